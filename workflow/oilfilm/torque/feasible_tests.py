"""The tests that a traction rig can run: within its limits and sensors, with a full film.

Decides: which tests the rig can run.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm.errors import OilfilmError
from oilfilm.fits.curve_errors import Curves
from oilfilm.fits.measured_curves import Known
from oilfilm.settings.config import PlanLevels
from oilfilm.settings.rig import Rig
from oilfilm.torque.operating_grid import Film, Grid
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import BoolArray, FloatArray

# As many as a curve has coefficients at least.
_FEWEST_SLIPS = 3


@dataclass(frozen=True)
class Candidates:
    """Tests that a rig can run.

    Attributes:
        tests: One row per test: P, U, T, load, largest slip, lambda there.
        curves: Their points.
        left_out: Number of conditions left out, by the reason.
    """

    tests: pd.DataFrame
    curves: Curves
    left_out: dict[str, int]


def candidates(
    levels: PlanLevels, rig: Rig, name: str, film: Film, lambda_limit: float, known: Known
) -> Candidates:
    """The tests among the levels of a plan that a rig can run with a full film.

    A test has the slips of the measured curves, as far as the rig and its speed sensor reach.

    Raises:
        OilfilmError: The rig's limits are not known, or no test is left.
    """
    limits, scale = rig.limits, rig.full_scale
    if limits is None:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: lacks the key `limits`, which a plan needs. Write the "
            "highest max_hertz_pressure_gpa, entrainment_speed_m_s, inlet_temperature_c and "
            "slide_roll_ratio at which the rig can run."
        )
    pressures, speeds, temperatures = (
        np.array(getattr(levels, each), dtype=float) for each in CONDITIONS
    )
    grid = Grid(pressures, speeds, temperatures, known.slip)
    points = grid.operating_points()
    pressure, speed, temperature, slip = points.to_numpy(dtype=float).T
    load = film.contact.load_n(pressure)
    lambda_ratio = film.over(grid)[1].ravel()
    shape = (-1, len(known.slip))
    tests = points.drop_duplicates(list(CONDITIONS))[list(CONDITIONS)].reset_index(drop=True)
    tests = tests.assign(load_n=load.reshape(shape)[:, 0])
    every = Curves(
        tests[list(known.law.conditions)].to_numpy(dtype=float),
        tests["load_n"].to_numpy(dtype=float),
        np.repeat(np.arange(len(tests)), len(known.slip)),
        slip,
    )
    force = load * known.law.traction(known.internal, every.at(known.law))
    reached = slip <= limits.slide_roll_ratio * (1 + 1e-6)
    largest: dict[str, tuple[FloatArray, float | None]] = {
        "the rig's largest pressure": (pressure, limits.max_hertz_pressure_gpa),
        "the rig's largest speed": (speed, limits.entrainment_speed_m_s),
        "the rig's highest temperature": (temperature, limits.inlet_temperature_c),
    }
    if scale is not None:
        reached &= speed * (1 + slip / 2) <= scale.surface_speed_m_s
        largest |= {
            "the load sensor's full scale": (load, scale.load_n),
            "the force sensor's full scale": (force, scale.traction_force_n),
            "the temperature sensor's full scale": (temperature, scale.temperature_c),
        }
    beyond: dict[str, BoolArray] = {
        reason: np.asarray((values > limit).reshape(shape).any(axis=1))
        for reason, (values, limit) in largest.items()
        if limit is not None
    }
    if limits.smallest_load_n is not None:
        beyond["the rig's smallest load"] = (load < limits.smallest_load_n).reshape(shape)[:, 0]
    few = reached.reshape(shape).sum(axis=1) < _FEWEST_SLIPS
    beyond["slips that the rig reaches at this speed"] = few
    thin = reached & ~(lambda_ratio > lambda_limit)
    beyond[f"a full film (lambda > {lambda_limit:g})"] = np.asarray(thin.reshape(shape).any(axis=1))
    reached, lambda_ratio = reached.reshape(shape), lambda_ratio.reshape(shape)
    return _feasible(tests, every, reached, lambda_ratio, beyond, name)


def _feasible(
    tests: pd.DataFrame,
    every: Curves,
    reached: BoolArray,
    lambda_ratio: FloatArray,
    beyond: Mapping[str, BoolArray],
    rig: str,
) -> Candidates:
    """The tests that are beyond nothing, and for how many others each reason is the first."""
    left = np.ones(len(reached), dtype=bool)
    left_out = {}
    for reason, is_beyond in beyond.items():
        left_out[reason] = int((left & is_beyond).sum())
        left &= ~is_beyond
    if not left.any():
        counts = ", ".join(f"{reason} ({count})" for reason, count in left_out.items() if count)
        raise OilfilmError(
            f"config/rigs/{rig}.yaml, plan.levels: none of {len(left)} conditions can be run; "
            f"they are beyond {counts}. Change plan.levels, or correct the rig's limits."
        )
    # points that are reached, of curves that are left
    point = (reached & left[:, np.newaxis]).ravel()
    number = np.cumsum(left) - 1
    last = reached.shape[1] - 1 - np.argmax(reached[:, ::-1], axis=1)
    row = np.arange(len(reached))
    slip = every.slip.reshape(reached.shape)
    tests = tests.assign(
        slide_roll_ratio=slip[row, last],
        lambda_ratio=lambda_ratio[row, last],
    )
    curves = Curves(
        every.conditions[left], every.load_n[left], number[every.curve[point]], every.slip[point]
    )
    return Candidates(tests[left].reset_index(drop=True), curves, left_out)
