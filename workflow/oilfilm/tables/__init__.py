"""The contract: what every table holds, checked whenever one is written or read.

Each column is declared once, in a YAML file, with its unit, meaning and caveat. Each table lists
its columns and its key. Units and descriptions are in the footer of the Parquet file, beside the
provenance. So each file says by which declaration it was written, and needs no version number.

Decides: how a table is checked, written and read; how many rows are in memory at once.
"""

import json
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.compute as compute
import pyarrow.parquet as parquet

from oilfilm.base.atomic_write import atomic_file
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.tables.declaration import BY_ROW as BY_ROW
from oilfilm.tables.declaration import UNITS as UNITS
from oilfilm.tables.dictionary import COLUMNS as COLUMNS
from oilfilm.tables.dictionary import LARGEST_NUMBER as LARGEST_NUMBER
from oilfilm.tables.dictionary import TABLES as TABLES
from oilfilm.tables.dictionary import Column as Column
from oilfilm.tables.dictionary import Table as Table
from oilfilm.tables.dictionary import repetition_complaint
from oilfilm.tables.dictionary import unit_of as unit_of

# Most bytes that a table may have once it is unpacked.
MOST_BYTES_UNPACKED = 1 << 30
# Largest product of the numbers of columns and row groups; that of each table here is less than a
# hundredth of it.
_MOST_CHUNKS = 100_000
# Types of at most 8 bytes a value.
_PLAIN_TYPES = {"BOOLEAN", "INT32", "INT64", "FLOAT", "DOUBLE"}
# Errors of Arrow for a file that is not Parquet or is damaged.
READ_ERRORS = (arrow.ArrowException, OSError, ValueError, RecursionError)


def refuse_oversized(file: Path, bytes_max: int = MOST_BYTES_UNPACKED) -> None:
    """Refuse a small file that unpacks to more than memory can hold (one value, repeated).

    Args:
        file: A Parquet file.
        bytes_max: Most bytes that it may unpack to.

    Raises:
        OilfilmError: It unpacks to more, is no table of plain values, or is missing.
    """
    try:
        byte_count = _bytes_unpacked(file, bytes_max)
    except FileNotFoundError:
        raise OilfilmError(f"{file}: there is no such table; snakemake makes it.") from None
    except READ_ERRORS as error:
        raise OilfilmError(f"{file}: cannot be read as a table ({error}).") from error
    if byte_count > bytes_max:
        raise OilfilmError(
            f"{file}: unpacks to {byte_count} bytes, more than are read ({bytes_max})."
        )


def _bytes_unpacked(file: Path, bytes_max: int) -> int:
    """Bytes of a Parquet file's values in memory; where they exceed the limit, a part of them."""
    metadata = parquet.read_metadata(file)
    if metadata.num_columns * max(metadata.num_row_groups, 1) > _MOST_CHUNKS:
        raise ValueError(
            f"it has {metadata.num_columns} columns in {metadata.num_row_groups} parts; expected "
            f"at most {_MOST_CHUNKS} together"
        )
    for arrow_type in metadata.schema.to_arrow_schema().types:
        if arrow.types.is_nested(arrow_type) and not _is_list_of_texts(arrow_type):
            raise ValueError(f"its columns hold {arrow_type}, which no table here does")
    row_groups = [metadata.row_group(index) for index in range(metadata.num_row_groups)]
    chunks = [
        row_group.column(index)
        for row_group in row_groups
        for index in range(row_group.num_columns)
    ]
    unknown = {chunk.physical_type for chunk in chunks} - {*_PLAIN_TYPES, "BYTE_ARRAY"}
    if unknown:
        raise ValueError(f"its columns hold {min(unknown)}, which no table here does")
    byte_count = sum(max(chunk.total_uncompressed_size, 8 * chunk.num_values) for chunk in chunks)
    # Only here a value has a length of its own. Read as a dictionary it lies in memory once.
    text_chunks = [chunk for chunk in chunks if chunk.physical_type == "BYTE_ARRAY"]
    text_columns = sorted({chunk.path_in_schema for chunk in text_chunks})
    if byte_count > bytes_max or not text_columns:
        return byte_count
    for batch in parquet.ParquetFile(file, read_dictionary=text_columns).iter_batches(
        columns=text_columns
    ):
        for column in batch.columns:
            values = column.flatten() if isinstance(column, arrow.ListArray) else column
            if isinstance(values, arrow.DictionaryArray):
                lengths = compute.binary_length(values.dictionary.cast(arrow.large_binary()))
                byte_count += compute.sum(lengths.take(values.indices)).as_py() or 0
            else:
                byte_count += values.nbytes
    return byte_count


def _is_list_of_texts(arrow_type: arrow.DataType) -> bool:
    return arrow.types.is_list(arrow_type) and arrow.types.is_string(arrow_type.value_type)


def release_memory() -> None:
    """Give the memory of tables that are no longer used back to the system.

    Arrow keeps it for its next table. A computation with NumPy cannot use it.
    """
    arrow.default_memory_pool().release_unused()


def columns(table_name: str) -> list[str]:
    """Names of a table's columns, in order."""
    return TABLES[table_name].column_names


def empty_table(table_name: str) -> pd.DataFrame:
    """The table with no rows and every column of its type."""
    return _cached_empty_table(table_name).copy()


@cache
def _cached_empty_table(table_name: str) -> pd.DataFrame:
    return pd.DataFrame(
        {column.name: pd.Series(dtype=column.dtype) for column in TABLES[table_name].columns}
    )


def from_rows(rows: list[dict[str, Any]], table_name: str) -> pd.DataFrame:
    """A table from one mapping per row; no rows give the empty table."""
    return conform(pd.DataFrame(rows), table_name, "new rows") if rows else empty_table(table_name)


def filled_table(frame: pd.DataFrame, table_name: str, origin: str = "new rows") -> pd.DataFrame:
    """Rows as a table; a value that they lack becomes null, 0, empty or the first text allowed.

    Raises:
        OilfilmError: As `conform`.
    """
    placeholder_by_type: dict[str, Any] = {"number": 0.0, "integer": 0, "flag": False, "text": ""}
    values_by_column = {}
    for column in TABLES[table_name].columns:
        given_values = frame.get(column.name, pd.Series(np.nan, frame.index))
        if column.type == "texts":
            values_by_column[column.name] = (
                given_values if column.nullable else _with_empty_lists(given_values)
            )
            continue
        if not column.nullable and given_values.hasnans:
            placeholder = (*column.allowed, placeholder_by_type[column.type])[0]
            given_values = given_values.astype(object).where(given_values.notna(), placeholder)
        dtype: Any = column.dtype
        values_by_column[column.name] = given_values.astype(dtype)
    return conform(pd.DataFrame(values_by_column), table_name, origin)


def _with_empty_lists(values: pd.Series) -> pd.Series:
    """Lists of texts, empty where there is none."""
    return _as_tuples(values).map(lambda texts: () if texts is None else texts)


def rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, one dictionary per row."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


# What to do where the columns of a table are not those that are declared.
_ADVICE_ON_NEW_ROWS = (
    "Give values for each declared column and for no other (workflow/oilfilm/tables)."
)
_ADVICE_ON_OLD_FILES = (
    "It was made by another version of oilfilm: read it with that version, or make it again."
)


def conform(
    frame: pd.DataFrame,
    table_name: str,
    origin: str,
    advice: str = _ADVICE_ON_NEW_ROWS,
    columns: Sequence[str] | None = None,
) -> pd.DataFrame:
    """The frame with the columns of the table in order and of their types, after every check.

    Columns are checked one at a time: a whole frame of samples at once takes three times the
    memory. Pandera checks only columns that do not plainly obey their declaration, because it
    takes a millisecond per column and several passes over a long one.

    Args:
        frame: The rows.
        table_name: Name of the declaration in `TABLES`.
        origin: Where the rows are from, for messages.
        advice: What to do where the columns are not those that are declared.
        columns: The columns that the frame has, in order; all of the table if not given. Checks
            over several columns or rows need them all.

    Raises:
        OilfilmError: A column is missing, unknown, or holds what the contract forbids.
    """
    table = TABLES[table_name]
    column_names = table.column_names if columns is None else list(columns)
    _refuse_other_columns(frame.columns, column_names, table_name, origin, advice)
    frame = frame.reset_index(drop=True)
    values_by_column = {
        name: _checked_values(frame, table[name], table, origin) for name in column_names
    }
    # one array of all columns would be one more copy of a large table
    conformed = pd.DataFrame(values_by_column, columns=column_names, copy=False)
    if columns is None:
        for complaint in table.complaints(conformed):
            raise OilfilmError(f"{origin}: table {table_name!r}: {cut(complaint, 1000)}.")
    return conformed


def _refuse_other_columns(
    present_names: Iterable[str],
    expected_names: Sequence[str],
    table_name: str,
    origin: str,
    advice: str,
) -> None:
    """Refuse columns that are not those expected, each once, in any order.

    Raises:
        OilfilmError: A column is missing, unknown or repeated.
    """
    present_names = list(present_names)
    missing_names = [name for name in expected_names if name not in present_names]
    unknown_names = [name for name in present_names if name not in expected_names]
    if missing_names or unknown_names:
        raise OilfilmError(
            f"{origin}: table {table_name!r} lacks the columns {missing_names or 'none'} and has "
            f"the unknown columns {cut(unknown_names or 'none')}. {advice}"
        )
    if len(present_names) > len(expected_names):
        repeated_names = [name for name in expected_names if present_names.count(name) > 1]
        raise OilfilmError(
            f"{origin}: table {table_name!r} repeats the columns {repeated_names}. {advice}"
        )


def _checked_values(frame: pd.DataFrame, column: Column, table: Table, origin: str) -> pd.Series:
    """A column with its type, every check passed."""
    values = frame[column.name]
    if column.type == "texts":
        values = _as_tuples(values)
    if column.dtype == "boolean" and values.dtype == object:
        # as Arrow hands over flags of which some are unknown
        values = values.astype("boolean")
    if _plainly_obeys(values, column):
        return values
    # imported where needed: it takes a second
    from pandera.errors import SchemaError, SchemaErrors  # noqa: PLC0415

    try:
        validated = table.schema.columns[column.name].validate(frame[[column.name]], lazy=True)
    except (SchemaErrors, SchemaError) as error:
        case = error.failure_cases.iloc[0]
        expected = case.get("check", column.dtype)
        raise OilfilmError(
            f"{origin}: table {table.name!r}, column {column.name!r} ({column.description}): found "
            f"{cut(repr(case['failure_case']))} at row {case['index']}, expected {expected}."
        ) from error
    return validated[column.name]


def list_column(lists: Sequence[tuple[str, ...]], index: pd.Index) -> pd.Series:
    """A column of lists of texts.

    Args:
        lists: The texts of each row.
        index: Of the rows.
    """
    return pd.Series(list(lists), index, dtype=object)


def _as_tuples(values: pd.Series) -> pd.Series:
    """Lists of texts as tuples, which are compared and grouped as one value; None where missing."""
    tuples = np.empty(len(values), dtype=object)
    for row, value in enumerate(values):
        if isinstance(value, list | tuple | np.ndarray):
            tuples[row] = tuple(value)
        else:
            tuples[row] = None if pd.isna(value) else value
    return pd.Series(tuples, values.index, dtype=object)


def _plainly_obeys(values: pd.Series, column: Column) -> bool:
    """Whether a column surely has its type and keeps its bounds; false in any doubt."""
    if values.dtype.name != column.dtype:
        return False
    if values.empty:
        return True
    if column.type == "texts":
        return all(
            column.is_list_allowed(value) or (value is None and column.nullable) for value in values
        )
    if not column.nullable and values.hasnans:
        return False
    if column.at_least is not None and np.fmin.reduce(values.to_numpy()) < column.at_least:
        return False
    if column.at_most is not None and np.fmax.reduce(values.to_numpy()) > column.at_most:
        return False
    return not column.allowed or bool(values.dropna().isin(column.allowed).all())


def write(frame: pd.DataFrame, table_name: str, path: Path, provenance: Mapping[str, Any]) -> None:
    """Check a table and write it completely or not at all, with units and provenance in its footer.

    Args:
        frame: The rows.
        table_name: Name of the declaration in `TABLES`.
        path: Parquet file to write.
        provenance: At least `campaign` and `data` ("simulated" or "measured"); plain JSON values.

    Raises:
        OilfilmError: The frame breaks the contract.
    """
    with writing(table_name, path, provenance, ROWS_PER_GROUP) as add:
        add(frame)


# Rows that are in memory at once where a long table is written or read a block at a time.
ROWS_PER_GROUP = 1 << 18


def write_blocks(
    blocks: Iterable[pd.DataFrame], table_name: str, path: Path, provenance: Mapping[str, Any]
) -> None:
    """Write the blocks of a long table, of which one is in memory at a time.

    Args:
        blocks: Its rows; the bytes do not depend on how they are divided.
        table_name: Name of the declaration in `TABLES`.
        path: Parquet file to write.
        provenance: As for `write`.

    Raises:
        OilfilmError: As in `writing`.
    """
    with writing(table_name, path, provenance, ROWS_PER_GROUP) as write_block:
        for block in blocks:
            write_block(block)


@contextmanager
def writing(
    table_name: str, path: Path, provenance: Mapping[str, Any], group_row_count: int | None = None
) -> Iterator[Callable[[pd.DataFrame], None]]:
    """Write a table a block at a time, completely or not at all, as `write` does.

    A key that occurs in two blocks is not found. The provenance may grow until the last block is
    written.

    Args:
        table_name: Name of the declaration in `TABLES`.
        path: Parquet file to write.
        provenance: As for `write`.
        group_row_count: Number of rows of each row group but the last. The bytes do then not depend
            on how the rows are divided into blocks. If not given, each block is a row group.

    Raises:
        OilfilmError: A block breaks the contract.
    """
    schema = _arrow_schema(table_name)
    encodings = {
        field.name: _ENCODINGS[str(field.type)] for field in schema if str(field.type) in _ENCODINGS
    }
    with atomic_file(path) as temporary:
        with parquet.ParquetWriter(
            temporary,
            schema,
            compression="zstd",
            use_dictionary=[
                # values of a list have a path of their own
                f"{field.name}.list.element" if _is_list_of_texts(field.type) else field.name
                for field in schema
                if field.name not in encodings
            ],
            column_encoding=encodings,
            write_page_checksum=True,
            store_schema=False,  # with its metadata at the end
        ) as writer:
            pending_blocks: list[pd.DataFrame] = []
            group_count = 0

            def write_group(group_rows: pd.DataFrame) -> None:
                nonlocal group_count
                # column by column, in half of the time of `from_pandas` of the table
                arrays = [
                    arrow.array(group_rows[field.name], field.type, from_pandas=True)
                    for field in schema
                ]
                writer.write_table(arrow.table(arrays, schema=schema), max(len(group_rows), 1))
                group_count += 1

            def add(frame: pd.DataFrame) -> None:
                block = conform(frame, table_name, str(path))
                if group_row_count is None:
                    write_group(block)
                    return
                pending_blocks.append(block)
                if sum(map(len, pending_blocks)) < group_row_count:
                    return
                rows = (
                    pd.concat(pending_blocks, ignore_index=True)
                    if len(pending_blocks) > 1
                    else block
                )
                pending_blocks.clear()
                # a whole table as Arrow's would be one more copy of it
                whole_groups_row_count = len(rows) // group_row_count * group_row_count
                for start in range(0, whole_groups_row_count, group_row_count):
                    write_group(rows.iloc[start : start + group_row_count])
                pending_blocks.append(rows.iloc[whole_groups_row_count:].copy())

            yield add
            remaining_blocks = [block for block in pending_blocks if len(block)]
            if remaining_blocks:
                write_group(
                    pd.concat(remaining_blocks, ignore_index=True)
                    if len(remaining_blocks) > 1
                    else remaining_blocks[0]
                )
            elif not group_count:
                write_group(empty_table(table_name))
            footer = {"table": table_name, **provenance}
            metadata = {"oilfilm": json.dumps(footer, sort_keys=True, ensure_ascii=False)}
            encoded_schema = b64encode(schema.with_metadata(metadata).serialize())
            writer.add_key_value_metadata({**metadata, "ARROW:schema": encoded_schema})


# Numbers hardly repeat: a dictionary of them takes five times the time and saves nothing.
_ENCODINGS = {"int64": "DELTA_BINARY_PACKED", "double": "BYTE_STREAM_SPLIT"}


def read(
    table_name: str,
    *paths: Path,
    columns: Sequence[str] | None = None,
    row_filter: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Read a table from one file, from several or from none (then empty), and check it again.

    A long table needs the memory of the columns and the rows that are read, and no more. Checks
    over several columns are made where the whole table is read.

    Args:
        table_name: Name of the declaration in `TABLES`.
        paths: Its files.
        columns: The columns to read; all if not given.
        row_filter: The value of some columns in the rows to read; all rows if not given.

    Raises:
        OilfilmError: A file is missing or damaged, holds another table or columns in other units,
            or breaks the contract.
    """
    if not paths:
        return (
            empty_table(table_name) if columns is None else empty_table(table_name)[list(columns)]
        )
    origin = str(paths[0]) if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"
    if row_filter:
        contents = [_rows_of_file(table_name, path, columns, row_filter) for path in paths]
    else:
        for path in paths:
            _check_written_as(table_name, path)
        contents = [_file_content(path, columns=columns) for path in paths]
    return conform(_as_frame(contents), table_name, origin, _ADVICE_ON_OLD_FILES, columns)


def read_of_any_version(table_name: str, path: Path) -> pd.DataFrame:
    """Read a table that another version of oilfilm may have made, and check it.

    Versions add columns. A column that either the file or this version lacks is left out. Checks
    over several columns are made where the file has all of them and no others.

    Args:
        table_name: Name of the declaration in `TABLES`.
        path: Its file.

    Raises:
        OilfilmError: As in `read`, or the file lacks a column of the table's key.
    """
    table = TABLES[table_name]
    names_in_file = column_names_of(path)
    is_repeated = len(set(names_in_file)) < len(names_in_file)
    if is_repeated or set(names_in_file) == set(table.column_names):
        return read(table_name, path)
    key_in_file = [name for name in names_in_file if name in table.key]
    _refuse_other_columns(key_in_file, table.key, table_name, str(path), _ADVICE_ON_OLD_FILES)
    shared_names = [name for name in table.column_names if name in names_in_file]
    _check_written_as(table_name, path, shared_names)
    content = _file_content(path, columns=shared_names)
    frame = conform(_as_frame([content]), table_name, str(path), _ADVICE_ON_OLD_FILES, shared_names)
    complaint = repetition_complaint(frame, table.key) if table.key else ""
    if complaint:
        raise OilfilmError(f"{path}: table {table_name!r}: {cut(complaint, 1000)}.")
    return frame


def column_names_of(path: Path) -> list[str]:
    """Names of the columns that a file has.

    Raises:
        OilfilmError: The file is missing or damaged.
    """
    return list(_schema(path).names)


def from_arrow(content: arrow.Table) -> pd.DataFrame:
    """A block of `arrow_blocks` as a frame; its values are not checked."""
    return _as_frame([content])


def _rows_of_file(
    table_name: str, path: Path, columns: Sequence[str] | None, row_filter: Mapping[str, str]
) -> arrow.Table:
    """The rows of a file that pass a filter, checked one row group after the other.

    Arrow's own filter reads many row groups ahead, which takes as much memory as the whole table.
    """
    column_names = TABLES[table_name].column_names if columns is None else list(columns)
    needed_names = list(dict.fromkeys([*column_names, *row_filter]))
    _check_written_as(table_name, path)
    schema = _schema(path)
    contents = [arrow.schema([schema.field(name) for name in needed_names]).empty_table()]
    for content in arrow_blocks(table_name, path, needed_names, row_filter):
        matching_rows = content.select(needed_names)
        for name, value in row_filter.items():
            matching_rows = matching_rows.filter(compute.equal(matching_rows[name], value))
        contents.append(matching_rows)
    return arrow.concat_tables(
        [content.replace_schema_metadata(None) for content in contents]
    ).select(column_names)


def _as_frame(contents: list[arrow.Table], use_threads: bool = True) -> pd.DataFrame:
    """Arrow tables with rows of one table as a frame; the list of them is emptied.

    No column is in memory twice: Arrow's copy is freed when pandas has its own.
    """
    content = arrow.concat_tables([part.replace_schema_metadata(None) for part in contents])
    contents.clear()
    content = content.unify_dictionaries()
    column_names = content.column_names
    tuples_by_name = {}
    for field in content.schema:
        if _is_list_of_texts(field.type):
            tuples_by_name[field.name] = _tuples_of(content[field.name])
    content = content.drop_columns(list(tuples_by_name))
    frame = content.to_pandas(split_blocks=True, self_destruct=True, use_threads=use_threads)
    for name, tuples in tuples_by_name.items():
        frame.insert(column_names.index(name), name, tuples)
    # Arrow keeps freed memory for itself
    arrow.default_memory_pool().release_unused()
    return frame


def _tuples_of(column: arrow.ChunkedArray) -> "np.ndarray[Any, np.dtype[np.object_]]":
    """Lists of texts as tuples, None where missing. Arrow would make an array for each of them."""
    tuples = np.empty(len(column), dtype=object)
    # few lists differ: one tuple for each
    shared: dict[tuple[str, ...], tuple[str, ...]] = {}
    row = 0
    for chunk in column.chunks:
        encoded = chunk.flatten().dictionary_encode()
        distinct_texts = encoded.dictionary.to_pylist()
        codes = encoded.indices.to_pylist()
        position = 0
        for length in chunk.value_lengths().to_pylist():
            if length is not None:
                texts = tuple(
                    [distinct_texts[code] for code in codes[position : position + length]]
                )
                tuples[row] = shared.setdefault(texts, texts)
                position += length
            row += 1
    return tuples


def read_blocks(
    table_name: str, *paths: Path, columns: Sequence[str] | None = None
) -> Iterator[pd.DataFrame]:
    """The row groups of files, one after the other, each checked as by `read`.

    Args:
        table_name: Name of the declaration in `TABLES`.
        paths: Its files.
        columns: The columns to read; all if not given.

    Raises:
        OilfilmError: As `read`.
    """
    for path in paths:
        for content in arrow_blocks(table_name, path, columns):
            # one thread, because the shares of a campaign are spread over all cores
            rows = _as_frame([content], use_threads=False)
            yield conform(rows, table_name, str(path), _ADVICE_ON_OLD_FILES, columns)


def arrow_blocks(
    table_name: str,
    path: Path,
    columns: Sequence[str] | None = None,
    row_filter: Mapping[str, str] | None = None,
) -> Iterator[arrow.Table]:
    """The row groups of a file as tables of Arrow; their values are not checked.

    Args:
        table_name: Name of the declaration in `TABLES`.
        path: The file.
        columns: The columns to read; all if not given.
        row_filter: Row groups that cannot have these values are left out.

    Raises:
        OilfilmError: As `read`, but for values.
    """
    _check_written_as(table_name, path)
    try:
        with parquet.ParquetFile(path, page_checksum_verification=True) as file:
            for group_index in range(file.num_row_groups):
                if not _may_match(file.metadata.row_group(group_index), row_filter or {}):
                    continue
                yield file.read_row_group(group_index, columns, use_threads=False)
    except READ_ERRORS as error:
        raise _damage_error(path, error) from error


def _may_match(row_group: parquet.RowGroupMetaData, row_filter: Mapping[str, str]) -> bool:
    """Whether a row group may have rows that pass a filter, by its smallest and largest values."""
    for column_index in range(row_group.num_columns):
        column = row_group.column(column_index)
        value = row_filter.get(column.path_in_schema)
        statistics = column.statistics
        if value is None or statistics is None or not statistics.has_min_max:
            continue
        if not statistics.min <= value <= statistics.max:
            return False
    return True


def _file_content(
    path: Path,
    filters: list[tuple[str, str, str]] | None = None,
    columns: Sequence[str] | None = None,
) -> arrow.Table:
    """The content of a file, each page checked, without columns from the folder's name."""
    try:
        return parquet.read_table(
            path,
            columns=None if columns is None else list(columns),
            partitioning=None,
            page_checksum_verification=True,
            filters=filters,
        )
    except READ_ERRORS as error:
        raise _damage_error(path, error) from error


def _damage_error(path: Path | str, error: Exception | str) -> OilfilmError:
    return OilfilmError(
        f"{path}: cannot be read as Parquet ({error}). Delete it and run snakemake again."
    )


def read_run(table_name: str, paths: Sequence[Path], run_id: str) -> pd.DataFrame:
    """The rows of one run, from the files that may hold them.

    Raises:
        OilfilmError: As `read`.
    """
    for path in paths:
        _check_written_as(table_name, path)
    # what is not of the run never leaves Arrow, and row groups without it are not even read
    filters = [("run_id", "==", run_id)]
    contents = [_file_content(path, filters=filters) for path in paths]
    return conform(_as_frame(contents), table_name, f"run {run_id}", _ADVICE_ON_OLD_FILES)


def _check_written_as(table_name: str, path: Path, columns: Sequence[str] | None = None) -> None:
    """Refuse a file that holds another table, other columns, or a column in another unit.

    Args:
        table_name: Name of the declaration in `TABLES`.
        path: The file.
        columns: Columns whose unit is checked. If not given, the file must have all columns of the
            table and no others.
    """
    schema = _schema(path)
    written_name = footer_of(schema, path).get("table")
    if written_name != table_name:
        raise OilfilmError(
            f"{path}: holds table {cut(repr(written_name))}; expected {table_name!r}. Delete it "
            "and run snakemake again."
        )
    if columns is None:
        columns = TABLES[table_name].column_names
        _refuse_other_columns(schema.names, columns, table_name, str(path), _ADVICE_ON_OLD_FILES)
    for column in [TABLES[table_name][name] for name in columns]:
        metadata = schema.field(column.name).metadata or {}
        unit = metadata.get(b"unit", b"").decode("utf-8", "replace")
        if unit != column.unit:
            raise OilfilmError(
                f"{path}: column {column.name!r} is in {cut(repr(unit))}; expected "
                f"{column.unit!r}. {_ADVICE_ON_OLD_FILES}"
            )


def read_footer(path: Path) -> dict[str, Any]:
    """Provenance and table name of a Parquet file.

    Raises:
        OilfilmError: The file is missing, damaged or was not written by oilfilm.
    """
    return footer_of(_schema(path), path)


def _schema(path: Path) -> arrow.Schema:
    try:
        return parquet.read_schema(path)
    except FileNotFoundError as error:
        raise OilfilmError(f"{path}: there is no such table; snakemake makes it.") from error
    except READ_ERRORS as error:
        raise _damage_error(path, error) from error


def footer_of(schema: arrow.Schema, path: Path | str) -> dict[str, Any]:
    """Provenance and table name in the schema of a Parquet file.

    Args:
        schema: The schema.
        path: The file, for messages.

    Raises:
        OilfilmError: The footer is damaged, or was not written by oilfilm.
    """
    metadata = schema.metadata or {}
    try:
        footer = json.loads(metadata.get(b"oilfilm", b"null"))
    except (ValueError, RecursionError) as error:
        raise _damage_error(path, error) from error
    if not isinstance(footer, dict):
        raise OilfilmError(f"{path}: it is Parquet, but not a table of oilfilm.")
    return footer


def _arrow_schema(table_name: str) -> arrow.Schema:
    fields = []
    for column in TABLES[table_name].columns:
        metadata = {"unit": column.unit, "description": column.description}
        fields.append(arrow.field(column.name, _ARROW_TYPES[column.dtype], metadata=metadata))
    return arrow.schema(fields)


_ARROW_TYPES = {
    "float64": arrow.float64(),
    "int64": arrow.int64(),
    "bool": arrow.bool_(),
    "boolean": arrow.bool_(),
    "str": arrow.string(),
    "object": arrow.list_(arrow.string()),
    "category": arrow.dictionary(arrow.int32(), arrow.string()),
}
