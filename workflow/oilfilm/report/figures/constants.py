"""The table of fitted constants."""

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import QUANTITIES

_ROW_IN = 0.17
_IN_STEP = "\N{DAGGER}"


@register(
    name="constants",
    title="Fitted constants",
    caption="Fitted constants of the traction law for each oil, with their standard errors "
    "from a bootstrap over curves.",
    category="Fits",
    family="law",
    tables=("coefficients",),
    settings=("oils",),
)
def constants(results: CampaignTables, settings: Settings) -> Drawing:
    """Each oil's constants with their standard errors."""
    return draw_constants(
        results.configured.coefficients.assign(printed_value=np.nan), list(settings.oils)
    )


def draw_constants(table: pd.DataFrame, oils: Sequence[str], note: str = "") -> Drawing:
    """A table of constants, one group of columns per oil.

    Args:
        table: Table of coefficients with the column `printed_value`, which is shown where it is
            known.
        oils: Oils of the campaign.
        note: What `printed_value` is, for the lines below.
    """
    # a constant that no oil has, neither fitted nor printed, is no row
    shown = table.dropna(subset=["value", "printed_value"], how="all")
    constants = list(dict.fromkeys(shown["constant"])) or ["no constants"]
    width, letters = (
        (style.SINGLE_COLUMN_IN, 68) if len(oils) == 1 else (style.DOUBLE_COLUMN_IN, 140)
    )
    notes = [*_notes(table, shown, note)]
    notes = [line for each in notes for line in textwrap.wrap(each, letters)]
    below = 0.9 + 0.6 * len(notes)
    height_in = _ROW_IN * (len(constants) + 2.4 + below)
    figure, axis = style.page(width, height_in, bottom=len(constants) + below, top=-2.0)
    for row, constant in enumerate(constants):
        axis.text(0, row + 0.5, constant, va="center", fontweight="bold")
    left = 0.06 if len(oils) > 1 else 0.12
    span = (1 - left) / len(oils)
    for number, oil in enumerate(oils):
        rows = table[table["oil"] == oil].set_index("constant").reindex(constants)
        _draw_oil(axis, oil, style.oil_colour(oil, oils), rows, left + number * span, span)
    for line in (-1.8, 0.0, len(constants) + 0.1):
        axis.axhline(line, color="black", linewidth=0.6)
    look: dict[str, Any] = {"va": "top", "fontsize": 6, "color": style.GREY}
    axis.text(0, len(constants) + 0.5, "\n".join(notes), **look)
    about = {"oil": table["oil"], "label": table["constant"]}
    error = table["standard_error"]
    ends = {"lower": table["value"] - error, "upper": table["value"] + error}
    drawn = [marks("", "fitted", np.nan, value=table["value"], **ends, **about)]
    if shown["printed_value"].notna().any():
        drawn.append(marks("", "printed", np.nan, value=table["printed_value"], **about))
    return figure, drawn


def _notes(table: pd.DataFrame, shown: pd.DataFrame, note: str) -> Iterator[str]:
    """What the columns are, below the table."""
    errors = "s.e.: from resampling whole curves"
    if shown["standard_error"].isna().any():
        errors += "; none where there are too few"
    if (shown["verdict"] == "in step").any():
        errors += f". {_IN_STEP}: along the tested line of conditions in step"
    yield f"{errors}."
    others = []
    for law in (LAWS[name] for name in table["law"].unique()):
        powers = ", ".join(
            f"{QUANTITIES[group].symbol} over {reference:g} {QUANTITIES[group].unit}"
            for group, reference in zip(law.groups, law.reference, strict=True)
        )
        others.append(f"{law.name}: {powers}")
    if shown["printed_value"].notna().any():
        others.append(note)
    yield ". ".join(others)


def _draw_oil(
    axis: Axes, oil: str, colour: str, rows: pd.DataFrame, start: float, span: float
) -> None:
    """Three columns of one oil: fitted value, standard error, printed value if there are any."""
    columns = ["value", "standard_error", "printed_value"]
    heads = ["fitted", "\N{PLUS-MINUS SIGN} s.e.", "printed"]
    ends = [start + share * span for share in (0.29, 0.59, 0.98)]
    if rows["printed_value"].isna().all():
        columns, heads, ends = columns[:2], heads[:2], [start + 0.5 * span, start + 0.97 * span]
    axis.text(
        start + 0.53 * span, -1.3, oil, ha="center", va="center", color=colour, fontweight="bold"
    )
    for end, head in zip(ends, heads, strict=True):
        axis.text(end, -0.5, head, ha="right", va="center", color=style.GREY)
    naive = rows["naive_standard_error"].to_numpy()
    in_step = (rows["verdict"] == "in step").to_numpy()
    for height, row in enumerate(rows[columns].to_numpy(dtype=float)):
        # digits beyond the second of the error say nothing
        digits = _decimals(row[1] if not np.isnan(row[1]) else naive[height])
        for end, number, column in zip(ends, row, columns, strict=True):
            # what is printed has every digit of the print
            form = ".10g" if column == "printed_value" else f".{digits}f"
            text = "\N{EN DASH}" if np.isnan(number) else format(number, form)
            text += _IN_STEP if column == "value" and in_step[height] else ""
            text = text.replace("-", "\N{MINUS SIGN}")
            axis.text(end, height + 0.5, text, ha="right", va="center", fontsize=7)


def _decimals(error: float) -> int:
    """Decimals that show two digits of an error; 4 where there is none."""
    return 4 if np.isnan(error) or error <= 0 else int(np.clip(1 - np.floor(np.log10(error)), 0, 8))
