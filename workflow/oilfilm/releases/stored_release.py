"""Read, check and copy a release or a pin. A file is checked against its hash before it is read.

A pin is the small part of a release that a repository keeps.

Decides: when a release counts as unchanged; what a pin keeps of a release.
"""

import re
import stat
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as arrow
from pyarrow import fs

from oilfilm import tables
from oilfilm.base.atomic_write import atomic_folder
from oilfilm.base.digests import file_digest, files_below
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.releases.code_tree import PINS, copy_file
from oilfilm.releases.manifest import (
    CHECKSUMS_FILE,
    CONFIG_FILE,
    PINNED_MANIFEST_FILE,
    UNLISTED_FILE_NAMES,
    FileRecord,
    Manifest,
    checksums,
    is_inside,
    read_manifest,
)
from oilfilm.settings.yaml_file import read_yaml
from oilfilm.tables import MOST_BYTES_UNPACKED, READ_ERRORS, refuse_oversized

# Files that a pin keeps for the drift gate: those with the statements of a release. The table of
# points is too large.
_PINNED_FILES = (
    "config.yaml",
    "summary.txt",
    "tables/advice_band.parquet",
    "tables/claims.parquet",
    "tables/coefficients.parquet",
    "tables/fit_quality.parquet",
    "tables/law_verdicts.parquet",
    "tables/runs.parquet",
    "tables/sign_verdicts.parquet",
    "tables/slip_advice.parquet",
    "tables/soundness.parquet",
    "tables/surfaces.parquet",
    "tables/torque_runs.parquet",
)
_MOST_BYTES = 1 << 28  # of a file that is read into memory
_MOST_CONFIG_BYTES = 1 << 20


@dataclass(frozen=True)
class StoredRelease:
    """A folder with a manifest.

    Attributes:
        folder: The folder.
        manifest: Its manifest.
        is_pin: Whether it is a pin, which keeps only some of the files.
    """

    folder: Path
    manifest: Manifest
    is_pin: bool

    @classmethod
    def open(cls, folder: Path) -> "StoredRelease":
        """Open a release or a pin.

        Raises:
            OilfilmError: There is no manifest, or it is damaged.
        """
        manifest, is_pin = read_manifest(folder)
        return cls(folder, manifest, is_pin)

    @cached_property
    def record_by_path(self) -> dict[str, FileRecord]:
        """The record of each file that the manifest names, by its path."""
        return {record.path: record for record in self.manifest.files}

    @property
    def name(self) -> str:
        """Campaign and version, safe to print."""
        name = printable(f"{self.manifest.made_from.campaign} {self.manifest.version}")
        return f"{name} (pin)" if self.is_pin else name

    def find_changes(self) -> list[str]:
        """A sentence for each file that differs from the manifest, is missing or is extra.

        `SHA256SUMS` must be there and name every file. A folder with the name of a release must
        have the name of this one. A pin must hold the files that each pin keeps; of the others,
        those that are there are checked.
        """
        files_present = set(files_below(self.folder))
        sentences = [
            f"{printable(path)}: is extra: the manifest does not name it."
            for path in files_present - UNLISTED_FILE_NAMES - self.record_by_path.keys()
        ]
        if self.is_pin:
            expected_records = [
                record
                for path, record in self.record_by_path.items()
                if path in files_present or path in _PINNED_FILES
            ]
        else:
            # the file that `sha256sum -c` reads and that a signature covers
            checksums_text = checksums(self.manifest).encode()
            digest = sha256(checksums_text).hexdigest()
            checksums_record = FileRecord(
                path=CHECKSUMS_FILE, sha256=digest, size=len(checksums_text)
            )
            expected_records = [*self.record_by_path.values(), checksums_record]
            sentences.append(self._wrong_folder_name())
        sentences += [self.describe_mismatch(record) for record in expected_records]
        return sorted(filter(None, sentences))

    def _wrong_folder_name(self) -> str:
        """A sentence if the folder has the name of another release; empty if not."""
        campaign = self.manifest.made_from.campaign
        path = self.folder.resolve()
        if not re.fullmatch(r".+-[0-9a-f]{12}", path.name):
            return ""
        folder_campaign = campaign
        if path.parent.parent.name == "releases":
            folder_campaign = path.parent.name
        if (folder_campaign, path.name) == (campaign, self.manifest.version):
            return ""
        folder_name = printable(f"{folder_campaign}/{path.name}")
        return (
            f"{folder_name}: is the name of another release: the manifest is that of {self.name}."
        )

    def describe_mismatch(self, record: FileRecord) -> str:
        """A sentence on how a file differs from its record; empty if it does not."""
        path = self.folder / record.path
        name = printable(record.path)
        folders_on_the_way = path.parents[: record.path.count("/")]
        try:
            status = path.lstat()
            # checked before anything is opened: a link may lead anywhere, a pipe may never end
            is_behind_link = any(folder.is_symlink() for folder in folders_on_the_way)
            if is_behind_link or not stat.S_ISREG(status.st_mode):
                return f"{name}: is not a plain file."
            if status.st_size != record.size:
                return f"{name}: differs: {status.st_size} bytes, {record.size} in the manifest."
            digest = file_digest(path)
        except FileNotFoundError:
            return f"{name}: is missing."
        except OSError as error:
            return f"{name}: cannot be read ({error.strerror})."
        if digest == record.sha256:
            return ""
        hashes = f"sha256 {digest[:12]}..., {record.sha256[:12]}... in the manifest"
        return f"{name}: differs: {hashes}."

    def checked_file(self, path: str, most_bytes: int = _MOST_BYTES) -> Path:
        """Path of a file, after its hash and size are checked.

        Raises:
            OilfilmError: It is missing, is no plain file, differs from the manifest, or is too
                large, packed or unpacked.
        """
        record = self.record_by_path[path]
        if record.size > most_bytes:
            raise OilfilmError(
                f"{self.folder}: {path} has {record.size} bytes, more than are read ({most_bytes})."
            )
        mismatch = self.describe_mismatch(record)
        if mismatch:
            raise OilfilmError(f"{self.folder}: {mismatch}")
        if path.endswith(".parquet"):
            refuse_oversized(self.folder / path, MOST_BYTES_UNPACKED)
        return self.folder / path

    def read_table(self, name: str) -> pd.DataFrame | None:
        """A table; None where the release has none, or the pin does not keep it.

        It has the columns that are both declared in this version and in the file.

        Raises:
            OilfilmError: As in `checked_file`, or as in `tables.read_of_any_version`.
        """
        file = self._table_file(name)
        if file is None:
            return None
        try:
            return tables.read_of_any_version(name, file)
        except READ_ERRORS as error:
            raise OilfilmError(f"{file}: cannot be read as a table ({error}).") from error

    def column_names(self, table_name: str) -> list[str] | None:
        """Names of the columns of a table; None as for `read_table`.

        Raises:
            OilfilmError: As in `checked_file`, or the file is damaged.
        """
        file = self._table_file(table_name)
        return None if file is None else tables.column_names_of(file)

    def _table_file(self, name: str) -> Path | None:
        """The checked file of a table; None as for `read_table`."""
        path = f"tables/{name}.parquet"
        return self.checked_file(path) if self._holds(path) else None

    def _holds(self, path: str) -> bool:
        """Whether the folder must hold a file: the release has it, and a pin keeps such files."""
        return path in self.record_by_path and (not self.is_pin or path in _PINNED_FILES)

    def read_lines(self, path: str) -> list[str] | None:
        """The lines of a text; None where the release has none, or the pin does not keep it.

        Raises:
            OilfilmError: As in `checked_file`, or it is no text.
        """
        if not self._holds(path):
            return None
        file = self.checked_file(path)
        try:
            return file.read_text(encoding="utf-8").split("\n")
        except UnicodeDecodeError:
            raise OilfilmError(f"{file}: is no text in UTF-8.") from None

    def read_config(self) -> dict[str, Any]:
        """All settings of the run, as plain values.

        Raises:
            OilfilmError: As in `checked_file`, or it is no YAML.
        """
        path = self.checked_file(CONFIG_FILE, _MOST_CONFIG_BYTES)
        try:
            return read_yaml(path).values
        except RecursionError:
            raise OilfilmError(f"{path}: its groups are nested too deeply.") from None


def pin(release: Path, root: Path) -> Path:
    """Keep a release as the pin of its campaign; it replaces an earlier pin.

    Args:
        release: Folder of the release.
        root: Top folder of the project.

    Returns:
        Folder of the pin.

    Raises:
        OilfilmError: It is no release, is damaged, or is itself a pin.
    """
    stored = StoredRelease.open(release)
    if stored.is_pin:
        raise OilfilmError(f"{release}: is a pin already; expected a release.")
    folder = root / PINS / stored.manifest.made_from.campaign
    with atomic_folder(folder) as temporary:
        for path in _PINNED_FILES:
            if path in stored.record_by_path:
                copy_file(stored.checked_file(path), temporary / path)
        (temporary / PINNED_MANIFEST_FILE).write_bytes(stored.manifest.text().encode())
    return folder


def fetch_release(address: str, folder: Path) -> None:
    """Copy a release and check every file; its folder appears when all files are as released.

    Args:
        address: Its address, as s3://bucket/releases/june/v1-0123456789ab. Credentials and server
            come from the environment, as for every S3 client.
        folder: A folder that does not exist yet.

    Raises:
        OilfilmError: The storage fails, it is no release, or a file is not as it was released.
    """
    if folder.exists():
        raise OilfilmError(f"{folder}: exists already. Name a new folder.")
    if not address.startswith("s3://") or "@" in address or "?" in address:
        # not quoted: it may hold a key
        raise OilfilmError(
            "The address of the release: expected s3://BUCKET/PLACE, without a key or a server. "
            "They are read from AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_ENDPOINT_URL_S3."
        )
    with atomic_folder(folder) as temporary:
        try:
            _copy_from_storage(address, temporary)
        except (OSError, arrow.ArrowException) as error:
            raise OilfilmError(
                f"{address}: cannot be copied ({printable(error)[:300]}). Check the address, "
                "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_ENDPOINT_URL_S3 and the network, "
                "then try again."
            ) from None
        try:
            changes = StoredRelease.open(temporary).find_changes()
        except OilfilmError as error:
            raise OilfilmError(str(error).replace(str(temporary), address)) from None
        if changes:
            raise OilfilmError(f"{address}: is not as it was released: {changes[0]}")


def _copy_from_storage(address: str, folder: Path) -> None:
    """Copy all files below an address of a storage into a folder, and no file beside it.

    Raises:
        OilfilmError: A path of the storage leads out of the folder.
        OSError, arrow.ArrowException: The storage fails.
    """
    storage, place = fs.FileSystem.from_uri(address.rstrip("/"))
    files = storage.get_file_info(fs.FileSelector(place, recursive=True))
    paths = [file.path.removeprefix(f"{place}/") for file in files if file.is_file]
    for path in paths:
        if not is_inside(path):
            raise OilfilmError(
                f"{address}: found the path {printable(path)!r}, which leads out of the release; "
                "expected paths below it. It was altered: fetch a release from another place."
            )
    # one by one: a second listing of the storage could have other paths
    for path in paths:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        fs.copy_files(f"{place}/{path}", str(folder / path), storage, fs.LocalFileSystem())
