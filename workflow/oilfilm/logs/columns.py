"""What the columns of a log mean, and the run that they make: shared by all formats in columns.

A format finds names, units, header keys and numbers; everything that follows from them is here and
in the kind of log.

Decides: what the columns of a log mean, and their units; which rows are refused for their cells.
"""

import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from oilfilm.logs.base import (
    LARGEST_READING,
    NO_TEXT,
    Flaw,
    LogColumn,
    LoggedRun,
    Reading,
    Refusal,
    TextForm,
    Understood,
    as_ranges,
)
from oilfilm.logs.header import FORMAT_ADVICE, FULL_WIDTH, apart
from oilfilm.logs.log_kind import Column, ContinuousLog, FloatArray, LogKind, Renamed, Vocabulary
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.settings import campaign as campaign_file
from oilfilm.settings.base import plain_key
from oilfilm.settings.resolved import Settings
from oilfilm.units import ABSOLUTE_ZERO_C, conversion

# No oil is liquid there; its properties have no meaning.
_HOTTEST_C = 1000.0
ROWS_ADVICE = "Look at these rows of the raw log; the rows around them are used."


def columns_advice(vocabulary: Vocabulary) -> str:
    """What to do about a log whose columns cannot be understood."""
    return f"{FORMAT_ADVICE} Other names: see `{vocabulary.columns_key}` of the campaign file."


def meaning(name: str, renamed: Renamed, vocabulary: Vocabulary) -> tuple[str, str | None] | None:
    """Quantity and unit (None where something else must give it) of a column's name.

    Args:
        name: Column name as the log writes it.
        renamed: Quantity -> `name` and `unit`, for columns with names of their own.
        vocabulary: What such logs may hold.
    """
    bare, unit = apart(name.translate(FULL_WIDTH))
    for quantity, given in renamed.items():
        if _is_listed(name, given):
            return quantity, given.unit or unit
    plain = plain_key(bare)
    if plain in vocabulary.own_names:
        quantity, own_unit = vocabulary.own_names[plain]
        return quantity, unit or own_unit
    return (plain, unit) if plain in vocabulary.quantities else None


def _is_listed(name: str, given: campaign_file.Column) -> bool:
    plain = _plain(name)
    return bool({plain, apart(plain)[0]} & {*map(_plain, given.name)})


@lru_cache(maxsize=4096)
def _plain(name: str) -> str:
    """A name as it is compared with those of the campaign file, its case kept: n is not N."""
    return " ".join(unicodedata.normalize("NFC", name).translate(FULL_WIDTH).split())


def meanings(
    names: Sequence[str], renamed: Renamed, vocabulary: Vocabulary
) -> dict[int, tuple[str, str | None]]:
    """Quantity and unit of each column that means something, by its place.

    Where the campaign file lists a column of the log, others of the project's name mean nothing.
    """
    known = {
        index: found
        for index, name in enumerate(names)
        if (found := meaning(name, renamed, vocabulary)) is not None
    }
    listed = {
        index: quantity
        for index, (quantity, _) in known.items()
        if quantity in renamed and _is_listed(names[index], renamed[quantity])
    }
    return {
        index: found
        for index, found in known.items()
        if index in listed or found[0] not in listed.values()
    }


def fits(quantity: str, unit: str, vocabulary: Vocabulary) -> bool:
    """True where a quantity can be given in that unit."""
    try:
        conversion(unit, vocabulary.quantities[quantity])
    except ValueError:
        return False
    return True


def _unit(quantity: str, beside: str, named: str | None, vocabulary: Vocabulary) -> str:
    """The unit that the log gives beside a name, unless only that of the name can be used."""
    use_named = named and not (beside and fits(quantity, beside, vocabulary))
    return named if named and use_named else beside


def known_names(
    names: Sequence[str], units: Sequence[str], renamed: Renamed, vocabulary: Vocabulary
) -> tuple[int, int]:
    """How many names are known and have a unit that fits them, and how many are known at all."""
    fitting = [
        fits(quantity, _unit(quantity, units[index], unit, vocabulary), vocabulary)
        for index, (quantity, unit) in meanings(names, renamed, vocabulary).items()
    ]
    return sum(fitting), len(fitting)


def find_columns(
    names: Sequence[str],
    units: Sequence[str],
    renamed: Renamed,
    vocabulary: Vocabulary,
) -> tuple[Column, ...]:
    """The columns that make a run, each with its conversion, then the spare ones.

    Args:
        names: All column names, in the order of the columns.
        units: Unit that the log gives for each, beside its name; empty where none.
        renamed: As for `meaning`.
        vocabulary: As for `meaning`.

    Raises:
        ValueError: A quantity is missing or doubled, or has no unit or an impossible one; the
            message is a sentence for the user.
    """
    columns: dict[str, Column] = {}
    for index, (quantity, named_unit) in meanings(names, renamed, vocabulary).items():
        name, unit = names[index], _unit(quantity, units[index], named_unit, vocabulary)
        if quantity in columns:
            raise ValueError(f"the log repeats the column {quantity!r}")
        if not unit:
            raise ValueError(
                f"the column {name[:60]!r} has no unit; write it in brackets, in a row below the "
                f"names or under `{vocabulary.columns_key}` of the campaign file"
            )
        try:
            to = conversion(unit, vocabulary.quantities[quantity])
        except ValueError as error:
            raise ValueError(f"the column {name[:60]!r}: {error}") from error
        columns[quantity] = Column(quantity, index, to, name, unit)
    either = vocabulary.either
    chosen = next((some for some in either if columns.keys() >= set(some)), either[0])
    needed = [*vocabulary.always, *chosen]
    missing = ", ".join(quantity for quantity in needed if quantity not in columns)
    if missing:
        own_names = ", ".join(names)[:200]
        raise ValueError(f"the log lacks the columns {missing}; its own are {own_names!r}")
    spare = [
        replace(columns[quantity], spare=True)
        for others in either[either.index(chosen) + 1 :]
        for quantity in others
        if quantity in columns
    ]
    needed += [quantity for quantity in vocabulary.optional if quantity in columns]
    return (*(columns[quantity] for quantity in needed), *spare)


Values = npt.NDArray[Any]


@dataclass(frozen=True)
class LoggedTable:
    """One run as a format found it: what every reader gives.

    Attributes:
        run_id: Unique name of the run.
        keys: Header keys, as `plain_key` makes them.
        names: All column names.
        units: Unit beside each name; empty where none.
        values: Gives the columns at some places, one number per row, NaN where a cell holds none.
        rows: How many rows there are, good and bad.
        first_row: Number of the first row in the file.
        flaw: Why the run cannot be used, if so.
        problem: Why its columns cannot be understood, if so.
        behind: The refusal of rows behind those of the table, if there are any.
        part: Name of the run in its file; empty where a file of the format is one run.
        clocks: Start, increment and unit of the time of columns that were sampled evenly, by their
            place.
        bad_rows: Gives the refusal of a range of rows whose cells cannot be used.
    """

    run_id: str
    keys: Mapping[str, str]
    names: Sequence[str]
    units: Sequence[str]
    values: Callable[[Sequence[int]], Sequence[Values]]
    rows: int
    first_row: int = 1
    flaw: Flaw | None = None
    problem: str = ""
    behind: Refusal | None = None
    part: str = ""
    clocks: Mapping[int, tuple[float, float, str]] = field(default_factory=dict)
    bad_rows: Callable[[int, int], Refusal] | None = None

    @property
    def all_rows(self) -> int:
        """How many rows there are with those behind the table."""
        return self.rows + (self.behind.refused_rows if self.behind else 0)


def read_tables(
    tables: Iterable[LoggedTable],
    settings: Settings,
    kind: LogKind,
    sheet: SheetOfLog,
    form: TextForm = NO_TEXT,
) -> Reading:
    """The runs that the tables of a file make, and what had to be refused of them."""
    reading = Reading(0, form=form)
    for table in tables:
        run, refusals = _read_table(table, settings, kind, sheet, form.encoding)
        reading = replace(
            reading,
            rows=reading.rows + table.all_rows,
            runs=[*reading.runs, *([run] if run is not None else [])],
            refusals=[*reading.refusals, *refusals],
        )
    return reading


def _read_table(
    table: LoggedTable, settings: Settings, kind: LogKind, sheet: SheetOfLog, encoding: str
) -> tuple[LoggedRun | None, list[Refusal]]:
    def refused(problem: Refusal) -> Refusal:
        last = table.first_row + table.all_rows - 1
        return problem.of_rows(table.run_id if table.part else "", table.first_row, last)

    try:
        table = _with_time(table, kind.renamed(settings.campaign), kind.vocabulary)
        columns = find_columns(
            table.names, table.units, kind.renamed(settings.campaign), kind.vocabulary
        )
        labels = sheet.labels(table.run_id, table.keys, settings, table.part)
        problem = labels.problem or kind.header_problem(labels.keys, columns, settings)
        if problem:
            return None, [refused(problem), *labels.remarks]
        used, logged = _numbers(table, columns)
    except ValueError as error:
        reason = str(error) + (f"; read as {encoding}" if encoding not in ("", "ascii") else "")
        return None, [refused(Refusal("columns", reason, columns_advice(kind.vocabulary)))]
    every, good = converted(used, logged)
    rows = np.arange(table.first_row, table.first_row + table.rows)
    refusals = []
    for first, last in as_ranges(rows[~good]):
        seen = ", ".join(f"{numbers[first - table.first_row]:g}" for numbers in logged)
        plain = unreadable_rows(table.run_id, first, last, seen)
        refusals.append(table.bad_rows(first, last) if table.bad_rows else plain)
    if refusals:
        rows = rows[good]
        every = {quantity: numbers[good] for quantity, numbers in every.items()}
    refusals += [table.behind] if table.behind else []
    places = {column.index for column in used}
    understood = Understood(
        [
            LogColumn.of(column.name, column.logged_unit, column.quantity, column.to, numbers)
            for column, numbers in zip(used, logged, strict=True)
        ],
        [name for index, name in enumerate(table.names) if index not in places],
        labels.sources,
    )
    flaw = labels.excluded or table.flaw
    log = ContinuousLog(table.run_id, labels.keys, used, rows, every, flaw, understood)
    return kind.run(log, settings), [*refusals, *labels.remarks]


def _with_time(table: LoggedTable, renamed: Renamed, vocabulary: Vocabulary) -> LoggedTable:
    """The table with time made of the sampling interval, where no column has it.

    Raises:
        ValueError: Its columns cannot be understood.
    """
    if table.problem:
        raise ValueError(table.problem)
    known = meanings(table.names, renamed, vocabulary)
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


def _numbers(
    table: LoggedTable, columns: Sequence[Column]
) -> tuple[list[Column], list[FloatArray]]:
    """The columns with their numbers as logged, without spare ones that hold none.

    Raises:
        ValueError: A column holds something else.
    """
    kept, logged = [], []
    values = table.values([column.index for column in columns])
    for column, numbers in zip(columns, values, strict=True):
        if numbers.dtype.kind in "iuf":
            kept.append(column)
            logged.append(numbers.astype(np.float64, copy=False))
        elif not column.spare:
            raise ValueError(f"the column {column.name[:60]!r} does not hold numbers")
    return kept, logged


# Time may be counted from 1970, in milliseconds too.
_LARGEST_TIME = 1e13


def converted(
    columns: Sequence[Column], logged: Sequence[FloatArray]
) -> tuple[dict[str, FloatArray], npt.NDArray[np.bool_]]:
    """Logged numbers in the units of `columns`, by quantity, and which rows can be used.

    A row can be used where every number but the spare ones is finite and below what any rig
    measures.
    """
    good = np.logical_and.reduce(
        [
            np.abs(numbers) < (_LARGEST_TIME if column.quantity == "time" else LARGEST_READING)
            for column, numbers in zip(columns, logged, strict=True)
            if not column.spare
        ]
    )
    all_good = bool(good.all())
    values = {
        column.quantity: column.to.of(numbers if all_good else np.where(good, numbers, np.nan))
        for column, numbers in zip(columns, logged, strict=True)
    }
    for quantity, numbers in values.items():
        if quantity.endswith("temperature"):
            good = good & (numbers > ABSOLUTE_ZERO_C) & (numbers < _HOTTEST_C)
    return values, good


def unreadable_rows(run_id: str, first: int, last: int, seen: str, where: str = "") -> Refusal:
    """Rows refused for a cell; `seen` is what the first of them holds, `where` its line."""
    return Refusal(
        "unreadable_row",
        f"rows {first} to {last}: cells are missing, too many, not numbers or absurdly large; row "
        f"{first}{where} reads {seen[:80]!r}",
        ROWS_ADVICE,
    ).of_rows(run_id, first, last)


def header_text(value: object) -> str:
    """A property of a binary format as a text log would write it."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value).strip()
