"""The tables of claims: every claim of the paper on every basis, with verdict and numbers."""

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import of_matrix
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.paper.audit.checks import CHECKS
from oilfilm.paper.audit.evidence import Evidence, NotCheckableError, Numbers, Outcome, View
from oilfilm.paper.reference import Claim, printed_constants, read_claims
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import Grid, films, obstacle
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import FloatArray


def checked_claims(path: Path) -> list[Claim]:
    """The claims of the paper, each with its check.

    Raises:
        OilfilmError: The file has a mistake, or names a claim that has no check or lacks one.
    """
    claims = read_claims(path).claims
    ids = [claim.id for claim in claims]
    wrong = sorted(set(ids) ^ set(CHECKS)) or sorted({i for i in ids if ids.count(i) > 1})
    if wrong:
        raise OilfilmError(
            f"{path}: the claims and the checks of oilfilm.paper.audit must be the same, each "
            f"once; look at {', '.join(wrong)}."
        )
    return claims


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
        settings: `audit`, `film`, `gates`, `oils`, `printed`, `rigs`, `same_set_point`,
            `selection` and the campaign's `matrix` and `twin`.

    Raises:
        OilfilmError: A reference file has a mistake.
    """
    constants = printed_constants(printed)
    checked = checked_claims(claims)
    if not set(constants) & set(settings.oils):
        return audit(checked, [], settings)
    refit = refit_evidence(results, list(constants), settings)
    return audit(checked, [refit, printed_evidence(constants, settings)], settings)


def refit_evidence(
    results: CampaignTables, viscosity_order: Sequence[str], settings: Settings
) -> Evidence:
    """The campaign's own fits and points of the paper's oils: it says nothing of others."""
    fits, points = results.configured.coefficients, results.points
    laws = {oil: FittedLaw.of(fits, oil) for oil in fits["oil"].unique() if oil in viscosity_order}
    planned = points["run_id"].isin(of_matrix(results.runs, settings)["run_id"])
    measured = {
        "points": points[planned & failed_gates.failed_none_but(points, "thin_film")],
        **{name: results.table(name) for name in ("fit_quality", "torque", "torque_control")},
    }
    own = {name: rows[rows["oil"].isin(viscosity_order)] for name, rows in measured.items()}
    return Evidence(
        "refit",
        viscosity_order,
        {oil: law for oil, law in laws.items() if not obstacle(law)},
        films(settings),
        settings.gates.lambda_limit,
        results.replace(**own),
        settings.campaign.truth_is_law,
    )


def printed_evidence(printed: Mapping[str, FloatArray], settings: Settings) -> Evidence:
    """The constants that the paper prints, signs restored; the most viscous oil first."""
    laws = {
        oil: FittedLaw(DENG2026, Coefficients.bare(DENG2026, row)) for oil, row in printed.items()
    }
    return Evidence("printed", list(laws), laws, films(settings), settings.gates.lambda_limit)


def boxes_of(settings: Settings) -> dict[str, Grid]:
    """The boxes in which trends are judged, as grids."""
    slips = settings.printed.signs.slide_roll_ratio.figures
    return {
        name: Grid.spanning(box, settings.audit.levels, slips)
        for name, box in settings.printed.boxes.model_dump().items()
    }


def audit(
    claims: Sequence[Claim], evidence: Sequence[Evidence], settings: Settings
) -> dict[str, pd.DataFrame]:
    """Tables `claims`, one row per claim and basis in the paper's order, and `claim_numbers`.

    Claims on speeds alone need no fit: they are judged once, with what the paper prints.

    Args:
        claims: The paper's claims.
        evidence: The bases.
        settings: `audit`, `selection` and `printed`.
    """
    boxes = boxes_of(settings)
    rows: list[dict[str, Any]] = []
    numbers: list[dict[str, Any]] = []
    for claim, basis in itertools.product(claims, evidence):
        check = CHECKS[claim.id]
        if check.where == "formula" and basis.basis != "printed":
            continue
        key = {"claim": claim.id, "basis": basis.basis}
        grids = boxes if check.where in boxes else {check.where: boxes["tested"]}
        views = {name: View(basis, grid, settings) for name, grid in grids.items()}
        row, further = _judge(claim, views, settings)
        rows.append(key | {"judged_on": check.where, **row})
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


def _judge(
    claim: Claim, views: Mapping[str, View], settings: Settings
) -> tuple[dict[str, Any], Numbers]:
    """What the table of claims has of a claim, and the numbers that explain it.

    It holds if every fair reading of it does, and fails if none holds in a fair share.
    """
    check = CHECKS[claim.id]
    outcomes: dict[str, Outcome] = {}
    reason = ""
    for name, view in views.items():
        try:
            outcomes[name] = check.judge(view)
        except NotCheckableError as why:
            # a box may have no condition that the claim is about
            if name == check.where or str(why) != "no condition":
                reason = reason or str(why)
    if reason:
        unchecked = {"verdict": "cannot be checked", "reason_code": reason, "worst_oil": ""}
        return {**unchecked, "cases": 0}, {}
    outcome = outcomes[check.where]
    others = (outcome.numbers.get(name, np.nan) for name in claim.readings)
    known = [share for share in others if isinstance(share, float) and not np.isnan(share)]
    read = [outcome.share, *known]
    if min(read) >= settings.audit.holds_share and outcome.complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    else:
        verdict = "fails" if max(read) < settings.audit.fails_share else "holds in part"
    by_oil = outcome.cases.groupby("oil", sort=False)["holds"].mean().drop("", errors="ignore")
    return {
        "verdict": verdict,
        "reason_code": "",
        "cases": len(outcome.cases),
        "share": outcome.share,
        **{f"share_{name}_box": each.share for name, each in outcomes.items()},
        **outcome.worst_case(check.worst).add_prefix("worst_"),
    }, {"share": {str(oil): share for oil, share in by_oil.items()}, **outcome.numbers}
