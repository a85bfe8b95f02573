"""What the findings show: the order of the oils, and what the lost signs leave open."""

from itertools import product

import numpy as np
from matplotlib.figure import Figure

import deng2026_study
import oilfilm
from examples import NAMES, contact, simulated_points
from law import AT, SLIP
from oilfilm.fits.fitted import Coefficients, FittedLaw
from style import GREEN, GREY, OILS, axes

# Exponents of 4010 whose sign no statement of the paper gives.
_OPEN = ("B1", "B2", "C2", "C3")


def order_of_oils() -> Figure:
    """mu of the three oils over pressure, by the printed constants."""
    figure, one = axes(
        xlabel="Maximum Hertz pressure P (GPa)", ylabel="Traction coefficient mu (1)"
    )
    pressure = np.linspace(0.8, 2.5, 100)
    for name, style in zip(NAMES, ("-", "--", ":"), strict=True):
        mu = deng2026_study.printed(name).predict_at(pressure, 30, 70, 0.05).traction_coefficient
        one.plot(pressure, mu, style, color=OILS[name], label=name)
    one.legend(title="oil")
    one.set(xlim=(0.8, 2.5), ylim=(0, None))
    return figure


def open_signs() -> Figure:
    """mu of 4010 for each choice of its open signs."""
    figure, one = axes(xlabel="Slide-roll ratio S (1)", ylabel="Traction coefficient mu (1)")
    law = deng2026_study.printed("4010")
    names = [constant.name for constant in law.law.constants]
    for signs in product((1, -1), repeat=len(_OPEN)):
        turned = dict(zip(_OPEN, signs, strict=True))
        constants = law.coefficients.constants * [turned.get(name, 1) for name in names]
        other = FittedLaw(law.law, Coefficients.from_constants(law.law, constants))
        mu = other.predict_at(1.5, 40, 120, SLIP).traction_coefficient
        used = all(sign == 1 for sign in signs)
        one.plot(SLIP, mu, color=GREEN if used else GREY, lw=2.5 if used else 0.7)
    one.plot([], color=GREEN, label="signs in use")
    one.plot([], color=GREY, label="the other 15 choices")
    one.legend()
    one.set(xlim=(0, 0.3), ylim=(0, None))
    return figure


def near_zero() -> Figure:
    """mu at small slip of Wang-Deng laws that were fitted to points of the paper's law."""
    figure, one = axes(xlabel="Slide-roll ratio S (1)", ylabel="Traction coefficient mu (1)")
    slip = np.linspace(0, 0.002, 50)
    pressure, speed, temperature = AT
    mu = deng2026_study.printed("4102").predict_at(*AT, slip).traction_coefficient
    one.plot(slip, mu, color=GREY, label="paper's law, which made the points")
    points = simulated_points()
    table = points.set_axis(["p [GPa]", "U [m/s]", "T [degC]", "SRR", "mu", "curve"], axis=1)
    table["load [N]"] = contact().load_n(table.pop("p [GPa]"))
    at = np.tile([contact().load_n(pressure), speed, temperature], (len(slip), 1))
    for name, style in (("wang-deng-load", "--"), ("wang-deng-critical-load", ":")):
        fit = oilfilm.fit_table(table, law=name, bootstrap=20, searches=2).law
        one.plot(slip, fit.predict(at, slip).traction_coefficient, style, label=fit.law.title)
    one.axhline(0, color=GREY, lw=0.7)
    one.legend()
    one.set(xlim=(0, 0.002), xticks=np.linspace(0, 0.002, 5))
    return figure
