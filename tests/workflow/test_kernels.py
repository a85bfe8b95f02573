"""The same campaign on the kernels of other CPUs: every verdict, statement and number."""

import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from campaigns import QUICK, SMALL_MATRIX, lay_out, simulated_campaign, write_campaign
from command_line import succeeded
from oilfilm import tables
from oilfilm.releases.statements import changed_statements
from oilfilm.traction import LAW_FILES
from other_cpus import CPUS, ENVIRONMENT, environment_of, table_changes
from reproduce import Surroundings, command, succeed

pytestmark = pytest.mark.workflow

# Every CPU of x86-64 can do what it could.
OLDEST, *OTHERS = CPUS
# The newest that this machine has. Those between can wait for the night.
NEWEST = [name for name, cpu in CPUS.items() if not cpu.lacking()][-1:]
OIL = "4010"
LAW_FILE_NAMES = [LAW_FILES[law].stem for law in QUICK["compare"]["laws"]]
JOBS = [
    *("points share=0", "collect"),
    *(f"fit oil={OIL} law_file={name}" for name in LAW_FILE_NAMES),
    f"surface oil={OIL}",
    *("fits", "torque_runs", "bearing_maps", "torque"),
]
Run = Callable[[str], Path]


def bearing_study(project: Path) -> None:
    """Lay out a simulated campaign of one oil and a bearing, some of whose cages skid.

    Its logs are written by the kernel of this machine. The night compares the
    demonstration: three oils, the plans, the figures and the report.
    """
    campaign = simulated_campaign()
    lay_out(project)
    campaign |= {"oils": [OIL], "figures": ["constants"], "matrix": SMALL_MATRIX}
    defect = {"oil": OIL, "condition": [1.0, 25, 50], "kind": "truncated"}
    campaign["twin"] |= {"sampling_rate_hz": 20, "defects": [defect]}
    defect = {"oil": OIL, "axial_load_n": 5000, "oil_temperature_c": 70, "kind": "tare_drift"}
    campaign["torque"]["twin"]["defects"] = [defect]
    campaign["torque"]["matrix"] = {
        "axial_load_n": [5000, 20000],
        "inner_speed_rpm": [6000, 12000],
        "oil_temperature_c": [70],
    }
    bearing: dict[str, Any] = {
        "uncertainty": {"draws": 40},
        "cage_slip": {
            "pitch_speed_mm_rpm": [1e6, 4e6],
            "axial_load_n": [1000, 20000],
            "further_temperature_c": [140],
        },
        "size_effect": {"ball_size_factors": [0.5, 1.0], "groove_curvatures": [0.51]},
    }
    campaign["settings"] = {**QUICK, "bearing": bearing}
    write_campaign(project, "kernels", campaign)


def results_by(name: str, blank: Path, jobs: Sequence[str]) -> Path:
    """Run jobs on a copy of a project as a CPU does, in one process; the folder of the results."""
    cpu = CPUS[name]
    if reason := cpu.lacking():
        pytest.skip(reason)
    project = shutil.copytree(blank, blank.with_name(name))
    output = run_jobs(project, jobs, cpu.environment)
    cpu.refuse_other(environment_of(output))
    return project / "results/kernels"


def run_jobs(project: Path, jobs: Sequence[str], kernel: Mapping[str, str]) -> str:
    """Run jobs of a project in one process; what it prints, and last its environment."""
    lines = [
        "import sys; sys.path.insert(0, 'workflow'); from stand_in import main",
        *(f"main({[*job.split(), 'campaign=kernels']})" for job in jobs),
        ENVIRONMENT,
    ]
    (python, *_), environment = command(project)
    return succeeded([python, "-c", "\n".join(lines)], cwd=project, env={**environment, **kernel})


def table_of(results: Path, name: str) -> pd.DataFrame | None:
    """A table of finished results; None where they have none."""
    path = results / f"tables/{name}.parquet"
    return tables.read(name, path) if path.exists() else None


def unlike(before: Path, after: Path) -> list[str]:
    """What differs between the results of two CPUs, by table."""
    changes = list(table_changes(before, after))
    statements = changed_statements(
        partial(table_of, before), partial(table_of, after), error_change=0.1
    )
    return changes + [", ".join(statement[:-1]) for statement in statements]


@pytest.mark.nightly
@pytest.mark.skipif(NEWEST == [OLDEST], reason="this machine has the oldest kernel alone")
def test_no_kernel_changes_a_verdict_or_a_number_beyond_its_error(tmp_path: Path) -> None:
    blank = tmp_path / "blank"
    blank.mkdir()
    bearing_study(blank)
    run_jobs(blank, ["twin", "torque_twin"], {})
    oldest, newest = (results_by(name, blank, JOBS) for name in (OLDEST, *NEWEST))
    assert unlike(oldest, newest) == []


# ---------------------------------------------------------------- the demonstration


@pytest.fixture(scope="module")
def demonstration(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Runs the demonstration as a CPU does; the folder of its results."""

    def run_as(name: str) -> Path:
        cpu = CPUS[name]
        if reason := cpu.lacking():
            pytest.skip(reason)
        project = tmp_path_factory.mktemp("demonstration")
        lay_out(project)
        around = Surroundings("2", cpu.environment)
        succeed(project, "results/demo/summary.txt", around=around)
        (python, *_), environment = command(project)
        output = succeeded(
            [python, "-c", ENVIRONMENT], cwd=project, env={**environment, **cpu.environment}
        )
        cpu.refuse_other(environment_of(output))
        return project / "results/demo"

    return run_as


@pytest.fixture(scope="module")
def oldest_demonstration(demonstration: Run) -> Path:
    """The demonstration by the oldest of the CPUs."""
    return demonstration(OLDEST)


@pytest.mark.nightly
@pytest.mark.parametrize("name", OTHERS)
def test_no_kernel_changes_the_demonstration(
    oldest_demonstration: Path, demonstration: Run, name: str
) -> None:
    results = demonstration(name)
    assert unlike(oldest_demonstration, results) == []
    old_lines, new_lines = (
        (folder / "summary.txt").read_text(encoding="utf-8").splitlines()
        for folder in (oldest_demonstration, results)
    )
    assert [line for line in new_lines if line not in old_lines] == []
