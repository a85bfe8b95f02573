"""The two rigs, drawn by code from what the paper's text says of them (Figs 1 and 5)."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Patch, Rectangle

from oilfilm import tables
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import register
from oilfilm.report.figures.sheet import Sheet
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# What a part is -> its colour, and in words.
_KINDS: dict[str, tuple[Any, str]] = {
    "fixed": (style.tint("#555555", 0.30), "fixed or guided"),
    "turning": ("#ffffff", "turning"),
    "sensor": (style.tint("#E69F00", 0.65), "sensor"),
    "drive": (style.tint("#CC79A7", 0.45), "drive"),
    "oil": (style.tint("#56B4E9", 0.60), "oil"),
}
_EDGE: style.Look = {"edgecolor": "black", "linewidth": 0.6}


@register(paper="Fig. 1", family="data", settings=("rigs",), shows_data=False)
def fig01(results: CampaignTables, settings: Settings) -> Sheet:
    """Traction rig.

    (a) Ball-on-disc rig with drives and sensors. (b) The cradle turns about the vertical axis
    of the air spindle. It presses against the force sensor, which measures along the rolling
    direction. (c) Contact of ball and disc with the measured speeds, load and force. Schematic
    after the text of the paper, not to scale; configured dimensions in mm.
    """
    sheet = Sheet(4, 2, height=(1.55, 1.9), left=0.05, bottom=0.05, width_ratios=(1.15, 1))
    # the first panel is as tall as both others together
    grid = sheet.axes[0].get_gridspec()
    for axis in sheet.axes[::2]:
        axis.remove()
    sheet.axes = [sheet.figure.add_subplot(grid[:, 0]), *sheet.axes[1::2]]
    rig = next(iter(settings.rigs.values()))
    radii = {"disc": rig.disc_track_radius_m, "ball": rig.ball_track_radius_m}
    sizes = {
        name: "" if radius is None else f" = {1e3 * radius:.4g} mm"
        for name, radius in radii.items()
    }
    titles = ("Rig from the side", "Cradle from above", "Contact, along the ball's axis")
    return _draw(sheet, "fig01", titles, sizes)


@register(paper="Fig. 5", family="data", shows_data=False)
def fig05(results: CampaignTables, settings: Settings) -> Sheet:
    """Torque rig.

    Rig for the friction torque of a bearing: driven inner ring, pure axial load and under-race
    lubrication. The torque of the outer ring is measured. Schematic after the text of the
    paper, not to scale.
    """
    sheet = Sheet(width=style.DOUBLE_COLUMN_IN, left=0.05, top=0.05, bottom=0.05, height=2.3)
    return _draw(sheet, "fig05", [None], {})


def _draw(sheet: Sheet, name: str, titles: Sequence[str | None], sizes: Mapping[str, str]) -> Sheet:
    """Draw the parts that a file lists, later ones above, and the key.

    A circle has its radius as `to_x`. Words are at (x, y), with a line to the part at (to_x, to_y)
    unless that is the same point. Each mark is two rows of what is drawn, its start and its end.

    Args:
        sheet: With the panels.
        name: The file `<name>.csv` beside this module.
        titles: Of the panels.
        sizes: What stands for the names in braces.
    """
    parts = pd.read_csv(Path(__file__).with_name(f"{name}.csv"), keep_default_na=False)
    labels = [label.format_map(sizes).replace("\\n", "\n") for label in parts["words"]]
    panels = [sheet.panel(number, title) for number, title in enumerate(titles)]
    for part in tables.rows(parts.assign(words=labels)):
        _draw_mark(sheet.axes["abc".index(part["panel"])], part)
    for axis in sheet.axes:
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_anchor("N")
    sheet.legend(
        [Patch(facecolor=colour, label=label, **_EDGE) for colour, label in _KINDS.values()]
    )
    series = (parts["mark"] + " " + parts["kind"]).str.strip().repeat(2)
    x, y = (parts[[name, f"to_{name}"]].to_numpy().ravel() for name in "xy")
    panels[0].keep(series, x, y, label=np.repeat(labels, 2), panel=parts["panel"].repeat(2))
    return sheet


def _draw_mark(axis: Axes, part: Mapping[str, Any]) -> None:
    start, end, kind = (part["x"], part["y"]), (part["to_x"], part["to_y"]), part["kind"]
    width, height = end[0] - start[0], end[1] - start[1]
    colour, _ = _KINDS.get(kind, ("black", ""))
    oil = kind == "oil"
    match part["mark"]:
        case "box":
            axis.add_patch(Rectangle(start, width, height, facecolor=colour, **_EDGE))
        case "film":
            axis.add_patch(Rectangle(start, width, height, facecolor=colour, linewidth=0))
        case "circle":
            axis.add_patch(Circle(start, end[0], facecolor=colour, **_EDGE))
        case "ring":
            axis.add_patch(Circle(start, end[0], fill=False, linewidth=0.6, linestyle="--"))
        case "line":
            thickness = 3.0 if oil else 0.6
            xy = zip(start, end, strict=True)
            axis.plot(*xy, color=colour, linewidth=thickness, solid_capstyle="butt")
        case "arrow" | "turn" | "turn left":
            bend = {"turn": -0.6, "turn left": 0.6}.get(part["mark"], 0.0)
            axis.add_patch(
                FancyArrowPatch(
                    start,
                    end,
                    arrowstyle="-|>",
                    connectionstyle=f"arc3,rad={bend}",
                    mutation_scale=7,
                    shrinkA=0,
                    shrinkB=0,
                    color="#0072B2" if oil else "black",
                    linewidth=0.9,
                )
            )
        case "words":
            _draw_label(axis, part["words"], start, end)


def _draw_label(
    axis: Axes, label: str, at: tuple[float, float], target: tuple[float, float]
) -> None:
    box = None
    if at != target:
        axis.plot(*zip(at, target, strict=True), color=style.GREY, linewidth=0.5)
        axis.plot(*target, ".", color=style.GREY, markersize=2.5)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    axis.text(*at, label, ha="center", va="center", fontsize=7, linespacing=1.1, bbox=box)
