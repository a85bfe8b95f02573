"""Results that several tests of the report only look at, made once."""

import pytest

from browsers import open_tab
from drawn_results import on_printed_law
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from reports import results_of

# of a module: playwright runs once at a time, and other rooms start it as well
tab = pytest.fixture(scope="module")(open_tab)


@pytest.fixture(scope="session")
def results(config: Settings) -> CampaignTables:
    return results_of(config)


@pytest.fixture(scope="session", name="on_printed_law")
def points_on_printed_law() -> CampaignTables:
    return on_printed_law()
