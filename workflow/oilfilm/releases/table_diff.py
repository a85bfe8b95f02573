"""Where two files, or two folders, begin to differ."""

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
# What a reader of pictures raises where one is broken, or far too large.
_DAMAGED = (OSError, SyntaxError, ValueError, Image.DecompressionBombError)


def first_difference(before: Path, after: Path) -> str:
    """The first file in which two folders differ and the place in it; empty where none does."""
    names = [{path.relative_to(top).as_posix() for path in _files(top)} for top in (before, after)]
    for name in sorted(names[0] | names[1]):
        for found, top in zip(names, (before, after), strict=True):
            if name not in found:
                return f"{name}: is missing in {top}"
        place = difference(before / name, after / name)
        if place:
            return f"{name}: {place}"
    return ""


def _files(folder: Path) -> Iterator[Path]:
    # where a link leads is what it holds
    return (path for path in folder.rglob("*") if path.is_symlink() or path.is_file())


def difference(before: Path, after: Path) -> str:
    """Where two files begin to differ: row and column, pixel, line or byte; else empty."""
    if before.is_symlink() or after.is_symlink():
        leads = [path.readlink() if path.is_symlink() else "nowhere" for path in (before, after)]
        return "" if leads[0] == leads[1] else f"leads to {leads[0]}, then to {leads[1]}"
    old, new = before.read_bytes(), after.read_bytes()
    if old == new:
        return ""
    if old.startswith(b"PAR1") and new.startswith(b"PAR1"):
        return _of_tables(before, after)
    if old.startswith(_PNG) and new.startswith(_PNG):
        return _of_pictures(old, new, before, after)
    try:
        return _of_texts(old.decode(), new.decode())
    except UnicodeDecodeError:
        return f"byte {_first(old, new)}"


def _first(old: bytes, new: bytes) -> int:
    pairs = enumerate(zip(old, new, strict=False))
    return next((place for place, (one, other) in pairs if one != other), min(len(old), len(new)))


def _of_texts(old: str, new: str) -> str:
    lines = zip(old.splitlines(), new.splitlines(), strict=False)
    for number, (one, other) in enumerate(lines, start=1):
        if one != other:
            return f"line {number}: {one[:200]!r}, then {other[:200]!r}"
    return f"{len(old)} letters, then {len(new)}"


def _of_tables(before: Path, after: Path) -> str:
    try:
        return _of_read_tables(*(parquet.read_table(x, partitioning=None) for x in (before, after)))
    except (OSError, ValueError, arrow.ArrowException) as error:
        return f"cannot be read as Parquet ({error})"


def _of_read_tables(old: arrow.Table, new: arrow.Table) -> str:
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
            place = _of_texts(*(_text(of.get(key) or b"") for of in (first, then)))
            return f"the same rows; {_text(key)} in the footer, {place}"
    return "the same rows and footer, laid out otherwise"


def _column(table: arrow.Table, name: str) -> "pd.Series[Any]":
    """A column; categories as plain values, which compare whatever others there are."""
    column = pd.Series(table[name].to_pandas())
    return column.astype(object) if isinstance(column.dtype, pd.CategoricalDtype) else column


def _text(content: bytes) -> str:
    return content.decode(errors="backslashreplace")


def _of_pictures(old: bytes, new: bytes, before: Path, after: Path) -> str:
    kept, others = _said(old), _said(new)
    for one, other in zip(kept, others, strict=False):
        if one != other:
            return f"metadata {one[:80]!r}, then {other[:80]!r}"
    if len(kept) != len(others):
        return f"{len(kept)} chunks of metadata, then {len(others)}"
    # drawn with what drew them; imported late, because it takes a second
    from matplotlib.image import imread  # noqa: PLC0415

    try:
        first, then = imread(before), imread(after)
    except _DAMAGED as error:
        return f"byte {_first(old, new)}; cannot be read as PNG ({error})"
    if first.shape != then.shape:
        return f"{first.shape} pixels, then {then.shape}"
    unlike = (first != then).any(axis=-1)
    if not unlike.any():
        return "the same pixels, compressed otherwise"
    line, column = np.unravel_index(int(np.argmax(unlike)), unlike.shape)
    return f"{int(unlike.sum())} pixels, the first at line {line}, column {column}"


def _said(content: bytes) -> list[bytes]:
    """What a PNG says beside its pixels: kind and data of each chunk."""
    found = []
    place = len(_PNG)
    while place + 8 <= len(content):
        size, kind = struct.unpack(">I4s", content[place : place + 8])
        if kind != b"IDAT":
            found.append(kind + b" " + content[place + 8 : place + 8 + size])
        place += size + 12
    return found


def largest_relative_differences(before: Path, after: Path) -> dict[str, float]:
    """How far the numbers of a Parquet file move, by column, relative to the column's largest.

    Infinite where rows or text differ. Relative to each value itself a sum that is nearly zero
    would decide.
    """
    old, new = (parquet.read_table(path, partitioning=None) for path in (before, after))
    if old.column_names != new.column_names or len(old) != len(new):
        return {"": np.inf}
    found = {}
    for name in old.column_names:
        one, other = (_column(table, name) for table in (old, new))
        if one.dtype.kind == "f":
            known = one.notna().to_numpy()
            if (known != other.notna().to_numpy()).any():
                found[name] = np.inf
            elif known.any():
                a, b = one.to_numpy()[known], other.to_numpy()[known]
                finite = np.isfinite(a) & np.isfinite(b)
                step = np.abs(a - b, where=finite, out=np.zeros(len(a))).max()
                size = np.abs(a, where=finite, out=np.zeros(len(a))).max()
                found[name] = float(step / size) if size else float(step > 0)
        else:
            same = ((one == other) | (one.isna() & other.isna())).to_numpy(bool)
            found[name] = 0.0 if same.all() else np.inf
    return {name: value for name, value in found.items() if value > 0}
