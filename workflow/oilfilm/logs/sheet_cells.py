"""The cells of a table in text or in a workbook, whatever program has written it."""

import csv
import io
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

from oilfilm.errors import OilfilmError
from oilfilm.logs.encoding import encodings_of

_DELIMITERS = (",", ";", "\t", "|")
# The line of names is near the top, below comments and the line `sep=;` of Excel.
LINES_SEARCHED = 20
_LARGEST = 1 << 24

Cells = list[list[str]]


def cells_of(content: bytes, path: Path, is_name: Callable[[str], bool]) -> Cells:
    """The cells of a table, row by row; empty rows are kept, so that rows can be counted.

    Args:
        content: Text in any usual encoding with any delimiter, or an Excel workbook, of which the
            first sheet is read.
        path: Path of the file, for messages.
        is_name: Whether a cell is the name of a column. Where the bytes leave a choice, a table is
            read so that one of its first lines has the most names.

    Raises:
        OilfilmError: It cannot be read, or is larger than any table of this kind.
    """
    if len(content) > _LARGEST:
        raise OilfilmError(f"{path}: is larger than {_LARGEST >> 20} MiB.")
    if content.startswith(b"PK"):
        return _workbook(content, path)
    readings: list[Cells] = []
    for encoding in encodings_of(content):
        text = content.decode(encoding, "replace").removeprefix("\ufeff")
        for delimiter in _DELIMITERS:
            try:
                cells = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
            except csv.Error:
                continue
            readings.append([[cell.strip() for cell in row] for row in cells])
    if not readings:
        raise OilfilmError(f"{path}: cannot be read as text with delimiters. Save it as CSV.")

    def names(cells: Sequence[Sequence[str]]) -> int:
        return max((sum(map(is_name, row)) for row in cells[:LINES_SEARCHED]), default=0)

    # the first of equals is the most likely one
    return max(readings, key=names)


def _workbook(content: bytes, path: Path) -> Cells:
    """The cells of the first sheet of an Excel workbook."""
    # imported where needed: few tables are workbooks
    import openpyxl  # noqa: PLC0415

    try:
        unfolded = sum(part.file_size for part in zipfile.ZipFile(io.BytesIO(content)).infolist())
        if unfolded > _LARGEST:
            raise ValueError(f"unpacked it has {unfolded >> 20} MiB")
        book = openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=True)
        rows = book.worksheets[0].iter_rows(values_only=True)
        return [[_cell(value) for value in row] for row in rows]
    except Exception as error:  # whatever a damaged workbook makes the library stumble over
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise OilfilmError(
            f"{path}: cannot be read as a workbook ({reason}). Save it as runs.csv."
        ) from None


def _cell(value: object) -> str:
    """A cell of a workbook as a text sheet would hold it."""
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return "" if value is None else str(value).strip()
