"""The fit with a robust loss beside the plain one, and the curves that pull the plain one away.

The plain sum of squares (Eq. 10 of the paper) is the reference. What a robust loss makes of the
same points says whether a few curves decide the constants.

Decides: the robust fit, and which curves are odd.
"""

from dataclasses import replace

import numpy as np

from oilfilm.base.units import MAD_TO_SIGMA, BoolArray, FloatArray
from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings

# Cauchy loss at this many standard deviations keeps 95 % of the efficiency on normal errors.
_CAUCHY_TUNING = 2.3849
_ROUNDS = 100
# Of the SSE in each round; and a change of mu that is none, over the scale.
_TOLERANCE, _STANDS = 1e-8, 1e-6
# Of a curve's largest traction: points with less say little about it, and do not count.
_LEAST_TRACTION = 0.2


# Free internal constants, and the weight of each point (at most 1).
Robust = tuple[FloatArray, FloatArray]


def robust_fit(problem: Problem, plain: Optimum) -> Robust | None:
    """Cauchy loss, its scale from the median size of the residuals; None for an exact fit.

        minimise sum of ln(1 + (r/c)^2),  c = 2.3849 * 1.4826 median |r|

    Least squares with each point's weight from its last residual, and the scale from all of them,
    until the law stands.

    Reference: P. J. Huber, E. M. Ronchetti, Robust Statistics, 2nd ed. (2009), chapters 4 and 7.
    """
    values, residual = plain.values, problem.residual(plain.values)
    for _ in range(_ROUNDS):
        scale = _CAUCHY_TUNING * MAD_TO_SIGMA * float(np.median(np.abs(residual)))
        if scale == 0 or not np.isfinite(scale):
            return None
        weighted = replace(problem, weight=1 / (1 + (residual / scale) ** 2))
        (values,), _ = descend(weighted, values[np.newaxis], tolerance=_TOLERANCE, near=True)
        before, residual = residual, problem.residual(values)
        if np.abs(residual - before).max() <= _STANDS * scale:
            break
    return values, 1 / (1 + (residual / scale) ** 2)


def curve_agreement(
    problem: Problem, robust: Robust | None, settings: FitSettings
) -> dict[str, FloatArray | BoolArray]:
    """How each curve agrees with the robust fit of all of them; perfectly where it is exact.

    Points of little traction are left out: near S = 0 every curve agrees with every law.

    Returns:
        Columns of `curve_residuals`: its traction over the fit's (`gain`), the mean weight of its
        points (`robust_weight`, near 1 where it agrees), and whether it is `odd`.
    """
    ones = np.ones(problem.curves)
    if robust is None:
        return {"gain": ones, "robust_weight": ones, "odd": ones < 0}
    values, weight = robust
    curve, fitted = problem.at.curve, problem.residual(values) + problem.mu
    counts = fitted >= _LEAST_TRACTION * np.maximum.reduceat(fitted, problem.starts)[curve]

    def total(of_points: FloatArray) -> FloatArray:
        kept = np.where(counts, of_points, 0.0)
        return np.bincount(curve, kept, minlength=problem.curves).astype(np.float64)

    number, power = total(np.ones(len(curve))), total(fitted**2)
    # a curve without traction agrees with every law
    gain = np.divide(total(problem.mu * fitted), power, out=ones.copy(), where=power > 0)
    power = np.where(power > 0, power, 1.0)
    rest = total((problem.mu - gain[curve] * fitted) ** 2)
    mean_weight = total(weight) / number
    odd = _odd(gain, mean_weight, np.sqrt(rest / power) / gain, settings)
    return {"gain": gain, "robust_weight": mean_weight, "odd": odd}


def _odd(
    gain: FloatArray, weight: FloatArray, scatter: FloatArray, settings: FitSettings
) -> BoolArray:
    """Curves that do not belong to the others: they pull the plain fit away.

    The gain or the scatter (rms difference from the fit times its gain, relative) of such a curve
    is far from those of the others: further than the limit, and than what a law that fits all of
    them badly explains. Half the limit is enough where the robust fit nearly ignores the curve.
    """
    off = np.abs(np.log(np.maximum(gain, 1e-9)))
    usual_off, usual_scatter = float(np.median(off)), float(np.median(scatter))
    far = off > max(settings.odd_gain, settings.odd_factor * usual_off)
    deviation = MAD_TO_SIGMA * usual_off
    far |= off > max(settings.odd_gain_deviations * deviation, settings.odd_gain_min)
    wide = scatter > max(settings.odd_scatter, settings.odd_factor * usual_scatter)
    # weights are of absolute residuals, which grow with mu: a weight alone is no reason
    material = (off > settings.odd_gain / 2) | (scatter > settings.odd_scatter / 2)
    ignored = material & (weight < settings.pulling_weight)
    return np.asarray(far | wide | ignored)
