"""Tables checked, written whole or not at all, and read."""

import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pandera.pandas as pa
import pyarrow as arrow
import pyarrow.parquet as parquet

from oilfilm.atomic_write import atomic_file
from oilfilm.errors import OilfilmError
from oilfilm.tables import bearing, drawn, fits, paper, rig
from oilfilm.tables.fields import Table, repeated, unit_of

SCHEMA_VERSION = 7

TABLES: dict[str, type[Table]] = {
    **rig.TABLES,
    **fits.TABLES,
    **paper.TABLES,
    **bearing.TABLES,
    **drawn.TABLES,
}
_KEYS = {**rig.KEYS, **fits.KEYS, **paper.KEYS, **bearing.KEYS}


def columns(table: str) -> list[str]:
    """Names of a table's columns, in order."""
    return list(TABLES[table].to_schema().columns)


def empty(table: str) -> pd.DataFrame:
    """The table with no rows and every column of its type."""
    return _empty(table).copy()


@cache
def _empty(table: str) -> pd.DataFrame:
    return conform(pd.DataFrame({name: [] for name in columns(table)}), table, "an empty table")


def from_rows(rows: list[dict[str, Any]], table: str) -> pd.DataFrame:
    """A table from one mapping a row; no rows give the empty table."""
    return conform(pd.DataFrame(rows), table, "new rows") if rows else empty(table)


def rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, a dictionary each."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def conform(frame: pd.DataFrame, table: str, where: str) -> pd.DataFrame:
    """The frame with the table's columns in order and its types, every check passed.

    Columns are checked one at a time: a whole frame of samples at once takes three times the
    memory. Pandera is asked only about columns that do not plainly obey their model, because it
    takes a millisecond a column and several passes over a long one.

    Raises:
        OilfilmError: A column is missing, unknown, or holds what the contract forbids.
    """
    schema = TABLES[table].to_schema()
    missing = [name for name in schema.columns if name not in frame.columns]
    unknown = [name for name in frame.columns if name not in schema.columns]
    if missing or unknown:
        raise OilfilmError(
            f"{where}: table {table!r} lacks {missing or 'no column'} and has the unknown "
            f"{unknown or 'none'}. It was made by another version: rebuild it."
        )
    frame = frame.reset_index(drop=True)
    checked = {}
    for name, column in schema.columns.items():
        checked[name] = frame[name]
        if _plainly_obeys(checked[name], column):
            continue
        try:
            checked[name] = column.validate(frame[[name]], lazy=True)[name]
        except (pa.errors.SchemaErrors, pa.errors.SchemaError) as error:
            case = error.failure_cases.iloc[0]
            expected = case.get("check", column.dtype)
            raise OilfilmError(
                f"{where}: table {table!r}, column {name!r} ({column.description}): found "
                f"{case['failure_case']!r} at row {case['index']}, expected {expected}."
            ) from error
    # one block of all columns would be one more copy of a large table
    conformed = pd.DataFrame(checked, columns=list(schema.columns), copy=False)
    complaints = [
        repeated(conformed, _KEYS[table]) if table in _KEYS else "",
        rig.CHECKS[table](conformed) if table in rig.CHECKS else "",
    ]
    for complaint in filter(None, complaints):
        raise OilfilmError(f"{where}: table {table!r}: {complaint}.")
    return conformed


# pandera's name of a check -> whether all values of a column, nulls aside, pass it
_PLAIN_CHECKS: dict[str, Callable[..., bool]] = {
    "greater_than_or_equal_to": lambda values, min_value: (
        not np.fmin.reduce(values.to_numpy()) < min_value
    ),
    "less_than_or_equal_to": lambda values, max_value: (
        not np.fmax.reduce(values.to_numpy()) > max_value
    ),
    "isin": lambda values, allowed_values: values.dropna().isin(allowed_values).all(),
}


def _plainly_obeys(values: pd.Series, column: pa.Column) -> bool:
    """True where a column has its model's type and keeps its bounds; in any doubt false."""
    if values.dtype.name != column.dtype.type.name or column.unique:
        return False
    if values.empty:
        return True
    return (column.nullable or not values.hasnans) and all(
        check.name in _PLAIN_CHECKS and _PLAIN_CHECKS[check.name](values, **check.statistics)
        for check in column.checks
    )


def write(frame: pd.DataFrame, table: str, path: Path, provenance: Mapping[str, Any]) -> None:
    """Check a table and write it whole or not at all, with units and provenance in the footer.

    Args:
        frame: The rows.
        table: Name of the table's model.
        path: Parquet file to write.
        provenance: At least `campaign` and `data` ("simulated" or "measured"); plain JSON values.

    Raises:
        OilfilmError: The frame breaks the contract.
    """
    conformed, schema = conform(frame, table, str(path)), _arrow_schema(table)
    # column by column, in half of the time of `from_pandas`
    content = arrow.table(
        [arrow.array(conformed[field.name], field.type, from_pandas=True) for field in schema],
        schema=schema,
    )
    footer = {"table": table, "schema_version": SCHEMA_VERSION, **provenance}
    content = content.replace_schema_metadata(
        {"oilfilm": json.dumps(footer, sort_keys=True, ensure_ascii=False)}
    )
    encodings = {
        field.name: _ENCODINGS[str(field.type)] for field in schema if str(field.type) in _ENCODINGS
    }
    with atomic_file(path) as aside:
        parquet.write_table(
            content,
            aside,
            compression="zstd",
            row_group_size=1 << 18,
            use_dictionary=[name for name in schema.names if name not in encodings],
            column_encoding=encodings,
            write_page_checksum=True,
        )


# Numbers hardly repeat: a dictionary of them takes five times the time and saves nothing.
_ENCODINGS = {"int64": "DELTA_BINARY_PACKED", "double": "BYTE_STREAM_SPLIT"}


def read(table: str, *paths: Path) -> pd.DataFrame:
    """Read a table, whole, in several files or in none (then empty), and check it again.

    Raises:
        OilfilmError: A file is missing or damaged, holds another table or another schema
            version, or breaks the contract.
    """
    if not paths:
        return empty(table)
    parts = [_read_part(table, path) for path in paths]
    where = str(paths[0]) if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"
    whole = arrow.concat_tables(parts).unify_dictionaries() if len(parts) > 1 else parts[0]
    return conform(whole.to_pandas(), table, where)


def _read_part(table: str, path: Path) -> arrow.Table:
    _check_footer(table, path)
    return _content(path).replace_schema_metadata(None)


def refuse_damaged(path: Path) -> None:
    """See that every page of a file is as it was written.

    Raises:
        OilfilmError: One is not, or the file is missing.
    """
    _content(path)


def _content(path: Path, **asked: Any) -> arrow.Table:
    """What a file holds, each page checked; not as part of a set, whose folder adds a column."""
    try:
        return parquet.read_table(path, partitioning=None, page_checksum_verification=True, **asked)
    except (OSError, arrow.ArrowException) as error:
        raise _damaged(path, error) from error


def _damaged(path: Path, error: Exception) -> OilfilmError:
    return OilfilmError(
        f"{path}: cannot be read as Parquet ({error}). Delete it and run snakemake again."
    )


def read_run(table: str, paths: Sequence[Path], run_id: str) -> pd.DataFrame:
    """Only the rows of one run, from the files among which they are.

    Raises:
        OilfilmError: As `read`.
    """
    for path in paths:
        _check_footer(table, path)
    # what is not of the run never leaves Arrow, and row groups without it are not even read
    wanted = [("run_id", "==", run_id)]
    content = arrow.concat_tables([_content(path, filters=wanted) for path in paths])
    return conform(content.to_pandas(), table, f"run {run_id}")


def _check_footer(table: str, path: Path) -> None:
    footer = read_footer(path)
    if footer.get("table") != table or footer.get("schema_version") != SCHEMA_VERSION:
        raise OilfilmError(
            f"{path}: holds table {footer.get('table')!r}, schema version "
            f"{footer.get('schema_version')!r}; expected {table!r}, version {SCHEMA_VERSION}. "
            "Delete it and run snakemake again."
        )


def read_footer(path: Path) -> dict[str, Any]:
    """Provenance, table name and schema version of a Parquet file.

    Raises:
        OilfilmError: The file is missing, damaged or was not written by oilfilm.
    """
    try:
        metadata = parquet.read_schema(path).metadata or {}
    except FileNotFoundError as error:
        raise OilfilmError(f"{path}: there is no such table; snakemake makes it.") from error
    except (OSError, arrow.ArrowException) as error:
        raise _damaged(path, error) from error
    if b"oilfilm" not in metadata:
        raise OilfilmError(f"{path}: is Parquet, but not a table of oilfilm.")
    try:
        footer = json.loads(metadata[b"oilfilm"])
    except (ValueError, RecursionError) as error:
        raise _damaged(path, error) from error
    if not isinstance(footer, dict):
        raise OilfilmError(f"{path}: is Parquet, but not a table of oilfilm.")
    return footer


def _arrow_schema(table: str) -> arrow.Schema:
    types = {
        "float64": arrow.float64(),
        "int64": arrow.int64(),
        "bool": arrow.bool_(),
        "category": arrow.dictionary(arrow.int32(), arrow.string()),
    }
    fields = []
    for name, column in TABLES[table].to_schema().columns.items():
        about = {"unit": unit_of(name), "description": column.description}
        fields.append(
            arrow.field(name, types.get(str(column.dtype), arrow.string()), metadata=about)
        )
    return arrow.schema(fields)
