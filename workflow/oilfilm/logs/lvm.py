"""LabVIEW's text logs (LVM): a header, then segments with a header of their own and rows.

Each segment is a run.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from oilfilm.logs.base import Refusal, TextForm, UnreadableLogError, check_lines
from oilfilm.logs.columns import Found, LoggedTable
from oilfilm.logs.header import FORMAT_ADVICE
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.logs.text_rows import TextTable, encoding_of, normalise
from oilfilm.settings.base import plain_key

_TITLE = b"LabVIEW Measurement"
# Name of the column that is the time of the channels behind it.
_X = "X_Value"
_SEPARATOR = re.compile(r"^Separator(.)", re.MULTILINE)
# Cells behind the name of each line of a header.
Header = dict[str, list[str]]


def recognises(head: bytes) -> bool:
    """True for text that begins with the title of LVM."""
    return normalise(head).lstrip(b" \t\n").startswith(_TITLE)


def tables(content: bytes, vocabulary: Vocabulary) -> Found:
    """See `Reader.tables`."""
    check_lines(content)
    encoding = encoding_of(content)
    text = normalise(content, encoding).decode("utf-8", "replace")
    found = _SEPARATOR.search(text[:4000])
    separator = found[1] if found else "\t"
    lines = text.removesuffix("\n").split("\n")
    starts = [n for n, line in enumerate(lines) if line.split(separator, 1)[0] == "Channels"]
    if not starts:
        reason = "the header does not end: no segment with a line `Channels` follows it"
        raise UnreadableLogError(reason, f"Export it again. {FORMAT_ADVICE}")
    of_file = _header(lines[: starts[0]], separator)
    mark = _first(of_file, "decimal_separator", ".")
    cut = len(lines) if not text.endswith("\n") else 0
    marks = separator, "," if mark == "," else "."
    logged = [
        _table(lines[start:stop], of_file, marks, f"segment{n}" if starts[1:] else "", stop == cut)
        for n, (start, stop) in enumerate(pairwise([*starts, len(lines)]), start=1)
    ]
    return TextForm.of(encoding, *marks), filter(None, logged)


def _header(lines: Sequence[str], separator: str) -> Header:
    cells = (line.split(separator) for line in lines)
    return {plain_key(first): [cell.strip() for cell in others] for first, *others in cells}


def _first(header: Header, key: str, usual: str) -> str:
    """The first cell of a header line."""
    return next(iter(header.get(key, ())), "") or usual


def _table(
    lines: Sequence[str], of_file: Header, marks: tuple[str, str], part: str, cut: bool
) -> LoggedTable | None:
    """A segment as a table; None without rows. `marks` part cells and are the decimal mark."""
    separator, mark = marks
    starts = [line.split(separator, 1)[0] for line in lines]
    end = next((starts.index(name) for name in (_X, "***End_of_Header***") if name in starts), -1)
    own, rows = _header(lines[:end], separator), lines[end + 1 :] if end >= 0 else ()
    header = {**of_file, **own}
    if not rows:
        return None
    names = [cell.strip() for cell in lines[end].split(separator)] if starts[end] == _X else []
    units = ["", *own.get("y_unit_label", ()), *[""] * len(names)][: len(names)]
    # the column of comments need not be there
    width = rows[-1].count(separator) + 1 + (names[-1:] == ["Comment"]) if cut else 0
    text = "\n".join([*(_row(row, len(names), separator) for row in rows), *[""] * (not cut)])
    table = TextTable(text.encode(), len(names), separator, mark)
    clocks = {}
    if _first(header, "x_dimension", "Time") == "Time":
        unit = _first(header, "x_unit_label", "s")
        if _first(header, "x_columns", "One") == "No":
            clocks = {place: (*of, unit) for place, of in _clocks(header, len(names), mark)}
        elif names:
            xs = table.numbers([n for n, name in enumerate(names) if name == _X])
            # if the X columns of all channels agree, they are the time
            if all(np.array_equal(xs[0], each, equal_nan=True) for each in xs):
                names, units = ["time", *names[1:]], [unit, *units[1:]]
    reason = f"the segment has no line `{_X}` with the names of its channels"
    problem = None if names else Refusal("columns", reason, FORMAT_ADVICE)
    flaw, keys = _too_few_rows(header, len(rows)), dict(_keys(of_file)) | dict(_keys(own))
    columns = names, units, table.numbers, len(rows), part
    return LoggedTable(keys, *columns, flaw=flaw, problem=problem, clocks=clocks, cut=width)


def _row(line: str, width: int, separator: str) -> str:
    """A row with one cell per name: a comment may be missing, empty cells too many."""
    missing = width - 1 - line.count(separator)
    if missing < 0:
        cells = line.split(separator)
        return separator.join(cells[:width]) if not any(map(str.strip, cells[width:])) else line
    return line + missing * separator


def _too_few_rows(header: Header, rows: int) -> Refusal | None:
    cells = header.get("samples", ())
    counts = [cell for cell in cells if cell.isascii() and cell.isdecimal() and len(cell) < 12]
    announced = max(map(int, counts), default=0)
    sentence = f"the segment announces {announced} samples and holds {rows}"
    return Refusal("truncated", sentence) if announced > rows else None


def _clocks(header: Header, width: int, mark: str) -> Iterator[tuple[int, tuple[float, float]]]:
    """Start and increment of the time of the channels whose increment the header has."""

    def number(key: str, place: int) -> float:
        try:
            return float(header[key][place - 1].replace(mark, "."))
        except (KeyError, IndexError, ValueError):
            return np.nan

    for place in range(1, width):
        if np.isfinite(increment := number("delta_x", place)):
            yield place, (float(np.nan_to_num(number("x0", place))), increment)


def _keys(header: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, str]]:
    """Header keys: a field each, and what `description` and `notes` say as `key: value`."""
    for name, cells in header.items():
        if cells and cells[0]:
            yield name, cells[0]
    for text in (*header.get("description", ()), ";", *header.get("notes", ())):
        for part in re.split("[;,]", text):
            name, mark, value = part.partition(":" if ":" in part else "=")
            if mark:
                yield plain_key(name), value.strip()
