"""Blocks of code on pages, and which commands among them no test can carry out as they are."""

import re
from typing import NamedTuple

from campaigns import ROOT

HOW_TO = "docs/how-to"
# Pages whose commands `workflow/test_how_to.py` carries out.
CARRIED_OUT = (
    *(f"{HOW_TO}/{page}.md sh" for page in ("check", "plan", "bearing", "releases", "nightly")),
    "docs/tutorials/demonstration.md sh",
)
# Commands that no test carries out as they are; the rest of the line says what is tested instead.
NOT_RUN = {
    r"make( test)?$": "the tests themselves follow it",
    r".*snakemake --workflow-profile profiles/slurm": "needs Slurm: workflow/test_slurm.py",
    r"apptainer build|snakemake --sdm apptainer": "needs Apptainer: workflow/test_containers.py",
    r".*profiles/kubernetes|.*executor-plugin-kubernetes": "needs Kubernetes; the page says so",
    r".*s3://": "needs a server of object storage: workflow/test_object_storage.py",
    r".*pip install .*requirements/": "needs a network: repository/test_requirements_lock.py",
    r".*pip (download|install) .*wheels": "needs a network, and 200 MB",
    r".*oilfilm watch": "runs until Ctrl-C: test_watch.py",
    r".*snakemake release --config campaign=june": "a campaign of the reader; see nightly.md",
    r".*snakemake --config campaign=etm-slim": "20 s of fits: curation/test_measured_curves.py",
    r"oilfilm (init june|run$|check data/raw/june$)|(cd|cat).* ?june": "tutorial first-csv",
}


class Block(NamedTuple):
    """A block of code on a page, of a language such as `sh`."""

    page: str
    language: str
    content: str

    @property
    def names(self) -> set[str]:
        """Names of the block in `CARRIED_OUT`: its page, or its page and language."""
        return {self.page, f"{self.page} {self.language}"}


def blocks() -> list[Block]:
    """The blocks of all pages, but for pictures and other directives."""
    pages = [*(ROOT / "docs").rglob("*.md"), *(ROOT / "data/raw").rglob("README.md")]
    pages += [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "config/README.md")]
    found = []
    for page in sorted(page for page in pages if "_build" not in page.parts):
        name = page.relative_to(ROOT).as_posix()
        directives = r"(?ms)^ *```\{.*?^ *```$"
        text = re.sub(directives, "", page.read_text("utf-8"))
        for indent, language, content in re.findall(
            r"^( *)```([^{\n]*)\n(.*?)^ *```$", text, re.DOTALL | re.MULTILINE
        ):
            found.append(Block(name, language, re.sub(rf"(?m)^{indent}", "", content)))
    return found


def commands(block: Block) -> list[str]:
    """The commands of a block, without comments; a line of a screen begins with `$`."""
    lines = [line.partition(" #")[0].strip() for line in block.content.splitlines()]
    return [line for line in lines if line]


def reason(command: str) -> str:
    """Why no test carries out a command; empty for one that is carried out."""
    for pattern, why in NOT_RUN.items():
        if re.match(pattern, command):
            return why
    return ""
