"""mu of the fitted law far and wide, beside the printed constants: Figs 7-10 of the paper."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.paper.extrapolation import is_beyond
from oilfilm.paper.printed_law import with_printed
from oilfilm.paper.reference import PrintedCoefficients
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.config import Conditions
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import FloatArray

_STEPS = 121  # along the abscissa
_MU = "\N{GREEK SMALL LETTER MU}"
_SYMBOLS = 4  # along a curve
# A printed line nearer to the refit than this share of its largest mu cannot be told from it.
_NEAR = 0.05
_ROOM = 1.4  # largest mu of a panel over that of its lines
_ONE_SCALE = 2.0  # panels whose largest mu differ by less than this factor share their scale
_SPEED, _TEMPERATURE, _SLIP = "entrainment_speed_m_s", "inlet_temperature_c", "slide_roll_ratio"
# Of each figure: condition along the abscissa, and condition that tells the curves of one panel
# apart. The others tell panels apart.
CUTS = {
    "fig07": (_SLIP, _TEMPERATURE),
    "fig08": (_SPEED, _TEMPERATURE),
    "fig09": ("max_hertz_pressure_gpa", _TEMPERATURE),
    "fig10": (_TEMPERATURE, _SLIP),
}

_ALIKE = {
    "family": "law",
    "tables": ("coefficients", "refits", "fit_quality"),
    "settings": ("oils", "extrapolation", "same_set_point"),
    "references": ("printed_coefficients",),
}
_OF_ALL_OILS = "Traction coefficient of all oils against "
_LINES = (
    "the paper does not state its own. Full lines: fitted law with the 95 % interval of "
    "the next good run. Thin dashed lines: constants printed in the paper, signs restored, at the "
    "middle level. They are shown where they differ by more than 5 % of the largest traction "
    "coefficient. Each panel states the largest difference at all levels. Shaded: beyond the "
    "tested conditions. dmN: pitch diameter times speed (mm rpm) of a bearing with this "
    "entrainment speed."
)


@register(
    name="fig07",
    paper="Fig. 7",
    title="Traction against slide-roll ratio",
    caption=_OF_ALL_OILS
    + "slide-roll ratio, one panel per maximum Hertz pressure and entrainment speed. "
    + "The curves are for several inlet temperatures; "
    + _LINES,
    **_ALIKE,
)
def fig07(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Drawing:
    """mu against slip, one panel per pressure."""
    return _draw_cuts("fig07", results, settings, printed_coefficients)


@register(
    name="fig08",
    paper="Fig. 8",
    title="Traction against entrainment speed",
    caption=_OF_ALL_OILS
    + "entrainment speed (m/s), one panel per maximum Hertz pressure and slide-roll ratio. "
    + "The curves are for several inlet temperatures; "
    + _LINES,
    **_ALIKE,
)
def fig08(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Drawing:
    """mu against entrainment speed, one panel per slip."""
    return _draw_cuts("fig08", results, settings, printed_coefficients)


@register(
    name="fig09",
    paper="Fig. 9",
    title="Traction against pressure",
    caption=_OF_ALL_OILS
    + "maximum Hertz pressure (GPa), one panel per entrainment speed and slide-roll ratio. "
    + "The curves are for several inlet temperatures; "
    + _LINES,
    **_ALIKE,
)
def fig09(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Drawing:
    """mu against pressure, one panel per speed and slip."""
    return _draw_cuts("fig09", results, settings, printed_coefficients)


@register(
    name="fig10",
    paper="Fig. 10",
    title="Traction against temperature",
    caption=_OF_ALL_OILS
    + "inlet temperature (\N{DEGREE SIGN}C), one panel per maximum Hertz pressure and entrainment "
    + "speed. "
    + "The curves are for several slide-roll ratios; "
    + _LINES,
    **_ALIKE,
)
def fig10(
    results: CampaignTables, settings: Settings, printed_coefficients: PrintedCoefficients
) -> Drawing:
    """mu against temperature, one panel per pressure and speed."""
    return _draw_cuts("fig10", results, settings, printed_coefficients)


def _draw_cuts(
    figure_name: str,
    results: CampaignTables,
    settings: Settings,
    printed_coefficients: PrintedCoefficients,
) -> Drawing:
    """All oils along the cuts of one figure; the levels are those of `extrapolation` of config."""
    (abscissa, by), levels = CUTS[figure_name], settings.extrapolation[figure_name]
    apart = [name for name in style.LEVEL_PHRASES if name not in (abscissa, by)]
    cuts = list(itertools.product(*(getattr(levels, name) for name in apart)))
    rows = -(-len(cuts) // 2)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.35 * rows + 0.6))
    # each panel with its own scale, or the strong traction of one would press the others flat
    axes = list(figure.subplots(rows, 2, sharex=True, squeeze=False).flat)
    oils = list(settings.oils)
    printed = with_printed(results.configured.coefficients, printed_coefficients)
    laws = {oil: of_oil for oil in oils if (of_oil := _laws(results, printed, oil))}
    drawn: list[pd.DataFrame] = []
    for number, cut in enumerate(cuts):
        fixed = dict(zip(apart, cut, strict=True))
        panel = style.title_panel(axes[number], number, panel_title(fixed))
        if laws:
            within = settings.same_set_point.relative
            drawn.append(_curves(panel, laws, levels, fixed, figure_name, within))
            _draw(axes[number], drawn[-1], oils)
    for axis in axes[len(cuts) :]:
        axis.set_visible(False)
    for axis in axes[max(len(cuts) - 2, 0) : len(cuts)]:
        # not of the figure as a whole, which would cover the key
        axis.set_xlabel(style.CONDITION_LABELS[abscissa])
        axis.tick_params(labelbottom=True)
    figure.supylabel(style.TRACTION_LABEL, fontsize=8)
    key = []
    if abscissa == _SPEED:
        fastest = style.bearing_speed_phrase(max(getattr(levels, _SPEED)))
        key.append(f"{fastest}: pitch diameter times speed, mm rpm")
    if drawn:
        key += _scale(axes[: len(cuts)], drawn)
        symbols = [style.LEVEL_PHRASES[by].format(level) for level in getattr(levels, by)]
        lines = pd.concat(drawn)
        any_printed = bool((lines["shown"] & (lines["series"] == "printed")).any())
        _draw_legend(figure, symbols, laws, oils, any_printed)
        if lost := [oil for oil in oils if oil not in laws]:
            key.append(f"no fit that follows P, U and T: {', '.join(lost)}")
        if key:
            style.say_key(figure, "\n".join(key))
    else:
        reason = "no oil has a fitted law\nof pressure, speed and temperature"
        style.say_in_panel(axes[0], reason)
    return figure, [curves.drop(columns=["beyond", "shown"]) for curves in drawn]


def panel_title(fixed: Mapping[str, float]) -> str:
    """Levels of a panel in words, with dmN beside the speed."""
    phrases = [
        style.bearing_speed_phrase(level) if name == _SPEED else style.level_phrases({name: level})
        for name, level in fixed.items()
    ]
    return ", ".join(phrases)


def _scale(axes: Sequence[Axes], drawn: Sequence[pd.DataFrame]) -> list[str]:
    """Give panels one scale, or where one would press others flat a line at the same mu in each.

    An interval that runs away leaves the panel, instead of pressing the lines flat.
    """
    key = []
    for axis, curves in zip(axes, drawn, strict=True):
        line = curves.loc[curves["shown"], "y"].max()
        axis.set_ylim(0, min(axis.get_ylim()[1], _ROOM * line))
    tops = [axis.get_ylim()[1] for axis in axes]
    if (upper := pd.concat(drawn)["y_upper"].max()) > max(tops):
        key.append(f"intervals that leave a panel reach up to {_MU} = {upper:.2g}")
    if max(tops) < _ONE_SCALE * min(tops):
        for axis in axes:
            axis.set_ylim(top=max(tops))
        return key
    size = 10.0 ** np.floor(np.log10(min(tops)))
    level = size * max(step for step in (0.5, 1.0, 2.0, 5.0) if step * size < 0.8 * min(tops))
    for axis in axes:
        axis.axhline(level, color="black", linestyle=":", linewidth=0.7, gid="scale")
    return [f"scales differ: the dotted line is {_MU} = {level:g} in each panel", *key]


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


def _curves(
    panel: str,
    laws: Mapping[str, Mapping[str, FittedLaw]],
    levels: Conditions,
    fixed: Mapping[str, float],
    figure_name: str,
    within: float,
) -> pd.DataFrame:
    """Every curve of a panel as its marks; `beyond` the tests, and whether it is `shown`.

    Printed constants that are too near to the refit to be shown say so.
    """
    abscissa, by = CUTS[figure_name]
    every = getattr(levels, by)
    # without slip there is nothing to measure, but a curve begins there
    tested = getattr(levels, abscissa)
    along = np.linspace(0.0 if abscissa == _SLIP else min(tested), max(tested), _STEPS)
    parts = []
    for (oil, of_oil), level in itertools.product(laws.items(), every):
        at = pd.DataFrame({**fixed, by: level, abscissa: along})[[*CONDITIONS, _SLIP]]
        conditions = np.ascontiguousarray(at[list(CONDITIONS)])
        beyond = is_beyond(at.to_numpy(), of_oil["refit"].coefficients.box, within).any(axis=1)
        predicted = {
            series: law.predict(conditions, at[_SLIP].to_numpy()) for series, law in of_oil.items()
        }
        refit = predicted["refit"].traction_coefficient
        for series, prediction in predicted.items():
            mu = prediction.traction_coefficient
            off = np.abs(mu - refit).max() / refit.max()
            shown = series == "refit" or (level == every[len(every) // 2] and off > _NEAR)
            label = style.LEVEL_PHRASES[by].format(level) + ("" if shown else ", not drawn")
            interval = {"lower": prediction.obs_ci_lower, "upper": prediction.obs_ci_upper}
            curve = marks(panel, series, along, mu, oil=oil, label=label, value=off, **interval)
            parts.append(curve.assign(beyond=np.asarray(beyond), shown=shown))
    return pd.concat(parts, ignore_index=True)


def _draw(axis: Axes, curves: pd.DataFrame, oils: Sequence[str]) -> None:
    """Intervals as bands, the refit as lines with a symbol per level, printed constants dashed."""
    refits = curves[curves["series"] == "refit"]
    symbols = dict(zip(refits["words"].unique(), itertools.cycle(style.MARKERS), strict=False))
    for (oil, level), line in refits.groupby(["oil", "words"], sort=False):
        colour = style.oil_colour(str(oil), oils)
        axis.fill_between(
            line["x"], line["y_lower"], line["y_upper"], color=colour, alpha=0.25, linewidth=0
        )
        axis.plot(
            line["x"],
            line["y"],
            linestyle=style.LINES["fit"],
            color=colour,
            marker=symbols[str(level)],
            markevery=(_STEPS // (2 * _SYMBOLS), _STEPS // _SYMBOLS),
            markerfacecolor="white",
            markeredgewidth=0.7,
        )
    printed = curves[curves["series"] == "printed"]
    for oil, line in printed[printed["shown"]].groupby("oil", sort=False):
        look: dict[str, Any] = {"linestyle": style.LINES["printed"], "linewidth": 0.6}
        look["color"] = style.shades(style.oil_colour(str(oil), oils), 2)[0]
        axis.plot(line["x"], line["y"], **look)
    if len(printed):
        off = printed["value"].max()
        sentence = f"printed constants: off by up to {100 * off:.{1 if off < 0.1 else 0}f} %"
        # an empty legend finds room beside the lines
        axis.legend(handles=[], title=sentence, title_fontproperties={"size": 6}, loc="best")
    # a level counts as tested only where every curve is
    for start, end in _stretches(curves.groupby("x")["beyond"].any()):
        axis.axvspan(start, end, color=style.EXTRAPOLATED, linewidth=0, zorder=0)
    axis.set_xlim(curves["x"].min(), curves["x"].max())
    axis.set_ylim(bottom=0)


def _stretches(flags: "pd.Series[bool]") -> Iterator[tuple[float, float]]:
    """Where flags along an axis are true, from half way before to half way behind."""
    along, here = flags.index.to_numpy(dtype=float), flags.to_numpy()
    middles: FloatArray = np.concatenate([along[:1], (along[1:] + along[:-1]) / 2, along[-1:]])
    changes = np.flatnonzero(np.diff(np.concatenate([[False], here, [False]])))
    for start, end in changes.reshape(-1, 2):
        yield middles[start], middles[end]


def _draw_legend(
    figure: Figure,
    symbols: Sequence[str],
    laws: Mapping[str, Mapping[str, FittedLaw]],
    oils: Sequence[str],
    any_printed: bool,
) -> None:
    """What colours, symbols and lines mean, below the panels."""
    look: dict[str, Any] = {"color": style.GREY, "linewidth": 0.6, "markerfacecolor": "white"}
    handles: list[Any] = [
        *(style.line_handle(f"{oil}, refit", color=style.oil_colour(oil, oils)) for oil in laws),
        *(
            style.line_handle(label, marker=marker, **look)
            for label, marker in zip(symbols, itertools.cycle(style.MARKERS), strict=False)
        ),
    ]
    if any_printed:
        look = {"color": "black", "linestyle": style.LINES["printed"], "linewidth": 0.6}
        handles.append(style.line_handle("printed constants", **look))
    handles.append(Patch(color=style.GREY, alpha=0.25, linewidth=0, label="95 %, next run"))
    handles.append(Patch(color=style.EXTRAPOLATED, label="beyond the tests"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
