"""The mainshaft bearing of the demonstration, by the printed constants."""

from functools import cache

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

import deng2026_study
from deng2026_study.settings import default_settings
from examples import NAMES, bearing, contact, oil, settings
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.friction import FrictionProblem
from oilfilm.bearing.inputs import Inputs
from oilfilm.bearing.kinematics import inner_slide_roll_ratio
from oilfilm.bearing.quasistatic import OperatingPoints, raceway_control
from oilfilm.bearing.resistance import HEATS, Lubrication
from oilfilm.bearing.torque import torque_terms
from oilfilm.torque.load_variables import LawInBearing
from style import OILS, axes, row

STYLES = ("-", "--", ":")
SPEED_RPM = np.linspace(3000, 16000, 12)


@cache
def terms(name: str, axial_load_n: float = 20e3):
    """Torque and motion over speed with an oil of 100 degC."""
    many = len(SPEED_RPM)
    duty = OperatingPoints.axial(np.full(many, axial_load_n), SPEED_RPM * np.pi / 30)
    assumed = settings().bearing
    oil_film = Lubrication.flooded(
        oil(name), np.full(many, 100.0), assumed.drag_coefficient, assumed.oil_volume_fraction
    )
    law = LawInBearing.from_fit(
        deng2026_study.printed(name), "stress", contact(), assumed.law_floor.model_dump()
    )
    box = default_settings().printed.boxes.tested.model_dump()
    tested = {key: tuple(ends) for key, ends in box.items()}
    drawing = FrictionProblem(bearing(), duty, oil_film, law)
    uncertain = {**bearing().uncertain, **assumed.uncertain_inputs()}
    operation = drawing.with_inputs(Inputs.without_draws(uncertain, many))
    return torque_terms(friction_equilibrium(operation), tested)


def contact_angles() -> Figure:
    """Contact angles over speed: centrifugal force separates them."""
    figure, one = axes(xlabel="Speed of the inner ring (rpm)", ylabel="Contact angle (°)")
    speed = np.linspace(1, 16000, 40)
    duty = OperatingPoints.axial(np.full(40, 20e3), speed * np.pi / 30)
    angle = np.degrees(raceway_control(bearing(), duty).contacts.contact_angle_rad)
    one.plot(speed, angle[:, 0], "-", label="inner race")
    one.plot(speed, angle[:, 1], "--", label="outer race")
    one.legend()
    return figure


def torque() -> Figure:
    """Friction torque of three oils over speed."""
    figure, one = axes(xlabel="Speed of the inner ring (rpm)", ylabel="Friction torque (N m)")
    for name, style in zip(NAMES, STYLES, strict=True):
        one.plot(SPEED_RPM, terms(name)["torque_n_m"], style, color=OILS[name], label=name)
    one.legend(title="oil")
    one.set(ylim=(0, None))
    return figure


def parts() -> Figure:
    """What the torque consists of."""
    figure, one = axes(xlabel="Speed of the inner ring (rpm)", ylabel="Friction torque (N m)")
    found = terms("4050")
    values = [found[f"{name}_torque_n_m"] for name in HEATS]
    colours = colormaps["cividis"](np.linspace(0, 1, len(HEATS)))
    one.stackplot(SPEED_RPM, values, labels=HEATS, colors=colours, edgecolor="white")
    one.legend(loc="upper left")
    return figure


def cage_slip() -> Figure:
    """Cage slip over speed at three loads."""
    figure, one = axes(xlabel="Speed of the inner ring (rpm)", ylabel="Cage slip (%)")
    for load, style in ((1e3, "-"), (3e3, "--"), (20e3, ":")):
        one.plot(
            SPEED_RPM, 100 * terms("4050", load)["cage_slip"], style, label=f"{load / 1e3:g} kN"
        )
    one.axhline(15, color="black", lw=0.8)
    one.text(3200, 15.5, "limit of the paper", fontsize=8)
    one.legend(title="axial load")
    return figure


def slip_kinematics() -> Figure:
    """Slide-roll ratio at the inner race over cage slip."""
    figure, one = axes(xlabel="Cage slip (%)", ylabel="Slide-roll ratio S, inner race (1)")
    slip = np.linspace(0, 0.4, 100)
    for gamma, style in ((0.0, "-"), (0.15, "--"), (0.3, ":")):
        one.plot(100 * slip, inner_slide_roll_ratio(slip, gamma), style, label=f"gamma = {gamma:g}")
    one.axhline(0.3, color="black", lw=0.8)
    one.text(1, 0.31, "largest slip of the paper's tests", fontsize=8)
    one.legend()
    return figure


def friction_heat() -> Figure:
    """Friction heat over speed with its film ratio."""
    figure, two = row(2)
    for name, style in zip(NAMES, STYLES, strict=True):
        found = terms(name)
        heat = found["torque_n_m"] * SPEED_RPM * np.pi / 30 / 1e3
        two[0].plot(SPEED_RPM, heat, style, color=OILS[name], label=name)
        two[1].plot(SPEED_RPM, found["lambda_ratio"], style, color=OILS[name], label=name)
    two[0].set(xlabel="Speed of the inner ring (rpm)", ylabel="Friction heat (kW)", ylim=(0, None))
    two[1].set(xlabel="Speed of the inner ring (rpm)", ylabel="Smallest lambda (1)", ylim=(0, None))
    two[1].axhline(3, color="black", lw=0.8)
    two[0].legend(title="oil")
    return figure
