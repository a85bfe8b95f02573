"""Global searches by differential evolution, polished by Newton's method.

A search looks among the logarithms of |A0|, B0 and C0, with the analytic derivatives of the law.
All searches run at once, in the same arrays; each has random numbers of its own, and none knows of
the others.

Decides: how constants are searched.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oilfilm.fits.descent import descend
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings
from oilfilm.units import BoolArray, FloatArray

# Points times candidates evaluated at once: about what fits a processor's cache.
_CHUNK = 1 << 14

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

    Differential evolution is stopped while its population still covers several valleys; members
    of all ranks are then polished, and the lowest end counts. A population left to converge ends
    in a wrong valley in one search of four on the hardest oil, a polish from a member of it
    reaches the right one about every second time.

    Args:
        problem: What to fit.
        settings: `population`, `generations` and `polished` of config's fit.
        randoms: Source of each search's random numbers.
    """
    few = problem.thinned(_FEW_POINTS)
    members = _evolved(few, settings, randoms)
    ends = members.reshape(-1, members.shape[-1])
    for part, steps in ((few, _STEPS), (problem, _FURTHER_STEPS)):
        ends, sse = descend(part, ends, tolerance=_ROUGH_TOLERANCE, most_steps=steps)
    lowest = np.argmin(sse.reshape(members.shape[:2]), axis=1)
    best = ends.reshape(members.shape)[np.arange(len(members)), lowest]
    return [polish(problem, end) for end in best]


def _evolved(
    problem: Problem, settings: FitSettings, randoms: Sequence[np.random.Generator]
) -> FloatArray:
    """Members of all ranks of each search's last population: shape (searches, polished, free).

    Reference: R. Storn, K. Price, J. Glob. Optim. 11 (1997) 341, DE/rand/1/bin.
    """
    low, high = problem.limits.T
    starts = [constant.start_lower for constant in problem.law.constants]
    low = np.maximum(low, np.array(starts)[problem.free])
    count = max(settings.population, _CANDIDATES * len(low))
    population = np.stack([_spread(low, high, count, random) for random in randoms])
    sse = population_sse(problem, population)
    for _ in range(settings.generations):
        pairs = zip(population, randoms, strict=True)
        trials = np.stack([_trials(members, low, high, random) for members, random in pairs])
        of_trials = population_sse(problem, trials)
        better = of_trials < sse
        population = np.where(better[..., np.newaxis], trials, population)
        sse = np.where(better, of_trials, sse)
    ranks = np.linspace(0, count - 1, settings.polished).astype(int)
    chosen = np.argsort(sse, axis=1)[:, ranks, np.newaxis]
    return np.take_along_axis(population, chosen, axis=1)


def _spread(
    low: FloatArray, high: FloatArray, count: int, random: np.random.Generator
) -> FloatArray:
    """Candidates spread over the bounds by a Latin hypercube, shape (count, free)."""
    rank = random.permuted(np.tile(np.arange(count), (len(low), 1)), axis=1).T
    return low + (high - low) * (rank + random.random(rank.shape)) / count


def _trials(
    members: FloatArray, low: FloatArray, high: FloatArray, random: np.random.Generator
) -> FloatArray:
    """One trial per member, x1 + F (x2 - x3) of three others crossed with the member itself."""
    count, size = members.shape
    order = random.random((count, count))
    np.fill_diagonal(order, np.inf)
    first, second, third = members[np.argsort(order, axis=1)[:, :3].T]
    mutants = first + random.uniform(*_MUTATION) * (second - third)
    mutants = np.where((mutants < low) | (mutants > high), random.uniform(low, high), mutants)
    taken = random.random((count, size)) < _RECOMBINATION
    taken[np.arange(count), random.integers(size, size=count)] = True
    return np.where(taken, mutants, members)


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
    # from a rough start Newton's method may run off along a valley without a floor
    for near, tolerance in ((False, _TOLERANCE), (True, _LAST_DIGITS)):
        held = at_bounds(problem, ends)
        ends, sse = descend(problem, ends, held=held, tolerance=tolerance, near=near)
    return Optimum(ends[0], float(sse[0]))


def population_sse(problem: Problem, population: FloatArray) -> FloatArray:
    """Sum of squared errors of each candidate; population of shape (..., free)."""
    candidates = population.reshape(-1, population.shape[-1]).T
    step = max(_CHUNK // max(len(problem.mu), 1), 1)
    with np.errstate(over="ignore", invalid="ignore"):
        chunks = [
            problem.law.traction(problem.expand(candidates[:, start : start + step]), problem.at)
            for start in range(0, candidates.shape[1], step)
        ]
        sums = [np.square(chunk - problem.mu[:, np.newaxis]).sum(axis=0) for chunk in chunks]
    return np.concatenate(sums).reshape(population.shape[:-1])
