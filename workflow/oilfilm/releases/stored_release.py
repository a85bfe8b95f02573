"""Read a release or a pin. Every file is checked against its hash before it is read."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.manifest import CONFIG, FileRecord, Manifest, read_manifest
from oilfilm.releases.verify import file_mismatch
from oilfilm.settings.yaml_file import read_yaml
from oilfilm.tables.limits import LARGEST_TABLE, UNREADABLE, refuse_unpacking

# Bytes of one file that is read into memory, of a table once it is unpacked, of a configuration.
_LARGEST_FILE = 1 << 28
_LARGEST_TABLE = LARGEST_TABLE
_LARGEST_CONFIG = 1 << 20


@dataclass(frozen=True)
class StoredRelease:
    """A folder with a manifest. A pin holds a part of the files only."""

    folder: Path
    manifest: Manifest
    pinned: bool

    @classmethod
    def open(cls, folder: Path) -> "StoredRelease":
        """Open a release or a pin.

        Raises:
            OilfilmError: There is no manifest, or it is damaged.
        """
        return cls(folder, *read_manifest(folder))

    @cached_property
    def files(self) -> dict[str, FileRecord]:
        """The files by their paths."""
        return {record.path: record for record in self.manifest.files}

    @property
    def name(self) -> str:
        """Campaign and version, fit to be printed."""
        version = f"{self.manifest.made_from.campaign} {self.manifest.version}"
        return printable(version) + (" (pin)" if self.pinned else "")

    def holds(self, path: str) -> bool:
        """Whether a file can be read: a pin lacks most of those that it names."""
        return path in self.files and (not self.pinned or (self.folder / path).exists())

    def file(self, path: str, largest: int = _LARGEST_FILE) -> Path:
        """Path of a file, after its hash and size are checked.

        Raises:
            OilfilmError: It is missing, is no plain file, differs from the manifest, or unpacks to
                too much.
        """
        record = self.files[path]
        if record.size > largest:
            raise OilfilmError(
                f"{self.folder}: {path} has {record.size} bytes, more than are read ({largest})."
            )
        if complaint := file_mismatch(self.folder, record):
            raise OilfilmError(f"{self.folder}: {complaint}")
        if path.endswith(".parquet"):
            refuse_unpacking(self.folder / path, _LARGEST_TABLE)
        return self.folder / path

    def table(self, name: str) -> pd.DataFrame | None:
        """A table; None where the release has none, or the pin does not keep it.

        Raises:
            OilfilmError: As `file`, or it is no such table, or of another schema version.
        """
        path = f"tables/{name}.parquet"
        if not self.holds(path):
            return None
        version = self.manifest.made_from.schema_version
        if version != tables.SCHEMA_VERSION:
            raise OilfilmError(
                f"{self.folder}: its tables have schema version {version}, and version "
                f"{tables.SCHEMA_VERSION} is read here. "
                "Read it with the code of that release; renew a pin with `oilfilm pin RELEASE`."
            )
        file = self.file(path)
        try:
            return tables.read(name, file)
        except UNREADABLE as error:
            raise OilfilmError(f"{file}: cannot be read as a table ({error}).") from error

    def config(self) -> dict[str, Any] | None:
        """The configuration as resolved; None where the pin does not keep it.

        Raises:
            OilfilmError: As `file`, or it is no YAML.
        """
        if not self.holds(CONFIG):
            return None
        path = self.file(CONFIG, _LARGEST_CONFIG)
        try:
            return read_yaml(path).values
        except RecursionError:
            raise OilfilmError(f"{path}: its groups are nested too deeply.") from None
