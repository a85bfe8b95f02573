"""Friction equilibrium: how balls and cage move where forces alone decide it, and what it costs.

Beside the loads of `quasistatic`, each ball's three moments and its force along the orbit must
balance: traction in both ellipses, the rolling contacts' resistance, the oil's drag and the cage.
Ball spin, tilt of its axis, gyroscopic slip and the speed of the cage come out. Every part is a
pair of forces on two bodies, so that the power put in at the rings is the sum of the parts' heat.

The cage turns steadily and all balls travel with it, each pushed or held by its pocket.

Decides: motion of balls and cage at the friction equilibrium.
"""

from dataclasses import dataclass, field

import numpy as np

from oilfilm.bearing.ellipse import (
    Grid,
    Sliding,
    Traction,
    TractionLaw,
    conditions,
    grid,
    law_at,
    sliding,
    traction,
    turning,
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import (
    Contacts,
    Motion,
    OperatingPoints,
    ball_force_n,
    centrifugal_force_n,
    contacts_at,
    gyroscopic_moment_n_m,
    neighbourhood,
    raceway_control,
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
from oilfilm.bearing.solver import Equations, Solution, follow, of_some, solve
from oilfilm.physics.contact import Conditions
from oilfilm.units import FloatArray, IndexArray

# Nodes of the ellipse across and along the rolling direction.
QUADRATURE = (16, 4)
HEATS = ("traction", *TERMS)
# Jacobians after which a point is given up.
_MAX_ITERATIONS = 100
# The same where the search starts near by.
_MAX_NEAR = 14
# Points whose arrays about fit a processor's cache.
_CHUNK = 2000
# Scale of the speeds of a bearing at rest.
_SLOWEST_RAD_S = 1e-3


@dataclass(frozen=True)
class Balance:
    """All that acts on a ball and its share of cage and rings; shapes (...) and more.

    Attributes:
        contacts: Normal contacts.
        motion: Of the ball.
        at: Conditions of the contacts.
        sliding: In the ellipses.
        traction: Of the film in the ellipses.
        drag_n: Of the oil along t, against the orbit.
        heat_w: Of each of `HEATS`: (..., 6).
        force_n: On the ball, (x, r): what is left of it at no equilibrium.
        moment_n_m: On the ball about (x, r, t), less what its gyroscopic motion takes.
        cage_n_m: On the cage.
        ring_force_n: On the inner ring along x.
        ring_moment_n_m: On the inner and the outer ring about the bearing's axis: (..., 2).
    """

    contacts: Contacts
    motion: Motion
    at: Conditions
    sliding: Sliding
    traction: Traction
    drag_n: FloatArray
    heat_w: FloatArray
    force_n: FloatArray
    moment_n_m: FloatArray
    cage_n_m: FloatArray
    ring_force_n: FloatArray
    ring_moment_n_m: FloatArray


@dataclass(frozen=True)
class FrictionProblem:
    """A bearing at operating points, and the equations of its friction equilibrium.

    Unknowns of each point: the ball's centre (x, r) in m, its spin (x, r, t) and the speed of cage
    and balls in rad/s, and the displacement of the inner ring along x in m.

    Attributes:
        bearing: The bearing.
        points: Loads and speeds.
        lubrication: The oil at each point.
        law: The traction law.
        rule: Quadrature nodes of the ellipse.
    """

    bearing: Bearing
    points: OperatingPoints
    lubrication: Lubrication
    law: TractionLaw
    rule: Grid = field(default_factory=lambda: grid(*QUADRATURE))

    def at(self, which: IndexArray) -> "FrictionProblem":
        """The problem of some of the points."""
        points, lubrication = self.points.at(which), self.lubrication.at(which)
        return FrictionProblem(
            self.bearing, points, lubrication, law_at(self.law, which), self.rule
        )

    def balance(self, unknowns: FloatArray, share: float = 1.0) -> Balance:
        """All that acts on the balls, shapes (..., points, ...).

        Args:
            unknowns: Shape (..., points, 7).
            share: Of everything that resists or turns the balls beside traction.
        """
        bearing, oil, rule = self.bearing, self.lubrication, self.rule
        rings, radius = self.points.ring_speed_rad_s, bearing.ball_diameter_m / 2
        contacts = contacts_at(bearing, unknowns[..., :2], unknowns[..., 6])
        motion = Motion(unknowns[..., 5], unknowns[..., 2:5])
        slip = sliding(bearing, contacts, motion, rings, rule)
        at = conditions(bearing, contacts, slip, oil.inlet_temperature_c[:, np.newaxis])
        film = traction(contacts, slip, at, self.law, rule)
        (n_x, n_r), orbit = np.moveaxis(contacts.normal, -2, 0), contacts.orbit_radius_m
        race_radius = orbit[..., np.newaxis] + n_r * radius
        roll, flex, roll_heat = self._rolling(contacts, motion, race_radius, share)
        speed = orbit * motion.orbit_speed_rad_s
        drag = drag_force_n(
            bearing.ball_diameter_m, oil.mist_density_kg_m3, oil.drag_coefficient, speed
        )
        drag = drag * share * oil.factor("drag")
        # the oil's rolling force shears the ball's surface and, by its pressure, pushes its centre
        pushed = roll * (2 * race_radius / orbit[..., np.newaxis] - 1)
        pocket = drag - (film.force_n[..., 1, :] + pushed).sum(axis=-1)
        # pocket and ball rub by Coulomb: against the spin, which turns its force by a right angle
        coulomb = share * oil.factor("pocket") * bearing.cage.pocket_friction_coefficient * pocket
        spin = np.hypot(motion.spin_rad_s[..., 0], motion.spin_rad_s[..., 1])
        axis = motion.spin_rad_s[..., :2] / np.maximum(spin, np.finfo(float).tiny)[..., None]
        rub_x, rub_r = coulomb * axis[..., 1], -coulomb * axis[..., 0]
        braked = np.abs(coulomb) * radius
        force_x = -(film.force_n[..., 0, :] * n_r + contacts.load_n * n_x)
        force_r = film.force_n[..., 0, :] * n_x - contacts.load_n * n_r
        outward = rub_r + centrifugal_force_n(bearing, contacts, motion)
        about_n, about_y, about_t = np.moveaxis(film.moment_n_m, -2, 0)
        about_y = about_y + radius * roll + flex
        moment = [
            (about_n * n_x - about_y * n_r).sum(axis=-1) - braked * axis[..., 0],
            (about_n * n_r + about_y * n_x).sum(axis=-1) - braked * axis[..., 1],
            about_t.sum(axis=-1),
        ]
        guide = 1 if bearing.cage.guided_by_outer else 0
        lag = rings[:, guide] - motion.orbit_speed_rad_s
        damping = share * oil.factor("land") / bearing.ball_count
        land = damping * land_damping_n_m_s(bearing, oil) * lag
        on_ring = film.race_moment_n_m + flex * n_r - roll * race_radius
        on_ring[..., guide] -= land
        heat = [film.heat_w.sum(axis=-1), *roll_heat, drag * speed, braked * spin, land * lag]
        return Balance(
            contacts=contacts,
            motion=motion,
            at=at,
            sliding=slip,
            traction=film,
            drag_n=drag,
            heat_w=np.stack(heat, axis=-1),
            force_n=np.stack(
                [force_x.sum(axis=-1) + rub_x, force_r.sum(axis=-1) + outward], axis=-1
            ),
            moment_n_m=np.stack(moment, axis=-1) - share * gyroscopic_moment_n_m(bearing, motion),
            cage_n_m=land - pocket * orbit - np.sign(pocket) * radius * rub_r,
            ring_force_n=-force_x[..., 0],
            ring_moment_n_m=on_ring,
        )

    def _rolling(
        self, contacts: Contacts, motion: Motion, race_radius_m: FloatArray, share: float
    ) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """Rolling resistance in each contact: the oil's force, the moment of hysteresis, heats.

        The oil's force FR acts on both surfaces, against their way. The film is in balance by
        pressure on the two of them, which has no moment about the ball's centre nor about the
        bearing's axis and pushes the ball's centre along its orbit: by 2 FR (race radius)/(orbit
        radius).
        """
        bearing, oil = self.bearing, self.lubrication.of_contacts
        n_r, load = contacts.normal[..., 1, :], contacts.load_n
        _, w_y, race = turning(contacts, motion, self.points.ring_speed_rad_s)
        # sum of the surface speeds along t
        rolling = race * race_radius_m - w_y * bearing.ball_diameter_m / 2
        mean, radius_x = np.abs(rolling / 2), bearing.radius_x_m(np.abs(n_r))
        modulus = bearing.reduced_modulus_pa
        pressure = contacts.max_hertz_pressure_pa / modulus
        reduction = rolling_force_reduction(pressure, oil.thermal_loading(mean))
        viscosity = oil.dynamic_viscosity_pa_s
        force = rolling_force_n(load, mean, viscosity, radius_x, bearing.radius_y_m, modulus)
        moment = hysteresis_moment_n_m(load, bearing.ball_diameter_m, radius_x, bearing.radius_y_m)
        factors = self.lubrication.factors[:, np.newaxis]
        way = share * np.sign(rolling)
        force = way * reduction * force * factors[..., TERMS.index("rolling")]
        moment = way * moment * factors[..., TERMS.index("hysteresis")]
        heats = [force * rolling, -moment * (w_y + race * n_r)]
        return force, moment, [heat.sum(axis=-1) for heat in heats]

    def equations(self, share: float) -> Equations:
        """The equations with a share of everything that resists or turns the balls."""
        bearing, unit = self.bearing, ball_force_n(self.bearing, self.points)
        load = self.points.axial_load_n / bearing.ball_count
        radius, pitch = bearing.ball_diameter_m / 2, bearing.pitch_diameter_m / 2

        def residuals(unknowns: FloatArray, which: IndexArray) -> FloatArray:
            state = self.at(which).balance(unknowns, share)
            parts = [
                state.force_n,
                state.moment_n_m / radius,
                state.cage_n_m[..., np.newaxis] / pitch,
                (state.ring_force_n + load[which])[..., np.newaxis],
            ]
            return np.concatenate(parts, axis=-1) / unit[which, np.newaxis]

        return residuals

    def start(self) -> FloatArray:
        """Unknowns of raceway control without gyroscopic moment."""
        start = raceway_control(self.bearing, self.points, gyroscopic_sign=0.0)
        ball, ring = start.solution.unknowns[:, :2], start.solution.unknowns[:, 2]
        return np.column_stack(
            [ball, start.motion.spin_rad_s, start.motion.orbit_speed_rad_s, ring]
        )

    def scale(self) -> FloatArray:
        """Scale of each unknown."""
        bearing, rings = self.bearing, self.points.ring_speed_rad_s
        relative = np.abs(rings[:, 0] - rings[:, 1])
        spin = relative * bearing.pitch_diameter_m / (2 * bearing.ball_diameter_m)
        spin = np.maximum(spin, _SLOWEST_RAD_S)
        orbit = np.maximum(np.abs(rings).max(axis=1) / 2, _SLOWEST_RAD_S)
        length = np.full(len(rings), bearing.groove_offset_m.min())
        return np.column_stack([length, length, spin, spin, spin, orbit, length])


@dataclass(frozen=True)
class FrictionEquilibrium:
    """Steady motion of a bearing in which all forces balance.

    Attributes:
        problem: What was solved.
        balance: All that acts on a ball of each point.
        solution: The solver's account, with residuals over the load of a ball (moments: times its
            radius).
    """

    problem: FrictionProblem
    balance: Balance
    solution: Solution

    def torque_n_m(self) -> FloatArray:
        """Moment that turns the inner ring, shape (points,)."""
        return np.asarray(-self.problem.bearing.ball_count * self.balance.ring_moment_n_m[..., 0])

    def cage_slip(self) -> FloatArray:
        """By how much the cage lags behind balls that roll on both races, relative: (points,).

        The balls' axis is taken as it is; rolling is no sliding in the middle of either contact.
        """
        contacts, motion = self.balance.contacts, self.balance.motion
        rings = self.problem.points.ring_speed_rad_s
        radius = self.problem.bearing.ball_diameter_m / 2
        axis = np.abs(turning(contacts, motion, rings).about_tangent)
        race = contacts.orbit_radius_m[..., np.newaxis] + contacts.normal[..., 1, :] * radius
        reach = race / np.maximum(axis / np.maximum(axis.max(axis=-1, keepdims=True), 1e-300), 1e-3)
        rolling = (rings * reach).sum(axis=-1) / reach.sum(axis=-1)
        lag = rolling - motion.orbit_speed_rad_s
        return np.divide(lag, rolling, out=np.zeros_like(lag), where=rolling != 0)

    def widest_contact(self) -> FloatArray:
        """Semi-axis across the rolling direction over the balls' radius, the wider of the two."""
        radius = self.problem.bearing.ball_diameter_m / 2
        return np.asarray(self.balance.contacts.semi_axis_y_m.max(axis=-1) / radius)


def friction_equilibrium(
    problem: FrictionProblem, start: FloatArray | None = None
) -> FrictionEquilibrium:
    """Where balls, cage and inner ring travel steadily under all forces.

    Args:
        problem: Bearing, loads, speeds, oil and law.
        start: Unknowns of equilibria with other constants, near which these are looked for first.

    Returns:
        The motion; not converged as well where a contact would be as wide as the ball.
    """
    if start is None:
        of_start, scale, near = problem.start(), problem.scale(), neighbourhood(problem.points)
        solution = follow(problem.equations, of_start, scale, _MAX_ITERATIONS, near)
    else:
        solution = _near(problem, start)
    found = FrictionEquilibrium(problem, problem.balance(solution.unknowns), solution)
    # beyond the range of Hertz's solution and of the groove there is no equilibrium
    solution.converged[found.widest_contact() >= 1] = False
    return found


def _near(problem: FrictionProblem, start: FloatArray) -> Solution:
    """From known equilibria; where that leads nowhere, from a rolling cage."""
    equations, scale = problem.equations(1.0), problem.scale()
    chunks = np.array_split(np.arange(len(start)), -(-len(start) // _CHUNK))
    parts = [
        solve(of_some(equations, chunk), start[chunk], scale[chunk], _MAX_NEAR) for chunk in chunks
    ]
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    solution = Solution(*map(np.concatenate, columns))
    lost = np.flatnonzero(~solution.converged)
    if len(lost):
        again = problem.at(lost)
        end = solve(again.equations(1.0), again.start(), scale[lost], _MAX_ITERATIONS)
        solution.put(lost, end)
    return solution
