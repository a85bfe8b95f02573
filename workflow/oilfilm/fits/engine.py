"""Global searches by SciPy's differential evolution, polished by Newton's method.

A search looks among the logarithms of |A0|, B0 and C0, with the analytic derivatives of the law.
Differential evolution only finds starts. Where a search ends is decided by the descent from them:
the descents of all searches run at once, and no search knows of the others.

Decides: how constants are searched.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.fits.descent import descend
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings

# Points that are enough to find the valleys; the ends in them are compared by all points.
_FEW_POINTS = 500
# Enough to tell the valleys apart: local minima lie 7 % and more above the best one.
_ROUGH_TOLERANCE = 1e-3
# Steps to a valley, and to its floor by all points; what needs more runs off.
_STEPS, _FURTHER_STEPS = 50, 15
# Of the SSE, where Newton's method begins, and before its last step.
_TOLERANCE, _LAST_DIGITS = 1e-6, 1e-14
# Of a candidate's constants, those taken from a mutant; and the range of the mutation factor.
_RECOMBINATION = 0.9
_MUTATION = (0.5, 1.0)
# Candidates per constant at least.
_CANDIDATES = 5


@dataclass(frozen=True)
class Optimum:
    """End of one search: free internal constants and the sum of squared errors there."""

    values: FloatArray
    sse: float


def search(
    problem: Problem, settings: FitSettings, randoms: Sequence[np.random.Generator]
) -> list[Optimum]:
    """Global searches from scratch.

    Differential evolution is stopped while its population still covers several valleys. Members
    of all ranks are then polished, and the lowest end counts. On the hardest oil a fully converged
    population is in the wrong valley in 1 of 4 searches; polishing one member finds the right one
    in about 1 of 2.

    Args:
        problem: What to fit.
        settings: `population`, `generations` and `polished` of config's fit.
        randoms: Source of each search's random numbers.
    """
    few = problem.thinned(_FEW_POINTS)
    members = np.stack([_evolved(few, settings, random) for random in randoms])
    ends = members.reshape(-1, members.shape[-1])
    for part, steps in ((few, _STEPS), (problem, _FURTHER_STEPS)):
        ends, sse = descend(part, ends, tolerance=_ROUGH_TOLERANCE, most_steps=steps)
    lowest = np.argmin(sse.reshape(members.shape[:2]), axis=1)
    best = ends.reshape(members.shape)[np.arange(len(members)), lowest]
    return [polish(problem, end) for end in best]


def _evolved(problem: Problem, settings: FitSettings, random: np.random.Generator) -> FloatArray:
    """Members of all ranks of one search's last population: shape (polished, free).

    Reference: R. Storn, K. Price, J. Glob. Optim. 11 (1997) 341, DE/rand/1/bin.
    """
    low, high = problem.limits.T
    starts = [constant.start_lower for constant in problem.law.constants]
    low = np.maximum(low, np.array(starts)[problem.free])
    candidates = max(settings.population, _CANDIDATES * len(low))

    # SciPy's types know no vectorized function
    def sse(members: FloatArray) -> Any:
        return population_sse(problem, members.T)

    # SciPy imports `optimize` at its first use; only jobs that search wait for it
    end = scipy.optimize.differential_evolution(
        sse,
        scipy.optimize.Bounds(low, high),
        strategy="rand1bin",
        popsize=math.ceil(candidates / len(low)),
        maxiter=settings.generations,
        tol=0,  # all generations
        mutation=_MUTATION,
        recombination=_RECOMBINATION,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=random,
    )
    ranks = np.linspace(0, len(end.population) - 1, settings.polished).astype(int)
    by_rank = np.argsort(end.population_energies, kind="stable")
    return np.asarray(end.population[by_rank[ranks]])


def at_bounds(problem: Problem, values: FloatArray) -> BoolArray:
    """Which free constants, shape (..., free), are at a bound of the search."""
    low, high = problem.limits.T
    margin = 1e-6 * (high - low)
    return np.asarray((values <= low + margin) | (values >= high - margin))


def polish(problem: Problem, start: FloatArray) -> Optimum:
    """The local optimum next to `start`, to the last digits, within the law's bounds.

    A constant that starts at a bound stays there.

    Args:
        problem: What to fit.
        start: Free internal constants to start from.
    """
    ends = np.clip(start, *problem.limits.T)[np.newaxis]
    # From a rough start Newton's method may run off along a valley without a floor. Its last step
    # is damped, and leaves over a share of itself that depends on the start: one more step, from
    # where it ended, leaves rounding only.
    for near, tolerance in ((False, _TOLERANCE), (True, _LAST_DIGITS), (True, _LAST_DIGITS)):
        held = at_bounds(problem, ends)
        ends, sse = descend(problem, ends, held=held, tolerance=tolerance, near=near)
    return Optimum(ends[0], float(sse[0]))


def population_sse(problem: Problem, population: FloatArray) -> FloatArray:
    """Sum of squared errors of each candidate, inf where it has none; population (k, free)."""
    with np.errstate(over="ignore", invalid="ignore"):
        mu = problem.law.traction(problem.expand(population.T), problem.at)
        sse = np.square(mu - problem.mu[:, np.newaxis]).sum(axis=0)
    return np.where(np.isnan(sse), np.inf, sse)
