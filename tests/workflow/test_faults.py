"""What goes wrong on a machine: the next run ends in the same bytes, or says what to do.

`make bench-faults` kills thirty times; here are a few kills and one of every other fault.
"""

import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd
import pytest
import yaml

from campaigns import ROOT, lay_out_small, write_campaign
from oilfilm import tables
from oilfilm.releases.manifest import PINNED_MANIFEST, FileRecord, Manifest, read_manifest
from oilfilm.releases.pin import pin
from oilfilm.releases.table_diff import file_difference
from reproduce import (
    Surroundings,
    command,
    compare,
    fake_clock,
    killed,
    run,
    unfinished,
    unusual,
    usual,
    works,
)

pytestmark = pytest.mark.workflow

TWO = Surroundings("2")
SMALL = ("--config", "campaign=small")
# Snakemake's own sentence where its lock is there still, else ours.
REFUSED = re.compile(r"Directory cannot be locked|Another run is active in")
POINTS = "results/small/tables/points.parquet"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with an undisturbed run and its release."""
    place = tmp_path_factory.mktemp("whole")
    lay_out_small(place)
    done = run(place, usual(), "release", *SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    return place


def said(done: subprocess.CompletedProcess[str]) -> str:
    text = done.stdout + done.stderr
    assert "Traceback" not in text, text
    return text


def test_run_needs_no_network_and_unpickles_nothing(whole: Path) -> None:
    """The guard (tests/guard) would have raised, and written down what was tried."""
    assert not (whole / "guard.log").exists()


def test_killed_run_ends_in_the_same_bytes_when_it_is_run_again(
    whole: Path, tmp_path: Path
) -> None:
    """Killed again and again, a day ahead of the clock at first."""
    lay_out_small(tmp_path)
    ahead = fake_clock("+1d")
    for files, clock in ((0, ahead), (3, ahead), (15, {}), (40, {})):
        assert killed(tmp_path, 1.5, "--cores", "2", "release", *SMALL, files=files, clock=clock)
    done = run(tmp_path, TWO, "release", *SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    assert compare(whole, tmp_path) == ""


def test_release_that_is_found_leaves_the_same_bytes_as_one_that_is_made(
    whole: Path, tmp_path: Path
) -> None:
    """As after a kill between the release and Snakemake's own record of it."""
    place = tmp_path / "again"
    shutil.copytree(whole, place, symlinks=True)
    done = run(place, TWO, "release", "--forcerun", "release", *SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "exists already, with the same bytes" in said(done)
    assert compare(whole, place) == ""


def test_code_that_changes_during_a_run_is_not_released(whole: Path, tmp_path: Path) -> None:
    place = tmp_path / "edited"
    shutil.copytree(whole, place, symlinks=True)
    called, environment = command(place, "--cores", "2", "release", "--forcerun", "summary", *SMALL)
    with subprocess.Popen(
        called, cwd=place, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as running:
        wait_for(lambda: bool(unfinished(place)))
        with (place / "workflow/oilfilm/units.py").open("a", encoding="utf-8") as module:
            module.write("# changed\n")
        assert running.stdout is not None
        text = running.stdout.read().decode()
    assert running.returncode != 0
    assert "The code has changed while it ran" in text


def nightly(place: Path, around: Surroundings) -> subprocess.CompletedProcess[str]:
    (python, *_), environment = command(place)
    return subprocess.run(
        [*around.before, python, str(ROOT / ".ci/nightly.py"), "small"],
        cwd=place,
        env={**environment, **around.environment},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def pinned(whole: Path) -> Iterator[Path]:
    kept = pin(whole / "results/releases/small/latest", whole)
    yield kept
    shutil.rmtree(kept)


def test_nightly_passes_where_nothing_moved_and_rebuilds_the_same_bytes_in_other_surroundings(
    whole: Path, pinned: Path, tmp_path: Path
) -> None:
    around = unusual(tmp_path)
    done = nightly(whole, around)
    assert done.returncode == 0, done.stdout + done.stderr
    summary = (whole / "results/nightly/small.md").read_text(encoding="utf-8")
    for step in ("refit", "drift gate", "verify"):
        assert f"## {step}: passed" in summary
    assert "rebuilt from the raw logs: the same bytes" in summary
    shutil.rmtree(whole / "results/nightly")
    if around.lacking:
        pytest.skip(f"the same bytes, but not with {', '.join(around.lacking)}")


def make_larger(pinned: Path, factor: float) -> str:
    """Make the first constant of a pin larger, in table and manifest; the constant's name."""
    path = pinned / "tables/coefficients.parquet"
    frame, footer = tables.read("coefficients", path), tables.read_footer(path)
    frame.loc[0, "value"] *= factor
    made_by = {key: footer[key] for key in footer.keys() - {"table", "schema_version"}}
    tables.write(frame, "coefficients", path, made_by)
    manifest, _ = read_manifest(pinned)
    record = FileRecord.of(pinned, "tables/coefficients.parquet")
    files = tuple(record if each.path == record.path else each for each in manifest.files)
    text = Manifest(manifest.made_from, files, manifest.samples).text()
    (pinned / PINNED_MANIFEST).write_text(text, encoding="utf-8")
    return str(frame.loc[0, "constant"])


def test_nightly_fails_with_a_table_of_what_moved(whole: Path, pinned: Path) -> None:
    """One constant of the pin is made half as large again: 14 standard errors."""
    moved = make_larger(pinned, 1.5)
    done = nightly(whole, TWO)
    assert done.returncode == 1
    summary = (whole / "results/nightly/small.md").read_text(encoding="utf-8")
    assert "## drift gate: failed" in summary
    assert "## verify: not run" in summary
    assert moved in summary
    shutil.rmtree(whole / "results/nightly")


def points_of(place: Path, campaign: str = "small") -> pd.DataFrame:
    return tables.read("points", place / f"results/{campaign}/tables/points.parquet")


# A file system of its own for results, as large as is said; it ends with the process.
_DISK = [*("unshare", "--user", "--map-root-user", "--mount"), "sh", "-c"]


@pytest.mark.skipif(
    not works([*_DISK, "mount -t tmpfs tmpfs /mnt"]), reason="no file system may be mounted here"
)
def test_read_only_and_full_disk_are_told_and_the_next_run_goes_on(
    whole: Path, tmp_path: Path
) -> None:
    lay_out_small(tmp_path)
    (tmp_path / "results").mkdir()
    called, environment = command(tmp_path, "--cores", "2", POINTS, *SMALL)
    script = """
        mount -t tmpfs -o ro tmpfs results
        "$@" >read-only.txt 2>&1 && exit 1
        mount -o remount,rw,size=400k results
        "$@" >full.txt 2>&1 && exit 2
        mount -o remount,size=100m results
        "$@" >enough.txt 2>&1 || exit 3
        cp results/small/tables/points.parquet .
    """
    done = subprocess.run(
        [*_DISK, script, "sh", *called], cwd=tmp_path, env=environment, check=False
    )
    read_only, full = ((tmp_path / f"{name}.txt").read_text() for name in ("read-only", "full"))
    assert done.returncode == 0, read_only + full
    assert "Traceback" not in read_only + full
    assert "Read-only file system" in read_only
    assert "The disk is full. Make room on it" in full
    assert file_difference(whole / POINTS, tmp_path / "points.parquet") == ""


def test_file_too_large_for_the_quota_is_told(whole: Path, tmp_path: Path) -> None:
    lay_out_small(tmp_path)
    # without its configuration coverage leaves the run alone: its records are larger than that
    untraced = [
        "env",
        "-u",
        "COVERAGE_PROCESS_CONFIG",
        "sh",
        "-c",
        'ulimit -f 200 && exec "$@"',
        "sh",
    ]
    limit = Surroundings("2", {}, untraced)
    text = said(run(tmp_path, limit, POINTS, *SMALL))
    assert "A file would be larger than is allowed here" in text
    done = run(tmp_path, TWO, POINTS, *SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    assert file_difference(whole / POINTS, tmp_path / POINTS) == ""


def wait_for(condition: Callable[[], bool]) -> None:
    for _ in range(1200):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("waited for a minute in vain")


def test_second_run_is_refused_and_a_killed_one_is_in_nobodys_way(
    whole: Path, tmp_path: Path
) -> None:
    lay_out_small(tmp_path)
    called, environment = command(tmp_path, "--cores", "2", POINTS, *SMALL)
    records = tmp_path / ".snakemake"
    with subprocess.Popen(
        called, cwd=tmp_path, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as first:
        wait_for(lambda: any((records / "incomplete").glob("*")))
        second = run(tmp_path, TWO, POINTS, *SMALL)
        assert second.returncode != 0
        assert REFUSED.search(said(second))
        # the run alone, so that its job lives on
        first.kill()
    third = run(tmp_path, TWO, POINTS, *SMALL)
    while third.returncode != 0:
        assert REFUSED.search(said(third))
        third = run(tmp_path, TWO, POINTS, *SMALL)
    assert file_difference(whole / POINTS, tmp_path / POINTS) == ""


def test_log_that_grows_during_a_run_is_read_whole_or_not_at_all(
    whole: Path, tmp_path: Path
) -> None:
    """A measured log is half copied when the run begins, and whole soon after."""
    lay_out_small(tmp_path)
    shutil.copytree(
        whole / "data/raw/small", tmp_path / "data/raw/own", ignore=shutil.ignore_patterns(".*")
    )
    campaign = yaml.safe_load((tmp_path / "config/campaigns/small.yaml").read_text("utf-8"))
    del campaign["twin"]
    write_campaign(tmp_path, "own", campaign)
    target = ("results/own/tables/points.parquet", "--config", "campaign=own")
    log = tmp_path / "data/raw/own/4102_P1.50_U40_T120.csv"
    content = log.read_bytes()
    log.write_bytes(content[: len(content) // 2])
    called, environment = command(tmp_path, "--cores", "2", *target)
    with subprocess.Popen(
        called, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as running:
        wait_for(lambda: any((tmp_path / ".snakemake/locks").glob("*")))
        log.write_bytes(content)
        assert running.stdout is not None
        text = running.stdout.read().decode()
    # changed before its digest was taken, or after
    assert running.returncode == 0 or f"{log.name}: has changed since the run began" in text
    assert "Traceback" not in text
    # a copy that keeps the time stamp of the rig, which is older than anything here
    os.utime(log, (0, 0))
    done = run(tmp_path, TWO, *target)
    assert done.returncode == 0, done.stdout + done.stderr
    assert points_of(tmp_path, "own").equals(points_of(whole))
    changed = content.replace(b"\n", b"\n\n", 1)
    log.write_bytes(changed)
    os.utime(log, (0, 0))
    assert "ingest" in said(run(tmp_path, TWO, "--dry-run", *target)).partition("Job stats")[2]


def test_log_of_the_twin_that_somebody_has_changed_is_refused(whole: Path) -> None:
    log = whole / "data/raw/small/4102_P1.50_U40_T120.csv"
    before, stamps = log.read_bytes(), log.stat()
    try:
        log.write_bytes(before[:-100])
        done = run(whole, TWO, *SMALL)
    finally:
        log.write_bytes(before)
        os.utime(log, ns=(stamps.st_atime_ns, stamps.st_mtime_ns))
    assert done.returncode != 0
    assert f"{log.name}: is not as the rig twin wrote it. Delete" in said(done)


def test_clock_that_has_stepped_back_stops_no_run(whole: Path) -> None:
    """Every file is dated in the future, furthest what was made first."""
    files = sorted(path for path in (whole / "results/small").rglob("*") if path.is_file())
    contents = {path: path.read_bytes() for path in files}
    stamps = {path: path.stat() for path in files}
    in_order = sorted(files, key=lambda path: stamps[path].st_mtime_ns)
    now = time.time_ns()
    try:
        for place, path in enumerate(in_order):
            os.utime(path, ns=(now, now + (len(files) - place) * 3_600_000_000_000))
        again = run(whole, TWO, *SMALL)
        assert again.returncode == 0, said(again)
        assert {path: path.read_bytes() for path in files} == contents
    finally:
        for path, stamp in stamps.items():
            os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


def test_damaged_table_is_refused_and_made_again(whole: Path) -> None:
    """A sector of the disk reads otherwise."""
    path = whole / "results/small/tables/extrapolation_errors.parquet"
    before = path.read_bytes()
    path.write_bytes(before[:100] + bytes(512) + before[612:])
    refused = run(whole, TWO, *SMALL)
    assert refused.returncode != 0
    assert f"{path.name}: cannot be read as Parquet" in said(refused)
    path.unlink()
    done = run(whole, TWO, str(path.relative_to(whole)), *SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    assert path.read_bytes() == before
