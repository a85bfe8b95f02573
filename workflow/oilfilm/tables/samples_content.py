"""Samples by run, and digests of them that do not depend on how runs are divided into files."""

from collections.abc import Callable, Iterable, Mapping
from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as parquet

from oilfilm.base.digests import mapping_digest
from oilfilm.tables import read_footer, read_run
from oilfilm.tables.dictionary import TABLES


def digests_of_runs(samples: pd.DataFrame) -> dict[str, str]:
    """sha256 of the samples of each run, in hex, by run; it does not depend on their file.

    Args:
        samples: Table of samples; the rows of a run are together.
    """
    columns = [column for column in TABLES["samples"].columns if column.name != "run_id"]
    digest_by_run = {}
    for run_id, samples_of_run in samples.groupby("run_id", sort=False, observed=True):
        digest = sha256()
        for column in columns:
            digest.update(np.ascontiguousarray(samples_of_run[column.name], column.dtype).data)
        digest_by_run[str(run_id)] = digest.hexdigest()
    return digest_by_run


def reader_of_samples(paths: Iterable[Path]) -> Callable[[str], pd.DataFrame]:
    """A function that gives the samples of a run; it reads only the file that holds them.

    Args:
        paths: Files of samples, with `content` in their footer.

    Raises:
        OilfilmError: A file is missing or damaged.
    """
    file_by_run = {run_id: path for path in paths for run_id in read_footer(path)["content"]}
    return lambda run_id: read_run("samples", [file_by_run[run_id]], run_id)


def samples_digest_and_row_count(paths: Iterable[Path]) -> tuple[str, int]:
    """sha256 of the samples in some files, and the number of their rows.

    Neither depends on how the runs are divided into files.

    Args:
        paths: As of `reader_of_samples`.

    Raises:
        OilfilmError: A file is missing or damaged.
    """
    digest_by_run: dict[str, str] = {}
    row_count = 0
    for path in paths:
        digest_by_run_of_file: Mapping[str, str] = read_footer(path)["content"]
        digest_by_run |= digest_by_run_of_file
        row_count += parquet.read_metadata(path).num_rows
    return mapping_digest(digest_by_run), row_count
