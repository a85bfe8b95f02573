"""The memory that a log may take from its bytes to its verdict, each in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bad_logs
from campaigns import LABORATORY, ROOT

PHASES = (0.0, 0.004, 0.008, 0.012, 0.016, 0.02, 0.05, 0.07, 0.10, 0.12, 0.15, 0.20, 0.0)
# standard deviations of what a sensor adds of its own, in the units of the columns
NOISE = {
    "load": 0.04,
    "traction_force": 0.005,
    "ball_speed": 20,
    "disc_speed": 6,
    "inlet_temperature": 0.05,
}
CHECK = "from oilfilm.cli import main; main(sys.argv[1:])"
# what the rule `points` runs
SHARE = """
import hashlib
from pathlib import Path
from oilfilm.curation.curate import curate_share
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET
from oilfilm.settings.resolve import resolve
log = Path(sys.argv[1])
settings = resolve(Path("tests/laboratory"), {})
digest = hashlib.sha256(log.read_bytes()).hexdigest()
logs = RawLogs(log.parent, {log.name: log}, {log.name: digest})
samples = {oil: log.parent / f"{oil}.parquet" for oil in settings.oils}
curated = curate_share(logs, settings, NO_SHEET, samples, {})
assert len(curated.runs) == 1
"""


def slow_log(rows: int) -> bytes:
    """A sweep that a slow program drew out: short plateaus, and some of a tenth of the log."""
    steps = bad_logs.good(PHASES)
    random = np.random.default_rng(1)
    fast = np.arange(len(steps["time"]))
    slow = np.linspace(0, len(fast) - 1, rows)
    columns = {"time": np.arange(rows) / 50}
    for name, size in NOISE.items():
        smooth = np.convolve(np.pad(steps[name], 7, mode="edge"), np.ones(15) / 15, "valid")
        columns[name] = np.interp(slow, fast, smooth) + size * random.standard_normal(rows)
    return bad_logs.csv(columns)


# the last line is the largest resident size in KiB; that of `resource` counts the parent's, too
PEAK = """
import atexit, re, sys
from pathlib import Path
def print_peak():
    print(re.search(r"VmHWM: *([0-9]+)", Path("/proc/self/status").read_text().expandtabs())[1])
atexit.register(print_peak)
"""


def peak_mib(code: str, *arguments: object) -> float:
    """The largest resident size of a program of its own."""
    done = subprocess.run(
        [sys.executable, "-c", PEAK + code, *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT / "workflow")},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    # 1: the log is refused
    assert done.returncode in {0, 1}
    return int(done.stdout.splitlines()[-1]) / 1024


@pytest.mark.no_cover
def test_log_with_uneven_plateaus_takes_no_more_than_its_rows(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_bytes(slow_log(100_000))
    check = peak_mib(CHECK, "check", log, "--config", LABORATORY, "--campaign", "laboratory")
    share = peak_mib(SHARE, log)
    assert check < 300
    assert share < 300
