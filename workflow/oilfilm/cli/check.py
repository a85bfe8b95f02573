"""The command `oilfilm check`: read logs, apply every gate, say what was understood.

What was found is plain values, for machines and `watch`, and text for people.

Decides: by which campaign a log is checked; how `oilfilm check` tells a torque log from a
traction log (by the folder); what it finds in a log, as text and JSON.
"""

import argparse
import os
import sys
import textwrap
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.cli.arguments import config_folder, json_line, project_folder
from oilfilm.curation.curate import Curated, curate_ingested
from oilfilm.curation.gate import RULES, Gate
from oilfilm.curation.plateau_gates import PLATEAU_GATES, advice_for
from oilfilm.curation.rig_kind import TORQUE, TRACTION, RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.base import LOADS, NOTHING_UNDERSTOOD, SET_POINTS
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.ingest import ReadLog, ingest_logs, read_bytes
from oilfilm.logs.raw_files import named_logs, raw_files
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import is_run_sheet, sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.text_table import text_table

# Columns of plateaus that show what a log was understood to be.
MEASURED = {
    TRACTION: (*SET_POINTS, "slide_roll_ratio", "traction_coefficient", "lambda_ratio"),
    TORQUE: TorqueRig.means,
}
_REFUSED = ["run_id", "rule", "reason", "advice", "first_row", "last_row", "refused_rows"]
_OF_RUN = ["run_id", "label", "oil", "rig", "verdict", "warning", "plateaus"]
# Where a label or set point comes from that the header does not give.
_CAMPAIGN, _BY_HERTZ = "campaign", "by Hertz"
WIDTH = 100
# More runs of one log, and more logs at once, are shown in less detail.
_RUNS_LISTED = 10
_LOGS_IN_DETAIL = 10
_COLUMN_HEADS = ["Column", "Unit", "Read as", "Unit", "Smallest", "Largest", "Numbers", "Missing"]
Plain = dict[str, Any]
_KINDS: tuple[type[RigKind], ...] = (TractionRig, TorqueRig)
Log = tuple[str, bytes]


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where a log is refused."""
    config = config_folder(options.config)
    raw = project_folder(options.config) / "data" / "raw"
    given: list[Path] = []
    for path in options.logs:
        given += [path / name for name in raw_files(path)] if path.is_dir() else [path]
    campaign = options.campaign or _campaign_of(given, raw, config)
    settings = resolve(config, {"campaign": campaign} if campaign else {})
    # a pattern such as data/raw/own/*.csv names the run sheet too
    paths = [path for path in dict.fromkeys(given) if not is_run_sheet(path, raw)]
    if not paths:
        raise OilfilmError(f"{_name(given[0])}: is a run sheet. Name logs.")
    for gone in _gone(settings.campaign.name, raw) if campaign else ():
        print(gone, file=sys.stderr)
    checked = check_files([(_name(path), read_bytes(path)) for path in paths], settings, raw)
    print("\n".join(map(json_line, checked)) if options.json else report(checked))
    return int(any(log["verdict"] == "refused" for log in checked))


def _gone(campaign: str, raw: Path) -> Iterator[str]:
    """Which logs of a campaign's folders an earlier run has read and are no longer there."""
    for folder in (campaign, f"{campaign}-torque"):
        seen = FirstSeen(campaign, folder, raw.parent / "first_seen")
        there = named_logs(raw / folder) if (raw / folder).is_dir() else ()
        if gone := seen.gone(f"data/raw/{folder}/{name}" for name, _ in there):
            yield gone


def _campaign_of(paths: Iterable[Path], raw: Path, config: Path) -> str | None:
    """The campaign in whose folders the logs are; None where they are elsewhere.

    Raises:
        OilfilmError: They are of several campaigns.
    """
    raw = raw.resolve()
    # not `resolve`, which fails on a link to itself
    real = [Path(os.path.realpath(path)) for path in paths]
    inside = (path.relative_to(raw) for path in real if path.is_relative_to(raw))
    named = {path.parts[0].removesuffix("-torque") for path in inside}
    known = sorted(name for name in named if (config / f"campaigns/{name}.yaml").is_file())
    if len(known) > 1:
        raise OilfilmError(
            f"{raw}: the logs are of the campaigns {' and '.join(known)}. Check one "
            "campaign at a time, or name with --campaign the one whose limits are meant."
        )
    return known[0] if known else None


def _name(path: Path) -> str:
    """A path as text, with escapes for bytes that are no text in the encoding of this system."""
    return str(path).encode("utf-8", "backslashreplace").decode("utf-8")


def check_files(logs: Sequence[Log], settings: Settings, raw: Path) -> list[Plain]:
    """What was found in logs, in their order.

    Args:
        logs: The logs by path and content.
        settings: Settings of the campaign.
        raw: The folder of the campaigns' folders, whose run sheets are used.

    Raises:
        OilfilmError: As `ingest_logs`.
    """
    found: dict[str, Plain] = {}
    for each in _KINDS:
        of_kind = [(file, log) for file, log in logs if kind_of(file, settings) is each]
        if of_kind:
            sheet = sheet_of_paths([Path(file) for file, _ in of_kind], raw, settings, each.logs)
            found |= {log["file"]: log for log in judged_logs(of_kind, settings, each, sheet)}
    return [found[file] for file, _ in logs]


def kinds_of_folders(settings: Settings) -> dict[str, type[RigKind]]:
    """The folders of a campaign below `data/raw`, with the kind of rig whose logs each has."""
    name = settings.campaign.name
    kinds: dict[str, type[RigKind]] = {name: TractionRig, f"{name}-torque": TorqueRig}
    return kinds if settings.campaign.torque is not None else {name: TractionRig}


def kind_of(file: str, settings: Settings) -> type[RigKind]:
    """The kind of rig that a log is of, by its folder: traction, but for that of torque logs."""
    kinds = kinds_of_folders(settings)
    # the nearest folder decides: that of the project may have the name of the campaign, too
    nearest = (folder.name for folder in Path(file).resolve().parents if folder.name in kinds)
    return kinds[next(nearest, settings.campaign.name)]


# ---------------------------------------------------------------- plain values


def judged_logs(
    logs: Sequence[Log], settings: Settings, kind: type[RigKind], sheet: RunSheet
) -> Iterator[Plain]:
    """What was found in logs of one kind, in their order; NaN where unknown.

    Args:
        logs: The logs by path and content.
        settings: Settings of the campaign.
        kind: The kind of rig.
        sheet: The run sheet as `sheet_of_paths` gives it.

    Raises:
        OilfilmError: As `ingest_logs`.
    """
    ingested = ingest_logs(logs, settings, kind.logs, sheet)
    curated = curate_ingested(ingested, kind(settings))
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


def _checked_run(
    run: Mapping[str, Any], log: ReadLog, curated: Curated, settings: Settings, kind: type[RigKind]
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
    # the load has one set point, as force or as pressure
    by_hertz = LOADS if not LOADS.isdisjoint(sources) else frozenset()
    found: Plain = dict.fromkeys(SET_POINTS)
    for name in SET_POINTS:
        if not pd.isna(value := run[f"nominal_{name}"]):
            source = sources.get(name, _BY_HERTZ if name in by_hertz else _CAMPAIGN)
            found[name] = {"value": value, "source": source}
    return found


def _failed_gates(points: pd.DataFrame, kind: type[RigKind]) -> Iterator[Plain]:
    failed = failed_gates.one_row_per_gate(points).groupby("rule", sort=False)["first_row"]
    for gate, rows in sorted(failed, key=lambda group: -len(group[1])):
        first, advice = int(rows.min()), advice_for(str(gate), kind)
        yield {"gate": gate, "plateaus": len(rows), "first_row": first, "advice": advice}


def _not_applied(
    run: Mapping[str, Any], points: pd.DataFrame, settings: Settings, kind: type[RigKind]
) -> Iterator[Plain]:
    """The gates that lack what they need, where the run has plateaus to be judged."""
    gates: list[Gate[Any]] = [*RUN_GATES.of(kind.name), *PLATEAU_GATES.of(kind.name)]
    for gate in gates if len(points) else []:
        if not (need := gate.needs):
            continue
        if need in points or need in run:
            lacks = bool(np.all(pd.isna(points[need] if need in points else run[need])))
        else:
            lacks = not getattr(kind(settings), need)
        if lacks:
            yield {"gate": gate.name, "reason": RULES["lacking"][need]}


# ---------------------------------------------------------------- text


def report(logs: Sequence[Plain]) -> str:
    """Everything that was found in some logs, at most `WIDTH` columns wide but for long names."""
    lines: list[str] = []
    brief = len(logs) > _LOGS_IN_DETAIL
    for log in logs:
        lines += verdict_lines(log)
        if not brief or log["verdict"] == "refused":
            lines += [*_understood(log), ""]
    if len(logs) > 1:
        lines.append(f"{len(logs)} logs: {_counted(log['verdict'] for log in logs)}")
        lines += [f"  {printable(log['file'])}" for log in logs if log["verdict"] == "refused"]
        if brief:
            lines.append("Name a log alone to see how it was understood, or add --json.")
    return "\n".join(lines).rstrip()


def verdict_lines(log: Plain) -> Iterator[str]:
    """The verdict on each run, with the reason and the advice right below it."""
    runs, file, found = log["runs"], printable(log["file"]), _found(log)
    if not runs:
        yield f"{file}: {log['verdict'].upper()}"
    if len(runs) > _RUNS_LISTED:
        verdicts = _counted(run["verdict"] for run in runs)
        yield f"{file}: {len(runs)} runs: {verdicts}; --json shows all"
        runs = [run for run in runs if found[run["run_id"]]]
    for run in sorted(runs, key=lambda run: run["verdict"] != "refused")[:_RUNS_LISTED]:
        plateaus = f"{run['accepted_plateaus']} of {run['plateaus']} plateaus"
        verdict = run["verdict"].upper()
        yield f"{printable(run['run_id'])}: {verdict}, {plateaus}, {run['rows']} rows"
        yield from found[run["run_id"]]
    yield from found[""]


def _found(log: Plain) -> dict[str, list[str]]:
    """What is wrong or doubtful, and what to do, by run; under an empty name, of the file."""
    lines: dict[str, list[str]] = {"": [], **{run["run_id"]: [] for run in log["runs"]}}

    def add(run_id: str, found: str, advice: str = "") -> None:
        of_run = lines.get(run_id, lines[""])
        of_run += _wrapped(printable(found), "  ")
        of_run += _wrapped(f"-> {printable(advice)}", "    ") if advice else []

    for each in log["refusals"]:
        add(each["run_id"], f"{each['rule']}: {each['reason']}", each["advice"])
    explained = {(each["run_id"], each["rule"]) for each in log["refusals"]}
    for run in log["runs"]:
        if run["warning"]:
            add(run["run_id"], f"WARNING: {run['warning']}")
        for gate in run["failed_gates"]:
            if (run["run_id"], gate["gate"]) not in explained:
                count = f"{gate['plateaus']} plateau{'' if gate['plateaus'] == 1 else 's'}"
                found = f"{gate['gate']}: {count}, first at row {gate['first_row']}"
                add(run["run_id"], found, gate["advice"])
    if log["run_sheet_rows"] == 0:
        advice = "Only its header counts. Correct the name in the sheet."
        add("", "the run sheet has no row for this log", advice)
    return lines


def _counted(names: Iterable[str]) -> str:
    """Each of some names with how often it comes, in their order."""
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(names).items()))


def _wrapped(text: str, indent: str) -> list[str]:
    wrapper = textwrap.TextWrapper(WIDTH, indent, f"{indent}  ")
    wrapper.break_long_words = wrapper.break_on_hyphens = False
    return wrapper.wrap(text)


def _understood(log: Plain) -> Iterator[str]:
    """How a log was understood: format, columns, conditions, gates that could not be applied."""
    form = [log["format"]]
    if log["encoding"]:
        form += [log["encoding"], f"delimiter {log['delimiter']}", f"decimal {log['decimal_mark']}"]
    refused = f" ({log['refused_rows']} refused)" if log["refused_rows"] else ""
    read_as = f"Read as {log['rig_kind']} log of campaign {log['campaign']}: {', '.join(form)}"
    yield from _wrapped(f"{read_as}, {log['rows']} rows{refused}", "  ")
    runs = log["runs"]
    if not runs:
        return
    rig = "rig" if log["rig_kind"] == "traction" else "bearing"
    oils = sorted({f"{run['oil']} ({run['oil_source']})" for run in runs})
    rigs = sorted({f"{run['rig']} ({run['rig_source']})" for run in runs})
    yield f"  Oil {', '.join(oils)}; {rig} {', '.join(rigs)}"
    yield from ("", *_columns(runs), *_conditions(log), *_gates_not_applied(runs))


def _columns(runs: Sequence[Plain]) -> Iterator[str]:
    """Each column of a log with its range over all runs."""
    every = pd.DataFrame([column for run in runs for column in run["columns"]])
    if len(every):
        by = ["name", "logged_unit", "quantity", "unit"]
        found = every.groupby(by, sort=False, as_index=False).agg(
            {"minimum": "min", "maximum": "max", "count": "sum", "missing": "sum"}
        )
        for end in ("minimum", "maximum"):
            found[end] = ["-" if pd.isna(value) else f"{value:.5g}" for value in found[end]]
        rows = found.astype(str).to_numpy().tolist()
        yield from text_table([_COLUMN_HEADS, *rows], right=4, indent="  ")
    unused = dict.fromkeys(name for run in runs for name in run["unused_columns"])
    if unused:
        yield from _wrapped(f"Not read: {', '.join(map(printable, unused))}", "  ")


def _conditions(log: Plain) -> Iterator[str]:
    """Operating conditions and traction over all runs of a log."""
    runs, rows = log["runs"], []
    for name in runs[0]["measured"]:
        ends = [end for run in runs for end in run["measured"][name].values()]
        points = [point for run in runs if (point := run["set_points"].get(name))]
        sources = ", ".join(sorted({point["source"] for point in points}))
        set_point = f"{_span([point['value'] for point in points])} ({sources})" if points else "-"
        rows.append([name, _span(ends), set_point])
    title = "Plateaus" if len(runs) == 1 else f"Plateaus of {len(runs)} runs"
    yield from ("", *text_table([[title, "Measured", "Set point"], *rows], right=2, indent="  "))


def _span(values: Sequence[float]) -> str:
    """The range of some numbers; small ones with a fixed count of decimals."""
    known = sorted(value for value in values if not isnan(value))
    if not known:
        return "-"
    # no minus before a zero
    form = "z.4f" if max(map(abs, known)) < 10 else ".4g"
    lowest, highest = (f"{known[end]:{form}}" for end in (0, -1))
    return lowest if lowest == highest else f"{lowest}..{highest}"


def _gates_not_applied(runs: Sequence[Plain]) -> Iterator[str]:
    """The gates that could not be applied to all runs or to some, by what they lack."""
    lacking = pd.DataFrame([each for run in runs for each in run["gates_not_applied"]])
    if len(lacking):
        yield from ("", "  Gates that could not be applied")
        for reason, gates in lacking.drop_duplicates().groupby("reason", sort=False)["gate"]:
            yield from _wrapped(f"{', '.join(gates)}: {reason}", "    ")
