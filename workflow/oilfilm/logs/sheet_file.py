"""The file of the run sheet: one row per log, per run or per pattern of logs.

It is read as text logs are: in any usual encoding, with any delimiter, units in the names or in a
row below them. A mistake in it stops the run: nobody knows what it should have said.

Decides: columns, units and mistakes of the run sheet.
"""

import difflib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from oilfilm.errors import OilfilmError, printable
from oilfilm.logs.base import Refusal, number, set_point, set_point_range
from oilfilm.logs.header import FULL_WIDTH, SET_POINT_UNITS, apart
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.log_names import LogNames
from oilfilm.logs.raw_files import find_sheet, is_sheet, named_logs
from oilfilm.logs.run_sheet import (
    NO_SHEET,
    UNLISTED,
    UNMATCHED,
    UNMATCHED_ADVICE,
    RunSheet,
    SheetRow,
)
from oilfilm.logs.sheet_cells import LINES_SEARCHED, cells_of
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


_AS_TEXT = Conversion("")


@dataclass(frozen=True)
class _Column:
    """A column of the sheet, the header key that it gives, and how its numbers become the key's."""

    index: int
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

    def names(self) -> dict[str, str]:
        """Key by each name that its column may have."""
        own = {key: key for key in self.keys}
        set_points = {
            name: key
            for key in self.keys
            if key in SET_POINT_UNITS
            for quantity, _, units in [SET_POINT_UNITS[key]]
            for name in (quantity, *(f"{quantity}_{unit}" for unit in units))
        }
        named = {
            plain_key(name): key
            for key, listed in self.settings.campaign.header
            for name in listed or ()
            if key in own
        }
        return {**set_points, **own, **named}

    def refuse(self, where: str, sentence: str) -> None:
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
    logs = LogNames(files)
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
            remarks.append(_unmatched(row_number, row.file, nearest))
            near |= {nearest: f"row {row_number}: {row.file!r}"} if nearest else {}
    sheet.stop()
    if strays > _LISTED:
        reason = f"{strays - _LISTED} more rows match no log"
        remarks.append(Refusal(UNMATCHED, reason, UNMATCHED_ADVICE))
    if rows and len(matched) < len(files):
        remarks.append(_unlisted([file for file in files if file not in matched], files))
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
    sheets: dict[str, RunSheet] = {}
    rows: dict[str, tuple[SheetRow, ...]] = {}
    near: dict[str, str] = {}
    name, inside = "", raw.resolve()
    for path in paths:
        real = path.resolve()
        if not real.is_relative_to(inside):
            continue
        top, *below = real.relative_to(inside).parts
        if top not in sheets:
            sheets[top] = _sheet_of(raw / top, settings, kind)
        sheet = sheets[top]
        if sheet.name:
            name = sheet.name
            file = "/".join(below)
            rows[str(path)] = sheet.rows.get(file, ())
            near |= {str(path): sheet.near[file]} if file in sheet.near else {}
    return RunSheet(name, rows, near=near)


def _sheet_of(folder: Path, settings: Settings, kind: LogKind) -> RunSheet:
    path = find_sheet(folder)
    if path is None:
        return NO_SHEET
    # a log with an unfit name is no reason not to judge the others
    files = [name for name, fault in named_logs(folder) if not fault]
    return read_run_sheet(path.read_bytes(), path, files, settings, kind)


def _rows(content: bytes, sheet: _Sheet) -> list[tuple[int, SheetRow]]:
    """The rows with their numbers, as a spreadsheet counts them."""
    known = sheet.names()
    records = cells_of(content, sheet.path, lambda cell: _key(cell, known) is not None)
    start = _line_of_names(records, known)
    if start is None:
        seen = next((record for record in records if any(record)), [""])
        sheet.refuse("its first rows", f"found {', '.join(seen)[:120]!r}, {_expected(sheet)}")
        return []
    numbered = list(enumerate(records, start=1))[start:]
    names, below = numbered[0][1], numbered[1:]
    has_units = bool(below) and _is_unit_row(below[0][1], names, known)
    units = below.pop(0)[1] if has_units else []
    columns = _columns(numbered[0][0], names, units, sheet)
    if sheet.mistakes:
        return []
    rows = [(n, _row(n, cells, columns, sheet)) for n, cells in below if any(cells)]
    return [(n, row) for n, row in rows if row is not None]


def _expected(sheet: _Sheet) -> str:
    return (
        "expected a row of column names, one of them `file` (others: "
        f"{', '.join(key for key in sheet.keys if key != 'file')}). Names of your own: see "
        "`header` of the campaign file."
    )


def _key(cell: str, names: Mapping[str, str]) -> str | None:
    return names.get(plain_key(cell)) or names.get(plain_key(apart(cell.translate(FULL_WIDTH))[0]))


def _line_of_names(records: Sequence[Sequence[str]], names: Mapping[str, str]) -> int | None:
    """Index of the line of names: of the first ones that have `file`, the one most is known of."""
    lines = [
        index
        for index, record in enumerate(records[:LINES_SEARCHED])
        if any(_key(cell, names) == "file" for cell in record)
    ]
    known = [sum(_key(cell, names) is not None for cell in records[index]) for index in lines]
    return lines[known.index(max(known))] if lines else None


def _is_unit_row(cells: Sequence[str], names: Sequence[str], known: Mapping[str, str]) -> bool:
    """A row below the names that names no log and has a unit for some set point."""
    by_key = {_key(name, known): cell for name, cell in zip(names, cells, strict=False)}
    if by_key.get("file") not in ("", "-", None):
        return False
    return any(
        _conversion(cell, _targets(key)) is not None
        for key, cell in by_key.items()
        if key in SET_POINT_UNITS
    )


def _targets(key: str) -> tuple[str, ...]:
    """Units that a set point may be given in; a load as the pressure that it makes, too."""
    _, unit, _ = SET_POINT_UNITS[key]
    return (unit, "GPa") if key == "load_n" else (unit,)


def _conversion(unit: str, targets: tuple[str, ...]) -> Conversion | None:
    try:
        return conversion(unit.strip("[]()"), targets)
    except ValueError:
        return None


def _columns(
    row: int, names: Sequence[str], units: Sequence[str], sheet: _Sheet
) -> dict[int, _Column]:
    """The columns by their place; what is wrong with them goes to the mistakes of the sheet."""
    known = sheet.names()
    columns: dict[int, _Column] = {}
    for index, name in enumerate(names):
        key = _key(name, known)
        if not name:
            continue
        if key is None:
            near = difflib.get_close_matches(plain_key(apart(name)[0]), known, 1)
            hint = f"; did you mean {near[0]!r}?" if near else "."
            sheet.refuse(
                f"row {row}",
                f"found the unknown column {name!r}{hint} Known: {', '.join(sheet.keys)}. A column "
                "that is not to be read: list its name under `header: remarks` of the campaign "
                "file.",
            )
            continue
        unit = units[index] if index < len(units) else ""
        column = _column(row, index, name, unit, key, sheet)
        if column is None:
            continue
        if column.key != "remarks" and column.key in {each.key for each in columns.values()}:
            sheet.refuse(f"row {row}", f"the column {name!r} gives {column.key} a second time.")
        columns[index] = column
    return columns


def _column(row: int, index: int, name: str, unit: str, key: str, sheet: _Sheet) -> _Column | None:
    if key not in SET_POINT_UNITS:
        return _Column(index, name, key)
    quantity, own_unit, units = SET_POINT_UNITS[key]
    targets = _targets(key)
    bare, in_brackets = apart(name.translate(FULL_WIDTH))
    plain = plain_key(bare)
    # names that campaign files list are those of the key, in its unit
    implied = "" if plain == quantity else units.get(plain.removeprefix(f"{quantity}_"), own_unit)
    if in_brackets and implied and _conversion(in_brackets, targets) is None:
        in_brackets = None if plain_key(name) in sheet.names() else in_brackets
    given = unit or in_brackets or implied
    if not given:
        sheet.refuse(
            f"row {row}",
            f"the column {name!r} has no unit. Write `{name} [{own_unit}]`, or the unit in a row "
            "below the names.",
        )
        return None
    to = _conversion(given, targets)
    if to is None:
        expected = " or ".join(targets)
        sheet.refuse(
            f"row {row}, column {name!r}", f"found the unit {given!r}, expected one of {expected}."
        )
        return None
    pressure = to.unit == "GPa"
    return _Column(index, name, "max_hertz_pressure_gpa" if pressure else key, to)


def _row(
    row: int, cells: Sequence[str], columns: Mapping[int, _Column], sheet: _Sheet
) -> SheetRow | None:
    """What a row says; its mistakes go to those of the sheet."""
    for index, cell in enumerate(cells):
        if cell and index not in columns:
            sheet.refuse(
                f"row {row}",
                f"the cell {cell[:60]!r} is in no column: expected {len(columns)} cells. A text "
                "with the delimiter in it needs quotes.",
            )
            return None
    by_key = {
        column.key: (column, cells[index])
        for index, column in columns.items()
        if index < len(cells) and cells[index]
    }
    texts = {key: text for key, (_, text) in by_key.items()}
    if "file" not in texts:
        sheet.refuse(
            f"row {row}, column {_name_of('file', columns)!r}",
            "is empty, expected the name of a log or a pattern such as '*.csv'.",
        )
        return None
    exclude = texts.get("exclude", "")
    if exclude.lower() in _UNREASONED:
        sheet.refuse(
            f"row {row}, column {_name_of('exclude', columns)!r}",
            f"found {exclude!r}, expected the reason for leaving the run out, or nothing.",
        )
    excluded = exclude.lower() not in _KEPT | {""}
    keys: dict[str, str] = {}
    for key, (column, text) in by_key.items():
        if key in ("oil", *sheet.kind.sheet_keys):
            value, expected = _value(column, text, sheet)
            if value is not None:
                keys[key] = value
            elif not excluded:  # of a run that is left out nothing need be known
                where = f"row {row}, column {column.name!r}"
                sheet.refuse(where, f"found {text[:60]!r}, expected {expected}.")
    return SheetRow(
        texts["file"], texts.get("run", ""), printable(exclude) if excluded else "", keys
    )


def _name_of(key: str, columns: Mapping[int, _Column]) -> str:
    return next(column.name for column in columns.values() if column.key == key)


def _value(column: _Column, text: str, sheet: _Sheet) -> tuple[str | None, str]:
    """The value of a cell as its header key holds it, or None, and what is expected there."""
    settings = sheet.settings
    names = {
        "oil": list(settings.oils),
        "rig": list(settings.rigs),
        "bearing": [settings.campaign.torque.bearing] if settings.campaign.torque else [],
    }
    if column.key in names:
        name = settings.oil_ids.get(plain_key(text), text) if column.key == "oil" else text
        known = names[column.key]
        expected = f"{column.key} of the campaign {settings.campaign.name}: {', '.join(known)}"
        if column.key == "oil":
            expected += " (other names: `oil_aliases` of the campaign file)"
        return (name if name in known else None), expected
    least, most = set_point_range(column.key)
    expected = f"a number above {least:g}, below {most:g} {column.to.unit}"
    try:
        logged = number(text if "." in text else text.replace(",", ".", 1))
    except ValueError:
        return None, f"a number; its column says the unit ({expected})"
    value = f"{float(column.to.of(np.array(logged))):.12g}"
    return (value if set_point(column.key, value) is not None else None), expected


def _unmatched(row: int, cell: str, nearest: str | None) -> Refusal:
    hint = f"; did you mean {nearest!r}?" if nearest else ""
    reason = printable(f"row {row}: {cell!r} matches no log{hint}")
    return Refusal(UNMATCHED, reason, UNMATCHED_ADVICE)


def _unlisted(unlisted: Sequence[str], files: Sequence[str]) -> Refusal:
    listed = ", ".join(unlisted[:_LISTED]) + (" ..." if len(unlisted) > _LISTED else "")
    reason = printable(f"no row for {len(unlisted)} of {len(files)} logs: {listed}")
    return Refusal(UNLISTED, reason, "Only their headers count. Add rows where that is wrong.")
