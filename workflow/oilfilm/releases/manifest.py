"""The manifest of a release: every file in it, and everything it was made from, by sha256.

A manifest may come from an unknown author: its size is limited, it is checked against its schema,
and no path in it leads out of its folder.

Decides: what makes the version of a release.
"""

import hashlib
import json
import re
from collections.abc import Iterable
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any, Literal

from pydantic import FailFast, Field, SerializerFunctionWrapHandler, model_serializer

from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.logs.raw_files import listing_text
from oilfilm.settings.base import Group, key, optional
from oilfilm.settings.messages import first_mistake

MANIFEST_FILE = "manifest.json"
# The manifest of a pin, which keeps only some of the files that its manifest names.
PINNED_MANIFEST_FILE = "pinned-manifest.json"
CHECKSUMS_FILE = "SHA256SUMS"  # the hashes of a manifest, for `sha256sum -c`
SIGNATURE_FILE = "SHA256SUMS.sig"  # signature of the checksums, by `ssh-keygen`
# Files of a release that its manifest does not name.
UNLISTED_FILE_NAMES = {MANIFEST_FILE, PINNED_MANIFEST_FILE, CHECKSUMS_FILE, SIGNATURE_FILE}
# Files and a folder of every release.
CONFIG_FILE = "config.yaml"
LOCK_FILE = "requirements.lock"
ENVIRONMENT_FILE = "environment.json"
CODE_FOLDER = "code"
# Largest manifest that is read, in bytes: one with a hundred thousand files has about this size.
MOST_BYTES = 1 << 25
# A backslash separates folders on Windows. A line break would begin a line of SHA256SUMS.
_FORBIDDEN_CHARACTERS = {"\\", "\x7f"} | {chr(code) for code in range(32)}
# Largest number of characters that a message quotes from the manifest.
_QUOTED_CHARACTERS_MAX = 500

Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$", description="sha256 in hex.")]
ShortText = Annotated[str, Field(max_length=200)]
# Limit of the number of records in a list of files.
_RECORDS_MAX = Field(max_length=100_000)
# Largest number of keys of one object; an environment has a few hundred packages.
_MOST_KEYS = 10_000
# Largest number of keys of all objects: three lists of records, each record with three keys.
_MOST_KEYS_TOGETHER = 1_000_000


class FileRecord(Group):
    """One file: path below its folder, with `/` between the parts, hash and size in bytes."""

    path: str = key("Below the folder.", min_length=1, max_length=1024)
    sha256: Sha256
    size: int = key("Bytes.", ge=0, le=2**53)

    @classmethod
    def from_file(cls, file: Path, path: str) -> "FileRecord":
        """The record of an existing file.

        Args:
            file: The file.
            path: Its path in the release.
        """
        return cls(path=path, sha256=file_digest(file), size=file.stat().st_size)


class Environment(Group):
    """The environment that a release was made in."""

    python: ShortText = key("Version of Python.", min_length=1)
    platform: ShortText = key("System and processor.", min_length=1)
    c_library: ShortText = key("Name and version; empty where none is known.")
    cpu: str = key("Vector instructions that NumPy uses beyond its least.", max_length=1000)
    blas: Annotated[list[ShortText], Field(min_length=1, max_length=20)] | None = optional(
        "BLAS libraries of NumPy and SciPy: name, version, kernel. Left out where none is known."
    )
    packages: Annotated[
        dict[str, Annotated[ShortText, Field(min_length=1)]], Field(max_length=10000)
    ] = key("Versions of packages.")

    @model_serializer(mode="wrap")
    def _without_unknown(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # an older manifest lacks `blas`: it must give the same text and version as then
        return _without_null(serialize(self))


def _without_null(keys: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in keys.items() if value is not None}


class ReleaseInputs(Group):
    """What a release was made from. The version depends on this only."""

    campaign: Annotated[str, Field(pattern=r"^[^./\\\x00-\x1f][^/\\\x00-\x1f]{0,99}$")] = key(
        "Name of the campaign."
    )
    data: Literal["measured", "simulated"] = key("Whether the data are simulated.")
    tag: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,31}$")] = key(
        "Readable part of the version."
    )
    # of CONFIG_FILE, of all files of code, and of LOCK_FILE (the locked packages)
    config: Sha256
    code: Sha256
    lock: Sha256
    environment: Environment = key("The environment.")
    raw: Annotated[list[FileRecord], _RECORDS_MAX, FailFast()] = key(
        "Raw logs; their paths are from the top folder of the project."
    )
    schema_version: Annotated[int, Field(ge=1, le=10**6)] | None = optional(
        "Version of the tables' columns, in older releases. Now each table says its columns itself."
    )

    @model_serializer(mode="wrap")
    def _without_unknown(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # an older manifest keeps the version that it had when it was made
        return _without_null(serialize(self))

    @property
    def version(self) -> str:
        """Tag and the first 12 hex digits of the hash over what the release was made from."""
        return f"{self.tag}-{_digest_of_content(self.model_dump())[:12]}"


class Manifest(Group):
    """The files of a release and what it was made from: the content of manifest.json."""

    format: Literal[2] = key(
        "Read a release of another format by the code of its time; renew a pin with "
        "`oilfilm pin RELEASE`."
    )
    version: ShortText = key("<tag>-<12 hex digits>", min_length=1)
    made_from: ReleaseInputs = key("What the release was made from.")
    files: Annotated[list[FileRecord], _RECORDS_MAX, FailFast()] = key(
        "Every file of the release but the manifest itself."
    )
    samples: Annotated[list[FileRecord], _RECORDS_MAX, FailFast()] = key(
        "Samples of each oil, which the release leaves out: one hash over all their runs."
    )
    # over the other keys of the manifest
    sha256: Sha256

    @classmethod
    def from_records(
        cls, made_from: ReleaseInputs, files: list[FileRecord], samples: list[FileRecord]
    ) -> "Manifest":
        """The manifest of a release, with its version and the hash over its other keys."""
        content: dict[str, Any] = {
            "format": 2,
            "version": made_from.version,
            "made_from": made_from.model_dump(),
            "files": [record.model_dump() for record in files],
            "samples": [record.model_dump() for record in samples],
        }
        return cls(**content, sha256=_digest_of_content(content))

    def text(self) -> str:
        """The manifest as it is written."""
        return canonical_json(self.model_dump())


def checksums(manifest: Manifest) -> str:
    """The hashes of a release in the form of `sha256sum -c`, that of the manifest first."""
    hashes = {MANIFEST_FILE: text_sha256(manifest.text())}
    hashes |= {record.path: record.sha256 for record in manifest.files}
    return listing_text(hashes)


def canonical_json(content: Any) -> str:
    """JSON that is the same for the same content."""
    return json.dumps(content, indent=2, sort_keys=True, ensure_ascii=False) + "\n"


def text_sha256(text: str) -> str:
    """sha256 of a text in UTF-8, in hex."""
    return hashlib.sha256(text.encode()).hexdigest()


def _digest_of_content(content: Any) -> str:
    """sha256 of a content's canonical JSON."""
    return text_sha256(canonical_json(content))


def records_digest(records: Iterable[FileRecord]) -> str:
    """One hash over several files: their paths, hashes and sizes."""
    by_path = sorted(records, key=lambda record: record.path)
    return _digest_of_content([record.model_dump() for record in by_path])


def read_manifest(folder: Path) -> tuple[Manifest, bool]:
    """The manifest in a folder, and whether the folder is only a pin.

    Raises:
        OilfilmError: There is none, or its text is not that of `Manifest.text`: it is damaged,
            altered, of another format, or has a path that leads out of the folder.
    """
    for name in (MANIFEST_FILE, PINNED_MANIFEST_FILE):
        path = folder / name
        if path.is_file() and not path.is_symlink():
            return _parse(path), name == PINNED_MANIFEST_FILE
    raise OilfilmError(
        f"{folder}: is not a release: it holds no {MANIFEST_FILE}, nor {PINNED_MANIFEST_FILE} as a "
        "pin has. `snakemake release` makes a release in results/releases/<campaign>, and "
        "`oilfilm pin` a pin of it."
    )


def _parse(path: Path) -> Manifest:
    """Read and check a manifest.

    Raises:
        OilfilmError: As in `read_manifest`.
    """
    if path.stat().st_size > MOST_BYTES:
        raise OilfilmError(f"{path}: is larger than {MOST_BYTES} bytes, so it is not a manifest.")
    try:
        text = path.read_bytes().decode("utf-8")
        if text.count('":') > _MOST_KEYS_TOGETHER:
            raise ValueError(f"more than {_MOST_KEYS_TOGETHER} keys")
        # pydantic notes every unknown key: their number is limited before
        content = json.loads(text, object_pairs_hook=_object_of_few_keys)
    except (OSError, ValueError, RecursionError) as error:
        raise OilfilmError(f"{path}: cannot be read as JSON ({error}).") from None
    first_mistake_text = first_mistake(content, Manifest)
    if first_mistake_text:
        # a quoted value may be as long as the file
        raise OilfilmError(f"{path}: {first_mistake_text[:_QUOTED_CHARACTERS_MAX]}")
    stated_manifest = Manifest(**content)
    contradiction = _contradiction(stated_manifest)
    if contradiction:
        raise OilfilmError(f"{path}: {contradiction}")
    manifest = Manifest.from_records(
        stated_manifest.made_from, stated_manifest.files, stated_manifest.samples
    )
    if manifest.text() != text:
        raise OilfilmError(
            f"{path}: is not as it was written: version {stated_manifest.version}, but its content "
            f"gives {manifest.version}. It is damaged or was altered."
        )
    return manifest


def _object_of_few_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON, from its keys and values.

    Raises:
        ValueError: It has more keys than any object of a manifest.
    """
    if len(pairs) > _MOST_KEYS:
        raise ValueError(f"an object has {len(pairs)} keys; expected at most {_MOST_KEYS}")
    return dict(pairs)


def _contradiction(manifest: Manifest) -> str:
    """A sentence on the first entry that no release can have; empty if there is none."""
    made_from = manifest.made_from
    record_by_path = {record.path: record for record in manifest.files}
    for record in (*manifest.files, *manifest.samples, *made_from.raw):
        if not is_inside(record.path):
            return f"names {record.path!r}; expected a path below the folder."
    for record in made_from.raw:
        if not re.match(r"data/raw/[^/]+/.", record.path):
            return f"names the raw log {record.path!r}; expected data/raw/<campaign>/<log>."
    if len(record_by_path) < len(manifest.files) or record_by_path.keys() & UNLISTED_FILE_NAMES:
        return "names a file twice, or itself."
    code_records = []
    for path, record in record_by_path.items():
        if path.startswith(f"{CODE_FOLDER}/"):
            code_records.append(
                record.model_copy(update={"path": path.removeprefix(f"{CODE_FOLDER}/")})
            )
    digest_of_file = {path: record.sha256 for path, record in record_by_path.items()}
    digest_of_file[CODE_FOLDER] = records_digest(code_records)
    stated_digests = {
        CODE_FOLDER: made_from.code,
        CONFIG_FILE: made_from.config,
        LOCK_FILE: made_from.lock,
        ENVIRONMENT_FILE: _digest_of_content(made_from.environment.model_dump()),
    }
    for name, digest in stated_digests.items():
        if digest_of_file.get(name) != digest:
            return f"its {name} does not match the inputs that it states. It was altered."
    return ""


def is_inside(path: str) -> bool:
    """Whether a path of a manifest stays below its folder, on every system.

    Examples:
        >>> [is_inside(path) for path in ("tables/runs.parquet", "../x", "/x", "a//b", "c:x")]
        [True, False, False, False, False]
        >>> is_inside("data/raw/demo/12:30.csv")  # only at the start is it a drive
        True
        >>> is_inside("a" + chr(10) + "b")
        False
    """
    return (
        bool(path)
        and not set(path) & _FORBIDDEN_CHARACTERS
        and not PureWindowsPath(path).drive
        and PurePosixPath(path).as_posix() == path
        and not path.startswith("/")
        and not {"..", "."} & set(path.split("/"))
    )
