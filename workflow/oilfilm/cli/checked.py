"""What `oilfilm check` found in a log: one object per log, for people and for machines.

Decides: what `oilfilm check` finds in a log, as text and JSON.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from math import isnan
from typing import Any, Literal, NamedTuple

import pandas as pd

from oilfilm import tables
from oilfilm.curation.curate import Curated
from oilfilm.curation.gate import TORQUE, TRACTION, Gate, Limits
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.curation.verdicts import advice_for
from oilfilm.logs.base import LOADS, NOTHING_UNDERSTOOD, SET_POINTS
from oilfilm.logs.ingest import Ingested, ReadLog
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.settings.base import Group, Result, key
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates

# Columns of plateaus that show what a log was understood to be.
MEASURED = {
    TRACTION: (
        "max_hertz_pressure_gpa",
        "load_n",
        "entrainment_speed_m_s",
        "inlet_temperature_c",
        "slide_roll_ratio",
        "traction_coefficient",
        "lambda_ratio",
    ),
    TORQUE: (
        "axial_load_n",
        "inner_speed_rpm",
        "oil_temperature_c",
        "outer_ring_temperature_c",
        "torque_n_m",
    ),
}
# Where a label or set point comes from that the header does not give.
_CAMPAIGN, _BY_HERTZ = "campaign", "by Hertz"

Verdict = Literal["accepted", "refused"]


class Range(Group):
    """Smallest and largest value; null where there is none."""

    minimum: Result = key("Smallest value.")
    maximum: Result = key("Largest value.")


class CheckedColumn(Range):
    """A column that is read."""

    name: str = key("Name in the log.")
    logged_unit: str = key("Unit in the log.")
    quantity: str = key("What it is taken for.")
    unit: str = key("Unit of `minimum` and `maximum`.")
    count: int = key("Rows with a number.")
    missing: int = key("Rows without a number.")


class SetPoint(Group):
    """A set point of a run."""

    value: float = key("Its value; the unit is in its name.")
    source: str = key(
        "Where it comes from: header, campaign (its file), by Hertz (from the pressure)."
    )


class FailedGate(Group):
    """A gate that refused plateaus of a run."""

    gate: str = key("Name of the gate.")
    plateaus: int = key("How many plateaus failed it.")
    first_row: int = key("First row of the first of them.")
    advice: str = key("What to do.")


class NotApplied(Group):
    """A gate that could not be applied to a run."""

    gate: str = key("Name of the gate.")
    reason: str = key("What it lacks.")


class Refused(Group):
    """A refusal of a file, a run or a range of rows."""

    run_id: str = key("Run; empty where it is the file.")
    rule: str = key("Name of the rule or gate.")
    reason: str = key("What was found and what was expected.")
    advice: str = key("What to do.")
    first_row: int = key("First row concerned; 0 where no row is meant.")
    last_row: int = key("Last row concerned.")
    refused_rows: int = key("Rows kept out of the samples because of it.")


class CheckedRun(Group):
    """One run of a log."""

    run_id: str = key("Name of the run.")
    label: str = key("Name that the log gives the run; empty where none.")
    oil: str = key("Its oil.")
    oil_source: str = key("Where the oil comes from: header, run sheet or campaign.")
    rig: str = key("Its rig, or its bearing where it is a torque log.")
    rig_source: str = key("Where the rig comes from: header, run sheet or campaign.")
    verdict: Verdict = key("accepted: at least one plateau passed.")
    warning: str = key("What is doubtful about a run that is used; empty where nothing is.")
    rows: int = key("Rows that are used.")
    plateaus: int = key("Plateaus found.")
    accepted_plateaus: int = key("Plateaus that passed every gate.")
    columns: list[CheckedColumn] = key("Columns that are read.")
    unused_columns: list[str] = key("Names of the other columns.")
    set_points: dict[str, SetPoint | None] = key(
        "By name with unit; null where none is given. None in torque logs."
    )
    measured: dict[str, Range] = key("Over all plateaus, by name with unit.")
    failed_gates: list[FailedGate] = key("Gates that refused plateaus, the most frequent first.")
    gates_not_applied: list[NotApplied] = key("Gates that could not be applied.")


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


class CheckedLog(Group):
    """What `oilfilm check` found in one log."""

    file: str = key("The file, as it was named.")
    campaign: str = key("Campaign whose rigs, oils and limits were applied.")
    verdict: Verdict = key("refused: the file or a run of it was refused.")
    rig_kind: str = key("traction or torque.")
    format: str = key("Format that was recognised; none where the format is not known.")
    encoding: str = key("Encoding of a text log; else empty.")
    delimiter: str = key("Delimiter of a text log in a word; else empty.")
    decimal_mark: str = key("Decimal mark of a text log: point or comma; else empty.")
    rows: int = key("Rows of data, good and bad.")
    refused_rows: int = key("Rows kept out of the samples.")
    run_sheet_rows: int | None = key(
        "Rows of the run sheet about the log; null where its folder has no run sheet."
    )
    run_sheet_near: str = key(
        "Row of the run sheet that matches no log and resembles the name of a log without a row; "
        "empty where there is none."
    )
    refusals: list[Refused] = key("What was refused.")
    runs: list[CheckedRun] = key("Runs of the log.")

    @property
    def problems(self) -> Iterator[Problem]:
        """All that was found, the reasons of refusals first."""
        for refused in self.refusals:
            found = f"{refused.rule}: {refused.reason}"
            yield Problem(refused.run_id, refused.rule, found, refused.advice)
        explained = {(refused.run_id, refused.rule) for refused in self.refusals}
        for run in self.runs:
            if run.warning:
                yield Problem(run.run_id, "warning", f"WARNING: {run.warning}")
            for failed in run.failed_gates:
                if (run.run_id, failed.gate) not in explained:
                    count = f"{failed.plateaus} plateau{'' if failed.plateaus == 1 else 's'}"
                    found = f"{failed.gate}: {count}, first at row {failed.first_row}"
                    yield Problem(run.run_id, failed.gate, found, failed.advice)
        if self.run_sheet_rows == 0:
            near = self.run_sheet_near and f"; did you mean this log in {self.run_sheet_near}?"
            yield Problem(
                "",
                "run sheet",
                f"the run sheet has no row for this log{near}",
                "Only its header counts. Correct the name in the sheet.",
            )


def checked_logs(
    ingested: Ingested, curated: Curated, settings: Settings, kind: RigKind, sheet: RunSheet
) -> Iterator[CheckedLog]:
    """What was found in each log, in the order in which they were read.

    Args:
        ingested: The logs as read.
        curated: What curation made of them.
        settings: Settings of the campaign.
        kind: The kind of rig.
        sheet: The run sheet as `sheet_of_paths` gives it.
    """
    for log in ingested.logs:
        runs = curated.runs[curated.runs["file"] == log.file]
        refused = curated.quarantine[curated.quarantine["file"] == log.file]
        refused_run = bool((runs["verdict"] == "refused").any())
        yield CheckedLog(
            file=log.file,
            campaign=settings.campaign.name,
            verdict="refused" if refused_run or runs.empty else "accepted",
            rig_kind=kind.name,
            format=log.format,
            **asdict(log.form),
            rows=log.rows,
            refused_rows=int(refused["refused_rows"].sum()),
            run_sheet_rows=len(sheet.rows[log.file]) if log.file in sheet.rows else None,
            run_sheet_near=sheet.near.get(log.file, ""),
            refusals=[_refused(row) for row in tables.rows(refused)],
            runs=[_checked_run(row, log, curated, settings, kind) for row in tables.rows(runs)],
        )


def _refused(row: Mapping[str, Any]) -> Refused:
    return Refused(**{name: row[name] for name in Refused.model_fields})


def _checked_run(
    run: Mapping[str, Any], log: ReadLog, curated: Curated, settings: Settings, kind: RigKind
) -> CheckedRun:
    points = curated.points[curated.points["run_id"] == run["run_id"]]
    understood = log.runs.get(run["run_id"], NOTHING_UNDERSTOOD)
    return CheckedRun(
        **{name: run[name] for name in ("run_id", "label", "oil", "rig", "plateaus")},
        verdict=run["verdict"],
        warning=run["warning"],
        oil_source=understood.sources.get("oil", _CAMPAIGN),
        rig_source=understood.sources.get("rig" if kind.name == TRACTION else "bearing", _CAMPAIGN),
        rows=run["samples"],
        accepted_plateaus=run["accepted_points"],
        columns=[CheckedColumn(**asdict(column)) for column in understood.columns],
        unused_columns=[name for name in understood.unused if name],
        set_points=_set_points(run, understood.sources) if kind.name == TRACTION else {},
        measured={
            name: Range(minimum=points[name].min(), maximum=points[name].max())
            for name in MEASURED[kind.name]
        },
        failed_gates=list(_failed_gates(points, kind)),
        gates_not_applied=list(_not_applied(run, points, kind, kind.limits(settings))),
    )


def _set_points(run: Mapping[str, Any], sources: Mapping[str, str]) -> dict[str, SetPoint | None]:
    values = {name: run[f"nominal_{name}"] for name in SET_POINTS}
    named = {name: sources.get(name, _CAMPAIGN) for name in SET_POINTS}
    if not LOADS.isdisjoint(sources):
        # the load has one set point, as force or as pressure
        named |= {name: _BY_HERTZ for name in LOADS - sources.keys()}
    return {
        name: None if isnan(value) else SetPoint(value=value, source=named[name])
        for name, value in values.items()
    }


def _failed_gates(points: pd.DataFrame, kind: RigKind) -> Iterator[FailedGate]:
    by_gate = failed_gates.one_row_per_gate(points)
    for gate, count in failed_gates.counts(points).items():
        first = by_gate.loc[by_gate["rule"] == gate, "first_row"].min()
        yield FailedGate(
            gate=str(gate),
            plateaus=int(count),
            first_row=int(first),
            advice=advice_for(str(gate), kind),
        )


def _not_applied(
    run: Mapping[str, Any], points: pd.DataFrame, kind: RigKind, limits: Limits
) -> Iterator[NotApplied]:
    """The gates that lack what they need, where the run has plateaus to be judged."""
    gates: list[Gate[Any]] = [*RUN_GATES.of(kind.name), *PLATEAU_GATES.of(kind.name)]
    for gate in gates if len(points) else []:
        if (need := gate.needs) is None:
            continue
        if need.name in points:
            lacks = bool(points[need.name].isna().all())
        elif need.name in run:
            lacks = isnan(run[need.name])
        else:
            lacks = not getattr(limits, need.name)
        if lacks:
            yield NotApplied(gate=gate.name, reason=need.lacking)
