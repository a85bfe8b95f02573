"""The demonstration with Slurm on this machine, and without it: times, ratio, the same bytes.

Every file is compared with the one of a local run, but for Snakemake's log.

Run by `make bench NAME=slurm`: it installs Debian's packages of Slurm where they are
missing.

Takes 25 minutes, as root.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from campaigns import lay_out
from reproduce import Surroundings, compare, files_made, succeed
from slurm_cluster import PROFILE, install_plugin, running_cluster

CORES = os.cpu_count() or 1


def main() -> int:
    """Run all; 0 where the bytes are the same and Slurm takes at most three times as long."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-bench-") as folder:
        plugin, local, slurm = (Path(folder, name) for name in ("plugin", "local", "slurm"))
        plugin.mkdir()
        install_plugin(plugin)
        lay_out(local)
        lay_out(slurm)
        local_s = seconds(local, around=Surroundings(str(CORES)))
        with running_cluster(CORES) as cluster:
            slurm_s = seconds(slurm, *PROFILE, around=cluster.around(slurm, plugin))
            jobs = len(cluster.jobs())
        ratio = slurm_s / local_s
        print(f"{CORES} cores: local {local_s:.0f} s, Slurm {slurm_s:.0f} s: ratio {ratio:.2f}")
        print(f"{jobs} jobs; load of the machine {os.getloadavg()[1]:.1f}")
        difference = compare(local, slurm)
        print(difference or f"{len(files_made(local))} files have the same bytes")
        return int(bool(difference) or ratio > 3)


def seconds(project: Path, *arguments: str, around: Surroundings) -> float:
    """Seconds of the demonstration with its release."""
    start_s = time.perf_counter()
    succeed(project, "release", *arguments, "--config", "campaign=demo", around=around)
    return time.perf_counter() - start_s


if __name__ == "__main__":
    sys.exit(main())
