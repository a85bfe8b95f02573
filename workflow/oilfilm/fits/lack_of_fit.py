"""Residuals of a fit in two parts: noise, which repeated runs show, and what the law misses.

Decides: what is noise, and what is lack of fit.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.units import FloatArray, IndexArray

_CONFIDENCE = 0.95
_LARGEST_RATIO = 1e6
# Repeated runs, as advised where there are none.
ADVISED_REPEATS = (2, 5)


@dataclass(frozen=True)
class LackOfFit:
    """Noise and lack of fit, in the unit of the residuals.

    Attributes:
        repeats: Runs that repeat the condition of an earlier one.
        conditions: Conditions that several runs have.
        noise: Standard deviation of a point between repeated runs; NaN without repeats.
        lack: Root-mean-square of what the law's form misses, 0 where the noise explains all of the
            residuals; NaN without repeats.
        ratio: F, mean square of the lack of fit over that of repeats; NaN without repeats.
        limit: 95 % limit of F where the law's form is right.
    """

    repeats: int
    conditions: int
    noise: float
    lack: float
    ratio: float
    limit: float

    @property
    def shown(self) -> bool:
        """Whether the repeats show that the law's form is wrong."""
        return self.ratio > self.limit


def lack_of_fit(
    residual: FloatArray, run: IndexArray, condition: IndexArray, slip: IndexArray, constants: int
) -> LackOfFit:
    """The classical test of lack of fit, where the points of a run share its errors.

    Points of different runs at one condition and one level of slip are repeats. Half the mean
    square of their differences is the variance of a point, its run's error included. It is taken
    from residuals instead of mu, so that small differences of condition and slip do not count.
    What is left of the mean squared residual is the square of what the law misses. The test is

        F = (SSE - SSPE)/(cells - constants) / (SSPE/(n - cells))

    over the means of each run in each cell; a cell is one level of slip at one condition. Because
    the values of a run are not independent, each run counts as one: both degrees of freedom are
    divided by the values per run. That is the most careful choice (lower bound of Greenhouse and
    Geisser); with one value per run it is the classical test.

    Args:
        residual: Of each point.
        run: Run of each point, counted from 0.
        condition: Condition of each point, the same for all points of a run.
        slip: Level of slip of each point.
        constants: Fitted constants.

    References: N. R. Draper, H. Smith, Applied Regression Analysis, 3rd ed. (1998), section 2.1;
        S. W. Greenhouse, S. Geisser, Psychometrika 24 (1959) 95.
    """
    condition_of_run = np.zeros(run.max() + 1, dtype=np.int64)
    condition_of_run[run] = condition
    runs_of_condition = np.bincount(condition_of_run)
    repeats = int(np.sum(runs_of_condition[runs_of_condition > 1] - 1))
    conditions = int(np.sum(runs_of_condition > 1))
    _, cell = np.unique(np.column_stack([condition, slip]), axis=0, return_inverse=True)
    values, cell_of_value = _means(residual, run, cell.ravel())
    per_cell = np.bincount(cell_of_value)
    pure_degrees = len(values) - len(per_cell)
    fit_degrees = len(per_cell) - constants
    if pure_degrees == 0 or fit_degrees <= 0:
        return LackOfFit(repeats, conditions, *[float("nan")] * 4)
    sums = np.bincount(cell_of_value, values)
    pure = float(np.sum(values**2) - np.sum(sums**2 / per_cell))
    # repeats that are copies leave rounding only
    pure = max(pure, float(np.sum(values**2)) / _LARGEST_RATIO)
    ratio = float(np.sum(sums**2 / per_cell)) / fit_degrees / (pure / pure_degrees)
    per_run = len(values) / len(condition_of_run)
    limit = f_limit(fit_degrees / per_run, pure_degrees / per_run)
    noise = _between_runs(residual, run, cell.ravel())
    share = 1 - constants / len(residual)  # of the noise that the fit has not taken up
    unexplained = float(np.mean(residual**2)) - share * noise**2
    lack = float(np.sqrt(max(unexplained, 0.0)))
    return LackOfFit(repeats, conditions, noise, lack, ratio, limit)


def f_limit(above: float, below: float) -> float:
    """95 % quantile of F with these degrees of freedom."""
    return float(scipy.special.fdtri(above, below, _CONFIDENCE))


def _means(
    residual: FloatArray, run: IndexArray, cell: IndexArray
) -> tuple[FloatArray, IndexArray]:
    """Mean residual of each run in each cell, and the cell of each mean."""
    pairs, index = np.unique(np.column_stack([cell, run]), axis=0, return_inverse=True)
    index = index.ravel()
    return np.bincount(index, residual) / np.bincount(index), pairs[:, 0]


def _between_runs(residual: FloatArray, run: IndexArray, cell: IndexArray) -> float:
    """Standard deviation of a point, from differences between runs in one cell."""
    pairs, index = np.unique(np.column_stack([cell, run]), axis=0, return_inverse=True)
    in_run = _squared_differences(residual, index.ravel())
    count_in_run = np.bincount(index.ravel())
    total = _squared_differences(residual, cell)
    count = np.bincount(cell)
    runs = np.bincount(pairs[:, 0])
    across = total - np.bincount(pairs[:, 0], in_run)
    number = (count**2 - np.bincount(pairs[:, 0], count_in_run**2)) / 2
    repeated = runs > 1
    variances = across[repeated] / (2 * number[repeated])
    return float(np.sqrt(np.average(variances, weights=runs[repeated] - 1)))


def _squared_differences(values: FloatArray, group: IndexArray) -> FloatArray:
    """Sum of squared differences over the pairs of each group."""
    centred = values - (np.bincount(group, values) / np.bincount(group))[group]
    return np.asarray(np.bincount(group) * np.bincount(group, centred**2), dtype=float)
