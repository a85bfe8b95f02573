"""The fit with a robust loss beside the plain one, and the curves that pull the plain one away.

The plain sum of squares is the reference. A fit of the same points with a robust loss shows whether
a few curves decide the constants.

Decides: the robust fit, and which curves are odd.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray
from oilfilm.fits.descent import descend
from oilfilm.fits.global_search import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings

# Cauchy loss at this many standard deviations keeps 95 % of the efficiency on normal errors.
_CAUCHY_TUNING = 2.3849
_MOST_ROUNDS = 100
# Relative decrease of the SSE at which the descent of a round ends.
_SSE_TOLERANCE = 1e-8
# Change of mu, over the scale of the loss, at which the rounds end.
_MU_TOLERANCE = 1e-6
# Points with less traction than this share of the largest one of their curve are left out.
_LEAST_TRACTION = 0.2
# Gain that replaces a smaller one, as of a curve without traction or with the opposite sign.
_SMALLEST_GAIN = 1e-9


class RobustFit(NamedTuple):
    """The fit with a robust loss.

    Attributes:
        constants: Free constants in the form of the search (ln|X0| and exponents), shape (free,).
        weight_of_point: Weight of each point by the loss, at most 1, shape (points,).
    """

    constants: FloatArray
    weight_of_point: FloatArray


def fit_robustly(problem: Problem, plain_optimum: Optimum) -> RobustFit | None:
    """The fit with a Cauchy loss; its scale is the median size of the residuals.

        minimise sum of ln(1 + (r/c)^2),  c = 2.3849 * 1.4826 median |r|

    Least squares is repeated until mu does not change. Each round takes the weights of the points
    and the scale from the residuals of the round before.

    Args:
        problem: What was fitted.
        plain_optimum: The optimum of the plain sum of squares.

    Returns:
        The fit; None for an exact fit.

    Reference: P. J. Huber, E. M. Ronchetti, Robust Statistics, 2nd ed. (2009), chapters 4 and 7.
    """
    constants = plain_optimum.constants
    residual = problem.residual(constants)
    for _ in range(_MOST_ROUNDS):
        scale = _CAUCHY_TUNING * MAD_TO_SIGMA * float(np.median(np.abs(residual)))
        if scale == 0 or not np.isfinite(scale):
            return None
        weighted_problem = replace(problem, weight_of_point=_cauchy_weight(residual, scale))
        # of one start: its local optimum, and the SSE there
        local_optima, _ = descend(
            weighted_problem, constants[np.newaxis], tolerance=_SSE_TOLERANCE, use_newton=True
        )
        constants = local_optima[0]
        previous_residual = residual
        residual = problem.residual(constants)
        if np.abs(residual - previous_residual).max() <= _MU_TOLERANCE * scale:
            break
    return RobustFit(constants, _cauchy_weight(residual, scale))


def _cauchy_weight(residual: FloatArray, scale: float) -> FloatArray:
    """Weight of each point by the Cauchy loss: 1/(1 + (r/c)^2), with the scale c."""
    return np.asarray(1 / (1 + (residual / scale) ** 2))


def curve_agreement(
    problem: Problem, robust_fit: RobustFit | None, settings: FitSettings
) -> dict[str, FloatArray | BoolArray]:
    """How well each curve agrees with the robust fit of all curves: perfectly if that fit is exact.

    Points of little traction are left out: near S = 0 every curve agrees with every law.

    Args:
        problem: What was fitted.
        robust_fit: As `fit_robustly` returns it.
        settings: The limits of odd curves.

    Returns:
        Columns of `curve_residuals`: traction of the curve over that of the fit (`gain`), mean
        weight of its points (`robust_weight`, near 1 where it agrees), and whether it is `odd`.
    """
    ones = np.ones(problem.curve_count)
    if robust_fit is None:
        none_odd = np.zeros(problem.curve_count, dtype=bool)
        return {"gain": ones, "robust_weight": ones, "odd": none_odd}
    constants, weight_of_point = robust_fit
    curve_of_point = problem.observations.curve_of_point
    fitted_mu = problem.residual(constants) + problem.mu
    largest_traction = np.maximum.reduceat(fitted_mu, problem.first_point_of_curve)
    is_counted = fitted_mu >= _LEAST_TRACTION * largest_traction[curve_of_point]

    def sums_by_curve(point_values: FloatArray) -> FloatArray:
        """Sum over the points of each curve that count."""
        counted_values = np.where(is_counted, point_values, 0.0)
        return np.bincount(curve_of_point, counted_values, minlength=problem.curve_count).astype(
            np.float64
        )

    point_count = sums_by_curve(np.ones(len(curve_of_point)))
    sum_of_squares = sums_by_curve(fitted_mu**2)
    # a curve without traction agrees with every law
    gain = np.divide(
        sums_by_curve(problem.mu * fitted_mu),
        sum_of_squares,
        out=ones.copy(),
        where=sum_of_squares > 0,
    )
    sum_of_squares = np.where(sum_of_squares > 0, sum_of_squares, 1.0)
    remaining_sse = sums_by_curve((problem.mu - gain[curve_of_point] * fitted_mu) ** 2)
    scatter = np.sqrt(remaining_sse / sum_of_squares) / np.maximum(gain, _SMALLEST_GAIN)
    mean_weight = sums_by_curve(weight_of_point) / point_count
    is_odd = _is_odd(gain, mean_weight, scatter, settings)
    return {"gain": gain, "robust_weight": mean_weight, "odd": is_odd}


def _is_odd(
    gain: FloatArray, mean_weight: FloatArray, scatter: FloatArray, settings: FitSettings
) -> BoolArray:
    """Whether each curve does not belong to the others: odd curves pull the plain fit away.

    The gain or the scatter of such a curve is far from those of the others. It is above the limit,
    and above what a law that fits all curves badly explains. Half the limit is enough where the
    robust fit nearly ignores the curve.

    Args:
        gain: Traction of each curve over that of the fit, shape (curves,).
        mean_weight: Mean weight of its points in the robust fit, shape (curves,).
        scatter: Rms difference of the curve from the fit times the gain, relative, shape (curves,).
        settings: The limits.
    """
    gain_error = np.abs(np.log(np.maximum(gain, _SMALLEST_GAIN)))
    usual_gain_error = float(np.median(gain_error))
    usual_scatter = float(np.median(scatter))
    standard_deviation = MAD_TO_SIGMA * usual_gain_error
    # two tests of the gain: against the median by `odd_gain` and `odd_factor`; against the scatter
    # of all gains by `odd_gain_deviations` and `odd_gain_min`
    is_far = gain_error > max(settings.odd_gain, settings.odd_factor * usual_gain_error)
    is_far |= gain_error > max(
        settings.odd_gain_deviations * standard_deviation, settings.odd_gain_min
    )
    is_wide = scatter > max(settings.odd_scatter, settings.odd_factor * usual_scatter)
    # weights are of absolute residuals, which grow with mu: a weight alone is no reason
    is_half_odd = (gain_error > settings.odd_gain / 2) | (scatter > settings.odd_scatter / 2)
    is_ignored = is_half_odd & (mean_weight < settings.pulling_weight)
    return np.asarray(is_far | is_wide | is_ignored)
