"""A release in one file, with all that making it again without a network takes.

The file is a bag (BagIt 1.0, RFC 8493) in a tar archive, compressed with Zstandard: every archive
and library knows these formats, so that `tar` and `sha256sum` open it where oilfilm is not
installed. It holds a project folder: code, settings, measured logs, the release and the packages of
its lock.
"""

import hashlib
import io
import platform
import shutil
import sys
import tarfile
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

import pyarrow as arrow

from oilfilm import home
from oilfilm.atomic_write import atomic_file, atomic_folder
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.manifest import files_below, is_inside
from oilfilm.releases.rebuild import lay_out
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.tree import code_tree_digest
from oilfilm.releases.verify import file_mismatch, verify
from oilfilm.releases.wheels import LOCK_OF_WHEELS, WHEELS, collect_wheels

_PAYLOAD = "data/"
_MANIFEST, _TAG_MANIFEST = "manifest-sha256.txt", "tagmanifest-sha256.txt"
_BAGIT = "BagIt-Version: 1.0\nTag-File-Character-Encoding: UTF-8\n"
# Most files of a bag, and most bytes of those that describe it.
_MOST_FILES, _LARGEST_TAG = 400_000, 1 << 26
_BLOCK = 1 << 20
# What a damaged or foreign archive makes its readers raise.
_UNREADABLE = (tarfile.TarError, arrow.ArrowException, OSError, EOFError, ValueError)
_GUIDE_NAME = "RESTORE.txt"
_GUIDE = """Release {version} of campaign {campaign}, with all that making it again takes.

{about} In this folder:

    python3 -m venv .venv
    .venv/bin/python -m pip install {how}
    PYTHONPATH=workflow PATH="$PWD/.venv/bin:$PATH" python -m oilfilm verify {release} --rebuild
"""


def make_archive(release: Path, root: Path, file: Path, *, packages: bool) -> int:
    """Write a release, its logs, code and packages into one file.

    Args:
        release: Folder of the release.
        root: Top folder of the project, with the measured logs.
        file: The archive to write.
        packages: Whether the packages of the lock are included; they are downloaded.

    Returns:
        Number of files in it.

    Raises:
        OilfilmError: It is a pin, is damaged, was made by other code, a log is missing or has
            changed, the archive is there already, or a package cannot be had.
    """
    if file.exists():
        raise OilfilmError(f"{file}: exists already. Name a new file.")
    # the name of `latest` is that of its version
    stored = StoredRelease.open(release.resolve())
    if complaints := verify(stored.folder):
        raise OilfilmError(f"{release}: is not as it was released: {complaints[0]}")
    if not stored.pinned and stored.manifest.made_from["code"] != code_tree_digest(home.HOME):
        raise OilfilmError(
            f"{release}: was made by other code than is installed here, which could not make it "
            "again. Archive it with the version of oilfilm that made it."
        )
    with tempfile.TemporaryDirectory(prefix="oilfilm-archive-") as temporary:
        aside = Path(temporary)
        lay_out(stored, root, aside / "project")
        files = _below(aside / "project") | _released(stored)
        if packages:
            collect_wheels(home.HOME / "requirements.lock", aside / WHEELS)
            files |= _below(aside / WHEELS, f"{WHEELS}/")
        (aside / _GUIDE_NAME).write_text(_guide(stored, packages=packages), encoding="utf-8")
        files[_GUIDE_NAME] = aside / _GUIDE_NAME
        _write_bag(_name(stored), files, file)
    return len(files)


def restore_archive(file: Path, folder: Path) -> Path:
    """Check every file of an archive and unpack it; the folder of its release.

    Args:
        file: What `make_archive` has written; its author may be unknown.
        folder: A folder that does not exist yet. It appears when all is there and as archived.

    Raises:
        OilfilmError: It is no such archive, is damaged, or has names that lead out of the folder.
    """
    if folder.exists():
        raise OilfilmError(f"{folder}: exists already. Name a new folder.")
    with atomic_folder(folder) as temporary:
        try:
            with _read(file) as archive:
                bag = _unpack(archive, temporary)
        except _UNREADABLE as error:
            fault = printable(error) or type(error).__name__
            raise OilfilmError(f"{file}: cannot be read as an archive ({fault}).") from None
        except _NoBagError as fault:
            raise OilfilmError(f"{file}: {fault}") from None
        if complaint := bag.complaint():
            raise OilfilmError(f"{file}: is not as it was archived: {complaint}")
        releases = sorted(temporary.glob("results/releases/*/*/manifest.json"))
        if not releases:
            raise OilfilmError(f"{file}: has no release in it.")
        release = releases[0].parent
        if complaint := _not_of_release(StoredRelease.open(release), temporary):
            raise OilfilmError(f"{file}: its release is not as it was made: {complaint}")
        return folder / release.relative_to(temporary)


def _not_of_release(stored: StoredRelease, folder: Path) -> str:
    """What does not fit the manifest of a restored release, as a sentence; empty if all does."""
    if complaints := verify(stored.folder):
        return complaints[0]
    if code_tree_digest(folder) != stored.manifest.made_from["code"]:
        return "the code beside it is not the one that made it."
    logs = (record for record in stored.manifest.raw if (folder / record.path).exists())
    return next((text for log in logs if (text := file_mismatch(folder, log))), "")


def _below(folder: Path, place: str = "") -> dict[str, Path]:
    return {place + path: folder / path for path in files_below(folder)}


def _name(stored: StoredRelease) -> str:
    return f"{stored.manifest.made_from['campaign']}-{stored.manifest.version}"


def _released(stored: StoredRelease) -> dict[str, Path]:
    return _below(stored.folder, f"{_place(stored)}/")


def _place(stored: StoredRelease) -> str:
    manifest = stored.manifest
    return f"results/releases/{manifest.made_from['campaign']}/{manifest.version}"


def _guide(stored: StoredRelease, *, packages: bool) -> str:
    here = f"Python {platform.python_version()} on {sys.platform} {platform.machine()}"
    lock = f"--no-index --find-links {WHEELS} --require-hashes -r {WHEELS}/{LOCK_OF_WHEELS}"
    return _GUIDE.format(
        version=stored.manifest.version,
        campaign=stored.manifest.made_from["campaign"],
        about=f"Its packages fit {here}; no network is needed."
        if packages
        else f"It was archived on {here}, without packages: they are downloaded.",
        how=lock if packages else "--require-hashes -r requirements.lock",
        release=_place(stored),
    )


# --------------------------------------------------------------------------------- writing


def _write_bag(name: str, files: Mapping[str, Path], file: Path) -> None:
    digests = {_PAYLOAD + path: file_digest(source) for path, source in sorted(files.items())}
    size = sum(source.stat().st_size for source in files.values())
    tags = {
        "bagit.txt": _BAGIT,
        "bag-info.txt": f"Bag-Software-Agent: oilfilm\nPayload-Oxum: {size}.{len(files)}\n",
        _MANIFEST: _listing(digests),
    }
    tags[_TAG_MANIFEST] = _listing(
        {path: hashlib.sha256(text.encode()).hexdigest() for path, text in tags.items()}
    )
    with (
        atomic_file(file) as aside,
        arrow.CompressedOutputStream(str(aside), "zstd") as packed,
        tarfile.open(
            fileobj=cast("IO[bytes]", packed), mode="w|", format=tarfile.PAX_FORMAT
        ) as tar,
    ):
        for path, text in tags.items():
            content = text.encode()
            tar.addfile(_member(f"{name}/{path}", len(content)), io.BytesIO(content))
        for path, source in sorted(files.items()):
            with source.open("rb") as opened:
                tar.addfile(_member(f"{name}/{_PAYLOAD}{path}", source.stat().st_size), opened)
            if file_digest(source) != digests[_PAYLOAD + path]:
                raise OilfilmError(f"{source}: has changed while it was archived. Try again.")


def _member(path: str, size: int) -> tarfile.TarInfo:
    """A file without owner and date: the same release gives the same archive."""
    member = tarfile.TarInfo(path)
    member.size, member.mode = size, 0o644
    return member


def _listing(digests: Mapping[str, str]) -> str:
    # RFC 8493, section 2.1.3
    return "".join(
        f"{digest}  {path.replace('%', '%25')}\n" for path, digest in sorted(digests.items())
    )


# --------------------------------------------------------------------------------- reading


class _NoBagError(Exception):
    """What an archive of `make_archive` would not have."""


@dataclass(frozen=True)
class _Bag:
    """What was read: the hash of each file, and the texts of those that describe the bag."""

    digests: Mapping[str, str]
    tags: Mapping[str, bytes]

    def complaint(self) -> str:
        """The first file that differs from the bag's own listings, as a sentence; empty if none."""
        for listing in (_TAG_MANIFEST, _MANIFEST):
            if listing not in self.tags:
                return f"{listing} is missing."
            expected = _listed(self.tags[listing])
            held = {
                path
                for path in self.digests
                if path.startswith(_PAYLOAD) == (listing == _MANIFEST) and path != _TAG_MANIFEST
            }
            for path in sorted(expected.keys() | held):
                if expected.get(path) != self.digests.get(path):
                    state = (
                        "is missing"
                        if path not in held
                        else "is not named in it"
                        if path not in expected
                        else "differs"
                    )
                    return f"{printable(path)} {state} ({listing})."
        return ""


def _listed(content: bytes) -> dict[str, str]:
    lines = content.decode("utf-8", errors="replace").splitlines()
    parts = [line.partition("  ") for line in lines]
    return {path.replace("%25", "%"): digest for digest, _, path in parts}


@contextmanager
def _read(file: Path) -> Iterator[tarfile.TarFile]:
    with (
        arrow.CompressedInputStream(str(file), "zstd") as unpacked,
        tarfile.open(fileobj=cast("IO[bytes]", unpacked), mode="r|") as archive,
    ):
        yield archive


def _unpack(archive: tarfile.TarFile, folder: Path) -> _Bag:
    """Write the payload below a folder, member by member; only plain files are taken."""
    room = shutil.disk_usage(folder).free
    digests: dict[str, str] = {}
    tags: dict[str, bytes] = {}
    for member in archive:
        if member.isdir():
            continue
        path = member.name.partition("/")[2]
        said = printable(member.name)[:200]
        source = archive.extractfile(member) if member.isreg() else None
        if source is None:
            raise _NoBagError(f"{said} is not a plain file.")
        if not is_inside(path) or path in digests:
            raise _NoBagError(f"{said} is not a path below its folder, or occurs twice.")
        room -= member.size
        if len(digests) == _MOST_FILES or room < 0:
            raise _NoBagError(f"{said} is one file too many, or too large for this disk.")
        if path.startswith(_PAYLOAD):
            digests[path] = _copy(source, folder / path.removeprefix(_PAYLOAD))
            continue
        if member.size > _LARGEST_TAG:
            raise _NoBagError(f"{said} is too large for a description of the archive.")
        tags[path] = source.read()
        digests[path] = hashlib.sha256(tags[path]).hexdigest()
    return _Bag(digests, tags)


def _copy(source: IO[bytes], target: Path) -> str:
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("xb") as file:
        shutil.copyfileobj(source, file, _BLOCK)
    return file_digest(target)
