"""One run at a time per folder; leftovers of a killed run never block the next one.

Snakemake's own lock is a file, which remains after a killed run. A lock of the operating system
ends with the last process that holds it. The run holds one, and so does each of its jobs, because
a job may outlive the run. Standard library only, because the Snakefile imports it.
"""

import fcntl
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path
from typing import IO

from oilfilm.errors import OilfilmError

_LOCK = "oilfilm.lock"


def clear_leftovers(records: Path, outputs: Iterable[Path]) -> None:
    """Remove stale locks and time stamps in the future, unless a run is active.

    Snakemake refuses an output that is older than its input. After a clock was set back, no file
    could be made from an earlier one.

    Args:
        records: Snakemake's own folder.
        outputs: Files and folders that the workflow makes; raw logs of users keep their dates.
    """
    with suppress(OSError), _open_lock(records) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for stale in (records / "locks").glob("*.lock"):
            stale.unlink()
        now = time.time_ns()
        for path in chain(*((folder, *folder.rglob("*")) for folder in outputs if folder.exists())):
            if path.lstat().st_mtime_ns > now:
                os.utime(path, ns=(now, now), follow_symlinks=False)


def lock_run(records: Path) -> None:
    """Hold the run lock of a folder until this process ends.

    Raises:
        OilfilmError: Another run, or a job that outlived its run, is active.
    """
    try:
        with _open_lock(records) as file:
            lock = os.dup(file.fileno())  # never closed
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # shared from now on, because the jobs hold it too
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OilfilmError(
            f"Another run is active in {records.absolute().parent}, or a job of one that was "
            "killed. Wait until it ends, or end it, then run snakemake again."
        ) from None
    except OSError:  # a file system without such locks: Snakemake's own lock remains
        pass


@contextmanager
def job_lock(records: Path) -> Iterator[None]:
    """Prevent another run from starting while a job is active."""
    with _open_lock(records) as lock:
        with suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_SH)
        yield


def _open_lock(records: Path) -> IO[bytes]:
    records.mkdir(parents=True, exist_ok=True)
    return (records / _LOCK).open("a+b")  # network file systems lock readable files only
