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
from oilfilm.curation.curate import CuratedTables, curate_ingested
from oilfilm.curation.gate import RULES, Gate
from oilfilm.curation.plateau_gates import PLATEAU_GATES, advice_for
from oilfilm.curation.rig_kind import TORQUE_KIND, TRACTION_KIND, RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.curation.torque_rig import TorqueRig, radial_load_warnings
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import LOAD_KEYS, NO_INTERPRETATION, READING_NOTE, SET_POINT_KEYS
from oilfilm.logs.first_seen import FirstSeenDigests
from oilfilm.logs.ingest import UNKNOWN_FORMAT, LogSummary, ingest_logs, read_bytes
from oilfilm.logs.raw_files import log_names_and_faults, raw_log_names
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import is_run_sheet_of_any_campaign, sheet_of_paths
from oilfilm.settings.campaign import SetPoints
from oilfilm.settings.resolve import campaign_names, resolve
from oilfilm.settings.resolved import Settings
from oilfilm.surface.shape import FEWEST_CURVES
from oilfilm.tables import failed_gates

# Columns of plateaus whose range a check reports, by kind of rig.
_MEASURED_COLUMNS_BY_KIND = {
    TRACTION_KIND: (*SET_POINT_KEYS, "slide_roll_ratio", "traction_coefficient", "lambda_ratio"),
    TORQUE_KIND: TorqueRig.mean_columns,
}
_REFUSAL_COLUMNS = ["run_id", "rule", "reason", "advice", "first_row", "last_row", "refused_rows"]
_RUN_COLUMNS = ["run_id", "label", "oil", "rig", "verdict", "warning", "plateaus"]
# Columns of `CheckedLogs.to_frame`.
_FRAME_COLUMNS = [
    *("file", "run_id", "oil", "rig", "verdict", "plateaus", "accepted_plateaus", "rows"),
    "warning",
]
# Source of a label or set point that the header does not give.
_FROM_CAMPAIGN, _FROM_HERTZ = "campaign", "by Hertz"
# Characters in a line of the text.
TEXT_WIDTH = 100
# More runs of one log, and more logs at once, are shown in less detail.
_MAX_LISTED_RUNS = 10
_MAX_DETAILED_LOGS = 10
_COLUMN_HEADS = ["Column", "Unit", "Read as", "Unit", "Smallest", "Largest", "Numbers", "Missing"]
# Key of what concerns the whole file, where problems are listed by run.
_FILE_KEY = ""
_RIG_CLASSES: tuple[type[RigKind], ...] = (TractionRig, TorqueRig)
# Rule of a cause -> rules whose faults may only follow from it.
CONSEQUENCES_BY_CAUSE: Mapping[str, frozenset[str]] = {
    cause: frozenset(rules.split()) for cause, rules in RULES["causes"].items()
}
# Path and content of a log.
PathAndContent = tuple[str, bytes]
# A report on a log, a run or a part of it: plain values by key, as in JSON.
JsonObject = dict[str, Any]


@dataclass(frozen=True)
class CheckedLogs:
    """The verdicts on some logs.

    Attributes:
        logs: What was found in each log, as plain values: what `oilfilm check --json` prints.
        campaign: The campaign by whose columns, rig and limits they were judged.
        notes: What whoever reads the verdicts must know, too, in sentences.
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
        for log_report in self.logs:
            run_reports = log_report["runs"] or [{"verdict": log_report["verdict"]}]
            rows += [{"file": log_report["file"]} | run_report for run_report in run_reports]
        return pd.DataFrame(rows).reindex(columns=_FRAME_COLUMNS)

    def summary(self) -> str:
        """Verdicts with reasons and advice, and how each log was understood, as text."""
        return reports_text(self.logs)

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
            files += [path / name for name in raw_log_names(path)]
        else:
            files.append(path)
    config_option = None if config is None else Path(config)
    settings_folder, project_root = _config_and_project_folders(config_option, files)
    raw_folder = project_root / "data" / "raw"
    given_campaign = campaign or _campaign_name_of(files, raw_folder, settings_folder)
    settings = resolve(settings_folder, {"campaign": given_campaign} if given_campaign else {})
    # a file that is named twice, as `june` and `june/run01.csv`, would be a copy of itself
    file_by_location: dict[str, Path] = {}
    for path in files:
        # `resolve` would follow a link, which is a log of its own
        file_by_location.setdefault(os.path.abspath(path), path)  # noqa: PTH100
    # a pattern such as data/raw/own/*.csv names the run sheet too
    log_paths = [
        path
        for path in file_by_location.values()
        if not is_run_sheet_of_any_campaign(path, raw_folder)
    ]
    if not log_paths:
        raise OilfilmError(f"{_decodable_path(files[0])}: is a run sheet. Name logs.")
    campaign_name = settings.campaign.name
    # read one after the other: a log is not needed beside its samples
    reader_by_path = {_decodable_path(path): partial(read_bytes, path) for path in log_paths}
    reports, points = _reports_and_points(reader_by_path, settings, raw_folder)
    if given_campaign:
        notes = tuple(_sentences_on_missing_logs(campaign_name, raw_folder))
    else:
        notes = (_advice_for_logs_of_no_campaign(campaign_name),)
    return CheckedLogs(reports, campaign_name, notes, points)


def _config_and_project_folders(
    config_option: Path | None, logs: Sequence[Path]
) -> tuple[Path, Path]:
    """The configuration folder and the folder of the project by which logs are judged.

    It is that of the option, else that of the project in whose `data/raw` the logs are, else that
    of the current folder, else oilfilm's own.

    Raises:
        OilfilmError: The logs are of several projects.
    """
    if config_option:
        return config_option, project_folder(config_option)
    folder_of_log = map(_project_folder_of, logs)
    project_folders = sorted({folder for folder in folder_of_log if folder is not None})
    if len(project_folders) > 1:
        projects_in_words = " and ".join(map(str, project_folders))
        raise OilfilmError(
            f"{logs[0]}: the logs are of the projects {projects_in_words}. Check one "
            "project at a time, or name with --config the configuration folder that is meant."
        )
    if project_folders and project_folders[0] != Path.cwd():
        return project_folders[0] / "config", project_folders[0]
    return config_folder(None), project_folder(None)


def _project_folder_of(log: Path) -> Path | None:
    """The folder of the project in whose `data/raw` a log is; None where it is in none."""
    # not `resolve`, which fails on a link to itself
    for folder in Path(os.path.realpath(log)).parents:
        is_raw_folder = folder.name == "raw" and folder.parent.name == "data"
        if is_raw_folder and (folder.parents[1] / "config" / "config.yaml").is_file():
            return folder.parents[1]
    return None


def _advice_for_logs_of_no_campaign(campaign_name: str) -> str:
    """What to do about logs that are in no campaign's folder."""
    return (
        f"The logs are in the folder of no campaign: the names of columns, the rig and the limits "
        f"are those of the campaign {campaign_name!r}, which may be another laboratory's. "
        "`oilfilm init FOLDER LOG...` makes a project for logs of your own. --campaign names a "
        "campaign that you have."
    )


def _sentences_on_missing_logs(campaign_name: str, raw_folder: Path) -> Iterator[str]:
    """Sentences on the logs of a campaign that an earlier run has read and that are missing now."""
    for folder_name in (campaign_name, f"{campaign_name}-torque"):
        first_seen = FirstSeenDigests(
            campaign_name, folder_name, folder=raw_folder.parent / "first_seen"
        )
        folder = raw_folder / folder_name
        logs_now = log_names_and_faults(folder) if folder.is_dir() else ()
        sentence = first_seen.sentence_on_missing(
            f"data/raw/{folder_name}/{name}" for name, _ in logs_now
        )
        if sentence:
            yield sentence


def _campaign_name_of(paths: Iterable[Path], raw_folder: Path, settings_folder: Path) -> str | None:
    """The name of the campaign in whose folders the logs are; None where they are elsewhere.

    Raises:
        OilfilmError: They are of several campaigns.
    """
    raw_folder = raw_folder.resolve()
    known_names = campaign_names(settings_folder)
    campaign_names_of_logs = set()
    for path in paths:
        # not `resolve`, which fails on a link to itself
        real_path = Path(os.path.realpath(path))
        if raw_folder in real_path.parents:
            folder_name = real_path.relative_to(raw_folder).parts[0]
            # a campaign may itself have a name that ends in -torque
            for campaign_name in (folder_name, folder_name.removesuffix("-torque")):
                if campaign_name in known_names:
                    campaign_names_of_logs.add(campaign_name)
                    break
    if len(campaign_names_of_logs) > 1:
        campaigns_in_words = " and ".join(sorted(campaign_names_of_logs))
        raise OilfilmError(
            f"{raw_folder}: the logs are of the campaigns {campaigns_in_words}. Check one campaign "
            "at a time, or name with --campaign the one whose limits are meant."
        )
    return campaign_names_of_logs.pop() if campaign_names_of_logs else None


def _decodable_path(path: Path) -> str:
    """A path as text, with escapes for bytes that the encoding of the system cannot decode."""
    return str(path).encode("utf-8", "backslashreplace").decode("utf-8")


def reports_on_logs(
    reader_by_path: Mapping[str, Callable[[], bytes]], settings: Settings, raw_folder: Path
) -> list[JsonObject]:
    """The reports on logs of both kinds as plain values, in the order of the logs.

    Args:
        reader_by_path: Function that returns the content of a log, by the path of the log.
        settings: Settings of the campaign.
        raw_folder: The folder `data/raw` with the campaigns' folders, whose run sheets are used.

    Raises:
        OilfilmError: As in `ingest_logs`.
    """
    reports, _ = _reports_and_points(reader_by_path, settings, raw_folder)
    return reports


def _reports_and_points(
    reader_by_path: Mapping[str, Callable[[], bytes]], settings: Settings, raw_folder: Path
) -> tuple[list[JsonObject], pd.DataFrame]:
    """The reports of `reports_on_logs`, and the accepted points of the traction logs."""
    report_by_path: dict[str, JsonObject] = {}
    points = pd.DataFrame()
    for rig_class in _RIG_CLASSES:
        paths = [path for path in reader_by_path if rig_class_of(path, settings) is rig_class]
        if paths:
            sheet = sheet_of_paths(
                [Path(path) for path in paths], raw_folder, settings, rig_class.log_schema
            )
            contents = ((path, reader_by_path[path]()) for path in paths)
            reports_of_kind, curated = _reports_and_tables(contents, settings, rig_class, sheet)
            report_by_path.update(
                (log_report["file"], log_report) for log_report in reports_of_kind
            )
            if rig_class is TractionRig:
                points = curated.points[curated.points["accepted"]].reset_index(drop=True)
    return [report_by_path[path] for path in reader_by_path], points


def rig_class_by_folder(settings: Settings) -> dict[str, type[RigKind]]:
    """The kind of rig by the name of each of a campaign's folders below `data/raw`."""
    campaign_name = settings.campaign.name
    rig_class_by_name: dict[str, type[RigKind]] = {campaign_name: TractionRig}
    if settings.campaign.torque is not None:
        rig_class_by_name[f"{campaign_name}-torque"] = TorqueRig
    return rig_class_by_name


def rig_class_of(path: str, settings: Settings) -> type[RigKind]:
    """The kind of rig of a log, by its folder; traction where the folder is not a campaign's."""
    rig_class_by_name = rig_class_by_folder(settings)
    # the nearest folder decides: the folder of the project may have the campaign's name, too
    for folder in Path(os.path.realpath(path)).parents:
        if folder.name in rig_class_by_name:
            return rig_class_by_name[folder.name]
    return rig_class_by_name[settings.campaign.name]


# ---------------------------------------------------------------- plain values


def reports_on_logs_of_kind(
    logs: Iterable[PathAndContent],
    settings: Settings,
    rig_class: type[RigKind],
    run_sheet: RunSheet,
) -> list[JsonObject]:
    """The reports on logs of one kind of rig, in the order of the logs; NaN where unknown.

    Args:
        logs: Path and content of each log.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
        run_sheet: The run sheet as `sheet_of_paths` gives it.

    Raises:
        OilfilmError: As in `ingest_logs`.
    """
    reports, _ = _reports_and_tables(logs, settings, rig_class, run_sheet)
    return reports


def _reports_and_tables(
    logs: Iterable[PathAndContent],
    settings: Settings,
    rig_class: type[RigKind],
    run_sheet: RunSheet,
) -> tuple[list[JsonObject], CuratedTables]:
    """The reports of `reports_on_logs_of_kind`, and the tables behind them."""
    ingested = ingest_logs(logs, settings, rig_class.log_schema, run_sheet)
    curated = curate_ingested(ingested, rig_class(settings))
    reports = []
    for log_summary in ingested.logs:
        path = log_summary.file
        runs = tables.rows(curated.runs[curated.runs["file"] == path])
        refusals = curated.quarantine[curated.quarantine["file"] == path]
        is_accepted = runs and all(run["verdict"] != "refused" for run in runs)
        log_report: JsonObject = {
            "file": path,
            "campaign": settings.campaign.name,
            "verdict": "accepted" if is_accepted else "refused",
            "rig_kind": rig_class.name,
            "format": log_summary.format_name,
            # encoding, delimiter and decimal mark
            **asdict(log_summary.dialect),
            "rows": log_summary.row_count,
            "refused_rows": int(refusals["refused_rows"].sum()),
            "run_sheet_rows": len(run_sheet.rows_of_log[path])
            if path in run_sheet.rows_of_log
            else None,
            "refusals": tables.rows(refusals[_REFUSAL_COLUMNS]),
            "runs": [
                _report_on_run(run, log_summary, curated, settings, rig_class) for run in runs
            ],
        }
        reports.append(log_report)
    return reports, curated


def _report_on_run(
    run: Mapping[str, Any],
    log_summary: LogSummary,
    curated: CuratedTables,
    settings: Settings,
    rig_class: type[RigKind],
) -> JsonObject:
    """The report on one run of a log, as plain values."""
    points = curated.points[curated.points["run_id"] == run["run_id"]]
    interpretation = log_summary.interpretation_of_run.get(run["run_id"], NO_INTERPRETATION)
    source_by_key = interpretation.source_of_key
    is_traction = rig_class.name == TRACTION_KIND
    ranges = points[list(_MEASURED_COLUMNS_BY_KIND[rig_class.name])].agg(["min", "max"])
    run_report: JsonObject = {name: run[name] for name in _RUN_COLUMNS}
    warnings = [*run["warning"]]
    if not is_traction:
        warnings += radial_load_warnings(interpretation.unused_names)
    run_report["warning"] = "; ".join(warnings)
    run_report["oil_source"] = source_by_key.get("oil", _FROM_CAMPAIGN)
    run_report["rig_source"] = source_by_key.get(
        "rig" if is_traction else "bearing", _FROM_CAMPAIGN
    )
    run_report["rows"] = run["samples"]
    run_report["accepted_plateaus"] = run["accepted_points"]
    run_report["columns"] = [asdict(column) for column in interpretation.columns]
    run_report["unused_columns"] = [name for name in interpretation.unused_names if name]
    run_report["set_points"] = {}
    if is_traction:
        run_report["set_points"] = _set_point_values(
            run, source_by_key, settings.campaign.set_points
        )
    run_report["measured"] = ranges.set_axis(["minimum", "maximum"]).to_dict()
    run_report["failed_gates"] = list(_failed_gate_reports(points, rig_class))
    run_report["gates_not_applied"] = list(
        _unapplied_gate_reports(run, curated.runs, points, settings, rig_class)
    )
    return run_report


def _set_point_values(
    run: Mapping[str, Any], source_by_key: Mapping[str, str], campaign_set_points: SetPoints
) -> JsonObject:
    """Value and source of each set point; None where there is none.

    Args:
        run: Row of the table `runs`.
        source_by_key: Source of what the log or the run sheet states, by key of the header.
        campaign_set_points: What the campaign file states.
    """
    # the load has one set point, as force or as pressure; the other one follows by Hertz
    is_load_of_log = not LOAD_KEYS.isdisjoint(source_by_key)
    set_points: JsonObject = {}
    for key in SET_POINT_KEYS:
        value = run[f"nominal_{key}"]
        if pd.isna(value):
            set_points[key] = None
            continue
        is_stated_by_campaign = getattr(campaign_set_points, key) is not None
        if key in LOAD_KEYS and (is_load_of_log or not is_stated_by_campaign):
            source_without_log = _FROM_HERTZ
        else:
            source_without_log = _FROM_CAMPAIGN
        set_points[key] = {"value": value, "source": source_by_key.get(key, source_without_log)}
    return set_points


def _failed_gate_reports(points: pd.DataFrame, rig_class: type[RigKind]) -> Iterator[JsonObject]:
    """Failed gates with their plateaus, the most frequent first."""
    failures = failed_gates.one_row_per_gate(points)
    first_rows_by_gate = {
        str(gate_name): first_rows
        for gate_name, first_rows in failures.groupby("rule", sort=False)["first_row"]
    }
    most_frequent_first = sorted(first_rows_by_gate.items(), key=lambda entry: -len(entry[1]))
    for gate_name, first_rows in most_frequent_first:
        yield {
            "gate": gate_name,
            "plateaus": len(first_rows),
            "first_row": int(first_rows.min()),
            "advice": advice_for(gate_name, rig_class),
        }


def _unapplied_gate_reports(
    run: Mapping[str, Any],
    runs: pd.DataFrame,
    points: pd.DataFrame,
    settings: Settings,
    rig_class: type[RigKind],
) -> Iterator[JsonObject]:
    """The gates that lack what they need, where the run has plateaus to be judged.

    Args:
        run: The run.
        runs: Table of all runs that are checked.
        points: Points of the run.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
    """
    if points.empty:
        return
    run_gates = RUN_GATES.for_rig(rig_class.name)
    plateau_gates = PLATEAU_GATES.for_rig(rig_class.name)
    gates: list[Gate[Any]] = [*run_gates, *plateau_gates]
    for gate in gates:
        if gate.needs and not _has_what_gate_needs(gate.needs, run, points, rig_class(settings)):
            yield {"gate": gate.name, "reason": RULES["lacking"][gate.needs]}
    if rig_class.name == TRACTION_KIND and run["verdict"] == "accepted":
        same_oil_and_rig = (runs["oil"] == run["oil"]) & (runs["rig"] == run["rig"])
        if (same_oil_and_rig & (runs["verdict"] == "accepted")).sum() < FEWEST_CURVES:
            yield {"gate": "odd_shape", "reason": RULES["lacking"]["other_curves"]}


def _has_what_gate_needs(
    need: str, run: Mapping[str, Any], points: pd.DataFrame, rig_kind: RigKind
) -> bool:
    """Whether the points, the run or the rig have what a gate needs."""
    if need in points:
        return bool(points[need].notna().any())
    if need in run:
        return not np.all(pd.isna(run[need]))
    return bool(getattr(rig_kind, need))


# ---------------------------------------------------------------- text
# Below, `log_report` is a report on a log as `reports_on_logs` returns it, `run_report` one on
# its runs.


def reports_text(log_reports: Sequence[JsonObject]) -> str:
    """The text of the reports on logs.

    Only long names and lists of oils and rigs make it wider than `TEXT_WIDTH` columns.
    """
    lines: list[str] = []
    is_brief = len(log_reports) > _MAX_DETAILED_LOGS
    shared_notes = _shared_notes(log_reports)
    for log_report in log_reports:
        lines += verdict_lines(log_report, shared_notes)
        if not is_brief or log_report["verdict"] == "refused":
            lines += _reading_lines(log_report)
            lines.append("")
    for note, count in shared_notes.items():
        lines += _wrapped_lines(f"{READING_NOTE} of {count} logs: {printable(note)}", "")
    if len(log_reports) > 1:
        verdicts = _counts_in_words(log_report["verdict"] for log_report in log_reports)
        lines.append(f"{len(log_reports)} logs: {verdicts}")
        for log_report in log_reports:
            if log_report["verdict"] == "refused":
                lines.append(f"  {printable(log_report['file'])}")
        if is_brief:
            lines.append("Name a log alone to see how it was understood, or add --json.")
    return "\n".join(lines).rstrip()


def _shared_notes(log_reports: Sequence[JsonObject]) -> dict[str, int]:
    """Notes on how a log was read that several logs have, with the number of these logs."""
    log_count_by_note: Counter[str] = Counter()
    for log_report in log_reports:
        refusals = log_report["refusals"]
        log_count_by_note.update({row["reason"] for row in refusals if row["rule"] == READING_NOTE})
    return {note: count for note, count in log_count_by_note.items() if count > 1}


def verdict_lines(log_report: JsonObject, shared_notes: Container[str] = ()) -> Iterator[str]:
    """The verdict on each run; the reason and the advice are right below it.

    Args:
        log_report: The report on the log.
        shared_notes: Notes on reading that are said once for all logs, and not here.
    """
    run_reports = log_report["runs"]
    path = printable(log_report["file"])
    lines_by_run = _problem_lines_by_run(log_report, shared_notes)
    if not run_reports:
        yield f"{path}: {log_report['verdict'].upper()}"
    if len(run_reports) > _MAX_LISTED_RUNS:
        verdicts = _counts_in_words(run_report["verdict"] for run_report in run_reports)
        yield f"{path}: {len(run_reports)} runs: {verdicts}; --json shows all"
        run_reports = [
            run_report for run_report in run_reports if lines_by_run[run_report["run_id"]]
        ]
    refused_first = sorted(run_reports, key=lambda run_report: run_report["verdict"] != "refused")
    for run_report in refused_first[:_MAX_LISTED_RUNS]:
        plateau_counts = f"{run_report['accepted_plateaus']} of {run_report['plateaus']} plateaus"
        verdict = run_report["verdict"].upper()
        run_id = run_report["run_id"]
        yield f"{printable(run_id)}: {verdict}, {plateau_counts}, {run_report['rows']} rows"
        yield from lines_by_run[run_id]
    yield from lines_by_run[_FILE_KEY]


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


def _problem_lines_by_run(
    log_report: JsonObject, shared_notes: Container[str]
) -> dict[str, list[str]]:
    """Lines on what is wrong or doubtful and what to do, by run and for the file (`_FILE_KEY`).

    Args:
        log_report: The report on the log.
        shared_notes: Notes on reading that are said elsewhere.
    """
    problems_by_run: dict[str, list[_Problem]] = {_FILE_KEY: []}
    for run_report in log_report["runs"]:
        problems_by_run[run_report["run_id"]] = []
    for run_id, refusals in _refusals_by_rule(log_report, shared_notes):
        problems_of_run = problems_by_run.get(run_id, problems_by_run[_FILE_KEY])
        problems_of_run.append(_problem_of_rule(refusals))
    for run_report in log_report["runs"]:
        problems_of_run = problems_by_run[run_report["run_id"]]
        named_rules = {problem.rule for problem in problems_of_run}
        if run_report["warning"]:
            problems_of_run.append(_Problem("", f"WARNING: {run_report['warning']}"))
        for failure in run_report["failed_gates"]:
            if failure["gate"] not in named_rules:
                noun = "plateau" if failure["plateaus"] == 1 else "plateaus"
                text = (
                    f"{failure['gate']}: {failure['plateaus']} {noun}, first at row "
                    f"{failure['first_row']}"
                )
                problems_of_run.append(_Problem(failure["gate"], text, failure["advice"]))
    if log_report["run_sheet_rows"] == 0:
        advice = "Only its header counts. Correct the name in the sheet."
        problems_by_run[_FILE_KEY].append(
            _Problem("", "the run sheet has no row for this log", advice)
        )
    return {run_id: list(_lines_by_cause(problems)) for run_id, problems in problems_by_run.items()}


def _refusals_by_rule(
    log_report: JsonObject, shared_notes: Container[str]
) -> Iterator[tuple[str, list[JsonObject]]]:
    """The refusals of a log, grouped by run and rule in the order in which they are first named.

    Args:
        log_report: The report on the log.
        shared_notes: Notes on reading that are left out.

    Yields:
        The run, and its refusals by one rule.
    """
    refusals_by_run_and_rule: dict[tuple[str, str], list[JsonObject]] = {}
    for refusal in log_report["refusals"]:
        if refusal["rule"] == READING_NOTE and refusal["reason"] in shared_notes:
            continue
        refusals_by_run_and_rule.setdefault((refusal["run_id"], refusal["rule"]), []).append(
            refusal
        )
    for (run_id, _), refusals in refusals_by_run_and_rule.items():
        yield run_id, refusals


def _problem_of_rule(refusals: Sequence[JsonObject]) -> _Problem:
    """Refusals of one run by one rule: the first one in words, the others counted."""
    first_refusal, *other_refusals = refusals
    text = f"{first_refusal['rule']}: {first_refusal['reason']}"
    if other_refusals:
        refused_rows = sum(refusal["refused_rows"] for refusal in other_refusals)
        row_note = f" ({refused_rows} rows)" if refused_rows else ""
        text += f"; and {len(other_refusals)} more of this kind{row_note}: --json shows all"
    return _Problem(first_refusal["rule"], text, first_refusal["advice"])


def _lines_by_cause(problems: Sequence[_Problem]) -> Iterator[str]:
    """Problems as lines: causes first, each with what may only follow from it below."""
    rules = {problem.rule for problem in problems}
    consequences: set[str] = set()
    for rule in rules & CONSEQUENCES_BY_CAUSE.keys():
        consequences |= CONSEQUENCES_BY_CAUSE[rule]
    # where two causes may follow from each other, neither is shown as the cause
    cause_rules = CONSEQUENCES_BY_CAUSE.keys() - consequences
    causes = [problem for problem in problems if problem.rule in cause_rules]
    shown_rules: set[str] = set()
    for cause in causes:
        yield from _problem_lines(cause)
        shown_rules.add(cause.rule)
        following_rules = (rules & CONSEQUENCES_BY_CAUSE[cause.rule]) - shown_rules
        if following_rules:
            yield "    These may only follow from it:"
        for problem in problems:
            if problem.rule in following_rules:
                yield from _wrapped_lines(printable(problem.text), "      ")
        shown_rules |= following_rules
    for problem in problems:
        if problem.rule not in shown_rules:
            yield from _problem_lines(problem)


def _problem_lines(problem: _Problem) -> Iterator[str]:
    """What was found, and below it what to do."""
    yield from _wrapped_lines(printable(problem.text), "  ")
    if problem.advice:
        yield from _wrapped_lines(f"-> {printable(problem.advice)}", "    ")


def _counts_in_words(names: Iterable[str]) -> str:
    """How often each name occurs, sorted by name: "2 accepted, 1 refused"."""
    return ", ".join(f"{count} {name}" for name, count in sorted(Counter(names).items()))


def _wrapped_lines(text: str, indent: str) -> list[str]:
    """A text in lines of at most `TEXT_WIDTH` characters, further ones indented more."""
    return textwrap.wrap(
        text,
        TEXT_WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _reading_lines(log_report: JsonObject) -> Iterator[str]:
    """How a log was understood: format, columns, conditions, gates that could not be applied.

    Nothing, where its format is not known.
    """
    if log_report["format"] == UNKNOWN_FORMAT:
        return
    format_facts = [log_report["format"]]
    if log_report["encoding"]:
        format_facts.append(log_report["encoding"])
        format_facts.append(f"delimiter {log_report['delimiter']}")
        format_facts.append(f"decimal {log_report['decimal_mark']}")
    refused_note = f" ({log_report['refused_rows']} refused)" if log_report["refused_rows"] else ""
    read_as = (
        f"Read as {log_report['rig_kind']} log of campaign {log_report['campaign']}: "
        f"{', '.join(format_facts)}"
    )
    yield from _wrapped_lines(f"{read_as}, {log_report['rows']} rows{refused_note}", "  ")
    run_reports = log_report["runs"]
    if not run_reports:
        return
    rig_or_bearing = "rig" if log_report["rig_kind"] == "traction" else "bearing"
    oils = sorted(
        {f"{run_report['oil']} ({run_report['oil_source']})" for run_report in run_reports}
    )
    rigs = sorted(
        {f"{run_report['rig']} ({run_report['rig_source']})" for run_report in run_reports}
    )
    yield f"  Oil {', '.join(oils)}; {rig_or_bearing} {', '.join(rigs)}"
    yield ""
    yield from _column_lines(run_reports)
    yield from _condition_lines(log_report)
    yield from _lines_on_unapplied_gates(run_reports)


def _column_lines(run_reports: Sequence[JsonObject]) -> Iterator[str]:
    """Each column of a log with its range over all runs."""
    columns = pd.DataFrame(chain.from_iterable(run_report["columns"] for run_report in run_reports))
    if len(columns):
        identity = ["name", "logged_unit", "quantity", "unit"]
        columns_over_runs = columns.groupby(identity, sort=False, as_index=False).agg(
            {"minimum": "min", "maximum": "max", "count": "sum", "missing": "sum"}
        )
        for bound in ("minimum", "maximum"):
            columns_over_runs[bound] = [
                "-" if pd.isna(value) else f"{value:.5g}" for value in columns_over_runs[bound]
            ]
        rows = columns_over_runs.astype(str).to_numpy().tolist()
        yield from text_table([_COLUMN_HEADS, *rows], right_aligned_count=4, indent="  ")
    all_unused = chain.from_iterable(run_report["unused_columns"] for run_report in run_reports)
    unused_names = dict.fromkeys(all_unused)
    if unused_names:
        yield from _wrapped_lines(f"Not read: {', '.join(map(printable, unused_names))}", "  ")


def _condition_lines(log_report: JsonObject) -> Iterator[str]:
    """Operating conditions and traction over all runs of a log."""
    run_reports = log_report["runs"]
    title = "Plateaus" if len(run_reports) == 1 else f"Plateaus of {len(run_reports)} runs"
    rows = [[title, "Measured", "Set point"]]
    for column in run_reports[0]["measured"]:
        measured_bounds: list[float] = []
        for run_report in run_reports:
            measured_bounds += run_report["measured"][column].values()
        set_points = [run_report["set_points"].get(column) for run_report in run_reports]
        rows.append([column, _range_text(measured_bounds), _set_point_cell(set_points)])
    yield ""
    yield from text_table(rows, right_aligned_count=2, indent="  ")


def _set_point_cell(set_points: Sequence[JsonObject | None]) -> str:
    """Range of one set point over runs, with its sources."""
    known_set_points = [set_point for set_point in set_points if set_point is not None]
    if not known_set_points:
        return "-"
    sources = sorted({set_point["source"] for set_point in known_set_points})
    values = [set_point["value"] for set_point in known_set_points]
    return f"{_range_text(values)} ({', '.join(sources)})"


def _range_text(values: Sequence[float]) -> str:
    """The range of some numbers; small numbers have four decimals."""
    sorted_values = sorted(value for value in values if not isnan(value))
    if not sorted_values:
        return "-"
    # z: no minus before a zero
    number_format = "z.4f" if max(map(abs, sorted_values)) < 10 else ".4g"
    lowest = format(sorted_values[0], number_format)
    highest = format(sorted_values[-1], number_format)
    return lowest if lowest == highest else f"{lowest}..{highest}"


def _lines_on_unapplied_gates(run_reports: Sequence[JsonObject]) -> Iterator[str]:
    """The gates that could not be applied to some or all runs, by what they lack."""
    all_unapplied = chain.from_iterable(
        run_report["gates_not_applied"] for run_report in run_reports
    )
    unapplied_gates = pd.DataFrame(all_unapplied)
    if len(unapplied_gates):
        yield ""
        yield "  Gates that could not be applied"
        for reason, gate_names in unapplied_gates.drop_duplicates().groupby("reason", sort=False)[
            "gate"
        ]:
            yield from _wrapped_lines(f"{', '.join(gate_names)}: {reason}", "    ")
