"""The two rigs, drawn by code from what the paper's text says of them (Figs 1 and 5)."""

from collections.abc import Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Patch, Rectangle

from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, marks, register
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
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
# One mark: panel, mark, kind, x, y, to_x, to_y, words. A circle has its radius as to_x. Words are
# at (x, y), with a line to the part at (to_x, to_y) unless that is the same point.
_Mark = tuple[str, str, str, float, float, float, float, str]


def _box(panel: str, kind: str, x: float, y: float, to_x: float, to_y: float) -> _Mark:
    return (panel, "box", kind, x, y, to_x, to_y, "")


def _label(panel: str, label: str, x: float, y: float, *target: float) -> _Mark:
    to_x, to_y = target or (x, y)
    return (panel, "words", "", x, y, to_x, to_y, label)


def _arrow(panel: str, x: float, y: float, to_x: float, to_y: float, kind: str = "") -> _Mark:
    return (panel, "arrow", kind, x, y, to_x, to_y, "")


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
    rig = next(iter(settings.rigs.values()))
    style.title_panel(axes["a"], 0, "Rig from the side")
    style.title_panel(axes["b"], 1, "Cradle from above")
    style.title_panel(axes["c"], 2, "Contact, along the ball's axis")
    return figure, [_draw(figure, [*_RIG, *_CRADLE, *_contact(rig)])]


_RIG: tuple[_Mark, ...] = (
    # frame: base, column, beam
    _box("a", "fixed", -52, -8, 50, -3),
    _box("a", "fixed", -52, -3, -46, 96),
    _box("a", "fixed", -52, 96, 50, 101),
    # disc below its vertical spindle
    _box("a", "drive", 17, 70, 37, 96),
    _box("a", "turning", 25, 61, 29, 70),
    _box("a", "turning", 4, 57, 50, 61),
    # ball on its horizontal spindle, on the cradle
    ("a", "circle", "turning", 12, 51.5, 5.5, 0, ""),
    _box("a", "turning", 2, 50, 6.6, 53),
    _box("a", "drive", -30, 46, 2, 57),
    _box("a", "fixed", -34, 41, 6, 46),
    # air spindle, load sensor, actuator
    _box("a", "turning", -20, 20, -8, 41),
    _box("a", "fixed", -23, 22, -20, 38),
    _box("a", "fixed", -8, 22, -5, 38),
    _box("a", "sensor", -21, 14, -7, 20),
    _box("a", "drive", -19, -3, -9, 14),
    # traction force sensor on a post of the frame, in front of the cradle
    _box("a", "fixed", -29, -3, -25.5, 40),
    _box("a", "sensor", -30.5, 39, -24.5, 47),
    # nozzle and its oil, Hall sensors
    ("a", "line", "oil", 46, 40, 22, 52, ""),
    _arrow("a", 22, 52, 15, 56, "oil"),
    _box("a", "sensor", 30, 63, 34, 68),
    _box("a", "sensor", -34, 49, -30, 54),
    _arrow("a", -14, 2, -14, 10),
    _label("a", "spindle II", 27, 83),
    _label("a", "disc", 44, 67, 44, 61),
    _label("a", "spindle I", -14, 51.5),
    _label("a", "ball", 14, 36, 13, 47),
    _label("a", "cradle", -14, 43.5),
    _label("a", "contact A,\nF into the page", -14, 68, 11.5, 57.2),
    _label("a", "air spindle", 12, 29, -12, 30),
    _label("a", "load sensor, W", 14, 17, -8, 17),
    _label("a", "servo actuator", 14, 6, -10, 6),
    _label("a", "traction\nforce\nsensor, F", -37.6, 28, -29, 41),
    _label("a", "Hall sensor, n\u2082", -8, 86, 31, 67),
    _label("a", "Hall sensor, n\u2081", -30, 77, -32, 53),
    _label("a", "oil nozzle (turned\ninto the page),\ntemperature T", 38, 31, 40, 43),
    _label("a", "frame", 40, 98.5),
)

# Abscissa as in the side view; what is above is farther away there.
_CRADLE: tuple[_Mark, ...] = (
    _box("b", "fixed", -52, -20, -46, 24),
    _box("b", "fixed", -46, -20, -25, -16),
    _box("b", "sensor", -32, -16, -26, -7),
    _box("b", "fixed", -34, -7, 6, 7),
    _box("b", "drive", -30, -5, 2, 5),
    _box("b", "turning", 2, -1.5, 6.6, 1.5),
    ("b", "circle", "turning", 12, 0, 5.5, 0, ""),
    ("b", "ring", "", 27, 0, 23, 0, ""),
    ("b", "circle", "turning", -14, 0, 1.2, 0, ""),
    ("b", "turn left", "", -3, -12, -3, 12, ""),
    _arrow("b", 12, 0, 12, 15),
    _label("b", "spindle I", -38, 17, -26, 3),
    _label("b", "axis of the air spindle", -19, 24, -14, 0.5),
    _label("b", "traction force sensor, F", -4, -26.5, -28, -12),
    _label("b", "frame", -38, -11, -40, -17.5),
    _label("b", "F", 15.5, 12),
    _label("b", "ball", 24, -8, 15, -3.5),
    _label("b", "disc\n(above)", 35, 4),
    _label("b", "yaw", -9, 12.5),
)


def _contact(rig: Rig) -> list[_Mark]:
    """The contact; sizes as configured, where they are known."""

    def size(length_m: float | None) -> str:
        return "" if length_m is None else f" = {1e3 * length_m:.4g} mm"

    return [
        _box("c", "turning", -34, 22, 34, 30),
        ("c", "circle", "turning", 0, 0, 20, 0, ""),
        ("c", "line", "", 0, 0, 14.1, 14.1, ""),
        ("c", "line", "oil", -36, 12, -24, 17, ""),
        _arrow("c", -24, 17, -12, 20.5, "oil"),
        ("c", "film", "oil", -7, 20, 7, 22, ""),
        ("c", "turn", "", 9, -9, -9, -9, ""),
        _arrow("c", -30, 26, -14, 26),
        _arrow("c", -8, 13, 6, 13),
        _arrow("c", 10, 20.4, 27, 20.4),
        _arrow("c", 0, -36, 0, -21),
        _label("c", "disc, R\u2082" + size(rig.disc_track_radius_m), 15, 26),
        _label("c", "U\u2082", -10, 26),
        _label("c", "U\u2081", -11.5, 13),
        _label("c", "F on the ball", 27, 15.5),
        _label("c", "W", 4, -31),
        _label("c", "R\u2081" + size(rig.ball_track_radius_m), 6.5, -3),
        _label("c", "n\u2081", 0, -10.5),
        _label("c", "ball", -10, -3),
        _label("c", "film", -24, 8, -5, 20.8),
        _label("c", "oil, T", -33, 4, -31, 13.5),
        _label("c", "U = (U\u2081 + U\u2082)/2", -21, -27),
        _label("c", "S = (U\u2082 \N{MINUS SIGN} U\u2081)/U", 23, -27),
        _label("c", "\N{GREEK SMALL LETTER MU} = F/W", 23, -33),
    ]


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
    return figure, [_draw(figure, _TORQUE_RIG)]


_TORQUE_RIG: tuple[_Mark, ...] = (
    # axial load: cylinder, sensor, carriage with the drive
    _box("a", "fixed", -4, -28, 178, -24),
    _box("a", "fixed", -4, -24, 0, 10),
    _box("a", "drive", 0, -7, 22, 7),
    _box("a", "fixed", 22, -2.5, 27, 2.5),
    _box("a", "sensor", 27, -6, 36, 6),
    _box("a", "drive", 36, -14, 76, 14),
    _box("a", "fixed", 34, -19, 78, -14),
    ("a", "circle", "fixed", 42, -21.5, 2.5, 0, ""),
    ("a", "circle", "fixed", 70, -21.5, 2.5, 0, ""),
    # shaft and test bearing
    _box("a", "turning", 76, -4, 107, 4),
    _box("a", "turning", 94, 5.5, 107, 9),
    _box("a", "turning", 94, -9, 107, -5.5),
    ("a", "circle", "turning", 100.5, 11.6, 3.4, 0, ""),
    ("a", "circle", "turning", 100.5, -11.6, 3.4, 0, ""),
    _box("a", "fixed", 94, 14.2, 107, 17.5),
    _box("a", "fixed", 94, -17.5, 107, -14.2),
    # shoulders pass the load on: of the shaft (the oil runs through it) to the inner ring, and of
    # the outer ring to the housing
    _box("a", "turning", 92, 4, 94, 8),
    _box("a", "turning", 92, -8, 94, -4),
    _box("a", "fixed", 107, 14.2, 112, 17.5),
    _box("a", "fixed", 107, -17.5, 112, -14.2),
    # housing, end cap, hydrostatic spindle, torque sensor
    _box("a", "fixed", 94, 17.5, 112, 21),
    _box("a", "fixed", 94, -21, 112, -17.5),
    _box("a", "fixed", 90, 13, 94, 21),
    _box("a", "fixed", 90, -21, 94, -13),
    _box("a", "fixed", 112, -21, 116, 21),
    # the spindle could turn, but the sensor holds it
    _box("a", "fixed", 116, -8, 156, 8),
    _box("a", "fixed", 121, 8, 150, 14),
    _box("a", "fixed", 121, -24, 150, -8),
    _box("a", "sensor", 156, -7, 170, 7),
    _box("a", "fixed", 170, -24, 178, 10),
    # oil from a pipe into the gap behind a lip of the shaft, under the race and through its holes
    _box("a", "turning", 87, 4, 88.5, 8),
    _box("a", "turning", 87, -8, 88.5, -4),
    _box("a", "oil", 88.5, 4, 107, 5.5),
    _box("a", "oil", 88.5, -5.5, 107, -4),
    # the seat of the inner ring on the shaft
    _box("a", "turning", 105.2, 4, 107, 5.5),
    _box("a", "turning", 105.2, -5.5, 107, -4),
    _box("a", "oil", 96, 5.5, 97, 9),
    _box("a", "oil", 104, 5.5, 105, 9),
    _box("a", "oil", 96, -9, 97, -5.5),
    _box("a", "oil", 104, -9, 105, -5.5),
    ("a", "line", "oil", 82, 28, 82, 10.5, ""),
    ("a", "line", "oil", 81.4, 10.5, 91.8, 10.5, ""),
    _arrow("a", 91.2, 10.5, 91.2, 5.5, "oil"),
    _arrow("a", 96.5, 9, 96.5, 12.5, "oil"),
    _arrow("a", 104.5, 9, 104.5, 12.5, "oil"),
    _arrow("a", 96.5, -9, 96.5, -12.5, "oil"),
    _arrow("a", 104.5, -9, 104.5, -12.5, "oil"),
    _arrow("a", 3, 11, 19, 11),
    ("a", "turn", "", 79, 7, 79, -7, ""),
    _label("a", "electric\ncylinder", 11, 0),
    _label("a", "axial force\nsensor", 31, 22, 31.5, 6),
    _label("a", "drive, high and\nlow speed", 56, 0),
    _label("a", "carriage", 56, -16.5),
    _label("a", "axial load", 11, 15),
    _label("a", "drive shaft", 82, -21.6, 85.5, -3.2),
    _label("a", "oil supply", 69, 25, 81.5, 25),
    _label("a", "end cap", 86, 35, 92, 20),
    _label("a", "inner ring with oil holes,\nunder-race feed", 133, 31, 105.8, 7.2),
    _label("a", "outer ring", 102, 35, 100.5, 16),
    _label("a", "loading housing", 157, 21, 114.5, 17),
    _label("a", "hydrostatic spindle,\nalmost without friction", 136, 0),
    _label("a", "torque\nsensor", 163, 0),
    _label("a", "frame", 20, -26),
)


def _draw(figure: Figure, parts: Sequence[_Mark]) -> pd.DataFrame:
    """Draw the parts and the key; each mark is two rows, its start and its end."""
    axes = dict(zip("abc", figure.axes, strict=False))
    for part in parts:
        _draw_mark(axes[part[0]], *part[1:])
    for axis in figure.axes:
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_anchor("N")
    handles = [Patch(facecolor=colour, label=label, **_EDGE) for colour, label in _KINDS.values()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    style.say_key(figure, "Schematic, not to scale")
    return pd.concat(
        marks(panel, f"{mark} {kind}".strip(), [x, to_x], [y, to_y], label=label)
        for panel, mark, kind, x, y, to_x, to_y, label in parts
    )


def _draw_mark(
    axis: Axes, mark: str, kind: str, x: float, y: float, to_x: float, to_y: float, label: str
) -> None:
    start, end = (x, y), (to_x, to_y)
    width, height = end[0] - start[0], end[1] - start[1]
    colour, _ = _KINDS.get(kind, ("black", ""))
    oil = kind == "oil"
    match mark:
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
            bend = {"turn": -0.6, "turn left": 0.6}.get(mark, 0.0)
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
            _draw_label(axis, label, start, end)


def _draw_label(
    axis: Axes, label: str, at: tuple[float, float], target: tuple[float, float]
) -> None:
    box = None
    if at != target:
        axis.plot(*zip(at, target, strict=True), color=style.GREY, linewidth=0.5)
        axis.plot(*target, ".", color=style.GREY, markersize=2.5)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    axis.text(*at, label, ha="center", va="center", fontsize=7, linespacing=1.1, bbox=box)
