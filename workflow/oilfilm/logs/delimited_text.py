"""Text logs with one row per instant: a header, one line of column names, then the rows.

The only assumption is that one line names the columns and that the rows follow it.
data/raw/README.md describes what may differ between logs.

Decides: how the layout of a text log is found.
"""

import csv
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise, zip_longest
from typing import NamedTuple

from oilfilm.base.plain_key import plain_key
from oilfilm.logs import base, text_rows
from oilfilm.logs.base import TextDialect, UnreadableLogError, check_row_count, parse_decimal
from oilfilm.logs.header import FULL_WIDTH_TO_ASCII, joined_texts, states_oil
from oilfilm.logs.likely_names import likely_line_of_names
from oilfilm.logs.log_schema import QuantitiesAndUnits, Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile

_BLANK_DELIMITER = " "
_DELIMITERS = (",", ";", "\t", "|")
# A line with fewer numbers may be a header line.
_FEWEST_NUMBERS_OF_ROW = 3
_CHARACTERS_SHOWN = 80
# The line of names is near the top of the file.
_LINES_SEARCHED = 200
# The line of names is the one with most known names among so many lines from the first candidate.
_LINES_COMPARED = 20
_COMMENT_LINES = re.compile(rb"^#[^\n]*(?:\n|\Z)", re.MULTILINE)
_SPREADSHEET_ERROR = re.compile(r"#(?:N/A|NV|[^\W\d_]+(?:/0)?[!?])")
_BLANKS_BETWEEN_CELLS = re.compile(rb"[ \t]+")
_BLANKS_AROUND_LINE = re.compile(rb"^[ \t]+|[ \t]+$", re.MULTILINE)
# Two numbers: hours and minutes, or minutes and seconds.
_HOURS_OR_MINUTES = re.compile(r"\d+:\d+")
_CLOCK_OR_DATE = re.compile(r"\d[:/]\d")
# A number in groups of thousands, with a decimal mark behind them. None begins with 0.
_GROUPED_NUMBER = re.compile(
    r"[-+]?[1-9]\d{0,2}(?P<group_mark>[.,])\d{3}"
    r"(?:(?P=group_mark)\d{3})*(?!(?P=group_mark))[.,]\d+"
)
_LONGEST_UNIT = 8
# Limits where blanks separate the columns: words of a name, columns of a log.
_MOST_WORDS_OF_NAME = 5
_FEWEST_COLUMNS = 3
# Text has few control characters among its first characters; other files have more.
_CHARACTERS_JUDGED = 1000
_LARGEST_CONTROL_SHARE = 0.02


@dataclass(frozen=True)
class _Head:
    """The beginning of a text log: the lines above the rows, and the first rows.

    Attributes:
        header_lines: The lines above the names.
        line_count_above_rows: Number of lines above the first row.
        delimiter: Character between cells; a blank for any number of blanks.
        names: Names of the columns.
        units: Unit of each column from a line below the names; empty where there is none.
        first_rows: The first rows, each as a list of its cells.
        has_quotes: Whether quotes occur, so that a cell may hold the delimiter.
    """

    header_lines: Sequence[str]
    line_count_above_rows: int
    delimiter: str
    names: list[str]
    units: list[str]
    first_rows: list[list[str]]
    has_quotes: bool


@dataclass(frozen=True)
class _NameLine:
    """The line of names: its index among the lines of the text, the delimiter, the names."""

    line_index: int
    delimiter: str
    names: list[str]


def recognises(first_bytes: bytes) -> bool:
    """True for any text."""
    first_bytes = text_rows.without_zero_blocks(first_bytes)
    text = text_rows.normalised(first_bytes).decode("utf-8", "replace")
    beginning = text.lstrip("\ufeff \n")[:_CHARACTERS_JUDGED]
    control_characters = [
        character for character in beginning if not (character.isprintable() or character.isspace())
    ]
    is_mostly_text = len(control_characters) <= _LARGEST_CONTROL_SHARE * len(beginning)
    return beginning != "" and "\0" not in beginning[:200] and is_mostly_text


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    encoding = text_rows.encoding_of(content)
    text = text_rows.normalised(content, encoding)
    check_row_count(max(text_rows.count_rows(text) - 1, 0))
    first_dialect, first_table = _table(text, encoding, vocabulary)
    texts_of_blocks = _texts_of_blocks(text, vocabulary)
    if len(texts_of_blocks) < 2:
        return first_dialect, [first_table]
    tables_of_blocks = [
        _table(text_of_block, encoding, vocabulary)[1] for text_of_block in texts_of_blocks
    ]
    names = base.distinct_names(
        f"block{number}" for number, _ in enumerate(texts_of_blocks, start=1)
    )
    return first_dialect, [
        replace(table, run_name=name, text_of_key=text_of_key)
        for table, name, text_of_key in zip(
            tables_of_blocks, names, _header_of_blocks(tables_of_blocks), strict=True
        )
    ]


def _table(text: bytes, encoding: str, vocabulary: Vocabulary) -> tuple[TextDialect, LoggedTable]:
    """How a text with one line of names is written, and its table.

    Args:
        text: The text, as `normalised` gives it.
        encoding: The encoding of the file.
        vocabulary: The names that are known.

    Raises:
        UnreadableLogError: No line names columns, or a row is above it.
    """
    # one of the lines may be that of the names
    row_count = max(text_rows.count_rows(text) - 1, 0)
    try:
        head = _head_of_text(text, vocabulary)
        # a row may be above the names: all lines count
        row_count += 1
        _refuse_row_above_names(head)
        body, start_of_rows = _without_comments(text, head)
        row_count = text_rows.count_rows(body, start_of_rows)
        quantities_and_units = vocabulary.quantities_and_units(head.names, head.units)
        stamp_indices = _stamp_indices(head, quantities_and_units)
    except ValueError as error:
        encoding_in_words = "" if encoding == "ascii" else f"; read as {encoding}"
        raise UnreadableLogError(
            f"{error}{encoding_in_words}", vocabulary.advice, row_count
        ) from error
    if stamp_indices:
        # seconds, in spite of any unit that the log gives
        head.units[stamp_indices[0]] = "s"
    body, delimiter, start_of_rows = _rows_with_plain_cells(body, head, start_of_rows)
    decimal_mark, group_mark = _decimal_and_group_mark(
        head, delimiter, quantities_and_units.keys() - stamp_indices
    )
    text_of_key = _text_of_header_key(head.header_lines, head.delimiter)
    may_grow = (
        "time" in vocabulary.required_quantities
        and text_of_key.get("log_kind") != base.SETTLED_LOG_KIND
    )
    body, notes = _with_line_end(body, start_of_rows, delimiter, len(head.names), may_grow=may_grow)
    text_table = text_rows.TextTable(
        body, len(head.names), delimiter, decimal_mark, group_mark, stamp_indices, start_of_rows
    )
    logged_table = LoggedTable(
        text_of_key,
        head.names,
        head.units,
        text_table.numbers,
        text_table.row_count,
        cut_row_cell_count=text_table.cut_row_cell_count,
        show_row=text_table.row_text,
        read_texts=text_table.texts,
        notes=notes,
        decimal_mark=decimal_mark,
    )
    return TextDialect.from_marks(encoding, head.delimiter, decimal_mark), logged_table


def _texts_of_blocks(text: bytes, vocabulary: Vocabulary) -> list[bytes]:
    """The texts of the blocks of a log: each has header lines, a line of names, and rows.

    The line of names is the same in all blocks. Programs of rigs write one block per step. A line
    of names that a logger repeats without header lines, while time goes on, begins no block.
    """
    head = _head_of_text(text, vocabulary)
    start_of_names = _start_of_line(text, len(head.header_lines))
    line_of_names = text[start_of_names : text.find(b"\n", start_of_names) + 1]
    starts = [0]
    end_of_line_above = text.find(b"\n" + line_of_names, start_of_names) if line_of_names else -1
    while end_of_line_above >= 0:
        start = _start_of_header(text, end_of_line_above + 1, head)
        has_header = start < end_of_line_above + 1
        if has_header or not _is_time_rising(text, end_of_line_above + 1, head, vocabulary):
            starts.append(start)
        end_of_line_above = text.find(b"\n" + line_of_names, end_of_line_above + 1)
    return [text[start:stop] for start, stop in pairwise([*starts, len(text)])]


def _with_line_end(
    body: bytes, start_of_rows: int, delimiter: str, width: int, *, may_grow: bool
) -> tuple[bytes, tuple[str, ...]]:
    """The text with a line end behind the last row, if this row is complete, and a note on it.

    The last row is complete where it has all its cells and its last number is as long as those
    above it: a number that was cut is shorter. In a log that may still be written, all of them
    must have the same number of decimals, too.

    Args:
        body: A text that ends in the rows.
        start_of_rows: Position of the first row.
        delimiter: Character between cells.
        width: Number of cells of a row.
        may_grow: Whether the log may still be written; settled readings are a finished table.
    """
    if body.endswith(b"\n") or len(body) <= start_of_rows:
        return body, ()
    lines = body[max(start_of_rows, len(body) - text_rows.HEAD_BYTES) :].decode("utf-8", "replace")
    *rows_above, last_row = [line.split(delimiter) for line in lines.split("\n")]
    lengths_above = [_length_of_number(row[-1]) for row in rows_above if len(row) == width]
    if len(last_row) != width or not lengths_above:
        return body, ()
    last_length = _length_of_number(last_row[-1])
    # an empty cell is no short number
    lengths_of_numbers = [length for length in lengths_above if length.whole >= 0]
    lengths_above = lengths_of_numbers or lengths_above
    shortest_whole = min(length.whole for length in lengths_above)
    fewest_decimals = min(length.decimals for length in lengths_above)
    most_decimals = max(length.decimals for length in lengths_above)
    if last_length.whole < shortest_whole or last_length.decimals < fewest_decimals:
        return body, ()
    if may_grow and last_length.decimals < most_decimals:
        return body, ()
    note = (
        "the last row has no line end; it is used, because it has all its cells and its last "
        "number is as long as those above it"
    )
    return body + b"\n", (note,)


class _NumberLength(NamedTuple):
    """Number of digits before and behind a decimal mark; -1 and -1 where a cell has no number."""

    whole: int
    decimals: int


def _length_of_number(cell: str) -> _NumberLength:
    bare_number = _bare_cell(cell)
    if not _is_number(bare_number):
        return _NumberLength(-1, -1)
    whole, _, decimals = bare_number.lstrip("+-").replace(",", ".").partition(".")
    return _NumberLength(len(whole), len(decimals))


def _start_of_line(text: bytes, line_index: int) -> int:
    """Position in a text of the first byte of the line with an index."""
    position = 0
    for _ in range(line_index):
        position = text.index(b"\n", position) + 1
    return position


def _start_of_header(text: bytes, start_of_names: int, head: _Head) -> int:
    """Position of the first header line above a line of names: behind the last row above it.

    Args:
        text: The text.
        start_of_names: Position of the line of names.
        head: The lines above the first row.
    """
    start = start_of_names
    while start > 0:
        start_of_line_above = text.rfind(b"\n", 0, start - 1) + 1
        line = text[start_of_line_above : start - 1].decode("utf-8", "replace")
        if _is_row_above_names(line, head):
            return start
        start = start_of_line_above
    return start


def _is_row_above_names(line: str, head: _Head) -> bool:
    """Whether a line above a repeated line of names is a row, perhaps a damaged one.

    It has a cell for each name, and most of them are numbers, or the first one is, or none is
    empty. A table program fills header lines with empty cells.
    """
    cells = _cells_of_line(line, head.delimiter)
    if len(cells) < len(head.names):
        return False
    is_number = [_is_number(cell) or text_rows.is_stamp(cell) for cell in cells]
    if sum(is_number) > len(cells) / 2:
        return True
    # blanks separate the words of a header line, too
    if head.delimiter == _BLANK_DELIMITER or line.startswith("#") or cells == head.names:
        return False
    return len(cells) == len(head.names) and (is_number[0] or all(cells))


def _is_time_rising(text: bytes, start_of_names: int, head: _Head, vocabulary: Vocabulary) -> bool:
    """Whether time rises from the row above a repeated line of names to the row below it."""
    quantities_and_units = vocabulary.quantities_and_units(head.names, head.units)
    time_index = next(
        (index for index, (quantity, _) in quantities_and_units.items() if quantity == "time"), None
    )
    if time_index is None:
        return False
    lines_above = text[:start_of_names][-text_rows.HEAD_BYTES :].split(b"\n")[-_LINES_COMPARED:]
    lines_below = text[start_of_names : start_of_names + text_rows.HEAD_BYTES].split(b"\n")[1:3]

    def time_cells_of(lines: Iterable[bytes]) -> list[str]:
        """The time in each line where its cell begins with a digit: damaged rows have no time."""
        time_cells: list[str] = []
        for line in lines:
            cells = _cells_of_line(line.decode("utf-8", "replace"), head.delimiter)
            cell = cells[time_index].strip('" ') if time_index < len(cells) else ""
            if cell[:1].isdigit():
                time_cells.append(cell)
        return time_cells

    cells_above, cells_below = time_cells_of(lines_above), time_cells_of(lines_below)
    neighbours = [*cells_above[-1:], *cells_below]
    if len(neighbours) < 2:
        return False
    earlier, later = neighbours[:2]
    try:
        return parse_decimal(later) > parse_decimal(earlier)
    except ValueError:
        # time stamps of one log have one form
        return later > earlier


def _header_of_blocks(tables_of_blocks: Sequence[LoggedTable]) -> list[Mapping[str, str]]:
    """Header keys of each block; those that only the first block gives hold for all blocks."""
    first_table, *other_tables = tables_of_blocks
    keys_in_other_blocks = {key for table in other_tables for key in table.text_of_key}
    # the oil is one key, whatever its lines are called
    has_oil_in_other_blocks = any(states_oil(table.text_of_key) for table in other_tables)
    text_of_file_key = {
        key: text
        for key, text in first_table.text_of_key.items()
        if key not in keys_in_other_blocks
        and not (has_oil_in_other_blocks and states_oil({key: text}))
    }
    return [text_of_file_key | dict(table.text_of_key) for table in tables_of_blocks]


def _without_comments(text: bytes, head: _Head) -> tuple[bytes, int]:
    """A text that ends in the rows, without comments between them, and where they start."""
    lines_above = text[: text_rows.HEAD_BYTES].split(b"\n", head.line_count_above_rows)[
        : head.line_count_above_rows
    ]
    start_of_rows = sum(len(line) for line in lines_above) + len(lines_above)
    # searched first: most logs have no comments there, and to replace them takes much longer
    if text.find(b"\n#", max(start_of_rows - 1, 0)) < 0:
        return text, start_of_rows
    text_of_rows = _COMMENT_LINES.sub(
        lambda match: _row_or_empty(match[0], head), text[start_of_rows:]
    )
    return text_of_rows, 0


def _head_of_text(text: bytes, vocabulary: Vocabulary) -> _Head:
    """The lines of names and of units, and the first rows.

    Raises:
        ValueError: No line names columns.
    """
    beginning = text[: text_rows.HEAD_BYTES].decode("utf-8", "replace")
    # tested first: most logs are ASCII, and to translate takes longer
    if not beginning.isascii():
        beginning = beginning.translate(FULL_WIDTH_TO_ASCII)
    lines = beginning.split("\n", _LINES_SEARCHED)[:_LINES_SEARCHED]
    line_of_names = _line_of_names(lines, vocabulary)
    names, delimiter = line_of_names.names, line_of_names.delimiter
    line_count_above_rows = line_of_names.line_index + 1
    first_rows: list[list[str]] = []
    line_index_of_row: list[int] = []
    for line_index, line in enumerate(lines[line_count_above_rows:], start=line_count_above_rows):
        is_comment = line.startswith("#") and not _is_row_with_hash(line, delimiter, len(names))
        if line.strip() and not is_comment:
            first_rows.append(_cells_of_line(line, delimiter))
            line_index_of_row.append(line_index)
    units = [""] * len(names)
    if first_rows and _is_unit_row(first_rows[0], names, vocabulary):
        units = [_bare_cell(cell) for cell in first_rows.pop(0)]
        line_count_above_rows = line_index_of_row[0] + 1
    width = _row_width(first_rows, names)
    empty_cells = [""] * width
    return _Head(
        header_lines=lines[: line_of_names.line_index],
        line_count_above_rows=line_count_above_rows,
        delimiter=delimiter,
        names=[*names, *empty_cells][:width],
        units=[*units, *empty_cells][:width],
        first_rows=first_rows,
        has_quotes='"' in beginning,
    )


def _row_width(first_rows: Sequence[Sequence[str]], names: Sequence[str]) -> int:
    """Number of cells of a row: as in most rows, or as many as names where the two contradict.

    Rows, or the names alone, may have a delimiter behind the last cell.
    """
    if not first_rows:
        return len(names)
    width = _most_frequent(len(row) for row in first_rows)
    would_lose_names = any(names[width:])
    would_lose_cells = width > len(names) and any(
        any(row[len(names) :]) for row in first_rows if len(row) == width
    )
    return len(names) if would_lose_names or would_lose_cells else width


def _most_frequent(numbers: Iterable[int]) -> int:
    """The number that occurs most often, the first of equals; 0 where there is none."""
    counts = Counter(numbers)
    return max(counts, key=lambda number: counts[number], default=0)


def _is_row_with_hash(line: str, delimiter: str, width: int) -> bool:
    """Whether a `#` line below the names is a row: spreadsheets write their errors as #N/A.

    It is a row in each of these cases:

    - its first cell is such an error;
    - it has as many cells as names (not where blanks separate cells: they separate words too);
    - more than half of the cells are numbers or errors.
    """
    cells = _cells_of_line(line, delimiter)
    if _SPREADSHEET_ERROR.fullmatch(cells[0]):
        return True
    if delimiter != _BLANK_DELIMITER and len(cells) == width:
        return True
    number_cells = [cell for cell in cells if cell.startswith("#") or _is_number(cell)]
    return len(number_cells) > width / 2


def _row_or_empty(line: bytes, head: _Head) -> bytes:
    """The `#` line itself where it is a row; empty where it is a comment."""
    line_text = line.decode("utf-8", "replace")
    return line if _is_row_with_hash(line_text, head.delimiter, len(head.names)) else b""


def _refuse_row_above_names(head: _Head) -> None:
    """Refuse a log with a row above the line of names, which would be taken for a header line.

    Raises:
        ValueError: A line above has numbers in the same cells as the first row.
    """
    if not head.first_rows:
        return
    is_number = [_is_number(cell) for cell in head.first_rows[0]]
    if sum(is_number) < _FEWEST_NUMBERS_OF_ROW:
        return
    for number, line in enumerate(head.header_lines, start=1):
        cells = _cells_of_line(line, head.delimiter)
        if [_is_number(cell) or cell.startswith("#") for cell in cells] == is_number:
            raise ValueError(
                f"line {number} reads {line[:_CHARACTERS_SHOWN]!r}, which looks like a row, but is "
                "above the line of names; put the names above all rows"
            )


def _line_of_names(lines: Sequence[str], vocabulary: Vocabulary) -> _NameLine:
    """The line that names the columns.

    Raises:
        ValueError: No line does.
    """
    uncommented_line_of_index: dict[int, str] = {}
    comment_of_index: dict[int, str] = {}
    for line_index, line in enumerate(lines):
        if line.lstrip().startswith("#"):
            comment_of_index[line_index] = line.lstrip("# \t")
        else:
            uncommented_line_of_index[line_index] = line
    # some programs write the names as a comment
    for candidates in (uncommented_line_of_index, comment_of_index):
        line_of_names = _line_with_most_known_names(candidates, vocabulary)
        if line_of_names is not None:
            return line_of_names
    hint = ""
    for line_index, line in enumerate(lines):
        width = _width_between_blanks(lines[line_index + 1 : line_index + 1 + _LINES_COMPARED])
        if width < _FEWEST_COLUMNS:
            continue
        for names in _names_between_blanks(line, vocabulary):
            if _known_name_count(names, vocabulary) >= 2:
                if len(names) == width:
                    return _NameLine(line_index, _BLANK_DELIMITER, names)
                hint = f": blanks part {width} columns, but {len(names)} names; write these without"
    if not hint:
        first_line = next((line for line in uncommented_line_of_index.values() if line.strip()), "")
        hint = f"; its first line is {first_line[:120]!r}" if first_line else ""
        commented_names = _names_in_comment(comment_of_index.values(), first_line)
        likely_line = likely_line_of_names(lines)
        if commented_names:
            hint = f"; the names in its comment are {commented_names[:120]!r}"
        elif likely_line is not None:
            line_number, text = likely_line
            hint = f"; the names seem to be in line {line_number}: {text.strip()[:160]!r}"
    raise ValueError(f"no line names columns of a {vocabulary.name} log{hint}")


def _names_in_comment(comments: Collection[str], row: str) -> str:
    """The last comment that has as many cells as a row, and no number; empty without one."""
    names = ""
    for delimiter in _DELIMITERS:
        width = len(_cells_of_line(row, delimiter))
        for comment in comments:
            cells = _cells_of_line(comment, delimiter)
            if width > 1 and len(cells) == width and not any(map(_is_number, cells)):
                names = comment
    return names


def _line_with_most_known_names(
    line_of_index: Mapping[int, str], vocabulary: Vocabulary
) -> _NameLine | None:
    """The line with the most known names, two or more; None where there is no such line.

    Args:
        line_of_index: Index of a line -> its text.
        vocabulary: The names that are known.
    """
    best_line: _NameLine | None = None
    largest_count = 1
    for line_index, line in line_of_index.items():
        if best_line and line_index > best_line.line_index + _LINES_COMPARED:
            break
        for delimiter in _DELIMITERS:
            names = _cells_of_line(line, delimiter)
            if len(names) <= largest_count or _is_number(names[0]):
                continue
            known_count = _known_name_count(names, vocabulary)
            if known_count > largest_count:
                best_line = _NameLine(line_index, delimiter, names)
                largest_count = known_count
    return best_line


def _known_name_count(names: Sequence[str], vocabulary: Vocabulary) -> int:
    return sum(vocabulary.quantity_and_unit(name) is not None for name in names)


def _width_between_blanks(lines: Sequence[str]) -> int:
    """Number of cells between blanks in most rows of numbers; 0 where there are none."""
    rows = [line.split() for line in lines if line.strip()]
    return _most_frequent(
        len(row)
        for row in rows
        if _is_number(row[0]) or text_rows.is_stamp(row[0]) or text_rows.is_date(row[0])
    )


def _names_between_blanks(line: str, vocabulary: Vocabulary) -> Iterator[list[str]]:
    """The names of a line in which blanks separate them, found in three ways.

    Each word is a name; names are separated by two blanks or a tab; words that together are a known
    name are one name.
    """
    line = line.lstrip("# \t")
    words = line.split()
    yield words
    yield [name for name in re.split(r"\s{2,}|\t", line.strip()) if name]
    names: list[str] = []
    first_word_index = 0
    while first_word_index < len(words):
        word_count = _word_count_of_known_name(words[first_word_index:], vocabulary)
        names.append(" ".join(words[first_word_index : first_word_index + word_count]))
        first_word_index += word_count
    yield names


def _word_count_of_known_name(words: Sequence[str], vocabulary: Vocabulary) -> int:
    """How many of the first words are the longest known name; 1 where none is known."""
    for count in range(min(_MOST_WORDS_OF_NAME, len(words)), 1, -1):
        if vocabulary.quantity_and_unit(" ".join(words[:count])):
            return count
    return 1


def _cells_of_line(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without blanks around them."""
    if delimiter == _BLANK_DELIMITER:
        return line.split()
    cells = line.split(delimiter)
    if '"' in line:
        with suppress(csv.Error):
            cells = next(csv.reader([line], delimiter=delimiter), [])
    return [cell.strip() for cell in cells]


def _rows_with_plain_cells(body: bytes, head: _Head, start_of_rows: int) -> tuple[bytes, str, int]:
    """A text of the rows with a delimiter that no cell holds, this delimiter, and their start."""
    if head.delimiter == _BLANK_DELIMITER:
        text_of_rows = _BLANKS_AROUND_LINE.sub(b"", body[start_of_rows:])
        text_of_rows = _BLANKS_BETWEEN_CELLS.sub(b"\t", text_of_rows)
        return text_rows.normalised(text_of_rows, "ascii"), "\t", 0
    cells_hold_delimiter = head.has_quotes and any(
        head.delimiter in cell for row in head.first_rows for cell in row
    )
    if not cells_hold_delimiter:
        return body, head.delimiter, start_of_rows
    # line by line: an unpaired quote then harms one row only
    lines = body[start_of_rows:].decode("utf-8").split("\n")
    text = "\n".join("\t".join(_cells_of_line(line, head.delimiter)) for line in lines)
    return text_rows.normalised(text.encode(), "ascii"), "\t", 0


def _decimal_and_group_mark(
    head: _Head, delimiter: str, number_indices: Set[int]
) -> tuple[str, str]:
    """Decimal mark and mark between thousands (empty without one), by the columns of numbers."""
    if delimiter == "," and not head.has_quotes:
        return ".", ""
    # from all of the first rows: one row may hold whole numbers only
    cells_with_comma = []
    # a row with an unpaired quote has few cells, which hold commas
    complete_rows = [row for row in head.first_rows if len(row) == len(head.names)]
    for row in complete_rows:
        cells = [_bare_cell(row[index]) for index in number_indices]
        cells_with_comma += [cell for cell in cells if "," in cell]
    for cell in cells_with_comma:
        grouped_number = _GROUPED_NUMBER.fullmatch(cell)
        if grouped_number:
            return (",", ".") if grouped_number["group_mark"] == "." else (".", ",")
    has_decimal_comma = cells_with_comma and delimiter != ","
    return "," if has_decimal_comma else ".", ""


def _stamp_indices(head: _Head, quantities_and_units: QuantitiesAndUnits) -> tuple[int, ...]:
    """Indices of the columns of time stamps, see `TextTable`; empty where time is a number.

    Raises:
        ValueError: The time is neither a number nor a time stamp.
    """
    time_index = next(
        (index for index, (quantity, _) in quantities_and_units.items() if quantity == "time"), None
    )
    if time_index is None:
        return ()
    cells = [
        row[time_index].strip('" ') if time_index < len(row) else "" for row in head.first_rows
    ]
    with_colon_or_slash = [cell for cell in cells if _CLOCK_OR_DATE.search(cell)]
    if len(with_colon_or_slash) <= len(cells) / 2:
        return ()
    stamps = [cell for cell in with_colon_or_slash if text_rows.is_stamp(cell)]
    if len(stamps) <= len(with_colon_or_slash) / 2:
        raise ValueError(
            f"the column {head.names[time_index][:60]!r} holds {with_colon_or_slash[0][:40]!r}; "
            "expected "
            "numbers, or time stamps such as '2026-03-01 10:15:00.250'"
        )
    for index, column in enumerate(zip_longest(*head.first_rows, fillvalue="")):
        dates = [cell for cell in column if text_rows.is_date(cell.strip('" '))]
        if len(dates) > len(cells) / 2:
            return time_index, index
    for cell in stamps:
        if _HOURS_OR_MINUTES.fullmatch(cell):
            raise ValueError(
                f"the column {head.names[time_index][:60]!r} holds {cell[:40]!r}, which may be "
                "hours and minutes or minutes and seconds; expected all three, as '00:10:15'"
            )
    return (time_index,)


def _is_unit_row(cells: Sequence[str], names: Sequence[str], vocabulary: Vocabulary) -> bool:
    """Whether the row below the names has units: most known columns have a usable unit there."""
    number_cells = [_bare_cell(cell) for cell in cells if _is_number(cell)]
    # a row with a number is the first row of the log; 1 is the unit of a ratio
    if any(cells[len(names) :]) or any(cell != "1" for cell in number_cells):
        return False
    units = [_bare_cell(cell) for cell in cells] + [""] * len(names)
    quantities_and_units = vocabulary.quantities_and_units(names, [""] * len(names))
    fitting_indices = [
        index
        for index, (quantity, _) in quantities_and_units.items()
        if vocabulary.is_convertible(quantity, units[index])
    ]
    if len(fitting_indices) > len(quantities_and_units) / 2:
        return True
    # in a log of another kind only some units fit; its message must not be that units are missing
    has_long_unit = any(len(units[index]) > 1 for index in fitting_indices)
    return has_long_unit and not number_cells and all(len(unit) <= _LONGEST_UNIT for unit in units)


def _is_number(cell: str) -> bool:
    try:
        float(_bare_cell(cell).replace(",", "."))
    except ValueError:
        return False
    return True


def _bare_cell(cell: str) -> str:
    """A cell without brackets, quotes and blanks around it."""
    return cell.strip('[]() "')


def _text_of_header_key(lines: Sequence[str], delimiter: str) -> dict[str, str]:
    """Header keys from `key: value` lines above the names, with or without `#`.

    The mark between key and value is the first of `:`, `=` and the delimiter.
    """
    marks = {":", "=", delimiter} - {_BLANK_DELIMITER}
    keys_and_texts: list[tuple[str, str]] = []
    for line in lines:
        text = line.strip().lstrip("#").strip()
        marks_of_line = [mark for mark in marks if mark in text]
        if not marks_of_line:
            continue
        key, _, value = text.partition(min(marks_of_line, key=text.index))
        # a table program may quote the cells and fill the line with delimiters
        surplus = f'"{delimiter} \t'
        keys_and_texts.append((plain_key(key).strip(surplus), value.strip(surplus)))
    return joined_texts(keys_and_texts)
