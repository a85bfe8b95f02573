"""A law fitted to a table of mu: in Python `oilfilm.fit_table`, on the command line `oilfilm fit`.

Decides: which law a table is fitted with, and what is saved of such a fit.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import oilfilm
from oilfilm import tables
from oilfilm.arrays import ArrayFit, fit_points
from oilfilm.atomic_write import atomic_folder, write_bytes, write_text
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError
from oilfilm.exports.campaign import export_campaign
from oilfilm.fits.finished import finished_fits
from oilfilm.home import CONFIG
from oilfilm.logs.base import SET_POINTS
from oilfilm.mu_table import LOAD, MU, PRESSURE, SPEED, TEMPERATURE, read_mu_table, with_pressure
from oilfilm.report.html import html
from oilfilm.report.sections.answer import answer
from oilfilm.report.sections.constants import constants
from oilfilm.report.sections.fits import fits
from oilfilm.report.sections.laws import laws
from oilfilm.report.text import text
from oilfilm.settings.resolve import resolve, safe_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.dictionary import TABLES
from oilfilm.traction import LAWS, PAPER_LAW

_PLACES = (("Report", "report.html"), ("Tables", "tables"), ("Exports", "exports"))
# Of laws of load and of pressure, the one that a table is fitted with unless another is named.
_OF_LOAD, _OF_PRESSURE = "wang-deng-load", PAPER_LAW.name

_OPTIONS = {PRESSURE: "--stress 1.2GPa", SPEED: "--speed 2m/s", LOAD: "--load 50N"}
_OPTIONS |= {TEMPERATURE: "--temperature 40degC"}


@dataclass(frozen=True, repr=False)
class TableFit(ArrayFit):
    """A law fitted to a table of mu.

    Attributes:
        source: The table.
        oil: Name of its oil.
    """

    source: str
    oil: str

    def save(self, folder: Path | str) -> None:
        """Write tables, exports and report, as a campaign has them in its results.

        Afterwards `oilfilm predict --results FOLDER --oil OIL` and `oilfilm.read_fit` use them.

        Raises:
            OilfilmError: The folder exists, or its name cannot be that of a campaign.
        """
        folder = Path(folder)
        if folder.exists():
            raise OilfilmError(f"{folder}: exists already. Name a new folder.")
        name = safe_name(folder.resolve().name, folder)
        settings = self._settings(name)
        results = CampaignTables.in_memory(
            **{table: frame.assign(oil=self.oil) for table, frame in self.tables.tables.items()},
            **self._data(name),
        )
        finished = {**self._data(name), **finished_fits(results, settings)}
        results = results.replace(**finished)
        source = Path(self.source)
        provenance = {
            "code": f"oilfilm {oilfilm.__version__}",
            "settings": None,
            "inputs": {source.name: file_digest(source)} if source.is_file() else {},
        }
        with atomic_folder(folder) as made:
            about = {"campaign": name, "data": "measured", **provenance}
            for table, frame in finished.items():
                tables.write(frame, table, made / f"tables/{table}.parquet", about)
            parts = (results.coefficients, results.fit_quality, results.soundness)
            exports = export_campaign(results.points, *parts, settings, provenance)
            for file, content in exports.items():
                write_bytes(content, made / "exports" / file)
            sections = [answer(results, settings), fits(results), constants(results)]
            sections = [each for each in (*sections, laws(results, settings)) if each]
            write_text(text(sections, settings.campaign, _PLACES), made / "summary.txt")
            page = html(sections, results, [], made, settings, provenance)
            write_text(page, made / "report.html")

    def _data(self, campaign: str) -> dict[str, pd.DataFrame]:
        """The tables `points` and `runs` of a campaign that has this table alone."""
        points = self.points.assign(
            oil=self.oil, accepted=True, n_samples=1, first_row=self.points.index + 1
        )
        means = points.groupby("run_id", sort=False)
        runs = pd.DataFrame({"accepted_points": means.size(), "plateaus": means.size()})
        for name in {*SET_POINTS} & {*points}:
            runs[f"nominal_{name}"] = means[name].mean()
        runs = runs.reset_index().assign(
            campaign=campaign, oil=self.oil, rig="unknown", verdict="accepted", file=self.source
        )
        return {"points": _filled(points, "points"), "runs": _filled(runs, "runs")}

    def _settings(self, campaign: str) -> Settings:
        """Settings of a campaign that has this table alone."""
        return Settings.of(
            {
                **resolve(CONFIG, {"campaign": "etm-slim"}).plain(),
                "campaign": {
                    "name": campaign,
                    "data": "measured",
                    "description": f"table of traction coefficients {Path(self.source).name}",
                    "rigs": ["unknown"],
                    "oils": [],
                    "oils_without_properties": [self.oil],
                    "figures": [],
                },
                "dataset": {},
                "rigs": {},
                "oils": {self.oil: None},
                "bearings": {},
                "fit": self.settings.model_dump(),
            }
        )


def _filled(frame: pd.DataFrame, table: str) -> pd.DataFrame:
    """A frame as a table of a campaign: what it does not know is missing, 0 or empty."""
    unknown: dict[str, Any] = {"number": 0.0, "integer": 0, "flag": False, "text": ""}
    lacking = [column for column in TABLES[table].columns if column.name not in frame]
    values = {
        column.name: np.nan if column.nullable else (*column.allowed, unknown[column.type])[0]
        for column in lacking
    }
    return tables.conform(frame.assign(**values), table, "the table")


def fit_table(
    table: Path | str | pd.DataFrame,
    *,
    ball_radius_m: float | None = None,
    materials: str = "steel,steel",
    law: str | None = None,
    oil: str | None = None,
    at: Mapping[str, float] | None = None,
    **settings: Any,
) -> TableFit:
    """Fit a traction law to a table of mu: csv, tsv, xlsx, Parquet or a data frame.

    Columns are found by name and unit, in the languages that logs may have: slide-roll ratio (as
    fraction or %), mean speed or speeds of ball and disc, mu, load or maximum Hertz pressure,
    temperature; and, where there are such columns, oil and curve.

    Args:
        table: The table. Units are in the names or in the row below them: `speed [mm/s]`.
        ball_radius_m: Radius of the ball on a flat disc, in m: load becomes pressure.
        materials: Of ball and disc: steel, silicon-nitride, glass, or 206GPa:0.3.
        law: Name of the law; if not given one of pressure, or of load where the pressure is not
            known.
        oil: Which oil, where the table has a column of oils with several; else its name.
        at: Conditions that hold for all rows, by their columns' names (`inlet_temperature_c`).
        settings: Keys of `fit` in config/config.yaml that differ, as `bootstrap=200`.

    Raises:
        OilfilmError: A column or a condition is missing or cannot be understood, or a number is
            impossible.
    """
    found = read_mu_table(table)
    points, notes = found.points.assign(**(at or {})), list(found.notes)
    points, oil = _of_oil(points, oil, found.name)
    if LOAD in points and PRESSURE not in points and ball_radius_m is not None:
        points = with_pressure(points, ball_radius_m, materials)
        notes.append(f"{PRESSURE} follows from load, ball radius and materials ({materials})")
    of_load = LOAD in points and PRESSURE not in points
    if law is None:
        law = _OF_LOAD if of_load else _OF_PRESSURE
        if of_load:
            notes.append(
                f"law of load, {law}, because the pressure is not known; with --ball-radius and "
                "--materials a law of pressure can be fitted"
            )
    conditions = LAWS[law].conditions if law in LAWS else (PRESSURE, SPEED, TEMPERATURE)
    _refuse_missing(points, conditions, found.name)
    curve = points.pop("curve") if "curve" in points else None
    fitted = fit_points(points, conditions, law, curve, **settings)
    parts = (fitted.points, fitted.tables, fitted.settings, (*notes, *fitted.notes))
    return TableFit(*parts, found.name, oil)


def _of_oil(points: pd.DataFrame, oil: str | None, name: str) -> tuple[pd.DataFrame, str]:
    """The points of one oil, and its name."""
    if "oil" not in points:
        return points, oil or "oil"
    oils = sorted(points["oil"].unique())
    if oil not in (None, *oils) or (oil is None and len(oils) > 1):
        asked = "has several oils" if oil is None else f"has no oil {oil!r}"
        raise OilfilmError(f"{name}: {asked}. Name one with --oil: {', '.join(oils)}.")
    chosen = oil or str(oils[0])
    return points[points["oil"] == chosen].drop(columns="oil"), chosen


def _refuse_missing(points: pd.DataFrame, conditions: tuple[str, ...], name: str) -> None:
    """Refuse a table without a condition that the law needs.

    Raises:
        OilfilmError: It lacks one.
    """
    for column in (*conditions, MU):
        if column not in points:
            radius = " Where it has the load, give --ball-radius and --materials."
            raise OilfilmError(
                f"{name}: no column is the {column.rpartition('_')[0].replace('_', ' ')}. Add it, "
                f"or give it for all rows, as {_OPTIONS.get(column, '')}."
                + (radius if column == PRESSURE else "")
            )
