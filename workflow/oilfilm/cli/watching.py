"""Verdicts on the logs of a campaign while it is measured, by the size and date of each file.

Nothing is stored: a new `Watcher` finds everything again from the files.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from oilfilm.cli.check import check_logs
from oilfilm.cli.checked import CheckedLog, CheckedRun
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.base import SET_POINTS
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import find_sheet, named_logs
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.settings.resolved import Settings

Stamp = tuple[int, int]
# Then new files are looked for, however many old logs are still to be judged.
_LONGEST_LOOK_S = 2.0
_COLUMNS = {
    "log": str,
    "oil": str,
    "rig": str,
    "verdict": str,
    "accepted_points": int,
    "plateaus": int,
    **{f"nominal_{name}": float for name in SET_POINTS},
}


@dataclass(frozen=True)
class Problem:
    """What was found in a log that was refused or is doubtful, and what to do."""

    found: str
    advice: str = ""

    def __str__(self) -> str:
        return f"{self.found} -> {self.advice}" if self.advice else self.found


@dataclass(frozen=True)
class Verdict:
    """What is shown of a log.

    Attributes:
        log: Its path below `data/raw`.
        changed: When it was last written, in seconds since 1970.
        verdict: As `oilfilm check` gives it; `not judged` where that was not possible.
        plateaus: How many plateaus were accepted.
        problems: Reasons with advice, those of refusals first.
        runs: Its traction runs with their set points.
    """

    log: str
    changed: float
    verdict: Literal["accepted", "refused", "not judged"]
    plateaus: str
    problems: tuple[Problem, ...]
    runs: tuple[dict[str, Any], ...] = ()

    def __str__(self) -> str:
        """The verdict in one line."""
        problems = self.problems if self.verdict == "accepted" else self.problems[:1]
        found = ", ".join(filter(None, [self.verdict.upper(), self.plateaus]))
        more = len(self.problems) - len(problems)
        rest = f" (and {more} more)" if more else ""
        return printable("; ".join([f"{self.log}: {found}", *map(str, problems)]) + rest)


@dataclass(frozen=True)
class _Log:
    """A log as it is now; `fault` says why it cannot be used, if so."""

    path: Path
    name: str
    kind: RigKind
    stamp: Stamp
    fault: str


class Watcher:
    """The logs of a campaign's folders, each with its verdict once it is finished.

    Attributes:
        settings: Settings of the campaign.
        folders: Its folders of raw logs.
        verdicts: By path.
        writing: Logs that have changed a moment ago.
        notes: What hinders: a folder or a run sheet that cannot be read.
        waiting: Whether something is unfinished, so that the next look should come soon.
    """

    def __init__(self, settings: Settings, raw: Path, settle_s: float) -> None:
        """Watch the folders of a campaign.

        Args:
            settings: Settings of the campaign.
            raw: The folder of the campaigns' folders, `data/raw`.
            settle_s: A log that has not changed for so many seconds is finished.
        """
        self.settings = settings
        name = settings.campaign.name
        self.folders: dict[Path, RigKind] = {raw / name: TRACTION_RIG}
        if settings.campaign.torque is not None:
            self.folders[raw / f"{name}-torque"] = TORQUE_RIG
        self.verdicts: dict[Path, Verdict] = {}
        self.writing: list[str] = []
        self.notes: list[str] = []
        self.waiting = True
        self._raw, self._settle_s = raw, settle_s
        self._seen: dict[Path, tuple[Stamp, float]] = {}
        self._judged: dict[Path, tuple[Stamp, Any]] = {}
        self._sheets: dict[Path, tuple[Any, RunSheet]] = {}

    def look(self) -> Iterator[Verdict]:
        """Look at every file and yield each new verdict; the newest logs come first."""
        began = time.monotonic()
        self.notes, self.writing, self.waiting = [], [], False
        logs = [log for folder, kind in self.folders.items() for log in self._logs(folder, kind)]
        present = {log.path for log in logs}
        for known in (self.verdicts, self._judged):
            for path in known.keys() - present:
                del known[path]
        sheets = {folder: self._sheet(folder, logs, began) for folder in self.folders}
        ripe = []
        for log in logs:
            sheet = sheets[self._raw / log.name.partition("/")[0]]
            rows = sheet.rows.get(str(log.path)) if sheet else None
            judged_stamp, judged_rows = self._judged.get(log.path, (None, None))
            if judged_stamp == log.stamp and (sheet is None or judged_rows == rows):
                continue
            self.waiting = True
            if judged_stamp not in (None, log.stamp):
                self.verdicts.pop(log.path, None)
            if not self._settled(log.path, log.stamp, began):
                self.writing.append(log.name)
            elif sheet is not None:
                ripe.append((log, sheet, rows))
        ripe.sort(key=lambda each: each[0].stamp[1], reverse=True)
        for log, sheet, rows in ripe:
            verdict = self._judge(log, sheet)
            if verdict is None:
                self.writing.append(log.name)
                continue
            if verdict.verdict != "not judged":
                self._judged[log.path] = log.stamp, rows
            if self.verdicts.get(log.path) != verdict:
                self.verdicts[log.path] = verdict
                yield verdict
            if time.monotonic() - began > _LONGEST_LOOK_S:
                break

    def runs(self) -> pd.DataFrame:
        """The traction runs of all judged logs, as `coverage` takes them, with their `log`."""
        rows = [run for verdict in self.newest_first() for run in verdict.runs]
        return pd.DataFrame(rows, columns=list(_COLUMNS)).astype(_COLUMNS)

    def newest_first(self) -> list[Verdict]:
        """All verdicts; the log that was written last comes first."""
        return sorted(self.verdicts.values(), key=lambda each: (-each.changed, each.log))

    def _logs(self, folder: Path, kind: RigKind) -> Iterator[_Log]:
        try:
            for name, fault in named_logs(folder):
                try:
                    stamp = _stamp(folder / name)
                except FileNotFoundError:  # deleted a moment ago
                    continue
                yield _Log(folder / name, f"{folder.name}/{name}", kind, stamp, fault)
        except (OilfilmError, OSError) as error:
            self.notes.append(_sentence(error, folder))

    def _sheet(self, folder: Path, logs: list[_Log], now: float) -> RunSheet | None:
        """What the run sheet says of the logs of a folder; None while it cannot be read."""
        paths = [log.path for log in logs if log.path.is_relative_to(folder) and not log.fault]
        try:
            path = find_sheet(folder)
            stamp = _stamp(path) if path else None
            if path and stamp and not self._settled(path, stamp, now):
                self.waiting = True
                return None
            key = stamp, paths
            known, sheet = self._sheets.get(folder, (None, None))
            if sheet is None or known != key:
                kind = self.folders[folder].logs
                sheet = sheet_of_paths(paths, self._raw, self.settings, kind)
                self._sheets[folder] = key, sheet
            return sheet
        except (OilfilmError, OSError) as error:
            self.notes.append(f"{_sentence(error, folder)} Until then no log there is judged.")
            return None

    def _settled(self, path: Path, stamp: Stamp, now: float) -> bool:
        """Whether a file has been seen unchanged for long enough, by this computer's own clock."""
        seen, since = self._seen.get(path, (None, now))
        if seen != stamp:
            self._seen[path], since = (stamp, now), now
        return now - since >= self._settle_s

    def _judge(self, log: _Log, sheet: RunSheet) -> Verdict | None:
        """The verdict on a finished log; None where it has changed while it was read."""
        changed = log.stamp[1] / 1e9
        if log.fault:
            return Verdict(log.name, changed, "refused", "", (Problem(log.fault),))
        file = str(log.path)
        try:
            content = read_bytes(log.path)
            if _stamp(log.path) != log.stamp:
                return None
            (checked,) = check_logs([(file, content)], self.settings, log.kind, sheet)
        except FileNotFoundError:
            return None
        except (OilfilmError, OSError) as error:
            return Verdict(log.name, changed, "not judged", "", (Problem(_sentence(error, file)),))
        except Exception as error:  # one log must not end the watch
            found = f"a defect of oilfilm: {type(error).__name__}: {error}"
            advice = "Run `oilfilm check` on it, and report what is printed."
            return Verdict(log.name, changed, "refused", "", (Problem(found, advice),))
        return _verdict(checked, log, changed)


def _stamp(path: Path) -> Stamp:
    status = path.stat()
    return status.st_size, status.st_mtime_ns


def _sentence(error: Exception, named: object) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or named}: {error.strerror or error}."
    return str(error)


def _verdict(checked: CheckedLog, log: _Log, changed: float) -> Verdict:
    accepted = sum(run.accepted_plateaus for run in checked.runs)
    plateaus = f"{accepted} of {sum(run.plateaus for run in checked.runs)} plateaus"
    if len(checked.runs) > 1:
        good = sum(run.verdict == "accepted" for run in checked.runs)
        plateaus += f" in {good} of {len(checked.runs)} runs"
    runs = checked.runs if log.kind is TRACTION_RIG else []
    return Verdict(
        log.name,
        changed,
        checked.verdict,
        plateaus,
        tuple(_problems(checked)),
        tuple(_run(run, log.name) for run in runs),
    )


def _problems(checked: CheckedLog) -> Iterator[Problem]:
    several = len(checked.runs) > 1

    def about(run_id: str) -> str:
        part = run_id.removeprefix(checked.file).strip(":")
        return f"{part}: " if several and part else ""

    for refused in checked.refusals:
        found = f"{about(refused.run_id)}{refused.rule}: {refused.reason}"
        yield Problem(found, refused.advice)
    explained = {(refused.run_id, refused.rule) for refused in checked.refusals}
    for run in checked.runs:
        if run.warning:
            yield Problem(f"{about(run.run_id)}warning: {run.warning}")
        for gate in run.failed_gates:
            if (run.run_id, gate.gate) not in explained:
                found = f"{gate.gate}: {gate.plateaus} plateaus, first at row {gate.first_row}"
                yield Problem(f"{about(run.run_id)}{found}", gate.advice)
    if checked.without_row:
        yield Problem(*checked.without_row)


def _run(run: CheckedRun, log: str) -> dict[str, Any]:
    points = {name: run.set_points.get(name) for name in SET_POINTS}
    return {
        "log": log,
        "oil": run.oil,
        "rig": run.rig,
        "verdict": run.verdict,
        "accepted_points": run.accepted_plateaus,
        "plateaus": run.plateaus,
        **{f"nominal_{name}": point.value if point else None for name, point in points.items()},
    }
