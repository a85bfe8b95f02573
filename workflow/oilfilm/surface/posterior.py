"""The smooth part of a surface given the curves: dense, or on the curves of a few conditions.

Both predict the coordinates of one condition from all others in closed form. What is left out of a
normal distribution follows from blocks of the inverse covariance:
error = (K^-1)_cc^-1 (K^-1 y)_c, with the covariance (K^-1)_cc^-1, where K is the covariance of the
coordinates y, and c stands for the coordinates that are left out.

References: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
Eqs 2.23-2.24 and 5.12; E. Snelson, Z. Ghahramani, AISTATS 2007 (blocks of the remainder).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from oilfilm.base.ties import first_largest, first_smallest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.kernels import matern
from oilfilm.surface.reduction import ANOTHER_RIG, Coordinates
from oilfilm.surface.reml import CurveCovariance

# Added to the variance of each inducing coordinate, in units of the mean variance.
_JITTER = 1e-10
# Number of curves whose blocks are computed at once. With more curves most of the work would be on
# entries between curves, which are 0; with fewer there would be many calls.
_CURVES_AT_ONCE = 20


@dataclass(frozen=True)
class LeftOutCurves:
    """The coordinates of a group of curves, as all other curves predict them.

    Attributes:
        coordinate_indices: Indices of the coordinates of the group.
        precision: Their block of K^-1, shape (coordinates, coordinates).
        weights: Their part of K^-1 y, shape (coordinates,).
    """

    coordinate_indices: IndexArray
    precision: FloatArray
    weights: FloatArray

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the error, shape (coordinates, coordinates)."""
        inverse = scipy.linalg.inv(self.precision)
        return np.asarray((inverse + inverse.T) / 2)

    @property
    def error(self) -> FloatArray:
        """Measured less predicted, shape (coordinates,)."""
        return self.covariance @ self.weights


class ParameterPosterior(NamedTuple):
    """The posterior of parameters of which the smooth part is a linear function.

    Each parameter is in units of its prior standard deviation.

    Attributes:
        expected_change: Expected change of each from its prior mean, shape (parameters,).
        covariance: Covariance of the changes, shape (parameters, parameters).
    """

    expected_change: FloatArray
    covariance: FloatArray


class Posterior(Protocol):
    """The smooth part of ln mu, less the law, given the curves.

    Targets are the points, or weighted sums over points, at which it is wanted.
    """

    def mean(self, targets: Coordinates) -> FloatArray:
        """Expected value at each target, shape (targets,)."""
        ...

    def variance(self, targets: Coordinates) -> FloatArray:
        """Variance at each target, shape (targets,)."""
        ...

    def parameter_posterior(self, slopes: FloatArray) -> ParameterPosterior:
        """The posterior of parameters of the smooth part, given the curves.

        Args:
            slopes: Derivative of each coordinate by each parameter, in units of its prior standard
                deviation, shape (coordinates, parameters).
        """
        ...

    def leave_groups_out(self, group_of_curve: IndexArray) -> Iterator[LeftOutCurves]:
        """Each group of curves as the others predict it.

        Args:
            group_of_curve: Index of the group of each curve, from 0, shape (curves,).
        """
        ...


def smooth_covariance(
    covariance: CurveCovariance, row_coordinates: Coordinates, column_coordinates: Coordinates
) -> FloatArray:
    """Covariance of the smooth part of ln mu, shape (row coordinates, column coordinates)."""
    # C_E and C_G of `kernels`
    overall_factor, slip_factor = covariance.kernel.factors(
        row_coordinates.conditions, column_coordinates.conditions
    )
    row_condition = row_coordinates.condition_of_coordinate
    column_condition = column_coordinates.condition_of_coordinate
    slip_covariance = _slip_covariance(covariance, row_coordinates, column_coordinates)
    row_sums = row_coordinates.weights @ slip_covariance
    covariance_over_slip = (column_coordinates.weights @ row_sums.T).T
    total = slip_factor[:, column_condition][row_condition]
    total *= covariance_over_slip
    overall_covariance = overall_factor[:, column_condition][row_condition]
    overall_covariance *= _size_in_coordinates(covariance, row_coordinates)[:, np.newaxis]
    overall_covariance *= _size_in_coordinates(covariance, column_coordinates)
    total += overall_covariance
    total += row_coordinates.law_slopes @ column_coordinates.law_slopes.T
    if covariance.sizes.rig_gain:
        total += covariance.sizes.rig_gain**2 * row_coordinates.rig_gain_products(
            column_coordinates
        )
    return total


def weighted_covariance(
    covariance: CurveCovariance,
    row_coordinates: Coordinates,
    column_coordinates: Coordinates,
    weights: FloatArray,
) -> FloatArray:
    """`smooth_covariance` times weights of the column coordinates, shape (row coordinates,).

    The weights are first summed over the coordinates of each condition, so that the covariance of
    all coordinates is never made.
    """
    overall_factor, slip_factor = covariance.kernel.factors(
        row_coordinates.conditions, column_coordinates.conditions
    )
    row_condition = row_coordinates.condition_of_coordinate
    column_condition = column_coordinates.condition_of_coordinate
    # times a column of coordinates, it sums the weighted coordinates of each condition
    weighted_sum = scipy.sparse.csr_array(
        (weights, (column_condition, np.arange(len(weights)))),
        (len(column_coordinates.conditions), len(weights)),
    )
    column_sizes = _size_in_coordinates(covariance, column_coordinates)
    overall_sums = np.asarray(overall_factor @ (weighted_sum @ column_sizes))
    slip_sums = np.asarray(slip_factor @ (weighted_sum @ column_coordinates.weights))
    slip_covariance = _slip_covariance(covariance, row_coordinates, column_coordinates)
    product = np.sum((row_coordinates.weights @ slip_covariance) * slip_sums[row_condition], axis=1)
    product += _size_in_coordinates(covariance, row_coordinates) * overall_sums[row_condition]
    product += row_coordinates.law_slopes @ (column_coordinates.law_slopes.T @ weights)
    if covariance.sizes.rig_gain:
        product += covariance.sizes.rig_gain**2 * (
            row_coordinates.rig_gain_products(column_coordinates) @ weights
        )
    return product


def _size_in_coordinates(covariance: CurveCovariance, targets: Coordinates) -> FloatArray:
    """Coordinates of w, the size of the departure over slip, shape (coordinates,)."""
    return np.asarray(
        targets.weights @ covariance.sizes.departure_sizes.size_at_slips(targets.slips)
    )


def _slip_covariance(
    covariance: CurveCovariance, row_coordinates: Coordinates, column_coordinates: Coordinates
) -> FloatArray:
    """w M w' of `kernels` between the slips, shape (row slips, column slips)."""
    departure = covariance.sizes.departure_sizes
    distance = np.subtract.outer(row_coordinates.slips, column_coordinates.slips)
    correlation = matern(distance / departure.slip_length)
    correlation *= departure.size_at_slips(row_coordinates.slips)[:, np.newaxis]
    correlation *= departure.size_at_slips(column_coordinates.slips)
    return correlation


def smooth_variance(covariance: CurveCovariance, targets: Coordinates) -> FloatArray:
    """Prior variance of the smooth part at points, shape (points,)."""
    law_variance = np.sum(targets.law_slopes**2, axis=1)
    size_over_slip = covariance.sizes.departure_sizes.size_at_slips(targets.slips)
    departure_variance = (
        size_over_slip**2
        * covariance.kernel.variances(targets.conditions)[targets.condition_of_coordinate]
    )
    rig_variance = (
        covariance.sizes.rig_gain**2 * targets.gain**2 * (targets.rig_of_coordinate != ANOTHER_RIG)
    )
    return departure_variance + law_variance + rig_variance


def coordinates_by_group(
    curve_of_coordinate: IndexArray, group_of_curve: IndexArray
) -> list[IndexArray]:
    """Indices of the coordinates of each group of curves, one array per group.

    Args:
        curve_of_coordinate: Index of the curve of each coordinate, shape (coordinates,).
        group_of_curve: Index of the group of each curve, from 0, shape (curves,).
    """
    group_of_coordinate = group_of_curve[curve_of_coordinate]
    coordinates_in_order = np.argsort(group_of_coordinate, kind="stable")
    counts = np.bincount(group_of_coordinate)
    return np.split(coordinates_in_order, np.cumsum(counts)[:-1])


@dataclass(frozen=True)
class DensePosterior:
    """The exact posterior.

    Attributes:
        covariance: Covariance of the curves.
    """

    covariance: CurveCovariance

    @cached_property
    def covariance_factor(self) -> FloatArray:
        """Lower Cholesky factor of the covariance of the coordinates."""
        return np.asarray(scipy.linalg.cholesky(self.covariance.matrix(), lower=True))

    @cached_property
    def weights(self) -> FloatArray:
        """K^-1 y, shape (coordinates,)."""
        return self._inverse_times(self.covariance.curves.departure)

    def mean(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        return weighted_covariance(self.covariance, targets, self.all_coordinates, self.weights)

    def variance(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        cross_covariance = smooth_covariance(self.covariance, targets, self.all_coordinates)
        whitened_cross_covariance = scipy.linalg.solve_triangular(
            self.covariance_factor, cross_covariance.T, lower=True
        )
        return smooth_variance(self.covariance, targets) - np.sum(
            whitened_cross_covariance**2, axis=0
        )

    def leave_groups_out(self, group_of_curve: IndexArray) -> Iterator[LeftOutCurves]:
        """See `Posterior`."""
        inverse = self._inverse_times(np.eye(len(self.weights)))
        for coordinate_indices in coordinates_by_group(
            self.covariance.curves.curve_of_coordinate, group_of_curve
        ):
            block = inverse[np.ix_(coordinate_indices, coordinate_indices)]
            yield LeftOutCurves(coordinate_indices, block, self.weights[coordinate_indices])

    def parameter_posterior(self, slopes: FloatArray) -> ParameterPosterior:
        """See `Posterior`."""
        remaining_covariance = np.eye(slopes.shape[1]) - slopes.T @ self._inverse_times(slopes)
        return ParameterPosterior(slopes.T @ self.weights, remaining_covariance)

    @cached_property
    def all_coordinates(self) -> Coordinates:
        """All coordinates."""
        return self.covariance.curves.select_coordinates(np.arange(len(self.weights)))

    def _inverse_times(self, vectors: FloatArray) -> FloatArray:
        """K^-1 times vectors."""
        return np.asarray(scipy.linalg.cho_solve((self.covariance_factor, True), vectors))


class CurveFeatures(NamedTuple):
    """The coordinates of one or more curves, as features of a `NystromPosterior`.

    Attributes:
        coordinate_indices: Indices of the coordinates.
        features: F of these coordinates, shape (coordinates, inducing).
        unshared_factor: Lower Cholesky factor of their covariance beyond the features, which only
            coordinates of one curve share, shape (coordinates, coordinates).
    """

    coordinate_indices: IndexArray
    features: FloatArray
    unshared_factor: FloatArray


@dataclass(frozen=True)
class NystromPosterior:
    """A posterior whose cost is linear in the number of curves.

    The smooth part is F u with independent u, plus a remainder that only the points of one curve
    share. F follows from the covariance with the inducing curves. With all curves inducing it is
    the exact posterior.

    Attributes:
        covariance: Covariance of the curves.
        inducing_indices: Indices of the coordinates of the inducing curves.
    """

    covariance: CurveCovariance
    inducing_indices: IndexArray

    @cached_property
    def inducing_coordinates(self) -> Coordinates:
        """The inducing coordinates."""
        return self.covariance.curves.select_coordinates(self.inducing_indices)

    @cached_property
    def inducing_factor(self) -> FloatArray:
        """Lower Cholesky factor of the smooth covariance of the inducing coordinates."""
        inducing_covariance = smooth_covariance(
            self.covariance, self.inducing_coordinates, self.inducing_coordinates
        )
        jitter = _JITTER * np.mean(np.diag(inducing_covariance))
        return np.asarray(
            scipy.linalg.cholesky(
                inducing_covariance + jitter * np.eye(len(inducing_covariance)), lower=True
            )
        )

    @cached_property
    def inducing_posterior(self) -> tuple[FloatArray, FloatArray]:
        """Lower Cholesky factor of the precision of u given the curves, and the mean of u."""
        precision = np.eye(len(self.inducing_indices))
        precision_times_mean = np.zeros(len(self.inducing_indices))
        every_curve = np.arange(len(self.covariance.curves.conditions))
        for curve_indices in _curve_blocks(every_curve, every_curve):
            coordinate_indices, features, unshared_factor = self._features_of_curves(curve_indices)
            whitened = scipy.linalg.solve_triangular(unshared_factor, features, lower=True)
            departure = self.covariance.curves.departure[coordinate_indices]
            precision += whitened.T @ whitened
            precision_times_mean += whitened.T @ scipy.linalg.solve_triangular(
                unshared_factor, departure, lower=True
            )
        factor = scipy.linalg.cholesky(precision, lower=True)
        return factor, np.asarray(scipy.linalg.cho_solve((factor, True), precision_times_mean))

    @cached_property
    def weights(self) -> FloatArray:
        """Weights of the inducing coordinates in the mean, shape (inducing,)."""
        _, mean = self.inducing_posterior
        return np.asarray(
            scipy.linalg.solve_triangular(self.inducing_factor, mean, lower=True, trans="T")
        )

    def mean(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        return weighted_covariance(
            self.covariance, targets, self.inducing_coordinates, self.weights
        )

    def variance(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        features = self._features(targets)
        precision_factor, _ = self.inducing_posterior
        whitened_features = scipy.linalg.solve_triangular(precision_factor, features.T, lower=True)
        remainder = smooth_variance(self.covariance, targets) - np.sum(features**2, axis=1)
        return np.maximum(remainder, 0.0) + np.sum(whitened_features**2, axis=0)

    def leave_groups_out(self, group_of_curve: IndexArray) -> Iterator[LeftOutCurves]:
        """See `Posterior`."""
        precision_factor, mean = self.inducing_posterior
        curves_by_group = np.argsort(group_of_curve, kind="stable")
        for curve_indices in _curve_blocks(curves_by_group, group_of_curve[curves_by_group]):
            coordinate_indices, features, unshared_factor = self._features_of_curves(curve_indices)
            unshared_inverse = scipy.linalg.cho_solve(
                (unshared_factor, True), np.eye(len(unshared_factor))
            )
            weighted = unshared_inverse @ features
            whitened_features = scipy.linalg.solve_triangular(
                precision_factor, weighted.T, lower=True
            )
            departure = self.covariance.curves.departure[coordinate_indices]
            weights = unshared_inverse @ (departure - features @ mean)
            group_of_coordinates = group_of_curve[
                self.covariance.curves.curve_of_coordinate[coordinate_indices]
            ]
            for positions in _rows_by_group(group_of_coordinates):
                block_of_group = unshared_inverse[np.ix_(positions, positions)]
                precision = (
                    block_of_group
                    - whitened_features[:, positions].T @ whitened_features[:, positions]
                )
                yield LeftOutCurves(coordinate_indices[positions], precision, weights[positions])

    def parameter_posterior(self, slopes: FloatArray) -> ParameterPosterior:
        """See `Posterior`."""
        precision_factor, mean = self.inducing_posterior
        inducing_slopes = slopes[self.inducing_indices]
        features = scipy.linalg.solve_triangular(self.inducing_factor, inducing_slopes, lower=True)
        whitened_features = scipy.linalg.solve_triangular(precision_factor, features, lower=True)
        remaining_covariance = (
            np.eye(slopes.shape[1])
            - features.T @ features
            + whitened_features.T @ whitened_features
        )
        return ParameterPosterior(features.T @ mean, remaining_covariance)

    def features_by_curve(self) -> Iterator[CurveFeatures]:
        """The features of each curve."""
        every_curve = np.arange(len(self.covariance.curves.conditions))
        for curve_indices in _curve_blocks(every_curve, every_curve):
            coordinate_indices, features, unshared_factor = self._features_of_curves(curve_indices)
            for positions in _rows_by_group(
                self.covariance.curves.curve_of_coordinate[coordinate_indices]
            ):
                yield CurveFeatures(
                    coordinate_indices[positions],
                    features[positions],
                    unshared_factor[np.ix_(positions, positions)],
                )

    def _features_of_curves(self, curve_indices: IndexArray) -> CurveFeatures:
        """The features of some curves; `unshared_factor` is of a matrix with a block per curve.

        Args:
            curve_indices: Rows of the curves.
        """
        curves, sizes = self.covariance.curves, self.covariance.sizes
        coordinate_indices = curves.coordinate_indices_of(curve_indices)
        coordinates = curves.select_coordinates(coordinate_indices)
        features = self._features(coordinates)
        unshared_covariance = (
            smooth_covariance(self.covariance, coordinates, coordinates) - features @ features.T
        )
        scaled_effects = curves.effect_design[coordinate_indices] * sizes.effects
        unshared_covariance += scaled_effects @ scaled_effects.T
        unshared_covariance *= np.equal.outer(
            curves.curve_of_coordinate[coordinate_indices],
            curves.curve_of_coordinate[coordinate_indices],
        )
        unshared_covariance[np.diag_indices_from(unshared_covariance)] += sizes.noise**2
        unshared_factor = np.asarray(scipy.linalg.cholesky(unshared_covariance, lower=True))
        return CurveFeatures(coordinate_indices, features, unshared_factor)

    def _features(self, coordinates: Coordinates) -> FloatArray:
        """Features of coordinates, shape (coordinates, inducing)."""
        cross_covariance = smooth_covariance(
            self.covariance, coordinates, self.inducing_coordinates
        )
        return np.asarray(
            scipy.linalg.solve_triangular(self.inducing_factor, cross_covariance.T, lower=True).T
        )


def farthest_point_selection(conditions: FloatArray, wanted_count: int) -> IndexArray:
    """Indices of rows of conditions that are far from each other.

    The first row is the one nearest to the mean. Of distances that are equal but for rounding the
    first row counts.

    Args:
        conditions: Scaled conditions, shape (rows, 3).
        wanted_count: Number of rows that are chosen; fewer if there are fewer different conditions.
    """
    distance = np.linalg.norm(conditions - conditions.mean(axis=0), axis=1)
    chosen_rows = [int(first_smallest(distance))]
    distance_to_chosen = np.linalg.norm(conditions - conditions[chosen_rows[0]], axis=1)
    while len(chosen_rows) < wanted_count and distance_to_chosen.max() > 0:
        farthest = int(first_largest(distance_to_chosen))
        chosen_rows.append(farthest)
        distance_to_new = np.linalg.norm(conditions - conditions[farthest], axis=1)
        distance_to_chosen = np.minimum(distance_to_chosen, distance_to_new)
    return np.sort(np.array(chosen_rows, dtype=np.int64))


def _curve_blocks(curve_indices: IndexArray, group_of_curve: IndexArray) -> list[IndexArray]:
    """Curves in blocks of about `_CURVES_AT_ONCE` curves; all curves of a group are in one block.

    Args:
        curve_indices: Indices of curves, shape (curves,).
        group_of_curve: Index of the group of each of them, in ascending order, shape (curves,).
    """
    group_starts = np.flatnonzero(np.diff(group_of_curve, prepend=-1) > 0)
    block_of_group = group_starts // _CURVES_AT_ONCE
    block_starts = group_starts[np.diff(block_of_group, prepend=-1) > 0]
    return np.split(curve_indices, block_starts[1:])


def _rows_by_group(group_of_row: IndexArray) -> list[IndexArray]:
    """Rows of each group that has rows, in the order of the groups; one array per group."""
    sorted_rows = np.argsort(group_of_row, kind="stable")
    group_starts = np.flatnonzero(np.diff(group_of_row[sorted_rows])) + 1
    return np.split(sorted_rows, group_starts)
