"""Sliding and traction inside the contact ellipse of a ball and a race.

The surfaces slide for three reasons: the ball spins against the race, the distance from the ball's
axis changes across the groove, and the contact as a whole slips. A traction law gives the local
traction coefficient. Hertz's pressure gives the weight of each quadrature node.

The axes x, r, t and n are those of `quasistatic`. Beside that, x and y are coordinates in the
ellipse: x along the rolling direction t, y across it along t x n.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import scipy

from oilfilm.base.units import PA_PER_GPA, FloatArray, IndexArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import Contacts, Motion
from oilfilm.physics.contact import Conditions

# A traction law: mu as a function of the conditions and the slide-roll ratio of contacts.
# The slide-roll ratio is 0 or more, and mu has its shape. The last three axes are operating points,
# contacts and nodes; the conditions have one node. A law that differs between operating points has
# a method `at_points`, which takes indices of points and returns the law of these points.
TractionLaw = Callable[[Conditions, FloatArray], FloatArray]


def law_at_points(law: TractionLaw, point_index: IndexArray) -> TractionLaw:
    """The law of some of the operating points. Most laws are the same at all points."""
    at_points = getattr(law, "at_points", None)
    return law if at_points is None else at_points(point_index)


@dataclass(frozen=True)
class QuadratureRule:
    """Quadrature nodes of the unit ellipse and their shares of the load; shapes (nodes,).

    Attributes:
        along: Position along the rolling direction, in semi-axes.
        across: Position across the rolling direction, in semi-axes.
        load_share: Share of the load, by Hertz's pressure. The shares sum to 1.
        node_counts: Number of nodes across and along.
    """

    along: FloatArray
    across: FloatArray
    load_share: FloatArray
    node_counts: tuple[int, int]

    @cached_property
    def moment_weights(self) -> FloatArray:
        """1, `along` and `across` of each node, as weights of sums of forces: (nodes, 3)."""
        return np.column_stack([np.ones_like(self.along), self.along, self.across])

    def finer(self) -> "QuadratureRule":
        """The rule with twice as many nodes in each direction."""
        return gauss_rule(2 * self.node_counts[0], 2 * self.node_counts[1])


@cache
def gauss_rule(node_count_across: int, node_count_along: int) -> QuadratureRule:
    """Gauss's rule for Hertz's pressure over an ellipse.

    The load of a strip across the rolling direction is proportional to 1 - y^2, the pressure along
    it to sqrt(1 - x^2). Both are weights (1 - z^2)^(a - 1/2) of Gegenbauer polynomials, with a of
    3/2 and 1. Hence the rule is exact for polynomials up to degree 2 n - 1 in each direction.

    Args:
        node_count_across: Number of nodes across the rolling direction.
        node_count_along: Number of nodes along it.

    Examples:
        The mean of y^2 under Hertz's pressure is 1/5 of the semi-axis squared:

        >>> rule = gauss_rule(4, 3)
        >>> print(f"{np.sum(rule.load_share * rule.across**2):.12f}")
        0.200000000000
    """
    # by the type stubs, roots_gegenbauer always returns the sum of the weights as well
    y, y_share = scipy.special.roots_gegenbauer(node_count_across, 1.5)[:2]
    x, x_share = scipy.special.roots_gegenbauer(node_count_along, 1.0)[:2]
    half_length = np.sqrt(1 - y**2)
    load_share = np.outer(y_share, x_share).ravel()
    return QuadratureRule(
        along=np.outer(half_length, x).ravel(),
        across=np.repeat(y, node_count_along),
        load_share=load_share / load_share.sum(),
        node_counts=(node_count_across, node_count_along),
    )


@dataclass(frozen=True)
class Sliding:
    """Sliding of the race over the ball; shapes (..., 2 contacts) or (..., 2 contacts, nodes).

    Attributes:
        relative_race_speed_rad_s: Speed of the race about the bearing's axis, relative to the
            ball's orbit.
        roll_rad_s: Rotation of the ball about t x n, the axis about which it rolls on the race.
        relative_spin_rad_s: Spin: rotation of the ball about the normal, relative to the race.
        relative_roll_rad_s: Rotation of the ball about t x n, relative to the race.
        sliding_across_m_s: Sliding speed across the rolling direction at each node.
        sliding_along_m_s: Sliding speed along t at each node.
        entrainment_speed_m_s: Mean surface speed in the middle of the contact.
        middle_slide_roll_ratio: Sliding speed along t over the mean surface speed, in the middle of
            the contact. It is positive where the race is faster than the ball.
        middle_height_m: Distance z(0) from the ball's centre to the middle of the contact, along
            the normal.
        height_m: Distance z from the ball's centre to each node, along the normal.
        semi_axes_m: Semi-axes along t and across the rolling direction. The second is limited to
            the ball's radius.
    """

    relative_race_speed_rad_s: FloatArray
    roll_rad_s: FloatArray
    relative_spin_rad_s: FloatArray
    relative_roll_rad_s: FloatArray
    sliding_across_m_s: FloatArray
    sliding_along_m_s: FloatArray
    entrainment_speed_m_s: FloatArray
    middle_slide_roll_ratio: FloatArray
    middle_height_m: FloatArray
    height_m: FloatArray
    semi_axes_m: tuple[FloatArray, FloatArray]


def smoothly_limited_speed_m_s(speed_m_s: FloatArray, band_m_s: FloatArray | float) -> FloatArray:
    """A speed U of 0 or more, raised smoothly within the band U < U_0, to at least U_0/2.

        U_0/2 (1 + (U/U_0)^2)   where U < U_0,   else U

    Value and slope are continuous at U = U_0. Nothing changes with U_0 = 0.
    """
    is_slow = speed_m_s < band_m_s
    ratio = np.divide(speed_m_s, band_m_s, out=np.zeros_like(speed_m_s), where=is_slow)
    return np.asarray(np.where(is_slow, band_m_s / 2 * (1 + ratio**2), speed_m_s))


def sliding_in_ellipses(
    bearing: Bearing,
    contacts: Contacts,
    motion: Motion,
    ring_speed_rad_s: FloatArray,
    rule: QuadratureRule,
    entrainment_band_m_s: FloatArray | float = 0.0,
) -> Sliding:
    """Sliding speeds in both ellipses of each ball, from rigid-body motion.

    In a frame that travels with the ball, at the point p = z n + y (t x n) + x t:

        along t:          W (r_b + n_r z + n_x y) - w_n y + w_y z
        across, along t x n:                (w_n - W n_x) x - w_t z

    W is the race's speed relative to the ball's orbit, w the ball's rotation, r_b the distance of
    the ball's centre from the bearing's axis. The height z decreases across the groove, because the
    deformed surface is curved: with its radius R it is z(y) = z(0) - R + sqrt(R^2 - y^2). At the
    ends of the ellipse this surface meets the undeformed ball.

    Args:
        bearing: The bearing.
        contacts: Contacts of the balls.
        motion: Motion of the balls.
        ring_speed_rad_s: Speeds of inner and outer ring, shape (..., 2).
        rule: Quadrature nodes of the ellipse.
        entrainment_band_m_s: Band U_0 of the entrainment speed (`smoothly_limited_speed_m_s`),
            shape (points, 1).

    Reference: A. B. Jones, J. Basic Eng. 81 (1959) 1; T. A. Harris, Rolling Bearing Analysis.
    """
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    w_x, w_r = motion.rotation_rad_s[..., :1], motion.rotation_rad_s[..., 1:2]
    w_t = motion.rotation_rad_s[..., 2]
    relative_race_speed_rad_s = ring_speed_rad_s - motion.orbit_speed_rad_s[..., np.newaxis]
    roll_rad_s = w_r * n_x - w_x * n_r
    relative_spin_rad_s = w_x * n_x + w_r * n_r - relative_race_speed_rad_s * n_x
    relative_roll_rad_s = relative_race_speed_rad_s * n_r + roll_rad_s
    ball_radius_m = bearing.ball_diameter_m / 2
    curvature_radius_m = bearing.deformed_surface_radius_m
    # no contact is wider than the ball, but a search may try such a state
    semi_axis_y_m = np.minimum(contacts.semi_axis_y_m, ball_radius_m)
    semi_axis_x_m = contacts.semi_axis_x_m
    # z(0), from the height sqrt(r^2 - y^2) of a ball of radius r at the ends of the ellipse
    middle_height_m = (
        curvature_radius_m
        + np.sqrt(ball_radius_m**2 - semi_axis_y_m**2)
        - np.sqrt(curvature_radius_m**2 - semi_axis_y_m**2)
    )
    height_m = np.sqrt(
        curvature_radius_m[:, np.newaxis] ** 2
        - (semi_axis_y_m**2)[..., np.newaxis] * rule.across**2
    )
    height_m += (middle_height_m - curvature_radius_m)[..., np.newaxis]
    # speed of the race, extended to the radius of the orbit, past the ball's centre
    race_speed_at_orbit_m_s = relative_race_speed_rad_s * contacts.orbit_radius_m[..., np.newaxis]
    sliding_across_m_s = (relative_spin_rad_s * semi_axis_x_m)[..., np.newaxis] * rule.along
    sliding_across_m_s -= w_t[..., np.newaxis, np.newaxis] * height_m
    sliding_along_m_s = relative_roll_rad_s[..., np.newaxis] * height_m
    sliding_along_m_s -= (relative_spin_rad_s * semi_axis_y_m)[..., np.newaxis] * rule.across
    sliding_along_m_s += race_speed_at_orbit_m_s[..., np.newaxis]
    race_surface_m_s = race_speed_at_orbit_m_s + relative_race_speed_rad_s * n_r * middle_height_m
    ball_surface_m_s = -roll_rad_s * middle_height_m
    mean_speed_m_s = (race_surface_m_s + ball_surface_m_s) / 2
    speed_difference_m_s = race_surface_m_s - ball_surface_m_s
    return Sliding(
        relative_race_speed_rad_s=relative_race_speed_rad_s,
        roll_rad_s=roll_rad_s,
        relative_spin_rad_s=relative_spin_rad_s,
        relative_roll_rad_s=relative_roll_rad_s,
        sliding_across_m_s=sliding_across_m_s,
        sliding_along_m_s=sliding_along_m_s,
        entrainment_speed_m_s=smoothly_limited_speed_m_s(
            np.abs(mean_speed_m_s), entrainment_band_m_s
        ),
        middle_slide_roll_ratio=np.divide(
            speed_difference_m_s,
            mean_speed_m_s,
            out=np.zeros_like(mean_speed_m_s),
            where=mean_speed_m_s != 0,
        ),
        middle_height_m=middle_height_m,
        height_m=height_m,
        semi_axes_m=(semi_axis_x_m, semi_axis_y_m),
    )


@dataclass(frozen=True)
class Traction:
    """Forces, moments and heat of traction; shapes (..., 2 contacts) unless stated otherwise.

    Attributes:
        force_across_n: Force on the ball along t x n.
        force_along_n: Force on the ball along t.
        moment_about_normal_n_m: Moment on the ball about its axis parallel to n.
        moment_about_across_n_m: Moment on the ball about its axis parallel to t x n.
        moment_about_tangent_n_m: Moment on the ball about its axis parallel to t.
        race_moment_n_m: Moment on the race about the bearing's axis.
        heat_w: Force times sliding speed, summed over the ellipse.
        slide_roll_ratio: Local slide-roll ratio, shape (..., 2 contacts, nodes).
        coefficient: Local traction coefficient mu, of the same shape.
    """

    force_across_n: FloatArray
    force_along_n: FloatArray
    moment_about_normal_n_m: FloatArray
    moment_about_across_n_m: FloatArray
    moment_about_tangent_n_m: FloatArray
    race_moment_n_m: FloatArray
    heat_w: FloatArray
    slide_roll_ratio: FloatArray
    coefficient: FloatArray


def contact_conditions(
    bearing: Bearing, contacts: Contacts, sliding_state: Sliding, inlet_temperature_c: FloatArray
) -> Conditions:
    """Conditions of each contact, with one more axis for the nodes.

    Args:
        bearing: The bearing.
        contacts: Contacts of the balls.
        sliding_state: Sliding in these contacts.
        inlet_temperature_c: Inlet temperature of the oil; it broadcasts against (..., 2 contacts).
    """
    radius_x_m = bearing.radius_x_m(np.abs(contacts.normal[..., 1, :]))
    max_pressure_gpa = contacts.max_hertz_pressure_pa / PA_PER_GPA
    temperature_c = np.broadcast_to(inlet_temperature_c, radius_x_m.shape)
    semi_axis_y_m, semi_axis_x_m = contacts.semi_axis_y_m, contacts.semi_axis_x_m
    ellipticity = np.divide(
        semi_axis_y_m, semi_axis_x_m, out=np.ones_like(semi_axis_y_m), where=semi_axis_x_m > 0
    )
    return Conditions(
        load_n=contacts.load_n[..., np.newaxis],
        max_hertz_pressure_gpa=max_pressure_gpa[..., np.newaxis],
        entrainment_speed_m_s=sliding_state.entrainment_speed_m_s[..., np.newaxis],
        inlet_temperature_c=temperature_c[..., np.newaxis],
        radius_x_m=radius_x_m[..., np.newaxis],
        reduced_modulus_pa=bearing.reduced_modulus_pa,
        ellipticity=ellipticity[..., np.newaxis],
    )


def traction_in_ellipses(
    contacts: Contacts,
    sliding_state: Sliding,
    conditions: Conditions,
    law: TractionLaw,
    rule: QuadratureRule,
    traction_factor: FloatArray | float = 1.0,
) -> Traction:
    """Force, moments and heat of the film's traction, by quadrature over the ellipse.

    The law was fitted to averages over contacts at their p_max. Hence it is evaluated with the
    p_max of the contact and the local slip, and Hertz's pressure distributes the load. With the
    local pressure, pressure would count twice.

    Args:
        contacts: Contacts of the balls.
        sliding_state: Sliding in these contacts.
        conditions: Conditions of these contacts (`contact_conditions`).
        law: The traction law.
        rule: Quadrature nodes of the ellipse.
        traction_factor: Factor on all traction, one number or shape (points,).
    """
    sliding_speed_m_s = np.sqrt(
        sliding_state.sliding_across_m_s**2 + sliding_state.sliding_along_m_s**2
    )
    entrainment_speed_m_s = np.maximum(sliding_state.entrainment_speed_m_s, np.finfo(float).tiny)
    local_slide_roll_ratio = sliding_speed_m_s / entrainment_speed_m_s[..., np.newaxis]
    mu = law(conditions, local_slide_roll_ratio)
    mu *= np.reshape(traction_factor, (-1, 1, 1))
    # friction force of each node over the load of its contact
    force_over_load = mu * rule.load_share
    heat_over_load = np.einsum("...k,...k->...", force_over_load, sliding_speed_m_s)
    # friction force over sliding speed, in the same memory, because there are many nodes
    force_over_speed = force_over_load
    # no division by 0 where nothing slides
    force_over_speed /= np.maximum(sliding_speed_m_s, 1e-300, out=sliding_speed_m_s)
    force_over_speed *= contacts.load_n[..., np.newaxis]
    node_force_across_n = force_over_speed * sliding_state.sliding_across_m_s
    node_force_along_n = force_over_speed * sliding_state.sliding_along_m_s
    # last axis: sum of the forces, of forces times x, of forces times y (x, y in semi-axes)
    across_sums = np.tensordot(node_force_across_n, rule.moment_weights, 1)
    along_sums = np.tensordot(node_force_along_n, rule.moment_weights, 1)
    semi_axis_x, semi_axis_y = sliding_state.semi_axes_m
    force_across_n = across_sums[..., 0]
    force_along_n = along_sums[..., 0]
    # sums of force times coordinate, in N m
    across_times_x = across_sums[..., 1] * semi_axis_x
    along_times_y = along_sums[..., 2] * semi_axis_y
    across_times_z = np.einsum("...k,...k->...", node_force_across_n, sliding_state.height_m)
    along_times_z = np.einsum("...k,...k->...", node_force_along_n, sliding_state.height_m)
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    # moment about the bearing's axis: distance of each node from that axis, times the force along t
    along_moment_n_m = (
        force_along_n * contacts.orbit_radius_m[..., np.newaxis]
        + n_r * along_times_z
        + n_x * along_times_y
    )
    return Traction(
        force_across_n=force_across_n,
        force_along_n=force_along_n,
        moment_about_normal_n_m=along_times_y - across_times_x,
        moment_about_across_n_m=-along_times_z,
        moment_about_tangent_n_m=across_times_z,
        race_moment_n_m=n_x * across_times_x - along_moment_n_m,
        heat_w=contacts.load_n * heat_over_load,
        slide_roll_ratio=local_slide_roll_ratio,
        coefficient=mu,
    )
