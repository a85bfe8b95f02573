"""One small release, which tests leave as they found it."""

from pathlib import Path

import pytest

from oilfilm.settings.resolved import Settings
from releases import RAW, finished_run, project, released, runs_of


@pytest.fixture(scope="session")
def release(config: Settings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A release of two logs."""
    folder = tmp_path_factory.mktemp("release")
    return released(finished_run(project(folder / "p"), config, RAW, {"runs": runs_of(RAW)}))
