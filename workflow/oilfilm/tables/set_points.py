"""Set points of runs: their columns, the levels that they mean, and the conditions of a matrix.

Decides: which set points of runs are the same.
"""

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.ties import exceeds, first_smallest
from oilfilm.base.units import PA_PER_GPA
from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.settings.config import SameSetPointSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig

NOMINAL_COLUMNS = (
    "nominal_max_hertz_pressure_gpa",
    "nominal_load_n",
    "nominal_entrainment_speed_m_s",
    "nominal_inlet_temperature_c",
)
# Of a matrix, which is planned for each oil.
CONDITION_COLUMNS = ["oil", *NOMINAL_COLUMNS]


def with_levels(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Runs with a pressure for a load, and each set point moved to the level that it means."""
    planned, same = planned_conditions(settings), settings.same_set_point
    noted = _with_pressure(runs, settings.rigs)
    levels = {
        name: _nearest_levels(noted[name], planned[name].dropna(), same) for name in NOMINAL_COLUMNS
    }
    return noted.assign(**levels)


def with_measured(runs: pd.DataFrame, parts: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Runs with the mean of their accepted plateaus for each set point that they do not state.

    Args:
        runs: Table of runs.
        parts: The table of points in parts of whole runs.
    """
    names = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
    means_of_parts = [part[part["accepted"]].groupby("run_id")[names].mean() for part in parts]
    means = pd.concat(means_of_parts).reindex(runs["run_id"])
    measured = means.add_prefix("nominal_").set_index(runs.index)
    # a load is a set point of the pressure
    pressure_gpa = measured["nominal_max_hertz_pressure_gpa"].mask(runs["nominal_load_n"].notna())
    return runs.fillna(measured.assign(nominal_max_hertz_pressure_gpa=pressure_gpa))


def planned_conditions(settings: Settings) -> pd.DataFrame:
    """Conditions of the matrix, for each oil; none without a matrix."""
    matrix = settings.campaign.matrix
    if matrix is None:
        pressures_gpa, speeds_m_s, temperatures_c = [], [], []
    else:
        pressures_gpa = matrix.max_hertz_pressure_gpa
        speeds_m_s = matrix.entrainment_speed_m_s
        temperatures_c = matrix.inlet_temperature_c
    levels_by_column = list(settings.oils), pressures_gpa, [math.nan], speeds_m_s, temperatures_c
    planned = pd.DataFrame(itertools.product(*levels_by_column), columns=CONDITION_COLUMNS)
    return planned.astype(dict.fromkeys(NOMINAL_COLUMNS, float))


def _with_pressure(runs: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Runs with a nominal pressure wherever set points and rig give one, else with the load."""
    pressure_gpa = runs["nominal_max_hertz_pressure_gpa"].copy()
    for name, rig in rigs.items():
        contact = rig.contact()
        rows = (runs["rig"] == name) & pressure_gpa.isna() & (runs["nominal_load_n"] > 0)
        if contact is not None and rows.any():
            load_n = runs.loc[rows, "nominal_load_n"].to_numpy()
            pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
            pressure_gpa[rows] = pressure_pa / PA_PER_GPA
    load = runs["nominal_load_n"].where(pressure_gpa.isna())
    return runs.assign(nominal_max_hertz_pressure_gpa=pressure_gpa, nominal_load_n=load)


def _nearest_levels(
    values: "pd.Series[float]", planned: "pd.Series[float]", same: SameSetPointSettings
) -> "pd.Series[float]":
    """Each value's level: the nearest planned one, or else the first of those near each other."""
    is_relative = values.name != "nominal_inlet_temperature_c"
    levels, noted_values = np.unique(planned), np.unique(values.dropna())
    for value in noted_values:
        allowed = same.relative * value if is_relative else same.temperature_c
        if exceeds(np.abs(levels - value).min(initial=np.inf), allowed):
            levels = np.append(levels, value)
    nearest_level = {
        value: levels[first_smallest(np.abs(levels - value))] for value in noted_values
    }
    return values.map(nearest_level).astype(float)


def describe_condition(condition: Mapping[Any, Any]) -> str:
    """A condition as text, as in `P = 1.25 GPa, U = 30 m/s, T = 70 degC`."""
    forms = ("P = {:g} GPa", "W = {:g} N", "U = {:g} m/s", "T = {:g} degC")
    values = zip(forms, (condition[name] for name in NOMINAL_COLUMNS), strict=True)
    stated = [form.format(value) for form, value in values if not math.isnan(value)]
    return ", ".join(stated) or "no set points"
