"""What the fits are worth: constants, how well data tell them apart, errors of all laws."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import LogLocator, NullFormatter

from oilfilm import tables
from oilfilm.fits.fit import laws_of
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.report.document import number, significant
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import (
    NothingToDrawError,
    Panel,
    Sheet,
    oil_grid,
    register,
    table_page,
)
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import QUANTITIES, Law

_ROW_IN = 0.17
_ENDS = ("pressure", "speed", "temperature")
# Kinds of error, from those on the fitted curves themselves to the farthest: how each is drawn.
_KINDS: dict[str, style.Look] = {
    "fitted curves": {"marker": "o", "markersize": 3.4},
    "curve left out": {"marker": "D", "markersize": 3.4},
    "end level left out": {"marker": "^", "markersize": 4},
}


@register(family="law", tables=("coefficients",), settings=("oils",))
def constants(results: CampaignTables, settings: Settings) -> Sheet:
    """Fitted constants.

    Fitted constants of the traction law for each oil, with their standard errors from a
    bootstrap over curves; none where there are too few.
    """
    table = results.configured.coefficients.assign(printed_value=np.nan)
    return draw_constants(table, list(settings.oils))


def draw_constants(table: pd.DataFrame, oils: Sequence[str], note: str = "") -> Sheet:
    """A table of constants, one group of columns per oil.

    Args:
        table: Table of coefficients with the column `printed_value`, which is shown where it is
            known.
        oils: Oils of the campaign.
        note: What `printed_value` is, for the lines below.
    """
    # a constant that no oil has, neither fitted nor printed, is no row
    shown = table.dropna(subset=["value", "printed_value"], how="all")
    names = list(dict.fromkeys(shown["constant"])) or ["no constants"]
    any_printed = bool(shown["printed_value"].notna().any())
    left = 0.12 if len(oils) == 1 else 0.06
    span = (1 - left) / len(oils)
    width = style.SINGLE_COLUMN_IN if len(oils) == 1 else style.DOUBLE_COLUMN_IN
    notes = [_powers(LAWS[name]) for name in table["law"].unique()]
    notes += [note] if any_printed else []
    sheet, panel, write = table_page(width, len(names), _ROW_IN, 2 * _ROW_IN, notes)
    write(0, "", names, fontweight="bold")
    for place, oil in enumerate(oils):
        name: style.Look = {"color": style.oil_colour(oil, oils), "fontweight": "bold"}
        write(left + (place + 0.53) * span, f"{oil}\n", [], ha="center", **name)
        rows = table[table["oil"] == oil].set_index("constant").reindex(names)
        for share, (head, texts) in _of_oil(rows).items():
            at, grey = left + (place + share) * span, {"color": style.GREY}
            write(at, f"\n{head}", texts, grey, ha="right")
    about = {"oil": table["oil"], "label": table["constant"]}
    error = table["standard_error"]
    ends = {"lower": table["value"] - error, "upper": table["value"] + error}
    panel.keep("fitted", np.nan, value=table["value"], **ends, **about)
    if any_printed:
        panel.keep("printed", np.nan, value=table["printed_value"], **about)
    return sheet


def _powers(law: Law) -> str:
    """What the constants of a law are powers of."""
    powers = ", ".join(
        f"{QUANTITIES[group].symbol} over {reference:g} {QUANTITIES[group].unit}"
        for group, reference in zip(law.groups, law.reference, strict=True)
    )
    return f"{law_name(law.name)}: {powers}"


def _of_oil(rows: pd.DataFrame) -> dict[float, tuple[str, list[str]]]:
    """Head and texts of each column of one oil, by its place within the oil's width."""
    # digits beyond the second of the error say nothing
    forms = list(map(significant, rows["standard_error"].fillna(rows["naive_standard_error"])))

    def texts(column: str, forms: Sequence[str]) -> list[str]:
        return [number(form)(value) for value, form in zip(rows[column], forms, strict=True)]

    fitted = "fitted", texts("value", forms)
    errors = "\N{PLUS-MINUS SIGN} s.e.", texts("standard_error", forms)
    if rows["printed_value"].isna().all():
        return {0.5: fitted, 0.97: errors}
    # what is printed has every digit of the print
    printed = "printed", texts("printed_value", [".10g"] * len(rows))
    return {0.29: fitted, 0.59: errors, 0.98: printed}


@register(family="law", tables=("correlations",), settings=("oils",))
def identifiability(results: CampaignTables, settings: Settings) -> Sheet:
    """Identifiability of the constants.

    Correlation of each pair of constants, by the bootstrap over curves or, with too few curves,
    by the Jacobian. Near 1 or -1 the two constants replace each other.
    """
    correlations = results.configured.correlations
    sheet, panels = oil_grid(
        style.oils_in(correlations, settings),
        "No oil has a fit.",
        width=style.DOUBLE_COLUMN_IN,
        height=1.55,
        across=0.4,
        right=0.8,
        sharex=False,
        sharey=False,
    )
    for panel, _, oil in panels:
        pairs = correlations[correlations["oil"] == oil]
        names = list(dict.fromkeys([*pairs["constant"], *pairs["other"]]))
        field = pairs.pivot(index="other", columns="constant", values="correlation")
        # from orange by white to purple, distinct for every kind of colour vision
        squares = field.reindex(index=names, columns=names).to_numpy(dtype=float)
        image = panel.axis.imshow(squares, cmap="PuOr", vmin=-1, vmax=1)
        panel.axis.set_xticks(range(len(names)), names, rotation=90, fontsize=6)
        panel.axis.set_yticks(range(len(names)), names, fontsize=6)
        panel.axis.grid(False)
        panel.axis.tick_params(length=0)
        label = pairs["constant"] + ", " + pairs["other"]
        panel.keep("correlation", np.nan, oil=oil, label=label, value=pairs["correlation"])
    sheet.colour_bar(image, "Correlation")
    return sheet


@register(family="law", tables=("fit_quality",), settings=("oils",))
def law_errors(results: CampaignTables, settings: Settings) -> Sheet:
    """Errors of the laws.

    Rms error of each law over the rms of the measured traction coefficient: on fitted curves, on
    curves left out, and on the lowest and highest levels of pressure, speed and temperature left
    out. Open symbols: fit not certified (the table of the comparison says why). The groups and
    readings of the Wang-Deng laws are ours.
    """
    compared, oils = results.fit_quality.dropna(subset="rmse"), list(settings.oils)
    laws = list(dict.fromkeys(compared["law"]))
    if not laws:
        raise NothingToDrawError("no law could be fitted")
    sheet = Sheet(width=style.DOUBLE_COLUMN_IN, left=1.75, height=0.34 * len(laws) + 0.1)
    panel = sheet.panel(title=None)
    for fit in tables.rows(compared):
        # laws are apart by one, their oils by so much that many stay within their law
        among = oils.index(fit["oil"]) - (len(oils) - 1) / 2
        _draw_errors(panel, fit, laws.index(fit["law"]) + among * min(0.24, 0.8 / len(oils)), oils)
    axis = panel.axis
    axis.set_yticks(range(len(laws)), map(law_name, laws))
    axis.set(ylim=(len(laws) - 0.45, -0.55), xscale="log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    # decimals as each level needs them: 0.2 %, 100 %
    axis.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.3g}%")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(visible=False, axis="y")
    axis.set_xlabel(f"Rms error over rms of measured {style.MU}")
    white: style.Look = {"color": "black", "markerfacecolor": "white", "linestyle": ""}
    kinds = [style.line_handle(kind, **white, **look) for kind, look in _KINDS.items()]
    sheet.legend([*style.oil_patches(style.oils_in(compared, settings), oils), *kinds])
    return sheet


def starts_of(results: CampaignTables, oil: str, law_key: str, settings: Settings) -> pd.DataFrame:
    """mu at no slip of each curve (`run_id`, `y`), in the order of rising temperature."""
    fits = results.coefficients
    of_fit = (fits["oil"] == oil) & (fits["law"] == law_key)
    if fits.loc[of_fit, "value"].isna().all():
        return pd.DataFrame({"run_id": [], "y": []})
    law = laws_of(oil, settings)[law_key]
    data = curve_data(results.points[results.points["oil"] == oil], law.conditions)
    fitted = FittedLaw.of(fits, oil, law=law)
    y = fitted.predict(data.conditions, np.zeros(len(data.runs))).traction_coefficient
    order = np.argsort(data.conditions[:, -1])
    return pd.DataFrame({"run_id": data.runs, "y": y}).iloc[order]


def _draw_errors(panel: Panel, fit: Mapping[str, Any], height: float, oils: Sequence[str]) -> None:
    """Each kind of error of one fit, on a line from the smallest to the largest."""
    colour = style.oil_colour(fit["oil"], oils)
    left_out = fit["left_out_rmse"] * fit["relative_rms"] / fit["rmse"]
    ends = [fit[f"{end}_end_out_relative_rms"] for end in _ENDS]
    errors = [fit["relative_rms"]], [left_out], ends
    line = [np.nanmin(np.concatenate(errors)), np.nanmax(np.concatenate(errors))]
    panel.axis.plot(line, [height] * 2, color=colour, linewidth=0.6)
    face = {"color": colour, "markerfacecolor": colour if fit["certified"] else "white"}
    label = fit["law"] if fit["certified"] else f"{fit['law']}, not certified"
    for (kind, look), values in zip(_KINDS.items(), errors, strict=True):
        known = np.array(values)[~np.isnan(values)]
        panel.dots(
            kind, known, np.full(len(known), height), face | look, oil=fit["oil"], label=label
        )


def symbol_of(fit: Mapping[str, Any], oils: Sequence[str]) -> style.Look:
    """Symbol of an oil, open where the fit is not certified."""
    look = style.oil_look(fit["oil"], oils)
    face = look["color"] if fit["certified"] else "white"
    return {**look, "markerfacecolor": face, "linestyle": ""}
