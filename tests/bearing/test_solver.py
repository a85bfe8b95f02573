"""Roots near the roots of similar equations, against planted roots."""

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.bearing.solver import inverse_jacobian, solve_near

POINTS, UNKNOWNS = 4000, 7
# Effect of the weakest combination of the unknowns, over that of the strongest, as beside a fold.
WEAKEST = 1e-3


def test_a_root_stays_where_it_is_in_a_second_search() -> None:
    # the residuals of a root are rounding and must not give a direction
    random = np.random.default_rng(1)
    root = random.uniform(0.5, 2.0, (POINTS, UNKNOWNS))
    stiffness = np.eye(UNKNOWNS) + random.uniform(-1, 1, (POINTS, UNKNOWNS, UNKNOWNS))
    left, size, right = np.linalg.svd(stiffness)
    size[:, -1] = WEAKEST * size[:, 0]
    stiffness = left @ (size[:, :, np.newaxis] * right)
    load = np.einsum("pij,pj->pi", stiffness, root**3)

    def equations(unknowns: FloatArray, which: IndexArray) -> FloatArray:
        return load[which] - np.einsum("pij,...pj->...pi", stiffness[which], unknowns**3)

    scale = np.ones_like(root)
    inverse = inverse_jacobian(equations, root, scale)
    current = root * (1 + random.uniform(-1e-6, 1e-6, root.shape))
    for _ in range(4):
        solution = solve_near(equations, current, scale, inverse)
        current = solution.unknowns
        assert solution.converged.all()
        # loads of some 10 are rounded to 2e-15
        np.testing.assert_allclose(current, root, rtol=1e-14 / WEAKEST)


def test_a_point_is_judged_where_its_last_step_ended() -> None:
    # a triple root draws the steps in slowly: no step of the search ends at it
    start = np.linspace(0.5, 1.5, 9)[:, np.newaxis]

    def equations(unknowns: FloatArray, which: IndexArray) -> FloatArray:
        return -(unknowns**3)

    scale = np.ones_like(start)
    solution = solve_near(equations, start, scale, inverse_jacobian(equations, start, scale))
    np.testing.assert_array_equal(solution.residual, np.abs(solution.unknowns[:, 0]) ** 3)
    assert (solution.converged == (solution.residual <= 1e-10)).all()
