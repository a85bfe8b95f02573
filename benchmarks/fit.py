"""The fit against other optimisers, on the same simulated data in one run.

Success is an end within 0.01 % of the best SSE that any method found. Rivals that expect a user's
own scaling (SciPy's and lmfit's differential evolution with their defaults, pymoo's genetic
algorithm, as the paper used one) search the raw constants within generous bounds; those that an
expert would use (fcmaes, CMA-ES, many starts of least squares) get the logarithms and the bounds
that ours has. Then: how the fit grows with the data, what the bootstrap costs, and memory.

    python benchmarks/fit.py [seeds]

Takes half an hour.
"""
# ruff: noqa: PLC0415  (a rival is imported where it runs: workers and helpers need none of them)

import itertools
import logging
import os
import resource
import sys
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any

# As Snakemake does for its jobs, and for every method here: small matrices lose by threads.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import numpy as np
from scipy.optimize import Bounds, differential_evolution, least_squares
from simulated import simulate_curves

from oilfilm.base.randomness import generator
from oilfilm.fits.conditions import varied_condition_mask
from oilfilm.fits.fit_tables import certificate_columns
from oilfilm.fits.global_search import population_sse, search
from oilfilm.fits.problem import CurveData, Problem, build_problem
from oilfilm.fits.uncertainty import curve_bootstrap, naive_covariance
from oilfilm.settings.resolve import resolve
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import CONDITIONS, FloatArray, bounds
from oilfilm.traction.laws.deng2026 import traction_coefficient
from simulated_lab.printed import read_printed_constants

ROOT = Path(__file__).parents[1]
CONFIG = resolve(ROOT / "config", {"campaign": "demo"})
PRINTED = read_printed_constants(ROOT / "data/reference/printed_coefficients.yaml")
OILS = ("4102", "4050", "4010")
# Bounds of the internal constants, which are logarithms and exponents.
LOG_BOX = bounds(PAPER_LAW)
# What a user who knows the size of mu and no more would allow for the raw constants.
_EXPONENTS = [(-6, 6)] * 3
RAW_BOX = np.array(
    [(-0.2, 0), *_EXPONENTS, (0, 10), *_EXPONENTS, (0, 200), *_EXPONENTS], dtype=float
)
# Success: the SSE is at most this above the best one, relative.
SUCCESS_TOLERANCE = 1e-4

# A search: the problem, its data and a seed -> the best SSE it ends with.
Search = Callable[[Problem, CurveData, int], float]


@cache
def task(oil: str, copies: int = 1) -> tuple[Problem, CurveData]:
    """The demonstration's matrix simulated `copies` times over."""
    conditions = np.array(list(itertools.product(*CONFIG.campaign.matrix.model_dump().values())))
    random = generator(CONFIG.seed, "bench-fit", oil)
    rig = next(iter(CONFIG.rigs.values()))
    data = simulate_curves(
        PRINTED[oil], np.tile(conditions, (copies, 1)), CONFIG.campaign.twin, rig, random
    )
    return build_problem(
        PAPER_LAW, data, varied_condition_mask(CONDITIONS, data.conditions, CONFIG.fit)
    ), data


def raw_sse(data: CurveData) -> Callable[[FloatArray], float]:
    """SSE of the raw constants; a candidate without a value is only very bad."""
    levels = data.conditions.T[:, :, np.newaxis]
    # every simulated curve has the same number of points
    slip, mu = (values.reshape(len(data.run_ids), -1) for values in (data.slip, data.mu))

    def sse(constants: FloatArray) -> float:
        with np.errstate(all="ignore"):
            error = traction_coefficient(constants, *levels, slip) - mu
            return float(np.nan_to_num(np.sum(error**2), nan=1e9, posinf=1e9))

    return sse


def log_sse(problem: Problem) -> Callable[[FloatArray], float]:
    """SSE of the internal constants."""

    def sse(values: FloatArray) -> float:
        with np.errstate(all="ignore"):
            return float(np.nan_to_num(np.sum(problem.residual(values) ** 2), nan=1e9, posinf=1e9))

    return sse


def ours(problem: Problem, data: CurveData, seed: int) -> float:
    """The project's search."""
    return search(problem, CONFIG.fit, [generator(seed, "bench")])[0].sse


def scipy_defaults(problem: Problem, data: CurveData, seed: int) -> float:
    """SciPy's differential evolution as it comes."""
    return float(differential_evolution(raw_sse(data), RAW_BOX, rng=seed).fun)


def lmfit_defaults(problem: Problem, data: CurveData, seed: int) -> float:
    """The same behind lmfit."""
    import lmfit

    names = [constant.name for constant in PAPER_LAW.constants]
    start = lmfit.Parameters()
    for name, (low, high) in zip(names, RAW_BOX, strict=True):
        start.add(name, value=(low + high) / 2, min=low, max=high)
    sse = raw_sse(data)

    def objective(given: Any) -> float:
        return sse(np.array([given[name].value for name in names]))

    found = lmfit.minimize(objective, start, method="differential_evolution", rng=seed)
    return sse(np.array([found.params[name].value for name in names]))


def genetic(sse: Callable[[FloatArray], float], box: FloatArray, seed: int) -> FloatArray:
    """The best candidate of pymoo's plain genetic algorithm: 100 candidates, 300 generations."""
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    class Fit(ElementwiseProblem):
        def _evaluate(self, x: FloatArray, out: dict[str, Any], *_: Any, **__: Any) -> None:
            out["F"] = sse(x)

    fit = Fit(n_var=12, n_obj=1, xl=box[:, 0], xu=box[:, 1])
    return np.asarray(minimize(fit, GA(pop_size=100), ("n_gen", 300), seed=seed).X)


def pymoo_ga(problem: Problem, data: CurveData, seed: int) -> float:
    """A plain genetic algorithm on the raw constants."""
    sse = raw_sse(data)
    return sse(genetic(sse, RAW_BOX, seed))


def fcmaes(problem: Problem, data: CurveData, seed: int) -> float:
    """Differential evolution of fcmaes on the logarithms."""
    from fcmaes import de

    box = Bounds(LOG_BOX[:, 0], LOG_BOX[:, 1])
    random = np.random.default_rng(seed)
    found = de.minimize(log_sse(problem), 12, box, max_evaluations=30_000, rg=random)
    return float(found.fun)


def pycma(problem: Problem, data: CurveData, seed: int) -> float:
    """CMA-ES on the logarithms, from a random start."""
    import cma

    start = np.random.default_rng(seed).uniform(*LOG_BOX.T)
    options = {
        "bounds": [*LOG_BOX.T],
        "seed": seed + 1,
        "verbose": -9,
        "maxfevals": 30_000,
        "CMA_stds": np.ptp(LOG_BOX, axis=1) / 4,
        "tolfun": 1e-13,
    }
    return float(cma.fmin2(log_sse(problem), start, 1.0, options)[1].result.fbest)


def many_starts(problem: Problem, data: CurveData, seed: int) -> float:
    """Levenberg-Marquardt from the best 20 of 2 000 random candidates."""
    starts = np.random.default_rng(seed).uniform(*LOG_BOX.T, size=(2000, 12))
    with np.errstate(all="ignore"):
        sse = population_sse(problem, starts)
        chosen = starts[np.argsort(np.nan_to_num(sse, nan=np.inf))[:20]]
        ends = [
            least_squares(problem.residual, start, problem.jacobian, method="lm", x_scale="jac")
            for start in chosen
        ]
    return 2 * min(float(end.cost) for end in ends)


METHODS: dict[str, Search] = {
    "oilfilm": ours,
    "SciPy DE, defaults": scipy_defaults,
    "lmfit DE, defaults": lmfit_defaults,
    "pymoo GA": pymoo_ga,
    "fcmaes DE": fcmaes,
    "pycma CMA-ES": pycma,
    "20 starts of LM": many_starts,
}


def contest(oil: str, seeds: int) -> None:
    """Success and time of every method on one oil."""
    problem, data = task(oil)
    ends, seconds = {}, {}
    for name, method in METHODS.items():
        method(problem, data, 10_000)  # imports and compilation are nobody's search
        start = time.perf_counter()
        ends[name] = np.array([method(problem, data, seed) for seed in range(seeds)])
        seconds[name] = (time.perf_counter() - start) / seeds
    best = min(end.min() for end in ends.values())
    print(f"\n{oil}: {len(data.mu)} points of {problem.curve_count} curves, best SSE {best:.6e}")
    print(
        f"{'method':20s} {'success':>8s} {'s a search':>11s} {'x ours':>7s} {'worst/best SSE':>15s}"
    )
    for name, end in ends.items():
        won = int((end <= best * (1 + SUCCESS_TOLERANCE)).sum())
        print(
            f"{name:20s} {won:3d} / {seeds:2d} {seconds[name]:11.3f} "
            f"{seconds[name] / seconds['oilfilm']:7.1f} {end.max() / best:15.6f}",
            flush=True,
        )


def global_searches(oil: str, seeds: int) -> None:
    """Relative spread of SSE over many seeds."""
    problem, data = task(oil)
    sse = np.array([ours(problem, data, seed) for seed in range(seeds)])
    agree = int((sse / sse.min() - 1 < 1e-8).sum())
    print(f"{oil}: {agree} of {seeds} seeds within 1e-8 of the best SSE")


def certified(problem: Problem, data: CurveData) -> float:
    """Seconds of one certified fit: five independent searches and the certificate."""
    start = time.perf_counter()
    optima = search(problem, CONFIG.fit, [generator(seed, "certified") for seed in range(5)])
    best = min(optima, key=lambda optimum: optimum.sse)
    errors = np.sqrt(np.diag(naive_covariance(problem, best)))
    verdict = certificate_columns(problem, optima, errors, CONFIG.fit)
    seconds = time.perf_counter() - start
    if not verdict["certified"]:
        print(verdict["doubts"])
    return seconds


def refits(oil: str, count: int) -> FloatArray:
    """Curve-bootstrap refits of one oil."""
    problem, _ = task(oil)
    (best,) = search(problem, CONFIG.fit, [generator(1, "refits")])
    return curve_bootstrap(problem, best, count, generator(2, "refits"))


def bootstrap_of_all() -> float:
    """Seconds of 1 000 refits of each oil on two processes that already run."""
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(partial(refits, count=2), OILS * 2))
        start = time.perf_counter()
        list(pool.map(partial(refits, count=1000), OILS))
        return time.perf_counter() - start


def growth() -> None:
    """Time of a certified fit with bootstrap against the number of curves."""
    print(f"\n{'curves':>7s} {'points':>8s} {'certified s':>12s} {'1000 refits s':>14s} {'x':>6s}")
    before = 0.0
    for copies in (1, 10, 45):
        problem, data = task("4102", copies)
        fit_s = min(certified(problem, data) for _ in range(2 if copies > 1 else 5))
        (best,) = search(problem, CONFIG.fit, [generator(1, "growth")])
        start = time.perf_counter()
        curve_bootstrap(problem, best, 1000, generator(2, "growth"))
        refit_s = time.perf_counter() - start
        ratio = (fit_s + refit_s) / before if before else 1.0
        before = fit_s + refit_s
        print(
            f"{problem.curve_count:7d} {len(data.mu):8d} {fit_s:12.3f} {refit_s:14.3f} "
            f"{ratio:6.1f}",
            flush=True,
        )


def main(seeds: int = 20) -> None:
    """Print everything."""
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    for oil in OILS:
        global_searches(oil, 200)
    for oil in OILS:
        print(f"{oil}: certified in {min(certified(*task(oil)) for _ in range(5)):.3f} s")
    print(f"3 x 1000 curve-bootstrap refits on 2 processes: {bootstrap_of_all():.2f} s")
    growth()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory so far, up to 100 000 points: {peak:.0f} MiB")
    for oil in OILS:
        contest(oil, seeds)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
