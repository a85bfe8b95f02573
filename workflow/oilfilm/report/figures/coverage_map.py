"""The coverage map: which conditions were accepted, refused or have no run that could be read."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from oilfilm import tables
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_OILS_ABREAST = 3
_CELL_HEIGHT_IN = 0.24
_SYMBOL_IN = 0.2  # of a cell's width, and ...
_LETTER_IN = 0.055  # ... for each letter of 6 pt after the symbol
_LABELS_IN = 0.6  # left of the panels
_MARGIN_IN = 0.35  # of a panel, for its title and its ticks
_LONGEST_IN = 9.0  # a page
_LEGEND_TITLE = ("Conditions by state (P pressure, W load);", "in a cell: accepted/all runs")

_SPEED = "nominal_entrainment_speed_m_s"
_TEMPERATURE = "nominal_inlet_temperature_c"
_PRESSURE = "nominal_max_hertz_pressure_gpa"
_LOAD = "nominal_load_n"
_CELL = ["oil", _TEMPERATURE, _SPEED, _PRESSURE, _LOAD]


@register(
    name="coverage",
    title="Coverage of the test matrix",
    caption="Conditions of the test matrix, one column of panels per oil and one row per "
    "inlet temperature. Abscissa: entrainment speed U (m/s). Ordinate: maximum Hertz pressure P "
    "(GPa) or load W (N). Numbers: accepted runs of all runs. Missing: no run of the condition "
    "could be read.",
    category="Data quality",
    family="data",
    tables=("coverage",),
    settings=("oils",),
)
def coverage_map(results: CampaignTables, settings: Settings) -> Drawing:
    """One column of panels per oil, one row per temperature; cells of pressure and speed."""
    cells = _cells(results.coverage)
    oils = [oil for oil in settings.oils if (cells["oil"] == oil).any()]
    if reason := _why_no_map(cells, oils):
        return _counts_in_words(reason, cells), []
    blocks = [oils[start : start + _OILS_ABREAST] for start in range(0, len(oils), _OILS_ABREAST)]
    grid = [
        (block, temperature)
        for block in blocks
        for temperature in sorted(cells.loc[cells["oil"].isin(block), "temperature"].unique())
    ]
    speeds, forces = cells["x"].nunique(), cells["y"].nunique()
    abreast = min(len(oils), _OILS_ABREAST)
    cell_in = _SYMBOL_IN + _LETTER_IN * cells["label"].str.len().max()
    narrow = abreast * speeds * cell_in + _LABELS_IN <= style.SINGLE_COLUMN_IN
    width_in = style.SINGLE_COLUMN_IN if narrow else style.DOUBLE_COLUMN_IN
    height_in = len(grid) * (forces * _CELL_HEIGHT_IN + _MARGIN_IN) + (0.87 if narrow else 0.75)
    figure, axes = style.panels(len(grid), abreast, width_in, height_in)
    fitting = int((width_in - _LABELS_IN) / abreast / cell_in)
    drawn = []
    for number, axis in enumerate(axes):
        block, temperature = grid[number // abreast]
        column = number % abreast
        oil = block[column] if column < len(block) else ""
        of_panel = cells[(cells["oil"] == oil) & (cells["temperature"] == temperature)]
        if of_panel.empty:
            axis.set_visible(False)
            continue
        title = _title(oil, of_panel[_TEMPERATURE].iloc[0])
        axis.set_title(title, fontsize=7, pad=3, parse_math=False)
        _draw(axis, of_panel, bool(cells["planned"].any()), cell_in if speeds <= fitting else 0)
        # cells keep their size where there are few
        axis.set_xlim(-0.6, max(speeds, fitting) - 0.4)
        axis.set_ylim(-0.6, forces - 0.4)
        axis.set_label(str(number + 1))
        x, y = of_panel[_SPEED], of_panel[_PRESSURE].fillna(of_panel[_LOAD])
        shown = {"oil": oil, "label": of_panel["label"]}
        drawn.append(marks(str(number + 1), of_panel["state"], x, y, **shown))
    _label(axes, abreast, cells)
    _draw_legend(figure, cells, narrow)
    return figure, drawn


def _cells(coverage: pd.DataFrame) -> pd.DataFrame:
    """Cells of the map: conditions of all rigs together, with their positions and label.

    `x`, `y` and `temperature` number the levels in rising order; those not stated come last.
    """
    runs = coverage["runs_accepted"] + coverage["runs_refused"]
    conditions = coverage.assign(runs=runs).groupby(_CELL, dropna=False, as_index=False)
    cells = conditions.agg({"runs_accepted": "sum", "runs": "sum", "planned": "any"})
    accepted, total = cells["runs_accepted"].astype(str), cells["runs"].astype(str)
    return cells.assign(
        state=np.select(
            [cells["runs_accepted"] > 0, cells["runs"] > 0], ["accepted", "refused"], "missing"
        ),
        x=cells.groupby(_SPEED, dropna=False).ngroup(),
        y=cells.groupby([_PRESSURE, _LOAD], dropna=False).ngroup(),
        temperature=cells.groupby(_TEMPERATURE, dropna=False).ngroup(),
        label=(accepted + "/" + total).where(cells["runs"] > 0, ""),
    )


def _why_no_map(cells: pd.DataFrame, oils: Sequence[str]) -> str:
    """What to say instead of a map, where there is none to draw; else empty."""
    if cells.empty:
        return "No run was read, and the campaign has no matrix:\nthere is nothing to cover."
    if cells[_CELL[1:]].isna().all(axis=None):
        return (
            "No set points are stated, so that no map can be drawn.\n"
            "Write them into the header of each log, or under\n`set_points` of the campaign file."
        )
    temperatures = cells.loc[cells["oil"].isin(oils), "temperature"].nunique()
    height_in = cells["y"].nunique() * temperatures * _CELL_HEIGHT_IN
    if height_in > 2 * _LONGEST_IN or cells["x"].nunique() > 40:
        return (
            f"{len(cells)} different conditions are more than a map can show.\n"
            "The table coverage has them all."
        )
    return ""


def _counts_in_words(reason: str, cells: pd.DataFrame) -> Figure:
    per_oil = cells.groupby("oil")[["runs_accepted", "runs"]].sum()
    counts = [
        f"{style.plain(str(oil))}: {row['runs_accepted']} of {row['runs']} runs accepted"
        for oil, row in per_oil.iterrows()
    ]
    return style.sentences("\n".join([reason, "", *counts]))


def _title(oil: str, temperature: float) -> str:
    known = not np.isnan(temperature)
    level = style.level_phrases({"inlet_temperature_c": temperature}) if known else "T not stated"
    return f"{style.plain(oil)}, {level}"


def _draw(axis: Axes, cells: pd.DataFrame, has_matrix: bool, cell_in: float) -> None:
    """Cells of one panel: a tinted field, the state's symbol, accepted of all runs.

    The numbers are left out where `cell_in`, the cells' least width, is 0.
    """
    for cell in tables.rows(cells.sort_values(["x", "y"])):
        x, y, state = cell["x"], cell["y"], cell["state"]
        colour = style.STATE_COLOURS[state]
        outside = has_matrix and not cell["planned"]
        axis.add_patch(
            Rectangle(
                (x - 0.46, y - 0.42),
                0.92,
                0.84,
                facecolor="white" if state == "missing" else style.tint(colour, 0.22),
                edgecolor=colour,
                linewidth=0.7,
                linestyle=style.LINES["not planned"] if outside else "-",
            )
        )
        with_number = cell_in > 0 and cell["label"] != ""
        axis.plot(
            x - 0.46 + 0.5 * _SYMBOL_IN / cell_in if with_number else x,
            y,
            markersize=3.6,
            markeredgewidth=0.6,
            **_symbol(state),
        )
        if with_number:
            middle = x + 0.4 * _SYMBOL_IN / cell_in
            axis.text(middle, y, cell["label"], ha="center", va="center_baseline", fontsize=6)
    axis.grid(False)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def _symbol(state: str) -> dict[str, Any]:
    """Marker and colour of a state; open where there is no run."""
    colour = style.STATE_COLOURS[state]
    return {
        "linestyle": "",
        "marker": style.STATE_MARKERS[state],
        "color": colour,
        "markerfacecolor": "white" if state == "missing" else colour,
    }


def _label(axes: Sequence[Axes], abreast: int, cells: pd.DataFrame) -> None:
    """Ticks are levels, evenly spaced; the unit stands at the axis, or at the tick where mixed."""
    names = {_PRESSURE: "P (GPa)", _LOAD: "W (N)"}
    known = [name for name in names if cells[name].notna().any()]
    mixed = len(known) > 1
    forces = cells.drop_duplicates("y").sort_values("y")
    labels = [
        _level(load, " N" if mixed else "")
        if np.isnan(pressure)
        else _level(pressure, " GPa" if mixed else "")
        for pressure, load in zip(forces[_PRESSURE], forces[_LOAD], strict=True)
    ]
    speeds = cells.drop_duplicates("x").sort_values("x")[_SPEED]
    axes[0].set_yticks(range(len(labels)), labels)
    axes[0].set_xticks(range(len(speeds)), [_level(speed, "") for speed in speeds])
    for column in range(abreast):
        # below the last panel of each column, which need not be in the last row
        *_, lowest = (axis for axis in axes[column::abreast] if axis.get_visible())
        lowest.tick_params(labelbottom=True)
        lowest.set_xlabel("U (m/s)", fontsize=7, loc="left")
    force = names[known[0]] if len(known) == 1 else "P or W"
    for start in range(0, len(axes), abreast):
        leftmost = next(axis for axis in axes[start : start + abreast] if axis.get_visible())
        leftmost.tick_params(labelleft=True)
        leftmost.set_ylabel(force, fontsize=7)


def _level(value: float, unit: str) -> str:
    return "not stated" if np.isnan(value) else f"{value:.4g}{unit}"


def _draw_legend(figure: Figure, cells: pd.DataFrame, narrow: bool) -> None:
    """What the symbols mean, below the panels, where it covers no data."""
    counts = cells["state"].value_counts()
    handles: list[Any] = [
        style.line_handle(f"{state} ({counts.get(state, 0)})", markersize=4, **_symbol(state))
        for state in style.STATE_COLOURS
    ]
    if cells["planned"].any() and not cells["planned"].all():
        edge: dict[str, Any] = {
            "facecolor": "white",
            "edgecolor": style.GREY,
            "linestyle": style.LINES["not planned"],
        }
        outside = (~cells["planned"]).sum()
        handles.append(Rectangle((0, 0), 1, 1, label=f"not in the matrix ({outside})", **edge))
    figure.legend(
        handles=handles,
        loc="outside lower left",
        ncols=2 if narrow else 4,
        title=("\n" if narrow else " ").join(_LEGEND_TITLE),
        title_fontsize=7,
        alignment="left",
        handletextpad=0.3,
        columnspacing=1.2,
    )
