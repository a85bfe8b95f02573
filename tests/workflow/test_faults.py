"""What goes wrong on a machine: the next run ends in the same bytes, or says what to do.

`make bench-faults` kills thirty times; here are a few kills and one of every other fault.
"""

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from campaigns import lay_out_measured, lay_out_small
from oilfilm import tables
from oilfilm.releases.table_diff import file_difference
from reproduce import (
    IN_ONE_SHARE,
    Surroundings,
    command,
    compare,
    fail,
    fake_clock,
    killed,
    run,
    start,
    succeed,
    unfinished,
    unusual,
    works,
)

pytestmark = pytest.mark.workflow

SMALL = ("--config", "campaign=small")
POINTS = "results/small/tables/points.parquet"


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


def test_run_needs_no_network_and_unpickles_nothing(released_project: Path) -> None:
    """The guard (tests/guard) would have raised, and written down what was tried."""
    assert not (released_project / "guard.log").exists()


@pytest.mark.nightly
def test_run_in_a_folder_of_any_name_and_other_surroundings_ends_in_the_same_bytes(
    undisturbed: Path, tmp_path: Path
) -> None:
    """Blank, umlaut, quote, semicolon, hash, percent, hyphen, and an interpreter in there too.

    The other surroundings: date, host name, user, network (none), locale, time zone and cores.
    """
    lab = tmp_path / "My Lab" / "Prüfstand; it's #1 %d" / "-x"
    python = lab / "env/bin/python"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", lab / "env"], check=True)
    (packages,) = (lab / "env/lib").glob("python*/site-packages")
    (packages / "outer.pth").write_text(f"{sysconfig.get_path('purelib')}\n", encoding="utf-8")
    lay_out_small(lab / "project")
    _, environment = command(lab / "project")
    around = replace(unusual(tmp_path), cores="1")
    done = subprocess.run(
        [*around.before, python, "-m", "snakemake", "--cores", around.cores, POINTS, *SMALL],
        cwd=lab / "project",
        env={**environment, **around.environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert file_difference(undisturbed / POINTS, lab / "project" / POINTS) == ""
    if around.lacking:
        pytest.skip(f"the same bytes, but not with {', '.join(around.lacking)}")


@pytest.mark.nightly
def test_killed_run_ends_in_the_same_bytes_in_other_surroundings(
    undisturbed: Path, new: Path, tmp_path: Path
) -> None:
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
def test_release_that_exists_leaves_the_same_bytes_as_one_that_is_made(
    undisturbed: Path, tmp_path: Path
) -> None:
    """As after a kill between the release and Snakemake's own record of it."""
    project = tmp_path / "again"
    shutil.copytree(undisturbed, project, symlinks=True)
    output = succeed(project, "release", "--forcerun", "release", *SMALL)
    assert "exists already, with the same bytes" in output
    assert compare(undisturbed, project) == ""


@pytest.mark.nightly
def test_code_that_changes_during_a_run_is_not_released(undisturbed: Path, tmp_path: Path) -> None:
    project = tmp_path / "edited"
    shutil.copytree(undisturbed, project, symlinks=True)
    with start(project, "release", "--forcerun", "summary", *SMALL) as running:
        wait_for(lambda: bool(unfinished(project)))
        with (project / "workflow/oilfilm/units.py").open("a", encoding="utf-8") as module:
            module.write("# changed\n")
        output, _ = running.communicate()
    assert running.returncode != 0
    assert "The code has changed while it ran" in output


# A file system of its own for results, as large as is said; it ends with the process.
_DISK = [*("unshare", "--user", "--map-root-user", "--mount"), "sh", "-c"]


@pytest.mark.nightly
@pytest.mark.skipif(
    not works([*_DISK, "mount -t tmpfs tmpfs /mnt"]), reason="no file system may be mounted here"
)
def test_read_only_and_full_disk_are_told_and_the_next_run_goes_on(
    undisturbed: Path, new: Path
) -> None:
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
    assert "The disk can only be read" in read_only
    assert "The disk is full. Make room on it" in full
    assert file_difference(undisturbed / POINTS, new / "points.parquet") == ""


@pytest.mark.nightly
def test_file_too_large_for_the_quota_is_told(undisturbed: Path, new: Path) -> None:
    limited = Surroundings("2", {}, ["sh", "-c", 'ulimit -f 200 && exec "$@"', "sh"])
    message = fail(new, POINTS, *SMALL, around=limited)
    assert "A file would be larger than is allowed here" in message
    succeed(new, POINTS, *SMALL)
    assert file_difference(undisturbed / POINTS, new / POINTS) == ""


def wait_for(condition: Callable[[], bool]) -> None:
    for _ in range(1200):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited for a minute in vain")


def test_second_run_is_refused_and_a_killed_one_is_in_nobodys_way(
    undisturbed: Path, tmp_path: Path
) -> None:
    new = tmp_path / "new"
    shutil.copytree(undisturbed, new, symlinks=True)
    again = (POINTS, "--forcerun", "points", *SMALL, IN_ONE_SHARE)
    with start(new, *again, stdout=subprocess.DEVNULL, new_session=True) as first:
        wait_for(lambda: bool(unfinished(new)))
        os.killpg(first.pid, signal.SIGSTOP)  # it must not end while the second one starts
        assert "Another run is active in" in fail(new, *again)
        # the run alone, so that its job lives on
        first.kill()
        os.killpg(first.pid, signal.SIGCONT)
    # another date, user, locale, time zone and order of hashes, and a Python without assertions
    around = Surroundings("1", unusual(tmp_path).environment)
    code, output = run(new, POINTS, *SMALL, IN_ONE_SHARE, around=around)
    while code != 0:
        assert "Another run is active in" in output
        code, output = run(new, POINTS, *SMALL, IN_ONE_SHARE, around=around)
    assert file_difference(undisturbed / POINTS, new / POINTS) == ""


@pytest.mark.nightly
def test_log_that_grows_during_a_run_is_read_whole_or_not_at_all(
    undisturbed: Path, new: Path
) -> None:
    """A measured log is half copied when the run begins, and whole soon after."""
    log = lay_out_measured(undisturbed, new) / "4102_P1.50_U40_T120.csv"
    target = ("results/own/tables/points.parquet", "--config", "campaign=own")
    content = log.read_bytes()
    log.write_bytes(content[: len(content) // 2])
    with start(new, *target) as running:
        wait_for(lambda: bool(unfinished(new)))
        log.write_bytes(content)
        output, _ = running.communicate()
    if running.returncode != 0:
        assert f"{log.name}: has changed while it was read" in output
    assert "Traceback" not in output
    listing = new / "data/first_seen/own.sha256"
    listing.unlink(missing_ok=True)  # half a log may have been the first one that was seen
    succeed(new, *target)
    expected = tables.read("points", undisturbed / POINTS)
    assert tables.read("points", new / target[0]).equals(expected)


def test_log_of_the_twin_that_somebody_has_changed_is_refused(undisturbed: Path) -> None:
    log = undisturbed / "data/raw/small/4102_P1.50_U40_T120.csv"
    before, stamps = log.read_bytes(), log.stat()
    try:
        log.write_bytes(before[:-100])
        message = fail(undisturbed, POINTS, *SMALL)
    finally:
        log.write_bytes(before)
        os.utime(log, ns=(stamps.st_atime_ns, stamps.st_mtime_ns))
    assert f"{log.name}: is not as the rig twin wrote it. Delete" in message


@pytest.mark.nightly
def test_clock_that_has_stepped_back_stops_no_run(undisturbed: Path) -> None:
    """Every file is dated in the future, furthest what was made first."""
    paths = [path for path in (undisturbed / "results/small").rglob("*") if path.is_file()]
    contents = {path: path.read_bytes() for path in paths}
    stamps = {path: path.stat() for path in paths}
    newest_first = sorted(paths, key=lambda path: stamps[path].st_mtime_ns, reverse=True)
    now = time.time_ns()
    try:
        for hours, path in enumerate(newest_first, start=1):
            os.utime(path, ns=(now, now + hours * 3_600_000_000_000))
        succeed(undisturbed, *SMALL)
        assert {path: path.read_bytes() for path in paths} == contents
    finally:
        for path, stamp in stamps.items():
            os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("report.html", "report"),
        ("figures/curves.png", "data-figures"),
        ("exports/4102/traction_4102.h", "exports"),
        ("parts/collect/4102/points.parquet", "collect"),
    ],
)
def test_damaged_result_is_not_released_until_its_step_is_done_anew(
    undisturbed: Path, name: str, step: str
) -> None:
    """One bit is turned over, and the time stamp is as it was."""
    path, again = undisturbed / "results/small" / name, ("release", "--forcerun", "release", *SMALL)
    before, stamp = path.read_bytes(), path.stat()
    path.write_bytes(before[:-9] + bytes([before[-9] ^ 1]) + before[-8:])
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    made = f"results/small/made/{step}.sha256"
    message = fail(undisturbed, *again)
    assert f"results/small/{name}: is not as its step wrote it. Remove {made}" in message
    (undisturbed / made).unlink()
    assert "exists already, with the same bytes" in succeed(undisturbed, *again)
    assert path.read_bytes() == before


@pytest.mark.nightly
def test_damaged_table_is_refused_and_made_again(undisturbed: Path) -> None:
    """A sector of the disk reads otherwise."""
    table = "results/small/tables/correlations.parquet"
    path = undisturbed / table
    before = path.read_bytes()
    path.write_bytes(before[:100] + bytes(512) + before[612:])
    assert f"{path.name}: cannot be read as Parquet" in fail(undisturbed, *SMALL)
    path.unlink()
    succeed(undisturbed, table, *SMALL)
    assert path.read_bytes() == before
