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
from typing import Protocol

import numpy as np
import scipy.linalg

from oilfilm.base.ties import first_largest, first_smallest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.kernels import matern
from oilfilm.surface.reduction import Coordinates
from oilfilm.surface.reml import CurveCovariance

# Added to the variance of each inducing coordinate, in units of the mean variance.
_JITTER = 1e-10


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


class Posterior(Protocol):
    """The smooth part of ln mu, less the law, given the curves."""

    def mean(self, places: Coordinates) -> FloatArray:
        """Expected value at each point, shape (points,)."""
        ...

    def variance(self, places: Coordinates) -> FloatArray:
        """Variance at each point, shape (points,)."""
        ...

    def freedom_of_law(self) -> tuple[FloatArray, FloatArray]:
        """Change of what is free in the law, and its covariance, in standard deviations before.

        The order is that of `oilfilm.surface.reduction.slopes_of_law`.
        """
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
    level_factor, slip_factor = covariance.kernel.factors(left.conditions, right.conditions)
    distance = np.subtract.outer(left.slips, right.slips)
    correlation = matern(distance / covariance.sizes.departure.slip_length)
    left_size = covariance.sizes.departure.over_slip(left.slips)
    right_size = covariance.sizes.departure.over_slip(right.slips)
    correlation *= np.outer(left_size, right_size)
    over_slip = (right.weights @ (left.weights @ correlation).T).T
    expanded = np.ix_(left.row, right.row)
    level = np.outer(left.weights @ left_size, right.weights @ right_size)
    departure = level_factor[expanded] * level + slip_factor[expanded] * over_slip
    return departure + left.law_slopes @ right.law_slopes.T


def smooth_variance(covariance: CurveCovariance, places: Coordinates) -> FloatArray:
    """Variance of the smooth part at points before the data, shape (points,)."""
    of_law = np.sum(places.law_slopes**2, axis=1)
    size = covariance.sizes.departure.over_slip(places.slips)
    return size**2 * covariance.kernel.variances(places.conditions) + of_law


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

    def mean(self, places: Coordinates) -> FloatArray:
        """See `Posterior`."""
        return smooth_covariance(self.covariance, places, self.everything) @ self.weights

    def variance(self, places: Coordinates) -> FloatArray:
        """See `Posterior`."""
        across = smooth_covariance(self.covariance, places, self.everything)
        half = scipy.linalg.solve_triangular(self.factor, across.T, lower=True)
        return smooth_variance(self.covariance, places) - np.sum(half**2, axis=0)

    def left_out(self, group: IndexArray) -> Iterator[LeftOut]:
        """See `Posterior`."""
        inverse = self._solved(np.eye(len(self.weights)))
        for coordinates in coordinates_by_group(self.covariance.curves.curve, group):
            block = inverse[np.ix_(coordinates, coordinates)]
            yield LeftOut(coordinates, block, self.weights[coordinates])

    def freedom_of_law(self) -> tuple[FloatArray, FloatArray]:
        """See `Posterior`."""
        slopes = self.covariance.curves.law_slopes
        unexplained = np.eye(slopes.shape[1]) - slopes.T @ self._solved(slopes)
        return slopes.T @ self.weights, unexplained

    @cached_property
    def everything(self) -> Coordinates:
        """All coordinates."""
        return self.covariance.curves.part(np.arange(len(self.weights)))

    def _solved(self, right: FloatArray) -> FloatArray:
        """K^-1 times vectors."""
        return np.asarray(scipy.linalg.cho_solve((self.factor, True), right))


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
        return self.covariance.curves.part(self.inducing)

    @cached_property
    def factor(self) -> FloatArray:
        """Lower Cholesky factor of the smooth covariance of the inducing coordinates."""
        among = smooth_covariance(self.covariance, self.basis, self.basis)
        jitter = _JITTER * np.mean(np.diag(among))
        return np.asarray(scipy.linalg.cholesky(among + jitter * np.eye(len(among)), lower=True))

    @cached_property
    def solved(self) -> tuple[FloatArray, FloatArray]:
        """Cholesky factor of the precision of u, and the mean of u."""
        precision = np.eye(len(self.inducing))
        pull = np.zeros(len(self.inducing))
        for coordinates in self._of_curves():
            features, own_factor = self._curve(coordinates)
            whitened = scipy.linalg.solve_triangular(own_factor, features, lower=True)
            departure = self.covariance.curves.departure[coordinates]
            precision += whitened.T @ whitened
            pull += whitened.T @ scipy.linalg.solve_triangular(own_factor, departure, lower=True)
        factor = scipy.linalg.cholesky(precision, lower=True)
        return factor, np.asarray(scipy.linalg.cho_solve((factor, True), pull))

    def mean(self, places: Coordinates) -> FloatArray:
        """See `Posterior`."""
        _, mean = self.solved
        return self._features(places) @ mean

    def variance(self, places: Coordinates) -> FloatArray:
        """See `Posterior`."""
        features = self._features(places)
        precision_factor, _ = self.solved
        half = scipy.linalg.solve_triangular(precision_factor, features.T, lower=True)
        remainder = smooth_variance(self.covariance, places) - np.sum(features**2, axis=1)
        return np.maximum(remainder, 0.0) + np.sum(half**2, axis=0)

    def left_out(self, group: IndexArray) -> Iterator[LeftOut]:
        """See `Posterior`."""
        precision_factor, mean = self.solved
        by_curve = self._of_curves()
        for rows in _rows_by_group(group):
            features, blocks = [], []
            for row in rows:
                of_curve, own_factor = self._curve(by_curve[row])
                features.append(of_curve)
                blocks.append(scipy.linalg.cho_solve((own_factor, True), np.eye(len(own_factor))))
            coordinates = np.concatenate([by_curve[row] for row in rows])
            own_inverse = scipy.linalg.block_diag(*blocks)
            stacked = np.vstack(features)
            weighted = own_inverse @ stacked
            half = scipy.linalg.solve_triangular(precision_factor, weighted.T, lower=True)
            departure = self.covariance.curves.departure[coordinates]
            weights = own_inverse @ (departure - stacked @ mean)
            yield LeftOut(coordinates, own_inverse - half.T @ half, weights)

    def freedom_of_law(self) -> tuple[FloatArray, FloatArray]:
        """See `Posterior`."""
        precision_factor, mean = self.solved
        slopes = self.covariance.curves.law_slopes[self.inducing]
        features = scipy.linalg.solve_triangular(self.factor, slopes, lower=True)
        half = scipy.linalg.solve_triangular(precision_factor, features, lower=True)
        left_over = np.eye(slopes.shape[1]) - features.T @ features + half.T @ half
        return features.T @ mean, left_over

    def of_curves(self) -> Iterator[tuple[IndexArray, FloatArray, FloatArray]]:
        """Coordinates of each curve, their features, and the factor of what only they share."""
        for coordinates in self._of_curves():
            features, own_factor = self._curve(coordinates)
            yield coordinates, features, own_factor

    def _of_curves(self) -> list[IndexArray]:
        """Indices of the coordinates of each curve."""
        curves = self.covariance.curves
        return coordinates_by_group(curves.curve, np.arange(len(curves.conditions)))

    def _curve(self, coordinates: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Features of a curve, and the Cholesky factor of what only its points share."""
        curves, sizes = self.covariance.curves, self.covariance.sizes
        part = curves.part(coordinates)
        features = self._features(part)
        own = smooth_covariance(self.covariance, part, part) - features @ features.T
        scaled = curves.effects[coordinates] * sizes.effects
        own += scaled @ scaled.T + sizes.noise**2 * np.eye(len(own))
        return features, np.asarray(scipy.linalg.cholesky(own, lower=True))

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
    nearest = np.linalg.norm(conditions - conditions[chosen[0]], axis=1)
    while len(chosen) < count and nearest.max() > 0:
        farthest = int(first_largest(nearest))
        chosen.append(farthest)
        step = np.linalg.norm(conditions - conditions[farthest], axis=1)
        nearest = np.minimum(nearest, step)
    return np.sort(np.array(chosen, dtype=np.int64))


def _rows_by_group(group: IndexArray) -> list[IndexArray]:
    """Rows of each group."""
    order = np.argsort(group, kind="stable")
    return np.split(order, np.cumsum(np.bincount(group))[:-1])
