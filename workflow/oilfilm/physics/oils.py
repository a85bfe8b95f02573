"""Properties of oils against temperature, at ambient pressure.

The formulas are here; their numbers, with units and sources, are in config/oils. Methods take
temperatures in degC, floats or arrays. Results are in SI units and have the same shape.

Decides: viscosity and density of an oil (the numbers are in `config/oils`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oilfilm.physics.contact import Floats
from oilfilm.units import ABSOLUTE_ZERO_C, FloatArray

# Limiting shear stress over pressure that no mineral or synthetic oil is known to exceed: 0.03 to
# 0.12 (S. Bair, W. O. Winer, J. Lubr. Technol. 101 (1979) 251, second-hand). As the mean shear
# stress of a contact is mu times its mean pressure, it is the largest mu as well.
LIMITING_STRESS_RATIO = 0.12
# Of floats, or of complex numbers by which a formula is differentiated.
AnyArray = npt.NDArray[Any]
# Temperature's imaginary step: its square vanishes, so that the derivative is exact to rounding.
_STEP_K = 1e-30


@dataclass(frozen=True)
class PiecewiseLinear:
    """A property given at a few temperatures: straight lines between them.

    The end pieces are continued beyond the table, because the tables begin at 38 degC and the
    rig at 25 degC.

    Attributes:
        temperature_k: Temperatures in K, rising, two or more.
        value: The property at each of them.
    """

    temperature_k: tuple[float, ...]
    value: tuple[float, ...]

    def at(self, temperature_k: AnyArray) -> AnyArray:
        """The property at `temperature_k`."""
        piece = np.searchsorted(self.temperature_k[1:-1], np.real(temperature_k))
        slope = (np.diff(self.value) / np.diff(self.temperature_k))[piece]
        start, value = np.asarray(self.temperature_k)[piece], np.asarray(self.value)[piece]
        return value + slope * (temperature_k - start)


@dataclass(frozen=True, kw_only=True)
class Oil:
    """An oil and its properties.

    Attributes:
        id: Short name, as in config/oils.
        name: Full name.
        display_name: Full name; figures and tables show the id.
        nominal_kinematic_viscosity_100c_cst: Grade of the oil, in cSt (mm2/s) at 100 degC.
        stand_in: True where the properties are those of a similar oil.
        note: A remark on the source of the properties.
        source: Source of the properties.
        relative_uncertainty: Half-width of a property's uncertainty, relative, by property name.
        density: In kg/m3.
        specific_heat: In J/(kg K).
        thermal_conductivity: In W/(m K).
        model: Key of `FORMULAS`.
        coefficients: Numbers of the formulas, by name.
        limiting_stress_ratio: Limiting shear stress over pressure; see `LIMITING_STRESS_RATIO`.
    """

    id: str
    name: str
    display_name: str
    nominal_kinematic_viscosity_100c_cst: float
    stand_in: bool
    note: str
    source: str
    relative_uncertainty: Mapping[str, float]
    density: PiecewiseLinear
    specific_heat: PiecewiseLinear
    thermal_conductivity: PiecewiseLinear
    model: str
    coefficients: Mapping[str, float]
    limiting_stress_ratio: float = LIMITING_STRESS_RATIO

    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity eta, in Pa s."""
        return np.asarray(FORMULAS[self.model][0](self, _kelvin(temperature_c)))

    def pressure_viscosity_coefficient_1_pa(self, temperature_c: Floats) -> FloatArray:
        """Pressure-viscosity coefficient alpha, in 1/Pa."""
        return np.asarray(FORMULAS[self.model][1](self, _kelvin(temperature_c)))

    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient beta = -d ln(eta)/dT, in 1/K."""
        with np.errstate(invalid="ignore"):  # of a missing temperature
            viscosity = FORMULAS[self.model][0](self, _kelvin(temperature_c) + 1j * _STEP_K)
        return np.asarray(-np.imag(viscosity) / np.real(viscosity) / _STEP_K)

    def kinematic_viscosity_m2_s(self, temperature_c: Floats) -> FloatArray:
        """Kinematic viscosity nu = eta/rho, in m2/s."""
        return self.dynamic_viscosity_pa_s(temperature_c) / self.density_kg_m3(temperature_c)

    def density_kg_m3(self, temperature_c: Floats) -> FloatArray:
        """Density rho, in kg/m3."""
        return self.density.at(_kelvin(temperature_c))

    def specific_heat_j_kgk(self, temperature_c: Floats) -> FloatArray:
        """Specific heat, in J/(kg K)."""
        return self.specific_heat.at(_kelvin(temperature_c))

    def thermal_conductivity_w_mk(self, temperature_c: Floats) -> FloatArray:
        """Thermal conductivity, in W/(m K)."""
        return self.thermal_conductivity.at(_kelvin(temperature_c))


def _mil_l_7808_viscosity(oil: Oil, t: AnyArray) -> AnyArray:
    """eta = scale (b - offset),  b = exp(a),  a = exp(intercept - slope ln T).

    MIL-L-7808 oil by the bearing-dynamics code ADORE, for 311 to 478 K.

    Reference: P. K. Gupta, ADORE, lubricant functions (second-hand transcription, docs/physics.md).
    """
    c = oil.coefficients
    a = np.exp(c["viscosity_intercept"] - c["viscosity_slope"] * np.log(t))
    return c["viscosity_scale_pa_s"] * (np.exp(a) - c["viscosity_offset"])


def _mil_l_7808_pressure_viscosity(oil: Oil, t: AnyArray) -> AnyArray:
    """alpha = base + rate/(T - pole), without meaning near the pole. Reference: as above."""
    c = oil.coefficients
    above_pole = t - c["pressure_viscosity_pole_k"]
    return c["pressure_viscosity_base_1_pa"] + c["pressure_viscosity_rate_k_pa"] / above_pole


def _mil_l_23699_viscosity(oil: Oil, t: AnyArray) -> AnyArray:
    """eta = eta_r exp(c1 d + c2 d^2),  d = 1/T - 1/T_r.

    MIL-L-23699 oil by the bearing-dynamics code ADORE; the densities that go with it are given for
    233 to 422 K.

    Reference: P. K. Gupta, ADORE, lubricant functions (second-hand transcription, docs/physics.md).
    """
    c = oil.coefficients
    d = 1 / t - 1 / c["reference_temperature_k"]
    exponent = c["viscosity_first_order_k"] * d + c["viscosity_second_order_k2"] * d**2
    return c["reference_viscosity_pa_s"] * np.exp(exponent)


def _by_viscosity(oil: Oil, t: AnyArray) -> AnyArray:
    """alpha = exp(m ln(eta) - n)/eta, alpha in 1/Pa and eta in Pa s. Reference: ADORE, as above."""
    c, eta_pa_s = oil.coefficients, FORMULAS[oil.model][0](oil, t)
    exponent = c["pressure_viscosity_exponent"] * np.log(eta_pa_s)
    return np.exp(exponent - c["pressure_viscosity_offset"]) / eta_pa_s


def _astm_d341_viscosity(oil: Oil, t: AnyArray) -> AnyArray:
    """log10 log10(nu + 0.7) = A - B log10 T,  eta = nu rho, nu in cSt and above 2 cSt.

    Reference: ASTM D341, Standard practice for viscosity-temperature charts for liquid petroleum
        products, the line without its low-viscosity terms.
    """
    c = oil.coefficients
    shifted = 10 ** (10 ** (c["viscosity_intercept"] - c["viscosity_slope"] * np.log10(t)))
    return (shifted - 0.7) * 1e-6 * oil.density.at(t)


Formula = Callable[[Oil, AnyArray], AnyArray]
# Viscosity and pressure-viscosity coefficient by temperature in K, by the `model` of an oil's file.
FORMULAS: dict[str, tuple[Formula, Formula]] = {
    "adore-mil-l-7808": (_mil_l_7808_viscosity, _mil_l_7808_pressure_viscosity),
    "adore-mil-l-23699": (_mil_l_23699_viscosity, _by_viscosity),
    "astm-d341": (_astm_d341_viscosity, _by_viscosity),
}


def _kelvin(temperature_c: Floats) -> FloatArray:
    return np.asarray(temperature_c) - ABSOLUTE_ZERO_C
