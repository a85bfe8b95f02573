"""A law fitted to a table of mu: in Python `oilfilm.fit_table`, on the command line `oilfilm fit`.

Decides: which law a table is fitted with.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from oilfilm.arrays import ArrayFit, fit_points
from oilfilm.errors import OilfilmError
from oilfilm.mu_table import LOAD, MU, PRESSURE, SPEED, TEMPERATURE, read_mu_table, with_pressure
from oilfilm.traction import LAWS, PAPER_LAW

# Of laws of load and of pressure, the one that a table is fitted with unless another is named.
_OF_LOAD, _OF_PRESSURE = "wang-deng-load", PAPER_LAW.name

_OPTIONS = {PRESSURE: "--stress 1.2GPa", SPEED: "--speed 2m/s", LOAD: "--load 50N"}
_OPTIONS |= {TEMPERATURE: "--temperature 40degC"}


def fit_table(
    table: Path | str | pd.DataFrame,
    *,
    ball_radius_m: float | None = None,
    materials: str = "steel,steel",
    law: str | None = None,
    oil: str | None = None,
    at: Mapping[str, float] | None = None,
    **settings: Any,
) -> ArrayFit:
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
    notes += fitted.notes
    return replace(fitted, notes=tuple(notes), source=found.name, oil=oil)


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
