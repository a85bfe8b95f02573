"""Profile likelihood: how the least SSE rises when one constant is held away from its optimum.

Decides: intervals of constants by profile likelihood.
"""

import numpy as np

from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum
from oilfilm.fits.interval import student_quantile
from oilfilm.fits.problem import Problem
from oilfilm.units import FloatArray

# Where each constant is held, in naive standard errors from its optimum.
_AT = np.array([-4.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0])


def profiles(
    problem: Problem, optimum: Optimum, naive: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values of each free internal constant and the signed root of the SSE's rise there.

        z = sign(x - x_best) sqrt((SSE(x) - SSE_best) / s^2),  s^2 = SSE_best / (points - constants)

    For a linear law z is the distance in naive standard errors; how far it bends from that is how
    far those errors mislead. Like them it takes every point's error for its own.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        naive: Naive covariance of the free internal constants. The others start where it expects
            them.

    Returns:
        Two arrays of shape (free, levels), ascending, the optimum itself in the middle.

    Reference: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications (1988),
    chapter 6.
    """
    count, levels = len(optimum.values), len(_AT)
    degrees = len(problem.mu) - count
    held = np.repeat(np.eye(count, dtype=bool), levels, axis=0)
    errors = np.sqrt(np.diag(naive))
    towards = (naive / errors).T[:, np.newaxis] * _AT[:, np.newaxis]
    starts = optimum.values + towards.reshape(-1, count)
    # beyond the bounds a constant has no meaning
    starts = np.clip(starts, *problem.limits.T)
    sse = np.full(len(starts), np.nan)
    if np.isfinite(naive).all():
        _, sse = descend(problem, starts, held=held, tolerance=1e-7, near=True)
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
    limit = student_quantile(level, degrees)
    rising = np.concatenate([[True], np.diff(z) > 0])
    if not np.isfinite(z).all() or not rising.all():
        return float("nan"), float("nan")
    return _crossing(values, z, -limit), _crossing(values, z, limit)


def _crossing(values: FloatArray, z: FloatArray, at: float) -> float:
    """The value at one signed root: on the cubic through the four nearest ones; NaN outside."""
    after = int(np.searchsorted(z, at))
    if not 0 < after < len(z):
        return float("nan")
    some = slice(max(after - 2, 0), after + 2)
    return float(np.polyval(np.polyfit(z[some], values[some], len(z[some]) - 1), at))
