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

from oilfilm.logs.encoding import count_rows
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
        return count_rows(self.text, self.start)

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
        try:
            numbers = self._floats(whole, places, misfits)
        except arrow.ArrowInvalid:
            numbers = [self._column(whole, place, misfits) for place in places]
        if not misfits and not self.cut:
            return numbers
        fitting = np.ones(self.rows, dtype=bool)
        fitting[np.array(misfits, dtype=int) - 1] = False
        fitting[self.rows - bool(self.cut) :] = False
        every = np.full((len(places), self.rows), np.nan)
        every[:, fitting] = numbers
        return [*every]

    def show(self, index: int) -> str:
        """A row as it is written."""
        return self._lines[index].decode("utf-8", "replace")

    @cached_property
    def _lines(self) -> list[bytes]:
        return self.text[self.start :].split(b"\n")

    def _column(self, rows: memoryview, place: int, misfits: list[int]) -> FloatArray:
        """The numbers of one column; `misfits` gets the rows that do not fit, which have none."""
        if place in self.stamps:
            texts = self._cells(rows, self.stamps, arrow.string(), misfits)
            return seconds(*(each.to_pandas().str.strip(' "') for each in texts))
        try:
            return self._floats(rows, [place], misfits)[0]
        except arrow.ArrowInvalid:
            (texts,) = self._cells(rows, [place], arrow.binary(), misfits)
            return self._numbers(texts.to_pandas())

    def _floats(
        self, rows: memoryview, places: Sequence[int], misfits: list[int]
    ) -> list[FloatArray]:
        """Numbers of some columns; ArrowInvalid: a cell is none, or a line longer than a block."""
        return [each.to_numpy() for each in self._cells(rows, places, arrow.float64(), misfits)]

    def _cells(
        self, rows: memoryview, places: Sequence[int], kind: arrow.DataType, misfits: list[int]
    ) -> list[arrow.ChunkedArray]:
        misfits.clear()

        def skip(row: arrow_csv.InvalidRow) -> str:
            misfits.append(row.number)
            return "skip"

        names, numbers = [*map(str, range(self.width))], kind == arrow.float64()
        types = {names[place]: kind for place in places}
        block = _BLOCK if numbers else len(rows) + 1
        table = arrow_csv.read_csv(
            arrow.BufferReader(arrow.py_buffer(rows)),
            # one thread: only then are the rows that do not fit numbered
            arrow_csv.ReadOptions(use_threads=False, column_names=names, block_size=block),
            # a stray quote must not swallow the lines up to the next one
            arrow_csv.ParseOptions(
                delimiter=self.delimiter, quote_char=False, invalid_row_handler=skip
            ),
            arrow_csv.ConvertOptions(
                include_columns=[*types],
                column_types=types,
                decimal_point=self.decimal_mark if numbers else ".",
            ),
        )
        return [table[names[place]] for place in places]

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
