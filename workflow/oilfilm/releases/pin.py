"""Pins: the small part of a release that a repository keeps as reference for later releases.

Decides: what a pin keeps of a release.
"""

from pathlib import Path

from oilfilm.atomic_write import atomic_folder
from oilfilm.errors import OilfilmError
from oilfilm.releases.manifest import PINNED_MANIFEST
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.tree import PINS, copy_file

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
    """Keep a release as its campaign's pin, in folder of the one before; the pin's folder.

    Raises:
        OilfilmError: It is no release, is damaged, or is itself a pin.
    """
    stored = StoredRelease.open(release)
    if stored.pinned:
        raise OilfilmError(f"{release}: is a pin already; expected a release.")
    folder = root / PINS / stored.manifest.made_from.campaign
    with atomic_folder(folder) as temporary:
        for path in _KEPT:
            if path in stored.files:
                copy_file(stored.file(path), temporary / path)
        (temporary / PINNED_MANIFEST).write_bytes(stored.manifest.text().encode())
    return folder
