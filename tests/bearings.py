"""The shipped bearings, for tests and benchmarks."""

from pathlib import Path

import numpy as np

from oilfilm.bearing.geometry import Bearing, bearing_from_config
from oilfilm.config import load_checked

FOLDER = Path(__file__).parents[1] / "config" / "bearings"
SHIPPED = ("harris-218", "mainshaft-167", "nasa-35")
RPM = np.pi / 30  # rad/s


def shipped(name: str) -> Bearing:
    return bearing_from_config(name, load_checked(FOLDER / f"{name}.yaml", "bearing"))
