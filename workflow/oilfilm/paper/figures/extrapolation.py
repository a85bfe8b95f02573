"""Fitted laws against the truth of a simulated campaign, at the conditions of Figs 7-10."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, PercentFormatter

from oilfilm.paper.extrapolation import relative_rms
from oilfilm.paper.figures.model_curves import CUTS, panel_title
from oilfilm.report.captions import tie
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.config import ExtrapolationFigureSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_ROW_IN = 0.24


@register(
    name="extrapolation",
    title="Fitted laws and the truth of the simulation",
    caption="(a-d) Fitted laws and the truth of the simulation for one oil, each along one "
    "cut through the conditions of Figs 7 to 10. (e) Rms error of each law within the tested "
    "conditions and beyond them. The figure allows no conclusion about real oils.",
    category="Fits",
    family="law",
    tables=("extrapolation",),
    settings=("oils", "figures"),
    requires="twin",
    compares_laws=True,
)
def extrapolation(results: CampaignTables, settings: Settings) -> Drawing:
    """One oil cut through Figs 7-10, truth and laws; below, each law's error for every oil."""
    compared, choice = results.extrapolation, settings.figures.extrapolation
    laws, oils = list(dict.fromkeys(compared["law"])), list(settings.oils)
    errors_in = _ROW_IN * len(laws) + 0.55
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 4.4 + errors_in))
    grid = figure.add_gridspec(3, 2, height_ratios=(2.1, 2.1, errors_in))
    of_oil = compared[compared["oil"] == choice.oil]
    colour = style.oil_colour(choice.oil, oils)
    drawn: list[pd.DataFrame] = []
    first: Axes | None = None
    for number, (name, (abscissa, _)) in enumerate(CUTS.items()):
        axis = figure.add_subplot(grid[number // 2, number % 2], sharey=first)
        first = first or axis
        cut, levels = _cut(of_oil[of_oil["figure"] == name], abscissa, choice)
        panel = style.title_panel(axis, number, panel_title(levels))
        axis.set_xlabel(style.CONDITION_LABELS[abscissa])
        drawn += _draw_cut(axis, panel, cut.sort_values(abscissa), abscissa, colour, laws)
        if number % 2 == 0:
            axis.set_ylabel(style.TRACTION_LABEL)
    true = of_oil["true_traction_coefficient"]
    if first is not None and len(true):
        # a law that runs away leaves the panel, instead of pressing the others flat
        first.set_ylim(0, min(first.get_ylim()[1], 2 * true.max()))
    drawn += _draw_errors(figure.add_subplot(grid[2, :]), compared, laws, oils)
    handles = [
        style.line_handle(f"truth of the twin, {choice.oil}", color=colour, linewidth=1.8),
        *(style.line_handle(law, **_line_of_law(number)) for number, law in enumerate(laws)),
        Patch(facecolor=style.EXTRAPOLATED, label="beyond the tests"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    key = ("It decides nothing about the real oils.", tie(settings.campaign))
    style.say_key(figure, " ".join(filter(None, key)))
    return figure, drawn


def _cut(
    of_figure: pd.DataFrame, abscissa: str, choice: ExtrapolationFigureSettings
) -> tuple[pd.DataFrame, dict[str, float]]:
    """The rows along one abscissa, and the levels of the other conditions.

    A condition that the figure has at one level is at that level, the others are chosen.
    """
    fixed = {}
    for name in style.LEVEL_PHRASES:
        if name != abscissa:
            levels = of_figure[name].unique()
            fixed[name] = levels[0] if len(levels) == 1 else getattr(choice, name)
            of_figure = of_figure[np.isclose(of_figure[name], fixed[name])]
    return of_figure, fixed


def _draw_cut(
    axis: Axes, panel: str, cut: pd.DataFrame, abscissa: str, colour: Any, laws: Sequence[str]
) -> Iterator[pd.DataFrame]:
    """The truth, each law, and a tint where no test reaches."""
    if cut.empty:
        style.say_in_panel(axis, "no such condition\n(config: figures, extrapolation)")
        return
    axis.set_facecolor(style.EXTRAPOLATED)
    tested = cut.loc[cut["beyond"] == "", abscissa]
    if len(tested):
        axis.axvspan(tested.min(), tested.max(), color="white", linewidth=0, zorder=0)
    truth = cut[cut["law"] == laws[0]]
    axis.plot(truth[abscissa], truth["true_traction_coefficient"], color=colour, linewidth=1.8)
    xy = truth[abscissa], truth["true_traction_coefficient"]
    yield marks(panel, "truth", *xy, oil=truth["oil"])
    for number, law in enumerate(laws):
        of_law = cut[cut["law"] == law]
        xy = of_law[abscissa], of_law["traction_coefficient"]
        axis.plot(*xy, **_line_of_law(number))
        yield marks(panel, law, *xy, oil=of_law["oil"])


def _draw_errors(
    axis: Axes, compared: pd.DataFrame, laws: Sequence[str], oils: Sequence[str]
) -> Iterator[pd.DataFrame]:
    """One row per law: open symbols in the tested box, filled ones beyond it, joined by a line."""
    title = "Rms error over Figs 7-10, open: tested box; filled: beyond it"
    panel = style.title_panel(axis, len(CUTS), title)
    for (row, law), (number, oil) in itertools.product(enumerate(laws), enumerate(oils)):
        of_both = compared[(compared["law"] == law) & (compared["oil"] == oil)]
        outside = of_both["beyond"] != ""
        inside, beyond = relative_rms(of_both[~outside]), relative_rms(of_both[outside])
        height = row + 0.22 * (number - (len(oils) - 1) / 2)
        colour, marker = style.oil_colour(oil, oils), style.oil_marker(oil, oils)
        axis.plot([inside, beyond], [height, height], color=colour, linewidth=0.8)
        axis.plot(inside, height, marker, color=colour, markerfacecolor="white", markersize=4)
        axis.plot(beyond, height, marker, color=colour, markersize=4)
        yield marks(panel, law, [inside, beyond], height, oil=oil, label=["tested box", "beyond"])
    axis.set_yticks(range(len(laws)), laws)
    axis.set_ylim(len(laws) - 0.5, -0.5)
    if axis.get_xlim()[1] > 1:
        axis.set_xscale("log")
    else:
        axis.set_xlim(left=0)
        axis.xaxis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10]))
    axis.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axis.set_xlabel("Rms error over rms of true \N{GREEK SMALL LETTER MU}")
    fitted = set(compared.dropna(subset="traction_coefficient")["oil"])
    handles = style.oil_handles(oils, fitted, markersize=4, linewidth=0.8)
    axis.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _line_of_law(number: int) -> dict[str, Any]:
    """Colours are for oils, dashes for what a law was fitted to: laws differ by symbol and grey."""
    return {
        "color": ("black", "#777777")[number % 2],
        "linewidth": 0.9,
        "linestyle": style.LINES["fit"],
        # one symbol along each sixth of the panel's diagonal, not all at one abscissa
        "marker": style.MARKERS[number % len(style.MARKERS)],
        "markevery": (0.03 * number, 0.17),
        "markersize": 2.6,
        "markerfacecolor": "white" if number < len(style.MARKERS) else "black",
        "markeredgewidth": 0.6,
    }
