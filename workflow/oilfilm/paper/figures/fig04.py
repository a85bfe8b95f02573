"""The Wang-Deng law as the paper shows it: Fig. 4."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.report.captions import tie
from oilfilm.report.figures import style
from oilfilm.report.figures.law_errors import OURS, WANG_DENG, starts_of, symbol_of
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import DENG2026

_MU = "\N{GREEK SMALL LETTER MU}"
_TIMES = "\N{MULTIPLICATION SIGN} 10$^{-3}$"
_DASHES: dict[str, Any] = {"fit": "-", "left out": (0, (4, 2)), "Eq. 7": ":"}


@register(
    name="fig04",
    paper="Fig. 4",
    title="The Wang-Deng law at zero slip and on a curve left out",
    caption="Measured traction coefficient against slide-roll ratio, and the Wang-Deng law "
    "fitted to the same oil. Each oil has one curve, chosen by a rule among all tested curves "
    "and all versions of the law. (a) Curve with the largest traction coefficient at zero slip; "
    "below: detail near zero slip. (b) Curve whose rms error grows most when the fit leaves it "
    "out; below: the errors. Full lines: fit to all curves. Dashed lines: fit without this "
    "curve. Dotted lines: law of the paper (Eq. 7), fitted without this curve. Symbols: plateau "
    "means with the 95 % interval of their random error.",
    family="law",
    tables=("points", "fit_quality", "coefficients", "law_points"),
    settings=("oils", "rigs"),
    compares_laws=True,
)
def fig04(results: CampaignTables, settings: Settings) -> Drawing:
    """Left, the largest traction without slip; right, the largest growth of an error."""
    fits = results.fit_quality.dropna(subset="rmse")
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 5.2))
    ((whole, near), (unseen, errors)) = figure.subplots(2, 2, height_ratios=(1.15, 1)).T
    style.title_panel(whole, 0, f"Curve with the largest |{_MU}(0)|")
    near.set_title("    near S = 0")
    # numbers of many decimals: few of them fit
    near.xaxis.set_major_locator(MaxNLocator(4))
    style.title_panel(unseen, 1, "Curve with the largest growth of error")
    errors.set_title("    fitted minus measured")
    drawn: list[pd.DataFrame] = []
    for oil in settings.oils:
        of_oil = fits[fits["oil"] == oil].set_index("law", drop=False)
        drawn += _draw_zero_slip(whole, near, oil, of_oil, results, settings)
        drawn += _draw_left_out(unseen, errors, oil, of_oil, results, settings)
    for above, below in ((whole, near), (unseen, errors)):
        if below.get_legend_handles_labels()[0]:
            below.legend(loc="upper left", bbox_to_anchor=(-0.12, -0.25), fontsize=6)
        else:
            style.say_in_panel(above, "no Wang-Deng law could be fitted")
        below.set_xlabel(style.CONDITION_LABELS["slide_roll_ratio"])
    _zoom(near, drawn)
    whole.set_ylabel(style.TRACTION_LABEL)
    near.set_ylabel(f"{_MU} (10$^{{-3}}$)")
    errors.set_ylabel(f"\N{GREEK CAPITAL LETTER DELTA}{_MU} (10$^{{-3}}$)")
    figure.legend(handles=_key_of_lines(), loc="outside lower center", ncols=5, fontsize=6)
    style.say_key(figure, " ".join(filter(None, (OURS, tie(settings.campaign)))))
    return figure, drawn


def _zoom(axis: Axes, parts: Sequence[pd.DataFrame]) -> None:
    """Show what is near zero slip: a few times the largest mu(0), as far as the slowest rise."""
    axis.axhline(0, color="black", linewidth=0.6)
    if not parts:
        return
    drawn = pd.concat(parts)
    mu = drawn.loc[drawn["series"] == "zero slip", "y"]
    least, top = mu.min(), 4 * mu.abs().max()
    lines = drawn[(drawn["panel"] == "a") & (drawn["series"] == "fit")]
    below = lines[lines.groupby("oil")["y"].cummax() < top]
    axis.set_ylim(1e3 * (min(least, 0) - 0.1 * top), 1e3 * top)
    axis.set_xlim(-0.04 * below["x"].max(), below["x"].max())


def _draw_zero_slip(
    whole: Axes,
    near: Axes,
    oil: str,
    fits: pd.DataFrame,
    results: CampaignTables,
    settings: Settings,
) -> Iterator[pd.DataFrame]:
    """Of one oil: the curve at which a fit has the most traction without slip."""
    starts = [
        starts_of(results, oil, law, settings).assign(law=law) for law in _wang_deng(fits["law"])
    ]
    if not sum(map(len, starts)):
        return
    among = pd.concat(starts, ignore_index=True)
    largest = tables.rows(among.loc[[among["y"].abs().idxmax()]])[0]
    law_name, run = largest["law"], largest["run_id"]
    fit, law = tables.rows(fits.loc[[law_name]])[0], laws_of(oil, settings)[law_name]
    curve = _curve(results, run)
    # close enough together for the zoom
    slip = np.linspace(0, 1, 301) ** 2 * float(curve["slide_roll_ratio"].max())
    fitted = FittedLaw.of(results.coefficients, oil, law=law)
    mu = fitted.traction(curve[list(law.conditions)].mean().to_numpy(dtype=float), slip)
    look = symbol_of(oil, settings, fit)
    for axis, scale in ((whole, 1.0), (near, 1e3)):
        axis.plot(slip, scale * mu, color=look["color"], linewidth=0.9)
        _draw_measured(axis, curve, look, scale)
    label = f"{_about(fit, curve)}\n{_MU}(0) = {_thousandths(mu[0])} {_TIMES}"
    # an open symbol hides no other
    order = 4 if fit["certified"] else 5
    near.plot(0, 1e3 * mu[0], **look | {"markersize": 5}, label=label, zorder=order)
    about = {"oil": oil, "label": f"{law_name}, run {run}"}
    yield _measured("a", curve, about)
    yield marks("a", "fit", slip, mu, **about)
    yield marks("a", "zero slip", 0.0, mu[0], **about)


def _draw_left_out(
    whole: Axes,
    errors: Axes,
    oil: str,
    fits: pd.DataFrame,
    results: CampaignTables,
    settings: Settings,
) -> Iterator[pd.DataFrame]:
    """Of one oil: the curve whose error by a Wang-Deng law grows most when left out."""
    rms = _errors_by_curve(results, oil)
    among = rms[rms["law"].isin(_wang_deng(fits["law"]))].dropna()
    if among.empty:
        return
    worst = tables.rows(among.loc[[(among["unseen"] - among["seen"]).idxmax()]])[0]
    law_name, run = worst["law"], worst["run_id"]
    fit = tables.rows(fits.loc[[law_name]])[0]
    curve, look = _curve(results, run), symbol_of(oil, settings, fit)
    beside = results.law_points[results.law_points["run_id"] == run]
    _draw_measured(whole, curve, look)
    yield _measured("b", curve, {"oil": oil, "label": f"{law_name}, run {run}"})
    lines = [(law_name, "fit"), (law_name, "left out"), (DENG2026.name, "left out")]
    for law, series in lines:
        column = "traction_coefficient" if series == "fit" else "left_out_traction_coefficient"
        of_law = beside[beside["law"] == law]
        line = _one_side(of_law.assign(traction_coefficient=of_law[column]))
        if law not in fits.index or line["traction_coefficient"].isna().any():
            continue
        dashes = _DASHES["Eq. 7" if law == DENG2026.name else series]
        slip, mu = line["slide_roll_ratio"], line["traction_coefficient"]
        off = mu.to_numpy() - curve["traction_coefficient"].to_numpy()
        for axis, y in ((whole, mu), (errors, 1e3 * off)):
            axis.plot(slip, y, color=look["color"], linestyle=dashes, linewidth=0.9)
        yield marks("b", series, slip, mu, oil=oil, label=f"{law}, run {run}")
    errors.axhline(0, color="black", linewidth=0.6)
    label = f"{_about(fit, curve)}\nrms error {_growth(worst)}"
    for papers in tables.rows(rms[(rms["law"] == DENG2026.name) & (rms["run_id"] == run)]):
        label += f"; Eq. 7: {_growth(papers)}"
    errors.plot([], [], **look, label=label)


def _key_of_lines() -> list[Any]:
    black: dict[str, Any] = {"color": "black", "linewidth": 0.9}
    return [
        style.symbol_handle("plateau, 95 % (random part)", ".", color="black", markersize=4),
        style.line_handle("fit to all curves", linestyle=_DASHES["fit"], **black),
        style.line_handle("fit to all others", linestyle=_DASHES["left out"], **black),
        style.line_handle("Eq. 7, fit to all others", linestyle=_DASHES["Eq. 7"], **black),
        style.symbol_handle("fit not certified", "o", color="black", markerfacecolor="white"),
    ]


def _errors_by_curve(results: CampaignTables, oil: str) -> pd.DataFrame:
    """Rms error of each law on each curve of an oil, `seen` by the fit and `unseen`."""
    key = ["run_id", "first_row"]
    beside = results.law_points[results.law_points["oil"] == oil]
    points = results.points[[*key, "traction_coefficient"]]
    both = beside.merge(points, on=key, suffixes=("", "_measured"))
    squares = both[["law", "run_id"]].assign(
        seen=(both["traction_coefficient"] - both["traction_coefficient_measured"]) ** 2,
        unseen=(both["left_out_traction_coefficient"] - both["traction_coefficient_measured"]) ** 2,
    )
    means = squares.groupby(["law", "run_id"], as_index=False).mean()
    return means.assign(seen=np.sqrt(means["seen"]), unseen=np.sqrt(means["unseen"]))


def _wang_deng(laws: "pd.Series[str]") -> list[str]:
    return [law for law in laws if law.startswith(WANG_DENG)]


def _curve(results: CampaignTables, run: str) -> pd.DataFrame:
    """Accepted points of one run by slip, as if slipping in the positive direction."""
    points = results.points[results.points["accepted"] & (results.points["run_id"] == run)]
    return _one_side(points)


def _one_side(points: pd.DataFrame) -> pd.DataFrame:
    both = ["slide_roll_ratio", "traction_coefficient"]
    side = np.where(points["slide_roll_ratio"] < 0, -1.0, 1.0)
    return points.assign(**{name: side * points[name] for name in both}).sort_values(both[0])


def _draw_measured(
    axis: Axes, curve: pd.DataFrame, look: Mapping[str, Any], scale: float = 1.0
) -> None:
    axis.errorbar(
        curve["slide_roll_ratio"],
        scale * curve["traction_coefficient"],
        yerr=scale * style.SE_DRAWN * curve["traction_coefficient_se"],
        fmt=".",
        color=look["color"],
        markersize=3,
        elinewidth=0.7,
    )


def _about(fit: Mapping[str, Any], curve: pd.DataFrame) -> str:
    """Oil, law and what keeps its fit from being certified; below, the conditions of a curve."""
    bounds = f", at bounds: {fit['active_bounds']}" if fit["active_bounds"] else ""
    fault = "" if fit["certified"] else f" (not certified{bounds})"
    levels = {name: float(f"{curve[name].mean():.3g}") for name in CONDITIONS}
    return f"{fit['oil']}, {fit['law']}{fault}\n{style.level_phrases(levels)}"


def _growth(errors: Mapping[str, Any]) -> str:
    seen, unseen = _thousandths(errors["seen"]), _thousandths(errors["unseen"])
    return f"{seen} \N{RIGHTWARDS ARROW} {unseen} {_TIMES}"


def _thousandths(number: float) -> str:
    return f"{1e3 * number:.2g}".replace("-", "\N{MINUS SIGN}")


def _measured(panel: str, curve: pd.DataFrame, about: Mapping[str, str]) -> pd.DataFrame:
    x, y = curve["slide_roll_ratio"], curve["traction_coefficient"]
    bar = style.SE_DRAWN * curve["traction_coefficient_se"]
    return marks(panel, "measured", x, y, lower=y - bar, upper=y + bar, **about)
