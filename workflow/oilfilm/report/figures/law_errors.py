"""Errors of all laws compared, and their traction at zero slip."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.fits.problem import curve_data
from oilfilm.report.captions import tie
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_MU = "\N{GREEK SMALL LETTER MU}"
WANG_DENG = "wang-deng"  # how the names of its readings begin
OURS = "Wang-Deng laws: groups and readings are ours."
_OPEN = "Open symbols: fit not certified (table comparison says why)."
_ROW_IN = 0.34
_ENDS = ("pressure", "speed", "temperature")
# Kinds of error, from those on the fitted curves themselves to the farthest: how each is drawn.
_KINDS: dict[str, dict[str, Any]] = {
    "fitted curves": {"marker": "o", "markersize": 3.4},
    "curve left out": {"marker": "D", "markersize": 3.4},
    "end level left out": {"marker": "^", "markersize": 4},
}


@register(
    name="law-errors",
    title="Laws at zero slip and on data left out",
    caption="(a) Traction coefficient at zero slip by each law, at every tested condition. "
    "(b) Relative error of each law on fitted curves, on curves left out, and on the lowest and "
    "highest levels left out. Open symbols: fit not certified; constants at a bound are named.",
    category="Fits",
    family="law",
    tables=("points", "fit_quality", "coefficients"),
    settings=("oils", "rigs"),
    compares_laws=True,
)
def law_errors(results: CampaignTables, settings: Settings) -> Drawing:
    """Above, mu at no slip of the laws that allow it; below, each law's errors, seen and unseen."""
    compared, oils = results.fit_quality.dropna(subset="rmse"), list(settings.oils)
    laws = list(dict.fromkeys(compared["law"]))
    starting = list(compared.loc[compared["zero_slip_traction"] != 0, "law"].unique())
    heights = (1.6, _ROW_IN * max(len(laws), 1) + 0.5)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, sum(heights) + 0.9))
    above, below = figure.subplots(2, 1, height_ratios=heights)
    drawn = [
        *_drawstarts_of(above, results, settings, compared, starting),
        *_draw_errors(below, compared, oils),
    ]
    if not drawn:
        style.say_in_panel(above, "no law could be fitted")
    elif not starting:
        style.say_in_panel(above, "every law that was compared has no traction without slip")
    title = "Traction without slip at the tested conditions, cold to hot; other laws: 0"
    style.title_panel(above, 0, title)
    above.set_ylabel(f"{_MU} at S = 0 (10$^{{-3}}$)")
    title = (
        f"Rms error over rms of {_MU}; left out: a curve, or the lowest and highest level of P, U "
        "or T"
    )
    style.title_panel(below, 1, title)
    below.set_xlabel(f"Rms error over rms of measured {_MU}")
    handles: list[Any] = [
        Patch(color=style.oil_colour(oil, oils), label=oil)
        for oil in oils
        if oil in set(compared["oil"])
    ]
    handles += [
        style.symbol_handle(kind, color="black", markerfacecolor="white", **look)
        for kind, look in _KINDS.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=6)
    ours = OURS if any(law.startswith(WANG_DENG) for law in laws) else ""
    style.say_key(figure, " ".join(filter(None, (_OPEN, ours, tie(settings.campaign)))))
    return figure, drawn


def _drawstarts_of(
    axis: Axes,
    results: CampaignTables,
    settings: Settings,
    compared: pd.DataFrame,
    laws: Sequence[str],
) -> Iterator[pd.DataFrame]:
    """A cloud per law and oil: mu at zero slip at each condition, spread along the abscissa."""
    oils = list(settings.oils)
    axis.axhline(0, color="black", linewidth=0.8)
    for fit in tables.rows(compared[compared["law"].isin(laws)]):
        y = starts_of(results, fit["oil"], fit["law"], settings)["y"].to_numpy()
        apart = min(0.26, 0.8 / len(oils))
        middle = laws.index(fit["law"]) + apart * (oils.index(fit["oil"]) - (len(oils) - 1) / 2)
        x = middle + np.linspace(-0.35, 0.35, len(y)) * apart
        axis.plot(x, 1e3 * y, **symbol_of(fit["oil"], settings, fit), markeredgewidth=0.5)
        yield marks("a", "zero slip", x, y, oil=fit["oil"], label=_label(fit))
    axis.set_xticks(range(len(laws)), laws)
    axis.set_xlim(-0.5, max(len(laws), 1) - 0.5)
    axis.grid(visible=False, axis="x")


def starts_of(results: CampaignTables, oil: str, law_name: str, settings: Settings) -> pd.DataFrame:
    """mu at no slip of each curve (`run_id`, `y`), in the order of rising temperature."""
    fits = results.coefficients
    of_fit = (fits["oil"] == oil) & (fits["law"] == law_name)
    if fits.loc[of_fit, "value"].isna().all():
        return pd.DataFrame({"run_id": [], "y": []})
    law = laws_of(oil, settings)[law_name]
    data = curve_data(results.points[results.points["oil"] == oil], law.conditions)
    fitted = FittedLaw.of(fits, oil, law=law)
    y = fitted.predict(data.conditions, np.zeros(len(data.runs))).traction_coefficient
    order = np.argsort(data.conditions[:, -1])
    return pd.DataFrame({"run_id": data.runs, "y": y}).iloc[order]


def _draw_errors(axis: Axes, compared: pd.DataFrame, oils: Sequence[str]) -> Iterator[pd.DataFrame]:
    """One row per law, one line per oil from the smallest of its errors to the largest."""
    laws = list(dict.fromkeys(compared["law"]))
    for fit in tables.rows(compared):
        apart = min(0.24, 0.8 / len(oils))  # rows of many oils stay within those of their law
        height = laws.index(fit["law"]) + apart * (oils.index(fit["oil"]) - (len(oils) - 1) / 2)
        colour = style.oil_colour(fit["oil"], oils)
        face = colour if fit["certified"] else "white"
        left_out = fit["left_out_rmse"] * fit["relative_rms"] / fit["rmse"]
        ends = [fit[f"{end}_end_out_relative_rms"] for end in _ENDS]
        errors = dict(zip(_KINDS, ([fit["relative_rms"]], [left_out], ends), strict=True))
        every = np.concatenate(list(errors.values()))
        axis.plot([np.nanmin(every), np.nanmax(every)], [height] * 2, color=colour, linewidth=0.6)
        for kind, values in errors.items():
            look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "linestyle": ""}
            axis.plot(values, [height] * len(values), **look, **_KINDS[kind])
            about = {"oil": fit["oil"], "label": _label(fit)}
            yield marks("b", kind, values, height, **about).dropna(subset="x")
    axis.set_yticks(range(len(laws)), [_with_bounds(compared, law) for law in laws])
    axis.set_ylim(len(laws) - 0.45, -0.55)
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    # decimals as each level needs them: 0.2 %, 100 %
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:.3g}%"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(visible=False, axis="y")


def _with_bounds(compared: pd.DataFrame, law: str) -> str:
    """Name of a law, with the constants that ended at a bound for any oil below it."""
    bounds = compared.loc[compared["law"] == law, "active_bounds"]
    names = dict.fromkeys(name for joined in bounds if joined for name in joined.split(", "))
    return f"{law}\n(at bounds: {', '.join(names)})" if names else law


def symbol_of(oil: str, settings: Settings, fit: Mapping[str, Any]) -> dict[str, Any]:
    """Symbol of an oil, open where the fit is not certified."""
    oils = list(settings.oils)
    colour = style.oil_colour(oil, oils)
    face = colour if fit["certified"] else "white"
    marker = style.oil_marker(oil, oils)
    return {"color": colour, "marker": marker, "markerfacecolor": face, "linestyle": ""}


def _label(fit: Mapping[str, Any]) -> str:
    """A law, and where it is so that its fit has no certificate."""
    return str(fit["law"]) if fit["certified"] else f"{fit['law']}, not certified"
