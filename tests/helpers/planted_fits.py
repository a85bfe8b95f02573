"""Fits with planted constants and refits, of any law."""

import numpy as np

from oilfilm.fits.conditions import FixedCondition, InStep
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.fits.interval import Unseen
from oilfilm.traction.law import Law, bounds, to_constants


def planted_fit(law: Law) -> tuple[FittedLaw, float, int]:
    """A fit that does not follow the speed, which varied in step with load or pressure.

    Returns:
        The fit, and factor and power by which the law's first condition goes with the pressure.
    """
    random, ends = np.random.default_rng(9), bounds(law)
    # thick and thin films, refits scattered by 5 %
    internal = ends[:, 0] + (ends[:, 1] - ends[:, 0]) * random.uniform(0.4, 0.6, len(ends))
    given = [constant.known is not None for constant in law.constants]
    internal = np.where(given, law.known, internal)
    scattered = internal + np.where(given, 0, 0.05) * random.standard_normal((30, len(ends)))
    factor, power = (42.0, 3) if "load_n" in law.conditions else (1.0, 1)
    box = np.array([[1.0, 1.5], [25.0, 40.0], [25.0, 120.0], [0.0, 0.3]])
    box[0] = factor * box[0] ** power
    line = InStep(law.conditions[0], box[0].mean(), 0.5)
    speed = FixedCondition("entrainment_speed_m_s", 32.0, 2.0, (line,))
    spread, known = to_constants(law, scattered), np.array([True, False, True])
    constants = to_constants(law, internal)
    two_levels = ("inlet_temperature_c",)
    rest = (box, (speed,), Unseen(2e-5, 0.01, 0.02, np.full(5, 1.7)), 20.0, two_levels)
    fit = Coefficients(constants, known, spread, spread[:3], *rest)
    return FittedLaw(law, fit), factor, power
