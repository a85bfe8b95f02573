"""The fits of all oils and laws together, and what shows only when they are beside each other."""

import pandas as pd

from oilfilm.fits.best_law import best_laws
from oilfilm.fits.law_comparison import laws_of
from oilfilm.fits.noise import noise_and_misfit
from oilfilm.fits.odd_curves import with_likely_oils
from oilfilm.fits.soundness import judged_fits
from oilfilm.settings.resolved import Settings
from oilfilm.table_needs import OF_FIT
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS


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
