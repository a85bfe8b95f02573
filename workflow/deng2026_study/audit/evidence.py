"""What claims are held against, and what a check finds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
import pandas as pd

from deng2026_study.settings import StudySettings, study_settings
from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.film import Thickness
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Grid, films, traction

# Further numbers of a claim by name: one, or one per oil.
Numbers = dict[str, float | dict[str, float]]


class NotCheckableError(Exception):
    """A claim cannot be checked; the message is a code of reference/claims.yaml."""


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
        index = first_largest(values if worst == "largest" else -values)
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

    @cached_property
    def study(self) -> StudySettings:
        """The settings of the study."""
        return study_settings(self.settings)

    @property
    def curve(self) -> FloatArray:
        """Slips of a whole curve."""
        end = self.study.printed.boxes.tested.slide_roll_ratio[1]
        return np.linspace(0.0, end, self.study.audit.curve_points)

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
