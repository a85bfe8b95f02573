"""Curves that do not belong to the others of their oil, and the oils that they may belong to."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.tables.campaign_tables import CampaignTables

# A curve agrees much better with another oil's fit where its error is smaller by this factor.
_MUCH_BETTER = 0.5
# A curve of which mu differs less than this as a whole is odd by its shape.
_SAME_GAIN = 0.03


def pulling_curves(residuals: pd.DataFrame) -> str:
    """The odd curves of one oil in words, worst first.

    Args:
        residuals: The oil's rows of the table of curve residuals.
    """
    odd = residuals[residuals["odd"]].sort_values("robust_weight", kind="stable")
    return "; ".join(
        f"{row['run_id']} ({_difference(row)}{_likely(row['likely_oil'])})"
        for row in tables.rows(odd)
    )


def _difference(row: Mapping[str, Any]) -> str:
    if abs(row["gain"] - 1) < _SAME_GAIN:
        return f"of another shape: rms error of mu {row['rmse']:.1e}"
    return f"mu {row['gain']:.2f} times the fit's"


def _likely(oil: str) -> str:
    return f"; the fit of {oil} is much nearer: is the label of the run right?" if oil else ""


def with_likely_oils(
    fits: CampaignTables, points: pd.DataFrame
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Name the oil that an odd curve belongs to, where the fit of another one agrees much better.

    Args:
        fits: Finished fits of all oils.
        points: Table of points of the campaign.

    Returns:
        Tables of curve residuals and of fit quality.
    """
    residuals, quality = fits.curve_residuals.copy(), fits.fit_quality.copy()
    odd = residuals.loc[residuals["odd"], "run_id"]
    curves = points[points["accepted"] & points["run_id"].isin(odd)].groupby("run_id")
    laws = {
        str(oil): FittedLaw.of(fits.coefficients, str(oil), quality=quality)
        for oil in quality["oil"]
    }
    for index, row in zip(residuals.index, tables.rows(residuals), strict=True):
        if row["odd"]:
            curve = curves.get_group(row["run_id"])
            residuals.loc[index, "likely_oil"] = _much_nearer(laws, row["oil"], curve)
    quality["pulling_curves"] = [
        pulling_curves(residuals[residuals["oil"] == oil]) for oil in quality["oil"]
    ]
    return residuals, quality


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
