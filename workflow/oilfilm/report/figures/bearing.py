"""Figures of the bearing: friction torque, cage slip, size effect and the tests to run next."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm
from matplotlib.patches import Patch

from oilfilm.base.ties import exceeds
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import Panel, Sheet, declare_figure, oil_grid
from oilfilm.report.names import load_variable_in_words
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import is_bistable
from oilfilm.traction.law import CONDITIONS

# Fill of the symbols and dashes of the lines of each temperature.
_TEMPERATURE_LOOKS = (
    ("full", "-"),
    ("none", (0, (5, 2))),
    ("left", ":"),
    ("right", "-."),
    ("top", "-"),
)
# The campaign's law and the law of load that it is compared with.
_COMPARED_LAWS = ("stress", "wang-deng-load")
# Reach of the errors that are drawn, over the largest error; and the least one, in percent.
_ERROR_HEADROOM = 1.15
_LEAST_ERROR_SHOWN = 20.0
_LOOK_OF_LOAD_VARIABLE: dict[str, style.Look] = {
    "load": {"linestyle": style.LINE_STYLES["load"], "marker": "s"},
    "dimensionless_load": {"linestyle": style.LINE_STYLES["dimensionless load"], "marker": "^"},
}
_SLIP_LEVELS = (-1.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0)
_BISTABLE: style.Look = {"marker": "x", "color": "black", "linestyle": "", "markersize": 4}
_NOT_KNOWN: style.Look = {"marker": "+", "color": style.GREY, "linestyle": "", "markersize": 4}
_PRESSURE_LINE: style.Look = {"color": "#D55E00", "linestyle": ":", "linewidth": 1.4}
_NO_LAW = "No oil has a law that a bearing could use."
_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS


@declare_figure(
    family="bearing", tables=("torque",), settings=("oils", "figures"), requires="torque"
)
def torque(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction torque of the bearing.

    One column of panels per oil, against speed of the inner ring. Top: friction torque (N m).
    Symbols: measured; lines: calculated with the pressure-based law. Middle and bottom: error (%)
    of the torque calculated with the pressure-based law and with the load-based Wang-Deng law.
    Bars: 95 % interval from refits of the law, calibration and the other terms of the torque; they
    may leave the panel. Symbols are side by side at one speed. Colour: axial load. Filled and open:
    oil temperature. Crosses: the cage may roll or skid.
    """
    torque_rows = _with_set_points(results.torque, settings)
    torque_rows = torque_rows.assign(speed_krpm=torque_rows["inner_speed_rpm"] / 1e3)
    sheet, panels = oil_grid(
        style.oils_in(torque_rows, settings),
        "No torque was measured, or no law could be evaluated.",
        # the first row of panels has the torque itself, without the name of a law
        ["", *_COMPARED_LAWS],
        lambda law_name, oil: f"{oil}, {load_variable_in_words(law_name)}" if law_name else oil,
        height=1.35,
        sharey="row",
        width=style.DOUBLE_COLUMN_IN,
    )
    looks = _looks_of_series(torque_rows)
    lowest, highest = _limits_of_error_axis(
        torque_rows[torque_rows["load_variable"].isin(_COMPARED_LAWS)]
    )
    for panel, law_name, oil in panels:
        rows = torque_rows[torque_rows["oil"] == oil]
        if law_name:
            _draw_torque_errors(panel, rows[rows["load_variable"] == law_name], looks)
            panel.axes.set_ylim(lowest, highest)
        else:
            _draw_torque(panel, rows[rows["load_variable"] == "stress"], looks)
    for index, axes in enumerate(sheet.axes_of_panels):
        axes.set_ylabel("Friction torque (N m)" if index < len(panels) / 3 else "Error (%)")
    sheet.label_axes(style.SPEED_LABEL, fontsize=7)
    look_of_load = {load: look for (load, _), look in looks.items()}
    handles: list[Any] = [
        Patch(color=look["color"], label=_in_kn(load)) for load, look in look_of_load.items()
    ]
    look_of_temperature = {temperature_c: look for (_, temperature_c), look in looks.items()}
    for temperature_c, look in look_of_temperature.items():
        black = {**look, "color": "black"}
        handles.append(style.line_handle(f"{temperature_c:.0f} \N{DEGREE SIGN}C", **black))
    sheet.legend(handles + _motion_handles(torque_rows))
    return sheet


def _limits_of_error_axis(torque_rows: pd.DataFrame) -> tuple[float, float]:
    """Ends of the scale of errors (%): all errors, and what of the intervals is not far off.

    Errors that are not known do not count.
    """
    measured_n_m = torque_rows["measured_torque_n_m"]
    errors = 100 * torque_rows["relative_error"]
    lower_ends = 100 * (torque_rows["torque_n_m_lower"] / measured_n_m - 1)
    highest = _ERROR_HEADROOM * np.fmax(errors.max(), _LEAST_ERROR_SHOWN)
    smallest_errors = [errors.min(), lower_ends.min(), -_LEAST_ERROR_SHOWN]
    lowest = _ERROR_HEADROOM * np.fmin.reduce(smallest_errors)
    return max(lowest, -highest), highest


def _looks_of_series(torque_rows: pd.DataFrame) -> dict[tuple[float, float], style.Look]:
    """Look of the symbols of each set point of load (N) and temperature (degC)."""
    loads_n, temperatures_c = (sorted(set(torque_rows[name])) for name in ("load", "temperature_c"))
    colours = colormaps["viridis"](np.linspace(0, 0.85, len(loads_n)))
    temperature_looks = list(zip(temperatures_c, itertools.cycle(_TEMPERATURE_LOOKS), strict=False))
    looks = {}
    for load_n, colour in zip(loads_n, colours, strict=True):
        for temperature_c, (fill_style, dashes) in temperature_looks:
            looks[round(load_n), temperature_c] = {
                "color": tuple(colour),
                "fillstyle": fill_style,
                "linestyle": dashes,
                "marker": "o",
                "markersize": 3.0,
                "linewidth": 0.8,
            }
    return looks


def _draw_torque(
    panel: Panel, torque_rows: pd.DataFrame, looks: Mapping[tuple[float, float], style.Look]
) -> None:
    """Draw the measured symbols and the calculated lines of one oil, one series per set point."""
    for (load_n, temperature_c), look in looks.items():
        rows_of_set_point = _rows_at_set_point(torque_rows, load_n, temperature_c)
        details = {
            "oil": rows_of_set_point["oil"],
            "label": f"{_in_kn(load_n)}, {temperature_c:.0f} degC",
        }
        line_look = {name: look[name] for name in ("color", "linestyle", "linewidth")}
        panel.line(
            "calculated",
            rows_of_set_point["speed_krpm"],
            rows_of_set_point["torque_n_m"],
            line_look,
            **details,
        )
        dot_look = {name: look[name] for name in ("color", "fillstyle", "marker", "markersize")}
        measured = rows_of_set_point["measured_torque_n_m"]
        half_bar = style.BAR_HALF_LENGTH_SE * rows_of_set_point["measured_torque_n_m_uncertainty"]
        ends = {"lower": measured - half_bar, "upper": measured + half_bar}
        panel.dots(
            "measured", rows_of_set_point["speed_krpm"], measured, dot_look, **details, **ends
        )
    _draw_motions(panel, torque_rows, "speed_krpm", "torque_n_m")
    panel.axes.set_ylim(bottom=0)


def _draw_torque_errors(
    panel: Panel, torque_rows: pd.DataFrame, looks: Mapping[tuple[float, float], style.Look]
) -> None:
    """Draw the error of the torque by one law, with its interval, side by side at each speed."""
    panel.axes.axhline(0, color="black", linewidth=0.6)
    gaps = np.diff(np.unique(torque_rows["speed_krpm"].round(1)))
    step = gaps.min() / (len(looks) + 2) if len(gaps) else 0.0
    for series_index, ((load_n, temperature_c), look) in enumerate(looks.items()):
        rows_of_set_point = _rows_at_set_point(torque_rows, load_n, temperature_c)
        measured = rows_of_set_point["measured_torque_n_m"]
        error_percent, lower_percent, upper_percent = (
            100 * (rows_of_set_point[name] / measured - 1)
            for name in ("torque_n_m", "torque_n_m_lower", "torque_n_m_upper")
        )
        x_beside = rows_of_set_point["speed_krpm"] + (series_index - (len(looks) - 1) / 2) * step
        dot_look = {name: look[name] for name in ("color", "fillstyle", "marker", "markersize")}
        motion_labels = _motion_labels(rows_of_set_point, two_motions=", bistable", one_motion="")
        labels = f"{_in_kn(load_n)}, {temperature_c:.0f} degC" + motion_labels
        details = {
            "oil": rows_of_set_point["oil"],
            "label": labels,
            "lower": lower_percent,
            "upper": upper_percent,
        }
        panel.dots("error", x_beside, error_percent, {**dot_look, "elinewidth": 0.6}, **details)


def _in_kn(load_n: float) -> str:
    """A load as text, to 0.1 kN."""
    return f"{round(load_n / 1e3, 1):g} kN"


def _rows_at_set_point(
    torque_rows: pd.DataFrame, load_n: float, temperature_c: float
) -> pd.DataFrame:
    """The rows of one set point, by speed."""
    is_at_set_point = (torque_rows["load"].round() == load_n) & (
        torque_rows["temperature_c"] == temperature_c
    )
    return torque_rows[is_at_set_point].sort_values("speed_krpm", kind="stable")


def _with_set_points(table: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The table with the set points of each row: `load` (N) and `temperature_c`.

    A set point is the mean of neighbouring measured values that are the same within the setting.
    """
    same_within = settings.figures.torque.same_within

    def set_points(measured: "pd.Series[float]") -> "pd.Series[float]":
        """The set point of each measured value."""
        sorted_values = measured.sort_values()
        is_first_of_set = pd.Series(
            exceeds(sorted_values.diff(), same_within * sorted_values.shift()), sorted_values.index
        )
        return measured.groupby(is_first_of_set.cumsum()).transform("mean")

    return table.assign(
        load=set_points(table["axial_load_n"]),
        temperature_c=set_points(table["inlet_temperature_c"]),
    )


def _draw_motions(panel: Panel, rows: pd.DataFrame, x_column: str, y_column: str) -> None:
    """Mark where the cage may roll or skid, and where that is not known.

    Args:
        panel: The panel.
        rows: Rows with the flag `bistable`.
        x_column: Column of the abscissa.
        y_column: Column of the ordinate.
    """
    bistable = rows[is_bistable(rows)]
    not_known = rows[rows["bistable"].isna()]
    panel.axes.plot(bistable[x_column], bistable[y_column], **_BISTABLE)
    panel.axes.plot(not_known[x_column], not_known[y_column], **_NOT_KNOWN)


def _motion_handles(rows: pd.DataFrame) -> list[Any]:
    """Entries of the legend for the marks of `_draw_motions` that occur."""
    handles = []
    if is_bistable(rows).any():
        handles.append(style.line_handle("cage may roll or skid", **_BISTABLE))
    if rows["bistable"].isna().any():
        handles.append(style.line_handle("not known whether there is another motion", **_NOT_KNOWN))
    return handles


def _motion_labels(rows: pd.DataFrame, *, two_motions: str, one_motion: str) -> "pd.Series[str]":
    """A label of each row by its flag `bistable`; where it is null, that of one with a note."""
    labels = rows["bistable"].astype(object).map({True: two_motions, False: one_motion})
    return labels.where(rows["bistable"].notna(), f"{one_motion}, perhaps bistable")


@declare_figure(
    family="bearing", tables=("cage_slip",), settings=("oils", "bearing"), requires="torque"
)
def cage_slip(results: CampaignTables, settings: Settings) -> Sheet:
    """Cage slip.

    Cage slip at friction equilibrium, one panel per oil. Abscissa: dmN, pitch diameter times
    speed (million mm rpm), and entrainment speed U of rolling balls. Ordinate: axial load (kN).
    Full line: limit of the cage slip. Dashed lines: the 2.5 % and 97.5 % quantiles of the slip
    reach the limit, where they could be calculated. Dotted lines: the larger contact pressure
    reaches a limit (GPa). Crosses: the cage may roll or skid.
    """
    slip_map = results.cage_slip
    slip_map = slip_map.assign(**axis_columns(slip_map))
    slip_limit = settings.bearing.cage_slip.slip_limit
    pressure_limits = settings.bearing.pressure_limits_gpa
    drawn_pressures: set[float] = set()
    sheet, panels = oil_grid(style.oils_in(slip_map, settings), _NO_LAW, height=1.7, right=0.75)
    sheet.axes_of_panels[0].set_yscale("log")
    sheet.axes_of_panels[0].yaxis.set_major_formatter("{x:g}")
    for panel, _, oil in panels:
        coloured_cells = _draw_slip(panel, slip_map[slip_map["oil"] == oil], oil, slip_limit)
        pressures = _draw_pressures(panel, slip_map[slip_map["oil"] == oil], pressure_limits)
        drawn_pressures.update(pressures)
    bar = sheet.colour_bar(coloured_cells, "Cage slip", ticks=_SLIP_LEVELS[1:])
    bar.set_yticklabels([f"{level:g}" for level in _SLIP_LEVELS[1:]])
    sheet.label_axes(style.DMN_LABEL, style.AXIAL_LOAD_LABEL, fontsize=7)
    handles: list[Any] = [
        style.line_handle(f"slip of {slip_limit:g}", color="black"),
        style.line_handle("its 95 % interval", linestyle="--", color="black", linewidth=0.8),
    ]
    handles += [
        style.line_handle(f"contact pressure of {pressure:g} GPa", **_PRESSURE_LINE)
        for pressure in sorted(drawn_pressures)
    ]
    temperature_c = settings.bearing.cage_slip.inlet_temperature_c
    bearing_name = slip_map["bearing"].iloc[0]
    title = f"{bearing_name}, oil at {temperature_c:g} \N{DEGREE SIGN}C; {style.DMN_AS_SPEED}"
    sheet.legend(handles + _motion_handles(slip_map), title)
    return sheet


def _draw_pressures(
    panel: Panel, rows_of_oil: pd.DataFrame, limits_gpa: Sequence[float]
) -> Iterator[float]:
    """Draw a line where the larger contact pressure reaches each limit.

    Yields:
        The limits that are reached on the map.
    """
    contacts = ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
    slip_map = rows_of_oil.assign(pressure=rows_of_oil[contacts].max(axis=1))
    pressure_map = slip_map.pivot(index="load_kn", columns="dmn", values="pressure")
    pressure_gpa = np.ma.masked_invalid(pressure_map.to_numpy())
    for limit_gpa in limits_gpa:
        if pressure_gpa.min() < limit_gpa < pressure_gpa.max():
            panel.axes.contour(
                pressure_map.columns,
                pressure_map.index,
                pressure_gpa,
                [limit_gpa],
                colors=_PRESSURE_LINE["color"],
                linestyles=_PRESSURE_LINE["linestyle"],
                linewidths=_PRESSURE_LINE["linewidth"],
            )
            yield limit_gpa


def axis_columns(rows: pd.DataFrame) -> dict[str, "pd.Series[float]"]:
    """Columns `dmn` (pitch diameter times speed, million mm rpm) and `load_kn`."""
    return {"dmn": rows["pitch_speed_mm_rpm"] / 1e6, "load_kn": rows["axial_load_n"] / 1e3}


def _draw_slip(panel: Panel, rows_of_oil: pd.DataFrame, oil: str, slip_limit: float) -> Any:
    """Draw the cage slip over dmN and load, and where it reaches the limit.

    Returns:
        The coloured cells, for the colour bar.
    """
    axes = panel.axes
    maps = rows_of_oil.pivot(index="load_kn", columns="dmn")
    slip = np.ma.masked_invalid(maps["cage_slip"].to_numpy())
    lower = np.ma.masked_invalid(maps["cage_slip_lower"].to_numpy())
    upper = np.ma.masked_invalid(maps["cage_slip_upper"].to_numpy())
    dmn = maps["cage_slip"].columns.to_numpy()
    load_kn = maps.index.to_numpy()
    dmn_edges = style.cell_edges(dmn, axes.get_xscale())
    load_edges = style.cell_edges(load_kn, axes.get_yscale())
    norm = BoundaryNorm(_SLIP_LEVELS, 256)
    cells = axes.pcolormesh(dmn_edges, load_edges, slip, cmap="cividis_r", norm=norm)
    full: style.Look = {"linewidths": 1.1}
    dashed: style.Look = {"linewidths": 0.8, "linestyles": "--"}
    for field, look in ((slip, full), (lower, dashed), (upper, dashed)):
        if field.count():
            axes.contour(dmn, load_kn, field, [slip_limit], colors="black", **look)
    _draw_motions(panel, rows_of_oil, "dmn", "load_kn")
    axes.grid(False)
    panel.record(
        _motion_labels(rows_of_oil, two_motions="bistable", one_motion="cell"),
        rows_of_oil["dmn"],
        rows_of_oil["load_kn"],
        oil=oil,
        value=rows_of_oil["cage_slip"],
        lower=rows_of_oil["cage_slip_lower"],
        upper=rows_of_oil["cage_slip_upper"],
    )
    return cells


@declare_figure(family="bearing", tables=("size_effect",), settings=("oils",), requires="torque")
def size_effect(results: CampaignTables, settings: Settings) -> Sheet:
    """Size effect of laws of load.

    Traction torque by the load-based laws, relative to the pressure-based law (%). Left:
    against ball diameter (mm), with all lengths in proportion and equal pressure and surface
    speed. Right: against conformity, with equal load and speed. Symbols are calculated, lines
    join them. A curve bends where the larger traction of larger balls ends their gyroscopic
    slip while that by spin goes on growing.
    """
    oils = list(settings.oils)
    effects = results.size_effect
    sheet = Sheet(2, 2, left=0.7, sharey=True)
    panels = (
        ("ball size", "ball_diameter_mm", "Ball diameter (mm)", "pressure and surface speed"),
        ("conformity", "groove_curvature", "Groove radius over ball diameter", "load and speed"),
    )
    for index, (varied, column, label, constant_conditions) in enumerate(panels):
        panel = sheet.panel(index, f"{varied} at the same {constant_conditions}")
        effects_of_panel = effects[effects["varied"] == varied]
        for oil, variable in itertools.product(oils, _LOOK_OF_LOAD_VARIABLE):
            series = effects_of_panel[
                (effects_of_panel["oil"] == oil) & (effects_of_panel["load_variable"] == variable)
            ]
            look: style.Look = {"color": style.oil_colour(oil, oils)}
            look.update(_LOOK_OF_LOAD_VARIABLE[variable])
            panel.line(variable, series[column], 100 * series["relative_to_stress"], look, oil=oil)
        panel.axes.axhline(0, color="black", linewidth=0.6)
        panel.axes.set(
            xlabel=label, ylabel="Traction torque above that\nof the pressure-based law (%)"
        )
        if effects.empty:
            panel.write_message(_NO_LAW, fontsize=6)
    sheet.axes_of_panels[1].yaxis.label.set_visible(False)
    grey: style.Look = {"color": style.GREY, "linewidth": 0.9}
    laws = [
        style.line_handle(load_variable_in_words(variable), **grey, **look)
        for variable, look in _LOOK_OF_LOAD_VARIABLE.items()
    ]
    sheet.legend([*style.oil_patches(style.oils_in(effects, settings), oils), *laws])
    return sheet


@declare_figure(
    family="bearing", tables=("test_plan", "points"), settings=("oils",), requires="torque"
)
def plan(results: CampaignTables, settings: Settings) -> Sheet:
    """Tests to run next.

    Tests that the rig can run, one column of panels per oil. Abscissa: entrainment speed U
    (m/s). Ordinate: maximum Hertz pressure P (GPa, top) or inlet temperature T
    (\N{DEGREE SIGN}C, bottom). Colour: reduction (%) of the uncertainty of the calculated friction
    torque by one more curve: the whole uncertainty, with drag, feed oil and ring temperatures, as
    root mean square over the duty points. The third condition has its best level. Numbers: tests to
    run next, in this order; there are none where another cause than the law makes the largest share
    of the variance. Circles: measured runs. White: the rig cannot run the test with a full film.
    """
    tests = results.test_plan
    remaining_share = tests["uncertainty_with_test"] / tests["uncertainty_now"]
    tests = tests.assign(reduction=100 * (1 - remaining_share))
    tests = tests[tests["target"] == "torque"]
    points = results.table("points", ["oil", "run_id", "accepted", *CONDITIONS])
    points = points[points["accepted"]]
    runs = points.groupby(["oil", "run_id"], as_index=False)[list(CONDITIONS)].mean().dropna()
    sheet, panels = oil_grid(
        style.oils_in(tests, settings),
        "No test can be planned for any oil:\n`oilfilm plan` says what is missing.",
        # the ordinate of each row; of the third condition the best level is shown
        (_PRESSURE, _TEMPERATURE),
        height=1.5,
        right=0.7,
        sharey="row",
        width=style.DOUBLE_COLUMN_IN,
    )
    for panel, y_column, oil in panels:
        panel.axes.set_ylabel(style.CONDITION_LABELS[y_column], fontsize=7)
        tests_of_oil = tests[tests["oil"] == oil]
        runs_of_oil = runs[runs["oil"] == oil]
        cells = _draw_plan(panel, tests_of_oil, runs_of_oil, y_column, tests["reduction"].max())
    sheet.label_axes(style.CONDITION_LABELS[_SPEED], fontsize=7)
    sheet.colour_bar(cells, "Reduction of the torque's uncertainty (%)")
    box_look: style.Look = {"marker": "s", "color": "black", "markerfacecolor": "white"}
    sheet.legend(
        [
            style.symbol_handle(
                "number: test to run next, in this order", markersize=6, **box_look
            ),
            style.symbol_handle("measured run", "o", color=style.GREY, markerfacecolor="none"),
        ]
    )
    return sheet


def _draw_plan(
    panel: Panel, tests: pd.DataFrame, runs: pd.DataFrame, y_column: str, largest_reduction: float
) -> Any:
    """Draw the reduction over speed and `y_column`, the measured runs and the chosen tests.

    Args:
        panel: The panel.
        tests: Possible tests of one oil.
        runs: Mean conditions of its runs.
        y_column: Column of the ordinate.
        largest_reduction: Largest reduction of all oils (%).

    Returns:
        The coloured cells, for the colour bar.
    """
    best_tests = tests.loc[tests.groupby([_SPEED, y_column])["uncertainty_with_test"].idxmin()]
    reduction_map = best_tests.pivot(index=y_column, columns=_SPEED, values="reduction")
    cells = panel.axes.pcolormesh(
        style.cell_edges(reduction_map.columns.to_numpy(dtype=float), "linear"),
        style.cell_edges(reduction_map.index.to_numpy(dtype=float), "linear"),
        np.ma.masked_invalid(reduction_map.to_numpy(dtype=float)),
        cmap="YlGnBu",
        vmin=0,
        vmax=max(largest_reduction, 1e-6),
        rasterized=True,
    )
    oil = best_tests["oil"].iloc[0]
    panel.record(
        "cell", best_tests[_SPEED], best_tests[y_column], value=best_tests["reduction"], oil=oil
    )
    ring_look: style.Look = {"marker": "o", "markersize": 2.2, "markerfacecolor": "none"}
    ring_look["color"] = style.GREY
    panel.dots("measured", runs[_SPEED], runs[y_column], ring_look, oil=oil)
    chosen = tests[tests["test_order"] > 0].sort_values("test_order")
    number_look: style.Look = {"ha": "center", "va": "center", "fontsize": 6, "weight": "bold"}
    number_look["bbox"] = {"boxstyle": "round,pad=0.15", "facecolor": "white", "linewidth": 0.5}
    for (speed_m_s, level), tests_of_cell in chosen.groupby([_SPEED, y_column]):
        # three numbers side by side would cover the neighbouring cells
        separator = ", " if len(tests_of_cell) < 3 else "\n"
        order_text = separator.join(tests_of_cell["test_order"].astype(str))
        panel.axes.annotate(order_text, (speed_m_s, level), **number_look)
    panel.record("chosen", chosen[_SPEED], chosen[y_column], value=chosen["test_order"], oil=oil)
    panel.axes.grid(False)
    return cells
