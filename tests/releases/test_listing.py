"""The page that lists the releases of a campaign."""

import json
import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.releases.listing import list_releases
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


def test_releases_are_listed_in_the_order_in_which_they_were_made(
    root: Path, config: Settings
) -> None:
    """The newest comes first, and dates of files do not matter once it is listed."""
    one = release(root, config, FIRST)
    list_releases(one.parent, DRIFT)
    two = release(root, config, SECOND)
    page = list_releases(two.parent, DRIFT)
    content = page.read_bytes()
    text = content.decode()
    assert text.index(two.name) < text.index(one.name)
    assert f"{two.name} (latest)" in text
    assert f'<a href="changes/{two.name}.html">nothing beyond the limits' in text
    assert "4102: 2" in text
    assert "data/raw/demo/b.csv" in (one.parent / f"changes/{two.name}.html").read_text()
    os.utime(two, (0, 0))
    assert list_releases(two.parent, DRIFT).read_bytes() == content


def test_release_that_is_made_again_stays_where_it_is_in_the_list(
    root: Path, config: Settings
) -> None:
    one, two = release(root, config, FIRST), release(root, config, SECOND)
    list_releases(one.parent, DRIFT)
    (root / "data/raw/demo/b.csv").unlink()
    assert release(root, config, FIRST) == one
    text = list_releases(one.parent, DRIFT).read_text(encoding="utf-8")
    assert text.index(two.name) < text.index(f"{one.name} (latest)")


def test_release_after_one_that_is_gone_is_compared_anew(root: Path, config: Settings) -> None:
    releases = release(root, config, FIRST).parent
    last = [release(root, config, raw) for raw in (SECOND, {**SECOND, "c.csv": b"3\n"})]
    list_releases(releases, DRIFT)
    assert "b.csv" not in (releases / f"changes/{last[1].name}.html").read_text()
    last[0].rename(root / "away")
    list_releases(releases, DRIFT)
    assert "b.csv" in (releases / f"changes/{last[1].name}.html").read_text()


def test_damaged_release_is_listed_with_the_reason(root: Path, config: Settings) -> None:
    one = release(root, config, FIRST)
    (one / "manifest.json").chmod(0o644)
    (one / "manifest.json").write_text("{}", encoding="utf-8")
    two = release(root, config, SECOND)
    text = list_releases(two.parent, DRIFT).read_text(encoding="utf-8")
    assert text.count("not compared: ") == 2
    assert f'<a href="{two.name}' not in text  # it has no report


def test_text_of_a_list_is_no_markup(root: Path, config: Settings) -> None:
    one = release(root, config, FIRST)
    list_releases(one.parent, DRIFT)
    kept = one.parent / "releases.json"
    content = json.loads(kept.read_text(encoding="utf-8"))
    content["releases"][0]["oils"] = {"<script>alert(1)</script>": 1}
    kept.write_text(json.dumps(content), encoding="utf-8")
    text = list_releases(one.parent, DRIFT).read_text(encoding="utf-8")
    assert "&lt;script&gt;" in text
    assert "<script" not in text


def test_list_that_cannot_be_read_is_made_anew(root: Path, config: Settings) -> None:
    one = release(root, config, FIRST)
    content = list_releases(one.parent, DRIFT).read_bytes()
    (one.parent / "releases.json").write_bytes(b"\xff{")
    assert list_releases(one.parent, DRIFT).read_bytes() == content
