"""What the workflow costs beside its own computing.

A campaign is run once by snakemake, in jobs that start a Python each. Then the scripts of the same
jobs run again in the same order, as forks of one process that has imported everything, on as many
cores. The difference is what the workflow costs: reading rules, starting Python, importing.

Takes a quarter of an hour.
"""

import json
import os
import pickle
import pkgutil
import re
import runpy
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from campaigns import lay_out
from oilfilm import tables
from reproduce import Surroundings, succeed

CORES = 2
_END_OF_PREAMBLE = b"######## snakemake preamble end #########"
_PICKLED = re.compile(rb"pickle\.loads\((b'(?:[^'\\]|\\.)*'|b\"(?:[^\"\\]|\\.)*\")\)")


@dataclass(frozen=True)
class Step:
    """A job of the run: its script, as snakemake wrote it, and the files it reads and writes."""

    rule: str
    script: Path
    inputs: frozenset[str]
    outputs: frozenset[str]
    log: str


def main(campaign: str) -> None:
    """Run a campaign twice; print both times, the overhead and the share of each stage."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-run-") as folder:
        project, warm_project = Path(folder, "snakemake"), Path(folder, "warm")
        lay_out(project)
        begun = time.perf_counter()
        options = ("--skip-script-cleanup", "--config", f"campaign={campaign}")
        succeed(project, *options, around=Surroundings(str(CORES)))
        by_snakemake = time.perf_counter() - begun
        taken = seconds_of_rules(project)
        steps = sorted(steps_of(project), key=lambda step: step.script.stat().st_mtime)
        lay_out(warm_project)
        import_all()
        os.chdir(warm_project)
        begun = time.perf_counter()
        warm = run_warm(steps)
        in_one_process = time.perf_counter() - begun
        os.chdir("/")
        report(taken, warm)
        print(f"\n{len(steps)} jobs by snakemake {by_snakemake:.1f} s, warm {in_one_process:.1f} s")
        print(f"overhead of the workflow: {by_snakemake / in_one_process - 1:.0%}")
        constants = [coefficients(run_folder, campaign) for run_folder in (project, warm_project)]
        print(f"constants of the two: {'equal' if constants[0].equals(constants[1]) else 'DIFFER'}")


def coefficients(project: Path, campaign: str) -> pd.DataFrame:
    """The fitted constants of a run."""
    path = project / "results" / campaign / "tables/coefficients.parquet"
    return tables.read("coefficients", path)


def steps_of(project: Path) -> Iterator[Step]:
    """The jobs whose scripts snakemake has left behind."""
    for script in (project / ".snakemake/scripts").glob("tmp*.py"):
        match = _PICKLED.search(script.read_bytes().partition(_END_OF_PREAMBLE)[0])
        if match is None:
            raise SystemExit(f"{script}: the script has no job of Snakemake; was it upgraded?")
        # what this run's own snakemake wrote a moment ago
        job: Any = pickle.loads(eval(match[1]))
        inputs, outputs = frozenset(map(str, job.input)), frozenset(map(str, job.output))
        yield Step(job.rule, script, inputs, outputs, str(job.log[0]))


def seconds_of_rules(project: Path) -> dict[str, float]:
    """Wall time of the jobs of each rule, as snakemake recorded it beside each output."""
    times: dict[tuple[str, str], list[float]] = defaultdict(list)
    for record in (project / ".snakemake/metadata").iterdir():
        job = json.loads(record.read_text(encoding="utf-8"))
        times[job["rule"], str(job["log"])] += [job["starttime"], job["endtime"]]
    seconds: dict[str, float] = defaultdict(float)
    for (rule, _), moments in times.items():
        seconds[rule] += max(moments) - min(moments)
    return seconds


def import_all() -> None:
    """Import the library and what its functions import when they are called."""
    package = import_module("oilfilm")
    for module in pkgutil.walk_packages(package.__path__, "oilfilm."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    for name in ("matplotlib.pyplot", "scipy.optimize", "scipy.special"):
        import_module(name)


def run_warm(steps: list[Step]) -> dict[str, float]:
    """Run the jobs as forks of this process, each once its input is there; seconds of each rule."""
    waiting = list(steps)
    made: set[str] = set()
    unmade = {file for step in steps for file in step.outputs}
    seconds: dict[str, float] = defaultdict(float)
    active: dict[int, tuple[Step, float]] = {}
    while waiting or active:
        ready = [step for step in waiting if not (step.inputs & unmade) - made]
        for step in ready[: CORES - len(active)]:
            waiting.remove(step)
            active[start(step)] = step, time.perf_counter()
        process, status = os.wait()
        step, begun = active.pop(process)
        if status:
            raise SystemExit(f"{step.rule} failed when it ran in a warm process")
        seconds[step.rule] += time.perf_counter() - begun
        made |= step.outputs
    return seconds


def start(step: Step) -> int:
    """A fork that runs a job."""
    for file in (*step.outputs, step.log):
        Path(file).parent.mkdir(parents=True, exist_ok=True)
    process = os.fork()
    if process:
        return process
    code = 1
    try:
        with Path(step.log).open("w", encoding="utf-8") as log, redirect_stdout(log):
            runpy.run_path(str(step.script), run_name="__main__")
        code = 0
    finally:
        os._exit(code)


def report(taken: dict[str, float], warm: dict[str, float]) -> None:
    """Print the seconds of each stage in both runs."""
    print(f"{'stage':<20} {'snakemake':>10} {'warm':>8}   ratio")
    for rule in sorted(warm, key=lambda rule: -warm[rule]):
        print(
            f"{rule:<20} {taken[rule]:8.1f} s {warm[rule]:6.1f} s   {taken[rule] / warm[rule]:.2f}"
        )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "demo")
