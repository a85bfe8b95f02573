"""How often the intervals of the constants cover the truth, over simulated campaigns.

Each campaign has the demonstration's matrix, noise, control errors and per-run errors of load and
temperature. Printed per constant: the share of campaigns whose nominal 95 % interval covers the
planted value, for the curve bootstrap (the interval in the table of coefficients) and for the
naive error. A share of 200 campaigns is itself known to 1.5 %.

    python benchmarks/coverage.py [campaigns] [refits]
"""

import itertools
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from oilfilm.fits.conditions import varied
from oilfilm.fits.engine import polish
from oilfilm.fits.problem import build_problem
from oilfilm.fits.uncertainty import curve_bootstrap, naive_covariance
from oilfilm.paper.reference import printed_constants
from oilfilm.randomness import generator
from oilfilm.rig_twin.plateaus import simulate_curves
from oilfilm.settings.resolve import resolve
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import CONDITIONS, FloatArray, to_internal

ROOT = Path(__file__).parents[1]
NORMAL_95 = 1.959964


def covered(oil: str, refits: int, number: int) -> FloatArray:
    """1 where a constant's interval covers the truth: a row for the bootstrap, one naive."""
    config = resolve(ROOT / "config", {"campaign": "demo"})
    campaign = config.campaign
    constants = printed_constants(ROOT / "data/reference/printed_coefficients.yaml")[oil]
    truth = to_internal(PAPER_LAW, constants)
    conditions = np.array(list(itertools.product(*campaign.matrix.model_dump().values())))
    random = generator(config.seed, "coverage", oil, number)
    rig = next(iter(config.rigs.values()))
    data = simulate_curves(constants, conditions, campaign.twin, rig, random)
    problem = build_problem(PAPER_LAW, data, varied(CONDITIONS, data.conditions, config.fit))
    best = polish(problem, truth)
    lower, upper = np.quantile(curve_bootstrap(problem, best, refits, random), [0.025, 0.975], 0)
    naive = NORMAL_95 * np.sqrt(np.diag(naive_covariance(problem, best)))
    inside = (lower <= truth) & (truth <= upper), np.abs(truth - best.values) <= naive
    return np.array(inside, dtype=float)


def coverage(oil: str, campaigns: int, refits: int) -> FloatArray:
    """Shares of the campaigns: a row for the bootstrap, one naive; a column a constant."""
    with ProcessPoolExecutor(2) as pool:
        task = partial(covered, oil, refits)
        return np.mean(list(pool.map(task, range(campaigns), chunksize=4)), axis=0)


def main(campaigns: int = 200, refits: int = 1000) -> None:
    """Print the shares of every oil."""
    names = " ".join(f"{constant.name:>5s}" for constant in PAPER_LAW.constants)
    print(f"share of {campaigns} campaigns whose 95 % interval covers the truth; {refits} refits")
    for oil in ("4102", "4050", "4010"):
        print(f"{oil:16s} {names}")
        for name, shares in zip(
            ("curve bootstrap", "naive"), coverage(oil, campaigns, refits), strict=True
        ):
            print(f"{name:16s} " + " ".join(f"{share:5.3f}" for share in shares), flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3]))
