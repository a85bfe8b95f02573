"""The explorer's empty chart: axes and glyphs, which `page.js` fills."""

import json
import re
from collections.abc import Sequence
from importlib.metadata import files
from typing import Any

from bokeh.embed import json_item
from bokeh.models import BoxAnnotation, ColumnDataSource, HoverTool, Range1d, Span
from bokeh.plotting import figure
from bokeh.resources import Resources
from markupsafe import Markup

from oilfilm.report.colours import EXTRAPOLATED

_MARKERS = ("circle", "square", "triangle", "diamond", "inverted_triangle", "plus")
_DASHES = ("solid", "dashed", "dotdash", "dotted", "dashdot", "solid")
_HEIGHT_PX = 420
# Bokeh escapes what it puts in for @names, which is text of a log.
_TOOLTIP = """
<div style="color: #1b1f24; max-width: 22rem; overflow-wrap: anywhere">
<b>@oil</b> @run<br>@at<br>μ @mu{0.00000}
</div>"""


def chart(colours: Sequence[str]) -> dict[str, Any]:
    """A chart with a band, a line and points for each colour, as BokehJS reads it.

    Its sources are named `curve0`, `points0`, ...; two boxes, `below` and `above`, shade what was
    never tested; the abscissa's range is `x`, the ordinate's `y`; `dots0` and `bars0` draw points.
    """
    plot = figure(
        height=_HEIGHT_PX,
        sizing_mode="stretch_width",
        toolbar_location=None,
        tools="",
        x_range=Range1d(0, 1, name="x"),
        y_range=Range1d(0, 1, name="y"),
        y_axis_label="Traction coefficient \N{GREEK SMALL LETTER MU}",
        name="chart",
    )
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.axis_label_text_font_size = plot.axis.major_label_text_font_size = "14px"
    for name in ("below", "above"):
        plot.add_layout(
            BoxAnnotation(
                name=name, left=0, right=0, fill_color=EXTRAPOLATED, fill_alpha=1, line_alpha=0,
                level="underlay", propagate_hover=True,
            )
        )  # fmt: skip
    sliders = Span(name="sliders", dimension="height", line_dash="dashed", line_color="#555555")
    plot.add_layout(sliders)
    curve = ("x", "mu", "lower", "upper")
    for number, colour in enumerate(colours):
        source = _empty(f"curve{number}", *curve)
        dash = _DASHES[number % len(_DASHES)]
        plot.varea("x", "lower", "upper", source=source, fill_color=colour, fill_alpha=0.25)
        plot.line("x", "mu", source=source, color=colour, line_width=2.5, line_dash=dash)
        source = _empty(f"points{number}", *curve, "run", "oil", "at")
        plot.segment("x", "lower", "x", "upper", source=source, color=colour, name=f"bars{number}")
        dots = plot.scatter(
            "x", "mu", source=source, marker=_MARKERS[number % len(_MARKERS)], size=8,
            line_color=colour, line_width=1.5, fill_color="white", name=f"dots{number}",
        )  # fmt: skip
        plot.add_tools(HoverTool(renderers=[dots], tooltips=_TOOLTIP))
    return _renumbered(json_item(plot))


def _empty(name: str, *columns: str) -> ColumnDataSource:
    return ColumnDataSource({column: [] for column in columns}, name=name)


def _renumbered(item: Any) -> dict[str, Any]:
    """The same with Bokeh's running numbers from 1: not what else the process has drawn."""
    text = json.dumps(item)
    order = dict.fromkeys(re.findall(r'"p\d+"', text))
    numbers = {name: f'"m{number}"' for number, name in enumerate(order, 1)}
    renumbered: dict[str, Any] = json.loads(
        re.sub(r'"p\d+"', lambda match: numbers[match.group()], text)
    )
    return renumbered


def library() -> Markup:
    """BokehJS as it is shipped with the Python package, without add-ons."""
    (script,) = Resources(mode="inline", components=["bokeh"], minified=True).js_raw[:1]
    return Markup(script)  # noqa: S704  (of a locked package)


def licence() -> str:
    """Licence of the library, which must stay with every copy of it."""
    path = next(path for path in files("bokeh") or () if path.match("licenses/LICENSE.txt"))
    return path.read_text()
