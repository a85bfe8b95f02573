"""Medians and quantiles of the signals of a run, as NumPy gives them, in a fraction of its time.

NumPy selects two order statistics, which takes seven times as long as to sort a run's 5000 rows
with the vector instructions of the processor.
"""

import numpy as np
import numpy.typing as npt

from oilfilm.units import FloatArray


def median(values: FloatArray | npt.NDArray[np.int64]) -> float:
    """Median of numbers, shape (n,); NaN where one of them is NaN, or where there is none.

    Examples:
        >>> median(np.array([3.0, 1.0, 2.0, 10.0]))
        2.5
    """
    ranked = np.sort(values)
    if len(ranked) == 0 or np.isnan(ranked[-1]):
        return np.nan
    return float((ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2]) / 2)


def quantile(values: FloatArray | npt.NDArray[np.int64], share: float) -> float:
    """The number below which a share of the numbers is, interpolated; NaN as for `median`.

    Examples:
        >>> quantile(np.array([0.0, 10.0, 30.0]), 0.75)
        20.0
    """
    ranked = np.sort(values)
    if len(ranked) == 0 or np.isnan(ranked[-1]):
        return np.nan
    place = share * (len(ranked) - 1)
    below = int(place)
    low, high = float(ranked[below]), float(ranked[min(below + 1, len(ranked) - 1)])
    weight = place - below
    # from the nearer end, as NumPy does: the same to the last digit
    near_high = high - (high - low) * (1 - weight)
    return near_high if weight >= 1 / 2 else low + (high - low) * weight
