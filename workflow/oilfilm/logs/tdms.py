"""LabVIEW's binary logs (TDMS): groups of channels with properties; one with rows is a run."""

import io
import logging
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from nptdms import TdmsFile, TdmsGroup
from nptdms.log import log_manager

from oilfilm.logs.base import NO_TEXT, Refusal, UnreadableLogError, check_rows, distinct
from oilfilm.logs.columns import Found, LoggedTable, header_text, seconds
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.settings.base import plain_key

Values = npt.NDArray[Any]

_TAG = b"TDSm"
_LEAD_IN = 28
_UNKNOWN_END = (1 << 64) - 1
_BIG_ENDIAN = 1 << 6
# Counts of scalings and of their coefficients, which the library loops over, are never larger.
_MOST_SCALINGS = 1000

# Its warnings about damaged files would repeat on the terminal what the verdict says.
log_manager.set_level(logging.ERROR)


def recognises(head: bytes) -> bool:
    """True where the file begins with the tag of a segment."""
    return head.startswith(_TAG)


def tables(content: bytes, vocabulary: Vocabulary) -> Found:
    """See `Reader.tables`."""
    flaw, raw = _segments(content)
    with TdmsFile.open(io.BytesIO(content)) as log:
        channels = [channel for group in log.groups() for channel in group.channels()]
        _check_claims(channels, [log.properties, *(g.properties for g in log.groups())], content)
        sizes = [getattr(channel.data_type, "size", 0) for channel in channels]
        # texts and raw data of DAQmx have no size, channels without data no type
        if not flaw and None not in sizes:
            used = sum(len(channel) * size for channel, size in zip(channels, sizes, strict=True))
            if used != raw:
                raise ValueError(f"its channels have {used} bytes of values, its segments {raw}")
        groups = [group for group in log.groups() if any(map(len, group.channels()))]
        if flaw and not groups:
            advice = "Copy it again, or repeat the run."
            raise UnreadableLogError(flaw.reason, advice, rule="damaged_file")
        labels = distinct(group.name for group in groups)
        return NO_TEXT, [
            _table(group, log.properties, label if groups[1:] else "", flaw, vocabulary)
            for group, label in zip(groups, labels, strict=True)
        ]


def _segments(content: bytes) -> tuple[Refusal | None, int]:
    """What is wrong with the last segment where it was not written to its end; bytes of values."""
    position, number, raw = 0, 0, 0
    while position < len(content):
        number += 1
        sentence = f"the file ends within segment {number}, which was not written to its end"
        lead_in = content[position : position + _LEAD_IN]
        if len(lead_in) < _LEAD_IN or not lead_in.startswith(_TAG):
            # another tag is damage, which the library reports
            return (Refusal("truncated", sentence) if _TAG.startswith(lead_in[:4]) else None), raw
        order = ">" if lead_in[4] & _BIG_ENDIAN else "<"
        length, of_names = struct.unpack(f"{order}QQ", lead_in[12:28])
        if length == _UNKNOWN_END or position + _LEAD_IN + length > len(content):
            return Refusal("truncated", sentence), raw
        position += _LEAD_IN + length
        raw += length - of_names
    return None, raw


def _check_claims(
    channels: Sequence[Any], properties: Sequence[Mapping[str, Any]], content: bytes
) -> None:
    """Refuse what would make the library fill the memory or loop without end.

    Raises:
        ValueError: More values are claimed than the file has bytes, or scalings beyond reason.
    """
    claimed = sum(len(channel) for channel in channels)
    if claimed > len(content):
        raise ValueError(f"it claims {claimed} values in {len(content)} bytes")
    for owner in [*properties, *(channel.properties for channel in channels)]:
        for name, value in owner.items():
            if name.startswith("NI_") and name.endswith(("_Size", "_Scales")):
                if not 0 <= int(value) <= _MOST_SCALINGS:
                    raise ValueError(f"the property {name} is {value}")


def _table(
    group: TdmsGroup,
    of_file: Mapping[str, Any],
    part: str,
    flaw: Refusal | None,
    vocabulary: Vocabulary,
) -> LoggedTable:
    """A group as a table, in which shorter channels end in rows without a number.

    Channels that mean nothing to a run may be of any length.
    """
    channels = group.channels()
    names = [channel.name.strip() for channel in channels]
    about = [channel.properties for channel in channels]
    units = [
        "s" if channel.dtype.kind == "M" else str(channel.properties.get("unit_string", "")).strip()
        for channel in channels
    ]
    known = vocabulary.meanings(names, units)
    rows = max(len(channels[place]) for place in known or range(len(channels)))
    check_rows(rows)
    # read here, as long as the file is open
    read = {place: seconds(np.asarray(channels[place][:])) for place in known}

    def values(places: Sequence[int]) -> list[Values]:
        return [_of_length(read[place], rows) for place in places]

    clocks = {
        place: (float(each.get("wf_start_offset", 0.0)), float(each["wf_increment"]), "s")
        for place, each in enumerate(about)
        if "wf_increment" in each
    }
    properties = {**of_file, **group.properties}
    keys = {plain_key(name): header_text(value) for name, value in properties.items()}
    return LoggedTable(keys, names, units, values, rows, part, flaw=flaw, clocks=clocks)


def _of_length(values: Values, rows: int) -> Values:
    """Numbers with NaN behind the last; anything else as it is."""
    if len(values) == rows or values.dtype.kind not in "iuf":
        return values
    return np.pad(values.astype(np.float64), (0, rows - len(values)), constant_values=np.nan)
