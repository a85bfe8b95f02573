"""Rebuild a release from the raw logs in a temporary folder and compare it byte by byte.

Decides: how a release is rebuilt.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from oilfilm import home
from oilfilm.errors import OilfilmError, printable
from oilfilm.releases.compare import Comparison, compare
from oilfilm.releases.manifest import CODE, FileRecord
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.tree import code_files, copy_file
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.messages import check
from oilfilm.settings.resolve import unresolve
from oilfilm.settings.resolved import Settings

# What a run needs beside its code. The configuration comes from the release.
_OTHER_FILES = (home.RUN_LOCK, "pyproject.toml", "profiles/default/config.yaml")


def rebuild(release: Path, root: Path, cores: str) -> Comparison:
    """Rebuild a release from the local raw logs and code; compare it with what was rebuilt.

    The code in the release is never run: its author may be unknown. The local code must match.

    Args:
        release: Folder of the release.
        root: Top folder of the project, with code and raw logs.
        cores: For snakemake.

    Raises:
        OilfilmError: It is a pin, a raw log is missing or has changed, or the run fails.
    """
    stored = StoredRelease.open(release)
    with tempfile.TemporaryDirectory(prefix="oilfilm-rebuild-") as temporary:
        folder = Path(temporary)
        settings = lay_out(stored, root, folder)
        _run(folder, stored, cores)
        campaign = stored.manifest.made_from.campaign
        rebuilt = StoredRelease.open(folder / "results" / "releases" / campaign / "latest")
        return compare(stored, rebuilt, settings.drift)


def lay_out(stored: StoredRelease, root: Path, folder: Path) -> Settings:
    """Put local code, a release's configuration and measured logs into a fresh folder.

    Returns:
        The settings of the release.

    Raises:
        OilfilmError: It is a pin, its configuration is none, a raw log is missing or has changed.
    """
    if stored.pinned:
        raise OilfilmError(
            f"{stored.folder}: is a pin, which cannot be rebuilt; expected a release."
        )
    for path, file in code_files(home.HOME).items():
        copy_file(file, folder / path)
    for path in _OTHER_FILES:
        copy_file(home.HOME / path, folder / path)
    config = stored.config()
    try:
        settings = Settings.of(config)
        check(config["campaign"], Campaign, lambda steps: "campaign")
        texts = unresolve(settings)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError, OilfilmError) as error:
        raise OilfilmError(
            f"{stored.folder}: config.yaml is not a configuration of this version of oilfilm "
            f"({error}). If the release was made by another version, rebuild it with a clone of "
            f"that version; its code is in the folder {CODE}/ of the release."
        ) from error
    # the rig twin writes these logs again
    torque_twin = settings.campaign.torque and settings.campaign.torque.twin
    name = settings.campaign.name
    twins = {name: settings.campaign.twin, f"{name}-torque": torque_twin}
    for path, text in texts.items():
        target = folder / "config" / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    for record in stored.manifest.made_from.raw:
        if twins.get(record.path.split("/")[2]):
            continue
        source = root / record.path
        if source.is_file():
            copy_file(source, folder / record.path)
        if not source.is_file() or FileRecord.of(folder / record.path, record.path) != record:
            raise OilfilmError(
                f"{source}: is not the log that release {stored.name} was made from. "
                "Put the original back, then try again."
            )
    return settings


def _run(folder: Path, stored: StoredRelease, cores: str) -> None:
    command = [sys.executable, "-m", "snakemake", "release", "--cores", cores]
    # use the library of the copy, not the installed one
    environment = {**os.environ, "PYTHONPATH": str(folder / "workflow")}
    done = subprocess.run(  # noqa: S603 - a fixed command; `cores` is one argument
        command,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode != 0:
        output = (done.stdout + done.stderr).replace(str(folder), ".").splitlines()
        last = "\n".join(printable(line) for line in output[-30:])
        raise OilfilmError(f"{stored.folder}: the rebuild failed. Its last lines:\n{last}")
