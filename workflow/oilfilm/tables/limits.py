"""What a table of unknown origin may take of memory, asked before it is read."""

from pathlib import Path

import pyarrow as arrow
import pyarrow.compute as compute
import pyarrow.parquet as parquet

from oilfilm.errors import OilfilmError

# Bytes of a table once it is unpacked.
LARGEST_TABLE = 1 << 30
# Columns and row groups; no table here has a hundredth of them.
_MOST_CHUNKS = 100_000
# Types of at most 8 bytes a value.
_PLAIN = {"BOOLEAN", "INT32", "INT64", "FLOAT", "DOUBLE"}
# Errors of Arrow for a file that is not Parquet or is damaged.
UNREADABLE = (arrow.ArrowException, OSError, ValueError, RecursionError)


def refuse_unpacking(file: Path, largest: int = LARGEST_TABLE) -> None:
    """Refuse a small file that unpacks to more than memory can hold (one value, repeated).

    Args:
        file: A Parquet file.
        largest: Most bytes.

    Raises:
        OilfilmError: It unpacks to more, is no table of plain values, or is missing.
    """
    try:
        size = _size_unpacked(file, largest)
    except FileNotFoundError:
        raise OilfilmError(f"{file}: there is no such table; snakemake makes it.") from None
    except UNREADABLE as error:
        raise OilfilmError(f"{file}: cannot be read as a table ({error}).") from error
    if size > largest:
        raise OilfilmError(f"{file}: unpacks to {size} bytes, more than are read ({largest}).")


def _size_unpacked(file: Path, largest: int) -> int:
    """Bytes of a Parquet file's values in memory, or a size too large on the way to them."""
    metadata = parquet.read_metadata(file)
    if metadata.num_columns * max(metadata.num_row_groups, 1) > _MOST_CHUNKS:
        raise ValueError(
            f"it has {metadata.num_columns} columns in {metadata.num_row_groups} parts; expected "
            f"at most {_MOST_CHUNKS} together"
        )
    if any(arrow.types.is_nested(kind) for kind in metadata.schema.to_arrow_schema().types):
        raise ValueError("its columns hold lists, which no table here does")
    groups = [metadata.row_group(group) for group in range(metadata.num_row_groups)]
    chunks = [group.column(index) for group in groups for index in range(group.num_columns)]
    if unknown := {chunk.physical_type for chunk in chunks} - {*_PLAIN, "BYTE_ARRAY"}:
        raise ValueError(f"its columns hold {min(unknown)}, which no table here does")
    size = sum(max(chunk.total_uncompressed_size, 8 * chunk.num_values) for chunk in chunks)
    # Only here a value has a length of its own. Read as a dictionary it lies in memory once.
    text = sorted({c.path_in_schema for c in chunks if c.physical_type == "BYTE_ARRAY"})
    if size > largest or not text:
        return size
    for batch in parquet.ParquetFile(file, read_dictionary=text).iter_batches(columns=text):
        for column in batch.columns:
            if isinstance(column, arrow.DictionaryArray):
                lengths = compute.binary_length(column.dictionary.cast(arrow.large_binary()))
                size += compute.sum(lengths.take(column.indices)).as_py() or 0
            else:
                size += column.nbytes
    return size
