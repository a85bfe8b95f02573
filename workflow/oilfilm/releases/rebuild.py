"""A release made anew from the raw logs, in a folder of its own, and compared byte by byte."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from oilfilm.errors import OilfilmError
from oilfilm.releases.manifest import CODE, FileRecord, shown
from oilfilm.releases.opened import Opened
from oilfilm.releases.table_diff import difference
from oilfilm.releases.tree import code_files
from oilfilm.settings.load import unresolve

# What a run needs beside its code; the configuration is the release's own.
_BESIDE = ("requirements.lock", "pyproject.toml", "profiles/default/config.yaml")


def rebuild(release: Path, root: Path, cores: str) -> list[str]:
    """Make a release anew from the raw logs and the code that are here; every difference.

    The code of a release is never run: it may be a stranger's. That here must be the same.

    Args:
        release: Folder of the release.
        root: Top folder of the project, with code and raw logs.
        cores: For snakemake.

    Raises:
        OilfilmError: It is a pin, a raw log is missing or has changed, or the run fails.
    """
    opened = Opened.at(release)
    config = opened.config()
    if opened.pinned or config is None:
        raise OilfilmError(f"{release}: is a pin, which cannot be rebuilt; expected a release.")
    with tempfile.TemporaryDirectory(prefix="oilfilm-rebuild-") as folder:
        place = Path(folder)
        _lay_out(opened, config, root, place)
        _run(place, opened, cores)
        campaign = opened.manifest.made_from["campaign"]
        again = Opened.at(place / "results" / "releases" / campaign / "latest")
        return differences(opened, again)


def _lay_out(opened: Opened, config: dict[str, Any], root: Path, place: Path) -> None:
    """Code, configuration and raw logs in a fresh folder."""
    for path in (*code_files(root), *_BESIDE):
        _copy(root / path, place / path)
    try:
        texts, simulated = unresolve(config), _made_by_twin(config)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise OilfilmError(
            f"{opened.folder}: config.yaml is no resolved configuration ({error!r})."
        ) from error
    for path, text in texts.items():
        target = place / "config" / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    campaign = opened.manifest.made_from["campaign"]
    for record in opened.manifest.raw:
        # what the twin writes it writes again
        if simulated.get(record.path.split("/")[2]):
            continue
        source = root / record.path
        if not source.is_file() or FileRecord.of(root, record.path) != record:
            raise OilfilmError(
                f"{source}: is not the log that release {shown(campaign)} "
                f"{shown(opened.manifest.version)} was made from. Put it back, then again."
            )
        _copy(source, place / record.path)


def _made_by_twin(config: dict[str, Any]) -> dict[str, bool]:
    """Whether a folder of raw logs is written by a twin."""
    campaign = config["campaign"]
    name = campaign["name"]
    return {name: "twin" in campaign, f"{name}-torque": "twin" in campaign.get("torque", {})}


def _copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _run(place: Path, opened: Opened, cores: str) -> None:
    command = [sys.executable, "-m", "snakemake", "release", "--cores", cores]
    # the copy's own library, whatever is installed
    environment = {**os.environ, "PYTHONPATH": str(place / "workflow")}
    done = subprocess.run(  # noqa: S603 - a fixed command; `cores` is one argument
        command,
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode != 0:
        said = (done.stdout + done.stderr).replace(str(place), ".").splitlines()
        last = "\n".join(shown(line) for line in said[-30:])
        raise OilfilmError(f"{opened.folder}: the rebuild did not end. Its last words:\n{last}")


def differences(before: Opened, after: Opened) -> list[str]:
    """Every file in which two releases differ, of the first one also where."""
    found = []
    for what, old, new in (
        ("raw log ", before.manifest.raw, after.manifest.raw),
        ("", before.manifest.files, after.manifest.files),
        ("samples ", before.manifest.samples, after.manifest.samples),
    ):
        was, now = ({record.path: record for record in each} for each in (old, new))
        # code first: what follows may follow from it
        paths = sorted(
            was.keys() | now.keys(), key=lambda path: (not path.startswith(f"{CODE}/"), path)
        )
        for path in paths:
            if was.get(path) != now.get(path):
                state = "is gone" if path not in now else "is new" if path not in was else "differs"
                found.append((what, path, state))
    lines = [f"{what}{shown(path)} {state}" for what, path, state in found]
    if found and found[0][0] == "" and found[0][2] == "differs":
        path = found[0][1]
        lines[0] += ": " + difference(before.file(path), after.file(path))
    return lines
