"""LabVIEW's text logs (LVM): a header, then segments with a header of their own and rows.

Each segment is a run.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from oilfilm.logs.base import Flaw, Names, Reading, TextForm, refused_file
from oilfilm.logs.columns import LoggedTable, known_names, read_tables
from oilfilm.logs.encoding import HEAD_SEARCHED, best_encoding, encodings_of, normalise
from oilfilm.logs.header import FORMAT_ADVICE
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.logs.text_rows import TextTable, cut_row
from oilfilm.settings.base import plain_key
from oilfilm.settings.resolved import Settings

Cells = Mapping[str, Sequence[str]]

_TITLE = b"LabVIEW Measurement"
# Name of the column that is the time of the channels behind it.
_X = "X_Value"
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
        segment = _first_segment(head.decode("utf-8", "replace"))
        return known_names(segment.names, _units(segment), renamed, kind.vocabulary)

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
            part = f"segment{number}"
            tables.append(_table(header, segment, complete, run_id, part, first_row))
        first_row += len(segment.rows)
    form = TextForm.of(encoding, separator, _decimal_mark(header))
    return read_tables(tables, settings, kind, sheet, form)


def names(content: bytes) -> Iterator[Names]:
    """See `Reader.names`."""
    for encoding in encodings_of(content):
        text = normalise(content[:HEAD_SEARCHED], encoding).decode("utf-8", "replace")
        segment = _first_segment(text)
        yield list(zip(segment.names, _units(segment), strict=True))


def _separator(text: str) -> str:
    mark = _SEPARATOR.search(text[:4000])
    return mark[1] if mark else "\t"


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
        if cells[0] == _X:
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
    header: Cells, segment: _Segment, complete: bool, run_id: str, part: str, first_row: int
) -> LoggedTable:
    """A segment as a table, without a last row that may be cut."""
    names, units = list(segment.names), _units(segment)
    rows, behind, flaw = list(segment.rows), None, None
    if not complete:
        width = rows.pop().count(segment.separator) + 1
        row = first_row + len(rows)
        # the column of comments need not be there
        behind, flaw = cut_row(width, len(names) - (names[-1:] == ["Comment"]), row, run_id)
    mark = _decimal_mark(header)
    text = "\n".join(_row(row, len(names), segment.separator) for row in rows)
    table = TextTable(text.encode(), len(names), segment.separator, mark)
    clocks = {}
    if (segment.header.get("x_dimension") or ["Time"])[0] in {"Time", ""}:
        unit = (segment.header.get("x_unit_label") or [""])[0] or "s"
        if (header.get("x_columns") or ["One"])[0] == "No":
            steps = {place: _step(segment.header, place, mark) for place in range(1, len(names))}
            clocks = {place: (*step, unit) for place, step in steps.items() if step}
        elif names:
            xs = table.numbers([n for n, name in enumerate(names) if name == _X])
            # if the X columns of all channels agree, they are the time
            if all(np.array_equal(xs[0], each, equal_nan=True) for each in xs):
                names[0], units[0] = "time", unit
    problem = "" if names else f"the segment has no line `{_X}` with the names of its channels"
    return LoggedTable(
        run_id,
        _keys(header) | _keys(segment.header),
        names,
        units,
        table.numbers,
        len(rows),
        first_row,
        flaw or _too_few_rows(segment),
        problem,
        behind,
        part,
        clocks,
    )


def _row(line: str, width: int, separator: str) -> str:
    """A row with one cell per name: a comment may be missing, empty cells too many."""
    missing = width - 1 - line.count(separator)
    if missing < 0:
        cells = line.split(separator)
        return separator.join(cells[:width]) if not any(map(str.strip, cells[width:])) else line
    return line + missing * separator


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


def _step(header: Cells, place: int, decimal_mark: str) -> tuple[float, float] | None:
    """Start and increment of the time of a channel, if the segment's header has the increment."""
    x0, increment = (
        _number(header.get(key, [])[place - 1 : place], decimal_mark) for key in ("x0", "delta_x")
    )
    return (np.nan_to_num(x0), increment) if np.isfinite(increment) else None


def _number(cells: Sequence[str], decimal_mark: str) -> float:
    try:
        return float(cells[0].replace(decimal_mark, "."))
    except (IndexError, ValueError):
        return np.nan


def _keys(header: Cells) -> dict[str, str]:
    """Header keys: a field each, and what `description` and `notes` say as `key: value`."""
    keys = {name: cells[0] for name, cells in header.items() if cells and cells[0]}
    for field in _FREE_TEXT:
        for part in re.split("[;,]", " ; ".join(header.get(field, []))):
            name, mark, value = part.partition(":" if ":" in part else "=")
            if mark:
                keys[plain_key(name)] = value.strip()
    return keys
