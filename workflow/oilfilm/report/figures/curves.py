"""What was measured: mu against slip with the fit, what the fit leaves, coverage of the matrix."""

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
_CONDITIONS_TOLD_APART = 6
# Symbols of more points would hide the lines.
_POINTS_TOLD_APART = 2000
# More lines than this in one panel are one dark area, and each takes 2 kB of SVG.
_FITS_DRAWN = 500
# Its multiples modulo 1 are spread evenly without a period. Every third condition, by contrast, may
# have the same temperature.
_GOLDEN_RATIO = (5**0.5 - 1) / 2
_MEASURED = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
_GROUPS = 15  # of equally many points, where no set points tell levels apart
_MILLI = 1e3


@dataclass(frozen=True)
class Series:
    """One curve of a panel: the points of some runs and the fit at their mean conditions."""

    label: str
    oil: str
    points: pd.DataFrame
    law: FittedLaw
    colour: Any
    marker: str

    def fit(self, largest_slip: float) -> tuple[Any, Any]:
        """Slip and fitted mu at the mean conditions of the points."""
        condition = self.points[list(self.law.law.conditions)].mean().to_numpy(dtype=np.float64)
        slip = np.linspace(0, largest_slip, 151)
        return slip, self.law.traction(condition, slip)


def draw_series(panel: Panel, series: Iterable[Series]) -> None:
    """Points with their errors, and the fit through them, of each curve that has points."""
    nothing = True
    for curve in series:
        if curve.points.empty:
            continue
        nothing = False
        x, y, se = curve.points[_MEASURED].to_numpy(dtype=float).T
        bar = style.SE_DRAWN * se
        about: style.Look = {"oil": curve.oil, "label": curve.label}
        look = {"marker": curve.marker, "color": curve.colour, "label": curve.label}
        panel.dots("measured", x, y, look | style.BAR_LOOK, lower=y - bar, upper=y + bar, **about)
        panel.line("fit", *curve.fit(np.abs(x).max()), {"color": curve.colour}, **about)
    if nothing:
        panel.say(NO_POINT)


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
    # runs at speeds that nobody stated are no repeats of one condition
    runs = with_levels(with_measured(results.runs, results.points), settings)
    for panel, _, oil in panels:
        of_oil = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
        if of_oil.empty:
            panel.say("no accepted point")
            continue
        law = FittedLaw.from_tables(results.configured.coefficients, oil)
        # one table per condition: columns that nobody draws would take most of the memory
        conditions = _conditions(runs, of_oil[["run_id", *law.law.conditions, *_MEASURED]])
        colour = style.oil_colour(oil, oils)
        apart = len(conditions) <= _CONDITIONS_TOLD_APART and len(of_oil) <= _POINTS_TOLD_APART
        shades = style.shades(colour, len(conditions)) if apart else itertools.repeat("black")
        looks = zip(shades, itertools.cycle(style.MARKERS), strict=False)
        series = [
            Series(label, oil, points, law, *look)
            for (label, points), look in zip(conditions.items(), looks, strict=False)
        ]
        if apart:
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


def _conditions(runs: pd.DataFrame, points: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """The points of each set of set points by its phrase; `runs` are those of `with_levels`."""
    names, units = list(SET_POINTS), ("GPa", "N", "m/s", "\N{DEGREE SIGN}C")
    by_phrase = {}
    with_set_points = points.merge(runs[["run_id", *names]], on="run_id")
    for _, group in with_set_points.groupby(names, dropna=False):
        levels = zip(group[names].iloc[0], units, strict=True)
        phrase = ", ".join(f"{level:.4g} {unit}" for level, unit in levels if not np.isnan(level))
        by_phrase[phrase] = group
    return by_phrase


def _draw_cloud(panel: Panel, colour: str, series: Sequence[Series]) -> None:
    """All points in one colour, with the fits at their conditions."""
    points = pd.concat([condition.points for condition in series])
    x, y, _ = points[_MEASURED].to_numpy(dtype=float).T
    look: style.Look = {"marker": ".", "color": colour, "alpha": 0.7, "markersize": 1.6}
    # so many error bars would hide the points: none is drawn
    panel.dots("measured", x, y, look | {"rasterized": True}, oil=series[0].oil)
    # a sample in the legend that can be seen
    panel.axis.plot([], [], ".", color=colour, markersize=5, label=f"points ({len(points)})")
    spread = np.argsort(np.arange(len(series)) * _GOLDEN_RATIO % 1)[:_FITS_DRAWN]
    # few lines are drawn over their points, many lines under all points
    few = len(series) <= _CONDITIONS_TOLD_APART
    look = {"color": "black", "linewidth": 1.1 if few else 0.3, "zorder": 3 if few else 1.5}
    for condition in (series[number] for number in sorted(spread)):
        at, mu = condition.fit(float(np.abs(x).max()))
        panel.line("fit", at, mu, look, oil=condition.oil, label=condition.label)
    not_all = f" ({len(spread)} of {len(series)} conditions)" if len(spread) < len(series) else ""
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
    panels = itertools.product(oils, CONDITION_WORDS.items())
    for number, (oil, (condition, (symbol, _, unit))) in enumerate(panels):
        panel = sheet.panel(number)
        if number % len(CONDITION_WORDS) == 0:
            points = _residuals(results, runs, oil)
        panel.axis.set_xlabel(f"{symbol} ({unit})" if unit else f"|{symbol}|")
        delta = f"\N{GREEK CAPITAL LETTER DELTA}{style.MU} ({style.THOUSANDTHS})"
        panel.axis.set_ylabel(f"{oil}: {delta}", fontsize=7)
        if points is None or points[condition].isna().all():
            panel.say("no fit" if points is None else "not known")
            continue
        look: style.Look = {"alpha": 0.25, "markersize": 1.2, "rasterized": True, "marker": "."}
        look["color"] = style.oil_colour(oil, oils)
        panel.dots("point", points[condition], points["residual"], look, oil=oil)
        panel.axis.axhline(0, color="black", linewidth=0.6)
        groups = points.groupby(_levels(points, condition), observed=True)
        means = groups.agg(x=(condition, "mean"), y=("residual", "mean"), sd=("residual", "std"))
        at, mean, sd = means.to_numpy().T
        look = {"marker": "o", "color": "black", **style.BAR_LOOK}
        panel.dots("mean", at, mean, look, oil=oil, lower=mean - sd, upper=mean + sd)
    sheet.label()
    plateau = style.symbol_handle("plateau", ".", color="black", markersize=3)
    label = "mean of a level, with the standard deviation of its plateaus"
    level = style.symbol_handle(label, "o", color="black", markerfacecolor="white")
    sheet.legend([plateau, level])
    return sheet


def _residuals(results: CampaignTables, runs: pd.DataFrame, oil: str) -> pd.DataFrame | None:
    """Accepted points with their residual and the levels of their run; None without a fit."""
    of_oil = results.configured.coefficients[results.configured.coefficients["oil"] == oil]
    points = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
    if of_oil.empty or points.empty:
        return None
    law = FittedLaw.from_tables(of_oil, oil)
    slip = points["slide_roll_ratio"].to_numpy()
    fitted = law.predict(points[list(law.law.conditions)].to_numpy(), slip).traction_coefficient
    if np.isnan(fitted).all():
        return None
    # slip and traction of a rig that reverses the slip change sign together
    residual = np.where(slip < 0, -1, 1) * (points["traction_coefficient"] - fitted)
    known = points.assign(residual=_MILLI * residual, slide_roll_ratio=np.abs(slip))
    return known.merge(runs[["run_id", *(f"nominal_{name}" for name in CONDITIONS)]], on="run_id")


def _levels(points: pd.DataFrame, condition: str) -> "pd.Series[Any]":
    """The level of each point: its set point, or a group of equally many points."""
    nominal = f"nominal_{condition}"
    if nominal in points and points[nominal].notna().all():
        return points[nominal]
    return pd.qcut(points[condition], _GROUPS, duplicates="drop")


_MOST_ROWS = 12
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
    force, phrase = (_PRESSURE, "P = {:g} GPa") if table[_PRESSURE].any() else (_LOAD, "W = {:g} N")
    table = table.assign(runs=table["runs_accepted"] + table["runs_refused"])
    conditions = table.groupby(["oil", _TEMPERATURE, _SPEED, force], as_index=False)
    cells = conditions[["runs_accepted", "runs"]].sum()
    states = cells["runs_accepted"] > 0, cells["runs"] > 0
    cells["state"] = np.select(states, ["accepted", "refused"], "missing")
    levels = sorted(cells[force].unique())
    if not 0 < len(levels) <= _MOST_ROWS:
        raise NothingToDrawError(
            f"Conditions at {len(levels)} pressures or loads: there is nothing to cover,\n"
            "or more than a map can show. The table coverage has all runs.\n"
            "Set points are read from the headers of logs and from\n"
            "`set_points` of the campaign file."
        )
    sheet, panels = oil_grid(
        style.oils_in(cells, settings),
        rows=levels,
        title=lambda level, oil: f"{oil}, {phrase.format(level)}",
        height=1.1,
    )
    for panel, level, oil in panels:
        of_panel = cells[(cells["oil"] == oil) & (cells[force] == level)]
        panel.axis.margins(0.15)
        for state, of_state in of_panel.groupby("state"):
            x, y, look = of_state[_SPEED], of_state[_TEMPERATURE], _symbol(str(state))
            counts = of_state["runs_accepted"].astype(str) + "/" + of_state["runs"].astype(str)
            labels = counts.where(counts != "1/1", "")
            panel.dots(state, x, y, look | {"markersize": 3.6}, oil=oil, label=labels)
            for number in labels.index[labels != ""]:
                place: style.Look = {"xytext": (3, -2), "textcoords": "offset points"}
                panel.axis.annotate(labels[number], (x[number], y[number]), **place, fontsize=6)
    sheet.label("U (m/s)", "T (\N{DEGREE SIGN}C)", fontsize=7)
    counts = cells["state"].value_counts()
    handles = [
        style.symbol_handle(f"{state} ({counts.get(state, 0)})", **_symbol(state), markersize=4)
        for state in style.STATE_COLOURS
    ]
    sheet.legend(handles, "Conditions by state; beside a symbol: accepted/all runs")
    return sheet


def _symbol(state: str) -> style.Look:
    """Marker and colour of a state; open where there is no run."""
    colour = style.STATE_COLOURS[state]
    face = "white" if state == "missing" else colour
    return {"marker": style.STATE_MARKERS[state], "color": colour, "markerfacecolor": face}
