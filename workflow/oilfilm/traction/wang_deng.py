"""The four-coefficient law of Wang and Deng, on load and on dimensionless groups.

    mu = (A + B S) exp(-C S) + D

with A < 0, B > 0, C > 0 and D > 0, each a power law. Unlike Eq. 7 of Deng et al. (2026) nothing
ties D to A, so that mu = D - |A| at S = 0, which need not be zero.

The law is older than the paper that names it: with A = mu_0 - mu_inf and D = mu_inf it is that of
the bearing-dynamics code ADORE. What the coefficients are power laws of is not public. The paper
calls it a law of five parameters (dynamic viscosity, elastic modulus, viscosity-temperature
coefficient, thermal conductivity and slip) that takes the load and not the stress; the groups
below are OURS, made of just those.

References: K. Deng, X. Qing, F. Pape, Y. Wang, Lubricants 14 (2026) 33, section 4.1; P. K. Gupta,
Advanced Dynamics of Rolling Elements, Springer (1984), for the slip part.
"""

from copy import copy
from typing import ClassVar

import numpy as np

from oilfilm.physics.film import InletOil
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.traction.law import BoolArray, Coefficient, FloatArray, Law

_SLIP = "mu = (A + B S) exp(-C S) + D"
_SOURCE = "Wang and Deng, as described by Deng et al., Lubricants 14 (2026) 33, section 4.1"


class WangDengLoad(Law):
    """On the dimensional load, which alone carries the size of the ball."""

    name = "wang-deng-load"
    equation = f"{_SLIP}, X = X0 (W/100 N)^X1 (U/20 m/s)^X2 (T/20 degC)^X3"
    source = _SOURCE
    conditions = ("load_n", "entrainment_speed_m_s", "inlet_temperature_c")
    reference = np.array([100.0, 20.0, 20.0])  # N, m/s, degC
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient("A", -1, 1e-4, 1.0),
        Coefficient("B", +1, 1e-4, 1e3),
        Coefficient("C", +1, 1e-2, 1e4),
        Coefficient("D", +1, 1e-4, 1.0),
    )

    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from |A|, B, C and D."""
        size, slope, rate, level = sizes
        return np.asarray((slope * slip - size) * np.exp(-rate * slip) + level)

    def slopes(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives by ln|A|, ln B, ln C and ln D."""
        size, slope, rate, level = sizes
        decay = np.exp(-rate * slip)
        return np.stack(
            [
                -size * decay,
                slope * slip * decay,
                (size - slope * slip) * rate * slip * decay,
                np.broadcast_to(level, decay.shape),
            ]
        )


class WangDengCriticalLoad(WangDengLoad):
    """The same with A proportional to |Wc/W - 1|, Wc being a critical load.

    K = Wc/W is a coefficient like the others, whose exponents the law gives: K0 = Wc/100 N is its
    one constant. At W = Wc A vanishes and mu no longer tends to zero with the slip. A has three
    constants of the load then: loads at three levels fit more than one Wc exactly as well.

    Reference: Yan et al., Mech. Syst. Signal Process. 224 (2025) 112133, after Wang's thesis of
    2006: A = A0 W^A1 |Wc/W - 1| U^A2 T^A3. Second-hand; that B, C and D lack the factor is OUR
    reading.
    """

    name = "wang-deng-critical-load"
    equation = (
        "mu = (A |K - 1| + B S) exp(-C S) + D, X = X0 (W/100 N)^X1 (U/20 m/s)^X2 (T/20 degC)^X3, "
        "K = Wc/W = K0 (W/100 N)^-1"
    )
    source = "Yan et al., Mech. Syst. Signal Process. 224 (2025) 112133, after Wang (2006)"
    coefficients = (
        *WangDengLoad.coefficients,
        Coefficient("K", +1, 1e-3, 1e3, exponents=(-1.0, 0.0, 0.0)),
    )

    def varied_groups(self, varied: BoolArray) -> BoolArray:
        """The conditions themselves.

        Raises:
            ValueError: The load does not vary: one load says nothing of a critical one.
        """
        if not varied[0]:
            raise ValueError(f"{self.name} needs the load to vary")
        return varied

    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from |A|, B, C, D and K."""
        size, slope, rate, level, critical = sizes
        factored = np.stack([size * np.abs(critical - 1), slope, rate, level])
        return super().value(factored, slip)

    def slopes(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives by ln|A|, ln B, ln C, ln D and ln K; by K one-sided where K = 1."""
        size, slope, rate, level, critical = sizes
        factored = np.stack([size * np.abs(critical - 1), slope, rate, level])
        by_critical = -size * np.exp(-rate * slip) * np.sign(critical - 1) * critical
        return np.concatenate([super().slopes(factored, slip), by_critical[np.newaxis]])


class WangDengGroups(WangDengLoad):
    """On dimensionless groups of load, speed and heat; the groups are OURS.

        Wbar = W/(E' R^2),  Ubar = eta0 U/(E' R),  Lbar = eta0 beta U^2/k

    with the oil's properties at the inlet temperature. For a circular contact Wbar is
    (2 pi^3/3) (p_max/E')^3 whatever the ball: this basis is one of stress, not of load.
    """

    name = "wang-deng-groups"
    equation = f"{_SLIP}, X = X0 (W/(E' R^2)/1e-6)^X1 (eta0 U/(E' R)/1e-10)^X2 (eta0 beta U^2/k)^X3"
    source = f"{_SOURCE}; the groups are ours"
    reference = np.array([1e-6, 1e-10, 1.0])

    def __init__(self, oil: Oil, contact: Contact) -> None:
        self._oil = oil
        self._radius_m: FloatArray | float = contact.radius_m
        self._modulus_pa = contact.reduced_modulus_pa

    @property
    def groups(self) -> tuple[str, ...]:
        """Load, speed and thermal loading parameter."""
        return ("dimensionless_load", "dimensionless_speed", "thermal_loading_parameter")

    def group_values(self, conditions: FloatArray) -> FloatArray:
        """The three groups from W in N, U in m/s and T in degC."""
        load_n, speed_m_s, temperature_c = conditions.T
        modulus_pa, radius_m = self._modulus_pa, self._radius_m
        inlet = InletOil.of(self._oil, temperature_c)
        return np.column_stack(
            [
                load_n / (modulus_pa * radius_m**2),
                inlet.dynamic_viscosity_pa_s * speed_m_s / (modulus_pa * radius_m),
                inlet.thermal_loading(speed_m_s),
            ]
        )

    def in_contacts(self, radius_m: FloatArray, reduced_modulus_pa: float) -> "WangDengGroups":
        """See `Law.in_contacts`."""
        other = copy(self)
        other._radius_m, other._modulus_pa = radius_m, reduced_modulus_pa
        return other

    def varied_groups(self, varied: BoolArray) -> BoolArray:
        """Speed and thermal loading can be told apart where both U and T vary.

        Raises:
            ValueError: One of U and T varies alone.
        """
        load, speed, temperature = varied
        if speed != temperature:
            raise ValueError(f"{self.name} needs speed and temperature to vary, or neither")
        return np.array([load, speed, speed])
