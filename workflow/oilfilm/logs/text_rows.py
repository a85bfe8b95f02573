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

from oilfilm.logs.encoding import line_ends
from oilfilm.logs.instants import seconds
from oilfilm.units import FloatArray

# Marks between thousands that are no decimal mark anywhere.
_BLANK_GROUPS = r"(?<=\d)[ \u00a0\u202f'\u2019](?=\d{3}(?!\d))"


@dataclass(frozen=True)
class TextTable:
    """Rows of a text log, as UTF-8 with LF line ends.

    Attributes:
        text: The rows; the last one may have no line end, then none of its cells is a number.
        width: How many cells a row has.
        delimiter: What parts the cells; no cell holds it.
        decimal_mark: Decimal mark of numbers.
        group_mark: Mark between thousands; empty where there is none.
        stamps: Places of the cells that make a time stamp, that of the time of day first; empty
            where time is a number.
    """

    text: bytes
    width: int
    delimiter: str
    decimal_mark: str
    group_mark: str = ""
    stamps: Sequence[int] = ()

    @cached_property
    def rows(self) -> int:
        """How many rows there are, a last one that may be cut too."""
        return count_rows(self.text)

    @property
    def cut(self) -> int:
        """How many cells a last row without a line end has; 0 where there is none."""
        tail = self.text[self.text.rfind(b"\n") + 1 :]
        return tail.count(self.delimiter.encode()) + 1 if tail else 0

    def numbers(self, places: Sequence[int]) -> list[FloatArray]:
        """Numbers of some columns, one per row; NaN where a cell holds none.

        A row with more or fewer cells than columns holds no number.
        """
        whole = self.text[: self.text.rfind(b"\n") + 1]
        every = np.full((len(places), self.rows), np.nan)
        if not whole:
            return [*every]
        misfits: list[int] = []
        plain = [place for place in places if place not in self.stamps]
        try:
            table = self._parsed(whole, places, arrow.float64(), self.decimal_mark, misfits)
            numbers = {place: table[str(place)].to_numpy() for place in plain}
        except arrow.ArrowInvalid:
            misfits.clear()
            table = self._parsed(whole, places, arrow.binary(), ".", misfits)
            numbers = {place: self._numbers(table[str(place)].to_pandas()) for place in plain}
        if self.stamps:
            texts = [table[str(place)].to_pandas() for place in self.stamps]
            numbers[self.stamps[0]] = seconds(*(each.str.strip(' "') for each in texts))
        columns = [numbers[place] for place in places]
        if not misfits and not self.cut:
            return columns
        fitting = np.ones(self.rows, dtype=bool)
        fitting[np.array(misfits, dtype=int) - 1] = False
        fitting[self.rows - bool(self.cut) :] = False
        every[:, fitting] = columns
        return [*every]

    def show(self, index: int) -> str:
        """A row as it is written."""
        return self._lines[index].decode("utf-8", "replace")

    @cached_property
    def _lines(self) -> list[bytes]:
        return self.text.split(b"\n")

    def _parsed(
        self,
        rows: bytes,
        places: Sequence[int],
        kind: arrow.DataType,
        decimal_mark: str,
        misfits: list[int],
    ) -> arrow.Table:
        """Cells of the columns; the numbers of the rows that do not fit go to `misfits`."""

        def skip(row: arrow_csv.InvalidRow) -> str:
            misfits.append(row.number)
            return "skip"

        types = {str(place): kind for place in places}
        types |= {str(place): arrow.string() for place in self.stamps}
        return arrow_csv.read_csv(
            arrow.BufferReader(rows),
            # one thread: only then are the rows that do not fit numbered;
            # one block: a line longer than a block could not be read
            read_options=arrow_csv.ReadOptions(
                use_threads=False,
                column_names=[*map(str, range(self.width))],
                block_size=len(rows) + 1,
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


def count_rows(text: bytes) -> int:
    """Lines of a text without empty lines; the last one counts without a line end too."""
    return int(np.count_nonzero(line_ends(text))) + (text != b"" and not text.endswith(b"\n"))
