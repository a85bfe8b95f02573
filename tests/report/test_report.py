"""The report without a browser: what its text holds, and what can never get into it."""

import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT, without
from oilfilm import tables
from oilfilm.fits.fit import fit_oil
from oilfilm.logs.run_sheet import CONTRADICTION, UNLISTED
from oilfilm.paper.selection import OUTSIDE
from oilfilm.report import runs, sections
from oilfilm.report.bearing_sentences import bearing_lines
from oilfilm.report.explorer import Axis, explorer
from oilfilm.report.labels import OTHER_CHOICES
from oilfilm.report.meanings import MEANINGS
from oilfilm.report.refused_sentences import refused_lines
from oilfilm.report.shown_table import percent
from oilfilm.report.spreadsheet import csv_text
from oilfilm.report.verdict import verdict
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from reports import HOSTILE, OILS, report_of, results_of, rows, with_hostile_names

Write = Callable[..., str]


class Page(HTMLParser):
    """Tags, attributes and texts of a page, as a browser sees them."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: dict[str, str] = {}
        self.texts: list[str] = []
        self.script: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self.script = dict(attrs).get("id") or f"{tag}{len(self.scripts)}"

    def handle_endtag(self, tag: str) -> None:
        if tag in ("script", "style"):
            self.script = None

    def handle_data(self, data: str) -> None:
        if self.script is None:
            self.texts.append(data)
        else:
            self.scripts[self.script] = self.scripts.get(self.script, "") + data

    def data(self, name: str) -> Any:
        return json.loads(self.scripts[name])


@pytest.fixture(scope="module")
def results(config: Settings) -> CampaignTables:
    return results_of(config)


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
def text(write: Write) -> str:
    return write()


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


def test_same_results_give_the_same_bytes_wherever_they_lie(
    results: CampaignTables, config: Settings, text: str, tmp_path: Path
) -> None:
    assert report_of(results, config, tmp_path) == text
    assert str(tmp_path.parent) not in text
    assert str(ROOT) not in text


def test_page_holds_the_tables_themselves(page: Page, results: CampaignTables) -> None:
    downloads = page.data("downloads")
    assert downloads["coefficients.csv"] == csv_text(results.coefficients)
    assert downloads["quarantine.csv"] == csv_text(results.quarantine)
    kept = pd.DataFrame(json.loads(downloads["coefficients.json"]))
    for name in ("value", "standard_error", "lower", "upper"):
        assert kept[name].tolist() == results.coefficients[name].tolist()
    for oil in page.data("explorer-data")["oils"]:
        own = results.points[results.points["oil"] == oil["name"]]
        for name in ("slide_roll_ratio", "inlet_temperature_c", "traction_coefficient"):
            assert oil["points"][name] == own[name].tolist()
        runs = [oil["points"]["runs"][number] for number in oil["points"]["run"]]
        assert runs == own["run_id"].tolist()


def test_page_asks_the_network_for_nothing(page: Page) -> None:
    addresses = [
        value
        for tag, attributes in page.tags
        for name, value in attributes.items()
        if name in ("src", "href", "srcset", "action", "data", "poster") and value
    ]
    assert len(addresses) > 10
    assert all(address.startswith(("#", "data:")) for address in addresses)
    assert not [tag for tag, _ in page.tags if tag in ("iframe", "object", "embed", "base", "form")]
    styles = page.scripts["style0"]
    assert "url(" not in styles
    assert "@import" not in styles
    policy = next(a["content"] for tag, a in page.tags if tag == "meta" and "http-equiv" in a)
    assert "default-src 'none'" in str(policy)
    assert "unsafe-eval" not in str(policy)
    assert "script-src 'sha256-" in str(policy)


def test_hostile_names_are_text(
    results: CampaignTables, config: Settings, page: Page, tmp_path: Path
) -> None:
    about = {"title": HOSTILE[1], "creators": [HOSTILE[2], HOSTILE[3]], "licence": "MIT"}
    changed = {"log": "data/raw/june/a.csv", "was": "0" * 16, "now": "1" * 16, "reason": HOSTILE[0]}
    changes = {
        "campaign": {"description": HOSTILE[0]},
        "dataset": {
            **about,
            "sources": [{"title": HOSTILE[1]}],
            "acknowledged_changes": [changed],
        },
    }
    named = with_hostile_names(results)
    hostile = Page(report_of(named, config.with_changes(changes), tmp_path))
    assert {tag for tag, _ in hostile.tags} == {tag for tag, _ in page.tags}
    assert len(hostile.scripts) == len(page.scripts)
    handlers = {
        name for _, attributes in hostile.tags for name in attributes if name.startswith("on")
    }
    assert not handlers
    texts = "".join(hostile.texts)
    for name in HOSTILE:
        assert name in texts
    assert "49" not in {text.strip() for text in hostile.texts}
    runs = [run for oil in hostile.data("explorer-data")["oils"] for run in oil["points"]["runs"]]
    assert set(HOSTILE) <= set(runs)


def test_verdict_is_a_few_lines_with_the_numbers(results: CampaignTables, config: Settings) -> None:
    lines = dict(verdict(results, sections.certainty(results), config))
    assert list(lines) == ["Data", "Fit", "Law", "Noise", "Error", "Trouble", "Paper"]
    assert "SIMULATED" in lines["Data"]
    assert "54 of 55 runs and 1674 of 1674 points" in lines["Data"]
    assert all(oil in lines["Fit"] for oil in OILS)
    assert "1 run refused (stuck sensor)" in lines["Trouble"]
    assert "1 log without a run (unreadable)" in lines["Trouble"]
    assert "STAND-IN" in lines["Trouble"]
    assert "holds 1." in lines["Paper"]
    assert "20.0 % in the median, 30.0 % at worst" in lines["Paper"]  # of 0.1 and -0.3


def test_best_law_is_on_the_first_screen_with_the_meaning_of_each_word(
    write: Write, results: CampaignTables, config: Settings
) -> None:
    verdict_of_law = {"oil": "4102", "law": "deng2026", "verdict": "another law is better"}
    judged = rows(
        "law_verdicts",
        verdict_of_law
        | {
            "better_law": "tanh",
            "bic_ties": "tanh",
            "left_out_ties": "tanh",
            "bic_difference": 1515.0,
        },
    )
    misfit = {"verdict": "shown", "lack_of_fit_relative_rms": 0.0275}
    noise = rows("lack_of_fit", {"oil": "4102"} | misfit)
    quality = results.fit_quality
    tanh = quality[(quality["oil"] == "4102") & quality["configured"]].assign(law="tanh")
    fits = pd.concat([quality, tanh.assign(configured=False)], ignore_index=True)
    lines = dict(
        verdict(
            results.replace(law_verdicts=judged, lack_of_fit=noise, fit_quality=fits),
            sections.certainty(results),
            config,
        )
    )
    assert lines["Law"].startswith("4102: tanh describes the data better than the configured law")
    assert "`fit: {law: tanh}`" in lines["Law"]
    assert "lack of fit of the law is 2.75%" in lines["Noise"]
    page = write(law_verdicts=judged, lack_of_fit=noise, fit_quality=fits)
    first = page[page.index('<section id="verdict"') : page.index('<section id="constants"')]
    assert "1515" in first
    for word in ("certified", "BIC", "curves left out"):
        assert f"<dt>{word}</dt><dd>{MEANINGS[word]}" in first


def test_page_of_own_oils_has_no_claims_no_advice_and_no_print(
    write: Write, results: CampaignTables, config: Settings
) -> None:
    plain = results.coefficients.assign(printed_value=np.nan)
    none = results.claims[:0]
    lines = dict(verdict(results.replace(claims=none), sections.certainty(results), config))
    assert "Paper" not in lines
    # what a bearing's torque comes to is no matter of the paper
    assert "30.0" in lines["Bearing"]
    rules = [rule.model_copy(update={"prefer": ["other"]}) for rule in config.selection.rules]
    own = {"selection": {"rules": [rule.model_dump() for rule in rules]}}
    page = Page(write(own, claims=none, coefficients=plain))
    assert not [a for _, a in page.tags if a.get("href") == "#claims" or a.get("id") == "claims"]
    assert "claims.csv" not in page.data("downloads")
    texts = "".join(page.texts)
    assert "Printed" not in texts
    assert not page.data("explorer-data")["advised"]


def test_verdict_tells_what_was_measured_and_refused_from_what_has_no_run(
    results: CampaignTables, config: Settings
) -> None:
    states = ("accepted", "refused", "missing")
    conditions = [
        {"oil": oil, "state": state, "planned": True, "nominal_inlet_temperature_c": level}
        for oil in OILS[:2]
        for level, state in zip((25.0, 70.0, 120.0), states, strict=True)
    ]
    covered = results.replace(coverage=rows("coverage", *conditions))
    line = dict(verdict(covered, sections.certainty(results), config))["Data"]
    assert "2 of 6 planned conditions covered, 2 measured and refused, 2 without a run that" in line
    assert "never measured" not in line


def test_oil_that_was_not_fitted_is_named_and_not_counted(
    results: CampaignTables, config: Settings
) -> None:
    empty = results.points.assign(accepted=False)
    lost = fit_oil(empty, "4010", config.fit, config.seed)
    kept = {
        name: pd.concat([table[table["oil"] != "4010"], getattr(lost, name)])
        for name, table in (
            ("coefficients", results.coefficients),
            ("fit_quality", results.fit_quality),
        )
    }
    changed = results.replace(**kept)
    lines = dict(verdict(changed, sections.certainty(changed), config))
    assert "of 3 fits" not in lines["Fit"]
    assert lines["Fit"].endswith("; not fitted: 4010.")
    # two fits of twelve constants
    assert "of 24 constants known" in lines["Error"]
    assert "not identifiable" not in lines["Error"]


def test_trouble_names_oils_without_a_film_and_too_few_runs(
    results: CampaignTables, config: Settings
) -> None:
    film = np.where(results.points["oil"] == "4050", "cannot be judged", "full film")
    runs = results.runs.assign(oil=np.where(results.runs["verdict"] == "refused", "4010", "4050"))
    changed = results.replace(points=results.points.assign(film_judgement=film), runs=runs)
    line = dict(verdict(changed, sections.certainty(results), config))["Trouble"]
    assert line.startswith("TOO FEW ACCEPTED RUNS (oil 4010: 0 of 1 runs accepted")
    assert line.endswith("film thickness NOT JUDGED for 4050.")


def test_verdict_says_why_no_claim_is_judged(results: CampaignTables, config: Settings) -> None:
    why = "cannot be checked: the campaign has none of the oils"
    unjudged = results.claims.assign(verdict="cannot be checked", finding=why)
    lines = dict(verdict(results.replace(claims=unjudged), sections.certainty(results), config))
    assert lines["Paper"] == (
        "No claim of the paper is judged on this campaign's fits: "
        "the campaign has none of the oils."
    )


def test_report_says_what_simulated_torque_and_ties_are_worth(
    write: Write, results: CampaignTables, config: Settings
) -> None:
    control = rows(
        "torque_control",
        {"oil": "4102", "verdict": "positive control", "law_misfit": 0.0, "n_plateaus": 2}
        | {"median_torque_error": 0.003, "largest_torque_error": 0.018},
    )
    page = write(torque_control=control)
    assert "Controls: what the comparison with SIMULATED torque shows" in page
    assert "Wang-Deng here: a tie by construction" in page
    changed = results.replace(torque_control=control)
    line = dict(verdict(changed, sections.certainty(results), config))["Paper"]
    assert "CIRCULAR on the refit" in line
    assert "positive control: the fitted law itself made the SIMULATED logs" in line
    assert "4102 0.3%, 1.8%" in line
    # as if it had been measured
    measured = without(config, "twin", "torque").with_changes({"campaign": {"data": "measured"}})
    line = dict(verdict(results, sections.certainty(results), measured))["Paper"]
    assert "CIRCULAR" not in line
    assert re.search(
        r"pressure-based law is off by 20.0\s% in the median, 30.0\s% at worst\.$", line
    )


def test_bearing_errors_leave_out_and_name_where_the_cage_may_skid(
    results: CampaignTables,
) -> None:
    at = {"inner_speed_rpm": 12000.0, "axial_load_n": 5000.0, "inlet_temperature_c": 100.0}
    torque = results.torque.assign(
        **at, converged=True, run_id=["a", "b"], bistable=[False, True], energy_error=0.0
    )
    changed = results.replace(torque=torque)
    lines = bearing_lines(changed)
    assert any(
        line.startswith("| pressure-based    | 10.0            | 10.0             |")
        for line in lines
    )
    left_out = "- Left out, because the cage may roll or skid: 1 of 2 plateaus."
    assert f"{left_out} Operating points: 4102 at 12000 rpm, 5000 N, 100 degC." in lines
    ((*about, median, largest, _, _),) = sections.torque(changed).rows
    assert about == ["4102", "pressure-based", "1"]
    assert median == largest == percent(1)(0.1)


def test_constants_show_the_interval_that_decides_on_their_sign(write: Write) -> None:
    assert "Joint interval" in write()


def test_certainty_is_half_the_interval_over_mu(results: CampaignTables) -> None:
    # curves with 1 % gain errors, 18 of them, and a calibration of 0.5 % of load, 1 % of mu or less
    median, largest = sections.certainty(results).loc["4102"]
    assert 0.005 < median < 0.06
    assert median < largest


def test_data_that_could_not_be_fitted_make_a_page(write: Write, results: CampaignTables) -> None:
    nothing = results.coefficients.assign(
        **dict.fromkeys(["value", "standard_error", "lower", "upper"], np.nan),
        identifiable=False,
        verdict="not identifiable",
    )
    empty = ("refits", "points", "runs", "quarantine", "claims", "torque")
    page = Page(
        write(
            coefficients=nothing,
            fit_quality=results.fit_quality.assign(rmse=np.nan, certified=False),
            **{name: results.table(name)[:0] for name in empty},
        )
    )
    text = "".join(page.texts)
    assert "Nothing could be fitted." in text
    assert "No fit can be explored here." in text
    assert "No log, run or row was refused." in text


def test_fit_without_refits_has_no_interval(results: CampaignTables, config: Settings) -> None:
    content = explorer(results.replace(refits=results.refits[:0]), config)
    assert [oil["root"] for oil in content["oils"]] == [None] * 3


def test_condition_without_exponents_moves_no_slider(
    results: CampaignTables, config: Settings
) -> None:
    lost = results.coefficients["constant"].isin(["A2", "B2", "C2"])
    table = results.coefficients.assign(value=results.coefficients["value"].mask(lost))
    content = explorer(results.replace(coefficients=table, refits=results.refits[:0]), config)
    assert [axis["idle"] for axis in content["axes"]] == [False, True, False, False]
    assert [oil["known"] for oil in content["oils"]] == [[True, False, True]] * 3


def test_endless_interval_is_none_in_json(write: Write, results: CampaignTables) -> None:
    endless = results.coefficients.assign(upper=np.inf)
    page = Page(write(coefficients=endless))
    kept = json.loads(page.data("downloads")["coefficients.json"], parse_constant=pytest.fail)
    assert {row["upper"] for row in kept} == {None}
    assert [row["value"] for row in kept] == results.coefficients["value"].tolist()


def test_page_stays_below_its_limit_and_says_what_it_leaves_out(write: Write, text: str) -> None:
    pictures = sum(map(len, re.findall(r'(?:src|href)="(data:image[^"]+)"', text)))
    bare = len(text.encode()) - pictures
    page = write({"report": {"size_max_mb": (bare + 100) / 1e6}})
    assert len(page.encode()) <= bare + 100
    assert "figures/fig02.png" in page
    assert len(text.encode()) < 8e6


def test_endless_list_of_refusals_is_left_out_of_the_page(write: Write, text: str) -> None:
    about = {"rule": "unreadable", "reason": "no data", "advice": "Log again."}
    many = rows("quarantine", *({"file": f"{n:05}.csv", **about} for n in range(20_000)))
    assert len(csv_text(many)) > 600_000
    size_max = len(text.encode()) + 300_000
    page = write({"report": {"size_max_mb": size_max / 1e6}}, quarantine=many)
    assert len(page.encode()) <= size_max
    assert 'data-save="quarantine.csv"' not in page
    assert "tables/quarantine.csv" in page
    assert page.count("data:image/png") == text.count("data:image/png")


def test_many_points_and_refusals_are_thinned_and_counted(write: Write) -> None:
    page = Page(write({"report": {"points_max": 500, "rows_max": 1}}))
    content = page.data("explorer-data")
    shown = content["points"]["shown"]
    assert sum(len(oil["points"]["run"]) for oil in content["oils"]) == shown <= 500
    text = " ".join("".join(page.texts).split())
    assert f"Of 1674 accepted points this page holds {shown}" in text
    assert "And 1 more rows" in text


@pytest.mark.parametrize(
    ("low", "high", "step"),
    [(0.8, 2.5, 0.01), (20, 200, 1), (0.0, 0.3, 0.001), (0.0249, 0.0251, 1e-6), (0.5, 100.0, 0.1)],
)
def test_slider_covers_its_range_in_round_steps(low: float, high: float, step: float) -> None:
    axis = Axis.over("x", low, high, (low + high) / 2)
    assert axis.step == pytest.approx(step)
    assert axis.values[0] <= low * (1 + 1e-12)
    assert axis.values[0] > 0 or low == 0
    assert axis.values[-1] >= high * (1 - 1e-12)
    assert len(axis.values) < 2000


def test_comparison_of_laws_says_that_the_papers_law_made_the_logs(write: Write) -> None:
    thermal = {"campaign": resolve(ROOT / "config", {"campaign": "thermal"}).plain()["campaign"]}
    assert "Wang-Deng here: a tie by construction" in write()
    assert "Wang-Deng here: a tie by construction" not in write(thermal)


def test_measured_campaign_does_not_say_simulated(write: Write) -> None:
    measured = {"campaign": {"data": "measured"}}
    text = write(measured)
    assert "SIMULATED data" not in text
    assert "Measured data" in text
    assert "not stated in the campaign file" in text
    assert "June 2026" in write(measured | {"dataset": {"date": "June 2026"}})


def test_remarks_on_the_run_sheet_are_not_among_what_was_refused(
    write: Write, results: CampaignTables
) -> None:
    remark = {"file": "runs.csv", "rule": UNLISTED, "reason": "no row for a log"}
    counts = rows("gate_counts", {"gate": UNLISTED}, {"gate": "thin_film", "points": 4})
    listed = pd.concat([results.quarantine, rows("quarantine", remark)], ignore_index=True)
    assert sections.refused(listed, "quarantine", "", 10).rows == (
        sections.refused(results.quarantine, "quarantine", "", 10).rows
    )
    shown = sections.gates(results.replace(gate_counts=counts))
    assert [row[0] for row in shown.rows] == ["thin film"]
    assert refused_lines(rows("quarantine", remark), "quarantine") == []


def test_page_of_a_refused_run_has_the_advice_of_the_rule_that_refused_it(
    results: CampaignTables,
) -> None:
    about = {"run_id": "stuck.csv", "file": "stuck.csv"}
    remark = rows("quarantine", {**about, "rule": CONTRADICTION, "advice": "Correct the sheet."})
    quarantine = pd.concat([remark, results.quarantine], ignore_index=True)
    refused = results.runs[results.runs["run_id"] == "stuck.csv"]
    (page,) = runs.run_pages(results.replace(quarantine=quarantine), refused, {})["runs"]
    assert page["advice"] == "Check the sensor."


def test_every_judgement_on_the_advice_that_differs_has_a_sentence() -> None:
    (allowed,) = (
        column.allowed
        for column in tables.TABLES["slip_advice"].columns
        if column.name == "judgement"
    )
    assert set(allowed) == {"agree", "no film", OUTSIDE, *OTHER_CHOICES}


def test_bearing_is_shown_in_tables_with_a_quantity_in_each_row(results: CampaignTables) -> None:
    torque = results.torque.assign(converged=[True, False], why=["", "no equilibrium"])
    advice = rows(
        "slip_advice",
        {"judgement": "agree", "best_oil": "4102"},
        {"judgement": "heats more", "best_oil": "4010"},
        {"judgement": "no film"},
    )
    numbers, choice = sections.bearing(results.replace(torque=torque, slip_advice=advice))
    values = {quantity: value for quantity, value, _ in numbers.rows}
    assert values["Torque logs read"] == "1 of 2"
    assert values["Equilibria not found"] == "1 of 2"
    assert values["Reason"] == "no equilibrium"
    assert values["Share of traction in the torque"] == "20 % to 20 %"  # 0.2 of 1.0 N m
    assert choice.rows[0][:2] == ("The advice agrees with the best oil", "1 of 2")
    assert not [cell for row in (*numbers.rows, *choice.rows) for cell in row if "->" in cell]


def test_page_names_laws_and_gates_in_words(write: Write) -> None:
    page = Page(write())
    texts = "".join(page.texts[: page.texts.index("Configuration as resolved")])
    assert "Johnson-Tevaarwerk (Eyring)" in texts
    assert "stuck sensor" in texts
    assert "deng2026" not in texts
    assert "stuck_sensor" not in texts


def test_runs_that_share_a_log_are_told_apart() -> None:
    shown = sections.refused(
        rows("quarantine", {"file": "a.csv", "run_id": "a.csv#2"}), "quarantine", "", 10
    )
    assert [column.heading for column in shown.columns][:2] == ["Log", "Run"]
