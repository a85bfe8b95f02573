"""A manifest whose schema somebody altered is compared, or ends in a sentence."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from alterations import alter
from oilfilm.base.errors import OilfilmError
from oilfilm.releases.compare import compare
from oilfilm.releases.manifest import (
    CHECKSUMS_FILE,
    MANIFEST_FILE,
    Manifest,
    ReleaseInputs,
    canonical_json,
    text_sha256,
)
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.resolved import Settings


@pytest.fixture
def stranger(release: Path, tmp_path: Path) -> Iterator[Path]:
    """A copy of the release, for a stranger to change."""
    copy = Path(shutil.copytree(release, tmp_path / "stranger"))
    for path in (copy, *copy.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    yield copy


def with_right_digests(content: Any) -> str:
    """The text of a manifest whose version and digest are those of its content, if it has any."""
    if isinstance(content, dict):
        content.pop("sha256", None)
        try:
            content["version"] = ReleaseInputs(**content["made_from"]).version
        except (KeyError, TypeError, ValueError):
            pass
        content["sha256"] = text_sha256(canonical_json(content))
    return canonical_json(content)


def alter_and_compare(release: Path, stranger: Path, settings: Settings, seeds: range) -> int:
    """Alter the manifest again and again; how many ended in a sentence."""
    good = (release / MANIFEST_FILE).read_text(encoding="utf-8")
    (stranger / CHECKSUMS_FILE).unlink()
    refused = 0
    for seed in seeds:
        random = np.random.default_rng(seed)
        content = json.loads(good)
        alter(content, random)
        (stranger / MANIFEST_FILE).write_text(with_right_digests(content), encoding="utf-8")
        try:
            altered = StoredRelease.open(stranger)
            assert altered.find_changes()
            compare(StoredRelease.open(release), altered, settings.drift)
        except OilfilmError as error:
            refused += 1
            assert str(error).replace("\n", "").isprintable()
            assert len(str(error)) < 3000
    return refused


def test_text_of_an_unaltered_manifest_is_right(release: Path) -> None:
    text = (release / MANIFEST_FILE).read_text(encoding="utf-8")
    assert with_right_digests(json.loads(text)) == text
    assert Manifest(**json.loads(text)).text() == text


def test_altered_manifest_is_compared_or_ends_in_a_sentence(
    release: Path, stranger: Path, config: Settings
) -> None:
    assert 0 < alter_and_compare(release, stranger, config, range(20)) < 20


@pytest.mark.nightly
def test_a_thousand_altered_manifests_are_compared_or_end_in_a_sentence(
    release: Path, stranger: Path, config: Settings
) -> None:
    assert alter_and_compare(release, stranger, config, range(1000, 2000))
