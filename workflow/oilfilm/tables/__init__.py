"""The contract: what every table holds, checked whenever one is written or read.

Each column is declared once, in a YAML file, with its unit, meaning and caveat. Each table lists
its columns and its key. Units and descriptions are in the footer of the Parquet file, beside the
provenance. They say by which declaration it was written: there is no version to raise.

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
from oilfilm.tables.dictionary import LARGEST as LARGEST
from oilfilm.tables.dictionary import TABLES as TABLES
from oilfilm.tables.dictionary import Column as Column
from oilfilm.tables.dictionary import Table as Table
from oilfilm.tables.dictionary import unit_of as unit_of

# Bytes of a table once it is unpacked.
LARGEST_TABLE = 1 << 30
# Columns and row groups; no table here has a hundredth of them.
_MOST_CHUNKS = 100_000
# Types of at most 8 bytes a value.
_PLAIN_TYPES = {"BOOLEAN", "INT32", "INT64", "FLOAT", "DOUBLE"}
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
    for kind in metadata.schema.to_arrow_schema().types:
        if arrow.types.is_nested(kind) and not _is_list_of_texts(kind):
            raise ValueError(f"its columns hold {kind}, which no table here does")
    row_groups = [metadata.row_group(group) for group in range(metadata.num_row_groups)]
    chunks = [group.column(index) for group in row_groups for index in range(group.num_columns)]
    unknown = {chunk.physical_type for chunk in chunks} - {*_PLAIN_TYPES, "BYTE_ARRAY"}
    if unknown:
        raise ValueError(f"its columns hold {min(unknown)}, which no table here does")
    size = sum(max(chunk.total_uncompressed_size, 8 * chunk.num_values) for chunk in chunks)
    # Only here a value has a length of its own. Read as a dictionary it lies in memory once.
    text_chunks = [chunk for chunk in chunks if chunk.physical_type == "BYTE_ARRAY"]
    text_columns = sorted({chunk.path_in_schema for chunk in text_chunks})
    if size > largest or not text_columns:
        return size
    for batch in parquet.ParquetFile(file, read_dictionary=text_columns).iter_batches(
        columns=text_columns
    ):
        for column in batch.columns:
            values = column.flatten() if isinstance(column, arrow.ListArray) else column
            if isinstance(values, arrow.DictionaryArray):
                lengths = compute.binary_length(values.dictionary.cast(arrow.large_binary()))
                size += compute.sum(lengths.take(values.indices)).as_py() or 0
            else:
                size += values.nbytes
    return size


def _is_list_of_texts(kind: arrow.DataType) -> bool:
    return arrow.types.is_list(kind) and arrow.types.is_string(kind.value_type)


def columns(table: str) -> list[str]:
    """Names of a table's columns, in order."""
    return TABLES[table].names


def empty(table: str) -> pd.DataFrame:
    """The table with no rows and every column of its type."""
    return _empty(table).copy()


@cache
def _empty(table: str) -> pd.DataFrame:
    return pd.DataFrame(
        {column.name: pd.Series(dtype=column.dtype) for column in TABLES[table].columns}
    )


def from_rows(rows: list[dict[str, Any]], table: str) -> pd.DataFrame:
    """A table from one mapping per row; no rows give the empty table."""
    return conform(pd.DataFrame(rows), table, "new rows") if rows else empty(table)


def filled(frame: pd.DataFrame, table: str, where: str = "new rows") -> pd.DataFrame:
    """Rows as a table: what they do not know is missing, 0 or empty, or the first text allowed.

    Raises:
        OilfilmError: As `conform`.
    """
    placeholder_by_type: dict[str, Any] = {"number": 0.0, "integer": 0, "flag": False, "text": ""}
    values = {}
    for column in TABLES[table].columns:
        given = frame.get(column.name, pd.Series(np.nan, frame.index))
        if column.type == "texts":
            values[column.name] = given if column.nullable else _with_empty_lists(given)
            continue
        if not column.nullable and given.hasnans:
            placeholder = (*column.allowed, placeholder_by_type[column.type])[0]
            given = given.astype(object).where(given.notna(), placeholder)
        dtype: Any = column.dtype
        values[column.name] = given.astype(dtype)
    return conform(pd.DataFrame(values), table, where)


def _with_empty_lists(values: pd.Series) -> pd.Series:
    """Lists of texts, empty where there is none."""
    return _as_tuples(values).map(lambda texts: () if texts is None else texts)


def rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, one dictionary per row."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


# Why the columns of a table are not those that are declared.
_GIVEN = "Give values for each declared column and for no other (workflow/oilfilm/tables)."
_OTHER_VERSION = (
    "It was made by another version of oilfilm: read it with that version, or make it again."
)


def conform(
    frame: pd.DataFrame,
    table: str,
    where: str,
    advice: str = _GIVEN,
    columns: Sequence[str] | None = None,
) -> pd.DataFrame:
    """The frame with the columns of the table in order and of their types, after every check.

    Columns are checked one at a time: a whole frame of samples at once takes three times the
    memory. Pandera checks only columns that do not plainly obey their declaration, because it
    takes a millisecond per column and several passes over a long one.

    Args:
        frame: The rows.
        table: Name of the table's model.
        where: Where the rows are from, for messages.
        advice: What to do where the columns are not those that are declared.
        columns: The columns that the frame has, in order; all of the table if not given. Checks
            over several columns or rows need them all.

    Raises:
        OilfilmError: A column is missing, unknown, or holds what the contract forbids.
    """
    model = TABLES[table]
    names = model.names if columns is None else list(columns)
    _refuse_other_columns(frame.columns, names, table, where, advice)
    frame = frame.reset_index(drop=True)
    checked = {name: _checked(frame, model[name], model, where) for name in names}
    # one block of all columns would be one more copy of a large table
    conformed = pd.DataFrame(checked, columns=names, copy=False)
    if columns is None:
        for complaint in model.complaints(conformed):
            raise OilfilmError(f"{where}: table {table!r}: {cut(complaint, 1000)}.")
    return conformed


def _refuse_other_columns(
    found: Iterable[str], expected: Sequence[str], table: str, where: str, advice: str
) -> None:
    """Refuse columns that are not those expected, each once, in any order.

    Raises:
        OilfilmError: A column is missing, unknown or repeated.
    """
    found = list(found)
    missing = [name for name in expected if name not in found]
    unknown = [name for name in found if name not in expected]
    if missing or unknown:
        raise OilfilmError(
            f"{where}: table {table!r} lacks the columns {missing or 'none'} and has the unknown "
            f"columns {cut(unknown or 'none')}. {advice}"
        )
    if len(found) > len(expected):
        repeated = [name for name in expected if found.count(name) > 1]
        raise OilfilmError(f"{where}: table {table!r} repeats the columns {repeated}. {advice}")


def _checked(frame: pd.DataFrame, column: Column, model: Table, where: str) -> pd.Series:
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
        validated = model.schema.columns[column.name].validate(frame[[column.name]], lazy=True)
    except (SchemaErrors, SchemaError) as error:
        case = error.failure_cases.iloc[0]
        expected = case.get("check", column.dtype)
        raise OilfilmError(
            f"{where}: table {model.name!r}, column {column.name!r} ({column.description}): found "
            f"{cut(repr(case['failure_case']))} at row {case['index']}, expected {expected}."
        ) from error
    return validated[column.name]


def lists(values: Sequence[tuple[str, ...]], index: pd.Index) -> pd.Series:
    """A column of lists of texts.

    Args:
        values: The texts of each row.
        index: Of the rows.
    """
    return pd.Series(list(values), index, dtype=object)


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
    """True where a column has its type and keeps its bounds; in any doubt false."""
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


def write(frame: pd.DataFrame, table: str, path: Path, provenance: Mapping[str, Any]) -> None:
    """Check a table and write it completely or not at all, with units and provenance in its footer.

    Args:
        frame: The rows.
        table: Name of the table's model.
        path: Parquet file to write.
        provenance: At least `campaign` and `data` ("simulated" or "measured"); plain JSON values.

    Raises:
        OilfilmError: The frame breaks the contract.
    """
    with writing(table, path, provenance, ROW_GROUP) as add:
        add(frame)


# Rows that are in memory at once where a long table is written or read a part at a time.
ROW_GROUP = 1 << 18


@contextmanager
def writing(
    table: str, path: Path, provenance: Mapping[str, Any], rows_of_group: int | None = None
) -> Iterator[Callable[[pd.DataFrame], None]]:
    """Write a table a part at a time, completely or not at all, as `write` does.

    No check compares the keys of two parts. The provenance may grow until the last part is written.

    Args:
        table: Name of the table's model.
        path: Parquet file to write.
        provenance: As for `write`.
        rows_of_group: Rows of each row group but the last, whatever rows the parts have: the bytes
            do not depend on the parts then. Each part is a row group if not given.

    Raises:
        OilfilmError: A part breaks the contract.
    """
    schema = _arrow_schema(table)
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
            waiting: list[pd.DataFrame] = []
            groups = 0

            def write_group(group: pd.DataFrame) -> None:
                nonlocal groups
                # column by column, in half of the time of `from_pandas` of the table
                arrays = [
                    arrow.array(group[field.name], field.type, from_pandas=True) for field in schema
                ]
                writer.write_table(arrow.table(arrays, schema=schema), max(len(group), 1))
                groups += 1

            def add(frame: pd.DataFrame) -> None:
                part = conform(frame, table, str(path))
                if rows_of_group is None:
                    write_group(part)
                    return
                waiting.append(part)
                if sum(map(len, waiting)) < rows_of_group:
                    return
                rows = pd.concat(waiting, ignore_index=True) if len(waiting) > 1 else part
                waiting.clear()
                # a whole table as Arrow's would be one more copy of it
                whole_groups = len(rows) // rows_of_group * rows_of_group
                for start in range(0, whole_groups, rows_of_group):
                    write_group(rows.iloc[start : start + rows_of_group])
                waiting.append(rows.iloc[whole_groups:].copy())

            yield add
            rest = [part for part in waiting if len(part)]
            if rest:
                write_group(pd.concat(rest, ignore_index=True) if len(rest) > 1 else rest[0])
            elif not groups:
                write_group(empty(table))
            footer = {"table": table, **provenance}
            metadata = {"oilfilm": json.dumps(footer, sort_keys=True, ensure_ascii=False)}
            encoded_schema = b64encode(schema.with_metadata(metadata).serialize())
            writer.add_key_value_metadata({**metadata, "ARROW:schema": encoded_schema})


# Numbers hardly repeat: a dictionary of them takes five times the time and saves nothing.
_ENCODINGS = {"int64": "DELTA_BINARY_PACKED", "double": "BYTE_STREAM_SPLIT"}


def read(
    table: str,
    *paths: Path,
    columns: Sequence[str] | None = None,
    wanted: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Read a table from one file, from several or from none (then empty), and check it again.

    A long table needs the memory of the columns and the rows that are read, and no more. Checks
    over several columns are made where the whole table is read.

    Args:
        table: Name of the table's model.
        paths: Its files.
        columns: The columns to read; all if not given.
        wanted: What a column must be in the rows that are read; all rows if not given.

    Raises:
        OilfilmError: A file is missing or damaged, holds another table or columns in other units,
            or breaks the contract.
    """
    if not paths:
        return empty(table) if columns is None else empty(table)[list(columns)]
    where = str(paths[0]) if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"
    if wanted:
        parts = [_wanted_rows(table, path, columns, wanted) for path in paths]
    else:
        for path in paths:
            _check_written_as(table, path)
        parts = [_content(path, columns=columns) for path in paths]
    return conform(_as_frame(parts), table, where, _OTHER_VERSION, columns)


def from_arrow(content: arrow.Table) -> pd.DataFrame:
    """A part of a table, as `arrow_parts` gives it, as a frame; its values are not checked."""
    return _as_frame([content])


def _wanted_rows(
    table: str, path: Path, columns: Sequence[str] | None, wanted: Mapping[str, str]
) -> arrow.Table:
    """The wanted rows of a file, filtered one row group after the other.

    Arrow's own filter reads many row groups ahead, which takes as much memory as the whole table.
    """
    names = TABLES[table].names if columns is None else list(columns)
    needed = list(dict.fromkeys([*names, *wanted]))
    _check_written_as(table, path)
    schema = _schema(path)
    kept = [arrow.schema([schema.field(name) for name in needed]).empty_table()]
    for part in arrow_parts(table, path, needed, wanted):
        rows = part.select(needed)
        for name, value in wanted.items():
            rows = rows.filter(compute.equal(rows[name], value))
        kept.append(rows)
    return arrow.concat_tables([part.replace_schema_metadata(None) for part in kept]).select(names)


def _as_frame(parts: list[arrow.Table], use_threads: bool = True) -> pd.DataFrame:
    """Parts of one table as a frame; the list of parts is emptied.

    Two copies of a column are never there: Arrow's goes when pandas has it.
    """
    content = arrow.concat_tables([part.replace_schema_metadata(None) for part in parts])
    parts.clear()
    content = content.unify_dictionaries()
    names = content.column_names
    lists = {}
    for field in content.schema:
        if _is_list_of_texts(field.type):
            lists[field.name] = _tuples_of(content[field.name])
    content = content.drop_columns(list(lists))
    frame = content.to_pandas(split_blocks=True, self_destruct=True, use_threads=use_threads)
    for name, tuples in lists.items():
        frame.insert(names.index(name), name, tuples)
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
        words = encoded.dictionary.to_pylist()
        codes = encoded.indices.to_pylist()
        end = 0
        for length in chunk.value_lengths().to_pylist():
            if length is not None:
                texts = tuple([words[code] for code in codes[end : end + length]])
                tuples[row] = shared.setdefault(texts, texts)
                end += length
            row += 1
    return tuples


def read_parts(
    table: str, *paths: Path, columns: Sequence[str] | None = None
) -> Iterator[pd.DataFrame]:
    """The row groups of files, one after the other, each checked as by `read`.

    Args:
        table: Name of the table's model.
        paths: Its files.
        columns: The columns to read; all if not given.

    Raises:
        OilfilmError: As `read`.
    """
    for path in paths:
        for content in arrow_parts(table, path, columns):
            # one thread, because the shares of a campaign are spread over all cores
            rows = _as_frame([content], use_threads=False)
            yield conform(rows, table, str(path), _OTHER_VERSION, columns)


def arrow_parts(
    table: str,
    path: Path,
    columns: Sequence[str] | None = None,
    wanted: Mapping[str, str] | None = None,
) -> Iterator[arrow.Table]:
    """The row groups of a file as Arrow has them; their values are not checked.

    Args:
        table: Name of the table's model.
        path: The file.
        columns: The columns to read; all if not given.
        wanted: Row groups that cannot have these values are left out.

    Raises:
        OilfilmError: As `read`, but for values.
    """
    _check_written_as(table, path)
    try:
        with parquet.ParquetFile(path, page_checksum_verification=True) as file:
            for group in range(file.num_row_groups):
                if not _may_have(file.metadata.row_group(group), wanted or {}):
                    continue
                yield file.read_row_group(group, columns, use_threads=False)
    except UNREADABLE as error:
        raise _damaged(path, error) from error


def _may_have(group: parquet.RowGroupMetaData, wanted: Mapping[str, str]) -> bool:
    """Whether a row group may have rows with some values, by its smallest and largest ones."""
    for index in range(group.num_columns):
        column = group.column(index)
        value = wanted.get(column.path_in_schema)
        ends = column.statistics
        if value is None or ends is None or not ends.has_min_max:
            continue
        if not ends.min <= value <= ends.max:
            return False
    return True


def _content(
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
    except UNREADABLE as error:
        raise _damaged(path, error) from error


def _damaged(path: Path, error: Exception | str) -> OilfilmError:
    return OilfilmError(
        f"{path}: cannot be read as Parquet ({error}). Delete it and run snakemake again."
    )


def read_run(table: str, paths: Sequence[Path], run_id: str) -> pd.DataFrame:
    """The rows of one run, from the files that may hold them.

    Raises:
        OilfilmError: As `read`.
    """
    for path in paths:
        _check_written_as(table, path)
    # what is not of the run never leaves Arrow, and row groups without it are not even read
    rows_of_run = [("run_id", "==", run_id)]
    parts = [_content(path, filters=rows_of_run) for path in paths]
    return conform(_as_frame(parts), table, f"run {run_id}", _OTHER_VERSION)


def _check_written_as(table: str, path: Path) -> None:
    """Refuse a file that holds another table, other columns, or a column in another unit."""
    schema = _schema(path)
    name = _footer(path, schema).get("table")
    if name != table:
        raise OilfilmError(
            f"{path}: holds table {cut(repr(name))}; expected {table!r}. Delete it and run "
            "snakemake again."
        )
    _refuse_other_columns(schema.names, TABLES[table].names, table, str(path), _OTHER_VERSION)
    for column in TABLES[table].columns:
        metadata = schema.field(column.name).metadata or {}
        unit = metadata.get(b"unit", b"").decode("utf-8", "replace")
        if unit != column.unit:
            raise OilfilmError(
                f"{path}: column {column.name!r} is in {cut(repr(unit))}; expected "
                f"{column.unit!r}. {_OTHER_VERSION}"
            )


def read_footer(path: Path) -> dict[str, Any]:
    """Provenance and table name of a Parquet file.

    Raises:
        OilfilmError: The file is missing, damaged or was not written by oilfilm.
    """
    return _footer(path, _schema(path))


def _schema(path: Path) -> arrow.Schema:
    try:
        return parquet.read_schema(path)
    except FileNotFoundError as error:
        raise OilfilmError(f"{path}: there is no such table; snakemake makes it.") from error
    except UNREADABLE as error:
        raise _damaged(path, error) from error


def _footer(path: Path, schema: arrow.Schema) -> dict[str, Any]:
    metadata = schema.metadata or {}
    try:
        footer = json.loads(metadata.get(b"oilfilm", b"null"))
    except (ValueError, RecursionError) as error:
        raise _damaged(path, error) from error
    if not isinstance(footer, dict):
        raise OilfilmError(f"{path}: it is Parquet, but not a table of oilfilm.")
    return footer


def _arrow_schema(table: str) -> arrow.Schema:
    fields = []
    for column in TABLES[table].columns:
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
