"""One finished project for all tests of whole runs."""

from pathlib import Path

import pytest

from campaigns import lay_out_small, made_once, simulator
from reproduce import USUAL, Surroundings, coverage_environment, succeed


@pytest.fixture(scope="session")
def released_project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The campaign `small`, run and released once for all workers; tests change copies of it.

    Its folder has a name that shells, Make and Snakemake may stumble over.
    """
    simulator()

    def released(folder: Path) -> Path:
        project = folder / "-x/small"
        project.mkdir(parents=True)
        lay_out_small(project)
        around = Surroundings("2", {**USUAL.environment, **coverage_environment()})
        text = succeed(project, "release", "--config", "campaign=small", around=around)
        project.with_suffix(".txt").write_text(text)
        return project

    return made_once("Prüfstand; it's #1 %d", released, tmp_path_factory)
