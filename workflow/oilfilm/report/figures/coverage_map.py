"""The coverage map: which conditions were accepted, refused or have no run that could be read."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from oilfilm import tables
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import NothingToDrawError, Sheet, oil_grid
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_CELL_IN = 0.2  # height
_LONGEST_IN = 9.0  # a page
_STATES = list(style.STATE_COLOURS)
_SPEED = "nominal_entrainment_speed_m_s"
_TEMPERATURE = "nominal_inlet_temperature_c"
_PRESSURE = "nominal_max_hertz_pressure_gpa"
_LOAD = "nominal_load_n"
_NOT_PLANNED: style.Look = {
    "fill": False,
    "edgecolor": style.GREY,
    "linestyle": style.LINES["not planned"],
}
_CELL = ["oil", _TEMPERATURE, _SPEED, _PRESSURE, _LOAD]


@register(family="data", tables=("coverage",), settings=("oils",))
def coverage(results: CampaignTables, settings: Settings) -> Sheet:
    """Coverage of the test matrix.

    Conditions of the test matrix, one column of panels per oil and one row per inlet
    temperature. Abscissa: entrainment speed U (m/s). Ordinate: maximum Hertz pressure P (GPa)
    or load W (N). Numbers: accepted runs of all runs, where there is not one accepted run.
    Missing: no run of the condition could be read. Dashed: not in the matrix.
    """
    cells = _cells(results.coverage)
    if reason := _why_no_map(cells):
        per_oil = cells.groupby("oil")[["runs_accepted", "runs"]].sum()
        lines = [
            f"{oil}: {good} of {runs} runs accepted" for oil, good, runs in per_oil.itertuples()
        ]
        raise NothingToDrawError("\n".join([reason, "", *map(style.plain, lines)]))
    temperatures = cells.drop_duplicates("temperature").sort_values("temperature")[_TEMPERATURE]
    has_matrix = bool(cells["planned"].any())

    def title(row: tuple[int, float], oil: str) -> str:
        phrase = style.level_phrases({"inlet_temperature_c": row[1]})
        return f"{oil}, {'T not stated' if np.isnan(row[1]) else phrase}"

    layout: style.Look = {"height": _CELL_IN * cells["y"].nunique(), "left": 0.75, "down": 0.22}
    layout |= {"sharex": True, "sharey": True}
    sheet, panels = oil_grid(
        style.oils_in(cells, settings),
        rows=list(enumerate(temperatures)),
        title=title,
        **layout,
    )
    for panel, (row, _), oil in panels:
        panel.axis.set_title(panel.axis.get_title(loc="left"), fontsize=7, pad=3)
        of_panel = cells[(cells["oil"] == oil) & (cells["temperature"] == row)]
        _draw(panel.axis, of_panel, has_matrix)
        x, y = of_panel[_SPEED], of_panel[_PRESSURE].fillna(of_panel[_LOAD])
        panel.keep(of_panel["state"], x, y, oil=oil, label=of_panel["label"])
    # ticks are levels, evenly spaced: of a pressure or, where none is stated, of a load
    forces = cells.drop_duplicates("y").sort_values("y")
    speeds = cells.drop_duplicates("x").sort_values("x")[_SPEED]
    in_gpa, in_n = _levels(forces[_PRESSURE], " GPa"), _levels(forces[_LOAD], " N")
    axis = sheet.axes[0]
    axis.set_yticks(range(len(forces)), in_gpa.fillna(in_n).fillna("not stated"))
    axis.set_xticks(range(len(speeds)), _levels(speeds, "").fillna("not stated"))
    axis.set(xlim=(-0.5, len(speeds) - 0.5), ylim=(-0.5, len(forces) - 0.5))
    sheet.label("U (m/s)", "P or W", fontsize=7)
    counts = cells["state"].value_counts()
    handles: list[Any] = [
        style.symbol_handle(f"{state} ({counts.get(state, 0)})", **_symbol(state), markersize=4)
        for state in _STATES
    ]
    if has_matrix and not cells["planned"].all():
        outside = f"not in the matrix ({(~cells['planned']).sum()})"
        handles.append(Rectangle((0, 0), 1, 1, label=outside, **_NOT_PLANNED))
    sheet.legend(handles, "Conditions by state; in a cell: accepted/all runs")
    return sheet


def _cells(coverage: pd.DataFrame) -> pd.DataFrame:
    """Cells of the map: conditions of all rigs together, with their positions and label.

    `x`, `y` and `temperature` number the levels in rising order; those not stated come last.
    """
    runs = coverage["runs_accepted"] + coverage["runs_refused"]
    conditions = coverage.assign(runs=runs).groupby(_CELL, dropna=False, as_index=False)
    cells = conditions.agg({"runs_accepted": "sum", "runs": "sum", "planned": "any"})
    accepted, total = cells["runs_accepted"].astype(str), cells["runs"].astype(str)
    is_accepted, any_run = cells["runs_accepted"] > 0, cells["runs"] > 0
    return cells.assign(
        state=np.select([is_accepted, any_run], ["accepted", "refused"], "missing"),
        x=cells.groupby(_SPEED, dropna=False).ngroup(),
        y=cells.groupby([_PRESSURE, _LOAD], dropna=False).ngroup(),
        temperature=cells.groupby(_TEMPERATURE, dropna=False).ngroup(),
        label=(accepted + "/" + total).where(any_run, ""),
    )


def _why_no_map(cells: pd.DataFrame) -> str:
    """What to say instead of a map, where there is none to draw; else empty."""
    if cells.empty:
        return "No run was read, and the campaign has no matrix:\nthere is nothing to cover."
    if cells[_CELL[1:]].isna().all(axis=None):
        return (
            "No set points are stated, so that no map can be drawn.\n"
            "Write them into the header of each log, or under\n`set_points` of the campaign file."
        )
    height_in = cells["y"].nunique() * cells["temperature"].nunique() * _CELL_IN
    if height_in > 2 * _LONGEST_IN or cells["x"].nunique() > 40:
        return (
            f"{len(cells)} different conditions are more than a map can show.\n"
            "The table coverage has them all."
        )
    return ""


def _draw(axis: Axes, cells: pd.DataFrame, has_matrix: bool) -> None:
    """Cells of one panel: the state's symbol, accepted of all runs."""
    for state, of_state in cells.groupby("state"):
        x = of_state["x"] - 0.2 * (of_state["label"] != "1/1")
        axis.plot(x, of_state["y"], linestyle="", markersize=3.6, **_symbol(str(state)))
    look: style.Look = {"ha": "center", "va": "center_baseline", "fontsize": 6}
    for cell in tables.rows(cells):
        if cell["label"] != "1/1":
            axis.text(cell["x"] + 0.17, cell["y"], cell["label"], **look)
        if has_matrix and not cell["planned"]:
            corner = cell["x"] - 0.46, cell["y"] - 0.42
            axis.add_patch(Rectangle(corner, 0.92, 0.84, **_NOT_PLANNED))
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def _symbol(state: str) -> style.Look:
    """Marker and colour of a state; open where there is no run."""
    colour = style.STATE_COLOURS[state]
    face = "white" if state == "missing" else colour
    return {"marker": style.STATE_MARKERS[state], "color": colour, "markerfacecolor": face}


def _levels(values: "pd.Series[float]", unit: str) -> "pd.Series[str]":
    """Levels in words; null where none is stated."""
    return values.map(lambda level: f"{level:.4g}{unit}", na_action="ignore").astype("string")
