"""Thickness of the oil film in a rolling contact, and its ratio to the roughness (lambda).

All quantities are in SI units. Arguments are floats or arrays that broadcast against each other.

`contact_film` gives film and lambda of an oil in a rig's contact. `film_thickness` gives the film
of any contact. The formulas behind both come first. A lambda needs its definition: bearing
practice takes the minimum film, reduced by inlet heating, over the combined Rq.

Decides: how thick the film of an oil in a contact is, and lambda.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from oilfilm.physics.contact import Conditions, Contact, Floats, max_hertz_pressure
from oilfilm.physics.oils import Oil
from oilfilm.units import PA_PER_GPA, BoolArray, FloatArray

# Outside this range no oil is a liquid lubricant, and the formulas of its properties overflow.
_OIL_TEMPERATURES_C = (-100.0, 500.0)
# Of phi_T; assumed: nearer to zero its fit is beyond its range.
_LEAST_NUMERATOR = 0.1

Thickness = Literal["minimum", "central"]


# a, b, c, d, e, f of h/Rx = a U^b G^c W^-d (1 - e exp(-f k))
_HAMROCK_DOWSON = {
    "central": (2.69, 0.67, 0.53, 0.067, 0.61, 0.73),
    "minimum": (3.63, 0.68, 0.49, 0.073, 1.0, 0.68),
}


def isothermal_film_thickness(oil: "InletOil", at: Conditions, thickness: Thickness) -> FloatArray:
    """Film thickness in a fully flooded, isothermal point contact: in its centre, or the smallest.

        h_c/Rx   = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k))
        h_min/Rx = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k))

        U = eta0 u/(E' Rx),   G = alpha E',   W = w/(E' Rx^2)

    Args:
        oil: The oil at the inlet temperature.
        at: Load (above 0), speed, radius, modulus and ellipticity. The exact one
            (`contact.ellipticity`) is 1 for a ball on a flat, where the authors' fit
            1.0339 (Ry/Rx)^0.636 would thicken the film by 1 to 2 %.
        thickness: `central` (h_c), or `minimum` (h_min, at the sides).

    Returns:
        h, in m.

    Validity: full film, ample oil, steady rolling along x. Fitted to 34 numerical solutions, of
        k from 1 to 8 and U up to the order of 1e-11 (both limits not checked against print); the
        rig covers U from 2e-11 to 1e-9 and so extrapolates. Heating in the inlet is left out:
        see `film_thickness`.

    Reference: B. J. Hamrock and D. Dowson, Isothermal elastohydrodynamic lubrication of point
        contacts, Part III, J. Lubr. Technol. 99 (1977) 264, doi 10.1115/1.3453074.

    Examples:
        20 mm steel ball on a flat, MIL-L-23699 oil at 100 degC, 0.360 um in the centre:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> at = Conditions(142, 1.5, 25, 100, radius_x_m=0.010, reduced_modulus_pa=221.6e9)
        >>> h = isothermal_film_thickness(oil, at, "minimum")
        >>> print(f"{h * 1e6:.3f} um")
        0.211 um
    """
    factor, speed_power, oil_power, load_power, leakage, leakage_rate = _HAMROCK_DOWSON[thickness]
    modulus, radius = at.reduced_modulus_pa, at.radius_x_m
    u = oil.dynamic_viscosity_pa_s * at.entrainment_speed_m_s / (modulus * radius)
    g = oil.pressure_viscosity_coefficient_1_pa * modulus
    w = at.load_n / (modulus * radius**2)
    side_leakage = 1 - leakage * np.exp(-leakage_rate * at.ellipticity)
    relative = factor * u**speed_power * g**oil_power * w**-load_power * side_leakage
    return np.asarray(relative * radius)


def thermal_reduction_factor(
    relative_pressure: Floats, slide_roll_ratio: Floats, thermal_loading: Floats
) -> FloatArray:
    """Thermal reduction of the isothermal film by inlet heating: h = phi_T h_isothermal.

        phi_T = [1 - 13.2 (p0/E') L^0.42] / [1 + 0.213 (1 + 2.23 |S|^0.83) L^0.64]

    Args:
        relative_pressure: Maximum pressure over modulus, p0/E'; 0 leaves the pressure term out.
        slide_roll_ratio: S; its sign makes no difference.
        thermal_loading: L of `InletOil.thermal_loading`, 0 or more.

    Returns:
        phi_T, 1 where L = 0.

    Validity: an empirical fit, not clipped here. Its numerator turns negative at L above about
        300 at 1.5 GPa on steel; `within_thermal_reduction` tells where it is used beyond its range.

    Reference: P. K. Gupta, H. S. Cheng, D. Zhu, N. H. Forster and J. B. Schrand, Viscoelastic
        effects in MIL-L-7808-type lubricant, Part I, Tribol. Trans. 35 (1992) 269.

    Examples:
        MIL-L-23699 oil at 100 degC, 25 m/s and 1.5 GPa:

        >>> phi = thermal_reduction_factor(1.5 / 221.6, np.array([0.0, 0.3]), 0.424)
        >>> phi.round(3)
        array([0.835, 0.766])
    """
    slip = 1 + 2.23 * np.abs(slide_roll_ratio) ** 0.83
    shear = 0.213 * slip * thermal_loading**0.64
    return np.asarray(_numerator(relative_pressure, thermal_loading) / (1 + shear))


def within_thermal_reduction(relative_pressure: Floats, thermal_loading: Floats) -> BoolArray:
    """Whether phi_T is used within its range: its numerator is not near or below zero.

    Beyond, a small or negative film is that of the formula, and says nothing about the contact.

    Args:
        relative_pressure: As in `thermal_reduction_factor`.
        thermal_loading: As there.
    """
    return np.asarray(_numerator(relative_pressure, thermal_loading) >= _LEAST_NUMERATOR)


def _numerator(relative_pressure: Floats, thermal_loading: Floats) -> FloatArray:
    """1 - 13.2 (p0/E') L^0.42."""
    return np.asarray(1 - 13.2 * relative_pressure * thermal_loading**0.42)


@dataclass(frozen=True)
class InletOil:
    """Properties of an oil at the inlet of a contact, on which its film depends.

    Attributes:
        dynamic_viscosity_pa_s: eta0, in Pa s.
        pressure_viscosity_coefficient_1_pa: alpha, in 1/Pa.
        temperature_viscosity_coefficient_1_k: beta = -d ln(eta0)/dT, in 1/K.
        thermal_conductivity_w_mk: k_oil, in W/(m K).
    """

    dynamic_viscosity_pa_s: Floats
    pressure_viscosity_coefficient_1_pa: Floats
    temperature_viscosity_coefficient_1_k: Floats
    thermal_conductivity_w_mk: Floats

    @classmethod
    def of(cls, oil: Oil, temperature_c: Floats) -> "InletOil":
        """The properties of an oil at inlet temperatures in degC."""
        return cls(
            oil.dynamic_viscosity_pa_s(temperature_c),
            oil.pressure_viscosity_coefficient_1_pa(temperature_c),
            oil.temperature_viscosity_coefficient_1_k(temperature_c),
            oil.thermal_conductivity_w_mk(temperature_c),
        )

    @classmethod
    def joined(cls, oils: Sequence["InletOil"]) -> "InletOil":
        """The properties of several oils, arrays of one axis, one oil after the other."""
        return cls(
            np.concatenate([oil.dynamic_viscosity_pa_s for oil in oils]),
            np.concatenate([oil.pressure_viscosity_coefficient_1_pa for oil in oils]),
            np.concatenate([oil.temperature_viscosity_coefficient_1_k for oil in oils]),
            np.concatenate([oil.thermal_conductivity_w_mk for oil in oils]),
        )

    def __getitem__(self, index: Any) -> "InletOil":
        """The properties with the same index applied to each array."""
        return InletOil(
            np.asarray(self.dynamic_viscosity_pa_s)[index],
            np.asarray(self.pressure_viscosity_coefficient_1_pa)[index],
            np.asarray(self.temperature_viscosity_coefficient_1_k)[index],
            np.asarray(self.thermal_conductivity_w_mk)[index],
        )

    def thermal_loading(self, entrainment_speed_m_s: Floats) -> FloatArray:
        """Thermal loading parameter: how strongly shear in the inlet heats the oil there.

            L = eta0 beta u^2 / k_oil

        Args:
            entrainment_speed_m_s: Mean u = (u1 + u2)/2 of the two surface speeds, in m/s.

        Reference: P. K. Gupta, H. S. Cheng, D. Zhu, N. H. Forster and J. B. Schrand, Viscoelastic
            effects in MIL-L-7808-type lubricant, Part I, Tribol. Trans. 35 (1992) 269.

        Examples:
            MIL-L-23699 oil at 100 degC and 25 m/s:

            >>> print(f"{InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472).thermal_loading(25):.3f}")
            0.424
        """
        heating = self.dynamic_viscosity_pa_s * self.temperature_viscosity_coefficient_1_k
        return np.asarray(heating * entrainment_speed_m_s**2 / self.thermal_conductivity_w_mk)


def film_thickness(
    oil: InletOil, at: Conditions, slide_roll_ratio: Floats, thickness: Thickness
) -> FloatArray:
    """Film thickness of an oil in a contact: h = phi_T h_isothermal.

    Args:
        oil: The oil at the inlet temperature.
        at: The contact's conditions; a pressure of 0 leaves out the pressure term of phi_T.
        slide_roll_ratio: S.
        thickness: `minimum` or `central`, as in `isothermal_film_thickness`.

    Returns:
        h, in m; zero or negative outside the range of phi_T.

    Examples:
        MIL-L-23699 oil at 100 degC on a 20 mm ball: 0.2108 um, reduced by 0.766:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> at = Conditions(142, 1.5, 25, 100, radius_x_m=0.010, reduced_modulus_pa=221.6e9)
        >>> print(f"{film_thickness(oil, at, 0.3, 'minimum') * 1e6:.3f} um")
        0.161 um
    """
    isothermal = isothermal_film_thickness(oil, at, thickness)
    loading = oil.thermal_loading(at.entrainment_speed_m_s)
    return isothermal * thermal_reduction_factor(at.relative_pressure, slide_roll_ratio, loading)


def contact_film(
    oil: Oil,
    contact: Contact,
    thickness: Thickness,
    *,
    load_n: FloatArray,
    entrainment_speed_m_s: FloatArray,
    inlet_temperature_c: FloatArray,
    slide_roll_ratio: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Film thickness and lambda of an oil in the contact of a ball on a flat.

    Args:
        oil: The oil.
        contact: The contact.
        thickness: As in `film_thickness`.
        load_n: Normal load, in N (`contact.load_for_max_hertz_pressure` where p0 is known).
        entrainment_speed_m_s: Mean of the two surface speeds, in m/s.
        inlet_temperature_c: Oil temperature at the inlet, in degC.
        slide_roll_ratio: S.

    Returns:
        Film thickness h, in m, and lambda = h/sigma, sigma the combined Rq, of the
        arguments' broadcast shape. NaN where speed or temperature is not possible, or where the
        thermal reduction is used outside its range.
    """
    low, high = _OIL_TEMPERATURES_C
    speed = np.where(entrainment_speed_m_s > 0, entrainment_speed_m_s, np.nan)
    is_liquid = (inlet_temperature_c >= low) & (inlet_temperature_c <= high)
    inlet_oil = InletOil.of(oil, np.where(is_liquid, inlet_temperature_c, np.nan))
    radius, modulus = np.asarray(contact.radius_m), contact.reduced_modulus_pa
    pressure = max_hertz_pressure(load_n, radius, modulus) / PA_PER_GPA
    at = Conditions(load_n, pressure, speed, inlet_temperature_c, radius, modulus)
    thickness_m = film_thickness(inlet_oil, at, slide_roll_ratio, thickness)
    within = within_thermal_reduction(at.relative_pressure, inlet_oil.thermal_loading(speed))
    thickness_m = np.where(np.isfinite(thickness_m) & within, thickness_m, np.nan)
    return thickness_m, thickness_m / contact.roughness_rq_m
