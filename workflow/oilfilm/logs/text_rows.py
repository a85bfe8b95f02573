"""The rows of a text log as numbers: parsed by Arrow, cell by cell where a cell is no number.

Decides: which number a cell of a text log holds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm.logs.base import Flaw, Refusal
from oilfilm.logs.encoding import line_ends
from oilfilm.logs.instants import seconds
from oilfilm.units import FloatArray

# Marks between thousands that are no decimal mark anywhere.
_BLANK_GROUPS = r"(?<=\d)[ \u00a0\u202f'\u2019](?=\d{3}(?!\d))"


@dataclass(frozen=True)
class TextTable:
    """Rows of a text log, as UTF-8 with LF line ends.

    Attributes:
        rows: The rows.
        width: How many cells a row has.
        delimiter: What parts the cells; no cell holds it.
        decimal_mark: Decimal mark of numbers.
        group_mark: Mark between thousands; empty where there is none.
        stamps: Places of the cells that make a time stamp, that of the time of day first; empty
            where time is a number.
    """

    rows: bytes
    width: int
    delimiter: str
    decimal_mark: str
    group_mark: str = ""
    stamps: Sequence[int] = ()

    def numbers(self, places: Sequence[int]) -> list[FloatArray]:
        """Numbers of some columns, one per row; NaN where a cell holds none.

        A row with more or fewer cells than columns holds no number.
        """
        if not self.rows:
            return [np.array([])] * len(places)
        misfits: list[int] = []
        try:
            table = self._parsed(places, arrow.float64(), self.decimal_mark, misfits)
            numbers = {place: table[str(place)].to_numpy() for place in self._plain(places)}
        except arrow.ArrowInvalid:
            misfits.clear()
            table = self._parsed(places, arrow.binary(), ".", misfits)
            numbers = {
                place: self._numbers(table[str(place)].to_pandas()) for place in self._plain(places)
            }
        if self.stamps:
            texts = [table[str(place)].to_pandas() for place in self.stamps]
            numbers[self.stamps[0]] = seconds(*(each.str.strip(' "') for each in texts))
        columns = [numbers[place] for place in places]
        if not misfits:
            return columns
        fitting = np.ones(len(columns[0]) + len(misfits), dtype=bool)
        fitting[np.array(misfits) - 1] = False
        every = np.full((len(columns), len(fitting)), np.nan)
        every[:, fitting] = columns
        return [*every]

    @cached_property
    def lines(self) -> list[bytes]:
        """The rows one by one."""
        return self.rows.split(b"\n")

    def _plain(self, places: Sequence[int]) -> list[int]:
        return [place for place in places if place not in self.stamps]

    def _parsed(
        self, places: Sequence[int], kind: arrow.DataType, decimal_mark: str, misfits: list[int]
    ) -> arrow.Table:
        """Cells of the columns; the numbers of the rows that do not fit go to `misfits`."""

        def skip(row: arrow_csv.InvalidRow) -> str:
            misfits.append(row.number)
            return "skip"

        types = {str(place): kind for place in places}
        types |= {str(place): arrow.string() for place in self.stamps}
        return arrow_csv.read_csv(
            arrow.BufferReader(self.rows),
            # one thread: only then are the rows that do not fit numbered;
            # one block: a line longer than a block could not be read
            read_options=arrow_csv.ReadOptions(
                use_threads=False,
                column_names=[*map(str, range(self.width))],
                block_size=len(self.rows) + 1,
            ),
            # a stray quote must not swallow the lines up to the next one
            parse_options=arrow_csv.ParseOptions(
                delimiter=self.delimiter, quote_char=False, invalid_row_handler=skip
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=[*types], column_types=types, decimal_point=decimal_mark
            ),
        )

    def _numbers(self, cells: "pd.Series[Any]") -> FloatArray:
        """Numbers of raw cells; NaN where a cell holds anything else."""
        text = cells.map(lambda cell: cell.decode("utf-8", "replace").strip(' "'), "ignore")
        text = text.str.replace(_BLANK_GROUPS, "", regex=True)
        other = "," if self.decimal_mark == "." else "."
        if self.group_mark:
            grouped = rf"[-+]?\d{{1,3}}(?:\{other}\d{{3}})+(?:\{self.decimal_mark}\d*)?"
            ungrouped = text.str.replace(other, "", regex=False)
            text = text.where(~text.str.fullmatch(grouped, na=False), ungrouped)
        # the other mark would be a second decimal mark: such a cell is no number
        text = text.str.replace(other, "?", regex=False).str.replace(",", ".", regex=False)
        return pd.to_numeric(text, errors="coerce").to_numpy(dtype=np.float64)


def count_rows(table: bytes) -> int:
    """Lines of a normalised table; the last one counts without a line end too."""
    return int(np.count_nonzero(line_ends(table))) + (table != b"" and not table.endswith(b"\n"))


def cut_row(cells: int, columns: int, row: int, run_id: str) -> tuple[Refusal, Flaw | None]:
    """The refusal of a last row without a line end; and why the run cannot be used, if so."""
    if cells >= columns:
        reason = f"row {row}, the last, has no line end, so that its last number may be cut"
        refusal = Refusal("unterminated_row", reason, "End the file with a line end.")
        return refusal.of_rows(run_id, row, row), None
    reason = f"the log ends in the middle of row {row} (its last good row is {row - 1})"
    refusal = Refusal(
        "cut_row", reason, "This row is not used. Check whether the run was complete."
    )
    return refusal.of_rows(run_id, row, row), Flaw("truncated", reason)
