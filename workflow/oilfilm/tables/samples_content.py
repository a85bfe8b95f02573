"""The content of samples: what is stated of it does not depend on the files that hold it."""

from collections.abc import Callable, Iterable, Mapping
from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as parquet

from oilfilm.base.digests import settings_digest
from oilfilm.tables import read_footer, read_run
from oilfilm.tables.dictionary import TABLES


def digests_of_runs(samples: pd.DataFrame) -> dict[str, str]:
    """sha256 of the samples of each run, in hex: they are the same in whatever file they are.

    Args:
        samples: Table of samples, the rows of a run together.
    """
    columns = [column for column in TABLES["samples"].columns if column.name != "run_id"]
    digests = {}
    for run_id, samples_of_run in samples.groupby("run_id", sort=False, observed=True):
        digest = sha256()
        for column in columns:
            digest.update(np.ascontiguousarray(samples_of_run[column.name], column.dtype).data)
        digests[str(run_id)] = digest.hexdigest()
    return digests


def samples_by_run(paths: Iterable[Path]) -> Callable[[str], pd.DataFrame]:
    """Gives the samples of a run; it reads the file that holds them and no other.

    Args:
        paths: Files of samples, with `content` in their footer.

    Raises:
        OilfilmError: A file is missing or damaged.
    """
    file_by_run = {run_id: path for path in paths for run_id in read_footer(path)["content"]}
    return lambda run_id: read_run("samples", [file_by_run[run_id]], run_id)


def content_digest(paths: Iterable[Path]) -> tuple[str, int]:
    """sha256 of the samples in some files, and their number of rows, whatever rows each file has.

    Args:
        paths: As of `samples_by_run`.

    Raises:
        OilfilmError: A file is missing or damaged.
    """
    all_digests: dict[str, str] = {}
    rows = 0
    for path in paths:
        digest_by_run: Mapping[str, str] = read_footer(path)["content"]
        all_digests |= digest_by_run
        rows += parquet.read_metadata(path).num_rows
    return settings_digest(all_digests), rows
