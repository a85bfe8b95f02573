"""Fixtures that several tests share: configuration, demonstration campaign, measured curves."""

import gc
import os
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

# Before NumPy is imported, here and in the workers: small matrices lose by threads, sixtyfold.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings

from campaigns import (
    ETM,
    LABORATORY,
    REAL_PCS,
    ROOT,
    Campaign,
    carry_through,
    made_once,
    printed,
    simulator,
)
from oilfilm import tables
from oilfilm.logs.raw_files import raw_log_names
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# Collecting the tests imports a thousand modules: with fewer searches for cycles, a tenth faster.
gc.set_threshold(50_000)

# No timed assertions, and the same examples in every run: a slow machine must not fail a test.
for profile, examples in {"quick": 30, "nightly": 300}.items():
    settings.register_profile(
        profile,
        max_examples=examples,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[HealthCheck.too_slow],
    )
settings.load_profile("quick")


@pytest.fixture(scope="session")
def config() -> Settings:
    """Settings of a laboratory's campaign, which needs no package beside oilfilm."""
    return resolve(LABORATORY, {})


@pytest.fixture(scope="session")
def demo_config() -> Settings:
    """Settings of the demonstration, which belongs to a study."""
    pytest.importorskip("deng2026_study")
    simulator()
    return resolve(ROOT / "config", {"campaign": "demo"})


@pytest.fixture(scope="session")
def demo(demo_config: Settings, tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """The whole demonstration campaign, simulated and curated once for all workers."""
    return made_once("demo", lambda folder: simulated(demo_config, folder), tmp_path_factory)


def simulated(config: Settings, folder: Path) -> Campaign:
    truth = []
    for run, content, rows in simulator().simulate_campaign(config, printed()):
        (folder / run.name).write_bytes(content)
        truth += rows
    files = sorted(path.name for path in folder.iterdir())
    campaign = carry_through(config, folder, files)
    return replace(campaign, truth=tables.from_rows(truth, "truth"))


@pytest.fixture(scope="session")
def real_pcs() -> Path:
    if not REAL_PCS.is_dir():
        pytest.skip("the PCS exports as published (../shared/real/pcs) are not here")
    return REAL_PCS


@pytest.fixture(scope="session")
def etm(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """The measured curves of data/raw/etm-slim, curated."""

    def curated(_: Path) -> Campaign:
        config = resolve(ROOT / "config", {"campaign": "etm-slim"})
        return carry_through(config, ETM, raw_log_names(ETM))

    return made_once("etm", curated, tmp_path_factory)


@pytest.hookimpl(wrapper=True, optionalhook=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """One more than cores: tests wait for browsers, servers and runs of snakemake."""
    return (yield) + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Runs of snakemake come first: begun last, they would keep one core while the others rest.

    The first one makes what all others need. Long files that need none of it go beside it; one of
    them sleeps for most of its time.
    """
    first = ("test_every_law.py", "test_report_browser.py", "test_watch.py")

    def place(item: pytest.Item) -> int:
        if item.path.name in first:
            return first.index(item.path.name)
        return len(first) + (item.get_closest_marker("workflow") is None)

    items.sort(key=place)
