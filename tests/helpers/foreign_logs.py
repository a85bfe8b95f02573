"""Logs of the blind laboratory in one plain dialect, for tests of what is made of unknown logs."""

from functools import cache
from pathlib import Path

import numpy as np

from blind_lab.bench import Bench, Condition, Recording, draw_bench
from blind_lab.dialects import HEADER, Dialect, columns_of, log_bytes
from blind_lab.truth import draw_machine, draw_oil

GERMAN = Dialect(
    language="german",
    units={"time": "s", "load": "N", "force": "N", "ball": "rpm", "disc": "rpm", "celsius": "°C"},
    encoding="cp1252",
    delimiter=";",
    decimal=",",
    line_end="\r\n",
    mark="",
    separator=": ",
    units_in_row=False,
    packed=False,
)
CONDITIONS = (Condition(1.0, 16.0, 40.0), Condition(1.2, 16.0, 70.0), Condition(1.2, 24.0, 70.0))


@cache
def bench_and_runs(oil: str = "Öl B-12") -> tuple[Bench, list[Recording]]:
    """A bench, and one run of an oil at each condition."""
    random = np.random.default_rng(5)
    bench = draw_bench(random, draw_machine(random))
    drawn = draw_oil(random, (oil,))
    return bench, [bench.run(drawn, condition, random) for condition in CONDITIONS]


def header(run: Recording, dialect: Dialect = GERMAN) -> dict[str, str]:
    """The header lines of a run, numbers with the dialect's decimal mark."""
    levels = vars(run.condition).values()
    numbers = [str(level).replace(".", dialect.decimal) for level in levels]
    return dict(zip(HEADER[dialect.language], (run.oil[0], *numbers), strict=True))


def write_logs(
    folder: Path,
    bench: Bench,
    runs: list[Recording],
    dialect: Dialect = GERMAN,
    lines: slice = slice(None),
) -> list[Path]:
    """The runs as `Messung_<number>.csv`, with some of their header lines."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, run in enumerate(runs):
        kept = dict([*header(run, dialect).items()][lines])
        path = folder / f"Messung_{number}.csv"
        path.write_bytes(log_bytes(kept, columns_of(run, dialect, bench.machine), dialect))
        paths.append(path)
    return paths
