"""What each figure declares: name, captions, tables and settings, read without importing it.

A figure is declared once, by `@register(...)` above the function that draws it. The Snakefile and
the settings need the declarations of all figures whenever the Snakefile is parsed. Importing the
functions would import matplotlib (0.5 s); reading their source takes 0.05 s.

Decides: which figures exist, and what each declares.
"""

import ast
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from oilfilm import studies

_LIBRARY = Path(__file__).parent


@dataclass(frozen=True)
class FigureDeclaration:
    """One figure: what it is called, what it shows and what it needs.

    A declaration may begin with the keys of another one: `like="torque"`.

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
    folders = ("report/figures", *(f"{name}/figures" for name in studies.available()))
    declared: dict[str, dict[str, Any]] = {}
    for folder in folders:
        for path in sorted((_LIBRARY / folder).glob("*.py")):
            module = f"oilfilm.{folder.replace('/', '.')}.{path.stem}"
            for keys in _declarations(path):
                if keys["name"] in declared:
                    raise ValueError(f"two figures have the name {keys['name']!r}")
                inherited = declared.get(keys.pop("like", ""), {})
                declared[keys["name"]] = {**inherited, **keys, "module": module}
    return {name: FigureDeclaration(**keys) for name, keys in declared.items()}


def families(names: Iterable[str]) -> dict[str, list[FigureDeclaration]]:
    """The named figures by family, in their order."""
    grouped: dict[str, list[FigureDeclaration]] = {}
    for name in names:
        figure = figures()[name]
        grouped.setdefault(figure.family, []).append(figure)
    return grouped


def _declarations(path: Path) -> Iterator[dict[str, Any]]:
    """The keys of each `@register(...)` of a module, in its order."""
    constants: dict[str, Any] = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            with suppress(ValueError):
                constants[node.targets[0].id] = ast.literal_eval(node.value)
        calls = list(getattr(node, "decorator_list", []))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            calls.append(node.value.func)  # register(...)(function of another module)
        for decorator in calls:
            if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "register":
                try:
                    yield _keys(decorator, constants)
                except (KeyError, ValueError) as error:
                    raise ValueError(
                        f"{path}, line {decorator.lineno}: {error}; write literals, or constants "
                        "of the module"
                    ) from error


def _keys(call: ast.Call, constants: Mapping[str, Any]) -> dict[str, Any]:
    keys: dict[str, Any] = {}
    for keyword in call.keywords:
        value = _value(keyword.value, constants)
        keys |= {keyword.arg: value} if keyword.arg else value
    return keys


def _value(node: ast.expr, constants: Mapping[str, Any]) -> Any:
    if isinstance(node, ast.Name):
        return constants[node.id]
    if isinstance(node, ast.BinOp):
        return _value(node.left, constants) + _value(node.right, constants)
    return ast.literal_eval(node)
