"""Figures of the bearing: torque on each basis, cage slip, size effect, a published power loss."""

import itertools
import string
from collections.abc import Sequence
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
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.advice_map import advice_handles, cell_edges, draw_advice
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use
from oilfilm.units import RAD_S_PER_RPM

_SE_DRAWN = 1.96  # error bars are 95 % intervals
_BASES: dict[str, tuple[str, Any, str]] = {
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
    category="Paper",
    family="bearing",
    tables=("torque",),
    settings=("oils", "figures"),
    requires="torque",
    draws=_TORQUE_DRAWN,
)
def fig06(results: CampaignTables, settings: Settings) -> Drawing:
    """Measured and calculated torque against speed, one column per oil; relative errors below."""
    choice = settings.figures.fig06
    asked, within = choice.inlet_temperature_c, choice.same_within
    near = (results.torque["inlet_temperature_c"] - asked).abs() <= within * asked
    torque = results.torque[near]
    oils = [oil for oil in settings.oils if (torque["oil"] == oil).any()]
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 4.4))
    axes = figure.subplots(2, max(len(oils), 1), sharex=True, sharey="row", squeeze=False)
    torque = torque.assign(load=_sets(torque["axial_load_n"], within))
    loads = sorted(set(torque["load"]))
    rows = []
    for column, oil in enumerate(oils):
        of_oil = torque[torque["oil"] == oil]
        colour = style.oil_colour(oil, list(settings.oils))
        letters = string.ascii_letters[column], string.ascii_letters[column + len(oils)]
        rows.append(_draw_oil(axes[:, column], of_oil, colour, letters, loads))
        for axis, letter in zip(axes[:, column], letters, strict=True):
            axis.set_title(f"({letter}) {oil}, {asked:g} \N{DEGREE SIGN}C")
    axes[0, 0].set_ylabel("Friction torque (N m)")
    axes[1, 0].set_ylabel("Relative error (%)")
    for axis in axes[1]:
        axis.set_xlabel("Speed of the inner ring (1000 rpm)")
    if not rows:
        style.say_in_panel(axes[0, 0], "No torque was measured at this temperature.")
        return figure, []
    axes[0, 0].legend(
        handles=_load_handles(loads),
        loc="upper left",
        title="axial load",
        title_fontsize=7,
        alignment="left",
    )
    figure.legend(handles=_basis_handles(), loc="outside lower center", ncols=3)
    style.say_key(
        figure, "Points above: measured; bars: 95 %, random errors alone. Lines: the law."
    )
    return figure, rows


def _basis_handles() -> list[Line2D]:
    """Entries of a legend that tell the bases apart, in grey."""
    return [
        Line2D([], [], linestyle=line, marker=marker, color=style.GREY, linewidth=0.9, label=name)
        for name, line, marker in _BASES.values()
    ]


def _draw_oil(
    axes: np.ndarray[Any, Any],
    torque: pd.DataFrame,
    colour: str,
    letters: tuple[str, str],
    loads: Sequence[float],
) -> pd.DataFrame:
    rows = []
    for load, shade in zip(loads, style.shades(colour, len(loads)), strict=True):
        of_load = torque[torque["load"] == load]
        for basis, (_, line, marker) in _BASES.items():
            of_basis = of_load[of_load["load_variable"] == basis].sort_values("inner_speed_rpm")
            speed = of_basis["inner_speed_rpm"] / 1e3
            if basis == "stress":
                axes[0].errorbar(
                    speed,
                    of_basis["measured_torque_n_m"],
                    _SE_DRAWN * of_basis["measured_torque_n_m_se"],
                    fmt="o",
                    color=shade,
                )
                rows.append(_drawn(of_basis, letters[0], "measured", load))
            axes[0].plot(speed, of_basis["torque_n_m"], linestyle=line, color=shade, linewidth=0.9)
            axes[1].plot(
                speed,
                100 * of_basis["relative_error"],
                linestyle=line,
                marker=marker,
                color=shade,
                linewidth=0.6,
            )
            rows.append(_drawn(of_basis, f"{letters[0]} {letters[1]}", basis, load))
    axes[1].axhline(0, color="black", linewidth=0.6)
    return pd.concat(rows, ignore_index=True)


def _load_handles(loads: Sequence[float]) -> list[Line2D]:
    """Entries of a legend that tell loads apart, in shades of grey: each oil has its own colour."""
    return [
        Line2D([], [], linestyle="", marker="o", color=shade, label=f"{load / 1e3:.3g} kN")
        for load, shade in zip(loads, style.shades(style.GREY, len(loads)), strict=True)
    ]


def _sets(levels: "pd.Series[float]", within: float) -> "pd.Series[float]":
    """For each measured level the mean of those that it belongs with."""
    ranked = levels.sort_values()
    apart = ranked.diff() > within * ranked.shift()
    return levels.groupby(apart.cumsum()).transform("mean")


def _drawn(rows: pd.DataFrame, panel: str, series: str, load: float) -> pd.DataFrame:
    measured = series == "measured"
    return pd.DataFrame(
        {
            "panel": panel,
            "series": series,
            "oil": rows["oil"],
            "axial_load_n": load,
            "inner_speed_rpm": rows["inner_speed_rpm"],
            "torque_n_m": rows["measured_torque_n_m" if measured else "torque_n_m"],
            "torque_n_m_se": rows["measured_torque_n_m_se"] if measured else np.nan,
            "relative_error": np.nan if measured else rows["relative_error"],
        }
    )


_SLIP_LEVELS = (-1.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0)


_CAGE_SLIP_MAP = drawn_table(
    "cage_slip_map",
    "Drawn in the map of cage slip: one row per cell.",
    columns="""
        panel oil pitch_speed_mm_rpm axial_load_n cage_slip advised_oil best_oil judgement""",
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
    caption="Cage slip (%) at friction equilibrium against pitch diameter times speed (million "
    "mm rpm) and axial load (kN), one panel per oil; line: limit of the paper. Last panel: colour "
    "of the oil that the rules of the paper advise; symbols: best oil by calculated slip, where it "
    "is another.",
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
    every = list(settings.oils)
    oils = [oil for oil in every if (table["oil"] == oil).any()]
    if not oils:
        return style.sentences("No oil has a law that a bearing could use."), []
    count = len(oils) + (not advice.empty)
    columns = min(count, 2)
    rows = -(-count // columns)
    width = style.DOUBLE_COLUMN_IN if columns > 1 else style.SINGLE_COLUMN_IN
    figure, axes = style.panels(rows, columns, width, 2.2 * rows + 0.4)
    axes[0].set_yscale("log")
    axes[0].yaxis.set_major_formatter("{x:g}")
    drawn = []
    for letter, axis, oil in zip(string.ascii_letters, axes, oils, strict=False):
        of_oil = table[table["oil"] == oil]
        filled = _draw_slip(axis, of_oil, settings.selection.limits.slip_limit)
        axis.set_title(f"({letter}) {oil}")
        drawn.append(of_oil.assign(panel=letter, advised_oil="", best_oil="", judgement=""))
    if not advice.empty:
        letter, axis = string.ascii_letters[len(oils)], axes[len(oils)]
        in_units = advice.assign(**_in_units_of_axes(advice))
        draw_advice(axis, in_units, every, "speed", "load", 3.5)
        axis.set_title(f"({letter}) advice by slip")
        drawn.append(advice.assign(panel=letter, oil="", cage_slip=np.nan))
        figure.legend(
            handles=advice_handles(advice, every, "slip"), loc="outside lower left", ncols=4
        )
    for axis in axes[count:]:
        axis.set_axis_off()
    bar = figure.colorbar(filled, ax=axes, label="Cage slip (1)", ticks=_SLIP_LEVELS[1:])
    bar.ax.set_yticklabels([f"{level:g}" for level in _SLIP_LEVELS[1:]])
    for axis in axes[max(count - columns, 0) :]:
        axis.set_xlabel("Pitch diameter times speed (million mm rpm)")
    figure.supylabel("Axial load (kN)", fontsize=8)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    limit = settings.selection.limits.slip_limit
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
    """Traction torque of the load bases against the stress basis, by ball size and conformity."""
    drawn = results.size_effect["load_variable"].isin(["load", "dimensionless_load"])
    table = results.size_effect[drawn].reset_index(drop=True)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.7))
    axes = figure.subplots(1, 2, sharey=True)
    panels = (
        ("ball size", "ball_diameter_mm", "Ball diameter (mm)", "stress and surface speed"),
        (
            "conformity",
            "groove_curvature",
            "Groove radius over ball diameter (1)",
            "load and speed",
        ),
    )
    for letter, axis, (varied, column, label, held) in zip("ab", axes, panels, strict=True):
        rows = table[table["varied"] == varied]
        for oil, basis in itertools.product(settings.oils, ("load", "dimensionless_load")):
            of_series = rows[(rows["oil"] == oil) & (rows["load_variable"] == basis)]
            _, line, marker = _BASES[basis]
            axis.plot(
                of_series[column],
                100 * of_series["relative_to_stress"],
                linestyle=line,
                marker=marker,
                color=style.oil_colour(oil, list(settings.oils)),
                label=oil if basis == "load" else None,
            )
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set_xlabel(label)
        axis.set_title(f"({letter}) {varied} at the same {held}")
    axes[0].set_ylabel("Traction torque above that\nof the law on stress (%)")
    if table.empty:
        style.say_in_panel(axes[0], "No oil has a law that a bearing could use.")
    else:
        axes[0].legend(loc="upper left")
        handles = _basis_handles()[1:]
        axes[1].legend(handles=handles, loc="upper right", title="law on", title_fontsize=7)
    return figure, [table]


@register(
    name="power-loss",
    title="Published power loss",
    caption="Calculated power loss (W) by term, and published power loss, against speed of the "
    "inner ring: a plausibility check only. Published: NASA TP-2275, from a transcription by a "
    "third party.",
    category="Bearing",
    family="bearing",
    tables=("power_loss",),
    requires="torque",
    draws="power_loss",
)
def power_loss(results: CampaignTables, settings: Settings) -> Drawing:
    """Calculated power loss term by term beside a published one: plausibility alone."""
    table = results.power_loss
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
    # not in the colour of an oil; the rim shows it on dark areas
    rim: dict[str, Any] = {"markeredgecolor": "white", "markersize": 4}
    axis.plot(speed, table["published_power_w"], "o", color="black", label="published", **rim)
    axis.set_axisbelow(True)
    # from the top, as the areas lie
    axis.legend(loc="upper left", reverse=True)
    style.say_key(figure, "Points: NASA TP-2275, second-hand. Areas: calculated.")
    bearing, oil, load, temperature = table.loc[
        table.index[0], ["bearing", "oil", "axial_load_n", "inlet_temperature_c"]
    ]
    axis.set_title(f"{bearing}, {oil}, {load:g} N, {temperature:.0f} \N{DEGREE SIGN}C")
    return figure, [table]
