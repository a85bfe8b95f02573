"""The map of oils: what the paper's rules advise, and where the numbers prefer another oil."""

import string
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from oilfilm import tables
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import register
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.units import FloatArray

_SPEED, _PRESSURE = "entrainment_speed_m_s", "max_hertz_pressure_gpa"
_PANEL = ["inlet_temperature_c", "slide_roll_ratio"]
_FIELD = 0.45  # share of an oil's colour in the field that a rule gives it


@register(
    name="selection",
    title="Choice of oil",
    caption="Colour of the oil that the rules of the paper advise, against entrainment speed (m/s) "
    "and maximum Hertz pressure (GPa); symbols: oil that traction and film prefer, where it is "
    "another.",
    category="Claims",
    family="claims",
    tables=("selection",),
    settings=("oils", "printed"),
    draws="selection_map",
)
def selection_map(
    results: CampaignTables, config: Mapping[str, Any]
) -> tuple[Figure, pd.DataFrame]:
    """A row of panels a temperature, a column a slip; cells of speed and stress.

    The refit is drawn, the printed constants where the campaign has no fit of these oils.
    """
    table = results.selection
    if table.empty:
        return _in_words(config), tables.empty("selection_map")
    basis = table["basis"].iloc[0]
    table = table[table["basis"] == basis]
    oils = list(config["oils"])
    temperatures, slips = (sorted(table[name].unique()) for name in _PANEL)
    figure, axes = style.panels(
        len(temperatures), len(slips), style.DOUBLE_COLUMN_IN, 1.75 * len(temperatures) + 0.4
    )
    drawn = []
    for number, axis in enumerate(axes):
        temperature, slip = temperatures[number // len(slips)], slips[number % len(slips)]
        here = table[(table[_PANEL[0]] == temperature) & (table[_PANEL[1]] == slip)]
        panel = string.ascii_lowercase[number]
        axis.set_title(f"({panel}) T = {temperature:g} \N{DEGREE SIGN}C, S = {slip:g}", fontsize=7)
        _draw(axis, here, oils)
        box = config["printed"]["boxes"]["tested"]
        at = zip(_PANEL, (temperature, slip), strict=True)
        if all(box[name][0] <= level <= box[name][1] for name, level in at):
            _draw_tested(axis, box)
        drawn.append(here.assign(panel=panel))
    _label(figure, axes[0], axes[-len(slips) :], table)
    _say_key(figure, oils, table)
    stand_ins = any(oil is not None and oil["stand_in"] for oil in config["oils"].values())
    films = ", of STAND-IN oils" if stand_ins else ""
    style.say_key(figure, f"Constants: {basis}. Film: of the traction rig's contact{films}")
    style.say_source(figure, config["campaign"])
    return figure, tables.conform(
        pd.concat(drawn)[tables.columns("selection_map")], "selection_map", "map of oils"
    )


def _in_words(config: Mapping[str, Any]) -> Figure:
    figure, (axis,) = style.panels(1, 1, style.SINGLE_COLUMN_IN, 0.5)
    axis.set_axis_off()
    axis.text(
        0,
        1,
        "The oils of selection.rules have no law or no film here: no map.",
        va="top",
        fontsize=7,
    )
    style.say_source(figure, config["campaign"])
    return figure


def _draw(axis: Axes, here: pd.DataFrame, oils: Sequence[str]) -> None:
    """Fields in the colour of the advised oil, symbols of the oil that the numbers prefer."""
    field = here.pivot(index=_PRESSURE, columns=_SPEED, values="advised_oil")
    # white is for places where no oil is advised
    fields = [style.tint(style.oil_colour(oil, oils), _FIELD) for oil in oils]
    places = field.map(lambda oil: oils.index(oil) + 1 if oil else 0)
    axis.pcolormesh(
        _edges(field.columns.to_numpy()),
        _edges(field.index.to_numpy()),
        places.to_numpy(),
        cmap=ListedColormap([(1.0, 1.0, 1.0), *fields]),
        vmin=-0.5,
        vmax=len(oils) + 0.5,
        rasterized=True,
    )
    for oil in oils:
        apart = here[(here["best_oil"] == oil) & (here["judgement"] != "agree")]
        axis.plot(
            apart[_SPEED],
            apart[_PRESSURE],
            style.oil_marker(oil, oils),
            color=style.oil_colour(oil, oils),
            markersize=2.2,
            linestyle="",
        )
    none = here[here["judgement"] == "no film"]
    axis.plot(none[_SPEED], none[_PRESSURE], "x", color="#555555", markersize=3, linestyle="")
    axis.set(xscale="log", yscale="log")
    axis.grid(False)


def _edges(levels: FloatArray) -> FloatArray:
    """Edges of cells around rising levels of equal ratio."""
    ratio = np.sqrt(levels[1] / levels[0])
    return np.append(levels / ratio, levels[-1] * ratio)


def _draw_tested(axis: Axes, box: Mapping[str, Sequence[float]]) -> None:
    (left, right), (low, high) = box[_SPEED], box[_PRESSURE]
    axis.add_patch(
        Rectangle(
            (left, low), right - left, high - low, fill=False, edgecolor="black", linewidth=0.9,
        )
    )  # fmt: skip


def _label(figure: Figure, axis: Axes, bottom: Sequence[Axes], table: pd.DataFrame) -> None:
    for side, name, ticks in (
        (axis.xaxis, _SPEED, (20, 50, 100, 200)),
        (axis.yaxis, _PRESSURE, (0.8, 1.0, 1.5, 2.0, 2.5)),
    ):
        inside = [tick for tick in ticks if table[name].min() <= tick <= table[name].max() * 1.001]
        side.set_major_locator(FixedLocator(inside))
        side.set_major_formatter("{x:g}")
        side.set_minor_locator(NullLocator())
        side.set_minor_formatter(NullFormatter())
    # not of the figure as a whole, which would lie on the key
    bottom[len(bottom) // 2].set_xlabel("Entrainment speed U (m/s)")
    figure.supylabel("Maximum Hertz pressure P (GPa)", fontsize=8)


def _say_key(figure: Figure, oils: Sequence[str], table: pd.DataFrame) -> None:
    shown = [oil for oil in oils if oil in {*table["advised_oil"], *table["best_oil"]}]
    fields: list[Any] = [
        Patch(
            facecolor=style.tint(style.oil_colour(oil, oils), _FIELD), label=f"rules advise {oil}"
        )
        for oil in shown
    ]
    symbols: list[Any] = [
        Line2D(
            [], [], linestyle="", marker=style.oil_marker(oil, oils),
            color=style.oil_colour(oil, oils), markersize=3.5, label=f"numbers prefer {oil}",
        )
        for oil in shown
    ]  # fmt: skip
    symbols.append(
        Rectangle((0, 0), 1, 1, fill=False, edgecolor="black", label="tested by the paper")
    )
    fields.append(
        Line2D(
            [], [], linestyle="", marker="x", color="#555555", markersize=4,
            label="no film known to be enough",
        )
    )  # fmt: skip
    pairs = [handle for pair in zip(fields, symbols, strict=True) for handle in pair]
    figure.legend(handles=pairs, loc="outside lower left", ncols=len(pairs) // 2)
