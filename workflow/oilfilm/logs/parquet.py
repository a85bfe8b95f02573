"""Parquet logs: one row per instant, header keys in the file's metadata; a file is a run."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.base.plain_key import plain_key
from oilfilm.logs.base import COPY_AGAIN_ADVICE, NO_DIALECT, UnreadableLogError, check_row_count
from oilfilm.logs.columns import as_seconds, text_of_value, texts_of_values
from oilfilm.logs.header import joined_texts
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile, Texts

# Largest size of a column of text that may name the run of a row.
_MOST_TEXT_BYTES = 1 << 26
# Key of the metadata in tables that oilfilm writes.
_OILFILM_KEY = b"oilfilm"
_PANDAS_ATTRIBUTES_KEY = b"PANDAS_ATTRS"
_TECHNICAL_KEYS = {b"pandas", b"ARROW:schema", _PANDAS_ATTRIBUTES_KEY}


def recognises(first_bytes: bytes) -> bool:
    """True for the first bytes of a Parquet file, encrypted or not."""
    return first_bytes.startswith((b"PAR1", b"PARE"))


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    # few writers add checksums to the pages; where they are, a changed bit is found
    log = parquet.ParquetFile(arrow.BufferReader(content), page_checksum_verification=True)
    row_count = log.metadata.num_rows
    schema = log.schema_arrow
    metadata = schema.metadata or {}
    if _OILFILM_KEY in metadata:
        table_name = metadata[_OILFILM_KEY].decode("utf-8", "replace")[:80]
        reason = f"this is a table that oilfilm made itself, not a raw log ({table_name!r})"
        advice = "Take it out of the raw folder; tables belong into results."
        raise UnreadableLogError(reason, advice, row_count, "own_table")
    check_row_count(row_count)
    units = [_unit(field) for field in schema]
    # texts of any length are not read
    names_of_numbers = [
        schema.names[column_index]
        for column_index in vocabulary.quantities_and_units(schema.names, units)
        if _holds_numbers(schema.types[column_index])
    ]
    # columns may have the same name
    names_to_read = list(dict.fromkeys(names_of_numbers))
    columns = log.read(columns=names_to_read, use_threads=False)
    if columns.num_rows != row_count:
        reason = f"the footer counts {row_count} rows, and the pages have {columns.num_rows}"
        raise UnreadableLogError(reason, COPY_AGAIN_ADVICE, columns.num_rows, "damaged_file")
    # of each name all columns are read, in the order of the file
    indices_read = [
        column_index for column_index, name in enumerate(schema.names) if name in names_to_read
    ]
    numbers_of_index = {
        column_index: _numbers(column)
        for column_index, column in zip(indices_read, columns.columns, strict=True)
    }
    no_numbers = np.array([], dtype=str)

    def read_values(column_indices: Sequence[int]) -> list[npt.NDArray[Any]]:
        return [numbers_of_index.get(column_index, no_numbers) for column_index in column_indices]

    def read_texts(column_index: int) -> Texts:
        name = schema.names[column_index]
        is_text = arrow.types.is_string(schema.types[column_index])
        if _unpacked_byte_count(log.metadata, name) > _MOST_TEXT_BYTES or not (
            is_text or _holds_numbers(schema.types[column_index])
        ):
            return np.full(row_count, "", dtype=object)
        # a dictionary holds each text once
        encoded = parquet.ParquetFile(
            arrow.BufferReader(content), read_dictionary=[name] if is_text else None
        ).read(columns=[name], use_threads=False)
        return texts_of_values(encoded.columns[0].to_pandas().to_numpy())

    logged_table = LoggedTable(
        _text_of_header_key(metadata),
        schema.names,
        units,
        read_values,
        row_count,
        read_texts=read_texts,
    )
    return NO_DIALECT, [logged_table] if row_count else []


def _unpacked_byte_count(metadata: parquet.FileMetaData, name: str) -> int:
    """Bytes of a column when it is unpacked."""
    byte_count = 0
    for group_index in range(metadata.num_row_groups):
        row_group = metadata.row_group(group_index)
        for column_index in range(row_group.num_columns):
            column_chunk = row_group.column(column_index)
            if column_chunk.path_in_schema == name:
                byte_count += column_chunk.total_uncompressed_size
    return byte_count


def _unit(field: arrow.Field) -> str:
    """The unit in the metadata of a column; instants and durations are converted to s."""
    if _is_time(field.type):
        return "s"
    return (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace").strip()


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
        return as_seconds(column.to_numpy())
    return np.asarray(column.cast(arrow.float64(), safe=False).to_numpy())


def _text_of_header_key(metadata: Mapping[bytes, bytes]) -> dict[str, str]:
    """Header keys: the metadata of the file, then the `attrs` of a pandas frame."""
    try:
        attributes = dict(json.loads(metadata.get(_PANDAS_ATTRIBUTES_KEY, b"{}")))
    except (TypeError, ValueError, RecursionError):
        attributes = {}
    # metadata of the file replaces attributes of the same name
    texts = {str(name): text_of_value(value) for name, value in attributes.items()}
    for name, value in metadata.items():
        if name not in _TECHNICAL_KEYS:
            texts[name.decode("utf-8", "replace")] = value.decode("utf-8", "replace").strip()
    return joined_texts((plain_key(name), text) for name, text in texts.items())
