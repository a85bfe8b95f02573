"""A ball bearing: sizes, materials, cage, and the Hertz contacts of its races.

Two contacts per ball, always in the order inner race, outer race. Lengths are in m.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from oilfilm.physics.contact import elliptical_contact
from oilfilm.units import FloatArray

# Hertz's solution is interpolated in the cosine of the contact angle by polynomials of this
# degree: each power brings a factor of at least 2 dm/D, so that rounding is all that is left.
_DEGREE = 12


@dataclass(frozen=True)
class OilSupply:
    """The oil that cools a bearing.

    Attributes:
        flow_m3_s: Volume flow at the inlet temperature, in m3/s.
        heat_share: Share of the friction heat that the oil carries away; shaft and housing take
            the rest.
        outlet_weight: Where the oil of the contacts lies between inlet (0) and outlet (1)
            temperature.
    """

    flow_m3_s: float
    heat_share: float
    outlet_weight: float


@dataclass(frozen=True)
class Cage:
    """A cage guided by the land of one ring.

    Attributes:
        guided_by_outer: True where the outer ring's land guides it, else the inner ring's.
        land_diameter_m: Diameter of the guiding surface.
        land_width_m: Width of both lands together.
        land_clearance_m: Radial clearance between cage and land.
        pocket_friction_coefficient: Coulomb coefficient between ball and pocket.
    """

    guided_by_outer: bool
    land_diameter_m: float
    land_width_m: float
    land_clearance_m: float
    pocket_friction_coefficient: float


@dataclass(frozen=True)
class Bearing:
    """A single-row ball bearing.

    Attributes:
        name: As in config/bearings.
        ball_diameter_m: D.
        pitch_diameter_m: d_m, of the ball centres, unloaded.
        ball_count: Z.
        contact_angle_rad: alpha_0, unloaded.
        groove_curvature: Groove radius over ball diameter, inner and outer.
        reduced_modulus_pa: E' = 2 E* of ball against ring.
        ball_density_kg_m3: Density of the balls.
        roughness_rq_m: Combined Rq of ball and race.
        cage: The cage.
    """

    name: str
    ball_diameter_m: float
    pitch_diameter_m: float
    ball_count: int
    contact_angle_rad: float
    groove_curvature: tuple[float, float]
    reduced_modulus_pa: float
    ball_density_kg_m3: float
    roughness_rq_m: float
    cage: Cage

    @cached_property
    def ball_mass_kg(self) -> float:
        """Mass of a ball."""
        return self.ball_density_kg_m3 * np.pi * self.ball_diameter_m**3 / 6

    @cached_property
    def ball_inertia_kg_m2(self) -> float:
        """Moment of inertia of a ball, m D^2/10."""
        return self.ball_mass_kg * self.ball_diameter_m**2 / 10

    @cached_property
    def groove_offset_m(self) -> FloatArray:
        """Distance from groove centre to ball centre of an unloaded contact, inner and outer."""
        return (np.array(self.groove_curvature) - 0.5) * self.ball_diameter_m

    @cached_property
    def groove_centre_distance_m(self) -> float:
        """A, between inner and outer groove centre, unloaded."""
        return float(self.groove_offset_m.sum())

    @cached_property
    def outer_groove_radius_m(self) -> float:
        """From the bearing's axis to the centre of the outer groove."""
        return float(
            self.pitch_diameter_m / 2 - self.groove_offset_m[1] * np.cos(self.contact_angle_rad)
        )

    @cached_property
    def deformed_radius_m(self) -> FloatArray:
        """Radius of the pressed surface across the rolling direction, 2 f D/(2 f + 1).

        Reference: A. B. Jones, J. Basic Eng. 81 (1959) 1.
        """
        curvature = np.array(self.groove_curvature)
        return 2 * curvature * self.ball_diameter_m / (2 * curvature + 1)

    def radius_x_m(self, cosine: FloatArray) -> FloatArray:
        """Reduced radius along the rolling direction, D/2 (1 -+ cos(alpha) D/dm): (..., 2)."""
        ratio = self.ball_diameter_m / self.pitch_diameter_m
        return self.ball_diameter_m / 2 * (1 + np.array([-1.0, 1.0]) * ratio * cosine)

    @cached_property
    def radius_y_m(self) -> FloatArray:
        """Reduced radius across the rolling direction, inner and outer."""
        curvature = np.array(self.groove_curvature)
        return self.ball_diameter_m * curvature / (2 * curvature - 1)

    def under_unit_load(self, cosine: FloatArray) -> FloatArray:
        """Stiffness and semi-axes of the contacts under 1 N, by Hertz, exact to rounding.

        Args:
            cosine: |cos(alpha)| of each contact, shape (..., 2).

        Returns:
            Shape (3, ..., 2): K in N/m^1.5 of Q = K delta^1.5; semi-axis along the rolling
            direction and across it, in m under 1 N, both growing with the cube root of the load.
        """
        argument = 2 * cosine - 1
        powers = self._hertz_polynomials[(slice(None), slice(None), *(None,) * (argument.ndim - 1))]
        value = powers[-1]
        for coefficient in powers[-2::-1]:
            value = value * argument + coefficient
        return value

    @cached_property
    def _hertz_polynomials(self) -> FloatArray:
        """Coefficients in 2 cos(alpha) - 1: shape (degree + 1, 3, 2)."""
        nodes = np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
        cosine = np.repeat((nodes[:, np.newaxis] + 1) / 2, 2, axis=1)
        contact = elliptical_contact(
            1.0, self.radius_x_m(cosine), self.radius_y_m, self.reduced_modulus_pa
        )
        values = np.stack(
            [contact.approach_m**-1.5, contact.semi_axis_x_m, contact.semi_axis_y_m], axis=1
        )
        powers = np.linalg.solve(np.vander(nodes, increasing=True), values.reshape(len(nodes), -1))
        return powers.reshape(values.shape)
