"""mu against slip at chosen conditions, measured and fitted: Figs 2 and 3 of the paper."""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.curation.coverage import with_levels
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.curves import NO_POINT, Series, draw_series
from oilfilm.report.figures.registry import Drawing, register
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS


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
)
def fig02(results: CampaignTables, settings: Settings) -> Drawing:
    """mu of one oil against slip by pressure (left) and speed (right), one row per temperature."""
    runs = with_levels(results.runs, settings)
    choice = settings.figures.fig02
    oil, temperatures = choice.oil, choice.inlet_temperature_c
    law = FittedLaw.of(results.configured.coefficients, oil)
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
            Series(
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
        drawn += draw_series(axes[number], panel, series)
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
            Series(
                oil,
                oil,
                _select(results.points, runs, oil, {_PRESSURE: pressure, **same}),
                FittedLaw.of(results.configured.coefficients, oil),
                style.oil_colour(oil, oils),
                style.oil_marker(oil, oils),
            )
            for oil in oils
        ]
        panel = style.title_panel(axes[number], number, style.level_phrases({_PRESSURE: pressure}))
        drawn += draw_series(axes[number], panel, series)
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
        style.say_in_panel(axes[0], NO_POINT)
    style.label_traction_axes(figure)
    symbols = "symbols: plateau means, 95 % interval (random part); lines: fit"
    style.say_key(figure, symbols + key)
