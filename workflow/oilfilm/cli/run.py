"""The command `oilfilm run`: everything of a project folder or of a clone, by Snakemake."""

import argparse
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from oilfilm.errors import OilfilmError


def run(options: argparse.Namespace) -> int:
    """Run the workflow in a folder; the exit code is Snakemake's."""
    words: list[str] = options.words
    at = words.index("--") if "--" in words else len(words)
    before, arguments = words[:at], words[at + 1 :]
    if len(before) > 1 or any(word.startswith("-") for word in before):
        raise OilfilmError(
            f"oilfilm run: found {' '.join(before)!r}; expected at most one folder. Arguments for "
            "snakemake come behind --, as in: oilfilm run june -- --dry-run"
        )
    folder = Path(*before)
    places = [folder / name for name in ("Snakefile", "workflow/Snakefile")]
    if not any(place.is_file() for place in places):
        raise OilfilmError(
            f"{folder}: has no Snakefile, so it is not a project folder. Name one, or make one: "
            "oilfilm init DIR LOG..."
        )
    if find_spec("snakemake") is None:
        # `main` says how to install it
        raise ModuleNotFoundError(name="snakemake")
    command = [sys.executable, "-m", "snakemake", *arguments]
    # a list of arguments, no shell; they are those of the user who started this
    return subprocess.run(command, cwd=folder, check=False).returncode  # noqa: S603
