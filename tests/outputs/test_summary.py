"""The summary tells the counts, the refusals and each fit's verdict."""

import re

from campaigns import CLAIMS, Campaign, printed, sign_study
from oilfilm import tables
from oilfilm.curation.coverage import coverage
from oilfilm.outputs.summary import summarise
from oilfilm.rig_twin.truth import truth_grid
from oilfilm.studies.audit.audit import audit, printed_evidence, read_claims
from oilfilm.studies.extrapolation import extrapolate
from oilfilm.studies.printed.judge import judge_printed
from oilfilm.tables.campaign_tables import CampaignTables


def text_of(campaign: Campaign, oil: str) -> str:
    config, curated = campaign.config, campaign.curated
    fit = campaign.fit(oil, bootstrap=20, searches=2)
    extrapolation = tables.empty("extrapolation")
    if config.campaign.twin:
        relative = config.same_set_point.relative
        truth = truth_grid(config, printed())
        extrapolation = extrapolate(truth, fit.coefficients, fit.refits, fit.fit_quality, relative)
    fitted = (curated.points, fit.coefficients, fit.fit_quality)
    signs, sign_verdicts = sign_study(config, curated.points)
    basis = printed_evidence(printed(), list(printed()), config)
    results = CampaignTables.in_memory(
        runs=curated.runs,
        points=curated.points,
        quarantine=curated.quarantine,
        coverage=coverage(curated.runs, config),
        extrapolation=extrapolation,
        coefficients=fit.coefficients,
        fit_quality=fit.fit_quality,
        printed_judged=judge_printed(
            *fitted, printed(), list(config.oils), config.printed, fit.refits
        ),
        signs=signs,
        sign_verdicts=sign_verdicts,
        claims=audit(read_claims(CLAIMS), [basis], config),
    )
    return summarise(results, config)


def test_summary_of_the_demonstration(demo: Campaign) -> None:
    text = text_of(demo, "4010")
    assert "SIMULATED" in text
    assert "212 of 218 accepted" in text
    assert "certified: 2 of 2 searches agree" in text
    assert "stuck_sensor 31" in text
    assert "218 read of 218" in text
    assert "STAND-IN properties for 4102, 4050" in text
    assert "which decides nothing about the real oils:\n    deng2026: rms error" in text
    assert "212 of 216 conditions of the matrix accepted, 4 refused; missing: none" in text
    assert "outside it: 1 tested" in text
    assert "results/demo/refused" in text
    assert re.search(r"4010: SSE [\d.e-]+, the fit's [\d.e-]+; mu differs by at most", text)
    assert "4050: signs in use rank" in text
    assert "without effect C2" in text
    assert re.search(r"printed: .*\d fails.*; failing: viscosity-order, hot-convergence", text)
    # 4050's C2 is without effect: noise may favour either sign of it
    assert re.search(r"the points favour .*; CIRCULAR: they were simulated with these", text)


def test_summary_says_what_was_not_judged_and_not_identifiable(etm: Campaign) -> None:
    text = text_of(etm, "unrecorded-oil")
    assert "FILM NOT JUDGED for 20482 accepted points" in text
    assert "not identifiable, because max_hertz_pressure_gpa is not known of every run" in text
    assert "etm-slim (MEASURED, moritzploss/tribology 09bf75d, MIT licence)" in text
    assert "1 of 1 conditions tested accepted (no matrix is given" in text
    assert "Printed constants" not in text
