"""The declaration of each figure: name, caption, tables and settings, read without importing it.

A figure is declared once, by the function that draws it:

- its name is the name of the function, with hyphens;
- its title is the first line of the docstring, its caption the rest;
- `@declare_figure(...)` has the other attributes.

The Snakefile and the settings need all declarations whenever the Snakefile is parsed. Importing the
functions would import matplotlib (0.5 s). Reading their source takes 0.05 s.

Decides: which figures exist, and what each declares.
"""

import ast
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from oilfilm.base import studies

_LIBRARY_FOLDER = Path(__file__).parents[1]
# Section of Snakemake's report, by the family of a figure.
_CATEGORY_BY_FAMILY = {"data": "Data quality", "law": "Fits", "bearing": "Bearing"}


@dataclass(frozen=True)
class FigureDeclaration:
    """One figure: its name, its content and what it needs.

    A declaration may take over the attributes of another one: `like="torque"`. Its own paragraphs
    then replace the first paragraphs of the other caption. The remaining ones are kept.

    Attributes:
        name: Name of the figure in campaign files, and of the files of the figure.
        title: A few words.
        paragraphs: Paragraphs of the caption: what is drawn, with units.
        module: Module of the function that draws it.
        family: One job draws all figures of a family, because imports take longer than drawing.
        tables: Names of the finished tables with the drawn data.
        settings: Keys of the settings that it depends on; `campaign.matrix` is a key of the
            campaign file.
        references: Names of the files of reference data that it shows, without `.yaml`.
        counterpart: Its counterpart in the publication of a study, as "Fig. 2"; empty without one.
        shows_data: False where nothing comes from the campaign's logs.
        requires: Key of the campaign file without which there is nothing to draw.
    """

    name: str
    title: str
    paragraphs: tuple[str, ...]
    module: str
    family: str
    tables: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    references: tuple[str, ...] = ()
    counterpart: str = ""
    shows_data: bool = True
    requires: str = ""

    @property
    def category(self) -> str:
        """Section of Snakemake's report; figures after a publication have one of their own."""
        return (
            studies.publication(self.study)
            if self.counterpart
            else _CATEGORY_BY_FAMILY[self.family]
        )

    @property
    def caption(self) -> str:
        """What is drawn, and the figure of a publication that it is made after."""
        caption = " ".join(self.paragraphs)
        if not self.counterpart:
            return caption
        return f"{caption} Made after {self.counterpart} of {studies.publication(self.study)}."

    @property
    def full_title(self) -> str:
        """Title, after the number of its counterpart: "Fig. 2. Traction curves of one oil"."""
        return f"{self.counterpart}. {self.title}" if self.counterpart else self.title

    @property
    def study(self) -> str:
        """Name of the study that it belongs to; empty where every campaign may have it."""
        package = self.module.split(".")[0]
        return package if package in studies.available() else ""

    @property
    def source(self) -> Path:
        """File of its module."""
        return studies.PACKAGES / f"{self.module.replace('.', '/')}.py"


@cache
def figures() -> Mapping[str, FigureDeclaration]:
    """Every figure by name.

    Raises:
        ValueError: A declaration is not made of literals.
    """
    figure_by_name: dict[str, FigureDeclaration] = {}
    for module_file in _module_files_with_figures():
        for node in ast.parse(module_file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.decorator_list:
                name = node.name.replace("_", "-")
                figure_by_name[name] = _declaration(name, node, module_file, figure_by_name)
    return figure_by_name


def _module_files_with_figures() -> list[Path]:
    """Files of the modules that draw figures: those of the library first, then of the studies."""
    folders = [_LIBRARY_FOLDER / "report/figures"]
    folders += [studies.folder(study) / "figures" for study in studies.available()]
    module_files = []
    for folder in folders:
        module_files += sorted(folder.glob("*.py"))
    return module_files


def figures_by_family(figure_names: Iterable[str]) -> dict[str, list[FigureDeclaration]]:
    """The declarations of the named figures by their family, in the order of the names."""
    grouped_figures: dict[str, list[FigureDeclaration]] = {}
    for figure_name in figure_names:
        figure = figures()[figure_name]
        grouped_figures.setdefault(figure.family, []).append(figure)
    return grouped_figures


def _declaration(
    figure_name: str,
    function: ast.FunctionDef,
    module_file: Path,
    figure_by_name: Mapping[str, FigureDeclaration],
) -> FigureDeclaration:
    """The declaration of the figure that a function draws.

    `figure_by_name` has the declarations before it, for the keyword `like`.
    """
    (decorator,) = function.decorator_list
    keywords = decorator.keywords  # type: ignore[attr-defined]
    declared_attributes = {keyword.arg: ast.literal_eval(keyword.value) for keyword in keywords}
    docstring = ast.get_docstring(function) or ""
    title, *paragraphs = (" ".join(text.split()) for text in docstring.split("\n\n"))
    similar_name = declared_attributes.pop("like", None)
    attributes: dict[str, Any] = {}
    if similar_name:
        attributes = asdict(figure_by_name[similar_name])
        paragraphs += attributes["paragraphs"][len(paragraphs) :]
    attributes |= declared_attributes
    attributes["name"] = figure_name
    attributes["title"] = title.rstrip(".")
    attributes["paragraphs"] = tuple(paragraphs)
    attributes["module"] = ".".join(module_file.relative_to(studies.PACKAGES).with_suffix("").parts)
    return FigureDeclaration(**attributes)
