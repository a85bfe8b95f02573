"""How a figure registers itself, and how its name leads to it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.figure_catalogue import FigureDeclaration, figures
from oilfilm.report.facts import film_unjudged_oils
from oilfilm.report.figures import style
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import table
from oilfilm.tables.declaration import Column, Table

# From the campaign's tables and settings, and reference files by name, to the figure and to what it
# draws: parts of one table.
Drawing = tuple[Figure, Sequence[pd.DataFrame]]
Draw = Callable[..., Drawing]


@dataclass(frozen=True)
class RegisteredFigure:
    """A figure with its function.

    Attributes:
        declaration: Its name, captions and inputs.
        function: The function that draws it.
        table: Name of the model of the table of what it draws.
    """

    declaration: FigureDeclaration
    function: Draw
    table: str

    def draw(
        self, results: CampaignTables, settings: Settings, references: Mapping[str, Any]
    ) -> tuple[Figure, pd.DataFrame]:
        """The figure, which says where its data are from, and the table of what it draws."""
        shown = {name: references[name] for name in self.declaration.references}
        drawing, parts = self.function(results, settings, **shown)
        drawn = tables.empty(self.table)
        if parts:
            all_parts = pd.concat(parts, ignore_index=True)[tables.columns(self.table)]
            drawn = tables.conform(all_parts, self.table, f"figure {self.declaration.name}")
        if self.declaration.shows_data:
            unjudged = film_unjudged_oils(results.points)
            if "oil" in drawn:
                unjudged = [oil for oil in unjudged if (drawn["oil"] == oil).any()]
            style.say_source(drawing, settings.campaign, unjudged)
        return drawing, drawn


_DRAWN: dict[str, Table] = {}


def drawn_table(
    name: str,
    description: str,
    *,
    columns: str,
    uses: Sequence[Column] = (),
    key: Sequence[str] = (),
) -> str:
    """Declare the table of what a figure draws; the arguments are those of `columns.table`."""
    no_key = "" if key else "Rows are in the order of drawing; two marks may be the same."
    declared = table(name, description, columns=columns, uses=uses, key=tuple(key), no_key=no_key)
    tables.declare(declared)
    _DRAWN[name] = declared
    return name


def drawn_tables() -> list[Table]:
    """Tables of what the figures draw, in the order of their names; imports every figure."""
    for name in figures():
        load_figure(name)
    return [_DRAWN[name] for name in sorted(_DRAWN)]


_REGISTERED: dict[str, RegisteredFigure] = {}


def register(*, name: str, draws: str, **declared: Any) -> Callable[[Draw], Draw]:
    """Declare the figure that a function draws.

    The function returns the figure and the parts of the table of what it draws, none where there is
    nothing to draw.

    Args:
        name: Name of the figure.
        draws: Model of that table.
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
        registered = load_figure(Path(png).stem)
        drawing, drawn = registered.draw(results, settings, references)
        tables.write(drawn, registered.table, Path(drawn_file), provenance)
        style.save(drawing, Path(png), Path(svg))
