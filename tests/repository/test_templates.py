"""Templates for scheduled runs, containers and conda: what they name must exist."""

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

NIGHTLY = ROOT / "docs/nightly"
CONTAINERS = ROOT / "docs/containers"
TEMPLATES = sorted(path for path in NIGHTLY.iterdir() if path.is_file())
OILFILM = "/srv/oilfilm/venv/bin/oilfilm"


def recipe_steps(path: Path) -> list[str]:
    """The commands that build an image: RUN of a Dockerfile, %post of an Apptainer definition."""
    text = path.read_text(encoding="utf-8")
    if path.name == "Dockerfile":
        joined = text.replace("\\\n", " ")
        runs = re.findall(r"(?m)^RUN (.+)$", joined)
        return [step.strip() for run in runs for step in run.split("&&")]
    (post,) = re.findall(r"(?ms)^%post\n(.*?)^%", text)
    return [line.strip() for line in post.splitlines() if line.strip()]


def copied() -> list[str]:
    """What the image gets of a clone, by the list beside the Dockerfile."""
    lines = (CONTAINERS / "Dockerfile.dockerignore").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "*"
    return [line.removeprefix("!") for line in lines if line.startswith("!")]


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: path.name)
def test_every_template_calls_the_command_as_it_is(path: Path) -> None:
    text = path.read_text(encoding="utf-8").replace("$CAMPAIGN", "june")
    calls = re.findall(rf"{OILFILM} ([^\n]*?)(?: 2>.*)?$", text, re.MULTILINE)
    assert calls or path.suffix == ".timer"
    for call in calls:
        options = parser().parse_args(shlex.split(call))
        assert (options.module, options.campaign) == ("nightly", "june")


@pytest.mark.parametrize(
    ("name", "schema"),
    [
        ("gitlab-ci.yml", "vendor.gitlab-ci"),
        ("github-self-hosted.yml", "vendor.github-workflows"),
    ],
)
def test_template_of_a_service_follows_its_schema(name: str, schema: str) -> None:
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema]
    done = subprocess.run(
        [*command, str(NIGHTLY / name)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_self_hosted_runner_keeps_results_and_uses_the_pinned_actions() -> None:
    text = (NIGHTLY / "github-self-hosted.yml").read_text(encoding="utf-8")
    ours = (ROOT / ".github/workflows/nightly.yml").read_text(encoding="utf-8")
    assert yaml.safe_load(text)["permissions"] == {"contents": "read"}
    actions = re.findall(r"uses: (.+)", text)
    assert actions
    assert all(f"uses: {action}" in ours for action in actions)
    assert "clean: false" in text


@pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="systemd is not installed here")
def test_systemd_takes_service_and_timer(tmp_path: Path) -> None:
    for name in ("oilfilm-nightly.service", "oilfilm-nightly.timer"):
        # it asks whether the program is there
        text = (NIGHTLY / name).read_text(encoding="utf-8").replace(OILFILM, sys.executable)
        (tmp_path / name).write_text(text, encoding="utf-8")
    units = [str(tmp_path / f"oilfilm-nightly.{kind}") for kind in ("timer", "service")]
    done = subprocess.run(
        ["systemd-analyze", "verify", *units], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_service_without_a_writable_home_has_a_folder_for_the_cache_of_snakemake() -> None:
    """Without one every run ends in `os.makedirs`; systemd makes CacheDirectory in /var/cache."""
    service = (NIGHTLY / "oilfilm-nightly.service").read_text(encoding="utf-8")
    settings = dict(re.findall(r"(?m)^(\w+)=(.+)$", service))
    assert settings["ProtectSystem"] == "strict"
    assert settings["Environment"] == f"XDG_CACHE_HOME=/var/cache/{settings['CacheDirectory']}"


def test_timer_starts_the_service_of_its_name() -> None:
    """Without `Unit=` a timer starts the service of the same name."""
    timer = (NIGHTLY / "oilfilm-nightly.timer").read_text(encoding="utf-8")
    assert (NIGHTLY / "oilfilm-nightly.service").is_file()
    assert "Unit=" not in timer.replace("[Unit]", "")
    assert "WantedBy=timers.target" in timer


def test_cron_line_has_five_fields_and_a_command() -> None:
    lines = (NIGHTLY / "crontab").read_text(encoding="utf-8").splitlines()
    (line,) = (line for line in lines if line[:1].isdigit())
    assert re.fullmatch(r"[0-5]?\d 2 \* \* \* cd \S+ && .*", line)
    # cron reads a bare percent sign as the end of the command
    assert "%" not in line


def test_both_recipes_take_the_same_steps_and_files() -> None:
    docker, apptainer = (
        recipe_steps(CONTAINERS / name) for name in ("Dockerfile", "apptainer.def")
    )
    # an Apptainer image has no user of its own: it runs as who starts it
    own = ("useradd", "install ", "cd ")
    steps = [[step for step in each if not step.startswith(own)] for each in (docker, apptainer)]
    assert steps[0] == steps[1]
    assert steps[0][-1] == "make setup"
    text = (CONTAINERS / "apptainer.def").read_text(encoding="utf-8")
    files = re.findall(r"(?m)^    (\S+) /oilfilm/(\S+)$", text)
    assert [source for source, _ in files] == [target for _, target in files] == copied()
    assert all((ROOT / name).exists() for name in copied())


def test_recipes_have_the_rules_that_matter() -> None:
    """Exact base, exact packages, no root, locked Python packages."""
    docker = (CONTAINERS / "Dockerfile").read_text(encoding="utf-8")
    apptainer = (CONTAINERS / "apptainer.def").read_text(encoding="utf-8")
    (base,) = re.findall(r"(?m)^FROM (\S+)$", docker)
    assert re.fullmatch(r"python:3\.\d+\.\d+-slim-[a-z]+", base)
    assert f"From: {base}\n" in apptainer
    targets = (ROOT / "Makefile").read_text(encoding="utf-8")
    for step in recipe_steps(CONTAINERS / "Dockerfile"):
        if step.startswith("apt-get install"):
            assert "--no-install-recommends" in step
            packages = [word for word in step.split()[2:] if not word.startswith("-")]
            assert all("=" in package for package in packages)
        if step.startswith("make "):
            assert re.search(rf"(?m)^{step.split()[1]}:", targets)
        assert "pip" not in step  # `make` installs by the lock
    assert "rm -rf /var/lib/apt/lists/*" in docker
    assert not re.search(r"(?m)^ADD ", docker)
    user, last = docker.index("\nUSER 1000\n"), docker.index("RUN make setup")
    assert user < last
    assert "USER" not in docker[last:]


def test_conda_environment_takes_the_lock_and_a_python_that_is_allowed() -> None:
    path = CONTAINERS / "environment.yml"
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    *conda, by_pip = content["dependencies"]
    (requirement,) = by_pip["pip"]
    lock = path.parent / requirement.removeprefix("--requirement=")
    assert lock.resolve() == ROOT / "requirements.lock"
    (python,) = (each for each in conda if each.startswith("python="))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert python.removeprefix("python=") in SpecifierSet(project["requires-python"])
    base = re.search(r"python:(3\.\d+)", (CONTAINERS / "Dockerfile").read_text(encoding="utf-8"))
    assert base is not None
    assert python == f"python={base[1]}"


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
