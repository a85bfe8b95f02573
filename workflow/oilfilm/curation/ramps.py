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
from oilfilm.curation.zero import short_phase_refusal
from oilfilm.logs.base import Refusal
from oilfilm.settings.config import PlateauSettings, ZeroReferenceSettings

# --- what a ramp is

# Held levels in a larger share of the sliding time show a log of steps.
_LARGEST_HELD_SHARE = 1 / 4
# The path of the slip is the sum of its changes, up and down. A ramp needs at least this share of
# the time for most of its path: a straight ramp 0.8, a sine 0.59. Steps need less than 0.3.
_MOST_OF_THE_PATH = 0.8
_LEAST_SHARE_OF_TIME = 0.4
# Path of the slip over the path from turn to turn. The noise of a slow body makes more.
_LARGEST_PATH_RATIO = 1.3
# Share of the time that has most of the squared changes, each over the time below: 0.4 for noise,
# 0.5 for a sine. Steps that are smaller than those which are looked for have less than 0.15.
_CHANGE_TIME_S = 0.2
_LEAST_SHARE_OF_SQUARES = 0.25
# Share of the changes that a single fall to rolling makes at most.
_SHARE_OF_A_FALL = 0.02
# Number of windows in which the path is counted.
_WINDOW_COUNT = 200
# A ramp by equal factors is straight in asinh(S/0.01).
_SLIP_SCALE = 0.01
# Fewer sliding rows show no ramp, and fewer rows of a branch, up or down, give no curve.
_FEWEST_ROWS = 30
# Fewer slips that are resolved give no curve of mu.
FEWEST_READINGS = 5

# --- how a ramp is measured

# More rows are averaged to so many, which is enough for a curve.
_MOST_ROWS = 1000
# The slip is smoothed by parabolas over this time, and so many rows at least.
_SMOOTHING_TIME_S = 0.8
_FEWEST_ROWS_SMOOTHED = 5
# Fewer rows between half a slip and the slip do not resolve it.
_FEWEST_ROWS_TO_RESOLVE = 7
# The slip turns a corner where it is so many standard deviations of noise off the smooth one.
_CORNER_ERRORS = 4.0
# The slip turns back where it returns by so much of the largest slip.
_TURN_SHARE = 0.1
# Ratios of neighbouring knots of the spline. The curve must not depend on them: both are tried.
_KNOT_RATIOS = (1.4, 1.7)
_FIRST_KNOT_SLIP = 0.0015
# Rows between two knots.
_ROWS_PER_KNOT = 4
_SPLINE_DEGREE = 3
# What spline, kind of lag and smoothing leave of mu, relative, beside noise: 24 simulated ramps of
# two curves that no law has are off by 0.1 to 0.4 %, all their points alike.
_RELATIVE_CURVE_ERROR = 0.003
# Relative size below which a column counts as empty.
_EMPTY_COLUMN_SIZE = 1e-10
# A filter with a time constant below this share of the time of a row changes nothing.
_SHORTEST_FILTER_ROWS = 1e-3
# Where the lag is not seen: number of lags that stand for its range, and the shares of the filter
# in a lag; the rest is delay.
_LAGS_TRIED = 9
_FILTER_SHARES = (0.0, 0.5, 1.0)
# Evaluations in the search of a lag.
_MOST_EVALUATIONS = 30
# The force may be read before the slip of its row, by so many rows.
_EARLIEST_LAG_ROWS = 0.5
# A spike is compared with the median of so many readings.
_READINGS_OF_MEDIAN = 9
# Rising and falling slip show the lag where both cover so much of the slips.
_LEAST_COVERED_SHARE = 1 / 2
# A lag that is found beyond this share of its range may be longer.
LARGEST_SHARE_OF_RANGE = 0.95


@dataclass(frozen=True)
class RampReadings:
    """Traction coefficients at slips that a ramp passes.

    Attributes:
        slip: Slide-roll ratio with its sign, shape (readings,).
        mu: Traction coefficient with the sign of the slip, less the zero, shape (readings,).
        mu_se: Its standard error, which contains that of the method, shape (readings,).
        starts: Index of the first sample whose slip is nearest to that of the reading, shape
            (readings,).
        stops: Index after the last such sample, shape (readings,).
        spike_counts: Number of spikes of the force between them, shape (readings,).
        lag: The lag of the force.
        drift_n: Change of the zero from the first row to the last; 0 where none was asked for.
    """

    slip: FloatArray
    mu: FloatArray
    mu_se: FloatArray
    starts: IndexArray
    stops: IndexArray
    spike_counts: IndexArray
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
        weight: Factor on the residual of each row: one over its standard deviation.
        branch_of_row: Number of the branch of each row: on a branch the size of the slip rises, or
            it falls.
        samples_per_row: Samples that are averaged to a row.
    """

    time: FloatArray
    interval_s: float
    slip: FloatArray
    slip_noise: float
    force_n: FloatArray
    load_n: FloatArray
    weight: FloatArray
    branch_of_row: IndexArray
    samples_per_row: int


@dataclass(frozen=True)
class _Trial:
    """One of several possible lags, with which the curve is read; the answer is their mean.

    Attributes:
        knots: Slips between which the spline is one polynomial, shape (knots,).
        filter_s: Time constant of the filter.
        delay_s: The delay.
        weight: Its weight in the mean; the weights of all trials have the sum 1.
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
    slip = run.working_signals["slide_roll_ratio"]
    sliding_rows = np.flatnonzero(np.abs(slip) > rolling_slip)
    if len(sliding_rows) < _FEWEST_ROWS:
        return False
    sliding_s = len(sliding_rows) * run.signals.interval_s
    is_level = is_held & (np.abs(run.plateaus["slide_roll_ratio"]) > rolling_slip)
    is_level &= run.plateaus["duration_s"] >= plateau_settings.min_duration_s
    if run.plateaus["duration_s"][is_level].sum() > _LARGEST_HELD_SHARE * sliding_s:
        return False
    sliding_slip = slip[sliding_rows[0] : sliding_rows[-1] + 1]
    slip_scales = (sliding_slip, np.arcsinh(sliding_slip / _SLIP_SCALE))
    if max(_share_of_time(scaled_slip) for scaled_slip in slip_scales) < _LEAST_SHARE_OF_TIME:
        return False
    if not _goes_from_turn_to_turn(sliding_slip):
        return False
    rows_per_change = max(round(_CHANGE_TIME_S / run.signals.interval_s), 1)
    return (
        max(_share_of_squares(scaled_slip, rows_per_change) for scaled_slip in slip_scales)
        >= _LEAST_SHARE_OF_SQUARES
    )


def _share_of_time(signal: FloatArray) -> float:
    """Smallest share of the time in which a signal covers most of its path."""
    window_means = _block_means(signal, max(len(signal) // _WINDOW_COUNT, 1))
    return _smallest_share(np.abs(np.diff(window_means)))


def _goes_from_turn_to_turn(signal: FloatArray) -> bool:
    """Whether the path of a signal is hardly longer than from turn to turn, as without noise."""
    window_means = _block_means(signal, max(len(signal) // _WINDOW_COUNT, 1))
    signal_size = np.abs(window_means)
    size_at_turns = signal_size[[0, *_rows_of_turns(signal_size), len(signal_size) - 1]]
    path_length = np.abs(np.diff(signal_size)).sum()
    return bool(path_length <= _LARGEST_PATH_RATIO * np.abs(np.diff(size_at_turns)).sum())


def _share_of_squares(signal: FloatArray, rows_per_change: int) -> float:
    """Smallest share of the time that has most of the squared changes of a signal.

    Small steps have them at their edges, a ramp all the time. A single fall to rolling is left out.

    Args:
        signal: The signal, shape (rows,).
        rows_per_change: Rows over which a change is taken.
    """
    sorted_squares = np.sort(np.diff(_block_means(signal, rows_per_change)) ** 2)
    return _smallest_share(sorted_squares[: round((1 - _SHARE_OF_A_FALL) * len(sorted_squares))])


def _smallest_share(changes: FloatArray) -> float:
    """Smallest share of changes that add up to most of their sum."""
    running_sum = np.cumsum(np.sort(changes)[::-1])
    if len(running_sum) == 0 or running_sum[-1] == 0:
        return 0.0
    return float(
        (1 + np.searchsorted(running_sum, _MOST_OF_THE_PATH * running_sum[-1])) / len(running_sum)
    )


@dataclass(frozen=True)
class RampZero:
    """How the zero of the force of a ramp is found.

    Attributes:
        term_count: Number of terms: 0 where the force has no zero left, 1 for a constant zero, 2
            for a zero with a drift.
        phases: What shows the zero, in words.
        refusal: Why nothing shows it; None where something does.
    """

    term_count: int
    phases: tuple[str, ...] = ()
    refusal: Refusal | None = None


def rolling_zero(
    signals: Signals, zero_source_name: str, window_s: float, settings: ZeroReferenceSettings
) -> RampZero:
    """How the zero is found: by rolling at the ends of a ramp, or by both directions of slip.

    Args:
        signals: The rows of the ramp, rolling included.
        zero_source_name: `semantics: zero` of the campaign.
        window_s: Time over which the slip is averaged to find rolling.
        settings: Shortest phase of rolling, and its largest slip.
    """
    if zero_source_name in ("standstill", "already_removed"):
        return RampZero(term_count=0)
    phases = rolling_ends(signals, window_s, settings)
    needed_phases = ("opening",) if zero_source_name == "opening_phase" else ("opening", "closing")
    for phase_name in needed_phases:
        phase_in_words = f"{phase_name} phase of pure rolling"
        refusal = short_phase_refusal(
            signals, phases[phase_name], phase_in_words, settings.min_duration_s
        )
        if refusal is not None:
            if _slides_in_both_directions(signals["slide_roll_ratio"]):
                # a drift looks like a part of the curve
                return RampZero(term_count=1, phases=("both directions of slip",))
            return RampZero(term_count=0, refusal=refusal)
    return RampZero(term_count=len(needed_phases), phases=needed_phases)


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
    window_rows = max(round(window_s / signals.interval_s), 1)
    mean_slip = scipy.ndimage.uniform_filter1d(slip, window_rows, mode="nearest")
    sliding_rows = np.flatnonzero(np.abs(mean_slip) > settings.max_slide_roll_ratio)
    if len(sliding_rows) == 0:
        # a slip that alternates faster than the window has no ends of rolling
        return {"opening": slice(0, 0), "closing": slice(0, 0)}
    return {
        "opening": slice(0, int(sliding_rows[0])),
        "closing": slice(int(sliding_rows[-1]) + 1, len(slip)),
    }


def _slides_in_both_directions(slip: FloatArray) -> bool:
    """Whether a run slides in both directions, so that what they have in common is the zero."""
    common_slip = min(slip.max(initial=0.0), -slip.min(initial=0.0))
    return bool(common_slip >= _LEAST_COVERED_SHARE * np.abs(slip).max(initial=0.0) > 0)


def ramp_readings(
    signals: Signals,
    lag_range_s: Sequence[float],
    zero_term_count: int,
    least_slip: float,
    spike_threshold: float,
) -> RampReadings | None:
    """Traction coefficients on a ramp; None where it resolves too few slips.

    Args:
        signals: Its rows, rolling included, one after the other.
        lag_range_s: Smallest and largest lag of the force behind the slip.
        zero_term_count: `RampZero.term_count`.
        least_slip: Smallest slip at which a point is given.
        spike_threshold: Threshold of a spike of the force, in robust standard deviations.
    """
    force_n, is_spike = _force_without_spikes(signals["traction_force_n"], spike_threshold)
    ramp = _averaged_ramp(signals, force_n)
    shortest_lag_s, longest_lag_s = lag_range_s
    is_seen = longest_lag_s > shortest_lag_s and _shows_its_lag(ramp)
    ramp = _weighted_ramp(ramp, longest_lag_s, zero_term_count)
    trials, row_variance, is_seen = _weighted_trials(
        ramp, shortest_lag_s, longest_lag_s, zero_term_count, is_seen
    )
    slip_sizes, branch_of_reading = _slips_of_readings(ramp, trials[0].knots, least_slip)
    if len(slip_sizes) < FEWEST_READINGS:
        return None
    mu_of_trials, mu_se_of_trials, drift_n_of_trials = [], [], []
    for trial in trials:
        trial_mu, trial_mu_se, trial_drift_n = _curve_of_trial(
            ramp, trial, zero_term_count, row_variance, slip_sizes, branch_of_reading
        )
        mu_of_trials.append(trial_mu)
        mu_se_of_trials.append(trial_mu_se)
        drift_n_of_trials.append(trial_drift_n)
    weights = np.array([trial.weight for trial in trials])
    mu, mu_se = _mean_of_trials(np.array(mu_of_trials), np.array(mu_se_of_trials), weights)
    lag_s_of_trials = np.array([trial.lag_s for trial in trials])
    lag_s, lag_se_s = _mean_of_trials(lag_s_of_trials, np.zeros(len(lag_s_of_trials)), weights)
    starts, stops = _rows_of_readings(ramp, slip_sizes, branch_of_reading)
    signs = np.array(
        [np.sign(median(ramp.slip[ramp.branch_of_row == branch])) for branch in branch_of_reading]
    )
    has_rows = stops > starts
    starts = starts[has_rows] * ramp.samples_per_row
    stops = stops[has_rows] * ramp.samples_per_row
    stretches = Stretches(starts, stops)
    return RampReadings(
        slip=(signs * slip_sizes)[has_rows],
        mu=(signs * mu)[has_rows],
        mu_se=np.hypot(mu_se, _RELATIVE_CURVE_ERROR * mu)[has_rows],
        starts=starts,
        stops=stops,
        spike_counts=stretches.counts(stretches.cut(is_spike.astype(float)) > 0),
        lag=ForceLag(float(lag_s), float(lag_se_s), is_seen, (shortest_lag_s, longest_lag_s)),
        drift_n=float(weights @ np.array(drift_n_of_trials)),
    )


def _mean_of_trials(
    values: FloatArray, standard_errors: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean over trials, and its standard error: their own errors and how far they are apart.

    Args:
        values: Values of each trial, shape (trials, ...).
        standard_errors: Their standard errors, of the same shape.
        weights: Weights of sum 1, shape (trials,).
    """
    mean = weights @ values
    return mean, np.sqrt(weights @ standard_errors**2 + weights @ (values - mean) ** 2)


def _force_without_spikes(force_n: FloatArray, threshold: float) -> tuple[FloatArray, BoolArray]:
    """The force with the median of its neighbours in place of spikes, and the mask of spikes."""
    median_force_n = scipy.ndimage.median_filter(force_n, _READINGS_OF_MEDIAN, mode="nearest")
    # a force without noise has no spikes
    limit_n = threshold * _noise_sd(force_n) or np.inf
    is_spike = np.abs(force_n - median_force_n) > limit_n
    return np.where(is_spike, median_force_n, force_n), is_spike


def _block_means(signal: FloatArray, block_length: int) -> FloatArray:
    """Means of blocks of so many samples; what is left at the end is dropped."""
    block_count = len(signal) // block_length
    return signal[: block_count * block_length].reshape(block_count, block_length).mean(axis=1)


def _averaged_ramp(signals: Signals, force_n: FloatArray) -> _Ramp:
    """The rows of a ramp, averaged over blocks where there are many."""
    samples_per_row = -(-len(signals) // _MOST_ROWS)
    slip = _block_means(signals["slide_roll_ratio"], samples_per_row)
    interval_s = signals.interval_s * samples_per_row
    # at low slip the noise of the slip is a large force
    window_rows = max(2 * round(_SMOOTHING_TIME_S / interval_s / 2) + 1, _FEWEST_ROWS_SMOOTHED)
    parabola_weights = scipy.signal.savgol_coeffs(window_rows, polyorder=2)
    smooth_slip = scipy.ndimage.convolve1d(slip, parabola_weights, mode="nearest")
    slip_noise = _noise_sd(slip)
    # a corner is no noise
    smooth_slip = np.where(
        np.abs(slip - smooth_slip) > _CORNER_ERRORS * slip_noise, slip, smooth_slip
    )
    return _Ramp(
        time=np.linspace(0.0, 1.0, len(slip)),
        interval_s=interval_s,
        slip=smooth_slip,
        slip_noise=slip_noise * float(np.sqrt(np.sum(parabola_weights**2))),
        force_n=_block_means(force_n, samples_per_row),
        load_n=_block_means(signals["load_n"], samples_per_row),
        weight=np.ones(len(slip)),
        branch_of_row=_branch_of_rows(np.abs(smooth_slip)),
        samples_per_row=samples_per_row,
    )


def _noise_sd(values: FloatArray) -> float:
    """Standard deviation of the noise of a signal, by its second differences."""
    return MAD_TO_SIGMA * median(np.abs(np.diff(values, 2))) / np.sqrt(6)


def _weighted_ramp(ramp: _Ramp, longest_lag_s: float, zero_term_count: int) -> _Ramp:
    """The ramp with weights: a row counts less where the noise of the slip moves its force.

    The variance of a row is that of the force and that of the slip times the squared slope of the
    force (J. Orear, Am. J. Phys. 50 (1982) 912).
    """
    force_noise_n = _noise_sd(ramp.force_n)
    if force_noise_n == 0:
        return ramp
    knots = _knots(ramp, _KNOT_RATIOS[-1])
    best_lag = _best_lag(ramp, knots, longest_lag_s, zero_term_count)
    curve_columns, zero_columns = _design_columns(ramp, knots, zero_term_count)
    logged_curve = _columns_as_logged(curve_columns, best_lag.x[0], best_lag.x[1], ramp.interval_s)
    coefficients, _ = _least_squares(np.hstack([logged_curve, zero_columns]), ramp.force_n)
    size = np.abs(ramp.slip)
    slip_step = knots[0] / 10
    basis_change = _spline_basis(size + slip_step, knots) - _spline_basis(
        np.maximum(size - slip_step, 0.0), knots
    )
    slope_n = (
        ramp.load_n * (basis_change @ coefficients[: curve_columns.shape[1]]) / (2 * slip_step)
    )
    return replace(ramp, weight=1 / np.hypot(1.0, slope_n * ramp.slip_noise / force_noise_n))


def _rows_of_turns(size: FloatArray) -> list[int]:
    """Rows at which the size of the slip turns back, in the order of time."""
    smallest_return = _TURN_SHARE * size.max()
    turns: list[int] = []
    is_rising: bool | None = None
    extreme_row = 0
    for row, value in enumerate(size.tolist()):
        change = value - float(size[extreme_row])
        if is_rising is None:
            if abs(change) > smallest_return:
                is_rising = change > 0
                extreme_row = row
        elif (change > 0) == is_rising:
            extreme_row = row
        elif abs(change) > smallest_return:
            turns.append(extreme_row)
            is_rising = not is_rising
            extreme_row = row
    return turns


def _branch_of_rows(size: FloatArray) -> IndexArray:
    """The number of the branch, up or down, of each row, shape (rows,).

    A branch with too few rows for a curve counts as part of the one before it.

    Args:
        size: Size of the slip, shape (rows,).
    """
    branch_of_row = np.zeros(len(size), dtype=np.int64)
    branch = 0
    turns = _rows_of_turns(size)
    for start, stop in pairwise([*turns, len(size)]):
        if stop - start >= _FEWEST_ROWS:
            branch += 1
        branch_of_row[start:] = branch
    return branch_of_row


def _shows_its_lag(ramp: _Ramp) -> bool:
    """Whether rising and falling slip both cover half of the slips."""
    size = np.abs(ramp.slip)
    slip_grid = np.linspace(0.0, size.max(), _WINDOW_COUNT)
    # rising or not -> which slips it covers
    is_covered_by_direction = {
        True: np.zeros(_WINDOW_COUNT, dtype=bool),
        False: np.zeros(_WINDOW_COUNT, dtype=bool),
    }
    for start, stop in pairwise([0, *_rows_of_turns(size), len(size) - 1]):
        low, high = sorted((size[start], size[stop]))
        is_covered_by_direction[bool(size[stop] > size[start])] |= (slip_grid >= low) & (
            slip_grid <= high
        )
    return bool(
        np.mean(is_covered_by_direction[True] & is_covered_by_direction[False])
        >= _LEAST_COVERED_SHARE
    )


def _knots(ramp: _Ramp, knot_ratio: float) -> FloatArray:
    """Knots of the spline: by a ratio, and so far apart that each has some rows."""
    size = np.abs(ramp.slip)
    largest_slip = float(size.max())
    slip_steps = np.abs(np.diff(size))[size[1:] > _FIRST_KNOT_SLIP]
    least_distance = _ROWS_PER_KNOT * max(median(slip_steps), largest_slip / _MOST_ROWS)
    knots = [max(_FIRST_KNOT_SLIP, least_distance)]
    while knots[-1] < largest_slip:
        knots.append(max(knots[-1] * knot_ratio, knots[-1] + least_distance))
    knots = knots[:-1]
    # the last one is the largest slip, and not too near to the one before it
    if len(knots) > 1 and largest_slip - knots[-1] < (knots[-1] - knots[-2]) / 2:
        knots.pop()
    return np.array([*knots, largest_slip])


def _spline_basis(size: FloatArray, knots: FloatArray) -> FloatArray:
    """Cubic B-splines in the size of the slip that are 0 at no slip, shape (n, splines)."""
    end_knots = np.full(_SPLINE_DEGREE + 1, knots[-1])
    padded_knots = np.concatenate([np.zeros(_SPLINE_DEGREE + 1), knots[:-1], end_knots])
    clipped_size = np.clip(size, 0.0, knots[-1])
    splines = scipy.interpolate.BSpline.design_matrix(
        clipped_size, padded_knots, _SPLINE_DEGREE
    ).toarray()
    # at no slip only the first one is not 0
    return np.asarray(splines[:, 1:])


def _columns_as_logged(
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
    delay_rows, delay_fraction = divmod(delay_s / interval_s, 1.0)
    source_rows = np.arange(len(columns)) - int(delay_rows)
    last_row = len(columns) - 1
    delayed = (1 - delay_fraction) * columns[np.clip(source_rows, 0, last_row)]
    delayed += delay_fraction * columns[np.clip(source_rows - 1, 0, last_row)]
    if filter_s < _SHORTEST_FILTER_ROWS * interval_s:
        return np.asarray(delayed)
    decay = np.exp(-interval_s / filter_s)
    mean_age = (1 - decay) * filter_s / interval_s
    filtered, _ = scipy.signal.lfilter(
        [1 - mean_age, mean_age - decay], [1.0, -decay], delayed, axis=0, zi=mean_age * delayed[:1]
    )
    return np.asarray(filtered)


def _design_columns(
    ramp: _Ramp, knots: FloatArray, zero_term_count: int
) -> tuple[FloatArray, FloatArray]:
    """Columns of the curve without lag, shape (rows, splines), and of the zero, (rows, terms)."""
    signed_load_n = np.sign(ramp.slip) * ramp.load_n
    curve_columns = signed_load_n[:, np.newaxis] * _spline_basis(np.abs(ramp.slip), knots)
    zero_columns = np.vander(ramp.time, zero_term_count, increasing=True)
    return curve_columns, zero_columns


def _weighted_trials(
    ramp: _Ramp, shortest_lag_s: float, longest_lag_s: float, zero_term_count: int, is_seen: bool
) -> tuple[list[_Trial], float, bool]:
    """Lags with their weights, the variance for means, and whether the ramp shows its lag.

    Args:
        ramp: The ramp.
        shortest_lag_s: Smallest lag of the force behind the slip.
        longest_lag_s: Largest lag.
        zero_term_count: As for `ramp_readings`.
        is_seen: Whether rising and falling slip may show the lag.

    Returns:
        The trials, the variance as by `_variance_for_means`, and whether the best lag is certain.
    """
    knots_by_spacing = [_knots(ramp, knot_ratio) for knot_ratio in _KNOT_RATIOS]
    best_lags = [
        _best_lag(ramp, knots, longest_lag_s, zero_term_count) for knots in knots_by_spacing
    ]
    row_variance = min(
        _variance_for_means(best_lag.fun, len(knots))
        for best_lag, knots in zip(best_lags, knots_by_spacing, strict=True)
    )
    trials_by_spacing = [
        _trials_around_best(best_lag, row_variance, knots)
        for best_lag, knots in zip(best_lags, knots_by_spacing, strict=True)
    ]
    is_seen = is_seen and all(
        _is_narrow(trials, shortest_lag_s, longest_lag_s) for trials in trials_by_spacing
    )
    if not is_seen:
        trials_by_spacing = [
            _trials_over_range(shortest_lag_s, longest_lag_s, knots) for knots in knots_by_spacing
        ]
    sum_of_squares = np.array([np.sum(best_lag.fun**2) for best_lag in best_lags])
    spline_counts = np.array([len(knots) for knots in knots_by_spacing])
    deviances = sum_of_squares / row_variance + spline_counts * np.log(len(ramp.slip))
    weights = np.exp(-(deviances - deviances.min()) / 2)
    weights /= weights.sum()
    trials: list[_Trial] = []
    for trials_of_spacing, weight in zip(trials_by_spacing, weights.tolist(), strict=True):
        trials += [replace(trial, weight=trial.weight * weight) for trial in trials_of_spacing]
    return trials, row_variance, is_seen


def _best_lag(
    ramp: _Ramp, knots: FloatArray, longest_lag_s: float, zero_term_count: int
) -> scipy.optimize.OptimizeResult:
    """Filter and delay, in `x`, with which one curve for all branches leaves the least squares."""
    curve_columns, zero_columns = _design_columns(ramp, knots, zero_term_count)
    weighted_force_n = ramp.weight * ramp.force_n

    def residual(filter_and_delay_s: FloatArray) -> FloatArray:
        logged_curve = _columns_as_logged(
            curve_columns, filter_and_delay_s[0], filter_and_delay_s[1], ramp.interval_s
        )
        weighted_columns = ramp.weight[:, np.newaxis] * np.hstack([logged_curve, zero_columns])
        coefficients, _ = _least_squares(weighted_columns, weighted_force_n)
        return np.asarray(weighted_force_n - weighted_columns @ coefficients)

    early_s = _EARLIEST_LAG_ROWS * ramp.interval_s
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
            max_nfev=_MOST_EVALUATIONS,
        )
        for first_lag in first_lags
    ]
    return min(results, key=lambda result: result.cost)


def _variance_for_means(residual: FloatArray, spline_count: int) -> float:
    """Variance of a row that gives the right error of a mean of many rows.

    It includes the autocorrelation of the rows.
    """
    _, mean_se = mean_with_error(residual)
    uncorrelated_variance = np.sum(residual**2) / max(len(residual) - 2 * spline_count, 1)
    return float(max(mean_se**2 * len(residual), uncorrelated_variance))


def _trials_around_best(
    best_lag: scipy.optimize.OptimizeResult, row_variance: float, knots: FloatArray
) -> list[_Trial]:
    """Four lags of equal weight, which have the best lag as mean and its covariance."""
    covariance = row_variance * np.linalg.pinv(best_lag.jac.T @ best_lag.jac)
    lag_variances, directions = np.linalg.eigh(covariance)
    trials: list[_Trial] = []
    for lag_variance, direction in zip(lag_variances, directions.T, strict=True):
        for side in (-1.0, 1.0):
            filter_s, delay_s = best_lag.x + side * np.sqrt(2 * max(lag_variance, 0.0)) * direction
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


def _slips_of_readings(
    ramp: _Ramp, knots: FloatArray, least_slip: float
) -> tuple[FloatArray, IndexArray]:
    """Sizes of slip at which points are given, and the branch of each; both of shape (readings,).

    A slip is not resolved where the ramp comes from half of it within the time of smoothing.
    """
    fewest_rows = max(_SMOOTHING_TIME_S / ramp.interval_s, _FEWEST_ROWS_TO_RESOLVE)
    slip_sizes: list[float] = []
    branches: list[int] = []
    for branch in np.unique(ramp.branch_of_row):
        size = np.abs(ramp.slip[ramp.branch_of_row == branch])
        for knot in knots[knots >= least_slip]:
            is_near = (size > knot / 2) & (size <= knot)
            if np.count_nonzero(is_near) >= fewest_rows and knot <= size.max():
                slip_sizes.append(float(knot))
                branches.append(int(branch))
    return np.array(slip_sizes), np.array(branches, dtype=np.int64)


def _curve_of_trial(
    ramp: _Ramp,
    trial: _Trial,
    zero_term_count: int,
    row_variance: float,
    slip_sizes: FloatArray,
    branch_of_reading: IndexArray,
) -> tuple[FloatArray, FloatArray, float]:
    """Sizes of mu, their standard errors, both of shape (readings,), and the drift of the zero.

    All branches together give the zero: one direction of slip could not tell it from its curve.
    Then each branch has a curve of its own, because other gates compare the branches.

    Args:
        ramp: The ramp.
        trial: The lag, and the knots of the spline.
        zero_term_count: As for `ramp_readings`.
        row_variance: Variance of a row that counts for means.
        slip_sizes: Size of the slip of each reading, shape (readings,).
        branch_of_reading: Number of the branch of each reading, shape (readings,).
    """
    curve_columns, zero_columns = _design_columns(ramp, trial.knots, zero_term_count)
    weight = ramp.weight[:, np.newaxis]
    weighted_force_n = ramp.weight * ramp.force_n
    weighted_zero = weight * zero_columns
    common_curve = weight * _columns_as_logged(
        curve_columns, trial.filter_s, trial.delay_s, ramp.interval_s
    )
    common_coefficients, common_inverse = _least_squares(
        np.hstack([common_curve, weighted_zero]), weighted_force_n
    )
    spline_count = curve_columns.shape[1]
    zero_coefficients = common_coefficients[spline_count:]
    zero_covariance = row_variance * common_inverse[spline_count:, spline_count:]

    branches = np.unique(ramp.branch_of_row)
    curves_of_branches = [
        np.where((ramp.branch_of_row == branch)[:, np.newaxis], curve_columns, 0.0)
        for branch in branches
    ]
    logged_curves = _columns_as_logged(
        np.hstack(curves_of_branches), trial.filter_s, trial.delay_s, ramp.interval_s
    )
    weighted_columns = weight * logged_curves
    coefficients, inverse = _least_squares(
        weighted_columns, weighted_force_n - weighted_zero @ zero_coefficients
    )
    # at a reading only the splines of its own branch count
    mu_of_coefficients = np.zeros((len(slip_sizes), len(coefficients)))
    basis = _spline_basis(slip_sizes, trial.knots)
    for branch_index, branch in enumerate(branches):
        is_of_branch = branch_of_reading == branch
        splines_of_branch = slice(branch_index * spline_count, (branch_index + 1) * spline_count)
        mu_of_coefficients[is_of_branch, splines_of_branch] = basis[is_of_branch]
    sensitivity_to_zero = mu_of_coefficients @ inverse @ (weighted_columns.T @ weighted_zero)
    mu_variances = row_variance * np.einsum(
        "ij,jk,ik->i", mu_of_coefficients, inverse, mu_of_coefficients
    )
    mu_variances += np.einsum(
        "ij,jk,ik->i", sensitivity_to_zero, zero_covariance, sensitivity_to_zero
    )
    drift_n = float(zero_coefficients[-1]) if zero_term_count > 1 else 0.0
    return mu_of_coefficients @ coefficients, np.sqrt(mu_variances), drift_n


def _least_squares(columns: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The coefficients of least squares, and the inverse of the normal matrix.

    The coefficient of a column that is zero in all rows is about 0.
    """
    normal_matrix = columns.T @ columns
    column_sizes = np.sqrt(np.diag(normal_matrix)) + _EMPTY_COLUMN_SIZE * np.sqrt(
        np.trace(normal_matrix)
    )
    scaled_matrix = normal_matrix / np.outer(column_sizes, column_sizes)
    scaled_matrix[np.diag_indices_from(scaled_matrix)] += _EMPTY_COLUMN_SIZE
    inverse = np.linalg.inv(scaled_matrix) / np.outer(column_sizes, column_sizes)
    return inverse @ (columns.T @ values), inverse


def _rows_of_readings(
    ramp: _Ramp, slip_sizes: FloatArray, branch_of_reading: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Start and stop of the rows of each reading, both of shape (readings,).

    The rows of a reading are those of its branch whose slip is nearest to that of the reading.
    """
    starts = np.zeros(len(slip_sizes), dtype=np.int64)
    stops = np.zeros(len(slip_sizes), dtype=np.int64)
    for branch in np.unique(branch_of_reading):
        readings_of_branch = np.flatnonzero(branch_of_reading == branch)
        slips_of_branch = slip_sizes[readings_of_branch]
        middle_slips = (slips_of_branch[1:] + slips_of_branch[:-1]) / 2
        size = np.abs(ramp.slip)
        # rows of rolling belong to no slip
        rows_of_branch = np.flatnonzero(
            (ramp.branch_of_row == branch) & (size > slips_of_branch[0] / _KNOT_RATIOS[0])
        )
        nearest_index = np.searchsorted(middle_slips, size[rows_of_branch])
        for index, reading in enumerate(readings_of_branch):
            nearest_rows = rows_of_branch[nearest_index == index]
            if len(nearest_rows):
                starts[reading] = nearest_rows[0]
                stops[reading] = nearest_rows[-1] + 1
    return starts, stops
