"""The workflow as a user runs it: small campaigns from raw logs to figures, in a folder apart."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from campaigns import lay_out_small
from oilfilm import tables
from oilfilm.digests import file_digest
from oilfilm.releases.verify import verify

pytestmark = pytest.mark.workflow

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project with a small simulated campaign: one oil, 12 runs, two defects."""
    place = tmp_path_factory.mktemp("project")
    lay_out_small(place)
    return place


@pytest.fixture(scope="module")
def snakemake(place: Path) -> Run:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "snakemake", *arguments]
        environment = {**os.environ, "PYTHONPATH": str(place / "workflow")}
        return subprocess.run(
            command, cwd=place, env=environment, capture_output=True, text=True, check=False
        )

    return run


@pytest.fixture(scope="module")
def finished(place: Path, snakemake: Run) -> str:
    done = snakemake("--config", "campaign=small")
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_run_ends_with_a_summary_of_what_was_made(place: Path, finished: str) -> None:
    assert "Campaign small (SIMULATED by the rig twin)" in finished
    assert "certified: 2 of 2 searches agree" in finished
    assert "Traceback" not in finished
    for name in ("eqs11-13", "curves"):
        for ending in ("png", "svg", "parquet"):
            assert (place / f"results/small/figures/{name}.{ending}").stat().st_size > 1000


def test_snakemakes_own_report_has_every_figure_and_table_with_its_caption(
    place: Path, snakemake: Run, finished: str
) -> None:
    done = snakemake("--config", "campaign=small", "--report", "report-snakemake.html")
    assert done.returncode == 0, done.stdout + done.stderr
    page = (place / "report-snakemake.html").read_text(encoding="utf-8")
    for words in ("Fitted and printed constants", "All curves", "Data quality"):
        assert words in page
    for name in ("coefficients", "fit_quality", "points", "quarantine"):
        assert f"tables/{name}.parquet" in page
    assert "One constant of one traction law for one oil." in page
    # nothing is fetched, so that it opens without a network
    assert not re.search(r"<(script|link|img)[^>]+(src|href)=[\"']?(https?:)?//", page)


def test_target_figures_makes_the_figures_and_no_more(snakemake: Run, finished: str) -> None:
    assert "Nothing to be done" in str(snakemake("figures", "--config", "campaign=small"))
    again = snakemake("-n", "figures", "--forcerun", "law_figures", "--config", "campaign=small")
    assert planned(again) == {"law_figures", "figures", "total"}


def test_tables_of_a_run_are_valid_and_say_that_they_are_simulated(
    place: Path, finished: str
) -> None:
    folder = place / "results/small/tables"
    for name in (
        *("runs", "points", "quarantine", "coefficients", "fit_quality", "coverage"),
        *("extrapolation", "extrapolation_errors"),
    ):
        path = folder / f"{name}.parquet"
        frame = tables.read(name, path)
        assert len(frame) > 0
        footer = tables.read_footer(path)
        assert (footer["data"], footer["campaign"]) == ("simulated", "small")
        assert str(place) not in str(footer)
    runs = tables.read("runs", folder / "runs.parquet")
    refused = runs.loc[runs["verdict"] == "refused", "rule"]
    assert sorted(refused) == ["swapped_sign", "truncated"]
    pages = tables.read("refused_pages", place / "results/small/refused/index.parquet")
    assert all(
        (place / "results/small/refused" / page).stat().st_size > 1000 for page in pages["page"]
    )


def test_tables_of_a_run_are_described(place: Path, finished: str) -> None:
    folder = place / "results/small/tables"
    package = json.loads((folder / "datapackage.json").read_text(encoding="utf-8"))
    files = {file["path"]: file["hash"] for each in package["resources"] for file in each["files"]}
    assert files == {
        path.relative_to(folder).as_posix(): f"sha256:{file_digest(path)}"
        for path in folder.rglob("*.parquet")
    }


def test_fits_of_a_run_are_exported(place: Path, finished: str) -> None:
    folder = place / "results/small/exports"
    content = json.loads((folder / "4102/traction_4102.json").read_text(encoding="utf-8"))
    assert content["data"] == "simulated"
    assert all((folder / "4102" / name).stat().st_size > 100 for name in content["files"].values())
    assert str(place) not in "".join(
        path.read_text(encoding="utf-8") for path in folder.rglob("*.*")
    )


def test_run_has_a_report(place: Path, finished: str) -> None:
    text = (place / "results/small/report.html").read_text(encoding="utf-8")
    assert "SIMULATED data" in text
    assert "swapped_sign" in text
    assert str(place) not in text
    assert len(text.encode()) < 8e6


def test_run_is_released_once(place: Path, snakemake: Run, finished: str) -> None:
    released = snakemake("release", "--config", "campaign=small")
    assert released.returncode == 0, released.stdout + released.stderr
    folder = (place / "results/releases/small/latest").resolve()
    assert f"releases/small/{folder.name}: released" in released.stdout + released.stderr
    assert verify(folder) == []
    assert {"report.html", "summary.txt", "exports", "figures", "refused", "tables"} <= {
        path.name for path in folder.iterdir()
    }
    for path in folder.rglob("*"):
        assert path.is_dir() or str(place).encode() not in path.read_bytes(), path
    again = snakemake("release", "--config", "campaign=small")
    assert "exists already, with the same bytes" in again.stdout + again.stderr


def test_second_run_has_nothing_to_do(snakemake: Run, finished: str) -> None:
    again = snakemake("--config", "campaign=small")
    assert again.returncode == 0
    assert "Nothing to be done" in again.stdout + again.stderr


def planned(output: subprocess.CompletedProcess[str]) -> set[str]:
    """Rules that a dry run would run."""
    text = output.stdout + output.stderr
    table = text.partition("Job stats:")[2].partition("\n\n")[0]
    return {line.split()[0] for line in table.splitlines()[3:] if line.strip()}


def test_changed_gate_judges_again_but_reads_nothing_again(snakemake: Run, finished: str) -> None:
    dry = snakemake("-n", "--config", "campaign=small", "gates={'load_tolerance': 0.05}")
    assert {"curate", "collect"} <= planned(dry)
    assert not {"twin", "ingest"} & planned(dry)


def test_changed_code_runs_what_it_affects_and_nothing_else(
    place: Path, snakemake: Run, finished: str
) -> None:
    module = place / "workflow/oilfilm/outputs/figures/style.py"
    before = module.read_text(encoding="utf-8")
    try:
        module.write_text(before + "\n# touched\n", encoding="utf-8")
        assert planned(snakemake("-n", "--config", "campaign=small")) == {
            "data_figures",
            "law_figures",
            "refused",
            "report",
            "all",
            "total",
        }
    finally:
        module.write_text(before, encoding="utf-8")


def test_corrected_title_redoes_the_description_and_nothing_else(
    place: Path, snakemake: Run, finished: str
) -> None:
    campaign = place / "config/campaigns/small.yaml"
    before = campaign.read_text(encoding="utf-8")
    try:
        campaign.write_text(before.replace("title: ", "title: Corrected ", 1), encoding="utf-8")
        assert planned(snakemake("-n", "--config", "campaign=small")) == {
            "metadata",
            "report",
            "all",
            "total",
        }
    finally:
        campaign.write_text(before, encoding="utf-8")


def test_mistake_in_a_campaign_file_ends_in_a_sentence(place: Path, snakemake: Run) -> None:
    text = (place / "config/campaigns/small.yaml").read_text(encoding="utf-8")
    wrong = text.replace("data: simulated", "data: imagined")
    (place / "config/campaigns/wrong.yaml").write_text(wrong, encoding="utf-8")
    failed = snakemake("--config", "campaign=wrong")
    said = failed.stdout + failed.stderr
    assert failed.returncode != 0
    assert "wrong.yaml, line" in said
    assert "`data`: found 'imagined', expected one of 'measured', 'simulated'" in said
    assert "Traceback" not in said


def test_campaign_without_logs_is_told_where_to_put_them(place: Path, snakemake: Run) -> None:
    failed = snakemake("--config", "campaign=template")
    assert "data/raw/template: there is no such folder" in failed.stdout + failed.stderr


def test_changed_log_redoes_only_its_own_share(place: Path, snakemake: Run, finished: str) -> None:
    """The simulated logs become a user's own; then one of them changes."""
    own = place / "data/raw/own"
    shutil.copytree(place / "data/raw/small", own)
    campaign = yaml.safe_load((place / "config/campaigns/small.yaml").read_text(encoding="utf-8"))
    del campaign["twin"]
    path = place / "config/campaigns/own.yaml"
    path.write_text(yaml.safe_dump(campaign, allow_unicode=True), encoding="utf-8")
    done = snakemake("--config", "campaign=own")
    assert done.returncode == 0, done.stdout + done.stderr
    points = "tables/points.parquet"
    simulated = tables.read("points", place / "results/small" / points)
    assert simulated.equals(tables.read("points", place / "results/own" / points))
    log = own / "4102_P1.50_U40_T120.csv"
    log.write_bytes(log.read_bytes() + b"99.0,142.0,0.1,30000,7500,120.0\n")
    dry = snakemake("-n", "--config", "campaign=own")
    text = dry.stdout + dry.stderr
    assert "ingest            1" in text or "\ningest" in text
    counts = dict(
        line.split()
        for line in text.partition("Job stats:")[2].partition("\n\n")[0].splitlines()[3:]
    )
    assert (counts["ingest"], counts["curate"]) == ("1", "1")


def test_real_etm_log_goes_through(place: Path, snakemake: Run, real_pcs: Path) -> None:
    raw = place / "data/raw/etm-slim"
    raw.mkdir()
    shutil.copy(real_pcs / "ETM_slim_mapper.txt", raw)
    path = place / "config/campaigns/etm-slim.yaml"
    text = path.read_text(encoding="utf-8")
    quick = text.replace("settings:\n", "settings:\n  fit: {bootstrap: 20, searches: 2}\n")
    path.write_text(quick, encoding="utf-8")
    done = snakemake("--config", "campaign=etm-slim")
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "FILM NOT JUDGED" in said
    assert "points  20482 accepted of 20500" in said
    assert (place / "results/etm-slim/figures/curves.png").stat().st_size > 10_000
