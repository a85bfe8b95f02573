"""One example value of each column, from finished tables, for `docs/reference/tables.md`.

`make schemas RESULTS="results/demo results/thermal results/etm-slim"` renews them from finished
campaigns. A test fails where a column has no example that its declaration allows.
"""

import json
import textwrap
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm.base import studies
from oilfilm.base.home import HOME
from oilfilm.tables import TABLES, read, read_footer
from oilfilm.tables.dictionary import Column, Table

EXAMPLES = HOME / "docs/reference/table_examples.json"
# Longest text of an example, and most texts of a list.
_LONGEST = 40
_MOST_TEXTS = 3
# Where several files hold a table, the first file of the last folder counts.
_FOLDERS = ("refused", "figures", "twin", "tables")


def read_examples() -> dict[str, dict[str, Any]]:
    """Example by table and column; None where no finished table had a value."""
    examples: dict[str, dict[str, Any]] = json.loads(EXAMPLES.read_text("utf-8"))
    return examples


def examples(*results: Path) -> dict[str, dict[str, Any]]:
    """Examples from the folders of finished campaigns; the first one that has a value counts.

    Raises:
        OilfilmError: A table is damaged or of another version.
    """
    studies.declare_tables(studies.available())
    examples_by_table: dict[str, dict[str, Any]] = {}
    for folder in results:
        path_by_table = {
            read_footer(path)["table"]: path
            for part in _FOLDERS
            for path in sorted((folder / part).rglob("*.parquet"), reverse=True)
        }
        for name, path in path_by_table.items():
            new_examples = _examples_of(TABLES[name], read(name, path))
            example_by_column = examples_by_table.setdefault(name, new_examples)
            for column, example in example_by_column.items():
                if example is None:
                    example_by_column[column] = new_examples[column]
    return {name: examples_by_table.get(name, {}) for name in TABLES}


def _examples_of(table: Table, frame: pd.DataFrame) -> dict[str, Any]:
    """Values of the fullest row; of another one where that row is empty."""
    filled = frame.notna() & ~frame.map(_is_empty)
    fullest = filled.sum(axis="columns")
    row = _middle(fullest.index[fullest == fullest.max()])
    values = {}
    for column in table.columns:
        rows_with_value = filled.index[filled[column.name]]
        row_of_example = row if row in rows_with_value else _middle(rows_with_value)
        values[column.name] = None
        if row_of_example is not None:
            values[column.name] = _shown(frame[column.name][row_of_example], column)
    return values


def _is_empty(value: object) -> bool:
    """Whether a text or a list has nothing in it."""
    return isinstance(value, str | tuple) and not value


def _middle(rows: pd.Index) -> Any:
    """A row from the middle, because the first one is often a zero or a limit."""
    return rows[len(rows) // 2] if len(rows) else None


def _shown(value: Any, column: Column) -> Any:
    """A value as JSON can hold it, rounded or shortened."""
    if column.type == "number":
        return float(f"{value:.4g}")
    if column.type == "texts":
        return [_short(text) for text in value[:_MOST_TEXTS]]
    return _short(value) if column.type == "text" else value.item()


def _short(text: str) -> str:
    text = text.replace("`", "")  # the page shows it between such marks
    if " " in text:
        return textwrap.shorten(text, _LONGEST, placeholder=" …", break_on_hyphens=False)
    return text if len(text) <= _LONGEST else f"{text[:12]}…"


def write_examples(*results: Path) -> None:
    """Renew the stored examples from the folders of finished campaigns."""
    text = json.dumps(examples(*results), indent=1, ensure_ascii=False)
    EXAMPLES.write_text(text + "\n", encoding="utf-8", newline="\n")
