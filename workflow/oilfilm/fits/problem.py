"""Least squares of a law on accepted points, over the constants that the points can give.

Decides: which points are fitted.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.traction.law import CONDITIONS, Law, Observations, bounds, to_constants


@dataclass(frozen=True)
class Curves:
    """Points of curves that were measured or may be measured, without their mu.

    Attributes:
        conditions: The law's conditions of each curve, shape (curves, conditions), NaN where
            unknown.
        load_n: Load of each curve, shape (curves,).
        curve_of_point: Index of the curve of each point, in ascending order, shape (points,).
        slip: Slide-roll ratio of each point, 0 or more, shape (points,).
    """

    conditions: FloatArray
    load_n: FloatArray
    curve_of_point: IndexArray
    slip: FloatArray

    def observations(self, law: Law) -> Observations:
        """The points in the form in which a law is evaluated."""
        return Observations(law.design(self.conditions), self.curve_of_point, self.slip)


@dataclass(frozen=True)
class CurveData(Curves):
    """Accepted points of one oil; a curve is one run at its mean measured conditions.

    Attributes:
        run_ids: Name of the run of each curve.
        mu: Traction coefficient of each point, shape (points,).
        mu_se: Random standard error of mu, by the readings of the point, shape (points,); NaN where
            unknown.
        slip_se: Random standard error of the slip, shape (points,); NaN where unknown.
    """

    run_ids: list[str]
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
        is_followed_condition: Whether the fit follows each condition of the law, that is, gives
            exponents for it, shape (conditions,).
        observations: The points in the form in which the law is evaluated.
        mu: Measured traction coefficient of each point, shape (points,).
        is_free: Whether each constant of the law is fitted, shape (constants,).
        held_constants: Index and internal value of each constant that is held at a bound.
        weight_of_point: Weight of each point's squared error, shape (points,); None where all are
            1.
    """

    law: Law
    data: CurveData
    is_followed_condition: BoolArray
    observations: Observations
    mu: FloatArray
    is_free: BoolArray
    held_constants: tuple[tuple[int, float], ...] = ()
    weight_of_point: FloatArray | None = None

    @property
    def curve_count(self) -> int:
        """Number of curves."""
        return len(self.observations.design)

    @cached_property
    def first_point_of_curve(self) -> IndexArray:
        """Index of the first point of each curve, shape (curves,); points are sorted by curve."""
        return np.searchsorted(self.observations.curve_of_point, np.arange(self.curve_count))

    @cached_property
    def point_counts(self) -> IndexArray:
        """Number of points of each curve, shape (curves,)."""
        return np.diff(self.first_point_of_curve, append=len(self.mu))

    @cached_property
    def free_names(self) -> list[str]:
        """Names of the free constants.

        Where a condition did not vary, its level is inside X0. The data then give the coefficient
        X at that level and at the reference of the others. The name of this constant is X.
        """
        return [self._constant_names[index] for index in np.flatnonzero(self.is_free)]

    def distance_beyond_bounds(self, constants: FloatArray) -> FloatArray:
        """Distance of free constants beyond their bounds, over the range between them; 0 within.

        Args:
            constants: Free internal constants, shape (..., free).
        """
        low, high = self.free_bounds.T
        distance = np.maximum(low - constants, constants - high)
        return np.maximum(distance, 0.0) / (high - low)

    @cached_property
    def values_at_bounds(self) -> dict[str, float]:
        """Value of each constant held at a bound, in the form of the law's equation, by name."""
        values_by_name = {}
        for constant_index, internal_value in self.held_constants:
            sign = self.law.signs[constant_index]
            values_by_name[self._constant_names[constant_index]] = (
                sign * np.exp(internal_value) if sign else internal_value
            )
        return values_by_name

    @cached_property
    def _constant_names(self) -> list[str]:
        """Names of all constants. If a group has no exponent, the constant A0 is named A."""
        names = [constant.name for constant in self.law.constants]
        if self.group_has_exponent.all():
            return names
        coefficient_names = {f"{name}0": name for name in self.law.coefficient_names}
        return [coefficient_names.get(name, name) for name in names]

    @cached_property
    def signs(self) -> IndexArray:
        """Sign of each free constant, 0 for exponents, shape (free,)."""
        return self.law.signs[self.is_free]

    @cached_property
    def is_linear(self) -> BoolArray:
        """Whether each free constant is a ln|X0| with mu linear in X0, shape (free,)."""
        return self.law.is_linear_x0[self.is_free]

    @cached_property
    def free_bounds(self) -> FloatArray:
        """Bounds of the free internal constants, shape (free, 2)."""
        return bounds(self.law)[self.is_free]

    @cached_property
    def group_has_exponent(self) -> BoolArray:
        """Whether the fit follows each group of the law by an exponent, shape (groups,)."""
        # a group without an exponent has its reference value, logarithm 0, in every curve
        return np.asarray(np.any(self.observations.design[:, 1:] != 0, axis=0))

    def holding(self, constants: FloatArray, is_held: BoolArray) -> "Problem":
        """The same problem with some of its free constants held at their values.

        Args:
            constants: Free internal constants, shape (free,).
            is_held: Whether each of them is held from now on, shape (free,).
        """
        held_indices = np.flatnonzero(self.is_free)[is_held]
        newly_held = zip(held_indices.tolist(), constants[is_held].tolist(), strict=True)
        is_free = self.is_free.copy()
        is_free[held_indices] = False
        return replace(
            self, is_free=is_free, held_constants=self.held_constants + tuple(newly_held)
        )

    def thinned(self, point_count: int) -> "Problem":
        """The same problem with every n-th point of each curve.

        Args:
            point_count: So many points remain, or up to twice as many; at least one per curve.
        """
        step = max(len(self.mu) // point_count, 1)
        # each curve begins at another of its points, so that more slips are kept
        offset = np.arange(self.curve_count) % np.minimum(self.point_counts, step)
        first_kept_point = self.first_point_of_curve + offset
        curve_of_point = self.observations.curve_of_point
        is_kept = (np.arange(len(self.mu)) - first_kept_point[curve_of_point]) % step == 0
        observations = replace(
            self.observations,
            curve_of_point=curve_of_point[is_kept],
            slip=self.observations.slip[is_kept],
        )
        return replace(self, observations=observations, mu=self.mu[is_kept])

    def in_equation_form(self, constants: FloatArray) -> FloatArray:
        """Free internal constants in the form of the law's equation; shape (..., free)."""
        return to_constants(self.signs, constants)

    def expand(self, constants: FloatArray) -> FloatArray:
        """All internal constants from the free ones.

        Args:
            constants: Free internal constants, shape (free,) or (free, population).

        Returns:
            Shape (constants,) or (constants, population).
        """
        population_shape = constants.shape[1:]
        all_constants = np.empty((len(self.is_free), *population_shape))
        all_constants.T[:] = self.law.prescribed
        for constant_index, value in self.held_constants:
            all_constants[constant_index] = value
        all_constants[self.is_free] = constants
        return all_constants

    def residual(self, constants: FloatArray) -> FloatArray:
        """Fitted minus measured mu at each point, shape (points,)."""
        return self.law.traction(self.expand(constants), self.observations) - self.mu

    def slip_slope(self, constants: FloatArray) -> FloatArray:
        """S dmu/dS at each point: change of mu per relative change of slip, shape (points,)."""
        return (
            self.law.jacobian(self.expand(constants), self.observations) @ self.law.slip_direction
        )

    def jacobian(self, constants: FloatArray) -> FloatArray:
        """Derivatives of the residual by the free constants, shape (points, free)."""
        return self.law.jacobian(self.expand(constants), self.observations)[:, self.is_free]


def curve_data(points: pd.DataFrame, condition_columns: Sequence[str] = CONDITIONS) -> CurveData:
    """Accepted points of one oil, grouped by run.

    Args:
        points: Rows of the table of points.
        condition_columns: Columns of the law's conditions.
    """
    averaged_columns = list(dict.fromkeys([*condition_columns, "load_n"]))
    error_columns = ["traction_coefficient_se", "slide_roll_ratio_se"]
    columns = [
        "first_row",
        *averaged_columns,
        "slide_roll_ratio",
        "traction_coefficient",
        *error_columns,
    ]
    is_accepted = points["accepted"]
    # names of runs, and columns that no law needs, would take most of the memory
    accepted = points.loc[is_accepted, points.columns.intersection(columns)]
    run_of_point, distinct_run_ids = pd.factorize(points.loc[is_accepted, "run_id"])
    run_ids = sorted(map(str, distinct_run_ids))
    curve_by_run_id = {run_id: curve_index for curve_index, run_id in enumerate(run_ids)}
    curve_of_run = np.array(
        [curve_by_run_id[str(run_id)] for run_id in distinct_run_ids], dtype=np.int64
    )
    accepted = accepted.assign(curve=curve_of_run[run_of_point]).sort_values(["curve", "first_row"])
    # traction is odd in slip: a slightly negative slip is the same point seen from the other side
    slip_sign = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    # points that a Python user gives as arrays have no readings, and so no such columns
    standard_errors = accepted.reindex(columns=error_columns)
    means = accepted.groupby("curve")[averaged_columns].mean()
    return CurveData(
        conditions=means[list(condition_columns)].to_numpy(dtype=float),
        load_n=means["load_n"].to_numpy(dtype=float),
        curve_of_point=accepted["curve"].to_numpy(),
        slip=slip_sign * accepted["slide_roll_ratio"].to_numpy(),
        run_ids=run_ids,
        mu=slip_sign * accepted["traction_coefficient"].to_numpy(),
        mu_se=standard_errors["traction_coefficient_se"].to_numpy(dtype=float),
        slip_se=standard_errors["slide_roll_ratio_se"].to_numpy(dtype=float),
    )


def build_problem(law: Law, data: CurveData, is_followed_condition: BoolArray) -> Problem:
    """The problem of fitting a law to data in which only some conditions vary.

    Args:
        law: The law.
        data: The accepted points.
        is_followed_condition: Whether the fit follows each condition of the law, shape
            (conditions,).

    Raises:
        ValueError: A varied condition has a value at which the law has none, or the law cannot
            follow these conditions alone.
    """
    group_has_exponent = law.varied_groups(is_followed_condition)
    groups_with_exponent = set(itertools.compress(law.groups, group_has_exponent))
    is_free = []
    for constant in law.constants:
        # X0 belongs to no group
        has_effect = constant.group is None or constant.group in groups_with_exponent
        is_free.append(constant.prescribed is None and has_effect)
    observations = Observations(
        law.design(data.conditions, group_has_exponent), data.curve_of_point, data.slip
    )
    return Problem(law, data, is_followed_condition, observations, data.mu, np.array(is_free))
