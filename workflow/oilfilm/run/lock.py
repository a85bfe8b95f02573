"""One run at a time per folder; leftovers of a killed run never block the next one.

Snakemake's own lock is a file, which remains after a killed run. A lock of the operating system
ends with the last process that holds it. The run holds one, and so does each of its jobs, because
a job may outlive the run. Some shared file systems have no such locks, or keep them within one
computer. A note beside the lock therefore says who runs, and its date is renewed while they do: a
note that is old, or of a process of this computer that has ended, keeps nobody out. Standard
library only, because the Snakefile imports it.
"""

import atexit
import fcntl
import getpass
import json
import os
import platform
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from threading import Event, Thread
from typing import IO

from oilfilm.errors import OilfilmError

_LOCK = "oilfilm.lock"
_NOTE = "oilfilm.run.json"
# Seconds between two signs of life, and without any until a run counts as ended. Computers of a
# shared file system see each other's changes late, most of them within a minute.
_BEAT_S = 20.0
_SILENT_S = 300.0
# Letters of a name in a note that are told.
_LONGEST = 80


@dataclass(frozen=True)
class _Holder:
    """Who runs in a folder: what is told to whoever else would."""

    campaign: str
    user: str
    host: str
    process: int
    begun: str

    @classmethod
    def me(cls, campaign: str) -> "_Holder":
        """This process."""
        try:
            user = getpass.getuser()
        except (KeyError, OSError):  # a container may run under a number without a name
            user = str(os.getuid())
        begun = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
        return cls(campaign, user, platform.node(), os.getpid(), begun)

    @classmethod
    def noted(cls, note: Path) -> "_Holder | None":
        """Who wrote a note; None where there is none, or one that cannot be understood."""
        try:
            said = json.loads(note.read_bytes())
            campaign, user, host, begun = (
                "".join(filter(str.isprintable, str(said[key])))[:_LONGEST]
                for key in ("campaign", "user", "host", "begun")
            )
            return cls(campaign, user, host, int(said["process"]), begun)
        except (OSError, ValueError, TypeError, KeyError, RecursionError):
            return None

    @property
    def has_ended(self) -> bool:
        """Whether this computer knows that the process has ended, or is this one."""
        if self.host != platform.node():
            return False
        try:
            os.kill(self.process, 0)
        except (ProcessLookupError, OverflowError):
            return True
        except PermissionError:  # of another user
            return False
        return self.process == os.getpid()

    def __str__(self) -> str:
        return (
            f"of campaign {self.campaign!r} by {self.user} on {self.host} "
            f"(process {self.process}), begun {self.begun},"
        )


def clear_leftovers(records: Path, outputs: Iterable[Path]) -> str:
    """Remove stale locks and time stamps in the future, unless a run is active; then, whose it is.

    Snakemake refuses an output that is older than its input. After a clock was set back, no file
    could be made from an earlier one.

    Args:
        records: Snakemake's own folder.
        outputs: Files and folders that the workflow makes; raw logs of users keep their dates.

    Returns:
        Which run is active and what to do; empty if none is. Snakemake's own lock refuses a second
        run before `lock_run` could, and advises to remove the lock.
    """
    with suppress(OSError), _open_lock(records) as lock:
        if _held(records, lock):
            return _refusal(records)
        for stale in (records / "locks").glob("*.lock"):
            stale.unlink()
        now = time.time_ns()
        for path in chain(*((folder, *folder.rglob("*")) for folder in outputs if folder.exists())):
            if path.lstat().st_mtime_ns > now:
                os.utime(path, ns=(now, now), follow_symlinks=False)
    return ""


def lock_run(records: Path, campaign: str) -> None:
    """Hold the run lock of a folder until this process ends, and say who holds it.

    Args:
        records: Snakemake's own folder.
        campaign: What is run, for the note.

    Raises:
        OilfilmError: Another run, or a job that outlived its run, is active: whose, since when.
    """
    with _open_lock(records) as file:
        if _held(records, file):
            raise OilfilmError(_refusal(records))
        lock = os.dup(file.fileno())  # never closed
    with suppress(OSError):  # a file system without such locks
        # shared from now on, because the jobs hold it too
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    temporary = records / f".{_NOTE}.part"
    temporary.write_text(json.dumps(asdict(_Holder.me(campaign))), encoding="utf-8")
    temporary.replace(records / _NOTE)
    atexit.register((records / _NOTE).absolute().unlink, missing_ok=True)
    _beat(records / _NOTE)


@contextmanager
def job_lock(records: Path) -> Iterator[None]:
    """Prevent another run from starting while a job is active."""
    with _open_lock(records) as lock:
        with suppress(OSError):
            fcntl.flock(lock, fcntl.LOCK_SH)
        ended = _beat(records / _NOTE)
        try:
            yield
        finally:
            ended.set()


def _refusal(records: Path) -> str:
    holder = _Holder.noted(records / _NOTE)
    return (
        f"Another run {f'{holder} ' if holder else ''}is active in {records.absolute().parent}, or "
        "a job of one that was killed. Wait until it ends, or end it, then run snakemake again. A "
        f"run that was killed on another computer counts as ended after {_SILENT_S / 60:.0f} "
        "minutes. To run two campaigns at a time, give each a folder of its own (oilfilm init)."
    )


def _held(records: Path, lock: IO[bytes]) -> bool:
    """Whether another process holds the lock; if not, this one may do so from now on."""
    locks_work = True
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        locks_work = False
    note = records / _NOTE
    holder = _Holder.noted(note)
    # within one computer the lock itself knows
    if holder is None or holder.has_ended or (locks_work and holder.host == platform.node()):
        return False
    os.utime(lock.fileno())  # the time of the file system, which may not be that of this computer
    return os.fstat(lock.fileno()).st_mtime - note.stat().st_mtime < _SILENT_S


def _beat(note: Path) -> Event:
    """Renew the date of a note until this process or the returned event ends it."""
    ended = Event()

    def renew() -> None:
        while not ended.wait(_BEAT_S):
            with suppress(OSError):
                os.utime(note)

    Thread(target=renew, daemon=True, name="sign of life").start()
    return ended


def _open_lock(records: Path) -> IO[bytes]:
    records.mkdir(parents=True, exist_ok=True)
    return (records / _LOCK).open("a+b")  # network file systems lock readable files only
