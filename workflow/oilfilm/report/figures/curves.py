"""What was measured: mu against slip with the fit, residuals of the fit, coverage of the matrix."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import NothingToDrawError, Panel, Sheet, oil_grid, register
from oilfilm.report.words import CONDITIONS as CONDITION_WORDS
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import SET_POINTS, with_levels, with_measured
from oilfilm.traction.law import CONDITIONS

NO_POINT = "no accepted point\nat the conditions\nof this figure\n(config: figures)"
# More conditions than this in one panel cannot be told apart by shade and symbol.
_MAX_CONDITIONS_APART = 6
# Symbols and bars of more points than this in one panel would hide the lines.
_MAX_POINTS_WITH_BARS = 2000
# More lines than this in one panel are one dark area, and each takes 2 kB of SVG.
_MAX_FITS_DRAWN = 500
# Its multiples, modulo 1, are spread evenly and without a period. They choose the conditions whose
# fits are drawn: of every third condition, by contrast, all may have the same temperature.
_GOLDEN_RATIO = (5**0.5 - 1) / 2
_MEASURED = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
# Number of groups of equally many points, where no set points tell levels apart.
_GROUP_COUNT = 15
_THOUSANDTHS_PER_ONE = 1e3


@dataclass(frozen=True)
class Series:
    """One curve of a panel: the points of some runs and the fit at their mean conditions."""

    label: str
    oil: str
    points: pd.DataFrame
    fitted: FittedLaw
    colour: Any
    marker: str

    def fit(self, largest_slip: float) -> tuple[Any, Any]:
        """Slip and fitted mu at the mean conditions of the points."""
        condition = self.points[list(self.fitted.law.conditions)].mean().to_numpy(dtype=np.float64)
        slip = np.linspace(0, largest_slip, 151)
        return slip, self.fitted.traction(condition, slip)


def draw_series(panel: Panel, series: Iterable[Series]) -> None:
    """Points with their errors, and the fit through them, of each curve that has points."""
    with_points = [curve for curve in series if not curve.points.empty]
    if not with_points:
        panel.say(NO_POINT)
    for curve in with_points:
        x, y, se = curve.points[_MEASURED].to_numpy(dtype=float).T
        bar = style.SE_DRAWN * se
        names: dict[str, Any] = {"oil": curve.oil, "label": curve.label}
        look = {"marker": curve.marker, "color": curve.colour, "label": curve.label}
        panel.dots("measured", x, y, look | style.BAR_LOOK, lower=y - bar, upper=y + bar, **names)
        panel.line("fit", *curve.fit(np.abs(x).max()), {"color": curve.colour}, **names)


@register(
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
)
def curves(results: CampaignTables, settings: Settings) -> Sheet:
    """All curves.

    Traction coefficient of all accepted plateaus against slide-roll ratio, one panel per oil.
    Points: plateau means. Bars, where there are few points: 95 % interval of the random error.
    Lines: fitted law at each tested condition; where only some are drawn, the legend says so.
    """
    oils = list(settings.oils)
    sheet, panels = oil_grid(oils, height=2.2)
    # runs without stated set points would all look like one condition: their measured means count
    runs = with_levels(with_measured(results.runs, results.points), settings)
    for panel, _, oil in panels:
        of_oil = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
        if of_oil.empty:
            panel.say("no accepted point")
            continue
        fitted = FittedLaw.of(results.configured.coefficients, oil)
        # one table per condition: columns that nobody draws would take most of the memory
        columns = ["run_id", *fitted.law.conditions, *_MEASURED]
        conditions = _points_by_condition(runs, of_oil[columns])
        colour = style.oil_colour(oil, oils)
        told_apart = (
            len(conditions) <= _MAX_CONDITIONS_APART and len(of_oil) <= _MAX_POINTS_WITH_BARS
        )
        colours: Iterable[Any] = itertools.repeat("black")
        if told_apart:
            colours = style.shades(colour, len(conditions))
        looks = zip(conditions.items(), colours, itertools.cycle(style.MARKERS), strict=False)
        series = [
            Series(label, oil, points, fitted, shade, marker)
            for (label, points), shade, marker in looks
        ]
        if told_apart:
            draw_series(panel, series)
        else:
            _draw_cloud(panel, colour, series)
        panel.axis.legend(loc="upper left", fontsize=6)
    if sheet.parts:
        # all panels have one scale; room for the legends
        bottom, top = sheet.axes[0].get_ylim()
        sheet.axes[0].set_ylim(bottom, top + 0.18 * (top - bottom))
    sheet.label(style.CONDITION_LABELS["slide_roll_ratio"], style.TRACTION_LABEL)
    return sheet


def _points_by_condition(runs: pd.DataFrame, points: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """The points of each condition, by its label, such as `1.25 GPa, 30 m/s`.

    Args:
        runs: Runs with the levels of their set points (`with_levels`).
        points: Accepted points of one oil.
    """
    names, units = list(SET_POINTS), ("GPa", "N", "m/s", "\N{DEGREE SIGN}C")
    by_label = {}
    with_set_points = points.merge(runs[["run_id", *names]], on="run_id")
    for _, group in with_set_points.groupby(names, dropna=False):
        levels = zip(group[names].iloc[0], units, strict=True)
        label = ", ".join(f"{level:.4g} {unit}" for level, unit in levels if not np.isnan(level))
        by_label[label] = group
    return by_label


def _draw_cloud(panel: Panel, colour: str, series: Sequence[Series]) -> None:
    """All points in one colour, with the fits at their conditions."""
    points = pd.concat([curve.points for curve in series])
    x, y, _ = points[_MEASURED].to_numpy(dtype=float).T
    look: style.Look = {"marker": ".", "color": colour, "alpha": 0.7, "markersize": 1.6}
    # no error bars: so many would hide the points
    panel.dots("measured", x, y, look | {"rasterized": True}, oil=series[0].oil)
    # for the legend alone: a symbol that is large enough to be seen there
    panel.axis.plot([], [], ".", color=colour, markersize=5, label=f"points ({len(points)})")
    chosen = np.argsort(np.arange(len(series)) * _GOLDEN_RATIO % 1)[:_MAX_FITS_DRAWN]
    # few lines are drawn over their points, many lines under all points
    few = len(series) <= _MAX_CONDITIONS_APART
    look = {"color": "black", "linewidth": 1.1 if few else 0.3, "zorder": 3 if few else 1.5}
    largest_slip = float(np.abs(x).max())
    for number in sorted(chosen):
        curve = series[number]
        slip, mu = curve.fit(largest_slip)
        panel.line("fit", slip, mu, look, oil=curve.oil, label=curve.label)
    not_all = f" ({len(chosen)} of {len(series)} conditions)" if len(chosen) < len(series) else ""
    panel.axis.plot([], [], color="black", label=f"fit{not_all}")


@register(
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
)
def residuals(results: CampaignTables, settings: Settings) -> Sheet:
    """Residuals of the fit.

    Measured minus fitted traction coefficient of all accepted plateaus against maximum Hertz
    pressure (GPa), entrainment speed (m/s), inlet temperature (\N{DEGREE SIGN}C) and slide-roll
    ratio. Symbols with bars: mean and scatter at each level. A mean away from zero shows a
    systematic error of the law.
    """
    oils, runs = list(settings.oils), with_levels(results.runs, settings)
    layout: style.Look = {"height": 1.1, "down": 0.3, "sharex": "col", "sharey": "row"}
    sheet = Sheet(len(oils) * len(CONDITION_WORDS), len(CONDITION_WORDS), **layout)
    for row, oil in enumerate(oils):
        points, colour = _residuals(results, runs, oil), style.oil_colour(oil, oils)
        for column, (condition, (symbol, _, unit)) in enumerate(CONDITION_WORDS.items()):
            panel = sheet.panel(row * len(CONDITION_WORDS) + column)
            panel.axis.set_xlabel(f"{symbol} ({unit})" if unit else f"|{symbol}|")
            delta = f"\N{GREEK CAPITAL LETTER DELTA}{style.MU} ({style.THOUSANDTHS})"
            panel.axis.set_ylabel(f"{oil}: {delta}", fontsize=7)
            if points is None:
                panel.say("no fit")
            elif points[condition].isna().all():
                panel.say("not known")
            else:
                _draw_residuals(panel, points, condition, oil, colour)
    sheet.label()
    plateau_handle = style.symbol_handle("plateau", ".", color="black", markersize=3)
    label = "mean of a level, with the standard deviation of its plateaus"
    level_handle = style.symbol_handle(label, "o", color="black", markerfacecolor="white")
    sheet.legend([plateau_handle, level_handle])
    return sheet


def _draw_residuals(
    panel: Panel, points: pd.DataFrame, condition: str, oil: str, colour: str
) -> None:
    """Residuals of one oil against one condition, with mean and scatter at each of its levels."""
    look: style.Look = {"alpha": 0.25, "markersize": 1.2, "rasterized": True, "marker": "."}
    look["color"] = colour
    panel.dots("point", points[condition], points["residual"], look, oil=oil)
    panel.axis.axhline(0, color="black", linewidth=0.6)
    by_level = points.groupby(_levels(points, condition), observed=True)
    means = by_level.agg(x=(condition, "mean"), y=("residual", "mean"), sd=("residual", "std"))
    level, mean, sd = means.to_numpy().T
    look = {"marker": "o", "color": "black", **style.BAR_LOOK}
    panel.dots("mean", level, mean, look, oil=oil, lower=mean - sd, upper=mean + sd)


def _residuals(results: CampaignTables, runs: pd.DataFrame, oil: str) -> pd.DataFrame | None:
    """Accepted points with their residual (in 1e-3) and their set points; None without a fit."""
    of_oil = results.configured.coefficients[results.configured.coefficients["oil"] == oil]
    points = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
    if of_oil.empty or points.empty:
        return None
    fitted = FittedLaw.of(of_oil, oil)
    slip = points["slide_roll_ratio"].to_numpy()
    conditions = points[list(fitted.law.conditions)].to_numpy()
    fitted_mu = fitted.predict(conditions, slip).traction_coefficient
    if np.isnan(fitted_mu).all():
        return None
    # slip and traction of a rig that reverses the slip change sign together
    residual = np.where(slip < 0, -1, 1) * (points["traction_coefficient"] - fitted_mu)
    with_residuals = points.assign(
        residual=_THOUSANDTHS_PER_ONE * residual, slide_roll_ratio=np.abs(slip)
    )
    set_points = [f"nominal_{name}" for name in CONDITIONS]
    return with_residuals.merge(runs[["run_id", *set_points]], on="run_id")


def _levels(points: pd.DataFrame, condition: str) -> "pd.Series[Any]":
    """The level of each point: its set point, or a group of equally many points."""
    nominal = f"nominal_{condition}"
    if nominal in points and points[nominal].notna().all():
        return points[nominal]
    return pd.qcut(points[condition], _GROUP_COUNT, duplicates="drop")


# More rows of panels than this are no map.
_MAX_PANEL_ROWS = 12
_SPEED = "nominal_entrainment_speed_m_s"
_TEMPERATURE = "nominal_inlet_temperature_c"
_PRESSURE = "nominal_max_hertz_pressure_gpa"
_LOAD = "nominal_load_n"


@register(family="data", tables=("coverage",), settings=("oils",))
def coverage(results: CampaignTables, settings: Settings) -> Sheet:
    """Coverage of the test matrix.

    Conditions of the test matrix and of all runs, one column of panels per oil and one row per
    maximum Hertz pressure P or, where none is stated, load W. Abscissa: entrainment speed U (m/s).
    Ordinate: inlet temperature T (\N{DEGREE SIGN}C). Numbers: accepted runs of all runs, where
    there is not one accepted run. Missing: no run of the condition could be read. Conditions that
    are not stated as a whole are not shown.
    """
    table = results.coverage
    row_column, row_title = _LOAD, "W = {:g} N"
    if table[_PRESSURE].any():
        row_column, row_title = _PRESSURE, "P = {:g} GPa"
    table = table.assign(runs=table["runs_accepted"] + table["runs_refused"])
    conditions = table.groupby(["oil", _TEMPERATURE, _SPEED, row_column], as_index=False)
    cells = conditions[["runs_accepted", "runs"]].sum()
    states = cells["runs_accepted"] > 0, cells["runs"] > 0
    cells["state"] = np.select(states, ["accepted", "refused"], "missing")
    levels = sorted(cells[row_column].unique())
    if not 0 < len(levels) <= _MAX_PANEL_ROWS:
        raise NothingToDrawError(
            f"Conditions at {len(levels)} pressures or loads: there is nothing to cover,\n"
            "or more than a map can show. The table coverage has all runs.\n"
            "Set points are read from the headers of logs and from\n"
            "`set_points` of the campaign file."
        )
    sheet, panels = oil_grid(
        style.oils_in(cells, settings),
        rows=levels,
        title=lambda level, oil: f"{oil}, {row_title.format(level)}",
        height=1.1,
    )
    for panel, level, oil in panels:
        of_panel = cells[(cells["oil"] == oil) & (cells[row_column] == level)]
        panel.axis.margins(0.15)
        for state, of_state in of_panel.groupby("state"):
            x, y, look = of_state[_SPEED], of_state[_TEMPERATURE], _symbol(str(state))
            counts = of_state["runs_accepted"].astype(str) + "/" + of_state["runs"].astype(str)
            # the usual case, one run which is accepted, gets no number
            labels = counts.where(counts != "1/1", "")
            panel.dots(state, x, y, look | {"markersize": 3.6}, oil=oil, label=labels)
            for number in labels.index[labels != ""]:
                beside: style.Look = {"xytext": (3, -2), "textcoords": "offset points"}
                panel.axis.annotate(labels[number], (x[number], y[number]), **beside, fontsize=6)
    sheet.label("U (m/s)", "T (\N{DEGREE SIGN}C)", fontsize=7)
    numbers = cells["state"].value_counts()
    handles = [
        style.symbol_handle(f"{state} ({numbers.get(state, 0)})", **_symbol(state), markersize=4)
        for state in style.STATE_COLOURS
    ]
    sheet.legend(handles, "Conditions by state; beside a symbol: accepted/all runs")
    return sheet


def _symbol(state: str) -> style.Look:
    """Marker and colour of a state; an open symbol where there is no run."""
    colour = style.STATE_COLOURS[state]
    face = "white" if state == "missing" else colour
    return {"marker": style.STATE_MARKERS[state], "color": colour, "markerfacecolor": face}
