"""LabVIEW's text logs (LVM): a header, then segments with a header of their own and rows.

Each segment is a run.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from oilfilm.base.plain_key import plain_key
from oilfilm.logs.base import Refusal, TextForm, UnreadableLogError, check_lines
from oilfilm.logs.header import FORMAT_ADVICE
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.logs.logged_table import Clock, LoggedTable, TablesOfFile
from oilfilm.logs.text_rows import TextTable, encoding_of, normalise

_TITLE = b"LabVIEW Measurement"
# Name of the column that is the time of the channels behind it.
_X_COLUMN = "X_Value"
_COMMENT = "Comment"
_END_OF_HEADER = "***End_of_Header***"
_SEPARATOR = re.compile(r"^Separator(.)", re.MULTILINE)
# The line `Separator` is near the top.
_LETTERS_SEARCHED = 4000
# Name of a header line -> the cells behind it.
Header = dict[str, list[str]]


@dataclass(frozen=True)
class _Marks:
    """The characters between cells and between whole numbers and decimals."""

    separator: str
    decimal: str


def recognises(head: bytes) -> bool:
    """True for text that begins with the title of LVM."""
    return normalise(head).lstrip(b" \t\n").startswith(_TITLE)


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `Reader.tables`."""
    check_lines(content)
    encoding = encoding_of(content)
    text = normalise(content, encoding).decode("utf-8", "replace")
    separator_line = _SEPARATOR.search(text[:_LETTERS_SEARCHED])
    separator = separator_line[1] if separator_line else "\t"
    lines = text.removesuffix("\n").split("\n")
    starts = [
        number for number, line in enumerate(lines) if line.split(separator, 1)[0] == "Channels"
    ]
    if not starts:
        reason = "the header does not end: no segment with a line `Channels` follows it"
        raise UnreadableLogError(reason, f"Export it again. {FORMAT_ADVICE}")
    file_header = _header(lines[: starts[0]], separator)
    decimal = "," if _first_cell(file_header, "decimal_separator", ".") == "," else "."
    marks = _Marks(separator, decimal)
    logged_tables = []
    for number, (start, stop) in enumerate(pairwise([*starts, len(lines)]), start=1):
        run_name = f"segment{number}" if len(starts) > 1 else ""
        is_cut = stop == len(lines) and not text.endswith("\n")
        table = _table(lines[start:stop], file_header, marks, run_name, is_cut)
        if table is not None:
            logged_tables.append(table)
    return TextForm.from_marks(encoding, separator, decimal), logged_tables


def _header(lines: Sequence[str], separator: str) -> Header:
    header: Header = {}
    for line in lines:
        name, *cells = line.split(separator)
        header[plain_key(name)] = [cell.strip() for cell in cells]
    return header


def _first_cell(header: Header, key: str, default: str) -> str:
    """The first cell of a header line; the default where it is missing or empty."""
    cells = header.get(key, [])
    return (cells[0] if cells else "") or default


def _table(
    lines: Sequence[str], file_header: Header, marks: _Marks, run_name: str, is_cut: bool
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
        line_of_names = first_cells.index(_X_COLUMN)
    elif _END_OF_HEADER in first_cells:
        line_of_names = first_cells.index(_END_OF_HEADER)
    else:
        return None
    rows = lines[line_of_names + 1 :]
    if not rows:
        return None
    segment_header = _header(lines[:line_of_names], separator)
    header = file_header | segment_header
    names = [cell.strip() for cell in lines[line_of_names].split(separator)] if has_names else []
    channel_units = segment_header.get("y_unit_label", [])
    units = ["", *channel_units, *[""] * len(names)][: len(names)]
    cut_row_cells = 0
    if is_cut:
        cut_row_cells = rows[-1].count(separator) + 1
        if names and names[-1] == _COMMENT:
            # this column need not be there
            cut_row_cells += 1
    text = "\n".join(_row(row, len(names), separator) for row in rows)
    if not is_cut:
        text += "\n"
    table = TextTable(text.encode(), len(names), separator, marks.decimal)
    clocks: dict[int, Clock] = {}
    time_column_of: dict[int, int] = {}
    started_s: dict[int, float] = {}
    if names and _first_cell(header, "x_dimension", "Time") == "Time":
        time_unit = _first_cell(header, "x_unit_label", "s")
        started_s = _start_times_s(header, names) if time_unit == "s" else {}
        if _first_cell(header, "x_columns", "One") == "No":
            clocks = _clocks(header, len(names), marks.decimal, time_unit)
        elif not any(started_s.values()) and _has_one_time(table, names):
            names = ["time", *names[1:]]
            units = [time_unit, *units[1:]]
        elif time_unit == "s":
            time_column_of = _time_columns(names)
    problem = None
    if not names:
        reason = f"the segment has no line `{_X_COLUMN}` with the names of its channels"
        problem = Refusal("columns", reason, FORMAT_ADVICE)
    return LoggedTable(
        dict(_keys(file_header)) | dict(_keys(segment_header)),
        names,
        units,
        table.numbers,
        len(rows),
        run_name,
        flaw=_too_few_rows(header, len(rows)),
        problem=problem,
        clocks=clocks,
        time_column_of=time_column_of,
        started_s=started_s,
        cut_row_cells=cut_row_cells,
        texts=table.texts,
    )


def _has_one_time(table: TextTable, names: Sequence[str]) -> bool:
    """Whether the X columns of all channels agree, so that the first one is the time."""
    first_times, *other_times = table.numbers(
        [index for index, name in enumerate(names) if name == _X_COLUMN]
    )
    return all(np.array_equal(first_times, times, equal_nan=True) for times in other_times)


def _time_columns(names: Sequence[str]) -> dict[int, int]:
    """Index of the X column in front of each channel, by the index of the channel."""
    time_column_of: dict[int, int] = {}
    x_column = 0
    for index, name in enumerate(names):
        if name == _X_COLUMN:
            x_column = index
        else:
            time_column_of[index] = x_column
    return time_column_of


def _row(line: str, width: int, separator: str) -> str:
    """A row with one cell per name: a comment may be missing, empty cells too many."""
    missing = width - 1 - line.count(separator)
    if missing >= 0:
        return line + missing * separator
    cells = line.split(separator)
    surplus_is_empty = not any(cell.strip() for cell in cells[width:])
    return separator.join(cells[:width]) if surplus_is_empty else line


def _too_few_rows(header: Header, rows: int) -> Refusal | None:
    """A flaw where a segment has fewer rows than its header announces."""
    counts = [
        int(cell)
        for cell in header.get("samples", [])
        if cell.isascii() and cell.isdecimal() and len(cell) < 12
    ]
    announced = max(counts, default=0)
    if announced <= rows:
        return None
    sentence = f"the segment announces {announced} samples and holds {rows}"
    return Refusal("truncated", sentence)


def _clocks(header: Header, width: int, decimal_mark: str, unit: str) -> dict[int, Clock]:
    """Clock of each channel whose interval the header has, by the index of its column.

    Args:
        header: Header of the segment.
        width: Number of columns; the first is none of a channel.
        decimal_mark: Decimal mark of the header.
        unit: Unit of the time.
    """

    def number_in_header(key: str, channel: int) -> float:
        try:
            return float(header[key][channel].replace(decimal_mark, "."))
        except (KeyError, IndexError, ValueError):
            return np.nan

    clocks: dict[int, Clock] = {}
    for index in range(1, width):
        interval = number_in_header("delta_x", index - 1)
        start = float(np.nan_to_num(number_in_header("x0", index - 1)))
        if np.isfinite(interval):
            clocks[index] = Clock(start, interval, unit)
    return clocks


def _start_times_s(header: Header, names: Sequence[str]) -> dict[int, float]:
    """Seconds from the start of the first channel to that of each channel, by its column.

    Times are relative to the date and time of their channel, unless the header says that they are
    absolute. A header with fewer dates and times than channels has one start for all.

    Source: NI, Specification for the LabVIEW Measurement File, tags Date, Time and Time_Pref.

    Args:
        header: Header of the segment and the file.
        names: Names of the columns.
    """
    columns = [index for index, name in enumerate(names) if name not in (_X_COLUMN, _COMMENT)]
    dates = header.get("date", [])[: len(columns)]
    clock_times = header.get("time", [])[: len(columns)]
    is_absolute = _first_cell(header, "time_pref", "Relative").lower() == "absolute"
    if is_absolute or not len(dates) == len(clock_times) == len(columns):
        return {}
    try:
        starts = [
            np.datetime64(f"{date.replace('/', '-')}T{clock_time.replace(',', '.')}", "ns")
            for date, clock_time in zip(dates, clock_times, strict=True)
        ]
    except ValueError:
        return {}
    return {
        index: float((start - starts[0]) / np.timedelta64(1, "s"))
        for index, start in zip(columns, starts, strict=True)
    }


def _keys(header: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, str]]:
    """Header keys: each line is one; `description` and `notes` may hold `key: value` texts."""
    for name, cells in header.items():
        if cells and cells[0]:
            yield name, cells[0]
    for text in (*header.get("description", ()), *header.get("notes", ())):
        for statement in re.split("[;,]", text):
            name, mark, value = statement.partition(":" if ":" in statement else "=")
            if mark:
                yield plain_key(name), value.strip()
