"""mu against slip: measured points with their errors, and the fit as lines (figs 2 and 3)."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.curation.coverage import SET_POINTS, with_levels, with_measured
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.facts import counted
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use
from oilfilm.traction.law import CONDITIONS

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS
_NO_POINT = "no accepted point\nat the conditions\nof this figure\n(config: figures)"
# More conditions than this in one panel cannot be told apart by shade and symbol.
_CONDITIONS_TOLD_APART = 6
# Symbols of more points would hide the lines.
_POINTS_TOLD_APART = 2000
# More lines than this in one panel are one dark area, and each takes 2 kB of SVG.
_FITS_DRAWN = 500
# Its multiples modulo 1 are spread evenly without a period. Every third condition, by contrast, may
# have the same temperature.
_GOLDEN_RATIO = (5**0.5 - 1) / 2
_MEASURED = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]


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
    columns="panel series kind oil slide_roll_ratio traction_coefficient traction_coefficient_se",
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
    caption="Traction coefficient against slide-roll ratio, one row of panels per inlet "
    "temperature. Left: by maximum Hertz pressure; right: by entrainment speed. Symbols: plateau "
    "means with the 95 % interval of their random error. Lines: fitted law.",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("figures", "oils", "rigs", "same_set_point", "campaign.matrix"),
    draws=_CURVES,
)
def fig02(results: CampaignTables, settings: Settings) -> Drawing:
    """mu of one oil against slip by pressure (left) and speed (right), one row per temperature."""
    runs = with_levels(results.runs, settings)
    choice = settings.figures.fig02
    oil, temperatures = choice.oil, choice.inlet_temperature_c
    law = FittedLaw.of(results.coefficients, oil)
    base = style.oil_colour(oil, list(settings.oils))
    figure, axes = style.panels(
        len(temperatures), 2, style.DOUBLE_COLUMN_IN, 2.1 * len(temperatures)
    )
    drawn = []
    panels = itertools.product(temperatures, ((_PRESSURE, _SPEED), (_SPEED, _PRESSURE)))
    for number, (temperature, (varied, fixed)) in enumerate(panels):
        same = {_TEMPERATURE: temperature, fixed: getattr(choice, fixed)}
        levels = _levels(runs, settings.campaign, varied)
        shades = style.shades(base, len(levels))
        series = [
            _Series(
                style.level_phrases({varied: level}),
                oil,
                _select(results.points, runs, oil, {**same, varied: level}),
                law,
                shade,
                marker,
            )
            for level, shade, marker in zip(
                levels, shades, itertools.cycle(style.MARKERS), strict=False
            )
        ]
        panel = style.title_panel(axes[number], number, style.level_phrases(same))
        drawn += _draw_series(axes[number], panel, series)
    _finish(
        figure, axes, drawn, [axes[::2], axes[1::2]], ncols=2, handletextpad=0.2, columnspacing=0.8
    )
    return figure, drawn


@register(
    name="fig03",
    paper="Fig. 3",
    title="Traction curves of all oils at one temperature",
    caption="Traction coefficient against slide-roll ratio, one panel per maximum Hertz "
    "pressure. Symbols: plateau means with the 95 % interval of their random error. Lines: "
    "fitted law.",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("figures", "oils", "rigs", "same_set_point", "campaign.matrix"),
    draws=_CURVES,
)
def fig03(results: CampaignTables, settings: Settings) -> Drawing:
    """mu of all oils against slip at one temperature, one panel per pressure."""
    runs = with_levels(results.runs, settings)
    choice = settings.figures.fig03
    oils = list(settings.oils)
    same = {_SPEED: choice.entrainment_speed_m_s, _TEMPERATURE: choice.inlet_temperature_c}
    pressures = _levels(runs, settings.campaign, _PRESSURE)
    figure, axes = style.panels(1, max(len(pressures), 1), style.DOUBLE_COLUMN_IN, 2.6)
    drawn = []
    for number, pressure in enumerate(pressures):
        series = [
            _Series(
                oil,
                oil,
                _select(results.points, runs, oil, {_PRESSURE: pressure, **same}),
                FittedLaw.of(results.coefficients, oil),
                style.oil_colour(oil, oils),
                style.oil_marker(oil, oils),
            )
            for oil in oils
        ]
        panel = style.title_panel(axes[number], number, style.level_phrases({_PRESSURE: pressure}))
        drawn += _draw_series(axes[number], panel, series)
    title = style.level_phrases(same)
    shown = {oil for part in drawn for oil in part["oil"]}
    lost = [oil for oil in oils if oil not in shown]
    key = f"\nno accepted point here: {', '.join(lost)}" if shown and lost else ""
    legend: dict[str, Any] = {"title": title, "title_fontsize": 7, "alignment": "left"}
    _finish(figure, axes, drawn, [axes], key, **legend)
    return figure, drawn


def _levels(runs: pd.DataFrame, campaign: Campaign, name: str) -> list[float]:
    """Levels of a condition: those of the campaign's matrix, else those that runs were set to."""
    if campaign.matrix is not None:
        return list(getattr(campaign.matrix, name))
    return sorted(runs[f"nominal_{name}"].dropna().unique())


def _select(
    points: pd.DataFrame, runs: pd.DataFrame, oil: str, levels: Mapping[str, float]
) -> pd.DataFrame:
    """Accepted points of the runs of an oil at given levels."""
    runs = runs[runs["oil"] == oil]
    for name, level in levels.items():
        runs = runs[np.isclose(runs[f"nominal_{name}"], level)]
    return points[points["accepted"] & points["run_id"].isin(runs["run_id"])]


def _finish(
    figure: Figure,
    axes: Sequence[Axes],
    drawn: Sequence[pd.DataFrame],
    groups: Iterable[Sequence[Axes]],
    key: str = "",
    **legend: Any,
) -> None:
    """Legends, or why there is nothing to draw; labels of the axes and key.

    The first panel of each group has the legend of the group, and room for it.
    """
    if drawn:
        for of_group in groups:
            entries = [axis.get_legend_handles_labels() for axis in of_group]
            # a series may have no points in the first panel; the fullest one gives the order
            fullest_first = sorted(entries, key=lambda entry: -len(entry[1]))
            shown = {
                label: handle
                for handles, labels in fullest_first
                for handle, label in zip(handles, labels, strict=True)
            }
            of_group[0].legend(shown.values(), shown.keys(), loc="upper left", **legend)
        axes[0].set_ylim(0, axes[0].get_ylim()[1] * 1.22)
        axes[0].set_xlim(left=-0.005)
    elif not axes[0].texts:
        style.say_in_panel(axes[0], _NO_POINT)
    style.label_traction_axes(figure)
    symbols = "symbols: plateau means, 95 % interval (random part); lines: fit"
    style.say_key(figure, symbols + key)


@register(
    name="curves",
    title="All curves",
    caption="Traction coefficient of all accepted plateaus against slide-roll ratio, one "
    "panel per oil. Lines: fitted law at each tested condition; where only some are drawn, the "
    "legend says so.",
    category="Data quality",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
    draws=_CURVES,
)
def curves(results: CampaignTables, settings: Settings) -> Drawing:
    """Every accepted point of every oil, and the fit at its conditions."""
    oils = list(settings.oils)
    width = style.SINGLE_COLUMN_IN if len(oils) == 1 else style.DOUBLE_COLUMN_IN
    figure, axes = style.panels(1, len(oils), width, 2.8)
    # runs at speeds that nobody stated are no repeats of one condition
    runs = with_levels(with_measured(results.runs, results.points), settings)
    drawn = []
    for number, (axis, oil) in enumerate(zip(axes, oils, strict=True)):
        of_oil = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
        panel = style.title_panel(axis, number, oil)
        if of_oil.empty:
            count = int((runs["oil"] == oil).sum())
            why = (
                f"no accepted point\n({counted(count, 'run')} refused)" if count else "no run read"
            )
            style.say_in_panel(axis, why)
            continue
        law = FittedLaw.of(results.coefficients, oil)
        # one table per condition: columns that nobody draws would take most of the memory
        drawable = of_oil[["run_id", *law.law.conditions, *_MEASURED]]
        conditions = list(_conditions(runs, drawable))
        told_apart = (
            1 < len(conditions) <= _CONDITIONS_TOLD_APART and len(of_oil) <= _POINTS_TOLD_APART
        )
        colour = style.oil_colour(oil, oils)
        colours: Iterable[Any] = (
            style.shades(colour, len(conditions)) if told_apart else itertools.repeat("black")
        )
        series = [
            _Series(label, oil, points, law, shade, marker)
            for (label, points), shade, marker in zip(
                conditions, colours, itertools.cycle(style.MARKERS), strict=False
            )
        ]
        drawn += (
            _draw_series(axis, panel, series)
            if told_apart
            else _draw_cloud(axis, panel, colour, series)
        )
        axis.legend(loc="best", fontsize=6)
    if drawn:
        # all panels have one scale; room for two lines of a legend
        bottom, top = axes[0].get_ylim()
        axes[0].set_ylim(bottom, top + 0.18 * (top - bottom))
    bars = "bars: 95 % (random part); " if any(len(axis.containers) for axis in axes) else ""
    style.label_traction_axes(figure)
    style.say_key(figure, f"points: plateau means; {bars}lines: fit")
    return figure, drawn


def _conditions(runs: pd.DataFrame, points: pd.DataFrame) -> Iterable[tuple[str, pd.DataFrame]]:
    """Each set of set points in words, and its points; `runs` are those of `with_levels`."""
    names = list(SET_POINTS)
    joined = points.merge(runs[["run_id", *names]], on="run_id")
    for _, group in joined.groupby(names, dropna=False):
        levels = zip(group[names].iloc[0], ("GPa", "N", "m/s", "\N{DEGREE SIGN}C"), strict=True)
        label = ", ".join(f"{level:.4g} {unit}" for level, unit in levels if not np.isnan(level))
        yield label, group


def _draw_series(axis: Axes, panel: str, series: Iterable[_Series]) -> list[pd.DataFrame]:
    """Draw the series of one panel and return exactly what was drawn."""
    drawn = []
    for curve in series:
        if curve.points.empty:
            continue
        measured, line = (
            _measured_rows(panel, curve),
            _fit_rows(panel, curve, _largest_slip(curve.points)),
        )
        axis.plot(line["slide_roll_ratio"], line["traction_coefficient"], color=curve.colour)
        axis.errorbar(
            measured["slide_roll_ratio"],
            measured["traction_coefficient"],
            yerr=style.SE_DRAWN * measured["traction_coefficient_se"],
            fmt=curve.marker,
            color=curve.colour,
            markerfacecolor="white",
            markeredgewidth=0.7,
            elinewidth=0.7,
            label=curve.label,
        )
        drawn += [measured, line]
    if not drawn:
        style.say_in_panel(axis, _NO_POINT)
    return drawn


def _draw_cloud(
    axis: Axes, panel: str, colour: str, series: Sequence[_Series]
) -> list[pd.DataFrame]:
    """All points in one colour, with the fits at their conditions through them."""
    points = pd.concat([condition.points for condition in series])
    # few lines are drawn over their points, many lines under all points
    few = len(series) <= _CONDITIONS_TOLD_APART
    many = few and len(points) > _POINTS_TOLD_APART
    axis.plot(
        points["slide_roll_ratio"],
        points["traction_coefficient"],
        ".",
        color=colour,
        markersize=1.6 if many or not few else 3.5,
        alpha=0.15 if many else 0.7,
        rasterized=True,
    )
    # a sample in the legend that can be seen
    axis.plot([], [], ".", color=colour, markersize=5, label=f"points ({len(points)})")
    # so many error bars would hide the points: none is drawn
    cloud = replace(series[0], label=series[0].oil, points=points)
    drawn = [_measured_rows(panel, cloud).assign(traction_coefficient_se=np.nan)]
    width, order = (1.1, 3) if few else (0.3, 1.5)
    largest_slip = _largest_slip(points)
    spread = np.argsort(np.arange(len(series)) * _GOLDEN_RATIO % 1)[:_FITS_DRAWN]
    shown = [series[number] for number in sorted(spread)]
    for condition in shown:
        line = _fit_rows(panel, condition, largest_slip)
        xy = line["slide_roll_ratio"], line["traction_coefficient"]
        axis.plot(*xy, color=condition.colour, linewidth=width, zorder=order)
        drawn.append(line)
    not_all = "" if len(shown) == len(series) else f" ({len(shown)} of {len(series)} conditions)"
    axis.plot([], [], color="black", label=f"fit{not_all}")
    return drawn


def _measured_rows(panel: str, curve: _Series) -> pd.DataFrame:
    return curve.points[_MEASURED].assign(
        panel=panel, series=curve.label, kind="measured", oil=curve.oil
    )


def _largest_slip(points: pd.DataFrame) -> float:
    return float(points["slide_roll_ratio"].abs().max())


def _fit_rows(panel: str, curve: _Series, largest_slip: float) -> pd.DataFrame:
    """The fit at the mean conditions of a curve, up to some slip."""
    condition = curve.points[list(curve.law.law.conditions)].mean().to_numpy(dtype=np.float64)
    slip = np.linspace(0, largest_slip, 151)
    mu = curve.law.traction(condition, slip)
    return pd.DataFrame({"slide_roll_ratio": slip, "traction_coefficient": mu}).assign(
        panel=panel, series=curve.label, kind="fit", oil=curve.oil
    )
