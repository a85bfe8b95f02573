"""What a column and a table are; the YAML files beside it declare them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import pandas as pd

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
        return "category" if self.dictionary else _DTYPES[self.type]

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
