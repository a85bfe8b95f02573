"""The first difference between two files: row, pixel, line or byte."""

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
        return _picture_difference(before, after)
    try:
        return _text_difference(old.decode(), new.decode())
    except UnicodeDecodeError:
        pairs = enumerate(zip(old, new, strict=False))
        first = next((index for index, (a, b) in pairs if a != b), min(len(old), len(new)))
        return f"byte {first}"


def _text_difference(old: str, new: str) -> str:
    lines = zip(old.splitlines(), new.splitlines(), strict=False)
    for number, (before, after) in enumerate(lines, start=1):
        if before != after:
            return f"line {number}: {before[:200]!r}, then {after[:200]!r}"
    return f"{len(old)} letters, then {len(new)}"


def _table_difference(before: Path, after: Path) -> str:
    try:
        old, new = (parquet.read_table(path, partitioning=None) for path in (before, after))
    except (OSError, ValueError, arrow.ArrowException) as error:
        return f"cannot be read as Parquet ({error})"
    if old.column_names != new.column_names:
        return f"columns {old.column_names}, then {new.column_names}"
    if len(old) != len(new):
        return f"{len(old)} rows, then {len(new)}"
    for name in old.column_names:
        first, then = (_column(table, name) for table in (old, new))
        same = ((first == then) | (first.isna() & then.isna())).to_numpy(bool)
        if not same.all():
            row = int(np.argmin(same))
            return f"column {name}, row {row}: {first.iloc[row]!r}, then {then.iloc[row]!r}"
    footers = [table.schema.metadata or {} for table in (old, new)]
    for key in sorted(footers[0].keys() | footers[1].keys()):
        texts = [_text(footer.get(key) or b"") for footer in footers]
        if texts[0] != texts[1]:
            return f"the same rows; {_text(key)} in the footer, {_text_difference(*texts)}"
    return "the same rows and footer, laid out differently"


def _column(table: arrow.Table, name: str) -> "pd.Series[Any]":
    """A column; categories become plain values, so that they can be compared."""
    column = pd.Series(table[name].to_pandas())
    return column.astype(object) if isinstance(column.dtype, pd.CategoricalDtype) else column


def _text(content: bytes) -> str:
    return content.decode(errors="backslashreplace")


def _picture_difference(before: Path, after: Path) -> str:
    try:
        with Image.open(before) as old, Image.open(after) as new:
            if old.info != new.info:
                return f"metadata {old.info!r:.80}, then {new.info!r:.80}"
            pixels, new_pixels = np.asarray(old), np.asarray(new)
    except _DAMAGED as error:
        return f"cannot be read as PNG ({error})"
    if pixels.shape != new_pixels.shape:
        return f"{pixels.shape} pixels, then {new_pixels.shape}"
    unlike = (pixels != new_pixels).any(axis=-1)
    if not unlike.any():
        return "the same pixels, compressed differently"
    line, column = np.unravel_index(int(np.argmax(unlike)), unlike.shape)
    return f"{int(unlike.sum())} pixels, the first at line {line}, column {column}"
