"""What a fit has solved, before it becomes tables."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from oilfilm.fits.engine import Optimum
from oilfilm.fits.interval import Unseen
from oilfilm.fits.objectives import Alternative
from oilfilm.fits.problem import CurveData, Problem
from oilfilm.fits.uncertainty import Estimates
from oilfilm.units import FloatArray


@dataclass(frozen=True)
class Solution:
    """One law fitted to one oil.

    Attributes:
        problem: What was fitted; constants that ran into a bound are held there.
        data: The curves it was fitted to.
        best: The best end of the searches.
        certificate: Whether the searches agree, and at what kind of optimum.
        estimates: The free constants with their errors.
        profile: As `oilfilm.fits.profile.profiles`.
        robust: The fit with a robust loss; None for an exact fit.
        left_out: Error of each point's mu by a fit that has not seen its curve, NaN where there is
            none.
        unseen: What these errors say of a further run.
        refits_at_bounds: Refits of which a constant ended at a bound; they are not among the
            estimates' refits.
    """

    problem: Problem
    data: CurveData
    best: Optimum
    certificate: Mapping[str, Any]
    estimates: Estimates
    profile: tuple[FloatArray, FloatArray]
    robust: Alternative | None
    left_out: FloatArray
    unseen: Unseen
    refits_at_bounds: int
