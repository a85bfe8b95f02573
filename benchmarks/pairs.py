"""How often the interval of a ratio of two oils holds the true ratio, and how wide it is.

Two campaigns of one rig are simulated as points, each is fitted with Deng's law, and the surface of
their ratio is fitted. The true ratio is compared at new conditions of the tested box, at slips
between the tested ones. The columns:

    level        share of ratios that the interval should hold
    inside       share of true ratios inside; least: the smallest share of a campaign
    half         half width of the interval over the ratio, median
    certain      share of answers that say which oil is higher; wrong: those that are not true
    answered     share of points with support
    s            seconds per pair

    python benchmarks/pairs.py                       (three pairs, 24 and 8 conditions, one seed)
    python benchmarks/pairs.py planted [seeds]       (ratio 1.04; 24, 12 and 8 conditions)
    python benchmarks/pairs.py relatives [seeds]     (oils of one family)
    python benchmarks/pairs.py strangers [seeds]     (oils with nothing in common)
    python benchmarks/pairs.py alone [seeds]         (half of the conditions have one oil only)
    python benchmarks/pairs.py scale                 (time and memory over the number of runs)

Takes 1 minute; `planted` takes 6, `relatives` 6, `strangers` 2, `alone` 4 and `scale` 3.
"""

import sys
import time
import tracemalloc
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.surface.ratio import OilOfPair, fit_ratio

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from lawless_truths import TRUTHS
from planted_pairs import PLANTED, PLANTED_RATIO, RELATED, UNRELATED, OilPair, scaled_oil
from surface_campaigns import (
    PRESSURES,
    SPEEDS,
    TEMPERATURES,
    ends,
    fitted_law,
    grid,
    latin,
    random_conditions,
    simulated,
)

NEW_POINTS = 200
DESIGNS = {
    "24 latin": latin(),
    "12 = 2x2x3": grid(ends(PRESSURES), ends(SPEEDS), (25.0, 72.0, 120.0)),
    "8 = 2x2x2": grid(ends(PRESSURES), ends(SPEEDS), ends(TEMPERATURES)),
}


def campaign(name: str, pair: OilPair, design: str, seed: int, *, alone: bool) -> dict[str, object]:
    """Two campaigns: coverage and width of the interval of their ratio.

    Args:
        name: Name of the pair.
        pair: The two truths.
        design: Name of the plan of tests.
        seed: Number of the campaign.
        alone: Whether half of the conditions of each oil are its own.
    """
    random = generator(23, "pairs", name, design, str(alone), str(seed))
    conditions = DESIGNS[design]
    of_oils = [conditions, conditions]
    if alone:
        own = len(conditions) // 2
        shared = random.permutation(len(conditions))[own:]
        of_oils = [
            np.vstack([conditions[shared], random_conditions(own, random)]) for _ in range(2)
        ]
    oils = []
    for truth, of_oil in zip((pair.first, pair.second), of_oils, strict=True):
        points = simulated(truth, of_oil, random)
        oils.append(OilOfPair(points, fitted_law(points)))
    start = time.perf_counter()
    surface = fit_ratio(*oils)
    factors = surface.interval_factors
    seconds = time.perf_counter() - start

    lowest, highest = conditions.min(axis=0), conditions.max(axis=0)
    asked = lowest + random.random((NEW_POINTS, 3)) * (highest - lowest)
    slip = np.exp(random.uniform(np.log(0.0015), np.log(0.3), NEW_POINTS))
    prediction = surface.predict(asked, slip)
    lower, upper = prediction.interval(factors.point)
    true = pair.ratio(asked, slip)
    supported = prediction.support_codes == 0
    higher, less = lower > 1, upper < 1
    wrong = (higher & (true < 1)) | (less & (true > 1))
    return {
        "design": design,
        "pair": name,
        "level": factors.level,
        "inside": ((lower <= true) & (true <= upper))[supported].mean(),
        "half": np.median(factors.point * prediction.ln_ratio_sd[supported]),
        "certain": (higher | less)[supported].mean(),
        "wrong": wrong.mean(),
        "answered": supported.mean(),
        "factor": factors.point,
        "converged": surface.converged,
        "s": seconds,
    }


def coverage(
    pairs: Mapping[str, OilPair], designs: Sequence[str], seeds: int, *, alone: bool = False
) -> None:
    """Print the coverage by design and pair, and by design."""
    rows = []
    for design in designs:
        for name, pair in pairs.items():
            rows.extend(campaign(name, pair, design, seed, alone=alone) for seed in range(seeds))
    table = pd.DataFrame(rows)
    for groups in (["design", "pair"], ["design"]):
        grouped = table.groupby(groups, sort=False)
        summary = grouped[list(table.columns[2:])].mean()
        summary.insert(2, "least", grouped["inside"].min())
        print(summary.round(4).to_string(), end="\n\n")


def scale() -> None:
    """Print seconds, and the largest memory of arrays, over the number of runs of each oil."""
    print("  runs      s    MB  half %  error %")
    for runs in (24, 72, 300, 1000):
        random = generator(23, "pairs", "scale", str(runs))
        conditions = random_conditions(runs, random)
        oils = []
        for truth in (TRUTHS["jt"], scaled_oil(TRUTHS["jt"])):
            points = simulated(truth, conditions, random)
            oils.append(OilOfPair(points, fitted_law(points)))
        start = time.perf_counter()
        tracemalloc.start()
        surface = fit_ratio(*oils)
        factor = surface.interval_factors.point
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        seconds = time.perf_counter() - start
        asked = random_conditions(NEW_POINTS, random)
        prediction = surface.predict(asked, np.full(NEW_POINTS, 0.05))
        half = np.median(factor * prediction.ln_ratio_sd)
        error = np.quantile(np.abs(prediction.ratio / PLANTED_RATIO - 1), 0.95)
        print(f"{runs:6d} {seconds:6.1f} {peak / 1e6:5.0f} {100 * half:7.2f} {100 * error:8.2f}")


def main(arguments: list[str]) -> None:
    """Print the table that the arguments ask for."""
    seeds = int(arguments[1]) if len(arguments) > 1 else 1
    every_design = tuple(DESIGNS)
    match arguments[:1]:
        case ["planted"]:
            coverage(PLANTED, every_design, seeds)
        case ["relatives"]:
            coverage(RELATED, every_design, seeds)
        case ["strangers"]:
            coverage(UNRELATED, every_design, seeds)
        case ["alone"]:
            coverage(PLANTED | RELATED, ("24 latin",), seeds, alone=True)
        case ["scale"]:
            scale()
        case []:
            few = {name: PLANTED[name] for name in list(PLANTED)[:3]}
            coverage(few, ("24 latin", "8 = 2x2x2"), 1)
        case _:
            raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
