"""Resampled refits of every law against SciPy's, in one run.

For each law and each oil of the demonstration, both refit the same resampled curves from the same
start, on one core: ours all at once, `scipy.optimize.least_squares(method="lm")` one after the
other, as fast as it can be: analytic Jacobian, its own tolerances (1e-8; ours are 1e-10), a curve
drawn twice as one curve of weight 2. Both hold a constant that leaves its bounds. Printed per law:
CPU time per refit, the ratio, the largest distance of a constant from SciPy's in standard errors
where both end in one valley (SSE equal to 1e-6), and how many end elsewhere and who lower.

    python benchmarks/refits.py [refits per oil]

Takes 5 minutes.
"""

import os
import sys
import time
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

# As Snakemake does for its jobs.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from scipy.optimize import least_squares
from simulated import simulate_curves

from oilfilm.base.randomness import generator
from oilfilm.fits.conditions import varied_condition_mask
from oilfilm.fits.fit import laws_of_oil
from oilfilm.fits.global_search import Optimum, is_at_bound, search
from oilfilm.fits.problem import CurveData, Problem, build_problem
from oilfilm.fits.uncertainty import curve_bootstrap, draw_curves
from oilfilm.settings.resolve import resolve
from oilfilm.traction import LAW_NAMES
from oilfilm.traction.law import FloatArray, IndexArray, Law, Observations
from simulated_lab.printed import read_printed_constants

ROOT = Path(__file__).parents[1]
CONFIG = resolve(ROOT / "config", {"campaign": "demo"})
PRINTED = read_printed_constants(ROOT / "data/reference/printed_coefficients.yaml")
OILS = ("4102", "4050", "4010")
# Two SSE this near each other, relative, are of one valley.
SAME_SSE = 1e-6


def curves(oil: str) -> CurveData:
    """The demonstration's matrix, simulated."""
    matrix = CONFIG.campaign.matrix
    assert matrix is not None
    conditions = np.array(list(product(*matrix.model_dump().values())))
    random = generator(CONFIG.seed, "bench-refits", oil)
    rig = next(iter(CONFIG.rigs.values()))
    return simulate_curves(PRINTED[oil], conditions, CONFIG.campaign.twin, rig, random)


def fitted(law: Law, data: CurveData) -> tuple[Problem, Optimum]:
    """The problem of a law and its optimum; what ended at a bound stays there."""
    if "load_n" in law.conditions:
        contact = CONFIG.common_contact()
        assert contact is not None
        load_n = contact.load_n(data.conditions[:, 0])
        data = replace(data, conditions=np.column_stack([load_n, data.conditions[:, 1:]]))
    problem = build_problem(
        law, data, varied_condition_mask(law.conditions, data.conditions, CONFIG.fit)
    )
    random = [generator(seed, "refits") for seed in range(CONFIG.fit.searches)]
    best = min(search(problem, CONFIG.fit, random), key=lambda end: end.sse)
    stuck = is_at_bound(problem, best.constants)
    return problem.holding(best.constants, stuck), Optimum(best.constants[~stuck], best.sse)


@dataclass(frozen=True)
class Resample:
    """The problem of the curves drawn, with the square root of each point's weight."""

    problem: Problem
    weight: FloatArray

    @classmethod
    def from_draw(cls, problem: Problem, draw: IndexArray) -> "Resample":
        """The resample of a problem; `draw` is how often each curve was drawn."""
        original = problem.observations
        is_drawn_curve = draw > 0
        is_drawn_point = is_drawn_curve[original.curve_of_point]
        original_curve = original.curve_of_point[is_drawn_point]
        new_index_of_curve = np.cumsum(is_drawn_curve) - 1
        observations = Observations(
            original.design[is_drawn_curve],
            new_index_of_curve[original_curve],
            original.slip[is_drawn_point],
        )
        drawn_problem = replace(problem, observations=observations, mu=problem.mu[is_drawn_point])
        return cls(drawn_problem, np.sqrt(draw[original_curve]))

    def residual(self, values: FloatArray) -> FloatArray:
        """Of each point drawn, weighted."""
        return self.weight * self.problem.residual(values)

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Derivatives of the residual."""
        return self.weight[:, np.newaxis] * self.problem.jacobian(values)

    def end(self, values: FloatArray) -> FloatArray:
        """One refit by MINPACK; the constant farthest outside its bounds stays at its bound."""
        low, high = self.problem.free_bounds.T
        values, held = values.copy(), np.zeros(len(values), dtype=bool)
        while True:
            part = replace(self, problem=self.problem.holding(values, held))
            values[~held] = least_squares(
                part.residual, values[~held], part.jacobian, method="lm", x_scale="jac"
            ).x
            outside = ~held * self.problem.distance_beyond_bounds(values)
            if not outside.any():
                return values
            values = np.where(outside > 0, np.clip(values, low, high), values)
            held[np.argmax(outside)] = True


@dataclass(frozen=True)
class Race:
    """Our refits and SciPy's of one oil.

    Attributes:
        ours_s: CPU time of ours.
        scipy_s: CPU time of SciPy's.
        apart: Largest distance of a constant in standard errors, by refit.
        excess: Our SSE over SciPy's, less 1, by refit; below 0 ours is lower.
    """

    ours_s: float
    scipy_s: float
    apart: FloatArray
    excess: FloatArray


def race(problem: Problem, best: Optimum, refits: int) -> Race:
    """Both refit the same resamples."""
    draws = draw_curves(problem.observations.design, refits, generator(1, "refits"))
    tasks = [Resample.from_draw(problem, draw) for draw in draws]
    times = [time.process_time()]
    ours = curve_bootstrap(problem, best, refits, generator(1, "refits"))
    times.append(time.process_time())
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        theirs = np.array([task.end(best.constants) for task in tasks])
    times.append(time.process_time())
    sums = [
        [float(np.sum(task.residual(end) ** 2)) for task, end in zip(tasks, ends, strict=True)]
        for ends in (ours, theirs)
    ]
    apart = (np.abs(ours - theirs) / ours.std(axis=0)).max(axis=1)
    ours_s, scipy_s = np.diff(times)
    return Race(ours_s, scipy_s, apart, np.array(sums[0]) / np.array(sums[1]) - 1)


def main(refits: int = 1000) -> None:
    """Print a row per law."""
    print(f"{refits} refits for each of {len(OILS)} oils")
    print(
        "law                      ours ms  SciPy ms  ratio   apart   elsewhere: ours, SciPy lower"
    )
    for name in LAW_NAMES:
        races = []
        for oil in OILS:
            problem, best = fitted(laws_of_oil(oil, CONFIG)[name], curves(oil))
            # the law is compiled at its first use: a refit of 1000 does not notice
            curve_bootstrap(problem, best, 2, generator(2, "refits"))
            races.append(race(problem, best, refits))
        count = refits * len(OILS)
        ours, scipy = sum(each.ours_s for each in races), sum(each.scipy_s for each in races)
        excess = np.concatenate([each.excess for each in races])
        apart = np.concatenate([each.apart for each in races])[np.abs(excess) <= SAME_SSE]
        print(
            f"{name:24s} {1e3 * ours / count:7.2f} {1e3 * scipy / count:9.2f} {scipy / ours:6.1f} "
            f"{apart.max():7.0e} {(excess < -SAME_SSE).sum():16d}, {(excess > SAME_SSE).sum()}",
            flush=True,
        )


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
