"""The tables of claims: every claim of the paper on every basis, with verdict and numbers."""

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from deng2026_study.audit import checks
from deng2026_study.audit.evidence import Evidence, NotCheckableError, Numbers, Outcome
from deng2026_study.reference import Claim, read_claims
from deng2026_study.settings import study_settings
from oilfilm import tables
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import FloatArray
from oilfilm.curation.coverage import runs_of_matrix
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import Grid, reason_without_value
from oilfilm.traction.laws.deng2026 import DENG2026
from simulated_lab.printed import PrintedCoefficients

# Basis of verdicts without the oils whose printed constants may be damaged.
UNDOUBTED = "undoubted"


def audit_campaign(
    results: CampaignTables, printed_file: Path, claims_file: Path, settings: Settings
) -> dict[str, pd.DataFrame]:
    """Tables `claims` and `claim_numbers`, by the refit and by the printed constants.

    A campaign without any oil of the paper has neither claims nor printed constants.

    Args:
        results: Tables `coefficients`, `points`, `runs`, `fit_quality`, `torque` and
            `torque_control`.
        printed_file: File of the printed constants.
        claims_file: File of the paper's claims.
        settings: At least `film`, `gates`, `oils`, `rigs`, `same_set_point`, `studies` and the
            campaign's `matrix` and `twin`.

    Raises:
        OilfilmError: A reference file has a mistake.
    """
    printed_coefficients = load(printed_file, PrintedCoefficients)
    paper_claims = read_claims(claims_file).claims
    constants_by_oil = printed_coefficients.constants_by_oil()
    if not set(constants_by_oil) & set(settings.oils):
        return audit(paper_claims, [])
    all_evidence = [
        refit_evidence(results, list(constants_by_oil), settings),
        printed_evidence(constants_by_oil, settings),
    ]
    if printed_coefficients.doubtful:
        all_evidence.append(
            undoubted_evidence(constants_by_oil, printed_coefficients.doubtful, settings)
        )
    return audit(paper_claims, all_evidence)


def refit_evidence(
    results: CampaignTables, falling_viscosity: Sequence[str], settings: Settings
) -> Evidence:
    """The campaign's own fits and points of the paper's oils, without other oils.

    Args:
        results: As for `audit_campaign`.
        falling_viscosity: The paper's oils, the most viscous first.
        settings: As for `audit_campaign`.
    """
    coefficients = results.configured_fits.coefficients
    points = results.points
    oils = [oil for oil in coefficients["oil"].unique() if oil in falling_viscosity]
    fit_by_oil = {oil: FittedLaw.from_tables(coefficients, oil) for oil in oils}
    is_planned = points["run_id"].isin(runs_of_matrix(results.runs, settings)["run_id"])
    measured_rows = {
        "points": points[is_planned & failed_gates.passed_all_but(points, "thin_film")]
    }
    for name in ("fit_quality", "torque", "torque_control"):
        measured_rows[name] = results.table(name)
    rows_of_paper_oils = {
        name: rows[rows["oil"].isin(falling_viscosity)] for name, rows in measured_rows.items()
    }
    return Evidence(
        "refit",
        falling_viscosity,
        {oil: law for oil, law in fit_by_oil.items() if not reason_without_value(law)},
        settings,
        grid_of_box(settings, "tested"),
        results.replace(**rows_of_paper_oils),
        settings.campaign.truth_is_law,
    )


def printed_evidence(constants_by_oil: dict[str, FloatArray], settings: Settings) -> Evidence:
    """The constants that the paper prints, signs restored; the most viscous oil first."""
    fit_by_oil = {
        oil: FittedLaw(DENG2026, Coefficients.from_constants(DENG2026, constants))
        for oil, constants in constants_by_oil.items()
    }
    return Evidence(
        "printed", list(fit_by_oil), fit_by_oil, settings, grid_of_box(settings, "tested")
    )


def undoubted_evidence(
    constants_by_oil: dict[str, FloatArray], doubtful: Collection[str], settings: Settings
) -> Evidence:
    """The constants that the paper prints, without the oils whose constants may be damaged."""
    undoubted_by_oil = {
        oil: constants for oil, constants in constants_by_oil.items() if oil not in doubtful
    }
    return replace(printed_evidence(undoubted_by_oil, settings), basis=UNDOUBTED)


def grid_of_box(settings: Settings, box_name: str) -> Grid:
    """A box in which trends are judged, `tested` or `extrapolated`, as a grid."""
    study = study_settings(settings)
    ends = study.printed.boxes.model_dump()[box_name]
    slips = study.printed.signs.slide_roll_ratio.figures
    return Grid.spanning(ends, study.audit.levels, slips)


def audit(claims: Sequence[Claim], all_evidence: Sequence[Evidence]) -> dict[str, pd.DataFrame]:
    """Tables `claims`, one row per claim and basis in the paper's order, and `claim_numbers`.

    Claims on speeds alone need no fit: they are judged once, with what the paper prints. Without
    doubtful oils only those claims are judged again whose verdict rests on the constants of oils.

    Args:
        claims: The paper's claims.
        all_evidence: What verdicts are based on, one object per basis.
    """
    rows: list[dict[str, Any]] = []
    number_rows: list[dict[str, Any]] = []
    for claim, evidence in itertools.product(claims, all_evidence):
        if claim.judged_on == "formula" and evidence.basis != "printed":
            continue
        rests_on_constants = (
            claim.judged_on in ("tested", "extrapolated") and claim.without_doubtful
        )
        if evidence.basis == UNDOUBTED and not rests_on_constants:
            continue
        key_columns = {"claim": claim.id, "basis": evidence.basis}
        row, further_numbers = _judge(claim, evidence)
        rows.append(key_columns | {"judged_on": claim.judged_on} | row)
        for number_columns in _rows_of_numbers(further_numbers):
            number_rows.append(key_columns | number_columns)
    claim_rows = pd.DataFrame(rows, columns=tables.columns("claims"))
    return {
        "claims": tables.conform(claim_rows, "claims", "claims"),
        "claim_numbers": tables.from_rows(number_rows, "claim_numbers"),
    }


def _rows_of_numbers(numbers: Numbers) -> Iterator[dict[str, Any]]:
    """Rows of further numbers: one per number, or per number and oil; none where it is NaN."""
    for name, content in numbers.items():
        value_of_oil = content if isinstance(content, dict) else {"": content}
        for oil, value in value_of_oil.items():
            if not np.isnan(value):
                yield {"number": name, "oil": oil, "value": value}


def check(claim_id: str, evidence: Evidence) -> Outcome:
    """The outcome of the check of a claim.

    Raises:
        NotCheckableError: The evidence lacks what the claim is about.
    """
    outcome: Outcome = getattr(checks, claim_id.replace("-", "_"))(evidence)
    return outcome


def _judge(claim: Claim, evidence: Evidence) -> tuple[dict[str, Any], Numbers]:
    """The columns of the table of claims for one claim, and the numbers that explain it.

    A claim holds if every fair reading of it holds. It fails if no reading holds in a fair share.
    """
    limits = evidence.study.audit
    grid = evidence.grid
    if claim.judged_on == "extrapolated":
        grid = grid_of_box(evidence.settings, claim.judged_on)
    try:
        outcome = check(claim.id, replace(evidence, grid=grid))
    except NotCheckableError as error:
        row = {
            "verdict": "cannot be checked",
            "reason_code": str(error),
            "worst_oil": "",
            "cases": 0,
        }
        return row, {}
    shares = [outcome.share]
    for reading in claim.readings:
        share = outcome.numbers.get(reading, np.nan)
        if isinstance(share, float) and not np.isnan(share):
            shares.append(share)
    if reaches(min(shares), limits.holds_share) and outcome.is_complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    elif exceeds(limits.fails_share, max(shares)):
        verdict = "fails"
    else:
        verdict = "holds in part"
    row = {
        "verdict": verdict,
        "reason_code": "",
        "cases": len(outcome.cases),
        "share": outcome.share,
    }
    row.update(outcome.worst_case(claim.worst).add_prefix("worst_"))
    share_by_oil = (
        outcome.cases.groupby("oil", sort=False)["holds"].mean().drop("", errors="ignore")
    )
    numbers: Numbers = {"share": {str(oil): share for oil, share in share_by_oil.items()}}
    if claim.judged_on == "extrapolated":
        numbers.update(_share_where_tested(claim, evidence))
    numbers.update(outcome.numbers)
    return row, numbers


def _share_where_tested(claim: Claim, evidence: Evidence) -> Numbers:
    """Share of the cases of the box tested by the paper in which a claim holds, read strictly."""
    try:
        return {"share_tested": check(claim.id, evidence).share}
    except NotCheckableError:  # the claim is about no condition of that box
        return {}
