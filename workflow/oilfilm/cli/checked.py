"""What `oilfilm check` found in a log: plain values for people, for machines and for `watch`.

Decides: what `oilfilm check` finds in a log, as text and JSON.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any, NamedTuple

import pandas as pd

from oilfilm import tables
from oilfilm.curation.curate import Curated
from oilfilm.curation.gate import RULES, TORQUE, TRACTION, Gate
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.verdicts import advice_for
from oilfilm.logs.base import LOADS, NOTHING_UNDERSTOOD, SET_POINTS
from oilfilm.logs.ingest import Ingested, ReadLog
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates

# Columns of plateaus that show what a log was understood to be.
MEASURED = {
    TRACTION: (*SET_POINTS, "slide_roll_ratio", "traction_coefficient", "lambda_ratio"),
    TORQUE: TORQUE_RIG.means,
}
_REFUSED = ["run_id", "rule", "reason", "advice", "first_row", "last_row", "refused_rows"]
_OF_RUN = ["run_id", "label", "oil", "rig", "verdict", "warning", "plateaus"]
# Where a label or set point comes from that the header does not give.
_CAMPAIGN, _BY_HERTZ = "campaign", "by Hertz"
Plain = dict[str, Any]


class Problem(NamedTuple):
    """What is wrong or doubtful about a log or a run of it, and what to do.

    Attributes:
        run_id: The run; empty where it is the file.
        rule: Name of the rule or gate.
        found: What was found, in a sentence that begins with the rule.
        advice: What to do; empty where there is nothing to do.
    """

    run_id: str
    rule: str
    found: str
    advice: str = ""


def checked_logs(
    ingested: Ingested, curated: Curated, settings: Settings, kind: RigKind, sheet: RunSheet
) -> Iterator[Plain]:
    """What was found in each log, in the order in which they were read; NaN where unknown.

    Args:
        ingested: The logs as read.
        curated: What curation made of them.
        settings: Settings of the campaign.
        kind: The kind of rig.
        sheet: The run sheet as `sheet_of_paths` gives it.
    """
    for log in ingested.logs:
        runs = tables.rows(curated.runs[curated.runs["file"] == log.file])
        refused = curated.quarantine[curated.quarantine["file"] == log.file]
        accepted = runs and all(run["verdict"] != "refused" for run in runs)
        yield {
            "file": log.file,
            "campaign": settings.campaign.name,
            "verdict": "accepted" if accepted else "refused",
            "rig_kind": kind.name,
            "format": log.format,
            **asdict(log.form),
            "rows": log.rows,
            "refused_rows": int(refused["refused_rows"].sum()),
            "run_sheet_rows": len(sheet.rows[log.file]) if log.file in sheet.rows else None,
            "refusals": tables.rows(refused[_REFUSED]),
            "runs": [_checked_run(run, log, curated, settings, kind) for run in runs],
        }


def problems(log: Plain) -> Iterator[Problem]:
    """All that was found in a log, the reasons of refusals first."""
    for each in log["refusals"]:
        found = f"{each['rule']}: {each['reason']}"
        yield Problem(each["run_id"], each["rule"], found, each["advice"])
    explained = {(each["run_id"], each["rule"]) for each in log["refusals"]}
    for run in log["runs"]:
        if run["warning"]:
            yield Problem(run["run_id"], "warning", f"WARNING: {run['warning']}")
        for gate in run["failed_gates"]:
            if (run["run_id"], gate["gate"]) not in explained:
                count = f"{gate['plateaus']} plateau{'' if gate['plateaus'] == 1 else 's'}"
                found = f"{gate['gate']}: {count}, first at row {gate['first_row']}"
                yield Problem(run["run_id"], gate["gate"], found, gate["advice"])
    if log["run_sheet_rows"] == 0:
        advice = "Only its header counts. Correct the name in the sheet."
        yield Problem("", "run sheet", "the run sheet has no row for this log", advice)


def _checked_run(
    run: Mapping[str, Any], log: ReadLog, curated: Curated, settings: Settings, kind: RigKind
) -> Plain:
    points = curated.points[curated.points["run_id"] == run["run_id"]]
    understood = log.runs.get(run["run_id"], NOTHING_UNDERSTOOD)
    sources, traction = understood.sources, kind.name == TRACTION
    ends = points[list(MEASURED[kind.name])].agg(["min", "max"]).set_axis(["minimum", "maximum"])
    return {
        **{name: run[name] for name in _OF_RUN},
        "oil_source": sources.get("oil", _CAMPAIGN),
        "rig_source": sources.get("rig" if traction else "bearing", _CAMPAIGN),
        "rows": run["samples"],
        "accepted_plateaus": run["accepted_points"],
        "columns": [asdict(column) for column in understood.columns],
        "unused_columns": [name for name in understood.unused if name],
        "set_points": _set_points(run, sources) if traction else {},
        "measured": ends.to_dict(),
        "failed_gates": list(_failed_gates(points, kind)),
        "gates_not_applied": list(_not_applied(run, points, settings, kind)),
    }


def _set_points(run: Mapping[str, Any], sources: Mapping[str, str]) -> Plain:
    named = {name: sources.get(name, _CAMPAIGN) for name in SET_POINTS}
    if not LOADS.isdisjoint(sources):
        # the load has one set point, as force or as pressure
        named |= {name: _BY_HERTZ for name in LOADS - sources.keys()}
    values = {name: run[f"nominal_{name}"] for name in SET_POINTS}
    return {
        name: None if pd.isna(value) else {"value": value, "source": named[name]}
        for name, value in values.items()
    }


def _failed_gates(points: pd.DataFrame, kind: RigKind) -> Iterator[Plain]:
    failed = failed_gates.one_row_per_gate(points).groupby("rule", sort=False)["first_row"]
    for gate, rows in sorted(failed, key=lambda group: -len(group[1])):
        advice = advice_for(str(gate), kind)
        first = int(rows.min())
        yield {"gate": gate, "plateaus": len(rows), "first_row": first, "advice": advice}


def _not_applied(
    run: Mapping[str, Any], points: pd.DataFrame, settings: Settings, kind: RigKind
) -> Iterator[Plain]:
    """The gates that lack what they need, where the run has plateaus to be judged."""
    gates: list[Gate[Any]] = [*RUN_GATES.of(kind.name), *PLATEAU_GATES.of(kind.name)]
    for gate in gates if len(points) else []:
        need = gate.needs
        if not need:
            continue
        if need in points:
            lacks = bool(points[need].isna().all())
        elif need in run:
            lacks = bool(pd.isna(run[need]))
        else:
            lacks = not getattr(kind.limits(settings), need)
        if lacks:
            yield {"gate": gate.name, "reason": RULES["lacking"][need]}
