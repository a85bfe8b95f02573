"""The traction rig: a ball on a disc.

A step is a step of slip, rest is pure rolling, and mu = F/W is derived, then pressure and film.

Decides: how a traction log is curated; what `oilfilm init` takes for the source of the zero;
pressure, film and lambda of a point; the error of calibration that the points of a run share.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from oilfilm.curation.hypotheses import Hypothesis, setting_hypotheses, traction_hypotheses
from oilfilm.curation.measure import find_steps, measure, settled_parts
from oilfilm.curation.rig_kind import TRACTION as NAME
from oilfilm.curation.rig_kind import Channel, Division, RigKind, Run, Signals, nothing
from oilfilm.curation.zero import force_left, part_of_curve, phases_at_standstill, turns_steadily
from oilfilm.logs.base import Columns, Refusal
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.traction_log import TRACTION
from oilfilm.physics.contact import Contact, max_hertz_pressure
from oilfilm.physics.film import contact_film
from oilfilm.physics.oils import Oil
from oilfilm.settings.config import (
    FilmSettings,
    GateSettings,
    PlateauSettings,
    ZeroReferenceSettings,
)
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.ties import exceeds
from oilfilm.units import M_PER_UM, PA_PER_GPA, FloatArray

# No traction rig loads a contact less; below it F/W is noise over nothing.
LEAST_LOAD_N = 1e-6
# Column -> the column and the key of the rig file it comes from; relative but for temperature.
_RELATIVE = {
    "load_systematic_n": ("load_n", "load_relative"),
    "traction_force_systematic_n": ("traction_force_n", "traction_force_relative"),
    "entrainment_speed_systematic_m_s": ("entrainment_speed_m_s", "speed_relative"),
}
# Phases of pure rolling that a zero procedure needs.
_PHASES = {
    "rolling_phases": ("opening", "closing"),
    "opening_phase": ("opening",),
    "already_removed": (),
}
_LOGGED = (
    "load_n",
    "traction_force_1_n",
    "traction_force_2_n",
    "inlet_temperature_c",
    "measured_film_thickness_um",
)


class TractionRig(RigKind):
    """See `RigKind`."""

    name = NAME
    logs: LogKind = TRACTION
    table = "points"
    sensor = Channel("traction_force_n", "traction force", "N")
    channels = (
        Channel("load_n", "load", "N"),
        Channel("ball_speed_m_s", "ball speed", "m/s"),
        Channel("disc_speed_m_s", "disc speed", "m/s"),
        Channel("inlet_temperature_c", "inlet temperature", "degC"),
    )
    means = (
        "slide_roll_ratio",
        "traction_force_n",
        "load_n",
        "entrainment_speed_m_s",
        "inlet_temperature_c",
    )
    errors = ("slide_roll_ratio", "traction_force_n", "load_n")
    changes = (*errors, "inlet_temperature_c")
    transients = ("slide_roll_ratio", "traction_force_n")
    words: Mapping[str, str] = {"sensor": sensor.name, "level": "slip"}
    carried: tuple[str, ...] = (
        "oil",
        "rig",
        "nominal_max_hertz_pressure_gpa",
        "nominal_load_n",
        "nominal_entrainment_speed_m_s",
        "nominal_inlet_temperature_c",
    )
    keeps_refused_runs = True
    shown_signals: Mapping[str, str] = {
        "traction_force_n": "Traction\nforce (N)",
        "load_n": "Load (N)",
        "slide_roll_ratio": "Slide-roll\nratio S (1)",
        "inlet_temperature_c": "Inlet temp.\n(\N{DEGREE SIGN}C)",
    }

    gates: GateSettings
    plateaus: PlateauSettings
    zero: ZeroReferenceSettings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self.gates, self.plateaus = settings.gates, settings.curation.plateaus
        self.zero = settings.curation.zero_reference
        self.zero_drift_max = self.zero.max_drift_n

    @property
    def planned_slips(self) -> Sequence[float]:
        """The slips that are planned, where any are."""
        return self.settings.campaign.set_points.slide_roll_ratio or ()

    @staticmethod
    def signals(samples: Columns, rig: str, settings: Settings) -> Signals:
        """Force and slip positive with the slower body slowed; S is NaN where nothing turns."""
        log = settings.campaign.semantics_for(rig)
        ball, disc = samples["ball_speed_m_s"], samples["disc_speed_m_s"]
        speed = (ball + disc) / 2
        sliding = log.direction * (disc - ball)
        slip = np.divide(sliding, speed, out=nothing(len(speed)), where=speed != 0)
        columns = {
            **{name: samples[name] for name in _LOGGED if name in samples},
            "traction_force_n": log.traction_sign * log.direction * samples["traction_force_n"],
            "entrainment_speed_m_s": speed,
            "slide_roll_ratio": slip,
            "ball_speed_m_s": ball,
            "disc_speed_m_s": disc,
        }
        return Signals(samples["row"], samples["time_s"], columns)

    def divide(self, signals: Signals, rig: str) -> Division:
        """Levels of slip; the first and the last of them are pure rolling."""
        curation, levels = self.settings.curation, self.plateaus
        # where nothing turns S has no value
        turning = np.isfinite(signals["slide_roll_ratio"]) & turns_steadily(signals, curation)
        usable = signals.at(turning)
        interval_s = usable.interval_s
        steps = find_steps(usable["slide_roll_ratio"], interval_s, levels.min_step, levels)
        starts, stops = settled_parts(len(usable), steps, interval_s, levels)
        zero = self.settings.campaign.semantics_for(rig).zero
        if zero == "standstill":
            return Division(usable, starts, stops, signals, phases_at_standstill(signals, curation))
        # the opening phase gives the zero first; what is left of it is a plateau at no slip
        zero_rows = round(self.zero.duration_s / interval_s)
        rolling = {"opening": slice(0, 0), "closing": slice(0, 0)}
        if len(steps):
            rolling["opening"] = slice(0, min(zero_rows, int(stops[0])))
            rolling["closing"] = slice(int(starts[-1]), int(stops[-1]))
        phases = {name: rolling[name] for name in _PHASES[zero]}
        return Division(usable, starts, stops, usable, phases, "pure rolling", in_levels=True)

    def zero_fault(self, run: Run, parts: Division, rig: str) -> Refusal | None:
        """A phase that is part of the curve, or a force where it should be zero."""
        source = self.settings.campaign.semantics_for(rig).zero
        if source == "standstill":
            return run.flaw
        if source == "already_removed":
            return force_left(run, self.settings.curation, self.gates.significant_errors)
        share, errors = self.zero.max_traction_share, self.gates.significant_errors
        return run.flaw or part_of_curve(parts, run.plateaus, share, errors)

    def derive(self, averages: Columns, zero: FloatArray, zero_se: FloatArray) -> Columns:
        """Traction force above the zero, mu = F/W and its standard error."""
        unknown = nothing(len(zero))
        force_n = averages["traction_force_n"] - zero
        load = np.where(averages["load_n"] > LEAST_LOAD_N, averages["load_n"], np.nan)
        mu = force_n / load
        force_se_n = np.hypot(averages["traction_force_n_se"], zero_se)
        kept = ("first_row", "last_row", "n_samples", "n_spikes", "time_s", "duration_s")
        return {
            **{name: averages[name] for name in (*kept, *self.means)},
            "force_asymmetry": _asymmetry(averages),
            "measured_film_thickness_um": averages.get("measured_film_thickness_um", unknown),
            "slide_roll_ratio_se": averages["slide_roll_ratio_se"],
            "slip_change": averages["slide_roll_ratio_change"],
            "slip_transient": averages["slide_roll_ratio_transient"],
            "traction_force_n": force_n,
            "traction_coefficient": mu,
            "traction_coefficient_se": np.hypot(force_se_n, mu * averages["load_n_se"]) / load,
            "traction_change": averages["traction_force_n_change"] / load,
            "traction_transient": averages["traction_force_n_transient"] / load,
            "load_change": averages["load_n_change"] / load,
            "temperature_change_c": averages["inlet_temperature_c_change"],
        }

    def complete(self, points: pd.DataFrame) -> pd.DataFrame:
        """With contact pressure, film, lambda and the calibration of the rig's sensors."""
        return with_calibration(with_film(points, self.settings), self.settings.rigs)

    def hypotheses(self, rig: str) -> Iterator[Hypothesis]:
        """See `RigKind.hypotheses`."""
        yield from traction_hypotheses(self.settings.rigs[rig])
        yield from setting_hypotheses("curation", self.plateaus, "min_step")


def _asymmetry(averages: Columns) -> FloatArray:
    """|TF1 + TF2| over |TF1| + |TF2| of a rig that logs the force of either direction of slip."""
    unknown = nothing(len(averages["time_s"]))
    if "traction_force_1_n" not in averages:
        return unknown
    first, second = averages["traction_force_1_n"], averages["traction_force_2_n"]
    both = np.abs(first) + np.abs(second)
    return np.divide(np.abs(first + second), both, out=unknown, where=both > 0)


# Two phases show a drift, and the force at standstill may be held by static friction.
BEST_FIRST = ("rolling_phases", "opening_phase", "standstill")


def zero_source(
    time_s: FloatArray,
    ball_m_s: FloatArray,
    disc_m_s: FloatArray,
    load_n: FloatArray,
    force_n: FloatArray,
    settings_by_source: Mapping[str, Settings],
) -> str | None:
    """The first source from which a run gets a zero that its own curve does not contradict.

    Args:
        time_s: Time, shape (n,).
        ball_m_s: Surface speed of the ball, shape (n,).
        disc_m_s: That of the disc, shape (n,).
        load_n: Normal load, shape (n,); in any unit, because only ratios of mu matter.
        force_n: Traction force, shape (n,).
        settings_by_source: Settings with each source of `BEST_FIRST` as `semantics: zero`.

    Returns:
        A value of `semantics: zero`; None where none of them suits.
    """
    samples = {
        "row": np.arange(len(time_s)),
        "time_s": time_s,
        "load_n": load_n,
        "traction_force_n": force_n,
        "ball_speed_m_s": ball_m_s,
        "disc_speed_m_s": disc_m_s,
        "inlet_temperature_c": np.zeros(len(time_s)),
    }
    for source in BEST_FIRST:
        settings = settings_by_source[source]
        signals = TractionRig.signals(samples, "", settings)
        measured = measure(signals, TractionRig(settings), "")
        if measured.flaw is None or measured.flaw.rule != "zero_missing":
            return source
    return None


# ---------------------------------------------------------------- rig and oil


def with_film(points: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Points with maximum Hertz pressure, film thickness, lambda and the film's judgement.

    Pressure needs the rig's geometry and materials, or is the stated one; film needs the oil's
    properties, lambda the roughness as well. Where they are not known the columns are null and the
    film "cannot be judged".
    """
    points = points.assign(
        max_hertz_pressure_gpa=np.nan, film_thickness_um=np.nan, lambda_ratio=np.nan
    )
    for (rig, oil_name), of_both in points.groupby(["rig", "oil"]):
        contact, oil_file = settings.rigs[str(rig)].contact(), settings.oils[str(oil_name)]
        if contact is not None:
            oil = oil_file.properties() if oil_file else None
            derived = contact_state(of_both, contact, oil, settings.film)
            points.loc[of_both.index, list(derived)] = derived
        elif "nominal_max_hertz_pressure_gpa" in points:
            # without geometry only the pressure that the log or its sheet states is known
            stated = of_both["nominal_max_hertz_pressure_gpa"]
            points.loc[of_both.index, "max_hertz_pressure_gpa"] = stated
    known = points["lambda_ratio"].notna()
    full = exceeds(points["lambda_ratio"], settings.gates.lambda_limit)
    judgement = np.select([~known, full], ["cannot be judged", "full film"], "below limit")
    return points.assign(film_judgement=judgement)


def contact_state(
    points: pd.DataFrame, contact: Contact, oil: Oil | None, settings: FilmSettings
) -> pd.DataFrame:
    """Maximum Hertz pressure and, where the oil is known, film thickness and lambda.

    Args:
        points: Columns load_n, entrainment_speed_m_s, inlet_temperature_c and slide_roll_ratio.
        contact: The contact they are of.
        oil: The oil, None where its properties are not known.
        settings: `film` of the configuration.
    """
    load = points["load_n"].where(points["load_n"] > LEAST_LOAD_N).to_numpy()
    pressure_pa = max_hertz_pressure(load, contact.radius_m, contact.reduced_modulus_pa)
    derived = pd.DataFrame({"max_hertz_pressure_gpa": pressure_pa / PA_PER_GPA}, points.index)
    if oil is None:
        return derived
    thickness_m, lambda_ratio = contact_film(
        oil,
        contact,
        settings.thickness,
        load_n=load,
        entrainment_speed_m_s=points["entrainment_speed_m_s"].to_numpy(),
        inlet_temperature_c=points["inlet_temperature_c"].to_numpy(),
        slide_roll_ratio=points["slide_roll_ratio"].to_numpy(),
    )
    return derived.assign(film_thickness_um=thickness_m / M_PER_UM, lambda_ratio=lambda_ratio)


def with_calibration(points: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Points with the standard uncertainty of each sensor's calibration.

    All points of a rig share these errors, so they are kept apart from the random ones; null
    where the rig file states none.
    """
    rig = points["rig"].astype("category")

    def from_rig(key: str) -> "pd.Series[float]":
        values = {name: getattr(file.calibration, key, None) for name, file in rigs.items()}
        return rig.map(values).astype(float)

    return points.assign(
        **{
            column: points[quantity].abs() * from_rig(key)
            for column, (quantity, key) in _RELATIVE.items()
        },
        inlet_temperature_systematic_c=from_rig("temperature_c"),
    )
