"""Every block of code of every page runs in a test, is checked here, or is listed with the reason.

`workflow/test_how_to.py` carries out the commands of `helpers/page_blocks.py`.
"""

import re
import shutil
from pathlib import Path
from typing import Any

import pytest
import yaml

from campaigns import ROOT
from oilfilm.logs.ingest import ingest_logs
from oilfilm.logs.sheet_file import read_run_sheet
from oilfilm.logs.torque_log import TORQUE
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.campaign import CampaignFile
from oilfilm.settings.config import Config
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from page_blocks import CARRIED_OUT, HOW_TO, Block, blocks, commands, reason

# Pages, or languages of a page, whose blocks run in another test.
ELSEWHERE = {
    "docs/tutorials/first-csv.md": "repository/test_docs_code.py",
    "docs/tutorials/pcs-log.md": "repository/test_docs_code.py",
    "docs/tutorials/bearing.md": "repository/test_docs_code.py",
    f"{HOW_TO}/using-constants.md": "exports/test_using_constants.py",
    f"{HOW_TO}/check.md text": "test_check.py",
    "docs/reference/results.md python": "report/test_metadata.py",
    "docs/reference/results.md r": "report/test_metadata.py",
    "CONTRIBUTING.md": "workflow/test_stand_in.py",
}
# What a page shows of a screen or a folder, and where its form is tested.
SHOWN = {
    f"{HOW_TO}/plan.md": "numbers of the demonstration; form: torque/test_next_tests.py",
    f"{HOW_TO}/watch.md": "times of day; form: test_watch.py",
    "docs/tutorials/demonstration.md": "numbers of the demonstration; form: test_check.py",
    f"{HOW_TO}/running.md": "the Snakefile of a module: workflow/test_installed.py",
}


BLOCKS = blocks()
HERE = [block for block in BLOCKS if not block.names & set(ELSEWHERE)]
COMMANDS = [(block, line) for block in BLOCKS if block.language == "sh" for line in commands(block)]


def test_every_block_is_tested_or_listed_with_the_reason() -> None:
    assert len(BLOCKS) > 40
    for block in HERE:
        tested = bool(block.names & set(CARRIED_OUT)) or block.language == "yaml"
        tested |= block.page in SHOWN and block.language == "text"
        tested |= block.content in FILES
        if block.language == "sh" and not tested:
            lacking = [line for line in commands(block) if not reason(line)]
            assert not lacking, block.page
        else:
            assert tested, f"{block.page}: {block.language or 'no language'}: {block.content}"


YAML = [block for block in BLOCKS if block.language == "yaml" and "tutorials" not in block.page]


@pytest.mark.parametrize("block", YAML, ids=lambda block: block.page)
def test_settings_of_a_page_are_accepted(block: Block, tmp_path: Path) -> None:
    """As keys of a campaign file, of config.yaml or as the file of a rig."""
    folder = tmp_path / "config"
    shutil.copytree(ROOT / "config", folder)
    shutil.copy(folder / "bearings/mainshaft-167.yaml", folder / "bearings/my-bearing.yaml")
    own = yaml.safe_load(block.content)
    path = folder / "campaigns/etm-slim.yaml"
    if set(own) <= set(CampaignFile.model_fields):
        write(path, read(path) | own)
    elif set(own) <= set(Config.model_fields):
        path = folder / "config.yaml"
        write(path, read(path) | own)
    else:
        (folder / "rigs/own.yaml").write_text(block.content, "utf-8")
        write(path, read(path) | {"rigs": ["own"]})
    resolve(folder, {"campaign": "etm-slim"})


def read(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load(path.read_text("utf-8"))
    return content


def write(path: Path, content: dict[str, Any]) -> None:
    path.write_text(yaml.safe_dump(content, allow_unicode=True), "utf-8")


# Run sheets and logs that pages show.
FILES = {
    block.content: block
    for block in BLOCKS
    if block.language == "text" and re.match(r"file[,;]|# oil: ", block.content)
}


@pytest.mark.parametrize("content", FILES, ids=lambda content: content.split("\n")[0])
def test_log_or_run_sheet_of_a_page_is_read(content: str, config: Settings) -> None:
    if content.startswith("file"):
        logs = re.findall(r"(?m)^([\w/*]+\.\w+)[,;]", content)
        names = [name.replace("*", "_9") for name in logs]
        sheet = read_run_sheet(content.encode(), Path("runs.csv"), names, config, TRACTION)
        assert set(sheet.rows) == set(names)
    else:
        kind = TORQUE if "torque_n_m" in content else TRACTION
        ingested = ingest_logs([("a.csv", content.encode())], config, kind)
        assert ingested.quarantine.empty
        data = content.splitlines()[content.count("# ") + 1 :]
        assert list(ingested.runs["samples"]) == [len(data)]
