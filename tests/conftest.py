"""Fixtures that several tests share: configuration, demonstration campaign, measured curves."""

import os
from pathlib import Path

# Before NumPy is imported, here and in the workers: small matrices lose by threads, sixtyfold.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings

from campaigns import ETM, REAL_PCS, ROOT, Campaign, carry_through, printed
from oilfilm import tables
from oilfilm.readers.raw_files import raw_files
from oilfilm.rig_twin.simulate import simulate_campaign
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

# No timed assertions, and the same examples in every run: a slow machine must not fail a test.
settings.register_profile(
    "oilfilm",
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("oilfilm")


@pytest.fixture(scope="session")
def config() -> Settings:
    return resolve(ROOT / "config", {"campaign": "demo"})


@pytest.fixture(scope="session")
def demo(config: Settings, tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """The whole demonstration campaign, simulated and curated."""
    folder = tmp_path_factory.mktemp("demo")
    truth = []
    for run, content, row in simulate_campaign(config, printed()):
        (folder / run.name).write_bytes(content)
        truth.append(row)
    files = sorted(path.name for path in folder.iterdir())
    campaign = carry_through(config, folder, files)
    return Campaign(
        config, folder, tables.from_rows(truth, "truth"), campaign.ingested, campaign.curated
    )


@pytest.fixture(scope="session")
def real_pcs() -> Path:
    if not REAL_PCS.is_dir():
        pytest.skip("the PCS exports as published (../shared/real/pcs) are not here")
    return REAL_PCS


@pytest.fixture(scope="session")
def etm() -> Campaign:
    """The measured curves of data/raw/etm-slim, curated."""
    config = resolve(ROOT / "config", {"campaign": "etm-slim"})
    return carry_through(config, ETM, raw_files(ETM))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Runs of snakemake come first: begun last, they would keep one core while the others rest."""
    items.sort(key=lambda item: item.get_closest_marker("workflow") is None)
