"""What a raw file gives: runs, and refusals of what cannot be used."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from oilfilm.base.units import ABSOLUTE_ZERO_C, IndexArray

# Name of a column -> its values, shape (rows,). The rows are samples of one run, or its plateaus.
ColumnArrays = dict[str, npt.NDArray[Any]]

# Name of each column of a log, and the unit beside or below it (empty where there is none).
NamesAndUnits = list[tuple[str, str]]

# Value of the header key and of the column `log_kind`. Each row is a settled reading, as of a rig
# whose program steps from one slip to the next. Any other log is a signal against time.
SETTLED_LOG_KIND = "steps"

# Rule of a note on how a log was read. It refuses nothing.
READING_NOTE = "reading_note"
COPY_AGAIN_ADVICE = "Copy it again from the rig, or export it again: this copy cannot be repaired."

# These limits hold whatever the settings of a campaign are.
# No rig measures a larger number, in any unit.
LARGEST_READING = 1e9
# A day of logging at 50 Hz has 4.3 million rows. A log with more rows would fill the memory.
MOST_ROWS = 4_500_000
# Largest ratio of the unpacked to the packed size. An archive with more was made to fill the
# memory.
MOST_UNPACKED_RATIO = 250
_LARGEST_TEXT_READ_BY_LINE_MIB = 64
_BYTES_PER_MIB = 1 << 20


# Set points of a run that its log or the campaign states, by key.
SetPoints = Mapping[str, float]
# Key of a set point -> its quantity, as header keys name it, and its unit.
QUANTITY_AND_UNIT_OF_SET_POINT = {
    "max_hertz_pressure_gpa": ("max_hertz_pressure", "GPa"),
    "load_n": ("load", "N"),
    "entrainment_speed_m_s": ("entrainment_speed", "m/s"),
    "inlet_temperature_c": ("inlet_temperature", "degC"),
}
SET_POINT_KEYS = tuple(QUANTITY_AND_UNIT_OF_SET_POINT)
# Set points that state the load: a run has one of them.
LOAD_KEYS = frozenset({"max_hertz_pressure_gpa", "load_n"})
# No contact of steel or ceramic bears a higher pressure: a larger number is in MPa.
LARGEST_PRESSURE_GPA = 10.0


@dataclass(frozen=True)
class Refusal:
    """A file, a run or a range of rows that was refused; or a remark, which refuses nothing.

    The rules of remarks are `READING_NOTE` and the `REMARK_RULES` of `run_sheet.py`.

    Attributes:
        rule: Name of the rule or gate.
        reason: The sentence: what was found and what was expected.
        advice: What to do about it. Empty for a run: its rule has the advice.
        run_id: The run; empty where the file itself is refused.
        first_row: First data row concerned, counted from 1; 0 where no row is meant.
        last_row: Last data row concerned.
        refused_rows: Number of rows that the refusal keeps out of the samples.
    """

    rule: str
    reason: str
    advice: str = ""
    run_id: str = ""
    first_row: int = 0
    last_row: int = 0
    refused_rows: int = 0

    def for_rows(self, run_id: str, first_row: int, last_row: int) -> "Refusal":
        """The refusal of rows `first_row` to `last_row`; of no rows if `last_row` is smaller."""
        return replace(
            self,
            run_id=run_id,
            first_row=min(first_row, last_row),
            last_row=last_row,
            refused_rows=last_row - first_row + 1,
        )


class UnreadableLogError(Exception):
    """A file or run of which nothing can be used.

    Attributes:
        refusal: Why it cannot be used.
        row_count: Number of lines that may be data rows.
    """

    def __init__(
        self, reason: str, advice: str = "", row_count: int = 0, rule: str = "columns"
    ) -> None:
        super().__init__(reason)
        self.refusal = Refusal(rule, reason, advice)
        self.row_count = row_count

    @classmethod
    def from_refusal(cls, refusal: Refusal) -> Self:
        """The error that carries a refusal out of a reader."""
        return cls(refusal.reason, refusal.advice, rule=refusal.rule)


def too_large_error(reason: str) -> UnreadableLogError:
    """The error for a log that is larger than any run."""
    return UnreadableLogError(reason, "Begin a file for each run.", rule="too_large")


def check_row_count(row_count: int) -> None:
    """Refuse a table with more rows than any log, before it is read.

    Raises:
        UnreadableLogError: The table has more than `MOST_ROWS` rows.
    """
    if row_count > MOST_ROWS:
        raise too_large_error(f"the log has {row_count} rows, more than {MOST_ROWS}")


def check_text_size(content: bytes) -> None:
    """Refuse a text that is too large to be read line by line.

    Raises:
        UnreadableLogError: The text is too large.
    """
    if len(content) > _LARGEST_TEXT_READ_BY_LINE_MIB * _BYTES_PER_MIB:
        raise too_large_error(
            f"a text of this format is read up to {_LARGEST_TEXT_READ_BY_LINE_MIB} MiB"
        )


@dataclass(frozen=True)
class ColumnSummary:
    """What one column of a log holds, for messages and `oilfilm check`.

    Attributes:
        name: Name in the log.
        logged_unit: Unit in the log.
        quantity: Quantity that the column is taken for.
        unit: Unit to which its numbers are converted.
        minimum: Smallest number, in `unit`; NaN where there is none.
        maximum: Largest number, in `unit`; NaN where there is none.
        count: Number of rows with a number.
        missing: Number of rows without a number.
    """

    name: str
    logged_unit: str
    quantity: str
    unit: str
    minimum: float
    maximum: float
    count: int
    missing: int


@dataclass(frozen=True)
class RunInterpretation:
    """How the reader interpreted the columns and the header of a run.

    Attributes:
        columns: Summaries of the columns that are read.
        unused_names: Names of the columns that are not read.
        source_of_key: Header key -> its source: `header` or `run sheet`.
        names_with_units: Names of all columns, each with the unit beside it.
        statements: Header lines as `key=text`, without those of oil, rig and set points.
    """

    columns: Sequence[ColumnSummary] = ()
    unused_names: Sequence[str] = ()
    source_of_key: Mapping[str, str] = field(default_factory=dict)
    names_with_units: tuple[str, ...] = ()
    statements: tuple[str, ...] = ()


NO_INTERPRETATION = RunInterpretation()


@dataclass(frozen=True)
class LoggedRun:
    """One test run out of a raw file. Its length is the number of its rows.

    Attributes:
        run_id: Unique name of the run.
        oil_name: Id of the oil.
        rig_name: Name of the rig file; of a torque log the bearing.
        log_kind: `continuous` (a signal against time) or `SETTLED_LOG_KIND`.
        set_points: Set points that the log, its sheet or the campaign states.
        samples: Its columns in the table of samples.
        refusal: Why the run cannot be used; None where it can. The samples are kept in both cases.
        label: Name that the log itself gives the run.
        interpretation: How its columns and header were interpreted.
    """

    run_id: str
    oil_name: str
    rig_name: str
    log_kind: str
    set_points: SetPoints
    samples: ColumnArrays
    refusal: Refusal | None = None
    label: str = ""
    interpretation: RunInterpretation = NO_INTERPRETATION

    def __len__(self) -> int:
        return len(self.samples["row"])


@dataclass(frozen=True)
class TextDialect:
    """How a text log is written. An attribute that the format does not have is empty.

    Attributes:
        encoding: Python's name of the encoding.
        delimiter: Name of the character between cells, as `semicolon`.
        decimal_mark: `point` or `comma`.
    """

    encoding: str = ""
    delimiter: str = ""
    decimal_mark: str = ""

    @classmethod
    def from_marks(cls, encoding: str, delimiter: str, decimal_mark: str) -> "TextDialect":
        """The dialect of a text with these characters between cells and as decimal mark."""
        return cls(encoding, _NAME_OF_MARK.get(delimiter, delimiter), _NAME_OF_MARK[decimal_mark])


# The dialect of a file that is no text.
NO_DIALECT = TextDialect()
_NAME_OF_MARK = {
    ",": "comma",
    ";": "semicolon",
    "\t": "tab",
    "|": "bar",
    " ": "blanks",
    ".": "point",
}


@dataclass(frozen=True)
class ParsedLog:
    """Everything that a reader found in one raw file.

    Attributes:
        row_count: Number of data rows, good and bad.
        runs: The runs of the file.
        refusals: What was refused of it, and remarks.
        dialect: How its text is written.
        unpacked_sha256: sha256 of the content of a packed file; empty where it is not packed.
    """

    row_count: int
    runs: list[LoggedRun] = field(default_factory=list)
    refusals: list[Refusal] = field(default_factory=list)
    dialect: TextDialect = NO_DIALECT
    unpacked_sha256: str = ""


def refused_ranges(
    run_id: str, row_numbers: IndexArray, rule: str, problem: str, advice: str
) -> list[Refusal]:
    """One refusal per unbroken range of rows that have the same problem."""
    return [
        Refusal(rule, f"rows {first} to {last}: {problem}", advice).for_rows(run_id, first, last)
        for first, last in unbroken_ranges(row_numbers)
    ]


def parse_number(text: str) -> float:
    """The number in a cell with a decimal point.

    Raises:
        ValueError: The cell holds no number. Python reads 1_0 as 10; here it is no number.
    """
    if "_" in text:
        raise ValueError(f"{text!r} is no number")
    return float(text)


def parse_decimal(text: str) -> float:
    """The number in a cell with a decimal point or comma.

    Raises:
        ValueError: The cell holds no number.
    """
    if "." in text:
        return parse_number(text)
    return parse_number(text.replace(",", ".", 1))


def parse_set_point(set_point_key: str, text: str) -> float | None:
    """The number of a set point, with a decimal point or comma.

    None where the text is no number, or where the number is out of the range of the set point.
    """
    try:
        value = parse_decimal(text)
    except ValueError:
        return None
    return value if is_in_set_point_range(set_point_key, value) else None


def is_in_set_point_range(set_point_key: str, value: float) -> bool:
    """Whether a number, in the unit of a set point, is in its range."""
    lower_limit, upper_limit = _set_point_range(set_point_key)
    return lower_limit < value < upper_limit


def set_point_range_in_words(set_point_key: str) -> str:
    """The range and unit of a set point, for a message."""
    lower_limit, upper_limit = _set_point_range(set_point_key)
    _, unit = QUANTITY_AND_UNIT_OF_SET_POINT[set_point_key]
    if unit == "GPa":
        unit = "GPa, not MPa"
    return f"a number above {lower_limit:g}, below {upper_limit:g} (in {unit})"


def _set_point_range(set_point_key: str) -> tuple[float, float]:
    """Lower and upper limit of a set point, in its unit; both limits are excluded."""
    if set_point_key == "inlet_temperature_c":
        return ABSOLUTE_ZERO_C, LARGEST_READING
    if set_point_key == "max_hertz_pressure_gpa":
        return 0.0, LARGEST_PRESSURE_GPA
    return 0.0, LARGEST_READING


def distinct_names(names: Iterable[str]) -> list[str]:
    """Printable names; a number is added to a name that repeats an earlier one.

    Examples:
        >>> distinct_names(["A", "A", "A-2"])
        ['A', 'A-3', 'A-2']
    """
    # `?`, and no escape: a backslash must not enter the id of a run
    printable_names = [
        "".join(letter if letter.isprintable() else "?" for letter in name)[:80] for name in names
    ]
    taken_names = set(printable_names)
    number_of_name: dict[str, int] = {}
    distinct: list[str] = []
    for printable_name in printable_names:
        distinct_name = printable_name
        is_repeated = printable_name in number_of_name
        number_of_name.setdefault(printable_name, 1)
        while is_repeated and distinct_name in taken_names:
            number_of_name[printable_name] += 1
            distinct_name = f"{printable_name}-{number_of_name[printable_name]}"
        taken_names.add(distinct_name)
        distinct.append(distinct_name)
    return distinct


def unbroken_ranges(row_numbers: IndexArray) -> list[tuple[int, int]]:
    """Sorted row numbers as (first, last) pairs of unbroken ranges."""
    if len(row_numbers) == 0:
        return []
    # the first row begins a range: the number put before it is 2 smaller
    start_indices = np.flatnonzero(np.diff(row_numbers, prepend=row_numbers[0] - 2) != 1)
    end_indices = np.append(start_indices[1:] - 1, len(row_numbers) - 1)
    return [
        (int(row_numbers[start_index]), int(row_numbers[end_index]))
        for start_index, end_index in zip(start_indices, end_indices, strict=True)
    ]
