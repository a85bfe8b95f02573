"""What the docs name exists, what is generated is current, and notebooks print what they store.

Pages show a study as their example. They are those of the whole repository.
"""

import ast
import json
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from campaigns import needs_study
from nights import quick_ones
from notebooks import FOLDER, execute, texts
from page_blocks import blocks
from reference_pages import GENERATED

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "tests/README.md"]
# Folders that a run or a user fills.
NOT_TRACKED = (
    *("data/first_seen", "data/raw/", "docs/_build/", "results/", "figures/", "parts/", "tables/"),
    *(".venv", ".snakemake/", "config/campaigns/june", "config/campaigns/etm.yaml"),
    *("config/rigs/my", "tribology/", "kg/m³"),
)


def named_paths(text: str) -> set[str]:
    """Paths in backticks and targets of links."""
    code = re.findall(r"`([\w.-]+(?:/[\w.-]+)+/?)`", text)
    return set(code) | {link.split("#")[0] for link in re.findall(r"\]\(([^):]+)\)", text)}


@needs_study
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_that_a_page_names_exist(page: Path):
    folders = (ROOT, page.parent, ROOT / "workflow/oilfilm")
    paths = {path for path in named_paths(page.read_text("utf-8")) if path}
    missing = [
        path
        for path in sorted(paths)
        if not path.startswith(NOT_TRACKED)
        # NAME is any name
        if not any(any(folder.glob(path.replace("NAME", "*"))) for folder in folders)
    ]
    assert not missing


# Files that a reader of the page writes.
OF_READERS = {"june.yaml", "my_torque.py"}
FOLDERS = ("benchmarks", "config", "data/reference", "docs", "tests", "workflow")
FILES = {path.name for folder in FOLDERS for path in (ROOT / folder).rglob("*.*")}
FILES |= {path.name for path in ROOT.glob("*.*")}


@needs_study
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_source_files_that_a_page_names_without_a_folder_exist(page: Path) -> None:
    named = re.findall(r"`([\w.-]+\.(?:py|smk|jinja|toml|yaml))`", page.read_text("utf-8"))
    assert {*named} - FILES - OF_READERS == set()


# The files behind the ways are traced on a campaign that runs to its report.
WAYS = "docs/explanation/ways.md"


@pytest.mark.slow
@pytest.mark.parametrize("path", quick_ones(GENERATED, {*GENERATED} - {WAYS}))
def test_generated_file_is_current(path: str) -> None:
    assert (ROOT / path).read_text("utf-8") == GENERATED[path](), "run `make schemas`"


@pytest.mark.slow
@needs_study
@pytest.mark.parametrize(
    "name", quick_ones(sorted(path.stem for path in FOLDER.glob("*.ipynb")), ["first-curve"])
)
def test_notebook_prints_what_it_stores(name: str) -> None:
    path = FOLDER / f"{name}.ipynb"
    stored = json.loads(path.read_text(encoding="utf-8"))
    assert texts(execute(path)) == texts(stored), "run `make notebooks`"


# ---------------------------------------------------------------- public names

OURS = ("oilfilm", "simulated_lab", "deng2026_study")


def inner_names(code: str) -> Iterator[str]:
    """Names of our packages that a program uses and that completion does not offer."""
    for node in ast.walk(ast.parse(code)):
        match node:
            case ast.Import(names=names):
                used = [name.name for name in names if "." in name.name]
            case ast.ImportFrom(module=str(module), names=names):
                used = [f"{module}.{name.name}" for name in names]
            case ast.Attribute(value=ast.Name(id=package), attr=name):
                used = [f"{package}.{name}"]
            case _:
                continue
        for name in used:
            package, _, member = name.partition(".")
            if package in OURS and member not in getattr(import_module(package), "__all__", ()):
                yield name


PROGRAMS = {
    path.name: "\n".join(
        "".join(cell["source"])
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]
        if cell["cell_type"] == "code"
    )
    for path in FOLDER.glob("*.ipynb")
} | {
    f"{block.page} {number}": block.content
    for number, block in enumerate(blocks())
    if block.language == "python" and ">>>" not in block.content
}


@needs_study
@pytest.mark.parametrize("name", PROGRAMS)
def test_notebooks_and_pages_use_public_names_only(name: str) -> None:
    assert list(inner_names(PROGRAMS[name])) == []


def test_an_inner_name_is_found() -> None:
    code = "import oilfilm.fits\nfrom oilfilm.base import home\noilfilm.fit()\noilfilm.logs"
    assert sorted(inner_names(code)) == ["oilfilm.base.home", "oilfilm.fits", "oilfilm.logs"]
