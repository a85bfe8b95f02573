"""The figure of `oilfilm compare --plot`."""

from collections.abc import Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.base.units import BoolArray
from oilfilm.cli.compare import MU, RATIO, conditions_text
from oilfilm.fits.fitted import SLIP
from oilfilm.report.figures import style
from oilfilm.surface.support import Support

_DOTTED = ". Dotted: not tested, without support or above the limiting shear stress"


def draw(curves: pd.DataFrame, conditions: Mapping[str, float], *, simulated: bool) -> Figure:
    """mu over slip of each fit with its interval; beside it the ratios to the first fit."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve_of_fit = {str(name): curve for name, curve in curves.groupby("fit", sort=False)}
    names = list(curve_of_fit)
    first = names[0]
    for name, curve in curve_of_fit.items():
        colour = style.oil_colour(name, names)
        doubtful = (curve["outside"] | curve["over_limit"]).to_numpy()
        _draw_curve(left, curve, MU, doubtful, colour, name)
        if name != first:
            no_support = curve["ratio_support"] != Support.SUPPORTED
            ratio_doubtful = (curve["ratio_outside"] | no_support).to_numpy()
            label = name if curve["ratio_of"].iloc[0] == "runs" else f"{name}, of the two laws"
            _draw_curve(right, curve, RATIO, ratio_doubtful, colour, label)
    right.axhline(1, color=style.GREY, linewidth=0.6)
    for axis, label in ((left, style.TRACTION_LABEL), (right, f"Ratio to {first}")):
        axis.set(xlabel=style.CONDITION_LABELS[SLIP], ylabel=label)
        axis.legend()
    title = conditions_text(conditions)
    if simulated:
        title = f"SIMULATED data. {title}"
    if curves[["outside", "over_limit", "ratio_outside", "ratio_support"]].any(axis=None):
        title += _DOTTED
    figure.suptitle(title, fontsize=8)
    return figure


def _draw_curve(
    axis: Axes,
    curve: pd.DataFrame,
    columns: Sequence[str],
    doubtful: BoolArray,
    colour: str,
    label: str,
) -> None:
    """Draw a value over slip with its interval; dotted where it is doubtful."""
    value, lower, upper = (curve[column] for column in columns)
    axis.plot(curve[SLIP], value.mask(doubtful), color=colour, label=label)
    axis.plot(curve[SLIP], value.where(doubtful), ":", color=colour)
    axis.fill_between(curve[SLIP], lower, upper, color=colour, alpha=0.2, linewidth=0)
