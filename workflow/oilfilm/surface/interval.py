"""How far the next run may be from a surface, by the conditions that were left out.

The standard deviation of the next run is multiplied by a factor: one for a single point, and one
for a band over a whole curve. 12 points that are inside with 95 % each are not all inside with
95 %, and few left-out curves show that by chance only. So the factor of the band is at least the
quantile of the largest error of a curve that is drawn from the model.

Decides: the level of an interval that few conditions allow.
"""

import bisect
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.posterior import LeftOutCurves
from oilfilm.surface.reml import CurveCovariance

# Number of curves that are drawn. It gives the quantile of their largest score within 1 %.
_DRAW_COUNT = 20_000
# A share that is below a level by rounding only has reached it.
_ROUNDING = 1e-9


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


def allowed_level(wanted_level: float, condition_count: int) -> float:
    """The wanted level, or n/(n+1) for n conditions if that is less.

    Repeated runs do not raise the level.

    >>> round(allowed_level(0.95, 8), 3)
    0.889
    """
    return min(wanted_level, condition_count / (condition_count + 1))


def normal_half_width(level: float) -> float:
    """Half width of the interval that holds this share of a normal distribution, in its sd.

    >>> round(normal_half_width(0.95), 3)
    1.96
    """
    return float(scipy.special.ndtri((1 + level) / 2))


def point_quantile(scores: FloatArray, condition_of_point: IndexArray, level: float) -> float:
    """The score below which a point of a new condition is expected with the given probability.

    The share of points below a score is the mean over the conditions. The new condition counts
    beside them, with the share of the worst one. Where whole conditions are far off, this is the
    quantile of exchangeable groups, which holds without any assumption. Where single points are far
    off, as by noise with heavy tails, that quantile would be the largest of all scores in 19
    conditions.

    Args:
        scores: Scores of the points of left-out conditions, shape (points,).
        condition_of_point: Index of the condition of each point, shape (points,).
        level: The level of the interval (`allowed_level`).

    Reference: R. Dunn, L. Wasserman, A. Ramdas, J. Am. Stat. Assoc. 118 (2023) 2491 (groups).
    """
    point_counts = np.bincount(condition_of_point)

    def expected_share(score_limit: float) -> float:
        """Share of the points of a new condition with scores up to a limit."""
        shares = np.bincount(condition_of_point, scores <= score_limit) / point_counts
        return float((shares.sum() + shares.min()) / (len(point_counts) + 1))

    sorted_scores = np.sort(scores)
    score_index = bisect.bisect_left(sorted_scores, level - _ROUNDING, key=expected_share)
    return float(sorted_scores[min(score_index, len(sorted_scores) - 1)])


def curve_quantile(scores: FloatArray, condition_of_curve: IndexArray, level: float) -> float:
    """The score that a curve of a new condition stays below with the given probability.

    Args:
        scores: Largest score of each curve of the left-out conditions, shape (curves,).
        condition_of_curve: Index of the condition of each curve, shape (curves,).
        level: The level of the interval (`allowed_level`).

    Reference: V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World (2005),
    with one group per condition.
    """
    curves_by_score = np.argsort(scores, kind="stable")
    curve_counts = np.bincount(condition_of_curve)
    weights = 1 / curve_counts[condition_of_curve[curves_by_score]]
    cumulative_shares = np.cumsum(weights) / (len(curve_counts) + 1)
    rank = int(np.searchsorted(cumulative_shares, level - _ROUNDING))
    return float(scores[curves_by_score[min(rank, len(curves_by_score) - 1)]])


def interval_factors(
    covariance: CurveCovariance,
    curve_of_point: IndexArray,
    condition_of_curve: IndexArray,
    left_out_conditions: Iterable[LeftOutCurves],
    wanted_level: float,
) -> IntervalFactors:
    """Factors from the errors at left-out conditions over their standard deviations.

    Left-out corners of a plan never test its middle. What they show can widen an interval beyond
    that of a normal distribution, and never narrows it.

    Args:
        covariance: Covariance of the curves.
        curve_of_point: Index of the curve of each point, shape (points,).
        condition_of_curve: Index of the condition of each curve, shape (curves,).
        left_out_conditions: The curves of each condition, as those of the others predict them.
        wanted_level: Share that an interval should hold, where there are enough conditions.
    """
    scores, drawn_largest_scores = _scores_and_draws(
        covariance, curve_of_point, left_out_conditions
    )
    level = allowed_level(wanted_level, int(condition_of_curve.max()) + 1)
    largest_scores = np.zeros(len(condition_of_curve))
    np.maximum.at(largest_scores, curve_of_point, scores)
    point_factor = max(
        normal_half_width(wanted_level),
        point_quantile(scores, condition_of_curve[curve_of_point], level),
    )
    model_quantile = float(np.quantile(drawn_largest_scores, wanted_level))
    return IntervalFactors(
        level=level,
        point=point_factor,
        curve=max(
            point_factor, model_quantile, curve_quantile(largest_scores, condition_of_curve, level)
        ),
    )


def _scores_and_draws(
    covariance: CurveCovariance,
    curve_of_point: IndexArray,
    left_out_conditions: Iterable[LeftOutCurves],
) -> tuple[FloatArray, FloatArray]:
    """Score of each point, and drawn largest scores of a curve.

    The score of a point is the size of its error over the standard deviation of the error. A draw
    is the largest score of a curve whose errors have the covariance of the model.

    Returns:
        Shapes (points,) and (draws,).
    """
    curves, noise = covariance.curves, covariance.sizes.noise
    random_generator = generator(0, "largest score of a curve")
    draws_per_curve = math.ceil(_DRAW_COUNT / len(curves.conditions))
    error = curves.remainder.copy()
    variance = np.zeros(len(error))
    drawn_largest_scores = []
    for left_out in left_out_conditions:
        point_indices, vectors = curves.vectors_of(left_out.coordinate_indices)
        error[point_indices] += vectors @ left_out.error
        noise_variance = noise**2 * (1 - np.sum(vectors**2, axis=1))
        variance[point_indices] = (
            np.sum((vectors @ left_out.covariance) * vectors, axis=1) + noise_variance
        )
        drawn_errors = _drawn_errors(left_out, vectors, noise, random_generator, draws_per_curve)
        drawn_scores = np.abs(drawn_errors) / np.sqrt(variance[point_indices, np.newaxis])
        first_points_of_curves = np.flatnonzero(np.diff(curve_of_point[point_indices], prepend=-1))
        drawn_largest_scores.append(
            np.maximum.reduceat(drawn_scores, first_points_of_curves, axis=0).ravel()
        )
    return np.abs(error) / np.sqrt(variance), np.concatenate(drawn_largest_scores)


def _drawn_errors(
    left_out: LeftOutCurves,
    vectors: FloatArray,
    noise: float,
    random_generator: np.random.Generator,
    draw_count: int,
) -> FloatArray:
    """Errors of the points of left-out curves, drawn from the model, shape (points, draws).

    Args:
        left_out: The curves.
        vectors: V of their coordinates, shape (points, coordinates).
        noise: Standard deviation of the noise of points.
        random_generator: Draws the errors.
        draw_count: Number of draws.
    """
    # of the points and not of the coordinates, whose signs depend on the machine
    covariance = vectors @ left_out.covariance @ vectors.T
    point_count = len(covariance)
    # noise within the coordinates is already in their covariance
    covariance += noise**2 * (np.eye(point_count) - vectors @ vectors.T)
    factor = scipy.linalg.cholesky(covariance, lower=True)
    return np.asarray(factor @ random_generator.standard_normal((point_count, draw_count)))
