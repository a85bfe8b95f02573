"""The command `oilfilm run` starts Snakemake, which makes all results of a project folder.

A clone of the repository is a project folder too.
"""

import argparse
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from oilfilm.base.errors import OilfilmError


def run(options: argparse.Namespace) -> int:
    """Run the workflow in a folder.

    Returns:
        The exit code of Snakemake: 0 for success, 1 where a job fails; negative, as the number of
        the signal, where a signal ends it.
    """
    words: list[str] = options.words
    separator = words.index("--") if "--" in words else len(words)
    folders = words[:separator]
    arguments = words[separator + 1 :]
    if len(folders) > 1 or any(word.startswith("-") for word in folders):
        raise OilfilmError(
            f"oilfilm run: found {' '.join(folders)!r}; expected at most one folder. Arguments for "
            "snakemake come behind --, as in: oilfilm run june -- --dry-run"
        )
    folder = Path(*folders)
    snakefiles = [folder / "Snakefile", folder / "workflow/Snakefile"]
    if not any(file.is_file() for file in snakefiles):
        raise OilfilmError(
            f"{folder}: has no Snakefile, so it is not a project folder. Name one, or make one: "
            "oilfilm init DIR LOG..."
        )
    if find_spec("snakemake") is None:
        # the message of `main` says how to install it
        raise ModuleNotFoundError(name="snakemake")
    command = [sys.executable, "-m", "snakemake", *arguments]
    # a list of arguments without a shell; the user who started this has typed them
    return subprocess.run(command, cwd=folder, check=False).returncode  # noqa: S603
