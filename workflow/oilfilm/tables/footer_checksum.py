"""A checksum of the footer of a Parquet file, kept in that footer.

Parquet has checksums of pages only. A footer says where columns are, what they are called and where
the rows came from; a changed bit in it may go unseen.
"""

import re
import zlib
from pathlib import Path

# What a writer adds to the metadata: a placeholder of zeros for the checksum.
PLACE = {"oilfilm.footer_crc32": "00000000"}

_STATED = re.compile(rb"oilfilm\.footer_crc32..([0-9a-f]{8})", re.DOTALL)
# A Parquet file ends with the length of its footer and four letters.
_TAIL = 8


def seal(path: Path) -> None:
    """Write the checksum of the footer into its place.

    Args:
        path: A complete Parquet file with `PLACE` in its metadata.
    """
    footer = _footer(path)
    _, place = _stated(footer)
    with path.open("r+b") as file:
        file.seek(place.start - len(footer), 2)
        file.write(f"{_checksum(footer, place):08x}".encode())


def is_sound(path: Path) -> bool:
    """Whether a footer has its checksum, or none at all, as in tables written by earlier versions.

    Raises:
        OSError: There is no such file, or it is too short for a footer.
    """
    footer = _footer(path)
    if not _STATED.search(footer):
        return True
    stated, place = _stated(footer)
    return stated == _checksum(footer, place)


def _footer(path: Path) -> bytes:
    """The footer of a file, with its length and the four letters."""
    with path.open("rb") as file:
        file.seek(-_TAIL, 2)
        length = int.from_bytes(file.read(4), "little")
        file.seek(-_TAIL - length, 2)
        return file.read()


def _stated(footer: bytes) -> tuple[int, slice]:
    """The checksum in a footer, and where: the last match, as texts come earlier in the footer."""
    *_, last = _STATED.finditer(footer)
    return int(last[1], 16), slice(*last.span(1))


def _checksum(footer: bytes, place: slice) -> int:
    return zlib.crc32(footer[: place.start] + b"00000000" + footer[place.stop :])
