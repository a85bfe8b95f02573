"""Is a release still what it was: every file hashed again."""

import stat
from pathlib import Path

from oilfilm.digests import file_digest
from oilfilm.releases.manifest import (
    MANIFEST,
    PINNED_MANIFEST,
    FileRecord,
    files_below,
    read_manifest,
    shown,
)


def verify(folder: Path) -> list[str]:
    """A sentence for each file that differs from the manifest, is missing or is extra.

    Of a pin only the files that it keeps are asked for.

    Raises:
        OilfilmError: The manifest is missing, damaged or altered.
    """
    manifest, pinned = read_manifest(folder)
    wanted = {record.path: record for record in manifest.files}
    there = set(files_below(folder)) - {PINNED_MANIFEST if pinned else MANIFEST}
    complaints = [
        complaint
        for path, record in wanted.items()
        if path in there or not pinned
        if (complaint := complaint_about(folder, record))
    ]
    extra = [
        f"{shown(path)}: is extra: the manifest does not name it." for path in there - set(wanted)
    ]
    return sorted([*complaints, *extra])


def complaint_about(folder: Path, record: FileRecord) -> str:
    """How a file differs from its record, in a sentence; empty where it does not."""
    path = folder / record.path
    try:
        found = path.lstat()
    except OSError:
        return f"{shown(record.path)}: is missing."
    # before anything is opened: a link may lead anywhere, a pipe never ends
    if not stat.S_ISREG(found.st_mode) or _crosses_link(folder, record.path):
        return f"{shown(record.path)}: is no plain file."
    if found.st_size != record.size:
        return (
            f"{shown(record.path)}: differs: {found.st_size} bytes, {record.size} in the manifest."
        )
    try:
        digest = file_digest(path)
    except OSError as error:
        return f"{shown(record.path)}: cannot be read ({error.strerror})."
    if digest != record.sha256:
        return (
            f"{shown(record.path)}: differs: sha256 {digest[:12]}..., {record.sha256[:12]}... in "
            "the manifest."
        )
    return ""


def _crosses_link(folder: Path, path: str) -> bool:
    """Whether a folder on the way to a file is a link."""
    parts = path.split("/")[:-1]
    return any(folder.joinpath(*parts[:depth]).is_symlink() for depth in range(1, len(parts) + 1))
