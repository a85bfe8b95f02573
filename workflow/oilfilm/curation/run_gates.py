"""The gates of runs in the order in which they judge: clock, sensors, temperature, way back.

Behind them are the warnings about a run that is used: what is not wrong for certain.

Decides: when a whole run is refused (clock, stuck sensor, sign, temperature drift); warnings about
a run that is used.
"""

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np

from oilfilm.curation.gate import (
    Finding,
    Gates,
    Limits,
    Run,
    RunJudge,
    TorqueLimits,
    TractionLimits,
    unit_hint,
)
from oilfilm.curation.statistics import (
    MAD_TO_SIGMA,
    changed,
    is_noise,
    longest_hold,
    median,
    rows_per_reading,
)
from oilfilm.units import FloatArray

RUN_GATES: Gates[RunJudge] = Gates()
gate = RUN_GATES.gate


@gate
def time_disorder(run: Run, limits: Limits) -> Finding | None:
    """The clock stands still or runs backwards."""
    time_s, row = run.signals.time_s, run.signals.row
    backward = np.flatnonzero(np.diff(time_s) <= 0)
    if len(backward) == 0:
        return None
    first = int(backward[0])
    return Finding(
        f"the time stamp does not increase at {len(backward)} rows, first from {time_s[first]:g} s "
        f"at row {row[first]} to {time_s[first + 1]:g} s at row {row[first + 1]}",
        row[first],
        row[first + 1],
    )


@gate
def missing_readings(run: Run, limits: Limits) -> Finding | None:
    """So many rows in one place cannot be read that the run has a hole."""
    row, steps = run.signals.row, np.diff(run.signals.row)
    # a log that writes a slow channel in every twentieth row only has steps of 20 rows
    longest = limits.gates.clock_jump_intervals * median(steps)
    if not steps.max(initial=0) > longest:  # of a single row it is NaN
        return None
    hole = int(np.argmax(steps))
    first, last = row[hole] + 1, row[hole + 1] - 1
    return Finding(
        f"no row from {first} to {last} can be used; expected no gap of more than "
        f"{longest - 1:g} rows",
        first,
        last,
    )


@gate
def clock_jump(run: Run, limits: Limits) -> Finding | None:
    """The clock jumps ahead."""
    gaps = np.diff(run.signals.time_s)
    longest_s = limits.gates.clock_jump_intervals * run.signals.interval_s
    if not gaps.max(initial=0) > longest_s:  # of settled readings without time it is NaN
        return None
    longest = int(np.argmax(gaps))
    before, after = run.signals.row[[longest, longest + 1]]
    return Finding(
        f"{gaps[longest]:g} s pass between row {before} and row {after}; expected no gap over "
        f"{longest_s:g} s",
        before,
        after,
    )


@gate
def same_channel(run: Run, limits: Limits) -> Finding | None:
    """A run without a zero has the same readings in two channels."""
    if run.flaw is None or run.flaw[0] != "zero_missing":
        return None
    for one, other in combinations(run.channels, 2):
        values = run.signals[one.column]
        apart = np.mean(np.abs(values - run.signals[other.column]))
        # but for the rounding of other units
        if apart <= _ROUNDED * np.mean(np.abs(np.diff(values))):
            return Finding(
                f"the {one.name} and the {other.name} are the same in every row; one column may be "
                "taken for both"
            )
    return None


@gate
def never_turns(run: Run, limits: TorqueLimits) -> Finding | None:
    """The bearing stands still from the first row to the last."""
    fastest_rpm = float(np.abs(run.signals["inner_speed_rpm"]).max())
    if fastest_rpm > limits.zero.max_speed_rpm:
        return None
    return Finding(
        f"the bearing never turns: its highest speed is {fastest_rpm:g} rpm; expected more than "
        f"{limits.zero.max_speed_rpm:g} rpm"
    )


# So many standard errors are no chance.
_SURE = 5
# Two columns of one signal are apart by less than this of its noise.
_ROUNDED = 0.1
# So many plateaus are no mishaps of single ones.
_FEW = 3
# With fewer levels a jump of a curve is not told from its shape.
_FEWEST_OF_CURVE = 6
# Each of the two last steps of a curve in the wrong order falls by more than this of the largest.
_FALL = 0.08
# A jump is so many times as large as the range of three levels on either side.
_FLATTER = 5
# A signal of fewer values does not move.
_FEWEST_LEVELS = 3
# The mean of fewer readings has no standard error worth the name.
_FEWEST_READINGS = 5
# Readings before and after a hold that must show noise, too.
_AROUND = 20
# In a sound run a channel with noise is held so long with less than this chance.
_CHANCE = 1e-9


@gate
def held_readings(run: Run, limits: Limits) -> Finding | None:
    """The sensor is read so slowly that a plateau has few readings of its own."""
    durations = run.plateaus["duration_s"]
    plateau_s = median(durations) if len(durations) else limits.plateaus.min_duration_s
    rows = rows_per_reading(run.signals[run.sensor.column])
    hold_s = rows * run.signals.interval_s
    if rows == 1 or not plateau_s < _FEWEST_READINGS * hold_s:
        return None
    return Finding(
        f"each value of the {run.sensor.name} is repeated in {rows} rows ({hold_s:.2g} s): it is "
        f"read more slowly than the logger writes, and a plateau of {plateau_s:.2g} s has "
        f"{int(plateau_s / hold_s)} of its readings; expected {_FEWEST_READINGS} or more"
    )


@gate
def stuck_channel(run: Run, limits: Limits) -> Finding | None:
    """A signal that shows noise stops moving for part of the run."""
    row = run.working.row
    for channel in run.channels:
        values = run.working[channel.column]
        hold = _long_hold(values, run, limits)
        if hold is None:
            continue
        start, stop = hold
        others = np.delete(values, np.s_[start + 1 : stop])
        updates = changed(others)
        repeats = 1 - len(updates) / len(others)
        # a channel that freezes has its noise up to that row; one that is quiet there has not
        before, after = changed(values[: start + 1])[-_AROUND:], changed(values[stop - 1 :])
        sides = [side for side in (before, after[:_AROUND]) if len(side) > _AROUND / 2]
        noisy = is_noise(updates) and all(map(is_noise, sides))
        if noisy and len(values) * repeats ** (stop - start) < _CHANCE:
            first, last = row[[start, stop - 1]]
            return Finding(
                f"the {channel.name} is exactly {values[start]:g} {channel.unit} from row {first} "
                f"to row {last}, but has noise in the rest of the run",
                first,
                last,
            )
    return None


def _long_hold(values: FloatArray, run: Run, limits: Limits) -> tuple[int, int] | None:
    """The longest stretch of one value, as `longest_hold`; None where it is not suspicious."""
    start, stop = longest_hold(values) if len(values) else (0, 0)
    long = (stop - start) * run.signals.interval_s >= limits.stuck.duration_s
    return (start, stop) if long and stop - start >= limits.stuck.samples else None


@gate
def no_traction(run: Run, limits: TractionLimits) -> Finding | None:
    """The traction coefficients of the sliding plateaus are smaller than those of any oil."""
    sentence = _small_traction(run, limits, limits.gates.sliding_traction_min)
    return Finding(sentence) if sentence else None


def _small_traction(run: Run, limits: TractionLimits, least: float) -> str:
    """Sentence about a median traction coefficient below a limit; empty where it is not."""
    slip, mu = run.plateaus["slide_roll_ratio"], run.plateaus["traction_coefficient"]
    size = median(np.abs(mu[np.abs(slip) > limits.gates.sign_slip_min]))
    if not size < least:
        return ""
    usual, most = limits.gates.sliding_traction_usual, limits.gates.traction_max
    hint = unit_hint("traction force", lambda newton: usual <= size * newton <= most)
    return (
        f"the median traction coefficient above a slip of {limits.gates.sign_slip_min:g} is "
        f"{size:.2g}; expected {least:g} or more{hint}"
    )


@gate
def impossible_traction(run: Run, limits: TractionLimits) -> Finding | None:
    """The zero moves, but the traction is too large by more than a zero explains."""
    if run.flaw is None or run.flaw[0] != "zero_drift":
        return None
    slip, mu = run.plateaus["slide_roll_ratio"], run.plateaus["traction_coefficient"]
    size = median(np.abs(mu[np.abs(slip) > limits.gates.sign_slip_min]))
    drift = limits.zero_drift_max * _SURE / median(run.plateaus["load_n"])
    if not size - drift > limits.gates.traction_max:
        return None
    return Finding(
        f"the median traction coefficient above a slip of {limits.gates.sign_slip_min:g} is "
        f"{size:.2g}; expected {limits.gates.traction_max:g} or less. Beside that, "
        f"{run.flaw[1].sentence}"
    )


@gate
def swapped_sign(run: Run, limits: TractionLimits) -> Finding | None:
    """The traction force acts against the slip."""
    slip = run.plateaus["slide_roll_ratio"]
    sliding = np.abs(slip) > limits.gates.sign_slip_min
    along = run.plateaus["traction_force_n"][sliding] * np.sign(slip[sliding])
    median_n = median(along) if len(along) else 0.0
    if not median_n < 0 or (along < 0).mean() < limits.gates.sign_share:
        return None
    return Finding(
        f"the traction force acts against the slip (median {median_n:.3g} N); expected the slower "
        "body to be dragged along"
    )


@gate
def sign_changes(run: Run, limits: TractionLimits) -> Finding | None:
    """The traction force acts against the slip in one part of the run and along it in another."""
    plateaus = run.plateaus
    slip, force_n = plateaus["slide_roll_ratio"], plateaus["traction_force_n"]
    error_n = _SURE * np.nan_to_num(plateaus["traction_coefficient_se"]) * plateaus["load_n"]
    sure = (np.abs(slip) > limits.gates.sign_slip_min) & (np.abs(force_n) > error_n)
    against = sure & (force_n * slip < 0)
    few = max(_FEW, (1 - limits.gates.sign_share) * sure.sum())
    if not few <= against.sum() <= sure.sum() - few:
        return None
    first, last = np.flatnonzero(against)[[0, -1]]
    return Finding(
        f"the traction force acts against the slip on {against.sum()} of {sure.sum()} sliding "
        "plateaus and along it on the others; the speeds of ball and disc or the polarity of the "
        "force may have been exchanged within the run",
        plateaus["first_row"][first],
        plateaus["last_row"][last],
    )


def _ways(run: Run, limits: TractionLimits) -> list[tuple[FloatArray, FloatArray]]:
    """Rising slips and traction coefficients of each way of a sweep.

    It turns back at its inner extreme; fewer points than `branch_points` on either side of it are
    no way of their own.
    """
    slip, mu = run.plateaus["slide_roll_ratio"], run.plateaus["traction_coefficient"]
    known = np.isfinite(slip) & np.isfinite(mu)
    slip, mu, least = slip[known], mu[known], limits.gates.branch_points
    parts = [slice(None)]
    if len(slip) >= 2 * least:
        extremes = np.array([np.argmax(slip), np.argmin(slip)])
        from_end = np.minimum(extremes, len(slip) - 1 - extremes)
        turn = int(extremes[np.argmax(from_end)])
        if from_end.max() >= least:
            parts = [slice(turn + 1), slice(turn, None)]
    orders = [np.argsort(slip[part], kind="stable") for part in parts]
    return [(slip[part][order], mu[part][order]) for part, order in zip(parts, orders, strict=True)]


def _curves(run: Run, limits: TractionLimits) -> list[tuple[FloatArray, FloatArray]]:
    """Those ways of a sweep that have enough points with slip."""
    sliding = [(slip[slip > 0], mu[slip > 0]) for slip, mu in _ways(run, limits)]
    return [curve for curve in sliding if len(curve[0]) >= _FEWEST_OF_CURVE]


@gate
def order_of_time(run: Run, limits: TractionLimits) -> Finding | None:
    """The traction falls to nothing at the largest slip, as if the force ran the other way."""
    for _, mu in _curves(run, limits):
        largest, last = mu.max(), mu[-3:]
        falls = -np.diff(last)
        steep = falls.min() > _FALL * largest and falls.sum() > (largest - last[-1]) / 2
        if steep and mu[:3].max() > last[0]:
            return Finding(
                f"the traction coefficient falls from {last[0]:.4f} to {last[-1]:.4f} over the "
                f"three largest slips, below {mu[:3].max():.4f} at small ones: force and slip may "
                "run in opposite orders of time"
            )
    return None


@gate
def gain_jump(run: Run, limits: TractionLimits) -> Finding | None:
    """The traction jumps between two slips, and changes little on either side."""
    for slip, mu in _curves(run, limits):
        largest, allowed = float(np.abs(mu).max()), limits.gates.traction_jump_max
        for place in range(3, len(slip) - 1):
            before, after = mu[place - 3 : place], mu[place : place + 3]
            jump, range_ = after[0] - before[-1], max(np.ptp(before), np.ptp(after))
            gap = slip[place] - slip[place - 1]
            wide = min(np.ptp(slip[place - 3 : place]), np.ptp(slip[place : place + 3]))
            # where the curve still rises, or one level repeats, nothing is known of its shape
            flat = min(before.min(), after.min()) > largest / 2 and wide > gap / 2
            if flat and abs(jump) > max(allowed * largest, _FLATTER * range_):
                return Finding(
                    f"the traction coefficient jumps by {jump:.4f} between slide-roll ratios of "
                    f"{slip[place - 1]:.4f} and {slip[place]:.4f}, and is flat on either side; "
                    f"allowed {allowed:.0%} of the largest, {largest:.4f}"
                )
    return None


@gate
def saturated(run: Run, limits: Limits) -> Finding | None:
    """A sensor is at the end of its range for part of the run."""
    row = run.working.row
    for channel in (run.sensor, run.load):
        values = run.working[channel.column]
        for extreme in (values.max(initial=-np.inf), values.min(initial=np.inf)):
            at_stop = np.flatnonzero(values == extreme)
            share = len(at_stop) / max(len(values), 1)
            # a signal that stands there without a break to its end is stuck
            logged = run.signals[channel.column] == extreme
            stuck = np.argmax(logged) + np.count_nonzero(logged) == len(logged)
            if (
                len(at_stop) >= limits.stuck.samples
                and share > limits.gates.saturated_share
                and not stuck
                and _piled_up(values, extreme, limits.gates.piled_up_factor)
                and is_noise(changed(np.delete(values, at_stop)))
            ):
                first, last = row[at_stop[[0, -1]]]
                return Finding(
                    f"the {channel.name} is at its extreme of {extreme:g} {channel.unit} in "
                    f"{share:.1%} of the rows, between row {first} and row {last}; allowed "
                    f"{limits.gates.saturated_share:.1%}",
                    first,
                    last,
                )
    return None


def _piled_up(values: FloatArray, extreme: float, factor: float) -> bool:
    """True where an extreme value occurs more than `factor` times as often as the next one.

    A sensor at its stop gives one value again and again, with noise on one side only. Values that
    are coarse anyway are not piled up, nor is the load of a dead weight.
    """
    levels, counts = np.unique(values, return_counts=True)
    end, neighbour = (-1, -2) if extreme == levels[-1] else (0, 1)
    return len(levels) > 1 and bool(counts[end] > factor * counts[neighbour])


@gate
def stuck_sensor(run: Run, limits: Limits) -> Finding | None:
    """The sensor gives exactly the same reading again and again."""
    values, row = run.working[run.sensor.column], run.working.row
    hold = _long_hold(values, run, limits)
    if hold is None:
        return None
    start, stop = hold
    first, last = row[[start, stop - 1]]
    return Finding(
        f"the {run.sensor.name} is exactly {values[start]:g} {run.sensor.unit} from row {first} to "
        f"row {last}; expected noise within {limits.stuck.duration_s:g} s{_few_digits(values)}",
        first,
        last,
    )


def _few_digits(values: FloatArray) -> str:
    """A hint where a signal does move, but in steps of its last digit."""
    levels = np.unique(values)
    if len(levels) < _FEWEST_LEVELS or is_noise(changed(values)):
        return ""
    return (
        f"; it moves in steps of {np.diff(levels).min():.2g}: log it with more digits, if that is "
        "its last one"
    )


@gate
def temperature_drift(run: Run, limits: TractionLimits) -> Finding | None:
    """The inlet temperature differs between the plateaus of one run."""
    levels = run.plateaus["inlet_temperature_c"]
    levels = levels[~np.isnan(levels)]
    allowed_c = limits.gates.temperature_drift_max_c
    if len(levels) == 0 or levels.max() - levels.min() <= allowed_c:
        return None
    return Finding(
        f"the inlet temperature goes from {levels.min():.1f} to {levels.max():.1f} degC within the "
        f"run; allowed {allowed_c:g} degC"
    )


@gate
def branches_differ(run: Run, limits: TractionLimits) -> Finding | None:
    """The traction coefficients of rising and falling slip do not agree."""
    differences, _ = _branches(run, limits)
    # the median, because other gates judge single wild points
    difference = median(np.abs(differences)) if len(differences) else 0.0
    if difference <= limits.gates.branch_difference_max:
        return None
    return Finding(
        f"with rising and falling slip the traction coefficients differ by {difference:.4f} "
        f"(median over {len(differences)} points); allowed {limits.gates.branch_difference_max:g}"
    )


def _branches(run: Run, limits: TractionLimits) -> tuple[FloatArray, FloatArray]:
    """Differences of mu between the two ways of a sweep, and mu; empty where it goes one way."""
    (slip, mu), *back = _ways(run, limits)
    for back_slip, back_mu in back:
        low, high = max(slip[0], back_slip[0]), min(slip[-1], back_slip[-1])
        shared = (slip >= low) & (slip <= high)
        if shared.sum() >= limits.gates.branch_points:
            return mu[shared] - np.interp(slip[shared], back_slip, back_mu), mu[shared]
    return mu[:0], mu[:0]


# --- warnings

# A share of the largest plateau by which readings seldom scatter.
_NOISY = 0.03
# Small and large readings, over the largest; so many give the noise to within a tenth.
_SMALL, _LARGE, _ALMOST_ALL = 0.2, 0.8, 0.99
_CHANGES = 60
# Sensors have the same noise at any reading, and vibrations add to it.
_NOISE_LEFT = 0.6
# A fixed interval is kept to so much of it: a logger's hardware does, a program's timer does not.
_FIXED = 0.03
# Steps this many times further off than almost all others are not its rounding.
_FAR_OFF = 3


def little_traction(run: Run, limits: TractionLimits) -> str:
    """The traction is less than oils have, though not impossible."""
    return _small_traction(run, limits, limits.gates.sliding_traction_usual)


def branches_apart(run: Run, limits: TractionLimits) -> str:
    """Rising and falling slip differ by a share of the traction: something changes with time."""
    differences, mu = _branches(run, limits)
    slides = np.abs(mu) > limits.gates.sliding_traction_min
    ratio = median(differences[slides] / mu[slides])
    if slides.sum() < limits.gates.branch_points or abs(ratio) <= limits.gates.branch_ratio_max:
        return ""
    return (
        f"with rising slip the traction coefficients are {ratio:+.1%} from those with falling slip "
        f"(median over {slides.sum()} points); the gain of a sensor or the contact may change with "
        "time"
    )


def _noise(run: Run) -> FloatArray:
    """The sensor's noise at each sample but the first and last; empty for settled readings.

    No ramp shows in second differences, which have six times the variance of the noise.
    """
    settled = np.isnan(run.plateaus["duration_s"]).all()
    readings = run.working[run.sensor.column][: 0 if settled else None]
    return np.abs(np.diff(readings, 2)) / np.sqrt(6)


def soft_saturation(run: Run, limits: Limits) -> str:
    """The sensor has less noise at its largest readings: its amplifier compresses them."""
    noise, size = _noise(run), np.abs(run.working[run.sensor.column][1:-1])
    if len(noise) == 0:
        return ""
    largest = np.quantile(size, _ALMOST_ALL)
    parts = size < _SMALL * largest, size > _LARGE * largest
    if min(map(np.count_nonzero, parts)) < _CHANGES:
        return ""
    small, large = (MAD_TO_SIGMA * median(noise[part]) for part in parts)
    if large >= _NOISE_LEFT * small or not is_noise(changed(size[parts[0]])):
        return ""
    name, unit = run.sensor.name, run.sensor.unit
    return (
        f"the noise of the {name} falls from {small:.2g} {unit} at small to {large:.2g} {unit} at "
        "large readings; the sensor or its amplifier may be near the end of its range and give too "
        "little there"
    )


def noisy_sensor(run: Run, limits: Limits) -> str:
    """The readings scatter by a large share of what is measured."""
    each, name = _noise(run), run.sensor.name
    noise = MAD_TO_SIGMA * median(each)
    largest = float(np.nanmax(np.abs(run.plateaus[run.sensor.column]), initial=0.0))
    if len(each) < _CHANGES or not noise > _NOISY * largest:
        return ""
    return (
        f"the readings of the {name} scatter by {noise:.2g} {run.sensor.unit}, "
        f"{noise / largest:.0%} of the largest plateau; a cable, the amplifier or vibration may "
        "disturb the sensor"
    )


def uneven_clock(run: Run, limits: Limits) -> str:
    """Rows come at a fixed interval, but a few of them do not: a digit of their time may be wrong.

    A clock that runs backwards or stands still is refused before.
    """
    gap_s, step = np.diff(run.signals.time_s), np.diff(run.signals.row)
    if len(gap_s) < _CHANGES:
        return ""
    beside = step == np.median(step)  # no row between them was refused
    interval_s = run.signals.interval_s
    off_s = np.where(beside, np.abs(gap_s - interval_s), 0.0)
    usual_s = float(np.quantile(off_s[beside], _ALMOST_ALL))
    odd = np.flatnonzero(off_s > max(_FAR_OFF * usual_s, _FIXED * interval_s))
    if usual_s > _FIXED * interval_s or len(odd) == 0:
        return ""
    first = int(odd[0])
    before, after = run.signals.row[[first, first + 1]]
    return (
        f"rows come every {interval_s:g} s, but {gap_s[first]:g} s pass between row {before} and "
        f"row {after} ({len(odd)} such steps); a digit of the time may be wrong, or rows are lost"
    )


_OF_TRACTION = (little_traction, branches_apart)
DOUBTS: dict[str, Callable[[Run, Any], str]] = {
    each.__name__: each for each in (*_OF_TRACTION, noisy_sensor, soft_saturation, uneven_clock)
}


def warning(run: Run, limits: Limits) -> str:
    """All warnings about a run, each with its name; empty where there is none."""
    traction = isinstance(limits, TractionLimits)
    asked = {name: doubt for name, doubt in DOUBTS.items() if traction or doubt not in _OF_TRACTION}
    found = {name: doubt(run, limits) for name, doubt in asked.items()}
    return "; ".join(f"{name}: {sentence}" for name, sentence in found.items() if sentence)
