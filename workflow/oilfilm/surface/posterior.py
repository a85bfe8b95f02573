"""The smooth part of a surface given the curves: dense, or on the curves of a few conditions.

Both know the coordinates that others predict without one condition in closed form, because what
is left out of a normal distribution follows from blocks of the inverse covariance:
error = (K^-1)_cc^-1 (K^-1 y)_c, with the covariance (K^-1)_cc^-1.

References: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
Eqs 2.23-2.24 and 5.12; E. Snelson, Z. Ghahramani, AISTATS 2007 (blocks of the remainder).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import scipy.linalg
import scipy.sparse

from oilfilm.base.ties import first_largest, first_smallest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.kernels import matern
from oilfilm.surface.reduction import ANOTHER_RIG, Coordinates
from oilfilm.surface.reml import CurveCovariance

# Added to the variance of each inducing coordinate, in units of the mean variance.
_JITTER = 1e-10
# Curves whose blocks are found at once: few calls, and little work on what is 0 between curves.
_CURVES_AT_ONCE = 20


@dataclass(frozen=True)
class LeftOut:
    """The coordinates of a group of curves, as all other curves predict them.

    Attributes:
        coordinates: Indices of the coordinates.
        precision: Their block of K^-1, shape (coordinates, coordinates).
        weights: Their part of K^-1 y, shape (coordinates,).
    """

    coordinates: IndexArray
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


class FreedomOfLaw(NamedTuple):
    """What is free in the law, in its standard deviations before the data.

    The order is that of `oilfilm.surface.reduction.slopes_of_law`.

    Attributes:
        change: Expected change, shape (slopes,).
        covariance: Its covariance, shape (slopes, slopes).
    """

    change: FloatArray
    covariance: FloatArray


class Posterior(Protocol):
    """The smooth part of ln mu, less the law, given the curves.

    Targets are the points, or weighted sums of points, at which it is wanted.
    """

    def mean(self, targets: Coordinates) -> FloatArray:
        """Expected value at each point, shape (points,)."""
        ...

    def variance(self, targets: Coordinates) -> FloatArray:
        """Variance at each point, shape (points,)."""
        ...

    def freedom_of_law(self) -> FreedomOfLaw:
        """What the curves say of what is free in the law."""
        ...

    def left_out(self, group: IndexArray) -> Iterator[LeftOut]:
        """Each group of curves as the others predict it.

        Args:
            group: Number of the group of each curve, from 0, shape (curves,).
        """
        ...


def smooth_covariance(
    covariance: CurveCovariance, left: Coordinates, right: Coordinates
) -> FloatArray:
    """Covariance of the smooth part, shape (coordinates of left, coordinates of right)."""
    # C_E and C_G of `kernels`
    overall_factor, slip_factor = covariance.kernel.factors(left.conditions, right.conditions)
    over_slip = (right.weights @ (left.weights @ _slip_covariance(covariance, left, right)).T).T
    total = slip_factor[:, right.row][left.row]
    total *= over_slip
    overall_covariance = overall_factor[:, right.row][left.row]
    overall_covariance *= _size_in_coordinates(covariance, left)[:, np.newaxis]
    overall_covariance *= _size_in_coordinates(covariance, right)
    total += overall_covariance
    total += left.law_slopes @ right.law_slopes.T
    if covariance.sizes.rig_gain:
        total += covariance.sizes.rig_gain**2 * left.rig_products(right)
    return total


def weighted_covariance(
    covariance: CurveCovariance, left: Coordinates, right: Coordinates, weights: FloatArray
) -> FloatArray:
    """`smooth_covariance` times weights of the right coordinates, shape (coordinates of left,).

    The weights are first summed over the coordinates of each condition, so that the covariance of
    all coordinates is never made.
    """
    overall_factor, slip_factor = covariance.kernel.factors(left.conditions, right.conditions)
    count = len(right.conditions)
    sum_by_condition = scipy.sparse.csr_array(
        (weights, (right.row, np.arange(len(weights)))), (count, len(weights))
    )
    by_overall = np.asarray(
        overall_factor @ (sum_by_condition @ _size_in_coordinates(covariance, right))
    )
    by_slip = np.asarray(slip_factor @ (sum_by_condition @ right.weights))
    over_slip = left.weights @ _slip_covariance(covariance, left, right)
    product = np.sum(over_slip * by_slip[left.row], axis=1)
    product += _size_in_coordinates(covariance, left) * by_overall[left.row]
    product += left.law_slopes @ (right.law_slopes.T @ weights)
    if covariance.sizes.rig_gain:
        product += covariance.sizes.rig_gain**2 * (left.rig_products(right) @ weights)
    return product


def _size_in_coordinates(covariance: CurveCovariance, targets: Coordinates) -> FloatArray:
    """Coordinates of w, the size of the departure over slip, shape (coordinates,)."""
    return np.asarray(targets.weights @ covariance.sizes.departure.over_slip(targets.slips))


def _slip_covariance(
    covariance: CurveCovariance, left: Coordinates, right: Coordinates
) -> FloatArray:
    """w M w' between the slips, shape (slips of left, slips of right)."""
    departure = covariance.sizes.departure
    distance = np.subtract.outer(left.slips, right.slips)
    correlation = matern(distance / departure.slip_length)
    correlation *= departure.over_slip(left.slips)[:, np.newaxis]
    correlation *= departure.over_slip(right.slips)
    return correlation


def smooth_variance(covariance: CurveCovariance, targets: Coordinates) -> FloatArray:
    """Variance of the smooth part at points before the data, shape (points,)."""
    law_variance = np.sum(targets.law_slopes**2, axis=1)
    size_over_slip = covariance.sizes.departure.over_slip(targets.slips)
    departure_variance = (
        size_over_slip**2 * covariance.kernel.variances(targets.conditions)[targets.row]
    )
    rig_variance = covariance.sizes.rig_gain**2 * targets.gain**2 * (targets.rig != ANOTHER_RIG)
    return departure_variance + law_variance + rig_variance


def coordinates_by_group(curves_of_coordinates: IndexArray, group: IndexArray) -> list[IndexArray]:
    """Indices of the coordinates of each group of curves."""
    group_of_coordinates = group[curves_of_coordinates]
    order = np.argsort(group_of_coordinates, kind="stable")
    counts = np.bincount(group_of_coordinates)
    return np.split(order, np.cumsum(counts)[:-1])


@dataclass(frozen=True)
class DensePosterior:
    """The exact posterior.

    Attributes:
        covariance: Covariance of the curves.
    """

    covariance: CurveCovariance

    @cached_property
    def factor(self) -> FloatArray:
        """Lower Cholesky factor of the covariance of the coordinates."""
        return np.asarray(scipy.linalg.cholesky(self.covariance.matrix(), lower=True))

    @cached_property
    def weights(self) -> FloatArray:
        """K^-1 y, shape (coordinates,)."""
        return self._solved(self.covariance.curves.departure)

    def mean(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        return weighted_covariance(self.covariance, targets, self.all_coordinates, self.weights)

    def variance(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        across = smooth_covariance(self.covariance, targets, self.all_coordinates)
        whitened_across = scipy.linalg.solve_triangular(self.factor, across.T, lower=True)
        return smooth_variance(self.covariance, targets) - np.sum(whitened_across**2, axis=0)

    def left_out(self, group: IndexArray) -> Iterator[LeftOut]:
        """See `Posterior`."""
        inverse = self._solved(np.eye(len(self.weights)))
        for coordinates in coordinates_by_group(self.covariance.curves.curve, group):
            block = inverse[np.ix_(coordinates, coordinates)]
            yield LeftOut(coordinates, block, self.weights[coordinates])

    def freedom_of_law(self) -> FreedomOfLaw:
        """See `Posterior`."""
        slopes = self.covariance.curves.law_slopes
        remaining_covariance = np.eye(slopes.shape[1]) - slopes.T @ self._solved(slopes)
        return FreedomOfLaw(slopes.T @ self.weights, remaining_covariance)

    @cached_property
    def all_coordinates(self) -> Coordinates:
        """All coordinates."""
        return self.covariance.curves.select(np.arange(len(self.weights)))

    def _solved(self, right: FloatArray) -> FloatArray:
        """K^-1 times vectors."""
        return np.asarray(scipy.linalg.cho_solve((self.factor, True), right))


class CurveFeatures(NamedTuple):
    """The coordinates of one or more curves, as a `NystromPosterior` has them.

    Attributes:
        coordinates: Indices of the coordinates.
        features: F of these coordinates, shape (coordinates, inducing).
        unshared_factor: Lower Cholesky factor of the covariance that different curves do not share.
    """

    coordinates: IndexArray
    features: FloatArray
    unshared_factor: FloatArray


@dataclass(frozen=True)
class NystromPosterior:
    """A posterior whose cost is linear in the number of curves.

    The smooth part is u' F with independent u, and a remainder that only the points of one curve
    share. With all curves inducing it is the exact posterior.

    Attributes:
        covariance: Covariance of the curves.
        inducing: Indices of the coordinates of the inducing curves.
    """

    covariance: CurveCovariance
    inducing: IndexArray

    @cached_property
    def basis(self) -> Coordinates:
        """The inducing coordinates."""
        return self.covariance.curves.select(self.inducing)

    @cached_property
    def factor(self) -> FloatArray:
        """Lower Cholesky factor of the smooth covariance of the inducing coordinates."""
        inducing_covariance = smooth_covariance(self.covariance, self.basis, self.basis)
        jitter = _JITTER * np.mean(np.diag(inducing_covariance))
        return np.asarray(
            scipy.linalg.cholesky(
                inducing_covariance + jitter * np.eye(len(inducing_covariance)), lower=True
            )
        )

    @cached_property
    def inducing_posterior(self) -> tuple[FloatArray, FloatArray]:
        """Lower Cholesky factor of the precision of u given the curves, and the mean of u."""
        # the mean solves precision u = pull
        precision = np.eye(len(self.inducing))
        pull = np.zeros(len(self.inducing))
        every_curve = np.arange(len(self.covariance.curves.conditions))
        for rows in _in_blocks(every_curve, every_curve):
            coordinates, features, unshared_factor = self._curves(rows)
            whitened = scipy.linalg.solve_triangular(unshared_factor, features, lower=True)
            departure = self.covariance.curves.departure[coordinates]
            precision += whitened.T @ whitened
            pull += whitened.T @ scipy.linalg.solve_triangular(
                unshared_factor, departure, lower=True
            )
        factor = scipy.linalg.cholesky(precision, lower=True)
        return factor, np.asarray(scipy.linalg.cho_solve((factor, True), pull))

    @cached_property
    def weights(self) -> FloatArray:
        """Weights of the inducing coordinates in the mean, shape (inducing,)."""
        _, mean = self.inducing_posterior
        return np.asarray(scipy.linalg.solve_triangular(self.factor, mean, lower=True, trans="T"))

    def mean(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        return weighted_covariance(self.covariance, targets, self.basis, self.weights)

    def variance(self, targets: Coordinates) -> FloatArray:
        """See `Posterior`."""
        features = self._features(targets)
        precision_factor, _ = self.inducing_posterior
        whitened_features = scipy.linalg.solve_triangular(precision_factor, features.T, lower=True)
        remainder = smooth_variance(self.covariance, targets) - np.sum(features**2, axis=1)
        return np.maximum(remainder, 0.0) + np.sum(whitened_features**2, axis=0)

    def left_out(self, group: IndexArray) -> Iterator[LeftOut]:
        """See `Posterior`."""
        precision_factor, mean = self.inducing_posterior
        order = np.argsort(group, kind="stable")
        for block in _in_blocks(order, group[order]):
            coordinates, features, unshared_factor = self._curves(block)
            unshared_inverse = scipy.linalg.cho_solve(
                (unshared_factor, True), np.eye(len(unshared_factor))
            )
            weighted = unshared_inverse @ features
            whitened_features = scipy.linalg.solve_triangular(
                precision_factor, weighted.T, lower=True
            )
            departure = self.covariance.curves.departure[coordinates]
            weights = unshared_inverse @ (departure - features @ mean)
            group_of_coordinates = group[self.covariance.curves.curve[coordinates]]
            for rows in _rows_by_group(group_of_coordinates):
                block_of_group = unshared_inverse[np.ix_(rows, rows)]
                precision = (
                    block_of_group - whitened_features[:, rows].T @ whitened_features[:, rows]
                )
                yield LeftOut(coordinates[rows], precision, weights[rows])

    def freedom_of_law(self) -> FreedomOfLaw:
        """See `Posterior`."""
        precision_factor, mean = self.inducing_posterior
        slopes = self.covariance.curves.law_slopes[self.inducing]
        features = scipy.linalg.solve_triangular(self.factor, slopes, lower=True)
        whitened_features = scipy.linalg.solve_triangular(precision_factor, features, lower=True)
        remaining_covariance = (
            np.eye(slopes.shape[1])
            - features.T @ features
            + whitened_features.T @ whitened_features
        )
        return FreedomOfLaw(features.T @ mean, remaining_covariance)

    def by_curve(self) -> Iterator[CurveFeatures]:
        """The features of each curve."""
        every_curve = np.arange(len(self.covariance.curves.conditions))
        for rows in _in_blocks(every_curve, every_curve):
            coordinates, features, unshared_factor = self._curves(rows)
            for rows_of_curve in _rows_by_group(self.covariance.curves.curve[coordinates]):
                yield CurveFeatures(
                    coordinates[rows_of_curve],
                    features[rows_of_curve],
                    unshared_factor[np.ix_(rows_of_curve, rows_of_curve)],
                )

    def _curves(self, rows: IndexArray) -> CurveFeatures:
        """The features of some curves; `unshared_factor` is of a matrix with a block per curve.

        Args:
            rows: Rows of the curves.
        """
        curves, sizes = self.covariance.curves, self.covariance.sizes
        coordinates = curves.coordinates_of(rows)
        block = curves.select(coordinates)
        features = self._features(block)
        unshared_covariance = (
            smooth_covariance(self.covariance, block, block) - features @ features.T
        )
        scaled_effects = curves.effects[coordinates] * sizes.effects
        unshared_covariance += scaled_effects @ scaled_effects.T
        unshared_covariance *= np.equal.outer(curves.curve[coordinates], curves.curve[coordinates])
        unshared_covariance[np.diag_indices_from(unshared_covariance)] += sizes.noise**2
        unshared_factor = np.asarray(scipy.linalg.cholesky(unshared_covariance, lower=True))
        return CurveFeatures(coordinates, features, unshared_factor)

    def _features(self, coordinates: Coordinates) -> FloatArray:
        """Features of coordinates, shape (coordinates, inducing)."""
        across = smooth_covariance(self.covariance, coordinates, self.basis)
        return np.asarray(scipy.linalg.solve_triangular(self.factor, across.T, lower=True).T)


def spread_out(conditions: FloatArray, count: int) -> IndexArray:
    """Rows of conditions that are far from each other, by farthest-point selection.

    The first row is the one nearest to the mean. Of distances that are equal but for rounding the
    first row counts.

    Args:
        conditions: Scaled conditions, shape (rows, 3).
        count: Number of rows wanted; fewer if there are fewer different conditions.
    """
    distance = np.linalg.norm(conditions - conditions.mean(axis=0), axis=1)
    chosen = [int(first_smallest(distance))]
    distance_to_chosen = np.linalg.norm(conditions - conditions[chosen[0]], axis=1)
    while len(chosen) < count and distance_to_chosen.max() > 0:
        farthest = int(first_largest(distance_to_chosen))
        chosen.append(farthest)
        distance_to_new = np.linalg.norm(conditions - conditions[farthest], axis=1)
        distance_to_chosen = np.minimum(distance_to_chosen, distance_to_new)
    return np.sort(np.array(chosen, dtype=np.int64))


def _in_blocks(rows: IndexArray, group: IndexArray) -> list[IndexArray]:
    """Rows in blocks of some curves; a group is in one block.

    Args:
        rows: Rows of curves, shape (curves,).
        group: Number of the group of each of them, in ascending order, shape (curves,).
    """
    is_first = np.diff(group, prepend=-1) > 0
    starts = np.flatnonzero(is_first)
    block_of_group = starts // _CURVES_AT_ONCE
    begins = starts[np.diff(block_of_group, prepend=-1) > 0]
    return np.split(rows, begins[1:])


def _rows_by_group(group: IndexArray) -> list[IndexArray]:
    """Rows of each group that has some, in the order of their numbers."""
    order = np.argsort(group, kind="stable")
    begins = np.flatnonzero(np.diff(group[order])) + 1
    return np.split(order, begins)
