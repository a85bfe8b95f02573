"""From the columns of a log to its run: what all formats share.

A format finds names, units, header keys and numbers. This module and the kind of log do the rest.

Decides: which rows are refused for their cells.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
import pandas as pd

from oilfilm.base.errors import printable
from oilfilm.base.units import ABSOLUTE_ZERO_C, BoolArray, FloatArray, IndexArray
from oilfilm.logs import base
from oilfilm.logs.clocks import with_time
from oilfilm.logs.log_kind import Column, LogKind, UsableLog, Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile, Texts, Values
from oilfilm.logs.run_sheet import Labels, RunSheet
from oilfilm.logs.runs_in_table import runs_in_table
from oilfilm.logs.text_rows import DAY
from oilfilm.settings.resolved import Settings

# Limits of what the columns of a log can hold. They belong to reading, before a campaign is judged
# by its settings.
# No oil is liquid at this temperature; its properties have no meaning.
_HOTTEST_C = 1000.0
# Time may be counted from 1970, in milliseconds too.
_LARGEST_TIME = 1e13
# The sampling rate is compared between blocks of rows. It has changed where some blocks differ from
# the first one by more than this ratio.
_ROWS_PER_BLOCK = 50
_FEWEST_BLOCKS = 2
_LARGEST_RATE_RATIO = 1.5
# Share of refused rows from which the decimal mark of the file is in doubt.
_MANY_ROWS_SHARE = 0.05
# Keys that have columns of their own in the table of runs.
_KEYS_WITH_COLUMN = frozenset({"oil", "rig", "log_kind", "run", *base.SET_POINT_KEYS})
_MOST_STATED_KEYS = 30
# Of the columns of a log that the table of runs names.
_MOST_NAMES, _LONGEST_NAME = 200, 100
_NOTE_ADVICE = "Nothing to do if that is right."
ROWS_ADVICE = "Look at these rows of the raw log; the rows around them are used."


def read_tables(
    tables_of_file: TablesOfFile, file: str, settings: Settings, kind: LogKind, sheet: RunSheet
) -> base.Reading:
    """The runs in the tables of a file, and what was refused of them."""
    form = tables_of_file[0]
    rows = 0
    reading = base.Reading(0, form=form)
    run_names: list[str] = []
    context = _Context(file, form, settings, kind, sheet)
    for table in tables_of_file[1]:
        run_tables = _runs_in(table, settings, kind)
        for run_table in run_tables:
            run_names += _read_run(run_table, rows + 1, reading, context)
        rows += sum(run_table.rows for run_table in run_tables)
    refusals = [*reading.refusals, *sheet.unmatched_rows(file, run_names)]
    return replace(reading, rows=rows, refusals=refusals)


def _runs_in(table: LoggedTable, settings: Settings, kind: LogKind) -> list[LoggedTable]:
    """The runs in a table, with its time. Its columns are converted once for all of them."""
    vocabulary = kind.vocabulary_of(settings.campaign)
    table = with_time(table, vocabulary)
    converted: dict[int, Values] = {}

    def values(indices: Sequence[int]) -> list[Values]:
        not_yet_converted = [index for index in indices if index not in converted]
        if not_yet_converted:
            converted.update(zip(not_yet_converted, table.values(not_yet_converted), strict=True))
        return [converted[index] for index in indices]

    return runs_in_table(replace(table, values=values), vocabulary, settings)


@dataclass(frozen=True)
class _Context:
    """What the runs of one file share: its name, how its text is written, what judges them."""

    file: str
    form: base.TextForm
    settings: Settings
    kind: LogKind
    sheet: RunSheet


def _read_run(
    table: LoggedTable, first_row: int, reading: base.Reading, context: _Context
) -> list[str]:
    """Add the run of a table, or why it is refused, to the reading of its file.

    A run at several set points is added as several runs.

    Returns:
        The names of the runs in the file; none where the file is one run.
    """
    form, kind = context.form, context.kind
    read_as = "" if form.encoding in ("", "ascii") else f"; read as {form.encoding}"
    labels = context.sheet.labels(context.file, table.run_name, table.keys, context.settings)
    try:
        run, refused = _read_table(table, labels, first_row, form, context.settings, kind)
        parts = _parts_at_set_points(table, run, first_row, kind)
        if len(parts) > 1:
            return [name for part in parts for name in _read_run(part, first_row, reading, context)]
        reading.runs.append(run)
    except (ValueError, base.UnreadableLogError) as error:
        problem = base.Refusal("columns", f"{error}{read_as}", kind.vocabulary.advice)
        if isinstance(error, base.UnreadableLogError):
            problem = error.refusal
        problem = labels.with_exclusion(problem)
        run_id = labels.run_id if table.run_name else ""
        rows = base.unbroken_ranges(table.numbers_of_rows(first_row))
        # a table without rows is refused, too
        rows = rows or [(first_row, first_row - 1)]
        refused = [problem.of_rows(run_id, first, last) for first, last in rows]
    reading.refusals.extend(refused)
    reading.refusals.extend(labels.remarks)
    return [table.run_name] if table.run_name else []


def _parts_at_set_points(
    table: LoggedTable, run: base.LoggedRun, first_row: int, kind: LogKind
) -> list[LoggedTable]:
    """The parts of a run at different set points; the table itself where it has one."""
    # some formats say themselves what a run is
    rows_of_parts = [] if table.columns else kind.rows_of_set_points(run)
    if len(rows_of_parts) < 2:
        return [table]
    # rows that cannot be used belong to the part before them
    first_rows = [int(run.samples["row"][rows[0]]) for rows in rows_of_parts[1:]]
    split_indices = np.searchsorted(table.numbers_of_rows(first_row), first_rows)
    listed_rows = ", ".join(map(str, first_rows[:10]))
    note = (
        f"the load or the speed changes to another set point at row {listed_rows}; the rows "
        f"before and after are runs of their own"
    )
    parts: list[LoggedTable] = []
    for number, rows in enumerate(np.split(np.arange(table.rows), split_indices), start=1):
        name = f"{table.run_name} setpoint{number}".strip()
        part = table.part(rows, name, table.keys)
        parts.append(part.with_note(note))
    return parts


def _read_table(
    table: LoggedTable,
    labels: Labels,
    first_row: int,
    form: base.TextForm,
    settings: Settings,
    kind: LogKind,
) -> tuple[base.LoggedRun, list[base.Refusal]]:
    """The run of a table and the refusals of its rows.

    Raises:
        ValueError: Its columns cannot be understood.
        UnreadableLogError: Nothing of it can be used for another reason.
    """
    if table.problem:
        raise base.UnreadableLogError.from_refusal(table.problem)
    vocabulary = kind.vocabulary_of(settings.campaign)
    not_needed = kind.not_needed(labels.keys, settings)
    names, table = _without_twins(table, vocabulary)
    columns = table.columns or vocabulary.columns(names, table.units, not_needed)
    problems = chain([labels.problem], kind.header_problems(labels.keys, columns, settings))
    first_problem = next(filter(None, problems), None)
    if first_problem:
        raise base.UnreadableLogError.from_refusal(first_problem)
    logged = _numbers(table, columns)
    values, readable = _converted(logged)
    rows = table.numbers_of_rows(first_row)
    good, refusals = _good_rows(table, list(logged.values()), readable, rows)
    refusals += [base.Refusal(base.READING_NOTE, note, _NOTE_ADVICE) for note in table.notes]
    refusals = [replace(refusal, run_id=labels.run_id) for refusal in refusals]
    if not good.all():
        rows = rows[good]
        values = {quantity: numbers[good] for quantity, numbers in values.items()}
    log = UsableLog(
        labels.run_id,
        labels.keys,
        list(logged),
        rows,
        values,
        labels.excluded or _flaw(table, labels, rows, values, refusals, form),
        _understood(table, labels, logged),
    )
    return kind.run(log, settings), refusals


def _without_twins(table: LoggedTable, vocabulary: Vocabulary) -> tuple[list[str], LoggedTable]:
    """The names of a table, empty for a column that repeats an earlier one, and notes on these.

    Two columns of one quantity with the same numbers are one column.
    """
    names = list(table.names)
    if table.columns:
        return names, table
    first_by_quantity: dict[str, int] = {}
    notes: list[str] = []
    meanings = vocabulary.meanings(table.names, table.units)
    for index, (quantity, unit) in meanings.items():
        first_index = first_by_quantity.setdefault(quantity, index)
        if first_index == index or unit != meanings[first_index][1]:
            continue
        numbers, twin_numbers = table.values([first_index, index])
        if numbers.dtype.kind not in "iuf" or twin_numbers.dtype.kind not in "iuf":
            continue
        if np.array_equal(numbers, twin_numbers, equal_nan=True):
            notes.append(
                f"the columns {names[first_index][:60]!r} and {names[index][:60]!r} hold the same "
                "numbers; the first of them is used"
            )
            names[index] = ""
    return names, replace(table, notes=(*table.notes, *notes))


def _good_rows(
    table: LoggedTable, logged: Sequence[FloatArray], readable: BoolArray, rows: IndexArray
) -> tuple[BoolArray, list[base.Refusal]]:
    """Which rows can be used, shape (rows,), and the refusals of the others.

    Args:
        table: The table.
        logged: Its columns as logged, each of shape (rows,).
        readable: Rows whose cells hold usable numbers.
        rows: Row numbers in the file.
    """
    # a last row without a line end has a refusal of its own
    ended = np.ones(len(rows), dtype=bool)
    if table.cut_row_cells:
        ended[-1] = False
    refusals = [
        _refusal_of_unreadable_rows(table, logged, first, last, int(np.searchsorted(rows, first)))
        for first, last in base.unbroken_ranges(rows[ended & ~readable])
    ]
    good = readable & ended
    if table.contradictory is not None:
        contradictory = rows[good & table.contradictory]
        refusals += base.refused_ranges(
            "",
            contradictory,
            "identity_broken",
            "the row contradicts itself: speeds, slip, forces, coefficient disagree",
            "Look at these rows: a sensor or the export has failed there.",
        )
        good &= ~table.contradictory
    if table.cut_row_cells:
        refusals.append(_refusal_of_cut_row(table, int(rows[-1])))
    return good, refusals


def _flaw(
    table: LoggedTable,
    labels: Labels,
    rows: IndexArray,
    values: Mapping[str, FloatArray],
    refusals: Sequence[base.Refusal],
    form: base.TextForm,
) -> base.Refusal | None:
    """Why a run cannot be used by its rows; the first reason that is found, None without one.

    Args:
        table: The table.
        labels: What is known of the run.
        rows: Numbers of the good rows.
        values: Their values by quantity.
        refusals: The refusals of the other rows.
        form: How the text was read.
    """
    if table.flaw:
        return table.flaw
    for refusal in refusals:
        if refusal.rule == "cut_row":
            return replace(refusal, run_id="", rule="truncated")
    if "time" in values and labels.keys.get("log_kind") != "steps":
        rate_change = _rate_change(values["time"], rows)
        if rate_change:
            return rate_change
    return _two_decimal_marks(table, refusals, form)


def _understood(
    table: LoggedTable, labels: Labels, logged: Mapping[Column, FloatArray]
) -> base.Understood:
    """How the columns and the header of a run were understood."""
    read = {column.index for column in logged}
    return base.Understood(
        columns=[column.summary(numbers) for column, numbers in logged.items()],
        unused=[name for index, name in enumerate(table.names) if index not in read],
        sources=labels.sources,
        names=_names_with_units(table),
        stated=_stated(labels.keys),
    )


def _names_with_units(table: LoggedTable) -> tuple[str, ...]:
    """The columns of a log, each with the unit beside its name."""
    names: list[str] = []
    for name, unit in zip(table.names, table.units, strict=True):
        name_with_unit = f"{name} [{unit}]" if unit else name
        names.append(printable(name_with_unit)[:_LONGEST_NAME])
    return tuple(names[:_MOST_NAMES])


def _stated(keys: Mapping[str, str]) -> tuple[str, ...]:
    """What header and run sheet say beside oil, rig and set points; of a time stamp the day."""
    statements: list[str] = []
    for key, text in sorted(keys.items()):
        if not text or key in _KEYS_WITH_COLUMN:
            continue
        day = DAY.match(text)
        value = day[0] if day else text
        statements.append(printable(f"{key[:40]}={value[:60]}"))
    return tuple(statements[:_MOST_STATED_KEYS])


def _refusal_of_unreadable_rows(
    table: LoggedTable, logged: Sequence[FloatArray], first: int, last: int, index: int
) -> base.Refusal:
    """Refusal of rows with a bad cell, which shows the first of them.

    Args:
        table: The table.
        logged: Its columns as logged.
        first: Number of the first row in the file.
        last: Number of the last row in the file.
        index: Index of the first row in the table.
    """
    if table.show:
        row_text = table.show(index)
    else:
        row_text = ", ".join(f"{numbers[index]:g}" for numbers in logged)
    reason = (
        f"rows {first} to {last}: cells are missing, too many, not numbers or absurdly large; row "
        f"{first} reads {row_text[:80]!r}"
    )
    return base.Refusal("unreadable_row", reason, ROWS_ADVICE).of_rows("", first, last)


def _refusal_of_cut_row(table: LoggedTable, row: int) -> base.Refusal:
    """The refusal of a last row without a line end."""
    row_text = table.show(table.rows - 1) if table.show else ""
    zeros = row_text.count("\0")
    rule = "cut_row"
    last_good = f"(its last good row is {row - 1})"
    if zeros:
        reason = f"the log ends in {zeros} zero bytes in row {row} {last_good}"
        advice = "The disk or the logger has lost what was there: copy the log again."
    elif table.cut_row_cells < len(table.names):
        reason = f"the log ends in the middle of row {row} {last_good}"
        advice = "This row is not used. Check whether the run was complete."
    else:
        rule = "unterminated_row"
        reason = f"row {row}, the last, has no line end, so that its last number may be cut"
        advice = "End the file with a line end."
    return base.Refusal(rule, reason, advice).of_rows("", row, row)


def _rate_change(time: FloatArray, rows: IndexArray) -> base.Refusal | None:
    """A flaw where the sampling rate changes within a run: levels are found at one interval."""
    blocks = (len(time) - 1) // _ROWS_PER_BLOCK
    if blocks < 2 * _FEWEST_BLOCKS:
        return None
    steps_by_block = np.diff(time)[: blocks * _ROWS_PER_BLOCK].reshape(blocks, _ROWS_PER_BLOCK)
    # gates judge pauses and wrong digits of single rows
    trimmed_steps = np.sort(steps_by_block, axis=1)[
        :, _ROWS_PER_BLOCK // 10 : -_ROWS_PER_BLOCK // 10
    ]
    intervals_s = trimmed_steps.mean(axis=1)
    if not intervals_s[0] > 0:
        return None
    slower = intervals_s > intervals_s[0] * _LARGEST_RATE_RATIO
    faster = intervals_s < intervals_s[0] / _LARGEST_RATE_RATIO
    changed = slower | faster
    if changed.sum() < _FEWEST_BLOCKS:
        return None
    first_changed = int(np.argmax(changed))
    return base.Refusal(
        "sampling_rate",
        f"rows come every {intervals_s[0]:.3g} s at first and every "
        f"{intervals_s[first_changed]:.3g} s from "
        f"about row {rows[first_changed * _ROWS_PER_BLOCK]} on; expected one sampling rate",
    )


def _two_decimal_marks(
    table: LoggedTable, refusals: Sequence[base.Refusal], form: base.TextForm
) -> base.Refusal | None:
    """A flaw where many rows are refused because they have the other decimal mark."""
    mark = form.decimal_mark
    if form.delimiter in ("", "comma") or table.show is None:
        return None
    number_with_other_mark = r"\d\.\d" if mark == "comma" else r"\d,\d"
    with_other_mark = []
    for refusal in refusals:
        _, _, row_text = refusal.reason.partition("reads")
        if re.search(number_with_other_mark, row_text):
            with_other_mark.append(refusal)
    refused_rows = sum(refusal.refused_rows for refusal in with_other_mark)
    if not with_other_mark or refused_rows < table.rows * _MANY_ROWS_SHARE:
        return None
    reason = f"{with_other_mark[0].reason}; most other rows have a decimal {mark}"
    return base.Refusal("decimal_marks", reason)


def _numbers(table: LoggedTable, columns: Sequence[Column]) -> dict[Column, FloatArray]:
    """The columns with their numbers as logged, without spare ones that hold none.

    Raises:
        ValueError: A column holds something else.
    """
    logged: dict[Column, FloatArray] = {}
    all_values = table.values([column.index for column in columns])
    for column, values in zip(columns, all_values, strict=True):
        if values.dtype.kind in "iuf":
            logged[column] = values.astype(np.float64, copy=False)
        elif not column.spare:
            raise ValueError(f"the column {column.name[:60]!r} does not hold numbers")
    return logged


def _converted(logged: Mapping[Column, FloatArray]) -> tuple[dict[str, FloatArray], BoolArray]:
    """Numbers in the units of the columns, by quantity, and which rows can be used.

    A row can be used where every number is finite and below the largest reading of any rig. Numbers
    of spare columns are not judged.
    """
    within_limits = []
    for column, numbers in logged.items():
        if not column.spare:
            limit = _LARGEST_TIME if column.quantity == "time" else base.LARGEST_READING
            within_limits.append(np.abs(numbers) < limit)
    readable = np.logical_and.reduce(within_limits)
    all_readable = bool(readable.all())
    values: dict[str, FloatArray] = {}
    for column, numbers in logged.items():
        usable = numbers if all_readable else np.where(readable, numbers, np.nan)
        values[column.quantity] = column.conversion.convert(usable)
    for column in logged:
        quantity = column.quantity
        numbers = values[quantity]
        if column.conversion.unit == "GPa":
            readable = readable & ~(np.abs(numbers) > base.LARGEST_PRESSURE_GPA)
        if quantity.endswith("temperature"):
            readable = readable & ~((numbers <= ABSOLUTE_ZERO_C) | (numbers >= _HOTTEST_C))
    return values, readable


def seconds(values: Values) -> Values:
    """Instants as seconds since the first, durations as seconds; numbers stay as they are."""
    if values.dtype.kind not in "mM":
        return values
    start = values[0] if values.dtype.kind == "M" and len(values) else 0
    return (values - start) / np.timedelta64(1, "s")


def header_text(value: object) -> str:
    """A property of a binary format as a text log would write it."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value).strip()


def texts_of(values: Values) -> Texts:
    """Numbers or texts of a binary format as a text log would write them; missing ones are empty.

    Args:
        values: Values of a column, shape (rows,).
    """
    codes, different_values = pd.factorize(values)
    # the code of a missing value is -1
    texts = [*(header_text(value) for value in different_values.tolist()), ""]
    return np.array(texts, dtype=object)[codes]
