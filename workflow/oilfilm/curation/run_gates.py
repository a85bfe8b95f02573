"""The gates of runs in the order in which they judge: clock, sensors, temperature, branches.

Warnings follow them. A warning names what may be wrong with a run that is used.

Decides: when a whole run is refused (clock, stuck sensor, sign, temperature drift); warnings about
a run that is used.
"""

from itertools import combinations
from typing import Any

import numpy as np

from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray
from oilfilm.curation.gate import (
    RULES,
    FindingFields,
    Gate,
    Gates,
    RunJudge,
    refusal_by,
    refusal_with_sentence,
    unit_hint,
)
from oilfilm.curation.rig_kind import Channel, MeasuredRun, RigKind
from oilfilm.curation.statistics import (
    is_noise,
    longest_hold,
    median,
    rows_per_reading,
    without_repeats,
)
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.curation.zero import DIRECTION_COLUMN, mu_differences_of_directions, shows_its_zero
from oilfilm.logs.base import Refusal

RUN_GATES: Gates[RunJudge] = Gates()
gate = RUN_GATES.gate

# The limits of the gates are in the configuration. These name the cause of a refusal, or say what
# noise is, as in `statistics`.
# Two columns have the same signal if their mean difference is at most this share of the mean step
# between its readings.
_SAME_SIGNAL_SHARE = 0.1
# Fewest distinct values of a sensor whose smallest step is stated in the refusal.
_FEWEST_VALUES = 3
# Number of changed readings before, and after, a hold in which a channel must show noise.
_READINGS_BESIDE_HOLD = 20


def first_refusal(run: MeasuredRun) -> Refusal | None:
    """The refusal by the first gate that refuses a run, if one does."""
    for run_gate in RUN_GATES.for_rig(run.rig_kind.name):
        for fields in run_gate.judge(run, run.rig_kind):
            return refusal_with_sentence(run_gate.name, _sentence(run_gate, run, fields), fields)
    if run.refusal is None and len(run.plateaus["time_s"]) == 0:
        return refusal_by("no_plateau")
    return run.refusal


def warnings_about(run: MeasuredRun) -> tuple[str, ...]:
    """All warnings about a run, each with its name."""
    sentences = []
    for run_warning in WARNINGS.for_rig(run.rig_kind.name):
        for fields in run_warning.judge(run, run.rig_kind):
            sentences.append(f"{run_warning.name}: {_sentence(run_warning, run, fields)}")
    return tuple(sentences)


def _sentence(run_gate: Gate[RunJudge], run: MeasuredRun, fields: dict[str, Any]) -> str:
    """The sentence of a gate about a run, with the values of its fields."""
    return run_gate.sentence(run.rig_kind, sensor=run.rig_kind.sensor, **fields)


@gate
def time_disorder(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The time stamp does not increase."""
    time_s = run.signals.time_s
    indices_not_increasing = np.flatnonzero(np.diff(time_s) <= 0)
    if len(indices_not_increasing):
        first_index = indices_not_increasing[0]
        yield {
            "rows": len(indices_not_increasing),
            "time_before": time_s[first_index],
            "time_after": time_s[first_index + 1],
            **run.signals.row_range(first_index, first_index + 1),
        }


@gate
def missing_readings(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """So many consecutive rows cannot be read that the run has a hole."""
    row_numbers = run.signals.row_numbers
    row_steps = np.diff(row_numbers)
    # a log that writes a slow channel in every twentieth row only has steps of 20 rows
    allowed_row_step = rig_kind.gate_limits.clock_jump_intervals * median(row_steps)
    # a single row has no steps: the limit is NaN, and the comparison is false
    if row_steps.max(initial=0) > allowed_row_step:
        hole_index = int(np.argmax(row_steps))
        yield {
            "first": row_numbers[hole_index] + 1,
            "last": row_numbers[hole_index + 1] - 1,
            "allowed": allowed_row_step - 1,
        }


@gate
def clock_jump(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The clock jumps ahead."""
    gaps_s = np.diff(run.signals.time_s)
    allowed_s = rig_kind.gate_limits.clock_jump_intervals * run.signals.interval_s
    # settled readings without time have gaps of NaN, which exceed nothing
    if exceeds(gaps_s.max(initial=0), allowed_s):
        longest_gap_index = int(np.argmax(gaps_s))
        row_range = run.signals.row_range(longest_gap_index, longest_gap_index + 1)
        yield {"gap": gaps_s[longest_gap_index], "allowed": allowed_s, **row_range}


@gate
def same_channel(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """A run without a zero has the same readings in two channels."""
    if run.refusal is None or run.refusal.rule != "zero_missing":
        return
    for channel, other_channel in combinations(rig_kind.channels, 2):
        values = run.signals[channel.column]
        step_sizes = np.abs(np.diff(values))
        if not step_sizes.any():
            # two constant signals may have one value by chance
            continue
        mean_difference = np.mean(np.abs(values - run.signals[other_channel.column]))
        # rounding in other units makes small differences
        if mean_difference <= _SAME_SIGNAL_SHARE * np.mean(step_sizes):
            yield {"one": channel.name, "other": other_channel.name}


@gate
def never_turns(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The bearing is at standstill from the first row to the last."""
    fastest_rpm = float(np.abs(run.signals["inner_speed_rpm"]).max())
    # a speed that is not known does not show that the bearing turns
    if not fastest_rpm > rig_kind.settings.torque_logs.tare.max_speed_rpm:
        yield {"fastest": fastest_rpm}


@gate
def held_readings(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The sensor is read so slowly that a plateau has few readings of its own."""
    durations_s = run.plateaus["duration_s"]
    plateau_s = (
        median(durations_s) if len(durations_s) else rig_kind.plateau_settings.min_duration_s
    )
    rows_held = rows_per_reading(run.signals[rig_kind.sensor.column])
    hold_s = rows_held * run.signals.interval_s
    fewest_readings = rig_kind.gate_limits.readings_min
    if rows_held > 1 and exceeds(fewest_readings * hold_s, plateau_s):
        yield {
            "rows": rows_held,
            "hold": hold_s,
            "plateau": plateau_s,
            "readings": sum(reaches(plateau_s, hold_s * np.arange(1, fewest_readings))),
            "fewest": fewest_readings,
        }


@gate
def stuck_channel(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """A signal that shows noise stops moving for part of the run."""
    for channel in rig_kind.channels:
        values = run.running_signals[channel.column]
        start, stop = _suspicious_hold(values, run, rig_kind)
        if start == stop:
            continue
        values_outside = np.delete(values, np.s_[start + 1 : stop])
        readings_outside = without_repeats(values_outside)
        repeat_share = 1 - len(readings_outside) / len(values_outside)
        if not (is_noise(readings_outside) and _noise_beside_hold(values, start, stop)):
            continue
        expected_holds = len(values) * repeat_share ** (stop - start)
        if expected_holds < rig_kind.stuck_settings.chance:
            row_range = run.running_signals.row_range(start, stop - 1)
            yield {"channel": channel, "value": values[start], **row_range}


def _noise_beside_hold(values: FloatArray, start: int, stop: int) -> bool:
    """Whether the readings just before and after a hold are noise; too few count as noise.

    A channel that freezes has its noise up to that row. A channel that is quiet there has none.
    """
    before = without_repeats(values[: start + 1])[-_READINGS_BESIDE_HOLD:]
    after = without_repeats(values[stop - 1 :])[:_READINGS_BESIDE_HOLD]
    for readings in (before, after):
        if len(readings) > _READINGS_BESIDE_HOLD / 2 and not is_noise(readings):
            return False
    return True


def _suspicious_hold(values: FloatArray, run: MeasuredRun, rig_kind: RigKind) -> tuple[int, int]:
    """The longest stretch of one value, as `longest_hold`; empty where it is not suspicious."""
    if len(values) == 0:
        return 0, 0
    start, stop = longest_hold(values)
    duration_s = (stop - start) * run.signals.interval_s
    is_suspicious = (
        reaches(duration_s, rig_kind.stuck_settings.duration_s)
        and stop - start >= rig_kind.stuck_settings.samples
    )
    return (start, stop) if is_suspicious else (0, 0)


def _is_sliding(run: MeasuredRun, rig_kind: TractionRig) -> BoolArray:
    """The plateaus at which the sign and the size of the traction can be judged."""
    return np.asarray(np.abs(run.plateaus["slide_roll_ratio"]) > rig_kind.gate_limits.sign_slip_min)


def _median_traction_coefficient(run: MeasuredRun, rig_kind: TractionRig) -> float:
    """Median size of the traction coefficient of the sliding plateaus.

    A plateau without load has no traction coefficient, and is left out.
    """
    mu = run.plateaus["traction_coefficient"][_is_sliding(run, rig_kind)]
    return median(np.abs(mu[np.isfinite(mu)]))


@gate
def no_traction(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The traction coefficients of the sliding plateaus are smaller than those of any oil."""
    yield from _small_traction(run, rig_kind, rig_kind.gate_limits.sliding_traction_min)


def _small_traction(run: MeasuredRun, rig_kind: TractionRig, smallest_mu: float) -> FindingFields:
    """A median traction coefficient below a limit, with the units that would explain it."""
    median_mu = _median_traction_coefficient(run, rig_kind)

    def is_usual(unit_size_n: float) -> bool:
        return (
            rig_kind.gate_limits.sliding_traction_usual
            <= median_mu * unit_size_n
            <= rig_kind.gate_limits.traction_max
        )

    if median_mu < smallest_mu:
        yield {"median_mu": median_mu, "hint": unit_hint("traction force", is_usual)}


@gate
def impossible_traction(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The zero moves, but the traction is too large by more than a zero explains."""
    if run.refusal is None or run.refusal.rule != "zero_drift":
        return
    median_mu = _median_traction_coefficient(run, rig_kind)
    excess_mu = median_mu - rig_kind.gate_limits.traction_max
    explained_n = rig_kind.zero_settings.max_drift_n * rig_kind.gate_limits.significant_errors
    # compared as forces: the load may be 0
    if excess_mu * median(run.plateaus["load_n"]) > explained_n:
        yield {"median_mu": median_mu, "reason": run.refusal.reason}


@gate
def swapped_sign(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The traction force acts against the slip."""
    force_along_slip_n = run.plateaus["traction_force_n"] * np.sign(
        run.plateaus["slide_roll_ratio"]
    )
    force_along_slip_n = force_along_slip_n[_is_sliding(run, rig_kind)]
    median_force_n = median(force_along_slip_n)
    if median_force_n < 0 and (force_along_slip_n < 0).mean() >= rig_kind.gate_limits.sign_share:
        yield {"median": median_force_n}


@gate
def sign_changes(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The traction force acts against the slip in one part of the run and along it in another."""
    plateaus = run.plateaus
    slip = plateaus["slide_roll_ratio"]
    force_n = plateaus["traction_force_n"]
    force_se_n = np.nan_to_num(plateaus["traction_coefficient_se"]) * plateaus["load_n"]
    is_significant = np.abs(force_n) > rig_kind.gate_limits.significant_errors * force_se_n
    is_judged = _is_sliding(run, rig_kind) & is_significant
    is_against = is_judged & (force_n * slip < 0)
    judged_count = is_judged.sum()
    against_count = is_against.sum()
    fewest_plateaus = max(
        rig_kind.gate_limits.faulty_plateaus_min,
        (1 - rig_kind.gate_limits.sign_share) * judged_count,
    )
    # so many plateaus must have either sign
    if reaches(against_count, fewest_plateaus) and reaches(
        judged_count - fewest_plateaus, against_count
    ):
        first_index, last_index = np.flatnonzero(is_against)[[0, -1]]
        yield {
            "against": against_count,
            "sliding": judged_count,
            "first": plateaus["first_row"][first_index],
            "last": plateaus["last_row"][last_index],
        }


def _branches_in_direction(
    run: MeasuredRun, rig_kind: TractionRig, direction: int
) -> list[tuple[FloatArray, FloatArray]]:
    """Rising slips and traction coefficients of each branch of a sweep, in one direction of slip.

    A sweep reverses at its inner extreme: one branch ends there, and another begins. The one with
    rising slip is the first of the two. With fewer than `branch_points` plateaus on either side of
    the extreme, the sweep has one branch.
    """
    slip = run.plateaus["slide_roll_ratio"]
    mu = run.plateaus["traction_coefficient"]
    is_judged = np.isfinite(slip) & np.isfinite(mu) & (run.plateaus[DIRECTION_COLUMN] == direction)
    # rolling before and after a sweep is no reversal of it
    is_judged &= slip > rig_kind.zero_settings.max_slide_roll_ratio
    slip = slip[is_judged]
    mu = mu[is_judged]
    fewest_plateaus = rig_kind.gate_limits.branch_points
    slices_of_branches = [slice(None)]
    if len(slip) >= 2 * fewest_plateaus:
        extreme_indices = np.array([np.argmax(slip), np.argmin(slip)])
        distance_from_end = np.minimum(extreme_indices, len(slip) - 1 - extreme_indices)
        reversal_index = int(extreme_indices[np.argmax(distance_from_end)])
        if distance_from_end.max() >= fewest_plateaus:
            slices_of_branches = [slice(reversal_index + 1), slice(reversal_index, None)]
            if slip[reversal_index] == slip.min():
                # the slip falls first
                slices_of_branches.reverse()
    branches = []
    for branch_slice in slices_of_branches:
        order_by_slip = np.argsort(slip[branch_slice], kind="stable")
        branches.append((slip[branch_slice][order_by_slip], mu[branch_slice][order_by_slip]))
    return branches


@gate
def saturated(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """A sensor is at the end of its range for part of the run."""
    for channel in (rig_kind.sensor, rig_kind.channels[0]):
        values = run.running_signals[channel.column]
        for extreme in (values.max(initial=-np.inf), values.min(initial=np.inf)):
            indices_at_extreme = np.flatnonzero(values == extreme)
            share = len(indices_at_extreme) / max(len(values), 1)
            # a signal that keeps this value to its end is stuck
            is_at_extreme = run.signals[channel.column] == extreme
            rows_from_first_to_end = len(is_at_extreme) - np.argmax(is_at_extreme)
            is_stuck = np.count_nonzero(is_at_extreme) == rows_from_first_to_end
            if (
                len(indices_at_extreme) >= rig_kind.stuck_settings.samples
                and share > rig_kind.gate_limits.saturated_share
                and not is_stuck
                and _is_piled_up(values, extreme, rig_kind.gate_limits.piled_up_factor)
                and is_noise(without_repeats(np.delete(values, indices_at_extreme)))
            ):
                row_range = run.running_signals.row_range(
                    indices_at_extreme[0], indices_at_extreme[-1]
                )
                yield {"channel": channel, "extreme": extreme, "share": share, **row_range}


def _is_piled_up(values: FloatArray, extreme: float, factor: float) -> bool:
    """True where an extreme value occurs more than `factor` times as often as the next one.

    A sensor at its stop gives one value again and again, with noise on one side only. Values that
    are coarse anyway are not piled up, nor is the load of a dead weight.
    """
    distinct_values, counts = np.unique(values, return_counts=True)
    if len(distinct_values) <= 1:
        return False
    end_index, neighbour_index = (-1, -2) if extreme == distinct_values[-1] else (0, 1)
    return bool(counts[end_index] > factor * counts[neighbour_index])


@gate
def stuck_sensor(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The sensor gives exactly the same reading again and again.

    Settled readings are means without noise: those of a flat curve may be equal.
    """
    if run.is_settled:
        return
    values = run.running_signals[rig_kind.sensor.column]
    start, stop = _suspicious_hold(values, run, rig_kind)
    if start == stop:
        return
    distinct_values = np.unique(values)
    hint = ""
    if len(distinct_values) >= _FEWEST_VALUES and not is_noise(without_repeats(values)):
        smallest_step = np.diff(distinct_values).min()
        hint = (
            f"; it moves in steps of {smallest_step:.2g}: log it with more digits, if that is its "
            "last one"
        )
    yield {"value": values[start], "hint": hint, **run.running_signals.row_range(start, stop - 1)}


@gate
def temperature_drift(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The inlet temperature differs between the plateaus of one run."""
    temperature_c = run.plateaus["inlet_temperature_c"]
    least_c = np.fmin.reduce(temperature_c, initial=np.inf)
    most_c = np.fmax.reduce(temperature_c, initial=-np.inf)
    if exceeds(most_c - least_c, rig_kind.gate_limits.temperature_drift_max_c):
        yield {"least": least_c, "most": most_c}


@gate
def two_conditions(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The plateaus have two loads or two speeds, each in several of them."""
    limits = rig_kind.settings.same_condition
    speed = Channel("entrainment_speed_m_s", "speed", "m/s")
    for channel, largest_relative_range in (
        (rig_kind.channels[0], limits.load),
        (speed, limits.entrainment_speed),
    ):
        values = run.plateaus[channel.column]
        # a load that changes within a plateau is neither
        is_held = ~(np.abs(run.plateaus["load_change"]) > rig_kind.gate_limits.load_change_max)
        is_held &= np.isfinite(values)
        values = values[is_held]
        limit = _limit_between_levels(
            values, largest_relative_range, rig_kind.gate_limits.faulty_plateaus_min
        )
        if np.isnan(limit):
            continue
        is_high = values > limit
        change_indices = np.flatnonzero(is_high[1:] != is_high[:-1])
        yield {
            "name": channel.name,
            "unit": channel.unit,
            "low": median(values[~is_high]),
            "high": median(values[is_high]),
            "count_low": np.count_nonzero(~is_high),
            "count_high": np.count_nonzero(is_high),
            "first": run.plateaus["first_row"][is_held][change_indices[0] + 1],
            "last": run.plateaus["last_row"][-1],
        }


def _limit_between_levels(
    values: FloatArray, largest_relative_range: float, fewest_plateaus: int
) -> float:
    """A value that separates two levels; NaN where there are not two.

    Args:
        values: Means of plateaus, finite.
        largest_relative_range: Largest range of one level, relative to its median.
        fewest_plateaus: Plateaus that a level has at least.
    """
    sorted_values = np.sort(values)
    if len(sorted_values) < 2 * fewest_plateaus:
        return np.nan
    gaps = np.diff(sorted_values)
    split_index = (
        fewest_plateaus
        - 1
        + int(np.argmax(gaps[fewest_plateaus - 1 : len(gaps) - fewest_plateaus + 1]))
    )
    levels = sorted_values[: split_index + 1], sorted_values[split_index + 1 :]
    is_narrow = [np.ptp(level) <= largest_relative_range * abs(median(level)) for level in levels]
    if all(is_narrow) and gaps[split_index] > largest_relative_range * abs(
        sorted_values[split_index]
    ):
        return float(sorted_values[split_index] + gaps[split_index] / 2)
    return np.nan


@gate
def branches_differ(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The traction coefficients of rising and falling slip do not agree."""
    differences, _ = _branch_differences(run, rig_kind)
    # the median, because other gates judge single wild points
    median_difference = median(np.abs(differences))
    if median_difference > rig_kind.gate_limits.branch_difference_max:
        yield {"difference": median_difference, "points": len(differences)}


def _branch_differences(run: MeasuredRun, rig_kind: TractionRig) -> tuple[FloatArray, FloatArray]:
    """Rising branch less falling branch of a sweep in mu, and mu, both of shape (slips,).

    Only the slips that both branches reach are compared. Both arrays are empty where the sweep has
    one branch.
    """
    differences = [np.empty(0)]
    compared_mu = [np.empty(0)]
    for direction in (1, -1):
        branches = _branches_in_direction(run, rig_kind, direction)
        if len(branches) == 1:
            continue
        (slip, mu), (back_slip, back_mu) = branches
        lowest = max(slip[0], back_slip[0])
        highest = min(slip[-1], back_slip[-1])
        is_shared = (slip >= lowest) & (slip <= highest)
        if is_shared.sum() >= rig_kind.gate_limits.branch_points:
            differences.append(mu[is_shared] - np.interp(slip[is_shared], back_slip, back_mu))
            compared_mu.append(mu[is_shared])
    return np.concatenate(differences), np.concatenate(compared_mu)


@gate
def directions_differ(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The traction coefficients of positive and negative slip do not have the same size."""
    if run.refusal is not None and run.refusal.rule == "zero_left":
        # which names the cause
        return
    differences = mu_differences_of_directions(run.plateaus)
    median_difference = median(differences)
    if len(differences) >= rig_kind.gate_limits.branch_points and (
        abs(median_difference) > rig_kind.gate_limits.branch_difference_max
    ):
        yield {"difference": median_difference, "points": len(differences)}


# --- warnings

WARNINGS: Gates[RunJudge] = Gates("warnings")

# These say how noise is estimated. How much of it is a warning is in the configuration.
# Readings up to this share of the largest count as small, those from the other share as large.
_SMALL_SHARE = 0.2
_LARGE_SHARE = 0.8
# Quantile that is taken for the largest value, so that wild readings do not count.
_LARGEST_QUANTILE = 0.99
# Number of second differences whose median gives the noise; its standard error is a fifth of it.
_FEWEST_DIFFERENCES = 60
# Number of steps of time that show what interval is the usual one.
_FEWEST_TIME_STEPS = 60


@WARNINGS.gate
def little_traction(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The traction is less than that of usual oils, though not impossible."""
    yield from _small_traction(run, rig_kind, rig_kind.gate_limits.sliding_traction_usual)


@WARNINGS.gate
def zero_on_trust(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """Nothing in settled readings shows that their zero was removed."""
    if run.is_settled and not shows_its_zero(run, rig_kind.zero_settings):
        yield {}


@WARNINGS.gate
def drift_not_seen(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """One part of the run, or both directions of slip, gave the zero: nothing shows its drift."""
    if len(run.zero_phases) == 1:
        (source_of_zero,) = run.zero_phases
        allowed_n = rig_kind.zero_settings.max_drift_n
        largest_n = np.nanmax(np.abs(run.plateaus["traction_force_n"]), initial=0.0)
        if largest_n > 0:
            yield {"part": source_of_zero, "allowed": allowed_n, "share": allowed_n / largest_n}


@WARNINGS.gate
def slip_ramp(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """The slip is a continuous ramp, and the lag of the force was taken off."""
    if run.force_lag is not None:
        lag = run.force_lag
        low_s, high_s = lag.tried_range_s
        if lag.is_seen:
            sentence_name = "lag_seen"
        elif high_s > low_s:
            sentence_name = "lag_not_seen"
        else:
            sentence_name = "lag_stated"
        template = RULES["sentences"][sentence_name]
        yield {
            "lag_in_words": template.format(
                lag=lag.lag_s, error=lag.lag_se_s, low=low_s, high=high_s
            )
        }


@WARNINGS.gate
def branches_apart(run: MeasuredRun, rig_kind: TractionRig) -> FindingFields:
    """Rising and falling slip differ by a share of the traction: something changes with time."""
    differences, mu = _branch_differences(run, rig_kind)
    has_traction = np.abs(mu) > rig_kind.gate_limits.sliding_traction_min
    median_ratio = median(differences[has_traction] / mu[has_traction])
    if (
        has_traction.sum() >= rig_kind.gate_limits.branch_points
        and abs(median_ratio) > rig_kind.gate_limits.branch_ratio_max
    ):
        yield {"ratio": median_ratio, "points": has_traction.sum()}


def _noise_of_samples(run: MeasuredRun) -> FloatArray:
    """Size of the sensor's noise at each sample but the first and last.

    Ramps do not change second differences. These have six times the variance of the noise.

    Returns:
        Shape (samples - 2,); empty for settled readings.
    """
    if run.is_settled:
        return np.empty(0)
    readings = run.running_signals[run.rig_kind.sensor.column]
    return np.abs(np.diff(readings, 2)) / np.sqrt(6)


@WARNINGS.gate
def noisy_sensor(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The readings scatter by a large share of what is measured."""
    noise_of_sample = _noise_of_samples(run)
    noise = MAD_TO_SIGMA * median(noise_of_sample)
    largest_reading = float(np.nanmax(np.abs(run.plateaus[rig_kind.sensor.column]), initial=0.0))
    is_long_enough = len(noise_of_sample) >= _FEWEST_DIFFERENCES
    if is_long_enough and noise > rig_kind.gate_limits.noise_share_max * largest_reading:
        yield {"noise": noise, "share": noise / largest_reading}


@WARNINGS.gate
def soft_saturation(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """The sensor has less noise at its largest readings: its amplifier compresses them."""
    noise_of_sample = _noise_of_samples(run)
    if len(noise_of_sample) == 0:
        return
    reading_sizes = np.abs(run.running_signals[rig_kind.sensor.column][1:-1])
    largest_size = np.quantile(reading_sizes, _LARGEST_QUANTILE)
    is_small = reading_sizes < _SMALL_SHARE * largest_size
    is_large = reading_sizes > _LARGE_SHARE * largest_size
    if is_small.sum() < _FEWEST_DIFFERENCES or is_large.sum() < _FEWEST_DIFFERENCES:
        return
    small_noise = MAD_TO_SIGMA * median(noise_of_sample[is_small])
    large_noise = MAD_TO_SIGMA * median(noise_of_sample[is_large])
    # sensors have the same noise at any reading, and vibrations add to it
    is_compressed = large_noise < rig_kind.gate_limits.noise_left_min * small_noise
    if is_compressed and is_noise(without_repeats(reading_sizes[is_small])):
        yield {"small": small_noise, "large": large_noise}


@WARNINGS.gate
def uneven_clock(run: MeasuredRun, rig_kind: RigKind) -> FindingFields:
    """Rows have a fixed interval, with a few exceptions: a digit of their time may be wrong.

    An earlier gate refuses time stamps that do not increase.
    """
    row_numbers = run.signals.row_numbers
    gaps_s = np.diff(run.signals.time_s)
    row_steps = np.diff(row_numbers)
    if len(gaps_s) < _FEWEST_TIME_STEPS:
        return
    # neighbours: no row between them was refused. The lower median is a step that occurs
    usual_step = np.sort(row_steps)[(len(row_steps) - 1) // 2]
    is_between_neighbours = row_steps == usual_step
    interval_s = run.signals.interval_s
    deviation_s = np.where(is_between_neighbours, np.abs(gaps_s - interval_s), 0.0)
    usual_deviation_s = float(np.quantile(deviation_s[is_between_neighbours], _LARGEST_QUANTILE))
    # a logger's hardware keeps its interval, the timer of a program does not
    scatter_s = rig_kind.gate_limits.clock_scatter_max * interval_s
    limit_s = max(rig_kind.gate_limits.clock_odd_factor * usual_deviation_s, scatter_s)
    odd_indices = np.flatnonzero(deviation_s > limit_s)
    if usual_deviation_s <= scatter_s and len(odd_indices):
        first_odd_index = odd_indices[0]
        yield {
            "interval": interval_s,
            "steps": len(odd_indices),
            "gap": gaps_s[first_odd_index],
            "before": row_numbers[first_odd_index],
            "after": row_numbers[first_odd_index + 1],
        }
