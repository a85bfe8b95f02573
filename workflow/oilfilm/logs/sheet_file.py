"""The file of the run sheet: one row per log, per run or per pattern of logs.

It is read like a text log: in any usual encoding, with any delimiter, units in the names. A row
replaces a header: its cells mean the same as header lines of these names. A mistake in it stops the
run, because the intended content cannot be known.

Decides: columns, units and mistakes of the run sheet.
"""

import csv
import io
import os
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from oilfilm.base.errors import OilfilmError, printable
from oilfilm.base.plain_key import plain_key
from oilfilm.logs import base, opendocument, run_sheet
from oilfilm.logs.header import (
    expectation_in_words,
    key_by_listed_name,
    project_key_and_text,
    split_bracketed_unit,
)
from oilfilm.logs.log_schema import LogSchema
from oilfilm.logs.raw_files import (
    faults_error,
    find_run_sheet,
    is_run_sheet_of,
    log_names_and_faults,
    names_in_words,
)
from oilfilm.logs.run_sheet import RunSheet, SheetRow, matches
from oilfilm.logs.text_rows import encoding_of
from oilfilm.logs.workbook import ZIP_SIGNATURE, checked_workbook
from oilfilm.settings.resolved import Settings

# Columns that every run sheet may have. A log schema adds more (`run_sheet_keys`).
_COMMON_COLUMNS = ("file", "run", "oil", "exclude", "remarks")
# Cells of the column `exclude` that do not exclude a run.
_CELLS_THAT_KEEP_A_RUN = frozenset(["", *"0 - n no false nein falsch non faux nej nei 否".split()])
# The row of names is near the top, below comments and the line `sep=;` of Excel.
_ROWS_SEARCHED = 20
_MIB = 1 << 20
_LARGEST_SHEET_BYTES = 16 * _MIB
# A cell to try the unit of a column: 1 is a possible set point in every usual unit.
_TRIAL_CELL = "1"
# A number with decimals: the mark in 1.250 might be one between thousands.
_CERTAIN_DECIMAL = re.compile(r"[-+]?(?![1-9]\d{0,2}[.,]\d{3}$)\d*[.,]\d+")
_SET_POINT_KEY_OF_QUANTITY = {
    quantity: key for key, (quantity, _) in base.QUANTITY_AND_UNIT_OF_SET_POINT.items()
}

# Rows of a sheet, each a list of the texts of its cells.
CellRows = list[list[str]]


class _LogNames:
    """The logs of a campaign by the names that a cell of `file` may give them.

    Args:
        files: Paths of the logs below the folder of the sheet.
    """

    def __init__(self, files: Iterable[str]) -> None:
        self._files_of_path: dict[str, list[str]] = {}
        self._files_of_unpacked_path: dict[str, list[str]] = {}
        self._files_of_name: dict[str, list[str]] = {}
        self._files_of_unpacked_name: dict[str, list[str]] = {}
        for file in files:
            path = unicodedata.normalize("NFC", file)
            name = PurePosixPath(path).name
            self._files_of_path.setdefault(path, []).append(file)
            self._files_of_unpacked_path.setdefault(_without_packing(path), []).append(file)
            self._files_of_name.setdefault(name, []).append(file)
            self._files_of_unpacked_name.setdefault(_without_packing(name), []).append(file)

    def matching(self, cell: str) -> list[str]:
        """The logs that a cell names. A name without a folder may be in any folder."""
        pattern = unicodedata.normalize("NFC", cell).replace("\\", "/").removeprefix("./")
        files_of_paths = (self._files_of_path, self._files_of_unpacked_path)
        files_of_names = (self._files_of_name, self._files_of_unpacked_name)
        if not _is_pattern(pattern):
            for files_of_spelling in (*files_of_paths, *files_of_names):
                if pattern in files_of_spelling:
                    return files_of_spelling[pattern]
            return []
        matching_files: dict[str, None] = {}
        for files_of_spelling in files_of_paths if "/" in pattern else files_of_names:
            for name, files in files_of_spelling.items():
                if matches(name, pattern):
                    matching_files |= dict.fromkeys(files)
        return list(matching_files)


def _without_packing(name: str) -> str:
    """The name of a packed log before it was packed; other names are unchanged."""
    return name.removesuffix(".gz").removesuffix(".zst")


def _is_pattern(cell: str) -> bool:
    return "*" in cell or "?" in cell


class _SheetColumn(NamedTuple):
    """A column of the run sheet.

    Attributes:
        name: Name in the sheet.
        header_key: The name as the key of a header line, as `plain_key` makes it.
        key: Key of the project.
    """

    name: str
    header_key: str
    key: str


class _SheetBeingRead:
    """A run sheet while it is read.

    Attributes:
        path: Its path, for messages.
        settings: Settings of the campaign.
        allowed_keys: Keys of the project that its columns may have.
        mistakes: Sentences about the mistakes found so far.
        decimal_mark: Decimal mark of its numbers; empty where it is not known.
        key_and_text: Function that gives the key of the project and the text of a cell, by the
            column's `header_key` and the cell.
    """

    def __init__(self, path: Path, settings: Settings, log_schema: LogSchema) -> None:
        self.path = path
        self.settings = settings
        self.allowed_keys = (*_COMMON_COLUMNS, *log_schema.run_sheet_keys)
        self.mistakes: list[str] = []
        self.decimal_mark = "."
        key_by_name = key_by_listed_name(settings)

        # cached: set points repeat from row to row
        @cache
        def key_and_text_of_cell(header_key: str, text: str) -> tuple[str, str]:
            return project_key_and_text(header_key, text, key_by_name, self.decimal_mark)

        self.key_and_text = key_and_text_of_cell

    def column(self, name: str) -> _SheetColumn:
        """A column by its name."""
        header_key = plain_key(name)
        key, _ = self.key_and_text(header_key, _TRIAL_CELL)
        if key not in self.allowed_keys:
            # a set point without a unit is known by its quantity
            bare_key, _ = split_bracketed_unit(key)
            key = _SET_POINT_KEY_OF_QUANTITY.get(bare_key, bare_key)
        return _SheetColumn(name, header_key, key)

    def score_of_names(self, names: Sequence[str]) -> tuple[bool, int]:
        """Score of a row of names: whether it has `file`, and the number of known names."""
        keys = [self.column(name).key for name in names]
        return "file" in keys, sum(key in self.allowed_keys for key in keys)

    def add_mistake(self, where: str, sentence: str) -> None:
        """Add a mistake."""
        self.mistakes.append(printable(f"{self.path}, {where}: {sentence}"))

    def raise_mistakes(self) -> None:
        """Raise an error that names all mistakes, if there are any.

        Raises:
            OilfilmError: There is a mistake.
        """
        if self.mistakes:
            raise faults_error(self.mistakes, self.path, "mistakes")


def read_run_sheet(
    content: bytes, path: Path, files: Sequence[str], settings: Settings, log_schema: LogSchema
) -> RunSheet:
    """The run sheet of a campaign with the rows of each log.

    Args:
        content: The bytes of the sheet: text, or an Excel workbook, of which the first sheet
            counts.
        path: Its path, for messages.
        files: All logs of the campaign, by their paths below the folder of the sheet.
        settings: Settings of the campaign.
        log_schema: What logs of this kind of rig may hold.

    Raises:
        OilfilmError: It cannot be read, a column is unknown, or a cell has a wrong content. The
            message names all mistakes, each with its row, as a spreadsheet counts, and its column.
    """
    sheet = _SheetBeingRead(path, settings, log_schema)
    numbered_rows = _numbered_sheet_rows(content, sheet)
    rows_of_log: dict[str, list[SheetRow]] = {}
    unmatched_rows: list[str] = []
    log_names = _LogNames(files)
    for row_number, row in numbered_rows:
        matching_files = log_names.matching(row.file)
        if len(matching_files) > 1 and not _is_pattern(row.file):
            sentence = (
                f"{row.file!r} is the name of {names_in_words(matching_files)}: add the folder."
            )
            sheet.add_mistake(f"row {row_number}", sentence)
        for file in matching_files:
            rows_of_log.setdefault(file, []).append(row)
        if not matching_files:
            unmatched_rows.append(f"row {row_number}: {row.file!r} matches no log")
    sheet.raise_mistakes()
    remarks: list[base.Refusal] = []
    if unmatched_rows:
        reason = printable(names_in_words(unmatched_rows))
        remarks.append(base.Refusal(run_sheet.UNMATCHED, reason, run_sheet.UNMATCHED_ADVICE))
    unlisted_files = [file for file in files if file not in rows_of_log]
    if numbered_rows and unlisted_files:
        reason = (
            f"no row for {len(unlisted_files)} of {len(files)} logs: "
            f"{names_in_words(unlisted_files)}"
        )
        advice = "Only their headers count. Add rows where that is wrong."
        remarks.append(base.Refusal(run_sheet.UNLISTED, printable(reason), advice))
    return RunSheet(
        path.name, {file: tuple(log_rows) for file, log_rows in rows_of_log.items()}, tuple(remarks)
    )


def is_run_sheet_of_any_campaign(path: Path, raw_folder: Path) -> bool:
    """Whether a file is the run sheet of some campaign, below the folder `data/raw`."""
    # not `resolve`: it raises for a link to itself
    file = Path(os.path.realpath(path))
    return file.parent.parent == raw_folder.resolve() and is_run_sheet_of(file, file.parent)


def sheet_of_paths(
    paths: Iterable[Path], raw_folder: Path, settings: Settings, log_schema: LogSchema
) -> RunSheet:
    """One run sheet for logs of several campaigns' folders, by the paths as given.

    Messages name it by the file of the last campaign that has a run sheet.

    Args:
        paths: The logs, in any folder.
        raw_folder: The parent of the campaigns' folders, `data/raw`.
        settings: Settings of the campaign by which the logs are judged.
        log_schema: What logs of this kind of rig may hold.

    Raises:
        OilfilmError: As in `read_run_sheet`.
    """
    resolved_raw_folder = raw_folder.resolve()
    # name of a campaign -> name of a log in its folder -> path of the log as it is given
    paths_of_campaign: dict[str, dict[str, Path]] = {}
    for path in paths:
        # not `resolve`, which fails on a link to itself: the reader has a sentence for it
        resolved_path = Path(os.path.realpath(path))
        if resolved_raw_folder in resolved_path.parents:
            campaign_name, *names = resolved_path.relative_to(resolved_raw_folder).parts
            paths_of_campaign.setdefault(campaign_name, {})["/".join(names)] = path
    sheet_name = ""
    rows_of_log: dict[str, tuple[SheetRow, ...]] = {}
    for campaign_name, path_of_name in paths_of_campaign.items():
        folder = raw_folder / campaign_name
        sheet_path = find_run_sheet(folder)
        if sheet_path is None:
            continue
        # logs with an unfit name are left out: the others can be judged all the same
        files = [name for name, fault in log_names_and_faults(folder) if not fault]
        campaign_sheet = read_run_sheet(
            sheet_path.read_bytes(), sheet_path, files, settings, log_schema
        )
        sheet_name = campaign_sheet.name
        rows_of_log |= {
            str(path): campaign_sheet.rows_of_log.get(name, ())
            for name, path in path_of_name.items()
        }
    return RunSheet(sheet_name, rows_of_log)


def _numbered_sheet_rows(content: bytes, sheet: _SheetBeingRead) -> list[tuple[int, SheetRow]]:
    """Number of each row, as a spreadsheet counts them, and its content.

    Raises:
        OilfilmError: The sheet is too large, or has mistakes.
    """
    if len(content) > _LARGEST_SHEET_BYTES:
        raise OilfilmError(f"{sheet.path}: is larger than {_LARGEST_SHEET_BYTES // _MIB} MiB.")
    cell_rows_of_delimiters = (
        [_cells_of_workbook(content, sheet)]
        if content.startswith(ZIP_SIGNATURE)
        else _cells_of_text(content)
    )
    sheet.raise_mistakes()
    cell_rows, index_of_names = _row_of_names(cell_rows_of_delimiters, sheet)
    column_of_index = {
        index: sheet.column(name) for index, name in enumerate(cell_rows[index_of_names]) if name
    }
    _check_columns(column_of_index, cell_rows, f"row {index_of_names + 1}", sheet)
    # a workbook, or a text with commas between its cells, has decimal points
    if cell_rows is not cell_rows_of_delimiters[0]:
        set_point_indices = [
            index for index, column in column_of_index.items() if column.key in base.SET_POINT_KEYS
        ]
        sheet.decimal_mark = _decimal_mark(cell_rows[index_of_names + 1 :], set_point_indices)
    numbered_rows: list[tuple[int, SheetRow]] = []
    for row_number, cells in enumerate(cell_rows[index_of_names + 1 :], start=index_of_names + 2):
        if any(cells):
            numbered_rows.append(
                (row_number, _sheet_row(f"row {row_number}", cells, column_of_index, sheet))
            )
    sheet.raise_mistakes()
    return numbered_rows


def _row_of_names(
    cell_rows_of_delimiters: Sequence[CellRows], sheet: _SheetBeingRead
) -> tuple[CellRows, int]:
    """The rows of cells whose row of names has the best score, and the index of this row.

    Args:
        cell_rows_of_delimiters: Rows of cells, once for each delimiter that the sheet may have.
        sheet: The sheet.
    """
    best_cell_rows: CellRows = [[]]
    best_index = 0
    best_score = (False, -1)
    for cell_rows in cell_rows_of_delimiters:
        for index, names in enumerate(cell_rows[:_ROWS_SEARCHED]):
            score = sheet.score_of_names(names)
            if score > best_score:
                best_cell_rows, best_index, best_score = cell_rows, index, score
    return best_cell_rows, best_index


def _decimal_mark(rows: CellRows, set_point_indices: Sequence[int]) -> str:
    """The mark of the numbers that can have no other meaning; empty without one, or with both.

    Args:
        rows: The rows below the names.
        set_point_indices: Indices of the columns of set points.
    """
    cells = [row[index] for row in rows for index in set_point_indices if index < len(row)]
    marks = {cell.strip("+-0123456789") for cell in cells if _CERTAIN_DECIMAL.fullmatch(cell)}
    return marks.pop() if len(marks) == 1 else ""


def _check_columns(
    column_of_index: Mapping[int, _SheetColumn],
    cell_rows: CellRows,
    row_in_words: str,
    sheet: _SheetBeingRead,
) -> None:
    """Check the columns of a sheet.

    Args:
        column_of_index: Index of a column -> the column.
        cell_rows: All rows of the sheet.
        row_in_words: The row of the names in words, as `row 3`.
        sheet: The sheet.

    Raises:
        OilfilmError: The column `file` is missing, or a column is unknown, double or without unit.
    """
    count_of_key = Counter(column.key for column in column_of_index.values())
    if "file" not in count_of_key:
        first_row = next((row for row in cell_rows if any(row)), [""])
        other_keys = ", ".join(key for key in sheet.allowed_keys if key != "file")
        sheet.add_mistake(
            "its first rows",
            f"found {', '.join(first_row)[:120]!r}, expected a row of column names, one of them "
            f"`file` (others: {other_keys}). Names of your own: see `header` of the campaign file.",
        )
    sheet.raise_mistakes()
    for column in column_of_index.values():
        _check_column(column, row_in_words, sheet)
    for key, count in count_of_key.items():
        if count > 1 and key in sheet.allowed_keys and key != "remarks":
            sheet.add_mistake(row_in_words, f"{count} columns give {key}: leave one of them.")
    sheet.raise_mistakes()


def _cells_of_text(content: bytes) -> list[CellRows]:
    """The cells of a text, once for each delimiter that it may have."""
    text = content.decode(encoding_of(content), "replace").removeprefix("\ufeff")
    cell_rows_of_delimiters = []
    for delimiter in (",", ";", "\t", "|"):
        # the csv reader refuses very long cells: no run sheet has them
        with suppress(csv.Error):
            rows = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
            cell_rows_of_delimiters.append([[cell.strip() for cell in row] for row in rows])
    return cell_rows_of_delimiters


def _cells_of_workbook(content: bytes, sheet: _SheetBeingRead) -> CellRows:
    """The cells of the first sheet of a workbook, as a text sheet would hold them.

    Raises:
        OilfilmError: The workbook cannot be read.
    """
    # imported where needed: few run sheets are workbooks
    import openpyxl  # noqa: PLC0415

    def text(value: object, cell: openpyxl.cell.Cell) -> str:
        """Text of a value; `cell` has the formula that gave it, if one did."""
        if value is None and cell.data_type == "f":
            sheet.add_mistake(
                f"cell {cell.coordinate}",
                "found a formula whose value the workbook does not hold, expected text or a "
                "number: write the value, or open the workbook in a spreadsheet program and save "
                "it.",
            )
        if value is None:
            return ""
        if isinstance(value, float) and value.is_integer():
            return f"{value:.0f}"
        return str(value).strip()

    try:
        if opendocument.recognises(content):
            # each cell holds its value, also where a formula gave it
            _, lines = opendocument.sheet_lines(content)[0]
            return [line.split("\t") for line in lines]
        values_sheet = openpyxl.load_workbook(
            checked_workbook(content), read_only=True, data_only=True
        ).worksheets[0]
        formulas_sheet = openpyxl.load_workbook(
            io.BytesIO(content), read_only=True, data_only=False
        ).worksheets[0]
        # the size that a sheet states may be wrong: it is read to its last cell
        values_sheet.reset_dimensions()
        formulas_sheet.reset_dimensions()
        cell_rows: CellRows = []
        for row_values, row_cells in zip(
            values_sheet.iter_rows(values_only=True), formulas_sheet.iter_rows(), strict=True
        ):
            values_and_cells = zip(row_values, row_cells, strict=True)
            cell_rows.append([text(value, cell) for value, cell in values_and_cells])
        return cell_rows
    except Exception as error:  # the library raises many kinds for a damaged workbook
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise OilfilmError(
            f"{sheet.path}: cannot be read as a workbook ({reason}). Save it as runs.csv."
        ) from None


def _check_column(column: _SheetColumn, row_in_words: str, sheet: _SheetBeingRead) -> None:
    """Add a mistake to the sheet where a column is unknown, or a set point has no usable unit."""
    if column.key not in sheet.allowed_keys:
        sheet.add_mistake(
            row_in_words,
            f"found the unknown column {column.name!r}; expected {', '.join(sheet.allowed_keys)}. "
            "A column that is not to be read: list it under `header: remarks` of the campaign "
            "file.",
        )
    elif column.key in base.SET_POINT_KEYS:
        # a key without a unit is not that of a set point; an unknown unit is left in the text
        key, converted_text = sheet.key_and_text(column.header_key, _TRIAL_CELL)
        if key in base.SET_POINT_KEYS and base.parse_set_point(key, converted_text) is not None:
            return
        _, unit = split_bracketed_unit(column.header_key)
        found = f"found the unit {unit!r}" if unit else "has no unit"
        _, expected = base.QUANTITY_AND_UNIT_OF_SET_POINT[column.key]
        # a load may also be given as maximum Hertz pressure
        if column.key == "load_n":
            expected = "N or GPa"
        where = f"{row_in_words}, column {column.name!r}"
        sheet.add_mistake(where, f"{found}, expected {expected} in brackets behind the name.")


def _sheet_row(
    row_in_words: str,
    cells: Sequence[str],
    column_of_index: Mapping[int, _SheetColumn],
    sheet: _SheetBeingRead,
) -> SheetRow:
    """The content of a row; its mistakes are added to those of the sheet.

    Args:
        row_in_words: The row in words, as `row 3`.
        cells: Its cells.
        column_of_index: Index of a column -> the column.
        sheet: The sheet.
    """
    cell_of_index = {index: cell for index, cell in enumerate(cells) if cell}
    surplus_cells = [cell for index, cell in cell_of_index.items() if index not in column_of_index]
    if surplus_cells:
        sheet.add_mistake(
            row_in_words,
            f"the cell {surplus_cells[0][:60]!r} is in no column: expected {len(column_of_index)} "
            "cells. A text with the delimiter in it needs quotes.",
        )
    cell_of_column = {
        column_of_index[index]: cell
        for index, cell in cell_of_index.items()
        if index in column_of_index
    }
    cell_of_key = {column.key: cell for column, cell in cell_of_column.items()}
    if "file" not in cell_of_key:
        sheet.add_mistake(
            f"{row_in_words}, column 'file'", "is empty, expected the name of a log or a pattern."
        )
    exclude = cell_of_key.get("exclude", "")
    is_excluded = exclude.lower() not in _CELLS_THAT_KEEP_A_RUN
    text_of_key: dict[str, str] = {}
    for column, cell in cell_of_column.items():
        if column.key != "oil" and column.key in _COMMON_COLUMNS:
            continue
        value, expected = _value_and_expectation(column, cell, sheet)
        if value is not None:
            text_of_key[column.key] = value
        elif not is_excluded:
            # an excluded run needs no oil and no set points
            where = f"{row_in_words}, column {column.name!r}"
            sheet.add_mistake(where, f"found {cell[:60]!r}, expected {expected}.")
    reason = printable(exclude) if is_excluded else ""
    return SheetRow(cell_of_key.get("file", ""), cell_of_key.get("run", ""), reason, text_of_key)


def _value_and_expectation(
    column: _SheetColumn, text: str, sheet: _SheetBeingRead
) -> tuple[str | None, str]:
    """The text of a cell for the project, and what is expected there, in words.

    The text is None where the cell has a wrong content.
    """
    key = column.key
    settings = sheet.settings
    if key in base.SET_POINT_KEYS:
        project_key, converted_text = sheet.key_and_text(column.header_key, text)
        if project_key != key:
            # the unit in the cell is that of a load in a column of pressures, or the reverse
            return None, expectation_in_words(key, text)
        set_point = base.parse_set_point(project_key, converted_text)
        # 12 digits, as `project_key_and_text` gives them: 80 N and 0.08 kN become the same text
        value = None if set_point is None else f"{set_point:.12g}"
        return value, expectation_in_words(project_key, converted_text)
    torque = settings.campaign.torque
    allowed_names = {
        "oil": list(settings.oils),
        "rig": list(settings.rigs),
        "bearing": [torque.bearing] if torque else [],
        # a signal against time, or settled readings
        "log_kind": ["continuous", base.SETTLED_LOG_KIND],
    }[key]
    name = settings.oil_id_by_name.get(plain_key(text), text) if key == "oil" else text
    expected = f"{key} of the campaign {settings.campaign.name}: {', '.join(allowed_names)}"
    return (name if name in allowed_names else None), expected
