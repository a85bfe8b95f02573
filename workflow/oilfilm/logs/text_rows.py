"""The text of a log: its encoding, its rows as numbers, its time stamps as seconds.

Rows are parsed by Arrow, a column cell by cell where a cell is no number.

Decides: in which encoding a text log is read; which number a cell of a text log holds; how time
stamps are read.
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm.units import FloatArray

HEAD_SEARCHED = 1 << 16
_EMPTY_LINES = re.compile(rb"\n\n+")
_HIGH_BYTES = re.compile(rb"[\x80-\xff]+")
_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
# So many runs of bytes of 128 and above tell the encoding.
_RUNS_SEARCHED = 10_000
# Nearly all Chinese characters in use are in level 1 of GB 2312, whose first bytes are below.
_LEVEL_2 = 0xD8


def encoding_of(content: bytes) -> str:
    """The most likely encoding of a text.

    A mark, zeros (UTF-16) or valid UTF-8 tell it. In a damaged text most bytes of 128 and above
    are as its encoding wants them all the same: UTF-8 is hardly ever met by chance; common Chinese
    characters have two such bytes in GB18030; western letters of Windows-1252 have one between
    others.
    """
    if content.startswith(_UTF8_MARK):
        return "utf-8"
    if content.startswith(_UTF16_MARKS):
        return "utf-16"
    head = content[:2000]
    zeros = head[1::2].count(0), head[0::2].count(0)
    if max(zeros) > len(head) / 4:
        return "utf-16-le" if zeros[0] > zeros[1] else "utf-16-be"
    if content.isascii():
        return "ascii"
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return "utf-8"
    runs = [match[0] for match in islice(_HIGH_BYTES.finditer(content), _RUNS_SEARCHED)]
    letters = b" ".join(runs).decode("utf-8", "replace").replace(" ", "")
    if letters.count("\ufffd") <= len(letters) / 2:
        return "utf-8"
    chinese = sum(len(run) % 2 == 0 and run[0] < _LEVEL_2 for run in runs)
    return "gb18030" if chinese > len(runs) / 2 else "cp1252"


def normalise(content: bytes, encoding: str | None = None) -> bytes:
    """The text as UTF-8 with LF line ends, whatever it was written in.

    Empty lines are left out. Bytes that are not valid in the encoding become the replacement
    character, so that the rows that hold them are refused.

    Args:
        content: The file's bytes, or the first of them.
        encoding: Its encoding; the most likely one if not given.
    """
    encoding = encoding or encoding_of(content)
    if encoding != "ascii":
        content = content.decode(encoding, "replace").encode("utf-8")
    content = content.removeprefix(_UTF8_MARK)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return _EMPTY_LINES.sub(b"\n", content).lstrip(b"\n")


def count_rows(text: bytes, start: int = 0) -> int:
    """Lines of a text without empty lines; the last one counts without a line end too."""
    return text.count(b"\n", start) + (len(text) > start and not text.endswith(b"\n"))


# ---------------------------------------------------------------- rows

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
        block, mark = (_BLOCK, self.decimal_mark) if numbers else (len(rows) + 1, ".")
        # one thread: only then are the rows that do not fit numbered
        read = arrow_csv.ReadOptions(use_threads=False, column_names=names, block_size=block)
        # a stray quote must not swallow the lines up to the next one
        parse = arrow_csv.ParseOptions(
            delimiter=self.delimiter, quote_char=False, invalid_row_handler=skip
        )
        convert = arrow_csv.ConvertOptions(
            include_columns=[*types], column_types=types, decimal_point=mark
        )
        content = arrow.BufferReader(arrow.py_buffer(rows))
        table = arrow_csv.read_csv(content, read, parse, convert)
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


# ---------------------------------------------------------------- time stamps

# Year, month, day by ISO 8601, with `/` or `.` too; or day.month.year, which no country writes
# otherwise. 03/01/2026 may be March or January: it is no date.
_DATE = r"(?P<date>\d{4}([-/.])\d{1,2}\2\d{1,2}|\d{1,2}\.\d{1,2}\.\d{4})"
_CLOCK = r"(?P<h>\d{1,4}):(?P<min>[0-5]\d)(?::(?P<s>[0-5]\d(?:[.,]\d{1,9})?))?"
_ZONE = r"\s?(?:Z|(?P<ahead>[+-]\d\d)(?::?(?P<and>\d\d))?)?"
_STAMP = re.compile(rf"(?:{_DATE}(?:T|\s+))?{_CLOCK}{_ZONE}")
DAY = re.compile(_DATE)
_DAY_S = 86_400.0
_NUMBERS = ("h", "min", "s", "ahead", "and")
_HOUR_S = 3_600.0


def is_stamp(cell: str) -> bool:
    """Whether a cell holds a time of day, with or without its date."""
    return _STAMP.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Whether a cell holds a date alone."""
    return DAY.fullmatch(cell) is not None


def seconds(stamps: "pd.Series[str]", dates: "pd.Series[str] | None" = None) -> FloatArray:
    """Seconds since the first time stamp; NaN where a cell holds none.

    A time of day without a date that falls by more than half a day is of the next day.

    Args:
        stamps: Cells of the time column.
        dates: Cells of a column of dates beside it, if the log has one.

    Examples:
        >>> seconds(pd.Series(["2026-03-01T10:15:00.250", "2026-03-01 10:15:00.750"])).tolist()
        [0.0, 0.5]
    """
    parts = stamps.str.extract(f"^{_STAMP.pattern}$")
    numbers = parts.assign(s=parts["s"].str.replace(",", "."))[[*_NUMBERS]].astype(float)
    numbers = numbers.fillna({"s": 0.0, "ahead": 0.0, "and": 0.0})
    minutes_ahead = 60 * numbers["ahead"] + np.copysign(numbers["and"], numbers["ahead"])
    clock = numbers["h"] * _HOUR_S + numbers["min"] * 60 + numbers["s"] - 60 * minutes_ahead
    time: FloatArray = clock.to_numpy(np.float64, copy=True)
    day = _days(parts["date"] if dates is None else dates)
    dated = bool(np.isfinite(day).any())
    if dated:
        # counted from the first day, because the seconds of centuries leave too few digits
        time += (day - np.nanmin(day)) * _DAY_S
    known = np.flatnonzero(np.isfinite(time))
    if len(known):
        time -= time[known[0]]
        if not dated:
            steps = np.diff(time[known], prepend=0.0)
            time[known] += _DAY_S * np.cumsum(steps < -_DAY_S / 2)
    return time


def _days(texts: "pd.Series[str]") -> FloatArray:
    """Days since a fixed one; NaN where a cell holds no date."""
    dates = texts.where(texts.str.fullmatch(DAY, na=False)).str.replace("[/.]", "-", regex=True)
    first, last = (
        pd.to_datetime(dates, format=form, errors="coerce") for form in ("%Y-%m-%d", "%d-%m-%Y")
    )
    days = (first.fillna(last) - pd.Timestamp(0)) / pd.Timedelta(days=1)
    return np.asarray(days, dtype=np.float64)
