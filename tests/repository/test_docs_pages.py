"""Every generated page, schema and table of the repository is current."""

import pytest

from campaigns import ROOT
from reference_pages import GENERATED


@pytest.mark.parametrize("path", GENERATED)
def test_generated_file_is_current(path: str) -> None:
    assert (ROOT / path).read_text("utf-8") == GENERATED[path](), "run `make schemas`"
