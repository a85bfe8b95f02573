"""The runs that one table of a log holds: by a column that names them, and by restarts of time.

A format gives tables: groups, segments, sheets, blocks with a header of their own. This module
finds the runs within a table, for every format.

Decides: which rows of a table are a run.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pandas as pd

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.logs import base, header
from oilfilm.logs.log_kind import Meanings, Vocabulary
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
        kind: `oil`, `rig`, `run` or `step`.
        key: Name of the column, in the form in which names are compared.
        names: Its different texts, in the order of their first rows.
        codes: Index of the name of each row, shape (rows,).
    """

    kind: str
    key: str
    names: Sequence[str]
    codes: IndexArray


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
    if table.columns or table.problem or table.rows == 0:
        return [table]
    meanings = vocabulary.meanings(table.names, table.units)
    labels = _label_columns(table, meanings, settings)
    parts = _by_labels(table, labels)
    runs = [run for part in parts for run in _by_restarts(part, meanings)]
    if len(runs) == 1:
        return [part.with_name(table.run_name) for part in runs]
    names = base.distinct_names(
        " ".join(filter(None, [table.run_name, run.run_name])) for run in runs
    )
    return [run.with_name(name) for run, name in zip(runs, names, strict=True)]


def _label_columns(
    table: LoggedTable, meanings: Meanings, settings: Settings
) -> list[_LabelColumn]:
    """The columns that name runs, the more general kinds first."""
    labels: list[_LabelColumn] = []
    if table.texts is None:
        return labels
    key_by_listed_name = header.listed_names(settings)
    has_numbers: BoolArray | None = None
    for index, name in enumerate(table.names):
        bare_name, unit = header.split_unit(name)
        key = plain_key(bare_name)
        kind = _kind_of_label(key, key_by_listed_name)
        if not kind or unit or table.units[index] or index in meanings:
            continue
        if has_numbers is None:
            has_numbers = _has_numbers(table, meanings)
        label = _label_column(kind, key, table.texts(index), has_numbers)
        if _divides(label) and (kind != "step" or _steps_sweep(table, meanings, label)):
            labels.append(label)
    kinds = ("run", "step", "rig", "oil")
    return sorted(labels, key=lambda label: kinds.index(label.kind))


def _kind_of_label(key: str, key_by_listed_name: Mapping[str, str]) -> str:
    """`oil`, `rig`, `run` or `step` by the key of a column; empty for another column."""
    meaning = key_by_listed_name.get(key, key)
    if meaning in ("oil", "rig", "run"):
        return meaning
    if header.oil_key({key: "x"}):
        return "oil"
    words = frozenset(key.rstrip(".").split("_")) - _NUMBER_WORDS
    if len(words) != 1:
        return ""
    if words <= _RUN_WORDS:
        return "run"
    return "step" if words <= _STEP_WORDS else ""


def _has_numbers(table: LoggedTable, meanings: Meanings) -> BoolArray:
    """Rows with a number in some column that is read, shape (rows,)."""
    has_numbers = np.zeros(table.rows, dtype=bool)
    for values in table.values(list(meanings)):
        if values.dtype.kind in "iuf":
            has_numbers |= np.isfinite(values)
    return has_numbers


def _label_column(kind: str, key: str, texts: Texts, has_numbers: BoolArray) -> _LabelColumn:
    """A column of labels. An empty cell, or that of a row without numbers, is as the one above."""
    cells = pd.Series(texts, dtype=object)
    is_name = (cells != "") & has_numbers
    # rows above the first text belong to it
    filled = cells.where(is_name).ffill().bfill().fillna("")
    codes, names = pd.factorize(filled)
    return _LabelColumn(kind, key, list(names), codes.astype(np.int64))


def _divides(label: _LabelColumn) -> bool:
    """Whether the texts of a label are names: not numbers with decimals, a flag or a counter."""
    if any(_has_decimals(name) for name in label.names):
        return False
    if label.kind in ("oil", "rig"):
        return any(label.names)
    if len(label.names) < 2 or set(label.names) <= {"0", "1"}:
        return False
    # a run is one stretch of rows, and longer than a fault
    starts = np.flatnonzero(np.diff(label.codes, prepend=-1))
    lengths = np.diff(np.append(starts, len(label.codes)))
    return len(starts) == len(label.names) and int(lengths.min()) >= _FEWEST_ROWS


def _has_decimals(text: str) -> bool:
    try:
        return not base.parse_decimal(text).is_integer()
    except (ValueError, OverflowError):
        return False


def _steps_sweep(table: LoggedTable, meanings: Meanings, label: _LabelColumn) -> bool:
    """Whether the slip of each step covers a good share of the range of all steps."""
    slip = _slip_or_like(table, meanings)
    if slip is None:
        return False
    is_finite = np.isfinite(slip)
    if not is_finite.any():
        return False
    whole_range = np.ptp(slip[is_finite])
    for code in range(len(label.names)):
        slip_of_step = slip[(label.codes == code) & is_finite]
        if len(slip_of_step) < _FEWEST_ROWS or np.ptp(slip_of_step) < _SHARE_OF_SWEEP * whole_range:
            return False
    return True


def _slip_or_like(table: LoggedTable, meanings: Meanings) -> FloatArray | None:
    """The slide-roll ratio as logged, or the logarithm of the ratio of both speeds; shape (rows,).

    Units and radii change neither the share of a range.
    """
    index_by_quantity = {quantity: index for index, (quantity, _) in meanings.items()}
    if "slide_roll_ratio" in index_by_quantity:
        (slip,) = table.values([index_by_quantity["slide_roll_ratio"]])
        return slip.astype(float) if slip.dtype.kind in "iuf" else None
    if not {"ball_speed", "disc_speed"} <= index_by_quantity.keys():
        return None
    ball, disc = table.values([index_by_quantity["ball_speed"], index_by_quantity["disc_speed"]])
    if ball.dtype.kind not in "iuf" or disc.dtype.kind not in "iuf":
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(np.abs(disc / ball)))


def _by_labels(table: LoggedTable, labels: Sequence[_LabelColumn]) -> list[LoggedTable]:
    """A table for each combination of labels, in the order of their first rows."""
    if not labels:
        return [table.with_name("")]
    codes = pd.MultiIndex.from_arrays([label.codes for label in labels])
    combination_of_row, combinations = pd.factorize(codes)
    texts_by_combination = [
        tuple(label.names[code] for label, code in zip(labels, combination, strict=True))
        for combination in combinations
    ]
    if len(texts_by_combination) > _MOST_RUNS:
        listed = ", ".join(repr(label.key) for label in labels)
        reason = (
            f"the columns {listed} name {len(texts_by_combination)} runs; expected at most "
            f"{_MOST_RUNS}"
        )
        problem = base.Refusal("columns", reason, "Rename a column that names no runs.")
        return [replace(table, run_name="", problem=problem)]
    labels_in_name = _fewest_that_differ(texts_by_combination)
    rows_by_part = np.split(
        np.argsort(combination_of_row, kind="stable"),
        np.cumsum(np.bincount(combination_of_row))[:-1],
    )
    parts: list[LoggedTable] = []
    for texts, rows in zip(texts_by_combination, rows_by_part, strict=True):
        keys = dict(table.keys)
        for label, text in zip(labels, texts, strict=True):
            # the name of a run in its file need not differ from those of other files
            if label.kind in ("oil", "rig") and text:
                stated = keys.get(label.kind) or _stated_oil(label, keys) or text
                keys[label.kind] = _joined(stated, text)
        parts.append(table.part(rows, " ".join(texts[:labels_in_name]), keys))
    return parts


def _fewest_that_differ(combinations: Sequence[tuple[str, ...]]) -> int:
    """How many of the first texts tell all combinations apart."""
    width = len(combinations[0])
    for label_count in range(width):
        if len({texts[:label_count] for texts in combinations}) == len(combinations):
            return label_count
    return width


def _stated_oil(label: _LabelColumn, keys: Mapping[str, str]) -> str:
    """The oil that a header line such as `lubricant` states; empty without one."""
    key = header.oil_key(keys) if label.kind == "oil" else None
    return keys[key] if key else ""


def _joined(stated: str, text: str) -> str:
    """One text, or both where header and column differ: what needs the key refuses the run."""
    return text if plain_key(stated) == plain_key(text) else f"{stated} / {text}"


def _by_restarts(table: LoggedTable, meanings: Meanings) -> list[LoggedTable]:
    """A table for each stretch of rows at whose start time begins anew."""
    if table.problem:
        return [table]
    time_index = next(
        (index for index, (quantity, _) in meanings.items() if quantity == "time"), None
    )
    if time_index is None:
        return [table]
    # all columns at once: a text is parsed as a whole
    indices = list(meanings)
    time = table.values(indices)[indices.index(time_index)]
    if time.dtype.kind not in "iuf":
        return [table]
    starts = _restarts(time.astype(np.float64, copy=False))
    bounds = [0, *starts, table.rows]
    if len(starts) == 0 or min(np.diff(bounds)) < _FEWEST_ROWS:
        return [table]
    parts: list[LoggedTable] = []
    for number, (start, stop) in enumerate(pairwise(bounds), start=1):
        name = " ".join(filter(None, [table.run_name, f"part{number}"]))
        parts.append(table.part(np.arange(start, stop), name, table.keys))
    return parts


def _restarts(time: FloatArray) -> list[int]:
    """Rows at which time falls back to its first value, or to zero, and rises again from there.

    A row or two with a wrong time are no restart.
    """
    rows_with_time = np.flatnonzero(np.isfinite(time))
    times = time[rows_with_time]
    steps = np.diff(times)
    rising = steps[steps > 0]
    if len(rising) == 0:
        return []
    tolerance = _INTERVALS_AT_RESTART * float(np.median(rising))
    restarts: list[int] = []
    start = 0
    for row in np.flatnonzero(steps < 0) + 1:
        next_times = times[row : row + _FEWEST_ROWS]
        # a clock that is set falls to any other time
        falls_to_start = min(abs(times[row]), abs(times[row] - times[start])) <= tolerance
        rises = bool((np.diff(next_times) > 0).all()) and next_times[-1] < times[row - 1]
        if falls_to_start and rises and len(next_times) == _FEWEST_ROWS:
            restarts.append(int(rows_with_time[row]))
            start = int(row)
    return restarts
