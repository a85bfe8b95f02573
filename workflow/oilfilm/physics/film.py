"""Thickness of the oil film in a rolling contact, and how far it keeps rough surfaces apart.

All quantities are in SI units. Arguments are floats or arrays that broadcast against each other.

lambda means little unless it is said of what: bearing practice takes the minimum film, thinned by
inlet heating, over the combined Rq.
"""

import numpy as np

from oilfilm.physics.contact import Floats
from oilfilm.units import FloatArray


def central_film_thickness(
    *,
    load_n: Floats,
    entrainment_speed_m_s: Floats,
    dynamic_viscosity_pa_s: Floats,
    pressure_viscosity_coefficient_1_pa: Floats,
    radius_x_m: Floats,
    reduced_modulus_pa: Floats,
    ellipticity: Floats = 1.0,
) -> FloatArray:
    """Film thickness in the centre of a fully flooded, isothermal point contact.

        h_c/Rx = 2.69 U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k))

        U = eta0 u/(E' Rx),   G = alpha E',   W = w/(E' Rx^2)

    Args:
        load_n: Normal load w, in N; above 0.
        entrainment_speed_m_s: Mean u = (u1 + u2)/2 of the two surface speeds, in m/s; 0 or more.
        dynamic_viscosity_pa_s: eta0 at the inlet temperature and ambient pressure, in Pa s.
        pressure_viscosity_coefficient_1_pa: alpha at the inlet temperature, in 1/Pa.
        radius_x_m: Reduced radius Rx in the rolling direction, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        ellipticity: k = a_y/a_x of the contact, exact (`contact.ellipticity`); 1 for a ball on a
            flat, where the authors' fit 1.0339 (Ry/Rx)^0.636 would thicken the film by 1 to 2 %.

    Returns:
        h_c, in m.

    Validity: full film, ample oil, steady rolling along x. Fitted to 34 numerical solutions, of
        k from 1 to 8 and U up to the order of 1e-11 (both limits not checked against print); the
        rig covers U from 2e-11 to 1e-9 and so extrapolates. Heating in the inlet is left out:
        multiply by `thermal_reduction_factor`.

    Reference: B. J. Hamrock and D. Dowson, Isothermal elastohydrodynamic lubrication of point
        contacts, Part III, J. Lubr. Technol. 99 (1977) 264, doi 10.1115/1.3453074.

    Examples:
        20 mm steel ball on a flat, MIL-L-23699 oil at 100 degC:

        >>> h = central_film_thickness(
        ...     load_n=142, entrainment_speed_m_s=25, dynamic_viscosity_pa_s=5.006e-3,
        ...     pressure_viscosity_coefficient_1_pa=1.103e-8, radius_x_m=0.010,
        ...     reduced_modulus_pa=221.6e9)
        >>> print(f"{h * 1e6:.3f} um")
        0.360 um
    """
    u = dynamic_viscosity_pa_s * entrainment_speed_m_s / (reduced_modulus_pa * radius_x_m)
    g = pressure_viscosity_coefficient_1_pa * reduced_modulus_pa
    w = load_n / (reduced_modulus_pa * radius_x_m**2)
    side_leakage = 1 - 0.61 * np.exp(-0.73 * ellipticity)
    return np.asarray(2.69 * u**0.67 * g**0.53 * w**-0.067 * side_leakage * radius_x_m)


def minimum_film_thickness(
    *,
    load_n: Floats,
    entrainment_speed_m_s: Floats,
    dynamic_viscosity_pa_s: Floats,
    pressure_viscosity_coefficient_1_pa: Floats,
    radius_x_m: Floats,
    reduced_modulus_pa: Floats,
    ellipticity: Floats = 1.0,
) -> FloatArray:
    """Smallest film thickness, at the sides of a fully flooded, isothermal point contact.

        h_min/Rx = 3.63 U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k))

    U, G, W, arguments and validity are those of `central_film_thickness`.

    Args:
        load_n: Normal load w, in N; above 0.
        entrainment_speed_m_s: Mean u = (u1 + u2)/2 of the two surface speeds, in m/s; 0 or more.
        dynamic_viscosity_pa_s: eta0 at the inlet temperature and ambient pressure, in Pa s.
        pressure_viscosity_coefficient_1_pa: alpha at the inlet temperature, in 1/Pa.
        radius_x_m: Reduced radius Rx in the rolling direction, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        ellipticity: k = a_y/a_x of the contact, exact (`contact.ellipticity`); 1 for a ball on a
            flat, where the authors' fit 1.0339 (Ry/Rx)^0.636 would thicken the film by 1 to 2 %.

    Returns:
        h_min, in m.

    Reference: B. J. Hamrock and D. Dowson, Isothermal elastohydrodynamic lubrication of point
        contacts, Part III, J. Lubr. Technol. 99 (1977) 264, doi 10.1115/1.3453074.

    Examples:
        20 mm steel ball on a flat, MIL-L-23699 oil at 100 degC:

        >>> h = minimum_film_thickness(
        ...     load_n=142, entrainment_speed_m_s=25, dynamic_viscosity_pa_s=5.006e-3,
        ...     pressure_viscosity_coefficient_1_pa=1.103e-8, radius_x_m=0.010,
        ...     reduced_modulus_pa=221.6e9)
        >>> print(f"{h * 1e6:.3f} um")
        0.211 um
    """
    u = dynamic_viscosity_pa_s * entrainment_speed_m_s / (reduced_modulus_pa * radius_x_m)
    g = pressure_viscosity_coefficient_1_pa * reduced_modulus_pa
    w = load_n / (reduced_modulus_pa * radius_x_m**2)
    side_leakage = 1 - np.exp(-0.68 * ellipticity)
    return np.asarray(3.63 * u**0.68 * g**0.49 * w**-0.073 * side_leakage * radius_x_m)


def thermal_loading_parameter(
    *,
    entrainment_speed_m_s: Floats,
    dynamic_viscosity_pa_s: Floats,
    temperature_viscosity_coefficient_1_k: Floats,
    thermal_conductivity_w_mk: Floats,
) -> FloatArray:
    """How strongly shear in the inlet heats the oil there (dimensionless).

        L = eta0 beta u^2 / k_oil

    Args:
        entrainment_speed_m_s: Mean u = (u1 + u2)/2 of the two surface speeds, in m/s.
        dynamic_viscosity_pa_s: eta0 at the inlet temperature, in Pa s.
        temperature_viscosity_coefficient_1_k: beta = -d ln(eta0)/dT, in 1/K.
        thermal_conductivity_w_mk: k_oil at the inlet temperature, in W/(m K).

    Returns:
        L.

    Reference: P. K. Gupta, H. S. Cheng, D. Zhu, N. H. Forster and J. B. Schrand, Viscoelastic
        effects in MIL-L-7808-type lubricant, Part I, Tribol. Trans. 35 (1992) 269.

    Examples:
        MIL-L-23699 oil at 100 degC and 25 m/s:

        >>> loading = thermal_loading_parameter(
        ...     entrainment_speed_m_s=25, dynamic_viscosity_pa_s=5.006e-3,
        ...     temperature_viscosity_coefficient_1_k=0.01996,
        ...     thermal_conductivity_w_mk=0.1472)
        >>> print(f"{loading:.3f}")
        0.424
    """
    heating = dynamic_viscosity_pa_s * temperature_viscosity_coefficient_1_k
    return np.asarray(heating * entrainment_speed_m_s**2 / thermal_conductivity_w_mk)


def thermal_reduction_factor(
    *,
    max_hertz_pressure_pa: Floats,
    reduced_modulus_pa: Floats,
    slide_roll_ratio: Floats,
    thermal_loading: Floats,
) -> FloatArray:
    """By how much inlet heating thins the isothermal film: h = phi_T h_isothermal.

        phi_T = [1 - 13.2 (p0/E') L^0.42] / [1 + 0.213 (1 + 2.23 |S|^0.83) L^0.64]

    Args:
        max_hertz_pressure_pa: Maximum pressure p0, in Pa.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        slide_roll_ratio: S; which of the two surfaces is the faster one makes no difference.
        thermal_loading: L of `thermal_loading_parameter`, 0 or more.

    Returns:
        phi_T, 1 where L = 0.

    Validity: an empirical fit, not clipped here. Its numerator turns negative at L above about
        300 at 1.5 GPa on steel, so values near or below zero lie outside the fit.

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
    heating = 13.2 * (max_hertz_pressure_pa / reduced_modulus_pa) * thermal_loading**0.42
    sliding = 0.213 * (1 + 2.23 * np.abs(slide_roll_ratio) ** 0.83) * thermal_loading**0.64
    return np.asarray((1 - heating) / (1 + sliding))


def rq_from_ra(ra_m: Floats) -> FloatArray:
    """Root-mean-square roughness where only the mean roughness is known.

        Rq = 1.25 Ra

    This is a convention, not a law: a Gaussian profile has sqrt(pi/2) = 1.2533, a sine wave 1.11,
    a plateau-honed one more.

    Args:
        ra_m: Arithmetic mean roughness Ra, in m.

    Returns:
        Rq, in m.

    Examples:
        The rig's root-sum-square Ra of 0.0172 um (rig page):

        >>> print(f"{rq_from_ra(0.0172e-6) * 1e6:.4f} um")
        0.0215 um
    """
    return np.asarray(1.25 * ra_m)


def combined_roughness(rq_1_m: Floats, rq_2_m: Floats) -> FloatArray:
    """Roughness of two surfaces facing each other, their profiles being independent.

        sigma = sqrt(Rq1^2 + Rq2^2)

    Args:
        rq_1_m: Root-mean-square roughness of the first surface, in m.
        rq_2_m: The same of the second surface.

    Returns:
        sigma, in m. Ra values in give the combined Ra.

    Examples:
        Ball and disc of the rig, Ra 0.014 and 0.010 um, have 0.0172 um together (rig page):

        >>> print(f"{combined_roughness(0.014e-6, 0.010e-6) * 1e6:.4f} um")
        0.0172 um
    """
    return np.hypot(rq_1_m, rq_2_m)


def lambda_ratio(film_thickness_m: Floats, combined_roughness_m: Floats) -> FloatArray:
    """Film thickness over combined roughness; above 3 the surfaces are taken as kept apart.

        lambda = h / sigma

    Args:
        film_thickness_m: h, in m; say whether minimum or central, and thermally reduced or not.
        combined_roughness_m: sigma of `combined_roughness`, in m; say whether of Rq or Ra.

    Returns:
        lambda.

    Examples:
        The rig's worst corner without thermal reduction, 0.092 um over 0.0215 um (physics.md):

        >>> print(f"{lambda_ratio(0.092e-6, 0.0215e-6):.1f}")
        4.3
    """
    return np.asarray(film_thickness_m / combined_roughness_m)
