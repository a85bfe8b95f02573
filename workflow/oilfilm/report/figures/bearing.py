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

# Temperatures by the fill of symbols and the dashes of lines.
_LEVELS = (("full", "-"), ("none", (0, (5, 2))), ("left", ":"), ("right", "-."), ("top", "-"))
# The campaign's own law, and the one on load that it is compared with, by colour.
_LAWS = {"stress": "#0072B2", "wang-deng-load": "#D55E00"}
_LOOKS: dict[str, style.Look] = {
    "load": {"linestyle": style.LINES["load"], "marker": "s"},
    "dimensionless_load": {"linestyle": style.LINES["dimensionless load"], "marker": "^"},
}
_SLIP_LEVELS = (-1.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.75, 1.0)
_CROSS: style.Look = {"marker": "x", "color": "black", "linestyle": "", "markersize": 4}
_UNKNOWN: style.Look = {**_CROSS, "marker": "+", "color": style.GREY}
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
    table = _in_sets(results.torque, settings)
    levels = sorted(set(table["level"]))
    sheet, panels = oil_grid(
        style.oils_in(table, settings),
        "No torque was measured, or no law could be evaluated.",
        sorted(set(table["load"])),
        lambda load, oil: f"{oil}, {round(load / 1e3, 1):g} kN",
        **{"height": 1.2, "sharey": "row", "width": style.DOUBLE_COLUMN_IN},
    )
    for panel, load, oil in panels:
        rows = table[(table["oil"] == oil) & (table["load"] == load)]
        for level, (fill, dashes) in zip(levels, itertools.cycle(_LEVELS), strict=False):
            _draw_torque(panel, rows[rows["level"] == level], f"{level:.0f} degC", fill, dashes)
    sheet.label(style.SPEED_LABEL, "Friction torque (N m)", fontsize=7)
    laws = [law for law in _LAWS if (table["load_variable"] == law).any()]
    handles: list[Any] = [Patch(color=_LAWS[law], label=load_variable(law)) for law in laws]
    black: style.Look = {"marker": "o", "markersize": 4, "color": "black", "linewidth": 0.9}
    for level, (fill, dashes) in zip(levels, itertools.cycle(_LEVELS), strict=False):
        label = f"{level:.0f} \N{DEGREE SIGN}C: measured and calculated"
        handles.append(style.line_handle(label, fillstyle=fill, linestyle=dashes, **black))
    sheet.legend(handles + _motion_handles(table))
    return sheet


def _draw_torque(panel: Panel, rows: pd.DataFrame, label: str, fill: str, dashes: Any) -> None:
    """Lines of each law and symbols of what was measured, of one panel at one temperature."""
    rows = rows.sort_values("inner_speed_rpm", kind="stable")
    speed = rows["inner_speed_rpm"] / 1e3
    for law, colour in _LAWS.items():
        own = rows["load_variable"] == law
        at = rows[own].assign(speed=speed[own])
        band = {"lower": at["torque_n_m_lower"], "upper": at["torque_n_m_upper"]}
        band["label"] = label + _motions(at, ", bistable", "")
        look = {"color": colour, "linestyle": dashes, "linewidth": 0.9}
        name = load_variable(law)
        panel.line(name, speed[own], at["torque_n_m"], look, oil=at["oil"], **band)
        _draw_motions(panel, at, "speed", "torque_n_m")
    own = rows["load_variable"] == "stress"
    values = rows.loc[own, "measured_torque_n_m"]
    bar = style.SE_DRAWN * rows.loc[own, "measured_torque_n_m_uncertainty"]
    about = {"label": label, "oil": rows.loc[own, "oil"]}
    about |= {"lower": values - bar, "upper": values + bar}
    look = {"color": "black", "marker": "o", "fillstyle": fill, "elinewidth": 0.7}
    panel.dots("measured", speed[own], values, look, **about)


def _in_sets(table: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The table with the set points of `load` and temperature (`level`) that rows belong to."""
    within = settings.figures.torque.same_within

    def mean_of_set(measured: "pd.Series[float]") -> "pd.Series[float]":
        ranked = measured.sort_values()
        apart = pd.Series(exceeds(ranked.diff(), within * ranked.shift()), ranked.index)
        return measured.groupby(apart.cumsum()).transform("mean")

    loads, levels = map(mean_of_set, (table["axial_load_n"], table["inlet_temperature_c"]))
    return table.assign(load=loads, level=levels)


def _draw_motions(panel: Panel, rows: pd.DataFrame, x: str, y: str) -> None:
    """Crosses where the cage may roll or skid, and others where that is not known."""
    for chosen, look in ((is_bistable(rows), _CROSS), (rows["bistable"].isna(), _UNKNOWN)):
        panel.axis.plot(rows.loc[chosen, x], rows.loc[chosen, y], **look)


def _motion_handles(table: pd.DataFrame) -> list[Any]:
    handles = [style.line_handle("cage may roll or skid", **_CROSS)]
    handles = handles if is_bistable(table).any() else []
    if table["bistable"].isna().any():
        handles.append(style.line_handle("not known whether there is another motion", **_UNKNOWN))
    return handles


def _motions(rows: pd.DataFrame, both: str, one: str) -> "pd.Series[str]":
    """A label of each row by its flag `bistable`; where it is null, that of one with a note."""
    labels = rows["bistable"].astype(object).map({True: both, False: one})
    return labels.where(rows["bistable"].notna(), f"{one}, perhaps bistable")


@register(family="bearing", tables=("cage_slip",), settings=("oils", "bearing"), requires="torque")
def cage_slip(results: CampaignTables, settings: Settings) -> Sheet:
    """Cage slip.

    Cage slip at friction equilibrium, one panel per oil. Abscissa: dmN, pitch diameter times
    speed (million mm rpm), and entrainment speed U of rolling balls. Ordinate: axial load (kN).
    Full line: limit of the cage slip. Dashed lines: the 2.5 % and 97.5 % quantiles of the slip
    reach the limit, where they could be calculated. Crosses: the cage may roll or skid.
    """
    table = results.cage_slip.assign(**in_units_of_axes(results.cage_slip))
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
    """Speed in million mm rpm and load in kN."""
    return {"speed": rows["pitch_speed_mm_rpm"] / 1e6, "load_kn": rows["axial_load_n"] / 1e3}


def _draw_slip(panel: Panel, of_oil: pd.DataFrame, oil: str, limit: float) -> Any:
    axis = panel.axis
    fields = of_oil.pivot(index="load_kn", columns="speed")
    slip, lower, upper = (
        np.ma.masked_invalid(fields[name].to_numpy())
        for name in ("cage_slip", "cage_slip_lower", "cage_slip_upper")
    )
    speed, load = fields["cage_slip"].columns.to_numpy(), fields.index.to_numpy()
    across = style.cell_edges(speed, axis.get_xscale())
    along = style.cell_edges(load, axis.get_yscale())
    norm = BoundaryNorm(_SLIP_LEVELS, 256)
    filled = axis.pcolormesh(across, along, slip, cmap="cividis_r", norm=norm)
    ends: style.Look = {"linewidths": 0.8, "linestyles": "--"}
    for field, look in ((slip, {"linewidths": 1.1}), (lower, ends), (upper, ends)):
        if field.count():
            axis.contour(speed, load, field, [limit], colors="black", **look)
    _draw_motions(panel, of_oil, "speed", "load_kn")
    axis.grid(False)
    series = _motions(of_oil, "bistable", "cell")
    about = {"lower": of_oil["cage_slip_lower"], "upper": of_oil["cage_slip_upper"]}
    about["value"] = of_oil["cage_slip"]
    panel.keep(series, of_oil["speed"], of_oil["load_kn"], oil=oil, **about)
    return filled


@register(family="bearing", tables=("size_effect",), settings=("oils",), requires="torque")
def size_effect(results: CampaignTables, settings: Settings) -> Sheet:
    """Size effect of laws of load.

    Traction torque by the load-based laws, relative to the pressure-based law (%). Left:
    against ball diameter (mm), with all lengths in proportion and equal pressure and surface
    speed. Right: against conformity, with equal load and speed. Symbols are calculated, lines
    join them. A curve bends where the larger traction of larger balls ends their gyroscopic
    slip while that by spin goes on growing.
    """
    oils, table = list(settings.oils), results.size_effect
    sheet = Sheet(2, 2, left=0.7, sharey=True)
    panels = (
        ("ball size", "ball_diameter_mm", "Ball diameter (mm)", "pressure and surface speed"),
        ("conformity", "groove_curvature", "Groove radius over ball diameter", "load and speed"),
    )
    for number, (varied, column, label, held) in enumerate(panels):
        panel = sheet.panel(number, f"{varied} at the same {held}")
        rows = table[table["varied"] == varied]
        for oil, variable in itertools.product(oils, _LOOKS):
            line = rows[(rows["oil"] == oil) & (rows["load_variable"] == variable)]
            look = {"color": style.oil_colour(oil, oils), **_LOOKS[variable]}
            panel.line(variable, line[column], 100 * line["relative_to_stress"], look, oil=oil)
        panel.axis.axhline(0, color="black", linewidth=0.6)
        panel.axis.set(
            xlabel=label, ylabel="Traction torque above that\nof the pressure-based law (%)"
        )
        if table.empty:
            panel.say(_NO_LAW, fontsize=6)
    sheet.axes[1].yaxis.label.set_visible(False)
    grey: style.Look = {"color": style.GREY, "linewidth": 0.9}
    laws = [style.line_handle(load_variable(name), **grey, **_LOOKS[name]) for name in _LOOKS]
    sheet.legend([*style.oil_patches(style.oils_in(table, settings), oils), *laws])
    return sheet


@register(family="bearing", tables=("test_plan", "points"), settings=("oils",), requires="torque")
def plan(results: CampaignTables, settings: Settings) -> Sheet:
    """Tests to run next.

    Tests that the rig can run, one column of panels per oil. Abscissa: entrainment speed U
    (m/s). Ordinate: maximum Hertz pressure P (GPa, top) or inlet temperature T
    (\N{DEGREE SIGN}C, bottom). Colour: reduction (%) of the uncertainty of the calculated friction
    torque
    by one more curve. Only the uncertainty from the law counts, its form included, as root mean
    square over the duty points. The third condition has its best level. Numbers: tests to run
    next, in this order. Circles: measured runs. White: the rig cannot run the test with a full
    film.
    """
    tests = results.test_plan
    # by how much one test reduces the uncertainty
    share = tests["uncertainty_with_test"] / tests["uncertainty_now"]
    tests = tests.assign(reduction=100 * (1 - share))[tests["target"] == "torque"]
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
        of_oil, of_runs = tests[tests["oil"] == oil], runs[runs["oil"] == oil]
        mesh = _draw_plan(panel, of_oil, of_runs, y, tests["reduction"].max())
    sheet.label(style.CONDITION_LABELS[_SPEED], fontsize=7)
    sheet.colour_bar(mesh, "Reduction of the torque's uncertainty (%)")
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
    """Cells of speed and `y`, runs and chosen tests."""
    best = tests.loc[tests.groupby([_SPEED, y])["uncertainty_with_test"].idxmin()]
    field = best.pivot(index=y, columns=_SPEED, values="reduction")
    mesh = panel.axis.pcolormesh(
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
    panel.dots("measured", runs[_SPEED], runs[y], ring | {"color": style.GREY}, oil=oil)
    chosen = tests[tests["test_order"] > 0].sort_values("test_order")
    look: style.Look = {"ha": "center", "va": "center", "fontsize": 6, "weight": "bold"}
    look["bbox"] = {"boxstyle": "round,pad=0.15", "facecolor": "white", "linewidth": 0.5}
    for (speed, level), same in chosen.groupby([_SPEED, y]):
        # many side by side would cover their neighbours
        numbers = (", " if len(same) < 3 else "\n").join(same["test_order"].astype(str))
        panel.axis.annotate(numbers, (speed, level), **look)
    panel.keep("chosen", chosen[_SPEED], chosen[y], value=chosen["test_order"], oil=oil)
    panel.axis.grid(False)
    return mesh
