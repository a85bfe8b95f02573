"""Columns and tables as their YAML files declare them.

`declaration.py` has the keys of these files. Tables of oilfilm are in `rig.yaml`, `fits.yaml`,
`bearing.yaml` and `drawn.yaml`; a package beside oilfilm has a file of its own.

Decides: columns and key of every table, what a column means, and its unit, each in a YAML file
beside it (`rig.yaml` with `points` and `runs`, `fits.yaml`, `bearing.yaml`).
"""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.settings.messages import validated_file
from oilfilm.settings.yaml_file import YamlFile, read_yaml
from oilfilm.tables.declaration import (
    BY_ROW,
    ColumnEntry,
    ColumnList,
    Declarations,
    Limits,
    Refinement,
    TableEntry,
)

# Bound of every number, because infinity passes a plain lower bound. No quantity of a traction rig
# comes near this one.
LARGEST_NUMBER = 1e12
ColumnType = Literal["number", "integer", "text", "texts", "flag"]
# A check over several columns: a complaint, or an empty text where all is well.
TableCheck = Callable[[pd.DataFrame], str]
_DTYPES = {
    "number": "float64",
    "integer": "int64",
    "text": "str",
    "texts": "object",  # a tuple of texts, or None where it is not known
    "flag": "bool",
}


@dataclass(frozen=True)
class Column:
    """One column, the same in every table that has it.

    Attributes:
        name: Of the column; it ends in the unit where the unit is not 1.
        type: Type of its values.
        unit: One of `UNITS` in `tables.declaration`; empty for text, lists of texts and flags.
        meaning: What it is, in every table.
        caveat: What a user must know before trusting it ("calibration is not included").
        nullable: Whether values may be missing.
        at_least: Smallest value allowed.
        at_most: Largest value allowed.
        allowed: The only texts allowed, in a list too; empty where any is.
        note: What one table adds, as "mean over the plateau".
        dictionary: Whether one table stores it dictionary-encoded, because few texts repeat.
    """

    name: str
    type: ColumnType
    unit: str
    meaning: str
    caveat: str = ""
    nullable: bool = False
    at_least: float | None = None
    at_most: float | None = None
    allowed: tuple[str, ...] = ()
    note: str = ""
    dictionary: bool = False

    @property
    def dtype(self) -> str:
        """Name of its type in pandas."""
        if self.dictionary:
            return "category"
        # of three values: true, false, unknown
        return "boolean" if self.type == "flag" and self.nullable else _DTYPES[self.type]

    @property
    def shown_unit(self) -> str:
        """Unit to write behind a number; empty for plain numbers and a unit of its own per row."""
        return "" if self.unit in ("1", BY_ROW) else self.unit

    @property
    def meaning_here(self) -> str:
        """Meaning, and what the table adds."""
        return "; ".join(filter(None, (self.meaning, self.note)))

    @property
    def description(self) -> str:
        """Meaning, note and caveat in one line."""
        return "; ".join(filter(None, (self.meaning_here, self.caveat)))

    def is_list_allowed(self, value: object) -> bool:
        """Whether a value is a tuple of texts that this column of lists may hold."""
        if not isinstance(value, tuple):
            return False
        if not all(isinstance(text, str) for text in value):
            return False
        return not self.allowed or set(value) <= set(self.allowed)


@dataclass(frozen=True, eq=False)
class Table:
    """One table: its columns in order, what identifies a row, and what must hold.

    Attributes:
        name: Of the table.
        description: What one row is, in one line.
        columns: In order; there are no others.
        key: Columns that no two rows share.
        no_key: Why there is no key; empty where there is one.
        caveats: What a user must know about the whole table.
        references: Other tables that its rows belong to, with the columns that say so.
        checks: Checks over several columns.
    """

    name: str
    description: str
    columns: tuple[Column, ...]
    key: tuple[str, ...] = ()
    no_key: str = ""
    caveats: str = ""
    references: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    checks: tuple[TableCheck, ...] = ()

    @property
    def full_description(self) -> str:
        """Description and caveats."""
        return " ".join(filter(None, (self.description, self.caveats)))

    def __getitem__(self, name: str) -> Column:
        """The column of that name, with what this table adds."""
        return self._column_by_name[name]

    @property
    def column_names(self) -> list[str]:
        """Names of the columns, in order."""
        return list(self._column_by_name)

    @cached_property
    def _column_by_name(self) -> Mapping[str, Column]:
        return {column.name: column for column in self.columns}

    @cached_property
    def schema(self) -> Any:
        """The pandera schema that frames of this table are validated with."""
        # imported where needed: frames that plainly obey their table never pay for it (a second)
        import pandera.pandas as pa  # noqa: PLC0415

        return pa.DataFrameSchema(
            {column.name: _pandera_column(column) for column in self.columns},
            strict=True,
            ordered=True,
            name=self.name,
            description=self.description,
        )

    def complaints(self, frame: pd.DataFrame) -> list[str]:
        """What is wrong across columns or rows, one text each."""
        messages = [repetition_complaint(frame, self.key) if self.key else ""]
        messages += [check(frame) for check in self.checks]
        return [message for message in messages if message]


def _pandera_column(column: Column) -> Any:
    import pandera.pandas as pa  # noqa: PLC0415

    checks = []
    if column.at_least is not None:
        checks.append(pa.Check.ge(column.at_least))
    if column.at_most is not None:
        checks.append(pa.Check.le(column.at_most))
    if column.type == "texts":
        checks.append(pa.Check(column.is_list_allowed, element_wise=True, name="list_of_texts"))
    elif column.allowed:
        checks.append(pa.Check.isin(column.allowed))
    return pa.Column(
        str if column.dtype == "str" else column.dtype,
        checks=checks,
        nullable=column.nullable,
        coerce=True,
        description=column.description,
    )


def repetition_complaint(frame: pd.DataFrame, key: Sequence[str]) -> str:
    """A complaint that rows share a key; empty where none do."""
    repeating_rows = frame[frame.duplicated(list(key))]
    if repeating_rows.empty:
        return ""
    first_key = ", ".join(f"{name} {repeating_rows.iloc[0][name]}" for name in key)
    return f"{len(repeating_rows)} rows repeat {' + '.join(key)}, the first at {first_key}"


# Every column and every table by name, in the order in which they are described.
COLUMNS: dict[str, Column] = {}
TABLES: dict[str, Table] = {}
# Lists of columns that several tables share; `column_sets` in the files.
_COLUMN_SETS: dict[str, ColumnList] = {}

# Attributes of a column by the type that its declaration names; its own limits replace them.
_ATTRIBUTES_BY_DECLARED_TYPE: dict[str, dict[str, Any]] = {
    # infinity passes no bound
    "number": {
        "type": "number",
        "nullable": True,
        "at_least": -LARGEST_NUMBER,
        "at_most": LARGEST_NUMBER,
    },
    "share": {"type": "number", "unit": "1", "nullable": True, "at_least": 0, "at_most": 1},
    "count": {"type": "integer", "unit": "1", "at_least": 0},
    "text": {"type": "text"},
    "texts": {"type": "texts"},
    "flag": {"type": "flag"},
}

_DECLARED_COLUMN = "a declared column"
_COLUMN_OF_TABLE = "a column of this table"


def declare(path: Path, checks: Mapping[str, TableCheck] | None = None) -> None:
    """Add the columns and tables of a YAML file.

    Args:
        path: The file.
        checks: A check over several columns, by the name of the table.

    Raises:
        OilfilmError: A key is unknown or a value is wrong, a name is declared twice, or a table
            names a column that is not declared. The message has the file and the line.
    """
    file = read_yaml(path)
    declarations: Declarations = validated_file(file, Declarations)
    for name, column in declarations.columns.items():
        _refuse_second_declaration(name, COLUMNS, file, ("columns", name))
        COLUMNS[name] = _column(name, column)
    for name, column_set in declarations.column_sets.items():
        _refuse_second_declaration(name, _COLUMN_SETS, file, ("column_sets", name))
        key_path = ("column_sets", name)
        _refuse_unknown(column_set.columns, COLUMNS, _DECLARED_COLUMN, file, (*key_path, "columns"))
        names_in_set = column_set.columns
        # in every table that has the set
        refined = column_set.in_this_table
        _refuse_unknown(refined, names_in_set, _COLUMN_OF_TABLE, file, (*key_path, "in_this_table"))
        _COLUMN_SETS[name] = column_set
    for name, table in declarations.tables.items():
        _refuse_second_declaration(name, TABLES, file, ("tables", name))
        TABLES[name] = _table(name, table, file, (checks or {}).get(name))


def _column(name: str, entry: ColumnEntry) -> Column:
    attributes: dict[str, Any] = {"unit": entry.unit or ""}
    attributes |= _ATTRIBUTES_BY_DECLARED_TYPE[entry.type]
    attributes |= _limit_attributes(entry)
    return Column(name=name, meaning=entry.meaning, caveat=entry.caveat or "", **attributes)


def _limit_attributes(entry: Limits) -> dict[str, Any]:
    """The limits that a declaration gives, as attributes of a column."""
    limits: dict[str, Any] = {}
    if entry.required is not None:
        limits["nullable"] = not entry.required
    if entry.at_least is not None:
        limits["at_least"] = entry.at_least
    if entry.at_most is not None:
        limits["at_most"] = entry.at_most
    if entry.allowed is not None:
        limits["allowed"] = tuple(entry.allowed)
    return limits


def _refined_column(name: str, refinement: Refinement) -> Column:
    """A column as one table has it: same unit and meaning, other limits, a note."""
    return replace(
        COLUMNS[name],
        note=refinement.note or "",
        dictionary=refinement.dictionary,
        **_limit_attributes(refinement),
    )


def _table(name: str, entry: TableEntry, file: YamlFile, check: TableCheck | None) -> Table:
    key_path = ("tables", name)
    _refuse_unknown(
        entry.column_sets or [], _COLUMN_SETS, "a declared set", file, (*key_path, "column_sets")
    )
    _refuse_unknown(entry.columns, COLUMNS, _DECLARED_COLUMN, file, (*key_path, "columns"))
    column_names: list[str] = []
    refinements: dict[str, Refinement] = {}
    for set_name in entry.column_sets or []:
        column_names += _COLUMN_SETS[set_name].columns
        refinements |= _COLUMN_SETS[set_name].in_this_table
    column_names += entry.columns
    refinements |= entry.in_this_table
    _refuse_unknown(
        entry.in_this_table, column_names, _COLUMN_OF_TABLE, file, (*key_path, "in_this_table")
    )
    _refuse_unknown(entry.key or [], column_names, _COLUMN_OF_TABLE, file, (*key_path, "key"))
    columns = tuple(
        _refined_column(column_name, refinements[column_name])
        if column_name in refinements
        else COLUMNS[column_name]
        for column_name in column_names
    )
    references = {other_name: tuple(key) for other_name, key in entry.references.items()}
    return Table(
        name=name,
        description=entry.description,
        columns=columns,
        key=tuple(entry.key or ()),
        no_key=entry.no_key or "",
        caveats=entry.caveats or "",
        references=references,
        checks=(check,) if check else (),
    )


def _refuse_second_declaration(
    name: str, declared: Mapping[str, object], file: YamlFile, key_path: Sequence[str]
) -> None:
    """Refuse a name that another file has declared already.

    Raises:
        OilfilmError: It is declared already.
    """
    if name in declared:
        location = file.location_of(key_path)
        raise OilfilmError(
            f"{location}: {name!r} is declared a second time under `{key_path[0]}`; "
            "expected one declaration in all files. Use another name."
        )


def _refuse_unknown(
    names: Iterable[str],
    allowed_names: Container[str],
    expected: str,
    file: YamlFile,
    key_path: Sequence[str],
) -> None:
    """Refuse a name that is not among the allowed ones.

    Raises:
        OilfilmError: There is such a name.
    """
    for index, name in enumerate(names):
        if name not in allowed_names:
            # in a list the line of its item, in a group that of its key
            last_key = name if key_path[-1] == "in_this_table" else index
            location = file.location_of((*key_path, last_key))
            raise OilfilmError(
                f"{location}: found {name!r} under `{'.'.join(key_path)}`, "
                f"expected {expected}. Declare it, or correct the name."
            )


def unit_of(name: str) -> str:
    """The unit of a column; "1" for plain numbers, empty for text and flags.

    Raises:
        KeyError: No table has such a column.
    """
    return COLUMNS[name].unit


def _verdict_agrees_with_failed_gates(frame: pd.DataFrame) -> str:
    passed_all_gates = frame["failed_gates"].map(len) == 0
    contradictions = int((frame["accepted"] != passed_all_gates).sum())
    if not contradictions:
        return ""
    return f"{contradictions} points are accepted with a failed gate or refused without one"


for file_name in ("rig", "fits", "bearing", "drawn"):
    declare(
        Path(__file__).with_name(f"{file_name}.yaml"),
        checks={
            "points": _verdict_agrees_with_failed_gates,
            "refused_pages": lambda frame: repetition_complaint(
                frame[frame["page"] != ""], ["page"]
            ),
        },
    )
