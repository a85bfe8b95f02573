"""Forces and moments that resist balls and cage, beside the traction of the film.

Each formula has one function; `friction` combines them. Arguments are in SI units and broadcast.

Decides: drag, rolling resistance, pockets and lands of a bearing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from oilfilm.base.units import MM_PER_M, RAD_S_PER_RPM, FloatArray, IndexArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.inputs import InputValues
from oilfilm.physics.contact import Floats
from oilfilm.physics.film import InletOil, thermal_reduction_factor
from oilfilm.physics.oils import Oil

# Names of the resistances beside traction.
_RESISTANCE_NAMES = ("rolling", "hysteresis", "drag", "pocket", "land")
# Names of the forces that have a factor, in the order of the columns of `Lubrication.factors`.
FACTOR_NAMES = ("traction", *_RESISTANCE_NAMES)
# Names of the heats that the power of the rings becomes: friction, and the oil that the inner ring
# accelerates.
HEAT_TERMS = (*FACTOR_NAMES, "momentum")
# K_Z of `replenishment_factor` for single-row angular-contact ball bearings.
_KZ_ANGULAR_CONTACT = 4.4
_CST_PER_M2_S = 1e6


@dataclass(frozen=True)
class Lubrication:
    """The oil of a bearing at its inlet, and factors on the forces; one value per point.

    Attributes:
        inlet_temperature_c: Inlet temperature, in degC.
        inlet_oil: Properties of the oil at the inlet, which determine the film.
        oil_density_kg_m3: Density of the oil, in kg/m3.
        oil_volume_fraction: Share of oil in the volume through which the balls travel.
        drag_coefficient: c_D of a ball in the row, for its frontal area.
        carried_flow_m3_s: Flow of oil that leaves the inner ring with the ring's speed, in m3/s;
            NaN where the flow is not known.
        replenishment_constant: K_rs of `replenishment_factor`; 0 floods the contacts.
        ellipse_factor: Traction in the bearing's ellipse over that of the law.
        factors: Factor on each of `FACTOR_NAMES`, shape (points, factors), by which an uncertain
            resistance is varied; 1 otherwise.
    """

    inlet_temperature_c: FloatArray
    inlet_oil: InletOil
    oil_density_kg_m3: FloatArray
    oil_volume_fraction: FloatArray
    drag_coefficient: FloatArray
    carried_flow_m3_s: FloatArray
    replenishment_constant: FloatArray
    ellipse_factor: FloatArray
    factors: FloatArray

    @classmethod
    def flooded(
        cls,
        oil: Oil,
        inlet_temperature_c: FloatArray,
        drag_coefficient: float,
        oil_volume_fraction: float,
    ) -> "Lubrication":
        """Lubrication by one oil, with flooded contacts, in which the feed is left out.

        Args:
            oil: The oil.
            inlet_temperature_c: Inlet temperature of each point, shape (points,).
            drag_coefficient: c_D of a ball in the row.
            oil_volume_fraction: Share of oil in the volume between the rings.
        """
        point_count = len(inlet_temperature_c)
        return cls(
            inlet_temperature_c=inlet_temperature_c,
            inlet_oil=InletOil.from_oil(oil, inlet_temperature_c),
            oil_density_kg_m3=oil.density_kg_m3(inlet_temperature_c),
            oil_volume_fraction=np.full(point_count, oil_volume_fraction),
            drag_coefficient=np.full(point_count, drag_coefficient),
            carried_flow_m3_s=np.zeros(point_count),
            replenishment_constant=np.zeros(point_count),
            ellipse_factor=np.ones(point_count),
            factors=np.ones((point_count, len(FACTOR_NAMES))),
        )

    def with_inputs(self, inputs: InputValues) -> "Lubrication":
        """The lubrication with other values of the uncertain inputs."""
        return replace(
            self,
            oil_volume_fraction=inputs.oil_volume_fraction,
            carried_flow_m3_s=inputs.feed_flow_m3_s * inputs.momentum_share,
            replenishment_constant=inputs.replenishment_constant,
            ellipse_factor=inputs.ellipse_factor,
        )

    @classmethod
    def joined(cls, groups: Sequence["Lubrication"]) -> "Lubrication":
        """The points of several groups, one group after the other."""
        arrays = {
            name: np.concatenate([getattr(group, name) for group in groups])
            for name in _ARRAY_ATTRIBUTES
        }
        return cls(inlet_oil=InletOil.joined([group.inlet_oil for group in groups]), **arrays)

    def at_points(self, point_index: IndexArray) -> "Lubrication":
        """The lubrication of some of the points, by their indices."""
        arrays = {name: getattr(self, name)[point_index] for name in _ARRAY_ATTRIBUTES}
        return Lubrication(inlet_oil=self.inlet_oil[point_index], **arrays)

    def factor(self, name: str) -> FloatArray:
        """The factor on one of `FACTOR_NAMES`, shape (points,)."""
        return self.factors[:, FACTOR_NAMES.index(name)]

    @property
    def traction_factor(self) -> FloatArray:
        """The factor on the law's traction, shape (points,)."""
        return self.factor("traction") * self.ellipse_factor

    def with_traction_factor(self, traction_factor: FloatArray) -> "Lubrication":
        """The lubrication with a factor on all traction, shape (points,)."""
        factors = self.factors.copy()
        factors[:, FACTOR_NAMES.index("traction")] = traction_factor
        return replace(self, factors=factors)

    @property
    def oil_in_contacts(self) -> InletOil:
        """The oil of each point, shape (points, 1): it broadcasts over both contacts of a ball."""
        return self.inlet_oil[:, np.newaxis]

    @property
    def mist_density_kg_m3(self) -> FloatArray:
        """Mass of oil per volume through which the balls travel, shape (points,)."""
        return self.oil_volume_fraction * self.oil_density_kg_m3

    @property
    def carried_flow_kg_s(self) -> FloatArray:
        """Mass flow of the oil that leaves the inner ring with the ring's speed, (points,)."""
        return self.carried_flow_m3_s * self.oil_density_kg_m3

    def replenishment_factor(self, bearing: Bearing, speed_rad_s: FloatArray) -> FloatArray:
        """Starvation of rolling resistance and film by `replenishment_factor`, shape (points,).

        Args:
            bearing: The bearing.
            speed_rad_s: Speed of one ring relative to the other.
        """
        bore_m, outside_diameter_m = bearing.bore_and_outside_diameter_m
        kinematic_viscosity_m2_s = self.inlet_oil.dynamic_viscosity_pa_s / self.oil_density_kg_m3
        return replenishment_factor(
            self.replenishment_constant,
            kinematic_viscosity_m2_s,
            speed_rad_s,
            bore_m,
            outside_diameter_m,
        )


# The attributes that are arrays of points.
_ARRAY_ATTRIBUTES = tuple(field.name for field in fields(Lubrication) if field.name != "inlet_oil")


def rolling_force_n(
    load_n: Floats,
    entrainment_speed_m_s: Floats,
    dynamic_viscosity_pa_s: Floats,
    radius_x_m: Floats,
    radius_y_m: Floats,
    reduced_modulus_pa: Floats,
) -> FloatArray:
    """Rolling resistance of the oil in the inlet of a contact, which acts on both surfaces.

        FR = (F_IVR - F_EHL)/(1 + M/6.6) + F_EHL
        F_IVR = 2.9766 E* Rx^2 k^0.3316 W^(1/3) U^(2/3)
        F_EHL = 7.5826 E* Rx^2 k^0.4055 W^(1/3) U^(3/4),   M = 0.5549 k^-0.6029 W U^-0.75

    with k = Ry/Rx, U = eta0 v/(E* Rx), W = Q/(E* Rx^2), E* = E'/2. F_IVR holds for a rigid contact
    with an isoviscous film, F_EHL for an elastohydrodynamic one.

    Args:
        load_n: Normal load Q, in N; 0 or more.
        entrainment_speed_m_s: Mean surface speed v, in m/s; 0 or more.
        dynamic_viscosity_pa_s: eta0 at the inlet, in Pa s.
        radius_x_m: Reduced radius Rx in the rolling direction, in m.
        radius_y_m: Reduced radius Ry across it, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        FR, in N.

    Validity: fully flooded, isothermal inlet; at high speed multiply by
        `rolling_force_reduction_factor`.

    Reference: N. Biboulet and L. Houpert, Proc. Inst. Mech. Eng. J 224 (2010) 777, part 2.

    Examples:
        As the load vanishes the isoviscous, rigid force is left and goes with speed^(2/3):

        >>> slow, fast = rolling_force_n(1e-6, np.array([1.0, 8.0]), 0.01, 0.01, 0.1, 2.2e11)
        >>> print(f"{fast / slow:.3f}")
        4.000
    """
    modulus = reduced_modulus_pa / 2
    k = radius_y_m / radius_x_m
    u = dynamic_viscosity_pa_s * entrainment_speed_m_s / (modulus * radius_x_m)
    w = load_n / (modulus * radius_x_m**2)
    common_factor = modulus * radius_x_m**2 * np.cbrt(w)
    rigid_force_n = 2.9766 * common_factor * k**0.3316 * u ** (2 / 3)
    elastic_force_n = 7.5826 * common_factor * k**0.4055 * u**0.75
    # 1/(1 + M/6.6), numerator and denominator times U^0.75, because M is infinite at rest
    numerator = u**0.75
    denominator = np.asarray(numerator + 0.5549 * k**-0.6029 * w / 6.6)
    # nothing resists where there is neither load nor speed
    weight_of_rigid = np.divide(
        numerator, denominator, out=np.zeros_like(denominator), where=denominator > 0
    )
    return np.asarray((rigid_force_n - elastic_force_n) * weight_of_rigid + elastic_force_n)


def hysteresis_moment_n_m(
    load_n: Floats, ball_diameter_m: float, radius_x_m: Floats, radius_y_m: Floats
) -> FloatArray:
    """Moment of elastic hysteresis that resists a rolling ball.

        M = 7.48e-7 (D/2)^0.33 Q^1.33 [1 - 3.519e-3 (k - 1)^0.8063],   k = Ry/Rx

    Args:
        load_n: Normal load Q, in N.
        ball_diameter_m: Ball diameter D, in m.
        radius_x_m: Reduced radius Rx in the rolling direction, in m.
        radius_y_m: Reduced radius Ry across it, in m.

    Returns:
        M, in N m.

    Validity: steel on steel. The shape factor is 1 where k is below 1.

    Reference: elastic rolling resistance as in L. Houpert's ball-bearing torque.

    Examples:
        A ball of 2 m diameter on a flat under 1 N has the bare constant:

        >>> print(f"{hysteresis_moment_n_m(1.0, 2.0, 1.0, 1.0):.3g} N m")
        7.48e-07 N m
    """
    k = radius_y_m / radius_x_m
    shape_factor = 1 - 3.519e-3 * np.maximum(k - 1, 0) ** 0.8063
    return np.asarray(7.48e-7 * (ball_diameter_m / 2) ** 0.33 * load_n**1.33 * shape_factor)


def rolling_force_reduction_factor(
    relative_pressure: FloatArray, thermal_loading: FloatArray
) -> FloatArray:
    """Thermal reduction of the rolling force: phi_T of the film without slip.

    Gupta's phi_T was fitted to the film. This project assumes that it also holds for the rolling
    force, which depends on the same warm inlet. It is 0 where the fit would be negative.

    The slip is left out, because the pressure flow in the inlet causes the force. Published models
    of rolling resistance reduce it by the rolling speed alone (the inlet shear heating factor of
    SKF's catalogue). The film thickness does depend on the slip of its contact.

    Args:
        relative_pressure: p0/E' at the inner and the outer race, shape (..., points, 2).
        thermal_loading: L with the mean surface speed, of the same shape.
    """
    no_slip = 0.0
    return np.maximum(thermal_reduction_factor(relative_pressure, no_slip, thermal_loading), 0.0)


def drag_force_n(
    ball_diameter_m: float, density_kg_m3: Floats, drag_coefficient: Floats, ball_speed_m_s: Floats
) -> FloatArray:
    """Drag of the mist of oil and air on a ball, against its speed.

        F = 1/2 rho c_D (pi D^2/4) v |v|

    Args:
        ball_diameter_m: Ball diameter D, in m.
        density_kg_m3: Mist density rho, in kg/m3: oil density times oil share of the volume.
        drag_coefficient: c_D of a ball in its row.
        ball_speed_m_s: Speed v of the ball centre, in m/s.

    Returns:
        F, in N, with the sign of v.

    Reference: sphere drag with an effective density, as in bearing-dynamics codes (ADORE).

    Examples:
        A frontal area of 1 m2 in water, c_D = 1, 1 m/s, by hand rho/2:

        >>> print(f"{drag_force_n(np.sqrt(4 / np.pi), 1000.0, 1.0, 1.0):.1f} N")
        500.0 N
    """
    frontal_area_m2 = np.pi * ball_diameter_m**2 / 4
    return np.asarray(
        density_kg_m3
        * drag_coefficient
        * frontal_area_m2
        / 2
        * np.abs(ball_speed_m_s)
        * ball_speed_m_s
    )


def momentum_torque_n_m(
    mass_flow_kg_s: Floats, speed_rad_s: Floats, radius_m: Floats
) -> FloatArray:
    """Torque that gives oil the speed of a ring.

        M = m' omega r^2

    The oil comes without swirl and leaves the ring at radius r with its speed. Times omega, this is
    the power: half of it is the kinetic energy of the oil, the other half heats it.

    For the shaft this is exact if all of the flow leaves there. A housing senses less where oil
    leaves it with swirl, so that the torque of the whole bearing is an upper bound there.

    Args:
        mass_flow_kg_s: Mass flow m'.
        speed_rad_s: Speed omega of the ring.
        radius_m: Radius r.

    Reference: balance of angular momentum of a steady flow.

    Examples:
        8 L/min of 918 kg/m3 from a ring of 72.6 mm at 12 000 rpm:

        >>> torque = momentum_torque_n_m(918 * 8e-3 / 60, 12000 * np.pi / 30, 72.6e-3)
        >>> print(f"{torque:.3f} N m")
        0.811 N m
    """
    return np.asarray(np.multiply(mass_flow_kg_s, speed_rad_s) * np.square(radius_m))


def replenishment_factor(
    constant_krs: Floats,
    kinematic_viscosity_m2_s: Floats,
    speed_rad_s: Floats,
    bore_m: float,
    outside_diameter_m: float,
) -> FloatArray:
    """Reduction of the rolling resistance where overrolled oil does not flow back in time.

        phi_rs = exp(-K_rs nu n (d + D) sqrt(K_Z/(2 (D - d))))

    with nu in cSt, n in 1/min, bore d and outside diameter D in mm. K_rs is 3e-8 for oil bath and
    jet, 6e-8 for grease and oil-air; K_Z is 4.4 for single-row angular-contact ball bearings.

    SKF's formula is one of torque. This project assumes that it holds for the thickness of the film
    too, as both come from the same inlet.

    Args:
        constant_krs: K_rs.
        kinematic_viscosity_m2_s: Kinematic viscosity nu.
        speed_rad_s: Speed n of one ring relative to the other.
        bore_m: Bore d.
        outside_diameter_m: Outside diameter D.

    Validity: steady speed, catalogue bearings up to their limiting speed.

    Reference: SKF, Rolling bearings, general catalogue, 2018: kinematic replenishment/starvation
        reduction factor; formula and constants by programs that quote it (docs/physics.md, Feed
        oil), not read in print.

    Examples:
        Bore 40, outside 80 mm, 20 cSt at 10 000 rpm: exp(-3e-8 2e5 120 sqrt(0.055)) by hand:

        >>> factor = replenishment_factor(3e-8, 20e-6, 10000 * np.pi / 30, 0.040, 0.080)
        >>> print(f"{factor:.4f}")
        0.8446
    """
    bore_mm, outside_diameter_mm = bore_m * MM_PER_M, outside_diameter_m * MM_PER_M
    viscosity_cst = np.multiply(kinematic_viscosity_m2_s, _CST_PER_M2_S)
    speed_rpm = np.abs(speed_rad_s) / RAD_S_PER_RPM
    geometry_factor_mm = (bore_mm + outside_diameter_mm) * np.sqrt(
        _KZ_ANGULAR_CONTACT / (2 * (outside_diameter_mm - bore_mm))
    )
    return np.asarray(
        np.exp(-np.multiply(constant_krs, viscosity_cst) * speed_rpm * geometry_factor_mm)
    )


def land_damping_n_m_s(bearing: Bearing, lubrication: Lubrication) -> FloatArray:
    """Moment of the oil between cage and land over their relative speed, in a concentric gap.

        M/Omega = 2 pi eta R^3 L/c

    with R the land's radius, L its width and c the radial clearance.

    Args:
        bearing: The bearing.
        lubrication: The oil at each point. The gap is assumed to be full.

    Returns:
        Shape (points,), in N m s.

    Reference: N. P. Petroff, friction of journal bearings, 1883.
    """
    cage = bearing.cage
    geometry_m3 = cage.land_width_m * (cage.land_diameter_m / 2) ** 3 / cage.land_clearance_m
    return np.asarray(2 * np.pi * lubrication.inlet_oil.dynamic_viscosity_pa_s * geometry_m3)
