"""Each curve as a few coordinates: the projection on smooth functions of slip.

The coordinates of a curve are V' W y, where y is ln mu less that of the law, and the weights W make
the noise of all points equal. The columns of V are the leading eigenvectors of the covariance over
slip of the weighted points of the curve. What V leaves over, the remainder, is noise of points.

Decides: how many coordinates a curve has; how points near zero traction count.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECT_NAMES, LogMu, effect_design
from oilfilm.surface.form_bends import form_bends
from oilfilm.surface.kernels import SLIP_LENGTH_PRIOR, ConditionBox, matern
from oilfilm.surface.law_mean import CONSTANT_SD, FreeLaw
from oilfilm.surface.measurements import (
    Measurements,
    rigs_by_first_curve,
    scaled_conditions,
    scaled_slip,
)

# Largest number of coordinates of a curve. With fewer, kinks of a curve count as noise.
_MAX_COORDINATES = 9
# Spacing of the nodes that replace many different slips. Cubic interpolation over it changes a
# correlation of the usual length by about 1e-6, and of the shortest one allowed by less than 1e-3.
_NODE_SPACING = 0.05
# Number of curves whose slopes are computed at once. A slope of all points takes three times the
# memory of the same slope of all coordinates, and there are about ten slopes.
_CURVES_AT_ONCE = 1000
# mu is near zero if it is below this factor times the error of the zero.
_NEAR_ZERO_FACTOR = 10.0

# Column of the gain in `ReducedCurves.effect_design`.
_GAIN_COLUMN = EFFECT_NAMES.index("gain")
# Rig number of a value on another rig than those of the data: it has the gain of none of them.
ANOTHER_RIG = -1

# Weight of each slip (column) in each coordinate (row). It is sparse for single points, which may
# have a slip each, and dense for curves, whose coordinates share their slips.
SlipWeights = FloatArray | scipy.sparse.csr_array


def is_near_zero(mu: FloatArray, zero_error: float) -> BoolArray:
    """Whether each mu is so small that ln mu is not nearly linear in the error of the zero.

    Args:
        mu: Measured traction coefficients.
        zero_error: Size of the error of the zero, as a traction coefficient: its standard
            deviation, or the largest error in which ln mu shall be linear.
    """
    return mu < _NEAR_ZERO_FACTOR * zero_error


@dataclass(frozen=True)
class Coordinates:
    """Weighted sums of values of a surface over slip, each at one condition.

    A coordinate of a curve is such a sum. The value at a single point is the sum with one weight 1.

    Attributes:
        conditions: Centred conditions, shape (conditions, 3).
        condition_of_coordinate: Row of `conditions` of each coordinate, shape (coordinates,).
        slips: Scaled slips, shape (slips,).
        weights: Weight of each of `slips` in each coordinate, shape (coordinates, slips).
        law_slopes: Slopes of the law, see `slopes_of_law`, shape (coordinates, slopes).
        gain: Change of each coordinate by a gain of 1, shape (coordinates,).
        rig_of_coordinate: Number of the rig, or `ANOTHER_RIG`, shape (coordinates,).
    """

    conditions: FloatArray
    condition_of_coordinate: IndexArray
    slips: FloatArray
    weights: SlipWeights
    law_slopes: FloatArray
    gain: FloatArray
    rig_of_coordinate: IndexArray

    def rig_gain_products(self, other: "Coordinates") -> FloatArray:
        """Products of the gains of two coordinates; 0 where they are not of one rig of the data.

        Args:
            other: The coordinates of the columns.

        Returns:
            Shape (coordinates, other coordinates).
        """
        is_same_rig = (
            np.equal.outer(self.rig_of_coordinate, other.rig_of_coordinate)
            & (self.rig_of_coordinate != ANOTHER_RIG)[:, np.newaxis]
        )
        return np.outer(self.gain, other.gain) * is_same_rig


def coordinates_at_points(
    law: FreeLaw, box: ConditionBox, conditions: FloatArray, slip: FloatArray
) -> Coordinates:
    """Values at single points, as coordinates with one weight 1 each.

    Args:
        law: The law.
        box: The box of the tested conditions.
        conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
        slip: Slide-roll ratio, above 0, shape (points,).
    """
    distinct_conditions, condition_of_point = np.unique(
        scaled_conditions(conditions), axis=0, return_inverse=True
    )
    return Coordinates(
        conditions=box.centred(distinct_conditions),
        condition_of_coordinate=condition_of_point.ravel(),
        slips=scaled_slip(slip),
        weights=scipy.sparse.csr_array(scipy.sparse.eye_array(len(slip))),
        law_slopes=slopes_of_law(law, box, conditions, slip),
        gain=np.ones(len(slip)),
        rig_of_coordinate=np.full(len(slip), ANOTHER_RIG),
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
        transposed_vectors: V' of all curves on its diagonal, shape (coordinates, points).
        weight_of_point: W, the weight of each point, shape (points,).
        curve_of_coordinate: Curve of each coordinate, shape (coordinates,).
        conditions: Centred conditions of each curve, shape (curves, 3).
        slips: Scaled slips that stand for those of all points (`slip_nodes`), shape (slips,).
        slip_weights_of_points: Weights of `slips` at each point, shape (points, slips).
        departure: V' W y, with y the measured ln mu less that of the law, shape (coordinates,).
        law_slopes: V' W of the slopes of the law, see `slopes_of_law`, shape (coordinates, slopes).
        effect_design: V' W of `effects.effect_design`, shape (coordinates, effects).
        remainder: What V leaves of the weighted departure at each point, shape (points,).
        rig_of_curve: Number of the rig of each curve, shape (curves,); `ANOTHER_RIG` where the data
            do not name rigs.
    """

    transposed_vectors: scipy.sparse.csr_array
    weight_of_point: FloatArray
    curve_of_coordinate: IndexArray
    conditions: FloatArray
    slips: FloatArray
    slip_weights_of_points: scipy.sparse.csr_array
    departure: FloatArray
    law_slopes: FloatArray
    effect_design: FloatArray
    remainder: FloatArray
    rig_of_curve: IndexArray

    @property
    def membership(self) -> scipy.sparse.csr_array:
        """1 where a coordinate belongs to a curve, shape (coordinates, curves)."""
        coordinate_count = len(self.curve_of_coordinate)
        shape = (coordinate_count, len(self.conditions))
        return scipy.sparse.csr_array(
            (np.ones(coordinate_count), (np.arange(coordinate_count), self.curve_of_coordinate)),
            shape,
        )

    @cached_property
    def first_coordinate_of_curve(self) -> IndexArray:
        """First coordinate of each curve, shape (curves,)."""
        return np.searchsorted(self.curve_of_coordinate, np.arange(len(self.conditions)))

    @cached_property
    def slip_weights_of_coordinates(self) -> FloatArray:
        """V' W as weights of `slips`, shape (coordinates, slips).

        With many curves it would be the largest array; `select_coordinates` makes only the rows
        that it needs.
        """
        projection = weighted_projection(self.transposed_vectors, self.weight_of_point)
        return np.asarray((projection @ self.slip_weights_of_points).toarray())

    @cached_property
    def coordinate_pairs(self) -> tuple[IndexArray, IndexArray]:
        """Indices of both coordinates of each pair within a curve, shape (pairs,) each."""
        first_coordinate, second_coordinate = np.nonzero(
            np.equal.outer(self.curve_of_coordinate, self.curve_of_coordinate)
        )
        return first_coordinate, second_coordinate

    @cached_property
    def effect_products(self) -> FloatArray:
        """Products of the designs of both coordinates of each pair, shape (pairs, effects)."""
        first_coordinate, second_coordinate = self.coordinate_pairs
        return self.effect_design[first_coordinate] * self.effect_design[second_coordinate]

    @cached_property
    def gain_products_of_rigs(self) -> FloatArray:
        """See `Coordinates.rig_gain_products`, shape (coordinates, coordinates)."""
        all_coordinates = self.select_coordinates(np.arange(len(self.curve_of_coordinate)))
        return all_coordinates.rig_gain_products(all_coordinates)

    @property
    def gains_by_rig(self) -> FloatArray:
        """Change of each coordinate by a gain of 1 of each rig, shape (coordinates, rigs)."""
        rig_of_coordinate = self.rig_of_curve[self.curve_of_coordinate]
        is_of_rig = np.equal.outer(rig_of_coordinate, rigs_by_first_curve(self.rig_of_curve))
        return self.effect_design[:, [_GAIN_COLUMN]] * is_of_rig

    @property
    def residual_freedom(self) -> int:
        """Number of points less the number of coordinates."""
        coordinate_count, point_count = self.transposed_vectors.shape
        return point_count - coordinate_count

    def select_coordinates(self, coordinate_indices: IndexArray) -> Coordinates:
        """Some coordinates, without the conditions and slips that they do not use."""
        curve_indices, condition_of_coordinate = np.unique(
            self.curve_of_coordinate[coordinate_indices], return_inverse=True
        )
        projection = weighted_projection(
            self.transposed_vectors[coordinate_indices], self.weight_of_point
        )
        weights = (projection @ self.slip_weights_of_points).toarray()
        used_slips = np.flatnonzero(np.any(weights != 0, axis=0))
        return Coordinates(
            conditions=self.conditions[curve_indices],
            condition_of_coordinate=condition_of_coordinate,
            slips=self.slips[used_slips],
            weights=weights[:, used_slips],
            law_slopes=self.law_slopes[coordinate_indices],
            gain=self.effect_design[coordinate_indices, _GAIN_COLUMN],
            rig_of_coordinate=self.rig_of_curve[self.curve_of_coordinate[coordinate_indices]],
        )

    def coordinate_indices_of(self, curve_indices: IndexArray) -> IndexArray:
        """Indices of the coordinates of some curves, in ascending order."""
        ends = np.append(self.first_coordinate_of_curve[1:], len(self.curve_of_coordinate))
        return np.concatenate(
            [
                np.arange(self.first_coordinate_of_curve[curve_index], ends[curve_index])
                for curve_index in np.sort(curve_indices)
            ]
        )

    def vectors_of(self, coordinate_indices: IndexArray) -> tuple[IndexArray, FloatArray]:
        """Indices of the points of some coordinates, and their V, shape (points, coordinates)."""
        block = self.transposed_vectors[coordinate_indices].tocoo()
        point_indices, row_of_entry = np.unique(block.col, return_inverse=True)
        vectors = np.zeros((len(point_indices), len(coordinate_indices)))
        vectors[row_of_entry, block.row] = block.data
        return point_indices.astype(np.int64), vectors

    @property
    def vectors(self) -> scipy.sparse.csc_array:
        """V of all curves on its diagonal, shape (points, coordinates)."""
        return self.transposed_vectors.T

    def remainder_of(self, values: FloatArray) -> FloatArray:
        """What V leaves of values at the points, as `remainder` for the departure, (points,)."""
        return np.asarray(values - self.vectors @ (self.transposed_vectors @ values))

    def covariance_from_slips(self, slip_covariance: FloatArray) -> FloatArray:
        """Covariance of the coordinates from that of `slips`, shape (coordinates, coordinates)."""
        weights = self.slip_weights_of_coordinates
        return weights @ slip_covariance @ weights.T

    def summed_onto_slips(self, coordinate_matrix: FloatArray) -> FloatArray:
        """Sums of a matrix of coordinates, weighted by their slip weights, shape (slips, slips)."""
        weights = self.slip_weights_of_coordinates
        return weights.T @ coordinate_matrix @ weights

    def expanded_to_coordinates(self, curve_matrix: FloatArray) -> FloatArray:
        """The entry of its two curves for each pair of coordinates.

        Args:
            curve_matrix: One entry per pair of curves, shape (curves, curves).

        Returns:
            Shape (coordinates, coordinates).
        """
        return curve_matrix[:, self.curve_of_coordinate][self.curve_of_coordinate]

    def summed_by_curve(self, coordinate_rows: FloatArray) -> FloatArray:
        """Rows of coordinates summed over those of each curve, shape (curves, columns)."""
        return np.add.reduceat(coordinate_rows, self.first_coordinate_of_curve, axis=0)


def box_of(measurements: Measurements) -> ConditionBox:
    """The box of the tested conditions."""
    scaled_rows = scaled_conditions(measurements.conditions)
    level_counts = measurements.level_numbers().max(axis=0) + 1
    level_widths = measurements.level_widths.scaled()
    return ConditionBox(
        scaled_rows.min(axis=0), scaled_rows.max(axis=0), level_counts, level_widths
    )


def response(measurements: Measurements, log_mu: LogMu, zero_error: float) -> FloatArray:
    """What a surface is fitted to: ln mu of each point, linearised near zero, shape (points,).

    Near zero traction it is ln m + (mu - m)/m, where m is mu of the present surface. The law alone
    would not do as m: it may be wrong by a factor at low slip.

    Args:
        measurements: The points.
        log_mu: ln mu of the present surface, from conditions and slips.
        zero_error: Size of the error of the zero, as a traction coefficient: its standard
            deviation, or the largest error in which ln mu shall be linear.
    """
    is_linear = is_near_zero(measurements.mu, zero_error)
    log_mu_of_point = np.log(np.where(is_linear, 1.0, measurements.mu))
    if is_linear.any():
        conditions = measurements.point_conditions[is_linear]
        present_log_mu = log_mu(conditions, measurements.slip[is_linear])
        log_mu_of_point[is_linear] = (
            present_log_mu + measurements.mu[is_linear] / np.exp(present_log_mu) - 1
        )
    return log_mu_of_point


def floored_log_mu(log_mu: LogMu, zero_error: float) -> LogMu:
    """ln mu of a surface, not below ln of the error of the zero: below it a surface tells nothing.

    Args:
        log_mu: ln mu of the surface, from conditions and slips.
        zero_error: Size of the error of the zero, as a traction coefficient: its standard
            deviation, or the largest error in which ln mu shall be linear.
    """

    def bounded_log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """ln mu at points, shape (points,)."""
        return np.maximum(log_mu(conditions, slip), np.log(zero_error))

    return bounded_log_mu


def reduced_curves(
    measurements: Measurements, law: FreeLaw, log_mu: LogMu, zero_error: float, box: ConditionBox
) -> ReducedCurves:
    """The curves as coordinates.

    Args:
        measurements: The points, in canonical order.
        law: The law.
        log_mu: ln mu of the present surface, from conditions and slips.
        zero_error: Size of the error of the zero, as a traction coefficient: its standard
            deviation, or the largest error in which ln mu shall be linear.
        box: The box of the tested conditions.
    """
    present_log_mu = floored_log_mu(log_mu, zero_error)
    conditions, slip = measurements.point_conditions, measurements.slip
    weight_of_point = 1 / measurements.noise_ratio_of_points
    weighted_departure = weight_of_point * (
        response(measurements, present_log_mu, zero_error) - law.log_mu(conditions, slip)
    )
    scaled_slips = scaled_slip(slip)
    slips, slip_weights_of_points = slip_nodes(scaled_slips)
    transposed_vectors, curve_of_coordinate = _vectors_of_curves(
        measurements, scaled_slips, weight_of_point
    )
    departure = transposed_vectors @ weighted_departure
    law_slopes = []
    effect_designs = []
    curve_count = len(measurements.conditions)
    for first_curve in range(0, curve_count, _CURVES_AT_ONCE):
        curve_limits = [first_curve, first_curve + _CURVES_AT_ONCE]
        point_block = slice(*np.searchsorted(measurements.curve_of_point, curve_limits))
        coordinate_block = slice(*np.searchsorted(curve_of_coordinate, curve_limits))
        # V' W
        projection = weighted_projection(
            transposed_vectors[coordinate_block, point_block], weight_of_point[point_block]
        )
        block_conditions = conditions[point_block]
        block_slip = slip[point_block]
        law_slopes.append(projection @ slopes_of_law(law, box, block_conditions, block_slip))
        effect_designs.append(
            projection @ effect_design(present_log_mu, block_conditions, block_slip)
        )
    rig_of_curve = measurements.rig_of_curve
    if rig_of_curve is None:
        rig_of_curve = np.full(curve_count, ANOTHER_RIG)
    return ReducedCurves(
        transposed_vectors=transposed_vectors,
        weight_of_point=weight_of_point,
        curve_of_coordinate=curve_of_coordinate,
        conditions=box.centred(scaled_conditions(measurements.conditions)),
        slips=slips,
        slip_weights_of_points=slip_weights_of_points,
        departure=departure,
        law_slopes=np.vstack(law_slopes),
        effect_design=np.vstack(effect_designs),
        remainder=weighted_departure - transposed_vectors.T @ departure,
        rig_of_curve=rig_of_curve,
    )


def weighted_projection(
    transposed_vectors: scipy.sparse.csr_array, weight_of_point: FloatArray
) -> scipy.sparse.csr_array:
    """V' W of some coordinates, shape (coordinates, points).

    Args:
        transposed_vectors: V' of these coordinates, shape (coordinates, points).
        weight_of_point: Weight of each point, shape (points,).
    """
    projection = transposed_vectors.copy()
    projection.data *= weight_of_point[projection.indices]
    return projection


def _vectors_of_curves(
    measurements: Measurements, scaled_slips: FloatArray, weight_of_point: FloatArray
) -> tuple[scipy.sparse.csr_array, IndexArray]:
    """V' of all curves on its diagonal, and the index of the curve of each coordinate.

    Args:
        measurements: The points.
        scaled_slips: Scaled slips of the points.
        weight_of_point: Their weights.
    """
    point_counts = np.bincount(measurements.curve_of_point)
    end_of_curve = np.cumsum(point_counts)
    coordinate_counts = np.minimum(point_counts, _MAX_COORDINATES)
    curve_of_coordinate = np.repeat(np.arange(len(point_counts)), coordinate_counts)
    # The sparse matrix is built from its entries, with indices of 4 bytes: one array per curve
    # would take several times the memory.
    row_starts = np.append(0, np.cumsum(point_counts[curve_of_coordinate])).astype(np.int32)
    first_point = (end_of_curve - point_counts).astype(np.int32)
    columns = np.arange(row_starts[-1], dtype=np.int32)
    columns -= np.repeat(
        row_starts[:-1] - first_point[curve_of_coordinate], point_counts[curve_of_coordinate]
    )
    entries = np.empty(len(columns))
    entry_start = 0
    for slips_of_curve, weight_of_curve in zip(
        np.split(scaled_slips, end_of_curve[:-1]),
        np.split(weight_of_point, end_of_curve[:-1]),
        strict=True,
    ):
        vectors_of_curve = _leading_vectors(slips_of_curve, weight_of_curve)
        entries[entry_start : entry_start + vectors_of_curve.size] = vectors_of_curve.T.ravel()
        entry_start += vectors_of_curve.size
    shape = (len(curve_of_coordinate), len(scaled_slips))
    transposed_vectors = scipy.sparse.csr_array((entries, columns, row_starts), shape)
    transposed_vectors.eliminate_zeros()
    return transposed_vectors, curve_of_coordinate


def slip_nodes(scaled_slips: FloatArray) -> tuple[FloatArray, scipy.sparse.csr_array]:
    """Scaled slips that stand for those of all points, and their weights at each point.

    Where runs share their slips, these are the slips themselves. Where each point has a slip of its
    own, they are a regular grid with cubic interpolation, so that the cost does not grow with the
    square of the number of points.

    Args:
        scaled_slips: Scaled slips of the points, shape (points,).

    Returns:
        Shapes (slips,) and (points, slips).

    Reference: A. G. Wilson, H. Nickisch, ICML 2015 (interpolation of a covariance from a grid).
    """
    slips, slip_of_point = np.unique(scaled_slips, return_inverse=True)
    # two nodes beyond each end: a point has two neighbours on either side
    first_node = slips[0] - _NODE_SPACING
    node_count = int(np.ceil((slips[-1] - first_node) / _NODE_SPACING)) + 2
    if len(slips) <= node_count:
        return slips, _rows_of_weights(np.ones((len(scaled_slips), 1)), slip_of_point, len(slips))
    nodes = first_node + _NODE_SPACING * np.arange(node_count)
    position = (scaled_slips - first_node) / _NODE_SPACING
    node_below = np.floor(position).astype(np.int64).clip(1, node_count - 3)
    # distance from the node below, in spacings
    x = position - node_below
    # Lagrange's polynomials of the nodes at -1, 0, 1 and 2
    weights = [
        -x * (x - 1) * (x - 2) / 6,
        (x + 1) * (x - 1) * (x - 2) / 2,
        -(x + 1) * x * (x - 2) / 2,
        (x + 1) * x * (x - 1) / 6,
    ]
    return nodes, _rows_of_weights(np.column_stack(weights), node_below - 1, node_count)


def _rows_of_weights(
    weights: FloatArray, first_column: IndexArray, column_count: int
) -> scipy.sparse.csr_array:
    """A sparse matrix with some weights side by side in each row.

    Args:
        weights: Shape (rows, weights).
        first_column: Column of the first weight of each row, shape (rows,).
        column_count: Number of columns.
    """
    row_count, weight_count = weights.shape
    columns = np.add.outer(first_column.astype(np.int32), np.arange(weight_count, dtype=np.int32))
    row_starts = np.arange(0, row_count * weight_count + 1, weight_count, dtype=np.int32)
    return scipy.sparse.csr_array(
        (weights.ravel(), columns.ravel(), row_starts), (row_count, column_count)
    )


def _leading_vectors(scaled_slips: FloatArray, weight_of_point: FloatArray) -> FloatArray:
    """V of one curve, shape (points, coordinates).

    Args:
        scaled_slips: Scaled slips of the points.
        weight_of_point: Their weights.
    """
    point_count = len(scaled_slips)
    if point_count <= _MAX_COORDINATES:
        return np.eye(point_count)
    distance = np.subtract.outer(scaled_slips, scaled_slips) / SLIP_LENGTH_PRIOR.median
    _, vectors = scipy.linalg.eigh(
        (1 + matern(distance)) * np.outer(weight_of_point, weight_of_point)
    )
    return vectors[:, -_MAX_COORDINATES:]
