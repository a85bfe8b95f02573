"""Curves with a wrong label are named with the oil that they belong to."""

import numpy as np
import pandas as pd

from fit_points import make_points, matrix
from oilfilm.fits.finished import with_likely_oils
from oilfilm.fits.fit import fit_oil
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

OILS = ("4102", "4010")


def test_curve_of_another_oil_is_named_with_that_oil(config: Settings) -> None:
    quick = config.fit.model_copy(update={"bootstrap": 20, "searches": 1})
    of_oil = [
        make_points(oil, matrix(), noise=1e-4).assign(
            run_id=lambda rows, oil=oil: f"{oil}-" + rows["run_id"]
        )
        for oil in OILS
    ]
    points = pd.concat(of_oil, ignore_index=True)
    # the truth: 4102's run 007 is in the drawer of 4010, and 4010's run 005 reads 20 % too much
    points.loc[points["run_id"] == "4102-run007", "oil"] = "4010"
    points.loc[points["run_id"] == "4010-run005", "traction_coefficient"] *= 1.2
    fits = [fit_oil(points, oil, quick, config.seed).tables for oil in OILS]
    joined = {name: pd.concat([fit[name] for fit in fits], ignore_index=True) for name in fits[0]}
    residuals = with_likely_oils(CampaignTables.in_memory(points=points, **joined))
    odd = residuals[residuals["odd"]].set_index("run_id")["likely_oil"]
    assert odd.to_dict() == {"4102-run007": "4102", "4010-run005": ""}
    # a law that has no value at the curve's condition accuses nobody
    points.loc[points["run_id"] == "4102-run007", "inlet_temperature_c"] = np.nan
    unknown = with_likely_oils(CampaignTables.in_memory(points=points, **joined))
    assert unknown["likely_oil"].eq("").all()
