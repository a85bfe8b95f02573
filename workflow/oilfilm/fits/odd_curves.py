"""Curves that do not belong to the others of their oil, and the oils that they may belong to.

Decides: when a curve is named as odd, and with which oil.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.tables.campaign_tables import CampaignTables

# A curve agrees much better with another oil's fit where its error is smaller by this factor.
_MUCH_BETTER = 0.5


def with_likely_oils(results: CampaignTables) -> pd.DataFrame:
    """Name the oil that an odd curve belongs to, where the fit of another one agrees much better.

    Args:
        results: The tables of every fit, and the points.

    Returns:
        Table of curve residuals; oils are named in the rows of the configured law.
    """
    fits, points = results.configured, results.points
    laws = {
        str(oil): FittedLaw.of(fits.coefficients, str(oil), quality=fits.fit_quality)
        for oil in fits.fit_quality["oil"]
    }
    odd = fits.curve_residuals[fits.curve_residuals["odd"]]
    curves = points[points["accepted"] & points["run_id"].isin(odd["run_id"])].groupby("run_id")
    nearer = {
        (row["law"], row["run_id"]): _much_nearer(laws, row["oil"], curves.get_group(row["run_id"]))
        for row in tables.rows(odd)
    }
    residuals = results.curve_residuals
    keys = zip(residuals["law"], residuals["run_id"], strict=True)
    return residuals.assign(likely_oil=[nearer.get(key, "") for key in keys])


def _much_nearer(laws: Mapping[str, FittedLaw], own: str, curve: pd.DataFrame) -> str:
    """The oil whose fit is much nearer to a curve than that of its own oil; empty if none is."""
    errors = {oil: _relative_error(law, curve) for oil, law in laws.items()}
    known = {oil: error for oil, error in errors.items() if np.isfinite(error)}
    if own not in known:
        return ""
    nearest = min(known, key=lambda oil: known[oil])
    return nearest if known[nearest] < _MUCH_BETTER * known[own] else ""


def _relative_error(law: FittedLaw, curve: pd.DataFrame) -> float:
    """RMS error of mu of a curve over the RMS of mu; NaN where the law says nothing there."""
    condition = curve[list(law.law.conditions)].mean().to_numpy()
    slip, mu = curve["slide_roll_ratio"].to_numpy(), curve["traction_coefficient"].to_numpy()
    try:
        error = law.traction(condition, slip) - mu
    except ValueError:  # no value at this condition
        return float("nan")
    return float(np.sqrt(np.mean(error**2) / np.mean(mu**2)))
