"""Captions: every figure has one, and it says where its data are from."""

import subprocess
import sys

from campaigns import ROOT
from oilfilm.base.figure_catalogue import figures
from oilfilm.report.captions import data_origin
from oilfilm.settings.resolved import Settings


def test_origin_of_data_says_simulated_or_who_measured(config: Settings) -> None:
    simulated = config.with_changes({"campaign": {"data": "simulated", "simulated_by": "x"}})
    assert "SIMULATED data (x, campaign 'laboratory')" in data_origin(simulated.campaign)
    measured = config.with_changes({"campaign": {"name": "june", "credit": "ours"}})
    assert data_origin(measured.campaign) == "Measured data (ours), campaign 'june'"


def test_declarations_are_read_without_importing_what_draws() -> None:
    code = (
        "import sys; from oilfilm.base.figure_catalogue import figures; print(len(figures())); "
        "print({'matplotlib', 'pandas', 'numpy'} & set(sys.modules))"
    )
    path = {"PYTHONPATH": str(ROOT / "workflow")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=path, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == [str(len(figures())), "set()"]
