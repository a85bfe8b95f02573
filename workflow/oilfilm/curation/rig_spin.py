"""Warnings about the spin of a ball-on-disc rig, which lowers the traction at low slip.

Decides: when the spin of a rig is a warning.
"""

from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd

from oilfilm.base.units import FloatArray
from oilfilm.curation.gate import fault
from oilfilm.physics.contact import Contact, contact_radius
from oilfilm.physics.rig_spin import LEAST_SLIP_OVER_EDGE, edge_slip, spin_correction
from oilfilm.settings.resolved import Settings

# Below this slip the rig rolls: the error of the slip decides the traction.
_LEAST_SLIP = 0.002
# Derivatives at the lowest slip are those of a curve through the points up to so many times it.
_NEAR = 4.0
_FEWEST_POINTS = 3
# Correction above which a rig is warned about, over mu.
_LARGEST_CORRECTION = 0.01


def spin_warnings(
    parts: Iterable[pd.DataFrame], rigs: "pd.Series[str]", settings: Settings
) -> Iterator[tuple[str, str]]:
    """One warning per rig with too much spin: id of the run that has most of it, and a sentence.

    Rigs whose tracks or materials are not recorded are left out: their spin is not known. A
    simulated rig has none.

    Args:
        parts: Points of accepted runs, some of them at a time.
        rigs: Rig of each run, by the id of the run.
        settings: The rigs.
    """
    if settings.campaign.data == "simulated":
        return
    sliding = pd.concat([part[_slides(part)] for part in parts], ignore_index=True)
    for name, of_rig in sliding.groupby(sliding["run_id"].map(rigs), sort=True):
        rig = settings.rigs.get(str(name))
        contact = None if rig is None else rig.contact()
        if rig is None or contact is None or rig.disc_track_radius_m is None:
            continue
        spins = [
            _spin_of_run(curve, contact, rig.disc_track_radius_m)
            for _, curve in of_rig.groupby("run_id", sort=True)
        ]
        spin = pd.DataFrame(spins)
        few_slips = spin["slip"] < LEAST_SLIP_OVER_EDGE * spin["edge"]
        affected = few_slips | (spin["correction"] > _LARGEST_CORRECTION)
        if affected.any():
            worst = spin[affected].nlargest(1, "lacks").iloc[0]
            numbers = {key: worst[key] for key in ("slip", "edge", "lacks")}
            sentence = fault("rig_spin", affected=affected.sum(), runs=len(spin), **numbers)
            yield str(worst["run_id"]), sentence.reason


def _slides(points: pd.DataFrame) -> "pd.Series[bool]":
    """Accepted points with a slip and with traction."""
    slides = points["accepted"] & (points["slide_roll_ratio"] >= _LEAST_SLIP)
    return slides & (points["traction_coefficient"] > 0)


def _spin_of_run(
    points: pd.DataFrame, contact: Contact, disc_track_radius_m: float
) -> dict[str, str | float]:
    """Lowest slip of a run, slip at the edge of its contact, and what its traction lacks there.

    `correction` is NaN where its formula does not hold. `lacks` is what a plateau of mu would lack
    at this slip, where the correction is not known.
    """
    curve = points.sort_values("slide_roll_ratio", kind="stable")
    slip = curve["slide_roll_ratio"].to_numpy(float)
    mu = curve["traction_coefficient"].to_numpy(float)
    load = float(curve["load_n"].mean())
    radius = contact_radius(load, contact.radius_m, contact.reduced_modulus_pa)
    edge = float(edge_slip(radius, disc_track_radius_m))
    correction = float(_correction(slip, mu, edge))
    plateau = edge**2 / (10 * slip[0] ** 2)
    return {
        "run_id": str(curve["run_id"].iloc[0]),
        "slip": slip[0],
        "edge": edge,
        "correction": correction,
        "lacks": plateau if np.isnan(correction) else correction,
    }


def _correction(slip: FloatArray, mu: FloatArray, edge: float) -> FloatArray:
    """Correction at the lowest slip; NaN where few points are near it or the formula fails.

    The logarithm of mu is taken as a polynomial in that of the slip.
    """
    near = slip <= _NEAR * slip[0]
    if near.sum() < _FEWEST_POINTS:
        return np.asarray(np.nan)
    degree = 2 if near.sum() > _FEWEST_POINTS else 1
    coefficients = np.polyfit(np.log(slip[near] / slip[0]), np.log(mu[near]), degree)
    power = coefficients[-2]
    bend = 2 * coefficients[0] if degree == 2 else 0.0
    level = np.exp(coefficients[-1])
    slope = power * level / slip[0]
    curvature = (power * (power - 1) + bend) * level / slip[0] ** 2
    return spin_correction(slip[0], level, slope, curvature, edge)
