"""mu against slip: measured points with their errors, and the fit as lines."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from oilfilm.curation.coverage import SET_POINTS, with_levels, with_measured
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.document import counted
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

NO_POINT = "no accepted point\nat the conditions\nof this figure\n(config: figures)"
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
class Series:
    """One curve of a panel: the points of some runs and the fit at their mean conditions."""

    label: str
    oil: str
    points: pd.DataFrame
    law: FittedLaw
    colour: Any
    marker: str


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
        law = FittedLaw.of(results.configured.coefficients, oil)
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
            Series(label, oil, points, law, shade, marker)
            for (label, points), shade, marker in zip(
                conditions, colours, itertools.cycle(style.MARKERS), strict=False
            )
        ]
        drawn += (
            draw_series(axis, panel, series)
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


def draw_series(axis: Axes, panel: str, series: Iterable[Series]) -> list[pd.DataFrame]:
    """Draw the series of one panel and return exactly what was drawn."""
    drawn = []
    for curve in series:
        if curve.points.empty:
            continue
        measured = _measured(panel, curve, bars=True)
        line = _fit(panel, curve, _largest_slip(curve.points))
        axis.plot(line["x"], line["y"], color=curve.colour)
        axis.errorbar(
            measured["x"],
            measured["y"],
            yerr=measured["y_upper"] - measured["y"],
            fmt=curve.marker,
            color=curve.colour,
            markerfacecolor="white",
            markeredgewidth=0.7,
            elinewidth=0.7,
            label=curve.label,
        )
        drawn += [measured, line]
    if not drawn:
        style.say_in_panel(axis, NO_POINT)
    return drawn


def _draw_cloud(
    axis: Axes, panel: str, colour: str, series: Sequence[Series]
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
    drawn = [_measured(panel, cloud, bars=False)]
    width, order = (1.1, 3) if few else (0.3, 1.5)
    largest_slip = _largest_slip(points)
    spread = np.argsort(np.arange(len(series)) * _GOLDEN_RATIO % 1)[:_FITS_DRAWN]
    shown = [series[number] for number in sorted(spread)]
    for condition in shown:
        line = _fit(panel, condition, largest_slip)
        axis.plot(line["x"], line["y"], color=condition.colour, linewidth=width, zorder=order)
        drawn.append(line)
    not_all = "" if len(shown) == len(series) else f" ({len(shown)} of {len(series)} conditions)"
    axis.plot([], [], color="black", label=f"fit{not_all}")
    return drawn


def _measured(panel: str, curve: Series, *, bars: bool) -> pd.DataFrame:
    x, y, se = curve.points[_MEASURED].to_numpy(dtype=float).T
    bar = style.SE_DRAWN * se if bars else np.full_like(se, np.nan)
    about = {"oil": curve.oil, "label": curve.label}
    return marks(panel, "measured", x, y, lower=y - bar, upper=y + bar, **about)


def _fit(panel: str, curve: Series, largest_slip: float) -> pd.DataFrame:
    """The fit at the mean conditions of a curve, up to some slip."""
    condition = curve.points[list(curve.law.law.conditions)].mean().to_numpy(dtype=np.float64)
    slip = np.linspace(0, largest_slip, 151)
    mu = curve.law.traction(condition, slip)
    return marks(panel, "fit", slip, mu, oil=curve.oil, label=curve.label)


def _largest_slip(points: pd.DataFrame) -> float:
    return float(points["slide_roll_ratio"].abs().max())
