"""What the paper says of the Wang-Deng law: traction without slip, and overfitting (Fig. 4)."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from oilfilm import tables
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.fitting.problem import curve_data
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.resolved import Settings
from oilfilm.studies.law_comparison import laws_of
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use

_ROW_IN = 0.34
_ENDS = ("pressure", "speed", "temperature")
_LOOK: dict[str, Any] = {"markersize": 3.4, "linestyle": "none"}
# Kinds of error, from those on the fitted curves themselves to the farthest: how each is drawn.
_KINDS: dict[str, dict[str, Any]] = {
    "fitted curves": _LOOK | {"marker": "o", "markerfacecolor": "white"},
    "curve left out": _LOOK | {"marker": "o"},
    "end level left out": _LOOK | {"marker": "|", "markersize": 7, "markeredgewidth": 1.4},
}

_LAW_PANELS = drawn_table(
    "law_panels",
    "Drawn in the figure of the laws' weaknesses (Fig. 4).",
    columns="panel law oil kind x y",
    uses=(
        use(
            "kind",
            "zero slip: mu at zero slip at a tested condition; the others: error of a law over mu",
            allowed=("zero slip", "fitted curves", "curve left out", "end level left out"),
        ),
        use("y", "of errors: position of the row", required=True),
    ),
)


@register(
    name="fig04",
    paper="Fig. 4",
    title="Laws at zero slip and on data left out",
    caption="(a) Traction coefficient at zero slip by each law, at every tested condition. (b) "
    "Relative error of each law on fitted curves, on curves left out, and on the lowest and "
    "highest levels left out.",
    family="law",
    tables=("points", "comparison", "law_coefficients"),
    settings=("oils", "rigs"),
    draws=_LAW_PANELS,
)
def fig04(results: CampaignTables, settings: Settings) -> Drawing:
    """Above, mu at no slip of the laws that allow it; below, each law's errors, seen and unseen."""
    compared, oils = results.comparison.dropna(subset="rmse"), list(settings.oils)
    laws = list(dict.fromkeys(compared["law"]))
    starting = list(compared.loc[compared["zero_slip_traction"] != 0, "law"].unique())
    heights = (1.6, _ROW_IN * max(len(laws), 1) + 0.5)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, sum(heights) + 0.9))
    above, below = figure.subplots(2, 1, height_ratios=heights)
    drawn = [
        *_draw_starts(above, results, settings, starting),
        *_draw_errors(below, compared, oils),
    ]
    if not drawn:
        style.say_in_panel(above, "no law could be fitted")
    elif not starting:
        style.say_in_panel(above, "every law that was compared has no traction without slip")
    title = "Traction without slip at the tested conditions, cold to hot; other laws: 0"
    style.title_panel(above, 0, title)
    above.set_ylabel("\N{GREEK SMALL LETTER MU} at S = 0 (10$^{-3}$)")
    title = (
        "Rms error over rms of \N{GREEK SMALL LETTER MU}; left out: a curve, or the lowest and "
        "highest level of P, U or T"
    )
    style.title_panel(below, 1, title)
    below.set_xlabel("Rms error over rms of measured \N{GREEK SMALL LETTER MU}")
    handles = style.oil_handles(oils, set(compared["oil"]), linewidth=0.8)
    handles += [style.line_handle(kind, color="black", **look) for kind, look in _KINDS.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=6)
    if any(law.startswith("wang-deng") for law in laws):
        style.say_key(figure, "Wang-Deng laws: groups and readings are ours")
    return figure, drawn


def _draw_starts(
    axis: Axes, results: CampaignTables, settings: Settings, laws: Sequence[str]
) -> Iterator[pd.DataFrame]:
    """A cloud per law and oil: mu at zero slip at each condition, spread along the abscissa."""
    oils = list(settings.oils)
    axis.axhline(0, color="black", linewidth=0.8)
    for (column, law), (number, oil) in itertools.product(enumerate(laws), enumerate(oils)):
        y = _starts(results, oil, law, settings)
        apart = min(0.26, 0.8 / len(oils))
        middle = column + apart * (number - (len(oils) - 1) / 2)
        x = middle + np.linspace(-0.35, 0.35, len(y)) * apart
        axis.plot(x, 1e3 * y, style.oil_marker(oil, oils), color=style.oil_colour(oil, oils))
        about = {"panel": "a", "law": law, "oil": oil, "kind": "zero slip"}
        yield pd.DataFrame({"x": x, "y": y}).assign(**about)
    axis.set_xticks(range(len(laws)), laws)
    axis.set_xlim(-0.5, max(len(laws), 1) - 0.5)
    axis.grid(visible=False, axis="x")


def _starts(results: CampaignTables, oil: str, law_name: str, settings: Settings) -> Any:
    """mu at no slip, condition by condition in the order of rising temperature."""
    fits = results.law_coefficients
    of_fit = (fits["oil"] == oil) & (fits["law"] == law_name)
    if fits.loc[of_fit, "value"].isna().all():
        return np.empty(0)
    law = laws_of(oil, settings)[law_name]
    of_oil = results.points[results.points["oil"] == oil]
    data = curve_data(of_oil, law.conditions)
    conditions = data.conditions[np.argsort(data.conditions[:, -1])]
    fitted = FittedLaw.of(fits, oil, law=law)
    return fitted.predict(conditions, np.zeros(len(conditions))).traction_coefficient


def _draw_errors(axis: Axes, compared: pd.DataFrame, oils: Sequence[str]) -> Iterator[pd.DataFrame]:
    """One row per law, one line per oil from the smallest of its errors to the largest."""
    laws = list(dict.fromkeys(compared["law"]))
    for fit in tables.rows(compared):
        apart = min(0.24, 0.8 / len(oils))  # rows of many oils stay within those of their law
        height = laws.index(fit["law"]) + apart * (oils.index(fit["oil"]) - (len(oils) - 1) / 2)
        colour = style.oil_colour(fit["oil"], oils)
        left_out = fit["left_out_rmse"] * fit["relative_rms"] / fit["rmse"]
        ends = [fit[f"{end}_end_out_relative_rms"] for end in _ENDS]
        errors = dict(zip(_KINDS, ([fit["relative_rms"]], [left_out], ends), strict=True))
        every = np.concatenate(list(errors.values()))
        axis.plot([np.nanmin(every), np.nanmax(every)], [height] * 2, color=colour, linewidth=0.6)
        for kind, values in errors.items():
            axis.plot(values, [height] * len(values), color=colour, **_KINDS[kind])
            about = {"panel": "b", "law": fit["law"], "oil": fit["oil"], "kind": kind}
            yield pd.DataFrame({"x": values, "y": height}).assign(**about).dropna(subset="x")
    axis.set_yticks(range(len(laws)), laws)
    axis.set_ylim(len(laws) - 0.45, -0.55)
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    # decimals as each level needs them: 0.2 %, 100 %
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:.3g}%"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(visible=False, axis="y")
