"""The tables of claims: every claim of the paper on every basis, with verdict and numbers."""

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from deng2026_study.audit import checks
from deng2026_study.audit.evidence import NotCheckableError, Numbers, Outcome, View
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
        settings: `film`, `gates`, `oils`, `rigs`, `same_set_point`, `studies` and the campaign's
            `matrix` and `twin`.

    Raises:
        OilfilmError: A reference file has a mistake.
    """
    printed_coefficients = load(printed_file, PrintedCoefficients)
    paper_claims = read_claims(claims_file).claims
    constants = printed_coefficients.constants()
    if not set(constants) & set(settings.oils):
        return audit(paper_claims, [])
    views = [
        refit_evidence(results, list(constants), settings),
        printed_evidence(constants, settings),
    ]
    if printed_coefficients.doubtful:
        views.append(undoubted_evidence(constants, printed_coefficients.doubtful, settings))
    return audit(paper_claims, views)


def refit_evidence(
    results: CampaignTables, falling_viscosity: Sequence[str], settings: Settings
) -> View:
    """The campaign's own fits and points of the paper's oils, without other oils."""
    fits = results.configured.coefficients
    points = results.points
    oil_names = [oil for oil in fits["oil"].unique() if oil in falling_viscosity]
    fitted_law_of_oil = {oil: FittedLaw.from_tables(fits, oil) for oil in oil_names}
    is_planned = points["run_id"].isin(runs_of_matrix(results.runs, settings)["run_id"])
    table_by_name = {
        "points": points[is_planned & failed_gates.failed_none_but(points, "thin_film")]
    }
    for table_name in ("fit_quality", "torque", "torque_control"):
        table_by_name[table_name] = results.table(table_name)
    rows_of_paper_oils = {
        table_name: table[table["oil"].isin(falling_viscosity)]
        for table_name, table in table_by_name.items()
    }
    return View(
        "refit",
        falling_viscosity,
        {oil: law for oil, law in fitted_law_of_oil.items() if not reason_without_value(law)},
        settings,
        grid_of_box(settings, "tested"),
        results.replace(**rows_of_paper_oils),
        settings.campaign.truth_is_law,
    )


def printed_evidence(printed_constants_of_oil: dict[str, FloatArray], settings: Settings) -> View:
    """The constants that the paper prints, signs restored; the most viscous oil first."""
    fitted_law_of_oil = {
        oil: FittedLaw(DENG2026, Coefficients.bare(DENG2026, constants))
        for oil, constants in printed_constants_of_oil.items()
    }
    return View(
        "printed",
        list(fitted_law_of_oil),
        fitted_law_of_oil,
        settings,
        grid_of_box(settings, "tested"),
    )


def undoubted_evidence(
    printed_constants_of_oil: dict[str, FloatArray],
    doubtful_oils: Collection[str],
    settings: Settings,
) -> View:
    """The constants that the paper prints, without the oils whose constants may be damaged."""
    undoubted_constants_of_oil = {
        oil: constants
        for oil, constants in printed_constants_of_oil.items()
        if oil not in doubtful_oils
    }
    return replace(printed_evidence(undoubted_constants_of_oil, settings), basis=UNDOUBTED)


def grid_of_box(settings: Settings, box_name: str) -> Grid:
    """A box in which trends are judged, `tested` or `extrapolated`, as a grid."""
    study = study_settings(settings)
    ends = study.printed.boxes.model_dump()[box_name]
    slips = study.printed.signs.slide_roll_ratio.figures
    return Grid.spanning(ends, study.audit.levels, slips)


def audit(claims: Sequence[Claim], views: Sequence[View]) -> dict[str, pd.DataFrame]:
    """Tables `claims`, one row per claim and basis in the paper's order, and `claim_numbers`.

    Claims on speeds alone need no fit: they are judged once, with what the paper prints. Without
    doubtful oils only those claims are judged again whose verdict rests on the constants of oils.

    Args:
        claims: The paper's claims.
        views: What a verdict is based on, one view per basis.
    """
    claim_rows: list[dict[str, Any]] = []
    number_rows: list[dict[str, Any]] = []
    for claim, view in itertools.product(claims, views):
        if claim.judged_on == "formula" and view.basis != "printed":
            continue
        rests_on_constants = (
            claim.judged_on in ("tested", "extrapolated") and claim.without_doubtful
        )
        if view.basis == UNDOUBTED and not rests_on_constants:
            continue
        key_columns = {"claim": claim.id, "basis": view.basis}
        claim_columns, further_numbers = _judge(claim, view)
        claim_rows.append(key_columns | {"judged_on": claim.judged_on} | claim_columns)
        for number_columns in _rows_of_numbers(further_numbers):
            number_rows.append(key_columns | number_columns)
    judged = pd.DataFrame(claim_rows, columns=tables.columns("claims"))
    return {
        "claims": tables.conform(judged, "claims", "claims"),
        "claim_numbers": tables.from_rows(number_rows, "claim_numbers"),
    }


def _rows_of_numbers(numbers: Numbers) -> Iterator[dict[str, Any]]:
    """Rows of further numbers: one per number, or per number and oil; none where it is NaN."""
    for number_name, value_or_values_of_oil in numbers.items():
        value_of_oil = (
            value_or_values_of_oil
            if isinstance(value_or_values_of_oil, dict)
            else {"": value_or_values_of_oil}
        )
        for oil, value in value_of_oil.items():
            if not np.isnan(value):
                yield {"number": number_name, "oil": oil, "value": value}


def check(claim_id: str, view: View) -> Outcome:
    """The outcome of the check of a claim.

    Raises:
        NotCheckableError: The evidence lacks what the claim is about.
    """
    outcome: Outcome = getattr(checks, claim_id.replace("-", "_"))(view)
    return outcome


def _judge(claim: Claim, view: View) -> tuple[dict[str, Any], Numbers]:
    """The columns of the table of claims for one claim, and the numbers that explain it.

    A claim holds if every fair reading of it holds. It fails if no reading holds in a fair share.
    """
    audit_settings = view.study.audit
    grid = view.grid
    if claim.judged_on == "extrapolated":
        grid = grid_of_box(view.settings, claim.judged_on)
    try:
        outcome = check(claim.id, replace(view, grid=grid))
    except NotCheckableError as error:
        claim_columns = {
            "verdict": "cannot be checked",
            "reason_code": str(error),
            "worst_oil": "",
            "cases": 0,
        }
        return claim_columns, {}
    share_of_readings = [outcome.share]
    for reading in claim.readings:
        share = outcome.numbers.get(reading, np.nan)
        if isinstance(share, float) and not np.isnan(share):
            share_of_readings.append(share)
    if reaches(min(share_of_readings), audit_settings.holds_share) and outcome.can_hold:
        verdict = "by construction" if outcome.by_construction else "holds"
    elif exceeds(audit_settings.fails_share, max(share_of_readings)):
        verdict = "fails"
    else:
        verdict = "holds in part"
    claim_columns = {
        "verdict": verdict,
        "reason_code": "",
        "cases": len(outcome.cases),
        "share": outcome.share,
    }
    claim_columns.update(outcome.worst_case(claim.worst).add_prefix("worst_"))
    share_by_oil = (
        outcome.cases.groupby("oil", sort=False)["holds"].mean().drop("", errors="ignore")
    )
    further_numbers: Numbers = {"share": {str(oil): share for oil, share in share_by_oil.items()}}
    if claim.judged_on == "extrapolated":
        further_numbers.update(_share_where_tested(claim, view))
    further_numbers.update(outcome.numbers)
    return claim_columns, further_numbers


def _share_where_tested(claim: Claim, view: View) -> Numbers:
    """Share of the cases of the box tested by the paper in which a claim holds, read strictly."""
    try:
        return {"share_tested": check(claim.id, view).share}
    except NotCheckableError:  # the claim is about no condition of that box
        return {}
