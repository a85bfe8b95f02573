"""The command `oilfilm watch`: the verdict on every log as soon as it is finished.

Nothing is stored: a new watch finds everything again from the files.

Decides: when a log that is being written is finished.
"""

import argparse
import time
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path

from oilfilm.cli.arguments import config_folder, project_folder
from oilfilm.cli.check import Plain, judged_logs, kinds_of_folders, problems
from oilfilm.curation.rig_kind import RigKind
from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import find_sheet, named_logs
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# A network drive may report no changes, so the folders are looked at again and again.
_PAUSE_S = 1.0
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
    """Print lines at once, safe for a terminal."""
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
                yield from self._once(folder, f"{_sentence(error, folder)} No log there is judged.")

    def _look_at(self, folder: Path, kind: type[RigKind]) -> Iterator[str]:
        faults = {folder / name: fault for name, fault in named_logs(folder)}
        of_sheet = _stamps(path for path in [find_sheet(folder)] if path)
        stamps = _stamps(faults)
        # every file is looked at: one that has changed settles from now on
        every = {**of_sheet, **stamps}
        settled = {path for path, stamp in every.items() if self._settled(path, stamp)}
        if not settled >= of_sheet.keys():
            return
        paths = [path for path in stamps if not faults[path]]
        sheet = sheet_of_paths(paths, self._raw, self._settings, kind.logs)
        for path in sorted(stamps, key=lambda path: stamps[path][1], reverse=True):
            state = stamps[path], sheet.rows.get(str(path))
            if path not in settled or self._judged.get(path) == state:
                continue
            name = path.relative_to(self._raw).as_posix()
            try:
                verdict = f"REFUSED; {faults[path]}"
                if not faults[path]:
                    log = [(str(path), read_bytes(path))]
                    verdict = _line(*judged_logs(log, self._settings, kind, sheet))
                self._judged[path] = state
                yield f"{name}: {verdict}"
            except Exception as error:  # one log must not end the watch
                # tried again: on Windows the program of the rig may hold the file
                yield from self._once(path, f"{name}: {_sentence(error, path)}")

    def _once(self, path: Path, line: str) -> Iterator[str]:
        if self._said.get(path) != line:
            self._said[path] = line
            yield line

    def _settled(self, path: Path, stamp: Stamp) -> bool:
        """Whether a file has been seen unchanged for long enough, by this computer's own clock."""
        now = time.monotonic()
        if self._seen.get(path, (None,))[0] != stamp:
            self._seen[path] = (stamp, now)
        return now - self._seen[path][1] >= self._settle_s


def _stamps(paths: Iterable[Path]) -> dict[Path, Stamp]:
    """Size and date of each file that is there."""
    found = {path: path.stat() for path in paths if path.exists()}
    return {path: (status.st_size, status.st_mtime_ns) for path, status in found.items()}


def _line(log: Plain) -> str:
    """Verdict, count of plateaus and problems; only the first one of a log that is refused."""
    runs = log["runs"]
    good, plateaus = (sum(run[key] for run in runs) for key in ("accepted_plateaus", "plateaus"))
    verdict = f"{log['verdict'].upper()}, {good} of {plateaus} plateaus"
    if len(runs) > 1:
        verdict += f" in {sum(run['verdict'] == 'accepted' for run in runs)} of {len(runs)} runs"
    found = []
    for problem in problems(log):
        run = problem.run_id.removeprefix(log["file"]).strip(":") if len(runs) > 1 else ""
        advice = f" -> {problem.advice}" if problem.advice else ""
        found.append(f"{run}: {problem.found}{advice}".removeprefix(": "))
    shown = found if log["verdict"] == "accepted" else found[:1]
    more = f" (and {len(found) - len(shown)} more)" if len(found) > len(shown) else ""
    return "; ".join([verdict, *shown]) + more


def _sentence(error: Exception, path: Path) -> str:
    if isinstance(error, OSError):
        return f"{error.filename or path}: {error.strerror or error}."
    if isinstance(error, OilfilmError):
        return str(error)
    return f"NOT JUDGED; a defect of oilfilm: {type(error).__name__}: {error}"
