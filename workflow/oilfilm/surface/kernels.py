"""Covariance of the departure of ln mu from a law, over slip and conditions.

    k = w(t) w(t') (C_E(x, x') + C_G(x, x') M(t, t'))

with t the scaled slip, x the scaled conditions about the middle of the tested box, M Matern-5/2 and
w = r^((t - t_m)/t_r), where t_r is the scaled slip of 0.3 and t_m its half. r is the size at a slip
of 0.3 over that at rolling: at low slip traction follows the viscosity, and a law misses more of
it.

    C_E = A + B/2,   C_G = (A + B)/2
    A = kappa^2 (4 + sum_d x_d x_d' + sum_(d<e) x_d x_e x_d' x_e')
    B = kappa^2 (sum a_d^2 M_d + p^2 M_P M_U M_T) + bends

so that k = w(t) w(t') [A (1 + M/2) + B (1 + M)/2]. kappa is the standard deviation of a term that
is linear in one condition (`DepartureSizes`). The main effect a_d of condition d and the
interaction p are in units of kappa. A condition with two levels has no main effect a_d: between two
levels no data can check the law. In its place there is a bend, which kappa does not scale.

Decides: the smoothness of a surface; the bend of traction between two levels of a condition.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import LogNormal
from oilfilm.surface.measurements import scaled_slip

# Standard deviation of ln mu in the middle between two levels of P, U and T, as oils bend there.
_BEND_SD = (0.05, 0.03, 0.08)
_LEVELS_THAT_SHOW_A_BEND = 3
# Number of conditions: P, U and T.
_CONDITIONS = 3
# Slip at which `DepartureSizes.slip_trend` is given.
_TREND_SLIP = 0.3
# Variance of the constant part over that of the linear part.
_CONSTANT_VARIANCE = 4.0

# Priors of the sizes of `DepartureSizes`.
MAIN_EFFECT_PRIOR = LogNormal(median=0.5, ln_sd=1.0, smallest=0.02, largest=10.0)
INTERACTION_PRIOR = LogNormal(median=0.3, ln_sd=1.0, smallest=0.02, largest=10.0)
# The longest lengths are about half the range of slips and twice that of conditions: with longer
# ones a departure would be rigid, and no departure between the tested points could be expected.
SLIP_TREND_PRIOR = LogNormal(median=0.5, ln_sd=0.7, smallest=0.1, largest=2.0)
SLIP_LENGTH_PRIOR = LogNormal(median=1.5, ln_sd=0.4, smallest=0.3, largest=2.5)
CONDITION_LENGTH_PRIOR = LogNormal(median=1.0, ln_sd=0.5, smallest=0.15, largest=3.0)


def matern(distance: FloatArray) -> FloatArray:
    """Matern-5/2 correlation (1 + r + r^2/3) exp(-r) with r = sqrt(5) d.

    Args:
        distance: Distance d, in units of the correlation length.

    Reference: C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning (2006),
    Eq. 4.17.

    >>> round(float(matern(np.array(1.0))), 5)
    0.52399
    """
    r = np.sqrt(5.0) * np.abs(distance)
    return (1 + r + r**2 / 3) * np.exp(-r)


def matern_slope(distance: FloatArray) -> FloatArray:
    """Derivative of `matern` by the logarithm of the length: r^2 (1 + r) exp(-r) / 3."""
    r = np.sqrt(5.0) * np.abs(distance)
    return r**2 * (1 + r) * np.exp(-r) / 3


@dataclass(frozen=True)
class DepartureSizes:
    """Sizes (standard deviations and lengths) of the departure from the law.

    The whole departure is larger than kappa. At the middle slip its standard deviation is 2.6 kappa
    in the middle of the tested box. It is 4.0 kappa where each condition is one scaled unit from
    there. Both are for the medians of the priors, and three levels or more of each condition.

    Attributes:
        kappa: Standard deviation of the term that is linear in one condition and the same at all
            slips, in ln mu per scaled unit of the condition.
        main: Sizes of the main effects of P, U and T, in units of kappa, shape (3,).
        interaction: Size of the interaction, in units of kappa.
        slip_length: Correlation length over the scaled slip.
        lengths: Correlation lengths over the scaled P, U and T, shape (3,).
        slip_trend: r, the size at a slip of 0.3 over that at rolling.
    """

    kappa: float
    main: FloatArray
    interaction: float
    slip_length: float
    lengths: FloatArray
    slip_trend: float

    def size_at_slips(self, scaled_slips: FloatArray) -> FloatArray:
        """w, the size at each scaled slip over that in the middle."""
        return self.slip_trend ** trend_exponent(scaled_slips)


def trend_exponent(scaled_slips: FloatArray) -> FloatArray:
    """Power of the trend at each scaled slip: -1/2 at rolling, 1/2 at a slip of 0.3."""
    return np.asarray(scaled_slips / scaled_slip(np.array(_TREND_SLIP)) - 0.5)


@dataclass(frozen=True)
class ConditionBox:
    """The tested conditions, in scaled units.

    Attributes:
        lowest: Lowest P, U and T, shape (3,).
        highest: Highest P, U and T, shape (3,).
        level_counts: Number of levels of P, of U and of T, shape (3,).
        scaled_level_widths: Largest range of one level of P, of U and of T, shape (3,).
    """

    lowest: FloatArray
    highest: FloatArray
    level_counts: IndexArray
    scaled_level_widths: FloatArray

    def centred(self, scaled: FloatArray) -> FloatArray:
        """Scaled conditions less the middle of the box, shape (rows, 3)."""
        return scaled - (self.lowest + self.highest) / 2

    def bends(self, centred: FloatArray) -> FloatArray:
        """Parabolas with the value `_BEND_SD` in the middle and 0 at two levels, shape (rows, 3).

        A condition with another number of levels has none.
        """
        half_range = (self.highest - self.lowest) / 2
        bends = np.zeros_like(centred)
        for condition_column in np.flatnonzero(self.has_two_levels):
            ratio = centred[:, condition_column] / half_range[condition_column]
            bends[:, condition_column] = _BEND_SD[condition_column] * (1 - ratio**2)
        return bends

    @property
    def has_two_levels(self) -> BoolArray:
        """Whether each condition has two levels, shape (3,)."""
        return self.level_counts == 2

    def distance_in_ranges(self, centred: FloatArray) -> FloatArray:
        """Distance of each row from the box, in units of the tested range, shape (rows,).

        The condition farthest outside counts. The distance is 0 inside the box, and infinite where
        a condition that was not varied has another value.
        """
        tested_range = self.highest - self.lowest
        beyond = np.maximum(np.abs(centred) - tested_range / 2, 0.0)
        has_one_level = self.level_counts == 1
        in_ranges = beyond / np.where(has_one_level, 1.0, tested_range)
        off_level = np.where(np.abs(centred) > self.scaled_level_widths, np.inf, 0.0)
        return np.max(np.where(has_one_level, off_level, in_ranges), axis=1)

    @property
    def shows_bends(self) -> FloatArray:
        """1 for conditions with three levels or more, else 0, shape (3,)."""
        return (self.level_counts >= _LEVELS_THAT_SHOW_A_BEND).astype(float)


@dataclass(frozen=True)
class ConditionKernel:
    """The factors C_E and C_G of the covariance between rows of conditions.

    "Centred" conditions are those of `ConditionBox.centred`.

    Attributes:
        box: The tested conditions.
        sizes: The sizes of the departure.
    """

    box: ConditionBox
    sizes: DepartureSizes

    def factors(
        self, centred: FloatArray, other_centred: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """C_E and C_G, shape (rows, other rows) each.

        Args:
            centred: Centred conditions of the rows of the result, shape (rows, 3).
            other_centred: Centred conditions of its columns, shape (other rows, 3).
        """
        rigid = self._rigid(centred[:, np.newaxis], other_centred[np.newaxis])
        curved = self._curved(centred, other_centred)
        return rigid + curved / 2, (rigid + curved) / 2

    def variances(self, centred: FloatArray) -> FloatArray:
        """C_E + C_G of each row with itself, shape (rows,)."""
        rigid = self._rigid(centred, centred)
        sizes = self.sizes
        main_and_interaction = np.sum(self.box.shows_bends * sizes.main**2) + sizes.interaction**2
        bends = np.sum(self.box.bends(centred) ** 2, axis=1)
        curved = sizes.kappa**2 * main_and_interaction + bends
        return 1.5 * rigid + curved

    def slopes(self, centred: FloatArray) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Derivatives of C_E and C_G among rows by the logarithm of each size, by name of the size.

        Names of sizes: kappa, main_0 to main_2, interaction, length_0 to length_2.
        """
        sizes = self.sizes
        correlations = self._correlations(centred, centred)
        main = sizes.kappa**2 * self.box.shows_bends * sizes.main**2
        interaction = sizes.kappa**2 * sizes.interaction**2
        product = np.prod(correlations, axis=0)
        rigid = self._rigid(centred[:, np.newaxis], centred[np.newaxis])
        curved_without_bends = np.tensordot(main, correlations, axes=1) + interaction * product
        slopes_by_size_name = {
            "kappa": (2 * rigid + curved_without_bends, rigid + curved_without_bends)
        }
        slopes_by_size_name["interaction"] = _slopes_by_curved(2 * interaction * product)
        for condition_column in range(_CONDITIONS):
            column = centred[:, condition_column]
            distance = np.subtract.outer(column, column) / sizes.lengths[condition_column]
            slope = matern_slope(distance)
            other_correlations = np.prod(np.delete(correlations, condition_column, axis=0), axis=0)
            slopes_by_size_name[f"main_{condition_column}"] = _slopes_by_curved(
                2 * main[condition_column] * correlations[condition_column]
            )
            slopes_by_size_name[f"length_{condition_column}"] = _slopes_by_curved(
                (main[condition_column] + interaction * other_correlations) * slope
            )
        return slopes_by_size_name

    def _rigid(self, centred: FloatArray, other_centred: FloatArray) -> FloatArray:
        """A: the constant, linear and bilinear part; the last axis of the arguments is summed."""
        products = centred * other_centred
        total = np.sum(products, axis=-1)
        pairs = (total**2 - np.sum(products**2, axis=-1)) / 2
        return self.sizes.kappa**2 * (_CONSTANT_VARIANCE + total + pairs)

    def _curved(self, centred: FloatArray, other_centred: FloatArray) -> FloatArray:
        """B: main effects, interaction and bends."""
        sizes = self.sizes
        correlations = self._correlations(centred, other_centred)
        main = np.tensordot(self.box.shows_bends * sizes.main**2, correlations, axes=1)
        interaction = sizes.interaction**2 * np.prod(correlations, axis=0)
        bends = self.box.bends(centred) @ self.box.bends(other_centred).T
        return sizes.kappa**2 * (main + interaction) + bends

    def _correlations(self, centred: FloatArray, other_centred: FloatArray) -> FloatArray:
        """Matern correlation over each condition, shape (3, rows, other rows)."""
        distance = centred.T[:, :, np.newaxis] - other_centred.T[:, np.newaxis, :]
        return matern(distance / self.sizes.lengths[:, np.newaxis, np.newaxis])


def _slopes_by_curved(slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Derivatives of C_E and C_G from that of B."""
    return slope / 2, slope / 2
