"""Excel workbooks, and what all spreadsheets share: a sheet is read as a text log, and is a run.

A small archive may hold very many cells, one cell very far away, or rows of very different
lengths. Each is refused before it fills the memory.

Decides: how large a workbook may be, and how its cells are read.
"""

import datetime
import io
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from contextlib import closing, suppress
from dataclasses import replace
from functools import lru_cache
from typing import IO, Any, NamedTuple
from xml.parsers import expat

from oilfilm.logs import base, delimited_text
from oilfilm.logs.base import NO_DIALECT, UnreadableLogError
from oilfilm.logs.likely_names import is_line_of_units
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile

# Value of a cell, and whether the sheet shows it in percent.
ValueAndPercent = tuple[Any, bool]
# A workbook is a zip archive, which begins with these bytes.
ZIP_SIGNATURE = b"PK\x03\x04"
_MEMBERS_OF_WORKBOOK = (b"[Content_Types].xml", b"_rels/.rels", b"xl/", b"docProps/")
_MIB = 1 << 20
MOST_UNPACKED_BYTES = 64 * _MIB
# Excel's own limit.
LAST_ROW = 1_048_576
# Limit on cells. Empty cells before the last cell of a row count: openpyxl creates them.
MOST_CELLS = 10_000_000
_CHUNK_BYTES = 1 << 20
_HAS_LETTER = re.compile(r"[^\W\d_]")
# Fewest numbers of a row of numbers. A line of a title may have one, as `Load | 20 | N`.
_FEWEST_NUMBERS = 2
# Rows of texts above numbers that are kept.
_MOST_ROWS_OF_TEXTS = 20
_ONLY_PERCENT = re.compile(r"[\s\[(]*%[\s\])]*")
_NUMBER_ALONE = re.compile(r"(?<!\S)\d+([.,]\d+)?(?!\S)")
# Texts in quotes, a letter behind a backslash or behind the marks for gaps and filling, and colours
# and languages in square brackets.
_TEXTS_OF_FORMAT = re.compile(r'"[^"]*"|[\\_*].|\[[^\]]*\]')


class SheetText(NamedTuple):
    """A sheet as the text log that it would be.

    Attributes:
        title: Title of the sheet.
        text: Tab-separated UTF-8.
        fraction_columns: Indices of the columns that the sheet shows in percent, and whose numbers
            are fractions in the text.
    """

    title: str
    text: bytes
    fraction_columns: Set[int] = frozenset()


def recognises(first_bytes: bytes) -> bool:
    """True for a zip archive with the parts of an Office document."""
    return first_bytes.startswith(ZIP_SIGNATURE) and any(
        name in first_bytes for name in _MEMBERS_OF_WORKBOOK
    )


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    return tables_of_sheets(sheet_texts(content), vocabulary)


def tables_of_sheets(sheets: Iterable[SheetText], vocabulary: Vocabulary) -> TablesOfFile:
    """The tables of the sheets of a workbook; a sheet without a table is named in a note.

    Args:
        sheets: The sheets as texts.
        vocabulary: The names that are known, with their quantities and units.

    Raises:
        UnreadableLogError: No sheet has a table.
    """
    logged_tables: list[LoggedTable] = []
    titles: list[str] = []
    titles_not_read: list[str] = []
    first_error: UnreadableLogError | None = None
    for title, text, fraction_columns in sheets:
        try:
            _, tables_of_sheet = delimited_text.tables(text, vocabulary)
        except UnreadableLogError as error:
            titles_not_read.append(title)
            first_error = first_error or error
            continue
        for table in tables_of_sheet:
            logged_tables.append(with_units_of_fractions(table, fraction_columns))
            titles.append(f"{title} {table.run_name}".strip())
    if not logged_tables:
        raise first_error or UnreadableLogError(
            "no sheet of the workbook has a cell", rule="no_rows"
        )
    if titles_not_read:
        listed_titles = ", ".join(map(repr, titles_not_read[:10]))
        note = (
            f"no columns of a {vocabulary.name} log in the sheets {listed_titles}: they are not "
            "read"
        )
        logged_tables[0] = logged_tables[0].with_note(note)
    if len(logged_tables) == 1:
        return NO_DIALECT, logged_tables
    names = base.distinct_names(titles)
    return NO_DIALECT, [
        table.with_name(name) for table, name in zip(logged_tables, names, strict=True)
    ]


def with_units_of_fractions(table: LoggedTable, fraction_columns: Set[int]) -> LoggedTable:
    """The table with the unit 1 beside fractions without a unit: their cells look like percent."""
    units = list(table.units)
    for index in fraction_columns:
        # another table of the sheet may have a percent sign there
        if index < len(units) and not units[index] and "%" not in table.names[index]:
            units[index] = "1"
    return replace(table, units=units)


def sheet_texts(content: bytes) -> list[SheetText]:
    """Each sheet with a cell as a text.

    Raises:
        ValueError: The workbook is too large.
        Exception: Any error that the library raises for a damaged workbook.
    """
    # imported where needed: few logs are workbooks
    import openpyxl  # noqa: PLC0415

    texts: list[SheetText] = []
    character_count = 0
    with closing(
        openpyxl.load_workbook(checked_workbook(content), read_only=True, data_only=True)
    ) as workbook:
        for sheet in workbook.worksheets:
            # the size that a sheet states may be wrong: it is read to its last cell
            sheet.reset_dimensions()
            lines: list[str] = []
            percent_columns = PercentColumns()
            for row in sheet.iter_rows():
                cells = [_value_and_percent(cell.value, cell.number_format or "") for cell in row]
                percent_columns.add_row(cells)
                line = line_of_cells(cells, percent_columns.in_percent)
                if line:
                    lines.append(line)
                    character_count += len(line)
                # many cells may share one long text
                check_character_count(character_count)
            if lines:
                texts.append(
                    SheetText(sheet.title, tab_separated_bytes(lines), percent_columns.of_fractions)
                )
    return texts


def _value_and_percent(value: Any, number_format: str) -> ValueAndPercent:
    """The value of a cell, and whether the sheet shows it in percent.

    A day that is shown without hours is a date alone: the time of day is in another column.
    """
    format_code = _format_without_texts(number_format)
    if isinstance(value, datetime.datetime) and "d" in format_code and "h" not in format_code:
        return date_if_midnight(value), False
    return value, "%" in format_code


def date_if_midnight(instant: datetime.datetime) -> datetime.datetime | datetime.date:
    """An instant at midnight as a date; any other as it is."""
    return instant if instant.time() != datetime.time() else instant.date()


@lru_cache(maxsize=1024)
def _format_without_texts(number_format: str) -> str:
    r"""A number format without the texts in it: a percent sign in a text multiplies no number.

    Examples:
        >>> [_format_without_texts(text) for text in ('0.0%', '0.0"%"', r'0.0\%', '[Red]0.0%')]
        ['0.0%', '0.0', '0.0', '0.0%']
    """
    return _TEXTS_OF_FORMAT.sub("", number_format).lower()


def check_character_count(character_count: int) -> None:
    """Refuse a workbook whose cells have too many characters.

    Raises:
        ValueError: They have more characters than `MOST_UNPACKED_BYTES`: each has at least one
            byte.
    """
    if character_count > MOST_UNPACKED_BYTES:
        raise ValueError(f"its cells hold more than {MOST_UNPACKED_BYTES // _MIB} MiB")


class PercentColumns:
    """The columns of a sheet whose name or unit has a percent sign, while its rows are read.

    Names and units are in the rows of texts right above a row of numbers. A percent sign in any
    other row is in a note. Below rows of numbers the marks stay, until a row has the names of all
    columns of numbers, or numbers are in other columns.

    Attributes:
        in_percent: Indices of these columns at the last row that was added.
        of_fractions: Indices of other columns that the sheet shows in percent, in any row.
    """

    def __init__(self) -> None:
        self.in_percent: Set[int] = frozenset()
        self.of_fractions: Set[int] = frozenset()
        # columns with numbers below the last names
        self._number_columns: Set[int] = frozenset()
        # texts by column, of the rows of texts since the last row of numbers
        self._rows_of_texts: list[Mapping[int, str]] = []

    def add_row(self, cells: Sequence[ValueAndPercent]) -> None:
        """Add the next row: the value of each cell, and whether the sheet shows it in percent."""
        texts = {index: value for index, (value, _) in enumerate(cells) if isinstance(value, str)}
        number_columns = {
            index
            for index, (value, is_in_percent) in enumerate(cells)
            if _is_number(value, is_in_percent, is_among_texts=bool(texts))
        }
        if not number_columns:
            self._rows_of_texts = [*self._rows_of_texts[-_MOST_ROWS_OF_TEXTS:], texts]
            return
        if len(number_columns) < _FEWEST_NUMBERS:
            return
        index_of_names = self._index_of_names(number_columns)
        if index_of_names is not None:
            self.in_percent = _marked_columns(self._rows_of_texts[index_of_names:])
            self._number_columns = frozenset()
        self._number_columns |= number_columns
        shown_in_percent = {index for index in number_columns if cells[index][1]}
        self.of_fractions |= shown_in_percent - self.in_percent
        self._rows_of_texts = []

    def _index_of_names(self, number_columns: Set[int]) -> int | None:
        """Index of the row of names among the rows of texts; None where there is none.

        Args:
            number_columns: Columns with numbers in the row below.
        """
        # numbers in other columns than before are those of another table; a title may have some
        has_new_columns = not number_columns <= self._number_columns
        columns_to_name = number_columns if has_new_columns else self._number_columns
        for index in reversed(range(len(self._rows_of_texts))):
            texts = self._rows_of_texts[index]
            if _names_all_columns(texts, columns_to_name) and not is_line_of_units(
                list(texts.values())
            ):
                return index
        if not has_new_columns or not self._rows_of_texts:
            return None
        # some columns have no name, or a name has a number
        word_counts = [_word_count(texts) for texts in self._rows_of_texts]
        largest_count = max(word_counts)
        is_note = largest_count < len(number_columns) / 2
        return None if is_note else word_counts.index(largest_count)


def _marked_columns(rows_from_names: Sequence[Mapping[int, str]]) -> Set[int]:
    """Columns with a percent sign in the row of names, in rows of units or as a unit alone."""
    names, *rows_below = rows_from_names
    marked_columns = {index for index, text in names.items() if "%" in text}
    for texts in rows_below:
        has_units = is_line_of_units(list(texts.values()))
        for index, text in texts.items():
            if _ONLY_PERCENT.fullmatch(text) or (has_units and "%" in text):
                marked_columns.add(index)
    return marked_columns


def _word_count(texts: Mapping[int, str]) -> int:
    """Number of different texts with letters: `NaN` in all cells is no row of names."""
    return len({text for text in texts.values() if _HAS_LETTER.search(text)})


def _names_all_columns(texts: Mapping[int, str], number_columns: Set[int]) -> bool:
    """Whether a row of texts names all columns of numbers; a note, as `Load 20 N`, has numbers."""
    return (
        number_columns <= texts.keys()
        and _word_count(texts) > 1
        and not any(_NUMBER_ALONE.search(text) for text in texts.values())
    )


def _is_number(value: Any, is_in_percent: bool, *, is_among_texts: bool) -> bool:
    """Whether a cell has a number or an instant. Among texts a bare 1 may be a ratio's unit."""
    if value is None or isinstance(value, str):
        return False
    return value != 1 or is_in_percent or not is_among_texts


def line_of_cells(cells: Sequence[ValueAndPercent], columns_in_percent: Set[int]) -> str:
    """The texts of a row up to its last filled cell, with tabs between them.

    A number that the sheet shows as 5 % is 0.05 in its cell. It becomes 5 in a column whose
    name or unit has a percent sign.

    Args:
        cells: The value of each cell, and whether the sheet shows it in percent.
        columns_in_percent: Columns whose name or unit has a percent sign.
    """
    texts: list[str] = []
    for index, (value, is_in_percent) in enumerate(cells):
        if isinstance(value, (int, float)) and is_in_percent:
            shown_number = 100 * value if index in columns_in_percent else value
            texts.append(f"{shown_number:.12g}")
        else:
            texts.append(_cell_text(value))
    return "\t".join(texts).rstrip("\t")


def tab_separated_bytes(lines: Sequence[str]) -> bytes:
    """Lines of cells as a text: each line is filled to the same number of cells.

    Raises:
        ValueError: As in `check_character_count`; the filling counts.
    """
    tab_counts = [line.count("\t") for line in lines]
    most_tabs = max(tab_counts)
    check_character_count(sum(map(len, lines)) + most_tabs * len(lines) - sum(tab_counts))
    filled_lines = [
        line + "\t" * (most_tabs - tab_count)
        for line, tab_count in zip(lines, tab_counts, strict=True)
    ]
    return ("\n".join(filled_lines) + "\n").encode()


def _cell_text(value: Any) -> str:
    """The text of a value: numbers with all digits, instants by ISO 8601, durations as h:mm:ss."""
    if value is None:
        return ""
    if isinstance(value, datetime.datetime):
        # a workbook holds days as numbers: behind milliseconds there are rounding errors
        rounded = value + datetime.timedelta(microseconds=500)
        return rounded.isoformat(sep=" ", timespec="milliseconds")
    if isinstance(value, datetime.timedelta):
        # with colons, because the unit in the name of its column need not be seconds
        sign = "-" if value < datetime.timedelta() else ""
        hours, rest = divmod(abs(value), datetime.timedelta(hours=1))
        return f"{sign}{hours}:{str(rest).removeprefix('0:')}"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:.0f}" if float(value).is_integer() else repr(value)
    return " ".join(str(value).split())


def checked_workbook(content: bytes) -> io.BytesIO:
    """An Excel workbook that can be opened: its bytes, rows and cells are counted before.

    Raises:
        ValueError: It has more than 64 MiB when it is unpacked, a row that no sheet has, or more
            than ten million cells.
    """
    archive = zipfile.ZipFile(io.BytesIO(content))
    unpacked_size = sum(member.file_size for member in archive.infolist())
    if unpacked_size > MOST_UNPACKED_BYTES:
        raise ValueError(
            f"unpacked it has {unpacked_size // _MIB} MiB; expected at most "
            f"{MOST_UNPACKED_BYTES // _MIB}"
        )
    cell_count = 0
    for member in archive.infolist():
        # any part may be a sheet; what is no XML, as a picture, ends at its first bytes
        with suppress(expat.ExpatError):
            cell_count += _count_cells(archive, member, MOST_CELLS - cell_count)
    return io.BytesIO(content)


def _count_cells(archive: zipfile.ZipFile, member: zipfile.ZipInfo, most_cells: int) -> int:
    """Number of cells of a sheet, each row filled up to its last cell.

    Raises:
        ValueError: A row is beyond the last one of any sheet, or there are too many cells.
    """
    row_number = filled_column_count = cell_count = 0

    def start_element(name: str, attributes: dict[str, str]) -> None:
        nonlocal row_number, filled_column_count, cell_count
        tag = name.rpartition(":")[2]
        if tag == "row":
            row_number = int(attributes.get("r", row_number + 1))
            filled_column_count = 0
            if row_number > LAST_ROW:
                raise ValueError(f"it has a row {row_number}; expected at most {LAST_ROW}")
        elif tag == "c":
            column_letters = attributes.get("r", "").rstrip("0123456789")
            column_number = (
                _column_number(column_letters) if column_letters else filled_column_count + 1
            )
            cell_count += max(column_number - filled_column_count, 0)
            filled_column_count = max(column_number, filled_column_count)
            if cell_count > most_cells:
                raise ValueError(f"it has more than {MOST_CELLS} cells, with empty ones between")

    def refuse_entity(*_: object) -> None:
        raise ValueError("a sheet declares entities, which no spreadsheet program writes")

    parser = expat.ParserCreate()
    parser.StartElementHandler = start_element
    parser.EntityDeclHandler = refuse_entity
    with archive.open(member) as sheet:
        for chunk in chunks_of(sheet):
            parser.Parse(chunk, False)
        parser.Parse(b"", True)
    return cell_count


def chunks_of(sheet: IO[bytes]) -> Iterator[bytes]:
    """The bytes of a part of an archive, a mebibyte at a time."""
    chunk = sheet.read(_CHUNK_BYTES)
    while chunk:
        yield chunk
        chunk = sheet.read(_CHUNK_BYTES)


def _column_number(letters: str) -> int:
    """The number of a column by its letters, from 1.

    Examples:
        >>> [_column_number(letters) for letters in ("A", "Z", "AA", "XFD")]
        [1, 26, 27, 16384]
    """
    number = 0
    for letter in letters[:4].upper():
        number = 26 * number + ord(letter) - ord("A") + 1
    return number
