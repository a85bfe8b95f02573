"""The ratio of mu of two oils at equal conditions: what both oils share cancels.

Each point of oil i = 1, 2 has

    ln mu_i = law + c - (-1)^i r/2 + effects of its run + noise,   r = ln(mu_2 / mu_1)

c, the departure of both oils from one law, and r are smooth and independent. r has no law: it is a
constant that nothing limits, and a departure with sizes of its own. Where both oils were tested at
the same conditions and slips, c cancels exactly. Elsewhere c fills in as far as it is smooth, so
that a run needs no partner with the same slips, nor any partner.

Both oils share the sizes of the effects, so they should be from one rig. A gain that all runs of
one oil share is a part of r that no data can tell.

Reference: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
section 2.2.

Decides: how two oils are compared without a law; when one oil is certainly higher.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.sparse

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECTS, LogMu, LogNormal, RunErrorSizes, effect_design
from oilfilm.surface.interval import IntervalFactors, allowed_level, interval_factors
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import LEVEL_WIDTH, Measurements, scaled_conditions
from oilfilm.surface.posterior import (
    LeftOut,
    coordinates_by_group,
    smooth_covariance,
    smooth_variance,
    spread_out,
)
from oilfilm.surface.reduction import (
    Coordinates,
    ReducedCurves,
    at_points,
    box_of,
    is_near_zero,
    reduced,
    response,
)
from oilfilm.surface.reml import CAUTIOUS, CurveCovariance, Sizes, priors
from oilfilm.surface.support import SlipCoverage, support_codes
from oilfilm.surface.threads import with_one_blas_thread

# Standard deviation of the constant part of r: a factor of e either way.
_CONSTANT_SD = 1.0
# Size of the part of r that changes with slip and conditions.
DEPARTURE = LogNormal(0.05, 0.7, 0.01, 1.0)
# Difference of the laws' constants, over their standard deviation in a surface.
LAW_DIFFERENCE = LogNormal(0.1, 0.7, 0.03, 3.0)
# So many conditions that are far from each other stand for all, in the answer and in the search.
LARGEST = 120
_CONDITIONS_FOR_SIZES = 30
_ITERATIONS = 60


@dataclass(frozen=True)
class TestedOil:
    """One oil of a pair.

    Attributes:
        measurements: Its points.
        law: Its fitted law.
    """

    measurements: Measurements
    law: FreeLaw


@dataclass(frozen=True)
class PairSizes:
    """All sizes of a pair.

    Attributes:
        common: Sizes of the effects of runs, of the noise and of c.
        ratio: The same effects and noise, and the sizes of r.
        law_difference: See `PairCovariance`.
    """

    common: Sizes
    ratio: Sizes
    law_difference: float

    @classmethod
    def from_logarithms(cls, logarithms: FloatArray) -> "PairSizes":
        """The sizes from their logarithms.

        Args:
            logarithms: Those of `common` in the order of `size_names`, those of `ratio` without
                effects and noise, and that of `law_difference`.
        """
        errors = _error_sizes()
        of_common = (len(logarithms) - 1 + errors) // 2
        of_ratio = np.concatenate([logarithms[:errors], logarithms[of_common:-1]])
        return cls(
            common=Sizes.from_logarithms(logarithms[:of_common]),
            ratio=Sizes.from_logarithms(of_ratio),
            law_difference=float(np.exp(logarithms[-1])),
        )


@dataclass(frozen=True)
class PairCovariance:
    """Covariance of the coordinates of the curves of both oils.

    Attributes:
        common: Covariance of what has no oil: law, c, effects of runs and noise.
        ratio: Covariance of r at the same coordinates, as if r were measured there.
        half: -1/2 for the first oil and 1/2 for the second, shape (coordinates,).
        law_difference: Standard deviation of the difference of the laws' constants, over that of a
            constant in a surface.
    """

    common: CurveCovariance
    ratio: CurveCovariance
    half: FloatArray
    law_difference: float

    @cached_property
    def everything(self) -> Coordinates:
        """All coordinates, as values of r."""
        return self.ratio.curves.part(np.arange(len(self.half)))

    def matrix(self) -> FloatArray:
        """The covariance, shape (coordinates, coordinates)."""
        of_ratio = smooth_covariance(self.ratio, self.everything, self.everything)
        return self.common.matrix() + np.outer(self.half, self.half) * of_ratio

    def slopes(self, weight: FloatArray) -> FloatArray:
        """Sums of `weight` times the derivative by each logarithm, in the order of `PairSizes`.

        Args:
            weight: Symmetric, shape (coordinates, coordinates).
        """
        weight_of_ratio = weight * np.outer(self.half, self.half)
        of_ratio = self.ratio.slopes(weight_of_ratio)[_error_sizes() :]
        by_law = self.law_difference * self.common.curves.law_slopes
        of_law = 2 * np.sum(by_law * (weight_of_ratio @ by_law))
        return np.concatenate([self.common.slopes(weight), of_ratio, [of_law]])

    def as_ratio(self, places: Coordinates) -> Coordinates:
        """Values of r at the points of values of ln mu."""
        return replace(
            places,
            law_slopes=slopes_of_ratio(places.weights, places.law_slopes, self.law_difference),
        )


@dataclass(frozen=True)
class RatioPrediction:
    """The ratio at some points.

    Attributes:
        ratio: mu of the second oil over that of the first, shape (points,).
        sd: Standard deviation of its logarithm, shape (points,).
        support: Code of `oilfilm.surface.support.Support`, shape (points,).
        outside: Whether a condition or the slip is outside the tested range of an oil,
            shape (points,).
    """

    ratio: FloatArray
    sd: FloatArray
    support: IndexArray
    outside: BoolArray

    def interval(self, factor: float) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limit of the ratio; nan where there is no support.

        Args:
            factor: `point` of the factors of the surface.
        """
        log_half = np.where(self.support == 0, factor * self.sd, np.nan)
        return self.ratio * np.exp(-log_half), self.ratio * np.exp(log_half)


@dataclass(frozen=True)
class RatioSurface:
    """The ratio of two oils over slip, pressure, speed and temperature.

    Attributes:
        covariance: Covariance of the curves.
        law: The law about which both oils are described.
        oils: The points of the first and the second oil, in canonical order.
        paired: Number of conditions that both oils have.
        sign: 1, or -1 if the oils were asked for in the other order.
    """

    covariance: PairCovariance
    law: FreeLaw
    oils: tuple[Measurements, Measurements]
    paired: int
    sign: int

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
        places = self._places(conditions, slip)
        across = smooth_covariance(self.covariance.ratio, places, self.covariance.everything)
        across *= self.covariance.half
        explained = scipy.linalg.solve_triangular(self._factor, across.T, lower=True)
        variance = smooth_variance(self.covariance.ratio, places) - np.sum(explained**2, axis=0)
        spread = np.sqrt(variance)
        return RatioPrediction(
            ratio=np.exp(self.sign * (across @ self._weights)),
            sd=spread,
            support=self._support(conditions, slip, spread),
            outside=self._is_outside(conditions, slip),
        )

    @cached_property
    def interval_factors(self) -> IntervalFactors:
        """Factors on the standard deviation of the ratio, and the level that they allow.

        The runs of one oil at one condition are left out at a time. The other oil's runs there then
        predict them by the ratio at other conditions.
        """
        return _interval_factors(self)

    def log_mu_of(self, oil: int) -> LogMu:
        """ln mu of the first (0) or the second (1) oil, in canonical order."""
        half = oil - 0.5

        def log_mu(conditions: FloatArray, slip: FloatArray) -> FloatArray:
            """ln mu of the oil."""
            places = at_points(self.law, self.covariance.common.box, conditions, slip)
            everything = self.covariance.common.curves.part(np.arange(len(self._weights)))
            common = smooth_covariance(self.covariance.common, places, everything)
            of_ratio = smooth_covariance(
                self.covariance.ratio, self.covariance.as_ratio(places), self.covariance.everything
            )
            across = common + half * of_ratio * self.covariance.half
            return self.law.log_mu(conditions, slip) + across @ self._weights

        return log_mu

    @cached_property
    def _factor(self) -> FloatArray:
        """Lower Cholesky factor of the covariance of the coordinates."""
        return np.asarray(scipy.linalg.cholesky(self.covariance.matrix(), lower=True))

    @cached_property
    def _weights(self) -> FloatArray:
        """K^-1 y, shape (coordinates,)."""
        return self._solved(self.covariance.common.curves.departure)

    def _solved(self, right: FloatArray) -> FloatArray:
        """K^-1 times vectors."""
        return np.asarray(scipy.linalg.cho_solve((self._factor, True), right))

    def _places(self, conditions: FloatArray, slip: FloatArray) -> Coordinates:
        """Values of r at single points."""
        places = at_points(self.law, self.covariance.common.box, conditions, slip)
        return self.covariance.as_ratio(places)

    def _support(self, conditions: FloatArray, slip: FloatArray, spread: FloatArray) -> IndexArray:
        """Code of each point: that of an oil without support there, if there is one."""
        scaled = scaled_conditions(conditions)
        no_constants = np.empty((len(slip), 0))
        codes = []
        for measurements in self.oils:
            box = box_of(measurements)
            slips = SlipCoverage.of_measurements(measurements)
            single = box.leaves_single_level(box.centred(scaled))
            codes.append(support_codes(slips, slip, spread, no_constants, single))
        return np.maximum(*codes)

    def _is_outside(self, conditions: FloatArray, slip: FloatArray) -> BoolArray:
        """Whether an oil was not tested as far as that."""
        scaled = scaled_conditions(conditions)
        outside = np.zeros(len(slip), dtype=bool)
        for measurements in self.oils:
            box = box_of(measurements)
            beyond = np.maximum(box.lowest - scaled, scaled - box.highest)
            outside |= np.any(beyond > LEVEL_WIDTH, axis=1)
            outside |= slip > measurements.slip.max() * (1 + LEVEL_WIDTH)
        return outside

    def left_out(self) -> list[LeftOut]:
        """The runs of each oil at each condition, as all other runs predict them."""
        stacked = _stacked(self.oils)
        group = _group_numbers(stacked.condition_numbers(), _oil_of_curves(self.oils))
        inverse = self._solved(np.eye(len(self._weights)))
        curve = self.covariance.common.curves.curve
        return [
            LeftOut(rows, inverse[np.ix_(rows, rows)], self._weights[rows])
            for rows in coordinates_by_group(curve, group)
        ]


@with_one_blas_thread
def _interval_factors(surface: RatioSurface) -> IntervalFactors:
    """See `RatioSurface.interval_factors`."""
    stacked = _stacked(surface.oils)
    factors = interval_factors(
        surface.covariance.common, stacked.curve, stacked.condition_numbers(), surface.left_out()
    )
    return replace(factors, level=allowed_level(surface.paired))


@with_one_blas_thread
def fit_ratio(
    first: TestedOil, second: TestedOil, errors: RunErrorSizes | None = None
) -> RatioSurface:
    """The ratio of mu of the second oil to that of the first.

    The first pass takes the points whose logarithm is safe and the slopes of the laws. The second
    pass takes all points, and the slopes of the first surface.

    Args:
        first: The oil that the other is compared with.
        second: The other oil.
        errors: Sizes of the errors of the rig, before the data.

    Raises:
        ValueError: A run belongs to both oils, or no point is clear of zero traction.
    """
    if share_runs(first.measurements, second.measurements):
        raise ValueError("a run belongs to both oils; a ratio needs runs of its own for each oil")
    errors = errors or RunErrorSizes()
    oils, sign = _in_canonical_order(first, second)
    law = oils[0].law
    paired = int(np.count_nonzero(paired_conditions(oils[0].measurements, oils[1].measurements)))
    everything = _chosen(oils, LARGEST)
    sample = _chosen(oils, _CONDITIONS_FOR_SIZES)

    zero_sd = errors.zero.median
    clear = []
    for oil in sample:
        is_clear = ~is_near_zero(oil.mu, zero_sd)
        if not is_clear.any():
            raise ValueError(
                "no mu of an oil is above ten times the error of the zero, "
                f"{zero_sd:g}; check the unit of mu and the zero of the rig"
            )
        clear.append(oil.of_points(is_clear))
    pair = Pair((clear[0], clear[1]), law)
    curves = pair.reduced([oil.law.log_mu for oil in oils], zero_sd)
    expected = np.log([prior.median for prior in pair_priors(errors)])
    first_surface = RatioSurface(
        pair.covariance(curves, PairSizes.from_logarithms(expected)), law, pair.oils, paired, sign
    )
    log_mu = [first_surface.log_mu_of(0), first_surface.log_mu_of(1)]

    pair = Pair(sample, law)
    logarithms = most_likely(pair, pair.reduced(log_mu, zero_sd), errors)
    pair = Pair(everything, law)
    # a rig may have a larger zero than it states: more points are then near zero
    found_zero_sd = float(np.exp(logarithms[EFFECTS.index("zero")]))
    curves = pair.reduced(log_mu, max(zero_sd, found_zero_sd))
    return RatioSurface(
        pair.covariance(curves, PairSizes.from_logarithms(logarithms)), law, pair.oils, paired, sign
    )


@dataclass(frozen=True)
class Pair:
    """The points of two oils.

    Attributes:
        oils: Points of the first and of the second oil, each in canonical order.
        law: The law about which both are described.
    """

    oils: tuple[Measurements, Measurements]
    law: FreeLaw

    @cached_property
    def stacked(self) -> Measurements:
        """The points of both, as if they were one oil."""
        return _stacked(self.oils)

    @cached_property
    def box(self) -> ConditionBox:
        """The box of the conditions of both."""
        return box_of(self.stacked)

    def reduced(self, log_mu: list[LogMu], zero_sd: float) -> ReducedCurves:
        """The curves of both oils as coordinates.

        Args:
            log_mu: ln mu of each oil, as the best present description has it.
            zero_sd: Standard deviation of the zero, as a traction coefficient.
        """
        curves = reduced(self.stacked, self.law, self.law.log_mu, zero_sd, self.box)
        responses, designs = [], []
        for oil, of_oil in zip(self.oils, log_mu, strict=True):
            conditions = oil.point_conditions
            responses.append(response(oil, of_oil, zero_sd) - self.law.log_mu(conditions, oil.slip))
            designs.append(effect_design(of_oil, conditions, oil.slip))
        departure = np.concatenate(responses)
        coordinates = curves.vectors.T @ departure
        return replace(
            curves,
            departure=coordinates,
            effects=curves.vectors.T @ np.vstack(designs),
            remainder=departure - curves.vectors @ coordinates,
        )

    def covariance(self, curves: ReducedCurves, sizes: PairSizes) -> PairCovariance:
        """Covariance of the curves with some sizes."""
        of_ratio = slopes_of_ratio(curves.to_slips, curves.law_slopes, sizes.law_difference)
        half = _oil_of_curves(self.oils) - 0.5
        # the ratio may bend between two levels by its own size only
        box = replace(self.box, level_counts=np.maximum(self.box.level_counts, 3))
        return PairCovariance(
            common=CurveCovariance(curves, self.box, sizes.common),
            ratio=CurveCovariance(replace(curves, law_slopes=of_ratio), box, sizes.ratio),
            half=half[curves.curve],
            law_difference=sizes.law_difference,
        )


def objective(
    logarithms: FloatArray,
    covariance_of: Callable[[FloatArray], PairCovariance],
    known: tuple[LogNormal, ...],
) -> tuple[float, FloatArray]:
    """Negative logarithm of the restricted likelihood and the priors, and its gradient.

    Args:
        logarithms: Logarithms of the sizes, see `PairSizes`.
        covariance_of: Covariance of the curves with such sizes.
        known: The priors of the sizes.
    """
    covariance = covariance_of(logarithms)
    curves = covariance.common.curves
    factor = scipy.linalg.cholesky(covariance.matrix(), lower=True)
    inverse = scipy.linalg.cho_solve((factor, True), np.eye(len(factor)))
    weights = inverse @ curves.departure
    value = 0.5 * curves.departure @ weights + np.sum(np.log(np.diag(factor)))
    gradient = covariance.slopes(inverse - np.outer(weights, weights)) / 2

    noise = _error_sizes() - 1
    scaled_squares = np.sum(curves.remainder**2) / np.exp(2 * logarithms[noise])
    value += curves.degrees_left * logarithms[noise] + scaled_squares / 2
    gradient[noise] += curves.degrees_left - scaled_squares

    medians = np.log([prior.median for prior in known])
    deviations = np.array([prior.ln_sd for prior in known])
    scores = (logarithms - medians) / deviations
    return value + np.sum(scores**2) / 2, gradient + scores / deviations


def most_likely(pair: Pair, curves: ReducedCurves, errors: RunErrorSizes) -> FloatArray:
    """Logarithms of the most likely sizes, see `PairSizes`."""
    known = pair_priors(errors)
    lower = np.log([prior.smallest for prior in known])
    upper = np.log([prior.largest for prior in known])

    def covariance_of(logarithms: FloatArray) -> PairCovariance:
        return pair.covariance(curves, PairSizes.from_logarithms(logarithms))

    search = scipy.optimize.minimize(
        objective,
        np.log([prior.median for prior in known]),
        args=(covariance_of, known),
        jac=True,
        method="L-BFGS-B",
        bounds=scipy.optimize.Bounds(lower, upper),
        options={"maxiter": _ITERATIONS, "ftol": 1e-8},
    )
    return np.asarray(search.x)


def pair_priors(errors: RunErrorSizes) -> tuple[LogNormal, ...]:
    """What is known of each size before the data, in the order of `PairSizes`."""
    of_ratio = priors(errors, DEPARTURE)[_error_sizes() :]
    return (*priors(errors, CAUTIOUS), *of_ratio, LAW_DIFFERENCE)


def _error_sizes() -> int:
    """Number of sizes of errors; the noise is the last of them."""
    return len(RunErrorSizes().in_order())


def slopes_of_ratio(
    weights: scipy.sparse.csr_array, law_slopes: FloatArray, law_difference: float
) -> FloatArray:
    """Slopes of r by its constant part and by the constants of the law, shape (rows, slopes).

    Args:
        weights: Weight of each slip in each row, shape (rows, slips).
        law_slopes: Slopes of the law at the rows, shape (rows, slopes).
        law_difference: See `PairCovariance`.
    """
    constant = weights @ np.full(weights.shape[1], _CONSTANT_SD)
    return np.column_stack([constant, law_difference * law_slopes])


def _in_canonical_order(
    first: TestedOil, second: TestedOil
) -> tuple[tuple[TestedOil, TestedOil], int]:
    """Both oils with their points in canonical order; the oil with more curves comes first.

    Returns:
        The oils, and -1 if they changed places, else 1.
    """
    oils = [
        replace(oil, measurements=oil.measurements.in_canonical_order()) for oil in (first, second)
    ]
    one, other = (_content(oil.measurements) for oil in oils)
    if one <= other:
        return (oils[0], oils[1]), 1
    return (oils[1], oils[0]), -1


def _content(measurements: Measurements) -> tuple[float, ...]:
    """What orders oils: the number of curves, then the values."""
    return (-len(measurements.conditions), *measurements.conditions.ravel(), *measurements.mu)


def share_runs(first: Measurements, second: Measurements) -> bool:
    """Whether a curve of one oil has the values of a curve of the other."""
    return not _curves(first).isdisjoint(_curves(second))


def _curves(measurements: Measurements) -> set[tuple[float, ...]]:
    """The values of mu of each curve, in ascending order."""
    order = np.lexsort([measurements.mu, measurements.curve])
    ends = np.cumsum(np.bincount(measurements.curve))[:-1]
    return {tuple(values) for values in np.split(measurements.mu[order], ends)}


def _stacked(oils: tuple[Measurements, Measurements]) -> Measurements:
    """The points of both oils, as if they were one."""
    first, second = oils
    return Measurements(
        conditions=np.vstack([first.conditions, second.conditions]),
        curve=np.concatenate([first.curve, second.curve + len(first.conditions)]),
        slip=np.concatenate([first.slip, second.slip]),
        mu=np.concatenate([first.mu, second.mu]),
    )


def _oil_of_curves(oils: tuple[Measurements, Measurements]) -> IndexArray:
    """0 for curves of the first oil and 1 for those of the second, shape (curves,)."""
    return np.repeat([0, 1], [len(oil.conditions) for oil in oils])


def _group_numbers(*columns: IndexArray) -> IndexArray:
    """Number of each row by its values in some columns, shape (rows,)."""
    _, number = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    return np.asarray(number, dtype=np.int64).ravel()


def paired_conditions(first: Measurements, second: Measurements) -> BoolArray:
    """Whether each condition was tested with both oils, shape (conditions,)."""
    oils = (first, second)
    condition, oil = _stacked(oils).condition_numbers(), _oil_of_curves(oils)
    has_first = np.bincount(condition[oil == 0], minlength=condition.max() + 1) > 0
    has_second = np.bincount(condition[oil == 1], minlength=condition.max() + 1) > 0
    return has_first & has_second


def _chosen(oils: tuple[TestedOil, TestedOil], count: int) -> tuple[Measurements, Measurements]:
    """Points at `count` conditions that stand for all; all of them if they are few.

    Conditions of both oils come first. Those that are chosen are far from each other.
    """
    first, second = oils[0].measurements, oils[1].measurements
    condition = _stacked((first, second)).condition_numbers()
    if condition.max() < count:
        return first, second
    centres = scaled_conditions(_stacked((first, second)).conditions)
    is_paired = paired_conditions(first, second)
    kept: list[int] = []
    for group in (np.flatnonzero(is_paired), np.flatnonzero(~is_paired)):
        room = count - len(kept)
        if len(group) and room:
            rows = np.array([np.flatnonzero(condition == number)[0] for number in group])
            kept.extend(group[spread_out(centres[rows], room)])
    is_kept = np.isin(condition, kept)
    count_first = len(first.conditions)
    return (
        first.of_curves(np.flatnonzero(is_kept[:count_first])),
        second.of_curves(np.flatnonzero(is_kept[count_first:])),
    )
