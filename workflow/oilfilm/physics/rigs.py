"""Traction rigs: geometry, materials and roughness, as far as they are known."""

from dataclasses import dataclass

from oilfilm.physics.contact import load_for_max_hertz_pressure
from oilfilm.units import PA_PER_GPA, FloatArray


@dataclass(frozen=True)
class Contact:
    """Contact of a ball on a flat disc: geometry, materials and roughness.

    Attributes:
        radius_m: Reduced radius, the ball's own, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        roughness_rq_m: Root-sum-square of both surfaces' Rq, in m.
        roughness_ra_m: The same of their Ra, in m.
    """

    radius_m: float
    reduced_modulus_pa: float
    roughness_rq_m: float
    roughness_ra_m: float

    def load_n(self, max_hertz_pressure_gpa: FloatArray | float) -> FloatArray:
        """Load in N that gives the contact its maximum Hertz pressure in GPa."""
        return load_for_max_hertz_pressure(
            max_hertz_pressure_gpa * PA_PER_GPA, self.radius_m, self.reduced_modulus_pa
        )

    def roughness_m(self, kind: str) -> float:
        """Combined roughness by `rq` or `ra`."""
        return {"rq": self.roughness_rq_m, "ra": self.roughness_ra_m}[kind]
