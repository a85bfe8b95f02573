"""Warnings about the spin of a ball-on-disc rig, which lowers the traction at low slip.

Decides: when the spin of a rig is a warning.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm.base.ties import exceeds
from oilfilm.base.units import FloatArray
from oilfilm.curation.gate import sentence_named
from oilfilm.physics.contact import Contact, contact_radius
from oilfilm.physics.rig_spin import SMALLEST_SLIP_OVER_EDGE_SLIP, edge_slip, spin_correction
from oilfilm.settings.resolved import Settings

# Below this slip the rig rolls: the error of the slip decides the traction.
_LEAST_SLIDING_SLIP = 0.002
# Derivatives at the lowest slip are those of a curve through the points up to so many times that
# slip.
_NEAR_SLIP_RATIO = 4.0
_FEWEST_NEAR_LEVELS = 3
# Largest ratio of slips that belong to one level: readings of one slip show no derivative.
_SAME_LEVEL_RATIO = 1.1
# Correction above which a rig is warned about, over mu.
_LARGEST_RELATIVE_CORRECTION = 0.01


def spin_warnings(
    points_in_parts: Iterable[pd.DataFrame], rig_name_of_run: "pd.Series[str]", settings: Settings
) -> Iterator[tuple[str, str]]:
    """One warning per rig with too much spin: id of the run that has most of it, and a sentence.

    Rigs whose tracks or materials are not recorded are left out: their spin is not known. A
    simulated rig has none.

    Args:
        points_in_parts: Points of accepted runs, some of them at a time.
        rig_name_of_run: Name of the rig of each run, by the id of the run.
        settings: The rigs.
    """
    if settings.campaign.data == "simulated":
        return
    sliding_points = pd.concat(
        [points[_has_slip_and_traction(points)] for points in points_in_parts], ignore_index=True
    )
    for rig_name, points_of_rig in sliding_points.groupby(
        sliding_points["run_id"].map(rig_name_of_run), sort=True
    ):
        rig = settings.rigs.get(str(rig_name))
        contact = None if rig is None else rig.contact()
        if rig is None or contact is None or rig.disc_track_radius_m is None:
            continue
        spin_rows = [
            _spin_of_run(curve, contact, rig.disc_track_radius_m)
            for _, curve in points_of_rig.groupby("run_id", sort=True)
        ]
        spin_of_runs = pd.DataFrame(spin_rows)
        smallest_valid_slip = SMALLEST_SLIP_OVER_EDGE_SLIP * spin_of_runs["slip_at_edge"]
        begins_below_valid_slip = spin_of_runs["lowest_slip"] < smallest_valid_slip
        lacks_much = spin_of_runs["lacking_share"] > _LARGEST_RELATIVE_CORRECTION
        is_affected = begins_below_valid_slip | lacks_much
        if is_affected.any():
            worst_run = spin_of_runs[is_affected].nlargest(1, "lacking_share").iloc[0]
            sentence = sentence_named(
                "rig_spin",
                affected=is_affected.sum(),
                runs=len(spin_of_runs),
                slip=worst_run["lowest_slip"],
                slip_at_edge=worst_run["slip_at_edge"],
                lacking_share=worst_run["lacking_share"],
            )
            yield str(worst_run["run_id"]), sentence


def _has_slip_and_traction(points: pd.DataFrame) -> "pd.Series[bool]":
    """Mask of the points that are accepted, and have slip and traction."""
    is_sliding = points["accepted"] & (points["slide_roll_ratio"] >= _LEAST_SLIDING_SLIP)
    return is_sliding & (points["traction_coefficient"] > 0)


class _SpinOfRun(NamedTuple):
    """What spin does to the traction of a run.

    Attributes:
        run_id: The run.
        lowest_slip: Lowest slide-roll ratio of its points.
        slip_at_edge: Slide-roll ratio that spin makes at the edge of the contact.
        lacking_share: What mu lacks at the lowest slip, relative. Where the formula does not hold,
            or few levels of slip are near the lowest one, what mu would lack if it were flat.
    """

    run_id: str
    lowest_slip: float
    slip_at_edge: float
    lacking_share: float


def _spin_of_run(points: pd.DataFrame, contact: Contact, disc_track_radius_m: float) -> _SpinOfRun:
    """What spin does to the traction of the run with these points."""
    curve = points.sort_values("slide_roll_ratio", kind="stable")
    slip = curve["slide_roll_ratio"].to_numpy(float)
    mu = curve["traction_coefficient"].to_numpy(float)
    load_n = float(curve["load_n"].mean())
    contact_radius_m = contact_radius(load_n, contact.radius_m, contact.reduced_modulus_pa)
    slip_at_edge = float(edge_slip(contact_radius_m, disc_track_radius_m))
    correction = float(_relative_correction(slip, mu, slip_at_edge))
    lacking_share_if_mu_is_flat = slip_at_edge**2 / (10 * slip[0] ** 2)
    return _SpinOfRun(
        run_id=str(curve["run_id"].iloc[0]),
        lowest_slip=slip[0],
        slip_at_edge=slip_at_edge,
        lacking_share=lacking_share_if_mu_is_flat if np.isnan(correction) else correction,
    )


def _relative_correction(slip: FloatArray, mu: FloatArray, slip_at_edge: float) -> FloatArray:
    """Correction at the lowest slip; NaN where few levels are near it or the formula fails.

    The logarithm of mu is taken as a polynomial in that of the slip.
    """
    is_near = slip <= _NEAR_SLIP_RATIO * slip[0]
    level_count = _level_count(slip[is_near])
    if level_count < _FEWEST_NEAR_LEVELS:
        return np.asarray(np.nan)
    degree = 2 if level_count > _FEWEST_NEAR_LEVELS else 1
    coefficients = np.polyfit(np.log(slip[is_near] / slip[0]), np.log(mu[is_near]), degree)
    exponent = coefficients[-2]
    exponent_slope = 2 * coefficients[0] if degree == 2 else 0.0
    mu_at_lowest = np.exp(coefficients[-1])
    slope = exponent * mu_at_lowest / slip[0]
    curvature = (exponent * (exponent - 1) + exponent_slope) * mu_at_lowest / slip[0] ** 2
    return spin_correction(slip[0], mu_at_lowest, slope, curvature, slip_at_edge)


def _level_count(rising_slip: FloatArray) -> int:
    """Number of levels of rising slips; a level has the slips near its lowest one."""
    level_starts = [rising_slip[0]]
    for slip in rising_slip:
        if exceeds(slip, _SAME_LEVEL_RATIO * level_starts[-1]):
            level_starts.append(slip)
    return len(level_starts)
