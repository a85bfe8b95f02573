"""How every figure looks: sizes of a journal, one colour an oil, one marker a level."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font

from oilfilm.captions import provenance

SINGLE_COLUMN_IN = 85 / 25.4
DOUBLE_COLUMN_IN = 170 / 25.4

# Okabe and Ito's colours, which stay apart for every kind of colour vision.
_PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P")
# What became of something: colour and symbol together, so that print in grey tells it as well.
STATE_COLOURS = {"accepted": "#0072B2", "refused": "#D55E00", "missing": "#555555"}
STATE_MARKERS = {"accepted": "o", "refused": "X", "missing": "D"}
VERDICT_COLOURS = {
    "holds": "#0072B2",
    "holds in part": "#E69F00",
    "fails": "#D55E00",
    "cannot be checked": "#777777",
}
VERDICT_MARKERS = {"holds": "o", "holds in part": "D", "fails": "X", "cannot be checked": "_"}

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
    "grid.color": "#e5e5e5",
    "grid.linewidth": 0.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "lines.markersize": 2.8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "savefig.dpi": 300,
    "svg.hashsalt": "oilfilm",
    "svg.fonttype": "none",
    "figure.constrained_layout.use": True,
}
mpl.rcParams.update(_SETTINGS)


def oil_colour(oil: str, oils: Sequence[str]) -> str:
    """The colour of an oil: its place in the campaign decides, in every figure alike."""
    return _PALETTE[list(oils).index(oil) % len(_PALETTE)]


def shades(colour: str, count: int) -> list[tuple[float, float, float]]:
    """`count` shades of one colour, from the colour itself darkened to a light tint of it."""
    red, green, blue = to_rgb(colour)
    steps = [0.45 + 1.0 * place / max(count - 1, 1) for place in range(count)]
    return [
        (red * s, green * s, blue * s)
        if s <= 1
        else tuple(1 - (1 - part) * (2 - s) for part in (red, green, blue))  # type: ignore[misc]
        for s in steps
    ]


# Height of a line of small print.
_LINE_IN = 0.11


def panels(rows: int, columns: int, width_in: float, height_in: float) -> tuple[Figure, list[Axes]]:
    """A figure with a grid of panels that share their axes; panels in reading order."""
    # not by pyplot, which would keep every figure open
    figure = Figure(figsize=(width_in, height_in))
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    return figure, list(axes.flat)


def label_traction_axes(figure: Figure) -> None:
    """Names of the two axes of mu against slip."""
    figure.supxlabel("Slide-roll ratio S (1)", fontsize=8)
    figure.supylabel("Traction coefficient \N{GREEK SMALL LETTER MU} (1)", fontsize=8)


def _is_wide(figure: Figure) -> bool:
    return figure.get_figwidth() > 1.5 * SINGLE_COLUMN_IN


def say_source(figure: Figure, campaign: Mapping[str, Any]) -> None:
    """Say on the figure itself whether its data were simulated or measured."""
    # above the key where the figure is too narrow for both in one line
    height = 1.002 if _is_wide(figure) else 1.002 + _LINE_IN / figure.get_figheight()
    words = provenance(campaign)
    figure.text(0.995, height, words, ha="right", va="bottom", fontsize=6, color="#555555")


def say_key(figure: Figure, words: str) -> None:
    """What symbols and lines mean, above the panels, where it covers no data."""
    figure.text(0.005, 1.002, words, ha="left", va="bottom", fontsize=6, color="#555555")


def tint(colour: str, share: float) -> tuple[float, float, float]:
    """White with a share of a colour in it."""
    red, green, blue = (1 - share * (1 - part) for part in to_rgb(colour))
    return red, green, blue


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
    metadata: dict[str, Any] = {".png": {"Software": None}, ".svg": {"Date": None}}
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        aside = path.with_name(f".{path.name}.part{path.suffix}")
        figure.savefig(aside, metadata=metadata[path.suffix], bbox_inches="tight", pad_inches=0.04)
        aside.replace(path)
