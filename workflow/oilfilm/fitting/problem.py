"""What is fitted: accepted points as curves, and which constants they can give at all."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.traction.law import CONDITIONS, FloatArray, IndexArray, Law, Observations

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
    """

    runs: list[str]
    conditions: FloatArray
    curve: IndexArray
    slip: FloatArray
    mu: FloatArray


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


def curve_data(points: pd.DataFrame) -> CurveData:
    """Accepted points of one oil, gathered by run."""
    accepted = points[points["accepted"]].sort_values(["run_id", "first_row"])
    codes, runs = pd.factorize(accepted["run_id"], sort=True)
    # traction is odd in slip: a slightly negative slip is the same point seen from the other side
    side = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    conditions = accepted.groupby("run_id", sort=True)[list(CONDITIONS)].mean()
    return CurveData(
        [str(run) for run in runs],
        conditions.to_numpy(dtype=float).reshape(-1, len(CONDITIONS)),
        codes.astype(np.int64),
        side * accepted["slide_roll_ratio"].to_numpy(),
        side * accepted["traction_coefficient"].to_numpy(),
    )


def varied_conditions(conditions: FloatArray, settings: Mapping[str, Any]) -> BoolArray:
    """Which conditions vary enough over the curves to give an exponent.

    A condition counts as varied when it is known for every curve and its range is at least
    `min_relative_range` of its largest magnitude, and it does not vary in step with another one.
    """
    if len(conditions) == 0 or np.isnan(conditions).all():
        return np.zeros(len(CONDITIONS), dtype=bool)
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
            constant.condition is None or bool(varied[CONDITIONS.index(constant.condition)])
            for constant in law.constants
        ]
    )
    design = law.design(np.where(varied, data.conditions, 1.0))
    return Problem(law, Observations(design, data.curve, data.slip), data.mu, free)
