"""The first difference between two files or two folders: row, pixel, line or byte."""

import struct
from collections.abc import Iterator
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


def folder_difference(before: Path, after: Path) -> str:
    """The first file in which two folders differ, and where; empty if they are the same."""
    names = [{path.relative_to(top).as_posix() for path in _files(top)} for top in (before, after)]
    for name in sorted(names[0] | names[1]):
        for present, top in zip(names, (before, after), strict=True):
            if name not in present:
                return f"{name}: is missing in {top}"
        difference = file_difference(before / name, after / name)
        if difference:
            return f"{name}: {difference}"
    return ""


def _files(folder: Path) -> Iterator[Path]:
    # the target of a link counts as its content
    return (path for path in folder.rglob("*") if path.is_symlink() or path.is_file())


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
    return next((place for place, (one, other) in pairs if one != other), min(len(old), len(new)))


def _text_difference(old: str, new: str) -> str:
    lines = zip(old.splitlines(), new.splitlines(), strict=False)
    for number, (one, other) in enumerate(lines, start=1):
        if one != other:
            return f"line {number}: {one[:200]!r}, then {other[:200]!r}"
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
        one, other = (_column(table, name) for table in (old, new))
        same = ((one == other) | (one.isna() & other.isna())).to_numpy(bool)
        if not same.all():
            row = int(np.argmin(same))
            return f"column {name}, row {row}: {one.iloc[row]!r}, then {other.iloc[row]!r}"
    first, then = (table.schema.metadata or {} for table in (old, new))
    for key in sorted(first.keys() | then.keys()):
        if first.get(key) != then.get(key):
            place = _text_difference(*(_text(of.get(key) or b"") for of in (first, then)))
            return f"the same rows; {_text(key)} in the footer, {place}"
    return "the same rows and footer, laid out differently"


def _column(table: arrow.Table, name: str) -> "pd.Series[Any]":
    """A column; categories become plain values, so that they can be compared."""
    column = pd.Series(table[name].to_pandas())
    return column.astype(object) if isinstance(column.dtype, pd.CategoricalDtype) else column


def _text(content: bytes) -> str:
    return content.decode(errors="backslashreplace")


def _picture_difference(old: bytes, new: bytes, before: Path, after: Path) -> str:
    kept, others = _metadata_chunks(old), _metadata_chunks(new)
    for one, other in zip(kept, others, strict=False):
        if one != other:
            return f"metadata {one[:80]!r}, then {other[:80]!r}"
    if len(kept) != len(others):
        return f"{len(kept)} chunks of metadata, then {len(others)}"
    # imported here, because it takes a second
    from matplotlib.image import imread  # noqa: PLC0415

    try:
        first, then = imread(before), imread(after)
    except _DAMAGED as error:
        return f"byte {_first_byte(old, new)}; cannot be read as PNG ({error})"
    if first.shape != then.shape:
        return f"{first.shape} pixels, then {then.shape}"
    unlike = (first != then).any(axis=-1)
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


def largest_relative_differences(before: Path, after: Path) -> dict[str, float]:
    """Largest change of each numeric column of a Parquet file, relative to its largest value.

    Infinite where rows or text differ. A change relative to each single value would be dominated
    by sums that are nearly zero.
    """
    old, new = (parquet.read_table(path, partitioning=None) for path in (before, after))
    if old.column_names != new.column_names or len(old) != len(new):
        return {"": np.inf}
    changes = {
        name: _largest_change(_column(old, name), _column(new, name)) for name in old.column_names
    }
    return {name: change for name, change in changes.items() if change > 0}


def _largest_change(old: "pd.Series[Any]", new: "pd.Series[Any]") -> float:
    """Largest relative change of a column; 0 or infinite for text."""
    if old.dtype.kind != "f":
        same = ((old == new) | (old.isna() & new.isna())).to_numpy(bool)
        return 0.0 if same.all() else np.inf
    known = old.notna().to_numpy()
    if (known != new.notna().to_numpy()).any():
        return np.inf
    a, b = old.to_numpy()[known], new.to_numpy()[known]
    if not len(a):
        return 0.0
    finite = np.isfinite(a) & np.isfinite(b)
    step = np.abs(a - b, where=finite, out=np.zeros(len(a))).max()
    size = np.abs(a, where=finite, out=np.zeros(len(a))).max()
    return float(step / size) if size else float(step > 0)
