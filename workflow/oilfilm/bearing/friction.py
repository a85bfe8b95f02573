"""Friction equilibrium: how balls and cage move where forces alone decide it, and what it costs.

Beside the loads of `quasistatic`, each ball's three moments and its force along the orbit must
balance: traction in both ellipses, the rolling contacts' resistance, the oil's drag and the cage.
Ball spin, tilt of its axis, gyroscopic slip and the speed of the cage come out. Every part is a
pair of forces on two bodies, so that the power put in at the rings is the sum of the parts' heat.

The cage turns steadily and all balls travel with it, each pushed or held by its pocket.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.bearing.ellipse import (
    Conditions,
    Grid,
    Traction,
    TractionBasis,
    conditions,
    grid,
    sliding,
    traction,
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import (
    Contacts,
    Equilibrium,
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
    Lubrication,
    drag_force_n,
    hysteresis_moment_n_m,
    land_damping_n_m_s,
    rolling_force_n,
    rolling_force_reduction,
)
from oilfilm.bearing.solver import Equations, IntArray, follow
from oilfilm.units import FloatArray

# Places of the ellipse across and along the rolling direction.
QUADRATURE = (16, 4)
# Scale of the speeds of a bearing at rest.
_SLOWEST_RAD_S = 1e-3


@dataclass(frozen=True)
class Resistance:
    """Rolling resistance in each contact; shapes (..., 2).

    Attributes:
        force_n: Of the oil drawn in, on either surface.
        moment_n_m: Of hysteresis.
        sense: Way of the surfaces through the contact along t, 1 or -1.
    """

    force_n: FloatArray
    moment_n_m: FloatArray
    sense: FloatArray


@dataclass(frozen=True)
class Balance:
    """All that acts on balls; shapes (..., balls) and more.

    Attributes:
        contacts: Normal contacts.
        motion: Of the balls.
        at: What the traction law was told.
        traction: Of the film in the ellipses.
        resistance: Of rolling.
        drag_n: Of the oil along t, against the orbit.
        pocket_n: Of the cage on the ball along t.
        land_n_m: Moment of the land on the cage, a ball's share of it; shape (..., balls).
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
    traction: Traction
    resistance: Resistance
    drag_n: FloatArray
    pocket_n: FloatArray
    land_n_m: FloatArray
    heat_w: FloatArray
    force_n: FloatArray
    moment_n_m: FloatArray
    cage_n_m: FloatArray
    ring_force_n: FloatArray
    ring_moment_n_m: FloatArray


HEATS = ("traction", "rolling", "hysteresis", "drag", "pocket", "land")


def balance(
    bearing: Bearing,
    contacts: Contacts,
    motion: Motion,
    ring_speed_rad_s: FloatArray,
    lubrication: Lubrication,
    law: TractionBasis,
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
        rule: Places of the ellipse.
        share: Of everything that resists or turns the balls beside traction.
    """
    slip = sliding(bearing, contacts, motion, ring_speed_rad_s[:, np.newaxis], rule)
    temperature = lubrication.inlet_temperature_c[:, np.newaxis, np.newaxis]
    at = conditions(bearing, contacts, slip, temperature)
    film = traction(contacts, slip, at, law, rule)
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    across = tangent(contacts.normal)
    radius, orbit = bearing.ball_diameter_m / 2, contacts.orbit_radius_m
    race_radius = orbit[..., np.newaxis] + n_r * radius
    roll = _resistance(bearing, contacts, motion, ring_speed_rad_s, lubrication, share)
    # shear on the ball's surface and, by the pressure, on its centre (see `_resistance`)
    pushed = roll.sense * roll.force_n * (2 * race_radius / orbit[..., np.newaxis] - 1)
    speed = orbit * motion.orbit_speed_rad_s
    mist = share * lubrication.mist_density_kg_m3[:, np.newaxis]
    drag = drag_force_n(bearing.ball_diameter_m, mist, lubrication.drag_coefficient, speed)
    pocket = drag - film.force_n[..., 1, :].sum(axis=-1) - pushed.sum(axis=-1)
    rub_force, rub_moment = _pocket_friction(bearing, motion, share * pocket)
    # moments about (n, t x n, t), then about (x, r, t)
    about_y = film.moment_n_m[..., 1, :] + roll.sense * (radius * roll.force_n + roll.moment_n_m)
    moment = np.stack(
        [
            (film.moment_n_m[..., 0, :] * n_x - about_y * n_r).sum(axis=-1),
            (film.moment_n_m[..., 0, :] * n_r + about_y * n_x).sum(axis=-1),
            film.moment_n_m[..., 2, :].sum(axis=-1),
        ],
        axis=-1,
    )
    taken = share * gyroscopic_moment_n_m(bearing, motion)
    on_ball = (
        film.force_n[..., 0, np.newaxis, :] * across
        - contacts.load_n[..., np.newaxis, :] * contacts.normal
    )
    force = on_ball.sum(axis=-1) + rub_force
    force[..., 1] += centrifugal_force_n(bearing, contacts, motion)
    on_race = film.race_moment_n_m + roll.sense * (
        roll.moment_n_m * n_r - roll.force_n * race_radius
    )
    guide = 1 if bearing.cage.guided_by_outer else 0
    damping = share * land_damping_n_m_s(bearing, lubrication)[:, np.newaxis] / bearing.ball_count
    land = damping * (ring_speed_rad_s[:, guide, np.newaxis] - motion.orbit_speed_rad_s)
    on_ring = on_race.copy()
    on_ring[..., guide] -= land
    relative = ring_speed_rad_s[:, np.newaxis] - motion.orbit_speed_rad_s[..., np.newaxis]
    w_y = motion.spin_rad_s[..., 1, np.newaxis] * n_x - motion.spin_rad_s[..., 0, np.newaxis] * n_r
    rolled = relative * race_radius - w_y * radius
    flexed = -(w_y + relative * n_r)
    heat = np.stack(
        [
            film.heat_w.sum(axis=-1),
            (roll.force_n * roll.sense * rolled).sum(axis=-1),
            (roll.moment_n_m * roll.sense * flexed).sum(axis=-1),
            drag * speed,
            -(rub_moment * motion.spin_rad_s).sum(axis=-1),
            land * (ring_speed_rad_s[:, guide, np.newaxis] - motion.orbit_speed_rad_s),
        ],
        axis=-1,
    )
    return Balance(
        contacts,
        motion,
        at,
        film,
        roll,
        drag,
        pocket,
        land,
        heat,
        force,
        moment + rub_moment - taken,
        land - pocket * orbit - np.sign(pocket) * radius * rub_force[..., 1],
        np.stack(
            [
                -on_ball[..., 0, 0],
                -on_ball[..., 1, 0],
                -film.force_n[..., 1, 0] - roll.sense[..., 0] * roll.force_n[..., 0],
            ],
            axis=-1,
        ),
        on_ring,
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
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    radius = bearing.ball_diameter_m / 2
    w_y = motion.spin_rad_s[..., 1, np.newaxis] * n_x - motion.spin_rad_s[..., 0, np.newaxis] * n_r
    relative = ring_speed_rad_s[:, np.newaxis] - motion.orbit_speed_rad_s[..., np.newaxis]
    race_radius = contacts.orbit_radius_m[..., np.newaxis] + n_r * radius
    mean = (relative * race_radius - w_y * radius) / 2
    radius_x = bearing.radius_x_m(np.abs(n_r))
    oil = lubrication.of_contacts
    reduction = rolling_force_reduction(
        oil, contacts.max_hertz_pressure_pa, np.abs(mean), bearing.reduced_modulus_pa
    )
    force = rolling_force_n(
        contacts.load_n,
        np.abs(mean),
        oil.dynamic_viscosity_pa_s,
        radius_x,
        bearing.radius_y_m,
        bearing.reduced_modulus_pa,
    )
    flexing = hysteresis_moment_n_m(
        contacts.load_n, bearing.ball_diameter_m, radius_x, bearing.radius_y_m
    )
    return Resistance(share * reduction * force, share * flexing, np.sign(mean))


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
        equilibrium: Loads, motion and the solver's account.
        places: Number of balls that each row of balls stands for.
    """

    balance: Balance
    equilibrium: Equilibrium
    places: float


def widest_contact(bearing: Bearing, contacts: Contacts) -> FloatArray:
    """Semi-axis across the rolling direction over the balls' radius, the widest of each point."""
    return contacts.semi_axis_y_m.max(axis=(1, 2)) / (bearing.ball_diameter_m / 2)


def friction_equilibrium(
    bearing: Bearing,
    points: OperatingPoints,
    lubrication: Lubrication,
    law: TractionBasis,
    quadrature: tuple[int, int] = QUADRATURE,
    tolerance: float = 1e-10,
    max_iterations: int = 100,
) -> FrictionEquilibrium:
    """Where balls, cage and inner ring travel steadily under all forces.

    Args:
        bearing: The bearing.
        points: Loads and speeds.
        lubrication: The oil at each point.
        law: The traction law.
        quadrature: Places of the ellipse, across and along the rolling direction.
        tolerance: Largest residual, over the load of a ball (moments: times its radius).
        max_iterations: Jacobians after which a point is given up.

    Returns:
        The motion; not converged as well where a contact would be as wide as the ball.
    """
    rule = grid(*quadrature)
    azimuth = azimuths(bearing, points.only_axial)
    loads = points.loads()
    force, length, lever = scales(bearing, points)
    force = np.maximum(force, np.finfo(float).tiny)
    ring_speed = np.stack([points.inner_speed_rad_s, points.outer_speed_rad_s], axis=-1)
    spin_scale = np.maximum(
        np.abs(ring_speed[:, 0] - ring_speed[:, 1])
        * bearing.pitch_diameter_m
        / (2 * bearing.ball_diameter_m),
        _SLOWEST_RAD_S,
    )
    orbit_scale = np.maximum(np.abs(ring_speed).max(axis=1) / 2, _SLOWEST_RAD_S)
    radius, pitch = bearing.ball_diameter_m / 2, bearing.pitch_diameter_m / 2

    def acting(own: FloatArray, shared: FloatArray, which: IntArray, share: float) -> Balance:
        contacts = contacts_at(
            bearing, own[..., :2], inner_groove(bearing, shared[..., 1:], azimuth)
        )
        orbit = np.broadcast_to(shared[..., :1], own.shape[:-1])
        return balance(
            bearing,
            contacts,
            Motion(orbit, own[..., 2:]),
            ring_speed[which],
            lubrication.at(which),
            law,
            rule,
            share,
        )

    def with_share(share: float) -> Equations:
        def equations(
            own: FloatArray, shared: FloatArray, which: IntArray
        ) -> tuple[FloatArray, FloatArray, FloatArray]:
            found = acting(own, shared, which, share)
            unit = force[which, np.newaxis, np.newaxis]
            parts = np.concatenate(
                [
                    found.cage_n_m[..., np.newaxis] / pitch,
                    force_on_ring(
                        bearing, found.ring_force_n, found.contacts, azimuth, loads.shape[1]
                    )
                    / lever,
                ],
                axis=-1,
            )
            outside = np.zeros(shared.shape)
            outside[..., 1:] = loads[which] / (bearing.ball_count * lever * unit[:, 0])
            return (
                np.concatenate([found.force_n, found.moment_n_m / radius], axis=-1) / unit,
                parts / (len(azimuth) * unit),
                outside,
            )

        return equations

    start = raceway_control(bearing, points, gyroscopic_sign=0.0)
    own = np.concatenate([start.solution.own, start.motion.spin_rad_s], axis=-1)
    orbit = start.motion.orbit_speed_rad_s.mean(axis=1, keepdims=True)
    shared = np.concatenate([orbit, start.displacement], axis=-1)
    own_scale = np.concatenate(
        [
            np.full((len(loads), 2), bearing.groove_offset_m.min()),
            np.repeat(spin_scale[:, np.newaxis], 3, axis=1),
        ],
        axis=-1,
    )
    shared_scale = np.concatenate([orbit_scale[:, np.newaxis], length], axis=-1)
    solution = follow(
        with_share,
        own,
        shared,
        own_scale,
        shared_scale,
        tolerance,
        max_iterations,
        neighbourhood(points),
    )
    every = np.arange(len(loads))
    found = acting(solution.own, solution.shared, every, 1.0)
    # beyond all that Hertz's solution and a groove can bear: no equilibrium
    solution.converged[widest_contact(bearing, found.contacts) >= 1] = False
    equilibrium = Equilibrium(found.contacts, found.motion, solution.shared[:, 1:], solution)
    return FrictionEquilibrium(found, equilibrium, bearing.ball_count / len(azimuth))
