"""The surface of one oil on one rig: fit and prediction.

Decides: how a surface is fitted, and how many conditions represent a large campaign.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECT_NAMES, ErrorPriors, LogMu, LogNormal, effect_design
from oilfilm.surface.interval import IntervalFactors, interval_factors
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.law_mean import CONSTANT_SD, FreeLaw
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements, rigs_by_first_curve, scaled_conditions
from oilfilm.surface.posterior import (
    DensePosterior,
    NystromPosterior,
    Posterior,
    farthest_point_selection,
)
from oilfilm.surface.reduction import (
    ANOTHER_RIG,
    Coordinates,
    ReducedCurves,
    box_of,
    coordinates_at_points,
    is_near_zero,
    reduced_curves,
    slopes_of_law,
)
from oilfilm.surface.reml import (
    INTERVAL_KAPPA_PRIOR,
    MISFIT_KAPPA_PRIOR,
    CurveCovariance,
    Sizes,
    most_likely_sizes,
    priors,
)
from oilfilm.surface.rig_gain import factor_of_another_rig, resolved_gain_count
from oilfilm.surface.support import SlipCoverage, support_codes
from oilfilm.surface.threads import with_one_blas_thread

# Largest number of curves whose posterior is exact. In a larger campaign it is approximated by
# representative conditions, far from each other (inducing points).
LARGEST_EXACT_CURVE_COUNT = 150
# Number of these representative conditions.
_INDUCING_CONDITIONS = 60
# Number of curves at which the sizes of a larger campaign are searched. The time of the search
# grows with their third power.
CURVE_COUNT_FOR_SIZES = 90
# Number of points that are predicted at once.
_POINTS_AT_ONCE = 2000
# The standard errors by the model are smaller than the errors of simulated fits by this factor.
_ERROR_INFLATION = 1.3
_ZERO_INDEX = EFFECT_NAMES.index("zero")


@dataclass(frozen=True)
class Prediction:
    """mu at some points, as the measurements and the law give it.

    Attributes:
        mu: Traction coefficient, shape (points,).
        surface_sd: Standard deviation of ln mu, shape (points,).
        next_run_sd: Standard deviation of ln mu as the next run would measure it, shape (points,).
        support_codes: Code of `oilfilm.surface.support.Support`, shape (points,).
    """

    mu: FloatArray
    surface_sd: FloatArray
    next_run_sd: FloatArray
    support_codes: IndexArray

    def interval(self, factor: float) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limit of mu in the next run; nan where there is no support.

        Args:
            factor: `point` or `curve` of `IntervalFactors`.
        """
        ln_half_width = np.where(self.support_codes == 0, factor * self.next_run_sd, np.nan)
        # where mu is nearly 0, the error of the zero is so many times mu that no limit is known
        with np.errstate(over="ignore"):
            return self.mu * np.exp(-ln_half_width), self.mu * np.exp(ln_half_width)


@dataclass(frozen=True)
class LawVerdict:
    """What the measurements say of the law.

    Attributes:
        kappa: Size of one term of the departure from the law, in ln mu, as in `DepartureSizes`; the
            whole departure is some three times as large. The misfit at the measured points is
            another number.
        constants: Free internal constants, shape (free constants,).
        standard_errors: Their standard errors, shape (free constants,). They have a meaning only
            where the law fits.
    """

    kappa: float
    constants: FloatArray
    standard_errors: FloatArray


@dataclass(frozen=True)
class Surface:
    """mu of one oil on one rig over slip, pressure, speed and temperature.

    Attributes:
        law: The law about which the surface is fitted.
        posterior: The departure from the law, given the curves.
        covariance: Covariance of the curves.
        slip_coverage: The tested slips, and how densely they were tested.
        measurements: The points, in canonical order.
        verdict: What the measurements say of the law.
        misfit_covariance: Covariance of the curves without the caution of intervals.
        limits: What an answer must fulfil.
        rig_gain_prior: Prior of the standard deviation of the gains of rigs.
        converged: Whether both searches for the most likely sizes found a maximum: that for the
            verdict and the cautious one for intervals. If not, the sizes are those of the last
            step.
    """

    law: FreeLaw
    posterior: Posterior
    covariance: CurveCovariance
    slip_coverage: SlipCoverage
    measurements: Measurements
    verdict: LawVerdict
    misfit_covariance: CurveCovariance
    limits: SurfaceLimits
    rig_gain_prior: LogNormal
    converged: bool

    @with_one_blas_thread
    def log_mu(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """ln mu, shape (points,).

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slip: Slide-roll ratio, above 0, shape (points,).
        """
        return log_mu_of(self.law, self.posterior, self.covariance.box, conditions, slip)

    def is_law_positive(self, conditions: FloatArray, slip: FloatArray) -> BoolArray:
        """Whether the law gives traction above 0, also at the ends of the box, shape (points,).

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slip: Slide-roll ratio, above 0, shape (points,).
        """
        slopes = slopes_of_law(self.law, self.covariance.box, conditions, slip)
        has_slopes = np.isfinite(slopes).all(axis=1)
        return np.asarray(has_slopes & np.isfinite(self.law.log_mu(conditions, slip)))

    @with_one_blas_thread
    def predict(
        self, conditions: FloatArray, slip: FloatArray, rig_number: int | None = None
    ) -> Prediction:
        """mu at some points, with its errors and its support.

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slip: Slide-roll ratio, above 0, shape (points,).
            rig_number: Number of the rig of the next run, as in the measurements, or `ANOTHER_RIG`.
                If it is not given, the next run is on one of the rigs of the measurements.

        Raises:
            ValueError: A slip is not above 0, or no run is of this rig.
        """
        if not np.all(slip > 0):
            raise ValueError("a slip is not above 0; at pure rolling mu is 0, without an interval")
        rig_numbers = self._rigs_of_next_run(rig_number)
        another_rig_sd = 0.0
        if rig_number == ANOTHER_RIG and self.covariance.sizes.rig_gain:
            another_rig_sd = self._gain_of_another_rig_sd
        noise_sd = self.covariance.sizes.noise * self.measurements.noise_ratio_at(slip)
        noise_and_rig_sd = np.hypot(noise_sd, another_rig_sd)
        blocks = [
            self._predict_block(
                conditions[block], slip[block], noise_and_rig_sd[block], rig_numbers
            )
            for block in _blocks(len(slip))
        ]
        return Prediction(
            mu=np.concatenate([block.mu for block in blocks]),
            surface_sd=np.concatenate([block.surface_sd for block in blocks]),
            next_run_sd=np.concatenate([block.next_run_sd for block in blocks]),
            support_codes=np.concatenate([block.support_codes for block in blocks]),
        )

    def _predict_block(
        self,
        conditions: FloatArray,
        slip: FloatArray,
        noise_and_rig_sd: FloatArray,
        rig_numbers: list[int],
    ) -> Prediction:
        """mu at as many points as are predicted at once.

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slip: Slide-roll ratio, above 0, shape (points,).
            noise_and_rig_sd: Standard deviation of ln mu by noise and by the gain of another rig,
                shape (points,).
            rig_numbers: Numbers of the rigs on one of which the next run is.
        """
        box = self.covariance.box
        targets = coordinates_at_points(self.law, box, conditions, slip)
        departure, surface_variance = self._departure_on_rigs(targets, rig_numbers)
        slopes_by_effect = effect_design(self.log_mu, conditions, slip)
        sd_by_effect = slopes_by_effect * self.covariance.sizes.effects
        surface_sd = np.sqrt(surface_variance)
        distance_in_ranges = box.distance_in_ranges(targets.conditions)[
            targets.condition_of_coordinate
        ]
        return Prediction(
            mu=np.exp(self.law.log_mu(conditions, slip) + departure),
            surface_sd=surface_sd,
            next_run_sd=np.sqrt(
                surface_variance + np.sum(sd_by_effect**2, axis=1) + noise_and_rig_sd**2
            ),
            support_codes=support_codes(
                self.limits,
                self.slip_coverage,
                slip,
                surface_sd,
                self._spread_of_bounds(targets.law_slopes),
                distance_in_ranges,
            ),
        )

    def sd_by_runs(self, effect_sizes: FloatArray) -> FloatArray:
        """Standard deviation of ln mu by the errors of runs at `measurements`, shape (points,).

        Args:
            effect_sizes: Sizes of the effects of runs, in the order of `EFFECT_NAMES`.
        """
        conditions, slip = self.measurements.point_conditions, self.measurements.slip
        sd_of_blocks = []
        for block in _blocks(len(slip)):
            slopes = effect_design(self.log_mu, conditions[block], slip[block])
            sd_of_blocks.append(np.linalg.norm(slopes * effect_sizes, axis=1))
        return np.concatenate(sd_of_blocks)

    def _rigs_of_next_run(self, rig_number: int | None) -> list[int]:
        """Numbers of the rigs on one of which the next run is; `ANOTHER_RIG` is a gain of 0.

        Args:
            rig_number: As in `predict`.

        Raises:
            ValueError: No run is of this rig.
        """
        tested_rigs: list[int] = []
        if self.measurements.rig_of_curve is not None:
            tested_rigs = rigs_by_first_curve(self.measurements.rig_of_curve).tolist()
        if rig_number is not None and rig_number != ANOTHER_RIG and rig_number not in tested_rigs:
            raise ValueError(f"no run is of the rig number {rig_number}")
        if not self.covariance.sizes.rig_gain:
            # one rig, or rigs that are not named: their gain is part of the surface
            return [ANOTHER_RIG]
        return tested_rigs if rig_number is None else [rig_number]

    def _departure_on_rigs(
        self, targets: Coordinates, rig_numbers: list[int]
    ) -> tuple[FloatArray, FloatArray]:
        """Mean and variance of the departure on one of some rigs, shape (points,) each.

        Args:
            targets: The points.
            rig_numbers: Numbers of the rigs; the next run is equally likely on each of them.
        """
        means, variances = [], []
        for rig_number in rig_numbers:
            on_rig = replace(
                targets, rig_of_coordinate=np.full(len(targets.condition_of_coordinate), rig_number)
            )
            means.append(self.posterior.mean(on_rig))
            variances.append(self.posterior.variance(on_rig))
        return np.mean(means, axis=0), np.mean(variances, axis=0) + np.var(means, axis=0)

    @cached_property
    def _gain_of_another_rig_sd(self) -> float:
        """Standard deviation of the gain of another rig: few rigs show how large it may be."""
        gain_sd = self.covariance.sizes.rig_gain
        slopes = gain_sd * self.covariance.curves.gains_by_rig
        gain_count = resolved_gain_count(self.posterior.parameter_posterior(slopes).covariance)
        return gain_sd * factor_of_another_rig(
            gain_sd, gain_count, self.rig_gain_prior, self.limits.level
        )

    @cached_property
    def interval_factors(self) -> IntervalFactors:
        """Factors on the standard deviation of the next run, from left-out conditions."""
        return _interval_factors(self)

    def effect_sizes(self) -> dict[str, float]:
        """Standard deviation of each effect of runs, by name."""
        return dict(zip(EFFECT_NAMES, self.covariance.sizes.effects.tolist(), strict=True))

    def _spread_of_bounds(self, law_slopes: FloatArray) -> FloatArray:
        """Standard deviation of ln mu by each constant that is at its bound.

        Args:
            law_slopes: Slopes of the law, as `slopes_of_law` has them, shape (points, slopes).
        """
        bound_columns = np.flatnonzero(self.law.is_at_bound())
        _, remaining_covariance = self.posterior.parameter_posterior(
            self.covariance.curves.law_slopes
        )
        share_left = np.sqrt(np.diag(remaining_covariance))
        return np.abs(law_slopes[:, bound_columns]) * share_left[bound_columns]


@with_one_blas_thread
def _interval_factors(surface: Surface) -> IntervalFactors:
    """See `Surface.interval_factors`."""
    condition_of_curve = surface.measurements.condition_of_curve()
    if condition_of_curve.max() == 0:
        # With one condition nothing is known of other conditions: its runs are left out one by one.
        condition_of_curve = np.arange(len(condition_of_curve))
    return interval_factors(
        surface.covariance,
        surface.measurements.curve_of_point,
        condition_of_curve,
        surface.posterior.leave_groups_out(condition_of_curve),
        surface.limits.level,
    )


@dataclass(frozen=True)
class SurfaceSizes:
    """The sizes of a surface, as logarithms in the order of `oilfilm.surface.reml.size_names`.

    With the points and the law they give the whole surface, without a search.

    Attributes:
        first: Sizes of the first surface, which takes the points clear of zero traction.
        misfit: Most likely sizes with a wide prior of the misfit of the law.
        interval: Most likely sizes with the cautious prior that intervals need. Rigs are told apart
            only here, where the runs are of several rigs: a change from rig to rig is a change
            that `misfit` must show.
        converged: Whether both searches found a maximum. If not, the sizes are those of the last
            step.
    """

    first: FloatArray
    misfit: FloatArray
    interval: FloatArray
    converged: bool


def fit_surface(
    measurements: Measurements,
    law: FreeLaw,
    error_priors: ErrorPriors | None = None,
    limits: SurfaceLimits | None = None,
) -> Surface:
    """The surface of measured points about a fitted law.

    Args:
        measurements: The points, in any order.
        law: The best fitted law.
        error_priors: Priors of the sizes of the errors of the rig.
        limits: What an answer must fulfil.

    Raises:
        ValueError: No point is clear of zero traction.
    """
    error_priors = error_priors or ErrorPriors()
    sizes = most_likely_surface_sizes(measurements, law, error_priors)
    return surface_from_sizes(measurements, law, error_priors, sizes, limits)


@with_one_blas_thread
def most_likely_surface_sizes(
    measurements: Measurements, law: FreeLaw, error_priors: ErrorPriors
) -> SurfaceSizes:
    """The most likely sizes of a surface.

    The first surface takes the points clear of zero traction, and the slopes of the law. The second
    one takes all points, and the slopes of the first.

    Args:
        measurements: The points, in any order.
        law: The best fitted law.
        error_priors: Priors of the sizes of the errors of the rig.

    Raises:
        ValueError: No point is clear of zero traction.
    """
    ordered = measurements.in_canonical_order()
    box = box_of(ordered)
    sample = _sample(ordered)
    first_curves = _clear_curves(sample, law, error_priors, box)
    first = most_likely_sizes(first_curves, box, priors(error_priors, INTERVAL_KAPPA_PRIOR))
    log_mu, zero_sd = _first_surface(first_curves, law, error_priors, box, first.sizes)
    curves = reduced_curves(sample, law, log_mu, zero_sd, box)
    misfit_sizes = most_likely_sizes(
        curves, box, priors(error_priors, MISFIT_KAPPA_PRIOR), first.logarithms
    )
    tells_rigs_apart = sample.rig_count > 1
    cautious_priors = priors(error_priors, INTERVAL_KAPPA_PRIOR, tells_rigs_apart=tells_rigs_apart)
    start = first.logarithms
    if tells_rigs_apart:
        start = np.append(start, np.log([error_priors.rig_gain.median]))
    cautious = most_likely_sizes(curves, box, cautious_priors, start)
    return SurfaceSizes(
        first=first.logarithms,
        misfit=misfit_sizes.logarithms,
        interval=cautious.logarithms,
        converged=misfit_sizes.converged and cautious.converged,
    )


@with_one_blas_thread
def surface_from_sizes(
    measurements: Measurements,
    law: FreeLaw,
    error_priors: ErrorPriors,
    sizes: SurfaceSizes,
    limits: SurfaceLimits | None = None,
) -> Surface:
    """The surface of measured points, a law and known sizes.

    Args:
        measurements: The points, in any order.
        law: The law of the search.
        error_priors: Priors of the sizes of the errors of the rig, as in the search.
        sizes: The sizes.
        limits: What an answer must fulfil.
    """
    ordered = measurements.in_canonical_order()
    box = box_of(ordered)
    first_curves = _clear_curves(_sample(ordered), law, error_priors, box)
    first_sizes = Sizes.from_logarithms(sizes.first)
    log_mu, zero_sd = _first_surface(first_curves, law, error_priors, box, first_sizes)
    curves = reduced_curves(ordered, law, log_mu, zero_sd, box)
    posterior, covariance = _posterior(curves, box, Sizes.from_logarithms(sizes.interval))
    misfit_posterior, misfit_covariance = _posterior(
        curves, box, Sizes.from_logarithms(sizes.misfit)
    )
    return Surface(
        law=law,
        posterior=posterior,
        covariance=covariance,
        slip_coverage=SlipCoverage.from_measurements(ordered),
        measurements=ordered,
        verdict=_verdict(law, misfit_posterior, misfit_covariance),
        misfit_covariance=misfit_covariance,
        limits=limits or SurfaceLimits(),
        rig_gain_prior=error_priors.rig_gain,
        converged=sizes.converged,
    )


def _clear_curves(
    sample: Measurements, law: FreeLaw, error_priors: ErrorPriors, box: ConditionBox
) -> ReducedCurves:
    """The curves of the points that are clear of zero traction, where ln mu is safe.

    Raises:
        ValueError: No point is clear of zero traction.
    """
    zero_sd = error_priors.zero.median
    is_clear = ~is_near_zero(sample.mu, zero_sd)
    if not is_clear.any():
        raise ValueError(
            f"no mu is above ten times the error of the zero, {zero_sd:g}; check the unit of mu "
            "and the zero of the rig"
        )
    return reduced_curves(sample.select_points(is_clear), law, law.log_mu, zero_sd, box)


def _first_surface(
    curves: ReducedCurves, law: FreeLaw, error_priors: ErrorPriors, box: ConditionBox, sizes: Sizes
) -> tuple[LogMu, float]:
    """ln mu of the first surface, and the standard deviation of the zero."""
    covariance = CurveCovariance(curves, box, sizes)
    posterior = DensePosterior(covariance)

    def log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """ln mu of the first surface."""
        return log_mu_of(law, posterior, box, conditions, slip)

    # a rig may have a larger zero than it states: more points are then near zero
    return log_mu, max(error_priors.zero.median, float(sizes.effects[_ZERO_INDEX]))


def log_mu_of(
    law: FreeLaw, posterior: Posterior, box: ConditionBox, conditions: FloatArray, slip: FloatArray
) -> FloatArray:
    """ln mu of a surface: that of the law plus the departure from it, shape (points,)."""
    log_mu_of_blocks = [np.empty(0)]
    for block in _blocks(len(slip)):
        targets = coordinates_at_points(law, box, conditions[block], slip[block])
        log_mu_of_blocks.append(
            law.log_mu(conditions[block], slip[block]) + posterior.mean(targets)
        )
    return np.concatenate(log_mu_of_blocks)


def _posterior(
    curves: ReducedCurves, box: ConditionBox, sizes: Sizes
) -> tuple[Posterior, CurveCovariance]:
    """The posterior of curves: exact where they are few."""
    covariance = CurveCovariance(curves, box, sizes)
    if len(curves.conditions) <= LARGEST_EXACT_CURVE_COUNT:
        return DensePosterior(covariance), covariance
    curves_for_conditions = farthest_point_selection(curves.conditions, _INDUCING_CONDITIONS)
    # without an inducing curve of a rig, its runs would share no gain
    _, curves_for_rigs = np.unique(curves.rig_of_curve, return_index=True)
    chosen_curves = (
        np.union1d(curves_for_conditions, curves_for_rigs)
        if covariance.sizes.rig_gain
        else curves_for_conditions
    )
    inducing_indices = np.flatnonzero(np.isin(curves.curve_of_coordinate, chosen_curves))
    return NystromPosterior(covariance, inducing_indices), covariance


def _verdict(law: FreeLaw, posterior: Posterior, covariance: CurveCovariance) -> LawVerdict:
    """What the measurements say of the law.

    Args:
        law: The law.
        posterior: The departure from the law, without the caution of intervals.
        covariance: Covariance of the curves.
    """
    change_of_law, remaining_covariance = posterior.parameter_posterior(
        covariance.curves.law_slopes
    )
    free_count = np.count_nonzero(law.is_free)
    constants = law.constants[law.is_free] + CONSTANT_SD * change_of_law[:free_count]
    standard_errors = (
        _ERROR_INFLATION * CONSTANT_SD * np.sqrt(np.diag(remaining_covariance)[:free_count])
    )
    return LawVerdict(float(covariance.sizes.departure_sizes.kappa), constants, standard_errors)


def _sample(ordered: Measurements) -> Measurements:
    """Representative curves at which the sizes are searched; all of them if they are few.

    Half of them are far from each other. The other half are the curves nearest to these in the
    canonical order, so that repeated runs show the effects of runs.
    """
    curve_count = len(ordered.conditions)
    if curve_count <= CURVE_COUNT_FOR_SIZES:
        return ordered
    chosen_curves = farthest_point_selection(
        scaled_conditions(ordered.conditions), CURVE_COUNT_FOR_SIZES // 2
    )
    next_curves = np.minimum(chosen_curves + 1, curve_count - 1)
    curve_indices = np.union1d(chosen_curves, next_curves)
    if ordered.rig_of_curve is not None:
        # a rig of few runs also shows how rigs differ
        _, first_curves_of_rigs = np.unique(ordered.rig_of_curve, return_index=True)
        curve_indices = np.union1d(curve_indices, first_curves_of_rigs)
    return ordered.select_curves(curve_indices)


def _blocks(point_count: int) -> Iterator[slice]:
    """Slices of the points that are predicted at once."""
    for first_point in range(0, point_count, _POINTS_AT_ONCE):
        yield slice(first_point, first_point + _POINTS_AT_ONCE)
