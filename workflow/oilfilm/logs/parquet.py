"""Parquet logs: one row per instant, header keys in the file's metadata; a file is a run."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.logs.base import LARGEST_LOG, Names, Reading, damaged_file, refused_file
from oilfilm.logs.columns import LoggedTable, header_text, meanings, read_tables
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.settings.base import plain_key
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings

_MARKS = (b"PAR1", b"PARE")
_OWN_TABLE = b"oilfilm"
_PANDAS_KEYS = b"PANDAS_ATTRS"
_NOT_KEYS = {b"pandas", b"ARROW:schema", _PANDAS_KEYS}
_BYTES_A_NUMBER = 8


def recognises(head: bytes) -> bool:
    """True for the mark of Parquet, encrypted or not."""
    return head.startswith(_MARKS)


def read(
    content: bytes, file: str, settings: Settings, kind: LogKind, sheet: SheetOfLog
) -> Reading:
    """See `Reader.read`."""
    if content.startswith(b"PARE"):
        advice = "Export it without encryption."
        return refused_file(0, "damaged_file", "the file is encrypted Parquet", advice)
    try:
        # few writers add checksums to the pages; where they are, a changed bit is found
        log = parquet.ParquetFile(arrow.BufferReader(content), page_checksum_verification=True)
        metadata = log.schema_arrow.metadata or {}
        if _OWN_TABLE in metadata:
            return _own_table(log.metadata.num_rows, metadata[_OWN_TABLE])
        table = _table(log, file, settings.campaign, kind)
    except Exception as error:  # Arrow raises whatever a damaged file makes it stumble over
        return damaged_file("parquet", error)
    # a table without rows is left to `ingest`, which says so
    return read_tables([table] if table.rows else [], settings, kind, sheet)


def names(content: bytes) -> list[Names]:
    """See `Reader.names`."""
    schema = parquet.read_schema(arrow.BufferReader(content))
    return [[(field.name, _unit(field)) for field in schema]]


def _unit(field: arrow.Field) -> str:
    unit = (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace").strip()
    return unit or ("s" if _is_instant(field.type) else "")


def _own_table(rows: int, footer: bytes) -> Reading:
    name = footer.decode("utf-8", "replace")[:80]
    reason = f"this is a table that oilfilm made itself, not a raw log ({name!r})"
    advice = "Take it out of the raw folder; tables belong into results."
    return refused_file(rows, "own_table", reason, advice)


def _table(log: parquet.ParquetFile, file: str, campaign: Campaign, kind: LogKind) -> LoggedTable:
    """The columns that mean something to a run.

    Raises:
        ValueError: The numbers would not fit any log's size.
    """
    schema = log.schema_arrow
    # of columns of one name the run is refused whichever is taken
    known = meanings(schema.names, kind.renamed(campaign), kind.vocabulary)
    wanted = dict.fromkeys(schema.names[place] for place in known)
    _check_claims(log.metadata, len(wanted))
    columns = log.read(columns=[*wanted], use_threads=False)
    return LoggedTable(
        file,
        _keys(schema.metadata or {}),
        schema.names,
        [_unit(field) for field in schema],
        lambda places: [
            _numbers(columns.column(columns.schema.get_all_field_indices(schema.names[place])[0]))
            for place in places
        ],
        log.metadata.num_rows,
    )


def _check_claims(about: parquet.FileMetaData, columns: int) -> None:
    """Refuse a file that unfolds to more than any log, before anything is unfolded."""
    unfolded = max(
        about.num_rows * max(columns, 1) * _BYTES_A_NUMBER,
        sum(about.row_group(group).total_byte_size for group in range(about.num_row_groups)),
    )
    if not 0 <= unfolded <= LARGEST_LOG:
        raise ValueError(f"it would unfold to {unfolded >> 20} MiB")


def _is_instant(kind: arrow.DataType) -> bool:
    return bool(arrow.types.is_timestamp(kind) or arrow.types.is_duration(kind))


def _numbers(column: arrow.ChunkedArray) -> npt.NDArray[Any]:
    """Numbers of a column, missing ones NaN; instants as seconds since the first; else text."""
    if _is_instant(column.type):
        instants = column.to_numpy()
        start = instants[0] if instants.dtype.kind == "M" and len(instants) else 0
        return (instants - start) / np.timedelta64(1, "s")
    are_numbers = arrow.types.is_integer, arrow.types.is_floating, arrow.types.is_decimal
    if any(are(column.type) for are in are_numbers):
        return np.asarray(column.cast(arrow.float64(), safe=False).to_numpy())
    return np.array([], dtype=str)


def _keys(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    """Header keys: the file's own metadata and, under them, the `attrs` of a pandas frame."""
    keys: dict[str, str] = {}
    try:
        attributes = json.loads(metadata.get(_PANDAS_KEYS, b"{}"))
    except (ValueError, RecursionError):
        attributes = {}
    if isinstance(attributes, dict):
        keys = {plain_key(str(name)): header_text(value) for name, value in attributes.items()}
    for name, value in metadata.items():
        if name not in _NOT_KEYS:
            key = plain_key(name.decode("utf-8", "replace"))
            keys[key] = value.decode("utf-8", "replace").strip()
    return keys
