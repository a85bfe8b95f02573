"""Text exports of PCS Instruments rigs: MTM and ETM (traction), EHD (film thickness).

An export is a sequence of steps; some of them have a table. Steps are found by their structure: the
lines above the first one may have any form. Traction steps measure each slip in both directions:
index 1 with the disc faster, index 2 with the ball faster.

Decides: what a PCS export holds.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from oilfilm.base.units import BoolArray, FloatArray, conversion
from oilfilm.logs import base
from oilfilm.logs.log_kind import Column, Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile
from oilfilm.logs.text_rows import encoding_of

_STEP = re.compile(r"^Step (\d{1,9})\b.* started at .+$")
# A row of a table, even if it is cut after its first cell.
_ROW = re.compile(r"^(\s*[-+.\d]|.*\t.*\t.*\t)")
# A line with so many tabs is a row even where the line of names above it is damaged.
_FEWEST_TABS_OF_ROW = 6
_LINES_SEARCHED = 40
# Step types whose rows are settled readings; the others (warm-up, mapping) are no sweep.
_SWEEPS = {"traction", "film"}
# The surface speeds are computed: from both directions where both were measured.
_SPEEDS = ("ball_speed", "disc_speed")
# Column -> its declaration: `names` in exports, `logged` unit, `sampled` unit in the samples, and
# `needed` where a step cannot be used without it.
_COLUMNS: dict[str, dict[str, Any]] = yaml.safe_load(
    Path(__file__).with_name("pcs.yaml").read_text(encoding="utf-8")
)
_REQUIRED = tuple(name for name, column in _COLUMNS.items() if "needed" in column)
_SAMPLED = {name: column for name, column in _COLUMNS.items() if "sampled" in column}
# Number of sampled columns without which a row cannot be used: time, load and both speeds. Rigs
# leave some of the others blank, so that those are spare.
_NEVER_BLANK = 4
# Added to each tolerance: an identity may hold to exactly half a printed digit.
_FLOATING_POINT_ERROR = 1e-9


@dataclass
class _Step:
    """One step of the file: names of its columns and lines of its rows."""

    number: int
    type: str = "unknown"
    names: list[str] = field(default_factory=list)
    rows: list[str] = field(default_factory=list)


def recognises(head: bytes) -> bool:
    """True where the first lines have a PCS step or the title of a PCS file."""
    text = head.decode("utf-8-sig", "replace")
    lines = text.splitlines()[:_LINES_SEARCHED]
    return any(_STEP.match(line) or "Test Data File" in line for line in lines)


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `Reader.tables`."""
    base.check_lines(content)
    # older programs write the degree sign in the encoding of western Windows
    encoding = encoding_of(content)
    if encoding not in {"ascii", "utf-8"}:
        encoding = "cp1252"
    text = content.decode(encoding, "replace").removeprefix("\ufeff")
    steps = list(_steps(re.split("\r\n|\r|\n", text)))
    if vocabulary.name != "traction":
        reason = f"the file is an export of a PCS traction rig, not a {vocabulary.name} log"
        advice = "Move it to the folder of the campaign's traction logs."
        raise base.UnreadableLogError(reason, advice, sum(len(step.rows) for step in steps))
    run_names = base.distinct_names(f"step{step.number:03d}" for step in steps)
    is_cut = not text.endswith(("\n", "\r"))
    logged_tables = [
        _table(step, run_name, is_cut and step is steps[-1])
        for step, run_name in zip(steps, run_names, strict=True)
        if step.rows
    ]
    return base.TextForm.from_marks(encoding, "\t", "."), logged_tables


def _steps(lines: Iterable[str]) -> Iterator[_Step]:
    """Steps of a file."""
    step: _Step | None = None
    for line in lines:
        start = _STEP.match(line)
        if step is None and not start and line.count("\t") >= _FEWEST_TABS_OF_ROW:
            # a table above the first step: the first line of its step is damaged
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
            if step.rows:
                # a second table in one step: the first line of another step is damaged
                yield step
                step = _Step(step.number, step.type)
            step.names = [name.strip() for name in line.split("\t")]
        elif _ROW.match(line) and (step.names or line.count("\t") >= _FEWEST_TABS_OF_ROW):
            step.rows.append(line)
    if step is not None:
        yield step


def _table(step: _Step, run_name: str, is_cut: bool) -> LoggedTable:
    """A step as a table: the sampled columns with the surface speeds, then the other columns.

    Args:
        step: The step.
        run_name: Name of the run in the file.
        is_cut: Whether the last row has no line end.
    """
    indices = _indices_of_columns(step.names)
    cells_by_row = [row.split("\t") for row in step.rows]
    values = _values(cells_by_row, indices)
    sampled = [name for name in _SAMPLED if name in indices or name in _SPEEDS]
    sampled_names = [
        step.names[indices[name]] if name in indices else f"{name} (mean)" for name in sampled
    ]
    sampled_units = [_SAMPLED[name]["logged"] for name in sampled]
    columns = [
        Column(
            name,
            index,
            conversion(sampled_units[index], (_SAMPLED[name]["sampled"],)),
            sampled_names[index],
            sampled_units[index],
            spare=index >= _NEVER_BLANK,
        )
        for index, name in enumerate(sampled)
    ]
    other_names = list(dict.fromkeys(name for name in step.names if name not in sampled_names))
    names = [*sampled_names, *other_names]
    # only compared with the number of names; 0 would say that the last row has a line end
    missing_cells = len(step.names) - len(cells_by_row[-1])
    cut_row_cells = max(len(names) - missing_cells, 1) if is_cut else 0
    missing = [_COLUMNS[name]["names"][0] for name in _REQUIRED if name not in indices]
    return LoggedTable(
        {"log_kind": "steps"},
        names,
        [*sampled_units, *[""] * len(other_names)],
        lambda chosen: [values[sampled[index]] for index in chosen],
        len(cells_by_row),
        run_name,
        columns=columns,
        problem=_problem(step, missing),
        cut_row_cells=cut_row_cells,
        show=step.rows.__getitem__,
        contradictory=_contradictory(values),
    )


def _indices_of_columns(names: Sequence[str]) -> dict[str, int]:
    """Column of `pcs.yaml` -> its index in a table of a step."""
    # the first columns of a table repeat later ones: the last one of a name counts
    index_of_name = {name: index for index, name in enumerate(names)}
    indices: dict[str, int] = {}
    for column, declaration in _COLUMNS.items():
        for name in declaration["names"]:
            if name in index_of_name:
                indices[column] = index_of_name[name]
    return indices


def _values(
    cells_by_row: Sequence[Sequence[str]], indices: Mapping[str, int]
) -> dict[str, FloatArray]:
    """Numbers of each column of `pcs.yaml` and the surface speeds, shape (rows,).

    The time is NaN in rows that cannot be used.
    """
    values = {name: np.full(len(cells_by_row), np.nan) for name in _COLUMNS}
    for name, index in indices.items():
        values[name] = np.array([_number(row, index) for row in cells_by_row])
    values["ball_speed"], values["disc_speed"] = _surface_speeds(values)
    usable = np.ones(len(cells_by_row), dtype=bool)
    for numbers in values.values():
        usable &= ~(np.abs(numbers) > base.LARGEST_READING)
    for name in _REQUIRED:
        usable &= ~np.isnan(values[name])
    values["time"] = np.where(usable, values["time"], np.nan)
    return values


def _problem(step: _Step, missing: Sequence[str]) -> base.Refusal | None:
    """Why nothing of a step can be read; None where it can."""
    if step.type.lower() not in _SWEEPS:
        return base.Refusal(
            "not_a_sweep",
            f"step {step.number} is of type {step.type[:60]!r}; expected a traction or film sweep",
            "Nothing to do: such rows carry no traction curve.",
        )
    if missing:
        reason = f"step {step.number} lacks the columns {', '.join(missing)}"
        return base.Refusal("columns", reason, "Export the step again with all columns.")
    return None


def _number(row: Sequence[str], index: int) -> float:
    """The number in a cell; NaN where it is blank or missing, infinity where it holds none."""
    if index >= len(row) or not row[index].strip():
        return np.nan
    try:
        return base.parse_number(row[index])
    except ValueError:
        return np.inf


def _contradictory(values: Mapping[str, FloatArray]) -> BoolArray:
    """Rows that contradict themselves by more than the rounding of their cells, shape (rows,).

    TF = (TF1 - TF2)/2; coefficient = |TF|/W; rolling = mean surface speed; sliding = disc minus
    ball, directions averaged; SRR = 100 sliding/rolling. Identities with a blank cell are not
    judged. Exports round forces to 1e-4 N, the coefficient to 1e-4, speeds to 0.01 mm/s and SRR to
    0.001 %; the error of a cell is half of that at most.
    """
    ball, disc = values["ball_speed"], values["disc_speed"]
    rolling, sliding, srr = values["rolling"], values["sliding"], values["srr"]
    force, load = values["traction_force"], values["load"]
    with np.errstate(divide="ignore", invalid="ignore"):
        half_difference = (values["traction_force_1"] - values["traction_force_2"]) / 2
        # errors of sliding, of rolling and of SRR itself
        srr_rounding = (0.5 + 0.005 * np.abs(srr)) / np.abs(rolling) + 0.0005
        # each identity with the largest error from the rounding of its cells
        errors_of_identities = (
            (force - half_difference, 1e-4),
            (np.abs(force) / load - values["coefficient"], 5e-5 + 1e-4 / np.abs(load)),
            (rolling - (ball + disc) / 2, 0.010),
            (sliding - (disc - ball), 0.015),
            (srr - 100 * sliding / rolling, srr_rounding),
        )
        violated = [
            np.abs(difference) > rounding + _FLOATING_POINT_ERROR
            for difference, rounding in errors_of_identities
        ]
    return np.asarray(np.any(violated, axis=0))


def _surface_speeds(values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Speeds of ball and disc in mm/s, as if the disc were the faster body in both directions."""
    both_ways = ~np.isnan(values["ball_2"]) & ~np.isnan(values["disc_2"])
    slower = np.where(both_ways, (values["ball_1"] + values["disc_2"]) / 2, values["ball_1"])
    faster = np.where(both_ways, (values["disc_1"] + values["ball_2"]) / 2, values["disc_1"])
    return slower, faster
