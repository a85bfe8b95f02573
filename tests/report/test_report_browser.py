"""The report in a browser: what it computes, and that it can be used by everyone.

Needs chromium or Chrome (`.ci/tools` installs Debian's chromium); skipped where there is none.
"""

import csv
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from browsers import Page, Tab
from nights import nightly
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.explorer import law_as_json
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS
from planted_fits import planted_fit
from reports import HOSTILE, OILS, report_of, with_hostile_names

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(
    results: CampaignTables, config: Settings, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    folder = tmp_path_factory.mktemp("report")
    (folder / "report.html").write_text(report_of(results, config, folder), encoding="utf-8")
    return folder / "report.html"


@pytest.fixture
def page(tab: Tab, report: Path) -> Page:
    return tab.open(report)


def prediction(results: CampaignTables, oil: str, points: np.ndarray) -> Any:
    return FittedLaw.from_results(results, oil).predict_at(*points.T)


def agree(values: Any, expected: Any, rtol: float = 1e-9) -> None:
    np.testing.assert_allclose(np.asarray(values, float), expected, rtol=rtol, atol=1e-300)


def same(predictions: list[dict[str, Any]], expected: Any) -> None:
    """Predictions of the page are those of Python.

    The page interpolates intervals inside the tested box, which changes their ends by up to 1.5 %.
    """
    agree([at["mu"] for at in predictions], expected.traction_coefficient)
    upper = np.array([at["upper"] for at in predictions], float)
    shown = np.isfinite(upper)
    assert np.isfinite(expected.obs_ci_upper[shown]).all()
    agree(upper[shown], expected.obs_ci_upper[shown], rtol=1.5e-2)
    lower = np.array([at["lower"] for at in predictions], float)
    agree(lower[shown], expected.obs_ci_lower[shown], rtol=1.5e-2)
    assert [at["outside"] for at in predictions] == expected.outside.tolist()


def choose(page: Page, **values: float) -> None:
    for symbol, value in values.items():
        page.fill(f"#value-{symbol}", str(value))
        page.keyboard.press("Enter")


def test_page_asks_for_nothing_and_runs_no_script_but_its_own(tab: Tab, report: Path) -> None:
    page = tab.open(report)
    assert tab.problems == []
    page.evaluate(
        "() => { const s = document.createElement('script'); s.textContent = 'globalThis.x = 1';"
        " document.body.append(s); }"
    )
    assert page.evaluate("globalThis.x") is None


def test_curves_and_cards_are_the_numbers_of_python(page: Page, results: CampaignTables) -> None:
    points = {
        "S": [1.4, 35.0, 75.0, 0.1],
        "P": [0.8, 200.0, 140.0, 0.05],
        "U": [2.5, 20.0, 20.0, 0.3],
        "T": [1.25, 25.0, 70.0, 0.007],
    }
    for along, (abscissa, point) in zip((3, 0, 1, 2), points.items(), strict=True):
        page.select_option("#abscissa", abscissa)
        choose(page, **dict(zip("PUTS", point, strict=True)))
        assert page.evaluate("oilfilm.state.point") == pytest.approx(point)
        mus = page.locator(".card .mu dd").all_inner_texts()
        intervals = page.locator(".card .interval dd").all_inner_texts()
        for number, oil in enumerate(OILS):
            at = prediction(results, oil, np.array([point]))
            agree(mus[number], at.traction_coefficient[0], rtol=5e-3)
            # of these points one is inside the tested box and above its smallest slip
            is_known = abscissa == "S"
            assert (intervals[number] != "not known") == is_known
            if is_known:
                ends = intervals[number].removesuffix(" (95 %)").split(" to ")
                agree(ends, [at.obs_ci_lower[0], at.obs_ci_upper[0]], rtol=1.5e-2)
            curve = page.evaluate(
                "([i, along]) => oilfilm.line(oilfilm.OILS[i], oilfilm.state.point, along,"
                " oilfilm.rangeOf(along))",
                [number, along],
            )
            assert len(curve) > 100
            row = np.tile(point, (len(curve), 1))
            row[:, along] = [each["x"] for each in curve]
            expected = prediction(results, oil, row)
            same(curve, expected)


def test_every_law_of_the_page_is_that_of_python(page: Page) -> None:
    points = np.random.default_rng(9).uniform([0.5, 5, 5, 0], [3, 250, 180, 0.5], (200, 4))
    points[:20, 3] = 0
    for name, law in LAWS.items():
        fit, factor, power = planted_fit(law)
        conditions = np.column_stack([factor * points[:, 0] ** power, points[:, 1:3]])
        expected = fit.predict(conditions, points[:, 3])
        predictions = page.evaluate(
            "([law, points]) => points.map(p => oilfilm.predict(law, p))",
            [law_as_json(fit, factor), points.tolist()],
        )
        assert 20 < expected.away.sum() < 180
        assert [at["away"] for at in predictions] == expected.away.tolist(), name
        same(predictions, expected)


def test_points_beside_the_curve_are_the_near_ones(page: Page, results: CampaignTables) -> None:
    at = {"max_hertz_pressure_gpa": 1.25, "entrainment_speed_m_s": 25, "inlet_temperature_c": 70}
    choose(page, **dict(zip("PUT", at.values(), strict=True)))
    points = results.points[results.points["oil"] == "4050"]
    near = points[(points[list(at)] == list(at.values())).all(axis=1)]
    drawn = page.evaluate("oilfilm.nearby(oilfilm.OILS[1], 3).map(({ mu }) => mu)")
    agree(drawn, near["traction_coefficient"], rtol=1e-5)
    assert page.locator("#chart .oil1 circle").count() == len(near)
    choose(page, T=76)  # nothing within 3 K
    assert page.locator("#chart circle").count() == 0


def test_shear_stress_beyond_the_limit_has_a_sentence_of_its_own(page: Page) -> None:
    page.evaluate("oilfilm.OILS.forEach((oil) => { oil.limit = 0.001; })")
    choose(page, U=30)
    warning = page.inner_text("#outside")
    assert "Outside the tested conditions" not in warning
    assert f"no film carries so much shear stress over pressure: {OILS[0]}" in warning
    choose(page, U=170)
    assert "Outside the tested conditions" in page.inner_text("#outside")
    assert "no film carries" in page.inner_text("#outside")


def test_outside_the_tested_box_the_page_warns(page: Page) -> None:
    assert page.locator("#outside").is_hidden()
    choose(page, U=170)
    assert "U 170: tested 25 to 40" in page.inner_text("#outside")
    assert page.locator(".card.beyond").count() == len(OILS)
    shades = "all => all.map(one => Number(one.getAttribute('width')))"
    # against slip nothing is tested there; against speed all but the fast and the slow part
    (whole,) = page.locator("#chart .shade").evaluate_all(shades)
    page.select_option("#abscissa", "U")
    parts = page.locator("#chart .shade").evaluate_all(shades)
    assert [part / whole for part in parts] == pytest.approx([5 / 180, 160 / 180], abs=0.01)


def test_hostile_names_are_shown_as_text(
    tab: Tab, results: CampaignTables, config: Settings, tmp_path: Path
) -> None:
    file = tmp_path / "report.html"
    changed = {"log": "data/raw/june/a.csv", "was": "0" * 16, "now": "1" * 16, "reason": HOSTILE[0]}
    about = {"title": HOSTILE[1], "creators": HOSTILE[2:4], "sources": [{"title": HOSTILE[1]}]}
    settings = config.with_changes(
        {
            "campaign": {"description": HOSTILE[0]},
            "dataset": {**about, "acknowledged_changes": [changed]},
        }
    )
    text = report_of(with_hostile_names(results), settings, tmp_path)
    file.write_text(text, encoding="utf-8")
    page = tab.open(file, width=375)
    shown = " ".join(page.inner_text("body").split())
    assert [name for name in HOSTILE if " ".join(name.split()) not in shown] == []
    texts = " ".join(page.locator("#chart title").all_text_contents())
    assert any(name in texts for name in HOSTILE)
    assert page.locator("img[src=x]").count() == 0
    assert tab.problems == []
    # a name without spaces must not push the page off a phone's screen
    assert page.evaluate("document.documentElement.scrollWidth") <= 375


@pytest.mark.parametrize(
    ("width", "scheme"), [(390, "light"), nightly(1440, "dark"), nightly(390, "dark")]
)
def test_everyone_can_use_the_page(tab: Tab, report: Path, width: int, scheme: str) -> None:
    page = tab.open(report, width=width)
    page.emulate_media(color_scheme=scheme)
    # the answer and the curves are on the first screen
    assert page.locator(".card").first.bounding_box()["y"] < 300
    assert page.locator("#chart").bounding_box()["y"] < 600
    for details in page.locator("details").all():
        details.evaluate("details => { details.open = true; }")
    assert tab.violations() == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_value_that_no_slider_has_is_refused_with_the_range(page: Page) -> None:
    choose(page, S=0.1)
    choose(page, S=15)
    assert page.evaluate("oilfilm.state.point[3]") == pytest.approx(0.1)
    refusal = page.inner_text("#refused-value")
    assert "S 15 is not in the range of this page, 0.000 to " in refusal
    assert "Write 0.15 for 15 %" in refusal
    choose(page, S=0.2)
    assert page.locator("#refused-value").is_hidden()


def test_a_sound_fit_is_not_green_where_it_was_not_tested(page: Page) -> None:
    colour = "one => getComputedStyle(one).color"
    heading, verdict = page.locator(".card dt").first, page.locator(".card .fit dd").first
    verdict.evaluate("one => { one.className = 'good'; }")
    inside = verdict.evaluate(colour)
    choose(page, U=170)
    assert verdict.evaluate(colour) == heading.evaluate(colour) != inside


def test_a_table_is_copied_as_csv(page: Page) -> None:
    page.evaluate("navigator.clipboard.writeText = (text) => { globalThis.copied = text; }")
    page.locator("button.copy").first.click()
    table = page.locator(".scroll > table").first
    rows = list(csv.reader(io.StringIO(page.evaluate("globalThis.copied"))))
    assert len(rows) == table.locator("tr").count()
    first = table.locator("tbody tr").first.locator("th, td").all_text_contents()
    assert rows[1] == [" ".join(cell.split()).replace("\u2212", "-") for cell in first]


@pytest.mark.parametrize(
    ("shown", "copied"),
    [
        ("\u22120.0532", "-0.0532"),
        ("\u22121.5e\u22127", "-1.5e-7"),
        ("\u22120.05 \u2026 0.01", "-0.05 \u2026 0.01"),
        ("=1+1.csv", "'=1+1.csv"),
        ("-1+cmd|' /C calc'!A0", "'-1+cmd|' /C calc'!A0"),
        ("\u2212SUM(A1)", "'-SUM(A1)"),
        ("@x", "'@x"),
        ("+1", "'+1"),
        ("a-b, c", "a-b, c"),
    ],
)
def test_copied_numbers_are_numbers_and_names_are_no_formulas(
    page: Page, shown: str, copied: str
) -> None:
    code = "(text) => { const table = document.createElement('table'); "
    code += "table.insertRow().insertCell().textContent = text; return oilfilm.csv(table); }"
    assert next(csv.reader(io.StringIO(page.evaluate(code, shown)))) == [copied]


def test_the_report_is_printed_on_one_page(page: Page, tmp_path: Path) -> None:
    written = page.pdf(path=tmp_path / "report.pdf", prefer_css_page_size=True)
    assert len(re.findall(rb"/Type\s*/Page\b", written)) == 1


def test_name_of_a_run_leads_to_its_point_or_signals(page: Page, results: CampaignTables) -> None:
    # a run without accepted points and without a page has no link
    link = page.locator("#run-list a[href^='#run?']").nth(1)
    run_id = link.inner_text()
    link.click()
    run = results.points[results.points["run_id"] == run_id]
    conditions = run[list(CONDITIONS)].mean().tolist()
    # the browser tells the page of its new address after the click
    page.wait_for_function(
        "conditions => conditions.every("
        "  (value, i) => Math.abs(oilfilm.state.point[i] / value - 1) < 1e-6)",
        arg=conditions,
    )
    page.locator("#run-list a", has_text="stuck.csv").click()
    page.wait_for_selector("#refused-stuck img", state="visible")


def test_explorer_works_by_keyboard_alone(page: Page) -> None:
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the answer"
    before, seen = page.evaluate("oilfilm.state.point"), set()
    keys = {"slider-P": "ArrowRight", "value-T": "ArrowUp"}
    for _ in range(60):
        page.keyboard.press("Tab")
        focused = page.evaluate("document.activeElement.id")
        if focused in keys and focused not in seen:
            page.keyboard.press(keys[focused])
        seen.add(focused)
    assert {"slider-P", "value-P", "slider-S", "abscissa"} <= seen
    after = page.evaluate("oilfilm.state.point")
    assert after[0] == pytest.approx(before[0] + 0.01)
    assert after[2] != before[2]
