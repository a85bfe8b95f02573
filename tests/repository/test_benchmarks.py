"""Benchmarks and the pictures of the site run rarely: what they import must still be there."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

from campaigns import ROOT

RARE = sorted([*(ROOT / "benchmarks").glob("*.py"), *(ROOT / "docs/pictures").glob("*.py")])


@pytest.mark.parametrize("path", RARE, ids=lambda path: path.stem)
def test_what_rarely_runs_imports_what_the_library_has(path: Path) -> None:
    imports = [
        node
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("oilfilm")
    ]
    for node in imports:
        module = import_module(str(node.module))
        missing = [name.name for name in node.names if not hasattr(module, name.name)]
        assert not missing, node.module
