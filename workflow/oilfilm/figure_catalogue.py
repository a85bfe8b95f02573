"""What each figure declares: name, captions, tables and settings, read without importing it.

A figure is declared once, by `@register(...)` above the function that draws it. The Snakefile and
the settings need the declarations of all figures whenever the Snakefile is parsed. Importing the
functions would import matplotlib (0.5 s); reading their source takes 0.05 s.
"""

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

from oilfilm import studies

_LIBRARY = Path(__file__).parent


@dataclass(frozen=True)
class FigureDeclaration:
    """One figure: what it is called, what it shows and what it needs.

    Attributes:
        name: Name in campaign files and of its files.
        title: A few words.
        caption: What is drawn, with units; `provenance` adds where the data are from.
        family: Figures of one family are drawn by one job, because imports take longer than
            drawing.
        category: Section of the report; every counterpart of the paper is in "Paper".
        tables: Finished tables that it is drawn from.
        settings: Settings that it depends on; `campaign.matrix` is a key of the campaign file.
        references: Files of data/reference that it shows, without ending.
        paper: Its counterpart in the paper, as "Fig. 2"; empty where the paper has none.
        shows_data: False where nothing comes from the campaign's logs.
        requires: Key of the campaign file without which there is nothing to draw.
        compares_laws: True where laws are shown side by side.
        module: Module of its function.
    """

    name: str
    title: str
    caption: str
    family: str
    category: str = "Paper"
    tables: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    references: tuple[str, ...] = ()
    paper: str = ""
    shows_data: bool = True
    requires: str = ""
    compares_laws: bool = False
    module: str = ""

    @property
    def numbered_title(self) -> str:
        """The title with the paper's number before it, where it has one."""
        return f"{self.paper.rstrip('.')}. {self.title}" if self.paper else self.title

    @property
    def study(self) -> str:
        """The study that it belongs to; empty where every campaign may have it."""
        room = self.module.split(".")[1]
        return room if room in studies.available() else ""

    @property
    def source(self) -> Path:
        """File of its module."""
        return _LIBRARY.parent / f"{self.module.replace('.', '/')}.py"


@cache
def figures() -> Mapping[str, FigureDeclaration]:
    """Every figure by name.

    Raises:
        ValueError: A declaration is not made of literals, or two figures have one name.
    """
    declared = [
        FigureDeclaration(
            **_literals(call, path),
            module=f"oilfilm.{folder.replace('/', '.')}.{path.stem}",
        )
        for folder in ("report/figures", *(f"{name}/figures" for name in studies.available()))
        for path in sorted((_LIBRARY / folder).glob("*.py"))
        for call in _declarations(path)
    ]
    by_name = {figure.name: figure for figure in declared}
    if len(by_name) < len(declared):
        raise ValueError(f"two figures have one name: {sorted(f.name for f in declared)}")
    return by_name


def families(names: Iterable[str]) -> dict[str, list[FigureDeclaration]]:
    """The named figures by family, in their order."""
    grouped: dict[str, list[FigureDeclaration]] = {}
    for name in names:
        figure = figures()[name]
        grouped.setdefault(figure.family, []).append(figure)
    return grouped


def _declarations(path: Path) -> Iterable[ast.Call]:
    """The `@register(...)` calls of a module, in its order."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        for decorator in getattr(node, "decorator_list", []):
            if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "register":
                yield decorator


def _literals(call: ast.Call, path: Path) -> dict[str, Any]:
    known = {field.name for field in fields(FigureDeclaration)}
    try:
        return {
            str(keyword.arg): ast.literal_eval(keyword.value)
            for keyword in call.keywords
            if keyword.arg in known
        }
    except ValueError as error:
        raise ValueError(f"{path}, line {call.lineno}: {error}; write literals only") from error
