"""Quasi-static equilibrium of an axially loaded ball bearing with raceway control (Jones, Harris).

Axes of a ball: x along the bearing's axis, in the direction in which the axial load pushes the
inner ring; r radially outward; t = x x r, the way the balls travel where the inner ring turns
with positive speed. In the plane (x, r) the outer groove's centre is fixed, the inner one moves
with its ring, and the ball lies between. A contact's normal n points from the ball into the race,
its tangent across the rolling direction is t x n = (-n_r, n_x). All balls are alike.

Last axes: two contacts, inner and outer; before them, where both stand, two components, x and r.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.solver import Solution, solve
from oilfilm.units import FloatArray, IndexArray

# Jacobians after which a point is given up.
_MAX_ITERATIONS = 30
# Axial load of a ball from which the search for its position starts where it bears less.
_LIGHTEST_N = 1e-3
# Into how many parts that search divides the angle, how often: to hundred-thousandths of a radian,
# near enough for Newton's method.
_PARTS, _NARROWINGS = 8, 6
# Sign of the inner and the outer normal against the contact angle.
_SIDE = np.array([-1.0, 1.0])


@dataclass(frozen=True)
class OperatingPoints:
    """Axial load and speeds of the rings, one value per point.

    Attributes:
        axial_load_n: On the inner ring along x, shape (points,).
        ring_speed_rad_s: Of inner and outer ring about x, shape (points, 2).
    """

    axial_load_n: FloatArray
    ring_speed_rad_s: FloatArray

    @classmethod
    def axial(
        cls,
        axial_load_n: FloatArray | float,
        inner_speed_rad_s: FloatArray | float,
        outer_speed_rad_s: FloatArray | float = 0.0,
    ) -> "OperatingPoints":
        """Points by load and speeds, which broadcast; the outer ring is at rest if not given."""
        given = np.atleast_1d(axial_load_n), inner_speed_rad_s, outer_speed_rad_s
        load, *speeds = (values.astype(float) for values in np.broadcast_arrays(*given))
        return cls(load, np.stack(speeds, axis=-1))

    def at(self, which: IndexArray) -> "OperatingPoints":
        """Some of the points."""
        return OperatingPoints(self.axial_load_n[which], self.ring_speed_rad_s[which])


@dataclass(frozen=True)
class Contacts:
    """Normal contacts of a ball; shapes (..., 2) of contacts unless stated otherwise.

    Attributes:
        normal: From the ball into the race, shape (..., 2 components, 2 contacts).
        load_n: Q.
        semi_axis_x_m: Half the ellipse's length along the rolling direction.
        semi_axis_y_m: Half its width across it.
        orbit_radius_m: From the bearing's axis to the ball's centre, shape (...).
    """

    normal: FloatArray
    load_n: FloatArray
    semi_axis_x_m: FloatArray
    semi_axis_y_m: FloatArray
    orbit_radius_m: FloatArray

    @property
    def contact_angle_rad(self) -> FloatArray:
        """Angle between the normal and the radial direction, alpha."""
        return np.arctan2(_SIDE * self.normal[..., 0, :], _SIDE * self.normal[..., 1, :])

    @property
    def max_hertz_pressure_pa(self) -> FloatArray:
        """p_max, 0 where the contact is open."""
        area = 2 * np.pi * self.semi_axis_x_m * self.semi_axis_y_m
        return np.divide(3 * self.load_n, area, out=np.zeros_like(area), where=area > 0)


@dataclass(frozen=True)
class Motion:
    """How balls move; shapes (...).

    Attributes:
        orbit_speed_rad_s: Of the ball's centre about the bearing's axis.
        spin_rad_s: Of the ball, seen from a frame that travels with it: (..., 3) of (x, r, t).
    """

    orbit_speed_rad_s: FloatArray
    spin_rad_s: FloatArray


@dataclass(frozen=True)
class Equilibrium:
    """Where a bearing's inner ring and balls travel steadily.

    Attributes:
        contacts: Shapes (points, ...).
        motion: Shapes (points, ...).
        solution: The solver's own account: centre of the ball (x, r) and displacement of the inner
            ring, in m, with residuals over the load of a ball.
    """

    contacts: Contacts
    motion: Motion
    solution: Solution


def contacts_at(bearing: Bearing, ball: FloatArray, displacement_m: FloatArray) -> Contacts:
    """Normal contacts of balls from where they lie.

    Args:
        bearing: The bearing.
        ball: Centre of the ball from that of the outer groove, shape (..., 2) of (x, r), in m.
        displacement_m: Of the inner ring along x, shape (...).
    """
    unloaded = bearing.groove_centre_distance_m
    inner = np.stack(
        [
            unloaded * np.sin(bearing.contact_angle_rad) + displacement_m,
            unloaded * np.cos(bearing.contact_angle_rad) + 0 * displacement_m,
        ],
        axis=-1,
    )
    # stacked on two contacts: from each groove's centre to the ball's
    arm = np.stack([ball - inner, ball], axis=-1)
    length = np.sqrt((arm**2).sum(axis=-2))
    normal = arm / length[..., np.newaxis, :]
    approach = np.maximum(length - bearing.groove_offset_m, 0.0)
    stiffness, a_x, a_y = bearing.under_unit_load(np.abs(normal[..., 1, :]))
    load = stiffness * approach**1.5
    growth = np.cbrt(load)
    return Contacts(
        normal, load, a_x * growth, a_y * growth, bearing.outer_groove_radius_m + ball[..., 1]
    )


def rolling_motion(bearing: Bearing, contacts: Contacts, ring_speed_rad_s: FloatArray) -> Motion:
    """Motion of balls that roll on both races and do not spin on the outer one.

        tan(beta) = sin(alpha_o)/(cos(alpha_o) + D/(2 r))

    with beta the tilt of the ball's axis and r the radius of its orbit; its speeds follow from
    equal surface speeds in the middle of both contacts.

    Reference: T. A. Harris, Rolling Bearing Analysis, ball motion in angular-contact bearings;
        A. B. Jones, J. Basic Eng. 81 (1959) 1.
    """
    radius = bearing.ball_diameter_m / 2
    sine, cosine = _SIDE * contacts.normal[..., 0, :], _SIDE * contacts.normal[..., 1, :]
    race = contacts.orbit_radius_m[..., np.newaxis] + _SIDE * radius * cosine
    # the ball's axis, of length `size`, and its height above both races
    along, across = cosine[..., 1] + radius / contacts.orbit_radius_m, sine[..., 1]
    size = np.hypot(along, across)
    lever = cosine * along[..., np.newaxis] + sine * across[..., np.newaxis]
    reach = race * size[..., np.newaxis] / lever
    orbit = (ring_speed_rad_s * reach).sum(axis=-1) / reach.sum(axis=-1)
    turning = (orbit - ring_speed_rad_s[..., 1]) * reach[..., 1] / (radius * size)
    return Motion(orbit, np.stack([-turning * along, turning * across, 0 * turning], axis=-1))


def centrifugal_force_n(bearing: Bearing, contacts: Contacts, motion: Motion) -> FloatArray:
    """Outward force on each ball, m r Omega^2."""
    return bearing.ball_mass_kg * contacts.orbit_radius_m * motion.orbit_speed_rad_s**2


def gyroscopic_moment_n_m(bearing: Bearing, motion: Motion) -> FloatArray:
    """Moment that turns each ball's spin along its orbit, J Omega x w: (..., 3) of (x, r, t).

    Friction must supply it. About t it is J Omega w_r = J Omega w sin(beta).
    """
    momentum = bearing.ball_inertia_kg_m2 * motion.orbit_speed_rad_s
    _, w_r, w_t = np.moveaxis(motion.spin_rad_s, -1, 0)
    return np.stack([0 * w_r, -momentum * w_t, momentum * w_r], axis=-1)


def ball_force_n(bearing: Bearing, points: OperatingPoints) -> FloatArray:
    """Force that a ball's residuals are divided by, shape (points,): its load and its weight."""
    orbit = points.ring_speed_rad_s.sum(axis=1) / 2
    centrifugal = bearing.ball_mass_kg * bearing.pitch_diameter_m / 2 * orbit**2
    force = np.abs(points.axial_load_n) / bearing.ball_count + centrifugal
    return np.maximum(force, np.finfo(float).tiny)


def raceway_control(
    bearing: Bearing, points: OperatingPoints, gyroscopic_sign: float = 1.0
) -> Equilibrium:
    """Equilibrium of balls and inner ring, the balls moving as `rolling_motion` says.

    The outer race alone supplies the gyroscopic moment, by friction across the rolling
    direction. Its size is not checked, nor are the moments about other axes.

    Args:
        bearing: The bearing.
        points: Loads and speeds.
        gyroscopic_sign: -1 turns the gyroscopic moment round. Harris's equations hold with his
            ball speed negative for a turning inner ring; programs that take it as positive, and
            with them much of the printed literature, have the moment turned round.

    Reference: T. A. Harris, Rolling Bearing Analysis, high-speed ball bearings; A. B. Jones,
        J. Basic Eng. 82 (1960) 309.
    """
    force = ball_force_n(bearing, points)

    def ball_state(unknowns: FloatArray, which: IndexArray) -> tuple[Contacts, Motion]:
        contacts = contacts_at(bearing, unknowns[..., :2], unknowns[..., 2])
        return contacts, rolling_motion(bearing, contacts, points.ring_speed_rad_s[which])

    def residuals(unknowns: FloatArray, which: IndexArray) -> FloatArray:
        contacts, motion = ball_state(unknowns, which)
        normal = contacts.normal
        # tangential force of the outer race, which supplies the moment about t
        moment = gyroscopic_moment_n_m(bearing, motion)[..., 2]
        grip = gyroscopic_sign * 2 / bearing.ball_diameter_m * moment
        on_ball = -contacts.load_n[..., np.newaxis, :] * normal
        on_ball[..., 0, 1] -= grip * normal[..., 1, 1]
        on_ball[..., 1, 1] += grip * normal[..., 0, 1]
        x, r = np.moveaxis(on_ball.sum(axis=-1), -1, 0)
        ring = points.axial_load_n[which] / bearing.ball_count - on_ball[..., 0, 0]
        outward = r + centrifugal_force_n(bearing, contacts, motion)
        return np.stack([x, outward, ring], axis=-1) / force[which, np.newaxis]

    start = _start(bearing, points)
    scale = np.full(start.shape, bearing.groove_offset_m.min())
    solution = solve(residuals, start, scale, _MAX_ITERATIONS)
    return Equilibrium(*ball_state(solution.unknowns, np.arange(len(start))), solution)


def _start(bearing: Bearing, points: OperatingPoints) -> FloatArray:
    """Ball and ring under the axial load and the centrifugal force, without friction.

    With q the axial load of a ball, Q = q/sin(alpha) on both races, cot(alpha_o) - cot(alpha_i) is
    the centrifugal force over q, and the radial distance of the groove centres is known: one
    equation for alpha_i, monotone, solved by narrowing down.
    """
    count = len(points.axial_load_n)
    per_ball = np.maximum(np.abs(points.axial_load_n) / bearing.ball_count, _LIGHTEST_N)
    cosine = np.cos(bearing.contact_angle_rad)
    ratio = bearing.ball_diameter_m * cosine / bearing.pitch_diameter_m
    orbit = points.ring_speed_rad_s @ [(1 - ratio) / 2, (1 + ratio) / 2]
    outward = bearing.ball_mass_kg * bearing.pitch_diameter_m / 2 * orbit**2 / per_ball
    # delta/Q^(2/3) of each contact
    softness = bearing.under_unit_load(np.full(2, cosine))[0] ** (-2 / 3)

    def arms(inner_angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Contact angles and distances from groove centre to ball centre, (..., 2)."""
        outer_angle = np.arctan2(1.0, 1 / np.tan(inner_angle) + outward[:, np.newaxis])
        angle = np.stack([inner_angle, outer_angle], axis=-1)
        load = per_ball[:, np.newaxis, np.newaxis] / np.sin(angle)
        return angle, bearing.groove_offset_m + softness * np.cbrt(load) ** 2

    low, width = np.zeros((count, 1)), np.pi
    for _ in range(_NARROWINGS):
        width /= _PARTS
        angle, length = arms(low + width * np.arange(1, _PARTS))
        radial = (length * np.cos(angle)).sum(axis=-1)
        too_low = radial > bearing.groove_centre_distance_m * cosine
        low = low + width * too_low.sum(axis=-1, keepdims=True)
    angle, length = (each[:, 0] for each in arms(low + width / 2))
    side = np.where(points.axial_load_n < 0, -1.0, 1.0)
    axial = side[:, np.newaxis] * length * np.sin(angle)
    unloaded = bearing.groove_centre_distance_m * np.sin(bearing.contact_angle_rad)
    outer_radial = length[:, 1] * np.cos(angle[:, 1])
    return np.column_stack([axial[:, 1], outer_radial, axial.sum(axis=1) - unloaded])
