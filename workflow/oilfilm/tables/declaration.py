"""YAML files that declare columns and tables, as one typed model.

A file has up to three groups:

- `columns`: each column once, by its name;
- `column_sets`: names of columns that several tables share;
- `tables`: each table with its key and the names of its columns.

Under `in_this_table` a table narrows one of its columns or adds a note. It cannot change unit and
meaning: the same name is the same quantity everywhere.

Decides: which keys the declaration of a column or of a table has.
"""

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, model_validator

from oilfilm.settings.base import Group, OneOf, key_error_at, optional
from oilfilm.settings.base import key as yaml_key
from oilfilm.settings.quantities import OneOrMore, OneOrMoreDistinct, Text

# The unit of a column in which each row has a unit of its own; the caveat of the column says which.
BY_ROW = "by row"
PHYSICAL_UNITS = (
    "s",
    "N",
    "m/s",
    "degC",
    "K",
    "GPa",
    "um",
    "mm",
    "deg",
    "rpm",
    "W",
    "N m",
    "mm rpm",
)
UNITS = ("1", BY_ROW, *PHYSICAL_UNITS)
Unit = Annotated[str, OneOf(UNITS)]
# Types that a declaration may name. A share is a number from 0 to 1; a count is a whole number from
# 0; texts are a list, which may be empty.
DeclaredType = Literal["number", "share", "count", "text", "texts", "flag"]


def _one_line(text: str) -> str:
    return " ".join(text.split())


Sentence = Annotated[Text, AfterValidator(_one_line)]


class Limits(Group):
    """What the values of a column may be."""

    required: bool | None = optional(
        "Whether every row has a value. If left out, only numbers and shares may be null."
    )
    at_least: float | None = optional("Smallest value allowed.")
    at_most: float | None = optional("Largest value allowed.")
    allowed: OneOrMoreDistinct[str] | None = optional("The only texts allowed, in a list too.")


class ColumnEntry(Limits):
    """One column, the same in every table that has it."""

    type: DeclaredType = yaml_key("Type of the values.", default="number")
    unit: Unit | None = optional("Unit of a number; '1' for a plain number.")
    meaning: Sentence = yaml_key("What the column is, in every table.")
    caveat: Sentence | None = optional(
        "What a user must know before trusting it, as 'calibration is not included'."
    )

    @model_validator(mode="after")
    def _only_numbers_have_units(self) -> Self:
        if self.type == "number" and self.unit is None:
            raise key_error_at(("unit",), "is missing; a number has a unit, or '1'.")
        if self.type != "number" and self.unit is not None:
            raise key_error_at(("unit",), f"a column of type {self.type} has no unit; remove it.")
        return self


class Refinement(Limits):
    """What one table says of a column beyond its declaration."""

    note: Sentence | None = optional("What the table adds, as 'mean over the plateau'.")
    dictionary: bool = yaml_key(
        "Whether each different text is stored once, because few texts repeat.", default=False
    )


class ColumnList(Group):
    """Columns of a table, or of several tables."""

    columns: OneOrMore[str] = yaml_key("Names of columns, in order.")
    in_this_table: dict[str, Refinement] = yaml_key(
        "By name of a column: what is narrower or added here.", default={}
    )


class TableEntry(ColumnList):
    """One table."""

    description: Sentence = yaml_key("What one row is, in one line.")
    caveats: Sentence | None = optional("What a user must know about the whole table.")
    key: OneOrMoreDistinct[str] | None = optional("Columns that no two rows share.")
    no_key: Sentence | None = optional("Why there is no key.")
    references: dict[str, OneOrMore[str]] = yaml_key(
        "Other tables that the rows belong to, with the columns that say so.", default={}
    )
    column_sets: OneOrMoreDistinct[str] | None = optional(
        "Sets of columns that come before its own."
    )


class Declarations(Group):
    """One file."""

    columns: dict[str, ColumnEntry] = yaml_key("Columns by their names.", default={})
    column_sets: dict[str, ColumnList] = yaml_key("Columns that several tables share.", default={})
    tables: dict[str, TableEntry] = yaml_key("Tables by their names.", default={})
