"""Means over plateaus with standard errors that know that neighbouring samples are alike."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oilfilm.curation.plateaus import MAD_TO_SIGMA
from oilfilm.curation.signals import FloatArray, IndexArray

BoolArray = npt.NDArray[np.bool_]


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

    @property
    def counts(self) -> IndexArray:
        """Samples in each stretch."""
        return self.inside.sum(axis=1)

    def split(self, share: float) -> tuple["Windows", "Windows"]:
        """The first `share` of the samples of each stretch, and the rest of them."""
        place = np.cumsum(self.inside, axis=1)
        early = place <= self.counts[:, np.newaxis] * share
        return self.without(~early), self.without(early)


def means(values: FloatArray, windows: Windows) -> FloatArray:
    """Mean of a signal over each stretch; NaN where a stretch is empty."""
    total = np.where(windows.inside, values[windows.index], 0.0).sum(axis=1)
    counts = windows.counts
    return np.divide(total, counts, out=np.full(len(counts), np.nan), where=counts > 0)


def standard_errors(values: FloatArray, windows: Windows) -> FloatArray:
    """Standard error of each mean, autocorrelation included; NaN with fewer than two samples.

        se^2 = s^2 / n (1 + 2 sum_k rho_k)

    with rho_k the autocorrelation at lag k, summed up to its first value that is not positive.

    Reference: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992) 473,
    section 3.3 (the initial positive sequence, here over single lags).
    """
    counts = windows.counts
    if windows.index.size == 0:
        return np.full(len(counts), np.nan)
    residual = np.where(
        windows.inside, values[windows.index] - means(values, windows)[:, np.newaxis], 0.0
    )
    length = residual.shape[1]
    spectrum = np.fft.rfft(residual, 2 * length, axis=1)
    covariance = np.fft.irfft(np.abs(spectrum) ** 2, 2 * length, axis=1)[:, :length]
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = np.nan_to_num(covariance / covariance[:, :1])
        positive = np.cumprod(correlation[:, 1:] > 0, axis=1)
        inflation = 1 + 2 * (correlation[:, 1:] * positive).sum(axis=1)
        variance = covariance[:, 0] / (counts - 1)
        return np.where(counts > 1, np.sqrt(variance / counts * inflation), np.nan)


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
