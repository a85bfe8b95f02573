"""The table of claims: every claim of the paper on every basis, with its verdict in words."""

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
from oilfilm.paper.audit.evidence import Evidence, NotCheckableError, Outcome, share
from oilfilm.paper.reference import Claim, Claims, falling_viscosity, printed_constants
from oilfilm.paper.selection import select
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Grid, films, obstacle
from oilfilm.traction.law import FloatArray
from oilfilm.traction.laws.deng2026 import DENG2026

_JUDGED_ON = {
    "tested": "the box tested by the paper",
    "extrapolated": "the box of figs 7 to 10",
    "data": "the campaign's data",
    "formula": "the paper's Eq. 1",
}
_CONDITION_FORMS = ("P {:.3g} GPa", "U {:.3g} m/s", "T {:.3g} degC", "S {:.3g}")


def read_claims(path: Path) -> list[Claim]:
    """The claims of the paper.

    Raises:
        OilfilmError: The file has a mistake, or names a claim that has no check or lacks one.
    """
    claims: list[Claim] = load(path, Claims).claims
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
    """Tables `claims` and `selection`: the refit and the printed constants against the paper.

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
        "claims": audit(read_claims(claims), bases, settings),
        # its rules may name other oils than the paper's
        "selection": select([refit, *bases[1:]], settings.selection, box),
    }


def refit_evidence(
    results: CampaignTables, viscosity_order: Sequence[str], settings: Settings
) -> Evidence:
    """The campaign's own fits, points and whatever was made of them."""
    coefficients = results.configured.coefficients
    laws = {str(oil): FittedLaw.of(coefficients, oil) for oil in coefficients["oil"].unique()}
    unknown = {oil: why for oil, law in laws.items() if (why := obstacle(law))}
    return Evidence(
        "refit",
        viscosity_order,
        {oil: law for oil, law in laws.items() if oil not in unknown},
        unknown,
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
    return Evidence(
        "printed", viscosity_order, laws, {}, films(settings), settings.gates.lambda_limit
    )


def boxes_of(settings: Settings) -> dict[str, Grid]:
    """The boxes in which trends are judged, as grids."""
    slips = settings.printed.signs.slide_roll_ratio.figures
    return {
        name: Grid.spanning(box, settings.audit.levels, slips)
        for name, box in settings.printed.boxes.model_dump().items()
    }


def audit(
    claims: Sequence[Claim], evidence: Sequence[Evidence], settings: Settings
) -> pd.DataFrame:
    """Table of claims: one row per claim and basis, in the paper's order.

    Claims on speeds alone need no fit: they are judged once, with what the paper prints.

    Args:
        claims: The paper's claims.
        evidence: The bases.
        settings: `audit`, `selection` and `printed`.
    """
    boxes = boxes_of(settings)
    keys = {name: getattr(settings, name) for name in ("audit", "printed", "selection")}
    rows = [
        {
            "claim": claim.id,
            "section": claim.section,
            "statement": claim.claim,
            "wording": claim.wording.strip(),
            "basis": basis.basis,
            "definition": CHECKS[claim.id].definition.format(**keys),
            **_judge(CHECKS[claim.id], basis, boxes, settings),
        }
        for claim in claims
        for basis in evidence
        if CHECKS[claim.id].where != "formula" or basis.basis == "printed"
    ]
    return tables.from_rows(rows, "claims")


def _judge(
    check: Check, evidence: Evidence, boxes: Mapping[str, Grid], settings: Settings
) -> dict[str, Any]:
    grids = boxes if check.where in boxes else {check.where: boxes["tested"]}
    row: dict[str, Any] = {
        "judged_on": _JUDGED_ON[check.where],
        "verdict": "cannot be checked",
        "cases": 0,
        **dict.fromkeys(("share", "share_tested_box", "share_extrapolated_box"), np.nan),
        "worst_quantity": "",
        "worst_oil": "",
        "worst_detail": "",
        **dict.fromkeys((f"worst_{name}" for name in (*AXES, "value")), np.nan),
    }
    try:
        if evidence.obstacle:
            raise NotCheckableError(evidence.obstacle)
        outcomes = {name: check.judge(evidence, grid, settings) for name, grid in grids.items()}
    except NotCheckableError as reason:
        return row | {"finding": f"cannot be checked: {reason}"}
    outcome = outcomes[check.where]
    if outcome is None:
        box = _JUDGED_ON[check.where]
        return row | {
            "finding": f"cannot be checked: {box} has no condition that the claim is about"
        }
    if outcome.share >= settings.audit.holds_share and outcome.complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    else:
        verdict = "fails" if outcome.share < settings.audit.fails_share else "holds in part"
    row |= {
        f"share_{name}_box": other.share
        for name, other in outcomes.items()
        if name in boxes and other is not None
    }
    worst = outcome.worst_case
    return row | {
        "verdict": verdict,
        "finding": _sentence(outcome, evidence),
        "share": outcome.share,
        "cases": len(outcome.cases),
        **worst.add_prefix("worst_"),
        "worst_quantity": outcome.quantity,
    }


def _sentence(outcome: Outcome, evidence: Evidence) -> str:
    """Shares, parts, worst case and remarks, in plain words."""
    by_oil = outcome.cases.groupby("oil", sort=False)["holds"].mean()
    why = f"By construction: {outcome.by_construction}" if outcome.by_construction else ""
    first = f"Holds in {percent(outcome.share)} of {len(outcome.cases)} cases"
    if len(by_oil) > 1:
        first += f" ({', '.join(f'{oil} {percent(value)}' for oil, value in by_oil.items())})"
    parts = "; ".join(f"{part}: {percent(share(holds))}" for part, holds in outcome.parts.items())
    sentences = [f"{text}." for text in (why, first, parts, _worst(outcome)) if text]
    left_out = [f"Left out: {oil} ({why})." for oil, why in evidence.unknown.items()]
    return " ".join([*sentences, *outcome.remarks, *left_out])


def _worst(outcome: Outcome) -> str:
    """The worst case: its value, its oil and its conditions."""
    worst = outcome.worst_case
    conditions = [worst["oil"]] if worst["oil"] else []
    conditions += [
        form.format(worst[name])
        for name, form in zip(AXES, _CONDITION_FORMS, strict=True)
        if not np.isnan(worst[name])
    ]
    head = "Worst case" if outcome.share < 1 else "Case nearest to failing"
    where = f" ({', '.join(conditions)})" if conditions else ""
    detail = f" ({worst['detail']})" if worst["detail"] else ""
    return f"{head}{where}, {outcome.quantity}: {worst['value']:{outcome.form}}{detail}"


def percent(share: float) -> str:
    """A share in percent, 100 or 0 only where it is all or none; "no case" where there is none."""
    if np.isnan(share):
        return "no case"
    near = not 0.01 <= share <= 0.99 and share not in (0.0, 1.0)
    return f"{min(max(share, 0.001), 0.999):.1%}" if near else f"{share:.0%}"


def _of_matrix(points: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """Points of these runs that no gate but the film's own refused."""
    kept = points[failed_gates.failed_none_but(points, "thin_film")]
    return kept[kept["run_id"].isin(runs["run_id"])]
