"""What a run needs of the machine, asked once before its first step.

Decides: what a run needs of the machine.
"""

import errno
import os
import shlex
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from oilfilm.errors import OilfilmError

# Snakemake takes braces for wildcards; PATH is parted at colons; a shell runs what a dollar sign
# or a backquote begins, even in double quotes, and the start scripts of packages have those.
UNUSABLE = frozenset('{}:$`"\\') | {chr(code) for code in (*range(32), 127)}
# A job maps up to 1.7 GiB on two cores, and more on more cores. With less OpenBLAS may wait for
# ever for memory that it does not get.
LEAST_ADDRESS_SPACE = 4 << 30
# A full disk still takes an empty file, but no block.
_BLOCK = bytes(4096)
# What the machine refuses is no fault of the program: in words, with what to do.
_FAULTS = {
    errno.ENOSPC: "The disk is full. Make room on it",
    errno.EDQUOT: "The quota on this disk is used up. Make room",
    errno.EFBIG: "A file would be larger than is allowed here. Raise the limit (ulimit -f)",
    errno.EROFS: "The disk can only be read. Mount it for writing",
    errno.EACCES: "A file or folder may not be read or written. Change its rights",
    errno.EPERM: "A file or folder may not be changed. Change its rights",
    errno.EIO: "The disk could not be read or written. Have it checked",
}


def ask_machine(written: Iterable[Path]) -> None:
    """Refuse to run where jobs cannot start or write.

    Args:
        written: Folders that the run writes to, or will make.

    Raises:
        OilfilmError: The path of the working folder cannot be used, a folder cannot be written, or
            the address space is too small.
    """
    refuse_unusable(Path.cwd())
    refuse_little_memory()
    for folder in written:
        refuse_unwritable(folder)


def machine_fault(error: OSError) -> str:
    """What the machine refuses and what to do, in words; empty where the program is at fault."""
    return _FAULTS.get(error.errno or 0, "")


def refuse_unusable(folder: Path) -> None:
    """Refuse a folder in which jobs cannot be started safely.

    Raises:
        OilfilmError: The whole path has a character of `UNUSABLE`.
    """
    bad = sorted(UNUSABLE & set(str(folder)))
    if bad:
        names = ", ".join(map(repr, bad))
        raise OilfilmError(
            f"{str(folder)!r}: jobs cannot be started in a folder with {names} in its path. Rename "
            "the folder, or move what is in it; blanks and letters of any language do no harm."
        )


def refuse_unwritable(folder: Path) -> None:
    """Refuse a folder that takes no file, or whose disk is full.

    Raises:
        OilfilmError: Which folder, why, and what to do.
    """
    places = (folder, *folder.absolute().parents)
    # unlike Path.exists, this does not raise where a folder above may not be entered
    existing = next(each for each in places if os.path.exists(each))  # noqa: PTH110
    try:
        with tempfile.TemporaryFile(dir=existing) as file:
            file.write(_BLOCK)
            file.flush()
    except OSError as error:
        fault = machine_fault(error)
        why = f"{fault} ({error.strerror})" if fault else f"cannot be written: {error.strerror}"
        raise OilfilmError(f"{existing}: {why}.") from None


def refuse_little_memory() -> None:
    """Refuse an address space in which jobs would fail at any point, or never end.

    Raises:
        OilfilmError: The limit, and what to do.
    """
    try:
        import resource  # noqa: PLC0415 - Windows has none, and no such limit
    except ModuleNotFoundError:
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < LEAST_ADDRESS_SPACE:
        raise OilfilmError(
            f"The address space of a process is limited to {limit / 2**30:.1f} GiB here; expected "
            f"at least {LEAST_ADDRESS_SPACE >> 30} GiB. Raise the limit (ulimit -v unlimited)."
        )


def start_python_by_name() -> None:
    """Let Snakemake find this Python through PATH where its own path would need quotes.

    Snakemake writes `sys.executable` without quotes into the commands of its jobs.
    """
    python = Path(sys.executable)
    if shlex.quote(sys.executable) != sys.executable:
        os.environ["PATH"] = os.pathsep.join([str(python.parent), os.environ.get("PATH", "")])
        sys.executable = python.name


def keep_a_cache(other: Path) -> None:
    """Give Snakemake another folder for its cache where it cannot make one in the user's.

    Args:
        other: The folder to take instead.
    """
    # as Snakemake finds it; Path.home raises where the user has no home at all
    home_cache = os.path.expanduser("~/.cache")  # noqa: PTH111
    usual = Path(os.environ.get("XDG_CACHE_HOME") or home_cache)
    try:
        refuse_unwritable(usual)
    except OilfilmError:
        os.environ["XDG_CACHE_HOME"] = str(other.absolute())
