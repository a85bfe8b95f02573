"""The order of runs in time: whether it is that of a condition, and a random order.

A rig that drifts while the pressure rises from run to run is not distinguished from an oil whose
traction follows the pressure otherwise. `make bench NAME=run_plan` prints the smallest trend that
24 runs show, by their order.

Decides: when runs are in the order of a condition.
"""

import numpy as np

from oilfilm.base.randomness import generator
from oilfilm.base.ties import exceeds, first_smallest
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.surface.measurements import LevelWidths, level_numbers, scaled_conditions
from oilfilm.traction.law import CONDITIONS

# Runs in random order have a ratio of successive differences near 1. Below this limit the smallest
# trend that is seen is twice as large or larger. Of 1 000 random orders 1 is below it with 24 runs,
# 6 with 12 runs and 67 with 8 runs.
_LARGEST_ORDERED_RATIO = 0.3
# Few runs are in the order of a condition by chance.
_FEWEST_RUNS = 6
# Share of the variance of the position in time that is within repeated conditions. With more, the
# repeats show a trend: one repeat of the first of 24 runs at the end gives 0.22.
_LARGEST_REPEATED_SHARE = 0.15
# Random orders that are drawn, until one is not in the order of a condition.
_MOST_DRAWN_ORDERS = 50


def ordering_condition(conditions: FloatArray, level_widths: LevelWidths) -> str:
    """The condition in whose order the runs were made; empty if there is none.

    Runs of equal or similar levels follow each other then, and no condition was repeated later. The
    measure is the mean square of successive differences over twice the variance (J. von Neumann,
    Ann. Math. Stat. 12 (1941) 367), which has the mean 1 in random order.

    Args:
        conditions: P in GPa, U in m/s and T in degC of each run, in order of time, shape (runs, 3).
        level_widths: Largest range of the values of one level.

    Examples:
        >>> rising = np.array([(p, 30, t) for p in (1.0, 1.2, 1.5, 1.8) for t in (50, 90)])
        >>> ordering_condition(rising, LevelWidths())
        'max_hertz_pressure_gpa'
        >>> ordering_condition(rising[[5, 0, 3, 6, 1, 4, 7, 2]], LevelWidths())
        ''
    """
    if len(conditions) < _FEWEST_RUNS:
        return ""
    scaled = scaled_conditions(conditions)
    if exceeds(_share_within_conditions(scaled, level_widths), _LARGEST_REPEATED_SHARE):
        return ""
    difference_ratios = [
        _successive_difference_ratio(column, width)
        for column, width in zip(scaled.T, level_widths.scaled().tolist(), strict=True)
    ]
    condition_index = int(first_smallest(difference_ratios))
    return (
        CONDITIONS[condition_index]
        if exceeds(_LARGEST_ORDERED_RATIO, difference_ratios[condition_index])
        else ""
    )


def _successive_difference_ratio(scaled: FloatArray, level_width: float) -> float:
    """Sum of squares of successive differences over twice that about the mean.

    It is infinite for a condition that was not varied.
    """
    if np.ptp(scaled) <= level_width:
        return np.inf
    deviation = scaled - scaled.mean()
    return float(np.sum(np.diff(scaled) ** 2) / (2 * np.sum(deviation**2)))


def _share_within_conditions(scaled: FloatArray, level_widths: LevelWidths) -> float:
    """Share of the variance of the position in time that is among runs of one condition."""
    level_numbers_of_runs = level_numbers(scaled, level_widths)
    _, condition_of_run = np.unique(level_numbers_of_runs, axis=0, return_inverse=True)
    condition_of_run = condition_of_run.ravel()
    position = np.arange(len(scaled)) - (len(scaled) - 1) / 2
    mean_position = np.bincount(condition_of_run, position) / np.bincount(condition_of_run)
    sum_of_squares_within = np.sum((position - mean_position[condition_of_run]) ** 2)
    return float(sum_of_squares_within / np.sum(position**2))


def random_order(conditions: FloatArray, seed: int, level_widths: LevelWidths) -> IndexArray:
    """An order of runs that is not that of a condition, shape (runs,).

    It depends on the seed, the widths of levels, and the number and conditions of the runs only.

    Args:
        conditions: P, U and T of each run, sorted by value, shape (runs, 3).
        seed: Seed of the configuration.
        level_widths: Largest range of the values of one level.
    """
    random = generator(seed, "order of planned runs")
    for _ in range(_MOST_DRAWN_ORDERS):
        order = random.permutation(len(conditions))
        if not ordering_condition(conditions[order], level_widths):
            break
    return order
