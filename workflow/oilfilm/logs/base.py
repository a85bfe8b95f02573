"""What becomes of a raw file: runs, and what had to be refused of it."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from oilfilm.units import ABSOLUTE_ZERO_C

# Columns of the table of samples but for `run_id`: name -> array over the rows of one run.
Columns = dict[str, npt.NDArray[Any]]
IndexArray = npt.NDArray[np.int64]

# Columns of a log: each one's name, and the unit beside or below it (empty where there is none).
Names = list[tuple[str, str]]

COPY_AGAIN = "Copy it again from the rig, or export it again: this copy cannot be repaired."

# What no rig can mean, whatever the settings of a campaign.
# A reading beyond this is no measurement of any rig, whatever its unit.
LARGEST_READING = 1e9
# A day of 50 Hz logging is 4.3 million rows. What has more, or unfolds to more than so many times
# its size, was made to fill the memory.
MOST_ROWS, MOST_FOLDED = 4_500_000, 250
_LARGEST_BY_LINE = 1 << 26


# Set points of a run that its log or the campaign states, by key.
Nominal = Mapping[str, float]
# Set point -> its quantity, as keys name it, and its unit.
SET_POINT_UNITS = {
    "max_hertz_pressure_gpa": ("max_hertz_pressure", "GPa"),
    "load_n": ("load", "N"),
    "entrainment_speed_m_s": ("entrainment_speed", "m/s"),
    "inlet_temperature_c": ("inlet_temperature", "degC"),
}
SET_POINTS = tuple(SET_POINT_UNITS)
LOADS = frozenset({"max_hertz_pressure_gpa", "load_n"})
# No contact of steel or ceramic bears more: 900 is in MPa.
HARDEST_GPA = 10.0


@dataclass(frozen=True)
class Refusal:
    """A file, a run or a range of rows that was refused.

    Attributes:
        rule: Name of the rule or gate.
        reason: The sentence: what was found and what was expected.
        advice: What to do about it; empty for a run, whose rule has its advice.
        run_id: The run; empty where it is the file.
        first_row: First data row concerned, counted from 1; 0 where no row is meant.
        last_row: Last data row concerned.
        refused_rows: How many rows are kept out of samples because of it.
    """

    rule: str
    reason: str
    advice: str = ""
    run_id: str = ""
    first_row: int = 0
    last_row: int = 0
    refused_rows: int = 0

    def of_rows(self, run_id: str, first: int, last: int) -> "Refusal":
        """The refusal of the rows from `first` to `last`; of none where `last` is smaller."""
        count = last - first + 1
        return replace(
            self, run_id=run_id, first_row=min(first, last), last_row=last, refused_rows=count
        )


class UnreadableLogError(Exception):
    """A file of which nothing can be used; `rows` counts what may be its rows."""

    def __init__(self, reason: str, advice: str = "", rows: int = 0, rule: str = "columns") -> None:
        super().__init__(reason)
        self.refusal = Refusal(rule, reason, advice)
        self.rows = rows

    @classmethod
    def of(cls, problem: Refusal) -> Self:
        """The error that a refusal ends in."""
        return cls(problem.reason, problem.advice, rule=problem.rule)


def too_large(reason: str) -> UnreadableLogError:
    """The refusal of a log that was made to fill the memory, or holds too much for one."""
    return UnreadableLogError(reason, "Begin a file for each run.", rule="too_large")


def check_rows(rows: int) -> None:
    """Refuse a table that is larger than any log, before it is read.

    Raises:
        UnreadableLogError: It is.
    """
    if rows > MOST_ROWS:
        raise too_large(f"the log has {rows} rows, more than {MOST_ROWS}")


def check_lines(content: bytes) -> None:
    """Refuse a text that is too large to be read line by line.

    Raises:
        UnreadableLogError: It is.
    """
    if len(content) > _LARGEST_BY_LINE:
        raise too_large(f"a text of this format is read up to {_LARGEST_BY_LINE >> 20} MiB")


@dataclass(frozen=True)
class LogColumn:
    """A column of a log that is read.

    Attributes:
        name: As the log writes it.
        logged_unit: Its unit in the log.
        quantity: What it is taken for.
        unit: The unit in which it is read.
        minimum: Smallest number that it holds, in `unit`; NaN where there is none.
        maximum: Largest number.
        count: How many rows have a number.
        missing: How many have none.
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
class Understood:
    """What a run was taken for.

    Attributes:
        columns: The columns that are read.
        unused: The names of the others.
        sources: Where each header key comes from.
        names: All columns, each with the unit beside its name.
        stated: What header and run sheet say beside oil, rig and set points.
    """

    columns: Sequence[LogColumn] = ()
    unused: Sequence[str] = ()
    sources: Mapping[str, str] = field(default_factory=dict)
    names: str = ""
    stated: str = ""


NOTHING_UNDERSTOOD = Understood()


@dataclass(frozen=True)
class LoggedRun:
    """One test run out of a raw file.

    `flaw` says why the run cannot be used, if so (its samples are kept all the same); `label` is
    the name that the log gives the run itself; `understood` is what its columns were taken for. Its
    length is the number of its rows.
    """

    run_id: str
    oil: str
    rig: str
    kind: str
    nominal: Nominal
    samples: Columns
    flaw: Refusal | None = None
    label: str = ""
    understood: Understood = NOTHING_UNDERSTOOD

    def __len__(self) -> int:
        return len(self.samples["row"])


@dataclass(frozen=True)
class TextForm:
    """How a text log was read; a part that the format does not have is empty.

    Attributes:
        encoding: Python's name of the encoding.
        delimiter: What parts the cells, in a word.
        decimal_mark: `point` or `comma`.
    """

    encoding: str = ""
    delimiter: str = ""
    decimal_mark: str = ""

    @classmethod
    def of(cls, encoding: str, delimiter: str, decimal_mark: str) -> "TextForm":
        """The same from the marks themselves."""
        return cls(encoding, _MARKS.get(delimiter, delimiter), _MARKS[decimal_mark])


NO_TEXT = TextForm()
_MARKS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", " ": "blanks", ".": "point"}


@dataclass(frozen=True)
class Reading:
    """Everything found in one raw file; `rows` counts its data rows, good and bad.

    `unpacked_sha256` is that of what is inside a packed file; empty where the file is not packed.
    """

    rows: int
    runs: list[LoggedRun] = field(default_factory=list)
    refusals: list[Refusal] = field(default_factory=list)
    form: TextForm = NO_TEXT
    unpacked_sha256: str = ""


def refused_ranges(
    run_id: str, rows: IndexArray, rule: str, problem: str, advice: str
) -> list[Refusal]:
    """One refusal per unbroken range of rows that have the same problem."""
    return [
        Refusal(rule, f"rows {first} to {last}: {problem}", advice).of_rows(run_id, first, last)
        for first, last in as_ranges(rows)
    ]


def number(text: str) -> float:
    """The number that a cell holds.

    Raises:
        ValueError: It holds none; 1_0 is none either, though Python reads it.
    """
    if "_" in text:
        raise ValueError(f"{text!r} is no number")
    return float(text)


def decimal_number(text: str) -> float:
    """The same, with a decimal point or comma."""
    return number(text if "." in text else text.replace(",", ".", 1))


def set_point(name: str, text: str) -> float | None:
    """The set point that a text gives, with a decimal point or comma; None where it gives none."""
    least, most = _range(name)
    try:
        value = decimal_number(text)
    except ValueError:
        return None
    return value if least < value < most else None


def expected_set_point(name: str) -> str:
    """What a set point must be, for a message."""
    least, most = _range(name)
    unit = SET_POINT_UNITS[name][1] + (", not MPa" if most == HARDEST_GPA else "")
    return f"a number above {least:g}, below {most:g} (in {unit})"


def _range(name: str) -> tuple[float, float]:
    least = ABSOLUTE_ZERO_C if name == "inlet_temperature_c" else 0.0
    return least, HARDEST_GPA if name == "max_hertz_pressure_gpa" else LARGEST_READING


def distinct(names: Iterable[str]) -> list[str]:
    """Printable names, those that repeat an earlier one told apart by a number."""
    seen: Counter[str] = Counter()
    result = []
    for name in names:
        # a name becomes part of other names: no backslashes of escaped characters
        plain = "".join(mark if mark.isprintable() else "?" for mark in name)[:80]
        seen[plain] += 1
        result.append(f"{plain}-{seen[plain]}" if seen[plain] > 1 else plain)
    return result


def as_ranges(rows: IndexArray) -> list[tuple[int, int]]:
    """Sorted row numbers as (first, last) pairs of unbroken ranges."""
    if len(rows) == 0:
        return []
    starts = np.flatnonzero(np.diff(rows, prepend=rows[0] - 2) != 1)
    ends = np.append(starts[1:] - 1, len(rows) - 1)
    return [(int(rows[start]), int(rows[end])) for start, end in zip(starts, ends, strict=True)]
