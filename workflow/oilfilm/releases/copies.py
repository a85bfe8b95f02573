"""Copies of releases: from object storage, and the small part that a repository keeps (a pin).

Decides: what a pin keeps of a release.
"""

from pathlib import Path

import pyarrow as arrow
from pyarrow import fs

from oilfilm.atomic_write import atomic_folder
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.manifest import PINNED_MANIFEST
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.tree import PINS, copy_file

# What the drift gate and a comparison of settings and verdicts need; no points, for their size.
_KEPT = (
    "config.yaml",
    "tables/claims.parquet",
    "tables/coefficients.parquet",
    "tables/fit_quality.parquet",
    "tables/runs.parquet",
    "tables/torque_runs.parquet",
)


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
