"""Laws beside data and far beyond them: Figs 4 and 7-10 of the paper."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from deng2026_study.extrapolation import is_beyond
from deng2026_study.printed_law import with_printed
from deng2026_study.settings import MatrixWithSlip, study_settings
from oilfilm import tables
from oilfilm.base.ties import first_largest, reaches
from oilfilm.base.units import FloatArray
from oilfilm.bearing.kinematics import pitch_speed_mm_rpm
from oilfilm.fits.fit import laws_of
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.fits import starts_of, symbol_of
from oilfilm.report.figures.sheet import Panel, Sheet, register
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import DENG2026
from simulated_lab.printed import PrintedCoefficients

_STEPS = 121  # along the abscissa
_SYMBOLS = 4  # along a curve
_NOT_DRAWN = ", not drawn"
# A printed line nearer to the refit than this share of its largest mu cannot be told from it.
_NEAR = 0.05
_ROOM = 1.3  # largest mu of a panel over that of its lines
_SPEED, _TEMPERATURE, _SLIP = "entrainment_speed_m_s", "inlet_temperature_c", "slide_roll_ratio"
# Of each figure: condition along the abscissa, and condition that tells the curves of one panel
# apart. The others tell panels apart.
CUTS = {
    "fig07": (_SLIP, _TEMPERATURE),
    "fig08": (_SPEED, _TEMPERATURE),
    "fig09": ("max_hertz_pressure_gpa", _TEMPERATURE),
    "fig10": (_TEMPERATURE, _SLIP),
}
_BEYOND = Patch(facecolor=style.EXTRAPOLATED, label="beyond the tests")


@register(
    counterpart="Fig. 7",
    family="law",
    tables=("coefficients", "refits", "fit_quality"),
    settings=("oils", "same_set_point", "studies"),
    references=("printed_coefficients",),
)
def fig07(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against slide-roll ratio.

    Traction coefficient of all oils against slide-roll ratio, one panel per maximum Hertz pressure
    and entrainment speed. The curves are for several inlet temperatures.

    The paper does not state the levels of the curves. Full lines: fitted law with the 95 %
    interval of the next good run, which may leave the panel. Thin dashed lines: constants printed
    in the paper, signs restored, at the middle level. They are shown where they differ by more
    than 5 % of the largest traction coefficient; the legend states the largest difference at all
    levels. Shaded: beyond the tested conditions. Each panel has its own scale. dmN: pitch diameter
    times speed (mm rpm) of a bearing with this entrainment speed. Oils without a fit of pressure,
    speed and temperature are not shown.
    """
    return _draw_cuts("fig07", results, settings, **references)


@register(like="fig07", counterpart="Fig. 8")
def fig08(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against entrainment speed.

    Traction coefficient of all oils against entrainment speed (m/s), one panel per maximum Hertz
    pressure and slide-roll ratio. The curves are for several inlet temperatures.
    """
    return _draw_cuts("fig08", results, settings, **references)


@register(like="fig07", counterpart="Fig. 9")
def fig09(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against pressure.

    Traction coefficient of all oils against maximum Hertz pressure (GPa), one panel per entrainment
    speed and slide-roll ratio. The curves are for several inlet temperatures.
    """
    return _draw_cuts("fig09", results, settings, **references)


@register(like="fig07", counterpart="Fig. 10")
def fig10(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against temperature.

    Traction coefficient of all oils against inlet temperature (\N{DEGREE SIGN}C), one panel per
    maximum Hertz pressure and entrainment speed. The curves are for several slide-roll ratios.
    """
    return _draw_cuts("fig10", results, settings, **references)


def _draw_cuts(
    figure: str,
    results: CampaignTables,
    settings: Settings,
    printed_coefficients: PrintedCoefficients,
) -> Sheet:
    """All oils along the cuts of one figure; the levels are those of `extrapolation` of config."""
    (abscissa, by), levels = CUTS[figure], study_settings(settings).extrapolation[figure]
    apart = [name for name in style.LEVEL_PHRASES if name not in (abscissa, by)]
    cuts = list(itertools.product(*(getattr(levels, name) for name in apart)))
    sheet = Sheet(len(cuts), 2, height=1.75, across=0.5, sharex=True)
    printed = with_printed(results.configured.coefficients, printed_coefficients)
    laws = {oil: of_oil for oil in settings.oils if (of_oil := _laws(results, printed, oil))}
    for number, cut in enumerate(cuts):
        fixed = dict(zip(apart, cut, strict=True))
        panel = sheet.panel(number, panel_title(fixed))
        if laws:
            _draw(panel, laws, levels, fixed, (abscissa, by), settings)
        elif number == 0:
            panel.say("no oil has a fitted law\nof pressure, speed and temperature")
    sheet.label(style.CONDITION_LABELS[abscissa], style.TRACTION_LABEL)
    if laws:
        sheet.legend(_handles(sheet.drawn(), getattr(levels, by), by, list(settings.oils)))
    return sheet


def panel_title(fixed: Mapping[str, float]) -> str:
    """Levels of a panel in words, with the dmN (mm rpm) of a bearing beside the speed."""
    title = style.level_phrases(fixed)
    if _SPEED in fixed:
        speed = style.level_phrases({_SPEED: fixed[_SPEED]})
        mantissa, exponent = f"{pitch_speed_mm_rpm(fixed[_SPEED]):.1e}".split("e")
        title = title.replace(speed, f"{speed} (dmN {mantissa}e{int(exponent)})")
    return title


def _laws(results: CampaignTables, coefficients: pd.DataFrame, oil: str) -> dict[str, FittedLaw]:
    """The refit and, where the paper has them, the printed constants, by the name of the series.

    None of an oil whose law does not follow all three conditions.
    """
    of_oil = coefficients[coefficients["oil"] == oil]
    if of_oil.empty:
        return {}
    refit = FittedLaw.of(of_oil, oil, results.configured.refits, results.configured.fit_quality)
    law, fitted = refit.law, refit.coefficients
    if law.conditions != CONDITIONS or not fitted.known.all() or np.isnan(fitted.constants).any():
        return {}
    names = [constant.name for constant in law.constants]
    printed = of_oil.set_index("constant")["printed_value"].reindex(names).to_numpy(dtype=float)
    if np.isnan(printed).any():
        return {"refit": refit}
    return {"refit": refit, "printed": FittedLaw(law, Coefficients.bare(law, printed))}


def _draw(
    panel: Panel,
    laws: Mapping[str, Mapping[str, FittedLaw]],
    levels: MatrixWithSlip,
    fixed: Mapping[str, float],
    cut: tuple[str, str],
    settings: Settings,
) -> None:
    """Intervals as bands, the refit as lines with a symbol per level, printed constants dashed."""
    abscissa, by = cut
    every, tested = getattr(levels, by), getattr(levels, abscissa)
    x = np.linspace(min(tested), max(tested), _STEPS)
    if abscissa == _SLIP:
        # without slip there is nothing to measure, but a curve begins there, and bends most near it
        x = max(tested) * np.linspace(0, 1, _STEPS) ** 2
    middles = x[0] + np.ptp(x) * (np.arange(_SYMBOLS) + 0.5) / _SYMBOLS
    symbols = reaches(x, middles[:, np.newaxis]).argmax(axis=1).tolist()
    highest, beyond = 0.0, np.zeros(_STEPS, dtype=bool)
    for (oil, of_oil), level in itertools.product(laws.items(), every):
        at = pd.DataFrame({**fixed, by: level, abscissa: x})[[*CONDITIONS, _SLIP]].to_numpy()
        # a level counts as tested only where every curve is
        box, within = of_oil["refit"].coefficients.box, settings.same_set_point.relative
        beyond |= is_beyond(at, box, within).any(axis=1)
        colour = style.oil_colour(oil, list(settings.oils))
        label, conditions = style.level_phrases({by: level}), np.ascontiguousarray(at[:, :-1])
        found = of_oil["refit"].predict(conditions, at[:, -1])
        refit = found.traction_coefficient
        highest = max(highest, refit.max())
        interval = {"lower": found.obs_ci_lower, "upper": found.obs_ci_upper}
        look: style.Look = {"color": colour, "markerfacecolor": "white", "markeredgewidth": 0.7}
        look["marker"] = style.MARKERS[every.index(level) % len(style.MARKERS)]
        look |= {"linestyle": style.LINES["fit"], "markevery": symbols}
        panel.line("refit", x, refit, look, oil=oil, label=label, value=0.0, **interval)
        if "printed" in of_oil:
            mu = of_oil["printed"].predict(conditions, at[:, -1]).traction_coefficient
            off = float(np.abs(mu - refit).max() / refit.max())
            if level == every[len(every) // 2] and off > _NEAR:
                dashed: style.Look = {"linestyle": style.LINES["printed"], "linewidth": 0.6}
                panel.axis.plot(x, mu, color=style.shades(colour, 2)[0], **dashed)
                highest = max(highest, mu.max())
            else:
                label += _NOT_DRAWN
            panel.keep("printed", x, mu, oil=oil, label=label, value=off)
    for start, end in _stretches(x, beyond):
        panel.axis.axvspan(start, end, color=style.EXTRAPOLATED, linewidth=0, zorder=0)
    panel.axis.set_xlim(x.min(), x.max())
    # an interval that runs away leaves the panel, instead of pressing the lines flat
    panel.axis.set_ylim(0, min(panel.axis.get_ylim()[1], _ROOM * highest))


def _stretches(along: FloatArray, flags: Any) -> Iterator[tuple[float, float]]:
    """Where flags along an axis are true, from half way before to half way behind."""
    middles: FloatArray = np.concatenate([along[:1], (along[1:] + along[:-1]) / 2, along[-1:]])
    changes = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    for start, end in changes.reshape(-1, 2):
        yield middles[start], middles[end]


def _handles(
    drawn: pd.DataFrame, levels: Sequence[float], by: str, oils: Sequence[str]
) -> list[Any]:
    """What colours, symbols and lines mean."""
    grey: style.Look = {"color": style.GREY, "linewidth": 0.6, "markerfacecolor": "white"}
    handles: list[Any] = [
        style.line_handle(f"{oil}, refit", color=style.oil_colour(oil, oils))
        for oil in oils
        if oil in set(drawn["oil"])
    ]
    handles += [
        style.line_handle(style.level_phrases({by: level}), marker=marker, **grey)
        for level, marker in zip(levels, itertools.cycle(style.MARKERS), strict=False)
    ]
    printed = drawn[drawn["series"] == "printed"]
    if len(printed):
        off, hidden = printed["value"].max(), printed["words"].str.endswith(_NOT_DRAWN).all()
        label = f"printed constants, off by up to {100 * off:.{1 if off < 0.1 else 0}f} %"
        dashed: style.Look = {"color": "black", "linestyle": style.LINES["printed"]}
        label, width = (label + _NOT_DRAWN, 0.0) if hidden else (label, 0.6)
        handles.append(style.line_handle(label, linewidth=width, **dashed))
    interval = Patch(color=style.GREY, alpha=0.25, linewidth=0, label="95 %, next run")
    return [*handles, interval, _BEYOND]


Fit = Mapping[str, Any]  # a row of a table
_TIMES = f"\N{MULTIPLICATION SIGN} {style.THOUSANDTHS}"
_WANG_DENG = "wang-deng"
_DASHES: style.Look = {"fit": "-", "left out": style.LINES["left out"], "Eq. 7": ":"}


@register(
    counterpart="Fig. 4",
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
    whole: Panel, near: Axes, fits: Mapping[str, Fit], results: CampaignTables, settings: Settings
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
    name, run = among[["law", "run_id"]].to_numpy()[first_largest(among["y"].abs())]
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
    whole: Panel, errors: Axes, fits: Mapping[str, Fit], results: CampaignTables, settings: Settings
) -> Iterator[Any]:
    """Of one oil: the curve whose error by a Wang-Deng law grows most when left out."""
    key, oil = ["run_id", "first_row"], [fit["oil"] for fit in fits.values()][:1]
    beside = results.law_points[results.law_points["oil"].isin(oil)]
    mu = ["traction_coefficient", "left_out_traction_coefficient"]
    measured = results.points.set_index(key)[mu[0]].rename("measured")
    off = beside.join(measured, on=key)
    missed = off[mu].sub(off["measured"], axis=0)
    squares = missed.pow(2).groupby([off["law"], off["run_id"]], sort=False)
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
    # a law that comes to its special case grows as that does: the first of both
    name, run = [*grows][first_largest([*grows.values()])]
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
    return points.assign(**turned).sort_values("slide_roll_ratio", kind="stable")


def _growth(seen: float, unseen: float) -> str:
    arrow = "\N{RIGHTWARDS ARROW}"
    return f"{_thousandths(seen)} {arrow} {_thousandths(unseen)} {_TIMES}"


def _thousandths(number: float) -> str:
    return f"{1e3 * number:.2g}".replace("-", "\N{MINUS SIGN}")
