"""Likelihood of changes in the effects of runs, given the points.

Each run has one effect of each kind, as its gain. The effects u of one kind enter the points y by a
design Z. Each effect has the variance v. Its mean is beta p: a size beta times a pattern p over the
runs, as a step or a trend. Twice the logarithm of the likelihood is then

    L(v) + 2 beta p' q - beta^2 p' W p,   W = Z' P Z,   q = Z' P y,

where P is the inverse covariance of the points with the variance v, and L(v) is the value without a
change. The points of a curve are few weighted sums of its measured points, which are called its
coordinates (`reduction`). The most likely beta is p'q / p'Wp; there, twice the logarithm of the
likelihood ratio is (p'q)^2 / p'Wp. L, q and W at any variance v follow from the eigenvalues of W at
v = 0, or for many curves from features of a few conditions (Nystrom).

Reference: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
Eq. A.9 and A.10 (inverse and determinant of a sum).

Decides: which variances of an effect are tried.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import EFFECT_NAMES
from oilfilm.surface.posterior import NystromPosterior, farthest_point_selection
from oilfilm.surface.reml import CurveCovariance
from oilfilm.surface.surface import LARGEST_EXACT_CURVE_COUNT

# Number of representative conditions of a large campaign (inducing points).
_INDUCING_CONDITIONS = 40
# Variances that are tried, over the variance that was fitted.
_VARIANCE_RATIOS = np.geomspace(1e-3, 1e3, 31)
# Index of the fitted variance among them.
FIT_VARIANCE_INDEX = 15
# Prior standard deviation of the logarithm of the standard deviation of an effect.
_PRIOR_LN_SD = 0.6
# Curves whose features are weighted at once.
_CURVES_AT_ONCE = 4096


@dataclass(frozen=True)
class EffectInformation:
    """What the points say of the effects of one kind, at one variance: q and W.

    W = diag(uncoupled_diagonal) + coupling_sign coupling_root coupling_root'.

    Attributes:
        vector: q, the information vector, shape (curves,).
        uncoupled_diagonal: Diagonal of the part of W that does not couple the runs, shape
            (curves,).
        coupling_root: Root of the part of W that couples the runs, shape (curves, any number of
            columns).
        coupling_sign: Sign of this part, 1 or -1.
    """

    vector: FloatArray
    uncoupled_diagonal: FloatArray
    coupling_root: FloatArray
    coupling_sign: float

    def bilinear_forms(self, patterns: FloatArray, other_patterns: FloatArray) -> FloatArray:
        """p' W r of each pair of a pattern p and another pattern r, shape (patterns,).

        Args:
            patterns: One pattern p per column, shape (curves, patterns).
            other_patterns: One pattern r per column, shape (curves, patterns).
        """
        root = self.coupling_root
        coupled_part = np.sum((root.T @ patterns) * (root.T @ other_patterns), axis=0)
        uncoupled_part = self.uncoupled_diagonal @ (patterns * other_patterns)
        return uncoupled_part + self.coupling_sign * coupled_part

    def matrix_times(self, columns: FloatArray) -> FloatArray:
        """W times columns, shape (curves, ...)."""
        uncoupled_part = (self.uncoupled_diagonal * columns.T).T
        coupled_part = self.coupling_root @ (self.coupling_root.T @ columns)
        return np.asarray(uncoupled_part + self.coupling_sign * coupled_part)

    def diagonal(self) -> FloatArray:
        """Diagonal of W, shape (curves,)."""
        # without an array of squares: in large campaigns the root is the largest array
        squares_of_rows = np.einsum("ij,ij->i", self.coupling_root, self.coupling_root)
        return self.uncoupled_diagonal + self.coupling_sign * squares_of_rows


class EffectLikelihood(Protocol):
    """Likelihood of the effects of one kind."""

    def twice_ln_steady_likelihoods(self) -> FloatArray:
        """Twice the logarithm of the likelihood without a change at each variance.

        It is known up to a constant, and includes the prior of the variance. Shape (variances,).
        """
        ...

    def information(self, variance_index: int) -> EffectInformation:
        """What the points say of the effects at one of the variances."""
        ...


def effect_likelihood(covariance: CurveCovariance, effect_name: str) -> EffectLikelihood:
    """The likelihood of one effect.

    Args:
        covariance: Covariance of the curves (`Surface.misfit_covariance`).
        effect_name: One of `oilfilm.surface.effects.EFFECT_NAMES`.
    """
    if len(covariance.curves.conditions) > LARGEST_EXACT_CURVE_COUNT:
        return _LowRankLikelihood.from_covariance(covariance, effect_name)
    return _DenseLikelihood.from_covariance(covariance, effect_name)


def _twice_ln_prior_density() -> FloatArray:
    """Twice the logarithm of the prior density of each variance, shape (variances,)."""
    return -((np.log(_VARIANCE_RATIOS) / 2 / _PRIOR_LN_SD) ** 2)


@dataclass(frozen=True)
class _DenseLikelihood:
    """The exact likelihood from eigenvalues, for at most `LARGEST_EXACT_CURVE_COUNT` curves.

    Attributes:
        eigenvalues: Eigenvalues of W at the variance 0, shape (curves,).
        eigenvectors: Its eigenvectors, one per column, shape (curves, curves).
        vector_along_eigenvectors: q along the eigenvectors, shape (curves,).
        fitted_variance: Variance of the effects in the fit.
    """

    eigenvalues: FloatArray
    eigenvectors: FloatArray
    vector_along_eigenvectors: FloatArray
    fitted_variance: float

    @classmethod
    def from_covariance(cls, covariance: CurveCovariance, effect_name: str) -> "_DenseLikelihood":
        """The likelihood of one effect."""
        effect_index = EFFECT_NAMES.index(effect_name)
        effect_sds = covariance.sizes.effects.copy()
        fitted_variance = float(effect_sds[effect_index] ** 2)
        effect_sds[effect_index] = 0.0
        without_effect = replace(covariance, sizes=replace(covariance.sizes, effects=effect_sds))
        curves = covariance.curves
        design = curves.membership.multiply(
            curves.effect_design[:, effect_index, np.newaxis]
        ).toarray()
        factor = scipy.linalg.cholesky(without_effect.matrix(), lower=True)
        whitened_design = scipy.linalg.solve_triangular(factor, design, lower=True)
        whitened_departure = scipy.linalg.solve_triangular(factor, curves.departure, lower=True)
        eigenvalues, eigenvectors = scipy.linalg.eigh(whitened_design.T @ whitened_design)
        vector = eigenvectors.T @ (whitened_design.T @ whitened_departure)
        return cls(np.maximum(eigenvalues, 0.0), eigenvectors, vector, fitted_variance)

    def twice_ln_steady_likelihoods(self) -> FloatArray:
        """See `EffectLikelihood`."""
        variances = self.fitted_variance * _VARIANCE_RATIOS
        shrinkage = 1 / (1 + np.outer(variances, self.eigenvalues))
        explained_squares = variances[:, np.newaxis] * shrinkage * self.vector_along_eigenvectors**2
        return np.sum(explained_squares + np.log(shrinkage), axis=1) + _twice_ln_prior_density()

    def information(self, variance_index: int) -> EffectInformation:
        """See `EffectLikelihood`."""
        shrinkage = 1 / (
            1 + self.fitted_variance * _VARIANCE_RATIOS[variance_index] * self.eigenvalues
        )
        return EffectInformation(
            vector=self.eigenvectors @ (shrinkage * self.vector_along_eigenvectors),
            uncoupled_diagonal=np.zeros(len(self.eigenvalues)),
            coupling_root=self.eigenvectors * np.sqrt(shrinkage * self.eigenvalues),
            coupling_sign=1.0,
        )


@dataclass(frozen=True)
class _LowRankLikelihood:
    """The likelihood from features of a few conditions, for many curves.

    The covariance of a curve is D + F F', with D for what only its points share. All attributes are
    for the fitted variance; another variance changes D by a matrix of rank one per curve.

    Attributes:
        design_squares: z' D^-1 z of each curve, with its column z of the design, shape (curves,).
        design_departure: z' D^-1 y of each curve, shape (curves,).
        design_features: z' D^-1 F of each curve, shape (curves, features).
        precision: 1 + F' D^-1 F of all curves, shape (features, features).
        feature_departure: F' D^-1 y of all curves, shape (features,).
        fitted_variance: Variance of the effects in the fit.
    """

    design_squares: FloatArray
    design_departure: FloatArray
    design_features: FloatArray
    precision: FloatArray
    feature_departure: FloatArray
    fitted_variance: float

    @classmethod
    def from_covariance(cls, covariance: CurveCovariance, effect_name: str) -> "_LowRankLikelihood":
        """The likelihood of one effect from the curves of a few conditions.

        The features of one effect are the largest array of a campaign: those of all effects are
        never in memory together.
        """
        effect_index = EFFECT_NAMES.index(effect_name)
        curves = covariance.curves
        inducing_curves = farthest_point_selection(curves.conditions, _INDUCING_CONDITIONS)
        posterior = NystromPosterior(
            covariance, np.flatnonzero(np.isin(curves.curve_of_coordinate, inducing_curves))
        )
        curve_count, feature_count = len(curves.conditions), len(posterior.inducing_indices)
        design_squares, design_departure = np.zeros((2, curve_count))
        design_features = np.zeros((curve_count, feature_count))
        precision, feature_departure = np.eye(feature_count), np.zeros(feature_count)
        for curve_index, (coordinate_indices, features, factor) in enumerate(
            posterior.features_by_curve()
        ):
            design = curves.effect_design[coordinate_indices, effect_index]
            columns = [features, design, curves.departure[coordinate_indices]]
            stacked = scipy.linalg.solve_triangular(factor, np.column_stack(columns), lower=True)
            whitened_features = stacked[:, :-2]
            whitened_design = stacked[:, -2]
            whitened_departure = stacked[:, -1]
            precision += whitened_features.T @ whitened_features
            feature_departure += whitened_features.T @ whitened_departure
            design_squares[curve_index] = whitened_design @ whitened_design
            design_departure[curve_index] = whitened_design @ whitened_departure
            design_features[curve_index] = whitened_design @ whitened_features
        return cls(
            design_squares=design_squares,
            design_departure=design_departure,
            design_features=design_features,
            precision=precision,
            feature_departure=feature_departure,
            fitted_variance=float(covariance.sizes.effects[effect_index] ** 2),
        )

    def twice_ln_steady_likelihoods(self) -> FloatArray:
        """See `EffectLikelihood`."""
        twice_ln_likelihoods = []
        for variance in self.fitted_variance * _VARIANCE_RATIOS:
            variance_change, factor, feature_departure = self._features_at_variance(variance)
            whitened = scipy.linalg.solve_triangular(factor, feature_departure, lower=True)
            # factor by which the determinant of D grows, per curve
            growth = 1 + variance_change * self.design_squares
            ln_determinant = np.sum(np.log(growth)) + 2 * np.sum(np.log(np.diag(factor)))
            twice_ln_likelihoods.append(
                np.sum(variance_change * self.design_departure**2 / growth)
                + whitened @ whitened
                - ln_determinant
            )
        return np.array(twice_ln_likelihoods) + _twice_ln_prior_density()

    def information(self, variance_index: int) -> EffectInformation:
        """See `EffectLikelihood`."""
        variance_change, factor, feature_departure = self._features_at_variance(
            self.fitted_variance * _VARIANCE_RATIOS[variance_index]
        )
        growth = 1 + variance_change * self.design_squares
        features = self.design_features / growth[:, np.newaxis]
        # in place: in large campaigns the root is the largest array
        root = scipy.linalg.solve_triangular(
            factor, features.T, lower=True, overwrite_b=True, check_finite=False
        ).T
        whitened = scipy.linalg.solve_triangular(factor, feature_departure, lower=True)
        return EffectInformation(
            vector=self.design_departure / growth - root @ whitened,
            uncoupled_diagonal=self.design_squares / growth,
            coupling_root=root,
            coupling_sign=-1.0,
        )

    def _features_at_variance(self, variance: float) -> "_FeaturesAtVariance":
        """The features with another variance of the effect."""
        variance_change = variance - self.fitted_variance
        weight_of_curve = variance_change / (1 + variance_change * self.design_squares)
        precision, feature_departure = self.precision.copy(), self.feature_departure.copy()
        for first_curve in range(0, len(weight_of_curve), _CURVES_AT_ONCE):
            block = slice(first_curve, first_curve + _CURVES_AT_ONCE)
            weighted_features = self.design_features[block] * weight_of_curve[block, np.newaxis]
            precision -= self.design_features[block].T @ weighted_features
            feature_departure -= weighted_features.T @ self.design_departure[block]
        factor = scipy.linalg.cholesky(precision, lower=True)
        return _FeaturesAtVariance(variance_change, factor, feature_departure)


class _FeaturesAtVariance(NamedTuple):
    """What the features say at one variance of the effect.

    Attributes:
        variance_change: This variance less the fitted one.
        precision_factor: Lower Cholesky factor of the precision with this variance.
        feature_departure: F' D^-1 y with this variance, shape (features,).
    """

    variance_change: float
    precision_factor: FloatArray
    feature_departure: FloatArray
