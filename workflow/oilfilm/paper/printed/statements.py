"""What the paper says of traction, each statement a share of a box of conditions where it holds.

Every printed sign was lost, but the text says what the curves look like. Nearly all of section 4.3
describes figures that the authors drew from these very constants. A statement's name is a
column of the table `signs`, which has its meaning and its section of the paper.

Arrays have the axes P, U, T, (S,) sign sets, so that all sign sets are scored at once.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import BoolArray, FloatArray

LAW = DENG2026  # its constants are printed
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
        compared: The lowest and the highest of the slips that the text compares.
        largest_slip: The box's largest S.
        sizes: |A|, B and C of Eq. 7, axes coefficient, P, U, T, sets.
    """

    stress: FloatArray
    slip: FloatArray
    compared: tuple[float, float]
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
        axes = [np.linspace(box[name][0], box[name][1], levels) for name in CONDITIONS]
        conditions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        sizes = LAW.sizes(internal, LAW.design(conditions))
        shape = -1, levels, levels, levels, internal.shape[1]
        ends = min(compared), max(compared)
        largest = max(box["slide_roll_ratio"])
        return cls(axes[STRESS], np.sort(slip), ends, largest, sizes.reshape(shape))

    @cached_property
    def mu(self) -> FloatArray:
        """Traction coefficient, axes P, U, T, S, sets."""
        return np.stack([self.at(slip) for slip in self.slip], axis=SLIP)

    def at(self, slip: FloatArray | float) -> FloatArray:
        """Traction coefficient at one slip, or at a slip of each condition; axes P, U, T, sets."""
        return LAW.value(self.sizes, np.asarray(slip))

    @cached_property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """Traction coefficient at the low and at the high slip that the text compares."""
        return self.at(self.compared[0]), self.at(self.compared[1])

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


Holds = Callable[[Surface, Limits], BoolArray]


@dataclass(frozen=True)
class Statement:
    """A statement about one oil.

    Attributes:
        holds: Where it holds, for each sign set; the last axis is that of the sets.
        box: The box it is about: what was tested (section 2), or what the figures of section 4.3
            draw (extrapolated).
        weight: 1 for the paper's words; 0.5 where a sentence can be read otherwise, or where the
            statement follows only by the physics that the sentence names.
    """

    holds: Holds
    box: str = "extrapolated"
    weight: float = 1.0

    def score(self, surface: Surface, limits: Limits) -> FloatArray:
        """Share of the box where it holds, for each sign set."""
        return _share(self.holds(surface, limits))


def _falls(axis: int, quantity: Literal["mu", "slope", "knee"] = "mu") -> Holds:
    """Mu, or another quantity of the surface, is smaller at the next level of an axis."""
    return lambda surface, _: np.diff(getattr(surface, quantity), axis=axis) < 0


def _levels_off(axis: int) -> Holds:
    """Mu changes less over the last third of the levels than it falls over the first.

    Of 20 to 140 degC the thirds are 20-60 and 100-140.
    """

    def holds(surface: Surface, _: Limits) -> BoolArray:
        level = np.moveaxis(surface.mu, axis, 0)
        third = (len(level) - 1) // 3
        return level[0] - level[third] > np.abs(level[-1 - third] - level[-1])

    return holds


def _muted_by_speed(change: Callable[[FloatArray], FloatArray]) -> Holds:
    """Mu changes more at the lowest speed than at the highest; `change` drops another axis."""

    def holds(surface: Surface, _: Limits) -> BoolArray:
        slow, fast = (change(np.take(surface.mu, at, axis=SPEED)) for at in (0, -1))
        return slow > np.abs(fast)

    return holds


def _physical(surface: Surface, limits: Limits) -> BoolArray:
    return (surface.mu.min(axis=SLIP) >= 0) & (surface.peak <= limits.traction_max)


def _linear_in_stress(surface: Surface, limits: Limits) -> BoolArray:
    stress = surface.stress - surface.stress.mean()
    mu = surface.mu - surface.mu.mean(axis=STRESS, keepdims=True)
    covariance = np.tensordot(stress, mu, axes=1)
    r2 = covariance**2 / ((stress**2).sum() * (mu**2).sum(axis=STRESS))
    return (r2 >= limits.linear_r2_min) & (covariance > 0)


def _declines_slightly(surface: Surface, limits: Limits) -> BoolArray:
    slight = surface.at(surface.largest_slip) >= (1 - limits.decline_max) * surface.peak
    return (surface.peak_slip < surface.largest_slip) & slight


def _slip_raises_stress_effect(surface: Surface, _: Limits) -> BoolArray:
    low, high = surface.ends
    return high[-1] - high[0] > np.abs(low[-1] - low[0])


# Columns of the table `signs`, whose meanings say where the paper says so.
STATEMENTS: dict[str, Statement] = {
    "physical": Statement(_physical),
    "rises_with_stress": Statement(lambda at, _: np.diff(at.mu, axis=STRESS) > 0),
    "linear_in_stress": Statement(_linear_in_stress),
    "falls_with_speed": Statement(_falls(SPEED)),
    "levels_off_with_speed": Statement(_levels_off(SPEED)),
    "falls_with_temperature": Statement(_falls(TEMPERATURE)),
    "levels_off_with_temperature": Statement(_levels_off(TEMPERATURE)),
    # the slope at zero slip, where the oil is Newtonian
    "start_falls_with_temperature": Statement(_falls(TEMPERATURE, "slope"), "tested", 0.5),
    "rises_with_slip": Statement(lambda at, _: at.ends[1] > at.ends[0]),
    "declines_slightly": Statement(_declines_slightly, "tested"),
    "earlier_plateau_with_stress": Statement(_falls(STRESS, "knee")),
    # two readings of one sentence
    "earlier_plateau_with_speed": Statement(_falls(SPEED, "knee"), "tested", 0.5),
    "earlier_plateau_with_temperature": Statement(_falls(TEMPERATURE, "knee"), "tested", 0.5),
    "slip_raises_stress_effect": Statement(_slip_raises_stress_effect),
    "speed_mutes_stress_effect": Statement(_muted_by_speed(lambda mu: mu[-1] - mu[0])),
    "speed_mutes_temperature_effect": Statement(_muted_by_speed(lambda mu: mu[:, 0] - mu[:, -1])),
}
# Statements about several oils; each compares an oil with what the others are by their own.
BETWEEN_OILS = ("viscosity_order", "hot_convergence")


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


def _share(holds: BoolArray) -> FloatArray:
    """Share of all conditions and slips where something holds, for each sign set."""
    return holds.reshape(-1, holds.shape[-1]).mean(axis=0)


def _mean(holds: list[BoolArray], surface: Surface) -> FloatArray:
    nothing = np.full(surface.mu.shape[-1], np.nan)
    return np.mean([_share(each) for each in holds], axis=0) if holds else nothing
