"""The report in a browser: what it computes, and that it can be used by everyone.

Needs chromium or Chrome (`.ci/tools` installs Debian's chromium); skipped where there is none.
"""

import codecs
import csv
import io
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from browsers import CHROMIUM, QUIET
from nights import nightly
from oilfilm import predict
from oilfilm.fits.fitted import FittedLaw
from oilfilm.paper.audit.audit import films
from oilfilm.paper.audit.evidence import Evidence
from oilfilm.paper.selection import select
from oilfilm.report.explorer import law_of
from oilfilm.report.release_id import with_release
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Grid
from oilfilm.traction import LAWS
from planted_fits import planted_fit
from reports import CONDITIONS, HOSTILE, OILS, report_of, results_of, with_hostile_names

if sys.platform != "linux":
    pytest.skip("the report is tested in Debian's chromium", allow_module_level=True)
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Dialog, Page, sync_playwright

if CHROMIUM is None:
    pytest.skip("there is no chromium (.ci/tools installs it)", allow_module_level=True)
LOADED = "#explorer[data-ready]"


class Tab:
    """One page for all tests, with the messages of its console and its requests beyond itself.

    To load a file anew takes a third of the time of a new page.
    """

    def __init__(self, page: Page) -> None:
        self.page = page
        self.messages: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self.messages.append(message.text))
        page.on("dialog", self._refuse)
        page.on("pageerror", lambda error: self.messages.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def _refuse(self, dialog: Dialog) -> None:
        self.messages.append(f"the page ran {dialog.message}")
        dialog.dismiss()

    def open(self, file: Path, fragment: str = "", width: int = 1280) -> Page:
        """The page of a file as a new reader has it."""
        self.page.context.clear_permissions()
        self.page.emulate_media(media="null", color_scheme="light")
        self.page.set_viewport_size({"width": width, "height": 900})
        # from the same page with another fragment it would only scroll
        self.page.goto("about:blank")
        self.messages.clear()
        self.requests.clear()
        self.page.goto(file.as_uri() + fragment)
        self.page.wait_for_selector(LOADED)
        return self.page

    def problems(self, file: Path) -> list[str]:
        """Messages, and requests for anything but the file itself."""
        own = ("data:", "blob:", file.as_uri())
        messages = [text for text in self.messages if not text.startswith("[bokeh")]
        return messages + [url for url in self.requests if not url.startswith(own)]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        # starts with an empty profile in a folder of its own
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def results(config: Settings) -> CampaignTables:
    return results_of(config)


@pytest.fixture(scope="module")
def report(
    results: CampaignTables, config: Settings, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    folder = tmp_path_factory.mktemp("report")
    (folder / "report.html").write_text(report_of(results, config, folder), encoding="utf-8")
    return folder / "report.html"


@pytest.fixture(scope="module")
def tab(browser: Browser) -> Iterator[Tab]:
    with browser.new_context() as context:
        yield Tab(context.new_page())


@pytest.fixture
def page(tab: Tab, report: Path) -> Page:
    return tab.open(report)


@pytest.fixture(scope="module")
def calculator(browser: Browser, report: Path) -> Iterator[Page]:
    """The report, opened once for tests that set all that they ask for."""
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(report.as_uri())
        page.wait_for_selector(LOADED)
        yield page


def fitted(results: CampaignTables, oil: str) -> FittedLaw:
    return FittedLaw.of(results.coefficients, oil, results.refits, results.fit_quality)


def prediction(results: CampaignTables, oil: str, points: np.ndarray) -> Any:
    law = fitted(results, oil)
    return predict(law.law, law.coefficients, *points.T)


def curves(page: Page, number: int) -> dict[str, list[float]]:
    return page.evaluate(
        "n => Object.fromEntries(Object.entries(oilfilm.model(`curve${n}`).data)"
        ".map(([name, values]) => [name, Array.from(values)]))",
        number,
    )


def slide(page: Page, symbol: str, step: int) -> None:
    page.locator(f"#slider-{symbol}").fill(str(step))


def agree(values: Any, expected: Any) -> None:
    np.testing.assert_allclose(np.asarray(values, float), expected, rtol=1e-9, atol=1e-300)


def test_page_loads_without_a_message_and_asks_for_nothing(tab: Tab, report: Path) -> None:
    tab.open(report)
    assert report.as_uri() in tab.requests
    assert tab.problems(report) == []


def test_page_of_a_release_says_which(tab: Tab, report: Path) -> None:
    assert tab.open(report).inner_text("#release") == "not released"
    file = report.with_name("passed on.html")
    text = with_release(report.read_text(encoding="utf-8"), "v1-0123456789ab")
    file.write_text(text, encoding="utf-8")
    assert tab.open(file).inner_text("#release") == "v1-0123456789ab"


def test_policy_stops_scripts_that_are_not_the_pages_own(page: Page) -> None:
    page.evaluate(
        "() => { const s = document.createElement('script'); s.textContent = 'globalThis.x = 1';"
        " document.body.append(s); }"
    )
    assert page.evaluate("globalThis.x") is None


@pytest.mark.parametrize(
    ("abscissa", "steps"),
    [
        ("S", {"P": 60, "U": 15, "T": 55, "S": 100}),
        ("P", {"P": 0, "U": 180, "T": 120, "S": 50}),
        ("U", {"P": 170, "U": 0, "T": 0, "S": 300}),
        ("T", {"P": 45, "U": 5, "T": 50, "S": 7}),
    ],
)
def test_sliders_move_the_curves_to_the_numbers_of_python(
    calculator: Page, results: CampaignTables, abscissa: str, steps: dict[str, int]
) -> None:
    calculator.select_option("#abscissa", abscissa)
    for symbol, step in steps.items():
        slide(calculator, symbol, step)
    point = calculator.evaluate("oilfilm.state.point")
    sliders = {"P": (0.8, 0.01), "U": (20, 1), "T": (20, 1), "S": (0, 0.001)}
    expected = [low + steps[symbol] * step for symbol, (low, step) in sliders.items()]
    assert point == pytest.approx(expected)
    for number, oil in enumerate(OILS):
        line = curves(calculator, number)
        points = np.tile(point, (len(line["x"]), 1))
        points[:, "PUTS".index(abscissa)] = line["x"]
        expected = prediction(results, oil, points)
        assert len(line["x"]) > 100
        agree(line["mu"], expected.traction_coefficient)
        agree(line["lower"], expected.obs_ci_lower)
        agree(line["upper"], expected.obs_ci_upper)


@pytest.mark.parametrize("name", LAWS)
def test_every_law_of_the_page_is_that_of_python(calculator: Page, name: str) -> None:
    fit, factor, power = planted_fit(LAWS[name])
    random = np.random.default_rng(9)
    points = random.uniform([0.5, 5, 5, 0], [3, 250, 180, 0.5], (300, 4))
    points[:20, 3] = 0
    conditions = np.column_stack([factor * points[:, 0] ** power, points[:, 1:3]])
    expected = fit.predict(conditions, points[:, 3])
    predictions = calculator.evaluate(
        "([law, points]) => points.map(p => oilfilm.predict(law, p))",
        [law_of(fit, factor), points.tolist()],
    )
    assert 20 < expected.away.sum() < 280
    assert [at["away"] for at in predictions] == expected.away.tolist()
    agree([at["mu"] for at in predictions], expected.traction_coefficient)
    agree([at["lower"] for at in predictions], expected.obs_ci_lower)
    agree([at["upper"] for at in predictions], expected.obs_ci_upper)
    assert [at["outside"] for at in predictions] == expected.outside.tolist()
    if power == 1:  # the page tells the distance by the pressure, Python by the load
        agree([max(at["beyond"]) for at in predictions], expected.distance)


@pytest.mark.parametrize("lambda_limit", [3.0, 8.0])
def test_page_advises_what_python_does(
    calculator: Page, results: CampaignTables, config: Settings, lambda_limit: float
) -> None:
    laws = {oil: fitted(results, oil) for oil in OILS}
    evidence = Evidence("refit", OILS, laws, films(config), lambda_limit)
    grid = {"inlet_temperature_c": [30, 99, 100, 140], "slide_roll_ratio": [0.001, 0.05, 0.15, 0.3]}
    chosen = {"selection": {"map": {**grid, "levels": 9}}}
    settings = config.with_changes(chosen).selection
    box = config.printed.boxes.extrapolated.model_dump()
    table = select([evidence], settings, box)
    advice = calculator.evaluate(
        "([limit, points]) => { oilfilm.DATA.selection.lambda_limit = limit;"
        " return points.map(p => { const a = oilfilm.advise(p); return ["
        " a.rule.name, a.advised?.name ?? '', a.best?.name ?? '', a.judgement, a.loss,"
        " a.advised?.lambda ?? NaN, a.best?.lambda ?? NaN, a.advised?.mu ?? NaN,"
        " a.contradicting.map(r => r.name).join('; ')]; }); }",
        [lambda_limit, table[list(AXES)].to_numpy().tolist()],
    )
    columns = [list(column) for column in zip(*advice, strict=True)]
    for index, name in enumerate(("selection_rule", "advised_oil", "best_oil", "judgement")):
        assert columns[index] == table[name].tolist()
    assert columns[8] == table["contradicting_rules"].tolist()
    assert table["judgement"].nunique() > 2
    assert (table["judgement"] == "outside the film formula").any()
    np.testing.assert_allclose(columns[4], table["loss_ratio"], rtol=1e-9, atol=1e-9)
    for index, name in enumerate(
        ("advised_lambda_ratio", "best_lambda_ratio", "advised_traction_coefficient"), 5
    ):
        agree(columns[index], table[name])


def test_film_of_the_page_is_that_of_python_at_every_step(
    calculator: Page, results: CampaignTables, config: Settings
) -> None:
    grid = Grid(
        np.array([0.8, 1.37, 2.5]),
        np.array([20.0, 63.0, 200.0]),
        np.array([20.0, 57.0, 93.0, 94.0, 140.0]),  # a property bends at 93.85 degC
        np.array([0.0, 0.123]),
    )
    points = grid.operating_points().to_numpy().tolist()
    for number, oil in enumerate(OILS):
        ratios = calculator.evaluate(
            "([n, points]) => points.map(p => oilfilm.lambdaRatio(oilfilm.DATA.oils[n].film, p))",
            [number, points],
        )
        agree(ratios, films(config)[oil].over(grid)[1].ravel())


def test_points_beside_the_curve_are_the_near_ones(page: Page, results: CampaignTables) -> None:
    for symbol, step in {"P": 45, "U": 5, "T": 50}.items():  # 1.25 GPa, 25 m/s, 70 degC
        slide(page, symbol, step)
    points = results.points
    near = points[
        (points["oil"] == "4050")
        & (points["max_hertz_pressure_gpa"] == 1.25)
        & (points["entrainment_speed_m_s"] == 25)
        & (points["inlet_temperature_c"] == 70)
    ]
    shown = page.evaluate("Array.from(oilfilm.model('points1').data.mu)")
    assert shown == near["traction_coefficient"].tolist()
    slide(page, "T", 56)  # 76 degC: nothing within 3 K
    assert page.evaluate("oilfilm.model('points1').data.mu.length") == 0


def test_outside_the_tested_box_the_page_warns(page: Page) -> None:
    slide(page, "U", 10)
    assert page.locator("#outside").is_hidden()
    slide(page, "U", 150)
    assert "U 170, tested 25 to 40" in page.inner_text("#outside")
    assert "no: U beyond" in page.inner_text("#here")
    # against slip nothing is tested there; against speed all but the fast part is
    assert page.evaluate("oilfilm.model('below').right") == pytest.approx(0.3)
    page.select_option("#abscissa", "U")
    assert page.evaluate("oilfilm.model('below').right") == pytest.approx(25)
    assert page.evaluate("oilfilm.model('above').left") == pytest.approx(40)
    slide(page, "S", 0)
    assert page.inner_text("#advice").startswith("Without slip")


def test_link_restores_the_state(tab: Tab, report: Path) -> None:
    page = tab.open(report)
    page.select_option("#abscissa", "T")
    slide(page, "P", 33)
    slide(page, "S", 200)
    page.locator("[name=oil]").nth(1).uncheck()
    before = page.evaluate("oilfilm.state"), curves(page, 0)
    again = tab.open(report, page.evaluate("location.hash"))
    assert (again.evaluate("oilfilm.state"), curves(again, 0)) == before
    assert again.locator("#slider-P").input_value() == "33"
    assert again.locator("[name=oil]").nth(1).is_checked() is False
    assert curves(again, 1)["mu"] == []


@pytest.mark.parametrize(
    "fragment",
    ["#explorer?x=Q&P=nan&U=1e999&T=-5&oils=[", "#explorer?P=9&S=-1&oils=%3Cscript%3E"],
)
def test_link_that_makes_no_sense_does_no_harm(tab: Tab, report: Path, fragment: str) -> None:
    point = np.array(tab.open(report, fragment).evaluate("oilfilm.state.point"))
    assert tab.problems(report) == []
    assert (([0.8, 20, 20, 0] <= point) & (point <= [2.5, 200, 140, 0.3])).all()


def saved(page: Page, button: str) -> tuple[str, bytes]:
    """Name and content of the file that a button saves."""
    with page.expect_download() as saving:
        page.click(button)
    return saving.value.suggested_filename, Path(saving.value.path()).read_bytes()


def csv_rows(content: bytes) -> tuple[str, list[dict[str, str]]]:
    # the mark of UTF-8, as `write_csv` sets it
    assert content.startswith(codecs.BOM_UTF8)
    text = content.decode("utf-8-sig")
    return text, list(csv.DictReader(io.StringIO(text, newline="")))


def test_curve_saved_as_csv_is_the_curve(page: Page, results: CampaignTables) -> None:
    page.select_option("#abscissa", "U")
    name, content = saved(page, "#save-curve")
    assert name == "curve.csv"
    _, rows = csv_rows(content)
    assert [row["oil"] for row in rows[::201]] == list(OILS)
    for oil in OILS:
        own = [row for row in rows if row["oil"] == oil]
        points = np.array([[float(row[name]) for name in AXES] for row in own])
        expected = prediction(results, oil, points)
        agree([row["traction_coefficient"] for row in own], expected.traction_coefficient)
        agree([row["upper"] for row in own], expected.obs_ci_upper)
        assert [row["outside"] for row in own] == expected.outside.astype(str).tolist()


def test_constants_saved_and_copied_are_the_table(page: Page, results: CampaignTables) -> None:
    text, rows = csv_rows(saved(page, "[data-save='coefficients.csv']")[1])
    assert [float(row["value"]) for row in rows] == results.coefficients["value"].tolist()
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.click("[data-copy='coefficients.csv']")
    page.wait_for_selector("#copied:not(:empty)")
    assert page.inner_text("#copied") == "Copied."
    copied = page.evaluate("navigator.clipboard.readText()")
    assert copied.replace("\r\n", "\n") == text.replace("\r\n", "\n")


def test_drawing_is_saved_as_it_was_made(page: Page, report: Path) -> None:
    drawing = (report.parent / "fig02.svg").read_bytes()
    assert saved(page, "[data-drawing=fig02]") == ("fig02.svg", drawing)


def test_hostile_names_are_shown_as_text(
    tab: Tab, results: CampaignTables, config: Settings, tmp_path: Path
) -> None:
    file = tmp_path / "report.html"
    text = report_of(with_hostile_names(results), config, tmp_path)
    file.write_text(text, encoding="utf-8")
    page = tab.open(file, width=375)
    shown = " ".join(page.locator("#refused").inner_text().split())
    assert [name for name in HOSTILE if " ".join(name.split()) not in shown] == []
    # the tooltip of a point has the name of its run
    for symbol, value in zip("PUT", CONDITIONS[0], strict=True):
        page.fill(f"#value-{symbol}", str(value))
        page.keyboard.press("Enter")
    page.locator("#chart").scroll_into_view_if_needed()
    left, top = page.evaluate(
        "() => { const view = Bokeh.index.roots[0], box = view.el.getBoundingClientRect();"
        " const { x, mu } = oilfilm.model('points0').data;"
        " return [box.x + view.frame.x_scale.compute(x[10]),"
        " box.y + view.frame.y_scale.compute(mu[10])]; }"
    )
    page.mouse.move(left - 30, top)
    page.mouse.move(left, top)
    tip = page.locator(".bk-Tooltip").first
    tip.wait_for(state="visible")
    assert HOSTILE[0] in tip.evaluate("tip => tip.shadowRoot.textContent")
    page.mouse.move(0, 0)
    assert page.locator("img[src=x]").count() == 0
    assert tab.problems(file) == []
    # a name without spaces must not push the page off a phone's screen
    assert page.evaluate("document.documentElement.scrollWidth") <= 375


VIEWS = product([375, 768, 1280], ["light", "dark"], ["", "#figure-fig02 .enlarge", "#run-list a"])
QUICK_VIEWS = [
    (375, "light", ""),
    (375, "dark", "#figure-fig02 .enlarge"),
    (375, "light", "#run-list a"),
]


@pytest.mark.parametrize(
    ("width", "scheme", "opened"),
    [view if view in QUICK_VIEWS else nightly(*view) for view in VIEWS],
)
def test_everyone_can_use_the_page(
    tab: Tab, report: Path, width: int, scheme: str, opened: str
) -> None:
    page = tab.open(report, width=width)
    page.emulate_media(color_scheme=scheme)
    for details in page.locator("details").all():
        details.evaluate("details => { details.open = true; }")
    if opened:
        page.locator(opened).first.click()
    violations = [
        f"{violation['id']}: {node['html'][:200]}"
        for violation in Axe().run(page).response["violations"]
        for node in violation["nodes"]
    ]
    assert violations == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_constants_of_two_oils_are_side_by_side_on_a_wide_screen(tab: Tab, report: Path) -> None:
    """At 1280 px less a scroll bar, with every verdict in sight."""
    tables = tab.open(report, width=1265).locator(".side-by-side .scroll")
    sizes = tables.evaluate_all(
        "all => all.map(one => [one.getBoundingClientRect().top, one.scrollWidth, one.clientWidth])"
    )
    assert len(sizes) == len(OILS)
    assert sizes[0][0] == sizes[1][0]
    assert all(inner <= outer for _, inner, outer in sizes), sizes


def test_constants_show_every_column_on_a_phone(tab: Tab, report: Path) -> None:
    page = tab.open(report, width=390)
    assert page.locator("#constants0 tbody tr").first.locator("td").count() == 5
    hidden = page.locator(".side-by-side td").evaluate_all(
        "all => all.filter(td => { const box = td.getBoundingClientRect(); return box.width === 0"
        " || box.left < 0 || box.right > 390 || td.scrollWidth > td.clientWidth + 1; })"
        ".map(td => td.textContent)"
    )
    assert hidden == []


def cells_of(page: Page, table: str, column: int) -> list[str]:
    cells = page.locator(f"#{table} tbody tr:not([hidden]) > :nth-child({column})")
    return cells.all_inner_texts()


def test_tables_sort_by_number_and_by_word(page: Page, results: CampaignTables) -> None:
    own = results.coefficients[results.coefficients["oil"] == OILS[0]]
    rising = own.sort_values("value")["constant"].tolist()
    head = page.locator("#constants0 th", has_text="Value")
    head.locator("button").click()
    assert cells_of(page, "constants0", 1) == rising
    assert head.get_attribute("aria-sort") == "ascending"
    head.locator("button").click()
    assert cells_of(page, "constants0", 1) == rising[::-1]
    page.locator("#constants0 th", has_text="Constant").locator("button").click()
    assert cells_of(page, "constants0", 1) == sorted(rising)


def test_search_leaves_the_rows_with_all_words(page: Page) -> None:
    page.locator("#data input[type=search]").fill("REFUSED stuck")
    assert cells_of(page, "run-list", 1) == ["stuck.csv"]
    assert "1 of 55 rows" in page.inner_text("#data .search")
    page.set_viewport_size({"width": 390, "height": 800})
    assert page.locator("#run-list tbody tr:visible").count() == 1


def test_every_run_has_a_page_with_its_curve_and_the_gates(
    page: Page, results: CampaignTables
) -> None:
    page.locator("#run-list a").nth(1).click()
    page.wait_for_selector("#run[open]")
    name = page.inner_text("#run-heading")
    points = results.points[results.points["run_id"] == name]
    assert page.locator("#run-page circle").count() == len(points) == 31
    assert page.locator("#run-page .law").count() == 1
    gates = page.locator("#run-page table").nth(1)
    assert "refused nothing" in gates.inner_text()
    assert "refused the run" not in gates.inner_text()
    address = page.evaluate("location.hash")
    page.click("#run [data-step='-1']")
    page.wait_for_function("document.getElementById('run-heading').textContent === 'stuck.csv'")
    stuck = page.locator("#run-page table").nth(1).locator("tr", has_text="stuck sensor")
    assert stuck.inner_text().endswith("refused the run")
    page.click("#run [data-close]")
    assert page.locator("#run").is_hidden()
    page.evaluate("address => { location.hash = address; }", address)
    page.wait_for_selector("#run[open]")
    assert page.inner_text("#run-heading") == name


def test_figure_is_enlarged_with_its_whole_caption(page: Page) -> None:
    page.click("#figure-fig02 .enlarge")
    caption = page.inner_text("#enlarged-caption")
    assert "Lubricants 14 (2026) 33" in caption
    page.keyboard.press("ArrowRight")
    assert page.inner_text("#enlarged-caption") != caption
    page.keyboard.press("Escape")
    assert page.locator("#enlarged").is_hidden()


def test_explorer_works_by_keyboard_alone(page: Page) -> None:
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the verdict"
    before = page.evaluate("oilfilm.state.point")
    seen = set()
    for _ in range(150):
        if "save-curve" in seen:
            break
        page.keyboard.press("Tab")
        seen.add(page.evaluate("document.activeElement.id"))
        if page.evaluate("document.activeElement.id") == "slider-P":
            page.keyboard.press("ArrowRight")
        if page.evaluate("document.activeElement.id") == "value-T":
            page.keyboard.type("99")
    assert {"slider-P", "value-P", "slider-S", "abscissa", "copy-link", "save-curve"} <= seen
    after = page.evaluate("oilfilm.state.point")
    assert after[0] == pytest.approx(before[0] + 0.01)
    assert after[2] != before[2]


def test_print_shows_what_is_folded_and_no_buttons(page: Page) -> None:
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.locator("details:not([open], .on-screen)").count() == 0
    assert page.locator("details.on-screen").first.is_hidden()
    assert page.locator("nav").is_hidden()
    assert page.locator("#save-curve").is_hidden()
    assert page.locator("#constants0").is_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.locator("details[open]").count() == 0
    assert len(page.pdf(format="A4")) > 20_000
