"""The figure of `oilfilm compare --plot`."""

import textwrap
from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from oilfilm.base.units import BoolArray
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.side_by_side import MU_COLUMNS, RATIO_COLUMNS
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import SIMULATED, Panel, Sheet
from oilfilm.surface.support import Support

_WHAT_DOTTED_MEANS = "Dotted: not tested, without support or above the limiting shear stress"
# Letters of a line of the legend's title, and of an entry of the legend.
_TITLE_LETTERS, _ENTRY_LETTERS = 110, 48


def comparison_figure(
    curves: pd.DataFrame, conditions_text: str, *, has_simulated_data: bool
) -> Figure:
    """The figure: mu over slip of each fit with its interval; beside it the ratios to the first.

    Args:
        curves: Rows of `comparison_table`.
        conditions_text: The operating point, with symbols and units.
        has_simulated_data: Whether a fit is of simulated data.
    """
    sheet = Sheet(2, 2, height=2.2, across=0.5)
    mu_panel = sheet.panel(0, "traction coefficient")
    ratio_panel = sheet.panel(1, "ratio to the first fit")
    curve_by_fit = {str(fit_name): curve for fit_name, curve in curves.groupby("fit", sort=False)}
    fit_names = list(curve_by_fit)
    first_fit_name = fit_names[0]
    handles = []
    for fit_name, curve in curve_by_fit.items():
        # fits may be of one oil: here each fit has the colour that elsewhere an oil has
        colour = style.oil_colour(fit_name, fit_names)
        is_doubtful = (curve["outside"] | curve["over_limit"]).to_numpy()
        _draw_curve(mu_panel, curve, MU_COLUMNS, is_doubtful, colour, fit_name)
        label = fit_name
        if fit_name != first_fit_name:
            lacks_support = curve["ratio_support"] != Support.SUPPORTED
            is_ratio_doubtful = (curve["ratio_outside"] | lacks_support).to_numpy()
            _draw_curve(ratio_panel, curve, RATIO_COLUMNS, is_ratio_doubtful, colour, fit_name)
            if curve["ratio_of"].iloc[0] != "runs":
                label = f"{fit_name} (ratio of the two laws)"
        handles.append(style.line_handle(_entry(label), color=colour))
    ratio_panel.axes.axhline(1, color=style.GREY, linewidth=0.6)
    sheet.label_axes(style.CONDITION_LABELS[SLIP], style.TRACTION_LABEL)
    title = conditions_text
    if curves[["outside", "over_limit", "ratio_outside", "ratio_support"]].any(axis=None):
        title += f". {_WHAT_DOTTED_MEANS}"
    sheet.legend(handles, _wrapped(title, _TITLE_LETTERS))
    for text in sheet.figure.legends[0].get_texts():
        text.set_parse_math(False)
    return sheet.finish(SIMULATED if has_simulated_data else "")


def _entry(label: str) -> str:
    """A label for the legend, which leaves out what begins with an underscore."""
    entry = _wrapped(label, _ENTRY_LETTERS)
    return f" {entry}" if entry.startswith("_") else entry


def _wrapped(text: str, letter_count: int) -> str:
    """A text in lines of at most so many letters."""
    return "\n".join(textwrap.wrap(style.plain_text(text), letter_count))


def _draw_curve(
    panel: Panel,
    curve: pd.DataFrame,
    columns: Sequence[str],
    is_doubtful: BoolArray,
    colour: str,
    fit_name: str,
) -> None:
    """Draw a value over slip with its interval; dotted where it is doubtful."""
    value, lower, upper = (curve[column] for column in columns)
    look: dict[str, Any] = {"color": colour}
    panel.line(fit_name, curve[SLIP], value.mask(is_doubtful), look, lower=lower, upper=upper)
    panel.axes.plot(curve[SLIP], value.where(is_doubtful), ":", **look)
