"""Benchmarks run by hand and rarely: what they take from the library must still be there."""

import ast
from importlib import import_module
from pathlib import Path
from runpy import run_path

import pytest

from campaigns import ROOT


@pytest.mark.parametrize(
    ("campaign", "seconds", "complaint"),
    [
        ("oils", {100: 10, 1000: 100, 10000: 1000}, ""),
        (
            "oils",
            {100: 10, 1000: 100, 10000: 1200},
            "Whole run: more than 10% above the line of smaller sizes.",
        ),
        (
            "oils",
            {100: 10, 1000: 100, 10000: 800},
            "Whole run: more than 10% off a straight line.",
        ),
        (
            "oils",
            {100: 49, 1000: 97, 3000: 226, 10000: 735},
            "Whole run: more than 10% above the line of smaller sizes.",
        ),
        ("one oil", {300: 10, 3000: 110}, ""),
        ("one oil", {300: 10, 3000: 130}, "One oil: more than 1.2 times linear growth."),
    ],
)
def test_benchmark_of_scale_complains_about_growth_beyond_its_limits(
    campaign: str, seconds: dict[int, float], complaint: str
) -> None:
    scale = run_path(str(ROOT / "benchmarks/scale.py"))
    rows = [
        scale["Row"]("0123456", campaign, runs, "whole run", "cpu_s", value)
        for runs, value in seconds.items()
    ]
    assert "".join(scale["complaints"](rows)) == complaint


@pytest.mark.parametrize("path", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda p: p.stem)
def test_benchmark_imports_what_the_library_has(path: Path) -> None:
    imports = [
        node
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("oilfilm")
    ]
    for node in imports:
        module = import_module(str(node.module))
        missing = [name.name for name in node.names if not hasattr(module, name.name)]
        assert not missing, node.module
