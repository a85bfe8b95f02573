"""LabVIEW's text logs (LVM): a header, then segments with a header of their own and rows.

Each segment is a run.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from oilfilm.logs.base import Flaw, Refusal, TextForm, UnreadableLogError, check_lines
from oilfilm.logs.columns import Found, LoggedTable
from oilfilm.logs.encoding import best_encoding, normalise
from oilfilm.logs.header import FORMAT_ADVICE
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.logs.text_rows import TextTable
from oilfilm.settings.base import plain_key

_TITLE = b"LabVIEW Measurement"
# Name of the column that is the time of the channels behind it.
_X = "X_Value"
_END = "***End_of_Header***"
_SEPARATOR = re.compile(r"^Separator(.)", re.MULTILINE)


@dataclass(frozen=True)
class _Segment:
    """One segment: cells of its header and of the file's, column names, units, rows."""

    header: Mapping[str, Sequence[str]]
    keys: dict[str, str]
    names: list[str]
    units: list[str]
    rows: list[str]

    def first(self, key: str, usual: str) -> str:
        """The first cell of a header line."""
        return next(iter(self.header.get(key, ())), "") or usual


def recognises(head: bytes) -> bool:
    """True for text that begins with the title of LVM."""
    return normalise(head).lstrip(b" \t\n").startswith(_TITLE)


def tables(content: bytes, vocabulary: Vocabulary) -> Found:
    """See `Reader.tables`."""

    def known(head: bytes) -> tuple[int, int]:
        segments, _ = _segments(head.decode("utf-8", "replace"))
        return vocabulary.score(segments[0].names, segments[0].units) if segments else (0, 0)

    check_lines(content)
    encoding = best_encoding(content, known)
    text = normalise(content, encoding).decode("utf-8", "replace")
    segments, separator = _segments(text)
    if not segments:
        reason = "the header does not end: no segment with a line `Channels` follows it"
        raise UnreadableLogError(reason, f"Export it again. {FORMAT_ADVICE}")
    mark = "," if segments[0].first("decimal_separator", "") == "," else "."
    logged = [
        _table(
            segment,
            separator,
            mark,
            part=f"segment{number}",
            alone=len(segments) == 1,
            complete=text.endswith("\n") or number < len(segments),
        )
        for number, segment in enumerate(segments, start=1)
        if segment.rows
    ]
    return TextForm.of(encoding, separator, mark), logged


def _segments(text: str) -> tuple[list[_Segment], str]:
    """The segments of a file, and what parts its cells."""
    found = _SEPARATOR.search(text[:4000])
    separator = found[1] if found else "\t"
    lines = text.removesuffix("\n").split("\n")
    begin = f"Channels{separator}"
    starts = [n for n, line in enumerate(lines) if line == "Channels" or line.startswith(begin)]
    of_file = _header(lines[: starts[0]], separator) if starts else {}
    return [
        _segment(lines[start:stop], of_file, separator)
        for start, stop in pairwise([*starts, len(lines)])
    ], separator


def _segment(
    lines: Sequence[str], of_file: Mapping[str, Sequence[str]], separator: str
) -> _Segment:
    cells = (line.split(separator) for line in lines)
    names_of = ((n, [cell.strip() for cell in row]) for n, row in enumerate(cells) if row[0] == _X)
    end, names = next(names_of, (-1, []))
    if not names:
        ends = (number for number, line in enumerate(lines) if line.startswith(_END))
        end = next(ends, len(lines))
    header = _header(lines[:end], separator)
    units = ["", *header.get("y_unit_label", []), *[""] * len(names)][: len(names)]
    keys = dict(_keys(of_file)) | dict(_keys(header))
    return _Segment({**of_file, **header}, keys, names, units, list(lines[end + 1 :]))


def _header(lines: Sequence[str], separator: str) -> dict[str, list[str]]:
    cells = (line.split(separator) for line in lines)
    return {plain_key(first): [cell.strip() for cell in others] for first, *others in cells}


def _table(
    segment: _Segment, separator: str, mark: str, *, part: str, alone: bool, complete: bool
) -> LoggedTable:
    names, units = segment.names, segment.units
    cut = 0
    if not complete:
        # the column of comments need not be there
        cut = segment.rows[-1].count(separator) + 1 + (names[-1:] == ["Comment"])
    rows = "\n".join(_row(row, len(names), separator) for row in segment.rows)
    table = TextTable(f"{rows}{'' if cut else chr(10)}".encode(), len(names), separator, mark)
    clocks = {}
    if segment.first("x_dimension", "Time") == "Time":
        unit = segment.first("x_unit_label", "s")
        if segment.first("x_columns", "One") == "No":
            clocks = dict(_clocks(segment, mark, unit))
        elif names:
            xs = table.numbers([n for n, name in enumerate(names) if name == _X])
            # if the X columns of all channels agree, they are the time
            if all(np.array_equal(xs[0], each, equal_nan=True) for each in xs):
                names, units = ["time", *names[1:]], [unit, *units[1:]]
    reason = f"the segment has no line `{_X}` with the names of its channels"
    return LoggedTable(
        segment.keys,
        names,
        units,
        table.numbers,
        len(segment.rows),
        part,
        alone,
        flaw=_too_few_rows(segment),
        problem=None if names else Refusal("columns", reason, FORMAT_ADVICE),
        clocks=clocks,
        cut=cut,
    )


def _row(line: str, width: int, separator: str) -> str:
    """A row with one cell per name: a comment may be missing, empty cells too many."""
    missing = width - 1 - line.count(separator)
    if missing < 0:
        cells = line.split(separator)
        return separator.join(cells[:width]) if not any(map(str.strip, cells[width:])) else line
    return line + missing * separator


def _too_few_rows(segment: _Segment) -> Flaw | None:
    cells = segment.header.get("samples", [])
    counts = [cell for cell in cells if cell.isascii() and cell.isdecimal() and len(cell) < 12]
    announced = max(map(int, counts), default=0)
    if announced <= len(segment.rows):
        return None
    sentence = f"the segment announces {announced} samples and holds {len(segment.rows)}"
    return Flaw("truncated", sentence)


def _clocks(
    segment: _Segment, mark: str, unit: str
) -> Iterator[tuple[int, tuple[float, float, str]]]:
    """See `LoggedTable.clocks`: of the channels whose increment the header has."""

    def number(key: str, place: int) -> float:
        try:
            return float(segment.header[key][place - 1].replace(mark, "."))
        except (KeyError, IndexError, ValueError):
            return np.nan

    for place in range(1, len(segment.names)):
        if np.isfinite(increment := number("delta_x", place)):
            yield place, (np.nan_to_num(number("x0", place)), increment, unit)


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
