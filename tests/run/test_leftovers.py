"""What a campaign no longer asks for goes, and nothing else."""

from pathlib import Path

import pytest

from oilfilm.base.digests import files_below
from oilfilm.logs.raw_files import listing_text
from oilfilm.run.leftovers import remove_leftovers

ASKED = {
    *("results/june/made/fit-x-one.sha256", "results/june/made/figures.sha256"),
    *("results/june/parts/fit/x/one/constants.parquet", "results/june/logs/fit-x/one.log"),
    *("results/june/figures/curves.png", "results/june/exports", "results/june/report.html"),
}
# A law, a share, a table and a figure of earlier runs; steps have listed the last two.
GONE = {
    *("made/fit-x-two.sha256", "parts/fit/x/two/constants.parquet", "logs/fit-x/two.log"),
    *("parts/points/7/runs.parquet", "parts/points/7/.runs.parquet.part"),
    *("tables/samples/oil=y/part-7.parquet", "twin/truth.parquet"),
    *("tables/claims.parquet", "figures/dropped.png"),
}
KEPT = {
    *(path.removeprefix("results/june/") for path in ASKED - {"results/june/exports"}),
    *("exports/x/law.h", "exports/.snakemake_timestamp"),
    # of a person: no step has listed them
    *("figures/mine.png", "tables/notes.csv", "notes.txt"),
}


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    results = Path("results/june")
    for name in GONE | KEPT:
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).touch()
    listed = ("tables/claims.parquet", "figures/dropped.png", "figures/curves.png")
    stated = {f"results/june/{name}": "0" * 64 for name in listed}
    elsewhere = {"data/raw/june/a.csv": "0" * 64, "results/july/report.html": "0" * 64}
    (results / "made/fit-x-two.sha256").write_text(listing_text(stated | elsewhere))
    for path in elsewhere:
        Path(path).parent.mkdir(parents=True)
        Path(path).touch()
    return results


def test_files_of_steps_go_and_those_of_a_person_stay(results: Path) -> None:
    assert set(remove_leftovers(results, ASKED)) == GONE
    assert set(files_below(results)) == KEPT
    assert Path("data/raw/june/a.csv").exists()
    assert Path("results/july/report.html").exists()
    empty = [
        folder for folder in results.rglob("*") if folder.is_dir() and not any(folder.iterdir())
    ]
    assert empty == []
    assert remove_leftovers(results, ASKED) == []


def test_folder_that_is_a_link_stays(results: Path, tmp_path: Path) -> None:
    other_disk = tmp_path / "disk"
    other_disk.mkdir()
    (other_disk / "old.parquet").touch()
    (results / "parts/old").symlink_to(other_disk)
    remove_leftovers(results, ASKED)
    assert (results / "parts/old/old.parquet").exists()


def test_campaign_that_has_not_run_has_nothing_to_remove(tmp_path: Path) -> None:
    assert remove_leftovers(tmp_path / "results/june", ASKED) == []
