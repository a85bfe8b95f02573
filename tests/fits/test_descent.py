"""Many descents at once: each must end where SciPy's own solver ends alone."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from campaigns import printed
from fit_points import LAW, make_points, matrix, polished, problem_of
from law_points import EVERY_LAW, PLAUSIBLE_CONSTANTS, points_of
from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.descent import descend
from oilfilm.fits.global_search import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.fits.uncertainty import curve_bootstrap, draw_curves
from oilfilm.traction.law import to_internal


def refit(
    problem: Problem, start: FloatArray, weights: FloatArray, tolerance: float = 1e-9
) -> tuple[FloatArray, FloatArray]:
    """Newton's method from one start, with other weights of the curves in each refit."""
    starts = np.tile(start, (len(weights), 1))
    return descend(problem, starts, weights=weights, tolerance=tolerance, use_newton=True)


@pytest.fixture(scope="module")
def task() -> Problem:
    return problem_of(make_points("4050", matrix(us=[25.0, 40.0]), noise=2e-4))


def fitted(name: str, noise: float = 2e-4) -> tuple[Problem, Optimum]:
    """A law fitted to noisy points of its own."""
    return polished(points_of(EVERY_LAW[name], noise), PLAUSIBLE_CONSTANTS[name], EVERY_LAW[name])


def scipy_end(
    task: Problem, start: FloatArray, copies: IndexArray | None = None, method: str = "lm"
) -> tuple[FloatArray, float]:
    """Constants and SSE of SciPy's fit to as many copies of each curve; "trf" knows the bounds."""
    curves = np.repeat(np.arange(task.curve_count), 1 if copies is None else copies)
    points = np.concatenate(
        [np.flatnonzero(task.observations.curve_of_point == curve) for curve in curves]
    )
    end = least_squares(
        lambda values: task.residual(values)[points],
        start,
        lambda values: task.jacobian(values)[points],
        bounds=tuple(task.free_bounds.T) if method == "trf" else (-np.inf, np.inf),
        method=method,
        x_scale="jac",
        xtol=1e-14,
        ftol=1e-14,
    )
    return end.x, 2 * end.cost


def test_descents_from_many_starts_end_where_scipy_ends(task: Problem) -> None:
    truth = to_internal(LAW, printed()["4050"])
    starts = truth + 0.3 * generator(1, "starts").standard_normal((40, 12))
    ends, sse = descend(task, starts, tolerance=1e-12)
    best, least = scipy_end(task, truth)
    # a wild start may fall into another valley
    at_best = sse < 1.001 * least
    assert at_best.mean() > 0.8
    np.testing.assert_allclose(sse[at_best], least, rtol=1e-9)
    np.testing.assert_allclose(ends[at_best], np.tile(best, (at_best.sum(), 1)), atol=1e-4)


@pytest.mark.parametrize("name", EVERY_LAW)
def test_polish_ends_where_no_step_is_left(name: str) -> None:
    """The residual is orthogonal to every slope, as at a minimum of a sum of squares."""
    problem, best = fitted(name)
    jacobian, residual = problem.jacobian(best.constants), problem.residual(best.constants)
    orthonormal, _ = np.linalg.qr(jacobian)
    assert np.linalg.norm(orthonormal.T @ residual) < 1e-9 * np.linalg.norm(residual)


@pytest.mark.parametrize("name", EVERY_LAW)
def test_resampled_refits_end_where_scipy_ends(name: str) -> None:
    """A thousandth of a standard error is far below any digit that is reported of it."""
    problem, best = fitted(name)
    refits = curve_bootstrap(problem, best, 12, generator(3, "refits"))
    draws = draw_curves(problem.observations.design, 12, generator(3, "refits"))
    expected = [scipy_end(problem, best.constants, draw)[0] for draw in draws]
    apart = np.abs(refits - expected) / np.std(refits, axis=0)
    assert apart.max() < 1e-3


def test_refits_that_leave_a_bound_end_where_scipy_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """A critical load far below all loads: some resamples say nothing of it."""
    weak = [*PLAUSIBLE_CONSTANTS["wang-deng-load"], 0.01, -1.0, 0.0, 0.0]
    monkeypatch.setitem(PLAUSIBLE_CONSTANTS, "wang-deng-critical-load", weak)
    problem, best = fitted("wang-deng-critical-load", 1e-3)
    draws = draw_curves(problem.observations.design, 12, generator(3, "refits"))
    ends, sse = refit(problem, best.constants, draws.astype(float))
    expected = [scipy_end(problem, best.constants, draw, "trf")[1] for draw in draws]
    np.testing.assert_allclose(sse, expected, rtol=1e-8)
    at_bound = ends[:, -1] == problem.free_bounds[-1, 0]
    assert 0 < at_bound.sum() < len(ends)


@pytest.mark.parametrize("name", ["deng2026", "eyring"])
def test_bytes_of_a_refit_do_not_depend_on_the_others(name: str) -> None:
    problem, best = fitted(name)
    weights = draw_curves(problem.observations.design, 30, generator(4, "refits")).astype(float)
    together = refit(problem, best.constants, weights)
    for size in (1, 7, 29):
        parts = [
            refit(problem, best.constants, weights[first : first + size])
            for first in range(0, len(weights), size)
        ]
        for whole, split in zip(together, zip(*parts, strict=True), strict=True):
            assert whole.tobytes() == np.concatenate(split).tobytes()


def test_held_constants_stay_and_the_others_reach_their_best(task: Problem) -> None:
    start = to_internal(LAW, printed()["4050"])
    held = np.zeros((12, 12), dtype=bool)
    np.fill_diagonal(held, True)
    starts = start + 0.05 * np.eye(12)
    ends, sse = descend(task, starts, is_held=held, tolerance=1e-13)
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
