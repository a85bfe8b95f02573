"""The formats of raw logs, each read by the module of its name.

A file's format is recognised by its content, never by its name.

Decides: which formats of logs are read.
"""

from collections.abc import Iterable
from typing import Protocol

from oilfilm.logs import csv, lvm, parquet, pcs, tdms
from oilfilm.logs.base import Names, Reading
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.settings.resolved import Settings


class Reader(Protocol):
    """A module that reads one format."""

    def recognises(self, head: bytes) -> bool:
        """True where the first bytes of a file look like this format."""
        ...

    def read(
        self, content: bytes, file: str, settings: Settings, kind: LogKind, sheet: SheetOfLog
    ) -> Reading:
        """Runs and refusals of a file's bytes, read as logs of one kind of rig.

        Runs are named after `file`, which is unique. The rows of the run sheet about the file beat
        its header.

        Raises nothing for a bad file: what cannot be used comes back among the refusals.
        """
        ...

    def names(self, content: bytes) -> Iterable[Names]:
        """What may be the columns of a file, whatever they are called: candidates to choose from.

        Empty where the names are always the same. Raises anything for a bad file.
        """
        ...


# The first that recognises a file reads it: csv, which takes any text in columns, comes last.
READERS: dict[str, Reader] = {"tdms": tdms, "parquet": parquet, "lvm": lvm, "pcs": pcs, "csv": csv}


def recognised_format(content: bytes) -> str | None:
    """The name of the format of a file's bytes; None where no reader recognises them."""
    head = content[:4096]
    return next((name for name, reader in READERS.items() if reader.recognises(head)), None)
