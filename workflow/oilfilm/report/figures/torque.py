"""Figures of measured and calculated friction torque."""

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_DRAWN_INTERVAL = 1.96  # bars are 95 % intervals, in standard uncertainties
_FILLS = ("full", "none", "left", "right", "bottom", "top")  # of the symbols, by temperature
# The campaign's own law, and the one on load that it is compared with.
_LAWS: dict[str, tuple[str, dict[str, Any]]] = {
    "stress": ("pressure-based", {"color": "#0072B2", "linestyle": "-"}),
    "wang-deng-load": ("load-based", {"color": "#D55E00", "linestyle": (0, (4, 2))}),
}
_LOAD_VARIABLES = {
    "stress": "pressure P",
    "load": "load W",
    "dimensionless_load": "load W/(E'R\N{SUPERSCRIPT TWO})",
}
_SPEED = "Speed of the inner ring (1000 rpm)"
_NOTHING = "No torque was measured, or no law could be evaluated."


@register(
    name="torque",
    title="Friction torque of the bearing",
    caption="Friction torque (N m) against speed of the inner ring, one panel per oil and "
    "axial load. Symbols: measured torque; bars: 95 % interval from random error and "
    "calibration. Lines: torque calculated with the pressure-based law and with the load-based "
    "Wang-Deng law. Bands: 95 % interval from refits of the law, calibration and the other terms "
    "of the torque. Numbers: median error of each law, and points that agree within twice the "
    "standard uncertainty of the difference. Crosses: the cage may roll or skid.",
    category="Bearing",
    family="bearing",
    tables=("torque", "torque_control", "fit_quality"),
    settings=("oils", "figures"),
    requires="torque",
)
def torque(results: CampaignTables, settings: Settings) -> Drawing:
    """Measured and calculated torque against speed, one panel per oil and axial load."""
    table = _in_sets(results.torque, settings)
    oils = [oil for oil in settings.oils if (table["oil"] == oil).any()]
    if not oils:
        return style.sentences(_NOTHING), []
    loads, levels = (sorted(set(table[name])) for name in ("load", "level"))
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 1.55 * len(loads) + 0.6))
    axes = figure.subplots(len(loads), len(oils), sharex=True, sharey="row", squeeze=False)
    drawn: list[pd.DataFrame] = []
    for number, axis in enumerate(axes.flat):
        load, oil = loads[number // len(oils)], oils[number % len(oils)]
        panel = style.title_panel(axis, number, f"{oil}, {round(load / 1e3, 1):g} kN")
        rows = table[(table["oil"] == oil) & (table["load"] == load)]
        drawn += (part.assign(oil=oil) for part in _draw_torque(axis, panel, rows, levels))
    figure.supylabel("Friction torque (N m)", fontsize=8)
    for axis in axes[-1]:
        axis.set_xlabel(_SPEED)
    handles = [
        style.symbol_handle(
            f"measured, {level:.0f} \N{DEGREE SIGN}C", "o", color="black", fillstyle=fill
        )
        for level, fill in zip(levels, itertools.cycle(_FILLS), strict=False)
    ]
    handles += [
        style.line_handle(name, **look)
        for load_variable, (name, look) in _LAWS.items()
        if (table["load_variable"] == load_variable).any()
    ]
    if table["bistable"].any():
        handles.append(style.symbol_handle("cage may roll or skid", "x", color="black"))
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 5))
    style.say_key(figure, "\n".join(_remarks(results)))
    return figure, drawn


def _in_sets(torque: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The table with the set points of `load` and temperature (`level`) that rows belong to."""
    within = settings.figures.fig06.same_within
    return torque.assign(
        load=_sets(torque["axial_load_n"], within),
        level=_sets(torque["inlet_temperature_c"], within),
    )


def _sets(levels: "pd.Series[float]", within: float) -> "pd.Series[float]":
    """For each measured level the mean of those that it belongs with."""
    ranked = levels.sort_values()
    apart = ranked.diff() > within * ranked.shift()
    return levels.groupby(apart.cumsum()).transform("mean")


def _draw_torque(
    axis: Axes, panel: str, rows: pd.DataFrame, levels: list[float]
) -> Iterator[pd.DataFrame]:
    """Points and laws of one oil at one load; yields what is drawn."""
    verdicts = []
    for load_variable, (name, look) in _LAWS.items():
        of_law = rows[rows["load_variable"] == load_variable]
        for level, at in of_law.sort_values("inner_speed_rpm").groupby("level"):
            speed, ends = (
                at["inner_speed_rpm"] / 1e3,
                (at["torque_n_m_lower"], at["torque_n_m_upper"]),
            )
            axis.plot(speed, at["torque_n_m"], linewidth=0.9, **look)
            axis.fill_between(speed, *ends, color=look["color"], alpha=0.22, linewidth=0)
            axis.plot(speed[at["bistable"]], at["torque_n_m"][at["bistable"]], "kx", markersize=4)
            label = np.where(at["bistable"], f"{level:.0f} degC, bistable", f"{level:.0f} degC")
            band = dict(zip(("lower", "upper"), ends, strict=True))
            yield marks(panel, name, speed, at["torque_n_m"], label=label, **band)
        sure = of_law[~of_law["bistable"]].dropna(subset=["relative_error"])
        if len(sure):
            error = sure["relative_error"].abs().median()
            agree = (sure["verdict"] == "compatible").sum()
            known = (sure["verdict"] != "not known").any()
            agrees = f", {agree} of {len(sure)} agree" if known else ""
            verdicts.append((f"{100 * error:.2g} %{agrees}", look["color"]))
    measured = rows[rows["load_variable"] == "stress"]
    for level, fill in zip(levels, itertools.cycle(_FILLS), strict=False):
        at = measured[measured["level"] == level]
        speed, values = at["inner_speed_rpm"] / 1e3, at["measured_torque_n_m"]
        bar = _DRAWN_INTERVAL * at["measured_torque_n_m_uncertainty"]
        points: dict[str, Any] = {"color": "black", "fillstyle": fill, "elinewidth": 0.7}
        axis.errorbar(speed, values, bar, fmt="o", **points)
        about = {"label": f"{level:.0f} degC", "lower": values - bar, "upper": values + bar}
        yield marks(panel, "measured", speed, values, **about)
    for line, (verdict, colour) in enumerate(verdicts):
        place: dict[str, Any] = {"va": "top", "transform": axis.transAxes}
        axis.text(0.03, 0.98 - 0.11 * line, verdict, fontsize=6, color=colour, **place)


def _remarks(results: CampaignTables) -> Iterator[str]:
    """What the key says of simulated truth and of fits without a certificate."""
    yield (
        "Bars and bands: 95 %. In the panels: median error, and points at which\ncalculated and "
        "measured torque agree within twice the standard uncertainty."
    )
    control, quality = results.torque_control, results.fit_quality
    if len(control):
        yield misfit_sentence(control)
    unsure = quality[(quality["law"] == "wang-deng-load") & ~quality["certified"]]
    if len(unsure):
        yield f"Fit of Wang-Deng without a certificate: {', '.join(unsure['oil'])}."


def misfit_sentence(control: pd.DataFrame) -> str:
    """What simulated logs are: a positive control, or two truths that are so far apart.

    Args:
        control: Table `torque_control`, with rows.
    """
    if (control["verdict"] == "positive control").all():
        return "Positive control: the pressure-based law and the same other terms made the logs."
    return (
        f"Simulated traction behind the two rigs' logs: {control['law_misfit'].max():.1%} of "
        "\N{GREEK SMALL LETTER MU} apart."
    )


@register(
    name="torque-load-variable",
    title="Load variables of the law in the bearing",
    caption="Error (%) of the calculated torque against speed of the inner ring, one panel "
    "per oil and load variable. The law is evaluated with pressure, with load and with "
    "dimensionless load. Crosses: the cage may roll or skid.",
    category="Bearing",
    family="bearing",
    tables=("torque", "torque_control"),
    settings=("oils", "figures"),
    requires="torque",
)
def torque_load_variable(results: CampaignTables, settings: Settings) -> Drawing:
    """Relative error of the torque against speed, one panel per load variable and oil."""
    choice = settings.figures.fig06
    near = results.torque["inlet_temperature_c"] - choice.inlet_temperature_c
    here = near.abs() <= choice.same_within * choice.inlet_temperature_c
    table = _in_sets(results.torque[here], settings)
    oils = [oil for oil in settings.oils if (table["oil"] == oil).any()]
    if not oils:
        return style.sentences("No torque was measured at this temperature."), []
    loads = sorted(set(table["load"]))
    figure, axes = style.panels(3, len(oils), style.DOUBLE_COLUMN_IN, 4.8)
    drawn = []
    for number, axis in enumerate(axes):
        load_variable, oil = list(_LOAD_VARIABLES)[number // len(oils)], oils[number % len(oils)]
        panel = style.title_panel(axis, number, f"{oil}, {_LOAD_VARIABLES[load_variable]}")
        rows = table[(table["oil"] == oil) & (table["load_variable"] == load_variable)]
        shades = style.shades(style.oil_colour(oil, list(settings.oils)), len(loads))
        for load, shade, marker in zip(loads, shades, style.MARKERS, strict=False):
            at = rows[rows["load"] == load].sort_values("inner_speed_rpm")
            speed, error = at["inner_speed_rpm"] / 1e3, 100 * at["relative_error"]
            axis.plot(speed, error, marker=marker, color=shade, linewidth=0.9)
            axis.plot(speed[at["bistable"]], error[at["bistable"]], "kx", markersize=5)
            series = f"{round(load / 1e3, 1):g} kN"
            drawn.append(
                marks(panel, series, speed, error, oil=oil, value=at["bistable"].astype(float))
            )
        axis.axhline(0, color="black", linewidth=0.6)
    figure.supylabel("Relative error of the torque (%)", fontsize=8)
    for axis in axes[-len(oils) :]:
        axis.set_xlabel(_SPEED)
    # loads in shades of grey: each oil has its own colour
    handles = [
        style.line_handle(f"axial load {round(load / 1e3, 1):g} kN", marker=marker, color=shade)
        for load, shade, marker in zip(
            loads, style.shades(style.GREY, len(loads)), style.MARKERS, strict=False
        )
    ]
    if table["bistable"].any():
        handles.append(style.symbol_handle("cage may roll or skid", "x", color="black"))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    control = results.torque_control
    said = f"Oil at {choice.inlet_temperature_c:g} \N{DEGREE SIGN}C."
    style.say_key(figure, f"{said} {misfit_sentence(control)}" if len(control) else said)
    return figure, drawn
