"""A folder whose name a shell or Snakemake would take for something else."""

import os
import shlex
import sys
from pathlib import Path

from oilfilm.errors import OilfilmError

# Snakemake takes braces for wildcards; PATH is parted at colons; a shell runs what a dollar sign
# or a backquote begins, even in double quotes, and the start scripts of packages have those.
UNUSABLE = frozenset('{}:$`"\\') | {chr(code) for code in (*range(32), 127)}


def refuse_unusable(folder: Path) -> None:
    """Refuse a folder in which jobs cannot be started safely.

    Raises:
        OilfilmError: The whole path has a character of `UNUSABLE`.
    """
    bad = sorted(UNUSABLE & set(str(folder)))
    if bad:
        names = ", ".join(map(repr, bad))
        raise OilfilmError(
            f"{str(folder)!r}: jobs cannot be started in a folder with {names} in its path. Rename "
            "the folder, or move what is in it; blanks and letters of any language do no harm."
        )


def start_python_by_name() -> None:
    """Let Snakemake find this Python through PATH where its own path would need quotes.

    Snakemake writes `sys.executable` without quotes into the commands of its jobs.
    """
    python = Path(sys.executable)
    if shlex.quote(sys.executable) != sys.executable:
        os.environ["PATH"] = os.pathsep.join([str(python.parent), os.environ.get("PATH", "")])
        sys.executable = python.name
