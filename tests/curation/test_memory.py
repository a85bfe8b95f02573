"""The memory that a log may take from its bytes to its verdict."""

import subprocess
import sys
import tracemalloc
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

import bad_logs
from campaigns import LABORATORY, ROOT
from oilfilm.curation.curate import curate_logs, curate_share
from oilfilm.logs.base import MOST_ROWS
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET
from oilfilm.settings.resolved import Settings

PHASES = (0.0, 0.004, 0.008, 0.012, 0.016, 0.02, 0.05, 0.07, 0.10, 0.12, 0.15, 0.20, 0.0)
# standard deviations of what a sensor adds of its own, in the units of the columns
NOISE = {
    "load": 0.04,
    "traction_force": 0.005,
    "ball_speed": 20,
    "disc_speed": 6,
    "inlet_temperature": 0.05,
}


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


def allocated_bytes(log: bytes, settings: Settings, folder: Path, *, by_rule: bool) -> int:
    """The most that Python and NumPy hold while a log is checked, or read by the rule `points`."""
    tracemalloc.start()
    try:
        if by_rule:
            path = folder / "log.csv"
            path.write_bytes(log)
            logs = RawLogs(folder, {path.name: path}, {path.name: sha256(log).hexdigest()})
            samples = {oil: folder / f"{oil}.parquet" for oil in settings.oils}
            curate_share(logs, settings, NO_SHEET, samples, {})
        else:
            curate_logs([("log.csv", log)], settings)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
@pytest.mark.parametrize(
    "by_rule",
    [pytest.param(False, id="check"), pytest.param(True, id="rule", marks=pytest.mark.nightly)],
)
def test_log_with_uneven_plateaus_takes_no_more_than_its_rows(
    config: Settings, tmp_path: Path, by_rule: bool
) -> None:
    # what is imported and made once is not counted
    allocated_bytes(slow_log(5_000), config, tmp_path, by_rule=by_rule)
    rows = 20_000
    assert allocated_bytes(slow_log(rows), config, tmp_path, by_rule=by_rule) < 200 * rows


# the last line is the largest resident size in KiB; that of `resource` counts the parent's, too
CHECK = """
import atexit, re, sys
from pathlib import Path
from oilfilm.cli import main
def print_peak():
    print(re.search(r"VmHWM: *([0-9]+)", Path("/proc/self/status").read_text().expandtabs())[1])
atexit.register(print_peak)
sys.exit(main(["check", *sys.argv[1:]]))
"""


@pytest.mark.nightly
def test_longest_log_is_checked_in_its_memory(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    # header lines count as rows where the rows of a text are limited. Lines that end as on Windows
    # are converted, which takes a second text
    log.write_bytes(slow_log(MOST_ROWS - 10).replace(b"\n", b"\r\n"))
    done = subprocess.run(
        [sys.executable, "-c", CHECK, log, "--config", LABORATORY, "--campaign", "laboratory"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    # 1: the log is refused, and every explanation of the refusal is tried
    assert done.returncode == 1
    assert int(done.stdout.splitlines()[-1]) * 1024 < 1.2e9
