"""How far the next run may be from a surface, by the conditions that were left out.

Decides: the level of an interval that few conditions allow.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.posterior import LeftOut
from oilfilm.surface.reml import CurveCovariance

_WANTED_LEVEL = 0.95
# Of a normal distribution. Left-out corners of a plan never test its middle, so what they show can
# widen an interval and never narrows it.
_NORMAL_FACTOR = 1.96


@dataclass(frozen=True)
class IntervalFactors:
    """Factors on the standard deviation of the next run.

    Attributes:
        level: Share of points of new runs that the interval should hold: 0.95, or n/(n+1) for n
            conditions if that is less.
        point: Factor for a single point.
        curve: Factor for a band that should hold all points of a curve, at the same level.
    """

    level: float
    point: float
    curve: float


def allowed_level(conditions: int) -> float:
    """The level that so many conditions allow; repeated runs do not raise it.

    >>> round(allowed_level(8), 3)
    0.889
    """
    return min(_WANTED_LEVEL, conditions / (conditions + 1))


def conformal_quantile(scores: FloatArray, weights: FloatArray, conditions: int) -> float:
    """The score that a new condition stays below at the allowed level.

    Args:
        scores: Scores of points or curves of the left-out conditions.
        weights: Weight of each score; those of each condition have the sum 1.
        conditions: Number of conditions.

    Reference: V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World (2005),
    with one group per condition.
    """
    wanted = allowed_level(conditions) * (conditions + 1)
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
) -> IntervalFactors:
    """Factors from the errors at left-out conditions over their standard deviations.

    Args:
        covariance: Covariance of the curves.
        point_curve: Curve of each point, shape (points,).
        condition: Condition of each curve, shape (curves,).
        left_out: Each condition, as the others predict it.
    """
    score = _scores(covariance, left_out)
    conditions = int(condition.max()) + 1
    curves = len(condition)
    points_of_condition = np.bincount(condition[point_curve], minlength=conditions)
    curves_of_condition = np.bincount(condition, minlength=conditions)
    largest = np.zeros(curves)
    np.maximum.at(largest, point_curve, score)
    of_points = conformal_quantile(
        score, 1 / points_of_condition[condition[point_curve]], conditions
    )
    of_curves = conformal_quantile(largest, 1 / curves_of_condition[condition], conditions)
    point = max(_NORMAL_FACTOR, of_points)
    return IntervalFactors(allowed_level(conditions), point, max(point, of_curves))


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
