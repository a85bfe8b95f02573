"""The two rigs, drawn by code from what the paper's text says of them (Figs 1 and 5)."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Patch, Rectangle

from oilfilm import tables
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use

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


_SCHEMATIC = drawn_table(
    "schematic",
    "Drawn in the schematic of a rig: one row per mark, later ones above.",
    columns="panel mark kind x y to_x to_y words",
    uses=(
        use("kind", "material or action, which gives the colour; empty where there is none"),
        use("x", "start, in units of the drawing", required=True),
        use("y", "start, in units of the drawing", required=True),
        use("to_x", "in units of the drawing"),
        use("to_y", "in units of the drawing"),
    ),
)


@register(
    name="fig01",
    paper="Fig. 1",
    title="Traction rig",
    caption="(a) Ball-on-disc rig with drives and sensors. (b) Contact of ball and disc with the "
    "measured speeds, load and force. Schematic after the description in the text, not to scale; "
    "dimensions as configured (mm).",
    family="configured",
    settings=("rigs",),
    shows_data=False,
    draws=_SCHEMATIC,
)
def fig01(results: CampaignTables, settings: Settings) -> Drawing:
    """The traction rig from the side, and the contact seen along the ball's axis."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 3.9))
    axes = figure.subplots(1, 2, width_ratios=(116, 70))
    rig = next(iter(settings.rigs.values()))
    style.title_panel(axes[0], 0, "Rig from the side")
    style.title_panel(axes[1], 1, "Contact, along the ball's axis")
    return figure, [_draw(figure, [*_RIG, *_contact(rig)])]


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
    # traction force sensor between frame and cradle
    _box("a", "fixed", -46, 42, -42, 45),
    _box("a", "sensor", -42, 41, -34, 46),
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
    _label("a", "contact A", -8, 64, 11, 57.2),
    _label("a", "air spindle", 12, 29, -12, 30),
    _label("a", "load sensor, W", 14, 17, -8, 17),
    _label("a", "servo actuator", 14, 6, -10, 6),
    _label("a", "traction\nforce\nsensor, F", -35, 31, -38, 41),
    _label("a", "Hall sensor, n\u2082", -6, 84, 31, 67),
    _label("a", "Hall sensor, n\u2081", -28, 72, -32, 53),
    _label("a", "oil nozzle,\ntemperature T", 38, 33, 40, 43),
    _label("a", "frame", 40, 98.5),
)


def _contact(rig: Rig) -> list[_Mark]:
    """The contact; sizes as configured, where they are known."""

    def size(length_m: float | None) -> str:
        return "" if length_m is None else f" = {1e3 * length_m:.4g} mm"

    return [
        _box("b", "turning", -34, 22, 34, 30),
        ("b", "circle", "turning", 0, 0, 20, 0, ""),
        ("b", "line", "", 0, 0, 14.1, 14.1, ""),
        ("b", "line", "oil", -36, 12, -24, 17, ""),
        _arrow("b", -24, 17, -12, 20.5, "oil"),
        ("b", "film", "oil", -7, 20, 7, 22, ""),
        ("b", "turn", "", 9, -9, -9, -9, ""),
        _arrow("b", -30, 26, -14, 26),
        _arrow("b", -8, 13, 6, 13),
        _arrow("b", 10, 20.4, 27, 20.4),
        _arrow("b", 0, -36, 0, -21),
        _label("b", "disc, R\u2082" + size(rig.disc_track_radius_m), 15, 26),
        _label("b", "U\u2082", -10, 26),
        _label("b", "U\u2081", -11.5, 13),
        _label("b", "F on the ball", 27, 15.5),
        _label("b", "W", 4, -31),
        _label("b", "R\u2081" + size(rig.ball_track_radius_m), 9, -2.2),
        _label("b", "n\u2081", 0, -10.5),
        _label("b", "ball", -10, -3),
        _label("b", "film", -24, 8, -5, 20.8),
        _label("b", "oil, T", -33, 4, -31, 13.5),
        _label("b", "U = (U\u2081 + U\u2082)/2", -21, -27),
        _label("b", "S = (U\u2082 \N{MINUS SIGN} U\u2081)/U", 23, -27),
        _label("b", "\N{GREEK SMALL LETTER MU} = F/W", 23, -33),
    ]


@register(
    name="fig05",
    paper="Fig. 5",
    title="Torque rig",
    caption="Rig for the friction torque of a bearing: driven inner ring, pure axial load, "
    "under-race lubrication, measured torque of the outer ring. Schematic after the description "
    "in the text, not to scale.",
    family="configured",
    shows_data=False,
    draws=_SCHEMATIC,
)
def fig05(results: CampaignTables, settings: Settings) -> Drawing:
    """The torque rig in a section along its shaft."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.6))
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
    _box("a", "turning", 95, 4, 106, 7),
    _box("a", "turning", 95, -7, 106, -4),
    ("a", "circle", "turning", 100.5, 9.6, 3.1, 0, ""),
    ("a", "circle", "turning", 100.5, -9.6, 3.1, 0, ""),
    _box("a", "fixed", 95, 12.2, 106, 15.5),
    _box("a", "fixed", 95, -15.5, 106, -12.2),
    # housing, end cap, hydrostatic spindle, torque sensor
    _box("a", "fixed", 95, 15.5, 112, 19),
    _box("a", "fixed", 95, -19, 112, -15.5),
    _box("a", "fixed", 91, 11, 95, 19),
    _box("a", "fixed", 91, -19, 95, -11),
    _box("a", "fixed", 112, -19, 116, 19),
    # the spindle could turn, but the sensor holds it
    _box("a", "fixed", 116, -8, 156, 8),
    _box("a", "fixed", 121, 8, 150, 14),
    _box("a", "fixed", 121, -24, 150, -8),
    _box("a", "sensor", 156, -7, 170, 7),
    _box("a", "fixed", 170, -24, 178, 10),
    # oil to the holes of the inner ring
    ("a", "line", "oil", 84, 26, 84, 10, ""),
    _arrow("a", 84, 10, 94, 5.5, "oil"),
    _arrow("a", 3, 11, 19, 11),
    ("a", "turn", "", 85, 7, 85, -7, ""),
    _label("a", "electric\ncylinder", 11, 0),
    _label("a", "axial force\nsensor", 31, 22, 31.5, 6),
    _label("a", "drive, high and\nlow speed", 56, 0),
    _label("a", "carriage", 56, -16.5),
    _label("a", "axial load", 11, 15),
    _label("a", "drive shaft", 85, -21.3, 81, -3),
    _label("a", "oil supply", 71, 24, 83.5, 24),
    _label("a", "end cap", 84, 33, 92.5, 18.5),
    _label("a", "inner ring", 121, 31, 104, 5.5),
    _label("a", "outer ring", 101, 33, 101, 14),
    _label("a", "loading housing", 150, 23, 114.5, 15),
    _label("a", "hydrostatic spindle,\nalmost without friction", 136, 0),
    _label("a", "torque\nsensor", 163, 0),
    _label("a", "frame", 20, -26),
)


def _draw(figure: Figure, marks: Sequence[_Mark]) -> pd.DataFrame:
    """Draw marks, each as its row of the table says, and the key."""
    drawn = tables.conform(
        pd.DataFrame(marks, columns=tables.columns("schematic")), "schematic", "schematic"
    )
    axes = dict(zip("ab", figure.axes, strict=False))
    for row in tables.rows(drawn):
        _draw_mark(axes[row["panel"]], row)
    for axis in figure.axes:
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_anchor("N")
    handles = [Patch(facecolor=colour, label=label, **_EDGE) for colour, label in _KINDS.values()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    style.say_key(figure, "Schematic, not to scale")
    return drawn


def _draw_mark(axis: Axes, row: Mapping[str, Any]) -> None:
    start, end = (row["x"], row["y"]), (row["to_x"], row["to_y"])
    width, height = end[0] - start[0], end[1] - start[1]
    colour, _ = _KINDS.get(row["kind"], ("black", ""))
    oil = row["kind"] == "oil"
    match row["mark"]:
        case "box":
            axis.add_patch(Rectangle(start, width, height, facecolor=colour, **_EDGE))
        case "film":
            axis.add_patch(Rectangle(start, width, height, facecolor=colour, linewidth=0))
        case "circle":
            axis.add_patch(Circle(start, end[0], facecolor=colour, **_EDGE))
        case "line":
            thickness = 3.0 if oil else 0.6
            xy = zip(start, end, strict=True)
            axis.plot(*xy, color=colour, linewidth=thickness, solid_capstyle="butt")
        case "arrow" | "turn":
            axis.add_patch(
                FancyArrowPatch(
                    start,
                    end,
                    arrowstyle="-|>",
                    connectionstyle="arc3,rad=-0.6" if row["mark"] == "turn" else "arc3",
                    mutation_scale=7,
                    shrinkA=0,
                    shrinkB=0,
                    color="#0072B2" if oil else "black",
                    linewidth=0.9,
                )
            )
        case "words":
            _draw_label(axis, row["words"], start, end)


def _draw_label(
    axis: Axes, label: str, at: tuple[float, float], target: tuple[float, float]
) -> None:
    box = None
    if at != target:
        axis.plot(*zip(at, target, strict=True), color=style.GREY, linewidth=0.5)
        axis.plot(*target, ".", color=style.GREY, markersize=2.5)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    axis.text(*at, label, ha="center", va="center", fontsize=7, linespacing=1.1, bbox=box)
