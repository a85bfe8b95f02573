"""The recipe of the container: its steps work on the files that the image gets."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from campaigns import ROOT
from command_line import succeeded

CONTAINERS = ROOT / "docs/containers"


def copied() -> list[str]:
    """What the image gets of a clone, by the list beside the Dockerfile."""
    lines = (CONTAINERS / "Dockerfile.dockerignore").read_text(encoding="utf-8").splitlines()
    return [line.removeprefix("!") for line in lines if line.startswith("!")]


@pytest.mark.parametrize("recipe", ["Dockerfile", "apptainer.def"])
def test_base_image_is_named_by_its_digest(recipe: str) -> None:
    text = (CONTAINERS / recipe).read_text(encoding="utf-8")
    bases = re.findall(r"(?m)^(?:FROM|From:) \S+?(@sha256:[0-9a-f]{64})?$", text)
    assert bases
    assert all(bases)


@pytest.mark.nightly
def test_steps_of_the_recipes_work_in_an_empty_folder(tmp_path: Path) -> None:
    """No container engine is needed: the same commands, on the files that the image gets."""
    for name in copied():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    text = (CONTAINERS / "Dockerfile").read_text(encoding="utf-8").replace("\\\n", " ")
    steps = [step for run in re.findall(r"(?m)^RUN (.+)$", text) for step in run.split("&&")]
    for step in (step for step in map(str.strip, steps) if step.startswith("make ")):
        succeeded(shlex.split(step), cwd=tmp_path)
    assert succeeded([tmp_path / ".venv/bin/oilfilm", "--version"]).startswith("oilfilm ")
