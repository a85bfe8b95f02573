"""The tables of claims: every claim of the paper on every basis, with verdict and numbers.

`Evidence` is what claims are held against, `Finding` what a check finds.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import of_matrix
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.paper.audit import checks
from oilfilm.paper.reference import Claim, printed_constants, read_claims
from oilfilm.physics.film import Thickness
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Grid, films, obstacle, traction
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import BoolArray, FloatArray

# Further numbers of a claim by name: one, or one per oil.
Numbers = dict[str, float | dict[str, float]]


class NotCheckableError(Exception):
    """A claim cannot be checked; the message is a code of data/reference/claims.yaml."""


@dataclass(frozen=True)
class Outcome:
    """Every case in which a claim was checked, and how it fared.

    Attributes:
        cases: Columns oil, holds, value and the grid's axes (null where a case spans an axis).
        numbers: Further numbers by name, as shares of parts of the claim.
        by_construction: Whether the claim is true whatever the oils are.
        complete: False where something beside the cases fails, so that the claim holds in part
            at most.
    """

    cases: pd.DataFrame
    numbers: Numbers
    by_construction: bool = False
    complete: bool = True

    @property
    def share(self) -> float:
        """Share of the cases in which the claim holds."""
        return float(self.cases["holds"].mean())

    def worst_case(self, worst: Literal["largest", "smallest"]) -> pd.Series:
        """The case farthest from holding; of those that hold the nearest to failing."""
        failing = self.cases[~self.cases["holds"]]
        among = self.cases if failing.empty else failing
        values = among["value"].to_numpy()
        index = (values if worst == "largest" else -values).argmax()
        return among.iloc[int(index)].reindex(["oil", *AXES, "value"])


def outcome(cases: pd.DataFrame, **numbers: Any) -> Outcome:
    """An outcome with further numbers; of an array of truths its share, NaN where it is empty."""

    def number(each: Any) -> Any:
        if isinstance(each, dict):
            return {name: number(part) for name, part in each.items()}
        truths = isinstance(each, np.ndarray) and each.dtype == bool
        return float(each if not truths else each.mean() if each.size else np.nan)

    return Outcome(cases, number(numbers))


@dataclass(frozen=True)
class View:
    """One basis of the verdicts over a grid of operating conditions, as a check sees it.

    Arrays have the axes oil, P, U, T, S, of length 1 where a case spans an axis.

    Attributes:
        basis: Name of it: `refit` or `printed`.
        falling_viscosity: The oils that the claims are about, the most viscous first.
        laws: Law of each oil that has all its constants.
        settings: The settings.
        grid: The operating conditions.
        measured: Tables of points, fit quality and torque; empty where the basis has none.
        truth_is_law: Whether the points were simulated with the paper's law.
    """

    basis: str
    falling_viscosity: Sequence[str]
    laws: Mapping[str, FittedLaw]
    settings: Settings
    grid: Grid
    measured: CampaignTables = field(default_factory=CampaignTables.in_memory)
    truth_is_law: bool = False

    def at(self, **levels: Sequence[float] | FloatArray) -> "View":
        """The same with other levels on some axes of the grid."""
        return replace(self, grid=self.grid.at(**levels))

    def rows(self, table: str, *, reason: str) -> pd.DataFrame:
        """A table of the basis.

        Raises:
            NotCheckableError: The basis has none.
        """
        if (frame := self.measured.table(table)).empty:
            raise NotCheckableError("not printed" if self.basis == "printed" else reason)
        return frame

    @property
    def curve(self) -> FloatArray:
        """Slips of a whole curve."""
        end = self.settings.printed.boxes.tested.slide_roll_ratio[1]
        return np.linspace(0.0, end, self.settings.audit.curve_points)

    def mu(
        self, oils: Sequence[str] | None = None, **levels: Sequence[float] | FloatArray
    ) -> FloatArray:
        """mu over the grid, with other levels on some axes, of every oil with a law.

        Raises:
            NotCheckableError: None has one, or one of the given oils has none.
        """
        oils, grid = list(self.laws) if oils is None else oils, self.grid.at(**levels)
        if not oils or not set(oils) <= set(self.laws):
            raise NotCheckableError("no law")
        return np.stack([traction(self.laws[oil], grid) for oil in oils])

    def mu_by_viscosity(self, **levels: Sequence[float] | FloatArray) -> FloatArray:
        """The same of the oils that the claims are about, the most viscous first."""
        return self.mu(self.falling_viscosity, **levels)

    def films(self, *oils: str, thickness: Thickness | None = None) -> FloatArray:
        """Film thickness in um and lambda over the grid, shape (2, oils, P, U, T, S).

        Args:
            oils: The oils; without any, those of the claims whose film is known.
            thickness: Which film; that of the settings if not given.

        Raises:
            NotCheckableError: An oil or the contact is not known well enough.
        """
        known = films(self.settings)
        oils = oils or tuple(oil for oil in self.falling_viscosity if oil in known)
        if not oils or not set(oils) <= set(known):
            raise NotCheckableError("no film")
        how = thickness or self.settings.film.thickness
        each = [replace(known[oil], thickness=how).over(self.grid) for oil in oils]
        return np.stack(each, axis=1)

    def by_oil(
        self, summary: Callable[[FloatArray], float], values: FloatArray
    ) -> dict[str, float]:
        """One number per oil from an array whose first axis is that of the oils with a law."""
        return {oil: float(summary(part)) for oil, part in zip(self.laws, values, strict=True)}

    def outcome(self, holds: BoolArray, value: FloatArray, **numbers: Any) -> Outcome:
        """What a check finds over the grid.

        Args:
            holds: True where the claim holds.
            value: The quantity that decides.
            numbers: Further numbers, as for `outcome`.
        """
        oils = [*self.laws] if len(holds) == len(self.laws) else [""]
        return outcome(self.cases(oils, holds, value), **numbers)

    def cases(self, oils: Sequence[str], holds: BoolArray, value: FloatArray) -> pd.DataFrame:
        """Cases from arrays over the grid; one oil of no name where a case compares oils."""
        axes = [
            levels if length > 1 or len(levels) == 1 else np.array([np.nan])
            for levels, length in zip(self.grid.levels, holds.shape[1:], strict=True)
        ]
        mesh = np.meshgrid(np.asarray(oils, dtype=object), *axes, indexing="ij")
        at = {name: level.ravel() for name, level in zip(("oil", *AXES), mesh, strict=True)}
        value = np.broadcast_to(value, holds.shape)
        return pd.DataFrame({**at, "holds": holds.ravel(), "value": value.ravel()})


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
    levels, slips = settings.audit.levels, settings.printed.signs.slide_roll_ratio.figures
    return Grid.spanning(settings.printed.boxes.model_dump()[name], levels, slips)


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
    audit, grid = basis.settings.audit, basis.grid
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
    if min(read) >= audit.holds_share and outcome.complete:
        verdict = "by construction" if outcome.by_construction else "holds"
    else:
        verdict = "fails" if max(read) < audit.fails_share else "holds in part"
    by_oil = outcome.cases.groupby("oil", sort=False)["holds"].mean().drop("", errors="ignore")
    return {
        "verdict": verdict,
        "reason_code": "",
        "cases": len(outcome.cases),
        "share": outcome.share,
        **outcome.worst_case(claim.worst).add_prefix("worst_"),
    }, {"share": {str(oil): share for oil, share in by_oil.items()}, **outcome.numbers}
