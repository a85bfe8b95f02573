"""The demonstration on a Slurm of this machine and without one: times, ratio, the same bytes.

Run by `make bench-slurm`, as root: it installs Debian's packages of Slurm where they are missing.
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
    """Run both; 0 where the bytes are the same and Slurm takes at most three times as long."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-bench-") as folder:
        local, remote, plugin = (Path(folder, name) for name in ("local", "remote", "plugin"))
        plugin.mkdir()
        install_plugin(plugin)
        local_s = seconds(local, around=Surroundings(str(CORES)))
        with running_cluster(CORES) as cluster:
            remote_s = seconds(remote, *PROFILE, around=cluster.around(remote, plugin))
            jobs = len(cluster.jobs())
        difference = compare(local, remote)
        same = difference or f"{len(files_made(local))} files have the same bytes"
        ratio = remote_s / local_s
        print(f"{CORES} cores: local {local_s:.0f} s, Slurm {remote_s:.0f} s in {jobs} jobs")
        print(f"ratio {ratio:.2f}; {same}; load of the machine {os.getloadavg()[1]:.1f}")
        return int(bool(difference) or ratio > 3)


def seconds(project: Path, *arguments: str, around: Surroundings) -> float:
    """Seconds of the demonstration with its release."""
    lay_out(project)
    begun = time.perf_counter()
    succeed(project, "release", *arguments, "--config", "campaign=demo", around=around)
    return time.perf_counter() - begun


if __name__ == "__main__":
    sys.exit(main())
