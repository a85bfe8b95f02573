"""The pages of the site, without building it: each is reachable, and generated ones are current."""

import ast
import re
from importlib import import_module
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.cli.messages_page import sentences

DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "_build" not in path.parts)
# pages that are as long as what they list
GENERATED = {
    "reference/gates.md": "oilfilm.report.gates_page",
    "reference/messages.md": "oilfilm.cli.messages_page",
}


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


@pytest.mark.parametrize("page", GENERATED)
def test_generated_page_is_current(page: str) -> None:
    made = import_module(GENERATED[page]).page()
    assert (DOCS / page).read_text("utf-8") == made, "run `make schemas`"


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


def test_messages_are_those_that_gates_and_settings_raise() -> None:
    """Sentences written out here, which a user has met; placeholders have a name."""
    text = (DOCS / "reference/messages.md").read_text("utf-8").replace("\\", "")
    assert "the time stamp does not increase at <backward> rows" in text
    assert "the log ends in the middle of row <row>" in text
    assert "exists already" in text
    assert "there is no such campaign file" in text


def test_collector_sees_a_message_of_each_kind() -> None:
    source = '''
def gate(run):
    """A docstring is no message, however long it may be."""
    if run:
        raise OilfilmError(f"{path}: the sun {'does not' if x else 'does'} shine. Wait for it.")
    reason = "the oil is much too cold here"
    raise ValueError("a programmer reads this sentence alone")
    return Finding(f"row {row[0]}: the value is {value:.3f} K, too hot" + " for this oil")
'''
    found = list(sentences(ast.parse(source)))
    assert "the oil is much too cold here" in found
    assert "<path>: the sun does not/does shine. Wait for it." in found
    assert "row <row>: the value is <value> K, too hot for this oil" in found
    assert not [text for text in found if "docstring" in text or "programmer" in text]
