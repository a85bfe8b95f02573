"""Code on pages. The tutorials are done by their text alone, and print what they say.

What takes minutes (`oilfilm run`, `make`, snakemake) is left to the nightly test.
"""

import doctest
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from campaigns import ROOT, needs_study
from nights import nightly
from oilfilm.cli import main
from oilfilm.logs.ingest import ingest_logs
from oilfilm.logs.sheet_file import read_run_sheet
from oilfilm.logs.torque_log import TORQUE
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.campaign import CampaignFile
from oilfilm.settings.config import Config
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.declaration import Declarations
from page_blocks import Block
from page_blocks import blocks as page_blocks

TUTORIALS = ROOT / "docs/tutorials"
LONG = re.compile(r"^(make|oilfilm run|cat results|\.venv/bin/(snakemake|oilfilm predict))")


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and content of each block of code of a tutorial."""
    text = (TUTORIALS / page).read_text("utf-8")
    return re.findall(r"^```(sh|yaml|text|python)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def follow(
    page: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    *,
    long: bool = False,
) -> str:
    """Do in a folder what the blocks of a page say; what was printed."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    for language, content in blocks(page):
        if language == "yaml":
            name = re.match(r"# (\S+)\n", content)
            assert name, "a file of a tutorial begins with its path"
            Path(name[1]).write_text(content, encoding="utf-8")
        lines = content.splitlines() if language == "sh" else ()
        for line in (line for line in lines if long or not LONG.match(line)):
            match shlex.split(line, comments=True):
                case ["cd", place]:
                    monkeypatch.chdir(place)
                case ["oilfilm" | ".venv/bin/oilfilm", "init" | "check" as name, *words]:
                    main([name, *words])  # without another start of Python
                case _:
                    subprocess.run(line, shell=True, check=False)
    return capfd.readouterr().out


def refuse_missing(page: str, printed: str) -> None:
    """Refuse what was printed where it lacks a line that the page shows."""
    flat = " ".join(printed.split())
    shown = "".join(content for language, content in blocks(page) if language == "text")
    missing = [line for line in shown.splitlines() if " ".join(line.split()) not in flat]
    assert not missing, printed


@pytest.mark.slow
@pytest.mark.parametrize("long", [False, nightly(True)])
def test_first_csv_prints_what_the_tutorial_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], long: bool
) -> None:
    printed = follow("first-csv.md", tmp_path, monkeypatch, capfd, long=long)
    refuse_missing("first-csv.md", printed)
    assert (tmp_path / "june/results/june/report.html").is_file() == long


def test_pcs_log_prints_what_the_tutorial_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("config", "data", "pyproject.toml", "Snakefile", "workflow"):
        (tmp_path / name).symlink_to(ROOT / name)
    refuse_missing("pcs-log.md", follow("pcs-log.md", tmp_path, monkeypatch, capfd))


@pytest.mark.nightly
def test_bearing_of_the_tutorial_has_an_equilibrium(capsys: pytest.CaptureFixture[str]) -> None:
    code = "\n".join(content for language, content in blocks("bearing.md") if language == "python")
    exec(code, {})
    printed = capsys.readouterr().out
    refuse_missing("bearing.md", printed)


@pytest.mark.slow
def test_readme_prints_what_it_says() -> None:
    (code,) = re.findall(r"(?ms)^```python\n(.*?)^```", (ROOT / "README.md").read_text("utf-8"))
    example = doctest.DocTestParser().get_doctest(code, {}, "README.md", None, 0)
    assert doctest.DocTestRunner().run(example).failed == 0


# ---------------------------------------------------------------- settings and logs on pages


YAML = [each for each in page_blocks() if each.language == "yaml" and "tutorials" not in each.page]
DECLARATIONS = [block for block in YAML if "tables" in yaml.safe_load(block.content)]
SETTINGS_BLOCKS = [block for block in YAML if block not in DECLARATIONS]


@pytest.mark.parametrize("block", DECLARATIONS, ids=lambda block: block.page)
def test_declarations_of_a_page_are_accepted(block: Block, tmp_path: Path) -> None:
    path = tmp_path / "declared.yaml"
    path.write_text(block.content, "utf-8")
    assert load(path, Declarations).tables


@needs_study
@pytest.mark.parametrize("block", SETTINGS_BLOCKS, ids=lambda block: block.page)
def test_settings_of_a_page_are_accepted(block: Block, tmp_path: Path) -> None:
    """As keys of a campaign file, of config.yaml or as the file of a rig."""
    folder = tmp_path / "config"
    shutil.copytree(ROOT / "config", folder)
    shutil.copy(folder / "bearings/mainshaft-167.yaml", folder / "bearings/my-bearing.yaml")
    own = yaml.safe_load(block.content)
    path = folder / "campaigns/etm-slim.yaml"
    if not set(own) <= set(CampaignFile.model_fields):
        if set(own) <= set(Config.model_fields):
            path = folder / "config.yaml"
        else:
            (folder / "rigs/own.yaml").write_text(block.content, "utf-8")
            own = {"rigs": ["own"]}
    content = yaml.safe_load(path.read_text("utf-8")) | own
    path.write_text(yaml.safe_dump(content, allow_unicode=True), "utf-8")
    resolve(folder, {"campaign": "etm-slim"})


# Run sheets and logs that pages show.
FILES = {
    block.content: block
    for block in page_blocks()
    if block.language == "text" and re.match(r"file[,;]|# oil: ", block.content)
}


@pytest.mark.parametrize("content", FILES, ids=lambda content: content.split("\n")[0])
def test_log_or_run_sheet_of_a_page_is_read(content: str, config: Settings) -> None:
    if content.startswith("file"):
        logs = re.findall(r"(?m)^([\w/*]+\.\w+)[,;]", content)
        names = [name.replace("*", "_9") for name in logs]
        sheet = read_run_sheet(content.encode(), Path("runs.csv"), names, config, TRACTION)
        assert set(sheet.rows_of_log) == set(names)
    else:
        kind = TORQUE if "torque_n_m" in content else TRACTION
        ingested = ingest_logs([("a.csv", content.encode())], config, kind)
        assert ingested.quarantine.empty
        data = content.splitlines()[content.count("# ") + 1 :]
        assert list(ingested.runs["samples"]) == [len(data)]
