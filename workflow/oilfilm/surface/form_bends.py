"""What two levels of a condition leave open: a power law and an exponential agree at both.

Between two levels v1 and v2 the law changes ln mu by D, at the slip and the other conditions of a
point. A power law is linear in ln v, an exponential in v, so that they differ by g D with

    g = ln(v/v1) / ln(v2/v1) - (v - v1) / (v2 - v1)

Laws have power laws of the temperature in degC; films follow exponentials more nearly. At low slip,
where traction follows the viscosity, g D is up to a quarter of mu. The difference has a standard
deviation of one; nothing is chosen.
"""

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import unscaled_conditions


def form_bends(
    law: FreeLaw, box: ConditionBox, conditions: FloatArray, slip: FloatArray
) -> FloatArray:
    """g D of each condition with two levels, shape (points, conditions with two levels).

    Args:
        law: The law.
        box: The box of the tested conditions.
        conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
        slip: Slide-roll ratio, above 0, shape (points,).
    """
    lowest, highest = unscaled_conditions(np.stack([box.lowest, box.highest]))
    bends = [np.empty((len(slip), 0))]
    for dimension in np.flatnonzero(box.has_two_levels):
        at_lowest, at_highest = conditions.copy(), conditions.copy()
        at_lowest[:, dimension] = lowest[dimension]
        at_highest[:, dimension] = highest[dimension]
        change = law.log_mu(at_highest, slip) - law.log_mu(at_lowest, slip)
        level = conditions[:, dimension]
        ratio = highest[dimension] / lowest[dimension]
        power_law_share = np.log(level / lowest[dimension]) / np.log(ratio)
        exponential_share = (level - lowest[dimension]) / (highest[dimension] - lowest[dimension])
        bends.append(((power_law_share - exponential_share) * change)[:, np.newaxis])
    return np.hstack(bends)
