"""The same campaign on the kernels of other CPUs: every verdict and sentence, and every number."""

import shutil
from collections.abc import Callable
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
# Each kernel costs as much as the campaign: those between the oldest and the newest that this
# machine has can wait for the night.
NEWEST = [name for name, cpu in CPUS.items() if not cpu.lacking()][-1:]
OILS = ("4102", "4010")
LAW_FILE_NAMES = [LAW_FILES[law].stem for law in QUICK["compare"]["laws"]]
JOBS = [
    *("twin", "torque_twin", "points shard=0", "collect", "run_plan"),
    *(f"fit oil={oil} law_file={name}" for oil in OILS for name in LAW_FILE_NAMES),
    *(f"surface oil={oil}" for oil in OILS),
    *("fits", "torque_runs", "bearing_maps", "bearing_temperatures", "torque", "test_plan"),
    *("refused", "law_figures"),
    "report",
]
Run = Callable[[str], Path]


def bearing_study(project: Path) -> None:
    """Lay out a simulated campaign of two oils and a bearing, some of whose cages skid."""
    campaign = simulated_campaign()
    lay_out(project)
    campaign |= {"oils": [*OILS], "figures": ["constants"], "matrix": SMALL_MATRIX}
    defect = {"oil": "4102", "condition": [1.0, 25, 50], "kind": "truncated"}
    campaign["twin"] |= {"sampling_rate_hz": 20, "defects": [defect]}
    defect = {"oil": "4010", "axial_load_n": 5000, "oil_temperature_c": 70, "kind": "tare_drift"}
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
    plan = {
        "tests": 2,
        "levels": {
            "max_hertz_pressure_gpa": [1.0, 1.5, 2.0],
            "entrainment_speed_m_s": [20, 40],
            "inlet_temperature_c": [70, 120],
        },
    }
    campaign["settings"] = {**QUICK, "bearing": bearing, "plan": plan}
    write_campaign(project, "kernels", campaign)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Runs the study as a CPU does, in one process; the folder of its results."""
    blank = tmp_path_factory.mktemp("kernels") / "blank"
    blank.mkdir()
    bearing_study(blank)

    def run_as(name: str) -> Path:
        cpu = CPUS[name]
        if reason := cpu.lacking():
            pytest.skip(reason)
        project = shutil.copytree(blank, blank.with_name(name))
        program = "\n".join(
            [
                "import sys; sys.path.insert(0, 'workflow'); from stand_in import main",
                *(f"main({[*job.split(), 'campaign=kernels']})" for job in JOBS),
                ENVIRONMENT,
            ]
        )
        (python, *_), environment = command(project)
        output = succeeded(
            [python, "-c", program], cwd=project, env={**environment, **cpu.environment}
        )
        cpu.refuse_other(environment_of(output))
        return project / "results/kernels"

    return run_as


@pytest.fixture(scope="module")
def oldest(run: Run) -> Path:
    """The results by the oldest of the CPUs."""
    return run(OLDEST)


def table_of(results: Path, name: str) -> pd.DataFrame | None:
    """A table of finished results; None where they have none."""
    path = results / f"tables/{name}.parquet"
    return tables.read(name, path) if path.exists() else None


def unlike(before: Path, after: Path) -> list[str]:
    """What differs between the results of two CPUs, by table, and lines of the summary."""
    changes = list(table_changes(before, after))
    statements = changed_statements(
        partial(table_of, before), partial(table_of, after), error_change=0.1
    )
    changes += [", ".join(statement[:-1]) for statement in statements]
    summaries = [(top / "summary.txt").read_text(encoding="utf-8") for top in (before, after)]
    lines = [text.split("\n") for text in summaries]
    return changes + [line for line in lines[1] if line not in lines[0]]


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.nightly] * (name not in NEWEST)) for name in OTHERS],
)
def test_no_kernel_changes_a_verdict_a_sentence_or_a_number_beyond_its_error(
    oldest: Path, run: Run, name: str
) -> None:
    assert unlike(oldest, run(name)) == []


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
    assert unlike(oldest_demonstration, demonstration(name)) == []
