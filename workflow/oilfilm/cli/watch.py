"""The command `oilfilm watch`: the verdict on every log as soon as it is finished.

Nothing is stored: a new watch finds everything again from the files.

Decides: when a log that is being written is finished.
"""

import argparse
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

from oilfilm.cli.arguments import config_folder, project_folder
from oilfilm.cli.check import judged_logs, kinds_of_folders, verdict_lines
from oilfilm.curation.rig_kind import RigKind
from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import named_logs
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# A network drive may report no changes, so the folders are looked at again and again.
_PAUSE_S = 1.0
# Size of a file in bytes, and the time of its last change in ns.
Stamp = tuple[int, int]


def run(options: argparse.Namespace) -> int:
    """Watch until interrupted, which ends with the exit code 130."""
    config, raw = config_folder(options.config), project_folder(options.config) / "data/raw"
    settings = resolve(config, {"campaign": options.campaign} if options.campaign else {})
    watcher = Watcher(settings, raw, options.settle)
    _say(f"Watching {' and '.join(map(str, watcher.folders))}. Stop with Ctrl-C: nothing is lost.")
    while True:
        # one verdict per look: a log that has just been finished does not wait for old ones
        if (verdict := next(watcher.look(), None)) is None:
            time.sleep(_PAUSE_S)
        else:
            _say(f"{datetime.now():%H:%M:%S} {verdict}")


def _say(text: str) -> None:
    """Print lines at once, with control characters escaped."""
    print("\n".join(map(printable, text.split("\n"))), flush=True)


class Watcher:
    """The logs of a campaign's folders, each of which gets its verdict once it is finished.

    Args:
        settings: The settings of the campaign.
        raw: The folder of the campaigns' folders, `data/raw`.
        settle_s: A file that has not changed for so many seconds is finished.
    """

    def __init__(self, settings: Settings, raw: Path, settle_s: float) -> None:
        self._settings, self._raw, self._settle_s = settings, raw, settle_s
        self.folders = {raw / name: kind for name, kind in kinds_of_folders(settings).items()}
        self._seen: dict[Path, tuple[Stamp, float]] = {}
        self._judged: dict[Path, object] = {}
        self._said: dict[Path, str] = {}

    def look(self) -> Iterator[str]:
        """Look at every file and yield each new verdict; the newest logs come first."""
        for folder, kind in self.folders.items():
            try:
                yield from self._look_at(folder, kind)
                self._said.pop(folder, None)
            except (OilfilmError, OSError) as error:
                yield from self._once(folder, f"{error} No log in {folder} is judged.")

    def _look_at(self, folder: Path, kind: type[RigKind]) -> Iterator[str]:
        faults = {folder / name: fault for name, fault in named_logs(folder)}
        found = {path: path.stat() for path in faults if path.exists()}
        stamps = {path: (each.st_size, each.st_mtime_ns) for path, each in found.items()}
        # every file is looked at: one that has changed settles from now on
        settled = [path for path, stamp in stamps.items() if self._settled(path, stamp)]
        sound = [path for path in stamps if not faults[path]]
        sheet = sheet_of_paths(sound, self._raw, self._settings, kind.logs)
        for path in sorted(settled, key=lambda path: stamps[path][1], reverse=True):
            state = stamps[path], sheet.rows.get(str(path))
            if self._judged.get(path) == state:
                continue
            try:
                verdict = f"{path}: REFUSED\n  {faults[path]}"
                if not faults[path]:
                    content = [(str(path), read_bytes(path))]
                    (log,) = judged_logs(content, self._settings, kind, sheet)
                    verdict = "\n".join(verdict_lines(log))
                self._judged[path] = state
                yield verdict
            except Exception as error:  # one log must not end the watch
                # tried again: on Windows the program of the rig may hold the file
                why = error if isinstance(error, OilfilmError) else repr(error)
                yield from self._once(path, f"{path}: NOT JUDGED: {why}")

    def _once(self, path: Path, line: str) -> Iterator[str]:
        """A line about a file or folder, unless it is the last one that was said of it."""
        if self._said.get(path) != line:
            self._said[path] = line
            yield line

    def _settled(self, path: Path, stamp: Stamp) -> bool:
        """Whether a file has been seen unchanged for long enough, by this computer's own clock."""
        now = time.monotonic()
        if self._seen.get(path, (None,))[0] != stamp:
            self._seen[path] = (stamp, now)
        return now - self._seen[path][1] >= self._settle_s
