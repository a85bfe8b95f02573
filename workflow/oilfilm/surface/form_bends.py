"""What two levels of a condition leave open: a power law and an exponential agree at both.

Between the levels v1 and v2 of a condition, the law changes ln mu by D, at the slip and the other
conditions of a point. By a power law ln mu is linear in ln v, by an exponential in v. The two
differ by g D with

    g = ln(v/v1) / ln(v2/v1) - (v - v1) / (v2 - v1)

Laws have power laws of the temperature in degC; films follow exponentials more nearly. At low slip,
where traction follows the viscosity, g D is up to a quarter of mu. The difference has a standard
deviation of one; no form is chosen.

A power of a temperature in degC has no value at 0 and below. Where a level is there, no power law
is expected, and g is 0. Far below the lowest level a power law is taken at a thousandth of it.

Where the law has no traction at one of the levels, its mu there is taken as a thousandth of that at
the other level. Where it has none at both, D is 0.
"""

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import unscaled_conditions

# Smallest value of a condition in a power law, over the lowest level.
_SMALLEST_RATIO = 1e-3
# Largest size of D.
_LARGEST_CHANGE = np.log(1e3)


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
    lowest_conditions, highest_conditions = unscaled_conditions(np.stack([box.lowest, box.highest]))
    bends = [np.empty((len(slip), 0))]
    for condition_column in np.flatnonzero(box.has_two_levels):
        lowest = lowest_conditions[condition_column]
        highest = highest_conditions[condition_column]
        if lowest <= 0:
            bends.append(np.zeros((len(slip), 1)))
            continue
        conditions_at_lowest = conditions.copy()
        conditions_at_lowest[:, condition_column] = lowest
        conditions_at_highest = conditions.copy()
        conditions_at_highest[:, condition_column] = highest
        change = _bounded_difference(
            law.log_mu(conditions_at_highest, slip), law.log_mu(conditions_at_lowest, slip)
        )
        value = conditions[:, condition_column]
        ratio = np.maximum(value / lowest, _SMALLEST_RATIO)
        power_law_share = np.log(ratio) / np.log(highest / lowest)
        exponential_share = (value - lowest) / (highest - lowest)
        bends.append(((power_law_share - exponential_share) * change)[:, np.newaxis])
    return np.hstack(bends)


def _bounded_difference(log_mu: FloatArray, other_log_mu: FloatArray) -> FloatArray:
    """Difference of two ln mu, shape (points,), of which either is not finite without traction."""
    with np.errstate(invalid="ignore"):
        bounded_log_mu = np.fmax(log_mu, other_log_mu - _LARGEST_CHANGE)
        bounded_other = np.fmax(other_log_mu, bounded_log_mu - _LARGEST_CHANGE)
        return np.nan_to_num(bounded_log_mu - bounded_other)
