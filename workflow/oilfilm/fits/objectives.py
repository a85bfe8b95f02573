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
from oilfilm.fits.engine import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings

# Cauchy loss at this many standard deviations keeps 95 % of the efficiency on normal errors.
_CAUCHY_TUNING = 2.3849
_MOST_ROUNDS = 100
# Relative decrease of the SSE at which the descent of a round ends.
_SSE_TOLERANCE = 1e-8
# Largest change of mu in the last round, over the scale of the loss.
_MU_TOLERANCE = 1e-6
# Points with less traction than this share of their curve's largest do not count: they say little.
_LEAST_TRACTION = 0.2
# A gain is not smaller than this, so that its logarithm exists.
_SMALLEST_GAIN = 1e-9


class RobustFit(NamedTuple):
    """The fit with a robust loss.

    Attributes:
        values: Free internal constants, shape (free,).
        weight: Weight of each point, at most 1, shape (points,).
    """

    values: FloatArray
    weight: FloatArray


def robust_fit(problem: Problem, plain: Optimum) -> RobustFit | None:
    """The fit with a Cauchy loss; its scale is the median size of the residuals.

        minimise sum of ln(1 + (r/c)^2),  c = 2.3849 * 1.4826 median |r|

    Least squares is repeated until mu does not change. Each round takes the weights of the points
    and the scale from the residuals of the round before.

    Args:
        problem: What was fitted.
        plain: The optimum of the plain sum of squares.

    Returns:
        The fit; None for an exact fit.

    Reference: P. J. Huber, E. M. Ronchetti, Robust Statistics, 2nd ed. (2009), chapters 4 and 7.
    """
    values = plain.values
    residual = problem.residual(values)
    for _ in range(_MOST_ROUNDS):
        scale = _CAUCHY_TUNING * MAD_TO_SIGMA * float(np.median(np.abs(residual)))
        if scale == 0 or not np.isfinite(scale):
            return None
        weighted = replace(problem, weight=_cauchy_weight(residual, scale))
        ends, _ = descend(
            weighted, values[np.newaxis], tolerance=_SSE_TOLERANCE, starts_near_ends=True
        )
        values = ends[0]
        previous_residual = residual
        residual = problem.residual(values)
        if np.abs(residual - previous_residual).max() <= _MU_TOLERANCE * scale:
            break
    return RobustFit(values, _cauchy_weight(residual, scale))


def _cauchy_weight(residual: FloatArray, scale: float) -> FloatArray:
    """Weight of each point by the Cauchy loss: 1/(1 + (r/c)^2), with the scale c."""
    return np.asarray(1 / (1 + (residual / scale) ** 2))


def curve_agreement(
    problem: Problem, robust: RobustFit | None, settings: FitSettings
) -> dict[str, FloatArray | BoolArray]:
    """How each curve agrees with the robust fit of all curves; perfectly where that fit is exact.

    Points of little traction are left out: near S = 0 every curve agrees with every law.

    Args:
        problem: What was fitted.
        robust: As `robust_fit` returns it.
        settings: The limits of odd curves.

    Returns:
        Columns of `curve_residuals`: its traction over the fit's (`gain`), the mean weight of its
        points (`robust_weight`, near 1 where it agrees), and whether it is `odd`.
    """
    ones = np.ones(problem.curves)
    if robust is None:
        none_odd = np.zeros(problem.curves, dtype=bool)
        return {"gain": ones, "robust_weight": ones, "odd": none_odd}
    values, weight = robust
    curve = problem.observations.curve
    fitted = problem.residual(values) + problem.mu
    largest_traction = np.maximum.reduceat(fitted, problem.starts)
    is_counted = fitted >= _LEAST_TRACTION * largest_traction[curve]

    def total(point_values: FloatArray) -> FloatArray:
        """Sum over the points of each curve that count."""
        counted_values = np.where(is_counted, point_values, 0.0)
        return np.bincount(curve, counted_values, minlength=problem.curves).astype(np.float64)

    point_count = total(np.ones(len(curve)))
    power = total(fitted**2)
    # a curve without traction agrees with every law
    gain = np.divide(total(problem.mu * fitted), power, out=ones.copy(), where=power > 0)
    power = np.where(power > 0, power, 1.0)
    remaining_sse = total((problem.mu - gain[curve] * fitted) ** 2)
    scatter = np.sqrt(remaining_sse / power) / gain
    mean_weight = total(weight) / point_count
    odd = _odd(gain, mean_weight, scatter, settings)
    return {"gain": gain, "robust_weight": mean_weight, "odd": odd}


def _odd(
    gain: FloatArray, weight: FloatArray, scatter: FloatArray, settings: FitSettings
) -> BoolArray:
    """Curves that do not belong to the others: they pull the plain fit away.

    The gain or the scatter of such a curve is far from those of the others. It is above the limit,
    and above what a law that fits all curves badly explains. Half the limit is enough where the
    robust fit nearly ignores the curve.

    Args:
        gain: Traction of each curve over the fit's, shape (curves,).
        weight: Mean weight of its points in the robust fit.
        scatter: Rms difference from the fit times the gain, relative.
        settings: The limits.
    """
    gain_error = np.abs(np.log(np.maximum(gain, _SMALLEST_GAIN)))
    usual_gain_error = float(np.median(gain_error))
    usual_scatter = float(np.median(scatter))
    deviation = MAD_TO_SIGMA * usual_gain_error
    is_far = gain_error > max(settings.odd_gain, settings.odd_factor * usual_gain_error)
    is_far |= gain_error > max(settings.odd_gain_deviations * deviation, settings.odd_gain_min)
    is_wide = scatter > max(settings.odd_scatter, settings.odd_factor * usual_scatter)
    # weights are of absolute residuals, which grow with mu: a weight alone is no reason
    is_material = (gain_error > settings.odd_gain / 2) | (scatter > settings.odd_scatter / 2)
    is_ignored = is_material & (weight < settings.pulling_weight)
    return np.asarray(is_far | is_wide | is_ignored)
