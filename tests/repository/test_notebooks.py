"""docs/notebooks: every cell runs, and what the notebooks store is what they print now."""

import json
from pathlib import Path

import pytest

from notebooks import FOLDER, execute, texts

NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_prints_what_it_stores(path: Path) -> None:
    stored = json.loads(path.read_text(encoding="utf-8"))
    assert texts(execute(path)) == texts(stored), "run `make notebooks`"
