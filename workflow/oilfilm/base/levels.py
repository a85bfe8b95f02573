"""Measured values that stand for one level of a condition.

Decides: which of many measured values are one level.
"""

import numpy as np

from oilfilm.base.ties import exceeds
from oilfilm.base.units import FloatArray, IndexArray


def clusters(values: FloatArray, width: float) -> IndexArray:
    """Clusters of values no wider than `width`, counted from 0.

    A cluster begins at the lowest value that no other cluster holds, so that the order of the
    values does not matter. Unknown values are the cluster 0, whether there are some or not.

    Args:
        values: Any values, shape (rows,).
        width: Largest difference of two values of one cluster.

    Examples:
        >>> clusters(np.array([0.101, 0.02, 0.099, 0.021, np.nan]), 0.006)
        array([2, 1, 2, 1, 0])
    """
    cluster = np.zeros(len(values), dtype=np.int64)
    cluster_number = 0
    smallest_of_cluster = -np.inf
    measured_rows = np.flatnonzero(~np.isnan(values))
    for row in measured_rows[np.argsort(values[measured_rows], kind="stable")]:
        if exceeds(values[row] - smallest_of_cluster, width):
            cluster_number += 1
            smallest_of_cluster = values[row]
        cluster[row] = cluster_number
    return cluster
