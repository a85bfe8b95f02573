"""Fig. 6 of the paper, the power loss of a published test, and the oil that its rules advise."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from deng2026_study.advice import NO_CHOICE, NO_EQUILIBRIUM, OUTSIDE
from oilfilm.base.units import RAD_S_PER_RPM
from oilfilm.bearing.resistance import HEATS
from oilfilm.report.figures import style
from oilfilm.report.figures.bearing import in_units_of_axes, torque
from oilfilm.report.figures.sheet import SIMULATED, Panel, Sheet, register, sentences
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# Share of an oil's colour in its field.
_FIELD_TINT = 0.45
# Where there is no best oil: symbol and its meaning, by judgement.
_NO_CHOICE = {
    "no film": ("x", "no film thick enough"),
    OUTSIDE: ("+", "outside the film formula"),
    NO_EQUILIBRIUM: ("1", "an oil without equilibrium"),
}
_NO_MAP = "The oils of selection.rules have no law or no film here:\nno map."


@register(like="torque", counterpart="Fig. 6")
def fig06(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction torque of the bearing."""
    return torque(results, settings)


@register(
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
    ends of the fraction's range; none fits this test and the published cage slip, too. Published
    points: NASA TP-2275, transcribed by a third party. The traction law is fitted to the logs of
    this campaign.
    """
    table = results.published_tests.dropna(subset="published_power_w")
    sheet = Sheet(height=2.0)
    panel = sheet.panel(title=None)
    sheet.label(style.SPEED_LABEL, "Power loss (W)")
    if table.empty:
        panel.say("The published test's oil is not fitted,\nor its bearing not described.")
        return sheet
    bearing, oil, load, temperature = table.iloc[0][
        ["bearing", "oil", "axial_load_n", "inlet_temperature_c"]
    ]
    turning = table["inner_speed_rpm"] * RAD_S_PER_RPM
    # feed oil of unknown flow adds nothing
    watts = [table[f"{term}_torque_n_m"].fillna(0.0) * turning for term in HEATS]
    speed = table["inner_speed_rpm"] / 1e3
    shades = colormaps["cividis"](np.linspace(0, 1, len(HEATS)))
    areas = panel.axis.stackplot(
        speed, watts, labels=HEATS, colors=shades, edgecolor="white", linewidth=0.3
    )
    low, high = settings.bearing.oil_volume_fraction_range
    dashed: style.Look = {"linestyle": "--", "color": "black"}
    for end in ("power_low_w", "power_high_w"):
        panel.axis.plot(speed, table[end], **dashed)
    # not in the colour of an oil; the rim shows it on dark areas
    dots: style.Look = {"marker": "o", "color": "black", "markeredgecolor": "white"}
    dots["markersize"] = 4
    for term, power in zip(HEATS, watts, strict=True):
        panel.keep(term, speed, power, oil=oil)
    ends = {"lower": table["power_low_w"], "upper": table["power_high_w"]}
    panel.keep("sum", speed, table["power_w"], oil=oil, **ends)
    panel.dots("published", speed, table["published_power_w"], dots)
    panel.axis.set_axisbelow(True)
    panel.axis.set_title(f"{bearing}, {oil}, {load:g} N, {temperature:.0f} \N{DEGREE SIGN}C")
    published = style.line_handle("published", **dots | {"linestyle": ""})
    handles = [*areas, style.line_handle(f"oil {low:.2%} and {high:.2%}", **dashed), published]
    logs = SIMULATED if settings.campaign.data == "simulated" else "this campaign's"
    share = f"{settings.bearing.oil_volume_fraction:.2%} of the volume"
    sheet.legend(handles, f"oil {share}; traction law from {logs} logs")
    return sheet


@register(
    family="bearing", tables=("slip_advice",), settings=("oils", "bearing"), requires="torque"
)
def slip_advice(results: CampaignTables, settings: Settings) -> Sheet:
    """Choice of oil by cage slip.

    Oil that the rules of the paper advise (colour), with its cage slip at friction equilibrium.
    Symbols: best oil, where it is another one. The best oil has the least torque of the oils
    that hold the cage; if none holds it, the least slip. All of this is by the fitted law. Rings:
    the best oil by the true traction of a simulated campaign is another one. Abscissa: dmN, pitch
    diameter times speed (million mm rpm). Ordinate: axial load (kN).
    """
    advice, oils = results.slip_advice, list(settings.oils)
    if advice.empty:
        return sentences(_NO_MAP)
    sheet = Sheet(height=2.2, top=0.06)
    panel = sheet.panel(title=None)
    panel.axis.set_yscale("log")
    panel.axis.yaxis.set_major_formatter("{x:g}")
    sheet.label(style.DMN_LABEL, style.AXIAL_LOAD_LABEL)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    title = f"{advice['bearing'].iloc[0]}, oil at {temperature:g} \N{DEGREE SIGN}C"
    handles = _draw(panel, advice.assign(**in_units_of_axes(advice)), oils)
    sheet.legend(handles, f"{title};\n{style.DMN_AS_SPEED}")
    return sheet


def is_wrong_by_truth(advice: pd.DataFrame) -> "pd.Series[bool]":
    """Operating points whose best oil by the fitted law is not that by the true traction.

    False where either of them is not known, and where mu was measured.

    Args:
        advice: Table of advice.
    """
    is_known = ~advice["judgement"].isin(NO_CHOICE) & (advice["true_judgement"] != "")
    is_known &= ~advice["true_judgement"].isin(NO_CHOICE)
    return is_known & (advice["true_best_oil"] != advice["best_oil"])


def _draw(panel: Panel, advice: pd.DataFrame, oils: list[str]) -> list[Any]:
    """Fields in the colour of the advised oil, symbols of the best oil; entries of the legend.

    Args:
        panel: Its scales are set already.
        advice: Columns `advised_oil`, `best_oil` and `judgement`, one row per cell.
        oils: Oils of the campaign, which fix the colours.
    """
    axis, x, y, judgement = panel.axis, "speed", "load_kn", advice["judgement"]
    # white: no oil is advised, or the choice depends on something that is not known
    advised = advice["advised_oil"].mask(judgement.isin(NO_CHOICE), "")
    field = advice.assign(number=advised.map(["", *oils].index)).pivot(index=y, columns=x)["number"]
    fields = [style.tint(style.oil_colour(oil, oils), _FIELD_TINT) for oil in oils]
    axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(), axis.get_xscale()),
        style.cell_edges(field.index.to_numpy(), axis.get_yscale()),
        field.to_numpy(),
        cmap=ListedColormap([(1.0, 1.0, 1.0), *fields]),
        vmin=-0.5,
        vmax=len(oils) + 0.5,
        rasterized=True,
    )
    handles: list[Any] = []
    for oil, tint in zip(oils, fields, strict=True):
        if oil in set(advice["advised_oil"]):
            handles.append(Patch(facecolor=tint, label=f"paper advises {oil}"))
        # where the best oil is known and another one than the advised oil
        other = advice[(advice["best_oil"] == oil) & ~judgement.isin(("agree", *NO_CHOICE))]
        look: style.Look = {"linestyle": "", "markersize": 3.5, **style.oil_look(oil, oils)}
        if len(other):
            axis.plot(other[x], other[y], **look)
            handles.append(style.line_handle(f"best oil: {oil}", **look))
    if (judgement == "rule has none").any():
        look = {"facecolor": "white", "edgecolor": style.GREY, "linewidth": 0.6}
        handles.append(Patch(label="paper's oils lack film", **look))
    for name, (marker, label) in _NO_CHOICE.items():
        without_choice = advice[judgement == name]
        if len(without_choice):
            # a cross of thin lines must be larger than a filled symbol
            axis.plot(without_choice[x], without_choice[y], marker, color=style.GREY, markersize=5)
            handles.append(style.symbol_handle(label, marker, color=style.GREY, markersize=3.5))
    is_wrong = is_wrong_by_truth(advice)
    if is_wrong.any():
        ring: style.Look = {"color": "black", "markerfacecolor": "none", "markeredgewidth": 0.8}
        axis.plot(advice.loc[is_wrong, x], advice.loc[is_wrong, y], "o", markersize=6.5, **ring)
        handles.append(
            style.symbol_handle("another best oil by the truth", "o", markersize=5, **ring)
        )
    panel.keep("wrong by truth", advice.loc[is_wrong, x], advice.loc[is_wrong, y])
    axis.grid(False)
    labels = judgement + ", best " + advice["best_oil"].replace("", "none")
    panel.keep("advised oil", advice[x], advice[y], oil=advice["advised_oil"], label=labels)
    return handles
