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
from functools import cached_property
from itertools import zip_longest
from pathlib import Path, PurePosixPath

import numpy as np

from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.base import Refusal, decimal_number, set_point, set_point_range
from oilfilm.logs.encoding import encodings_of
from oilfilm.logs.header import FULL_WIDTH, SET_POINT_UNITS, UNITS, apart
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
_KEPT = frozenset("0 - n no false nein falsch non faux nej nei 否".split())
_UNREASONED = frozenset("1 x y yes true j ja wahr oui vrai si sí 是".split())
# So many mistakes, rows and names of logs are listed; the others are counted.
_LISTED = 20
# The line of names is near the top, below comments and the line `sep=;` of Excel.
_LINES_SEARCHED = 20
_LARGEST = 1 << 24
_AS_TEXT = Conversion("")

_PACKED = (".gz", ".zst")

Cells = list[list[str]]


class _LogNames:
    """The logs of a campaign by the names that the run sheet may give them."""

    def __init__(self, files: Sequence[str]) -> None:
        self.files = files
        self._whole = {file: _plain(file) for file in files}
        self._last = {file: PurePosixPath(name).name for file, name in self._whole.items()}
        self._by_name: list[dict[str, list[str]]] = []
        for names in (self._whole, self._last):
            # a log keeps its name when it is packed
            for name_of in (str, _unpacked):
                by_name: dict[str, list[str]] = {}
                for file, name in names.items():
                    by_name.setdefault(name_of(name), []).append(file)
                self._by_name.append(by_name)

    def meant(self, cell: str) -> tuple[list[str], bool]:
        """The logs that a cell of `file` means, and whether it is a name that several logs have.

        A name without a folder means a log in any folder.
        """
        pattern = _plain(cell.replace("\\", "/").removeprefix("./"))
        if not set(pattern) & set("*?"):
            found: list[str] = next(filter(None, (by.get(pattern) for by in self._by_name)), [])
            return found, len(found) > 1
        names = self._whole if "/" in pattern else self._last
        fitting = [
            file
            for file, name in names.items()
            if matches(name, pattern) or matches(_unpacked(name), pattern)
        ]
        return fitting, False

    def nearest(self, cell: str) -> str | None:
        """The log whose name resembles a cell most."""
        lasts = {_unpacked(last).casefold(): file for file, last in self._last.items()}
        name = PurePosixPath(_plain(cell).replace("\\", "/")).name
        near = difflib.get_close_matches(_unpacked(name).casefold(), lasts, 1)
        return lasts[near[0]] if near else None


def _plain(name: str) -> str:
    """A name with its letters composed: some systems write an umlaut as two characters."""
    return unicodedata.normalize("NFC", name)


def _unpacked(name: str) -> str:
    return next((name.removesuffix(end) for end in _PACKED if name.endswith(end)), name)


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

    @cached_property
    def names(self) -> dict[str, tuple[str, str]]:
        """Key and unit, empty where only the log can say it, by each name of a column."""
        own = {key: SET_POINT_UNITS[key][1] if key in SET_POINT_UNITS else "" for key in self.keys}
        set_points = {
            name: (key, unit)
            for key in self.keys
            if key in SET_POINT_UNITS
            for quantity, _ in [SET_POINT_UNITS[key]]
            for name, unit in [(quantity, ""), *((f"{quantity}_{u}", UNITS[u]) for u in UNITS)]
        }
        listed = {
            plain_key(name): (key, own[key])
            for key, names in self.settings.campaign.header
            for name in names or ()
            if key in own
        }
        return {**set_points, **{key: (key, own[key]) for key in own}, **listed}

    def key(self, cell: str) -> str | None:
        """The key that a cell names, with its unit or without."""
        names = cell, apart(cell.translate(FULL_WIDTH))[0]
        known = (self.names.get(plain_key(name)) for name in names)
        return next((key for key, _ in filter(None, known)), None)

    @cached_property
    def known(self) -> dict[str, list[str]]:
        """The names that a cell may hold, by the key of its column."""
        torque = self.settings.campaign.torque
        bearings = [torque.bearing] if torque else []
        return {"oil": [*self.settings.oils], "rig": [*self.settings.rigs], "bearing": bearings}

    def refuse(self, where: str, sentence: str) -> None:
        """Add a mistake."""
        self.mistakes.append(printable(f"{self.path}, {where}: {sentence}"))

    def stop(self) -> None:
        """End with all mistakes, if there are any."""
        if not self.mistakes:
            return
        more = len(self.mistakes) - _LISTED
        counted = [f"{self.path}: {more} more mistakes"] if more > 0 else []
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
    remarks: list[Refusal] = []
    near: dict[str, str] = {}
    strays = 0
    logs = _LogNames(files)
    for row_number, row in rows:
        found, ambiguous = logs.meant(row.file)
        if ambiguous:
            listed = ", ".join(found[:_LISTED])
            sheet.refuse(
                f"row {row_number}", f"{row.file!r} is the name of {listed}: add the folder."
            )
        for file in found:
            matched.setdefault(file, []).append(row)
        strays += not found
        if not found and strays <= _LISTED:
            nearest = logs.nearest(row.file)
            hint = f"; did you mean {nearest!r}?" if nearest else ""
            reason = printable(f"row {row_number}: {row.file!r} matches no log{hint}")
            remarks.append(Refusal(UNMATCHED, reason, UNMATCHED_ADVICE))
            near |= {nearest: f"row {row_number}: {row.file!r}"} if nearest else {}
    sheet.stop()
    if strays > _LISTED:
        reason = f"{strays - _LISTED} more rows match no log"
        remarks.append(Refusal(UNMATCHED, reason, UNMATCHED_ADVICE))
    unlisted = [file for file in files if file not in matched]
    if rows and unlisted:
        listed = ", ".join(unlisted[:_LISTED]) + (" ..." if len(unlisted) > _LISTED else "")
        reason = printable(f"no row for {len(unlisted)} of {len(files)} logs: {listed}")
        advice = "Only their headers count. Add rows where that is wrong."
        remarks.append(Refusal(UNLISTED, reason, advice))
    near = {file: row for file, row in near.items() if file not in matched}
    rows_of = {file: tuple(of) for file, of in matched.items()}
    return RunSheet(path.name, rows_of, tuple(remarks), near)


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
        near = {str(path): sheet.near[file] for file, path in logs.items() if file in sheet.near}
        together = RunSheet(sheet.name, {**together.rows, **rows}, (), {**together.near, **near})
    return together


def _rows(content: bytes, sheet: _Sheet) -> list[tuple[int, SheetRow]]:
    """The rows with their numbers, as a spreadsheet counts them."""
    records = _workbook(content, sheet) if content.startswith(b"PK") else _text(content, sheet)
    lines = records[:_LINES_SEARCHED]
    known = {n: [sheet.key(cell) for cell in record] for n, record in enumerate(lines)}
    named = [n for n, keys in known.items() if "file" in keys]
    if not named:
        seen = ", ".join(next(filter(any, records), [""]))[:120]
        others = ", ".join(key for key in sheet.keys if key != "file")
        sheet.refuse(
            "its first rows",
            f"found {seen!r}, expected a row of column names, one of them `file` (others: "
            f"{others}). Names of your own: see `header` of the campaign file.",
        )
        return []
    # of the first lines that have `file`, the one most is known of
    start = max(named, key=lambda n: len(known[n]) - known[n].count(None))
    below = start + 1
    units: list[str] = []
    if below < len(records) and _is_unit_row(known[start], records[below]):
        units, below = records[below], below + 1
    columns = _columns(start + 1, records[start], units, sheet)
    if sheet.mistakes:
        return []
    numbered = enumerate(records[below:], start=below + 1)
    rows = [(n, _row(n, cells, columns, sheet)) for n, cells in numbered if any(cells)]
    return [(n, row) for n, row in rows if row is not None]


def _text(content: bytes, sheet: _Sheet) -> Cells:
    """The cells of a text: in the encoding and with the delimiter that give most known names."""
    if len(content) > _LARGEST:
        raise OilfilmError(f"{sheet.path}: is larger than {_LARGEST >> 20} MiB.")
    readings: list[Cells] = []
    for encoding in encodings_of(content):
        text = content.decode(encoding, "replace").removeprefix("\ufeff")
        for delimiter in (",", ";", "\t", "|"):
            try:
                cells = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
            except csv.Error:
                continue
            readings.append([[cell.strip() for cell in row] for row in cells])
    if not readings:
        raise OilfilmError(f"{sheet.path}: cannot be read as text with delimiters. Save it as CSV.")

    def names(cells: Cells) -> int:
        lines = cells[:_LINES_SEARCHED]
        return max((sum(sheet.key(cell) is not None for cell in row) for row in lines), default=0)

    # the first of equals is the most likely one
    return max(readings, key=names)


def _workbook(content: bytes, sheet: _Sheet) -> Cells:
    """The cells of the first sheet of an Excel workbook."""
    # imported where needed: few run sheets are workbooks
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
            f"{sheet.path}: cannot be read as a workbook ({reason}). Save it as runs.csv."
        ) from None


def _cell(value: object) -> str:
    """A cell of a workbook as a text sheet would hold it."""
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return "" if value is None else str(value).strip()


def _is_unit_row(keys: Sequence[str | None], cells: Sequence[str]) -> bool:
    """A row below the names that names no log and has a unit for some set point."""
    by_key = dict(zip(keys, cells, strict=False))
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


def _columns(
    row: int, names: Sequence[str], units: Sequence[str], sheet: _Sheet
) -> dict[int, _Column]:
    """The columns by their place; what is wrong with them goes to the mistakes of the sheet."""
    columns: dict[int, _Column] = {}
    for index, (name, unit) in enumerate(zip_longest(names, units[: len(names)], fillvalue="")):
        column = _column(row, name, unit, sheet) if name else None
        if column is None:
            continue
        if column.key != "remarks" and column.key in {each.key for each in columns.values()}:
            sheet.refuse(f"row {row}", f"the column {name!r} gives {column.key} a second time.")
        columns[index] = column
    return columns


def _column(row: int, name: str, below: str, sheet: _Sheet) -> _Column | None:
    bare, beside = apart(name.translate(FULL_WIDTH))
    whole = sheet.names.get(plain_key(name))
    known = whole or sheet.names.get(plain_key(bare))
    if known is None:
        near = difflib.get_close_matches(plain_key(bare), sheet.names, 1)
        hint = f"; did you mean {near[0]!r}?" if near else "."
        sheet.refuse(
            f"row {row}",
            f"found the unknown column {name!r}{hint} Known: {', '.join(sheet.keys)}. A column "
            "that is not to be read: list its name under `header: remarks` of the campaign file.",
        )
        return None
    key, implied = known
    if key not in SET_POINT_UNITS:
        return _Column(name, key)
    # brackets may be a part of a name that the campaign file lists
    is_unit = beside and (whole is None or _conversion(beside, key))
    unit = below or (beside if is_unit else "") or implied
    if not unit:
        sheet.refuse(
            f"row {row}",
            f"the column {name!r} has no unit. Write `{name} [{_targets(key)[0]}]`, or the unit in "
            "a row below the names.",
        )
        return None
    to = _conversion(unit, key)
    if to is None:
        expected = " or ".join(_targets(key))
        sheet.refuse(
            f"row {row}, column {name!r}", f"found the unit {unit!r}, expected one of {expected}."
        )
        return None
    return _Column(name, "max_hertz_pressure_gpa" if to.unit == "GPa" else key, to)


def _row(
    row: int, cells: Sequence[str], columns: Mapping[int, _Column], sheet: _Sheet
) -> SheetRow | None:
    """What a row says; its mistakes go to those of the sheet."""
    filled = {index: cell for index, cell in enumerate(cells) if cell}
    if stray := [cell for index, cell in filled.items() if index not in columns]:
        sheet.refuse(
            f"row {row}",
            f"the cell {stray[0][:60]!r} is in no column: expected {len(columns)} cells. A text "
            "with the delimiter in it needs quotes.",
        )
        return None
    names = {column.key: column.name for column in columns.values()}
    texts = {columns[index].key: cell for index, cell in filled.items()}
    if "file" not in texts:
        sheet.refuse(
            f"row {row}, column {names['file']!r}",
            "is empty, expected the name of a log or a pattern such as '*.csv'.",
        )
        return None
    exclude = texts.get("exclude", "")
    if exclude.lower() in _UNREASONED:
        sheet.refuse(
            f"row {row}, column {names['exclude']!r}",
            f"found {exclude!r}, expected the reason for leaving the run out, or nothing.",
        )
    excluded = exclude.lower() not in _KEPT | {""}
    keys: dict[str, str] = {}
    for index, text in filled.items():
        column = columns[index]
        if column.key in _COLUMNS and column.key != "oil":
            continue
        value, expected = _value(column, text, sheet)
        if value is not None:
            keys[column.key] = value
        elif not excluded:  # of a run that is left out nothing need be known
            where = f"row {row}, column {column.name!r}"
            sheet.refuse(where, f"found {text[:60]!r}, expected {expected}.")
    reason = printable(exclude) if excluded else ""
    return SheetRow(texts["file"], texts.get("run", ""), reason, keys)


def _value(column: _Column, text: str, sheet: _Sheet) -> tuple[str | None, str]:
    """The value of a cell as its header key holds it, or None, and what is expected there."""
    known, settings = sheet.known.get(column.key), sheet.settings
    if known is not None:
        name, others = text, ""
        if column.key == "oil":
            name = settings.oil_ids.get(plain_key(text), text)
            others = " (other names: `oil_aliases` of the campaign file)"
        expected = f"{column.key} of the campaign {settings.campaign.name}: {', '.join(known)}"
        return (name if name in known else None), expected + others
    least, most = set_point_range(column.key)
    expected = f"a number above {least:g}, below {most:g} {column.to.unit}"
    try:
        logged = decimal_number(text)
    except ValueError:
        return None, f"a number; its column says the unit ({expected})"
    value = f"{float(column.to.of(np.array(logged))):.12g}"
    return (value if set_point(column.key, value) is not None else None), expected
