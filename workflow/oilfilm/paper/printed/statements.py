"""What the paper says of traction, each statement a share of a box of conditions where it holds.

Every printed sign was lost, but the text says what the curves look like. Nearly all of section 4.3
describes figures that the authors drew from these very constants. A statement's name is a
column of the table `signs`, which has its meaning and its section of the paper.

Arrays have the axes P, U, T, (S,) sign sets, so that all sign sets are scored at once.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from oilfilm.settings.config import SignSettings
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import BoolArray, FloatArray

LAW = DENG2026  # its constants are printed
STRESS, SPEED, TEMPERATURE, SLIP = range(4)  # axes
# Statements that count half: the slope at zero slip, where the oil is Newtonian, follows only by
# the physics that a sentence names, and two are readings of one sentence.
HALF = (
    "start_falls_with_temperature",
    *("earlier_plateau_with_speed", "earlier_plateau_with_temperature"),
)


@dataclass(frozen=True)
class Surface:
    """Eqs 7-9 over a box of conditions, for many sets of constants.

    Attributes:
        stress: Levels of P, in GPa.
        slip: Levels of S.
        largest_slip: The box's largest S.
        sizes: |A|, B and C of Eq. 7, axes coefficient, P, U, T, sets.
    """

    stress: FloatArray
    slip: FloatArray
    largest_slip: float
    sizes: FloatArray

    @classmethod
    def over(
        cls,
        box: Mapping[str, Sequence[float]],
        levels: int,
        slip: Sequence[float],
        internal: FloatArray,
    ) -> "Surface":
        """The surface over a box.

        Args:
            box: Lowest and highest value of each condition and of `slide_roll_ratio`.
            levels: Evenly spaced levels of each condition.
            slip: Levels of the slide-roll ratio.
            internal: Constants in the law's internal form, shape (constants, sets).
        """
        axes = [np.linspace(box[name][0], box[name][1], levels) for name in CONDITIONS]
        conditions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        sizes = LAW.sizes(internal, LAW.design(conditions))
        shape = -1, levels, levels, levels, internal.shape[1]
        largest = max(box["slide_roll_ratio"])
        return cls(axes[STRESS], np.sort(slip), largest, sizes.reshape(shape))

    @cached_property
    def mu(self) -> FloatArray:
        """Traction coefficient, axes P, U, T, S, sets."""
        return np.stack([self.at(slip) for slip in self.slip], axis=SLIP)

    def at(self, slip: FloatArray | float) -> FloatArray:
        """Traction coefficient at one slip, or at a slip of each condition; axes P, U, T, sets."""
        return LAW.value(self.sizes, np.asarray(slip))

    @cached_property
    def peak_slip(self) -> FloatArray:
        """Slip of the one peak, where dmu/dS = 0: 1/C + |A|/B."""
        size, slope, rate = self.sizes
        return 1 / rate + size / slope

    @cached_property
    def peak(self) -> FloatArray:
        """Largest mu within the box's slips."""
        return self.at(np.minimum(self.peak_slip, self.largest_slip))

    @property
    def slope(self) -> FloatArray:
        """Slope of the curve at zero slip: B + |A| C."""
        size, slope, rate = self.sizes
        return slope + size * rate

    @cached_property
    def knee(self) -> FloatArray:
        """Slip at which the straight start would reach the peak: the end of the linear range."""
        return self.peak / self.slope


def where_true(
    tested: Surface,
    drawn: Surface,
    compared: Sequence[float],
    traction_max: float,
    limits: SignSettings,
) -> dict[str, BoolArray]:
    """Where each statement about one oil holds, for each sign set: the last axis.

    Args:
        tested: The box that was tested (section 2).
        drawn: The box that the figures of section 4.3 draw.
        compared: Slips whose lowest and highest the text compares.
        traction_max: Largest believable mu.
        limits: What counts as linear and slight.
    """
    mu = drawn.mu
    low, high = drawn.at(min(compared)), drawn.at(max(compared))
    # R2 of the straight line mu(P) is covariance^2/variances
    stress, off = drawn.stress - drawn.stress.mean(), mu - mu.mean(axis=STRESS, keepdims=True)
    covariance = np.tensordot(stress, off, axes=1)
    variances = (stress**2).sum() * (off**2).sum(axis=STRESS)
    linear = covariance**2 >= limits.linear_r2_min * variances
    slight = tested.at(tested.largest_slip) >= (1 - limits.decline_max) * tested.peak
    # change by stress and by temperature at the lowest speed and at the highest one
    of_stress, of_heat = (mu[-1] - mu[0])[[0, -1]], (mu[:, :, 0] - mu[:, :, -1])[:, [0, -1]]
    return {
        "physical": (mu.min(axis=SLIP) >= 0) & (drawn.peak <= traction_max),
        "rises_with_stress": np.diff(mu, axis=STRESS) > 0,
        "linear_in_stress": linear & (covariance > 0),
        "falls_with_speed": _falls(mu, SPEED),
        "levels_off_with_speed": _levels_off(mu, SPEED),
        "falls_with_temperature": _falls(mu, TEMPERATURE),
        "levels_off_with_temperature": _levels_off(mu, TEMPERATURE),
        "start_falls_with_temperature": _falls(tested.slope, TEMPERATURE),
        "rises_with_slip": high > low,
        "declines_slightly": (tested.peak_slip < tested.largest_slip) & slight,
        "earlier_plateau_with_stress": _falls(drawn.knee, STRESS),
        "earlier_plateau_with_speed": _falls(tested.knee, SPEED),
        "earlier_plateau_with_temperature": _falls(tested.knee, TEMPERATURE),
        "slip_raises_stress_effect": high[-1] - high[0] > np.abs(low[-1] - low[0]),
        "speed_mutes_stress_effect": of_stress[0] > np.abs(of_stress[1]),
        "speed_mutes_temperature_effect": of_heat[:, 0] > np.abs(of_heat[:, 1]),
    }


def viscosity_order(
    surface: Surface, more_viscous: Sequence[Surface], less_viscous: Sequence[Surface]
) -> FloatArray:
    """Mu is below that of the next more viscous oil, and above that of the next less viscous one.

    The other oils' surfaces are of one set each. NaN where there is no other oil.
    """
    holds = [surface.mu < other.mu for other in more_viscous[-1:]]
    holds += [surface.mu > other.mu for other in less_viscous[:1]]
    return _mean(holds, surface)


def hot_convergence(surface: Surface, others: Sequence[Surface]) -> FloatArray:
    """Mu is nearer to that of each other oil at the highest temperature than at the lowest."""
    apart = [np.abs(surface.mu - other.mu) for other in others]
    return _mean([gap[:, :, -1] < gap[:, :, 0] for gap in apart], surface)


def share(holds: BoolArray) -> FloatArray:
    """Share of all conditions and slips where something holds, for each sign set."""
    return holds.reshape(-1, holds.shape[-1]).mean(axis=0)


def _mean(holds: list[BoolArray], surface: Surface) -> FloatArray:
    nothing = np.full(surface.mu.shape[-1], np.nan)
    return np.mean([share(each) for each in holds], axis=0) if holds else nothing


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Smaller at the next level of an axis."""
    return np.diff(values, axis=axis) < 0


def _levels_off(mu: FloatArray, axis: int) -> BoolArray:
    """Mu changes less over the last third of the levels than it falls over the first.

    Of 20 to 140 degC the thirds are 20-60 and 100-140.
    """
    level = np.moveaxis(mu, axis, 0)
    third = (len(level) - 1) // 3
    return np.asarray(level[0] - level[third] > np.abs(level[-1 - third] - level[-1]))
