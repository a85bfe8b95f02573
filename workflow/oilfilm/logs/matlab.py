"""MATLAB files (.mat, versions 5 to 7): variables, structures and matrices with names of columns.

Three forms are a run: vectors of equal length, one per variable; a structure of such vectors, or
each element of an array of structures; a matrix with a cell array of names, and one of units if
there is one. Single numbers and texts beside them are header keys. The file is checked for its size
before a value is read; nothing of it is executed.

Decides: what of a MATLAB file is a table.
"""

import io
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from oilfilm.base.plain_key import plain_key
from oilfilm.logs import base
from oilfilm.logs.base import NO_DIALECT, UnreadableLogError
from oilfilm.logs.columns import text_of_value, texts_of_values
from oilfilm.logs.header import header_of_part
from oilfilm.logs.log_schema import Vocabulary
from oilfilm.logs.logged_table import LoggedTable, TablesOfFile, Texts, Values

_TITLE = b"MATLAB 5.0 MAT-file"
_TITLE_OF_HDF5 = b"MATLAB 7.3 MAT-file"
# A file is a header, then elements, each with a tag: its type and its number of bytes.
_HEADER_BYTES = 128
_TAG_BYTES = 8
# Type of an element that is packed with zlib (miCOMPRESSED).
_COMPRESSED = 15
_CHUNK_BYTES = 1 << 20
# Small, because numbers that are stored in one byte take eight in memory.
_MOST_UNPACKED_BYTES = 1 << 26
# A small file may always be unpacked to this size.
_UNSUSPICIOUS_BYTES = 1 << 24
# Names of the cell array that names the columns of a matrix; MATLAB's `importdata` gives the first.
_VARIABLES_WITH_COLUMN_NAMES = (
    "colheaders",
    "names",
    "column_names",
    "columnnames",
    "varnames",
    "headers",
)
_VARIABLES_WITH_UNITS = ("units", "unit")
_SAVE_AGAIN = "Save it in MATLAB with save(file, '-v7'), or export it as csv."


def recognises(first_bytes: bytes) -> bool:
    """True for the title of a MATLAB file of version 5 to 7.3."""
    return first_bytes.startswith((_TITLE, _TITLE_OF_HDF5))


def tables(content: bytes, vocabulary: Vocabulary) -> TablesOfFile:
    """See `ingest.Reader.tables`."""
    if content.startswith(_TITLE_OF_HDF5):
        reason = "the file is of MATLAB's version 7.3 (HDF5), which is not read"
        raise UnreadableLogError(reason, _SAVE_AGAIN, rule="unknown_format")
    _check_size(content)
    # imported where needed: few logs are of MATLAB
    from scipy.io import loadmat  # noqa: PLC0415

    # the types that come with SciPy know names of files only
    file: Any = io.BytesIO(content)
    variables = loadmat(file, squeeze_me=False, struct_as_record=True)
    user_variables = {name: value for name, value in variables.items() if not name.startswith("__")}
    logged_tables = list(_tables(user_variables))
    if not logged_tables:
        names_found = ", ".join(sorted(user_variables))[:200] or "none"
        reason = f"no variable is a table: expected vectors of equal length; found {names_found}"
        advice = "Save a table T as a structure: S = table2struct(T, 'ToScalar', true)."
        raise UnreadableLogError(reason, advice)
    if len(logged_tables) == 1:
        return NO_DIALECT, [logged_tables[0].with_name("")]
    names = base.distinct_names(table.run_name for table in logged_tables)
    return NO_DIALECT, [
        table.with_name(name) for table, name in zip(logged_tables, names, strict=True)
    ]


def _check_size(content: bytes) -> None:
    """Refuse a file whose variables would fill the memory when they are unpacked.

    Raises:
        UnreadableLogError: They have more bytes than any log, or than packed data can have.
        ValueError: A variable is longer than the file.
    """
    byte_order = "<" if content[126:128] == b"IM" else ">"
    most_byte_count = min(
        _MOST_UNPACKED_BYTES, max(_UNSUSPICIOUS_BYTES, base.MOST_UNPACKED_RATIO * len(content))
    )
    position = _HEADER_BYTES
    unpacked_byte_count = 0
    while position + _TAG_BYTES <= len(content):
        element_type, element_byte_count = struct.unpack_from(f"{byte_order}II", content, position)
        end = position + _TAG_BYTES + element_byte_count
        if end > len(content):
            raise ValueError("it ends within a variable")
        if element_type == _COMPRESSED:
            unpacked_byte_count += _unpacked_byte_count(
                content[position + _TAG_BYTES : end], most_byte_count
            )
        else:
            unpacked_byte_count += element_byte_count
        if unpacked_byte_count > most_byte_count:
            raise base.too_large_error(
                f"unpacked the file has more than {most_byte_count >> 20} MiB"
            )
        position = end


def _unpacked_byte_count(packed: bytes, most_byte_count: int) -> int:
    """Number of bytes of a packed variable, counted up to a limit without keeping them."""
    stream = zlib.decompressobj()
    byte_count = 0
    remaining = packed
    while remaining and byte_count <= most_byte_count:
        byte_count += len(stream.decompress(remaining, _CHUNK_BYTES))
        remaining = stream.unconsumed_tail
    return byte_count


def _tables(variables: Mapping[str, Any]) -> Iterator[LoggedTable]:
    """The tables of a file: each structure, and the variables themselves."""
    text_of_key = dict(_header_items(variables))
    table = _table("", variables, text_of_key)
    if table is not None:
        yield table
    for name, value in variables.items():
        if not isinstance(value, np.ndarray) or value.dtype.names is None:
            continue
        elements = value.reshape(-1)
        for number, element in enumerate(elements, start=1):
            fields = {field: element[field] for field in value.dtype.names}
            run_name = f"{name}{number}" if len(elements) > 1 else name
            table = _table(
                run_name, fields, header_of_part(text_of_key, dict(_header_items(fields)))
            )
            if table is not None:
                yield table


def _table(
    run_name: str, variables: Mapping[str, Any], text_of_key: Mapping[str, str]
) -> LoggedTable | None:
    """A table of vectors of equal length, or of a matrix if it has more numbers; else None."""
    vector_of_name = _vectors(variables)
    column_of_name = _columns_of_table(vector_of_name)
    matrix_column_of_name = _columns_of_matrix(variables)
    if _number_count(matrix_column_of_name) > _number_count(column_of_name):
        column_of_name = vector_of_name = matrix_column_of_name
    if not column_of_name:
        return None
    row_count = len(next(iter(column_of_name.values())))
    base.check_row_count(row_count)
    names = list(column_of_name)
    units = _units_of_columns(variables, vector_of_name, names)
    numbers_of_columns = [_numbers(column) for column in column_of_name.values()]
    columns = list(column_of_name.values())

    def read_values(column_indices: Sequence[int]) -> list[Values]:
        return [numbers_of_columns[column_index] for column_index in column_indices]

    def read_texts(column_index: int) -> Texts:
        column = columns[column_index]
        if column.dtype == object:
            cells = [_text(cell) for cell in column]
            return np.array(cells, dtype=object)
        return texts_of_values(column)

    return LoggedTable(
        text_of_key, names, units, read_values, row_count, run_name, read_texts=read_texts
    )


def _vectors(variables: Mapping[str, Any]) -> dict[str, Values]:
    """Name -> vector, for the vectors longer than 1, without the cell array of units."""
    vector_of_name: dict[str, Values] = {}
    for name, value in variables.items():
        is_vector = isinstance(value, np.ndarray) and value.ndim == 2 and min(value.shape) == 1
        is_units = plain_key(name) in _VARIABLES_WITH_UNITS and value.dtype == object
        if is_vector and value.dtype.names is None and value.size > 1 and not is_units:
            vector_of_name[name] = value.reshape(-1)
    return vector_of_name


def _columns_of_table(vector_of_name: Mapping[str, Values]) -> dict[str, Values]:
    """Name -> vector, for vectors of the most frequent length; empty without numbers.

    Of lengths that are as frequent, the largest counts.
    """
    lengths = [len(vector) for vector in vector_of_name.values() if vector.dtype.kind in "iuf"]
    if not lengths:
        return {}
    length = max(lengths, key=lambda length: (lengths.count(length), length))
    # one vector is no table
    if lengths.count(length) < 2:
        return {}
    return {name: vector for name, vector in vector_of_name.items() if len(vector) == length}


def _number_count(column_of_name: Mapping[str, Values]) -> int:
    """Number of all numbers in some columns."""
    return sum(column.size for column in column_of_name.values() if column.dtype.kind in "iuf")


def _units_of_columns(
    variables: Mapping[str, Any], vector_of_name: Mapping[str, Values], names: Sequence[str]
) -> list[str]:
    """The unit of each column of a table; empty where it is not known.

    Units are those of the columns of the table, of all vectors, or of the vectors of numbers:
    whichever are as many. Where these pair units with different names, no unit is known.
    """
    units = _texts_of_variable(variables, _VARIABLES_WITH_UNITS)
    vectors_of_numbers = [
        name for name, vector in vector_of_name.items() if vector.dtype.kind in "iuf"
    ]
    columns_of_numbers = [name for name in names if name in vectors_of_numbers]
    pairings: list[list[str]] = []
    for described_names in (names, list(vector_of_name), vectors_of_numbers, columns_of_numbers):
        if len(units) == len(described_names):
            unit_of_name = dict(zip(described_names, units, strict=True))
            pairings.append([unit_of_name.get(name, "") for name in names])
    is_clear = len(pairings) > 0 and all(pairing == pairings[0] for pairing in pairings)
    return pairings[0] if is_clear else [""] * len(names)


def _columns_of_matrix(variables: Mapping[str, Any]) -> dict[str, Values]:
    """Name -> column, for the only matrix beside a cell array of as many names; else empty."""
    matrices = [
        value
        for value in variables.values()
        if isinstance(value, np.ndarray)
        and value.ndim == 2
        and value.dtype.kind in "iuf"
        and min(value.shape) > 1
    ]
    names = _texts_of_variable(variables, _VARIABLES_WITH_COLUMN_NAMES)
    fitting_matrices = [matrix for matrix in matrices if matrix.shape[1] == len(names)]
    if len(fitting_matrices) != 1 or len(set(names)) < len(names):
        return {}
    return {name: fitting_matrices[0][:, index] for index, name in enumerate(names)}


def _texts_of_variable(variables: Mapping[str, Any], variable_names: Sequence[str]) -> list[str]:
    """The texts of the first variable with one of some names; empty without one."""
    for name, value in variables.items():
        is_named_so = plain_key(name) in variable_names
        if is_named_so and isinstance(value, np.ndarray) and value.dtype == object:
            return [_text(cell) for cell in value.reshape(-1)]
    return []


def _numbers(column: Values) -> Values:
    """A column of numbers; one of texts stays without numbers."""
    if column.dtype.kind in "iuf":
        return column
    return np.array([], dtype=str)


def _header_items(variables: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Header keys: texts and single numbers."""
    for name, value in variables.items():
        if isinstance(value, np.ndarray) and value.size == 1 and value.dtype.names is None:
            text = _text(value.reshape(-1)[0])
            if text:
                yield plain_key(name), text


def _text(cell: Any) -> str:
    """The text of a cell; empty for anything but a text or a real number, and for NaN."""
    while isinstance(cell, np.ndarray) and cell.size == 1:
        cell = cell.reshape(-1)[0]
    if isinstance(cell, (str, np.str_)):
        return str(cell).strip()
    if isinstance(cell, (int, float, np.integer, np.floating)) and not np.isnan(cell):
        return text_of_value(float(cell))
    return ""
