"""Memory and time of each job after curation, on points that are made directly.

A few logs go through the workflow up to `points`. Their tables of points, runs and quarantine are
then replaced by those of many runs: the plateaus of the same logs, with other set points, the mu
of the paper's law there, an error that a run shares and the noise of each plateau. No condition is
there twice. The workflow goes on from there. CPU time is user and system of one process; memory is
its largest resident size.

    python benchmarks/jobs.py RUNS [--quick] [TARGET ...]

Targets are rules or files of the campaign `scale`; all of it if none is given. `--quick` fits two
laws with 20 resampled curves in place of what the workflow has by default.

Takes ten minutes with 3 000 runs and `--quick`.
"""

import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scale import LONG, NAMES, OILS, levels, snakemake, write_logs

from campaigns import QUICK, printed, read_campaign, write_campaign
from oilfilm import tables
from oilfilm.base.digests import file_digest
from oilfilm.logs.raw_files import listing_text, read_listings
from oilfilm.traction.laws.deng2026 import traction_coefficient

# Logs whose plateaus are used again; at least five of each oil, as its shapes are judged.
TEMPLATE_RUNS = 24
# Relative error of mu that the points of a run share.
ERROR_OF_RUN = 0.005
CONDITIONS = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")
MIB = 1 << 20


def main(runs: int, targets: list[str], quick: bool) -> None:
    """Print what each job used."""
    with tempfile.TemporaryDirectory(prefix="oilfilm-jobs-") as folder:
        project = Path(folder, "project")
        write_logs(project, TEMPLATE_RUNS, OILS, LONG)
        campaign = read_campaign(project, "scale")
        campaign["settings"] = {"split": {"runs": 10 * TEMPLATE_RUNS}}
        if quick:
            campaign["settings"] |= QUICK
        write_campaign(project, "scale", campaign)
        share = project / "results/scale/parts/points/0"
        snakemake(project, "--until", "points")
        points = replace_runs(share, runs)
        print(f"{runs} runs, {points} points")
        used = snakemake(project, *targets)
        for line in report(used):
            print(line)
        for path in sorted((project / "results/scale/tables").glob("*.parquet")):
            if path.stat().st_size > MIB:
                print(f"{path.name}: {path.stat().st_size / MIB:.0f} MiB")


def replace_runs(share: Path, runs: int) -> int:
    """Replace the tables of a share by those of so many runs; the number of points."""
    paths = {name: share / f"{name}.parquet" for name in ("points", "runs", "quarantine")}
    provenance = {name: tables.read_footer(path) for name, path in paths.items()}
    old_points, old_runs = (tables.read(name, paths[name]) for name in ("points", "runs"))
    old_runs = old_runs[old_runs["verdict"] == "accepted"]
    count = 0
    made_runs = []
    with tables.writing("points", paths["points"], provenance["points"]) as add:
        for oil, of_oil in old_runs.groupby("oil"):
            template = of_oil.iloc[0]
            plateaus = old_points[old_points["run_id"] == template["run_id"]]
            for of_oil_runs, of_oil_points in runs_and_points(
                str(oil), template, plateaus, runs // len(OILS)
            ):
                add(of_oil_points)
                made_runs.append(of_oil_runs)
                count += len(of_oil_points)
    all_runs = pd.concat(made_runs, ignore_index=True)
    tables.write(all_runs, "runs", paths["runs"], provenance["runs"])
    tables.write(
        tables.empty_table("quarantine"),
        "quarantine",
        paths["quarantine"],
        {**provenance["quarantine"]},
    )
    digests = dict(zip(all_runs["file"], all_runs["sha256"], strict=True))
    (share / "logs.sha256").write_text(
        listing_text({f"data/raw/scale/{f}": d for f, d in digests.items()})
    )
    renew_listing(share)
    return count


def renew_listing(share: Path) -> None:
    """Write the digests of the replaced tables over those that the step has listed."""
    results = share.parents[2]
    listed = results / f"made/points-{share.name}.sha256"
    project = results.parents[1]
    listed.write_text(
        listing_text({path: file_digest(project / path) for path in read_listings(listed)})
    )


def runs_and_points(
    oil: str, run: "pd.Series[Any]", plateaus: pd.DataFrame, count: int
) -> Iterator[tuple[pd.DataFrame, pd.DataFrame]]:
    """Runs of one oil and their points, some hundred runs at a time."""
    random = np.random.default_rng(int(oil))
    grid = np.meshgrid(*levels(count).values(), indexing="ij")
    conditions = np.column_stack([axis.ravel() for axis in grid])
    template_condition = plateaus[list(CONDITIONS)].mean().to_numpy()
    for start in range(0, len(conditions), 1000):
        block = conditions[start : start + 1000]
        names = [f"{oil}_{p:.4f}_{u:.3f}_{t:.3f}.csv" for p, u, t in block]
        digests = [sha256(name.encode()).hexdigest() for name in names]
        of_runs = pd.DataFrame([run] * len(block)).reset_index(drop=True)
        of_runs = of_runs.assign(run_id=names, file=names, sha256=digests, content_sha256=digests)
        of_runs = of_runs.assign(**{f"nominal_{n}": block[:, i] for i, n in enumerate(CONDITIONS)})
        of_runs = of_runs.astype(tables.empty_table("runs").dtypes.to_dict())
        run_of_point = np.repeat(np.arange(len(block)), len(plateaus))
        points = pd.concat([plateaus] * len(block), ignore_index=True)
        measured = points[list(CONDITIONS)].to_numpy() * (block / template_condition)[run_of_point]
        error = ERROR_OF_RUN * random.standard_normal(len(block))[run_of_point]
        mu_se = points["traction_coefficient_se"].to_numpy()
        slip = points["slide_roll_ratio"].to_numpy()
        slip = slip + points["slide_roll_ratio_se"].to_numpy() * random.standard_normal(len(slip))
        mu = np.sign(slip) * traction_coefficient(printed()[oil], *measured.T, np.abs(slip))
        mu = mu * (1 + error) + mu_se * random.standard_normal(len(slip))
        load = points["load_n"].to_numpy() * (measured[:, 0] / points[CONDITIONS[0]]) ** 3
        points = points.assign(**dict(zip(CONDITIONS, measured.T, strict=True)))
        yield (
            of_runs,
            points.assign(
                run_id=np.array(names, dtype=object)[run_of_point],
                slide_roll_ratio=slip,
                traction_coefficient=mu,
                load_n=load,
                traction_force_n=mu * load,
            ).astype({"run_id": "str"}),
        )


def report(used: list[dict[str, Any]]) -> Iterator[str]:
    """CPU time and memory of each step, those with the most memory first."""
    of_step = defaultdict(list)
    for job in used:
        of_step[NAMES.get(job["step"], job["step"].removesuffix(".py"))].append(job)
    yield "| step | jobs | CPU time (s) | memory (MiB) |"
    yield "| --- | --- | --- | --- |"
    memory = {step: max(job["mib"] for job in jobs) for step, jobs in of_step.items()}
    for step in sorted(memory, key=lambda step: -memory[step]):
        seconds = sum(job["cpu_s"] for job in of_step[step])
        yield f"| `{step}` | {len(of_step[step])} | {seconds:.1f} | {memory[step]:.0f} |"


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--quick"]
    main(int(words[0]), words[1:], "--quick" in sys.argv)
