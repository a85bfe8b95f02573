"""What is fitted: accepted points as curves, and which constants they can give at all.

Decides: which points are fitted.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

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
        load_n: Load of each curve.
        curve: Curve of each point, rising.
        slip: Slide-roll ratio of each point, 0 or more.
    """

    conditions: FloatArray
    load_n: FloatArray
    curve: IndexArray
    slip: FloatArray

    def at(self, law: Law) -> Observations:
        """The points as a law takes them."""
        return Observations(law.design(self.conditions), self.curve, self.slip)


@dataclass(frozen=True)
class CurveData(Curves):
    """Accepted points of one oil; a curve is one run at its mean measured conditions.

    Attributes:
        runs: Run of each curve.
        mu: Traction coefficient of each point.
    """

    runs: list[str]
    mu: FloatArray


@dataclass(frozen=True)
class Problem:
    """Least squares of a law on data, over the constants that the data can give.

    `varied` are the conditions that a fit follows. The other constants (`free` false) are exponents
    that the law itself gives, and those of conditions that did not vary: held at zero, they leave
    the condition's effect inside the law's coefficients. `held` are the indices and values of those
    that ran into a bound and stay there; `weight` is that of each point's squared error, 1 where it
    is None.
    """

    law: Law
    data: CurveData
    varied: BoolArray
    at: Observations
    mu: FloatArray
    free: BoolArray
    held: tuple[tuple[int, float], ...] = ()
    weight: FloatArray | None = None

    @property
    def curves(self) -> int:
        """Number of curves."""
        return len(self.at.design)

    @cached_property
    def starts(self) -> IndexArray:
        """First point of each curve; points are in the order of their curves."""
        return np.searchsorted(self.at.curve, np.arange(self.curves))

    @cached_property
    def lengths(self) -> IndexArray:
        """Number of points of each curve."""
        return np.diff(self.starts, append=len(self.mu))

    @cached_property
    def names(self) -> list[str]:
        """Names of the free constants.

        Where a condition did not vary, its level is inside X0: what the data then give is the
        coefficient X at that level and at the reference of the others, and it is named so.
        """
        return [self._all_names[index] for index in np.flatnonzero(self.free)]

    def beyond(self, values: FloatArray) -> FloatArray:
        """How far free constants, shape (..., free), lie outside their bounds, 0 within."""
        low, high = self.limits.T
        return np.maximum(np.maximum(low - values, values - high), 0.0) / (high - low)

    @cached_property
    def at_bounds(self) -> dict[str, float]:
        """The constants that stay at a bound, in the form of the law's equation."""
        signs = self.law.signs
        return {
            self._all_names[index]: signs[index] * np.exp(value) if signs[index] else value
            for index, value in self.held
        }

    @cached_property
    def _all_names(self) -> list[str]:
        if self.followed.all():
            return [constant.name for constant in self.law.constants]
        local = {f"{name}0": name for name in self.law.local_constants}
        return [local.get(constant.name, constant.name) for constant in self.law.constants]

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
        # all of them at the reference at once is what a group that does not count looks like
        return np.asarray(np.any(self.at.design[:, 1:] != 0, axis=0))

    def holding(self, values: FloatArray, which: BoolArray) -> "Problem":
        """The same problem with some of its free constants held where they are."""
        indices = np.flatnonzero(self.free)[which]
        held = (*self.held, *zip(indices.tolist(), values[which].tolist(), strict=True))
        free = self.free.copy()
        free[indices] = False
        return replace(self, free=free, held=held)

    def thinned(self, points: int) -> "Problem":
        """The same problem with every n-th point of each curve, about so many in all."""
        step, curve = max(len(self.mu) // points, 1), np.arange(self.curves)
        # other slips of each curve
        first = self.starts + curve % np.minimum(self.lengths, step)
        kept = (np.arange(len(self.mu)) - first[self.at.curve]) % step == 0
        at = replace(self.at, curve=self.at.curve[kept], slip=self.at.slip[kept])
        return replace(self, at=at, mu=self.mu[kept])

    def reported(self, values: FloatArray) -> FloatArray:
        """Free constants in the form of the law's equation; shape (..., free)."""
        return to_constants(self.signs, values)

    def expand(self, values: FloatArray) -> FloatArray:
        """All internal constants from the free ones; (free,) or (free, population)."""
        full = np.empty((len(self.free), *values.shape[1:]))
        full.T[:] = self.law.known
        for index, value in self.held:
            full[index] = value
        full[self.free] = values
        return full

    def residual(self, values: FloatArray) -> FloatArray:
        """Fitted minus measured mu at each point."""
        return self.law.traction(self.expand(values), self.at) - self.mu

    def by_slip(self, values: FloatArray) -> FloatArray:
        """S dmu/dS at each point."""
        return self.law.jacobian(self.expand(values), self.at) @ self.law.slip_scale

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Derivatives of the residual by the free constants."""
        return self.law.jacobian(self.expand(values), self.at)[:, self.free]


def curve_data(
    points: pd.DataFrame,
    conditions: Sequence[str] = CONDITIONS,
    key: Callable[[str], Any] | None = None,
) -> CurveData:
    """Accepted points of one oil, gathered by run.

    Args:
        points: Rows of the table of points.
        conditions: Columns that a law's power laws are of.
        key: By which runs are put in order; their names if not given.
    """
    accepted = points[points["accepted"]]
    runs = sorted(map(str, accepted["run_id"].unique()), key=key)
    curve = accepted["run_id"].map(dict(zip(runs, range(len(runs)), strict=True)))
    accepted = accepted.assign(curve=curve.astype(np.int64)).sort_values(["curve", "first_row"])
    # traction is odd in slip: a slightly negative slip is the same point seen from the other side
    side = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    means = accepted.groupby("curve")[[*{*conditions, "load_n"}]].mean()
    return CurveData(
        means[list(conditions)].to_numpy(dtype=float),
        means["load_n"].to_numpy(dtype=float),
        accepted["curve"].to_numpy(),
        side * accepted["slide_roll_ratio"].to_numpy(),
        runs,
        side * accepted["traction_coefficient"].to_numpy(),
    )


def build_problem(law: Law, data: CurveData, varied: BoolArray) -> Problem:
    """The problem of fitting a law to data in which only some conditions vary.

    Raises:
        ValueError: A varied condition has a value at which the law has none, or the law cannot
            follow these conditions alone.
    """
    groups = law.varied_groups(varied)
    follows: dict[str | None, bool] = {None: True}
    follows.update(zip(law.groups, groups.tolist(), strict=True))
    free = np.array(
        [constant.known is None and follows[constant.condition] for constant in law.constants]
    )
    at = Observations(law.design(data.conditions, groups), data.curve, data.slip)
    return Problem(law, data, varied, at, data.mu, free)
