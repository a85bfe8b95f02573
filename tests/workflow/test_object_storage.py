"""Whole runs with logs, results or releases in object storage: the bytes of a run in folders."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from campaigns import lay_out_measured, lay_out_small, read_campaign, write_campaign
from damages import SOUND
from oilfilm import tables
from oilfilm.cli import main
from oilfilm.releases.table_diff import file_difference
from oilfilm.releases.verify import verify
from reproduce import IN_ONE_SHARE, Surroundings, fail, succeed
from storage_servers import (
    IN_BUCKET,
    SECRET,
    Storage,
    cut_after,
    files_with_a_key,
    in_environment,
    keep_in_bucket,
    moto_storage,
    seaweed_storage,
    store_logs,
)

pytestmark = pytest.mark.workflow

SMALL = ("--config", "campaign=small")
OWN = ("--config", "campaign=own")


def around(storage: Storage) -> Surroundings:
    return Surroundings("2", storage.environment)


@pytest.fixture(scope="module")
def quick() -> Iterator[Storage]:
    with moto_storage() as storage:
        storage.client().create_bucket(Bucket="lab")
        yield storage


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Storage]:
    with seaweed_storage(tmp_path_factory.mktemp("seaweed")) as storage:
        storage.client().create_bucket(Bucket="lab")
        yield storage


def assert_same(local: Path, stored: dict[str, bytes], folder: Path) -> None:
    """Every file of the bucket has the bytes of the local run; the first difference is named."""
    for name, content in sorted(stored.items()):
        if name == ".oilfilm":  # it only keeps the bucket
            continue
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        assert content == (local / name).read_bytes(), file_difference(local / name, path)


def add_torque_log(project: Path) -> None:
    """A torque log of the campaign `own`."""
    campaign = read_campaign(project, "own")
    torque = read_campaign(project, "demo")["torque"]
    del torque["matrix"], torque["twin"]
    write_campaign(project, "own", campaign | {"torque": torque})
    log = project / "data/raw/own-torque/a.csv"
    log.parent.mkdir()
    log.write_bytes(SOUND["torque"].text())


@pytest.mark.nightly
def test_points_from_logs_in_a_bucket_are_those_from_a_folder(
    released_project: Path, quick: Storage, tmp_path: Path
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    for project in (here, there):
        lay_out_small(project)
        lay_out_measured(released_project, project)
        add_torque_log(project)
    store_logs(there, quick)
    points = "results/own/tables/points.parquet"
    made = (points, "results/own/tables/torque_runs.parquet")
    succeed(here, *made, *OWN)
    output = succeed(there, *made, *OWN, around=around(quick))
    assert SECRET not in output
    assert files_with_a_key(quick, there) == []
    for path in (here / "results/own").rglob("*.parquet"):
        same = there / path.relative_to(here)
        assert path.read_bytes() == same.read_bytes(), file_difference(path, same)
    torque = tables.read_footer(there / made[1])
    assert "data/raw/own-torque" in torque["inputs"]
    # A log that is put anew into the bucket is read anew, the others are not.
    changed, others = sorted(quick.files("lab", "logs/own/"))[0], "s3://lab/logs/own/"
    content = quick.files("lab", "logs/own/")[changed]
    assert "Nothing to be done" in succeed(there, points, *OWN, "-n", around=around(quick)), others
    quick.put("lab", {f"logs/own/{changed}": content.replace(b"\n", b"\r\n")})
    message = fail(there, points, *OWN, "-n", around=around(quick))
    assert f"data/raw/own/{changed}: has changed since a run first read it" in message
    (there / "data/first_seen/own.sha256").unlink()
    planned = succeed(there, points, *OWN, "-n", around=around(quick))
    assert planned.count("rule ingest:") == 1


@pytest.mark.nightly
def test_points_that_go_to_a_bucket_are_those_of_a_folder(
    released_project: Path, quick: Storage, tmp_path: Path
) -> None:
    lay_out_small(tmp_path / "project")
    points = "results/small/tables/points.parquet"
    arguments = (points, *SMALL, *IN_BUCKET, "s3://lab/quick")
    output = succeed(tmp_path / "project", *arguments, around=around(quick))
    assert SECRET not in output
    assert files_with_a_key(quick, tmp_path) == []
    assert len(output.splitlines()) < 20
    stored = quick.files("lab", "quick/")
    assert points in stored
    assert_same(released_project, stored, tmp_path / "stored")


def test_points_from_a_bucket_to_a_bucket_are_those_of_folders(
    released_project: Path, quick: Storage, tmp_path: Path
) -> None:
    """Logs and results in a bucket; only the names of campaign and inputs differ."""
    project, points = tmp_path / "project", "tables/points.parquet"
    lay_out_small(project)
    lay_out_measured(released_project, project)
    store_logs(project, quick)
    arguments = (f"results/own/{points}", *OWN, IN_ONE_SHARE, *IN_BUCKET, "s3://lab/both")
    output = succeed(project, *arguments, around=around(quick))
    assert SECRET not in output
    assert len(output.splitlines()) < 20
    stored = quick.files("lab", "both/")
    copied = tmp_path / "points.parquet"
    copied.write_bytes(stored[f"results/own/{points}"])
    local = released_project / "results/small" / points
    assert tables.read("points", copied).equals(tables.read("points", local))


def test_missing_bucket_ends_a_run_and_is_not_made(quick: Storage, tmp_path: Path) -> None:
    lay_out_small(tmp_path)
    output = fail(tmp_path, *SMALL, *IN_BUCKET, "s3://nobody/x", around=around(quick))
    assert "s3://nobody: there is no such bucket." in output
    names = [each["Name"] for each in quick.client().list_buckets()["Buckets"]]
    assert "nobody" not in names


@pytest.mark.parametrize("prefix", [[], ["--default-storage-prefix", f"s3://key:{SECRET}@lab/x"]])
def test_results_without_a_bucket_end_a_run_in_a_sentence(
    quick: Storage, tmp_path: Path, prefix: list[str]
) -> None:
    lay_out_small(tmp_path)
    output = fail(tmp_path, *SMALL, *IN_BUCKET[:2], *prefix, around=around(quick))
    assert "s3://BUCKET/PLACE" in output
    assert "Traceback" not in output
    assert SECRET not in output


@pytest.mark.nightly
def test_run_with_results_and_release_on_a_real_server(
    released_project: Path, real: Storage, tmp_path: Path
) -> None:
    project = tmp_path / "project"
    lay_out_small(project)
    keep_in_bucket(project, releases="s3://lab/releases")
    output = succeed(
        project, "release", *SMALL, *IN_BUCKET, "s3://lab/all/of/it", around=around(real)
    )
    stored = real.files("lab", "all/of/it/")
    assert "results/small/report.html" in stored
    # what the release adds to its folder is in the folder
    assert_same(released_project, stored, tmp_path / "stored")
    local = released_project / "results/releases/small/latest"
    version = local.readlink().name
    assert_same(local, real.files("lab", f"releases/small/{version}/"), tmp_path / "release")
    assert verify(tmp_path / "release") == []
    assert SECRET not in output
    for folder in (project, tmp_path / "stored", tmp_path / "release"):
        assert files_with_a_key(real, folder) == []


@pytest.mark.nightly
def test_logs_on_a_real_server_give_the_release_of_a_folder_and_it_can_be_rebuilt(
    released_project: Path,
    real: Storage,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    lay_out_small(here)
    lay_out_measured(released_project, here)
    lay_out_small(there)
    lay_out_measured(released_project, there)
    store_logs(there, real)
    succeed(here, "release", *OWN)
    succeed(there, "release", *OWN, around=around(real))
    assert files_with_a_key(real, there) == []
    local = here / "results/releases/own/latest"
    place = f"s3://lab/releases/own/{local.readlink().name}"
    fetched = tmp_path / "fetched"
    with in_environment(real):
        assert main(["fetch", place, str(fetched)]) == 0
    assert "all files are as released" in capsys.readouterr().out
    for path in local.rglob("*"):
        if path.is_file():
            assert path.read_bytes() == (fetched / path.relative_to(local)).read_bytes(), path
    monkeypatch.chdir(there)
    with in_environment(real):
        assert main(["verify", place, "--rebuild", "--cores", "2"]) == 0
    assert "rebuilt from the raw logs: the same bytes" in capsys.readouterr().out


@pytest.mark.nightly
def test_wrong_key_and_missing_bucket_of_a_real_server_end_in_a_sentence(
    released_project: Path, real: Storage, tmp_path: Path
) -> None:
    """Whatever is kept there: all results, releases or logs."""
    lay_out_small(tmp_path)
    lay_out_measured(released_project, tmp_path)
    config = tmp_path / "config/config.yaml"
    text, stranger = config.read_text(encoding="utf-8"), real.with_wrong_key()
    refused = "s3://lab: the storage refuses the key (InvalidAccessKeyId)"
    for place, sentence, server in (
        ("s3://lab/x", refused, stranger),
        ("s3://nobody/x", "s3://nobody: there is no such bucket", real),
    ):
        keep_in_bucket(tmp_path, releases=place)
        outputs = [
            fail(tmp_path, *SMALL, *IN_BUCKET, place, around=around(server)),
            fail(tmp_path, "release", *SMALL, around=around(server)),
        ]
        config.write_text(text, encoding="utf-8")
        keep_in_bucket(tmp_path, raw=place)
        outputs.append(fail(tmp_path, *OWN, around=around(server)))
        config.write_text(text, encoding="utf-8")
        for output in outputs:
            assert sentence in output
            assert SECRET not in output
            assert server.key not in output
        assert files_with_a_key(server, tmp_path) == []
    assert not real.files("lab", "x/")
    assert not (tmp_path / "results").exists()


@pytest.mark.nightly
def test_run_whose_connection_breaks_is_completed_by_the_next_one(
    released_project: Path, real: Storage, tmp_path: Path
) -> None:
    project = tmp_path / "project"
    lay_out_small(project)
    points = "results/small/tables/points.parquet"
    arguments = (points, *SMALL, *IN_BUCKET, "s3://lab/cut")
    whole = sum(
        path.stat().st_size
        for folder in ("data/raw/small", "results/small/tables/samples")
        for path in (released_project / folder).rglob("*")
        if path.is_file()
    )
    with cut_after(real, whole // 2) as cut:
        output = fail(project, *arguments, around=around(cut))
    assert "storage" in output
    assert files_with_a_key(real, project) == []
    begun = real.files("lab", "cut/")
    assert points not in begun
    # every object is whole
    assert_same(released_project, begun, tmp_path / "begun")
    succeed(project, *arguments, around=around(real))
    stored = real.files("lab", "cut/")
    assert points in stored
    assert_same(released_project, stored, tmp_path / "stored")
