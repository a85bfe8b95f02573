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

from oilfilm.logs.encoding import count_rows, longest_line
from oilfilm.logs.instants import seconds
from oilfilm.units import FloatArray

_BLOCK = 1 << 22
# Marks between thousands that are no decimal mark anywhere.
_BLANK_GROUPS = r"(?<=\d)[ \u00a0\u202f'\u2019](?=\d{3}(?!\d))"


@dataclass(frozen=True)
class TextTable:
    """Rows of a text log, as UTF-8 with LF line ends.

    Attributes:
        text: A text that ends in the rows; the last one may have no line end, then none of its
            cells is a number.
        width: How many cells a row has.
        delimiter: What parts the cells; no cell holds it.
        decimal_mark: Decimal mark of numbers.
        group_mark: Mark between thousands; empty where there is none.
        stamps: Places of the cells that make a time stamp, that of the time of day first; empty
            where time is a number.
        start: Where the rows begin in the text.
    """

    text: bytes
    width: int
    delimiter: str
    decimal_mark: str
    group_mark: str = ""
    stamps: Sequence[int] = ()
    start: int = 0

    @cached_property
    def rows(self) -> int:
        """How many rows there are, a last one that may be cut too."""
        return count_rows(memoryview(self.text)[self.start :])

    @property
    def cut(self) -> int:
        """How many cells a last row without a line end has; 0 where there is none."""
        tail = self.text[max(self.start, self.text.rfind(b"\n") + 1) :]
        return tail.count(self.delimiter.encode()) + 1 if tail else 0

    def numbers(self, places: Sequence[int]) -> list[FloatArray]:
        """Numbers of some columns, one per row; NaN where a cell holds none.

        A row with more or fewer cells than columns holds no number.
        """
        # no copy: a log may be large
        whole = memoryview(self.text)[self.start : self.text.rfind(b"\n") + 1]
        if not whole:
            return [np.full(self.rows, np.nan) for _ in places]
        misfits: list[int] = []
        plain = [place for place in places if place not in self.stamps]
        numbers: dict[int, FloatArray] = {}
        try:
            every = np.empty((len(plain), self.rows))
            read = 0
            # block by block, so that the numbers are in memory once
            with arrow_csv.open_csv(
                *self._parser(whole, plain, arrow.float64(), misfits)
            ) as blocks:
                for block in blocks:
                    for column, place in zip(every, plain, strict=True):
                        cells = block[str(place)].to_numpy(zero_copy_only=False)
                        column[read : read + len(cells)] = cells
                    read += block.num_rows
            numbers = {place: column[:read] for place, column in zip(plain, every, strict=True)}
        except arrow.ArrowInvalid:
            misfits.clear()
            table = arrow_csv.read_csv(*self._parser(whole, plain, arrow.binary(), misfits))
            numbers = {place: self._numbers(table[str(place)].to_pandas()) for place in plain}
        if self.stamps:
            misfits.clear()
            table = arrow_csv.read_csv(*self._parser(whole, self.stamps, arrow.string(), misfits))
            texts = [table[str(place)].to_pandas() for place in self.stamps]
            numbers[self.stamps[0]] = seconds(*(each.str.strip(' "') for each in texts))
        if not misfits and not self.cut:
            return [numbers[place] for place in places]
        fitting = np.ones(self.rows, dtype=bool)
        fitting[np.array(misfits, dtype=int) - 1] = False
        fitting[self.rows - bool(self.cut) :] = False
        every = np.full((len(places), self.rows), np.nan)
        every[:, fitting] = [numbers[place] for place in places]
        return [*every]

    def show(self, index: int) -> str:
        """A row as it is written."""
        return self._lines[index].decode("utf-8", "replace")

    @cached_property
    def _lines(self) -> list[bytes]:
        return self.text[self.start :].split(b"\n")

    def _parser(
        self, rows: memoryview, places: Sequence[int], kind: arrow.DataType, misfits: list[int]
    ) -> tuple[Any, ...]:
        """What Arrow needs for some columns; rows that do not fit go to `misfits`."""

        def skip(row: arrow_csv.InvalidRow) -> str:
            misfits.append(row.number)
            return "skip"

        types = {str(place): kind for place in places}
        return (
            arrow.BufferReader(arrow.py_buffer(rows)),
            # one thread: only then are the rows that do not fit numbered;
            # no line may be longer than a block
            arrow_csv.ReadOptions(
                use_threads=False,
                column_names=[*map(str, range(self.width))],
                block_size=max(_BLOCK, 1 + longest_line(rows)),
            ),
            # a stray quote must not swallow the lines up to the next one
            arrow_csv.ParseOptions(
                delimiter=self.delimiter, quote_char=False, invalid_row_handler=skip
            ),
            arrow_csv.ConvertOptions(
                include_columns=[*types],
                column_types=types,
                decimal_point=self.decimal_mark if kind == arrow.float64() else ".",
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
