"""Whole runs with results in object storage: the bytes of a run in folders."""

from pathlib import Path

import pytest

from campaigns import lay_out_small
from reproduce import fail, succeed
from storage_servers import IN_BUCKET, SECRET, files_with_a_key, moto_storage

pytestmark = [pytest.mark.workflow, pytest.mark.nightly]

SMALL = ("--config", "campaign=small")


def test_results_without_a_place_end_a_run_in_a_sentence(tmp_path: Path) -> None:
    lay_out_small(tmp_path)
    assert "s3://BUCKET/PLACE" in fail(tmp_path, *SMALL, *IN_BUCKET[:2])


def test_results_in_a_bucket_make_the_same_release(released_project: Path, tmp_path: Path) -> None:
    lay_out_small(tmp_path)
    with moto_storage() as storage:
        output = succeed(tmp_path, "release", *SMALL, *IN_BUCKET, "s3://lab/all/of/it")
        stored = storage.files("all/of/it/")
    assert "results/small/report.html" in stored
    for name, content in stored.items():
        assert content == (released_project / name).read_bytes(), name
        assert SECRET.encode() not in content
    local = released_project / "results/releases/small/latest"
    release = tmp_path / "results/releases/small" / local.readlink().name
    assert (release / "manifest.json").read_bytes() == (local / "manifest.json").read_bytes()
    assert SECRET not in output
    assert files_with_a_key(tmp_path) == []
