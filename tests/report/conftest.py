"""Results that several tests of the report only look at, fitted once."""

import pytest

from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from reports import results_of


@pytest.fixture(scope="session")
def results(config: Settings) -> CampaignTables:
    return results_of(config)
