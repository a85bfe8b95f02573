"""Whole runs with results in object storage: the bytes of a run in folders."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from campaigns import lay_out_small
from reproduce import fail, succeed
from storage_servers import IN_BUCKET, SECRET, Storage, files_with_a_key, moto_storage

pytestmark = pytest.mark.workflow

SMALL = ("--config", "campaign=small")


@pytest.fixture(scope="module")
def storage() -> Iterator[Storage]:
    with moto_storage() as storage:
        yield storage


def assert_same(local: Path, stored: dict[str, bytes]) -> None:
    """Every file of the bucket has the bytes of the local run, and no key."""
    for name, content in stored.items():
        assert content == (local / name).read_bytes(), name
        assert SECRET.encode() not in content


def test_points_that_go_to_a_bucket_are_those_of_a_folder(
    released_project: Path, storage: Storage, tmp_path: Path
) -> None:
    project = tmp_path / "project"
    lay_out_small(project)
    points = "results/small/parts/points/0/points.parquet"
    output = succeed(project, points, *SMALL, *IN_BUCKET, "s3://lab/quick")
    assert SECRET not in output
    assert files_with_a_key(tmp_path) == []
    stored = storage.files("quick/")
    assert points in stored
    assert_same(released_project, stored)


@pytest.mark.nightly
def test_results_without_a_place_end_a_run_in_a_sentence(storage: Storage, tmp_path: Path) -> None:
    lay_out_small(tmp_path)
    output = fail(tmp_path, *SMALL, *IN_BUCKET[:2])
    assert "s3://BUCKET/PLACE" in output


@pytest.mark.nightly
def test_run_with_results_in_a_bucket_makes_the_same_release(
    released_project: Path, storage: Storage, tmp_path: Path
) -> None:
    project = tmp_path / "project"
    lay_out_small(project)
    arguments = ("release", *SMALL, *IN_BUCKET, "s3://lab/all/of/it")
    output = succeed(project, *arguments)
    stored = storage.files("all/of/it/")
    assert "results/small/report.html" in stored
    assert_same(released_project, stored)
    local = released_project / "results/releases/small/latest"
    release = project / "results/releases/small" / local.readlink().name
    assert (release / "manifest.json").read_bytes() == (local / "manifest.json").read_bytes()
    assert SECRET not in output
    assert files_with_a_key(project) == []
