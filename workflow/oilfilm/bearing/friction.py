"""Friction equilibrium: how balls and cage move where forces alone decide it, and what it costs.

Beside the loads of `quasistatic`, each ball's three moments and its force along the orbit must
balance: traction in both ellipses, the rolling contacts' resistance, the oil's drag and the cage.
Ball spin, tilt of its axis, gyroscopic slip and the speed of the cage come out. Every part is a
pair of forces on two bodies, so that the power put in at the rings is the sum of the parts' heat.

The cage turns steadily and all balls travel with it, each pushed or held by its pocket.

Decides: the forces on balls and cage, and the cage slip above which no law holds.
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
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import (
    Contacts,
    Motion,
    OperatingPoints,
    ball_force_n,
    centrifugal_force_n,
    contacts_at,
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
from oilfilm.bearing.solver import Solution
from oilfilm.physics.contact import Conditions, Floats
from oilfilm.units import BoolArray, FloatArray, IndexArray

# Nodes of the ellipse across and along the rolling direction.
QUADRATURE = (16, 4)
# The same of random draws, and on the way to an equilibrium.
COARSE = (6, 2)
# Quadrature nodes whose arrays fit a processor's cache.
_CACHED = 50_000
# Cage slip above which the outer contact hardly rolls. No setting: beyond it the motions are so
# close to each other that their number is not known either (`equilibria`).
_HARDLY_ROLLS = 0.9
# Scale of the speeds of a bearing at rest.
_SLOWEST_RAD_S = 1e-3


# Widths of the three bands in which jumps of the balance are smoothed, as columns: of the rolling
# speed and of a ball's spin, both over those of balls that roll between the rings, and of the
# entrainment speed in m/s. Narrower ones (0.2 %) leave curves unfinished, wider ones (1, 2 %) turn
# some of them back.
FULL_BANDS = np.array([[0.005, 0.005, 2.0]])
NO_BANDS = np.zeros((1, 3))


def smooth_sign(value: FloatArray, band: FloatArray) -> FloatArray:
    """The sign of a value, smooth within a band: t (3 - t^2)/2 with t = value/band.

    Value and slope are continuous at the ends of the band.
    """
    inside = np.abs(value) < band
    t = np.divide(value, band, out=np.zeros_like(value), where=inside)
    return np.where(inside, t * (3 - t**2) / 2, np.sign(value))


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
        bands: Widths within which jumps are smoothed, in columns as of `FULL_BANDS`: one row, or
            shape (..., points, 3). Outside these bands nothing changes. The resistance to rolling
            jumps where the surfaces' speeds cancel, the friction of a pocket turns where the
            ball's spin changes its axis, and a law of the slide-roll ratio has a pole where
            nothing is entrained; a curve of equilibria can be followed through smooth passages
            only.
    """

    bearing: Bearing
    points: OperatingPoints
    lubrication: Lubrication
    law: TractionLaw
    rule: Grid = field(default_factory=lambda: grid(*QUADRATURE))
    bands: FloatArray = field(default_factory=lambda: NO_BANDS)

    def at(self, which: IndexArray) -> "FrictionProblem":
        """The problem of some of the points."""
        points, lubrication = self.points.at(which), self.lubrication.at(which)
        bands = self.bands if len(self.bands) == 1 else self.bands[..., which, :]
        law = law_at(self.law, which)
        return FrictionProblem(self.bearing, points, lubrication, law, self.rule, bands)

    def balance(self, unknowns: FloatArray, share: Floats = 1.0) -> Balance:
        """All that acts on the balls, shapes (..., points, ...).

        Args:
            unknowns: Shape (..., points, 7).
            share: Of everything that resists or turns the balls beside traction: one number, or
                numbers of shape (..., points).
        """
        bearing, oil, rule = self.bearing, self.lubrication, self.rule
        rings, radius = self.points.ring_speed_rad_s, bearing.ball_diameter_m / 2
        contacts = contacts_at(bearing, unknowns[..., :2], unknowns[..., 6])
        motion = Motion(unknowns[..., 5], unknowns[..., 2:5])
        slip = sliding(bearing, contacts, motion, rings, rule, self.bands[..., 2:])
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
        of_axis = smooth_sign(spin, self.bands[..., 1] * self.rolling_spin_rad_s())
        of_axis = of_axis / np.maximum(spin, np.finfo(float).tiny)
        axis_x, axis_r = w_x * of_axis, w_r * of_axis
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
        self, contacts: Contacts, slip: Sliding, race_radius_m: FloatArray, share: Floats
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
        band = self.bands[..., 0] * self.rolling_speed_m_s()
        way = np.asarray(share)[..., np.newaxis] * smooth_sign(rolling, band[..., np.newaxis])
        known = self.lubrication
        force = way * reduction * force * known.factor("rolling")[:, np.newaxis]
        moment = way * moment * known.factor("hysteresis")[:, np.newaxis]
        return force, moment, [_both(force * rolling), -_both(moment * slip.roll_rad_s)]

    def residuals(self, unknowns: FloatArray, which: IndexArray, share: Floats = 1.0) -> FloatArray:
        """What is left of the balance at some of the points, over the load of a ball.

        Args:
            unknowns: Shape (..., points, 7).
            which: Numbers of these points.
            share: As of `balance`, for these points.
        """
        if len(which) == 0:
            return unknowns
        # in parts whose arrays fit a processor's cache
        nodes = unknowns[..., 0].size * len(self.rule.share)
        if nodes > _CACHED and len(which) > 1:
            half = [len(which) // 2]
            shares = np.broadcast_to(share, unknowns.shape[:-1])
            parts = zip(
                np.split(unknowns, half, axis=-2),
                np.split(which, half),
                np.split(shares, half, axis=-1),
                strict=True,
            )
            return np.concatenate([self.residuals(*part) for part in parts], axis=-2)
        part = self.at(which)
        left = part.balance(unknowns, share).left_over_n
        return left / ball_force_n(self.bearing, part.points)[:, np.newaxis]

    def start(self) -> FloatArray:
        """Unknowns of raceway control without gyroscopic moment."""
        start = raceway_control(self.bearing, self.points, gyroscopic_sign=0.0)
        ball, ring = start.solution.unknowns[:, :2], start.solution.unknowns[:, 2]
        return np.column_stack(
            [ball, start.motion.spin_rad_s, start.motion.orbit_speed_rad_s, ring]
        )

    def rolling_spin_rad_s(self) -> FloatArray:
        """Spin of balls that roll between the rings, shape (points,)."""
        bearing = self.bearing
        spin = self._ring_difference_rad_s() * bearing.pitch_diameter_m
        return np.maximum(spin / (2 * bearing.ball_diameter_m), _SLOWEST_RAD_S)

    def rolling_speed_m_s(self) -> FloatArray:
        """Surface speed of balls that roll between the rings, shape (points,)."""
        return np.asarray(self._ring_difference_rad_s() * self.bearing.pitch_diameter_m / 4)

    def _ring_difference_rad_s(self) -> FloatArray:
        rings = self.points.ring_speed_rad_s
        return np.abs(rings[:, 0] - rings[:, 1])

    def scale(self) -> FloatArray:
        """Scale of each unknown."""
        rings = self.points.ring_speed_rad_s
        spin = self.rolling_spin_rad_s()
        orbit = np.maximum(np.abs(rings).max(axis=1) / 2, _SLOWEST_RAD_S)
        length = np.full(len(rings), self.bearing.groove_offset_m.min())
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

    def held_by_band(self) -> BoolArray:
        """Where the forces balance only between the two sides of a jump, shape (points,).

        The outer contact does not roll there, and its resistance to rolling takes a share of its
        size between -1 and 1: a solution in the sense of Filippov.
        """
        held = (self.problem.bands > 0).any(axis=-1)
        return np.broadcast_to(held, self.solution.converged.shape)

    def outside_law(self) -> BoolArray:
        """Where the cage slips so far that the outer contact hardly rolls: no law was made for it.

        The entrainment speed is then below any that is tested.
        """
        return self.cage_slip() > _HARDLY_ROLLS

    def widest_contact(self) -> FloatArray:
        """Semi-axis across the rolling direction over the balls' radius, the wider of the two."""
        radius = self.problem.bearing.ball_diameter_m / 2
        return np.asarray(self.balance.contacts.semi_axis_y_m.max(axis=-1) / radius)


def _both(values: FloatArray) -> FloatArray:
    """The sum over both contacts."""
    return np.asarray(values[..., 0] + values[..., 1])
