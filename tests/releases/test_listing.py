"""The page that lists the releases of a campaign."""

import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.releases.page import list_releases
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from releases import made, project, released, runs_of

DRIFT = resolve(ROOT / "config", {"campaign": "demo"}).drift
FIRST = {"a.csv": b"1\n"}
SECOND = {"a.csv": b"1\n", "b.csv": b"2\n"}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return project(tmp_path / "p")


def release(root: Path, config: Settings, raw: Mapping[str, bytes]) -> Path:
    return released(made(root, config, raw, {"runs": runs_of(dict(raw), root)}))


def test_releases_are_listed_newest_first_with_what_changed(root: Path, config: Settings) -> None:
    one, two = release(root, config, FIRST), release(root, config, SECOND)
    for order, folder in enumerate((one, two)):
        os.utime(folder, (order, order))
    page = list_releases(two.parent, DRIFT)
    text = page.read_text(encoding="utf-8")
    assert text.index(f"{two.name} (latest)") < text.index(f"<td>{one.name}")
    assert "4102: 2" in text
    changes = f"changes/{one.name}..{two.name}.html"
    assert f'<a href="{changes}">' in text
    assert "data/raw/demo/b.csv" in (one.parent / changes).read_text()
    assert list_releases(two.parent, DRIFT).read_text(encoding="utf-8") == text
    # a release after one that is gone is compared with the one before that
    third = release(root, config, {**SECOND, "c.csv": b"3\n"})
    two.rename(root / "away")
    text = list_releases(third.parent, DRIFT).read_text(encoding="utf-8")
    assert f'<a href="changes/{one.name}..{third.name}.html">' in text


def test_damaged_release_is_listed_with_the_reason(root: Path, config: Settings) -> None:
    one = release(root, config, FIRST)
    (one / "manifest.json").chmod(0o644)
    (one / "manifest.json").write_text("{}", encoding="utf-8")
    two = release(root, config, SECOND)
    text = list_releases(two.parent, DRIFT).read_text(encoding="utf-8")
    assert text.count("not compared: ") == 2
    assert f'<a href="{two.name}' not in text  # it has no report
