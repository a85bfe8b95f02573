"""The file of the run sheet: one row per log, per run or per pattern of logs.

It is read as text logs are: in any usual encoding, with any delimiter, units in the names. A row is
a header: its cells mean what header lines of the same names mean. A mistake in it stops the run:
nobody knows what it should have said.

Decides: columns, units and mistakes of the run sheet.
"""

import csv
import io
import os
import unicodedata
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from oilfilm.errors import OilfilmError, printable
from oilfilm.logs import base, run_sheet
from oilfilm.logs.header import apart, listed_names, meaning
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.raw_files import all_faults, find_sheet, is_sheet, listed, named_logs
from oilfilm.logs.run_sheet import RunSheet, SheetRow, matches
from oilfilm.logs.text_rows import encoding_of
from oilfilm.settings.base import plain_key
from oilfilm.settings.resolved import Settings

# Columns that every run sheet may have; a kind of logs adds its own.
_COLUMNS = ("file", "run", "oil", "exclude", "remarks")
# Cells of `exclude` that keep a run.
_KEPT = frozenset(["", *"0 - n no false nein falsch non faux nej nei 否".split()])
# The line of names is near the top, below comments and the line `sep=;` of Excel.
_LINES_SEARCHED = 20
_LARGEST = 1 << 24
_QUANTITIES = {quantity: key for key, (quantity, _) in base.SET_POINT_UNITS.items()}

Cells = list[list[str]]


def _meant_by(files: Iterable[str]) -> Callable[[str], list[str]]:
    """Gives the logs of a campaign that a cell of `file` means."""
    by_form: dict[tuple[int, str], list[str]] = {}
    for file in files:
        name = unicodedata.normalize("NFC", file)
        # a name without a folder means any folder; a log keeps its name when it is packed
        for rank, form in enumerate((name, PurePosixPath(name).name)):
            unpacked = form.removesuffix(".gz").removesuffix(".zst")
            by_form.setdefault((2 * rank, form), []).append(file)
            by_form.setdefault((2 * rank + 1, unpacked), []).append(file)

    def meant(cell: str) -> list[str]:
        pattern = unicodedata.normalize("NFC", cell).replace("\\", "/").removeprefix("./")
        if not _is_pattern(pattern):
            return next(filter(None, (by_form.get((rank, pattern)) for rank in range(4))), [])
        ranks = (0, 1) if "/" in pattern else (2, 3)
        forms = (at for at in by_form if at[0] in ranks and matches(at[1], pattern))
        return [*dict.fromkeys(file for at in forms for file in by_form[at])]

    return meant


def _is_pattern(cell: str) -> bool:
    return bool(set(cell) & set("*?"))


class _Column(NamedTuple):
    """A column: its name in the sheet, that of the header line that a cell makes, and its key."""

    name: str
    own: str
    key: str


class _Sheet:
    """A run sheet while it is read: its settings, and the mistakes found so far."""

    def __init__(self, path: Path, settings: Settings, kind: LogKind) -> None:
        self.path, self.settings = path, settings
        self.keys = (*_COLUMNS, *kind.sheet_keys)
        self.mistakes: list[str] = []
        names = listed_names(settings)
        # set points repeat from row to row
        self.meaning = cache(lambda own, text: meaning(own, text, names))

    def column(self, name: str) -> _Column:
        """A column by its name."""
        own = plain_key(name)
        key = self.meaning(own, "1")[0]
        bare = apart(key)[0]
        # a set point without a unit is known by its quantity
        return _Column(name, own, key if key in self.keys else _QUANTITIES.get(bare, bare))

    def known(self, names: Sequence[str]) -> tuple[bool, int]:
        """How well cells are known as the names of columns."""
        keys = [key for name in names if (key := self.column(name).key) in self.keys]
        return "file" in keys, len(keys)

    def refuse(self, where: str, sentence: str) -> None:
        """Add a mistake."""
        self.mistakes.append(printable(f"{self.path}, {where}: {sentence}"))

    def stop(self) -> None:
        """End with all mistakes, if there are any."""
        if self.mistakes:
            raise all_faults(self.mistakes, self.path, "mistakes")


def read_run_sheet(
    content: bytes, path: Path, files: Sequence[str], settings: Settings, kind: LogKind
) -> RunSheet:
    """What a run sheet says of the logs of its campaign.

    Args:
        content: The bytes of the sheet: text, or an Excel workbook of which the first sheet counts.
        path: Its path, for messages.
        files: All logs of the campaign, by their paths below the folder of the sheet.
        settings: Settings of the campaign.
        kind: The kind of logs.

    Raises:
        OilfilmError: It cannot be read, a column is unknown, or a cell is not as it must be. All
            mistakes are named, each with its row, as a spreadsheet counts them, and its column.
    """
    sheet = _Sheet(path, settings, kind)
    rows = _rows(content, sheet)
    matched: dict[str, list[SheetRow]] = {}
    strays: list[str] = []
    meant = _meant_by(files)
    for number, row in rows:
        found = meant(row.file)
        if len(found) > 1 and not _is_pattern(row.file):
            sentence = f"{row.file!r} is the name of {listed(found)}: add the folder."
            sheet.refuse(f"row {number}", sentence)
        for file in found:
            matched.setdefault(file, []).append(row)
        if not found:
            strays.append(f"row {number}: {row.file!r} matches no log")
    sheet.stop()
    remarks: list[base.Refusal] = []
    if strays:
        remarks.append(
            base.Refusal(run_sheet.UNMATCHED, printable(listed(strays)), run_sheet.UNMATCHED_ADVICE)
        )
    if rows and (unlisted := [file for file in files if file not in matched]):
        reason = f"no row for {len(unlisted)} of {len(files)} logs: {listed(unlisted)}"
        advice = "Only their headers count. Add rows where that is wrong."
        remarks.append(base.Refusal(run_sheet.UNLISTED, printable(reason), advice))
    rows_of = {file: tuple(of) for file, of in matched.items()}
    return RunSheet(path.name, rows_of, tuple(remarks))


def is_run_sheet(path: Path, raw: Path) -> bool:
    """Whether a file is the run sheet of some campaign, below the folder `data/raw`."""
    file = Path(os.path.realpath(path))  # a link to itself is no sheet, and no fault
    return file.parent.parent == raw.resolve() and is_sheet(file, file.parent)


def sheet_of_paths(paths: Iterable[Path], raw: Path, settings: Settings, kind: LogKind) -> RunSheet:
    """What the run sheets of the campaigns' folders say of logs, by their paths as given.

    Args:
        paths: The logs, wherever they are.
        raw: The folder of the campaigns' folders, `data/raw`.
        settings: Settings of the campaign by which the logs are judged.
        kind: The kind of logs.

    Raises:
        OilfilmError: As by `read_run_sheet`.
    """
    inside = raw.resolve()
    by_folder: dict[str, dict[str, Path]] = {}
    for path in paths:
        if (real := path.resolve()).is_relative_to(inside):
            top, *below = real.relative_to(inside).parts
            by_folder.setdefault(top, {})["/".join(below)] = path
    together = RunSheet()
    for top, logs in by_folder.items():
        sheet_path = find_sheet(raw / top)
        if sheet_path is None:
            continue
        # a log with an unfit name is no reason not to judge the others
        files = [name for name, fault in named_logs(raw / top) if not fault]
        sheet = read_run_sheet(sheet_path.read_bytes(), sheet_path, files, settings, kind)
        rows = {str(path): sheet.rows.get(file, ()) for file, path in logs.items()}
        together = RunSheet(sheet.name, {**together.rows, **rows})
    return together


def _rows(content: bytes, sheet: _Sheet) -> list[tuple[int, SheetRow]]:
    """The rows with their numbers, as a spreadsheet counts them."""
    if len(content) > _LARGEST:
        raise OilfilmError(f"{sheet.path}: is larger than {_LARGEST >> 20} MiB.")
    readings = [_workbook(content, sheet)] if content.startswith(b"PK") else _texts(content)
    sheet.stop()
    # the line of names in the reading that knows most of them; the first of equals
    starts = ((cells, n) for cells in readings for n in range(len(cells[:_LINES_SEARCHED])))
    records, start = max(starts, key=lambda at: sheet.known(at[0][at[1]]), default=([[]], 0))
    columns = {n: sheet.column(name) for n, name in enumerate(records[start]) if name}
    counts = Counter(column.key for column in columns.values())
    where = f"row {start + 1}"
    if "file" not in counts:
        seen = ", ".join(next(filter(any, records), [""]))[:120]
        others = ", ".join(key for key in sheet.keys if key != "file")
        sheet.refuse(
            "its first rows",
            f"found {seen!r}, expected a row of column names, one of them `file` (others: "
            f"{others}). Names of your own: see `header` of the campaign file.",
        )
    sheet.stop()
    for column in columns.values():
        _check_column(column, where, sheet)
    for key, count in counts.items():
        if count > 1 and key in sheet.keys and key != "remarks":
            sheet.refuse(where, f"{count} columns give {key}: leave one of them.")
    sheet.stop()
    numbered = enumerate(records[start + 1 :], start=start + 2)
    rows = [(n, _row(f"row {n}", cells, columns, sheet)) for n, cells in numbered if any(cells)]
    sheet.stop()
    return rows


def _texts(content: bytes) -> list[Cells]:
    """The cells of a text by each delimiter that it may have."""
    text = content.decode(encoding_of(content), "replace").removeprefix("\ufeff")
    readings = []
    for delimiter in (",", ";", "\t", "|"):
        # a cell longer than csv reads is none of a run sheet
        with suppress(csv.Error):
            rows = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
            readings.append([[cell.strip() for cell in row] for row in rows])
    return readings


def unfolded(content: bytes) -> io.BytesIO:
    """An Excel workbook that can be opened: small archives may hold more than the memory.

    Raises:
        ValueError: It has more than 64 MiB when it is unpacked.
    """
    size = sum(part.file_size for part in zipfile.ZipFile(io.BytesIO(content)).infolist())
    if size > 4 * _LARGEST:
        raise ValueError(f"unpacked it has {size >> 20} MiB; expected at most {_LARGEST >> 18}")
    return io.BytesIO(content)


def _workbook(content: bytes, sheet: _Sheet) -> Cells:
    """The cells of the first sheet of an Excel workbook, as a text sheet would hold them."""
    # imported where needed: few run sheets are workbooks
    import openpyxl  # noqa: PLC0415

    def cell(value: object, written: openpyxl.cell.Cell) -> str:
        if value is None and written.data_type == "f":
            sheet.refuse(
                f"cell {written.coordinate}",
                "found a formula whose value the workbook does not hold, expected text or a "
                "number: write the value, or open the workbook in a spreadsheet program and save "
                "it.",
            )
        whole = isinstance(value, float) and value.is_integer()
        return "" if value is None else f"{value:.0f}" if whole else str(value).strip()

    try:
        # with the values that formulas had when the workbook was saved, and with the formulas
        books = (
            openpyxl.load_workbook(unfolded(content), read_only=True, data_only=only)
            for only in (True, False)
        )
        values, formulas = (book.worksheets[0] for book in books)
        pairs = zip(values.iter_rows(values_only=True), formulas.iter_rows(), strict=True)
        return [[*map(cell, *pair)] for pair in pairs]
    except Exception as error:  # whatever a damaged workbook makes the library stumble over
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise OilfilmError(
            f"{sheet.path}: cannot be read as a workbook ({reason}). Save it as runs.csv."
        ) from None


def _check_column(column: _Column, row: str, sheet: _Sheet) -> None:
    """Whether a column is known, with its unit; what is wrong with it goes to the mistakes."""
    if column.key not in sheet.keys:
        found = f"found the unknown column {column.name!r}; expected {', '.join(sheet.keys)}."
        advice = "A column that is not to be read: list it under `header: remarks` of the campaign"
        sheet.refuse(row, f"{found} {advice} file.")
    elif column.key in base.SET_POINTS:
        key, one = sheet.meaning(column.own, "1")
        if key not in base.SET_POINTS or base.set_point(key, one) is None:
            unit = apart(column.own)[1]
            found = f"found the unit {unit!r}" if unit else "has no unit"
            expected = "N or GPa" if column.key == "load_n" else base.SET_POINT_UNITS[column.key][1]
            where = f"{row}, column {column.name!r}"
            sheet.refuse(where, f"{found}, expected {expected} in brackets behind the name.")


def _row(row: str, cells: Sequence[str], columns: Mapping[int, _Column], sheet: _Sheet) -> SheetRow:
    """What a row says; its mistakes go to those of the sheet."""
    filled = {index: cell for index, cell in enumerate(cells) if cell}
    if stray := [filled.pop(index) for index in sorted(filled.keys() - columns.keys())]:
        found = f"the cell {stray[0][:60]!r} is in no column: expected {len(columns)} cells."
        sheet.refuse(row, f"{found} A text with the delimiter in it needs quotes.")
    texts = {columns[index].key: cell for index, cell in filled.items()}
    if "file" not in texts:
        sheet.refuse(f"{row}, column 'file'", "is empty, expected the name of a log or a pattern.")
    exclude = texts.get("exclude", "")
    excluded = exclude.lower() not in _KEPT
    keys: dict[str, str] = {}
    for index, text in filled.items():
        column = columns[index]
        if column.key == "oil" or column.key not in _COLUMNS:
            value, expected = _value(column, text, sheet)
            if value is not None:
                keys[column.key] = value
            elif not excluded:  # of a run that is left out nothing need be known
                where = f"{row}, column {column.name!r}"
                sheet.refuse(where, f"found {text[:60]!r}, expected {expected}.")
    reason = printable(exclude) if excluded else ""
    return SheetRow(texts.get("file", ""), texts.get("run", ""), reason, keys)


def _value(column: _Column, text: str, sheet: _Sheet) -> tuple[str | None, str]:
    """The value of a cell as its header key holds it, or None, and what is expected there."""
    key, settings = column.key, sheet.settings
    if key in base.SET_POINTS:
        value = base.set_point(*sheet.meaning(column.own, text))
        return (None if value is None else f"{value:.12g}"), base.expected_set_point(key)
    torque = settings.campaign.torque
    names = {
        "oil": [*settings.oils],
        "rig": [*settings.rigs],
        "bearing": [torque.bearing] if torque else [],
        "log_kind": ["continuous", "steps"],
    }[key]
    name = settings.oil_ids.get(plain_key(text), text) if key == "oil" else text
    expected = f"{key} of the campaign {settings.campaign.name}: {', '.join(names)}"
    return (name if name in names else None), expected
