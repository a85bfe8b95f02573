"""Curves whose shape contradicts what the other curves of the oil say.

Each point is judged by all other points, those of its own curve included, and each curve by all
other curves. Both follow from the inverse covariance in closed form. The inverse covariance of all
points is V K^-1 V' + (s^2 (I - V V') + z z')^-1, with K the covariance of the coordinates of curves
and s the noise of points. z is what V leaves of the zero of a run: V is smooth, and near zero
traction the effect of the zero is not. The second inverse is that in the space beyond V.

A bad curve makes the departure and the noise large, and so hides itself. It also makes good curves
near it look odd. So bad curves are left out. The retained curves alone judge all curves, and the
law and the sizes are fitted to them:

1. All curves are judged with the prior medians of the sizes. A quarter of the curves
   is left out, one after the other; each time it is the curve that agrees least.
2. Law and sizes are fitted to the retained curves, and all curves are judged by these. Curves that
   agree are retained again. The curve that contradicts most is left out, until none contradicts.
3. Step 2 is repeated until the retained curves stay the same.
4. A curve that was left out may show what the retained ones do not: a corner of the plan where the
   oil behaves otherwise. So it must also be odd, by lower limits, where the departure from the law
   is fitted to all curves of the sample. The errors of the rig are those of the retained curves.

This is the search for outliers by a subset without them, as in the minimum covariance determinant.
In a large campaign law and sizes come from a sample, and a curve is judged by the curves in its
part of the tested conditions, so that the cost is linear in the number of curves.

Reference: P. J. Rousseeuw, K. Van Driessen, Technometrics 41 (1999) 212 (concentration steps).

Decides: when the shape of a curve contradicts the others.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from oilfilm.base.ties import first_largest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.effects import EFFECT_NAMES, ErrorPriors, LogMu, LogNormal
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import Measurements, scaled_conditions
from oilfilm.surface.posterior import DensePosterior, coordinates_by_group, farthest_point_selection
from oilfilm.surface.quick_law import NoClearTractionError, quick_law
from oilfilm.surface.reduction import (
    ReducedCurves,
    box_of,
    floored_log_mu,
    is_near_zero,
    reduced_curves,
)
from oilfilm.surface.reml import (
    INTERVAL_KAPPA_PRIOR,
    CurveCovariance,
    Sizes,
    most_likely_sizes,
    priors,
)
from oilfilm.surface.surface import log_mu_of
from oilfilm.surface.threads import with_one_blas_thread
from oilfilm.traction.law import Law

# A curve is not odd if its ln mu is nowhere farther than this from what the others say. In quiet
# campaigns even errors that matter to no law and no bearing are significant.
_ODD_DEVIATION = 0.05
# Oddness of a curve above which only a fault explains it.
REFUSED_ODDNESS = 2.0
# Fewer curves cannot judge each other: with one of them left out, four must agree.
FEWEST_CURVES = 5
_FEWEST_RETAINED_CURVES = 4
# Standard deviation of the logarithm of a size that is taken as known.
_KNOWN_LN_SD = 0.01
# Largest ln mu that is stated as expected. Where the others say nothing, mu might overflow.
_LARGEST_EXPECTED_LOG_MU = 0.0
# Share of the curves that is left out in step 1. More bad curves than this may stay hidden.
_FIRST_LEFT_OUT_SHARE = 0.25
# Share of the curves that is left out at most. With more, no majority says what is right.
_MOST_LEFT_OUT_SHARE = 1 / 3
# Largest number of repetitions of step 2.
_MAX_ROUNDS = 5
# Number of curves of a large campaign to which law and sizes are fitted.
_SAMPLE_CURVE_COUNT = 40
# Largest number of curves that are judged together.
_LARGEST_PART_CURVE_COUNT = 80
# Largest error of the zero of a run, in its standard deviations. ln mu must be linear in this
# error: where mu is ten times the error, it is so within 0.5 %.
_LARGEST_ZERO_IN_SDS = 4.0
_ZERO_INDEX = EFFECT_NAMES.index("zero")


class OddnessLimits(NamedTuple):
    """Limits above which the shape of a curve is odd; one of them is enough.

    Attributes:
        point: Largest error of a point over its standard deviation, given all other points.
        curve: Square of the distance of all errors of the curve from 0, by their covariance, per
            point.
    """

    point: float
    curve: float


# Set by `benchmarks/shapes.py`: clean curves of the seeds 0 to 14, bad ones of the seeds 0 to 9.
_LIMITS_BY_RETAINED = OddnessLimits(point=7.0, curve=10.0)
# A corner of the plan where the oil behaves otherwise is far from a fit without it, and near a fit
# with it.
_LIMITS_BY_ALL = OddnessLimits(point=2.85, curve=2.55)


@dataclass(frozen=True)
class CurveShape:
    """How far the shape of a curve is from what the other curves of the oil say.

    Attributes:
        curve_index: Index of the curve in the measurements.
        point_index: Index in the measurements of the point that is farthest from what the other
            curves say, over its standard deviation. Where one point makes most of the distance, it
            is this point, which the other points of its curve contradict, too.
        expected_mu: mu at this point, as the other curves say.
        log_mu_sd: Standard deviation of ln mu of a new run at this point, by the other curves.
        median_log_mu_sd: Median of this standard deviation over the points of the curve.
        oddness: Deviation of the curve over the limits; above 1 the curve is odd.
    """

    curve_index: int
    point_index: int
    expected_mu: float
    log_mu_sd: float
    median_log_mu_sd: float
    oddness: float

    @property
    def smallest_visible_change(self) -> float:
        """Smallest change of ln mu at a point of median spread that would make the curve odd."""
        return max(_LIMITS_BY_RETAINED.point * self.median_log_mu_sd, _ODD_DEVIATION)

    @property
    def is_odd(self) -> bool:
        """Whether the curve contradicts the others."""
        return self.oddness > 1


@dataclass(frozen=True)
class PredictedCurve:
    """The coordinates of a curve, as some other curves predict them.

    Attributes:
        point_indices: Indices of its points, shape (points,).
        vectors: V of the curve, shape (points, coordinates).
        error: Measured less predicted coordinates, shape (coordinates,).
        covariance: Covariance of this error, shape (coordinates, coordinates).
        remainder: What V leaves of the departure at each point, shape (points,).
        zero_remainder: z, what V leaves of the standard deviation by the zero, shape (points,).
        noise: Standard deviation of the noise of points.
        log_mu: Measured ln mu, linearised near zero, shape (points,).
        largest_zero: Largest error of the zero, as a traction coefficient.
    """

    point_indices: IndexArray
    vectors: FloatArray
    error: FloatArray
    covariance: FloatArray
    remainder: FloatArray
    zero_remainder: FloatArray
    noise: float
    log_mu: FloatArray
    largest_zero: float

    @cached_property
    def precision(self) -> FloatArray:
        """Inverse of the covariance, shape (coordinates, coordinates)."""
        inverse = scipy.linalg.inv(self.covariance)
        return np.asarray((inverse + inverse.T) / 2)

    @property
    def variance_of_zero_remainder(self) -> float:
        """Variance of the remainder along z, by the zero and by the noise."""
        return float(self.zero_remainder @ self.zero_remainder) + self.noise**2

    @property
    def weighted_remainder(self) -> FloatArray:
        """Inverse covariance of the remainder times the remainder, shape (points,)."""
        # the error of the zero, in its standard deviations, that the remainder suggests
        zero_in_sds = (self.zero_remainder @ self.remainder) / self.variance_of_zero_remainder
        return (self.remainder - self.zero_remainder * zero_in_sds) / self.noise**2

    @property
    def squares_per_point(self) -> float:
        """Square of the distance of all errors from 0, by their covariance, per point."""
        squares = self.error @ self.precision @ self.error
        squares += self.remainder @ self.weighted_remainder
        return float(squares) / len(self.point_indices)

    def point_scores(self) -> FloatArray:
        """Error of each point over its standard deviation, given all other points."""
        weights = self.vectors @ (self.precision @ self.error)
        weights += self.weighted_remainder
        share_of_zero = self.zero_remainder**2 / self.variance_of_zero_remainder
        share_of_noise = 1 - np.sum(self.vectors**2, axis=1) - share_of_zero
        noise_precision = share_of_noise / self.noise**2
        precision = np.sum((self.vectors @ self.precision) * self.vectors, axis=1) + noise_precision
        return np.abs(weights) / np.sqrt(precision)

    def deviations(self) -> FloatArray:
        """ln of each measured mu over the one that the other curves predict, shape (points,)."""
        return self.vectors @ self.error + self.remainder

    def expected_mu(self) -> FloatArray:
        """mu as the other curves predict it, shape (points,)."""
        return np.exp(np.minimum(self.log_mu - self.deviations(), _LARGEST_EXPECTED_LOG_MU))

    def log_mu_sds(self) -> FloatArray:
        """Standard deviation of each deviation, shape (points,)."""
        noise_variance = self.noise**2 * (1 - np.sum(self.vectors**2, axis=1))
        noise_variance += self.zero_remainder**2
        variance = np.sum((self.vectors @ self.covariance) * self.vectors, axis=1) + noise_variance
        return np.sqrt(variance)

    def farthest_point(self) -> int:
        """Index within the curve of the point that `CurveShape.point_index` describes."""
        point_scores = self.point_scores()
        # without a point, the squared distance is smaller by the square of its score
        half_of_squares = self.squares_per_point * len(self.point_indices) / 2
        if point_scores.max() ** 2 > half_of_squares:
            return int(first_largest(point_scores))
        return int(first_largest(np.abs(self.deviations()) / self.log_mu_sds()))

    def oddness(self, limits: OddnessLimits) -> float:
        """See `CurveShape.oddness`.

        Args:
            limits: When a curve is odd.
        """
        largest_score = float(self.point_scores().max())
        significance = max(largest_score / limits.point, self.squares_per_point / limits.curve)
        deviations = np.abs(self.deviations())
        # near zero traction a large share of mu may be the zero of the run
        is_beyond_zero = deviations * self.expected_mu() > self.largest_zero
        largest_deviation = float(np.max(deviations, where=is_beyond_zero, initial=0.0))
        return min(significance, largest_deviation / _ODD_DEVIATION)


@dataclass(frozen=True)
class CurveJudge:
    """Judges each curve by some others, with the covariance among them.

    Attributes:
        curves: The curves.
        covariance: Their covariance, shape (coordinates, coordinates).
        noise: Standard deviation of the noise of points.
        law_log_mu: ln mu of the law at each point, shape (points,).
        zero_remainder: z of each curve, shape (points,).
        largest_zero: Largest error of the zero, as a traction coefficient.
    """

    curves: ReducedCurves
    covariance: FloatArray
    noise: float
    law_log_mu: FloatArray
    zero_remainder: FloatArray
    largest_zero: float

    @cached_property
    def log_mu(self) -> FloatArray:
        """Measured ln mu of each point, linearised near zero, shape (points,)."""
        departure = self.curves.vectors @ self.curves.departure + self.curves.remainder
        return self.law_log_mu + departure

    @cached_property
    def indices_and_vectors_of_curves(self) -> list[tuple[IndexArray, IndexArray, FloatArray]]:
        """Indices of the coordinates, indices of the points, and V of each curve."""
        coordinate_indices_of_curves = coordinates_by_group(
            self.curves.curve_of_coordinate, np.arange(len(self.curves.conditions))
        )
        return [
            (coordinate_indices, *self.curves.vectors_of(coordinate_indices))
            for coordinate_indices in coordinate_indices_of_curves
        ]

    def predicted_curves(self, retained_curves: IndexArray) -> Iterator[PredictedCurve]:
        """Each curve, as the retained curves other than itself predict it.

        Args:
            retained_curves: Indices of the retained curves, in ascending order.
        """
        curve_count = len(self.curves.conditions)
        is_retained = np.isin(np.arange(curve_count), retained_curves)
        retained_coordinates = np.flatnonzero(is_retained[self.curves.curve_of_coordinate])
        position_in_retained = np.zeros(len(self.curves.curve_of_coordinate), dtype=np.int64)
        position_in_retained[retained_coordinates] = np.arange(len(retained_coordinates))
        inverse = scipy.linalg.inv(
            self.covariance[np.ix_(retained_coordinates, retained_coordinates)]
        )
        solved_departure = inverse @ self.curves.departure[retained_coordinates]
        for curve_index, (coordinate_indices, point_indices, vectors) in enumerate(
            self.indices_and_vectors_of_curves
        ):
            if is_retained[curve_index]:
                positions = position_in_retained[coordinate_indices]
                error_covariance = scipy.linalg.inv(inverse[np.ix_(positions, positions)])
                error = error_covariance @ solved_departure[positions]
            else:
                cross_covariance = self.covariance[np.ix_(coordinate_indices, retained_coordinates)]
                error_covariance = self.covariance[np.ix_(coordinate_indices, coordinate_indices)]
                error_covariance = (
                    error_covariance - cross_covariance @ inverse @ cross_covariance.T
                )
                error = (
                    self.curves.departure[coordinate_indices] - cross_covariance @ solved_departure
                )
            remainder = self.curves.remainder[point_indices]
            error_covariance = (error_covariance + error_covariance.T) / 2
            yield PredictedCurve(
                point_indices,
                vectors,
                error,
                error_covariance,
                remainder,
                self.zero_remainder[point_indices],
                self.noise,
                self.log_mu[point_indices],
                self.largest_zero,
            )

    def oddness_of_curves(
        self, retained_curves: IndexArray, limits: OddnessLimits = _LIMITS_BY_RETAINED
    ) -> FloatArray:
        """`PredictedCurve.oddness` of each curve, shape (curves,)."""
        return np.array(
            [
                predicted_curve.oddness(limits)
                for predicted_curve in self.predicted_curves(retained_curves)
            ]
        )

    def agreeing_curves_from(self, retained_curves: IndexArray) -> IndexArray:
        """Indices of the curves that agree with each other: all that agree are retained, no others.

        Args:
            retained_curves: Indices of curves to begin with, most of which agree.
        """
        curve_count = len(self.curves.conditions)
        most_left_out = int(_MOST_LEFT_OUT_SHARE * curve_count)
        fewest_retained = max(_FEWEST_RETAINED_CURVES, curve_count - most_left_out)
        for _ in range(2 * curve_count):
            oddness = self.oddness_of_curves(retained_curves)
            is_retained = np.isin(np.arange(curve_count), retained_curves)
            returning_curves = np.flatnonzero(~is_retained & (oddness <= 1))
            worst_curve = int(first_largest(np.where(is_retained, oddness, 0.0)))
            if len(returning_curves):
                retained_curves = np.sort(np.append(retained_curves, returning_curves))
            elif oddness[worst_curve] > 1 and len(retained_curves) > fewest_retained:
                retained_curves = retained_curves[retained_curves != worst_curve]
            else:
                break
        return retained_curves

    def most_agreeing_curves(self) -> IndexArray:
        """Indices of the curves that remain when a quarter has been left out, the worst first."""
        curve_count = len(self.curves.conditions)
        retained_curves = np.arange(curve_count)
        for _ in range(int(_FIRST_LEFT_OUT_SHARE * curve_count)):
            worst_position = int(
                first_largest(self.oddness_of_curves(retained_curves)[retained_curves])
            )
            retained_curves = np.delete(retained_curves, worst_position)
        return retained_curves


@dataclass(frozen=True)
class _RobustFit:
    """A law and the sizes of a surface about it, fitted to the retained curves.

    Attributes:
        law: The law.
        log_mu: ln mu of the surface.
        logarithms: Logarithms of the sizes, in the order of `reml.size_names`.
        zero_sd: Standard deviation of the zero, as a traction coefficient.
    """

    law: FreeLaw
    log_mu: LogMu
    logarithms: FloatArray
    zero_sd: float

    def judge(self, measurements: Measurements, box: ConditionBox) -> CurveJudge:
        """The judge of some curves."""
        largest_zero = _LARGEST_ZERO_IN_SDS * self.zero_sd
        curves = reduced_curves(measurements, self.law, self.log_mu, largest_zero, box)
        sizes = Sizes.from_logarithms(self.logarithms)
        covariance = CurveCovariance(curves, box, sizes)
        conditions, slip = measurements.point_conditions, measurements.slip
        # a zero of 1 changes ln mu by 1/mu
        effect_of_zero = np.exp(-floored_log_mu(self.log_mu, largest_zero)(conditions, slip))
        return CurveJudge(
            curves,
            covariance.matrix(),
            sizes.noise,
            law_log_mu=self.law.log_mu(conditions, slip),
            zero_remainder=curves.remainder_of(self.zero_sd * effect_of_zero),
            largest_zero=largest_zero,
        )


@with_one_blas_thread
def curve_shapes(
    measurements: Measurements, law: Law, error_priors: ErrorPriors | None = None
) -> tuple[CurveShape, ...]:
    """How each curve agrees with the others that do not contradict each other, in their order.

    Args:
        measurements: The points; five curves or more.
        law: A law of the maximum Hertz pressure, the speed and the temperature.
        error_priors: Priors of the sizes of the errors of the rig.

    Raises:
        ValueError: There are fewer curves.
        NoClearTractionError: No point is clear of zero traction.
    """
    error_priors = error_priors or ErrorPriors()
    if len(measurements.conditions) < FEWEST_CURVES:
        raise ValueError(f"{len(measurements.conditions)} curves; expected {FEWEST_CURVES} or more")
    # every point counts alike: the noise of a point is part of what is judged
    measurements = replace(measurements, noise_ratio=None)
    curve_order, point_order = measurements.canonical_order()
    ordered = measurements.in_canonical_order()
    box = box_of(ordered)
    sample = ordered.select_curves(_sample_curves(ordered))
    fit = _fit_without_odd_curves(sample, law, error_priors, box)
    fit_of_all: _RobustFit | None = None
    shapes: list[CurveShape] = []
    for curves_of_part in _curve_parts(scaled_conditions(ordered.conditions)):
        points_of_part = np.flatnonzero(np.isin(ordered.curve_of_point, curves_of_part))
        measurements_of_part = ordered.select_curves(curves_of_part)
        judge = fit.judge(measurements_of_part, box)
        all_curves = np.arange(len(curves_of_part))
        retained_curves = judge.agreeing_curves_from(all_curves)
        oddness_by_all_curves = np.full(len(curves_of_part), np.inf)
        if len(retained_curves) < len(curves_of_part):
            # most campaigns have no odd curve, and their search of sizes is spared
            fit_of_all = fit_of_all or _next_fit(
                sample, _known_error_priors(fit, error_priors), box, fit
            )
            judge_by_all = fit_of_all.judge(measurements_of_part, box)
            oddness_by_all_curves = judge_by_all.oddness_of_curves(all_curves, _LIMITS_BY_ALL)
        # where retained curves contradict each other, no majority says which of them are right
        oddness_of_retained = judge.oddness_of_curves(retained_curves)[retained_curves]
        oddness_cap = REFUSED_ODDNESS if np.any(oddness_of_retained > 1) else np.inf
        judged_curves = zip(
            curves_of_part,
            judge.predicted_curves(retained_curves),
            oddness_by_all_curves,
            strict=True,
        )
        for curve_index, predicted, oddness_by_all in judged_curves:
            point_indices = points_of_part[predicted.point_indices]
            shapes.append(
                _shape(
                    int(curve_order[curve_index]),
                    point_order[point_indices],
                    predicted,
                    min(oddness_by_all, oddness_cap),
                )
            )
    return tuple(sorted(shapes, key=lambda shape: shape.curve_index))


def _shape(
    curve_index: int, point_indices: IndexArray, predicted: PredictedCurve, oddness_cap: float
) -> CurveShape:
    """The `CurveShape` of a curve.

    Args:
        curve_index: Index of the curve in the measurements.
        point_indices: Indices of its points in the measurements, shape (points,).
        predicted: The curve as the others predict it.
        oddness_cap: Largest oddness that is stated.
    """
    log_mu_sds = predicted.log_mu_sds()
    farthest_point = predicted.farthest_point()
    return CurveShape(
        curve_index=curve_index,
        point_index=int(point_indices[farthest_point]),
        expected_mu=float(predicted.expected_mu()[farthest_point]),
        log_mu_sd=float(log_mu_sds[farthest_point]),
        median_log_mu_sd=float(np.median(log_mu_sds)),
        oddness=min(predicted.oddness(_LIMITS_BY_RETAINED), oddness_cap),
    )


def _fit_without_odd_curves(
    sample: Measurements, law: Law, error_priors: ErrorPriors, box: ConditionBox
) -> _RobustFit:
    """Law and sizes by the curves that do not contradict each other."""
    retained_curves = np.arange(len(sample.conditions))
    fit = _first_fit(sample, law, error_priors, box)
    agreeing_curves = fit.judge(sample, box).most_agreeing_curves()
    for _ in range(_MAX_ROUNDS):
        if np.array_equal(agreeing_curves, retained_curves):
            break
        retained_curves = agreeing_curves
        fit = _next_fit(sample.select_curves(retained_curves), error_priors, box, fit)
        agreeing_curves = fit.judge(sample, box).agreeing_curves_from(retained_curves)
    return fit


def _first_fit(
    measurements: Measurements, law: Law, error_priors: ErrorPriors, box: ConditionBox
) -> _RobustFit:
    """The law, and the prior medians of the sizes: a bad curve must not raise them.

    Points near zero traction do not count, because their logarithm needs a surface.

    Args:
        measurements: The points.
        law: The law to be fitted.
        error_priors: Priors of the sizes of the errors of the rig.
        box: The box of the tested conditions.
    """
    zero_sd = error_priors.zero.median
    fitted = quick_law(law, measurements, _LARGEST_ZERO_IN_SDS * zero_sd)
    is_clear = ~is_near_zero(measurements.mu, _LARGEST_ZERO_IN_SDS * zero_sd)
    if not is_clear.any():
        raise NoClearTractionError(
            "no mu is clear of the error of the zero; check the unit of mu and the zero of the rig"
        )
    curves = reduced_curves(
        measurements.select_points(is_clear), fitted, fitted.log_mu, zero_sd, box
    )
    logarithms = np.log([prior.median for prior in priors(error_priors, INTERVAL_KAPPA_PRIOR)])
    return _fit_with_surface(curves, fitted, logarithms, box)


def _next_fit(
    measurements: Measurements, error_priors: ErrorPriors, box: ConditionBox, previous: _RobustFit
) -> _RobustFit:
    """Law and sizes by the retained curves.

    Args:
        measurements: The points of the retained curves.
        error_priors: Priors of the sizes of the errors of the rig.
        box: The box of the tested conditions.
        previous: The fit of the round before.
    """
    largest_zero = _LARGEST_ZERO_IN_SDS * previous.zero_sd
    law = quick_law(previous.law.law, measurements, largest_zero, previous.law)
    curves = reduced_curves(measurements, law, previous.log_mu, largest_zero, box)
    # a search that did not end gives sizes that are good enough: faults are far beyond the limits
    most_likely = most_likely_sizes(
        curves, box, priors(error_priors, INTERVAL_KAPPA_PRIOR), previous.logarithms
    )
    return _fit_with_surface(curves, law, most_likely.logarithms, box)


def _known_error_priors(fit: _RobustFit, error_priors: ErrorPriors) -> ErrorPriors:
    """Priors that fix the sizes of the errors of the rig at those of a fit.

    Args:
        fit: The fit.
        error_priors: The priors before the fit; those of rigs stay.
    """
    names = (*EFFECT_NAMES, "noise")
    known_priors = {}
    for name, size in zip(names, np.exp(fit.logarithms[: len(names)]), strict=True):
        range_factor = np.exp(_KNOWN_LN_SD)
        known_priors[name] = LogNormal(
            median=float(size),
            ln_sd=_KNOWN_LN_SD,
            smallest=float(size / range_factor),
            largest=float(size * range_factor),
        )
    return replace(error_priors, **known_priors)


def _fit_with_surface(
    curves: ReducedCurves, law: FreeLaw, logarithms: FloatArray, box: ConditionBox
) -> _RobustFit:
    """A fit with the surface that its curves give."""
    covariance = CurveCovariance(curves, box, Sizes.from_logarithms(logarithms))
    posterior = DensePosterior(covariance)

    def log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """ln mu of the surface."""
        return log_mu_of(law, posterior, box, conditions, slip)

    return _RobustFit(law, log_mu, logarithms, float(covariance.sizes.effects[_ZERO_INDEX]))


def _sample_curves(ordered: Measurements) -> IndexArray:
    """Indices of curves that stand for all where law and sizes are fitted.

    Half of them are far from each other. The other half are the next ones in the canonical order,
    so that repeated runs show the effects of runs.
    """
    curve_count = len(ordered.conditions)
    if curve_count <= _SAMPLE_CURVE_COUNT:
        return np.arange(curve_count)
    chosen_curves = farthest_point_selection(
        scaled_conditions(ordered.conditions), _SAMPLE_CURVE_COUNT // 2
    )
    return np.union1d(chosen_curves, np.minimum(chosen_curves + 1, curve_count - 1))


def _curve_parts(conditions: FloatArray) -> list[IndexArray]:
    """Indices of the curves of each part; the curves of a part are judged together.

    A part that is too large is cut in halves along its widest condition.

    Args:
        conditions: Scaled conditions of the curves, shape (curves, 3).
    """
    finished_parts: list[IndexArray] = []
    open_parts = [np.arange(len(conditions))]
    while open_parts:
        curve_indices = open_parts.pop()
        if len(curve_indices) <= _LARGEST_PART_CURVE_COUNT:
            finished_parts.append(curve_indices)
            continue
        widest_condition = int(first_largest(np.ptp(conditions[curve_indices], axis=0)))
        sorted_curves = curve_indices[
            np.argsort(conditions[curve_indices, widest_condition], kind="stable")
        ]
        middle = len(curve_indices) // 2
        open_parts += [np.sort(sorted_curves[:middle]), np.sort(sorted_curves[middle:])]
    return finished_parts
