"""Friction equilibrium: how balls and cage move where forces alone decide it, and what it costs.

Beside the loads of `quasistatic`, each ball's three moments and its force along the orbit must
balance: traction in both ellipses, the rolling contacts' resistance, the oil's drag and the cage.
Ball spin, tilt of its axis, gyroscopic slip and the speed of the cage come out. Every part is a
pair of forces on two bodies, so that the power put in at the rings is the sum of the parts' heat.

The cage turns steadily and all balls travel with it, each pushed or held by its pocket.

Decides: motion of balls and cage at the friction equilibrium, and when a cage may roll or skid.
"""

from dataclasses import dataclass, field, replace

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
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import (
    Contacts,
    Motion,
    OperatingPoints,
    ball_force_n,
    centrifugal_force_n,
    contacts_at,
    neighbourhood,
    raceway_control,
)
from oilfilm.bearing.resistance import (
    Lubrication,
    drag_force_n,
    hysteresis_moment_n_m,
    land_damping_n_m_s,
    rolling_force_n,
    rolling_force_reduction,
)
from oilfilm.bearing.solver import Equations, Solution, follow, inverse_jacobian, near, solve
from oilfilm.physics.contact import Conditions
from oilfilm.units import FloatArray, IndexArray

# Nodes of the ellipse across and along the rolling direction.
QUADRATURE = (16, 4)
# The same of random draws, and on the way to another equilibrium.
COARSE = (6, 2)
# Jacobians after which a point is given up.
_MAX_ITERATIONS = 100
# The same where the search starts near by.
_MAX_NEAR = 14
# Quadrature nodes whose arrays fit a processor's cache.
_CACHED = 50_000
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
        heats_w: Of each of `HEATS`.
        left_over_n: What is left at no equilibrium, shape (..., 7): force on the ball along x and
            r; moment about x, r and t, less what its gyroscopic motion takes, over its radius;
            moment on the cage over the pitch radius; force on the inner ring along x.
        ring_moment_n_m: On the inner and the outer ring about the bearing's axis: (..., 2).
    """

    contacts: Contacts
    motion: Motion
    at: Conditions
    sliding: Sliding
    traction: Traction
    drag_n: FloatArray
    heats_w: tuple[FloatArray, ...]
    left_over_n: FloatArray
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
        film = traction(contacts, slip, at, self.law, rule, oil.factor("traction"))
        n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
        orbit = contacts.orbit_radius_m
        race_radius = orbit[..., np.newaxis] + n_r * radius
        roll, flex, roll_heat = self._rolling(contacts, slip, race_radius, share)
        speed = orbit * motion.orbit_speed_rad_s
        drag = drag_force_n(
            bearing.ball_diameter_m, oil.mist_density_kg_m3, oil.drag_coefficient, speed
        )
        drag = drag * share * oil.factor("drag")
        # the oil's rolling force shears the ball's surface and, by its pressure, pushes its centre
        pushed = roll * (2 * race_radius / orbit[..., np.newaxis] - 1)
        pocket = drag - _both(film.along_n + pushed)
        # pocket and ball rub by Coulomb: against the spin, which turns its force by a right angle
        coulomb = share * oil.factor("pocket") * bearing.cage.pocket_friction_coefficient * pocket
        w_x, w_r, w_t = (motion.spin_rad_s[..., part] for part in range(3))
        spin = np.sqrt(w_x**2 + w_r**2)
        turned = np.maximum(spin, np.finfo(float).tiny)
        axis_x, axis_r = w_x / turned, w_r / turned
        rub_r, braked = -coulomb * axis_x, np.abs(coulomb) * radius
        force_x = -(film.across_n * n_r + contacts.load_n * n_x)
        force_r = film.across_n * n_x - contacts.load_n * n_r
        about_n, about_y = film.about_normal_n_m, film.about_across_n_m + radius * roll + flex
        guide = 1 if bearing.cage.guided_by_outer else 0
        lag = rings[:, guide] - motion.orbit_speed_rad_s
        damping = share * oil.factor("land") / bearing.ball_count
        land = damping * land_damping_n_m_s(bearing, oil) * lag
        on_ring = film.race_moment_n_m + flex * n_r - roll * race_radius
        on_ring[..., guide] -= land
        # what the ball's spin, turned along its orbit, takes about r and t
        gyroscopic = share * bearing.ball_inertia_kg_m2 * motion.orbit_speed_rad_s
        outward = rub_r + centrifugal_force_n(bearing, contacts, motion)
        cage = land - pocket * orbit - np.sign(pocket) * radius * rub_r
        about_r = about_n * n_r + about_y * n_x
        parts = (
            _both(force_x) + coulomb * axis_r,
            _both(force_r) + outward,
            (_both(about_n * n_x - about_y * n_r) - braked * axis_x) / radius,
            (_both(about_r) - braked * axis_r + gyroscopic * w_t) / radius,
            (_both(film.about_tangent_n_m) - gyroscopic * w_r) / radius,
            cage / (bearing.pitch_diameter_m / 2),
            self.points.axial_load_n / bearing.ball_count - force_x[..., 0],
        )
        return Balance(
            contacts=contacts,
            motion=motion,
            at=at,
            sliding=slip,
            traction=film,
            drag_n=drag,
            heats_w=(_both(film.heat_w), *roll_heat, drag * speed, braked * spin, land * lag),
            left_over_n=np.stack(parts, axis=-1),
            ring_moment_n_m=on_ring,
        )

    def _rolling(
        self, contacts: Contacts, slip: Sliding, race_radius_m: FloatArray, share: float
    ) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """Rolling resistance in each contact: the oil's force, the moment of hysteresis, heats.

        The oil's force FR acts on both surfaces, against their way. The film is in balance by
        pressure on the two of them, which has no moment about the ball's centre nor about the
        bearing's axis and pushes the ball's centre along its orbit: by 2 FR (race radius)/(orbit
        radius).
        """
        bearing, oil = self.bearing, self.lubrication.of_contacts
        n_r, load = contacts.normal[..., 1, :], contacts.load_n
        # sum of the surface speeds along t
        rolling = slip.race_rad_s * race_radius_m
        rolling -= slip.axis_rad_s * (bearing.ball_diameter_m / 2)
        mean, radius_x = np.abs(rolling / 2), bearing.radius_x_m(np.abs(n_r))
        modulus = bearing.reduced_modulus_pa
        pressure = contacts.max_hertz_pressure_pa / modulus
        reduction = rolling_force_reduction(pressure, oil.thermal_loading(mean))
        viscosity = oil.dynamic_viscosity_pa_s
        force = rolling_force_n(load, mean, viscosity, radius_x, bearing.radius_y_m, modulus)
        moment = hysteresis_moment_n_m(load, bearing.ball_diameter_m, radius_x, bearing.radius_y_m)
        way, known = share * np.sign(rolling), self.lubrication
        force = way * reduction * force * known.factor("rolling")[:, np.newaxis]
        moment = way * moment * known.factor("hysteresis")[:, np.newaxis]
        return force, moment, [_both(force * rolling), -_both(moment * slip.roll_rad_s)]

    def equations(self, share: float) -> Equations:
        """The equations with a share of everything that resists or turns the balls."""
        unit = ball_force_n(self.bearing, self.points)

        def residuals(unknowns: FloatArray, which: IndexArray) -> FloatArray:
            # in parts whose arrays fit a processor's cache
            nodes = unknowns[..., 0].size * len(self.rule.share)
            if nodes > _CACHED and len(which) > 1:
                half = len(which) // 2
                halves = np.split(unknowns, [half], axis=-2), np.split(which, [half])
                return np.concatenate([*map(residuals, *halves)], axis=-2)
            left = self.at(which).balance(unknowns, share).left_over_n
            return left / unit[which, np.newaxis]

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
        axis = np.abs(self.balance.sliding.axis_rad_s)
        race = contacts.orbit_radius_m[..., np.newaxis] + contacts.normal[..., 1, :] * radius
        reach = race / np.maximum(axis / np.maximum(axis.max(axis=-1, keepdims=True), 1e-300), 1e-3)
        rolling = (rings * reach).sum(axis=-1) / reach.sum(axis=-1)
        lag = rolling - motion.orbit_speed_rad_s
        return np.divide(lag, rolling, out=np.zeros_like(lag), where=rolling != 0)

    def widest_contact(self) -> FloatArray:
        """Semi-axis across the rolling direction over the balls' radius, the wider of the two."""
        radius = self.problem.bearing.ball_diameter_m / 2
        return np.asarray(self.balance.contacts.semi_axis_y_m.max(axis=-1) / radius)


def _both(values: FloatArray) -> FloatArray:
    """The sum over both contacts."""
    return np.asarray(values[..., 0] + values[..., 1])


@dataclass(frozen=True)
class Neighbour:
    """Known equilibria, near which others are looked for.

    Attributes:
        unknowns: Shape (points, 7).
        inverse: Of the Jacobian there, shape (points, 7, 7).
    """

    unknowns: FloatArray
    inverse: FloatArray

    @classmethod
    def of(cls, problem: FrictionProblem, unknowns: FloatArray) -> "Neighbour":
        """The equilibria of a problem."""
        slope = inverse_jacobian(problem.equations(1.0), unknowns, problem.scale())
        return cls(unknowns, slope)

    def at(self, which: IndexArray) -> "Neighbour":
        """Some of them."""
        return Neighbour(self.unknowns[which], self.inverse[which])


def friction_equilibrium(
    problem: FrictionProblem, neighbour: Neighbour | None = None
) -> FrictionEquilibrium:
    """Where balls, cage and inner ring travel steadily under all forces.

    Args:
        problem: Bearing, loads, speeds, oil and law.
        neighbour: Equilibria with other constants, near which these are looked for first.

    Returns:
        The motion; not converged as well where a contact would be as wide as the ball.
    """
    scale = problem.scale()
    if neighbour is None:
        # a law may be one of certain nodes
        plain = problem.rule.counts == QUADRATURE
        rule = grid(*COARSE) if plain else problem.rule
        coarse = replace(problem, rule=rule)
        start, place = problem.start(), neighbourhood(problem.points)
        solution = follow(coarse.equations, start, scale, _MAX_ITERATIONS, place)
        found = np.flatnonzero(solution.converged)
        if problem.rule is not rule and len(found):
            part = problem.at(found)
            solution.put(found, _near(part, Neighbour.of(part, solution.unknowns[found])))
        if problem.rule is not rule and len(lost := np.flatnonzero(~solution.converged)):
            equations = problem.at(lost).equations(1.0)
            solution.put(lost, solve(equations, start[lost], scale[lost], _MAX_ITERATIONS))
    else:
        solution = _near(problem, neighbour)
    made = FrictionEquilibrium(problem, problem.balance(solution.unknowns), solution)
    # beyond the range of Hertz's solution and of the groove there is no equilibrium
    solution.converged[made.widest_contact() >= 1] = False
    return made


def _near(problem: FrictionProblem, neighbour: Neighbour) -> Solution:
    """From known equilibria; where that leads nowhere, from there and a rolling cage by Newton."""
    start, scale = neighbour.unknowns, problem.scale()
    solution = near(problem.equations(1.0), start, scale, neighbour.inverse)
    for most in (_MAX_NEAR, _MAX_ITERATIONS):
        if len(lost := np.flatnonzero(~solution.converged)):
            part = problem.at(lost)
            begin = start[lost] if most == _MAX_NEAR else part.start()
            solution.put(lost, solve(part.equations(1.0), begin, scale[lost], most))
    return solution


# Factors on all traction on the way down to the law; the way up has the reciprocals.
_FACTORS = (4.0, 2.0, 1.4, 1.15, 1.0)
# Speed of a skidding cage at the start, over that of a rolling one.
_SKIDDING = 0.5
# Jacobians of one step of the traction.
_MAX_OF_STEP = 12
# Cage slips of two equilibria are further apart.
_APART = 1e-3


def other_equilibrium(
    problem: FrictionProblem, known_cage_slip: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Cage slip and torque of the equilibrium that is not the known one, where there is another.

    Traction that falls with slip can hold a cage at two speeds: the film of a rolling contact pulls
    hard enough, that of a skidding one no longer does. Which of them a bearing takes depends on its
    past. One search comes from stronger traction, where the cage rolls, and one from weaker
    traction, where it skids; where they end apart there are two equilibria. A branch that is
    connected with neither would be missed.

    Args:
        problem: Bearing, loads, speeds, oil and law; the outer ring at rest.
        known_cage_slip: Of the known equilibria, shape (points,); NaN where there is none.

    Returns:
        Two arrays of shape (points,), NaN where no second equilibrium was found.
    """
    count = len(known_cage_slip)
    whole = problem.at(np.tile(np.arange(count), 2))
    unknowns, scale = whole.start(), whole.scale()
    # cage and balls that have lost half their speed: they roll on the outer race and slide on the
    # inner one
    unknowns[count:, 2:6] *= _SKIDDING
    for factor in _FACTORS:
        both_ways = whole.lubrication.with_traction(np.repeat([factor, 1 / factor], count))
        # fewer nodes are enough on the way
        rule = whole.rule if factor == _FACTORS[-1] else grid(*COARSE)
        part = replace(whole, lubrication=both_ways, rule=rule)
        end = solve(part.equations(1.0), unknowns, scale, _MAX_OF_STEP)
        # what is lost at one factor starts at the next from where it was
        unknowns = np.where(end.converged[:, np.newaxis], end.unknowns, unknowns)
    final = FrictionEquilibrium(whole, whole.balance(unknowns), end)
    slip = np.where(end.converged, final.cage_slip(), np.nan).reshape(2, count)
    away = np.nan_to_num(np.abs(slip - known_cage_slip))
    chosen = away.argmax(axis=0), np.arange(count)
    apart = away[chosen] > _APART
    torque = final.torque_n_m().reshape(2, count)
    return np.where(apart, slip[chosen], np.nan), np.where(apart, torque[chosen], np.nan)
