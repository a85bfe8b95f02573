"""Pins: the small part of a release that a repository keeps, to hold later releases against."""

import shutil
from pathlib import Path

from oilfilm.errors import OilfilmError
from oilfilm.releases.manifest import PINNED_MANIFEST
from oilfilm.releases.opened import Opened
from oilfilm.releases.tree import PINS

# What the drift gate and a comparison of settings and verdicts need; no points, for their size.
_KEPT = (
    "config.yaml",
    "tables/claims.parquet",
    "tables/coefficients.parquet",
    "tables/fit_quality.parquet",
    "tables/runs.parquet",
    "tables/torque_runs.parquet",
)


def pin(release: Path, root: Path) -> Path:
    """Keep a release as its campaign's pin, in place of the one before; the pin's folder.

    Raises:
        OilfilmError: It is no release, is damaged, or is itself a pin.
    """
    opened = Opened.at(release)
    if opened.pinned:
        raise OilfilmError(f"{release}: is a pin already; expected a release.")
    place = root / PINS / opened.manifest.made_from["campaign"]
    aside = place.with_name(f".{place.name}.part")
    shutil.rmtree(aside, ignore_errors=True)
    for path in _KEPT:
        if path in opened.files:
            target = aside / path
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(opened.file(path), target)
    (aside / PINNED_MANIFEST).write_bytes(opened.manifest.text().encode())
    if place.exists():
        shutil.rmtree(place)
    aside.rename(place)
    return place
