"""The Wang-Deng law as the paper shows it: Fig. 4."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.report.figures import style
from oilfilm.report.figures.fits import starts_of, symbol_of
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import FloatArray

Fit = Mapping[str, Any]  # a row of a table
_TIMES = f"\N{MULTIPLICATION SIGN} {style.THOUSANDTHS}"
_WANG_DENG = "wang-deng"
_DASHES: style.Look = {"fit": "-", "left out": style.LINES["left out"], "Eq. 7": ":"}


@register(
    paper="Fig. 4",
    family="law",
    tables=("points", "fit_quality", "coefficients", "law_points"),
    settings=("oils", "rigs"),
)
def fig04(results: CampaignTables, settings: Settings) -> Sheet:
    """The Wang-Deng law at zero slip and on a curve left out.

    Measured traction coefficient against slide-roll ratio, and the Wang-Deng law fitted to the
    same oil. Each oil has one curve, chosen by a rule among all tested curves and all versions
    of the law. (a) Curve with the largest traction coefficient at zero slip; below: detail near
    zero slip. (b) Curve whose rms error grows most when the fit leaves it out; below: the
    errors. Full lines: fit to all curves. Dashed lines: fit without this curve. Dotted lines:
    law of the paper (Eq. 7), fitted without this curve. Symbols: plateau means with the 95 %
    interval of their random error. Open symbols: fit not certified. The groups and readings of
    the Wang-Deng laws are ours.
    """
    fits = results.fit_quality.dropna(subset="rmse")
    sheet = Sheet(4, 2, height=(1.7, 1.5), across=0.55, down=0.45)
    whole = sheet.panel(0, f"Curve with the largest |{style.MU}(0)|")
    unseen = sheet.panel(1, "Curve with the largest growth of error")
    near, errors = sheet.axes[2:]
    near.set_title("    near S = 0")
    near.xaxis.set_major_locator(MaxNLocator(4))  # numbers of many decimals: few of them fit
    errors.set_title("    fitted minus measured")
    handles: list[list[Any]] = [[], []]
    for oil in settings.oils:
        of_oil = {fit["law"]: fit for fit in tables.rows(fits[fits["oil"] == oil])}
        handles[0] += _draw_zero_slip(whole, near, of_oil, results, settings)
        handles[1] += _draw_left_out(unseen, errors, of_oil, results, settings)
    for panel, of_panel in zip((whole, unseen), handles, strict=True):
        if not of_panel:
            panel.say("no Wang-Deng law could be fitted")
    for axis in (near, errors):
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set_xlabel(style.CONDITION_LABELS["slide_roll_ratio"])
    _zoom(near, sheet.drawn())
    whole.axis.set_ylabel(style.TRACTION_LABEL)
    near.set_ylabel(f"{style.MU} ({style.THOUSANDTHS})")
    errors.set_ylabel(f"\N{GREEK CAPITAL LETTER DELTA}{style.MU} ({style.THOUSANDTHS})")
    black: style.Look = {"color": "black", "linewidth": 0.9}
    plateau = style.symbol_handle("plateau, 95 % (random part)", ".", color="black", markersize=4)
    labels = {
        "fit": "fit to all curves",
        "left out": "fit to all other curves",
        "Eq. 7": f"{law_name(DENG2026.name)}, fit to all other curves",
    }
    lines = [style.line_handle(label, linestyle=_DASHES[n], **black) for n, label in labels.items()]
    sheet.legend([*handles[0], plateau, lines[0], *handles[1], *lines[1:]], columns=2)
    return sheet


def _zoom(axis: Axes, drawn: pd.DataFrame) -> None:
    """Show what is near zero slip: a few times the largest mu(0), as far as the slowest rise."""
    of_a = drawn[drawn["panel"] == "a"]
    mu = of_a.loc[of_a["series"] == "zero slip", "y"]
    if len(mu):
        top = 4 * mu.abs().max()
        lines = of_a[of_a["series"] == "fit"]
        farthest = lines.loc[lines.groupby("oil")["y"].cummax() < top, "x"].max()
        axis.set_ylim(1e3 * (min(mu.min(), 0) - 0.1 * top), 1e3 * top)
        axis.set_xlim(-0.04 * farthest, farthest)


def _draw_zero_slip(
    whole: Panel,
    near: Axes,
    fits: Mapping[str, Fit],
    results: CampaignTables,
    settings: Settings,
) -> Iterator[Any]:
    """Of one oil: the curve at which a fit has the most traction without slip."""
    starts = [
        starts_of(results, fit["oil"], law, settings).assign(law=law)
        for law, fit in fits.items()
        if law.startswith(_WANG_DENG)
    ]
    if not sum(map(len, starts)):
        return
    among = pd.concat(starts, ignore_index=True)
    name, run = among[["law", "run_id"]].to_numpy()[among["y"].abs().argmax()]
    curve, look, colour, about, label = _begin(whole, fits[name], run, results, settings)
    slip, mu = _finely(fits[name], curve, results, settings)
    near.plot(curve["slide_roll_ratio"], 1e3 * curve["traction_coefficient"], ".", **colour)
    whole.line("fit", slip, mu, colour, **about)
    near.plot(slip, 1e3 * mu, **colour)
    # an open symbol hides no other
    near.plot(0, 1e3 * mu[0], **look | {"markersize": 5}, zorder=4 + (not fits[name]["certified"]))
    whole.keep("zero slip", 0.0, mu[0], **about)
    label += f"\n{style.MU}(0) = {_thousandths(mu[0])} {_TIMES}"
    yield style.line_handle(label, **look | {"markersize": 5})


def _draw_left_out(
    whole: Panel,
    errors: Axes,
    fits: Mapping[str, Fit],
    results: CampaignTables,
    settings: Settings,
) -> Iterator[Any]:
    """Of one oil: the curve whose error by a Wang-Deng law grows most when left out."""
    key, oil = ["run_id", "first_row"], [fit["oil"] for fit in fits.values()][:1]
    beside = results.law_points[results.law_points["oil"].isin(oil)]
    mu = ["traction_coefficient", "left_out_traction_coefficient"]
    measured = results.points.set_index(key)[mu[0]].rename("measured")
    off = beside.join(measured, on=key)
    squares = off[mu].sub(off["measured"], axis=0).pow(2).groupby([off["law"], off["run_id"]])
    # rms error of each law on each curve, by the fit of all curves and by that without the curve
    pairs = (squares.mean() ** 0.5).reset_index().to_numpy().tolist()
    rms = {(str(law), str(run)): (seen, unseen) for law, run, seen, unseen in pairs}
    grows = {
        at: unseen - seen
        for at, (seen, unseen) in rms.items()
        if at[0].startswith(_WANG_DENG) and not np.isnan(unseen)
    }
    if not grows:
        return
    name, run = max(grows, key=lambda at: grows[at])
    curve, look, colour, _, label = _begin(whole, fits[name], run, results, settings)
    for law, series in ((name, "fit"), (name, "left out"), (DENG2026.name, "left out")):
        column = mu[series == "left out"]
        of_law = _one_side(beside[(beside["law"] == law) & (beside["run_id"] == run)])
        if law not in fits or of_law[column].isna().any():
            continue
        at, line = of_law["slide_roll_ratio"].to_numpy(), of_law[column].to_numpy()
        # a fit without the curve is known at its plateaus alone
        fine = _finely(fits[law], curve, results, settings) if series == "fit" else (at, line)
        dashes = {"linestyle": _DASHES["Eq. 7" if law == DENG2026.name else series]}
        about: style.Look = {"oil": fits[law]["oil"], "label": f"{law}, run {run}"}
        whole.line(series, fine[0], fine[1], colour | dashes, **about)
        dots: style.Look = {"marker": ".", "markersize": 2, "linewidth": 0.5}
        difference = line - curve["traction_coefficient"].to_numpy()
        errors.plot(at, 1e3 * difference, **colour | dashes | dots)
    label += f"\nrms error {_growth(*rms[name, run])}"
    if (DENG2026.name, run) in rms:
        label += f"; Eq. 7: {_growth(*rms[DENG2026.name, run])}"
    yield style.line_handle(label, **look)


def _begin(
    panel: Panel, fit: Fit, run: str, results: CampaignTables, settings: Settings
) -> tuple[pd.DataFrame, style.Look, style.Look, style.Look, str]:
    """Draw a curve as measured; give it with the looks of symbol and lines, and what it is."""
    curve = _one_side(results.points.query("accepted and run_id == @run"))
    look = symbol_of(fit, list(settings.oils))
    x, y = curve["slide_roll_ratio"], curve["traction_coefficient"]
    bar = style.SE_DRAWN * curve["traction_coefficient_se"]
    dots: style.Look = {"color": look["color"], "marker": ".", "markersize": 3, "elinewidth": 0.7}
    about: style.Look = {"oil": fit["oil"], "label": f"{fit['law']}, run {run}"}
    panel.dots("measured", x, y, dots, lower=y - bar, upper=y + bar, **about)
    levels = {name: float(f"{curve[name].mean():.3g}") for name in CONDITIONS}
    label = f"{fit['oil']}, {law_name(fit['law'])}\n{style.level_phrases(levels)}"
    return curve, look, {"color": look["color"], "linewidth": 0.9}, about, label


def _finely(
    fit: Fit, curve: pd.DataFrame, results: CampaignTables, settings: Settings
) -> tuple[FloatArray, FloatArray]:
    """Slip and mu of a fit at the mean conditions of a curve, between its plateaus as well."""
    law = laws_of(fit["oil"], settings)[fit["law"]]
    fitted = FittedLaw.of(results.coefficients, fit["oil"], law=law)
    # close enough together for the detail
    slip = np.linspace(0, 1, 301) ** 2 * float(curve["slide_roll_ratio"].max())
    return slip, fitted.traction(curve[list(law.conditions)].mean().to_numpy(dtype=float), slip)


def _one_side(points: pd.DataFrame) -> pd.DataFrame:
    """Points by slip, as if slipping in the positive direction."""
    side = np.where(points["slide_roll_ratio"] < 0, -1.0, 1.0)
    turned = points.filter(regex="slide_roll_ratio$|traction_coefficient$").mul(side, axis="index")
    return points.assign(**turned).sort_values("slide_roll_ratio")


def _growth(seen: float, unseen: float) -> str:
    arrow = "\N{RIGHTWARDS ARROW}"
    return f"{_thousandths(seen)} {arrow} {_thousandths(unseen)} {_TIMES}"


def _thousandths(number: float) -> str:
    return f"{1e3 * number:.2g}".replace("-", "\N{MINUS SIGN}")
