"""Columns and tables as their YAML files declare them: one line per column, one entry per table.

A column is declared once: `name: kind | meaning | caveat`. The kind is a unit (of a number),
`share`, `count`, `text`, `flag` or `flag or null` (true, false, unknown); then `required` where it
is never null, bounds, and in brackets
the only texts allowed. A table lists the names of its columns. Under `uses` it may narrow a column
and add a note, but it has no unit and no meaning of its own: the same name is the same quantity
everywhere.

Decides: columns and key of every table, what a column means, and its unit, each in a YAML file
beside it (`rig.yaml` with `points` and `runs`, `fits.yaml`, `bearing.yaml`).
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import pandas as pd
import yaml

# Infinity passes a plain lower bound; no quantity of a traction rig comes near this one.
LARGEST = 1e12
# The unit of a number whose rows have units of their own; its caveat says which.
BY_ROW = "by row"
UNITS = frozenset(
    {"1", "s", "N", "m/s", "degC", "K", "GPa", "um", "mm", "deg", "rpm", "W", "N m", "mm rpm"}
    | {BY_ROW}
)
Type = Literal["number", "integer", "text", "flag"]
# A check over several columns: a complaint, or an empty text where all is well.
Check = Callable[[pd.DataFrame], str]
_DTYPES = {"number": "float64", "integer": "int64", "text": "str", "flag": "bool"}


@dataclass(frozen=True)
class Column:
    """One column, the same in every table that has it.

    Attributes:
        name: Of the column; it ends in the unit where the unit is not 1.
        type: Type of its values.
        unit: One of `UNITS`; empty for text and flags.
        meaning: What it is, in every table.
        caveat: What a user must know before trusting it ("calibration is not included").
        nullable: Whether values may be missing.
        at_least: Smallest value allowed.
        at_most: Largest value allowed.
        allowed: The only texts allowed; empty where any is.
        note: What one table adds, as "mean over the plateau".
        dictionary: Whether one table stores it dictionary-encoded, because few texts repeat.
    """

    name: str
    type: Type
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
        """Unit to write behind a number; empty for plain numbers and for units of their own."""
        return "" if self.unit in ("1", BY_ROW) else self.unit

    @property
    def meaning_here(self) -> str:
        """Meaning, and what the table adds."""
        return "; ".join(filter(None, (self.meaning, self.note)))

    @property
    def description(self) -> str:
        """Meaning, note and caveat in one line."""
        return "; ".join(filter(None, (self.meaning_here, self.caveat)))


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
    checks: tuple[Check, ...] = ()

    @property
    def about(self) -> str:
        """Description and caveats."""
        return " ".join(filter(None, (self.description, self.caveats)))

    def __getitem__(self, name: str) -> Column:
        """The column of that name, with what this table adds."""
        return self._by_name[name]

    @property
    def names(self) -> list[str]:
        """Names of the columns, in order."""
        return list(self._by_name)

    @cached_property
    def _by_name(self) -> Mapping[str, Column]:
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
        """What is wrong across columns or rows."""
        messages = [repeated(frame, self.key) if self.key else ""]
        messages += [check(frame) for check in self.checks]
        return [message for message in messages if message]


def _pandera_column(column: Column) -> Any:
    import pandera.pandas as pa  # noqa: PLC0415

    checks = []
    if column.at_least is not None:
        checks.append(pa.Check.ge(column.at_least))
    if column.at_most is not None:
        checks.append(pa.Check.le(column.at_most))
    if column.allowed:
        checks.append(pa.Check.isin(column.allowed))
    return pa.Column(
        str if column.dtype == "str" else column.dtype,
        checks=checks,
        nullable=column.nullable,
        coerce=True,
        description=column.description,
    )


def repeated(frame: pd.DataFrame, key: Sequence[str]) -> str:
    """A complaint where rows share a key; empty where none do."""
    again = frame[frame.duplicated(list(key))]
    if again.empty:
        return ""
    first = ", ".join(f"{name} {again.iloc[0][name]}" for name in key)
    return f"{len(again)} rows repeat {' + '.join(key)}, the first at {first}"


# Every column and every table by name, in the order in which they are described.
COLUMNS: dict[str, Column] = {}
TABLES: dict[str, Table] = {}
# Columns that several tables share, as `@friction`, and what these tables say of them.
_SETS: dict[str, Mapping[str, Any]] = {}

_KIND = re.compile(
    r"(?P<unit>[^<>(]*?) ?(?P<words>(?:\b(?:dictionary|required)\b ?)*)"
    r"(?:>= (?P<at_least>\S+) ?)?(?:<= (?P<at_most>\S+) ?)?(?:\((?P<allowed>.*)\))?"
)


def declare(path: Path, checks: Mapping[str, Check] | None = None) -> None:
    """Add the columns and tables of a YAML file.

    Args:
        path: The file.
        checks: By table: a check over several columns.

    Raises:
        ValueError: A name is declared twice.
        KeyError: A table has a column that is not declared.
    """
    content = yaml.load(path.read_bytes(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # noqa: S506
    for name, text in content["columns"].items():
        if name in COLUMNS:
            raise ValueError(f"{path}: column {name!r} is declared twice")
        COLUMNS[name] = _column(name, text)
    _SETS.update(content.get("sets", {}))
    for name, entry in content["tables"].items():
        if name in TABLES:
            raise ValueError(f"{path}: table {name!r} is declared twice")
        TABLES[name] = _table(name, entry, (checks or {}).get(name))


def _column(name: str, text: str) -> Column:
    kind, meaning, *caveat = text.split(" | ")
    unit, limits = _limits(kind)
    declared: dict[str, Any] = {"name": name, "meaning": meaning, "caveat": "".join(caveat)}
    if unit in ("text", "flag"):
        declared |= {"type": unit, "unit": ""}
    elif unit == "flag or null":
        declared |= {"type": "flag", "unit": "", "nullable": True}
    elif unit == "count":
        declared |= {"type": "integer", "unit": "1", "at_least": 0}
    elif unit == "share":
        declared |= {"type": "number", "unit": "1", "nullable": True, "at_least": 0, "at_most": 1}
    else:  # infinity passes no bound
        declared |= {"type": "number", "unit": unit, "nullable": True}
        declared |= {"at_least": -LARGEST, "at_most": LARGEST}
    return Column(**declared | limits)


def _limits(kind: str) -> tuple[str, dict[str, Any]]:
    """Unit of a kind, and its limits as attributes of a column."""
    match = _KIND.fullmatch(kind)
    if match is None:
        raise ValueError(f"{kind!r} is no kind of column")
    unit, words, at_least, at_most, allowed = match.groups()
    limits: dict[str, Any] = {}
    if "required" in words:
        limits["nullable"] = False
    if "dictionary" in words:
        limits["dictionary"] = True
    for name, bound in (("at_least", at_least), ("at_most", at_most)):
        if bound is not None:
            limits[name] = float(bound)
    if allowed is not None:
        limits["allowed"] = tuple(allowed.split(", "))
    return unit, limits


def use(name: str, text: str) -> Column:
    """A column as one table has it: same unit and meaning, other bounds, a note.

    Args:
        name: Of the column.
        text: The note, or `limits | note`.
    """
    kind, _, note = text.rpartition("|")
    _, limits = _limits(kind.strip())
    return replace(COLUMNS[name], note=note.strip(), **limits)


def _table(name: str, entry: Mapping[str, Any], check: Check | None) -> Table:
    names: list[str] = []
    uses: dict[str, str] = {}
    for word in entry["columns"].split():
        shared = _SETS[word[1:]] if word[0] == "@" else {"columns": word}
        names += shared["columns"].split()
        uses |= shared.get("uses", {})
    uses |= entry.get("uses", {})
    if unknown := set(uses) - set(names):
        raise ValueError(f"table {name!r} has no columns {sorted(unknown)}")
    references = {other: tuple(key.split()) for other, key in entry.get("references", {}).items()}
    return Table(
        name=name,
        description=entry["row"],
        columns=tuple(use(each, uses[each]) if each in uses else COLUMNS[each] for each in names),
        key=tuple(entry.get("key", "").split()),
        no_key=entry.get("no_key", ""),
        caveats=entry.get("caveats", ""),
        references=references,
        checks=(check,) if check else (),
    )


def unit_of(name: str) -> str:
    """The unit of a column; "1" for plain numbers, empty for text and flags.

    Raises:
        KeyError: No table has such a column.
    """
    return COLUMNS[name].unit


def _verdict_agrees_with_failed_gates(frame: pd.DataFrame) -> str:
    wrong = int((frame["accepted"] != (frame["failed_gates"] == "")).sum())
    return f"{wrong} points are accepted with a failed gate or refused without one" if wrong else ""


for each in ("rig", "fits", "bearing", "drawn"):
    declare(
        Path(__file__).with_name(f"{each}.yaml"),
        checks={
            "points": _verdict_agrees_with_failed_gates,
            "refused_pages": lambda frame: repeated(frame[frame["page"] != ""], ["page"]),
        },
    )
