"""Maps of the oil that the paper's rules advise, and of the best oil where it is another one."""

import itertools
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from oilfilm.bearing.kinematics import pitch_speed_mm_rpm
from oilfilm.paper.selection import OUTSIDE
from oilfilm.report.figures import style
from oilfilm.report.figures.bearing import in_units_of_axes
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Panel, Sheet, sentences
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_SPEED, _PRESSURE = "entrainment_speed_m_s", "max_hertz_pressure_gpa"
_PANEL = ["inlet_temperature_c", "slide_roll_ratio"]
_TICKS = {_SPEED: (20, 50, 100, 200), _PRESSURE: (0.8, 1.0, 1.5, 2.0, 2.5)}
_FRAME: style.Look = {"fill": False, "edgecolor": "black"}
_FIELD = 0.45  # share of an oil's colour in its field
# Where there is no best oil: symbol and its meaning, by judgement.
_NO_CHOICE = {
    "no film": ("x", "no film thick enough"),
    OUTSIDE: ("+", "outside the film formula"),
}
_NO_MAP = "The oils of selection.rules have no law or no film here:\nno map."


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
def slip_advice(results: CampaignTables, settings: Settings) -> Sheet:
    """Advised and best oil against speed and axial load."""
    advice, oils = results.slip_advice, list(settings.oils)
    if advice.empty:
        return sentences(_NO_MAP)
    sheet = Sheet(height=2.2, top=0.06)
    panel = sheet.panel(title=None)
    panel.axis.set_yscale("log")
    panel.axis.yaxis.set_major_formatter("{x:g}")
    _draw(panel, advice.assign(**in_units_of_axes(advice)), oils, ("speed", "load_kn"), 3.5)
    sheet.label(style.DMN_LABEL, style.AXIAL_LOAD_LABEL)
    temperature = settings.bearing.cage_slip.inlet_temperature_c
    title = f"{advice['bearing'].iloc[0]}, oil at {temperature:g} \N{DEGREE SIGN}C"
    sheet.legend(_handles(advice, oils), f"{title};\n{style.DMN_AS_SPEED}")
    return sheet


@register(
    name="selection",
    title="Choice of oil",
    caption="Oil that the rules of the paper advise (colour), against entrainment speed (m/s) "
    "and maximum Hertz pressure (GPa). Symbols: best oil by traction and film thickness of the "
    "traction rig's contact, where it is another one; properties of the oils may be stand-ins. "
    "Cage slip: the slip that corresponds to the slide-roll ratio. dmN: pitch diameter times speed "
    "(mm rpm) of a bearing with this entrainment speed. Outside the film formula: the choice "
    "depends on a film beyond the range of the thermal reduction.",
    category="Claims",
    family="bearing",
    tables=("selection",),
    settings=("oils", "printed"),
)
def selection_map(results: CampaignTables, settings: Settings) -> Sheet:
    """One row of panels per temperature, one column per slip; cells of speed and pressure.

    The refit is drawn, the printed constants where the campaign has no fit of these oils.
    """
    if results.selection.empty:
        return sentences(_NO_MAP)
    basis = results.selection["basis"].iloc[0]
    table = results.selection[results.selection["basis"] == basis]
    oils = list(settings.oils)
    temperatures, slips = (sorted(table[name].unique()) for name in _PANEL)
    layout: style.Look = {"height": 1.35, "sharex": True, "sharey": True}
    count = len(temperatures) * len(slips)
    sheet = Sheet(count, len(slips), width=style.DOUBLE_COLUMN_IN, **layout)
    box = settings.printed.boxes.tested
    for number, at in enumerate(itertools.product(temperatures, slips)):
        levels = dict(zip(_PANEL, at, strict=True))
        of_panel = table[(table[_PANEL] == list(at)).all(axis=1)]
        title = f"{style.level_phrases(levels)}, cage slip {of_panel['cage_slip'].iloc[0]:.0%}"
        panel = sheet.panel(number, title, fontsize=6.5)
        panel.axis.set(xscale="log", yscale="log")
        _draw(panel, of_panel, oils, (_SPEED, _PRESSURE), 2.2)
        if all(np.clip(level, *getattr(box, name)) == level for name, level in levels.items()):
            (left, right), (low, high) = box.entrainment_speed_m_s, box.max_hertz_pressure_gpa
            frame = Rectangle((left, low), right - left, high - low, linewidth=0.9, **_FRAME)
            panel.axis.add_patch(frame)
    for side, name in ((sheet.axes[0].xaxis, _SPEED), (sheet.axes[0].yaxis, _PRESSURE)):
        least, most = table[name].min(), table[name].max() * 1.001
        side.set_major_locator(FixedLocator([t for t in _TICKS[name] if least <= t <= most]))
        side.set_major_formatter("{x:g}")
        side.set_minor_locator(NullLocator())
        side.set_minor_formatter(NullFormatter())
    sheet.label("U (m/s)", "P (GPa)")
    dmn = f"100 m/s is dmN {pitch_speed_mm_rpm(100) / 1e6:.1f}e6 mm rpm"
    handles = [*_handles(table, oils), Rectangle((0, 0), 1, 1, label="tested", **_FRAME)]
    sheet.legend(handles, f"constants: {basis}; {dmn}")
    return sheet


def _draw(
    panel: Panel, advice: pd.DataFrame, oils: list[str], columns: tuple[str, str], markersize: float
) -> None:
    """Fields in the colour of the advised oil, and symbols of the best oil.

    Args:
        panel: Its scales are set already.
        advice: Columns `advised_oil`, `best_oil` and `judgement`, one row per cell.
        oils: Oils of the campaign, which fix the colours.
        columns: Columns along the abscissa and the ordinate.
        markersize: Of the symbols, in points.
    """
    axis, (x, y) = panel.axis, columns
    outside = advice["judgement"] == OUTSIDE
    # white: no oil is advised, or the choice depends on a film that is not known
    shown = advice.assign(number=advice["advised_oil"].mask(outside, "").map(["", *oils].index))
    field = shown.pivot(index=y, columns=x, values="number")
    fields = [style.tint(style.oil_colour(oil, oils), _FIELD) for oil in oils]
    axis.pcolormesh(
        style.cell_edges(field.columns.to_numpy(), axis.get_xscale()),
        style.cell_edges(field.index.to_numpy(), axis.get_yscale()),
        field.to_numpy(),
        cmap=ListedColormap([(1.0, 1.0, 1.0), *fields]),
        vmin=-0.5,
        vmax=len(oils) + 0.5,
        rasterized=True,
    )
    differs = (advice["judgement"] != "agree") & ~outside
    for oil in oils:
        other = advice[(advice["best_oil"] == oil) & differs]
        look: style.Look = {"linestyle": "", "markersize": markersize, **style.oil_look(oil, oils)}
        axis.plot(other[x], other[y], **look)
    for judgement, (marker, _) in _NO_CHOICE.items():
        here = advice[advice["judgement"] == judgement]
        # a cross of thin lines needs more room than a filled symbol
        axis.plot(here[x], here[y], marker, color=style.GREY, markersize=1.5 * markersize)
    axis.grid(False)
    label = advice["judgement"] + ", best " + advice["best_oil"].replace("", "none")
    panel.keep("advised oil", advice[x], advice[y], oil=advice["advised_oil"], label=label)


def _handles(advice: pd.DataFrame, oils: list[str]) -> list[Any]:
    """Entries of the legend."""
    handles: list[Any] = []
    for oil in oils:
        if oil in {*advice["advised_oil"], *advice["best_oil"]}:
            tint = style.tint(style.oil_colour(oil, oils), _FIELD)
            handles += [
                Patch(facecolor=tint, label=f"paper advises {oil}"),
                style.line_handle(
                    f"best oil: {oil}", linestyle="", markersize=3.5, **style.oil_look(oil, oils)
                ),
            ]
    if (advice["judgement"] == "rule has none").any():
        look: style.Look = {"facecolor": "white", "edgecolor": style.GREY, "linewidth": 0.6}
        handles.append(Patch(label="paper's oils lack film", **look))
    return handles + [
        style.symbol_handle(label, marker, color=style.GREY, markersize=3.5)
        for judgement, (marker, label) in _NO_CHOICE.items()
        if (advice["judgement"] == judgement).any()
    ]
