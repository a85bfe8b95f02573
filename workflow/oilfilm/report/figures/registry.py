"""How a figure registers itself, how its name leads to it, and the table of what it draws.

Decides: what is kept of what a figure draws.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.figure_catalogue import figures
from oilfilm.report.captions import film_unjudged_oils
from oilfilm.report.figures import style
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# From the campaign's tables and settings, and reference files by name, to the figure and to what it
# draws: parts made by `marks`.
Drawing = tuple[Figure, Sequence[pd.DataFrame]]
Draw = Callable[..., Drawing]


def marks(
    panel: Any,
    series: Any,
    x: Any,
    y: Any = np.nan,
    *,
    oil: Any = "",
    label: Any = "",
    value: Any = np.nan,
    lower: Any = np.nan,
    upper: Any = np.nan,
) -> pd.DataFrame:
    """Rows of the table `drawn`: arrays as long as the marks, or one value for all.

    Args:
        panel: Letter of the panel; of a table that is drawn, its column.
        series: Which line, symbol or row of the panel.
        x: Abscissa.
        y: Ordinate.
        oil: Oil; empty where it is of none.
        label: Text that is drawn there, or what tells the mark apart.
        value: What a colour or a number shows.
        lower: Lower end of a bar or band.
        upper: Its upper end.
    """
    given = (panel, series, oil, label, x, y, value, lower, upper)
    arrays = np.broadcast_arrays(*map(np.atleast_1d, map(np.asarray, given)))
    return pd.DataFrame(dict(zip(tables.columns("drawn"), arrays, strict=True)))


_FUNCTIONS: dict[str, Draw] = {}


def register(*, name: str, **declared: Any) -> Callable[[Draw], Draw]:
    """Declare the figure that a function draws.

    The function returns the figure and the parts of the table of what it draws, none where there is
    nothing to draw.

    Args:
        name: Name of the figure.
        declared: The other attributes of `FigureDeclaration`; `oilfilm.figure_catalogue` reads them
            from the source.
    """

    def keep(draw: Draw) -> Draw:
        _FUNCTIONS[name] = draw
        return draw

    return keep


def draw_figure(
    name: str, results: CampaignTables, settings: Settings, references: Mapping[str, Any]
) -> tuple[Figure, pd.DataFrame]:
    """A figure, which says where its data are from, and the table of what it draws.

    Args:
        name: Name of the figure.
        results: Tables that it is drawn from.
        settings: Settings that it depends on.
        references: Content of reference files by name.

    Raises:
        KeyError: There is no such figure.
    """
    declared = figures()[name]
    import_module(declared.module)
    shown = {reference: references[reference] for reference in declared.references}
    drawing, parts = _FUNCTIONS[name](results, settings, **shown)
    drawn = tables.empty("drawn")
    if parts:
        drawn = tables.conform(pd.concat(parts, ignore_index=True), "drawn", f"figure {name}")
    if declared.shows_data:
        unjudged = film_unjudged_oils(results.points)
        if named := set(drawn["oil"]) - {""}:
            unjudged = [oil for oil in unjudged if oil in named]
        style.say_source(drawing, settings.campaign, unjudged)
    return drawing, drawn


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
        drawing, drawn = draw_figure(Path(png).stem, results, settings, references)
        footer = {**provenance, "panels": style.panels_in_words(drawing)}
        tables.write(drawn, "drawn", Path(drawn_file), footer)
        style.save(drawing, Path(png), Path(svg))
