"""A lock that ends with its holder: one run at a time, and no dead one in the way."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.errors import OilfilmError
from oilfilm.run.lock import clear_leftovers, job_lock, lock_run


def another_run(records: Path) -> subprocess.Popen[str]:
    """A process that is a run until its standard input closes."""
    program = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'workflow')!r})\n"
        "from pathlib import Path; from oilfilm.run.lock import lock_run\n"
        f"lock_run(Path({str(records)!r})); print('begun', flush=True); sys.stdin.read()"
    )
    run = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert run.stdout is not None
    assert run.stdout.readline() == "begun\n"
    return run


def test_second_run_is_told_and_a_killed_one_is_forgotten(tmp_path: Path) -> None:
    left = tmp_path / "locks" / "0.output.lock"
    left.parent.mkdir()
    left.write_text("results/points.parquet\n", encoding="utf-8")
    with another_run(tmp_path) as first:
        with pytest.raises(OilfilmError, match=r"Another run is active in .* again"):
            lock_run(tmp_path)
        clear_leftovers(tmp_path, [tmp_path])
        assert left.exists()
        first.kill()
    clear_leftovers(tmp_path, [tmp_path])
    assert not left.exists()
    with another_run(tmp_path) as second:
        second.kill()


def test_job_that_outlives_its_run_keeps_others_out(tmp_path: Path) -> None:
    with job_lock(tmp_path), pytest.raises(OilfilmError, match="a job of one that was killed"):
        lock_run(tmp_path)


def test_job_works_beside_its_own_run(tmp_path: Path) -> None:
    with another_run(tmp_path) as run:
        with job_lock(tmp_path):
            assert run.poll() is None
        run.kill()


def test_dates_in_the_future_become_now_and_others_stay(tmp_path: Path) -> None:
    now = time.time()
    for name, stamp in (("future", now + 86_400), ("past", now - 86_400)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (stamp, stamp))
    clear_leftovers(tmp_path / "records", [tmp_path, tmp_path / "not there"])
    assert now <= (tmp_path / "future").stat().st_mtime <= time.time()
    assert (tmp_path / "past").stat().st_mtime == pytest.approx(now - 86_400)
