"""Thickness of the oil film in a rolling contact, and its ratio to the roughness (lambda).

All quantities are in SI units. Arguments are floats or arrays that broadcast against each other.

`contact_film` gives film and lambda of an oil in a rig's contact. `film_thickness` gives the film
of any contact. The formulas behind both come first. A lambda needs its definition: bearing
practice takes the minimum film, reduced by inlet heating, over the combined Rq.

Decides: how thick the film of an oil in a contact is, and lambda.
"""

from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np

from oilfilm.physics.contact import Floats, max_hertz_pressure
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.units import BoolArray, FloatArray

# Outside this range no oil is a liquid lubricant, and the formulas of its properties overflow.
_OIL_TEMPERATURES_C = (-100.0, 500.0)

Thickness = Literal["minimum", "central"]


# a, b, c, d, e, f of h/Rx = a U^b G^c W^-d (1 - e exp(-f k))
_HAMROCK_DOWSON = {
    "central": (2.69, 0.67, 0.53, 0.067, 0.61, 0.73),
    "minimum": (3.63, 0.68, 0.49, 0.073, 1.0, 0.68),
}


def isothermal_film_thickness(
    thickness: Thickness,
    *,
    load_n: Floats,
    entrainment_speed_m_s: Floats,
    dynamic_viscosity_pa_s: Floats,
    pressure_viscosity_coefficient_1_pa: Floats,
    radius_x_m: Floats,
    reduced_modulus_pa: Floats,
    ellipticity: Floats = 1.0,
) -> FloatArray:
    """Film thickness in a fully flooded, isothermal point contact: in its centre, or the smallest.

        h_c/Rx   = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k))
        h_min/Rx = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k))

        U = eta0 u/(E' Rx),   G = alpha E',   W = w/(E' Rx^2)

    Args:
        thickness: `central` (h_c), or `minimum` (h_min, at the sides).
        load_n: Normal load w, in N; above 0.
        entrainment_speed_m_s: Mean u = (u1 + u2)/2 of the two surface speeds, in m/s; 0 or more.
        dynamic_viscosity_pa_s: eta0 at the inlet temperature and ambient pressure, in Pa s.
        pressure_viscosity_coefficient_1_pa: alpha at the inlet temperature, in 1/Pa.
        radius_x_m: Reduced radius Rx in the rolling direction, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        ellipticity: k = a_y/a_x of the contact, exact (`contact.ellipticity`); 1 for a ball on a
            flat, where the authors' fit 1.0339 (Ry/Rx)^0.636 would thicken the film by 1 to 2 %.

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

        >>> h = isothermal_film_thickness(
        ...     "minimum", load_n=142, entrainment_speed_m_s=25, dynamic_viscosity_pa_s=5.006e-3,
        ...     pressure_viscosity_coefficient_1_pa=1.103e-8, radius_x_m=0.010,
        ...     reduced_modulus_pa=221.6e9)
        >>> print(f"{h * 1e6:.3f} um")
        0.211 um
    """
    factor, speed_power, oil_power, load_power, leakage, leakage_rate = _HAMROCK_DOWSON[thickness]
    u = dynamic_viscosity_pa_s * entrainment_speed_m_s / (reduced_modulus_pa * radius_x_m)
    g = pressure_viscosity_coefficient_1_pa * reduced_modulus_pa
    w = load_n / (reduced_modulus_pa * radius_x_m**2)
    side_leakage = 1 - leakage * np.exp(-leakage_rate * ellipticity)
    relative = factor * u**speed_power * g**oil_power * w**-load_power * side_leakage
    return np.asarray(relative * radius_x_m)


@dataclass(frozen=True)
class ThermalReductionFit:
    """Constants of the fitted formula of `thermal_reduction_factor`, all dimensionless."""

    pressure_factor: float = 13.2
    pressure_power: float = 0.42
    shear_factor: float = 0.213
    shear_power: float = 0.64
    slip_factor: float = 2.23
    slip_power: float = 0.83
    least_numerator: float = 0.1  # assumed: nearer to zero the fit is beyond its range


THERMAL_REDUCTION_FIT = ThermalReductionFit()


def thermal_reduction_factor(
    *,
    max_hertz_pressure_pa: Floats,
    reduced_modulus_pa: Floats,
    slide_roll_ratio: Floats,
    thermal_loading: Floats,
) -> FloatArray:
    """Thermal reduction of the isothermal film by inlet heating: h = phi_T h_isothermal.

        phi_T = [1 - 13.2 (p0/E') L^0.42] / [1 + 0.213 (1 + 2.23 |S|^0.83) L^0.64]

    Args:
        max_hertz_pressure_pa: Maximum pressure p0, in Pa; 0 leaves the pressure term out.
        reduced_modulus_pa: E' = 2 E*, in Pa.
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

        >>> phi = thermal_reduction_factor(
        ...     max_hertz_pressure_pa=1.5e9, reduced_modulus_pa=221.6e9,
        ...     slide_roll_ratio=np.array([0.0, 0.3]), thermal_loading=0.424)
        >>> phi.round(3)
        array([0.835, 0.766])
    """
    fit = THERMAL_REDUCTION_FIT
    numerator = _numerator(max_hertz_pressure_pa, reduced_modulus_pa, thermal_loading)
    slip = 1 + fit.slip_factor * np.abs(slide_roll_ratio) ** fit.slip_power
    shear = fit.shear_factor * slip * thermal_loading**fit.shear_power
    return np.asarray(numerator / (1 + shear))


def within_thermal_reduction(
    *, max_hertz_pressure_pa: Floats, reduced_modulus_pa: Floats, thermal_loading: Floats
) -> BoolArray:
    """Whether phi_T is used within its range: its numerator is not near or below zero.

    Beyond, a small or negative film is that of the formula, and says nothing about the contact.

    Args:
        max_hertz_pressure_pa: As in `thermal_reduction_factor`.
        reduced_modulus_pa: As there.
        thermal_loading: As there.
    """
    numerator = _numerator(max_hertz_pressure_pa, reduced_modulus_pa, thermal_loading)
    return np.asarray(numerator >= THERMAL_REDUCTION_FIT.least_numerator)


def _numerator(
    max_hertz_pressure_pa: Floats, reduced_modulus_pa: Floats, thermal_loading: Floats
) -> FloatArray:
    """1 - 13.2 (p0/E') L^0.42."""
    fit = THERMAL_REDUCTION_FIT
    relative_pressure = max_hertz_pressure_pa / reduced_modulus_pa
    heating = fit.pressure_factor * relative_pressure * thermal_loading**fit.pressure_power
    return np.asarray(1 - heating)


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

    def __getitem__(self, index: Any) -> "InletOil":
        """The properties indexed as arrays are."""
        return InletOil(*(np.asarray(getattr(self, field.name))[index] for field in fields(self)))

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
    oil: InletOil,
    *,
    thickness: Thickness,
    thermal_reduction: bool = True,
    load_n: Floats,
    max_hertz_pressure_pa: Floats,
    entrainment_speed_m_s: Floats,
    slide_roll_ratio: Floats,
    radius_x_m: Floats,
    reduced_modulus_pa: Floats,
    ellipticity: Floats = 1.0,
) -> FloatArray:
    """Film thickness of an oil in a contact: h = phi_T h_isothermal.

    Args:
        oil: The oil at the inlet temperature.
        thickness: `minimum` or `central`, as in `isothermal_film_thickness`.
        thermal_reduction: Whether phi_T of `thermal_reduction_factor` applies.
        load_n: Normal load, in N; above 0.
        max_hertz_pressure_pa: Maximum pressure, in Pa; 0 leaves out the pressure term of phi_T.
        entrainment_speed_m_s: Mean of the two surface speeds, in m/s.
        slide_roll_ratio: S.
        radius_x_m: Reduced radius in the rolling direction, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        ellipticity: a_y/a_x of the contact.

    Returns:
        h, in m; zero or negative outside the range of phi_T.

    Examples:
        MIL-L-23699 oil at 100 degC on a 20 mm ball: 0.2108 um, reduced by 0.766:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> h = film_thickness(
        ...     oil, thickness="minimum", load_n=142, max_hertz_pressure_pa=1.5e9,
        ...     entrainment_speed_m_s=25, slide_roll_ratio=0.3, radius_x_m=0.010,
        ...     reduced_modulus_pa=221.6e9)
        >>> print(f"{h * 1e6:.3f} um")
        0.161 um
    """
    isothermal = isothermal_film_thickness(
        thickness,
        load_n=load_n,
        entrainment_speed_m_s=entrainment_speed_m_s,
        dynamic_viscosity_pa_s=oil.dynamic_viscosity_pa_s,
        pressure_viscosity_coefficient_1_pa=oil.pressure_viscosity_coefficient_1_pa,
        radius_x_m=radius_x_m,
        reduced_modulus_pa=reduced_modulus_pa,
        ellipticity=ellipticity,
    )
    if not thermal_reduction:
        return isothermal
    return isothermal * thermal_reduction_factor(
        max_hertz_pressure_pa=max_hertz_pressure_pa,
        reduced_modulus_pa=reduced_modulus_pa,
        slide_roll_ratio=slide_roll_ratio,
        thermal_loading=oil.thermal_loading(entrainment_speed_m_s),
    )


def contact_film(
    oil: Oil,
    contact: Contact,
    *,
    thickness: Thickness,
    thermal_reduction: bool,
    roughness: Literal["rq", "ra"],
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
        thermal_reduction: As in `film_thickness`.
        roughness: Which roughness lambda refers to.
        load_n: Normal load, in N (`contact.load_for_max_hertz_pressure` where p0 is known).
        entrainment_speed_m_s: Mean of the two surface speeds, in m/s.
        inlet_temperature_c: Oil temperature at the inlet, in degC.
        slide_roll_ratio: S.

    Returns:
        Film thickness h, in m, and lambda = h/sigma, sigma the combined roughness, of the
        arguments' broadcast shape. NaN where speed or temperature is not possible, or where the
        thermal reduction is used outside its range.
    """
    low, high = _OIL_TEMPERATURES_C
    speed = np.where(entrainment_speed_m_s > 0, entrainment_speed_m_s, np.nan)
    is_liquid = (inlet_temperature_c >= low) & (inlet_temperature_c <= high)
    inlet_oil = InletOil.of(oil, np.where(is_liquid, inlet_temperature_c, np.nan))
    pressure = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
    thickness_m = film_thickness(
        inlet_oil,
        thickness=thickness,
        thermal_reduction=thermal_reduction,
        load_n=load_n,
        max_hertz_pressure_pa=pressure,
        entrainment_speed_m_s=speed,
        slide_roll_ratio=slide_roll_ratio,
        radius_x_m=contact.radius_m,
        reduced_modulus_pa=contact.reduced_modulus_pa,
    )
    within = within_thermal_reduction(
        max_hertz_pressure_pa=pressure,
        reduced_modulus_pa=contact.reduced_modulus_pa,
        thermal_loading=inlet_oil.thermal_loading(speed),
    )
    is_film = np.isfinite(thickness_m) & (within | (not thermal_reduction))
    thickness_m = np.where(is_film, thickness_m, np.nan)
    return thickness_m, thickness_m / contact.roughness_m(roughness)
