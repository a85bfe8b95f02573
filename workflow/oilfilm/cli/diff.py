"""The command `oilfilm diff`: what differs between two releases, and whether it is too much."""

import argparse
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.cli.arguments import config_folder
from oilfilm.releases.compare import Comparison, Section, compare, drift_table
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.base import Group, key
from oilfilm.settings.config import DriftSettings
from oilfilm.settings.resolve import read_config, resolve


class ComparedReleases(Group):
    """Two releases, A and B, and all that differs."""

    before: str = key("Release A.")
    after: str = key("Release B.")
    sections: list[Section] = key("Aspects that differ; empty where none does.")
    constants: list[dict[str, Any]] = key(
        "Oil, constant, `before`, `after` and `change` in standard errors of A; null where there "
        "is none."
    )
    traction: list[dict[str, Any]] = key(
        "Where mu of each oil changed most, by `measure`: `change`, `before`, `after`, `where`; "
        "null where mu cannot be compared."
    )
    beyond_limits: Section = key("Changes beyond the limits of `drift` in the configuration.")


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where `--gate` finds a change beyond its limit."""
    before, after = StoredRelease.open(options.before), StoredRelease.open(options.after)
    campaign = after.manifest.made_from.campaign
    drift = _drift(config_folder(options.config), campaign, options.gate)
    comparison = compare(before, after, drift)
    too_far = drift_table(comparison, drift)
    if options.json:
        print(as_json(comparison, too_far).model_dump_json())
    elif not options.gate:
        print(comparison.text())
    elif too_far.rows:
        # this table is never cut
        print(f"A {before.name}\nB {after.name}\n{too_far.text()}")
    return int(options.gate and bool(too_far.rows))


def as_json(comparison: Comparison, too_far: Section) -> ComparedReleases:
    """A comparison as plain values."""
    return ComparedReleases(
        before=comparison.before.name,
        after=comparison.after.name,
        sections=[section for section in comparison.sections if section.rows],
        constants=_changed(comparison.constants),
        traction=_changed(comparison.traction),
        beyond_limits=too_far,
    )


def _changed(table: pd.DataFrame) -> list[dict[str, Any]]:
    # a number that JSON cannot write becomes null
    return tables.rows(table[table["change"] != 0])


def _drift(folder: Path, campaign: str, gate: bool) -> DriftSettings:
    """Settings `drift` of the campaign, or of config.yaml where the campaign is not configured.

    Raises:
        OilfilmError: The configuration has a mistake, or the gate needs a campaign that it lacks.
    """
    if gate or (folder / "campaigns" / f"{campaign}.yaml").is_file():
        return resolve(folder, {"campaign": campaign}).drift
    return read_config(folder).drift
