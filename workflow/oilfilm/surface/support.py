"""Where a surface has support: the reasons for which it gives no answer."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements, scaled_slip

# Scaled slips within this distance are the same slip: 0.02 is 2 % of a slip far above 0.003.
SAME_SLIP = 0.02


class Support(IntEnum):
    """Whether a surface has support at a point, or why not."""

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
    """The tested slips.

    Attributes:
        scaled: Scaled slips in ascending order, shape (slips,).
        widest_gap: Widest gap between the slips of a curve, median over the curves.
        per_curve: Different slips in a curve, median over the curves.
    """

    scaled: FloatArray
    widest_gap: float
    per_curve: float

    @classmethod
    def from_measurements(cls, measurements: Measurements) -> "SlipCoverage":
        """The tested slips of points in canonical order."""
        scaled = scaled_slip(measurements.slip)
        ends = np.flatnonzero(np.diff(measurements.curve)) + 1
        gaps = [np.diff(scaled_of_curve) for scaled_of_curve in np.split(scaled, ends)]
        counts = [1 + np.count_nonzero(gap > SAME_SLIP) for gap in gaps]
        widest = [gap.max(initial=0.0) for gap in gaps]
        return cls(np.unique(scaled), float(np.median(widest)), float(np.median(counts)))

    def is_far(self, slip: FloatArray, limits: SurfaceLimits) -> BoolArray:
        """Whether each slip is too far from the tested ones, shape (points,).

        Beyond the first and the last tested slip only one neighbour holds the surface, so that
        half the reach is left.

        Args:
            slip: Slide-roll ratio of each point, shape (points,).
            limits: The reach of a tested slip.
        """
        scaled = scaled_slip(slip)
        beyond = (scaled < self.scaled[0]) | (scaled > self.scaled[-1])
        share_of_gap = limits.reach_in_gaps * np.where(beyond, 0.5, 1.0)
        # scaled slips are logarithms, but for the lowest ones
        largest_distance = np.minimum(share_of_gap * self.widest_gap, np.log(limits.reach_in_slip))
        return self.distance(slip) > largest_distance + SAME_SLIP

    def distance(self, slip: FloatArray) -> FloatArray:
        """Distance of each slip from the nearest tested one, scaled, shape (points,)."""
        scaled = scaled_slip(slip)
        above = np.searchsorted(self.scaled, scaled).clip(0, len(self.scaled) - 1)
        below = (above - 1).clip(0)
        to_above = np.abs(self.scaled[above] - scaled)
        return np.minimum(to_above, np.abs(self.scaled[below] - scaled))


def support_codes(
    limits: SurfaceLimits,
    slips: SlipCoverage,
    slip: FloatArray,
    spread: FloatArray,
    bound_spreads: FloatArray,
    ranges_beyond: FloatArray,
) -> IndexArray:
    """Code of `Support` of each point; the last reason that applies counts, shape (points,).

    Args:
        limits: What is asked of a surface.
        slips: The tested slips.
        slip: Slide-roll ratio of each point, shape (points,).
        spread: Standard deviation of the surface in ln mu, shape (points,).
        bound_spreads: Standard deviation in ln mu by each constant that is at its bound,
            shape (points, constants at a bound).
        ranges_beyond: As `ConditionBox.ranges_beyond`, shape (points,).
    """
    is_between = slips.distance(slip) > SAME_SLIP
    too_few = slips.per_curve < limits.fewest_slips
    at_bound = np.any(bound_spreads > limits.largest_spread_of_bound, axis=1)
    reasons: list[tuple[Support, BoolArray]] = [
        (Support.CONSTANT_AT_BOUND, at_bound),
        (Support.SPREAD_TOO_LARGE, spread > limits.largest_spread),
        (Support.FAR_FROM_TESTED_SLIPS, slips.is_far(slip, limits)),
        (Support.FEW_SLIPS, too_few & is_between),
        (Support.FAR_FROM_TESTED_CONDITIONS, ranges_beyond > limits.reach_in_ranges),
        (Support.CONDITION_NOT_VARIED, np.isinf(ranges_beyond)),
    ]
    codes = np.full(len(slip), Support.SUPPORTED, dtype=np.int64)
    for reason, applies in reasons:
        codes[applies] = reason
    return codes
