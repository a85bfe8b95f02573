"""The wheel in a folder of its own: the library, the command and the workflow as a module."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pandas as pd
import pytest
import yaml

from campaigns import ROOT, lay_out, read_campaign
from foreign_logs import GERMAN, bench_and_runs, write_logs
from reproduce import measured

pytestmark = pytest.mark.workflow

SNAKEFILE = """from oilfilm.home import HOME

module oilfilm:
    snakefile: str(HOME / "workflow/Snakefile")
    config: config

use rule * from oilfilm

onstart: oilfilm.onstart()
onsuccess: oilfilm.onsuccess()
onerror: oilfilm.onerror()
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the content of the wheel, as an installation puts it."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run(installed: Path, folder: Path, *arguments: str) -> str:
    """Run a module of Python with the installed library in a folder; what it prints."""
    # coverage counts the library of the clone, not its copy
    kept = {name: value for name, value in os.environ.items() if name not in measured()}
    environment = {**kept, "PYTHONPATH": str(installed)}
    done = subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


@pytest.mark.nightly
def test_project_folder_needs_only_what_differs(
    installed: Path, released_project: Path, tmp_path: Path
) -> None:
    """The workflow as a module of another folder makes the bytes that a clone makes."""
    campaigns = tmp_path / "config/campaigns"
    campaigns.mkdir(parents=True)
    (tmp_path / "Snakefile").write_text(SNAKEFILE, encoding="utf-8")
    (tmp_path / "config/config.yaml").write_text("campaign: small\n", encoding="utf-8")
    campaign = (released_project / "config/campaigns/small.yaml").read_bytes()
    (campaigns / "small.yaml").write_bytes(campaign)
    made = [
        f"results/small/{name}"
        for name in ("tables/coefficients.parquet", "tables/runs.parquet", "figures/curves.png")
    ]
    run(installed, tmp_path, "snakemake", "--cores", "2", *made)
    for name in made:
        assert (tmp_path / name).read_bytes() == (released_project / name).read_bytes(), name


# A workflow with a configuration and rules of its own, before and after those of oilfilm.
HOST = """from oilfilm.home import HOME

configfile: "config/host.yaml"
PLACE = config["place"]

rule overview:
    input: PLACE + "results/NAME/tables/runs.parquet", "shift-book.txt"
    output: "overview.txt"
    shell: "wc -c {input} > {output}"

rule shift_book:
    output: "shift-book.txt"
    shell: "echo {config[laboratory]} > {output}"

rule fetch:
    input: "incoming/{log}.csv"
    output: "data/raw/own/{log}.csv"
    shell: "cp {input} {output}"

module oilfilm:
    snakefile: str(HOME / "workflow/Snakefile")
    config: config["tribology"]
    PREFIX

use rule * from oilfilm ALIAS

rule report_of_all:
    input: rules.overview.output
    output: "all.txt"
    shell: "cat {input[0]} > {output}"

onstart: oilfilm.onstart()
"""


@pytest.mark.parametrize(("place", "name"), [("", "own"), ("rig/", "small")])
def test_workflow_with_rules_and_configuration_of_its_own_has_the_same_tables(
    installed: Path, released_project: Path, tmp_path: Path, place: str, name: str
) -> None:
    """`config` is a section of the host's; with a prefix all results are below it.

    One log of the measured campaign comes by a rule of the host.
    """
    folder, incoming = tmp_path / "config/rigs-of-ours", tmp_path / "incoming"
    (folder / "campaigns").mkdir(parents=True)
    campaign = read_campaign(released_project, "small")
    if name == "own":
        del campaign["twin"]
        raw = shutil.copytree(released_project / "data/raw/small", tmp_path / "data/raw/own")
        incoming.mkdir()
        first = min(raw.glob("*.csv"))
        shutil.copy(first, incoming)
    (folder / f"campaigns/{name}.yaml").write_text(yaml.safe_dump(campaign), encoding="utf-8")
    section = {"folder": "config/rigs-of-ours", "campaign": name}
    host = {"laboratory": "Lab 3", "place": place, "tribology": section}
    (tmp_path / "config/host.yaml").write_text(yaml.safe_dump(host), encoding="utf-8")
    prefix, alias = (f'prefix: "{place}"', "") if place else ("", "as oilfilm_*")
    text = HOST.replace("PREFIX", prefix).replace("ALIAS", alias).replace("NAME", name)
    (tmp_path / "Snakefile").write_text(text, encoding="utf-8")
    run(installed, tmp_path, "snakemake", "--cores", "2", "overview.txt")
    assert "runs.parquet" in (tmp_path / "overview.txt").read_text(encoding="utf-8")
    here, there = (
        pd.read_parquet(top / f"results/{of}/tables/points.parquet")
        for top, of in ((tmp_path / place, name), (released_project, "small"))
    )
    pd.testing.assert_frame_equal(here, there)
    if name == "small":  # also the provenance
        table = "results/small/tables/points.parquet"
        assert (tmp_path / place / table).read_bytes() == (released_project / table).read_bytes()
        assert not (tmp_path / "results").exists()


def test_commands_need_no_clone(installed: Path, released_project: Path, tmp_path: Path) -> None:
    results, raw = released_project / "results", released_project / "data/raw/small"
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("campaign: demo\n", encoding="utf-8")
    log = next(raw.glob("4102_P1.25*.csv"))
    check = ("oilfilm", "check", str(log), "--campaign", "demo")
    assert "ACCEPTED" in run(installed, tmp_path, *check)
    release = str((results / "releases/small/latest").resolve())
    assert "as released" in run(installed, tmp_path, "oilfilm", "verify", release)
    assert run(installed, tmp_path, "oilfilm", "diff", release, release)
    at = ("--stress", "1.2GPa", "--speed", "30m/s", "--temperature", "70degC", "--slip", "0.05")
    where = ("--results", str(results / "small"), "--oil", "4102")
    assert "mu = 0.01" in run(installed, tmp_path, "oilfilm", "predict", *where, *at)


METRES = GERMAN.with_units(ball="m/s", disc="m/s")
FILM = "film_unjudged: {accept: true, reason: thick by experience}"


def accept_film(project: Path, name: str) -> dict[str, object]:
    """Fill in the one line of the campaign that `oilfilm init` leaves empty; the campaign."""
    path = project / f"config/campaigns/{name}.yaml"
    lines = path.read_text(encoding="utf-8").splitlines()
    filled = [FILM if line.startswith("film_unjudged:") else line for line in lines]
    path.write_text("\n".join([*filled, ""]), encoding="utf-8")
    return dict(yaml.safe_load(path.read_text(encoding="utf-8")))


def runs_of(project: Path, name: str) -> pd.DataFrame:
    return pd.read_parquet(project / f"results/{name}/tables/runs.parquet")


@pytest.mark.nightly
def test_projects_run_from_their_folders_with_one_installation(
    installed: Path, tmp_path: Path
) -> None:
    """`init`, one line filled in, `run`: each folder has the runs of its own logs alone."""
    for name, oil in (("juni", "Öl B-12"), ("juli", "Öl C-7")):
        bench, runs = bench_and_runs(oil)
        logs = write_logs(tmp_path / f"logs-{name}", bench, runs, METRES)
        run(installed, tmp_path, "oilfilm", "init", name, *map(str, logs))
        accept_film(tmp_path / name, name)
        target = f"results/{name}/tables/runs.parquet"
        run(installed, tmp_path, "oilfilm", "run", name, "--", target)
    for name, oil in (("juni", "oel-b-12"), ("juli", "oel-c-7")):
        found = runs_of(tmp_path / name, name)
        assert found["verdict"].tolist() == ["accepted"] * 3
        assert set(found["oil"]) == {oil}
        assert [path.name for path in (tmp_path / name / "results").iterdir()] == [name]


# What `snakedeploy deploy-workflow` (0.17) writes into workflow/Snakefile, with the path of a
# folder where it writes github("owner/name", path="workflow/Snakefile", tag="...").
DEPLOYED = """from snakemake.utils import min_version


min_version("6.10.0")


configfile: "config/config.yaml"


# declare {source} as a module
module oilfilm:
    snakefile:
        "{source}/workflow/Snakefile"
    config:
        config


# use all rules from {source}
use rule * from oilfilm


# what docs/how-to/running.md adds to it
onstart: oilfilm.onstart()
onsuccess: oilfilm.onsuccess()
onerror: oilfilm.onerror()
"""


@pytest.mark.nightly
def test_workflow_that_snakedeploy_deploys(installed: Path, tmp_path: Path) -> None:
    """The whole config.yaml comes as `config`: "4050" stays text, and a campaign wins over it."""
    source, deployed = tmp_path / "source", tmp_path / "deployed"
    lay_out(source)
    for name in ("config", "profiles"):
        shutil.copytree(source / name, deployed / name)
    (deployed / "workflow").mkdir()
    text = DEPLOYED.format(source=source.as_posix())
    (deployed / "workflow/Snakefile").write_text(text, encoding="utf-8")
    bench, runs = bench_and_runs("4050")
    logs = write_logs(tmp_path / "logs", bench, runs, METRES)
    # the settings of these logs, in a campaign that is called as the oil
    run(installed, tmp_path, "oilfilm", "init", "made", *map(str, logs), "--campaign", "4050")
    campaign = accept_film(tmp_path / "made", "4050")
    campaign["settings"] = {"gates": {"temperature_tolerance_c": 0.001}}
    shutil.copytree(tmp_path / "made/config", deployed / "config", dirs_exist_ok=True)
    path = deployed / "config/campaigns/4050.yaml"
    path.write_text(yaml.safe_dump(campaign, allow_unicode=True), encoding="utf-8")
    shutil.copytree(tmp_path / "made/data", deployed / "data")
    # as a user who edits the deployed config.yaml
    whole = (ROOT / "config/config.yaml").read_text(encoding="utf-8")
    named = whole.replace("campaign: demo ", 'campaign: "4050" ', 1)
    (deployed / "config/config.yaml").write_text(named, encoding="utf-8")
    run(installed, deployed, "snakemake", "results/4050/tables/runs.parquet")
    found = runs_of(deployed, "4050")
    assert set(found["campaign"]) == set(found["oil"]) == {"4050"}
    # a tolerance of a thousandth of a degree refuses every log
    assert set(found["verdict"]) == {"refused"}
