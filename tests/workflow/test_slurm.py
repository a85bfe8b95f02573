"""The workflow on a real Slurm, as docs/how-to/cluster.md says, and what goes wrong on clusters."""

import os
import signal
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from campaigns import lay_out_small
from reproduce import compare, start
from slurm_cluster import PROFILE, Cluster, UnavailableError, install_plugin, running_cluster

pytestmark = [pytest.mark.workflow, pytest.mark.nightly]

# Too little memory to start Python in, and two minutes for a step that will hang; then enough.
SCARCE = ("points:mem_mb=32 * 64 ** (attempt - 1)", "fit:runtime=2 * 10 ** (attempt - 1)")


@pytest.fixture(scope="module")
def plugin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plugin")
    try:
        install_plugin(folder)
    except UnavailableError as reason:
        pytest.skip(f"no Slurm to test with: {reason}")
    return folder


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    try:
        with running_cluster(cores=4) as slurm:
            yield slurm
    except UnavailableError as reason:
        pytest.skip(f"no Slurm to test with: {reason}")


def wait(process: subprocess.Popen[str], for_what: Callable[[], object]) -> None:
    """Wait until something is true while a run is active."""
    while not for_what():
        assert process.poll() is None, "the run ended too early"
        time.sleep(0.2)


def processes_of(script: str, project: Path) -> list[int]:
    """Processes that run a script of the workflow for a project."""
    copies = str(project / ".snakemake/scripts")
    found = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):  # it has ended
            words = place.read_bytes().decode(errors="replace").split("\0")
            if len(words) > 1 and words[1].startswith(copies) and words[1].endswith(f".{script}"):
                found.append(int(place.parent.name))
    return found


def test_campaign_on_a_cluster_has_the_bytes_of_a_local_run_whatever_fails(
    cluster: Cluster, plugin: Path, released_project: Path, tmp_path: Path
) -> None:
    """Too little memory, a step that hangs, slurmd killed in mid-run: each costs time only."""
    project, output = tmp_path / "cluster", tmp_path / "output.txt"
    lay_out_small(project)
    slurm = (*PROFILE, "--slurm-init-seconds-before-status-checks=1", "--set-resources", *SCARCE)
    arguments = ("release", *slurm, "--config", "campaign=small")
    around = cluster.around(project, plugin)
    with (
        output.open("w") as file,
        start(project, *arguments, around=around, stdout=file.fileno()) as process,
    ):
        wait(process, lambda: processes_of("fit.py", project))
        os.kill(processes_of("fit.py", project)[0], signal.SIGSTOP)
        cluster.stop_node()
        # the fit of the other law ends while nobody watches it
        fits = project / "results/small/parts/fit/4102"
        wait(process, lambda: any(fits.glob("*/refits.parquet")))
        time.sleep(10)
        cluster.start_node()
    text = output.read_text(encoding="utf-8")
    assert process.returncode == 0, text
    assert compare(released_project, project) == ""

    jobs = cluster.jobs()
    failed = {job for job in jobs if job[1] != "COMPLETED"}
    # without control groups Slurm says FAILED of a job that it has ended for its memory
    shares = {(f"rule_points_wildcards_{share}", "FAILED") for share in range(2)}
    ((hung, state),) = failed - shares
    assert (hung.startswith("rule_fit_wildcards_4102"), state) == (True, "TIMEOUT")
    assert shares < failed
    logs = project.glob(".snakemake/slurm_logs/rule_points/**/*.log")
    assert any("exceeded memory limit" in log.read_text(encoding="utf-8") for log in logs)
    # what is done is not done again
    done = Counter(step for step, state in jobs if state == "COMPLETED")
    assert set(done.values()) == {1}
