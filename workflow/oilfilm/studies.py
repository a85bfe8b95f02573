"""Studies: rooms of the library for one question. A campaign names them (`studies: [paper]`).

The rooms that every laboratory needs name no study. A study is a folder with two modules: `tables`
(`TABLES`, declared when the room is imported) and `study` (`STUDY`). It may have a folder
`figures`.

Decides: what a study may add to a campaign.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

_LIBRARY = Path(__file__).parent


@dataclass(frozen=True)
class Study:
    """What a study adds to a campaign beside its tables and figures.

    Attributes:
        name: Name of its room.
        exports: Function that makes more files for bearing codes from the oils by their
            identifiers, the settings and the provenance;
            `oilfilm.exports.campaign.export_campaign` calls it.
        exported: Sentence for the index of the exports where there are such files.
        sections: Function that makes sections of the report
            (`oilfilm.report.document.Section`) from the finished tables and the settings. They
            come after the sections of every campaign.
    """

    name: str
    exports: Callable[..., dict[str, bytes]]
    exported: str
    sections: Callable[..., list[Any]] = lambda *_: []


@cache
def available() -> tuple[str, ...]:
    """Names of all studies."""
    return tuple(sorted(path.parent.name for path in _LIBRARY.glob("*/study.py")))


def declare_tables(names: Iterable[str]) -> None:
    """Make the tables of some studies known to `oilfilm.tables`."""
    for name in names:
        import_module(f"oilfilm.{name}.tables")


def load(names: Iterable[str]) -> list[Study]:
    """The studies of these names, as a campaign lists them."""
    return [import_module(f"oilfilm.{name}.study").STUDY for name in names]
