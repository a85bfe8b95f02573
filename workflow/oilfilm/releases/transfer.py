"""Copy releases to object storage and back. The manifest goes last and comes first.

Without its manifest a folder is no release: of a copy that broke off nothing can be read, and the
next one completes it.
"""

from pathlib import Path

from oilfilm import object_storage
from oilfilm.atomic_write import atomic_folder, write_bytes
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
        if object_storage.content(f"{address}/{MANIFEST}") == (folder / MANIFEST).read_bytes():
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
        raise OilfilmError(f"{folder}: is there already. Name a new folder.")
    with atomic_folder(folder) as temporary:
        content = object_storage.content(f"{address}/{MANIFEST}", largest=LARGEST)
        write_bytes(content, temporary / MANIFEST)
        manifest, _ = read_manifest(temporary)
        for name in {CHECKSUMS, SIGNATURE} & set(object_storage.listing(address)):
            content = object_storage.content(f"{address}/{name}", largest=LARGEST)
            write_bytes(content, temporary / name)
        for record in manifest.files:
            content = object_storage.content(f"{address}/{record.path}", largest=record.size)
            write_bytes(content, temporary / record.path)
        if complaints := verify(temporary):
            raise OilfilmError(f"{address}: is not as it was released: {complaints[0]}")
