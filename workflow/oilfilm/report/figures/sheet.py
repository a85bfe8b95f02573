"""A figure: lettered panels on a grid in inches, a legend below them, and the drawn values as rows.

A figure is a function with the decorator `declare_figure`. The function's name is that of the
figure and of its table.

Positions follow from sizes in inches alone. A layout solver would measure texts, and the last bits
of such sizes differ from machine to machine.

Decides: what is kept of what a figure draws.
"""

import io
import itertools
import math
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
from oilfilm.base.units import IndexArray
from oilfilm.report.figures.style import DOUBLE_COLUMN_IN, GREY, SINGLE_COLUMN_IN, Look, plain_text
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# Room around and between panels (in), as `Sheet` describes it.
_ROOM_IN = {"left": 0.62, "right": 0.1, "top": 0.22, "bottom": 0.4, "across": 0.15, "down": 0.27}
_CORNER_TEXT_IN = 0.14  # height of the line with the text of simulated data
_LEGEND_LINE_IN = 0.155  # height of a line of a legend
_LEGEND_SYMBOL_IN = 0.42  # width of a symbol of a legend with its gaps
_LEGEND_LETTER_IN = 0.061  # width of a letter of a legend
_NOTE_LETTER_IN = 0.049  # width of a letter of notes
_COLOUR_BAR = "<colorbar>"
_CLIP_PATH = re.compile(r'(  <clipPath id="(p\w+)">\n(.*?)  </clipPath>\n)', re.DOTALL)


class Panel:
    """A panel of a figure; what it draws is kept as rows of the table `drawn`."""

    def __init__(self, axes: Axes, letter: str, drawn_parts: list[dict[str, Any]]) -> None:
        """Take the axes.

        Args:
            axes: Axes of the panel.
            letter: Letter of the panel; may be empty.
            drawn_parts: Receives a part of the table `drawn` for each call of `record`: arrays by
                column.
        """
        self.axes = axes
        self.letter = letter
        self.drawn_parts = drawn_parts

    def record(self, series_name: Any, x: Any, y: Any = np.nan, **details: Any) -> None:
        """Keep lines or symbols as rows of the table `drawn`, without drawing them.

        Each argument is an array over the points, or one value for all of them.

        Args:
            series_name: Name of the line or of the symbols, as `measured`.
            x: Abscissa.
            y: Ordinate.
            details: `oil`; `label`, which is drawn beside the symbol or distinguishes it (column
                `words`); `value`, which a colour or a number shows; `lower` and `upper` end of a
                bar or band (columns `y_lower` and `y_upper`); `panel`, a column of a table, in
                place of the panel's letter.
        """
        values_by_detail = {
            "panel": self.letter,
            "series": series_name,
            "oil": "",
            "label": "",
            "x": x,
            "y": y,
            "value": np.nan,
            "lower": np.nan,
            "upper": np.nan,
        }
        values_by_detail.update(details)
        arrays = [np.atleast_1d(np.asarray(values)) for values in values_by_detail.values()]
        drawn_arrays = np.broadcast_arrays(*arrays)
        self.drawn_parts.append(dict(zip(tables.columns("drawn"), drawn_arrays, strict=True)))

    def line(self, series_name: Any, x: Any, y: Any, look: Look, **details: Any) -> None:
        """Draw and keep a line, with a band from `lower` to `upper` where these are given."""
        self.axes.plot(x, y, **look)
        if "lower" in details:
            band: Look = {"color": look.get("color"), "alpha": 0.25, "linewidth": 0}
            self.axes.fill_between(x, details["lower"], details["upper"], **band)
        self.record(series_name, x, y, **details)

    def dots(self, series_name: Any, x: Any, y: Any, look: Look, **details: Any) -> None:
        """Draw and keep symbols, with bars from `lower` to `upper` where these are given."""
        look = {"linestyle": "", **look}
        if "lower" in details:
            ends = np.abs(np.asarray([y - details["lower"], details["upper"] - y]))
            self.axes.errorbar(x, y, yerr=ends, **look)
        else:
            self.axes.plot(x, y, **look)
        self.record(series_name, x, y, **details)

    def write_message(self, sentence: str, **look: Any) -> None:
        """Write in the middle of the panel why it is empty."""
        middle: Look = {"ha": "center", "va": "center", "transform": self.axes.transAxes}
        self.axes.text(0.5, 0.5, sentence, **middle, **look)


def _panel_letter(index: int) -> str:
    """The letter of a panel: a to z, A to Z, then aa, ab and so on.

    Examples:
        >>> [_panel_letter(index) for index in (0, 51, 52, 105)]
        ['a', 'Z', 'aa', 'bb']
    """
    round_number, place = divmod(index, len(string.ascii_letters))
    letter = string.ascii_letters[place]
    return _panel_letter(round_number - 1) + letter if round_number else letter


class Sheet:
    """A figure with its panels in reading order.

    Attributes:
        figure: Matplotlib's figure.
        axes_of_panels: Axes of the panels.
        heights: Height of the panels of each row, in inches.
        drawn_parts: A part of the table `drawn` for each call of `Panel.record`: arrays by column.
            Empty where nothing has been drawn.
    """

    def __init__(
        self,
        panel_count: int = 1,
        column_count: int = 1,
        *,
        width: float | None = None,
        height: float | Sequence[float] = 2.0,
        **layout: Any,
    ) -> None:
        """Place the panels.

        Args:
            panel_count: Number of panels.
            column_count: Number of panels side by side.
            width: Width of the figure (in). By default it is one column of a page where panels are
                not side by side, else two.
            height: Height of a panel (in), or that of the panels of each row.
            layout: `left` for the ordinate, `right` beside the last column, `top` for the titles,
                `bottom` for the abscissa, gaps `across` columns and `down` rows; and keywords of
                `Figure.subplots`.
        """
        self._room = {side: layout.pop(side, usual) for side, usual in _ROOM_IN.items()}
        row_count = math.ceil(panel_count / column_count)
        self.heights = [height] * row_count if isinstance(height, float | int) else list(height)
        self._width = width or (DOUBLE_COLUMN_IN if column_count > 1 else SINGLE_COLUMN_IN)
        self._column_count = column_count
        self._legend_height_in = 0.0
        self._colour_bar_axes: Axes | None = None
        # not by pyplot, which would keep every figure open
        self.figure = Figure()
        FigureCanvasAgg(self.figure)  # measures texts without a trial drawing
        grid = self.figure.subplots(
            row_count, column_count, squeeze=False, height_ratios=self.heights, **layout
        )
        all_axes = list(grid.flat)
        for axes in all_axes[panel_count:]:
            axes.remove()
        self.axes_of_panels = all_axes[:panel_count]
        for axes in all_axes[max(panel_count - column_count, 0) : panel_count]:
            axes.tick_params(labelbottom=True)
        self.drawn_parts: list[dict[str, Any]] = []

    def drawn(self) -> pd.DataFrame:
        """The table `drawn`, of what the panels have drawn so far."""
        if not self.drawn_parts:
            return tables.empty_table("drawn")
        values_by_column = {}
        for name in self.drawn_parts[0]:
            values_by_column[name] = np.concatenate(
                [columns_of_call[name] for columns_of_call in self.drawn_parts]
            )
        return tables.conform(pd.DataFrame(values_by_column), "drawn", "a figure")

    def panel(self, index: int = 0, title: str | None = "", **look: Any) -> Panel:
        """A panel, with its letter before its title; without a title it has no letter."""
        axes = self.axes_of_panels[index]
        letter = ""
        if title is not None:
            letter = _panel_letter(index)
            look.setdefault("parse_math", False)
            axes.set_title(f"({letter}) {plain_text(title)}".rstrip(), **look)
        axes.set_label(letter)
        return Panel(axes, letter, self.drawn_parts)

    def label_axes(self, x: str = "", y: str = "", **look: Any) -> None:
        """Name the abscissa and the ordinate of all panels.

        Only the lowest panels show the name of the abscissa, and only the leftmost ones that of the
        ordinate. The other names are in the file of the table `drawn`.

        Args:
            x: Name of the abscissa; unchanged if empty.
            y: Name of the ordinate; unchanged if empty.
            look: Properties of matplotlib's text, for the names.
        """
        for index, axes in enumerate(self.axes_of_panels):
            if x:
                axes.set_xlabel(x)
            if y:
                axes.set_ylabel(y)
            is_lowest = index + self._column_count >= len(self.axes_of_panels)
            is_leftmost = index % self._column_count == 0
            axes.xaxis.label.set(**look)
            axes.xaxis.label.set_visible(is_lowest)
            axes.yaxis.label.set(**look)
            axes.yaxis.label.set_visible(is_leftmost)

    def legend(self, handles: Sequence[Any], title: str = "", column_count: int = 0) -> None:
        """Explain colours, symbols and lines below the panels, where the legend covers no data.

        Args:
            handles: Entries of matplotlib's legend.
            title: Above the entries.
            column_count: Number of columns; if 0, as many as fit into the width.
        """
        lines_of_labels = [str(handle.get_label()).split("\n") for handle in handles] or [[""]]
        line_counts = np.array([len(lines) for lines in lines_of_labels])
        letter_counts = np.array([max(len(line) for line in lines) for lines in lines_of_labels])
        if not column_count:
            column_count = _legend_columns(letter_counts, self._width)
        line_counts_of_columns = [
            column.sum() for column in np.array_split(line_counts, column_count)
        ]
        line_count_of_title = title.count("\n") + 1 if title else 0
        self._legend_height_in = (
            _LEGEND_LINE_IN * (max(line_counts_of_columns) + line_count_of_title) + 0.06
        )
        self.figure.legend(
            handles=handles,
            loc="lower left",
            ncols=column_count,
            title=title or None,
            alignment="left",
            borderpad=0.2,
            borderaxespad=0.2,
            columnspacing=1.2,
            handletextpad=0.5,
        )

    def colour_bar(self, mappable: Any, label: str, **look: Any) -> Axes:
        """A colour bar at the right of all panels; `right` must leave room for it."""
        self._colour_bar_axes = self.figure.add_axes((0, 0, 0.1, 0.1), label=_COLOUR_BAR)
        colour_bar = self.figure.colorbar(mappable, cax=self._colour_bar_axes, **look)
        colour_bar.set_label(label, fontsize=7)
        self._colour_bar_axes.tick_params(labelsize=6)
        return self._colour_bar_axes

    def finish(self, corner_text: str = "") -> Figure:
        """Place everything and return the figure.

        Args:
            corner_text: Text in the upper right corner, as that of simulated data.
        """
        room = self._room
        width = self._width
        across = room["across"]
        down = room["down"]
        row_count = len(self.heights)
        column_count = self._column_count
        above = room["top"]
        if corner_text:
            above += _CORNER_TEXT_IN
        below = room["bottom"] + self._legend_height_in
        panels_height_in = sum(self.heights) + down * (row_count - 1)
        height = above + panels_height_in + below
        self.figure.set_size_inches(width, height)
        panel_width_in = (
            width - room["left"] - room["right"] - across * (column_count - 1)
        ) / column_count
        self.figure.subplots_adjust(
            left=room["left"] / width,
            right=1 - room["right"] / width,
            bottom=below / height,
            top=1 - above / height,
            wspace=across / panel_width_in,
            hspace=down * row_count / sum(self.heights),
        )
        if self._colour_bar_axes is not None:
            bar_left = 1 - (room["right"] - 0.1) / width
            bar_bottom = (below + 0.1 * panels_height_in) / height
            bar_width = 0.1 / width
            bar_height = 0.8 * panels_height_in / height
            self._colour_bar_axes.set_position((bar_left, bar_bottom, bar_width, bar_height))
        if corner_text:
            corner_look: Look = {"ha": "right", "va": "top", "fontsize": 6.5, "fontweight": "bold"}
            self.figure.text(
                1 - 0.03 / width, 1 - 0.02 / height, corner_text, color=GREY, **corner_look
            )
        return self.figure


def _legend_columns(letter_counts: IndexArray, width_in: float) -> int:
    """The largest number of columns of a legend that fits into a width; at least 1.

    Args:
        letter_counts: Length of each label.
        width_in: Width of the figure.
    """
    fitting_count = 1
    for column_count in range(1, len(letter_counts) + 1):
        # matplotlib fills one column after another; the first ones have one entry more
        longest_labels = [column.max() for column in np.array_split(letter_counts, column_count)]
        column_widths = [
            _LEGEND_SYMBOL_IN + _LEGEND_LETTER_IN * letter_count for letter_count in longest_labels
        ]
        if sum(column_widths) < width_in:
            fitting_count = column_count
    return fitting_count


class NothingToDrawError(Exception):
    """A figure has nothing to draw. The message gives the reason; it is drawn instead."""


def oil_grid(
    oils: Sequence[str],
    message_without_oils: str = "",
    rows: Sequence[Any] = ("",),
    title: Callable[[Any, str], str] = lambda _, oil: oil,
    **layout: Any,
) -> tuple[Sheet, list[tuple[Panel, Any, str]]]:
    """A figure with one column of panels per oil; a single row has at most three side by side.

    Args:
        oils: Oils that are shown.
        message_without_oils: The message where there is no oil.
        rows: What each row of panels shows: a level, or the name of a quantity.
        title: Function that gives the title of a panel from its row and oil.
        layout: As `Sheet`. All panels have the same axes unless `sharex` or `sharey` changes that.

    Returns:
        The figure, and each panel with its row and oil.

    Raises:
        NothingToDrawError: There is no oil.
    """
    if not oils:
        raise NothingToDrawError(message_without_oils)
    cells = list(itertools.product(rows, oils))
    column_count = len(oils) if len(rows) > 1 else min(len(oils), 3)
    layout.setdefault("sharex", True)
    layout.setdefault("sharey", True)
    sheet = Sheet(len(cells), column_count, **layout)
    panels = []
    for index, (row, oil) in enumerate(cells):
        panels.append((sheet.panel(index, title(row, oil)), row, oil))
    return sheet, panels


def blank_page(width: float, height: float, *, bottom: float, top: float) -> tuple[Sheet, Panel]:
    """A figure for text without axes: x from 0 to 1, y between two limits."""
    margins: Look = dict.fromkeys(("left", "right", "top", "bottom"), 0.03)
    sheet = Sheet(width=width, height=height, **margins)
    panel = sheet.panel(title=None)
    panel.axes.set_axis_off()
    panel.axes.set(xlim=(0, 1), ylim=(bottom, top))
    return sheet, panel


def text_figure(text: str) -> Sheet:
    """A figure of text alone, which explains why there is nothing to draw."""
    sheet, panel = blank_page(SINGLE_COLUMN_IN, 0.14 * (text.count("\n") + 1), bottom=0, top=1)
    look: Look = {"va": "top", "fontsize": 7, "linespacing": 1.3, "parse_math": False}
    panel.axes.text(0, 1, text, **look)
    return sheet


def table_page(
    width: float, row_count: int, row_in: Any, head_in: float, notes: Sequence[str]
) -> tuple[Sheet, Panel, Callable[..., None]]:
    """A figure that is a table, with lines above and below its head and its rows.

    Args:
        width: Width of the figure (in).
        row_count: Number of rows.
        row_in: Height of the rows (in): one number, or one per row.
        head_in: Height of the head (in).
        notes: Texts below the table; they are wrapped.

    Returns:
        Figure, panel, and a function that writes a column. Its arguments: position from 0 to 1 of
        the width, head, a text for each row, keywords of the head alone, keywords of all texts.
    """
    heights = np.broadcast_to(row_in, row_count)
    letters_per_line = round(width / _NOTE_LETTER_IN)
    note_lines = [line for note in notes for line in textwrap.wrap(note, letters_per_line)]
    table_in = head_in + heights.sum()
    height_in = table_in + 0.08 + 0.1 * len(note_lines)
    sheet, panel = blank_page(width, height_in, bottom=height_in, top=0)

    def write(
        x: float, head: str, texts: Iterable[str], head_look: Look | None = None, **look: Any
    ) -> None:
        # one line spacing for all cells: with different ones they are at different heights
        cell_look: Look = {"va": "center", "fontsize": 7, "parse_math": False}
        cell_look.update(look)
        panel.axes.text(x, head_in / 2, head, **cell_look | (head_look or {}))
        middles = head_in + heights.cumsum() - heights / 2
        for y, text in zip(middles, texts, strict=True):
            panel.axes.text(x, y, text, **cell_look)

    for edge in (0.0, head_in, table_in):
        panel.axes.axhline(edge, color="black", linewidth=0.6)
    note_look: Look = {"va": "bottom", "fontsize": 6, "linespacing": 1.15, "parse_math": False}
    panel.axes.text(0, height_in, "\n".join(note_lines), color=GREY, **note_look)
    return sheet, panel, write


def save(figure: Figure, *paths: Path) -> None:
    """Write a figure as PNG or SVG by the suffix of each path, completely or not at all.

    The same figure gives the same bytes.
    """
    figure.set_dpi(mpl.rcParams["savefig.dpi"])
    for path in paths:
        with atomic_file(path) as temporary:
            if path.suffix == ".png":
                _write_png(figure, temporary)
            else:
                _write_svg(figure, temporary)


def _write_png(figure: Figure, path: Path) -> None:
    """Write a PNG with a palette, which has a third of the bytes."""
    # `Figure.savefig` would draw the figure twice
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    # ten times as fast as the median cut
    image = image.quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    image.save(path, "PNG", dpi=(figure.dpi, figure.dpi))


def _write_svg(figure: Figure, path: Path) -> None:
    """Write an SVG without the date."""
    text = io.StringIO()
    canvas: Any = FigureCanvasSVG(figure)
    canvas.print_svg(text, metadata={"Date": None})
    path.write_text(_with_stable_clip_paths(text.getvalue()), encoding="utf-8")


def _with_stable_clip_paths(svg: str) -> str:
    """An SVG whose clipping paths have names that follow from their written positions.

    Matplotlib derives the names from all digits of the positions. The last digit depends on the
    version of Python.
    """
    stable_names: dict[str, str] = {}
    for element, name, content in _CLIP_PATH.findall(svg):
        stable_name = f"p{sha256(content.encode()).hexdigest()[:10]}"
        if stable_name in stable_names.values():
            # the same written positions: one path is enough
            svg = svg.replace(element, "", 1)
        stable_names[name] = stable_name

    def stable(match: re.Match[str]) -> str:
        """The name that depends on the path's content alone."""
        return stable_names.get(match[0], match[0])

    return re.sub(r"\bp[0-9a-f]{10}\b", stable, svg)


# A function that draws a figure from tables and settings, and reference files by name.
DrawFunction = Callable[..., Sheet]
SIMULATED = "SIMULATED"


def declare_figure(**declaration: Any) -> Callable[[DrawFunction], DrawFunction]:
    """Declare that a function draws a figure.

    Args:
        declaration: Attributes of `FigureDeclaration`; `oilfilm.base.figure_catalogue` reads them
            from the source.
    """
    return lambda draw: draw


def draw_figure(
    name: str, results: CampaignTables, settings: Settings, references: Mapping[str, Any]
) -> tuple[Figure, pd.DataFrame]:
    """Draw a figure, with `SIMULATED` in its corner if its data are simulated.

    Args:
        name: Name of the figure.
        results: Tables that it is drawn from.
        settings: Settings that it depends on.
        references: Content of reference files by name.

    Returns:
        The figure, and the table of what it shows.

    Raises:
        KeyError: There is no such figure.
    """
    declaration = figures()[name]
    draw: DrawFunction = getattr(
        import_module(declaration.module), declaration.name.replace("-", "_")
    )
    own_references = {reference: references[reference] for reference in declaration.references}
    try:
        sheet = draw(results, settings, **own_references)
    except NothingToDrawError as reason:
        sheet = text_figure(str(reason))
    is_simulated = declaration.shows_data and settings.campaign.data == "simulated"
    figure = sheet.finish(SIMULATED if is_simulated else "")
    return figure, sheet.drawn()


def draw_figures(
    files: Iterable[tuple[str, str, str]],
    results: CampaignTables,
    settings: Settings,
    references: Mapping[str, Any],
    provenance: Mapping[str, Any],
) -> None:
    """Draw figures, and write what each shows as a table.

    Args:
        files: PNG, SVG and table of each figure; the PNG's name is that of the figure.
        results: Tables that the figures are drawn from.
        settings: Settings that the figures depend on.
        references: Content of reference files by name.
        provenance: As `tables.write`.
    """
    for png, svg, drawn_file in files:
        figure, drawn = draw_figure(Path(png).stem, results, settings, references)
        # the table has x and y of all panels: the names of the axes have the units
        panel_texts = {}
        for axes in figure.axes:
            letter = str(axes.get_label())
            if letter != _COLOUR_BAR:
                panel_texts[letter] = {
                    "title": axes.get_title("left"),
                    "x": axes.get_xlabel(),
                    "y": axes.get_ylabel(),
                }
        tables.write(drawn, "drawn", Path(drawn_file), {**provenance, "panels": panel_texts})
        save(figure, Path(png), Path(svg))
