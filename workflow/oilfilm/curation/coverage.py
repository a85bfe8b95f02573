"""What a campaign covers: the state of each operating condition, and the counts of each gate.

Decides: which planned conditions are accepted, refused or missing.
"""

from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.plateau_gates import PLATEAU_GATES, advice_for
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.set_points import (
    CONDITION_COLUMNS,
    NOMINAL_COLUMNS,
    planned_conditions,
    with_matched_set_points,
)

_PLATEAU_GATE_NAMES = {gate.name for gate in PLATEAU_GATES}
_COUNT_COLUMNS = ["runs_accepted", "runs_refused", "points_accepted", "points_refused"]


def coverage(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Table of coverage: every condition that was tested or is in the campaign's matrix.

    The matrix is planned for each oil of the campaign, on any of its rigs. Without a matrix
    nothing is planned and nothing can be missing. Runs that state no set points share rows with
    null conditions.

    Args:
        runs: Table of runs with their verdicts.
        settings: The campaign and its rigs.
    """
    rig_names = settings.campaign.rigs
    planned = planned_conditions(settings).assign(planned=True)
    tested_conditions = _counts_by_condition(with_matched_set_points(runs, settings))
    conditions = tested_conditions.merge(planned, on=CONDITION_COLUMNS, how="outer")
    values_if_untested: dict[str, Any] = dict.fromkeys(_COUNT_COLUMNS, 0)
    values_if_untested["rig"] = rig_names[0] if len(rig_names) == 1 else ""
    values_if_untested["planned"] = False
    conditions = conditions.fillna(values_if_untested).astype({"planned": bool})
    state = np.select(
        [conditions["runs_accepted"] > 0, conditions["runs_refused"] > 0],
        ["accepted", "refused"],
        "missing",
    )
    conditions = conditions.assign(state=state).sort_values(["oil", "rig", *NOMINAL_COLUMNS])
    return tables.conform(conditions[tables.columns("coverage")], "coverage", "coverage")


def runs_of_matrix(runs: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The runs at conditions of the campaign's matrix; all of them where it has none."""
    if settings.campaign.matrix is None:
        return runs
    conditions = with_matched_set_points(runs, settings)[CONDITION_COLUMNS]
    planned = planned_conditions(settings)
    merged = conditions.merge(planned, on=CONDITION_COLUMNS, how="left", indicator="found_in")
    return runs[(merged["found_in"] == "both").to_numpy()]


def planned_states(coverage_table: pd.DataFrame) -> pd.DataFrame:
    """One row per planned condition, all rigs together: oil, set points and the best state."""
    rank_of_state = {"accepted": 0, "refused": 1, "missing": 2}
    planned_rows = coverage_table[coverage_table["planned"]]
    rank = planned_rows["state"].map(rank_of_state)
    best_first = planned_rows.loc[rank.sort_values(kind="stable").index]
    return best_first.drop_duplicates(["oil", *NOMINAL_COLUMNS]).sort_index()


def gate_counts(runs: pd.DataFrame, points: pd.DataFrame, quarantine: pd.DataFrame) -> pd.DataFrame:
    """Table of gate counts: how many files, runs, points and rows each gate or rule refused."""
    refused_points = failed_gates.one_row_per_gate(points)
    refused_points = refused_points.assign(
        stage="curate",
        refused_rows=0,
        file=refused_points["run_id"].map(runs.set_index("run_id")["file"]),
        advice=[advice_for(rule, TractionRig) for rule in refused_points["rule"]],
        points=1,
        runs_refused=0,
    )
    # curation of a traction rig refuses whole runs in the quarantine
    is_refused_run = quarantine["stage"] == "curate"
    quarantined = quarantine.assign(points=0, runs_refused=is_refused_run.astype(int))
    refusals = pd.concat([quarantined, refused_points])
    if refusals.empty:
        return tables.empty_table("gate_counts")
    is_by_plateau_gate = refusals["rule"].isin(_PLATEAU_GATE_NAMES)
    is_by_curation = refusals["stage"] == "curate"
    # a file that cannot be read has no run
    is_without_run = refusals["run_id"] == ""
    judged_unit = np.select(
        [is_by_plateau_gate, is_by_curation, is_without_run], ["point", "run", "file"], "rows"
    )
    refusals = refusals.assign(what=judged_unit, run_id=refusals["run_id"].mask(is_without_run))
    counts = refusals.groupby(["stage", "rule", "what"], as_index=False).agg(
        files=("file", "nunique"),
        runs=("run_id", "nunique"),
        runs_refused=("runs_refused", "sum"),
        points=("points", "sum"),
        rows=("refused_rows", "sum"),
        advice=("advice", "first"),
    )
    return tables.conform(counts.rename(columns={"rule": "gate"}), "gate_counts", "gate counts")


def _counts_by_condition(runs: pd.DataFrame) -> pd.DataFrame:
    """Counts of runs and points by condition and rig."""
    is_accepted = runs["verdict"] == "accepted"
    runs_with_counts = runs.assign(
        runs_accepted=is_accepted.astype(int),
        runs_refused=(~is_accepted).astype(int),
        points_accepted=runs["accepted_points"],
        points_refused=runs["plateaus"] - runs["accepted_points"],
    )
    condition_columns = ["oil", "rig", *NOMINAL_COLUMNS]
    return (
        runs_with_counts.groupby(condition_columns, dropna=False)[_COUNT_COLUMNS]
        .sum()
        .reset_index()
    )
