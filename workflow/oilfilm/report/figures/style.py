"""How every figure looks: widths of a journal, one colour per oil, one line style per meaning."""

import string
import textwrap
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font
from matplotlib.lines import Line2D

from oilfilm.atomic_write import atomic_file
from oilfilm.bearing.kinematics import pitch_speed_mm_rpm
from oilfilm.report import colours
from oilfilm.report.captions import provenance
from oilfilm.settings.campaign import Campaign
from oilfilm.units import FloatArray

# Columns of a page, 84 and 174 mm.
SINGLE_COLUMN_IN = 84 / 25.4
DOUBLE_COLUMN_IN = 174 / 25.4

oil_colour = colours.oil_colour
MARKERS = ("o", "s", "^", "D", "v", "P")
# One style per meaning: what a law was fitted to, or where its constants are from.
LINES: dict[str, Any] = {
    "fit": "-",
    "printed": (0, (4, 2)),
    "load": "-.",
    "dimensionless load": ":",
    "not planned": (0, (6, 1.5)),
}
GREY = "#555555"  # of words and keys that belong to no oil
EXTRAPOLATED = colours.EXTRAPOLATED
# Name of each condition on an axis, and one level of it in a title.
CONDITION_LABELS = {
    "max_hertz_pressure_gpa": "Maximum Hertz pressure P (GPa)",
    "entrainment_speed_m_s": "Entrainment speed U (m/s)",
    "inlet_temperature_c": "Inlet temperature T (\N{DEGREE SIGN}C)",
    "slide_roll_ratio": "Slide-roll ratio S",
}
TRACTION_LABEL = "Traction coefficient \N{GREEK SMALL LETTER MU}"
SE_DRAWN = 1.96  # error bars are 95 % intervals
LEVEL_PHRASES = {
    "max_hertz_pressure_gpa": "P = {:g} GPa",
    "entrainment_speed_m_s": "U = {:g} m/s",
    "inlet_temperature_c": "T = {:g} \N{DEGREE SIGN}C",
    "slide_roll_ratio": "S = {:g}",
}
# Decimal places of the positions of axes, as shares of the figure: far below a pixel.
_PLACES = 6
_SMALL_PRINT: dict[str, Any] = {"va": "top", "fontsize": 6, "color": GREY}
# What became of something: colour and symbol together, so that print in grey tells it as well.
STATE_COLOURS = {"accepted": "#0072B2", "refused": "#D55E00", "missing": "#555555"}
STATE_MARKERS = {"accepted": "o", "refused": "X", "missing": "D"}
VERDICT_COLOURS = {
    "holds": "#0072B2",
    "by construction": "#56B4E9",
    "holds in part": "#E69F00",
    "fails": "#D55E00",
    "cannot be checked": "#777777",
}
VERDICT_MARKERS = {
    "holds": "o",
    "by construction": "s",
    "holds in part": "D",
    "fails": "X",
    "cannot be checked": "_",
}

_SETTINGS: Any = {
    "font.size": 8,
    "font.family": "DejaVu Sans",
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e5e5e5",
    "grid.linewidth": 0.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "lines.markersize": 2.8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "savefig.dpi": 180,  # as wide as the report shows it
    "svg.hashsalt": "oilfilm",
    "svg.fonttype": "none",
    "figure.constrained_layout.use": True,
}
mpl.rcParams.update(_SETTINGS)


def oil_marker(oil: str, oils: Sequence[str]) -> str:
    """The marker of an oil, beside its colour."""
    return MARKERS[list(oils).index(oil) % len(MARKERS)]


def shades(colour: str, count: int) -> list[tuple[float, float, float]]:
    """`count` shades of one colour, from the colour itself darkened to a light tint of it."""
    red, green, blue = to_rgb(colour)
    steps = [0.45 + 1.0 * number / max(count - 1, 1) for number in range(count)]
    return [(red * s, green * s, blue * s) if s <= 1 else tint(colour, 2 - s) for s in steps]


def tint(colour: str, share: float) -> tuple[float, float, float]:
    """White with a share of a colour in it."""
    red, green, blue = (1 - share * (1 - part) for part in to_rgb(colour))
    return red, green, blue


def panels(rows: int, columns: int, width_in: float, height_in: float) -> tuple[Figure, list[Axes]]:
    """A figure with a grid of panels that share their axes; panels in reading order."""
    # not by pyplot, which would keep every figure open
    figure = Figure(figsize=(width_in, height_in))
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    return figure, list(axes.flat)


def title_panel(axis: Axes, number: int, title: str = "", **look: Any) -> str:
    """Give a panel its title with its letter in front; returns the letter."""
    letter = string.ascii_letters[number]
    axis.set_label(letter)
    axis.set_title(f"({letter}) {title}".rstrip(), **look)
    return letter


def panels_in_words(figure: Figure) -> dict[str, dict[str, str]]:
    """Title, abscissa and ordinate of each panel by its letter, with their units."""
    return {
        str(axes.get_label()): {
            "title": axes.get_title(loc="left"),
            "x": _shared_label(axes.get_shared_x_axes(), axes, "x") or figure.get_supxlabel(),
            "y": _shared_label(axes.get_shared_y_axes(), axes, "y") or figure.get_supylabel(),
        }
        for axes in figure.axes
        if axes.axison and axes.get_label() != "<colorbar>"
    }


def _shared_label(group: Any, axes: Axes, name: str) -> str:
    """Label of an axis, or of one that shares it: inner panels have none of their own."""
    labels = (getattr(each, f"get_{name}label")() for each in [axes, *group.get_siblings(axes)])
    return next(filter(None, labels), "")


def level_phrases(levels: Mapping[str, float]) -> str:
    """Levels of conditions in words, as `P = 1.5 GPa, S = 0.1`."""
    return ", ".join(LEVEL_PHRASES[name].format(level) for name, level in levels.items())


def bearing_speed_phrase(entrainment_speed_m_s: float) -> str:
    """An entrainment speed with the dmN (mm rpm) of a bearing: `U = 200 m/s (dmN 7.6e6)`."""
    mantissa, exponent = f"{pitch_speed_mm_rpm(entrainment_speed_m_s):.1e}".split("e")
    speed = LEVEL_PHRASES["entrainment_speed_m_s"].format(entrainment_speed_m_s)
    return f"{speed} (dmN {mantissa}e{int(exponent)})"


def say_in_panel(axis: Axes, sentence: str, **look: Any) -> None:
    """Say in the middle of a panel why it is empty."""
    axis.text(0.5, 0.5, sentence, ha="center", va="center", transform=axis.transAxes, **look)


def page(width_in: float, height_in: float, *, bottom: float, top: float) -> tuple[Figure, Axes]:
    """A figure for text without axes: x from 0 to 1, y between two limits."""
    figure, (axis,) = panels(1, 1, width_in, height_in)
    axis.set_axis_off()
    axis.set(xlim=(0, 1), ylim=(bottom, top))
    return figure, axis


def sentences(lines: str) -> Figure:
    """A figure of text: why there is nothing to draw."""
    height_in = 0.14 * (lines.count("\n") + 1) + 0.05
    figure, axis = page(SINGLE_COLUMN_IN, height_in, bottom=0, top=1)
    axis.text(0, 1, lines, va="top", fontsize=7, linespacing=1.3, parse_math=False)
    return figure


def line_handle(label: str, **look: Any) -> Line2D:
    """An entry of a legend: a line, a symbol or both."""
    return Line2D([], [], label=label, **look)


def symbol_handle(label: str, marker: str, **look: Any) -> Line2D:
    """An entry of a legend: a symbol without a line."""
    return Line2D([], [], linestyle="", marker=marker, label=label, **look)


def oil_handles(oils: Sequence[str], shown: Collection[str], **look: Any) -> list[Line2D]:
    """Entries of a legend that tell oils apart by colour and symbol: those that are shown."""
    return [
        line_handle(oil, color=oil_colour(oil, oils), marker=oil_marker(oil, oils), **look)
        for oil in oils
        if oil in shown
    ]


def label_traction_axes(figure: Figure) -> None:
    """Names of the two axes of mu against slip."""
    figure.supxlabel(CONDITION_LABELS["slide_roll_ratio"], fontsize=8)
    figure.supylabel(TRACTION_LABEL, fontsize=8)


def say_source(figure: Figure, campaign: Campaign, unjudged: Collection[str]) -> None:
    """Say on the figure itself where its data are from; `unjudged` as in `provenance`."""
    _put_above(figure, provenance(campaign, unjudged), right=True)


def say_key(figure: Figure, key: str) -> None:
    """What symbols and lines mean, above the panels, where it covers no data."""
    _put_above(figure, key, right=False)


def _put_above(figure: Figure, lines: str, *, right: bool) -> None:
    """Small print above the panels, for which the figure grows; the panels keep their height."""
    line_in, margin_in = 0.12, 0.02
    wide = figure.get_figwidth() > 1.5 * SINGLE_COLUMN_IN
    # 70 letters fit into the width of one column, and into half of a wide figure
    lines = "\n".join(part for line in lines.split("\n") for part in textwrap.wrap(line, 70))
    side = "right" if right else "left"
    figure.text(1 if right else 0, 1, lines, ha=side, gid="small print", **_SMALL_PRINT)
    print_above = [text for text in figure.texts if text.get_gid() == "small print"]
    # which the settings above give to every figure
    layout: Any = figure.get_layout_engine()
    panels_in = figure.get_figheight() * layout.get()["rect"][3]
    heights = [line_in * (text.get_text().count("\n") + 1) for text in print_above]
    # in one line where that is wide enough for both
    height_in = panels_in + (max(heights) if wide else sum(heights))
    figure.set_figheight(height_in)
    top = height_in
    for text, height in zip(print_above, heights, strict=True):
        x = margin_in / figure.get_figwidth()
        at_right = text.get_horizontalalignment() == "right"
        text.set_position((1 - x if at_right else x, (top - margin_in) / height_in))
        top -= 0 if wide else height
    layout.set(rect=(0, 0, 1, panels_in / height_in))


def cell_edges(centres: FloatArray, scale: str) -> FloatArray:
    """Edges of cells around rising centres, half way along a linear or logarithmic scale."""
    levels = np.log(centres) if scale == "log" else centres
    if len(levels) == 1:
        edges = levels[0] + np.array([-0.5, 0.5])
        return np.exp(edges) if scale == "log" else edges
    middles = (levels[1:] + levels[:-1]) / 2
    first, last = 2 * levels[0] - middles[0], 2 * levels[-1] - middles[-1]
    edges = np.concatenate([[first], middles, [last]])
    return np.exp(edges) if scale == "log" else edges


def plain(text: str) -> str:
    """Text of a log that can be drawn as it stands: what the font lacks is written as its code.

    To be drawn with `parse_math=False`, or `$` would begin a formula.
    """
    font = get_font(findfont(_SETTINGS["font.family"]))
    return "".join(
        letter
        if letter.isprintable() and font.get_char_index(ord(letter))
        else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )


def save(figure: Figure, *paths: Path) -> None:
    """Write a figure as PNG or SVG, the same bytes each time, whole or not at all."""
    _lay_out(figure)
    for path in paths:
        with atomic_file(path) as aside:
            # `Figure.savefig` would draw the figure twice, to lay it out again
            canvas: Any = (FigureCanvasAgg if path.suffix == ".png" else FigureCanvasSVG)(figure)
            if path.suffix == ".png":
                canvas.print_png(aside, metadata={"Software": None})
            else:
                canvas.print_svg(aside, metadata={"Date": None})


def _lay_out(figure: Figure) -> None:
    """Place the axes once, on a grid: the solver of the layout may differ in the last bits.

    The order of its sums depends on addresses in memory.
    """
    figure.set_dpi(mpl.rcParams["savefig.dpi"])
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, _PLACES))
