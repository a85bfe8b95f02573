"""Fig. 6 of the paper, and the power loss of a published test."""

import numpy as np
from matplotlib import colormaps

from oilfilm.bearing.friction import HEATS
from oilfilm.report.figures import style
from oilfilm.report.figures.bearing import torque
from oilfilm.report.figures.registry import SIMULATED, register
from oilfilm.report.figures.sheet import Sheet
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.units import RAD_S_PER_RPM


@register(like="torque", paper="Fig. 6", category="Paper")
def fig06(results: CampaignTables, settings: Settings) -> Sheet:
    """Friction torque of the bearing."""
    return torque(results, settings)


@register(
    category="Bearing",
    family="bearing",
    tables=("published_tests",),
    settings=("bearing",),
    requires="torque",
    shows_data=False,
)
def power_loss(results: CampaignTables, settings: Settings) -> Sheet:
    """Published power loss.

    Calculated power loss (W) by term, and published power loss, against speed of the inner
    ring. The volume fraction of oil, and with it the drag, is fitted to the published points.
    Dashed lines: ends of its range. Published points: NASA TP-2275, transcribed by a third
    party. The traction law is fitted to the logs of this campaign.
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
    watts = [table[f"{term}_torque_n_m"] * turning for term in HEATS]
    speed = table["inner_speed_rpm"] / 1e3
    shades = colormaps["cividis"](np.linspace(0, 1, len(HEATS)))
    areas = panel.axis.stackplot(
        speed, watts, labels=HEATS, colors=shades, edgecolor="white", linewidth=0.3
    )
    low, high = settings.bearing.oil_volume_fraction_range
    ends = [table["power_low_w"], table["power_high_w"]]
    dashed: style.Look = {"linestyle": "--", "color": "black"}
    for end in ends:
        panel.axis.plot(speed, end, **dashed)
    # not in the colour of an oil; the rim shows it on dark areas
    dots: style.Look = {"marker": "o", "color": "black", "markeredgecolor": "white"}
    dots["markersize"] = 4
    for term, power in zip(HEATS, watts, strict=True):
        panel.keep(term, speed, power, oil=oil)
    panel.keep("sum", speed, table["power_w"], oil=oil, lower=ends[0], upper=ends[1])
    panel.dots("published", speed, table["published_power_w"], dots)
    panel.axis.set_axisbelow(True)
    panel.axis.set_title(f"{bearing}, {oil}, {load:g} N, {temperature:.0f} \N{DEGREE SIGN}C")
    published = style.line_handle("published", **dots | {"linestyle": ""})
    range_label = f"oil {low:.2%} and {high:.2%}"
    handles = [*areas, style.line_handle(range_label, **dashed), published]
    logs = SIMULATED if settings.campaign.data == "simulated" else "this campaign's"
    share = f"{settings.bearing.oil_volume_fraction:.2%} of the volume"
    sheet.legend(handles, f"oil {share}, fitted; traction law from {logs} logs")
    return sheet
