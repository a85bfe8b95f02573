"""Thermal traction from local conditions: the physics behind simulated torque logs.

A fitted law, and the twin of the traction rig, give mu of a whole contact. Here every point of a
contact has its own pressure, sliding speed and temperature, so that a bearing simulated with it is
not the model that is compared with it. Stresses and heat are those of
`oilfilm.physics.thermal_traction`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from oilfilm.bearing.ellipse import Conditions, Grid, grid
from oilfilm.physics.contact import elliptical_contact
from oilfilm.physics.film import InletOil, film_thickness
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.physics.thermal_traction import ThermalEhl, film_stress, film_temperature_rise
from oilfilm.units import PA_PER_GPA, FloatArray

# P in GPa, U in m/s, T in degC, S -> mu of the traction rig's contact
LawOfRig = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]

_FIXED_POINTS = 25
# Levels of the rig's box, over which laws are compared (Deng et al. 2026, section 2).
_BOX = ((1.0, 1.5), (25.0, 40.0), (25.0, 70.0, 120.0))
_SLIPS = np.array([0.01, 0.03, 0.08, 0.2])
# Where the search for constants starts, and their usual ranges (not checked against print):
# Eyring stress in Pa, limiting stress over pressure, its relative fall in 1/K.
_START = np.array([np.log(5e6), np.log(0.06), 4e-3])
_LOWEST = np.array([np.log(3e6), np.log(0.03), 0.0])
_HIGHEST = np.array([np.log(8e6), np.log(0.15), 1e-2])

# What is not looked for: in degC, where the limiting stress over pressure holds, within the rig's
# box; and bearing steel in W/(m K) and J/(m3 K), usual values (not checked against print).
_GIVEN = {
    "limiting_stress_reference_c": 60.0,
    "solid_conductivity_w_mk": 46.0,
    "solid_volumetric_heat_j_m3k": 3.6e6,
}


@dataclass(frozen=True)
class LocalTraction:
    """mu at each point of contacts from that point's own pressure, slip and temperature.

    Attributes:
        oil: The oil's properties.
        constants: Stresses and thermal properties of the bodies.
        rule: The points at which it is evaluated.
        radius_y_m: Reduced radius across the rolling direction, broadcasting against the contacts.
    """

    oil: Oil
    constants: ThermalEhl
    rule: Grid
    radius_y_m: FloatArray

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `oilfilm.bearing.ellipse.TractionLaw`."""
        load = np.maximum(at.load_n, 1e-3)
        contact = elliptical_contact(load, at.radius_x_m, self.radius_y_m, at.reduced_modulus_pa)
        peak = np.maximum(at.max_hertz_pressure_gpa * PA_PER_GPA, 1e6)
        speed = np.maximum(at.entrainment_speed_m_s, 1e-3)
        pressure = peak * np.sqrt(1 - self.rule.along**2 - self.rule.across**2)
        inlet, sliding = at.inlet_temperature_c, slide_roll_ratio * speed
        inlet_oil = InletOil.of(self.oil, inlet)
        film = film_thickness(
            inlet_oil,
            thickness="central",
            load_n=load,
            max_hertz_pressure_pa=0.0,  # without the pressure term, as in `thermal_ehl_traction`
            entrainment_speed_m_s=speed,
            slide_roll_ratio=slide_roll_ratio,
            radius_x_m=at.radius_x_m,
            reduced_modulus_pa=at.reduced_modulus_pa,
            ellipticity=contact.ellipticity,
        )
        # both rises go with the stress: of the film, and of surfaces that took half the heat each
        # over the time of one crossing, 2/3 of the rise at its end
        constants = self.constants
        steel = constants.solid_conductivity_w_mk * constants.solid_volumetric_heat_j_m3k
        crossing = np.sqrt(2 * contact.semi_axis_x_m / (np.pi * speed * steel))
        rise = 2 / 3 * sliding * crossing + film_temperature_rise(
            sliding,
            film_thickness_m=film,
            conductivity_w_mk=inlet_oil.thermal_conductivity_w_mk,
        )
        temperature = inlet + np.zeros_like(rise * pressure)
        for _ in range(_FIXED_POINTS):
            stress = film_stress(self.oil, constants, pressure, temperature, sliding / film)
            temperature = (temperature + inlet + rise * stress) / 2
        stress = film_stress(self.oil, constants, pressure, temperature, sliding / film)
        return stress / pressure


def misfit(oil: Oil, constants: ThermalEhl, law: LawOfRig, rig: Contact) -> float:
    """Root-mean-square difference of local traction, averaged over the rig's contact, from a law.

    Args:
        oil: The oil's properties.
        constants: Of the local traction.
        law: mu of the rig's contact.
        rig: The traction rig's contact.

    Returns:
        The difference over the rig's box, relative to the law's root-mean-square.
    """
    known, mean = _compared(oil, law, rig)
    return float(np.sqrt(np.mean((mean(constants) - known) ** 2) / np.mean(known**2)))


def calibrated(oil: Oil, law: LawOfRig, rig: Contact) -> ThermalEhl:
    """Constants with which the traction rig's contact comes nearest to a law.

    Args:
        oil: The oil's properties.
        law: mu of the rig's contact.
        rig: The traction rig's contact.
    """
    known, mean = _compared(oil, law, rig)

    def constants(values: FloatArray) -> ThermalEhl:
        return ThermalEhl(
            eyring_stress_pa=np.exp(values[0]),
            limiting_stress_ratio=np.exp(values[1]),
            limiting_stress_decay_1_k=values[2],
            **_GIVEN,
        )

    def away(values: FloatArray) -> FloatArray:
        return (mean(constants(values)) - known).ravel() / np.abs(known).max()

    scale = _HIGHEST - _LOWEST
    fit = least_squares(
        away, _START, bounds=(_LOWEST, _HIGHEST), x_scale=scale, xtol=1e-4, ftol=1e-6
    )
    return constants(fit.x)


def _compared(
    oil: Oil, law: LawOfRig, rig: Contact
) -> tuple[FloatArray, Callable[[ThermalEhl], FloatArray]]:
    """A law over the rig's box, and local traction there as a function of its constants."""
    rule = grid(6, 4)
    pressure, speed, temperature = (
        level.ravel()[:, np.newaxis] for level in np.meshgrid(*_BOX, indexing="ij")
    )
    known = law(*np.broadcast_arrays(pressure, speed, temperature, _SLIPS))
    load = rig.load_n(pressure)
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

    def mean(constants: ThermalEhl) -> FloatArray:
        film = LocalTraction(oil, constants, rule, np.asarray(rig.radius_m))
        return np.asarray((film(at, _SLIPS[:, np.newaxis]) * rule.share).sum(axis=-1))

    return known, mean
