"""The coverage map: which conditions were accepted, refused or never measured."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use

_OILS_ABREAST = 3
_CELL_HEIGHT_IN = 0.24
_SYMBOL_IN = 0.2  # of a cell's width, and ...
_LETTER_IN = 0.055  # ... for each letter of 6 pt after the symbol
_LABELS_IN = 0.6  # left of the panels
_MARGIN_IN = 0.35  # of a panel, for its title and its ticks
_LONGEST_IN = 9.0  # a page
_NOT_STATED = "not stated"

_SPEED = "nominal_entrainment_speed_m_s"
_TEMPERATURE = "nominal_inlet_temperature_c"
_PRESSURE = "nominal_max_hertz_pressure_gpa"
_LOAD = "nominal_load_n"
_CELL = ["oil", _TEMPERATURE, _SPEED, _PRESSURE, _LOAD]


_COVERAGE_MAP = drawn_table(
    "coverage_map",
    "Drawn in the coverage map: one row per cell, all rigs together.",
    columns="""
        panel oil nominal_inlet_temperature_c nominal_entrainment_speed_m_s
        nominal_max_hertz_pressure_gpa nominal_load_n runs_accepted runs state planned""",
    uses=(
        use("nominal_inlet_temperature_c", "of the panel"),
        use("nominal_entrainment_speed_m_s", "abscissa"),
        use("nominal_max_hertz_pressure_gpa", "ordinate"),
        use("nominal_load_n", "ordinate without pressure"),
        use("runs_accepted", "first number of the cell"),
        use("runs", "second number of the cell: all runs"),
        use("state", "symbol and colour of the cell"),
        use("planned", "false: drawn with a broken edge, if there is a matrix"),
    ),
)


@register(
    name="coverage",
    title="Coverage of the test matrix",
    caption="Accepted, refused and missing conditions, one column per oil and one row per "
    "temperature, against entrainment speed (m/s) and maximum Hertz pressure (GPa) or load (N). "
    "Numbers: accepted runs of all runs.",
    category="Data quality",
    family="data",
    tables=("coverage",),
    settings=("oils",),
    draws=_COVERAGE_MAP,
)
def coverage_map(results: CampaignTables, settings: Settings) -> Drawing:
    """One column of panels per oil, one row per temperature; cells of pressure and speed."""
    cells = _cells(results.coverage)
    oils = [oil for oil in settings.oils if (cells["oil"] == oil).any()]
    words = _why_no_map(cells, oils)
    if words:
        return _in_words(words, cells), []
    blocks = [oils[at : at + _OILS_ABREAST] for at in range(0, len(oils), _OILS_ABREAST)]
    grid = [(block, level) for block in blocks for level in _temperatures(cells, block)]
    speeds, forces = _levels(cells, [_SPEED]), _levels(cells, [_PRESSURE, _LOAD])
    abreast = min(len(oils), _OILS_ABREAST)
    cell_in = _SYMBOL_IN + _LETTER_IN * max(map(len, _numbers(cells)))
    narrow = abreast * len(speeds) * cell_in + _LABELS_IN <= style.SINGLE_COLUMN_IN
    width_in = style.SINGLE_COLUMN_IN if narrow else style.DOUBLE_COLUMN_IN
    height_in = len(grid) * (len(forces) * _CELL_HEIGHT_IN + _MARGIN_IN) + 0.75
    figure, axes = style.panels(len(grid), abreast, width_in, height_in)
    fitting = int((width_in - _LABELS_IN) / abreast / cell_in)
    has_matrix = bool(cells["planned"].any())
    drawn = []
    for row, (block, temperature) in enumerate(grid):
        for place in range(abreast):
            axis = axes[row * abreast + place]
            oil = block[place] if place < len(block) else ""
            here = cells[(cells["oil"] == oil) & _is_level(cells, [_TEMPERATURE], [temperature])]
            if here.empty:
                axis.set_visible(False)
                continue
            axis.set_title(_title(oil, temperature), fontsize=7, pad=3, parse_math=False)
            _draw(axis, here, speeds, forces, has_matrix, cell_in if len(speeds) <= fitting else 0)
            # cells keep their size where there are few
            axis.set_xlim(-0.6, max(len(speeds), fitting) - 0.4)
            axis.set_ylim(-0.6, len(forces) - 0.4)
            drawn.append(here.assign(panel=str(row * abreast + place + 1)))
    _label(axes, abreast, speeds, forces)
    _say_key(figure, cells, columns=2 if width_in == style.SINGLE_COLUMN_IN else 4)
    return figure, drawn


def _cells(coverage: pd.DataFrame) -> pd.DataFrame:
    """Cells of the map: conditions of all rigs together."""
    runs = coverage["runs_accepted"] + coverage["runs_refused"]
    cells = coverage.assign(runs=runs).groupby(_CELL, dropna=False, as_index=False)
    whole = cells.agg({"runs_accepted": "sum", "runs": "sum", "planned": "any"})
    states = np.select(
        [whole["runs_accepted"] > 0, whole["runs"] > 0], ["accepted", "refused"], "missing"
    )
    return whole.assign(state=states)


def _why_no_map(cells: pd.DataFrame, oils: Sequence[str]) -> str:
    """What to say instead of a map, where there is none to draw; else empty."""
    if cells.empty:
        return "No run was read, and the campaign has no matrix: there is nothing to cover."
    if cells[_CELL[1:]].isna().all(axis=None):
        return (
            "No set points are stated, so that no map can be drawn.\n"
            "They belong into the head of each log, or under\n`set_points` of the campaign file."
        )
    rows = len(_levels(cells, [_PRESSURE, _LOAD])) * len(_temperatures(cells, oils))
    if rows * _CELL_HEIGHT_IN > 2 * _LONGEST_IN or len(_levels(cells, [_SPEED])) > 40:
        return (
            f"{len(cells)} different conditions are more than a map can show.\n"
            "The table coverage has them all."
        )
    return ""


def _in_words(words: str, cells: pd.DataFrame) -> Figure:
    per_oil = cells.groupby("oil")[["runs_accepted", "runs"]].sum()
    counts = [
        f"{style.plain(str(oil))}: {row['runs_accepted']} of {row['runs']} runs accepted"
        for oil, row in per_oil.iterrows()
    ]
    return style.sentences("\n".join([words, "", *counts]))


def _numbers(cells: pd.DataFrame) -> list[str]:
    """What stands in each cell: accepted of all runs."""
    return [
        f"{accepted}/{runs}" if runs else ""
        for accepted, runs in zip(cells["runs_accepted"], cells["runs"], strict=True)
    ]


def _levels(cells: pd.DataFrame, names: Sequence[str]) -> list[tuple[float, ...]]:
    """Levels of one or two set points in rising order, those not stated last."""
    found = cells[list(names)].drop_duplicates().sort_values(list(names))
    return list(found.itertuples(index=False, name=None))


def _temperatures(cells: pd.DataFrame, oils: Sequence[str]) -> list[float]:
    return [level[0] for level in _levels(cells[cells["oil"].isin(oils)], [_TEMPERATURE])]


def _is_level(
    cells: pd.DataFrame, names: Sequence[str], level: Sequence[float]
) -> "pd.Series[bool]":
    same = [
        cells[name].isna() if np.isnan(value) else cells[name] == value
        for name, value in zip(names, level, strict=True)
    ]
    return pd.concat(same, axis="columns").all(axis="columns")


def _title(oil: str, temperature: float) -> str:
    stated = (
        f"T = {temperature:g} \N{DEGREE SIGN}C" if not np.isnan(temperature) else "T not stated"
    )
    return f"{style.plain(oil)}, {stated}"


def _draw(
    axis: Axes,
    cells: pd.DataFrame,
    speeds: Sequence[tuple[float, ...]],
    forces: Sequence[tuple[float, ...]],
    has_matrix: bool,
    cell_in: float,
) -> None:
    """Cells of one panel: a tinted field, the state's symbol, accepted of all runs.

    The numbers are left out where `cell_in`, the cells' least width, is 0.
    """
    for x, y, cell in _places(cells.assign(words=_numbers(cells)), speeds, forces):
        state = cell["state"]
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
        with_number = cell_in > 0 and cell["words"] != ""
        axis.plot(
            x - 0.46 + 0.5 * _SYMBOL_IN / cell_in if with_number else x,
            y,
            style.STATE_MARKERS[state],
            color=colour,
            markersize=3.6,
            markerfacecolor="white" if state == "missing" else colour,
            markeredgewidth=0.6,
        )
        if with_number:
            middle = x + 0.4 * _SYMBOL_IN / cell_in
            axis.text(middle, y, cell["words"], ha="center", va="center_baseline", fontsize=6)
    axis.grid(False)
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def _places(
    cells: pd.DataFrame, speeds: Sequence[tuple[float, ...]], forces: Sequence[tuple[float, ...]]
) -> Iterator[tuple[int, int, dict[str, Any]]]:
    for x, speed in enumerate(speeds):
        for y, force in enumerate(forces):
            here = _is_level(cells, [_SPEED, _PRESSURE, _LOAD], (*speed, *force))
            for cell in cells[here].to_dict("records"):
                yield x, y, {str(name): value for name, value in cell.items()}


def _label(
    axes: Sequence[Axes],
    abreast: int,
    speeds: Sequence[tuple[float, ...]],
    forces: Sequence[tuple[float, ...]],
) -> None:
    """Ticks are levels, evenly spaced; the unit stands at the axis, or at the tick where mixed."""
    stated = {
        name
        for force in forces
        for name, value in zip(("pressure", "load"), force, strict=True)
        if not np.isnan(value)
    }
    mixed = len(stated) > 1
    words = []
    for pressure, load in forces:
        unit = "" if not mixed else (" GPa" if not np.isnan(pressure) else " N")
        value = load if np.isnan(pressure) else pressure
        words.append(_NOT_STATED if np.isnan(value) else f"{value:.4g}{unit}")
    names = {"pressure": "P (GPa)", "load": "W (N)"}
    axes[0].set_yticks(range(len(forces)), words)
    axes[0].set_xticks(
        range(len(speeds)), [_NOT_STATED if np.isnan(u) else f"{u:.4g}" for (u,) in speeds]
    )
    for place in range(abreast):
        # below the last panel of each column, which need not be in the last row
        column = [axis for axis in axes[place::abreast] if axis.get_visible()]
        column[-1].tick_params(labelbottom=True)
        column[-1].set_xlabel("Entrainment speed U (m/s)", fontsize=7, loc="left")
    for start in range(0, len(axes), abreast):
        row = [axis for axis in axes[start : start + abreast] if axis.get_visible()]
        row[0].tick_params(labelleft=True)
        row[0].set_ylabel(names.get("".join(stated), "P or W"), fontsize=7)


def _say_key(figure: Figure, cells: pd.DataFrame, columns: int) -> None:
    """What the symbols mean, below the panels, where it covers no data."""
    handles: list[Any] = [
        Line2D(
            [],
            [],
            linestyle="",
            marker=style.STATE_MARKERS[state],
            markersize=4,
            color=colour,
            markerfacecolor="white" if state == "missing" else colour,
            label=f"{state} ({(cells['state'] == state).sum()})",
        )
        for state, colour in style.STATE_COLOURS.items()
    ]
    if cells["planned"].any() and not cells["planned"].all():
        outside = (~cells["planned"]).sum()
        edge: dict[str, Any] = {
            "facecolor": "white",
            "edgecolor": style.GREY,
            "linestyle": style.LINES["not planned"],
        }
        handles.append(Rectangle((0, 0), 1, 1, label=f"not in the matrix ({outside})", **edge))
    figure.legend(
        handles=handles,
        loc="outside lower left",
        ncols=columns,
        title="Conditions by state (P pressure, W load); in a cell: accepted/all runs",
        title_fontsize=7,
        alignment="left",
        handletextpad=0.3,
        columnspacing=1.2,
    )
