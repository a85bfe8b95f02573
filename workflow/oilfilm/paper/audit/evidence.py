"""What claims are held against, and what a check finds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import pandas as pd

from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Film, Grid, traction
from oilfilm.units import BoolArray, FloatArray

# Further numbers of a claim by name: one, or one per oil.
Numbers = dict[str, float | dict[str, float]]
Worst = Literal["largest", "smallest"]


class NotCheckableError(Exception):
    """A claim cannot be checked; the message is a code of data/reference/claims.yaml."""


@dataclass(frozen=True)
class Evidence:
    """One basis on which the claims are judged.

    Attributes:
        basis: Name of it: `refit` or `printed`.
        falling_viscosity: The oils that the claims are about, the most viscous first.
        laws: Law of each oil that has all its constants.
        films: Film of each oil whose properties are known, in the contact of the rig.
        lambda_limit: Full film above.
        measured: Tables of points, fit quality and torque; empty where the basis has none.
        truth_is_law: Whether the points were simulated with the paper's law.
    """

    basis: str
    falling_viscosity: Sequence[str]
    laws: Mapping[str, FittedLaw]
    films: Mapping[str, Film]
    lambda_limit: float
    measured: CampaignTables = field(default_factory=CampaignTables.in_memory)
    truth_is_law: bool = False

    def rows(self, table: str, *, reason: str) -> pd.DataFrame:
        """A table of the basis.

        Raises:
            NotCheckableError: The basis has none.
        """
        if (frame := self.measured.table(table)).empty:
            raise NotCheckableError("not printed" if self.basis == "printed" else reason)
        return frame


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
    numbers: Numbers = field(default_factory=dict)
    by_construction: bool = field(default=False, kw_only=True)
    complete: bool = field(default=True, kw_only=True)

    @property
    def share(self) -> float:
        """Share of the cases in which the claim holds."""
        return float(self.cases["holds"].mean())

    def worst_case(self, worst: Worst) -> pd.Series:
        """The case farthest from holding; of those that hold the nearest to failing."""
        failing = self.cases[~self.cases["holds"]]
        among = self.cases if failing.empty else failing
        values = among["value"].to_numpy()
        index = (values if worst == "largest" else -values).argmax()
        return among.iloc[int(index)].reindex(["oil", *AXES, "value"])


@dataclass(frozen=True)
class View:
    """One basis over a grid of operating conditions, as a check sees it.

    Arrays have the axes oil, P, U, T, S, of length 1 where a case spans an axis.
    """

    evidence: Evidence
    grid: Grid
    settings: Settings

    def at(self, **levels: Sequence[float] | FloatArray) -> "View":
        """The same with other levels on some axes of the grid."""
        return replace(self, grid=self.grid.at(**levels))

    @property
    def oils(self) -> tuple[str, ...]:
        """Oils that have a law.

        Raises:
            NotCheckableError: None has.
        """
        if not self.evidence.laws:
            raise NotCheckableError("no law")
        return tuple(self.evidence.laws)

    @property
    def curve(self) -> FloatArray:
        """Slips of a whole curve."""
        end = self.settings.printed.boxes.tested.slide_roll_ratio[1]
        return np.linspace(0.0, end, self.settings.audit.curve_points)

    def mu(self, **levels: Sequence[float] | FloatArray) -> FloatArray:
        """mu over the grid, with other levels on some axes, of every oil with a law."""
        grid = self.grid.at(**levels)
        return np.stack([traction(self.evidence.laws[oil], grid) for oil in self.oils])

    def mu_by_viscosity(self, **levels: Sequence[float] | FloatArray) -> FloatArray:
        """The same of the oils that the claims are about, the most viscous first.

        Raises:
            NotCheckableError: One of them has no law.
        """
        oils, laws, grid = (
            self.evidence.falling_viscosity,
            self.evidence.laws,
            self.grid.at(**levels),
        )
        if not set(oils) <= set(laws):
            raise NotCheckableError("no law")
        return np.stack([traction(laws[oil], grid) for oil in oils])

    def film(self, oil: str) -> tuple[FloatArray, FloatArray]:
        """Film thickness in um and lambda of one oil over the grid.

        Raises:
            NotCheckableError: Oil or contact are not known well enough.
        """
        if oil not in self.evidence.films:
            raise NotCheckableError("no film")
        return self.evidence.films[oil].over(self.grid)

    def of_most_viscous(self, holds: BoolArray) -> BoolArray:
        """The cases of the most viscous oil, which the paper shows; none where it has no law."""
        return holds[[oil == self.evidence.falling_viscosity[0] for oil in self.oils]]

    def central_film(self) -> FloatArray:
        """Central film thickness in um over the box and its whole curves, oils in rows."""
        slips = [0.0, *self.grid.slide_roll_ratio, self.curve[-1]]
        films = [self.evidence.films.get(oil) for oil in self.evidence.falling_viscosity]
        central = {"thickness": "central"}
        return np.array(
            [
                replace(film, settings=film.settings.model_copy(update=central)).over(
                    self.grid.at(slide_roll_ratio=slips)
                )[0]
                for film in films
                if film
            ]
        )

    def by_oil(
        self, summary: Callable[[FloatArray], float], values: FloatArray
    ) -> dict[str, float]:
        """One number per oil from an array whose first axis is that of the oils."""
        return {oil: float(summary(part)) for oil, part in zip(self.oils, values, strict=True)}

    def outcome(self, holds: BoolArray, value: FloatArray, **numbers: Any) -> Outcome:
        """What a check finds over the grid.

        Args:
            holds: True where the claim holds.
            value: The quantity that decides.
            numbers: Further numbers; of an array of truths its share.
        """
        oils = self.oils if len(holds) == len(self.oils) else [""]
        return Outcome(cases(self.grid, oils, holds, value), shares(numbers))


def shares(numbers: Mapping[str, Any]) -> Numbers:
    """Numbers, with the share of the cases for arrays of truths; NaN where there are none."""
    return {
        name: (float(each.mean()) if each.size else np.nan)
        if isinstance(each, np.ndarray) and each.dtype == bool
        else each
        for name, each in numbers.items()
    }


def cases(grid: Grid, oils: Sequence[str], holds: BoolArray, value: FloatArray) -> pd.DataFrame:
    """Cases from arrays of shape (oils, P, U, T, S), of length 1 along each axis they span.

    Args:
        grid: The grid whose axes the arrays have or span.
        oils: Oils of the first axis; one empty text where a case compares oils.
        holds: True where the claim holds.
        value: The quantity that decides.
    """
    axes = [
        levels if length > 1 or len(levels) == 1 else np.array([np.nan])
        for levels, length in zip(grid.levels, holds.shape[1:], strict=True)
    ]
    of_oil, *mesh = np.meshgrid(np.arange(len(oils)), *axes, indexing="ij")
    conditions = {name: level.ravel() for name, level in zip(AXES, mesh, strict=True)}
    value = np.broadcast_to(value, holds.shape).ravel()
    names = np.asarray(oils)[of_oil.ravel()]
    return pd.DataFrame({"oil": names, **conditions, "holds": holds.ravel(), "value": value})
