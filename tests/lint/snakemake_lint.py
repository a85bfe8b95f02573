"""Run `snakemake --lint` and fail on every finding but one.

Snakemake asks each rule for a conda environment or a container of its own. Here all rules share
the one environment that requirements/run.lock pins, so that finding, and no other, is let through.
"""

import re
import subprocess
import sys

HEADING = "Lints for "
FINDING = "    * "
ALLOWED = FINDING + "Specify a conda environment or container for each rule.:"


def refused(report: str) -> list[str]:
    """Every finding of the report but the allowed one, below the rule or file that it is about."""
    where, found = "", []
    for block in re.split(rf"(?m)^(?={re.escape(HEADING)}|{re.escape(FINDING)})", report):
        if block.startswith(HEADING):
            where = block
        elif block.startswith(FINDING) and block.splitlines()[0] != ALLOWED:
            found.append(where + block)
    return found


def main() -> int:
    # `--lint json` prints the same text in Snakemake 9.27.
    lint = subprocess.run(
        [sys.executable, "-m", "snakemake", "--lint"], capture_output=True, text=True, check=False
    )
    found = refused(lint.stderr)
    if lint.returncode != 0 and FINDING not in lint.stderr:
        found = [lint.stderr]  # the workflow does not even load
    print("\n".join(found), file=sys.stderr, end="")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
