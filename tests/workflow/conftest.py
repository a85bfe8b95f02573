"""One finished project for all tests of whole runs."""

import fcntl
from pathlib import Path

import pytest

from campaigns import lay_out_small
from reproduce import USUAL, Surroundings, measured, succeed


@pytest.fixture(scope="session")
def released_project(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The campaign `small`, run and released once for all workers; tests change copies of it.

    Its folder has a name that shells, Make and Snakemake may stumble over.
    """
    folder = tmp_path_factory.getbasetemp()
    if worker_id != "master":
        folder = folder.parent
    folder = folder / "Prüfstand; it's #1 %d" / "-x"
    folder.mkdir(parents=True, exist_ok=True)
    project, output = folder / "small", folder / "small.txt"
    with (folder / "small.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not output.exists():
            lay_out_small(project)
            around = Surroundings("2", {**USUAL.environment, **measured()})
            text = succeed(project, "release", "--config", "campaign=small", around=around)
            output.write_text(text)
    return project
