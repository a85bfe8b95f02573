"""The run that the columns of a log make: shared by all formats in columns.

A format finds names, units, header keys and numbers; everything that follows from them is here and
in the kind of log.

Decides: which rows are refused for their cells.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np
import numpy.typing as npt

from oilfilm.errors import printable
from oilfilm.logs import base
from oilfilm.logs.log_kind import Column, ContinuousLog, LogKind, Vocabulary
from oilfilm.logs.run_sheet import Labels, RunSheet
from oilfilm.logs.text_rows import DAY
from oilfilm.settings.resolved import Settings
from oilfilm.units import ABSOLUTE_ZERO_C, BoolArray, FloatArray

# What the columns of a log can hold. These limits belong to reading, before a campaign is judged
# by its settings.
# No oil is liquid there; its properties have no meaning.
_HOTTEST_C = 1000.0
# Time may be counted from 1970, in milliseconds too.
_LARGEST_TIME = 1e13
# A rate holds for some blocks of rows; more than such a ratio is another one.
_ROWS_OF_RATE, _BLOCKS_OF_RATE, _RATIO_OF_RATES = 50, 2, 1.5
# So many of the rows are no slips of single rows.
_MANY_ROWS = 0.05
# Keys that have columns of their own in the table of runs; so many of the others are kept.
_OF_RUNS = frozenset({"oil", "rig", "log_kind", "run", *base.SET_POINTS})
_MOST_STATED = 30
ROWS_ADVICE = "Look at these rows of the raw log; the rows around them are used."
Values = npt.NDArray[Any]


@dataclass(frozen=True)
class LoggedTable:
    """One run as a format found it: what every reader gives.

    Attributes:
        keys: Header keys, as `plain_key` makes them.
        names: All column names.
        units: Unit beside each name; empty where none.
        values: Gives the columns at some places, one number per row, NaN where a cell holds none.
        rows: How many rows there are, good and bad.
        part: Name of the run in its file; empty where the file is one run.
        columns: The columns that make a run, where the format itself says it.
        flaw: Why the run cannot be used, if so.
        problem: Why nothing of it can be used, if so.
        clocks: Start, increment and unit of the time of columns that were sampled evenly, by their
            place.
        cut: How many cells the last row has, where it has no line end; else 0.
        show: Gives a row as the file has it; without it the numbers are shown.
        broken: Rows that contradict themselves, where the format can show it.
    """

    keys: Mapping[str, str]
    names: Sequence[str]
    units: Sequence[str]
    values: Callable[[Sequence[int]], Sequence[Values]]
    rows: int
    part: str = ""
    columns: Sequence[Column] = ()
    flaw: base.Refusal | None = None
    problem: base.Refusal | None = None
    clocks: Mapping[int, tuple[float, float, str]] = field(default_factory=dict)
    cut: int = 0
    show: Callable[[int], str] | None = None
    broken: BoolArray | None = None


# What a reader finds in a file.
Found = tuple[base.TextForm, Iterable[LoggedTable]]


def read_tables(
    found: Found, file: str, settings: Settings, kind: LogKind, sheet: RunSheet
) -> base.Reading:
    """The runs that the tables of a file make, and what had to be refused of them."""
    form, tables = found[0], [*found[1]]
    read_as = f"; read as {form.encoding}" if form.encoding not in ("", "ascii") else ""
    rows = 0
    runs: list[base.LoggedRun] = []
    refusals: list[base.Refusal] = []
    for table in tables:
        labels = sheet.labels(file, table.part, table.keys, settings)
        try:
            run, refused = _read_table(table, labels, rows + 1, form, settings, kind)
            runs.append(run)
        except (ValueError, base.UnreadableLogError) as error:
            problem = base.Refusal("columns", f"{error}{read_as}", kind.vocabulary.advice)
            problem = labels.whole(getattr(error, "refusal", problem))
            run_id = labels.run_id if table.part else ""
            refused = [problem.of_rows(run_id, rows + 1, rows + table.rows)]
        rows += table.rows
        refusals += [*refused, *labels.remarks]
    refusals += sheet.strays(file, [table.part for table in tables if table.part])
    return base.Reading(rows, runs, refusals, form)


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
        raise base.UnreadableLogError.of(table.problem)
    vocabulary = kind.vocabulary_of(settings.campaign)
    table = _with_time(table, vocabulary)
    spared = kind.spared(labels.keys, settings)
    columns = table.columns or vocabulary.columns(table.names, table.units, spared)
    problems = chain([labels.problem], kind.header_problems(labels.keys, columns, settings))
    if problem := next(filter(None, problems), None):
        raise base.UnreadableLogError.of(problem)
    logged = _numbers(table, columns)
    values, good = _converted(logged)
    rows = np.arange(first_row, first_row + table.rows)
    # a last row without a line end is refused as such
    whole = slice(table.rows - bool(table.cut))
    refusals = [
        _unreadable(table, [*logged.values()], first, last, first - first_row)
        for first, last in base.as_ranges(rows[whole][~good[whole]])
    ]
    flaw = table.flaw
    if table.broken is not None:
        contradiction = "the row contradicts itself: speeds, slip, forces, coefficient disagree"
        advice = "Look at these rows: a sensor or the export has failed there."
        broken = rows[whole][(good & table.broken)[whole]]
        refusals += base.refused_ranges("", broken, "identity_broken", contradiction, advice)
        good &= ~table.broken
    if table.cut:
        good[-1] = False
        refusals.append(_cut_row(table, int(rows[-1])))
        if refusals[-1].rule == "cut_row":
            flaw = flaw or replace(refusals[-1], rule="truncated")
    refusals = [replace(refusal, run_id=labels.run_id) for refusal in refusals]
    if not good.all():
        rows = rows[good]
        values = {quantity: numbers[good] for quantity, numbers in values.items()}
    if "time" in values and labels.keys.get("log_kind") != "steps":
        flaw = flaw or _rate_change(values["time"], rows)
    flaw = flaw or _two_decimal_marks(table, refusals, form)
    places = {column.index for column in logged}
    unused = [name for index, name in enumerate(table.names) if index not in places]
    read = [column.read(numbers) for column, numbers in logged.items()]
    said = labels.sources, _named(table), _stated(labels.keys)
    understood = base.Understood(read, unused, *said)
    flaw = labels.excluded or flaw
    log = ContinuousLog(labels.run_id, labels.keys, [*logged], rows, values, flaw, understood)
    return kind.run(log, settings), refusals


def _named(table: LoggedTable) -> str:
    """The columns of a log, each with the unit beside its name."""
    both = zip(table.names, table.units, strict=True)
    return printable(", ".join(f"{name} [{unit}]" if unit else name for name, unit in both))[:2000]


def _stated(keys: Mapping[str, str]) -> str:
    """What header and run sheet say beside oil, rig and set points; of a time stamp the day."""
    said = {key: DAY.match(text) or [text] for key, text in sorted(keys.items()) if text}
    kept = [f"{key[:40]}={text[0][:60]}" for key, text in said.items() if key not in _OF_RUNS]
    return printable("; ".join(each.replace(";", ",") for each in kept[:_MOST_STATED]))


def _unreadable(
    table: LoggedTable, logged: Sequence[FloatArray], first: int, last: int, index: int
) -> base.Refusal:
    """Rows refused for a cell; the first of them, at some index of the table, is shown."""
    seen = table.show(index) if table.show else ", ".join(f"{each[index]:g}" for each in logged)
    reason = (
        f"rows {first} to {last}: cells are missing, too many, not numbers or absurdly large; row "
        f"{first} reads {seen[:80]!r}"
    )
    return base.Refusal("unreadable_row", reason, ROWS_ADVICE).of_rows("", first, last)


def _cut_row(table: LoggedTable, row: int) -> base.Refusal:
    """The refusal of a last row without a line end."""
    seen = table.show(table.rows - 1) if table.show else ""
    rule, good = "cut_row", f"(its last good row is {row - 1})"
    if zeros := seen.count("\0"):
        reason = f"the log ends in {zeros} zero bytes in row {row} {good}"
        advice = "The disk or the logger has lost what was there: copy the log again."
    elif table.cut < len(table.names):
        reason = f"the log ends in the middle of row {row} {good}"
        advice = "This row is not used. Check whether the run was complete."
    else:
        reason = f"row {row}, the last, has no line end, so that its last number may be cut"
        rule, advice = "unterminated_row", "End the file with a line end."
    return base.Refusal(rule, reason, advice).of_rows("", row, row)


def _rate_change(time: FloatArray, rows: base.IndexArray) -> base.Refusal | None:
    """Whether rows come at another interval from some row on: levels are found at one interval."""
    count = (len(time) - 1) // _ROWS_OF_RATE
    steps = np.diff(time)[: count * _ROWS_OF_RATE].reshape(count, _ROWS_OF_RATE)
    # pauses and wrong digits of some rows are judged by gates
    usual = np.sort(steps, axis=1)[:, _ROWS_OF_RATE // 10 : -_ROWS_OF_RATE // 10].mean(axis=1)
    if count < 2 * _BLOCKS_OF_RATE or not usual[0] > 0:
        return None
    other = (usual > usual[0] * _RATIO_OF_RATES) | (usual < usual[0] / _RATIO_OF_RATES)
    if other.sum() < _BLOCKS_OF_RATE:
        return None
    first = int(np.argmax(other))
    return base.Refusal(
        "sampling_rate",
        f"rows come every {usual[0]:.3g} s at first and every {usual[first]:.3g} s from about row "
        f"{rows[first * _ROWS_OF_RATE]} on; expected one sampling rate",
    )


def _two_decimal_marks(
    table: LoggedTable, refusals: Sequence[base.Refusal], form: base.TextForm
) -> base.Refusal | None:
    """Whether many rows are refused because they have the other decimal mark."""
    mark = form.decimal_mark
    if form.delimiter in ("", "comma") or table.show is None:
        return None
    other = r"\d\.\d" if mark == "comma" else r"\d,\d"
    having = [each for each in refusals if re.search(other, each.reason.partition("reads")[2])]
    if not having or sum(each.refused_rows for each in having) < table.rows * _MANY_ROWS:
        return None
    reason = f"{having[0].reason}; most other rows have a decimal {mark}"
    return base.Refusal("decimal_marks", reason)


def _with_time(table: LoggedTable, vocabulary: Vocabulary) -> LoggedTable:
    """The table with time made of the sampling interval, where no column has it."""
    known = vocabulary.meanings(table.names, table.units)
    clocks = {table.clocks[index] for index in known if index in table.clocks}
    if len(clocks) != 1 or any(quantity == "time" for quantity, _ in known.values()):
        return table
    ((start, increment, unit),) = clocks
    place = len(table.names)

    def values(places: Sequence[int]) -> list[Values]:
        logged = iter(table.values([each for each in places if each != place]))
        time = start + increment * np.arange(table.rows)
        return [time if each == place else next(logged) for each in places]

    names, units = [*table.names, "time"], [*table.units, unit]
    return replace(table, names=names, units=units, values=values)


def _numbers(table: LoggedTable, columns: Sequence[Column]) -> dict[Column, FloatArray]:
    """The columns with their numbers as logged, without spare ones that hold none.

    Raises:
        ValueError: A column holds something else.
    """
    values = zip(columns, table.values([column.index for column in columns]), strict=True)
    logged = {c: n.astype(np.float64, copy=False) for c, n in values if n.dtype.kind in "iuf"}
    for column in columns:
        if column not in logged and not column.spare:
            raise ValueError(f"the column {column.name[:60]!r} does not hold numbers")
    return logged


def _converted(logged: Mapping[Column, FloatArray]) -> tuple[dict[str, FloatArray], BoolArray]:
    """Numbers in the units of the columns, by quantity, and which rows can be used.

    A row can be used where every number but the spare ones is finite and below what any rig
    measures.
    """
    limits = {column: base.LARGEST_READING for column in logged if not column.spare}
    limits |= {column: _LARGEST_TIME for column in limits if column.quantity == "time"}
    good = np.logical_and.reduce([np.abs(logged[each]) < most for each, most in limits.items()])
    all_good = bool(good.all())
    values = {
        column.quantity: column.to.of(numbers if all_good else np.where(good, numbers, np.nan))
        for column, numbers in logged.items()
    }
    for column in logged:
        quantity, numbers = column.quantity, values[column.quantity]
        if column.to.unit == "GPa":
            good = good & ~(np.abs(numbers) > base.HARDEST_GPA)
        if quantity.endswith("temperature"):
            good = good & ~((numbers <= ABSOLUTE_ZERO_C) | (numbers >= _HOTTEST_C))
    return values, good


def seconds(values: Values) -> Values:
    """Instants as seconds since the first, durations as seconds; numbers as they are."""
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
