"""Settings whose schema somebody altered are settings or end in a sentence."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from alterations import alter
from campaigns import LABORATORY, ROOT
from oilfilm.base.errors import OilfilmError
from oilfilm.settings.resolve import resolve

FILES = (
    "config.yaml",
    "campaigns/laboratory.yaml",
    "rigs/ball-on-disc-20mm.yaml",
    "oils/4102.yaml",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = Path(shutil.copytree(ROOT / "config", tmp_path_factory.mktemp("altered") / "config"))
    shutil.copy(LABORATORY / "campaigns/laboratory.yaml", folder / "campaigns")
    return folder


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


@pytest.mark.slow
def test_altered_settings_are_settings_or_end_in_a_sentence(folder: Path) -> None:
    assert alter_and_resolve(folder, range(20))


@pytest.mark.nightly
def test_a_thousand_altered_settings_are_settings_or_end_in_a_sentence(folder: Path) -> None:
    assert alter_and_resolve(folder, range(1000, 2000))
