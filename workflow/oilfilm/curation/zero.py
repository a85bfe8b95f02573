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
from oilfilm.curation.gate import fault
from oilfilm.curation.rig_kind import Channel, Division, Run, Signals
from oilfilm.curation.statistics import Stretches, mean_with_error, median
from oilfilm.logs.base import Columns, Refusal
from oilfilm.settings.config import (
    CurationSettings,
    PlateauSettings,
    SignalGateSettings,
    ZeroReferenceSettings,
)

# These say how speed and slope of a run are estimated. The limits that judge them are in the
# configuration.
# Column of plateaus: -1 where slip and force were negative, which `derive` turns round; else 1.
DIRECTION = "direction"
# Rows whose slips differ by less than a step belong to a signal, where they are so many.
_FEWEST_ROWS_OF_SIGNAL = 100
# Quantile of the speeds that stands for the speed of a run, without wild readings.
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
        phases = len(self.time_s)
        if phases < 2 or self.time_s[0] == self.time_s[1]:
            return np.full((len(time_s), phases), 1 / max(phases, 1))
        share = (time_s - self.time_s[0]) / (self.time_s[1] - self.time_s[0])
        return np.stack([1 - share, share], axis=1)


def phase_too_short(
    signals: Signals, phase: slice, name: str, min_duration_s: float
) -> Refusal | None:
    """A phase at rest that is missing or too short.

    Args:
        signals: The run.
        phase: The samples of the phase.
        name: The phase in words, as in `opening phase of standstill`.
        min_duration_s: Shortest phase that can be used.
    """
    rows = phase.stop - phase.start
    if rows <= 0:
        return fault("zero_missing", "no_phase", name=name)
    duration_s = rows * signals.interval_s
    # a single row gives no standard error
    if reaches(duration_s, min_duration_s) and rows > 1:
        return None
    return fault(
        "zero_missing",
        "short_phase",
        name=name,
        rows=rows,
        duration=duration_s,
        least=min_duration_s,
    )


def zero_reference(
    signals: Signals, sensor: str, phases: Mapping[str, slice], spike_threshold: float
) -> ZeroReference:
    """The zero from the phases at rest.

    Args:
        signals: The run.
        sensor: Column of the sensor.
        phases: Name of a phase -> its samples. Empty where the rig has removed the zero itself.
        spike_threshold: Threshold of the spike test, in robust standard deviations.
    """
    stretches = Stretches(
        starts=np.array([phase.start for phase in phases.values()], dtype=np.int64),
        stops=np.array([phase.stop for phase in phases.values()], dtype=np.int64),
    )
    outputs = stretches.cut(signals[sensor])
    inside = ~stretches.spikes(outputs, spike_threshold)
    output = stretches.means(outputs, inside)
    return ZeroReference(
        time_s=stretches.means(stretches.cut(signals.time_s), inside),
        output=output,
        output_se=stretches.standard_errors(outputs, inside, output),
    )


def moved_zero(
    zero: ZeroReference,
    division: Division,
    sensor: Channel,
    allowed: float,
    gates: SignalGateSettings,
) -> Refusal | None:
    """A refusal if the zero after the run differs from that before it, by the most likely cause.

    The causes are:

    - a sensor that still settles in the last phase
    - noise that is as large as the difference
    - otherwise a drift

    Args:
        zero: The zero at both phases.
        division: The phases.
        sensor: The signal whose zero it is.
        allowed: Largest difference, in the sensor's unit.
        gates: `zero_moving_share` and `significant_errors`.
    """
    if abs(zero.drift) <= allowed:
        return None
    last_name = list(division.phases)[-1]
    last_phase = division.phases[last_name]
    values = division.at_rest[sensor.column][last_phase]
    third = len(values) // 3
    change = float(np.mean(values[-third:]) - np.mean(values[:third])) if third else 0.0
    numbers = {"sensor": sensor, "drift": zero.drift, "allowed": allowed}
    # towards the opening zero, by more than the share of a steady drift
    if -change * np.sign(zero.drift) > gates.zero_moving_share * abs(zero.drift):
        rows = division.at_rest.rows(last_phase.start, last_phase.stop - 1)
        return fault(
            "zero_not_settled",
            phase=last_name,
            rest=division.rest_in_words,
            change=change,
            **numbers,
            **rows,
        )
    error = float(np.hypot(zero.output_se[0], zero.output_se[-1]))
    if abs(zero.drift) <= gates.significant_errors * error:
        return fault("zero_noisy", error=error, **numbers)
    return fault("zero_drift", **numbers)


def _is_still(signals: Signals, settings: CurationSettings) -> BoolArray:
    """The samples at which both surfaces are slower than a share of the run's speed."""
    faster = np.maximum(np.abs(signals["ball_speed_m_s"]), np.abs(signals["disc_speed_m_s"]))
    speeds = faster[np.isfinite(faster)]
    speed_of_run_m_s = np.quantile(speeds, _FASTEST_QUANTILE) if len(speeds) else 0.0
    return np.asarray(faster <= settings.zero_reference.standstill_share * speed_of_run_m_s)


def phases_at_standstill(signals: Signals, settings: CurationSettings) -> dict[str, slice]:
    """The settled samples at standstill before a run, and those after it if they are enough."""
    guard = round(settings.plateaus.guard_s / signals.interval_s)
    settle = round(settings.plateaus.settle_s / signals.interval_s)
    rows = len(signals)
    turning = np.flatnonzero(~_is_still(signals, settings))
    if len(turning) == 0:
        first_turning, last_turning = 0, rows - 1
    else:
        first_turning, last_turning = int(turning[0]), int(turning[-1])
    phases = {"opening": slice(0, max(first_turning - guard, 0))}
    closing = slice(min(last_turning + 1 + settle, rows), rows)
    min_duration_s = settings.zero_reference.min_duration_s
    if phase_too_short(signals, closing, "closing phase", min_duration_s) is None:
        phases["closing"] = closing
    return phases


def turns_steadily(signals: Signals, settings: CurationSettings) -> BoolArray:
    """The samples at which a rig turns, without ramps out of and into standstill.

    A ramp ends where the speed equals the mean of the following window. `settle_s` is cut off after
    a ramp and `guard_s` before the next one.
    """
    is_still = _is_still(signals, settings)
    is_turning = ~is_still
    if not is_still.any():
        return is_turning
    interval_s = signals.interval_s
    window = max(round(settings.plateaus.window_s / interval_s), 2)
    settle = round(settings.plateaus.settle_s / interval_s)
    guard = round(settings.plateaus.guard_s / interval_s)
    tolerance = settings.zero_reference.ramp_tolerance
    speed = signals["entrainment_speed_m_s"]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_still, [0]]).astype(int)))
    for start, stop in edges.reshape(-1, 2):
        # within a run a few readings of 0 are lost readings and no standstill
        if stop - start < window and 0 < start and stop < len(is_still):
            continue
        ramp_up = _ramp_length(speed[stop:], window, tolerance)
        ramp_down = _ramp_length(speed[:start][::-1], window, tolerance)
        is_turning[max(start - ramp_down - guard, 0) : stop + ramp_up + settle] = False
    return is_turning


def _ramp_length(speed: FloatArray, window: int, tolerance: float) -> int:
    """Samples before a speed equals the mean of the window that it begins; all if it never does."""
    if len(speed) < window:
        return len(speed)
    running_sum = np.concatenate([[0.0], np.cumsum(speed)])
    mean = (running_sum[window:] - running_sum[:-window]) / window
    is_steady = np.abs(speed[: len(mean)] - mean) <= tolerance * np.abs(mean)
    # the zeros of the next standstill are steady too, but do not end this ramp
    is_steady &= mean != 0
    return int(np.argmax(is_steady)) if is_steady.any() else len(speed)


def sliding_phase(division: Division, name: str, limit: float) -> Refusal | None:
    """A phase whose slide-roll ratio is beyond a limit; None where it is not."""
    slip = float(np.mean(division.at_rest["slide_roll_ratio"][division.phases[name]]))
    if abs(slip) <= limit:
        return None
    return fault("zero_missing", "sliding_phase", phase=name, slip=slip, limit=limit)


def part_of_curve(
    division: Division, plateaus: Columns, allowed: float, significant_errors: float
) -> Refusal | None:
    """A phase taken for pure rolling whose traction is more than a share of the largest one.

    Args:
        division: The phases.
        plateaus: The plateaus of the run.
        allowed: That share.
        significant_errors: Standard errors beyond which a slip is significant.
    """
    slips = plateaus["slide_roll_ratio"]
    mu = plateaus["traction_coefficient"]
    largest = float(np.nanmax(np.abs(mu), initial=0.0))
    for name, phase in division.phases.items():
        phase_slips = division.at_rest["slide_roll_ratio"][phase]
        slip, error = mean_with_error(phase_slips)
        # Student's distribution: the error of the mean of few readings is itself uncertain
        chance = scipy.stats.norm.sf(significant_errors)
        errors = float(scipy.stats.t.isf(chance, max(len(phase_slips) - 1, 1)))
        if abs(slip) <= errors * error:
            continue
        slope = initial_slope(slips, mu, slip)
        removed_mu = abs(slope * slip)
        if removed_mu > allowed * largest:
            return fault(
                "zero_missing",
                "part_of_curve",
                phase=name,
                share=removed_mu / largest,
                slip=slip,
                slope=slope,
                mu=removed_mu,
                allowed=allowed,
            )
    return None


def force_left(run: Run, curation: CurationSettings, significant_errors: float) -> Refusal | None:
    """A force without slip or at standstill although the rig is said to have removed its zero.

    Args:
        run: The run.
        curation: `zero_reference`, `plateaus` and `spikes`.
        significant_errors: Standard errors beyond which a difference is significant.
    """
    plateaus = run.plateaus
    allowed_n = curation.zero_reference.max_drift_n
    min_duration_s = curation.zero_reference.min_duration_s
    phases = {
        f"in the {name} phase of standstill": phase
        for name, phase in phases_at_standstill(run.signals, curation).items()
        if phase_too_short(run.signals, phase, name, min_duration_s) is None
    }
    threshold = curation.spikes.threshold
    standstill = zero_reference(run.signals, "traction_force_n", phases, threshold)
    slip = np.abs(plateaus["slide_roll_ratio"])
    is_rolling = slip <= significant_errors * plateaus["slide_roll_ratio_se"]
    force_error_n = plateaus["traction_coefficient_se"] * plateaus["load_n"]
    # plateaus without slip first, then the phases of standstill
    conditions = ["without slip"] * int(is_rolling.sum()) + list(phases)
    force_n = np.append(plateaus["traction_force_n"][is_rolling], standstill.output)
    error_n = np.append(force_error_n[is_rolling], standstill.output_se)
    return _first_force_left(force_n, significant_errors * error_n, conditions, allowed_n)


def force_left_in_rolling(
    signals: Signals,
    phases: Mapping[str, slice],
    curation: CurationSettings,
    significant_errors: float,
) -> Refusal | None:
    """A force in pure rolling although the rig is said to have removed its zero.

    Args:
        signals: The run.
        phases: Name of a phase of pure rolling -> its samples; short ones are not judged.
        curation: `zero_reference` and `spikes`.
        significant_errors: As for `force_left`.
    """
    settings = curation.zero_reference
    judged_phases = {
        f"in the {name} phase of pure rolling": phase
        for name, phase in phases.items()
        if phase_too_short(signals, phase, name, settings.min_duration_s) is None
    }
    zero = zero_reference(signals, "traction_force_n", judged_phases, curation.spikes.threshold)
    tolerances_n = significant_errors * zero.output_se
    return _first_force_left(zero.output, tolerances_n, list(judged_phases), settings.max_drift_n)


def _first_force_left(
    force_n: FloatArray, tolerances_n: FloatArray, conditions: Sequence[str], allowed_n: float
) -> Refusal | None:
    """The first force beyond what is allowed; None where all are within it.

    Args:
        force_n: Forces where there should be none, shape (places,).
        tolerances_n: What their noise explains, shape (places,).
        conditions: Where they are, in words.
        allowed_n: Largest force that is allowed.
    """
    beyond = np.flatnonzero(np.abs(force_n) > allowed_n + tolerances_n)
    if len(beyond) == 0:
        return None
    first = beyond[0]
    return fault("zero_left", force=force_n[first], place=conditions[first], allowed=allowed_n)


def raw_signal(signals: Signals, settings: PlateauSettings) -> Refusal | None:
    """Rows that are no settled readings, because they follow each other too closely.

    Args:
        signals: The run.
        settings: `min_duration_s`, the shortest settled part of a level, and `min_step` of slip.
    """
    # NaN where the log has no time
    interval_s = median(np.diff(signals.time_s))
    step = median(np.abs(np.diff(signals["slide_roll_ratio"])))
    numbers = dict(rows=len(signals), interval=interval_s, step=step)
    numbers |= dict(least_s=settings.min_duration_s, least=settings.min_step)
    if interval_s > 0 and exceeds(settings.min_duration_s, interval_s):
        return fault("no_settled_readings", "fast_rows", **numbers)
    has_many_rows = len(signals) >= _FEWEST_ROWS_OF_SIGNAL
    if not interval_s > 0 and has_many_rows and step < settings.min_step / 2:
        return fault("no_settled_readings", "close_rows", **numbers)
    return None


def _forces_reversed(signals: Signals) -> bool:
    """Whether the rig reverses the slip: half the difference of both forces has no zero."""
    one_direction = signals.columns.get("traction_force_1_n", np.empty(0))
    return bool(np.isfinite(one_direction).any())


def _largest_zero_n(plateaus: Columns, settings: ZeroReferenceSettings) -> FloatArray:
    """Largest force without slip: `max_drift_n`, or a share of the largest traction."""
    largest_mu = float(np.nanmax(np.abs(plateaus["traction_coefficient"]), initial=0.0))
    share_n = settings.max_traction_share * largest_mu * plateaus["load_n"]
    return np.asarray(np.fmax(settings.max_drift_n, share_n))


def _without_slip(plateaus: Columns, allowed_n: FloatArray) -> BoolArray:
    """Settled readings so near pure rolling that their own traction is less than a force."""
    slip = plateaus["slide_roll_ratio"]
    mu = plateaus["traction_coefficient"]
    slope = initial_slope(slip[slip != 0], mu[slip != 0], 0.0)
    return np.asarray(slope * np.abs(slip) * plateaus["load_n"] <= allowed_n)


def is_tested(run: Run, settings: ZeroReferenceSettings) -> bool:
    """Whether settled readings show their zero: without slip, or in both directions of it."""
    rolls = _without_slip(run.plateaus, _largest_zero_n(run.plateaus, settings))
    in_both_directions, _ = differences_of_directions(run.plateaus)
    return bool(rolls.any() or len(in_both_directions) or _forces_reversed(run.signals))


def zero_of_readings(run: Run, settings: ZeroReferenceSettings) -> Refusal | None:
    """A zero that is left in settled readings, by those without slip or of both directions.

    Args:
        run: The run, of which each row is a plateau.
        settings: Largest zero, and largest share of the largest traction.
    """
    if _forces_reversed(run.signals):
        return None
    slip = run.plateaus["slide_roll_ratio"]
    mu = run.plateaus["traction_coefficient"]
    load_n = run.plateaus["load_n"]
    largest_n = _largest_zero_n(run.plateaus, settings)
    is_rolling = _without_slip(run.plateaus, largest_n)
    # a reading with some slip may have as much traction of its own
    allowed_n = largest_n * np.where(slip == 0, 1, 2)
    beyond = np.flatnonzero(is_rolling & (np.abs(mu * load_n) > allowed_n))
    if len(beyond):
        first = beyond[0]
        return fault(
            "zero_left",
            "zero_left_without_slip",
            force=mu[first] * load_n[first],
            mu=mu[first],
            slip=slip[first],
            allowed=allowed_n[first],
        )
    offset_mu = zero_of_directions(run.plateaus)
    allowed_mu = median(largest_n / load_n)
    if abs(offset_mu) > allowed_mu:
        return fault("zero_left", "zero_left_in_directions", mu=offset_mu, allowed=allowed_mu)
    return None


def zero_of_directions(plateaus: Columns) -> float:
    """Traction coefficient that both directions of slip have in common; NaN without shared slips.

    It is half the difference of the sizes of mu at equal slips, in the median.
    """
    differences, _ = differences_of_directions(plateaus)
    return median(differences) / 2


def differences_of_directions(plateaus: Columns) -> tuple[FloatArray, FloatArray]:
    """Size of mu at positive slips less that at negative ones, and that at negative ones.

    Only slips that both directions reach are compared. Positive slips are interpolated.

    Returns:
        Both of shape (negative slips,).
    """
    slip = plateaus["slide_roll_ratio"]
    mu = plateaus["traction_coefficient"]
    is_known = np.isfinite(slip) & np.isfinite(mu)
    is_negative = is_known & (plateaus[DIRECTION] < 0)
    is_positive = is_known & (plateaus[DIRECTION] > 0)
    if not is_negative.any() or not is_positive.any():
        return np.empty(0), np.empty(0)
    by_slip = np.argsort(slip[is_positive], kind="stable")
    rising = slip[is_positive][by_slip]
    is_shared = is_negative & (slip >= rising[0]) & (slip <= rising[-1])
    positive_mu = np.interp(slip[is_shared], rising, mu[is_positive][by_slip])
    return positive_mu - mu[is_shared], mu[is_shared]


def initial_slope(slip: FloatArray, mu: FloatArray, at_slip: float) -> float:
    """d mu/dS at the beginning of a curve whose zero was taken at a slip; 0 where it is unknown.

    The slope of a saturating curve falls exponentially. It is extrapolated from two chords: from
    that slip to the nearest level, and from there to the next level. It is at most ten times the
    first chord. This limit holds too where the curve has saturated at its nearest level, or where
    there is no next level.

    Args:
        slip: Slide-roll ratio of each plateau, shape (n,).
        mu: Traction coefficient above the zero, shape (n,).
        at_slip: Mean slide-roll ratio of the phase that gave the zero.

    Examples:
        By hand: the chord 12.5 (exp(-0.2) - exp(-0.6)) = 3.374, times exp(0.3), because chords
        0.004 apart fall by exp(-0.4). The curve's own slope is 4.524 at 0.001 and 5 at 0.

        >>> slip = np.array([0.006, 0.01, 0.02])
        >>> mu = 0.05 * (np.exp(-0.002 / 0.01) - np.exp(-slip / 0.01))
        >>> print(f"{initial_slope(slip, mu, 0.002):.3f}")
        4.554
    """
    distance = np.abs(slip - at_slip)
    size = np.abs(mu)
    usable = np.isfinite(distance) & np.isfinite(size)
    usable &= (distance > 0) & (distance >= abs(at_slip) / 2)
    distance = distance[usable]
    size = size[usable]
    if len(distance) == 0:
        return 0.0
    is_nearest = reaches(_SAME_LEVEL_RATIO * distance.min(), distance)
    nearest_distance = distance[is_nearest].mean()
    nearest_size = size[is_nearest].mean()
    chord = nearest_size / nearest_distance
    distance = distance[~is_nearest]
    size = size[~is_nearest]
    if len(distance) == 0:
        return float(_STEEPEST_RATIO * chord)
    is_following = reaches(_SAME_LEVEL_RATIO * distance.min(), distance)
    step = distance[is_following].mean() - nearest_distance
    next_chord = (size[is_following] - nearest_size).mean() / step
    if next_chord <= 0:
        return float(_STEEPEST_RATIO * chord)
    # from the middle of the first chord back to the middle between no slip and that of the zero
    exponent = (nearest_distance + abs(at_slip)) / (nearest_distance + step)
    return float(chord * np.clip((chord / next_chord) ** exponent, 1, _STEEPEST_RATIO))
