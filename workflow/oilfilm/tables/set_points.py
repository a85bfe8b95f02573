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
# Columns of the conditions of a test matrix, which is planned for each oil.
CONDITION_COLUMNS = ["oil", *NOMINAL_COLUMNS]


def with_matched_set_points(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Runs with the pressure of a stated load, and each set point moved to the level it means."""
    planned = planned_conditions(settings)
    same_set_point = settings.same_set_point
    runs_with_pressure = _with_pressure(runs, settings.rigs)
    levels_by_column = {
        name: _nearest_levels(runs_with_pressure[name], planned[name].dropna(), same_set_point)
        for name in NOMINAL_COLUMNS
    }
    return runs_with_pressure.assign(**levels_by_column)


def with_measured_set_points(
    runs: pd.DataFrame, blocks_of_points: Iterable[pd.DataFrame]
) -> pd.DataFrame:
    """Runs with the mean of their accepted plateaus for each set point that they do not state.

    Args:
        runs: Table of runs.
        blocks_of_points: The table of points in blocks; the points of a run are in one of them.
    """
    measured_columns = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
    means_of_blocks = [
        block[block["accepted"]].groupby("run_id")[measured_columns].mean()
        for block in blocks_of_points
    ]
    means = pd.concat(means_of_blocks).reindex(runs["run_id"])
    measured = means.add_prefix("nominal_").set_index(runs.index)
    # a stated load sets the pressure
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
    levels_of_columns = list(settings.oils), pressures_gpa, [math.nan], speeds_m_s, temperatures_c
    planned = pd.DataFrame(itertools.product(*levels_of_columns), columns=CONDITION_COLUMNS)
    return planned.astype(dict.fromkeys(NOMINAL_COLUMNS, float))


def _with_pressure(runs: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Runs with a nominal pressure wherever set points and rig give one, else with the load."""
    pressure_gpa = runs["nominal_max_hertz_pressure_gpa"].copy()
    for rig_name, rig in rigs.items():
        contact = rig.contact()
        needs_pressure = (
            (runs["rig"] == rig_name) & pressure_gpa.isna() & (runs["nominal_load_n"] > 0)
        )
        if contact is not None and needs_pressure.any():
            load_n = runs.loc[needs_pressure, "nominal_load_n"].to_numpy()
            pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
            pressure_gpa[needs_pressure] = pressure_pa / PA_PER_GPA
    load = runs["nominal_load_n"].where(pressure_gpa.isna())
    return runs.assign(nominal_max_hertz_pressure_gpa=pressure_gpa, nominal_load_n=load)


def _nearest_levels(
    set_points: "pd.Series[float]",
    planned_levels: "pd.Series[float]",
    same_set_point: SameSetPointSettings,
) -> "pd.Series[float]":
    """The level of each set point.

    Levels are the planned ones. A set point that is far from every level becomes a level itself,
    the smallest set points first.
    """
    is_relative = set_points.name != "nominal_inlet_temperature_c"
    levels = np.unique(planned_levels)
    distinct_set_points = np.unique(set_points.dropna())
    for set_point in distinct_set_points:
        reach = same_set_point.relative * set_point if is_relative else same_set_point.temperature_c
        if exceeds(np.abs(levels - set_point).min(initial=np.inf), reach):
            levels = np.append(levels, set_point)
    level_by_set_point = {
        set_point: levels[first_smallest(np.abs(levels - set_point))]
        for set_point in distinct_set_points
    }
    return set_points.map(level_by_set_point).astype(float)


def describe_condition(condition: Mapping[Any, Any]) -> str:
    """A condition as text, as in `P = 1.25 GPa, U = 30 m/s, T = 70 degC`."""
    forms = ("P = {:g} GPa", "W = {:g} N", "U = {:g} m/s", "T = {:g} degC")
    forms_and_levels = zip(forms, (condition[name] for name in NOMINAL_COLUMNS), strict=True)
    texts = [form.format(level) for form, level in forms_and_levels if not math.isnan(level)]
    return ", ".join(texts) or "no set points"
