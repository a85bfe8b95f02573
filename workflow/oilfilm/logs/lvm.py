"""LabVIEW's text logs (LVM): a header, then segments with a header of their own and rows.

Each segment is a run.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from oilfilm.base.plain_key import plain_key
from oilfilm.logs.base import Refusal, TextDialect, UnreadableLogError, check_text_size
from oilfilm.logs.header import FORMAT_ADVICE, header_of_part, joined_texts
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import Clock, LoggedTable, TablesOfFile
from oilfilm.logs.text_rows import TextTable, encoding_of, normalised

_TITLE = b"LabVIEW Measurement"
# Name of a column with the time of the channels behind it.
_X_COLUMN = "X_Value"
_COMMENT = "Comment"
_END_OF_HEADER = "***End_of_Header***"
_SEPARATOR = re.compile(r"^Separator(.)", re.MULTILINE)
# Statements of a description or a note. A comma between two digits is a decimal mark.
_BETWEEN_STATEMENTS = re.compile(r";|,(?!\d)|(?<!\d),")
# The line `Separator` is near the top.
_CHARACTERS_SEARCHED = 4000
# NumPy reads nine decimals of a second, and LabVIEW writes up to twenty.
_CHARACTERS_OF_CLOCK_TIME = len("16:29:04.819098472")
# Key of a header line, as `plain_key` makes it -> the cells behind it.
CellsOfKey = dict[str, list[str]]


@dataclass(frozen=True)
class _Marks:
    """The characters between cells and between whole numbers and decimals."""

    separator: str
    decimal_mark: str


def recognises(first_bytes: bytes) -> bool:
    """True for text that begins with the title of LVM."""
    return normalised(first_bytes).lstrip(b" \t\n").startswith(_TITLE)


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    check_text_size(content)
    encoding = encoding_of(content)
    text = normalised(content, encoding).decode("utf-8", "replace")
    separator_line = _SEPARATOR.search(text[:_CHARACTERS_SEARCHED])
    separator = separator_line[1] if separator_line else "\t"
    lines = text.removesuffix("\n").split("\n")
    start_line_indices = [
        line_index
        for line_index, line in enumerate(lines)
        if line.split(separator, 1)[0] == "Channels"
    ]
    if not start_line_indices:
        reason = "the header does not end: no segment with a line `Channels` follows it"
        raise UnreadableLogError(reason, f"Export it again. {FORMAT_ADVICE}")
    file_header = _cells_of_header_lines(lines[: start_line_indices[0]], separator)
    decimal_mark = "," if _first_cell(file_header, "decimal_separator", ".") == "," else "."
    marks = _Marks(separator, decimal_mark)
    logged_tables = []
    for segment_number, (start_line_index, stop_line_index) in enumerate(
        pairwise([*start_line_indices, len(lines)]), start=1
    ):
        run_name = f"segment{segment_number}" if len(start_line_indices) > 1 else ""
        is_cut = stop_line_index == len(lines) and not text.endswith("\n")
        table = _table(
            lines[start_line_index:stop_line_index], file_header, marks, run_name, is_cut
        )
        if table is not None:
            logged_tables.append(table)
    return TextDialect.from_marks(encoding, separator, decimal_mark), logged_tables


def _cells_of_header_lines(lines: Sequence[str], separator: str) -> CellsOfKey:
    header: CellsOfKey = {}
    for line in lines:
        name, *cells = line.split(separator)
        header[plain_key(name)] = [cell.strip() for cell in cells]
    return header


def _first_cell(header: CellsOfKey, key: str, default: str) -> str:
    """The first cell of a header line; the default where it is missing or empty."""
    cells = header.get(key, [])
    return (cells[0] if cells else "") or default


def _filled_cells(header: CellsOfKey, key: str) -> list[str]:
    """The cells of a header line, without the empty ones above X columns."""
    return [cell for cell in header.get(key, []) if cell]


def _table(
    lines: Sequence[str], file_header: CellsOfKey, marks: _Marks, run_name: str, is_cut: bool
) -> LoggedTable | None:
    """A segment as a table; None without rows.

    Args:
        lines: The lines of the segment.
        file_header: Header of the file, which holds for all segments.
        marks: Characters between cells and decimals.
        run_name: Name of the run; empty where the file has one segment.
        is_cut: Whether the last line has no line end.
    """
    separator = marks.separator
    first_cells = [line.split(separator, 1)[0] for line in lines]
    has_names = _X_COLUMN in first_cells
    if has_names:
        index_of_names = first_cells.index(_X_COLUMN)
    elif _END_OF_HEADER in first_cells:
        index_of_names = first_cells.index(_END_OF_HEADER)
    else:
        return None
    row_lines = lines[index_of_names + 1 :]
    if not row_lines:
        return None
    segment_header = _cells_of_header_lines(lines[:index_of_names], separator)
    header = file_header | segment_header
    names = [cell.strip() for cell in lines[index_of_names].split(separator)] if has_names else []
    channel_units = segment_header.get("y_unit_label", [])
    units = ["", *channel_units, *[""] * len(names)][: len(names)]
    cut_row_cell_count = 0
    if is_cut:
        cut_row_cell_count = row_lines[-1].count(separator) + 1
        if names and names[-1] == _COMMENT:
            # this column need not be there
            cut_row_cell_count += 1
    text = "\n".join(_row_with_all_cells(row, len(names), separator) for row in row_lines)
    if not is_cut:
        text += "\n"
    text_table = TextTable(text.encode(), len(names), separator, marks.decimal_mark)
    clock_of_column: dict[int, Clock] = {}
    time_index_of_column: dict[int, int] = {}
    start_s_of_column: dict[int, float] = {}
    if names and _first_cell(header, "x_dimension", "Time") == "Time":
        time_unit = _first_cell(header, "x_unit_label", "s")
        start_s_of_column = _start_s_of_columns(header, names) if time_unit == "s" else {}
        if _first_cell(header, "x_columns", "One") == "No":
            clock_of_column = _clock_of_columns(header, len(names), marks.decimal_mark, time_unit)
        elif not any(start_s_of_column.values()) and _has_one_time(text_table, names):
            names = ["time", *names[1:]]
            units = [time_unit, *units[1:]]
        elif time_unit == "s":
            time_index_of_column = _time_index_of_columns(names)
    problem = None
    if not names:
        reason = f"the segment has no line `{_X_COLUMN}` with the names of its channels"
        problem = Refusal("columns", reason, FORMAT_ADVICE)
    return LoggedTable(
        header_of_part(
            joined_texts(_header_items(file_header)), joined_texts(_header_items(segment_header))
        ),
        names,
        units,
        text_table.numbers,
        len(row_lines),
        run_name,
        refusal=_too_few_rows_refusal(header, len(row_lines)),
        problem=problem,
        clock_of_column=clock_of_column,
        time_index_of_column=time_index_of_column,
        start_s_of_column=start_s_of_column,
        cut_row_cell_count=cut_row_cell_count,
        read_texts=text_table.texts,
        decimal_mark=marks.decimal_mark,
    )


def _has_one_time(table: TextTable, names: Sequence[str]) -> bool:
    """Whether the X columns of all channels agree, so that the first one is the time."""
    first_times, *other_times = table.numbers(
        [index for index, name in enumerate(names) if name == _X_COLUMN]
    )
    return all(np.array_equal(first_times, times, equal_nan=True) for times in other_times)


def _time_index_of_columns(names: Sequence[str]) -> dict[int, int]:
    """Index of the column of a channel -> index of the X column in front of it."""
    time_index_of_column: dict[int, int] = {}
    x_index = 0
    for index, name in enumerate(names):
        if name == _X_COLUMN:
            x_index = index
        else:
            time_index_of_column[index] = x_index
    return time_index_of_column


def _row_with_all_cells(line: str, cell_count: int, separator: str) -> str:
    """A row with one cell per name: a comment may be missing, empty cells too many."""
    missing_cell_count = cell_count - 1 - line.count(separator)
    if missing_cell_count >= 0:
        return line + missing_cell_count * separator
    cells = line.split(separator)
    surplus_is_empty = not any(cell.strip() for cell in cells[cell_count:])
    return separator.join(cells[:cell_count]) if surplus_is_empty else line


def _too_few_rows_refusal(header: CellsOfKey, row_count: int) -> Refusal | None:
    """A refusal if a segment has fewer rows than its header announces."""
    counts = [
        int(cell)
        for cell in header.get("samples", [])
        if cell.isascii() and cell.isdecimal() and len(cell) < 12
    ]
    announced_count = max(counts, default=0)
    if announced_count <= row_count:
        return None
    sentence = f"the segment announces {announced_count} samples and holds {row_count}"
    return Refusal("truncated", sentence)


def _clock_of_columns(
    header: CellsOfKey, column_count: int, decimal_mark: str, unit: str
) -> dict[int, Clock]:
    """Index of a column -> clock of its channel, where the header has the interval.

    Args:
        header: Header of the segment.
        column_count: Number of columns; the first is none of a channel.
        decimal_mark: Decimal mark of the header.
        unit: Unit of the time.
    """

    def number_in_header(key: str, channel_index: int) -> float:
        try:
            return float(header[key][channel_index].replace(decimal_mark, "."))
        except (KeyError, IndexError, ValueError):
            return np.nan

    clock_of_column: dict[int, Clock] = {}
    for column_index in range(1, column_count):
        interval = number_in_header("delta_x", column_index - 1)
        start = float(np.nan_to_num(number_in_header("x0", column_index - 1)))
        if np.isfinite(interval):
            clock_of_column[column_index] = Clock(start, interval, unit)
    return clock_of_column


def _start_s_of_columns(header: CellsOfKey, names: Sequence[str]) -> dict[int, float]:
    """Index of the column of a channel -> its start after that of the first channel, in s.

    Times are relative to the date and time of their channel, unless the header says that they are
    absolute. A header with fewer dates and times than channels has one start for all if these
    agree; else the start of no channel is known (NaN).

    Source: NI, Specification for the LabVIEW Measurement File, tags Date, Time and Time_Pref.

    Args:
        header: Header of the segment and the file.
        names: Names of the columns.
    """
    channel_indices = [
        index for index, name in enumerate(names) if name not in (_X_COLUMN, _COMMENT)
    ]
    channel_count = len(channel_indices)
    dates = _filled_cells(header, "date")[:channel_count]
    clock_times = [
        cell[:_CHARACTERS_OF_CLOCK_TIME] for cell in _filled_cells(header, "time")[:channel_count]
    ]
    is_absolute = _first_cell(header, "time_pref", "Relative").lower() == "absolute"
    if is_absolute:
        return {}
    try:
        starts = [
            np.datetime64(f"{date}T{clock_time}".replace("/", "-").replace(",", "."), "ns")
            for date, clock_time in zip(dates, clock_times, strict=False)
        ]
    except ValueError:
        return {}
    if not len(dates) == len(clock_times) == channel_count:
        return dict.fromkeys(channel_indices, np.nan) if len(set(starts)) > 1 else {}
    return {
        index: float((start - starts[0]) / np.timedelta64(1, "s"))
        for index, start in zip(channel_indices, starts, strict=True)
    }


def _header_items(header: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, str]]:
    """Header keys: each line is one; `description` and `notes` may hold `key: value` texts."""
    for name, cells in header.items():
        if cells and cells[0]:
            yield name, cells[0]
    for text in (*header.get("description", ()), *header.get("notes", ())):
        for statement in _BETWEEN_STATEMENTS.split(text):
            name, mark, value = statement.partition(":" if ":" in statement else "=")
            if mark:
                yield plain_key(name), value.strip()
