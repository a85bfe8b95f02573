"""Points of traction as arrays, in an order that depends on their values only.

Decides: the scales of slip and conditions in a surface; which conditions are one level.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.levels import cluster_indices
from oilfilm.base.units import BoolArray, FloatArray, IndexArray

# The slip at which the scaled slip turns from linear to logarithmic.
SLIP_SCALE = 0.003
# Changes of ln P and of ln U, and of T in K, that count as one unit of distance.
_PRESSURE_SCALE, _SPEED_SCALE, _TEMPERATURE_SCALE_K = 0.6, 1.5, 75.0
# Degree of the noise over the scaled slip.
_NOISE_DEGREE = 2


def scaled_slip(slip: FloatArray) -> FloatArray:
    """t = asinh(S / 0.003), which is linear at low slip and logarithmic above."""
    return np.arcsinh(np.asarray(slip, dtype=float) / SLIP_SCALE)


def scaled_conditions(conditions: FloatArray) -> FloatArray:
    """ln P / 0.6, ln U / 1.5 and T / 75 K, shape (rows, 3).

    Args:
        conditions: P in GPa, U in m/s and T in degC, shape (rows, 3).
    """
    pressure, speed, temperature = np.asarray(conditions, dtype=float).T
    return np.column_stack(
        [
            np.log(pressure) / _PRESSURE_SCALE,
            np.log(speed) / _SPEED_SCALE,
            temperature / _TEMPERATURE_SCALE_K,
        ]
    )


def unscaled_conditions(scaled: FloatArray) -> FloatArray:
    """P in GPa, U in m/s and T in degC from scaled conditions, shape (rows, 3)."""
    pressure, speed, temperature = scaled.T
    return np.column_stack(
        [
            np.exp(pressure * _PRESSURE_SCALE),
            np.exp(speed * _SPEED_SCALE),
            temperature * _TEMPERATURE_SCALE_K,
        ]
    )


@dataclass(frozen=True)
class LevelWidths:
    """Largest range of the measured values of one level of P, U and T.

    A campaign may state others (`same_condition` of its configuration).

    Attributes:
        pressure: Of P, relative.
        speed: Of U, relative.
        temperature_k: Of T.
    """

    pressure: float = 0.02
    speed: float = 0.04
    temperature_k: float = 4.0

    def scaled(self) -> FloatArray:
        """The ranges in the units of `scaled_conditions`, shape (3,)."""
        return np.array(
            [
                self.pressure / _PRESSURE_SCALE,
                self.speed / _SPEED_SCALE,
                self.temperature_k / _TEMPERATURE_SCALE_K,
            ]
        )


def level_numbers(scaled: FloatArray, widths: LevelWidths) -> IndexArray:
    """Number of the level of P, U and T in each row, from the lowest on, shape (rows, 3).

    Args:
        scaled: Scaled conditions, shape (rows, 3).
        widths: Largest range of the values of one level.
    """
    columns = zip(scaled.T, widths.scaled().tolist(), strict=True)
    numbers = np.column_stack([cluster_indices(column, width) for column, width in columns])
    # the cluster 0 is that of unknown values
    return numbers - 1


@dataclass(frozen=True)
class Measurements:
    """Measured points of one oil on one rig, in curves with one condition each.

    Attributes:
        conditions: P in GPa, U in m/s and T in degC of each curve, shape (curves, 3).
        curve: Row of `conditions` of each point, shape (points,).
        slip: Slide-roll ratio of each point, above 0, shape (points,).
        mu: Traction coefficient of each point, shape (points,).
        noise_ratio: Noise of each point over that of a typical one, as its readings show it, shape
            (points,); 1 if it is not given.
        level_widths: Largest range of the values of one level.
        rig: Number of the rig of each curve, not below 0, shape (curves,); None where the data do
            not name rigs.
    """

    conditions: FloatArray
    curve: IndexArray
    slip: FloatArray
    mu: FloatArray
    noise_ratio: FloatArray | None = None
    level_widths: LevelWidths = LevelWidths()
    rig: IndexArray | None = None

    def __post_init__(self) -> None:
        if self.noise_ratio is not None and not np.all(self.noise_ratio > 0):
            raise ValueError("a ratio of noise is not above 0")
        if self.rig is not None and not (
            len(self.rig) == len(self.conditions) and np.all(self.rig >= 0)
        ):
            raise ValueError("expected the number of a rig, not below 0, for each curve")
        if self.conditions.ndim != 2 or self.conditions.shape[1] != 3:
            raise ValueError(
                f"conditions have the shape {self.conditions.shape}; expected (curves, 3)"
            )
        if not len(self.curve) == len(self.slip) == len(self.mu):
            raise ValueError(
                f"{len(self.curve)} numbers of curves, {len(self.slip)} slips and {len(self.mu)} "
                "values of mu; expected one of each per point"
            )
        if not (np.isfinite(self.slip).all() and np.isfinite(self.mu).all()):
            raise ValueError("a slip or a mu is not finite; leave out points without a value")
        if np.any(self.slip <= 0):
            raise ValueError(
                f"the slip {self.slip.min():g} is not above 0; leave out points at rolling"
            )
        if not np.isfinite(self.conditions).all():
            raise ValueError("a condition is not finite; leave out curves of unknown conditions")
        if not np.all(self.conditions > 0):
            raise ValueError(
                "a pressure, a speed or a temperature in degC is not above 0; laws are powers of "
                "all three: leave out such curves"
            )
        if not np.array_equal(np.unique(self.curve), np.arange(len(self.conditions))):
            raise ValueError("a curve has no point; leave out curves without points")

    @property
    def point_conditions(self) -> FloatArray:
        """P, U and T of each point, shape (points, 3)."""
        return self.conditions[self.curve]

    @property
    def rig_count(self) -> int:
        """Number of rigs; 1 where the data do not name them."""
        return 1 if self.rig is None else len(np.unique(self.rig))

    def level_numbers(self) -> IndexArray:
        """Number of the level of P, U and T of each curve, shape (curves, 3)."""
        return level_numbers(scaled_conditions(self.conditions), self.level_widths)

    def condition_numbers(self) -> IndexArray:
        """Number of the condition of each curve; repeated runs share it. Shape (curves,)."""
        _, number = np.unique(self.level_numbers(), axis=0, return_inverse=True)
        return np.asarray(number, dtype=np.int64).ravel()

    def in_canonical_order(self) -> "Measurements":
        """The same points, ordered by their values: no result depends on the order of rows."""
        curves, points = self.canonical_order()
        sizes = np.bincount(self.curve)[curves]
        return replace(
            self,
            conditions=self.conditions[curves],
            curve=np.repeat(np.arange(len(curves)), sizes),
            slip=self.slip[points],
            mu=self.mu[points],
            noise_ratio=None if self.noise_ratio is None else self.noise_ratio[points],
            rig=None if self.rig is None else self.rig[curves],
        )

    def canonical_order(self) -> tuple[IndexArray, IndexArray]:
        """Rows of curves and rows of points in the order of their values."""
        by_value = np.lexsort([self.mu, self.slip, self.curve])
        ends = np.cumsum(np.bincount(self.curve))[:-1]
        points_of_curves = np.split(by_value, ends)

        _, place, counts = np.unique(
            self.conditions, axis=0, return_inverse=True, return_counts=True
        )
        place = place.ravel()

        def content(row: int) -> tuple[float, ...]:
            # of most curves the conditions are enough
            is_shared = counts[place[row]] > 1
            points = points_of_curves[row] if is_shared else points_of_curves[row][:0]
            return (place[row], *self.slip[points], *self.mu[points])

        rows = sorted(range(len(points_of_curves)), key=content)
        points = np.concatenate([points_of_curves[row] for row in rows])
        return np.array(rows, dtype=np.int64), points

    def select_curves(self, rows: IndexArray) -> "Measurements":
        """The points of some curves, which are numbered anew in their old order."""
        is_chosen = np.zeros(len(self.conditions), dtype=bool)
        is_chosen[rows] = True
        return self.select_points(is_chosen[self.curve])

    def select_points(self, is_chosen: BoolArray) -> "Measurements":
        """Some points; curves that lose all their points are left out.

        Args:
            is_chosen: Whether each point stays, shape (points,).
        """
        rows, curve = np.unique(self.curve[is_chosen], return_inverse=True)
        return replace(
            self,
            conditions=self.conditions[rows],
            curve=curve,
            slip=self.slip[is_chosen],
            mu=self.mu[is_chosen],
            noise_ratio=None if self.noise_ratio is None else self.noise_ratio[is_chosen],
            rig=None if self.rig is None else self.rig[rows],
        )

    def at_conditions(self, row: int, conditions: FloatArray) -> "Measurements":
        """The points of one curve, as if they had been measured at each of some conditions.

        Args:
            row: Row of the curve.
            conditions: P in GPa, U in m/s and T in degC, shape (copies, 3).
        """
        single_run = self.select_curves(np.array([row]))
        copies, points = len(conditions), len(single_run.slip)
        ratio, rig = single_run.noise_ratio, single_run.rig
        return replace(
            self,
            conditions=conditions,
            curve=np.repeat(np.arange(copies), points),
            slip=np.tile(single_run.slip, copies),
            mu=np.tile(single_run.mu, copies),
            noise_ratio=None if ratio is None else np.tile(ratio, copies),
            rig=None if rig is None else np.tile(rig, copies),
        )

    def noise_ratio_at(self, slip: FloatArray) -> FloatArray:
        """Noise of a new point over that of a typical one, shape (points,).

        It is a parabola in the scaled slip through the logarithms of the known ratios.

        Args:
            slip: Slide-roll ratio of the new points, above 0, shape (points,).
        """
        if self.noise_ratio is None:
            return np.ones(len(slip))
        tested = scaled_slip(self.slip)
        degree = min(_NOISE_DEGREE, len(np.unique(tested)) - 1)
        parabola = np.polynomial.Polynomial.fit(tested, np.log(self.noise_ratio), degree)
        return np.asarray(np.exp(parabola(scaled_slip(slip).clip(tested.min(), tested.max()))))
