"""The shipped bearings, oils and laws as bearings ask for them, for tests and benchmarks."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from campaigns import oil_of, printed, rig_contact
from oilfilm.bearing.ellipse import TractionLaw, grid
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.friction import QUADRATURE, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.settings.config import Config
from oilfilm.settings.messages import load
from oilfilm.settings.rig import BearingFile
from oilfilm.torque.load_variables import LawInBearing
from oilfilm.traction import LAWS

CONFIG = Path(__file__).parents[2] / "config"
FOLDER = CONFIG / "bearings"
SHIPPED = ("harris-218", "mainshaft-167", "nasa-35")
RPM = np.pi / 30  # rad/s
RIG = rig_contact()
SETTINGS = load(CONFIG / "config.yaml", Config).bearing


def shipped(name: str) -> Bearing:
    return load(FOLDER / f"{name}.yaml", BearingFile).bearing(name)


def any_bearing(ball: float, room: float, angle: float, inner: float, outer: float) -> Bearing:
    """A bearing by ball diameter, pitch diameter over it, contact angle, groove curvatures."""
    like = shipped("harris-218")
    return replace(
        like,
        ball_diameter_m=ball,
        pitch_diameter_m=ball * room,
        ball_count=max(int(0.9 * np.pi * room), 3),
        contact_angle_rad=np.radians(angle),
        groove_curvature=(inner, outer),
        cage=replace(like.cage, land_diameter_m=1.05 * ball * room),
    )


def printed_law(oil: str, load_variable: str = "stress") -> LawInBearing:
    law = LAWS["deng2026"]
    fitted = FittedLaw(law, Coefficients.bare(law, printed()[oil]))
    return LawInBearing.of(fitted, load_variable, RIG, SETTINGS.law_floor.model_dump())


def lubrication(
    oil: str, temperature_c: float | np.ndarray, points: int, **changed: float
) -> Lubrication:
    settings = SETTINGS.model_copy(update=changed)
    return Lubrication.of(
        oil_of(oil),
        np.full(points, temperature_c),
        settings.drag_coefficient,
        settings.oil_volume_fraction,
    )


def problem(
    bearing: Bearing,
    points: OperatingPoints,
    oil: str = "4050",
    temperature_c: float | np.ndarray = 100.0,
    law: TractionLaw | None = None,
    nodes: tuple[int, int] = QUADRATURE,
    **changed: float,
) -> FrictionProblem:
    """A bearing with an oil and its printed law, or another law."""
    known = lubrication(oil, temperature_c, len(points.axial_load_n), **changed)
    return FrictionProblem(bearing, points, known, law or printed_law(oil), grid(*nodes))


def equilibrium(*asked: Any, **also: Any) -> FrictionEquilibrium:
    """The friction equilibrium of `problem`, which is there at every point."""
    found = friction_equilibrium(problem(*asked, **also))
    assert found.solution.converged.all()
    return found
