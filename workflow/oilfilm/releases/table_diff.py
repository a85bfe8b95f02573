"""The first difference between two files: row or line."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.tables.limits import UNREADABLE


def file_difference(before: Path, after: Path) -> str:
    """The first difference of two files: row and column, or line; empty if none."""
    links = [str(path.readlink()) if path.is_symlink() else "" for path in (before, after)]
    if any(links):
        return "" if links[0] == links[1] else f"links to {links[0]}, then to {links[1]}"
    old, new = before.read_bytes(), after.read_bytes()
    if old == new or not old.startswith(b"PAR1") or not new.startswith(b"PAR1"):
        return _line_difference(old, new)
    try:
        tables = (parquet.read_table(path, partitioning=None) for path in (before, after))
        return _table_difference(*tables)
    except UNREADABLE as error:
        return f"cannot be read ({error})"


def _line_difference(old: bytes, new: bytes) -> str:
    lines = zip(old.splitlines(), new.splitlines(), strict=False)
    for number, (before, after) in enumerate(lines, start=1):
        if before != after:
            return f"line {number}: {before[:200]!r}, then {after[:200]!r}"
    return "" if old == new else f"{len(old)} bytes, then {len(new)}"


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
    footers = [table.schema.metadata or {} for table in (old, new)]
    for key in sorted(footers[0].keys() | footers[1].keys()):
        if difference := _line_difference(*(footer.get(key, b"") for footer in footers)):
            return f"the same rows; {key.decode()} in the footer, {difference}"
    return "the same rows and footer, laid out differently"
