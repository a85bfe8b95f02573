"""A lock that ends with its holder: one run at a time, and no dead one in the way."""

import errno
import fcntl
import getpass
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.errors import OilfilmError
from oilfilm.run import lock
from oilfilm.run.lock import clear_leftovers, job_lock, lock_run


def another_run(records: Path) -> subprocess.Popen[str]:
    """A process that is a run until its standard input closes."""
    program = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'workflow')!r})\n"
        "from pathlib import Path; from oilfilm.run.lock import lock_run\n"
        f"lock_run(Path({str(records)!r}), 'my-oils'); print('begun', flush=True); sys.stdin.read()"
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
        with pytest.raises(OilfilmError) as refusal:
            lock_run(tmp_path, "demo")
        assert f"of campaign 'my-oils' by {getpass.getuser()} on" in str(refusal.value)
        assert f"(process {first.pid}), begun 20" in str(refusal.value)
        assert clear_leftovers(tmp_path, [tmp_path]) == str(refusal.value)
        assert left.exists()
        first.kill()
    assert clear_leftovers(tmp_path, [tmp_path]) == ""
    assert not left.exists()
    with another_run(tmp_path) as second:
        assert second.stdin is not None
        second.stdin.close()
    assert not (tmp_path / "oilfilm.run.json").exists()


def test_job_that_outlives_its_run_keeps_others_out(tmp_path: Path) -> None:
    with job_lock(tmp_path), pytest.raises(OilfilmError, match="a job of one that was killed"):
        lock_run(tmp_path, "demo")


def test_job_works_beside_its_own_run(tmp_path: Path) -> None:
    with another_run(tmp_path) as run:
        with job_lock(tmp_path):
            assert run.poll() is None
        run.kill()


def note(records: Path, host: str, process: int, silent_s: float = 0.0) -> None:
    """What a run on some computer has left, or still renews."""
    said = {"campaign": "oil x", "user": "anna", "host": host, "process": process, "begun": "now"}
    path = records / "oilfilm.run.json"
    path.write_text(json.dumps(said), encoding="utf-8")
    os.utime(path, (time.time() - silent_s,) * 2)


def dead_process() -> int:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        pass
    return process.pid


def without_locks(*_: object) -> None:
    raise OSError(errno.ENOLCK, "No locks available")


def leftover(records: Path) -> Path:
    stale = records / "locks" / "0.output.lock"
    stale.parent.mkdir()
    stale.write_text("results/points.parquet\n", encoding="utf-8")
    return stale


@pytest.mark.parametrize("locks_work", [True, False])
def test_run_on_another_computer_keeps_others_out_until_it_is_long_silent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, locks_work: bool
) -> None:
    """A shared file system may keep locks within a computer, or have none at all."""
    if not locks_work:
        monkeypatch.setattr(fcntl, "flock", without_locks)
    stale = leftover(tmp_path)
    note(tmp_path, "another-host", 1, silent_s=60)
    with pytest.raises(OilfilmError, match=r"'oil x' by anna on another-host \(process 1\)"):
        lock_run(tmp_path, "demo")
    clear_leftovers(tmp_path, [])
    assert stale.exists()
    note(tmp_path, "another-host", 1, silent_s=600)
    clear_leftovers(tmp_path, [])
    assert not stale.exists()
    lock_run(tmp_path, "demo")


def test_without_locks_a_live_process_keeps_others_out_and_a_dead_one_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fcntl, "flock", without_locks)
    stale = leftover(tmp_path)
    note(tmp_path, platform.node(), os.getppid())
    with pytest.raises(OilfilmError, match="by anna on"):
        lock_run(tmp_path, "demo")
    note(tmp_path, platform.node(), dead_process())
    clear_leftovers(tmp_path, [])
    assert not stale.exists()
    lock_run(tmp_path, "demo")


def test_note_of_a_run_that_was_killed_on_this_computer_is_forgotten_at_once(
    tmp_path: Path,
) -> None:
    """The lock has ended with it, even where its number is another process by now."""
    note(tmp_path, platform.node(), os.getppid())
    lock_run(tmp_path, "demo")


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"campaign": 1}', b"[" * 100_000])
def test_note_that_cannot_be_read_keeps_nobody_out(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "oilfilm.run.json").write_bytes(content)
    lock_run(tmp_path, "demo")


def test_active_job_renews_the_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lock, "_BEAT_S", 0.01)
    note(tmp_path, "another-host", 1, silent_s=600)
    path, deadline = tmp_path / "oilfilm.run.json", time.monotonic() + 60
    old = path.stat().st_mtime
    with job_lock(tmp_path):
        while path.stat().st_mtime == old and time.monotonic() < deadline:
            time.sleep(0.01)
    assert path.stat().st_mtime > old


def test_dates_in_the_future_become_now_and_others_stay(tmp_path: Path) -> None:
    now = time.time()
    for name, stamp in (("future", now + 86_400), ("past", now - 86_400)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (stamp, stamp))
    clear_leftovers(tmp_path / "records", [tmp_path, tmp_path / "not there"])
    assert now <= (tmp_path / "future").stat().st_mtime <= time.time()
    assert (tmp_path / "past").stat().st_mtime == pytest.approx(now - 86_400)
