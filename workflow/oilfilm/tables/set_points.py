"""Set points of runs: their columns, the levels that they mean, and the conditions of a matrix.

Decides: which set points of runs are the same.
"""

import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.ties import exceeds, first_smallest
from oilfilm.base.units import PA_PER_GPA
from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.settings.config import SameSetPointSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig

SET_POINTS = (
    "nominal_max_hertz_pressure_gpa",
    "nominal_load_n",
    "nominal_entrainment_speed_m_s",
    "nominal_inlet_temperature_c",
)
# Of a matrix, which is planned for each oil.
CONDITION = ["oil", *SET_POINTS]


def with_levels(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Runs with a pressure for a load, and each set point moved to the level that it means."""
    planned, same = planned_conditions(settings), settings.same_set_point
    noted = _with_pressure(runs, settings.rigs)
    levels = {name: _levels(noted[name], planned[name].dropna(), same) for name in SET_POINTS}
    return noted.assign(**levels)


def with_measured(runs: pd.DataFrame, points: pd.DataFrame) -> pd.DataFrame:
    """Runs with the mean of their accepted plateaus for each set point that they do not state."""
    names = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
    means = points[points["accepted"]].groupby("run_id")[names].mean().reindex(runs["run_id"])
    measured = means.add_prefix("nominal_").set_index(runs.index)
    # a load is a set point of the pressure
    of_load = measured["nominal_max_hertz_pressure_gpa"].mask(runs["nominal_load_n"].notna())
    return runs.fillna(measured.assign(nominal_max_hertz_pressure_gpa=of_load))


def planned_conditions(settings: Settings) -> pd.DataFrame:
    """Conditions of the matrix, for each oil; none without a matrix."""
    matrix = settings.campaign.matrix
    pressure, speed, temperature = matrix.model_dump().values() if matrix else ((), (), ())
    levels = list(settings.oils), pressure, [math.nan], speed, temperature
    planned = pd.DataFrame(itertools.product(*levels), columns=CONDITION)
    return planned.astype(dict.fromkeys(SET_POINTS, float))


def _with_pressure(runs: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Runs with a nominal pressure wherever set points and rig give one, else with the load."""
    pressure = runs["nominal_max_hertz_pressure_gpa"].copy()
    for name, rig in rigs.items():
        contact = rig.contact()
        rows = (runs["rig"] == name) & pressure.isna() & (runs["nominal_load_n"] > 0)
        if contact is not None and rows.any():
            load_n = runs.loc[rows, "nominal_load_n"].to_numpy()
            pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
            pressure[rows] = pressure_pa / PA_PER_GPA
    load = runs["nominal_load_n"].where(pressure.isna())
    return runs.assign(nominal_max_hertz_pressure_gpa=pressure, nominal_load_n=load)


def _levels(
    values: "pd.Series[float]", planned: "pd.Series[float]", same: SameSetPointSettings
) -> "pd.Series[float]":
    """Each value's level: the nearest planned one, or else the first of those near each other."""
    relative = values.name != "nominal_inlet_temperature_c"
    levels, found = np.unique(planned), np.unique(values.dropna())
    for value in found:
        allowed = same.relative * value if relative else same.temperature_c
        if exceeds(np.abs(levels - value).min(initial=np.inf), allowed):
            levels = np.append(levels, value)
    nearest = {value: levels[first_smallest(np.abs(levels - value))] for value in found}
    return values.map(nearest).astype(float)


def describe_condition(condition: Mapping[Any, Any]) -> str:
    """A condition as text, as in `P = 1.25 GPa, U = 30 m/s, T = 70 degC`."""
    forms = ("P = {:g} GPa", "W = {:g} N", "U = {:g} m/s", "T = {:g} degC")
    values = zip(forms, (condition[name] for name in SET_POINTS), strict=True)
    known = [form.format(value) for form, value in values if not math.isnan(value)]
    return ", ".join(known) or "no set points"
