"""Raw logs as they were when a run first read them: one that has changed since is refused.

Decides: when a raw log is refused because it changed.
"""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.errors import OilfilmError
from oilfilm.logs.raw_files import listed, listing

FOLDER = Path("data/first_seen")
# The listings are for people and version control; so many digits tell any two logs apart.
_DIGITS = 16
_LINE = re.compile(r"([0-9a-f]{64})  (data/raw/.+)")


class FirstSeen:
    """The listing of a campaign, which `sha256sum -c` reads: one line per log, never changed.

    Args:
        campaign: Its name.
        logs: Name of the folder of its logs, if that is another one.
        folder: Where the listings are.

    Raises:
        OilfilmError: A line of it is damaged.
    """

    def __init__(self, campaign: str, logs: str = "", folder: Path = FOLDER) -> None:
        self._campaign = campaign
        self._path = folder / f"{logs or campaign}.sha256"
        self._digests: dict[str, str] = {}
        # a campaign that has not run has none
        text = self._path.read_text(encoding="utf-8") if self._path.is_file() else ""
        for number, line in enumerate(text.split("\n")[:-1], start=1):
            parts = _LINE.fullmatch(line)
            if parts is None:
                raise OilfilmError(
                    f"{self._path}, line {number}: expected a sha256, two blanks and the path of a "
                    "log below data/raw. Put the file back from version control or a backup."
                )
            self._digests[parts[2]] = parts[1]

    def gone(self, logs: Iterable[str]) -> str:
        """Which logs an earlier run has read that are not among these, as a sentence; or empty."""
        lost = sorted(self._digests.keys() - set(logs))
        if not lost:
            return ""
        return (
            f"{len(lost)} logs that an earlier run has read are gone: {listed(lost)}. Put them "
            f"back; if they are not meant to be there, take their lines out of {self._path}."
        )

    def check_and_add(
        self, digests: Mapping[str, str], acknowledged: Iterable[Mapping[str, str]]
    ) -> None:
        """Refuse logs that have other bytes than at first; list those that are new.

        Args:
            digests: sha256 of each log by its path from the top folder.
            acknowledged: Changes that are meant, by the keys of the campaign file.

        Raises:
            OilfilmError: Which logs, and the lines that acknowledge their changes.
            OSError: The listing cannot be written.
        """
        entries = list(acknowledged)
        seen = {log: self._digests.get(log, now) for log, now in digests.items()}
        changed = {log: (seen[log], now) for log, now in digests.items() if seen[log] != now}
        for each in entries:
            was, now = changed.get(each["log"], ("", ""))
            if was.startswith(each["was"]) and now.startswith(each["now"]):
                changed.pop(each["log"], None)
        if changed:
            first, *others = changed
            more = f", and {len(others)} more" if others else ""
            place = "at the end of `acknowledged_changes` in" if entries else "to"
            key = "" if entries else "acknowledged_changes:\n"
            lines = [
                f"  - log: {json.dumps(log)}\n"
                f'    was: "{was[:_DIGITS]}"\n    now: "{now[:_DIGITS]}"\n    reason: '
                for log, (was, now) in changed.items()
            ]
            before = changed[first][0][:_DIGITS]
            raise OilfilmError(
                f"{first}: has changed since a run first read it (it was {before} then, "
                f"{self._path} says){more}. Put it back. If the change is meant, add these lines "
                f"{place} config/campaigns/{self._campaign}.yaml, with the reason:\n{key}"
                + "\n".join(lines)
            )
        together = {**digests, **self._digests}
        if together != self._digests:
            write_text(listing(dict(sorted(together.items()))), self._path)
            self._digests = together
