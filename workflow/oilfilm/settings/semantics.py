"""How a rig's logs are meant: signs, definitions and the zero, as the campaign file says."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Semantics:
    """How the signals of one rig are to be taken.

    Attributes:
        traction_sign: -1 where the sensor's output falls when the disc, being faster, drags the
            ball along.
        slower_body: `ball` or `disc`; slide-roll ratio and traction are positive with it slowed.
        slide_roll_ratio: Definition of a logged one: sliding speed `over_mean`, `over_sum` or
            `over_faster` surface speed.
        zero: Where the zero of the force comes from: `rolling_phases` (opening and closing),
            `opening_phase` alone, or `already_removed` by the rig.
    """

    traction_sign: int = 1
    slower_body: str = "ball"
    slide_roll_ratio: str = "over_mean"
    zero: str = "rolling_phases"

    @property
    def direction(self) -> int:
        """What makes sliding and force positive with the slower body slowed."""
        return 1 if self.slower_body == "ball" else -1

    def over_mean(self, logged: FloatArray) -> FloatArray:
        """The slide-roll ratio (sliding over mean speed) of one logged by another definition."""
        if self.slide_roll_ratio == "over_sum":
            return 2 * logged
        if self.slide_roll_ratio == "over_faster":
            # s = (f - g)/f with f faster: (f - g)/((f + g)/2) = s/(1 - s/2); odd in the sign of s
            # twice the faster body's speed is no sliding speed; what comes of it is refused
            with np.errstate(divide="ignore"):
                return np.asarray(logged / (1 - np.abs(logged) / 2))
        return logged


def semantics_of(campaign: Mapping[str, Any], rig: str) -> Semantics:
    """What the campaign file says of its rigs in general and of this one."""
    general = campaign.get("semantics", {})
    return Semantics(**{**general, **campaign.get("semantics_of_rig", {}).get(rig, {})})
