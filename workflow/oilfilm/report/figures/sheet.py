"""A figure: lettered panels on a grid in inches, a legend below them, and what they draw as rows.

A figure is a function with the decorator `register`; its name leads to it and to its table.

Positions follow from sizes in inches alone: no solver measures texts, whose last bits differ.

Decides: what is kept of what a figure draws.
"""

import io
import itertools
import re
import string
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from PIL import Image

from oilfilm import tables
from oilfilm.base.atomic_write import atomic_file
from oilfilm.base.figure_catalogue import figures
from oilfilm.report.figures.style import DOUBLE_COLUMN_IN, GREY, SINGLE_COLUMN_IN, Look, plain
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# Room around and between panels, as `Sheet` describes it.
_ROOM_IN = {"left": 0.62, "right": 0.1, "top": 0.22, "bottom": 0.4, "across": 0.15, "down": 0.27}
_MARK_IN = 0.14  # the line that says that data are simulated
# Of a legend, in inches: height of a line, width of a symbol with its gaps, width of a letter.
_LINE_IN, _SYMBOL_IN, _LETTER_IN = 0.155, 0.42, 0.061
_SMALL_LETTER_IN = 0.049  # width of a letter of notes
_COLOUR_BAR = "<colorbar>"
_CLIP = re.compile(r'(  <clipPath id="(p\w+)">\n(.*?)  </clipPath>\n)', re.DOTALL)


class Panel:
    """A panel; what it draws is kept as rows of the table `drawn`."""

    def __init__(self, axis: Axes, letter: str, parts: list[dict[str, Any]]) -> None:
        """Take the axes; rows are added to `parts`."""
        self.axis, self.letter, self.parts = axis, letter, parts

    def keep(self, series: Any, x: Any, y: Any = np.nan, **about: Any) -> None:
        """Keep marks that matplotlib draws otherwise: arrays of one length, or one value for all.

        Args:
            series: Which line, symbol or row of the panel.
            x: Abscissa.
            y: Ordinate.
            about: `oil`; `label`, which is drawn there or tells the mark apart; `value` that a
                colour or a number shows; `lower` and `upper` end of a bar or band; `panel`, a
                column of a table, in place of the panel's letter.
        """
        given = {"panel": self.letter, "series": series, "oil": "", "label": "", "x": x, "y": y}
        given |= {"value": np.nan, "lower": np.nan, "upper": np.nan, **about}
        arrays = np.broadcast_arrays(*map(np.atleast_1d, map(np.asarray, given.values())))
        self.parts.append(dict(zip(tables.columns("drawn"), arrays, strict=True)))

    def line(self, series: Any, x: Any, y: Any, look: Look, **about: Any) -> None:
        """Draw and keep a line, with a band from `lower` to `upper` where these are given."""
        self.axis.plot(x, y, **look)
        if "lower" in about:
            band: Look = {"color": look.get("color"), "alpha": 0.25, "linewidth": 0}
            self.axis.fill_between(x, about["lower"], about["upper"], **band)
        self.keep(series, x, y, **about)

    def dots(self, series: Any, x: Any, y: Any, look: Look, **about: Any) -> None:
        """Draw and keep symbols, with bars from `lower` to `upper` where these are given."""
        look = {"linestyle": "", **look}
        if "lower" in about:
            ends = np.abs(np.asarray([y - about["lower"], about["upper"] - y]))
            self.axis.errorbar(x, y, yerr=ends, **look)
        else:
            self.axis.plot(x, y, **look)
        self.keep(series, x, y, **about)

    def say(self, sentence: str, **look: Any) -> None:
        """Say in the middle of the panel why it is empty."""
        place: Look = {"ha": "center", "va": "center", "transform": self.axis.transAxes}
        self.axis.text(0.5, 0.5, sentence, **place, **look)


class Sheet:
    """A figure with its panels in reading order."""

    def __init__(
        self,
        count: int = 1,
        columns: int = 1,
        *,
        width: float | None = None,
        height: float | Sequence[float] = 2.0,
        **layout: Any,
    ) -> None:
        """Place the panels.

        Args:
            count: Number of panels.
            columns: Panels side by side.
            width: Of the figure; by default one column of the page for one panel, else two.
            height: Of a panel, or of the panels of each row.
            layout: `left` for the ordinate, `right` beside the last column, `top` for the titles,
                `bottom` for the abscissa, gaps `across` columns and `down` rows; and keywords of
                `Figure.subplots`.
        """
        room = {side: layout.pop(side, usual) for side, usual in _ROOM_IN.items()}
        rows = -(-count // columns)
        self.heights = [height] * rows if isinstance(height, float | int) else list(height)
        self._width = width or (DOUBLE_COLUMN_IN if columns > 1 else SINGLE_COLUMN_IN)
        self._room, self._columns, self._legend_in = room, columns, 0.0
        self._bar: Axes | None = None
        # not by pyplot, which would keep every figure open
        self.figure = Figure()
        FigureCanvasAgg(self.figure)  # measures texts without a trial drawing
        ratios = {"height_ratios": self.heights, **layout}
        axes = list(self.figure.subplots(rows, columns, squeeze=False, **ratios).flat)
        for axis in axes[count:]:
            axis.remove()
        self.axes = axes[:count]
        for axis in axes[max(count - columns, 0) : count]:
            axis.tick_params(labelbottom=True)
        self.parts: list[dict[str, Any]] = []

    def drawn(self) -> pd.DataFrame:
        """The table of what the panels have drawn so far."""
        if not self.parts:
            return tables.empty("drawn")
        columns = {
            name: np.concatenate([part[name] for part in self.parts]) for name in self.parts[0]
        }
        return tables.conform(pd.DataFrame(columns), "drawn", "a figure")

    def panel(self, number: int = 0, title: str | None = "", **look: Any) -> Panel:
        """A panel, with its letter before its title; without a title it has no letter."""
        axis, letter = self.axes[number], ""
        if title is not None:
            letter = string.ascii_letters[number]
            axis.set_title(f"({letter}) {plain(title)}".rstrip(), **{"parse_math": False, **look})
        axis.set_label(letter)
        return Panel(axis, letter, self.parts)

    def label(self, x: str = "", y: str = "", **look: Any) -> None:
        """Name the axes; inner panels have the names for the table alone."""
        for number, axis in enumerate(self.axes):
            axis.set(**{f"{name}label": text for name, text in (("x", x), ("y", y)) if text})
            axis.xaxis.label.set(**look)
            lowest = number + self._columns >= len(self.axes)
            axis.xaxis.label.set_visible(lowest)
            axis.yaxis.label.set(**look)
            axis.yaxis.label.set_visible(number % self._columns == 0)

    def legend(self, handles: Sequence[Any], title: str = "", columns: int = 0) -> None:
        """What colours, symbols and lines mean, below the panels, where it covers no data."""
        labels = [str(handle.get_label()).split("\n") for handle in handles] or [[""]]
        letters = np.array([max(map(len, label)) for label in labels])

        def width_in(count: int) -> float:
            """The entries fill one column after another, the first ones with one more."""
            widest = [column.max() for column in np.array_split(letters, count)]
            return float(sum(_SYMBOL_IN + _LETTER_IN * longest for longest in widest))

        fitting = [n for n in range(1, len(labels) + 1) if width_in(n) < self._width]
        columns = columns or max(fitting, default=1)
        tall = max(column.sum() for column in np.array_split([*map(len, labels)], columns))
        lines = tall + (title.count("\n") + 1 if title else 0)
        self._legend_in = _LINE_IN * lines + 0.06
        self.figure.legend(
            handles=handles,
            loc="lower left",
            ncols=columns,
            title=title or None,
            alignment="left",
            borderpad=0.2,
            borderaxespad=0.2,
            columnspacing=1.2,
            handletextpad=0.5,
        )

    def colour_bar(self, mappable: Any, label: str, **look: Any) -> Axes:
        """A colour bar at the right of all panels; `right` must leave room for it."""
        self._bar = self.figure.add_axes((0, 0, 0.1, 0.1), label=_COLOUR_BAR)
        bar = self.figure.colorbar(mappable, cax=self._bar, **look)
        bar.set_label(label, fontsize=7)
        self._bar.tick_params(labelsize=6)
        return self._bar

    def finish(self, mark: str = "") -> Figure:
        """The figure with everything in its place, and above it what its data are."""
        room, width = self._room, self._width
        across, down = room["across"], room["down"]
        above = room["top"] + (_MARK_IN if mark else 0)
        below = room["bottom"] + self._legend_in
        rows, columns = len(self.heights), self._columns
        panels_in = sum(self.heights) + down * (rows - 1)
        height = above + panels_in + below
        self.figure.set_size_inches(width, height)
        panel_in = (width - room["left"] - room["right"] - across * (columns - 1)) / columns
        self.figure.subplots_adjust(
            left=room["left"] / width,
            right=1 - room["right"] / width,
            bottom=below / height,
            top=1 - above / height,
            wspace=across / panel_in,
            hspace=down * rows / sum(self.heights),
        )
        if self._bar is not None:
            x = 1 - (room["right"] - 0.1) / width
            y, tall = (below + 0.1 * panels_in) / height, 0.8 * panels_in / height
            self._bar.set_position((x, y, 0.1 / width, tall))
        if mark:
            place: Look = {"ha": "right", "va": "top", "fontsize": 6.5, "fontweight": "bold"}
            self.figure.text(1 - 0.03 / width, 1 - 0.02 / height, mark, color="#555555", **place)
        return self.figure


class NothingToDrawError(Exception):
    """A figure has nothing to draw; its message says why, in place of the figure."""


def oil_grid(
    oils: Sequence[str],
    otherwise: str = "",
    rows: Sequence[Any] = ("",),
    title: Callable[[Any, str], str] = lambda _, oil: oil,
    **layout: Any,
) -> tuple[Sheet, list[tuple[Panel, Any, str]]]:
    """A figure with one column of panels per oil; of one row at most three are side by side.

    Args:
        oils: Those that are shown.
        otherwise: What to say where there is none.
        rows: What each row of panels is for.
        title: Of a panel, from its row and oil.
        layout: As `Sheet`; all panels have the same axes unless it says otherwise.

    Returns:
        The figure, and each panel with its row and oil.

    Raises:
        NothingToDrawError: There is no oil.
    """
    if not oils:
        raise NothingToDrawError(otherwise)
    cells = list(itertools.product(rows, oils))
    columns = len(oils) if len(rows) > 1 else min(len(oils), 3)
    sheet = Sheet(len(cells), columns, **{"sharex": True, "sharey": True, **layout})
    return sheet, [(sheet.panel(n, title(*cell)), *cell) for n, cell in enumerate(cells)]


def page(width: float, height: float, *, bottom: float, top: float) -> tuple[Sheet, Panel]:
    """A figure for text without axes: x from 0 to 1, y between two limits."""
    margins: Look = dict.fromkeys(("left", "right", "top", "bottom"), 0.03)
    sheet = Sheet(width=width, height=height, **margins)
    panel = sheet.panel(title=None)
    panel.axis.set_axis_off()
    panel.axis.set(xlim=(0, 1), ylim=(bottom, top))
    return sheet, panel


def sentences(lines: str) -> Sheet:
    """A figure of text: why there is nothing to draw."""
    sheet, panel = page(SINGLE_COLUMN_IN, 0.14 * (lines.count("\n") + 1), bottom=0, top=1)
    look: Look = {"va": "top", "fontsize": 7, "linespacing": 1.3, "parse_math": False}
    panel.axis.text(0, 1, lines, **look)
    return sheet


def table_page(
    width: float, count: int, row_in: Any, head_in: float, notes: Sequence[str]
) -> tuple[Sheet, Panel, Callable[..., None]]:
    """A figure that is a table, with lines above and below its head and its rows.

    Args:
        width: Of the figure.
        count: Number of rows.
        row_in: Height of a row, or of each.
        head_in: Height of the head.
        notes: Below the table; they are wrapped.

    Returns:
        Figure, panel, and a function that writes a column: place from 0 to 1 of the width, head,
        texts of the rows, keywords of the head and of all.
    """
    heights = np.broadcast_to(row_in, count)
    letters = round(width / _SMALL_LETTER_IN)
    small = [line for note in notes for line in textwrap.wrap(note, letters)]
    table_in = head_in + heights.sum()
    height_in = table_in + 0.08 + 0.1 * len(small)
    sheet, panel = page(width, height_in, bottom=height_in, top=0)

    def write(
        x: float, head: str, texts: Iterable[str], head_look: Look | None = None, **look: Any
    ) -> None:
        # all cells alike: with line spacings of their own they are at different heights
        look = {"va": "center", "fontsize": 7, "parse_math": False, **look}
        panel.axis.text(x, head_in / 2, head, **look | (head_look or {}))
        for y, text in zip(head_in + heights.cumsum() - heights / 2, texts, strict=False):
            panel.axis.text(x, y, text, **look)

    for edge in (0.0, head_in, table_in):
        panel.axis.axhline(edge, color="black", linewidth=0.6)
    below: Look = {"va": "bottom", "fontsize": 6, "linespacing": 1.15, "parse_math": False}
    panel.axis.text(0, height_in, "\n".join(small), color=GREY, **below)
    return sheet, panel, write


def save(figure: Figure, *paths: Path) -> None:
    """Write a figure as PNG or SVG, the same bytes each time, whole or not at all.

    A PNG has a palette: that makes it a third in size.
    """
    dpi = mpl.rcParams["savefig.dpi"]
    figure.set_dpi(dpi)
    for path in paths:
        with atomic_file(path) as aside:
            # `Figure.savefig` would draw the figure twice
            if path.suffix == ".png":
                canvas: Any = FigureCanvasAgg(figure)
                canvas.draw()
                image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
                # ten times as fast as the median cut
                image = image.quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
                image.save(aside, "PNG", dpi=(dpi, dpi))
            else:
                text = io.StringIO()
                canvas = FigureCanvasSVG(figure)
                canvas.print_svg(text, metadata={"Date": None})
                aside.write_text(_with_stable_clips(text.getvalue()), encoding="utf-8")


def _with_stable_clips(svg: str) -> str:
    """Clipping paths named after what is written of them.

    Matplotlib names them after all digits of their positions, of which the last depends on the
    version of Python.
    """
    names: dict[str, str] = {}
    for whole, name, content in _CLIP.findall(svg):
        stable = f"p{sha256(content.encode()).hexdigest()[:10]}"
        if stable in names.values():  # two that differ in no digit that is written
            svg = svg.replace(whole, "", 1)
        names[name] = stable
    return re.sub(r"\bp[0-9a-f]{10}\b", lambda found: names.get(found[0], found[0]), svg)


# From the campaign's tables and settings, and reference files by name, to the figure.
Draw = Callable[..., Sheet]
SIMULATED = "SIMULATED"


def register(**declared: Any) -> Callable[[Draw], Draw]:
    """Declare the figure that a function draws.

    Args:
        declared: Attributes of `FigureDeclaration`; `oilfilm.base.figure_catalogue` reads them
            from the source.
    """
    return lambda draw: draw


def draw_figure(
    name: str, results: CampaignTables, settings: Settings, references: Mapping[str, Any]
) -> tuple[Figure, pd.DataFrame]:
    """A figure, which says whether its data are simulated, and the table of what it draws.

    Args:
        name: Name of the figure.
        results: Tables that it is drawn from.
        settings: Settings that it depends on.
        references: Content of reference files by name.

    Raises:
        KeyError: There is no such figure.
    """
    declared = figures()[name]
    draw: Draw = getattr(import_module(declared.module), declared.name.replace("-", "_"))
    shown = {reference: references[reference] for reference in declared.references}
    try:
        sheet = draw(results, settings, **shown)
    except NothingToDrawError as reason:
        sheet = sentences(str(reason))
    simulated = declared.shows_data and settings.campaign.data == "simulated"
    return sheet.finish(SIMULATED if simulated else ""), sheet.drawn()


def draw_figures(
    files: Iterable[tuple[str, str, str]],
    results: CampaignTables,
    settings: Settings,
    references: Mapping[str, Any],
    provenance: Mapping[str, Any],
) -> None:
    """Draw figures and write exactly what each shows as a table.

    Args:
        files: PNG, SVG and table of each figure; the PNG's name is that of the figure.
        results: Tables that the figures are drawn from.
        settings: Settings that the figures depend on.
        references: Content of reference files by name.
        provenance: As `tables.write`.
    """
    for png, svg, drawn_file in files:
        figure, drawn = draw_figure(Path(png).stem, results, settings, references)
        # what x and y are, with their units
        panels = {
            str(axes.get_label()): {"title": axes.get_title("left")}
            | {"x": axes.get_xlabel(), "y": axes.get_ylabel()}
            for axes in figure.axes
            if axes.get_label() != _COLOUR_BAR
        }
        tables.write(drawn, "drawn", Path(drawn_file), {**provenance, "panels": panels})
        save(figure, Path(png), Path(svg))
