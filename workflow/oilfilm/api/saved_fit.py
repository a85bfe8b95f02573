"""Saving a fit of arrays or of a table of mu, in the form of a campaign's results.

Decides: what is saved of a fit that was made without the workflow.
"""

import os
import re
from pathlib import Path
from typing import Any

import pandas as pd

import oilfilm
from oilfilm import tables
from oilfilm.api.arrays import ArrayFit
from oilfilm.base.atomic_write import atomic_folder, write_bytes, write_text
from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.home import CONFIG
from oilfilm.exports.campaign import export_campaign, export_oil
from oilfilm.exports.description import describe, make_identifiers
from oilfilm.fits.soundness import finished_fit_tables
from oilfilm.logs.base import SET_POINT_KEYS
from oilfilm.report.html import html_report
from oilfilm.report.sections.build import (
    answer_section,
    constants_section,
    fits_section,
    laws_section,
)
from oilfilm.report.text import text_report
from oilfilm.settings.quantities import NAME_PATTERN
from oilfilm.settings.resolve import resolve, safe_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import FIT_TABLES, SURFACE_TABLES
from oilfilm.traction import LAWS

_SAVED_TABLE_NAMES = (
    *("points", "runs", *FIT_TABLES, *SURFACE_TABLES),
    *("law_verdicts", "lack_of_fit", "soundness"),
)
# Title and path of what the folder of a saved fit contains, for its summary.
_CONTENTS = (("Report", "report.html"), ("Tables", "tables"), ("Exports", "exports"))


def save_fit(fit: ArrayFit, folder: Path) -> None:
    """Write tables, exports and report, in the form of a campaign's results.

    Args:
        fit: The fit.
        folder: A new folder. Its name becomes that of the campaign.

    Raises:
        OilfilmError: The folder exists, or its name cannot be that of a campaign.
    """
    campaign_name = safe_name(folder.resolve().name, folder)
    # a broken link counts: no folder can take its place
    if os.path.lexists(folder):
        raise OilfilmError(f"{folder}: exists already. Name a new folder.")
    fit_tables, settings, provenance = as_campaign(fit, campaign_name)
    footer = {"campaign": campaign_name, "data": settings.campaign.data, **provenance}
    sections = [
        answer_section(fit_tables, settings),
        fits_section(fit_tables),
        constants_section(fit_tables),
        laws_section(fit_tables, settings),
    ]
    shown_sections = [section for section in sections if section]
    with atomic_folder(folder) as temporary_folder:
        for table_name in _SAVED_TABLE_NAMES:
            file = temporary_folder / f"tables/{table_name}.parquet"
            tables.write(fit_tables.table(table_name), table_name, file, footer)
        for export_path, content in export_campaign(fit_tables, settings, provenance).items():
            write_bytes(content, temporary_folder / "exports" / export_path)
        summary_text = text_report(shown_sections, settings.campaign, _CONTENTS)
        write_text(summary_text, temporary_folder / "summary.txt")
        # no run was refused, so that the folder of their pages is not read
        report_page = html_report(
            shown_sections,
            fit_tables,
            pngs=[],
            refused_folder=temporary_folder,
            settings=settings,
            provenance=provenance,
        )
        write_text(report_page, temporary_folder / "report.html")


def export_fit(fit: ArrayFit, path: Path) -> None:
    """Write the law in the form that the ending of a file names.

    Raises:
        OilfilmError: There is no such form, or the fit has none.
    """
    fit_tables, settings, provenance = as_campaign(fit, "arrays")
    law = LAWS[settings.fit.law]
    identifier = make_identifiers([fit.oil])[fit.oil]
    description = describe(fit_tables, fit.oil, identifier, law, settings)
    content_by_file = export_oil(description, provenance)
    content_by_ending: dict[str, bytes] = {}
    for file_name, content in content_by_file.items():
        # the first of several files with one ending
        content_by_ending.setdefault(Path(file_name).suffix, content)
    if path.suffix not in content_by_ending:
        reason = description.obstacle or f"expected {', '.join(sorted(content_by_ending))}"
        raise OilfilmError(f"{path}: there is no export of this kind: {reason}.")
    write_bytes(content_by_ending[path.suffix], path)


def as_campaign(
    fit: ArrayFit, campaign_name: str
) -> tuple[CampaignTables, Settings, dict[str, Any]]:
    """The fit as a finished campaign: its tables, settings and provenance.

    Raises:
        OilfilmError: The name of its oil cannot be that of an oil of a campaign.
    """
    if not re.fullmatch(NAME_PATTERN, fit.oil):
        raise OilfilmError(
            f"oil: found the name {cut(repr(fit.oil))}; to save or export a fit, expected ASCII "
            "letters, digits, '_', '.' and '-', as SAE-10W-40, and neither '.' nor '-' at the "
            "beginning. Rename the oil in the table; where the table names none, in the call."
        )
    # a fit of arrays does not know its oil: its tables have another name
    table_by_name = {
        table_name: fit.tables.table(table_name).assign(oil=fit.oil)
        for table_name in (*FIT_TABLES, *SURFACE_TABLES)
    }
    runs = _runs_table(fit, campaign_name)
    fit_tables = CampaignTables.from_frames(points=fit.campaign_points, runs=runs, **table_by_name)
    settings = _settings_of_table(fit, campaign_name)
    fit_tables = fit_tables.replace(**finished_fit_tables(fit_tables, settings))
    source_file = Path(fit.source)
    provenance = {
        # a campaign has digests here; the settings of this fit are arguments of a call
        "code": f"oilfilm {oilfilm.__version__}",
        "settings": None,
        "inputs": {source_file.name: file_digest(source_file)} if source_file.is_file() else {},
    }
    return fit_tables, settings, provenance


def _runs_table(fit: ArrayFit, campaign_name: str) -> pd.DataFrame:
    """The table `runs` of a campaign, one row per curve; its set points are means."""
    points_by_run = fit.campaign_points.groupby("run_id", sort=False)
    runs = pd.DataFrame({"accepted_points": points_by_run.size(), "plateaus": points_by_run.size()})
    for column in SET_POINT_KEYS:
        if column in fit.campaign_points:
            runs[f"nominal_{column}"] = points_by_run[column].mean()
    runs = runs.reset_index().assign(
        campaign=campaign_name, oil=fit.oil, rig="unknown", verdict="accepted", file=fit.source
    )
    return tables.filled_table(runs, "runs", "the table")


def _settings_of_table(fit: ArrayFit, campaign_name: str) -> Settings:
    """Settings of a campaign that has only this table."""
    # any campaign will do: the keys of the campaign are replaced
    shipped_settings = resolve(CONFIG, {"campaign": "etm-slim"}).plain_values()
    return Settings.from_plain_values(
        {
            **shipped_settings,
            "campaign": {
                "name": campaign_name,
                "data": "simulated" if fit.simulated else "measured",
                "description": f"table of traction coefficients {Path(fit.source).name}",
                "rigs": ["unknown"],
                "oils": [],
                "oils_without_properties": [fit.oil],
                "figures": [],
            },
            "dataset": {},
            "rigs": {},
            "oils": {fit.oil: None},
            "bearings": {},
            "fit": fit.settings.model_dump(),
        }
    )
