"""The first difference between two files: row, line or byte."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.tables.limits import UNREADABLE


def file_difference(before: Path, after: Path) -> str:
    """The first difference of two files: row and column, line or byte; empty if none."""
    links = [str(path.readlink()) if path.is_symlink() else "" for path in (before, after)]
    if any(links):
        return "" if links[0] == links[1] else f"links to {links[0]}, then to {links[1]}"
    old, new = before.read_bytes(), after.read_bytes()
    if old == new:
        return ""
    try:
        if old.startswith(b"PAR1") and new.startswith(b"PAR1"):
            tables = (parquet.read_table(path, partitioning=None) for path in (before, after))
            return _table_difference(*tables)
    except UNREADABLE as error:
        return f"cannot be read ({error})"
    try:
        return _text_difference(old.decode(), new.decode())
    except UnicodeDecodeError:
        pairs = enumerate(zip(old, new, strict=False))
        return f"byte {next((at for at, (a, b) in pairs if a != b), min(len(old), len(new)))}"


def _text_difference(old: str, new: str) -> str:
    lines = zip(old.splitlines(), new.splitlines(), strict=False)
    for number, (before, after) in enumerate(lines, start=1):
        if before != after:
            return f"line {number}: {before[:200]!r}, then {after[:200]!r}"
    return f"{len(old)} letters, then {len(new)}"


def _table_difference(old: arrow.Table, new: arrow.Table) -> str:
    if old.column_names != new.column_names:
        return f"columns {old.column_names}, then {new.column_names}"
    if len(old) != len(new):
        return f"{len(old)} rows, then {len(new)}"
    for name in old.column_names:
        # categories become plain values, so that they can be compared
        first, then = (pd.Series(table[name].to_pandas()).astype(object) for table in (old, new))
        same = ((first == then) | (first.isna() & then.isna())).to_numpy(bool)
        if not same.all():
            row = int(np.argmin(same))
            return f"column {name}, row {row}: {first.iloc[row]!r}, then {then.iloc[row]!r}"
    footers = [_footer(table) for table in (old, new)]
    for key in sorted(footers[0].keys() | footers[1].keys()):
        texts = [footer.get(key, "") for footer in footers]
        if texts[0] != texts[1]:
            return f"the same rows; {key} in the footer, {_text_difference(*texts)}"
    return "the same rows and footer, laid out differently"


def _footer(table: arrow.Table) -> dict[str, str]:
    content: dict[bytes, bytes] = table.schema.metadata or {}
    return {key.decode(): text.decode(errors="backslashreplace") for key, text in content.items()}
