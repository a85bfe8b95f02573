"""A map of the oil that the paper's rules advise, and of the best oil where it is another one."""

from typing import Any

import pandas as pd
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from oilfilm.paper.advice import OUTSIDE
from oilfilm.report.figures import style
from oilfilm.report.figures.bearing import in_units_of_axes
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet, sentences
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_FIELD = 0.45  # share of an oil's colour in its field
# Where there is no best oil: symbol and its meaning, by judgement.
_NO_CHOICE = {
    "no film": ("x", "no film thick enough"),
    OUTSIDE: ("+", "outside the film formula"),
}
_NO_MAP = "The oils of selection.rules have no law or no film here:\nno map."


@register(
    category="Bearing",
    family="bearing",
    tables=("slip_advice",),
    settings=("oils", "bearing"),
    requires="torque",
)
def slip_advice(results: CampaignTables, settings: Settings) -> Sheet:
    """Choice of oil by cage slip.

    Oil that the rules of the paper advise (colour), with its cage slip at friction equilibrium.
    Symbols: best oil, where it is another one. The best oil has the least torque of the oils
    that hold the cage; if none holds it, the least slip. Abscissa: dmN, pitch diameter times
    speed (million mm rpm). Ordinate: axial load (kN).
    """
    advice, oils = results.slip_advice, list(settings.oils)
    if advice.empty:
        return sentences(_NO_MAP)
    sheet = Sheet(height=2.2, top=0.06)
    panel = sheet.panel(title=None)
    panel.axis.set_yscale("log")
    panel.axis.yaxis.set_major_formatter("{x:g}")
    _draw(panel, advice.assign(**in_units_of_axes(advice)), oils, ("speed", "load_kn"), 3.5)
    sheet.label(style.DMN_LABEL, style.AXIAL_LOAD_LABEL)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    title = f"{advice['bearing'].iloc[0]}, oil at {temperature:g} \N{DEGREE SIGN}C"
    sheet.legend(_handles(advice, oils), f"{title};\n{style.DMN_AS_SPEED}")
    return sheet


def _draw(
    panel: Panel, advice: pd.DataFrame, oils: list[str], columns: tuple[str, str], markersize: float
) -> None:
    """Fields in the colour of the advised oil, and symbols of the best oil.

    Args:
        panel: Its scales are set already.
        advice: Columns `advised_oil`, `best_oil` and `judgement`, one row per cell.
        oils: Oils of the campaign, which fix the colours.
        columns: Columns along the abscissa and the ordinate.
        markersize: Of the symbols, in points.
    """
    axis, (x, y) = panel.axis, columns
    outside = advice["judgement"] == OUTSIDE
    # white: no oil is advised, or the choice depends on a film that is not known
    shown = advice.assign(number=advice["advised_oil"].mask(outside, "").map(["", *oils].index))
    field = shown.pivot(index=y, columns=x, values="number")
    fields = [style.tint(style.oil_colour(oil, oils), _FIELD) for oil in oils]
    axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(), axis.get_xscale()),
        style.cell_edges(field.index.to_numpy(), axis.get_yscale()),
        field.to_numpy(),
        cmap=ListedColormap([(1.0, 1.0, 1.0), *fields]),
        vmin=-0.5,
        vmax=len(oils) + 0.5,
        rasterized=True,
    )
    differs = (advice["judgement"] != "agree") & ~outside
    for oil in oils:
        other = advice[(advice["best_oil"] == oil) & differs]
        look: style.Look = {"linestyle": "", "markersize": markersize, **style.oil_look(oil, oils)}
        axis.plot(other[x], other[y], **look)
    for judgement, (marker, _) in _NO_CHOICE.items():
        here = advice[advice["judgement"] == judgement]
        # a cross of thin lines needs more room than a filled symbol
        axis.plot(here[x], here[y], marker, color=style.GREY, markersize=1.5 * markersize)
    axis.grid(False)
    label = advice["judgement"] + ", best " + advice["best_oil"].replace("", "none")
    panel.keep("advised oil", advice[x], advice[y], oil=advice["advised_oil"], label=label)


def _handles(advice: pd.DataFrame, oils: list[str]) -> list[Any]:
    """Entries of the legend."""
    handles: list[Any] = []
    for oil in oils:
        if oil in {*advice["advised_oil"], *advice["best_oil"]}:
            tint = style.tint(style.oil_colour(oil, oils), _FIELD)
            handles += [
                Patch(facecolor=tint, label=f"paper advises {oil}"),
                style.line_handle(
                    f"best oil: {oil}", linestyle="", markersize=3.5, **style.oil_look(oil, oils)
                ),
            ]
    if (advice["judgement"] == "rule has none").any():
        look: style.Look = {"facecolor": "white", "edgecolor": style.GREY, "linewidth": 0.6}
        handles.append(Patch(label="paper's oils lack film", **look))
    return handles + [
        style.symbol_handle(label, marker, color=style.GREY, markersize=3.5)
        for judgement, (marker, label) in _NO_CHOICE.items()
        if (advice["judgement"] == judgement).any()
    ]
