"""One run at a time in a folder, and none stopped by what a killed one has left.

Snakemake's own lock is a file, which outlives a killed run. The operating system gives a lock up
with the last process that holds it: a run holds one, and so does each of its jobs, which may
outlive it. Standard library only: the Snakefile asks.
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


def clear_up(records: Path, made: Iterable[Path]) -> None:
    """Where no run is at work, take away what would stop one: dead locks, dates in the future.

    Snakemake lets no output be older than its input, so that after a clock has stepped back
    nothing could be made from what was made before.

    Args:
        records: Snakemake's own folder.
        made: What the workflow makes; a user's logs keep their dates.
    """
    with suppress(OSError), _opened(records) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for left in (records / "locks").glob("*.lock"):
            left.unlink()
        now = time.time_ns()
        for path in chain(*((folder, *folder.rglob("*")) for folder in made if folder.exists())):
            if path.lstat().st_mtime_ns > now:
                os.utime(path, ns=(now, now), follow_symlinks=False)


def begin_run(records: Path) -> None:
    """Be the one run of a folder until the process ends, however it ends.

    Raises:
        OilfilmError: Another run, or a job that outlived one, is at work.
    """
    try:
        with _opened(records) as file:
            lock = os.dup(file.fileno())  # never closed
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # shared from here on, because the jobs hold it too
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OilfilmError(
            f"Another run is at work in {records.absolute().parent}, or a job of one that was "
            "killed still is. Wait until it ends, or end it, then run snakemake again."
        ) from None
    except OSError:  # a file system that has no such locks: Snakemake's own must do
        pass


@contextmanager
def at_work(records: Path) -> Iterator[None]:
    """Let no other run begin while a job is at work."""
    with _opened(records) as lock:
        with suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_SH)
        yield


def _opened(records: Path) -> IO[bytes]:
    records.mkdir(parents=True, exist_ok=True)
    return (records / _LOCK).open("a+b")  # network file systems lock what can be read
