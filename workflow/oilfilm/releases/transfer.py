"""Copy releases to object storage and back. The manifest goes last and comes first.

Without its manifest a folder is no release: of a copy that broke off nothing can be read, and the
next one completes it.
"""

import shutil
from contextlib import suppress
from pathlib import Path

from oilfilm import object_storage
from oilfilm.atomic_write import atomic_folder
from oilfilm.errors import OilfilmError
from oilfilm.releases.manifest import (
    CHECKSUMS,
    LARGEST,
    MANIFEST,
    SIGNATURE,
    files_below,
    read_manifest,
)
from oilfilm.releases.verify import verify


def upload_release(folder: Path, address: str) -> bool:
    """Copy a release to a place in object storage; whether it was not there yet.

    Args:
        folder: Folder of the release.
        address: Its place, as s3://bucket/releases/june/v1-0123456789ab.

    Raises:
        OilfilmError: The storage fails, or another release is there.
    """
    present = object_storage.listing(address)
    if MANIFEST in present:
        there = object_storage.content(f"{address}/{MANIFEST}", largest=LARGEST)
        if there == (folder / MANIFEST).read_bytes():
            if (folder / SIGNATURE).is_file() and SIGNATURE not in present:  # signed since
                object_storage.upload(folder / SIGNATURE, f"{address}/{SIGNATURE}")
            return False
        raise OilfilmError(
            f"{address}: has another release than {folder}, and a release never changes. Move it "
            "away, or choose another place (`storage.releases`)."
        )
    files = files_below(folder)
    for path in sorted(files, key=lambda path: (path == MANIFEST, path)):
        object_storage.upload(folder / path, f"{address}/{path}")
    return True


def download_release(address: str, folder: Path) -> None:
    """Copy a release from object storage and check every file of it.

    Args:
        address: Its place.
        folder: A folder that does not exist yet.

    Raises:
        OilfilmError: The storage fails, it is no release, or a file is not as it was released.
    """
    if folder.exists():
        raise OilfilmError(f"{folder}: exists already. Name a new folder.")
    with atomic_folder(folder) as temporary:
        copy_release(address, temporary)
        if complaints := verify(temporary):
            raise OilfilmError(f"{address}: is not as it was released: {complaints[0]}")


def copy_release(address: str, folder: Path) -> None:
    """Copy what the manifest of a release names, unchecked, file by file to an empty folder.

    Raises:
        OilfilmError: The storage fails, it is no release, a file is missing or larger than the
            manifest says, or the disk has no room for it.
    """
    object_storage.download(f"{address}/{MANIFEST}", folder / MANIFEST, LARGEST)
    try:
        manifest, _ = read_manifest(folder)
    except OilfilmError as fault:
        raise OilfilmError(str(fault).replace(str(folder), address)) from None
    needed, free = sum(record.size for record in manifest.files), shutil.disk_usage(folder).free
    if needed > free:
        raise OilfilmError(
            f"{address}: needs {needed} bytes, and the disk of {folder.parent} has {free} free. "
            "Make room, or choose a folder on another disk."
        )
    for record in manifest.files:
        object_storage.download(f"{address}/{record.path}", folder / record.path, record.size)
    for name in (CHECKSUMS, SIGNATURE):
        with suppress(object_storage.MissingObjectError):  # an old or unsigned release
            object_storage.download(f"{address}/{name}", folder / name, LARGEST)
