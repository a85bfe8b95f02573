"""Digests of raw logs, kept from one start of the workflow to the next.

A terabyte of logs cannot be read at every start. A log keeps its digest while its size, its times
and its place on the disk are the same. Whoever reads its content takes the digest again: the job
that ingests it, a release, `oilfilm verify`.
"""

import json
import time
from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.digests import file_digest

# A file that changed less than this before it was read may change again within one tick of the
# file system's clock (2 s on FAT), and its times would not tell.
_TICK_NS = 2_000_000_000
_State = list[int]


class DigestCache:
    """Digests of files by path, each with the state that the file had when it was read."""

    def __init__(self, path: Path) -> None:
        """Read what earlier runs kept; a damaged file is none.

        Args:
            path: The file that keeps the digests.
        """
        self._path = path
        self._known = _read(path)
        self._changed = False

    def digest(self, file: Path) -> str:
        """sha256 of a file, in hex; read only where its state is not the known one."""
        name, state = file.as_posix(), _state(file)
        kept = self._known.get(name)
        if kept is not None and kept[0] == state:
            return kept[1]
        digest = file_digest(file)
        if _state(file) == state and time.time_ns() - max(state[1:3]) > _TICK_NS:
            self._known[name] = (state, digest)
            self._changed = True
        return digest

    def save(self) -> None:
        """Keep the digests for the next start.

        Raises:
            OSError: The file cannot be written.
        """
        if self._changed:
            write_text(json.dumps(self._known, sort_keys=True) + "\n", self._path)
            self._changed = False

    def forget(self) -> None:
        """Read every file again at the next start, as after a run that failed."""
        self._known, self._changed = {}, False
        self._path.unlink(missing_ok=True)


def _state(file: Path) -> _State:
    status = file.stat()
    return [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]


def _read(path: Path) -> dict[str, tuple[_State, str]]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {
            str(name): ([int(value) for value in state], str(digest))
            for name, (state, digest) in content.items()
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}
