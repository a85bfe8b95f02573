"""A ball bearing: sizes, materials, cage, and the Hertz contacts of its races.

Each ball has two contacts, in the order inner race, outer race. Lengths are in m.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.bearing.inputs import UncertainInput
from oilfilm.physics.contact import elliptical_contact

# Degree of the polynomials in the cosine of the contact angle that interpolate Hertz's solution.
# Each degree reduces the error by a factor of at least 2 dm/D, so that only rounding remains.
_POLYNOMIAL_DEGREE = 12


@dataclass(frozen=True)
class OilSupply:
    """The oil that cools a bearing.

    Attributes:
        flow_m3_s: Volume flow at the inlet temperature, in m3/s.
        heat_share: Share of the friction heat that the oil carries away; shaft and housing take
            the rest.
        outlet_weight: Weight of the outlet temperature in that of the oil in the contacts: 0 is the
            inlet temperature, 1 the outlet temperature.
    """

    flow_m3_s: float
    heat_share: float
    outlet_weight: float


@dataclass(frozen=True)
class Cage:
    """A cage guided by the land of one ring.

    Attributes:
        guided_by_outer_ring: True if the land of the outer ring guides it, False if that of the
            inner ring does.
        land_diameter_m: Diameter of the guiding land.
        land_width_m: Width of the two lands of that ring together, one on either side of its
            groove.
        land_clearance_m: Radial clearance between cage and land.
        pocket_friction_coefficient: Coulomb coefficient between ball and pocket.
    """

    guided_by_outer_ring: bool
    land_diameter_m: float
    land_width_m: float
    land_clearance_m: float
    pocket_friction_coefficient: float


@dataclass(frozen=True)
class Rings:
    """Rings of a bearing, with shaft and housing, which have the material of the rings.

    Attributes:
        youngs_modulus_pa: Young's modulus.
        poisson_ratio: Poisson's ratio.
        density_kg_m3: Density.
        expansion_1_k: Coefficient of thermal expansion of the rings.
        ball_expansion_1_k: Coefficient of thermal expansion of the balls.
        bore_ratio: Bore of the inner ring over the diameter at the bottom of its groove.
        outer_groove_ratio: Diameter at the bottom of the outer groove over the outside diameter.
        housing_ratio: Outside diameter of the housing over that of the bearing.
    """

    youngs_modulus_pa: float
    poisson_ratio: float
    density_kg_m3: float
    expansion_1_k: float
    ball_expansion_1_k: float
    bore_ratio: float
    outer_groove_ratio: float
    housing_ratio: float


@dataclass(frozen=True)
class Bearing:
    """A single-row ball bearing.

    Attributes:
        name: Name in config/bearings.
        ball_diameter_m: Ball diameter D.
        pitch_diameter_m: Diameter d_m of the circle of ball centres, unloaded.
        ball_count: Number of balls Z.
        contact_angle_rad: Contact angle alpha_0, unloaded.
        groove_curvature: Groove radius over ball diameter, inner and outer.
        reduced_modulus_pa: E' = 2 E* of ball against ring.
        ball_density_kg_m3: Density of the balls.
        roughness_rq_m: Combined Rq of ball and race.
        cage: The cage.
        rings: The rings, which grow in operation.
        uncertain_inputs: Value and range of each quantity of `inputs.INPUT_NAMES` that belongs to
            the bearing, by its name.
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
    rings: Rings
    uncertain_inputs: Mapping[str, UncertainInput] = field(hash=False)

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
        """Distance A between the centres of inner and outer groove, unloaded."""
        return float(self.groove_offset_m.sum())

    @cached_property
    def outer_groove_centre_radius_m(self) -> float:
        """Distance of the centre of the outer groove from the bearing's axis."""
        radial_offset = self.groove_offset_m[1] * np.cos(self.contact_angle_rad)
        return float(self.pitch_diameter_m / 2 - radial_offset)

    @cached_property
    def groove_centre_radius_m(self) -> FloatArray:
        """Distance of each groove's centre from the bearing's axis, inner and outer."""
        radial_distance = self.groove_centre_distance_m * np.cos(self.contact_angle_rad)
        return np.array(
            [self.outer_groove_centre_radius_m + radial_distance, self.outer_groove_centre_radius_m]
        )

    @cached_property
    def groove_bottom_radius_m(self) -> FloatArray:
        """Distance of the bottom of each groove from the bearing's axis, inner and outer."""
        groove_radius_m = np.array(self.groove_curvature) * self.ball_diameter_m
        return self.groove_centre_radius_m + np.array([-1.0, 1.0]) * groove_radius_m

    @cached_property
    def bore_and_outside_diameter_m(self) -> tuple[float, float]:
        """Bore and outside diameter."""
        inner_radius_m, outer_radius_m = self.groove_bottom_radius_m
        bore_m = 2 * inner_radius_m * self.rings.bore_ratio
        return float(bore_m), float(2 * outer_radius_m / self.rings.outer_groove_ratio)

    @cached_property
    def deformed_surface_radius_m(self) -> FloatArray:
        """Radius of the deformed contact surface across the rolling direction, 2 f D/(2 f + 1).

        Reference: A. B. Jones, J. Basic Eng. 81 (1959) 1.
        """
        curvature = np.array(self.groove_curvature)
        return 2 * curvature * self.ball_diameter_m / (2 * curvature + 1)

    def radius_x_m(self, contact_angle_cosine: FloatArray) -> FloatArray:
        """Reduced radius along the rolling direction, D/2 (1 -+ cos(alpha) D/dm): (..., 2).

        Args:
            contact_angle_cosine: |cos(alpha)| of each contact, shape (..., 2).
        """
        ratio = self.ball_diameter_m / self.pitch_diameter_m
        return self.ball_diameter_m / 2 * (1 + np.array([-1.0, 1.0]) * ratio * contact_angle_cosine)

    @cached_property
    def radius_y_m(self) -> FloatArray:
        """Reduced radius across the rolling direction, inner and outer."""
        curvature = np.array(self.groove_curvature)
        return self.ball_diameter_m * curvature / (2 * curvature - 1)

    def stiffness_and_unit_semi_axes(self, contact_angle_cosine: FloatArray) -> FloatArray:
        """Stiffness of the contacts and their semi-axes under 1 N, by Hertz's theory.

        The values are exact to rounding.

        Args:
            contact_angle_cosine: |cos(alpha)| of each contact, shape (..., 2).

        Returns:
            Shape (3, ..., 2): stiffness K in N/m^1.5 of Q = K delta^1.5, semi-axis along and
            semi-axis across the rolling direction in m. The semi-axes are those under 1 N and grow
            with the cube root of the load.
        """
        polynomial_argument = 2 * contact_angle_cosine - 1
        coefficients_of_powers = self._hertz_polynomials
        # one axis for each leading axis of the argument
        leading_axes = (1,) * (polynomial_argument.ndim - 1)
        coefficients = coefficients_of_powers.reshape(
            *coefficients_of_powers.shape[:2], *leading_axes, 2
        )
        # Horner's rule, from the highest power
        quantities = coefficients[-1]
        for coefficient in coefficients[-2::-1]:
            quantities = quantities * polynomial_argument + coefficient
        return quantities

    @cached_property
    def _hertz_polynomials(self) -> FloatArray:
        """Coefficients of the polynomials in 2 cos(alpha) - 1, shape (degree + 1, 3, 2).

        The axes are the powers, the three quantities of `stiffness_and_unit_semi_axes`, and the
        contacts (inner, outer).
        """
        chebyshev_nodes = np.cos(
            np.pi * (np.arange(_POLYNOMIAL_DEGREE + 1) + 0.5) / (_POLYNOMIAL_DEGREE + 1)
        )
        contact_angle_cosine = np.repeat((chebyshev_nodes[:, np.newaxis] + 1) / 2, 2, axis=1)
        contact = elliptical_contact(
            1.0, self.radius_x_m(contact_angle_cosine), self.radius_y_m, self.reduced_modulus_pa
        )
        quantities_at_nodes = np.stack(
            [contact.approach_m**-1.5, contact.semi_axis_x_m, contact.semi_axis_y_m], axis=1
        )
        powers_of_nodes = np.vander(chebyshev_nodes, increasing=True)
        coefficients = np.linalg.solve(
            powers_of_nodes, quantities_at_nodes.reshape(len(chebyshev_nodes), -1)
        )
        return coefficients.reshape(quantities_at_nodes.shape)
