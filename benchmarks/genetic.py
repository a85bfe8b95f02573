"""A plain genetic algorithm, as the paper used one, beside our fit of the same points.

The paper does not say which algorithm it used, nor its settings or bounds. This one is pymoo's with
its defaults (`genetic` of fit.py), once on the raw constants within generous bounds and once on the
logarithms and bounds that our search has. The points are the demonstration's matrix, simulated with
a fixed seed (`task` of fit.py). `make bench NAME=genetic` writes
its table of the ends and prints the tables of docs/study/genetic-algorithm.md.

    python benchmarks/genetic.py [seeds]

Takes 10 minutes.
"""

import csv
import logging
import sys
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fit import CONFIG, LOG_BOX, OILS, RAW_BOX, ROOT, genetic, log_sse, raw_sse, task

from oilfilm.base.randomness import generator
from oilfilm.fits.engine import search
from oilfilm.fits.problem import CurveData
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import FloatArray
from oilfilm.traction.laws.deng2026 import traction_coefficient

TABLE = ROOT / "workflow/deng2026_study/reference/genetic_algorithm.csv"
NAMES = [constant.name for constant in PAPER_LAW.constants]
OURS, RAW, LOGS = "differential evolution", "genetic, raw constants", "genetic, logarithms"
HEADINGS = ("oil", "search", "seed", "sse", "largest_difference_of_mu", *NAMES)
Row = dict[str, Any]


def mu_of(constants: FloatArray, data: CurveData) -> FloatArray:
    """mu of the paper's law at every point."""
    return traction_coefficient(constants, *data.conditions[data.curve].T, data.slip)


def ends(oil: str, seeds: int) -> Iterator[tuple[str, int, FloatArray]]:
    """Search, seed and constants of every end."""
    problem, data = task(oil)
    (best,) = search(problem, CONFIG.fit, [generator(0, "bench-ga")])
    yield OURS, 0, problem.reported(best.values)
    for seed in range(seeds):
        yield RAW, seed, genetic(raw_sse(data), RAW_BOX, seed)
        yield LOGS, seed, problem.reported(genetic(log_sse(problem), LOG_BOX, seed))


def rows_of(oil: str, seeds: int) -> Iterator[Row]:
    """Rows of the table; the first is that of our search."""
    _, data = task(oil)
    ours: FloatArray | None = None
    for name, seed, constants in ends(oil, seeds):
        mu = mu_of(constants, data)
        ours = mu if ours is None else ours
        sse, off = float(np.sum((mu - data.mu) ** 2)), float(np.abs(mu - ours).max())
        values = dict(zip(NAMES, constants.tolist(), strict=True))
        about = {"oil": oil, "search": name, "seed": seed}
        yield {**about, "sse": sse, "largest_difference_of_mu": off, **values}


def read_table(path: Path = TABLE) -> list[Row]:
    """The rows that were written."""
    with path.open(encoding="utf-8", newline="") as file:
        return [
            {
                name: value if name in ("oil", "search") else float(value)
                for name, value in row.items()
            }
            for row in csv.DictReader(file)
        ]


def quality_lines(rows: Sequence[Row]) -> Iterator[str]:
    """SSE and mu of the ends, as a table in Markdown."""
    columns = (
        "oil",
        "search",
        "SSE / ours: best, median, worst",
        "mu off ours by up to: best, worst",
    )
    yield f"| {' | '.join(columns)} |"
    yield "| --- | --- | --- | --- |"
    for oil in OILS:
        ours = _rows(rows, oil, OURS)[0]["sse"]
        for search_name in (RAW, LOGS):
            of_search = _rows(rows, oil, search_name)
            ratio = np.array([row["sse"] for row in of_search]) / ours
            off = np.array([row["largest_difference_of_mu"] for row in of_search])
            yield (
                f"| {oil} | {search_name} | {ratio.min():.4g}, {np.median(ratio):.4g}, "
                f"{ratio.max():.4g} | {off[ratio.argmin()]:.1g}, {off[ratio.argmax()]:.1g} |"
            )


def constant_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Constants of our fit, and of the best and the worst end on the raw constants."""
    yield "| constant | " + " | ".join(f"{oil}: ours; best; worst" for oil in OILS) + " |"
    yield "| --- |" + " --- |" * len(OILS)
    for name in NAMES:
        cells = []
        for oil in OILS:
            genetic_ends = sorted(_rows(rows, oil, RAW), key=lambda row: row["sse"])
            shown = (_rows(rows, oil, OURS)[0], genetic_ends[0], genetic_ends[-1])
            cells.append("; ".join(f"{row[name]:.3g}" for row in shown))
        yield f"| {name} | " + " | ".join(cells) + " |"


def _rows(rows: Sequence[Row], oil: str, search_name: str) -> list[Row]:
    return [row for row in rows if row["oil"] == oil and row["search"] == search_name]


def main(seeds: int = 5) -> None:
    """Write the table and print its summary."""
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    rows = [row for oil in OILS for row in rows_of(oil, seeds)]
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, HEADINGS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(
            {name: f"{v:.9g}" if isinstance(v, float) else v for name, v in row.items()}
            for row in rows
        )
    print("\n".join([*quality_lines(rows), "", *constant_lines(rows)]))


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
