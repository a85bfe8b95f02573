"""Digests of raw logs from the run that first read them. A log that has changed is refused.

Decides: when a raw log is refused because it changed.
"""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

import yaml

from oilfilm.base.atomic_write import write_text
from oilfilm.base.errors import OilfilmError
from oilfilm.logs.raw_files import listing_text, names_in_words

# So many digits of a sha256 tell any two logs of a campaign apart.
_DIGITS_SHOWN = 16
# Python reads bytes that are no UTF-8 as surrogates, which no name of a log has.
_LINE = re.compile(r"(?P<digest>[0-9a-f]{64})  (?P<path>data/raw/[^\ud800-\udfff\n]+)")


class FirstSeenDigests:
    """The listing of a campaign, which `sha256sum -c` reads: one line per log, never changed.

    A log is named by its path from the top folder, as `data/raw/june/a.csv`.

    Args:
        campaign_name: Name of the campaign.
        log_folder_name: Name of the folder of its logs, if that is another one.
        folder: Folder of the listings.

    Raises:
        OilfilmError: A line of the listing is damaged.
    """

    def __init__(self, campaign_name: str, log_folder_name: str = "", *, folder: Path) -> None:
        self._campaign_name = campaign_name
        self._listing_path = folder / f"{log_folder_name or campaign_name}.sha256"
        self._digest_of_path: dict[str, str] = {}
        # a campaign that has not run has no listing
        text = ""
        if self._listing_path.is_file():
            text = self._listing_path.read_text(encoding="utf-8", errors="surrogateescape")
        # not `splitlines`, which also splits at rare characters that a path may have
        lines = text.removesuffix("\n").split("\n") if text else []
        for number, line in enumerate(lines, start=1):
            match = _LINE.fullmatch(line)
            if match is None:
                raise OilfilmError(
                    f"{self._listing_path}, line {number}: expected a sha256, two blanks and the "
                    "path of a log below data/raw. Put the file back from version control or a "
                    "backup."
                )
            self._digest_of_path[match["path"]] = match["digest"]

    def sentence_on_missing(self, paths: Iterable[str]) -> str:
        """A sentence about the logs of earlier runs that are missing now; empty without any.

        Args:
            paths: Paths of the logs that are there now.
        """
        missing_paths = sorted(self._digest_of_path.keys() - set(paths))
        if not missing_paths:
            return ""
        return (
            f"{len(missing_paths)} logs that an earlier run has read are gone: "
            f"{names_in_words(missing_paths)}. Put "
            "them back; if they are not meant to be there, take their lines out of "
            f"{self._listing_path}."
        )

    def check_and_add(
        self, digest_of_path: Mapping[str, str], acknowledged: Iterable[Mapping[str, str]]
    ) -> None:
        """Refuse logs that have changed since they were first read, and list those that are new.

        Args:
            digest_of_path: Path of each log -> its sha256 now.
            acknowledged: Intended changes, by the keys of the campaign file.

        Raises:
            OilfilmError: A log has changed. The message has the lines that acknowledge changes.
            OSError: The listing cannot be written.
        """
        acknowledged_changes = list(acknowledged)
        digests_of_changed_path = {
            path: (self._digest_of_path[path], digest)
            for path, digest in digest_of_path.items()
            if self._digest_of_path.get(path, digest) != digest
        }
        for entry in acknowledged_changes:
            was, now = digests_of_changed_path.get(entry["log"], ("", ""))
            if was.startswith(entry["was"]) and now.startswith(entry["now"]):
                digests_of_changed_path.pop(entry["log"], None)
        if digests_of_changed_path:
            raise self._changed_logs_error(
                digests_of_changed_path, has_acknowledged=bool(acknowledged_changes)
            )
        digest_of_listed_path = dict(digest_of_path) | self._digest_of_path
        if digest_of_listed_path != self._digest_of_path:
            write_text(
                listing_text(dict(sorted(digest_of_listed_path.items()))), self._listing_path
            )
            self._digest_of_path = digest_of_listed_path

    def _changed_logs_error(
        self, digests_of_changed_path: Mapping[str, tuple[str, str]], has_acknowledged: bool
    ) -> OilfilmError:
        """The error for changed logs, with the lines that acknowledge the changes.

        Args:
            digests_of_changed_path: Path of a log -> its first digest, and that of now.
            has_acknowledged: Whether the campaign file has the key `acknowledged_changes`.
        """
        first_path = next(iter(digests_of_changed_path))
        first_digest, _ = digests_of_changed_path[first_path]
        other_count = len(digests_of_changed_path) - 1
        more = f", and {other_count} more" if other_count else ""
        if has_acknowledged:
            where_to_add = "at the end of `acknowledged_changes` in"
            lines_to_add = []
        else:
            where_to_add = "to"
            lines_to_add = ["acknowledged_changes:"]
        for path, (was, now) in digests_of_changed_path.items():
            lines_to_add += [
                f"  - log: {_quoted(path)}",
                f'    was: "{was[:_DIGITS_SHOWN]}"',
                f'    now: "{now[:_DIGITS_SHOWN]}"',
                "    reason: ",
            ]
        all_lines = "\n".join(lines_to_add)
        return OilfilmError(
            f"{first_path}: has changed since a run first read it (it was "
            f"{first_digest[:_DIGITS_SHOWN]} then, {self._listing_path} says){more}. Put it back. "
            f"If the change is meant, add these lines {where_to_add} "
            f"config/campaigns/{self._campaign_name}.yaml, "
            f"with the reason:\n{all_lines}"
        )


def _quoted(text: str) -> str:
    r"""A text in quotes on one line, as YAML reads it back.

    Examples:
        >>> print(_quoted('a "b" \N{LINE SEPARATOR}'))
        "a \"b\" \L"
    """
    dumped: str = yaml.safe_dump(text, default_style='"', allow_unicode=True, width=float("inf"))
    return dumped.removesuffix("\n")
