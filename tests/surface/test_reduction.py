"""Tests of `oilfilm.surface.reduction`."""

import numpy as np

from oilfilm.surface.kernels import matern
from oilfilm.surface.reduction import slip_nodes


def test_nodes_that_replace_many_slips_keep_polynomials_and_correlations() -> None:
    random = np.random.default_rng(3)
    scaled = np.sort(random.uniform(0.5, 5.3, 400))
    nodes, weights = slip_nodes(scaled)
    assert len(nodes) < len(scaled)
    for degree in range(4):
        np.testing.assert_allclose(weights @ nodes**degree, scaled**degree, rtol=1e-11)
    exact = matern(np.subtract.outer(scaled, scaled) / 1.5)
    by_nodes = weights @ matern(np.subtract.outer(nodes, nodes) / 1.5) @ weights.T
    np.testing.assert_allclose(by_nodes, exact, atol=2e-6)


def test_shared_slips_are_their_own_nodes() -> None:
    slips = np.tile([0.5, 1.0, 2.0], 40)
    nodes, weights = slip_nodes(slips)
    np.testing.assert_array_equal(nodes, [0.5, 1.0, 2.0])
    np.testing.assert_array_equal(weights @ nodes, slips)
