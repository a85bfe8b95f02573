"""Accepted points simulated from the printed constants, for the tests of fits."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from campaigns import printed
from oilfilm import tables
from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.fits.global_search import Optimum, converge
from oilfilm.fits.problem import Problem, build_problem, curve_data
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law, to_internal
from oilfilm.traction.laws.deng2026 import traction_coefficient

LAW = LAWS["deng2026"]
# Levels of pressure in GPa, speed in m/s and temperature in degC.
P, U, T = [1.0, 1.25, 1.5], [25.0, 30.0, 35.0, 40.0], [25.0, 50.0, 70.0, 85.0, 100.0, 120.0]


def accepted_points(
    oil: str,
    conditions: pd.DataFrame,
    slip: FloatArray,
    mu: FloatArray,
    noise: float,
    random: np.random.Generator,
) -> pd.DataFrame:
    """A table of accepted points: one curve per row of conditions, each at all the slips.

    `mu` is without noise, shape (curves * slips,).
    """
    points = conditions.loc[conditions.index.repeat(len(slip))].reset_index(drop=True)
    no_calibration = [column for column in tables.columns("points") if "_systematic_" in column]
    return points.assign(
        oil=oil,
        run_id=np.repeat([f"run{number:03d}" for number in range(len(conditions))], len(slip)),
        first_row=np.tile(np.arange(len(slip)), len(conditions)),
        slide_roll_ratio=np.tile(slip, len(conditions)),
        traction_coefficient=mu + noise * random.standard_normal(len(mu)),
        traction_coefficient_se=noise,
        traction_force_n=mu * points["load_n"],
        accepted=True,
        film_judgement="full film",
        **dict.fromkeys(no_calibration, np.nan),
    )


def make_points(
    oil: str, conditions: list[tuple[float, float, float]], noise: float = 0.0
) -> pd.DataFrame:
    """Accepted points on the printed law of an oil, with noise of this standard deviation."""
    slip = np.linspace(0, 0.3, 31)
    frame = pd.DataFrame(conditions, columns=list(CONDITIONS), dtype=float).assign(load_n=80.0)
    levels = (frame[[name]].to_numpy() for name in CONDITIONS)
    mu = traction_coefficient(printed()[oil], *levels, slip).ravel()
    return accepted_points(oil, frame, slip, mu, noise, generator(5, "points", oil))


def matrix(ps: list[float] = P, us: list[float] = U, ts: list[float] = T) -> list:
    """All combinations of levels of P, U and T."""
    return [(p, u, t) for p in ps for u in us for t in ts]


def problem_of(points: pd.DataFrame, law: Law = LAW) -> Problem:
    """The problem of fitting a law to points in which every condition varies."""
    return build_problem(law, curve_data(points, law.conditions), np.ones(3, dtype=bool))


def polished(
    points: pd.DataFrame, truth: Sequence[float] | FloatArray, law: Law = LAW
) -> tuple[Problem, Optimum]:
    """The problem, and the optimum next to its true constants."""
    problem = problem_of(points, law)
    return problem, converge(problem, to_internal(law, np.array(truth))[problem.is_free])
