"""How a text log is written: encoding, line ends, header, delimiter, decimal mark, columns, units.

Nothing is assumed of a log but that one line names its columns and the rows follow it.
"""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oilfilm.readers.base import Flaw, Refusal, TextForm
from oilfilm.readers.columns import find_columns, fits, meaning
from oilfilm.readers.header import plain_key
from oilfilm.readers.log_kind import Column, Renamed, Vocabulary

_DELIMITERS = (",", ";", "\t", "|")
_EMPTY_LINES = re.compile(rb"\n{2,}")
_HIGH_BYTES = re.compile(rb"[\x80-\xff]+")
_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
# The line of names is near the top; beyond this a file is no log of ours.
_LINES_SEARCHED = 200
_HEAD_SEARCHED = 1 << 16


@dataclass(frozen=True)
class Layout:
    """How a log is written; `table` holds the rows alone, as UTF-8 with LF line ends.

    `first_line` is the line of the file with the first row, counted from 1; 0 where
    empty lines make the count uncertain.
    """

    keys: dict[str, str]
    encoding: str
    delimiter: str
    decimal_mark: str
    width: int
    columns: tuple[Column, ...]
    table: bytes
    first_line: int

    @property
    def form(self) -> TextForm:
        """The same for people."""
        return TextForm.of(self.encoding, self.delimiter, self.decimal_mark)


class LayoutError(Exception):
    """A log whose columns cannot be understood; `rows` counts what may be its rows."""

    def __init__(self, reason: str, rows: int) -> None:
        super().__init__(reason)
        self.rows = rows


def find_layout(content: bytes, renamed: Renamed, vocabulary: Vocabulary) -> Layout:
    """Find out how a log is written.

    Args:
        content: The file's bytes.
        renamed: Quantity -> `name` (as the log writes it) and `unit`, for columns with other names.
        vocabulary: What such logs may hold.

    Raises:
        LayoutError: No line of column names was found, or the columns are not all there, or one
            has no unit or an impossible one.
    """
    encoding = _best_encoding(content, renamed, vocabulary)
    text = normalise(content, encoding)
    lines = _first_lines(text)
    try:
        number, delimiter, names = _line_of_names(lines, renamed, vocabulary)
    except ValueError as error:
        # one of the lines may be that of the names
        raise LayoutError(str(error), max(count_rows(text) - 1, 0)) from error
    start = sum(len(line) + 1 for line in lines[: number + 1])
    decoded = [line.decode("utf-8", "replace") for line in lines]
    rows = [line.split(delimiter) for line in decoded[number + 1 :]]
    units: list[str] = [""] * len(names)
    if rows and _is_unit_row(rows[0], names, renamed, vocabulary):
        units = [_bare(cell) for cell in rows.pop(0)]
        start += len(lines[number + 1]) + 1
    table = text[start:]
    try:
        columns = find_columns(names, units, renamed, vocabulary)
    except ValueError as error:
        raise LayoutError(str(error), count_rows(table)) from error
    # not the first row alone: it may hold whole numbers only
    numbers = (row[column.index] for row in rows for column in columns if column.index < len(row))
    decimal_mark = "," if delimiter != "," and any("," in cell for cell in numbers) else "."
    return Layout(
        _header_keys(decoded[:number], delimiter),
        encoding,
        delimiter,
        decimal_mark,
        len(names),
        columns,
        table,
        0 if _has_empty_lines(content, text) else text[:start].count(b"\n") + 1,
    )


def _best_encoding(content: bytes, renamed: Renamed, vocabulary: Vocabulary) -> str:
    """Of the encodings that a text may have, the one in which most names of columns are known."""
    encodings = encodings_of(content)
    if len(encodings) == 1:
        return encodings[0]
    # the first of equals is the most likely one
    return max(encodings, key=lambda encoding: _known_names(content, encoding, renamed, vocabulary))


def _known_names(content: bytes, encoding: str, renamed: Renamed, vocabulary: Vocabulary) -> int:
    lines = _first_lines(normalise(content[:_HEAD_SEARCHED], encoding))
    try:
        _, _, names = _line_of_names(lines, renamed, vocabulary)
    except ValueError:
        return 0
    return sum(meaning(name, renamed, vocabulary) is not None for name in names)


def _first_lines(text: bytes) -> list[bytes]:
    return text[:_HEAD_SEARCHED].split(b"\n", _LINES_SEARCHED)[:_LINES_SEARCHED]


def normalise(content: bytes, encoding: str | None = None) -> bytes:
    """The text as UTF-8 with LF line ends, whatever it was written in.

    Empty lines are left out. Bytes that are not valid in the encoding become the replacement
    character, so that the rows that hold them are refused.

    Args:
        content: The file's bytes, or the first of them.
        encoding: Its encoding; the most likely one if not given.
    """
    encoding = encoding or encodings_of(content)[0]
    if encoding != "ascii":
        content = content.decode(encoding, "replace").encode("utf-8")
    content = content.removeprefix(_UTF8_MARK)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    # asked first, because replacing what is not there takes longer than reading the log
    ends = _are_line_ends(content)
    if (ends[1:] & ends[:-1]).any():
        content = _EMPTY_LINES.sub(b"\n", content)
    return content.lstrip(b"\n")


def encodings_of(content: bytes) -> list[str]:
    """The encodings that a text may have, the most likely first.

    A mark, zeros (UTF-16) or valid UTF-8 leave one. Otherwise GB18030 and Windows-1252 are told
    apart by their bytes: common Chinese characters have two bytes of 128 and above each, while
    western letters have one between others.
    """
    if content.startswith(_UTF16_MARKS):
        return ["utf-16"]
    head = content[:2000]
    zeros = head[1::2].count(0), head[0::2].count(0)
    if max(zeros) > len(head) / 4:
        return ["utf-16-le" if zeros[0] > zeros[1] else "utf-16-be"]
    if content.isascii():
        return ["ascii"]
    if _is_valid(content, "utf-8"):
        return ["utf-8"]
    runs = _HIGH_BYTES.findall(content[:_HEAD_SEARCHED])
    pairs = all(len(run) % 2 == 0 for run in runs) and _is_valid(content, "gb18030")
    return ["gb18030", "cp1252", "utf-8"] if pairs else ["cp1252", "utf-8", "gb18030"]


def _is_valid(content: bytes, encoding: str) -> bool:
    try:
        content.decode(encoding)
    except UnicodeDecodeError:
        return False
    return True


def _has_empty_lines(content: bytes, text: bytes) -> bool:
    """True where empty lines of a log's bytes are not in its text."""
    if len(content) == len(text):
        return False
    return any(ends in content for ends in (b"\n\n", b"\r\n\r\n", b"\r\r"))


def _are_line_ends(text: bytes) -> npt.NDArray[np.bool_]:
    """Which bytes are line ends: in a tenth of the time that `bytes` takes to find many of them."""
    return np.frombuffer(text, np.uint8) == ord("\n")


def count_rows(table: bytes) -> int:
    """Lines of a normalised table; the last one counts without a line end too."""
    ends = np.count_nonzero(_are_line_ends(table))
    return int(ends) + (len(table) > 0 and not table.endswith(b"\n"))


def cut_row(cells: int, columns: int, row: int, run_id: str) -> Refusal | None:
    """What to make of a last line without a line end; 0 cells where there is none."""
    if not cells:
        return None
    if cells < columns:
        reason = f"the log ends in the middle of row {row} (its last good row is {row - 1})"
        advice = "Nothing can be made of half a row; see what became of the run."
        return Refusal("cut_row", reason, advice).of_rows(run_id, row, row)
    reason = f"row {row}, the last, has no line end, so that its last number may be cut"
    advice = "End the file with a line end."
    return Refusal("unterminated_row", reason, advice).of_rows(run_id, row, row)


def truncated(cut: Refusal | None) -> Flaw | None:
    """Why a run whose last row is cut off cannot be used."""
    return Flaw("truncated", cut.reason) if cut and cut.rule == "cut_row" else None


def _line_of_names(
    lines: Sequence[bytes], renamed: Renamed, vocabulary: Vocabulary
) -> tuple[int, str, list[str]]:
    for number, raw in enumerate(lines):
        if raw.lstrip().startswith(b"#"):
            continue
        line = raw.decode("utf-8", "replace")
        for delimiter in _DELIMITERS:
            names = _split(line, delimiter)
            if sum(meaning(name, renamed, vocabulary) is not None for name in names) >= 2:
                return number, delimiter, names
    other = (line for line in lines if line.strip() and not line.lstrip().startswith(b"#"))
    first = next(other, b"").decode("utf-8", "replace")
    seen = f"; its first line is {first[:120]!r}" if first else ""
    raise ValueError(f"no line names columns of a {vocabulary.name} log{seen}")


def _split(line: str, delimiter: str) -> list[str]:
    try:
        cells = next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:
        cells = line.split(delimiter)
    return [cell.strip() for cell in cells]


def _is_unit_row(
    cells: Sequence[str], names: Sequence[str], renamed: Renamed, vocabulary: Vocabulary
) -> bool:
    """A row right below the names in which most known columns have a unit that fits them."""
    # a row of numbers is the first of the log, whatever units may be called
    if len(cells) != len(names) or any(_is_number(cell) for cell in cells):
        return False
    meanings = [
        (meaning(name, renamed, vocabulary), cell) for name, cell in zip(names, cells, strict=True)
    ]
    fitting = [
        fits(known[0], _bare(cell), vocabulary) for known, cell in meanings if known is not None
    ]
    return sum(fitting) > len(fitting) / 2


def _is_number(cell: str) -> bool:
    try:
        float(_bare(cell).replace(",", "."))
    except ValueError:
        return False
    return True


def _bare(unit: str) -> str:
    return unit.strip('[]() "')


def _header_keys(lines: Sequence[str], delimiter: str) -> dict[str, str]:
    """`key: value` lines above the names, with or without `#`; `=` or the delimiter serve too."""
    keys: dict[str, str] = {}
    for line in lines:
        plain = line.strip().lstrip("#").strip()
        marks = [mark for mark in (":", "=", delimiter) if mark in plain]
        if marks:
            key, _, value = plain.partition(min(marks, key=plain.index))
            name, text = plain_key(key), value.strip().strip(delimiter).strip()
            # two values are none: what needs this key refuses the log
            keys[name] = text if keys.get(name, text) == text else f"{keys[name]} / {text}"
    return keys
