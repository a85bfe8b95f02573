"""Many descents at once: each must end where SciPy's own solver ends alone."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from campaigns import printed
from fit_points import LAW, make_points, matrix, problem_of
from oilfilm.fitting.descent import descend
from oilfilm.fitting.engine import polish
from oilfilm.fitting.problem import Problem
from oilfilm.randomness import generator
from oilfilm.traction.law import to_internal


@pytest.fixture(scope="module")
def task() -> Problem:
    return problem_of(make_points("4050", matrix(us=[25.0, 40.0]), noise=2e-4))[0]


def test_descents_from_many_starts_end_where_scipy_ends(task: Problem) -> None:
    truth = to_internal(LAW, printed()["4050"])
    random = generator(1, "starts")
    starts = truth + 0.3 * random.standard_normal((40, 12))
    ends, sse = descend(task, starts, tolerance=1e-12)
    alone = [polish(task, start) for start in starts]
    # a wild start may fall into another valley by another path; what both reach is the same
    reached = np.array([end.sse for end in alone]) < 1.001 * sse
    assert reached.mean() > 0.9
    best = min(alone, key=lambda end: end.sse)
    at_best = sse < 1.001 * best.sse
    assert at_best.mean() > 0.8
    np.testing.assert_allclose(sse[at_best], best.sse, rtol=1e-9)
    np.testing.assert_allclose(ends[at_best], np.tile(best.values, (at_best.sum(), 1)), atol=1e-4)


def test_weight_of_a_curve_is_that_many_copies_of_it(task: Problem) -> None:
    random = generator(2, "weights")
    copies = random.integers(0, 3, (5, task.curves))
    start = to_internal(LAW, printed()["4050"])
    ends, sse = descend(task, np.tile(start, (5, 1)), copies.astype(float), tolerance=1e-13)
    for end, total, counts in zip(ends, sse, copies, strict=True):
        points = np.concatenate(
            [
                np.flatnonzero(task.at.curve == curve)
                for curve in np.repeat(np.arange(len(counts)), counts)
            ]
        )
        expected = least_squares(
            lambda values, points=points: task.residual(values)[points],
            start,
            lambda values, points=points: task.jacobian(values)[points],
            method="lm",
            xtol=1e-14,
            ftol=1e-14,
        )
        assert total == pytest.approx(2 * expected.cost, rel=1e-9)
        np.testing.assert_allclose(end, expected.x, atol=1e-5)


def test_held_constants_stay_and_the_others_reach_their_best(task: Problem) -> None:
    start = to_internal(LAW, printed()["4050"])
    held = np.zeros((12, 12), dtype=bool)
    np.fill_diagonal(held, True)
    starts = start + 0.05 * np.eye(12)
    ends, sse = descend(task, starts, held=held, tolerance=1e-13)
    np.testing.assert_array_equal(ends[held], starts[held])
    for index in (0, 5, 11):
        free = np.arange(12) != index

        def residual(values: np.ndarray, index: int = index, free: np.ndarray = free) -> np.ndarray:
            all_values = starts[index].copy()
            all_values[free] = values
            return task.residual(all_values)

        expected = least_squares(residual, starts[index][free], method="lm", xtol=1e-13, ftol=1e-13)
        assert sse[index] == pytest.approx(2 * expected.cost, rel=1e-7)


def test_start_where_the_law_overflows_does_no_harm_to_the_others(task: Problem) -> None:
    good = to_internal(LAW, printed()["4050"])
    wild = np.full(12, 400.0)
    ends, sse = descend(task, np.array([wild, good, good]))
    assert np.isfinite(sse[1:]).all()
    np.testing.assert_allclose(ends[1], ends[2], rtol=1e-10)
    assert not np.isfinite(sse[0]) or sse[0] > sse[1]
