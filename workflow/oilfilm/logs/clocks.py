"""Channels with clocks of their own, brought to one time.

Decides: the times of the rows where the channels of a log are sampled at different times.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.logs import base
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import Clock, LoggedTable, Values

# Clocks whose times differ by less in every row, in sampling intervals, are one clock.
LARGEST_CLOCK_DIFFERENCE = 0.1
_CLOCKS_ADVICE = (
    "Check the start times and intervals of the channels, or export them together on one time axis."
)


def with_time_column(table: LoggedTable, vocabulary: Vocabulary) -> LoggedTable:
    """The table with a column of time made of the clocks of its channels, where no column has it.

    Channels with different clocks are interpolated linearly onto the times of the fastest one. The
    first and the last reading of a channel that is more than 1.5 times slower hold for one of its
    intervals. Rows beyond these have no number of that channel.

    Args:
        table: The table.
        vocabulary: What the names of its columns mean.
    """
    quantities_and_units = vocabulary.quantities_and_units(table.names, table.units)
    has_time = any(quantity == "time" for quantity, _ in quantities_and_units.values())
    clocked_column_indices = [
        index
        for index in quantities_and_units
        if index in table.clock_of_column or index in table.time_index_of_column
    ]
    # a format that knows its columns (`table.columns`) knows its time, too
    if has_time or not clocked_column_indices or table.columns:
        return table
    indices_without_start = [
        index for index in clocked_column_indices if np.isnan(_start_of_channel(table, index))
    ]
    if indices_without_start:
        return replace(table, problem=_unknown_start_problem(table, indices_without_start))
    if not table.time_index_of_column:
        clocks = [_clock_since_log_start(table, index) for index in clocked_column_indices]
        if _is_one_clock(clocks, table.row_count):
            return _append_time_column(
                table, _times_by_clock(clocks[0], table.row_count), clocks[0].unit, {}
            )
    if len(clocked_column_indices) < len(quantities_and_units):
        # the times of the other channels are not known
        return table
    return _align_channels(table, clocked_column_indices)


def _is_one_clock(clocks: Sequence[Clock], row_count: int) -> bool:
    """Whether clocks agree over all rows."""
    first_clock = clocks[0]
    for clock in clocks:
        # the difference is linear in the row: it is largest in the first or the last one
        start_difference = clock.start - first_clock.start
        end_difference = start_difference + (clock.interval - first_clock.interval) * (
            row_count - 1
        )
        difference = max(abs(start_difference), abs(end_difference))
        if clock.unit != first_clock.unit or not difference <= LARGEST_CLOCK_DIFFERENCE * abs(
            first_clock.interval
        ):
            return False
    return True


class _Channel(NamedTuple):
    """Readings of a channel and the time of each, both of shape (readings,).

    They begin and end with a reading whose time is known.
    """

    times: FloatArray
    readings: FloatArray


def _align_channels(table: LoggedTable, channel_indices: Sequence[int]) -> LoggedTable:
    """The table with its channels at the times of the fastest one.

    Args:
        table: The table.
        channel_indices: Indices of the channels that are read.
    """
    channels: dict[int, _Channel] = {}
    times_of_index: dict[int, FloatArray] = {}
    readings_of_index: dict[int, FloatArray] = {}
    units = {
        table.clock_of_column[index].unit
        for index in channel_indices
        if index in table.clock_of_column
    } or {"s"}
    for index, readings in zip(channel_indices, table.read_values(channel_indices), strict=True):
        if readings.dtype.kind not in "iuf":
            return table
        times_of_index[index] = _times_of_channel(table, index)
        readings_of_index[index] = readings.astype(np.float64)
        channels[index] = _trimmed_channel(times_of_index[index], readings_of_index[index])
    if len(units) > 1 or any(len(channel.times) < 2 for channel in channels.values()):
        return table
    for index in channels:
        # the times as the log has them, without the start of the channel's record
        logged_times = times_of_index[index] - table.start_s_of_column.get(index, 0.0)
        problem = _falling_time_problem(table.names[index], logged_times)
        if problem:
            return replace(table, problem=problem)
    interval_of_index = {
        index: float(np.median(np.diff(channel.times))) for index, channel in channels.items()
    }
    if not all(interval > 0 for interval in interval_of_index.values()):
        return table
    shortest_interval = min(interval_of_index.values())
    # of equally fast channels the one that starts first
    fastest_index = min(
        (
            index
            for index in channel_indices
            if interval_of_index[index] <= shortest_interval * (1 + 1e-9)
        ),
        key=lambda index: channels[index].times[0],
    )
    times_of_fastest = times_of_index[fastest_index]
    latest_start = max(float(channel.times[0]) for channel in channels.values())
    earliest_end = min(float(channel.times[-1]) for channel in channels.values())
    if latest_start >= earliest_end:
        return replace(table, problem=_no_overlap_problem(table, channels))
    # a reading with a time of its own is not interpolated
    numbers_of_index: dict[int, Values] = {fastest_index: readings_of_index[fastest_index]}
    for index, (times, readings) in channels.items():
        if index == fastest_index:
            continue
        interpolated_readings = np.interp(times_of_fastest, times, readings)
        # a channel that is read nearly as often as the fastest one has a reading beside each row
        hold_time = (
            interval_of_index[index] if interval_of_index[index] > 1.5 * shortest_interval else 0.0
        )
        tolerance = LARGEST_CLOCK_DIFFERENCE * shortest_interval
        is_beyond = (
            np.maximum(times[0] - times_of_fastest, times_of_fastest - times[-1])
            > hold_time + tolerance
        )
        numbers_of_index[index] = np.where(is_beyond, np.nan, interpolated_readings)
    table_with_time = _append_time_column(table, times_of_fastest, units.pop(), numbers_of_index)
    note = _note_on_clocks(table, channels, interval_of_index, fastest_index)
    return table_with_time.with_note(note) if note else table_with_time


def _trimmed_channel(times_of_row: FloatArray, readings_of_row: FloatArray) -> _Channel:
    """The readings of a channel, without the rows above its first and below its last one.

    Args:
        times_of_row: Its times, shape (rows,).
        readings_of_row: Its readings, shape (rows,).
    """
    # shorter channels end in rows without a number
    indices_with_reading = np.flatnonzero(np.isfinite(readings_of_row) & np.isfinite(times_of_row))
    if len(indices_with_reading) == 0:
        return _Channel(np.array([]), np.array([]))
    row_indices = np.arange(indices_with_reading[0], indices_with_reading[-1] + 1)
    times, readings = times_of_row[row_indices], readings_of_row[row_indices]
    # a row without a time is a gap between its neighbours
    has_time = np.isfinite(times)
    return _Channel(
        np.interp(row_indices, row_indices[has_time], times[has_time]),
        np.where(has_time, readings, np.nan),
    )


def _falling_time_problem(name: str, times_of_row: FloatArray) -> base.Refusal | None:
    """Why a channel whose time falls cannot be brought to the time of others; None if it rises."""
    rows_with_time = np.flatnonzero(np.isfinite(times_of_row))
    times = times_of_row[rows_with_time]
    falls = np.flatnonzero(np.diff(times) < 0)
    if len(falls) == 0:
        return None
    fall = int(falls[0])
    reason = (
        f"the channels have clocks of their own, and the time of {name[:60]!r} falls from "
        f"{times[fall]:.12g} to {times[fall + 1]:.12g} in row {rows_with_time[fall + 1] + 1} of "
        "its table; expected times that rise"
    )
    advice = (
        "Correct this time where it is wrong; where a run begins there, export each run on its own."
    )
    return base.Refusal("clocks", reason, advice)


def _clock_since_log_start(table: LoggedTable, index: int) -> Clock:
    """The clock of a channel, counted from the start of the log."""
    return table.clock_of_column[index]._replace(start=_start_of_channel(table, index))


def _times_by_clock(clock: Clock, row_count: int) -> FloatArray:
    """Time of each row by a clock, shape (rows,)."""
    return clock.start + clock.interval * np.arange(row_count, dtype=np.float64)


def _times_of_channel(table: LoggedTable, index: int) -> FloatArray:
    """Time of each reading of a channel, shape (rows,)."""
    if index in table.time_index_of_column:
        (times,) = table.read_values([table.time_index_of_column[index]])
        return times.astype(np.float64) + table.start_s_of_column.get(index, 0.0)
    return _times_by_clock(_clock_since_log_start(table, index), table.row_count)


def _append_time_column(
    table: LoggedTable, time: FloatArray, unit: str, aligned_values_of_index: Mapping[int, Values]
) -> LoggedTable:
    """The table with a column of time, and with other numbers in the aligned columns."""
    time_index = len(table.names)
    new_values_of_index = {**aligned_values_of_index, time_index: time}

    def read_values(column_indices: Sequence[int]) -> list[Values]:
        logged_indices = [index for index in column_indices if index not in new_values_of_index]
        logged_values_of_index = dict(
            zip(logged_indices, table.read_values(logged_indices), strict=True)
        )
        return [
            new_values_of_index[index]
            if index in new_values_of_index
            else logged_values_of_index[index]
            for index in column_indices
        ]

    return replace(
        table,
        names=[*table.names, "time"],
        units=[*table.units, unit],
        read_values=read_values,
        # the texts of channels belong to their own times, not to these
        read_texts=None if aligned_values_of_index else table.read_texts,
        show_row=None if aligned_values_of_index else table.show_row,
        # with the cell of the time
        cut_row_cell_count=table.cut_row_cell_count + 1 if table.cut_row_cell_count else 0,
    )


def _start_of_channel(table: LoggedTable, index: int) -> float:
    """Start of a channel; NaN where it is not known.

    Its clock counts from the start of the channel's own record, whose start after that of the log
    is in `start_s_of_column`.
    """
    start = table.clock_of_column[index].start if index in table.clock_of_column else 0.0
    return start + table.start_s_of_column.get(index, 0.0)


def _unknown_start_problem(table: LoggedTable, indices: Sequence[int]) -> base.Refusal:
    """Why channels cannot be paired: those with these indices have no start time.

    Where the channels that have one agree, the reader of the format gives the others the same.
    """
    names = ", ".join(repr(table.names[index][:60]) for index in indices)
    reason = (
        f"the file gives no start time for {names}, and its other start times differ from each "
        "other"
    )
    return base.Refusal("clocks", reason, _CLOCKS_ADVICE)


def _no_overlap_problem(table: LoggedTable, channels: Mapping[int, _Channel]) -> base.Refusal:
    spans_of_channels = [
        f"{table.names[index][:60]!r} from {channel.times[0]:.12g} to {channel.times[-1]:.12g}"
        for index, channel in channels.items()
    ]
    reason = f"the channels were not read at the same time: {', '.join(spans_of_channels)}"
    return base.Refusal("clocks", reason, _CLOCKS_ADVICE)


def _note_on_clocks(
    table: LoggedTable,
    channels: Mapping[int, _Channel],
    interval_of_index: Mapping[int, float],
    fastest_index: int,
) -> str:
    """The sentence about channels whose clock is not that of the fastest one; empty if all are."""
    times_of_fastest = channels[fastest_index].times
    other_channels: list[str] = []
    for index, channel in channels.items():
        times = channel.times
        has_other_interval = (
            abs(interval_of_index[index] - interval_of_index[fastest_index])
            > 1e-9 * interval_of_index[fastest_index]
        )
        if (
            has_other_interval
            or abs(times[0] - times_of_fastest[0])
            > LARGEST_CLOCK_DIFFERENCE * interval_of_index[fastest_index]
        ):
            other_channels.append(
                f"{table.names[index][:60]!r} (from {times[0]:.12g}, every "
                f"{interval_of_index[index]:.4g})"
            )
    if not other_channels:
        return ""
    return (
        f"{', '.join(other_channels)} have clocks of their own; they are interpolated onto the "
        "times of "
        f"{table.names[fastest_index][:60]!r} (from {times_of_fastest[0]:.12g}, every "
        f"{interval_of_index[fastest_index]:.4g})"
    )
