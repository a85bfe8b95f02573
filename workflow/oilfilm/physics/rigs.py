"""Traction rigs: geometry, materials and roughness, as far as they are known."""

from dataclasses import dataclass

import numpy as np

from oilfilm.physics.contact import Floats, load_for_max_hertz_pressure
from oilfilm.units import PA_PER_GPA, FloatArray


@dataclass(frozen=True)
class Contact:
    """Contact of a ball on a flat disc: geometry, materials and roughness.

    Attributes:
        radius_m: Reduced radius, the ball's own, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        roughness_rq_m: Root-sum-square of both surfaces' Rq, in m.
    """

    radius_m: float
    reduced_modulus_pa: float
    roughness_rq_m: float

    def load_n(self, max_hertz_pressure_gpa: FloatArray | float) -> FloatArray:
        """Load in N that gives the contact its maximum Hertz pressure in GPa."""
        return load_for_max_hertz_pressure(
            max_hertz_pressure_gpa * PA_PER_GPA, self.radius_m, self.reduced_modulus_pa
        )


def rq_from_ra(ra_m: Floats) -> FloatArray:
    """Root-mean-square roughness where only the mean roughness is known.

        Rq = 1.25 Ra

    This is a convention, not a law: a Gaussian profile has sqrt(pi/2) = 1.2533, a sine wave 1.11,
    a plateau-honed one more.

    Args:
        ra_m: Arithmetic mean roughness Ra, in m.

    Returns:
        Rq, in m.

    Examples:
        The rig's root-sum-square Ra of 0.0172 um (docs/physics.md):

        >>> print(f"{rq_from_ra(0.0172e-6) * 1e6:.4f} um")
        0.0215 um
    """
    return np.asarray(1.25 * ra_m)


def combined_roughness(rq_1_m: Floats, rq_2_m: Floats) -> FloatArray:
    """Roughness of two surfaces facing each other, their profiles being independent.

        sigma = sqrt(Rq1^2 + Rq2^2)

    Args:
        rq_1_m: Root-mean-square roughness of the first surface, in m.
        rq_2_m: The same of the second surface.

    Returns:
        sigma, in m. Ra values in give the combined Ra.

    Examples:
        Ball and disc of the rig, Ra 0.014 and 0.010 um, have 0.0172 um together (docs/physics.md):

        >>> print(f"{combined_roughness(0.014e-6, 0.010e-6) * 1e6:.4f} um")
        0.0172 um
    """
    return np.hypot(rq_1_m, rq_2_m)
