"""The wheel in a folder of its own: the library, the command and the workflow as a module."""

import json
import os
import shutil
import sys
import zipfile
from pathlib import Path

import pandas as pd
import pytest
import yaml

from campaigns import ROOT, read_campaign
from command_line import succeeded
from reproduce import coverage_environment

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the content of the wheel, as an installation puts it."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    succeeded(build, cwd=ROOT)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run(installed: Path, folder: Path, *arguments: str) -> str:
    """Run a module of Python with the installed library in a folder; what it prints."""
    # coverage counts the library of the clone, not its copy
    kept = {name: value for name, value in os.environ.items() if name not in coverage_environment()}
    environment = {**kept, "PYTHONPATH": str(installed)}
    return succeeded([sys.executable, "-m", *arguments], cwd=folder, env=environment)


# A workflow with a configuration and rules of its own, before and after those of oilfilm.
HOST = """from oilfilm.base.home import HOME

configfile: "config/host.yaml"
PLACE = config["place"]

rule overview:
    input: PLACE + "results/own/tables/runs.parquet", "shift-book.txt"
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
    prefix: PLACE

use rule * from oilfilm as oilfilm_*

rule report_of_all:
    input: rules.overview.output
    output: "all.txt"
    shell: "cat {input[0]} > {output}"

onstart: oilfilm.onstart()
"""


@pytest.mark.nightly
def test_workflow_of_a_host(installed: Path, released_project: Path, tmp_path: Path) -> None:
    """`config` is a section of the host's; all results are below a prefix.

    One log of the measured campaign comes by a rule of the host.
    """
    folder, incoming = tmp_path / "config/rigs-of-ours", tmp_path / "incoming"
    (folder / "campaigns").mkdir(parents=True)
    campaign = read_campaign(released_project, "small")
    del campaign["twin"]
    (folder / "campaigns/own.yaml").write_text(yaml.safe_dump(campaign), encoding="utf-8")
    raw = shutil.copytree(released_project / "data/raw/small", tmp_path / "data/raw/own")
    incoming.mkdir()
    shutil.copy(min(raw.glob("*.csv")), incoming)
    section = {"folder": "config/rigs-of-ours", "campaign": "own", "split": {"runs": 12}}
    host = {"laboratory": "Lab 3", "place": "rig/", "tribology": section}
    (tmp_path / "config/host.yaml").write_text(yaml.safe_dump(host), encoding="utf-8")
    (tmp_path / "Snakefile").write_text(HOST, encoding="utf-8")
    # without a target: the first rule of the host is made, and with it what it needs of oilfilm
    run(installed, tmp_path, "snakemake", "--cores", "2")
    assert "runs.parquet" in (tmp_path / "overview.txt").read_text(encoding="utf-8")
    here, there = (
        pd.read_parquet(results / "tables/points.parquet")
        for results in (tmp_path / "rig/results/own", released_project / "results/small")
    )
    pd.testing.assert_frame_equal(here, there)
    assert not (tmp_path / "results").exists()
    assert (tmp_path / "rig/data/first_seen/own.sha256").is_file()
    assert not (tmp_path / "data/first_seen").exists()


def test_commands_need_no_clone(installed: Path, released_project: Path, tmp_path: Path) -> None:
    results, raw = released_project / "results", released_project / "data/raw/small"
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("campaign: demo\n", encoding="utf-8")
    at = ("--stress", "1.2GPa", "--speed", "30m/s", "--temperature", "70degC", "--slip", "0.05")
    commands = [
        ["check", str(next(raw.glob("4102_P1.25*.csv"))), "--campaign", "demo"],
        ["verify", str((results / "releases/small/latest").resolve())],
        ["predict", "--results", str(results / "small"), "--oil", "4102", *at],
    ]
    program = f"from oilfilm.cli import main\nfor words in {commands}: main(words)\n"
    (tmp_path / "commands.py").write_text(program, encoding="utf-8")
    text = run(installed, tmp_path, "commands")
    assert all(word in text for word in ("ACCEPTED", "as released", "mu = 0.01"))


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["first-curve", "bearing-torque", "own-logs"])
def test_a_notebook_runs_with_the_installed_library(
    installed: Path, tmp_path: Path, name: str
) -> None:
    cells = json.loads((ROOT / f"docs/notebooks/{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    program = "import matplotlib; matplotlib.use('agg')\n" + "\n".join(sources)
    (tmp_path / "notebook.py").write_text(program, encoding="utf-8")
    # a notebook without an error ends with exit code 0
    run(installed, tmp_path, "notebook")
