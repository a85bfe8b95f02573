"""Steps in an image: what the directive `container` of the rules says."""

import os
import sys
from pathlib import Path

import pytest

from campaigns import ROOT, lay_out_small
from reproduce import Surroundings, succeed

pytestmark = [pytest.mark.workflow, pytest.mark.nightly]

RUNS = "results/small/parts/points/0/runs.parquet"
SMALL = ("--config", "campaign=small")
# It writes down its image, and carries the command out on this machine.
APPTAINER = """#!/bin/sh
if [ "$1" = --version ]; then echo apptainer version 1.4.0; exit; fi
until [ "$1" = sh ] || [ "$1" = bash ]; do image=$1; shift; done
echo "$image" >> images.txt
exec "$@"
"""


@pytest.mark.parametrize("image", ["oilfilm.sif", "images/other.sif"])
def test_each_step_runs_in_the_image_of_the_settings(tmp_path: Path, image: str) -> None:
    """There is no engine: a program in its place, and an empty file in place of the image."""
    lay_out_small(tmp_path)
    (tmp_path / image).parent.mkdir(exist_ok=True)
    (tmp_path / image).touch()
    engine = tmp_path / "bin/apptainer"
    engine.parent.mkdir()
    engine.write_text(APPTAINER, encoding="utf-8")
    engine.chmod(0o755)
    places = [str(engine.parent), str(Path(sys.executable).parent), os.environ["PATH"]]
    around = Surroundings(environment={"PATH": os.pathsep.join(places)})
    chosen = (*SMALL, f"container={image}")
    steps = succeed(tmp_path, "--sdm", "apptainer", *chosen, "--", RUNS, around=around)
    used = (tmp_path / "images.txt").read_text(encoding="utf-8").split()
    # the simulated logs, and their points
    assert used == [image, image], steps


def test_recipe_builds_the_image_that_the_rules_name() -> None:
    recipe = (ROOT / "docs/containers/apptainer.def").read_text(encoding="utf-8")
    named = "container: oilfilm.sif"
    assert named in (ROOT / "config/config.yaml").read_text(encoding="utf-8")
    assert recipe.startswith("# apptainer build oilfilm.sif docs/containers/apptainer.def")


HOST = """from oilfilm.base.home import HOME

module oilfilm:
    snakefile: str(HOME / "workflow/Snakefile")
    config: {"campaign": "small"}

use rule * from oilfilm as oilfilm_*
"""


def test_lint_finds_nothing_where_the_workflow_is_a_module(tmp_path: Path) -> None:
    lay_out_small(tmp_path)
    (tmp_path / "Snakefile").write_text(HOST, encoding="utf-8")
    assert "good condition" in succeed(tmp_path, "--lint")
