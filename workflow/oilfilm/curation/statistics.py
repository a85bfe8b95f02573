"""Means over plateaus with standard errors that allow for autocorrelated samples.

Plateaus differ in length. Their samples are cut out of the signals into arrays of shape
(..., plateaus, longest plateau), and masks of shape (plateaus, longest plateau) say which of them
count.

Decides: standard errors of autocorrelated samples.
"""

import numpy as np

from oilfilm.units import MAD_TO_SIGMA, BoolArray, FloatArray, IndexArray

# What noise and held values are: definitions behind the gates, whose limits are in the
# configuration.
# Readings that noise of two digits of the resolution, or more, gives among ten: six.
_READINGS, _DIFFERENT = 10, 6
# Noise turns back at two of three readings, or at one of two where it is filtered; a ramp does not.
_LEAST_TURNS = 1 / 4
# Readings closer than this, relative, differ by the rounding of a conversion only.
_ROUNDING = 1e-9

# A sensor holds its values where these last so many rows or more, almost all equally long.
_SHORTEST_HOLD, _EVEN, _FEWEST_HOLDS = 3, 0.9, 10

# Noise is seldom alike over more samples than this; a drift or a hum is.
_NEAR_LAGS = 8


def cut(signals: FloatArray, starts: IndexArray, stops: IndexArray) -> tuple[FloatArray, BoolArray]:
    """Stretches of signals from each start to before each stop, and the mask of their samples.

    Args:
        signals: One or several, shape (..., samples).
        starts: First index of each stretch.
        stops: The index past its last one; it must be larger.
    """
    lengths = stops - starts
    longest = int(lengths.max(initial=0))
    stretches = np.zeros((*signals.shape[:-1], len(starts), longest))
    # slice by slice, which is faster than one array of indices
    for place, (start, stop) in enumerate(zip(starts.tolist(), stops.tolist(), strict=True)):
        stretches[..., place, : stop - start] = signals[..., start:stop]
    return stretches, np.arange(longest) < lengths[:, np.newaxis]


def first_part(inside: BoolArray, share: float) -> BoolArray:
    """The mask of the first `share` of the samples of each stretch."""
    place = np.cumsum(inside, axis=-1)
    return inside & (place <= place[:, -1:] * share)


def means(values: FloatArray, inside: BoolArray) -> FloatArray:
    """Mean of each stretch, shape (..., stretches); NaN where none of its samples counts.

    Args:
        values: Stretches of signals as `cut` gives them.
        inside: Which of their samples count.
    """
    # not BLAS: the last digit must not hang on the processor or its threads
    total = np.einsum("...ij,ij->...i", values, inside.astype(float))
    counts = inside.sum(axis=-1)
    return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)


def standard_errors(
    values: FloatArray, inside: BoolArray, mean: FloatArray | None = None
) -> FloatArray:
    """Standard error of each mean, autocorrelation included; NaN with fewer than two samples.

        se^2 = s^2 / n (1 + 2 sum_k rho_k)

    with rho_k the autocorrelation at lag k, summed up to its first value that is not positive.
    Shapes as for `means`; `mean` is what that gives, where it is known already.

    Reference: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992) 473,
    section 3.3 (the initial positive sequence, here over single lags).
    """
    counts, mean = inside.sum(axis=-1), means(values, inside) if mean is None else mean
    residual = np.where(inside, values - mean[..., np.newaxis], 0.0)
    squares = np.einsum("...ij,...ij->...i", residual, residual)
    lagged = _sum_of_lags(residual.reshape(mean.size, inside.shape[1])).reshape(mean.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = (squares + 2 * lagged) / (counts - 1)
        return np.where(counts > 1, np.sqrt(variance / counts), np.nan)


def _sum_of_lags(residual: FloatArray) -> FloatArray:
    """Autocovariances of each row over all lags up to the first that is not positive.

    Most rows end within a few lags, which cost little; the few others are transformed.
    """
    total = np.zeros(len(residual))
    rows = np.arange(len(residual))
    for lag in range(1, min(_NEAR_LAGS + 1, residual.shape[1])):
        covariance = np.einsum("ij,ij->i", residual[:, lag:], residual[:, :-lag])
        positive = covariance > 0
        rows, residual = rows[positive], residual[positive]
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
    """Samples further from their stretch's median than `threshold` robust standard deviations.

    A signal that hardly changes has no spread to judge by: where the median deviation is zero,
    nothing is flagged. Shapes as for `means`, of one signal.
    """
    counts = inside.sum(axis=-1)
    deviation = np.abs(values - _medians(np.where(inside, values, np.nan), counts))
    spread = MAD_TO_SIGMA * _medians(np.where(inside, deviation, np.nan), counts)
    return inside & (deviation > threshold * spread) & (spread > 0)


def _medians(padded: FloatArray, counts: IndexArray) -> FloatArray:
    """Median of each row's first numbers, the others being NaN: shape (rows, 1).

    NumPy's nanmedian takes many times as long on many short rows.
    """
    if padded.size == 0:
        return np.full((len(padded), 1), np.nan)
    ranked = np.sort(padded, axis=1)
    rows, last = np.arange(len(padded)), np.maximum(counts - 1, 0)
    return ((ranked[rows, last // 2] + ranked[rows, (last + 1) // 2]) / 2)[:, np.newaxis]


def longest_hold(values: FloatArray) -> tuple[int, int]:
    """First row of the longest stretch of one and the same value, and the row behind its last.

    Examples:
        >>> longest_hold(np.array([3.0, 1.0, 1.0, 1.0, 2.0]))
        (1, 4)
    """
    edges = np.concatenate([[0], np.flatnonzero(values[1:] != values[:-1]) + 1, [len(values)]])
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1])


def changed(values: FloatArray) -> FloatArray:
    """The values without those that repeat the one before."""
    return values[np.flatnonzero(np.diff(values)) + 1]


def rows_per_reading(values: FloatArray) -> int:
    """In how many rows a logger writes each value of a slower sensor (sample and hold); else 1.

    Examples:
        >>> rows_per_reading(np.repeat(np.arange(20.0), 6))
        6
        >>> rows_per_reading(np.arange(20.0))
        1
    """
    holds = np.diff(np.flatnonzero(np.diff(values)))
    rows = round(median(holds)) if len(holds) >= _FEWEST_HOLDS else 1
    return rows if rows >= _SHORTEST_HOLD and np.mean(np.abs(holds - rows) <= 1) >= _EVEN else 1


def is_noise(readings: FloatArray) -> bool:
    """True for readings that scatter over several digits; False for few digits, a ramp, few values.

    Args:
        readings: The readings of a signal as `changed` gives them.

    Examples:
        >>> is_noise(np.tile([70.0, 70.1], 50))
        False
        >>> is_noise(np.random.default_rng(1).standard_normal(100))
        True
    """
    if len(readings) < _READINGS:
        return False
    ranked = np.sort(np.lib.stride_tricks.sliding_window_view(readings, _READINGS), axis=1)
    apart = np.diff(ranked, axis=1) > _ROUNDING * np.abs(readings).max()
    change = np.diff(readings)
    turns = np.mean(change[1:] * change[:-1] < 0)
    return bool(median(apart.sum(axis=1) + 1) >= _DIFFERENT and turns >= _LEAST_TURNS)


def median(values: FloatArray | IndexArray) -> float:
    """Median of numbers, shape (n,); NaN where one of them is NaN, or where there is none.

    NumPy selects two order statistics, which takes seven times as long as to sort a run's 5000 rows
    with the vector instructions of the processor.

    Examples:
        >>> median(np.array([3.0, 1.0, 2.0, 10.0]))
        2.5
    """
    ranked = np.sort(values)
    if len(ranked) == 0 or np.isnan(ranked[-1]):
        return np.nan
    return float((ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2]) / 2)
