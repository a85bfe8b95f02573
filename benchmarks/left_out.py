"""What leaving curves out costs as a campaign grows.

Simulates curves of one oil at random conditions of the demonstration's range, and compares all laws
on 300, 1000 and 3000 of them. Printed for each number: CPU time of the whole comparison, that of
leaving curves out of all laws' fits, and the exponents by which both grow from the line above.
Up to 300 curves: how far the rms error at curves left out in groups is at most from that at curves
left out one at a time, over all laws, in relation.

    python benchmarks/left_out.py [curves ...]

Takes 12 minutes.
"""

import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

# As Snakemake does for its jobs.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
from numpy.random import Generator  # noqa: E402

from campaigns import printed  # noqa: E402
from fit_points import accepted_points  # noqa: E402
from law_points import compare_laws  # noqa: E402
from oilfilm.base.randomness import generator  # noqa: E402
from oilfilm.fits import fit  # noqa: E402
from oilfilm.fits.global_search import Optimum  # noqa: E402
from oilfilm.fits.problem import Problem  # noqa: E402
from oilfilm.settings.config import FitSettings  # noqa: E402
from oilfilm.settings.resolve import resolve  # noqa: E402
from oilfilm.traction import LAW_NAMES  # noqa: E402
from oilfilm.traction.law import CONDITIONS, FloatArray  # noqa: E402
from oilfilm.traction.laws.deng2026 import traction_coefficient  # noqa: E402

CONFIG = resolve(ROOT / "config", {"campaign": "demo"})
OIL = "4102"
SLIP = np.linspace(0, 0.3, 20)
# More curves are not left out one at a time.
ALONE = 300


def points(curves: int) -> pd.DataFrame:
    """Points of as many curves: mu of Eqs 7-9, an error of 1 % that a curve shares, and noise."""
    random = generator(1, "left out", str(curves))
    levels = random.uniform([1.0, 25.0, 25.0], [1.5, 40.0, 120.0], (curves, 3))
    contact = CONFIG.common_contact()
    assert contact is not None
    conditions = pd.DataFrame(levels, columns=list(CONDITIONS))
    conditions["load_n"] = contact.load_n(levels[:, 0])
    mu = traction_coefficient(printed()[OIL], *levels.T[:, :, np.newaxis], SLIP)
    mu = mu * (1 + 0.01 * random.standard_normal((curves, 1)))
    return accepted_points(OIL, conditions, SLIP, mu.ravel(), 2e-4, random)


@dataclass(frozen=True)
class Costs:
    """CPU times of comparing all laws and of leaving curves out in it, in s.

    `apart` is the largest relative difference of a law's rms error at curves left out in groups
    from that at curves left out one at a time.
    """

    compare: float
    left_out: float
    apart: float


def compared(of_oil: pd.DataFrame) -> Costs:
    """All laws compared; the curves left out in groups and, not counted, one at a time."""
    in_groups = fit.errors_at_curves_left_out
    groups, alone = [0.0], [0.0]
    apart = [0.0]

    def timed(
        problem: Problem, best: Optimum, settings: FitSettings, random: Generator
    ) -> FloatArray:
        times = [time.process_time()]
        errors = in_groups(problem, best, settings, random)
        times.append(time.process_time())
        if problem.curve_count <= ALONE:
            each = settings.model_copy(update={"left_out_groups": problem.curve_count})
            one_by_one = in_groups(problem, best, each, random)
            apart.append(abs(np.sqrt(np.nanmean(errors**2) / np.nanmean(one_by_one**2)) - 1))
        times.append(time.process_time())
        groups.append(times[1] - times[0])
        alone.append(times[2] - times[1])
        return errors

    fit.errors_at_curves_left_out = timed
    start = time.process_time()
    compare_laws(of_oil, OIL, LAW_NAMES, CONFIG)
    fit.errors_at_curves_left_out = in_groups
    return Costs(time.process_time() - start - sum(alone), sum(groups), max(apart))


def main(*sizes: int) -> None:
    """Print a row per number of curves."""
    print("curves  compare s  exponent  left out s  exponent  apart", flush=True)
    before: tuple[int, Costs] | None = None
    for curves in sizes:
        now = compared(points(curves))
        exponents = ["", ""]
        if before is not None:
            growth = np.log(curves / before[0])
            ratios = now.compare / before[1].compare, now.left_out / before[1].left_out
            exponents = [f"{np.log(ratio) / growth:.2f}" for ratio in ratios]
        print(
            f"{curves:6d} {now.compare:10.1f} {exponents[0]:>9s} {now.left_out:11.2f} "
            f"{exponents[1]:>9s} {f'{now.apart:.0e}' if curves <= ALONE else '':>6s}",
            flush=True,
        )
        before = curves, now


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:] or (300, 1000, 3000)))
