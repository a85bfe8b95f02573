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
KeyPath = tuple[Any, ...]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = Path(shutil.copytree(ROOT / "config", tmp_path_factory.mktemp("altered") / "config"))
    shutil.copy(LABORATORY / "campaigns/laboratory.yaml", folder / "campaigns")
    return folder


def key_paths_below(value: Any) -> list[KeyPath]:
    """The key paths of everything in a group or list."""
    if not isinstance(value, dict | list):
        return []
    key_paths: list[KeyPath] = []
    for key in value if isinstance(value, dict) else range(len(value)):
        key_paths.append((key,))
        key_paths += [(key, *path_below) for path_below in key_paths_below(value[key])]
    return key_paths


def alter(values: Any, rng: np.random.Generator) -> None:
    """Remove something, wrap it, repeat it, or put another value in its place."""
    key_paths = key_paths_below(values)
    *group_keys, last_key = key_paths[int(rng.integers(len(key_paths)))]
    for key in group_keys:
        values = values[key]
    alteration = int(rng.integers(6))
    if alteration == 0:
        del values[last_key]
    elif alteration == 1:
        values[last_key] = {"x": values[last_key]}
    elif alteration == 2:
        values[last_key] = [values[last_key], values[last_key]]
    else:
        values[last_key] = VALUES[int(rng.integers(len(VALUES)))]


def alter_and_resolve(folder: Path, alterations: range) -> int:
    """Alter one file after the other; how many ended in a sentence."""
    refused_count = 0
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
            refused_count += 1
            assert str(error).replace("\n", "").isprintable()
        path.write_text(text, encoding="utf-8")
    return refused_count


def test_altered_settings_are_settings_or_end_in_a_sentence(folder: Path) -> None:
    assert alter_and_resolve(folder, range(20))


@pytest.mark.nightly
def test_a_thousand_altered_settings_are_settings_or_end_in_a_sentence(folder: Path) -> None:
    assert alter_and_resolve(folder, range(1000, 2000))
