"""Parquet logs: one row per instant, header keys in the file's metadata; a file is a run."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.base.plain_key import plain_key
from oilfilm.logs.base import COPY_AGAIN, NO_TEXT, UnreadableLogError, check_rows
from oilfilm.logs.columns import header_text, seconds, texts_of
from oilfilm.logs.log_kind import Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile, Texts

# Largest size of a column of text that may name the run of a row.
_LARGEST_TEXTS = 1 << 26
# Key of the metadata in tables that oilfilm writes.
_OILFILM_KEY = b"oilfilm"
_PANDAS_ATTRIBUTES_KEY = b"PANDAS_ATTRS"
_TECHNICAL_KEYS = {b"pandas", b"ARROW:schema", _PANDAS_ATTRIBUTES_KEY}


def recognises(head: bytes) -> bool:
    """True for the first bytes of a Parquet file, encrypted or not."""
    return head.startswith((b"PAR1", b"PARE"))


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `Reader.tables`."""
    # few writers add checksums to the pages; where they are, a changed bit is found
    log = parquet.ParquetFile(arrow.BufferReader(content), page_checksum_verification=True)
    rows = log.metadata.num_rows
    schema = log.schema_arrow
    metadata = schema.metadata or {}
    if _OILFILM_KEY in metadata:
        table = metadata[_OILFILM_KEY].decode("utf-8", "replace")[:80]
        reason = f"this is a table that oilfilm made itself, not a raw log ({table!r})"
        advice = "Take it out of the raw folder; tables belong into results."
        raise UnreadableLogError(reason, advice, rows, "own_table")
    check_rows(rows)
    units = [_unit(field) for field in schema]
    # texts of any length are not read
    names_to_read = {
        schema.names[index]: None
        for index in vocabulary.meanings(schema.names, units)
        if _holds_numbers(schema.types[index])
    }
    columns = log.read(columns=list(names_to_read), use_threads=False)
    if columns.num_rows != rows:
        reason = f"the footer counts {rows} rows, and the pages have {columns.num_rows}"
        raise UnreadableLogError(reason, COPY_AGAIN, columns.num_rows, "damaged_file")
    # of each name all columns are read, in the order of the file
    indices_read = [index for index, name in enumerate(schema.names) if name in names_to_read]
    numbers_by_index = {
        index: _numbers(column) for index, column in zip(indices_read, columns.columns, strict=True)
    }
    no_numbers = np.array([], dtype=str)

    def values(indices: Sequence[int]) -> list[npt.NDArray[Any]]:
        return [numbers_by_index.get(index, no_numbers) for index in indices]

    def texts(index: int) -> Texts:
        name = schema.names[index]
        is_text = arrow.types.is_string(schema.types[index])
        if _bytes_of(log.metadata, name) > _LARGEST_TEXTS or not (
            is_text or _holds_numbers(schema.types[index])
        ):
            return np.full(rows, "", dtype=object)
        # a dictionary holds each text once
        encoded = parquet.ParquetFile(
            arrow.BufferReader(content), read_dictionary=[name] if is_text else None
        ).read(columns=[name], use_threads=False)
        return texts_of(encoded.columns[0].to_pandas().to_numpy())

    logged = LoggedTable(_keys(metadata), schema.names, units, values, rows, texts=texts)
    return NO_TEXT, [logged] if rows else []


def _bytes_of(metadata: parquet.FileMetaData, name: str) -> int:
    """Bytes of a column when it is unpacked."""
    size = 0
    for group in range(metadata.num_row_groups):
        row_group = metadata.row_group(group)
        for number in range(row_group.num_columns):
            column = row_group.column(number)
            if column.path_in_schema == name:
                size += column.total_uncompressed_size
    return size


def _unit(field: arrow.Field) -> str:
    """The unit in the metadata of a column; instants and durations are converted to s."""
    unit = (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace").strip()
    return unit or ("s" if _is_time(field.type) else "")


def _is_time(data_type: arrow.DataType) -> bool:
    """Whether a column holds instants or durations."""
    return bool(arrow.types.is_timestamp(data_type) or arrow.types.is_duration(data_type))


def _holds_numbers(data_type: arrow.DataType) -> bool:
    return bool(
        arrow.types.is_integer(data_type)
        or arrow.types.is_floating(data_type)
        or arrow.types.is_decimal(data_type)
        or _is_time(data_type)
    )


def _numbers(column: arrow.ChunkedArray) -> npt.NDArray[Any]:
    """Numbers of a column, missing ones NaN; instants as seconds since the first."""
    if _is_time(column.type):
        return seconds(column.to_numpy())
    return np.asarray(column.cast(arrow.float64(), safe=False).to_numpy())


def _keys(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    """Header keys: the metadata of the file, then the `attrs` of a pandas frame."""
    try:
        attributes = dict(json.loads(metadata.get(_PANDAS_ATTRIBUTES_KEY, b"{}")))
    except (TypeError, ValueError, RecursionError):
        attributes = {}
    # metadata of the file replaces attributes of the same name
    texts = {str(name): header_text(value) for name, value in attributes.items()}
    for name, value in metadata.items():
        if name not in _TECHNICAL_KEYS:
            texts[name.decode("utf-8", "replace")] = value.decode("utf-8", "replace").strip()
    return {plain_key(name): text for name, text in texts.items()}
