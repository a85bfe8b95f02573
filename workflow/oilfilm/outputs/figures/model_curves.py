"""mu of the fitted law far and wide, beside the printed constants: Figs 7-10 of the paper."""

import itertools
import string
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from oilfilm.fitting.fitted import Coefficients, FittedLaw
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.config import Conditions
from oilfilm.settings.resolved import Settings
from oilfilm.studies.extrapolation import is_beyond
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import ABSOLUTE_ZERO_C, FloatArray

_STEPS = 121  # along the abscissa
_SYMBOLS = 4  # along a curve


@dataclass(frozen=True)
class Cuts:
    """What one of Figs 7-10 varies, and how.

    Attributes:
        abscissa: Condition along the abscissa.
        by: Condition that tells the curves of one panel apart; the others tell panels apart.
    """

    abscissa: str
    by: str


_TEMPERATURE, _SLIP = "inlet_temperature_c", "slide_roll_ratio"
CUTS = {
    "fig07": Cuts(_SLIP, _TEMPERATURE),
    "fig08": Cuts("entrainment_speed_m_s", _TEMPERATURE),
    "fig09": Cuts("max_hertz_pressure_gpa", _TEMPERATURE),
    "fig10": Cuts(_TEMPERATURE, _SLIP),
}


_MODEL_CURVES = drawn_table(
    "model_curves",
    "Drawn in a figure of the law's curves (Figs 7-10): one row per vertex of a line.",
    columns="""
        panel oil series max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c
        slide_roll_ratio traction_coefficient traction_coefficient_lower
        traction_coefficient_upper extrapolated""",
    uses=(
        use("oil", "colour of the line"),
        use(
            "series",
            "refit: full line in its interval; printed: thin dashed line",
            allowed=("refit", "printed"),
        ),
        use("max_hertz_pressure_gpa", required=True),
        use("entrainment_speed_m_s", required=True, at_least=0),
        use("inlet_temperature_c", required=True, at_least=ABSOLUTE_ZERO_C),
        use("slide_roll_ratio", required=True, at_least=0),
        use("traction_coefficient", "ordinate", required=True),
        use("traction_coefficient_lower", "lower edge of the band, none where null"),
        use("traction_coefficient_upper", "upper edge of the band"),
    ),
)


@register(
    name="fig07",
    paper="Fig. 7",
    title="Traction against slip at 200 m/s",
    caption="Traction coefficient of all oils against slide-roll ratio, one panel per pressure, at "
    "several inlet temperatures (ours: the paper does not print its own). Full lines: "
    "refit with its 95 % interval; thin dashed lines: printed constants, signs restored; shaded: "
    "beyond the tested conditions.",
    category="Paper",
    family="law",
    tables=("coefficients", "refits", "fit_quality"),
    settings=("oils", "extrapolation", "same_set_point"),
    draws=_MODEL_CURVES,
)
def fig07(results: CampaignTables, settings: Settings) -> Drawing:
    """mu against slip, one panel per pressure."""
    return _figure("fig07", results, settings)


@register(
    name="fig08",
    paper="Fig. 8",
    title="Traction against entrainment speed",
    caption="Traction coefficient of all oils against entrainment speed (m/s) at 1.5 GPa, one "
    "panel per slide-roll ratio, at several inlet temperatures (ours: the paper does not print "
    "its own). Full lines: refit with its 95 % interval; thin dashed lines: printed constants, "
    "signs restored; shaded: beyond the tested conditions.",
    category="Paper",
    family="law",
    tables=("coefficients", "refits", "fit_quality"),
    settings=("oils", "extrapolation", "same_set_point"),
    draws=_MODEL_CURVES,
)
def fig08(results: CampaignTables, settings: Settings) -> Drawing:
    """mu against entrainment speed, one panel per slip."""
    return _figure("fig08", results, settings)


@register(
    name="fig09",
    paper="Fig. 9",
    title="Traction against pressure",
    caption="Traction coefficient of all oils against maximum Hertz pressure (GPa) at high and low "
    "speed and at small and large slide-roll ratio, at several inlet temperatures (ours: the paper "
    "does not print its own). Full lines: "
    "refit with its 95 % interval; thin dashed lines: printed constants, signs restored; shaded: "
    "beyond the tested conditions.",
    category="Paper",
    family="law",
    tables=("coefficients", "refits", "fit_quality"),
    settings=("oils", "extrapolation", "same_set_point"),
    draws=_MODEL_CURVES,
)
def fig09(results: CampaignTables, settings: Settings) -> Drawing:
    """mu against pressure, one panel per speed and slip."""
    return _figure("fig09", results, settings)


@register(
    name="fig10",
    paper="Fig. 10",
    title="Traction against temperature",
    caption="Traction coefficient of all oils against inlet temperature (\N{DEGREE SIGN}C) at "
    "light and heavy load and at high and low speed, at several slide-roll ratios (ours: the paper "
    "does not print its own). Full lines: refit with its 95 % interval; thin dashed lines: printed "
    "constants, signs restored; shaded: beyond the tested conditions.",
    category="Paper",
    family="law",
    tables=("coefficients", "refits", "fit_quality"),
    settings=("oils", "extrapolation", "same_set_point"),
    draws=_MODEL_CURVES,
)
def fig10(results: CampaignTables, settings: Settings) -> Drawing:
    """mu against temperature, one panel per pressure and speed."""
    return _figure("fig10", results, settings)


def _figure(name: str, results: CampaignTables, settings: Settings) -> Drawing:
    """All oils along the cuts of one figure; the levels are those of `extrapolation` of config."""
    cuts, levels = CUTS[name], settings.extrapolation[name]
    apart = [axis for axis in style.LEVEL_PHRASES if axis not in (cuts.abscissa, cuts.by)]
    places = [
        dict(zip(apart, at, strict=True))
        for at in itertools.product(*(getattr(levels, axis) for axis in apart))
    ]
    rows = -(-len(places) // 2)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.35 * rows + 0.6))
    # each panel with its own scale, or the strong traction of one would press the others flat
    axes = list(figure.subplots(rows, 2, sharex=True, squeeze=False).flat)
    oils = list(settings.oils)
    laws = {oil: found for oil in oils if (found := _laws(results, oil))}
    drawn = []
    for letter, axis, place in zip(string.ascii_lowercase, axes, places, strict=False):
        words = ", ".join(
            style.LEVEL_PHRASES[axis_name].format(level) for axis_name, level in place.items()
        )
        axis.set_title(f"({letter}) {words}")
        curves = _curves(laws, cuts, levels, place, settings.same_set_point.relative)
        if not curves.empty:
            _draw(axis, curves, cuts, oils)
            drawn.append(curves.assign(panel=letter))
    for axis in axes[len(places) :]:
        axis.set_visible(False)
    for axis in axes[max(len(places) - 2, 0) : len(places)]:
        # not of the figure as a whole, which would lie on the key
        axis.set_xlabel(style.CONDITION_LABELS[cuts.abscissa])
        axis.tick_params(labelbottom=True)
    figure.supylabel("Traction coefficient \N{GREEK SMALL LETTER MU} (1)", fontsize=8)
    if drawn:
        _say_key(figure, cuts, getattr(levels, cuts.by), laws, oils)
    else:
        words = "no oil has a fitted law\nof pressure, speed and temperature"
        style.say_in_panel(axes[0], words)
    return figure, drawn


def _laws(results: CampaignTables, oil: str) -> dict[str, FittedLaw]:
    """The refit and, where the paper has them, the printed constants, by the name of the series.

    None of an oil whose law does not follow all three conditions.
    """
    of_oil = results.coefficients[results.coefficients["oil"] == oil]
    if of_oil.empty:
        return {}
    refit = FittedLaw.of(of_oil, oil, results.refits, results.fit_quality)
    found = refit.coefficients
    if (
        refit.law.conditions != CONDITIONS
        or not found.known.all()
        or np.isnan(found.constants).any()
    ):
        return {}
    names = [constant.name for constant in refit.law.constants]
    printed = of_oil.set_index("constant")["printed_value"].reindex(names).to_numpy(dtype=float)
    if np.isnan(printed).any():
        return {"refit": refit}
    return {
        "refit": refit,
        "printed": FittedLaw(refit.law, Coefficients.bare(refit.law, printed)),
    }


def _curves(
    laws: Mapping[str, Mapping[str, FittedLaw]],
    cuts: Cuts,
    levels: Conditions,
    place: Mapping[str, float],
    within: float,
) -> pd.DataFrame:
    """Every curve of a panel, one row per vertex."""
    along_levels = getattr(levels, cuts.abscissa)
    ends = min(along_levels), max(along_levels)
    # without slip there is nothing to measure, but a curve begins there
    along = np.linspace(0.0 if cuts.abscissa == _SLIP else ends[0], ends[1], _STEPS)
    parts = []
    for (oil, both), level in itertools.product(laws.items(), getattr(levels, cuts.by)):
        at: dict[str, Any] = {**place, cuts.by: level, cuts.abscissa: along}
        conditions = np.column_stack(
            [np.broadcast_to(at[name], along.shape) for name in CONDITIONS]
        )
        slip = np.broadcast_to(at[_SLIP], along.shape)
        asked = np.column_stack([conditions, slip])
        beyond = is_beyond(asked, both["refit"].coefficients.box, within).any(axis=1)
        for series, law in both.items():
            found = law.predict(conditions, slip)
            parts.append(
                pd.DataFrame(dict(zip(CONDITIONS, conditions.T, strict=True))).assign(
                    oil=oil,
                    series=series,
                    slide_roll_ratio=slip,
                    traction_coefficient=found.traction_coefficient,
                    traction_coefficient_lower=found.lower,
                    traction_coefficient_upper=found.upper,
                    extrapolated=np.asarray(beyond),
                )
            )
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def _draw(axis: Axes, curves: pd.DataFrame, cuts: Cuts, oils: Sequence[str]) -> None:
    """Intervals as bands, the refit as lines with a symbol a level, printed constants dashed."""
    levels = list(curves[cuts.by].unique())
    for (oil, level), curve in curves.groupby(["oil", cuts.by], sort=False):
        place = levels.index(level)
        colour = style.oil_colour(str(oil), oils)
        refit = curve[curve["series"] == "refit"]
        x = refit[cuts.abscissa]
        interval = refit["traction_coefficient_lower"], refit["traction_coefficient_upper"]
        axis.fill_between(x, *interval, color=colour, alpha=0.25, linewidth=0)
        axis.plot(
            x,
            refit["traction_coefficient"],
            linestyle=style.LINES["fit"],
            color=colour,
            marker=style.MARKERS[place % len(style.MARKERS)],
            markevery=(_STEPS // (2 * _SYMBOLS), _STEPS // _SYMBOLS),
            markerfacecolor="white",
            markeredgewidth=0.7,
        )
        printed = curve[curve["series"] == "printed"]
        axis.plot(
            printed[cuts.abscissa],
            printed["traction_coefficient"],
            linestyle=style.LINES["printed"],
            color=style.shades(colour, 2)[0],
            linewidth=0.6,
        )
    # a place counts as tested only where every curve is
    beyond = curves.groupby(cuts.abscissa)["extrapolated"].any()
    for start, end in _stretches(beyond):
        axis.axvspan(start, end, color=style.EXTRAPOLATED, linewidth=0, zorder=0)
    axis.set_xlim(curves[cuts.abscissa].min(), curves[cuts.abscissa].max())
    axis.set_ylim(bottom=0)


def _stretches(flags: "pd.Series[bool]") -> Iterator[tuple[float, float]]:
    """Where flags along an axis are true, from half way before to half way behind."""
    along, here = flags.index.to_numpy(dtype=float), flags.to_numpy()
    middles: FloatArray = np.concatenate([along[:1], (along[1:] + along[:-1]) / 2, along[-1:]])
    changes = np.flatnonzero(np.diff(np.concatenate([[False], here, [False]])))
    for start, end in changes.reshape(-1, 2):
        yield middles[start], middles[end]


def _say_key(
    figure: Figure,
    cuts: Cuts,
    levels: Sequence[float],
    laws: Mapping[str, Mapping[str, FittedLaw]],
    oils: Sequence[str],
) -> None:
    """What colours, symbols and lines mean, below the panels."""
    handles: list[Any] = [
        Line2D([], [], color=style.oil_colour(oil, oils), label=f"{oil}, refit") for oil in laws
    ]
    phrase = style.LEVEL_PHRASES[cuts.by]
    handles += [
        Line2D(
            [], [], color=style.GREY, linewidth=0.6, markerfacecolor="white",
            marker=style.MARKERS[place % len(style.MARKERS)], label=phrase.format(level),
        )
        for place, level in enumerate(levels)
    ]  # fmt: skip
    if any("printed" in both for both in laws.values()):
        handles.append(
            Line2D(
                [], [], color="black", linestyle=style.LINES["printed"], linewidth=0.6,
                label="printed constants",
            )
        )  # fmt: skip
    handles.append(Patch(color=style.GREY, alpha=0.25, linewidth=0, label="95 % interval"))
    handles.append(Patch(color=style.EXTRAPOLATED, label="beyond the tests"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
