"""Raw logs as they were when a run first read them: one that has changed since is refused.

Decides: when a raw log is refused because it changed.
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.errors import OilfilmError
from oilfilm.settings.campaign import AcknowledgedChange

FOLDER = Path("data/first_seen")
# The listings are for people and version control; so many digits tell any two logs apart.
_DIGITS = 16
_LINE = re.compile(r"([0-9a-f]{64})  (data/raw/.+)")


class FirstSeen:
    """The listing of a campaign, which `sha256sum -c` reads: one line per log, never changed."""

    def __init__(self, campaign: str, folder: Path = FOLDER) -> None:
        """Read the listing; a campaign that has not run has none.

        Args:
            campaign: Its name.
            folder: Where the listings are.

        Raises:
            OilfilmError: A line of it is damaged.
        """
        self._campaign = campaign
        self._path = folder / f"{campaign}.sha256"
        self._states: dict[str, str] = {}
        text = self._path.read_text(encoding="utf-8") if self._path.is_file() else ""
        for number, line in enumerate(text.split("\n")[:-1], start=1):
            parts = _LINE.fullmatch(line)
            if parts is None:
                raise OilfilmError(
                    f"{self._path}, line {number}: expected a sha256, two blanks and the path of a "
                    "log below data/raw. Put the file back from version control or a backup."
                )
            self._states[parts[2]] = parts[1]

    def refuse_changed(
        self,
        logs: Iterable[Path],
        state_of: Callable[[Path], str],
        acknowledged: Iterable[AcknowledgedChange],
    ) -> None:
        """Refuse logs that have other bytes than at first, unless the campaign file says why.

        Args:
            logs: The logs, from the top folder.
            state_of: Gives the sha256 of a log; empty if unknown.
            acknowledged: Changes that are meant.

        Raises:
            OilfilmError: Which logs, and the lines that acknowledge their changes.
        """
        entries = list(acknowledged)
        changes = {
            log: (was, now)
            for log in (path.as_posix() for path in logs)
            if log in self._states
            for was, now in [(self._states[log], state_of(Path(log)))]
            if now not in (was, "")
            and not any(
                each.log == log and was.startswith(each.was) and now.startswith(each.now)
                for each in entries
            )
        }
        if not changes:
            return
        (log, (was, _)), *others = changes.items()
        more = f", and {len(others)} more" if others else ""
        place = "at the end of `acknowledged_changes` in" if entries else "to"
        lines = "" if entries else "acknowledged_changes:\n"
        for changed, states in changes.items():
            quoted = [json.dumps(text) for text in (changed, *(s[:_DIGITS] for s in states))]
            lines += "  - log: {}\n    was: {}\n    now: {}\n    reason: \n".format(*quoted)
        raise OilfilmError(
            f"{log}: has changed since a run first read it (it was {was[:_DIGITS]} then, "
            f"{self._path} says){more}. Put it back. If the change is meant, add these lines "
            f"{place} config/campaigns/{self._campaign}.yaml, with the reason:\n"
            + lines.removesuffix("\n")
        )

    def add(self, states: Mapping[str, str]) -> None:
        """Keep the state of logs that are new; the others keep theirs.

        Raises:
            OSError: The listing cannot be written.
        """
        together = {log: state for log, state in states.items() if state} | self._states
        if together != self._states:
            lines = [f"{state}  {log}\n" for log, state in sorted(together.items())]
            write_text("".join(lines), self._path)
            self._states = together
