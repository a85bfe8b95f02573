"""Templates for scheduled runs, containers and conda: they name what exists, their steps work."""

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.specifiers import SpecifierSet

from campaigns import ROOT
from oilfilm.cli.parser import parser

CONTAINERS = ROOT / "docs/containers"
NIGHTLY = [path for path in (ROOT / "docs/nightly").iterdir() if path.suffix != ".timer"]


def recipe_steps(path: Path) -> list[str]:
    """The commands that build an image: RUN of a Dockerfile, %post of an Apptainer definition."""
    text = path.read_text(encoding="utf-8")
    if path.name == "Dockerfile":
        runs = re.findall(r"(?m)^RUN (.+)$", text.replace("\\\n", " "))
        return [step.strip() for run in runs for step in run.split("&&")]
    (post,) = re.findall(r"(?ms)^%post\n(.*?)^%", text)
    return [line.strip() for line in post.splitlines() if line.strip()]


def copied() -> list[str]:
    """What the image gets of a clone, by the list beside the Dockerfile."""
    lines = (CONTAINERS / "Dockerfile.dockerignore").read_text(encoding="utf-8").splitlines()
    return [line.removeprefix("!") for line in lines if line.startswith("!")]


@pytest.mark.parametrize("path", sorted(NIGHTLY), ids=lambda path: path.name)
def test_every_scheduled_run_makes_a_release_and_compares_it_with_the_pin(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    (gate,) = re.findall(r"\boilfilm (diff .* --gate)$", text, re.MULTILINE)
    options = parser().parse_args(shlex.split(gate))
    assert options.before == Path("data/reference/pins/june")
    assert options.after == Path("results/releases/june/latest")
    assert text.index("snakemake release --config campaign=june") < text.index(gate)
    if path.suffix == ".yml":
        schema = "github-workflows" if "github" in path.name else "gitlab-ci"
        check = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}"]
        done = subprocess.run([*check, str(path)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


def test_both_recipes_take_the_same_steps_and_files() -> None:
    docker, apptainer = (
        recipe_steps(CONTAINERS / name) for name in ("Dockerfile", "apptainer.def")
    )
    bases = [
        re.findall(
            r"(?mi)^from:? (\S+@sha256:[0-9a-f]{64})$", (CONTAINERS / name).read_text("utf-8")
        )
        for name in ("Dockerfile", "apptainer.def")
    ]
    assert [digest.partition("@")[2] for (digest,) in bases] == [bases[0][0].partition("@")[2]] * 2
    # an Apptainer image has no user of its own: it runs as who starts it
    own = ("useradd", "install ", "cd ")
    steps = [[step for step in each if not step.startswith(own)] for each in (docker, apptainer)]
    assert steps[0] == steps[1]
    text = (CONTAINERS / "apptainer.def").read_text(encoding="utf-8")
    files = re.findall(r"(?m)^    (\S+) /oilfilm/(\S+)$", text)
    assert [source for source, _ in files] == [target for _, target in files] == copied()
    assert all((ROOT / name).exists() for name in copied())


def test_conda_environment_takes_the_lock_and_a_python_that_is_allowed() -> None:
    path = CONTAINERS / "environment.yml"
    *conda, by_pip = yaml.safe_load(path.read_text(encoding="utf-8"))["dependencies"]
    (requirement,) = by_pip["pip"]
    assert (path.parent / requirement.removeprefix("--requirement=")).is_file()
    (python,) = (each for each in conda if each.startswith("python="))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert python.removeprefix("python=") in SpecifierSet(project["requires-python"])


@pytest.mark.nightly
def test_steps_of_the_recipes_work_in_an_empty_folder(tmp_path: Path) -> None:
    """No container engine is needed: the same commands, on the files that the image gets."""
    for name in copied():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    steps = recipe_steps(CONTAINERS / "Dockerfile")
    for step in (step for step in steps if step.startswith("make ")):
        done = subprocess.run(
            shlex.split(step), cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    oilfilm = tmp_path / ".venv/bin/oilfilm"
    done = subprocess.run([oilfilm, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("oilfilm ")
