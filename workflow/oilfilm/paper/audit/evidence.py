"""What claims are held against, and what a check finds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.torque.operating_grid import AXES, Film, Grid, traction
from oilfilm.units import BoolArray, FloatArray


class NotCheckableError(Exception):
    """A claim cannot be checked; the message says why, as the end of a sentence."""


@dataclass(frozen=True)
class Evidence:
    """One basis on which the claims are judged.

    Attributes:
        basis: Name of it: `refit` or `printed`.
        falling_viscosity: The oils that the claims are about, the most viscous first.
        laws: Law of each oil that has all its constants.
        unknown: Why an oil has no such law, by oil.
        films: Film of each oil whose properties are known, in the contact of the rig.
        lambda_limit: Full film above.
        points: Measured points with lambda; None where the basis has none.
        comparison: Table of the laws compared; empty where it was not made.
        torque: Table of bearing torque; empty where the basis has none.
        torque_control: Table of what simulated torque can show; empty where it was measured.
        truth_is_law: Whether the points were simulated with the paper's law.
        obstacle: Why no claim can be checked on this basis, as the end of a sentence; empty where
            some may be.
    """

    basis: str
    falling_viscosity: Sequence[str]
    laws: Mapping[str, FittedLaw]
    unknown: Mapping[str, str]
    films: Mapping[str, Film]
    lambda_limit: float
    points: pd.DataFrame | None = None
    comparison: pd.DataFrame = field(default_factory=partial(tables.empty, "fit_quality"))
    torque: pd.DataFrame = field(default_factory=partial(tables.empty, "torque"))
    torque_control: pd.DataFrame = field(default_factory=partial(tables.empty, "torque_control"))
    truth_is_law: bool = False
    obstacle: str = ""

    def of_paper(self) -> "Evidence":
        """The same of the oils that the claims are about: the paper says nothing of others."""
        paper = self.falling_viscosity
        known = {*self.laws, *self.unknown}
        own = {oil: "the paper did not test it" for oil in known if oil not in paper}

        def kept(table: pd.DataFrame) -> pd.DataFrame:
            return table[table["oil"].isin(paper)]

        return replace(
            self,
            laws={oil: law for oil, law in self.laws.items() if oil in paper},
            unknown={**self.unknown, **own},
            points=None if self.points is None else kept(self.points),
            comparison=kept(self.comparison),
            torque=kept(self.torque),
            torque_control=kept(self.torque_control),
            obstacle=f"the campaign has none of the oils that the paper tested ({', '.join(paper)})"
            if known and len(own) == len(known)
            else "",
        )

    @property
    def oils(self) -> tuple[str, ...]:
        """Oils that have a law.

        Raises:
            NotCheckableError: None has.
        """
        if not self.laws:
            raise NotCheckableError(self._reasons(self.unknown) or "no oil has a traction law")
        return tuple(self.laws)

    def traction(self, grid: Grid) -> FloatArray:
        """mu over a grid, of every oil with a law: shape (oils, P, U, T, S)."""
        return np.stack([traction(self.laws[oil], grid) for oil in self.oils])

    def traction_by_viscosity(self, grid: Grid) -> FloatArray:
        """The same of the oils that the claims are about, the most viscous first.

        Raises:
            NotCheckableError: One of them has no law.
        """
        lacking = [oil for oil in self.falling_viscosity if oil not in self.laws]
        if lacking:
            reasons = {oil: self.unknown.get(oil, "there is no fit of it") for oil in lacking}
            raise NotCheckableError(self._reasons(reasons))
        return np.stack([traction(self.laws[oil], grid) for oil in self.falling_viscosity])

    def film(self, oil: str, grid: Grid) -> tuple[FloatArray, FloatArray]:
        """Film thickness in um and lambda of one oil over a grid.

        Raises:
            NotCheckableError: Oil or contact are not known well enough.
        """
        if oil not in self.films:
            raise NotCheckableError(
                f"the film of {oil} cannot be calculated: the campaign lacks the oil's properties "
                "or the rig's geometry and roughness"
            )
        return self.films[oil].over(grid)

    @staticmethod
    def _reasons(reasons: Mapping[str, str]) -> str:
        return "; ".join(f"{oil}: {reason}" for oil, reason in reasons.items())


@dataclass(frozen=True)
class Outcome:
    """Every case in which a claim was checked, and how it fared.

    Attributes:
        cases: Columns oil, holds, value, the grid's axes (null where a case spans an axis), and
            `detail` where more is to be said of a case.
        quantity: What `value` is, for a sentence.
        form: How to print it.
        worst: Which value is the worst.
        parts: Where each part of the claim holds.
        remarks: Further figures, a sentence each.
        by_construction: Why the claim is true whatever the oils are; empty where it need not be.
        complete: False where something beside the cases fails, so that the claim holds in part
            at most.
    """

    cases: pd.DataFrame
    quantity: str
    form: str = ".2f"
    worst: Literal["largest", "smallest"] = field(kw_only=True)
    parts: Mapping[str, BoolArray] = field(default_factory=dict, kw_only=True)
    remarks: Sequence[str] = field(default=(), kw_only=True)
    by_construction: str = field(default="", kw_only=True)
    complete: bool = field(default=True, kw_only=True)

    @property
    def share(self) -> float:
        """Share of the cases in which the claim holds."""
        return float(self.cases["holds"].mean())

    @property
    def worst_case(self) -> pd.Series:
        """The case farthest from holding; of those that hold the nearest to failing."""
        failing = self.cases[~self.cases["holds"]]
        among = self.cases if failing.empty else failing
        values = among["value"].to_numpy()
        index = (values if self.worst == "largest" else -values).argmax()
        worst = among.iloc[int(index)].reindex(["oil", *AXES, "value", "detail"])
        return worst.fillna({"detail": ""})


def share(holds: BoolArray) -> float:
    """Share of the cases in which something holds; NaN where there are none."""
    return float(holds.mean()) if holds.size else np.nan


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
