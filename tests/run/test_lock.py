"""A lock that ends with its holders: one run at a time, and no dead one in the way."""

import subprocess
import sys
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.errors import OilfilmError
from oilfilm.run.lock import job_lock, lock_run


def another_run(records: Path) -> subprocess.Popen[str]:
    """A process that is a run until it is killed."""
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


def test_second_run_is_refused_and_a_killed_one_is_forgotten(tmp_path: Path) -> None:
    with another_run(tmp_path) as first:
        with pytest.raises(OilfilmError, match="Another run is active"):
            lock_run(tmp_path)
        with job_lock(tmp_path):  # its own jobs work beside it
            first.kill()
            first.wait()
            with pytest.raises(OilfilmError, match="a job of one that was killed"):
                lock_run(tmp_path)
    with another_run(tmp_path) as second:
        second.kill()
