"""Figures of the measurements: mu against slip with the fit, residuals, coverage of the matrix."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from oilfilm.base.units import IndexArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import Panel, Sheet, declare_figure, oil_grid
from oilfilm.report.names import CONDITION_TEXTS
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import (
    NOMINAL_COLUMNS,
    with_matched_set_points,
    with_measured_set_points,
)
from oilfilm.traction.law import CONDITIONS

NO_POINT_MESSAGE = "no accepted point\nat the conditions\nof this figure\n(config: figures)"
# Largest number of conditions in one panel that shade and symbol tell apart.
_MOST_CONDITIONS_TOLD_APART = 6
# Largest number of points in one panel: symbols of more would hide the lines.
_MOST_POINTS_TOLD_APART = 2000
# Largest number of lines in one panel: more are one dark area, and each takes 2 kB of SVG.
_MOST_FITS_DRAWN = 500
# Largest number of runs of one oil whose points are drawn. More points cover each other, and all of
# them would be the largest table of a campaign.
_MOST_RUNS_DRAWN = 1000
# Multiples of this number modulo 1 are spread evenly without a period. A fixed step could choose
# conditions of one temperature only.
_GOLDEN_RATIO = (5**0.5 - 1) / 2
_MEASURED_COLUMNS = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
_GROUP_COUNT = 15  # groups of equally many points, where no set points define levels
_THOUSANDTHS_PER_UNIT = 1e3


@dataclass(frozen=True)
class CurveInPanel:
    """One curve of a panel: the points of some runs and the fit at their mean conditions.

    Attributes:
        label: For the legend.
        oil: Name of the oil.
        points: Rows of the table of points.
        fitted: The fitted law.
        colour: Colour of points and line.
        marker: Symbol of the points.
    """

    label: str
    oil: str
    points: pd.DataFrame
    fitted: FittedLaw
    colour: Any
    marker: str

    def fitted_line(self, largest_slip: float) -> tuple[Any, Any]:
        """Slips from 0 to `largest_slip`, and the law's mu at the mean conditions of the points."""
        condition = self.points[list(self.fitted.law.conditions)].mean().to_numpy(dtype=np.float64)
        slip = np.linspace(0, largest_slip, 151)
        return slip, self.fitted.traction(condition, slip)


def draw_curves(panel: Panel, curves: Iterable[CurveInPanel]) -> None:
    """Draw the points of each curve with their errors, and the fit through them."""
    curves_with_points = [curve for curve in curves if not curve.points.empty]
    for curve in curves_with_points:
        slip, mu, standard_error = curve.points[_MEASURED_COLUMNS].to_numpy(dtype=float).T
        half_bar = style.BAR_HALF_LENGTH_SE * standard_error
        fit_slip, fit_mu = curve.fitted_line(np.abs(slip).max())
        details = {"oil": curve.oil, "label": curve.label}
        look: style.Look = {"marker": curve.marker, "color": curve.colour, "label": curve.label}
        look.update(style.BAR_LOOK)
        panel.dots("measured", slip, mu, look, lower=mu - half_bar, upper=mu + half_bar, **details)
        panel.line("fit", fit_slip, fit_mu, {"color": curve.colour}, **details)
    if not curves_with_points:
        panel.write_message(NO_POINT_MESSAGE)


@declare_figure(
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
)
def curves(results: CampaignTables, settings: Settings) -> Sheet:
    """All curves.

    Traction coefficient of all accepted plateaus against slide-roll ratio, one panel per oil.
    Points: plateau means. Bars, where there are few points: 95 % interval of the random error.
    Lines: fitted law at each tested condition. Where only some points or lines are drawn, evenly
    chosen, the legend says so.
    """
    oils = list(settings.oils)
    sheet, panels = oil_grid(oils, height=2.2)
    # runs without a stated speed get their measured one: they need not be repeats
    parts_of_points = results.blocks_of_runs("points", ["run_id", "accepted", *CONDITIONS])
    runs = with_matched_set_points(
        with_measured_set_points(results.runs, parts_of_points), settings
    )
    for panel, _, oil in panels:
        columns = ["run_id", "accepted", "load_n", *CONDITIONS, *_MEASURED_COLUMNS]
        points = results.table("points", columns, oil=oil)
        points = points[points["accepted"]]
        if points.empty:
            panel.write_message("no accepted point")
            continue
        fitted = FittedLaw.from_tables(results.configured_fits.coefficients, oil)
        points, labels = _with_conditions(runs, points)
        colour = style.oil_colour(oil, oils)
        has_few_points = len(points) <= _MOST_POINTS_TOLD_APART
        if len(labels) <= _MOST_CONDITIONS_TOLD_APART and has_few_points:
            draw_curves(panel, _curves_at_conditions(oil, fitted, points, labels, colour))
        else:
            _draw_cloud(panel, oil, fitted, points, labels, colour)
        panel.axes.legend(loc="upper left", fontsize=6)
    if sheet.drawn_parts:
        # all panels have one scale; room for the legends
        bottom, top = sheet.axes_of_panels[0].get_ylim()
        sheet.axes_of_panels[0].set_ylim(bottom, top + 0.18 * (top - bottom))
    sheet.label_axes(style.CONDITION_LABELS["slide_roll_ratio"], style.TRACTION_LABEL)
    return sheet


def _with_conditions(runs: pd.DataFrame, points: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Points with the index of their `run` and `condition`; the conditions in words, by index.

    A condition is one combination of set points.

    Args:
        runs: As of `with_matched_set_points`.
        points: Points of one oil, with `run_id`.
    """
    nominal_columns = list(NOMINAL_COLUMNS)
    units = ("GPa", "N", "m/s", "\N{DEGREE SIGN}C")
    run_index, run_names = pd.factorize(points["run_id"], sort=True)
    set_points = runs.set_index("run_id").loc[run_names, nominal_columns]
    runs_by_condition = set_points.groupby(nominal_columns, dropna=False)
    labels = []
    for levels in runs_by_condition.head(1).sort_values(nominal_columns).to_numpy():
        texts = [
            f"{level:.4g} {unit}"
            for level, unit in zip(levels, units, strict=True)
            if not np.isnan(level)
        ]
        labels.append(", ".join(texts))
    condition_index = runs_by_condition.ngroup().to_numpy()[run_index]
    numbered_points = points.drop(columns="run_id").assign(run=run_index, condition=condition_index)
    return numbered_points.sort_values("condition", kind="stable"), labels


def _curves_at_conditions(
    oil: str, fitted: FittedLaw, points: pd.DataFrame, labels: Sequence[str], colour: str
) -> list[CurveInPanel]:
    """The curves of some conditions.

    Args:
        oil: Name of the oil.
        fitted: Its fit.
        points: Points of these conditions, as of `_with_conditions`.
        labels: Set points of every condition in words.
        colour: Colour of the oil.
    """
    shades = style.shades(colour, len(labels))
    condition_indices = np.unique(points["condition"]).tolist()
    points_by_condition = [
        points_of_condition for _, points_of_condition in points.groupby("condition")
    ]
    return [
        CurveInPanel(
            labels[condition_index],
            oil,
            points_of_condition,
            fitted,
            shades[condition_index],
            style.MARKERS[condition_index % len(style.MARKERS)],
        )
        for condition_index, points_of_condition in zip(
            condition_indices, points_by_condition, strict=True
        )
    ]


def _evenly_chosen(count: int, largest_count: int) -> IndexArray:
    """Indices of at most `largest_count` of `count` things, evenly spread and in order."""
    spread_order = np.argsort(np.arange(count) * _GOLDEN_RATIO % 1)
    return np.sort(spread_order[:largest_count])


def _of_drawn_runs(points: pd.DataFrame) -> pd.DataFrame:
    """The points of all runs, or of `_MOST_RUNS_DRAWN` runs, evenly chosen in order of name.

    Args:
        points: Points of one oil, with the index of their `run` in the order of the names.
    """
    run_count = int(points["run"].max()) + 1
    return points[points["run"].isin(_evenly_chosen(run_count, _MOST_RUNS_DRAWN))]


def _draw_cloud(
    panel: Panel,
    oil: str,
    fitted: FittedLaw,
    points: pd.DataFrame,
    labels: Sequence[str],
    colour: str,
) -> None:
    """Draw points in one colour, and the fits at their conditions in black.

    Args:
        panel: The panel.
        oil: Name of the oil.
        fitted: Its fit.
        points: As of `_with_conditions`.
        labels: Set points of every condition in words.
        colour: Colour of the oil.
    """
    drawn_points = _of_drawn_runs(points)
    slip, mu, _ = drawn_points[_MEASURED_COLUMNS].to_numpy(dtype=float).T
    # so many error bars would hide the points: none is drawn
    dot_look: style.Look = {"marker": ".", "color": colour, "alpha": 0.7, "markersize": 1.6}
    panel.dots("measured", slip, mu, dot_look | {"rasterized": True}, oil=oil)
    count_text = f"{len(points)}"
    if len(drawn_points) < len(points):
        count_text = f"{len(drawn_points)} of {len(points)}"
    # the legend has a larger dot
    panel.axes.plot([], [], ".", color=colour, markersize=5, label=f"points ({count_text})")
    drawn_indices = _evenly_chosen(len(labels), _MOST_FITS_DRAWN)
    line_look: style.Look = {"color": "black"}
    if len(labels) <= _MOST_CONDITIONS_TOLD_APART:
        # few lines are drawn over their points, many lines under all points
        line_look.update(linewidth=1.1, zorder=3)
    else:
        line_look.update(linewidth=0.3, zorder=1.5)
    largest_slip = float(points["slide_roll_ratio"].abs().max())
    drawn_conditions = points[points["condition"].isin(drawn_indices)]
    for curve in _curves_at_conditions(oil, fitted, drawn_conditions, labels, colour):
        fit_slip, fit_mu = curve.fitted_line(largest_slip)
        panel.line("fit", fit_slip, fit_mu, line_look, oil=oil, label=curve.label)
    label = "fit"
    if len(drawn_indices) < len(labels):
        label = f"fit ({len(drawn_indices)} of {len(labels)} conditions)"
    panel.axes.plot([], [], color="black", label=label)


@declare_figure(
    family="data",
    tables=("points", "runs", "coefficients"),
    settings=("oils", "rigs", "same_set_point", "campaign.matrix"),
)
def residuals(results: CampaignTables, settings: Settings) -> Sheet:
    """Residuals of the fit.

    Measured minus fitted traction coefficient of all accepted plateaus against maximum Hertz
    pressure (GPa), entrainment speed (m/s), inlet temperature (\N{DEGREE SIGN}C) and slide-roll
    ratio. Symbols with bars: mean and scatter at each level. A mean away from zero shows a
    systematic error of the law. Where the plateaus of some runs only are drawn, evenly chosen, the
    legend says so; means are those of all.
    """
    oils = list(settings.oils)
    runs = with_matched_set_points(results.runs, settings)
    column_count = len(CONDITION_TEXTS)
    layout: style.Look = {"height": 1.1, "down": 0.3, "sharex": "col", "sharey": "row"}
    sheet = Sheet(len(oils) * column_count, column_count, **layout)
    note_on_drawn = ""
    delta_mu = f"\N{GREEK CAPITAL LETTER DELTA}{style.MU} ({style.THOUSANDTHS})"
    for row_index, oil in enumerate(oils):
        points = _residuals(results, runs, oil)
        colour = style.oil_colour(oil, oils)
        drawn_points = None if points is None else _of_drawn_runs(points)
        if points is not None and drawn_points is not None and len(drawn_points) < len(points):
            note_on_drawn = f" (at most {_MOST_RUNS_DRAWN} runs per oil)"
        for column_index, (condition, (symbol, _, unit)) in enumerate(CONDITION_TEXTS.items()):
            panel = sheet.panel(row_index * column_count + column_index)
            panel.axes.set_xlabel(f"{symbol} ({unit})" if unit else f"|{symbol}|")
            panel.axes.set_ylabel(f"{oil}: {delta_mu}", fontsize=7)
            if points is None or drawn_points is None:
                panel.write_message("no fit")
            elif points[condition].isna().all():
                panel.write_message("not known")
            else:
                _draw_residuals(panel, points, drawn_points, condition, oil, colour)
    sheet.label_axes()
    plateau = style.symbol_handle(f"plateau{note_on_drawn}", ".", color="black", markersize=3)
    label = "mean of a level, with the standard deviation of its plateaus"
    level = style.symbol_handle(label, "o", color="black", markerfacecolor="white")
    sheet.legend([plateau, level])
    return sheet


def _draw_residuals(
    panel: Panel,
    points: pd.DataFrame,
    drawn_points: pd.DataFrame,
    condition: str,
    oil: str,
    colour: str,
) -> None:
    """Draw residuals against one condition, and the mean and scatter of all at each level.

    Args:
        panel: The panel.
        points: As of `_residuals`.
        drawn_points: Those of them that are drawn.
        condition: Column of the abscissa.
        oil: Name of the oil.
        colour: Its colour.
    """
    dot_look: style.Look = {"alpha": 0.25, "markersize": 1.2, "rasterized": True, "marker": "."}
    dot_look["color"] = colour
    panel.dots("point", drawn_points[condition], drawn_points["residual"], dot_look, oil=oil)
    panel.axes.axhline(0, color="black", linewidth=0.6)
    groups = points.groupby(_levels_of_points(points, condition), observed=True)
    means = groups.agg(x=(condition, "mean"), y=("residual", "mean"), sd=("residual", "std"))
    level_means, residual_means, deviations = means.to_numpy().T
    mean_look: style.Look = {"marker": "o", "color": "black"}
    mean_look.update(style.BAR_LOOK)
    ends = {"lower": residual_means - deviations, "upper": residual_means + deviations}
    panel.dots("mean", level_means, residual_means, mean_look, oil=oil, **ends)


def _residuals(results: CampaignTables, runs: pd.DataFrame, oil: str) -> pd.DataFrame | None:
    """Accepted points with their residual (1e-3), and index and set points of their run.

    None where the oil has no fit or no accepted point.
    """
    coefficients = results.configured_fits.coefficients
    coefficients_of_oil = coefficients[coefficients["oil"] == oil]
    if coefficients_of_oil.empty:
        return None
    fitted_law = FittedLaw.from_tables(coefficients_of_oil, oil)
    conditions = list(fitted_law.law.conditions)
    columns = dict.fromkeys(["run_id", "accepted", *conditions, *CONDITION_TEXTS])
    points = results.table("points", [*columns, "traction_coefficient"], oil=oil)
    points = points[points["accepted"]]
    if points.empty:
        return None
    slip = points["slide_roll_ratio"].to_numpy()
    predictions = fitted_law.predictions(points[conditions].to_numpy(), slip)
    fitted_mu = np.concatenate([part.traction_coefficient for part in predictions])
    if np.isnan(fitted_mu).all():
        return None
    # slip and traction of a rig that reverses the slip change sign together
    residual = np.where(slip < 0, -1, 1) * (points["traction_coefficient"] - fitted_mu)
    set_points = [f"nominal_{name}" for name in CONDITIONS]
    # an index in place of the name of the run, which would take most of the memory
    run_index, run_ids = pd.factorize(points["run_id"], sort=True)
    levels_of_run = runs.set_index("run_id").loc[run_ids, set_points]
    return points[list(CONDITION_TEXTS)].assign(
        run=run_index,
        residual=_THOUSANDTHS_PER_UNIT * residual,
        slide_roll_ratio=np.abs(slip),
        **{name: levels_of_run[name].to_numpy()[run_index] for name in set_points},
    )


def _levels_of_points(points: pd.DataFrame, condition: str) -> "pd.Series[Any]":
    """The level of each point: its set point, or else one of `_GROUP_COUNT` groups of one size."""
    nominal = f"nominal_{condition}"
    if nominal in points and points[nominal].notna().all():
        return points[nominal]
    if points[condition].nunique() == 1:
        # one value has no quantiles between which it could be
        return points[condition]
    return pd.qcut(points[condition], _GROUP_COUNT, duplicates="drop")


_MOST_PANEL_ROWS = 12
_NOMINAL_SPEED = "nominal_entrainment_speed_m_s"
_NOMINAL_TEMPERATURE = "nominal_inlet_temperature_c"
_NOMINAL_PRESSURE = "nominal_max_hertz_pressure_gpa"
_NOMINAL_LOAD = "nominal_load_n"


@declare_figure(family="data", tables=("coverage", "points"), settings=("oils",))
def coverage(results: CampaignTables, settings: Settings) -> Sheet:
    """Coverage of the test matrix.

    Conditions of the test matrix and of all runs, one column of panels per oil and one row per
    maximum Hertz pressure P or, where none is stated, load W. Abscissa: entrainment speed U (m/s).
    Ordinate: inlet temperature T (\N{DEGREE SIGN}C). Numbers: accepted runs of all runs; a
    condition without a number has one run, which is accepted. Missing: no run of the condition
    could be read. Conditions that are not stated as a whole are not shown. Where none is, or at
    too many pressures for a map, the measured means of each run are shown, one panel per oil.
    """
    table = results.coverage
    has_pressures = table[_NOMINAL_PRESSURE].any()
    load_column = _NOMINAL_PRESSURE if has_pressures else _NOMINAL_LOAD
    level_phrase = "P = {:g} GPa" if has_pressures else "W = {:g} N"
    table = table.assign(runs=table["runs_accepted"] + table["runs_refused"])
    groups = table.groupby(
        ["oil", _NOMINAL_TEMPERATURE, _NOMINAL_SPEED, load_column], as_index=False
    )
    cells = groups[["runs_accepted", "runs"]].sum()
    has_accepted = cells["runs_accepted"] > 0
    has_runs = cells["runs"] > 0
    cells["state"] = np.select([has_accepted, has_runs], ["accepted", "refused"], "missing")
    levels = sorted(cells[load_column].unique())
    if not 0 < len(levels) <= _MOST_PANEL_ROWS:
        return _measured_coverage(results, settings)
    sheet, panels = oil_grid(
        style.oils_in(cells, settings),
        rows=levels,
        title=lambda level, oil: f"{oil}, {level_phrase.format(level)}",
        height=1.1,
    )
    for panel, level, oil in panels:
        cells_of_panel = cells[(cells["oil"] == oil) & (cells[load_column] == level)]
        panel.axes.margins(0.15)
        for state, cells_of_state in cells_of_panel.groupby("state"):
            _draw_state(panel, str(state), cells_of_state, oil)
    sheet.label_axes("U (m/s)", "T (\N{DEGREE SIGN}C)", fontsize=7)
    counts = cells["state"].value_counts()
    handles = [
        style.symbol_handle(f"{state} ({counts.get(state, 0)})", **_symbol(state), markersize=4)
        for state in style.STATE_COLOURS
    ]
    sheet.legend(handles, "Conditions by state; beside a symbol: accepted/all runs")
    return sheet


def _measured_coverage(results: CampaignTables, settings: Settings) -> Sheet:
    """The mean measured speed and temperature of each run, for runs without common set points."""
    columns = ["oil", "run_id", "accepted", "entrainment_speed_m_s", "inlet_temperature_c"]
    means_of_parts = [
        part.groupby(["oil", "run_id"], as_index=False).agg(
            speed=("entrainment_speed_m_s", "mean"),
            temperature=("inlet_temperature_c", "mean"),
            accepted=("accepted", "any"),
        )
        for part in results.blocks_of_runs("points", columns)
    ]
    means = pd.concat(means_of_parts).sort_values(["oil", "run_id"], ignore_index=True)
    means = means.dropna(subset=["speed", "temperature"])
    means["state"] = np.where(means["accepted"], "accepted", "refused")
    sheet, panels = oil_grid(
        style.oils_in(means, settings),
        "No run has a known speed and temperature: there is nothing to cover.",
        title=lambda _, oil: f"{oil}, measured means of runs",
        height=1.6,
    )
    for panel, _, oil in panels:
        panel.axes.margins(0.15)
        panel.axes.xaxis.set_major_locator(MaxNLocator(4))  # speeds of slow rigs have many decimals
        for state, runs_of_state in means[means["oil"] == oil].groupby("state"):
            look = _symbol(str(state))
            look["markersize"] = 3.0
            details: style.Look = {"oil": oil, "label": runs_of_state["run_id"]}
            panel.dots(
                str(state), runs_of_state["speed"], runs_of_state["temperature"], look, **details
            )
    sheet.label_axes("U (m/s)", "T (\N{DEGREE SIGN}C)", fontsize=7)
    counts = means["state"].value_counts()
    handles = [
        style.symbol_handle(f"{state} ({count})", **_symbol(str(state)), markersize=4)
        for state, count in counts.items()
    ]
    sheet.legend(handles, "Runs by state; their logs state no common set points")
    return sheet


def _draw_state(panel: Panel, state: str, cells: pd.DataFrame, oil: str) -> None:
    """Draw the conditions of one state, with `accepted/all runs` beside each that is not 1/1."""
    speed = cells[_NOMINAL_SPEED]
    temperature = cells[_NOMINAL_TEMPERATURE]
    counts = cells["runs_accepted"].astype(str) + "/" + cells["runs"].astype(str)
    labels = counts.where(counts != "1/1", "")
    look = _symbol(state)
    look["markersize"] = 3.6
    panel.dots(state, speed, temperature, look, oil=oil, label=labels)
    label_look: style.Look = {"xytext": (3, -2), "textcoords": "offset points", "fontsize": 6}
    for index in labels.index[labels != ""]:
        panel.axes.annotate(labels[index], (speed[index], temperature[index]), **label_look)


def _symbol(state: str) -> style.Look:
    """Marker and colour of a state; open where there is no run."""
    colour = style.STATE_COLOURS[state]
    face = "white" if state == "missing" else colour
    return {"marker": style.STATE_MARKERS[state], "color": colour, "markerfacecolor": face}
