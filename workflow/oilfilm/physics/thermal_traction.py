"""Traction of an oil film by thermal elastohydrodynamics: shear thinning, limiting stress, heat.

Traction is calculated from the properties of an oil, without a fit. The rig twin can use it as
truth, and laws use its stresses. The contact has one film thickness. Each point of the contact has
its own pressure, stress and temperature. The traction of the contact is the mean over its points.
All quantities are in SI units, temperatures in degC. Arguments are floats or arrays that broadcast.

Volumes and pages of the references are not checked against print. The tests compare each formula
with its limits and with conduction solved numerically.

Decides: traction of an oil from its properties (thermal elastohydrodynamics), the truth of the
campaign `thermal`; the temperature of the film of a measured point.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from oilfilm.base.units import PA_PER_GPA, FloatArray
from oilfilm.physics.contact import (
    Conditions,
    Floats,
    contact_radius,
    creep_slope,
    load_for_max_hertz_pressure,
)
from oilfilm.physics.film import InletOil, film_thickness
from oilfilm.physics.oils import Oil

# Highest temperature of a film. At higher temperatures, properties extrapolated from their tables
# by straight lines would be negative.
_HIGHEST_FILM_TEMPERATURE_C = 800.0
# Quadrature nodes of the mean over a contact. mu is within 0.01 % up to 2.5 GPa and 200 m/s.
_RADIAL_NODE_COUNT = 12


@dataclass(frozen=True, kw_only=True)
class ThermalEhlConstants:
    """Constants of film and bodies that are not in an oil's file.

    Attributes:
        eyring_stress_pa: Stress tau_E above which the oil is shear-thinning, in Pa.
        limiting_stress_ratio: Limiting stress over pressure, Lambda, at the reference temperature.
        limiting_stress_reference_c: Reference temperature of Lambda, in degC.
        limiting_stress_decay_1_k: Relative decrease of Lambda per kelvin of the film, in 1/K.
        solid_conductivity_w_mk: Thermal conductivity of both bodies, in W/(m K).
        solid_volumetric_heat_j_m3k: Density times specific heat of both bodies, in J/(m3 K).
    """

    eyring_stress_pa: float
    limiting_stress_ratio: float
    limiting_stress_reference_c: float
    limiting_stress_decay_1_k: float
    solid_conductivity_w_mk: float
    solid_volumetric_heat_j_m3k: float


@dataclass(frozen=True)
class SlidingFilm:
    """Result of `sliding_film`; arrays of the broadcast shape of the arguments.

    Attributes:
        shear_stress_pa: Shear stress tau, in Pa.
        shear_rate_1_s: Shear rate of the film, S_f U/h, without the creep of the bodies, in 1/s.
        film_thickness_m: Central film thickness, reduced by inlet heating, in m. It is the same at
            all points of a contact, and has no axis of the pressure.
        surface_temperature_c: Mean temperature of the two surfaces, in degC.
        film_temperature_c: Mean temperature across the film, in degC.
    """

    shear_stress_pa: FloatArray
    shear_rate_1_s: FloatArray
    film_thickness_m: FloatArray
    surface_temperature_c: FloatArray
    film_temperature_c: FloatArray


def barus_viscosity(
    dynamic_viscosity_pa_s: Floats, pressure_viscosity_coefficient_1_pa: Floats, pressure_pa: Floats
) -> FloatArray:
    """Viscosity at a pressure.

        eta = eta0 exp(alpha p)

    Args:
        dynamic_viscosity_pa_s: Viscosity eta0 at ambient pressure, in Pa s.
        pressure_viscosity_coefficient_1_pa: Pressure-viscosity coefficient alpha, in 1/Pa.
        pressure_pa: Pressure p, in Pa.

    Returns:
        eta, in Pa s.

    Validity: up to about 0.5 GPa, far too high above. There the stress of a film depends on ln(eta)
        at most, and at higher stresses on the limiting stress alone.

    Reference: C. Barus, Am. J. Sci. 45 (1893) 87.

    Examples:
        MIL-L-23699 oil at 100 degC and 1 GPa, by hand 5.006e-3 exp(11.03) Pa s:

        >>> print(f"{barus_viscosity(5.006e-3, 1.103e-8, 1e9):.0f} Pa s")
        309 Pa s
    """
    return np.asarray(
        dynamic_viscosity_pa_s * np.exp(pressure_viscosity_coefficient_1_pa * pressure_pa)
    )


def eyring_shear_stress(
    viscosity_pa_s: Floats, shear_rate_1_s: Floats, eyring_stress_pa: Floats
) -> FloatArray:
    """Shear stress of a film that is shear-thinning by thermal activation.

        tau = tau_E asinh(eta gamma/tau_E)

    Args:
        viscosity_pa_s: Viscosity eta at low shear, at the pressure and temperature of the film, in
            Pa s.
        shear_rate_1_s: Shear rate gamma, in 1/s.
        eyring_stress_pa: Eyring stress tau_E, in Pa.

    Returns:
        tau, in Pa. It is eta gamma where that is small compared with tau_E.

    Reference: H. Eyring, J. Chem. Phys. 4 (1936) 283; K. L. Johnson and J. L. Tevaarwerk, Proc. R.
        Soc. Lond. A 356 (1977) 215.

    Examples:
        At eta gamma = sinh(1) tau_E the stress is tau_E:

        >>> print(f"{eyring_shear_stress(np.sinh(1.0), 5e6, 5e6) / 1e6:.3f} MPa")
        5.000 MPa
    """
    newtonian_stress_pa = viscosity_pa_s * shear_rate_1_s
    return np.asarray(eyring_stress_pa * np.arcsinh(newtonian_stress_pa / eyring_stress_pa))


def limiting_stress(
    pressure_pa: Floats, temperature_c: Floats, ehl_constants: ThermalEhlConstants
) -> FloatArray:
    """Limiting shear stress of a film.

        tau_L = Lambda p exp(-b (T - T_r))

    The stress is proportional to pressure, as usual. It is known to decrease with temperature. The
    exponential form is chosen because it keeps the stress above zero.

    Args:
        pressure_pa: Pressure p, in Pa.
        temperature_c: Temperature T of the film, in degC.
        ehl_constants: Lambda at the reference temperature T_r, and its decay b.

    Returns:
        tau_L, in Pa.

    Reference: S. Bair and W. O. Winer, J. Lubr. Technol. 101 (1979) 251, for the proportionality to
        pressure.
    """
    below_reference_k = ehl_constants.limiting_stress_reference_c - np.asarray(temperature_c)
    temperature_factor = np.exp(ehl_constants.limiting_stress_decay_1_k * below_reference_k)
    return np.asarray(ehl_constants.limiting_stress_ratio * pressure_pa * temperature_factor)


def limited_stress(stress_pa: Floats, limiting_stress_pa: Floats) -> FloatArray:
    """Shear stress with a smooth transition to its limit.

        tau = tau_L [1 - exp(-tau_0/tau_L)]

    Args:
        stress_pa: Stress tau_0 without a limit, in Pa, 0 or more.
        limiting_stress_pa: Limiting stress tau_L, in Pa.

    Returns:
        tau, in Pa. It tends to tau_0 far below tau_L, and to tau_L far above.

    Reference: S. Bair and W. O. Winer, J. Lubr. Technol. 101 (1979) 258, the exponential form.

    Examples:
        Far below the limit, at tau_0 = tau_L (1 - 1/e of the limit), and far above:

        >>> limited_stress(np.array([1e3, 50e6, 1e12]), 50e6) / 50e6
        array([1.99998000e-05, 6.32120559e-01, 1.00000000e+00])
    """
    return np.asarray(-limiting_stress_pa * np.expm1(-np.asarray(stress_pa) / limiting_stress_pa))


def flash_temperature_rise(
    heat_flux_w_m2: Floats,
    contact_radius_m: Floats,
    speed_m_s: Floats,
    conductivity_w_mk: Floats,
    volumetric_heat_j_m3k: Floats,
) -> FloatArray:
    """Mean temperature rise of a surface under a circular heat source that moves fast.

        dT = 0.974 q sqrt(a/(k rho c V))

    With the total heat Q = pi a^2 q and the diffusivity chi this is Archard's
    0.31 (Q/(k a)) sqrt(chi/(V a)).

    Args:
        heat_flux_w_m2: Heat flux q into this surface, uniform over the circle, in W/m2.
        contact_radius_m: Radius a, in m.
        speed_m_s: Speed V of the surface relative to the source, in m/s.
        conductivity_w_mk: Conductivity k of the body, in W/(m K).
        volumetric_heat_j_m3k: Volumetric heat capacity rho c of the body, in J/(m3 K).

    Returns:
        dT, in K.

    Validity: V a rho c/(2 k) above 5. It is 88 at 20 m/s and 0.8 GPa, and increases with both.

    Reference: J. C. Jaeger, J. Proc. R. Soc. N.S.W. 76 (1942) 203; J. F. Archard, Wear 2 (1959)
        438.

    Examples:
        20 mm steel ball at 1.5 GPa and 25 m/s, half of 20 MPa times 1.25 m/s; by hand, with
        Archard's factor, 0.31 pi 12.5e6 sqrt(0.212e-3/(46 * 3.6e6 * 25)) K:

        >>> rise = flash_temperature_rise(
        ...     12.5e6, contact_radius_m=0.212e-3, speed_m_s=25, conductivity_w_mk=46,
        ...     volumetric_heat_j_m3k=3.6e6)
        >>> print(f"{rise:.2f} K")
        2.75 K
    """
    # Mean temperature over a circle under a fast, uniform source. The mean over a chord is
    # q (4/3) sqrt(chord/(pi k rho c V)); the factor is the integral over all chords.
    factor = 8 * np.sqrt(2) / (3 * np.pi**1.5) * scipy.special.beta(1 / 2, 7 / 4)
    k_rho_c_v = conductivity_w_mk * volumetric_heat_j_m3k * speed_m_s
    return np.asarray(factor * heat_flux_w_m2 * np.sqrt(contact_radius_m / k_rho_c_v))


def film_temperature_rise(
    heat_flux_w_m2: Floats, film_thickness_m: Floats, conductivity_w_mk: Floats
) -> FloatArray:
    """Rise of a film's mean temperature above its surfaces, with heat loss by conduction alone.

        dT = q h/(12 k)

    Heat that is uniform across the film and leaves through both surfaces gives a parabola of
    temperature. This is its mean. The rise in the middle of the film is q h/(8 k).

    Args:
        heat_flux_w_m2: Heat q generated in the film, in W per m2 of contact.
        film_thickness_m: Film thickness h, in m.
        conductivity_w_mk: Conductivity k of the oil, in W/(m K).

    Returns:
        dT, in K.

    Validity: the time of the oil in the contact is long compared with h^2 rho c/(pi^2 k). It is
        five times as long in cold films of 0.6 um at 200 m/s, and longer elsewhere.

    Reference: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, Oxford (1959), 3.14.

    Examples:
        20 MPa times 1.25 m/s in 0.4 um of oil, by hand 25e6 * 0.4e-6/(12 * 0.147) K:

        >>> rise = film_temperature_rise(25e6, film_thickness_m=0.4e-6, conductivity_w_mk=0.147)
        >>> print(f"{rise:.2f} K")
        5.67 K
    """
    return np.asarray(heat_flux_w_m2 * film_thickness_m / (12 * conductivity_w_mk))


def mean_film_temperature_rise(
    inlet_oil: InletOil,
    conditions: Conditions,
    traction_coefficient: Floats,
    slide_roll_ratio: Floats,
    solid_conductivity_w_mk: float,
    solid_volumetric_heat_j_m3k: float,
) -> FloatArray:
    """Mean temperature of the film above the inlet temperature, by its friction heat.

        q = |mu| p_mean |S| u,   p_mean = 2/3 p0
        dT = flash(q/2), mean of both surfaces, + q h_c/(12 k_oil)

    Args:
        inlet_oil: The oil at the inlet temperature.
        conditions: Conditions of the contact.
        traction_coefficient: Measured mu.
        slide_roll_ratio: Slide-roll ratio S.
        solid_conductivity_w_mk: Conductivity of both bodies, in W/(m K).
        solid_volumetric_heat_j_m3k: Density times specific heat of both bodies, in J/(m3 K).

    Returns:
        dT, in K.

    Validity: circular contact, half of the heat into each body, uniform heat, |S| below 2 (both
        surfaces roll on); and that of `flash_temperature_rise` and `film_temperature_rise`.

    Reference: J. F. Archard, Wear 2 (1959) 438, for the surfaces; H. S. Carslaw and J. C. Jaeger,
        Conduction of Heat in Solids (1959), 3.14, for the film.

    Examples:
        MIL-L-23699 oil at 100 degC, 1.5 GPa, 25 m/s, S = 0.05, mu = 0.02: 20 MPa times 1.25 m/s is
        25 MW/m2, with 2.75 K in the surfaces and 4.17 K in 0.295 um of oil:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> contact = Conditions(142, 1.5, 25, 100, radius_x_m=0.010, reduced_modulus_pa=221.6e9)
        >>> print(f"{mean_film_temperature_rise(oil, contact, 0.02, 0.05, 46, 3.6e6):.1f} K")
        6.9 K
    """
    speed_m_s = conditions.entrainment_speed_m_s
    mean_pressure_pa = 2 / 3 * conditions.max_hertz_pressure_gpa * PA_PER_GPA
    sliding_m_s = np.abs(slide_roll_ratio) * speed_m_s
    heat_flux_w_m2 = np.abs(traction_coefficient) * mean_pressure_pa * sliding_m_s
    radius_m = contact_radius(
        conditions.load_n, conditions.radius_x_m, conditions.reduced_modulus_pa
    )

    def surface_rise(surface_speed_m_s: FloatArray) -> FloatArray:
        """Rise (K) of a surface of this speed, which takes half of the heat."""
        return flash_temperature_rise(
            heat_flux_w_m2 / 2,
            radius_m,
            surface_speed_m_s,
            solid_conductivity_w_mk,
            solid_volumetric_heat_j_m3k,
        )

    first_surface_rise_k = surface_rise(speed_m_s * (1 - slide_roll_ratio / 2))
    second_surface_rise_k = surface_rise(speed_m_s * (1 + slide_roll_ratio / 2))
    thickness_m = film_thickness(inlet_oil, conditions, slide_roll_ratio, "central")
    film_rise_k = film_temperature_rise(
        heat_flux_w_m2, thickness_m, inlet_oil.thermal_conductivity_w_mk
    )
    return (first_surface_rise_k + second_surface_rise_k) / 2 + film_rise_k


def film_stress(
    oil: Oil,
    ehl_constants: ThermalEhlConstants,
    pressure_pa: FloatArray,
    film_temperature_c: FloatArray,
    shear_rate_1_s: FloatArray,
) -> FloatArray:
    """Shear stress of a film with a given temperature. It decreases with temperature.

        tau = limited_stress(eyring_stress(eta(p, T), gamma), limiting_stress(p, T))

    Args:
        oil: The oil. Its viscosity and pressure-viscosity coefficient are taken at T.
        ehl_constants: Eyring stress and limiting stress.
        pressure_pa: Pressure p, in Pa.
        film_temperature_c: Temperature T of the film, in degC.
        shear_rate_1_s: Shear rate gamma, in 1/s.

    Returns:
        tau, in Pa.
    """
    viscosity_pa_s = barus_viscosity(
        oil.dynamic_viscosity_pa_s(film_temperature_c),
        oil.pressure_viscosity_coefficient_1_pa(film_temperature_c),
        pressure_pa,
    )
    limit_pa = limiting_stress(pressure_pa, film_temperature_c, ehl_constants)
    thinned_stress_pa = eyring_shear_stress(
        viscosity_pa_s, shear_rate_1_s, ehl_constants.eyring_stress_pa
    )
    return limited_stress(thinned_stress_pa, limit_pa)


def sliding_film(
    oil: Oil,
    ehl_constants: ThermalEhlConstants,
    conditions: Conditions,
    pressure_pa: Floats,
    slide_roll_ratio: Floats,
    semi_axis_x_m: Floats,
) -> SlidingFilm:
    """Film at a point of a contact, heated by its own friction.

        tau   = film_stress(p, T, gamma),   gamma = S_f U/h
        T     = T_inlet + dT_flash(tau S_f U/2) + dT_film(tau S_f U)
        S_f   = S - tau/(K p),   K = creep_slope of the bodies
        h     = phi_T h_c

    The slip S_f of the film and the creep of the bodies are in series at every point. The stiffness
    of a point is proportional to its pressure. That distribution is OURS; the slope of the contact
    at small slip is Kalker's. The stress decreases with the temperature and with the creep, and
    both increase with the stress. Hence there is exactly one solution, found by bracketing.

    Args:
        oil: The oil. Viscosity and pressure-viscosity coefficient are taken at the temperature of
            the film, the conductivity at that of the inlet.
        ehl_constants: Stresses, and thermal properties of the bodies.
        conditions: Conditions of the contact, with speed and pressure above 0. The bodies far from
            the contact have the inlet temperature.
        pressure_pa: Pressure p at the point, in Pa.
        slide_roll_ratio: Slide-roll ratio S at the point, 0 or more.
        semi_axis_x_m: Semi-axis of the contact in the rolling direction, in m.

    Returns:
        The film; NaN where it would be hotter than 800 degC.

    Validity: full film and small S. Both surfaces are heated as if they moved at U, which is 1 %
        off at S = 0.3. A point is heated as in a contact with uniform flux, by the mean over the
        area. The thermal reduction phi_T is the fit of Gupta et al. without its pressure term,
        which would make films negative at 200 m/s. Left out: heat carried by the oil, heat of
        compression, elastic strain of the film, effect of pressure on conductivity. Good for the
        dependence of traction on its conditions, not for the level of a particular oil.

    References: K. L. Johnson and J. L. Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215; those of
    the functions in this module and in `film`.
    """
    inlet_oil = InletOil.from_oil(oil, conditions.inlet_temperature_c)
    inlet_c = conditions.inlet_temperature_c
    speed_m_s = conditions.entrainment_speed_m_s
    # without the pressure term, see Validity
    conditions_without_pressure = replace(conditions, max_hertz_pressure_gpa=np.zeros(()))
    film_thickness_m = film_thickness(
        inlet_oil, conditions_without_pressure, slide_roll_ratio, "central"
    )
    sliding_m_s = np.asarray(slide_roll_ratio) * speed_m_s
    # Both rises are in kelvin per pascal of shear stress, as they are proportional to the heat. The
    # chords of an ellipse are those of a circle with the semi-axis along the rolling direction.
    flash_rise_k_per_pa = flash_temperature_rise(
        sliding_m_s / 2,
        semi_axis_x_m,
        speed_m_s,
        ehl_constants.solid_conductivity_w_mk,
        ehl_constants.solid_volumetric_heat_j_m3k,
    )
    oil_conductivity_w_mk = inlet_oil.thermal_conductivity_w_mk
    film_rise_k_per_pa = film_temperature_rise(sliding_m_s, film_thickness_m, oil_conductivity_w_mk)
    shear_rate_1_s = sliding_m_s / film_thickness_m
    # stress at which the creep would be all of the slip
    creep_slope_of_bodies = creep_slope(conditions.relative_pressure, conditions.ellipticity)
    creep_stress_pa = creep_slope_of_bodies * pressure_pa * slide_roll_ratio
    # all of one shape, as the search needs them
    search_arguments = np.broadcast_arrays(
        pressure_pa,
        inlet_c,
        flash_rise_k_per_pa + film_rise_k_per_pa,
        shear_rate_1_s,
        creep_stress_pa,
    )
    stress_pa = _stress_with_heat(oil, ehl_constants, *search_arguments)
    film_share = _film_share_of_slip(stress_pa, creep_stress_pa)
    return SlidingFilm(
        shear_stress_pa=stress_pa,
        shear_rate_1_s=shear_rate_1_s * film_share,
        film_thickness_m=film_thickness_m,
        surface_temperature_c=inlet_c + flash_rise_k_per_pa * film_share * stress_pa,
        film_temperature_c=inlet_c
        + (flash_rise_k_per_pa + film_rise_k_per_pa) * film_share * stress_pa,
    )


def thermal_ehl_traction(
    oil: Oil,
    ehl_constants: ThermalEhlConstants,
    max_hertz_pressure_pa: Floats,
    entrainment_speed_m_s: Floats,
    inlet_temperature_c: Floats,
    slide_roll_ratio: Floats,
    radius_m: float,
    reduced_modulus_pa: float,
) -> FloatArray:
    """Traction coefficient of a circular contact, the load-weighted mean over its points.

        mu = 3 int_0^1 tau(p0 s)/(p0 s) s^2 ds,   p = p0 s with s = sqrt(1 - r^2/a^2)

    Args:
        oil: The oil, as for `sliding_film`.
        ehl_constants: Stresses and thermal properties, as for `sliding_film`.
        max_hertz_pressure_pa: Maximum pressure p0, in Pa.
        entrainment_speed_m_s: Entrainment speed U, above 0, in m/s.
        inlet_temperature_c: Temperature of the oil, and of both bodies far from the contact, in
            degC.
        slide_roll_ratio: Slide-roll ratio S, 0 or more.
        radius_m: Reduced radius, the same in both planes, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        mu; NaN where a point of the film would be hotter than 800 degC.

    Validity, References: as for `sliding_film`.
    """
    arguments = np.broadcast_arrays(
        max_hertz_pressure_pa, entrainment_speed_m_s, inlet_temperature_c, slide_roll_ratio
    )
    # the last axis holds the nodes
    max_pressure_pa, speed_m_s, inlet_c, slip = (
        argument[..., np.newaxis].astype(float) for argument in arguments
    )
    load_n = load_for_max_hertz_pressure(max_pressure_pa, radius_m, reduced_modulus_pa)
    # nodes between -1 and 1, which stand for s between 0 and 1
    node, weight = scipy.special.roots_jacobi(_RADIAL_NODE_COUNT, 0, 2)[:2]
    pressure_pa = max_pressure_pa * (1 + node) / 2
    conditions = Conditions(
        load_n=load_n,
        max_hertz_pressure_gpa=max_pressure_pa / PA_PER_GPA,
        entrainment_speed_m_s=speed_m_s,
        inlet_temperature_c=inlet_c,
        radius_x_m=np.asarray(radius_m),
        reduced_modulus_pa=reduced_modulus_pa,
    )
    contact_radius_m = contact_radius(load_n, radius_m, reduced_modulus_pa)
    film = sliding_film(oil, ehl_constants, conditions, pressure_pa, slip, contact_radius_m)
    return np.asarray((film.shear_stress_pa / pressure_pa) @ (weight / weight.sum()))


def _stress_with_heat(
    oil: Oil,
    ehl_constants: ThermalEhlConstants,
    pressure_pa: FloatArray,
    inlet_c: FloatArray,
    rise_k_per_pa: FloatArray,
    shear_rate_1_s: FloatArray,
    creep_stress_pa: FloatArray,
) -> FloatArray:
    """Shear stress of a film that is heated by friction, with creep of the bodies.

    Args:
        oil: The oil.
        ehl_constants: Stresses.
        pressure_pa: Pressure.
        inlet_c: Inlet temperature.
        rise_k_per_pa: Temperature rise of the film per pascal of stress, without creep.
        shear_rate_1_s: Shear rate of the film without creep.
        creep_stress_pa: Stress at which the creep is all of the slip.
    """

    def stress_error(
        assumed_stress_pa: FloatArray,
        pressure_pa: FloatArray,
        inlet_c: FloatArray,
        rise_k_per_pa: FloatArray,
        shear_rate_1_s: FloatArray,
        creep_stress_pa: FloatArray,
    ) -> FloatArray:
        """The assumed stress less that of the film which it heats; 0 at the solution."""
        film_share = _film_share_of_slip(assumed_stress_pa, creep_stress_pa)
        temperature_c = inlet_c + rise_k_per_pa * film_share * assumed_stress_pa
        return assumed_stress_pa - film_stress(
            oil, ehl_constants, pressure_pa, temperature_c, shear_rate_1_s * film_share
        )

    # the stress is largest in a film at the inlet temperature; the factor allows for rounding
    cold_film_stress_pa = film_stress(oil, ehl_constants, pressure_pa, inlet_c, shear_rate_1_s)
    with np.errstate(divide="ignore"):
        hottest_film_stress_pa = (_HIGHEST_FILM_TEMPERATURE_C - inlet_c) / rise_k_per_pa
    highest_stress_pa = np.minimum(cold_film_stress_pa * (1 + 1e-9), hottest_film_stress_pa)
    highest_stress_pa = np.minimum(highest_stress_pa, creep_stress_pa)
    # imported here because the import takes half a second and the formulas above do not need it
    from scipy.optimize import elementwise  # noqa: PLC0415

    root = elementwise.find_root(
        stress_error,
        (np.zeros_like(highest_stress_pa), highest_stress_pa),
        args=(pressure_pa, inlet_c, rise_k_per_pa, shear_rate_1_s, creep_stress_pa),
    )
    return np.asarray(root.x)


def _film_share_of_slip(stress_pa: FloatArray, creep_stress_pa: FloatArray) -> FloatArray:
    """Share of the film in the slip; the rest is creep of the bodies."""
    positive_creep_stress_pa = np.where(creep_stress_pa > 0, creep_stress_pa, 1.0)
    return np.asarray(1 - stress_pa / positive_creep_stress_pa)
