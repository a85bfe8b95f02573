"""Sliding and traction inside the contact ellipse of a ball and a race.

The surfaces slide for three reasons: the ball spins against the race, the distance from the ball's
axis changes across the groove, and the contact as a whole slips. A traction law gives the local
traction coefficient; Hertz's pressure gives the weight of each quadrature node.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import Contacts, Motion
from oilfilm.physics.contact import Conditions
from oilfilm.units import PA_PER_GPA, FloatArray, IndexArray


class TractionLaw(Protocol):
    """A traction law as a function of the conditions and the slip of contacts.

    A law that differs between operating points has a method `at_points` that takes their indices
    and gives the law of these points.
    """

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """mu, of the shape of `slide_roll_ratio` (0 or more), whose last axis `at` has as 1.

        The axes from the end are nodes, contacts and operating points.
        """
        ...


@dataclass(frozen=True)
class ScaledLaw:
    """A law times a factor, shape (points,), at each operating point."""

    law: TractionLaw
    factor: FloatArray

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        return np.asarray(self.factor[:, None, None] * self.law(at, slide_roll_ratio))

    def at_points(self, which: IndexArray) -> "ScaledLaw":
        """See `TractionLaw`."""
        return ScaledLaw(law_at(self.law, which), self.factor[which])


@dataclass(frozen=True)
class JoinedLaw:
    """Several laws, each of some of the operating points.

    Attributes:
        laws: The laws; one that differs between points counts its own points only.
        number: Index of each point's law, shape (points,).
    """

    laws: Sequence[TractionLaw]
    number: IndexArray

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        mu = np.empty_like(slide_roll_ratio)
        for number, law in enumerate(self.laws):
            if len(which := np.flatnonzero(self.number == number)):
                levels = {
                    name: value[..., which, :, :] if np.ndim(value) else value
                    for name, value in vars(at).items()
                }
                mu[..., which, :, :] = law(Conditions(**levels), slide_roll_ratio[..., which, :, :])
        return mu

    def at_points(self, which: IndexArray) -> "JoinedLaw":
        """See `TractionLaw`."""
        place = np.empty_like(self.number)
        for number in range(len(self.laws)):
            of_law = self.number == number
            place[of_law] = np.arange(of_law.sum())
        chosen, place = self.number[which], place[which]
        laws = [law_at(law, place[chosen == number]) for number, law in enumerate(self.laws)]
        return JoinedLaw(laws, chosen)


def law_at(law: TractionLaw, which: IndexArray) -> TractionLaw:
    """The law of some of the operating points; most laws are the same at all of them."""
    at_points = getattr(law, "at_points", None)
    return law if at_points is None else at_points(which)


@dataclass(frozen=True)
class Grid:
    """Quadrature nodes of the unit ellipse and their shares of the load; shapes (nodes,).

    Attributes:
        along: In the rolling direction, in semi-axes.
        across: Across it.
        share: Of the load, by Hertz's pressure; they sum to 1.
        counts: How many nodes there are across and along.
    """

    along: FloatArray
    across: FloatArray
    share: FloatArray
    counts: tuple[int, int]

    def finer(self) -> "Grid":
        """Twice as many nodes either way."""
        return grid(2 * self.counts[0], 2 * self.counts[1])


@cache
def grid(across: int, along: int) -> Grid:
    """Gauss's rule for Hertz's pressure over an ellipse.

    Across the rolling direction the load of a strip goes with 1 - y^2, along it the pressure with
    sqrt(1 - x^2): both are weights of Gegenbauer polynomials, so that the rule is exact for
    polynomials up to degree 2 n - 1 in either direction.

    Examples:
        The mean of y^2 under Hertz's pressure is 1/5 of the semi-axis squared:

        >>> rule = grid(4, 3)
        >>> print(f"{np.sum(rule.share * rule.across**2):.12f}")
        0.200000000000
    """
    # the stubs leave out that a rule can be asked for without its sum of weights
    y, y_share = scipy.special.roots_gegenbauer(across, 1.5)[:2]
    x, x_share = scipy.special.roots_gegenbauer(along, 1.0)[:2]
    reach = np.sqrt(1 - y**2)
    share = np.outer(y_share, x_share).ravel()
    nodes = np.outer(reach, x).ravel(), np.repeat(y, along), share / share.sum()
    return Grid(*nodes, (across, along))


class Turning(NamedTuple):
    """Speeds of ball and race at each contact, in rad/s; shapes (..., 2 contacts).

    Attributes:
        about_normal: The ball's spin about the normal n.
        about_tangent: The ball's spin about t x n.
        race: The race's speed about the bearing's axis, against the ball's orbit.
    """

    about_normal: FloatArray
    about_tangent: FloatArray
    race: FloatArray


def turning(contacts: Contacts, motion: Motion, ring_speed_rad_s: FloatArray) -> Turning:
    """Speeds at the contacts from those of the ball and of both rings, shape (..., 2)."""
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    w_x, w_r = motion.spin_rad_s[..., :1], motion.spin_rad_s[..., 1:2]
    race = ring_speed_rad_s - motion.orbit_speed_rad_s[..., np.newaxis]
    return Turning(w_x * n_x + w_r * n_r, w_r * n_x - w_x * n_r, race)


@dataclass(frozen=True)
class Sliding:
    """Sliding of the race over the ball; shapes (..., 2 contacts) or (..., 2 contacts, nodes).

    Attributes:
        across_m_s: Speed across the rolling direction at each node.
        along_m_s: Speed along t at each node.
        entrainment_speed_m_s: Mean surface speed in the contact's middle.
        middle_slide_roll_ratio: Sliding along t there over that mean, positive where the race is
            the faster one.
        middle_m: From the ball's centre to the contact's middle, along the normal.
        height_m: The same to each node.
        across_m: From the normal to each node, across the rolling direction.
        along_m: The same along t.
        race_radius_m: From the bearing's axis to each node.
    """

    across_m_s: FloatArray
    along_m_s: FloatArray
    entrainment_speed_m_s: FloatArray
    middle_slide_roll_ratio: FloatArray
    middle_m: FloatArray
    height_m: FloatArray
    across_m: FloatArray
    along_m: FloatArray
    race_radius_m: FloatArray


def sliding(
    bearing: Bearing, contacts: Contacts, motion: Motion, ring_speed_rad_s: FloatArray, rule: Grid
) -> Sliding:
    """Sliding speeds in both ellipses of each ball, from rigid-body motion.

    In a frame that travels with the ball, with the point p = z n + y (t x n) + x t:

        along t:          W (r_b + n_r z + n_x y) - w_n y + w_y z
        across, along t x n:                (w_n - W n_x) x - w_t z

    W is the race's speed against the ball's orbit, w the ball's spin, and z falls across the
    groove as the pressed surface bends.

    Args:
        bearing: The bearing.
        contacts: Of the balls.
        motion: Of the balls.
        ring_speed_rad_s: Of inner and outer ring, shape (..., 2).
        rule: Quadrature nodes of the ellipse.

    Reference: A. B. Jones, J. Basic Eng. 81 (1959) 1; T. A. Harris, Rolling Bearing Analysis.
    """
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    speeds = turning(contacts, motion, ring_speed_rad_s)
    w_n, w_y, race = (speed[..., np.newaxis] for speed in speeds)
    w_t = motion.spin_rad_s[..., 2, np.newaxis, np.newaxis]
    bend, radius = bearing.deformed_radius_m, bearing.ball_diameter_m / 2
    # no contact is wider than the ball, though a search may come by such a state
    edge = np.minimum(contacts.semi_axis_y_m, radius)
    across_m = edge[..., np.newaxis] * rule.across
    along_m = contacts.semi_axis_x_m[..., np.newaxis] * rule.along
    middle = bend + np.sqrt(radius**2 - edge**2) - np.sqrt(bend**2 - edge**2)
    height = (middle - bend)[..., np.newaxis] + np.sqrt(bend[:, np.newaxis] ** 2 - across_m**2)
    orbit = contacts.orbit_radius_m[..., np.newaxis]
    race_radius = n_r[..., np.newaxis] * height + n_x[..., np.newaxis] * across_m
    race_radius += orbit[..., np.newaxis]
    race_speed, ball_speed = speeds.race * (orbit + n_r * middle), -speeds.about_tangent * middle
    mean = (race_speed + ball_speed) / 2
    return Sliding(
        (w_n - race * n_x[..., np.newaxis]) * along_m - w_t * height,
        race * race_radius - (w_n * across_m - w_y * height),
        np.abs(mean),
        np.divide(race_speed - ball_speed, mean, out=np.zeros_like(mean), where=mean != 0),
        middle,
        height,
        across_m,
        along_m,
        race_radius,
    )


@dataclass(frozen=True)
class Traction:
    """Forces, moments and heat of traction; shapes (..., 2 contacts) unless stated otherwise.

    Attributes:
        across_n: Force on the ball along t x n at each node: (..., 2 contacts, nodes).
        along_n: The same along t.
        force_n: Sums of both: shape (..., 2 parts, 2 contacts).
        moment_n_m: On the ball about its centre, about n, t x n and t: (..., 3, 2 contacts).
        race_moment_n_m: On the race about the bearing's axis.
        heat_w: Force times sliding, summed over the ellipse.
        slide_roll_ratio: At each node, shape (..., 2 contacts, nodes).
        coefficient: mu at each node.
    """

    across_n: FloatArray
    along_n: FloatArray
    force_n: FloatArray
    moment_n_m: FloatArray
    race_moment_n_m: FloatArray
    heat_w: FloatArray
    slide_roll_ratio: FloatArray
    coefficient: FloatArray


def conditions(
    bearing: Bearing, contacts: Contacts, slip: Sliding, inlet_temperature_c: FloatArray
) -> Conditions:
    """Conditions of each contact, with one more axis for the nodes.

    Args:
        bearing: The bearing.
        contacts: Of the balls.
        slip: Of the same.
        inlet_temperature_c: Of the oil, shape broadcasting against (..., 2 contacts).
    """
    radius_x = bearing.radius_x_m(np.abs(contacts.normal[..., 1, :]))
    pressure = contacts.max_hertz_pressure_pa / PA_PER_GPA
    temperature = np.broadcast_to(inlet_temperature_c, radius_x.shape)
    levels = contacts.load_n, pressure, slip.entrainment_speed_m_s, temperature, radius_x
    load, pressure, speed, temperature, radius_x = (level[..., np.newaxis] for level in levels)
    wide, long = contacts.semi_axis_y_m, contacts.semi_axis_x_m
    shape = np.divide(wide, long, out=np.ones_like(wide), where=long > 0)[..., np.newaxis]
    modulus = bearing.reduced_modulus_pa
    return Conditions(load, pressure, speed, temperature, radius_x, modulus, shape)


def traction(
    contacts: Contacts, slip: Sliding, at: Conditions, law: TractionLaw, rule: Grid
) -> Traction:
    """Force, moments and heat of the film's traction, by quadrature over the ellipse.

    The law was fitted to averages over contacts at their p_max: it is given the contact's p_max
    and the local slip, and Hertz's pressure shares the load out. Given the local pressure it would
    count pressure twice.
    """
    speed = np.hypot(slip.across_m_s, slip.along_m_s)
    entrainment = np.maximum(slip.entrainment_speed_m_s, np.finfo(float).tiny)[..., np.newaxis]
    ratio = speed / entrainment
    mu = law(at, ratio)
    strength = mu * rule.share * contacts.load_n[..., np.newaxis] / np.maximum(speed, 1e-300)
    f_across, f_along = strength * slip.across_m_s, strength * slip.along_m_s
    # x-component of the race's speed per turn, across the rolling direction: -n_x x
    tilt = -contacts.normal[..., 0, :, np.newaxis] * slip.along_m

    def summed(first: FloatArray, by: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("...k,...k->...", first, by))

    moment = [
        summed(slip.across_m, f_along) - summed(slip.along_m, f_across),
        -summed(slip.height_m, f_along),
        summed(slip.height_m, f_across),
    ]
    return Traction(
        f_across,
        f_along,
        np.stack([f_across.sum(axis=-1), f_along.sum(axis=-1)], axis=-2),
        np.stack(moment, axis=-2),
        -summed(f_along, slip.race_radius_m) - summed(f_across, tilt),
        summed(strength * speed, speed),
        ratio,
        mu,
    )
