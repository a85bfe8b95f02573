"""What the fits are worth: constants, how well data tell them apart, errors of all laws."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import LogLocator, NullFormatter

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
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
from oilfilm.traction.law import QUANTITIES

_ROW_IN = 0.17
_IN_STEP = "\N{DAGGER}"
_REACH = 4.5  # naive standard errors to either side of a profile
_BENT = 0.05  # of them, by which a profile that is named bends at least
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
    bootstrap over curves.
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
    notes = [*_notes(table, shown), *([note] if any_printed else [])]
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


def _notes(table: pd.DataFrame, shown: pd.DataFrame) -> Iterator[str]:
    """What the columns are, below the table."""
    errors = "s.e.: from resampling whole curves"
    if shown["standard_error"].isna().any():
        errors += "; none where there are too few"
    if (shown["verdict"] == "in step").any():
        errors += f". {_IN_STEP}: along the tested line of conditions in step"
    yield f"{errors}."
    for law in (LAWS[name] for name in table["law"].unique()):
        powers = ", ".join(
            f"{QUANTITIES[group].symbol} over {reference:g} {QUANTITIES[group].unit}"
            for group, reference in zip(law.groups, law.reference, strict=True)
        )
        yield f"{law_name(law.name)}: {powers}"


def _of_oil(rows: pd.DataFrame) -> dict[float, tuple[str, list[str]]]:
    """Head and texts of each column of one oil, by its place within the oil's width."""
    # digits beyond the second of the error say nothing
    forms = list(map(significant, rows["standard_error"].fillna(rows["naive_standard_error"])))

    def texts(column: str, forms: Sequence[str]) -> list[str]:
        return [number(form)(value) for value, form in zip(rows[column], forms, strict=True)]

    in_step = np.where(rows["verdict"] == "in step", _IN_STEP, "")
    fitted = "fitted", list(map("".join, zip(texts("value", forms), in_step, strict=True)))
    errors = "\N{PLUS-MINUS SIGN} s.e.", texts("standard_error", forms)
    if rows["printed_value"].isna().all():
        return {0.5: fitted, 0.97: errors}
    # what is printed has every digit of the print
    printed = "printed", texts("printed_value", [".10g"] * len(rows))
    return {0.29: fitted, 0.59: errors, 0.98: printed}


@register(
    family="law",
    tables=("coefficients", "correlations", "profiles"),
    settings=("oils",),
)
def identifiability(results: CampaignTables, settings: Settings) -> Sheet:
    """Identifiability of the constants.

    Top: correlation of each pair of constants, by the bootstrap over curves or, with too few
    curves, by the Jacobian. Bottom: profile of each constant. Ordinate: signed root of the rise
    of the squared error. Abscissa: distance from the optimum in standard errors of independent
    points. A straight line marks a well-determined constant; the two that bend most are named.
    """
    results, every = results.configured, list(settings.oils)
    oils = style.oils_in(results.profiles, settings)
    side = (style.DOUBLE_COLUMN_IN - 1.45 - 0.4 * (len(oils) - 1)) / max(len(oils), 2)
    layout: style.Look = {"height": (side, side), "across": 0.4, "down": 0.62, "right": 0.8}
    layout |= {"width": style.DOUBLE_COLUMN_IN, "sharex": False, "sharey": False}
    kinds = ("correlations", "profiles")
    sheet, panels = oil_grid(oils, "No oil has a fit with profiles.", kinds, **layout)
    for panel, kind, oil in panels:
        coefficients, correlations, profiles = (
            table[table["oil"] == oil]
            for table in (results.coefficients, results.correlations, results.profiles)
        )
        if kind == "profiles":
            _draw_profiles(panel, profiles, coefficients, oil, every)
            continue
        if coefficients["standard_error"].isna().all():
            panel.axis.set_title(f"{panel.axis.get_title(loc='left')}, by the Jacobian")
        names = list(profiles["constant"].unique())
        image = _draw_correlations(panel, correlations, names, oil)
    sheet.colour_bar(image, "Correlation")
    sheet.axes[len(oils)].set_ylabel("Signed root of the rise\nof the squared error")
    below = sheet.axes[len(oils) + len(oils) // 2]
    below.set_xlabel("Distance from the fit in naive standard errors")
    return sheet


def _draw_correlations(panel: Panel, pairs: pd.DataFrame, names: list[str], oil: str) -> Any:
    """One square per pair below the diagonal; each pair is in the table once."""
    field = np.full((len(names), len(names)), np.nan)
    for row in tables.rows(pairs):
        column, line = sorted(names.index(row[name]) for name in ("constant", "other"))
        field[line, column] = row["correlation"]
    # from orange by white to purple, distinct for every kind of colour vision
    image = panel.axis.imshow(field, cmap="PuOr", vmin=-1, vmax=1)
    panel.axis.set_xticks(range(len(names)), names, rotation=90, fontsize=6)
    panel.axis.set_yticks(range(len(names)), names, fontsize=6)
    panel.axis.grid(False)
    panel.axis.tick_params(length=0)
    label = pairs["constant"] + ", " + pairs["other"]
    panel.keep("correlation", np.nan, oil=oil, label=label, value=pairs["correlation"])
    return image


def _draw_profiles(
    panel: Panel, profiles: pd.DataFrame, fitted: pd.DataFrame, oil: str, oils: Sequence[str]
) -> None:
    """Profiles over the distance from the fit, in naive standard errors."""
    panel.axis.axline((0, 0), slope=1, color=style.GREY, linewidth=0.6)
    lines = profiles.merge(fitted, on="constant", suffixes=("", "_fitted"))
    distance = (lines["value"] - lines["value_fitted"]) / lines["naive_standard_error"]
    for constant, line in lines.assign(distance=distance).groupby("constant", sort=False):
        look: style.Look = {"color": style.oil_colour(oil, oils), "linewidth": 0.7}
        x, y = line["distance"], line["signed_root"]
        panel.line("profile", x, y, look, oil=oil, label=constant)
    panel.axis.set(xlim=(-_REACH, _REACH), ylim=(-_REACH, _REACH), aspect="equal")
    off = (lines["signed_root"] - distance).abs().groupby(lines["constant"]).max()
    most = off[off > _BENT].nlargest(2)
    labels = [f"{name}: off the line by {bend:.2g}" for name, bend in most.items()]
    place: style.Look = {"va": "top", "fontsize": 6, "transform": panel.axis.transAxes}
    panel.axis.text(0.03, 0.97, "\n".join(labels), **place)


@register(
    family="law",
    tables=("fit_quality",),
    settings=("oils",),
)
def law_errors(results: CampaignTables, settings: Settings) -> Sheet:
    """Errors of the laws.

    Rms error of each law over the rms of the measured traction coefficient: on fitted curves, on
    curves left out, and on the lowest and highest levels of pressure, speed and temperature left
    out. Open symbols: fit not certified (the table of the comparison says why); constants at a
    bound are named. The groups and readings of the Wang-Deng laws are ours.
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
    axis.set_yticks(range(len(laws)), [_with_bounds(compared, law) for law in laws])
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


def _with_bounds(compared: pd.DataFrame, law: str) -> str:
    """Name of a law, with the constants that ended at a bound for any oil below it."""
    bounds = compared.loc[compared["law"] == law, "active_bounds"]
    names = dict.fromkeys(name for joined in bounds if joined for name in joined.split(", "))
    return f"{law_name(law)}\n(at bounds: {', '.join(names)})" if names else law_name(law)


def symbol_of(fit: Mapping[str, Any], oils: Sequence[str]) -> style.Look:
    """Symbol of an oil, open where the fit is not certified."""
    look = style.oil_look(fit["oil"], oils)
    face = look["color"] if fit["certified"] else "white"
    return {**look, "markerfacecolor": face, "linestyle": ""}
