"""Which raw logs a campaign has. Standard library only: the Snakefile imports it.

Decides: which files of a folder are logs.
"""

import hashlib
import json
import re
from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Iterator,
    Mapping,
    MutableMapping,
    Sequence,
)
from pathlib import Path
from typing import Any

from oilfilm.atomic_write import write_bytes
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError

# The run sheet lies in the campaign's folder, not below it; its name may be in capitals.
_SHEETS = ("runs.csv", "runs.tsv", "runs.xlsx")
# Excel writes such a file beside a workbook that is open.
_LOCK_FILE = "~$"
# Snakemake takes braces for wildcards and angle brackets for its own paths, a manifest backslashes
# for folders; control characters and changes of direction deceive who reads a listing; Python
# writes bytes that are no UTF-8 as surrogates.
_UNFIT = re.compile(
    r"[{}<>\\\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)


def raw_files(folder: Path) -> list[str]:
    """Paths of all logs below a campaign's raw folder, relative to it, sorted.

    Hidden files, README files and the run sheet are not logs.

    Raises:
        OilfilmError: The folder is missing or empty, a link in it leads out of it, or a log has a
            name that Snakemake, a listing or a manifest cannot hold.
    """
    files = []
    for name, fault in named_logs(folder):
        if fault:
            raise OilfilmError(fault)
        files.append(name)
    if not files:
        raise OilfilmError(f"{folder}: holds no logs. Put the campaign's logs there.")
    return files


def named_logs(folder: Path) -> Iterator[tuple[str, str]]:
    """Each log below a raw folder: its path relative to it, and why it cannot be used, if so.

    Raises:
        OilfilmError: The folder is missing.
    """
    if not folder.is_dir():
        raise OilfilmError(f"{folder}: there is no such folder. Make it and put the logs there.")
    inside = folder.resolve()
    for path in sorted(folder.rglob("*")):
        relative = path.relative_to(folder)
        name, fault = relative.as_posix(), ""
        hidden = _is_hidden(relative)
        if path.is_symlink() and path.is_dir() and not hidden:
            yield name, f"{path}: is a link to a folder. Copy the logs into {folder}."
            continue
        if hidden or not path.is_file() or _is_readme(path) or is_sheet(path, folder):
            continue
        if not path.resolve().is_relative_to(inside):
            fault = f"{path}: is a link that leads out of {folder}. Copy the log into the folder."
        yield name, fault or unfit_name(name, path)


def _is_hidden(relative: Path) -> bool:
    return any(part.startswith((".", _LOCK_FILE)) for part in relative.parts)


def _is_readme(path: Path) -> bool:
    return path.stem.upper() == "README"


def unfit_name(name: str, path: Path | str) -> str:
    """Why a log cannot have its name below its campaign's folder; empty where it can.

    Args:
        name: Its name there, text that others must be able to hold.
        path: Where it is.
    """
    unfit = _UNFIT.search(name)
    return (
        f"{path}: {unfit[0]!r} cannot be in the name of a log: expected text in UTF-8 without "
        "braces, angle brackets, backslashes or control characters. Rename it."
        if unfit
        else ""
    )


def is_sheet(path: Path, folder: Path) -> bool:
    """Whether a file of a campaign's raw folder is its run sheet."""
    return path.parent == folder and path.name.lower() in _SHEETS


def find_sheet(folder: Path) -> Path | None:
    """The run sheet of a campaign's raw folder; None where it has none.

    Raises:
        OilfilmError: There are several, or it is a link that leads out of the folder.
    """
    sheets = [
        path for path in sorted(folder.glob("*")) if is_sheet(path, folder) and path.is_file()
    ]
    if len(sheets) > 1:
        names = " and ".join(path.name for path in sheets)
        raise OilfilmError(f"{folder}: has the run sheets {names}. Leave one of them.")
    for path in sheets:
        if not path.resolve().is_relative_to(folder.resolve()):
            raise OilfilmError(
                f"{path}: is a link that leads out of {folder}. Copy the run sheet into the folder."
            )
    return sheets[0] if sheets else None


def refuse_strangers(folder: Path, written: Iterable[str]) -> None:
    """The folder that the rig twin writes again each time must hold only its logs.

    Raises:
        OilfilmError: A file there is none of those `written`.
    """
    strangers = {path.name for path in folder.glob("*")} - set(written)
    strangers = {name for name in strangers if not name.startswith(".")}
    if strangers:
        raise OilfilmError(
            f"{folder}: holds {sorted(strangers)[0]!r}, which the rig twin did not write and would "
            "delete. Put logs of your own into a campaign of their own."
        )


def listing(folder: Path) -> str:
    """The digests of a folder's logs, as `sha256sum` writes and checks them."""
    return "".join(f"{file_digest(folder / name)}  {name}\n" for name in raw_files(folder))


def read_listing(path: Path) -> dict[str, str]:
    """Digest by name, from the text that `listing` has made."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return {name: digest for digest, _, name in (line.partition("  ") for line in lines)}


def refuse_altered(
    folder: Path, path: Path, digest_of: Callable[[Path], str] = file_digest
) -> None:
    """The simulated logs must not be edited; the listing has their digests.

    Snakemake sees no change inside a folder that a job has made.

    Args:
        folder: The logs.
        path: The listing.
        digest_of: Gives the digest of a log.

    Raises:
        OilfilmError: A log has other bytes or is missing.
    """
    if not (folder.is_dir() and path.is_file()):
        return
    for name, digest in read_listing(path).items():
        if not (folder / name).is_file() or digest_of(folder / name) != digest:
            raise OilfilmError(
                f"{folder / name}: is not as the rig twin wrote it. Delete {folder}: the next run "
                "simulates it again."
            )


def keep_found(found: Mapping[str, Any], path: Path) -> None:
    """Write what a run has found of its logs, unless the file has it already.

    Args:
        found: Plain data, as the state of each log in their order.
        path: Where it is kept.

    Raises:
        OSError: The file cannot be written.
    """
    content = (json.dumps(found, indent=1) + "\n").encode()
    if not path.is_file() or path.read_bytes() != content:
        write_bytes(content, path)


def expected_states(states: Mapping[str, str], written: str | None) -> dict[str, str]:
    """The state that each log had when the run began, or, from a listing, when it was written."""
    if written is None:
        return dict(states)
    listed = read_listing(Path(written))
    return {name: listed[name] for name in states}


def unchanged_logs(
    folder: Path,
    states: Mapping[str, str],
    inputs: MutableMapping[str, str] | None = None,
) -> Iterator[tuple[str, bytes]]:
    """Name and content of each log.

    Args:
        folder: Where the logs are.
        states: sha256 of each log by its name.
        inputs: Gets the digest of each log, for the provenance. Snakemake does not know the logs
            as inputs.

    Raises:
        OilfilmError: A log cannot be read, or has changed since its state was taken.
    """
    for name, state in states.items():
        path = folder / name
        content = _content(path)
        found = hashlib.sha256(content).hexdigest()
        if found != state:
            raise OilfilmError(
                f"{path}: has changed since the run began. When it is complete, run snakemake "
                "again."
            )
        if inputs is not None:
            inputs[path.as_posix()] = found[:16]
        yield name, content


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise OilfilmError(
            f"{path}: cannot be read ({error.strerror}). Check its rights. If it is missing, put "
            "it back, or run snakemake again without it."
        ) from error


def remove_others(folder: Path, oils: Collection[str], shares: Collection[int]) -> None:
    """Delete samples that no job writes any more, as after a change of `split.runs`.

    Args:
        folder: Of the samples, with files `oil=<oil>/part-<share>.parquet`.
        oils: The oils of the campaign.
        shares: The shares of its logs.
    """
    wanted = {f"oil={oil}/part-{share}.parquet" for oil in oils for share in shares}
    for path in sorted(folder.glob("oil=*/part-*.parquet")):
        if path.relative_to(folder).as_posix() not in wanted:
            path.unlink()


def shares_of(files: Sequence[str], runs: int) -> dict[int, list[str]]:
    """The logs of each share of the work, by its number; no share is empty.

    The share of a log depends on its name and on the number of shares. That is a power of two: a
    log that is added or removed moves no other one, but where the campaign has doubled.

    Args:
        files: Names of the logs.
        runs: Logs in a share, at most, on average.

    Examples:
        >>> logs = [f"run{number}.csv" for number in range(900)]
        >>> [number for number, files in shares_of(logs, 250).items() if 180 < len(files) < 270]
        [0, 1, 2, 3]
    """
    count = 1 << max(-(-len(files) // runs) - 1, 0).bit_length()
    shares: dict[int, list[str]] = {}
    for file in files:
        # names in a row must spread: the low bits of a checksum would not
        digest = hashlib.blake2b(file.encode(), digest_size=8).digest()
        shares.setdefault(int.from_bytes(digest) % count, []).append(file)
    return dict(sorted(shares.items()))
