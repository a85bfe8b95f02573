"""The sections of the report tell the counts, the refusals, each fit's verdict, and what to do."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from jinja2 import FileSystemLoader

from campaigns import ROOT
from nights import nightly
from oilfilm import tables
from oilfilm.fits.certificate_sentences import certificate_sentence
from oilfilm.logs.run_sheet import UNLISTED
from oilfilm.report.document import (
    Fact,
    _environment,
    _shown_tables,
    facts_from_template,
    percent_formatter,
)
from oilfilm.report.sections.build import (
    bearing_section,
    campaign_sections,
    data_section,
    laws_section,
    refused_section,
    relative_uncertainty,
    run_list,
)
from oilfilm.report.text import text_report
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import NOT_KNOWN
from reports import OILS, cells, report_of, rows, sentences

_PAPER = re.compile(r"paper|claim|Printed|Fig\. ")


@pytest.mark.slow
def test_laboratory_without_the_paper_reads_nothing_of_it(
    results: CampaignTables, config: Settings, tmp_path: Path
) -> None:
    about = {"studies": [], "figures": ["coverage"], "description": "Curves of June."}
    own = config.with_changes({"campaign": about, "dataset": {"sources": None}})
    page = report_of(results, own, tmp_path, ["coverage"])
    shown = re.sub(r"<(script|style|pre).*?</\1>|<[^>]*>", "", page, flags=re.DOTALL)
    assert not _PAPER.search(text_report(campaign_sections(results, own), own.campaign) + shown)


@pytest.mark.parametrize("verdict", ["another law is better", nightly("tie")])
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
    fact, best, *_ = laws_section(changed, config).facts
    assert fact.text.startswith(f"{OILS[0]}, {OILS[1]}: ")
    assert fact.is_trouble == (verdict == "another law is better")
    assert "hyperbolic tangent" in fact.text
    assert "law: tanh" in fact.advice
    assert best.text.startswith(f"{OILS[2]}: ")


def test_wang_deng_is_explained_where_it_is_compared(
    results: CampaignTables, demo_config: Settings
) -> None:
    for law, is_explained in (("wang-deng-load", True), ("tanh", False)):
        quality = rows("fit_quality", {"oil": OILS[0], "law": law, "configured": True})
        facts = laws_section(results.replace(fit_quality=quality), demo_config).facts
        assert any("Wang-Deng here" in fact.text for fact in facts) == is_explained


def test_a_remark_on_the_run_sheet_refuses_no_log(
    results: CampaignTables, config: Settings
) -> None:
    of_file = {"file": "two.tdms", "stage": "ingest", "reason": "-", "advice": "-"}
    quarantine = rows(
        "quarantine",
        {**of_file, "rule": "sheet_row_unmatched"},
        {**of_file, "run_id": "two.tdms:1", "rule": "columns"},
    )
    facts = refused_section(results.replace(quarantine=quarantine), config).facts
    text = " ".join(fact.text for fact in facts)
    assert "columns 1" in text
    assert "sheet row unmatched" not in text


def test_runs_lead_to_their_own_signals_or_points() -> None:
    page = {"rule": "stuck", "reason": "-", "advice": "-"}
    shown = CampaignTables.from_frames(
        runs=rows(
            "runs",
            {"run_id": "1", "file": "june/1", "verdict": "accepted"},
            {"run_id": "2", "file": "june/2", "verdict": "refused"},
            {"run_id": "3", "file": "june/3", "verdict": "refused"},
        ),
        points=rows("points", {"run_id": "1", "accepted": True}),
        refused_pages=rows(
            "refused_pages",
            # a torque run of the same name
            {**page, "run_id": "1", "file": "june-torque/1", "page": "torque.png"},
            {**page, "run_id": "2", "file": "june/2", "page": "traction.png"},
            {**page, "run_id": "3", "file": "june/3", "page": ""},
        ),
    )
    runs = run_list(shown, 9)
    link_of_run = dict(zip((row[0] for row in runs.rows), runs.links, strict=True))
    assert link_of_run == {"1": "#run?name=1", "2": "#refused-traction", "3": ""}


def test_film_and_too_few_runs_are_trouble(results: CampaignTables, config: Settings) -> None:
    film = np.where(results.points["oil"] == "4050", "cannot be judged", "full film")
    runs = results.runs.assign(oil=np.where(results.runs["verdict"] == "refused", "4010", "4050"))
    changed = results.replace(points=results.points.assign(film_judgement=film), runs=runs)
    brief = [fact.text for fact in data_section(changed, config).facts if fact.is_trouble]
    assert any(line.startswith("NOT ENOUGH: oil 4010: 0 of 1 runs accepted") for line in brief)
    assert any(line.startswith("FILM NOT JUDGED") and "4050" in line for line in brief)


def test_bearing_errors_leave_out_skidding_cages(results: CampaignTables, config: Settings) -> None:
    at = {"inner_speed_rpm": 12000.0, "axial_load_n": 5000.0, "inlet_temperature_c": 100.0}
    torque = results.torque.assign(
        **at, converged=True, run_id=["a", "b"], bistable=[False, True], energy_error=0.0
    )
    section = bearing_section(results.replace(torque=torque), config)
    left_out = "Left out, because the cage may roll or skid: 1 of 2 plateaus."
    assert f"{left_out} Operating points: 4102 at 12000 rpm, 5000 N, 100 degC." in sentences(
        section
    )
    assert "Traction causes 20 % to 20 % of the torque." in sentences(section)  # 0.2 of 1.0 N m
    row = cells(section, "torque", "4102")
    assert row["Points"] == "1"
    assert row["Median error"] == row["Largest error"] == percent_formatter(1)(0.1)


def test_torque_logs_with_a_colon_in_their_names_are_counted_one_by_one(
    results: CampaignTables, config: Settings
) -> None:
    # two times of day, and two runs of one workbook
    names = {"10:15.csv": "10:15.csv", "10:30.csv": "10:30.csv", "b.xlsx:1": "b.xlsx"}
    plateaus = [
        {"run_id": run_id, "file": file, "accepted": True}
        for run_id, file in [*names.items(), ("b.xlsx:2", "b.xlsx")]
    ]
    changed = results.replace(torque_runs=rows("torque_runs", *plateaus))
    assert "3 of them have runs that were kept" in sentences(bearing_section(changed, config))


def test_bearing_section_says_where_the_motion_is_not_known(
    results: CampaignTables, config: Settings
) -> None:
    flags = pd.array([None, False], dtype="boolean")
    torque = results.torque.assign(converged=True, run_id=["a", "b"], bistable=flags)
    section = bearing_section(results.replace(torque=torque), config)
    assert "not known at 1 of 2 plateaus whether the cage may roll or skid" in sentences(section)
    assert "Left out" not in sentences(section)
    assert cells(section, "torque", "4102")["Points"] == "2"


def test_bearing_section_says_that_the_momentum_of_feed_oil_is_missing(
    results: CampaignTables, config: Settings
) -> None:
    torque = results.torque.assign(converged=True, run_id=["a", "b"], torque_n_m_uncertainty=0.1)
    for momentum_n_m, is_missing in ((np.nan, True), (0.4, False)):
        changed = results.replace(torque=torque.assign(momentum_torque_n_m=momentum_n_m))
        section = bearing_section(changed, config)
        assert ("lacks the momentum of the feed oil" in sentences(section)) == is_missing
        assert "has no uncertainty" not in sentences(section)


@pytest.mark.parametrize(
    ("bistable", "has_errors", "lacks_refits"),
    [nightly(True, False, False), (False, True, False), (False, False, True)],
)
def test_refits_are_said_to_lack_only_where_they_do(
    results: CampaignTables, config: Settings, bistable: bool, has_errors: bool, lacks_refits: bool
) -> None:
    torque = results.torque.assign(converged=True, bistable=bistable, verdict="not known")
    error = 0.1 if has_errors else np.nan
    coefficients = results.coefficients.assign(standard_error=error)
    changed = results.replace(torque=torque, coefficients=coefficients)
    assert ("has no refits" in sentences(bearing_section(changed, config))) == lacks_refits


def test_operating_point_without_a_full_film_says_so(
    results: CampaignTables, config: Settings
) -> None:
    point = {"oil": "4102", "axial_load_n": 100.0, "best_share": 0.4}
    answers = rows(
        "bearing_answers",
        {**point, "best_oil": "4102"},
        {**point, "axial_load_n": 200.0, "best_oil": ""},
    )
    section = bearing_section(results.replace(bearing_answers=answers), config)
    assert [row[-1] for row in section.tables[0].rows] == ["4102 (40%)", "none has a full film"]


def test_share_of_traction_is_told_where_the_law_has_an_equilibrium(
    results: CampaignTables, config: Settings
) -> None:
    both = [results.torque.assign(load_variable=name) for name in ("stress", "load")]
    for is_found in (True, False):
        of_stress = both[0].assign(converged=is_found)
        torque = pd.concat([of_stress, both[1].assign(converged=True)])
        section = bearing_section(results.replace(torque=torque), config)
        assert ("Traction causes" in sentences(section)) == is_found


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
    section = bearing_section(results.replace(heat_balance=balance), config)
    assert "1 of 2 operating points" in sentences(section)
    assert "at 2 more" in sentences(section)


def test_lists_of_tables_are_joined_where_they_are_shown() -> None:
    for name, shown in _shown_tables().items():
        model = tables.TABLES.get(shown.get("model", name))
        for column, given in shown["columns"].items():
            if model and column in model.column_names and model[column].type == "texts":
                assert given["form"] in ("list", "laws"), (name, column)


def test_remarks_on_the_sheet_are_no_refusals(results: CampaignTables, config: Settings) -> None:
    remark = {"file": "runs.csv", "rule": UNLISTED, "reason": "no row for a log"}
    counts = rows("gate_counts", {"gate": UNLISTED}, {"gate": "thin_film", "points": 4})
    listed = pd.concat([results.quarantine, rows("quarantine", remark)], ignore_index=True)
    changed = results.replace(quarantine=listed, gate_counts=counts)
    section = refused_section(changed, config)
    assert [row[0] for row in section.tables[0].rows] == ["thin film"]
    assert remark["reason"] not in sentences(section)


def test_lost_run_of_a_log_that_has_other_runs_is_counted(
    results: CampaignTables, config: Settings
) -> None:
    file = results.runs["file"].iloc[0]
    lost = {"file": file, "run_id": f"{file}:2", "rule": "columns", "reason": "no load"}
    listed = pd.concat([results.quarantine, rows("quarantine", lost)], ignore_index=True)
    refused = refused_section(results.replace(quarantine=listed), config)
    assert "2 runs refused: stuck sensor 1, columns 1" in sentences(refused)


def test_curve_of_unknown_temperature_hides_no_uncertainty_of_the_others(
    results: CampaignTables,
) -> None:
    points = results.points[results.points["oil"] == "4102"]
    is_unknown = points["run_id"] == points["run_id"].iloc[0]
    temperature = points["inlet_temperature_c"].mask(is_unknown)
    of_oil = results.replace(
        fit_quality=results.fit_quality[results.fit_quality["oil"] == "4102"],
        points=points.assign(inlet_temperature_c=temperature),
    )
    without_curve = of_oil.replace(points=points[~is_unknown])
    expected = relative_uncertainty(without_curve)
    assert expected.notna().all(axis=None)
    pd.testing.assert_frame_equal(relative_uncertainty(of_oil), expected)


def test_name_from_a_log_can_begin_no_sentence_of_its_own() -> None:
    forged = "a.csv\n+ Everything is certified"
    case = {"name": forged, "gate": "drift", "count": 1, "reason": "it drifts", "advice": "Wait"}
    (fact,) = facts_from_template(
        "report/sections/cases.jinja", cases=[case], cases_in="quarantine.parquet"
    )
    assert fact == Fact("a.csv + Everything is certified: drift. It drifts.", "Wait.")


def test_question_of_a_sentence_keeps_its_mark_and_is_said_once() -> None:
    quality = {"law": "deng2026", "no_fit": "no traction", "fixed_conditions": ""}
    unfitted = [{"oil": "4010", "certificate": certificate_sentence(quality)}]
    nothing: dict[str, list[str]] = {"fitted": [], "misfits": [], "without_pure_error": []}
    texts = [
        fact.text
        for fact in facts_from_template(
            "report/sections/fits.jinja", unfitted=unfitted, odd_curves=[], **nothing
        )
    ]
    (text,) = [text for text in texts if text.startswith("4010")]
    assert text.endswith("file)?")
    assert text.count("not fitted") == 1


def test_second_line_of_advice_does_not_overwrite_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "two.jinja").write_text("- the run drifts\n> wait\n> repeat the run\n", "utf-8")
    monkeypatch.setattr(_environment(), "loader", FileSystemLoader(tmp_path))
    (fact,) = facts_from_template("two.jinja")
    assert fact.advice == "Wait. Repeat the run."


def test_every_setting_that_a_sentence_names_exists(config: Settings) -> None:
    packages = ROOT / "workflow"
    texts = [path.read_text("utf-8") for path in packages.glob("*/report/sections/*.jinja")]
    texts += [path.read_text("utf-8") for path in packages.glob("*/reference/*.yaml")]
    groups = vars(config).keys() | {"audit"}
    # `(fit.oil, fit.law)` are variables of a template
    names = set(re.findall(r"[( ]([a-z_]+\.[a-z_]+)[)\n]", "".join(texts)))
    named_settings = {name for name in names if name.partition(".")[0] in groups}
    assert "fit.min_curves_for_errors" in named_settings
    for name in named_settings:
        group, _, key = name.partition(".")
        assert hasattr(getattr(config, group, None), key), name
