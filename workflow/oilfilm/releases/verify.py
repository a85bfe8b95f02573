"""Check every file of a release against the hashes of its manifest.

Decides: when a release counts as unchanged.
"""

import stat
from hashlib import sha256
from pathlib import Path

from oilfilm.digests import file_digest
from oilfilm.errors import printable
from oilfilm.releases.manifest import (
    CHECKSUMS,
    MANIFEST,
    PINNED_MANIFEST,
    SIGNATURE,
    FileRecord,
    Manifest,
    checksums,
    files_below,
    read_manifest,
)


def verify(folder: Path) -> list[str]:
    """A sentence for each file that differs from the manifest, is missing or is extra.

    For a pin, only the files that it keeps are checked.

    Raises:
        OilfilmError: The manifest is missing, damaged or altered.
    """
    manifest, pinned = read_manifest(folder)
    expected = {record.path: record for record in manifest.files}
    beside = {PINNED_MANIFEST} if pinned else {MANIFEST, CHECKSUMS, SIGNATURE}
    present = set(files_below(folder)) - beside
    complaints = [
        complaint
        for path, record in expected.items()
        if path in present or not pinned
        if (complaint := file_mismatch(folder, record))
    ]
    extra = [
        f"{printable(path)}: is extra: the manifest does not name it."
        for path in present - set(expected)
    ]
    return sorted([*complaints, *extra, *_wrong_checksums(folder, manifest)])


def _wrong_checksums(folder: Path, manifest: Manifest) -> list[str]:
    """Why `sha256sum -c` would check something else; an old release has no such file."""
    path = folder / CHECKSUMS
    if not path.exists() and not path.is_symlink():
        return []
    text = checksums(manifest).encode()
    expected = FileRecord(path=CHECKSUMS, sha256=sha256(text).hexdigest(), size=len(text))
    return [complaint] if (complaint := file_mismatch(folder, expected)) else []


def file_mismatch(folder: Path, record: FileRecord) -> str:
    """How a file differs from its record, in a sentence; empty where it does not."""
    path = folder / record.path
    try:
        status = path.lstat()
    except OSError:
        return f"{printable(record.path)}: is missing."
    # before anything is opened: a link may lead anywhere, a pipe never ends
    if not stat.S_ISREG(status.st_mode) or _crosses_link(folder, record.path):
        return f"{printable(record.path)}: is not a plain file."
    if status.st_size != record.size:
        sizes = f"{status.st_size} bytes, {record.size} in the manifest"
        return f"{printable(record.path)}: differs: {sizes}."
    try:
        digest = file_digest(path)
    except OSError as error:
        return f"{printable(record.path)}: cannot be read ({error.strerror})."
    if digest != record.sha256:
        hashes = f"sha256 {digest[:12]}..., {record.sha256[:12]}... in the manifest"
        return f"{printable(record.path)}: differs: {hashes}."
    return ""


def _crosses_link(folder: Path, path: str) -> bool:
    """Whether a folder on the way to a file is a link."""
    parts = path.split("/")[:-1]
    return any(folder.joinpath(*parts[:depth]).is_symlink() for depth in range(1, len(parts) + 1))
