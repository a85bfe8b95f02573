"""Profile likelihood: how the least SSE rises when one constant is held away from its optimum.

Decides: intervals of constants by profile likelihood.
"""

import numpy as np
import scipy

from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.units import FloatArray

# Where each constant is held, in naive standard errors from its optimum.
_AT = np.array([-4.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0])


def profiles(
    problem: Problem, optimum: Optimum, naive_errors: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values of each free internal constant and the signed root of the SSE's rise there.

        z = sign(x - x_best) sqrt((SSE(x) - SSE_best) / s^2),  s^2 = SSE_best / (points - constants)

    For a linear law z is the distance in naive standard errors; how far it bends from that is how
    far those errors mislead. Like them it takes every point's error for its own.

    Returns:
        Two arrays of shape (free, levels), ascending, the optimum itself in the middle.

    Reference: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications (1988),
    chapter 6.
    """
    count, levels = len(optimum.values), len(_AT)
    degrees = len(problem.mu) - count
    held = np.repeat(np.eye(count, dtype=bool), levels, axis=0)
    starts = np.where(
        held, optimum.values + np.tile(_AT, count)[:, np.newaxis] * naive_errors, optimum.values
    )
    # beyond the bounds a constant has no meaning
    starts = np.clip(starts, *problem.limits.T)
    sse = np.full(len(starts), np.nan)
    if np.isfinite(naive_errors).all():
        _, sse = descend(problem, starts, held=held, tolerance=1e-10)
    rise = np.maximum(sse - optimum.sse, 0) * degrees / max(optimum.sse, np.finfo(float).tiny)
    z = np.sign(np.tile(_AT, count)) * np.sqrt(rise)
    middle = levels // 2
    values = np.insert(starts[held].reshape(count, levels), middle, optimum.values, axis=1)
    return values, np.insert(z.reshape(count, levels), middle, 0.0, axis=1)


def profile_interval(
    values: FloatArray, z: FloatArray, degrees: int, level: float = 0.95
) -> tuple[float, float]:
    """Where one constant's profile crosses Student's quantiles; NaN where it does not within reach.

    Args:
        values: Ascending values of the constant.
        z: Signed roots there, as from `profiles`.
        degrees: Points minus constants.
        level: Of confidence.
    """
    limit = float(scipy.special.stdtrit(degrees, 0.5 + level / 2))
    rising = np.concatenate([[True], np.diff(z) > 0])
    if not np.isfinite(z).all() or not rising.all():
        return float("nan"), float("nan")
    at = scipy.interpolate.PchipInterpolator(z, values, extrapolate=False)
    return float(at(-limit)), float(at(limit))
