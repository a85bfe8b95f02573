"""Measured values that stand for one level of a condition.

Decides: which of many measured values are one level.
"""

import numpy as np

from oilfilm.base.ties import exceeds
from oilfilm.base.units import FloatArray, IndexArray


def level_indices(values: FloatArray, width: float) -> IndexArray:
    """Index of the level of each value; the values of no level differ by more than `width`.

    Levels are counted from 1, from the lowest values to the highest. Index 0 is for NaN only.
    A level begins at the lowest value that no other level holds, so that the order of the
    values does not matter. Infinite values are levels of their own.

    Args:
        values: Any values, shape (rows,); NaN where a value is not known.
        width: Largest difference of two values of one level.

    Examples:
        >>> level_indices(np.array([0.101, 0.02, 0.099, 0.021, np.nan]), 0.006)
        array([2, 1, 2, 1, 0])
    """
    level_of_row = np.zeros(len(values), dtype=np.int64)
    level_index = 0
    lowest_of_level = np.nan
    known_rows = np.flatnonzero(~np.isnan(values))
    for row in known_rows[np.argsort(values[known_rows], kind="stable")]:
        value = values[row]
        # two equal infinite values have no difference
        is_new_level = value != lowest_of_level and (
            # the plain comparison is quicker, and no smaller difference is a new level
            value - lowest_of_level > width and exceeds(value - lowest_of_level, width)
        )
        if level_index == 0 or is_new_level:
            level_index += 1
            lowest_of_level = value
        level_of_row[row] = level_index
    return level_of_row
