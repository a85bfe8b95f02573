"""LabVIEW's text logs (LVM): a header, then segments with a header of their own and rows.

Each segment is a run. The segments are told apart here; lvm-read is given one at a time, from
memory, so that neither its pickles nor its evaluation of header cells is ever reached by a file.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import lvm_read
import numpy as np
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm.logs.base import Flaw, Names, Reading, Refusal, TextForm, damaged_file, refused_file
from oilfilm.logs.columns import LoggedTable, known_names, meaning, read_tables
from oilfilm.logs.encoding import HEAD_SEARCHED, best_encoding, encodings_of, normalise
from oilfilm.logs.header import FORMAT_ADVICE
from oilfilm.logs.layout import cut_row, truncated
from oilfilm.logs.log_kind import FloatArray, LogKind, Renamed, Vocabulary
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.settings.base import plain_key
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings

Cells = Mapping[str, Sequence[str]]

_TITLE = b"LabVIEW Measurement"
_END = "***End_of_Header***"
_SEPARATOR = re.compile(r"^Separator(.)", re.MULTILINE)
# Fields of free text, in which `key: value; key: value` is read.
_FREE_TEXT = ("description", "notes")


@dataclass(frozen=True)
class _Segment:
    """One segment: cells of its header by their key, column names, rows, cells' separator."""

    header: Cells
    names: Sequence[str]
    rows: Sequence[str]
    separator: str


def recognises(head: bytes) -> bool:
    """True for text that begins with the title of LVM."""
    return normalise(head).lstrip(b" \t\n").startswith(_TITLE)


def read(
    content: bytes, file: str, settings: Settings, kind: LogKind, sheet: SheetOfLog
) -> Reading:
    """See `Reader.read`."""
    renamed = kind.renamed(settings.campaign)

    def known(head: bytes) -> tuple[int, int]:
        return _known_names(head.decode("utf-8", "replace"), renamed, kind.vocabulary)

    encoding = best_encoding(content, known)
    text = normalise(content, encoding).decode("utf-8", "replace")
    separator = _separator(text)
    lines = text.removesuffix("\n").split("\n")
    begin = f"Channels{separator}"
    starts = [n for n, line in enumerate(lines) if line == "Channels" or line.startswith(begin)]
    if not starts:
        reason = "the header does not end: no segment with a line `Channels` follows it"
        return refused_file(0, "columns", reason, f"Export it again. {FORMAT_ADVICE}")
    header = _header(lines[: starts[0]], separator)
    tables: list[LoggedTable] = []
    first_row = 1
    for number, (start, stop) in enumerate(pairwise([*starts, len(lines)]), start=1):
        segment = _segment(lines[start:stop], separator)
        run_id = f"{file}:segment{number}" if len(starts) > 1 else file
        complete = text.endswith("\n") or number < len(starts)
        if segment.rows:
            try:
                table = _table(header, segment, complete, run_id, first_row, settings, kind)
            except Exception as error:  # whatever a damaged file makes the library stumble over
                return damaged_file("lvm", error)
            tables.append(replace(table, part=f"segment{number}"))
        first_row += len(segment.rows)
    form = TextForm.of(encoding, separator, _decimal_mark(header))
    return replace(read_tables(tables, settings, kind, sheet), form=form)


def names(content: bytes) -> Iterator[Names]:
    """See `Reader.names`."""
    for encoding in encodings_of(content):
        text = normalise(content[:HEAD_SEARCHED], encoding).decode("utf-8", "replace")
        segment = _first_segment(text)
        yield list(zip(segment.names, _units(segment), strict=True))


def _separator(text: str) -> str:
    mark = _SEPARATOR.search(text[:4000])
    return mark[1] if mark else "\t"


def _known_names(text: str, renamed: Renamed, vocabulary: Vocabulary) -> tuple[int, int]:
    """As `known_names`, of the first segment in the head of a log."""
    segment = _first_segment(text)
    return known_names(segment.names, _units(segment), renamed, vocabulary)


def _first_segment(text: str) -> _Segment:
    lines = text.split("\n")
    start = next((n for n, line in enumerate(lines) if line.startswith("Channels")), len(lines))
    return _segment(lines[start:], _separator(text))


def _units(segment: _Segment) -> list[str]:
    labels = ["", *segment.header.get("y_unit_label", [])]
    return [labels[index] if index < len(labels) else "" for index in range(len(segment.names))]


def _segment(lines: Sequence[str], separator: str) -> _Segment:
    for number, line in enumerate(lines):
        cells = line.split(separator)
        if cells[0] == "X_Value":
            names = [cell.strip() for cell in cells]
            header = _header(lines[:number], separator)
            return _Segment(header, names, lines[number + 1 :], separator)
    ends = [number for number, line in enumerate(lines, start=1) if line.startswith(_END)]
    end = ends[0] if ends else len(lines)
    return _Segment(_header(lines[:end], separator), [], lines[end:], separator)


def _header(lines: Sequence[str], separator: str) -> Cells:
    cells = (line.split(separator) for line in lines)
    return {plain_key(first): [cell.strip() for cell in others] for first, *others in cells}


def _table(
    header: Cells,
    segment: _Segment,
    complete: bool,
    run_id: str,
    first_row: int,
    settings: Settings,
    kind: LogKind,
) -> LoggedTable:
    """A segment as a table, without a last row that may be cut."""
    kept, cut = list(segment.rows), None
    if not complete:
        row = first_row + len(kept) - 1
        cells = kept.pop().count(segment.separator) + 1
        # the column of comments need not be there
        width = len(segment.names) - (segment.names[-1:] == ["Comment"])
        cut = cut_row(cells, width, row, run_id)
    decimal_mark = _decimal_mark(header)
    values = _numbers(segment.names, kept, segment.separator, decimal_mark)
    names, units, columns = _named(header, segment, values, decimal_mark, settings.campaign, kind)
    problem = None
    if not segment.names:
        reason = "the segment has no line `X_Value` with the names of its channels"
        problem = Refusal("columns", reason, FORMAT_ADVICE)
    keys = _keys(header) | _keys(segment.header)
    flaw = truncated(cut) or _too_few_rows(segment)
    return LoggedTable(
        run_id, keys, names, units, columns, len(kept), first_row, flaw, problem, cut
    )


def _decimal_mark(header: Cells) -> str:
    return "," if (header.get("decimal_separator") or [""])[0] == "," else "."


def _too_few_rows(segment: _Segment) -> Flaw | None:
    cells = segment.header.get("samples", [])
    counts = [cell for cell in cells if cell.isascii() and cell.isdecimal() and len(cell) < 12]
    announced = max(map(int, counts), default=0)
    if announced <= len(segment.rows):
        return None
    sentence = f"the segment announces {announced} samples and holds {len(segment.rows)}"
    return Flaw("truncated", sentence)


def _numbers(
    names: Sequence[str], rows: Sequence[str], separator: str, decimal_mark: str
) -> FloatArray:
    """Numbers of all columns, shape (rows, columns); NaN where a cell holds anything else."""
    values = np.full((len(rows), len(names)), np.nan)
    if not rows or not names:
        return values
    width = rows[0].count(separator) + 1
    alone = _numbers_alone(rows, separator, decimal_mark, width) if width <= len(names) else None
    if alone is not None:
        values[:, :width] = alone
        return values
    plain = [row if _is_row(row, separator, names) else "?" for row in rows]
    # everything but the rows is written again: nothing else of the file is for lvm-read to judge
    lines = [
        f"Decimal_Separator{separator}{decimal_mark}\n",
        "\n",
        f"Channels{separator}{len(names)}\n",
        separator.join(["X_Value", *("Y" for _ in names[1:])]) + "\n",
        *(f"{row}\n" for row in plain),
    ]
    numbers = lvm_read.read_lines(lines, separator=separator)[0]["data"]
    if len(numbers) != len(rows):
        raise ValueError(f"of {len(rows)} rows {len(numbers)} came back")
    width = min(numbers.shape[1], len(names))
    values[:, :width] = numbers[:, :width]
    return values


def _numbers_alone(
    rows: Sequence[str], separator: str, decimal_mark: str, width: int
) -> FloatArray | None:
    """Numbers of rows that hold nothing else, much faster than lvm-read; None of others."""
    table = "\n".join(rows).encode()
    types = dict.fromkeys(map(str, range(width)), arrow.float64())
    try:
        cells = arrow_csv.read_csv(
            arrow.BufferReader(table),
            read_options=arrow_csv.ReadOptions(
                use_threads=False,
                column_names=[*types],
                block_size=len(table) + 1,
            ),
            parse_options=arrow_csv.ParseOptions(delimiter=separator, quote_char=False),
            convert_options=arrow_csv.ConvertOptions(
                column_types=types, decimal_point=decimal_mark
            ),
        )
    except ValueError:
        return None
    if len(cells) != len(rows) or any(column.null_count for column in cells.columns):
        return None
    return np.column_stack([column.to_numpy() for column in cells.columns])


def _is_row(line: str, separator: str, names: Sequence[str]) -> bool:
    """Whether a line can be a row of data: not empty, no marker, no cell beyond the names."""
    cells = line.split(separator)
    numbers = cells[: len(names) - (names[-1] == "Comment")]
    return (
        bool(line.strip(f"{separator} "))
        and not line.startswith(("***", _TITLE.decode()))
        and not any(cell.strip() for cell in cells[len(names) :])
        # Python reads 1_0 as a number
        and not any("_" in cell for cell in numbers)
    )


def _named(
    header: Cells,
    segment: _Segment,
    values: FloatArray,
    decimal_mark: str,
    campaign: Campaign,
    kind: LogKind,
) -> tuple[list[str], list[str], list[FloatArray]]:
    """Names, units and columns, the X column being the time where no channel is."""
    names = list(segment.names)
    units = _units(segment)
    columns = list(values.T)
    renamed = kind.renamed(campaign)
    known = [meaning(name, renamed, kind.vocabulary) for name in names]
    is_time = (segment.header.get("x_dimension") or ["Time"])[0] in {"Time", ""}
    if not names or not is_time or any(column and column[0] == "time" for column in known):
        return names, units, columns
    x_unit = (segment.header.get("x_unit_label") or [""])[0] or "s"
    if (header.get("x_columns") or ["One"])[0] != "No":
        clocks = [column for name, column in zip(names, columns, strict=True) if name == "X_Value"]
        if not all(np.array_equal(clocks[0], clock, equal_nan=True) for clock in clocks):
            # without a time of their own the segment is refused for the lack of one
            return names, units, columns
        return ["time", *names[1:]], [x_unit, *units[1:]], columns
    steps = {
        (_first(segment.header, "x0", index, decimal_mark), increment)
        for index, column in enumerate(known)
        if column is not None
        and np.isfinite(increment := _first(segment.header, "delta_x", index, decimal_mark))
    }
    if len(steps) != 1:
        return names, units, columns
    ((start, increment),) = steps
    time = np.nan_to_num(start) + increment * np.arange(len(values))
    return ["time", *names[1:]], [x_unit, *units[1:]], [time, *columns[1:]]


def _first(header: Cells, key: str, index: int, decimal_mark: str) -> float:
    """The number of a channel in a line of the segment's header; NaN where it has none."""
    cells = header.get(key, [])
    try:
        return float(cells[index - 1].replace(decimal_mark, "."))
    except (IndexError, ValueError):
        return float("nan")


def _keys(header: Cells) -> dict[str, str]:
    """Header keys: a field each, and what `description` and `notes` say as `key: value`."""
    keys = {name: cells[0] for name, cells in header.items() if cells and cells[0]}
    for field in _FREE_TEXT:
        for part in re.split("[;,]", " ; ".join(header.get(field, []))):
            name, mark, value = part.partition(":" if ":" in part else "=")
            if mark:
                keys[plain_key(name)] = value.strip()
    return keys
