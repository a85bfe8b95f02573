"""The contract: what every table holds, checked whenever one is written or read.

Each column is declared once, in a YAML file, with its unit, meaning and caveat. Each table lists
its columns and its key. Units and descriptions are in the footer of the Parquet file, beside the
schema version and the provenance.
"""

from oilfilm.tables.declaration import BY_ROW as BY_ROW
from oilfilm.tables.declaration import LARGEST as LARGEST
from oilfilm.tables.declaration import UNITS as UNITS
from oilfilm.tables.declaration import Column as Column
from oilfilm.tables.declaration import Table as Table
from oilfilm.tables.dictionary import COLUMNS as COLUMNS
from oilfilm.tables.dictionary import TABLES as TABLES
from oilfilm.tables.dictionary import unit_of as unit_of
from oilfilm.tables.schema_version import SCHEMA_VERSION as SCHEMA_VERSION
from oilfilm.tables.store import ROW_GROUP as ROW_GROUP
from oilfilm.tables.store import columns as columns
from oilfilm.tables.store import conform as conform
from oilfilm.tables.store import empty as empty
from oilfilm.tables.store import filled as filled
from oilfilm.tables.store import from_rows as from_rows
from oilfilm.tables.store import read as read
from oilfilm.tables.store import read_footer as read_footer
from oilfilm.tables.store import read_parts as read_parts
from oilfilm.tables.store import read_run as read_run
from oilfilm.tables.store import rows as rows
from oilfilm.tables.store import write as write
from oilfilm.tables.store import writing as writing
