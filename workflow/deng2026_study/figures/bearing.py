"""Fig. 6 of the paper, the power loss of a published test, and the oil that its rules advise."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from deng2026_study.advice import (
    JUDGEMENTS_WITHOUT_CHOICE,
    NO_EQUILIBRIUM,
    OUTSIDE_FILM_FORMULA,
    STAYS_BEST_SHARE,
    has_known_best_oil,
)
from deng2026_study.settings import study_settings
from oilfilm.base.units import RAD_S_PER_RPM
from oilfilm.bearing.resistance import HEAT_TERMS
from oilfilm.report.figures import style
from oilfilm.report.figures.bearing import axis_columns, torque
from oilfilm.report.figures.sheet import SIMULATED, Panel, Sheet, declare_figure, text_figure
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import OPERATING_POINT_COLUMNS, is_best_in_share

# Share of an oil's colour in its field.
_FIELD_TINT = 0.45
# Symbol and its meaning where there is no best oil, by judgement.
_SYMBOL_OF_NO_CHOICE = {
    "no film": ("x", "no film thick enough"),
    OUTSIDE_FILM_FORMULA: ("+", "outside the film formula"),
    NO_EQUILIBRIUM: ("1", "an oil without equilibrium"),
}
# Symbol and its meaning where the advised oil is not the best one, by judgement.
_SYMBOL_OF_WRONG_ADVICE = {
    "slips": ("v", "the cage slips with it, not with the best"),
    "slips more": ("^", "the cage slips more with it"),
    "heats more": ("s", "it heats more"),
    "rule has none": ("D", "the paper's oils lack film"),
}
_NO_MAP = "The oils of selection.rules have no law or no film here:\nno map."


@declare_figure(like="torque", counterpart="Fig. 6")
def fig06(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction torque of the bearing."""
    return torque(results, settings)


@declare_figure(
    family="bearing",
    tables=("published_tests",),
    settings=("bearing",),
    requires="torque",
    shows_data=False,
)
def power_loss(results: CampaignTables, settings: Settings) -> Sheet:
    """Published power loss.

    Calculated power loss (W) by term, and published power loss, against speed of the inner
    ring. Flow of oil and its volume fraction, and with it the drag, are assumed. Dashed lines:
    sum of the terms at the ends of the fraction's range. No fraction fits both this test and the
    published cage slip. Published points: NASA TP-2275, transcribed by a third party. The traction
    law is fitted to the logs of this campaign.
    """
    tests = results.published_tests.dropna(subset="published_power_w")
    sheet = Sheet(height=2.0)
    panel = sheet.panel(title=None)
    sheet.label_axes(style.SPEED_LABEL, "Power loss (W)")
    if tests.empty:
        panel.write_message(
            "The published test's oil is not fitted,\nor its bearing not described."
        )
        return sheet
    bearing_name, oil, load_n, temperature_c = tests.iloc[0][
        ["bearing", "oil", "axial_load_n", "inlet_temperature_c"]
    ]
    speed_rad_s = tests["inner_speed_rpm"] * RAD_S_PER_RPM
    # feed oil of unknown flow adds nothing
    power_of_terms = [tests[f"{term}_torque_n_m"].fillna(0.0) * speed_rad_s for term in HEAT_TERMS]
    speed_1000_rpm = tests["inner_speed_rpm"] / 1e3
    colour_of_terms = colormaps["cividis"](np.linspace(0, 1, len(HEAT_TERMS)))
    areas = panel.axes.stackplot(
        speed_1000_rpm,
        power_of_terms,
        labels=HEAT_TERMS,
        colors=colour_of_terms,
        edgecolor="white",
        linewidth=0.3,
    )
    lowest_fraction, highest_fraction = settings.bearing.oil_volume_fraction_range
    dashed: style.Look = {"linestyle": "--", "color": "black"}
    for column in ("power_low_w", "power_high_w"):
        panel.axes.plot(speed_1000_rpm, tests[column], **dashed)
    # not in the colour of an oil; the rim shows it on dark areas
    dot_look: style.Look = {"marker": "o", "color": "black", "markeredgecolor": "white"}
    dot_look["markersize"] = 4
    for term, power in zip(HEAT_TERMS, power_of_terms, strict=True):
        panel.record(term, speed_1000_rpm, power, oil=oil)
    power_interval = {"lower": tests["power_low_w"], "upper": tests["power_high_w"]}
    panel.record("sum", speed_1000_rpm, tests["power_w"], oil=oil, **power_interval)
    panel.dots("published", speed_1000_rpm, tests["published_power_w"], dot_look)
    panel.axes.set_axisbelow(True)
    panel.axes.set_title(
        f"{bearing_name}, {oil}, {load_n:g} N, {temperature_c:.0f} \N{DEGREE SIGN}C"
    )
    published_handle = style.line_handle("published", **dot_look | {"linestyle": ""})
    handles = [
        *areas,
        style.line_handle(f"oil {lowest_fraction:.2%} and {highest_fraction:.2%}", **dashed),
        published_handle,
    ]
    origin_of_logs = SIMULATED if settings.campaign.data == "simulated" else "this campaign's"
    fraction_text = f"{settings.bearing.oil_volume_fraction:.2%} of the volume"
    sheet.legend(handles, f"oil {fraction_text}; traction law from {origin_of_logs} logs")
    return sheet


@declare_figure(
    family="bearing",
    tables=("slip_advice", "cage_slip"),
    settings=("oils", "bearing", "gates", "studies"),
    requires="torque",
)
def slip_advice(results: CampaignTables, settings: Settings) -> Sheet:
    """Choice of oil by cage slip.

    (a) Best of the oils that the rules of the paper name, by the friction equilibrium with the
    fitted law. Of the oils that hold the cage it has the least torque; if none holds it, it has the
    least slip. Dots: it is the best of all oils of the campaign in at least 95 % of the draws of
    all uncertain inputs. Rings: the best oil by the true traction of a simulated campaign is
    another one. White: no oil is best, or the best one is not known. (b) Oil that the rules of the
    paper advise, with its cage slip at friction equilibrium. Symbols: the advised oil is neither
    the best one nor nearly as good, and why. White: none is advised, or the choice is not known.
    Abscissa: dmN, pitch diameter times speed (million mm rpm). Ordinate: axial load (kN).
    """
    advice, oils = results.slip_advice, list(settings.oils)
    if advice.empty:
        return text_figure(_NO_MAP)
    advice = advice.assign(**axis_columns(advice))
    sheet = Sheet(2, 2, height=2.2, across=0.3, sharex=True, sharey=True)
    sheet.axes_of_panels[0].set_yscale("log")
    sheet.axes_of_panels[0].yaxis.set_major_formatter("{x:g}")
    best_panel = sheet.panel(0, "best of the rules' oils")
    advised_panel = sheet.panel(1, "oil that the paper advises")
    judgement = advice["judgement"]
    is_decided = ~judgement.isin(JUDGEMENTS_WITHOUT_CHOICE)
    selection = study_settings(settings).selection
    is_best_known = has_known_best_oil(
        advice, results.cage_slip, selection, settings.gates.lambda_limit
    )
    _draw_oils(best_panel, advice, "best_oil", is_best_known, oils)
    _draw_oils(advised_panel, advice, "advised_oil", is_decided, oils)
    handles: list[Any] = [
        Patch(facecolor=style.tint(style.oil_colour(oil, oils), _FIELD_TINT), label=oil)
        for oil in oils
    ]
    handles += _draw_certain_best(best_panel, advice[is_best_known], results.cage_slip)
    handles += _draw_wrong_by_truth(best_panel, advice)
    handles += _draw_judgements(advised_panel, advice)
    handles += _draw_undecided(best_panel, advice[~is_best_known])
    handles += _draw_undecided(advised_panel, advice)
    sheet.label_axes(style.DMN_LABEL, style.AXIAL_LOAD_LABEL)
    labels = judgement + ", best " + advice["best_oil"].replace("", "none")
    advised_panel.record(
        "advised oil", advice["dmn"], advice["load_kn"], oil=advice["advised_oil"], label=labels
    )
    temperature_c = settings.bearing.cage_slip.inlet_temperature_c
    title = f"{advice['bearing'].iloc[0]}, oil at {temperature_c:g} \N{DEGREE SIGN}C"
    handle_by_label = {handle.get_label(): handle for handle in handles}
    sheet.legend(list(handle_by_label.values()), f"{title}; {style.DMN_AS_SPEED}")
    return sheet


def is_wrong_by_truth(advice: pd.DataFrame) -> "pd.Series[bool]":
    """Whether the best oil by the fitted law is not the best by the true traction, at each point.

    False where either of them is not known, and where mu was measured.

    Args:
        advice: Table of advice.
    """
    is_known = ~advice["judgement"].isin(JUDGEMENTS_WITHOUT_CHOICE) & (
        advice["true_judgement"] != ""
    )
    is_known &= ~advice["true_judgement"].isin(JUDGEMENTS_WITHOUT_CHOICE)
    return is_known & (advice["true_best_oil"] != advice["best_oil"])


def _draw_oils(
    panel: Panel, advice: pd.DataFrame, column: str, is_decided: "pd.Series[bool]", oils: list[str]
) -> None:
    """Draw each cell in the colour of the oil in a column; white where nothing is decided."""
    oil_of_cell = advice[column].where(is_decided, "")
    with_index = advice.assign(number=oil_of_cell.map(["", *oils].index))
    index_by_cell = with_index.pivot(index="load_kn", columns="dmn", values="number")
    axes = panel.axes
    tints = [style.tint(style.oil_colour(oil, oils), _FIELD_TINT) for oil in oils]
    axes.pcolormesh(
        style.cell_edges(index_by_cell.columns.to_numpy(), axes.get_xscale()),
        style.cell_edges(index_by_cell.index.to_numpy(), axes.get_yscale()),
        index_by_cell.to_numpy(),
        cmap=ListedColormap([(1.0, 1.0, 1.0), *tints]),
        vmin=-0.5,
        vmax=len(oils) + 0.5,
        rasterized=True,
    )
    axes.grid(False)


def _draw_certain_best(panel: Panel, advice: pd.DataFrame, cage_slip: pd.DataFrame) -> list[Any]:
    """Draw dots where the best oil stays best in nearly all draws; return entries of the legend.

    Args:
        panel: The panel.
        advice: Rows of the table of advice with a known best oil.
        cage_slip: Table of cage slip.
    """
    certain_rows = cage_slip[is_best_in_share(cage_slip, STAYS_BEST_SHARE)]
    certain_oils = certain_rows[[*OPERATING_POINT_COLUMNS, "oil"]].rename(
        columns={"oil": "best_oil"}
    )
    sure_rows = advice.merge(certain_oils, on=[*OPERATING_POINT_COLUMNS, "best_oil"])
    look: style.Look = {"marker": "o", "markersize": 2.5, "color": "black"}
    oils = sure_rows["best_oil"]
    panel.dots(
        "stays best", sure_rows["dmn"], sure_rows["load_kn"], look, oil=oils, label="stays best"
    )
    label = f"best in at least {100 * STAYS_BEST_SHARE:.0f} % of the draws"
    return [style.line_handle(label, linestyle="", **look)] if len(sure_rows) else []


def _draw_wrong_by_truth(panel: Panel, advice: pd.DataFrame) -> list[Any]:
    """Draw rings where the truth has another best oil; return entries of the legend."""
    wrong_rows = advice[is_wrong_by_truth(advice)]
    panel.record("wrong by truth", wrong_rows["dmn"], wrong_rows["load_kn"])
    if wrong_rows.empty:
        return []
    ring: style.Look = {"color": "black", "markerfacecolor": "none", "markeredgewidth": 0.8}
    panel.axes.plot(wrong_rows["dmn"], wrong_rows["load_kn"], "o", markersize=6.5, **ring)
    return [style.symbol_handle("another best oil by the truth", "o", markersize=5, **ring)]


def _draw_judgements(panel: Panel, advice: pd.DataFrame) -> list[Any]:
    """Draw symbols where the advised oil is not the best; return entries of the legend."""
    handles = []
    for judgement, (marker, label) in _SYMBOL_OF_WRONG_ADVICE.items():
        cells = advice[advice["judgement"] == judgement]
        if len(cells):
            look: style.Look = {"marker": marker, "color": "black", "markersize": 3.5}
            panel.axes.plot(cells["dmn"], cells["load_kn"], linestyle="", **look)
            handles.append(style.line_handle(label, linestyle="", **look))
    return handles


def _draw_undecided(panel: Panel, advice: pd.DataFrame) -> list[Any]:
    """Draw symbols where there is no choice of an oil; return entries of the legend."""
    handles = []
    for judgement, (marker, label) in _SYMBOL_OF_NO_CHOICE.items():
        cells = advice[advice["judgement"] == judgement]
        if len(cells):
            # a cross of thin lines must be larger than a filled symbol
            look: style.Look = {"color": style.GREY, "markersize": 5}
            panel.axes.plot(cells["dmn"], cells["load_kn"], marker, **look)
            handles.append(style.symbol_handle(label, marker, color=style.GREY, markersize=3.5))
    return handles
