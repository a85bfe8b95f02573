"""Where a surface has support, that is, where it gives an answer; else the reason why not."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import LINEAR_SLIP_LIMIT, Measurements, scaled_slip

# Scaled slips within this distance are the same slip: 0.02 is 2 % of a slip far above 0.003.
SAME_SLIP = 0.02
# Above this slip a distance counts by its factor, below by its difference: between small slips mu
# rises steadily, and the interval widens by itself. `benchmarks/surface.py gaps` measures both.
_SMALL_SLIP = 0.02


class Support(IntEnum):
    """Whether a surface has support at a point, or why not.

    `support_codes` gives all but `LAW_NOT_POSITIVE`, for which the law must be evaluated.
    """

    SUPPORTED = 0
    SPREAD_TOO_LARGE = 1
    FAR_FROM_TESTED_SLIPS = 2
    FEW_SLIPS = 3
    CONSTANT_AT_BOUND = 4
    CONDITION_NOT_VARIED = 5
    FAR_FROM_TESTED_CONDITIONS = 6
    LAW_NOT_POSITIVE = 7


@dataclass(frozen=True)
class SlipCoverage:
    """The tested slips, and how densely they were tested.

    Attributes:
        scaled_slips: Scaled slips in ascending order, shape (slips,).
        widest_gap: Widest gap between the slips of a curve, median over the curves.
        slips_per_curve: Number of different slips of a curve, median over the curves.
    """

    scaled_slips: FloatArray
    widest_gap: float
    slips_per_curve: float

    @classmethod
    def from_measurements(cls, measurements: Measurements) -> "SlipCoverage":
        """The tested slips of points in canonical order."""
        scaled_slips = scaled_slip(measurements.slip)
        curve_starts = np.flatnonzero(np.diff(measurements.curve_of_point)) + 1
        gaps_of_curves = [
            np.diff(slips_of_curve) for slips_of_curve in np.split(scaled_slips, curve_starts)
        ]
        slip_counts = [1 + np.count_nonzero(gaps > SAME_SLIP) for gaps in gaps_of_curves]
        widest_gaps = [gaps.max(initial=0.0) for gaps in gaps_of_curves]
        return cls(
            np.unique(scaled_slips), float(np.median(widest_gaps)), float(np.median(slip_counts))
        )

    def is_far(self, slip: FloatArray, limits: SurfaceLimits) -> BoolArray:
        """Whether each slip is too far from the tested ones, shape (points,).

        Beyond the first and the last tested slip there is a tested slip on one side only, so that
        half the reach is left.

        Args:
            slip: Slide-roll ratio of each point, shape (points,).
            limits: The reach of a tested slip.
        """
        new_slips = scaled_slip(slip)
        is_beyond = (new_slips < self.scaled_slips[0]) | (new_slips > self.scaled_slips[-1])
        share_of_gap = limits.reach_in_gaps * np.where(is_beyond, 0.5, 1.0)
        is_far_in_gaps = self.distance(slip) > share_of_gap * self.widest_gap + SAME_SLIP
        tested_slips = LINEAR_SLIP_LIMIT * np.sinh(self.scaled_slips)
        distance = _distance_to_nearest(
            np.arcsinh(tested_slips / _SMALL_SLIP), np.arcsinh(slip / _SMALL_SLIP)
        )
        return is_far_in_gaps | (distance > np.log(limits.reach_in_slip))

    def distance(self, slip: FloatArray) -> FloatArray:
        """Distance of each slip from the nearest tested one, in scaled slip, shape (points,)."""
        return _distance_to_nearest(self.scaled_slips, scaled_slip(slip))


def _distance_to_nearest(sorted_values: FloatArray, values: FloatArray) -> FloatArray:
    """Distance of each value from the nearest one of some sorted values, shape (values,)."""
    above = np.searchsorted(sorted_values, values).clip(0, len(sorted_values) - 1)
    below = (above - 1).clip(0)
    return np.minimum(np.abs(sorted_values[above] - values), np.abs(sorted_values[below] - values))


def support_codes(
    limits: SurfaceLimits,
    coverage: SlipCoverage,
    slip: FloatArray,
    spread: FloatArray,
    spread_of_bounds: FloatArray,
    distance_in_ranges: FloatArray,
) -> IndexArray:
    """Code of `Support` of each point; the last reason that applies counts, shape (points,).

    Args:
        limits: What a surface must fulfil.
        coverage: The tested slips.
        slip: Slide-roll ratio of each point, shape (points,).
        spread: Standard deviation of the surface in ln mu, shape (points,).
        spread_of_bounds: Standard deviation in ln mu by each constant that is at its bound,
            shape (points, constants at a bound).
        distance_in_ranges: Distance from the tested conditions, as
            `ConditionBox.distance_in_ranges` gives it, shape (points,).
    """
    is_untested_slip = coverage.distance(slip) > SAME_SLIP
    has_few_slips = coverage.slips_per_curve < limits.fewest_slips
    rests_on_bound = np.any(spread_of_bounds > limits.largest_spread_of_bound, axis=1)
    reasons: list[tuple[Support, BoolArray]] = [
        (Support.CONSTANT_AT_BOUND, rests_on_bound),
        (Support.SPREAD_TOO_LARGE, spread > limits.largest_spread),
        (Support.FAR_FROM_TESTED_SLIPS, coverage.is_far(slip, limits)),
        (Support.FEW_SLIPS, has_few_slips & is_untested_slip),
        (Support.FAR_FROM_TESTED_CONDITIONS, distance_in_ranges > limits.reach_in_ranges),
        # a condition of one level has no range, so that the distance from it is infinite
        (Support.CONDITION_NOT_VARIED, np.isinf(distance_in_ranges)),
    ]
    codes = np.full(len(slip), Support.SUPPORTED, dtype=np.int64)
    for reason, does_apply in reasons:
        codes[does_apply] = reason
    return codes
