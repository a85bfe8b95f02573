"""Text exports of PCS Instruments rigs: MTM and ETM (traction), EHD (film thickness).

An export is a sequence of steps, each with lines of its own and, for some, a table. Steps are
found by their structure; the lines above the first one are not relied on. Traction steps measure
each slip in both directions: index 1 with the disc faster, index 2 with the ball faster.

Decides: what a PCS export holds.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from oilfilm.logs import base
from oilfilm.logs.columns import Found, LoggedTable
from oilfilm.logs.log_kind import Column, Vocabulary
from oilfilm.logs.text_rows import encoding_of
from oilfilm.units import BoolArray, FloatArray, conversion

_STEP = re.compile(r"^Step (\d{1,9})\b.* started at .+$")
# A row of a table, were it cut after its first cell.
_ROW = re.compile(r"^(\s*[-+.\d]|.*\t.*\t.*\t)")
# So many cells are a row even where the line of names above them is damaged.
_TABS_OF_A_ROW = 6
# Step types whose rows are settled readings; the others (warm-up, mapping) are no sweep.
_SWEEPS = {"traction", "film"}
# The surface speeds are computed: of both directions, where both were measured.
_SPEEDS = ("ball_speed", "disc_speed")
_COLUMNS: dict[str, dict[str, Any]] = yaml.safe_load(
    Path(__file__).with_name("pcs.yaml").read_text(encoding="utf-8")
)
_REQUIRED = tuple(name for name, column in _COLUMNS.items() if "needed" in column)
_SAMPLED = {name: column for name, column in _COLUMNS.items() if "sampled" in column}
# Room for floating point where an identity holds to exactly half a printed digit.
_FLOATING = 1e-9


@dataclass
class _Step:
    """One step of the file."""

    number: int
    type: str = "unknown"
    names: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)


def recognises(head: bytes) -> bool:
    """True where the first lines have a PCS step or the title of a PCS file."""
    text = head.decode("utf-8-sig", "replace")
    return any(_STEP.match(line) or "Test Data File" in line for line in text.splitlines()[:40])


def tables(content: bytes, vocabulary: Vocabulary) -> Found:
    """See `Reader.tables`."""
    base.check_lines(content)
    # older programs write the degree sign in the encoding of western Windows
    likely = encoding_of(content)
    encoding = likely if likely in {"ascii", "utf-8"} else "cp1252"
    text = content.decode(encoding, "replace").removeprefix("\ufeff")
    steps = list(_steps(re.split("\r\n|\r|\n", text)))
    labels = base.distinct(f"step{step.number:03d}" for step in steps)
    if vocabulary.name != "traction":
        reason = f"the file is an export of a PCS traction rig, not a {vocabulary.name} log"
        advice = "Move it to the folder of the campaign's traction logs."
        raise base.UnreadableLogError(reason, advice, sum(len(step.lines) for step in steps))
    cut = bool(text) and not text.endswith(("\n", "\r"))
    named = zip(steps, labels, strict=True)
    logged = [_table(step, name, cut and step is steps[-1]) for step, name in named if step.lines]
    return base.TextForm.of(encoding, "\t", "."), logged


def _steps(lines: Iterable[str]) -> Iterator[_Step]:
    """Steps of a file."""
    step: _Step | None = None
    for line in lines:
        start = _STEP.match(line)
        if step is None and not start and line.count("\t") >= _TABS_OF_A_ROW:
            # a table above the first step: the line that began it is damaged
            step = _Step(0)
        if start:
            if step is not None:
                yield step
            step = _Step(int(start[1]))
        elif step is None:
            continue
        elif line.startswith("Step type\t"):
            step.type = line.split("\t")[1].strip()
        elif "Step Time (s)" in line:
            if step.lines:
                # a second table in one step: the line that began another step is damaged
                yield step
                step = _Step(step.number, step.type)
            step.names = [name.strip() for name in line.split("\t")]
        elif _ROW.match(line) and (step.names or line.count("\t") >= _TABS_OF_A_ROW):
            step.lines.append(line)
    if step is not None:
        yield step


def _table(step: _Step, label: str, cut: bool) -> LoggedTable:
    """A step as a table with the surface speeds behind its own columns."""
    # the first columns of a table repeat later ones
    last = {name: place for place, name in enumerate(step.names)}
    known = ((ours, each) for ours, column in _COLUMNS.items() for each in column["names"])
    places = {ours: last[theirs] for ours, theirs in known if theirs in last}
    cells = [line.split("\t") for line in step.lines]
    values = {name: np.full(len(cells), np.nan) for name in _COLUMNS} | {
        name: np.array([_number(row[place : place + 1]) for row in cells])
        for name, place in places.items()
    }
    values |= dict(zip(_SPEEDS, _surface_speeds(values), strict=True))
    readable = np.logical_and.reduce(
        [~(np.abs(numbers) > base.LARGEST_READING) for numbers in values.values()]
        + [~np.isnan(values[name]) for name in _REQUIRED]
    )
    values["time"] = np.where(readable, values["time"], np.nan)
    used = [name for name in _SAMPLED if name in places or name in _SPEEDS]
    names = [step.names[places[name]] if name in places else f"{name} (mean)" for name in used]
    others = [*{name: "" for name in step.names if name not in names}]
    logged, sampled = ([_SAMPLED[name][key] for name in used] for key in ("logged", "sampled"))
    width = len(cells[-1]) + len(names) + len(others) - len(step.names)
    columns = [
        # rigs leave some of the columns behind the first four blank
        Column(name, place, conversion(unit, (to,)), names[place], unit, spare=place >= 4)
        for place, (name, unit, to) in enumerate(zip(used, logged, sampled, strict=True))
    ]
    missing = [_COLUMNS[name]["names"][0] for name in _REQUIRED if name not in places]
    return LoggedTable(
        {"log_kind": "steps"},
        [*names, *others],
        [*logged, *[""] * len(others)],
        lambda wanted: [values[used[place]] for place in wanted],
        len(cells),
        label,
        columns=columns,
        problem=_problem(step, missing),
        cut=width if cut else 0,
        show=step.lines.__getitem__,
        broken=_broken(values),
    )


def _problem(step: _Step, missing: Sequence[str]) -> base.Refusal | None:
    if step.type.lower() not in _SWEEPS:
        found = (
            f"step {step.number} is of type {step.type[:60]!r}; expected a traction or film sweep"
        )
        return base.Refusal(
            "not_a_sweep", found, "Nothing to do: such rows carry no traction curve."
        )
    reason = f"step {step.number} lacks the columns {', '.join(missing)}"
    advice = "Export the step again with all columns."
    return base.Refusal("columns", reason, advice) if missing else None


def _number(cell: Sequence[str]) -> float:
    """The number of a cell; NaN where it is blank or missing, infinity where it holds none."""
    try:
        return base.number(cell[0]) if cell and cell[0].strip() else np.nan
    except ValueError:
        return np.inf


def _broken(values: Mapping[str, FloatArray]) -> BoolArray:
    """Rows that do not agree with themselves to the rounding of their cells.

    TF = (TF1 - TF2)/2; coefficient = |TF|/W; rolling = mean surface speed; sliding = disc minus
    ball, directions averaged; SRR = 100 sliding/rolling. Identities of cells that the rig leaves
    blank are not asked.
    """
    ball, disc = (values[name] for name in _SPEEDS)
    rolling, force, srr = values["rolling"], values["traction_force"], values["srr"]
    abs_load, abs_rolling = np.abs(values["load"]), np.abs(rolling)
    with np.errstate(divide="ignore", invalid="ignore"):
        half = (values["traction_force_1"] - values["traction_force_2"]) / 2
        # both speeds rounded to 0.01 mm/s, SRR to 0.001 %
        rounded = (0.5 + 0.005 * np.abs(srr)) / abs_rolling + 0.0005
        # what rounding each cell of the identity to its printed digits can make of it
        differences = (
            (force - half, 1e-4),
            (np.abs(force) / values["load"] - values["coefficient"], 5e-5 + 1e-4 / abs_load),
            (rolling - (ball + disc) / 2, 0.010),
            (values["sliding"] - (disc - ball), 0.015),
            (srr - 100 * values["sliding"] / rolling, rounded),
        )
        broken = [np.abs(difference) > allowed + _FLOATING for difference, allowed in differences]
    return np.asarray(np.any(broken, axis=0))


def _surface_speeds(values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Ball and disc speed as if the disc were the faster body in both directions, in mm/s."""
    two_ways = ~np.isnan(values["ball_2"]) & ~np.isnan(values["disc_2"])
    slower = np.where(two_ways, (values["ball_1"] + values["disc_2"]) / 2, values["ball_1"])
    faster = np.where(two_ways, (values["disc_1"] + values["ball_2"]) / 2, values["disc_1"])
    return slower, faster
