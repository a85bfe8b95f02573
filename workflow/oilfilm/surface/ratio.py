"""The ratio of mu of two oils at equal conditions: errors that both share cancel.

One model describes the runs of both oils (`pair_covariance`). A run needs no partner with the same
slips. Where only one oil was tested, the part that both share is interpolated as far as it is
smooth, and the interval is wider.

Both oils share the sizes of the effects of runs. A gain that all runs of one oil share is a part of
the ratio that no data can tell; so is the calibration, where each oil has a rig of its own.

Decides: how two oils are compared without a law.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECT_NAMES, ErrorPriors, LogMu, effect_design
from oilfilm.surface.interval import IntervalFactors, allowed_level, interval_factors
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements, scaled_conditions, scaled_slip
from oilfilm.surface.pair_covariance import (
    PairCovariance,
    PairSizes,
    most_likely_pair_sizes,
    pair_priors,
)
from oilfilm.surface.posterior import (
    LeftOutCurves,
    coordinates_by_group,
    farthest_point_selection,
    smooth_variance,
)
from oilfilm.surface.reduction import (
    ReducedCurves,
    box_of,
    coordinates_at_points,
    is_near_zero,
    reduced_curves,
    response,
)
from oilfilm.surface.support import SAME_SLIP, SlipCoverage, support_codes
from oilfilm.surface.threads import with_one_blas_thread

# Number of representative conditions, far from each other, to whose runs the ratio is fitted.
_CONDITION_COUNT_FOR_RATIO = 120
# Number of those at which the sizes are searched.
_CONDITION_COUNT_FOR_SIZES = 30
# Fewest points whose values are equal in one run only, even if they are rounded.
_FEWEST_POINTS_OF_SAME_RUN = 5


@dataclass(frozen=True)
class OilOfPair:
    """One oil of a pair.

    Attributes:
        measurements: Its points.
        law: Its fitted law.
    """

    measurements: Measurements
    law: FreeLaw


@dataclass(frozen=True)
class RunsOfPair:
    """The runs of two oils, as points; a run needs no partner.

    Attributes:
        first: Points of the first oil, in canonical order.
        second: Points of the second oil, in canonical order.
    """

    first: Measurements
    second: Measurements

    @cached_property
    def stacked(self) -> Measurements:
        """The points of both, as if they were one oil."""
        return Measurements(
            conditions=np.vstack([self.first.conditions, self.second.conditions]),
            curve_of_point=np.concatenate(
                [self.first.curve_of_point, self.second.curve_of_point + len(self.first.conditions)]
            ),
            slip=np.concatenate([self.first.slip, self.second.slip]),
            mu=np.concatenate([self.first.mu, self.second.mu]),
            noise_ratio=np.concatenate(
                [self.first.noise_ratio_of_points, self.second.noise_ratio_of_points]
            ),
            level_widths=self.first.level_widths,
        )

    @cached_property
    def oil_of_curve(self) -> IndexArray:
        """0 for curves of the first oil and 1 for those of the second, shape (curves,)."""
        return np.repeat([0, 1], [len(self.first.conditions), len(self.second.conditions)])

    @cached_property
    def condition_of_curve(self) -> IndexArray:
        """Index of the condition of each curve, shape (curves,); both oils share conditions."""
        return self.stacked.condition_of_curve()

    def is_paired(self) -> BoolArray:
        """Whether each condition was tested with both oils, shape (conditions,)."""
        condition_count = self.condition_of_curve.max() + 1
        conditions_of_first = self.condition_of_curve[self.oil_of_curve == 0]
        conditions_of_second = self.condition_of_curve[self.oil_of_curve == 1]
        has_first = np.bincount(conditions_of_first, minlength=condition_count) > 0
        has_second = np.bincount(conditions_of_second, minlength=condition_count) > 0
        return has_first & has_second

    def has_common_runs(self) -> bool:
        """Whether a curve of one oil has the same mu as a curve of the other.

        Rounded values of short curves may be equal by chance. These count where each curve of an
        oil is the same as one of the other.
        """
        mu_of_first, mu_of_second = _mu_of_curves(self.first), _mu_of_curves(self.second)
        common = mu_of_first & mu_of_second
        are_all_common = common in (mu_of_first, mu_of_second)
        return are_all_common or any(len(mu) >= _FEWEST_POINTS_OF_SAME_RUN for mu in common)

    def at_representative_conditions(self, condition_count: int) -> "RunsOfPair":
        """The points at some conditions that are far from each other; all points if there are few.

        Conditions that were tested with both oils are chosen first.
        """
        is_paired = self.is_paired()
        if len(is_paired) <= condition_count:
            return self
        _, first_curves = np.unique(self.condition_of_curve, return_index=True)
        scaled_distinct_conditions = scaled_conditions(self.stacked.conditions[first_curves])
        chosen_conditions = np.empty(0, dtype=np.int64)
        for condition_indices in (np.flatnonzero(is_paired), np.flatnonzero(~is_paired)):
            remaining_count = condition_count - len(chosen_conditions)
            if len(condition_indices) and remaining_count:
                chosen_conditions = np.append(
                    chosen_conditions,
                    condition_indices[
                        farthest_point_selection(
                            scaled_distinct_conditions[condition_indices], remaining_count
                        )
                    ],
                )
        is_chosen = np.isin(self.condition_of_curve, chosen_conditions)
        return RunsOfPair(
            self.first.select_curves(np.flatnonzero(is_chosen[self.oil_of_curve == 0])),
            self.second.select_curves(np.flatnonzero(is_chosen[self.oil_of_curve == 1])),
        )

    def clear_of_zero(self, zero_sd: float) -> "RunsOfPair":
        """The points that are clear of zero traction, where ln mu is safe.

        Raises:
            ValueError: An oil has no such point.
        """
        clear_measurements = []
        for measurements in (self.first, self.second):
            is_clear = ~is_near_zero(measurements.mu, zero_sd)
            if not is_clear.any():
                raise ValueError(
                    f"no mu of an oil is above ten times the error of the zero, {zero_sd:g}; check "
                    "the unit of mu and the zero of the rig"
                )
            clear_measurements.append(measurements.select_points(is_clear))
        return RunsOfPair(*clear_measurements)

    def reduced_curves(
        self, law: FreeLaw, log_mu_of_oils: tuple[LogMu, LogMu], zero_sd: float
    ) -> ReducedCurves:
        """The curves of both oils as coordinates.

        Args:
            law: The law about which both are described.
            log_mu_of_oils: ln mu of each oil by its present surface or law.
            zero_sd: Standard deviation of the zero, as a traction coefficient.
        """
        # departure, effect design and remainder depend on the oil, and are replaced below
        curves = reduced_curves(self.stacked, law, law.log_mu, zero_sd, box_of(self.stacked))
        departures, designs = [], []
        for measurements, log_mu_of_oil in zip(
            (self.first, self.second), log_mu_of_oils, strict=True
        ):
            law_log_mu = law.log_mu(measurements.point_conditions, measurements.slip)
            departures.append(response(measurements, log_mu_of_oil, zero_sd) - law_log_mu)
            designs.append(
                effect_design(log_mu_of_oil, measurements.point_conditions, measurements.slip)
            )
        weight = curves.weight_of_point
        weighted_departure = weight * np.concatenate(departures)
        departure = curves.vectors.T @ weighted_departure
        return replace(
            curves,
            departure=departure,
            effect_design=curves.vectors.T @ (weight[:, np.newaxis] * np.vstack(designs)),
            remainder=weighted_departure - curves.vectors @ departure,
        )


@dataclass(frozen=True)
class RatioPrediction:
    """The predicted ratio of two oils at some points.

    Attributes:
        ratio: mu of the second oil over that of the first, shape (points,).
        ln_ratio_sd: Standard deviation of its natural logarithm, shape (points,).
        support_codes: Code of `oilfilm.surface.support.Support`, shape (points,).
        is_outside: Whether a point is beyond the tested conditions or slips of an oil, shape
            (points,).
    """

    ratio: FloatArray
    ln_ratio_sd: FloatArray
    support_codes: IndexArray
    is_outside: BoolArray

    def interval(self, factor: float) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limit of the ratio; nan where there is no support.

        Args:
            factor: `point` or `curve` of `IntervalFactors`.
        """
        ln_half_width = np.where(self.support_codes == 0, factor * self.ln_ratio_sd, np.nan)
        return self.ratio * np.exp(-ln_half_width), self.ratio * np.exp(ln_half_width)


@dataclass(frozen=True)
class RatioSurface:
    """The ratio of two oils over slip, pressure, speed and temperature.

    Attributes:
        law: The law about which both oils are described.
        covariance: Covariance of the curves.
        runs: The points of both oils.
        sign: 1 for the ratio of the second oil of `runs` to the first, -1 for its inverse.
        limits: What an answer must fulfil.
        converged: Whether the search for the most likely sizes found a maximum. If not, the sizes
            are those of its last step.
    """

    law: FreeLaw
    covariance: PairCovariance
    runs: RunsOfPair
    sign: int
    limits: SurfaceLimits
    converged: bool

    @with_one_blas_thread
    def predict(self, conditions: FloatArray, slip: FloatArray) -> RatioPrediction:
        """The ratio at some points.

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slip: Slide-roll ratio, above 0, shape (points,).

        Raises:
            ValueError: A slip is not above 0.
        """
        if not np.all(slip > 0):
            raise ValueError("a slip is not above 0; at pure rolling both mu are 0")
        covariance = self.covariance
        targets = coordinates_at_points(
            self.law, covariance.common_covariance.box, conditions, slip
        )
        cross_covariance = covariance.ratio_covariance_at(targets)
        whitened_cross_covariance = scipy.linalg.solve_triangular(
            self.covariance_factor, cross_covariance.T, lower=True
        )
        variance = smooth_variance(
            covariance.ratio_covariance, covariance.with_ratio_slopes(targets)
        )
        ln_ratio_sd = np.sqrt(variance - np.sum(whitened_cross_covariance**2, axis=0))
        return RatioPrediction(
            ratio=np.exp(self.sign * (cross_covariance @ self.weights)),
            ln_ratio_sd=ln_ratio_sd,
            support_codes=self._support_codes(conditions, slip, ln_ratio_sd),
            is_outside=self._is_outside(conditions, slip),
        )

    @cached_property
    def interval_factors(self) -> IntervalFactors:
        """Factors on the standard deviation of the ratio, and the level that they allow.

        All conditions show how large the errors are. Only those of both oils raise the level.
        """
        return _interval_factors(self)

    def leave_conditions_out(self) -> list[LeftOutCurves]:
        """The runs of each oil at each condition, as all other runs predict them.

        Where the other oil was tested at the condition, its runs there predict them with the ratio
        at other conditions: the error is that of the ratio.
        """
        condition_and_oil = 2 * self.runs.condition_of_curve + self.runs.oil_of_curve
        _, group_of_curve = np.unique(condition_and_oil, return_inverse=True)
        inverse = self._inverse_times(np.eye(len(self.weights)))
        return [
            LeftOutCurves(
                coordinate_indices,
                inverse[np.ix_(coordinate_indices, coordinate_indices)],
                self.weights[coordinate_indices],
            )
            for coordinate_indices in coordinates_by_group(
                self.covariance.common_covariance.curves.curve_of_coordinate, group_of_curve.ravel()
            )
        ]

    def log_mu_of(self, oil_index: int) -> LogMu:
        """ln mu of the first (0) or the second (1) oil of `runs`."""

        def log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
            targets = coordinates_at_points(
                self.law, self.covariance.common_covariance.box, conditions, slip
            )
            departure = self.covariance.oil_covariance_at(targets, oil_index) @ self.weights
            return self.law.log_mu(conditions, slip) + departure

        return log_mu

    @cached_property
    def covariance_factor(self) -> FloatArray:
        """Lower Cholesky factor of the covariance of the coordinates."""
        return np.asarray(scipy.linalg.cholesky(self.covariance.matrix(), lower=True))

    @cached_property
    def weights(self) -> FloatArray:
        """K^-1 y, shape (coordinates,)."""
        return self._inverse_times(self.covariance.common_covariance.curves.departure)

    def _inverse_times(self, vectors: FloatArray) -> FloatArray:
        """K^-1 times vectors."""
        return np.asarray(scipy.linalg.cho_solve((self.covariance_factor, True), vectors))

    def _support_codes(
        self, conditions: FloatArray, slip: FloatArray, ln_ratio_sd: FloatArray
    ) -> IndexArray:
        """Code of `Support` of each point; where an oil has no support, its reason counts."""
        codes_of_oils = []
        for measurements in (self.runs.first, self.runs.second):
            box = box_of(measurements)
            codes_of_oils.append(
                support_codes(
                    self.limits,
                    SlipCoverage.from_measurements(measurements),
                    slip,
                    ln_ratio_sd,
                    # the ratio has no constants that could be at a bound
                    np.empty((len(slip), 0)),
                    box.distance_in_ranges(box.centred(scaled_conditions(conditions))),
                )
            )
        return np.maximum(*codes_of_oils)

    def _is_outside(self, conditions: FloatArray, slip: FloatArray) -> BoolArray:
        """Whether each point is beyond what was tested with an oil, shape (points,)."""
        scaled = scaled_conditions(conditions)
        new_slip = scaled_slip(slip)
        is_outside = np.zeros(len(slip), dtype=bool)
        for measurements in (self.runs.first, self.runs.second):
            box = box_of(measurements)
            distance_beyond = np.maximum(box.lowest - scaled, scaled - box.highest)
            is_outside |= np.any(distance_beyond > box.scaled_level_widths, axis=1)
            # without slip each mu is 0, which needs no test; their ratio there is not known
            tested_slip = scaled_slip(measurements.slip)
            is_outside |= new_slip < tested_slip.min() - SAME_SLIP
            is_outside |= new_slip > tested_slip.max() + SAME_SLIP
        return is_outside


@with_one_blas_thread
def _interval_factors(ratio_surface: RatioSurface) -> IntervalFactors:
    """See `RatioSurface.interval_factors`."""
    runs, wanted_level = ratio_surface.runs, ratio_surface.limits.level
    factors = interval_factors(
        ratio_surface.covariance.common_covariance,
        runs.stacked.curve_of_point,
        runs.condition_of_curve,
        ratio_surface.leave_conditions_out(),
        wanted_level,
    )
    paired_count = int(np.count_nonzero(runs.is_paired()))
    return replace(factors, level=allowed_level(wanted_level, paired_count))


@with_one_blas_thread
def fit_ratio(
    first: OilOfPair,
    second: OilOfPair,
    error_priors: ErrorPriors | None = None,
    limits: SurfaceLimits | None = None,
) -> RatioSurface:
    """The ratio of mu of the second oil to that of the first.

    A first surface takes the points clear of zero traction, the slopes of the laws and the prior
    medians of the sizes. The second one takes all points, and the slopes of the first.

    Args:
        first: The oil with which the other is compared.
        second: The other oil.
        error_priors: Priors of the sizes of the errors of the rig.
        limits: What an answer must fulfil.

    Raises:
        ValueError: A run belongs to both oils, or an oil has no point clear of zero traction.
    """
    error_priors, limits = error_priors or ErrorPriors(), limits or SurfaceLimits()
    (leading, other), sign = _in_canonical_order(first, second)
    law = leading.law
    runs = RunsOfPair(leading.measurements, other.measurements)
    if runs.has_common_runs():
        raise ValueError("a run belongs to both oils; a ratio needs other runs for each oil")
    sample = runs.at_representative_conditions(_CONDITION_COUNT_FOR_SIZES)
    size_priors, zero_sd = pair_priors(error_priors), error_priors.zero.median

    clear = sample.clear_of_zero(zero_sd)
    curves = clear.reduced_curves(law, (leading.law.log_mu, other.law.log_mu), zero_sd)
    prior_sizes = PairSizes.from_logarithms(np.log([prior.median for prior in size_priors]))
    pilot = RatioSurface(law, _covariance(clear, curves, prior_sizes), clear, sign, limits, True)
    log_mu_of_oils = (pilot.log_mu_of(0), pilot.log_mu_of(1))

    curves = sample.reduced_curves(law, log_mu_of_oils, zero_sd)
    most_likely = most_likely_pair_sizes(
        lambda sizes: _covariance(sample, curves, sizes), size_priors
    )
    # a rig may have a larger zero than it states: more points are then near zero
    zero_sd = max(zero_sd, float(np.exp(most_likely.logarithms[EFFECT_NAMES.index("zero")])))
    runs = runs.at_representative_conditions(_CONDITION_COUNT_FOR_RATIO)
    curves = runs.reduced_curves(law, log_mu_of_oils, zero_sd)
    sizes = PairSizes.from_logarithms(most_likely.logarithms).with_caution()
    covariance = _covariance(runs, curves, sizes)
    return RatioSurface(law, covariance, runs, sign, limits, most_likely.converged)


def _covariance(runs: RunsOfPair, curves: ReducedCurves, sizes: PairSizes) -> PairCovariance:
    """Covariance of the curves of some runs."""
    return PairCovariance.from_curves(curves, box_of(runs.stacked), runs.oil_of_curve, sizes)


def _in_canonical_order(
    first: OilOfPair, second: OilOfPair
) -> tuple[tuple[OilOfPair, OilOfPair], int]:
    """Both oils with their points in canonical order; the oil with more curves comes first.

    Returns:
        The oils, and -1 if they changed places, else 1.
    """
    oils = [
        replace(oil, measurements=oil.measurements.in_canonical_order()) for oil in (first, second)
    ]
    if _sort_key(oils[0].measurements) <= _sort_key(oils[1].measurements):
        return (oils[0], oils[1]), 1
    return (oils[1], oils[0]), -1


def _sort_key(measurements: Measurements) -> tuple[float, ...]:
    """What the oils of a pair are sorted by: the number of curves, then the values."""
    return (-len(measurements.conditions), *measurements.conditions.ravel(), *measurements.mu)


def _mu_of_curves(measurements: Measurements) -> set[tuple[float, ...]]:
    """The values of mu of each curve, in ascending order, as a set of curves."""
    order = np.lexsort([measurements.mu, measurements.curve_of_point])
    ends = np.cumsum(np.bincount(measurements.curve_of_point))[:-1]
    return {tuple(values) for values in np.split(measurements.mu[order], ends)}
