"""Time stamps of text logs: date and time of day as seconds since the first row.

Decides: how time stamps are read.
"""

import re
from collections.abc import Callable
from datetime import date

import numpy as np
import pandas as pd

from oilfilm.units import FloatArray

# Year, month, day by ISO 8601, with `/` or `.` too; or day.month.year, which no country writes
# otherwise. 03/01/2026 may be March or January: it is no date.
_DATE = r"(?P<date>\d{4}([-/.])\d{1,2}\2\d{1,2}|\d{1,2}\.\d{1,2}\.\d{4})"
_CLOCK = r"(?P<h>\d{1,4}):(?P<min>[0-5]\d)(?::(?P<s>[0-5]\d(?:[.,]\d{1,9})?))?"
_ZONE = r"\s?(?P<zone>Z|[+-]\d\d(?::?\d\d)?)?"
_STAMP = re.compile(rf"(?:{_DATE}(?:T|\s+))?{_CLOCK}{_ZONE}")
_DAY = re.compile(_DATE)
_DAY_S = 86_400.0
_HOUR_S = 3_600.0


def is_stamp(cell: str) -> bool:
    """Whether a cell holds a time of day, with or without its date."""
    return _STAMP.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Whether a cell holds a date alone."""
    return _DAY.fullmatch(cell) is not None


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
    clock: FloatArray = np.asarray(
        parts["h"].astype(float) * _HOUR_S
        + parts["min"].astype(float) * 60
        + parts["s"].str.replace(",", ".").astype(float).fillna(0.0),
        dtype=np.float64,
    )
    time: FloatArray = clock - _by_text(parts["zone"].fillna("Z"), _offset_s)
    day = _by_text(parts["date"] if dates is None else dates, _day)
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


def _by_text(texts: "pd.Series[str]", number: Callable[[str], float]) -> FloatArray:
    """A number for each text, found once for texts that are the same; NaN where there is none."""
    known = {}
    for text in texts.dropna().unique():
        try:
            known[text] = number(text)
        except ValueError:
            continue
    return texts.map(known).to_numpy(dtype=np.float64)


def _day(text: str) -> float:
    if not is_date(text):
        raise ValueError(f"{text!r} is no date")
    parts = [int(part) for part in re.split("[-/.]", text)]
    return float(date(*(parts if parts[0] > 31 else parts[::-1])).toordinal())


def _offset_s(zone: str) -> float:
    """Seconds that local time is ahead of UTC."""
    if zone == "Z":
        return 0.0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    ahead = int(digits[:2]) * _HOUR_S + int(digits[2:]) * 60
    return -ahead if zone.startswith("-") else ahead
