"""Which raw logs a campaign has. Standard library only: the Snakefile imports it.

Decides: which files of a folder are logs.
"""

import hashlib
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import BinaryIO

from oilfilm.base.errors import OilfilmError

# Names of the run sheet, in small letters or capitals. It is in the campaign's folder itself.
_RUN_SHEET_NAMES = ("runs.csv", "runs.tsv", "runs.xlsx", "runs.ods")
# Largest log in bytes, packed or unpacked. A larger one was made to fill the memory.
LARGEST_LOG_BYTES = 1 << 28
TOO_LITTLE_MEMORY = (
    "the memory does not suffice to read it. Give the program more memory, or end other programs."
)
_BLOCK_BYTES = 1 << 20
# Number of faults or names in a message. Further faults are counted, further names become dots.
_MOST_LISTED = 20
# Excel writes such a file beside a workbook that is open.
_LOCK_FILE_PREFIX = "~$"
# Snakemake takes braces for wildcards and angle brackets for its own paths. A manifest takes
# backslashes for folders. Control characters, ends of lines and changes of direction deceive the
# reader of a listing. Python writes bytes that are no UTF-8 as surrogates.
_UNFIT_CHARACTER = re.compile(
    r"[{}<>\\\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def raw_log_names(folder: Path) -> list[str]:
    """Names of all logs of a campaign: their paths below its raw folder, sorted part by part.

    Hidden files, README files and the run sheet are not logs.

    Raises:
        OilfilmError: The folder is missing or empty, or it has possible logs that cannot be read:
            a link that is broken or leads out of it, a folder without rights, a pipe, a name
            that Snakemake, a listing or a manifest cannot hold. The message names all of them.
    """
    fault_of_log = dict(log_names_and_faults(folder))
    faults = [fault for fault in fault_of_log.values() if fault]
    if faults:
        raise faults_error(faults, folder, "of them")
    if not fault_of_log:
        raise OilfilmError(f"{folder}: holds no logs. Put the campaign's logs there.")
    return list(fault_of_log)


def faults_error(faults: Sequence[str], path: Path, faults_in_words: str) -> OilfilmError:
    """One error for the many faults of a folder or file, one per line.

    Args:
        faults: Sentences.
        path: The folder or file.
        faults_in_words: Word for the faults that are counted only, as in `3 more mistakes`.
    """
    lines = list(faults[:_MOST_LISTED])
    if len(faults) > _MOST_LISTED:
        lines.append(f"{path}: {len(faults) - _MOST_LISTED} more {faults_in_words}")
    return OilfilmError("\n".join(lines))


def names_in_words(names: Sequence[str]) -> str:
    """The first names of many, for a message."""
    more = " ..." if len(names) > _MOST_LISTED else ""
    return ", ".join(names[:_MOST_LISTED]) + more


def log_names_and_faults(folder: Path) -> Iterator[tuple[str, str]]:
    """Path of each log, relative to a raw folder, and why it cannot be used (empty where it can).

    Raises:
        OilfilmError: The folder is missing or cannot be read.
    """
    error_of_folder: dict[Path, OSError] = {}

    def note_error(error: OSError) -> None:
        error_of_folder[Path(error.filename)] = error

    paths: list[Path] = []
    for parent, folder_names, file_names in os.walk(folder, onerror=note_error):
        paths += [Path(parent, name) for name in (*folder_names, *file_names)]
    error = error_of_folder.get(folder)
    if isinstance(error, (FileNotFoundError, NotADirectoryError)):
        raise OilfilmError(f"{folder}: there is no such folder. Make it and put the logs there.")
    if error is not None:
        raise OilfilmError(f"{folder}: {_access_fault(error)}")
    for path in sorted(paths):
        if is_passed_over(path, folder):
            continue
        name = path.relative_to(folder).as_posix()
        if path in error_of_folder:
            fault = _access_fault(error_of_folder[path])
        else:
            fault = _reach_fault(path, folder)
        if fault:
            yield name, f"{path}: {fault}"
        elif not path.is_dir():
            yield name, name_fault(name, path)


def is_passed_over(path: Path, folder: Path) -> bool:
    """Whether a path below a raw folder is no log by its name: hidden, a README, a run sheet."""
    names = path.relative_to(folder).parts
    is_hidden = any(name.startswith((".", _LOCK_FILE_PREFIX)) for name in names)
    return is_hidden or path.stem.upper() == "README" or is_run_sheet_of(path, folder)


def _access_fault(error: OSError) -> str:
    """Why a file or folder cannot be read, by the error of the attempt."""
    return f"cannot be read ({error.strerror}). Check its rights, and those of its folder."


def _reach_fault(path: Path, folder: Path) -> str:
    """Why a path with the name of a log or folder cannot be read; empty where it can."""
    try:
        path.stat()
    except PermissionError as error:
        return _access_fault(error)
    except OSError:
        return "is a link to a file that is not there. Fetch the file, or take the link out."
    if path.is_dir():
        if path.is_symlink():
            return f"is a link to a folder. Copy the logs into {folder}."
        return ""
    if not path.is_file():
        return "is a pipe or a device, expected a file. Take it out."
    if not path.resolve().is_relative_to(folder.resolve()):
        return f"is a link that leads out of {folder}. Copy the file into it."
    return ""


def name_fault(name: str, path: Path | str) -> str:
    """Why a log cannot have its name below its campaign's folder; empty where it can.

    Args:
        name: Path of the log below the folder.
        path: Path of the log, for the message.
    """
    match = _UNFIT_CHARACTER.search(name)
    if match is None:
        return ""
    return (
        f"{path}: {match[0]!r} cannot be in the name of a log: expected text in UTF-8 without "
        "braces, angle brackets, backslashes or control characters. Rename it."
    )


def is_run_sheet_of(path: Path, folder: Path) -> bool:
    """Whether a path in a campaign's raw folder is its run sheet."""
    return path.parent == folder and path.name.lower() in _RUN_SHEET_NAMES


def find_run_sheet(folder: Path) -> Path | None:
    """The run sheet of a campaign's raw folder; None where it has none.

    Raises:
        OilfilmError: There are several, or it is no file of the folder.
    """
    sheets = [path for path in sorted(folder.glob("*")) if is_run_sheet_of(path, folder)]
    if len(sheets) > 1:
        names = " and ".join(path.name for path in sheets)
        raise OilfilmError(f"{folder}: has the run sheets {names}. Leave one of them.")
    if not sheets:
        return None
    sheet = sheets[0]
    fault = _reach_fault(sheet, folder)
    if not fault and sheet.is_dir():
        fault = "is a folder with the name of a run sheet, expected a file. Rename it."
    if fault:
        raise OilfilmError(f"{sheet}: {fault}")
    return sheet


def read_beginning(file: BinaryIO) -> bytes:
    """The bytes of a file; of a file that is too large, one byte more than the largest log."""
    # a read of some size takes so much memory at once, however small the file is
    size = os.fstat(file.fileno()).st_size
    return file.read(min(size, LARGEST_LOG_BYTES) + 1)


@dataclass(frozen=True)
class RawLogs:
    """The raw logs that a job reads, each once; iterating gives the name and content of each.

    Attributes:
        folder: Folder of the campaign's logs, from the top folder.
        path_of_log: Name of a log below the folder -> its file.
        expected_digest_of_log: Name of a log -> its sha256 when the job began, or as the rig twin
            wrote it.
        is_simulated: Whether the rig twin wrote the logs.
        provenance_digests: Filled while iterating: path of each measured log -> the beginning of
            its sha256, for the provenance of tables.
        digest_of_log: Filled while iterating: name of a log -> its sha256.
    """

    folder: Path
    path_of_log: Mapping[str, Path]
    expected_digest_of_log: Mapping[str, str]
    is_simulated: bool = False
    provenance_digests: dict[str, str] = field(default_factory=dict)
    digest_of_log: dict[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[tuple[str, bytes]]:
        """Read one log after the other.

        Raises:
            OilfilmError: A log cannot be read, or has other bytes than are expected.
        """
        for name, path in self.path_of_log.items():
            try:
                with path.open("rb") as file:
                    content = read_beginning(file)
                    digest = hashlib.sha256(content)
                    # a larger log is refused for its size, but listed with its complete digest
                    block = file.read(_BLOCK_BYTES)
                    while block:
                        digest.update(block)
                        block = file.read(_BLOCK_BYTES)
            except MemoryError:
                raise OilfilmError(f"{self.folder / name}: {TOO_LITTLE_MEMORY}") from None
            except OSError as error:
                raise OilfilmError(
                    f"{self.folder / name}: cannot be read ({error.strerror}). Check its rights. "
                    "If it is missing, put it back, or run snakemake again without it."
                ) from error
            self.digest_of_log[name] = digest.hexdigest()
            if self.digest_of_log[name] != self.expected_digest_of_log[name]:
                raise OilfilmError(f"{self.folder / name}: {self._change_in_words()}")
            if not self.is_simulated:
                self.provenance_digests[f"{self.folder}/{name}"] = self.digest_of_log[name][:16]
            yield name, content

    def _change_in_words(self) -> str:
        if self.is_simulated:
            return "is not as the rig twin wrote it. Delete it: the next run simulates it again."
        return "has changed while it was read. When it is complete, run snakemake again."

    def select(self, names: Collection[str]) -> "RawLogs":
        """The logs with these names; reading them fills the digests of these logs."""
        names_selected = set(names)
        path_of_log = {
            name: path for name, path in self.path_of_log.items() if name in names_selected
        }
        return replace(self, path_of_log=path_of_log)

    def digest_of_path(self) -> dict[str, str]:
        """Path of each log that has been read, from the top folder -> its sha256."""
        return {
            (self.folder / name).as_posix(): digest for name, digest in self.digest_of_log.items()
        }


def listing_text(digest_of_name: Mapping[str, str]) -> str:
    """The text of a listing: digests and names of files, as `sha256sum` writes and checks them."""
    return "".join(f"{digest}  {name}\n" for name, digest in digest_of_name.items())


def read_listings(*paths: Path) -> dict[str, str]:
    """Name of a log -> its digest, from files with the text of `listing_text`."""
    digest_of_name: dict[str, str] = {}
    for path in paths:
        for line in path.read_text(encoding="utf-8").splitlines():
            digest, _, name = line.partition("  ")
            digest_of_name[name] = digest
    return digest_of_name


def logs_by_share(names: Sequence[str], logs_per_share: int) -> dict[int, list[str]]:
    """The logs of each share of the work, by its number; no share is empty.

    The share of a log depends on its name and on the number of shares. This number is the smallest
    power of two that is enough: an added or removed log moves other logs only where it changes.

    Args:
        names: Names of the logs.
        logs_per_share: Largest mean number of logs in a share.

    Examples:
        >>> logs = [f"run{number}.csv" for number in range(900)]
        >>> [number for number, files in logs_by_share(logs, 250).items() if 180 < len(files) < 270]
        [0, 1, 2, 3]
    """
    share_count = 1
    while share_count * logs_per_share < len(names):
        share_count *= 2
    names_of_share: dict[int, list[str]] = {}
    for name in names:
        # consecutive names must spread over the shares: with a checksum they would not
        name_digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
        names_of_share.setdefault(int.from_bytes(name_digest) % share_count, []).append(name)
    return dict(sorted(names_of_share.items()))
