"""Shipped bearings with oils and laws, for tests and benchmarks."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from campaigns import oil_of, printed, rig_contact
from oilfilm.bearing.ellipse import TractionLaw, gauss_rule
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.friction import NODE_COUNTS, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.inputs import InputValues
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.settings.config import Config
from oilfilm.settings.messages import load
from oilfilm.settings.rig import BearingFile
from oilfilm.torque.load_variables import LawInBearing
from oilfilm.traction import LAWS

CONFIG = Path(__file__).parents[2] / "config"
BEARINGS_FOLDER = CONFIG / "bearings"
SHIPPED = ("harris-218", "mainshaft-167", "nasa-35")
RPM = np.pi / 30  # rad/s
RIG_CONTACT = rig_contact()
SETTINGS = load(CONFIG / "config.yaml", Config).bearing


def shipped(name: str) -> Bearing:
    return load(BEARINGS_FOLDER / f"{name}.yaml", BearingFile).bearing(name)


def exact_keys(name: str) -> dict[str, dict[str, list[float]]]:
    """Keys of the bearing's file with ranges of almost no width."""
    file = load(BEARINGS_FOLDER / f"{name}.yaml", BearingFile)
    exact = {}
    for section in ("mounting", "oil_supply"):
        keys = getattr(file, section)
        ends = {}
        for key in type(keys).model_fields:
            if key.endswith("_range"):
                value = getattr(keys, key.removesuffix("_range"))
                ends[key] = [value - 1e-9 * max(abs(value), 1), value]
        exact[section] = ends
    return exact


def any_bearing(
    ball: float, pitch_over_ball: float, angle: float, inner: float, outer: float
) -> Bearing:
    """A bearing from its sizes.

    Args:
        ball: Ball diameter, in m.
        pitch_over_ball: Pitch diameter over ball diameter.
        angle: Contact angle, in degrees.
        inner: Groove curvature of the inner ring.
        outer: Groove curvature of the outer ring.
    """
    template = shipped("harris-218")
    return replace(
        template,
        ball_diameter_m=ball,
        pitch_diameter_m=ball * pitch_over_ball,
        ball_count=max(int(0.9 * np.pi * pitch_over_ball), 3),
        contact_angle_rad=np.radians(angle),
        groove_curvature=(inner, outer),
        cage=replace(template.cage, land_diameter_m=1.05 * ball * pitch_over_ball),
    )


def printed_law(oil: str, load_variable: str = "stress") -> LawInBearing:
    law = LAWS["deng2026"]
    fitted = FittedLaw(law, Coefficients.from_constants(law, printed()[oil]))
    return LawInBearing.from_fit(
        fitted, load_variable, RIG_CONTACT, SETTINGS.law_floor.model_dump()
    )


def lubrication(
    oil: str, temperature_c: float | np.ndarray, points: int, **changed: float
) -> Lubrication:
    settings = SETTINGS.model_copy(update=changed)
    return Lubrication.flooded(
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
    nodes: tuple[int, int] = NODE_COUNTS,
    **changed: float,
) -> FrictionProblem:
    """The friction problem of a bearing with an oil, by default with the printed law of the oil."""
    inlet = lubrication(oil, temperature_c, len(points.axial_load_n), **changed)
    return FrictionProblem(bearing, points, inlet, law or printed_law(oil), gauss_rule(*nodes))


def in_operation(at_rest: FrictionProblem) -> FrictionProblem:
    """The problem with growth, feed oil and starvation, by the values of bearing and settings."""
    uncertain = {**at_rest.bearing.uncertain_inputs, **SETTINGS.uncertain_inputs()}
    return at_rest.with_inputs(InputValues.nominal(uncertain, len(at_rest.points.axial_load_n)))


def equilibrium(*arguments: Any, **options: Any) -> FrictionEquilibrium:
    """The friction equilibrium of `problem`, which must exist at every point."""
    motion = friction_equilibrium(problem(*arguments, **options))
    assert motion.solution.converged.all()
    return motion
