"""Properties of oils against temperature, at ambient pressure.

The formulas are here; their numbers, with units and sources, are in config/oils. Methods take
temperatures in degC, floats or arrays. Results are in SI units and have the same shape.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.constants import zero_Celsius

from oilfilm.physics.contact import Floats
from oilfilm.units import FloatArray

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
        display_name: Name in figures and tables.
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
class MilL23699(Oil):
    """Oil by the MIL-L-23699 functions of the bearing-dynamics code ADORE, T in K.

        eta   = eta_r exp(c1 d + c2 d^2),   d = 1/T - 1/T_r
        alpha = exp(m ln(eta/1 Pa s) - n)/eta
        beta  = (c1 + 2 c2 d)/T^2

    beta is the derivative of the first line. The densities that go with it are given for 233 to
    422 K.

    Reference: P. K. Gupta, ADORE, lubricant functions (second-hand transcription, docs/physics.md).

    Attributes:
        reference_temperature_k: T_r, in K.
        reference_viscosity_pa_s: eta_r, in Pa s.
        viscosity_first_order_k: c1, in K.
        viscosity_second_order_k2: c2, in K2.
        pressure_viscosity_exponent: m, dimensionless.
        pressure_viscosity_offset: n, dimensionless (alpha in 1/Pa, eta in Pa s).
    """

    reference_temperature_k: float
    reference_viscosity_pa_s: float
    viscosity_first_order_k: float
    viscosity_second_order_k2: float
    pressure_viscosity_exponent: float
    pressure_viscosity_offset: float

    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity: eta_r exp(c1 d + c2 d^2), in Pa s."""
        d = self._inverse_temperature_difference(_kelvin(temperature_c))
        exponent = self.viscosity_first_order_k * d + self.viscosity_second_order_k2 * d**2
        return self.reference_viscosity_pa_s * np.exp(exponent)

    def pressure_viscosity_coefficient_1_pa(self, temperature_c: Floats) -> FloatArray:
        """Pressure-viscosity coefficient: exp(m ln(eta) - n)/eta, in 1/Pa."""
        return _alpha_from_viscosity(
            self.dynamic_viscosity_pa_s(temperature_c),
            self.pressure_viscosity_exponent,
            self.pressure_viscosity_offset,
        )

    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient: (c1 + 2 c2 d)/T^2, in 1/K."""
        t = _kelvin(temperature_c)
        d = self._inverse_temperature_difference(t)
        return (self.viscosity_first_order_k + 2 * self.viscosity_second_order_k2 * d) / t**2

    def _inverse_temperature_difference(self, t: FloatArray) -> FloatArray:
        return 1 / t - 1 / self.reference_temperature_k


@dataclass(frozen=True, kw_only=True)
class AstmD341(Oil):
    """Oil known by its kinematic viscosity at two temperatures, T in K, nu in cSt.

        log10 log10(nu + 0.7) = A - B log10 T,   eta = nu rho
        alpha = exp(m ln(eta/1 Pa s) - n)/eta
        beta  = B ln(10) log10(nu + 0.7) (nu + 0.7)/(nu T) - (d rho/dT)/rho

    beta is the derivative of the first line. Holds for nu above 2 cSt; the standard adds terms
    below that. alpha follows the rule of `MilL23699`.

    Reference: ASTM D341, Standard practice for viscosity-temperature charts for liquid petroleum
        products, the line without its low-viscosity terms.

    Attributes:
        viscosity_intercept: A, dimensionless.
        viscosity_slope: B, dimensionless.
        pressure_viscosity_exponent: m, dimensionless.
        pressure_viscosity_offset: n, dimensionless (alpha in 1/Pa, eta in Pa s).
    """

    viscosity_intercept: float
    viscosity_slope: float
    pressure_viscosity_exponent: float
    pressure_viscosity_offset: float

    def dynamic_viscosity_pa_s(self, temperature_c: Floats) -> FloatArray:
        """Dynamic viscosity: nu rho, in Pa s."""
        nu_cst = 10 ** self._log_shifted_viscosity(_kelvin(temperature_c)) - 0.7
        return nu_cst * 1e-6 * self.density_kg_m3(temperature_c)

    def pressure_viscosity_coefficient_1_pa(self, temperature_c: Floats) -> FloatArray:
        """Pressure-viscosity coefficient: exp(m ln(eta) - n)/eta, in 1/Pa."""
        return _alpha_from_viscosity(
            self.dynamic_viscosity_pa_s(temperature_c),
            self.pressure_viscosity_exponent,
            self.pressure_viscosity_offset,
        )

    def temperature_viscosity_coefficient_1_k(self, temperature_c: Floats) -> FloatArray:
        """Temperature-viscosity coefficient: the sum of those of nu and rho, in 1/K."""
        t = _kelvin(temperature_c)
        log_shifted = self._log_shifted_viscosity(t)
        shifted_over_nu = 1 / (1 - 0.7 * 10**-log_shifted)
        kinematic = self.viscosity_slope * np.log(10) * log_shifted * shifted_over_nu / t
        return np.asarray(kinematic - self.density.slope(t) / self.density.at(t))

    def _log_shifted_viscosity(self, t: FloatArray) -> FloatArray:
        return np.asarray(10 ** (self.viscosity_intercept - self.viscosity_slope * np.log10(t)))


_MODELS: dict[str, type[Oil]] = {
    "adore-mil-l-7808": MilL7808,
    "adore-mil-l-23699": MilL23699,
    "astm-d341": AstmD341,
}


def oil_from_config(config: Mapping[str, Any]) -> Oil:
    """The oil that a file of config/oils describes.

    Args:
        config: Content of the file, as `workflow/schemas/oil.schema.json` has it.

    Returns:
        The oil, ready to be asked for its properties.

    Raises:
        ValueError: The property model is not known.

    Examples:
        The stand-in of 4102 has 7.0 cSt at 100 degC and 40.2 at 40 degC (docs/physics.md):

        >>> from pathlib import Path
        >>> from oilfilm.settings.load import load_checked
        >>> file = Path(__file__).parents[3] / "config" / "oils" / "4102.yaml"
        >>> oil = oil_from_config(load_checked(file, "oil"))
        >>> (oil.kinematic_viscosity_m2_s(np.array([100.0, 40.0])) * 1e6).round(1)
        array([ 7. , 40.2])
    """
    model = config["model"]
    if model not in _MODELS:
        allowed = ", ".join(_MODELS)
        raise ValueError(
            f"oil {config['id']}: found the property model {model!r}; expected one of {allowed}"
        )
    return _MODELS[model](
        id=config["id"],
        name=config["name"],
        display_name=config["display_name"],
        nominal_kinematic_viscosity_100c_cst=config["nominal_kinematic_viscosity_100c_cst"],
        stand_in=config["stand_in"],
        note=config["note"],
        source=config["source"],
        relative_uncertainty=config.get("relative_uncertainty", {}),
        density=_piecewise_linear(config["density_kg_m3"]),
        specific_heat=_piecewise_linear(config["specific_heat_j_kgk"]),
        thermal_conductivity=_piecewise_linear(config["thermal_conductivity_w_mk"]),
        **config["coefficients"],
    )


def _piecewise_linear(rows: Iterable[tuple[float, float]]) -> PiecewiseLinear:
    temperature_k, value = zip(*sorted(rows), strict=True)
    return PiecewiseLinear(temperature_k, value)


def _alpha_from_viscosity(eta_pa_s: FloatArray, exponent: float, offset: float) -> FloatArray:
    return np.exp(exponent * np.log(eta_pa_s) - offset) / eta_pa_s


def _kelvin(temperature_c: Floats) -> FloatArray:
    return np.asarray(temperature_c) + zero_Celsius
