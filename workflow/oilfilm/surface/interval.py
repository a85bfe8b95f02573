"""How far the next run may be from a surface, by the conditions that were left out.

Decides: the level of an interval that few conditions allow.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.special

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.posterior import LeftOut
from oilfilm.surface.reml import CurveCovariance


@dataclass(frozen=True)
class IntervalFactors:
    """Factors on the standard deviation of the next run.

    Attributes:
        level: Share of points of new runs that the interval should hold: the wanted one, or
            n/(n+1) for n conditions if that is less.
        point: Factor for a single point.
        curve: Factor for a band that should hold all points of a curve, at the same level.
    """

    level: float
    point: float
    curve: float


def allowed_level(wanted: float, conditions: int) -> float:
    """The wanted level, or the one that so many conditions allow; repeated runs do not raise it.

    >>> round(allowed_level(0.95, 8), 3)
    0.889
    """
    return min(wanted, conditions / (conditions + 1))


def normal_factor(level: float) -> float:
    """Standard deviations on either side that hold this share of a normal distribution.

    >>> round(normal_factor(0.95), 3)
    1.96
    """
    return float(scipy.special.ndtri((1 + level) / 2))


def conformal_quantile(
    scores: FloatArray, weights: FloatArray, conditions: int, level: float
) -> float:
    """The score that a new condition stays below at a level.

    Args:
        scores: Scores of points or curves of the left-out conditions.
        weights: Weight of each score; those of each condition have the sum 1.
        conditions: Number of conditions.
        level: Level that so many conditions allow.

    Reference: V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World (2005),
    with one group per condition.
    """
    wanted = level * (conditions + 1)
    order = np.argsort(scores, kind="stable")
    reached = np.cumsum(weights[order])
    # rounding must not ask for more than all scores
    number = int(np.searchsorted(reached, min(wanted, conditions) - 1e-9))
    return float(scores[order[min(number, len(scores) - 1)]])


def interval_factors(
    covariance: CurveCovariance,
    point_curve: IndexArray,
    condition: IndexArray,
    left_out: Iterable[LeftOut],
    wanted_level: float,
) -> IntervalFactors:
    """Factors from the errors at left-out conditions over their standard deviations.

    Left-out corners of a plan never test its middle, so what they show can widen an interval beyond
    that of a normal distribution, and never narrows it.

    Args:
        covariance: Covariance of the curves.
        point_curve: Curve of each point, shape (points,).
        condition: Condition of each curve, shape (curves,).
        left_out: Each condition, as the others predict it.
        wanted_level: Share that an interval should hold, where there are conditions enough.
    """
    score = _scores(covariance, left_out)
    conditions = int(condition.max()) + 1
    curves = len(condition)
    level = allowed_level(wanted_level, conditions)
    points_of_condition = np.bincount(condition[point_curve], minlength=conditions)
    curves_of_condition = np.bincount(condition, minlength=conditions)
    largest = np.zeros(curves)
    np.maximum.at(largest, point_curve, score)
    of_points = conformal_quantile(
        score, 1 / points_of_condition[condition[point_curve]], conditions, level
    )
    of_curves = conformal_quantile(largest, 1 / curves_of_condition[condition], conditions, level)
    point = max(normal_factor(wanted_level), of_points)
    return IntervalFactors(level, point, max(point, of_curves))


def _scores(covariance: CurveCovariance, left_out: Iterable[LeftOut]) -> FloatArray:
    """Size of the error of each point over its standard deviation, shape (points,)."""
    curves = covariance.curves
    noise_variance = covariance.sizes.noise**2
    error = curves.remainder.copy()
    variance = np.zeros(len(error))
    for group in left_out:
        points, vectors = curves.vectors_of(group.coordinates)
        error[points] += vectors @ group.error
        of_noise = noise_variance * (1 - np.sum(vectors**2, axis=1))
        variance[points] = np.sum((vectors @ group.covariance) * vectors, axis=1) + of_noise
    return np.abs(error) / np.sqrt(variance)
