"""Where a surface has support: the reasons for which it gives no answer.

Decides: when there is no support.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.measurements import Measurements, scaled_slip

# Largest standard deviation of the surface in ln mu.
_LARGEST_SPREAD = 0.15
# A curve with fewer slips does not show the shape between them.
_FEWEST_SLIPS = 3
# Scaled slips within this distance are the same slip: 0.02 is 2 % of a slip far above 0.003.
_SAME_SLIP = 0.02
# A constant at its bound matters where its own uncertainty moves ln mu by more.
_BOUND_MATTERS = 0.05


class Support(IntEnum):
    """Whether a surface has support at a point, or why not."""

    SUPPORTED = 0
    SPREAD_TOO_LARGE = 1
    FAR_FROM_TESTED_SLIPS = 2
    FEW_SLIPS = 3
    CONSTANT_AT_BOUND = 4
    CONDITION_NOT_VARIED = 5


@dataclass(frozen=True)
class SlipCoverage:
    """The tested slips.

    Attributes:
        scaled: Scaled slips in ascending order, shape (slips,).
        reach: Largest distance from a tested slip that has support, between tested slips.
        per_curve: Different slips in a curve, median over the curves.
    """

    scaled: FloatArray
    reach: float
    per_curve: float

    @classmethod
    def of_measurements(cls, measurements: Measurements) -> "SlipCoverage":
        """The tested slips of points in canonical order.

        The reach is half the widest gap of a curve, median over the curves.
        """
        scaled = scaled_slip(measurements.slip)
        ends = np.flatnonzero(np.diff(measurements.curve)) + 1
        gaps = [np.diff(of_curve) for of_curve in np.split(scaled, ends)]
        counts = [1 + np.count_nonzero(gap > _SAME_SLIP) for gap in gaps]
        widest = [gap.max(initial=0.0) for gap in gaps]
        return cls(np.unique(scaled), float(np.median(widest)) / 2, float(np.median(counts)))

    def is_far(self, slip: FloatArray) -> BoolArray:
        """Whether each slip is too far from the tested ones, shape (points,).

        Beyond the first and the last tested slip only one neighbour holds the surface, so that
        half the reach is left.
        """
        scaled = scaled_slip(slip)
        beyond = (scaled < self.scaled[0]) | (scaled > self.scaled[-1])
        reach = np.where(beyond, self.reach / 2, self.reach)
        return self.distance(slip) > reach + _SAME_SLIP

    def distance(self, slip: FloatArray) -> FloatArray:
        """Distance of each slip from the nearest tested one, scaled, shape (points,)."""
        scaled = scaled_slip(slip)
        above = np.searchsorted(self.scaled, scaled).clip(0, len(self.scaled) - 1)
        below = (above - 1).clip(0)
        to_above = np.abs(self.scaled[above] - scaled)
        return np.minimum(to_above, np.abs(self.scaled[below] - scaled))

    @property
    def few(self) -> bool:
        """Whether a curve has too few slips to show its shape."""
        return self.per_curve < _FEWEST_SLIPS


def support_codes(
    slips: SlipCoverage,
    slip: FloatArray,
    spread: FloatArray,
    of_constants: FloatArray,
    leaves_single_level: BoolArray,
) -> IndexArray:
    """Code of `Support` of each point; the last reason that applies counts, shape (points,).

    Args:
        slips: The tested slips.
        slip: Slide-roll ratio of each point, shape (points,).
        spread: Standard deviation of the surface in ln mu, shape (points,).
        of_constants: Standard deviation in ln mu by each constant that is at its bound,
            shape (points, constants at a bound).
        leaves_single_level: Whether a condition that was not varied has another value,
            shape (points,).
    """
    distance = slips.distance(slip)
    reasons: list[tuple[Support, BoolArray]] = [
        (Support.CONSTANT_AT_BOUND, np.any(of_constants > _BOUND_MATTERS, axis=1)),
        (Support.SPREAD_TOO_LARGE, spread > _LARGEST_SPREAD),
        (Support.FAR_FROM_TESTED_SLIPS, slips.is_far(slip)),
        (Support.FEW_SLIPS, slips.few & (distance > _SAME_SLIP)),
        (Support.CONDITION_NOT_VARIED, leaves_single_level),
    ]
    codes = np.full(len(slip), Support.SUPPORTED, dtype=np.int64)
    for reason, applies in reasons:
        codes[applies] = reason
    return codes
