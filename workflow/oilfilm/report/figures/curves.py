"""What was measured: mu against slip with the fit, what the fit leaves, coverage of the matrix."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from oilfilm import tables
from oilfilm.curation.coverage import SET_POINTS, with_levels, with_measured
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.document import counted
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import NothingToDrawError, Panel, Sheet, oil_grid, register
from oilfilm.report.words import CONDITIONS as CONDITION_WORDS
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
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
    sheet, panels = oil_grid(oils, height=2.2, sharex=True, sharey=True)
    # runs at speeds that nobody stated are no repeats of one condition
    runs = with_levels(with_measured(results.runs, results.points), settings)
    for panel, _, oil in panels:
        of_oil = results.points[results.points["accepted"] & (results.points["oil"] == oil)]
        if of_oil.empty:
            count = int((runs["oil"] == oil).sum())
            refused = f"no accepted point\n({counted(count, 'run')} refused)"
            panel.say(refused if count else "no run read")
            continue
        law = FittedLaw.of(results.configured.coefficients, oil)
        # one table per condition: columns that nobody draws would take most of the memory
        conditions = _conditions(runs, of_oil[["run_id", *law.law.conditions, *_MEASURED]])
        colour = style.oil_colour(oil, oils)
        apart = 1 < len(conditions) <= _CONDITIONS_TOLD_APART and len(of_oil) <= _POINTS_TOLD_APART
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
    """All points in one colour, with the fits at their conditions through them."""
    points = pd.concat([condition.points for condition in series])
    x, y, _ = points[_MEASURED].to_numpy(dtype=float).T
    # few lines are drawn over their points, many lines under all points
    few, many = len(series) <= _CONDITIONS_TOLD_APART, len(points) > _POINTS_TOLD_APART
    look: style.Look = {"marker": ".", "color": colour, "alpha": 0.15 if few and many else 0.7}
    look |= {"markersize": 3.5 if few and not many else 1.6, "rasterized": True}
    # so many error bars would hide the points: none is drawn
    panel.dots("measured", x, y, look, oil=series[0].oil, label=series[0].oil)
    # a sample in the legend that can be seen
    panel.axis.plot([], [], ".", color=colour, markersize=5, label=f"points ({len(points)})")
    spread = np.argsort(np.arange(len(series)) * _GOLDEN_RATIO % 1)[:_FITS_DRAWN]
    look = {"linewidth": 1.1, "zorder": 3} if few else {"linewidth": 0.3, "zorder": 1.5}
    for condition in (series[number] for number in sorted(spread)):
        at, mu = condition.fit(float(np.abs(x).max()))
        own = {"color": condition.colour, **look}
        panel.line("fit", at, mu, own, oil=condition.oil, label=condition.label)
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
    law = FittedLaw.of(of_oil, oil)
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


_CELL_IN = 0.2  # height
_LONGEST_IN = 9.0  # a page
_STATES = list(style.STATE_COLOURS)
_SPEED = "nominal_entrainment_speed_m_s"
_TEMPERATURE = "nominal_inlet_temperature_c"
_PRESSURE = "nominal_max_hertz_pressure_gpa"
_LOAD = "nominal_load_n"
_NOT_PLANNED: style.Look = {
    "fill": False,
    "edgecolor": style.GREY,
    "linestyle": style.LINES["not planned"],
}
_CELL = ["oil", _TEMPERATURE, _SPEED, _PRESSURE, _LOAD]


@register(family="data", tables=("coverage",), settings=("oils",))
def coverage(results: CampaignTables, settings: Settings) -> Sheet:
    """Coverage of the test matrix.

    Conditions of the test matrix, one column of panels per oil and one row per inlet
    temperature. Abscissa: entrainment speed U (m/s). Ordinate: maximum Hertz pressure P (GPa)
    or load W (N). Numbers: accepted runs of all runs, where there is not one accepted run.
    Missing: no run of the condition could be read. Dashed: not in the matrix.
    """
    cells = _cells(results.coverage)
    if reason := _why_no_map(cells):
        per_oil = cells.groupby("oil")[["runs_accepted", "runs"]].sum()
        lines = [
            f"{oil}: {good} of {runs} runs accepted" for oil, good, runs in per_oil.itertuples()
        ]
        raise NothingToDrawError("\n".join([reason, "", *map(style.plain, lines)]))
    temperatures = cells.drop_duplicates("temperature").sort_values("temperature")[_TEMPERATURE]
    has_matrix = bool(cells["planned"].any())

    def title(row: tuple[int, float], oil: str) -> str:
        phrase = style.level_phrases({"inlet_temperature_c": row[1]})
        return f"{oil}, {'T not stated' if np.isnan(row[1]) else phrase}"

    layout: style.Look = {"height": _CELL_IN * cells["y"].nunique(), "left": 0.75, "down": 0.22}
    layout |= {"sharex": True, "sharey": True}
    sheet, panels = oil_grid(
        style.oils_in(cells, settings),
        rows=list(enumerate(temperatures)),
        title=title,
        **layout,
    )
    for panel, (row, _), oil in panels:
        panel.axis.set_title(panel.axis.get_title(loc="left"), fontsize=7, pad=3)
        of_panel = cells[(cells["oil"] == oil) & (cells["temperature"] == row)]
        _draw_cells(panel.axis, of_panel, has_matrix)
        x, y = of_panel[_SPEED], of_panel[_PRESSURE].fillna(of_panel[_LOAD])
        panel.keep(of_panel["state"], x, y, oil=oil, label=of_panel["label"])
    # ticks are levels, evenly spaced: of a pressure or, where none is stated, of a load
    forces = cells.drop_duplicates("y").sort_values("y")
    speeds = cells.drop_duplicates("x").sort_values("x")[_SPEED]
    in_gpa, in_n = _stated(forces[_PRESSURE], " GPa"), _stated(forces[_LOAD], " N")
    axis = sheet.axes[0]
    axis.set_yticks(range(len(forces)), in_gpa.fillna(in_n).fillna("not stated"))
    axis.set_xticks(range(len(speeds)), _stated(speeds, "").fillna("not stated"))
    axis.set(xlim=(-0.5, len(speeds) - 0.5), ylim=(-0.5, len(forces) - 0.5))
    sheet.label("U (m/s)", "P or W", fontsize=7)
    counts = cells["state"].value_counts()
    handles: list[Any] = [
        style.symbol_handle(f"{state} ({counts.get(state, 0)})", **_symbol(state), markersize=4)
        for state in _STATES
    ]
    if has_matrix and not cells["planned"].all():
        outside = f"not in the matrix ({(~cells['planned']).sum()})"
        handles.append(Rectangle((0, 0), 1, 1, label=outside, **_NOT_PLANNED))
    sheet.legend(handles, "Conditions by state; in a cell: accepted/all runs")
    return sheet


def _cells(coverage: pd.DataFrame) -> pd.DataFrame:
    """Cells of the map: conditions of all rigs together, with their positions and label.

    `x`, `y` and `temperature` number the levels in rising order; those not stated come last.
    """
    runs = coverage["runs_accepted"] + coverage["runs_refused"]
    conditions = coverage.assign(runs=runs).groupby(_CELL, dropna=False, as_index=False)
    cells = conditions.agg({"runs_accepted": "sum", "runs": "sum", "planned": "any"})
    accepted, total = cells["runs_accepted"].astype(str), cells["runs"].astype(str)
    is_accepted, any_run = cells["runs_accepted"] > 0, cells["runs"] > 0
    return cells.assign(
        state=np.select([is_accepted, any_run], ["accepted", "refused"], "missing"),
        x=cells.groupby(_SPEED, dropna=False).ngroup(),
        y=cells.groupby([_PRESSURE, _LOAD], dropna=False).ngroup(),
        temperature=cells.groupby(_TEMPERATURE, dropna=False).ngroup(),
        label=(accepted + "/" + total).where(any_run, ""),
    )


def _why_no_map(cells: pd.DataFrame) -> str:
    """What to say instead of a map, where there is none to draw; else empty."""
    if cells.empty:
        return "No run was read, and the campaign has no matrix:\nthere is nothing to cover."
    if cells[_CELL[1:]].isna().all(axis=None):
        return (
            "No set points are stated, so that no map can be drawn.\n"
            "Write them into the header of each log, or under\n`set_points` of the campaign file."
        )
    height_in = cells["y"].nunique() * cells["temperature"].nunique() * _CELL_IN
    if height_in > 2 * _LONGEST_IN or cells["x"].nunique() > 40:
        return (
            f"{len(cells)} different conditions are more than a map can show.\n"
            "The table coverage has them all."
        )
    return ""


def _draw_cells(axis: Axes, cells: pd.DataFrame, has_matrix: bool) -> None:
    """Cells of one panel: the state's symbol, accepted of all runs."""
    for state, of_state in cells.groupby("state"):
        x = of_state["x"] - 0.2 * (of_state["label"] != "1/1")
        axis.plot(x, of_state["y"], linestyle="", markersize=3.6, **_symbol(str(state)))
    look: style.Look = {"ha": "center", "va": "center_baseline", "fontsize": 6}
    for cell in tables.rows(cells):
        if cell["label"] != "1/1":
            axis.text(cell["x"] + 0.17, cell["y"], cell["label"], **look)
        if has_matrix and not cell["planned"]:
            corner = cell["x"] - 0.46, cell["y"] - 0.42
            axis.add_patch(Rectangle(corner, 0.92, 0.84, **_NOT_PLANNED))
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)


def _symbol(state: str) -> style.Look:
    """Marker and colour of a state; open where there is no run."""
    colour = style.STATE_COLOURS[state]
    face = "white" if state == "missing" else colour
    return {"marker": style.STATE_MARKERS[state], "color": colour, "markerfacecolor": face}


def _stated(values: "pd.Series[float]", unit: str) -> "pd.Series[str]":
    """Levels in words; null where none is stated."""
    return values.map(lambda level: f"{level:.4g}{unit}", na_action="ignore").astype("string")
