"""What claims are held against, and what a check finds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.torque.operating_grid import AXES, Film, Grid, traction
from oilfilm.units import BoolArray, FloatArray

# Further numbers of a claim by name: one, or one per oil.
Numbers = dict[str, float | dict[str, float]]


class NotCheckableError(Exception):
    """A claim cannot be checked; the message is a code of `oilfilm.paper.audit.reasons`."""


@dataclass(frozen=True)
class Evidence:
    """One basis on which the claims are judged.

    Attributes:
        basis: Name of it: `refit` or `printed`.
        falling_viscosity: The oils that the claims are about, the most viscous first.
        laws: Law of each oil that has all its constants.
        films: Film of each oil whose properties are known, in the contact of the rig.
        lambda_limit: Full film above.
        points: Measured points with lambda; None where the basis has none.
        comparison: Table of the laws compared; empty where it was not made.
        torque: Table of bearing torque; empty where the basis has none.
        torque_control: Table of what simulated torque can show; empty where it was measured.
        truth_is_law: Whether the points were simulated with the paper's law.
    """

    basis: str
    falling_viscosity: Sequence[str]
    laws: Mapping[str, FittedLaw]
    films: Mapping[str, Film]
    lambda_limit: float
    points: pd.DataFrame | None = None
    comparison: pd.DataFrame = field(default_factory=partial(tables.empty, "fit_quality"))
    torque: pd.DataFrame = field(default_factory=partial(tables.empty, "torque"))
    torque_control: pd.DataFrame = field(default_factory=partial(tables.empty, "torque_control"))
    truth_is_law: bool = False

    def of_paper(self) -> "Evidence":
        """The same of the oils that the claims are about: the paper says nothing of others."""
        paper = self.falling_viscosity

        def kept(table: pd.DataFrame) -> pd.DataFrame:
            return table[table["oil"].isin(paper)]

        return replace(
            self,
            laws={oil: law for oil, law in self.laws.items() if oil in paper},
            points=None if self.points is None else kept(self.points),
            comparison=kept(self.comparison),
            torque=kept(self.torque),
            torque_control=kept(self.torque_control),
        )

    @property
    def oils(self) -> tuple[str, ...]:
        """Oils that have a law.

        Raises:
            NotCheckableError: None has.
        """
        if not self.laws:
            raise NotCheckableError("no law")
        return tuple(self.laws)

    def traction(self, grid: Grid) -> FloatArray:
        """mu over a grid, of every oil with a law: shape (oils, P, U, T, S)."""
        return np.stack([traction(self.laws[oil], grid) for oil in self.oils])

    def traction_by_viscosity(self, grid: Grid) -> FloatArray:
        """The same of the oils that the claims are about, the most viscous first.

        Raises:
            NotCheckableError: One of them has no law.
        """
        if not set(self.falling_viscosity) <= set(self.laws):
            raise NotCheckableError("no law")
        return np.stack([traction(self.laws[oil], grid) for oil in self.falling_viscosity])

    def film(self, oil: str, grid: Grid) -> tuple[FloatArray, FloatArray]:
        """Film thickness in um and lambda of one oil over a grid.

        Raises:
            NotCheckableError: Oil or contact are not known well enough.
        """
        if oil not in self.films:
            raise NotCheckableError("no film")
        return self.films[oil].over(grid)

    def by_oil(
        self, summary: Callable[[FloatArray], float], values: FloatArray
    ) -> dict[str, float]:
        """One number per oil from an array whose first axis is that of the oils."""
        return {oil: float(summary(part)) for oil, part in zip(self.oils, values, strict=True)}


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

    def worst_case(self, worst: Literal["largest", "smallest"]) -> pd.Series:
        """The case farthest from holding; of those that hold the nearest to failing."""
        failing = self.cases[~self.cases["holds"]]
        among = self.cases if failing.empty else failing
        values = among["value"].to_numpy()
        index = (values if worst == "largest" else -values).argmax()
        return among.iloc[int(index)].reindex(["oil", *AXES, "value"])


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
