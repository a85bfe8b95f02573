"""The paper's choice of oil by cage slip, and the power loss of a published test."""

from typing import Any

import numpy as np
from matplotlib import colormaps

from oilfilm.bearing.friction import HEATS
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.paper.figures.advice_map import advice_handles, advice_marks, draw_advice
from oilfilm.report.figures import style
from oilfilm.report.figures.bearing import in_units_of_axes
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.units import RAD_S_PER_RPM


@register(
    name="slip-advice",
    title="Choice of oil by cage slip",
    caption="Oil that the rules of the paper advise (colour), with its cage slip at friction "
    "equilibrium. Symbols: best oil, where it is another one. The best oil has the least torque of "
    "the oils that hold the cage; if none holds it, the least slip. Abscissa: dmN, pitch diameter "
    "times speed (million mm rpm). Ordinate: axial load (kN).",
    category="Bearing",
    family="bearing",
    tables=("slip_advice",),
    settings=("oils", "bearing"),
    requires="torque",
)
def slip_advice(results: CampaignTables, settings: Settings) -> Drawing:
    """Advised and best oil against speed and axial load."""
    advice, oils = results.slip_advice, list(settings.oils)
    if advice.empty:
        return style.sentences("The oils of selection.rules have no law here:\nno map."), []
    figure, (axis,) = style.panels(1, 1, style.SINGLE_COLUMN_IN, 2.9)
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter("{x:g}")
    in_units = advice.assign(**in_units_of_axes(advice))
    draw_advice(axis, in_units, oils, "speed", "load", 3.5)
    axis.set_xlabel(f"dmN (million mm rpm; 1 is U = {entrainment_speed_m_s(1e6):.0f} m/s)")
    axis.set_ylabel("Axial load (kN)")
    handles = advice_handles(advice, oils, "best oil")
    figure.legend(handles=handles, loc="outside lower left", ncols=2)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    bearing = advice["bearing"].iloc[0]
    style.say_key(figure, f"Friction equilibrium, {bearing}, {temperature:g} \N{DEGREE SIGN}C")
    return figure, [advice_marks("", in_units, "speed", "load")]


@register(
    name="power-loss",
    title="Published power loss",
    caption="Calculated power loss (W) by term, and published power loss, against speed of "
    "the inner ring. The volume fraction of oil, and with it the drag, is fitted to the "
    "published points. Dashed lines: ends of its range. Published points: NASA TP-2275, "
    "transcribed by a third party.",
    category="Bearing",
    family="bearing",
    tables=("published_tests",),
    settings=("bearing",),
    requires="torque",
    shows_data=False,
)
def power_loss(results: CampaignTables, settings: Settings) -> Drawing:
    """Calculated power loss term by term beside a published one, to which the drag is fitted."""
    table = results.published_tests.dropna(subset="published_power_w")
    figure, (axis,) = style.panels(1, 1, style.SINGLE_COLUMN_IN, 2.8)
    axis.set_xlabel("Speed of the inner ring (1000 rpm)")
    axis.set_ylabel("Power loss (W)")
    if table.empty:
        style.say_in_panel(
            axis, "The published test's oil is not fitted,\nor its bearing not described."
        )
        return figure, []
    turning = table["inner_speed_rpm"] * RAD_S_PER_RPM
    watts = [table[f"{term}_torque_n_m"] * turning for term in HEATS]
    speed = table["inner_speed_rpm"] / 1e3
    shades = colormaps["cividis"](np.linspace(0, 1, len(HEATS)))
    axis.stackplot(speed, watts, labels=HEATS, colors=shades, edgecolor="white", linewidth=0.3)
    low, high = settings.bearing.oil_volume_fraction_range
    axis.plot(
        speed,
        table[["power_low_w", "power_high_w"]],
        linestyle="--",
        color="black",
        label=[f"oil {low:.2%} and {high:.2%}", None],
    )
    # not in the colour of an oil; the rim shows it on dark areas
    rim: dict[str, Any] = {"markeredgecolor": "white", "markersize": 4}
    axis.plot(speed, table["published_power_w"], "o", color="black", label="published", **rim)
    axis.set_axisbelow(True)
    # from the top, in the order of the areas
    axis.legend(loc="upper left", reverse=True)
    share = settings.bearing.oil_volume_fraction
    simulated = settings.campaign.data == "simulated"
    logs = "SIMULATED logs" if simulated else "this campaign's logs"
    style.say_key(
        figure,
        "Points: NASA TP-2275, published, second-hand.\n"
        f"Areas: calculated, oil {share:.2%} of the volume (fitted to the points);\n"
        f"traction law fitted to {logs}.",
    )
    bearing, oil, load, temperature = table.loc[
        table.index[0], ["bearing", "oil", "axial_load_n", "inlet_temperature_c"]
    ]
    axis.set_title(f"{bearing}, {oil}, {load:g} N, {temperature:.0f} \N{DEGREE SIGN}C")
    ends = {"lower": table["power_low_w"], "upper": table["power_high_w"]}
    drawn = [
        marks("", term, speed, power, oil=oil) for term, power in zip(HEATS, watts, strict=True)
    ]
    drawn.append(marks("", "sum", speed, table["power_w"], oil=oil, **ends))
    return figure, [*drawn, marks("", "published", speed, table["published_power_w"])]
