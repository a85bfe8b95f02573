"""Results on the printed laws, which figures draw in a moment."""

import numpy as np
import pandas as pd

from campaigns import printed
from fit_points import make_points, matrix
from oilfilm.base.randomness import generator
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from planted_fits import printed_fits


def on_printed_law() -> CampaignTables:
    """Points on the printed law of every oil; their lambda is 10 U/25."""
    coefficients, quality = printed_fits()
    points = pd.concat((make_points(oil, matrix()) for oil in printed()), ignore_index=True)
    points["run_id"] = points["oil"] + points["run_id"]
    points["lambda_ratio"] = 0.4 * points["entrainment_speed_m_s"]
    runs = points.groupby("run_id", as_index=False).first()[["run_id", "oil", *CONDITIONS]]
    runs = runs.rename(columns={name: f"nominal_{name}" for name in CONDITIONS})
    runs = runs.assign(rig="ball-on-disc-20mm", nominal_load_n=np.nan)
    return CampaignTables.from_frames(
        points=points, runs=runs, coefficients=coefficients, fit_quality=quality
    )


def with_refits() -> CampaignTables:
    """Points on the printed law of every oil, and refits that scatter by 1 % about it."""
    fitted = on_printed_law()
    coefficients = fitted.coefficients
    coefficients = coefficients.assign(standard_error=0.01 * coefficients["value"].abs())
    random = generator(1, "refits")
    refits = pd.concat(
        coefficients[["oil", "law", "constant"]].assign(
            cause="resampled curves",
            refit=number,
            value=coefficients["value"] * random.normal(1, 0.01, len(coefficients)),
        )
        for number in range(40)
    )
    correlations = _correlations(refits)
    return fitted.replace(coefficients=coefficients, refits=refits, correlations=correlations)


def _correlations(refits: pd.DataFrame) -> pd.DataFrame:
    parts = []
    for oil, of_oil in refits.groupby("oil", sort=False):
        matrix_of_oil = of_oil.pivot(index="refit", columns="constant", values="value").corr()
        rows = matrix_of_oil.rename_axis(index="other").stack().rename("correlation").reset_index()
        parts.append(rows[rows["constant"] < rows["other"]].assign(oil=oil, law="deng2026"))
    return pd.concat(parts)
