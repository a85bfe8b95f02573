"""What goes wrong on a machine: the next run ends in the same bytes, or says what to do.

`make bench NAME=faults` kills thirty times; here are a few kills and one of every other fault.
"""

import fcntl
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from campaigns import lay_out_small
from reproduce import (
    Surroundings,
    command,
    compare,
    fail,
    fake_clock,
    killed,
    start,
    succeed,
    succeeds,
    unfinished,
    unusual,
)

pytestmark = pytest.mark.workflow

SMALL = ("--config", "campaign=small")
POINTS = "results/small/tables/points.parquet"
# One job makes it.
SHARE = "results/small/parts/points/0/points.parquet"


@pytest.fixture(scope="module")
def undisturbed(released_project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with an undisturbed run and its release, as every test leaves it."""
    project = tmp_path_factory.mktemp("faults") / "undisturbed"
    shutil.copytree(released_project, project, symlinks=True)
    return project


@pytest.fixture
def new(tmp_path: Path) -> Path:
    """A project that has not run."""
    project = tmp_path / "new"
    lay_out_small(project)
    return project


@pytest.mark.slow
def test_run_needs_no_network_and_unpickles_nothing(released_project: Path) -> None:
    """The guard (tests/guard) would have raised, and written down what was tried."""
    assert not (released_project / "guard.log").exists()


@pytest.mark.nightly
def test_killed_run_ends_in_the_same_bytes(undisturbed: Path, new: Path, tmp_path: Path) -> None:
    """Killed again and again, the clock set back in between, then run to its end.

    The other surroundings: date, host name, user, locale, time zone, number of cores and a Python
    that skips assertions.
    """
    ahead, around = Surroundings("2", fake_clock("+500d")), replace(unusual(tmp_path), cores="1")
    for files, surroundings in ((0, ahead), (3, ahead), (15, around), (40, around)):
        assert killed(new, 1.5, "release", *SMALL, files=files, around=surroundings)
    succeed(new, "release", *SMALL, around=around)
    assert compare(undisturbed, new) == ""
    if around.lacking:
        pytest.skip(f"the same bytes, but not with {', '.join(around.lacking)}")


@pytest.mark.nightly
def test_code_that_changes_during_a_run_is_not_released(undisturbed: Path, tmp_path: Path) -> None:
    project = tmp_path / "edited"
    shutil.copytree(undisturbed, project, symlinks=True)
    with start(project, "release", "--forcerun", "report", *SMALL) as running:
        wait_for(lambda: bool(unfinished(project)))
        with (project / "workflow/oilfilm/base/units.py").open("a", encoding="utf-8") as module:
            module.write("# changed\n")
        output, _ = running.communicate()
    assert running.returncode != 0
    assert "code has changed" in output


# A file system of its own for results, as large as is said; it ends with the process.
_DISK = [*("unshare", "--user", "--map-root-user", "--mount"), "sh", "-c"]


@pytest.mark.nightly
@pytest.mark.skipif(
    not succeeds([*_DISK, "mount -t tmpfs tmpfs /mnt"]), reason="no file system may be mounted here"
)
def test_read_only_and_full_disk_are_told_and_the_run_goes_on(undisturbed: Path, new: Path) -> None:
    (new / "results").mkdir()
    snakemake, environment = command(new, "--cores", "2", POINTS, *SMALL)
    script = """
        mount -t tmpfs -o ro tmpfs results
        "$@" >read-only.txt 2>&1 && exit 1
        mount -o remount,rw,size=400k results
        "$@" >full.txt 2>&1 && exit 2
        mount -o remount,size=100m results
        "$@" >enough.txt 2>&1 || exit 3
        cp results/small/tables/points.parquet .
    """
    done = subprocess.run([*_DISK, script, "sh", *snakemake], cwd=new, env=environment, check=False)
    read_only, full = ((new / f"{name}.txt").read_text() for name in ("read-only", "full"))
    assert done.returncode == 0, read_only + full
    assert "Traceback" not in read_only + full
    assert "can only be read" in read_only
    assert "disk is full" in full
    assert (undisturbed / POINTS).read_bytes() == (new / "points.parquet").read_bytes()


def wait_for(condition: Callable[[], bool]) -> None:
    for _ in range(1200):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited for a minute in vain")


def no_job_is_left(project: Path) -> bool:
    with (project / ".snakemake/oilfilm.lock").open("a+b") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


@pytest.mark.nightly
def test_second_run_is_refused_unless_killed(released_project: Path, tmp_path: Path) -> None:
    new = tmp_path / "new"
    shutil.copytree(released_project, new, symlinks=True)
    again = (SHARE, "--forcerun", "points", *SMALL)
    with start(new, *again, stdout=subprocess.DEVNULL, new_session=True) as first:
        wait_for(lambda: bool(unfinished(new)))
        os.killpg(first.pid, signal.SIGSTOP)  # it must not end while the second one starts
        assert "Another run" in fail(new, *again)
        # the run alone, so that its job lives on
        first.kill()
        os.killpg(first.pid, signal.SIGCONT)
    wait_for(lambda: no_job_is_left(new))
    # another date, user, locale, time zone and order of hashes, and a Python without assertions
    around = Surroundings("1", unusual(tmp_path).environment)
    succeed(new, SHARE, *SMALL, around=around)
    assert (released_project / SHARE).read_bytes() == (new / SHARE).read_bytes()
