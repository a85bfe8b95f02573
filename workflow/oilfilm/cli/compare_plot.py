"""The figure of `oilfilm compare --plot`."""

from collections.abc import Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.base.units import BoolArray
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.side_by_side import MU_COLUMNS, RATIO_COLUMNS
from oilfilm.report.figures import style
from oilfilm.surface.support import Support

_WHAT_DOTTED_MEANS = ". Dotted: not tested, without support or above the limiting shear stress"


def comparison_figure(
    curves: pd.DataFrame, conditions_text: str, *, has_simulated_data: bool
) -> Figure:
    """The figure: mu over slip of each fit with its interval; beside it the ratios to the first.

    Args:
        curves: Rows of `comparison_table`.
        conditions_text: The operating point, with symbols and units.
        has_simulated_data: Whether a fit is of simulated data.
    """
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.9), layout="constrained")
    mu_axes, ratio_axes = figure.subplots(1, 2)
    curve_by_fit = {str(fit_name): curve for fit_name, curve in curves.groupby("fit", sort=False)}
    fit_names = list(curve_by_fit)
    first_fit_name = fit_names[0]
    for fit_name, curve in curve_by_fit.items():
        # fits may be of one oil: here each fit has the colour that elsewhere an oil has
        colour = style.oil_colour(fit_name, fit_names)
        is_doubtful = (curve["outside"] | curve["over_limit"]).to_numpy()
        _draw_curve(mu_axes, curve, MU_COLUMNS, is_doubtful, colour, fit_name)
        if fit_name != first_fit_name:
            lacks_support = curve["ratio_support"] != Support.SUPPORTED
            is_ratio_doubtful = (curve["ratio_outside"] | lacks_support).to_numpy()
            is_ratio_of_runs = curve["ratio_of"].iloc[0] == "runs"
            label = fit_name if is_ratio_of_runs else f"{fit_name}, of the two laws"
            _draw_curve(ratio_axes, curve, RATIO_COLUMNS, is_ratio_doubtful, colour, label)
    ratio_axes.axhline(1, color=style.GREY, linewidth=0.6)
    ratio_label = f"Ratio to {first_fit_name}"
    for axes, label in ((mu_axes, style.TRACTION_LABEL), (ratio_axes, ratio_label)):
        axes.set(xlabel=style.CONDITION_LABELS[SLIP], ylabel=label)
        axes.legend()
    title = conditions_text
    if has_simulated_data:
        title = f"SIMULATED data. {title}"
    if curves[["outside", "over_limit", "ratio_outside", "ratio_support"]].any(axis=None):
        title += _WHAT_DOTTED_MEANS
    figure.suptitle(title, fontsize=8)
    return figure


def _draw_curve(
    axes: Axes,
    curve: pd.DataFrame,
    columns: Sequence[str],
    is_doubtful: BoolArray,
    colour: str,
    label: str,
) -> None:
    """Draw a value over slip with its interval; dotted where it is doubtful."""
    value, lower, upper = (curve[column] for column in columns)
    axes.plot(curve[SLIP], value.mask(is_doubtful), color=colour, label=label)
    axes.plot(curve[SLIP], value.where(is_doubtful), ":", color=colour)
    axes.fill_between(curve[SLIP], lower, upper, color=colour, alpha=0.2, linewidth=0)
