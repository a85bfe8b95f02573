"""Points of traction as arrays, in an order that depends on their values only.

Decides: the scales of slip and conditions in a surface; which conditions are one level.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.levels import level_indices
from oilfilm.base.units import BoolArray, FloatArray, IndexArray

# The slide-roll ratio at which the scaled slip turns from linear to logarithmic.
LINEAR_SLIP_LIMIT = 0.003
# Changes of ln P, of ln U and of T that are one unit of the scaled conditions.
_LN_PRESSURE_SCALE, _LN_SPEED_SCALE, _TEMPERATURE_SCALE_K = 0.6, 1.5, 75.0
# Degree of the polynomial that describes ln(noise) over the scaled slip.
_NOISE_DEGREE = 2


def scaled_slip(slip: FloatArray) -> FloatArray:
    """t = asinh(S / 0.003) of each slide-roll ratio S: linear at low slip, logarithmic above."""
    return np.arcsinh(np.asarray(slip, dtype=float) / LINEAR_SLIP_LIMIT)


def scaled_conditions(conditions: FloatArray) -> FloatArray:
    """ln P / 0.6, ln U / 1.5 and T / 75 K of each row of conditions, shape (rows, 3).

    Args:
        conditions: P in GPa, U in m/s and T in degC, shape (rows, 3).
    """
    pressure, speed, temperature = np.asarray(conditions, dtype=float).T
    return np.column_stack(
        [
            np.log(pressure) / _LN_PRESSURE_SCALE,
            np.log(speed) / _LN_SPEED_SCALE,
            temperature / _TEMPERATURE_SCALE_K,
        ]
    )


def unscaled_conditions(scaled: FloatArray) -> FloatArray:
    """P in GPa, U in m/s and T in degC from scaled conditions, shape (rows, 3)."""
    pressure, speed, temperature = scaled.T
    return np.column_stack(
        [
            np.exp(pressure * _LN_PRESSURE_SCALE),
            np.exp(speed * _LN_SPEED_SCALE),
            temperature * _TEMPERATURE_SCALE_K,
        ]
    )


@dataclass(frozen=True)
class LevelWidths:
    """Largest range of the measured values of one level of P, U and T.

    A campaign may state others (`same_condition` of its configuration).

    Attributes:
        pressure: Range of P over its value.
        speed: Range of U over its value.
        temperature_k: Range of T in K, not over its value.
    """

    pressure: float = 0.02
    speed: float = 0.04
    temperature_k: float = 4.0

    def scaled(self) -> FloatArray:
        """The ranges in the units of `scaled_conditions`, shape (3,)."""
        return np.array(
            [
                self.pressure / _LN_PRESSURE_SCALE,
                self.speed / _LN_SPEED_SCALE,
                self.temperature_k / _TEMPERATURE_SCALE_K,
            ]
        )


def level_numbers(scaled: FloatArray, widths: LevelWidths) -> IndexArray:
    """Number of the level of P, U and T in each row, from 0 for the lowest one, shape (rows, 3).

    Args:
        scaled: Scaled conditions, shape (rows, 3).
        widths: Largest range of the values of one level.
    """
    columns = zip(scaled.T, widths.scaled().tolist(), strict=True)
    level_of_row = np.column_stack([level_indices(column, width) for column, width in columns])
    # the level 0 is that of unknown values
    return level_of_row - 1


def rigs_by_first_curve(rig_of_curve: IndexArray) -> IndexArray:
    """Numbers of the rigs in the order of their first curves: no sum depends on how they are named.

    Args:
        rig_of_curve: Number of the rig of each curve, in canonical order, shape (curves,).
    """
    rig_numbers, first_curves = np.unique(rig_of_curve, return_index=True)
    return rig_numbers[np.argsort(first_curves)]


@dataclass(frozen=True)
class Measurements:
    """Measured points of one oil on one rig, in curves with one condition each.

    Attributes:
        conditions: P in GPa, U in m/s and T in degC of each curve, shape (curves, 3).
        curve_of_point: Row of `conditions` of each point, shape (points,).
        slip: Slide-roll ratio of each point, above 0, shape (points,).
        mu: Traction coefficient of each point, shape (points,).
        noise_ratio: Standard deviation of the noise of each point over that of a typical point, as
            the readings of the point show it, shape (points,); 1 if it is not given.
        level_widths: Largest range of the values of one level.
        rig_of_curve: Number of the rig of each curve, not below 0, shape (curves,); None where the
            data do not name rigs.
    """

    conditions: FloatArray
    curve_of_point: IndexArray
    slip: FloatArray
    mu: FloatArray
    noise_ratio: FloatArray | None = None
    level_widths: LevelWidths = LevelWidths()
    rig_of_curve: IndexArray | None = None

    def __post_init__(self) -> None:
        if self.noise_ratio is not None and not np.all(self.noise_ratio > 0):
            raise ValueError("a ratio of noise is not above 0")
        if self.rig_of_curve is not None and not (
            len(self.rig_of_curve) == len(self.conditions) and np.all(self.rig_of_curve >= 0)
        ):
            raise ValueError("expected the number of a rig, not below 0, for each curve")
        if self.conditions.ndim != 2 or self.conditions.shape[1] != 3:
            raise ValueError(
                f"conditions have the shape {self.conditions.shape}; expected (curves, 3)"
            )
        if not len(self.curve_of_point) == len(self.slip) == len(self.mu):
            raise ValueError(
                f"{len(self.curve_of_point)} numbers of curves, {len(self.slip)} slips and "
                f"{len(self.mu)} values of mu; expected one of each per point"
            )
        if not (np.isfinite(self.slip).all() and np.isfinite(self.mu).all()):
            raise ValueError("a slip or a mu is not finite; leave out points without a value")
        if np.any(self.slip <= 0):
            raise ValueError(
                f"the slip {self.slip.min():g} is not above 0; leave out points at rolling"
            )
        if not np.isfinite(self.conditions).all():
            raise ValueError("a condition is not finite; leave out curves of unknown conditions")
        if not np.all(self.conditions[:, :2] > 0):
            raise ValueError("a pressure or a speed is not above 0: leave out such curves")
        if not np.array_equal(np.unique(self.curve_of_point), np.arange(len(self.conditions))):
            raise ValueError("a curve has no point; leave out curves without points")

    @property
    def point_conditions(self) -> FloatArray:
        """P, U and T of each point, shape (points, 3)."""
        return self.conditions[self.curve_of_point]

    @property
    def noise_ratio_of_points(self) -> FloatArray:
        """`noise_ratio`, or 1 for each point if it is not given, shape (points,)."""
        return np.ones(len(self.slip)) if self.noise_ratio is None else self.noise_ratio

    @property
    def rig_count(self) -> int:
        """Number of rigs; 1 where the data do not name them."""
        return 1 if self.rig_of_curve is None else len(np.unique(self.rig_of_curve))

    def level_numbers(self) -> IndexArray:
        """Number of the level of P, U and T of each curve, from 0, shape (curves, 3)."""
        return level_numbers(scaled_conditions(self.conditions), self.level_widths)

    def condition_of_curve(self) -> IndexArray:
        """Index of the condition of each curve, shape (curves,).

        Repeated runs have the same condition: their P, U and T have the same levels.
        """
        _, condition_of_curve = np.unique(self.level_numbers(), axis=0, return_inverse=True)
        return np.asarray(condition_of_curve, dtype=np.int64).ravel()

    def in_canonical_order(self) -> "Measurements":
        """The same points, ordered by their values: no result depends on the order of rows."""
        curve_indices, point_indices = self.canonical_order()
        point_counts = np.bincount(self.curve_of_point)[curve_indices]
        return replace(
            self,
            conditions=self.conditions[curve_indices],
            curve_of_point=np.repeat(np.arange(len(curve_indices)), point_counts),
            slip=self.slip[point_indices],
            mu=self.mu[point_indices],
            noise_ratio=None if self.noise_ratio is None else self.noise_ratio[point_indices],
            rig_of_curve=None if self.rig_of_curve is None else self.rig_of_curve[curve_indices],
        )

    def canonical_order(self) -> tuple[IndexArray, IndexArray]:
        """Indices of the curves, and indices of the points, sorted by their values.

        Curves are sorted by their conditions, then by the slips and mu of their points. Points are
        sorted by their curve, then by slip and mu.

        Returns:
            Shapes (curves,) and (points,).
        """
        points_by_value = np.lexsort([self.mu, self.slip, self.curve_of_point])
        ends = np.cumsum(np.bincount(self.curve_of_point))[:-1]
        points_of_curve = np.split(points_by_value, ends)

        _, rank_of_condition, curve_counts = np.unique(
            self.conditions, axis=0, return_inverse=True, return_counts=True
        )
        rank_of_condition = rank_of_condition.ravel()

        def sort_key(curve_index: int) -> tuple[float, ...]:
            """What the curves are sorted by."""
            condition_rank = rank_of_condition[curve_index]
            if curve_counts[condition_rank] == 1:
                # of most curves the condition is enough
                return (condition_rank,)
            points = points_of_curve[curve_index]
            return (condition_rank, *self.slip[points], *self.mu[points])

        curve_indices = sorted(range(len(points_of_curve)), key=sort_key)
        point_indices = np.concatenate(
            [points_of_curve[curve_index] for curve_index in curve_indices]
        )
        return np.array(curve_indices, dtype=np.int64), point_indices

    def select_curves(self, curve_indices: IndexArray) -> "Measurements":
        """The points of some curves. The curves keep their order and are numbered from 0.

        Args:
            curve_indices: Indices of these curves.
        """
        is_chosen = np.zeros(len(self.conditions), dtype=bool)
        is_chosen[curve_indices] = True
        return self.select_points(is_chosen[self.curve_of_point])

    def select_points(self, is_chosen: BoolArray) -> "Measurements":
        """Some points; curves that lose all their points are left out.

        Args:
            is_chosen: Whether each point stays, shape (points,).
        """
        curve_indices, new_curve_of_point = np.unique(
            self.curve_of_point[is_chosen], return_inverse=True
        )
        return replace(
            self,
            conditions=self.conditions[curve_indices],
            curve_of_point=new_curve_of_point,
            slip=self.slip[is_chosen],
            mu=self.mu[is_chosen],
            noise_ratio=None if self.noise_ratio is None else self.noise_ratio[is_chosen],
            rig_of_curve=None if self.rig_of_curve is None else self.rig_of_curve[curve_indices],
        )

    def copied_to_conditions(self, curve_index: int, conditions: FloatArray) -> "Measurements":
        """One copy of a curve at each of some conditions, as if it had been measured there.

        Args:
            curve_index: Index of the curve.
            conditions: P in GPa, U in m/s and T in degC, shape (copies, 3).
        """
        single_run = self.select_curves(np.array([curve_index]))
        copy_count, point_count = len(conditions), len(single_run.slip)
        noise_ratio, rig_of_curve = single_run.noise_ratio, single_run.rig_of_curve
        return replace(
            self,
            conditions=conditions,
            curve_of_point=np.repeat(np.arange(copy_count), point_count),
            slip=np.tile(single_run.slip, copy_count),
            mu=np.tile(single_run.mu, copy_count),
            noise_ratio=None if noise_ratio is None else np.tile(noise_ratio, copy_count),
            rig_of_curve=None if rig_of_curve is None else np.tile(rig_of_curve, copy_count),
        )

    def noise_ratio_at(self, slip: FloatArray) -> FloatArray:
        """Noise of new points over that of a typical one, as `noise_ratio`, shape (points,).

        Its logarithm is a parabola over the scaled slip, fitted to those of `noise_ratio`.

        Args:
            slip: Slide-roll ratio of the new points, above 0, shape (points,).
        """
        if self.noise_ratio is None:
            return np.ones(len(slip))
        tested_slips = scaled_slip(self.slip)
        degree = min(_NOISE_DEGREE, len(np.unique(tested_slips)) - 1)
        parabola = np.polynomial.Polynomial.fit(tested_slips, np.log(self.noise_ratio), degree)
        return np.asarray(
            np.exp(parabola(scaled_slip(slip).clip(tested_slips.min(), tested_slips.max())))
        )
