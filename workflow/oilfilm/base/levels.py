"""Measured values that stand for one level of a condition.

Decides: which of many measured values are one level.
"""

import numpy as np

from oilfilm.base.ties import exceeds
from oilfilm.base.units import FloatArray, IndexArray


def cluster_indices(values: FloatArray, width: float) -> IndexArray:
    """Index of the cluster of each value; no cluster is wider than `width`.

    Clusters are counted from 1, from the lowest values to the highest. Index 0 is for NaN only.
    A cluster begins at the lowest value that no other cluster holds, so that the order of the
    values does not matter.

    Args:
        values: Any values, shape (rows,); NaN where a value is not known.
        width: Largest difference of two values of one cluster.

    Examples:
        >>> cluster_indices(np.array([0.101, 0.02, 0.099, 0.021, np.nan]), 0.006)
        array([2, 1, 2, 1, 0])
    """
    cluster_of_row = np.zeros(len(values), dtype=np.int64)
    cluster_index = 0
    lowest_of_cluster = -np.inf
    known_rows = np.flatnonzero(~np.isnan(values))
    for row in known_rows[np.argsort(values[known_rows], kind="stable")]:
        if exceeds(values[row] - lowest_of_cluster, width):
            cluster_index += 1
            lowest_of_cluster = values[row]
        cluster_of_row[row] = cluster_index
    return cluster_of_row
