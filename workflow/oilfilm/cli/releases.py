"""The commands about releases: `oilfilm verify`, `fetch`, `diff` and `pin`."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.cli.arguments import config_folder, json_text
from oilfilm.errors import printable
from oilfilm.releases.compare import Comparison, Section, compare, drift_table
from oilfilm.releases.rebuild import rebuild
from oilfilm.releases.stored_release import StoredRelease, fetch_release, pin
from oilfilm.settings.config import DriftSettings
from oilfilm.settings.resolve import read_config, resolve


def run(options: argparse.Namespace) -> int:
    """Run the command of this name; exit code 1 where a release is not as it should be."""
    commands = {"verify": _verify, "fetch": _fetch, "diff": _diff, "pin": _pin}
    return commands[options.command](options)


def _verify(options: argparse.Namespace) -> int:
    """Whether a release is as it was made, and whether it can be made again."""
    release: Path = options.release
    stored = StoredRelease.open(release)
    version, wrong, rebuilt = stored.manifest.version, stored.changes(), None
    if not options.json:
        checked = "the files in the pin" if stored.pinned else f"all {len(stored.files)} files"
        note = "; a signature is there, and ssh-keygen checks it" * stored.signed
        as_released = f"{printable(version)}: {checked} are as released{note}"
        head = f"{release}: {len(wrong)} files are not as released:"
        # now: a rebuild takes minutes
        print("\n".join([head, *wrong]) if wrong else as_released, flush=True)
    if options.rebuild and not wrong:
        rebuilt = rebuild(release, Path(), options.cores)
    if options.json:
        found = {
            "folder": str(release),
            "version": version,
            "pin": stored.pinned,
            "files": len(stored.files),
            "signed": stored.signed,
            "not_as_released": wrong,
            "rebuilt": rebuilt,
        }
        print(json_text(found))
    elif rebuilt is not None:
        head = f"rebuilt from the raw logs: {len(rebuilt)} differences, the first:"
        same = "rebuilt from the raw logs: the same bytes"
        print("\n".join([head, *map(printable, rebuilt)]) if rebuilt else same)
    return int(bool(wrong or rebuilt))


def _fetch(options: argparse.Namespace) -> int:
    """Copy a release; every file is checked before its folder appears."""
    fetch_release(options.address, options.folder)
    print(f"{options.folder}: all files are as released")
    return 0


def _pin(options: argparse.Namespace) -> int:
    """Keep a release as the reference for later ones."""
    print(f"{pin(options.release, Path())}: pinned; commit it")
    return 0


def _diff(options: argparse.Namespace) -> int:
    """What differs between two releases; 1 where `--gate` finds a change beyond its limit."""
    before, after = StoredRelease.open(options.before), StoredRelease.open(options.after)
    campaign = after.manifest.made_from.campaign
    drift = _drift(config_folder(options.config), campaign, options.gate)
    comparison = compare(before, after, drift)
    too_far = drift_table(comparison, drift)
    if options.json:
        print(json_text(_plain(comparison, too_far)))
    elif not options.gate:
        print(comparison.text())
    elif too_far.rows:
        # this table is never cut
        print(f"A {before.name}\nB {after.name}\n{too_far.text()}")
    return int(options.gate and bool(too_far.rows))


def _plain(comparison: Comparison, too_far: Section) -> dict[str, Any]:
    """A comparison as plain values: aspects that differ, constants, traction, what is too far."""

    def changed(table: pd.DataFrame) -> list[dict[str, Any]]:
        return tables.rows(table[table["change"] != 0])

    return {
        "before": comparison.names[0],
        "after": comparison.names[1],
        "sections": [asdict(section) for section in comparison.sections],
        "constants": changed(comparison.constants),
        "traction": changed(comparison.traction),
        "beyond_limits": asdict(too_far),
    }


def _drift(folder: Path, campaign: str, gate: bool) -> DriftSettings:
    """Settings `drift` of the campaign, or of config.yaml where the campaign is not configured.

    Raises:
        OilfilmError: The configuration has a mistake, or the gate needs a campaign that it lacks.
    """
    if gate or (folder / "campaigns" / f"{campaign}.yaml").is_file():
        return resolve(folder, {"campaign": campaign}).drift
    return read_config(folder).drift
