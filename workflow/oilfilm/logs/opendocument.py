"""OpenDocument spreadsheets (.ods): a sheet is read as the text log that it would be, and is a run.

The XML is read once, as it is unpacked. No more of it is held than the texts of the cells, because
a repeated cell or row takes a few bytes and may stand for millions.

Source: OASIS, OpenDocument 1.3, part 3, 9 (tables) and 19.385 (types of values).
"""

import io
import zipfile
from datetime import datetime
from typing import NamedTuple
from xml.parsers import expat

import pandas as pd

from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import TablesOfFile
from oilfilm.logs.workbook import (
    LAST_ROW,
    MOST_CELLS,
    MOST_UNPACKED_BYTES,
    PercentColumns,
    SheetText,
    ValueAndPercent,
    check_character_count,
    chunks_of,
    date_if_midnight,
    line_of_cells,
    tab_separated_bytes,
    tables_of_sheets,
)

# It is the first member of the archive, and is not compressed.
_MEDIA_TYPE = b"mimetypeapplication/vnd.oasis.opendocument.spreadsheet"
_TABLE_NAMESPACE = "urn:oasis:names:tc:opendocument:xmlns:table:1.0 "
_OFFICE_NAMESPACE = "urn:oasis:names:tc:opendocument:xmlns:office:1.0 "
_TEXT_NAMESPACE = "urn:oasis:names:tc:opendocument:xmlns:text:1.0 "
_CELL_TAGS = (_TABLE_NAMESPACE + "table-cell", _TABLE_NAMESPACE + "covered-table-cell")
_MIB = 1 << 20


def recognises(first_bytes: bytes) -> bool:
    """True for a zip archive that states that it is an OpenDocument spreadsheet."""
    return first_bytes.startswith(b"PK\x03\x04") and _MEDIA_TYPE in first_bytes[:200]


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    return tables_of_sheets(sheet_texts(content), vocabulary)


def sheet_texts(content: bytes) -> list[SheetText]:
    """Each sheet with a cell as a text.

    Raises:
        ValueError: The spreadsheet is too large, or is encrypted.
        Exception: Any error that the libraries raise for a damaged file.
    """
    texts: list[SheetText] = []
    for sheet in _sheets(content):
        filled_lines = [line for line in sheet.lines if line]
        if filled_lines:
            text = tab_separated_bytes(filled_lines)
            texts.append(SheetText(sheet.title, text, sheet.percent_columns.of_fractions))
    return texts


def sheet_lines(content: bytes) -> list[tuple[str, list[str]]]:
    """Title and rows of each sheet: the texts of a row's cells with tabs between them.

    Empty rows are empty lines, so that a line has the number of its row.

    Raises:
        ValueError: The spreadsheet is too large, or is encrypted.
        Exception: Any error that the libraries raise for a damaged file.
    """
    return [(sheet.title, sheet.lines) for sheet in _sheets(content)]


class _Sheet(NamedTuple):
    """A sheet that was read to its end: its title, its lines and its columns in percent."""

    title: str
    lines: list[str]
    percent_columns: PercentColumns


def _sheets(content: bytes) -> list[_Sheet]:
    """The sheets of a spreadsheet, as `sheet_lines`."""
    sheet_parser = _SheetParser()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        member = archive.getinfo("content.xml")
        if member.file_size > MOST_UNPACKED_BYTES:
            raise ValueError(
                f"unpacked it has {member.file_size // _MIB} MiB; "
                f"expected at most {MOST_UNPACKED_BYTES // _MIB}"
            )
        with archive.open(member) as document:
            for chunk in chunks_of(document):
                sheet_parser.parser.Parse(chunk, False)
    sheet_parser.parser.Parse(b"", True)
    return sheet_parser.finished_sheets


class _SheetParser:
    """The sheets of a document while its XML is read.

    Attributes:
        finished_sheets: Each sheet that was read to its end.
    """

    def __init__(self) -> None:
        self.finished_sheets: list[_Sheet] = []
        self.parser = expat.ParserCreate(namespace_separator=" ")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start_element
        self.parser.EndElementHandler = self._end_element
        self.parser.CharacterDataHandler = self._add_text
        self.parser.EntityDeclHandler = self._refuse_entity
        self._lines: list[str] = []
        self._percent_columns = PercentColumns()
        # value of each cell of a row, and whether it is shown in percent
        self._cells_of_row: list[ValueAndPercent] = []
        self._row_repeats = 1
        self._cell_repeats = 1
        self._cell_attributes: dict[str, str] = {}
        # empty cells and rows are kept back: those behind the last filled one are dropped
        self._empty_cell_count = 0
        self._empty_row_count = 0
        self._paragraphs: list[str] = []
        self._is_in_paragraph = False
        self._annotation_depth = 0
        self._cell_count = 0
        self._character_count = 0
        self._title = ""

    def _start_element(self, tag: str, attributes: dict[str, str]) -> None:
        if tag == _OFFICE_NAMESPACE + "annotation" or self._annotation_depth:
            # the text of a note is not that of the cell
            self._annotation_depth += 1
        elif tag == _TABLE_NAMESPACE + "table":
            self._title = attributes.get(_TABLE_NAMESPACE + "name", "")
            self._lines = []
            self._empty_row_count = 0
            self._percent_columns = PercentColumns()
        elif tag == _TABLE_NAMESPACE + "table-row":
            self._cells_of_row = []
            self._empty_cell_count = 0
            self._row_repeats = _repeat_count(attributes, "number-rows-repeated")
        elif tag in _CELL_TAGS:
            self._cell_attributes = attributes
            self._paragraphs = []
            self._cell_repeats = _repeat_count(attributes, "number-columns-repeated")
        elif tag == _TEXT_NAMESPACE + "p":
            self._paragraphs.append("")
            self._is_in_paragraph = True

    def _end_element(self, tag: str) -> None:
        if self._annotation_depth:
            self._annotation_depth -= 1
        elif tag == _TEXT_NAMESPACE + "p":
            self._is_in_paragraph = False
        elif tag in _CELL_TAGS:
            self._end_cell()
        elif tag == _TABLE_NAMESPACE + "table-row":
            self._end_row()
        elif tag == _TABLE_NAMESPACE + "table":
            self.finished_sheets.append(_Sheet(self._title, self._lines, self._percent_columns))

    def _add_text(self, text: str) -> None:
        if self._is_in_paragraph and not self._annotation_depth:
            self._paragraphs[-1] += text

    def _end_cell(self) -> None:
        value = _value(self._cell_attributes, " ".join(self._paragraphs))
        if value is None or value == "":
            self._empty_cell_count += self._cell_repeats
            return
        self._add_to_cell_count(self._empty_cell_count + self._cell_repeats)
        is_in_percent = self._cell_attributes.get(_OFFICE_NAMESPACE + "value-type") == "percentage"
        self._cells_of_row += [(None, False)] * self._empty_cell_count
        self._cells_of_row += [(value, is_in_percent)] * self._cell_repeats
        self._empty_cell_count = 0

    def _end_row(self) -> None:
        self._percent_columns.add_row(self._cells_of_row)
        line = line_of_cells(self._cells_of_row, self._percent_columns.in_percent)
        if not line:
            self._empty_row_count += self._row_repeats
            return
        row_count = len(self._lines) + self._empty_row_count + self._row_repeats
        if row_count > LAST_ROW:
            raise ValueError(f"it has a row {row_count}; expected at most {LAST_ROW}")
        self._add_to_cell_count(len(self._cells_of_row) * (self._row_repeats - 1))
        self._character_count += len(line) * self._row_repeats
        check_character_count(self._character_count)
        self._lines += [""] * self._empty_row_count
        self._lines += [line] * self._row_repeats
        self._empty_row_count = 0

    def _add_to_cell_count(self, added_cell_count: int) -> None:
        self._cell_count += added_cell_count
        if self._cell_count > MOST_CELLS:
            raise ValueError(f"it has more than {MOST_CELLS} cells, with empty ones between")

    @staticmethod
    def _refuse_entity(*_: object) -> None:
        raise ValueError("a sheet declares entities, which no spreadsheet program writes")


def _repeat_count(attributes: dict[str, str], name: str) -> int:
    """How often a cell or row is repeated."""
    return max(int(attributes.get(_TABLE_NAMESPACE + name, 1)), 1)


def _value(attributes: dict[str, str], text: str) -> object:
    """The value of a cell by its type; its text where the type says no more."""
    value_type = attributes.get(_OFFICE_NAMESPACE + "value-type", "string")
    if value_type in ("float", "percentage", "currency"):
        return float(attributes[_OFFICE_NAMESPACE + "value"])
    if value_type == "date":
        date_value = attributes[_OFFICE_NAMESPACE + "date-value"]
        instant = datetime.fromisoformat(date_value)
        # a day that is shown without hours is a date alone
        return instant if ":" in (text or date_value) else date_if_midnight(instant)
    if value_type == "time":
        return pd.Timedelta(attributes[_OFFICE_NAMESPACE + "time-value"]).to_pytimedelta()
    return text
