"""The first difference between two files: row, pixel, line or byte."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.parquet as parquet
from PIL import Image

_PNG = b"\x89PNG\r\n\x1a\n"
# Errors of the picture reader for a broken or far too large file.
_DAMAGED = (OSError, SyntaxError, ValueError, Image.DecompressionBombError)


def file_difference(before: Path, after: Path) -> str:
    """The first difference of two files: row and column, pixel, line or byte; empty if none."""
    if before.is_symlink() or after.is_symlink():
        targets = [path.readlink() if path.is_symlink() else "nowhere" for path in (before, after)]
        return "" if targets[0] == targets[1] else f"links to {targets[0]}, then to {targets[1]}"
    old, new = before.read_bytes(), after.read_bytes()
    if old == new:
        return ""
    if old.startswith(b"PAR1") and new.startswith(b"PAR1"):
        return _table_difference(before, after)
    if old.startswith(_PNG) and new.startswith(_PNG):
        return _picture_difference(old, new, before, after)
    try:
        return _text_difference(old.decode(), new.decode())
    except UnicodeDecodeError:
        return f"byte {_first_byte(old, new)}"


def _first_byte(old: bytes, new: bytes) -> int:
    pairs = enumerate(zip(old, new, strict=False))
    return next((index for index, (a, b) in pairs if a != b), min(len(old), len(new)))


def _text_difference(old: str, new: str) -> str:
    lines = zip(old.splitlines(), new.splitlines(), strict=False)
    for number, (before, after) in enumerate(lines, start=1):
        if before != after:
            return f"line {number}: {before[:200]!r}, then {after[:200]!r}"
    return f"{len(old)} letters, then {len(new)}"


def _table_difference(before: Path, after: Path) -> str:
    try:
        return _read_tables_difference(
            *(parquet.read_table(x, partitioning=None) for x in (before, after))
        )
    except (OSError, ValueError, arrow.ArrowException) as error:
        return f"cannot be read as Parquet ({error})"


def _read_tables_difference(old: arrow.Table, new: arrow.Table) -> str:
    if old.column_names != new.column_names:
        return f"columns {old.column_names}, then {new.column_names}"
    if len(old) != len(new):
        return f"{len(old)} rows, then {len(new)}"
    for name in old.column_names:
        before, after = (_column(table, name) for table in (old, new))
        same = ((before == after) | (before.isna() & after.isna())).to_numpy(bool)
        if not same.all():
            row = int(np.argmin(same))
            return f"column {name}, row {row}: {before.iloc[row]!r}, then {after.iloc[row]!r}"
    first, then = (table.schema.metadata or {} for table in (old, new))
    for key in sorted(first.keys() | then.keys()):
        if first.get(key) != then.get(key):
            line = _text_difference(*(_text(of.get(key) or b"") for of in (first, then)))
            return f"the same rows; {_text(key)} in the footer, {line}"
    return "the same rows and footer, laid out differently"


def _column(table: arrow.Table, name: str) -> "pd.Series[Any]":
    """A column; categories become plain values, so that they can be compared."""
    column = pd.Series(table[name].to_pandas())
    return column.astype(object) if isinstance(column.dtype, pd.CategoricalDtype) else column


def _text(content: bytes) -> str:
    return content.decode(errors="backslashreplace")


def _picture_difference(old: bytes, new: bytes, before: Path, after: Path) -> str:
    old_chunks, new_chunks = _metadata_chunks(old), _metadata_chunks(new)
    for first, then in zip(old_chunks, new_chunks, strict=False):
        if first != then:
            return f"metadata {first[:80]!r}, then {then[:80]!r}"
    if len(old_chunks) != len(new_chunks):
        return f"{len(old_chunks)} chunks of metadata, then {len(new_chunks)}"
    # imported here, because it takes a second
    from matplotlib.image import imread  # noqa: PLC0415

    try:
        pixels, new_pixels = imread(before), imread(after)
    except _DAMAGED as error:
        return f"byte {_first_byte(old, new)}; cannot be read as PNG ({error})"
    if pixels.shape != new_pixels.shape:
        return f"{pixels.shape} pixels, then {new_pixels.shape}"
    unlike = (pixels != new_pixels).any(axis=-1)
    if not unlike.any():
        return "the same pixels, compressed differently"
    line, column = np.unravel_index(int(np.argmax(unlike)), unlike.shape)
    return f"{int(unlike.sum())} pixels, the first at line {line}, column {column}"


def _metadata_chunks(content: bytes) -> list[bytes]:
    """Metadata of a PNG: kind and data of each chunk except the pixels."""
    chunks = []
    start = len(_PNG)
    while start + 8 <= len(content):
        size, kind = struct.unpack(">I4s", content[start : start + 8])
        if kind != b"IDAT":
            chunks.append(kind + b" " + content[start + 8 : start + 8 + size])
        start += size + 12
    return chunks
