"""The report without a browser: what its text holds, and what can never get into it."""

import html
import json
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.document import _shown_tables
from oilfilm.report.explorer import Axis, explorer_data
from oilfilm.report.html import _LOOK_BY_VERDICT
from oilfilm.report.release_id import with_release
from oilfilm.settings.resolved import Settings
from oilfilm.tables import TABLES
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import SURFACE_TABLES
from reports import OILS, report_of, rows

Write = Callable[..., str]


class Page:
    """Texts and data of a page."""

    def __init__(self, page: str) -> None:
        (data,) = re.findall(
            r'<script type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL
        )
        self.data = json.loads(data)
        shown = re.sub(r"<(script|style).*?</\1>|<[^>]*>", "", page, flags=re.DOTALL)
        self.text = " ".join(html.unescape(shown).split())


@pytest.fixture(scope="module")
def write(
    results: CampaignTables, config: Settings, tmp_path_factory: pytest.TempPathFactory
) -> Write:
    """Writes the report into a new folder; other settings and other tables may be given."""

    def write(changes: dict[str, Any] | None = None, **replaced: pd.DataFrame) -> str:
        folder = tmp_path_factory.mktemp("report")
        return report_of(results.replace(**replaced), config.with_changes(changes or {}), folder)

    return write


@pytest.fixture(scope="module")
def write_of_one_oil(
    results: CampaignTables, config: Settings, tmp_path_factory: pytest.TempPathFactory
) -> Write:
    """The same with one of the three oils, for what the page says whatever was fitted."""
    of_one_oil = {}
    for name in ("coefficients", "fit_quality", "refits", "points", *SURFACE_TABLES):
        table = results.table(name)
        of_one_oil[name] = table[table["oil"] == OILS[0]]

    def write(changes: dict[str, Any] | None = None, **replaced: pd.DataFrame) -> str:
        folder = tmp_path_factory.mktemp("report")
        tables_of_page = results.replace(**{**of_one_oil, **replaced})
        return report_of(tables_of_page, config.with_changes(changes or {}), folder)

    return write


@pytest.fixture(scope="module")
def text(write: Write) -> str:
    return write()


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


@pytest.mark.slow
def test_same_results_give_the_same_bytes_wherever_they_lie(
    write_of_one_oil: Write, tmp_path_factory: pytest.TempPathFactory
) -> None:
    text = write_of_one_oil()
    assert write_of_one_oil() == text
    assert str(tmp_path_factory.getbasetemp()) not in text
    assert str(ROOT) not in text


@pytest.mark.slow
def test_page_has_the_points_themselves(page: Page, results: CampaignTables) -> None:
    drawn, points = page.data["points"], results.points
    assert [drawn["names"][run] for run in drawn["run"]] == points["run_id"].tolist()
    assert drawn["oil"] == points["oil"].tolist()
    assert drawn["axes"][3] == pytest.approx(points["slide_roll_ratio"], rel=1e-5)
    assert drawn["mu"] == pytest.approx(points["traction_coefficient"], rel=1e-5)


@pytest.mark.slow
def test_cards_answer_for_every_oil_at_one_point(page: Page, results: CampaignTables) -> None:
    data = page.data
    at = [axis["start"] for axis in data["axes"]]
    # the accepted point nearest to the middle of 1 to 1.5 GPa, 25 to 40 m/s, 25 to 120 degC
    assert at[0] == 1.25
    assert at[2] == 70.0
    text = page.text
    for oil in OILS:
        expected = FittedLaw.from_results(results, oil).predict_at(*at)
        ends = [float(expected.obs_ci_lower), float(expected.obs_ci_upper)]
        mu, *interval = (f"{value:#.3g}" for value in (float(expected.traction_coefficient), *ends))
        assert f"{mu} Next good run{' to '.join(interval)} (95 %)" in text
    assert "Fitsound" in text
    assert "Fitnot sound (law: none fits; campaign: changed)" in text
    assert (
        "4050: The campaign is not steady. From run b on (2 runs) the traction force reads higher"
        in text
    )


def test_data_that_could_not_be_fitted_make_a_page(write: Write, results: CampaignTables) -> None:
    nothing = results.coefficients.assign(
        **dict.fromkeys(["value", "standard_error", "lower", "upper"], np.nan),
        identifiable=False,
        verdict="not identifiable",
    )
    empty = ("refits", "points", "runs", "quarantine", "torque")
    page = Page(
        write(
            coefficients=nothing,
            fit_quality=results.fit_quality.assign(rmse=np.nan, certified=False),
            **{name: results.table(name)[:0] for name in empty},
        )
    )
    text = page.text
    assert "Nothing could be fitted" in text


def test_explorer_without_surface_and_speed(results: CampaignTables, config: Settings) -> None:
    lost = results.coefficients["constant"].isin(["A2", "B2", "C2"])
    table = results.coefficients.assign(value=results.coefficients["value"].mask(lost))
    without_surface = {name: results.table(name)[:0] for name in SURFACE_TABLES}
    content = explorer_data(results.replace(coefficients=table, **without_surface), config)
    assert [oil["surface"] for oil in content["oils"]] == [None] * 3
    assert [axis["idle"] for axis in content["axes"]] == [False, True, False, False]
    assert [oil["known"] for oil in content["oils"]] == [[True, False, True]] * 3


@pytest.mark.slow
def test_page_stays_below_its_limit_and_says_what_it_leaves_out(write: Write, text: str) -> None:
    pictures = sum(map(len, re.findall(r'srcset="(data:[^"]*)"', text)))
    size_max = len(text.encode()) - pictures + 1000
    page = write({"report": {"size_max_mb": size_max / 1e6}})
    assert len(page.encode()) <= size_max
    assert "<code>figures/curves.png</code>" in page
    assert "<code>figures/curves.png</code>" not in text


@pytest.mark.slow
def test_many_points_and_refusals_are_thinned_and_counted(write: Write) -> None:
    page = Page(write({"report": {"points_max": 500, "rows_max": 1}}))
    points = page.data["points"]
    assert len(points["mu"]) == 1674 - points["left_out"] <= 500
    text = page.text
    assert f"{points['left_out']} accepted points are not in this page" in text
    assert "And 54 more rows" in text


@pytest.mark.parametrize(
    ("low", "high", "step"),
    [(0.8, 2.5, 0.01), (20, 200, 1), (0.0, 0.3, 0.001), (0.0249, 0.0251, 1e-6), (0.5, 100.0, 0.1)],
)
def test_slider_covers_its_range_in_round_steps(low: float, high: float, step: float) -> None:
    axis = Axis.with_round_steps("x", low, high, (low + high) / 2)
    assert axis.step == pytest.approx(step)
    assert axis.low <= low * (1 + 1e-12)
    assert axis.low > 0 or low == 0
    assert axis.high >= high * (1 - 1e-12)
    assert axis.low + axis.steps * axis.step == pytest.approx(axis.high)
    assert axis.steps < 2000


@pytest.mark.slow
def test_header_says_once_where_the_data_are_from(write_of_one_oil: Write, text: str) -> None:
    assert text.count("Measured data") == 1
    assert "SIMULATED data" not in text
    by_program = {"data": "simulated", "simulated_by": "a program"}
    simulated = write_of_one_oil({"campaign": by_program, "dataset": {"date": "June 2026"}})
    assert simulated.count("SIMULATED data (a program") == 1
    assert "Measured data" not in simulated
    assert "June 2026" in simulated


@pytest.mark.parametrize("table_name", ["constants", "lack_of_fit", "law_verdicts", "run-list"])
def test_each_verdict_has_a_look_of_its_own(table_name: str) -> None:
    """Otherwise `no other law` would look as bad as `no`."""
    declaration = _shown_tables()[table_name]
    model = TABLES[declaration.get("model", table_name)]
    assert declaration["columns"]["verdict"]["is_verdict"]
    assert set(model["verdict"].allowed) <= _LOOK_BY_VERDICT.keys()


def test_page_of_a_release_says_which(text: str) -> None:
    assert '<dd id="release">not released</dd>' in text
    assert '<dd id="release">v1-0123456789ab</dd>' in with_release(text, "v1-0123456789ab")


@pytest.mark.slow
def test_names_of_users_are_shown_as_they_are_written(write_of_one_oil: Write) -> None:
    refused = {
        **{"file": "mu-run3.csv", "run_id": "mu-run3.csv:um R2", "rule": "stuck", "oil": "mu oil"},
        **{"reason": "the mu of 'mu [degC]' of mu oil is >= 1", "advice": "Log mu-run3.csv again"},
    }
    unread = {"file": "S 5 lambda.csv", "rule": "unreadable", "reason": "no mu", "advice": "-"}
    page = Page(write_of_one_oil(quarantine=rows("quarantine", refused, unread)))
    assert "mu-run3.csv:um R2: stuck" in page.text
    # the sentence has the symbols of print, the names have not
    assert "The \u03bc of 'mu [degC]' of mu oil is \u2265 1" in page.text
    assert "Log mu-run3.csv again" in page.text
    assert "S 5 lambda.csv: unreadable. No \u03bc." in page.text
