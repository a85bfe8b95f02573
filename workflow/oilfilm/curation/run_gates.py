"""The gates of runs in the order in which they judge: clock, sensors, temperature, way back.

Behind them are the warnings about a run that is used: what is not wrong for certain.

Decides: when a whole run is refused (clock, stuck sensor, sign, temperature drift); warnings about
a run that is used.
"""

from itertools import combinations
from typing import Any

import numpy as np

from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray
from oilfilm.curation.gate import Found, Gate, Gates, RunJudge, fault, refused, unit_hint
from oilfilm.curation.rig_kind import RigKind, Run
from oilfilm.curation.statistics import changed, is_noise, longest_hold, median, rows_per_reading
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Refusal

RUN_GATES: Gates[RunJudge] = Gates()
gate = RUN_GATES.gate

# None of these decides whether a run is refused; the limits that do are in the configuration.
# Two columns of one signal are apart by less than this of its noise: names the cause of a refusal.
_ROUNDED = 0.1
# A signal of fewer values does not move: no hint is given.
_FEWEST_LEVELS = 3
# Readings before and after a hold by which a channel is known to have noise.
_AROUND = 20


def first_fault(run: Run) -> Refusal | None:
    """The refusal by the first gate that refuses a run, if one does."""
    for each in RUN_GATES.of(run.rig.name):
        for found in each.judge(run, run.rig):
            return refused(each.name, _sentence(each, run, found), found)
    if run.flaw is None and len(run.plateaus["time_s"]) == 0:
        return fault("no_plateau")
    return run.flaw


def warnings_about(run: Run) -> tuple[str, ...]:
    """All warnings about a run, each with its name."""
    return tuple(
        f"{each.name}: {_sentence(each, run, found)}"
        for each in WARNINGS.of(run.rig.name)
        for found in each.judge(run, run.rig)
    )


def _sentence(of: Gate[RunJudge], run: Run, found: dict[str, Any]) -> str:
    return of.sentence(run.rig, sensor=run.rig.sensor, **found)


@gate
def time_disorder(run: Run, rig: RigKind) -> Found:
    """The clock stands still or runs backwards."""
    backward = np.flatnonzero(np.diff(run.signals.time_s) <= 0)
    if len(backward):
        place = backward[0]
        before, after = run.signals.time_s[place : place + 2]
        rows = run.signals.rows(place, place + 1)
        yield dict(rows=len(backward), before=before, after=after, **rows)


@gate
def missing_readings(run: Run, rig: RigKind) -> Found:
    """So many rows in one place cannot be read that the run has a hole."""
    row, steps = run.signals.row, np.diff(run.signals.row)
    # a log that writes a slow channel in every twentieth row only has steps of 20 rows
    longest = rig.gates.clock_jump_intervals * median(steps)
    if steps.max(initial=0) > longest:  # of a single row it is NaN
        hole = int(np.argmax(steps))
        yield dict(first=row[hole] + 1, last=row[hole + 1] - 1, allowed=longest - 1)


@gate
def clock_jump(run: Run, rig: RigKind) -> Found:
    """The clock jumps ahead."""
    gaps = np.diff(run.signals.time_s)
    longest_s = rig.gates.clock_jump_intervals * run.signals.interval_s
    # of settled readings without time it is NaN
    if exceeds(gaps.max(initial=0), longest_s):
        longest = int(np.argmax(gaps))
        rows = run.signals.rows(longest, longest + 1)
        yield dict(gap=gaps[longest], allowed=longest_s, **rows)


@gate
def same_channel(run: Run, rig: RigKind) -> Found:
    """A run without a zero has the same readings in two channels."""
    if run.flaw is None or run.flaw.rule != "zero_missing":
        return
    for one, other in combinations(run.rig.channels, 2):
        values = run.signals[one.column]
        apart = np.mean(np.abs(values - run.signals[other.column]))
        # but for the rounding of other units
        if apart <= _ROUNDED * np.mean(np.abs(np.diff(values))):
            yield dict(one=one.name, other=other.name)


@gate
def never_turns(run: Run, rig: RigKind) -> Found:
    """The bearing stands still from the first row to the last."""
    fastest_rpm = float(np.abs(run.signals["inner_speed_rpm"]).max())
    if not fastest_rpm > rig.settings.torque_logs.tare.max_speed_rpm:
        yield dict(fastest=fastest_rpm)


@gate
def held_readings(run: Run, rig: RigKind) -> Found:
    """The sensor is read so slowly that a plateau has few readings of its own."""
    durations = run.plateaus["duration_s"]
    plateau_s = median(durations) if len(durations) else rig.plateaus.min_duration_s
    rows = rows_per_reading(run.signals[run.rig.sensor.column])
    hold_s, fewest = rows * run.signals.interval_s, rig.gates.readings_min
    if rows > 1 and exceeds(fewest * hold_s, plateau_s):
        readings = sum(reaches(plateau_s, hold_s * np.arange(1, fewest)))
        found = dict(rows=rows, hold=hold_s, plateau=plateau_s, readings=readings)
        yield {**found, "fewest": fewest}


@gate
def stuck_channel(run: Run, rig: RigKind) -> Found:
    """A signal that shows noise stops moving for part of the run."""
    for channel in run.rig.channels:
        values = run.working[channel.column]
        start, stop = _long_hold(values, run, rig)
        if start == stop:
            continue
        others = np.delete(values, np.s_[start + 1 : stop])
        updates = changed(others)
        repeats = 1 - len(updates) / len(others)
        # a channel that freezes has its noise up to that row; one that is quiet there has not
        before, after = changed(values[: start + 1])[-_AROUND:], changed(values[stop - 1 :])
        sides = [side for side in (before, after[:_AROUND]) if len(side) > _AROUND / 2]
        noisy = is_noise(updates) and all(map(is_noise, sides))
        if noisy and len(values) * repeats ** (stop - start) < rig.stuck.chance:
            rows = run.working.rows(start, stop - 1)
            yield dict(channel=channel, value=values[start], **rows)


def _long_hold(values: FloatArray, run: Run, rig: RigKind) -> tuple[int, int]:
    """The longest stretch of one value, as `longest_hold`; empty where it is not suspicious."""
    start, stop = longest_hold(values) if len(values) else (0, 0)
    long = reaches((stop - start) * run.signals.interval_s, rig.stuck.duration_s)
    return (start, stop) if long and stop - start >= rig.stuck.samples else (0, 0)


def _sliding(run: Run, rig: TractionRig) -> BoolArray:
    """The plateaus at which the sign and the size of the traction can be judged."""
    return np.asarray(np.abs(run.plateaus["slide_roll_ratio"]) > rig.gates.sign_slip_min)


def _usual_size(run: Run, rig: TractionRig) -> float:
    return median(np.abs(run.plateaus["traction_coefficient"][_sliding(run, rig)]))


@gate
def no_traction(run: Run, rig: TractionRig) -> Found:
    """The traction coefficients of the sliding plateaus are smaller than those of any oil."""
    yield from _small_traction(run, rig, rig.gates.sliding_traction_min)


def _small_traction(run: Run, rig: TractionRig, least: float) -> Found:
    size = _usual_size(run, rig)
    usual, most = rig.gates.sliding_traction_usual, rig.gates.traction_max
    if size < least:
        hint = unit_hint("traction force", lambda newton: usual <= size * newton <= most)
        yield dict(size=size, hint=hint)


@gate
def impossible_traction(run: Run, rig: TractionRig) -> Found:
    """The zero moves, but the traction is too large by more than a zero explains."""
    if run.flaw is None or run.flaw.rule != "zero_drift":
        return
    size, load_n = _usual_size(run, rig), median(run.plateaus["load_n"])
    explained = rig.zero.max_drift_n * rig.gates.significant_errors / load_n
    if size - explained > rig.gates.traction_max:
        yield dict(size=size, flaw=run.flaw.reason)


@gate
def swapped_sign(run: Run, rig: TractionRig) -> Found:
    """The traction force acts against the slip."""
    along = run.plateaus["traction_force_n"] * np.sign(run.plateaus["slide_roll_ratio"])
    along = along[_sliding(run, rig)]
    if median(along) < 0 and (along < 0).mean() >= rig.gates.sign_share:
        yield dict(median=median(along))


@gate
def sign_changes(run: Run, rig: TractionRig) -> Found:
    """The traction force acts against the slip in one part of the run and along it in another."""
    plateaus = run.plateaus
    slip, force_n = plateaus["slide_roll_ratio"], plateaus["traction_force_n"]
    error_n = np.nan_to_num(plateaus["traction_coefficient_se"]) * plateaus["load_n"]
    significant = np.abs(force_n) > rig.gates.significant_errors * error_n
    sure = _sliding(run, rig) & significant
    against = sure & (force_n * slip < 0)
    few = max(rig.gates.faulty_plateaus_min, (1 - rig.gates.sign_share) * sure.sum())
    if reaches(against.sum(), few) and reaches(sure.sum() - few, against.sum()):
        begin, end = np.flatnonzero(against)[[0, -1]]
        rows = dict(first=plateaus["first_row"][begin], last=plateaus["last_row"][end])
        yield dict(against=against.sum(), sliding=sure.sum(), **rows)


def _ways(run: Run, rig: TractionRig) -> list[tuple[FloatArray, FloatArray]]:
    """Rising slips and traction coefficients of each way of a sweep.

    It turns back at its inner extreme; fewer points than `branch_points` on either side of it are
    no way of their own.
    """
    slip, mu = run.plateaus["slide_roll_ratio"], run.plateaus["traction_coefficient"]
    known = np.isfinite(slip) & np.isfinite(mu)
    slip, mu, least = slip[known], mu[known], rig.gates.branch_points
    parts = [slice(None)]
    if len(slip) >= 2 * least:
        extremes = np.array([np.argmax(slip), np.argmin(slip)])
        from_end = np.minimum(extremes, len(slip) - 1 - extremes)
        turn = int(extremes[np.argmax(from_end)])
        if from_end.max() >= least:
            parts = [slice(turn + 1), slice(turn, None)]
    orders = [np.argsort(slip[part], kind="stable") for part in parts]
    return [(slip[part][order], mu[part][order]) for part, order in zip(parts, orders, strict=True)]


def _curves(run: Run, rig: TractionRig) -> list[tuple[FloatArray, FloatArray]]:
    """Those ways of a sweep that have enough points with slip."""
    sliding = [(slip[slip > 0], mu[slip > 0]) for slip, mu in _ways(run, rig)]
    return [curve for curve in sliding if len(curve[0]) >= rig.gates.curve_points_min]


@gate
def order_of_time(run: Run, rig: TractionRig) -> Found:
    """The traction falls to nothing at the largest slip, as if the force ran the other way."""
    for _, mu in _curves(run, rig):
        largest, small, last = mu.max(), mu[:3].max(), mu[-3:]
        falls = -np.diff(last)
        steep = falls.min() > rig.gates.order_fall_max * largest
        far = falls.sum() > (largest - last[-1]) / 2
        if steep and far and small > last[0]:
            yield dict(begin=last[0], end=last[-1], small=small)


@gate
def gain_jump(run: Run, rig: TractionRig) -> Found:
    """The traction jumps between two slips, and changes little on either side."""
    for slip, mu in _curves(run, rig):
        largest, gates = float(np.abs(mu).max()), rig.gates
        for place in range(3, len(slip) - 1):
            before, after = mu[place - 3 : place], mu[place : place + 3]
            jump, range_ = after[0] - before[-1], max(np.ptp(before), np.ptp(after))
            gap = slip[place] - slip[place - 1]
            wide = min(np.ptp(slip[place - 3 : place]), np.ptp(slip[place : place + 3]))
            # where the curve still rises, or one level repeats, nothing is known of its shape
            flat = min(before.min(), after.min()) > largest / 2 and wide > gap / 2
            allowed = max(gates.traction_jump_max * largest, gates.jump_range_factor * range_)
            if flat and abs(jump) > allowed:
                yield dict(jump=jump, before=slip[place - 1], after=slip[place], largest=largest)


@gate
def saturated(run: Run, rig: RigKind) -> Found:
    """A sensor is at the end of its range for part of the run."""
    for channel in (run.rig.sensor, run.rig.channels[0]):
        values = run.working[channel.column]
        for extreme in (values.max(initial=-np.inf), values.min(initial=np.inf)):
            at_stop = np.flatnonzero(values == extreme)
            share = len(at_stop) / max(len(values), 1)
            # a signal that stands there without a break to its end is stuck
            logged = run.signals[channel.column] == extreme
            stuck = np.argmax(logged) + np.count_nonzero(logged) == len(logged)
            if (
                len(at_stop) >= rig.stuck.samples
                and share > rig.gates.saturated_share
                and not stuck
                and _piled_up(values, extreme, rig.gates.piled_up_factor)
                and is_noise(changed(np.delete(values, at_stop)))
            ):
                rows = run.working.rows(at_stop[0], at_stop[-1])
                yield dict(channel=channel, extreme=extreme, share=share, **rows)


def _piled_up(values: FloatArray, extreme: float, factor: float) -> bool:
    """True where an extreme value occurs more than `factor` times as often as the next one.

    A sensor at its stop gives one value again and again, with noise on one side only. Values that
    are coarse anyway are not piled up, nor is the load of a dead weight.
    """
    levels, counts = np.unique(values, return_counts=True)
    end, neighbour = (-1, -2) if extreme == levels[-1] else (0, 1)
    return len(levels) > 1 and bool(counts[end] > factor * counts[neighbour])


@gate
def stuck_sensor(run: Run, rig: RigKind) -> Found:
    """The sensor gives exactly the same reading again and again."""
    values = run.working[run.rig.sensor.column]
    start, stop = _long_hold(values, run, rig)
    if start < stop:
        levels, hint = np.unique(values), ""
        if len(levels) >= _FEWEST_LEVELS and not is_noise(changed(values)):
            step = f"; it moves in steps of {np.diff(levels).min():.2g}"
            hint = f"{step}: log it with more digits, if that is its last one"
        yield dict(value=values[start], hint=hint, **run.working.rows(start, stop - 1))


@gate
def temperature_drift(run: Run, rig: TractionRig) -> Found:
    """The inlet temperature differs between the plateaus of one run."""
    levels = run.plateaus["inlet_temperature_c"]
    least, most = np.fmin.reduce(levels, initial=np.inf), np.fmax.reduce(levels, initial=-np.inf)
    if exceeds(most - least, rig.gates.temperature_drift_max_c):
        yield dict(least=least, most=most)


@gate
def branches_differ(run: Run, rig: TractionRig) -> Found:
    """The traction coefficients of rising and falling slip do not agree."""
    differences, _ = _branches(run, rig)
    # the median, because other gates judge single wild points
    difference = median(np.abs(differences))
    if difference > rig.gates.branch_difference_max:
        yield dict(difference=difference, points=len(differences))


def _branches(run: Run, rig: TractionRig) -> tuple[FloatArray, FloatArray]:
    """Differences of mu between the two ways of a sweep, and mu; empty where it goes one way."""
    (slip, mu), *back = _ways(run, rig)
    for back_slip, back_mu in back:
        low, high = max(slip[0], back_slip[0]), min(slip[-1], back_slip[-1])
        shared = (slip >= low) & (slip <= high)
        if shared.sum() >= rig.gates.branch_points:
            return mu[shared] - np.interp(slip[shared], back_slip, back_mu), mu[shared]
    return mu[:0], mu[:0]


# --- warnings

WARNINGS: Gates[RunJudge] = Gates("warnings")

# How noise is estimated, not how much of it is a warning: small and large readings, over the
# largest; so many readings give it to within a tenth.
_SMALL, _LARGE, _ALMOST_ALL = 0.2, 0.8, 0.99
_CHANGES = 60


@WARNINGS.gate
def little_traction(run: Run, rig: TractionRig) -> Found:
    """The traction is less than oils have, though not impossible."""
    yield from _small_traction(run, rig, rig.gates.sliding_traction_usual)


@WARNINGS.gate
def branches_apart(run: Run, rig: TractionRig) -> Found:
    """Rising and falling slip differ by a share of the traction: something changes with time."""
    differences, mu = _branches(run, rig)
    slides = np.abs(mu) > rig.gates.sliding_traction_min
    ratio = median(differences[slides] / mu[slides])
    if slides.sum() >= rig.gates.branch_points and abs(ratio) > rig.gates.branch_ratio_max:
        yield dict(ratio=ratio, points=slides.sum())


def _noise(run: Run) -> FloatArray:
    """The sensor's noise at each sample but the first and last; empty for settled readings.

    No ramp shows in second differences, which have six times the variance of the noise.
    """
    settled = np.isnan(run.plateaus["duration_s"]).all()
    readings = run.working[run.rig.sensor.column][: 0 if settled else None]
    return np.abs(np.diff(readings, 2)) / np.sqrt(6)


@WARNINGS.gate
def noisy_sensor(run: Run, rig: RigKind) -> Found:
    """The readings scatter by a large share of what is measured."""
    each = _noise(run)
    noise = MAD_TO_SIGMA * median(each)
    largest = float(np.nanmax(np.abs(run.plateaus[run.rig.sensor.column]), initial=0.0))
    if len(each) >= _CHANGES and noise > rig.gates.noise_share_max * largest:
        yield dict(noise=noise, share=noise / largest)


@WARNINGS.gate
def soft_saturation(run: Run, rig: RigKind) -> Found:
    """The sensor has less noise at its largest readings: its amplifier compresses them."""
    noise, size = _noise(run), np.abs(run.working[run.rig.sensor.column][1:-1])
    if len(noise) == 0:
        return
    largest = np.quantile(size, _ALMOST_ALL)
    parts = size < _SMALL * largest, size > _LARGE * largest
    if min(map(np.count_nonzero, parts)) < _CHANGES:
        return
    small, large = (MAD_TO_SIGMA * median(noise[part]) for part in parts)
    # sensors have the same noise at any reading, and vibrations add to it
    if large < rig.gates.noise_left_min * small and is_noise(changed(size[parts[0]])):
        yield dict(small=small, large=large)


@WARNINGS.gate
def uneven_clock(run: Run, rig: RigKind) -> Found:
    """Rows come at a fixed interval, but a few of them do not: a digit of their time may be wrong.

    A clock that runs backwards or stands still is refused before.
    """
    gap_s, step = np.diff(run.signals.time_s), np.diff(run.signals.row)
    if len(gap_s) < _CHANGES:
        return
    beside = step == np.median(step)  # no row between them was refused
    interval_s = run.signals.interval_s
    off_s = np.where(beside, np.abs(gap_s - interval_s), 0.0)
    usual_s = float(np.quantile(off_s[beside], _ALMOST_ALL))
    # a logger's hardware keeps to its interval, the timer of a program does not
    scatter_s = rig.gates.clock_scatter_max * interval_s
    odd = np.flatnonzero(off_s > max(rig.gates.clock_odd_factor * usual_s, scatter_s))
    if usual_s <= scatter_s and len(odd):
        before, after = run.signals.row[[odd[0], odd[0] + 1]]
        gap = dict(gap=gap_s[odd[0]], before=before, after=after)
        yield dict(interval=interval_s, steps=len(odd), **gap)
