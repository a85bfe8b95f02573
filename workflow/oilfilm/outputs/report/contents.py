"""Tables of the report: which columns of the finished tables are shown, and how numbers read."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables

_NONE = "\N{EN DASH}"
_MINUS = "\N{MINUS SIGN}"


@dataclass(frozen=True)
class Column:
    """A column of a shown table; `meaning` is that of the table's model."""

    heading: str
    unit: str = ""
    meaning: str = ""
    is_number: bool = False
    is_verdict: bool = False


@dataclass(frozen=True)
class Shown:
    """A table as it is printed: plain texts, which the page escapes.

    Attributes:
        name: Of it in the page, unique.
        caption: What it shows.
        columns: Its columns.
        rows: One text per cell.
        left_out: Rows that are not shown, because there are too many.
        source: File of the campaign's results that has all of it.
    """

    name: str
    caption: str
    columns: Sequence[Column]
    rows: Sequence[Sequence[str]]
    left_out: int = 0
    source: str = ""

    def __bool__(self) -> bool:
        """True where it has rows."""
        return bool(self.rows)


Form = Callable[[Any], str]


@dataclass(frozen=True)
class Choice:
    """A column of a table model, with the heading and the form that it is shown in."""

    name: str
    heading: str
    form: Form = str
    unit: str | None = None
    is_verdict: bool = False


def significant(error: float) -> str:
    """Format that shows two digits of an error, which is all that a value is good for."""
    if np.isnan(error) or error <= 0:
        return ".4g"
    return f".{int(np.clip(1 - np.floor(np.log10(error)), 0, 8))}f"


def number(digits: str) -> Form:
    """How a number is written; a dash where there is none."""
    return lambda value: _NONE if np.isnan(value) else signed(f"{value:{digits}}")


def signed(text: str) -> str:
    """A number's text with a proper minus."""
    return text.replace("-", _MINUS)


def percent(digits: int) -> Form:
    """A share in percent."""
    return lambda value: _NONE if np.isnan(value) else signed(f"{100 * value:.{digits}f} %")


def yes_or_no(value: Any) -> str:
    """A flag in words."""
    return "yes" if value else "no"


def show(
    frame: pd.DataFrame,
    table: str,
    caption: str,
    choices: Sequence[Choice],
    *,
    name: str = "",
    most: int | None = None,
) -> Shown:
    """Some columns of a table.

    Args:
        frame: Rows of it.
        table: Name of its model, which has units and meanings.
        caption: What it shows.
        choices: Its columns.
        name: Of it in the page, if not the model's.
        most: Rows that are shown at most.
    """
    columns = [_column(table, choice) for choice in choices]
    rows = [
        [choice.form(row[choice.name]) for choice in choices] for row in tables.rows(frame[:most])
    ]
    left_out = len(frame) - len(rows)
    return Shown(name or table, caption, columns, rows, left_out, f"tables/{table}.parquet")


def _column(table: str, choice: Choice) -> Column:
    model = tables.TABLES[table][choice.name]
    unit = model.shown_unit.replace("degC", "\N{DEGREE SIGN}C")
    return Column(
        choice.heading,
        unit if choice.unit is None else choice.unit,
        model.description,
        model.type in ("number", "integer"),
        choice.is_verdict,
    )
