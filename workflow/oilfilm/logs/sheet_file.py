"""The file of the run sheet: one row per log, per run or per pattern of logs.

It is read as text logs are: in any usual encoding, with any delimiter, units in the names or in a
row below them. A mistake in it stops the run: nobody knows what it should have said.

Decides: columns, units and mistakes of the run sheet.
"""

import csv
import difflib
import io
import os
import unicodedata
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.base import Refusal, decimal_number, set_point, set_point_range
from oilfilm.logs.encoding import encodings_of
from oilfilm.logs.header import FULL_WIDTH, SET_POINT_UNITS, apart, listed_names, set_point_key
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.raw_files import find_sheet, is_sheet, named_logs
from oilfilm.logs.run_sheet import (
    NO_SHEET,
    UNLISTED,
    UNMATCHED,
    UNMATCHED_ADVICE,
    RunSheet,
    SheetRow,
    matches,
)
from oilfilm.settings.base import plain_key
from oilfilm.settings.resolved import Settings
from oilfilm.units import Conversion, conversion

# Columns that every run sheet may have; a kind of logs adds its own.
_COLUMNS = ("file", "run", "oil", "exclude", "remarks")
# Cells of `exclude` that keep a run, and those that would exclude it without a reason.
_KEPT = frozenset(["", *"0 - n no false nein falsch non faux nej nei 否".split()])
_UNREASONED = frozenset("1 x y yes true j ja wahr oui vrai si sí 是".split())
# So many mistakes, rows and names of logs are listed; the others are counted.
_LISTED = 20
# The line of names is near the top, below comments and the line `sep=;` of Excel.
_LINES_SEARCHED = 20
_LARGEST = 1 << 24
_AS_TEXT = Conversion("")

Cells = list[list[str]]


class _LogNames:
    """The logs of a campaign by the names that the run sheet may give them."""

    def __init__(self, files: Iterable[str]) -> None:
        # a log keeps its name when it is packed; a name without a folder means any folder
        self._forms = {
            file: (name, _unpacked(name), last, _unpacked(last))
            for file in files
            for name in [unicodedata.normalize("NFC", file)]
            for last in [PurePosixPath(name).name]
        }
        self._by_form: list[dict[str, list[str]]] = [{}, {}, {}, {}]
        for file, forms in self._forms.items():
            for by_form, form in zip(self._by_form, forms, strict=True):
                by_form.setdefault(form, []).append(file)

    def meant(self, cell: str) -> tuple[list[str], bool]:
        """The logs that a cell of `file` means, and whether it is a name that several logs have."""
        plain = unicodedata.normalize("NFC", cell)
        pattern = plain.replace("\\", "/").removeprefix("./")
        if not set(pattern) & set("*?"):
            found = next(filter(None, (by.get(pattern) for by in self._by_form)), [])
            return found, len(found) > 1
        which = slice(2) if "/" in pattern else slice(2, 4)
        fitting = [
            file
            for file, forms in self._forms.items()
            if any(matches(form, pattern) for form in forms[which])
        ]
        return fitting, False


def _unpacked(name: str) -> str:
    return name.removesuffix(".gz").removesuffix(".zst")


@dataclass(frozen=True)
class _Column:
    """A column of the sheet, the header key that it gives, and how its numbers become the key's."""

    name: str
    key: str
    to: Conversion = _AS_TEXT


@dataclass
class _Sheet:
    """A run sheet while it is read: its settings, and the mistakes found so far."""

    path: Path
    settings: Settings
    kind: LogKind
    mistakes: list[str] = field(default_factory=list)

    @property
    def keys(self) -> tuple[str, ...]:
        """The header keys and columns that it may have."""
        return (*_COLUMNS, *self.kind.sheet_keys)

    def key(self, name: str) -> tuple[str, str] | None:
        """Key and unit, empty where the name has none, that the name of a column gives."""
        listed = listed_names(self.settings)
        plain, bare = plain_key(name.translate(FULL_WIDTH)), apart(name.translate(FULL_WIDTH))[0]
        key = listed.get(plain_key(name), plain_key(name))
        found = set_point_key(plain, listed)
        if found is None and key not in self.keys:
            key = listed.get(plain_key(bare), plain_key(bare))
        found = found or (key, "")
        return found if found[0] in self.keys else None

    def refuse(self, where: str, sentence: str) -> None:
        """Add a mistake."""
        self.mistakes.append(printable(f"{self.path}, {where}: {sentence}"))

    def stop(self) -> None:
        """End with all mistakes, if there are any."""
        more = len(self.mistakes) - _LISTED
        counted = [f"{self.path}: {more} more mistakes"] if more > 0 else []
        if self.mistakes:
            raise OilfilmError("\n".join([*self.mistakes[:_LISTED], *counted]))


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
    sheet.stop()
    matched: dict[str, list[SheetRow]] = {}
    strays: list[tuple[int, str]] = []
    logs = _LogNames(files)
    for number, row in rows:
        found, ambiguous = logs.meant(row.file)
        if ambiguous:
            listed = ", ".join(found[:_LISTED])
            sheet.refuse(f"row {number}", f"{row.file!r} is the name of {listed}: add the folder.")
        for file in found:
            matched.setdefault(file, []).append(row)
        if not found:
            strays.append((number, row.file))
    sheet.stop()
    remarks: list[Refusal] = []
    if strays:
        listed = "; ".join(f"row {number}: {cell!r}" for number, cell in strays[:_LISTED])
        more = f" and {len(strays) - _LISTED} more rows" if strays[_LISTED:] else ""
        verb = "match no log" if strays[1:] else "matches no log"
        remarks.append(Refusal(UNMATCHED, printable(f"{listed}{more} {verb}"), UNMATCHED_ADVICE))
    unlisted = [file for file in files if file not in matched]
    if rows and unlisted:
        listed = ", ".join(unlisted[:_LISTED]) + (" ..." if len(unlisted) > _LISTED else "")
        reason = printable(f"no row for {len(unlisted)} of {len(files)} logs: {listed}")
        advice = "Only their headers count. Add rows where that is wrong."
        remarks.append(Refusal(UNLISTED, reason, advice))
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
    together = NO_SHEET
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
    records = _workbook(content, sheet) if content.startswith(b"PK") else _text(content, sheet)
    start = max(range(len(records[:_LINES_SEARCHED])), key=lambda n: _known(records[n], sheet))
    found = [sheet.key(cell) for cell in records[start]]
    if "file" not in [key for key, _ in filter(None, found)]:
        seen = ", ".join(next(filter(any, records), [""]))[:120]
        others = ", ".join(key for key in sheet.keys if key != "file")
        sheet.refuse(
            "its first rows",
            f"found {seen!r}, expected a row of column names, one of them `file` (others: "
            f"{others}). Names of your own: see `header` of the campaign file.",
        )
        return []
    below = start + 1
    units: list[str] = []
    if below < len(records) and _is_unit_row(found, records[below]):
        units, below = records[below], below + 1
    columns: dict[int, _Column] = {}
    for index, (name, unit) in enumerate(
        zip_longest(records[start], units[: len(found)], fillvalue="")
    ):
        column = _column(start + 1, name, unit, sheet) if name else None
        if column is None:
            continue
        if column.key != "remarks" and column.key in {each.key for each in columns.values()}:
            sheet.refuse(
                f"row {start + 1}", f"the column {name!r} gives {column.key} a second time."
            )
        columns[index] = column
    if sheet.mistakes:
        return []
    numbered = enumerate(records[below:], start=below + 1)
    rows = [(n, _row(n, cells, columns, sheet)) for n, cells in numbered if any(cells)]
    return [(n, row) for n, row in rows if row is not None]


def _known(names: Sequence[str], sheet: _Sheet) -> tuple[bool, int]:
    """How well cells are known as the names of columns."""
    keys = [found[0] for name in names if (found := sheet.key(name))]
    return "file" in keys, len(keys)


def _text(content: bytes, sheet: _Sheet) -> Cells:
    """The cells of a text: in the encoding and with the delimiter that give most known names."""
    readings: list[Cells] = [[[]]]
    for encoding in encodings_of(content):
        text = content.decode(encoding, "replace").removeprefix("\ufeff")
        for delimiter in (",", ";", "\t", "|"):
            try:
                cells = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
            except csv.Error:
                continue
            readings.append([[cell.strip() for cell in row] for row in cells] or [[]])
    # the first of equals is the most likely one
    return max(
        readings[1:] or readings,
        key=lambda cells: max(_known(row, sheet) for row in cells[:_LINES_SEARCHED]),
    )


def _workbook(content: bytes, sheet: _Sheet) -> Cells:
    """The cells of the first sheet of an Excel workbook."""
    # imported where needed: few run sheets are workbooks
    import openpyxl  # noqa: PLC0415

    try:
        unfolded = sum(part.file_size for part in zipfile.ZipFile(io.BytesIO(content)).infolist())
        if unfolded > _LARGEST:
            raise ValueError(f"unpacked it has {unfolded >> 20} MiB")
        values, formulas = (
            openpyxl.load_workbook(io.BytesIO(content), read_only=True, data_only=only)
            .worksheets[0]
            .iter_rows()
            for only in (True, False)
        )
        rows = [
            [_cell(*cells, sheet) for cells in zip(*row, strict=True)]
            for row in zip(values, formulas, strict=True)
        ]
    except Exception as error:  # whatever a damaged workbook makes the library stumble over
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise OilfilmError(
            f"{sheet.path}: cannot be read as a workbook ({reason}). Save it as runs.csv."
        ) from None
    sheet.stop()
    return rows or [[]]


def _cell(cell: Any, written: Any, sheet: _Sheet) -> str:
    """A cell of a workbook as a text sheet would hold it.

    Args:
        cell: The cell with the value that a formula had when the workbook was saved.
        written: The same with the formula itself.
        sheet: Gets the mistake where a formula has no such value: it would read as empty.
    """
    value = cell.value
    if value is None and written.data_type == "f":
        sheet.refuse(
            f"cell {written.coordinate}",
            "found a formula whose value the workbook does not hold, expected text or a number: "
            "write the value, or open the workbook in a spreadsheet program and save it.",
        )
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return "" if value is None else str(value).strip()


def _is_unit_row(found: Sequence[tuple[str, str] | None], cells: Sequence[str]) -> bool:
    """A row below the names that names no log and has a unit for some set point."""
    by_key = {of[0]: cell for of, cell in zip(found, cells, strict=False) if of}
    return by_key.get("file", "") in ("", "-") and any(
        _conversion(cell, key) for key, cell in by_key.items() if key in SET_POINT_UNITS
    )


def _targets(key: str) -> tuple[str, ...]:
    """Units that a set point may be given in; a load as the pressure that it makes, too."""
    unit = SET_POINT_UNITS[key][1]
    return (unit, "GPa") if key == "load_n" else (unit,)


def _conversion(unit: str, key: str) -> Conversion | None:
    try:
        return conversion(unit.strip("[]()"), _targets(key))
    except ValueError:
        return None


def _column(row: int, name: str, below: str, sheet: _Sheet) -> _Column | None:
    """A column of the sheet; what is wrong with it goes to the mistakes."""
    known = sheet.key(name)
    if known is None:
        words = [*sheet.keys, *listed_names(sheet.settings)]
        near = difflib.get_close_matches(plain_key(apart(name)[0]), words, 1)
        hint = f"; did you mean {near[0]!r}?" if near else "."
        sheet.refuse(
            f"row {row}",
            f"found the unknown column {name!r}{hint} Known: {', '.join(sheet.keys)}. A column "
            "that is not to be read: list its name under `header: remarks` of the campaign file.",
        )
        return None
    key, named = known
    if key not in SET_POINT_UNITS:
        return _Column(name, key)
    unit = below or named
    to = _conversion(unit, key) if unit else None
    if to is None:
        found = f"found the unit {unit!r}" if unit else "has no unit"
        expected = " or ".join(_targets(key))
        sheet.refuse(
            f"row {row}, column {name!r}",
            f"{found}, expected {expected} in brackets behind the name or in a row below.",
        )
        return None
    return _Column(name, "max_hertz_pressure_gpa" if to.unit == "GPa" else key, to)


def _row(
    number: int, cells: Sequence[str], columns: Mapping[int, _Column], sheet: _Sheet
) -> SheetRow | None:
    """What a row says; its mistakes go to those of the sheet."""
    row, mistakes = f"row {number}", len(sheet.mistakes)
    filled = {index: cell for index, cell in enumerate(cells) if cell}
    if stray := [cell for index, cell in filled.items() if index not in columns]:
        sheet.refuse(
            row,
            f"the cell {stray[0][:60]!r} is in no column: expected {len(columns)} cells. A text "
            "with the delimiter in it needs quotes.",
        )
        return None
    texts = {columns[index].key: cell for index, cell in filled.items()}
    if "file" not in texts:
        sheet.refuse(f"{row}, column 'file'", "is empty, expected the name of a log or a pattern.")
    exclude = texts.get("exclude", "")
    if exclude.lower() in _UNREASONED:
        expected = "the reason for leaving the run out, or nothing"
        sheet.refuse(f"{row}, column 'exclude'", f"found {exclude!r}, expected {expected}.")
    excluded = exclude.lower() not in _KEPT
    keys: dict[str, str] = {}
    for index, text in filled.items():
        column = columns[index]
        if column.key in _COLUMNS and column.key != "oil":
            continue
        value, expected = _value(column, text, sheet)
        if value is not None:
            keys[column.key] = value
        elif not excluded:  # of a run that is left out nothing need be known
            where = f"{row}, column {column.name!r}"
            sheet.refuse(where, f"found {text[:60]!r}, expected {expected}.")
    if len(sheet.mistakes) > mistakes:
        return None
    reason = printable(exclude) if excluded else ""
    return SheetRow(texts["file"], texts.get("run", ""), reason, keys)


def _value(column: _Column, text: str, sheet: _Sheet) -> tuple[str | None, str]:
    """The value of a cell as its header key holds it, or None, and what is expected there."""
    key, settings = column.key, sheet.settings
    if key not in SET_POINT_UNITS:
        torque = settings.campaign.torque
        bearings = [torque.bearing] if torque else []
        names = {
            "oil": [*settings.oils],
            "rig": [*settings.rigs],
            "bearing": bearings,
            "log_kind": ["continuous", "steps"],
        }
        known = names[key]
        name = settings.oil_ids.get(plain_key(text), text) if key == "oil" else text
        expected = f"{key} of the campaign {settings.campaign.name}: {', '.join(known)}"
        return (name if name in known else None), expected
    least, most = set_point_range(key)
    expected = (
        f"a number above {least:g}, below {most:g} {column.to.unit} (the column says the unit)"
    )
    try:
        logged = decimal_number(text)
    except ValueError:
        return None, expected
    value = f"{float(column.to.of(np.array(logged))):.12g}"
    return (value if set_point(key, value) is not None else None), expected
