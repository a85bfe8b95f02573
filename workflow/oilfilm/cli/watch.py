"""The command `oilfilm watch`: the verdict on every log as soon as it is finished.

Nothing is stored. A new watch begins again with the files.

Decides: when a log that is being written is finished.
"""

import argparse
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from oilfilm.api.folders import config_folder, project_folder
from oilfilm.api.log_check import judged_logs, kinds_of_folders, verdict_lines
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.curation.rig_kind import RigKind
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import named_logs
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# A network drive may report no changes, so the folders are read again after this pause.
_PAUSE_S = 1.0


class Stamp(NamedTuple):
    """State of a file: its size in bytes, and the time of its last change in ns."""

    size: int
    changed_ns: int


def run(options: argparse.Namespace) -> int:
    """Watch until interrupted, which ends with the exit code 130.

    Raises:
        OilfilmError: The current folder is no project, and none is named.
    """
    if options.config is None and not Path("config/config.yaml").is_file():
        raise OilfilmError(
            "config/config.yaml: there is no such file, so the logs to be watched are not known. "
            "Go to the folder of the project, or name its configuration folder with --config. "
            "`oilfilm init FOLDER LOG...` makes a project."
        )
    config = config_folder(options.config)
    raw = project_folder(options.config) / "data/raw"
    settings = resolve(config, {"campaign": options.campaign} if options.campaign else {})
    watcher = Watcher(settings, raw, options.settle)
    folders = " and ".join(map(str, watcher.folders))
    _print(f"Watching {folders}. Stop with Ctrl-C: nothing is lost.")
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
        raw: The folder `data/raw` with the campaigns' folders.
        settle_s: A file is finished when it has not changed for so many seconds.
    """

    def __init__(self, settings: Settings, raw: Path, settle_s: float) -> None:
        self._settings = settings
        self._raw = raw
        self._settle_s = settle_s
        self.folders = {raw / name: kind for name, kind in kinds_of_folders(settings).items()}
        # the last stamp of each file, and when it was first seen, in s of the monotonic clock
        self._seen: dict[Path, tuple[Stamp, float]] = {}
        # what each judged log was judged from
        self._judged: dict[Path, object] = {}
        # the last line about each file or folder that could not be judged
        self._last_line: dict[Path, str] = {}

    def look(self) -> Iterator[str]:
        """Look at every file and yield each new verdict; the newest logs come first."""
        for folder, kind in self.folders.items():
            try:
                yield from self._look_at(folder, kind)
                self._last_line.pop(folder, None)
            except (OilfilmError, OSError) as error:
                yield from self._once(folder, f"{error} No log in {folder} is judged.")

    def _look_at(self, folder: Path, kind: type[RigKind]) -> Iterator[str]:
        faults = {folder / name: fault for name, fault in named_logs(folder)}
        stamps: dict[Path, Stamp] = {}
        for path in faults:
            if path.exists():
                status = path.stat()
                stamps[path] = Stamp(status.st_size, status.st_mtime_ns)
        # every file is looked at: the time of a changed one begins now
        settled_paths = [path for path, stamp in stamps.items() if self._is_settled(path, stamp)]
        paths_without_fault = [path for path in stamps if not faults[path]]
        sheet = sheet_of_paths(paths_without_fault, self._raw, self._settings, kind.kind_of_logs)
        for path in sorted(settled_paths, key=lambda path: stamps[path].changed_ns, reverse=True):
            judged_from = stamps[path], sheet.rows_of_log.get(str(path))
            if self._judged.get(path) == judged_from:
                continue
            try:
                if faults[path]:
                    verdict = f"{path}: REFUSED\n  {faults[path]}"
                else:
                    verdict = self._verdict(path, kind, sheet)
                self._judged[path] = judged_from
                yield verdict
            except Exception as error:  # one log must not end the watch
                # tried again: on Windows the program of the rig may hold the file
                reason = error if isinstance(error, OilfilmError) else repr(error)
                yield from self._once(path, f"{path}: NOT JUDGED: {reason}")

    def _verdict(self, path: Path, kind: type[RigKind], sheet: RunSheet) -> str:
        logs = [(str(path), read_bytes(path))]
        (log,) = judged_logs(logs, self._settings, kind, sheet)
        return "\n".join(verdict_lines(log))

    def _once(self, path: Path, line: str) -> Iterator[str]:
        """A line about a file or folder, unless it is the last line about it."""
        if self._last_line.get(path) != line:
            self._last_line[path] = line
            yield line

    def _is_settled(self, path: Path, stamp: Stamp) -> bool:
        """Whether a file has been seen unchanged for long enough, by this computer's own clock."""
        now_s = time.monotonic()
        last_stamp, since_s = self._seen.get(path, (None, now_s))
        if last_stamp != stamp:
            self._seen[path] = (stamp, now_s)
            since_s = now_s
        return now_s - since_s >= self._settle_s
