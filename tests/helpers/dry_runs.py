"""Dry runs of many projects: `snakemake -n`, in forks of one process that has imported Snakemake.

A start of Snakemake takes longer than the dry run of a small campaign. Each fork imports oilfilm
from its own project.
"""

import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

OUTPUT = "dry-run.txt"


def jobs(output: str) -> dict[str, int]:
    """How many jobs of each rule a run announces."""
    table = output.partition("Job stats")[2].partition("total")[0]
    rows = re.findall(r"(?m)^ *(\w[\w ]*?) +(\d+) *$", table)
    # the logger writes a blank for an underscore
    return {rule.replace(" ", "_"): int(jobs) for rule, jobs in rows}


def jobs_due(projects: Mapping[str, Path], campaign: str) -> dict[str, dict[str, int]]:
    """How many jobs of each rule are due in each project, without the target `all`."""
    folders = list(map(str, projects.values()))
    done = subprocess.run(
        [sys.executable, __file__, campaign, *folders], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    due = {}
    for name, project in projects.items():
        output = (project / OUTPUT).read_text(encoding="utf-8")
        due[name] = jobs(output)
        assert due[name] or "Nothing to be done" in output, output
        due[name].pop("all", None)
    return due


def main(campaign: str, folders: Sequence[str]) -> None:
    """Make a dry run in each folder, as many at a time as there are processors."""
    # what Snakemake and the Snakefile import
    import pandas  # noqa: F401, PLC0415
    import pyarrow.parquet  # noqa: F401, PLC0415
    import pydantic  # noqa: F401, PLC0415
    import scipy  # noqa: F401, PLC0415
    import smart_open  # noqa: F401, PLC0415
    import snakemake.cli  # noqa: PLC0415
    import sqlmodel  # noqa: F401, PLC0415

    active = 0
    for folder in folders:
        if active == (os.cpu_count() or 1):
            os.wait()
            active -= 1
        active += 1
        if os.fork():
            continue
        os.chdir(folder)
        sys.path.insert(0, "workflow")
        with open(OUTPUT, "w", encoding="utf-8") as output:  # noqa: PTH123
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
            try:
                snakemake.cli.main(["-n", "--config", f"campaign={campaign}"])
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(0)
    for _ in range(active):
        os.wait()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
