"""Text logs with one row per instant: a header, one line of column names, then the rows.

Nothing is assumed of a log but that one line names its columns and the rows follow it.
data/raw/README.md describes what may vary between logs.

Decides: how the layout of a text log is found.
"""

import csv
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass
from itertools import zip_longest

from oilfilm.logs import text_rows
from oilfilm.logs.base import TextForm, UnreadableLogError, check_rows
from oilfilm.logs.columns import Found, LoggedTable
from oilfilm.logs.header import FULL_WIDTH
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.settings.base import plain_key

_BLANKS = " "
_DELIMITERS = (",", ";", "\t", "|")
# Fewer numbers may be the value of a header line; letters of a line that are quoted.
_NUMBERS_OF_ROW, _LONGEST = 3, 80
# The line of names is near the top; beyond this a file is no log of ours.
_LINES_SEARCHED = 200
_COMMENT_LINES = re.compile(rb"^#[^\n]*(?:\n|\Z)", re.MULTILINE)
_SPREADSHEET_ERROR = re.compile(r"#(?:N/A|NV|[^\W\d_]+(?:/0)?[!?])")
_SOME_BLANKS = re.compile(rb"[ \t]+")
_OUTER_BLANKS = re.compile(rb"^[ \t]+|[ \t]+$", re.MULTILINE)
_CLOCK_OR_DATE = re.compile(r"\d[:/]\d")
# A number in groups of thousands, with a decimal mark behind them.
_GROUPED = re.compile(r"[-+]?\d{1,3}(?:([.,])\d{3})(?:\1\d{3})*(?!\1)[.,]\d+")
# Words of a name and columns, where blanks part the columns; lines in which a better one is looked
# for, or rows.
_LONGEST_UNIT = 8
_LONGEST_NAME, _FEWEST_COLUMNS, _ROWS_SEARCHED = 5, 3, 20


@dataclass(frozen=True)
class _Head:
    """The lines above the rows, and the first rows.

    `start` is the number of lines down to the first row, `rows` has cells of the first rows,
    `quoted` says whether a cell may hold the delimiter.
    """

    header: Sequence[str]
    start: int
    delimiter: str
    names: list[str]
    units: list[str]
    rows: list[list[str]]
    quoted: bool


# Text has no more control characters than this among its first letters; other files do.
_JUDGED, _ODD_SHARE = 1000, 0.02


def recognises(head: bytes) -> bool:
    """True for any text."""
    first = text_rows.normalise(head).decode("utf-8", "replace").lstrip("\ufeff \n")[:_JUDGED]
    odd = sum(not (letter.isprintable() or letter.isspace()) for letter in first)
    return bool(first) and "\0" not in first[:200] and odd <= _ODD_SHARE * len(first)


def tables(content: bytes, vocabulary: Vocabulary) -> Found:
    """See `Reader.tables`."""
    encoding = text_rows.encoding_of(content)
    text = text_rows.normalise(content, encoding)
    rows = max(text_rows.count_rows(text) - 1, 0)  # one of the lines may be that of the names
    check_rows(rows)
    try:
        head = _find_head(text, vocabulary)
        rows += 1
        _refuse_row_above_names(head)
        lines = text[: text_rows.HEAD_SEARCHED].split(b"\n", head.start)[: head.start]
        start = sum(map(len, lines)) + head.start
        body = text
        # asked first, because replacing what is not there takes longer than reading the log
        if text.find(b"\n#", max(start - 1, 0)) >= 0:
            body = _COMMENT_LINES.sub(lambda line: _row_or_nothing(line[0], head), text[start:])
            start = 0
        rows = text_rows.count_rows(body, start)
        known = vocabulary.meanings(head.names, head.units)
        stamps = _stamps(head, known)
    except ValueError as error:
        read_as = "" if encoding == "ascii" else f"; read as {encoding}"
        raise UnreadableLogError(f"{error}{read_as}", vocabulary.advice, rows) from error
    body, delimiter, start = _plain_cells(body, head, start)
    decimal_mark, group_mark = _marks(head, delimiter, known.keys() - stamps)
    table = text_rows.TextTable(
        body, len(head.names), delimiter, decimal_mark, group_mark, stamps, start
    )
    keys = _header_keys(head.header, head.delimiter)
    columns = head.names, head.units, table.numbers, table.rows
    logged = LoggedTable(keys, *columns, cut=table.cut, show=table.show)
    return TextForm.of(encoding, head.delimiter, decimal_mark), [logged]


def _find_head(text: bytes, vocabulary: Vocabulary) -> _Head:
    """The lines of names and of units, and the first rows.

    Raises:
        ValueError: No line names columns.
    """
    first = text[: text_rows.HEAD_SEARCHED].decode("utf-8", "replace")
    # asked first: most logs are ASCII, and each run pays for it
    first = first if first.isascii() else first.translate(FULL_WIDTH)
    lines = first.split("\n", _LINES_SEARCHED)[:_LINES_SEARCHED]
    number, delimiter, names = _line_of_names(lines, vocabulary)
    below = [
        (place, line)
        for place, line in enumerate(lines[number + 1 :], start=number + 1)
        if line.strip() and (line[0] != "#" or _is_row(line, delimiter, len(names)))
    ]
    cells = [_split(line, delimiter) for _, line in below]
    units, start = [""] * len(names), number + 1
    if cells and _is_unit_row(cells[0], names, vocabulary):
        units, start = [_bare(cell) for cell in cells.pop(0)], below[0][0] + 1
    width = Counter(map(len, cells)).most_common(1)[0][0] if cells else len(names)
    # a delimiter behind the last cell, in the rows or in the names alone
    if any(names[width:]) or (
        width > len(names) and any(any(row[len(names) :]) for row in cells if len(row) == width)
    ):
        width = len(names)
    names, units = ((some + [""] * width)[:width] for some in (names, units))
    return _Head(lines[:number], start, delimiter, names, units, cells, '"' in first)


def _is_row(line: str, delimiter: str, width: int) -> bool:
    """Whether a `#` line below the names is a row: spreadsheets write their errors as #N/A.

    So does a first cell that is such an error, as many cells as names (but where blanks part them,
    as they part words), or more than half of them numbers or errors.
    """
    cells = _split(line, delimiter)
    numbers = sum(cell.startswith("#") or _is_number(cell) for cell in cells)
    as_wide = delimiter != _BLANKS and len(cells) == width
    return as_wide or numbers > width / 2 or _SPREADSHEET_ERROR.fullmatch(cells[0]) is not None


def _row_or_nothing(line: bytes, head: _Head) -> bytes:
    """A `#` line that is a row; nothing for a comment."""
    text = line.decode("utf-8", "replace")
    return line if _is_row(text, head.delimiter, len(head.names)) else b""


def _refuse_row_above_names(head: _Head) -> None:
    """Raise if a row is above the line of names: it would be lost as a header line."""
    form = [_is_number(cell) for cell in head.rows[0]] if head.rows else []
    for number, line in enumerate(head.header if sum(form) >= _NUMBERS_OF_ROW else (), start=1):
        cells = _split(line, head.delimiter)
        numbers = [_is_number(cell) or cell.startswith("#") for cell in cells]
        if numbers == form:
            raise ValueError(
                f"line {number} reads {line[:_LONGEST]!r}, which looks like a row, but is "
                "above the line of names; put the names above all rows"
            )


def _line_of_names(lines: Sequence[str], vocabulary: Vocabulary) -> tuple[int, str, list[str]]:
    def known(names: Sequence[str]) -> int:
        return sum(vocabulary.meaning(name) is not None for name in names)

    # some programs write the names as a comment: looked for where there is no better line
    for mark in ("", "#"):
        best, found = 1, None
        for number, line in enumerate(lines):
            if found and number > found[0] + _ROWS_SEARCHED:
                break
            if line.lstrip().startswith("#") == bool(mark):
                for delimiter in _DELIMITERS:
                    names = _split(line.lstrip("# \t") if mark else line, delimiter)
                    if len(names) > best and not _is_number(names[0]) and known(names) > best:
                        best, found = known(names), (number, delimiter, names)
        if found is not None:
            return found
    hint = ""
    for number, line in enumerate(lines):
        width = _width_of_rows(lines[number + 1 : number + 1 + _ROWS_SEARCHED])
        for names in _blank_parted(line, vocabulary) if width >= _FEWEST_COLUMNS else ():
            if known(names) >= 2:
                if len(names) == width:
                    return number, _BLANKS, names
                hint = f": blanks part {width} columns, but {len(names)} names; write these without"
    first = next((line for line in lines if line.strip() and line.lstrip()[0] != "#"), "")
    seen = f"; its first line is {first[:120]!r}" if first else ""
    raise ValueError(f"no line names columns of a {vocabulary.name} log{hint or seen}")


def _width_of_rows(lines: Sequence[str]) -> int:
    """How many cells most rows of numbers have that blanks part; 0 where there are none."""
    rows = [line.split() for line in lines if line.strip()]
    holds_data = (_is_number, text_rows.is_stamp, text_rows.is_date)
    counts = Counter(len(row) for row in rows if any(holds(row[0]) for holds in holds_data))
    return counts.most_common(1)[0][0] if counts else 0


def _blank_parted(line: str, vocabulary: Vocabulary) -> Iterator[list[str]]:
    """Names that blanks part: each word one, by two at least, or by one and known as a whole."""
    line = line.lstrip("# \t")
    yield line.split()
    yield [name for name in re.split(r"\s{2,}|\t", line.strip()) if name]
    words, names = line.split(), []
    first = 0
    while first < len(words):
        joined = (" ".join(words[first : first + count]) for count in range(_LONGEST_NAME, 0, -1))
        name = next((name for name in joined if vocabulary.meaning(name)), words[first])
        names.append(name)
        first += len(name.split())
    yield names


def _split(line: str, delimiter: str) -> list[str]:
    if delimiter == _BLANKS:
        return line.split()
    cells = line.split(delimiter)
    if '"' in line:
        with suppress(csv.Error):
            cells = next(csv.reader([line], delimiter=delimiter), [])
    return [cell.strip() for cell in cells]


def _plain_cells(body: bytes, head: _Head, start: int) -> tuple[bytes, str, int]:
    """The rows with one mark between cells that no cell holds, that mark, and where they start."""
    plain = not (head.quoted and any(head.delimiter in cell for row in head.rows for cell in row))
    if plain and head.delimiter != _BLANKS:
        return body, head.delimiter, start
    body = body[start:]
    if head.delimiter == _BLANKS:
        return (
            text_rows.normalise(_SOME_BLANKS.sub(b"\t", _OUTER_BLANKS.sub(b"", body)), "ascii"),
            "\t",
            0,
        )
    # quoted cells hold the delimiter; line by line, so that a stray quote harms one row alone
    lines = body.decode("utf-8").split("\n")
    rows = "\n".join("\t".join(_split(line, head.delimiter)) for line in lines)
    return text_rows.normalise(rows.encode(), "ascii"), "\t", 0


def _marks(head: _Head, delimiter: str, places: Set[int]) -> tuple[str, str]:
    """Decimal mark and mark between thousands, from the columns of numbers at some places."""
    # not the first row alone: it may hold whole numbers only
    cells = [_bare(row[place]) for row in head.rows for place in places if place < len(row)]
    cells = [cell for cell in cells if "," in cell]
    if not cells or (delimiter == "," and not head.quoted):
        return ".", ""
    if grouped := next(filter(None, map(_GROUPED.fullmatch, cells)), None):
        return (",", ".") if grouped[1] == "." else (".", ",")
    return "." if delimiter == "," else ",", ""


def _stamps(head: _Head, known: Mapping[int, tuple[str, str]]) -> tuple[int, ...]:
    """Places of the columns of time stamps, see `TextTable`.

    The unit of the time is set to seconds, whatever the log says.

    Raises:
        ValueError: The time is neither a number nor a time stamp.
    """
    time = next((index for index, (quantity, _) in known.items() if quantity == "time"), None)
    if time is None:
        return ()
    cells = [row[time].strip('" ') if time < len(row) else "" for row in head.rows]
    marked = [cell for cell in cells if _CLOCK_OR_DATE.search(cell)]
    if len(marked) <= len(cells) / 2:
        return ()
    if sum(map(text_rows.is_stamp, marked)) <= len(marked) / 2:
        raise ValueError(
            f"the column {head.names[time][:60]!r} holds {marked[0][:40]!r}; expected numbers, or "
            "time stamps such as '2026-03-01 10:15:00.250'"
        )
    head.units[time] = "s"
    columns = zip_longest(*head.rows, fillvalue="")
    dates = (sum(text_rows.is_date(cell.strip('" ')) for cell in column) for column in columns)
    date = [place for place, found in enumerate(dates) if found > len(cells) / 2]
    return (time, *date[:1])


def _is_unit_row(cells: Sequence[str], names: Sequence[str], vocabulary: Vocabulary) -> bool:
    """A row right below the names in which most known columns have a unit that fits them."""
    # a row of numbers is the first of the log, whatever units may be called
    if any(cells[len(names) :]) or any(_is_number(cell) for cell in cells):
        return False
    units = [_bare(cell) for cell in cells] + [""] * len(names)
    known = vocabulary.meanings(names, [""] * len(names))
    fitting = [place for place, (of, _) in known.items() if vocabulary.fits(of, units[place])]
    # of a log of something else, some units fit: it must not be told that units are missing
    certain = any(len(units[place]) > 1 for place in fitting)
    return len(fitting) > len(known) / 2 or (
        certain and all(len(unit) <= _LONGEST_UNIT for unit in units)
    )


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
        marks = [mark for mark in (":", "=", delimiter.strip(_BLANKS)) if mark and mark in plain]
        if marks:
            key, _, value = plain.partition(min(marks, key=plain.index))
            # a table program may quote the cells and fill the line with delimiters
            name, text = (part.strip(f'"{delimiter} \t') for part in (plain_key(key), value))
            # two values are none: what needs this key refuses the log
            keys[name] = text if keys.get(name, text) == text else f"{keys[name]} / {text}"
    return keys
