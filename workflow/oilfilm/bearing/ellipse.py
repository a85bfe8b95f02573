"""Sliding and traction inside the contact ellipse of a ball and a race.

The surfaces slide for three reasons: the ball spins against the race, the distance from the ball's
axis changes across the groove, and the contact as a whole slips. A traction law gives the local
traction coefficient; Hertz's pressure gives the weight of each quadrature node.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import scipy

from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import Contacts, Motion
from oilfilm.physics.contact import Conditions
from oilfilm.units import PA_PER_GPA, FloatArray, IndexArray

# A traction law as a function of the conditions and the slip of contacts: mu, of the shape of the
# slide-roll ratio (0 or more), whose last axis the conditions have as 1. The axes from the end are
# nodes, contacts and operating points. A law that differs between operating points has a method
# `at_points` that takes their indices and gives the law of these points.
TractionLaw = Callable[[Conditions, FloatArray], FloatArray]


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

    @cached_property
    def moments(self) -> FloatArray:
        """1, `along` and `across` of each node, by which forces are summed: shape (nodes, 3)."""
        return np.column_stack([np.ones_like(self.along), self.along, self.across])

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


@dataclass(frozen=True)
class Sliding:
    """Sliding of the race over the ball; shapes (..., 2 contacts) or (..., 2 contacts, nodes).

    Attributes:
        race_rad_s: The race's speed about the bearing's axis, against the ball's orbit.
        axis_rad_s: The ball's spin about t x n.
        spin_rad_s: Of the ball about the normal, against the race.
        roll_rad_s: Of the ball about t x n, against the race.
        across_m_s: Speed across the rolling direction at each node.
        along_m_s: Speed along t at each node.
        entrainment_speed_m_s: Mean surface speed in the contact's middle.
        middle_slide_roll_ratio: Sliding along t there over that mean, positive where the race is
            the faster one.
        middle_m: From the ball's centre to the contact's middle, along the normal.
        height_m: The same to each node.
        semi_axes_m: Along t and across the rolling direction, of which the nodes have shares.
    """

    race_rad_s: FloatArray
    axis_rad_s: FloatArray
    spin_rad_s: FloatArray
    roll_rad_s: FloatArray
    across_m_s: FloatArray
    along_m_s: FloatArray
    entrainment_speed_m_s: FloatArray
    middle_slide_roll_ratio: FloatArray
    middle_m: FloatArray
    height_m: FloatArray
    semi_axes_m: tuple[FloatArray, FloatArray]


def never_slower(speed_m_s: FloatArray, least_m_s: FloatArray | float) -> FloatArray:
    """A speed of 0 or more that stays above half of `least_m_s`, smoothly.

        least/2 (1 + (U/least)^2)   where U < least,   else U

    Value and slope are continuous at U = least; with least = 0 it is U everywhere.
    """
    slow = speed_m_s < least_m_s
    ratio = np.divide(speed_m_s, least_m_s, out=np.zeros_like(speed_m_s), where=slow)
    return np.asarray(np.where(slow, least_m_s / 2 * (1 + ratio**2), speed_m_s))


def sliding(
    bearing: Bearing,
    contacts: Contacts,
    motion: Motion,
    ring_speed_rad_s: FloatArray,
    rule: Grid,
    least_speed_m_s: FloatArray | float = 0.0,
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
        least_speed_m_s: As of `never_slower`, for the entrainment speed, shape (points, 1).

    Reference: A. B. Jones, J. Basic Eng. 81 (1959) 1; T. A. Harris, Rolling Bearing Analysis.
    """
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    w_x, w_r = motion.spin_rad_s[..., :1], motion.spin_rad_s[..., 1:2]
    race, axis = ring_speed_rad_s - motion.orbit_speed_rad_s[..., np.newaxis], w_r * n_x - w_x * n_r
    spin, roll = w_x * n_x + w_r * n_r - race * n_x, race * n_r + axis
    bend, radius = bearing.deformed_radius_m, bearing.ball_diameter_m / 2
    # no contact is wider than the ball, though a search may come by such a state
    edge, length = np.minimum(contacts.semi_axis_y_m, radius), contacts.semi_axis_x_m
    middle = bend + np.sqrt(radius**2 - edge**2) - np.sqrt(bend**2 - edge**2)
    height = np.sqrt(bend[:, np.newaxis] ** 2 - (edge**2)[..., np.newaxis] * rule.across**2)
    height += (middle - bend)[..., np.newaxis]
    orbit = race * contacts.orbit_radius_m[..., np.newaxis]
    across = (spin * length)[..., np.newaxis] * rule.along
    across -= motion.spin_rad_s[..., 2, np.newaxis, np.newaxis] * height
    along = roll[..., np.newaxis] * height
    along -= (spin * edge)[..., np.newaxis] * rule.across
    along += orbit[..., np.newaxis]
    race_speed, ball_speed = orbit + race * n_r * middle, -axis * middle
    mean = (race_speed + ball_speed) / 2
    return Sliding(
        race_rad_s=race,
        axis_rad_s=axis,
        spin_rad_s=spin,
        roll_rad_s=roll,
        across_m_s=across,
        along_m_s=along,
        entrainment_speed_m_s=never_slower(np.abs(mean), least_speed_m_s),
        middle_slide_roll_ratio=np.divide(
            race_speed - ball_speed, mean, out=np.zeros_like(mean), where=mean != 0
        ),
        middle_m=middle,
        height_m=height,
        semi_axes_m=(length, edge),
    )


@dataclass(frozen=True)
class Traction:
    """Forces, moments and heat of traction; shapes (..., 2 contacts) unless stated otherwise.

    Attributes:
        across_n: Force on the ball along t x n.
        along_n: The same along t.
        about_normal_n_m: Moment on the ball about its centre, about n.
        about_across_n_m: The same about t x n.
        about_tangent_n_m: The same about t.
        race_moment_n_m: On the race about the bearing's axis.
        heat_w: Force times sliding, summed over the ellipse.
        slide_roll_ratio: At each node, shape (..., 2 contacts, nodes).
        coefficient: mu at each node.
    """

    across_n: FloatArray
    along_n: FloatArray
    about_normal_n_m: FloatArray
    about_across_n_m: FloatArray
    about_tangent_n_m: FloatArray
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
    contacts: Contacts,
    slip: Sliding,
    at: Conditions,
    law: TractionLaw,
    rule: Grid,
    factor: FloatArray | float = 1.0,
) -> Traction:
    """Force, moments and heat of the film's traction, by quadrature over the ellipse.

    The law was fitted to averages over contacts at their p_max: it is given the contact's p_max
    and the local slip, and Hertz's pressure shares the load out. Given the local pressure it would
    count pressure twice. A factor on all traction has the shape (points,).
    """
    speed = np.sqrt(slip.across_m_s**2 + slip.along_m_s**2)
    ratio = speed / np.maximum(slip.entrainment_speed_m_s, np.finfo(float).tiny)[..., np.newaxis]
    mu = law(at, ratio)
    mu *= np.reshape(factor, (-1, 1, 1))
    strength = mu * rule.share
    heat = np.einsum("...k,...k->...", strength, speed)
    strength /= np.maximum(speed, 1e-300, out=speed)
    strength *= contacts.load_n[..., np.newaxis]
    f_across, f_along = strength * slip.across_m_s, strength * slip.along_m_s
    # sums of the forces, and of forces times x and times y
    of_across = np.tensordot(f_across, rule.moments, 1)
    of_along = np.tensordot(f_along, rule.moments, 1)
    length, edge = slip.semi_axes_m
    across, across_x = of_across[..., 0], of_across[..., 1] * length
    along, along_y = of_along[..., 0], of_along[..., 2] * edge
    across_z = np.einsum("...k,...k->...", f_across, slip.height_m)
    along_z = np.einsum("...k,...k->...", f_along, slip.height_m)
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    # by the distance from the bearing's axis, and across the rolling direction by the race's tilt
    lever = along * contacts.orbit_radius_m[..., np.newaxis] + n_r * along_z + n_x * along_y
    return Traction(
        across_n=across,
        along_n=along,
        about_normal_n_m=along_y - across_x,
        about_across_n_m=-along_z,
        about_tangent_n_m=across_z,
        race_moment_n_m=n_x * across_x - lever,
        heat_w=contacts.load_n * heat,
        slide_roll_ratio=ratio,
        coefficient=mu,
    )
