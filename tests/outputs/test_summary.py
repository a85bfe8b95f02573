"""The summary tells the counts, the refusals and each fit's verdict."""

import re

import numpy as np
import pandas as pd

from campaigns import CLAIMS, Campaign, printed, sign_study, without
from oilfilm import tables
from oilfilm.curation.coverage import coverage
from oilfilm.outputs.summary import at_the_end_of_a_run, summarise
from oilfilm.rig_twin.truth import truth_grid
from oilfilm.settings.resolved import Settings
from oilfilm.studies.audit.audit import audit, printed_evidence, read_claims
from oilfilm.studies.extrapolation import extrapolate
from oilfilm.studies.printed.judge import judge_printed
from oilfilm.tables.campaign_tables import CampaignTables
from reports import rows


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
    # of nine exponents; the fit of 20 refits is not sure of those near zero
    assert re.search(r"the fits have [5-9] of 9 signs in use(; not sure of 4010 .*)?; CIRC", text)
    assert "other sign" not in text
    assert "the law's equation makes it so: zero-slip, non-negative\n" in text
    assert "CIRCULAR on the refit" in text
    assert "Wang-Deng: a tie by construction" in text


def test_sign_that_is_not_known_stands_beside_the_interval_that_holds_zero(demo: Campaign) -> None:
    fit = demo.fit("4010", bootstrap=20, searches=2)
    chosen = fit.coefficients["constant"] == "B2"
    planted = {"lower": 0.187, "upper": 0.566, "joint_lower": -0.0213, "joint_upper": 0.774}
    constants = fit.coefficients.assign(
        verdict=np.where(chosen, "sign unknown", "known"),
        **{name: fit.coefficients[name].mask(chosen, end) for name, end in planted.items()},
    )
    results = CampaignTables.in_memory(coefficients=constants, fit_quality=fit.fit_quality)
    partner = {"oil": "4010", "law": "deng2026", "constant": "B1", "other": "B2"}
    together = results.replace(correlations=rows("correlations", partner | {"correlation": -0.97}))
    text = summarise(together, without(demo.config, "torque"))
    (value,) = constants.loc[chosen, "value"]
    spans = "the joint interval spans -0.0213 to 0.774"
    assert f"not determined: B2 {value:.4g} ({spans}; correlated -0.97 with B1)" in text
    # what is determined is named first, and each word has its meaning below
    known = r"determined by these data: A0 -0\.\d+ \+- \d.*, .*\n    not determined: B2"
    assert re.search(known, text)
    assert "    joint interval: holds for all constants" in text
    assert "    correlated: near 1 or -1" in text


def test_signs_are_those_of_the_fit_and_not_of_the_printed_sizes(demo: Campaign) -> None:
    """Printed sizes that suit no point may fit better with a turned sign: the fit decides."""
    fit = demo.fit("4010", bootstrap=20, searches=2)
    signs, verdicts = sign_study(demo.config, demo.curated.points)
    misleading = verdicts.assign(least_sse=1.0, least_sse_turned=0.5)

    def line(constants: pd.DataFrame, campaign: Settings = demo.config) -> str:
        results = CampaignTables.in_memory(
            coefficients=constants,
            fit_quality=fit.fit_quality,
            signs=signs,
            sign_verdicts=misleading,
        )
        (found,) = re.findall("the fits have .*", summarise(results, campaign))
        return str(found)

    sure = fit.coefficients.assign(verdict="known", value=fit.coefficients["printed_value"])
    assert line(sure).startswith("the fits have 9 of 9 signs in use; CIRCULAR")
    turned = sure.assign(value=sure["value"].where(sure["constant"] != "C1", -sure["value"]))
    assert "8 of 9 signs in use; the other sign of 4010 C1; CIRCULAR" in line(turned)
    open_sign = sure.assign(verdict=np.where(sure["constant"] == "A2", "sign unknown", "known"))
    assert "8 of 9 signs in use; not sure of 4010 A2; CIRCULAR" in line(open_sign)
    # logs that another program simulated need not have these signs
    elsewhere = without(demo.config, "twin", "torque")
    assert line(sure, elsewhere).endswith(
        "9 of 9 signs in use; the points were SIMULATED, which says nothing of the real oils"
    )


def test_summary_says_what_was_not_judged_and_not_identifiable(etm: Campaign) -> None:
    text = text_of(etm, "unrecorded-oil")
    assert "FILM NOT JUDGED for 20482 accepted points of unrecorded-oil: neither oil" in text
    assert "not identifiable, because max_hertz_pressure_gpa is not known of every run" in text
    assert "etm-slim (MEASURED, moritzploss/tribology 09bf75d, MIT licence)" in text
    assert "1 of 1 conditions tested accepted (no matrix is given" in text
    assert "Printed constants" not in text


def test_best_law_and_noise_are_near_the_top_with_what_to_do(demo: Campaign) -> None:
    fit = demo.fit("4010", bootstrap=20, searches=2)
    better = "tanh describes the data better than the configured law deng2026. BIC: lower by 1515"
    verdict = {"oil": "4010", "law": "deng2026", "verdict": "another law is better"}
    noise = {"oil": "4010", "law": "deng2026", "finding": "lack of fit of the law 2.75%"}
    results = CampaignTables.in_memory(
        coefficients=fit.coefficients,
        fit_quality=fit.fit_quality,
        law_verdicts=rows("law_verdicts", verdict | {"finding": better, "advice": "Set it"}),
        lack_of_fit=rows("lack_of_fit", noise),
    )
    text = summarise(results, without(demo.config, "torque"))
    assert text.splitlines()[1:3] == [f"  law     4010: {better}", "    -> Set it."]
    assert "  4010: lack of fit of the law 2.75%\n" in text
    for word in ("certified", "BIC", "lack of fit"):
        assert f"\n    {word}: " in text
    # no claims were checked, so that nothing is said of any
    assert "Claims of the paper" not in text


def test_end_of_a_run_is_short_and_says_where_the_whole_is() -> None:
    body = [f"line {number}" for number in range(100)]
    body[3:3] = ["  what the words mean:", "    rms: root-mean-square", "    tie: no difference"]
    text = at_the_end_of_a_run("\n".join([*body, "", "Report:  a", "Log:     b"]), "summary.txt")
    lines = text.split("\n")
    assert lines[:5] == [*body[:3], "  what the words mean: summary.txt", "line 3"]
    assert lines[-4:] == ["... 26 more lines: summary.txt", "", "Report:  a", "Log:     b"]
    assert "tie" not in text
    short = "line\n\nReport:  a"
    assert at_the_end_of_a_run(short, "summary.txt") == short
