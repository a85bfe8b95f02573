"""Figures of the bearing: torque by each law, cage slip, size effect, published power loss."""

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from oilfilm.bearing.friction import HEATS
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.advice_map import advice_handles, cell_edges, draw_advice
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use
from oilfilm.units import RAD_S_PER_RPM

_SE_DRAWN = 1.96  # error bars are 95 % intervals
_LOAD_VARIABLES: dict[str, tuple[str, Any, str]] = {
    "stress": ("stress", style.LINES["fit"], "o"),
    "load": ("load W", style.LINES["load"], "s"),
    "dimensionless_load": (
        "load W/(E'R\N{SUPERSCRIPT TWO})",
        style.LINES["dimensionless load"],
        "^",
    ),
}

_TORQUE_DRAWN = drawn_table(
    "torque_drawn",
    "Drawn in a figure of torque against speed.",
    columns="""
        panel series oil axial_load_n inner_speed_rpm torque_n_m torque_n_m_se
        relative_error""",
    uses=(
        use("series", "measured, or the load variable of the law"),
        use("axial_load_n", "mean of the set of points"),
        use("inner_speed_rpm", "abscissa"),
        use("torque_n_m", "ordinate of the panels of torque"),
        use("torque_n_m_se", "the bar drawn is 1.96 times as long to either side"),
        use("relative_error", "ordinate of the panels of error"),
    ),
)


@register(
    name="fig06",
    paper="Fig. 6",
    title="Friction torque of the bearing",
    caption="Top: measured torque (N m; bars: 95 %, random errors alone) and torque calculated "
    "with the law evaluated with pressure, with load and with dimensionless load, against speed of "
    "the inner ring. Bottom: relative errors (%).",
    family="bearing",
    tables=("torque",),
    settings=("oils", "figures"),
    requires="torque",
    draws=_TORQUE_DRAWN,
)
def fig06(results: CampaignTables, settings: Settings) -> Drawing:
    """Measured and calculated torque against speed, one column per oil; relative errors below."""
    choice = settings.figures.fig06
    level, within = choice.inlet_temperature_c, choice.same_within
    near = (results.torque["inlet_temperature_c"] - level).abs() <= within * level
    torque = results.torque[near]
    oils = [oil for oil in settings.oils if (torque["oil"] == oil).any()]
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 4.4))
    axes = figure.subplots(2, max(len(oils), 1), sharex=True, sharey="row", squeeze=False)
    torque = torque.assign(load=_sets(torque["axial_load_n"], within))
    loads = sorted(set(torque["load"]))
    drawn: list[pd.DataFrame] = []
    for column, oil in enumerate(oils):
        of_oil = torque[torque["oil"] == oil]
        title = f"{oil}, {level:g} \N{DEGREE SIGN}C"
        above, below = (
            style.title_panel(axis, number, title)
            for axis, number in zip(axes[:, column], (column, column + len(oils)), strict=True)
        )
        shades = style.shades(style.oil_colour(oil, list(settings.oils)), len(loads))
        for load, shade in zip(loads, shades, strict=True):
            of_load = of_oil[of_oil["load"] == load]
            drawn += _draw_load(axes[:, column], of_load, shade, above, below)
        axes[1, column].axhline(0, color="black", linewidth=0.6)
    axes[0, 0].set_ylabel("Friction torque (N m)")
    axes[1, 0].set_ylabel("Relative error (%)")
    for axis in axes[1]:
        axis.set_xlabel("Speed of the inner ring (1000 rpm)")
    if not drawn:
        style.say_in_panel(axes[0, 0], "No torque was measured at this temperature.")
        return figure, []
    # loads in shades of grey: each oil has its own colour
    handles = [
        style.symbol_handle(f"{load / 1e3:.3g} kN", "o", color=shade)
        for load, shade in zip(loads, style.shades(style.GREY, len(loads)), strict=True)
    ]
    title_look: dict[str, Any] = {"title_fontsize": 7, "alignment": "left"}
    axes[0, 0].legend(handles=handles, loc="upper left", title="axial load", **title_look)
    figure.legend(handles=_load_variable_handles(), loc="outside lower center", ncols=3)
    style.say_key(
        figure, "Points above: measured; bars: 95 %, random errors alone. Lines: the law."
    )
    return figure, drawn


def _load_variable_handles() -> list[Line2D]:
    """Entries of a legend that tell the load variables apart, in grey."""
    look: dict[str, Any] = {"color": style.GREY, "linewidth": 0.9}
    return [
        style.line_handle(name, linestyle=line, marker=marker, **look)
        for name, line, marker in _LOAD_VARIABLES.values()
    ]


def _draw_load(
    axes: np.ndarray[Any, Any], torque: pd.DataFrame, shade: Any, above: str, below: str
) -> Iterator[pd.DataFrame]:
    """Torque of one oil at one load in the panel above, relative errors below."""
    for load_variable, (_, line, marker) in _LOAD_VARIABLES.items():
        rows = torque[torque["load_variable"] == load_variable].sort_values("inner_speed_rpm")
        speed = rows["inner_speed_rpm"] / 1e3
        shown = rows[["oil", "inner_speed_rpm"]].assign(axial_load_n=rows["load"])
        if load_variable == "stress":
            measured, error = rows["measured_torque_n_m"], rows["measured_torque_n_m_se"]
            axes[0].errorbar(speed, measured, _SE_DRAWN * error, fmt="o", color=shade)
            yield shown.assign(
                panel=above,
                series="measured",
                torque_n_m=measured,
                torque_n_m_se=error,
                relative_error=np.nan,
            )
        look: dict[str, Any] = {"linestyle": line, "color": shade}
        axes[0].plot(speed, rows["torque_n_m"], linewidth=0.9, **look)
        axes[1].plot(speed, 100 * rows["relative_error"], linewidth=0.6, marker=marker, **look)
        yield shown.assign(
            panel=f"{above} {below}",
            series=load_variable,
            torque_n_m=rows["torque_n_m"],
            torque_n_m_se=np.nan,
            relative_error=rows["relative_error"],
        )


def _sets(levels: "pd.Series[float]", within: float) -> "pd.Series[float]":
    """For each measured level the mean of those that it belongs with."""
    ranked = levels.sort_values()
    apart = ranked.diff() > within * ranked.shift()
    return levels.groupby(apart.cumsum()).transform("mean")


_SLIP_LEVELS = (-1.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0)

_CAGE_SLIP_MAP = drawn_table(
    "cage_slip_map",
    "Drawn in the map of cage slip: one row per cell.",
    columns="panel oil pitch_speed_mm_rpm axial_load_n cage_slip advised_oil best_oil judgement",
    uses=(
        use("oil", "of the panel; empty in the last one, which shows the advice"),
        use("pitch_speed_mm_rpm", "abscissa"),
        use("axial_load_n", "ordinate"),
        use("cage_slip", "colour of the cell, and the line at the limit"),
        use("advised_oil", "colour of the cell of the last panel"),
        use("best_oil", "symbol, drawn where the judgement is not agree"),
        use("judgement", "as in slip_advice"),
    ),
)


@register(
    name="cage-slip",
    title="Cage slip and choice of oil",
    caption="Cage slip (%) at friction equilibrium against dmN, pitch diameter times speed "
    "(million mm rpm; U: entrainment speed of balls that roll), and axial load (kN), one panel per "
    "oil; line: limit of the paper. Last panel: colour of the oil that the rules of the paper "
    "advise; symbols: best oil by calculated slip, where it is another.",
    category="Bearing",
    family="bearing",
    tables=("cage_slip", "slip_advice"),
    settings=("oils", "bearing", "selection"),
    requires="torque",
    draws=_CAGE_SLIP_MAP,
)
def cage_slip(results: CampaignTables, settings: Settings) -> Drawing:
    """Cage slip against speed and axial load, one panel per oil, and the best oil by slip."""
    table, advice = results.cage_slip, results.slip_advice
    campaign_oils = list(settings.oils)
    oils = [oil for oil in campaign_oils if (table["oil"] == oil).any()]
    if not oils:
        return style.sentences("No oil has a law that a bearing could use."), []
    limit = settings.selection.limits.slip_limit
    count = len(oils) + (not advice.empty)
    columns = min(count, 2)
    rows = -(-count // columns)
    width = style.DOUBLE_COLUMN_IN if columns > 1 else style.SINGLE_COLUMN_IN
    figure, axes = style.panels(rows, columns, width, 2.2 * rows + 0.4)
    axes[0].set_yscale("log")
    axes[0].yaxis.set_major_formatter("{x:g}")
    drawn = []
    for number, oil in enumerate(oils):
        of_oil = table[table["oil"] == oil]
        filled = _draw_slip(axes[number], of_oil, limit)
        panel = style.title_panel(axes[number], number, oil)
        drawn.append(of_oil.assign(panel=panel, advised_oil="", best_oil="", judgement=""))
    if not advice.empty:
        axis = axes[len(oils)]
        in_units = advice.assign(**_in_units_of_axes(advice))
        draw_advice(axis, in_units, campaign_oils, "speed", "load", 3.5)
        panel = style.title_panel(axis, len(oils), "advice by slip")
        drawn.append(advice.assign(panel=panel, oil="", cage_slip=np.nan))
        handles = advice_handles(advice, campaign_oils, "slip")
        figure.legend(handles=handles, loc="outside lower left", ncols=4)
    for axis in axes[count:]:
        axis.set_axis_off()
    bar = figure.colorbar(filled, ax=axes, label="Cage slip", ticks=_SLIP_LEVELS[1:])
    bar.ax.set_yticklabels([f"{level:g}" for level in _SLIP_LEVELS[1:]])
    for axis in axes[max(count - columns, 0) :]:
        axis.set_xlabel(f"dmN (million mm rpm; 1 is U = {entrainment_speed_m_s(1e6):.0f} m/s)")
    figure.supylabel("Axial load (kN)", fontsize=8)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    style.say_key(
        figure,
        f"Friction equilibrium, {table['bearing'].iloc[0]}, {temperature:g} \N{DEGREE SIGN}C; "
        f"line: slip of {limit:g}.",
    )
    return figure, drawn


def _in_units_of_axes(rows: pd.DataFrame) -> dict[str, "pd.Series[float]"]:
    """Speed in million mm rpm and load in kN."""
    return {"speed": rows["pitch_speed_mm_rpm"] / 1e6, "load": rows["axial_load_n"] / 1e3}


def _draw_slip(axis: Axes, of_oil: pd.DataFrame, limit: float) -> QuadMesh:
    in_units = of_oil.assign(**_in_units_of_axes(of_oil))
    grid = in_units.pivot(index="load", columns="speed", values="cage_slip")
    speed, load = grid.columns.to_numpy(), grid.index.to_numpy()
    slip = np.ma.masked_invalid(grid.to_numpy())
    norm = BoundaryNorm(_SLIP_LEVELS, 256)
    edges = cell_edges(speed, axis.get_xscale()), cell_edges(load, axis.get_yscale())
    filled = axis.pcolormesh(*edges, slip, cmap="cividis_r", norm=norm)
    axis.contour(speed, load, slip, [limit], colors="black", linewidths=1.1)
    axis.grid(False)
    return filled


@register(
    name="size-effect",
    title="Size effect of laws of load",
    caption="Traction torque by the laws of load, relative to that by the law of pressure (%), "
    "against ball diameter (mm; all lengths in proportion, same pressure and surface speed) and "
    "against conformity (same load and speed).",
    category="Bearing",
    family="bearing",
    tables=("size_effect",),
    settings=("oils",),
    requires="torque",
    draws="size_effect",
)
def size_effect(results: CampaignTables, settings: Settings) -> Drawing:
    """Traction torque of laws of load relative to the law of pressure, by size and conformity."""
    of_load = results.size_effect["load_variable"].isin(["load", "dimensionless_load"])
    table = results.size_effect[of_load].reset_index(drop=True)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.7))
    axes = figure.subplots(1, 2, sharey=True)
    curvature = "Groove radius over ball diameter"
    panels = (
        ("ball size", "ball_diameter_mm", "Ball diameter (mm)", "stress and surface speed"),
        ("conformity", "groove_curvature", curvature, "load and speed"),
    )
    for number, (varied, column, label, held) in enumerate(panels):
        axis = axes[number]
        rows = table[table["varied"] == varied]
        for oil, load_variable in itertools.product(settings.oils, ("load", "dimensionless_load")):
            series = rows[(rows["oil"] == oil) & (rows["load_variable"] == load_variable)]
            _, line, marker = _LOAD_VARIABLES[load_variable]
            axis.plot(
                series[column],
                100 * series["relative_to_stress"],
                linestyle=line,
                marker=marker,
                color=style.oil_colour(oil, list(settings.oils)),
                label=oil if load_variable == "load" else None,
            )
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set_xlabel(label)
        style.title_panel(axis, number, f"{varied} at the same {held}")
    axes[0].set_ylabel("Traction torque above that\nof the law on stress (%)")
    if table.empty:
        style.say_in_panel(axes[0], "No oil has a law that a bearing could use.")
    else:
        axes[0].legend(loc="upper left")
        handles = _load_variable_handles()[1:]
        axes[1].legend(handles=handles, loc="upper right", title="law on", title_fontsize=7)
    return figure, [table]


@register(
    name="power-loss",
    title="Published power loss",
    caption="Calculated power loss (W) by term, and published power loss, against speed of the "
    "inner ring. The oil's share of the volume, and with it the drag, is fitted to the points; "
    "dashed: ends of its range. Published: NASA TP-2275, from a transcription by a third party.",
    category="Bearing",
    family="bearing",
    tables=("published_tests",),
    settings=("bearing",),
    requires="torque",
    draws="published_tests",
)
def power_loss(results: CampaignTables, settings: Settings) -> Drawing:
    """Calculated power loss term by term beside a published one, to which the drag is fitted."""
    table = results.published_tests.dropna(subset="published_power_w")
    figure, (axis,) = style.panels(1, 1, style.SINGLE_COLUMN_IN, 2.8)
    axis.set_xlabel("Speed of the inner ring (1000 rpm)")
    axis.set_ylabel("Power loss (W)")
    if table.empty:
        style.say_in_panel(
            axis, "The published test's oil is not fitted,\nor its bearing not described."
        )
        return figure, []
    turning = table["inner_speed_rpm"] * RAD_S_PER_RPM
    watts = [table[f"{term}_torque_n_m"] * turning for term in HEATS]
    speed = table["inner_speed_rpm"] / 1e3
    shades = colormaps["cividis"](np.linspace(0, 1, len(HEATS)))
    axis.stackplot(speed, watts, labels=HEATS, colors=shades, edgecolor="white", linewidth=0.3)
    low, high = settings.bearing.oil_volume_fraction_range
    axis.plot(
        speed,
        table[["power_low_w", "power_high_w"]],
        linestyle="--",
        color="black",
        label=[f"oil {low:.2%} and {high:.2%}", None],
    )
    # not in the colour of an oil; the rim shows it on dark areas
    rim: dict[str, Any] = {"markeredgecolor": "white", "markersize": 4}
    axis.plot(speed, table["published_power_w"], "o", color="black", label="published", **rim)
    axis.set_axisbelow(True)
    # from the top, in the order of the areas
    axis.legend(loc="upper left", reverse=True)
    share = settings.bearing.oil_volume_fraction
    style.say_key(
        figure,
        "Points: NASA TP-2275, second-hand.\n"
        f"Areas: calculated, oil {share:.2%} of the volume (fitted to the points).",
    )
    bearing, oil, load, temperature = table.loc[
        table.index[0], ["bearing", "oil", "axial_load_n", "inlet_temperature_c"]
    ]
    axis.set_title(f"{bearing}, {oil}, {load:g} N, {temperature:.0f} \N{DEGREE SIGN}C")
    return figure, [table]
