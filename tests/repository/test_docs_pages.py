"""The pages of the site, without building it: each is reachable, and generated ones are current."""

import ast
import re
from pathlib import Path

import pytest

from campaigns import ROOT
from reference_pages import GENERATED

DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "_build" not in path.parts)


def listed(page: Path) -> list[Path]:
    """The pages of the tables of contents of a page."""
    blocks = re.findall(r"```\{toctree\}\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
    names = [line for block in blocks for line in block.splitlines() if line and line[0] != ":"]
    return [(page.parent / name).resolve() for name in names]


def test_every_page_is_in_one_table_of_contents() -> None:
    names = [name for page in PAGES for name in listed(page)]
    assert len(names) == len(set(names))
    pages = {page.with_suffix("") for page in PAGES} - {DOCS / "index"}
    notebooks = {path.with_suffix("") for path in (DOCS / "notebooks").glob("*.ipynb")}
    assert set(names) == pages | notebooks


@pytest.mark.parametrize("path", GENERATED)
def test_generated_file_is_current(path: str) -> None:
    assert (ROOT / path).read_text("utf-8") == GENERATED[path](), "run `make schemas`"


def pictures() -> list[tuple[str, str, str]]:
    """Module and function, alternative text and caption of every picture."""
    found = []
    for page in PAGES:
        for name, content in re.findall(
            r"```\{picture\} (\S+)\n(.*?)```", page.read_text("utf-8"), re.DOTALL
        ):
            alt = re.search(r":alt: (.+)", content)
            found.append((name, alt[1] if alt else "", content.split("\n\n", 1)[-1].strip()))
    return found


def test_every_picture_is_drawn_and_has_caption_and_alternative_text() -> None:
    shown = pictures()
    assert len({name for name, *_ in shown}) >= 20
    assert all(alt and caption.endswith(".") for _, alt, caption in shown)
    functions = {
        f"{path.stem}.{node.name}"
        for path in (DOCS / "pictures").glob("*.py")
        for node in ast.parse(path.read_text("utf-8")).body
        if isinstance(node, ast.FunctionDef)
        and ast.unparse(node.returns or ast.Constant(0)) == "Figure"
    }
    assert {name for name, *_ in shown} == functions
