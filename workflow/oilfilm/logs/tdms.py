"""LabVIEW's binary logs (TDMS): groups of channels with properties; one with rows is a run."""

import io
import logging
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from nptdms import TdmsChannel, TdmsFile, TdmsGroup
from nptdms.log import log_manager

from oilfilm.base.plain_key import plain_key
from oilfilm.logs.base import (
    NO_DIALECT,
    Refusal,
    UnreadableLogError,
    check_row_count,
    distinct_names,
)
from oilfilm.logs.clocks import LARGEST_CLOCK_DIFFERENCE
from oilfilm.logs.columns import as_seconds, text_of_value, texts_of_values
from oilfilm.logs.header import header_of_part, joined_texts
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import Clock, LoggedTable, TablesOfFile, Texts, Values

# A segment begins with a tag. The tag, flags, and the numbers of bytes are its lead-in.
_TAG = b"TDSm"
_LEAD_IN_BYTES = 28
# LabVIEW writes this number of bytes first, and the true one when the segment is complete.
_UNKNOWN_BYTE_COUNT = (1 << 64) - 1
# Flag of numbers whose most significant byte is the first.
_BIG_ENDIAN = 1 << 6
# Largest number of scalings, and of their coefficients, in a log of a rig. The library loops over
# them.
_MOST_SCALINGS = 1000
# LabVIEW writes an unknown start as one of 1904.
_EARLIEST_START = np.datetime64("1970-01-01")

# Its warnings about damaged files would repeat the message of the refusal on the terminal.
log_manager.set_level(logging.ERROR)


def recognises(first_bytes: bytes) -> bool:
    """True where the file begins with the tag of a segment."""
    return first_bytes.startswith(_TAG)


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    refusal, value_byte_count = _read_segments(content)
    with TdmsFile.open(io.BytesIO(content)) as log:
        channels = [channel for group in log.groups() for channel in group.channels()]
        properties = [log.properties]
        properties += [group.properties for group in log.groups()]
        properties += [channel.properties for channel in channels]
        _check_claimed_sizes(channels, properties, content)
        if not refusal:
            _check_value_byte_count(channels, value_byte_count)
        groups = [
            group for group in log.groups() if any(len(channel) > 0 for channel in group.channels())
        ]
        if refusal and not groups:
            advice = "Copy it again, or repeat the run."
            raise UnreadableLogError(refusal.reason, advice, rule="damaged_file")
        run_names = distinct_names(group.name for group in groups)
        if len(groups) == 1:
            run_names = [""]
        # read here, while the file is open
        return NO_DIALECT, [
            _table(group, log.properties, run_name, refusal, vocabulary, content)
            for group, run_name in zip(groups, run_names, strict=True)
        ]


def _read_segments(content: bytes) -> tuple[Refusal | None, int]:
    """A refusal if the last segment is incomplete, and the number of bytes of values before it."""
    position = 0
    segment_number = 0
    value_byte_count = 0
    while position < len(content):
        segment_number += 1
        incomplete_refusal = Refusal(
            "truncated",
            f"the file ends within segment {segment_number}, which was not written to its end",
        )
        lead_in = content[position : position + _LEAD_IN_BYTES]
        if not _TAG.startswith(lead_in[:4]):
            # another tag is damage, which the library reports
            return None, value_byte_count
        if len(lead_in) < _LEAD_IN_BYTES:
            return incomplete_refusal, value_byte_count
        byte_order = ">" if lead_in[4] & _BIG_ENDIAN else "<"
        segment_byte_count, metadata_byte_count = struct.unpack(f"{byte_order}QQ", lead_in[12:28])
        end = position + _LEAD_IN_BYTES + segment_byte_count
        if segment_byte_count == _UNKNOWN_BYTE_COUNT or end > len(content):
            return incomplete_refusal, value_byte_count
        position = end
        value_byte_count += segment_byte_count - metadata_byte_count
    return None, value_byte_count


def _check_value_byte_count(channels: Sequence[TdmsChannel], value_byte_count: int) -> None:
    """Compare the values of the channels with those of the segments.

    Raises:
        ValueError: The numbers of bytes differ.
    """
    channel_byte_count = 0
    for channel in channels:
        # channels without data have no type
        bytes_per_value = getattr(channel.data_type, "size", 0)
        if bytes_per_value is None:
            # texts and raw data of DAQmx have no size: nothing can be compared
            return
        channel_byte_count += len(channel) * bytes_per_value
    if channel_byte_count != value_byte_count:
        raise ValueError(
            f"its channels have {channel_byte_count} bytes of values, its segments "
            f"{value_byte_count}"
        )


def _check_claimed_sizes(
    channels: Sequence[TdmsChannel],
    properties_of_objects: Sequence[Mapping[str, Any]],
    content: bytes,
) -> None:
    """Refuse a file that would make the library fill the memory or loop without end.

    Raises:
        ValueError: More values are claimed than the file has bytes, or more than `_MOST_SCALINGS`.
    """
    claimed_value_count = sum(len(channel) for channel in channels)
    if claimed_value_count > len(content):
        raise ValueError(f"it claims {claimed_value_count} values in {len(content)} bytes")
    for properties_of_object in properties_of_objects:
        for name, value in properties_of_object.items():
            is_count = name.startswith("NI_") and name.endswith(("_Size", "_Scales"))
            if is_count and not 0 <= int(value) <= _MOST_SCALINGS:
                raise ValueError(f"the property {name} is {value}")


def _table(
    group: TdmsGroup,
    file_properties: Mapping[str, Any],
    run_name: str,
    refusal: Refusal | None,
    vocabulary: Vocabulary,
    content: bytes,
) -> LoggedTable:
    """A group as a table, in which shorter channels end in rows without a number.

    Channels without a meaning may have any length.
    """
    channels = group.channels()
    names = [channel.name.strip() for channel in channels]
    units = [_unit(channel) for channel in channels]
    quantities_and_units = vocabulary.quantities_and_units(names, units)
    read_indices = list(quantities_and_units) or range(len(channels))
    row_count = max(len(channels[column_index]) for column_index in read_indices)
    check_row_count(row_count)
    numbers_of_index = {
        column_index: as_seconds(np.asarray(channels[column_index][:]))
        for column_index in quantities_and_units
    }

    def read_values(column_indices: Sequence[int]) -> list[Values]:
        return [
            _with_length(numbers_of_index[column_index], row_count)
            for column_index in column_indices
        ]

    group_name = group.name

    def read_texts(column_index: int) -> Texts:
        # few logs have such a channel: the file is opened again for it
        with TdmsFile.open(io.BytesIO(content)) as log:
            channel = log[group_name].channels()[column_index]
            if len(channel) != row_count:
                return np.full(row_count, "", dtype=object)
            return texts_of_values(np.asarray(channel[:]))

    starts_s = _start_s_of_channels(
        [channels[column_index].properties for column_index in read_indices]
    )
    clock_of_column: dict[int, Clock] = {}
    for column_index, start_s in zip(read_indices, starts_s, strict=True):
        if "wf_increment" in channels[column_index].properties:
            interval_s = float(channels[column_index].properties["wf_increment"])
            clock_of_column[column_index] = Clock(start_s, interval_s, "s")
    return LoggedTable(
        header_of_part(_text_of_key(file_properties), _text_of_key(group.properties)),
        names,
        units,
        read_values,
        row_count,
        run_name,
        refusal=refusal,
        clock_of_column=clock_of_column,
        read_texts=read_texts,
    )


def _text_of_key(properties: Mapping[str, Any]) -> dict[str, str]:
    """Header key -> its text, from the properties of the file or of a group."""
    return joined_texts(
        (plain_key(name), text_of_value(value)) for name, value in properties.items()
    )


def _start_s_of_channels(properties_of_channels: Sequence[Mapping[str, Any]]) -> list[float]:
    """Start of each channel after the earliest start time, in s: by its start time and offset.

    A channel without a start time starts with the others. It is NaN where these start at different
    times.
    """
    offsets = [
        float(properties.get("wf_start_offset", 0.0)) for properties in properties_of_channels
    ]
    start_times = np.array([_start_time(properties) for properties in properties_of_channels])
    is_known = ~np.isnat(start_times)
    if not is_known.any():
        return offsets
    s_after_earliest = (start_times - start_times[is_known].min()) / np.timedelta64(1, "us") * 1e-6
    intervals_s = [
        abs(float(properties["wf_increment"]))
        for properties in properties_of_channels
        if "wf_increment" in properties
    ]
    largest_difference_s = LARGEST_CLOCK_DIFFERENCE * min(intervals_s, default=0.0)
    if np.max(s_after_earliest[is_known]) <= largest_difference_s:
        s_after_earliest[~is_known] = 0.0
    return (s_after_earliest + offsets).tolist()


def _start_time(properties: Mapping[str, Any]) -> np.datetime64:
    """Start time of a channel; NaT (not a time) where it has none."""
    instant = properties.get("wf_start_time")
    start_time = np.datetime64("NaT") if instant is None else np.datetime64(instant)
    # a comparison with NaT is false
    return start_time if start_time > _EARLIEST_START else np.datetime64("NaT")


def _unit(channel: TdmsChannel) -> str:
    """Unit of a channel; instants are converted to seconds."""
    if channel.dtype.kind == "M":
        return "s"
    return str(channel.properties.get("unit_string", "")).strip()


def _with_length(values: Values, row_count: int) -> Values:
    """Numbers of shape (rows,), NaN behind the last one; other values stay as they are."""
    if len(values) == row_count or values.dtype.kind not in "iuf":
        return values
    return np.pad(values.astype(np.float64), (0, row_count - len(values)), constant_values=np.nan)
