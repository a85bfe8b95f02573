"""Laws far and wide: Figs 7-10 of the paper."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.patches import Patch

from oilfilm.bearing.kinematics import pitch_speed_mm_rpm
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.paper.extrapolation import is_beyond
from oilfilm.paper.printed_law import with_printed
from oilfilm.paper.reference import PrintedCoefficients
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet
from oilfilm.settings.config import Conditions
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import FloatArray

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
    paper="Fig. 7",
    family="law",
    tables=("coefficients", "refits", "fit_quality"),
    settings=("oils", "extrapolation", "same_set_point"),
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


@register(like="fig07", paper="Fig. 8")
def fig08(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against entrainment speed.

    Traction coefficient of all oils against entrainment speed (m/s), one panel per maximum Hertz
    pressure and slide-roll ratio. The curves are for several inlet temperatures.
    """
    return _draw_cuts("fig08", results, settings, **references)


@register(like="fig07", paper="Fig. 9")
def fig09(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against pressure.

    Traction coefficient of all oils against maximum Hertz pressure (GPa), one panel per entrainment
    speed and slide-roll ratio. The curves are for several inlet temperatures.
    """
    return _draw_cuts("fig09", results, settings, **references)


@register(like="fig07", paper="Fig. 10")
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
    (abscissa, by), levels = CUTS[figure], settings.extrapolation[figure]
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
    levels: Conditions,
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
    symbols = np.searchsorted(x, middles).tolist()
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
