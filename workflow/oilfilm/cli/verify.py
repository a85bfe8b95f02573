"""The command `oilfilm verify`: is a release as it was made, and can it be made again?"""

import argparse
from pathlib import Path

from oilfilm.errors import printable
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.base import Group, key


class Verified(Group):
    """What was found in the folder of a release or a pin."""

    folder: str = key("Folder, as it was named.")
    version: str = key("Version of the release.")
    pin: bool = key("True for a pin: only the files that it keeps are checked.")
    files: int = key("Files that the manifest names.")
    not_as_released: list[str] = key("One sentence per file; empty where all agree.")
    rebuilt: list[str] | None = key(
        "Differences of a rebuild from the raw logs, the first of them; empty where there are "
        "none; null where nothing was rebuilt."
    )

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
    stored = StoredRelease.open(release)
    found = Verified(
        folder=str(release),
        version=stored.manifest.version,
        pin=stored.pinned,
        files=len(stored.files),
        not_as_released=stored.changes(),
        rebuilt=None,
    )
    if not options.json:
        # now: a rebuild takes minutes
        print(found.released_text(), flush=True)
    if options.rebuild and not found.not_as_released:
        from oilfilm.releases.rebuild import rebuild  # noqa: PLC0415 - needs the extra `report`

        found = found.model_copy(update={"rebuilt": rebuild(release, Path(), options.cores)})
        if not options.json:
            print(found.rebuilt_text())
    if options.json:
        print(found.model_dump_json())
    return int(bool(found.not_as_released or found.rebuilt))
