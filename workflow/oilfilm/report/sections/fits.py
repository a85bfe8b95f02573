"""How near the configured law comes to the points of each oil, how sure it is, and the noise."""

from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.noise import ADVISED_REPEATS
from oilfilm.fits.soundness_words import what_is_wrong
from oilfilm.report.document import Fact, Section, facts
from oilfilm.report.shown_table import show_declared
from oilfilm.tables.campaign_tables import CampaignTables

# A curve of which mu differs less than this as a whole is odd by its shape.
_SAME_GAIN = 0.03
# Share of the points at which mu is known at least so well.
_MOST = 0.95
# Of the largest mu of the law: below it a point has no traction to speak of.
_CLEAR = 0.01


def fits(results: CampaignTables) -> Section:
    """Misfit, certificate and certainty of each fit, noise and lack of fit."""
    quality, sure = results.configured.fit_quality, certainty(results)
    fitted = tables.rows(quality[quality["rmse"].notna()])
    made = facts(
        "report/sections/fits.jinja",
        fitted=fitted,
        wrong={str(row["oil"]): what_is_wrong(row) for row in tables.rows(results.soundness)},
        lost=tables.rows(quality[quality["rmse"].isna()]),
        **_odd(results.configured.curve_residuals),
        misfits=tables.rows(results.lack_of_fit),
        unrepeated=tables.rows(results.lack_of_fit.query("verdict == 'no repeats'")),
        repeats=ADVISED_REPEATS,
    )
    shown = [
        show_declared(quality.join(sure, on="oil"), "fit_quality"),
        show_declared(results.lack_of_fit, "lack_of_fit"),
    ]
    return Section("fits", "Fits", made, shown, downloads={"fit_quality.csv": quality})


def curve_facts(quality: pd.DataFrame, residuals: pd.DataFrame) -> list[Fact]:
    """Curves that are left out of fits, and curves that pull them away.

    Args:
        quality: Rows of the table of fit quality.
        residuals: Table of curve residuals, of the same fits.
    """
    fitted = tables.rows(quality)
    return facts("report/sections/curves.jinja", fitted=fitted, **_odd(residuals))


def _odd(residuals: pd.DataFrame) -> dict[str, Any]:
    odd = residuals[residuals["odd"]].sort_values("robust_weight", kind="stable")
    of_oil = {str(oil): tables.rows(rows) for oil, rows in odd.groupby("oil")}
    return {"odd_curves": of_oil, "same_gain": _SAME_GAIN}


def certainty(results: CampaignTables) -> pd.DataFrame:
    """How sure mu of the next run is at the accepted points: half of its 95 % interval over mu.

    Columns median and largest (below which 95 % of the points are) by oil; null where the fit has
    no interval. Rolling without slip is left out: an interval over a mu of
    nearly zero says nothing.
    """
    certainties = {}
    accepted = results.points[results.points["accepted"]]
    for oil in results.configured.fit_quality["oil"]:
        fit = FittedLaw.of_configured(results, oil)
        points = accepted[accepted["oil"] == oil]
        conditions, slip = points[list(fit.law.conditions)], points["slide_roll_ratio"]
        prediction = fit.predict(conditions.to_numpy(float), slip.to_numpy(float))
        size = np.abs(prediction.traction_coefficient)
        width = prediction.obs_ci_upper - prediction.obs_ci_lower
        clear = size > _CLEAR * size.max(initial=0.0)
        half = pd.Series(width[clear] / 2 / size[clear])
        certainties[oil] = half.median(), half.quantile(_MOST)
    index = pd.Index(certainties, dtype=str)
    return pd.DataFrame([*certainties.values()], index, columns=["median", "largest"])
