"""Curves whose shape contradicts what the other curves of the oil say.

Each point is judged by all other points, those of its own curve included, and each curve by all
other curves. Both follow from the inverse covariance in closed form, so nothing is fitted again.
Over all points it is V K^-1 V' + (I - V V')/s^2, with K the covariance of the coordinates of curves
and s the noise of points.

The sizes are fitted with the bad curve among the others. A fault that is smooth in slip, as that of
a contact that starves, then raises the size of the departure. It may hide itself, above all in few
runs.

Decides: when the shape of a curve contradicts the others.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.base.ties import first_largest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.effects import RunErrorSizes
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.posterior import Posterior
from oilfilm.surface.reml import CurveCovariance
from oilfilm.surface.surface import fit_surface
from oilfilm.surface.threads import with_one_blas_thread

# Errors of a point over its standard deviation, and squares of a curve per point, above which the
# shape is odd. A trial named none of 432 clean curves of smooth oils.
_ODD_POINT = 6.0
_ODD_CURVE = 5.5
# Fewer curves cannot judge each other.
_FEWEST_CURVES = 4


@dataclass(frozen=True)
class OddCurve:
    """A curve that contradicts the others.

    Attributes:
        curve: Row of the curve in the measurements.
        point: Row of its oddest point in the measurements.
        point_score: Error of this point over its standard deviation, given all other points.
        squares_per_point: Squares of the errors of the curve over their covariance, given all
            other curves, per point.
    """

    curve: int
    point: int
    point_score: float
    squares_per_point: float

    @property
    def size(self) -> float:
        """How far the curve is above the limits; above 1 it is odd."""
        return max(self.point_score / _ODD_POINT, self.squares_per_point / _ODD_CURVE)


def odd_curves(
    measurements: Measurements, law: FreeLaw, errors: RunErrorSizes | None = None
) -> tuple[OddCurve, ...]:
    """Curves that contradict the others, the worst first.

    The worst curve is left out and the rest is fitted again, until no curve is odd: a bad curve
    makes good ones beside it look odd. At most a third of the curves is left out.

    Args:
        measurements: The points.
        law: The best fitted law.
        errors: Sizes of the errors of the rig, before the data.
    """
    curves, points = measurements.canonical_order()
    ordered = measurements.in_canonical_order()
    kept = np.arange(len(curves))
    odd: list[OddCurve] = []
    while len(kept) >= max(_FEWEST_CURVES, 2 * len(curves) / 3):
        rows_of_points = np.flatnonzero(np.isin(ordered.curve, kept))
        worst = _worst(ordered.of_curves(kept), law, errors)
        if worst.size <= 1:
            break
        row = kept[worst.curve]
        odd.append(
            OddCurve(
                curve=int(curves[row]),
                point=int(points[rows_of_points[worst.point]]),
                point_score=worst.point_score,
                squares_per_point=worst.squares_per_point,
            )
        )
        kept = kept[kept != row]
    return tuple(odd)


def point_scores(posterior: Posterior, covariance: CurveCovariance) -> FloatArray:
    """Error of each point over its standard deviation, given all other points, shape (points,).

    Args:
        posterior: The posterior.
        covariance: Covariance of the curves.
    """
    curves, noise_variance = covariance.curves, covariance.sizes.noise**2
    weights = curves.remainder / noise_variance
    precision = np.zeros(len(weights))
    for left_out in posterior.left_out(np.arange(len(curves.conditions))):
        points, vectors = curves.vectors_of(left_out.coordinates)
        weights[points] += vectors @ left_out.weights
        of_noise = (1 - np.sum(vectors**2, axis=1)) / noise_variance
        precision[points] = np.sum((vectors @ left_out.precision) * vectors, axis=1) + of_noise
    return np.abs(weights) / np.sqrt(precision)


def squares_per_point(
    posterior: Posterior, covariance: CurveCovariance, curve: IndexArray
) -> FloatArray:
    """Squares of each curve's errors over their covariance, per point, given all other curves.

    Args:
        posterior: The posterior.
        covariance: Covariance of the curves.
        curve: Curve of each point, shape (points,).
    """
    curves, noise = covariance.curves, covariance.sizes.noise
    squares = np.bincount(curve, (curves.remainder / noise) ** 2)
    for row, left_out in enumerate(posterior.left_out(np.arange(len(curves.conditions)))):
        squares[row] += left_out.error @ left_out.precision @ left_out.error
    return squares / np.bincount(curve)


@with_one_blas_thread
def _worst(measurements: Measurements, law: FreeLaw, errors: RunErrorSizes | None) -> OddCurve:
    """The curve that contradicts the others most.

    Args:
        measurements: The points, in canonical order.
        law: The best fitted law.
        errors: Sizes of the errors of the rig, before the data.
    """
    surface = fit_surface(measurements, law, errors)
    scores = point_scores(surface.posterior, surface.covariance)
    squares = squares_per_point(surface.posterior, surface.covariance, measurements.curve)
    ends = np.cumsum(np.bincount(measurements.curve))[:-1]
    points_of_curves = np.split(np.arange(len(scores)), ends)
    candidates = []
    for row, points in enumerate(points_of_curves):
        point = points[first_largest(scores[points])]
        candidates.append(OddCurve(row, int(point), float(scores[point]), float(squares[row])))
    return candidates[int(first_largest([candidate.size for candidate in candidates]))]
