"""How a fitted law does on curves that it has not seen.

Decides: the errors of curves left out.
"""

import numpy as np

from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.units import BoolArray, FloatArray, IndexArray

# Errors of single points are reported: they feel what an SSE does not.
_TOLERANCE = 1e-8


def leave_curves_out(
    problem: Problem, optimum: Optimum, groups: int, random: np.random.Generator
) -> FloatArray:
    """Error of each point's mu in a fit that has not seen its curve.

    Each such fit descends from the optimum of all; another valley is not looked for. Up to `groups`
    curves are left out one at a time. More are left out in as many groups, drawn at random, so
    that the cost grows with the number of curves and not with its square. A fit then misses some
    more curves than the one that it is judged by.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        groups: The largest number of fits.
        random: Draws the groups.

    Returns:
        Fitted minus measured mu, shape (points,); NaN where the other curves leave a constant open.

    Reference: T. Hastie, R. Tibshirani, J. Friedman, The Elements of Statistical Learning, 2nd ed.
        (2009), section 7.10.1.
    """
    group = np.arange(problem.curves)
    if problem.curves > groups:
        group = random.permutation(group) % groups
    return _errors_left_out(problem, optimum, np.unique(group)[:, np.newaxis] == group)


def spread_left_out(problem: Problem, optimum: Optimum, covariance: FloatArray) -> FloatArray:
    """Random standard error of mu at each point, by a fit that has not seen its curve.

    That of the fit to all curves, times what the curve alone tells of its own mu:
    g^T (J^T J - J_i^T J_i)^-1 g over g^T (J^T J)^-1 g.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        covariance: Of the free internal constants, shape (free, free).

    Returns:
        Shape (points,).
    """
    jacobian = problem.jacobian(optimum.values)
    variance = np.einsum("pi,ij,pj->p", jacobian, covariance, jacobian)
    orthonormal, _ = np.linalg.qr(jacobian)
    seen = np.sum(orthonormal**2, axis=1)
    unseen = np.empty_like(seen)
    for first, length in zip(problem.starts, problem.lengths, strict=True):
        of_curve = orthonormal[first : first + length]
        # (I - Q_i^T Q_i)^-1 is endless where the curve alone decides a direction
        others = np.linalg.pinv(np.eye(orthonormal.shape[1]) - of_curve.T @ of_curve)
        unseen[first : first + length] = np.einsum("pi,ij,pj->p", of_curve, others, of_curve)
    growth = np.divide(unseen, seen, out=np.ones_like(seen), where=seen > 0)
    return np.sqrt(np.maximum(variance * growth, 0.0))


def leave_ends_out(problem: Problem, optimum: Optimum, levels: IndexArray) -> FloatArray:
    """The same of the curves of the lowest and of the highest level, by fits to the other levels.

    Both ends are extrapolated to, one at a time.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        levels: Level of each curve, counted from 0, as by `level_of`.

    Returns:
        Fitted minus measured mu, shape (points,); NaN at all levels between, and at all points
        where there are fewer than two levels or the others leave a constant open.
    """
    if levels.max(initial=0) == 0:
        return np.full(len(problem.mu), np.nan)
    return _errors_left_out(problem, optimum, np.stack([levels == 0, levels == levels.max()]))


def level_of(values: FloatArray, gap: float) -> IndexArray:
    """Levels among measured values, counted from 0 for the lowest.

    Args:
        values: One per curve.
        gap: A new level begins where two neighbours differ by more than this share of the range.

    Returns:
        Level of each value; all 0 where a value is unknown.

    Examples:
        >>> level_of(np.array([25.1, 119.8, 24.9, 70.0, 120.2]), gap=0.05)
        array([0, 2, 0, 1, 2])
    """
    if not np.isfinite(values).all():
        return np.zeros(len(values), dtype=np.int64)
    order = np.argsort(values)
    steps = np.diff(values[order], prepend=values.min(initial=np.inf))
    levels = np.empty(len(values), dtype=np.int64)
    levels[order] = np.cumsum(steps > gap * np.ptp(values))
    return levels


def relative_rms(errors: FloatArray, mu: FloatArray) -> float:
    """Root-mean-square error over root-mean-square mu, where there is an error; else NaN."""
    known = np.isfinite(errors)
    if not known.any():
        return float("nan")
    return float(np.sqrt(np.sum(errors[known] ** 2) / np.sum(mu[known] ** 2)))


def _errors_left_out(problem: Problem, optimum: Optimum, left_out: BoolArray) -> FloatArray:
    """Errors at the curves that each row of `left_out` leaves out, by a fit to the others."""
    rank = np.linalg.matrix_rank(problem.at.design)
    possible = [np.linalg.matrix_rank(problem.at.design[~row]) == rank for row in left_out]
    left_out = left_out[possible]
    starts = np.tile(optimum.values, (len(left_out), 1))
    weights = (~left_out).astype(float)
    ends, _ = descend(problem, starts, weights=weights, tolerance=_TOLERANCE, near=True)
    errors = np.full(len(problem.mu), np.nan)
    for end, row in zip(ends, left_out, strict=True):
        points = row[problem.at.curve]
        errors[points] = problem.residual(end)[points]
    return errors
