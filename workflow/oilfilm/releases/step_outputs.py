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
    """What steps have listed when they ended.

    Attributes:
        digests: sha256 of each file, by its path in the project.
        listings: The file in which its step has listed it, by the same path.
    """

    digests: Mapping[str, str]
    listings: Mapping[str, Path]

    @classmethod
    def of(cls, listings: Iterable[Path]) -> Self:
        """What some listings name. A listing that is removed meanwhile, to be renewed, is empty."""
        digests: dict[str, str] = {}
        listing_by_path: dict[str, Path] = {}
        for listing in listings:
            try:
                digests_of_step = read_listings(listing)
            except FileNotFoundError:
                continue
            digests |= digests_of_step
            listing_by_path |= dict.fromkeys(digests_of_step, listing)
        return cls(digests, listing_by_path)

    def refuse_altered(self, path: str, file: Path) -> None:
        """Refuse a listed file that is not as its step wrote it.

        Args:
            path: Its path in the project.
            file: The file, or its local copy.

        Raises:
            OilfilmError: It is another one.
        """
        digest, written = file_digest(file), self.digests[path]
        if digest != written:
            raise OilfilmError(
                f"{path}: is not as its step wrote it. Its sha256 begins with {digest[:12]}, the "
                f"step wrote {written[:12]}. Remove it and {self.listings[path]}, then give the "
                "same command again: the step is repeated."
            )
