"""Checks of the machine before the first step of a run, and the lock of a folder.

The lock allows one run at a time per folder. It is a lock of the operating system. The system
releases it when the last process that holds it ends. The run and each of its jobs hold the lock,
because a job may outlive a run that was killed. Snakemake's own lock is a file, which remains after
a run was killed. The profiles therefore set `nolock`.

Decides: what a run needs of the machine; who keeps a second run out of a folder.
"""

import errno
import fcntl
import os
import shlex
import shutil
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from oilfilm.base.errors import OilfilmError

# Characters that the path of a project must not have. Snakemake takes braces for wildcards. PATH is
# split at colons. A shell evaluates a dollar sign or a backquote even in double quotes, and the
# start scripts of packages contain double quotes.
UNUSABLE_CHARACTERS = frozenset('{}:$`"\\') | {chr(code) for code in (*range(32), 127)}
_LOCK_NAME = "oilfilm.lock"
# Faults of the machine, not of the program, with the advice, by the number of the error.
_FAULT_AND_ADVICE_BY_ERRNO = {
    errno.ENOSPC: "The disk is full. Make room on it",
    errno.EDQUOT: "The quota on this disk is used up. Make room",
    errno.EFBIG: "A file would be larger than is allowed here. Raise the limit (ulimit -f)",
    errno.EROFS: "The disk can only be read. Mount it for writing",
    errno.EACCES: "A file or folder may not be read or written. Change its rights",
    errno.EPERM: "A file or folder may not be changed. Change its rights",
    errno.EIO: "The disk could not be read or written. Have it checked",
}


def machine_fault(error: OSError) -> str:
    """A fault of the machine and the advice, as text; empty where the program is at fault."""
    return _FAULT_AND_ADVICE_BY_ERRNO.get(error.errno or 0, "")


def check_machine(written_folders: Iterable[Path]) -> None:
    """Refuse to run where jobs cannot start or write.

    Args:
        written_folders: Folders that the run writes to or makes.

    Raises:
        OilfilmError: The path of the working folder cannot be used, or no file can be written to a
            folder.
    """
    folder = Path.cwd()
    unusable_in_path = sorted(UNUSABLE_CHARACTERS & set(str(folder)))
    if unusable_in_path:
        characters = ", ".join(map(repr, unusable_in_path))
        raise OilfilmError(
            f"{str(folder)!r}: jobs cannot be started in a folder with {characters} in its path. "
            "Rename the folder, or move its content; blanks and letters of any language do no harm."
        )
    for path in written_folders:
        _check_writable(path)


def _check_writable(path: Path) -> None:
    """Refuse a folder, existing or not, to which no file can be written."""
    existing_path = next(
        folder for folder in (path, *path.absolute().parents) if os.path.lexists(folder)
    )
    if not existing_path.exists():
        target = existing_path.readlink()
        raise OilfilmError(
            f"{existing_path}: is a link to {target}, which does not exist. Make the folder, or "
            "remove the link."
        )
    if not existing_path.is_dir():
        raise OilfilmError(f"{existing_path}: is a file, expected a folder. Move it.")
    if not os.access(existing_path, os.W_OK | os.X_OK):
        is_read_only_disk = os.statvfs(existing_path).f_flag & os.ST_RDONLY
        error_number = errno.EROFS if is_read_only_disk else errno.EACCES
        raise OilfilmError(f"{existing_path}: {_FAULT_AND_ADVICE_BY_ERRNO[error_number]}.")
    if not shutil.disk_usage(existing_path).free:
        raise OilfilmError(f"{existing_path}: {_FAULT_AND_ADVICE_BY_ERRNO[errno.ENOSPC]}.")


def check_image(image: str) -> None:
    """Refuse to run steps in a container image that does not exist.

    Without this check Apptainer would refuse each step by itself.

    Args:
        image: File or address of the container image; `none` where steps run without a container.

    Raises:
        OilfilmError: The image is a file that does not exist.
    """
    if image != "none" and "://" not in image and not Path(image).exists():
        raise OilfilmError(
            f"{image}: there is no such image. Build it by docs/containers/apptainer.def of the "
            "repository, or name another one: --config container=IMAGE."
        )


def make_python_findable_by_name() -> None:
    """Make Snakemake find this Python through PATH where its own path would need quotes.

    Snakemake writes `sys.executable` without quotes into the commands of its jobs.
    """
    python = Path(sys.executable)
    if shlex.quote(sys.executable) != sys.executable:
        os.environ["PATH"] = os.pathsep.join([str(python.parent), os.environ.get("PATH", "")])
        sys.executable = python.name


def reset_future_dates(folders: Iterable[Path]) -> None:
    """Set dates in the future to the present, as after a clock was set back.

    Snakemake refuses an output that is older than its input.
    """
    now = time.time_ns()
    for folder in folders:
        for path in (folder, *folder.rglob("*")):
            if path.exists() and path.lstat().st_mtime_ns > now:
                os.utime(path, ns=(now, now), follow_symlinks=False)


def lock_run(snakemake_folder: Path) -> None:
    """Hold the lock of a folder until this process ends.

    Args:
        snakemake_folder: Snakemake's folder, `.snakemake`.

    Raises:
        OilfilmError: Another run, or a job that outlived its run, is active.
    """
    with _open_lock(snakemake_folder) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # From now on the jobs of this run hold the lock too. The change is not atomic: if
            # another run takes the lock in between, this one gives up.
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OilfilmError(
                f"Another run is active in {snakemake_folder.absolute().parent}, or a job of one "
                "that was killed. Wait until it ends, or end it, then run snakemake again. To run "
                "two campaigns at a time, give each a folder of its own (oilfilm init)."
            ) from None
        except OSError:  # a file system without such locks
            return
        os.dup(file.fileno())  # never closed


@contextmanager
def job_lock(snakemake_folder: Path) -> Iterator[None]:
    """Prevent another run from starting while a job is active."""
    with _open_lock(snakemake_folder) as file:
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_SH)
        yield


def _open_lock(snakemake_folder: Path) -> IO[bytes]:
    """The open file of the lock, which is made if there is none."""
    snakemake_folder.mkdir(parents=True, exist_ok=True)
    # network file systems lock readable files only
    return (snakemake_folder / _LOCK_NAME).open("a+b")
