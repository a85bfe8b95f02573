"""Raw formats: one module a format, listed here. Adding a format touches its module and this list.

A file's format is recognised by its content, never by its name.
"""

from oilfilm.readers.base import Reader
from oilfilm.readers.csv import CsvReader
from oilfilm.readers.lvm import LvmReader
from oilfilm.readers.parquet import ParquetReader
from oilfilm.readers.pcs import PcsReader
from oilfilm.readers.tdms import TdmsReader

# The first that recognises a file reads it: csv, which takes any text in columns, comes last.
READERS: tuple[Reader, ...] = (
    TdmsReader(),
    ParquetReader(),
    LvmReader(),
    PcsReader(),
    CsvReader(),
)


def find_reader(content: bytes) -> Reader | None:
    """The reader that recognises a file's bytes; None for an unknown format."""
    head = content[:4096]
    return next((reader for reader in READERS if reader.recognises(head)), None)
