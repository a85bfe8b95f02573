"""A rational law of twelve constants with the oil's viscosity in place of the temperature.

    mu = N S/((1 + B S) sqrt(1 + C S)),   X = X0 Pbar^X1 Ubar^X2 (eta0/5 mPa s)^X3

N is the slope at S = 0. B S bends the curve towards the level N/B, and C S lets it fall as the
inverse square root of the slip, as a film that its own heat softens. eta0 is the dynamic viscosity
of the oil at the inlet temperature, so that the law needs the oil's properties.

Reference: OURS.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.traction.law import Coefficient, Law


@dataclass(frozen=True, kw_only=True, eq=False)
class ViscosityLaw(Law):
    """A law on pressure, speed and the oil's viscosity at the inlet temperature.

    Attributes:
        oil: The oil; None before `for_oil`.
    """

    oil: Oil | None = None

    def for_oil(self, oil: Oil | None, contact: Contact | None) -> "ViscosityLaw | None":
        """See `Law.for_oil`."""
        return None if oil is None else replace(self, oil=oil)

    def group_values(self, conditions: FloatArray) -> FloatArray:
        """P in GPa, U in m/s and eta0 in Pa s, from P, U and T in degC."""
        if self.oil is None:
            raise ValueError(f"{self.name} needs the oil")
        pressure_gpa, speed_m_s, temperature_c = conditions.T
        viscosity_pa_s = self.oil.dynamic_viscosity_pa_s(temperature_c)
        return np.column_stack([pressure_gpa, speed_m_s, viscosity_pa_s])


RATIONAL_VISCOSITY = ViscosityLaw(
    name="rational-viscosity",
    title="rational, on viscosity",
    source="ours; no publication",
    equation="N*S/((1 + B*S)*sqrt(1 + C*S))",
    coefficients=(
        Coefficient("N", +1, 1e-2, 1e4, multiplies_slip=True),
        Coefficient("B", +1, 1e-2, 1e4, multiplies_slip=True),
        Coefficient("C", +1, 1e-3, 1e4, multiplies_slip=True),
    ),
    groups=("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_viscosity_pa_s"),
    reference=(1.0, 20.0, 5e-3),
)
