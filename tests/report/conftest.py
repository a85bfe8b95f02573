"""Results that several tests of the report only look at, made once."""

import pandas as pd
import pytest

from browsers import open_tab
from campaigns import printed
from fit_points import make_points, matrix
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from planted_fits import printed_fits
from reports import results_of

# of a module: playwright runs once at a time, and other rooms start it as well
tab = pytest.fixture(scope="module")(open_tab)


@pytest.fixture(scope="session")
def results(config: Settings) -> CampaignTables:
    return results_of(config)


@pytest.fixture(scope="session")
def on_printed_law() -> CampaignTables:
    """Points on the printed law of every oil; their lambda is 10 U/25."""
    coefficients, quality = printed_fits()
    points = pd.concat((make_points(oil, matrix()) for oil in printed()), ignore_index=True)
    points["rig"] = "ball-on-disc-20mm"
    points["run_id"] = points["oil"] + points["run_id"]
    points["lambda_ratio"] = 0.4 * points["entrainment_speed_m_s"]
    return CampaignTables.in_memory(points=points, coefficients=coefficients, fit_quality=quality)
