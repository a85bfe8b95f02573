"""The table of one run as a format found it: what every reader gives."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from oilfilm.base.units import BoolArray, IndexArray
from oilfilm.logs import base
from oilfilm.logs.log_schema import LoggedColumn

# Values of a column as its format gives them: numbers, instants, durations or texts. Those of a
# column of numbers have the shape (rows,).
Values = npt.NDArray[Any]
# Text of each row of a column, shape (rows,).
Texts = npt.NDArray[np.object_]


class Clock(NamedTuple):
    """Time of an evenly sampled column: its start, the interval between rows, and their unit.

    The start is NaN where the file does not give it, and gives several to other columns.
    """

    start: float
    interval: float
    unit: str


@dataclass(frozen=True)
class LoggedTable:
    """A table of a log as a reader gives it: one run, or several that are told apart later.

    Attributes:
        text_of_key: Header key, as `plain_key` makes it -> text of its line.
        names: Names of all columns.
        units: Unit beside each name; empty where there is none.
        read_values: Function that gives the columns with some indices; those of numbers have the
            shape (rows,). A cell without a number is NaN.
        row_count: Number of rows, good and bad.
        run_name: Name of the run in its file; empty where the file is one run.
        undivided_names: Names of the runs that this run is a part of.
        columns: The columns that make a run, where the format itself says which; empty for other
            formats, whose columns are known by their names.
        refusal: Why the run cannot be used, although its rows are read; None where it can.
        problem: Why nothing of the run can be read; None where it can.
        clock_of_column: Index of an evenly sampled column -> its clock.
        time_index_of_column: Index of a column -> index of the column with its time, where several
            columns have times of their own.
        start_s_of_column: Index of a column -> seconds to be added to its times; NaN as in `Clock`.
        cut_row_cell_count: Number of cells of the last row where it has no line end; else 0.
        show_row: Function that gives the text of the row with an index, for messages; None where
            the file has no text. The numbers are shown then.
        read_texts: Function that gives the texts of the column with an index; None where the
            format has numbers only.
        is_contradictory: Mask of the rows that contradict themselves; None where the format cannot
            show it.
        row_indices: Index of each row among the rows of the table that the format found, shape
            (rows,); None where it is the whole table.
        notes: What the user should know of how the table was read, in sentences.
        decimal_mark: Decimal mark of its numbers as text.
    """

    text_of_key: Mapping[str, str]
    names: Sequence[str]
    units: Sequence[str]
    read_values: Callable[[Sequence[int]], Sequence[Values]]
    row_count: int
    run_name: str = ""
    undivided_names: tuple[str, ...] = ()
    columns: Sequence[LoggedColumn] = ()
    refusal: base.Refusal | None = None
    problem: base.Refusal | None = None
    clock_of_column: Mapping[int, Clock] = field(default_factory=dict)
    time_index_of_column: Mapping[int, int] = field(default_factory=dict)
    start_s_of_column: Mapping[int, float] = field(default_factory=dict)
    cut_row_cell_count: int = 0
    show_row: Callable[[int], str] | None = None
    read_texts: Callable[[int], Texts] | None = None
    is_contradictory: BoolArray | None = None
    row_indices: IndexArray | None = None
    notes: tuple[str, ...] = ()
    decimal_mark: str = "."

    @property
    def run_names(self) -> tuple[str, ...]:
        """The name of the run, then `undivided_names`; empty where the file is one run.

        A row of the run sheet holds for the run if it has one of these names.
        """
        return (self.run_name, *self.undivided_names) if self.run_name else ()

    def row_numbers(self, first_row_number: int) -> IndexArray:
        """Number of each row in its file.

        Args:
            first_row_number: Number of the first row of the table that the format found.
        """
        if self.row_indices is None:
            return np.arange(first_row_number, first_row_number + self.row_count)
        return first_row_number + self.row_indices

    def with_name(self, run_name: str) -> "LoggedTable":
        """The table under another name of its run."""
        return replace(self, run_name=run_name)

    def with_note(self, note: str) -> "LoggedTable":
        """The table with one more note."""
        return replace(self, notes=(*self.notes, note))

    def select_rows(
        self, selected_indices: IndexArray, run_name: str, text_of_key: Mapping[str, str]
    ) -> "LoggedTable":
        """Some rows of the table as a run of their own.

        Args:
            selected_indices: Indices of the rows, rising, shape (n,).
            run_name: Name of the run in its file.
            text_of_key: Header key of the run -> text of its line.
        """
        if len(selected_indices) == self.row_count:
            return replace(self, run_name=run_name, text_of_key=text_of_key)
        # a slice of an array takes no memory
        is_consecutive = int(selected_indices[-1]) - int(selected_indices[0]) + 1 == len(
            selected_indices
        )
        selection = (
            slice(int(selected_indices[0]), int(selected_indices[-1]) + 1)
            if is_consecutive
            else selected_indices
        )
        read_all_values = self.read_values
        read_all_texts = self.read_texts
        show_any_row = self.show_row

        def read_selected_values(column_indices: Sequence[int]) -> list[Values]:
            # other columns than numbers have any length
            return [
                column[selection] if len(column) == self.row_count else column
                for column in read_all_values(column_indices)
            ]

        def read_selected_texts(index: int) -> Texts:
            return (
                read_all_texts(index)[selection] if read_all_texts else np.array([], dtype=object)
            )

        has_last_row = int(selected_indices[-1]) == self.row_count - 1
        row_indices = np.arange(self.row_count) if self.row_indices is None else self.row_indices
        return replace(
            self,
            text_of_key=text_of_key,
            read_values=read_selected_values,
            row_count=len(selected_indices),
            run_name=run_name,
            cut_row_cell_count=self.cut_row_cell_count if has_last_row else 0,
            show_row=None
            if show_any_row is None
            else lambda row: show_any_row(int(selected_indices[row])),
            read_texts=None if read_all_texts is None else read_selected_texts,
            is_contradictory=None
            if self.is_contradictory is None
            else self.is_contradictory[selection],
            row_indices=row_indices[selected_indices],
        )


# What a reader finds in a file: the dialect of its text, and its tables.
TablesOfFile = tuple[base.TextDialect, Iterable[LoggedTable]]
