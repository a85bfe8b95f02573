"""Hertz contact, oils, film thickness and lambda."""

import numpy as np
from matplotlib.figure import Figure

from examples import NAMES, contact, oil
from oilfilm.base.units import FloatArray
from oilfilm.physics.contact import Conditions
from oilfilm.physics.film import (
    InletOil,
    contact_film,
    isothermal_film_thickness,
    thermal_reduction_factor,
)
from style import GREY, OILS, axes, row

STYLES = ("-", "--", ":")
PRESSURE = 1.25  # GPa


def film(name: str, speed: FloatArray, temperature: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Minimum film in um and lambda at pure rolling."""
    one = contact()
    thickness, ratio = contact_film(
        oil(name),
        one,
        "minimum",
        load_n=one.load_n(PRESSURE),
        entrainment_speed_m_s=speed,
        inlet_temperature_c=temperature,
        slide_roll_ratio=np.asarray(0.0),
    )
    return thickness * 1e6, ratio


def viscosity() -> Figure:
    """Viscosity of the three oils over temperature."""
    figure, one = axes(xlabel="Temperature (°C)", ylabel="Dynamic viscosity (mPa s)", yscale="log")
    temperature = np.linspace(0, 160, 161)
    for name, style in zip(NAMES, STYLES, strict=True):
        values = oil(name).dynamic_viscosity_pa_s(temperature) * 1e3
        one.plot(temperature, values, style, color=OILS[name], label=name)
    one.legend(title="oil")
    return figure


def pressure_viscosity() -> Figure:
    """Pressure-viscosity coefficient of the three oils."""
    figure, one = axes(xlabel="Temperature (°C)", ylabel="Pressure-viscosity coefficient (1/GPa)")
    temperature = np.linspace(20, 160, 141)
    for name, style in zip(NAMES, STYLES, strict=True):
        values = oil(name).pressure_viscosity_coefficient_1_pa(temperature) * 1e9
        one.plot(temperature, values, style, color=OILS[name], label=name)
    one.legend(title="oil")
    return figure


def hertz() -> Figure:
    """Maximum pressure over load."""
    figure, one = axes(xlabel="Load (N)", ylabel="Maximum Hertz pressure (GPa)")
    pressure = np.linspace(0.05, 2, 200)
    load = contact().load_n(pressure)
    one.plot(load, pressure)
    for level in (1.0, 1.25, 1.5):
        at = float(contact().load_n(level))
        one.plot([at], [level], "o", color=GREY)
        one.annotate(f"{level:g} GPa, {at:.0f} N", (at, level), (at + 12, level - 0.08), fontsize=9)
    one.set(xlim=(0, 350), ylim=(0, 2.2))
    return figure


def thickness_over_speed() -> Figure:
    """Film thickness over speed, with and without inlet heating."""
    figure, one = axes(
        xlabel="Entrainment speed U (m/s)",
        ylabel="Minimum film thickness (µm)",
        xscale="log",
        yscale="log",
    )
    speed = np.geomspace(0.5, 60, 120)
    for temperature, colour in ((40.0, "C0"), (70.0, "C1"), (120.0, "C2")):
        label = f"{temperature:g} °C"
        thickness, _ = film("4102", speed, np.asarray(temperature))
        one.plot(speed, thickness, "-", color=colour, label=label)
        rig, inlet = contact(), InletOil.from_oil(oil("4102"), temperature)
        of_rig = {"radius_x_m": rig.radius_m, "reduced_modulus_pa": rig.reduced_modulus_pa}
        at = Conditions(rig.load_n(PRESSURE), PRESSURE, speed, temperature, **of_rig)
        isothermal = isothermal_film_thickness(inlet, at, "minimum") * 1e6
        one.plot(speed, isothermal, ":", color=colour, label=f"{label}, isothermal")
    one.legend(ncols=2)
    return figure


def lambda_map() -> Figure:
    """Lambda over speed and temperature, with the limit of full film."""
    figure, one = axes(xlabel="Entrainment speed U (m/s)", ylabel="Inlet temperature T (°C)")
    speed, temperature = np.meshgrid(np.geomspace(0.2, 50, 120), np.linspace(25, 150, 120))
    _, ratio = film("4050", speed, temperature)
    shown = one.contourf(speed, temperature, np.log10(ratio), 14, cmap="cividis")
    lines = one.contour(speed, temperature, ratio, [1, 3, 10], colors="white", linewidths=[1, 2, 1])
    one.clabel(lines, fmt="lambda = %g")
    figure.colorbar(shown, label="log10 of lambda (1)")
    one.set(xscale="log")
    one.grid(visible=False)
    return figure


def inlet_heating() -> Figure:
    """Thermal reduction factor over speed."""
    figure, two = row(2)
    speed = np.linspace(1, 60, 120)
    for temperature, style in ((40.0, "-"), (70.0, "--"), (120.0, ":")):
        heating = InletOil.from_oil(oil("4102"), np.asarray(temperature)).thermal_loading(speed)
        two[0].plot(speed, heating, style, label=f"{temperature:g} °C")
        relative = PRESSURE * 1e9 / contact().reduced_modulus_pa
        factor = thermal_reduction_factor(relative, 0.0, heating)
        two[1].plot(speed, factor, style, label=f"{temperature:g} °C")
    two[0].set(xlabel="Entrainment speed U (m/s)", ylabel="Thermal loading L (1)", yscale="log")
    two[1].set(
        xlabel="Entrainment speed U (m/s)", ylabel="Thermal reduction factor (1)", ylim=(0, 1)
    )
    two[0].legend()
    return figure
