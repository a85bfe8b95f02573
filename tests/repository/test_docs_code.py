"""The tutorials, done by their text alone: every block of code runs and prints what the page says.

What takes minutes (`oilfilm run`, `make`, snakemake) is left to the nightly test.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from campaigns import ROOT

TUTORIALS = ROOT / "docs/tutorials"
LONG = re.compile(
    r"^(make|oilfilm run|cat results|\.venv/bin/snakemake|\.venv/bin/oilfilm predict)"
)


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and content of each block of code of a tutorial."""
    text = (TUTORIALS / page).read_text("utf-8")
    return re.findall(r"^```(sh|yaml|text|python)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def follow(page: str, folder: Path, *, long: bool) -> str:
    """Do in a folder what the blocks of a page say; what was printed."""
    script = []
    for language, content in blocks(page):
        if language == "sh":
            script += [line for line in content.splitlines() if long or not LONG.match(line)]
        elif language == "yaml":
            name = re.match(r"# (\S+)\n", content)
            assert name, "a file of a tutorial begins with its path"
            script += [f"cat > {name[1]} <<'END'", content.rstrip(), "END"]
    binaries = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-c", "\n".join(script)],
        cwd=folder,
        env={**os.environ, "PATH": binaries},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout + done.stderr


def expected(page: str) -> list[str]:
    """What a page says that is printed."""
    return [
        line.strip()
        for language, content in blocks(page)
        if language == "text"
        for line in content.splitlines()
        if line.strip()
    ]


def lacking(page: str, printed: str) -> list[str]:
    flat = " ".join(printed.split())
    return [line for line in expected(page) if " ".join(line.split()) not in flat]


@pytest.fixture
def first_csv(tmp_path: Path) -> Path:
    shutil.copy(ROOT / "docs/examples/write_logs.py", tmp_path)
    return tmp_path


def test_first_csv_prints_what_the_tutorial_says(first_csv: Path) -> None:
    printed = follow("first-csv.md", first_csv, long=False)
    assert not lacking("first-csv.md", printed), printed


@pytest.mark.nightly
def test_first_csv_runs_to_a_fit_that_has_the_planted_constants(first_csv: Path) -> None:
    printed = follow("first-csv.md", first_csv, long=True)
    assert not lacking("first-csv.md", printed), printed
    assert "4102" in (first_csv / "june/results/june/summary.txt").read_text("utf-8")
    assert (first_csv / "june/results/june/report.html").is_file()


def test_pcs_log_prints_what_the_tutorial_says(tmp_path: Path) -> None:
    for name in ("config", "data", "pyproject.toml", "Snakefile", "workflow"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / ".venv").symlink_to(Path(sys.prefix))
    printed = follow("pcs-log.md", tmp_path, long=False)
    assert not lacking("pcs-log.md", printed), printed


def test_bearing_of_the_tutorial_has_an_equilibrium() -> None:
    code = "\n".join(content for language, content in blocks("bearing.md") if language == "python")
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "all converged: True" in done.stdout
    assert not lacking("bearing.md", done.stdout), done.stdout
