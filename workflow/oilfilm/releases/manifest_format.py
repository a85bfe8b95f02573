"""What a manifest.json must look like. It may come from a stranger, hence the bounds."""

from typing import Annotated, Literal

from pydantic import Field

from oilfilm.settings.base import Group, key

Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$", description="sha256 in hex.")]
ShortText = Annotated[str, Field(max_length=200)]
FileName = Annotated[str, Field(min_length=1, max_length=1024)]


class Record(Group):
    """A file: its path, hash and size."""

    path: FileName = key("Below the folder.")
    sha256: Sha256
    size: int = key("Bytes.", ge=0, le=2**53)


class RawRecord(Record):
    """A raw log."""

    path: Annotated[FileName, Field(pattern=r"^data/raw/[^/]+/.")] = key("From the top folder.")


class Environment(Group):
    """The environment that a release was made in."""

    python: ShortText = key("Version of Python.", min_length=1)
    platform: ShortText = key("System and processor.", min_length=1)
    c_library: ShortText = key("Name and version; empty where none is known.")
    cpu: str = key("Vector instructions that NumPy has found.", max_length=1000)
    packages: Annotated[
        dict[str, Annotated[ShortText, Field(min_length=1)]], Field(max_length=10000)
    ] = key("Versions of packages.")


class MadeFrom(Group):
    """What a release was made from."""

    campaign: Annotated[str, Field(pattern=r"^[^./\\\x00-\x1f][^/\\\x00-\x1f]{0,99}$")] = key(
        "Name of the campaign."
    )
    data: Literal["measured", "simulated"] = key("Whether the data are simulated.")
    tag: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,31}$")] = key(
        "Readable part of the version."
    )
    schema_version: int = key("Version of the tables' schema.", ge=1, le=1_000_000)
    config: Sha256
    code: Sha256
    lock: Sha256
    environment: Environment = key("The environment.")
    raw: Annotated[list[RawRecord], Field(max_length=100_000)] = key("Raw logs.")


class ManifestFile(Group):
    """manifest.json of a release."""

    format: Literal[2] = key(
        "Read a release of another format by the code of its time; renew a pin with "
        "`oilfilm pin RELEASE`."
    )
    version: ShortText = key("<tag>-<12 hex digits>", min_length=1)
    made_from: MadeFrom = key("What the release was made from.")
    files: Annotated[list[Record], Field(max_length=100_000)] = key("Files of the release.")
    samples: Annotated[list[Record], Field(max_length=100_000)] = key(
        "Samples of each oil, which the release leaves out."
    )
    sha256: Sha256
