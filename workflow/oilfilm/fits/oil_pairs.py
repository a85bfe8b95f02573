"""The ratio of two oils by their runs, or the reason why the runs give none.

Decides: how many conditions two oils must have in common for a ratio by their runs.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import reduce
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw, read_fit
from oilfilm.fits.measured_surface import MeasuredContact, OilSurface, free_law, usable_measurements
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.ratio import OilOfPair, RatioSurface, RunsOfPair, fit_ratio
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.traction.law import CONDITIONS

# Fewest conditions of both oils. With fewer, the level of an interval is below 80 %.
_FEWEST_PAIRED_CONDITIONS = 4


class Obstacle(StrEnum):
    """Why the runs of two oils give no ratio."""

    SAME_RUNS = "same runs"
    FEW_PAIRS = "few pairs"
    OTHER_CONDITIONS = "other conditions"
    UNKNOWN_CONDITIONS = "unknown conditions"


@dataclass(frozen=True)
class MeasuredOil:
    """The runs of one oil, and its fit.

    Attributes:
        fit: The fitted law.
        points: Rows of the table of points of the oil.
        rig_names: Names of the rigs of its accepted runs.
    """

    fit: FittedLaw
    points: pd.DataFrame
    rig_names: frozenset[str]


@dataclass(frozen=True)
class OilPair:
    """What the runs of two oils say of their ratio.

    Attributes:
        ratio_or_obstacle: The ratio over slip and conditions, or why there is none.
        paired_count: Number of conditions that both oils have.
        unpaired_count: Number of conditions that only one oil has.
        rig_names: Names of the rigs of the first and of the second oil.
    """

    ratio_or_obstacle: RatioSurface | Obstacle
    paired_count: int
    unpaired_count: int
    rig_names: tuple[frozenset[str], frozenset[str]]


def read_oil(folder: Path, oil_name: str) -> MeasuredOil:
    """The runs and the configured fit of one oil, from a campaign's results or a saved fit.

    Args:
        folder: Folder of the results, which contains the folder `tables`.
        oil_name: Name of the oil.
    """
    results = CampaignTables.from_folder(folder)
    points, runs = results.table("points", CURVE_COLUMNS, oil=oil_name), results.runs
    has_accepted_points = runs["run_id"].isin(points.loc[points["accepted"], "run_id"])
    return MeasuredOil(
        read_fit(folder, oil_name), points, frozenset(runs.loc[has_accepted_points, "rig"])
    )


def oil_pair(first_oil: MeasuredOil, second_oil: MeasuredOil) -> OilPair:
    """What the runs of two oils say of mu of the second one over that of the first."""
    rig_names = (first_oil.rig_names, second_oil.rig_names)
    if any(
        measured_oil.fit.law.conditions != CONDITIONS for measured_oil in (first_oil, second_oil)
    ):
        return OilPair(Obstacle.OTHER_CONDITIONS, 0, 0, rig_names)
    if _has_unknown_condition(first_oil) or _has_unknown_condition(second_oil):
        return OilPair(Obstacle.UNKNOWN_CONDITIONS, 0, 0, rig_names)
    assumptions = assumptions_of_pair(first_oil, second_oil)
    oils_of_pair = (_oil_of_pair(first_oil, assumptions), _oil_of_pair(second_oil, assumptions))
    paired_runs = RunsOfPair(oils_of_pair[0].measurements, oils_of_pair[1].measurements)
    is_paired = paired_runs.is_paired()
    paired_count = int(np.count_nonzero(is_paired))
    ratio_or_obstacle: RatioSurface | Obstacle
    if paired_runs.has_common_runs():
        ratio_or_obstacle = Obstacle.SAME_RUNS
    elif paired_count < _FEWEST_PAIRED_CONDITIONS:
        ratio_or_obstacle = Obstacle.FEW_PAIRS
    else:
        ratio_or_obstacle = _ratio_by_runs(
            *oils_of_pair, assumptions, limits_of_pair(first_oil, second_oil)
        )
    return OilPair(ratio_or_obstacle, paired_count, len(is_paired) - paired_count, rig_names)


def limits_of_pair(first_oil: MeasuredOil, second_oil: MeasuredOil) -> SurfaceLimits:
    """What an answer must fulfil: the stricter limits of those oils that have a surface."""
    limits_of_oils = [surface.limits for surface in _surfaces(first_oil, second_oil)]
    return reduce(SurfaceLimits.stricter, limits_of_oils) if limits_of_oils else SurfaceLimits()


def assumptions_of_pair(first_oil: MeasuredOil, second_oil: MeasuredOil) -> RunAssumptions:
    """What is known of the runs of two oils. An oil without a surface says nothing of its runs.

    The rigs of the runs are left out.
    """
    assumptions_of_oils = [
        replace(surface.assumptions, rig_name_of_run=None)
        for surface in _surfaces(first_oil, second_oil)
    ]
    return reduce(RunAssumptions.joined, assumptions_of_oils or [RunAssumptions()])


def _surfaces(*measured_oils: MeasuredOil) -> list[OilSurface]:
    """The surfaces of those oils that have one."""
    surfaces = (measured_oil.fit.surface for measured_oil in measured_oils)
    return [surface for surface in surfaces if surface is not None]


def _ratio_by_runs(
    first_oil: OilOfPair, second_oil: OilOfPair, assumptions: RunAssumptions, limits: SurfaceLimits
) -> RatioSurface:
    """The ratio by the runs.

    Raises:
        OilfilmError: The points cannot have one.
    """
    try:
        return fit_ratio(first_oil, second_oil, assumptions.error_sizes, limits)
    except ValueError as error:
        raise OilfilmError(f"the ratio of two oils by their runs: {error}.") from None


def _oil_of_pair(measured_oil: MeasuredOil, assumptions: RunAssumptions) -> OilOfPair:
    """The oil as a surface takes it."""
    contact = MeasuredContact.from_points(measured_oil.points[measured_oil.points["accepted"]])
    coefficients = measured_oil.fit.coefficients
    law = free_law(
        measured_oil.fit.law, coefficients.constants, coefficients.group_has_exponent, contact
    )
    _, measurements = usable_measurements(measured_oil.points, law, contact, assumptions)
    return OilOfPair(measurements, law)


def _has_unknown_condition(measured_oil: MeasuredOil) -> bool:
    """Whether a condition is unknown in all accepted runs: it may differ between the oils."""
    accepted = measured_oil.points[measured_oil.points["accepted"]]
    return bool(accepted[list(CONDITIONS)].isna().all().any())
