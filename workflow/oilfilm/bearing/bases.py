"""Traction laws as a bearing asks them: by contact stress, by load, by dimensionless load."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from oilfilm.bearing.ellipse import Conditions
from oilfilm.contact import load_for_max_hertz_pressure
from oilfilm.rigs import Contact
from oilfilm.traction.deng2026 import REFERENCE, traction_coefficient
from oilfilm.units import PA_PER_GPA, FloatArray

BASES = ("stress", "load", "dimensionless_load")


@dataclass(frozen=True)
class PowerLawBasis:
    """Eqs 7-9 with their first power law in stress, in load or in W/(E' R^2).

    On the one ball and flat of a traction rig the three say the same: load goes with the cube of
    the stress, so that data which one fits the others fit as well, with a third of the exponents.
    In a bearing, with other balls and elliptical contacts, they differ; R is then Rx, the reduced
    radius along the rolling direction.

    Attributes:
        basis: One of `BASES`.
        constants: The twelve constants of Eqs 7-9, stress in GPa.
        rig: Contact of the traction rig on which they were found.
        floor: Smallest stress, speed and temperature that the power laws are given; they have no
            value at zero.
    """

    basis: str
    constants: FloatArray
    rig: Contact
    floor: Mapping[str, float]

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionBasis`."""
        stress_gpa = {
            "stress": lambda: at.max_hertz_pressure_gpa,
            "load": lambda: np.cbrt(at.load_n / self._load_at_one_gpa_n),
            "dimensionless_load": lambda: np.cbrt(
                at.load_n
                / (at.reduced_modulus_pa * at.radius_x_m**2)
                / (self._load_at_one_gpa_n / (self.rig.reduced_modulus_pa * self.rig.radius_m**2))
            ),
        }[self.basis]()
        return traction_coefficient(
            self.constants,
            np.maximum(stress_gpa, self.floor["max_hertz_pressure_gpa"]),
            np.maximum(at.entrainment_speed_m_s, self.floor["entrainment_speed_m_s"]),
            np.maximum(at.inlet_temperature_c, self.floor["inlet_temperature_c"]),
            slide_roll_ratio,
        )

    @property
    def _load_at_one_gpa_n(self) -> FloatArray:
        return load_for_max_hertz_pressure(
            REFERENCE[0] * PA_PER_GPA, self.rig.radius_m, self.rig.reduced_modulus_pa
        )
