"""No mu without its mark: every place where mu can be asked, at points that nobody tested.

Beside it: what each tool computes from its export (`exports/test_exports.py` and
`test_workbook.py`), the shades of figures (`report/test_drawings.py`), the contacts of a torque
above the limit (`torque/test_bearing_torque.py`).
"""

import json
import runpy
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import oilfilm
from browsers import CHROMIUM, QUIET
from exported import describe_law
from known_laws import known_law
from oilfilm.api.arrays import ArrayFit
from oilfilm.cli import main
from oilfilm.exports.campaign import adore_rows
from oilfilm.fits.fitted import Prediction
from oilfilm.report.sections.build import answer_section
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

CONDITIONS = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")
NAMES = (*CONDITIONS, "slide_roll_ratio")
OPTIONS = ("--stress", "--speed", "--temperature", "--slip")
# Every pressure cold, the lowest one hot as well: hot and heavily loaded was never tested,
# though each by itself was. mu is six times that of the printed 4010: 0.16 at the heaviest, slowest
# and coldest condition, where no oil is known to carry more than 0.12.
TESTED = [
    (pressure, speed, temperature)
    for pressure in (1.0, 1.25, 1.5)
    for speed in (25.0, 40.0)
    for temperature in (25.0, 50.0, 80.0, 120.0)
    if pressure < 1.2 or temperature < 60
]
POINTS = {
    "tested": (1.2, 30.0, 50.0, 0.05),
    "outside": (1.2, 150.0, 50.0, 0.05),
    "far from every run": (1.5, 40.0, 120.0, 0.05),
    "over the limit": (1.5, 25.0, 25.0, 0.1),
}


@dataclass(frozen=True)
class SavedFit:
    """A fit that was saved twice, so that it can be compared, and what reads its output."""

    fit: ArrayFit
    folders: list[Path]
    capsys: pytest.CaptureFixture[str]

    def command(self, *words: str) -> str:
        assert main([*words]) == 0
        return self.capsys.readouterr().out

    def exported(self, file: str) -> Path:
        (exported_file,) = self.folders[0].glob(f"exports/*/{file}")
        return exported_file


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> tuple[ArrayFit, list[Path]]:
    slip = np.linspace(0.01, 0.3, 6)
    points = np.array(
        [(*condition, slip_of_point) for condition in TESTED for slip_of_point in slip]
    )
    mu = 6 * known_law("4010").predict_at(*points.T).traction_coefficient
    curve_of_point = np.repeat(np.arange(len(TESTED)), len(slip))
    factor_of_curve = 1 + 0.005 * np.random.default_rng(1).standard_normal(len(TESTED))
    table = pd.DataFrame(points, columns=list(NAMES))
    table = table.assign(
        traction_coefficient=mu * factor_of_curve[curve_of_point], curve=curve_of_point
    )
    fit = oilfilm.fit_table(table, oil="own", searches=2, bootstrap=40)
    folder = tmp_path_factory.mktemp("marks")
    fit.save(folder / "june")
    shutil.copytree(folder / "june", folder / "july")
    return fit, [folder / "june", folder / "july"]


@pytest.fixture
def saved_fit(saved: tuple[ArrayFit, list[Path]], capsys: pytest.CaptureFixture[str]) -> SavedFit:
    return SavedFit(*saved, capsys)


Point = tuple[float, float, float, float]


def words_of(point: Point) -> list[str]:
    return [word for pair in zip(OPTIONS, map(str, point), strict=True) for word in pair]


def marks(outside: object, over: object) -> set[str]:
    return {name for name, is_marked in (("outside", outside), ("over", over)) if is_marked}


def marks_of_prediction(prediction: Prediction) -> set[str]:
    return marks(prediction.outside, prediction.over_limit)


def marks_in_output(output_name: str, saved_fit: SavedFit, point: Point) -> set[str]:
    """The marks of mu at a point in one of the outputs."""
    folder, *_ = saved_fit.folders
    predict_words = ["predict", "--oil", "own", "--results", str(folder), *words_of(point)]
    compare_words = ["compare", *map(str, saved_fit.folders), *words_of(point)]
    match output_name:
        case "predict":
            text = saved_fit.command(*predict_words)
            return marks("OUTSIDE" in text, "IMPOSSIBLE" in text)
        case "predict --json":
            predicted_row = json.loads(saved_fit.command(*predict_words, "--json"))
            return marks(predicted_row["outside"], predicted_row["over_limit"])
        case "compare":
            text = saved_fit.command(*compare_words)
            return marks("!: outside the tested" in text, "IMPOSSIBLE" in text)
        case "fit":
            return marks_of_prediction(saved_fit.fit.predict(*point))
        case "saved fit":
            return marks_of_prediction(oilfilm.read_fit(folder, "own").predict_at(*point))
        case _:
            exported = runpy.run_path(str(saved_fit.exported("traction_own.py")))
            return {"marked"} if exported["outside_tested_box"](*point) else set()


OUTPUT_NAMES = ("predict", "predict --json", "compare", "fit", "saved fit", "exported Python")
MARKS = {
    "tested": set(),
    "outside": {"outside"},
    "far from every run": {"outside"},
    "over the limit": {"over"},
}
# The exported Python has one flag. It does not have the tested conditions, and says so.
MARKS_IN_PYTHON = {
    name: {"marked"} if name in ("outside", "over the limit") else set() for name in POINTS
}


@pytest.mark.slow
@pytest.mark.parametrize("output_name", OUTPUT_NAMES)
def test_mu_has_its_mark_wherever_it_is_asked(output_name: str, saved_fit: SavedFit) -> None:
    expected = MARKS_IN_PYTHON if output_name == "exported Python" else MARKS
    assert {
        name: marks_in_output(output_name, saved_fit, point) for name, point in POINTS.items()
    } == expected


@pytest.mark.slow
def test_explorer_marks_mu(saved_fit: SavedFit) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("there is no chromium (.ci/tools installs it)")
    marks_by_point = {}
    with playwright.sync_playwright() as playwright_session:
        browser = playwright_session.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        page = browser.new_page()
        page.goto((saved_fit.folders[0] / "report.html").as_uri())
        for name, point in POINTS.items():
            for symbol, value in zip("PUTS", point, strict=True):
                page.fill(f"#value-{symbol}", str(value))
                page.keyboard.press("Enter")
            warning = page.locator("#outside")
            text = "" if warning.is_hidden() else warning.inner_text()
            outside = page.locator(".card.beyond").count() == 1
            assert outside == ("tested 25 to 40" in text or "not near" in text)
            marks_by_point[name] = marks(outside, "shear stress" in text)
        browser.close()
    assert marks_by_point == MARKS


@pytest.mark.slow
def test_card_of_the_report_is_marked(saved_fit: SavedFit, config: Settings) -> None:
    results = CampaignTables.from_folder(saved_fit.folders[0])
    (row,) = answer_section(results, config).tables[0].rows
    assert "not tested" not in row[2] and "limiting" not in row[2]
    quality = results.fit_quality.assign(limiting_stress_ratio=1e-4)
    (row,) = answer_section(results.replace(fit_quality=quality), config).tables[0].rows
    assert "limiting shear stress" in row[2]
    tested_range = {
        "tested_min_entrainment_speed_m_s": 1.0,
        "tested_max_entrainment_speed_m_s": 2.0,
    }
    quality = results.fit_quality.assign(**tested_range)
    (row,) = answer_section(results.replace(fit_quality=quality), config).tables[0].rows
    assert "not tested there" in row[2]

    # the other exports: tests/deng2026_study/test_printed.py


def test_form_of_adore_is_marked(config: Settings) -> None:
    description = describe_law(config, "deng2026")
    conditions = dict(zip(CONDITIONS, (1.2, 30.0, 50.0), strict=True))
    points = (conditions, {**conditions, "entrainment_speed_m_s": 150.0})
    rows = adore_rows(replace(description, adore_points=points))
    assert [row["outside_tested_box"] for row in rows] == [False, True]
    assert not any(row["peak_above_limiting_stress"] for row in rows)
    weak_coefficients = replace(
        description.law_with_constants.coefficients, limiting_stress_ratio=1e-4
    )
    weak_description = replace(
        description,
        law_with_constants=replace(description.law_with_constants, coefficients=weak_coefficients),
        adore_points=points,
    )
    assert all(row["peak_above_limiting_stress"] for row in adore_rows(weak_description))


@pytest.mark.slow
def test_picture_of_a_comparison_is_dotted_where_untested(
    saved_fit: SavedFit, tmp_path: Path
) -> None:
    texts = []
    for speed in ("30m/s", "150m/s"):
        picture = tmp_path / "mu.svg"
        words = ["compare", *map(str, saved_fit.folders), "--speed", speed, "--plot", str(picture)]
        saved_fit.command(*words, "--stress", "1.2GPa")
        texts.append(picture.read_text(encoding="utf-8"))
    assert ["Dotted" in text for text in texts] == [False, True]
