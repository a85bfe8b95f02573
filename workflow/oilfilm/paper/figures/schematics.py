"""The two rigs, drawn by code from what the paper's text says of them (Figs 1 and 5)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Patch, Rectangle

from oilfilm import tables
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
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
_EDGE: dict[str, Any] = {"edgecolor": "black", "linewidth": 0.6}


@register(
    name="fig01",
    paper="Fig. 1",
    title="Traction rig",
    caption="(a) Ball-on-disc rig with drives and sensors. (b) The cradle turns about the "
    "vertical axis of the air spindle. It presses against the force sensor, which measures along "
    "the rolling direction. (c) Contact of ball and disc with the measured speeds, load and "
    "force. Schematic after the text of the paper, not to scale; configured dimensions in mm.",
    family="data",
    settings=("rigs",),
    shows_data=False,
)
def fig01(results: CampaignTables, settings: Settings) -> Drawing:
    """The traction rig from the side and from above, and the contact along the ball's axis."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 4.5))
    axes = figure.subplot_mosaic(
        [["a", "b"], ["a", "c"]], width_ratios=(1.15, 1), height_ratios=(1, 1.25)
    )
    style.title_panel(axes["a"], 0, "Rig from the side")
    style.title_panel(axes["b"], 1, "Cradle from above")
    style.title_panel(axes["c"], 2, "Contact, along the ball's axis")
    rig = next(iter(settings.rigs.values()))
    radii = {"disc": rig.disc_track_radius_m, "ball": rig.ball_track_radius_m}
    sizes = {
        name: "" if radius is None else f" = {1e3 * radius:.4g} mm"
        for name, radius in radii.items()
    }
    return figure, [_draw(figure, "fig01", sizes)]


@register(
    name="fig05",
    paper="Fig. 5",
    title="Torque rig",
    caption="Rig for the friction torque of a bearing: driven inner ring, pure axial load and "
    "under-race lubrication. The torque of the outer ring is measured. Schematic after the text "
    "of the paper, not to scale.",
    family="data",
    shows_data=False,
)
def fig05(results: CampaignTables, settings: Settings) -> Drawing:
    """The torque rig in a section along its shaft."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.7))
    figure.subplots()
    return figure, [_draw(figure, "fig05", {})]


def _draw(figure: Figure, name: str, sizes: Mapping[str, str]) -> pd.DataFrame:
    """Draw the parts that a file lists, later ones above, and the key.

    A circle has its radius as `to_x`. Words are at (x, y), with a line to the part at (to_x, to_y)
    unless that is the same point. Each mark is two rows of what is drawn, its start and its end.

    Args:
        figure: With the panels.
        name: The file `<name>.csv` beside this module.
        sizes: What stands for the names in braces.
    """
    parts = pd.read_csv(Path(__file__).with_name(f"{name}.csv"), keep_default_na=False)
    labels = [label.format_map(sizes).replace("\\n", "\n") for label in parts["words"]]
    axes = dict(zip("abc", figure.axes, strict=False))
    for part in tables.rows(parts.assign(words=labels)):
        _draw_mark(axes[part["panel"]], part)
    for axis in figure.axes:
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_anchor("N")
    handles = [Patch(facecolor=colour, label=label, **_EDGE) for colour, label in _KINDS.values()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    style.say_key(figure, "Schematic, not to scale")
    series = (parts["mark"] + " " + parts["kind"]).str.strip().repeat(2)
    xy = (parts[[name, f"to_{name}"]].to_numpy().ravel() for name in "xy")
    return marks(parts["panel"].repeat(2), series, *xy, label=np.repeat(labels, 2))


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
