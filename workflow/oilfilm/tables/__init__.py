"""The contract: what every table holds, checked whenever one is written or read.

Each column is declared once, in `columns`, with its unit, meaning and caveat. Each table lists its
columns and its key. Units and descriptions are in the footer of the Parquet file, beside the schema
version and the provenance.
"""

from oilfilm.tables.columns import COLUMNS, unit_of
from oilfilm.tables.declaration import BY_ROW, LARGEST, UNITS, Column, Table
from oilfilm.tables.store import (
    SCHEMA_VERSION,
    TABLES,
    columns,
    conform,
    declare,
    empty,
    from_rows,
    read,
    read_footer,
    read_run,
    refuse_damaged,
    rows,
    write,
)

__all__ = [
    "BY_ROW",
    "COLUMNS",
    "LARGEST",
    "SCHEMA_VERSION",
    "TABLES",
    "UNITS",
    "Column",
    "Table",
    "columns",
    "conform",
    "declare",
    "empty",
    "from_rows",
    "read",
    "read_footer",
    "read_run",
    "refuse_damaged",
    "rows",
    "unit_of",
    "write",
]
