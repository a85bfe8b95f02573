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
from oilfilm.torque.operating_grid import Grid, obstacle
from oilfilm.traction.laws.deng2026 import DENG2026
from simulated_lab.printed import PrintedCoefficients

# Basis of verdicts without the oils whose printed constants may be damaged.
UNDOUBTED = "undoubted"


def audit_campaign(
    results: CampaignTables, printed: Path, claims: Path, settings: Settings
) -> dict[str, pd.DataFrame]:
    """Tables `claims` and `claim_numbers`, by the refit and by the printed constants.

    A campaign without any oil of the paper has neither claims nor printed constants.

    Args:
        results: Tables `coefficients`, `points`, `runs`, `fit_quality`, `torque` and
            `torque_control`.
        printed: File of the printed constants.
        claims: File of the paper's claims.
        settings: `film`, `gates`, `oils`, `rigs`, `same_set_point`, `studies` and the campaign's
            `matrix` and `twin`.

    Raises:
        OilfilmError: A reference file has a mistake.
    """
    of_print, of_paper = load(printed, PrintedCoefficients), read_claims(claims).claims
    constants = of_print.constants()
    if not set(constants) & set(settings.oils):
        return audit(of_paper, [])
    evidence = [
        refit_evidence(results, list(constants), settings),
        printed_evidence(constants, settings),
    ]
    if of_print.doubtful:
        evidence.append(undoubted_evidence(constants, of_print.doubtful, settings))
    return audit(of_paper, evidence)


def refit_evidence(
    results: CampaignTables, viscosity_order: Sequence[str], settings: Settings
) -> View:
    """The campaign's own fits and points of the paper's oils, without other oils."""
    fits = results.configured.coefficients
    points = results.points
    oils = [oil for oil in fits["oil"].unique() if oil in viscosity_order]
    laws = {oil: FittedLaw.from_tables(fits, oil) for oil in oils}
    planned = points["run_id"].isin(runs_of_matrix(results.runs, settings)["run_id"])
    measured = {"points": points[planned & failed_gates.failed_none_but(points, "thin_film")]}
    for name in ("fit_quality", "torque", "torque_control"):
        measured[name] = results.table(name)
    of_paper = {name: rows[rows["oil"].isin(viscosity_order)] for name, rows in measured.items()}
    return View(
        "refit",
        viscosity_order,
        {oil: law for oil, law in laws.items() if not obstacle(law)},
        settings,
        box(settings, "tested"),
        results.replace(**of_paper),
        settings.campaign.truth_is_law,
    )


def printed_evidence(printed: dict[str, FloatArray], settings: Settings) -> View:
    """The constants that the paper prints, signs restored; the most viscous oil first."""
    laws = {
        oil: FittedLaw(DENG2026, Coefficients.bare(DENG2026, row)) for oil, row in printed.items()
    }
    return View("printed", list(laws), laws, settings, box(settings, "tested"))


def undoubted_evidence(
    printed: dict[str, FloatArray], doubtful: Collection[str], settings: Settings
) -> View:
    """The constants that the paper prints, without the oils whose constants may be damaged."""
    kept = {oil: constants for oil, constants in printed.items() if oil not in doubtful}
    return replace(printed_evidence(kept, settings), basis=UNDOUBTED)


def box(settings: Settings, name: str) -> Grid:
    """A box in which trends are judged, `tested` or `extrapolated`, as a grid."""
    study = study_settings(settings)
    ends = study.printed.boxes.model_dump()[name]
    slips = study.printed.signs.slide_roll_ratio.figures
    return Grid.spanning(ends, study.audit.levels, slips)


def audit(claims: Sequence[Claim], evidence: Sequence[View]) -> dict[str, pd.DataFrame]:
    """Tables `claims`, one row per claim and basis in the paper's order, and `claim_numbers`.

    Claims on speeds alone need no fit: they are judged once, with what the paper prints. Without
    doubtful oils only those claims are judged again whose verdict rests on the constants of oils.

    Args:
        claims: The paper's claims.
        evidence: The bases.
    """
    rows: list[dict[str, Any]] = []
    numbers: list[dict[str, Any]] = []
    for claim, basis in itertools.product(claims, evidence):
        if claim.judged_on == "formula" and basis.basis != "printed":
            continue
        rests_on_constants = (
            claim.judged_on in ("tested", "extrapolated") and claim.without_doubtful
        )
        if basis.basis == UNDOUBTED and not rests_on_constants:
            continue
        key = {"claim": claim.id, "basis": basis.basis}
        row, further_numbers = _judge(claim, basis)
        rows.append(key | {"judged_on": claim.judged_on} | row)
        for number in _rows_of_numbers(further_numbers):
            numbers.append(key | number)
    judged = pd.DataFrame(rows, columns=tables.columns("claims"))
    return {
        "claims": tables.conform(judged, "claims", "claims"),
        "claim_numbers": tables.from_rows(numbers, "claim_numbers"),
    }


def _rows_of_numbers(numbers: Numbers) -> Iterator[dict[str, Any]]:
    """Rows of further numbers: one per number, or per number and oil; none where it is NaN."""
    for name, values in numbers.items():
        value_of_oil = values if isinstance(values, dict) else {"": values}
        for oil, value in value_of_oil.items():
            if not np.isnan(value):
                yield {"number": name, "oil": oil, "value": value}


def check(claim: str, view: View) -> Outcome:
    """The outcome of the check of a claim.

    Raises:
        NotCheckableError: The evidence lacks what the claim is about.
    """
    outcome: Outcome = getattr(checks, claim.replace("-", "_"))(view)
    return outcome


def _judge(claim: Claim, basis: View) -> tuple[dict[str, Any], Numbers]:
    """The columns of the table of claims for one claim, and the numbers that explain it.

    A claim holds if every fair reading of it holds. It fails if no reading holds in a fair share.
    """
    audit = basis.study.audit
    grid = basis.grid
    if claim.judged_on == "extrapolated":
        grid = box(basis.settings, claim.judged_on)
    try:
        outcome = check(claim.id, replace(basis, grid=grid))
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
    if reaches(min(shares), audit.holds_share) and outcome.complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    elif exceeds(audit.fails_share, max(shares)):
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
    by_oil = outcome.cases.groupby("oil", sort=False)["holds"].mean().drop("", errors="ignore")
    numbers: Numbers = {"share": {str(oil): share for oil, share in by_oil.items()}}
    if claim.judged_on == "extrapolated":
        numbers.update(_where_tested(claim, basis))
    numbers.update(outcome.numbers)
    return row, numbers


def _where_tested(claim: Claim, basis: View) -> Numbers:
    """Share of the cases of the box tested by the paper in which a claim holds, read strictly."""
    try:
        return {"share_tested": check(claim.id, basis).share}
    except NotCheckableError:  # the claim is about no condition of that box
        return {}
