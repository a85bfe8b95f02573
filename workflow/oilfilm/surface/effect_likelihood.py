"""Likelihood of changes in the effects of runs, given the points.

Each run has one effect of each kind, as its gain. The effects u of one kind enter the points y by a
design Z. Each effect has the variance v. Its mean is beta p: a size beta times a pattern p over the
runs, as a step or a trend. Twice the logarithm of the likelihood is then

    L(v) + 2 beta p' q - beta^2 p' W p,   W = Z' P Z,   q = Z' P y,

where P is the inverse covariance of the points with the variance v, and L(v) is the value without a
change. The most likely beta is p'q / p'Wp; there, twice the logarithm of the likelihood ratio is
(p'q)^2 / p'Wp. All variances follow from the eigenvalues of W at v = 0, or for many curves from
features of a few conditions (Nystrom).

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

# Number of conditions that stand for all in a large campaign.
_INDUCING_CONDITIONS = 40
# Variances that are tried, over the variance in the fit.
_VARIANCE_RATIOS = np.geomspace(1e-3, 1e3, 31)
# Index of the variance in the fit among them.
INDEX_OF_FIT = 15
# Standard deviation of the logarithm of the standard deviation of an effect, before the data.
_LN_SD = 0.6
# Curves whose features are weighted at once.
_CURVES_AT_ONCE = 4096


@dataclass(frozen=True)
class Information:
    """q and W of the effects of one kind, at one variance: what the points say of them.

    W = diag(unshared) + sign root root'.

    Attributes:
        pull: q, shape (curves,).
        unshared: Diagonal of the part of W that does not couple the runs, shape (curves,).
        root: Root of the part of W that couples the runs, shape (curves, any number of columns).
        sign: Sign of the latter part, 1 or -1.
    """

    pull: FloatArray
    unshared: FloatArray
    root: FloatArray
    sign: float

    def products(self, patterns: FloatArray, other_patterns: FloatArray) -> FloatArray:
        """p' W r of each pair of a pattern p and another pattern r, shape (patterns,).

        Args:
            patterns: One pattern p per column, shape (curves, patterns).
            other_patterns: One pattern r per column, shape (curves, patterns).
        """
        shared = np.sum((self.root.T @ patterns) * (self.root.T @ other_patterns), axis=0)
        return self.unshared @ (patterns * other_patterns) + self.sign * shared

    def times(self, columns: FloatArray) -> FloatArray:
        """W times columns, shape (curves, ...)."""
        unshared_term = (self.unshared * columns.T).T
        return np.asarray(unshared_term + self.sign * (self.root @ (self.root.T @ columns)))

    def diagonal(self) -> FloatArray:
        """Diagonal of W, shape (curves,)."""
        # without an array of squares: in large campaigns the root is the largest array
        return self.unshared + self.sign * np.einsum("ij,ij->i", self.root, self.root)


class EffectLikelihood(Protocol):
    """Likelihood of the effects of one kind."""

    def twice_ln_likelihood_of_steady_runs(self) -> FloatArray:
        """Twice the logarithm of the likelihood without a change at each variance.

        It is known up to a constant, and includes the prior of the variance. Shape (variances,).
        """
        ...

    def information(self, variance_index: int) -> Information:
        """What the points say of the effects at one of the variances."""
        ...


def effect_likelihood(covariance: CurveCovariance, effect_name: str) -> EffectLikelihood:
    """The likelihood of one effect.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        effect_name: One of `oilfilm.surface.effects.EFFECTS`.
    """
    if len(covariance.curves.conditions) > LARGEST_DENSE:
        return _LowRank.from_covariance(covariance, effect_name)
    return _Dense.from_covariance(covariance, effect_name)


def _log_prior_density() -> FloatArray:
    """Twice the logarithm of the density of each variance before the data, shape (variances,)."""
    return -((np.log(_VARIANCE_RATIOS) / 2 / _LN_SD) ** 2)


@dataclass(frozen=True)
class _Dense:
    """The exact likelihood from eigenvalues, for at most `LARGEST_DENSE` curves.

    Attributes:
        eigenvalues: Eigenvalues of W at the variance 0, shape (curves,).
        eigenvectors: Its eigenvectors, one per column, shape (curves, curves).
        pull_of_eigenvectors: q along the eigenvectors, shape (curves,).
        expected_variance: Variance of an effect in the fit.
    """

    eigenvalues: FloatArray
    eigenvectors: FloatArray
    pull_of_eigenvectors: FloatArray
    expected_variance: float

    @classmethod
    def from_covariance(cls, covariance: CurveCovariance, effect_name: str) -> "_Dense":
        """The likelihood of one effect."""
        effect_index = EFFECTS.index(effect_name)
        sizes = covariance.sizes.effects.copy()
        expected_variance = float(sizes[effect_index] ** 2)
        sizes[effect_index] = 0.0
        without_effect = replace(covariance, sizes=replace(covariance.sizes, effects=sizes))
        curves = covariance.curves
        design = curves.membership.multiply(curves.effects[:, effect_index, np.newaxis]).toarray()
        factor = scipy.linalg.cholesky(without_effect.matrix(), lower=True)
        whitened_design = scipy.linalg.solve_triangular(factor, design, lower=True)
        whitened_departure = scipy.linalg.solve_triangular(factor, curves.departure, lower=True)
        eigenvalues, eigenvectors = scipy.linalg.eigh(whitened_design.T @ whitened_design)
        pull = eigenvectors.T @ (whitened_design.T @ whitened_departure)
        return cls(np.maximum(eigenvalues, 0.0), eigenvectors, pull, expected_variance)

    def twice_ln_likelihood_of_steady_runs(self) -> FloatArray:
        """See `EffectLikelihood`."""
        variances = self.expected_variance * _VARIANCE_RATIOS
        shrinkage = 1 / (1 + np.outer(variances, self.eigenvalues))
        explained_squares = variances[:, np.newaxis] * shrinkage * self.pull_of_eigenvectors**2
        return np.sum(explained_squares + np.log(shrinkage), axis=1) + _log_prior_density()

    def information(self, variance_index: int) -> Information:
        """See `EffectLikelihood`."""
        shrinkage = 1 / (
            1 + self.expected_variance * _VARIANCE_RATIOS[variance_index] * self.eigenvalues
        )
        return Information(
            pull=self.eigenvectors @ (shrinkage * self.pull_of_eigenvectors),
            unshared=np.zeros(len(self.eigenvalues)),
            root=self.eigenvectors * np.sqrt(shrinkage * self.eigenvalues),
            sign=1.0,
        )


@dataclass(frozen=True)
class _LowRank:
    """The likelihood from features of a few conditions, for many curves.

    The covariance of a curve is D + F F', with D for what only its points share. All sums are with
    the variance of the fit; another variance changes D by a matrix of rank one per curve.

    Attributes:
        design_squares: z' D^-1 z of each curve, with its column z of the design, shape (curves,).
        design_pull: z' D^-1 y of each curve, shape (curves,).
        design_features: z' D^-1 F of each curve, shape (curves, features).
        precision: 1 + F' D^-1 F of all curves, shape (features, features).
        feature_pull: F' D^-1 y of all curves, shape (features,).
        expected_variance: Variance of an effect in the fit.
    """

    design_squares: FloatArray
    design_pull: FloatArray
    design_features: FloatArray
    precision: FloatArray
    feature_pull: FloatArray
    expected_variance: float

    @classmethod
    def from_covariance(cls, covariance: CurveCovariance, effect_name: str) -> "_LowRank":
        """The likelihood of one effect from the curves of a few conditions.

        The features of one effect are the largest array of a campaign: those of all effects are
        never in memory together.
        """
        effect_index = EFFECTS.index(effect_name)
        curves = covariance.curves
        inducing_curves = spread_out(curves.conditions, _INDUCING_CONDITIONS)
        posterior = NystromPosterior(
            covariance, np.flatnonzero(np.isin(curves.curve_of_coordinate, inducing_curves))
        )
        curve_count, feature_count = len(curves.conditions), len(posterior.inducing_indices)
        design_squares, design_pull = np.zeros((2, curve_count))
        design_features = np.zeros((curve_count, feature_count))
        precision, feature_pull = np.eye(feature_count), np.zeros(feature_count)
        for curve_index, (coordinate_indices, features, factor) in enumerate(
            posterior.features_by_curve()
        ):
            design = curves.effects[coordinate_indices, effect_index]
            columns = [features, design, curves.departure[coordinate_indices]]
            stacked = scipy.linalg.solve_triangular(factor, np.column_stack(columns), lower=True)
            whitened_features = stacked[:, :-2]
            whitened_design = stacked[:, -2]
            whitened_departure = stacked[:, -1]
            precision += whitened_features.T @ whitened_features
            feature_pull += whitened_features.T @ whitened_departure
            design_squares[curve_index] = whitened_design @ whitened_design
            design_pull[curve_index] = whitened_design @ whitened_departure
            design_features[curve_index] = whitened_design @ whitened_features
        return cls(
            design_squares=design_squares,
            design_pull=design_pull,
            design_features=design_features,
            precision=precision,
            feature_pull=feature_pull,
            expected_variance=float(covariance.sizes.effects[effect_index] ** 2),
        )

    def twice_ln_likelihood_of_steady_runs(self) -> FloatArray:
        """See `EffectLikelihood`."""
        twice_ln_likelihoods = []
        for variance in self.expected_variance * _VARIANCE_RATIOS:
            variance_change, factor, pull = self._features_at(variance)
            solved = scipy.linalg.solve_triangular(factor, pull, lower=True)
            growth = 1 + variance_change * self.design_squares
            log_determinant = np.sum(np.log(growth)) + 2 * np.sum(np.log(np.diag(factor)))
            twice_ln_likelihoods.append(
                np.sum(variance_change * self.design_pull**2 / growth)
                + solved @ solved
                - log_determinant
            )
        return np.array(twice_ln_likelihoods) + _log_prior_density()

    def information(self, variance_index: int) -> Information:
        """See `EffectLikelihood`."""
        variance_change, factor, pull = self._features_at(
            self.expected_variance * _VARIANCE_RATIOS[variance_index]
        )
        growth = 1 + variance_change * self.design_squares
        features = self.design_features / growth[:, np.newaxis]
        # in place, as in `diagonal`
        root = scipy.linalg.solve_triangular(
            factor, features.T, lower=True, overwrite_b=True, check_finite=False
        ).T
        solved = scipy.linalg.solve_triangular(factor, pull, lower=True)
        return Information(
            pull=self.design_pull / growth - root @ solved,
            unshared=self.design_squares / growth,
            root=root,
            sign=-1.0,
        )

    def _features_at(self, variance: float) -> "_FeaturesAtVariance":
        """The features with another variance of the effect."""
        variance_change = variance - self.expected_variance
        weight = variance_change / (1 + variance_change * self.design_squares)
        precision, pull = self.precision.copy(), self.feature_pull.copy()
        for first in range(0, len(weight), _CURVES_AT_ONCE):
            block = slice(first, first + _CURVES_AT_ONCE)
            weighted = self.design_features[block] * weight[block, np.newaxis]
            precision -= self.design_features[block].T @ weighted
            pull -= weighted.T @ self.design_pull[block]
        factor = scipy.linalg.cholesky(precision, lower=True)
        return _FeaturesAtVariance(variance_change, factor, pull)


class _FeaturesAtVariance(NamedTuple):
    """What the features say at one variance of the effect.

    Attributes:
        variance_change: This variance less that of the fit.
        precision_factor: Lower Cholesky factor of the precision of the features.
        pull: F' D^-1 y with this variance, shape (features,).
    """

    variance_change: float
    precision_factor: FloatArray
    pull: FloatArray
