"""Roots of many equations near known ones, against roots that are planted."""

import numpy as np

from oilfilm.bearing.solver import inverse_jacobian, near
from oilfilm.units import FloatArray, IndexArray

POINTS, UNKNOWNS = 400, 7


def test_roots_are_found_near_others_and_stay_where_they_are_found() -> None:
    # at a root nothing but rounding is left over: it must give no direction of a step
    random = np.random.default_rng(1)
    root = random.uniform(0.5, 2.0, (POINTS, UNKNOWNS))
    stiffness = np.eye(UNKNOWNS) + random.uniform(-0.3, 0.3, (POINTS, UNKNOWNS, UNKNOWNS))

    def equations(unknowns: FloatArray, which: IndexArray) -> FloatArray:
        distance = unknowns**3 - root[which] ** 3
        return -np.einsum("pij,...pj->...pi", stiffness[which], distance)

    scale = np.ones_like(root)
    inverse = inverse_jacobian(equations, root, scale)
    found = near(equations, root * (1 + random.uniform(-1e-3, 1e-3, root.shape)), scale, inverse)
    again = near(equations, found.unknowns, scale, inverse)
    assert found.converged.all()
    np.testing.assert_allclose(found.unknowns, root, rtol=1e-12)
    np.testing.assert_array_equal(again.unknowns, found.unknowns)
