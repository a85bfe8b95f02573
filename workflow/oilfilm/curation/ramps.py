"""Continuous ramps of slip: the traction coefficient at chosen slips, less the lag of the force.

On a ramp no slip is held. The force is logged behind the slip, because the sensor, its filter and
the film answer late. So the force in a row is not that of the slip in this row. The curve of mu,
the zero of the sensor and the lag are found together, by least squares on all rows:

    F(t) = zero + drift t + L_lag [W(t) m(|S(t)|) sign(S(t))]

F is the traction force, W the load, S the slide-roll ratio, and t the time from 0 at the first row
to 1 at the last. m is the curve of mu: a cubic spline with m(0) = 0. L_lag is a filter of first
order, a delay, or both. If rising and falling slip pass the same slips, the lag is the one with
which both curves agree. If they do not, the run does not show its lag. The lag may then have any
value in a range, and the error of mu includes this.

The log has samples. Where there are many, they are averaged to rows. The result has points.

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
from oilfilm.curation.rig_kind import ForceLag, MeasuredRun, Signals
from oilfilm.curation.statistics import Stretches, mean_with_error, median
from oilfilm.curation.zero import short_phase_refusal
from oilfilm.logs.base import Refusal
from oilfilm.settings.config import PlateauSettings, ZeroReferenceSettings

# --- what a ramp is

# If levels are held for a larger share of the sliding time, the run has steps and is no ramp.
_LARGEST_HELD_SHARE = 1 / 4
# The path of the slip is the sum of the sizes of its changes, up and down. This share of a sum
# counts as most of it.
_SHARE_CALLED_MOST = 0.8
# A ramp makes most of its path in at least this share of the time: a straight ramp in 0.8, a sine
# in 0.59. Steps need less than 0.3.
_LEAST_TIME_SHARE_OF_PATH = 0.4
# Largest path of the slip over the path from turn to turn. Noise of a slow body makes it larger.
_LARGEST_PATH_RATIO = 1.3
# Changes of the slip are taken over this time.
_CHANGE_TIME_S = 0.2
# A ramp has most of the squares of its changes in at least this share of the time: noise in 0.4, a
# sine in 0.5. Steps that are too small to be found as levels have them in less than 0.15.
_LEAST_TIME_SHARE_OF_SQUARES = 0.25
# A single fall to rolling makes at most this share of the changes.
_SHARE_OF_A_FALL = 0.02
# The path is counted from the means of so many windows.
_WINDOW_COUNT = 200
# A ramp by equal factors is straight in asinh(S/0.01).
_SLIP_SCALE = 0.01
# Fewer sliding samples show no ramp.
_FEWEST_SAMPLES = 30
# Fewer points give no curve of mu.
FEWEST_RAMP_POINTS = 5

# --- how a ramp is measured

# So many rows are enough for a curve. Samples are averaged until there are no more.
_MOST_ROWS = 1000
# A branch, up or down, with fewer rows gives no curve.
_FEWEST_ROWS_OF_BRANCH = 30
# The slip is smoothed by parabolas over this time.
_SMOOTHING_TIME_S = 0.8
# The parabolas are over at least so many rows.
_FEWEST_ROWS_SMOOTHED = 5
# A slip is resolved if the ramp has at least so many rows between half of it and itself.
_FEWEST_ROWS_TO_RESOLVE = 7
# The slip turns a corner where it differs from the smooth one by so many standard deviations of its
# noise.
_CORNER_ERRORS = 4.0
# The slip turns back where it returns by this share of the largest slip.
_TURN_SHARE = 0.1
# Ratios of neighbouring knots of the spline. The curve must not depend on them: both are tried.
_KNOT_RATIOS = (1.4, 1.7)
# The first knot is at this slip or above.
_FIRST_KNOT_SLIP = 0.0015
# At least so many rows are between two knots.
_FEWEST_ROWS_PER_KNOT = 4
# For the distance of knots, the slip of a slow ramp counts as if it had reached its largest value
# in so many rows.
_MOST_ROWS_TO_LARGEST_SLIP = 1000
# Cubic.
_SPLINE_DEGREE = 3
# Relative error of mu that the spline, the kind of lag and the smoothing make beside noise. 24
# simulated ramps of two curves that no law has are off by 0.1 to 0.4 %, all their points alike.
_RELATIVE_CURVE_ERROR = 0.003
# A column below this share of the size of all columns counts as empty.
_EMPTY_COLUMN_SIZE = 1e-10
# A filter with a time constant below this share of the time between rows changes nothing.
_SHORTEST_FILTER_ROWS = 1e-3
# If the run does not show its lag, so many lags stand for the range.
_LAGS_TRIED = 9
# Shares of the filter in a lag that are tried. The rest of the lag is delay.
_FILTER_SHARES = (0.0, 0.5, 1.0)
# The search of a lag ends after so many evaluations.
_MOST_EVALUATIONS = 30
# The force may be read before the slip of its row, by at most so many rows.
_LARGEST_LEAD_ROWS = 0.5
# A spike is compared with the median of so many samples.
_MEDIAN_FILTER_SAMPLES = 9
# Rising and falling slip may show the lag if both cover at least this share of the slips.
_LEAST_COVERED_SHARE = 1 / 2
# The share is counted at so many slips.
_COVER_SLIP_COUNT = 200
# Both directions of slip show the zero if the smaller of their largest slips is at least this share
# of the larger one.
_LEAST_SHARE_OF_OTHER_DIRECTION = 1 / 2
# If the lag is beyond this share of its range, it may be longer than the range.
LARGEST_SHARE_OF_LAG_RANGE = 0.95


@dataclass(frozen=True)
class RampPoints:
    """Traction coefficients at slips that a ramp passes.

    Attributes:
        slip: Slide-roll ratio with its sign, shape (points,).
        mu: Traction coefficient with the sign of the slip, less the zero, shape (points,).
        mu_se: Its standard error, which contains that of the method, shape (points,).
        starts: Index of the first sample whose slip is nearest to that of the point, shape
            (points,).
        stops: Index after the last such sample, shape (points,).
        spike_counts: Number of spikes of the force between them, shape (points,).
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
        relative_time: Time from 0 at the first row to 1 at the last.
        interval_s: Time between rows.
        slip: Slide-roll ratio, smoothed.
        slip_noise: Standard deviation of its noise.
        force_n: Traction force.
        load_n: Load.
        row_weight: Factor on the residual of each row: noise of the force over the noise of the
            row, 1 at most.
        branch_of_row: Index of the branch of each row. On one branch the size of the slip rises
            all the time, or it falls all the time.
        samples_per_row: Samples that are averaged to a row.
    """

    relative_time: FloatArray
    interval_s: float
    slip: FloatArray
    slip_noise: float
    force_n: FloatArray
    load_n: FloatArray
    row_weight: FloatArray
    branch_of_row: IndexArray
    samples_per_row: int


@dataclass(frozen=True)
class _Trial:
    """One of several possible lags that are tried: mu is the weighted mean of their curves.

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
    run: MeasuredRun, plateau_settings: PlateauSettings, rolling_slip: float, is_held: BoolArray
) -> bool:
    """Whether the slip of a run changes continuously. False if it is held in levels.

    Args:
        run: The run, divided into levels.
        plateau_settings: `min_duration_s`, the shortest level.
        rolling_slip: Slip below which the rig rolls.
        is_held: Plateaus whose slip is steady, shape (plateaus,).
    """
    slip = run.running_signals["slide_roll_ratio"]
    sliding_indices = np.flatnonzero(np.abs(slip) > rolling_slip)
    if len(sliding_indices) < _FEWEST_SAMPLES:
        return False
    sliding_s = len(sliding_indices) * run.signals.interval_s
    is_level = is_held & (np.abs(run.plateaus["slide_roll_ratio"]) > rolling_slip)
    is_level &= run.plateaus["duration_s"] >= plateau_settings.min_duration_s
    if run.plateaus["duration_s"][is_level].sum() > _LARGEST_HELD_SHARE * sliding_s:
        return False
    sliding_slip = slip[sliding_indices[0] : sliding_indices[-1] + 1]
    slip_scales = (sliding_slip, np.arcsinh(sliding_slip / _SLIP_SCALE))
    if (
        max(_time_share_of_path(scaled_slip) for scaled_slip in slip_scales)
        < _LEAST_TIME_SHARE_OF_PATH
    ):
        return False
    if not _goes_from_turn_to_turn(sliding_slip):
        return False
    samples_per_change = max(round(_CHANGE_TIME_S / run.signals.interval_s), 1)
    return (
        max(_time_share_of_squares(scaled_slip, samples_per_change) for scaled_slip in slip_scales)
        >= _LEAST_TIME_SHARE_OF_SQUARES
    )


def _time_share_of_path(signal: FloatArray) -> float:
    """Smallest share of the time in which a signal makes most of its path."""
    window_means = _block_means(signal, max(len(signal) // _WINDOW_COUNT, 1))
    return _smallest_share(np.abs(np.diff(window_means)))


def _goes_from_turn_to_turn(signal: FloatArray) -> bool:
    """Whether the signal moves straight from one turn to the next.

    Noise would make its path longer.
    """
    window_means = _block_means(signal, max(len(signal) // _WINDOW_COUNT, 1))
    signal_size = np.abs(window_means)
    size_at_turns = signal_size[[0, *_rows_of_turns(signal_size), len(signal_size) - 1]]
    path_length = np.abs(np.diff(signal_size)).sum()
    return bool(path_length <= _LARGEST_PATH_RATIO * np.abs(np.diff(size_at_turns)).sum())


def _time_share_of_squares(signal: FloatArray, samples_per_change: int) -> float:
    """Smallest share of the time that has most of the squared changes of a signal.

    Small steps have them at their edges, a ramp all the time. A single fall to rolling is left out.

    Args:
        signal: The signal, shape (samples,).
        samples_per_change: Samples over which a change is taken.
    """
    sorted_squares = np.sort(np.diff(_block_means(signal, samples_per_change)) ** 2)
    return _smallest_share(sorted_squares[: round((1 - _SHARE_OF_A_FALL) * len(sorted_squares))])


def _smallest_share(changes: FloatArray) -> float:
    """Smallest share of changes that add up to most of their sum."""
    running_sum = np.cumsum(np.sort(changes)[::-1])
    if len(running_sum) == 0 or running_sum[-1] == 0:
        return 0.0
    return float(
        (1 + np.searchsorted(running_sum, _SHARE_CALLED_MOST * running_sum[-1])) / len(running_sum)
    )


@dataclass(frozen=True)
class RampZero:
    """How the zero of the force of a ramp is found.

    Attributes:
        term_count: Number of terms: 0 where the force has no zero left, 1 for a constant zero, 2
            for a zero with a drift.
        shown_by: What shows the zero, in words: phases of rolling, or both directions of slip.
        refusal: Why nothing shows the zero; None if something does.
    """

    term_count: int
    shown_by: tuple[str, ...] = ()
    refusal: Refusal | None = None


def ramp_zero(
    signals: Signals, zero_source_name: str, window_s: float, zero_settings: ZeroReferenceSettings
) -> RampZero:
    """How the zero is found: by rolling at the ends of a ramp, or by both directions of slip.

    Args:
        signals: The samples of the ramp, rolling included.
        zero_source_name: `semantics: zero` of the campaign.
        window_s: Time over which the slip is averaged to find rolling.
        zero_settings: Shortest phase of rolling, and its largest slip.
    """
    if zero_source_name in ("standstill", "already_removed"):
        return RampZero(term_count=0)
    rolling_slices = rolling_ends(signals, window_s, zero_settings)
    needed_phases = ("opening",) if zero_source_name == "opening_phase" else ("opening", "closing")
    for phase_name in needed_phases:
        phase_in_words = f"{phase_name} phase of pure rolling"
        refusal = short_phase_refusal(
            signals, rolling_slices[phase_name], phase_in_words, zero_settings.min_duration_s
        )
        if refusal is not None:
            if _slides_in_both_directions(signals["slide_roll_ratio"]):
                # a drift looks like a part of the curve
                return RampZero(term_count=1, shown_by=("both directions of slip",))
            return RampZero(term_count=0, refusal=refusal)
    return RampZero(term_count=len(needed_phases), shown_by=needed_phases)


def rolling_ends(
    signals: Signals, window_s: float, zero_settings: ZeroReferenceSettings
) -> dict[str, slice]:
    """The samples before and after the sliding part of a ramp, by the name of the phase.

    Args:
        signals: The samples of the ramp, rolling included.
        window_s: Time over which the slip is averaged to find rolling.
        zero_settings: Largest slip of rolling.
    """
    slip = signals["slide_roll_ratio"]
    window_samples = max(round(window_s / signals.interval_s), 1)
    mean_slip = scipy.ndimage.uniform_filter1d(slip, window_samples, mode="nearest")
    sliding_indices = np.flatnonzero(np.abs(mean_slip) > zero_settings.max_slide_roll_ratio)
    if len(sliding_indices) == 0:
        # a slip that alternates faster than the window has no ends of rolling
        return {"opening": slice(0, 0), "closing": slice(0, 0)}
    return {
        "opening": slice(0, int(sliding_indices[0])),
        "closing": slice(int(sliding_indices[-1]) + 1, len(slip)),
    }


def _slides_in_both_directions(slip: FloatArray) -> bool:
    """Whether a run slides far enough in both directions to show the zero.

    mu changes its sign with the slip, and the zero does not.
    """
    common_slip = min(slip.max(initial=0.0), -slip.min(initial=0.0))
    return bool(common_slip >= _LEAST_SHARE_OF_OTHER_DIRECTION * np.abs(slip).max(initial=0.0) > 0)


def ramp_points(
    signals: Signals,
    lag_range_s: Sequence[float],
    zero_term_count: int,
    smallest_slip: float,
    spike_threshold: float,
) -> RampPoints | None:
    """Traction coefficients at points of a ramp. None if too few are resolved and known.

    Args:
        signals: Its samples, rolling included, one after the other.
        lag_range_s: Smallest and largest lag of the force behind the slip.
        zero_term_count: `RampZero.term_count`.
        smallest_slip: Smallest slip at which a point is given.
        spike_threshold: Threshold of a spike of the force, in robust standard deviations.
    """
    force_n, is_spike = replace_spikes(signals["traction_force_n"], spike_threshold)
    ramp = _averaged_ramp(signals, force_n)
    shortest_lag_s, longest_lag_s = lag_range_s
    may_show_lag = longest_lag_s > shortest_lag_s and _may_show_its_lag(ramp)
    ramp = _weighted_ramp(ramp, longest_lag_s, zero_term_count)
    trials, effective_variance_n2, shows_lag = _weighted_trials(
        ramp, shortest_lag_s, longest_lag_s, zero_term_count, may_show_lag
    )
    point_slip_sizes, branch_of_point = _slips_of_points(ramp, trials[0].knots, smallest_slip)
    if len(point_slip_sizes) < FEWEST_RAMP_POINTS:
        return None
    mu_of_trials, mu_se_of_trials, drift_n_of_trials = [], [], []
    for trial in trials:
        trial_mu, trial_mu_se, trial_drift_n = _curve_of_trial(
            ramp, trial, zero_term_count, effective_variance_n2, point_slip_sizes, branch_of_point
        )
        mu_of_trials.append(trial_mu)
        mu_se_of_trials.append(trial_mu_se)
        drift_n_of_trials.append(trial_drift_n)
    weights = np.array([trial.weight for trial in trials])
    mu, mu_se = _mean_of_trials(np.array(mu_of_trials), np.array(mu_se_of_trials), weights)
    lag_s_of_trials = np.array([trial.lag_s for trial in trials])
    lag_s, lag_se_s = _mean_of_trials(lag_s_of_trials, np.zeros(len(lag_s_of_trials)), weights)
    starts, stops = _rows_of_points(ramp, point_slip_sizes, branch_of_point)
    signs = np.array(
        [np.sign(median(ramp.slip[ramp.branch_of_row == branch])) for branch in branch_of_point]
    )
    # where the log ends before the late force of a slip is logged, mu may have any size
    is_known = (stops > starts) & (mu_se < np.abs(mu).max())
    if np.count_nonzero(is_known) < FEWEST_RAMP_POINTS:
        return None
    starts = starts[is_known] * ramp.samples_per_row
    stops = stops[is_known] * ramp.samples_per_row
    stretches = Stretches(starts, stops)
    return RampPoints(
        slip=(signs * point_slip_sizes)[is_known],
        mu=(signs * mu)[is_known],
        mu_se=np.hypot(mu_se, _RELATIVE_CURVE_ERROR * mu)[is_known],
        starts=starts,
        stops=stops,
        spike_counts=stretches.counts(stretches.cut(is_spike.astype(float)) > 0),
        lag=ForceLag(float(lag_s), float(lag_se_s), shows_lag, (shortest_lag_s, longest_lag_s)),
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


def replace_spikes(signal: FloatArray, threshold: float) -> tuple[FloatArray, BoolArray]:
    """A signal with the median of its neighbours in place of spikes, and the mask of spikes.

    Args:
        signal: The force or the load, shape (samples,).
        threshold: Distance from that median beyond which a sample is a spike, in standard
            deviations of the noise.
    """
    median_signal = scipy.ndimage.median_filter(signal, _MEDIAN_FILTER_SAMPLES, mode="nearest")
    noise_sd = _noise_sd(signal)
    # a signal without noise has no spikes
    limit = threshold * noise_sd if noise_sd > 0 else np.inf
    is_spike = np.abs(signal - median_signal) > limit
    return np.where(is_spike, median_signal, signal), is_spike


def _block_means(signal: FloatArray, block_length: int) -> FloatArray:
    """Means of blocks of `block_length` samples; an incomplete block at the end is dropped."""
    block_count = len(signal) // block_length
    return signal[: block_count * block_length].reshape(block_count, block_length).mean(axis=1)


def _averaged_ramp(signals: Signals, force_n: FloatArray) -> _Ramp:
    """The rows of a ramp, averaged over blocks where there are many."""
    samples_per_row = -(-len(signals) // _MOST_ROWS)
    slip = _block_means(signals["slide_roll_ratio"], samples_per_row)
    interval_s = signals.interval_s * samples_per_row
    # at low slip the curve is steep, so that noise of the slip acts like much noise of the force
    window_rows = max(2 * round(_SMOOTHING_TIME_S / interval_s / 2) + 1, _FEWEST_ROWS_SMOOTHED)
    parabola_weights = scipy.signal.savgol_coeffs(window_rows, polyorder=2)
    smooth_slip = scipy.ndimage.convolve1d(slip, parabola_weights, mode="nearest")
    slip_noise = _noise_sd(slip)
    # a corner is no noise
    smooth_slip = np.where(
        np.abs(slip - smooth_slip) > _CORNER_ERRORS * slip_noise, slip, smooth_slip
    )
    return _Ramp(
        relative_time=np.linspace(0.0, 1.0, len(slip)),
        interval_s=interval_s,
        slip=smooth_slip,
        slip_noise=slip_noise * float(np.sqrt(np.sum(parabola_weights**2))),
        force_n=_block_means(force_n, samples_per_row),
        load_n=_block_means(signals["load_n"], samples_per_row),
        row_weight=np.ones(len(slip)),
        branch_of_row=_branch_of_rows(np.abs(smooth_slip)),
        samples_per_row=samples_per_row,
    )


def _noise_sd(signal: FloatArray) -> float:
    """Standard deviation of the noise of a signal, by its second differences."""
    return MAD_TO_SIGMA * median(np.abs(np.diff(signal, 2))) / np.sqrt(6)


def _weighted_ramp(ramp: _Ramp, longest_lag_s: float, zero_term_count: int) -> _Ramp:
    """The ramp with weights: a row counts less where the noise of the slip moves its force.

    The variance of a row is that of the force and that of the slip times the squared slope of the
    force (J. Orear, Am. J. Phys. 50 (1982) 912).
    """
    force_noise_n = _noise_sd(ramp.force_n)
    if force_noise_n == 0:
        return ramp
    knots = _make_knots(ramp, _KNOT_RATIOS[-1])
    # the slope is that of a first fit, in which all rows have the same weight
    lag_fit = _lag_fit(ramp, knots, longest_lag_s, zero_term_count)
    curve_columns, zero_columns = _design_columns(ramp, knots, zero_term_count)
    logged_curve = _columns_as_logged(curve_columns, lag_fit.x[0], lag_fit.x[1], ramp.interval_s)
    coefficients, _ = _least_squares(np.hstack([logged_curve, zero_columns]), ramp.force_n)
    slip_size = np.abs(ramp.slip)
    slip_step = knots[0] / 10
    basis_change = _spline_basis(slip_size + slip_step, knots) - _spline_basis(
        np.maximum(slip_size - slip_step, 0.0), knots
    )
    slope_n = (
        ramp.load_n * (basis_change @ coefficients[: curve_columns.shape[1]]) / (2 * slip_step)
    )
    return replace(ramp, row_weight=1 / np.hypot(1.0, slope_n * ramp.slip_noise / force_noise_n))


def _rows_of_turns(slip_size: FloatArray) -> list[int]:
    """Rows at which the size of the slip turns back, in the order of time."""
    smallest_return = _TURN_SHARE * slip_size.max()
    turns: list[int] = []
    is_rising: bool | None = None
    extreme_row = 0
    for row, value in enumerate(slip_size.tolist()):
        change = value - float(slip_size[extreme_row])
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


def _branch_of_rows(slip_size: FloatArray) -> IndexArray:
    """The number of the branch, up or down, of each row, shape (rows,).

    A branch with too few rows for a curve counts as part of the one before it.

    Args:
        slip_size: Size of the slip, shape (rows,).
    """
    branch_of_row = np.zeros(len(slip_size), dtype=np.int64)
    branch = 0
    turns = _rows_of_turns(slip_size)
    for start, stop in pairwise([*turns, len(slip_size)]):
        if stop - start >= _FEWEST_ROWS_OF_BRANCH:
            branch += 1
        branch_of_row[start:] = branch
    return branch_of_row


def _may_show_its_lag(ramp: _Ramp) -> bool:
    """Whether rising and falling slip both cover so many slips that they may show the lag."""
    slip_size = np.abs(ramp.slip)
    slip_grid = np.linspace(0.0, slip_size.max(), _COVER_SLIP_COUNT)
    # whether the slip rises -> mask of the slips that it covers
    is_covered_by_direction = {
        True: np.zeros(_COVER_SLIP_COUNT, dtype=bool),
        False: np.zeros(_COVER_SLIP_COUNT, dtype=bool),
    }
    for start, stop in pairwise([0, *_rows_of_turns(slip_size), len(slip_size) - 1]):
        low, high = sorted((slip_size[start], slip_size[stop]))
        is_covered_by_direction[bool(slip_size[stop] > slip_size[start])] |= (slip_grid >= low) & (
            slip_grid <= high
        )
    return bool(
        np.mean(is_covered_by_direction[True] & is_covered_by_direction[False])
        >= _LEAST_COVERED_SHARE
    )


def _make_knots(ramp: _Ramp, knot_ratio: float) -> FloatArray:
    """Knots of the spline: by a ratio, and so far apart that each has some rows."""
    slip_size = np.abs(ramp.slip)
    largest_slip = float(slip_size.max())
    slip_steps = np.abs(np.diff(slip_size))[slip_size[1:] > _FIRST_KNOT_SLIP]
    least_distance = _FEWEST_ROWS_PER_KNOT * max(
        median(slip_steps), largest_slip / _MOST_ROWS_TO_LARGEST_SLIP
    )
    knots = [max(_FIRST_KNOT_SLIP, least_distance)]
    while knots[-1] < largest_slip:
        knots.append(max(knots[-1] * knot_ratio, knots[-1] + least_distance))
    knots = knots[:-1]
    # the last one is the largest slip, and not too near to the one before it
    if len(knots) > 1 and largest_slip - knots[-1] < (knots[-1] - knots[-2]) / 2:
        knots.pop()
    return np.array([*knots, largest_slip])


def _spline_basis(slip_size: FloatArray, knots: FloatArray) -> FloatArray:
    """Cubic B-splines in the size of the slip that are 0 at zero slip, shape (n, knots + 2)."""
    end_knots = np.full(_SPLINE_DEGREE + 1, knots[-1])
    padded_knots = np.concatenate([np.zeros(_SPLINE_DEGREE + 1), knots[:-1], end_knots])
    clipped_size = np.clip(slip_size, 0.0, knots[-1])
    splines = scipy.interpolate.BSpline.design_matrix(
        clipped_size, padded_knots, _SPLINE_DEGREE
    ).toarray()
    # at zero slip only the first spline is not 0: it is left out
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
    # mean of the decay over the time between rows: exact for signals that are straight there
    mean_decay = (1 - decay) * filter_s / interval_s
    filtered, _ = scipy.signal.lfilter(
        [1 - mean_decay, mean_decay - decay],
        [1.0, -decay],
        delayed,
        axis=0,
        zi=mean_decay * delayed[:1],
    )
    return np.asarray(filtered)


def _design_columns(
    ramp: _Ramp, knots: FloatArray, zero_term_count: int
) -> tuple[FloatArray, FloatArray]:
    """Columns of the curve without lag, shape (rows, splines), and of the zero, (rows, terms)."""
    signed_load_n = np.sign(ramp.slip) * ramp.load_n
    curve_columns = signed_load_n[:, np.newaxis] * _spline_basis(np.abs(ramp.slip), knots)
    zero_columns = np.vander(ramp.relative_time, zero_term_count, increasing=True)
    return curve_columns, zero_columns


def _weighted_trials(
    ramp: _Ramp,
    shortest_lag_s: float,
    longest_lag_s: float,
    zero_term_count: int,
    may_show_lag: bool,
) -> tuple[list[_Trial], float, bool]:
    """Trials of lags with their weights.

    Args:
        ramp: The ramp.
        shortest_lag_s: Smallest lag of the force behind the slip.
        longest_lag_s: Largest lag.
        zero_term_count: As for `ramp_points`.
        may_show_lag: Whether rising and falling slip may show the lag.

    Returns:
        The trials; the variance as `_variance_for_means` gives it; whether the ramp shows its lag,
        that is, whether the rows narrow it down.
    """
    knots_by_spacing = [_make_knots(ramp, knot_ratio) for knot_ratio in _KNOT_RATIOS]
    lag_fits = [_lag_fit(ramp, knots, longest_lag_s, zero_term_count) for knots in knots_by_spacing]
    effective_variance_n2 = min(
        _variance_for_means(lag_fit.fun, _parameter_count(knots, zero_term_count))
        for lag_fit, knots in zip(lag_fits, knots_by_spacing, strict=True)
    )
    trials_by_spacing = [
        _trials_around_best(lag_fit, effective_variance_n2, knots)
        for lag_fit, knots in zip(lag_fits, knots_by_spacing, strict=True)
    ]
    shows_lag = may_show_lag and all(
        _is_narrow(trials, shortest_lag_s, longest_lag_s) for trials in trials_by_spacing
    )
    if not shows_lag:
        trials_by_spacing = [
            _trials_over_range(shortest_lag_s, longest_lag_s, knots) for knots in knots_by_spacing
        ]
    sum_of_squares = np.array([np.sum(lag_fit.fun**2) for lag_fit in lag_fits])
    parameter_counts = np.array(
        [_parameter_count(knots, zero_term_count) for knots in knots_by_spacing]
    )
    # Schwarz's criterion (BIC) of each spacing of knots
    bic = sum_of_squares / effective_variance_n2 + parameter_counts * np.log(len(ramp.slip))
    weights = np.exp(-(bic - bic.min()) / 2)
    weights /= weights.sum()
    trials: list[_Trial] = []
    for trials_of_spacing, weight in zip(trials_by_spacing, weights.tolist(), strict=True):
        trials += [replace(trial, weight=trial.weight * weight) for trial in trials_of_spacing]
    return trials, effective_variance_n2, shows_lag


def _lag_fit(
    ramp: _Ramp, knots: FloatArray, longest_lag_s: float, zero_term_count: int
) -> "scipy.optimize.OptimizeResult":
    """The fit of filter and delay, in `x`, with one curve for all branches.

    The search starts at a quarter of the longest lag: as delay, as filter, and as half of both. The
    best of the three ends counts.
    """
    curve_columns, zero_columns = _design_columns(ramp, knots, zero_term_count)
    weighted_force_n = ramp.row_weight * ramp.force_n

    def residual(filter_and_delay_s: FloatArray) -> FloatArray:
        logged_curve = _columns_as_logged(
            curve_columns, filter_and_delay_s[0], filter_and_delay_s[1], ramp.interval_s
        )
        weighted_columns = ramp.row_weight[:, np.newaxis] * np.hstack([logged_curve, zero_columns])
        coefficients, _ = _least_squares(weighted_columns, weighted_force_n)
        return np.asarray(weighted_force_n - weighted_columns @ coefficients)

    largest_lead_s = _LARGEST_LEAD_ROWS * ramp.interval_s
    bounds = (
        [0.0, -largest_lead_s],
        [max(longest_lag_s, largest_lead_s), max(longest_lag_s, largest_lead_s)],
    )
    start_points = [
        (share * longest_lag_s / 4, (1 - share) * longest_lag_s / 4) for share in _FILTER_SHARES
    ]
    results = [
        scipy.optimize.least_squares(
            residual,
            start_point,
            bounds=bounds,
            x_scale=ramp.interval_s,
            diff_step=[1e-3, 1e-3],
            max_nfev=_MOST_EVALUATIONS,
        )
        for start_point in start_points
    ]
    return min(results, key=lambda result: result.cost)


def _parameter_count(knots: FloatArray, zero_term_count: int) -> int:
    """Number of parameters that `_lag_fit` fits: those of the curve, of the zero and of the lag."""
    spline_count = len(knots) + _SPLINE_DEGREE - 1  # one of `_spline_basis` is left out
    return spline_count + zero_term_count + 2


def _variance_for_means(residual: FloatArray, parameter_count: int) -> float:
    """Effective variance of a row: that of a mean of n rows is 1/n of it.

    It includes the autocorrelation of the rows. Without any it is the sum of squares over the
    degrees of freedom.

    Args:
        residual: Weighted residual of each row, shape (rows,).
        parameter_count: Number of parameters of the fit.
    """
    _, mean_se = mean_with_error(residual)
    uncorrelated_variance = np.sum(residual**2) / max(len(residual) - parameter_count, 1)
    return float(max(mean_se**2 * len(residual), uncorrelated_variance))


def _trials_around_best(
    lag_fit: "scipy.optimize.OptimizeResult", effective_variance_n2: float, knots: FloatArray
) -> list[_Trial]:
    """Four lags of equal weight around the best one: they have its filter, delay and covariance.

    Two of them are on each principal axis of the covariance of filter and delay, sqrt(2) standard
    deviations on either side of the best lag.
    """
    covariance = effective_variance_n2 * np.linalg.pinv(lag_fit.jac.T @ lag_fit.jac)
    eigenvalues, eigenvectors = np.linalg.eigh(covariance)
    trials: list[_Trial] = []
    for eigenvalue, eigenvector in zip(eigenvalues, eigenvectors.T, strict=True):
        for side in (-1.0, 1.0):
            filter_s, delay_s = lag_fit.x + side * np.sqrt(2 * max(eigenvalue, 0.0)) * eigenvector
            # how a lag is divided between filter and delay matters little. The filter must not be
            # negative, nor longer than the lag
            lag_s = filter_s + delay_s
            filter_s = np.clip(filter_s, 0.0, max(lag_s, 0.0))
            trials.append(_Trial(knots, float(filter_s), float(lag_s - filter_s), 1 / 4))
    return trials


def _is_narrow(trials: list[_Trial], shortest_lag_s: float, longest_lag_s: float) -> bool:
    """Whether lags scatter less than lags that are spread evenly over the range.

    The standard deviation of these is the length of the range over sqrt(12).
    """
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


def _slips_of_points(
    ramp: _Ramp, knots: FloatArray, smallest_slip: float
) -> tuple[FloatArray, IndexArray]:
    """Sizes of slip at which points are given, and the branch of each; both of shape (points,).

    A slip is resolved only if the ramp takes longer than the time of smoothing from half of the
    slip to the slip.
    """
    fewest_rows = max(_SMOOTHING_TIME_S / ramp.interval_s, _FEWEST_ROWS_TO_RESOLVE)
    point_slip_sizes: list[float] = []
    branches: list[int] = []
    for branch in np.unique(ramp.branch_of_row):
        slip_size = np.abs(ramp.slip[ramp.branch_of_row == branch])
        for knot in knots[knots >= smallest_slip]:
            is_approaching = (slip_size > knot / 2) & (slip_size <= knot)
            if np.count_nonzero(is_approaching) >= fewest_rows and knot <= slip_size.max():
                point_slip_sizes.append(float(knot))
                branches.append(int(branch))
    return np.array(point_slip_sizes), np.array(branches, dtype=np.int64)


def _curve_of_trial(
    ramp: _Ramp,
    trial: _Trial,
    zero_term_count: int,
    effective_variance_n2: float,
    point_slip_sizes: FloatArray,
    branch_of_point: IndexArray,
) -> tuple[FloatArray, FloatArray, float]:
    """Sizes of mu, their standard errors, both of shape (points,), and the drift of the zero.

    The zero is fitted to all branches together, with one curve: a single branch cannot tell the
    zero from its curve. Then each branch gets a curve of its own, because gates compare branches.

    Args:
        ramp: The ramp.
        trial: The lag, and the knots of the spline.
        zero_term_count: As for `ramp_points`.
        effective_variance_n2: As `_variance_for_means` gives it.
        point_slip_sizes: Size of the slip of each point, shape (points,).
        branch_of_point: Index of the branch of each point, shape (points,).
    """
    curve_columns, zero_columns = _design_columns(ramp, trial.knots, zero_term_count)
    weight = ramp.row_weight[:, np.newaxis]
    weighted_force_n = ramp.row_weight * ramp.force_n
    weighted_zero = weight * zero_columns
    common_curve = weight * _columns_as_logged(
        curve_columns, trial.filter_s, trial.delay_s, ramp.interval_s
    )
    common_coefficients, common_inverse = _least_squares(
        np.hstack([common_curve, weighted_zero]), weighted_force_n
    )
    spline_count = curve_columns.shape[1]
    zero_coefficients = common_coefficients[spline_count:]
    zero_covariance = effective_variance_n2 * common_inverse[spline_count:, spline_count:]

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
    # at a point only the splines of its own branch count
    basis_of_points = np.zeros((len(point_slip_sizes), len(coefficients)))
    basis = _spline_basis(point_slip_sizes, trial.knots)
    for branch_index, branch in enumerate(branches):
        is_of_branch = branch_of_point == branch
        splines_of_branch = slice(branch_index * spline_count, (branch_index + 1) * spline_count)
        basis_of_points[is_of_branch, splines_of_branch] = basis[is_of_branch]
    sensitivity_to_zero = basis_of_points @ inverse @ (weighted_columns.T @ weighted_zero)
    mu_variances = effective_variance_n2 * np.einsum(
        "ij,jk,ik->i", basis_of_points, inverse, basis_of_points
    )
    mu_variances += np.einsum(
        "ij,jk,ik->i", sensitivity_to_zero, zero_covariance, sensitivity_to_zero
    )
    drift_n = float(zero_coefficients[-1]) if zero_term_count > 1 else 0.0
    return basis_of_points @ coefficients, np.sqrt(mu_variances), drift_n


def _least_squares(columns: FloatArray, row_values: FloatArray) -> tuple[FloatArray, FloatArray]:
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
    return inverse @ (columns.T @ row_values), inverse


def _rows_of_points(
    ramp: _Ramp, point_slip_sizes: FloatArray, branch_of_point: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Start and stop of the rows of each point, both of shape (points,).

    The rows of a point are those of its branch whose slip is nearest to that of the point.
    """
    starts = np.zeros(len(point_slip_sizes), dtype=np.int64)
    stops = np.zeros(len(point_slip_sizes), dtype=np.int64)
    for branch in np.unique(branch_of_point):
        point_indices_of_branch = np.flatnonzero(branch_of_point == branch)
        slips_of_branch = point_slip_sizes[point_indices_of_branch]
        limits_between_slips = (slips_of_branch[1:] + slips_of_branch[:-1]) / 2
        slip_size = np.abs(ramp.slip)
        # rows of rolling belong to no slip
        rows_of_branch = np.flatnonzero(
            (ramp.branch_of_row == branch) & (slip_size > slips_of_branch[0] / _KNOT_RATIOS[0])
        )
        nearest_indices = np.searchsorted(limits_between_slips, slip_size[rows_of_branch])
        for index_in_branch, point_index in enumerate(point_indices_of_branch):
            nearest_rows = rows_of_branch[nearest_indices == index_in_branch]
            if len(nearest_rows):
                starts[point_index] = nearest_rows[0]
                stops[point_index] = nearest_rows[-1] + 1
    return starts, stops
