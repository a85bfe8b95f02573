"""Means over plateaus with standard errors that allow for autocorrelated samples.

Plateaus differ in length. Their samples are cut out of the signals into arrays of shape
(..., plateaus, longest plateau). Masks of shape (plateaus, longest plateau) mark the samples that
count.

Decides: standard errors of autocorrelated samples.
"""

import numpy as np

from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray, IndexArray

# What noise and held values are: definitions behind the gates, whose limits are in the
# configuration.
# Noise of two digits of the resolution, or more, gives at least six different values in ten
# readings.
_READINGS_COMPARED = 10
_FEWEST_DIFFERENT = 6
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

# Noise is seldom correlated over more samples than this; a drift or a hum is.
_LAGS_SUMMED_DIRECTLY = 8


def cut(signals: FloatArray, starts: IndexArray, stops: IndexArray) -> tuple[FloatArray, BoolArray]:
    """Stretches of signals from each start to before each stop, and the mask of their samples.

    Args:
        signals: One or several signals, shape (..., samples).
        starts: First index of each stretch.
        stops: The index after its last one; it must be larger.

    Returns:
        Stretches, shape (..., stretches, longest stretch), zero where a stretch is shorter; the
        mask, shape (stretches, longest stretch).
    """
    lengths = stops - starts
    longest = int(lengths.max(initial=0))
    stretches = np.zeros((*signals.shape[:-1], len(starts), longest))
    # slice by slice, which is faster than one array of indices
    for stretch, (start, stop) in enumerate(zip(starts.tolist(), stops.tolist(), strict=True)):
        stretches[..., stretch, : stop - start] = signals[..., start:stop]
    return stretches, np.arange(longest) < lengths[:, np.newaxis]


def first_part(inside: BoolArray, share: float) -> BoolArray:
    """The mask of the first `share` of the samples of each stretch."""
    number_of_sample = np.cumsum(inside, axis=-1)
    counts = number_of_sample[:, -1:]
    return inside & (number_of_sample <= counts * share)


def means(values: FloatArray, inside: BoolArray) -> FloatArray:
    """Mean of each stretch, shape (..., stretches); NaN where none of its samples counts.

    Args:
        values: Stretches of signals as `cut` gives them.
        inside: The mask of the samples that count.
    """
    # not BLAS: the last digit must not depend on the processor or its threads
    total = np.einsum("...ij,ij->...i", values, inside.astype(float))
    counts = inside.sum(axis=-1)
    return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)


def standard_errors(
    values: FloatArray, inside: BoolArray, mean: FloatArray | None = None
) -> FloatArray:
    """Standard error of each mean, autocorrelation included; NaN with fewer than two samples.

        se^2 = s^2 / n (1 + 2 sum_k rho_k)

    with rho_k the autocorrelation at lag k, summed up to its first value that is not positive.

    Args:
        values: As for `means`.
        inside: As for `means`.
        mean: Result of `means`, where it has been computed already.

    Reference: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992) 473,
    section 3.3 (the initial positive sequence, here over single lags).
    """
    counts = inside.sum(axis=-1)
    if mean is None:
        mean = means(values, inside)
    residual = np.where(inside, values - mean[..., np.newaxis], 0.0)
    squares = np.einsum("...ij,...ij->...i", residual, residual)
    lagged = _sum_of_lags(residual.reshape(mean.size, inside.shape[1])).reshape(mean.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = (squares + 2 * lagged) / (counts - 1)
        return np.where(counts > 1, np.sqrt(variance / counts), np.nan)


def _sum_of_lags(residual: FloatArray) -> FloatArray:
    """Sum of the autocovariances of each row over all lags up to the first that is not positive.

    Most sums end within a few lags and are computed directly. The others are computed by a Fourier
    transform.
    """
    total = np.zeros(len(residual))
    rows = np.arange(len(residual))
    for lag in range(1, min(_LAGS_SUMMED_DIRECTLY + 1, residual.shape[1])):
        covariance = np.einsum("ij,ij->i", residual[:, lag:], residual[:, :-lag])
        positive = covariance > 0
        rows = rows[positive]
        residual = residual[positive]
        if len(rows) == 0:
            break
        total[rows] += covariance[positive]
    if len(rows) == 0:
        return total
    length = residual.shape[1]
    spectrum = np.fft.rfft(residual, 2 * length, axis=1)
    covariance = np.fft.irfft(np.abs(spectrum) ** 2, 2 * length, axis=1)[:, 1:length]
    total[rows] = (covariance * np.cumprod(covariance > 0, axis=1)).sum(axis=1)
    return total


def spikes(values: FloatArray, inside: BoolArray, threshold: float) -> BoolArray:
    """Mask of samples whose distance from the median is above `threshold` standard deviations.

    The standard deviation is estimated from the median absolute deviation of the stretch. Where
    that is zero, the signal hardly changes and nothing is marked. Shapes as for `means`, of one
    signal.
    """
    counts = inside.sum(axis=-1)
    deviation = np.abs(values - _medians(np.where(inside, values, np.nan), counts))
    spread = MAD_TO_SIGMA * _medians(np.where(inside, deviation, np.nan), counts)
    return inside & (deviation > threshold * spread) & (spread > 0)


def _medians(padded: FloatArray, counts: IndexArray) -> FloatArray:
    """Median of each row's numbers, shape (rows, 1).

    NumPy's nanmedian takes many times as long on many short rows.

    Args:
        padded: Numbers, shape (rows, n); NaN where a row has fewer.
        counts: How many numbers each row has.
    """
    if padded.size == 0:
        return np.full((len(padded), 1), np.nan)
    ranked = np.sort(padded, axis=1)
    rows = np.arange(len(padded))
    last = np.maximum(counts - 1, 0)
    lower = ranked[rows, last // 2]
    upper = ranked[rows, (last + 1) // 2]
    return ((lower + upper) / 2)[:, np.newaxis]


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


def changed(values: FloatArray) -> FloatArray:
    """The values that differ from the one before; the first has none before it."""
    return values[np.flatnonzero(np.diff(values)) + 1]


def rows_per_reading(values: FloatArray) -> int:
    """Number of rows in which a logger repeats each value of a slower sensor; else 1.

    Examples:
        >>> rows_per_reading(np.repeat(np.arange(20.0), 6))
        6
        >>> rows_per_reading(np.arange(20.0))
        1
    """
    hold_rows = np.diff(np.flatnonzero(np.diff(values)))
    if len(hold_rows) < _FEWEST_HOLDS:
        return 1
    rows = round(median(hold_rows))
    share_of_equal = np.mean(np.abs(hold_rows - rows) <= 1)
    if rows < _SHORTEST_HOLD_ROWS or share_of_equal < _SMALLEST_SHARE_OF_EQUAL_HOLDS:
        return 1
    return rows


def is_noise(readings: FloatArray) -> bool:
    """Whether readings scatter over several digits. Few digits, a ramp or few values are no noise.

    Args:
        readings: The readings of a signal as `changed` gives them.

    Examples:
        >>> is_noise(np.tile([70.0, 70.1], 50))
        False
        >>> is_noise(np.random.default_rng(1).standard_normal(100))
        True
    """
    if len(readings) < _READINGS_COMPARED:
        return False
    windows = np.lib.stride_tricks.sliding_window_view(readings, _READINGS_COMPARED)
    ranked = np.sort(windows, axis=1)
    differs = np.diff(ranked, axis=1) > _CONVERSION_ROUNDING * np.abs(readings).max()
    different_values = differs.sum(axis=1) + 1
    change = np.diff(readings)
    share_of_turns = np.mean(change[1:] * change[:-1] < 0)
    return bool(
        median(different_values) >= _FEWEST_DIFFERENT and share_of_turns >= _SMALLEST_SHARE_OF_TURNS
    )


def median(values: FloatArray | IndexArray) -> float:
    """Median of numbers, shape (n,); NaN where one of them is NaN, or where there is none.

    NumPy's median selects two order statistics. For the 5000 rows of a run this takes seven times
    as long as sorting, which uses the vector instructions of the processor.

    Examples:
        >>> median(np.array([3.0, 1.0, 2.0, 10.0]))
        2.5
    """
    ranked = np.sort(values)
    if len(ranked) == 0 or np.isnan(ranked[-1]):
        return np.nan
    return float((ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2]) / 2)
