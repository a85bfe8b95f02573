"""Properties of oils against temperature, at ambient pressure.

The formulas are here; their numbers, with units and sources, are in config/oils. Methods take
temperatures in degC, floats or arrays. Results are in SI units and have the same shape.

Decides: viscosity and density of an oil (the numbers are in `config/oils`).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oilfilm.physics.contact import Floats
from oilfilm.units import ABSOLUTE_ZERO_C, FloatArray

IntArray = npt.NDArray[np.intp]


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

    def at(self, temperature_k: FloatArray) -> FloatArray:
        """The property at `temperature_k`."""
        piece = self._piece(temperature_k)
        start, value = np.asarray(self.temperature_k)[piece], np.asarray(self.value)[piece]
        return np.asarray(value + self.slope(temperature_k) * (temperature_k - start))

    def slope(self, temperature_k: FloatArray) -> FloatArray:
        """The property's derivative by temperature."""
        slopes = np.diff(self.value) / np.diff(self.temperature_k)
        return np.asarray(slopes[self._piece(temperature_k)])

    def _piece(self, temperature_k: FloatArray) -> IntArray:
        return np.searchsorted(self.temperature_k[1:-1], temperature_k)


@dataclass(frozen=True, kw_only=True)
class Oil(ABC):
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

    @abstractmethod
    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity eta, in Pa s."""

    @abstractmethod
    def pressure_viscosity_coefficient_1_pa(self, temperature_c: Floats) -> FloatArray:
        """Pressure-viscosity coefficient alpha, in 1/Pa."""

    @abstractmethod
    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient beta = -d ln(eta)/dT, in 1/K."""

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


@dataclass(frozen=True, kw_only=True)
class MilL7808(Oil):
    """Oil by the MIL-L-7808 functions of the bearing-dynamics code ADORE, T in K.

        eta   = scale (b - offset),   b = exp(a),   a = exp(intercept - slope ln T)
        alpha = base + rate/(T - pole)
        beta  = slope (a/T) b/(b - offset)

    beta is the derivative of the first line. Given for 311 to 478 K; alpha has no meaning near
    its pole at 216 K.

    Reference: P. K. Gupta, ADORE, lubricant functions (second-hand transcription, docs/physics.md).

    Attributes:
        viscosity_intercept: Dimensionless.
        viscosity_slope: Dimensionless.
        viscosity_scale_pa_s: In Pa s.
        viscosity_offset: Dimensionless.
        pressure_viscosity_base_1_pa: In 1/Pa.
        pressure_viscosity_rate_k_pa: In K/Pa.
        pressure_viscosity_pole_k: In K.
    """

    viscosity_intercept: float
    viscosity_slope: float
    viscosity_scale_pa_s: float
    viscosity_offset: float
    pressure_viscosity_base_1_pa: float
    pressure_viscosity_rate_k_pa: float
    pressure_viscosity_pole_k: float

    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity: scale (b - offset), in Pa s."""
        b = np.exp(self._log_b(_kelvin(temperature_c)))
        return self.viscosity_scale_pa_s * (b - self.viscosity_offset)

    def pressure_viscosity_coefficient_1_pa(self, temperature_c: Floats) -> FloatArray:
        """Pressure-viscosity coefficient: base + rate/(T - pole), in 1/Pa."""
        above_pole = _kelvin(temperature_c) - self.pressure_viscosity_pole_k
        return self.pressure_viscosity_base_1_pa + self.pressure_viscosity_rate_k_pa / above_pole

    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient: slope (a/T) b/(b - offset), in 1/K."""
        t = _kelvin(temperature_c)
        a = self._log_b(t)
        return self.viscosity_slope * (a / t) / (1 - self.viscosity_offset * np.exp(-a))

    def _log_b(self, t: FloatArray) -> FloatArray:
        return np.exp(self.viscosity_intercept - self.viscosity_slope * np.log(t))


@dataclass(frozen=True, kw_only=True)
class _PressureViscosityByViscosity(Oil):
    """Oil whose pressure-viscosity coefficient follows from its viscosity.

        alpha = exp(m ln(eta/1 Pa s) - n)/eta

    Attributes:
        pressure_viscosity_exponent: m, dimensionless.
        pressure_viscosity_offset: n, dimensionless (alpha in 1/Pa, eta in Pa s).
    """

    pressure_viscosity_exponent: float
    pressure_viscosity_offset: float

    def pressure_viscosity_coefficient_1_pa(self, temperature_c: Floats) -> FloatArray:
        """Pressure-viscosity coefficient: exp(m ln(eta) - n)/eta, in 1/Pa."""
        eta_pa_s = self.dynamic_viscosity_pa_s(temperature_c)
        exponent = self.pressure_viscosity_exponent * np.log(eta_pa_s)
        return np.exp(exponent - self.pressure_viscosity_offset) / eta_pa_s


@dataclass(frozen=True, kw_only=True)
class MilL23699(_PressureViscosityByViscosity):
    """Oil by the MIL-L-23699 functions of the bearing-dynamics code ADORE, T in K.

        eta   = eta_r exp(c1 d + c2 d^2),   d = 1/T - 1/T_r
        beta  = (c1 + 2 c2 d)/T^2

    beta is the derivative of the first line. The densities that go with it are given for 233 to
    422 K.

    Reference: P. K. Gupta, ADORE, lubricant functions (second-hand transcription, docs/physics.md).

    Attributes:
        reference_temperature_k: T_r, in K.
        reference_viscosity_pa_s: eta_r, in Pa s.
        viscosity_first_order_k: c1, in K.
        viscosity_second_order_k2: c2, in K2.
    """

    reference_temperature_k: float
    reference_viscosity_pa_s: float
    viscosity_first_order_k: float
    viscosity_second_order_k2: float

    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity: eta_r exp(c1 d + c2 d^2), in Pa s."""
        d = self._inverse_temperature_difference(_kelvin(temperature_c))
        exponent = self.viscosity_first_order_k * d + self.viscosity_second_order_k2 * d**2
        return self.reference_viscosity_pa_s * np.exp(exponent)

    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient: (c1 + 2 c2 d)/T^2, in 1/K."""
        t = _kelvin(temperature_c)
        d = self._inverse_temperature_difference(t)
        return (self.viscosity_first_order_k + 2 * self.viscosity_second_order_k2 * d) / t**2

    def _inverse_temperature_difference(self, t: FloatArray) -> FloatArray:
        return 1 / t - 1 / self.reference_temperature_k


@dataclass(frozen=True, kw_only=True)
class AstmD341(_PressureViscosityByViscosity):
    """Oil known by its kinematic viscosity at two temperatures, T in K, nu in cSt.

        log10 log10(nu + 0.7) = A - B log10 T,   eta = nu rho
        beta  = B ln(10) log10(nu + 0.7) (nu + 0.7)/(nu T) - (d rho/dT)/rho

    beta is the derivative of the first line. Holds for nu above 2 cSt; the standard adds terms
    below that.

    Reference: ASTM D341, Standard practice for viscosity-temperature charts for liquid petroleum
        products, the line without its low-viscosity terms.

    Attributes:
        viscosity_intercept: A, dimensionless.
        viscosity_slope: B, dimensionless.
    """

    viscosity_intercept: float
    viscosity_slope: float

    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity: nu rho, in Pa s."""
        nu_cst = 10 ** self._log_shifted_viscosity(_kelvin(temperature_c)) - 0.7
        return nu_cst * 1e-6 * self.density_kg_m3(temperature_c)

    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient: the sum of those of nu and rho, in 1/K."""
        t = _kelvin(temperature_c)
        log_shifted = self._log_shifted_viscosity(t)
        shifted_over_nu = 1 / (1 - 0.7 * 10**-log_shifted)
        kinematic = self.viscosity_slope * np.log(10) * log_shifted * shifted_over_nu / t
        return np.asarray(kinematic - self.density.slope(t) / self.density.at(t))

    def _log_shifted_viscosity(self, t: FloatArray) -> FloatArray:
        return np.asarray(10 ** (self.viscosity_intercept - self.viscosity_slope * np.log10(t)))


def _kelvin(temperature_c: Floats) -> FloatArray:
    return np.asarray(temperature_c) - ABSOLUTE_ZERO_C
