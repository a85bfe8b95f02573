"""A share of the logs is ingested and curated a run at a time: the same results, bounded memory."""

from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pyarrow.parquet as parquet
import pytest

import bad_logs
from damages import SOUND
from oilfilm import tables
from oilfilm.curation.curate import Curated, collect, curate_ingested, curate_parts
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.ingest import Ingested, ingest_logs, sample_files

ABOUT = {"campaign": "demo", "data": "simulated"}
CONFIG = bad_logs.CONFIG
LOGS = [
    ("sound", SOUND["traction"].text()),
    ("short", bad_logs.csv(bad_logs.good((0.0, 0.05, 0.0)))),
    # a second look at the samples finds the mistake
    ("force_in_mn", SOUND["traction"].column("traction_force", lambda force_n: 1000 * force_n)),
    ("no_rows", SOUND["traction"].text().partition(b"\n0")[0]),
]


def in_parts(logs: Iterator[tuple[str, bytes]], folder: Path) -> tuple[Ingested, Curated]:
    paths = {oil: folder / f"{oil}.parquet" for oil in CONFIG.oils}
    with sample_files(paths, ABOUT) as keep:
        ingested = ingest_logs(logs, CONFIG, keep=keep)
    samples = tables.read_parts("samples", *paths.values())
    return ingested, collect(curate_parts(samples, ingested, TractionRig(CONFIG)), CONFIG)


def test_share_in_parts_gives_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = len(SOUND["traction"].values["time"])
    monkeypatch.setattr(tables, "ROW_GROUP", 2 * rows)
    whole = ingest_logs(LOGS, CONFIG)
    expected = curate_ingested(whole, TractionRig(CONFIG))
    ingested, curated = in_parts(iter(LOGS), tmp_path)
    assert {"accepted", "refused"} == set(expected.runs["verdict"])
    assert {"", "force_scale", "no_rows"} <= set(expected.runs["rule"])
    pd.testing.assert_frame_equal(ingested.runs, whole.runs, check_exact=True)
    for name, frame in vars(expected).items():
        pd.testing.assert_frame_equal(getattr(curated, name), frame, check_exact=True)
    for oil, frame in whole.samples.items():
        path = tmp_path / f"{oil}.parquet"
        pd.testing.assert_frame_equal(tables.read("samples", path), frame, check_exact=True)
        file = parquet.ParquetFile(path).metadata
        rows_of_groups = [file.row_group(at).num_rows for at in range(file.num_row_groups)]
        assert max(rows_of_groups) <= 2 * rows
