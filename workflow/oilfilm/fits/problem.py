"""Least squares of a law on accepted points, over the constants that the points can give.

Decides: which points are fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.traction.law import CONDITIONS, Law, Observations, bounds, to_constants


@dataclass(frozen=True)
class Curves:
    """Points of curves, measured or to be measured.

    Attributes:
        conditions: The law's conditions of each curve, shape (curves, conditions), NaN where
            unknown.
        load_n: Load of each curve, shape (curves,).
        curve: Curve of each point, counted from 0 and rising, shape (points,).
        slip: Slide-roll ratio of each point, 0 or more, shape (points,).
    """

    conditions: FloatArray
    load_n: FloatArray
    curve: IndexArray
    slip: FloatArray

    def observations(self, law: Law) -> Observations:
        """The points in the form in which a law is evaluated."""
        return Observations(law.design(self.conditions), self.curve, self.slip)


@dataclass(frozen=True)
class CurveData(Curves):
    """Accepted points of one oil; a curve is one run at its mean measured conditions.

    Attributes:
        runs: Run of each curve.
        mu: Traction coefficient of each point, shape (points,).
        mu_se: Random standard error of mu, by the readings of the point; NaN where unknown.
        slip_se: The same of the slip.
    """

    runs: list[str]
    mu: FloatArray
    mu_se: FloatArray
    slip_se: FloatArray


@dataclass(frozen=True)
class Problem:
    """Least squares of a law on data, over the constants that the data can give.

    Constants that are not free are of three kinds. Some exponents are prescribed by the law.
    Exponents of conditions that did not vary are zero: the effect of such a condition is then
    inside the law's coefficients. Constants that ran into a bound are held there.

    Attributes:
        law: The law.
        data: The accepted points.
        varied: Which conditions of the law the fit follows, shape (conditions,).
        observations: The points in the form in which the law is evaluated.
        mu: Measured traction coefficient of each point, shape (points,).
        free: Which constants of the law are fitted, shape (constants,).
        held: Index and internal value of each constant that is held at a bound.
        weight: Weight of each point's squared error, shape (points,); None where all are 1.
    """

    law: Law
    data: CurveData
    varied: BoolArray
    observations: Observations
    mu: FloatArray
    free: BoolArray
    held: tuple[tuple[int, float], ...] = ()
    weight: FloatArray | None = None

    @property
    def curves(self) -> int:
        """Number of curves."""
        return len(self.observations.design)

    @cached_property
    def starts(self) -> IndexArray:
        """First point of each curve; points are in the order of their curves."""
        return np.searchsorted(self.observations.curve, np.arange(self.curves))

    @cached_property
    def lengths(self) -> IndexArray:
        """Number of points of each curve."""
        return np.diff(self.starts, append=len(self.mu))

    @cached_property
    def names(self) -> list[str]:
        """Names of the free constants.

        Where a condition did not vary, its level is inside X0. The data then give the coefficient
        X at that level and at the reference of the others. It has the name X.
        """
        return [self._all_names[index] for index in np.flatnonzero(self.free)]

    def beyond(self, values: FloatArray) -> FloatArray:
        """Distance of free constants from their bounds, in ranges of the bounds; 0 within.

        Args:
            values: Free internal constants, shape (..., free).
        """
        low, high = self.limits.T
        outside = np.maximum(low - values, values - high)
        return np.maximum(outside, 0.0) / (high - low)

    @cached_property
    def at_bounds(self) -> dict[str, float]:
        """Value of each constant that is held at a bound, in the form of the law's equation."""
        values = {}
        for index, internal in self.held:
            sign = self.law.signs[index]
            values[self._all_names[index]] = sign * np.exp(internal) if sign else internal
        return values

    @cached_property
    def _all_names(self) -> list[str]:
        """Names of all constants. If a group did not vary, a coefficient A0 is named A."""
        names = [constant.name for constant in self.law.constants]
        if self.followed.all():
            return names
        coefficient_names = {f"{name}0": name for name in self.law.coefficient_names}
        return [coefficient_names.get(name, name) for name in names]

    @cached_property
    def signs(self) -> IndexArray:
        """Sign of each free constant, 0 for exponents."""
        return self.law.signs[self.free]

    @cached_property
    def linear(self) -> BoolArray:
        """True for the free constants ln|X0| with mu linear in X0."""
        return self.law.linear_in[self.free]

    @cached_property
    def limits(self) -> FloatArray:
        """Bounds of the free internal constants, shape (free, 2)."""
        return bounds(self.law)[self.free]

    @cached_property
    def followed(self) -> BoolArray:
        """Which groups of the law varied."""
        # a group that does not count has its reference value, logarithm 0, in every curve
        return np.asarray(np.any(self.observations.design[:, 1:] != 0, axis=0))

    def holding(self, values: FloatArray, which: BoolArray) -> "Problem":
        """The same problem with some of its free constants held at their values.

        Args:
            values: Free internal constants, shape (free,).
            which: Which of them are held, shape (free,).
        """
        indices = np.flatnonzero(self.free)[which]
        newly_held = zip(indices.tolist(), values[which].tolist(), strict=True)
        free = self.free.copy()
        free[indices] = False
        return replace(self, free=free, held=self.held + tuple(newly_held))

    def thinned(self, points: int) -> "Problem":
        """The same problem with every n-th point of each curve, about `points` in all."""
        step = max(len(self.mu) // points, 1)
        # each curve begins at another of its points, so that more slips are kept
        offset = np.arange(self.curves) % np.minimum(self.lengths, step)
        first_kept = self.starts + offset
        curve = self.observations.curve
        kept = (np.arange(len(self.mu)) - first_kept[curve]) % step == 0
        observations = replace(
            self.observations, curve=curve[kept], slip=self.observations.slip[kept]
        )
        return replace(self, observations=observations, mu=self.mu[kept])

    def reported(self, values: FloatArray) -> FloatArray:
        """Free constants in the form of the law's equation; shape (..., free)."""
        return to_constants(self.signs, values)

    def expand(self, values: FloatArray) -> FloatArray:
        """All internal constants from the free ones; (free,) or (free, population)."""
        population = values.shape[1:]
        full = np.empty((len(self.free), *population))
        full.T[:] = self.law.prescribed
        for index, value in self.held:
            full[index] = value
        full[self.free] = values
        return full

    def residual(self, values: FloatArray) -> FloatArray:
        """Fitted minus measured mu at each point, shape (points,)."""
        return self.law.traction(self.expand(values), self.observations) - self.mu

    def slip_slope(self, values: FloatArray) -> FloatArray:
        """S dmu/dS at each point, shape (points,)."""
        return self.law.jacobian(self.expand(values), self.observations) @ self.law.slip_scale

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Derivatives of the residual by the free constants, shape (points, free)."""
        return self.law.jacobian(self.expand(values), self.observations)[:, self.free]


def curve_data(points: pd.DataFrame, conditions: Sequence[str] = CONDITIONS) -> CurveData:
    """Accepted points of one oil, grouped by run.

    Args:
        points: Rows of the table of points.
        conditions: Columns of the law's conditions.
    """
    averaged = list(dict.fromkeys([*conditions, "load_n"]))
    errors = ["traction_coefficient_se", "slide_roll_ratio_se"]
    values = ["first_row", *averaged, "slide_roll_ratio", "traction_coefficient", *errors]
    is_accepted = points["accepted"]
    # names of runs, and columns that no law needs, would take most of the memory
    accepted = points.loc[is_accepted, points.columns.intersection(values)]
    number, names = pd.factorize(points.loc[is_accepted, "run_id"])
    runs = sorted(map(str, names))
    number_of_run = {run: number for number, run in enumerate(runs)}
    curve_of_name = np.array([number_of_run[str(name)] for name in names], dtype=np.int64)
    accepted = accepted.assign(curve=curve_of_name[number]).sort_values(["curve", "first_row"])
    # traction is odd in slip: a slightly negative slip is the same point seen from the other side
    side = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    # arrays have no readings, and so no such columns
    standard_errors = accepted.reindex(columns=errors)
    means = accepted.groupby("curve")[averaged].mean()
    return CurveData(
        conditions=means[list(conditions)].to_numpy(dtype=float),
        load_n=means["load_n"].to_numpy(dtype=float),
        curve=accepted["curve"].to_numpy(),
        slip=side * accepted["slide_roll_ratio"].to_numpy(),
        runs=runs,
        mu=side * accepted["traction_coefficient"].to_numpy(),
        mu_se=standard_errors["traction_coefficient_se"].to_numpy(dtype=float),
        slip_se=standard_errors["slide_roll_ratio_se"].to_numpy(dtype=float),
    )


def build_problem(law: Law, data: CurveData, varied: BoolArray) -> Problem:
    """The problem of fitting a law to data in which only some conditions vary.

    Args:
        law: The law.
        data: The accepted points.
        varied: Which conditions of the law the fit follows, shape (conditions,).

    Raises:
        ValueError: A varied condition has a value at which the law has none, or the law cannot
            follow these conditions alone.
    """
    groups = law.varied_groups(varied)
    followed_groups = {name for name, follows in zip(law.groups, groups, strict=True) if follows}
    free = []
    for constant in law.constants:
        # X0 belongs to no condition
        has_effect = constant.condition is None or constant.condition in followed_groups
        free.append(constant.prescribed is None and has_effect)
    observations = Observations(law.design(data.conditions, groups), data.curve, data.slip)
    return Problem(law, data, varied, observations, data.mu, np.array(free))
