"""A genetic algorithm as the paper used one, alone and polished, beside our fit of the same points.

The paper does not say which algorithm it used, nor its settings or bounds. This one is pymoo's with
its defaults (`genetic` of fit.py), once on the raw constants within generous bounds and once on the
logarithms and bounds that our search has. Programs with a genetic algorithm often offer a local
search from its best candidate. Here it is SciPy's least squares within the same bounds. It also
runs from random candidates within the bounds of our search.

The points are the demonstration's matrix, simulated with a fixed seed (`task` of fit.py). `make
bench NAME=genetic` writes the table of the ends and prints those of
docs/study/genetic-algorithm.md.

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
from scipy.optimize import least_squares

from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.fits.global_search import search
from oilfilm.fits.problem import CurveData, Problem
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import to_internal
from oilfilm.traction.laws.deng2026 import traction_coefficient

TABLE = ROOT / "workflow/deng2026_study/reference/genetic_algorithm.csv"
NAMES = [constant.name for constant in PAPER_LAW.constants]
OURS, RAW, LOGS = "differential evolution", "genetic, raw constants", "genetic, logarithms"
RAW_POLISHED, LOGS_POLISHED = f"{RAW}, polished", f"{LOGS}, polished"
RANDOM_POLISHED = "random candidate, polished"
RANDOM_STARTS = 40
# How the local search ends.
POLISH: dict[str, Any] = {"x_scale": "jac", "xtol": 1e-12, "ftol": 1e-13, "max_nfev": 3000}
# An SSE this near ours, relative, is that of our optimum.
SAME_OPTIMUM = 1e-6
HEADINGS = ("oil", "search", "seed", "sse", "largest_difference_of_mu", *NAMES)
Row = dict[str, Any]


def mu_of(constants: FloatArray, data: CurveData) -> FloatArray:
    """mu of the paper's law at every point."""
    return traction_coefficient(constants, *data.conditions[data.curve_of_point].T, data.slip)


def ends(oil: str, seeds: int) -> Iterator[tuple[str, int, FloatArray]]:
    """Search, seed and constants of every end."""
    problem, data = task(oil)
    (best,) = search(problem, CONFIG.fit, [generator(0, "bench-ga")])
    yield OURS, 0, problem.in_equation_form(best.constants)
    for seed in range(seeds):
        yield RAW, seed, genetic(raw_sse(data), RAW_BOX, seed)
        yield LOGS, seed, problem.in_equation_form(genetic(log_sse(problem), LOG_BOX, seed))


def polished_raw(constants: FloatArray, data: CurveData) -> FloatArray:
    """The end of a local search on the raw constants, within their bounds."""
    low, high = RAW_BOX.T

    def residual(values: FloatArray) -> FloatArray:
        return np.asarray(np.nan_to_num(mu_of(values, data) - data.mu, nan=1e3))

    inside = np.clip(constants, low + 1e-9, high - 1e-9)
    return np.asarray(least_squares(residual, inside, bounds=(low, high), **POLISH).x)


def polished_logs(values: FloatArray, problem: Problem) -> FloatArray:
    """The end of a local search on the internal constants, within the bounds of our search."""
    low, high = LOG_BOX.T
    inside = np.clip(values, low + 1e-9, high - 1e-9)
    end = least_squares(problem.residual, inside, problem.jacobian, bounds=(low, high), **POLISH)
    return problem.in_equation_form(end.x)


def polished_ends(oil: str, rows: Sequence[Row]) -> Iterator[tuple[str, int, FloatArray]]:
    """Search, seed and constants of every polished end, from the genetic ends and from random."""
    problem, data = task(oil)
    for row in rows_of_search(rows, oil, RAW):
        yield RAW_POLISHED, int(row["seed"]), polished_raw(_constants_of(row), data)
    for row in rows_of_search(rows, oil, LOGS):
        values = to_internal(PAPER_LAW, _constants_of(row))
        yield LOGS_POLISHED, int(row["seed"]), polished_logs(values, problem)
    starts = np.random.default_rng(0).uniform(*LOG_BOX.T, size=(RANDOM_STARTS, len(NAMES)))
    for seed, start in enumerate(starts):
        yield RANDOM_POLISHED, seed, polished_logs(start, problem)


def row_of(oil: str, name: str, seed: int, constants: FloatArray, ours: FloatArray) -> Row:
    """A row of the table.

    Args:
        oil: The oil.
        name: The search.
        seed: Its seed.
        constants: Those it ended with.
        ours: mu of our fit at every point.
    """
    _, data = task(oil)
    mu = mu_of(constants, data)
    about = {"oil": oil, "search": name, "seed": seed}
    about["sse"] = float(np.sum((mu - data.mu) ** 2))
    about["largest_difference_of_mu"] = float(np.abs(mu - ours).max())
    return {**about, **dict(zip(NAMES, constants.tolist(), strict=True))}


def rows_of(oil: str, found: Sequence[tuple[str, int, FloatArray]], ours: FloatArray) -> list[Row]:
    """Rows of the table, of ends with search, seed and constants."""
    return [row_of(oil, name, seed, constants, ours) for name, seed, constants in found]


def with_polished(rows: Sequence[Row]) -> list[Row]:
    """The rows of our search and of genetic ends, and behind those of an oil its polished ends."""
    both: list[Row] = []
    for oil in OILS:
        of_oil = [row for row in rows if row["oil"] == oil]
        _, data = task(oil)
        ours = mu_of(_constants_of(rows_of_search(rows, oil, OURS)[0]), data)
        both += [*of_oil, *rows_of(oil, list(polished_ends(oil, rows)), ours)]
    return both


def _constants_of(row: Row) -> FloatArray:
    return np.array([row[name] for name in NAMES], dtype=float)


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
        "ends at our optimum",
    )
    yield f"| {' | '.join(columns)} |"
    yield "| --- | --- | --- | --- | --- |"
    for oil in OILS:
        ours = rows_of_search(rows, oil, OURS)[0]["sse"]
        for search_name in (RAW, LOGS, RAW_POLISHED, LOGS_POLISHED, RANDOM_POLISHED):
            of_search = rows_of_search(rows, oil, search_name)
            ratio = np.array([row["sse"] for row in of_search]) / ours
            off = np.array([row["largest_difference_of_mu"] for row in of_search])
            yield (
                f"| {oil} | {search_name} | {ratio.min():.4g}, {np.median(ratio):.4g}, "
                f"{ratio.max():.4g} | {off[ratio.argmin()]:.1g}, {off[ratio.argmax()]:.1g} | "
                f"{(ratio < 1 + SAME_OPTIMUM).sum()} of {len(ratio)} |"
            )


def constant_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Constants of our fit, and of the best and the worst end on the raw constants."""
    yield "| constant | " + " | ".join(f"{oil}: ours; best; worst" for oil in OILS) + " |"
    yield "| --- |" + " --- |" * len(OILS)
    for name in NAMES:
        cells = []
        for oil in OILS:
            genetic_ends = sorted(rows_of_search(rows, oil, RAW), key=lambda row: row["sse"])
            shown = (rows_of_search(rows, oil, OURS)[0], genetic_ends[0], genetic_ends[-1])
            cells.append("; ".join(f"{row[name]:.3g}" for row in shown))
        yield f"| {name} | " + " | ".join(cells) + " |"


def rows_of_search(rows: Sequence[Row], oil: str, search_name: str) -> list[Row]:
    """The rows of one search of an oil."""
    return [row for row in rows if row["oil"] == oil and row["search"] == search_name]


def main(seeds: int = 5) -> None:
    """Search, polish, write the table and print its summary."""
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    rows: list[Row] = []
    for oil in OILS:
        found = list(ends(oil, seeds))
        _, data = task(oil)
        rows += rows_of(oil, found, mu_of(found[0][2], data))
    write(with_polished(rows))


def write(rows: Sequence[Row]) -> None:
    """Write the table and print its summary."""
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
