"""Inputs of a bearing that no drawing gives exactly: each has a value and a range.

The attributes of `InputValues` are the names of these quantities. A bearing has some of them
(`Bearing.uncertain_inputs`), the settings have the others. A calculation takes one value of each
per operating point, so that draws are operating points with other values.

Decides: which inputs of a bearing are uncertain, and how they are drawn from their ranges.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray


class UncertainInput(NamedTuple):
    """A quantity with its range; NaN throughout where nothing is known.

    Attributes:
        value: The nominal value, with which a calculation without draws is made.
        low: Lower end of the range.
        high: Upper end of the range.
    """

    value: float
    low: float
    high: float

    def scaled(self, factor: float) -> "UncertainInput":
        """The quantity times a factor."""
        return UncertainInput(factor * self.value, factor * self.low, factor * self.high)

    def quantiles(self, probability: FloatArray) -> FloatArray:
        """Values of the quantity with a cumulative probability of 0 to 1.

        The value is the median, and both parts of the range are uniform. If the value is an end of
        the range, the whole range is uniform.

        Examples:
            >>> quarters = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
            >>> UncertainInput(value=1.0, low=0.0, high=5.0).quantiles(quarters)
            array([0. , 0.5, 1. , 3. , 5. ])
            >>> UncertainInput(value=5.0, low=1.0, high=5.0).quantiles(np.array([0.0, 0.5]))
            array([1., 3.])
        """
        if self.low < self.value < self.high:
            return np.interp(probability, [0.0, 0.5, 1.0], [self.low, self.value, self.high])
        return np.asarray(self.low + (self.high - self.low) * np.asarray(probability))


@dataclass(frozen=True)
class InputValues:
    """Values of the uncertain inputs, one per operating point; shapes (points,).

    Attributes:
        oil_volume_fraction: Share of oil in the volume through which the balls travel.
        feed_flow_m3_s: Volume flow of the oil that is fed to the bearing; NaN where unknown.
        momentum_share: Share of this flow that leaves the inner ring with the ring's speed.
        replenishment_constant: K_rs of `resistance.replenishment_factor`.
        ellipse_factor: Traction in the bearing's ellipse over that in the circle of a rig.
        shaft_bore_ratio: Bore of the shaft over the diameter at the bottom of the inner groove.
        shaft_interference_m: Interference of ring and shaft on the radius, before mounting.
        housing_interference_m: Interference of ring and housing on the radius; below 0 a clearance.
        ring_temperature_difference_k: Temperature of the inner ring less that of the outer ring.
        ball_temperature_difference_k: Temperature of the balls less the mean of both rings.
    """

    oil_volume_fraction: FloatArray
    feed_flow_m3_s: FloatArray
    momentum_share: FloatArray
    replenishment_constant: FloatArray
    ellipse_factor: FloatArray
    shaft_bore_ratio: FloatArray
    shaft_interference_m: FloatArray
    housing_interference_m: FloatArray
    ring_temperature_difference_k: FloatArray
    ball_temperature_difference_k: FloatArray

    @classmethod
    def nominal(
        cls, uncertain_inputs: Mapping[str, UncertainInput], point_count: int
    ) -> "InputValues":
        """The nominal value of each quantity, the same at all points.

        Args:
            uncertain_inputs: Every quantity of `INPUT_NAMES`, by its name.
            point_count: Number of operating points.
        """
        return cls(
            **{name: np.full(point_count, uncertain_inputs[name].value) for name in INPUT_NAMES}
        )

    @classmethod
    def drawn(
        cls,
        uncertain_inputs: Mapping[str, UncertainInput],
        probability_by_name: Mapping[str, FloatArray],
    ) -> "InputValues":
        """Values with given cumulative probabilities.

        Args:
            uncertain_inputs: Every quantity of `INPUT_NAMES`, by its name.
            probability_by_name: Cumulative probabilities of 0 to 1, shape (points,), by the name of
                the quantity.
        """
        return cls(
            **{
                name: uncertain_inputs[name].quantiles(probability_by_name[name])
                for name in INPUT_NAMES
            }
        )

    @classmethod
    def joined(cls, groups: Sequence["InputValues"]) -> "InputValues":
        """The points of several groups, one group after the other."""
        return cls(
            **{
                name: np.concatenate([getattr(group, name) for group in groups])
                for name in INPUT_NAMES
            }
        )

    def at_points(self, point_index: IndexArray) -> "InputValues":
        """The inputs of some of the points."""
        return InputValues(**{name: getattr(self, name)[point_index] for name in INPUT_NAMES})


# Names of the uncertain inputs.
INPUT_NAMES = tuple(field.name for field in fields(InputValues))
