"""What the docs name exists."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "tests/README.md"]
# Folders that a run or a user fills.
NOT_TRACKED = (
    "data/first_seen",
    "docs/_build/",
    "results/",
    "data/raw/",
    "figures/",
    "parts/",
    "tables/",
    ".venv",
    ".snakemake/",
    "config/campaigns/june",
    "config/campaigns/etm.yaml",
    "config/rigs/my",
    "tribology/",
    "kg/m³",
)


def named_paths(text: str) -> set[str]:
    """Paths in backticks and targets of links."""
    code = re.findall(r"`([\w.-]+(?:/[\w.-]+)+/?)`", text)
    return set(code) | {link.split("#")[0] for link in re.findall(r"\]\(([^):]+)\)", text)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_that_a_page_names_exist(page: Path):
    folders = (ROOT, page.parent, ROOT / "workflow/oilfilm")
    paths = {path for path in named_paths(page.read_text("utf-8")) if path}
    missing = [
        path
        for path in sorted(paths)
        if not path.startswith(NOT_TRACKED)
        if not any((folder / path).exists() for folder in folders)
    ]
    assert not missing
