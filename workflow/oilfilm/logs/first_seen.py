"""Digests of raw logs from the run that first read them. A log that has changed is refused.

Decides: when a raw log is refused because it changed.
"""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from oilfilm.base.atomic_write import write_text
from oilfilm.base.errors import OilfilmError
from oilfilm.logs.raw_files import joined_names, listing

# So many digits of a sha256 tell any two logs of a campaign apart.
_DIGITS_SHOWN = 16
_LINE = re.compile(r"(?P<digest>[0-9a-f]{64})  (?P<log>data/raw/.+)")


class FirstSeen:
    """The listing of a campaign, which `sha256sum -c` reads: one line per log, never changed.

    Args:
        campaign: Name of the campaign.
        logs: Name of the folder of its logs, if that is another one.
        folder: Folder of the listings.

    Raises:
        OilfilmError: A line of the listing is damaged.
    """

    def __init__(self, campaign: str, logs: str = "", *, folder: Path) -> None:
        self._campaign = campaign
        self._path = folder / f"{logs or campaign}.sha256"
        self._digests: dict[str, str] = {}
        # a campaign that has not run has no listing
        text = self._path.read_text(encoding="utf-8") if self._path.is_file() else ""
        # not `splitlines`, which also splits at rare marks that a path may have
        lines = text.removesuffix("\n").split("\n") if text else []
        for number, line in enumerate(lines, start=1):
            match = _LINE.fullmatch(line)
            if match is None:
                raise OilfilmError(
                    f"{self._path}, line {number}: expected a sha256, two blanks and the path of a "
                    "log below data/raw. Put the file back from version control or a backup."
                )
            self._digests[match["log"]] = match["digest"]

    def gone(self, logs: Iterable[str]) -> str:
        """A sentence about the logs of earlier runs that are missing now; empty without any.

        Args:
            logs: Paths of the logs that are there now.
        """
        missing = sorted(self._digests.keys() - set(logs))
        if not missing:
            return ""
        return (
            f"{len(missing)} logs that an earlier run has read are gone: "
            f"{joined_names(missing)}. Put "
            "them back; if they are not meant to be there, take their lines out of "
            f"{self._path}."
        )

    def check_and_add(
        self, digests: Mapping[str, str], acknowledged: Iterable[Mapping[str, str]]
    ) -> None:
        """Refuse logs that have changed since they were first read, and list those that are new.

        Args:
            digests: sha256 of each log by its path from the top folder.
            acknowledged: Intended changes, by the keys of the campaign file.

        Raises:
            OilfilmError: A log has changed. The message has the lines that acknowledge changes.
            OSError: The listing cannot be written.
        """
        acknowledged_changes = list(acknowledged)
        changed = {
            log: (self._digests[log], digest)
            for log, digest in digests.items()
            if self._digests.get(log, digest) != digest
        }
        for entry in acknowledged_changes:
            was, now = changed.get(entry["log"], ("", ""))
            if was.startswith(entry["was"]) and now.startswith(entry["now"]):
                changed.pop(entry["log"], None)
        if changed:
            raise self._changed_logs(changed, has_acknowledged=bool(acknowledged_changes))
        all_digests = dict(digests) | self._digests
        if all_digests != self._digests:
            write_text(listing(dict(sorted(all_digests.items()))), self._path)
            self._digests = all_digests

    def _changed_logs(
        self, changed: Mapping[str, tuple[str, str]], has_acknowledged: bool
    ) -> OilfilmError:
        """The error for changed logs.

        Args:
            changed: Digest at first and now, by the path of the log.
            has_acknowledged: Whether the campaign file has the key `acknowledged_changes`.
        """
        first_log, *other_logs = changed
        first_digest, _ = changed[first_log]
        more = f", and {len(other_logs)} more" if other_logs else ""
        if has_acknowledged:
            where_to_add = "at the end of `acknowledged_changes` in"
            lines_to_add = []
        else:
            where_to_add = "to"
            lines_to_add = ["acknowledged_changes:"]
        for log, (was, now) in changed.items():
            lines_to_add += [
                f"  - log: {json.dumps(log)}",
                f'    was: "{was[:_DIGITS_SHOWN]}"',
                f'    now: "{now[:_DIGITS_SHOWN]}"',
                "    reason: ",
            ]
        all_lines = "\n".join(lines_to_add)
        return OilfilmError(
            f"{first_log}: has changed since a run first read it (it was "
            f"{first_digest[:_DIGITS_SHOWN]} then, {self._path} says){more}. Put it back. If the "
            f"change is meant, add these lines {where_to_add} "
            f"config/campaigns/{self._campaign}.yaml, "
            f"with the reason:\n{all_lines}"
        )
