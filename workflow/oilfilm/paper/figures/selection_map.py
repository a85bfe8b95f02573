"""The map of oils: what the paper's rules advise, and where the numbers prefer another oil."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from oilfilm.bearing.kinematics import pitch_speed_mm_rpm
from oilfilm.paper.figures.advice_map import advice_handles, advice_marks, draw_advice
from oilfilm.report.captions import stand_in_oils
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_SPEED, _PRESSURE = "entrainment_speed_m_s", "max_hertz_pressure_gpa"
_PANEL = ["inlet_temperature_c", "slide_roll_ratio"]
_FRAME: dict[str, Any] = {"fill": False, "edgecolor": "black"}


@register(
    name="selection",
    title="Choice of oil",
    caption="Oil that the rules of the paper advise (colour), against entrainment speed (m/s) "
    "and maximum Hertz pressure (GPa). Symbols: best oil by traction and film thickness, where "
    "it is another one. Cage slip: the slip that corresponds to the slide-roll ratio. dmN: pitch "
    "diameter times speed (mm rpm) of a bearing with this entrainment speed. Outside the film "
    "formula: the choice depends on a film beyond the range of the thermal reduction.",
    category="Claims",
    family="bearing",
    tables=("selection",),
    settings=("oils", "printed"),
)
def selection_map(results: CampaignTables, settings: Settings) -> Drawing:
    """One row of panels per temperature, one column per slip; cells of speed and pressure.

    The refit is drawn, the printed constants where the campaign has no fit of these oils.
    """
    table = results.selection
    if table.empty:
        return style.sentences(
            "The oils of selection.rules have no law or no film here:\nno map."
        ), []
    basis = table["basis"].iloc[0]
    table = table[table["basis"] == basis]
    oils = list(settings.oils)
    temperatures, slips = (sorted(table[name].unique()) for name in _PANEL)
    figure, axes = style.panels(
        len(temperatures), len(slips), style.DOUBLE_COLUMN_IN, 1.75 * len(temperatures) + 0.4
    )
    drawn = []
    for number, axis in enumerate(axes):
        temperature, slip = temperatures[number // len(slips)], slips[number % len(slips)]
        of_panel = table[(table[_PANEL[0]] == temperature) & (table[_PANEL[1]] == slip)]
        levels = dict(zip(_PANEL, (temperature, slip), strict=True))
        title = f"{style.level_phrases(levels)}, cage slip {of_panel['cage_slip'].iloc[0]:.0%}"
        panel = style.title_panel(axis, number, title, fontsize=6.5)
        axis.set(xscale="log", yscale="log")
        draw_advice(axis, of_panel, oils, _SPEED, _PRESSURE, 2.2)
        box = settings.printed.boxes.tested
        if all(np.clip(level, *getattr(box, name)) == level for name, level in levels.items()):
            (left, right), (low, high) = box.entrainment_speed_m_s, box.max_hertz_pressure_gpa
            frame = Rectangle((left, low), right - left, high - low, linewidth=0.9, **_FRAME)
            axis.add_patch(frame)
        drawn.append(advice_marks(panel, of_panel, _SPEED, _PRESSURE))
    _label(figure, axes[0], axes[-len(slips) :], table)
    tested = Rectangle((0, 0), 1, 1, label="tested", **_FRAME)
    handles = [*advice_handles(table, oils, "best by traction"), tested]
    columns: dict[str, Any] = {"ncols": (len(handles) + 1) // 2, "columnspacing": 1.0}
    figure.legend(handles=handles, loc="outside lower left", **columns)
    films = ", of STAND-IN oils" if stand_in_oils(settings.oils) else ""
    style.say_key(figure, f"Constants: {basis}. Film: of the traction rig's contact{films}")
    return figure, drawn


def _label(figure: Figure, axis: Axes, bottom: Sequence[Axes], table: pd.DataFrame) -> None:
    for side, name, ticks in (
        (axis.xaxis, _SPEED, (20, 50, 100, 200)),
        (axis.yaxis, _PRESSURE, (0.8, 1.0, 1.5, 2.0, 2.5)),
    ):
        inside = [tick for tick in ticks if table[name].min() <= tick <= table[name].max() * 1.001]
        side.set_major_locator(FixedLocator(inside))
        side.set_major_formatter("{x:g}")
        side.set_minor_locator(NullLocator())
        side.set_minor_formatter(NullFormatter())
    # not of the figure as a whole, which would cover the key
    label = (
        f"Entrainment speed U (m/s); 100 m/s is dmN {pitch_speed_mm_rpm(100) / 1e6:.1f}e6 mm rpm"
    )
    bottom[len(bottom) // 2].set_xlabel(label)
    figure.supylabel("Maximum Hertz pressure P (GPa)", fontsize=8)
