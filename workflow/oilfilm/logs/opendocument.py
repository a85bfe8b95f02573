"""OpenDocument spreadsheets (.ods): a sheet is read as the text log that it would be, and is a run.

The XML is read once, as it is unpacked. No more of it is held than the texts of the cells, because
a repeated cell or row takes a few bytes and may stand for millions.

Source: OASIS, OpenDocument 1.3, part 3, 9 (tables) and 19.385 (types of values).
"""

import io
import zipfile
from datetime import datetime
from typing import Any
from xml.parsers import expat

import pandas as pd

from oilfilm.logs.log_kind import Vocabulary
from oilfilm.logs.logged_table import TablesOfFile
from oilfilm.logs.workbook import (
    LARGEST_UNPACKED,
    LAST_ROW,
    MOST_CELLS,
    check_letters,
    chunks_of,
    line_of_cells,
    tables_of_sheets,
    text_of_lines,
)

# It is the first member of the archive, and is not compressed.
_MEDIA_TYPE = b"mimetypeapplication/vnd.oasis.opendocument.spreadsheet"
_TABLE = "urn:oasis:names:tc:opendocument:xmlns:table:1.0 "
_OFFICE = "urn:oasis:names:tc:opendocument:xmlns:office:1.0 "
_TEXT = "urn:oasis:names:tc:opendocument:xmlns:text:1.0 "
_CELLS = (_TABLE + "table-cell", _TABLE + "covered-table-cell")
_MIB = 1 << 20


def recognises(head: bytes) -> bool:
    """True for a zip archive that states that it is an OpenDocument spreadsheet."""
    return head.startswith(b"PK\x03\x04") and _MEDIA_TYPE in head[:200]


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `Reader.tables`."""
    return tables_of_sheets(sheet_texts(content), vocabulary)


def sheet_texts(content: bytes) -> list[tuple[str, bytes]]:
    """Title and text of each sheet with a cell, as tab-separated UTF-8.

    Raises:
        ValueError: The spreadsheet is too large, or is encrypted.
        Exception: Any error that the libraries raise for a damaged file.
    """
    text_by_title: list[tuple[str, bytes]] = []
    for title, lines in sheet_lines(content):
        filled_lines = [line for line in lines if line]
        if filled_lines:
            text_by_title.append((title, text_of_lines(filled_lines)))
    return text_by_title


def sheet_lines(content: bytes) -> list[tuple[str, list[str]]]:
    """Title and rows of each sheet: the texts of a row's cells with tabs between them.

    Empty rows are empty lines, so that a line has the number of its row.

    Raises:
        ValueError: The spreadsheet is too large, or is encrypted.
        Exception: Any error that the libraries raise for a damaged file.
    """
    sheets = _Sheets()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        member = archive.getinfo("content.xml")
        if member.file_size > LARGEST_UNPACKED:
            raise ValueError(
                f"unpacked it has {member.file_size // _MIB} MiB; "
                f"expected at most {LARGEST_UNPACKED // _MIB}"
            )
        with archive.open(member) as document:
            for chunk in chunks_of(document):
                sheets.parser.Parse(chunk, False)
    sheets.parser.Parse(b"", True)
    return sheets.finished


class _Sheets:
    """The sheets of a document while its XML is read.

    Attributes:
        finished: Title and lines of each sheet that was read to its end.
    """

    def __init__(self) -> None:
        self.finished: list[tuple[str, list[str]]] = []
        self.parser = expat.ParserCreate(namespace_separator=" ")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._add_text
        self.parser.EntityDeclHandler = self._refuse_entity
        self._lines: list[str] = []
        self._columns_in_percent: set[int] = set()
        # value of each cell of a row, and whether it is shown in percent
        self._row: list[tuple[Any, bool]] = []
        self._rows_alike = 1
        self._cells_alike = 1
        self._attributes: dict[str, str] = {}
        # empty cells and rows are kept back: those behind the last filled one are dropped
        self._empty_cells = 0
        self._empty_rows = 0
        self._paragraphs: list[str] = []
        self._is_paragraph = False
        self._depth_of_note = 0
        self._cells = 0
        self._letters = 0
        self._title = ""

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if tag == _OFFICE + "annotation" or self._depth_of_note:
            # the text of a note is none of the cell
            self._depth_of_note += 1
        elif tag == _TABLE + "table":
            self._title = attributes.get(_TABLE + "name", "")
            self._lines = []
            self._empty_rows = 0
            self._columns_in_percent = set()
        elif tag == _TABLE + "table-row":
            self._row = []
            self._empty_cells = 0
            self._rows_alike = _number_of_times(attributes, "number-rows-repeated")
        elif tag in _CELLS:
            self._attributes = attributes
            self._paragraphs = []
            self._cells_alike = _number_of_times(attributes, "number-columns-repeated")
        elif tag == _TEXT + "p":
            self._paragraphs.append("")
            self._is_paragraph = True

    def _end(self, tag: str) -> None:
        if self._depth_of_note:
            self._depth_of_note -= 1
        elif tag == _TEXT + "p":
            self._is_paragraph = False
        elif tag in _CELLS:
            self._end_cell()
        elif tag == _TABLE + "table-row":
            self._end_row()
        elif tag == _TABLE + "table":
            self.finished.append((self._title, self._lines))

    def _add_text(self, text: str) -> None:
        if self._is_paragraph and not self._depth_of_note:
            self._paragraphs[-1] += text

    def _end_cell(self) -> None:
        value = _value(self._attributes, " ".join(self._paragraphs))
        if value is None or value == "":
            self._empty_cells += self._cells_alike
            return
        self._count_cells(self._empty_cells + self._cells_alike)
        is_in_percent = self._attributes.get(_OFFICE + "value-type") == "percentage"
        self._row += [(None, False)] * self._empty_cells
        self._row += [(value, is_in_percent)] * self._cells_alike
        self._empty_cells = 0

    def _end_row(self) -> None:
        line = line_of_cells(self._row, self._columns_in_percent)
        if not line:
            self._empty_rows += self._rows_alike
            return
        rows = len(self._lines) + self._empty_rows + self._rows_alike
        if rows > LAST_ROW:
            raise ValueError(f"it has a row {rows}; expected at most {LAST_ROW}")
        self._count_cells(len(self._row) * (self._rows_alike - 1))
        self._letters += len(line) * self._rows_alike
        check_letters(self._letters)
        self._lines += [""] * self._empty_rows
        self._lines += [line] * self._rows_alike
        self._empty_rows = 0

    def _count_cells(self, added: int) -> None:
        self._cells += added
        if self._cells > MOST_CELLS:
            raise ValueError(f"it has more than {MOST_CELLS} cells, with empty ones between")

    @staticmethod
    def _refuse_entity(*_: object) -> None:
        raise ValueError("a sheet declares entities, which no spreadsheet program writes")


def _number_of_times(attributes: dict[str, str], name: str) -> int:
    """How often a cell or row is repeated."""
    return max(int(attributes.get(_TABLE + name, 1)), 1)


def _value(attributes: dict[str, str], text: str) -> object:
    """The value of a cell by its type; its text where the type says no more."""
    kind = attributes.get(_OFFICE + "value-type", "string")
    if kind in ("float", "percentage", "currency"):
        return float(attributes[_OFFICE + "value"])
    if kind == "date":
        return datetime.fromisoformat(attributes[_OFFICE + "date-value"])
    if kind == "time":
        return pd.Timedelta(attributes[_OFFICE + "time-value"]).to_pytimedelta()
    return text
