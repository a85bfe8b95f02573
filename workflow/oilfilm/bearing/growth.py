"""Growth of rings and balls by rotation, fits and temperature.

Drawings give a bearing that is not mounted, at rest, at 20 degC. In operation the groove centres
move along the radius, and grooves and balls grow by temperature. The play between the grooves falls
and may vanish; the contact angles follow from the equilibrium (`quasistatic.normal_contacts`).

Decides: how far the rings of a bearing grow.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.inputs import InputValues
from oilfilm.physics.contact import Floats

# Temperature at which the dimensions of a drawing hold.
DRAWING_TEMPERATURE_C = 20.0


@dataclass(frozen=True)
class Growth:
    """Changes of a bearing's dimensions from its drawing, shapes (points, 2) of inner and outer.

    Attributes:
        centre_displacement_m: Radial displacement of each groove's centre, outward.
        offset_growth_m: Growth of the distance from groove centre to ball centre in an unloaded
            contact.
    """

    centre_displacement_m: FloatArray
    offset_growth_m: FloatArray

    def at_points(self, point_index: IndexArray) -> "Growth":
        """The growth at some of the points."""
        return Growth(self.centre_displacement_m[point_index], self.offset_growth_m[point_index])


def centrifugal_growth_m(
    speed_rad_s: Floats,
    radius_m: Floats,
    bore_radius_m: Floats,
    density_kg_m3: float,
    youngs_modulus_pa: float,
    poisson_ratio: float,
) -> FloatArray:
    """Radial growth of the outer surface of a rotating ring.

        u = rho omega^2 b/(4 E) [(1 - nu) b^2 + (3 + nu) a^2]

    with the outer radius b and the radius of the bore a.

    Validity: a thick ring in plane stress.

    Reference: S. P. Timoshenko and J. N. Goodier, Theory of Elasticity, rotating disks.

    Examples:
        A steel ring of 72.6 mm with a bore of 0.75 of that, at 12 000 rpm:

        >>> speed = 12000 * np.pi / 30
        >>> growth = centrifugal_growth_m(speed, 72.6e-3, 0.75 * 72.6e-3, 7833, 207.5e9, 0.3)
        >>> print(f"{growth * 1e6:.3f} um")
        14.577 um
    """
    radius_term = (1 - poisson_ratio) * np.square(radius_m) + (3 + poisson_ratio) * np.square(
        bore_radius_m
    )
    speed_factor = density_kg_m3 * np.square(speed_rad_s) * radius_m / (4 * youngs_modulus_pa)
    return np.asarray(speed_factor * radius_term)


def interference_share(
    groove_radius_m: Floats, fit_radius_m: Floats, free_surface_radius_m: Floats
) -> FloatArray:
    """Radial displacement of a groove by the fit of its ring, over the fit's radial interference.

        share = 2 a b/|b^2 - a^2| / [(b^2 + a^2)/|b^2 - a^2| + (a^2 + c^2)/|a^2 - c^2|]

    with the groove's radius b, the radius of the fit a and that of the other body's free surface c:
    the bore of the shaft, or the outer surface of the housing. A groove moves away from its fit.

    Validity: thick rings of the same elastic constants, plane stress.

    Reference: G. Lame's solution of thick rings under pressure; S. P. Timoshenko, Strength of
        Materials, part 2, shrink fits.

    Examples:
        A ring on a solid shaft takes a/b of the interference, here 0.8:

        >>> print(f"{interference_share(1.0, 0.8, 0.0):.3f}")
        0.800
    """
    groove_radius_squared, fit_radius_squared, free_radius_squared = (
        np.square(groove_radius_m),
        np.square(fit_radius_m),
        np.square(free_surface_radius_m),
    )
    ring_difference = np.abs(groove_radius_squared - fit_radius_squared)
    compliance = (groove_radius_squared + fit_radius_squared) / ring_difference + (
        fit_radius_squared + free_radius_squared
    ) / np.abs(fit_radius_squared - free_radius_squared)
    return np.asarray(2 * np.multiply(groove_radius_m, fit_radius_m) / ring_difference / compliance)


def inner_ring_growth_m(
    bearing: Bearing,
    speed_rad_s: FloatArray,
    shaft_bore_ratio: FloatArray,
    interference_m: FloatArray,
) -> FloatArray:
    """Radial growth of the inner groove by rotation and by the fit on the shaft, shape (points,).

    A tight ring and its shaft grow as one body with the bore of the shaft. The fit adds its share,
    calculated with both bodies. A ring that has lost its fit grows alone. The growth is the larger
    of the two: where the pressure of the fit vanishes they are equal.

    Args:
        bearing: The bearing.
        speed_rad_s: Speed of the inner ring.
        shaft_bore_ratio: Bore of the shaft over the diameter of the groove.
        interference_m: Interference on the radius.
    """
    rings = bearing.rings
    groove_bottom_radius_m = bearing.groove_bottom_radius_m[0]
    fit_radius_m = rings.bore_ratio * groove_bottom_radius_m
    ring_material = (rings.density_kg_m3, rings.youngs_modulus_pa, rings.poisson_ratio)
    shaft_bore_radius_m = shaft_bore_ratio * groove_bottom_radius_m
    one_body_growth_m = centrifugal_growth_m(
        speed_rad_s, groove_bottom_radius_m, shaft_bore_radius_m, *ring_material
    )
    tight_growth_m = (
        one_body_growth_m
        + interference_share(groove_bottom_radius_m, fit_radius_m, shaft_bore_radius_m)
        * interference_m
    )
    ring_alone_growth_m = centrifugal_growth_m(
        speed_rad_s, groove_bottom_radius_m, fit_radius_m, *ring_material
    )
    return np.maximum(tight_growth_m, ring_alone_growth_m)


def operating_growth(
    bearing: Bearing,
    speed_rad_s: FloatArray,
    outer_ring_temperature_c: FloatArray,
    inputs: InputValues,
) -> Growth:
    """Growth of a bearing in operation.

    Args:
        bearing: The bearing; its shaft and housing have the material of the rings.
        speed_rad_s: Speed of the inner ring, shape (points,).
        outer_ring_temperature_c: Temperature of the outer ring, shape (points,).
        inputs: Fits and differences of temperature.
    """
    rings = bearing.rings
    outer_bottom_radius_m = bearing.groove_bottom_radius_m[1]
    inner_growth_m = inner_ring_growth_m(
        bearing, speed_rad_s, inputs.shaft_bore_ratio, inputs.shaft_interference_m
    )
    outside_radius_m = outer_bottom_radius_m / rings.outer_groove_ratio
    interference_share_of_ring = interference_share(
        outer_bottom_radius_m, outside_radius_m, outside_radius_m * rings.housing_ratio
    )
    groove_squeeze_m = interference_share_of_ring * np.maximum(inputs.housing_interference_m, 0.0)

    inner_ring_temperature_c = outer_ring_temperature_c + inputs.ring_temperature_difference_k
    ring_warming_k = np.stack([inner_ring_temperature_c, outer_ring_temperature_c], axis=-1)
    ring_warming_k -= DRAWING_TEMPERATURE_C
    ball_warming_k = ring_warming_k.mean(axis=-1) + inputs.ball_temperature_difference_k
    ring_strain = rings.expansion_1_k * ring_warming_k
    ball_strain = rings.ball_expansion_1_k * ball_warming_k[:, np.newaxis]
    centre_displacement_m = ring_strain * bearing.groove_centre_radius_m
    centre_displacement_m += np.stack([inner_growth_m, -groove_squeeze_m], axis=-1)
    groove_curvature_radius_m = np.array(bearing.groove_curvature) * bearing.ball_diameter_m
    offset_growth_m = (
        ring_strain * groove_curvature_radius_m - ball_strain * bearing.ball_diameter_m / 2
    )
    return Growth(centre_displacement_m, offset_growth_m)
