"""Likelihood of changes in the effects of runs, given the points.

The effects u of a kind (one per run) enter the points y by a design Z. With the mean beta p over
the runs, a pattern p, and the variance v per run, twice the logarithm of the likelihood is

    steady(v) + 2 beta p' q - beta^2 p' W p,   W = Z' P Z,   q = Z' P y,

where P is the inverse covariance of the points with the variance v. The best beta is p'q / p'Wp,
and the ratio of likelihoods is (p'q)^2 / p'Wp. What is different for each variance follows from the
eigenvalues of W at v = 0, or for many curves from features of a few conditions (Nystrom).

Reference: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
Eq. A.9 and A.10 (inverse and determinant of a sum).

Decides: which variances of an effect are tried.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
import scipy.linalg

from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import EFFECTS
from oilfilm.surface.posterior import NystromPosterior, spread_out
from oilfilm.surface.reml import CurveCovariance
from oilfilm.surface.surface import LARGEST_DENSE

# In a large campaign, so many conditions stand for all.
_INDUCING_CONDITIONS = 40
# Variances that are tried, over the variance in the fit, and the number of the latter.
_VARIANCES = np.geomspace(1e-3, 1e3, 31)
EXPECTED = 15
# Standard deviation of the logarithm of a size before the data.
_LN_SD = 0.6


@dataclass(frozen=True)
class Information:
    """What the points say of the effects of one kind, at one variance.

    W is diag(unshared) + sign root root'.

    Attributes:
        pull: q, shape (curves,).
        unshared: Part of the diagonal of W that each run has by itself, shape (curves,).
        root: Root of the part of W that couples the runs, shape (curves, n).
        sign: Sign of that part, 1 or -1.
    """

    pull: FloatArray
    unshared: FloatArray
    root: FloatArray
    sign: float

    def between(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """p' W r of each column p of the left and r of the right, shape (patterns,)."""
        shared = np.sum((self.root.T @ left) * (self.root.T @ right), axis=0)
        return self.unshared @ (left * right) + self.sign * shared

    def times(self, columns: FloatArray) -> FloatArray:
        """W times columns, shape (curves, ...)."""
        unshared_term = (self.unshared * columns.T).T
        return np.asarray(unshared_term + self.sign * (self.root @ (self.root.T @ columns)))

    def diagonal(self) -> FloatArray:
        """Diagonal of W, shape (curves,)."""
        return self.unshared + self.sign * np.sum(self.root**2, axis=1)


class EffectLikelihood(Protocol):
    """Likelihood of the effects of one kind."""

    @property
    def steady(self) -> FloatArray:
        """Twice the logarithm of the likelihood without a change, up to a constant.

        What is known of the variance before the data is included. Shape (variances,).
        """
        ...

    def information(self, number: int) -> Information:
        """What the points say at one of the variances."""
        ...


def effect_likelihood(covariance: CurveCovariance, effect: str) -> EffectLikelihood:
    """The likelihood of one effect.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        effect: One of `oilfilm.surface.effects.EFFECTS`.
    """
    if len(covariance.curves.conditions) > LARGEST_DENSE:
        return _LowRank.from_covariance(covariance, effect)
    return _Dense.from_covariance(covariance, effect)


def _log_prior_density() -> FloatArray:
    """Twice the logarithm of the density of each variance before the data, shape (variances,)."""
    return -((np.log(_VARIANCES) / 2 / _LN_SD) ** 2)


@dataclass(frozen=True)
class _Dense:
    """The likelihood from eigenvalues.

    Attributes:
        values: Eigenvalues of W without the effect, shape (curves,).
        vectors: Its eigenvectors, shape (curves, curves).
        pull: q along the eigenvectors, shape (curves,).
        expected_variance: Variance of an effect in the fit.
    """

    values: FloatArray
    vectors: FloatArray
    pull: FloatArray
    expected_variance: float

    @classmethod
    def from_covariance(cls, covariance: CurveCovariance, effect: str) -> "_Dense":
        """The likelihood of one effect."""
        number = EFFECTS.index(effect)
        sizes = covariance.sizes.effects.copy()
        expected = float(sizes[number] ** 2)
        sizes[number] = 0.0
        without_effect = replace(covariance, sizes=replace(covariance.sizes, effects=sizes))
        curves = covariance.curves
        design = curves.membership.multiply(curves.effects[:, number, np.newaxis]).toarray()
        factor = scipy.linalg.cholesky(without_effect.matrix(), lower=True)
        whitened_design = scipy.linalg.solve_triangular(factor, design, lower=True)
        whitened_departure = scipy.linalg.solve_triangular(factor, curves.departure, lower=True)
        values, vectors = scipy.linalg.eigh(whitened_design.T @ whitened_design)
        pull = vectors.T @ (whitened_design.T @ whitened_departure)
        return cls(np.maximum(values, 0.0), vectors, pull, expected)

    @property
    def steady(self) -> FloatArray:
        """See `EffectLikelihood`."""
        variances = self.expected_variance * _VARIANCES
        shrinkage = 1 / (1 + np.outer(variances, self.values))
        squares = variances[:, np.newaxis] * shrinkage * self.pull**2
        return np.sum(squares + np.log(shrinkage), axis=1) + _log_prior_density()

    def information(self, number: int) -> Information:
        """See `EffectLikelihood`."""
        shrinkage = 1 / (1 + self.expected_variance * _VARIANCES[number] * self.values)
        return Information(
            pull=self.vectors @ (shrinkage * self.pull),
            unshared=np.zeros(len(self.values)),
            root=self.vectors * np.sqrt(shrinkage * self.values),
            sign=1.0,
        )


@dataclass(frozen=True)
class _LowRank:
    """The likelihood from features of a few conditions.

    The covariance of a curve is D + F F', with D for what only its points share. All sums are with
    the variance of the fit; another variance changes D by a matrix of rank one per curve.

    Attributes:
        unshared: z' D^-1 z of each curve, with its column z of the design, shape (curves,).
        unshared_pull: z' D^-1 y of each curve, shape (curves,).
        features: z' D^-1 F of each curve, shape (curves, features).
        precision: 1 + F' D^-1 F of all curves, shape (features, features).
        feature_pull: F' D^-1 y of all curves, shape (features,).
        expected_variance: Variance of an effect in the fit.
    """

    unshared: FloatArray
    unshared_pull: FloatArray
    features: FloatArray
    precision: FloatArray
    feature_pull: FloatArray
    expected_variance: float

    @classmethod
    def from_covariance(cls, covariance: CurveCovariance, effect: str) -> "_LowRank":
        """The likelihood of one effect from the curves of a few conditions.

        The features of one effect are the largest array of a campaign: those of all effects are
        never in memory together.
        """
        number = EFFECTS.index(effect)
        curves = covariance.curves
        chosen = spread_out(curves.conditions, _INDUCING_CONDITIONS)
        posterior = NystromPosterior(covariance, np.flatnonzero(np.isin(curves.curve, chosen)))
        curve_count, feature_count = len(curves.conditions), len(posterior.inducing)
        unshared, unshared_pull = np.zeros((2, curve_count))
        unshared_features = np.zeros((curve_count, feature_count))
        precision, feature_pull = np.eye(feature_count), np.zeros(feature_count)
        for row, (coordinates, features, factor) in enumerate(posterior.by_curve()):
            columns = [features, curves.effects[coordinates, number], curves.departure[coordinates]]
            stacked = scipy.linalg.solve_triangular(factor, np.column_stack(columns), lower=True)
            whitened, design, departure = stacked[:, :-2], stacked[:, -2], stacked[:, -1]
            precision += whitened.T @ whitened
            feature_pull += whitened.T @ departure
            unshared[row] = design @ design
            unshared_pull[row] = design @ departure
            unshared_features[row] = design @ whitened
        return cls(
            unshared=unshared,
            unshared_pull=unshared_pull,
            features=unshared_features,
            precision=precision,
            feature_pull=feature_pull,
            expected_variance=float(covariance.sizes.effects[number] ** 2),
        )

    @property
    def steady(self) -> FloatArray:
        """See `EffectLikelihood`."""
        values = []
        for variance in self.expected_variance * _VARIANCES:
            variance_change, factor, pull = self._at_variance(variance)
            solved = scipy.linalg.solve_triangular(factor, pull, lower=True)
            growth = 1 + variance_change * self.unshared
            determinant = np.sum(np.log(growth)) + 2 * np.sum(np.log(np.diag(factor)))
            values.append(
                np.sum(variance_change * self.unshared_pull**2 / growth)
                + solved @ solved
                - determinant
            )
        return np.array(values) + _log_prior_density()

    def information(self, number: int) -> Information:
        """See `EffectLikelihood`."""
        variance_change, factor, pull = self._at_variance(
            self.expected_variance * _VARIANCES[number]
        )
        growth = 1 + variance_change * self.unshared
        features = self.features / growth[:, np.newaxis]
        root = scipy.linalg.solve_triangular(factor, features.T, lower=True).T
        solved = scipy.linalg.solve_triangular(factor, pull, lower=True)
        return Information(
            pull=self.unshared_pull / growth - root @ solved,
            unshared=self.unshared / growth,
            root=root,
            sign=-1.0,
        )

    def _at_variance(self, variance: float) -> "_FeaturesAtVariance":
        """The features with another variance of the effect."""
        variance_change = variance - self.expected_variance
        growth = 1 + variance_change * self.unshared
        weighted = self.features * (variance_change / growth)[:, np.newaxis]
        precision = self.precision - self.features.T @ weighted
        pull = self.feature_pull - weighted.T @ self.unshared_pull
        factor = scipy.linalg.cholesky(precision, lower=True)
        return _FeaturesAtVariance(variance_change, factor, pull)


class _FeaturesAtVariance(NamedTuple):
    """What the features say at one variance of the effect.

    Attributes:
        variance_change: This variance less that of the fit.
        factor: Lower Cholesky factor of the precision of the features.
        pull: F' D^-1 y with this variance, shape (features,).
    """

    variance_change: float
    factor: FloatArray
    pull: FloatArray
