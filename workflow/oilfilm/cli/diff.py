"""The command `oilfilm diff`: what differs between two releases, and whether it is too much."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import BaseModel, ConfigDict, Field

from oilfilm import tables
from oilfilm.cli.arguments import config_folder
from oilfilm.releases.compare import Comparison, Section, compare
from oilfilm.releases.drift import drift_table
from oilfilm.releases.messages import comparison_text, section_text
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.config import DriftSettings
from oilfilm.settings.resolve import read_config, resolve


class Differences(BaseModel):
    """One aspect in which two releases differ, as a table of text."""

    model_config = ConfigDict(extra="forbid")

    title: str = Field(description="the aspect")
    columns: list[str] = Field(description="heads of the columns")
    rows: list[list[str]] = Field(description="one list of cells per row")


class ComparedReleases(BaseModel):
    """Two releases, A and B, and all that differs."""

    model_config = ConfigDict(extra="forbid")

    before: str = Field(description="release A")
    after: str = Field(description="release B")
    sections: list[Differences] = Field(description="aspects that differ; empty where none does")
    constants: list[dict[str, Any]] = Field(
        description="oil, constant, `before`, `after` and `change` in standard errors of A; null "
        "where there is none"
    )
    traction: list[dict[str, Any]] = Field(
        description="where mu of each oil changed most, by `measure`: `change`, `before`, `after`, "
        "`where`; null where mu cannot be compared"
    )
    beyond_limits: Differences = Field(
        description="changes beyond the limits of `drift` in the configuration"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where `--gate` finds a change beyond its limit."""
    before, after = StoredRelease.open(options.before), StoredRelease.open(options.after)
    campaign = after.manifest.made_from["campaign"]
    drift = _drift(config_folder(options.config), campaign, options.gate)
    comparison = compare(before, after, drift)
    too_far = drift_table(comparison, drift)
    if options.html:
        from oilfilm.releases.page import page  # noqa: PLC0415 - needs the extra `report`

        # YAML can escape half of a surrogate pair, which UTF-8 cannot encode
        text = page(comparison, too_far)
        options.html.write_text(text, encoding="utf-8", errors="backslashreplace")
    if options.json:
        print(as_json(comparison, too_far).model_dump_json())
    elif not options.gate:
        print(comparison_text(comparison))
    elif too_far.rows:
        # this table is never cut
        table = section_text(too_far, len(too_far.rows))
        print(f"A {before.name}\nB {after.name}\n{table}")
    return int(options.gate and bool(too_far.rows))


def as_json(comparison: Comparison, too_far: Section) -> ComparedReleases:
    """A comparison as plain values."""
    constants, traction = comparison.constants, comparison.traction
    return ComparedReleases(
        before=comparison.before.name,
        after=comparison.after.name,
        sections=[_differences(section) for section in comparison.sections if section.rows],
        constants=_changed(constants),
        traction=_changed(traction),
        beyond_limits=_differences(too_far),
    )


def _differences(section: Section) -> Differences:
    rows = [list(row) for row in section.rows]
    return Differences(title=section.title, columns=list(section.columns), rows=rows)


def _changed(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows with a change; numbers that JSON cannot write become None."""
    return [
        {
            name: None if isinstance(value, float) and not np.isfinite(value) else value
            for name, value in row.items()
        }
        for row in tables.rows(table[table["change"] != 0])
    ]


def _drift(folder: Path, campaign: str, gate: bool) -> DriftSettings:
    """Settings `drift` of the campaign, or of config.yaml where the campaign is not configured.

    Raises:
        OilfilmError: The configuration has a mistake, or the gate needs a campaign that it lacks.
    """
    if gate or (folder / "campaigns" / f"{campaign}.yaml").is_file():
        return resolve(folder, {"campaign": campaign}).drift
    return read_config(folder).drift
