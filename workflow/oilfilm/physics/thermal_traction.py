"""Traction of an oil film by thermal elastohydrodynamics: shear thinning, limiting stress, heat.

Traction computed from the properties of an oil instead of a fit. The rig twin can use it as truth,
and laws use its stresses. The contact has one film thickness; every point of it has its own
pressure, stress and temperature, and the contact's traction is their mean.
All quantities are in SI units, temperatures in degC. Arguments are floats or arrays that broadcast.

Volumes and pages of the references are not checked against print; the tests hold each formula
against its own limits and against conduction solved numerically.

Decides: traction of an oil from its properties (thermal elastohydrodynamics), the truth of the
campaign `thermal`; the temperature of the film of a measured point.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from oilfilm.physics.contact import (
    Conditions,
    Floats,
    contact_radius,
    creep_slope,
    load_for_max_hertz_pressure,
)
from oilfilm.physics.film import InletOil, film_thickness
from oilfilm.physics.oils import Oil
from oilfilm.units import PA_PER_GPA, FloatArray

# Further up, properties continued in straight lines from their tables would fall below zero.
_HOTTEST_C = 800.0
# Of the mean over a contact; within 0.01 % of mu up to 2.5 GPa and 200 m/s.
_RADIAL_NODES = 12


@dataclass(frozen=True, kw_only=True)
class ThermalEhl:
    """Constants that belong to no oil file.

    Attributes:
        eyring_stress_pa: tau_E, above which the film thins under shear, in Pa.
        limiting_stress_ratio: Lambda, limiting stress over pressure, at the reference temperature.
        limiting_stress_reference_c: That temperature, in degC.
        limiting_stress_decay_1_k: Relative fall of Lambda with the film's temperature, in 1/K.
        solid_conductivity_w_mk: Thermal conductivity of both bodies, in W/(m K).
        solid_volumetric_heat_j_m3k: Their density times specific heat, in J/(m3 K).
    """

    eyring_stress_pa: float
    limiting_stress_ratio: float
    limiting_stress_reference_c: float
    limiting_stress_decay_1_k: float
    solid_conductivity_w_mk: float
    solid_volumetric_heat_j_m3k: float


@dataclass(frozen=True)
class SlidingFilm:
    """Result of `sliding_film`; each attribute has the arguments' broadcast shape.

    Attributes:
        shear_stress_pa: Shear stress tau, in Pa.
        shear_rate_1_s: Sliding speed over film thickness, in 1/s.
        film_thickness_m: Central film thickness, thinned by inlet heating, in m.
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
    """Viscosity under pressure.

        eta = eta0 exp(alpha p)

    Args:
        dynamic_viscosity_pa_s: eta0 at ambient pressure, in Pa s.
        pressure_viscosity_coefficient_1_pa: alpha, in 1/Pa.
        pressure_pa: p, in Pa.

    Returns:
        eta, in Pa s.

    Validity: good to some 0.5 GPa; far too high above, where a film's stress hangs on ln(eta) at
        most and soon on its limit alone.

    Reference: C. Barus, Am. J. Sci. 45 (1893) 87.

    Examples:
        MIL-L-23699 oil at 100 degC and 1 GPa, by hand 5.006e-3 exp(11.03) Pa s:

        >>> print(f"{barus_viscosity(5.006e-3, 1.103e-8, 1e9):.0f} Pa s")
        309 Pa s
    """
    return np.asarray(
        dynamic_viscosity_pa_s * np.exp(pressure_viscosity_coefficient_1_pa * pressure_pa)
    )


def eyring_stress(
    viscosity_pa_s: Floats, shear_rate_1_s: Floats, eyring_stress_pa: Floats
) -> FloatArray:
    """Shear stress of a film that thins by thermal activation.

        tau = tau_E asinh(eta gamma/tau_E)

    Args:
        viscosity_pa_s: eta at rest, at the film's pressure and temperature, in Pa s.
        shear_rate_1_s: gamma, in 1/s.
        eyring_stress_pa: tau_E, in Pa.

    Returns:
        tau, in Pa: eta gamma where that is small against tau_E.

    Reference: H. Eyring, J. Chem. Phys. 4 (1936) 283; K. L. Johnson and J. L. Tevaarwerk, Proc. R.
        Soc. Lond. A 356 (1977) 215.

    Examples:
        At eta gamma = sinh(1) tau_E the stress is tau_E:

        >>> print(f"{eyring_stress(np.sinh(1.0), 5e6, 5e6) / 1e6:.3f} MPa")
        5.000 MPa
    """
    return np.asarray(
        eyring_stress_pa * np.arcsinh(viscosity_pa_s * shear_rate_1_s / eyring_stress_pa)
    )


def limiting_stress(
    pressure_pa: Floats, temperature_c: Floats, constants: ThermalEhl
) -> FloatArray:
    """Largest shear stress that a film can bear.

        tau_L = Lambda p exp(-b (T - T_r))

    Proportional to pressure as usual; the fall with temperature is known to be there, its
    exponential form is a convenience that keeps the stress above zero.

    Args:
        pressure_pa: p, in Pa.
        temperature_c: T of the film, in degC.
        constants: Lambda at the reference temperature T_r, and its decay b.

    Returns:
        tau_L, in Pa.

    Reference: S. Bair and W. O. Winer, J. Lubr. Technol. 101 (1979) 251, for its being
        proportional to pressure.
    """
    cooler = constants.limiting_stress_reference_c - np.asarray(temperature_c)
    warmed = np.exp(constants.limiting_stress_decay_1_k * cooler)
    return np.asarray(constants.limiting_stress_ratio * pressure_pa * warmed)


def limited_stress(stress_pa: Floats, limiting_stress_pa: Floats) -> FloatArray:
    """A shear stress that goes over smoothly into its limit.

        tau = tau_L [1 - exp(-tau_0/tau_L)]

    Args:
        stress_pa: tau_0 that the film would bear without a limit, in Pa, 0 or more.
        limiting_stress_pa: tau_L, in Pa.

    Returns:
        tau, in Pa: tau_0 far below tau_L, tau_L far above.

    Reference: S. Bair and W. O. Winer, J. Lubr. Technol. 101 (1979) 258, the exponential form.

    Examples:
        Below both, and 1 - 1/e of the limit where they meet:

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
    """Mean rise of a surface's temperature under a circular source of heat that moves fast.

        dT = 0.974 q sqrt(a/(k rho c V))

    In terms of the total heat Q = pi a^2 q and the diffusivity chi this is Archard's
    0.31 (Q/(k a)) sqrt(chi/(V a)).

    Args:
        heat_flux_w_m2: q into this surface, the same all over the circle, in W/m2.
        contact_radius_m: a, in m.
        speed_m_s: V of the surface against the source, in m/s.
        conductivity_w_mk: k of the body, in W/(m K).
        volumetric_heat_j_m3k: rho c of the body, in J/(m3 K).

    Returns:
        dT, in K.

    Validity: V a rho c/(2 k) above 5 (it is 88 at 20 m/s and 0.8 GPa, and rises with both).

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
    # Mean over a circle of the temperature that a fast, uniform source leaves behind: chord by
    # chord 4/3 q sqrt(chord/(pi k rho c V)), integrated over the chords.
    circular = 8 * np.sqrt(2) / (3 * np.pi**1.5) * scipy.special.beta(1 / 2, 7 / 4)
    return np.asarray(
        circular
        * heat_flux_w_m2
        * np.sqrt(contact_radius_m / (conductivity_w_mk * volumetric_heat_j_m3k * speed_m_s))
    )


def film_temperature_rise(
    heat_flux_w_m2: Floats, film_thickness_m: Floats, conductivity_w_mk: Floats
) -> FloatArray:
    """Rise of a film's mean temperature over its surfaces, its heat leaving by conduction alone.

        dT = q h/(12 k)

    The mean over the parabola that heat makes when it arises evenly across the film and leaves
    through both surfaces; the middle of the film is half as much again above them, q h/(8 k).

    Args:
        heat_flux_w_m2: q that arises in the film, in W per m2 of contact.
        film_thickness_m: h, in m.
        conductivity_w_mk: k of the oil, in W/(m K).

    Returns:
        dT, in K.

    Validity: oil stays in the contact long against h^2 rho c/(pi^2 k); five times as long in the
        cold films of 0.6 um at 200 m/s, longer elsewhere.

    Reference: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, Oxford (1959), 3.14.

    Examples:
        20 MPa times 1.25 m/s in 0.4 um of oil, by hand 25e6 * 0.4e-6/(12 * 0.147) K:

        >>> rise = film_temperature_rise(25e6, film_thickness_m=0.4e-6, conductivity_w_mk=0.147)
        >>> print(f"{rise:.2f} K")
        5.67 K
    """
    return np.asarray(heat_flux_w_m2 * film_thickness_m / (12 * conductivity_w_mk))


def mean_film_rise(
    oil: InletOil,
    at: Conditions,
    traction_coefficient: Floats,
    slide_roll_ratio: Floats,
    solid_conductivity_w_mk: float,
    solid_volumetric_heat_j_m3k: float,
) -> FloatArray:
    """Mean temperature of the film above that of the inlet, by the heat of its own friction.

        q = |mu| p_mean |S| u,   p_mean = 2/3 p0
        dT = flash(q/2) of the surfaces, on average, + q h_c/(12 k_oil)

    Args:
        oil: The oil at the inlet temperature.
        at: Conditions of the contact.
        traction_coefficient: mu, measured.
        slide_roll_ratio: S.
        solid_conductivity_w_mk: Of both bodies, in W/(m K).
        solid_volumetric_heat_j_m3k: Density times specific heat of both bodies, in J/(m3 K).

    Returns:
        dT, in K.

    Validity: circular contact, half of the heat into each body, heat even over the contact; as
        `flash_temperature_rise` and `film_temperature_rise`.

    Reference: J. F. Archard, Wear 2 (1959) 438, for the surfaces; H. S. Carslaw and J. C. Jaeger,
        Conduction of Heat in Solids (1959), 3.14, for the film.

    Examples:
        MIL-L-23699 oil at 100 degC, 1.5 GPa, 25 m/s, S = 0.05, mu = 0.02: 25 MW/m2 as 20 MPa times
        1.25 m/s, 2.75 K in the surfaces and 4.17 K in 0.295 um of oil:

        >>> oil = InletOil(5.006e-3, 1.103e-8, 0.01996, 0.1472)
        >>> at = Conditions(142, 1.5, 25, 100, radius_x_m=0.010, reduced_modulus_pa=221.6e9)
        >>> print(f"{mean_film_rise(oil, at, 0.02, 0.05, 46, 3.6e6):.1f} K")
        6.9 K
    """
    mean_pressure_pa = 2 / 3 * at.max_hertz_pressure_gpa * PA_PER_GPA
    sliding_m_s = np.abs(slide_roll_ratio) * at.entrainment_speed_m_s
    heat = np.abs(traction_coefficient) * mean_pressure_pa * sliding_m_s
    radius = contact_radius(at.load_n, at.radius_x_m, at.reduced_modulus_pa)
    solid = solid_conductivity_w_mk, solid_volumetric_heat_j_m3k
    speeds = (at.entrainment_speed_m_s * (1 + side * slide_roll_ratio / 2) for side in (-1, 1))
    slower, faster = (flash_temperature_rise(heat / 2, radius, speed, *solid) for speed in speeds)
    thickness_m = film_thickness(oil, at, slide_roll_ratio, "central")
    film = film_temperature_rise(heat, thickness_m, oil.thermal_conductivity_w_mk)
    return (slower + faster) / 2 + film


def film_stress(
    oil: Oil,
    constants: ThermalEhl,
    pressure_pa: FloatArray,
    film_temperature_c: FloatArray,
    shear_rate_1_s: FloatArray,
) -> FloatArray:
    """Shear stress of a film of known temperature; it falls as the temperature rises.

        tau = limited_stress(eyring_stress(eta(p, T), gamma), limiting_stress(p, T))

    Args:
        oil: The oil; its viscosity and pressure-viscosity coefficient are those of the film.
        constants: Stresses.
        pressure_pa: p, in Pa.
        film_temperature_c: T, in degC.
        shear_rate_1_s: gamma, in 1/s.

    Returns:
        tau, in Pa.
    """
    viscosity = barus_viscosity(
        oil.dynamic_viscosity_pa_s(film_temperature_c),
        oil.pressure_viscosity_coefficient_1_pa(film_temperature_c),
        pressure_pa,
    )
    limit = limiting_stress(pressure_pa, film_temperature_c, constants)
    thinned = eyring_stress(viscosity, shear_rate_1_s, constants.eyring_stress_pa)
    return limited_stress(thinned, limit)


def sliding_film(
    oil: Oil,
    constants: ThermalEhl,
    at: Conditions,
    pressure_pa: Floats,
    slide_roll_ratio: Floats,
    semi_axis_x_m: Floats,
) -> SlidingFilm:
    """Film at a point of a contact, with the heat that its own sliding makes.

        tau   = film_stress(p, T, gamma),   gamma = S_f U/h
        T     = T_inlet + dT_flash(tau S_f U/2) + dT_film(tau S_f U)
        S_f   = S - tau/(K p),   K = creep_slope of the bodies
        h     = phi_T h_c

    The film slips by S_f, the bodies creep by the rest: the two are in series at every point, which
    has a share of the contact's stiffness in proportion to its pressure. That distribution is OURS;
    the contact's slope at small slip is Kalker's. The stress falls with the temperature and with
    the creep, both of which rise with the stress, so that there is exactly one solution. A
    bracketing root search finds it.

    Args:
        oil: The oil; its viscosity and pressure-viscosity coefficient are taken at the temperature
            of the film, its conductivity at the inlet's.
        constants: Stresses and the bodies' thermal properties.
        at: The contact's conditions, at a speed and pressure above 0; the bodies far from the
            contact are as warm as the oil.
        pressure_pa: p at the point, in Pa.
        slide_roll_ratio: S at the point, 0 or more.
        semi_axis_x_m: Semi-axis of the contact in the rolling direction, in m.

    Returns:
        The film; NaN where it would be hotter than 800 degC.

    Validity: full film, small S (both surfaces are heated as if they moved at U; at S = 0.3 that
        is 1 % off). A point is heated as in a contact with the same flux everywhere, by the mean
        over its area. The thermal reduction phi_T is the fit of Gupta et al. without its pressure
        term, which would make films negative at 200 m/s. Left out: oil that carries heat away or
        arrives heated, heat of compression, elastic strain of the film, the pressure's effect on
        conductivity. Good for how traction goes with its conditions, not for the level of any one
        oil.

    References: K. L. Johnson and J. L. Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215; the parts
    as given with the functions of this module and in `film`.
    """
    inlet_oil, speed = InletOil.of(oil, at.inlet_temperature_c), at.entrainment_speed_m_s
    # without the pressure term, see Validity
    without = replace(at, max_hertz_pressure_gpa=np.zeros(()))
    film_thickness_m = film_thickness(inlet_oil, without, slide_roll_ratio, "central")
    sliding_m_s = np.asarray(slide_roll_ratio) * speed
    # both rises are proportional to the heat: kelvin per pascal of shear stress. The chords of an
    # ellipse are those of a circle with its semi-axis along the rolling direction.
    solid = constants.solid_conductivity_w_mk, constants.solid_volumetric_heat_j_m3k
    flash = flash_temperature_rise(sliding_m_s / 2, semi_axis_x_m, speed, *solid)
    conductivity = inlet_oil.thermal_conductivity_w_mk
    within = film_temperature_rise(sliding_m_s, film_thickness_m, conductivity)
    shear_rate = sliding_m_s / film_thickness_m
    # the stress at which all slip would be creep
    creep = creep_slope(at.relative_pressure, at.ellipticity) * pressure_pa * slide_roll_ratio
    known = np.broadcast_arrays(
        pressure_pa, at.inlet_temperature_c, flash + within, shear_rate, creep
    )
    stress = _stress_with_heat(oil, constants, *known)
    of_film = _share_of_film(stress, known[-1])
    return SlidingFilm(
        shear_stress_pa=stress,
        shear_rate_1_s=shear_rate * of_film,
        film_thickness_m=film_thickness_m,
        surface_temperature_c=at.inlet_temperature_c + flash * of_film * stress,
        film_temperature_c=at.inlet_temperature_c + (flash + within) * of_film * stress,
    )


def thermal_ehl_traction(
    oil: Oil,
    constants: ThermalEhl,
    max_hertz_pressure_pa: Floats,
    entrainment_speed_m_s: Floats,
    inlet_temperature_c: Floats,
    slide_roll_ratio: Floats,
    radius_m: float,
    reduced_modulus_pa: float,
) -> FloatArray:
    """Traction coefficient of a circular contact, the mean of its points by their load.

        mu = 3 int_0^1 tau(p0 s)/(p0 s) s^2 ds,   p = p0 s with s = sqrt(1 - r^2/a^2)

    Args:
        oil: As of `sliding_film`.
        constants: As of `sliding_film`.
        max_hertz_pressure_pa: p0, in Pa.
        entrainment_speed_m_s: U, above 0, in m/s.
        inlet_temperature_c: Of the oil and of both bodies far from the contact, in degC.
        slide_roll_ratio: S, 0 or more.
        radius_m: Reduced radius, the same in both planes, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        mu; NaN where a point of the film would be hotter than 800 degC.

    Validity, References: as of `sliding_film`.
    """
    levels = max_hertz_pressure_pa, entrainment_speed_m_s, inlet_temperature_c, slide_roll_ratio
    peak, speed, inlet, slip = (
        level[..., np.newaxis].astype(float) for level in np.broadcast_arrays(*levels)
    )
    load_n = load_for_max_hertz_pressure(peak, radius_m, reduced_modulus_pa)
    root, weight = scipy.special.roots_jacobi(_RADIAL_NODES, 0, 2)[:2]
    pressure = peak * (1 + root) / 2
    x = np.asarray(radius_m)
    at = Conditions(load_n, peak / PA_PER_GPA, speed, inlet, x, reduced_modulus_pa)
    radius = contact_radius(load_n, radius_m, reduced_modulus_pa)
    film = sliding_film(oil, constants, at, pressure, slip, radius)
    return np.asarray((film.shear_stress_pa / pressure) @ (weight / weight.sum()))


def _stress_with_heat(oil: Oil, constants: ThermalEhl, *known: FloatArray) -> FloatArray:
    """Shear stress of a film that its own heat warms and that the bodies' creep relieves.

    Args:
        oil: The oil.
        constants: Stresses.
        known: Pressure; temperature of the inlet; rise of the film's temperature per pascal of the
            stress and its shear rate, were all slip its own; stress at which all slip is creep.
    """

    def excess(stress: FloatArray, *known: FloatArray) -> FloatArray:
        pressure, inlet, rise, shear_rate, most = known
        share = _share_of_film(stress, most)
        warm = inlet + rise * share * stress
        return stress - film_stress(oil, constants, pressure, warm, shear_rate * share)

    pressure, inlet, rise, shear_rate, most = known
    # the stress is largest in a film that stays cold; the factor allows for rounding
    coldest = film_stress(oil, constants, pressure, inlet, shear_rate)
    with np.errstate(divide="ignore"):
        hottest = (_HOTTEST_C - inlet) / rise
    highest = np.minimum(np.minimum(coldest * (1 + 1e-9), hottest), most)
    # imported here: it takes half a second, and the formulas above do without
    from scipy.optimize import elementwise  # noqa: PLC0415

    root = elementwise.find_root(excess, (np.zeros_like(highest), highest), args=known)
    return np.asarray(root.x)


def _share_of_film(stress_pa: FloatArray, creep_stress_pa: FloatArray) -> FloatArray:
    """Share of the slip that is the film's own; the bodies creep by the rest."""
    whole = np.where(creep_stress_pa > 0, creep_stress_pa, 1.0)
    return np.asarray(1 - stress_pa / whole)
