"""Quasi-static equilibrium of an axially loaded ball bearing with raceway control (Jones, Harris).

Axes of a ball:

- x is parallel to the bearing's axis, in the direction in which the axial load pushes the inner
  ring.
- r points radially outward.
- t = x x r is the direction in which the balls travel where the inner ring has positive speed.

In the plane (x, r) the centre of the outer groove is fixed. The centre of the inner groove moves
with its ring, and by the growth of the rings. The ball is between both. A contact's normal n points
from the ball into the race. Its tangent across the rolling direction is t x n = (-n_r, n_x). All
balls are alike.

The last axis of an array holds the two contacts, inner and outer. Where an array also has the two
components x and r, their axis comes before that of the contacts.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.growth import Growth
from oilfilm.bearing.solver import Solution, solve
from oilfilm.physics.contact import Floats

# Jacobians after which a point is given up.
_MAX_ITERATIONS = 30
# Smallest axial load per ball for which a start is calculated.
_SMALLEST_LOAD_N = 1e-3
# The search for the start divides its interval of angles into this number of parts and keeps one of
# them. It does so several times. The last interval of 1e-5 rad is near enough for Newton's method.
_INTERVAL_PARTS = 8
_NARROWING_COUNT = 6
# Sign of the inner and the outer normal relative to the contact angle.
_NORMAL_SIGNS = np.array([-1.0, 1.0])


@dataclass(frozen=True)
class OperatingPoints:
    """Axial load and speeds of the rings, one value per point.

    Attributes:
        axial_load_n: Load on the inner ring along x, shape (points,).
        ring_speed_rad_s: Speeds of inner and outer ring about x, shape (points, 2).
        growth: Growth of rings and balls; None for the dimensions of the drawing.
    """

    axial_load_n: FloatArray
    ring_speed_rad_s: FloatArray
    growth: Growth | None = None

    @classmethod
    def from_load_and_speed(
        cls,
        axial_load_n: FloatArray | float,
        inner_speed_rad_s: FloatArray | float,
        outer_speed_rad_s: FloatArray | float = 0.0,
    ) -> "OperatingPoints":
        """Points from loads and speeds, which broadcast. By default the outer ring is at rest."""
        load_n, inner_rad_s, outer_rad_s = np.broadcast_arrays(
            np.atleast_1d(axial_load_n), inner_speed_rad_s, outer_speed_rad_s
        )
        ring_rad_s = np.stack([inner_rad_s, outer_rad_s], axis=-1)
        return cls(load_n.astype(float), ring_rad_s.astype(float))

    def at_points(self, point_index: IndexArray) -> "OperatingPoints":
        """Load, speeds and growth of some of the points."""
        growth = None if self.growth is None else self.growth.at_points(point_index)
        return OperatingPoints(
            self.axial_load_n[point_index], self.ring_speed_rad_s[point_index], growth
        )


@dataclass(frozen=True)
class Contacts:
    """Normal contacts of a ball with both races; shapes (..., 2 contacts) unless stated otherwise.

    Attributes:
        normal: Unit vector from the ball into the race, shape (..., 2 components, 2 contacts).
        load_n: Normal load Q.
        semi_axis_x_m: Semi-axis of the ellipse along the rolling direction.
        semi_axis_y_m: Semi-axis across the rolling direction.
        orbit_radius_m: Distance of the ball's centre from the bearing's axis, shape (...).
    """

    normal: FloatArray
    load_n: FloatArray
    semi_axis_x_m: FloatArray
    semi_axis_y_m: FloatArray
    orbit_radius_m: FloatArray

    @property
    def contact_angle_rad(self) -> FloatArray:
        """Contact angle alpha, between the normal and the radial direction."""
        sine = _NORMAL_SIGNS * self.normal[..., 0, :]
        cosine = _NORMAL_SIGNS * self.normal[..., 1, :]
        return np.arctan2(sine, cosine)

    @property
    def max_hertz_pressure_pa(self) -> FloatArray:
        """Maximum Hertz pressure p_max; 0 where the contact is open."""
        area = 2 * np.pi * self.semi_axis_x_m * self.semi_axis_y_m
        return np.divide(3 * self.load_n, area, out=np.zeros_like(area), where=area > 0)


@dataclass(frozen=True)
class Motion:
    """Motion of balls.

    Attributes:
        orbit_speed_rad_s: Speed of the ball's centre about the bearing's axis, shape (...).
        rotation_rad_s: Rotation w of the ball in the frame that travels with it, (..., 3) of
            (x, r, t). Spin, its part about the normal of a contact, is in `ellipse.Sliding`.
    """

    orbit_speed_rad_s: FloatArray
    rotation_rad_s: FloatArray


@dataclass(frozen=True)
class QuasiStaticEquilibrium:
    """Steady state of a bearing's inner ring and balls.

    Attributes:
        contacts: Contacts of each point, shapes (points, ...).
        motion: Motion of the balls, shapes (points, ...).
        solution: The solver's result: centre of the ball (x, r) and displacement of the inner
            ring, in m. The residuals are relative to the load of a ball.
    """

    contacts: Contacts
    motion: Motion
    solution: Solution


def normal_contacts(
    bearing: Bearing,
    ball_position_m: FloatArray,
    ring_displacement_m: FloatArray,
    growth: Growth | None = None,
) -> Contacts:
    """Normal contacts of balls from their positions.

    The inner groove's centre moves by the growth of both rings. Hence the contacts are exact also
    where no play is left between the grooves.

    Args:
        bearing: The bearing.
        ball_position_m: Position of the ball's centre relative to that of the outer groove, shape
            (..., 2) of (x, r).
        ring_displacement_m: Displacement of the inner ring along x, shape (...).
        growth: Growth of rings and balls at the points; None for the dimensions of the drawing.
    """
    unloaded_distance_m = bearing.groove_centre_distance_m
    axial_distance_m = unloaded_distance_m * np.sin(bearing.contact_angle_rad) + ring_displacement_m
    grooves = _grooves(bearing, growth)
    inner_groove_m = np.stack(
        [axial_distance_m, grooves.radial_distance_m + 0 * ring_displacement_m], axis=-1
    )
    # from the centre of each groove to that of the ball; the last axis holds the contacts
    arm_m = np.stack([ball_position_m - inner_groove_m, ball_position_m], axis=-1)
    arm_length_m = np.sqrt((arm_m**2).sum(axis=-2))
    normal = arm_m / arm_length_m[..., np.newaxis, :]
    approach_m = np.maximum(arm_length_m - grooves.offset_m, 0.0)
    stiffness, unit_semi_axis_x, unit_semi_axis_y = bearing.stiffness_and_unit_semi_axes(
        np.abs(normal[..., 1, :])
    )
    load_n = stiffness * approach_m**1.5
    cube_root_of_load = np.cbrt(load_n)
    return Contacts(
        normal=normal,
        load_n=load_n,
        semi_axis_x_m=unit_semi_axis_x * cube_root_of_load,
        semi_axis_y_m=unit_semi_axis_y * cube_root_of_load,
        orbit_radius_m=grooves.outer_centre_radius_m + ball_position_m[..., 1],
    )


class _Grooves(NamedTuple):
    """Positions of the grooves: single numbers for the bearing of a drawing, or one per point.

    Attributes:
        radial_distance_m: Radial distance of the two groove centres.
        offset_m: Distance from each groove centre to the ball's centre in an unloaded contact,
            shape (2,) or (points, 2).
        outer_centre_radius_m: Distance of the outer groove's centre from the bearing's axis.
    """

    radial_distance_m: Floats
    offset_m: FloatArray
    outer_centre_radius_m: Floats


def _grooves(bearing: Bearing, growth: Growth | None) -> _Grooves:
    """The grooves of a bearing, with the growth of its rings and balls if there is one."""
    radial_distance_m = bearing.groove_centre_distance_m * np.cos(bearing.contact_angle_rad)
    if growth is None:
        return _Grooves(
            radial_distance_m, bearing.groove_offset_m, bearing.outer_groove_centre_radius_m
        )
    inner_growth_m, outer_growth_m = (
        growth.centre_displacement_m[:, 0],
        growth.centre_displacement_m[:, 1],
    )
    return _Grooves(
        radial_distance_m=radial_distance_m + inner_growth_m - outer_growth_m,
        offset_m=bearing.groove_offset_m + growth.offset_growth_m,
        outer_centre_radius_m=bearing.outer_groove_centre_radius_m + outer_growth_m,
    )


def rolling_motion(bearing: Bearing, contacts: Contacts, ring_speed_rad_s: FloatArray) -> Motion:
    """Motion of balls that roll on both races and do not spin on the outer one.

        tan(beta) = sin(alpha_o)/(cos(alpha_o) + D/(2 r))

    with beta the tilt of the ball's axis and r the radius of its orbit. The speeds follow from
    equal surface speeds in the middle of both contacts.

    Reference: T. A. Harris, Rolling Bearing Analysis, ball motion in angular-contact bearings;
        A. B. Jones, J. Basic Eng. 81 (1959) 1.
    """
    ball_radius_m = bearing.ball_diameter_m / 2
    sine = _NORMAL_SIGNS * contacts.normal[..., 0, :]
    cosine = _NORMAL_SIGNS * contacts.normal[..., 1, :]
    race_radius_m = (
        contacts.orbit_radius_m[..., np.newaxis] + _NORMAL_SIGNS * ball_radius_m * cosine
    )
    # the vector (-axis_x, axis_r) is parallel to the ball's axis
    axis_x = cosine[..., 1] + ball_radius_m / contacts.orbit_radius_m
    axis_r = sine[..., 1]
    axis_length = np.hypot(axis_x, axis_r)
    # distance of each contact from the ball's axis over the ball's radius, times `axis_length`
    relative_lever = cosine * axis_x[..., np.newaxis] + sine * axis_r[..., np.newaxis]
    # without sliding, (ring speed - orbit speed) weight is equal and opposite at both races
    weight = race_radius_m * axis_length[..., np.newaxis] / relative_lever
    orbit_speed_rad_s = (ring_speed_rad_s * weight).sum(axis=-1) / weight.sum(axis=-1)
    relative_orbit_rad_s = orbit_speed_rad_s - ring_speed_rad_s[..., 1]
    rotation_rad_s = relative_orbit_rad_s * weight[..., 1] / (ball_radius_m * axis_length)
    return Motion(
        orbit_speed_rad_s,
        np.stack([-rotation_rad_s * axis_x, rotation_rad_s * axis_r, 0 * rotation_rad_s], axis=-1),
    )


def centrifugal_force_n(bearing: Bearing, contacts: Contacts, motion: Motion) -> FloatArray:
    """Outward force on each ball, m r Omega^2."""
    return bearing.ball_mass_kg * contacts.orbit_radius_m * motion.orbit_speed_rad_s**2


def gyroscopic_moment_n_m(bearing: Bearing, motion: Motion) -> FloatArray:
    """Moment that turns each ball's axis of rotation along its orbit, J Omega x w: (..., 3).

    Components are (x, r, t).

    Friction must supply this moment. About t it is J Omega w_r = J Omega w sin(beta).
    """
    inertia_times_orbit = bearing.ball_inertia_kg_m2 * motion.orbit_speed_rad_s
    w_r = motion.rotation_rad_s[..., 1]
    w_t = motion.rotation_rad_s[..., 2]
    moment_r_n_m = -inertia_times_orbit * w_t
    moment_t_n_m = inertia_times_orbit * w_r
    return np.stack([0 * w_r, moment_r_n_m, moment_t_n_m], axis=-1)


def ball_force_scale_n(bearing: Bearing, points: OperatingPoints) -> FloatArray:
    """Scale of the forces on a ball, shape (points,): axial load plus centrifugal force."""
    orbit_speed_rad_s = points.ring_speed_rad_s.sum(axis=1) / 2
    centrifugal_n = bearing.ball_mass_kg * bearing.pitch_diameter_m / 2 * orbit_speed_rad_s**2
    force_n = np.abs(points.axial_load_n) / bearing.ball_count + centrifugal_n
    return np.maximum(force_n, np.finfo(float).tiny)


def raceway_control_equilibrium(
    bearing: Bearing, points: OperatingPoints, gyroscopic_factor: float = 1.0
) -> QuasiStaticEquilibrium:
    """Equilibrium of balls and inner ring, with the motion of `rolling_motion`.

    The outer race alone supplies the gyroscopic moment, by friction across the rolling direction.
    The size of this friction is not checked, and other moments are not balanced.

    Args:
        bearing: The bearing.
        points: Loads and speeds.
        gyroscopic_factor: Factor on the gyroscopic moment; -1 reverses it. Harris's equations hold
            if his ball speed is negative for a turning inner ring. Programs that take it as
            positive reverse the moment, and so does much of the printed literature.

    Reference: T. A. Harris, Rolling Bearing Analysis, high-speed ball bearings; A. B. Jones,
        J. Basic Eng. 82 (1960) 309.
    """
    force_scale_n = ball_force_scale_n(bearing, points)

    def ball_state(unknowns: FloatArray, point_index: IndexArray) -> tuple[Contacts, Motion]:
        """Contacts and motion of the balls of the points `point_index`."""
        selected_points = points.at_points(point_index)
        contacts = normal_contacts(
            bearing, unknowns[..., :2], unknowns[..., 2], selected_points.growth
        )
        return contacts, rolling_motion(bearing, contacts, selected_points.ring_speed_rad_s)

    def residuals(unknowns: FloatArray, point_index: IndexArray) -> FloatArray:
        """Residuals of the forces on ball and ring, relative to the ball's load."""
        contacts, motion = ball_state(unknowns, point_index)
        normal = contacts.normal
        # tangential force of the outer race, which supplies the moment about t
        moment_t_n_m = gyroscopic_moment_n_m(bearing, motion)[..., 2]
        tangential_force_n = gyroscopic_factor * 2 / bearing.ball_diameter_m * moment_t_n_m
        force_on_ball_n = -contacts.load_n[..., np.newaxis, :] * normal
        force_on_ball_n[..., 0, 1] -= tangential_force_n * normal[..., 1, 1]
        force_on_ball_n[..., 1, 1] += tangential_force_n * normal[..., 0, 1]
        force_of_races_n = force_on_ball_n.sum(axis=-1)
        axial_sum_n = force_of_races_n[..., 0]
        radial_sum_n = force_of_races_n[..., 1] + centrifugal_force_n(bearing, contacts, motion)
        axial_sum_on_ring_n = (
            points.axial_load_n[point_index] / bearing.ball_count - force_on_ball_n[..., 0, 0]
        )
        return (
            np.stack([axial_sum_n, radial_sum_n, axial_sum_on_ring_n], axis=-1)
            / force_scale_n[point_index, np.newaxis]
        )

    start = _frictionless_state(bearing, points)
    scale = np.full(start.shape, bearing.groove_offset_m.min())
    solution = solve(residuals, start, scale, _MAX_ITERATIONS)
    contacts, motion = ball_state(solution.unknowns, np.arange(len(start)))
    return QuasiStaticEquilibrium(contacts, motion, solution)


def _frictionless_state(bearing: Bearing, points: OperatingPoints) -> FloatArray:
    """Positions of ball and ring under axial load and centrifugal force, shape (points, 3).

    With q the axial load of a ball, the load of both contacts is Q = q/sin(alpha), and
    cot(alpha_o) - cot(alpha_i) is the centrifugal force over q. The radial distance of the groove
    centres is known. That is one monotone equation for alpha_i. Its interval is narrowed down.
    """
    point_count = len(points.axial_load_n)
    load_per_ball_n = np.abs(points.axial_load_n) / bearing.ball_count
    load_per_ball_n = np.maximum(load_per_ball_n, _SMALLEST_LOAD_N)
    cosine = np.cos(bearing.contact_angle_rad)
    gamma = bearing.ball_diameter_m * cosine / bearing.pitch_diameter_m
    orbit_speed_rad_s = points.ring_speed_rad_s @ [(1 - gamma) / 2, (1 + gamma) / 2]
    centrifugal_n = bearing.ball_mass_kg * bearing.pitch_diameter_m / 2 * orbit_speed_rad_s**2
    relative_centrifugal = centrifugal_n / load_per_ball_n
    grooves = _grooves(bearing, points.growth)
    # with one axis for the angles that are tried
    offset_m = np.broadcast_to(grooves.offset_m, (point_count, 2))[:, np.newaxis, :]
    radial_distance_m = np.broadcast_to(grooves.radial_distance_m, point_count)[:, np.newaxis]
    # delta/Q^(2/3) of each contact
    stiffness, _, _ = bearing.stiffness_and_unit_semi_axes(np.full(2, cosine))
    compliance = stiffness ** (-2 / 3)

    def angles_and_ball_distances(inner_angle_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Contact angles and distances from groove centre to ball centre, (..., 2)."""
        outer_cotangent = 1 / np.tan(inner_angle_rad) + relative_centrifugal[:, np.newaxis]
        outer_angle_rad = np.arctan2(1.0, outer_cotangent)
        contact_angle_rad = np.stack([inner_angle_rad, outer_angle_rad], axis=-1)
        load_n = load_per_ball_n[:, np.newaxis, np.newaxis] / np.sin(contact_angle_rad)
        return contact_angle_rad, offset_m + compliance * np.cbrt(load_n) ** 2

    lowest_angle_rad = np.zeros((point_count, 1))
    interval_width_rad = np.pi
    for _ in range(_NARROWING_COUNT):
        interval_width_rad /= _INTERVAL_PARTS
        contact_angle_rad, ball_distance_m = angles_and_ball_distances(
            lowest_angle_rad + interval_width_rad * np.arange(1, _INTERVAL_PARTS)
        )
        radial_distance_of_angle_m = (ball_distance_m * np.cos(contact_angle_rad)).sum(axis=-1)
        is_angle_too_small = radial_distance_of_angle_m > radial_distance_m
        lowest_angle_rad = lowest_angle_rad + interval_width_rad * is_angle_too_small.sum(
            axis=-1, keepdims=True
        )
    contact_angle_rad, ball_distance_m = angles_and_ball_distances(
        lowest_angle_rad + interval_width_rad / 2
    )
    contact_angle_rad = contact_angle_rad[:, 0]
    ball_distance_m = ball_distance_m[:, 0]
    load_direction = np.where(points.axial_load_n < 0, -1.0, 1.0)
    axial_distance_m = load_direction[:, np.newaxis] * ball_distance_m * np.sin(contact_angle_rad)
    unloaded_axial_m = bearing.groove_centre_distance_m * np.sin(bearing.contact_angle_rad)
    outer_radial_m = ball_distance_m[:, 1] * np.cos(contact_angle_rad[:, 1])
    return np.column_stack(
        [axial_distance_m[:, 1], outer_radial_m, axial_distance_m.sum(axis=1) - unloaded_axial_m]
    )
