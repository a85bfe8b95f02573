"""Traction curves and what the constants of a law do."""

import numpy as np
from matplotlib.figure import Figure

import deng2026_study
import oilfilm
from examples import NAMES
from oilfilm.traction import LAWS
from style import GREY, OILS, axes, row

SLIP = np.linspace(0, 0.3, 301)
AT = (1.25, 30.0, 70.0)  # GPa, m/s, degC: the middle of the paper's tests


def regions() -> Figure:
    """A traction curve with its regions."""
    figure, one = axes(xlabel="Slide-roll ratio S (1)", ylabel="Traction coefficient mu (1)")
    mu = deng2026_study.printed("4102").predict_at(*AT, SLIP).traction_coefficient
    one.plot(SLIP, mu)
    peak = SLIP[np.argmax(mu)]
    for edge in (0.01, peak):
        one.axvline(edge, color=GREY, ls=":")
    for at, text in ((0.02, "non-linear"), (peak + 0.005, "thermal")):
        one.text(at, 0.0005, text, rotation=90, fontsize=9)
    one.annotate("linear", (0.005, 0.0018), (0.004, 0.008), arrowprops={"arrowstyle": "->"})
    one.annotate("peak", (peak, mu.max()), (0.12, mu.max()), arrowprops={"arrowstyle": "->"})
    one.set(ylim=(0, None), xlim=(0, 0.3))
    return figure


def conditions() -> Figure:
    """How pressure, speed and temperature move the curve."""
    figure, three = row(3, 9.6, 3.4)
    law = deng2026_study.printed("4102")
    levels = {0: (1.0, 1.25, 1.5), 1: (25, 30, 40), 2: (25, 70, 120)}
    units = ("GPa", "m/s", "°C")
    titles = ("pressure", "speed", "temperature")
    for place, (one, title) in enumerate(zip(three, titles, strict=True)):
        for level, style in zip(levels[place], ("-", "--", ":"), strict=True):
            at = [*AT]
            at[place] = level
            mu = law.predict_at(*at, SLIP).traction_coefficient
            one.plot(SLIP, mu, style, label=f"{level:g} {units[place]}")
        one.set(title=title, xlabel="Slide-roll ratio S (1)", ylim=(0, 0.031))
        one.legend()
    three[0].set_ylabel("Traction coefficient mu (1)")
    return figure


def oils() -> Figure:
    """The three oils of the paper, by its printed constants."""
    figure, one = axes(xlabel="Slide-roll ratio S (1)", ylabel="Traction coefficient mu (1)")
    for name, style in zip(NAMES, ("-", "--", ":"), strict=True):
        mu = deng2026_study.printed(name).predict_at(*AT, SLIP).traction_coefficient
        one.plot(SLIP, mu, style, color=OILS[name], label=name)
    one.legend(title="oil")
    one.set(xlim=(0, 0.3), ylim=(0, None))
    return figure


def traction_map() -> Figure:
    """mu over speed and temperature."""
    figure, one = axes(xlabel="Entrainment speed U (m/s)", ylabel="Inlet temperature T (°C)")
    speed, temperature = np.meshgrid(np.linspace(25, 40, 80), np.linspace(25, 120, 80))
    mu = (
        deng2026_study.printed("4102")
        .predict_at(1.25, speed, temperature, 0.05)
        .traction_coefficient
    )
    shown = one.contourf(speed, temperature, mu, 12, cmap="cividis")
    one.contour(speed, temperature, mu, shown.levels, colors="white", linewidths=0.4)
    figure.colorbar(shown, label="Traction coefficient mu (1)")
    one.grid(visible=False)
    return figure


def shapes() -> Figure:
    """The laws fitted to one curve of the first."""
    figure, one = axes(xlabel="Slide-roll ratio S (1)", ylabel="Traction coefficient mu (1)")
    slip = SLIP[3::6]
    mu = deng2026_study.printed("4102").predict_at(*AT, slip).traction_coefficient
    one.plot(slip, mu, "o", color=GREY, ms=3, label="points of the paper's law")
    styles = ("-", "--", ":", "-.")
    names = [name for name in ("eyring", "carreau", "tanh") if name in LAWS]
    for name, style in zip(names, styles, strict=False):
        fit = oilfilm.fit(*AT, slip, mu, law=name, bootstrap=20, searches=2)
        one.plot(SLIP, fit.predict(*AT, SLIP).traction_coefficient, style, label=name)
    one.legend()
    one.set(xlim=(0, 0.3), ylim=(0, None))
    return figure
