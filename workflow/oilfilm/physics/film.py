"""Thickness of the oil film in a rolling contact, and its ratio to the roughness (lambda).

All quantities are in SI units. Arguments are floats or arrays that broadcast against each other.

`contact_film` gives film and lambda of an oil in a rig's contact. `film_thickness` gives the film
of any contact. Their formulas come first. Lambda has several definitions. In bearing practice it is
the minimum film, reduced by inlet heating, over the combined Rq.

Decides: how thick the film of an oil in a contact is, and lambda.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from oilfilm.base.units import PA_PER_GPA, BoolArray, FloatArray
from oilfilm.physics.contact import Conditions, Contact, Floats, max_hertz_pressure
from oilfilm.physics.oils import Oil

# Outside this range no oil is a liquid lubricant, and the formulas of its properties overflow.
_LIQUID_RANGE_C = (-100.0, 500.0)
# Smallest numerator of phi_T within the range of its fit (assumed).
_SMALLEST_NUMERATOR = 0.1

FilmKind = Literal["minimum", "central"]


# a, b, c, d, e, f of h/Rx = a U^b G^c W^-d (1 - e exp(-f k))
_HAMROCK_DOWSON = {
    "central": (2.69, 0.67, 0.53, 0.067, 0.61, 0.73),
    "minimum": (3.63, 0.68, 0.49, 0.073, 1.0, 0.68),
}


def isothermal_film_thickness(
    inlet_oil: "InletOil", conditions: Conditions, film_kind: FilmKind
) -> FloatArray:
    """Central or minimum film thickness in a fully flooded, isothermal point contact.

        h_c/Rx   = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k))
        h_min/Rx = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k))

        U = eta0 u/(E' Rx),   G = alpha E',   W = w/(E' Rx^2)

    Args:
        inlet_oil: The oil at the inlet temperature.
        conditions: Load (above 0), speed, radius, modulus and ellipticity. The exact ellipticity
            (`contact.ellipticity`) is 1 for a ball on a flat. The authors' fit
            1.0339 (Ry/Rx)^0.636 would thicken the film there by 1 to 2 %.
        film_kind: `central` (h_c), or `minimum` (h_min, at the sides).

    Returns:
        h, in m.

    Validity: full film, fully flooded, steady rolling along x. Fitted to 34 numerical solutions
        with k from 1 to 8 and U up to the order of 1e-11 (both limits not checked against print).
        The rig has U from 2e-11 to 1e-9, so that the formula is extrapolated. Inlet heating is
        left out: see `film_thickness`.

    Reference: B. J. Hamrock and D. Dowson, Isothermal elastohydrodynamic lubrication of point
        contacts, Part III, J. Lubr. Technol. 99 (1977) 264, doi 10.1115/1.3453074.

    Examples:
        20 mm steel ball on a flat, MIL-L-23699 oil at 100 degC; the central film is 0.360 um:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> contact = Conditions(142, 1.5, 25, 100, radius_x_m=0.010, reduced_modulus_pa=221.6e9)
        >>> h = isothermal_film_thickness(oil, contact, "minimum")
        >>> print(f"{h * 1e6:.3f} um")
        0.211 um
    """
    a, b, c, d, e, f = _HAMROCK_DOWSON[film_kind]
    reduced_modulus_pa, radius_x_m = conditions.reduced_modulus_pa, conditions.radius_x_m
    dimensionless_speed = (
        inlet_oil.dynamic_viscosity_pa_s
        * conditions.entrainment_speed_m_s
        / (reduced_modulus_pa * radius_x_m)
    )
    material_parameter = inlet_oil.pressure_viscosity_coefficient_1_pa * reduced_modulus_pa
    dimensionless_load = conditions.load_n / (reduced_modulus_pa * radius_x_m**2)
    side_leakage_factor = 1 - e * np.exp(-f * conditions.ellipticity)
    relative_thickness = (
        a
        * dimensionless_speed**b
        * material_parameter**c
        * dimensionless_load**-d
        * side_leakage_factor
    )
    return np.asarray(relative_thickness * radius_x_m)


def thermal_reduction_factor(
    relative_pressure: Floats, slide_roll_ratio: Floats, thermal_loading: Floats
) -> FloatArray:
    """Thermal reduction of the isothermal film by inlet heating: h = phi_T h_isothermal.

        phi_T = [1 - 13.2 (p0/E') L^0.42] / [1 + 0.213 (1 + 2.23 |S|^0.83) L^0.64]

    Args:
        relative_pressure: Maximum pressure over modulus, p0/E'; 0 leaves the pressure term out.
        slide_roll_ratio: Slide-roll ratio S of either sign.
        thermal_loading: L of `InletOil.thermal_loading`, 0 or more.

    Returns:
        phi_T, 1 where L = 0.

    Validity: an empirical fit, not clipped here. On steel at 1.5 GPa its numerator is negative for
        L above about 300. `is_in_thermal_reduction_range` returns where it is within its range.

    Reference: P. K. Gupta, H. S. Cheng, D. Zhu, N. H. Forster and J. B. Schrand, Viscoelastic
        effects in MIL-L-7808-type lubricant, Part I, Tribol. Trans. 35 (1992) 269.

    Examples:
        MIL-L-23699 oil at 100 degC, 25 m/s and 1.5 GPa:

        >>> phi = thermal_reduction_factor(1.5 / 221.6, np.array([0.0, 0.3]), 0.424)
        >>> phi.round(3)
        array([0.835, 0.766])
    """
    slip_factor = 1 + 2.23 * np.abs(slide_roll_ratio) ** 0.83
    shear_term = 0.213 * slip_factor * thermal_loading**0.64
    return np.asarray(_reduction_numerator(relative_pressure, thermal_loading) / (1 + shear_term))


def is_in_thermal_reduction_range(relative_pressure: Floats, thermal_loading: Floats) -> BoolArray:
    """Whether phi_T is within its range, where its numerator is clearly above zero.

    Outside the range a small or negative film is an artefact of the fit.

    Args:
        relative_pressure: p0/E', as in `thermal_reduction_factor`.
        thermal_loading: L, as in `thermal_reduction_factor`.
    """
    return np.asarray(
        _reduction_numerator(relative_pressure, thermal_loading) >= _SMALLEST_NUMERATOR
    )


def _reduction_numerator(relative_pressure: Floats, thermal_loading: Floats) -> FloatArray:
    """Numerator of phi_T, 1 - 13.2 (p0/E') L^0.42."""
    return np.asarray(1 - 13.2 * relative_pressure * thermal_loading**0.42)


@dataclass(frozen=True)
class InletOil:
    """Properties of an oil at the inlet of a contact that determine its film.

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
    def from_oil(cls, oil: Oil, temperature_c: Floats) -> "InletOil":
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
        """Thermal loading parameter, a measure of the heat by shear in the inlet.

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
        viscosity_times_coefficient = (
            self.dynamic_viscosity_pa_s * self.temperature_viscosity_coefficient_1_k
        )
        return np.asarray(
            viscosity_times_coefficient * entrainment_speed_m_s**2 / self.thermal_conductivity_w_mk
        )


def film_thickness(
    inlet_oil: InletOil, conditions: Conditions, slide_roll_ratio: Floats, film_kind: FilmKind
) -> FloatArray:
    """Film thickness of an oil in a contact: h = phi_T h_isothermal.

    Args:
        inlet_oil: The oil at the inlet temperature.
        conditions: Conditions of the contact. A pressure of 0 leaves out the pressure term of
            phi_T.
        slide_roll_ratio: Slide-roll ratio S.
        film_kind: `minimum` or `central`, as in `isothermal_film_thickness`.

    Returns:
        h, in m; zero or negative outside the range of phi_T.

    Examples:
        MIL-L-23699 oil at 100 degC on a 20 mm ball: 0.2108 um, reduced by 0.766:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> contact = Conditions(142, 1.5, 25, 100, radius_x_m=0.010, reduced_modulus_pa=221.6e9)
        >>> print(f"{film_thickness(oil, contact, 0.3, 'minimum') * 1e6:.3f} um")
        0.161 um
    """
    isothermal_thickness_m = isothermal_film_thickness(inlet_oil, conditions, film_kind)
    thermal_loading = inlet_oil.thermal_loading(conditions.entrainment_speed_m_s)
    relative_pressure = conditions.relative_pressure
    return isothermal_thickness_m * thermal_reduction_factor(
        relative_pressure, slide_roll_ratio, thermal_loading
    )


def contact_film(
    oil: Oil,
    contact: Contact,
    film_kind: FilmKind,
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
        film_kind: As in `film_thickness`.
        load_n: Normal load, in N; from p0 by `contact.load_for_max_hertz_pressure`.
        entrainment_speed_m_s: Mean of the two surface speeds, in m/s.
        inlet_temperature_c: Oil temperature at the inlet, in degC.
        slide_roll_ratio: Slide-roll ratio S.

    Returns:
        Film thickness h, in m, and lambda = h/sigma with the combined Rq sigma. Both have the
        broadcast shape of the arguments. They are NaN where speed or temperature is not possible,
        or where the thermal reduction is outside its range.
    """
    lowest_c, highest_c = _LIQUID_RANGE_C
    speed_m_s = np.where(entrainment_speed_m_s > 0, entrainment_speed_m_s, np.nan)
    is_liquid = (inlet_temperature_c >= lowest_c) & (inlet_temperature_c <= highest_c)
    inlet_oil = InletOil.from_oil(oil, np.where(is_liquid, inlet_temperature_c, np.nan))
    radius_m = np.asarray(contact.radius_m)
    reduced_modulus_pa = contact.reduced_modulus_pa
    conditions = Conditions(
        load_n=load_n,
        max_hertz_pressure_gpa=max_hertz_pressure(load_n, radius_m, reduced_modulus_pa)
        / PA_PER_GPA,
        entrainment_speed_m_s=speed_m_s,
        inlet_temperature_c=inlet_temperature_c,
        radius_x_m=radius_m,
        reduced_modulus_pa=reduced_modulus_pa,
    )
    thickness_m = film_thickness(inlet_oil, conditions, slide_roll_ratio, film_kind)
    thermal_loading = inlet_oil.thermal_loading(speed_m_s)
    is_within_range = is_in_thermal_reduction_range(conditions.relative_pressure, thermal_loading)
    thickness_m = np.where(np.isfinite(thickness_m) & is_within_range, thickness_m, np.nan)
    return thickness_m, thickness_m / contact.roughness_rq_m


def film_viscosity_ratio(
    oil: Oil,
    max_hertz_pressure_gpa: FloatArray,
    inlet_temperature_c: FloatArray,
    temperature_rise_k: FloatArray,
) -> FloatArray:
    """Viscosity of a film at its inlet's temperature over that at a higher one, at mean pressure.

        eta(T) / eta(T + dT),   eta = eta0(T) exp(alpha(T) 2/3 p0)   (Barus 1893)

    Args:
        oil: The oil.
        max_hertz_pressure_gpa: p0, shape (points,).
        inlet_temperature_c: T, shape (points,).
        temperature_rise_k: dT, shape (points,).
    """
    mean_pressure_pa = 2 / 3 * PA_PER_GPA * max_hertz_pressure_gpa
    inlet_oil = InletOil.from_oil(oil, inlet_temperature_c)
    warm_oil = InletOil.from_oil(oil, inlet_temperature_c + temperature_rise_k)
    alpha_difference_1_pa = np.subtract(
        inlet_oil.pressure_viscosity_coefficient_1_pa, warm_oil.pressure_viscosity_coefficient_1_pa
    )
    ratio_at_no_pressure = np.divide(
        inlet_oil.dynamic_viscosity_pa_s, warm_oil.dynamic_viscosity_pa_s
    )
    return ratio_at_no_pressure * np.exp(alpha_difference_1_pa * mean_pressure_pa)
