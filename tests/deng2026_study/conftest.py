"""Settings of the demonstration for all tests of this folder."""

import pytest

from oilfilm.settings.resolved import Settings


@pytest.fixture(scope="session")
def config(demo_config: Settings) -> Settings:
    return demo_config
