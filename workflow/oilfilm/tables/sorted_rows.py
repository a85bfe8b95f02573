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

from oilfilm.tables import arrow_parts, from_arrow, read

# Rows that are sorted at once; a range of runs has hardly more.
_ROWS_OF_RANGE = 1 << 16
_COMPRESSION = arrow.ipc.IpcWriteOptions(compression="lz4")


def sorted_rows(
    table: str, paths: Sequence[Path], counts: "pd.Series[int]", folder: Path
) -> Iterator[pd.DataFrame]:
    """The rows of a table of runs in the order of run and first row, some of them at a time.

    Args:
        table: Name of the table's model, which has the columns `run_id` and `first_row`.
        paths: Its files, in which the rows of a run may be anywhere.
        counts: Number of rows of each run, by `run_id`.
        folder: For temporary files; it must hold the table once more.

    Raises:
        OilfilmError: As `tables.read`.
    """
    starts = _first_runs(counts)
    if len(starts) <= 1:
        yield _in_order(read(table, *paths))
        return
    with tempfile.TemporaryDirectory(prefix=".sorted-", dir=folder) as temporary:
        ranges = [Path(temporary, f"{number}.arrow") for number in range(len(starts))]
        _spread(table, paths, starts, ranges)
        for path in ranges:
            with arrow.ipc.open_file(path) as file:
                rows = from_arrow(file.read_all())
            yield _in_order(rows)


def _first_runs(counts: "pd.Series[int]") -> "np.ndarray[tuple[int], np.dtype[np.object_]]":
    """The first run of each range."""
    # a run without rows has no file
    ordered = counts[counts > 0].sort_index()
    number = (ordered.cumsum() - ordered) // _ROWS_OF_RANGE
    return ordered.index[~number.duplicated()].to_numpy(dtype=object)


def _spread(
    table: str,
    paths: Sequence[Path],
    starts: "np.ndarray[tuple[int], np.dtype[np.object_]]",
    ranges: Sequence[Path],
) -> None:
    """Write each row of some files to the file of its range."""
    with ExitStack() as files:
        writers: dict[int, arrow.ipc.RecordBatchFileWriter] = {}
        for content in chain.from_iterable(arrow_parts(table, path) for path in paths):
            runs = content["run_id"].to_numpy().astype(object)
            range_of_row = np.searchsorted(starts, runs, side="right") - 1
            # a run that was refused counts no rows, and may stand before the first range
            range_of_row = np.maximum(range_of_row, 0)
            for number in np.unique(range_of_row).tolist():
                if number not in writers:
                    schema = content.schema
                    writer = arrow.ipc.new_file(ranges[number], schema, options=_COMPRESSION)
                    writers[number] = files.enter_context(writer)
                writers[number].write_table(content.filter(range_of_row == number))


def _in_order(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows in the order of run and first row."""
    return rows.sort_values(["run_id", "first_row"], ignore_index=True)
