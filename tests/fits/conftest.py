"""Settings of fits that take a second."""

import pytest

from oilfilm.settings.resolved import Settings


@pytest.fixture(scope="session")
def quick(config: Settings) -> Settings:
    return config.with_changes({"fit": {"searches": 2, "bootstrap": 20}})
