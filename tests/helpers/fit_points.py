"""Accepted points simulated from the printed constants, for the tests of fits."""

import numpy as np
import pandas as pd

from campaigns import printed
from oilfilm.fitting.problem import CurveData, Problem, build_problem, curve_data
from oilfilm.randomness import generator
from oilfilm.traction import LAWS
from oilfilm.traction.laws.deng2026 import traction_coefficient

LAW = LAWS["deng2026"]
P, U, T = [1.0, 1.25, 1.5], [25.0, 30.0, 35.0, 40.0], [25.0, 50.0, 70.0, 85.0, 100.0, 120.0]


def make_points(
    oil: str, conditions: list[tuple[float, float, float]], noise: float = 0.0
) -> pd.DataFrame:
    random = generator(5, "points", oil)
    slip = np.linspace(0, 0.3, 31)
    frames = []
    for number, (p, u, t) in enumerate(conditions):
        mu = traction_coefficient(printed()[oil], p, u, t, slip)
        frames.append(
            pd.DataFrame(
                {
                    "run_id": f"run{number:03d}",
                    "oil": oil,
                    "first_row": np.arange(len(slip)),
                    "slide_roll_ratio": slip,
                    "max_hertz_pressure_gpa": p,
                    "entrainment_speed_m_s": u,
                    "inlet_temperature_c": t,
                    "traction_coefficient": mu + noise * random.standard_normal(len(slip)),
                    "traction_coefficient_se": noise,
                    "load_n": 80.0,
                    "traction_force_n": 80.0 * mu,
                    "load_systematic_n": np.nan,
                    "traction_force_systematic_n": np.nan,
                    "entrainment_speed_systematic_m_s": np.nan,
                    "inlet_temperature_systematic_c": np.nan,
                    "accepted": True,
                }
            )
        )
    return pd.concat(frames, ignore_index=True)


def matrix(ps: list[float] = P, us: list[float] = U, ts: list[float] = T) -> list:
    return [(p, u, t) for p in ps for u in us for t in ts]


def problem_of(points: pd.DataFrame) -> tuple[Problem, CurveData]:
    """The problem of fitting the law to points in which every condition varies, and its curves."""
    data = curve_data(points)
    return build_problem(LAW, data, np.ones(3, dtype=bool)), data
