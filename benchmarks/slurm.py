"""The demonstration on a Slurm of this machine and without one: times, ratio, the same bytes.

Then with all results in object storage, a SeaweedFS of this machine. Every file is compared with
the one of a local run, but for Snakemake's log.

Run by `make bench-slurm`, as root: it installs Debian's packages of Slurm where they are missing.
"""

import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from campaigns import lay_out
from reproduce import Surroundings, compare, files_made, succeed
from slurm_cluster import PROFILE, Cluster, install_plugin, running_cluster
from storage_servers import (
    IN_BUCKET,
    Storage,
    files_with_a_key,
    seaweed_storage,
)

CORES = os.cpu_count() or 1
LOCAL = Surroundings(str(CORES))


def main() -> int:
    """Run all; 0 where the bytes are the same and Slurm takes at most three times as long."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-bench-") as name:
        folder = Path(name)
        plugin, server, local = (folder / part for part in ("plugin", "server", "local"))
        plugin.mkdir()
        server.mkdir()
        install_plugin(plugin)
        lay_out(local)
        local_s = seconds(local, "demo", around=LOCAL)
        with running_cluster(CORES) as cluster, seaweed_storage(server) as storage:
            storage.client().create_bucket(Bucket="lab")
            slurm = Slurm(folder, plugin, cluster, storage)
            slurm_s = slurm.demonstration()
            ratio = slurm_s / local_s
            print(f"{CORES} cores: local {local_s:.0f} s, Slurm {slurm_s:.0f} s: ratio {ratio:.2f}")
            print(f"{len(cluster.jobs())} jobs; load of the machine {os.getloadavg()[1]:.1f}")
            same = slurm.same_bytes(local, "slurm")
            slurm.demonstration_in_bucket()
            same &= slurm.same_bytes(local, "all-in-bucket")
        return int(not same or ratio > 3)


def seconds(project: Path, campaign: str, *arguments: str, around: Surroundings) -> float:
    """Seconds of a campaign with its release."""
    begun = time.perf_counter()
    succeed(project, "release", *arguments, "--config", f"campaign={campaign}", around=around)
    return time.perf_counter() - begun


@dataclass(frozen=True)
class Slurm:
    """Projects whose jobs run on the cluster, each in a folder of its own."""

    folder: Path
    plugin: Path
    cluster: Cluster
    storage: Storage

    def demonstration(self) -> float:
        """All files in folders; the seconds that it takes."""
        lay_out(self.folder / "slurm")
        return self._seconds("slurm", "demo")

    def demonstration_in_bucket(self) -> None:
        """Simulated logs and all results in the bucket; then in the folder."""
        project = self.folder / "all-in-bucket"
        lay_out(project)
        self._seconds(project.name, "demo", *IN_BUCKET, "s3://lab/all")
        self.storage.fetch("lab", "all/", project)

    def same_bytes(self, local: Path, name: str) -> bool:
        """Whether files are those of the local run, and none holds a key."""
        project = self.folder / name
        difference = compare(local, project)
        count = len(files_made(local))
        print(f"{name}: {difference or f'{count} files have the same bytes'}", flush=True)
        if leaks := files_with_a_key(self.storage, project):
            print(f"{name}: {leaks[0]} holds the key of the storage")
        return not difference and not leaks

    def _seconds(self, name: str, campaign: str, *arguments: str) -> float:
        project = self.folder / name
        around = self.cluster.around(project, self.plugin, self.storage.environment)
        return seconds(project, campaign, *PROFILE, *arguments, around=around)


if __name__ == "__main__":
    sys.exit(main())
