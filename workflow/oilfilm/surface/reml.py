"""Sizes of departure, effects of runs and noise, by restricted maximum likelihood.

Sizes are the standard deviations and lengths of the model. What is not a size (the constants of the
law, the departure) is integrated out. Each size has a weak log-normal prior. The search for the
most likely sizes is over their logarithms.

Reference: H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545.

Decides: the prior of the departure from a law.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import EFFECT_NAMES, ErrorPriors, LogNormal
from oilfilm.surface.kernels import (
    CONDITION_LENGTH_PRIOR,
    INTERACTION_PRIOR,
    MAIN_EFFECT_PRIOR,
    SLIP_LENGTH_PRIOR,
    SLIP_TREND_PRIOR,
    ConditionBox,
    ConditionKernel,
    DepartureSizes,
    matern,
    matern_slope,
    trend_exponent,
)
from oilfilm.surface.reduction import ReducedCurves

# Prior of kappa, which scales the departure from the law. It allows any law, exact or wrong.
MISFIT_KAPPA_PRIOR = LogNormal(median=0.03, ln_sd=2.0, smallest=1e-4, largest=3.0)
# Prior of kappa for intervals. Left-out levels do not show what is between them, so no law is taken
# as exact.
INTERVAL_KAPPA_PRIOR = LogNormal(median=0.25, ln_sd=0.7, smallest=0.12, largest=3.0)
# Largest number of steps of the search.
_ITERATIONS = 300
# The search ends at a step in which the likelihood rises by less than this, relatively.
_RISE_PER_STEP = 1e-8
# Error of the logarithm of a size at which the last part of the search ends.
_LOGARITHM_ERROR = 1e-8
_RIG_GAIN = "rig_gain"
# Added to each variance, in units of the mean variance.
_JITTER = 1e-12


@dataclass(frozen=True)
class Sizes:
    """All sizes of a surface.

    Attributes:
        effects: Standard deviation of each effect of runs, shape (effects,).
        noise: Standard deviation of the noise of points in ln mu.
        departure_sizes: Sizes of the departure from the law.
        rig_gain: Standard deviation of the gain that the runs of a rig share; 0 where rigs are not
            told apart.
    """

    effects: FloatArray
    noise: float
    departure_sizes: DepartureSizes
    rig_gain: float = 0.0

    @classmethod
    def from_logarithms(cls, logarithms: FloatArray) -> "Sizes":
        """The sizes from their logarithms, in the order of `size_names`."""
        values = np.exp(logarithms)
        departure_sizes = DepartureSizes(
            kappa=values[5],
            main=values[6:9],
            interaction=values[9],
            slip_length=values[10],
            lengths=values[11:14],
            slip_trend=values[14],
        )
        rig_gain = float(values[15]) if len(values) > _SIZE_COUNT_WITHOUT_RIGS else 0.0
        return cls(values[:4], values[4], departure_sizes, rig_gain)

    def logarithms(self) -> FloatArray:
        """Logarithms of the sizes, in the order of `size_names`."""
        departure = self.departure_sizes
        rig_sizes = [self.rig_gain] if self.rig_gain else []
        return np.log(
            [
                *self.effects,
                self.noise,
                departure.kappa,
                *departure.main,
                departure.interaction,
                departure.slip_length,
                *departure.lengths,
                departure.slip_trend,
                *rig_sizes,
            ]
        )


def size_names(*, tells_rigs_apart: bool = False) -> tuple[str, ...]:
    """Names of the sizes, in the order in which they are searched.

    Args:
        tells_rigs_apart: Whether rigs are told apart.
    """
    mains = ("main_0", "main_1", "main_2")
    lengths = ("length_0", "length_1", "length_2")
    departure = ("kappa", *mains, "interaction", "slip_length", *lengths, "slip_trend")
    rig_names = (_RIG_GAIN,) if tells_rigs_apart else ()
    return (*EFFECT_NAMES, "noise", *departure, *rig_names)


def priors(
    error_priors: ErrorPriors, kappa_prior: LogNormal, *, tells_rigs_apart: bool = False
) -> tuple[LogNormal, ...]:
    """The prior of each size, in the order of `size_names`.

    Args:
        error_priors: Priors of the sizes of the errors of runs and rigs.
        kappa_prior: Prior of `DepartureSizes.kappa`.
        tells_rigs_apart: Whether rigs are told apart.
    """
    mains = (MAIN_EFFECT_PRIOR,) * 3
    lengths = (CONDITION_LENGTH_PRIOR,) * 3
    departure = (
        kappa_prior,
        *mains,
        INTERACTION_PRIOR,
        SLIP_LENGTH_PRIOR,
        *lengths,
        SLIP_TREND_PRIOR,
    )
    rig_priors = (error_priors.rig_gain,) if tells_rigs_apart else ()
    return (*error_priors.run_and_noise_priors(), *departure, *rig_priors)


_SIZE_COUNT_WITHOUT_RIGS = len(size_names())


@dataclass(frozen=True)
class CurveCovariance:
    """Covariance of the coordinates of all curves.

    Attributes:
        curves: The curves.
        box: The box of the tested conditions.
        sizes: The sizes.
    """

    curves: ReducedCurves
    box: ConditionBox
    sizes: Sizes

    @property
    def kernel(self) -> ConditionKernel:
        """Covariance over conditions."""
        return ConditionKernel(self.box, self.sizes.departure_sizes)

    @cached_property
    def factors(self) -> tuple[FloatArray, FloatArray]:
        """C_E (for all slips) and C_G (times the covariance over slips), as in `kernels`.

        Between the curves, shape (curves, curves) each.
        """
        return self.kernel.factors(self.curves.conditions, self.curves.conditions)

    @cached_property
    def size_at_slips(self) -> FloatArray:
        """w at each of the slips of the curves, shape (slips,)."""
        return self.sizes.departure_sizes.size_at_slips(self.curves.slips)

    @cached_property
    def size_in_coordinates(self) -> FloatArray:
        """Coordinates of w, the size of the departure over slip."""
        return np.asarray(self.curves.slip_weights_of_coordinates @ self.size_at_slips)

    @cached_property
    def slip_distances(self) -> FloatArray:
        """Distances of the scaled slips over the length, shape (slips, slips)."""
        slips = self.curves.slips
        return np.subtract.outer(slips, slips) / self.sizes.departure_sizes.slip_length

    @cached_property
    def slip_covariance(self) -> FloatArray:
        """w M w' between the slips, shape (slips, slips)."""
        size_over_slip = self.size_at_slips
        return matern(self.slip_distances) * np.outer(size_over_slip, size_over_slip)

    def matrix(self) -> FloatArray:
        """The covariance, shape (coordinates, coordinates)."""
        curves = self.curves
        overall_factor, slip_factor = self.factors
        covariance = curves.covariance_from_slips(self.slip_covariance)
        covariance *= curves.expanded_to_coordinates(slip_factor)
        overall_covariance = curves.expanded_to_coordinates(overall_factor)
        overall_covariance *= self.size_in_coordinates[:, np.newaxis]
        overall_covariance *= self.size_in_coordinates
        covariance += overall_covariance
        covariance += curves.law_slopes @ curves.law_slopes.T
        if self.sizes.rig_gain:
            covariance += self.sizes.rig_gain**2 * curves.gain_products_of_rigs
        covariance[curves.coordinate_pairs] += curves.effect_products @ self.sizes.effects**2
        diagonal = np.diag_indices_from(covariance)
        # rounding of large variances, as of a kappa above 1, must not make the matrix indefinite
        covariance[diagonal] += self.sizes.noise**2 + _JITTER * np.mean(covariance[diagonal])
        return covariance

    def gradient_by_size(self, weight: FloatArray) -> FloatArray:
        """Sum of `weight` times the derivative of the covariance by the logarithm of each size.

        The order is that of `size_names`, shape (sizes,).

        Args:
            weight: Symmetric, shape (coordinates, coordinates).
        """
        curves, size_over_slip = self.curves, self.size_at_slips
        overall_factor, slip_factor = self.factors
        slopes_by_size_name = {"noise": 2 * self.sizes.noise**2 * np.trace(weight)}
        effect_slopes = (
            2 * self.sizes.effects**2 * (weight[curves.coordinate_pairs] @ curves.effect_products)
        )
        slopes_by_size_name.update(zip(EFFECT_NAMES, effect_slopes, strict=True))

        # summed over the coordinates of a curve on one side of the matrix
        weight_by_curve = curves.summed_by_curve(weight * self.size_in_coordinates[:, np.newaxis]).T
        overall_weight = curves.summed_by_curve(
            self.size_in_coordinates[:, np.newaxis] * weight_by_curve
        )
        slip_weight = curves.summed_by_curve(
            curves.summed_by_curve(weight * curves.covariance_from_slips(self.slip_covariance)).T
        )
        for name, (overall_slope, slip_slope) in self.kernel.slopes(curves.conditions).items():
            slopes_by_size_name[name] = np.vdot(overall_weight, overall_slope) + np.vdot(
                slip_weight, slip_slope
            )

        slip_sums = curves.summed_onto_slips(weight * curves.expanded_to_coordinates(slip_factor))
        by_length = matern_slope(self.slip_distances) * np.outer(size_over_slip, size_over_slip)
        slopes_by_size_name["slip_length"] = np.vdot(slip_sums, by_length)
        exponent = trend_exponent(curves.slips)
        by_trend = self.slip_covariance * np.add.outer(exponent, exponent)
        size_by_trend = np.asarray(curves.slip_weights_of_coordinates @ (exponent * size_over_slip))
        trend_weight = curves.summed_by_curve(size_by_trend[:, np.newaxis] * weight_by_curve)
        overall_slope_by_trend = np.vdot(trend_weight, overall_factor)
        slopes_by_size_name["slip_trend"] = (
            np.vdot(slip_sums, by_trend) + 2 * overall_slope_by_trend
        )
        names = size_names(tells_rigs_apart=bool(self.sizes.rig_gain))
        if self.sizes.rig_gain:
            gain_sum = np.vdot(weight, curves.gain_products_of_rigs)
            slopes_by_size_name[_RIG_GAIN] = 2 * self.sizes.rig_gain**2 * gain_sum
        return np.array([slopes_by_size_name[name] for name in names])


def objective(
    logarithms: FloatArray,
    curves: ReducedCurves,
    box: ConditionBox,
    size_priors: tuple[LogNormal, ...],
) -> tuple[float, FloatArray]:
    """Negative logarithm of the restricted likelihood and the priors, and its gradient.

    Args:
        logarithms: Logarithms of the sizes, in the order of `size_names`.
        curves: The curves.
        box: The box of the tested conditions.
        size_priors: The priors of the sizes.
    """
    covariance = CurveCovariance(curves, box, Sizes.from_logarithms(logarithms))
    half_log_determinant, inverse = _half_log_determinant_and_inverse(covariance.matrix())
    weights = inverse @ curves.departure
    value = float(0.5 * curves.departure @ weights) + half_log_determinant
    inverse -= np.outer(weights, weights)
    gradient = covariance.gradient_by_size(inverse) / 2

    return with_remainder_and_priors(value, gradient, logarithms, curves, size_priors)


def with_remainder_and_priors(
    value: float,
    gradient: FloatArray,
    logarithms: FloatArray,
    curves: ReducedCurves,
    size_priors: tuple[LogNormal, ...],
) -> tuple[float, FloatArray]:
    """An objective of the coordinates, and its gradient, with the remainder and the priors added.

    Args:
        value: Negative logarithm of the restricted likelihood of the coordinates.
        gradient: Its gradient; it is changed.
        logarithms: Logarithms of the sizes, which begin in the order of `size_names`.
        curves: The curves, with the remainder beside the coordinates.
        size_priors: The priors of the sizes.
    """
    noise_index = size_names().index("noise")
    scaled_squares = np.sum(curves.remainder**2) / np.exp(2 * logarithms[noise_index])
    value += curves.residual_freedom * logarithms[noise_index] + scaled_squares / 2
    gradient[noise_index] += curves.residual_freedom - scaled_squares

    medians = np.log([prior.median for prior in size_priors])
    prior_sds = np.array([prior.ln_sd for prior in size_priors])
    scores = (logarithms - medians) / prior_sds
    return value + np.sum(scores**2) / 2, gradient + scores / prior_sds


@dataclass(frozen=True)
class FoundSizes:
    """Where the search for the most likely sizes ended.

    Attributes:
        logarithms: Logarithms of the sizes, in the order of `size_names`.
        converged: Whether the search reached a maximum of the likelihood. If not, the sizes are
            those of its last step.
    """

    logarithms: FloatArray
    converged: bool

    @property
    def sizes(self) -> Sizes:
        """The sizes."""
        return Sizes.from_logarithms(self.logarithms)


def most_likely_sizes(
    curves: ReducedCurves,
    box: ConditionBox,
    size_priors: tuple[LogNormal, ...],
    start: FloatArray | None = None,
) -> FoundSizes:
    """The most likely sizes.

    Args:
        curves: The curves.
        box: The box of the tested conditions.
        size_priors: The priors of the sizes.
        start: Logarithms at which the search starts; the medians if it is not given.
    """
    return most_likely_logarithms(
        lambda logarithms: objective(logarithms, curves, box, size_priors), size_priors, start
    )


def most_likely_logarithms(
    objective_of: Callable[[FloatArray], tuple[float, FloatArray]],
    size_priors: tuple[LogNormal, ...],
    start: FloatArray | None = None,
) -> FoundSizes:
    """The logarithms of sizes at which a likelihood is largest.

    Args:
        objective_of: Negative logarithm of the likelihood and the priors, and its gradient.
        size_priors: The priors of the sizes.
        start: Logarithms at which the search starts; the medians if it is not given.
    """
    lower = np.log([prior.smallest for prior in size_priors])
    upper = np.log([prior.largest for prior in size_priors])
    if start is None:
        start = np.log([prior.median for prior in size_priors])
    result = scipy.optimize.minimize(
        objective_of,
        np.clip(start, lower, upper),
        jac=True,
        method="L-BFGS-B",
        bounds=scipy.optimize.Bounds(lower, upper),
        options={"maxiter": _ITERATIONS, "ftol": _RISE_PER_STEP},
    )
    logarithms = np.asarray(result.x)
    if result.success:
        logarithms = _where_slopes_vanish(objective_of, logarithms, lower, upper)
    return FoundSizes(logarithms, bool(result.success))


def _where_slopes_vanish(
    objective_of: Callable[[FloatArray], tuple[float, FloatArray]],
    logarithms: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> FloatArray:
    """The maximum near the end of a search: where the slopes are 0.

    A search ends where rounding hides the rise of the likelihood, whose logarithm is about 10^4.
    Where it ends then depends on the kernels of the machine. The slopes are known to more digits.

    Args:
        objective_of: As in `most_likely_logarithms`.
        logarithms: Where the search ended; sizes at a bound stay there.
        lower: Lower bounds.
        upper: Upper bounds.

    Returns:
        Logarithms of the sizes at the maximum, or those given if no smaller slopes were found.
    """
    is_free = (logarithms > lower) & (logarithms < upper)

    def with_free(free_logarithms: FloatArray) -> FloatArray:
        """All logarithms, with these values where they are free."""
        changed = logarithms.copy()
        changed[is_free] = np.clip(free_logarithms, lower[is_free], upper[is_free])
        return changed

    def free_slopes(free_logarithms: FloatArray) -> FloatArray:
        """Slopes of the objective by the free logarithms."""
        _, slopes = objective_of(with_free(free_logarithms))
        return slopes[is_free]

    root = scipy.optimize.root(
        free_slopes, logarithms[is_free], method="hybr", options={"xtol": _LOGARITHM_ERROR}
    )
    largest_before = np.abs(free_slopes(logarithms[is_free])).max(initial=0)
    largest_slope = np.abs(root.fun).max(initial=0)
    return with_free(root.x) if largest_slope < largest_before else logarithms


def _half_log_determinant_and_inverse(matrix: FloatArray) -> tuple[float, FloatArray]:
    """Half the logarithm of the determinant of a symmetric matrix, and its inverse.

    Args:
        matrix: It is overwritten. Its transpose is in the order of LAPACK, which needs no copy.
    """
    factor = scipy.linalg.cholesky(matrix.T, lower=True, overwrite_a=True, check_finite=False)
    half_log_determinant = float(np.sum(np.log(np.diag(factor))))
    # LAPACK fills the lower triangle only
    lower, _ = scipy.linalg.lapack.dpotri(factor, lower=1, overwrite_c=1)
    inverse = np.add(lower, lower.T, order="C")
    inverse[np.diag_indices_from(inverse)] /= 2
    return half_log_determinant, inverse
