"""The table of one run as a format found it: what every reader gives."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from oilfilm.base.units import BoolArray, IndexArray
from oilfilm.logs import base
from oilfilm.logs.log_kind import Column

Values = npt.NDArray[Any]
# Text of each row of a column, shape (rows,).
Texts = npt.NDArray[np.object_]


class Clock(NamedTuple):
    """Time of an evenly sampled column: its start, the interval between rows, and their unit."""

    start: float
    interval: float
    unit: str


@dataclass(frozen=True)
class LoggedTable:
    """One run as a format found it: what every reader gives.

    Attributes:
        keys: Header keys, as `plain_key` makes them.
        names: Names of all columns.
        units: Unit beside each name; empty where there is none.
        values: Gives the columns with some indices, each of shape (rows,). A cell without a number
            is NaN.
        rows: Number of rows, good and bad.
        run_name: Name of the run in its file; empty where the file is one run.
        columns: The columns that make a run, where the format itself says it.
        flaw: Why the run cannot be used; None where it can.
        problem: Why nothing of the run can be read; None where it can.
        clocks: Clocks of evenly sampled columns, by the index of the column.
        time_column_of: Index of the column with the time of another column, by the index of the
            latter, where several columns have times of their own.
        started_s: Seconds to be added to the times of a column, by its index.
        cut_row_cells: Number of cells of the last row where it has no line end; else 0.
        show: Gives a row as the file has it. Without it the numbers are shown.
        texts: Gives the text of a column with an index; None where the format has numbers only.
        contradictory: Rows that contradict themselves, where the format can show it.
        row_indices: Index of each row among the rows of the table that the format found, shape
            (rows,); None where it is the whole table.
        notes: What the user should know of how the table was read, in sentences.
    """

    keys: Mapping[str, str]
    names: Sequence[str]
    units: Sequence[str]
    values: Callable[[Sequence[int]], Sequence[Values]]
    rows: int
    run_name: str = ""
    columns: Sequence[Column] = ()
    flaw: base.Refusal | None = None
    problem: base.Refusal | None = None
    clocks: Mapping[int, Clock] = field(default_factory=dict)
    time_column_of: Mapping[int, int] = field(default_factory=dict)
    started_s: Mapping[int, float] = field(default_factory=dict)
    cut_row_cells: int = 0
    show: Callable[[int], str] | None = None
    texts: Callable[[int], Texts] | None = None
    contradictory: BoolArray | None = None
    row_indices: IndexArray | None = None
    notes: tuple[str, ...] = ()

    def numbers_of_rows(self, first_row: int) -> IndexArray:
        """Number of each row in its file.

        Args:
            first_row: Number of the first row of the table that the format found.
        """
        if self.row_indices is None:
            return np.arange(first_row, first_row + self.rows)
        return first_row + self.row_indices

    def with_name(self, run_name: str) -> "LoggedTable":
        """The table under another name of its run."""
        return replace(self, run_name=run_name)

    def with_note(self, note: str) -> "LoggedTable":
        """The table with one more note."""
        return replace(self, notes=(*self.notes, note))

    def part(self, rows: IndexArray, run_name: str, keys: Mapping[str, str]) -> "LoggedTable":
        """Some rows of the table as a run of their own.

        Args:
            rows: Indices of the rows, rising, shape (n,).
            run_name: Name of the run in its file.
            keys: Header keys of the run.
        """
        if len(rows) == self.rows:
            return replace(self, run_name=run_name, keys=keys)
        # a slice of an array takes no memory
        is_stretch = int(rows[-1]) - int(rows[0]) + 1 == len(rows)
        chosen = slice(int(rows[0]), int(rows[-1]) + 1) if is_stretch else rows
        all_values = self.values
        all_texts = self.texts
        show = self.show

        def values(indices: Sequence[int]) -> list[Values]:
            # other columns than numbers have any length
            return [
                column[chosen] if len(column) == self.rows else column
                for column in all_values(indices)
            ]

        def texts(index: int) -> Texts:
            return all_texts(index)[chosen] if all_texts else np.array([], dtype=object)

        has_last_row = int(rows[-1]) == self.rows - 1
        row_indices = np.arange(self.rows) if self.row_indices is None else self.row_indices
        return replace(
            self,
            keys=keys,
            values=values,
            rows=len(rows),
            run_name=run_name,
            cut_row_cells=self.cut_row_cells if has_last_row else 0,
            show=None if show is None else lambda row: show(int(rows[row])),
            texts=None if all_texts is None else texts,
            contradictory=None if self.contradictory is None else self.contradictory[chosen],
            row_indices=row_indices[rows],
        )


# What a reader finds in a file: how the text is written, and its tables.
TablesOfFile = tuple[base.TextForm, Iterable[LoggedTable]]
