"""Five bearings whose whole friction equilibrium another program has solved.

docs/physics.md, Five bearings: vector mechanics of its own, 24 x 48 polar nodes, ellipses by
complete elliptic integrals. Nothing grows, no oil is fed, the contacts are flooded.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from bearings import RPM, problem, shipped
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.torque import torque_terms
from planted_fits import TESTED

MAINSHAFT = shipped("mainshaft-167")


@dataclass(frozen=True)
class Reference:
    """One bearing, its duty, and what the other program found.

    Attributes:
        sizes: Ball diameter and pitch diameter in mm, number of balls, contact angle in degrees,
            curvatures of inner and outer groove.
        land: Ring that guides the cage, and the diameter of its land in mm.
        duty: Oil, axial load in N, speed in rpm, temperature in degC.
        found: Results by column of `torque_terms`.
    """

    sizes: tuple[float, float, int, float, float, float]
    land: tuple[str, float]
    duty: tuple[str, float, float, float]
    found: dict[str, float]


COLUMNS = (
    "torque_n_m",
    "cage_slip",
    "inner_slide_roll_ratio",
    "inner_contact_angle_deg",
    "outer_contact_angle_deg",
    "inner_max_hertz_pressure_gpa",
    "outer_max_hertz_pressure_gpa",
    "traction_torque_n_m",
    "rolling_torque_n_m",
    "hysteresis_torque_n_m",
    "drag_torque_n_m",
    "pocket_torque_n_m",
    "land_torque_n_m",
)
# Half of the last digit that the other program printed, per column, times 1.5: both round.
ROUNDING = (1e-5, 1e-5, 1e-4, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-5, 1e-5)


def found(*values: float) -> dict[str, float]:
    """Results in the order of `COLUMNS`."""
    return dict(zip(COLUMNS, values, strict=True))


# fmt: off
REFERENCES = [
    Reference(
        (15.875, 100, 14, 15, 0.53, 0.52), ("inner", 95), ("4050", 3000, 15000, 80),
        found(0.97185, 0.00404, 0.0066, 21.646, 13.061, 1.4230, 1.3437,
              0.0637, 0.6914, 0.0847, 0.0587, 0.00316, 0.07017),
    ),
    Reference(
        (25.4, 200, 18, 33, 0.515, 0.525), ("outer", 220), ("4102", 40000, 8000, 120),
        found(11.54959, 0.00467, 0.0114, 41.885, 31.931, 1.5718, 1.7187,
              6.2315, 3.2247, 1.3346, 0.5624, 0.01164, 0.18472),
    ),
    Reference(
        (12.7, 75, 13, 25, 0.515, 0.515), ("outer", 82), ("4010", 800, 30000, 100),
        found(0.19536, 0.63648, 1.2380, 32.667, 18.810, 0.8322, 0.8603,
              0.0705, 0.1154, 0.0034, 0.0032, 0.00017, 0.00283),
    ),
    Reference(
        # its table says 0.525 of the outer groove; all thirteen results are those of 0.52
        (19.05, 140, 19, 20, 0.52, 0.52), ("outer", 152), ("4050", 15000, 18000, 70),
        found(5.05115, 0.00854, 0.0135, 31.897, 15.703, 1.5634, 1.7458,
              1.0113, 2.5672, 0.5926, 0.5616, 0.01780, 0.30070),
    ),
    Reference(
        (9.525, 52, 12, 40, 0.54, 0.53), ("inner", 48), ("4010", 1500, 6000, 40),
        found(0.08937, -0.00024, -0.0010, 41.298, 40.130, 1.4501, 1.2174,
              0.0062, 0.0683, 0.0088, 0.0004, 0.00023, 0.00547),
    ),
]
# fmt: on


@pytest.mark.parametrize("reference", REFERENCES, ids=range(1, 6))
def test_the_equilibrium_is_that_of_another_program(reference):
    ball, pitch, count, angle, inner, outer = reference.sizes
    ring, land = reference.land
    cage = replace(
        MAINSHAFT.cage, guided_by_outer_ring=ring == "outer", land_diameter_m=land * 1e-3
    )
    bearing = replace(
        MAINSHAFT,
        ball_diameter_m=ball * 1e-3,
        pitch_diameter_m=pitch * 1e-3,
        ball_count=count,
        contact_angle_rad=np.radians(angle),
        groove_curvature=(inner, outer),
        cage=cage,
    )
    oil, load, speed, temperature = reference.duty
    points = OperatingPoints.from_load_and_speed(float(load), speed * RPM)
    at = problem(bearing, points, oil, float(temperature), oil_volume_fraction=0.0036)
    terms = torque_terms(friction_equilibrium(at), TESTED)
    for (column, value), rounding in zip(reference.found.items(), ROUNDING, strict=True):
        # 1e-4 is how far the two programs' quadratures differ
        expected = pytest.approx(value, rel=1e-4, abs=rounding)
        assert terms[column][0] == expected, column
