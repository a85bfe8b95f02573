"""Benchmarks run by hand and rarely: what they take from the library must still be there."""

import ast
from importlib import import_module
from pathlib import Path
from runpy import run_path

import pytest

from campaigns import ROOT


def test_small_benchmark_of_ingest_gives_each_process_a_share(tmp_path: Path) -> None:
    ingest = run_path(str(ROOT / "benchmarks/ingest.py"))
    for number in range(40):
        (tmp_path / f"run{number}.csv").touch()
    assert len(ingest["shares_in"](tmp_path)) == ingest["CORES"]


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


@pytest.mark.parametrize(
    ("seconds", "told"),
    [
        ({100: 20}, ["| `whole run` | 20 |  |  |"]),
        (
            # 10 s and 0.1 s per run, but 5 s less at 100 runs
            {100: 15, 1000: 110, 3000: 310, 10000: 1010},
            [
                "| `whole run` | 15 | 110 | 310 | 1.01e+03 | +0% | 1e+05 |",
                "10,000 runs are +0.0% off the line through 1,000 and 3,000 runs; allowed +10%.",
                "They are -4.7% off the line through 100 and 1,000 runs; allowed +10%.",
                "Whole runs of one size differ by up to 7%.",
            ],
        ),
    ],
)
def test_page_of_scale_says_how_far_the_largest_size_is_off_the_lines(
    seconds: dict[int, float], told: list[str]
) -> None:
    scale = run_path(str(ROOT / "benchmarks/scale.py"))
    rows = [
        scale["Row"]("0123456", "oils", runs, step, quantity, value)
        for runs, cpu_s in seconds.items()
        for step, quantity, value in (
            ("whole run", "cpu_s", cpu_s),
            ("whole run", "spread", 0.07),
            ("dry run", "cpu_s", 1.0),
            ("dry run", "mib", 1.0),
            *((step, "bytes", 1000.0) for step in ("logs", "samples", "results")),
        )
    ]
    text = "\n".join(scale["report"](rows))
    assert [line for line in told if line not in text] == []


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
