"""How a figure registers itself, and how it is found by its name."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.figure_catalogue import FigureDeclaration, figures
from oilfilm.outputs.figures import style
from oilfilm.tables.campaign_tables import CampaignTables

# From the campaign's tables and settings, and reference files by name, to the figure and to a table
# of exactly what it draws.
Draw = Callable[..., tuple[Figure, pd.DataFrame]]


@dataclass(frozen=True)
class RegisteredFigure:
    """A figure with its function.

    Attributes:
        declaration: Its name, captions and inputs.
        draw: From tables, settings and references to the figure and what it draws.
        table: Name of the model of the table of what it draws.
    """

    declaration: FigureDeclaration
    draw: Draw
    table: str


_REGISTERED: dict[str, RegisteredFigure] = {}


def register(*, name: str, draws: str, **declared: Any) -> Callable[[Draw], Draw]:
    """Declare the figure that a function draws.

    Args:
        name: Name of the figure.
        draws: Model of the table of what it draws.
        declared: The other attributes of `FigureDeclaration`, as literals: they are read from the
            source as well.
    """

    def keep(draw: Draw) -> Draw:
        declaration = FigureDeclaration(name, **declared, module=draw.__module__)
        _REGISTERED[name] = RegisteredFigure(declaration, draw, draws)
        return draw

    return keep


def load_figure(name: str) -> RegisteredFigure:
    """A figure by its name; its module is imported.

    Raises:
        KeyError: There is no such figure.
    """
    import_module(figures()[name].module)
    return _REGISTERED[name]


def draw_figures(
    files: Iterable[tuple[str, str, str]],
    results: CampaignTables,
    config: Mapping[str, Any],
    references: Mapping[str, Any],
    provenance: Mapping[str, Any],
) -> None:
    """Draw figures and write exactly what each shows as a table.

    Args:
        files: PNG, SVG and table of each figure; the PNG's name is that of the figure.
        results: Tables that the figures are drawn from.
        config: Settings that the figures depend on.
        references: Content of reference files by name.
        provenance: As `tables.write`.
    """
    for png, svg, table in files:
        registered = load_figure(Path(png).stem)
        shown = {name: references[name] for name in registered.declaration.references}
        drawing, drawn = registered.draw(results, config, **shown)
        tables.write(drawn, registered.table, Path(table), provenance)
        style.save(drawing, Path(png), Path(svg))
