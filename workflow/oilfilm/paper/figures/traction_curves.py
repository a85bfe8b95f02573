"""mu against slip at chosen conditions, measured and fitted: Figs 2 and 3 of the paper."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from oilfilm.curation.coverage import with_levels
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.curves import NO_POINT, Series, draw_series
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Sheet
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS


@register(
    paper="Fig. 2",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("figures", "oils", "rigs", "same_set_point", "campaign.matrix"),
)
def fig02(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction curves of one oil.

    Traction coefficient against slide-roll ratio, one row of panels per inlet temperature.
    Left: by maximum Hertz pressure; right: by entrainment speed. Symbols: plateau means with
    the 95 % interval of their random error. Lines: fitted law.
    """
    runs, choice = with_levels(results.runs, settings), settings.figures.fig02
    oil, temperatures = choice.oil, choice.inlet_temperature_c
    law = FittedLaw.of(results.configured.coefficients, oil)
    base = style.oil_colour(oil, list(settings.oils))
    sheet = Sheet(2 * len(temperatures), 2, height=1.7, sharex=True, sharey=True)
    panels = itertools.product(temperatures, ((_PRESSURE, _SPEED), (_SPEED, _PRESSURE)))
    for number, (temperature, (varied, fixed)) in enumerate(panels):
        same = {_TEMPERATURE: temperature, fixed: getattr(choice, fixed)}
        levels = _levels(runs, settings.campaign, varied)
        looks = zip(
            levels, style.shades(base, len(levels)), itertools.cycle(style.MARKERS), strict=False
        )
        series = []
        for level, shade, marker in looks:
            points = _select(results.points, runs, oil, {**same, varied: level})
            phrase = style.level_phrases({varied: level})
            series.append(Series(phrase, oil, points, law, shade, marker))
        shown = sum(len(curve.points) > 0 for curve in series)
        count = "" if shown in (0, len(series)) else f" ({shown} of {len(series)} curves)"
        draw_series(sheet.panel(number, style.level_phrases(same) + count), series)
    _finish(sheet, [sheet.axes[::2], sheet.axes[1::2]])
    return sheet


@register(
    paper="Fig. 3",
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("figures", "oils", "rigs", "same_set_point", "campaign.matrix"),
)
def fig03(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction curves of all oils at one temperature.

    Traction coefficient against slide-roll ratio, one panel per maximum Hertz pressure.
    Symbols: plateau means with the 95 % interval of their random error. Lines: fitted law.
    """
    runs, choice = with_levels(results.runs, settings), settings.figures.fig03
    oils = list(settings.oils)
    same = {_SPEED: choice.entrainment_speed_m_s, _TEMPERATURE: choice.inlet_temperature_c}
    pressures = _levels(runs, settings.campaign, _PRESSURE)
    count = max(len(pressures), 1)
    sheet = Sheet(count, count, width=style.DOUBLE_COLUMN_IN, sharex=True, sharey=True)
    for number, pressure in enumerate(pressures):
        series = []
        for oil in oils:
            points = _select(results.points, runs, oil, {_PRESSURE: pressure, **same})
            law = FittedLaw.of(results.configured.coefficients, oil)
            series.append(Series(oil, oil, points, law, *style.oil_look(oil, oils).values()))
        draw_series(sheet.panel(number, style.level_phrases({_PRESSURE: pressure})), series)
    shown = set(sheet.drawn()["oil"])
    lost = style.lost_handles([oil for oil in oils if oil not in shown], "no accepted point here")
    _finish(sheet, [sheet.axes], lost, style.level_phrases(same))
    return sheet


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
    sheet: Sheet, groups: Sequence[Sequence[Axes]], lost: Sequence[Any] = (), title: str = ""
) -> None:
    """Labels of the axes, and below each group of panels the series that any of them shows."""
    sheet.label(style.CONDITION_LABELS["slide_roll_ratio"], style.TRACTION_LABEL)
    if not sheet.parts:
        if not sheet.axes[0].texts:
            sheet.panel(0).say(NO_POINT)
        return
    columns = []
    for of_group in groups:
        entries = [axis.get_legend_handles_labels() for axis in of_group]
        # a series may have no points in the first panel; the fullest one gives the order
        fullest_first = sorted(entries, key=lambda entry: -len(entry[1]))
        shown = {
            label: handle for both in fullest_first for handle, label in zip(*both, strict=True)
        }
        columns.append([*shown.values()])
    rows = max(map(len, columns))
    filled = [[*column, *style.lost_handles([""] * (rows - len(column)))] for column in columns]
    handles = [handle for column in filled for handle in column]
    sheet.legend([*handles, *lost], title, columns=len(groups) if len(groups) > 1 else 0)
    sheet.axes[0].set_ylim(bottom=0)
    sheet.axes[0].set_xlim(left=-0.005)
