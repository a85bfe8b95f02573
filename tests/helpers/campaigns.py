"""Campaigns for the tests: carried through the library, or laid out for snakemake."""

import os
import pickle
import shutil
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import pytest
import yaml

from oilfilm import tables
from oilfilm.base import studies
from oilfilm.curation.curate import CuratedTables, curate_ingested
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.fits.fit import fit_oil
from oilfilm.logs.ingest import IngestedLogs, ingest_logs
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import OilFile, Rig
from oilfilm.tables.campaign_tables import CampaignTables

if sys.platform != "win32":
    import fcntl

ROOT = Path(__file__).parents[2]
REFERENCE = ROOT / "data/reference/printed_coefficients.yaml"
# Configuration of a laboratory for tests: it needs no package beside oilfilm.
LABORATORY = ROOT / "tests/laboratory"
ETM = ROOT / "data/raw/etm-slim"
REAL_PCS = ROOT.parent / "shared" / "real" / "pcs"
# Settings of fits that take seconds: `tests/workflow/test_every_law.py` has every law.
QUICK = {"fit": {"bootstrap": 20, "searches": 2}, "compare": {"laws": ["deng2026", "tanh"]}}
# Constants of a film that heats itself, as in the campaign `thermal`.
HEATED_FILM = {
    **{"eyring_stress_pa": 5e6, "limiting_stress_ratio": 0.08},
    **{"limiting_stress_reference_c": 40.0, "limiting_stress_decay_1_k": 0.003},
    **{"solid_conductivity_w_mk": 46.0, "solid_volumetric_heat_j_m3k": 3.6e6},
}
SMALL_MATRIX = {
    "max_hertz_pressure_gpa": [1.0, 1.25, 1.5],
    "entrainment_speed_m_s": [25, 40],
    "inlet_temperature_c": [50, 120],
}


# What a function makes once for all workers.
Made = TypeVar("Made")


@dataclass(frozen=True)
class Campaign:
    """A campaign carried through the library: logs, samples, points, fits.

    Attributes:
        config: Its settings.
        folder: Folder of its logs.
        truth: Table of the truth behind simulated logs; empty if nothing has filled it.
        ingested: Its logs as they are read.
        curated: Its points, runs and quarantine.
    """

    config: Settings
    folder: Path
    truth: pd.DataFrame
    ingested: IngestedLogs
    curated: CuratedTables

    def fit(self, oil: str, **settings: Any) -> CampaignTables:
        """The fit of one oil with some settings of `fit` changed."""
        config = self.config.with_changes({"fit": settings})
        return fit_oil(self.curated.points, oil, config.fit, config.seed)


def oil_of(name: str) -> Oil:
    """An oil of config/oils."""
    return load(ROOT / f"config/oils/{name}.yaml", OilFile).properties()


def rig_contact() -> Contact:
    """The contact of the rig of the paper."""
    contact = load(ROOT / "config/rigs/ball-on-disc-20mm.yaml", Rig).contact()
    assert contact is not None
    return contact


@cache
def printed() -> dict[str, np.ndarray]:
    """Constants of the law `deng2026` by oil: those that Deng et al. (2026) print."""
    oils = yaml.safe_load(REFERENCE.read_text("utf-8"))["oils"]
    return {oil: np.concatenate([block[letter] for letter in "ABC"]) for oil, block in oils.items()}


needs_study = pytest.mark.skipif(
    "deng2026_study" not in studies.available(),
    reason="the study of Deng et al. (2026) is not here",
)


def simulator() -> ModuleType:
    """The module that simulates logs; a test that needs it is skipped where it is not."""
    module: ModuleType = pytest.importorskip("simulated_lab.simulate")
    return module


def carry_through(config: Settings, folder: Path, files: Iterable[str]) -> Campaign:
    """Ingest and curate some log files of a folder."""
    return carry_logs(config, ((file, (folder / file).read_bytes()) for file in files), folder)


def carry_logs(
    config: Settings, logs: Iterable[tuple[str, bytes]], folder: Path = ROOT
) -> Campaign:
    """Ingest and curate logs, each with its name and its bytes."""
    ingested = ingest_logs(logs, config)
    curated = curate_ingested(ingested, TractionRig(config))
    return Campaign(config, folder, pd.DataFrame(), ingested, curated)


def made_once(name: str, make: Callable[[Path], Made], factory: pytest.TempPathFactory) -> Made:
    """What the first worker makes in a folder, for all workers of this run."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return make(factory.mktemp(name, numbered=False))

    # each worker has a folder of its own in that of the run
    folder = factory.getbasetemp().parent / name
    kept = folder.with_suffix(".pickle")
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not kept.exists():
            folder.mkdir()
            kept.write_bytes(pickle.dumps(make(folder)))
    made: Made = pickle.loads(kept.read_bytes())
    return made


def rows(table: str, *given: dict[str, Any], flag: bool = False) -> pd.DataFrame:
    """Rows of a table; what is not given is null, zero, empty or `flag`."""
    nothing = {"number": np.nan, "integer": 0, "flag": flag, "text": "", "texts": ()}
    empty = {column.name: nothing[column.type] for column in tables.TABLES[table].columns}
    return pd.DataFrame([{**empty, **row} for row in given], columns=list(empty))


def laboratory_campaign() -> dict[str, Any]:
    """Keys of a measured campaign, which needs no package beside oilfilm."""
    return _read(LABORATORY / "campaigns/laboratory.yaml")


def simulated_campaign() -> dict[str, Any]:
    """Keys of a simulated campaign; the test is skipped where nothing simulates logs."""
    simulator()
    return _read(LABORATORY / "campaigns/simulated.yaml")


def without(settings: Settings, *keys: str) -> Settings:
    """Settings of a campaign whose file lacks some keys."""
    plain = settings.plain_values()
    campaign = {key: value for key, value in plain["campaign"].items() if key not in keys}
    return Settings.from_plain_values({**plain, "campaign": campaign})


def lay_out(project: Path) -> None:
    """A copy of the project, without logs and results; its bytecode spares each run a second."""
    for name in ("config", "data/reference", "profiles", "requirements", "workflow"):
        # other workers may write bytecode meanwhile, first under a temporary name
        shutil.copytree(ROOT / name, project / name, ignore=shutil.ignore_patterns("*.pyc.*"))
    for name in ("Snakefile", "pyproject.toml"):
        shutil.copy(ROOT / name, project)


def lay_out_small(project: Path) -> None:
    """The same with the campaign `small`: simulated, one oil, 12 runs, two defects."""
    campaign = simulated_campaign()
    lay_out(project)
    campaign["oils"] = ["4102"]
    del campaign["torque"]
    campaign["matrix"] = SMALL_MATRIX
    campaign["twin"]["defects"] = [
        {"oil": "4102", "condition": [1.0, 25, 50], "kind": "truncated"},
        {"oil": "4102", "condition": [1.0, 40, 50], "kind": "swapped_sign"},
    ]
    campaign["settings"] = {**QUICK, "split": {"runs": 6}}
    write_campaign(project, "small", campaign)


def lay_out_measured(
    project: Path, name: str, oils: list[str], matrix: dict[str, list[float]]
) -> Path:
    """A campaign of simulated logs as if a user had measured them; the folder of its logs."""
    campaign = simulated_campaign()
    raw = project / "data/raw" / name
    raw.mkdir(parents=True)
    lay_out(project)
    campaign |= {"oils": oils, "matrix": matrix, "figures": ["curves"]}
    campaign["settings"] = {**QUICK, "compare": {"laws": ["tanh"]}, "split": {"runs": 6}}
    campaign["twin"] |= {"slip_steps": 9, "sampling_rate_hz": 20, "defects": []}
    del campaign["torque"]
    write_campaign(project, name, campaign)
    config = resolve(project / "config", {"campaign": name})
    for run, content, _ in simulator().simulate_campaign(config, printed()):
        (raw / run.name).write_bytes(content)
    del campaign["twin"]
    write_campaign(project, name, campaign)
    return raw


def as_measured(project: Path, name: str) -> Path:
    """The campaign `small` under another name, as if a user had measured it; its empty folder."""
    campaign = read_campaign(project, "small")
    del campaign["twin"]
    write_campaign(project, name, campaign)
    raw = project / "data/raw" / name
    raw.mkdir()
    return raw


def read_campaign(project: Path, name: str) -> dict[str, Any]:
    """The keys of a campaign file of a project."""
    return _read(project / f"config/campaigns/{name}.yaml")


def _read(path: Path) -> dict[str, Any]:
    campaign: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return campaign


def write_campaign(project: Path, name: str, campaign: dict[str, Any]) -> None:
    """Write the keys of a campaign into its file in a project."""
    path = project / f"config/campaigns/{name}.yaml"
    path.write_text(yaml.safe_dump(campaign, allow_unicode=True), encoding="utf-8")
