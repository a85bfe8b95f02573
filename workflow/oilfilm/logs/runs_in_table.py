"""The runs that one table of a log holds: by a column that names them, and by restarts of time.

A format gives tables: groups, segments, sheets, blocks with a header of their own. This module
finds the runs within a table, for every format.

Decides: which rows of a table are a run.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pandas as pd

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.logs import base, header
from oilfilm.logs.log_schema import QuantitiesAndUnits, Vocabulary
from oilfilm.logs.logged_table import LoggedTable, Texts
from oilfilm.settings.resolved import Settings

# Words that name a column of runs. The words of oils are those of header lines.
_RUN_WORDS = frozenset(
    "run test lauf versuch messung essai prueba ensayo prova curve kurve".split()
    + "试验 試験 試験番号 опыт".split()
)
_STEP_WORDS = frozenset("step stage schritt stufe étape etape paso passo шаг".split())
_NUMBER_WORDS = frozenset("no nr number id n°".split())
# A shorter stretch of rows is a fault of the clock or of a label, not a run.
_FEWEST_ROWS = 3
# A column with more different texts was not meant to name runs.
_MOST_RUNS = 1000
# Time begins anew where it falls back to its first value, within so many sampling intervals.
_INTERVALS_AT_RESTART = 2
# A step is a run of its own where its slip covers at least this share of the range of all steps.
_SHARE_OF_SWEEP = 0.5


@dataclass(frozen=True)
class _LabelColumn:
    """A column whose text names the run of a row.

    Attributes:
        label_kind: `oil`, `rig`, `run` or `step`.
        key: Name of the column, in the form in which names are compared.
        names: Its different texts, in the order of their first rows.
        name_index_of_row: Index of the name of each row, shape (rows,).
    """

    label_kind: str
    key: str
    names: Sequence[str]
    name_index_of_row: IndexArray


def runs_in_table(
    table: LoggedTable, vocabulary: Vocabulary, settings: Settings
) -> list[LoggedTable]:
    """The runs of a table, each with its name and its keys; the table itself where it is one run.

    - A column `oil` or `rig` gives each row its oil and rig.
    - A column `run`, `test` or the like divides the rows. A column `step` does so only where each
      step sweeps the slip itself: in most logs a step is one level of slip.
    - Time that begins anew divides the rows.

    Args:
        table: The table.
        vocabulary: What the names of its columns mean.
        settings: Settings with the names of header keys and oils.
    """
    if table.columns or table.problem or table.row_count == 0:
        return [table]
    quantities_and_units = vocabulary.quantities_and_units(table.names, table.units)
    label_columns = _label_columns(table, quantities_and_units, settings)
    tables_of_labels = _tables_by_label(table, label_columns)
    run_tables = [
        run_table
        for table_of_labels in tables_of_labels
        for run_table in _tables_by_restart(table_of_labels, quantities_and_units)
    ]
    if len(run_tables) == 1:
        return [run_table.with_name(table.run_name) for run_table in run_tables]
    names = base.distinct_names(
        _joined_names(table.run_name, run_table.run_name) for run_table in run_tables
    )
    named_tables: list[LoggedTable] = []
    for run_table, name in zip(run_tables, names, strict=True):
        undivided_names = [
            _joined_names(table.run_name, undivided_name)
            for undivided_name in run_table.undivided_names
        ]
        undivided_names += table.run_names
        named_tables.append(
            replace(run_table, run_name=name, undivided_names=tuple(undivided_names))
        )
    return named_tables


def _joined_names(*names: str) -> str:
    """The name of a part: that of the whole, then its own; either may be empty."""
    return " ".join(filter(None, names))


def _label_columns(
    table: LoggedTable, quantities_and_units: QuantitiesAndUnits, settings: Settings
) -> list[_LabelColumn]:
    """The columns that name runs: those of runs and steps first, then of rigs and oils."""
    label_columns: list[_LabelColumn] = []
    if table.read_texts is None:
        return label_columns
    key_by_listed_name = header.key_by_listed_name(settings)
    has_number: BoolArray | None = None
    for index, name in enumerate(table.names):
        bare_name, unit = header.split_bracketed_unit(name)
        key = plain_key(bare_name)
        label_kind = _label_kind(key, key_by_listed_name)
        if not label_kind or unit or table.units[index] or index in quantities_and_units:
            continue
        if has_number is None:
            has_number = _has_number(table, quantities_and_units)
        label_column = _label_column(label_kind, key, table.read_texts(index), has_number)
        is_settled = table.text_of_key.get("log_kind") == base.SETTLED_LOG_KIND
        if _can_name_runs(label_column, is_settled=is_settled) and (
            label_kind != "step"
            or _is_sweep_in_each_step(table, quantities_and_units, label_column)
        ):
            label_columns.append(label_column)
    label_kinds = ("run", "step", "rig", "oil")
    return sorted(
        label_columns, key=lambda label_column: label_kinds.index(label_column.label_kind)
    )


def _label_kind(key: str, key_by_listed_name: Mapping[str, str]) -> str:
    """`oil`, `rig`, `run` or `step` by the key of a column; empty for another column."""
    project_key = key_by_listed_name.get(key, key)
    if project_key in ("oil", "rig", "run"):
        return project_key
    if header.oil_synonym_key({key: "x"}):
        return "oil"
    words = frozenset(key.rstrip(".").split("_")) - _NUMBER_WORDS
    if len(words) != 1:
        return ""
    if words <= _RUN_WORDS:
        return "run"
    return "step" if words <= _STEP_WORDS else ""


def _has_number(table: LoggedTable, quantities_and_units: QuantitiesAndUnits) -> BoolArray:
    """Rows with a number in some column that is read, shape (rows,)."""
    has_number = np.zeros(table.row_count, dtype=bool)
    for values in table.read_values(list(quantities_and_units)):
        if values.dtype.kind in "iuf":
            has_number |= np.isfinite(values)
    return has_number


def _label_column(label_kind: str, key: str, texts: Texts, has_number: BoolArray) -> _LabelColumn:
    """A column of labels. An empty cell, or one in a row without numbers, has the text above it."""
    cells = pd.Series(texts, dtype=object)
    is_name = (cells != "") & has_number
    # rows above the first text belong to it
    filled = cells.where(is_name).ffill().bfill().fillna("")
    name_index_of_row, names = pd.factorize(filled)
    return _LabelColumn(label_kind, key, list(names), name_index_of_row.astype(np.int64))


def _can_name_runs(label_column: _LabelColumn, *, is_settled: bool) -> bool:
    """Whether the texts of a column name runs: no numbers with decimals, no flag, no counter.

    Args:
        label_column: The column.
        is_settled: Whether the rows are settled readings: a run may have few of them. Where no run
            has more, the column counts the readings.
    """
    if any(_has_decimals(name) for name in label_column.names):
        return False
    if label_column.label_kind in ("oil", "rig"):
        return any(label_column.names)
    if len(label_column.names) < 2 or set(label_column.names) <= {"0", "1"}:
        return False
    # a run is one stretch of rows, and longer than a fault
    starts = np.flatnonzero(np.diff(label_column.name_index_of_row, prepend=-1))
    lengths = np.diff(np.append(starts, len(label_column.name_index_of_row)))
    decisive_length = int(lengths.max() if is_settled else lengths.min())
    return len(starts) == len(label_column.names) and decisive_length >= _FEWEST_ROWS


def _has_decimals(text: str) -> bool:
    try:
        number = base.parse_decimal(text)
    except ValueError:
        return False
    # `nan` is the label of a run that has none
    return math.isfinite(number) and not number.is_integer()


def _is_sweep_in_each_step(
    table: LoggedTable, quantities_and_units: QuantitiesAndUnits, label_column: _LabelColumn
) -> bool:
    """Whether the slip of each step covers a good share of the range of all steps."""
    slip = _slip_or_log_speed_ratio(table, quantities_and_units)
    if slip is None:
        return False
    is_finite = np.isfinite(slip)
    if not is_finite.any():
        return False
    whole_range = np.ptp(slip[is_finite])
    if whole_range == 0:
        return False
    for name_index in range(len(label_column.names)):
        slip_of_step = slip[(label_column.name_index_of_row == name_index) & is_finite]
        if len(slip_of_step) < _FEWEST_ROWS or np.ptp(slip_of_step) < _SHARE_OF_SWEEP * whole_range:
            return False
    return True


def _slip_or_log_speed_ratio(
    table: LoggedTable, quantities_and_units: QuantitiesAndUnits
) -> FloatArray | None:
    """The slide-roll ratio as logged, or the logarithm of the ratio of both speeds; shape (rows,).

    Units and radii do not change the share of a range.
    """
    index_by_quantity = {quantity: index for index, (quantity, _) in quantities_and_units.items()}
    if "slide_roll_ratio" in index_by_quantity:
        (slip,) = table.read_values([index_by_quantity["slide_roll_ratio"]])
        return slip.astype(float) if slip.dtype.kind in "iuf" else None
    if not {"ball_speed", "disc_speed"} <= index_by_quantity.keys():
        return None
    ball, disc = table.read_values(
        [index_by_quantity["ball_speed"], index_by_quantity["disc_speed"]]
    )
    if ball.dtype.kind not in "iuf" or disc.dtype.kind not in "iuf":
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(np.abs(disc / ball)))


def _tables_by_label(
    table: LoggedTable, label_columns: Sequence[_LabelColumn]
) -> list[LoggedTable]:
    """A table for each run, in the order of their first rows."""
    if not label_columns:
        return [table.with_name("")]
    name_indices_of_row = pd.MultiIndex.from_arrays(
        [label_column.name_index_of_row for label_column in label_columns]
    )
    run_index_of_row, name_indices_of_runs = pd.factorize(name_indices_of_row)
    labels_of_runs = [
        tuple(
            label_column.names[name_index]
            for label_column, name_index in zip(label_columns, name_indices, strict=True)
        )
        for name_indices in name_indices_of_runs
    ]
    if len(labels_of_runs) > _MOST_RUNS:
        keys_in_words = ", ".join(repr(label_column.key) for label_column in label_columns)
        reason = (
            f"the columns {keys_in_words} name {len(labels_of_runs)} runs; expected at most "
            f"{_MOST_RUNS}"
        )
        problem = base.Refusal("columns", reason, "Rename a column that names no runs.")
        return [replace(table, run_name="", problem=problem)]
    label_count_in_name = _label_count_that_tells_apart(labels_of_runs)
    row_indices_of_runs = np.split(
        np.argsort(run_index_of_row, kind="stable"), np.cumsum(np.bincount(run_index_of_row))[:-1]
    )
    tables_of_runs: list[LoggedTable] = []
    for labels, row_indices in zip(labels_of_runs, row_indices_of_runs, strict=True):
        text_of_key = dict(table.text_of_key)
        for label_column, label in zip(label_columns, labels, strict=True):
            # the name of a run in its file need not differ from those of other files
            if label_column.label_kind in ("oil", "rig") and label:
                stated_text = (
                    text_of_key.get(label_column.label_kind)
                    or _stated_oil(label_column, text_of_key)
                    or label
                )
                text_of_key[label_column.label_kind] = _stated_text_and_label(stated_text, label)
        run_name = " ".join(labels[:label_count_in_name])
        # a name of fewer labels is that of several runs together
        undivided_names = tuple(
            " ".join(labels[:label_count]) for label_count in range(1, label_count_in_name)
        )
        run_table = table.select_rows(row_indices, run_name, text_of_key)
        tables_of_runs.append(replace(run_table, undivided_names=undivided_names))
    return tables_of_runs


def _label_count_that_tells_apart(labels_of_runs: Sequence[tuple[str, ...]]) -> int:
    """Number of first columns whose labels tell all runs apart."""
    column_count = len(labels_of_runs[0])
    for label_count in range(column_count):
        if len({labels[:label_count] for labels in labels_of_runs}) == len(labels_of_runs):
            return label_count
    return column_count


def _stated_oil(label_column: _LabelColumn, text_of_key: Mapping[str, str]) -> str:
    """The oil that a header line such as `lubricant` states; empty without one."""
    key = header.oil_synonym_key(text_of_key) if label_column.label_kind == "oil" else None
    return text_of_key[key] if key else ""


def _stated_text_and_label(stated_text: str, label: str) -> str:
    """The label, or both where header and column differ: what needs the key refuses the run."""
    is_same = plain_key(stated_text) == plain_key(label)
    return label if is_same else f"{stated_text} / {label}"


def _tables_by_restart(
    table: LoggedTable, quantities_and_units: QuantitiesAndUnits
) -> list[LoggedTable]:
    """A table for each stretch of rows at whose start time begins anew."""
    if table.problem:
        return [table]
    time_index = next(
        (index for index, (quantity, _) in quantities_and_units.items() if quantity == "time"), None
    )
    if time_index is None:
        return [table]
    # all columns at once: a text is parsed as a whole
    indices = list(quantities_and_units)
    time = table.read_values(indices)[indices.index(time_index)]
    if time.dtype.kind not in "iuf":
        return [table]
    start_rows = _rows_of_restarts(time.astype(np.float64, copy=False))
    row_bounds = [0, *start_rows, table.row_count]
    if len(start_rows) == 0 or min(np.diff(row_bounds)) < _FEWEST_ROWS:
        return [table]
    tables_of_parts: list[LoggedTable] = []
    for number, (start, stop) in enumerate(pairwise(row_bounds), start=1):
        name = _joined_names(table.run_name, f"part{number}")
        table_of_part = table.select_rows(np.arange(start, stop), name, table.text_of_key)
        tables_of_parts.append(replace(table_of_part, undivided_names=table.run_names))
    return tables_of_parts


def _rows_of_restarts(time: FloatArray) -> list[int]:
    """Rows at which time falls back to its first value, or to zero, and rises again from there.

    A row or two with a wrong time are no restart.
    """
    rows_with_time = np.flatnonzero(np.isfinite(time))
    times = time[rows_with_time]
    differences = np.diff(times)
    intervals = differences[differences > 0]
    if len(intervals) == 0:
        return []
    tolerance = _INTERVALS_AT_RESTART * float(np.median(intervals))
    restart_rows: list[int] = []
    # indices among the rows with a time
    start_index = 0
    for index in np.flatnonzero(differences < 0) + 1:
        next_times = times[index : index + _FEWEST_ROWS]
        # a clock that is set falls to any other time
        falls_to_start = min(abs(times[index]), abs(times[index] - times[start_index])) <= tolerance
        rises = bool((np.diff(next_times) > 0).all()) and next_times[-1] < times[index - 1]
        if falls_to_start and rises and len(next_times) == _FEWEST_ROWS:
            restart_rows.append(int(rows_with_time[index]))
            start_index = int(index)
    return restart_rows
