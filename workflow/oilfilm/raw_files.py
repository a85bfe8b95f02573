"""Which raw logs a campaign has. Standard library only: the Snakefile asks."""

import zlib
from pathlib import Path

from oilfilm.errors import OilfilmError


def raw_files(folder: Path) -> list[str]:
    """Paths of all logs below a campaign's raw folder, relative to it, sorted.

    Hidden files and README files are not logs.

    Raises:
        OilfilmError: The folder is missing or empty, or a link in it leads out of it.
    """
    if not folder.is_dir():
        raise OilfilmError(f"{folder}: there is no such folder. Make it and put the logs there.")
    inside = folder.resolve()
    files = []
    for path in sorted(folder.rglob("*")):
        relative = path.relative_to(folder)
        hidden = any(part.startswith(".") for part in relative.parts)
        if hidden or not path.is_file() or path.stem.upper() == "README":
            continue
        if not path.resolve().is_relative_to(inside):
            raise OilfilmError(
                f"{path}: is a link that leads out of {folder}. Copy the log into the folder."
            )
        files.append(relative.as_posix())
    if not files:
        raise OilfilmError(f"{folder}: holds no logs. Put the campaign's logs there.")
    return files


def shard_of(file: str, shards: int) -> int:
    """The share of the work that a log belongs to; it depends on its name alone."""
    return zlib.crc32(file.encode()) % shards
