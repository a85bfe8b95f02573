"""The command `oilfilm watch`: a verdict on every finished log, and a page that shows them."""

import argparse
import time
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path

import watchfiles

from oilfilm.atomic_write import write_text
from oilfilm.cli.arguments import config_folder, project_folder
from oilfilm.cli.watch_page import watch_page
from oilfilm.cli.watching import Stamp, Watcher
from oilfilm.errors import OilfilmError, printable
from oilfilm.settings.resolve import resolve

# How long to wait for a change while a log is being written, and else: folders of a network drive
# may report no changes.
_SOON_S, _LATER_S = 1.0, 5.0
# How often the page is written again even if nothing has changed, so that it shows its age.
_HEARTBEAT_S = 10.0


def run(options: argparse.Namespace) -> int:
    """Watch until interrupted, which ends with the exit code 130."""
    config, project = config_folder(options.config), project_folder(options.config)
    overrides = {"campaign": options.campaign} if options.campaign else {}
    stamps = _stamps(config)
    watcher = Watcher(resolve(config, overrides), project / "data" / "raw", options.settle)
    name = watcher.settings.campaign.name
    page = _Page(options.page or project / "results" / name / "watch.html")
    folders = " and ".join(map(str, watcher.folders))
    _say(f"Watching {folders}. The page is {page.path}. Stop with Ctrl-C: nothing is lost.")
    mistake = ""
    try:
        while True:
            if (now := _stamps(config)) != stamps:
                stamps = now
                try:
                    settings, mistake = resolve(config, overrides), ""
                    if settings != watcher.settings:
                        _say("The settings have changed. All logs are judged again.")
                        watcher = Watcher(settings, project / "data" / "raw", options.settle)
                except (OilfilmError, OSError) as error:
                    mistake = f"{error} Until then the settings before count."
            for verdict in watcher.look():
                _say(f"{datetime.now():%H:%M:%S} {verdict}")
            page.show(watcher, mistake)
            _wait(watcher)
    except KeyboardInterrupt:
        page.show(watcher, mistake, stopped=True)
        raise


class _Page:
    """The page, written when what it shows has changed."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._shown: object = None
        self._written = 0.0
        self._said: list[str] = []

    def show(self, watcher: Watcher, mistake: str, *, stopped: bool = False) -> None:
        """Write what the watcher has found; say once what hinders, and go on."""
        notes = [*watcher.notes, *filter(None, [mistake])]
        shown = (list(watcher.verdicts.values()), watcher.writing, notes, stopped)
        troubles = list(notes)
        if shown != self._shown or time.monotonic() - self._written > _HEARTBEAT_S:
            try:
                write_text(watch_page(watcher, notes, datetime.now(), stopped=stopped), self.path)
                self._shown, self._written = shown, time.monotonic()
            except OSError as error:
                troubles.append(f"{self.path}: the page cannot be written ({error.strerror}).")
        for trouble in troubles:
            if trouble not in self._said:
                _say(trouble)
        self._said = troubles


def _say(text: str) -> None:
    """Print lines at once, safe for a terminal."""
    print("\n".join(map(printable, text.split("\n"))), flush=True)


def _stamps(config: Path) -> Mapping[Path, Stamp]:
    """Size and date of every file of the configuration."""
    stamps = {}
    for path in config.rglob("*.yaml"):
        try:
            status = path.stat()
        except OSError:
            continue
        stamps[path] = status.st_size, status.st_mtime_ns
    return stamps


def _wait(watcher: Watcher) -> None:
    """Wait until a file changes, or for a moment."""
    seconds = _SOON_S if watcher.waiting else _LATER_S
    folders = [folder for folder in watcher.folders if folder.is_dir()]
    try:
        if folders:
            changes = watchfiles.watch(
                *folders,
                watch_filter=None,
                debounce=200,
                rust_timeout=int(1000 * seconds),
                yield_on_timeout=True,
            )
            next(changes)
            return
    except (OSError, RuntimeError):  # a drive that reports no changes
        pass
    time.sleep(seconds)
