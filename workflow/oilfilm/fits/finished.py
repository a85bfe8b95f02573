"""The fits of all oils and laws together, and what shows only when they are beside each other.

Decides: with which oil an odd curve is named.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.fits.noise import noise_and_misfit
from oilfilm.fits.soundness import judged_fits
from oilfilm.settings.resolved import Settings
from oilfilm.table_needs import OF_FIT
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS

# A curve agrees much better with another oil's fit where its error is smaller by this factor.
_MUCH_BETTER = 0.5


def finished_fits(results: CampaignTables, settings: Settings) -> dict[str, pd.DataFrame]:
    """The tables of the fits, `law_verdicts`, `lack_of_fit` and `soundness`, by name.

    Args:
        results: The tables of every fit, `points` and `runs`.
        settings: `fit`, and those of `noise_and_misfit`.
    """
    quality = results.fit_quality
    known = {oil: settings.properties_of(oil) for oil in quality["oil"].unique()}
    limits = {oil: each.limiting_stress_ratio for oil, each in known.items() if each is not None}
    quality = quality.assign(
        configured=quality["law"] == settings.fit.law,
        limiting_stress_ratio=quality["oil"].map(limits).astype(float),
    )
    results = results.replace(fit_quality=quality)
    results = results.replace(curve_residuals=with_likely_oils(results))
    results = results.replace(lack_of_fit=noise_and_misfit(results, settings))
    laws = {
        oil: laws_of(oil, settings) if settings.fit.law not in LAWS else {}
        for oil in quality["oil"].unique()
    }
    return {
        **{name: results.table(name) for name in OF_FIT},
        "law_verdicts": best_laws(quality, results.law_points, results.points),
        "lack_of_fit": results.lack_of_fit,
        "soundness": judged_fits(results, settings.fit, laws),
    }


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
