"""Means over plateaus with standard errors that allow for autocorrelated samples.

Plateaus differ in length. Their samples are cut out of a signal into one array, one plateau after
the other. A mask of the same shape marks the samples that are used. So the memory needed grows with
the number of samples, whatever the lengths of the plateaus are.

Decides: standard errors of autocorrelated samples.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray, IndexArray

# What noise and held values are: definitions behind the gates, whose limits are in the
# configuration. Noise whose standard deviation is two steps of the resolution, or more, has six or
# more different values in ten readings (median, simulated).
_READINGS_COMPARED = 10
_FEWEST_DISTINCT_VALUES = 6
# So many windows of readings are sorted at once, to limit the memory.
_WINDOWS_AT_ONCE = 10_000
# Share of readings at which a signal turns back: two of three for noise, one of two where it is
# filtered, none for a ramp.
_SMALLEST_SHARE_OF_TURNS = 1 / 4
# Readings that differ by less, relative to the largest, differ by the rounding of a conversion.
_CONVERSION_ROUNDING = 1e-9

# A sensor holds its values where each lasts so many rows, almost all equally long, and where there
# are enough values to judge.
_SHORTEST_HOLD_ROWS = 3
_SMALLEST_SHARE_OF_EQUAL_HOLDS = 0.9
_FEWEST_HOLDS = 10

# The median absolute deviation of few readings is often far too small: of 3 readings of noise one
# is beyond 8 standard deviations in 13 % of the cases. These factors on the threshold, by the
# number of readings from 0 on, make it about 0.5 %, as of 10 readings (simulated).
_THRESHOLD_FACTORS_OF_FEW = np.array([1, 1, 1, 26, 8, 3.2, 1.9, 1.7, 1.3, 1.3])

# Noise is seldom correlated over more samples than this; a drift or a hum is.
_LAGS_SUMMED_DIRECTLY = 8
# A longer stretch is transformed (FFT) in blocks of so many samples, to limit the memory.
_MOST_SAMPLES_TRANSFORMED = 1 << 19


@dataclass(frozen=True)
class Stretches:
    """Stretches of a log, each of one sample at least.

    Attributes:
        starts: Index of the first sample of each stretch, shape (stretches,).
        stops: Index after its last sample, shape (stretches,).
    """

    starts: IndexArray
    stops: IndexArray

    @cached_property
    def lengths(self) -> IndexArray:
        """Number of samples of each stretch, shape (stretches,)."""
        return self.stops - self.starts

    @cached_property
    def cut_starts(self) -> IndexArray:
        """Index of the first sample of each stretch in what `cut` gives, shape (stretches,)."""
        return np.cumsum(self.lengths) - self.lengths

    def cut(self, signal: FloatArray) -> FloatArray:
        """The samples of all stretches, one stretch after the other, shape (samples,)."""
        if len(self.starts) == 0:
            return np.empty(0)
        # slice by slice, which is faster than one array of indices
        bounds = zip(self.starts.tolist(), self.stops.tolist(), strict=True)
        return np.concatenate([signal[start:stop] for start, stop in bounds])

    def all_samples(self) -> BoolArray:
        """The mask in which all samples of all stretches are used, shape (samples,)."""
        return np.ones(self.lengths.sum(), dtype=bool)

    def sums(self, values: FloatArray) -> FloatArray:
        """Sum of each stretch of values that `cut` gives, shape (stretches,)."""
        # not BLAS: the last digit must not depend on the processor or its threads
        return np.add.reduceat(values, self.cut_starts) if len(self.cut_starts) else np.empty(0)

    def counts(self, is_used: BoolArray) -> IndexArray:
        """Number of used samples of each stretch, shape (stretches,)."""
        if len(self.cut_starts) == 0:
            return np.empty(0, dtype=np.int64)
        return np.add.reduceat(is_used, self.cut_starts, dtype=np.int64)

    def per_sample(self, values: FloatArray | IndexArray) -> FloatArray:
        """Values of stretches, each repeated for the samples of its stretch; shape (samples,)."""
        return np.repeat(values, self.lengths)

    def is_in_first_part(self, is_used: BoolArray, share: float) -> BoolArray:
        """The mask of the first `share` of the used samples of each stretch, shape (samples,)."""
        used_so_far = np.cumsum(is_used)
        counts = self.counts(is_used)
        used_before_stretch = np.cumsum(counts) - counts
        return is_used & (used_so_far <= self.per_sample(used_before_stretch + counts * share))

    def means(self, values: FloatArray, is_used: BoolArray) -> FloatArray:
        """Mean of each stretch, shape (stretches,); NaN where none of its samples is used.

        Args:
            values: Samples as `cut` gives them.
            is_used: The mask of the samples that are used, shape (samples,).
        """
        total = self.sums(np.where(is_used, values, 0.0))
        counts = self.counts(is_used)
        return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)

    def standard_errors(
        self, values: FloatArray, is_used: BoolArray, mean: FloatArray
    ) -> FloatArray:
        """Standard error of each mean, autocorrelation included; NaN with fewer than two samples.

            se^2 = s^2 / n (1 + 2 sum_k rho_k)

        with rho_k the autocorrelation at lag k, summed up to its first value that is not positive.

        Args:
            values: As for `means`.
            is_used: As for `means`.
            mean: Result of `means`.

        Reference: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992)
        473, section 3.3 (the initial positive sequence, here over single lags).
        """
        counts = self.counts(is_used)
        residual = values - self.per_sample(mean)
        residual[~is_used] = 0.0
        sum_of_squares = self.sums(residual**2)
        autocovariance_sum = _autocovariance_sums(residual, self.lengths)
        with np.errstate(divide="ignore", invalid="ignore"):
            variance = (sum_of_squares + 2 * autocovariance_sum) / (counts - 1)
            return np.where(counts > 1, np.sqrt(variance / counts), np.nan)

    def spikes(self, values: FloatArray, threshold: float) -> BoolArray:
        """Mask of samples whose distance from the median is above `threshold` standard deviations.

        The standard deviation is estimated from the median absolute deviation of the stretch. Where
        that is zero, the signal hardly changes and nothing is marked. The threshold of fewer than
        ten samples is higher.
        """
        deviation = np.abs(values - self.per_sample(self.medians(values)))
        robust_sd = MAD_TO_SIGMA * self.medians(deviation)
        last_of_few = len(_THRESHOLD_FACTORS_OF_FEW) - 1
        factor = np.where(
            self.lengths > last_of_few,
            1.0,
            _THRESHOLD_FACTORS_OF_FEW[np.minimum(self.lengths, last_of_few)],
        )
        limit = np.where(robust_sd > 0, factor * threshold * robust_sd, np.inf)
        return deviation > self.per_sample(limit)

    def medians(self, values: FloatArray) -> FloatArray:
        """Median of each stretch, shape (stretches,); NaN where it has a NaN."""
        sorted_values = values.copy()
        for start, length in zip(self.cut_starts.tolist(), self.lengths.tolist(), strict=True):
            sorted_values[start : start + length].sort()
        last = self.lengths - 1
        lower = sorted_values[self.cut_starts + last // 2]
        upper = sorted_values[self.cut_starts + (last + 1) // 2]
        # NaN is sorted to the end
        return np.where(
            np.isnan(sorted_values[self.cut_starts + last]), np.nan, (lower + upper) / 2
        )


def mean_with_error(values: FloatArray) -> tuple[float, float]:
    """Mean of samples, shape (n,), and its standard error, autocorrelation included."""
    stretch = Stretches(np.array([0]), np.array([len(values)]))
    is_used = stretch.all_samples()
    mean = stretch.means(values, is_used)
    return float(mean[0]), float(stretch.standard_errors(values, is_used, mean)[0])


def _autocovariance_sums(residual: FloatArray, lengths: IndexArray) -> FloatArray:
    """Sum of the autocovariances of each stretch, up to the first that is not positive.

    Here an autocovariance is the sum of the products of samples a lag apart, from a lag of 1 on; it
    is not divided by their number. Most sums end within a few lags and are computed directly. The
    others are computed by a Fourier transform, one stretch at a time.

    Args:
        residual: Samples less the mean of their stretch, one stretch after the other.
        lengths: Number of samples of each stretch.
    """
    total = np.zeros(len(lengths))
    # indices of the stretches whose sum has not ended
    pending_indices = np.arange(len(lengths))
    for lag in range(1, _LAGS_SUMMED_DIRECTLY + 1):
        is_longer = lengths > lag
        residual = residual[np.repeat(is_longer, lengths)]
        pending_indices = pending_indices[is_longer]
        lengths = lengths[is_longer]
        if len(pending_indices) == 0:
            return total
        autocovariances = _autocovariances_at_lag(residual, lengths, lag)
        is_positive = autocovariances > 0
        residual = residual[np.repeat(is_positive, lengths)]
        pending_indices = pending_indices[is_positive]
        lengths = lengths[is_positive]
        total[pending_indices] += autocovariances[is_positive]
    stops = np.cumsum(lengths)
    for stretch_index, start, stop in zip(pending_indices, stops - lengths, stops, strict=True):
        total[stretch_index] = _autocovariance_sum_by_fourier(residual[start:stop])
    return total


def _autocovariances_at_lag(residual: FloatArray, lengths: IndexArray, lag: int) -> FloatArray:
    """Autocovariance at one lag of each stretch, all of which are longer than the lag."""
    products = np.zeros(len(residual))
    np.multiply(residual[:-lag], residual[lag:], out=products[:-lag])
    stops = np.cumsum(lengths)
    # the last samples of a stretch have their partner in the next one
    for samples_from_end in range(1, lag + 1):
        products[stops - samples_from_end] = 0.0
    return np.add.reduceat(products, stops - lengths)


def _autocovariance_sum_by_fourier(residual: FloatArray) -> float:
    """The sum of `_autocovariance_sums` for one stretch, by Fourier transforms."""
    total = 0.0
    for autocovariances in _autocovariance_blocks(residual):
        is_not_positive = autocovariances <= 0
        if is_not_positive.any():
            return total + float(autocovariances[: np.argmax(is_not_positive)].sum())
        total += float(autocovariances.sum())
    return total


def _autocovariance_blocks(residual: FloatArray) -> Iterator[FloatArray]:
    """Autocovariances of one stretch from a lag of 1 on, a block of lags at a time.

    A long stretch is transformed in blocks: one transform of all its samples takes ten times their
    memory.
    """
    length = len(residual)
    block_length = min(length, _MOST_SAMPLES_TRANSFORMED)
    padded_length = scipy.fft.next_fast_len(2 * block_length, real=True)
    for first_lag in range(0, length, block_length):
        cross_spectrum = np.zeros(padded_length // 2 + 1, dtype=complex)
        for start in range(0, length - first_lag, block_length):
            earlier = residual[start : start + block_length]
            later = residual[start + first_lag :][: 2 * block_length]
            earlier_spectrum = scipy.fft.rfft(earlier, padded_length)
            is_one_block = first_lag == 0 and block_length == length
            later_spectrum = (
                earlier_spectrum if is_one_block else scipy.fft.rfft(later, padded_length)
            )
            cross_spectrum += earlier_spectrum.conj() * later_spectrum
        autocovariances = scipy.fft.irfft(cross_spectrum, padded_length)[
            : min(block_length, length - first_lag)
        ]
        yield autocovariances[1:] if first_lag == 0 else autocovariances


def longest_hold(values: FloatArray) -> tuple[int, int]:
    """First row of the longest stretch of one value, and the row after its last.

    Examples:
        >>> longest_hold(np.array([3.0, 1.0, 1.0, 1.0, 2.0]))
        (1, 4)
    """
    changes = np.flatnonzero(values[1:] != values[:-1]) + 1
    edges = np.concatenate([[0], changes, [len(values)]])
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1])


def without_repeats(values: FloatArray) -> FloatArray:
    """The values that differ from the one before them, without the first value."""
    return values[np.flatnonzero(np.diff(values)) + 1]


def rows_per_reading(values: FloatArray) -> int:
    """Number of rows in which a logger repeats each value of a slower sensor; else 1.

    Examples:
        >>> rows_per_reading(np.repeat(np.arange(20.0), 6))
        6
        >>> rows_per_reading(np.arange(20.0))
        1
    """
    hold_lengths = np.diff(np.flatnonzero(np.diff(values)))
    if len(hold_lengths) < _FEWEST_HOLDS:
        return 1
    rows_held = round(median(hold_lengths))
    share_of_equal = np.mean(np.abs(hold_lengths - rows_held) <= 1)
    if rows_held < _SHORTEST_HOLD_ROWS or share_of_equal < _SMALLEST_SHARE_OF_EQUAL_HOLDS:
        return 1
    return rows_held


def is_noise(readings: FloatArray) -> bool:
    """Whether readings scatter over several steps of the resolution.

    One or two steps, a ramp or few readings are no noise.

    Args:
        readings: The readings of a signal as `without_repeats` gives them.

    Examples:
        >>> is_noise(np.tile([70.0, 70.1], 50))
        False
        >>> is_noise(np.random.default_rng(1).standard_normal(100))
        True
    """
    if len(readings) < _READINGS_COMPARED:
        return False
    windows = np.lib.stride_tricks.sliding_window_view(readings, _READINGS_COMPARED)
    rounding = _CONVERSION_ROUNDING * np.abs(readings).max()
    distinct_counts = np.empty(len(windows), dtype=np.int64)
    # in blocks: ten sorted readings for each one of a long log are too large
    for start in range(0, len(windows), _WINDOWS_AT_ONCE):
        block = slice(start, start + _WINDOWS_AT_ONCE)
        sorted_values = np.sort(windows[block], axis=1)
        distinct_counts[block] = (np.diff(sorted_values, axis=1) > rounding).sum(axis=1) + 1
    change = np.diff(readings)
    share_of_turns = np.mean(change[1:] * change[:-1] < 0)
    return bool(
        median(distinct_counts) >= _FEWEST_DISTINCT_VALUES
        and share_of_turns >= _SMALLEST_SHARE_OF_TURNS
    )


def median(values: FloatArray | IndexArray) -> float:
    """Median of numbers, shape (n,); NaN where one of them is NaN, or where there is none.

    NumPy's median selects two order statistics. For the 5000 rows of a run this takes seven times
    as long as sorting, which uses the vector instructions of the processor.

    Examples:
        >>> median(np.array([3.0, 1.0, 2.0, 10.0]))
        2.5
    """
    sorted_values = np.sort(values)
    if len(sorted_values) == 0 or np.isnan(sorted_values[-1]):
        return np.nan
    return float(
        (sorted_values[(len(sorted_values) - 1) // 2] + sorted_values[len(sorted_values) // 2]) / 2
    )
