"""Each curve as a few coordinates: the projection on smooth functions of slip.

The coordinates of a curve are V' W y, where y is ln mu less that of the law, and the weights W make
the noise of all points equal. The columns of V are the leading eigenvectors of the covariance over
slip of the weighted points of the curve. What V leaves over is noise of points.

Decides: how many coordinates a curve has; how points near zero traction count.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECTS, LogMu, effect_design
from oilfilm.surface.form_bends import form_bends
from oilfilm.surface.kernels import SLIP_LENGTH, ConditionBox, matern
from oilfilm.surface.law_mean import CONSTANT_SD, FreeLaw
from oilfilm.surface.measurements import Measurements, scaled_conditions, scaled_slip

# With fewer coordinates, kinks of a curve count as noise.
_COORDINATES = 9
# Spacing of the nodes that replace many different slips. Cubic interpolation over it changes a
# correlation of the usual length by less than 1e-6.
_NODE_SPACING = 0.05
# Curves whose slopes are found at once. A slope of all points takes three times the memory of the
# same slope of all coordinates, and there are some ten slopes.
_CURVES_AT_ONCE = 1000
# mu is near zero if it is within so many errors of the zero.
_NEAR_ZERO = 10.0

# Column of the gain in `ReducedCurves.effects`.
_GAIN = EFFECTS.index("gain")
# What stands for the number of a rig where a value has the gain of none of the rigs of the data.
ANOTHER_RIG = -1

# Each target may have a slip of its own: most weights are 0 then. Coordinates share their slips.
SlipWeights = FloatArray | scipy.sparse.csr_array


def is_near_zero(mu: FloatArray, zero_sd: float) -> BoolArray:
    """Whether the logarithm of each mu is too far from linear in the error of the zero.

    Args:
        mu: Measured traction coefficients.
        zero_sd: Standard deviation of the zero, as a traction coefficient.
    """
    return mu < _NEAR_ZERO * zero_sd


@dataclass(frozen=True)
class Coordinates:
    """Weighted sums of values of a surface; a value at a point is one of weight 1.

    Attributes:
        conditions: Centred conditions, shape (rows, 3).
        row: Row of `conditions` of each coordinate, shape (coordinates,).
        slips: Scaled slips, shape (slips,).
        weights: Weight of each of `slips` in each coordinate, shape (coordinates, slips).
        law_slopes: Slopes of the law, see `slopes_of_law`, shape (coordinates, slopes).
        gain: Change by a gain of 1, shape (coordinates,).
        rig: Number of the rig, or `ANOTHER_RIG`, shape (coordinates,).
    """

    conditions: FloatArray
    row: IndexArray
    slips: FloatArray
    weights: SlipWeights
    law_slopes: FloatArray
    gain: FloatArray
    rig: IndexArray

    def rig_products(self, right: "Coordinates") -> FloatArray:
        """Products of the gains of coordinates of one rig, shape (coordinates, other ones)."""
        is_same = np.equal.outer(self.rig, right.rig) & (self.rig != ANOTHER_RIG)[:, np.newaxis]
        return np.outer(self.gain, right.gain) * is_same


def at_points(
    law: FreeLaw, box: ConditionBox, conditions: FloatArray, slip: FloatArray
) -> Coordinates:
    """Values at single points.

    Args:
        law: The law.
        box: The box of the tested conditions.
        conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
        slip: Slide-roll ratio, above 0, shape (points,).
    """
    distinct_conditions, row = np.unique(scaled_conditions(conditions), axis=0, return_inverse=True)
    return Coordinates(
        conditions=box.centred(distinct_conditions),
        row=row.ravel(),
        slips=scaled_slip(slip),
        weights=scipy.sparse.csr_array(scipy.sparse.eye_array(len(slip))),
        law_slopes=slopes_of_law(law, box, conditions, slip),
        gain=np.ones(len(slip)),
        rig=np.full(len(slip), ANOTHER_RIG),
    )


def slopes_of_law(
    law: FreeLaw, box: ConditionBox, conditions: FloatArray, slip: FloatArray
) -> FloatArray:
    """Change of ln mu by one standard deviation of what is free in the law, shape (points, slopes).

    First the free constants, then the form of the law between two levels (`form_bends`).
    """
    slopes_of_constants = CONSTANT_SD * law.log_slopes(conditions, slip)
    return np.hstack([slopes_of_constants, form_bends(law, box, conditions, slip)])


@dataclass(frozen=True)
class ReducedCurves:
    """The curves of a campaign as coordinates.

    Attributes:
        by_coordinate: V' of all curves on its diagonal, shape (coordinates, points).
        weight: W, the weight of each point, shape (points,).
        curve: Curve of each coordinate, shape (coordinates,).
        conditions: Centred conditions of each curve, shape (curves, 3).
        slips: Scaled slips that stand for those of all points (`slip_nodes`), shape (slips,).
        weights_of_slips: Weights of `slips` at each point, shape (points, slips).
        departure: V' W of ln mu less that of the law, shape (coordinates,).
        law_slopes: V' W of the slopes of the law, see `slopes_of_law`, shape (coordinates, slopes).
        effects: V' W of the design of the effects of runs, shape (coordinates, effects).
        remainder: What V leaves of the weighted departure at each point, shape (points,).
        rig: Number of the rig of each curve, `ANOTHER_RIG` where it is not named, shape (curves,).
    """

    by_coordinate: scipy.sparse.csr_array
    weight: FloatArray
    curve: IndexArray
    conditions: FloatArray
    slips: FloatArray
    weights_of_slips: scipy.sparse.csr_array
    departure: FloatArray
    law_slopes: FloatArray
    effects: FloatArray
    remainder: FloatArray
    rig: IndexArray

    @property
    def membership(self) -> scipy.sparse.csr_array:
        """1 where a coordinate belongs to a curve, shape (coordinates, curves)."""
        count = len(self.curve)
        shape = (count, len(self.conditions))
        return scipy.sparse.csr_array((np.ones(count), (np.arange(count), self.curve)), shape)

    @cached_property
    def starts(self) -> IndexArray:
        """First coordinate of each curve, shape (curves,)."""
        return np.searchsorted(self.curve, np.arange(len(self.conditions)))

    @cached_property
    def to_slips(self) -> FloatArray:
        """V' W as weights of `slips`, shape (coordinates, slips).

        It would be the largest array of many curves; `select` makes the rows that it needs.
        """
        projection = weighted(self.by_coordinate, self.weight)
        return np.asarray((projection @ self.weights_of_slips).toarray())

    @cached_property
    def pairs(self) -> tuple[IndexArray, IndexArray]:
        """Both coordinates of each pair that belongs to one curve, shape (pairs,) each."""
        left, right = np.nonzero(np.equal.outer(self.curve, self.curve))
        return left, right

    @cached_property
    def effect_products(self) -> FloatArray:
        """Products of the effects of both coordinates of each pair, shape (pairs, effects)."""
        left, right = self.pairs
        return self.effects[left] * self.effects[right]

    @cached_property
    def gain_products_of_rigs(self) -> FloatArray:
        """See `Coordinates.rig_products`, shape (coordinates, coordinates)."""
        all_coordinates = self.select(np.arange(len(self.curve)))
        return all_coordinates.rig_products(all_coordinates)

    @property
    def residual_freedom(self) -> int:
        """Number of points less the number of coordinates."""
        coordinates, points = self.by_coordinate.shape
        return points - coordinates

    def select(self, coordinates: IndexArray) -> Coordinates:
        """Some coordinates, with what they need only."""
        curves, row = np.unique(self.curve[coordinates], return_inverse=True)
        projection = weighted(self.by_coordinate[coordinates], self.weight)
        weights = (projection @ self.weights_of_slips).toarray()
        used = np.flatnonzero(np.any(weights != 0, axis=0))
        return Coordinates(
            conditions=self.conditions[curves],
            row=row,
            slips=self.slips[used],
            weights=weights[:, used],
            law_slopes=self.law_slopes[coordinates],
            gain=self.effects[coordinates, _GAIN],
            rig=self.rig[self.curve[coordinates]],
        )

    def coordinates_of(self, rows: IndexArray) -> IndexArray:
        """Indices of the coordinates of some curves, in ascending order."""
        ends = np.append(self.starts[1:], len(self.curve))
        return np.concatenate([np.arange(self.starts[row], ends[row]) for row in np.sort(rows)])

    def vectors_of(self, coordinates: IndexArray) -> tuple[IndexArray, FloatArray]:
        """Points of some coordinates, and V of these, shape (points, coordinates)."""
        block = self.by_coordinate[coordinates].tocoo()
        points, row = np.unique(block.col, return_inverse=True)
        vectors = np.zeros((len(points), len(coordinates)))
        vectors[row, block.row] = block.data
        return points.astype(np.int64), vectors

    @property
    def vectors(self) -> scipy.sparse.csc_array:
        """V of all curves on its diagonal, shape (points, coordinates)."""
        return self.by_coordinate.T

    def over_slip(self, correlations: FloatArray) -> FloatArray:
        """Covariance of the coordinates from that of `slips`, shape (coordinates, coordinates)."""
        return self.to_slips @ correlations @ self.to_slips.T

    def onto_slips(self, coordinate_matrix: FloatArray) -> FloatArray:
        """Sums of a matrix of coordinates by `to_slips`, shape (slips, slips)."""
        return self.to_slips.T @ coordinate_matrix @ self.to_slips

    def expanded(self, curve_matrix: FloatArray) -> FloatArray:
        """A matrix of curves as one of their coordinates."""
        return curve_matrix[:, self.curve][self.curve]

    def summed(self, coordinate_rows: FloatArray) -> FloatArray:
        """Rows of coordinates summed over those of each curve, shape (curves, columns)."""
        return np.add.reduceat(coordinate_rows, self.starts, axis=0)


def box_of(measurements: Measurements) -> ConditionBox:
    """The box of the tested conditions."""
    scaled = scaled_conditions(measurements.conditions)
    counts = measurements.level_numbers().max(axis=0) + 1
    widths = measurements.level_widths.scaled()
    return ConditionBox(scaled.min(axis=0), scaled.max(axis=0), counts, widths)


def response(measurements: Measurements, log_mu: LogMu, zero_sd: float) -> FloatArray:
    """ln mu of each point, or its linear response near zero traction, shape (points,).

    The response of a point near zero is ln m + (mu - m)/m, where m is the present surface. It must
    not be the law alone, because a law may miss low slip by a factor.

    Args:
        measurements: The points.
        log_mu: ln mu of the present surface, from conditions and slips.
        zero_sd: Standard deviation of the zero, as a traction coefficient.
    """
    near_zero = is_near_zero(measurements.mu, zero_sd)
    logarithm = np.log(np.where(near_zero, 1.0, measurements.mu))
    if near_zero.any():
        conditions = measurements.point_conditions[near_zero]
        present = log_mu(conditions, measurements.slip[near_zero])
        logarithm[near_zero] = present + measurements.mu[near_zero] / np.exp(present) - 1
    return logarithm


def reduced(
    measurements: Measurements, law: FreeLaw, log_mu: LogMu, zero_sd: float, box: ConditionBox
) -> ReducedCurves:
    """The curves as coordinates.

    Args:
        measurements: The points, in canonical order.
        law: The law.
        log_mu: ln mu of the present surface, from conditions and slips.
        zero_sd: Standard deviation of the zero, as a traction coefficient.
        box: The box of the tested conditions.
    """

    def present_log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """ln mu of the present surface, which tells nothing below the error of the zero."""
        return np.maximum(log_mu(conditions, slip), np.log(zero_sd))

    conditions, slip = measurements.point_conditions, measurements.slip
    weight = np.ones(len(slip))
    if measurements.noise_ratio is not None:
        weight = 1 / measurements.noise_ratio
    weighted_departure = weight * (
        response(measurements, present_log_mu, zero_sd) - law.log_mu(conditions, slip)
    )
    scaled = scaled_slip(slip)
    slips, weights_of_slips = slip_nodes(scaled)
    by_coordinate, curve = _vectors_of_curves(measurements, scaled, weight)
    departure = by_coordinate @ weighted_departure
    law_slopes, effects = [], []
    curves = len(measurements.conditions)
    for first in range(0, curves, _CURVES_AT_ONCE):
        block = [first, first + _CURVES_AT_ONCE]
        points = slice(*np.searchsorted(measurements.curve, block))
        coordinates = slice(*np.searchsorted(curve, block))
        # V' W
        projection = weighted(by_coordinate[coordinates, points], weight[points])
        at_points_of_block = conditions[points], slip[points]
        law_slopes.append(projection @ slopes_of_law(law, box, *at_points_of_block))
        effects.append(projection @ effect_design(present_log_mu, *at_points_of_block))
    return ReducedCurves(
        by_coordinate=by_coordinate,
        weight=weight,
        curve=curve,
        conditions=box.centred(scaled_conditions(measurements.conditions)),
        slips=slips,
        weights_of_slips=weights_of_slips,
        departure=departure,
        law_slopes=np.vstack(law_slopes),
        effects=np.vstack(effects),
        remainder=weighted_departure - by_coordinate.T @ departure,
        rig=np.full(curves, ANOTHER_RIG) if measurements.rig is None else measurements.rig,
    )


def weighted(by_coordinate: scipy.sparse.csr_array, weight: FloatArray) -> scipy.sparse.csr_array:
    """V' W of some coordinates, shape (coordinates, points).

    Args:
        by_coordinate: V' of these, shape (coordinates, points).
        weight: Weight of each point, shape (points,).
    """
    projection = by_coordinate.copy()
    projection.data *= weight[projection.indices]
    return projection


def _vectors_of_curves(
    measurements: Measurements, scaled: FloatArray, weight: FloatArray
) -> tuple[scipy.sparse.csr_array, IndexArray]:
    """V' of all curves on its diagonal, and the curve of each coordinate.

    Args:
        measurements: The points.
        scaled: Scaled slips of the points.
        weight: Their weights.
    """
    points_of_curve = np.bincount(measurements.curve)
    ends = np.cumsum(points_of_curve)
    coordinates_of_curve = np.minimum(points_of_curve, _COORDINATES)
    curve = np.repeat(np.arange(len(points_of_curve)), coordinates_of_curve)
    # in numbers of 4 bytes; blocks as arrays of their own would take several times the memory
    begins = np.append(0, np.cumsum(points_of_curve[curve])).astype(np.int32)
    first_point = (ends - points_of_curve).astype(np.int32)
    columns = np.arange(begins[-1], dtype=np.int32)
    columns -= np.repeat(begins[:-1] - first_point[curve], points_of_curve[curve])
    values = np.empty(len(columns))
    begin = 0
    for scaled_of_curve, weight_of_curve in zip(
        np.split(scaled, ends[:-1]), np.split(weight, ends[:-1]), strict=True
    ):
        block = _leading_vectors(scaled_of_curve, weight_of_curve)
        values[begin : begin + block.size] = block.T.ravel()
        begin += block.size
    shape = (len(curve), len(scaled))
    by_coordinate = scipy.sparse.csr_array((values, columns, begins), shape)
    by_coordinate.eliminate_zeros()
    return by_coordinate, curve


def slip_nodes(scaled: FloatArray) -> tuple[FloatArray, scipy.sparse.csr_array]:
    """Scaled slips that stand for those of all points, and their weights at each point.

    Where runs share their slips, these are the slips themselves. Where each point has a slip of its
    own, they are a regular grid with cubic interpolation, so that the cost does not grow with the
    square of the number of points.

    Args:
        scaled: Scaled slips of the points, shape (points,).

    Returns:
        Shapes (slips,) and (points, slips).

    Reference: A. G. Wilson, H. Nickisch, ICML 2015 (interpolation of a covariance from a grid).
    """
    slips, slip_number = np.unique(scaled, return_inverse=True)
    # two nodes beyond each end: a point has two neighbours on either side
    first = slips[0] - _NODE_SPACING
    count = int(np.ceil((slips[-1] - first) / _NODE_SPACING)) + 2
    if len(slips) <= count:
        return slips, _rows_of_weights(np.ones((len(scaled), 1)), slip_number, len(slips))
    nodes = first + _NODE_SPACING * np.arange(count)
    position = (scaled - first) / _NODE_SPACING
    below = np.floor(position).astype(np.int64).clip(1, count - 3)
    share = position - below
    # Lagrange's polynomials of the nodes at -1, 0, 1 and 2
    weights = [
        -share * (share - 1) * (share - 2) / 6,
        (share + 1) * (share - 1) * (share - 2) / 2,
        -(share + 1) * share * (share - 2) / 2,
        (share + 1) * share * (share - 1) / 6,
    ]
    return nodes, _rows_of_weights(np.column_stack(weights), below - 1, count)


def _rows_of_weights(
    weights: FloatArray, first_column: IndexArray, count: int
) -> scipy.sparse.csr_array:
    """A sparse matrix with some weights side by side in each row.

    Args:
        weights: Shape (rows, weights).
        first_column: Column of the first weight of each row, shape (rows,).
        count: Number of columns.
    """
    rows, width = weights.shape
    columns = np.add.outer(first_column.astype(np.int32), np.arange(width, dtype=np.int32))
    begins = np.arange(0, rows * width + 1, width, dtype=np.int32)
    return scipy.sparse.csr_array((weights.ravel(), columns.ravel(), begins), (rows, count))


def _leading_vectors(scaled: FloatArray, weight: FloatArray) -> FloatArray:
    """V of one curve, shape (points, coordinates).

    Args:
        scaled: Scaled slips of the points.
        weight: Their weights.
    """
    count = len(scaled)
    if count <= _COORDINATES:
        return np.eye(count)
    distance = np.subtract.outer(scaled, scaled) / SLIP_LENGTH.median
    _, vectors = scipy.linalg.eigh((1 + matern(distance)) * np.outer(weight, weight))
    return vectors[:, -_COORDINATES:]
