"""Covariance of the runs of two oils, and its most likely sizes.

Each point of the oils i = 1, 2 has

    ln mu_i = law + c -+ r/2 + effects of its run + noise,   r = ln(mu_2 / mu_1)

c is the departure of both oils from one law. The covariance of law and departure is called smooth,
that of effects and noise is not. r has a constant part that is almost free, a
difference of the constants of the law, and a departure of its own. c and r are independent, so that
at conditions and slips at which both oils were tested r depends on the difference of their ln mu
only: c cancels.

Decides: the prior of the ratio of two oils.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.effects import ErrorPriors, LogNormal
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.posterior import smooth_covariance
from oilfilm.surface.reduction import Coordinates, ReducedCurves, SlipWeights
from oilfilm.surface.reml import (
    INTERVAL_KAPPA_PRIOR,
    CurveCovariance,
    FoundSizes,
    Sizes,
    most_likely_logarithms,
    priors,
    with_remainder_and_priors,
)

# Prior standard deviation of the constant part of r: a factor of e either way.
_RATIO_CONSTANT_SD = 1.0
# Prior of kappa of r, the size of its departure. The smallest one is for oils that differ by a
# factor alone.
RATIO_KAPPA_PRIOR = LogNormal(median=0.05, ln_sd=1.0, smallest=0.005, largest=1.0)
# Prior of the difference of the constants of the law, over their standard deviation in a surface.
LAW_DIFFERENCE_PRIOR = LogNormal(median=0.1, ln_sd=0.7, smallest=0.03, largest=3.0)
# Factor on the most likely kappa of r in intervals: oils differ more between the tested conditions
# than at them.
_CAUTION_FACTOR = 3.0
_ERROR_SIZE_COUNT = len(ErrorPriors().run_and_noise_priors())


@dataclass(frozen=True)
class PairSizes:
    """All sizes of the description of two oils.

    Attributes:
        common_sizes: Sizes of the effects of runs, of the noise and of c, the common departure.
        ratio_sizes: Sizes of r, the ratio, with the same effects and noise.
        law_difference_sd: Standard deviation of the difference of the constants of the law, over
            that of a constant in a surface.
    """

    common_sizes: Sizes
    ratio_sizes: Sizes
    law_difference_sd: float

    @classmethod
    def from_logarithms(cls, logarithms: FloatArray) -> "PairSizes":
        """The sizes from their logarithms.

        Args:
            logarithms: Those of `common_sizes` in the order of `size_names`, then those of
                `ratio_sizes` without effects and noise, then that of `law_difference_sd`.
        """
        end_of_common = (len(logarithms) - 1 + _ERROR_SIZE_COUNT) // 2
        ratio_logarithms = np.concatenate(
            [logarithms[:_ERROR_SIZE_COUNT], logarithms[end_of_common:-1]]
        )
        return cls(
            common_sizes=Sizes.from_logarithms(logarithms[:end_of_common]),
            ratio_sizes=Sizes.from_logarithms(ratio_logarithms),
            law_difference_sd=float(np.exp(logarithms[-1])),
        )

    def with_caution(self) -> "PairSizes":
        """The sizes for intervals, from the most likely ones."""
        departure = self.ratio_sizes.departure_sizes
        cautious = replace(departure, kappa=_CAUTION_FACTOR * departure.kappa)
        return replace(self, ratio_sizes=replace(self.ratio_sizes, departure_sizes=cautious))


def pair_priors(error_priors: ErrorPriors) -> tuple[LogNormal, ...]:
    """The prior of each size, in the order of `PairSizes.from_logarithms`."""
    ratio_priors = priors(error_priors, RATIO_KAPPA_PRIOR)[_ERROR_SIZE_COUNT:]
    return (*priors(error_priors, INTERVAL_KAPPA_PRIOR), *ratio_priors, LAW_DIFFERENCE_PRIOR)


@dataclass(frozen=True)
class PairCovariance:
    """Covariance of the coordinates of the curves of both oils.

    Attributes:
        common_covariance: Covariance of what does not depend on the oil: law, c, effects of runs
            and noise.
        ratio_covariance: Covariance of r at the same coordinates. Its effects and noise are not
            used.
        half_sign: -1/2 for the first oil and 1/2 for the second, shape (coordinates,).
        law_difference_sd: See `PairSizes`.
    """

    common_covariance: CurveCovariance
    ratio_covariance: CurveCovariance
    half_sign: FloatArray
    law_difference_sd: float

    @classmethod
    def from_curves(
        cls, curves: ReducedCurves, box: ConditionBox, oil_of_curve: IndexArray, sizes: PairSizes
    ) -> "PairCovariance":
        """The covariance of curves.

        Args:
            curves: The curves of both oils.
            box: The box of the tested conditions.
            oil_of_curve: 0 for curves of the first oil, 1 for those of the second, shape (curves,).
            sizes: The sizes.
        """
        slopes = _slopes_of_ratio(
            curves.slip_weights_of_coordinates, curves.law_slopes, sizes.law_difference_sd
        )
        # Count fewer levels as three: the ratio then gets a departure of its own along a condition
        # of one or two levels. The bends that the law has between two levels are among its slopes.
        ratio_box = replace(box, level_counts=np.maximum(box.level_counts, 3))
        return cls(
            common_covariance=CurveCovariance(curves, box, sizes.common_sizes),
            ratio_covariance=CurveCovariance(
                replace(curves, law_slopes=slopes), ratio_box, sizes.ratio_sizes
            ),
            half_sign=oil_of_curve[curves.curve_of_coordinate].astype(float) - 0.5,
            law_difference_sd=sizes.law_difference_sd,
        )

    @cached_property
    def all_coordinates(self) -> Coordinates:
        """All measured coordinates, as values of ln mu."""
        return self.common_covariance.curves.select_coordinates(np.arange(len(self.half_sign)))

    def matrix(self) -> FloatArray:
        """The covariance, shape (coordinates, coordinates)."""
        return self.common_covariance.matrix() + self.half_sign[
            :, np.newaxis
        ] * self.ratio_covariance_at(self.all_coordinates)

    def ratio_covariance_at(self, targets: Coordinates) -> FloatArray:
        """Covariance of r at the targets with the coordinates, shape (targets, coordinates)."""
        cross_covariance = smooth_covariance(
            self.ratio_covariance,
            self.with_ratio_slopes(targets),
            self.with_ratio_slopes(self.all_coordinates),
        )
        return cross_covariance * self.half_sign

    def oil_covariance_at(self, targets: Coordinates, oil_index: int) -> FloatArray:
        """Covariance of ln mu of an oil with the coordinates, shape (targets, coordinates).

        Args:
            targets: Where ln mu is wanted.
            oil_index: 0 for the first oil, 1 for the second.
        """
        covariance_of_common = smooth_covariance(
            self.common_covariance, targets, self.all_coordinates
        )
        return covariance_of_common + (oil_index - 0.5) * self.ratio_covariance_at(targets)

    def with_ratio_slopes(self, targets: Coordinates) -> Coordinates:
        """The same targets, with the law slopes of r."""
        slopes = _slopes_of_ratio(targets.weights, targets.law_slopes, self.law_difference_sd)
        return replace(targets, law_slopes=slopes)

    def gradient_by_size(self, weight: FloatArray) -> FloatArray:
        """Sum of `weight` times the derivative of the covariance by the logarithm of each size.

        The order is that of `PairSizes.from_logarithms`.

        Args:
            weight: Symmetric, shape (coordinates, coordinates).
        """
        weight_of_ratio = weight * np.outer(self.half_sign, self.half_sign)
        ratio_gradient = self.ratio_covariance.gradient_by_size(weight_of_ratio)
        law_slopes = self.law_difference_sd * self.common_covariance.curves.law_slopes
        law_difference_gradient = 2 * np.sum(law_slopes * (weight_of_ratio @ law_slopes))
        common_gradient = self.common_covariance.gradient_by_size(weight)
        return np.concatenate(
            [common_gradient, ratio_gradient[_ERROR_SIZE_COUNT:], [law_difference_gradient]]
        )


def pair_objective(
    logarithms: FloatArray,
    covariance_of: Callable[[PairSizes], PairCovariance],
    size_priors: tuple[LogNormal, ...],
) -> tuple[float, FloatArray]:
    """Negative logarithm of the restricted likelihood and the priors, and its gradient.

    Args:
        logarithms: Logarithms of the sizes, in the order of `PairSizes.from_logarithms`.
        covariance_of: Makes the covariance with some sizes.
        size_priors: The priors of the sizes.
    """
    covariance = covariance_of(PairSizes.from_logarithms(logarithms))
    curves = covariance.common_covariance.curves
    factor = scipy.linalg.cholesky(covariance.matrix(), lower=True)
    inverse = scipy.linalg.cho_solve((factor, True), np.eye(len(factor)))
    weights = inverse @ curves.departure
    value = 0.5 * curves.departure @ weights + np.sum(np.log(np.diag(factor)))
    gradient = covariance.gradient_by_size(inverse - np.outer(weights, weights)) / 2
    return with_remainder_and_priors(value, gradient, logarithms, curves, size_priors)


def most_likely_pair_sizes(
    covariance_of: Callable[[PairSizes], PairCovariance], size_priors: tuple[LogNormal, ...]
) -> FoundSizes:
    """The most likely sizes of a pair, as logarithms in the order of `PairSizes`.

    Args:
        covariance_of: Makes the covariance with some sizes.
        size_priors: The priors of the sizes.
    """
    return most_likely_logarithms(
        lambda logarithms: pair_objective(logarithms, covariance_of, size_priors), size_priors
    )


def _slopes_of_ratio(
    weights: SlipWeights, law_slopes: FloatArray, law_difference_sd: float
) -> FloatArray:
    """Slopes of r by its constant part and by what is free in the law, shape (rows, slopes).

    Args:
        weights: Weight of each slip in each row, shape (rows, slips).
        law_slopes: Slopes of the law at the rows, shape (rows, slopes).
        law_difference_sd: See `PairSizes`.
    """
    constant_slopes = weights @ np.full(weights.shape[1], _RATIO_CONSTANT_SD)
    return np.column_stack([constant_slopes, law_difference_sd * law_slopes])
