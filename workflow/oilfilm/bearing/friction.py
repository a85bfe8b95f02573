"""Friction equilibrium: how balls and cage move where forces alone decide it, and what it costs.

Beside the loads of `quasistatic`, each ball's three moments and its force along the orbit must
balance: traction in both ellipses, the rolling contacts' resistance, the oil's drag and the cage.
Ball spin, tilt of its axis, gyroscopic slip and the speed of the cage come out. Every part is a
pair of forces on two bodies, so that the power put in at the rings is the sum of the parts' heat.

The cage turns steadily and all balls travel with it, each pushed or held by its pocket.

Decides: motion of balls and cage at the friction equilibrium.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from oilfilm.bearing.ellipse import (
    Conditions,
    Grid,
    Sliding,
    Traction,
    TractionLaw,
    conditions,
    grid,
    law_at,
    sliding,
    traction,
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import (
    Contacts,
    Motion,
    OperatingPoints,
    azimuths,
    centrifugal_force_n,
    contacts_at,
    force_on_ring,
    gyroscopic_moment_n_m,
    inner_groove,
    neighbourhood,
    raceway_control,
    scales,
    tangent,
)
from oilfilm.bearing.resistance import (
    TERMS,
    Lubrication,
    drag_force_n,
    hysteresis_moment_n_m,
    land_damping_n_m_s,
    rolling_force_n,
    rolling_force_reduction,
)
from oilfilm.bearing.solver import Equations, IntArray, Solution, follow, of_some, solve
from oilfilm.units import FloatArray

# Nodes of the ellipse across and along the rolling direction.
QUADRATURE = (16, 4)
# Jacobians after which a point is given up.
_MAX_ITERATIONS = 100
# The same where the search starts near by.
_MAX_NEAR = 14
# Scale of the speeds of a bearing at rest.
_SLOWEST_RAD_S = 1e-3


@dataclass(frozen=True)
class Resistance:
    """Rolling resistance in each contact; shapes (..., 2).

    Attributes:
        force_n: Of the oil drawn in, on either surface, along t.
        moment_n_m: Of hysteresis, with the sign of the force.
        force_heat_w: Heat of the force.
        moment_heat_w: Heat of the moment.
    """

    force_n: FloatArray
    moment_n_m: FloatArray
    force_heat_w: FloatArray
    moment_heat_w: FloatArray


@dataclass(frozen=True)
class Balance:
    """All that acts on balls; shapes (..., balls) and more.

    Attributes:
        contacts: Normal contacts.
        motion: Of the balls.
        at: Conditions of the contacts.
        sliding: In the ellipses.
        traction: Of the film in the ellipses.
        drag_n: Of the oil along t, against the orbit.
        pocket_n: Of the cage on the ball along t.
        heat_w: Of (traction, rolling, hysteresis, drag, pocket, land): (..., balls, 6).
        force_n: On the ball, (x, r): what is left of it at no equilibrium.
        moment_n_m: On the ball about (x, r, t), less what its gyroscopic motion takes.
        cage_n_m: On the cage.
        ring_force_n: On the inner ring at each contact, (x, r, t).
        ring_moment_n_m: On the inner and the outer ring about the bearing's axis: (..., balls, 2).
    """

    contacts: Contacts
    motion: Motion
    at: Conditions
    sliding: Sliding
    traction: Traction
    drag_n: FloatArray
    pocket_n: FloatArray
    heat_w: FloatArray
    force_n: FloatArray
    moment_n_m: FloatArray
    cage_n_m: FloatArray
    ring_force_n: FloatArray
    ring_moment_n_m: FloatArray


HEATS = ("traction", *TERMS)


def balance(
    bearing: Bearing,
    contacts: Contacts,
    motion: Motion,
    ring_speed_rad_s: FloatArray,
    lubrication: Lubrication,
    law: TractionLaw,
    rule: Grid,
    share: float = 1.0,
) -> Balance:
    """Every force and moment on balls, cage and rings, and the heat of each part.

    Args:
        bearing: The bearing.
        contacts: Of the balls, shapes (..., points, balls, ...).
        motion: Of the balls.
        ring_speed_rad_s: Of inner and outer ring, shape (points, 2).
        lubrication: The oil at each point.
        law: The traction law.
        rule: Quadrature nodes of the ellipse.
        share: Of everything that resists or turns the balls beside traction.
    """
    slip = sliding(bearing, contacts, motion, ring_speed_rad_s[:, np.newaxis], rule)
    at = conditions(bearing, contacts, slip, lubrication.inlet_temperature_c[:, None, None])
    film = traction(contacts, slip, at, law, rule)
    roll = _resistance(bearing, contacts, motion, ring_speed_rad_s, lubrication, share)
    normal, orbit = contacts.normal, contacts.orbit_radius_m
    radius = bearing.ball_diameter_m / 2
    race_radius = orbit[..., np.newaxis] + normal[..., 1, :] * radius
    speed = orbit * motion.orbit_speed_rad_s
    mist = share * lubrication.factor("drag") * lubrication.mist_density_kg_m3[:, np.newaxis]
    drag = drag_force_n(bearing.ball_diameter_m, mist, lubrication.drag_coefficient, speed)
    # shear on the ball's surface and, by the pressure, on its centre (see `_resistance`)
    pushed = roll.force_n * (2 * race_radius / orbit[..., np.newaxis] - 1)
    pocket = drag - film.force_n[..., 1, :].sum(axis=-1) - pushed.sum(axis=-1)
    rub = share * lubrication.factor("pocket") * pocket
    rub_force, rub_moment = _pocket_friction(bearing, motion, rub)
    on_ball = (
        film.force_n[..., 0, np.newaxis, :] * tangent(normal)
        - contacts.load_n[..., np.newaxis, :] * normal
    )
    force = on_ball.sum(axis=-1) + rub_force
    force[..., 1] += centrifugal_force_n(bearing, contacts, motion)
    guide, land, land_heat = _land_friction(bearing, motion, ring_speed_rad_s, lubrication, share)
    rolling_moment = roll.moment_n_m * normal[..., 1, :] - roll.force_n * race_radius
    on_ring = film.race_moment_n_m + rolling_moment
    on_ring[..., guide] -= land
    heat = [
        film.heat_w.sum(axis=-1),
        roll.force_heat_w.sum(axis=-1),
        roll.moment_heat_w.sum(axis=-1),
        drag * speed,
        -(rub_moment * motion.spin_rad_s).sum(axis=-1),
        land_heat,
    ]
    along = -film.force_n[..., 1, 0] - roll.force_n[..., 0]
    taken = share * gyroscopic_moment_n_m(bearing, motion)
    return Balance(
        contacts=contacts,
        motion=motion,
        at=at,
        sliding=slip,
        traction=film,
        drag_n=drag,
        pocket_n=pocket,
        heat_w=np.stack(heat, axis=-1),
        force_n=force,
        moment_n_m=_contact_moment(normal, film, roll, radius) + rub_moment - taken,
        cage_n_m=land - pocket * orbit - np.sign(pocket) * radius * rub_force[..., 1],
        ring_force_n=np.stack([-on_ball[..., 0, 0], -on_ball[..., 1, 0], along], axis=-1),
        ring_moment_n_m=on_ring,
    )


def _contact_moment(
    normal: FloatArray, film: Traction, roll: Resistance, radius_m: float
) -> FloatArray:
    """Moment of both contacts on each ball about (x, r, t), in N m."""
    n_x, n_r = normal[..., 0, :], normal[..., 1, :]
    about_n, about_y, about_t = (film.moment_n_m[..., axis, :] for axis in range(3))
    about_y = about_y + (radius_m * roll.force_n + roll.moment_n_m)
    return np.stack(
        [
            (about_n * n_x - about_y * n_r).sum(axis=-1),
            (about_n * n_r + about_y * n_x).sum(axis=-1),
            about_t.sum(axis=-1),
        ],
        axis=-1,
    )


def _resistance(
    bearing: Bearing,
    contacts: Contacts,
    motion: Motion,
    ring_speed_rad_s: FloatArray,
    lubrication: Lubrication,
    share: float,
) -> Resistance:
    """Rolling resistance from load and mean surface speed.

    The oil's force FR acts on both surfaces, against their way. The film is in balance by pressure
    on the two of them, which has no moment about the ball's centre nor about the bearing's axis
    and pushes the ball's centre along its orbit: by 2 FR (race radius)/(orbit radius).
    """
    radius = bearing.ball_diameter_m / 2
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    w_y = motion.spin_rad_s[..., 1, np.newaxis] * n_x - motion.spin_rad_s[..., 0, np.newaxis] * n_r
    relative = ring_speed_rad_s[:, np.newaxis] - motion.orbit_speed_rad_s[..., np.newaxis]
    # sum of the surface speeds along t
    rolling = relative * (contacts.orbit_radius_m[..., np.newaxis] + n_r * radius) - w_y * radius
    mean = np.abs(rolling / 2)
    radius_x = bearing.radius_x_m(np.abs(n_r))
    oil = lubrication.of_contacts
    reduction = rolling_force_reduction(
        oil, contacts.max_hertz_pressure_pa, mean, bearing.reduced_modulus_pa
    )
    force = rolling_force_n(
        contacts.load_n,
        mean,
        oil.dynamic_viscosity_pa_s,
        radius_x,
        bearing.radius_y_m,
        bearing.reduced_modulus_pa,
    )
    flexing = hysteresis_moment_n_m(
        contacts.load_n, bearing.ball_diameter_m, radius_x, bearing.radius_y_m
    )
    way = share * np.sign(rolling)
    force = way * (reduction * force) * lubrication.factor("rolling")[..., np.newaxis]
    moment = way * flexing * lubrication.factor("hysteresis")[..., np.newaxis]
    return Resistance(force, moment, force * rolling, -moment * (w_y + relative * n_r))


def _land_friction(
    bearing: Bearing,
    motion: Motion,
    ring_speed_rad_s: FloatArray,
    lubrication: Lubrication,
    share: float,
) -> tuple[int, FloatArray, FloatArray]:
    """Index of the ring that guides the cage, the land's moment for each ball, and its heat."""
    guide = 1 if bearing.cage.guided_by_outer else 0
    speed = ring_speed_rad_s[:, guide, np.newaxis] - motion.orbit_speed_rad_s
    damping = share * lubrication.factor("land") / bearing.ball_count
    damping = damping * land_damping_n_m_s(bearing, lubrication)[:, np.newaxis]
    moment = damping * speed
    return guide, moment, moment * speed


def _pocket_friction(
    bearing: Bearing, motion: Motion, pocket_n: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Force (x, r) and moment (x, r, t) on each ball that rubs in its pocket, by Coulomb."""
    spin = motion.spin_rad_s[..., :2]
    speed = np.hypot(spin[..., :1], spin[..., 1:])
    axis = spin / np.maximum(speed, np.finfo(float).tiny)
    rub = (bearing.cage.pocket_friction_coefficient * pocket_n)[..., np.newaxis]
    force = rub * np.stack([axis[..., 1], -axis[..., 0]], axis=-1)
    moment = -np.abs(rub) * bearing.ball_diameter_m / 2 * axis
    return force, np.concatenate([moment, np.zeros_like(moment[..., :1])], axis=-1)


@dataclass(frozen=True)
class FrictionEquilibrium:
    """Steady motion of a bearing in which all forces balance.

    Attributes:
        balance: All that acts on the balls of each point.
        solution: The solver's account, with residuals over the load of a ball (moments: times its
            radius).
        balls_per_row: Number of balls that each row of the arrays represents.
    """

    balance: Balance
    solution: Solution
    balls_per_row: float


def widest_contact(bearing: Bearing, contacts: Contacts) -> FloatArray:
    """Semi-axis across the rolling direction over the balls' radius, the widest of each point."""
    return contacts.semi_axis_y_m.max(axis=(1, 2)) / (bearing.ball_diameter_m / 2)


def friction_equilibrium(
    bearing: Bearing,
    points: OperatingPoints,
    lubrication: Lubrication,
    law: TractionLaw,
    quadrature: tuple[int, int] = QUADRATURE,
    start: Solution | None = None,
) -> FrictionEquilibrium:
    """Where balls, cage and inner ring travel steadily under all forces.

    Args:
        bearing: The bearing.
        points: Loads and speeds.
        lubrication: The oil at each point.
        law: The traction law.
        quadrature: Nodes of the ellipse, across and along the rolling direction.
        start: Equilibria of other constants, near which these are looked for first.

    Returns:
        The motion; not converged as well where a contact would be as wide as the ball.
    """
    problem = FrictionProblem(bearing, points, lubrication, law, grid(*quadrature))
    solution = _from_raceway_control(problem) if start is None else _near(problem, start)
    every = np.arange(len(solution.shared))
    final = problem.balance(solution.own, solution.shared, every, share=1.0)
    # beyond the range of Hertz's solution and of the groove there is no equilibrium
    solution.converged[widest_contact(bearing, final.contacts) >= 1] = False
    return FrictionEquilibrium(final, solution, bearing.ball_count / len(problem.azimuth))


def _from_raceway_control(problem: "FrictionProblem") -> Solution:
    own, shared = problem.start()
    scales = problem.unknown_scales()
    near = neighbourhood(problem.points)
    return follow(problem.equations, own, shared, *scales, _MAX_ITERATIONS, near)


def _near(problem: "FrictionProblem", start: Solution) -> Solution:
    """From known equilibria; where that leads nowhere, from a rolling cage."""
    equations, (own_scale, shared_scale) = problem.equations(1.0), problem.unknown_scales()
    solution = solve(equations, start.own, start.shared, own_scale, shared_scale, _MAX_NEAR)
    lost = np.flatnonzero(~solution.converged)
    if len(lost):
        own, shared = (unknowns[lost] for unknowns in problem.start())
        scales = own_scale[lost], shared_scale[lost]
        end = solve(of_some(equations, lost), own, shared, *scales, _MAX_ITERATIONS)
        for name, values in vars(solution).items():
            values[lost] = getattr(end, name)
    return solution


@dataclass(frozen=True)
class FrictionProblem:
    """Equations of a bearing's friction equilibrium for `solver.follow`.

    Unknowns of a ball: its centre (x, r) in m and its spin (x, r, t) in rad/s. Shared unknowns:
    the speed of cage and balls in rad/s, then the displacement of the inner ring.
    """

    bearing: Bearing
    points: OperatingPoints
    lubrication: Lubrication
    law: TractionLaw
    rule: Grid

    @cached_property
    def azimuth(self) -> FloatArray:
        """Angle of each ball, shape (balls,)."""
        return azimuths(self.bearing, self.points.only_axial)

    @cached_property
    def ring_speed_rad_s(self) -> FloatArray:
        """Speed of inner and outer ring, shape (points, 2)."""
        return np.stack([self.points.inner_speed_rad_s, self.points.outer_speed_rad_s], axis=-1)

    @cached_property
    def ball_force_n(self) -> FloatArray:
        """Force that residuals are divided by, shape (points,)."""
        return np.maximum(scales(self.bearing, self.points)[0], np.finfo(float).tiny)

    def balance(
        self, own: FloatArray, shared: FloatArray, which: IntArray, share: float
    ) -> Balance:
        """All that acts on the balls of the points `which`."""
        groove = inner_groove(self.bearing, shared[..., 1:], self.azimuth)
        return balance(
            self.bearing,
            contacts_at(self.bearing, own[..., :2], groove),
            Motion(np.broadcast_to(shared[..., :1], own.shape[:-1]), own[..., 2:]),
            self.ring_speed_rad_s[which],
            self.lubrication.at(which),
            law_at(self.law, which),
            self.rule,
            share,
        )

    def equations(self, share: float) -> Equations:
        """The equations with a share of everything that resists or turns the balls."""
        bearing, loads = self.bearing, self.points.loads()
        lever = scales(bearing, self.points)[2]
        radius, pitch = bearing.ball_diameter_m / 2, bearing.pitch_diameter_m / 2

        def residuals(
            own: FloatArray, shared: FloatArray, which: IntArray
        ) -> tuple[FloatArray, FloatArray, FloatArray]:
            state = self.balance(own, shared, which, share)
            unit = self.ball_force_n[which, np.newaxis, np.newaxis]
            on_ring = force_on_ring(
                bearing, state.ring_force_n, state.contacts, self.azimuth, loads.shape[1]
            )
            cage = state.cage_n_m[..., np.newaxis] / pitch
            parts = np.concatenate([cage, on_ring / lever], axis=-1)
            outside = np.zeros(shared.shape)
            outside[..., 1:] = loads[which] / (bearing.ball_count * lever * unit[:, 0])
            return (
                np.concatenate([state.force_n, state.moment_n_m / radius], axis=-1) / unit,
                parts / (len(self.azimuth) * unit),
                outside,
            )

        return residuals

    def start(self) -> tuple[FloatArray, FloatArray]:
        """Unknowns of raceway control without gyroscopic moment."""
        start = raceway_control(self.bearing, self.points, gyroscopic_sign=0.0)
        own = np.concatenate([start.solution.own, start.motion.spin_rad_s], axis=-1)
        orbit = start.motion.orbit_speed_rad_s.mean(axis=1, keepdims=True)
        return own, np.concatenate([orbit, start.displacement], axis=-1)

    def unknown_scales(self) -> tuple[FloatArray, FloatArray]:
        """Scales of the balls' unknowns and of the shared ones."""
        bearing, ring_speed = self.bearing, self.ring_speed_rad_s
        relative = np.abs(ring_speed[:, 0] - ring_speed[:, 1])
        spin = np.maximum(
            relative * bearing.pitch_diameter_m / (2 * bearing.ball_diameter_m), _SLOWEST_RAD_S
        )
        orbit = np.maximum(np.abs(ring_speed).max(axis=1) / 2, _SLOWEST_RAD_S)
        centre = np.full((len(spin), 2), bearing.groove_offset_m.min())
        own = np.concatenate([centre, np.repeat(spin[:, np.newaxis], 3, axis=1)], axis=-1)
        length = scales(bearing, self.points)[1]
        return own, np.concatenate([orbit[:, np.newaxis], length], axis=-1)
