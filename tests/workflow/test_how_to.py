"""The commands of the how-to guides, carried out as the pages say on a finished small campaign."""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from command_line import succeeded
from page_blocks import CARRIED_OUT, blocks, commands, reason
from reproduce import command

pytestmark = [pytest.mark.workflow, pytest.mark.nightly]

# What a page says of its own campaign, and what the small one has.
LOG = "data/raw/small/4102_P1.25_U25_T050.csv"
IN_SMALL = {
    r"data/raw/demo/\S+\.csv|FILE\.\.\.": LOG,
    r"(raw|results|releases|pins)/(demo|june)\b": r"\1/small",
    r"--campaign june": "--campaign small",
    r"(snakemake release)( --config campaign=june)?": r"\1 --config campaign=small",
    r"diff A B": "diff results/releases/small/latest results/releases/small/latest",
    r"~/\.ssh/id_ed25519": "ada",
    r"(oilfilm bearing\b)(?!.*--results)": r"\1 --results results/small",
    # it has no bearing
    r"(--for cage-slip)": r"\1 --bearing mainshaft-167 --duty 20kN,10000rpm,100degC",
    # the packages would need a network: those that are installed take their place
    r" wheels ": " ",
    r"python3 -m venv june/": "ln -s ../.venv june/",
}
# What a page takes for granted.
PIN = ".venv/bin/oilfilm pin results/releases/small/latest"
BEFORE = {
    "docs/how-to/nightly.md": (PIN,),
    "docs/how-to/releases.md": (
        PIN,
        "ssh-keygen -qt ed25519 -N '' -f ada",
        "git init -q && git add Snakefile data profiles *.toml requirements/run.lock workflow",
        "git -c user.name=Ada -c user.email=ada@lab.example commit -q -m code",
    ),
}


@pytest.mark.skipif(not shutil.which("ssh-keygen"), reason="ssh-keygen is not installed")
@pytest.mark.parametrize("name", sorted(CARRIED_OUT))
def test_commands_of_a_page_succeed(name: str, released_project: Path, tmp_path: Path) -> None:
    project = tmp_path / "project"
    shutil.copytree(released_project, project, symlinks=True)
    (project / ".venv").symlink_to(Path(sys.prefix))
    _, environment = command(project)
    binaries = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    page = name.removesuffix(" sh")
    of_page = [block for block in blocks() if name in block.names]
    lines = [line for block in of_page for line in commands(block)]
    lines = [line for line in lines if not reason(line)]
    assert lines
    for line in (*BEFORE.get(page, ()), *map(in_small, lines)):
        succeeded(["bash", "-c", line], cwd=project, env={**environment, "PATH": binaries})


def in_small(line: str) -> str:
    for form, text in IN_SMALL.items():
        line = re.sub(form, text, line)
    return line
