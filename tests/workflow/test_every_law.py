"""Every law that config allows, and one more, from points to report and exports."""

import json
import shutil
from pathlib import Path

import pytest

from campaigns import read_campaign, write_campaign
from command_line import succeeded
from extensions import EXTENSIONS, apply
from nights import nightly
from oilfilm.exports.campaign import EXPORT_FORMS
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAW_FILES, LAWS
from reproduce import command

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


def run_with(project: Path, law: str) -> None:
    """Fit, exports, figures and report of a finished campaign with another law, in one process."""
    campaign = read_campaign(project, "small")
    campaign["settings"]["fit"] |= {"law": law}
    write_campaign(project, "small", campaign)
    law_file = LAW_FILES[law].stem if law in LAW_FILES else law
    jobs = "import sys; sys.path.insert(0, 'workflow'); from stand_in import main\n" + "\n".join(
        f"main({[*job.split(), 'campaign=small']})"
        for job in (f"fit oil=4102 law_file={law_file}", "fits", "exports", "law_figures", "report")
    )
    (python, *_), environment = command(project)
    succeeded([python, "-c", jobs], cwd=project, env=environment)


@pytest.mark.parametrize("law", ["hyperbola", *map(nightly, LAWS)])
def test_law_goes_from_points_to_exports(released_project: Path, tmp_path: Path, law: str) -> None:
    """The added law differs from the default one in all that laws differ in.

    It is of load, which must vary; it has another number of coefficients, one with exponents of its
    own; it has a part with a name, and is not in ADORE's form.
    """
    project = shutil.copytree(released_project, tmp_path / "project", symlinks=True)
    apply(EXTENSIONS["A law"], project)
    run_with(project, law)
    results = project / "results/small"
    assert set(CampaignTables.from_folder(results).configured_fits.fit_quality["law"]) == {law}
    exports = results / "exports/4102"
    content = json.loads((exports / "traction_4102.json").read_text())
    assert content["law"]["name"] == law
    for name in content["files"].values():
        assert (exports / name).stat().st_size > 100
    assert {*content["files"], *content["not_written"]} == {"CSV", *EXPORT_FORMS}
    # the form of the ADORE code is that of some laws only
    assert set(content["not_written"]) <= {"ADORE"}
    report = (results / "report.html").read_text(encoding="utf-8")
    assert "SIMULATED data" in report
    assert law in report
    if law == "hyperbola":
        header = (exports / "traction_4102.h").read_text(encoding="utf-8")
        lines = [line.strip() for line in header.splitlines()]
        assert "const double h = B * S / (B * S + 1.0);" in lines
        assert "const double mu = A * fabs(K - 1.0) * h;" in lines
