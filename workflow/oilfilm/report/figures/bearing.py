"""Figures of the bearing: friction torque, cage slip, size effect and the tests to run next."""

import itertools
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import BoundaryNorm
from matplotlib.patches import Patch

from oilfilm.base.ties import exceeds
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import Panel, Sheet, oil_grid, register
from oilfilm.report.words import load_variable
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
# Colours of the campaign's law and of the law of load that it is compared with.
_LAW_COLOURS = {"stress": "#0072B2", "wang-deng-load": "#D55E00"}
_LOOK_OF_LOAD_VARIABLE: dict[str, style.Look] = {
    "load": {"linestyle": style.LINES["load"], "marker": "s"},
    "dimensionless_load": {"linestyle": style.LINES["dimensionless load"], "marker": "^"},
}
_SLIP_LEVELS = (-1.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0)
_BISTABLE: style.Look = {"marker": "x", "color": "black", "linestyle": "", "markersize": 4}
_NOT_KNOWN: style.Look = {"marker": "+", "color": style.GREY, "linestyle": "", "markersize": 4}
_NO_LAW = "No oil has a law that a bearing could use."
_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS


@register(family="bearing", tables=("torque",), settings=("oils", "figures"), requires="torque")
def torque(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction torque of the bearing.

    Friction torque (N m) against speed of the inner ring, one panel per oil and axial load.
    Symbols: measured torque; bars: 95 % interval from random error and calibration. Lines:
    torque calculated with the pressure-based law and with the load-based Wang-Deng law. Bands:
    95 % interval from refits of the law, calibration and the other terms of the torque. Crosses:
    the cage may roll or skid.
    """
    table = _with_set_points(results.torque, settings)
    looks_of_level = list(
        zip(sorted(set(table["level"])), itertools.cycle(_TEMPERATURE_LOOKS), strict=False)
    )
    sheet, panels = oil_grid(
        style.oils_in(table, settings),
        "No torque was measured, or no law could be evaluated.",
        sorted(set(table["load"])),
        lambda load, oil: f"{oil}, {round(load / 1e3, 1):g} kN",
        height=1.2,
        sharey="row",
        width=style.DOUBLE_COLUMN_IN,
    )
    for panel, load, oil in panels:
        rows = table[(table["oil"] == oil) & (table["load"] == load)]
        for level, (fill, dashes) in looks_of_level:
            _draw_torque(panel, rows[rows["level"] == level], f"{level:.0f} degC", fill, dashes)
    sheet.label(style.SPEED_LABEL, "Friction torque (N m)", fontsize=7)
    handles: list[Any] = [
        Patch(color=colour, label=load_variable(law))
        for law, colour in _LAW_COLOURS.items()
        if (table["load_variable"] == law).any()
    ]
    black: style.Look = {"marker": "o", "markersize": 4, "color": "black", "linewidth": 0.9}
    for level, (fill, dashes) in looks_of_level:
        label = f"{level:.0f} \N{DEGREE SIGN}C: measured and calculated"
        handles.append(style.line_handle(label, fillstyle=fill, linestyle=dashes, **black))
    sheet.legend(handles + _motion_handles(table))
    return sheet


def _draw_torque(panel: Panel, rows: pd.DataFrame, label: str, fill: str, dashes: Any) -> None:
    """Draw the lines of each law and the measured symbols of one panel at one temperature."""
    rows = rows.sort_values("inner_speed_rpm", kind="stable")
    rows = rows.assign(speed=rows["inner_speed_rpm"] / 1e3)
    for law, colour in _LAW_COLOURS.items():
        by_law = rows[rows["load_variable"] == law]
        panel.line(
            load_variable(law),
            by_law["speed"],
            by_law["torque_n_m"],
            {"color": colour, "linestyle": dashes, "linewidth": 0.9},
            oil=by_law["oil"],
            lower=by_law["torque_n_m_lower"],
            upper=by_law["torque_n_m_upper"],
            label=label + _motion_labels(by_law, two_motions=", bistable", one_motion=""),
        )
        _draw_motions(panel, by_law, "speed", "torque_n_m")
    # each plateau has one row per law
    plateaus = rows[rows["load_variable"] == "stress"]
    measured = plateaus["measured_torque_n_m"]
    half_bar = style.SE_DRAWN * plateaus["measured_torque_n_m_uncertainty"]
    panel.dots(
        "measured",
        plateaus["speed"],
        measured,
        {"color": "black", "marker": "o", "fillstyle": fill, "elinewidth": 0.7},
        label=label,
        oil=plateaus["oil"],
        lower=measured - half_bar,
        upper=measured + half_bar,
    )


def _with_set_points(table: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The table with the set points of each row: `load` (N) and temperature `level` (degC).

    A set point is the mean of neighbouring measured values that are the same within the setting.
    """
    within = settings.figures.torque.same_within

    def set_points(measured: "pd.Series[float]") -> "pd.Series[float]":
        ranked = measured.sort_values()
        is_first_of_set = pd.Series(exceeds(ranked.diff(), within * ranked.shift()), ranked.index)
        return measured.groupby(is_first_of_set.cumsum()).transform("mean")

    return table.assign(
        load=set_points(table["axial_load_n"]), level=set_points(table["inlet_temperature_c"])
    )


def _draw_motions(panel: Panel, rows: pd.DataFrame, x: str, y: str) -> None:
    """Mark where the cage may roll or skid, and where that is not known.

    Args:
        panel: The panel.
        rows: Rows with the flag `bistable`.
        x: Column of the abscissa.
        y: Column of the ordinate.
    """
    bistable = rows[is_bistable(rows)]
    not_known = rows[rows["bistable"].isna()]
    panel.axis.plot(bistable[x], bistable[y], **_BISTABLE)
    panel.axis.plot(not_known[x], not_known[y], **_NOT_KNOWN)


def _motion_handles(table: pd.DataFrame) -> list[Any]:
    """Entries of the legend for the marks of `_draw_motions` that occur."""
    handles = []
    if is_bistable(table).any():
        handles.append(style.line_handle("cage may roll or skid", **_BISTABLE))
    if table["bistable"].isna().any():
        handles.append(style.line_handle("not known whether there is another motion", **_NOT_KNOWN))
    return handles


def _motion_labels(rows: pd.DataFrame, *, two_motions: str, one_motion: str) -> "pd.Series[str]":
    """A label of each row by its flag `bistable`; where it is null, that of one with a note."""
    labels = rows["bistable"].astype(object).map({True: two_motions, False: one_motion})
    return labels.where(rows["bistable"].notna(), f"{one_motion}, perhaps bistable")


@register(family="bearing", tables=("cage_slip",), settings=("oils", "bearing"), requires="torque")
def cage_slip(results: CampaignTables, settings: Settings) -> Sheet:
    """Cage slip.

    Cage slip at friction equilibrium, one panel per oil. Abscissa: dmN, pitch diameter times
    speed (million mm rpm), and entrainment speed U of rolling balls. Ordinate: axial load (kN).
    Full line: limit of the cage slip. Dashed lines: the 2.5 % and 97.5 % quantiles of the slip
    reach the limit, where they could be calculated. Crosses: the cage may roll or skid.
    """
    table = results.cage_slip
    table = table.assign(**in_units_of_axes(table))
    limit = settings.bearing.cage_slip.slip_limit
    sheet, panels = oil_grid(style.oils_in(table, settings), _NO_LAW, height=1.7, right=0.75)
    sheet.axes[0].set_yscale("log")
    sheet.axes[0].yaxis.set_major_formatter("{x:g}")
    for panel, _, oil in panels:
        filled = _draw_slip(panel, table[table["oil"] == oil], oil, limit)
    bar = sheet.colour_bar(filled, "Cage slip", ticks=_SLIP_LEVELS[1:])
    bar.set_yticklabels([f"{level:g}" for level in _SLIP_LEVELS[1:]])
    sheet.label(style.DMN_LABEL, style.AXIAL_LOAD_LABEL, fontsize=7)
    handles: list[Any] = [
        style.line_handle(f"slip of {limit:g}", color="black"),
        style.line_handle("its 95 % interval", linestyle="--", color="black", linewidth=0.8),
    ]
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    bearing = table["bearing"].iloc[0]
    title = f"{bearing}, oil at {temperature:g} \N{DEGREE SIGN}C; {style.DMN_AS_SPEED}"
    sheet.legend(handles + _motion_handles(table), title)
    return sheet


def in_units_of_axes(rows: pd.DataFrame) -> dict[str, "pd.Series[float]"]:
    """Columns `speed` (million mm rpm) and `load_kn`."""
    return {"speed": rows["pitch_speed_mm_rpm"] / 1e6, "load_kn": rows["axial_load_n"] / 1e3}


def _draw_slip(panel: Panel, of_oil: pd.DataFrame, oil: str, limit: float) -> Any:
    """Draw the cage slip over speed and load, and where it reaches the limit.

    Returns:
        The coloured cells, for the colour bar.
    """
    axis = panel.axis
    fields = of_oil.pivot(index="load_kn", columns="speed")
    slip = np.ma.masked_invalid(fields["cage_slip"].to_numpy())
    lower = np.ma.masked_invalid(fields["cage_slip_lower"].to_numpy())
    upper = np.ma.masked_invalid(fields["cage_slip_upper"].to_numpy())
    speed = fields["cage_slip"].columns.to_numpy()
    load_kn = fields.index.to_numpy()
    speed_edges = style.cell_edges(speed, axis.get_xscale())
    load_edges = style.cell_edges(load_kn, axis.get_yscale())
    norm = BoundaryNorm(_SLIP_LEVELS, 256)
    cells = axis.pcolormesh(speed_edges, load_edges, slip, cmap="cividis_r", norm=norm)
    full: style.Look = {"linewidths": 1.1}
    dashed: style.Look = {"linewidths": 0.8, "linestyles": "--"}
    for field, look in ((slip, full), (lower, dashed), (upper, dashed)):
        if field.count():
            axis.contour(speed, load_kn, field, [limit], colors="black", **look)
    _draw_motions(panel, of_oil, "speed", "load_kn")
    axis.grid(False)
    panel.keep(
        _motion_labels(of_oil, two_motions="bistable", one_motion="cell"),
        of_oil["speed"],
        of_oil["load_kn"],
        oil=oil,
        value=of_oil["cage_slip"],
        lower=of_oil["cage_slip_lower"],
        upper=of_oil["cage_slip_upper"],
    )
    return cells


@register(family="bearing", tables=("size_effect",), settings=("oils",), requires="torque")
def size_effect(results: CampaignTables, settings: Settings) -> Sheet:
    """Size effect of laws of load.

    Traction torque by the load-based laws, relative to the pressure-based law (%). Left:
    against ball diameter (mm), with all lengths in proportion and equal pressure and surface
    speed. Right: against conformity, with equal load and speed. Symbols are calculated, lines
    join them. A curve bends where the larger traction of larger balls ends their gyroscopic
    slip while that by spin goes on growing.
    """
    oils = list(settings.oils)
    table = results.size_effect
    sheet = Sheet(2, 2, left=0.7, sharey=True)
    panels = (
        ("ball size", "ball_diameter_mm", "Ball diameter (mm)", "pressure and surface speed"),
        ("conformity", "groove_curvature", "Groove radius over ball diameter", "load and speed"),
    )
    for number, (varied, column, label, constant_conditions) in enumerate(panels):
        panel = sheet.panel(number, f"{varied} at the same {constant_conditions}")
        rows = table[table["varied"] == varied]
        for oil, variable in itertools.product(oils, _LOOK_OF_LOAD_VARIABLE):
            line = rows[(rows["oil"] == oil) & (rows["load_variable"] == variable)]
            look: style.Look = {"color": style.oil_colour(oil, oils)}
            look.update(_LOOK_OF_LOAD_VARIABLE[variable])
            panel.line(variable, line[column], 100 * line["relative_to_stress"], look, oil=oil)
        panel.axis.axhline(0, color="black", linewidth=0.6)
        panel.axis.set(
            xlabel=label, ylabel="Traction torque above that\nof the pressure-based law (%)"
        )
        if table.empty:
            panel.say(_NO_LAW, fontsize=6)
    sheet.axes[1].yaxis.label.set_visible(False)
    grey: style.Look = {"color": style.GREY, "linewidth": 0.9}
    laws = [
        style.line_handle(load_variable(variable), **grey, **look)
        for variable, look in _LOOK_OF_LOAD_VARIABLE.items()
    ]
    sheet.legend([*style.oil_patches(style.oils_in(table, settings), oils), *laws])
    return sheet


@register(family="bearing", tables=("test_plan", "points"), settings=("oils",), requires="torque")
def plan(results: CampaignTables, settings: Settings) -> Sheet:
    """Tests to run next.

    Tests that the rig can run, one column of panels per oil. Abscissa: entrainment speed U
    (m/s). Ordinate: maximum Hertz pressure P (GPa, top) or inlet temperature T
    (\N{DEGREE SIGN}C, bottom). Colour: reduction (%) of the uncertainty of the calculated friction
    torque
    by one more curve: the whole uncertainty, with drag, feed oil and ring temperatures, as root
    mean square over the duty points. The third condition has its best level. Numbers: tests to run
    next, in this order; there are none where another cause than the law makes the largest share of
    the variance. Circles: measured runs. White: the rig cannot run the test with a full film.
    """
    tests = results.test_plan
    remaining_share = tests["uncertainty_with_test"] / tests["uncertainty_now"]
    tests = tests.assign(reduction=100 * (1 - remaining_share))
    tests = tests[tests["target"] == "torque"]
    points = results.points[results.points["accepted"]]
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
    for panel, y, oil in panels:
        panel.axis.set_ylabel(style.CONDITION_LABELS[y], fontsize=7)
        tests_of_oil = tests[tests["oil"] == oil]
        runs_of_oil = runs[runs["oil"] == oil]
        cells = _draw_plan(panel, tests_of_oil, runs_of_oil, y, tests["reduction"].max())
    sheet.label(style.CONDITION_LABELS[_SPEED], fontsize=7)
    sheet.colour_bar(cells, "Reduction of the torque's uncertainty (%)")
    box: style.Look = {"marker": "s", "color": "black", "markerfacecolor": "white"}
    sheet.legend(
        [
            style.symbol_handle("number: test to run next, in this order", markersize=6, **box),
            style.symbol_handle("measured run", "o", color=style.GREY, markerfacecolor="none"),
        ]
    )
    return sheet


def _draw_plan(
    panel: Panel, tests: pd.DataFrame, runs: pd.DataFrame, y: str, highest: float
) -> Any:
    """Draw the reduction over speed and `y`, the measured runs and the chosen tests.

    Args:
        panel: The panel.
        tests: Possible tests of one oil.
        runs: Mean conditions of its runs.
        y: Column of the ordinate.
        highest: Largest reduction of all oils (%).

    Returns:
        The coloured cells, for the colour bar.
    """
    best = tests.loc[tests.groupby([_SPEED, y])["uncertainty_with_test"].idxmin()]
    field = best.pivot(index=y, columns=_SPEED, values="reduction")
    cells = panel.axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(dtype=float), "linear"),
        style.cell_edges(field.index.to_numpy(dtype=float), "linear"),
        np.ma.masked_invalid(field.to_numpy(dtype=float)),
        cmap="YlGnBu",
        vmin=0,
        vmax=max(highest, 1e-6),
        rasterized=True,
    )
    oil = best["oil"].iloc[0]
    panel.keep("cell", best[_SPEED], best[y], value=best["reduction"], oil=oil)
    ring: style.Look = {"marker": "o", "markersize": 2.2, "markerfacecolor": "none"}
    ring["color"] = style.GREY
    panel.dots("measured", runs[_SPEED], runs[y], ring, oil=oil)
    chosen = tests[tests["test_order"] > 0].sort_values("test_order")
    number_look: style.Look = {"ha": "center", "va": "center", "fontsize": 6, "weight": "bold"}
    number_look["bbox"] = {"boxstyle": "round,pad=0.15", "facecolor": "white", "linewidth": 0.5}
    for (speed, level), tests_of_cell in chosen.groupby([_SPEED, y]):
        # three numbers side by side would cover the neighbouring cells
        separator = ", " if len(tests_of_cell) < 3 else "\n"
        numbers = separator.join(tests_of_cell["test_order"].astype(str))
        panel.axis.annotate(numbers, (speed, level), **number_look)
    panel.keep("chosen", chosen[_SPEED], chosen[y], value=chosen["test_order"], oil=oil)
    panel.axis.grid(False)
    return cells
