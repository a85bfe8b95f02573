"""The library without any package beside it: a laboratory's campaign, and the command."""

import shutil
from pathlib import Path

import pytest

from campaigns import SMALL_MATRIX, lay_out_measured
from command_line import succeeded
from oilfilm.base import studies
from oilfilm.tables.campaign_tables import CampaignTables
from reproduce import command, succeed

pytestmark = pytest.mark.workflow


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A laboratory's campaign `own` in a clone from which every study has been deleted."""
    lay_out_measured(tmp_path, "own", ["4102"], SMALL_MATRIX)
    for name in studies.available():
        shutil.rmtree(tmp_path / "workflow" / name)
    return tmp_path


@pytest.mark.nightly
def test_campaign_of_a_laboratory_runs_to_its_report(project: Path) -> None:
    succeed(project, "--config", "campaign=own")
    results = CampaignTables.from_folder(project / "results/own")
    # every condition of the matrix was tested once, and nothing but the law's own tables is there
    assert len(results.runs) == 12
    assert results.configured_fits.fit_quality["certified"].all()
    assert (project / "results/own/report.html").is_file()
    assert not (project / "results/own/tables/claims.parquet").exists()


def test_command_offers_no_constants_from_print(project: Path) -> None:
    (python, *_), environment = command(project)
    program = "from oilfilm.cli.parser import COMMANDS; print(*[of.__name__ for of in COMMANDS])"
    offered = succeeded([python, "-c", program], cwd=project, env=environment).split()
    assert "predict" in offered
    assert "export" not in offered
