"""What the calibration of a rig's sensors does to the constants: errors that runs share.

Decides: errors of constants from the calibration of the rig.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm.fits.engine import Optimum, polish
from oilfilm.fits.problem import Problem, build_problem, curve_data
from oilfilm.units import BoolArray, FloatArray

# In the order of the refits.
SENSORS = ("load", "traction force", "entrainment speed", "inlet temperature")


def calibration_refits(
    problem: Problem, optimum: Optimum, points: pd.DataFrame, varied: BoolArray
) -> FloatArray:
    """The free constants refitted with each sensor off by its standard uncertainty.

    All points of a rig share such an error, so the sensors are shifted one at a time, everywhere;
    the root of the summed squares of the constants' changes is their systematic standard error.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        points: The oil's rows of the table of points.
        varied: Conditions that gave exponents.

    Returns:
        One row per sensor, in the order of SENSORS; no rows where the calibration of one is not
        stated.
    """
    accepted = points[points["accepted"]]
    refits = []
    for shifted in _shifted(accepted):
        data = curve_data(shifted, problem.law.conditions)
        if not np.isfinite(data.mu).all() or not np.isfinite(data.conditions[:, varied]).all():
            return np.empty((0, len(optimum.values)))
        moved = replace(problem, at=build_problem(problem.law, data, varied).at, mu=data.mu)
        refits.append(polish(moved, optimum.values).values)
    return np.array(refits)


def _shifted(points: pd.DataFrame) -> list[pd.DataFrame]:
    """The points as they would read with one sensor each off by its standard uncertainty.

    A load of (1 + e) W makes mu = F/W smaller by 1/(1 + e) and the pressure, which goes with the
    cube root of the load, larger.
    """
    load = 1 + points["load_systematic_n"] / points["load_n"]
    force = points["traction_force_systematic_n"] / points["traction_force_n"].abs()
    # at no force at all there is nothing to be a share of
    gain = 1 + force.where(points["traction_force_n"] != 0, 0.0)
    mu, pressure = points["traction_coefficient"], points["max_hertz_pressure_gpa"]
    speed, temperature = points["entrainment_speed_m_s"], points["inlet_temperature_c"]
    return [
        points.assign(
            traction_coefficient=mu / load,
            max_hertz_pressure_gpa=pressure * np.cbrt(load),
            load_n=points["load_n"] * load,
        ),
        points.assign(traction_coefficient=mu * gain),
        # an error of speed that both bodies share leaves the slide-roll ratio as it is
        points.assign(entrainment_speed_m_s=speed + points["entrainment_speed_systematic_m_s"]),
        points.assign(inlet_temperature_c=temperature + points["inlet_temperature_systematic_c"]),
    ]
