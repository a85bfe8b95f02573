"""The contract: what every table holds, checked whenever one is written or read.

One pandera model stands for one table, in the module of its room. A column's unit is the end of
its name (`load_n`, `entrainment_speed_m_s`), its meaning is its description, and both travel in
the Parquet file, beside the schema version and the provenance.
"""

from oilfilm.tables.fields import LARGEST, unit_of
from oilfilm.tables.store import (
    SCHEMA_VERSION,
    TABLES,
    columns,
    conform,
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
    "LARGEST",
    "SCHEMA_VERSION",
    "TABLES",
    "columns",
    "conform",
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
