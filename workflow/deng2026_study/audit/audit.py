"""The tables of claims: every claim of the paper on every basis, with verdict and numbers."""

import itertools
from collections.abc import Sequence
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
from oilfilm.curation.coverage import of_matrix
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import Grid, obstacle
from oilfilm.traction.laws.deng2026 import DENG2026
from simulated_lab.printed import printed_constants


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
    constants, of_paper = printed_constants(printed), read_claims(claims).claims
    if not set(constants) & set(settings.oils):
        return audit(of_paper, [])
    refit = refit_evidence(results, list(constants), settings)
    return audit(of_paper, [refit, printed_evidence(constants, settings)])


def refit_evidence(
    results: CampaignTables, viscosity_order: Sequence[str], settings: Settings
) -> View:
    """The campaign's own fits and points of the paper's oils: it says nothing of others."""
    fits, points = results.configured.coefficients, results.points
    laws = {oil: FittedLaw.of(fits, oil) for oil in fits["oil"].unique() if oil in viscosity_order}
    planned = points["run_id"].isin(of_matrix(results.runs, settings)["run_id"])
    measured = {
        "points": points[planned & failed_gates.failed_none_but(points, "thin_film")],
        **{name: results.table(name) for name in ("fit_quality", "torque", "torque_control")},
    }
    own = {name: rows[rows["oil"].isin(viscosity_order)] for name, rows in measured.items()}
    return View(
        "refit",
        viscosity_order,
        {oil: law for oil, law in laws.items() if not obstacle(law)},
        settings,
        box(settings, "tested"),
        results.replace(**own),
        settings.campaign.truth_is_law,
    )


def printed_evidence(printed: dict[str, FloatArray], settings: Settings) -> View:
    """The constants that the paper prints, signs restored; the most viscous oil first."""
    laws = {
        oil: FittedLaw(DENG2026, Coefficients.bare(DENG2026, row)) for oil, row in printed.items()
    }
    return View("printed", list(laws), laws, settings, box(settings, "tested"))


def box(settings: Settings, name: str) -> Grid:
    """A box in which trends are judged, `tested` or `extrapolated`, as a grid."""
    study = study_settings(settings)
    levels, slips = study.audit.levels, study.printed.signs.slide_roll_ratio.figures
    return Grid.spanning(study.printed.boxes.model_dump()[name], levels, slips)


def audit(claims: Sequence[Claim], evidence: Sequence[View]) -> dict[str, pd.DataFrame]:
    """Tables `claims`, one row per claim and basis in the paper's order, and `claim_numbers`.

    Claims on speeds alone need no fit: they are judged once, with what the paper prints.

    Args:
        claims: The paper's claims.
        evidence: The bases.
    """
    rows: list[dict[str, Any]] = []
    numbers: list[dict[str, Any]] = []
    for claim, basis in itertools.product(claims, evidence):
        if claim.judged_on == "formula" and basis.basis != "printed":
            continue
        key = {"claim": claim.id, "basis": basis.basis}
        row, further = _judge(claim, basis)
        rows.append(key | {"judged_on": claim.judged_on, **row})
        numbers += [
            {**key, "number": name, "oil": oil, "value": value}
            for name, values in further.items()
            for oil, value in (values if isinstance(values, dict) else {"": values}).items()
            if not np.isnan(value)
        ]
    judged = pd.DataFrame(rows, columns=tables.columns("claims"))
    return {
        "claims": tables.conform(judged, "claims", "claims"),
        "claim_numbers": tables.from_rows(numbers, "claim_numbers"),
    }


def check(claim: str, view: View) -> Outcome:
    """What is found on a claim.

    Raises:
        NotCheckableError: The evidence lacks what the claim is about.
    """
    found: Outcome = getattr(checks, claim.replace("-", "_"))(view)
    return found


def _judge(claim: Claim, basis: View) -> tuple[dict[str, Any], Numbers]:
    """What the table of claims has of a claim, and the numbers that explain it.

    It holds if every fair reading of it does, and fails if none holds in a fair share.
    """
    audit, grid = basis.study.audit, basis.grid
    if claim.judged_on == "extrapolated":
        grid = box(basis.settings, claim.judged_on)
    try:
        outcome = check(claim.id, replace(basis, grid=grid))
    except NotCheckableError as why:
        reason = {"verdict": "cannot be checked", "reason_code": str(why)}
        return reason | {"worst_oil": "", "cases": 0}, {}
    others = (outcome.numbers.get(name, np.nan) for name in claim.readings)
    known = [share for share in others if isinstance(share, float) and not np.isnan(share)]
    read = [outcome.share, *known]
    if reaches(min(read), audit.holds_share) and outcome.complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    else:
        verdict = "fails" if exceeds(audit.fails_share, max(read)) else "holds in part"
    by_oil = outcome.cases.groupby("oil", sort=False)["holds"].mean().drop("", errors="ignore")
    return {
        "verdict": verdict,
        "reason_code": "",
        "cases": len(outcome.cases),
        "share": outcome.share,
        **outcome.worst_case(claim.worst).add_prefix("worst_"),
    }, {"share": {str(oil): share for oil, share in by_oil.items()}, **outcome.numbers}
