"""One run at a time per folder, by a lock of the operating system, which ends with its holders.

The run holds it, and so does each of its jobs, because a job may outlive a run that was killed.
Snakemake's own lock is a file that a killed run leaves behind: the profiles set `nolock`.

Decides: who keeps a second run out of a folder.
"""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from oilfilm.errors import OilfilmError

_LOCK = "oilfilm.lock"


def lock_run(records: Path) -> None:
    """Hold the lock of a folder until this process ends.

    Args:
        records: Snakemake's own folder.

    Raises:
        OilfilmError: Another run, or a job that outlived its run, is active.
    """
    with _open_lock(records) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OilfilmError(
                f"Another run is active in {records.absolute().parent}, or a job of one that was "
                "killed. Wait until it ends, or end it, then run snakemake again. To run two "
                "campaigns at a time, give each a folder of its own (oilfilm init)."
            ) from None
        except OSError:  # a file system without such locks
            return
        fcntl.flock(file, fcntl.LOCK_SH)  # from now on its jobs hold it too
        os.dup(file.fileno())  # never closed


@contextmanager
def job_lock(records: Path) -> Iterator[None]:
    """Prevent another run from starting while a job is active."""
    with _open_lock(records) as file:
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_SH)
        yield


def _open_lock(records: Path) -> IO[bytes]:
    records.mkdir(parents=True, exist_ok=True)
    return (records / _LOCK).open("a+b")  # network file systems lock readable files only
