"""The zero of a sensor: its output at rest before and after a run, and contradictions to it.

A traction rig is at rest under pure rolling or at standstill, a torque rig at standstill. A rig may
give both phases, only the opening one, or a signal whose zero it has removed itself.

Decides: how the zero of the force or torque sensor is removed; where a rig stands still; whether a
phase is pure rolling; when a force contradicts the zero of a traction rig.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.curation.gate import refusal_by
from oilfilm.curation.rig_kind import Channel, Division, MeasuredRun, Signals
from oilfilm.curation.statistics import Stretches, mean_with_error, median
from oilfilm.logs.base import ColumnArrays, Refusal
from oilfilm.settings.config import (
    CurationSettings,
    PlateauSettings,
    SignalGateSettings,
    ZeroReferenceSettings,
)

# Column of plateaus: -1 where slip and force were negative and `derive_plateaus` has reversed both;
# else 1.
DIRECTION_COLUMN = "direction"
# The constants below say how speed and slope of a run are estimated. The limits that judge them are
# in the configuration.
# So many rows, whose slips differ by less than half a step, are a signal and no settled readings.
_FEWEST_ROWS_OF_SIGNAL = 100
# Quantile of the speeds that is taken for the speed of a run, so that wild readings do not count.
_FASTEST_QUANTILE = 0.9
# Largest ratio of slips that belong to one level, on the way up and down.
_SAME_LEVEL_RATIO = 1.1
# Largest slope at the beginning of a curve, relative to that up to its first level.
_STEEPEST_RATIO = 10


@dataclass(frozen=True)
class ZeroReference:
    """Sensor output at rest in two phases, one or none, in the unit of the sensor.

    Attributes:
        time_s: Mean time of each phase, shape (phases,).
        output: Mean output in each phase, shape (phases,).
        output_se: Its standard error, shape (phases,).
    """

    time_s: FloatArray
    output: FloatArray
    output_se: FloatArray

    @property
    def drift(self) -> float:
        """Change of the zero from the first to the last phase."""
        return float(self.output[-1] - self.output[0]) if len(self.output) else 0.0

    def zero_at(self, time_s: FloatArray) -> FloatArray:
        """The zero at some times: a straight line through two phases (the drift), else constant."""
        return self._weights(time_s) @ self.output

    def standard_error_at(self, time_s: FloatArray) -> FloatArray:
        """Standard error of the zero at some times, from those of the phases."""
        return np.sqrt(self._weights(time_s) ** 2 @ self.output_se**2)

    def _weights(self, time_s: FloatArray) -> FloatArray:
        """Share of each phase in the zero at each time, shape (times, phases)."""
        phase_count = len(self.time_s)
        if phase_count < 2 or self.time_s[0] == self.time_s[1]:
            return np.full((len(time_s), phase_count), 1 / max(phase_count, 1))
        share = (time_s - self.time_s[0]) / (self.time_s[1] - self.time_s[0])
        return np.stack([1 - share, share], axis=1)


def short_phase_refusal(
    signals: Signals, phase: slice, phase_in_words: str, min_duration_s: float
) -> Refusal | None:
    """The refusal by a phase at rest that is missing or too short; None where it can be used.

    Args:
        signals: The run.
        phase: The samples of the phase.
        phase_in_words: The phase in words, as in `opening phase of standstill`.
        min_duration_s: Shortest phase that can be used.
    """
    row_count = phase.stop - phase.start
    if row_count <= 0:
        return refusal_by("zero_missing", "no_phase", name=phase_in_words)
    duration_s = row_count * signals.interval_s
    # a single row gives no standard error
    if reaches(duration_s, min_duration_s) and row_count > 1:
        return None
    return refusal_by(
        "zero_missing",
        "short_phase",
        name=phase_in_words,
        rows=row_count,
        duration=duration_s,
        least=min_duration_s,
    )


def zero_reference(
    signals: Signals, sensor_column: str, phases: Mapping[str, slice], spike_threshold: float
) -> ZeroReference:
    """The zero from the phases at rest.

    Args:
        signals: The run.
        sensor_column: Column of the sensor.
        phases: Name of a phase -> its samples. Empty where the rig has removed the zero itself.
        spike_threshold: Threshold of the spike test, in robust standard deviations.
    """
    stretches = Stretches(
        starts=np.array([phase.start for phase in phases.values()], dtype=np.int64),
        stops=np.array([phase.stop for phase in phases.values()], dtype=np.int64),
    )
    phase_outputs = stretches.cut(signals[sensor_column])
    is_used = ~stretches.spikes(phase_outputs, spike_threshold)
    output = stretches.means(phase_outputs, is_used)
    return ZeroReference(
        time_s=stretches.means(stretches.cut(signals.time_s), is_used),
        output=output,
        output_se=stretches.standard_errors(phase_outputs, is_used, output),
    )


def moved_zero_refusal(
    zero: ZeroReference,
    division: Division,
    sensor: Channel,
    largest_drift: float,
    gate_limits: SignalGateSettings,
) -> Refusal | None:
    """The refusal of a zero that moves during the run, by the most likely cause; else None.

    The causes are:

    - a sensor that still settles in the last phase
    - noise that is as large as the difference
    - otherwise a drift

    Args:
        zero: The zero at both phases.
        division: The phases.
        sensor: The signal whose zero it is.
        largest_drift: Largest difference, in the sensor's unit.
        gate_limits: `zero_moving_share` and `significant_errors`.
    """
    if abs(zero.drift) <= largest_drift:
        return None
    last_phase_name = list(division.phases)[-1]
    last_phase = division.phases[last_phase_name]
    last_outputs = division.phase_signals[sensor.column][last_phase]
    rows_of_third = len(last_outputs) // 3
    change = (
        float(np.mean(last_outputs[-rows_of_third:]) - np.mean(last_outputs[:rows_of_third]))
        if rows_of_third
        else 0.0
    )
    fields = {"sensor": sensor, "drift": zero.drift, "allowed": largest_drift}
    # The sensor still settles if its output returns to the opening zero within the last phase: the
    # change has the opposite sign of the drift and is more than a share of it.
    if -change * np.sign(zero.drift) > gate_limits.zero_moving_share * abs(zero.drift):
        row_range = division.phase_signals.row_range(last_phase.start, last_phase.stop - 1)
        return refusal_by(
            "zero_not_settled",
            phase=last_phase_name,
            rest=division.rest_in_words,
            change=change,
            **fields,
            **row_range,
        )
    drift_se = float(np.hypot(zero.output_se[0], zero.output_se[-1]))
    if abs(zero.drift) <= gate_limits.significant_errors * drift_se:
        return refusal_by("zero_noisy", error=drift_se, **fields)
    return refusal_by("zero_drift", **fields)


def _is_still(signals: Signals, curation_settings: CurationSettings) -> BoolArray:
    """Mask of the samples at which both surfaces are slower than a share of the run's speed."""
    faster_m_s = np.maximum(np.abs(signals["ball_speed_m_s"]), np.abs(signals["disc_speed_m_s"]))
    finite_speeds_m_s = faster_m_s[np.isfinite(faster_m_s)]
    speed_of_run_m_s = (
        np.quantile(finite_speeds_m_s, _FASTEST_QUANTILE) if len(finite_speeds_m_s) else 0.0
    )
    return np.asarray(
        faster_m_s <= curation_settings.zero_reference.standstill_share * speed_of_run_m_s
    )


def phases_at_standstill(signals: Signals, curation_settings: CurationSettings) -> dict[str, slice]:
    """The settled samples at standstill before a run, and those after it if they are enough."""
    guard_rows = round(curation_settings.plateaus.guard_s / signals.interval_s)
    settle_rows = round(curation_settings.plateaus.settle_s / signals.interval_s)
    sample_count = len(signals)
    turning_indices = np.flatnonzero(~_is_still(signals, curation_settings))
    if len(turning_indices) == 0:
        # nothing turns, so that nothing is before or after the run: both phases become empty
        first_turning_index, last_turning_index = 0, sample_count - 1
    else:
        first_turning_index, last_turning_index = int(turning_indices[0]), int(turning_indices[-1])
    phases = {"opening": slice(0, max(first_turning_index - guard_rows, 0))}
    closing = slice(min(last_turning_index + 1 + settle_rows, sample_count), sample_count)
    min_duration_s = curation_settings.zero_reference.min_duration_s
    if short_phase_refusal(signals, closing, "closing phase of standstill", min_duration_s) is None:
        phases["closing"] = closing
    return phases


def is_turning_steadily(signals: Signals, curation_settings: CurationSettings) -> BoolArray:
    """Mask of the samples at which a rig turns, without run-up from and run-down to standstill.

    The run-up ends where the speed equals the mean of the following window; the run-down is judged
    in the same way, backwards. `settle_s` is cut off after a run-up and `guard_s` before a
    run-down.
    """
    is_still = _is_still(signals, curation_settings)
    is_turning = ~is_still
    if not is_still.any():
        return is_turning
    interval_s = signals.interval_s
    window_rows = max(round(curation_settings.plateaus.window_s / interval_s), 2)
    settle_rows = round(curation_settings.plateaus.settle_s / interval_s)
    guard_rows = round(curation_settings.plateaus.guard_s / interval_s)
    tolerance = curation_settings.zero_reference.ramp_tolerance
    speed = signals["entrainment_speed_m_s"]
    standstill_edges = np.flatnonzero(np.diff(np.concatenate([[0], is_still, [0]]).astype(int)))
    for start, stop in standstill_edges.reshape(-1, 2):
        # within a run a few readings of 0 are lost readings and no standstill
        if stop - start < window_rows and 0 < start and stop < len(is_still):
            continue
        run_up_rows = _run_up_length(speed[stop:], window_rows, tolerance)
        run_down_rows = _run_up_length(speed[:start][::-1], window_rows, tolerance)
        is_turning[
            max(start - run_down_rows - guard_rows, 0) : stop + run_up_rows + settle_rows
        ] = False
    return is_turning


def _run_up_length(speed: FloatArray, window_rows: int, tolerance: float) -> int:
    """Number of samples before a speed equals the mean of the following window.

    It is the number of all samples where this never happens. Every sample has a speed: a row
    without one is unreadable, and gives no sample.
    """
    if len(speed) < window_rows:
        return len(speed)
    running_sum = np.concatenate([[0.0], np.cumsum(speed)])
    mean_speed = (running_sum[window_rows:] - running_sum[:-window_rows]) / window_rows
    is_steady = np.abs(speed[: len(mean_speed)] - mean_speed) <= tolerance * np.abs(mean_speed)
    # the zeros of the next standstill are steady too, but do not end this run-up
    is_steady &= mean_speed != 0
    return int(np.argmax(is_steady)) if is_steady.any() else len(speed)


def sliding_phase_refusal(
    division: Division, phase_name: str, largest_slip: float
) -> Refusal | None:
    """The refusal by a phase whose mean slide-roll ratio is beyond a limit; else None."""
    slip = float(np.mean(division.phase_signals["slide_roll_ratio"][division.phases[phase_name]]))
    if abs(slip) <= largest_slip:
        return None
    return refusal_by(
        "zero_missing", "sliding_phase", phase=phase_name, slip=slip, limit=largest_slip
    )


def phase_of_curve_refusal(
    division: Division, plateaus: ColumnArrays, largest_share: float, significant_errors: float
) -> Refusal | None:
    """The refusal by a phase that is taken for pure rolling and is part of the curve; else None.

    It is part of the curve where its traction is more than a share of the largest one.

    Args:
        division: The phases.
        plateaus: The plateaus of the run.
        largest_share: Largest share of the largest traction coefficient.
        significant_errors: Standard errors beyond which a slip is significant.
    """
    plateau_slips = plateaus["slide_roll_ratio"]
    plateau_mu = plateaus["traction_coefficient"]
    largest_mu = float(np.nanmax(np.abs(plateau_mu), initial=0.0))
    for phase_name, phase in division.phases.items():
        phase_slips = division.phase_signals["slide_roll_ratio"][phase]
        slip, slip_se = mean_with_error(phase_slips)
        # Student's distribution: the error of the mean of few readings is itself uncertain
        tail_probability = scipy.special.ndtr(-significant_errors)
        limit_in_errors = -scipy.special.stdtrit(max(len(phase_slips) - 1, 1), tail_probability)
        if abs(slip) <= limit_in_errors * slip_se:
            continue
        slope = initial_slope(plateau_slips, plateau_mu, slip)
        mu_taken_for_zero = abs(slope * slip)
        if mu_taken_for_zero > largest_share * largest_mu:
            return refusal_by(
                "zero_missing",
                "part_of_curve",
                phase=phase_name,
                share=mu_taken_for_zero / largest_mu,
                slip=slip,
                slope=slope,
                mu=mu_taken_for_zero,
                allowed=largest_share,
            )
    return None


def remaining_force_refusal(
    run: MeasuredRun, curation_settings: CurationSettings, significant_errors: float
) -> Refusal | None:
    """The refusal by a force without slip or at standstill, where the rig removes the zero itself.

    Args:
        run: The run.
        curation_settings: `zero_reference`, `plateaus` and `spikes`.
        significant_errors: Standard errors beyond which a difference is significant.
    """
    plateaus = run.plateaus
    allowed_n = curation_settings.zero_reference.max_drift_n
    min_duration_s = curation_settings.zero_reference.min_duration_s
    phases = {
        f"in the {phase_name} phase of standstill": phase
        for phase_name, phase in phases_at_standstill(run.signals, curation_settings).items()
        if short_phase_refusal(
            run.signals, phase, f"{phase_name} phase of standstill", min_duration_s
        )
        is None
    }
    threshold = curation_settings.spikes.threshold
    zero_at_standstill = zero_reference(run.signals, "traction_force_n", phases, threshold)
    slip = np.abs(plateaus["slide_roll_ratio"])
    # where the slip is noisy, one that is not significant may still have traction
    is_without_slip = slip <= curation_settings.zero_reference.max_slide_roll_ratio
    is_without_slip &= slip <= significant_errors * plateaus["slide_roll_ratio_se"]
    all_force_se_n = plateaus["traction_coefficient_se"] * plateaus["load_n"]
    # plateaus without slip first, then the phases of standstill
    locations_in_words = ["without slip"] * int(is_without_slip.sum()) + list(phases)
    force_n = np.append(plateaus["traction_force_n"][is_without_slip], zero_at_standstill.output)
    force_se_n = np.append(all_force_se_n[is_without_slip], zero_at_standstill.output_se)
    return _first_force_refusal(
        force_n, significant_errors * force_se_n, locations_in_words, allowed_n
    )


def force_in_rolling_refusal(
    signals: Signals,
    phases: Mapping[str, slice],
    curation_settings: CurationSettings,
    significant_errors: float,
) -> Refusal | None:
    """The refusal by a force in pure rolling, where the rig removes the zero itself.

    Args:
        signals: The run.
        phases: Name of a phase of pure rolling -> its samples; short ones are not judged.
        curation_settings: `zero_reference` and `spikes`.
        significant_errors: As for `remaining_force_refusal`.
    """
    zero_settings = curation_settings.zero_reference
    judged_phases = {
        f"in the {phase_name} phase of pure rolling": phase
        for phase_name, phase in phases.items()
        if short_phase_refusal(
            signals, phase, f"{phase_name} phase of pure rolling", zero_settings.min_duration_s
        )
        is None
    }
    zero = zero_reference(
        signals, "traction_force_n", judged_phases, curation_settings.spikes.threshold
    )
    tolerances_n = significant_errors * zero.output_se
    return _first_force_refusal(
        zero.output, tolerances_n, list(judged_phases), zero_settings.max_drift_n
    )


def _first_force_refusal(
    force_n: FloatArray,
    tolerances_n: FloatArray,
    locations_in_words: Sequence[str],
    allowed_n: float,
) -> Refusal | None:
    """The refusal by the first force beyond what is allowed; None where all are within it.

    Args:
        force_n: Forces where there should be none, shape (forces,).
        tolerances_n: What their noise explains, shape (forces,).
        locations_in_words: Where in the run each force is.
        allowed_n: Largest force that is allowed.
    """
    indices_beyond = np.flatnonzero(np.abs(force_n) > allowed_n + tolerances_n)
    if len(indices_beyond) == 0:
        return None
    first = indices_beyond[0]
    return refusal_by(
        "zero_left", force=force_n[first], location=locations_in_words[first], allowed=allowed_n
    )


def raw_signal_refusal(signals: Signals, plateau_settings: PlateauSettings) -> Refusal | None:
    """The refusal of rows that follow each other too closely to be settled readings; else None.

    Args:
        signals: The run.
        plateau_settings: `min_duration_s`, the shortest settled part of a level, and `min_step`,
            the smallest step of slip.
    """
    # NaN where the log has no time
    interval_s = median(np.diff(signals.time_s))
    slip = signals["slide_roll_ratio"]
    # a row at rest has no slip
    slip_step = median(np.abs(np.diff(slip[np.isfinite(slip)])))
    least_step = plateau_settings.min_step / 2
    fields = dict(rows=len(signals), interval=interval_s, step=slip_step)
    fields |= dict(least_s=plateau_settings.min_duration_s, least=least_step)
    if interval_s > 0 and exceeds(plateau_settings.min_duration_s, interval_s):
        return refusal_by("no_settled_readings", "fast_rows", **fields)
    has_many_rows = len(signals) >= _FEWEST_ROWS_OF_SIGNAL
    if not interval_s > 0 and has_many_rows and slip_step < least_step:
        return refusal_by("no_settled_readings", "close_rows", **fields)
    return None


def _reverses_slip(signals: Signals) -> bool:
    """Whether the rig measures each slip in both directions.

    Its traction force is then half the difference of two forces. A zero of the sensor is in both of
    them, so that the difference does not contain it.
    """
    force_of_one_direction = signals.columns.get("traction_force_1_n", np.empty(0))
    return bool(np.isfinite(force_of_one_direction).any())


def _allowed_zero_n(plateaus: ColumnArrays, zero_settings: ZeroReferenceSettings) -> FloatArray:
    """Allowed force without slip: `max_drift_n`, or a share of the largest traction."""
    largest_mu = float(np.nanmax(np.abs(plateaus["traction_coefficient"]), initial=0.0))
    share_n = zero_settings.max_traction_share * largest_mu * plateaus["load_n"]
    return np.asarray(np.fmax(zero_settings.max_drift_n, share_n))


def _is_without_slip(plateaus: ColumnArrays, allowed_zero_n: FloatArray) -> BoolArray:
    """Mask of settled readings so near pure rolling that their traction is below a force."""
    slip = plateaus["slide_roll_ratio"]
    mu = plateaus["traction_coefficient"]
    slope = initial_slope(slip[slip != 0], mu[slip != 0], 0.0)
    return np.asarray(slope * np.abs(slip) * plateaus["load_n"] <= allowed_zero_n)


def shows_its_zero(run: MeasuredRun, zero_settings: ZeroReferenceSettings) -> bool:
    """Whether settled readings show their zero: without slip, or in both directions of it."""
    is_without_slip = _is_without_slip(run.plateaus, _allowed_zero_n(run.plateaus, zero_settings))
    differences = mu_differences_of_directions(run.plateaus)
    return bool(is_without_slip.any() or len(differences) or _reverses_slip(run.signals))


def zero_of_readings_refusal(
    run: MeasuredRun, zero_settings: ZeroReferenceSettings
) -> Refusal | None:
    """The refusal by a zero that is left in settled readings; None where none is found.

    Readings without slip show it, and readings of both directions of slip.

    Args:
        run: The run, of which each row is a plateau.
        zero_settings: Largest zero, and largest share of the largest traction.
    """
    if _reverses_slip(run.signals):
        return None
    slip = run.plateaus["slide_roll_ratio"]
    mu = run.plateaus["traction_coefficient"]
    load_n = run.plateaus["load_n"]
    allowed_zero_n = _allowed_zero_n(run.plateaus, zero_settings)
    is_without_slip = _is_without_slip(run.plateaus, allowed_zero_n)
    # a reading with some slip may have as much traction of its own
    allowed_n = allowed_zero_n * np.where(slip == 0, 1, 2)
    indices_beyond = np.flatnonzero(is_without_slip & (np.abs(mu * load_n) > allowed_n))
    if len(indices_beyond):
        first_beyond = indices_beyond[0]
        return refusal_by(
            "zero_left",
            "zero_left_without_slip",
            force=mu[first_beyond] * load_n[first_beyond],
            mu=mu[first_beyond],
            slip=slip[first_beyond],
            allowed=allowed_n[first_beyond],
        )
    common_mu = mu_common_to_directions(run.plateaus)
    # a reading without load has no traction coefficient
    has_mu = np.isfinite(mu)
    allowed_mu = median(allowed_zero_n[has_mu] / load_n[has_mu])
    if abs(common_mu) > allowed_mu:
        return refusal_by("zero_left", "zero_left_in_directions", mu=common_mu, allowed=allowed_mu)
    return None


def mu_common_to_directions(plateaus: ColumnArrays) -> float:
    """Traction coefficient that both directions of slip have in common; NaN without shared slips.

    It is half the difference of the sizes of mu at equal slips, in the median.
    """
    return median(mu_differences_of_directions(plateaus)) / 2


def mu_differences_of_directions(plateaus: ColumnArrays) -> FloatArray:
    """Size of mu at positive slips less that at negative slips of the same size.

    Only slips that both directions reach are compared. Mu at positive slips is interpolated.

    Returns:
        One value per negative slip that is compared; empty without one.
    """
    slip = plateaus["slide_roll_ratio"]
    mu = plateaus["traction_coefficient"]
    has_mu = np.isfinite(slip) & np.isfinite(mu)
    # `derive_plateaus` has reversed slip and force of plateaus with negative slip
    was_reversed = has_mu & (plateaus[DIRECTION_COLUMN] < 0)
    was_not_reversed = has_mu & (plateaus[DIRECTION_COLUMN] > 0)
    if not was_reversed.any() or not was_not_reversed.any():
        return np.empty(0)
    order_by_slip = np.argsort(slip[was_not_reversed], kind="stable")
    rising_slip = slip[was_not_reversed][order_by_slip]
    is_shared = was_reversed & (slip >= rising_slip[0]) & (slip <= rising_slip[-1])
    positive_mu = np.interp(slip[is_shared], rising_slip, mu[was_not_reversed][order_by_slip])
    return np.asarray(positive_mu - mu[is_shared])


def initial_slope(slip: FloatArray, mu: FloatArray, slip_of_zero: float) -> float:
    """d mu/dS at the beginning of a curve whose mu was set to zero at some slip; 0 if unknown.

    The slope of a saturating curve falls exponentially. It is extrapolated from two chords. The
    first one goes from the slip of the zero to the nearest level. The second one goes from there to
    the next level. The result has two limits:

    - It is at most ten times the first chord. This value is taken where the curve has saturated at
      its nearest level, and where there is no next level.
    - It is not below the chord to any level, because a saturating curve is steepest at its
      beginning.

    Plateaus nearer to the slip of the zero than half of that slip are left out.

    Args:
        slip: Slide-roll ratio of each plateau, shape (n,).
        mu: Traction coefficient above the zero, shape (n,).
        slip_of_zero: Slip at which mu was set to zero: mean slide-roll ratio of the phase that gave
            the zero.

    Examples:
        By hand: the chord 12.5 (exp(-0.2) - exp(-0.6)) = 3.374, times exp(0.3), because chords
        0.004 apart fall by exp(-0.4). The curve's own slope is 4.524 at 0.001 and 5 at 0.

        >>> slip = np.array([0.006, 0.01, 0.02])
        >>> mu = 0.05 * (np.exp(-0.002 / 0.01) - np.exp(-slip / 0.01))
        >>> print(f"{initial_slope(slip, mu, 0.002):.3f}")
        4.554
    """
    slip_distance = np.abs(slip - slip_of_zero)
    mu_size = np.abs(mu)
    is_usable = np.isfinite(slip_distance) & np.isfinite(mu_size)
    is_usable &= (slip_distance > 0) & (slip_distance >= abs(slip_of_zero) / 2)
    slip_distance = slip_distance[is_usable]
    mu_size = mu_size[is_usable]
    if len(slip_distance) == 0:
        return 0.0
    # the nearest level may have no traction but rounding
    steepest_chord = float((mu_size / slip_distance).max())
    is_nearest = reaches(_SAME_LEVEL_RATIO * slip_distance.min(), slip_distance)
    nearest_slip_distance = slip_distance[is_nearest].mean()
    nearest_mu_size = mu_size[is_nearest].mean()
    chord = nearest_mu_size / nearest_slip_distance
    slip_distance = slip_distance[~is_nearest]
    mu_size = mu_size[~is_nearest]
    if len(slip_distance) == 0:
        return max(float(_STEEPEST_RATIO * chord), steepest_chord)
    is_following = reaches(_SAME_LEVEL_RATIO * slip_distance.min(), slip_distance)
    distance_to_next_level = slip_distance[is_following].mean() - nearest_slip_distance
    next_chord = (mu_size[is_following] - nearest_mu_size).mean() / distance_to_next_level
    if next_chord <= 0:
        return max(float(_STEEPEST_RATIO * chord), steepest_chord)
    # from the middle of the first chord back to the middle between no slip and that of the zero
    exponent = (nearest_slip_distance + abs(slip_of_zero)) / (
        nearest_slip_distance + distance_to_next_level
    )
    slope = float(chord * np.clip((chord / next_chord) ** exponent, 1, _STEEPEST_RATIO))
    return max(slope, steepest_chord)
