"""Laws with constants that tests know, and the box in which they count as tested."""

from dataclasses import replace

import numpy as np

from campaigns import printed
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.traction.laws.deng2026 import DENG2026

# GPa, m/s, degC and slide-roll ratio that Deng et al. (2026) say they tested (abstract).
TESTED = np.array([[1.0, 1.5], [25.0, 40.0], [25.0, 120.0], [0.0, 0.3]])


def known_law(oil: str) -> FittedLaw:
    """The law of Deng et al. (2026) with the constants that they print for an oil."""
    coefficients = Coefficients.from_constants(DENG2026, printed()[oil])
    return FittedLaw(DENG2026, replace(coefficients, tested_box=TESTED))
