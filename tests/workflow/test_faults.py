"""What goes wrong on a machine: the next run ends in the same bytes, or says what to do.

`make bench-faults` kills thirty times; here are a few kills and one of every other fault.
"""

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from campaigns import ROOT, lay_out_small
from oilfilm.releases.pin import pin
from reproduce import (
    Surroundings,
    command,
    compare,
    fake_clock,
    killed,
    run,
    unusual,
    usual,
)

pytestmark = pytest.mark.workflow

TWO = Surroundings("2")
SMALL = ("--config", "campaign=small")
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
    for seconds, clock in ((6, "+1d"), (9, "+1d"), (12, ""), (15, "")):
        killed(tmp_path, seconds, "--cores", "2", "release", *SMALL, environment=fake_clock(clock))
    done = run(tmp_path, TWO, "release", *SMALL)
    assert done.returncode == 0, done.stdout + done.stderr
    assert compare(whole, tmp_path) == ""


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


def test_nightly_fails_with_a_table_of_what_moved(whole: Path, pinned: Path) -> None:
    """One constant of the pin is made 1 % larger: many standard errors."""
    moved = make_larger(pinned, 1.01)
    done = nightly(whole, TWO)
    assert done.returncode == 1
    summary = (whole / "results/nightly/small.md").read_text(encoding="utf-8")
    assert "## drift gate: failed" in summary
    assert "## verify: not run" in summary
    assert moved in summary
    shutil.rmtree(whole / "results/nightly")
