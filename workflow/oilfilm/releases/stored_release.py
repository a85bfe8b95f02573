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
from oilfilm.atomic_write import atomic_folder
from oilfilm.digests import file_digest, files_below
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.manifest import (
    BESIDE,
    CHECKSUMS,
    CONFIG,
    PINNED_MANIFEST,
    FileRecord,
    Manifest,
    checksums,
    read_manifest,
)
from oilfilm.releases.tree import PINS, copy_file
from oilfilm.settings.yaml_file import read_yaml
from oilfilm.tables import LARGEST_TABLE, UNREADABLE, refuse_unpacking

# What the drift gate and a comparison of settings and verdicts need; no points, for their size.
_KEPT = (
    "config.yaml",
    "tables/claims.parquet",
    "tables/coefficients.parquet",
    "tables/fit_quality.parquet",
    "tables/runs.parquet",
    "tables/torque_runs.parquet",
)
# Bytes of one file that is read into memory, and of a configuration.
_LARGEST_FILE, _LARGEST_CONFIG = 1 << 28, 1 << 20


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

    def changes(self) -> list[str]:
        """A sentence for each file that differs from the manifest, is missing or is extra.

        `SHA256SUMS` must be there and name every file. A folder that has the name of a release must
        have that of this one. For a pin, only the files that it keeps are checked.
        """
        present = set(files_below(self.folder))
        named = [each for path, each in self.files.items() if path in present or not self.pinned]
        wrong = [
            f"{printable(path)}: is extra: the manifest does not name it."
            for path in present - BESIDE - set(self.files)
        ]
        if not self.pinned:
            # what `sha256sum -c` checks, and a signature over it covers
            text = checksums(self.manifest).encode()
            digest = sha256(text).hexdigest()
            named.append(FileRecord(path=CHECKSUMS, sha256=digest, size=len(text)))
            wrong += self._of_another_release()
        return sorted([*filter(None, map(self.mismatch, named)), *wrong])

    def _of_another_release(self) -> list[str]:
        """Why the place of the folder is not that of this release, in a sentence."""
        campaign, version = self.manifest.made_from.campaign, self.manifest.version
        of_releases, of_campaign, name = ("", "", *self.folder.resolve().parts)[-3:]
        stated = (of_campaign if of_releases == "releases" else campaign), name
        if not re.fullmatch(r".+-[0-9a-f]{12}", name) or stated == (campaign, version):
            return []
        return [
            f"{printable('/'.join(stated))}: is the name of another release: the manifest is that "
            f"of {self.name}."
        ]

    def mismatch(self, record: FileRecord) -> str:
        """How a file differs from its record, in a sentence; empty where it does not."""
        path, name = self.folder / record.path, printable(record.path)
        above = path.parents[: record.path.count("/")]
        try:
            status = path.lstat()
            # before anything is opened: a link may lead anywhere, a pipe never ends
            if not stat.S_ISREG(status.st_mode) or any(folder.is_symlink() for folder in above):
                return f"{name}: is not a plain file."
            if status.st_size != record.size:
                return f"{name}: differs: {status.st_size} bytes, {record.size} in the manifest."
            digest = file_digest(path)
        except FileNotFoundError:
            return f"{name}: is missing."
        except OSError as error:
            return f"{name}: cannot be read ({error.strerror})."
        hashes = f"sha256 {digest[:12]}..., {record.sha256[:12]}... in the manifest"
        return "" if digest == record.sha256 else f"{name}: differs: {hashes}."

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
        if complaint := self.mismatch(record):
            raise OilfilmError(f"{self.folder}: {complaint}")
        if path.endswith(".parquet"):
            refuse_unpacking(self.folder / path, LARGEST_TABLE)
        return self.folder / path

    def table(self, name: str) -> pd.DataFrame | None:
        """A table; None where the release has none, or the pin does not keep it.

        Raises:
            OilfilmError: As `file`, or as `tables.read`.
        """
        path = f"tables/{name}.parquet"
        if path not in self.files or (self.pinned and not (self.folder / path).exists()):
            return None
        file = self.file(path)
        try:
            return tables.read(name, file)
        except UNREADABLE as error:
            raise OilfilmError(f"{file}: cannot be read as a table ({error}).") from error

    def config(self) -> dict[str, Any]:
        """The configuration as resolved.

        Raises:
            OilfilmError: As `file`, or it is no YAML.
        """
        path = self.file(CONFIG, _LARGEST_CONFIG)
        try:
            return read_yaml(path).values
        except RecursionError:
            raise OilfilmError(f"{path}: its groups are nested too deeply.") from None


def pin(release: Path, root: Path) -> Path:
    """Keep a release as its campaign's pin, in folder of the one before; the pin's folder.

    Raises:
        OilfilmError: It is no release, is damaged, or is itself a pin.
    """
    stored = StoredRelease.open(release)
    if stored.pinned:
        raise OilfilmError(f"{release}: is a pin already; expected a release.")
    folder = root / PINS / stored.manifest.made_from.campaign
    with atomic_folder(folder) as temporary:
        for path in _KEPT:
            if path in stored.files:
                copy_file(stored.file(path), temporary / path)
        (temporary / PINNED_MANIFEST).write_bytes(stored.manifest.text().encode())
    return folder


def fetch_release(address: str, folder: Path) -> None:
    """Copy a release and check every file; its folder appears when each is as released.

    Args:
        address: Its place, as s3://bucket/releases/june/v1-0123456789ab. Credentials and server
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
            storage, place = fs.FileSystem.from_uri(address.rstrip("/"))
            fs.copy_files(place, str(temporary), storage, fs.LocalFileSystem())
        except (OSError, arrow.ArrowException) as error:
            raise OilfilmError(
                f"{address}: cannot be copied ({printable(error)[:300]}). Check the address, "
                "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_ENDPOINT_URL_S3 and the network, "
                "then try again."
            ) from None
        try:
            complaints = StoredRelease.open(temporary).changes()
        except OilfilmError as fault:
            raise OilfilmError(str(fault).replace(str(temporary), address)) from None
        if complaints:
            raise OilfilmError(f"{address}: is not as it was released: {complaints[0]}")
