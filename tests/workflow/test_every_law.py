"""Every law that config allows goes through the whole workflow, to report and exports."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from campaigns import ROOT, lay_out, write_campaign
from oilfilm import tables
from oilfilm.outputs.exports.campaign import FORMS
from oilfilm.traction import LAWS

pytestmark = pytest.mark.workflow

OILS = ("4102", "own")


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the project with two oils: one has printed constants, the other has none."""
    project = tmp_path_factory.mktemp("laws")
    lay_out(project)
    template = (ROOT / "config/oils/template.yaml").read_text(encoding="utf-8")
    (project / "config/oils/own.yaml").write_text(template.replace("my-oil", "own"))
    return project


def campaign_with(law: str) -> dict[str, object]:
    """The campaign `thermal`, much reduced; campaigns of two laws differ in `fit.law` alone."""
    path = ROOT / "config/campaigns/thermal.yaml"
    campaign = yaml.safe_load(path.read_text(encoding="utf-8"))
    campaign["oils"] = list(OILS)
    campaign["figures"] = ["eqs11-13", "fig03", "fig04", "fig06", "fig07", "residuals"]
    campaign["figures"] += ["identifiability", "extrapolation", "claims", "selection"]
    campaign["matrix"] = {
        "max_hertz_pressure_gpa": [1.0, 1.25, 1.5],
        "entrainment_speed_m_s": [25, 40],
        "inlet_temperature_c": [50, 120],
    }
    campaign["twin"] |= {"slip_steps": 9, "sampling_rate_hz": 20}
    campaign["torque"]["matrix"] = {
        "axial_load_n": [20000],
        "inner_speed_rpm": [6000, 12000],
        "oil_temperature_c": [70],
    }
    campaign["settings"] = {
        "fit": {"law": law, "bootstrap": 20, "searches": 2, "allow_uncertified": True},
        "compare": {"laws": ["deng2026", "wang-deng-load"], "bootstrap": 5},
        "figures": {"extrapolation": {"oil": "own"}},
        "shards": 1,
    }
    return campaign


def run(project: Path, law: str) -> str:
    """The campaign `laws` with this law; logs, samples and points of an earlier law are kept."""
    write_campaign(project, "laws", campaign_with(law))
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", "--config", "campaign=laws"],
        cwd=project,
        env={**os.environ, "PYTHONPATH": str(project / "workflow")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def refuse_gaps(project: Path, law: str) -> None:
    """Every export of every oil is there; what does not apply says why."""
    results = project / "results/laws"
    quality = tables.read("fit_quality", results / "tables/fit_quality.parquet")
    assert set(quality["law"]) == {law}
    for oil in OILS:
        content = json.loads((results / f"exports/{oil}/traction_{oil}.json").read_text())
        assert content["law"]["name"] == law
        for name in content["files"].values():
            assert (results / f"exports/{oil}" / name).stat().st_size > 100
        assert {*content["files"], *content["not_written"]} == {"CSV", *FORMS}
        # the form of the ADORE code is that of some laws only
        assert set(content["not_written"]) <= {"ADORE"}
    report = (results / "report.html").read_text(encoding="utf-8")
    assert "SIMULATED data" in report
    assert law in report
    assert (results / "figures/fig06.png").stat().st_size > 1000


# `make test` runs the two laws that differ most from the default one; `make nightly` runs all.
OFTEN = ("eyring", "wang-deng-critical-load")


@pytest.mark.parametrize(
    "law",
    [pytest.param(law, marks=[pytest.mark.nightly] if law not in OFTEN else []) for law in LAWS],
)
def test_every_law_goes_through_the_whole_workflow(project: Path, law: str) -> None:
    told = run(project, law)
    assert "Traceback" not in told
    refuse_gaps(project, law)
    coefficients = tables.read("coefficients", project / "results/laws/tables/coefficients.parquet")
    printed = coefficients[coefficients["printed_value"].notna()]
    # the paper prints constants of its own law only
    assert set(printed["oil"]) == ({"4102"} if law == "deng2026" else set())


SEVENTH = '''"""A straight start and a level, as a hyperbola: a law that only this test knows."""

from oilfilm.traction.law import Coefficient, Law

HYPERBOLA = Law(
    name="hyperbola",
    source="a test",
    equation="A*S/(S + K)",
    coefficients=(Coefficient("A", +1, 1e-4, 1.0), Coefficient("K", +1, 1e-4, 1.0)),
)
'''


def test_a_seventh_law_is_a_file_and_a_line(project: Path) -> None:
    laws = project / "workflow/oilfilm/traction/laws"
    (laws / "hyperbola.py").write_text(SEVENTH, encoding="utf-8")
    with (laws / "__init__.py").open("a", encoding="utf-8") as registry:
        registry.write("from oilfilm.traction.laws.hyperbola import HYPERBOLA as HYPERBOLA\n")
    told = run(project, "hyperbola")
    assert "Traceback" not in told
    refuse_gaps(project, "hyperbola")
    header = project / "results/laws/exports/own/traction_own.h"
    assert "const double mu = A * S / (S + K);" in header.read_text(encoding="utf-8")
