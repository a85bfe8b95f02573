"""Continuous ramps of slip: the traction coefficient at chosen slips, less the lag of the force.

On a ramp no slip is held. The force is logged behind the slip, because the sensor, its filter and
the film answer late. So the force in a row is not that of the slip in this row. The curve of mu,
the zero of the sensor and the lag are found together, by least squares on all rows:

    F(t) = zero + drift t + L_lag [W(t) m(|S(t)|) sign(S(t))]

m is a cubic spline with m(0) = 0. L_lag is a filter of first order, a delay, or both. Where rising
and falling slip meet the same slips, the lag is that with which both agree. Where they do not,
nothing in the run shows the lag. Then it is anywhere in a range, and the error of mu holds what
that means.

Decides: what a ramp is; the slips at which a ramp gives points; the lag of the force behind the
slip and its error; when a run shows its lag.

Sources: G. Golub, V. Pereyra, Inverse Problems 19 (2003) R1 (a curve is fitted anew to each lag);
S. Julier, J. Uhlmann, Proc. IEEE 92 (2004) 401 (points that stand for a covariance); G. Schwarz,
Ann. Statist. 6 (1978) 461 (weights of two spacings of knots).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray, IndexArray
from oilfilm.curation.rig_kind import ForceLag, Run, Signals
from oilfilm.curation.statistics import Stretches, mean_with_error, median
from oilfilm.curation.zero import phase_too_short
from oilfilm.logs.base import Refusal
from oilfilm.settings.config import PlateauSettings, ZeroReferenceSettings

# --- what a ramp is

# Held levels in a larger share of the sliding time show a log of steps.
_LARGEST_HELD_SHARE = 1 / 4
# Most of the way of the slip, and the smallest share of the time in which a ramp covers so much of
# it: 0.8 for a straight ramp, 0.59 for a sine. Steps cover it in less than 0.3.
_MOST_OF_THE_WAY = 0.8
_LEAST_SHARE_OF_TIME = 0.4
# Way of the slip over that between its turns. The noise of a slow body makes more.
_LONGEST_WAY = 1.3
# Share of the time that has most of the squared changes over a short time: 0.4 for noise, 0.5 for a
# sine. Steps that are smaller than those which are looked for have less than 0.15.
_SHORT_S = 0.2
_LEAST_SHARE_OF_SQUARES = 0.25
# Share of the changes that a single fall to rolling makes at most.
_SHARE_OF_A_FALL = 0.02
# Windows in which the way is counted.
_WINDOWS = 200
# A ramp by equal factors is straight in asinh(S/0.01).
_SLIP_SCALE = 0.01
# Fewer sliding rows show no ramp, and fewer rows of a way up or down give no curve.
_FEWEST_ROWS = 30
# Fewer slips that are resolved give no curve of mu.
FEWEST_READINGS = 5

# --- how a ramp is measured

# More rows are averaged to so many, which is enough for a curve.
_MOST_ROWS = 1000
# The slip is smoothed by parabolas over this time, and so many rows at least.
_SMOOTHED_S = 0.8
_FEWEST_SMOOTHED = 5
# Fewer rows between half a slip and the slip do not resolve it.
_FEWEST_TO_RESOLVE = 7
# The slip turns a corner where it is so many standard deviations of noise off the smooth one.
_CORNER_ERRORS = 4.0
# The slip turns back where it returns by so much of the largest slip.
_TURN_SHARE = 0.1
# Ratios of neighbouring knots of the spline. The curve must not depend on them: both are tried.
_KNOT_RATIOS = (1.4, 1.7)
_FIRST_KNOT = 0.0015
# Rows between two knots.
_ROWS_PER_KNOT = 4
_CUBIC = 3
# What spline, kind of lag and smoothing leave of mu, relative, beside noise: 24 simulated ramps of
# two curves that no law has are off by 0.1 to 0.4 %, all their points alike.
_CURVE_ERROR = 0.003
# Relative size below which a column counts as empty.
_EMPTY_COLUMN = 1e-10
# A filter with a time constant below this share of a row changes nothing.
_NO_FILTER = 1e-3
# Where the lag is not seen: lags that stand for its range, and shares of a filter in them.
_LAGS_TRIED = 9
_FILTER_SHARES = (0.0, 0.5, 1.0)
# Steps of the search of a lag.
_MOST_STEPS = 30
# Sensors of one row may be read so many rows apart.
_APART_IN_A_ROW = 0.5
# A spike is beside the median of so many readings.
_NEIGHBOURS = 9
# Rising and falling slip show the lag where both cover so much of the slips.
_COVERED_SHARE = 1 / 2
# A lag that is found beyond this share of its range may be longer.
LARGEST_SHARE_OF_RANGE = 0.95


@dataclass(frozen=True)
class RampReadings:
    """Traction coefficients at slips that a ramp passes.

    Attributes:
        slip: Slide-roll ratio with its sign, shape (readings,).
        mu: Traction coefficient with the sign of the slip, less the zero, shape (readings,).
        mu_se: Its standard error, which contains that of the method, shape (readings,).
        starts: Index of the first sample that is nearest to this slip, shape (readings,).
        stops: Index after the last one, shape (readings,).
        spikes: Number of spikes of the force between them, shape (readings,).
        lag: The lag of the force.
        drift_n: Change of the zero from the first row to the last; 0 where none was asked for.
    """

    slip: FloatArray
    mu: FloatArray
    mu_se: FloatArray
    starts: IndexArray
    stops: IndexArray
    spikes: IndexArray
    lag: ForceLag
    drift_n: float


@dataclass(frozen=True)
class _Ramp:
    """The rows of a ramp, averaged where there are many, each array of shape (rows,).

    Attributes:
        time: Time from 0 to 1.
        interval_s: Time between rows.
        slip: Slide-roll ratio, smoothed.
        slip_noise: Standard deviation of its noise.
        force_n: Traction force.
        load_n: Load.
        weight: Weight of a row in sums of residuals: one over its standard deviation.
        way: Number of the way on which the size of the slip rises or falls.
        samples_per_row: Samples that are averaged to a row.
    """

    time: FloatArray
    interval_s: float
    slip: FloatArray
    slip_noise: float
    force_n: FloatArray
    load_n: FloatArray
    weight: FloatArray
    way: IndexArray
    samples_per_row: int


@dataclass(frozen=True)
class _Trial:
    """A lag with which the curve is read, beside others.

    Attributes:
        knots: Slips between which the spline is one polynomial, shape (knots,).
        filter_s: Time constant of the filter.
        delay_s: The delay.
        weight: Its share in the answer.
    """

    knots: FloatArray
    filter_s: float
    delay_s: float
    weight: float

    @property
    def lag_s(self) -> float:
        """Time by which a straight ramp is late."""
        return self.filter_s + self.delay_s


def is_ramp(
    run: Run, plateau_settings: PlateauSettings, rolling_slip: float, is_held: BoolArray
) -> bool:
    """Whether the slip of a run moves all the time, in place of steps.

    Args:
        run: The run, divided into levels.
        plateau_settings: `min_duration_s`, the shortest level.
        rolling_slip: Slip below which the rig rolls.
        is_held: Plateaus whose slip is steady, shape (plateaus,).
    """
    slip = run.working["slide_roll_ratio"]
    sliding_rows = np.flatnonzero(np.abs(slip) > rolling_slip)
    if len(sliding_rows) < _FEWEST_ROWS:
        return False
    sliding_s = len(sliding_rows) * run.signals.interval_s
    is_level = is_held & (np.abs(run.plateaus["slide_roll_ratio"]) > rolling_slip)
    is_level &= run.plateaus["duration_s"] >= plateau_settings.min_duration_s
    if run.plateaus["duration_s"][is_level].sum() > _LARGEST_HELD_SHARE * sliding_s:
        return False
    sliding_slip = slip[sliding_rows[0] : sliding_rows[-1] + 1]
    scales = (sliding_slip, np.arcsinh(sliding_slip / _SLIP_SCALE))
    if max(_share_of_time(scale) for scale in scales) < _LEAST_SHARE_OF_TIME:
        return False
    if not _goes_straight(sliding_slip):
        return False
    rows = max(round(_SHORT_S / run.signals.interval_s), 1)
    return max(_share_of_squares(scale, rows) for scale in scales) >= _LEAST_SHARE_OF_SQUARES


def _share_of_time(signal: FloatArray) -> float:
    """Smallest share of the time in which a signal covers most of its way."""
    means = _block_means(signal, max(len(signal) // _WINDOWS, 1))
    return _smallest_share(np.abs(np.diff(means)))


def _goes_straight(signal: FloatArray) -> bool:
    """Whether a signal goes from turn to turn, so that its way is none of noise."""
    means = _block_means(signal, max(len(signal) // _WINDOWS, 1))
    size = np.abs(means)
    corners = size[[0, *_turns(size), len(size) - 1]]
    way = np.abs(np.diff(size)).sum()
    return bool(way <= _LONGEST_WAY * np.abs(np.diff(corners)).sum())


def _share_of_squares(signal: FloatArray, rows: int) -> float:
    """Smallest share of the time that has most of the squared changes over so many rows.

    Small steps have them at their edges, a ramp all the time. A single fall to rolling is left out.
    """
    squares = np.sort(np.diff(_block_means(signal, rows)) ** 2)
    return _smallest_share(squares[: round((1 - _SHARE_OF_A_FALL) * len(squares))])


def _smallest_share(changes: FloatArray) -> float:
    """Smallest share of changes that add up to most of their sum."""
    running_sum = np.cumsum(np.sort(changes)[::-1])
    if len(running_sum) == 0 or running_sum[-1] == 0:
        return 0.0
    return float(
        (1 + np.searchsorted(running_sum, _MOST_OF_THE_WAY * running_sum[-1])) / len(running_sum)
    )


@dataclass(frozen=True)
class RampZero:
    """How the zero of the force of a ramp is found.

    Attributes:
        terms: 0 where the force has no zero left, 1 for a zero, 2 for a zero with a drift.
        phases: What shows the zero, in words.
        flaw: Why nothing shows it; None where something does.
    """

    terms: int
    phases: tuple[str, ...] = ()
    flaw: Refusal | None = None


def rolling_zero(
    signals: Signals, source: str, window_s: float, settings: ZeroReferenceSettings
) -> RampZero:
    """How the zero is found: by rolling at the ends of a ramp, or by both directions of slip.

    Args:
        signals: The rows of the ramp, rolling included.
        source: `semantics: zero` of the campaign.
        window_s: Time over which the slip is averaged to find rolling.
        settings: Shortest phase of rolling, and its largest slip.
    """
    if source in ("standstill", "already_removed"):
        return RampZero(terms=0)
    phases = rolling_ends(signals, window_s, settings)
    needed = ("opening",) if source == "opening_phase" else ("opening", "closing")
    for name in needed:
        phase_in_words = f"{name} phase of pure rolling"
        flaw = phase_too_short(signals, phases[name], phase_in_words, settings.min_duration_s)
        if flaw is not None:
            if _slides_both_ways(signals["slide_roll_ratio"]):
                # a drift looks like a part of the curve
                return RampZero(terms=1, phases=("both directions of slip",))
            return RampZero(terms=0, flaw=flaw)
    return RampZero(terms=len(needed), phases=needed)


def rolling_ends(
    signals: Signals, window_s: float, settings: ZeroReferenceSettings
) -> dict[str, slice]:
    """The samples before and after the sliding part of a ramp, by the name of the phase.

    Args:
        signals: The rows of the ramp, rolling included.
        window_s: Time over which the slip is averaged to find rolling.
        settings: Largest slip of rolling.
    """
    slip = signals["slide_roll_ratio"]
    rows = max(round(window_s / signals.interval_s), 1)
    mean_slip = scipy.ndimage.uniform_filter1d(slip, rows, mode="nearest")
    sliding_rows = np.flatnonzero(np.abs(mean_slip) > settings.max_slide_roll_ratio)
    if len(sliding_rows) == 0:
        # a slip that alternates faster than the window has no ends of rolling
        return {"opening": slice(0, 0), "closing": slice(0, 0)}
    return {
        "opening": slice(0, int(sliding_rows[0])),
        "closing": slice(int(sliding_rows[-1]) + 1, len(slip)),
    }


def _slides_both_ways(slip: FloatArray) -> bool:
    """Whether a run slides in both directions, so that what they have in common is the zero."""
    reach = min(slip.max(initial=0.0), -slip.min(initial=0.0))
    return bool(reach >= _COVERED_SHARE * np.abs(slip).max(initial=0.0) > 0)


def ramp_readings(
    signals: Signals,
    lag_range_s: Sequence[float],
    zero_terms: int,
    least_slip: float,
    spike_threshold: float,
) -> RampReadings | None:
    """Traction coefficients on a ramp; None where it resolves too few slips.

    Args:
        signals: Its rows, rolling included, one after the other.
        lag_range_s: Smallest and largest lag of the force behind the slip.
        zero_terms: 0 where the force has no zero left, 1 for a zero, 2 for a zero with a drift.
        least_slip: Smallest slip at which a point is given.
        spike_threshold: Threshold of a spike of the force, in robust standard deviations.
    """
    force_n, is_spike = _without_spikes(signals["traction_force_n"], spike_threshold)
    ramp = _averaged(signals, force_n)
    shortest_lag_s, longest_lag_s = lag_range_s
    is_seen = longest_lag_s > shortest_lag_s and _shows_its_lag(ramp)
    ramp = _weighted(ramp, longest_lag_s, zero_terms)
    trials, variance, is_seen = _weighted_trials(
        ramp, shortest_lag_s, longest_lag_s, zero_terms, is_seen
    )
    slips, ways = _slips_of_ways(ramp, trials[0].knots, least_slip)
    if len(slips) < FEWEST_READINGS:
        return None
    values, errors, drifts = [], [], []
    for trial in trials:
        value, error, drift = _curve_of_trial(ramp, trial, zero_terms, variance, slips, ways)
        values.append(value)
        errors.append(error)
        drifts.append(drift)
    weights = np.array([trial.weight for trial in trials])
    mu, mu_se = _mean_of_trials(np.array(values), np.array(errors), weights)
    lags_s = np.array([trial.lag_s for trial in trials])
    lag_s, lag_se_s = _mean_of_trials(lags_s, np.zeros(len(lags_s)), weights)
    starts, stops = _rows_of_readings(ramp, slips, ways)
    signs = np.array([np.sign(median(ramp.slip[ramp.way == way])) for way in ways])
    has_rows = stops > starts
    starts = starts[has_rows] * ramp.samples_per_row
    stops = stops[has_rows] * ramp.samples_per_row
    stretches = Stretches(starts, stops)
    return RampReadings(
        slip=(signs * slips)[has_rows],
        mu=(signs * mu)[has_rows],
        mu_se=np.hypot(mu_se, _CURVE_ERROR * mu)[has_rows],
        starts=starts,
        stops=stops,
        spikes=stretches.counts(stretches.cut(is_spike.astype(float)) > 0),
        lag=ForceLag(float(lag_s), float(lag_se_s), is_seen, (shortest_lag_s, longest_lag_s)),
        drift_n=float(weights @ np.array(drifts)),
    )


def _mean_of_trials(
    values: FloatArray, errors: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean over trials, and its standard error: their own errors and how far they are apart.

    Args:
        values: Values of each trial, shape (trials, ...).
        errors: Their standard errors, of the same shape.
        weights: Weights of sum 1, shape (trials,).
    """
    mean = weights @ values
    return mean, np.sqrt(weights @ errors**2 + weights @ (values - mean) ** 2)


def _without_spikes(force_n: FloatArray, threshold: float) -> tuple[FloatArray, BoolArray]:
    """The force with the median of its neighbours in place of spikes, and the mask of spikes."""
    smooth = scipy.ndimage.median_filter(force_n, _NEIGHBOURS, mode="nearest")
    # a force without noise has no spikes
    limit_n = threshold * _noise(force_n) or np.inf
    is_spike = np.abs(force_n - smooth) > limit_n
    return np.where(is_spike, smooth, force_n), is_spike


def _block_means(signal: FloatArray, length: int) -> FloatArray:
    """Means of blocks of so many samples; what is left at the end is dropped."""
    count = len(signal) // length
    return signal[: count * length].reshape(count, length).mean(axis=1)


def _averaged(signals: Signals, force_n: FloatArray) -> _Ramp:
    """The rows of a ramp, averaged over blocks where there are many."""
    samples_per_row = -(-len(signals) // _MOST_ROWS)
    slip = _block_means(signals["slide_roll_ratio"], samples_per_row)
    interval_s = signals.interval_s * samples_per_row
    # at low slip the noise of the slip is a large force
    window = max(2 * round(_SMOOTHED_S / interval_s / 2) + 1, _FEWEST_SMOOTHED)
    parabola = scipy.signal.savgol_coeffs(window, polyorder=2)
    smooth = scipy.ndimage.convolve1d(slip, parabola, mode="nearest")
    noise = _noise(slip)
    # a corner is no noise
    smooth = np.where(np.abs(slip - smooth) > _CORNER_ERRORS * noise, slip, smooth)
    return _Ramp(
        time=np.linspace(0.0, 1.0, len(slip)),
        interval_s=interval_s,
        slip=smooth,
        slip_noise=noise * float(np.sqrt(np.sum(parabola**2))),
        force_n=_block_means(force_n, samples_per_row),
        load_n=_block_means(signals["load_n"], samples_per_row),
        weight=np.ones(len(slip)),
        way=_ways(np.abs(smooth)),
        samples_per_row=samples_per_row,
    )


def _noise(values: FloatArray) -> float:
    """Standard deviation of the noise of a signal, by its second differences."""
    return MAD_TO_SIGMA * median(np.abs(np.diff(values, 2))) / np.sqrt(6)


def _weighted(ramp: _Ramp, longest_lag_s: float, zero_terms: int) -> _Ramp:
    """The ramp with weights: a row counts less where the noise of the slip moves its force.

    The variance of a row is that of the force and that of the slip times the squared slope of the
    force (J. Orear, Am. J. Phys. 50 (1982) 912).
    """
    force_noise_n = _noise(ramp.force_n)
    if force_noise_n == 0:
        return ramp
    knots = _knots(ramp, _KNOT_RATIOS[-1])
    best_lag = _best_lag(ramp, knots, longest_lag_s, zero_terms)
    curve_columns, zero_columns = _design(ramp, knots, zero_terms)
    logged_curve = _as_logged(curve_columns, best_lag.x[0], best_lag.x[1], ramp.interval_s)
    coefficients, _ = _least_squares(np.hstack([logged_curve, zero_columns]), ramp.force_n)
    size = np.abs(ramp.slip)
    slip_step = knots[0] / 10
    rise = _basis(size + slip_step, knots) - _basis(np.maximum(size - slip_step, 0.0), knots)
    slope_n = ramp.load_n * (rise @ coefficients[: curve_columns.shape[1]]) / (2 * slip_step)
    return replace(ramp, weight=1 / np.hypot(1.0, slope_n * ramp.slip_noise / force_noise_n))


def _turns(size: FloatArray) -> list[int]:
    """Rows at which the size of the slip turns back, in the order of time."""
    smallest_return = _TURN_SHARE * size.max()
    turns: list[int] = []
    rises: bool | None = None
    extreme_row = 0
    for row, value in enumerate(size.tolist()):
        change = value - float(size[extreme_row])
        if rises is None:
            if abs(change) > smallest_return:
                rises = change > 0
                extreme_row = row
        elif (change > 0) == rises:
            extreme_row = row
        elif abs(change) > smallest_return:
            turns.append(extreme_row)
            rises = not rises
            extreme_row = row
    return turns


def _ways(size: FloatArray) -> IndexArray:
    """The number of the way, up or down, that each row belongs to.

    A way with too few rows for a curve counts as part of the one before it.
    """
    way = np.zeros(len(size), dtype=np.int64)
    way_number = 0
    turns = _turns(size)
    for start, stop in pairwise([*turns, len(size)]):
        if stop - start >= _FEWEST_ROWS:
            way_number += 1
        way[start:] = way_number
    return way


def _shows_its_lag(ramp: _Ramp) -> bool:
    """Whether rising and falling slip both cover half of the slips."""
    size = np.abs(ramp.slip)
    slips = np.linspace(0.0, size.max(), _WINDOWS)
    # rising or not -> which slips it covers
    is_covered = {True: np.zeros(_WINDOWS, dtype=bool), False: np.zeros(_WINDOWS, dtype=bool)}
    for start, stop in pairwise([0, *_turns(size), len(size) - 1]):
        low, high = sorted((size[start], size[stop]))
        is_covered[bool(size[stop] > size[start])] |= (slips >= low) & (slips <= high)
    return bool(np.mean(is_covered[True] & is_covered[False]) >= _COVERED_SHARE)


def _knots(ramp: _Ramp, ratio: float) -> FloatArray:
    """Knots of the spline: by a ratio, and so far apart that each has some rows."""
    size = np.abs(ramp.slip)
    largest = float(size.max())
    steps = np.abs(np.diff(size))[size[1:] > _FIRST_KNOT]
    least_distance = _ROWS_PER_KNOT * max(median(steps), largest / _MOST_ROWS)
    knots = [max(_FIRST_KNOT, least_distance)]
    while knots[-1] < largest:
        knots.append(max(knots[-1] * ratio, knots[-1] + least_distance))
    knots = knots[:-1]
    # the last one is the largest slip, and not too near to the one before it
    if len(knots) > 1 and largest - knots[-1] < (knots[-1] - knots[-2]) / 2:
        knots.pop()
    return np.array([*knots, largest])


def _basis(size: FloatArray, knots: FloatArray) -> FloatArray:
    """Cubic B-splines in the size of the slip that are 0 at no slip, shape (n, splines)."""
    ends = np.full(_CUBIC + 1, knots[-1])
    padded = np.concatenate([np.zeros(_CUBIC + 1), knots[:-1], ends])
    inside = np.clip(size, 0.0, knots[-1])
    splines = scipy.interpolate.BSpline.design_matrix(inside, padded, _CUBIC).toarray()
    # at no slip only the first one is not 0
    return np.asarray(splines[:, 1:])


def _as_logged(
    columns: FloatArray, filter_s: float, delay_s: float, interval_s: float
) -> FloatArray:
    """Columns of signals as a sensor logs them, shape (rows, columns).

    Signals between rows are straight lines; beyond the first and the last row they do not change.

    Args:
        columns: The signals.
        filter_s: Time constant of a filter of first order.
        delay_s: Delay; where it is negative the signals are early.
        interval_s: Time between rows.
    """
    whole_rows, fraction = divmod(delay_s / interval_s, 1.0)
    rows = np.arange(len(columns)) - int(whole_rows)
    last = len(columns) - 1
    delayed = (1 - fraction) * columns[np.clip(rows, 0, last)]
    delayed += fraction * columns[np.clip(rows - 1, 0, last)]
    if filter_s < _NO_FILTER * interval_s:
        return np.asarray(delayed)
    decay = np.exp(-interval_s / filter_s)
    mean_age = (1 - decay) * filter_s / interval_s
    filtered, _ = scipy.signal.lfilter(
        [1 - mean_age, mean_age - decay], [1.0, -decay], delayed, axis=0, zi=mean_age * delayed[:1]
    )
    return np.asarray(filtered)


def _design(ramp: _Ramp, knots: FloatArray, zero_terms: int) -> tuple[FloatArray, FloatArray]:
    """Columns of the curve without lag, shape (rows, splines), and of the zero, (rows, terms)."""
    pull_n = np.sign(ramp.slip) * ramp.load_n
    curve_columns = pull_n[:, np.newaxis] * _basis(np.abs(ramp.slip), knots)
    zero_columns = np.vander(ramp.time, zero_terms, increasing=True)
    return curve_columns, zero_columns


def _weighted_trials(
    ramp: _Ramp, shortest_lag_s: float, longest_lag_s: float, zero_terms: int, is_seen: bool
) -> tuple[list[_Trial], float, bool]:
    """Lags with their weights, the variance of a row that counts for means, and what is seen."""
    knots_of_spacings = [_knots(ramp, ratio) for ratio in _KNOT_RATIOS]
    best_lags = [_best_lag(ramp, knots, longest_lag_s, zero_terms) for knots in knots_of_spacings]
    variance = min(
        _variance(best.fun, len(knots))
        for best, knots in zip(best_lags, knots_of_spacings, strict=True)
    )
    trials_by_spacing = [
        _trials_around_best(best, variance, knots)
        for best, knots in zip(best_lags, knots_of_spacings, strict=True)
    ]
    is_seen = is_seen and all(
        _is_narrow(trials, shortest_lag_s, longest_lag_s) for trials in trials_by_spacing
    )
    if not is_seen:
        trials_by_spacing = [
            _trials_over_range(shortest_lag_s, longest_lag_s, knots) for knots in knots_of_spacings
        ]
    squares = np.array([np.sum(best.fun**2) for best in best_lags])
    spline_counts = np.array([len(knots) for knots in knots_of_spacings])
    deviances = squares / variance + spline_counts * np.log(len(ramp.slip))
    weights = np.exp(-(deviances - deviances.min()) / 2)
    weights /= weights.sum()
    trials: list[_Trial] = []
    for trials_of_spacing, weight in zip(trials_by_spacing, weights.tolist(), strict=True):
        trials += [replace(trial, weight=trial.weight * weight) for trial in trials_of_spacing]
    return trials, variance, is_seen


def _best_lag(
    ramp: _Ramp, knots: FloatArray, longest_lag_s: float, zero_terms: int
) -> scipy.optimize.OptimizeResult:
    """Filter and delay with which one curve for all ways leaves the least squares."""
    curve_columns, zero_columns = _design(ramp, knots, zero_terms)
    weighted_force_n = ramp.weight * ramp.force_n

    def residual(lag: FloatArray) -> FloatArray:
        logged_curve = _as_logged(curve_columns, lag[0], lag[1], ramp.interval_s)
        columns = ramp.weight[:, np.newaxis] * np.hstack([logged_curve, zero_columns])
        coefficients, _ = _least_squares(columns, weighted_force_n)
        return np.asarray(weighted_force_n - columns @ coefficients)

    early_s = _APART_IN_A_ROW * ramp.interval_s
    bounds = ([0.0, -early_s], [max(longest_lag_s, early_s), max(longest_lag_s, early_s)])
    first_lags = [
        (share * longest_lag_s / 4, (1 - share) * longest_lag_s / 4) for share in _FILTER_SHARES
    ]
    results = [
        scipy.optimize.least_squares(
            residual,
            first_lag,
            bounds=bounds,
            x_scale=ramp.interval_s,
            diff_step=[1e-3, 1e-3],
            max_nfev=_MOST_STEPS,
        )
        for first_lag in first_lags
    ]
    return min(results, key=lambda result: result.cost)


def _variance(residual: FloatArray, spline_count: int) -> float:
    """Variance of a row that counts for means of many rows: autocorrelation included."""
    _, error = mean_with_error(residual)
    uncorrelated_variance = np.sum(residual**2) / max(len(residual) - 2 * spline_count, 1)
    return float(max(error**2 * len(residual), uncorrelated_variance))


def _trials_around_best(
    best: scipy.optimize.OptimizeResult, variance: float, knots: FloatArray
) -> list[_Trial]:
    """Lags that stand for the best one and its covariance: four of equal weight."""
    covariance = variance * np.linalg.pinv(best.jac.T @ best.jac)
    variances, directions = np.linalg.eigh(covariance)
    trials: list[_Trial] = []
    for variance_along, direction in zip(variances, directions.T, strict=True):
        for side in (-1.0, 1.0):
            filter_s, delay_s = best.x + side * np.sqrt(2 * max(variance_along, 0.0)) * direction
            # how a lag is divided matters little: no part of it is negative
            lag_s = filter_s + delay_s
            filter_s = np.clip(filter_s, 0.0, max(lag_s, 0.0))
            trials.append(_Trial(knots, float(filter_s), float(lag_s - filter_s), 1 / 4))
    return trials


def _is_narrow(trials: list[_Trial], shortest_lag_s: float, longest_lag_s: float) -> bool:
    """Whether lags are nearer to each other than those of the range are."""
    lags_s = np.array([trial.lag_s for trial in trials])
    return float(np.std(lags_s)) < (longest_lag_s - shortest_lag_s) / np.sqrt(12)


def _trials_over_range(
    shortest_lag_s: float, longest_lag_s: float, knots: FloatArray
) -> list[_Trial]:
    """Lags in a range, of equal weight: filters, delays, and half of both."""
    lags_s = np.linspace(
        shortest_lag_s, longest_lag_s, _LAGS_TRIED if longest_lag_s > shortest_lag_s else 1
    )
    # the ends of the range count half
    weights = np.ones(len(lags_s))
    weights[[0, -1]] = 0.5
    weights /= weights.sum() * len(_FILTER_SHARES)
    return [
        _Trial(knots, float(share * lag_s), float((1 - share) * lag_s), float(weight))
        for share in _FILTER_SHARES
        for lag_s, weight in zip(lags_s, weights, strict=True)
    ]


def _slips_of_ways(
    ramp: _Ramp, knots: FloatArray, least_slip: float
) -> tuple[FloatArray, IndexArray]:
    """Sizes of slip at which points are given, and the way of each, both of shape (readings,).

    A slip that the ramp reaches from its half within the time of smoothing is not resolved.
    """
    fewest_rows = max(_SMOOTHED_S / ramp.interval_s, _FEWEST_TO_RESOLVE)
    slips: list[float] = []
    ways: list[int] = []
    for way in np.unique(ramp.way):
        size = np.abs(ramp.slip[ramp.way == way])
        for knot in knots[knots >= least_slip]:
            is_near = (size > knot / 2) & (size <= knot)
            if np.count_nonzero(is_near) >= fewest_rows and knot <= size.max():
                slips.append(float(knot))
                ways.append(int(way))
    return np.array(slips), np.array(ways, dtype=np.int64)


def _curve_of_trial(
    ramp: _Ramp,
    trial: _Trial,
    zero_terms: int,
    variance: float,
    slips: FloatArray,
    ways: IndexArray,
) -> tuple[FloatArray, FloatArray, float]:
    """Sizes of mu, their standard errors, both of shape (readings,), and the drift of the zero.

    All ways together give the zero: one direction of slip could not tell it from its curve. Then
    each way has a curve of its own, because other gates compare the ways.

    Args:
        ramp: The ramp.
        trial: The lag, and the knots of the spline.
        zero_terms: As for `ramp_readings`.
        variance: Variance of a row that counts for means.
        slips: Size of the slip of each reading, shape (readings,).
        ways: Number of the way of each reading, shape (readings,).
    """
    curve_columns, zero_columns = _design(ramp, trial.knots, zero_terms)
    weight = ramp.weight[:, np.newaxis]
    weighted_force_n = ramp.weight * ramp.force_n
    weighted_zero = weight * zero_columns
    common_curve = weight * _as_logged(
        curve_columns, trial.filter_s, trial.delay_s, ramp.interval_s
    )
    fitted_together, inverse_together = _least_squares(
        np.hstack([common_curve, weighted_zero]), weighted_force_n
    )
    spline_count = curve_columns.shape[1]
    zero_coefficients = fitted_together[spline_count:]
    zero_covariance = variance * inverse_together[spline_count:, spline_count:]

    way_numbers = np.unique(ramp.way)
    curves_of_ways = [
        np.where((ramp.way == way)[:, np.newaxis], curve_columns, 0.0) for way in way_numbers
    ]
    logged_curves = _as_logged(
        np.hstack(curves_of_ways), trial.filter_s, trial.delay_s, ramp.interval_s
    )
    columns = weight * logged_curves
    coefficients, inverse = _least_squares(
        columns, weighted_force_n - weighted_zero @ zero_coefficients
    )
    # of each way only its own splines count at a reading
    mu_of_coefficients = np.zeros((len(slips), len(coefficients)))
    basis = _basis(slips, trial.knots)
    for index, way in enumerate(way_numbers):
        is_of_way = ways == way
        splines_of_way = slice(index * spline_count, (index + 1) * spline_count)
        mu_of_coefficients[is_of_way, splines_of_way] = basis[is_of_way]
    sensitivity_to_zero = mu_of_coefficients @ inverse @ (columns.T @ weighted_zero)
    variances = variance * np.einsum("ij,jk,ik->i", mu_of_coefficients, inverse, mu_of_coefficients)
    variances += np.einsum("ij,jk,ik->i", sensitivity_to_zero, zero_covariance, sensitivity_to_zero)
    drift_n = float(zero_coefficients[-1]) if zero_terms > 1 else 0.0
    return mu_of_coefficients @ coefficients, np.sqrt(variances), drift_n


def _least_squares(columns: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The coefficients and the inverse of the normal matrix; about 0 where a column has no rows."""
    normal_matrix = columns.T @ columns
    column_sizes = np.sqrt(np.diag(normal_matrix)) + _EMPTY_COLUMN * np.sqrt(
        np.trace(normal_matrix)
    )
    scaled_matrix = normal_matrix / np.outer(column_sizes, column_sizes)
    scaled_matrix[np.diag_indices_from(scaled_matrix)] += _EMPTY_COLUMN
    inverse = np.linalg.inv(scaled_matrix) / np.outer(column_sizes, column_sizes)
    return inverse @ (columns.T @ values), inverse


def _rows_of_readings(
    ramp: _Ramp, slips: FloatArray, ways: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """First row that is nearest to the slip of each reading, and the row after the last one."""
    starts = np.zeros(len(slips), dtype=np.int64)
    stops = np.zeros(len(slips), dtype=np.int64)
    for way in np.unique(ways):
        readings_of_way = np.flatnonzero(ways == way)
        slips_of_way = slips[readings_of_way]
        middles = (slips_of_way[1:] + slips_of_way[:-1]) / 2
        size = np.abs(ramp.slip)
        # rows of rolling belong to no slip
        rows_of_way = np.flatnonzero((ramp.way == way) & (size > slips_of_way[0] / _KNOT_RATIOS[0]))
        nearest = np.searchsorted(middles, size[rows_of_way])
        for index, reading in enumerate(readings_of_way):
            nearest_rows = rows_of_way[nearest == index]
            if len(nearest_rows):
                starts[reading] = nearest_rows[0]
                stops[reading] = nearest_rows[-1] + 1
    return starts, stops
