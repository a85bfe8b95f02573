"""The keys of config/campaigns/<name>.yaml: what was measured, and what the logs mean.

Decides: the keys of a campaign file; the meaning of a rig's signals (sign, slip, zero).
"""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from oilfilm.base.units import FloatArray
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, OneOf, key, key_error_at, optional
from oilfilm.settings.config import Matrix


class Source(Group):
    """Other sources of the data."""

    title: q.Text = key("What it is.")
    address: q.WebAddress | None = optional("Address, where it has one.")


# First digits of the sha256 of a log. The message that refuses a changed log prints them.
LogDigestStart = Annotated[str, Field(pattern=r"^[0-9a-f]{12,64}$")]


class AcknowledgedChange(Group):
    """A raw log that was changed on purpose after a run had read it."""

    log: Annotated[str, Field(pattern=r"^data/raw/[^/]+/.")] = key("Its path from the top folder.")
    was: LogDigestStart = key("First digits of the sha256 that data/first_seen has of it.")
    now: LogDigestStart = key("First digits of its sha256 now.")
    reason: Annotated[str, Field(pattern=r"\S")] = key("Why it was changed.")


class Dataset(Group):
    """Description of the data, which changes no number."""

    title: q.Text | None = optional("Title of the dataset.")
    licence: (
        Annotated[str, Field(pattern=r"^(https?://[^\s<>\"{}|\\^`]+|[A-Za-z0-9._-]+)$")] | None
    ) = optional("Licence: an SPDX identifier (MIT, CC-BY-4.0) or an address.")
    date: str | None = optional(
        "When the data were measured, in quotes: '2026-06-02', 'June 2026'."
    )
    creators: q.OneOrMoreDistinct[q.Text] | None = optional(
        "Who made the data: persons or organisations."
    )
    sources: q.OneOrMore[Source] | None = optional("Other sources of the data.")
    acknowledged_changes: list[AcknowledgedChange] = key(
        "Raw logs changed on purpose after a run had read them; a run refuses others.", default=[]
    )


_SET_POINT_KEYS = [
    "max_hertz_pressure_gpa",
    "load_n",
    "entrainment_speed_m_s",
    "inlet_temperature_c",
]
_NAME_SCHEMA = {"type": "string", "minLength": 1}


def _as_list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


# One name, or a list of names.
Names = Annotated[
    q.OneOrMoreDistinct[q.Text],
    BeforeValidator(_as_list),
    WithJsonSchema(
        {"anyOf": [_NAME_SCHEMA, {"type": "array", "items": _NAME_SCHEMA, "minItems": 1}]}
    ),
]


class Column(Group):
    """A column of a log."""

    name: Names = key("Column's name as the log writes it, or a list of such names.")
    unit: q.Text | None = optional("Its unit, where the log does not say it.")


# Keys of headers and columns of the run sheet that a campaign may rename. Set points have the unit
# of their key.
_HEADER_KEY_NAMES = (
    *_SET_POINT_KEYS,
    "oil",
    "rig",
    "run",
    "log_kind",
    "file",
    "exclude",
    "remarks",
)
# Columns of logs that a campaign may rename.
_TRACTION_COLUMN_NAMES = (
    "time",
    "load",
    "traction_force",
    "traction_coefficient",
    "traction_force_1",
    "traction_force_2",
    "ball_speed",
    "disc_speed",
    "inlet_temperature",
    "entrainment_speed",
    "slide_roll_ratio",
    "max_hertz_pressure",
)
_TORQUE_COLUMN_NAMES = (
    "time",
    "axial_load",
    "inner_speed",
    "oil_temperature",
    "outer_ring_temperature",
    "torque",
)
HeaderKey = Annotated[str, OneOf(_HEADER_KEY_NAMES)]
TractionColumn = Annotated[str, OneOf(_TRACTION_COLUMN_NAMES)]
TorqueColumn = Annotated[str, OneOf(_TORQUE_COLUMN_NAMES)]


class Semantics(Group):
    """The meaning of a rig's signals."""

    traction_sign: Literal[1, -1] = key(
        "-1 where the sensor's output falls when the disc, being faster, drags the ball along.",
        default=1,
    )
    slower_body: Literal["ball", "disc"] = key("Body that is slowed at positive S.", default="ball")
    slide_roll_ratio: Literal["over_mean", "over_sum", "over_faster"] = key(
        "A logged slide-roll ratio is sliding speed over the mean, the sum or the faster of the "
        "surface speeds.",
        default="over_mean",
    )
    zero: Literal["rolling_phases", "opening_phase", "standstill", "already_removed"] = key(
        "Source of the zero of the traction force.", default="rolling_phases"
    )

    @property
    def sliding_sign(self) -> int:
        """Sign factor: sliding and force are positive where the slower body is slowed."""
        return 1 if self.slower_body == "ball" else -1

    def over_mean(self, logged_ratio: FloatArray) -> FloatArray:
        """The slide-roll ratio over the mean speed, from one logged by this definition."""
        if self.slide_roll_ratio == "over_sum":
            return 2 * logged_ratio
        if self.slide_roll_ratio == "over_faster":
            # f is the faster speed, g the other: s = (f - g)/f, and
            # (f - g)/((f + g)/2) = s/(1 - s/2), odd in the sign of s.
            # |s| of 2 and more is impossible; a gate refuses the infinite ratio
            with np.errstate(divide="ignore"):
                return np.asarray(logged_ratio / np.maximum(1 - np.abs(logged_ratio) / 2, 0.0))
        return logged_ratio


class FilmUnjudged(Group):
    """Where film thickness cannot be calculated."""

    accept: bool = key("Use points without a film thickness.")
    reason: q.Text = key("Reason, printed beside the results.")


class SetPoints(Group):
    """Nominal conditions of logs that carry none."""

    max_hertz_pressure_gpa: q.PressureGpa | None = optional("Maximum Hertz pressure.")
    load_n: q.LoadN | None = optional("Load.")
    entrainment_speed_m_s: q.SpeedMs | None = optional("Entrainment speed.")
    inlet_temperature_c: (
        Annotated[float, Field(gt=-100, le=250, json_schema_extra={"unit": "degC"})] | None
    ) = optional("Inlet temperature.")
    slide_roll_ratio: q.OneOrMore[q.SignedSlideRollRatio] | None = optional(
        "Planned S; points further from all of them than slip_tolerance are refused."
    )


PressureSpeedTemperature = Annotated[list[float], Field(min_length=3, max_length=3)]


class Defect(Group):
    """A defect that the rig twin plants."""

    oil: q.Name = key("Oil.")
    condition: PressureSpeedTemperature = key("Pressure in GPa, speed in m/s, temperature in degC.")
    kind: Literal[
        "truncated", "swapped_sign", "stuck_sensor", "wrong_units", "thin_film", "duplicate"
    ] = key("Kind of defect.")


class ThermalEhl(Group):
    """Constants of the thermal EHL traction that is a campaign's truth."""

    eyring_stress_pa: float = key(
        "Shear stress above which the film thins.", unit="Pa", ge=1e4, le=1e9
    )
    limiting_stress_ratio: float = key(
        "Limiting stress over pressure at its reference temperature.", unit="1", gt=0, le=1
    )
    limiting_stress_reference_c: float = key(
        "Reference temperature of the limiting stress.", unit="degC", ge=-100, le=250
    )
    limiting_stress_decay_1_k: float = key(
        "Relative fall of the limiting stress per kelvin.", unit="1/K", ge=0, le=1
    )
    solid_conductivity_w_mk: q.SolidConductivityWMK = key("Of ball and disc.")
    solid_volumetric_heat_j_m3k: q.SolidHeatJM3K = key("Density times specific heat of both.")


SamplingRateHz = Annotated[float, Field(gt=0, le=1e6, json_schema_extra={"unit": "Hz"})]


def _sample_count(twin: "Twin | TorqueTwin", duration_key: str) -> int:
    """Number of samples that a twin takes in a time of its settings, at least one."""
    duration_s = getattr(twin, duration_key)
    sample_count = round(duration_s * twin.sampling_rate_hz)
    if sample_count < 1:
        raise key_error_at(
            (duration_key,),
            f"found {duration_s:g} s, in which no sample is taken at {twin.sampling_rate_hz:g} Hz; "
            "expected one or more. Set a longer time, or a higher `sampling_rate_hz`.",
        )
    return sample_count


class Twin(Group):
    """How the rig twin simulates the campaign's logs."""

    thermal_ehl: ThermalEhl | None = optional("Truth; without it the printed constants are.")
    sampling_rate_hz: SamplingRateHz = key("Sampling rate.")
    baseline_s: q.DurationS = key("Pure rolling before and after the sweep.")
    step_s: q.DurationS = key("Time at each slip.")
    slip_steps: int = key("Slip steps.", ge=2)
    slip_max: q.SlideRollRatio = key("Largest S.")
    noise_of_full_scale: q.RelativeError = key("Noise of each sensor, one standard deviation.")
    response_s: q.DurationS = key("Time constant of the slip control.")
    zero_offset_n: q.ForceErrorN = key("Zero of the traction sensor, standard deviation over runs.")
    zero_drift_n: q.ForceErrorN = key("Its change over a run, standard deviation.")
    control_load: q.RelativeError = key("Error of the controlled load, per run.")
    control_speed: q.RelativeError = key("Error of the controlled speed, per run.")
    control_temperature_c: q.TemperatureErrorC = key("Error of the controlled temperature.")
    wander: q.RelativeError = key("Slow wandering of load and speed within a run.")
    systematic_load: q.RelativeError = key("Calibration error of the load, per run.")
    systematic_temperature_c: q.TemperatureErrorC = key("Calibration error of the temperature.")
    spikes: int = key("Wild readings of the force per run.", ge=0)
    spike_n: q.ForceErrorN = key("Their size.")
    defects: list[Defect] = key("Planted defects.")

    @model_validator(mode="after")
    def _has_samples(self) -> Self:
        row_count = 2 * _sample_count(self, "baseline_s")
        row_count += self.slip_steps * _sample_count(self, "step_s")
        if self.spikes > row_count:
            raise key_error_at(
                ("spikes",),
                f"found {self.spikes}, expected at most one for each of the {row_count} rows of a "
                "run. Set fewer spikes.",
            )
        return self


class TorqueCalibration(Group):
    """Standard uncertainties of the torque sensor's calibration."""

    torque_relative: q.RelativeError = key("Relative part.")
    torque_n_m: q.TorqueErrorNm = key("Absolute part.")


class TorqueMatrix(Group):
    """Operating points of the torque rig's twin."""

    axial_load_n: q.OneOrMoreDistinct[q.LoadN] = key("Axial loads.")
    inner_speed_rpm: q.OneOrMoreDistinct[q.SpeedRpm] = key("Speeds of the inner ring.")
    oil_temperature_c: q.OneOrMoreDistinct[q.TemperatureC] = key("Oil temperatures.")


class TorqueDefect(Group):
    """A defect that the torque rig's twin plants."""

    oil: q.Text = key("An oil of the campaign.")
    axial_load_n: q.LoadN = key("Axial load.")
    oil_temperature_c: q.TemperatureC = key("Oil temperature.")
    kind: Literal["tare_drift", "truncated", "warming"] = key("Kind of defect.")


class TorqueTwin(Group):
    """How the torque rig's twin simulates logs."""

    sampling_rate_hz: SamplingRateHz = key("Sampling rate.")
    rest_s: q.DurationS = key("Time at rest before and after.")
    step_s: q.DurationS = key("Time at each speed.")
    response_s: q.DurationS = key("Time constant of the spindle.")
    torque_noise_n_m: q.TorqueErrorNm = key("Noise of the torque, one standard deviation.")
    load_noise_n: q.ForceErrorN = key("Noise of the load, one standard deviation.")
    speed_noise_rpm: float = key("Noise of the speed, one standard deviation.", unit="rpm", ge=0)
    temperature_noise_c: q.TemperatureErrorC = key("Noise of the temperature.")
    tare_n_m: q.TorqueErrorNm = key("Tare, standard deviation over runs.")
    tare_drift_n_m: q.TorqueErrorNm = key("Its change over a run, standard deviation.")
    systematic_torque: q.RelativeError = key("Calibration error of the torque, per run.")
    control_load: q.RelativeError = key("Error of the controlled load, per run.")
    control_temperature_c: q.TemperatureErrorC = key("Error of the controlled temperature.")
    defects: list[TorqueDefect] = key("Planted defects.")

    @model_validator(mode="after")
    def _has_samples(self) -> Self:
        for duration_key in ("rest_s", "step_s"):
            _sample_count(self, duration_key)
        return self


class Torque(Group):
    """Torque logs, in data/raw/<campaign>-torque."""

    bearing: q.Name = key("Bearing: a file of config/bearings, without .yaml.")
    calibration: TorqueCalibration = key("Standard uncertainties of the torque sensor.")
    columns: dict[TorqueColumn, Column] = key("Columns with names of their own.", default={})
    matrix: TorqueMatrix | None = optional("Operating points of the twin.")
    twin: TorqueTwin | None = optional("How the torque rig's twin simulates logs.")


class CampaignKeys(Group):
    """Keys of a campaign that change its results."""

    data: Literal["measured", "simulated"] = key("Whether the logs were measured or simulated.")
    simulated_by: q.Text | None = optional("What simulated the logs; not with `twin`.")
    description: q.Text = key("One line on what was measured.")
    credit: q.Text | None = optional("Whose data they are; printed wherever they are shown.")
    rigs: q.OneOrMoreDistinct[q.Name] = key(
        "Files of config/rigs; the first is for logs that name none."
    )
    oils: q.AnyNumberDistinct[q.Name] = key("Files of config/oils, without .yaml, each in quotes.")
    oils_without_properties: q.AnyNumberDistinct[q.Name] = key(
        "Oils of unknown properties.", default=[]
    )
    oil_aliases: dict[str, Names] = key("By oil: names beside its `aliases`.", default={})
    figures: q.AnyNumberDistinct[q.Name] = key("Figures to draw.")
    studies: q.AnyNumberDistinct[q.Name] = key(
        "Packages beside oilfilm to add (`deng2026_study`).", default=[]
    )
    min_accepted_runs: int = key(
        "Accepted runs that the campaign and each oil with logs need (torque logs are counted "
        "apart); with fewer `make` fails.",
        ge=0,
        default=1,
    )
    min_accepted_share: q.Share = key(
        "Share of runs that must be accepted; unreadable logs count as runs.", default=0.0
    )
    matrix: Matrix | None = optional("Planned conditions: all combinations of levels.")
    columns: dict[TractionColumn, Column] = key("Columns with names of their own.", default={})
    header: dict[HeaderKey, Names] = key("Own names of header keys, sheet columns.", default={})
    semantics: Semantics = key("How the rigs' logs are meant.", default=Semantics())
    semantics_of_rig: dict[str, Semantics] = key("By rig, other than `semantics`.", default={})
    repeated_conditions: Literal["accept", "refuse"] = key(
        "What to do with a second run of a condition.", default="refuse"
    )
    film_unjudged: FilmUnjudged | None = optional("Where film thickness cannot be calculated.")
    set_points: SetPoints = key("Nominal conditions of logs that carry none.", default=SetPoints())
    twin: Twin | None = optional("How the rig twin simulates the campaign's logs.")
    torque: Torque | None = optional("Torque logs, in data/raw/<campaign>-torque.")

    @property
    def simulator(self) -> str:
        """What simulated the logs; empty where that is not stated."""
        return "rig twin" if self.twin is not None else self.simulated_by or ""

    @property
    def truth_is_law(self) -> bool:
        """Whether the logs were simulated with the paper's law (Eq. 7) and its printed constants.

        A fit of this law, or of a law that contains it, returns these constants then.
        """
        return self.twin is not None and self.twin.thermal_ehl is None

    def semantics_for(self, rig_name: str) -> Semantics:
        """How the logs of one rig are meant: `semantics`, with what differs for it."""
        semantics_of_rig = self.semantics_of_rig.get(rig_name)
        if semantics_of_rig is None:
            return self.semantics
        return self.semantics.model_copy(update=semantics_of_rig.model_dump(exclude_unset=True))


class CampaignFile(CampaignKeys, Dataset):
    """The keys of config/campaigns/<name>.yaml."""

    settings: dict[str, Any] = key("Keys of config/config.yaml for this campaign.", default={})


class Campaign(CampaignKeys):
    """A campaign in the settings: the keys of its file, and its name."""

    name: q.Name = key("The campaign file's name, without .yaml.")
