"""What each figure declares: name, caption, tables and settings, read without importing it.

A figure is declared once, by the function that draws it. Its name is that of the function, with
hyphens; the first line of its docstring is its title, and the rest its caption; `@register(...)`
has the other attributes. The Snakefile and the settings need the declarations of all figures
whenever the Snakefile is parsed. Importing the functions would import matplotlib (0.5 s); reading
their source takes 0.05 s.

Decides: which figures exist, and what each declares.
"""

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from oilfilm import studies

_LIBRARY = Path(__file__).parent
_CATEGORIES = {"data": "Data quality", "law": "Fits", "bearing": "Bearing"}


@dataclass(frozen=True)
class FigureDeclaration:
    """One figure: what it is called, what it shows and what it needs.

    A declaration may begin with the attributes of another one: `like="torque"`. Its own
    paragraphs then replace as many of the other one's caption, from the first on; the rest stays.

    Attributes:
        name: Name in campaign files and of its files.
        title: A few words.
        paragraphs: What is drawn, with units.
        module: Module of its function.
        family: Figures of one family are drawn by one job, because imports take longer than
            drawing.
        tables: Finished tables that it is drawn from.
        settings: Settings that it depends on; `campaign.matrix` is a key of the campaign file.
        references: Files of reference data that it shows, without ending.
        paper: Its counterpart in the paper, as "Fig. 2"; empty where the paper has none.
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
    paper: str = ""
    shows_data: bool = True
    requires: str = ""

    @property
    def category(self) -> str:
        """Section of the report; every counterpart of the paper is in "Paper"."""
        return "Paper" if self.paper else _CATEGORIES[self.family]

    @property
    def caption(self) -> str:
        """What is drawn; `report.captions` adds where the data are from."""
        return " ".join(self.paragraphs)

    @property
    def study(self) -> str:
        """The study that it belongs to; empty where every campaign may have it."""
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
    declared: dict[str, FigureDeclaration] = {}
    folders = (studies.folder(name) / "figures" for name in studies.available())
    for folder in (_LIBRARY / "report/figures", *folders):
        for path in sorted(folder.glob("*.py")):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.FunctionDef) and node.decorator_list:
                    name = node.name.replace("_", "-")
                    declared[name] = _declaration(name, node, path, declared)
    return declared


def families(names: Iterable[str]) -> dict[str, list[FigureDeclaration]]:
    """The named figures by family, in their order."""
    grouped: dict[str, list[FigureDeclaration]] = {}
    for name in names:
        figure = figures()[name]
        grouped.setdefault(figure.family, []).append(figure)
    return grouped


def _declaration(
    name: str, function: ast.FunctionDef, path: Path, declared: Mapping[str, FigureDeclaration]
) -> FigureDeclaration:
    (decorator,) = function.decorator_list
    keys = {each.arg: ast.literal_eval(each.value) for each in decorator.keywords}  # type: ignore[attr-defined]
    title, *own = (" ".join(part.split()) for part in ast.get_docstring(function).split("\n\n"))  # type: ignore[union-attr]
    other = keys.pop("like", None)
    inherited = vars(declared[other]) if other else {"paragraphs": ()}
    keys["paragraphs"] = (*own, *inherited["paragraphs"][len(own) :])
    keys["module"] = ".".join(path.relative_to(studies.PACKAGES).with_suffix("").parts)
    return FigureDeclaration(**{**inherited, **keys, "name": name, "title": title.rstrip(".")})
