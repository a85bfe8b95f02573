"""sha256 of the raw logs, which is a parameter of the jobs that read them.

A log is read for its digest only if its state in the file system is not the one that the last run
has kept. The state has the time of change (`st_ctime`). Each change of a file sets it to now, and
no copy sets it back: neither `cp -p` nor `rsync -a` nor a restored backup.

Decides: when a raw log is read to see whether it has changed.
"""

import json
import time
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.digests import file_digest

# A file system counts its times in steps of up to 2 s (FAT): within one, a second change of a log
# leaves the state as it is.
_COARSEST_CLOCK_NS = 2_000_000_000
# Size in bytes, time of writing and of change in ns since 1970, number of the file.
State = tuple[int, int, int, int]


class LogDigests:
    """The digests of the logs of a campaign.

    Args:
        record: Where a run keeps states and digests for the next one.
    """

    def __init__(self, record: Path) -> None:
        self._record = record
        self._of_this_run: dict[str, tuple[State, str]] = {}

    def of(self, folder: Path, names: Iterable[str]) -> dict[str, str]:
        """sha256 of logs by name; empty for one that cannot be read, which its job says.

        Args:
            folder: Of the logs.
            names: Their names below the folder.
        """
        return {name: self._digest(folder / name) for name in names}

    def keep(self) -> None:
        """Write down the states that were found, for the next run.

        Raises:
            OSError: The record cannot be written.
        """
        write_text(json.dumps(self._of_this_run), self._record)

    @cached_property
    def _of_last_run(self) -> dict[str, tuple[State, str]]:
        if not self._record.is_file():
            return {}
        kept = json.loads(self._record.read_text(encoding="utf-8"))
        return {path: (tuple(state), digest) for path, (state, digest) in kept.items()}

    def _digest(self, path: Path) -> str:
        name, now = path.as_posix(), time.time_ns()
        known = self._of_this_run.get(name) or self._of_last_run.get(name)
        try:
            status = path.stat()
            state = status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino
            digest = known[1] if known and known[0] == state else file_digest(path)
        except OSError:
            return ""
        if status.st_ctime_ns < now - _COARSEST_CLOCK_NS:
            self._of_this_run[name] = state, digest
        return digest
