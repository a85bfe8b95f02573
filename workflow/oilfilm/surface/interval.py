"""How far the next run may be from a surface, by the conditions that were left out.

A single answer and a band over a curve have a factor each. That of the band is also at least the
quantile of the largest error of a curve by the model: 12 points that are inside with 95 % each are
not all inside with 95 %, and few left-out curves show that by chance only.

Decides: the level of an interval that few conditions allow.
"""

import bisect
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.special

from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.posterior import LeftOut
from oilfilm.surface.reml import CurveCovariance

# Curves that are drawn for the largest score of a curve. Its quantile is then known within 1 %.
_DRAWS = 20_000
# A share that rounding leaves just below a level has reached it.
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


def point_quantile(scores: FloatArray, condition: IndexArray, level: float) -> float:
    """The score below which a point of a new condition is expected with the given probability.

    The share of points below a score is the mean over the conditions. The new condition counts
    beside them, with the share of the worst one. Where whole conditions are far off, this is the
    quantile of exchangeable groups, which holds without any assumption and takes no point of a new
    condition for granted. Where single points are far off, as by noise with heavy tails, that
    quantile would be the largest of all scores in 19 conditions.

    Args:
        scores: Scores of the points of left-out conditions, shape (points,).
        condition: Condition of each point, shape (points,).
        level: Level that so many conditions allow.

    Reference: R. Dunn, L. Wasserman, A. Ramdas, J. Am. Stat. Assoc. 118 (2023) 2491 (groups).
    """
    counts = np.bincount(condition)

    def expected_share(limit: float) -> float:
        """Share of the points of a new condition with scores up to a limit."""
        shares = np.bincount(condition, scores <= limit) / counts
        return float((shares.sum() + shares.min()) / (len(counts) + 1))

    ordered = np.sort(scores)
    number = bisect.bisect_left(ordered, level - _ROUNDING, key=expected_share)
    return float(ordered[min(number, len(ordered) - 1)])


def curve_quantile(scores: FloatArray, condition: IndexArray, level: float) -> float:
    """The score that a curve of a new condition stays below with the given probability.

    Args:
        scores: Largest score of each curve of the left-out conditions, shape (curves,).
        condition: Condition of each curve, shape (curves,).
        level: Level that so many conditions allow.

    Reference: V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World (2005),
    with one group per condition.
    """
    order = np.argsort(scores, kind="stable")
    counts = np.bincount(condition)
    reached = np.cumsum(1 / counts[condition[order]]) / (len(counts) + 1)
    number = int(np.searchsorted(reached, level - _ROUNDING))
    return float(scores[order[min(number, len(order) - 1)]])


def interval_factors(
    covariance: CurveCovariance,
    point_curve: IndexArray,
    condition: IndexArray,
    left_out: Iterable[LeftOut],
    wanted_level: float,
) -> IntervalFactors:
    """Factors from the errors at left-out conditions over their standard deviations.

    Left-out corners of a plan never test its middle. What they show can widen an interval beyond
    that of a normal distribution, and never narrows it.

    Args:
        covariance: Covariance of the curves.
        point_curve: Curve of each point, shape (points,).
        condition: Condition of each curve, shape (curves,).
        left_out: Each condition, as the others predict it.
        wanted_level: Share that an interval should hold, where there are conditions enough.
    """
    scores, drawn_largest_scores = _scores(covariance, point_curve, left_out)
    level = allowed_level(wanted_level, int(condition.max()) + 1)
    largest_scores = np.zeros(len(condition))
    np.maximum.at(largest_scores, point_curve, scores)
    point_factor = max(
        normal_factor(wanted_level), point_quantile(scores, condition[point_curve], level)
    )
    model_quantile = float(np.quantile(drawn_largest_scores, wanted_level))
    return IntervalFactors(
        level=level,
        point=point_factor,
        curve=max(point_factor, model_quantile, curve_quantile(largest_scores, condition, level)),
    )


def _scores(
    covariance: CurveCovariance, point_curve: IndexArray, left_out: Iterable[LeftOut]
) -> tuple[FloatArray, FloatArray]:
    """Size of the error of each point over its standard deviation, and largest ones by the model.

    Returns:
        Shapes (points,) and (draws,). A draw is the largest score of a curve whose errors have the
        covariance of the model.
    """
    curves, noise = covariance.curves, covariance.sizes.noise
    random = generator(0, "largest score of a curve")
    draws_per_curve = -(-_DRAWS // len(curves.conditions))
    error = curves.remainder.copy()
    variance = np.zeros(len(error))
    drawn_largest_scores = []
    for group in left_out:
        points, vectors = curves.vectors_of(group.coordinates)
        error[points] += vectors @ group.error
        noise_variance = noise**2 * (1 - np.sum(vectors**2, axis=1))
        variance[points] = np.sum((vectors @ group.covariance) * vectors, axis=1) + noise_variance
        drawn_errors = _drawn_errors(group, vectors, noise, random, draws_per_curve)
        drawn_scores = np.abs(drawn_errors) / np.sqrt(variance[points, np.newaxis])
        starts = np.flatnonzero(np.diff(point_curve[points], prepend=-1))
        drawn_largest_scores.append(np.maximum.reduceat(drawn_scores, starts, axis=0).ravel())
    return np.abs(error) / np.sqrt(variance), np.concatenate(drawn_largest_scores)


def _drawn_errors(
    group: LeftOut, vectors: FloatArray, noise: float, random: np.random.Generator, draws: int
) -> FloatArray:
    """Errors of the points of a group, drawn from their distribution, shape (points, draws).

    Args:
        group: The group.
        vectors: V of its coordinates, shape (points, coordinates).
        noise: Standard deviation of the noise of points.
        random: Draws the errors.
        draws: Number of draws.
    """
    # of the points and not of the coordinates, whose signs depend on the machine
    covariance = vectors @ group.covariance @ vectors.T
    points = len(covariance)
    # noise within the coordinates is already in their covariance
    covariance += noise**2 * (np.eye(points) - vectors @ vectors.T)
    factor = scipy.linalg.cholesky(covariance, lower=True)
    return np.asarray(factor @ random.standard_normal((points, draws)))
