"""What the report of the demonstration tells, of the paper and beside it."""

import re

import numpy as np
import pandas as pd
import pytest
from claim_evidence import CLAIMS, sign_study

from campaigns import REFERENCE, Campaign, printed, without
from deng2026_study import study
from deng2026_study.audit.audit import audit, printed_evidence
from deng2026_study.extrapolation import extrapolate, extrapolation_errors, truth_grid
from deng2026_study.printed_constants import compare_printed_with_fit
from deng2026_study.printed_law import add_printed_values
from deng2026_study.reference import read_claims
from deng2026_study.settings import study_settings
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.report.document import Section
from oilfilm.report.sections.build import constants_section
from oilfilm.report.text import text_report
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from reports import by_anchor, cells, sentences
from simulated_lab.printed import PrintedCoefficients


@pytest.fixture(scope="module")
def demo_tables(demo: Campaign) -> CampaignTables:
    """The tables of one fit of the demonstration."""
    config, curated = demo.config, demo.curated
    fit = demo.fit("4010", bootstrap=20, searches=2)
    fitted = fit.coefficients, fit.refits, fit.fit_quality
    signs, sign_verdicts = sign_study(config)
    within = config.same_set_point.relative
    truth = truth_grid(config, printed())
    results = CampaignTables.from_frames(
        **{name: getattr(curated, name) for name in ("runs", "points", "quarantine")},
        **dict(zip(("coefficients", "refits", "fit_quality"), fitted, strict=True)),
        coverage=coverage(curated.runs, config),
        gate_counts=gate_counts(curated.runs, curated.points, curated.quarantine),
        extrapolation_errors=extrapolation_errors(extrapolate(truth, *fitted, within)),
        signs=signs,
        sign_verdicts=sign_verdicts,
        **audit(read_claims(CLAIMS).claims, [printed_evidence(printed(), config)]),
    )
    judged = compare_printed_with_fit(
        results, printed(), config.oils, study_settings(config).printed
    )
    return results.replace(printed_judged=judged)


@pytest.fixture(scope="module")
def made(demo_tables: CampaignTables, demo: Campaign) -> dict[str, Section]:
    """All sections of the demonstration, by anchor."""
    return by_anchor(demo_tables, demo.config)


@pytest.mark.slow
def test_demonstration(made: dict[str, Section]) -> None:
    assert "212 of 218 runs and 6572 of 6743 points are accepted." in sentences(made["data"])
    matrix = "212 of 216 conditions of the test matrix are accepted. Refused: 4. Missing: none."
    assert f"{matrix} Tested outside the matrix: 1." in sentences(made["data"])
    assert "STAND-IN properties are used for 4102, 4050" in sentences(made["data"])
    (stuck,) = (fact for fact in made["refused"].facts if "stuck sensor. " in fact.text)
    assert stuck.text.startswith("4050_P1.50_U35_T085.csv: stuck sensor. The traction force is")
    assert "force sensor" in stuck.advice
    assert cells(made["refused"], "gate_counts", "stuck sensor")["Points"] == "31"
    fit = cells(made["fits"], "fit_quality", "4010")
    assert (fit["Points"], fit["Curves"], fit["Certified"]) == ("2201", "71", "yes")
    # near the truth: the law made the points
    truth = cells(made["truth"], "truth-errors", "Deng (Eq. 7)")
    inside, beyond = (float(truth[name].rstrip(" %")) for name in list(truth)[1:3])
    assert inside < beyond < 5


@pytest.mark.slow
def test_report_tells_what_the_paper_claims(made: dict[str, Section]) -> None:
    apart = cells(made["printed"], "printed_judged", "4010")
    _, printed_sse, fitted_sse, tested, beyond = (
        float(value.replace("\N{MINUS SIGN}", "-")) for value in apart.values()
    )
    assert fitted_sse <= printed_sse
    assert tested < beyond
    assert cells(made["printed"], "signs", "4050")["without effect"] == "C2"
    assert int(cells(made["claims"], "claim-counts", "printed constants")["fails"]) > 0
    order = "4102 > 4050 > 4010 across all loads, speeds and temperatures"
    assert cells(made["claims"], "claim-verdicts", order)["printed constants"] == "fails"
    # what holds is as visible as what fails
    linear = "mu grows almost linearly at small S"
    assert cells(made["claims"], "claim-verdicts", linear)["printed constants"] == "holds"
    # of nine exponents; the fit of 20 refits is not sure of those near zero
    signs = r"The fits confirm [5-9] of 9 signs in use\.( Sign not known: 4010 .*\.)? CIRCULAR"
    assert re.search(signs, sentences(made["printed"]))
    assert "CIRCULAR" in sentences(made["claims"])


def test_text_has_the_answer_first_and_no_keys(made: dict[str, Section], demo: Campaign) -> None:
    lines = text_report([*made.values()], demo.config.campaign).splitlines()
    assert "SIMULATED" in lines[1]
    titles = [lines[i - 1] for i, line in enumerate(lines) if line and set(line) == {"-"}]
    assert titles[:4] == ["Answer", "Trouble", "Where to find what", "Data"]
    for key in ("deng2026", "wang-deng", "stuck_sensor"):
        assert key not in "\n".join(lines)
    # every sentence is there once
    for section in made.values():
        for fact in section.facts:
            assert lines.count(f"- {fact.text}") == 1


def test_unknown_sign_is_beside_its_interval(demo_tables: CampaignTables) -> None:
    coefficients = demo_tables.coefficients
    chosen = coefficients["constant"] == "B2"
    planted = {"lower": -0.0213, "upper": 0.774}
    constants = coefficients.assign(
        verdict=np.where(chosen, "sign unknown", "known"),
        **{name: coefficients[name].mask(chosen, end) for name, end in planted.items()},
    )
    together = demo_tables.replace(coefficients=constants)
    section = constants_section(together)
    assert "11 of 12 constants are known. Sign unknown: B2." in sentences(section)
    assert "spans -0.0213 to 0.774." in sentences(section)
    row = cells(section, "constants0", "B2")
    assert row["Joint interval"].startswith("\N{MINUS SIGN}0.02")  # the one that decides


@pytest.mark.slow
def test_signs_are_those_of_the_fit(demo_tables: CampaignTables, demo: Campaign) -> None:
    fits = demo_tables.coefficients

    def line(constants: pd.DataFrame, campaign: Settings = demo.config) -> str:
        results = demo_tables.replace(coefficients=constants)
        made = {section.anchor: section for section in study.sections(results, campaign)}
        return sentences(made["printed"])

    beside = add_printed_values(fits, load(REFERENCE, PrintedCoefficients))
    sure = fits.assign(verdict="known", value=beside["printed_value"])
    assert "The fits confirm 9 of 9 signs in use. CIRCULAR" in line(sure)
    turned = sure.assign(value=sure["value"].where(sure["constant"] != "C1", -sure["value"]))
    assert "8 of 9 signs in use. The other sign: 4010 C1. CIRCULAR" in line(turned)
    open_sign = sure.assign(verdict=np.where(sure["constant"] == "A2", "sign unknown", "known"))
    assert "8 of 9 signs in use. Sign not known: 4010 A2. CIRCULAR" in line(open_sign)
    # logs that another program simulated need not have these signs
    elsewhere = without(demo.config, "twin", "torque")
    assert "signs in use. The points were SIMULATED: this says nothing of" in line(sure, elsewhere)


def test_unknown_reason_of_a_claim_is_an_error(demo_tables: CampaignTables, demo: Campaign) -> None:
    claims = demo_tables.claims.assign(reason_code="unheard_of")
    with pytest.raises(KeyError, match="unheard_of"):
        study.sections(demo_tables.replace(claims=claims), demo.config)
