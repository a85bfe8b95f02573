"""The reference page of all tables, `docs/tables.md`, generated from the declaration.

`make schemas` renews it; a test fails where it is out of date.
"""

from pathlib import Path

from oilfilm.tables.declaration import LARGEST, Column, Table
from oilfilm.tables.store import TABLES

PAGE = Path(__file__).parents[3] / "docs/tables.md"
_BEGINS = """# All tables

Generated from the declaration in `workflow/oilfilm/tables` by `make schemas`; do not edit.
A column name has the same unit and meaning in every table that has it.
Unit 1: a plain number. Unit "by row": each row has its own, see the caveat.
The tables from `coefficient_table` on hold what figures draw; they are in `figures/`.
"""
_COLUMNS_BEGIN = "| column | type | unit | meaning | caveat |\n| --- | --- | --- | --- | --- |"


def page() -> str:
    """The text of the page."""
    return "\n".join([_BEGINS, *(_section(table) for table in TABLES.values())])


def _section(table: Table) -> str:
    key = ", ".join(f"`{name}`" for name in table.key)
    references = [
        f"`{other}` by {', '.join(f'`{name}`' for name in columns)}"
        for other, columns in table.references.items()
    ]
    lines = [
        f"## {table.name}\n",
        f"{_cell(table.about)}\n",
        f"Key: {key}." if key else f"No key. {table.no_key}",
        *([f"Belongs to: {'; '.join(references)}."] if references else []),
        "",
        _COLUMNS_BEGIN,
        *(_row(column) for column in table.columns),
    ]
    return "\n".join(lines) + "\n"


def _row(column: Column) -> str:
    cells = (
        f"`{column.name}`",
        column.type + (", may be null" if column.nullable else ""),
        column.unit,
        column.meaning_here + _limits(column),
        column.caveat,
    )
    return "| " + " | ".join(_cell(cell) for cell in cells) + " |"


def _limits(column: Column) -> str:
    if column.allowed:
        return f" ({', '.join(text or 'empty' for text in column.allowed)})"
    low, high = column.at_least, column.at_most
    if column.type != "number" or low is None or high is None or low == -LARGEST:
        return ""
    return f" (from {low:g})" if high == LARGEST else f" (from {low:g} to {high:g})"


def _cell(text: str) -> str:
    return text.replace("|", r"\|").replace("<", r"\<")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
