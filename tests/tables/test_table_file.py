"""Samples in files: what is stated of them does not depend on the files that they are in."""

from pathlib import Path

import pandas as pd
import pytest

from campaigns import Campaign
from oilfilm import tables
from oilfilm.tables.table_file import content_digest, digests_of_runs, samples_by_run

ABOUT = {"campaign": "demo", "data": "simulated"}


@pytest.fixture(scope="module")
def samples(demo: Campaign) -> pd.DataFrame:
    """Of four runs, the rows of a run together."""
    of_oil = next(iter(demo.ingested.samples.values()))
    few = of_oil[of_oil["run_id"].isin(of_oil["run_id"].unique()[:4])]
    return few.astype({"run_id": str}).reset_index(drop=True)


def write(samples: pd.DataFrame, path: Path) -> Path:
    content = {**ABOUT, "content": digests_of_runs(samples)}
    tables.write(samples, "samples", path, content)
    return path


def test_hash_of_samples_does_not_depend_on_files(samples: pd.DataFrame, tmp_path: Path) -> None:
    first, *others = samples["run_id"].unique()
    one_file = [write(samples, tmp_path / "all.parquet")]
    parts = [samples[samples["run_id"].isin(others)], samples[samples["run_id"] == first]]
    two_files = [write(part, tmp_path / f"{len(part)}.parquet") for part in parts]
    assert content_digest(one_file) == content_digest(two_files)
    assert content_digest(one_file)[1] == len(samples)
    read = samples_by_run(two_files)
    for run_id in samples["run_id"].unique():
        expected = samples[samples["run_id"] == run_id].reset_index(drop=True)
        assert read(run_id).astype({"run_id": str}).equals(expected)


def test_hash_of_samples_changes_with_one_value_of_a_run(samples: pd.DataFrame) -> None:
    before = digests_of_runs(samples)
    assert len(before) == 4
    assert digests_of_runs(samples.head(0)) == {}
    changed = samples.copy()
    changed.loc[len(samples) - 1, "load_n"] += 1e-9
    after = digests_of_runs(changed)
    assert [run for run in before if before[run] != after[run]] == [samples["run_id"].iloc[-1]]
