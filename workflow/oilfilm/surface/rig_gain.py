"""The gain of a rig that made none of the runs.

The gain of a rig is the relative error of traction force that all its runs share. The gains of rigs
are normally distributed. Their standard deviation s is not known exactly: a few rigs show it in
part, and there is a prior. With n gains that the data resolve, the density of ln s is

    p(ln s) ~ s^-n exp(-n v / (2 s^2)) exp(-(ln s - ln m)^2 / (2 r^2)),

where v is the mean square of the resolved gains, m the prior median of s, and r the prior standard
deviation of ln s. The last factor is the prior of s, and p its posterior.

The gain of another rig is a mixture of normal distributions over this posterior. With a flat prior
of ln s the gain follows Student's t with n degrees of freedom. Without resolved gains (n = 0) the
posterior is the prior.

Where the search has found the most likely s, the derivative of ln p is 0 there. This gives n v.

Reference: A. Gelman and others, Bayesian Data Analysis, 3rd ed. (2013), section 5.4 (groups whose
standard deviation is not known).

Decides: how far the gain of another rig may be.
"""

import numpy as np
import scipy

from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import LogNormal
from oilfilm.surface.interval import normal_half_width

# Number of standard deviations s at which the posterior is evaluated.
_GRID_POINT_COUNT = 2001


def resolved_gain_count(covariance: FloatArray) -> float:
    """Number of gains of rigs that the data resolve.

    It is half of the Fisher information on ln s. Of rigs that all ran the same conditions it is one
    less than there are rigs, because their mean belongs to the law. Of rigs that ran one level of a
    condition each it is near 0.

    Args:
        covariance: Covariance of the gains given the data, in units of s^2, shape (rigs, rigs).
    """
    resolution_matrix = np.eye(len(covariance)) - covariance
    return float(np.sum(resolution_matrix**2))


def factor_of_another_rig(
    gain_sd: float, gain_count: float, gain_sd_prior: LogNormal, level: float
) -> float:
    """Factor on the standard deviation of the gains, for the gain of another rig.

    Args:
        gain_sd: The most likely standard deviation s.
        gain_count: Number of gains that the data resolve, as `resolved_gain_count` gives it.
        gain_sd_prior: Prior of s.
        level: Share of other rigs that the interval should hold.

    Returns:
        The quantile of the gain of another rig over that of a normal distribution with s.
    """
    ln_sds = np.linspace(
        np.log(gain_sd_prior.smallest), np.log(gain_sd_prior.largest), _GRID_POINT_COUNT
    )
    # derivative of the logarithm of the prior by ln s, at the most likely s
    prior_slope = -(np.log(gain_sd) - np.log(gain_sd_prior.median)) / gain_sd_prior.ln_sd**2
    # n v
    sum_of_squares = max(gain_sd**2 * (gain_count - prior_slope), 0.0)
    ln_density = (
        -gain_count * ln_sds
        - sum_of_squares / 2 * np.exp(-2 * ln_sds)
        - ((ln_sds - np.log(gain_sd_prior.median)) / gain_sd_prior.ln_sd) ** 2 / 2
    )
    weights = scipy.special.softmax(ln_density)
    sds = np.exp(ln_sds)

    def excess_share(gain: float) -> float:
        """Share of other rigs whose gain is farther from 0 than this one, less the wanted share."""
        return float(weights @ (2 * scipy.special.ndtr(-gain / sds))) - (1 - level)

    nearest = normal_half_width(level) * gain_sd_prior.smallest
    farthest = normal_half_width(level) * gain_sd_prior.largest
    quantile = scipy.optimize.brentq(excess_share, nearest, farthest)
    return float(quantile / (normal_half_width(level) * gain_sd))
