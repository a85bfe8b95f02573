"""Means over plateaus with standard errors that know that neighbouring samples are alike."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oilfilm.curation.plateaus import MAD_TO_SIGMA
from oilfilm.curation.signals import FloatArray, IndexArray

BoolArray = npt.NDArray[np.bool_]

# Noise is seldom alike over more samples than this; a drift or a hum is.
_NEAR_LAGS = 8


@dataclass(frozen=True)
class Windows:
    """Stretches of samples, padded to one length: `index` and `inside` have a row a stretch."""

    index: IndexArray
    inside: BoolArray

    @classmethod
    def between(cls, starts: IndexArray, stops: IndexArray) -> "Windows":
        """Stretches from each start to before each stop; empty ones must not be among them."""
        offsets = np.arange(int((stops - starts).max(initial=0)))
        index = starts[:, np.newaxis] + offsets
        inside = index < stops[:, np.newaxis]
        return cls(np.where(inside, index, starts[:, np.newaxis]), inside)

    def without(self, flagged: BoolArray) -> "Windows":
        """The same stretches with some samples left out; `flagged` has the shape of `index`."""
        return Windows(self.index, self.inside & ~flagged)

    @cached_property
    def counts(self) -> IndexArray:
        """Samples in each stretch."""
        return self.inside.sum(axis=1)

    def split(self, share: float) -> tuple["Windows", "Windows"]:
        """The first `share` of the samples of each stretch, and the rest of them."""
        place = np.cumsum(self.inside, axis=1)
        early = place <= self.counts[:, np.newaxis] * share
        return self.without(~early), self.without(early)


def means(values: FloatArray, windows: Windows) -> FloatArray:
    """Means of signals over each stretch; NaN where a stretch is empty.

    Args:
        values: One signal or several, shape (..., samples).
        windows: The stretches.

    Returns:
        Shape (..., stretches).
    """
    counts = windows.counts
    total = np.where(windows.inside, np.take(values, windows.index, axis=-1), 0.0).sum(axis=-1)
    return np.divide(total, counts, out=np.full(total.shape, np.nan), where=counts > 0)


def standard_errors(values: FloatArray, windows: Windows) -> FloatArray:
    """Standard error of each mean, autocorrelation included; NaN with fewer than two samples.

        se^2 = s^2 / n (1 + 2 sum_k rho_k)

    with rho_k the autocorrelation at lag k, summed up to its first value that is not positive.
    Shapes as for `means`.

    Reference: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992) 473,
    section 3.3 (the initial positive sequence, here over single lags).
    """
    counts, mean = windows.counts, means(values, windows)
    if windows.index.size == 0:
        return mean
    about = np.take(values, windows.index, axis=-1) - mean[..., np.newaxis]
    residual = np.where(windows.inside, about, 0.0)
    squares = np.vecdot(residual, residual)
    lagged = _sum_of_lags(residual.reshape(-1, residual.shape[-1])).reshape(squares.shape)
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
        covariance = np.vecdot(residual[:, lag:], residual[:, :-lag])
        positive = covariance > 0
        rows, residual = rows[positive], residual[positive]
        total[rows] += covariance[positive]
    if len(rows) == 0:
        return total
    length = residual.shape[1]
    spectrum = np.fft.rfft(residual, 2 * length, axis=1)
    covariance = np.fft.irfft(np.abs(spectrum) ** 2, 2 * length, axis=1)[:, 1:length]
    total[rows] = (covariance * np.cumprod(covariance > 0, axis=1)).sum(axis=1)
    return total


def spikes(values: FloatArray, windows: Windows, threshold: float) -> BoolArray:
    """Samples further from their stretch's median than `threshold` robust standard deviations.

    A signal that hardly changes has no spread to judge by: where the median deviation is zero,
    nothing is flagged.
    """
    inside = np.where(windows.inside, values[windows.index], np.nan)
    deviation = np.abs(inside - _medians(inside, windows.counts))
    spread = MAD_TO_SIGMA * _medians(deviation, windows.counts)
    return np.asarray((deviation > threshold * spread) & (spread > 0))


def _medians(padded: FloatArray, counts: IndexArray) -> FloatArray:
    """Median of each row's first numbers, the others being NaN: shape (rows, 1).

    NumPy's nanmedian takes many times as long on many short rows.
    """
    if padded.size == 0:
        return np.full((len(padded), 1), np.nan)
    ranked = np.sort(padded, axis=1)
    rows, last = np.arange(len(padded)), np.maximum(counts - 1, 0)
    return ((ranked[rows, last // 2] + ranked[rows, (last + 1) // 2]) / 2)[:, np.newaxis]
