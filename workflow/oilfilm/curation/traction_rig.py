"""The traction rig: a ball on a disc.

A step is a step of slip, rest is pure rolling, and mu = F/W is derived, then pressure and film.

Decides: how a traction log is curated; what `oilfilm init` takes for the source of the zero;
the signs of slip and force, by `semantics` of the campaign file; pressure, film and lambda of a
point; the error of calibration that the points of a run share.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm.base.ties import exceeds
from oilfilm.base.units import M_PER_UM, PA_PER_GPA, BoolArray, FloatArray
from oilfilm.curation.gate import refusal_by
from oilfilm.curation.hypotheses import (
    LONGEST_HOLD_S,
    Hypothesis,
    setting_hypotheses,
    traction_hypotheses,
)
from oilfilm.curation.measure import average_plateaus, find_steps, measure_run, settled_parts
from oilfilm.curation.ramps import (
    FEWEST_RAMP_POINTS,
    LARGEST_SHARE_OF_LAG_RANGE,
    RampPoints,
    is_ramp,
    ramp_points,
    ramp_zero,
    replace_spikes,
    rolling_ends,
)
from oilfilm.curation.rig_kind import (
    TRACTION_KIND,
    Channel,
    Division,
    MeasuredRun,
    RigKind,
    Signals,
    unknown_values,
)
from oilfilm.curation.statistics import median
from oilfilm.curation.zero import (
    DIRECTION_COLUMN,
    force_in_rolling_refusal,
    is_turning_steadily,
    phase_of_curve_refusal,
    phases_at_standstill,
    raw_signal_refusal,
    remaining_force_refusal,
    zero_of_readings_refusal,
    zero_reference,
)
from oilfilm.logs.base import ColumnArrays, Refusal
from oilfilm.logs.log_schema import LogSchema
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

# No traction rig has a smaller load; below it F/W has no meaning.
LEAST_LOAD_N = 1e-6
# Column -> the column that it is a share of, and the key of the rig file that has the share.
_RELATIVE_CALIBRATION = {
    "load_systematic_n": ("load_n", "load_relative"),
    "traction_force_systematic_n": ("traction_force_n", "traction_force_relative"),
    "entrainment_speed_systematic_m_s": ("entrainment_speed_m_s", "speed_relative"),
}
# Name of a source of the zero -> the phases of pure rolling that it needs.
_ROLLING_PHASES_OF_ZERO_SOURCE = {
    "rolling_phases": ("opening", "closing"),
    "opening_phase": ("opening",),
    "already_removed": (),
}
_UNCHANGED_SIGNALS = (
    "load_n",
    "traction_force_1_n",
    "traction_force_2_n",
    "inlet_temperature_c",
    "measured_film_thickness_um",
)


class TractionRig(RigKind):
    """See `RigKind`.

    What is wrong with a run is a `Refusal`, kept in `MeasuredRun.refusal`. `refusal_by` makes one.
    """

    # name of the kind of rig; TRACTION below is the kind of its logs
    name = TRACTION_KIND
    log_schema: LogSchema = TRACTION
    table_name = "points"
    # apart from `channels`: only its zero is removed, and its spikes are left out
    sensor = Channel("traction_force_n", "traction force", "N")
    channels = (
        Channel("load_n", "load", "N"),
        Channel("ball_speed_m_s", "ball speed", "m/s"),
        Channel("disc_speed_m_s", "disc speed", "m/s"),
        Channel("inlet_temperature_c", "inlet temperature", "degC"),
    )
    mean_columns = (
        "slide_roll_ratio",
        "traction_force_n",
        "load_n",
        "entrainment_speed_m_s",
        "inlet_temperature_c",
    )
    columns_with_error = ("slide_roll_ratio", "traction_force_n", "load_n")
    # second half of a plateau against its first half
    columns_with_change = (*columns_with_error, "inlet_temperature_c")
    # beginning of a plateau against all that follows
    columns_with_transient = ("slide_roll_ratio", "traction_force_n")
    terms: Mapping[str, str] = {"sensor": sensor.name, "level": "slip"}
    run_columns: tuple[str, ...] = (
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

    gate_limits: GateSettings
    plateau_settings: PlateauSettings
    zero_settings: ZeroReferenceSettings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self.gate_limits = settings.gates
        self.plateau_settings = settings.curation.plateaus
        self.zero_settings = settings.curation.zero_reference
        # in the unit of the sensor, N
        self.zero_drift_max = self.zero_settings.max_drift_n

    @property
    def planned_slips(self) -> Sequence[float]:
        """Sizes of the planned slips; empty where none are planned."""
        # points of both directions of slip have positive slips
        return [abs(slip) for slip in self.settings.campaign.set_points.slide_roll_ratio or ()]

    @staticmethod
    def make_signals(samples: ColumnArrays, rig_name: str, settings: Settings) -> Signals:
        """Signals with force and slip positive where `semantics: slower_body` is the slower body.

        The slide-roll ratio is NaN where nothing turns.
        """
        # `semantics.sliding_sign` is for the whole rig; DIRECTION_COLUMN has one sign per plateau
        semantics = settings.campaign.semantics_for(rig_name)
        ball_m_s = samples["ball_speed_m_s"]
        disc_m_s = samples["disc_speed_m_s"]
        entrainment_m_s = (ball_m_s + disc_m_s) / 2
        sliding_m_s = semantics.sliding_sign * (disc_m_s - ball_m_s)
        slip = unknown_values(len(entrainment_m_s))
        np.divide(sliding_m_s, entrainment_m_s, out=slip, where=entrainment_m_s != 0)
        force_sign = semantics.traction_sign * semantics.sliding_sign
        columns = {name: samples[name] for name in _UNCHANGED_SIGNALS if name in samples}
        columns["traction_force_n"] = force_sign * samples["traction_force_n"]
        columns["entrainment_speed_m_s"] = entrainment_m_s
        columns["slide_roll_ratio"] = slip
        columns["ball_speed_m_s"] = ball_m_s
        columns["disc_speed_m_s"] = disc_m_s
        return Signals(samples["row"], samples["time_s"], columns)

    def divide_run(self, signals: Signals, rig_name: str) -> Division:
        """Levels of slip; the first and the last of them are pure rolling."""
        curation_settings = self.settings.curation
        # where nothing turns S has no value
        is_turning = np.isfinite(signals["slide_roll_ratio"]) & is_turning_steadily(
            signals, curation_settings
        )
        usable_signals = signals.select(is_turning)
        interval_s = usable_signals.interval_s
        step_indices = find_steps(
            usable_signals["slide_roll_ratio"],
            interval_s,
            self.plateau_settings.min_step,
            self.plateau_settings,
        )
        starts, stops = settled_parts(
            len(usable_signals), step_indices, interval_s, self.plateau_settings
        )
        zero_source_name = self.settings.campaign.semantics_for(rig_name).zero
        if zero_source_name == "standstill":
            phases = phases_at_standstill(signals, curation_settings)
            return Division(usable_signals, starts, stops, phase_signals=signals, phases=phases)
        rolling_phases = {"opening": slice(0, 0), "closing": slice(0, 0)}
        if len(step_indices):
            # the beginning of the opening phase gives the zero; what follows is a plateau without
            # slip
            zero_row_count = round(self.zero_settings.duration_s / interval_s)
            # a slow log takes more time: the mean of fewer readings has no standard error. No rig
            # rolls for longer than this: the log is not slow then, but its unit of time is wrong
            if exceeds(LONGEST_HOLD_S, stops[0] * interval_s):
                zero_row_count = max(zero_row_count, self.gate_limits.readings_min)
            rolling_phases["opening"] = slice(0, min(zero_row_count, int(stops[0])))
            rolling_phases["closing"] = slice(int(starts[-1]), int(stops[-1]))
        return Division(
            usable_signals,
            starts,
            stops,
            phase_signals=usable_signals,
            phases={
                name: rolling_phases[name]
                for name in _ROLLING_PHASES_OF_ZERO_SOURCE[zero_source_name]
            },
            rest_in_words="pure rolling",
            # the slices of `phases` are parts of levels of slip
            are_phases_in_levels=True,
        )

    def measured_ramp(
        self, run: MeasuredRun, division: Division, rig_name: str
    ) -> MeasuredRun | None:
        """See `RigKind.measured_ramp`."""
        if not is_ramp(
            run, self.plateau_settings, self.zero_settings.max_slide_roll_ratio, self._is_held(run)
        ):
            return None
        spike_threshold = self.settings.curation.spikes.threshold
        load_n, _ = replace_spikes(division.signals["load_n"], spike_threshold)
        if not (load_n > LEAST_LOAD_N).all():
            return None
        signals = replace(division.signals, columns={**division.signals.columns, "load_n": load_n})
        zero_source_name = self.settings.campaign.semantics_for(rig_name).zero
        if zero_source_name == "standstill" and run.refusal is not None:
            return run
        zero = ramp_zero(
            signals, zero_source_name, self.plateau_settings.window_s, self.zero_settings
        )
        if zero.refusal is not None:
            slip = signals["slide_roll_ratio"]
            fields = dict(least=slip.min(), most=slip.max(), reason=zero.refusal.reason)
            return replace(run, refusal=refusal_by("zero_missing", "ramp_without_zero", **fields))
        removed_n, removed_se_n = self._zero_at_standstill(division, zero_source_name)
        sensor = self.sensor.column
        points_on_ramp = ramp_points(
            replace(signals, columns={**signals.columns, sensor: signals[sensor] - removed_n}),
            self._force_lag_range_s(rig_name),
            # terms that are fitted: 0 where no zero is left, 1 for a constant, 2 with a drift
            zero.term_count,
            self.zero_settings.max_slide_roll_ratio,
            spike_threshold,
        )
        if points_on_ramp is None:
            return replace(
                run, refusal=refusal_by("slip_ramps", "ramp_too_fast", fewest=FEWEST_RAMP_POINTS)
            )
        averages = average_plateaus(signals, points_on_ramp.starts, points_on_ramp.stops, self)
        averages |= _columns_at_slips(averages, points_on_ramp)
        no_zero = np.zeros(len(points_on_ramp.slip))
        measured_run = replace(
            run,
            plateaus=self.derive_plateaus(averages, no_zero, removed_se_n[points_on_ramp.starts]),
            refusal=self._ramp_refusal(points_on_ramp),
            short_level_refusals=(),
            # names of phases, or in words that both directions of slip give the zero
            zero_phases=zero.shown_by or tuple(division.phases),
            force_lag=points_on_ramp.lag,
        )
        if zero_source_name == "already_removed" and measured_run.refusal is None:
            rolling_phases = rolling_ends(
                signals, self.plateau_settings.window_s, self.zero_settings
            )
            significant_errors = self.gate_limits.significant_errors
            curation_settings = self.settings.curation
            refusal = force_in_rolling_refusal(
                signals, rolling_phases, curation_settings, significant_errors
            )
            return replace(
                measured_run,
                refusal=refusal
                or remaining_force_refusal(measured_run, curation_settings, significant_errors),
            )
        return measured_run

    def _zero_at_standstill(
        self, division: Division, zero_source_name: str
    ) -> tuple[FloatArray, FloatArray]:
        """Zero at standstill and its standard error at each sample; 0 where another source counts.

        Args:
            division: The phases of the run.
            zero_source_name: `semantics: zero` of the campaign.
        """
        time_s = division.signals.time_s
        if zero_source_name != "standstill":
            return np.zeros(len(time_s)), np.zeros(len(time_s))
        spike_threshold = self.settings.curation.spikes.threshold
        zero = zero_reference(
            division.phase_signals, self.sensor.column, division.phases, spike_threshold
        )
        return zero.zero_at(time_s), zero.standard_error_at(time_s)

    def _force_lag_range_s(self, rig_name: str) -> Sequence[float]:
        """Smallest and largest lag of the force: as the rig's file states it, else the usual."""
        rig = self.settings.rigs.get(rig_name)
        if rig is not None and rig.force_lag_s_range is not None:
            return rig.force_lag_s_range
        return self.settings.curation.ramps.force_lag_s_range

    def _is_held(self, run: MeasuredRun) -> BoolArray:
        """Mask of the plateaus whose slip does not change, shape (plateaus,)."""
        is_changing = np.abs(run.plateaus["slip_change"]) > self.gate_limits.slip_change_max
        has_transient = np.abs(run.plateaus["slip_transient"]) > self.gate_limits.slip_transient_max
        return np.asarray(~(is_changing | has_transient))

    def _ramp_refusal(self, points_on_ramp: RampPoints) -> Refusal | None:
        """The refusal of a ramp: its zero moves, its lag is too long, or its mu is not certain."""
        lag = points_on_ramp.lag
        shortest_s, longest_s = lag.tried_range_s
        # a lag that is below the range by less than this may be there by chance
        margin_s = self.gate_limits.significant_errors * lag.lag_se_s
        # a lag above the range is not found: one near its end may be longer
        may_be_longer = lag.lag_s + lag.lag_se_s > LARGEST_SHARE_OF_LAG_RANGE * longest_s
        is_shorter = lag.lag_s + margin_s < shortest_s
        if lag.is_seen and (may_be_longer or is_shorter):
            limits = dict(least=shortest_s, most=longest_s)
            return refusal_by("slip_ramps", "lag_out_of_range", lag=lag.lag_s, **limits)
        if abs(points_on_ramp.drift_n) > self.zero_settings.max_drift_n:
            fields = dict(drift=points_on_ramp.drift_n, allowed=self.zero_settings.max_drift_n)
            return refusal_by("zero_drift", sensor=self.sensor, **fields)
        # the relative error has no meaning where mu is near 0
        is_judged = np.abs(points_on_ramp.slip) > self.gate_limits.sign_slip_min
        # a ramp of small slips is judged by all its points
        is_judged |= not is_judged.any()
        median_error = median(np.abs(points_on_ramp.mu_se / points_on_ramp.mu)[is_judged])
        largest_error = self.settings.curation.ramps.largest_error
        if median_error > largest_error:
            explanation = (
                "" if lag.is_seen else ". Nothing shows the lag of the force behind the slip"
            )
            return refusal_by(
                "slip_ramps",
                "lag_matters",
                error=median_error,
                allowed=largest_error,
                explanation=explanation,
            )
        return None

    def zero_refusal(self, run: MeasuredRun, division: Division, rig_name: str) -> Refusal | None:
        """The refusal by a phase that is part of the curve, or by a force that should be zero."""
        zero_source_name = self.settings.campaign.semantics_for(rig_name).zero
        if zero_source_name == "standstill":
            return run.refusal
        if zero_source_name == "already_removed":
            return remaining_force_refusal(
                run, self.settings.curation, self.gate_limits.significant_errors
            )
        return run.refusal or phase_of_curve_refusal(
            division,
            run.plateaus,
            self.zero_settings.max_traction_share,
            self.gate_limits.significant_errors,
        )

    def settled_readings_refusal(self, run: MeasuredRun) -> Refusal | None:
        """The refusal of rows that are no settled readings, or whose zero was not removed."""
        return raw_signal_refusal(run.signals, self.plateau_settings) or zero_of_readings_refusal(
            run, self.zero_settings
        )

    def derive_plateaus(
        self, averages: ColumnArrays, zero_of_plateau: FloatArray, zero_of_plateau_se: FloatArray
    ) -> ColumnArrays:
        """Traction force above the zero, mu = F/W and its standard error."""
        slip = averages["slide_roll_ratio"]
        # the sign of each plateau; `make_signals` has applied the sign of the rig
        direction = np.ones(len(slip))
        # beyond pure rolling with an error of slip
        has_negative_slip = slip < self.gate_limits.slide_roll_ratio_min
        # mu changes its sign with the slip, so that both directions give points of one curve. A few
        # negative slips may be mishaps
        if has_negative_slip.sum() >= self.gate_limits.faulty_plateaus_min:
            direction[has_negative_slip] = -1.0
        force_n = direction * (averages["traction_force_n"] - zero_of_plateau)
        load_n = np.where(averages["load_n"] > LEAST_LOAD_N, averages["load_n"], np.nan)
        mu = force_n / load_n
        force_se_n = np.hypot(averages["traction_force_n_se"], zero_of_plateau_se)
        mu_se = np.hypot(force_se_n, mu * averages["load_n_se"]) / load_n
        film_um = averages.get("measured_film_thickness_um", unknown_values(len(zero_of_plateau)))
        unchanged_columns = (
            "first_row",
            "last_row",
            "n_samples",
            "n_spikes",
            "time_s",
            "duration_s",
        )
        return {
            **{name: averages[name] for name in (*unchanged_columns, *self.mean_columns)},
            DIRECTION_COLUMN: direction,
            "slide_roll_ratio": direction * slip,
            "force_asymmetry": _asymmetry(averages),
            "measured_film_thickness_um": film_um,
            "slide_roll_ratio_se": averages["slide_roll_ratio_se"],
            "slip_change": direction * averages["slide_roll_ratio_change"],
            "slip_transient": direction * averages["slide_roll_ratio_transient"],
            "traction_force_n": force_n,
            "traction_coefficient": mu,
            "traction_coefficient_se": mu_se,
            "traction_change": direction * averages["traction_force_n_change"] / load_n,
            "traction_transient": direction * averages["traction_force_n_transient"] / load_n,
            "load_change": averages["load_n_change"] / load_n,
            "temperature_change_c": averages["inlet_temperature_c_change"],
        }

    def with_rig_and_oil_columns(self, points: pd.DataFrame) -> pd.DataFrame:
        """With contact pressure, film, lambda and the calibration of the rig's sensors."""
        return with_calibration(with_film(points, self.settings), self.settings.rigs)

    def hypotheses(self, rig_name: str) -> Iterator[Hypothesis]:
        """See `RigKind.hypotheses`."""
        sliding_sign = self.settings.campaign.semantics_for(rig_name).sliding_sign
        yield from traction_hypotheses(self.settings.rigs[rig_name], sliding_sign)
        yield from setting_hypotheses("curation", self.plateau_settings, "min_step")


def _columns_at_slips(averages: ColumnArrays, points_on_ramp: RampPoints) -> ColumnArrays:
    """The columns of plateaus that are others on a ramp, where no slip is held.

    How steady the slip is has no meaning, so these columns are NaN.
    """
    unknown = unknown_values(len(points_on_ramp.slip))
    return {
        "duration_s": unknown,
        "n_spikes": points_on_ramp.spike_counts,
        "n_samples": points_on_ramp.stops - points_on_ramp.starts - points_on_ramp.spike_counts,
        "slide_roll_ratio_change": unknown,
        "slide_roll_ratio_transient": unknown,
        "traction_force_n_change": unknown,
        "traction_force_n_transient": unknown,
        "slide_roll_ratio": points_on_ramp.slip,
        # a point is at its slip by definition
        "slide_roll_ratio_se": np.zeros(len(points_on_ramp.slip)),
        "traction_force_n": points_on_ramp.mu * averages["load_n"],
        "traction_force_n_se": points_on_ramp.mu_se * averages["load_n"],
    }


def _asymmetry(averages: ColumnArrays) -> FloatArray:
    """|TF1 + TF2| over |TF1| + |TF2|, the forces of both directions of slip, shape (plateaus,).

    NaN where the rig does not log these forces, or both are zero.
    """
    asymmetry = unknown_values(len(averages["time_s"]))
    if "traction_force_1_n" in averages:
        force_disc_faster_n = averages["traction_force_1_n"]
        force_ball_faster_n = averages["traction_force_2_n"]
        sum_of_sizes_n = np.abs(force_disc_faster_n) + np.abs(force_ball_faster_n)
        np.divide(
            np.abs(force_disc_faster_n + force_ball_faster_n),
            sum_of_sizes_n,
            out=asymmetry,
            where=sum_of_sizes_n > 0,
        )
    return asymmetry


# Names of sources of the zero. Two rolling phases are best: they show a drift. Standstill is last:
# static friction may hold the force.
ZERO_SOURCES_BEST_FIRST = ("rolling_phases", "opening_phase", "standstill")


def find_zero_source(
    time_s: FloatArray,
    ball_m_s: FloatArray,
    disc_m_s: FloatArray,
    load_n: FloatArray,
    force_n: FloatArray,
    settings_by_source: Mapping[str, Settings],
) -> str | None:
    """The best source of the zero that the curve of a run does not contradict.

    Args:
        time_s: Time, shape (n,).
        ball_m_s: Surface speed of the ball, shape (n,).
        disc_m_s: Surface speed of the disc, shape (n,).
        load_n: Normal load, shape (n,), in any unit: only ratios of mu matter.
        force_n: Traction force, shape (n,).
        settings_by_source: Source in `ZERO_SOURCES_BEST_FIRST` -> settings with it as
            `semantics: zero`.

    Returns:
        A value of `semantics: zero`; None where no source is suitable.
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
    for source in ZERO_SOURCES_BEST_FIRST:
        settings = settings_by_source[source]
        signals = TractionRig.make_signals(samples, "", settings)
        measured_run = measure_run(signals, TractionRig(settings), "")
        if measured_run.refusal is None or measured_run.refusal.rule != "zero_missing":
            return source
    return None


# ---------------------------------------------------------------- rig and oil


def with_film(points: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Points with maximum Hertz pressure, film thickness, lambda and the film's judgement.

    The pressure needs the rig's geometry and materials; without them it is the stated one. The film
    needs the oil's properties, and lambda the roughness as well. Where they are not known the
    columns are null and the film "cannot be judged".
    """
    points = points.assign(
        max_hertz_pressure_gpa=np.nan, film_thickness_um=np.nan, lambda_ratio=np.nan
    )
    for (rig_name, oil_name), points_of_rig_and_oil in points.groupby(["rig", "oil"]):
        contact = settings.rigs[str(rig_name)].contact()
        oil_file = settings.oils[str(oil_name)]
        if contact is not None:
            oil = oil_file.properties() if oil_file else None
            columns = contact_state(points_of_rig_and_oil, contact, oil, settings.film)
            points.loc[points_of_rig_and_oil.index, list(columns)] = columns
        elif "nominal_max_hertz_pressure_gpa" in points:
            # without geometry only the pressure that the log or its sheet states is known
            stated_gpa = points_of_rig_and_oil["nominal_max_hertz_pressure_gpa"]
            points.loc[points_of_rig_and_oil.index, "max_hertz_pressure_gpa"] = stated_gpa
    is_unjudged = points["lambda_ratio"].isna()
    is_full_film = exceeds(points["lambda_ratio"], settings.gates.lambda_limit)
    judgement = np.select(
        [is_unjudged, is_full_film], ["cannot be judged", "full film"], default="below limit"
    )
    return points.assign(film_judgement=judgement)


def contact_state(
    points: pd.DataFrame, contact: Contact, oil: Oil | None, film_settings: FilmSettings
) -> pd.DataFrame:
    """Maximum Hertz pressure and, where the oil is known, film thickness and lambda.

    Args:
        points: Columns load_n, entrainment_speed_m_s, inlet_temperature_c and slide_roll_ratio.
        contact: The contact of the rig.
        oil: The oil; None where its properties are not known.
        film_settings: `film` of the configuration.
    """
    load_n = points["load_n"].where(points["load_n"] > LEAST_LOAD_N).to_numpy()
    pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
    state = pd.DataFrame({"max_hertz_pressure_gpa": pressure_pa / PA_PER_GPA}, points.index)
    if oil is None:
        return state
    thickness_m, lambda_ratio = contact_film(
        oil,
        contact,
        film_settings.thickness,
        load_n=load_n,
        entrainment_speed_m_s=points["entrainment_speed_m_s"].to_numpy(),
        inlet_temperature_c=points["inlet_temperature_c"].to_numpy(),
        slide_roll_ratio=points["slide_roll_ratio"].to_numpy(),
    )
    return state.assign(film_thickness_um=thickness_m / M_PER_UM, lambda_ratio=lambda_ratio)


def with_calibration(points: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Points with the standard uncertainty of each sensor's calibration.

    All points of a rig share these errors, so they are kept apart from the random ones. They are
    null where the rig file states none.
    """
    rig_of_point = points["rig"].astype("category")

    def from_rig_files(key: str) -> "pd.Series[float]":
        uncertainty_of_rig = {
            name: getattr(rig.calibration, key, None) for name, rig in rigs.items()
        }
        return rig_of_point.map(uncertainty_of_rig).astype(float)

    uncertainties: dict[str, pd.Series[float]] = {}
    for column, (measured_column, key) in _RELATIVE_CALIBRATION.items():
        uncertainties[column] = points[measured_column].abs() * from_rig_files(key)
    uncertainties["inlet_temperature_systematic_c"] = from_rig_files("temperature_c")
    return points.assign(**uncertainties)
