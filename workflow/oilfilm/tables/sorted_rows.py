"""The rows of many files in the order of their key, without all of them in memory.

The rows are first spread over files on disk, each with a range of runs, and then sorted range by
range. The cost is linear in the number of rows.

Decides: how many rows are sorted at once.
"""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import chain
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as arrow

from oilfilm.tables import arrow_blocks, from_arrow, read

# Number of rows that are sorted at once; a range of runs has hardly more.
_RANGE_ROW_COUNT = 1 << 16
_COMPRESSION = arrow.ipc.IpcWriteOptions(compression="lz4")


def sorted_rows(
    table_name: str, paths: Sequence[Path], row_count_of_run: "pd.Series[int]", folder: Path
) -> Iterator[pd.DataFrame]:
    """The rows of a table of runs in the order of run and first row, some of them at a time.

    Args:
        table_name: Name of the declaration, which has the columns `run_id` and `first_row`.
        paths: Its files, in which the rows of a run may be anywhere.
        row_count_of_run: Number of rows of each run, by `run_id`.
        folder: For temporary files; it must hold the table once more.

    Raises:
        OilfilmError: As `tables.read`.
    """
    first_run_id_of_range = _first_run_id_of_range(row_count_of_run)
    if len(first_run_id_of_range) <= 1:
        yield _by_run_and_row(read(table_name, *paths))
        return
    with tempfile.TemporaryDirectory(prefix=".sorted-", dir=folder) as temporary:
        range_paths = [
            Path(temporary, f"{range_index}.arrow")
            for range_index in range(len(first_run_id_of_range))
        ]
        _spread(table_name, paths, first_run_id_of_range, range_paths)
        for path in range_paths:
            with arrow.ipc.open_file(path) as file:
                rows = from_arrow(file.read_all())
            yield _by_run_and_row(rows)


def _first_run_id_of_range(
    row_count_of_run: "pd.Series[int]",
) -> "np.ndarray[tuple[int], np.dtype[np.object_]]":
    """The name of the first run of each range, in order."""
    # a run without rows is in no file
    ordered_counts = row_count_of_run[row_count_of_run > 0].sort_index()
    range_number_of_run = (ordered_counts.cumsum() - ordered_counts) // _RANGE_ROW_COUNT
    return ordered_counts.index[~range_number_of_run.duplicated()].to_numpy(dtype=object)


def _spread(
    table_name: str,
    paths: Sequence[Path],
    first_run_id_of_range: "np.ndarray[tuple[int], np.dtype[np.object_]]",
    range_paths: Sequence[Path],
) -> None:
    """Write each row of some files to the file of its range."""
    with ExitStack() as files:
        writers: dict[int, arrow.ipc.RecordBatchFileWriter] = {}
        for row_group in chain.from_iterable(arrow_blocks(table_name, path) for path in paths):
            run_ids = row_group["run_id"].to_numpy().astype(object)
            range_of_row = np.searchsorted(first_run_id_of_range, run_ids, side="right") - 1
            # a refused run has no count, and its name may come before the first range
            range_of_row = np.maximum(range_of_row, 0)
            for range_index in np.unique(range_of_row).tolist():
                if range_index not in writers:
                    schema = row_group.schema
                    writer = arrow.ipc.new_file(
                        range_paths[range_index], schema, options=_COMPRESSION
                    )
                    writers[range_index] = files.enter_context(writer)
                writers[range_index].write_table(row_group.filter(range_of_row == range_index))


def _by_run_and_row(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows in the order of run and first row."""
    return rows.sort_values(["run_id", "first_row"], ignore_index=True)
