"""Channels with clocks of their own, brought to one time.

Decides: at which times the rows of a log are whose channels are sampled apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.logs import base
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.logs.logged_table import LoggedTable, Values

# Clocks that differ by less, in sampling intervals over the whole log, are one clock.
_SAME_CLOCK = 0.1
_ADVICE = (
    "Check the start times and intervals of the channels, or export them together on one time axis."
)


def with_time(table: LoggedTable, vocabulary: Vocabulary) -> LoggedTable:
    """The table with a column of time made of the clocks of its channels, where no column has it.

    Channels with different clocks are interpolated linearly onto the times of the fastest one. The
    first and the last reading of a slower channel hold for one of its intervals. Rows beyond hold
    no number of it.

    Args:
        table: The table.
        vocabulary: What the names of its columns mean.
    """
    meanings = vocabulary.meanings(table.names, table.units)
    has_time = any(quantity == "time" for quantity, _ in meanings.values())
    clocked = [index for index in meanings if index in table.clocks or index in table.time_of]
    if has_time or not clocked or table.columns:
        return table
    if not table.time_of and _is_one_clock([_clock(table, index) for index in clocked], table.rows):
        start, increment, unit = _clock(table, clocked[0])
        return _with_column(
            table, start + increment * np.arange(table.rows, dtype=np.float64), unit, {}
        )
    if len(clocked) < len(meanings):
        # of the other channels nobody knows when they were read
        return table
    return _aligned(table, clocked)


def _is_one_clock(clocks: Sequence[tuple[float, float, str]], rows: int) -> bool:
    """Whether clocks agree over all rows."""
    start, increment, unit = clocks[0]
    return all(
        other_unit == unit
        and abs(other_start - start) + abs(other_increment - increment) * rows
        <= _SAME_CLOCK * abs(increment)
        for other_start, other_increment, other_unit in clocks
    )


def _aligned(table: LoggedTable, indices: Sequence[int]) -> LoggedTable:
    """The table with its channels at the times of the fastest one.

    Args:
        table: The table.
        indices: Indices of the channels that are read.
    """
    channels: dict[int, tuple[FloatArray, FloatArray]] = {}
    units = {table.clocks[index][2] for index in indices if index in table.clocks} or {"s"}
    for index, readings in zip(indices, table.values(indices), strict=True):
        if readings.dtype.kind not in "iuf":
            return table
        times = _times(table, index)
        known = np.flatnonzero(np.isfinite(readings) & np.isfinite(times))
        # shorter channels end in rows without a number
        count = int(known[-1]) + 1 if len(known) else 0
        channels[index] = times[:count], readings[:count].astype(np.float64)
    if len(units) > 1 or any(len(times) < 2 for times, _ in channels.values()):
        return table
    intervals = {index: float(np.median(np.diff(times))) for index, (times, _) in channels.items()}
    if not all(interval > 0 for interval in intervals.values()):
        return table
    shortest = min(intervals.values())
    # of equally fast channels the one that starts first
    fastest = min(
        (index for index in indices if intervals[index] <= shortest * (1 + 1e-9)),
        key=lambda index: channels[index][0][0],
    )
    grid = channels[fastest][0]
    first = max(float(times[0]) for times, _ in channels.values())
    last = min(float(times[-1]) for times, _ in channels.values())
    if first >= last:
        return replace(table, problem=_no_overlap(table, channels))
    aligned: dict[int, Values] = {}
    for index, (times, readings) in channels.items():
        numbers = np.interp(grid, times, readings)
        # what is read as often as the fastest channel has a reading of its own for each row
        held_s = intervals[index] if intervals[index] > 1.5 * shortest else 0.0
        tolerance = _SAME_CLOCK * shortest
        is_beyond = np.maximum(times[0] - grid, grid - times[-1]) > held_s + tolerance
        aligned[index] = np.where(is_beyond, np.nan, numbers)
    note = _note(table, channels, intervals, fastest)
    return _with_column(table, grid, units.pop(), aligned).with_note(note)


def _clock(table: LoggedTable, index: int) -> tuple[float, float, str]:
    """Start, increment and unit of the time of a channel."""
    start, increment, unit = table.clocks[index]
    return start + table.started_s.get(index, 0.0), increment, unit


def _times(table: LoggedTable, index: int) -> FloatArray:
    """Time of each reading of a channel, shape (rows,)."""
    if index in table.time_of:
        (times,) = table.values([table.time_of[index]])
        return times.astype(np.float64) + table.started_s.get(index, 0.0)
    start, increment, _ = _clock(table, index)
    return start + increment * np.arange(table.rows, dtype=np.float64)


def _with_column(
    table: LoggedTable, time: FloatArray, unit: str, aligned: Mapping[int, Values]
) -> LoggedTable:
    """The table with a column of time, and with other numbers in the aligned columns."""
    time_index = len(table.names)
    made = {**aligned, time_index: time}

    def values(indices: Sequence[int]) -> list[Values]:
        logged_indices = [index for index in indices if index not in made]
        logged = dict(zip(logged_indices, table.values(logged_indices), strict=True))
        return [made[index] if index in made else logged[index] for index in indices]

    return replace(
        table,
        names=[*table.names, "time"],
        units=[*table.units, unit],
        values=values,
        rows=len(time),
        # labels are not read by a clock
        texts=None if aligned else table.texts,
        show=None if aligned else table.show,
        cut_row_cells=0 if aligned else table.cut_row_cells,
    )


def _no_overlap(
    table: LoggedTable, channels: Mapping[int, tuple[FloatArray, FloatArray]]
) -> base.Refusal:
    spans = [
        f"{table.names[index][:60]!r} from {times[0]:.6g} to {times[-1]:.6g}"
        for index, (times, _) in channels.items()
    ]
    reason = f"the channels were not read at the same time: {', '.join(spans)}"
    return base.Refusal("clocks", reason, _ADVICE)


def _note(
    table: LoggedTable,
    channels: Mapping[int, tuple[FloatArray, FloatArray]],
    intervals: Mapping[int, float],
    fastest: int,
) -> str:
    """The sentence about channels whose clock is not that of the fastest one."""
    grid = channels[fastest][0]
    others: list[str] = []
    for index, (times, _) in channels.items():
        is_other = abs(intervals[index] - intervals[fastest]) > 1e-9 * intervals[fastest]
        if is_other or abs(times[0] - grid[0]) > _SAME_CLOCK * intervals[fastest]:
            others.append(
                f"{table.names[index][:60]!r} (from {times[0]:.6g}, every {intervals[index]:.4g})"
            )
    return (
        f"{', '.join(others)} have clocks of their own; they are interpolated onto the times of "
        f"{table.names[fastest][:60]!r} (from {grid[0]:.6g}, every {intervals[fastest]:.4g})"
    )
