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
from oilfilm.paper.audit.checks import CHECKS, Check
from oilfilm.paper.audit.evidence import Evidence, NotCheckableError, Numbers, Outcome
from oilfilm.paper.reference import Claim, falling_viscosity, printed_constants, read_claims
from oilfilm.paper.selection import select
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Grid, films, obstacle
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import FloatArray


def checked_claims(path: Path) -> list[Claim]:
    """The claims of the paper, each with its check.

    Raises:
        OilfilmError: The file has a mistake, or names a claim that has no check or lacks one.
    """
    claims = read_claims(path)
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
    """Tables `claims`, `claim_numbers` and `selection`, by the refit and by the printed constants.

    A campaign without any oil of the paper has neither claims nor printed constants.

    Args:
        results: Tables `coefficients`, `points`, `runs`, `comparison`, `torque` and
            `torque_control`.
        printed: File of the printed constants.
        claims: File of the paper's claims.
        settings: `audit`, `film`, `gates`, `oils`, `printed`, `rigs`, `same_set_point`,
            `selection` and the campaign's `matrix` and `twin`.

    Raises:
        OilfilmError: A reference file has a mistake, or a rule of the selection is missing.
    """
    oils = falling_viscosity(printed)
    refit = refit_evidence(results, oils, settings)
    as_printed = printed_evidence(printed_constants(printed), oils, settings)
    box = settings.printed.boxes.extrapolated.model_dump()
    # the paper says nothing of other oils
    of_paper = any(oil in oils for oil in settings.oils)
    bases = [refit.of_paper(), as_printed] if of_paper else []
    return {
        **audit(checked_claims(claims), bases, settings),
        # its rules may name other oils than the paper's
        "selection": select([refit, *bases[1:]], settings.selection, box),
    }


def refit_evidence(
    results: CampaignTables, viscosity_order: Sequence[str], settings: Settings
) -> Evidence:
    """The campaign's own fits, points and whatever was made of them."""
    coefficients = results.configured.coefficients
    laws = {str(oil): FittedLaw.of(coefficients, oil) for oil in coefficients["oil"].unique()}
    return Evidence(
        "refit",
        viscosity_order,
        {oil: law for oil, law in laws.items() if not obstacle(law)},
        films(settings),
        settings.gates.lambda_limit,
        _of_matrix(results.points, of_matrix(results.runs, settings)),
        results.fit_quality,
        results.torque,
        results.torque_control,
        settings.campaign.truth_is_law,
    )


def printed_evidence(
    printed: Mapping[str, FloatArray], viscosity_order: Sequence[str], settings: Settings
) -> Evidence:
    """The constants that the paper prints, signs restored."""
    laws = {
        oil: FittedLaw(DENG2026, Coefficients.bare(DENG2026, row)) for oil, row in printed.items()
    }
    return Evidence("printed", viscosity_order, laws, films(settings), settings.gates.lambda_limit)


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
        if CHECKS[claim.id].where == "formula" and basis.basis != "printed":
            continue
        key = {"claim": claim.id, "basis": basis.basis}
        row, further = _judge(CHECKS[claim.id], basis, boxes, settings)
        rows.append(key | row)
        numbers += [
            {**key, "number": name, "oil": oil, "value": value}
            for name, values in further.items()
            for oil, value in (values if isinstance(values, dict) else {"": values}).items()
            if not np.isnan(value)
        ]
    return {
        "claims": tables.from_rows(rows, "claims"),
        "claim_numbers": tables.from_rows(numbers, "claim_numbers"),
    }


def _judge(
    check: Check, evidence: Evidence, boxes: Mapping[str, Grid], settings: Settings
) -> tuple[dict[str, Any], Numbers]:
    """Row of the table of claims, and the numbers that explain it."""
    grids = boxes if check.where in boxes else {check.where: boxes["tested"]}
    outcomes: dict[str, Outcome] = {}
    reason = ""
    for name, grid in grids.items():
        try:
            outcomes[name] = check.judge(evidence, grid, settings)
        except NotCheckableError as why:
            # a box may have no condition that the claim is about
            if name == check.where or str(why) != "no condition":
                reason = reason or str(why)
    row: dict[str, Any] = {
        "judged_on": check.where,
        "verdict": "cannot be checked",
        "reason_code": reason,
        "cases": 0,
        "worst_oil": "",
        **dict.fromkeys(("share", "share_tested_box", "share_extrapolated_box"), np.nan),
        **dict.fromkeys((f"worst_{name}" for name in (*AXES, "value")), np.nan),
    }
    if reason:
        return row, {}
    outcome = outcomes[check.where]
    if outcome.share >= settings.audit.holds_share and outcome.complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    else:
        verdict = "fails" if outcome.share < settings.audit.fails_share else "holds in part"
    by_oil = outcome.cases.groupby("oil", sort=False)["holds"].mean()
    shares: Numbers = {"share": {oil: by_oil[oil] for oil in outcome.cases["oil"].unique() if oil}}
    row |= {f"share_{name}_box": outcomes[name].share for name in outcomes if name in boxes}
    return row | {
        "verdict": verdict,
        "share": outcome.share,
        "cases": len(outcome.cases),
        **outcome.worst_case(check.worst).add_prefix("worst_"),
    }, shares | outcome.numbers


def _of_matrix(points: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """Points of these runs that no gate but the film's own refused."""
    kept = points[failed_gates.failed_none_but(points, "thin_film")]
    return kept[kept["run_id"].isin(runs["run_id"])]
