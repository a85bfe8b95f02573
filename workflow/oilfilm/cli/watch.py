"""The command `oilfilm watch`: the verdict on every log as soon as it is finished.

Nothing is stored. A new watch begins again with the files.

Decides: when a log that is being written is finished.
"""

import argparse
import math
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from oilfilm.api.folders import config_folder, project_folder
from oilfilm.api.log_check import reports_on_logs_of_kind, rig_class_by_folder, verdict_lines
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.curation.rig_kind import RigKind
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import log_names_and_faults
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# A network drive may report no changes, so the folders are read again after this pause.
_PAUSE_S = 1.0


class FileState(NamedTuple):
    """State of a file: its size in bytes, and the time of its last change in ns."""

    size: int
    changed_ns: int


def run(options: argparse.Namespace) -> int:
    """Watch until interrupted, which ends with the exit code 130.

    Raises:
        OilfilmError: The current folder is no project, and none is named; or no log would ever be
            finished.
    """
    if not 0 <= options.settle < math.inf:
        raise OilfilmError(
            f"--settle: found {options.settle:g}; expected 0 seconds or more, as --settle 3."
        )
    if options.config is None and not Path("config/config.yaml").is_file():
        raise OilfilmError(
            "config/config.yaml: there is no such file, so the logs to be watched are not known. "
            "Go to the folder of the project, or name its configuration folder with --config. "
            "`oilfilm init FOLDER LOG...` makes a project."
        )
    settings_folder = config_folder(options.config)
    raw_folder = project_folder(options.config) / "data/raw"
    settings = resolve(settings_folder, {"campaign": options.campaign} if options.campaign else {})
    watcher = Watcher(settings, raw_folder, options.settle)
    folders_in_words = " and ".join(map(str, watcher.rig_class_of_folder))
    _print(f"Watching {folders_in_words}. Stop with Ctrl-C: nothing is lost.")
    while True:
        # one verdict per look: a log that has just been finished does not wait for old ones
        verdict = next(watcher.look(), None)
        if verdict is None:
            time.sleep(_PAUSE_S)
        else:
            _print(f"{datetime.now():%H:%M:%S} {verdict}")


def _print(text: str) -> None:
    """Print lines without buffering, with control characters escaped."""
    print("\n".join(map(printable, text.split("\n"))), flush=True)


class Watcher:
    """The logs of a campaign's folders; each gets its verdict once it is finished.

    Args:
        settings: The settings of the campaign.
        raw_folder: The folder `data/raw` with the campaigns' folders.
        settle_s: A file is finished when it has not changed for so many seconds.
    """

    def __init__(self, settings: Settings, raw_folder: Path, settle_s: float) -> None:
        self._settings = settings
        self._raw_folder = raw_folder
        self._settle_s = settle_s
        self.rig_class_of_folder = {
            raw_folder / name: rig_class
            for name, rig_class in rig_class_by_folder(settings).items()
        }
        # the last state of each file, and when it was first seen, in s of the monotonic clock
        self._state_and_time_seen: dict[Path, tuple[FileState, float]] = {}
        # what each judged log was judged from: its state, and its rows of the run sheet
        self._judged_from: dict[Path, object] = {}
        # the line about each file or folder that could not be judged, when last looked at
        self._last_line_by_path: dict[Path, str] = {}

    def look(self) -> Iterator[str]:
        """Look at every file and yield each new verdict; the newest logs come first."""
        for folder, rig_class in self.rig_class_of_folder.items():
            try:
                yield from self._look_at(folder, rig_class)
                self._last_line_by_path.pop(folder, None)
            except (OilfilmError, OSError) as error:
                yield from self._line_if_changed(folder, f"{error} No log in {folder} is judged.")

    def _look_at(self, folder: Path, rig_class: type[RigKind]) -> Iterator[str]:
        """Look at every file of one folder and yield each new verdict."""
        fault_by_path = {folder / name: fault for name, fault in log_names_and_faults(folder)}
        state_by_path: dict[Path, FileState] = {}
        for path in fault_by_path:
            if path.exists():
                status = path.stat()
                state_by_path[path] = FileState(status.st_size, status.st_mtime_ns)
        # every file is looked at: the time of a changed one begins now
        finished_paths = [
            path for path, state in state_by_path.items() if self._is_finished(path, state)
        ]
        finished_paths.sort(key=lambda path: state_by_path[path].changed_ns, reverse=True)
        paths_without_fault = [path for path in state_by_path if not fault_by_path[path]]
        run_sheet = sheet_of_paths(
            paths_without_fault, self._raw_folder, self._settings, rig_class.log_schema
        )
        for path in finished_paths:
            judged_from = state_by_path[path], run_sheet.rows_of_log.get(str(path))
            if self._judged_from.get(path) == judged_from:
                continue
            try:
                if fault_by_path[path]:
                    verdict = f"{path}: REFUSED\n  {fault_by_path[path]}"
                else:
                    verdict = self._verdict(path, rig_class, run_sheet)
                self._judged_from[path] = judged_from
                self._last_line_by_path.pop(path, None)
                yield verdict
            except Exception as error:  # one log must not end the watch
                # tried again: on Windows the program of the rig may hold the file
                reason = error if isinstance(error, OilfilmError) else repr(error)
                yield from self._line_if_changed(path, f"{path}: NOT JUDGED: {reason}")

    def _verdict(self, path: Path, rig_class: type[RigKind], run_sheet: RunSheet) -> str:
        """The verdict on a log, as text."""
        logs = [(str(path), read_bytes(path))]
        (log_report,) = reports_on_logs_of_kind(logs, self._settings, rig_class, run_sheet)
        return "\n".join(verdict_lines(log_report))

    def _line_if_changed(self, path: Path, line: str) -> Iterator[str]:
        """A line about a file or folder that cannot be judged, unless it was the same before."""
        if self._last_line_by_path.get(path) != line:
            self._last_line_by_path[path] = line
            yield line

    def _is_finished(self, path: Path, state: FileState) -> bool:
        """Whether a file has been seen unchanged for long enough, by this computer's own clock."""
        now_s = time.monotonic()
        last_state, first_seen_s = self._state_and_time_seen.get(path, (None, now_s))
        if last_state != state:
            self._state_and_time_seen[path] = (state, now_s)
            first_seen_s = now_s
        return now_s - first_seen_s >= self._settle_s
