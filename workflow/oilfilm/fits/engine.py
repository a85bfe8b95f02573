"""Global search by differential evolution, polished by Levenberg-Marquardt.

SciPy's defaults on the raw constants never reach the optimum of this problem. Searching the
logarithms of |A0|, B0 and C0, a whole population in one call, and polishing with the analytic
Jacobian does, every time.

Decides: how constants are searched.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np
import scipy

from oilfilm.fits.descent import descend
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings
from oilfilm.units import BoolArray, FloatArray

# Points times candidates evaluated at once: about what fits a processor's cache.
_CHUNK = 1 << 15

# Enough to tell the valleys apart: local minima lie 7 % and more above the best one.
_ROUGH_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Optimum:
    """End of one search: free internal constants and the sum of squared errors there."""

    values: FloatArray
    sse: float


def search(problem: Problem, settings: FitSettings, random: np.random.Generator) -> Optimum:
    """One global search from scratch.

    Differential evolution is stopped while its population still covers several valleys; members
    of all ranks are then polished, and the lowest end counts. A population left to converge ends
    in a wrong valley in one search of four on the hardest oil, a polish from a member of it
    reaches the right one about every second time.

    Args:
        problem: What to fit.
        settings: `population`, `generations` and `polished` of config's fit.
        random: Source of the search's random numbers.
    """
    low, high = problem.limits.T
    starts = [constant.start_lower for constant in problem.law.constants]
    low = np.maximum(low, np.array(starts)[problem.free])

    def objective(population: FloatArray) -> FloatArray:
        return population_sse(problem, population)

    result = scipy.optimize.differential_evolution(
        objective,  # type: ignore[arg-type]  # the stubs do not know of `vectorized`
        scipy.optimize.Bounds(low, high),
        strategy="rand1bin",
        popsize=max(ceil(settings.population / len(low)), 5),
        maxiter=settings.generations,
        mutation=(0.5, 1.0),
        recombination=0.9,
        tol=0.0,
        rng=random,
        polish=False,
        updating="deferred",
        vectorized=True,
    )
    ranked = result.population[np.argsort(result.population_energies)]
    chosen = ranked[np.linspace(0, len(ranked) - 1, settings.polished).astype(int)]
    ends, sse = descend(problem, chosen, tolerance=_ROUGH_TOLERANCE)
    # from a rough end the last polish may run off along a valley without a floor
    lowest, _ = descend(problem, ends[[np.argmin(sse)]])
    return polish(problem, lowest[0])


def at_bounds(problem: Problem, values: FloatArray) -> BoolArray:
    """Which free constants are at a bound of the search."""
    low, high = problem.limits.T
    margin = 1e-6 * (high - low)
    return np.asarray((values <= low + margin) | (values >= high - margin))


def polish(problem: Problem, start: FloatArray, weight: FloatArray | None = None) -> Optimum:
    """The local optimum next to `start`, to the last digits, within the law's bounds.

    MINPACK's Levenberg-Marquardt with the analytic Jacobian: it factors the Jacobian itself, where
    `descend`, made for many rough ends at once, squares its condition number. As there, the
    constant farthest outside its bounds stays at the bound, as does one that starts there.

    Args:
        problem: What to fit.
        start: Free internal constants to start from.
        weight: Weight of each point's squared error; 1 if not given.
    """
    low, high = problem.limits.T
    values, held = np.clip(start, low, high), at_bounds(problem, start)
    while True:
        values[~held], sse = _polish(problem.holding(values, held), values[~held], weight)
        outside = ~held * problem.beyond(values)
        if not outside.any():
            return Optimum(values, sse)
        values = np.where(outside > 0, np.clip(values, low, high), values)
        held[np.argmax(outside)] = True


def _polish(
    problem: Problem, start: FloatArray, weight: FloatArray | None
) -> tuple[FloatArray, float]:
    factor = np.ones(len(problem.mu)) if weight is None else np.sqrt(weight)

    def residual(values: FloatArray) -> FloatArray:
        return factor * problem.residual(values)

    def jacobian(values: FloatArray) -> FloatArray:
        return factor[:, np.newaxis] * problem.jacobian(values)

    # a trial step may run off to where the law overflows; the method takes it back
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        result = scipy.optimize.least_squares(
            residual,
            start,
            jacobian,
            method="lm",
            x_scale="jac",
            ftol=1e-15,
            xtol=1e-15,
            gtol=1e-15,
            max_nfev=1000,
        )
    return result.x, 2 * float(result.cost)


def population_sse(problem: Problem, population: FloatArray) -> FloatArray:
    """Sum of squared errors of each candidate; population of shape (free, candidates)."""
    candidates = population.shape[1]
    step = max(_CHUNK // max(len(problem.mu), 1), 1)
    chunks = [
        problem.law.traction(problem.expand(population[:, start : start + step]), problem.at)
        for start in range(0, candidates, step)
    ]
    return np.concatenate(
        [np.square(chunk - problem.mu[:, np.newaxis]).sum(axis=0) for chunk in chunks]
    )
