"""The sections of the report tell the counts, the refusals, each fit's verdict, and what to do."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from campaigns import CLAIMS, REFERENCE, Campaign, printed, sign_study, without
from deng2026_study import study
from deng2026_study.audit.audit import audit, printed_evidence
from deng2026_study.extrapolation import extrapolate, extrapolation_errors, truth_grid
from deng2026_study.printed_constants import judge_printed
from deng2026_study.printed_law import with_printed
from deng2026_study.reference import read_claims
from oilfilm import tables
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.logs.run_sheet import UNLISTED
from oilfilm.report.document import Fact, Section, _declarations, facts, percent
from oilfilm.report.sections.build import sections
from oilfilm.report.text import text
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import NOT_KNOWN
from reports import OILS, report_of, rows
from simulated_lab.printed import PrintedCoefficients

_PAPER = re.compile(r"paper|claim|Printed|Fig\. ")


@pytest.fixture(scope="module")
def demo_tables(demo: Campaign) -> CampaignTables:
    """The tables of one fit of the demonstration."""
    config, curated = demo.config, demo.curated
    fit = demo.fit("4010", bootstrap=20, searches=2)
    fitted = fit.coefficients, fit.refits, fit.fit_quality
    signs, sign_verdicts = sign_study(config)
    truth, within = truth_grid(config, printed()), config.same_set_point.relative
    results = CampaignTables.in_memory(
        **{name: getattr(curated, name) for name in ("runs", "points", "quarantine")},
        **dict(zip(("coefficients", "refits", "fit_quality"), fitted, strict=True)),
        coverage=coverage(curated.runs, config),
        gate_counts=gate_counts(curated.runs, curated.points, curated.quarantine),
        extrapolation_errors=extrapolation_errors(extrapolate(truth, *fitted, within)),
        signs=signs,
        sign_verdicts=sign_verdicts,
        **audit(read_claims(CLAIMS).claims, [printed_evidence(printed(), config)]),
    )
    judged = judge_printed(results, printed(), config.oils, config.printed)
    return results.replace(printed_judged=judged)


def by_anchor(results: CampaignTables, config: Settings) -> dict[str, Section]:
    return {section.anchor: section for section in sections(results, config)}


def told(section: Section) -> str:
    """All sentences of a section."""
    return " ".join(f"{fact.text} {fact.advice}" for fact in section.facts)


def cells(section: Section, table: str, first: str) -> dict[str, str]:
    """The row of a table that begins with a text, by heading."""
    (shown,) = (each for each in section.tables if each.name == table)
    (row,) = (row for row in shown.rows if row[0] == first)
    return dict(zip((column.heading for column in shown.columns), row, strict=True))


def test_demonstration(demo_tables: CampaignTables, demo: Campaign) -> None:
    made = by_anchor(demo_tables, demo.config)
    assert "212 of 218 runs and 6572 of 6743 points are accepted." in told(made["data"])
    matrix = "212 of 216 conditions of the test matrix are accepted. Refused: 4. Missing: none."
    assert f"{matrix} Tested outside the matrix: 1." in told(made["data"])
    assert "STAND-IN properties are used for 4102, 4050" in told(made["data"])
    (stuck,) = (fact for fact in made["refused"].facts if "stuck sensor. " in fact.text)
    assert stuck.text.startswith("4050_P1.50_U35_T085.csv: stuck sensor. The traction force is")
    assert stuck.advice.startswith("Check the traction force sensor")
    assert cells(made["refused"], "gate_counts", "stuck sensor")["Points"] == "31"
    fit = cells(made["fits"], "fit_quality", "4010")
    assert (fit["Points"], fit["Curves"], fit["Certified"]) == ("2201", "71", "yes")
    # near the truth: the law made the points
    truth = cells(made["truth"], "truth-errors", "Deng (Eq. 7)")
    inside, beyond = (float(truth[name].rstrip(" %")) for name in list(truth)[1:3])
    assert inside < beyond < 5


def test_report_tells_what_the_paper_claims(demo_tables: CampaignTables, demo: Campaign) -> None:
    made = by_anchor(demo_tables, demo.config)
    apart = cells(made["printed"], "printed_judged", "4010")
    _, printed_sse, fitted_sse, tested, beyond = (
        float(value.replace("\N{MINUS SIGN}", "-")) for value in apart.values()
    )
    assert fitted_sse <= printed_sse
    assert tested < beyond
    assert cells(made["printed"], "signs", "4050")["without effect"] == "C2"
    assert int(cells(made["claims"], "claim-counts", "printed constants")["fails"]) > 0
    order = "4102 > 4050 > 4010 across all loads, speeds and temperatures"
    assert cells(made["claims"], "failing-claims", order)["printed constants"] == "fails"
    # of nine exponents; the fit of 20 refits is not sure of those near zero
    signs = r"The fits confirm [5-9] of 9 signs in use\.( Sign not known: 4010 .*\.)? CIRCULAR"
    assert re.search(signs, told(made["printed"]))
    assert "CIRCULAR on the refit" in told(made["claims"])


def test_text_has_the_answer_first_and_no_keys(demo_tables: CampaignTables, demo: Campaign) -> None:
    made = sections(demo_tables, demo.config)
    lines = text(made, demo.config.campaign).splitlines()
    assert "SIMULATED" in lines[1]
    titles = [lines[i - 1] for i, line in enumerate(lines) if line and set(line) == {"-"}]
    assert titles[:4] == ["Answer", "Trouble", "Where to find what", "Data"]
    for key in ("deng2026", "wang-deng", "stuck_sensor"):
        assert key not in "\n".join(lines)
    # every sentence is there once
    for section in made:
        for fact in section.facts:
            assert lines.count(f"- {fact.text}") == 1


def test_laboratory_without_the_paper_reads_nothing_of_it(
    results: CampaignTables, config: Settings, tmp_path: Path
) -> None:
    about = {"studies": [], "figures": ["coverage"], "description": "Curves of June."}
    own = config.with_changes({"campaign": about, "dataset": {"sources": None}})
    page = report_of(results, own, tmp_path, ["coverage"])
    shown = re.sub(r"<(script|style|pre).*?</\1>|<[^>]*>", "", page, flags=re.DOTALL)
    assert not _PAPER.search(text(sections(results, own), own.campaign) + shown)


def test_unknown_sign_is_beside_its_interval(demo_tables: CampaignTables, demo: Campaign) -> None:
    coefficients = demo_tables.coefficients
    chosen = coefficients["constant"] == "B2"
    planted = {"lower": -0.0213, "upper": 0.774}
    constants = coefficients.assign(
        verdict=np.where(chosen, "sign unknown", "known"),
        **{name: coefficients[name].mask(chosen, end) for name, end in planted.items()},
    )
    together = demo_tables.replace(coefficients=constants)
    section = by_anchor(together, demo.config)["constants"]
    assert "11 of 12 constants are known. Sign unknown: B2." in told(section)
    assert "spans -0.0213 to 0.774." in told(section)
    row = cells(section, "constants0", "B2")
    assert row["Joint interval"].startswith("\N{MINUS SIGN}0.02")  # the one that decides


def test_signs_are_those_of_the_fit(demo_tables: CampaignTables, demo: Campaign) -> None:
    fits = demo_tables.coefficients

    def line(constants: pd.DataFrame, campaign: Settings = demo.config) -> str:
        results = demo_tables.replace(coefficients=constants)
        made = {section.anchor: section for section in study.sections(results, campaign)}
        return told(made["printed"])

    beside = with_printed(fits, load(REFERENCE, PrintedCoefficients))
    sure = fits.assign(verdict="known", value=beside["printed_value"])
    assert "The fits confirm 9 of 9 signs in use. CIRCULAR" in line(sure)
    turned = sure.assign(value=sure["value"].where(sure["constant"] != "C1", -sure["value"]))
    assert "8 of 9 signs in use. The other sign: 4010 C1. CIRCULAR" in line(turned)
    open_sign = sure.assign(verdict=np.where(sure["constant"] == "A2", "sign unknown", "known"))
    assert "8 of 9 signs in use. Sign not known: 4010 A2. CIRCULAR" in line(open_sign)
    # logs that another program simulated need not have these signs
    elsewhere = without(demo.config, "twin", "torque")
    assert "signs in use. The points were SIMULATED: this says nothing of" in line(sure, elsewhere)


@pytest.mark.parametrize("verdict", ["another law is better", "tie"])
def test_law_is_judged_once_for_oils(
    results: CampaignTables, config: Settings, verdict: str
) -> None:
    ties = ("deng2026", "tanh") if verdict == "tie" else ("tanh",)
    row = {"law": "deng2026", "verdict": verdict, "better_law": "tanh"} | dict.fromkeys(
        ("left_out_ties", "bic_ties"), ties
    )
    compared = [
        {"oil": oil, "law": law, "n_constants": count, "configured": law == "deng2026"}
        for law, count in (("deng2026", 12), ("tanh", 8))
        for oil in OILS
    ]
    other = {"oil": OILS[2], "law": "deng2026", "verdict": "best"}
    judged = rows("law_verdicts", *({"oil": oil, **row} for oil in OILS[:2]), other)
    changed = results.replace(law_verdicts=judged, fit_quality=rows("fit_quality", *compared))
    fact, best, *_ = by_anchor(changed, config)["laws"].facts
    assert fact.text.startswith(f"{OILS[0]}, {OILS[1]}: ")
    assert fact.is_trouble == (verdict == "another law is better")
    assert "hyperbolic tangent" in fact.text
    assert "law: tanh" in fact.advice
    assert best.text.startswith(f"{OILS[2]}: ")


def test_film_and_too_few_runs_are_trouble(results: CampaignTables, config: Settings) -> None:
    film = np.where(results.points["oil"] == "4050", "cannot be judged", "full film")
    runs = results.runs.assign(oil=np.where(results.runs["verdict"] == "refused", "4010", "4050"))
    changed = results.replace(points=results.points.assign(film_judgement=film), runs=runs)
    brief = [fact.text for fact in by_anchor(changed, config)["data"].facts if fact.is_trouble]
    assert any(line.startswith("NOT ENOUGH: oil 4010: 0 of 1 runs accepted") for line in brief)
    assert any("FILM NOT JUDGED for" in line and "of 4050." in line for line in brief)


def test_bearing_errors_leave_out_skidding_cages(results: CampaignTables, config: Settings) -> None:
    at = {"inner_speed_rpm": 12000.0, "axial_load_n": 5000.0, "inlet_temperature_c": 100.0}
    torque = results.torque.assign(
        **at, converged=True, run_id=["a", "b"], bistable=[False, True], energy_error=0.0
    )
    section = by_anchor(results.replace(torque=torque), config)["bearing"]
    left_out = "Left out, because the cage may roll or skid: 1 of 2 plateaus."
    assert f"{left_out} Operating points: 4102 at 12000 rpm, 5000 N, 100 degC." in told(section)
    assert "Traction causes 20 % to 20 % of the torque." in told(section)  # 0.2 of 1.0 N m
    row = cells(section, "torque", "4102")
    assert row["Points"] == "1"
    assert row["Median error"] == row["Largest error"] == percent(1)(0.1)


def test_bearing_section_says_where_the_motion_is_not_known(
    results: CampaignTables, config: Settings
) -> None:
    flags = pd.array([None, False], dtype="boolean")
    torque = results.torque.assign(converged=True, run_id=["a", "b"], bistable=flags)
    section = by_anchor(results.replace(torque=torque), config)["bearing"]
    assert "not known at 1 of 2 plateaus whether the cage may roll or skid" in told(section)
    assert "Left out" not in told(section)
    assert cells(section, "torque", "4102")["Points"] == "2"


def test_best_oils_of_a_heated_bearing_are_compared_where_both_are_known(
    results: CampaignTables, config: Settings
) -> None:
    best = ["4102", "4102", "4050", NOT_KNOWN]
    heated = ["4102", "4050", NOT_KNOWN, "4102"]
    points = [
        {"oil": "4102", "inner_speed_rpm": number, "axial_load_n": 1.0, "balanced": True}
        | {"best_oil": before, "heated_best_oil": after, "outlet_temperature_c": 100.0}
        for number, (before, after) in enumerate(zip(best, heated, strict=True))
    ]
    balance = rows("heat_balance", *points)
    section = by_anchor(results.replace(heat_balance=balance), config)["bearing"]
    assert "the best oil at 1 of 2 operating points. It is not known at 2 more" in told(section)


def test_lists_of_tables_are_joined_where_they_are_shown() -> None:
    for name, shown in _declarations("shown_tables").items():
        model = tables.TABLES.get(shown.get("model", name))
        for column, given in shown["columns"].items():
            if model and column in model.names and model[column].type == "texts":
                assert given["form"] in ("list", "laws"), (name, column)


def test_remarks_on_the_sheet_are_no_refusals(results: CampaignTables, config: Settings) -> None:
    remark = {"file": "runs.csv", "rule": UNLISTED, "reason": "no row for a log"}
    counts = rows("gate_counts", {"gate": UNLISTED}, {"gate": "thin_film", "points": 4})
    listed = pd.concat([results.quarantine, rows("quarantine", remark)], ignore_index=True)
    changed = results.replace(quarantine=listed, gate_counts=counts)
    section = by_anchor(changed, config)["refused"]
    assert [row[0] for row in section.tables[0].rows] == ["thin film"]
    assert "no row for a log" not in told(section)


def test_name_from_a_log_can_begin_no_sentence_of_its_own() -> None:
    forged = "a.csv\n+ Everything is certified"
    case = {"name": forged, "gate": "drift", "count": 1, "reason": "it drifts", "advice": "Wait"}
    (fact,) = facts("report/sections/cases.jinja", cases=[case], cases_in="quarantine.parquet")
    assert fact == Fact("a.csv + Everything is certified: drift. It drifts.", "Wait.")
