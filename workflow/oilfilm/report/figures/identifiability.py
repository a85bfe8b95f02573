"""How well the data tell the constants apart: correlations and profiles."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_COLOURS = "PuOr"  # from orange by white to purple, distinct for every kind of colour vision
_REACH = 4.5  # naive standard errors to either side
_NAMED = 2  # profiles that bend most ...
_BENT = 0.05  # ... by this at least, in naive standard errors


@register(
    name="identifiability",
    title="Identifiability of the constants",
    caption="Top: correlation of each pair of constants, by the bootstrap over curves or, "
    "with too few curves, by the Jacobian. Bottom: profile of each constant. Ordinate: signed "
    "root of the rise of the squared error. Abscissa: distance from the optimum in standard "
    "errors of independent points. A straight line marks a well-determined constant.",
    category="Fits",
    family="law",
    tables=("coefficients", "correlations", "profiles"),
    settings=("oils",),
)
def identifiability(results: CampaignTables, settings: Settings) -> Drawing:
    """One column per oil: correlation of each pair of constants, profile of each constant."""
    results = results.configured
    fitted = set(results.profiles["oil"])
    oils = [oil for oil in settings.oils if oil in fitted]
    if not oils:
        return style.sentences("No oil has a fit with profiles."), []
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 4.6))
    axes = figure.subplots(2, len(oils), squeeze=False)
    drawn = []
    image: Any = None
    for column, oil in enumerate(oils):
        above, below = axes[:, column]
        constants = list(dict.fromkeys(results.profiles.query("oil == @oil")["constant"]))
        image, pairs = _draw_correlations(above, results, oil, constants)
        profiles = _profiles(results, oil)
        _draw_profiles(below, profiles, style.oil_colour(oil, list(settings.oils)))
        errors = results.coefficients.query("oil == @oil")["standard_error"]
        title = f"{oil}, by the Jacobian" if errors.isna().all() else oil
        panel = style.title_panel(above, column, title)
        names = pairs["constant"] + ", " + pairs["other"]
        about = {"oil": oil, "label": names, "value": pairs["correlation"]}
        drawn.append(marks(panel, "correlation", np.nan, **about))
        panel = style.title_panel(below, column + len(oils), oil)
        xy = profiles["x"], profiles["value"]
        drawn.append(marks(panel, "profile", *xy, oil=oil, label=profiles["constant"]))
    figure.colorbar(image, ax=list(axes[0]), label="Correlation", shrink=0.9)
    axes[1, 0].set_ylabel("Signed root of the rise\nof the squared error")
    axes[1, len(oils) // 2].set_xlabel("Distance from the fit in naive standard errors")
    key = "Below: one line per constant, those that bend most are named"
    lost = [oil for oil in settings.oils if oil not in fitted]
    style.say_key(figure, key + (f"\nno fit: {', '.join(lost)}" if lost else ""))
    return figure, drawn


def _draw_correlations(
    axis: Axes, results: CampaignTables, oil: str, constants: Sequence[str]
) -> tuple[Any, pd.DataFrame]:
    """One square per pair below the diagonal; each pair is in the table once."""
    pairs = results.correlations.query("oil == @oil")
    field = np.full((len(constants), len(constants)), np.nan)
    for row in tables.rows(pairs):
        column, line = sorted(constants.index(row[name]) for name in ("constant", "other"))
        field[line, column] = row["correlation"]
    image = axis.imshow(field, cmap=_COLOURS, vmin=-1, vmax=1)
    axis.set_xticks(range(len(constants)), constants, rotation=90, fontsize=6)
    axis.set_yticks(range(len(constants)), constants, fontsize=6)
    axis.grid(False)
    axis.tick_params(length=0)
    return image, pairs


def _profiles(results: CampaignTables, oil: str) -> pd.DataFrame:
    """Profiles over the distance from the fit, in naive standard errors."""
    fitted = results.coefficients.query("oil == @oil").set_index("constant")
    profiles = results.profiles.query("oil == @oil")
    best, error = (
        profiles["constant"].map(fitted[name]) for name in ("value", "naive_standard_error")
    )
    x = (profiles["value"] - best) / error
    return profiles[["constant"]].assign(x=x, value=profiles["signed_root"])


def _draw_profiles(axis: Axes, profiles: pd.DataFrame, colour: str) -> None:
    axis.axline((0, 0), slope=1, color=style.GREY, linewidth=0.6)
    bends = {}
    for constant, line in profiles.groupby("constant", sort=False):
        axis.plot(line["x"], line["value"], color=colour, linewidth=0.7)
        bends[str(constant)] = float((line["value"] - line["x"]).abs().max())
    axis.set(xlim=(-_REACH, _REACH), ylim=(-_REACH, _REACH), aspect="equal")
    named = [name for name in sorted(bends, key=lambda name: -bends[name]) if bends[name] > _BENT]
    labels = [f"{name}: off the line by {bends[name]:.2g}" for name in named[:_NAMED]]
    axis.text(0.03, 0.97, "\n".join(labels), va="top", fontsize=6, transform=axis.transAxes)
