"""The command `oilfilm verify`: is a release as it was made, and can it be made again?"""

import argparse
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from oilfilm.errors import printable
from oilfilm.releases.manifest import read_manifest
from oilfilm.releases.verify import verify


class Verified(BaseModel):
    """What was found in the folder of a release or a pin."""

    model_config = ConfigDict(extra="forbid")

    folder: str = Field(description="folder, as it was named")
    version: str = Field(description="version of the release")
    pin: bool = Field(description="true for a pin: only the files that it keeps are checked")
    files: int = Field(description="files that the manifest names")
    not_as_released: list[str] = Field(description="one sentence per file; empty where all agree")
    rebuilt: list[str] | None = Field(
        description="differences of a rebuild from the raw logs, the first of them; empty where "
        "there are none; null where nothing was rebuilt"
    )

    @property
    def well(self) -> bool:
        """Whether nothing differs."""
        return not self.not_as_released and not self.rebuilt

    def released_text(self) -> str:
        """Whether the files are as released, in sentences."""
        if self.not_as_released:
            head = f"{self.folder}: {len(self.not_as_released)} files are not as released:"
            return "\n".join([head, *self.not_as_released])
        checked = "the files in the pin" if self.pin else f"all {self.files} files"
        return f"{printable(self.version)}: {checked} are as released"

    def rebuilt_text(self) -> str:
        """Whether the rebuild gave the same bytes, in sentences."""
        if not self.rebuilt:
            return "rebuilt from the raw logs: the same bytes"
        head = f"rebuilt from the raw logs: {len(self.rebuilt)} differences, the first:"
        return "\n".join([head, *map(printable, self.rebuilt)])


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where a file is not as released or the rebuild differs."""
    release: Path = options.release
    complaints = verify(release)
    manifest, pinned = read_manifest(release)
    found = Verified(
        folder=str(release),
        version=manifest.version,
        pin=pinned,
        files=len(manifest.files),
        not_as_released=complaints,
        rebuilt=None,
    )
    if not options.json:
        # now: a rebuild takes minutes
        print(found.released_text(), flush=True)
    if options.rebuild and not complaints:
        from oilfilm.releases.rebuild import rebuild  # noqa: PLC0415 - needs the extra `report`

        found.rebuilt = rebuild(release, Path(), options.cores)
        if not options.json:
            print(found.rebuilt_text())
    if options.json:
        print(found.model_dump_json())
    return int(not found.well)
