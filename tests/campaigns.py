"""A campaign carried through the library, for the tests that need one."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.curate import Curated, collect, curate
from oilfilm.fitting.fit import OilFit, fit_oil
from oilfilm.ingest import Ingested, ingest
from oilfilm.reference import printed_constants

ROOT = Path(__file__).parents[1]
REAL_PCS = ROOT.parent / "shared" / "real" / "pcs"


@dataclass(frozen=True)
class Campaign:
    """A campaign carried through the library: logs, samples, points, fits."""

    config: dict[str, Any]
    folder: Path
    truth: pd.DataFrame
    ingested: Ingested
    curated: Curated

    def fit(self, oil: str, **settings: Any) -> OilFit:
        config = {**self.config, "fit": {**self.config["fit"], **settings}}
        return fit_oil(self.curated.points, oil, printed().get(oil), config)


def printed() -> dict[str, np.ndarray]:
    return printed_constants(ROOT / "data/reference/printed_coefficients.yaml")


def carry_through(config: dict[str, Any], folder: Path, files: list[str]) -> Campaign:
    found = ingest(folder, files, config)
    samples = pd.concat(found.samples.values(), ignore_index=True)
    share = curate(samples, found.runs, config)
    return Campaign(
        config, folder, tables.empty("truth"), found, collect([share], [found.quarantine], config)
    )


def printed_settings(config: dict[str, Any]) -> dict[str, Any]:
    """What the rules hand to the study of the printed constants."""
    limit = config["gates"]["traction_max"]
    return {**config["printed"], "oils": list(config["oils"]), "traction_max": limit}
