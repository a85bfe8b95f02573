"""The four-coefficient law of Wang and Deng, on load and on dimensionless groups.

    mu = (A + B S) exp(-C S) + D

with A < 0, B > 0, C > 0 and D > 0, each a power law. Unlike in Eq. 7 of Deng et al. (2026), D is
independent of A. Hence mu = D - |A| at S = 0, which may differ from zero.

The law is older than the paper that names it: with A = mu_0 - mu_inf and D = mu_inf it is that of
the bearing-dynamics code ADORE. The variables of its power laws are not public. By the paper it is
a law of five parameters (dynamic viscosity, elastic modulus, viscosity-temperature coefficient,
thermal conductivity and slip) that uses the load and not the stress. The groups below are OURS,
made of these parameters.

References: K. Deng, X. Qing, F. Pape, Y. Wang, Lubricants 14 (2026) 33, section 4.1; P. K. Gupta,
Advanced Dynamics of Rolling Elements, Springer (1984), for the slip part.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.physics.contact import Contact
from oilfilm.physics.film import InletOil
from oilfilm.physics.oils import Oil
from oilfilm.traction.law import Coefficient, Law

_CONDITIONS = ("load_n", "entrainment_speed_m_s", "inlet_temperature_c")
_COEFFICIENTS = (
    Coefficient("A", -1, 1e-4, 1.0),
    Coefficient("B", +1, 1e-4, 1e3, multiplies_slip=True),
    Coefficient("C", +1, 1e-2, 1e4, multiplies_slip=True),
    Coefficient("D", +1, 1e-4, 1.0),
)

# On the load in N. Of all laws, only this one and the next one depend on the size of the ball.
WANG_DENG_LOAD = Law(
    name="wang-deng-load",
    title="load-based Wang-Deng",
    source="Wang and Deng, as described by Deng et al., Lubricants 14 (2026) 33, section 4.1",
    equation="(A + B*S)*exp(-C*S) + D",
    coefficients=_COEFFICIENTS,
    conditions=_CONDITIONS,
    groups=_CONDITIONS,
    reference=(100.0, 20.0, 20.0),
    adore=("A", "B", "C", "D"),
    is_evaluated_in_bearings=True,
)

# The law on load with A proportional to |Wc/W - 1|, where Wc is a critical load. K = Wc/W is a
# coefficient whose exponents the law prescribes; K0 = Wc/100 N is its only constant. At W = Wc, A
# is zero and mu does not tend to zero with the slip. A then has three constants of the load: with
# three levels of load, several Wc fit equally well.
# Second-hand: A = A0 W^A1 |Wc/W - 1| U^A2 T^A3. That B, C and D lack the factor is OUR reading.
WANG_DENG_CRITICAL_LOAD = replace(
    WANG_DENG_LOAD,
    name="wang-deng-critical-load",
    title="critical-load Wang-Deng",
    source="Yan et al., Mech. Syst. Signal Process. 224 (2025) 112133, after Wang (2006)",
    equation="(A*abs(K - 1) + B*S)*exp(-C*S) + D",
    coefficients=(
        *_COEFFICIENTS,
        # at the lower bound the law is that on the dimensional load
        Coefficient("K", +1, 1e-9, 1e3, exponents=(-1.0, 0.0, 0.0), smallest_start=1e-3),
    ),
    nested_law=WANG_DENG_LOAD,
    # a single load does not determine the critical load
    varied_conditions_needed=("load_n",),
    adore=("A*abs(K - 1)", "B", "C", "D"),
    is_evaluated_in_bearings=False,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class WangDengGroups(Law):
    """The law on dimensionless groups of load, speed and heating; the groups are OURS.

        Q = W/(E' R^2),  V = eta0 U/(E' R),  Z = eta0 beta U^2/k

    with the oil's properties at the inlet temperature. For a circular contact Q is
    (2 pi^3/3) (p0/E')^3 for every ball: these groups depend on stress and not on load.

    Attributes:
        oil: The oil; None before `for_oil`.
        radius_m: Reduced radius of the contact along the rolling direction.
        reduced_modulus_pa: E' = 2 E*.
    """

    oil: Oil | None = None
    radius_m: FloatArray | float = np.nan
    reduced_modulus_pa: float = np.nan

    def for_oil(self, oil: Oil | None, contact: Contact | None) -> "WangDengGroups | None":
        """See `Law.for_oil`."""
        if oil is None or contact is None:
            return None
        return replace(
            self, oil=oil, radius_m=contact.radius_m, reduced_modulus_pa=contact.reduced_modulus_pa
        )

    def group_values(self, conditions: FloatArray) -> FloatArray:
        """The three groups from W in N, U in m/s and T in degC."""
        if self.oil is None:
            raise ValueError(f"{self.name} needs the oil and the contact")
        load_n, speed_m_s, temperature_c = conditions.T
        modulus_pa = self.reduced_modulus_pa
        radius_m = self.radius_m
        inlet = InletOil.from_oil(self.oil, temperature_c)
        dimensionless_load = load_n / (modulus_pa * radius_m**2)
        dimensionless_speed = inlet.dynamic_viscosity_pa_s * speed_m_s / (modulus_pa * radius_m)
        thermal_loading = inlet.thermal_loading(speed_m_s)
        return np.column_stack([dimensionless_load, dimensionless_speed, thermal_loading])

    def in_contacts(self, radius_m: FloatArray, reduced_modulus_pa: float) -> "WangDengGroups":
        """See `Law.in_contacts`."""
        return replace(self, radius_m=radius_m, reduced_modulus_pa=reduced_modulus_pa)

    def unvaried_conditions(self, condition_varies: BoolArray) -> tuple[str, ...]:
        """See `Law.unvaried_conditions`. Of U and T both must vary, or neither."""
        _, speed_varies, temperature_varies = condition_varies
        if speed_varies == temperature_varies:
            return ()
        _, speed_name, temperature_name = self.conditions
        return (temperature_name,) if speed_varies else (speed_name,)

    def varied_groups(self, condition_varies: BoolArray) -> BoolArray:
        """See `Law.varied_groups`. Speed and thermal loading are separable if both U and T vary.

        Raises:
            ValueError: Only one of U and T varies.
        """
        load_varies, speed_varies, _ = condition_varies
        if self.unvaried_conditions(condition_varies):
            raise ValueError(
                f"{self.name} needs speed and temperature to vary independently, or neither"
            )
        return np.array([load_varies, speed_varies, speed_varies])


WANG_DENG_GROUPS = WangDengGroups(
    name="wang-deng-groups",
    title="dimensionless Wang-Deng",
    source=f"{WANG_DENG_LOAD.source}; the groups are ours",
    equation=WANG_DENG_LOAD.equation,
    coefficients=_COEFFICIENTS,
    conditions=_CONDITIONS,
    groups=("dimensionless_load", "dimensionless_speed", "thermal_loading_parameter"),
    reference=(1e-6, 1e-10, 1.0),
    adore=WANG_DENG_LOAD.adore,
    is_evaluated_in_bearings=True,
)
