"""A fit of arrays or of a table of mu, saved as a campaign has its results.

Decides: what is saved of a fit that was made without the workflow.
"""

from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

import oilfilm
from oilfilm import tables
from oilfilm.atomic_write import atomic_folder, write_bytes, write_text
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError
from oilfilm.exports.campaign import export, export_campaign
from oilfilm.exports.description import describe, identifiers
from oilfilm.fits.soundness import finished_fits
from oilfilm.home import CONFIG
from oilfilm.logs.base import SET_POINTS
from oilfilm.report.html import html
from oilfilm.report.sections.build import answer, constants, fits, laws
from oilfilm.report.text import text
from oilfilm.settings.config import FitSettings
from oilfilm.settings.resolve import resolve, safe_name
from oilfilm.settings.resolved import Settings
from oilfilm.table_needs import OF_FIT
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS

_SAVED = ("points", "runs", *OF_FIT, "law_verdicts", "lack_of_fit", "soundness")
_PLACES = (("Report", "report.html"), ("Tables", "tables"), ("Exports", "exports"))


class FitAlone(NamedTuple):
    """A fit that was made without a campaign.

    Attributes:
        oil: Name of the oil.
        points: What was fitted, as a table of points.
        tables: The tables of the fit.
        settings: Settings of the fit.
        source: File of the points, else empty.
    """

    oil: str
    points: pd.DataFrame
    tables: CampaignTables
    settings: FitSettings
    source: str


def save_fit(fit: FitAlone, folder: Path) -> None:
    """Write tables, exports and report, as a campaign has them in its results.

    Args:
        fit: The fit.
        folder: A new folder; its name is that of the campaign.

    Raises:
        OilfilmError: The folder exists, or its name cannot be that of a campaign.
    """
    if folder.exists():
        raise OilfilmError(f"{folder}: exists already. Name a new folder.")
    name = safe_name(folder.resolve().name, folder)
    results, settings, provenance = _campaign(fit, name)
    with atomic_folder(folder) as made:
        about = {"campaign": name, "data": "measured", **provenance}
        for table in _SAVED:
            tables.write(results.table(table), table, made / f"tables/{table}.parquet", about)
        for file, content in export_campaign(results, settings, provenance).items():
            write_bytes(content, made / "exports" / file)
        made_of = answer(results, settings), fits(results), constants(results)
        sections = [each for each in (*made_of, laws(results, settings)) if each]
        write_text(text(sections, settings.campaign, _PLACES), made / "summary.txt")
        page = html(sections, results, [], made, settings, provenance)
        write_text(page, made / "report.html")


def export_fit(fit: FitAlone, path: Path) -> None:
    """Write the law in the form that the ending of a file names.

    Raises:
        OilfilmError: There is no such form, or the fit has none.
    """
    results, settings, provenance = _campaign(fit, "arrays")
    law, (name,) = LAWS[settings.fit.law], identifiers([fit.oil]).values()
    described = describe(results, fit.oil, name, law, settings)
    files = export(described, provenance)
    by_ending = {Path(file).suffix: content for file, content in reversed(files.items())}
    if path.suffix not in by_ending:
        why = described.obstacle or f"expected {', '.join(sorted(by_ending))}"
        raise OilfilmError(f"{path}: there is no export of this kind: {why}.")
    write_bytes(by_ending[path.suffix], path)


def _campaign(fit: FitAlone, name: str) -> tuple[CampaignTables, Settings, dict[str, Any]]:
    """The fit as a finished campaign: its tables, settings and provenance."""
    means = fit.points.groupby("run_id", sort=False)
    runs = pd.DataFrame({"accepted_points": means.size(), "plateaus": means.size()})
    for column in SET_POINTS:
        runs[f"nominal_{column}"] = means[column].mean()
    runs = runs.reset_index().assign(
        campaign=name, oil=fit.oil, rig="unknown", verdict="accepted", file=fit.source
    )
    results = CampaignTables.in_memory(
        points=fit.points,
        runs=tables.filled(runs, "runs", "the table"),
        **{table: fit.tables.table(table).assign(oil=fit.oil) for table in OF_FIT},
    )
    source, settings = Path(fit.source), _settings(fit, name)
    provenance = {
        "code": f"oilfilm {oilfilm.__version__}",
        "settings": None,
        "inputs": {source.name: file_digest(source)} if source.is_file() else {},
    }
    return results.replace(**finished_fits(results, settings)), settings, provenance


def _settings(fit: FitAlone, campaign: str) -> Settings:
    """Settings of a campaign that has this table alone."""
    return Settings.of(
        {
            **resolve(CONFIG, {"campaign": "etm-slim"}).plain(),
            "campaign": {
                "name": campaign,
                "data": "measured",
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
