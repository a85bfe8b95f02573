"""Thermal, shear-thinning traction from local conditions: the physics behind simulated torque logs.

A fitted law says mu of a whole contact. Here every place of a contact has its own pressure,
sliding speed and temperature, so that a bearing simulated with it is not the model which is
compared with it. The ingredients are standard: Barus viscosity, Eyring stress under a limit that
falls with temperature (joined as by Bair and Winer), heat by sliding, flash temperature of moving
surfaces. Film thickness: Hamrock-Dowson, thinned by inlet heating.
"""

from collections.abc import Callable
from dataclasses import astuple, dataclass

import numpy as np
from scipy.optimize import least_squares

from oilfilm.bearing.ellipse import Conditions, Grid, grid
from oilfilm.contact import elliptical_contact, load_for_max_hertz_pressure
from oilfilm.film import (
    central_film_thickness,
    thermal_loading_parameter,
    thermal_reduction_factor,
)
from oilfilm.oils import Oil
from oilfilm.rigs import Contact
from oilfilm.units import PA_PER_GPA, FloatArray

LawOfRig = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]

# Steel: thermal conductivity times density times specific heat, 46 W/m K x 3.6e6 J/m3 K.
_STEEL = 46.0 * 3.6e6
# Barus overstates the viscosity under high pressure: its exponent is bent towards this limit.
_LARGEST_EXPONENT = 18.0
_FIXED_POINTS = 25
# The rig's box, over which the constants are sought (Deng et al. 2026, section 2).
_BOX = ((1.0, 1.5), (25.0, 40.0), (25.0, 70.0, 120.0))
_SLIPS = np.array([0.01, 0.03, 0.08, 0.2])


@dataclass(frozen=True)
class Constants:
    """What an oil's resistance to shear is made of, as logarithms but for the last.

    Attributes:
        log_eyring_pa: ln of the Eyring stress, in Pa.
        log_limit: ln of limiting stress over pressure at 60 degC.
        log_pressure: ln of a factor on the pressure-viscosity coefficient.
        limit_slope_1_k: Relative fall of the limit with temperature.
    """

    log_eyring_pa: float
    log_limit: float
    log_pressure: float
    limit_slope_1_k: float


# Where the search starts and what is known of such oils (physics.md): Eyring stress 3 to 8 MPa,
# limit 0.03 to 0.15 of the pressure and falling with temperature, viscosity's rise within 30 %.
_START = Constants(np.log(5e6), np.log(0.06), 0.0, 4e-3)
_LOWEST = Constants(np.log(3e6), np.log(0.03), np.log(0.7), 0.0)
_HIGHEST = Constants(np.log(8e6), np.log(0.15), np.log(1.3), 1e-2)


@dataclass(frozen=True)
class LocalTraction:
    """mu at each place of contacts from that place's own pressure, slip and temperature.

    Attributes:
        oil: The oil's properties.
        constants: Of its resistance to shear.
        rule: The places that it is asked for.
        radius_y_m: Reduced radius across the rolling direction, broadcasting against the contacts.
    """

    oil: Oil
    constants: Constants
    rule: Grid
    radius_y_m: FloatArray

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `oilfilm.bearing.ellipse.TractionBasis`."""
        load = np.maximum(at.load_n, 1e-3)
        contact = elliptical_contact(load, at.radius_x_m, self.radius_y_m, at.reduced_modulus_pa)
        peak = np.maximum(at.max_hertz_pressure_gpa * PA_PER_GPA, 1e6)
        speed = np.maximum(at.entrainment_speed_m_s, 1e-3)
        pressure = peak * np.sqrt(1 - self.rule.along**2 - self.rule.across**2)
        film = self._film(at, load, speed, contact.ellipticity, slide_roll_ratio, peak)
        crossing = np.sqrt(2 * contact.semi_axis_x_m / (np.pi * speed * _STEEL))
        sliding = slide_roll_ratio * speed
        conductivity = self.oil.thermal_conductivity_w_mk(at.inlet_temperature_c)
        # mean rise of both surfaces, half the heat into each, and of the film's middle above them
        per_heat = 2 / 3 * crossing + film / (8 * conductivity)
        temperature = at.inlet_temperature_c + 0 * pressure * sliding
        for _ in range(_FIXED_POINTS):
            stress = self._stress(pressure, sliding / film, temperature)
            target = at.inlet_temperature_c + stress * sliding * per_heat
            temperature = (temperature + target) / 2
        return self._stress(pressure, sliding / film, temperature) / pressure

    def _film(
        self,
        at: Conditions,
        load: FloatArray,
        speed: FloatArray,
        ellipticity: FloatArray,
        slip: FloatArray,
        peak: FloatArray,
    ) -> FloatArray:
        viscosity = self.oil.dynamic_viscosity_pa_s(at.inlet_temperature_c)
        loading = thermal_loading_parameter(
            entrainment_speed_m_s=speed,
            dynamic_viscosity_pa_s=viscosity,
            temperature_viscosity_coefficient_1_k=self.oil.temperature_viscosity_coefficient_1_k(
                at.inlet_temperature_c
            ),
            thermal_conductivity_w_mk=self.oil.thermal_conductivity_w_mk(at.inlet_temperature_c),
        )
        reduction = thermal_reduction_factor(
            max_hertz_pressure_pa=peak,
            reduced_modulus_pa=at.reduced_modulus_pa,
            slide_roll_ratio=slip,
            thermal_loading=loading,
        )
        film = central_film_thickness(
            load_n=load,
            entrainment_speed_m_s=speed,
            dynamic_viscosity_pa_s=viscosity,
            pressure_viscosity_coefficient_1_pa=self.oil.pressure_viscosity_coefficient_1_pa(
                at.inlet_temperature_c
            ),
            radius_x_m=at.radius_x_m,
            reduced_modulus_pa=at.reduced_modulus_pa,
            ellipticity=ellipticity,
        )
        return film * np.maximum(reduction, 0.1)

    def _stress(
        self, pressure: FloatArray, shear_rate: FloatArray, temperature_c: FloatArray
    ) -> FloatArray:
        constants = self.constants
        alpha = np.exp(constants.log_pressure) * self.oil.pressure_viscosity_coefficient_1_pa(
            temperature_c
        )
        exponent = alpha * pressure
        exponent = exponent / (1 + exponent / _LARGEST_EXPONENT)
        viscosity = self.oil.dynamic_viscosity_pa_s(temperature_c) * np.exp(exponent)
        eyring = np.exp(constants.log_eyring_pa)
        shear = eyring * np.arcsinh(viscosity * shear_rate / eyring)
        cooling = np.exp(-constants.limit_slope_1_k * (temperature_c - 60))
        limit = np.exp(constants.log_limit) * cooling * pressure
        return limit * (1 - np.exp(-shear / limit))


def calibrated(oil: Oil, law: LawOfRig, rig: Contact) -> tuple[Constants, float]:
    """Constants with which the traction rig's contact comes nearest to a law, and what is left.

    Args:
        oil: The oil's properties.
        law: mu of the rig's contact against (P in GPa, U in m/s, T in degC, S).
        rig: The traction rig's contact.

    Returns:
        The constants, and the root-mean-square difference over the rig's box relative to the law.
    """
    rule = grid(6, 4)
    pressure, speed, temperature = (
        level.ravel()[:, np.newaxis] for level in np.meshgrid(*_BOX, indexing="ij")
    )
    known = law(pressure, speed, temperature, _SLIPS)
    load = load_for_max_hertz_pressure(pressure * PA_PER_GPA, rig.radius_m, rig.reduced_modulus_pa)
    shape = (*known.shape, 1)

    def each(level: FloatArray) -> FloatArray:
        return np.broadcast_to(level[..., np.newaxis], shape)

    at = Conditions(
        load_n=each(load),
        max_hertz_pressure_gpa=each(pressure),
        entrainment_speed_m_s=each(speed),
        inlet_temperature_c=each(temperature),
        radius_x_m=np.full(shape, rig.radius_m),
        reduced_modulus_pa=rig.reduced_modulus_pa,
    )

    def mean(values: FloatArray) -> FloatArray:
        film = LocalTraction(oil, Constants(*values), rule, np.asarray(rig.radius_m))
        return np.asarray((film(at, _SLIPS[:, np.newaxis]) * rule.share).sum(axis=-1))

    def away(values: FloatArray) -> FloatArray:
        return (mean(values) - known).ravel() / np.abs(known).max()

    start, lowest, highest = (np.array(astuple(one)) for one in (_START, _LOWEST, _HIGHEST))
    found = least_squares(
        away,
        start,
        bounds=(lowest, highest),
        x_scale=highest - lowest,
        xtol=1e-4,
        ftol=1e-6,
    )
    left = np.sqrt(np.mean((mean(found.x) - known) ** 2) / np.mean(known**2))
    return Constants(*found.x), float(left)
