"""Two oils by their runs: which runs make pairs, and whether a ratio of the oils follows from them.

Decides: how many conditions two oils must have in common for a ratio by their runs.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.fits.fitted import FittedLaw, read_fit
from oilfilm.fits.problem import curve_data
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.ratio import RatioSurface, TestedOil, fit_ratio, paired_conditions, share_runs
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, to_internal

# With fewer, left-out conditions allow less than 80 %.
_FEWEST_PAIRED = 4
# Points at lower slip are at rolling, where the error of the slip is larger than the slip.
_LEAST_SLIP = 5e-4


class Obstacle(StrEnum):
    """Why the runs of two oils give no ratio."""

    SAME_RUNS = "same runs"
    FEW_PAIRS = "few pairs"
    OTHER_CONDITIONS = "other conditions"


@dataclass(frozen=True)
class MeasuredOil:
    """The runs of one oil, and its fit.

    Attributes:
        fit: The fitted law.
        measurements: The accepted points above rolling.
        rigs: Names of the rigs of its accepted runs.
    """

    fit: FittedLaw
    measurements: Measurements
    rigs: frozenset[str]


@dataclass(frozen=True)
class OilPair:
    """What the runs of two oils say of their ratio.

    Attributes:
        surface: The ratio over slip and conditions; None if there is an obstacle.
        obstacle: Why there is no ratio; None if there is one.
        paired: Number of conditions that both oils have.
        alone: Number of conditions that only one oil has.
        rigs: Names of the rigs of the first and of the second oil.
    """

    surface: RatioSurface | None
    obstacle: Obstacle | None
    paired: int
    alone: int
    rigs: tuple[frozenset[str], frozenset[str]]


def read_oil(folder: Path, oil: str) -> MeasuredOil:
    """The runs and the configured fit of one oil, from a campaign's results or a saved fit.

    Args:
        folder: Folder of the results, which contains the folder `tables`.
        oil: Name of the oil.
    """
    results = CampaignTables.in_folder(folder)
    points, runs = results.points, results.runs
    points = points[points["oil"] == oil]
    of_points = runs["run_id"].isin(points.loc[points["accepted"], "run_id"])
    return MeasuredOil(
        fit=read_fit(folder, oil),
        measurements=measurements_of(points),
        rigs=frozenset(runs.loc[of_points, "rig"]),
    )


def measurements_of(points: pd.DataFrame) -> Measurements:
    """The accepted points of one oil above rolling.

    Args:
        points: Rows of the table of points.
    """
    data = curve_data(points)
    is_sliding = data.slip >= _LEAST_SLIP
    curves, curve = np.unique(data.curve[is_sliding], return_inverse=True)
    return Measurements(data.conditions[curves], curve, data.slip[is_sliding], data.mu[is_sliding])


def ratios_to_first(oils: Mapping[str, MeasuredOil]) -> dict[str, OilPair]:
    """What the runs say of the ratio of each oil to the first one, by its name.

    Args:
        oils: Oils by name.
    """
    (_, first), *others = oils.items()
    return {name: oil_pair(first, other) for name, other in others}


def oil_pair(first: MeasuredOil, second: MeasuredOil) -> OilPair:
    """What the runs say of the ratio of mu of the second oil to that of the first."""
    measured = (first.measurements, second.measurements)
    is_paired = paired_conditions(*measured)
    paired = int(np.count_nonzero(is_paired))
    obstacle = None
    if share_runs(*measured):
        obstacle = Obstacle.SAME_RUNS
    elif any(oil.fit.law.conditions != CONDITIONS for oil in (first, second)):
        obstacle = Obstacle.OTHER_CONDITIONS
    elif paired < _FEWEST_PAIRED:
        obstacle = Obstacle.FEW_PAIRS
    surface = None
    if obstacle is None:
        surface = fit_ratio(_tested(first), _tested(second))
    alone = len(is_paired) - paired
    return OilPair(surface, obstacle, paired, alone, (first.rigs, second.rigs))


def _tested(oil: MeasuredOil) -> TestedOil:
    """The oil with the law as a surface takes it."""
    law, coefficients = oil.fit.law, oil.fit.coefficients
    followed = {
        name for name, follows in zip(law.groups, coefficients.followed, strict=True) if follows
    }
    is_free = [
        constant.prescribed is None
        and (constant.condition is None or constant.condition in followed)
        for constant in law.constants
    ]
    constants = to_internal(law, coefficients.constants)
    return TestedOil(oil.measurements, FreeLaw(law, constants, np.array(is_free)))
