"""Ingest and curation of 10 million rows in 2 000 csv runs, against what others take for reading.

Run by `make bench NAME=ingest`; prints rows a second, ratios of CPU time and of wall time, and peak
memory. CPU time is that of all processes and their threads. The logs are 20 simulated runs of 5 000
rows, each written under 100 names. Three baselines read the same files in the same run, each in one
process and spread over as many as ours:

- bare pyarrow.csv: `pyarrow.csv.read_csv` of every file, one after the other, at its defaults
  (threads on all cores, types inferred) but for the header that is skipped: all columns as Arrow
  tables, and nothing else. Nothing is hashed, checked, kept or written.
- pyarrow that keeps what it reads: the same, with the columns written as Parquet in the way of our
  samples, and that file read again. Nothing is hashed, checked or judged.
- naive pandas: the straightforward version, which reads a file at a time with `read_csv`, groups
  its rows by slip, averages, and writes both tables, judging nothing.

Times are the best of three rounds, in which ours and pyarrow's take turns; naive pandas, at a
minute a round, has one.

Takes minutes.
"""

import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

from campaigns import printed  # noqa: E402  (the tests' own helper)
from oilfilm import tables  # noqa: E402
from oilfilm.curation.curate import CuratedTables, collect, curate_parts  # noqa: E402
from oilfilm.curation.traction_rig import TractionRig  # noqa: E402
from oilfilm.logs.ingest import ingest_logs, open_sample_files, read_bytes  # noqa: E402
from oilfilm.logs.raw_files import logs_by_share  # noqa: E402
from oilfilm.settings.config import SplitSettings  # noqa: E402
from oilfilm.settings.resolve import resolve  # noqa: E402
from oilfilm.settings.resolved import Settings  # noqa: E402
from simulated_lab.simulate import simulate_campaign  # noqa: E402

CORES = 2
HEADER_LINES = 5
PROVENANCE = {"campaign": "bench", "data": "simulated"}


def configuration() -> Settings:
    """The demonstration campaign, stretched to 5 000 rows a run, repeats allowed."""
    config = resolve(ROOT / "config", {"campaign": "demo"})
    twin = {"step_s": 3.02, "baseline_s": 3.2, "defects": []}
    campaign = {"twin": twin, "repeated_conditions": "accept"}
    return config.with_changes({"campaign": campaign})


def write_logs(folder: Path, runs: int, config: Settings) -> int:
    """Write the logs; returns how many rows they hold."""
    rows = 0
    different = min(20, runs)
    for number, (_, content, _) in zip(
        range(different), simulate_campaign(config, printed()), strict=False
    ):
        for copy in range(runs // different):
            text = b"# run: %d-%d\n" % (number, copy) + content
            (folder / f"run{number:02d}_{copy:03d}.csv").write_bytes(text)
            rows += content.count(b"\n") - HEADER_LINES - 1
    return rows


def read_bare(path: Path) -> int:
    """The columns of a log, by pyarrow alone."""
    skipped = HEADER_LINES + 1
    return arrow_csv.read_csv(path, read_options=arrow_csv.ReadOptions(skip_rows=skipped)).num_rows


def write_and_read_parquet(path: Path, out: Path) -> None:
    """The columns of a log as a Parquet file, written and read again by pyarrow alone."""
    skipped = HEADER_LINES + 1
    read = arrow_csv.read_csv(path, read_options=arrow_csv.ReadOptions(skip_rows=skipped))
    file = out / f"{path.stem}.parquet"
    out.mkdir(parents=True, exist_ok=True)
    parquet.write_table(
        read.cast(arrow.schema([(name, arrow.float64()) for name in read.column_names])),
        file,
        compression="zstd",
        use_dictionary=False,
        column_encoding=dict.fromkeys(read.column_names, "BYTE_STREAM_SPLIT"),
        write_page_checksum=True,
    )
    parquet.read_table(file, page_checksum_verification=True, use_threads=False)


def average_with_pandas(path: Path, out: Path) -> None:
    """What one writes first: read a log, group its rows by slip, average each group, keep both.

    The standard errors know of autocorrelation, as ours do; nothing else is judged.
    """
    frame = pd.read_csv(path, comment="#")
    ball = frame["ball_speed_rpm"] * (2 * np.pi / 60) * 0.010
    disc = frame["disc_speed_rpm"] * (2 * np.pi / 60) * 0.040
    frame["slip"] = (disc - ball) / ((disc + ball) / 2)
    frame["mu"] = frame["traction_force_n"] / frame["load_n"]
    steps = frame.groupby(frame["slip"].round(2))
    points = steps.agg(["mean", "std", "count"])
    points.columns = ["_".join(name) for name in points.columns]
    points["inflation"] = steps["mu"].apply(
        lambda mu: 1 + 2 * sum(mu.autocorr(lag) for lag in range(1, 6)) if len(mu) > 10 else 1.0
    )
    out.mkdir(parents=True, exist_ok=True)
    frame.to_parquet(out / f"{path.stem}-samples.parquet", compression="zstd")
    points.to_parquet(out / f"{path.stem}-points.parquet", compression="zstd")


def shares_in(folder: Path) -> dict[int, list[str]]:
    """The logs of each share: of the default size, or smaller, so that each process has one."""
    names = [path.name for path in sorted(folder.iterdir())]
    return logs_by_share(names, min(SplitSettings().runs, -(-len(names) // CORES)))


def process_share(share: int, folder: Path, out: Path, config: Settings) -> CuratedTables:
    """One share of the logs through ingest and curation, every table written and read back."""
    paths = {oil: out / f"samples/oil={oil}/part-{share}.parquet" for oil in config.oils}
    logs = ((file, read_bytes(folder / file)) for file in shares_in(folder)[share])
    with open_sample_files(paths, PROVENANCE) as keep:
        found = ingest_logs(logs, config, keep_run=keep)
    samples = tables.read_blocks("samples", *paths.values())
    curated = curate_parts(samples, found, TractionRig(config))
    for name, frame in vars(curated).items():
        tables.write(frame, name, out / f"parts/{share}/{name}.parquet", PROVENANCE)
    return curated


def process_all(pool: ProcessPoolExecutor, folder: Path, out: Path, config: Settings) -> float:
    """All shares on all cores, then collected and written; CPU time of the pool."""
    process = partial(process_share, folder=folder, out=out, config=config)
    shares, seconds = spread(pool, process, shares_in(folder))
    names = ("points", "runs", "quarantine")
    joined_tables = (pd.concat([getattr(share, name) for share in shares]) for name in names)
    collected = collect(CuratedTables(*joined_tables), config)
    tables.write(collected.points, "points", out / "points.parquet", PROVENANCE)
    tables.write(collected.runs, "runs", out / "runs.parquet", PROVENANCE)
    tables.write(collected.quarantine, "quarantine", out / "quarantine.parquet", PROVENANCE)
    accepted = (collected.runs["verdict"] == "accepted").sum()
    print(f"  {accepted} of {len(collected.runs)} runs accepted, {len(collected.points)} points")
    return seconds


def one_after_the_other(work: Callable[[Path], object], paths: list[Path]) -> float:
    """All logs in this process; no CPU time of others."""
    for path in paths:
        work(path)
    return 0.0


def with_cpu_time(work: Callable[[Any], object], argument: Any) -> tuple[object, float]:
    """What a piece of work returns, and the CPU time of the process and its threads meanwhile."""
    start = time.process_time()
    returned = work(argument)
    return returned, time.process_time() - start


def spread(
    pool: ProcessPoolExecutor, work: Callable[[Any], Any], pieces: Iterable[Any], chunk: int = 1
) -> tuple[list[Any], float]:
    """What each piece of work returns, done by the processes of a pool, and their CPU time."""
    done = list(pool.map(partial(with_cpu_time, work), pieces, chunksize=chunk))
    return [returned for returned, _ in done], sum(seconds for _, seconds in done)


def times(work: Callable[[], float]) -> tuple[float, float]:
    """CPU and wall time of some work, in s; it returns the CPU time of other processes."""
    start, cpu = time.perf_counter(), time.process_time()
    of_others = work()
    return time.process_time() - cpu + of_others, time.perf_counter() - start


def peak_mib() -> float:
    """Largest memory of any process so far, in MiB."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return max(usage, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1024


def main(runs: int) -> None:
    """Write the logs, carry them through and print how that compares."""
    config = configuration()
    with tempfile.TemporaryDirectory() as name:
        folder, out = Path(name, "raw"), Path(name, "out")
        folder.mkdir()
        rows = write_logs(folder, runs, config)
        paths = sorted(folder.iterdir())
        size = sum(path.stat().st_size for path in paths)
        print(f"{rows} rows in {len(paths)} logs, {size / 2**20:.0f} MiB, {CORES} processes")
        # fresh processes: those of a fork would share and so hide memory
        with ProcessPoolExecutor(CORES, get_context("spawn")) as pool:
            keep = partial(write_and_read_parquet, out=Path(name, "kept"))
            works: dict[str, Callable[[], float]] = {
                "ingest and curation": lambda: process_all(pool, folder, out, config),
                "bare pyarrow.csv, one process": lambda: one_after_the_other(read_bare, paths),
                f"bare pyarrow.csv, {CORES} processes": lambda: spread(pool, read_bare, paths, 50)[
                    1
                ],
                "pyarrow that keeps, one process": lambda: one_after_the_other(keep, paths),
                f"pyarrow that keeps, {CORES} processes": lambda: spread(pool, keep, paths, 50)[1],
            }
            rounds = [{name: times(work) for name, work in works.items()} for _ in range(3)]
        # the least CPU time and the least wall time, each by itself
        best = {name: np.min([taken[name] for taken in rounds], axis=0) for name in works}
        naive = partial(average_with_pandas, out=Path(name, "naive"))
        best["naive pandas, one process"] = np.array(
            times(lambda: one_after_the_other(naive, paths))
        )
        with ProcessPoolExecutor(CORES, get_context("spawn")) as pool:
            best[f"naive pandas, {CORES} processes"] = np.array(
                times(lambda: spread(pool, naive, paths, 50)[1])
            )
        ours = best.pop("ingest and curation")
        cpu, wall = ours
        print(
            f"ingest and curation: {cpu:.2f} s CPU, {wall:.2f} s; {rows / wall:,.0f} rows a second"
        )
        for baseline, seconds in best.items():
            print(
                f"{baseline}: {seconds[0]:.2f} s CPU, {seconds[1]:.2f} s; "
                f"ours takes {cpu / seconds[0]:.2f} times the CPU time, "
                f"{wall / seconds[1]:.2f} times as long"
            )
        print(f"peak memory of a process: {peak_mib():.0f} MiB")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
