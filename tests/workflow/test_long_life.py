"""The life of a campaign: whatever changes, its results are those of a clean run, byte for byte."""

import os
import random
import shutil
from collections.abc import Collection
from copy import deepcopy
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from campaigns import ROOT, lay_out, lay_out_measured, read_campaign, write_campaign
from extensions import EXTENSIONS, apply
from reproduce import compare, succeed

pytestmark = [pytest.mark.workflow, pytest.mark.nightly]

LIFE = ("--config", "campaign=life")
RAW = Path("data/raw/life")
OILS, LATER_OIL = ["4102", "4050"], "4010"
MATRIX = {
    "max_hertz_pressure_gpa": [1.0, 1.5],
    "entrainment_speed_m_s": [25, 40],
    "inlet_temperature_c": [50, 120],
}
# Changes of a setting, each with what the campaign file then says.
SETTINGS: dict[str, Any] = {
    "a law is added": {"compare": {"laws": ["tanh", "carreau"]}},
    "a limit is lower": {"gates": {"traction_change_max": 0.0004}},
    "shares are smaller": {"split": {"runs": 6}},
}
AN_OIL, A_FIGURE, A_COLUMN = "an oil is added", "a figure is added", "a column is added"
GONE, GONE_TOO, EXCLUDED, EDITED = "a log is gone", "another is gone", "one excluded", "one edited"
ABOUT_LOGS = (GONE, GONE_TOO, EXCLUDED, EDITED)
CHANGES = (*SETTINGS, AN_OIL, A_FIGURE, A_COLUMN, *ABOUT_LOGS)
# Of every log, changed or not: 1 January 2020, in s since 1970.
OLD_DATE = 1_577_836_800


@dataclass(frozen=True)
class Beginning:
    """A campaign before any change.

    Attributes:
        campaign: Its file.
        logs: All its logs by name, those of the later oil too.
        chosen: The log that a change is about.
    """

    campaign: dict[str, Any]
    logs: dict[str, bytes]
    chosen: dict[str, str]

    def with_changes(self, project: Path, changes: Collection[str]) -> None:
        """Write the files of a project that are not as these changes make them."""
        write_campaign(project, "life", self._campaign(changes))
        self._write_logs(project / RAW, changes)
        column = EXTENSIONS["A column"]
        for path in {edit.path for edit in column if edit.path.startswith("workflow/")}:
            shutil.copy(ROOT / path, project / path)
        if A_COLUMN in changes:
            apply(column, project)

    def _campaign(self, changes: Collection[str]) -> dict[str, Any]:
        campaign = deepcopy(self.campaign)
        campaign["oils"] = [*OILS, LATER_OIL] if AN_OIL in changes else OILS
        campaign["figures"] = ["curves", "constants"] if A_FIGURE in changes else ["curves"]
        for change in SETTINGS.keys() & changes:
            campaign["settings"] |= SETTINGS[change]
        if EDITED in changes:
            was = self.logs[self.chosen[EDITED]]
            digests = {"was": _digest(was), "now": _digest(_edited(was))}
            log = f"{RAW.as_posix()}/{self.chosen[EDITED]}"
            campaign["acknowledged_changes"] = [{"log": log, **digests, "reason": "a test"}]
        return campaign

    def _write_logs(self, folder: Path, changes: Collection[str]) -> None:
        logs = dict(self.logs)
        for change in {GONE, GONE_TOO} & {*changes}:
            del logs[self.chosen[change]]
        if EDITED in changes:
            logs[self.chosen[EDITED]] = _edited(logs[self.chosen[EDITED]])
        if AN_OIL not in changes:
            logs = {name: log for name, log in logs.items() if not name.startswith(LATER_OIL)}
        if EXCLUDED in changes:
            logs["runs.csv"] = f"file,exclude\n{self.chosen[EXCLUDED]},a test\n".encode()
        folder.mkdir(parents=True, exist_ok=True)
        for path in {*folder.iterdir()} - {folder / name for name in logs}:
            path.unlink()
        for name, log in logs.items():
            path = folder / name
            if not path.is_file() or path.read_bytes() != log:
                path.write_bytes(log)
                os.utime(path, (OLD_DATE, OLD_DATE))


def _edited(log: bytes) -> bytes:
    """A log of the same size with another traction force in one row."""
    rows = log.split(b"\n")
    middle = len(rows) // 2
    cells = rows[middle].split(b",")
    cells[2] = cells[2][:-1] + (b"2" if cells[2].endswith(b"1") else b"1")
    rows[middle] = b",".join(cells)
    return b"\n".join(rows)


def _digest(log: bytes) -> str:
    return sha256(log).hexdigest()[:16]


@pytest.mark.parametrize("seed", [1])
def test_twenty_changes_each_end_in_the_bytes_of_a_clean_run(seed: int, tmp_path: Path) -> None:
    project, dice = tmp_path / "project", random.Random(seed)
    raw = lay_out_measured(project, "life", [*OILS, LATER_OIL], MATRIX)
    logs = {path.name: path.read_bytes() for path in sorted(raw.iterdir())}
    of_first_oils = [name for name in logs if not name.startswith(LATER_OIL)]
    chosen = dict(zip(ABOUT_LOGS, dice.sample(of_first_oils, len(ABOUT_LOGS)), strict=True))
    campaign = read_campaign(project, "life")
    # few steps: each takes longer to start than to compute
    campaign["settings"]["fit"]["law"] = "tanh"
    del campaign["settings"]["split"]
    beginning = Beginning(campaign, logs, chosen)
    beginning.with_changes(project, ())
    succeed(project, *LIFE)
    changes: set[str] = set()
    for step in range(20):
        changes ^= {dice.choice(CHANGES)}
        beginning.with_changes(project, changes)
        succeed(project, *LIFE)
        clean = tmp_path / f"clean-{step}"
        lay_out(clean)
        beginning.with_changes(clean, changes)
        succeed(clean, *LIFE)
        assert compare(clean, project) == "", f"step {step}, with {sorted(changes)}"
