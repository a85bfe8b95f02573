"""Every law that config allows goes through the whole workflow, to report and exports."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from campaigns import QUICK, ROOT, SMALL_MATRIX, lay_out, read_campaign, write_campaign
from oilfilm.exports.campaign import FORMS
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from reproduce import command, succeed

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


def campaign_with(law: str) -> dict[str, Any]:
    """The campaign `thermal`, much reduced; campaigns of two laws differ in `fit.law` alone."""
    campaign = read_campaign(ROOT, "thermal")
    campaign["oils"] = list(OILS)
    campaign["figures"] = ["eqs11-13", "fig03", "fig04", "law-errors", "fig06", "fig07"]
    campaign["figures"] += ["residuals", "identifiability"]
    campaign["matrix"] = SMALL_MATRIX
    campaign["twin"] |= {"slip_steps": 9, "sampling_rate_hz": 20}
    campaign["torque"]["matrix"] = {
        "axial_load_n": [20000],
        "inner_speed_rpm": [6000, 12000],
        "oil_temperature_c": [70],
    }
    campaign["settings"] = {
        "fit": {**QUICK["fit"], "law": law},
        "compare": {"laws": ["deng2026", "wang-deng-load"]},
        "bearing": {
            "uncertainty": {"draws": 40},
            "cage_slip": {"pitch_speed_mm_rpm": [1e6, 4e6], "axial_load_n": [1000, 20000]},
            "size_effect": {"ball_size_factors": [0.5, 1.0], "groove_curvatures": [0.51, 0.53]},
        },
        "plan": {
            "tests": 1,
            "levels": {
                "max_hertz_pressure_gpa": [1.0, 1.5],
                "entrainment_speed_m_s": [20, 45],
                "inlet_temperature_c": [50, 120],
            },
        },
        "split": {"runs": 1000},
    }
    return campaign


def run_with(project: Path, law: str) -> None:
    """Run the campaign `laws` and check that every export of every oil is there, or says why not.

    Logs, samples and points of an earlier law are kept.
    """
    write_campaign(project, "laws", campaign_with(law))
    succeed(project, "--config", "campaign=laws")
    results = project / "results/laws"
    check_results(results, law, OILS)
    assert (results / "figures/fig06.png").stat().st_size > 1000


def check_results(results: Path, law: str, oils: tuple[str, ...]) -> None:
    """Fits, exports and report are those of the law."""
    quality = CampaignTables.in_folder(results).configured.fit_quality
    assert set(quality["law"]) == {law}
    for oil in oils:
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


@pytest.mark.nightly
@pytest.mark.parametrize("law", LAWS)
def test_every_law_goes_through_the_whole_workflow(project: Path, law: str) -> None:
    run_with(project, law)


# It differs from the default law in all that laws differ in: of load, which must vary; another
# number of coefficients, one with exponents of its own; a part with a name; not in ADORE's form.
SEVENTH = '''"""A straight start and a level, as a hyperbola: a law that only this test knows."""

from oilfilm.traction.law import Coefficient, Law

CONDITIONS = ("load_n", "entrainment_speed_m_s", "inlet_temperature_c")
HYPERBOLA = Law(
    name="hyperbola",
    source="a test",
    equation="A*abs(K - 1)*h",
    parts=(("h", "S/(S + C)"),),
    coefficients=(
        Coefficient("A", +1, 1e-4, 1.0),
        Coefficient("C", +1, 1e-4, 1.0),
        Coefficient("K", +1, 1e-3, 1e3, exponents=(-1.0, 0.0, 0.0)),
    ),
    conditions=CONDITIONS,
    groups=CONDITIONS,
    reference=(100.0, 20.0, 20.0),
    must_vary=("load_n",),
)
'''


def add_seventh_law(project: Path) -> None:
    laws = project / "workflow/oilfilm/traction/laws"
    (laws / "hyperbola.py").write_text(SEVENTH, encoding="utf-8")
    with (laws / "__init__.py").open("a", encoding="utf-8") as registry:
        registry.write("from oilfilm.traction.laws.hyperbola import HYPERBOLA as HYPERBOLA\n")


def check_seventh_law(results: Path, oil: str) -> None:
    header = results / f"exports/{oil}/traction_{oil}.h"
    lines = [line.strip() for line in header.read_text(encoding="utf-8").splitlines()]
    assert "const double h = S / (S + C);" in lines
    assert "const double mu = A * fabs(K - 1.0) * h;" in lines


@pytest.mark.nightly
def test_a_seventh_law_goes_through_the_whole_workflow(project: Path) -> None:
    add_seventh_law(project)
    run_with(project, "hyperbola")
    check_seventh_law(project / "results/laws", "own")


def test_a_seventh_law_is_a_file_and_a_line(released_project: Path, tmp_path: Path) -> None:
    """From the points of a finished run: its fit, exports, figures and report, in one process."""
    project = tmp_path / "project"
    shutil.copytree(released_project, project, symlinks=True)
    add_seventh_law(project)
    campaign = read_campaign(project, "small")
    campaign["settings"]["fit"] |= {"law": "hyperbola"}
    write_campaign(project, "small", campaign)
    jobs = "import sys; sys.path.insert(0, 'workflow'); from stand_in import main\n" + "\n".join(
        f"main({[*job.split(), 'campaign=small']})"
        for job in ("fit oil=4102 law=hyperbola", "fits", "exports", "law_figures", "report")
    )
    (python, *_), environment = command(project)
    done = subprocess.run(
        [python, "-c", jobs],
        cwd=project,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    results = project / "results/small"
    check_results(results, "hyperbola", ("4102",))
    check_seventh_law(results, "4102")
