"""The logs of one format, read with the configuration of the demonstration."""

from collections.abc import Callable

import pytest

from oilfilm.logs.base import ParsedLog
from oilfilm.logs.ingest import read_log
from oilfilm.settings.resolved import Settings


@pytest.fixture
def read(request: pytest.FixtureRequest, config: Settings) -> Callable[[bytes | str], ParsedLog]:
    """The reading of a log by the format that its test module is named after."""
    name = request.module.__name__.rpartition("test_readers_")[2]

    def read(content: bytes | str) -> ParsedLog:
        content = content.encode() if isinstance(content, str) else content
        reader, reading = read_log(content, "log", config)
        assert reader == name
        return reading

    return read
