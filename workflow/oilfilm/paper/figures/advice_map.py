"""A map of the oil that the rules of the paper advise, and of the best oil where it is another."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from oilfilm.paper.selection import OUTSIDE
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import marks

_FIELD = 0.45  # share of an oil's colour in its field
# Where there is no best oil: symbol and its meaning, by judgement.
_NO_CHOICE = {
    "no film": ("x", "no film thick enough"),
    OUTSIDE: ("+", "outside the film formula"),
}


def draw_advice(
    axis: Axes, advice: pd.DataFrame, oils: list[str], x: str, y: str, markersize: float
) -> None:
    """Draw fields in the colour of the advised oil, and symbols of the best oil.

    Args:
        axis: Panel; its scales are set already.
        advice: Columns x, y, `advised_oil`, `best_oil` and `judgement`, one row per cell.
        oils: Oils of the campaign, which fix the colours.
        x: Column along the abscissa.
        y: Column along the ordinate.
        markersize: Of the symbols, in points.
    """
    outside = advice["judgement"] == OUTSIDE
    shown = advice.assign(advised_oil=advice["advised_oil"].mask(outside, ""))
    field = shown.pivot(index=y, columns=x, values="advised_oil")
    # white: no oil is advised, or the choice depends on a film that is not known
    fields = [style.tint(style.oil_colour(oil, oils), _FIELD) for oil in oils]
    axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(), axis.get_xscale()),
        style.cell_edges(field.index.to_numpy(), axis.get_yscale()),
        field.map(lambda oil: oils.index(oil) + 1 if oil else 0).to_numpy(),
        cmap=ListedColormap([(1.0, 1.0, 1.0), *fields]),
        vmin=-0.5,
        vmax=len(oils) + 0.5,
        rasterized=True,
    )
    for oil in oils:
        other = advice[(advice["best_oil"] == oil) & (advice["judgement"] != "agree") & ~outside]
        colour, marker = style.oil_colour(oil, oils), style.oil_marker(oil, oils)
        axis.plot(other[x], other[y], marker, color=colour, markersize=markersize)
    for judgement, (marker, _) in _NO_CHOICE.items():
        here = advice[advice["judgement"] == judgement]
        # a cross of thin lines needs more room than a filled symbol
        axis.plot(here[x], here[y], marker, color=style.GREY, markersize=1.5 * markersize)
    axis.grid(False)


def advice_marks(panel: str, advice: pd.DataFrame, x: str, y: str) -> pd.DataFrame:
    """Rows of the table of what is drawn: advised and best oil of each cell."""
    label = advice["judgement"] + ", best " + advice["best_oil"].replace("", "none")
    return marks(panel, "advised oil", advice[x], advice[y], oil=advice["advised_oil"], label=label)


def advice_handles(advice: pd.DataFrame, oils: list[str], best: str) -> list[Any]:
    """Entries of the legend of `draw_advice`; `best` is the word for the best oil."""
    handles: list[Any] = []
    for oil in oils:
        if oil in {*advice["advised_oil"], *advice["best_oil"]}:
            colour, marker = style.oil_colour(oil, oils), style.oil_marker(oil, oils)
            label = f"{best}: {oil}"
            handles += [
                Patch(facecolor=style.tint(colour, _FIELD), label=f"paper advises {oil}"),
                style.symbol_handle(label, marker, color=colour, markersize=3.5),
            ]
    if (advice["judgement"] == "rule has none").any():
        look: dict[str, Any] = {"facecolor": "white", "edgecolor": style.GREY, "linewidth": 0.6}
        handles.append(Patch(label="paper's oils lack film", **look))
    return handles + [
        style.symbol_handle(label, marker, color=style.GREY, markersize=3.5)
        for judgement, (marker, label) in _NO_CHOICE.items()
        if (advice["judgement"] == judgement).any()
    ]
