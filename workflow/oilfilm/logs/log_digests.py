"""sha256 of the raw logs, which is a parameter of the jobs that read them.

A log is read for its digest only if its state in the file system has changed since the last run.
The state contains the time of change (`st_ctime`). Each change of a file sets it to now, and no
copy sets it back: neither `cp -p` nor `rsync -a` nor a restored backup.

Decides: when a raw log is read to see whether it has changed.
"""

import json
import time
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from oilfilm.base.atomic_write import write_text
from oilfilm.base.digests import file_digest

# A file system counts its times in steps of up to 2 s (FAT). A second change of a log within one
# step does not change the state.
_COARSEST_CLOCK_NS = 2_000_000_000
# Size in bytes, time of writing and of change in ns since 1970, number of the file.
FileState = tuple[int, int, int, int]


class _Record(NamedTuple):
    """State of a log in the file system when its digest was computed, and this digest."""

    state: FileState
    digest: str


class LogDigests:
    """The digests of the logs of a campaign.

    Args:
        record_file: File in which a run keeps states and digests for the next one.
    """

    def __init__(self, record_file: Path) -> None:
        self._record_file = record_file
        self._record_of_path_in_this_run: dict[str, _Record] = {}

    def digest_of_name(self, folder: Path, names: Iterable[str]) -> dict[str, str]:
        """sha256 of logs by name; empty for a log that cannot be read, which its job reports.

        Args:
            folder: Folder of the logs.
            names: Names of the logs below the folder.
        """
        return {name: self._digest(folder / name) for name in names}

    def save(self) -> None:
        """Write the states and digests of this run to the file, for the next run.

        Raises:
            OSError: The file cannot be written.
        """
        write_text(json.dumps(self._record_of_path_in_this_run), self._record_file)

    @cached_property
    def _record_of_path_in_last_run(self) -> dict[str, _Record]:
        """Record of each log by its path."""
        if not self._record_file.is_file():
            return {}
        try:
            entries = json.loads(self._record_file.read_bytes())
            return {
                path: _Record(tuple(state), digest) for path, (state, digest) in entries.items()
            }
        except (AttributeError, TypeError, ValueError):
            # the file is damaged: all logs are read again
            return {}

    def _digest(self, path: Path) -> str:
        """sha256 of a log; empty where it cannot be read."""
        path_text = path.as_posix()
        now_ns = time.time_ns()
        record = self._record_of_path_in_this_run.get(
            path_text
        ) or self._record_of_path_in_last_run.get(path_text)
        try:
            status = path.stat()
            state = status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino
            if record is not None and record.state == state:
                digest = record.digest
            else:
                digest = file_digest(path)
        except OSError:
            return ""
        if status.st_ctime_ns < now_ns - _COARSEST_CLOCK_NS:
            self._record_of_path_in_this_run[path_text] = _Record(state, digest)
        return digest
