"""mu against slip: measured points with their errors, and the fit as lines (figs 2 and 3)."""

import itertools
import string
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.curation.coverage import with_levels
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.config import Fig03Settings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use
from oilfilm.traction.law import CONDITIONS

_NO_POINT = "no accepted point\nat the conditions\nof this figure\n(config: figures)"
_SE_DRAWN = 1.96  # error bars are 95 % intervals


@dataclass(frozen=True)
class _Series:
    """One curve of a panel: the points of some runs and the fit at their mean conditions."""

    label: str
    oil: str
    points: pd.DataFrame
    law: FittedLaw
    colour: Any
    marker: str


_CURVES = drawn_table(
    "curves",
    "Drawn in a figure of mu against slip.",
    columns="""
        panel series kind oil slide_roll_ratio traction_coefficient traction_coefficient_se""",
    uses=(
        use("kind", "measured: points; fit: line", allowed=("measured", "fit")),
        use("slide_roll_ratio", "abscissa", required=True),
        use("traction_coefficient", "ordinate", required=True),
        use(
            "traction_coefficient_se",
            "the bar drawn is 1.96 times as long to either side; none where null",
        ),
    ),
)


@register(
    name="fig02",
    paper="Fig. 2",
    title="Traction curves of one oil",
    caption="Traction coefficient against slide-roll ratio at three inlet temperatures, by maximum "
    "Hertz pressure (left) and by entrainment speed (right). Symbols: plateau means with the 95 % "
    "interval of their random error; lines: fitted law.",
    category="Paper",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("figures", "oils", "rigs", "same_set_point", "campaign.matrix"),
    draws=_CURVES,
)
def fig02(results: CampaignTables, settings: Settings) -> Drawing:
    """mu of one oil against slip by pressure (left) and speed (right), one row per temperature."""
    results = results.replace(runs=with_levels(results.runs, settings))
    choice = settings.figures.fig02
    oil, temperatures = choice.oil, choice.inlet_temperature_c
    law = FittedLaw.of(results.coefficients, oil)
    base = style.oil_colour(oil, list(settings.oils))
    figure, axes = style.panels(
        len(temperatures), 2, style.DOUBLE_COLUMN_IN, 2.1 * len(temperatures)
    )
    rows = []
    for row, temperature in enumerate(temperatures):
        columns = (
            ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "P = {:g} GPa", "U = {:g} m/s"),
            ("entrainment_speed_m_s", "max_hertz_pressure_gpa", "U = {:g} m/s", "P = {:g} GPa"),
        )
        for column, (varied, fixed, label, fixed_label) in enumerate(columns):
            levels = _levels(results, settings.campaign, varied)
            series = [
                _Series(
                    label.format(level),
                    oil,
                    _select(
                        results,
                        oil,
                        {
                            varied: level,
                            fixed: getattr(choice, fixed),
                            "inlet_temperature_c": temperature,
                        },
                    ),
                    law,
                    colour,
                    marker,
                )
                for level, colour, marker in zip(
                    levels,
                    style.shades(base, len(levels)),
                    itertools.cycle(style.MARKERS),
                    strict=False,
                )
            ]
            panel = string.ascii_letters[2 * row + column]
            title = f"({panel}) T = {temperature:g} \N{DEGREE SIGN}C, " + fixed_label.format(
                getattr(choice, fixed)
            )
            axes[2 * row + column].set_title(title)
            rows += _draw_series(axes[2 * row + column], panel, series)
    if not rows:
        style.say_in_panel(axes[0], _NO_POINT)
    else:
        for axis in axes[:2]:
            axis.legend(loc="upper left", ncols=2, handletextpad=0.2, columnspacing=0.8)
        _leave_room_for_legend(axes)
    return _finish(figure), rows


@register(
    name="fig03",
    paper="Fig. 3",
    title="Traction curves of all oils at one temperature",
    caption="Traction coefficient against slide-roll ratio, one panel per pressure. Symbols: "
    "plateau means with the 95 % interval of their random error; lines: fitted law.",
    category="Paper",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("figures", "oils", "rigs", "same_set_point", "campaign.matrix"),
    draws=_CURVES,
)
def fig03(results: CampaignTables, settings: Settings) -> Drawing:
    """mu of all oils against slip at one temperature, one panel per pressure."""
    results = results.replace(runs=with_levels(results.runs, settings))
    choice = settings.figures.fig03
    oils = list(settings.oils)
    pressures = _levels(results, settings.campaign, "max_hertz_pressure_gpa")
    figure, axes = style.panels(1, max(len(pressures), 1), style.DOUBLE_COLUMN_IN, 2.6)
    rows = []
    for number, (axis, pressure) in enumerate(zip(axes, pressures, strict=False)):
        where = {
            "max_hertz_pressure_gpa": pressure,
            "entrainment_speed_m_s": choice.entrainment_speed_m_s,
            "inlet_temperature_c": choice.inlet_temperature_c,
        }
        series = [
            _Series(
                oil,
                oil,
                _select(results, oil, where),
                FittedLaw.of(results.coefficients, oil),
                style.oil_colour(oil, oils),
                style.oil_marker(oil, oils),
            )
            for oil in oils
        ]
        panel = string.ascii_letters[number]
        axis.set_title(f"({panel}) P = {pressure:g} GPa")
        rows += _draw_series(axis, panel, series)
    if not rows:
        style.say_in_panel(axes[0], _NO_POINT)
    else:
        axes[0].legend(
            loc="upper left", title=_fixed_words(choice), title_fontsize=7, alignment="left"
        )
        _leave_room_for_legend(axes)
    return _finish(figure), rows


@register(
    name="curves",
    title="All curves",
    caption="Traction coefficient against slide-roll ratio of every accepted plateau, one panel "
    "per oil, and the fitted law at each tested condition.",
    category="Data quality",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils",),
    draws=_CURVES,
)
def curves(results: CampaignTables, settings: Settings) -> Drawing:
    """Every accepted point of every oil, and the fit at each of its conditions."""
    oils = list(settings.oils)
    width = style.SINGLE_COLUMN_IN if len(oils) == 1 else style.DOUBLE_COLUMN_IN
    figure, axes = style.panels(1, len(oils), width, 2.8)
    rows = []
    for number, (axis, oil) in enumerate(zip(axes, oils, strict=True)):
        of_oil = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
        panel = string.ascii_letters[number]
        axis.set_title(f"({panel}) {oil}")
        if of_oil.empty:
            style.say_in_panel(axis, _NO_POINT)
            continue
        conditions = list(_conditions(results, of_oil))
        told_apart = 1 < len(conditions) <= _CONDITIONS_TOLD_APART
        colour = style.oil_colour(oil, oils)
        colours: Iterable[Any] = (
            style.shades(colour, len(conditions)) if told_apart else itertools.repeat("black")
        )
        law = FittedLaw.of(results.coefficients, oil)
        series = [
            _Series(name, oil, points, law, shade, marker)
            for (name, points), shade, marker in zip(
                conditions, colours, itertools.cycle(style.MARKERS), strict=False
            )
        ]
        rows += (
            _draw_series(axis, panel, series)
            if told_apart
            else _draw_cloud(axis, panel, colour, series)
        )
        axis.legend(loc="best", fontsize=6)
    bars = "bars: 95 % (random part); " if any(len(axis.containers) for axis in axes) else ""
    _finish(figure, f"points: plateau means; {bars}lines: fit")
    return figure, rows


# More conditions than this in one panel cannot be told apart by shade and symbol.
_CONDITIONS_TOLD_APART = 6


def _draw_cloud(
    axis: Axes, panel: str, colour: str, series: Sequence[_Series]
) -> list[pd.DataFrame]:
    """All points in one colour, with the fit of each condition through them."""
    points = pd.concat([condition.points for condition in series])
    # one line lies on its points, many of them below all points
    one = len(series) == 1
    many = one and len(points) > 2000
    axis.plot(
        points["slide_roll_ratio"],
        points["traction_coefficient"],
        ".",
        color=colour,
        markersize=1.6 if many or not one else 3.5,
        alpha=0.15 if many else 0.7,
        rasterized=True,
    )
    # a sample in the legend that can be seen
    axis.plot([], [], ".", color=colour, markersize=5, label=f"points ({len(points)})")
    # so many error bars would hide the points: none is drawn
    cloud = replace(series[0], label=series[0].oil, points=points)
    drawn = [_measured_rows(panel, cloud).assign(traction_coefficient_se=np.nan)]
    for condition in series:
        line = _fit_rows(panel, condition, points)
        axis.plot(
            line["slide_roll_ratio"],
            line["traction_coefficient"],
            color=condition.colour,
            linewidth=1.1 if one else 0.3,
            zorder=3 if one else 1.5,
        )
        drawn.append(line)
    axis.plot([], [], color="black", label="fit")
    return drawn


def _levels(results: CampaignTables, campaign: Campaign, name: str) -> list[float]:
    """Levels of a condition: those of the campaign's matrix, else those that runs were set to."""
    if campaign.matrix is not None:
        return list(getattr(campaign.matrix, name))
    return sorted(results.runs[f"nominal_{name}"].dropna().unique())


def _select(results: CampaignTables, oil: str, where: Mapping[str, float]) -> pd.DataFrame:
    """Accepted points of the runs of an oil at given levels."""
    runs = results.runs[results.runs["oil"] == oil]
    for name, level in where.items():
        runs = runs[np.isclose(runs[f"nominal_{name}"], level)]
    points = results.points
    return points[points["accepted"] & points["run_id"].isin(runs["run_id"])]


def _conditions(
    results: CampaignTables, points: pd.DataFrame
) -> Iterable[tuple[str, pd.DataFrame]]:
    """Each set of set points in words, and its points."""
    names = [f"nominal_{name}" for name in CONDITIONS]
    joined = points.merge(results.runs[["run_id", *names]], on="run_id")
    for _, group in joined.groupby(names, dropna=False):
        known = zip(group[names].iloc[0], ("GPa", "m/s", "\N{DEGREE SIGN}C"), strict=True)
        words = ", ".join(f"{level:g} {unit}" for level, unit in known if not np.isnan(level))
        yield words, group


def _draw_series(axis: Axes, panel: str, series: Iterable[_Series]) -> list[pd.DataFrame]:
    """Draw the series of one panel and return exactly what was drawn."""
    rows = []
    for curve in series:
        if curve.points.empty:
            continue
        measured, line = _measured_rows(panel, curve), _fit_rows(panel, curve, curve.points)
        axis.plot(line["slide_roll_ratio"], line["traction_coefficient"], color=curve.colour)
        axis.errorbar(
            measured["slide_roll_ratio"],
            measured["traction_coefficient"],
            yerr=_SE_DRAWN * measured["traction_coefficient_se"],
            fmt=curve.marker,
            color=curve.colour,
            markerfacecolor="white",
            markeredgewidth=0.7,
            elinewidth=0.7,
            label=curve.label,
        )
        rows += [measured, line]
    return rows


_DRAWN_NUMBERS = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]


def _measured_rows(panel: str, curve: _Series) -> pd.DataFrame:
    return curve.points[_DRAWN_NUMBERS].assign(
        panel=panel, series=curve.label, kind="measured", oil=curve.oil
    )


def _fit_rows(panel: str, curve: _Series, points: pd.DataFrame) -> pd.DataFrame:
    """The fit at the mean conditions of a curve, over the slip of some points."""
    condition = curve.points[list(curve.law.law.conditions)].mean().to_numpy(dtype=np.float64)
    slip = np.linspace(0, float(points["slide_roll_ratio"].abs().max()), 151)
    mu = curve.law.traction(condition, slip)
    return pd.DataFrame({"slide_roll_ratio": slip, "traction_coefficient": mu}).assign(
        panel=panel, series=curve.label, kind="fit", oil=curve.oil
    )


def _fixed_words(choice: Fig03Settings) -> str:
    return (
        f"U = {choice.entrainment_speed_m_s:g} m/s, "
        f"T = {choice.inlet_temperature_c:g} \N{DEGREE SIGN}C"
    )


def _leave_room_for_legend(axes: list[Axes]) -> None:
    axes[0].set_ylim(0, axes[0].get_ylim()[1] * 1.22)
    axes[0].set_xlim(left=-0.005)


def _finish(
    figure: Figure,
    key: str = "symbols: plateau means, 95 % interval (random part); lines: fit",
) -> Figure:
    style.label_traction_axes(figure)
    style.say_key(figure, key)
    return figure
