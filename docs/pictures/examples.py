"""The settings, contact, logs and fits that several pictures show; each is made once."""

import io
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

import deng2026_study
import oilfilm
from oilfilm.api.arrays import ArrayFit
from oilfilm.base.home import reference_file
from oilfilm.bearing.geometry import Bearing
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import BearingFile
from simulated_lab.printed import read_printed_constants
from simulated_lab.simulate import simulate_campaign

CONFIG = Path(__file__).parents[2] / "config"
NAMES = ("4102", "4050", "4010")
BEARING = "mainshaft-167"


@cache
def settings() -> Settings:
    """The settings of the demonstration."""
    return resolve(CONFIG, {"campaign": "demo"})


def oil(name: str) -> Oil:
    """An oil of the demonstration."""
    return settings().oils[name].properties()


def contact() -> Contact:
    """The ball-on-disc contact of the demonstration."""
    (rig,) = settings().rigs.values()
    return rig.contact()


@cache
def bearing() -> Bearing:
    """The mainshaft bearing of the demonstration."""
    return load(CONFIG / f"bearings/{BEARING}.yaml", BearingFile).bearing(BEARING)


@cache
def log(defect: str = "") -> pd.DataFrame:
    """A simulated log of the demonstration, the first with that defect."""
    constants = read_printed_constants(reference_file("printed_coefficients"))
    for run, content, _ in simulate_campaign(settings(), constants):
        if run.defect == defect:
            return pd.read_csv(io.BytesIO(content), comment="#")
    raise ValueError(f"no simulated log has the defect {defect!r}")


def slip_of(rows: pd.DataFrame) -> "pd.Series[float]":
    """Slide-roll ratio of a log of the demonstration's rig."""
    (rig,) = settings().rigs.values()
    ball = rows["ball_speed_rpm"] * rig.ball_track_radius_m
    disc = rows["disc_speed_rpm"] * rig.disc_track_radius_m
    return 2 * (disc - ball) / (disc + ball)


@cache
def simulated_points() -> pd.DataFrame:
    """Points of the printed law of 4102; each curve has errors of its own, as on a rig."""
    random = np.random.default_rng(7)
    law = deng2026_study.printed("4102")
    slip = np.linspace(0.01, 0.3, 20)
    curves = []
    for pressure in (1.0, 1.25, 1.5):
        for speed in (25.0, 40.0):
            for temperature in (25.0, 70.0, 120.0):
                load_error, kelvin = random.normal(0, (0.01, 0.7))
                true = law.predict_at(
                    pressure * (1 + load_error), speed, temperature + kelvin, slip
                ).traction_coefficient
                mu = true * (1 + random.normal(0, 0.01, len(slip)))
                row = {"P": pressure, "U": speed, "T": temperature, "S": slip, "mu": mu}
                curves.append(pd.DataFrame({**row, "curve": len(curves)}))
    return pd.concat(curves, ignore_index=True)


@cache
def simulated_fit() -> ArrayFit:
    """The paper's law fitted to these points."""
    points = simulated_points()
    at = [points[name] for name in ("P", "U", "T", "S", "mu")]
    return oilfilm.fit(*at, curve=points["curve"], bootstrap=200, searches=3)
