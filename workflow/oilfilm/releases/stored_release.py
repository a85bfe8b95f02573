"""Read a release or a pin. Every file is checked against its hash before it is read."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as arrow
import pyarrow.compute as compute
import pyarrow.parquet as parquet

from oilfilm import tables
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.manifest import CONFIG, FileRecord, Manifest, read_manifest
from oilfilm.releases.verify import file_mismatch
from oilfilm.settings.yaml_file import read_yaml

# Bytes of one file that is read into memory, of a table once it is unpacked, of a configuration.
_LARGEST_FILE = 1 << 28
_LARGEST_TABLE = 1 << 30
_LARGEST_CONFIG = 1 << 20
# Types of at most 8 bytes a value.
_PLAIN = {"BOOLEAN", "INT32", "INT64", "FLOAT", "DOUBLE"}
# Errors of Arrow for a file that is not Parquet or is damaged.
_UNREADABLE = (arrow.ArrowException, OSError, ValueError, RecursionError)


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
        version = f"{self.manifest.made_from['campaign']} {self.manifest.version}"
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
            _refuse_unpacking(self.folder / path)
        return self.folder / path

    def table(self, name: str) -> pd.DataFrame | None:
        """A table; None where the release has none, or the pin does not keep it.

        Raises:
            OilfilmError: As `file`, or it is no such table, or of another schema version.
        """
        path = f"tables/{name}.parquet"
        if not self.holds(path):
            return None
        version = self.manifest.made_from["schema_version"]
        if version != tables.SCHEMA_VERSION:
            raise OilfilmError(
                f"{self.folder}: its tables have schema version {version}, and version "
                f"{tables.SCHEMA_VERSION} is read here. "
                "Read it with the code of that release; renew a pin with `oilfilm pin RELEASE`."
            )
        file = self.file(path)
        try:
            return tables.read(name, file)
        except _UNREADABLE as error:
            raise OilfilmError(f"{file}: is no table that can be read ({error}).") from error

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


def _refuse_unpacking(file: Path) -> None:
    """Refuse a small file that unpacks to more than memory can hold (one value, repeated)."""
    try:
        size = _size_unpacked(file)
    except _UNREADABLE as error:
        raise OilfilmError(f"{file}: is no table that can be read ({error}).") from error
    if size > _LARGEST_TABLE:
        raise OilfilmError(
            f"{file}: unpacks to {size} bytes, more than are read ({_LARGEST_TABLE})."
        )


def _size_unpacked(file: Path) -> int:
    """Bytes of a Parquet file's values in memory, or a size too large on the way to them."""
    metadata = parquet.read_metadata(file)
    if any(arrow.types.is_nested(kind) for kind in metadata.schema.to_arrow_schema().types):
        raise ValueError("its columns hold lists, which no table here does")
    groups = [metadata.row_group(group) for group in range(metadata.num_row_groups)]
    chunks = [group.column(index) for group in groups for index in range(group.num_columns)]
    if unknown := {chunk.physical_type for chunk in chunks} - {*_PLAIN, "BYTE_ARRAY"}:
        raise ValueError(f"its columns hold {min(unknown)}, which no table here does")
    size = sum(max(chunk.total_uncompressed_size, 8 * chunk.num_values) for chunk in chunks)
    # Only here a value has a length of its own. Read as a dictionary it lies in memory once.
    text = sorted({c.path_in_schema for c in chunks if c.physical_type == "BYTE_ARRAY"})
    if size > _LARGEST_TABLE or not text:
        return size
    for batch in parquet.ParquetFile(file, read_dictionary=text).iter_batches(columns=text):
        for column in batch.columns:
            if isinstance(column, arrow.DictionaryArray):
                lengths = compute.binary_length(column.dictionary.cast(arrow.large_binary()))
                size += compute.sum(lengths.take(column.indices)).as_py() or 0
            else:
                size += column.nbytes
    return size
