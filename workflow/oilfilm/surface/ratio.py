"""The ratio of mu of two oils at equal conditions: what both oils share cancels.

The runs of both oils are described together (`pair_covariance`). A run needs no partner with the
same slips. Where only one oil was tested, the part that both share fills in as far as it is smooth,
and the interval is wider there.

Both oils share the sizes of the effects of runs. A gain that all runs of one oil share is a part of
the ratio that no data can tell; so is the calibration, where each oil has a rig of its own.

Decides: how two oils are compared without a law.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECTS, LogMu, RunErrorSizes, effect_design
from oilfilm.surface.interval import IntervalFactors, allowed_level, interval_factors
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements, scaled_conditions, scaled_slip
from oilfilm.surface.pair_covariance import PairCovariance, PairSizes, most_likely_pair, pair_priors
from oilfilm.surface.posterior import LeftOut, coordinates_by_group, smooth_variance, spread_out
from oilfilm.surface.reduction import (
    ReducedCurves,
    at_points,
    box_of,
    is_near_zero,
    reduced,
    response,
)
from oilfilm.surface.support import SAME_SLIP, SlipCoverage, support_codes
from oilfilm.surface.threads import with_one_blas_thread

# So many conditions, far from each other, stand for all: in the answer, and in the search of sizes.
LARGEST_DENSE = 120
_CONDITIONS_FOR_SIZES = 30


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
class PairedRuns:
    """The points of two oils.

    Attributes:
        first: Points of the first oil, in canonical order.
        second: Points of the second oil, in canonical order.
    """

    first: Measurements
    second: Measurements

    @cached_property
    def stacked(self) -> Measurements:
        """The points of both, as if they were one oil."""
        noise_ratio = None
        if self.first.noise_ratio is not None and self.second.noise_ratio is not None:
            noise_ratio = np.concatenate([self.first.noise_ratio, self.second.noise_ratio])
        return Measurements(
            conditions=np.vstack([self.first.conditions, self.second.conditions]),
            curve=np.concatenate(
                [self.first.curve, self.second.curve + len(self.first.conditions)]
            ),
            slip=np.concatenate([self.first.slip, self.second.slip]),
            mu=np.concatenate([self.first.mu, self.second.mu]),
            noise_ratio=noise_ratio,
            level_widths=self.first.level_widths,
        )

    @cached_property
    def oil(self) -> IndexArray:
        """0 for curves of the first oil and 1 for those of the second, shape (curves,)."""
        return np.repeat([0, 1], [len(self.first.conditions), len(self.second.conditions)])

    @cached_property
    def condition(self) -> IndexArray:
        """Number of the condition of each curve, shape (curves,)."""
        return self.stacked.condition_numbers()

    def is_paired(self) -> BoolArray:
        """Whether each condition was tested with both oils, shape (conditions,)."""
        count = self.condition.max() + 1
        has_first = np.bincount(self.condition[self.oil == 0], minlength=count) > 0
        has_second = np.bincount(self.condition[self.oil == 1], minlength=count) > 0
        return has_first & has_second

    def share_runs(self) -> bool:
        """Whether a curve of one oil has the values of a curve of the other."""
        return not _curves(self.first).isdisjoint(_curves(self.second))

    def standing_for_all(self, count: int) -> "PairedRuns":
        """The points at `count` conditions that are far from each other; all if they are few.

        Conditions of both oils come first.
        """
        is_paired = self.is_paired()
        if len(is_paired) <= count:
            return self
        _, first_rows = np.unique(self.condition, return_index=True)
        centres = scaled_conditions(self.stacked.conditions[first_rows])
        chosen = np.empty(0, dtype=np.int64)
        for group in (np.flatnonzero(is_paired), np.flatnonzero(~is_paired)):
            wanted_count = count - len(chosen)
            if len(group) and wanted_count:
                chosen = np.append(chosen, group[spread_out(centres[group], wanted_count)])
        is_chosen = np.isin(self.condition, chosen)
        return PairedRuns(
            self.first.select_curves(np.flatnonzero(is_chosen[self.oil == 0])),
            self.second.select_curves(np.flatnonzero(is_chosen[self.oil == 1])),
        )

    def clear_of_zero(self, zero_sd: float) -> "PairedRuns":
        """The points whose logarithm is safe.

        Raises:
            ValueError: An oil has none.
        """
        oils = []
        for oil in (self.first, self.second):
            is_clear = ~is_near_zero(oil.mu, zero_sd)
            if not is_clear.any():
                raise ValueError(
                    f"no mu of an oil is above ten times the error of the zero, {zero_sd:g}; check "
                    "the unit of mu and the zero of the rig"
                )
            oils.append(oil.select_points(is_clear))
        return PairedRuns(*oils)

    def reduced(self, law: FreeLaw, log_mu: tuple[LogMu, LogMu], zero_sd: float) -> ReducedCurves:
        """The curves of both oils as coordinates.

        Args:
            law: The law about which both are described.
            log_mu: ln mu of each oil, as the best present description has it.
            zero_sd: Standard deviation of the zero, as a traction coefficient.
        """
        # of `law.log_mu` only what does not depend on the oil is kept
        curves = reduced(self.stacked, law, law.log_mu, zero_sd, box_of(self.stacked))
        departures, designs = [], []
        for oil, oil_log_mu in zip((self.first, self.second), log_mu, strict=True):
            law_log_mu = law.log_mu(oil.point_conditions, oil.slip)
            departures.append(response(oil, oil_log_mu, zero_sd) - law_log_mu)
            designs.append(effect_design(oil_log_mu, oil.point_conditions, oil.slip))
        weight = np.ones(len(self.stacked.slip))
        if self.stacked.noise_ratio is not None:
            weight = 1 / self.stacked.noise_ratio
        departure = weight * np.concatenate(departures)
        coordinates = curves.vectors.T @ departure
        return replace(
            curves,
            departure=coordinates,
            effects=curves.vectors.T @ (weight[:, np.newaxis] * np.vstack(designs)),
            remainder=departure - curves.vectors @ coordinates,
        )


@dataclass(frozen=True)
class RatioPrediction:
    """The ratio at some points.

    Attributes:
        ratio: mu of the second oil over that of the first, shape (points,).
        sd: Standard deviation of its logarithm, shape (points,).
        support: Code of `oilfilm.surface.support.Support`, shape (points,).
        outside: Whether an oil was not tested as far, shape (points,).
    """

    ratio: FloatArray
    sd: FloatArray
    support: IndexArray
    outside: BoolArray

    def interval(self, factor: float) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limit of the ratio; nan where there is no support.

        Args:
            factor: `point` or `curve` of `IntervalFactors`.
        """
        log_half = np.where(self.support == 0, factor * self.sd, np.nan)
        return self.ratio * np.exp(-log_half), self.ratio * np.exp(log_half)


@dataclass(frozen=True)
class RatioSurface:
    """The ratio of two oils over slip, pressure, speed and temperature.

    Attributes:
        law: The law about which both oils are described.
        covariance: Covariance of the curves.
        runs: The points of both oils.
        sign: 1, or -1 if the ratio of the first oil to the second is wanted.
        limits: What is asked of an answer.
        converged: Whether the sizes are most likely. If not, they are the last step of a search
            that found no maximum.
    """

    law: FreeLaw
    covariance: PairCovariance
    runs: PairedRuns
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
        targets = at_points(self.law, covariance.common.box, conditions, slip)
        across = covariance.ratio_covariance(targets)
        whitened_across = scipy.linalg.solve_triangular(self.factor, across.T, lower=True)
        variance = smooth_variance(covariance.ratio, covariance.as_ratio(targets))
        sd = np.sqrt(variance - np.sum(whitened_across**2, axis=0))
        return RatioPrediction(
            ratio=np.exp(self.sign * (across @ self.weights)),
            sd=sd,
            support=self._support(conditions, slip, sd),
            outside=self._is_outside(conditions, slip),
        )

    @cached_property
    def interval_factors(self) -> IntervalFactors:
        """Factors on the standard deviation of the ratio, and the level that they allow.

        All conditions show how large the errors are. Only those of both oils raise the level.
        """
        return _interval_factors(self)

    def left_out(self) -> list[LeftOut]:
        """The runs of each oil at each condition, as all other runs predict them.

        Where the other oil was tested at the condition, its runs there predict them with the ratio
        at other conditions: the error is that of the ratio.
        """
        group = 2 * self.runs.condition + self.runs.oil
        _, number = np.unique(group, return_inverse=True)
        inverse = self._solved(np.eye(len(self.weights)))
        return [
            LeftOut(rows, inverse[np.ix_(rows, rows)], self.weights[rows])
            for rows in coordinates_by_group(self.covariance.common.curves.curve, number.ravel())
        ]

    def log_mu_of(self, oil: int) -> LogMu:
        """ln mu of the first (0) or the second (1) oil of `runs`."""

        def log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
            targets = at_points(self.law, self.covariance.common.box, conditions, slip)
            departure = self.covariance.oil_covariance(targets, oil) @ self.weights
            return self.law.log_mu(conditions, slip) + departure

        return log_mu

    @cached_property
    def factor(self) -> FloatArray:
        """Lower Cholesky factor of the covariance of the coordinates."""
        return np.asarray(scipy.linalg.cholesky(self.covariance.matrix(), lower=True))

    @cached_property
    def weights(self) -> FloatArray:
        """K^-1 y, shape (coordinates,)."""
        return self._solved(self.covariance.common.curves.departure)

    def _solved(self, right: FloatArray) -> FloatArray:
        """K^-1 times vectors."""
        return np.asarray(scipy.linalg.cho_solve((self.factor, True), right))

    def _support(self, conditions: FloatArray, slip: FloatArray, sd: FloatArray) -> IndexArray:
        """Code of each point: that of an oil without support there, if there is one."""
        codes = []
        for oil in (self.runs.first, self.runs.second):
            box = box_of(oil)
            codes.append(
                support_codes(
                    self.limits,
                    SlipCoverage.from_measurements(oil),
                    slip,
                    sd,
                    # the ratio has no constants that could be at a bound
                    np.empty((len(slip), 0)),
                    box.ranges_beyond(box.centred(scaled_conditions(conditions))),
                )
            )
        return np.maximum(*codes)

    def _is_outside(self, conditions: FloatArray, slip: FloatArray) -> BoolArray:
        """Whether an oil was not tested as far, in a condition or in slip."""
        scaled = scaled_conditions(conditions)
        outside = np.zeros(len(slip), dtype=bool)
        for oil in (self.runs.first, self.runs.second):
            box = box_of(oil)
            beyond = np.maximum(box.lowest - scaled, scaled - box.highest)
            outside |= np.any(beyond > box.level_widths, axis=1)
            outside |= scaled_slip(slip) > scaled_slip(oil.slip).max() + SAME_SLIP
        return outside


@with_one_blas_thread
def _interval_factors(surface: RatioSurface) -> IntervalFactors:
    """See `RatioSurface.interval_factors`."""
    runs, wanted = surface.runs, surface.limits.level
    factors = interval_factors(
        surface.covariance.common, runs.stacked.curve, runs.condition, surface.left_out(), wanted
    )
    paired = int(np.count_nonzero(runs.is_paired()))
    return replace(factors, level=allowed_level(wanted, paired))


@with_one_blas_thread
def fit_ratio(
    first: OilOfPair,
    second: OilOfPair,
    errors: RunErrorSizes | None = None,
    limits: SurfaceLimits | None = None,
) -> RatioSurface:
    """The ratio of mu of the second oil to that of the first.

    The first pass takes the points whose logarithm is safe, the slopes of the laws and the sizes
    that are expected before the data. The second pass takes all points and the slopes of the first.

    Args:
        first: The oil with which the other is compared.
        second: The other oil.
        errors: Sizes of the errors of the rig, before the data.
        limits: What is asked of an answer.

    Raises:
        ValueError: A run belongs to both oils, or an oil has no point clear of zero traction.
    """
    errors, limits = errors or RunErrorSizes(), limits or SurfaceLimits()
    (leading, other), sign = _in_canonical_order(first, second)
    law = leading.law
    runs = PairedRuns(leading.measurements, other.measurements)
    if runs.share_runs():
        raise ValueError("a run belongs to both oils; a ratio needs other runs for each oil")
    sample = runs.standing_for_all(_CONDITIONS_FOR_SIZES)
    size_priors, zero_sd = pair_priors(errors), errors.zero.median

    clear = sample.clear_of_zero(zero_sd)
    curves = clear.reduced(law, (leading.law.log_mu, other.law.log_mu), zero_sd)
    expected = PairSizes.from_logarithms(np.log([prior.median for prior in size_priors]))
    pilot = RatioSurface(law, _covariance(clear, curves, expected), clear, sign, limits, True)
    log_mu = (pilot.log_mu_of(0), pilot.log_mu_of(1))

    curves = sample.reduced(law, log_mu, zero_sd)
    most_likely = most_likely_pair(lambda sizes: _covariance(sample, curves, sizes), size_priors)
    # a rig may have a larger zero than it states: more points are then near zero
    zero_sd = max(zero_sd, float(np.exp(most_likely.logarithms[EFFECTS.index("zero")])))
    runs = runs.standing_for_all(LARGEST_DENSE)
    curves = runs.reduced(law, log_mu, zero_sd)
    sizes = PairSizes.from_logarithms(most_likely.logarithms).with_caution()
    covariance = _covariance(runs, curves, sizes)
    return RatioSurface(law, covariance, runs, sign, limits, most_likely.converged)


def _covariance(runs: PairedRuns, curves: ReducedCurves, sizes: PairSizes) -> PairCovariance:
    """Covariance of the curves of some runs."""
    return PairCovariance.from_curves(curves, box_of(runs.stacked), runs.oil, sizes)


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
    if _content(oils[0].measurements) <= _content(oils[1].measurements):
        return (oils[0], oils[1]), 1
    return (oils[1], oils[0]), -1


def _content(measurements: Measurements) -> tuple[float, ...]:
    """What orders oils: the number of curves, then the values."""
    return (-len(measurements.conditions), *measurements.conditions.ravel(), *measurements.mu)


def _curves(measurements: Measurements) -> set[tuple[float, ...]]:
    """The values of mu of each curve, in ascending order."""
    order = np.lexsort([measurements.mu, measurements.curve])
    ends = np.cumsum(np.bincount(measurements.curve))[:-1]
    return {tuple(values) for values in np.split(measurements.mu[order], ends)}
