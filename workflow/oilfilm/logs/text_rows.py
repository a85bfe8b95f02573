"""The text of a log: its encoding, its rows as numbers, its time stamps as seconds.

Arrow parses the rows. A column with a cell that is no number is parsed cell by cell.

Decides: in which encoding a text log is read; which number a cell of a text log holds; how time
stamps are read.
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import islice, pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm.base.units import BoolArray, FloatArray

# The header and the names of the columns are in the first so many bytes of a text.
HEAD_BYTES = 1 << 16
_EMPTY_LINES = re.compile(rb"\n\n+")
_HIGH_BYTES = re.compile(rb"[\x80-\xff]+")
# UTF-16 has no four zeros in a row. The number is even, because half of a character in UTF-16
# beside the block may be zero.
_ZERO_BLOCK = re.compile(rb"(?:\0\0){2,}")
_UTF8_BOM = b"\xef\xbb\xbf"
_UTF16_BOMS = (b"\xff\xfe", b"\xfe\xff")
# The encoding is judged by so many sequences of high bytes (128 and above).
_SEQUENCES_SEARCHED = 10_000
# One or two letters of western languages between ASCII characters, and signs of units in
# Windows-1252. Before an ASCII letter a raised 2 or 3 is a letter of another encoding.
_WESTERN_LETTERS = re.compile(
    rb"(?<![\x80-\xff])"
    rb"(?:[\xc0-\xd6\xd8-\xf6\xf8-\xff]{1,2}|[\xb0\xb5\xb7\xb1\x80\x85\x91-\x97]|[\xb2\xb3](?![A-Za-z]))"
    rb"(?![\x80-\xff])"
)
# Encodings that the letters decide: Japanese, Russian, traditional Chinese, central European.
_DETECTABLE_ENCODINGS = ["gb18030", "cp932", "cp1251", "koi8_r", "big5", "cp1250"]
_MOST_BYTES_DETECTED = 1 << 16
# Nearly all Chinese characters in use are in level 1 of GB 2312. Level 2 begins with this byte.
_FIRST_BYTE_OF_GB2312 = 0xA1
_FIRST_BYTE_OF_LEVEL_2 = 0xD8


def encoding_of(content: bytes) -> str:
    """The most likely encoding of a text.

    A byte order mark, zeros (UTF-16) or valid UTF-8 give it. Otherwise the text is judged by its
    bytes of 128 and above, most of which are valid even in a damaged text:

    - valid UTF-8 hardly ever occurs by chance;
    - common Chinese characters have two such bytes in GB18030;
    - western letters and signs have one in Windows-1252, between ASCII letters;
    - other texts have the encoding in which their letters are as frequent as in a language.
    """
    if content.startswith(_UTF8_BOM):
        return "utf-8"
    if content.startswith(_UTF16_BOMS):
        return "utf-16"
    first_bytes = without_zero_blocks(content[:2000])
    zero_count_at_odd = first_bytes[1::2].count(0)
    zero_count_at_even = first_bytes[0::2].count(0)
    if max(zero_count_at_odd, zero_count_at_even) > len(first_bytes) / 4:
        return "utf-16-le" if zero_count_at_odd > zero_count_at_even else "utf-16-be"
    if content.isascii():
        return "ascii"
    with suppress(UnicodeDecodeError):
        content.decode("utf-8")
        return "utf-8"
    matches = list(islice(_HIGH_BYTES.finditer(content), _SEQUENCES_SEARCHED))
    sequences = [match[0] for match in matches]
    letters_as_utf8 = b" ".join(sequences).decode("utf-8", "replace").replace(" ", "")
    if letters_as_utf8.count("\ufffd") <= len(letters_as_utf8) / 2:
        return "utf-8"
    chinese_count = sum(map(_is_common_chinese, sequences))
    # damaged bytes are sequences of their own
    tolerated_count = max(len(sequences) // 10, min(len(sequences) // 3, 1))
    needed_count = len(sequences) - tolerated_count
    if chinese_count >= needed_count:
        return "gb18030"
    end_of_sequences = matches[-1].end()
    western_count = sum(1 for _ in _WESTERN_LETTERS.finditer(content, 0, end_of_sequences))
    if western_count >= needed_count:
        return "cp1252"
    detected_encoding = _detected_encoding(content)
    if detected_encoding:
        return detected_encoding
    # a damaged text is valid in none of the encodings
    return "gb18030" if chinese_count > len(sequences) / 2 else "cp1252"


def _is_common_chinese(sequence: bytes) -> bool:
    """Whether a sequence of bytes of 128 and above is common characters of GB 2312."""
    return len(sequence) % 2 == 0 and _FIRST_BYTE_OF_GB2312 <= sequence[0] < _FIRST_BYTE_OF_LEVEL_2


def _detected_encoding(content: bytes) -> str:
    """The encoding by the frequencies of letters in its language; empty where none is likely."""
    # imported where needed: most logs are ASCII or UTF-8
    from charset_normalizer import from_bytes  # noqa: PLC0415

    lines = content[:_MOST_BYTES_DETECTED].splitlines()
    lines_with_letters = [line for line in lines if not line.isascii()]
    best_match = from_bytes(
        b"\n".join(lines_with_letters), cp_isolation=_DETECTABLE_ENCODINGS
    ).best()
    return best_match.encoding if best_match else ""


def without_zero_blocks(first_bytes: bytes) -> bytes:
    """The first bytes of a file without blocks of zeros, which a full disk or a logger leaves."""
    return _ZERO_BLOCK.sub(b"", first_bytes)


def normalised(content: bytes, encoding: str | None = None) -> bytes:
    """The text as UTF-8 with LF line ends and without empty lines.

    Bytes that are not valid in the encoding become the replacement character. Rows with it are
    refused.

    Args:
        content: The file's bytes, or the first of them.
        encoding: Its encoding; the most likely one if not given. `ascii` is also for a text that is
            UTF-8 already.
    """
    encoding = encoding or encoding_of(content)
    if encoding != "ascii":
        content = content.decode(encoding, "replace").encode("utf-8")
    content = content.removeprefix(_UTF8_BOM)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return _EMPTY_LINES.sub(b"\n", content).lstrip(b"\n")


def count_rows(text: bytes, start: int = 0) -> int:
    """Number of lines of a text without empty lines; the last one may have no line end."""
    line_ends = text.count(b"\n", start)
    last_has_no_end = len(text) > start and not text.endswith(b"\n")
    return line_ends + 1 if last_has_no_end else line_ends


# ---------------------------------------------------------------- rows

_BLOCK_BYTES = 1 << 22
# Marks between thousands that no country uses as a decimal mark.
_MARK_BETWEEN_THOUSANDS = r"(?<=\d)[ \u00a0\u202f'\u2019](?=\d{3}(?!\d))"


@dataclass(frozen=True)
class TextTable:
    """The rows of a text log, and how their cells are written.

    Attributes:
        text: A text that ends in the rows, as UTF-8 with LF line ends. Where the last row has no
            line end, none of its cells counts as a number.
        width: Number of cells in a row.
        delimiter: Character between cells; no cell holds it.
        decimal_mark: Decimal mark of numbers.
        group_mark: Mark between thousands; empty where there is none.
        stamp_indices: Indices of the cells that make a time stamp, that of the time of day first;
            empty where time is a number.
        start_of_rows: Position of the first row in the text.
    """

    text: bytes
    width: int
    delimiter: str
    decimal_mark: str
    group_mark: str = ""
    stamp_indices: Sequence[int] = ()
    start_of_rows: int = 0

    @cached_property
    def row_count(self) -> int:
        """Number of rows, with a last one that has no line end."""
        return count_rows(self.text, self.start_of_rows)

    @property
    def cut_row_cell_count(self) -> int:
        """Number of cells of a last row without a line end; 0 where the last row has one."""
        cut_row = self.text[max(self.start_of_rows, self.text.rfind(b"\n") + 1) :]
        return cut_row.count(self.delimiter.encode()) + 1 if cut_row else 0

    def numbers(self, column_indices: Sequence[int]) -> list[FloatArray]:
        """Numbers of the columns with some indices, each of shape (rows,); NaN without a number.

        A row with more or fewer cells than columns holds no number.
        """
        if not column_indices:
            return []
        # the rows that have a line end; no copy, because a log may be large
        ended_rows = memoryview(self.text)[self.start_of_rows : self.text.rfind(b"\n") + 1]
        if not ended_rows:
            return [np.full(self.row_count, np.nan) for _ in column_indices]
        misfit_row_numbers: list[int] = []
        try:
            numbers = self._parsed_by_arrow(ended_rows, column_indices, misfit_row_numbers)
        except arrow.ArrowInvalid:
            numbers = [
                self._numbers_of_column(ended_rows, index, misfit_row_numbers)
                for index in column_indices
            ]
        if not misfit_row_numbers and not self.cut_row_cell_count:
            return numbers
        numbers_of_all_rows = np.full((len(column_indices), self.row_count), np.nan)
        numbers_of_all_rows[:, self._has_all_cells(misfit_row_numbers)] = numbers
        return list(numbers_of_all_rows)

    def texts(self, column_index: int) -> npt.NDArray[np.object_]:
        """Text of each cell of a column, shape (rows,).

        It is empty in a row with more or fewer cells than columns.
        """
        texts = np.full(self.row_count, "", dtype=object)
        ended_rows = memoryview(self.text)[self.start_of_rows : self.text.rfind(b"\n") + 1]
        if not ended_rows:
            return texts
        misfit_row_numbers: list[int] = []
        (cells,) = self._cells(ended_rows, [column_index], arrow.binary(), misfit_row_numbers)
        # few texts differ: one object for each
        encoded_cells = cells.combine_chunks().dictionary_encode()
        distinct_texts = [
            cell.decode("utf-8", "replace").strip(' "')
            for cell in encoded_cells.dictionary.to_pylist()
        ]
        codes = encoded_cells.indices.to_numpy()
        texts[self._has_all_cells(misfit_row_numbers)] = np.array(distinct_texts, dtype=object)[
            codes
        ]
        return texts

    def _has_all_cells(self, misfit_row_numbers: Sequence[int]) -> BoolArray:
        """Mask of the rows that have a line end and a cell for each column, shape (rows,)."""
        has_all_cells = np.ones(self.row_count, dtype=bool)
        has_all_cells[np.array(misfit_row_numbers, dtype=int) - 1] = False
        if self.cut_row_cell_count:
            has_all_cells[-1] = False
        return has_all_cells

    def row_text(self, row_index: int) -> str:
        """The text of the row with an index."""
        return self._lines[row_index].decode("utf-8", "replace")

    @cached_property
    def _lines(self) -> list[bytes]:
        return self.text[self.start_of_rows :].split(b"\n")

    def _numbers_of_column(
        self, rows_text: memoryview, column_index: int, misfit_row_numbers: list[int]
    ) -> FloatArray:
        """The numbers of one column, without rows that do not fit.

        Args:
            rows_text: Text of the rows.
            column_index: Index of the column.
            misfit_row_numbers: Filled with the numbers, from 1, of rows with more or fewer cells
                than columns.
        """
        if column_index in self.stamp_indices:
            cells = self._cells(rows_text, self.stamp_indices, arrow.string(), misfit_row_numbers)
            return seconds_of_stamps(*(column.to_pandas().str.strip(' "') for column in cells))
        try:
            return self._parsed_by_arrow(rows_text, [column_index], misfit_row_numbers)[0]
        except arrow.ArrowInvalid:
            (column,) = self._cells(rows_text, [column_index], arrow.binary(), misfit_row_numbers)
            return self._parsed_cell_by_cell(column.to_pandas())

    def _parsed_by_arrow(
        self, rows_text: memoryview, column_indices: Sequence[int], misfit_row_numbers: list[int]
    ) -> list[FloatArray]:
        """Numbers of some columns, as `_numbers_of_column`.

        Raises:
            ArrowInvalid: A cell is no number, or a line is longer than a block.
        """
        columns = self._cells(rows_text, column_indices, arrow.float64(), misfit_row_numbers)
        numbers = [column.to_numpy() for column in columns]
        del columns
        # Arrow keeps freed memory for itself: as much as the numbers of a long log
        arrow.default_memory_pool().release_unused()
        return numbers

    def _cells(
        self,
        rows_text: memoryview,
        column_indices: Sequence[int],
        cell_type: arrow.DataType,
        misfit_row_numbers: list[int],
    ) -> list[arrow.ChunkedArray]:
        """Cells of some columns in a type of Arrow, as `_numbers_of_column`."""
        misfit_row_numbers.clear()

        def skip(row: arrow_csv.InvalidRow) -> str:
            misfit_row_numbers.append(row.number)
            return "skip"

        names = [str(index) for index in range(self.width)]
        types = {names[index]: cell_type for index in column_indices}
        if cell_type == arrow.float64():
            block_bytes = _BLOCK_BYTES
            decimal_mark = self.decimal_mark
        else:
            # one block: a line may be longer than the usual one
            block_bytes = len(rows_text) + 1
            decimal_mark = "."
        table = arrow_csv.read_csv(
            arrow.BufferReader(arrow.py_buffer(rows_text)),
            # one thread: only then are the rows that do not fit numbered
            arrow_csv.ReadOptions(use_threads=False, column_names=names, block_size=block_bytes),
            # no quotes: an unpaired one would join the lines up to the next quote
            arrow_csv.ParseOptions(
                delimiter=self.delimiter, quote_char=False, invalid_row_handler=skip
            ),
            arrow_csv.ConvertOptions(
                include_columns=list(types), column_types=types, decimal_point=decimal_mark
            ),
        )
        return [table[names[index]] for index in column_indices]

    def _parsed_cell_by_cell(self, cells: "pd.Series[Any]") -> FloatArray:
        """Numbers of raw cells; NaN where a cell holds anything else."""
        texts = cells.map(lambda cell: cell.decode("utf-8", "replace").strip(' "'), "ignore")
        texts = texts.str.replace(_MARK_BETWEEN_THOUSANDS, "", regex=True)
        other_mark = "," if self.decimal_mark == "." else "."
        if self.group_mark:
            # 0.052 is no number with a mark between thousands
            grouped_number = (
                rf"[-+]?[1-9]\d{{0,2}}(?:\{other_mark}\d{{3}})+(?:\{self.decimal_mark}\d*)?"
            )
            ungrouped_texts = texts.str.replace(other_mark, "", regex=False)
            texts = texts.where(~texts.str.fullmatch(grouped_number, na=False), ungrouped_texts)
        # the other mark would be a second decimal mark: such a cell is no number
        texts = texts.str.replace(other_mark, "?", regex=False).str.replace(",", ".", regex=False)
        return pd.to_numeric(texts, errors="coerce").to_numpy(dtype=np.float64)


# ---------------------------------------------------------------- time stamps

# Year, month, day by ISO 8601, with `/` or `.` too; or day.month.year, which is unambiguous.
# 03/01/2026 may be March or January: it is no date.
_DATE = r"(?P<date>\d{4}([-/.])\d{1,2}\2\d{1,2}|\d{1,2}\.\d{1,2}\.\d{4})"
_TIME_OF_DAY = r"(?P<h>\d{1,4}):(?P<min>[0-5]\d)(?::(?P<s>[0-5]\d(?:[.,]\d{1,9})?))?"
_TIME_ZONE = r"\s?(?:Z|(?P<zone_h>[+-]\d\d)(?::?(?P<zone_min>\d\d))?)?"
_TIME_STAMP = re.compile(rf"(?:{_DATE}(?:T|\s+))?{_TIME_OF_DAY}{_TIME_ZONE}")
DATE_PATTERN = re.compile(_DATE)
_NUMBER_FIELDS_OF_STAMP = ["h", "min", "s", "zone_h", "zone_min"]
_S_PER_DAY = 86_400.0
_S_PER_HOUR = 3_600.0
# At most so many consecutive rows have a wrong time of day.
_MOST_WRONG_STAMPS = 10


def is_stamp(cell: str) -> bool:
    """Whether a cell holds a time of day, with or without its date."""
    return _TIME_STAMP.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Whether a cell holds a date alone."""
    return DATE_PATTERN.fullmatch(cell) is not None


def seconds_of_stamps(
    stamps: "pd.Series[str]", dates: "pd.Series[str] | None" = None
) -> FloatArray:
    """Seconds since the first time stamp, shape (rows,); NaN where a cell holds none.

    Without dates, a time of day that falls by more than half a day begins the next day. It does not
    where time returns to its old course within a few rows: these rows have wrong stamps.

    Args:
        stamps: Cells of the time column.
        dates: Cells of a column of dates beside it, if the log has one.

    Examples:
        >>> stamps = pd.Series(["2026-03-01T10:15:00.250", "2026-03-01 10:15:00.750"])
        >>> seconds_of_stamps(stamps).tolist()
        [0.0, 0.5]
    """
    fields = stamps.str.extract(f"^{_TIME_STAMP.pattern}$")
    fields["s"] = fields["s"].str.replace(",", ".")
    number_fields = fields[_NUMBER_FIELDS_OF_STAMP].astype(float)
    number_fields = number_fields.fillna({"s": 0.0, "zone_h": 0.0, "zone_min": 0.0})
    zone_offset_min = 60 * number_fields["zone_h"] + np.copysign(
        number_fields["zone_min"], number_fields["zone_h"]
    )
    local_s = number_fields["h"] * _S_PER_HOUR + number_fields["min"] * 60 + number_fields["s"]
    time_s: FloatArray = (local_s - 60 * zone_offset_min).to_numpy(np.float64, copy=True)
    days = _days_since_1970(fields["date"] if dates is None else dates)
    has_dates = bool(np.isfinite(days).any())
    if has_dates:
        # counted from the first day, because the seconds of centuries leave too few digits
        time_s += (days - np.nanmin(days)) * _S_PER_DAY
    rows_with_time = np.flatnonzero(np.isfinite(time_s))
    if len(rows_with_time):
        time_s -= time_s[rows_with_time[0]]
        if not has_dates:
            begins_next_day = _begins_next_day(time_s[rows_with_time])
            time_s[rows_with_time] += _S_PER_DAY * np.cumsum(begins_next_day)
    return time_s


def _begins_next_day(time_of_day_s: FloatArray) -> BoolArray:
    """Mask of the rows that begin the next day, shape (rows,)."""
    change_s = np.diff(time_of_day_s, prepend=time_of_day_s[0])
    begins_next_day = change_s < -_S_PER_DAY / 2
    rows_after_jump = np.flatnonzero(np.abs(change_s) > _S_PER_DAY / 2).tolist()
    first_unmarked_row = 0
    for row, next_row in pairwise(rows_after_jump):
        returns_to_course = (
            change_s[row] * change_s[next_row] < 0 and next_row - row <= _MOST_WRONG_STAMPS
        )
        time_rises = time_of_day_s[next_row] >= time_of_day_s[row - 1]
        if row >= first_unmarked_row and returns_to_course and time_rises:
            begins_next_day[[row, next_row]] = False
            first_unmarked_row = next_row + 1
    return begins_next_day


def _days_since_1970(texts: "pd.Series[str]") -> FloatArray:
    """Days since 1970, shape (rows,); NaN where a cell holds no date."""
    dates = texts.where(texts.str.fullmatch(DATE_PATTERN, na=False)).str.replace(
        "[/.]", "-", regex=True
    )
    year_first = pd.to_datetime(dates, format="%Y-%m-%d", errors="coerce")
    day_first = pd.to_datetime(dates, format="%d-%m-%Y", errors="coerce")
    days = (year_first.fillna(day_first) - pd.Timestamp(0)) / pd.Timedelta(days=1)
    return np.asarray(days, dtype=np.float64)
