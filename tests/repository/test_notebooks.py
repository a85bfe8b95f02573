"""docs/notebooks: every cell runs, and what the notebooks store is what they print now."""

import base64
import json
from pathlib import Path

import pytest

from notebooks import FOLDER, execute, texts

NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_prints_what_it_stores(path: Path) -> None:
    stored = json.loads(path.read_text(encoding="utf-8"))
    assert texts(execute(path)) == texts(stored), "run `make notebooks`"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_has_small_pictures_and_nothing_of_a_machine(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert set(json.loads(text)["metadata"]) == {"kernelspec", "language_info"}
    assert not any(part in text for part in ("/tmp", "/home", "object at 0x"))
    outputs = [each for cell in json.loads(text)["cells"] for each in cell.get("outputs", [])]
    shown = [output.get("data", {}) for output in outputs]
    pictures = [data["image/png"] for data in shown if "image/png" in data]
    assert pictures
    assert max(len(base64.b64decode(picture)) for picture in pictures) < 100_000
