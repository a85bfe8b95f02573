"""What a campaign covers: each operating condition with what came of it, each gate's counts.

Decides: which planned conditions are accepted, refused or missing.
"""

import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.plateau_gates import PLATEAU_GATES, advice_for
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.settings.config import SameSetPointSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.tables import failed_gates
from oilfilm.ties import exceeds, first_smallest
from oilfilm.units import PA_PER_GPA

SET_POINTS = (
    "nominal_max_hertz_pressure_gpa",
    "nominal_load_n",
    "nominal_entrainment_speed_m_s",
    "nominal_inlet_temperature_c",
)
_CONDITION = ["oil", *SET_POINTS]
_GATES = {gate.name for gate in PLATEAU_GATES}
_COUNTS = ("runs_accepted", "runs_refused", "points_accepted", "points_refused")


def coverage(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Table of coverage: every condition that was tested or is in the campaign's matrix.

    The matrix is planned for each oil of the campaign, on whichever of its rigs. Without a matrix
    nothing is planned and nothing can be missing. Runs that state no set points share rows with
    null conditions.
    """
    rigs = settings.campaign.rigs
    planned = _planned(settings).assign(planned=True)
    tested = _counted(with_levels(runs, settings))
    conditions = tested.merge(planned, on=_CONDITION, how="outer")
    nothing: dict[str, Any] = {"rig": rigs[0] if len(rigs) == 1 else "", "planned": False}
    conditions = conditions.fillna(nothing | dict.fromkeys(_COUNTS, 0)).astype({"planned": bool})
    state = np.select(
        [conditions["runs_accepted"] > 0, conditions["runs_refused"] > 0],
        ["accepted", "refused"],
        "missing",
    )
    conditions = conditions.assign(state=state).sort_values(["oil", "rig", *SET_POINTS])
    return tables.conform(conditions[tables.columns("coverage")], "coverage", "coverage")


def of_matrix(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The runs at conditions of the campaign's matrix; all of them where it has none."""
    if settings.campaign.matrix is None:
        return runs
    at = with_levels(runs, settings)[_CONDITION].merge(
        _planned(settings), on=_CONDITION, how="left", indicator="where"
    )
    return runs[(at["where"] == "both").to_numpy()]


def with_levels(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Runs with a pressure for a load, and each set point moved to the level that it means."""
    planned, same = _planned(settings), settings.same_set_point
    noted = with_pressure(runs, settings.rigs)
    levels = {name: _levels(noted[name], planned[name].dropna(), same) for name in SET_POINTS}
    return noted.assign(**levels)


def planned_states(coverage: pd.DataFrame) -> pd.DataFrame:
    """One row per planned condition, all rigs together: oil, set points and the best state."""
    best_first = {"accepted": 0, "refused": 1, "missing": 2}
    planned = coverage[coverage["planned"]].sort_values(
        "state", key=lambda states: states.map(best_first), kind="stable"
    )
    return planned.drop_duplicates(["oil", *SET_POINTS]).sort_index()


def describe_condition(condition: Mapping[Any, Any]) -> str:
    """A condition as text, as in `P = 1.25 GPa, U = 30 m/s, T = 70 degC`."""
    forms = ("P = {:g} GPa", "W = {:g} N", "U = {:g} m/s", "T = {:g} degC")
    values = zip(forms, (condition[name] for name in SET_POINTS), strict=True)
    known = [form.format(value) for form, value in values if not math.isnan(value)]
    return ", ".join(known) or "no set points"


def gate_counts(runs: pd.DataFrame, points: pd.DataFrame, quarantine: pd.DataFrame) -> pd.DataFrame:
    """Table of gate counts: how many files, runs, points and rows each gate or rule refused."""
    of_points = failed_gates.one_row_per_gate(points).assign(stage="curate", refused_rows=0)
    of_points = of_points.assign(
        file=of_points["run_id"].map(runs.set_index("run_id")["file"]),
        advice=[advice_for(rule, TractionRig) for rule in of_points["rule"]],
        points=1,
        runs_refused=0,
    )
    by_curation = quarantine["stage"] == "curate"
    of_runs = quarantine.assign(points=0, runs_refused=by_curation.astype(int))
    refusals = pd.concat([of_runs, of_points])
    if refusals.empty:
        return tables.empty("gate_counts")
    no_run = refusals["run_id"] == ""  # of a file that cannot be read
    of_gate, curated = refusals["rule"].isin(_GATES), refusals["stage"] == "curate"
    what = np.select([of_gate, curated, no_run], ["point", "run", "file"], "rows")
    refusals = refusals.assign(what=what, run_id=refusals["run_id"].mask(no_run))
    counts = refusals.groupby(["stage", "rule", "what"], as_index=False).agg(
        files=("file", "nunique"),
        runs=("run_id", "nunique"),
        runs_refused=("runs_refused", "sum"),
        points=("points", "sum"),
        rows=("refused_rows", "sum"),
        advice=("advice", "first"),
    )
    return tables.conform(counts.rename(columns={"rule": "gate"}), "gate_counts", "gate counts")


def _planned(settings: Settings) -> pd.DataFrame:
    """Conditions of the matrix, for each oil; none without a matrix."""
    matrix = settings.campaign.matrix
    pressure, speed, temperature = matrix.model_dump().values() if matrix else ((), (), ())
    levels = list(settings.oils), pressure, [math.nan], speed, temperature
    planned = pd.DataFrame(itertools.product(*levels), columns=_CONDITION)
    return planned.astype(dict.fromkeys(SET_POINTS, float))


def with_pressure(runs: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
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


def with_measured(runs: pd.DataFrame, points: pd.DataFrame) -> pd.DataFrame:
    """Runs with the mean of their accepted plateaus for each set point that they do not state."""
    names = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
    means = points[points["accepted"]].groupby("run_id")[names].mean().reindex(runs["run_id"])
    measured = means.add_prefix("nominal_").set_index(runs.index)
    # a load is a set point of the pressure
    of_load = measured["nominal_max_hertz_pressure_gpa"].mask(runs["nominal_load_n"].notna())
    return runs.fillna(measured.assign(nominal_max_hertz_pressure_gpa=of_load))


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


def _counted(runs: pd.DataFrame) -> pd.DataFrame:
    accepted = runs["verdict"] == "accepted"
    counts = runs.assign(
        runs_accepted=accepted.astype(int),
        runs_refused=(~accepted).astype(int),
        points_accepted=runs["accepted_points"],
        points_refused=runs["plateaus"] - runs["accepted_points"],
    )
    key = ["oil", "rig", *SET_POINTS]
    return counts.groupby(key, dropna=False)[list(_COUNTS)].sum().reset_index()
