"""Global searches by SciPy's differential evolution, polished by Newton's method.

A search looks for the free internal constants of a law. The internal value of an X0 (A0, B0, ...)
is ln|X0|. That of an exponent is the exponent itself. Constants that the law prescribes are not
free.

Differential evolution only finds starts. The descents from these starts decide where a search ends.
They use the analytic derivatives of the law. The descents of all searches run at once, and each
search is independent of the others.

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

# Number of points of the first descents. They are enough to find the valleys of the SSE. The lowest
# points of the valleys are then found and compared with all points.
_POINTS_TO_FIND_VALLEYS = 500
# Relative decrease of the SSE at which a descent to a valley ends. It is small enough to tell the
# valleys apart: the SSE of local minima is at least 7 % above that of the best one.
_VALLEY_TOLERANCE = 1e-3
# Largest number of steps of a descent to a valley, with few points and then with all points. A
# descent that needs more diverges.
_STEPS_TO_VALLEY = 50
_STEPS_WITH_ALL_POINTS = 15
# Relative decrease of the SSE where Newton's method begins, and where it ends.
_NEWTON_TOLERANCE = 1e-6
_LAST_DIGITS_TOLERANCE = 1e-14
# Share of a new member's constants that come from a mutant.
_RECOMBINATION = 0.9
# Range of the factor of a mutation.
_MUTATION = (0.5, 1.0)
# A population has at least so many members per free constant.
_FEWEST_MEMBERS_PER_CONSTANT = 5
# A constant is at a bound where it is nearer to it than this share of the range.
_AT_BOUND_SHARE = 1e-6


@dataclass(frozen=True)
class Optimum:
    """The end of a search.

    Attributes:
        constants: Free internal constants, shape (free,).
        sse: Sum of squared errors there.
    """

    constants: FloatArray
    sse: float


def search(
    problem: Problem, settings: FitSettings, randoms: Sequence[np.random.Generator]
) -> list[Optimum]:
    """Independent global searches; the optimum of each of them.

    Differential evolution stops while the members of its population are still in several valleys.
    Descents then start from members of all ranks. The search ends at the lowest of their ends.

    Two simpler ways fail on the hardest oil. If the population converges fully, it is in the wrong
    valley in 1 of 4 searches. A descent from a single member finds the right valley in about 1 of 2
    searches.

    Args:
        problem: What to fit.
        settings: `population`, `generations` and `polished` of config's fit. `polished` is the
            number of members from which descents start.
        randoms: Source of each search's random numbers.

    Returns:
        One optimum per search.
    """
    thinned_problem = problem.thinned(_POINTS_TO_FIND_VALLEYS)
    members = np.stack([_evolved_members(thinned_problem, settings, random) for random in randoms])
    search_count, member_count, free_count = members.shape
    starts = members.reshape(-1, free_count)
    ends, _ = descend(
        thinned_problem, starts, tolerance=_VALLEY_TOLERANCE, most_steps=_STEPS_TO_VALLEY
    )
    ends, sse = descend(
        problem, ends, tolerance=_VALLEY_TOLERANCE, most_steps=_STEPS_WITH_ALL_POINTS
    )
    ends = ends.reshape(members.shape)
    index_of_lowest_member = np.argmin(sse.reshape(search_count, member_count), axis=1)
    return [
        converge(problem, ends[search_index, member_index])
        for search_index, member_index in enumerate(index_of_lowest_member)
    ]


def _evolved_members(
    problem: Problem, settings: FitSettings, random: np.random.Generator
) -> FloatArray:
    """Members of one search's last population, evenly spread over the ranks of their errors.

    Returns:
        Free internal constants, shape (polished, free).

    Reference: R. Storn, K. Price, J. Glob. Optim. 11 (1997) 341, DE/rand/1/bin.
    """
    low, high = problem.free_bounds.T
    # far below its smallest start a constant has no effect on the residuals
    smallest_start = np.array([constant.smallest_start for constant in problem.law.constants])
    low = np.maximum(low, smallest_start[problem.is_free])
    member_count = max(settings.population, _FEWEST_MEMBERS_PER_CONSTANT * len(low))

    # SciPy's type hints have no vectorized function
    def sse_of_members(members: FloatArray) -> Any:
        """Sum of squares of each member; SciPy has one member per column."""
        return population_sse(problem, members.T)

    # SciPy imports `optimize` at its first use, so that only jobs that search wait for it
    result = scipy.optimize.differential_evolution(
        sse_of_members,
        scipy.optimize.Bounds(low, high),
        strategy="rand1bin",
        popsize=math.ceil(member_count / len(low)),
        maxiter=settings.generations,
        tol=0,  # all generations
        mutation=_MUTATION,
        recombination=_RECOMBINATION,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=random,
    )
    # so many members are the starts of descents in `search`
    ranks = np.linspace(0, len(result.population) - 1, settings.polished).astype(int)
    members_by_rank = np.argsort(result.population_energies, kind="stable")
    return np.asarray(result.population[members_by_rank[ranks]])


def is_at_bound(problem: Problem, constants: FloatArray) -> BoolArray:
    """Whether each free constant is at a bound of the search, shape (..., free)."""
    low, high = problem.free_bounds.T
    margin = _AT_BOUND_SHARE * (high - low)
    return np.asarray((constants <= low + margin) | (constants >= high - margin))


def converge(problem: Problem, start: FloatArray) -> Optimum:
    """The local optimum that descents from `start` reach, to the last digits, within the bounds.

    A constant that starts at a bound stays there.

    Args:
        problem: What to fit.
        start: Free internal constants to start from, shape (free,).
    """
    low, high = problem.free_bounds.T
    ends = np.clip(start, low, high)[np.newaxis]
    # from a rough start Newton's method may run off along a valley without a floor
    ends, _ = descend(
        problem,
        ends,
        is_held=is_at_bound(problem, ends),
        tolerance=_NEWTON_TOLERANCE,
        use_newton=False,
    )
    # Newton's last step is damped, and its remaining error depends on the start. A second descent
    # from its end leaves rounding only.
    for _ in range(2):
        is_held = is_at_bound(problem, ends)
        ends, sse = descend(
            problem, ends, is_held=is_held, tolerance=_LAST_DIGITS_TOLERANCE, use_newton=True
        )
    return Optimum(ends[0], float(sse[0]))


def population_sse(problem: Problem, population: FloatArray) -> FloatArray:
    """Sum of squared errors of each member, shape (k,); infinite where mu has no value.

    Args:
        problem: What to fit.
        population: Free internal constants of the members, shape (k, free).
    """
    with np.errstate(over="ignore", invalid="ignore"):
        mu = problem.law.traction(problem.expand(population.T), problem.observations)
        sse = np.square(mu - problem.mu[:, np.newaxis]).sum(axis=0)
    return np.where(np.isnan(sse), np.inf, sse)
