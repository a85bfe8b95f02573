"""Parquet logs: one row per instant, header keys in the file's metadata; a file is a run."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.logs.base import COPY_AGAIN, NO_TEXT, UnreadableLogError, check_rows
from oilfilm.logs.columns import Found, LoggedTable, header_text, seconds
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.settings.base import plain_key

_OWN_TABLE = b"oilfilm"
_PANDAS_KEYS = b"PANDAS_ATTRS"
_NOT_KEYS = {b"pandas", b"ARROW:schema", _PANDAS_KEYS}


def recognises(head: bytes) -> bool:
    """True for the mark of Parquet, encrypted or not."""
    return head.startswith((b"PAR1", b"PARE"))


def tables(content: bytes, vocabulary: Vocabulary) -> Found:
    """See `Reader.tables`."""
    # few writers add checksums to the pages; where they are, a changed bit is found
    log = parquet.ParquetFile(arrow.BufferReader(content), page_checksum_verification=True)
    rows, schema = log.metadata.num_rows, log.schema_arrow
    metadata = schema.metadata or {}
    if _OWN_TABLE in metadata:
        said = metadata[_OWN_TABLE].decode("utf-8", "replace")[:80]
        reason = f"this is a table that oilfilm made itself, not a raw log ({said!r})"
        advice = "Take it out of the raw folder; tables belong into results."
        raise UnreadableLogError(reason, advice, rows, "own_table")
    units = [_unit(field) for field in schema]
    check_rows(rows)
    # of columns of one name the run is refused whichever is taken; texts of any length are let be
    known = vocabulary.meanings(schema.names, units)
    wanted = {schema.names[n]: "" for n in known if _holds_numbers(schema.types[n])}
    columns = log.read(columns=[*wanted], use_threads=False)
    if columns.num_rows != rows:
        reason = f"the footer counts {rows} rows, and the pages have {columns.num_rows}"
        raise UnreadableLogError(reason, COPY_AGAIN, columns.num_rows, "damaged_file")
    read = dict(zip(columns.schema.names, map(_numbers, columns.columns), strict=True))
    nothing = np.array([], dtype=str)

    def values(places: Sequence[int]) -> list[npt.NDArray[Any]]:
        return [read.get(schema.names[place], nothing) for place in places]

    logged = LoggedTable(_keys(metadata), schema.names, units, values, rows)
    return NO_TEXT, [logged] if rows else []


def _unit(field: arrow.Field) -> str:
    unit = (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace").strip()
    return unit or ("s" if _is_instant(field.type) else "")


def _is_instant(kind: arrow.DataType) -> bool:
    return bool(arrow.types.is_timestamp(kind) or arrow.types.is_duration(kind))


def _holds_numbers(kind: arrow.DataType) -> bool:
    plain = arrow.types.is_integer(kind) or arrow.types.is_floating(kind)
    return plain or arrow.types.is_decimal(kind) or _is_instant(kind)


def _numbers(column: arrow.ChunkedArray) -> npt.NDArray[Any]:
    """Numbers of a column, missing ones NaN; instants as seconds since the first."""
    if _is_instant(column.type):
        return seconds(column.to_numpy())
    return np.asarray(column.cast(arrow.float64(), safe=False).to_numpy())


def _keys(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    """Header keys: the file's own metadata and, under them, the `attrs` of a pandas frame."""
    try:
        attributes = dict(json.loads(metadata.get(_PANDAS_KEYS, b"{}")))
    except (TypeError, ValueError, RecursionError):
        attributes = {}
    texts = {str(name): header_text(value) for name, value in attributes.items()}
    for name in metadata.keys() - _NOT_KEYS:
        texts[name.decode("utf-8", "replace")] = metadata[name].decode("utf-8", "replace").strip()
    return {plain_key(name): text for name, text in texts.items()}
