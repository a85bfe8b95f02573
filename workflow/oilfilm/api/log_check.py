"""Verdicts on raw logs: read them, apply every gate, report how each log was understood.

The function is `oilfilm.check`, the command `oilfilm check`. The result is plain values, for JSON
and `watch`, and text for people.

Decides: which campaign a log is checked by; how `oilfilm check` distinguishes a torque log from a
traction log (by the folder); what it reports on a log, as text and JSON.
"""

import os
import textwrap
from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import chain
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.api.folders import config_folder, project_folder
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.base.text_table import text_table
from oilfilm.curation.curate import Curated, curate_ingested
from oilfilm.curation.gate import RULES, Gate
from oilfilm.curation.plateau_gates import PLATEAU_GATES, advice_for
from oilfilm.curation.rig_kind import TORQUE_KIND, TRACTION_KIND, RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.curation.torque_rig import TorqueRig, radial_load_warnings
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import LOAD_KEYS, NOTHING_UNDERSTOOD, READING_NOTE, SET_POINT_KEYS
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.ingest import ReadLog, ingest_logs, read_bytes
from oilfilm.logs.raw_files import named_logs, raw_files
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import is_run_sheet, sheet_of_paths
from oilfilm.settings.resolve import campaign_names, resolve
from oilfilm.settings.resolved import Settings
from oilfilm.surface.shape import FEWEST_CURVES
from oilfilm.tables import failed_gates

# Columns of plateaus that a check reports, by kind of rig.
MEASURED = {
    TRACTION_KIND: (*SET_POINT_KEYS, "slide_roll_ratio", "traction_coefficient", "lambda_ratio"),
    TORQUE_KIND: TorqueRig.mean_columns,
}
_REFUSAL_COLUMNS = ["run_id", "rule", "reason", "advice", "first_row", "last_row", "refused_rows"]
_RUN_COLUMNS = ["run_id", "label", "oil", "rig", "verdict", "warning", "plateaus"]
# Columns of a data frame of runs.
_FRAME_COLUMNS = [
    *("file", "run_id", "oil", "rig", "verdict", "plateaus", "accepted_plateaus", "rows"),
    "warning",
]
# Source of a label or set point that the header does not give.
_CAMPAIGN, _BY_HERTZ = "campaign", "by Hertz"
# Columns of the text.
WIDTH = 100
# More runs of one log, and more logs at once, are shown in less detail.
_MOST_RUNS_LISTED = 10
_MOST_LOGS_IN_DETAIL = 10
_COLUMN_HEADS = ["Column", "Unit", "Read as", "Unit", "Smallest", "Largest", "Numbers", "Missing"]
# Stands for the file where problems are listed by run.
_FILE = ""
_KINDS: tuple[type[RigKind], ...] = (TractionRig, TorqueRig)
# Rule -> the rules whose faults may only follow from it.
CONSEQUENCES: Mapping[str, frozenset[str]] = {
    cause: frozenset(rules.split()) for cause, rules in RULES["causes"].items()
}
# A log: its path and its content.
Log = tuple[str, bytes]
# What was found in a log, a run or a part of it, as JSON has it.
JsonObject = dict[str, Any]


@dataclass(frozen=True)
class CheckedLogs:
    """The verdicts on some logs.

    Attributes:
        logs: What was found in each log, as plain values: what `oilfilm check --json` prints.
        campaign: The campaign by whose columns, rig and limits they were judged.
        notes: What its user must know beside the verdicts, in sentences.
        points: Accepted steady points of traction logs, one row per point, as the table `points`
            of a campaign: conditions, `slide_roll_ratio` and `traction_coefficient`, both with
            their signs.
    """

    logs: list[JsonObject]
    campaign: str
    notes: tuple[str, ...] = ()
    points: pd.DataFrame = field(default_factory=pd.DataFrame, compare=False)

    @property
    def accepted(self) -> bool:
        """Whether no log is refused."""
        return all(log["verdict"] == "accepted" for log in self.logs)

    def to_frame(self) -> pd.DataFrame:
        """One row per run: file, run, oil, rig, verdict and accepted plateaus.

        A log in which no run was found has one row without a run.
        """
        rows = []
        for log in self.logs:
            runs = log["runs"] or [{"verdict": log["verdict"]}]
            rows += [{"file": log["file"]} | run for run in runs]
        return pd.DataFrame(rows).reindex(columns=_FRAME_COLUMNS)

    def summary(self) -> str:
        """Verdicts with reasons and advice, and how each log was understood, as text."""
        return report(self.logs)

    def __repr__(self) -> str:
        return self.summary()


def check(
    *logs: Path | str, campaign: str | None = None, config: Path | str | None = None
) -> CheckedLogs:
    """Read raw logs and apply every gate, without running the workflow.

    Args:
        logs: Files, or folders with logs.
        campaign: The campaign by which they are judged: names of columns, rig, limits. If not
            given, that in whose folder the logs are, else that of `config.yaml`.
        config: Configuration folder. If not given, that of the project in whose `data/raw` the
            logs are, else `config` of the current folder, else that of oilfilm.

    Raises:
        OilfilmError: A file cannot be read, there is no such campaign, or the logs are of several
            campaigns or projects. A log that is refused raises nothing: see `accepted`.

    Examples:
        ```
        checked = oilfilm.check("data/raw/june")
        print(checked)               # verdicts, reasons, what to do
        checked.to_frame()           # one row per run
        checked.points               # what a law can be fitted to
        ```
    """
    if not logs:
        raise OilfilmError("check: found no path; expected one or more logs or folders.")
    files: list[Path] = []
    for path in map(Path, logs):
        if path.is_dir():
            files += [path / name for name in raw_files(path)]
        else:
            files.append(path)
    folder, project = _config_and_project(None if config is None else Path(config), files)
    raw = project / "data" / "raw"
    campaign_of_logs = campaign or _campaign_of(files, raw, folder)
    settings = resolve(folder, {"campaign": campaign_of_logs} if campaign_of_logs else {})
    # a pattern such as data/raw/own/*.csv names the run sheet too
    paths = [path for path in dict.fromkeys(files) if not is_run_sheet(path, raw)]
    if not paths:
        raise OilfilmError(f"{_decodable_path(files[0])}: is a run sheet. Name logs.")
    campaign_name = settings.campaign.name
    # read one after the other: a log is not needed beside its samples
    contents = {_decodable_path(path): partial(read_bytes, path) for path in paths}
    reports, points = _judged_files(contents, settings, raw)
    if campaign_of_logs:
        notes = tuple(_removed_logs(campaign_name, raw))
    else:
        notes = (_advice_for_logs_of_no_campaign(campaign_name),)
    return CheckedLogs(reports, campaign_name, notes, points)


def _config_and_project(config_option: Path | None, logs: Sequence[Path]) -> tuple[Path, Path]:
    """The configuration folder and the folder of the project by which logs are judged.

    It is that of the option, else that of the project in whose `data/raw` the logs are, else that
    of the current folder, else oilfilm's own.

    Raises:
        OilfilmError: The logs are of several projects.
    """
    if config_option:
        return config_option, project_folder(config_option)
    projects = sorted({project for project in map(_project_of, logs) if project is not None})
    if len(projects) > 1:
        names = " and ".join(map(str, projects))
        raise OilfilmError(
            f"{logs[0]}: the logs are of the projects {names}. Check one "
            "project at a time, or name with --config the configuration folder that is meant."
        )
    if projects and projects[0] != Path.cwd():
        return projects[0] / "config", projects[0]
    return config_folder(None), project_folder(None)


def _project_of(log: Path) -> Path | None:
    """The folder of the project in whose `data/raw` a log is; None where it is in none."""
    # not `resolve`, which fails on a link to itself
    for folder in Path(os.path.realpath(log)).parents:
        is_raw = folder.name == "raw" and folder.parent.name == "data"
        if is_raw and (folder.parents[1] / "config" / "config.yaml").is_file():
            return folder.parents[1]
    return None


def _advice_for_logs_of_no_campaign(campaign: str) -> str:
    """What to do about logs that are in no campaign's folder."""
    return (
        f"The logs are in the folder of no campaign: the names of columns, the rig and the limits "
        f"are those of the campaign {campaign!r}, which may be another laboratory's. "
        "`oilfilm init FOLDER LOG...` makes a project for logs of your own. --campaign names a "
        "campaign that you have."
    )


def _removed_logs(campaign: str, raw: Path) -> Iterator[str]:
    """Sentences on the logs of a campaign that an earlier run has read and that are missing now."""
    for folder in (campaign, f"{campaign}-torque"):
        first_seen = FirstSeen(campaign, folder, folder=raw.parent / "first_seen")
        logs = named_logs(raw / folder) if (raw / folder).is_dir() else ()
        sentence = first_seen.sentence_on_missing(f"data/raw/{folder}/{name}" for name, _ in logs)
        if sentence:
            yield sentence


def _campaign_of(paths: Iterable[Path], raw: Path, config: Path) -> str | None:
    """The campaign in whose folders the logs are; None where they are elsewhere.

    Raises:
        OilfilmError: They are of several campaigns.
    """
    raw = raw.resolve()
    known_campaigns = campaign_names(config)
    campaigns = set()
    for path in paths:
        # not `resolve`, which fails on a link to itself
        real_path = Path(os.path.realpath(path))
        if real_path.is_relative_to(raw):
            name = real_path.relative_to(raw).parts[0].removesuffix("-torque")
            if name in known_campaigns:
                campaigns.add(name)
    if len(campaigns) > 1:
        raise OilfilmError(
            f"{raw}: the logs are of the campaigns {' and '.join(sorted(campaigns))}. Check one "
            "campaign at a time, or name with --campaign the one whose limits are meant."
        )
    return campaigns.pop() if campaigns else None


def _decodable_path(path: Path) -> str:
    """A path as text, with escapes for bytes that the encoding of the system cannot decode."""
    return str(path).encode("utf-8", "backslashreplace").decode("utf-8")


def check_files(
    logs: Mapping[str, Callable[[], bytes]], settings: Settings, raw: Path
) -> list[JsonObject]:
    """The reports on logs as plain values, in the order of the logs.

    Args:
        logs: What gives the content of each log, by its path.
        settings: Settings of the campaign.
        raw: The folder `data/raw` with the campaigns' folders, whose run sheets are used.

    Raises:
        OilfilmError: As in `ingest_logs`.
    """
    reports, _ = _judged_files(logs, settings, raw)
    return reports


def _judged_files(
    logs: Mapping[str, Callable[[], bytes]], settings: Settings, raw: Path
) -> tuple[list[JsonObject], pd.DataFrame]:
    """The reports of `check_files`, and the accepted points of traction logs."""
    reports: dict[str, JsonObject] = {}
    points = pd.DataFrame()
    for kind in _KINDS:
        files = [file for file in logs if kind_of(file, settings) is kind]
        if files:
            sheet = sheet_of_paths([Path(file) for file in files], raw, settings, kind.kind_of_logs)
            contents = ((file, logs[file]()) for file in files)
            reports_of_kind, curated = _judged(contents, settings, kind, sheet)
            reports.update((log_report["file"], log_report) for log_report in reports_of_kind)
            if kind is TractionRig:
                points = curated.points[curated.points["accepted"]].reset_index(drop=True)
    return [reports[file] for file in logs], points


def kinds_of_folders(settings: Settings) -> dict[str, type[RigKind]]:
    """The kind of rig by the folders of a campaign below `data/raw`."""
    name = settings.campaign.name
    kinds: dict[str, type[RigKind]] = {name: TractionRig}
    if settings.campaign.torque is not None:
        kinds[f"{name}-torque"] = TorqueRig
    return kinds


def kind_of(file: str, settings: Settings) -> type[RigKind]:
    """The kind of rig of a log, by its folder; traction where the folder is not a campaign's."""
    kinds = kinds_of_folders(settings)
    # the nearest folder decides: the folder of the project may have the campaign's name, too
    for folder in Path(os.path.realpath(file)).parents:
        if folder.name in kinds:
            return kinds[folder.name]
    return kinds[settings.campaign.name]


# ---------------------------------------------------------------- plain values


def judged_logs(
    logs: Iterable[Log], settings: Settings, kind: type[RigKind], sheet: RunSheet
) -> list[JsonObject]:
    """The reports on logs of one kind, in the order of the logs; NaN where unknown.

    Args:
        logs: The logs by path and content.
        settings: Settings of the campaign.
        kind: The kind of rig.
        sheet: The run sheet as `sheet_of_paths` gives it.

    Raises:
        OilfilmError: As in `ingest_logs`.
    """
    reports, _ = _judged(logs, settings, kind, sheet)
    return reports


def _judged(
    logs: Iterable[Log], settings: Settings, kind: type[RigKind], sheet: RunSheet
) -> tuple[list[JsonObject], Curated]:
    """The reports of `judged_logs`, and the tables behind them."""
    ingested = ingest_logs(logs, settings, kind.kind_of_logs, sheet)
    curated = curate_ingested(ingested, kind(settings))
    reports = []
    for read_log in ingested.logs:
        file = read_log.file
        runs = tables.rows(curated.runs[curated.runs["file"] == file])
        refusals = curated.quarantine[curated.quarantine["file"] == file]
        is_accepted = runs and all(run["verdict"] != "refused" for run in runs)
        log_report: JsonObject = {
            "file": file,
            "campaign": settings.campaign.name,
            "verdict": "accepted" if is_accepted else "refused",
            "rig_kind": kind.name,
            "format": read_log.format_name,
            # encoding, delimiter and decimal mark
            **asdict(read_log.form),
            "rows": read_log.row_count,
            "refused_rows": int(refusals["refused_rows"].sum()),
            "run_sheet_rows": len(sheet.rows_of_log[file]) if file in sheet.rows_of_log else None,
            "refusals": tables.rows(refusals[_REFUSAL_COLUMNS]),
            "runs": [_checked_run(run, read_log, curated, settings, kind) for run in runs],
        }
        reports.append(log_report)
    return reports, curated


def _checked_run(
    run: Mapping[str, Any],
    read_log: ReadLog,
    curated: Curated,
    settings: Settings,
    kind: type[RigKind],
) -> JsonObject:
    """One run of a log."""
    points = curated.points[curated.points["run_id"] == run["run_id"]]
    understood = read_log.understood_of_run.get(run["run_id"], NOTHING_UNDERSTOOD)
    sources = understood.source_of_key
    is_traction = kind.name == TRACTION_KIND
    ranges = points[list(MEASURED[kind.name])].agg(["min", "max"])
    checked: JsonObject = {name: run[name] for name in _RUN_COLUMNS}
    warnings = [*run["warning"]]
    if not is_traction:
        warnings += radial_load_warnings(understood.unused_names)
    checked["warning"] = "; ".join(warnings)
    checked["oil_source"] = sources.get("oil", _CAMPAIGN)
    checked["rig_source"] = sources.get("rig" if is_traction else "bearing", _CAMPAIGN)
    checked["rows"] = run["samples"]
    checked["accepted_plateaus"] = run["accepted_points"]
    checked["columns"] = [asdict(column) for column in understood.columns]
    checked["unused_columns"] = [name for name in understood.unused_names if name]
    checked["set_points"] = _set_points(run, sources) if is_traction else {}
    checked["measured"] = ranges.set_axis(["minimum", "maximum"]).to_dict()
    checked["failed_gates"] = list(_failed_gates(points, kind))
    checked["gates_not_applied"] = list(
        _gates_without_data(run, curated.runs, points, settings, kind)
    )
    return checked


def _set_points(run: Mapping[str, Any], sources: Mapping[str, str]) -> JsonObject:
    """Value and source of each set point; None where there is none."""
    # the load has one set point, as force or as pressure; the other one follows by Hertz
    load_is_given = not LOAD_KEYS.isdisjoint(sources)
    set_points: JsonObject = {}
    for name in SET_POINT_KEYS:
        value = run[f"nominal_{name}"]
        source_without_header = _BY_HERTZ if load_is_given and name in LOAD_KEYS else _CAMPAIGN
        if pd.isna(value):
            set_points[name] = None
        else:
            set_points[name] = {"value": value, "source": sources.get(name, source_without_header)}
    return set_points


def _failed_gates(points: pd.DataFrame, kind: type[RigKind]) -> Iterator[JsonObject]:
    """Failed gates with their plateaus, the most frequent first."""
    failures = failed_gates.one_row_per_gate(points)
    first_rows = {
        str(gate): rows for gate, rows in failures.groupby("rule", sort=False)["first_row"]
    }
    for gate in sorted(first_rows, key=lambda gate: -len(first_rows[gate])):
        yield {
            "gate": gate,
            "plateaus": len(first_rows[gate]),
            "first_row": int(first_rows[gate].min()),
            "advice": advice_for(gate, kind),
        }


def _gates_without_data(
    run: Mapping[str, Any],
    runs: pd.DataFrame,
    points: pd.DataFrame,
    settings: Settings,
    kind: type[RigKind],
) -> Iterator[JsonObject]:
    """The gates that lack what they need, where the run has plateaus to be judged.

    Args:
        run: The run.
        runs: Table of all runs that are checked.
        points: Points of the run.
        settings: Settings of the campaign.
        kind: The kind of rig.
    """
    if points.empty:
        return
    gates: list[Gate[Any]] = [*RUN_GATES.for_rig(kind.name), *PLATEAU_GATES.for_rig(kind.name)]
    for gate in gates:
        if gate.needs and not _has_what_gate_needs(gate.needs, run, points, kind(settings)):
            yield {"gate": gate.name, "reason": RULES["lacking"][gate.needs]}
    if kind.name == TRACTION_KIND and run["verdict"] == "accepted":
        same_oil_and_rig = (runs["oil"] == run["oil"]) & (runs["rig"] == run["rig"])
        if (same_oil_and_rig & (runs["verdict"] == "accepted")).sum() < FEWEST_CURVES:
            yield {"gate": "odd_shape", "reason": RULES["lacking"]["other_curves"]}


def _has_what_gate_needs(
    need: str, run: Mapping[str, Any], points: pd.DataFrame, rig: RigKind
) -> bool:
    """Whether the points, the run or the rig have what a gate needs."""
    if need in points:
        return bool(points[need].notna().any())
    if need in run:
        return not np.all(pd.isna(run[need]))
    return bool(getattr(rig, need))


# ---------------------------------------------------------------- text
# Below, `log` is the report on a log that `judged_logs` gives.


def report(logs: Sequence[JsonObject]) -> str:
    """The text of the reports on logs; only long names make it wider than `WIDTH` columns."""
    lines: list[str] = []
    is_brief = len(logs) > _MOST_LOGS_IN_DETAIL
    shared_notes = _shared_notes(logs)
    for log in logs:
        lines += verdict_lines(log, shared_notes)
        if not is_brief or log["verdict"] == "refused":
            lines += _reading_lines(log)
            lines.append("")
    for note, count in shared_notes.items():
        lines += _wrapped(f"{READING_NOTE} of {count} logs: {printable(note)}", "")
    if len(logs) > 1:
        lines.append(f"{len(logs)} logs: {_counted(log['verdict'] for log in logs)}")
        lines += [f"  {printable(log['file'])}" for log in logs if log["verdict"] == "refused"]
        if is_brief:
            lines.append("Name a log alone to see how it was understood, or add --json.")
    return "\n".join(lines).rstrip()


def _shared_notes(logs: Sequence[JsonObject]) -> dict[str, int]:
    """Notes on how a log was read that several logs have, with the number of these logs."""
    counts: Counter[str] = Counter()
    for log in logs:
        refusals = log["refusals"]
        counts.update({row["reason"] for row in refusals if row["rule"] == READING_NOTE})
    return {note: count for note, count in counts.items() if count > 1}


def verdict_lines(log: JsonObject, shared_notes: Container[str] = ()) -> Iterator[str]:
    """The verdict on each run; the reason and the advice are right below it.

    Args:
        log: What was found in the log.
        shared_notes: Notes on reading that are said once for all logs, and not here.
    """
    runs = log["runs"]
    file = printable(log["file"])
    problems = _problems_by_run(log, shared_notes)
    if not runs:
        yield f"{file}: {log['verdict'].upper()}"
    if len(runs) > _MOST_RUNS_LISTED:
        verdicts = _counted(run["verdict"] for run in runs)
        yield f"{file}: {len(runs)} runs: {verdicts}; --json shows all"
        runs = [run for run in runs if problems[run["run_id"]]]
    refused_first = sorted(runs, key=lambda run: run["verdict"] != "refused")
    for run in refused_first[:_MOST_RUNS_LISTED]:
        plateau_counts = f"{run['accepted_plateaus']} of {run['plateaus']} plateaus"
        verdict = run["verdict"].upper()
        yield f"{printable(run['run_id'])}: {verdict}, {plateau_counts}, {run['rows']} rows"
        yield from problems[run["run_id"]]
    yield from problems[_FILE]


@dataclass(frozen=True)
class _Problem:
    """A finding about a run or a file.

    Attributes:
        rule: The rule or gate; empty where it is none.
        text: What was found.
        advice: What to do about it.
    """

    rule: str
    text: str
    advice: str = ""


def _problems_by_run(log: JsonObject, shared_notes: Container[str]) -> dict[str, list[str]]:
    """Lines on what is wrong or doubtful and what to do, by run and for the file (`_FILE`).

    Args:
        log: What was found in the log.
        shared_notes: Notes on reading that are said elsewhere.
    """
    problems: dict[str, list[_Problem]] = {_FILE: []}
    for run in log["runs"]:
        problems[run["run_id"]] = []
    for run_id, refusals in _refusals_by_rule(log, shared_notes):
        problems_of_run = problems.get(run_id, problems[_FILE])
        problems_of_run.append(_problem_of_rule(refusals))
    for run in log["runs"]:
        problems_of_run = problems[run["run_id"]]
        rules_named = {problem.rule for problem in problems_of_run}
        if run["warning"]:
            problems_of_run.append(_Problem("", f"WARNING: {run['warning']}"))
        for failure in run["failed_gates"]:
            if failure["gate"] not in rules_named:
                noun = "plateau" if failure["plateaus"] == 1 else "plateaus"
                text = (
                    f"{failure['gate']}: {failure['plateaus']} {noun}, first at row "
                    f"{failure['first_row']}"
                )
                problems_of_run.append(_Problem(failure["gate"], text, failure["advice"]))
    if log["run_sheet_rows"] == 0:
        advice = "Only its header counts. Correct the name in the sheet."
        problems[_FILE].append(_Problem("", "the run sheet has no row for this log", advice))
    return {
        run_id: list(_lines_by_cause(found_problems)) for run_id, found_problems in problems.items()
    }


def _refusals_by_rule(
    log: JsonObject, shared_notes: Container[str]
) -> Iterator[tuple[str, list[JsonObject]]]:
    """The refusals of a log by run and rule, in the order in which they are first named.

    Args:
        log: What was found in the log.
        shared_notes: Notes on reading that are left out.
    """
    by_rule: dict[tuple[str, str], list[JsonObject]] = {}
    for refusal in log["refusals"]:
        if refusal["rule"] == READING_NOTE and refusal["reason"] in shared_notes:
            continue
        by_rule.setdefault((refusal["run_id"], refusal["rule"]), []).append(refusal)
    for (run_id, _), refusals in by_rule.items():
        yield run_id, refusals


def _problem_of_rule(refusals: Sequence[JsonObject]) -> _Problem:
    """Refusals of one run by one rule: the first one in words, the others counted."""
    first, *others = refusals
    text = f"{first['rule']}: {first['reason']}"
    if others:
        rows = sum(refusal["refused_rows"] for refusal in others)
        row_note = f" ({rows} rows)" if rows else ""
        text += f"; and {len(others)} more of this kind{row_note}: --json shows all"
    return _Problem(first["rule"], text, first["advice"])


def _lines_by_cause(problems: Sequence[_Problem]) -> Iterator[str]:
    """Problems as lines: causes first, each with what may only follow from it below."""
    rules = {problem.rule for problem in problems}
    consequences: set[str] = set()
    for rule in rules & CONSEQUENCES.keys():
        consequences |= CONSEQUENCES[rule]
    # where two causes may follow from each other, neither is shown as the cause
    cause_rules = CONSEQUENCES.keys() - consequences
    causes = [problem for problem in problems if problem.rule in cause_rules]
    shown_rules: set[str] = set()
    for cause in causes:
        yield from _problem_lines(cause)
        shown_rules.add(cause.rule)
        following_rules = (rules & CONSEQUENCES[cause.rule]) - shown_rules
        if following_rules:
            yield "    These may only follow from it:"
        for problem in problems:
            if problem.rule in following_rules:
                yield from _wrapped(printable(problem.text), "      ")
        shown_rules |= following_rules
    for problem in problems:
        if problem.rule not in shown_rules:
            yield from _problem_lines(problem)


def _problem_lines(problem: _Problem) -> Iterator[str]:
    yield from _wrapped(printable(problem.text), "  ")
    if problem.advice:
        yield from _wrapped(f"-> {printable(problem.advice)}", "    ")


def _counted(names: Iterable[str]) -> str:
    """Each different name with its number, sorted by name."""
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(names).items()))


def _wrapped(text: str, indent: str) -> list[str]:
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _reading_lines(log: JsonObject) -> Iterator[str]:
    """How a log was understood: format, columns, conditions, gates that could not be applied."""
    format_facts = [log["format"]]
    if log["encoding"]:
        format_facts.append(log["encoding"])
        format_facts.append(f"delimiter {log['delimiter']}")
        format_facts.append(f"decimal {log['decimal_mark']}")
    refused_note = f" ({log['refused_rows']} refused)" if log["refused_rows"] else ""
    read_as = (
        f"Read as {log['rig_kind']} log of campaign {log['campaign']}: {', '.join(format_facts)}"
    )
    yield from _wrapped(f"{read_as}, {log['rows']} rows{refused_note}", "  ")
    runs = log["runs"]
    if not runs:
        return
    rig_or_bearing = "rig" if log["rig_kind"] == "traction" else "bearing"
    oils = sorted({f"{run['oil']} ({run['oil_source']})" for run in runs})
    rigs = sorted({f"{run['rig']} ({run['rig_source']})" for run in runs})
    yield f"  Oil {', '.join(oils)}; {rig_or_bearing} {', '.join(rigs)}"
    yield ""
    yield from _columns(runs)
    yield from _conditions(log)
    yield from _gates_not_applied(runs)


def _columns(runs: Sequence[JsonObject]) -> Iterator[str]:
    """Each column of a log with its range over all runs."""
    columns = pd.DataFrame(chain.from_iterable(run["columns"] for run in runs))
    if len(columns):
        identity = ["name", "logged_unit", "quantity", "unit"]
        over_runs = columns.groupby(identity, sort=False, as_index=False).agg(
            {"minimum": "min", "maximum": "max", "count": "sum", "missing": "sum"}
        )
        for bound in ("minimum", "maximum"):
            over_runs[bound] = [
                "-" if pd.isna(value) else f"{value:.5g}" for value in over_runs[bound]
            ]
        rows = over_runs.astype(str).to_numpy().tolist()
        yield from text_table([_COLUMN_HEADS, *rows], right=4, indent="  ")
    unused = dict.fromkeys(chain.from_iterable(run["unused_columns"] for run in runs))
    if unused:
        yield from _wrapped(f"Not read: {', '.join(map(printable, unused))}", "  ")


def _conditions(log: JsonObject) -> Iterator[str]:
    """Operating conditions and traction over all runs of a log."""
    runs = log["runs"]
    title = "Plateaus" if len(runs) == 1 else f"Plateaus of {len(runs)} runs"
    rows = [[title, "Measured", "Set point"]]
    for name in runs[0]["measured"]:
        measured = list(chain.from_iterable(run["measured"][name].values() for run in runs))
        set_points = [run["set_points"].get(name) for run in runs]
        rows.append([name, _range(measured), _set_point_cell(set_points)])
    yield ""
    yield from text_table(rows, right=2, indent="  ")


def _set_point_cell(set_points: Sequence[JsonObject | None]) -> str:
    """Range of one set point over runs, with its sources."""
    stated = [set_point for set_point in set_points if set_point is not None]
    if not stated:
        return "-"
    sources = sorted({set_point["source"] for set_point in stated})
    return f"{_range([set_point['value'] for set_point in stated])} ({', '.join(sources)})"


def _range(values: Sequence[float]) -> str:
    """The range of some numbers; small numbers have four decimals."""
    rising = sorted(value for value in values if not isnan(value))
    if not rising:
        return "-"
    # z: no minus before a zero
    number_format = "z.4f" if max(map(abs, rising)) < 10 else ".4g"
    lowest = format(rising[0], number_format)
    highest = format(rising[-1], number_format)
    return lowest if lowest == highest else f"{lowest}..{highest}"


def _gates_not_applied(runs: Sequence[JsonObject]) -> Iterator[str]:
    """The gates that could not be applied to some or all runs, by what they lack."""
    lacking = pd.DataFrame(chain.from_iterable(run["gates_not_applied"] for run in runs))
    if len(lacking):
        yield ""
        yield "  Gates that could not be applied"
        for reason, gates in lacking.drop_duplicates().groupby("reason", sort=False)["gate"]:
            yield from _wrapped(f"{', '.join(gates)}: {reason}", "    ")
