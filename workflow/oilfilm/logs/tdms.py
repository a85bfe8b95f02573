"""LabVIEW's binary logs (TDMS): groups of channels with properties; one with rows is a run."""

import io
import logging
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from nptdms import TdmsChannel, TdmsFile
from nptdms.log import log_manager

from oilfilm.logs.base import (
    Flaw,
    Names,
    Reading,
    Refusal,
    damaged_file,
    distinct,
    refused_file,
)
from oilfilm.logs.columns import LoggedTable, header_text, meanings, read_tables
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.settings.base import plain_key
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings

Values = npt.NDArray[Any]

_TAG = b"TDSm"
_LEAD_IN = 28
_UNKNOWN_END = (1 << 64) - 1
_BIG_ENDIAN = 1 << 6
# Counts of scalings and of their coefficients, which the library loops over, are never larger.
_MOST_SCALINGS = 1000

# Its warnings about damaged files would repeat on the terminal what the verdict says.
log_manager.set_level(logging.ERROR)


@dataclass(frozen=True)
class _Group:
    """Channels of one group; `clocks` as those of `LoggedTable`."""

    name: str
    keys: Mapping[str, str]
    names: Sequence[str]
    units: Sequence[str]
    values: Sequence[Values]
    clocks: Mapping[int, tuple[float, float, str]]


def recognises(head: bytes) -> bool:
    """True where the file begins with the tag of a segment."""
    return head.startswith(_TAG)


def read(
    content: bytes, file: str, settings: Settings, kind: LogKind, sheet: SheetOfLog
) -> Reading:
    """See `Reader.read`."""
    flaw = _cut(content)
    try:
        groups = [group for group in _groups(content) if any(map(len, group.values))]
    except Exception as error:  # whatever a damaged file makes the library stumble over
        return damaged_file("tdms", error)
    if flaw and not groups:
        return refused_file(0, "damaged_file", flaw.reason, "Copy it again, or repeat the run.")
    tables: list[LoggedTable] = []
    first_row = 1
    for group, label in zip(groups, distinct(group.name for group in groups), strict=True):
        run_id = f"{file}:{label}" if len(groups) > 1 else file
        tables.append(_table(group, run_id, label, first_row, flaw, settings.campaign, kind))
        first_row += tables[-1].all_rows
    return read_tables(tables, settings, kind, sheet)


def names(content: bytes) -> Iterator[Names]:
    """See `Reader.names`."""
    return (list(zip(group.names, group.units, strict=True)) for group in _groups(content))


def _cut(content: bytes) -> Flaw | None:
    """What is wrong with the last segment where it was not written to its end."""
    position, number = 0, 0
    while position < len(content):
        number += 1
        lead_in = content[position : position + _LEAD_IN]
        if len(lead_in) < _LEAD_IN or not lead_in.startswith(_TAG):
            # another tag is damage, which the library reports
            return _truncated(number) if _TAG.startswith(lead_in[:4]) else None
        order = ">" if lead_in[4] & _BIG_ENDIAN else "<"
        (length,) = struct.unpack(f"{order}Q", lead_in[12:20])
        if length == _UNKNOWN_END or position + _LEAD_IN + length > len(content):
            return _truncated(number)
        position += _LEAD_IN + length
    return None


def _truncated(segment: int) -> Flaw:
    sentence = f"the file ends within segment {segment}, which was not written to its end"
    return Flaw("truncated", sentence)


def _groups(content: bytes) -> Iterator[_Group]:
    with TdmsFile.open(io.BytesIO(content)) as log:
        channels = [channel for group in log.groups() for channel in group.channels()]
        _check_claims(channels, [log.properties, *(g.properties for g in log.groups())], content)
        for group in log.groups():
            properties = {**log.properties, **group.properties}
            keys = {plain_key(name): header_text(value) for name, value in properties.items()}
            members = group.channels()
            values = [np.asarray(channel[:]) for channel in members]
            units = [
                "s" if array.dtype.kind == "M" else str(channel.properties.get("unit_string", ""))
                for channel, array in zip(members, values, strict=True)
            ]
            yield _Group(
                group.name,
                keys,
                [channel.name.strip() for channel in members],
                [unit.strip() for unit in units],
                [_seconds(array) for array in values],
                {
                    place: _clock(channel)
                    for place, channel in enumerate(members)
                    if "wf_increment" in channel.properties
                },
            )


def _clock(channel: TdmsChannel) -> tuple[float, float, str]:
    """See `LoggedTable.clocks`."""
    start = float(channel.properties.get("wf_start_offset", 0.0))
    return start, float(channel.properties["wf_increment"]), "s"


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


def _seconds(values: Values) -> Values:
    """Instants as seconds since the first; numbers as they are."""
    if values.dtype.kind == "M" and len(values):
        return (values - values[0]) / np.timedelta64(1, "s")
    return values


def _table(
    group: _Group,
    run_id: str,
    label: str,
    first: int,
    flaw: Flaw | None,
    campaign: Campaign,
    kind: LogKind,
) -> LoggedTable:
    """The rows that all channels of a run have, and the refusal of those behind them.

    Channels that mean nothing to a run may be of any length: they are not read.
    """
    known = meanings(group.names, kind.renamed(campaign), kind.vocabulary)
    used = {group.names[place]: len(group.values[place]) for place in known}
    longest = max(used.values() if used else map(len, group.values))
    rows = min(used.values(), default=longest)
    table = LoggedTable(
        run_id,
        group.keys,
        group.names,
        group.units,
        lambda places: [group.values[place][:rows] for place in places],
        rows,
        first,
        flaw,
        part=label,
        clocks=group.clocks,
    )
    if longest == rows:
        return table
    ends = ", ".join(f"{name[:40]} {length}" for name, length in used.items())
    first_behind, last = first + rows, first + longest - 1
    behind = Refusal(
        "unequal_channels",
        f"rows {first_behind} to {last}: the channels are of different lengths ({ends[:200]})",
        "The rows that all channels have are used; let the logger write them together.",
    ).of_rows(run_id, first_behind, last)
    return replace(table, behind=behind)
