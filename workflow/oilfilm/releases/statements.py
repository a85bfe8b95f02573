"""What two releases state differently: verdicts, codes, counts, errors, nulls, and sentences.

Constants and traction have limits of their own (`compare.py`). Measured and computed values may
move with them. A statement about these values may not: whether a fit is certified, how wide an
interval is, which value is not known.

Decides: which columns of a table are statements, and when a sentence is another one.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base import studies
from oilfilm.base.ties import exceeds
from oilfilm.base.units import FloatArray
from oilfilm.tables.dictionary import Column

# Reads a table by its name; None where there is none.
ReadTable = Callable[[str], pd.DataFrame | None]
# Changed rows of one column that are listed one by one.
_MOST_ROWS = 20
# Columns that say what a run was made from. `diff` compares the logs themselves.
_SOURCES = frozenset({"sha256", "content_sha256", "file", "first_row", "last_row"})
# Numbers that say how sure another number is.
_ERROR = re.compile(r"(_se|standard_error|_uncertainty|half_width)$")
# A count of all, and any other number of a sentence.
_COUNT_OR_NUMBER = re.compile(r"\d+ of \d+|[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# Ends of an interval, by the ends of their names.
_LOWER = re.compile(r"(^|_)(lower|low)(_|$)")
_UPPER_BY_LOWER = {"lower": "upper", "low": "high"}


class Statement(NamedTuple):
    """A statement of a table that two results have differently.

    Attributes:
        table: Name of the table.
        row: Key of the row.
        column: Name of the column; empty where one of the tables lacks the row.
        before: First value, as text.
        after: Second value.
        counts_data: Whether it changes as soon as a log is added: a row or a count.
    """

    table: str
    row: str
    column: str
    before: str
    after: str
    counts_data: bool


def changed_statements(
    read_before: ReadTable, read_after: ReadTable, error_change: float
) -> Iterator[Statement]:
    """Every statement of a table that is in both of two results and differs.

    Texts, lists, flags, counts, and what is null must be equal. An error and the width of an
    interval may differ by a share.

    Args:
        read_before: Gives the tables of the first; a pin keeps some of them.
        read_after: Gives those of the second.
        error_change: Largest change of an error or width, relative to the first.
    """
    studies.declare_tables(studies.available())
    for name, table in sorted(tables.TABLES.items()):
        if not table.key:
            continue
        old, new = read_before(name), read_after(name)
        if old is None or new is None:
            continue
        keys = list(table.key)
        old, new = old.set_index(keys), new.set_index(keys)
        yield from _rows_of_one_table(name, old.index, new.index)
        common_rows = old.index.intersection(new.index, sort=False)
        old, new = old.loc[common_rows], new.loc[common_rows]
        columns = [column for column in table.columns if column.name in old and column.name in new]
        for column in columns:
            if column.name not in _SOURCES:
                is_changed = _is_changed(column, old, new, error_change)
                yield from _statements_of_column(name, column, old, new, is_changed)


def _rows_of_one_table(name: str, old: pd.Index, new: pd.Index) -> Iterator[Statement]:
    """The rows that only one of two tables has."""
    for indices, before, after in (
        (old.difference(new), "a row", "no row"),
        (new.difference(old), "no row", "a row"),
    ):
        for index in indices[:_MOST_ROWS]:
            yield Statement(name, _row_name(index), "", before, after, counts_data=True)
        if len(indices) > _MOST_ROWS:
            count_of_rest = f"{len(indices) - _MOST_ROWS} more rows"
            yield Statement(name, count_of_rest, "", before, after, counts_data=True)


def _is_changed(
    column: Column, old: pd.DataFrame, new: pd.DataFrame, error_change: float
) -> pd.Series:
    """Which rows state something else in a column."""
    before, after = old[column.name], new[column.name]
    is_null = before.isna()
    null_differs = is_null != after.isna()
    if column.type != "number":
        return null_differs | (~is_null & (before.astype(object) != after.astype(object)))
    if _ERROR.search(column.name):
        return null_differs | _moved_too_far(before, after, error_change)
    upper = _upper_end(column.name)
    if upper in old and upper in new:
        size = np.maximum(old[upper].abs().to_numpy(), before.abs().to_numpy())
        width_before, width_after = old[upper] - before, new[upper] - after
        return null_differs | _moved_too_far(width_before, width_after, error_change, size)
    return null_differs


def _moved_too_far(
    before: pd.Series, after: pd.Series, share: float, size_of_terms: FloatArray | float = 0.0
) -> pd.Series:
    """Where an error or a width has moved by more than a share of its first value.

    Args:
        before: First values.
        after: Second values, of the same rows.
        share: The largest change that counts as none.
        size_of_terms: Size of the terms where the values are differences.
    """
    with np.errstate(invalid="ignore"):
        size_of_change = (after - before).abs()
    differs = exceeds(size_of_change, share * before.abs(), size_of_terms)
    one_is_infinite = np.isinf(before) != np.isinf(after)
    return pd.Series(differs | one_is_infinite, index=before.index)


def _upper_end(name: str) -> str:
    """The column with the upper end of the interval of which a column has the lower; else ""."""
    match = _LOWER.search(name)
    if match is None:
        return ""
    start, end = match.span(2)
    return name[:start] + _UPPER_BY_LOWER[match[2]] + name[end:]


def _statements_of_column(
    table: str, column: Column, old: pd.DataFrame, new: pd.DataFrame, is_changed: pd.Series
) -> Iterator[Statement]:
    """The changed rows of a column; of the lower end of an interval its whole width."""
    is_count = column.type == "integer"
    upper = _upper_end(column.name)
    positions = np.flatnonzero(is_changed.to_numpy()).tolist()
    for position in positions[:_MOST_ROWS]:
        values = []
        for frame in (old, new):
            value = _text(frame[column.name].iloc[position])
            if upper in frame:
                value = f"{value} to {_text(frame[upper].iloc[position])}"
            values.append(value)
        row = _row_name(old.index[position])
        yield Statement(table, row, column.name, values[0], values[1], is_count)
    if len(positions) > _MOST_ROWS:
        count_of_rest = f"{len(positions) - _MOST_ROWS} more rows"
        yield Statement(table, count_of_rest, column.name, "", "", is_count)


def _row_name(index: object) -> str:
    return ", ".join(map(str, index)) if isinstance(index, tuple) else str(index)


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(value) or "none"
    if value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value)):
        return "null"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


# ---------------------------------------------------------------- sentences


def changed_lines(
    before: Sequence[str], after: Sequence[str], *, with_numbers: bool = True
) -> Iterator[tuple[str, str]]:
    """The lines of two texts that differ, each after the name of its text, `A` or `B`.

    Args:
        before: Lines of the first text.
        after: Lines of the second.
        with_numbers: Whether a line with other numbers is another line. Without them words and
            counts ("33 of 75") are compared.
    """
    old, new = list(before), list(after)
    if not with_numbers:
        old, new = list(map(_without_numbers, old)), list(map(_without_numbers, new))
    matcher = SequenceMatcher(a=old, b=new, autojunk=False)
    for kind_of_change, first_old, last_old, first_new, last_new in matcher.get_opcodes():
        if kind_of_change == "equal":
            continue
        yield from (("A", line) for line in before[first_old:last_old])
        yield from (("B", line) for line in after[first_new:last_new])


def _without_numbers(line: str) -> str:
    """A line with `#` in place of each number that is no count; runs of blanks are one blank."""
    marked_line = _COUNT_OR_NUMBER.sub(lambda match: match[0] if " of " in match[0] else "#", line)
    return " ".join(marked_line.split())
