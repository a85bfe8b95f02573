"""What the paper says of traction, each statement a share of a box of conditions where it holds.

Every printed sign was lost, but the text says what the curves look like. A statement's name is a
column of the table `signs`, whose description has the paper's own words and section. Nearly all
of section 4.3 describes figures that the authors drew from these very constants.

Arrays have the axes P, U, T, (S,) sign sets, so that all sign sets are scored at once.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, FloatArray

LAW = LAWS["deng2026"]  # whose constants are printed
STRESS, SPEED, TEMPERATURE, SLIP = range(4)  # axes


@dataclass(frozen=True)
class Limits:
    """What counts as believable, linear and slight.

    Attributes:
        traction_max: Largest believable mu.
        linear_r2_min: R2 of a straight line that counts as linear.
        decline_max: Share of the peak that a slight decline may lose.
    """

    traction_max: float
    linear_r2_min: float
    decline_max: float


@dataclass(frozen=True)
class Surface:
    """Eqs 7-9 over a box of conditions, for many sets of constants.

    Attributes:
        stress: Levels of P, in GPa.
        slip: Levels of S.
        low_slip, high_slip: The two slips that the text compares.
        largest_slip: The box's largest S.
        sizes: |A|, B and C of Eq. 7, axes coefficient, P, U, T, sets.
    """

    stress: FloatArray
    slip: FloatArray
    low_slip: float
    high_slip: float
    largest_slip: float
    sizes: FloatArray

    @classmethod
    def over(
        cls,
        box: Mapping[str, Sequence[float]],
        levels: int,
        slip: Sequence[float],
        compared: Sequence[float],
        internal: FloatArray,
    ) -> "Surface":
        """The surface over a box.

        Args:
            box: Lowest and highest value of each condition and of `slide_roll_ratio`.
            levels: Evenly spaced levels of each condition.
            slip: Levels of the slide-roll ratio.
            compared: Slips whose lowest and highest are compared.
            internal: Constants in the law's internal form, shape (constants, sets).
        """
        axes = [grid_levels(box, name, levels) for name in CONDITIONS]
        conditions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        sizes = LAW.sizes(internal, LAW.design(conditions))
        slips = (np.sort(slip), min(compared), max(compared), max(box["slide_roll_ratio"]))
        return cls(
            axes[STRESS], *slips, sizes.reshape(-1, levels, levels, levels, internal.shape[1])
        )

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

    @cached_property
    def slope(self) -> FloatArray:
        """Slope of the curve at zero slip: B + |A| C."""
        size, slope, rate = self.sizes
        return slope + size * rate

    @cached_property
    def knee(self) -> FloatArray:
        """Slip at which the straight start would reach the peak: the end of the linear range."""
        return self.peak / self.slope


@dataclass(frozen=True)
class Statement:
    """A statement about one oil.

    Attributes:
        score: Share of the box where it holds, for each sign set.
        box: The box it is about: what was tested (section 2), or what the figures of section 4.3
            draw (extrapolated).
        weight: 1 for the paper's words; 0.5 where a sentence can be read otherwise, or where the
            statement follows only by the physics that the sentence names.
    """

    score: Callable[[Surface, Limits], FloatArray]
    box: str = "extrapolated"
    weight: float = 1.0


def physical(surface: Surface, limits: Limits) -> FloatArray:
    """mu >= 0 by the signs of A, B and C; the peak stays below the largest believable mu."""
    return _share((surface.mu.min(axis=SLIP) >= 0) & (surface.peak <= limits.traction_max))


def rises_with_stress(surface: Surface, _: Limits) -> FloatArray:
    """Mu is larger at the next level of P."""
    return _share(np.diff(surface.mu, axis=STRESS) > 0)


def linear_in_stress(surface: Surface, limits: Limits) -> FloatArray:
    """mu(P) rises along a straight line, but for `1 - linear_r2_min` of its variance."""
    stress = surface.stress - surface.stress.mean()
    mu = surface.mu - surface.mu.mean(axis=STRESS, keepdims=True)
    covariance = np.tensordot(stress, mu, axes=1)
    r2 = covariance**2 / ((stress**2).sum() * (mu**2).sum(axis=STRESS))
    return _share((r2 >= limits.linear_r2_min) & (covariance > 0))


def falls_with_speed(surface: Surface, _: Limits) -> FloatArray:
    """Mu is smaller at the next level of U."""
    return _share(np.diff(surface.mu, axis=SPEED) < 0)


def levels_off_with_speed(surface: Surface, _: Limits) -> FloatArray:
    """Mu changes less over the last third of the speeds than it falls over the first."""
    return _share(_flattens(surface.mu, SPEED))


def falls_with_temperature(surface: Surface, _: Limits) -> FloatArray:
    """Mu is smaller at the next level of T."""
    return _share(np.diff(surface.mu, axis=TEMPERATURE) < 0)


def levels_off_with_temperature(surface: Surface, _: Limits) -> FloatArray:
    """The same of temperature: of 20 to 140 degC the thirds are 20-60 and 100-140."""
    return _share(_flattens(surface.mu, TEMPERATURE))


def start_falls_with_temperature(surface: Surface, _: Limits) -> FloatArray:
    """The slope at zero slip, where the oil is Newtonian, is smaller at the next level of T."""
    return _share(np.diff(surface.slope, axis=TEMPERATURE) < 0)


def rises_with_slip(surface: Surface, _: Limits) -> FloatArray:
    """Mu is larger at the high slip than at the low one."""
    return _share(surface.at(surface.high_slip) > surface.at(surface.low_slip))


def declines_slightly(surface: Surface, limits: Limits) -> FloatArray:
    """The peak lies within the slips, and at their end mu has lost `decline_max` of it at most."""
    end = surface.at(surface.largest_slip)
    slight = end >= (1 - limits.decline_max) * surface.peak
    return _share((surface.peak_slip < surface.largest_slip) & slight)


def earlier_plateau_with_stress(surface: Surface, _: Limits) -> FloatArray:
    """The linear range ends at smaller slip at the next level of P."""
    return _share(np.diff(surface.knee, axis=STRESS) < 0)


def earlier_plateau_with_speed(surface: Surface, _: Limits) -> FloatArray:
    """The same at the next level of U: one reading of the sentence."""
    return _share(np.diff(surface.knee, axis=SPEED) < 0)


def earlier_plateau_with_temperature(surface: Surface, _: Limits) -> FloatArray:
    """The same at the next level of T: the other reading."""
    return _share(np.diff(surface.knee, axis=TEMPERATURE) < 0)


def slip_raises_stress_effect(surface: Surface, _: Limits) -> FloatArray:
    """Over the range of P mu gains more at the high slip than it changes at the low one."""
    low, high = surface.at(surface.low_slip), surface.at(surface.high_slip)
    return _share(high[-1] - high[0] > np.abs(low[-1] - low[0]))


def speed_mutes_stress_effect(surface: Surface, _: Limits) -> FloatArray:
    """Over the range of P mu gains more at the lowest speed than it changes at the highest."""
    gain = surface.mu[-1] - surface.mu[0]
    return _share(gain[0] > np.abs(gain[-1]))


def speed_mutes_temperature_effect(surface: Surface, _: Limits) -> FloatArray:
    """Over the range of T mu loses more at the lowest speed than it changes at the highest."""
    loss = surface.mu[:, :, 0] - surface.mu[:, :, -1]
    return _share(loss[:, 0] > np.abs(loss[:, -1]))


STATEMENTS: dict[str, Statement] = {
    "physical": Statement(physical),
    "rises_with_stress": Statement(rises_with_stress),
    "linear_in_stress": Statement(linear_in_stress),
    "falls_with_speed": Statement(falls_with_speed),
    "levels_off_with_speed": Statement(levels_off_with_speed),
    "falls_with_temperature": Statement(falls_with_temperature),
    "levels_off_with_temperature": Statement(levels_off_with_temperature),
    "start_falls_with_temperature": Statement(start_falls_with_temperature, "tested", 0.5),
    "rises_with_slip": Statement(rises_with_slip),
    "declines_slightly": Statement(declines_slightly, "tested"),
    "earlier_plateau_with_stress": Statement(earlier_plateau_with_stress),
    "earlier_plateau_with_speed": Statement(earlier_plateau_with_speed, "tested", 0.5),
    "earlier_plateau_with_temperature": Statement(earlier_plateau_with_temperature, "tested", 0.5),
    "slip_raises_stress_effect": Statement(slip_raises_stress_effect),
    "speed_mutes_stress_effect": Statement(speed_mutes_stress_effect),
    "speed_mutes_temperature_effect": Statement(speed_mutes_temperature_effect),
}


def viscosity_order(
    surface: Surface, more_viscous: Sequence[Surface], less_viscous: Sequence[Surface]
) -> FloatArray:
    """Mu is below that of the next more viscous oil, and above that of the next less viscous one.

    The other oils' surfaces are of one set each. NaN where there is no other oil.
    """
    holds = [_share(surface.mu < other.mu) for other in more_viscous[-1:]]
    holds += [_share(surface.mu > other.mu) for other in less_viscous[:1]]
    return _mean(holds, surface)


def hot_convergence(surface: Surface, others: Sequence[Surface]) -> FloatArray:
    """Mu is nearer to that of each other oil at the highest temperature than at the lowest."""
    holds = []
    for other in others:
        apart = np.abs(surface.mu - other.mu)
        holds.append(_share(apart[:, :, -1] < apart[:, :, 0]))
    return _mean(holds, surface)


# Statements about several oils; each compares an oil with what the others are by their own.
BETWEEN_OILS = ("viscosity_order", "hot_convergence")


def grid_levels(box: Mapping[str, Sequence[float]], name: str, levels: int) -> FloatArray:
    """Evenly spaced levels of a condition over a box."""
    return np.linspace(min(box[name]), max(box[name]), levels)


def _share(holds: npt.NDArray[np.bool_]) -> FloatArray:
    """Share of all conditions and slips where something holds, for each sign set."""
    return holds.reshape(-1, holds.shape[-1]).mean(axis=0)


def _mean(shares: list[FloatArray], surface: Surface) -> FloatArray:
    return np.mean(shares, axis=0) if shares else np.full(surface.mu.shape[-1], np.nan)


def _flattens(mu: FloatArray, axis: int) -> npt.NDArray[np.bool_]:
    """Whether |change| over the last third of the levels is less than the fall over the first."""
    third = (mu.shape[axis] - 1) // 3
    level = np.moveaxis(mu, axis, 0)
    return level[0] - level[third] > np.abs(level[-1 - third] - level[-1])
