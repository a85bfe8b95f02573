"""The formats of raw logs, each read by the module of its name.

A file's format is recognised by its content, never by its name.

Decides: which formats of logs are read.
"""

from typing import Protocol

from oilfilm.logs import csv, lvm, parquet, pcs, tdms
from oilfilm.logs.columns import Found
from oilfilm.logs.log_kind import Vocabulary


class Reader(Protocol):
    """A module that reads one format."""

    def recognises(self, head: bytes) -> bool:
        """True where the first bytes of a file look like this format."""
        ...

    def tables(self, content: bytes, vocabulary: Vocabulary) -> Found:
        """How the text of a file is written, and its tables: names, units, keys, numbers.

        Raises:
            UnreadableLogError: Nothing of the file can be used.
            Exception: Whatever the library of a binary format stumbles over in a damaged file.
        """
        ...


# The first that recognises a file reads it: csv, which takes any text in columns, comes last.
READERS: dict[str, Reader] = {"tdms": tdms, "parquet": parquet, "lvm": lvm, "pcs": pcs, "csv": csv}
# How files begin that are no logs.
FOREIGN = {
    b"PK\x03\x04": "an Excel workbook or a zip archive: export it as csv, or unpack it",
    b"TDSh": "the index of a tdms log without its data: take the file .tdms beside it",
    b"\x1f\x8b": "a log that was packed twice: unpack it once",
}
# Formats that a library reads: whatever it raises, the file is damaged.
BINARY = frozenset({"tdms", "parquet"})


def recognised_format(content: bytes) -> str | None:
    """The name of the format of a file's bytes; None where no reader recognises them."""
    head = content[:4096]
    if head.startswith(tuple(FOREIGN)):
        return None
    return next((name for name, reader in READERS.items() if reader.recognises(head)), None)
