"""The workflow as a user runs it: small campaigns from raw logs to figures, in a folder apart."""

import json
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from campaigns import (
    SMALL_MATRIX,
    as_measured,
    lay_out_measured,
    lay_out_small,
    read_campaign,
    write_campaign,
)
from oilfilm import tables
from oilfilm.base.digests import file_digest
from oilfilm.logs.raw_files import listing_text
from oilfilm.releases.stored_release import StoredRelease
from reproduce import announced_jobs, changed_files, fail, files_made, stamps, succeed

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

SMALL = ("--config", "campaign=small")


@pytest.fixture(scope="module")
def project(released_project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project with a small simulated campaign: one oil, 12 runs, two defects."""
    project = tmp_path_factory.mktemp("workflow") / "project"
    shutil.copytree(released_project, project, symlinks=True)
    return project


@pytest.fixture(scope="module")
def results(project: Path) -> Path:
    return project / "results/small"


def test_run_ends_with_a_summary_of_what_was_made(results: Path, released_project: Path) -> None:
    output = released_project.with_suffix(".txt").read_text()
    assert "SIMULATED data (rig twin, campaign 'small')" in output
    assert re.search(r"\n\| 4102 +\| 0\.0.*\bsound\b", output)
    progress, _, _ = output.partition("Campaign small")
    assert len(progress.splitlines()) <= 50  # most of them are the number of jobs of each rule
    for name in ("constants", "curves"):
        for ending in ("png", "svg", "parquet"):
            assert (results / f"figures/{name}.{ending}").stat().st_size > 1000
    report = (results / "report.html").read_text(encoding="utf-8")
    assert "SIMULATED data" in report
    assert "swapped sign" in report
    assert len(report.encode()) < 8e6


def planned(project: Path, *arguments: str) -> dict[str, int]:
    """How many jobs of each rule a dry run would run."""
    return announced_jobs(succeed(project, "-n", *arguments))


def test_tables_of_a_run_are_valid_described_and_say_that_they_are_simulated(results: Path) -> None:
    for name in ("runs", "points", "quarantine", "coefficients", "fit_quality", "coverage"):
        path = results / f"tables/{name}.parquet"
        frame = tables.read(name, path)
        assert len(frame) > 0
        footer = tables.read_footer(path)
        assert (footer["data"], footer["campaign"]) == ("simulated", "small")
    runs = tables.read("runs", results / "tables/runs.parquet")
    refused = runs.loc[runs["verdict"] == "refused", "rule"]
    assert sorted(refused) == ["swapped_sign", "truncated"]
    pages = tables.read("refused_pages", results / "refused/index.parquet")
    assert all((results / "refused" / page).stat().st_size > 1000 for page in pages["page"])
    package = json.loads((results / "tables/datapackage.json").read_text(encoding="utf-8"))
    files = {file["path"] for each in package["resources"] for file in each["files"]}
    folder = results / "tables"
    assert files == {path.relative_to(folder).as_posix() for path in folder.rglob("*.parquet")}


def test_run_is_released_once(project: Path, released_project: Path) -> None:
    folder = (project / "results/releases/small/latest").resolve()
    first = released_project.with_suffix(".txt").read_text()
    assert f"releases/small/{folder.name}: released" in first
    assert StoredRelease.open(folder).find_changes() == []
    assert {"report.html", "summary.txt", "exports", "figures", "refused", "tables"} <= {
        path.name for path in folder.iterdir()
    }
    for path in folder.rglob("*"):
        assert path.is_dir() or str(released_project).encode() not in path.read_bytes(), path


@pytest.mark.nightly
def test_second_run_has_nothing_to_do_and_a_dry_run_changes_no_file(project: Path) -> None:
    before = stamps(project)
    assert "Nothing to be done" in succeed(project, "all", "figures", "-n", *SMALL)
    assert not changed_files(before, stamps(project))


@contextmanager
def changed(path: Path, old: str, new: str) -> Iterator[None]:
    """A file with one text replaced, for a while."""
    before = path.read_text(encoding="utf-8")
    try:
        path.write_text(before.replace(old, new, 1), encoding="utf-8")
        yield
    finally:
        path.write_text(before, encoding="utf-8")


TABLES_OF_OWN = [f"results/own/tables/{name}.parquet" for name in ("points", "runs")]
OWN = (*TABLES_OF_OWN, "--config", "campaign=own")
SHEET = (
    "file,max_hertz_pressure [MPa],entrainment_speed_m_s,inlet_temperature_c,exclude\n"
    "4102_P1.25_U25_T050.csv,1250,25,50,\n"
    "4102_P1.50_*,1500,,,\n"
    "later.csv,1500,,,\n"
)


@pytest.fixture(scope="module")
def own(project: Path) -> Path:
    """The simulated logs as a user's own, made to tables; the header of one is in a run sheet."""
    raw = as_measured(project, "own")
    for simulated in (project / "data/raw/small").glob("*.csv"):
        shutil.copy(simulated, raw)
    log = raw / "4102_P1.25_U25_T050.csv"
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    log.write_text("".join(line for line in lines if not line.startswith("#")), encoding="utf-8")
    (raw / "runs.csv").write_text(SHEET, encoding="utf-8")
    succeed(project, *OWN)
    return raw


def test_logs_with_a_run_sheet_give_the_points_of_their_headers(project: Path, own: Path) -> None:
    simulated, points = (
        tables.read("points", project / f"results/{name}/tables/points.parquet")
        for name in ("small", "own")
    )
    assert simulated.equals(points)
    listed = (project / "results/own/tables/quarantine.csv").read_text(encoding="utf-8")
    assert "row 4: 'later.csv' matches no log" in listed


@pytest.mark.nightly
def test_touched_log_makes_nothing_run_again(project: Path, own: Path) -> None:
    (own / "4102_P1.50_U40_T120.csv").touch()
    assert planned(project, *OWN) == {}


def test_changed_log_redoes_its_own_share_and_needs_a_reason(project: Path, own: Path) -> None:
    name = "4102_P1.50_U40_T120.csv"
    status = (own / name).stat()
    with changed(own / name, "\n#", "#\n"):
        # as a copy that keeps the date; the size is that of before
        os.utime(own / name, ns=(status.st_atime_ns, status.st_mtime_ns))
        assert (own / name).stat().st_size == status.st_size
        # other bytes than those that a run has read need a reason in the campaign file
        message = fail(project, *OWN)
        assert announced_jobs(message)["points"] == 1
        assert f"data/raw/own/{name}: has changed since a run first read it" in message
        lines = re.search(r"(?ms)^acknowledged_changes:.*?reason:", message)
        assert lines, message
        campaign = project / "config/campaigns/own.yaml"
        text = campaign.read_text(encoding="utf-8")
        with changed(campaign, text, f"{text}{lines[0]} the rig wrote an empty line\n"):
            assert planned(project, *OWN) == {"collect": 1}


@pytest.mark.nightly
def test_what_the_campaign_no_longer_asks_for_goes_with_the_next_run(project: Path) -> None:
    results = project / "results/small"
    listed, mine = results / "figures/dropped.png", results / "figures/mine.png"
    of_law, made = (
        results / "parts/fit/4102/carreau/refits.parquet",
        results / "made/dropped.sha256",
    )
    made.write_text(
        listing_text({f"results/small/figures/{listed.name}": "0" * 64}), encoding="utf-8"
    )
    of_law.parent.mkdir()
    for path in (listed, mine, of_law):
        path.touch()
    before = files_made(project)
    assert "Removed 3 files" in succeed(project, "enough", "--forcerun", "enough", *SMALL)
    gone = {path.relative_to(project).as_posix() for path in (listed, of_law, made)}
    assert before - files_made(project) == gone
    assert not of_law.parent.exists()
    mine.unlink()


@pytest.mark.nightly
def test_removed_log_refits_its_oil_alone(tmp_path: Path) -> None:
    project = tmp_path / "project"
    raw = lay_out_measured(project, "two", ["4102", "4050"], SMALL_MATRIX)
    fitted = [f"results/two/tables/{name}.parquet" for name in ("coefficients", "fit_quality")]
    target = (*fitted, "--config", "campaign=two")
    succeed(project, *target)
    listing = project / "data/first_seen/two.sha256"
    listed = listing.read_text(encoding="utf-8")
    assert {f"{file_digest(path)}  data/raw/two/{path.name}" for path in raw.iterdir()} == {
        *listed.splitlines()
    }
    log, logs = raw / "4102_P1.25_U40_T120.csv", project / "results/two/logs"
    before = {path: path.stat().st_mtime_ns for path in logs.rglob("*.log")}
    log.unlink()
    assert f"are gone: data/raw/two/{log.name}." in succeed(project, *target)
    after = (path for path in logs.rglob("*.log") if path.stat().st_mtime_ns != before.get(path))
    again = {path.relative_to(logs).with_suffix("").as_posix() for path in after}
    assert {"fit-4102/deng2026", "fit-4102/tanh", "fits"} <= again
    assert not any(job.startswith("fit-4050") for job in again)
    assert listing.read_text(encoding="utf-8") == listed


@pytest.mark.nightly
@pytest.mark.parametrize("runs", [1, 1000])
def test_release_is_the_same_in_any_split(
    released_project: Path, tmp_path: Path, runs: int
) -> None:
    project = tmp_path / "project"
    lay_out_small(project)
    campaign = read_campaign(project, "small")
    campaign["settings"] |= {"split": {"runs": runs}}
    write_campaign(project, "small", campaign)
    succeed(project, "release", *SMALL)
    manifests = [
        folder / "results/releases/small/latest/manifest.json"
        for folder in (released_project, project)
    ]
    assert manifests[0].read_bytes() == manifests[1].read_bytes()


@pytest.mark.nightly
def test_campaign_without_an_accepted_run_fails_when_everything_is_made(project: Path) -> None:
    raw = as_measured(project, "spoiled")
    wrong_sign, no_log = "4102_P1.00_U40_T050.csv", "notes.csv"
    shutil.copy(project / "data/raw/small" / wrong_sign, raw)
    (raw / no_log).write_text("shift book", encoding="utf-8")
    message = fail(project, "--config", "campaign=spoiled")
    assert "0 of 2 runs accepted, expected at least 1" in message
    # a run that fails later has read its logs, those too that are no logs
    listed = (project / "data/first_seen/spoiled.sha256").read_text(encoding="utf-8")
    assert [line.rpartition("/")[2] for line in listed.splitlines()] == [wrong_sign, no_log]
    results = project / "results/spoiled"
    # a person needs these to see why
    refused = tables.read("quarantine", results / "tables/quarantine.parquet")["rule"]
    assert set(refused) == {"swapped_sign", "columns"}
    assert len(list((results / "refused").glob("*.png"))) == 1
    for page in ("summary.txt", "report.html"):
        assert "NOT ENOUGH: 0 of 2 runs" in (results / page).read_text(encoding="utf-8")
