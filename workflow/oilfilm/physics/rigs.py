"""Traction rigs: geometry, materials and roughness, as far as they are known."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from oilfilm.physics.contact import load_for_max_hertz_pressure, reduced_modulus
from oilfilm.physics.roughness import combined_roughness, rq_from_ra
from oilfilm.units import M_PER_UM, PA_PER_GPA, FloatArray


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


def contact_of(rig: Mapping[str, Any]) -> Contact | None:
    """The contact of a rig file; None where its geometry and materials were not recorded."""
    if "ball_radius_m" not in rig:
        return None
    ball, disc = rig["ball"], rig["disc"]
    modulus_pa = reduced_modulus(
        ball["youngs_modulus_pa"],
        ball["poisson_ratio"],
        disc["youngs_modulus_pa"],
        disc["poisson_ratio"],
    )
    ra_m = [rig[f"{body}_roughness_ra_um"] * M_PER_UM for body in ("ball", "disc")]
    rq_m = [
        rig[key] * M_PER_UM if (key := f"{body}_roughness_rq_um") in rig else float(rq_from_ra(ra))
        for body, ra in zip(("ball", "disc"), ra_m, strict=True)
    ]
    return Contact(
        rig["ball_radius_m"],
        float(modulus_pa),
        float(combined_roughness(*rq_m)),
        float(combined_roughness(*ra_m)),
    )
