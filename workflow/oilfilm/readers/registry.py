"""Raw formats: one module per format. Adding one touches its module and the list here.

A file's format is recognised by its content, never by its name.
"""

from typing import Protocol

from oilfilm.readers.base import Reading
from oilfilm.readers.csv import CsvReader
from oilfilm.readers.log_kind import LogKind
from oilfilm.readers.lvm import LvmReader
from oilfilm.readers.parquet import ParquetReader
from oilfilm.readers.pcs import PcsReader
from oilfilm.readers.tdms import TdmsReader
from oilfilm.settings.resolved import Settings


class Reader(Protocol):
    """A raw format. It knows its format and nothing else."""

    name: str

    def recognises(self, head: bytes) -> bool:
        """True where the first bytes of a file look like this format."""
        ...

    def read(self, content: bytes, file: str, settings: Settings, kind: LogKind) -> Reading:
        """Runs and refusals of a file's bytes, read as logs of one kind of rig.

        Runs are named after `file`, which is unique.

        Raises nothing for a bad file: what cannot be used comes back among the refusals.
        """
        ...


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
