"""Time, memory and bytes of a campaign as it grows, from its logs on.

Whole runs of the default workflow on simulated logs, as if a laboratory had measured them:

- `oils`: 100, 1 000, 3 000 and 10 000 runs, a third of each oil; short logs (350 rows, 12 slips).
- `one oil`: 300 and 3 000 runs of one oil.
- `long logs`: 1 000 logs of 4 000 rows, as a rig writes them, from file to points.

Two dry runs come first; the second is measured. CPU times are used: user and system, of all
processes. Runs of `oils` are repeated, and the least time of each step counts: on a shared machine
the same step may take a quarter longer at one time than at another. The time of a whole run is the
sum of these. A straight line is fitted to the whole runs of all sizes; another one, through the two
sizes below the largest one, predicts that one. The largest two sizes predict a million runs. Growth
beyond the allowed limits ends in exit code 1.

    python benchmarks/scale.py [most runs]

Takes half an hour.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

from campaigns import lay_out, printed, simulated_campaign, write_campaign  # noqa: E402
from oilfilm.settings.resolve import resolve  # noqa: E402
from simulated_lab.simulate import simulate_campaign  # noqa: E402

COMMIT = subprocess.check_output(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], text=True)[
    :-1
]
CORES = 2
OILS = ("4102", "4050", "4010")
EXTRAPOLATED_RUNS = 10**6
SHORT = {"sampling_rate_hz": 10, "slip_steps": 12}
LONG = {"sampling_rate_hz": 50, "slip_steps": 31}
FIGURES = ["law-errors", "curves", "coverage", "residuals"]
# Name of a step by its script: Snakemake's own process.
NAMES = {"__main__.py": "snakemake"}
# Whole runs are off the fitted line by no more than this, and the largest one is above the line
# through the two sizes below it, or through the two smallest ones, by no more.
LINEAR = 0.10
ONE_OIL = 0.20
# Runs of one size of `oils`; the smaller sizes are those that predict.
ROUNDS, ROUNDS_OF_LARGEST, LARGEST = 3, 2, 10_000
# The line of a step that takes less is not judged: starting Python varies as much.
LEAST_S = 5.0


@dataclass(frozen=True)
class Row:
    """One number of one run; `step` is a script, "dry run" or "whole run"."""

    commit: str
    campaign: str
    runs: int
    step: str
    quantity: str
    value: float


def levels(runs: int) -> dict[str, list[float]]:
    """A matrix of about as many conditions, none of them twice."""
    side = round(runs ** (1 / 3))
    last = round(runs / side**2)
    return {
        "max_hertz_pressure_gpa": np.linspace(1.0, 1.5, side).round(4).tolist(),
        "entrainment_speed_m_s": np.linspace(25, 40, side).round(3).tolist(),
        "inlet_temperature_c": np.linspace(25, 100, last).round(3).tolist(),
    }


def write_logs(project: Path, runs: int, oils: Iterable[str], logs: dict[str, int]) -> int:
    """A project with the campaign `scale`, whose logs are there as if measured; their bytes."""
    lay_out(project)
    campaign = simulated_campaign()
    oils = list(oils)
    campaign |= {"oils": oils, "matrix": levels(runs // len(oils)), "figures": FIGURES}
    del campaign["torque"]
    campaign["twin"] |= {"defects": [], **logs}
    write_campaign(project, "scale", campaign)
    raw, size = project / "data/raw/scale", 0
    raw.mkdir(parents=True)
    simulated = simulate_campaign(resolve(project / "config", {"campaign": "scale"}), printed())
    for run, content, _ in simulated:
        (raw / run.name).write_bytes(content)
        size += len(content)
    del campaign["twin"], campaign["matrix"]
    campaign |= {"simulated_by": "rig twin of oilfilm", "repeated_conditions": "accept"}
    write_campaign(project, "scale", campaign)
    return size


def snakemake(project: Path, *arguments: str) -> list[dict[str, Any]]:
    """Run Snakemake on the campaign; what each process has used."""
    notes = project / "usage.jsonl"
    notes.unlink(missing_ok=True)
    path = os.pathsep.join([str(project / "workflow"), str(ROOT / "benchmarks/usage")])
    environment = {**os.environ, "PYTHONPATH": path, "OILFILM_USAGE": str(notes)}
    command = [sys.executable, "-m", "snakemake", "--cores", str(CORES), *arguments]
    done = subprocess.run(
        [*command, "--config", "campaign=scale"],
        cwd=project,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    return [json.loads(line) for line in notes.read_text(encoding="utf-8").splitlines()]


Usage = dict[str, list[dict[str, Any]]]


def run_anew(project: Path, *targets: str) -> Usage:
    """A run from the logs on: what each process has used, by step."""
    shutil.rmtree(project / "results", ignore_errors=True)
    of_step: Usage = defaultdict(list)
    for used in snakemake(project, *targets):
        of_step[NAMES.get(used["step"], used["step"].removesuffix(".py"))].append(used)
    return dict(of_step)


def cpu_s(jobs: list[dict[str, Any]]) -> float:
    """CPU time of all processes of one step."""
    return float(sum(job["cpu_s"] for job in jobs))


def bytes_below(folder: Path) -> int:
    """Bytes of all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def rows_of_campaign(
    name: str, runs: int, oils: Iterable[str], logs: dict[str, int], rounds: int
) -> Iterator[Row]:
    """One campaign through a dry run and some runs: the least CPU time and the most memory."""
    targets = ["results/scale/tables/points.parquet"] if logs == LONG else []
    with tempfile.TemporaryDirectory(prefix="oilfilm-scale-") as folder:
        project = Path(folder, "project")
        size = write_logs(project, runs, oils, logs)
        runs = len(list((project / "data/raw/scale").iterdir()))

        def row(step: str, quantity: str, value: float) -> Row:
            return Row(COMMIT, name, runs, step, quantity, round(value, 3))

        yield row("logs", "bytes", size)
        snakemake(project, "--dry-run", *targets)
        processes = snakemake(project, "--dry-run", *targets)
        dry = max(processes, key=lambda used: used["cpu_s"])
        yield row("dry run", "cpu_s", dry["cpu_s"])
        yield row("dry run", "mib", dry["mib"])
        usage = [run_anew(project, *targets) for _ in range(rounds)]
        least = {step: min(cpu_s(used[step]) for used in usage) for step in sorted(usage[0])}
        for step, value in least.items():
            yield row(step, "cpu_s", value)
            yield row(step, "mib", max(job["mib"] for used in usage for job in used[step]))
            yield row(step, "jobs", len(usage[0][step]))
        yield row("whole run", "cpu_s", sum(least.values()))
        totals = [sum(map(cpu_s, used.values())) for used in usage]
        yield row("whole run", "spread", max(totals) / min(totals) - 1)
        yield row("tables", "bytes", bytes_below(project / "results/scale/tables"))
        yield row("samples", "bytes", bytes_below(project / "results/scale/tables/samples"))
        yield row("results", "bytes", bytes_below(project / "results/scale"))


def main(most: int) -> list[Row]:
    """Measure every size up to `most` runs."""
    sizes = [runs for runs in (100, 1000, 3000, 10000) if runs <= most]
    rounds = {runs: ROUNDS if runs < LARGEST else ROUNDS_OF_LARGEST for runs in sizes}
    plan = [("oils", runs, OILS, SHORT, rounds[runs]) for runs in sizes]
    plan += [("one oil", runs, OILS[:1], SHORT, 1) for runs in (300, 3000) if runs <= most]
    plan += [("long logs", 1000, OILS, LONG, 1)] if most >= 1000 else []
    rows = []
    for campaign in plan:
        print(*campaign[:2], "runs", flush=True)
        rows += rows_of_campaign(*campaign)
    return rows


def series(rows: list[Row], campaign: str, step: str, quantity: str) -> dict[int, float]:
    """One quantity by the number of runs."""
    key = (campaign, step, quantity)
    return {row.runs: row.value for row in rows if (row.campaign, row.step, row.quantity) == key}


def value_on_line(values: dict[int, float], runs: float) -> float:
    """The value at a number of runs, on the straight line through the two largest sizes."""
    (size, value), (larger_size, larger_value) = sorted(values.items())[-2:]
    return value + (larger_value - value) * (runs - size) / (larger_size - size)


def extrapolated(values: dict[int, float]) -> float:
    """The value at a million runs, on the line through the largest two sizes unless it falls."""
    return max(value_on_line(values, EXTRAPOLATED_RUNS), values[max(values)])


def steps_of(rows: list[Row], campaign: str = "oils") -> list[str]:
    """Steps with a CPU time, the most expensive one of the largest campaign first."""
    largest = max((row.runs for row in rows if row.campaign == campaign), default=0)
    times = {
        row.step: row.value
        for row in rows
        if (row.campaign, row.runs, row.quantity) == (campaign, largest, "cpu_s")
    }
    return sorted(times, key=lambda step: -times[step])


def report(rows: list[Row]) -> Iterator[str]:
    """Time, memory and bytes by step, the check of the model and its extrapolation, as Markdown."""
    for quantity, title in (("cpu_s", "CPU time (s)"), ("mib", "Memory of one process (MiB)")):
        sizes = sorted(series(rows, "oils", "dry run", quantity))
        names = [
            title,
            *(f"{size:,} runs" for size in sizes),
            "off the line",
            f"{EXTRAPOLATED_RUNS:,} runs",
        ]
        yield from ("", f"| {' | '.join(names)} |", "| --- |" + " --- |" * (len(names) - 1))
        for step in steps_of(rows):
            values = series(rows, "oils", step, quantity)
            if not values:
                continue
            cells = [f"{values[size]:.3g}" if size in values else "" for size in sizes]
            grows = len(values) > 2 and (
                quantity != "cpu_s" or values[sorted(values)[-2]] >= LEAST_S
            )
            cells.append(f"{error_of_line(values):+.0%}" if grows else "")
            cells.append(f"{extrapolated(values):,.2g}" if len(values) > 1 else "")
            yield f"| `{step}` | {' | '.join(cells)} |"
    yield ""
    yield f"- Commit {' and '.join(sorted({row.commit for row in rows}))}, {CORES} cores."
    whole = series(rows, "oils", "whole run", "cpu_s")
    if len(whole) > 2:
        *_, one, other, largest = sorted(whole)
        errors = errors_of_fit(whole)
        of_sizes = ", ".join(f"{errors[size]:+.1%} at {size:,} runs" for size in sorted(whole))
        yield f"- Whole run, off the line that fits all sizes: {of_sizes}; allowed {LINEAR:.0%}."
        yield (
            f"- Whole run: {largest:,} runs are {error_of_line(whole):+.1%} off the line through "
            f"{one:,} and {other:,} runs; allowed {LINEAR:+.0%}."
        )
    if len(whole) > 3:
        small, next_one, *_ = sorted(whole)
        error = error_of_line(with_smallest(whole))
        yield (
            f"- They are {error:+.1%} off the line through {small:,} and {next_one:,} runs; "
            f"allowed {LINEAR:+.0%}."
        )
    if spread := series(rows, "oils", "whole run", "spread"):
        yield (
            f"- The time of a step in the table is the least of {ROUNDS} runs, or of "
            f"{ROUNDS_OF_LARGEST} with {LARGEST:,} runs or more. The whole run is the sum of its "
            f"steps. Whole runs of one size differ by up to {max(spread.values()):.0%}."
        )
    one_oil = series(rows, "one oil", "whole run", "cpu_s")
    if len(one_oil) == 2:
        (few, low), (many, high) = sorted(one_oil.items())
        ratio = growth(one_oil)
        yield (
            f"- One oil: {many:,} runs take {high:.0f} s of CPU, {few} take {low:.0f} s: "
            f"{ratio:.2f} times linear growth; allowed {1 + ONE_OIL}."
        )
    for campaign in ("oils", "long logs"):
        dry = series(rows, campaign, "dry run", "cpu_s")
        for runs in sorted(dry):
            sizes = [
                f"{what} {series(rows, campaign, what, 'bytes')[runs] / runs / 1000:.1f}"
                for what in ("logs", "samples", "results")
            ]
            yield (
                f"- {runs:,} {campaign.replace('oils', 'short logs')}: dry run {dry[runs]:.1f} s "
                f"of CPU; kB per run: {', '.join(sizes)}."
            )
    steps = [step for step in steps_of(rows, "long logs") if step.startswith("points")]
    if steps:
        largest = [max(series(rows, "long logs", step, "mib").values()) for step in steps]
        memory = ", ".join(
            f"`{step}` {mib:.0f} MiB" for step, mib in zip(steps, largest, strict=True)
        )
        yield f"- Long logs: {memory}."


def error_of_line(values: dict[int, float]) -> float:
    """By how much the largest size differs from the line through the two below it, relative."""
    *fitted, (largest, value) = sorted(values.items())
    return value / value_on_line(dict(fitted), largest) - 1


def with_smallest(values: dict[int, float]) -> dict[int, float]:
    """The two smallest sizes and the largest one."""
    return {size: values[size] for size in (*sorted(values)[:2], max(values))}


def errors_of_fit(values: dict[int, float]) -> dict[int, float]:
    """By how much each size differs from the line of least squares, relative to the value."""
    sizes, found = (np.array(list(each), dtype=float) for each in (values.keys(), values.values()))
    rows = np.column_stack([1 / found, sizes / found])
    fitted = rows @ np.linalg.lstsq(rows, np.ones(len(found)))[0]
    return dict(zip(values, 1 - fitted, strict=True))


def growth(values: dict[int, float]) -> float:
    """Growth from the smallest to the largest size, over that of the number of runs."""
    (few, low), *_, (many, high) = sorted(values.items())
    return high / low / (many / few)


def complaints(rows: list[Row]) -> list[str]:
    """What grows by more than is allowed."""
    found = []
    whole = series(rows, "oils", "whole run", "cpu_s")
    if len(whole) > 2 and max(map(abs, errors_of_fit(whole).values())) > LINEAR:
        found.append(f"Whole run: more than {LINEAR:.0%} off a straight line.")
    if len(whole) > 2 and max(map(error_of_line, (whole, with_smallest(whole)))) > LINEAR:
        found.append(f"Whole run: more than {LINEAR:.0%} above the line of smaller sizes.")
    one_oil = series(rows, "one oil", "whole run", "cpu_s")
    if len(one_oil) == 2 and growth(one_oil) > 1 + ONE_OIL:
        found.append(f"One oil: more than {1 + ONE_OIL} times linear growth.")
    return found


if __name__ == "__main__":
    results = main(int(sys.argv[1]) if len(sys.argv) > 1 else 10000)
    print("\n".join(report(results)))
    if too_much := complaints(results):
        print("\n".join(too_much), file=sys.stderr)
        raise SystemExit(1)
