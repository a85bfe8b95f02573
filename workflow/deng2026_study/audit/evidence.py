"""The evidence on which claims are judged, and the outcome of a check of one claim."""

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
from oilfilm.physics.film import FilmKind
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXIS_NAMES, Grid, film_by_oil, traction_on_grid

# Further numbers of a claim by name: each one number, or one number by oil.
Numbers = dict[str, float | dict[str, float]]


class NotCheckableError(Exception):
    """A claim cannot be checked; the message is a code of reference/claims.yaml."""


@dataclass(frozen=True)
class Outcome:
    """The result of a check: every case in which a claim was checked, and further numbers.

    Attributes:
        cases: One row per case. Columns `oil`, `holds` (whether the claim holds), `value` (the
            judged quantity of the claim, in its unit) and one column per axis of the grid. A case
            that is judged over a whole axis has null there.
        numbers: Further numbers by name. Most are shares of the cases in which one part of the
            claim holds.
        by_construction: Whether the claim is true whatever the oils are.
        is_complete: False if something fails that is no case. Then the claim holds in part at most.
    """

    cases: pd.DataFrame
    numbers: Numbers
    by_construction: bool = False
    is_complete: bool = True

    @property
    def share(self) -> float:
        """Share of the cases in which the claim holds."""
        return float(self.cases["holds"].mean())

    def worst_case(self, worst: Literal["largest", "smallest"]) -> pd.Series:
        """The case that is farthest from holding. If all hold, the one that is nearest to failing.

        Args:
            worst: Which `value` is farthest from holding.
        """
        failing = self.cases[~self.cases["holds"]]
        candidates = self.cases if failing.empty else failing
        values = candidates["value"].to_numpy()
        index = first_largest(values if worst == "largest" else -values)
        return candidates.iloc[int(index)].reindex(["oil", *AXIS_NAMES, "value"])


def outcome_of_cases(cases: pd.DataFrame, **numbers: Any) -> Outcome:
    """An outcome with further numbers.

    Args:
        cases: As for `Outcome`.
        numbers: Each is a number, an array of bool, or a dictionary of these by oil. An array
            gives its share of true values, NaN if it is empty.
    """
    as_floats: Numbers = {}
    for name, content in numbers.items():
        if isinstance(content, dict):
            as_floats[name] = {oil: _as_float(value) for oil, value in content.items()}
        else:
            as_floats[name] = _as_float(content)
    return Outcome(cases, as_floats)


def _as_float(content: Any) -> float:
    """A number, or the share of true values of an array of bool."""
    if isinstance(content, np.ndarray) and content.dtype == bool:
        return float(content.mean()) if content.size else np.nan
    return float(content)


@dataclass(frozen=True)
class Evidence:
    """Laws and tables of one basis, and the grid of operating conditions on which it is judged.

    Arrays have the axes oil, P, U, T, S, of length 1 where a case spans an axis: maximum Hertz
    pressure (GPa), entrainment speed (m/s), inlet temperature (degC) and slide-roll ratio.

    Attributes:
        basis: `refit` (the campaign's fits), `printed` (the paper's constants), or `undoubted`
            (the paper's constants, without oils whose constants may be damaged).
        falling_viscosity: The oils that the claims are about, the most viscous first.
        fit_by_oil: The law of each oil that has all its constants.
        settings: The settings.
        grid: The operating conditions.
        campaign_tables: Tables of the campaign, with the rows of these oils. Empty if the basis
            is not `refit`.
        truth_is_law: Whether the points were simulated with the paper's law.
    """

    basis: str
    falling_viscosity: Sequence[str]
    fit_by_oil: Mapping[str, FittedLaw]
    settings: Settings
    grid: Grid
    campaign_tables: CampaignTables = field(default_factory=CampaignTables.from_frames)
    truth_is_law: bool = False

    def with_levels(self, **levels: Sequence[float] | FloatArray) -> "Evidence":
        """The same evidence with other levels on some axes of the grid.

        Args:
            levels: The levels of an axis by its name, one of `AXIS_NAMES`.
        """
        return replace(self, grid=self.grid.with_levels(**levels))

    def rows_of_table(self, table_name: str, *, reason: str) -> pd.DataFrame:
        """A table of the basis, which must have rows.

        Args:
            table_name: Name of the table.
            reason: Code of claims.yaml that says why the basis `refit` may have no row. The code of
                the other bases is "not printed".

        Raises:
            NotCheckableError: The table has no row.
        """
        frame = self.campaign_tables.table(table_name)
        if frame.empty:
            raise NotCheckableError(reason if self.basis == "refit" else "not printed")
        return frame

    @cached_property
    def study(self) -> StudySettings:
        """The settings of the study."""
        return study_settings(self.settings)

    @property
    def curve_slips(self) -> FloatArray:
        """Slips of a whole curve."""
        largest_slip = self.study.printed.boxes.tested.slide_roll_ratio[1]
        # the key `curve_points` is the number of slips
        return np.linspace(0.0, largest_slip, self.study.audit.curve_points)

    def mu(
        self, oils: Sequence[str] | None = None, **levels: Sequence[float] | FloatArray
    ) -> FloatArray:
        """mu over the grid, shape (oils, P, U, T, S).

        Args:
            oils: The oils; without any, every oil with a law.
            levels: As for `with_levels`.

        Raises:
            NotCheckableError: No oil has a law, or one of the given oils has none.
        """
        if oils is None:
            oils = list(self.fit_by_oil)
        grid = self.grid.with_levels(**levels)
        if not oils or not set(oils) <= set(self.fit_by_oil):
            raise NotCheckableError("no law")
        return np.stack([traction_on_grid(self.fit_by_oil[oil], grid) for oil in oils])

    def mu_by_viscosity(self, **levels: Sequence[float] | FloatArray) -> FloatArray:
        """mu over the grid of the oils that the claims are about, the most viscous first."""
        return self.mu(self.falling_viscosity, **levels)

    def films(self, *oils: str, film_kind: FilmKind | None = None) -> FloatArray:
        """Film thickness in um and lambda over the grid, shape (2, oils, P, U, T, S).

        Args:
            oils: The oils; without any, those of the claims whose film is known.
            film_kind: Which film; that of the settings if not given.

        Raises:
            NotCheckableError: An oil or the contact is not known well enough.
        """
        film_of_oil = film_by_oil(self.settings)
        if not oils:
            oils = tuple(oil for oil in self.falling_viscosity if oil in film_of_oil)
        if not oils or not set(oils) <= set(film_of_oil):
            raise NotCheckableError("no film")
        film_kind = film_kind or self.settings.film.thickness
        films_of_oils = [
            replace(film_of_oil[oil], film_kind=film_kind).on_grid(self.grid) for oil in oils
        ]
        return np.stack(films_of_oils, axis=1)

    def summary_by_oil(
        self, summary: Callable[[FloatArray], float], values: FloatArray
    ) -> dict[str, float]:
        """One number per oil from an array whose first axis is that of the oils with a law."""
        values_of_oil = zip(self.fit_by_oil, values, strict=True)
        return {oil: float(summary(values_of_one)) for oil, values_of_one in values_of_oil}

    def outcome_on_grid(self, holds: BoolArray, value: FloatArray, **numbers: Any) -> Outcome:
        """The outcome of a check over the grid.

        Args:
            holds: True where the claim holds.
            value: The judged quantity of the claim, in its unit.
            numbers: Further numbers, as for `outcome_of_cases`.
        """
        oils = list(self.fit_by_oil) if len(holds) == len(self.fit_by_oil) else [""]
        return outcome_of_cases(self.cases_on_grid(oils, holds, value), **numbers)

    def cases_on_grid(
        self, oils: Sequence[str], holds: BoolArray, value: FloatArray
    ) -> pd.DataFrame:
        """Cases from arrays over the grid.

        Args:
            oils: The oils of the first axis; one empty name where a case compares oils.
            holds: True where the claim holds.
            value: The judged quantity of the claim, in its unit. It broadcasts against `holds`.
        """
        axes = [np.asarray(oils, dtype=object)]
        for levels, length in zip(self.grid.levels, holds.shape[1:], strict=True):
            spans_axis = length == 1 and len(levels) > 1
            axes.append(np.array([np.nan]) if spans_axis else levels)
        mesh = np.meshgrid(*axes, indexing="ij")
        columns = {
            name: levels.ravel() for name, levels in zip(("oil", *AXIS_NAMES), mesh, strict=True)
        }
        columns["holds"] = holds.ravel()
        columns["value"] = np.broadcast_to(value, holds.shape).ravel()
        return pd.DataFrame(columns)
