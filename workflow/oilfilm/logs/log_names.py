"""Which logs a name or a pattern means."""

import difflib
import unicodedata
from collections.abc import Sequence
from pathlib import PurePosixPath

from oilfilm.logs.run_sheet import matches

_PACKED = (".gz", ".zst")


class LogNames:
    """The logs of a campaign by the names that the run sheet may give them."""

    def __init__(self, files: Sequence[str]) -> None:
        self.files = files
        self._whole = {file: _plain(file) for file in files}
        self._last = {file: PurePosixPath(name).name for file, name in self._whole.items()}
        self._by_name: list[dict[str, list[str]]] = []
        for names in (self._whole, self._last):
            # a log keeps its name when it is packed
            for name_of in (str, _unpacked):
                by_name: dict[str, list[str]] = {}
                for file, name in names.items():
                    by_name.setdefault(name_of(name), []).append(file)
                self._by_name.append(by_name)

    def meant(self, cell: str) -> tuple[list[str], bool]:
        """The logs that a cell of `file` means, and whether it is a name that several logs have.

        A name without a folder means a log in any folder.
        """
        pattern = _plain(cell.replace("\\", "/").removeprefix("./"))
        if not set(pattern) & set("*?"):
            found: list[str] = next(filter(None, (by.get(pattern) for by in self._by_name)), [])
            return found, len(found) > 1
        names = self._whole if "/" in pattern else self._last
        fitting = [
            file
            for file, name in names.items()
            if matches(name, pattern) or matches(_unpacked(name), pattern)
        ]
        return fitting, False

    def nearest(self, cell: str) -> str | None:
        """The log whose name resembles a cell most."""
        lasts = {_unpacked(last).casefold(): file for file, last in self._last.items()}
        name = PurePosixPath(_plain(cell).replace("\\", "/")).name
        near = difflib.get_close_matches(_unpacked(name).casefold(), lasts, 1)
        return lasts[near[0]] if near else None


def _plain(name: str) -> str:
    """A name with its letters composed: some systems write an umlaut as two characters."""
    return unicodedata.normalize("NFC", name)


def _unpacked(name: str) -> str:
    return next((name.removesuffix(end) for end in _PACKED if name.endswith(end)), name)
