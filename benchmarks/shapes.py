"""How often curves with a defect are named by their shape, and how often good ones are.

Campaigns of 24 runs have two bad curves, those of 12 runs have one. `named` and `refused` count bad
curves that are odd, and those that are so by more than the limit of a refusal; `good named` and
`good refused` count good curves beside them. Clean campaigns have fifteen or six slips. A line per
campaign is printed while it runs.

    python benchmarks/shapes.py bad [first seed] [last seed]      (six defects, four truths)
    python benchmarks/shapes.py clean [first seed] [last seed]    (all truths)
    python benchmarks/shapes.py scale                             (time over the number of runs)

Takes 3 minutes per seed, `scale` half a minute. Parts with different seeds can run one after the
other.
"""

import itertools
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.surface.shape import REFUSED_ODDNESS, curve_shapes
from oilfilm.traction import PAPER_LAW

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from bad_curves import CURVE_DAMAGES, CurveDamage, damage_curves
from lawless_truths import TRUTHS
from surface_campaigns import (
    PRESSURES,
    SLIPS,
    SPEEDS,
    ends,
    grid,
    latin,
    random_conditions,
    simulated,
)

TWELVE = grid(ends(PRESSURES), ends(SPEEDS), (25.0, 72.0, 120.0))
# The last one has kinks, which no smooth surface follows.
DAMAGED_TRUTHS = ("jt", "own", "sol", "pw")
SIX_SLIPS = np.geomspace(0.006, 0.29, 6)


def trial(
    damage: CurveDamage | None,
    truth: str,
    conditions: FloatArray,
    bad_count: int,
    seed: int,
    slips: FloatArray = SLIPS,
) -> dict[str, object]:
    """One campaign with some bad curves: how many are named."""
    name = damage.__name__ if damage else "clean"
    random = generator(23, "shapes", name, truth, str(len(conditions)), str(seed))
    points = simulated(TRUTHS[truth], conditions, random, slips=slips)
    is_bad = np.zeros(len(conditions), dtype=bool)
    if damage:
        is_bad[random.permutation(len(conditions))[:bad_count]] = True
        points = damage_curves(points, np.flatnonzero(is_bad).tolist(), damage)
    start = time.perf_counter()
    oddness = np.array([shape.oddness for shape in curve_shapes(points, PAPER_LAW)])
    is_named, is_refused = oddness > 1, oddness > REFUSED_ODDNESS
    row: dict[str, object] = {
        "damage": name,
        "truth": truth,
        "truths": "kinks" if truth == "pw" else "smooth",
        "runs": len(conditions),
        "slips": len(slips),
        "bad": is_bad.sum(),
        "named": (is_named & is_bad).sum(),
        "refused": (is_refused & is_bad).sum(),
        "good": (~is_bad).sum(),
        "good named": (is_named & ~is_bad).sum(),
        "good refused": (is_refused & ~is_bad).sum(),
        "largest good": oddness[~is_bad].max(),
        "s": time.perf_counter() - start,
    }
    print(
        " ".join(
            f"{value:.3g}" if isinstance(value, float) else str(value) for value in row.values()
        ),
        flush=True,
    )
    return row


COUNTS = ["bad", "named", "refused", "good", "good named", "good refused"]


def bad(seeds: range) -> None:
    """Print how many bad curves are named, and how many good ones beside them."""
    rows = []
    for seed in seeds:
        for damage, truth in itertools.product(CURVE_DAMAGES, DAMAGED_TRUTHS):
            rows.append(trial(damage, truth, TWELVE, 1, seed))
            rows.append(trial(damage, truth, latin(), 2, seed))
    table = pd.DataFrame(rows)
    for groups in (["damage", "truths", "runs"], ["runs"]):
        print(table.groupby(groups, sort=False)[COUNTS].sum().to_string(), end="\n\n")
    print(f"{table['s'].mean():.1f} s per campaign")


def clean(seeds: range) -> None:
    """Print how many clean curves are named."""
    rows = []
    for truth in TRUTHS:
        for slips in (SLIPS, SIX_SLIPS):
            # half as many campaigns with six slips: a third of the curves
            for seed in seeds if slips is SLIPS else seeds[::2]:
                rows.append(trial(None, truth, latin(), 0, seed, slips))
                rows.append(trial(None, truth, TWELVE, 0, seed, slips))
    table = pd.DataFrame(rows)
    by_slips = table.groupby("slips")
    print(by_slips[COUNTS].sum().assign(largest=by_slips["largest good"].max()).to_string())
    print(table.sort_values("largest good").tail(5).to_string())


def scale() -> None:
    """Print seconds over the number of runs."""
    print("  runs      s")
    for runs in (30, 100, 300, 1000, 3000):
        random = generator(23, "shapes", "scale", str(runs))
        points = simulated(TRUTHS["jt"], random_conditions(runs, random), random)
        start = time.perf_counter()
        curve_shapes(points, PAPER_LAW)
        print(f"{runs:6d} {time.perf_counter() - start:6.1f}", flush=True)


def main(arguments: list[str]) -> None:
    """Print the table that the arguments ask for."""
    first, last = (int(number) for number in [*arguments[1:3], *("0", "0")[len(arguments[1:3]) :]])
    match arguments[:1]:
        case ["bad"]:
            bad(range(first, last + 1))
        case ["clean"]:
            clean(range(first, last + 1))
        case ["scale"]:
            scale()
        case _:
            raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
