"""Settings whose schema somebody altered are settings or end in a sentence."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from campaigns import LABORATORY, ROOT
from oilfilm.base.errors import OilfilmError
from oilfilm.settings.resolve import resolve

FILES = (
    "config.yaml",
    "campaigns/laboratory.yaml",
    "rigs/ball-on-disc-20mm.yaml",
    "oils/4102.yaml",
)
# Values that no key has, or that other keys have.
VALUES = [None, True, 0, -1, 1.5, 2**70, 1e308, "", "x", "\x1b[31m", "..", [], {}, [None], {"x": 1}]
Steps = tuple[Any, ...]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = Path(shutil.copytree(ROOT / "config", tmp_path_factory.mktemp("altered") / "config"))
    shutil.copy(LABORATORY / "campaigns/laboratory.yaml", folder / "campaigns")
    return folder


def steps_below(value: Any) -> list[Steps]:
    """The steps to everything in a group or list."""
    if not isinstance(value, dict | list):
        return []
    found: list[Steps] = []
    for step in value if isinstance(value, dict) else range(len(value)):
        found.append((step,))
        found += [(step, *below) for below in steps_below(value[step])]
    return found


def alter(values: Any, rng: np.random.Generator) -> None:
    """Remove something, wrap it, repeat it, or put another value in its place."""
    found = steps_below(values)
    *groups, last = found[int(rng.integers(len(found)))]
    for step in groups:
        values = values[step]
    kind = int(rng.integers(6))
    if kind == 0:
        del values[last]
    elif kind == 1:
        values[last] = {"x": values[last]}
    elif kind == 2:
        values[last] = [values[last], values[last]]
    else:
        values[last] = VALUES[int(rng.integers(len(VALUES)))]


def alter_and_resolve(folder: Path, alterations: range) -> int:
    """Alter one file after the other; how many ended in a sentence."""
    refused = 0
    for seed in alterations:
        rng = np.random.default_rng(seed)
        path = folder / FILES[int(rng.integers(len(FILES)))]
        text = path.read_text(encoding="utf-8")
        values = yaml.safe_load(text)
        alter(values, rng)
        path.write_text(yaml.safe_dump(values), encoding="utf-8")
        try:
            resolve(folder, {"campaign": "laboratory"})
        except OilfilmError as error:
            refused += 1
            assert str(error).replace("\n", "").isprintable()
        path.write_text(text, encoding="utf-8")
    return refused


def test_altered_settings_are_settings_or_end_in_a_sentence(folder: Path) -> None:
    assert alter_and_resolve(folder, range(20))


@pytest.mark.nightly
def test_a_thousand_altered_settings_are_settings_or_end_in_a_sentence(folder: Path) -> None:
    assert alter_and_resolve(folder, range(1000, 2000))
