"""Friction equilibrium: motion of balls and cage by the balance of all forces, and its heat.

Beside the loads of `quasistatic`, the three moments on each ball and its force along the orbit
balance. They come from traction in both ellipses, rolling resistance, drag of the oil and the cage.
The results are the rotation of the ball and the tilt of its axis, gyroscopic slip and the speed of
the cage. Each term is a pair of forces on two bodies. Hence the power that the rings supply is the
sum of all friction heat.

The axes x, r, t and the normal n of a contact are those of `quasistatic`.

The cage turns steadily. All balls travel with it, each pushed or held by its pocket.

Decides: the forces on balls and cage, and the cage slip above which no law holds.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.ellipse import (
    QuadratureRule,
    Sliding,
    Traction,
    TractionLaw,
    contact_conditions,
    gauss_rule,
    law_at_points,
    sliding_in_ellipses,
    traction_in_ellipses,
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.growth import operating_growth
from oilfilm.bearing.inputs import InputValues
from oilfilm.bearing.quasistatic import (
    Contacts,
    Motion,
    OperatingPoints,
    ball_force_scale_n,
    centrifugal_force_n,
    normal_contacts,
    raceway_control_equilibrium,
)
from oilfilm.bearing.resistance import (
    Lubrication,
    drag_force_n,
    hysteresis_moment_n_m,
    land_damping_n_m_s,
    momentum_torque_n_m,
    rolling_force_n,
    rolling_force_reduction_factor,
)
from oilfilm.bearing.solver import Solution
from oilfilm.physics.contact import Conditions, Floats

# Numbers of quadrature nodes of the ellipse, across and along the rolling direction.
NODE_COUNTS = (16, 4)
# The same for random draws and for the search of an equilibrium.
COARSE_NODE_COUNTS = (6, 2)
# Largest number of quadrature nodes whose arrays fit the cache of a processor.
_NODES_IN_CACHE = 50_000
# Cage slip above which the outer contact hardly rolls. It is no setting: beyond it motions are so
# close to each other that their number is not known either (`equilibria`).
_LARGEST_CAGE_SLIP_OF_LAW = 0.9
# Smallest scale of speeds, for a bearing at rest.
_SMALLEST_SCALE_RAD_S = 1e-3


# Half-widths of the bands about 0 in which jumps of the balance are smoothed. The columns are:
# rolling speed, relative to that of balls that roll between the rings;
# rotation of a ball, relative to that of balls that roll between the rings;
# entrainment speed, in m/s.
# With narrower bands (0.2 %) curves stay unfinished, with wider ones (1, 2 %) some turn back.
FULL_BANDS = np.array([[0.005, 0.005, 2.0]])
NO_BANDS = np.zeros((1, 3))


def smooth_sign(value: FloatArray, band: FloatArray) -> FloatArray:
    """The sign of a value, smoothed within a band: t (3 - t^2)/2 with t = value/band.

    The smoothed sign and its slope are continuous at the ends of the band.
    """
    is_inside = np.abs(value) < band
    relative_value = np.divide(value, band, out=np.zeros_like(value), where=is_inside)
    return np.where(is_inside, relative_value * (3 - relative_value**2) / 2, np.sign(value))


@dataclass(frozen=True)
class Balance:
    """Forces on a ball and on its share of cage and rings; shapes (...) unless stated otherwise.

    Attributes:
        contacts: Normal contacts.
        motion: Motion of the ball.
        conditions: Conditions of the contacts.
        sliding: Sliding in the ellipses.
        traction: Traction of the film in the ellipses.
        drag_n: Drag of the oil against the orbit, along t.
        heats_w: Heat of each of `HEAT_TERMS`.
        imbalance_n: Sums that vanish in equilibrium, shape (..., 7). They are the forces on the
            ball along x and r; the moments on the ball about x, r and t over its radius, including
            the gyroscopic moment; the moment on the cage over the pitch radius; the force on the
            inner ring along x.
        ring_moment_n_m: Moments on inner and outer ring about the bearing's axis, (..., 2). The
            inner one has the moment of the oil that it accelerates.
    """

    contacts: Contacts
    motion: Motion
    conditions: Conditions
    sliding: Sliding
    traction: Traction
    drag_n: FloatArray
    heats_w: tuple[FloatArray, ...]
    imbalance_n: FloatArray
    ring_moment_n_m: FloatArray


@dataclass(frozen=True)
class FrictionProblem:
    """A bearing at operating points, and the equations of its friction equilibrium.

    Each point has seven unknowns: centre of the ball (x, r) in m, its rotation (x, r, t) in
    rad/s, speed of cage and balls in rad/s, displacement of the inner ring along x in m.

    The balance is not smooth everywhere. Rolling resistance jumps where the speeds of the surfaces
    cancel. The friction of a pocket turns with the axis of the ball's rotation. A law of the
    slide-roll ratio has a pole at entrainment speed 0. A curve of equilibria can only be followed
    where the balance is smooth, so that it is smoothed within bands.

    Attributes:
        bearing: The bearing.
        points: Loads and speeds.
        lubrication: The oil at each point.
        law: The traction law.
        rule: Quadrature rule of the ellipse.
        bands: Half-widths of the bands, with the columns of `FULL_BANDS`: one row, or shape
            (..., points, 3). Outside the bands the balance is exact.
    """

    bearing: Bearing
    points: OperatingPoints
    lubrication: Lubrication
    law: TractionLaw
    rule: QuadratureRule = field(default_factory=lambda: gauss_rule(*NODE_COUNTS))
    bands: FloatArray = field(default_factory=lambda: NO_BANDS)

    def at_points(self, point_index: IndexArray) -> "FrictionProblem":
        """The problem of some of the points."""
        return FrictionProblem(
            bearing=self.bearing,
            points=self.points.at_points(point_index),
            lubrication=self.lubrication.at_points(point_index),
            law=law_at_points(self.law, point_index),
            rule=self.rule,
            bands=self.bands if len(self.bands) == 1 else self.bands[..., point_index, :],
        )

    def balance(self, unknowns: FloatArray, resistance_share: Floats = 1.0) -> Balance:
        """All forces and moments on the balls, shapes (..., points, ...).

        Args:
            unknowns: Shape (..., points, 7).
            resistance_share: Factor on all resistances and on the gyroscopic moment; 1 is the
                bearing. Traction always counts in full. One number, or shape (..., points).
        """
        bearing, lubrication = self.bearing, self.lubrication
        contacts = normal_contacts(bearing, unknowns[..., :2], unknowns[..., 6], self.points.growth)
        motion = Motion(unknowns[..., 5], unknowns[..., 2:5])
        ring_speed_rad_s = self.points.ring_speed_rad_s
        sliding_state = sliding_in_ellipses(
            bearing, contacts, motion, ring_speed_rad_s, self.rule, self.bands[..., 2:]
        )
        inlet_temperature_c = lubrication.inlet_temperature_c[:, np.newaxis]
        conditions = contact_conditions(bearing, contacts, sliding_state, inlet_temperature_c)
        film_traction = traction_in_ellipses(
            contacts, sliding_state, conditions, self.law, self.rule, lubrication.traction_factor
        )
        orbit_radius_m = contacts.orbit_radius_m
        n_r = contacts.normal[..., 1, :]
        race_radius_m = orbit_radius_m[..., np.newaxis] + n_r * (bearing.ball_diameter_m / 2)
        rolling_resistance = self._rolling_resistance(
            contacts, sliding_state, race_radius_m, resistance_share
        )
        orbit_speed_m_s = orbit_radius_m * motion.orbit_speed_rad_s
        drag_n = self._drag_n(orbit_speed_m_s, resistance_share)
        # The rolling force shears the surface of the ball. Its pressure pushes the ball's centre.
        push_n = rolling_resistance.force_n * (
            2 * race_radius_m / orbit_radius_m[..., np.newaxis] - 1
        )
        pocket_force_n = drag_n - _sum_over_contacts(film_traction.force_along_n + push_n)
        pocket_friction = self._pocket_friction(pocket_force_n, motion, resistance_share)
        land_sliding_rad_s = (
            ring_speed_rad_s[:, self._guiding_ring_index()] - motion.orbit_speed_rad_s
        )
        land_moment_n_m = self._land_moment_n_m(land_sliding_rad_s, resistance_share)
        imbalance_n = self._imbalance_n(
            contacts,
            motion,
            film_traction,
            rolling_resistance,
            pocket_friction,
            land_moment_n_m,
            resistance_share,
        )
        ring_moment_n_m = (
            film_traction.race_moment_n_m
            + rolling_resistance.moment_n_m * n_r
            - rolling_resistance.force_n * race_radius_m
        )
        ring_moment_n_m[..., self._guiding_ring_index()] -= land_moment_n_m
        feed_torque_per_ball_n_m = self.feed_torque_n_m() / bearing.ball_count
        ring_moment_n_m[..., 0] -= feed_torque_per_ball_n_m
        feed_heat_w = np.broadcast_to(
            feed_torque_per_ball_n_m * ring_speed_rad_s[:, 0], orbit_speed_m_s.shape
        )
        heats_w = (
            _sum_over_contacts(film_traction.heat_w),
            rolling_resistance.force_heat_w,
            rolling_resistance.moment_heat_w,
            drag_n * orbit_speed_m_s,
            pocket_friction.heat_w,
            land_moment_n_m * land_sliding_rad_s,
            feed_heat_w,
        )
        return Balance(
            contacts=contacts,
            motion=motion,
            conditions=conditions,
            sliding=sliding_state,
            traction=film_traction,
            drag_n=drag_n,
            heats_w=heats_w,
            imbalance_n=imbalance_n,
            ring_moment_n_m=ring_moment_n_m,
        )

    def with_inputs(self, inputs: InputValues) -> "FrictionProblem":
        """The problem with other values of the uncertain inputs: growth, feed oil, starvation.

        The outer ring has the temperature of the oil.

        Args:
            inputs: One value per point. The oil's properties and the factors stay.
        """
        growth = operating_growth(
            self.bearing,
            self.points.ring_speed_rad_s[:, 0],
            self.lubrication.inlet_temperature_c,
            inputs,
        )
        return replace(
            self,
            points=replace(self.points, growth=growth),
            lubrication=self.lubrication.with_inputs(inputs),
        )

    def feed_torque_n_m(self) -> FloatArray:
        """Torque of the oil that the inner ring accelerates, shape (points,).

        It is 0 where the flow is not known.
        """
        carried_flow_kg_s = np.nan_to_num(self.lubrication.carried_flow_kg_s)
        groove_bottom_radius_m = self.bearing.groove_bottom_radius_m[0]
        return momentum_torque_n_m(
            carried_flow_kg_s, self.points.ring_speed_rad_s[:, 0], groove_bottom_radius_m
        )

    def replenishment_factor(self) -> FloatArray:
        """Reduction of rolling resistance and film by starvation, shape (points,)."""
        return self.lubrication.replenishment_factor(
            self.bearing, self._ring_speed_difference_rad_s()
        )

    def _drag_n(self, orbit_speed_m_s: FloatArray, resistance_share: Floats) -> FloatArray:
        """Drag of the oil on a ball against its orbit, shape (..., points)."""
        drag_n = drag_force_n(
            self.bearing.ball_diameter_m,
            self.lubrication.mist_density_kg_m3,
            self.lubrication.drag_coefficient,
            orbit_speed_m_s,
        )
        return drag_n * resistance_share * self.lubrication.factor("drag")

    def _pocket_friction(
        self, pocket_force_n: FloatArray, motion: Motion, resistance_share: Floats
    ) -> "_PocketFriction":
        """Coulomb friction between pocket and ball, which acts against the ball's rotation.

        Args:
            pocket_force_n: Force of the pocket on the ball along t, shape (..., points).
            motion: Motion of the ball.
            resistance_share: As for `balance`.
        """
        ball_radius_m = self.bearing.ball_diameter_m / 2
        friction_factor = resistance_share * self.lubrication.factor("pocket")
        friction_n = (
            friction_factor * self.bearing.cage.pocket_friction_coefficient * pocket_force_n
        )
        rotation_x = motion.rotation_rad_s[..., 0]
        rotation_r = motion.rotation_rad_s[..., 1]
        rotation_rad_s = np.sqrt(rotation_x**2 + rotation_r**2)
        smoothed_sign = smooth_sign(
            rotation_rad_s, self.bands[..., 1] * self.rolling_rotation_rad_s()
        )
        # component of the axis over that of the rotation
        axis_per_rotation = smoothed_sign / np.maximum(rotation_rad_s, np.finfo(float).tiny)
        axis_x = rotation_x * axis_per_rotation
        axis_r = rotation_r * axis_per_rotation
        moment_n_m = np.abs(friction_n) * ball_radius_m
        return _PocketFriction(
            pocket_force_n=pocket_force_n,
            # the friction force is normal to the axis of the rotation
            force_x_n=friction_n * axis_r,
            force_r_n=-friction_n * axis_x,
            moment_x_n_m=moment_n_m * axis_x,
            moment_r_n_m=moment_n_m * axis_r,
            heat_w=moment_n_m * rotation_rad_s,
        )

    def _guiding_ring_index(self) -> int:
        """Axis index of the ring that guides the cage: 0 for the inner ring, 1 for the outer."""
        return 1 if self.bearing.cage.guided_by_outer_ring else 0

    def _land_moment_n_m(
        self, land_sliding_rad_s: FloatArray, resistance_share: Floats
    ) -> FloatArray:
        """Moment of the guiding ring on a ball's share of the cage, shape (..., points).

        Args:
            land_sliding_rad_s: Speed of the guiding ring less that of the cage; below 0 where
                the cage is faster.
            resistance_share: As for `balance`.
        """
        factor = resistance_share * self.lubrication.factor("land") / self.bearing.ball_count
        return factor * land_damping_n_m_s(self.bearing, self.lubrication) * land_sliding_rad_s

    def _imbalance_n(
        self,
        contacts: Contacts,
        motion: Motion,
        film_traction: Traction,
        rolling_resistance: "_RollingResistance",
        pocket_friction: "_PocketFriction",
        land_moment_n_m: FloatArray,
        resistance_share: Floats,
    ) -> FloatArray:
        """Sums of forces and moments that vanish in equilibrium, as `Balance.imbalance_n`."""
        bearing = self.bearing
        ball_radius_m = bearing.ball_diameter_m / 2
        n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
        contact_force_x_n = -(film_traction.force_across_n * n_r + contacts.load_n * n_x)
        contact_force_r_n = film_traction.force_across_n * n_x - contacts.load_n * n_r
        moment_about_normal_n_m = film_traction.moment_about_normal_n_m
        moment_about_across_n_m = (
            film_traction.moment_about_across_n_m
            + ball_radius_m * rolling_resistance.force_n
            + rolling_resistance.moment_n_m
        )
        contact_moment_x_n_m = moment_about_normal_n_m * n_x - moment_about_across_n_m * n_r
        contact_moment_r_n_m = moment_about_normal_n_m * n_r + moment_about_across_n_m * n_x
        # gyroscopic moment over the rotation
        gyroscopic_n_m_s = resistance_share * bearing.ball_inertia_kg_m2 * motion.orbit_speed_rad_s
        gyroscopic_moment_r_n_m = gyroscopic_n_m_s * motion.rotation_rad_s[..., 2]
        gyroscopic_moment_t_n_m = gyroscopic_n_m_s * motion.rotation_rad_s[..., 1]

        force_x_n = _sum_over_contacts(contact_force_x_n) + pocket_friction.force_x_n
        outward_force_n = pocket_friction.force_r_n + centrifugal_force_n(bearing, contacts, motion)
        force_r_n = _sum_over_contacts(contact_force_r_n) + outward_force_n
        moment_x_n_m = _sum_over_contacts(contact_moment_x_n_m) - pocket_friction.moment_x_n_m
        moment_r_n_m = (
            _sum_over_contacts(contact_moment_r_n_m)
            - pocket_friction.moment_r_n_m
            + gyroscopic_moment_r_n_m
        )
        moment_t_n_m = (
            _sum_over_contacts(film_traction.moment_about_tangent_n_m) - gyroscopic_moment_t_n_m
        )
        pocket_force_n = pocket_friction.pocket_force_n
        cage_moment_n_m = (
            land_moment_n_m
            - pocket_force_n * contacts.orbit_radius_m
            - np.sign(pocket_force_n) * ball_radius_m * pocket_friction.force_r_n
        )
        ring_force_x_n = self.points.axial_load_n / bearing.ball_count - contact_force_x_n[..., 0]
        imbalance_n = (
            force_x_n,
            force_r_n,
            moment_x_n_m / ball_radius_m,
            moment_r_n_m / ball_radius_m,
            moment_t_n_m / ball_radius_m,
            cage_moment_n_m / (bearing.pitch_diameter_m / 2),
            ring_force_x_n,
        )
        return np.stack(imbalance_n, axis=-1)

    def _rolling_resistance(
        self,
        contacts: Contacts,
        sliding_state: Sliding,
        race_radius_m: FloatArray,
        resistance_share: Floats,
    ) -> "_RollingResistance":
        """Rolling resistance in each contact by the oil and by hysteresis.

        The force FR of the oil acts on both surfaces, against their motion. Pressure on the two
        surfaces balances the film. This pressure has no moment about the centre of the ball or
        about the bearing's axis. It pushes the ball along its orbit, with the force
        2 FR (race radius)/(orbit radius).
        """
        bearing, oil = self.bearing, self.lubrication.oil_in_contacts
        load_n = contacts.load_n
        speed_sum_m_s = sliding_state.relative_race_speed_rad_s * race_radius_m
        speed_sum_m_s -= sliding_state.roll_rad_s * (bearing.ball_diameter_m / 2)
        mean_speed_m_s = np.abs(speed_sum_m_s / 2)
        radius_x_m = bearing.radius_x_m(np.abs(contacts.normal[..., 1, :]))
        radius_y_m = bearing.radius_y_m
        reduced_modulus_pa = bearing.reduced_modulus_pa
        relative_pressure = contacts.max_hertz_pressure_pa / reduced_modulus_pa
        thermal_reduction = rolling_force_reduction_factor(
            relative_pressure, oil.thermal_loading(mean_speed_m_s)
        )
        viscosity_pa_s = oil.dynamic_viscosity_pa_s
        force_n = rolling_force_n(
            load_n, mean_speed_m_s, viscosity_pa_s, radius_x_m, radius_y_m, reduced_modulus_pa
        )
        moment_n_m = hysteresis_moment_n_m(load_n, bearing.ball_diameter_m, radius_x_m, radius_y_m)
        band_m_s = self.bands[..., 0] * self.rolling_speed_m_s()
        sign_of_rolling = smooth_sign(speed_sum_m_s, band_m_s[..., np.newaxis])
        signed_share = np.asarray(resistance_share)[..., np.newaxis] * sign_of_rolling
        force_factor = self.lubrication.factor("rolling") * self.replenishment_factor()
        moment_factor = self.lubrication.factor("hysteresis")[:, np.newaxis]
        force_n = signed_share * thermal_reduction * force_n * force_factor[:, np.newaxis]
        moment_n_m = signed_share * moment_n_m * moment_factor
        return _RollingResistance(
            force_n=force_n,
            moment_n_m=moment_n_m,
            force_heat_w=_sum_over_contacts(force_n * speed_sum_m_s),
            moment_heat_w=-_sum_over_contacts(moment_n_m * sliding_state.relative_roll_rad_s),
        )

    def residuals(
        self, unknowns: FloatArray, point_index: IndexArray, resistance_share: Floats = 1.0
    ) -> FloatArray:
        """Imbalance at some of the points, over the load of a ball; shape (..., points, 7).

        Args:
            unknowns: Shape (..., points, 7).
            point_index: Indices of these points.
            resistance_share: As for `balance`, for these points.
        """
        if len(point_index) == 0:
            return unknowns
        node_count = unknowns[..., 0].size * len(self.rule.load_share)
        if node_count > _NODES_IN_CACHE and len(point_index) > 1:
            # halves, until the arrays fit the cache of a processor
            half_count = len(point_index) // 2
            shares = np.broadcast_to(resistance_share, unknowns.shape[:-1])
            residuals_of_first_half = self.residuals(
                unknowns[..., :half_count, :], point_index[:half_count], shares[..., :half_count]
            )
            residuals_of_second_half = self.residuals(
                unknowns[..., half_count:, :], point_index[half_count:], shares[..., half_count:]
            )
            return np.concatenate([residuals_of_first_half, residuals_of_second_half], axis=-2)
        problem = self.at_points(point_index)
        imbalance = problem.balance(unknowns, resistance_share).imbalance_n
        return imbalance / ball_force_scale_n(self.bearing, problem.points)[:, np.newaxis]

    def start_unknowns(self) -> FloatArray:
        """Unknowns of balls that roll (raceway control, no gyroscopic moment), shape (points, 7).

        A search for the equilibrium starts there.
        """
        rolling_equilibrium = raceway_control_equilibrium(
            self.bearing, self.points, gyroscopic_factor=0.0
        )
        ball_position_m = rolling_equilibrium.solution.unknowns[:, :2]
        ring_displacement_m = rolling_equilibrium.solution.unknowns[:, 2]
        motion = rolling_equilibrium.motion
        return np.column_stack(
            [ball_position_m, motion.rotation_rad_s, motion.orbit_speed_rad_s, ring_displacement_m]
        )

    def rolling_rotation_rad_s(self) -> FloatArray:
        """Rotation of balls that roll between the rings, shape (points,)."""
        bearing = self.bearing
        speed_difference_m_s = self._ring_speed_difference_rad_s() * bearing.pitch_diameter_m
        return np.maximum(
            speed_difference_m_s / (2 * bearing.ball_diameter_m), _SMALLEST_SCALE_RAD_S
        )

    def rolling_speed_m_s(self) -> FloatArray:
        """Surface speed of balls that roll between the rings, shape (points,)."""
        return np.asarray(self._ring_speed_difference_rad_s() * self.bearing.pitch_diameter_m / 4)

    def _ring_speed_difference_rad_s(self) -> FloatArray:
        """Difference of the speeds of both rings, without its sign."""
        ring_speed_rad_s = self.points.ring_speed_rad_s
        return np.abs(ring_speed_rad_s[:, 0] - ring_speed_rad_s[:, 1])

    def scale(self) -> FloatArray:
        """Scale of each unknown, shape (points, 7)."""
        ring_speed_rad_s = self.points.ring_speed_rad_s
        rotation_scale_rad_s = self.rolling_rotation_rad_s()
        orbit_scale_rad_s = np.maximum(
            np.abs(ring_speed_rad_s).max(axis=1) / 2, _SMALLEST_SCALE_RAD_S
        )
        length_scale_m = np.full(len(ring_speed_rad_s), self.bearing.groove_offset_m.min())
        return np.column_stack(
            [
                length_scale_m,
                length_scale_m,
                rotation_scale_rad_s,
                rotation_scale_rad_s,
                rotation_scale_rad_s,
                orbit_scale_rad_s,
                length_scale_m,
            ]
        )


@dataclass(frozen=True)
class FrictionEquilibrium:
    """Steady motion of a bearing in which all forces balance.

    Attributes:
        problem: The solved problem.
        balance: Forces on a ball at each point.
        solution: The solver's result. Residuals are relative to the load of a ball, moments to
            that load times the ball's radius.
    """

    problem: FrictionProblem
    balance: Balance
    solution: Solution

    def torque_n_m(self) -> FloatArray:
        """Moment that turns the inner ring, shape (points,)."""
        return np.asarray(-self.problem.bearing.ball_count * self.balance.ring_moment_n_m[..., 0])

    def cage_slip(self) -> FloatArray:
        """Slip of the cage relative to balls that roll on both races, shape (points,).

        Rolling means no sliding in the middle of either contact. The balls' axis is the actual one.
        """
        contacts, motion = self.balance.contacts, self.balance.motion
        ring_speed_rad_s = self.problem.points.ring_speed_rad_s
        ball_radius_m = self.problem.bearing.ball_diameter_m / 2
        roll_rad_s = np.abs(self.balance.sliding.roll_rad_s)
        roll_over_larger = roll_rad_s / np.maximum(roll_rad_s.max(axis=-1, keepdims=True), 1e-300)
        orbit_radius_m = contacts.orbit_radius_m[..., np.newaxis]
        race_radius_m = orbit_radius_m + contacts.normal[..., 1, :] * ball_radius_m
        # without sliding, (ring speed - orbit speed) weight is equal and opposite at both races
        weight = race_radius_m / np.maximum(roll_over_larger, 1e-3)
        rolling_orbit_rad_s = (ring_speed_rad_s * weight).sum(axis=-1) / weight.sum(axis=-1)
        lag_rad_s = rolling_orbit_rad_s - motion.orbit_speed_rad_s
        return np.divide(
            lag_rad_s,
            rolling_orbit_rad_s,
            out=np.zeros_like(lag_rad_s),
            where=rolling_orbit_rad_s != 0,
        )

    def held_by_band(self) -> BoolArray:
        """Whether the forces balance only between the two sides of a jump, shape (points,).

        The outer contact does not roll there. Its rolling resistance then has a value between the
        two sides of the jump (a solution in the sense of Filippov).
        """
        has_band = (self.problem.bands > 0).any(axis=-1)
        return np.broadcast_to(has_band, self.solution.converged.shape)

    def outside_law(self) -> BoolArray:
        """Whether the cage slips so much that the outer contact hardly rolls, shape (points,).

        No law was made for such contacts: the entrainment speed is below any tested speed.
        """
        return self.cage_slip() > _LARGEST_CAGE_SLIP_OF_LAW

    def widest_contact(self) -> FloatArray:
        """Semi-axis of the wider contact across the rolling direction, over the balls' radius."""
        ball_radius_m = self.problem.bearing.ball_diameter_m / 2
        return np.asarray(self.balance.contacts.semi_axis_y_m.max(axis=-1) / ball_radius_m)


@dataclass(frozen=True)
class _RollingResistance:
    """Rolling resistance by the oil and by hysteresis.

    Attributes:
        force_n: Force of the oil on either surface, shape (..., points, 2 contacts).
        moment_n_m: Moment of hysteresis on the ball, of the same shape.
        force_heat_w: Heat of the force in both contacts, shape (..., points).
        moment_heat_w: Heat of the moment in both contacts.
    """

    force_n: FloatArray
    moment_n_m: FloatArray
    force_heat_w: FloatArray
    moment_heat_w: FloatArray


@dataclass(frozen=True)
class _PocketFriction:
    """Force of the pocket on a ball and its friction, shapes (..., points).

    Attributes:
        pocket_force_n: Force of the pocket on the ball along t.
        force_x_n: Friction force on the ball along x.
        force_r_n: Friction force on the ball along r.
        moment_x_n_m: Friction moment about x, against the rotation of the ball.
        moment_r_n_m: Friction moment about r, against the rotation of the ball.
        heat_w: Friction heat.
    """

    pocket_force_n: FloatArray
    force_x_n: FloatArray
    force_r_n: FloatArray
    moment_x_n_m: FloatArray
    moment_r_n_m: FloatArray
    heat_w: FloatArray


def _sum_over_contacts(value_of_contacts: FloatArray) -> FloatArray:
    """Sum over both contacts."""
    return np.asarray(value_of_contacts[..., 0] + value_of_contacts[..., 1])
