"""Columns and tables as their YAML files declare them: one line per column, one entry per table.

A column is declared once: `name: kind | meaning | caveat`. The kind is a unit (of a number),
`share`, `count`, `text` or `flag`; then `required` where it is never null, bounds, and in brackets
the only texts allowed. A table lists the names of its columns. Under `uses` it may narrow a column
and add a note, but it has no unit and no meaning of its own: the same name is the same quantity
everywhere.

Decides: columns and key of every table, what a column means, and its unit, each in a YAML file
beside it (`rig.yaml` with `points` and `runs`, `fits.yaml`, `bearing.yaml`).
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from oilfilm.tables.declaration import LARGEST, Check, Column, Table, repeated

# Every column and every table by name, in the order in which they are described.
COLUMNS: dict[str, Column] = {}
TABLES: dict[str, Table] = {}
# Columns that several tables share, as `@friction`, and what these tables say of them.
_SETS: dict[str, Mapping[str, Any]] = {}

_KIND = re.compile(
    r"(?P<unit>[^<>(]*?) ?(?P<words>(?:\b(?:dictionary|required)\b ?)*)"
    r"(?:>= (?P<at_least>\S+) ?)?(?:<= (?P<at_most>\S+) ?)?(?:\((?P<allowed>.*)\))?"
)


def declare(path: Path, checks: Mapping[str, Check] | None = None) -> None:
    """Add the columns and tables of a YAML file.

    Args:
        path: The file.
        checks: By table: a check over several columns.

    Raises:
        ValueError: A name is declared twice.
        KeyError: A table has a column that is not declared.
    """
    content = yaml.load(path.read_bytes(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # noqa: S506
    for name, text in content["columns"].items():
        if name in COLUMNS:
            raise ValueError(f"{path}: column {name!r} is declared twice")
        COLUMNS[name] = _column(name, text)
    _SETS.update(content.get("sets", {}))
    for name, entry in content["tables"].items():
        if name in TABLES:
            raise ValueError(f"{path}: table {name!r} is declared twice")
        TABLES[name] = _table(name, entry, (checks or {}).get(name))


def _column(name: str, text: str) -> Column:
    kind, meaning, *caveat = text.split(" | ")
    unit, limits = _limits(kind)
    declared: dict[str, Any] = {"name": name, "meaning": meaning, "caveat": "".join(caveat)}
    if unit in ("text", "flag"):
        declared |= {"type": unit, "unit": ""}
    elif unit == "count":
        declared |= {"type": "integer", "unit": "1", "at_least": 0}
    elif unit == "share":
        declared |= {"type": "number", "unit": "1", "nullable": True, "at_least": 0, "at_most": 1}
    else:  # infinity passes no bound
        declared |= {"type": "number", "unit": unit, "nullable": True}
        declared |= {"at_least": -LARGEST, "at_most": LARGEST}
    return Column(**declared | limits)


def _limits(kind: str) -> tuple[str, dict[str, Any]]:
    """Unit of a kind, and its limits as attributes of a column."""
    match = _KIND.fullmatch(kind)
    if match is None:
        raise ValueError(f"{kind!r} is no kind of column")
    unit, words, at_least, at_most, allowed = match.groups()
    limits: dict[str, Any] = {}
    if "required" in words:
        limits["nullable"] = False
    if "dictionary" in words:
        limits["dictionary"] = True
    for name, bound in (("at_least", at_least), ("at_most", at_most)):
        if bound is not None:
            limits[name] = float(bound)
    if allowed is not None:
        limits["allowed"] = tuple(allowed.split(", "))
    return unit, limits


def use(name: str, text: str) -> Column:
    """A column as one table has it: same unit and meaning, other bounds, a note.

    Args:
        name: Of the column.
        text: The note, or `limits | note`.
    """
    kind, _, note = text.rpartition("|")
    _, limits = _limits(kind.strip())
    return replace(COLUMNS[name], note=note.strip(), **limits)


def _table(name: str, entry: Mapping[str, Any], check: Check | None) -> Table:
    names: list[str] = []
    uses: dict[str, str] = {}
    for word in entry["columns"].split():
        shared = _SETS[word[1:]] if word[0] == "@" else {"columns": word}
        names += shared["columns"].split()
        uses |= shared.get("uses", {})
    uses |= entry.get("uses", {})
    if unknown := set(uses) - set(names):
        raise ValueError(f"table {name!r} has no columns {sorted(unknown)}")
    references = {other: tuple(key.split()) for other, key in entry.get("references", {}).items()}
    return Table(
        name=name,
        description=entry["row"],
        columns=tuple(use(each, uses[each]) if each in uses else COLUMNS[each] for each in names),
        key=tuple(entry.get("key", "").split()),
        no_key=entry.get("no_key", ""),
        caveats=entry.get("caveats", ""),
        references=references,
        checks=(check,) if check else (),
    )


def unit_of(name: str) -> str:
    """The unit of a column; "1" for plain numbers, empty for text and flags.

    Raises:
        KeyError: No table has such a column.
    """
    return COLUMNS[name].unit


def _verdict_agrees_with_failed_gates(frame: pd.DataFrame) -> str:
    wrong = int((frame["accepted"] != (frame["failed_gates"] == "")).sum())
    return f"{wrong} points are accepted with a failed gate or refused without one" if wrong else ""


def _pages_are_unique(frame: pd.DataFrame) -> str:
    return repeated(frame[frame["page"] != ""], ["page"])


for each in ("rig", "fits", "bearing", "drawn"):
    declare(
        Path(__file__).with_name(f"{each}.yaml"),
        checks={"points": _verdict_agrees_with_failed_gates, "refused_pages": _pages_are_unique},
    )
