"""From the columns of a log to its run: what all formats share.

A format finds names, units, header keys and numbers. This module and the log schema do the rest.

Decides: which rows are refused for their cells.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
import pandas as pd

from oilfilm.base.errors import printable
from oilfilm.base.units import (
    ABSOLUTE_ZERO_C,
    BoolArray,
    Conversion,
    FloatArray,
    IndexArray,
    possible_conversion,
)
from oilfilm.logs import base
from oilfilm.logs.clocks import with_time_column
from oilfilm.logs.log_schema import LoggedColumn, LogSchema, UsableRows, Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile, Texts, Values
from oilfilm.logs.run_sheet import RunMetadata, RunSheet
from oilfilm.logs.runs_in_table import runs_in_table
from oilfilm.logs.text_rows import DATE_PATTERN
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
# The table of runs names so many columns of a log, each in so many letters, at most.
_MOST_NAMES_STATED, _LONGEST_NAME_STATED = 200, 100
_NOTE_ADVICE = "Nothing to do if that is right."
ROWS_ADVICE = "Look at these rows of the raw log; the rows around them are used."


def read_tables(
    tables_of_file: TablesOfFile,
    file: str,
    settings: Settings,
    log_schema: LogSchema,
    sheet: RunSheet,
) -> base.ParsedLog:
    """The runs in the tables of a file, and what was refused of them."""
    dialect, logged_tables = tables_of_file
    row_count = 0
    parsed_log = base.ParsedLog(0, dialect=dialect)
    names_of_runs: list[tuple[str, ...]] = []
    context = _FileContext(file, dialect, settings, log_schema, sheet)
    for table in logged_tables:
        run_tables = _tables_of_runs(table, settings, log_schema)
        for run_table in run_tables:
            names_of_runs += _read_run(run_table, row_count + 1, parsed_log, context)
        row_count += sum(run_table.row_count for run_table in run_tables)
    refusals = [*parsed_log.refusals, *sheet.unmatched_rows(file, names_of_runs)]
    return replace(parsed_log, row_count=row_count, refusals=refusals)


def _tables_of_runs(
    table: LoggedTable, settings: Settings, log_schema: LogSchema
) -> list[LoggedTable]:
    """One table per run of a table, with a time. Columns are read once for all runs."""
    vocabulary = log_schema.campaign_vocabulary(settings.campaign)
    table = with_time_column(table, vocabulary)
    values_of_index: dict[int, Values] = {}

    def read_values(column_indices: Sequence[int]) -> list[Values]:
        indices_to_read = [index for index in column_indices if index not in values_of_index]
        if indices_to_read:
            values_of_index.update(
                zip(indices_to_read, table.read_values(indices_to_read), strict=True)
            )
        return [values_of_index[index] for index in column_indices]

    return runs_in_table(replace(table, read_values=read_values), vocabulary, settings)


@dataclass(frozen=True)
class _FileContext:
    """What the runs of one file share.

    Attributes:
        file: Name of the file.
        dialect: How its text is written.
        settings: Settings of the campaign.
        log_schema: What logs of this kind of rig may hold.
        sheet: The run sheet.
    """

    file: str
    dialect: base.TextDialect
    settings: Settings
    log_schema: LogSchema
    sheet: RunSheet


def _read_run(
    table: LoggedTable, first_row_number: int, parsed_log: base.ParsedLog, context: _FileContext
) -> list[tuple[str, ...]]:
    """Add the run of a table, or why it is refused, to the parsed log of its file.

    A run at several set points is added as several runs.

    Returns:
        The names of each run in the file; none where the file is one run.
    """
    dialect, log_schema = context.dialect, context.log_schema
    encoding_in_words = "" if dialect.encoding in ("", "ascii") else f"; read as {dialect.encoding}"
    metadata = context.sheet.run_metadata(
        context.file, table.run_names, table.text_of_key, context.settings, table.decimal_mark
    )
    try:
        run, refusals = _read_table(
            table, metadata, first_row_number, dialect, context.settings, log_schema
        )
        tables_of_set_points = _tables_of_set_points(table, run, first_row_number, log_schema)
        if len(tables_of_set_points) > 1:
            names_of_runs: list[tuple[str, ...]] = []
            for table_of_set_point in tables_of_set_points:
                names_of_runs += _read_run(
                    table_of_set_point, first_row_number, parsed_log, context
                )
            return names_of_runs
        parsed_log.runs.append(run)
    except (ValueError, base.UnreadableLogError) as error:
        problem = base.Refusal(
            "columns", f"{error}{encoding_in_words}", log_schema.vocabulary.advice
        )
        if isinstance(error, base.UnreadableLogError):
            problem = error.refusal
        problem = metadata.with_exclusion(problem)
        run_id = metadata.run_id if table.run_name else ""
        row_ranges = base.unbroken_ranges(table.row_numbers(first_row_number))
        # a table without rows is refused, too
        row_ranges = row_ranges or [(first_row_number, first_row_number - 1)]
        refusals = [problem.for_rows(run_id, first, last) for first, last in row_ranges]
    parsed_log.refusals.extend(refusals)
    parsed_log.refusals.extend(metadata.remarks)
    return [table.run_names] if table.run_name else []


def _tables_of_set_points(
    table: LoggedTable, run: base.LoggedRun, first_row_number: int, log_schema: LogSchema
) -> list[LoggedTable]:
    """One table per set point of a run; the table itself where the run has one set point."""
    # some formats say themselves what a run is
    row_indices_of_parts = [] if table.columns else log_schema.find_rows_of_set_points(run)
    if len(row_indices_of_parts) < 2:
        return [table]
    # rows that cannot be used belong to the part before them
    first_row_numbers = [
        int(run.samples["row"][row_indices[0]]) for row_indices in row_indices_of_parts[1:]
    ]
    split_indices = np.searchsorted(table.row_numbers(first_row_number), first_row_numbers)
    listed_rows = ", ".join(map(str, first_row_numbers[:10]))
    note = (
        f"the load or the speed changes to another set point at row {listed_rows}; the rows "
        f"before and after are runs of their own"
    )
    tables_of_parts: list[LoggedTable] = []
    for number, row_indices in enumerate(
        np.split(np.arange(table.row_count), split_indices), start=1
    ):
        name = f"{table.run_name} setpoint{number}".strip()
        table_of_part = table.select_rows(row_indices, name, table.text_of_key)
        table_of_part = replace(table_of_part, undivided_names=table.run_names)
        tables_of_parts.append(table_of_part.with_note(note))
    return tables_of_parts


def _read_table(
    table: LoggedTable,
    metadata: RunMetadata,
    first_row_number: int,
    dialect: base.TextDialect,
    settings: Settings,
    log_schema: LogSchema,
) -> tuple[base.LoggedRun, list[base.Refusal]]:
    """The run of a table and the refusals of its rows.

    Raises:
        ValueError: Its columns cannot be understood.
        UnreadableLogError: Nothing of it can be used for another reason.
    """
    if table.problem:
        raise base.UnreadableLogError.from_refusal(table.problem)
    vocabulary = log_schema.campaign_vocabulary(settings.campaign)
    unneeded_quantities = log_schema.find_unneeded_quantities(metadata.text_of_key, settings)
    names, table = _names_without_duplicates(table, vocabulary)
    columns = table.columns or vocabulary.columns_of_run(names, table.units, unneeded_quantities)
    problems = chain(
        [metadata.problem], log_schema.find_header_problems(metadata.text_of_key, columns, settings)
    )
    first_problem = next(filter(None, problems), None)
    if first_problem:
        raise base.UnreadableLogError.from_refusal(first_problem)
    numbers_of_column = _logged_numbers(table, columns)
    values_of_quantity, is_readable = _converted_numbers(numbers_of_column)
    row_numbers = table.row_numbers(first_row_number)
    is_good, refusals = _mask_of_good_rows(
        table, list(numbers_of_column.values()), is_readable, row_numbers
    )
    refusals += [base.Refusal(base.READING_NOTE, note, _NOTE_ADVICE) for note in table.notes]
    refusals = [replace(refusal, run_id=metadata.run_id) for refusal in refusals]
    if not is_good.all():
        row_numbers = row_numbers[is_good]
        values_of_quantity = {
            quantity: numbers[is_good] for quantity, numbers in values_of_quantity.items()
        }
    usable_rows = UsableRows(
        metadata.run_id,
        metadata.text_of_key,
        list(numbers_of_column),
        row_numbers,
        values_of_quantity,
        metadata.exclusion
        or _refusal_of_run(table, metadata, row_numbers, values_of_quantity, refusals, dialect),
        _run_interpretation(table, metadata, numbers_of_column),
    )
    return log_schema.make_run(usable_rows, settings), refusals


# Two numbers that differ by less are one number in two units.
_ROUNDING_OF_CONVERSION = 1e-9


def _names_without_duplicates(
    table: LoggedTable, vocabulary: Vocabulary
) -> tuple[list[str], LoggedTable]:
    """Column names, empty for a duplicate of an earlier column, and the table with notes on these.

    A column is a duplicate where both have the same quantity and, in one unit, the same numbers: a
    load in kN duplicates the load in N.
    """
    names = list(table.names)
    if table.columns:
        return names, table
    first_index_of_quantity: dict[str, int] = {}
    notes: list[str] = []
    quantities_and_units = vocabulary.quantities_and_units(table.names, table.units)
    for index, (quantity, unit) in quantities_and_units.items():
        first_index = first_index_of_quantity.setdefault(quantity, index)
        if first_index == index:
            continue
        numbers, other_numbers = table.read_values([first_index, index])
        if numbers.dtype.kind not in "iuf" or other_numbers.dtype.kind not in "iuf":
            continue
        first_unit = quantities_and_units[first_index].unit
        if unit == first_unit:
            is_duplicate = np.array_equal(numbers, other_numbers, equal_nan=True)
        else:
            target_units = vocabulary.units_of_quantity[quantity]
            conversion = possible_conversion(first_unit, target_units)
            other_conversion = possible_conversion(unit, target_units)
            is_duplicate = _are_equal_in_one_unit(
                numbers, conversion, other_numbers, other_conversion
            )
        if is_duplicate:
            notes.append(
                f"the columns {names[first_index][:60]!r} and {names[index][:60]!r} hold the same "
                "numbers; the first of them is used"
            )
            names[index] = ""
    return names, replace(table, notes=(*table.notes, *notes))


def _are_equal_in_one_unit(
    numbers: FloatArray,
    conversion: Conversion | None,
    other_numbers: FloatArray,
    other_conversion: Conversion | None,
) -> bool:
    """Whether two columns of different units have the same numbers, as 80 N and 0.08 kN.

    Args:
        numbers: Numbers of the one, shape (rows,).
        conversion: Conversion of its unit; None where that is no unit of the quantity.
        other_numbers: Numbers of the other.
        other_conversion: Conversion of its unit.
    """
    if conversion is None or other_conversion is None or conversion.unit != other_conversion.unit:
        return False
    if numbers.shape != other_numbers.shape:
        return False
    return np.allclose(
        conversion.convert(numbers),
        other_conversion.convert(other_numbers),
        rtol=_ROUNDING_OF_CONVERSION,
        atol=0.0,
        equal_nan=True,
    )


def _mask_of_good_rows(
    table: LoggedTable,
    numbers_of_columns: Sequence[FloatArray],
    is_readable: BoolArray,
    row_numbers: IndexArray,
) -> tuple[BoolArray, list[base.Refusal]]:
    """The mask of the rows that can be used, shape (rows,), and the refusals of the other rows.

    Args:
        table: The table.
        numbers_of_columns: Its columns as logged, each of shape (rows,).
        is_readable: Mask of the rows whose cells hold usable numbers.
        row_numbers: Row numbers in the file.
    """
    # a last row without a line end has a refusal of its own
    has_line_end = np.ones(len(row_numbers), dtype=bool)
    if table.cut_row_cell_count:
        has_line_end[-1] = False
    refusals = [
        _refusal_of_unreadable_rows(
            table, numbers_of_columns, first, last, int(np.searchsorted(row_numbers, first))
        )
        for first, last in base.unbroken_ranges(row_numbers[has_line_end & ~is_readable])
    ]
    is_good = is_readable & has_line_end
    if table.is_contradictory is not None:
        contradictory_row_numbers = row_numbers[is_good & table.is_contradictory]
        refusals += base.refused_ranges(
            "",
            contradictory_row_numbers,
            "identity_broken",
            "the row contradicts itself: speeds, slip, forces, coefficient disagree",
            "Look at these rows: a sensor or the export has failed there.",
        )
        is_good &= ~table.is_contradictory
    if table.cut_row_cell_count:
        refusals.append(_refusal_of_cut_row(table, int(row_numbers[-1])))
    return is_good, refusals


def _refusal_of_run(
    table: LoggedTable,
    metadata: RunMetadata,
    row_numbers: IndexArray,
    values_of_quantity: Mapping[str, FloatArray],
    refusals: Sequence[base.Refusal],
    dialect: base.TextDialect,
) -> base.Refusal | None:
    """Why a run cannot be used by its rows; the first reason that is found, None without one.

    Args:
        table: The table.
        metadata: What is known of the run.
        row_numbers: Numbers of the good rows.
        values_of_quantity: Their values by quantity.
        refusals: The refusals of the other rows.
        dialect: How the text was read.
    """
    if table.refusal:
        return table.refusal
    for refusal in refusals:
        if refusal.rule == "cut_row":
            return replace(refusal, run_id="", rule="truncated")
    if (
        "time" in values_of_quantity
        and metadata.text_of_key.get("log_kind") != base.SETTLED_LOG_KIND
    ):
        rate_change = _rate_change_refusal(values_of_quantity["time"], row_numbers)
        if rate_change:
            return rate_change
    return _decimal_marks_refusal(table, refusals, dialect)


def _run_interpretation(
    table: LoggedTable, metadata: RunMetadata, numbers_of_column: Mapping[LoggedColumn, FloatArray]
) -> base.RunInterpretation:
    """How the columns and the header of a run were interpreted."""
    indices_read = {column.index for column in numbers_of_column}
    return base.RunInterpretation(
        columns=[column.summary(numbers) for column, numbers in numbers_of_column.items()],
        unused_names=[name for index, name in enumerate(table.names) if index not in indices_read],
        source_of_key=metadata.source_of_key,
        names_with_units=_names_with_units(table),
        statements=_statements(metadata.text_of_key),
    )


def _names_with_units(table: LoggedTable) -> tuple[str, ...]:
    """The columns of a log, each with the unit beside its name."""
    names: list[str] = []
    for name, unit in zip(table.names, table.units, strict=True):
        name_with_unit = f"{name} [{unit}]" if unit else name
        names.append(printable(name_with_unit)[:_LONGEST_NAME_STATED])
    return tuple(names[:_MOST_NAMES_STATED])


def _statements(text_of_key: Mapping[str, str]) -> tuple[str, ...]:
    """Header lines as `key=text`, without oil, rig and set points; of a time stamp only the day."""
    statements: list[str] = []
    for key, text in sorted(text_of_key.items()):
        if not text or key in _KEYS_WITH_COLUMN:
            continue
        day = DATE_PATTERN.match(text)
        value = day[0] if day else text
        statements.append(printable(f"{key[:40]}={value[:60]}"))
    return tuple(statements[:_MOST_STATED_KEYS])


def _refusal_of_unreadable_rows(
    table: LoggedTable,
    numbers_of_columns: Sequence[FloatArray],
    first_row_number: int,
    last_row_number: int,
    first_index: int,
) -> base.Refusal:
    """Refusal of rows with a bad cell, which shows the first of them.

    Args:
        table: The table.
        numbers_of_columns: Its columns as logged.
        first_row_number: Number of the first row in the file.
        last_row_number: Number of the last row in the file.
        first_index: Index of the first row in the table.
    """
    if table.show_row:
        row_text = table.show_row(first_index)
    else:
        row_text = ", ".join(f"{numbers[first_index]:g}" for numbers in numbers_of_columns)
    reason = (
        f"rows {first_row_number} to {last_row_number}: cells are missing, too many, not numbers "
        f"or absurdly large; row {first_row_number} reads {row_text[:80]!r}"
    )
    return base.Refusal("unreadable_row", reason, ROWS_ADVICE).for_rows(
        "", first_row_number, last_row_number
    )


def _refusal_of_cut_row(table: LoggedTable, row_number: int) -> base.Refusal:
    """The refusal of a last row without a line end."""
    row_text = table.show_row(table.row_count - 1) if table.show_row else ""
    zero_count = row_text.count("\0")
    rule = "cut_row"
    last_good = f"(its last good row is {row_number - 1})"
    if zero_count:
        reason = f"the log ends in {zero_count} zero bytes in row {row_number} {last_good}"
        advice = "The disk or the logger has lost what was there: copy the log again."
    elif table.cut_row_cell_count < len(table.names):
        reason = f"the log ends in the middle of row {row_number} {last_good}"
        advice = "This row is not used. Check whether the run was complete."
    else:
        rule = "unterminated_row"
        reason = f"row {row_number}, the last, has no line end, so that its last number may be cut"
        advice = "End the file with a line end."
    return base.Refusal(rule, reason, advice).for_rows("", row_number, row_number)


def _rate_change_refusal(time_s: FloatArray, row_numbers: IndexArray) -> base.Refusal | None:
    """A refusal if the sampling rate changes within a run: levels are found for one rate only."""
    block_count = (len(time_s) - 1) // _ROWS_PER_BLOCK
    if block_count < 2 * _FEWEST_BLOCKS:
        return None
    # one row per block
    intervals_s = np.diff(time_s)[: block_count * _ROWS_PER_BLOCK].reshape(
        block_count, _ROWS_PER_BLOCK
    )
    # without the extremes: gates judge pauses and wrong digits of single rows
    trimmed_intervals_s = np.sort(intervals_s, axis=1)[
        :, _ROWS_PER_BLOCK // 10 : -_ROWS_PER_BLOCK // 10
    ]
    mean_of_block_s = trimmed_intervals_s.mean(axis=1)
    if not mean_of_block_s[0] > 0:
        return None
    is_slower = mean_of_block_s > mean_of_block_s[0] * _LARGEST_RATE_RATIO
    is_faster = mean_of_block_s < mean_of_block_s[0] / _LARGEST_RATE_RATIO
    has_changed = is_slower | is_faster
    if has_changed.sum() < _FEWEST_BLOCKS:
        return None
    first_changed_block = int(np.argmax(has_changed))
    row_of_change = row_numbers[first_changed_block * _ROWS_PER_BLOCK]
    return base.Refusal(
        "sampling_rate",
        f"rows come every {mean_of_block_s[0]:.3g} s at first and every "
        f"{mean_of_block_s[first_changed_block]:.3g} s from about row {row_of_change} on; expected "
        "one sampling rate",
    )


def _decimal_marks_refusal(
    table: LoggedTable, refusals: Sequence[base.Refusal], dialect: base.TextDialect
) -> base.Refusal | None:
    """A refusal if many rows are refused because they have the other decimal mark."""
    mark = dialect.decimal_mark
    if dialect.delimiter in ("", "comma") or table.show_row is None:
        return None
    number_with_other_mark = r"\d\.\d" if mark == "comma" else r"\d,\d"
    refusals_with_other_mark = []
    for refusal in refusals:
        _, _, row_text = refusal.reason.partition("reads")
        if re.search(number_with_other_mark, row_text):
            refusals_with_other_mark.append(refusal)
    refused_rows = sum(refusal.refused_rows for refusal in refusals_with_other_mark)
    if not refusals_with_other_mark or refused_rows < table.row_count * _MANY_ROWS_SHARE:
        return None
    reason = f"{refusals_with_other_mark[0].reason}; most other rows have a decimal {mark}"
    return base.Refusal("decimal_marks", reason)


def _logged_numbers(
    table: LoggedTable, columns: Sequence[LoggedColumn]
) -> dict[LoggedColumn, FloatArray]:
    """Column -> its numbers as logged, without spare columns that hold no numbers.

    Raises:
        ValueError: A column holds something else.
    """
    numbers_of_column: dict[LoggedColumn, FloatArray] = {}
    all_values = table.read_values([column.index for column in columns])
    for column, logged_values in zip(columns, all_values, strict=True):
        if logged_values.dtype.kind in "iuf":
            numbers_of_column[column] = logged_values.astype(np.float64, copy=False)
        elif not column.is_spare:
            raise ValueError(f"the column {column.name[:60]!r} does not hold numbers")
    return numbers_of_column


def _converted_numbers(
    numbers_of_column: Mapping[LoggedColumn, FloatArray],
) -> tuple[dict[str, FloatArray], BoolArray]:
    """Quantity -> numbers in the unit of its column; and the mask of the rows that can be used.

    A row can be used where every number is finite and below the largest reading of any rig. Numbers
    of spare columns are not judged.
    """
    is_within_limits = []
    for column, numbers in numbers_of_column.items():
        if not column.is_spare:
            limit = _LARGEST_TIME if column.quantity == "time" else base.LARGEST_READING
            is_within_limits.append(np.abs(numbers) < limit)
    is_readable = np.logical_and.reduce(is_within_limits)
    are_all_readable = bool(is_readable.all())
    values_of_quantity: dict[str, FloatArray] = {}
    for column, numbers in numbers_of_column.items():
        usable_numbers = numbers if are_all_readable else np.where(is_readable, numbers, np.nan)
        values_of_quantity[column.quantity] = column.conversion.convert(usable_numbers)
    for column in numbers_of_column:
        quantity = column.quantity
        numbers = values_of_quantity[quantity]
        if column.conversion.unit == "GPa":
            is_readable = is_readable & ~(np.abs(numbers) > base.LARGEST_PRESSURE_GPA)
        if quantity.endswith("temperature"):
            is_readable = is_readable & ~((numbers <= ABSOLUTE_ZERO_C) | (numbers >= _HOTTEST_C))
    return values_of_quantity, is_readable


def as_seconds(values: Values) -> Values:
    """Instants as seconds since the first known one, durations as seconds; NaN where unknown.

    Numbers stay as they are.
    """
    if values.dtype.kind not in "mM":
        return values
    is_instant = values.dtype.kind == "M" and len(values) > 0
    start = values[np.argmin(np.isnat(values))] if is_instant else 0
    return (values - start) / np.timedelta64(1, "s")


def text_of_value(value: object) -> str:
    """A property of a binary format as a text log would write it."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value).strip()


def texts_of_values(values: Values) -> Texts:
    """Numbers or texts of a binary format as a text log would write them; missing ones are empty.

    Args:
        values: Values of a column, shape (rows,).
    """
    code_of_row, distinct_values = pd.factorize(values)
    # the code of a missing value is -1
    text_of_code = [*(text_of_value(value) for value in distinct_values.tolist()), ""]
    return np.array(text_of_code, dtype=object)[code_of_row]
