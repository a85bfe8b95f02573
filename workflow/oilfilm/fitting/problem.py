"""What is fitted: accepted points as curves, and which constants they can give at all."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.traction.law import (
    CONDITIONS,
    FloatArray,
    IndexArray,
    Law,
    Observations,
    bounds,
)

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class CurveData:
    """Accepted points of one oil; a curve is one run at its mean measured conditions.

    Attributes:
        runs: Run of each curve.
        conditions: (P in GPa, U in m/s, T in degC) of each curve, NaN where unknown.
        curve: Curve of each point.
        slip: Slide-roll ratio of each point, 0 or more.
        mu: Traction coefficient of each point.
        mu_se: Its standard error, NaN where unknown.
    """

    runs: list[str]
    conditions: FloatArray
    curve: IndexArray
    slip: FloatArray
    mu: FloatArray
    mu_se: FloatArray


@dataclass(frozen=True)
class Problem:
    """Least squares of a law on data, over the constants that the data can give.

    The others (`free` false) are exponents of conditions that did not vary; they are held at
    zero, and the condition's effect is then inside the law's coefficients.
    """

    law: Law
    at: Observations
    mu: FloatArray
    free: BoolArray

    @property
    def curves(self) -> int:
        """Number of curves."""
        return len(self.at.design)

    @cached_property
    def starts(self) -> IndexArray:
        """First point of each curve; points lie in the order of their curves."""
        return np.searchsorted(self.at.curve, np.arange(self.curves))

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds of the free internal constants."""
        lower, upper = bounds(self.law)[self.free].T
        return lower, upper

    @cached_property
    def names(self) -> list[str]:
        """Names of the free constants.

        Where a condition did not vary, its level is inside X0: what the data then give is the
        coefficient X at that level and at the reference of the others, and it is named so.
        """
        constants = [one for one, free in zip(self.law.constants, self.free, strict=True) if free]
        whole = bool(self.free.all())
        local = iter(self.law.local_constants)
        return [one.name if one.condition or whole else next(local) for one in constants]

    @cached_property
    def signs(self) -> IndexArray:
        """Sign of each free constant, 0 for exponents."""
        return np.array([constant.sign for constant in self.law.constants])[self.free]

    @property
    def logarithmic(self) -> BoolArray:
        """True for the free constants whose internal form is a logarithm."""
        return np.asarray(self.signs != 0)

    def reported(self, values: FloatArray) -> FloatArray:
        """Free constants as they stand in the law's equation; shape (..., free)."""
        sizes = np.exp(np.where(self.logarithmic, values, 0.0))
        return np.where(self.logarithmic, self.signs * sizes, values)

    def expand(self, values: FloatArray) -> FloatArray:
        """All internal constants from the free ones; (free,) or (free, population)."""
        full = np.zeros((len(self.free), *values.shape[1:]))
        full[self.free] = values
        return full

    def residual(self, values: FloatArray) -> FloatArray:
        """Fitted minus measured mu at each point."""
        return self.law.traction(self.expand(values), self.at) - self.mu

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Derivatives of the residual by the free constants."""
        return self.law.jacobian(self.expand(values), self.at)[:, self.free]


def curve_data(points: pd.DataFrame, conditions: Sequence[str] = CONDITIONS) -> CurveData:
    """Accepted points of one oil, gathered by run.

    Args:
        points: Rows of the table of points.
        conditions: Columns that a law's power laws are of.
    """
    accepted = points[points["accepted"]].sort_values(["run_id", "first_row"])
    codes, runs = pd.factorize(accepted["run_id"], sort=True)
    # traction is odd in slip: a slightly negative slip is the same point seen from the other side
    side = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    levels = accepted.groupby("run_id", sort=True)[list(conditions)].mean()
    return CurveData(
        [str(run) for run in runs],
        levels.to_numpy(dtype=float).reshape(-1, len(conditions)),
        codes.astype(np.int64),
        side * accepted["slide_roll_ratio"].to_numpy(),
        side * accepted["traction_coefficient"].to_numpy(),
        accepted["traction_coefficient_se"].to_numpy(dtype=float),
    )


def varied_conditions(conditions: FloatArray, settings: Mapping[str, Any]) -> BoolArray:
    """Which conditions vary enough over the curves to give an exponent.

    A condition counts as varied when it is known for every curve and its range is at least
    `min_relative_range` of its largest magnitude, and it does not vary in step with another one.
    """
    if len(conditions) == 0 or np.isnan(conditions).all():
        return np.zeros(conditions.shape[1], dtype=bool)
    low, high = conditions.min(axis=0), conditions.max(axis=0)
    size = np.maximum(np.abs(low), np.abs(high))
    alone = np.asarray((high > low) & (high - low >= settings["min_relative_range"] * size))
    return alone & ~_vary_together(conditions, alone, settings)


def _vary_together(
    conditions: FloatArray, among: BoolArray, settings: Mapping[str, Any]
) -> BoolArray:
    """Which of these conditions vary only together with others, so that no fit tells them apart.

    Judged by the singular values of the standardised conditions over the curves; too few curves
    are one case of it.
    """
    together = np.zeros(len(among), dtype=bool)
    varied = conditions[:, among]
    if varied.shape[1] < 2:
        return together
    standardised = (varied - varied.mean(axis=0)) / varied.std(axis=0)
    _, sizes, directions = np.linalg.svd(standardised, full_matrices=True)
    padded = np.zeros(varied.shape[1])
    padded[: len(sizes)] = sizes
    unknown = directions[padded <= settings["smallest_singular_value"] * padded[0]]
    together[among] = (np.abs(unknown) > settings["largest_unknown_share"]).any(axis=0)
    return together


def build_problem(law: Law, data: CurveData, varied: BoolArray) -> Problem:
    """The problem of fitting a law to data in which only some conditions vary.

    Raises:
        ValueError: A varied condition has a value at which the law has none.
    """
    free = np.array(
        [
            constant.condition is None or bool(varied[law.conditions.index(constant.condition)])
            for constant in law.constants
        ]
    )
    design = law.design(np.where(varied, data.conditions, 1.0))
    return Problem(law, Observations(design, data.curve, data.slip), data.mu, free)
