"""Whether the files of results are as their steps wrote them.

Decides: which results a run and a release refuse because somebody has changed them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.logs.raw_files import read_listings


@dataclass(frozen=True)
class StepOutputs:
    """The output files of steps, as each step listed them when it ended.

    Attributes:
        digest_by_path: sha256 of each file, by its path in the project.
        listing_by_path: The file in which the step listed it, by the same path.
    """

    digest_by_path: Mapping[str, str]
    listing_by_path: Mapping[str, Path]

    @classmethod
    def from_listings(cls, listings: Iterable[Path]) -> Self:
        """The files that some listings name; a listing that is removed meanwhile names none."""
        digest_by_path: dict[str, str] = {}
        listing_by_path: dict[str, Path] = {}
        for listing in listings:
            try:
                digest_by_path_of_step = read_listings(listing)
            except FileNotFoundError:
                continue
            digest_by_path |= digest_by_path_of_step
            listing_by_path |= dict.fromkeys(digest_by_path_of_step, listing)
        return cls(digest_by_path, listing_by_path)

    def refuse_altered(self, path: str, file: Path) -> None:
        """Refuse a listed file that is not as its step wrote it.

        Args:
            path: Its path in the project.
            file: The file, or its local copy.

        Raises:
            OilfilmError: Its content is another.
        """
        digest, listed_digest = file_digest(file), self.digest_by_path[path]
        if digest != listed_digest:
            raise OilfilmError(
                f"{path}: is not as its step wrote it. Its sha256 begins with {digest[:12]}, the "
                f"step wrote {listed_digest[:12]}. Remove it and {self.listing_by_path[path]}, "
                "then give the same command again: the step is repeated."
            )
