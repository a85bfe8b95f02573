"""The tests that a traction rig can run: within its limits and sensors, with a full film.

Decides: which tests the rig can run.
"""

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
from oilfilm.units import BoolArray

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
    points, count = grid.operating_points(), len(known.slip)
    points["load_n"] = film.contact.load_n(points["max_hertz_pressure_gpa"].to_numpy())
    tests = points.iloc[::count].drop(columns="slide_roll_ratio").reset_index(drop=True)
    slip = points["slide_roll_ratio"].to_numpy()
    conditions = tests[list(known.law.conditions)].to_numpy(dtype=float)
    load = tests["load_n"].to_numpy()
    every = Curves(conditions, load, np.repeat(np.arange(len(tests)), count), slip)
    shape = (len(tests), count)
    mu = known.law.traction(known.internal, every.at(known.law)).reshape(shape)
    pressure, speed, temperature = (tests[name].to_numpy() for name in CONDITIONS)
    slip, lambda_ratio = slip.reshape(shape), film.over(grid)[1].reshape(shape)
    reached = slip <= limits.slide_roll_ratio * (1 + 1e-6)
    # why a condition cannot be tested, in the order in which reasons are given
    beyond: dict[str, BoolArray] = {
        "the rig's largest pressure": pressure > limits.max_hertz_pressure_gpa,
        "the rig's largest speed": speed > limits.entrainment_speed_m_s,
        "the rig's highest temperature": temperature > limits.inlet_temperature_c,
    }
    if scale is not None:
        reached &= speed[:, np.newaxis] * (1 + slip / 2) <= scale.surface_speed_m_s
        force = (load[:, np.newaxis] * mu).max(axis=1)
        beyond |= {
            "the load sensor's full scale": np.asarray(load > scale.load_n),
            "the force sensor's full scale": np.asarray(force > scale.traction_force_n),
            "the temperature sensor's full scale": np.asarray(temperature > scale.temperature_c),
        }
    thin = reached & ~(lambda_ratio > lambda_limit)
    beyond |= {
        "the rig's smallest load": np.asarray(load < (limits.smallest_load_n or 0.0)),
        "slips that the rig reaches at this speed": np.asarray(reached.sum(axis=1) < _FEWEST_SLIPS),
        f"a full film (lambda > {lambda_limit:g})": np.asarray(thin.any(axis=1)),
    }
    left, left_out = np.ones(len(tests), dtype=bool), {}
    for reason, is_beyond in beyond.items():
        left_out[reason] = int((left & is_beyond).sum())
        left &= ~is_beyond
    if not left.any():
        counts = ", ".join(f"{reason} ({count})" for reason, count in left_out.items() if count)
        raise OilfilmError(
            f"config/rigs/{name}.yaml, plan.levels: none of {len(left)} conditions can be run; "
            f"they are beyond {counts}. Change plan.levels, or correct the rig's limits."
        )
    last = np.arange(len(tests)), count - 1 - np.argmax(reached[:, ::-1], axis=1)
    tests = tests.assign(slide_roll_ratio=slip[last], lambda_ratio=lambda_ratio[last])[left]
    # points that are reached, of curves that are left
    curve = np.repeat(np.arange(left.sum()), reached[left].sum(axis=1))
    curves = Curves(conditions[left], load[left], curve, slip[left][reached[left]])
    return Candidates(tests.reset_index(drop=True), curves, left_out)
