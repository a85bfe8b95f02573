"""Quasi-static equilibrium of a ball bearing with raceway control (Jones and Harris).

Axes of a ball: x along the bearing's axis, in the direction in which the axial load pushes the
inner ring; r radially outward; t = x x r, the way the balls travel where the inner ring turns
with positive speed. In the plane (x, r) the outer groove's centre is fixed, the inner one moves
with its ring, and the ball lies between. A contact's normal n points from the ball into the race,
its tangent across the rolling direction is t x n = (-n_r, n_x).

Last axes: two contacts, inner and outer; before them, where both stand, two components, x and r.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.solver import Equations, IntArray, Solution, follow
from oilfilm.units import FloatArray

# Jacobians after which a point is given up.
_MAX_ITERATIONS = 30
# Axial load of a ball from which the search for its position starts where it bears less.
_LIGHTEST_N = 1e-3
# Into how many parts that search divides the angle, how often: to hundred-thousandths of a radian,
# near enough for Newton's method.
_PARTS, _NARROWINGS = 8, 6


@dataclass(frozen=True)
class OperatingPoints:
    """Loads on the inner ring and speeds of the rings; one value a point, shape (points,).

    Attributes:
        axial_load_n: Along x.
        inner_speed_rad_s: Of the inner ring about x.
        outer_speed_rad_s: Of the outer ring.
        radial_load_n: Along y and z, across the axis, shape (points, 2).
        moment_n_m: About y and z, shape (points, 2).
    """

    axial_load_n: FloatArray
    inner_speed_rad_s: FloatArray
    outer_speed_rad_s: FloatArray
    radial_load_n: FloatArray
    moment_n_m: FloatArray

    @classmethod
    def axial(
        cls, axial_load_n: FloatArray | float, inner_speed_rad_s: FloatArray | float
    ) -> "OperatingPoints":
        """Points of axial load alone with the outer ring at rest."""
        load, speed = np.broadcast_arrays(
            np.atleast_1d(np.asarray(axial_load_n, dtype=float)), np.asarray(inner_speed_rad_s)
        )
        none = np.zeros((len(load), 2))
        return cls(load, speed.astype(float), np.zeros(len(load)), none, none)

    def at(self, which: IntArray) -> "OperatingPoints":
        """Some of the points."""
        return replace(self, **{name: values[which] for name, values in vars(self).items()})

    @property
    def only_axial(self) -> bool:
        """True where the load is axial at every point, so that all balls are alike."""
        return not (self.radial_load_n.any() or self.moment_n_m.any())

    def loads(self) -> FloatArray:
        """Loads by the ring's degrees of freedom (x, y, z, about y, about z): (points, 1 or 5)."""
        axial = self.axial_load_n[:, np.newaxis]
        if self.only_axial:
            return axial
        return np.concatenate([axial, self.radial_load_n, self.moment_n_m], axis=1)


@dataclass(frozen=True)
class Contacts:
    """Normal contacts of balls; shapes (..., 2) of contacts unless stated otherwise.

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
        side = np.array([-1.0, 1.0])
        return np.arctan2(side * self.normal[..., 0, :], side * self.normal[..., 1, :])

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
    """Where a bearing's rings and balls come to rest, or travel steadily.

    Balls of a point share one row where the load is axial; otherwise each ball has its own row.

    Attributes:
        contacts: Shapes (points, balls, ...).
        motion: Shapes (points, balls, ...).
        displacement: Of the inner ring: x, y, z in m, about y and z in rad; (points, 1 or 5).
        solution: The solver's own account, with residuals over the load of a ball.
    """

    contacts: Contacts
    motion: Motion
    displacement: FloatArray
    solution: Solution


def azimuths(bearing: Bearing, only_axial: bool) -> FloatArray:
    """Angle of each ball from y towards z; one ball stands for all under axial load."""
    balls = 1 if only_axial else bearing.ball_count
    return 2 * np.pi * np.arange(balls) / bearing.ball_count


def inner_groove(bearing: Bearing, displacement: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Inner groove's centre from the outer one at each ball, (..., balls, 2) of (x, r).

    Args:
        bearing: The bearing.
        displacement: Of the inner ring, shape (..., 1 or 5).
        azimuth: Of each ball, shape (balls,).
    """
    distance, angle = bearing.groove_centre_distance_m, bearing.contact_angle_rad
    moved = displacement[..., np.newaxis, :]
    axial = distance * np.sin(angle) + moved[..., 0] + 0 * azimuth
    radial = distance * np.cos(angle) + 0 * axial
    if displacement.shape[-1] > 1:
        cosine, sine = np.cos(azimuth), np.sin(azimuth)
        tilt = moved[..., 3] * sine - moved[..., 4] * cosine
        axial = axial + bearing.inner_groove_radius_m * tilt
        radial = radial + moved[..., 1] * cosine + moved[..., 2] * sine
    return np.stack([axial, radial], axis=-1)


def contacts_at(bearing: Bearing, ball: FloatArray, inner: FloatArray) -> Contacts:
    """Normal contacts of balls from where they lie.

    Args:
        bearing: The bearing.
        ball: Centre of the ball from that of the outer groove, shape (..., 2) of (x, r), in m.
        inner: Centre of the inner groove from that of the outer one, of the same shape.
    """
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


def tangent(normal: FloatArray) -> FloatArray:
    """Unit vector across the rolling direction, t x n, of the shape of `normal`."""
    return np.stack([-normal[..., 1, :], normal[..., 0, :]], axis=-2)


def rolling_motion(
    bearing: Bearing,
    contacts: Contacts,
    inner_speed_rad_s: FloatArray,
    outer_speed_rad_s: FloatArray,
) -> Motion:
    """Motion of balls that roll on both races and do not spin on the outer one.

        tan(beta) = sin(alpha_o)/(cos(alpha_o) + D/(2 r))

    with beta the tilt of the ball's axis and r the radius of its orbit; its speeds follow from
    equal surface speeds in the middle of both contacts.

    Reference: T. A. Harris, Rolling Bearing Analysis, ball motion in angular-contact bearings;
        A. B. Jones, J. Basic Eng. 81 (1959) 1.
    """
    radius = bearing.ball_diameter_m / 2
    side = np.array([-1.0, 1.0])
    sine, cosine = side * contacts.normal[..., 0, :], side * contacts.normal[..., 1, :]
    race = contacts.orbit_radius_m[..., np.newaxis] + side * radius * cosine
    # the ball's axis, of length `size`, and its height above both races
    along, across = cosine[..., 1] + radius / contacts.orbit_radius_m, sine[..., 1]
    size = np.hypot(along, across)
    lever = cosine * along[..., np.newaxis] + sine * across[..., np.newaxis]
    reach = race * size[..., np.newaxis] / lever
    inner, outer = reach[..., 0], reach[..., 1]
    orbit = (inner_speed_rad_s * inner + outer_speed_rad_s * outer) / (inner + outer)
    turning = (orbit - outer_speed_rad_s) * outer / (radius * size)
    return Motion(orbit, np.stack([-turning * along, turning * across, 0 * turning], axis=-1))


def centrifugal_force_n(bearing: Bearing, contacts: Contacts, motion: Motion) -> FloatArray:
    """Outward force on each ball, m r Omega^2."""
    return bearing.ball_mass_kg * contacts.orbit_radius_m * motion.orbit_speed_rad_s**2


def gyroscopic_moment_n_m(bearing: Bearing, motion: Motion) -> FloatArray:
    """Moment that turns each ball's spin along its orbit, J Omega x w: (..., 3) of (x, r, t).

    Friction must supply it. About t it is J Omega w_r = J Omega w sin(beta).
    """
    momentum = bearing.ball_inertia_kg_m2 * motion.orbit_speed_rad_s[..., np.newaxis]
    turned = np.stack(
        [0 * motion.spin_rad_s[..., 0], -motion.spin_rad_s[..., 2], motion.spin_rad_s[..., 1]],
        axis=-1,
    )
    return momentum * turned


def force_on_ring(
    bearing: Bearing, force: FloatArray, contacts: Contacts, azimuth: FloatArray, freedoms: int
) -> FloatArray:
    """What the balls' inner contacts do to the inner ring, by its degrees of freedom.

    Args:
        bearing: The bearing.
        force: On the ring at each inner contact, shape (..., balls, 3) of (x, r, t).
        contacts: The contacts.
        azimuth: Of each ball.
        freedoms: 1 (x alone) or 5 (x, y, z, about y, about z).

    Returns:
        Shape (..., balls, freedoms), in N and N m.
    """
    x, r, t = np.moveaxis(force, -1, 0)
    if freedoms == 1:
        return x[..., np.newaxis]
    cosine, sine = np.cos(azimuth), np.sin(azimuth)
    groove = bearing.groove_curvature[0] * bearing.ball_diameter_m * contacts.normal[..., 0]
    about_t = groove[..., 0] * r - (bearing.inner_groove_radius_m + groove[..., 1]) * x
    about_r = -groove[..., 0] * t
    return np.stack(
        [
            x,
            r * cosine - t * sine,
            r * sine + t * cosine,
            about_r * cosine - about_t * sine,
            about_r * sine + about_t * cosine,
        ],
        axis=-1,
    )


def scales(bearing: Bearing, points: OperatingPoints) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Force of a ball, and scales of the ring's displacement and of its loads.

    Returns:
        Shapes (points,), (points, freedoms) and (freedoms,): the first in N, the last what a
        ball's force is multiplied by to be of the kind of that load.
    """
    loads = points.loads()
    lever = np.ones(loads.shape[1])
    lever[3:] = bearing.pitch_diameter_m / 2
    orbit = (points.inner_speed_rad_s + points.outer_speed_rad_s) / 2
    centrifugal = bearing.ball_mass_kg * bearing.pitch_diameter_m / 2 * orbit**2
    force = np.abs(loads / lever).max(axis=1) / bearing.ball_count + centrifugal
    length = bearing.groove_offset_m.min() / lever
    return force, np.broadcast_to(length, loads.shape), lever


def neighbourhood(points: OperatingPoints) -> FloatArray:
    """Where operating points lie among each other: loads by their logarithms, speed."""
    loads = np.log1p(np.abs(points.loads()))
    speed = np.abs(points.inner_speed_rad_s - points.outer_speed_rad_s)
    return np.column_stack([loads, 3 * speed / max(speed.max(), 1.0)])


def raceway_control(
    bearing: Bearing,
    points: OperatingPoints,
    gyroscopic_sign: float = 1.0,
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
    azimuth = azimuths(bearing, points.only_axial)
    loads = points.loads()
    force, length, lever = scales(bearing, points)
    force = np.maximum(force, np.finfo(float).tiny)
    grip_1_m = 2 * gyroscopic_sign / bearing.ball_diameter_m
    sideways = np.arange(loads.shape[1]) > 0

    def ball_state(own: FloatArray, shared: FloatArray, which: IntArray) -> tuple[Contacts, Motion]:
        contacts = contacts_at(bearing, own, inner_groove(bearing, shared, azimuth))
        inner = points.inner_speed_rad_s[which, np.newaxis]
        outer = points.outer_speed_rad_s[which, np.newaxis]
        return contacts, rolling_motion(bearing, contacts, inner, outer)

    def with_share(share: float) -> Equations:
        """The equations with that share of the gyroscopic moment, radial load and tilting."""

        def equations(
            own: FloatArray, shared: FloatArray, which: IntArray
        ) -> tuple[FloatArray, FloatArray, FloatArray]:
            contacts, motion = ball_state(own, shared, which)
            # tangential force of the outer race, which supplies the moment about t
            momentum = bearing.ball_inertia_kg_m2 * motion.orbit_speed_rad_s
            grip = share * grip_1_m * momentum * motion.spin_rad_s[..., 1]
            on_ball = -contacts.load_n[..., np.newaxis, :] * contacts.normal
            on_ball[..., 0, 1] -= grip * contacts.normal[..., 1, 1]
            on_ball[..., 1, 1] += grip * contacts.normal[..., 0, 1]
            residual = on_ball.sum(axis=-1)
            residual[..., 1] += centrifugal_force_n(bearing, contacts, motion)
            on_ring = np.zeros((*residual.shape[:-1], 3))
            on_ring[..., :2] = -on_ball[..., 0]
            parts = force_on_ring(bearing, on_ring, contacts, azimuth, loads.shape[1])
            unit = force[which, np.newaxis]
            outside = (
                loads[which] * np.where(sideways, share, 1.0) / (bearing.ball_count * lever * unit)
            )
            return (
                residual / unit[..., np.newaxis],
                parts / (len(azimuth) * lever * unit[..., np.newaxis]),
                np.broadcast_to(outside, shared.shape),
            )

        return equations

    own, shared = _start(bearing, points, azimuth)
    own_scale = np.full((len(loads), 2), bearing.groove_offset_m.min())
    beside = neighbourhood(points)
    solution = follow(with_share, own, shared, own_scale, length, _MAX_ITERATIONS, beside)
    every = np.arange(len(loads))
    contacts, motion = ball_state(solution.own, solution.shared, every)
    return Equilibrium(contacts, motion, solution.shared, solution)


def _start(
    bearing: Bearing, points: OperatingPoints, azimuth: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Balls and ring under the axial load and the centrifugal force, without friction.

    With q the axial load of a ball, Q = q/sin(alpha) on both races, cot(alpha_o) - cot(alpha_i) is
    the centrifugal force over q, and the radial distance of the groove centres is known: one
    equation for alpha_i, monotone, solved by narrowing down. Radial load and moment add to q.
    """
    loads = points.loads()
    ring = np.abs(loads / scales(bearing, points)[2]).sum(axis=1)
    per_ball = np.maximum(ring / bearing.ball_count, _LIGHTEST_N)
    cosine = np.cos(bearing.contact_angle_rad)
    ratio = bearing.ball_diameter_m * cosine / bearing.pitch_diameter_m
    orbit = (points.inner_speed_rad_s * (1 - ratio) + points.outer_speed_rad_s * (1 + ratio)) / 2
    outward = bearing.ball_mass_kg * bearing.pitch_diameter_m / 2 * orbit**2 / per_ball
    softness = bearing.under_unit_load(np.full(2, cosine))[0] ** (-2 / 3)
    radial = bearing.groove_centre_distance_m * cosine
    low, width = np.zeros((len(loads), 1)), np.pi
    known = per_ball[:, np.newaxis, np.newaxis], outward[:, np.newaxis]
    for _ in range(_NARROWINGS):
        width /= _PARTS
        inner_angle = low + width * np.arange(1, _PARTS)
        angle, length = _without_friction(bearing, inner_angle, *known, softness)
        too_low = (length * np.cos(angle)).sum(axis=-1) > radial
        low = low + width * too_low.sum(axis=-1, keepdims=True)
    angle, length = _without_friction(bearing, low + width / 2, *known, softness)
    angle, length = angle[:, 0], length[:, 0]
    arm = length[:, np.newaxis, :] * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    shared = np.zeros(loads.shape)
    side = np.where(points.axial_load_n < 0, -1.0, 1.0)
    start = bearing.groove_centre_distance_m * np.sin(bearing.contact_angle_rad)
    shared[:, 0] = side * arm[:, 0].sum(axis=-1) - start
    ball = arm[:, :, 1] * np.stack([side, np.ones_like(side)], axis=1)
    return np.repeat(ball[:, np.newaxis], len(azimuth), axis=1), shared


def _without_friction(
    bearing: Bearing,
    inner_angle: FloatArray,
    per_ball_n: FloatArray,
    outward: FloatArray,
    softness: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Contact angles and arms from groove centre to ball centre, (..., 2), by the inner angle.

    Args:
        bearing: The bearing.
        inner_angle: alpha_i.
        per_ball_n: Axial load of a ball.
        outward: Centrifugal force over it.
        softness: delta/Q^(2/3) of each contact.
    """
    outer_angle = np.arctan2(1.0, 1 / np.tan(inner_angle) + outward)
    angle = np.stack([inner_angle, outer_angle], axis=-1)
    load = per_ball_n / np.sin(angle)
    return angle, bearing.groove_offset_m + softness * np.cbrt(load) ** 2
