"""The summary tells the counts, the refusals and each fit's verdict."""

import re
from itertools import pairwise

import numpy as np
import pandas as pd

from campaigns import CLAIMS, Campaign, printed, sign_study, without
from oilfilm import tables
from oilfilm.curation.coverage import coverage
from oilfilm.paper.audit.audit import audit, printed_evidence, read_claims
from oilfilm.paper.extrapolation import extrapolate
from oilfilm.paper.printed.judge import judge_printed
from oilfilm.report.summary import at_the_end_of_a_run, summarise
from oilfilm.rig_twin.truth import truth_grid
from oilfilm.settings.resolved import Settings
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


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def row_of(text: str, first: str, column: str = "") -> list[str]:
    """The other cells of the row of a table, that with the named column if one is named."""
    for table in text.split("\n\n"):
        rows = [cells(line) for line in table.splitlines() if line.startswith("|")]
        if rows and (not column or column in rows[0]):
            for row in rows:
                if row[0] == first:
                    return row[1:]
    raise AssertionError(f"no table has a row {first!r}")


def test_summary_of_the_demonstration(demo: Campaign) -> None:
    text = text_of(demo, "4010")
    assert "SIMULATED" in text
    assert "- Logs: 218 of 218 have runs.\n- Runs: 212 of 218 are accepted.\n" in text
    assert "STAND-IN properties are used for 4102, 4050" in text
    matrix = "Conditions of the test matrix: 212 of 216 are accepted. Refused: 4. Missing: none."
    assert f"{matrix} Tested outside the matrix: 1.\n" in text
    assert "results/demo/refused" in text
    stuck = "4050_P1.50_U35_T085.csv: stuck sensor. The traction force is exactly"
    assert re.search(rf"- {stuck} .*\.\n  What to do: Check the traction force sensor", text)
    assert row_of(text, "stuck sensor") == ["31"]
    points, curves, *_, certified, _ = row_of(text, "4010", "certified")
    assert (points, curves, certified) == ("2201", "71", "yes")
    assert row_of(text, "4010", "searches agree")[0] == "2 of 2"
    assert "SIMULATED truth at the conditions of Figs 7-10, which decides nothing about" in text
    # near the truth: the law made the points
    inside, beyond, *_ = map(float, row_of(text, "Deng (Eq. 7)", "beyond it")[:2])
    assert inside < beyond < 5


def test_summary_tells_what_the_paper_printed_and_claims(demo: Campaign) -> None:
    text = text_of(demo, "4010")
    printed_sse, fitted_sse, tested, beyond = map(float, row_of(text, "4010", "SSE, printed"))
    assert fitted_sse <= printed_sse
    assert tested < beyond
    assert row_of(text, "4050", "rank of the set in use")[-1] == "C2"
    header = next(line for line in text.splitlines() if "cannot be checked |" in line)
    counts = dict(zip(cells(header)[1:], row_of(text, "printed constants"), strict=True))
    assert int(counts["fails"]) > 0
    assert row_of(text, "4102 > 4050 > 4010 across all loads, speeds and temperatures") == ["fails"]
    # of nine exponents; the fit of 20 refits is not sure of those near zero
    signs = r"The fits confirm [5-9] of 9 signs in use\.( Sign not known: 4010 .*\.)? CIRCULAR"
    assert re.search(signs, text)
    assert "other sign" not in text
    assert "because of the law's equation: mu = 0 at S = 0, everywhere.\n" in text
    assert "CIRCULAR on the refit" in text
    assert "Wang-Deng: a tie by construction" in text


def test_summary_has_headed_sections_and_no_keys_of_the_code(demo: Campaign) -> None:
    lines = text_of(demo, "4010").splitlines()
    titles = [title for title, rule in pairwise(lines) if rule and rule == "-" * len(title)]
    assert titles[:3] == ["Data", "Refused", "Fits"]
    assert titles[-2:] == ["Words", "Where to find what"]
    text = "\n".join(lines)
    for key in ("->", "deng2026", "wang-deng", "stuck_sensor", "off_nominal"):
        assert key not in text
    # cells of a column are below each other
    for above, below in pairwise(lines):
        if above.startswith("|") and below.startswith("|"):
            assert len(above) == len(below)


def test_sign_that_is_not_known_stands_beside_the_interval_that_holds_zero(demo: Campaign) -> None:
    fit = demo.fit("4010", bootstrap=20, searches=2)
    chosen = fit.coefficients["constant"] == "B2"
    planted = {"lower": -0.0213, "upper": 0.774}
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
    assert f"4010 B2. {spans[0].upper()}{spans[1:]}; correlated -0.97 with B1.\n" in text
    assert row_of(text, "B2") == [f"{value:.4g} ?"]
    # of what is determined there is an error, and each word has its meaning below
    assert re.fullmatch(r"-0\.\d+ \+- [\d.e-]+", row_of(text, "A0")[0])
    assert row_of(text, "4010", "certified")[-1] == "B2"
    assert "\n- joint interval: Holds for all constants" in text
    assert "\n- correlated: Near 1 or -1" in text


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
        (found,) = re.findall("The fits confirm .*", summarise(results, campaign))
        return str(found)

    sure = fit.coefficients.assign(verdict="known", value=fit.coefficients["printed_value"])
    assert line(sure).startswith("The fits confirm 9 of 9 signs in use. CIRCULAR")
    turned = sure.assign(value=sure["value"].where(sure["constant"] != "C1", -sure["value"]))
    assert "8 of 9 signs in use. The other sign: 4010 C1. CIRCULAR" in line(turned)
    open_sign = sure.assign(verdict=np.where(sure["constant"] == "A2", "sign unknown", "known"))
    assert "8 of 9 signs in use. Sign not known: 4010 A2. CIRCULAR" in line(open_sign)
    # logs that another program simulated need not have these signs
    elsewhere = without(demo.config, "twin", "torque")
    assert line(sure, elsewhere).endswith(
        "9 of 9 signs in use. The points were SIMULATED: this says nothing of the real oils."
    )


def test_summary_says_what_was_not_judged_and_not_identifiable(etm: Campaign) -> None:
    text = text_of(etm, "unrecorded-oil")
    assert "FILM NOT JUDGED for 20482 accepted points of unrecorded-oil. Neither oil" in text
    assert re.search(
        r"not identifiable: A0, .*\. Maximum Hertz pressure is not known of every run\.", text
    )
    assert "etm-slim (MEASURED, moritzploss/tribology 09bf75d, MIT licence)" in text
    assert "Tested conditions: 1 of 1 are accepted. The campaign has no test matrix" in text
    assert "Printed constants" not in text


def test_best_law_and_noise_are_told_with_what_to_do(demo: Campaign) -> None:
    fit = demo.fit("4010", bootstrap=20, searches=2)
    verdict = {"oil": "4010", "law": "deng2026", "verdict": "another law is better"}
    verdict |= {"better_law": "tanh"}
    verdict |= {"left_out_law": "tanh", "left_out_ties": "tanh", "left_out_difference": 0.003}
    verdict |= {"bic_law": "tanh", "bic_ties": "tanh", "bic_difference": 1515.0}
    noise = {"oil": "4010", "law": "deng2026", "verdict": "shown"}
    noise |= {"lack_of_fit_relative_rms": 0.0275}
    tanh = fit.fit_quality.assign(law="tanh", configured=False)
    results = CampaignTables.in_memory(
        coefficients=fit.coefficients,
        fit_quality=pd.concat([fit.fit_quality, tanh]),
        law_verdicts=rows("law_verdicts", verdict),
        lack_of_fit=rows("lack_of_fit", noise),
    )
    text = summarise(results, without(demo.config, "torque"))
    head = "- 4010: hyperbolic tangent describes the data better than the configured law"
    assert f"{head} Deng (Eq. 7).\n  What to do: To use it, write `fit: {{law: tanh}}`" in text
    assert re.search(r"\n\| 4010 \| BIC +\| hyperbolic tangent +\| 1515 \+- ", text)
    assert "lack of fit of the law is 2.75%" in " ".join(text.split())
    for word in ("certified", "BIC", "lack of fit"):
        assert f"\n- {word}: " in text
    # no claims were checked, so that nothing is said of any
    assert "Claims of the paper" not in text


def test_end_of_a_run_is_short_and_says_where_the_whole_is() -> None:
    body = [f"line {number}" for number in range(100)]
    words = ["", "Words", "-----", "- rms: Root mean square.", "- tie: No difference."]
    places = ["", "Where to find what", "------------------", "Report:  a"]
    text = at_the_end_of_a_run("\n".join([*body, *words, *places]), "summary.txt")
    more, meaning = "... 25 more lines: summary.txt", "The meaning of words is in summary.txt."
    assert text.split("\n") == [*body[:75], more, meaning, *places]
    short = "\n".join(["line", *places])
    assert at_the_end_of_a_run(short, "summary.txt") == short
