"""Figures of the bearing: cage slip and size effect."""

import itertools
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_LOOKS: dict[str, tuple[str, dict[str, Any]]] = {
    "load": ("load W", {"linestyle": style.LINES["load"], "marker": "s"}),
    "dimensionless_load": (
        "load W/(E'R\N{SUPERSCRIPT TWO})",
        {"linestyle": style.LINES["dimensionless load"], "marker": "^"},
    ),
}
_SLIP_LEVELS = (-1.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0)


@register(
    name="cage-slip",
    title="Cage slip",
    caption="Cage slip at friction equilibrium, one panel per oil. Abscissa: dmN, pitch "
    "diameter times speed (million mm rpm), and entrainment speed U of rolling balls. Ordinate: "
    "axial load (kN). Full line: limit of the cage slip. Dashed lines: the 2.5 % and 97.5 % "
    "quantiles of the slip reach the limit. Hatched: the limit lies between the quantiles. "
    "Crosses: the cage may roll or skid.",
    category="Bearing",
    family="bearing",
    tables=("cage_slip",),
    settings=("oils", "bearing", "selection"),
    requires="torque",
)
def cage_slip(results: CampaignTables, settings: Settings) -> Drawing:
    """Cage slip against speed and axial load, one panel per oil."""
    table = results.cage_slip
    oils = [oil for oil in settings.oils if (table["oil"] == oil).any()]
    if not oils:
        return style.sentences("No oil has a law that a bearing could use."), []
    limit = settings.selection.limits.slip_limit
    columns = min(len(oils), 3)
    rows = -(-len(oils) // columns)
    width = style.DOUBLE_COLUMN_IN if columns > 1 else style.SINGLE_COLUMN_IN
    figure, axes = style.panels(rows, columns, width, 2.2 * rows + 0.3)
    axes[0].set_yscale("log")
    axes[0].yaxis.set_major_formatter("{x:g}")
    drawn = []
    for number, oil in enumerate(oils):
        of_oil = table[table["oil"] == oil]
        filled = _draw_slip(axes[number], of_oil, limit)
        panel = style.title_panel(axes[number], number, oil)
        at = of_oil.assign(**in_units_of_axes(of_oil))
        series = np.where(at["bistable"], "bistable", "cell")
        ends = {"lower": at["cage_slip_lower"], "upper": at["cage_slip_upper"]}
        slip = at["cage_slip"]
        drawn.append(marks(panel, series, at["speed"], at["load"], oil=oil, value=slip, **ends))
    for axis in axes[len(oils) :]:
        axis.set_axis_off()
    bar = figure.colorbar(filled, ax=axes, label="Cage slip", ticks=_SLIP_LEVELS[1:])
    bar.ax.set_yticklabels([f"{level:g}" for level in _SLIP_LEVELS[1:]])
    for axis in axes[max(len(oils) - columns, 0) : len(oils)]:
        axis.tick_params(labelbottom=True)
    speed = f"dmN (million mm rpm; 1 is U = {entrainment_speed_m_s(1e6):.0f} m/s)"
    figure.supxlabel(speed, fontsize=8)
    figure.supylabel("Axial load (kN)", fontsize=8)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    style.say_key(
        figure,
        f"Friction equilibrium, {table['bearing'].iloc[0]}, {temperature:g} \N{DEGREE SIGN}C; "
        f"line: slip of {limit:g};\ndashed: its 95 % interval; hatched: within or above it is "
        "not certain; crosses: rolls or skids.",
    )
    return figure, drawn


def in_units_of_axes(rows: pd.DataFrame) -> dict[str, "pd.Series[float]"]:
    """Speed in million mm rpm and load in kN."""
    return {"speed": rows["pitch_speed_mm_rpm"] / 1e6, "load": rows["axial_load_n"] / 1e3}


def _draw_slip(axis: Axes, of_oil: pd.DataFrame, limit: float) -> QuadMesh:
    in_units = of_oil.assign(**in_units_of_axes(of_oil))
    grid = in_units.pivot(index="load", columns="speed", values="cage_slip")
    speed, load = grid.columns.to_numpy(), grid.index.to_numpy()
    slip = np.ma.masked_invalid(grid.to_numpy())
    norm = BoundaryNorm(_SLIP_LEVELS, 256)
    edges = style.cell_edges(speed, axis.get_xscale()), style.cell_edges(load, axis.get_yscale())
    filled = axis.pcolormesh(*edges, slip, cmap="cividis_r", norm=norm)
    axis.contour(speed, load, slip, [limit], colors="black", linewidths=1.1)
    lower, upper = (
        np.ma.masked_invalid(in_units.pivot(index="load", columns="speed", values=name).to_numpy())
        for name in ("cage_slip_lower", "cage_slip_upper")
    )
    for end in (lower, upper):
        if end.count():
            axis.contour(speed, load, end, [limit], colors="black", linewidths=0.8, linestyles="--")
    across, along = edges
    between = np.ma.filled((lower < limit) & (upper > limit), False)
    # with an interval elsewhere, a cell without one is the least certain
    uncertain = between | (lower.mask & ~slip.mask if lower.count() else False)
    for row, column in np.argwhere(uncertain):
        corner, size = (
            (across[column], along[row]),
            (across[column + 1] - across[column], along[row + 1] - along[row]),
        )
        axis.add_patch(Rectangle(corner, *size, fill=False, hatch="////", linewidth=0))
    both = in_units[in_units["bistable"]]
    axis.plot(both["speed"], both["load"], "x", color="black", markersize=5)
    axis.grid(False)
    return filled


@register(
    name="size-effect",
    title="Size effect of laws of load",
    caption="Traction torque by the load-based laws, relative to the pressure-based law (%). "
    "Left: against ball diameter (mm), with all lengths in proportion and equal pressure and "
    "surface speed. Right: against conformity, with equal load and speed.",
    category="Bearing",
    family="bearing",
    tables=("size_effect",),
    settings=("oils",),
    requires="torque",
)
def size_effect(results: CampaignTables, settings: Settings) -> Drawing:
    """Traction torque of laws of load relative to the law of pressure, by size and conformity."""
    of_load = results.size_effect["load_variable"].isin(_LOOKS)
    table = results.size_effect[of_load].reset_index(drop=True)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.7))
    axes = figure.subplots(1, 2, sharey=True)
    curvature = "Groove radius over ball diameter"
    panels = (
        ("ball size", "ball_diameter_mm", "Ball diameter (mm)", "pressure and surface speed"),
        ("conformity", "groove_curvature", curvature, "load and speed"),
    )
    drawn = []
    for number, (varied, column, label, held) in enumerate(panels):
        axis = axes[number]
        panel = style.title_panel(axis, number, f"{varied} at the same {held}")
        rows = table[table["varied"] == varied]
        for oil, variable in itertools.product(settings.oils, _LOOKS):
            series = rows[(rows["oil"] == oil) & (rows["load_variable"] == variable)]
            line = marks(
                panel, variable, series[column], 100 * series["relative_to_stress"], oil=oil
            )
            colour = style.oil_colour(oil, list(settings.oils))
            name = oil if variable == "load" else None
            axis.plot(line["x"], line["y"], color=colour, label=name, **_LOOKS[variable][1])
            drawn.append(line)
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set_xlabel(label)
    axes[0].set_ylabel("Traction torque above that\nof the pressure-based law (%)")
    if table.empty:
        style.say_in_panel(axes[0], "No oil has a law that a bearing could use.")
    else:
        axes[0].legend(loc="upper left")
        grey: dict[str, Any] = {"color": style.GREY, "linewidth": 0.9}
        handles = [style.line_handle(name, **grey, **look) for name, look in _LOOKS.values()]
        axes[1].legend(handles=handles, loc="upper right", title="law based on", title_fontsize=7)
    return figure, drawn
