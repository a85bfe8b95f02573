"""How a figure registers itself, and how its name leads to it and to the table of what it draws."""

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.figure_catalogue import figures
from oilfilm.report.figures.sheet import (
    NothingToDrawError,
    Sheet,
    panels_in_words,
    save,
    sentences,
)
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# From the campaign's tables and settings, and reference files by name, to the figure.
Draw = Callable[..., Sheet]
SIMULATED = "SIMULATED"


def register(**declared: Any) -> Callable[[Draw], Draw]:
    """Declare the figure that a function draws.

    Args:
        declared: Attributes of `FigureDeclaration`; `oilfilm.figure_catalogue` reads them from the
            source.
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
        footer = {**provenance, "panels": panels_in_words(figure)}
        tables.write(drawn, "drawn", Path(drawn_file), footer)
        save(figure, Path(png), Path(svg))
