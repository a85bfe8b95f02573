"""Text exports of PCS Instruments rigs: MTM and ETM (traction), EHD (film thickness).

An export is a sequence of steps; some of them have a table. Steps are found by their structure: the
lines above the first one may have any form. Traction steps measure each slip in both directions:
index 1 with the disc faster, index 2 with the ball faster.

Decides: what a PCS export holds.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from oilfilm.base.units import BoolArray, FloatArray, conversion
from oilfilm.logs import base
from oilfilm.logs.log_schema import LoggedColumn, Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile
from oilfilm.logs.text_rows import encoding_of

_STEP = re.compile(r"^Step (\d{1,9})\b.* started at .+$")
# A row of a table, even if it is cut after its first cell.
_ROW = re.compile(r"^(\s*[-+.\d]|.*\t.*\t.*\t)")
# A line with so many tabs is a row even where the line of names above it is damaged.
_FEWEST_TABS_OF_ROW = 6
_LINES_SEARCHED = 40
# A line above the steps with so many marks between cells is a line of names or a row.
_FEWEST_MARKS_OF_TABLE = 3
# Step types whose rows are settled readings; the others (warm-up, mapping) are no sweep.
_SWEEP_TYPES = {"traction", "film"}
# The surface speeds are computed: from both directions where both were measured.
_SURFACE_SPEEDS = ("ball_speed", "disc_speed")
# Column, as `pcs.yaml` calls it -> its declaration: its `names` in exports, its unit in exports
# (`logged`) and in the samples (`sampled`), and `needed` where a step cannot be used without it.
_DECLARATION_OF_COLUMN: dict[str, dict[str, Any]] = yaml.safe_load(
    Path(__file__).with_name("pcs.yaml").read_text(encoding="utf-8")
)
_NEEDED_COLUMNS = tuple(
    column for column, declaration in _DECLARATION_OF_COLUMN.items() if "needed" in declaration
)
_DECLARATION_OF_SAMPLED_COLUMN = {
    column: declaration
    for column, declaration in _DECLARATION_OF_COLUMN.items()
    if "sampled" in declaration
}
# Number of sampled columns without which a row cannot be used: the first ones, which are time, load
# and both speeds. Rigs leave some of the others blank, so that those are spare.
_NEVER_BLANK_COUNT = 4
# One in the last digit of usual exports (N, mm/s, %). Programs that print more digits have computed
# with fewer.
_LAST_DIGIT_OF_COLUMN = {
    **dict.fromkeys(("traction_force", "traction_force_1", "traction_force_2"), 1e-4),
    **dict.fromkeys(("ball_1", "ball_2", "disc_1", "disc_2", "rolling", "sliding"), 0.01),
    "coefficient": 1e-4,
    "srr": 0.001,
}
# Added to each tolerance: an identity may hold to exactly half a printed digit.
_FLOATING_POINT_ERROR = 1e-9


@dataclass
class _Step:
    """One step of the file: number and type, names of its columns, and the lines of its rows."""

    number: int
    type: str = "unknown"
    names: list[str] = field(default_factory=list)
    row_lines: list[str] = field(default_factory=list)


def recognises(first_bytes: bytes) -> bool:
    """True where the first lines have a PCS step, or the title of a PCS file and no table below."""
    text = first_bytes.decode("utf-8-sig", "replace")
    lines = text.splitlines()[:_LINES_SEARCHED]
    return any(_STEP.match(line) for line in lines) or _has_title(lines)


def _has_title(lines: Sequence[str]) -> bool:
    """Whether lines have the title of a PCS file; another log may have these words above a table.

    The lines of a step begin with `Step`, also where the first one is damaged.
    """
    has_title = False
    for line in lines:
        has_title |= "Test Data File" in line and not line.startswith("#")
        if has_title and line.startswith("Step"):
            return True
        if any(line.count(mark) >= _FEWEST_MARKS_OF_TABLE for mark in ",;|\t"):
            return False
    return has_title


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    base.check_text_size(content)
    # older programs write the degree sign in the encoding of western Windows
    encoding = encoding_of(content)
    if encoding not in {"ascii", "utf-8"}:
        encoding = "cp1252"
    text = content.decode(encoding, "replace").removeprefix("\ufeff")
    lines = re.split("\r\n|\r|\n", text)
    steps = list(_steps(lines))
    if vocabulary.name != "traction":
        reason = f"the file is an export of a PCS traction rig, not a {vocabulary.name} log"
        advice = "Move it to the folder of the campaign's traction logs."
        raise base.UnreadableLogError(reason, advice, sum(len(step.row_lines) for step in steps))
    run_names = base.distinct_names(f"step{step.number:03d}" for step in steps)
    # the last line is empty where all have a line end
    logged_tables = [
        _table(step, run_name, step is steps[-1] and step.row_lines[-1] == lines[-1])
        for step, run_name in zip(steps, run_names, strict=True)
        if step.row_lines
    ]
    return base.TextDialect.from_marks(encoding, "\t", "."), logged_tables


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
            if step.row_lines:
                # a second table in one step: the first line of another step is damaged
                yield step
                step = _Step(step.number, step.type)
            step.names = [name.strip() for name in line.split("\t")]
        elif _ROW.match(line) and (step.names or line.count("\t") >= _FEWEST_TABS_OF_ROW):
            step.row_lines.append(line)
    if step is not None:
        yield step


def _table(step: _Step, run_name: str, has_cut_row: bool) -> LoggedTable:
    """A step as a table: the sampled columns with the surface speeds, then the other columns.

    Args:
        step: The step.
        run_name: Name of the run in the file.
        has_cut_row: Whether the last row has no line end.
    """
    index_of_column = _index_of_column(step.names)
    cells_by_row = [row.split("\t") for row in step.row_lines]
    values_of_column = _values_of_columns(cells_by_row, index_of_column)
    sampled_columns = [
        column
        for column in _DECLARATION_OF_SAMPLED_COLUMN
        if column in index_of_column or column in _SURFACE_SPEEDS
    ]
    sampled_names: list[str] = []
    sampled_units: list[str] = []
    logged_columns: list[LoggedColumn] = []
    for index, column in enumerate(sampled_columns):
        declaration = _DECLARATION_OF_SAMPLED_COLUMN[column]
        unit = declaration["logged"]
        name = f"{column} (mean)"
        if column in index_of_column:
            name = step.names[index_of_column[column]]
        sampled_names.append(name)
        sampled_units.append(unit)
        is_spare = index >= _NEVER_BLANK_COUNT
        logged_columns.append(
            LoggedColumn(
                column,
                index,
                conversion(unit, (declaration["sampled"],)),
                name,
                unit,
                is_spare=is_spare,
            )
        )
    other_names = list(dict.fromkeys(name for name in step.names if name not in sampled_names))
    names = [*sampled_names, *other_names]
    # only compared with the number of names; 0 would say that the last row has a line end
    missing_cell_count = len(step.names) - len(cells_by_row[-1])
    cut_row_cell_count = max(len(names) - missing_cell_count, 1) if has_cut_row else 0
    missing_names = [
        _DECLARATION_OF_COLUMN[column]["names"][0]
        for column in _NEEDED_COLUMNS
        if column not in index_of_column
    ]
    return LoggedTable(
        {"log_kind": base.SETTLED_LOG_KIND},
        names,
        [*sampled_units, *[""] * len(other_names)],
        lambda column_indices: [
            values_of_column[sampled_columns[index]] for index in column_indices
        ],
        len(cells_by_row),
        run_name,
        columns=logged_columns,
        problem=_problem(step, missing_names),
        cut_row_cell_count=cut_row_cell_count,
        show_row=step.row_lines.__getitem__,
        is_contradictory=_is_contradictory(
            values_of_column, _last_digit_of_columns(cells_by_row, index_of_column)
        ),
    )


def _index_of_column(names: Sequence[str]) -> dict[str, int]:
    """Column of `pcs.yaml` -> its index in a table of a step."""
    # the first columns of a table repeat later ones: the last one of a name counts
    index_of_name = {name: index for index, name in enumerate(names)}
    index_of_column: dict[str, int] = {}
    for column, declaration in _DECLARATION_OF_COLUMN.items():
        for name in declaration["names"]:
            if name in index_of_name:
                index_of_column[column] = index_of_name[name]
    return index_of_column


def _values_of_columns(
    cells_by_row: Sequence[Sequence[str]], index_of_column: Mapping[str, int]
) -> dict[str, FloatArray]:
    """Column of `pcs.yaml`, or surface speed -> its numbers, shape (rows,).

    The time is NaN in rows that cannot be used.
    """
    values_of_column = {
        column: np.full(len(cells_by_row), np.nan) for column in _DECLARATION_OF_COLUMN
    }
    for column, index in index_of_column.items():
        values_of_column[column] = np.array([_number(row, index) for row in cells_by_row])
    values_of_column["ball_speed"], values_of_column["disc_speed"] = _surface_speeds(
        values_of_column
    )
    is_usable = np.ones(len(cells_by_row), dtype=bool)
    for numbers in values_of_column.values():
        is_usable &= ~(np.abs(numbers) > base.LARGEST_READING)
    for column in _NEEDED_COLUMNS:
        is_usable &= ~np.isnan(values_of_column[column])
    values_of_column["time"] = np.where(is_usable, values_of_column["time"], np.nan)
    return values_of_column


def _problem(step: _Step, missing_names: Sequence[str]) -> base.Refusal | None:
    """Why nothing of a step can be read; None where it can."""
    if step.type.lower() not in _SWEEP_TYPES:
        return base.Refusal(
            "not_a_sweep",
            f"step {step.number} is of type {step.type[:60]!r}; expected a traction or film sweep",
            "Nothing to do: such rows carry no traction curve.",
        )
    if missing_names:
        reason = f"step {step.number} lacks the columns {', '.join(missing_names)}"
        return base.Refusal("columns", reason, "Export the step again with all columns.")
    return None


def _number(cells: Sequence[str], index: int) -> float:
    """The number in a cell; NaN where it is blank or missing, infinity where it holds none."""
    if index >= len(cells) or not cells[index].strip():
        return np.nan
    try:
        return base.parse_number(cells[index])
    except ValueError:
        return np.inf


def _last_digit_of_columns(
    cells_by_row: Sequence[Sequence[str]], index_of_column: Mapping[str, int]
) -> dict[str, float]:
    """Column of `pcs.yaml` -> value of one in its last digit: by its cell with most decimals.

    It is at least that of `_LAST_DIGIT_OF_COLUMN`.
    """
    last_digit_of_column = dict.fromkeys(_DECLARATION_OF_COLUMN, 0.0) | _LAST_DIGIT_OF_COLUMN
    for column, index in index_of_column.items():
        cells = [row[index] for row in cells_by_row if index < len(row)]
        most_decimals = max(map(_decimal_count, cells), default=-1)
        if most_decimals >= 0:
            last_digit_of_column[column] = max(last_digit_of_column[column], 10.0**-most_decimals)
    return last_digit_of_column


def _decimal_count(cell: str) -> int:
    """Number of decimals of a number in a cell; -1 where it holds none."""
    try:
        exponent = Decimal(cell.strip()).as_tuple().exponent
    except InvalidOperation:
        return -1
    return max(-exponent, 0) if isinstance(exponent, int) else -1


def _is_contradictory(
    values_of_column: Mapping[str, FloatArray], last_digit_of_column: Mapping[str, float]
) -> BoolArray:
    """Mask of the rows that contradict themselves by more than the rounding of their cells.

    TF = (TF1 - TF2)/2; coefficient = |TF|/W; rolling = mean surface speed; sliding = disc minus
    ball, directions averaged; SRR = 100 sliding/rolling. Identities with a blank cell are not
    judged. The error of a cell is half of its last digit at most.

    Args:
        values_of_column: Column of `pcs.yaml`, or surface speed -> its numbers.
        last_digit_of_column: As `_last_digit_of_columns` gives it.
    """
    ball, disc = values_of_column["ball_speed"], values_of_column["disc_speed"]
    rolling, sliding, srr = (
        values_of_column["rolling"],
        values_of_column["sliding"],
        values_of_column["srr"],
    )
    # largest rounding error of a cell, by its column
    half_digit = {column: last_digit / 2 for column, last_digit in last_digit_of_column.items()}
    half_difference_rounding = max(half_digit["traction_force_1"], half_digit["traction_force_2"])
    # a surface speed is one cell, or the mean of two
    speed_rounding = max(half_digit[column] for column in ("ball_1", "ball_2", "disc_1", "disc_2"))
    force, load = values_of_column["traction_force"], values_of_column["load"]
    coefficient = values_of_column["coefficient"]
    with np.errstate(divide="ignore", invalid="ignore"):
        half_difference = (
            values_of_column["traction_force_1"] - values_of_column["traction_force_2"]
        ) / 2
        srr_rounding = (100 * half_digit["sliding"] + half_digit["rolling"] * np.abs(srr)) / np.abs(
            rolling
        ) + half_digit["srr"]
        coefficient_rounding = half_digit["coefficient"] + (
            half_digit["traction_force"] + half_digit["load"] * coefficient
        ) / np.abs(load)
        # each identity with the largest error from the rounding of its cells
        errors_of_identities = (
            (force - half_difference, half_digit["traction_force"] + half_difference_rounding),
            (np.abs(force) / load - coefficient, coefficient_rounding),
            (rolling - (ball + disc) / 2, half_digit["rolling"] + speed_rounding),
            (sliding - (disc - ball), half_digit["sliding"] + 2 * speed_rounding),
            (srr - 100 * sliding / rolling, srr_rounding),
        )
        is_violated = [
            np.abs(difference) > rounding + _FLOATING_POINT_ERROR
            for difference, rounding in errors_of_identities
        ]
    return np.asarray(np.any(is_violated, axis=0))


def _surface_speeds(values_of_column: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Speeds of ball and disc in mm/s, as if the disc were the faster body in both directions."""
    is_measured_both_ways = ~np.isnan(values_of_column["ball_2"]) & ~np.isnan(
        values_of_column["disc_2"]
    )
    slower_mm_s = np.where(
        is_measured_both_ways,
        (values_of_column["ball_1"] + values_of_column["disc_2"]) / 2,
        values_of_column["ball_1"],
    )
    faster_mm_s = np.where(
        is_measured_both_ways,
        (values_of_column["disc_1"] + values_of_column["ball_2"]) / 2,
        values_of_column["disc_1"],
    )
    return slower_mm_s, faster_mm_s
