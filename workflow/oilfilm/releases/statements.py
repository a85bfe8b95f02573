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
# Columns that say from which log a row is. `diff` compares the logs themselves.
_SOURCE_COLUMNS = frozenset({"sha256", "content_sha256", "file", "first_row", "last_row"})
# Names of columns that say how sure another column is, or how large a change must be to be seen.
_ERROR_COLUMN = re.compile(r"(_se|standard_error|_uncertainty|half_width)$|^seen_")
# In a sentence: a count of a total (`33 of 75`), or any other number.
_COUNT_OR_NUMBER = re.compile(r"\d+ of \d+|[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# The line below the head of a table, which is as long as the longest number.
_TABLE_RULE = re.compile(r"-{3,}")
# Names of columns with the lower end of an interval.
_LOWER_COLUMN = re.compile(r"(^|_)(lower|low)(_|$)")
_UPPER_BY_LOWER = {"lower": "upper", "low": "high"}


class Statement(NamedTuple):
    """A statement that the same table of two releases makes differently.

    Attributes:
        table_name: Name of the table.
        row_key: Key of the row, as text.
        column_name: Name of the column; empty where one of the tables lacks the row.
        before: First value, as text.
        after: Second value.
        changes_with_logs: Whether it is about a row or a count: these change where logs are added.
    """

    table_name: str
    row_key: str
    column_name: str
    before: str
    after: str
    changes_with_logs: bool


def changed_statements(
    read_before: ReadTable, read_after: ReadTable, error_change: float
) -> Iterator[Statement]:
    """Every statement that differs, of the tables that two releases both have.

    Texts, lists, flags, counts, and what is null must be equal. An error and the width of an
    interval may differ by a share.

    Args:
        read_before: Reads a table of the first release; a pin keeps only some of them.
        read_after: Reads a table of the second.
        error_change: Largest change of an error or width, relative to the first.
    """
    studies.declare_tables(studies.available())
    for table_name, table in sorted(tables.TABLES.items()):
        if not table.key:
            continue
        table_before = read_before(table_name)
        table_after = read_after(table_name)
        if table_before is None or table_after is None:
            continue
        key_columns = list(table.key)
        table_before = table_before.set_index(key_columns)
        table_after = table_after.set_index(key_columns)
        yield from _statements_on_rows(table_name, table_before.index, table_after.index)
        common_keys = table_before.index.intersection(table_after.index, sort=False)
        table_before = table_before.loc[common_keys]
        table_after = table_after.loc[common_keys]
        columns = [
            column
            for column in table.columns
            if column.name in table_before and column.name in table_after
        ]
        for column in columns:
            if column.name not in _SOURCE_COLUMNS:
                is_changed = _is_changed(column, table_before, table_after, error_change)
                yield from _statements_of_column(
                    table_name, column, table_before, table_after, is_changed
                )


def _statements_on_rows(
    table_name: str, keys_before: pd.Index, keys_after: pd.Index
) -> Iterator[Statement]:
    """A statement on each row that only one of two tables has."""
    for keys, text_before, text_after in (
        (keys_before.difference(keys_after), "a row", "no row"),
        (keys_after.difference(keys_before), "no row", "a row"),
    ):
        for key in keys[:_MOST_ROWS]:
            yield Statement(
                table_name, _key_text(key), "", text_before, text_after, changes_with_logs=True
            )
        if len(keys) > _MOST_ROWS:
            count_of_rest = f"{len(keys) - _MOST_ROWS} more rows"
            yield Statement(
                table_name, count_of_rest, "", text_before, text_after, changes_with_logs=True
            )


def _is_changed(
    column: Column, table_before: pd.DataFrame, table_after: pd.DataFrame, error_change: float
) -> pd.Series:
    """Whether each row states something else in a column.

    Args:
        column: The column.
        table_before: The first table.
        table_after: The second, with the same rows in the same order.
        error_change: As in `changed_statements`.
    """
    values_before = table_before[column.name]
    values_after = table_after[column.name]
    is_null = values_before.isna()
    null_differs = is_null != values_after.isna()
    if column.type != "number":
        return null_differs | (
            ~is_null & (values_before.astype(object) != values_after.astype(object))
        )
    if _ERROR_COLUMN.search(column.name):
        return null_differs | _moved_too_far(values_before, values_after, error_change)
    upper_column = _upper_end(column.name)
    if upper_column in table_before and upper_column in table_after:
        size_of_ends = np.maximum(
            table_before[upper_column].abs().to_numpy(), values_before.abs().to_numpy()
        )
        width_before = table_before[upper_column] - values_before
        width_after = table_after[upper_column] - values_after
        return null_differs | _moved_too_far(width_before, width_after, error_change, size_of_ends)
    return null_differs


def _moved_too_far(
    values_before: pd.Series,
    values_after: pd.Series,
    share: float,
    size_of_terms: FloatArray | float = 0.0,
) -> pd.Series:
    """Whether each error or width has moved by more than a share of its first value.

    Args:
        values_before: First values.
        values_after: Second values, of the same rows.
        share: The largest change that counts as none.
        size_of_terms: Size of the terms where the values are differences.
    """
    with np.errstate(invalid="ignore"):
        size_of_change = (values_after - values_before).abs()
    differs = exceeds(size_of_change, share * values_before.abs(), size_of_terms)
    one_is_infinite = np.isinf(values_before) != np.isinf(values_after)
    return pd.Series(differs | one_is_infinite, index=values_before.index)


def _upper_end(name: str) -> str:
    """The column with the upper end of an interval, from that of its lower end; else empty."""
    match = _LOWER_COLUMN.search(name)
    if match is None:
        return ""
    start, end = match.span(2)
    return name[:start] + _UPPER_BY_LOWER[match[2]] + name[end:]


def _statements_of_column(
    table_name: str,
    column: Column,
    table_before: pd.DataFrame,
    table_after: pd.DataFrame,
    is_changed: pd.Series,
) -> Iterator[Statement]:
    """A statement on each changed row of a column; that on a lower end has the upper end, too."""
    is_count = column.type == "integer"
    upper_column = _upper_end(column.name)
    row_indices = np.flatnonzero(is_changed.to_numpy()).tolist()
    for row_index in row_indices[:_MOST_ROWS]:
        texts = []
        for table in (table_before, table_after):
            text = _value_text(table[column.name].iloc[row_index])
            if upper_column in table:
                text = f"{text} to {_value_text(table[upper_column].iloc[row_index])}"
            texts.append(text)
        row_key = _key_text(table_before.index[row_index])
        yield Statement(table_name, row_key, column.name, texts[0], texts[1], is_count)
    if len(row_indices) > _MOST_ROWS:
        count_of_rest = f"{len(row_indices) - _MOST_ROWS} more rows"
        yield Statement(table_name, count_of_rest, column.name, "", "", is_count)


def _key_text(key: object) -> str:
    """The key of a row as text."""
    return ", ".join(map(str, key)) if isinstance(key, tuple) else str(key)


def _value_text(value: object) -> str:
    """A value of a table as text."""
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
    compared_before = list(before)
    compared_after = list(after)
    if not with_numbers:
        compared_before = list(map(_without_numbers, compared_before))
        compared_after = list(map(_without_numbers, compared_after))
    matcher = SequenceMatcher(a=compared_before, b=compared_after, autojunk=False)
    for kind_of_change, first_old, last_old, first_new, last_new in matcher.get_opcodes():
        if kind_of_change == "equal":
            continue
        yield from (("A", line) for line in before[first_old:last_old])
        yield from (("B", line) for line in after[first_new:last_new])


def _without_numbers(line: str) -> str:
    """A line with `#` in place of each number that is no count, without the widths of columns."""
    marked_line = _COUNT_OR_NUMBER.sub(lambda match: match[0] if " of " in match[0] else "#", line)
    return " ".join(_TABLE_RULE.sub("---", marked_line).split())
