"""The command `oilfilm watch`: the verdict on every log as soon as it is finished.

Nothing is stored: a new watch finds everything again from the files.

Decides: when a log that is being written is finished.
"""

import argparse
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from oilfilm.cli.arguments import config_folder, project_folder
from oilfilm.cli.check import judged_logs
from oilfilm.cli.checked import CheckedLog, Problem
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import find_sheet, named_logs
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# A network drive may report no changes, so the folders are looked at again and again.
_PAUSE_S = 1.0
# Then new files are looked for, however many old logs are still to be judged.
_LONGEST_LOOK_S = 2.0
Stamp = tuple[int, int]


def run(options: argparse.Namespace) -> int:
    """Watch until interrupted, which ends with the exit code 130."""
    config, raw = config_folder(options.config), project_folder(options.config) / "data/raw"
    overrides = {"campaign": options.campaign} if options.campaign else {}
    stamps = _stamps(config)
    watcher = Watcher(resolve(config, overrides), raw, options.settle)
    _say(f"Watching {' and '.join(map(str, watcher.folders))}. Stop with Ctrl-C: nothing is lost.")
    while True:
        if (now := _stamps(config)) != stamps:
            stamps = now
            try:
                settings = resolve(config, overrides)
                if settings != watcher.settings:
                    _say("The settings have changed. All logs are judged again.")
                    watcher = Watcher(settings, raw, options.settle)
            except (OilfilmError, OSError) as error:
                _say(f"{error} Until then the previous settings apply.")
        for line in watcher.look():
            _say(f"{datetime.now():%H:%M:%S} {line}")
        time.sleep(_PAUSE_S)


def _say(text: str) -> None:
    """Print lines at once, safe for a terminal."""
    print("\n".join(map(printable, text.split("\n"))), flush=True)


def _stamps(config: Path) -> dict[Path, Stamp]:
    """Size and date of every file of the configuration."""
    return {path: _stamp(path) for path in config.rglob("*.yaml") if path.is_file()}


def _stamp(path: Path) -> Stamp:
    status = path.stat()
    return status.st_size, status.st_mtime_ns


class _Log(NamedTuple):
    """A log that is finished; `fault` says why its name cannot be used, if so."""

    name: str
    path: Path
    stamp: Stamp
    kind: RigKind
    sheet: RunSheet
    fault: str

    @property
    def state(self) -> object:
        """A verdict holds as long as this does not change."""
        return self.stamp, self.sheet.rows.get(str(self.path))


class Watcher:
    """The logs of a campaign's folders, each of which gets its verdict once it is finished.

    Args:
        settings: Settings of the campaign.
        raw: The folder of the campaigns' folders, `data/raw`.
        settle_s: A file that has not changed for so many seconds is finished.
    """

    def __init__(self, settings: Settings, raw: Path, settle_s: float) -> None:
        self.settings = settings
        name = settings.campaign.name
        self.folders: dict[Path, RigKind] = {raw / name: TRACTION_RIG}
        if settings.campaign.torque is not None:
            self.folders[raw / f"{name}-torque"] = TORQUE_RIG
        self._raw, self._settle_s = raw, settle_s
        self._seen: dict[Path, tuple[Stamp, float]] = {}
        self._judged: dict[Path, object] = {}
        self._said: dict[Path, str] = {}
        self._sheets: dict[Path, tuple[object, RunSheet]] = {}

    def look(self) -> Iterator[str]:
        """Look at every file and yield each new verdict; the newest logs come first."""
        began = time.monotonic()
        finished: list[_Log] = []
        for folder, kind in self.folders.items():
            try:
                finished += self._finished(folder, kind, began)
                self._said.pop(folder, None)
            except (OilfilmError, OSError) as error:
                yield from self._once(folder, f"{_sentence(error, folder)} No log there is judged.")
        due = [log for log in finished if self._judged.get(log.path) != log.state]
        for log in sorted(due, key=lambda log: log.stamp[1], reverse=True):
            try:
                line = self._verdict(log)
                self._judged[log.path] = log.state
                yield f"{log.name}: {line}"
            except FileNotFoundError:  # deleted a moment ago
                continue
            except (OilfilmError, OSError) as error:
                # tried again: on Windows the program of the rig may hold the file
                yield from self._once(log.path, f"{log.name}: {_sentence(error, log.path)}")
            if time.monotonic() - began > _LONGEST_LOOK_S:
                break

    def _once(self, path: Path, line: str) -> Iterator[str]:
        if self._said.get(path) != line:
            self._said[path] = line
            yield line

    def _finished(self, folder: Path, kind: RigKind, now: float) -> list[_Log]:
        """The logs of a folder that are finished; none while its run sheet is being written."""
        faults = {folder / name: fault for name, fault in named_logs(folder)}
        stamps = {path: _stamp(path) for path in faults if path.exists()}
        settled = {path for path, stamp in stamps.items() if self._settled(path, stamp, now)}
        for path in self._judged.keys() - stamps.keys():
            if path.is_relative_to(folder):
                del self._judged[path]
        sheet_path = find_sheet(folder)
        sheet_stamp = _stamp(sheet_path) if sheet_path else None
        if sheet_path and sheet_stamp and not self._settled(sheet_path, sheet_stamp, now):
            return []
        paths = [path for path in stamps if not faults[path]]
        if self._sheets.get(folder, (None,))[0] != (sheet_stamp, paths):
            sheet = sheet_of_paths(paths, self._raw, self.settings, kind.logs)
            self._sheets[folder] = (sheet_stamp, paths), sheet
        sheet = self._sheets[folder][1]
        return [
            _Log(path.relative_to(self._raw).as_posix(), path, stamps[path], kind, sheet, fault)
            for path, fault in faults.items()
            if path in settled
        ]

    def _settled(self, path: Path, stamp: Stamp, now: float) -> bool:
        """Whether a file has been seen unchanged for long enough, by this computer's own clock."""
        seen, since = self._seen.get(path, (None, now))
        if seen != stamp:
            self._seen[path], since = (stamp, now), now
        return now - since >= self._settle_s

    def _verdict(self, log: _Log) -> str:
        """The verdict on a log in one line."""
        if log.fault:
            return f"REFUSED; {log.fault}"
        try:
            content = read_bytes(log.path)
            (checked,) = judged_logs([(str(log.path), content)], self.settings, log.kind, log.sheet)
        except (OilfilmError, OSError):
            raise
        except Exception as error:  # one log must not end the watch
            return (
                f"NOT JUDGED; a defect of oilfilm: {type(error).__name__}: {error} -> Run `oilfilm "
                "check` on it, and report what is printed."
            )
        return _line(checked)


def _line(checked: CheckedLog) -> str:
    """Verdict, count of plateaus and problems; only the first one of a log that is refused."""
    runs = checked.runs
    good = sum(run.accepted_plateaus for run in runs)
    plateaus = f"{good} of {sum(run.plateaus for run in runs)} plateaus"
    if len(runs) > 1:
        plateaus += f" in {sum(run.verdict == 'accepted' for run in runs)} of {len(runs)} runs"
    problems = list(checked.problems)
    shown = problems if checked.verdict == "accepted" else problems[:1]
    more = f" (and {len(problems) - len(shown)} more)" if len(problems) > len(shown) else ""
    found = [_with_advice(problem, checked) for problem in shown]
    return "; ".join([f"{checked.verdict.upper()}, {plateaus}", *found]) + more


def _with_advice(problem: Problem, checked: CheckedLog) -> str:
    run = problem.run_id.removeprefix(checked.file).strip(":") if len(checked.runs) > 1 else ""
    found = f"{run}: {problem.found}" if run else problem.found
    return f"{found} -> {problem.advice}" if problem.advice else found


def _sentence(error: Exception, path: Path) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or path}: {error.strerror or error}."
    return str(error)
