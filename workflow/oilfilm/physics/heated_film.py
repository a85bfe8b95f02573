"""How much hotter than its inlet the film of a sliding contact is.

Decides: the temperature of the film of a measured point.
"""

import numpy as np

from oilfilm.physics.contact import Conditions, Floats, contact_radius
from oilfilm.physics.film import InletOil, film_thickness
from oilfilm.physics.thermal_traction import film_temperature_rise, flash_temperature_rise
from oilfilm.units import PA_PER_GPA, FloatArray


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
