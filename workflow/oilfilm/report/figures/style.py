"""How every figure looks: widths of a journal, one colour per oil, one line style per meaning.

Decides: widths, symbols and line styles of figures (fonts and lines: `journal.mplstyle`).
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.colors import to_rgb
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from oilfilm.base.units import FloatArray
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.report import names
from oilfilm.settings.resolved import Settings

# Widths of figures: one column of a page (84 mm), and two (174 mm).
SINGLE_COLUMN_IN = 84 / 25.4
DOUBLE_COLUMN_IN = 174 / 25.4

# Keyword arguments of a drawing function of matplotlib, as colour and marker.
Look = dict[str, Any]
oil_colour = names.oil_colour
MARKERS = ("o", "s", "^", "D", "v", "P")
# One line style per meaning: the basis of a law, or the source of its constants.
LINE_STYLES: dict[str, Any] = {
    "fit": "-",
    "printed": (0, (4, 2)),
    "left out": (0, (4, 2)),
    "load": "-.",
    "dimensionless load": ":",
    "not planned": (0, (6, 1.5)),
}
GREY = "#555555"  # of text and legend entries that belong to no oil
EXTRAPOLATED_COLOUR = "#ececec"  # background of conditions outside the tests
MU = "\N{GREEK SMALL LETTER MU}"
LAMBDA = "\N{GREEK SMALL LETTER LAMDA}"
# No mathematics of matplotlib: its parser takes half a second to load.
THOUSANDTHS = "10\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT THREE}"
# Name of each condition on an axis, and one level of it in a title.
CONDITION_LABELS = {
    name: f"{label} {symbol} ({unit})".removesuffix(" ()")
    for name, (symbol, label, unit) in names.CONDITION_TEXTS.items()
}
LEVEL_PHRASES = {
    name: f"{symbol} = {{:g}} {unit}".rstrip()
    for name, (symbol, _, unit) in names.CONDITION_TEXTS.items()
}
TRACTION_LABEL = f"Traction coefficient {MU}"
SPEED_LABEL = "Speed of the inner ring (1000 rpm)"
DMN_LABEL = "dmN (million mm rpm)"
DMN_AS_SPEED = f"dmN of 1 million mm rpm is U = {entrainment_speed_m_s(1e6):.0f} m/s"
AXIAL_LOAD_LABEL = "Axial load (kN)"
BAR_HALF_LENGTH_SE = 1.96  # half length of an error bar, in standard errors: 95 % intervals
# Colour and symbol of a verdict, so that print in grey shows it, too.
STATE_COLOURS = {"accepted": "#0072B2", "refused": "#D55E00", "missing": "#555555"}
STATE_MARKERS = {"accepted": "o", "refused": "X", "missing": "D"}
BAR_LOOK: Look = {"markerfacecolor": "white", "markeredgewidth": 0.7, "elinewidth": 0.7}
mpl.rc_file(Path(__file__).with_name("journal.mplstyle"))


def oil_look(oil: str, oils: Sequence[str]) -> Look:
    """Colour and symbol of an oil."""
    marker = MARKERS[list(oils).index(oil) % len(MARKERS)]
    return {"color": oil_colour(oil, oils), "marker": marker}


def oils_in(table: pd.DataFrame, settings: Settings) -> list[str]:
    """The oils of a campaign that have rows in a table."""
    return [oil for oil in settings.oils if (table["oil"] == oil).any()]


def oil_patches(shown: Iterable[str], oils: Sequence[str]) -> list[Any]:
    """Entries of a legend: the colour of each oil that is shown."""
    return [Patch(color=oil_colour(oil, oils), label=oil) for oil in shown]


def shades(colour: str, count: int) -> list[tuple[float, float, float]]:
    """`count` shades of one colour, from dark to light."""
    red, green, blue = to_rgb(colour)
    colours = []
    for number in range(count):
        brightness = 0.45 + 1.0 * number / max(count - 1, 1)
        if brightness <= 1:
            colours.append((red * brightness, green * brightness, blue * brightness))
        else:
            colours.append(tint(colour, 2 - brightness))
    return colours


def tint(colour: str, share: float) -> tuple[float, float, float]:
    """A mixture of a colour and white; `share` is that of the colour."""
    red, green, blue = to_rgb(colour)
    return 1 - share * (1 - red), 1 - share * (1 - green), 1 - share * (1 - blue)


def level_phrases(levels: Mapping[str, float]) -> str:
    """Levels of conditions in words, as `P = 1.5 GPa, S = 0.1`."""
    return ", ".join(LEVEL_PHRASES[name].format(level) for name, level in levels.items())


def line_handle(label: str, **look: Any) -> Line2D:
    """An entry of a legend: a line, a symbol or both."""
    return Line2D([], [], label=label, **look)


def symbol_handle(label: str, marker: str, **look: Any) -> Line2D:
    """An entry of a legend: a symbol without a line."""
    return Line2D([], [], linestyle="", marker=marker, label=label, **look)


def missing_oil_handles(oils: Iterable[str], reason: str = "") -> list[Patch]:
    """Entries of a legend for oils that are not drawn, with the reason; blank without a reason."""
    label = f"{{}}: {reason}" if reason else " "
    return [Patch(fill=False, linewidth=0, label=label.format(oil)) for oil in oils]


def log_ticks(axis: Any, ticks: Sequence[float]) -> None:
    """Give a logarithmic axis (`Axes.xaxis` or `Axes.yaxis`) only these ticks, as plain numbers."""
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def cell_edges(centres: FloatArray, scale: str = "linear") -> FloatArray:
    """Edges of cells, shape (n + 1,), half way between their centres.

    Args:
        centres: Rising, shape (n,).
        scale: `linear`, or `log` for half way along a logarithmic scale.
    """
    scaled_centres = np.log(centres) if scale == "log" else centres
    if len(scaled_centres) == 1:
        below = scaled_centres - 1.0
        above = scaled_centres + 1.0
    else:
        below = 2 * scaled_centres[0] - scaled_centres[1:2]
        above = 2 * scaled_centres[-1] - scaled_centres[-2:-1]
    extended = np.concatenate([below, scaled_centres, above])
    edges = (extended[1:] + extended[:-1]) / 2
    return np.exp(edges) if scale == "log" else edges


def plain_text(text: str) -> str:
    """Text of a log for a figure: characters that the font lacks become their codes.

    Draw it with `parse_math=False`: otherwise `$` begins a formula.
    """
    font = get_font(findfont(FontProperties()))
    characters = []
    for character in text:
        if character.isprintable() and font.get_char_index(ord(character)):
            characters.append(character)
        else:
            characters.append(character.encode("unicode_escape").decode("ascii"))
    return "".join(characters)
