"""Levenberg-Marquardt on many starts at once, for searches, resampled curves and profiles.

All of them are descents of one sum of squares from many starts, or with other weights of the
curves, or with a constant held. Taken together they cost a fraction of as many calls of SciPy:
the law is evaluated for all of them in one array, and because a law's coefficients are power laws
of a curve's condition, the normal equations are sums over curves of small products.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.fitting.problem import Problem
from oilfilm.traction.law import BoolArray, FloatArray, IndexArray

# Points times descents evaluated at once: about what fits a processor's cache.
_CHUNK = 1 << 14
_MAX_STEPS = 300
_FIRST_DAMPING = 1e-2
# Keeps a singular matrix solvable; far below what slows a regular one down.
_LEAST_DAMPING = 1e-12
# Damped to this, a step is nothing: the descent stands.
_STUCK_DAMPING = 1e12


@dataclass(frozen=True)
class _Normal:
    """SSE (k,), its half gradient (k, n) and J^T J (k, n, n) of k descents."""

    sse: FloatArray
    gradient: FloatArray
    matrix: FloatArray

    def update(self, which: IndexArray, by: "_Normal") -> None:
        self.sse[which] = by.sse
        self.gradient[which] = by.gradient
        self.matrix[which] = by.matrix


def descend(
    problem: Problem,
    starts: FloatArray,
    weights: FloatArray | None = None,
    held: BoolArray | None = None,
    tolerance: float = 1e-9,
) -> tuple[FloatArray, FloatArray]:
    """The local optima next to each start, within the law's bounds.

    Where constants leave their bounds, the one farthest out is put back on its bound and stays
    there, and the others descend again from within theirs.

    Args:
        problem: What to fit.
        starts: Free internal constants, shape (descents, free).
        weights: Weight of each curve's squared errors in each descent, shape (descents, curves);
            1 if not given.
        held: True where a constant stays at its start, shape (descents, free).
        tolerance: Relative decrease of the SSE, expected and found, at which a descent ends.

    Returns:
        The ends, shape (descents, free), and the (weighted) SSE there, shape (descents,).

    Reference: H. B. Nielsen, Damping Parameter in Marquardt's Method, IMM-REP-1999-05, Technical
    University of Denmark (1999).
    """
    weights = np.ones((len(starts), problem.curves)) if weights is None else weights
    held = np.zeros(starts.shape, dtype=bool) if held is None else held
    ends, sse = _descend_all(problem, starts, weights, held, tolerance)
    low, high = problem.limits.T
    while True:
        outside = ~held * problem.beyond(ends)
        rows = outside.any(axis=1)
        if not rows.any():
            return ends, sse
        held = held | (outside > 0) & (outside == outside.max(axis=1, keepdims=True))
        inside = np.where(outside > 0, np.clip(ends, low, high), ends)
        ends[rows], sse[rows] = _descend_all(
            problem, inside[rows], weights[rows], held[rows], tolerance
        )


def _descend_all(
    problem: Problem, starts: FloatArray, weights: FloatArray, held: BoolArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    step = max(_CHUNK // max(len(problem.mu), 1), 1)
    ends: FloatArray = np.empty_like(starts)
    sse: FloatArray = np.empty(len(starts))
    for first in range(0, len(starts), step):
        rows = slice(first, first + step)
        ends[rows], sse[rows] = _descend(
            problem, starts[rows].copy(), weights[rows], held[rows], tolerance
        )
    return ends, sse


def _descend(
    problem: Problem, values: FloatArray, weights: FloatArray, held: BoolArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    now = _normal_equations(problem, values, weights, held)
    damping: FloatArray
    damping, growth = np.full(len(values), _FIRST_DAMPING), np.full(len(values), 2.0)
    going = np.arange(len(values))
    tiny = np.finfo(float).tiny
    for _ in range(_MAX_STEPS):
        step, expected = _steps(now, damping, going)
        trial = values[going] + step
        then = _normal_equations(problem, trial, weights[going], held[going])
        better = then.sse < now.sse[going]
        # from where the law overflows any step is a gain without measure
        with np.errstate(over="ignore", invalid="ignore"):
            gain = (now.sse[going] - then.sse) / np.maximum(expected, tiny)
        # a step damped short promises little and proves nothing
        ended = (expected <= tolerance * now.sse[going]) & (damping[going] <= 1)
        easing = np.maximum(1 / 3, 1 - (2 * np.clip(gain, 0, 2) - 1) ** 3)
        damping[going] *= np.where(better, easing, growth[going])
        np.maximum(damping, _LEAST_DAMPING, out=damping)
        growth[going] = np.where(better, 2.0, 2 * growth[going])
        taken = going[better]
        values[taken] = trial[better]
        now.update(taken, _Normal(then.sse[better], then.gradient[better], then.matrix[better]))
        going = going[~ended & (damping[going] < _STUCK_DAMPING)]
        if not len(going):
            break
    return values, now.sse


def _steps(now: _Normal, damping: FloatArray, going: IndexArray) -> tuple[FloatArray, FloatArray]:
    """Damped steps and the decrease of the SSE that the quadratic model expects of them."""
    matrix, gradient = now.matrix[going], now.gradient[going]
    size = np.sqrt(np.einsum("kii->ki", matrix))
    # a constant without effect has no scale of its own
    size = np.where(size > 0, size, 1.0)
    scaled = matrix / (size[:, :, np.newaxis] * size[:, np.newaxis, :])
    slope = gradient / size
    damped = scaled + damping[going, np.newaxis, np.newaxis] * np.eye(matrix.shape[1])
    step = np.linalg.solve(damped, -slope[:, :, np.newaxis])[:, :, 0]
    expected = np.sum(step * (damping[going, np.newaxis] * step - slope), axis=1)
    return np.asarray(step / size), np.asarray(expected)


def _normal_equations(
    problem: Problem, values: FloatArray, weights: FloatArray, held: BoolArray
) -> _Normal:
    """Normal equations at the values of each descent.

    d mu / d(X0, X1, ...) of a coefficient X is (d mu / d ln X) times the curve's row of the
    design, so that sums over points end within a curve.
    """
    law, at, free = problem.law, problem.at, problem.free
    count, terms = len(values), at.design.shape[1]
    slip = at.slip[:, np.newaxis]
    products = (at.design[:, :, np.newaxis] * at.design[:, np.newaxis, :]).reshape(-1, terms**2)

    def total(of_points: FloatArray, rows: FloatArray) -> FloatArray:
        """Weighted sum over points of a quantity times its curve's row: (descents, row)."""
        by_curve = np.add.reduceat(of_points, problem.starts, axis=0)
        return np.asarray((weights.T * by_curve).T @ rows)

    gradient = np.empty((count, len(law.coefficients), terms))
    matrix = np.empty((count, len(law.coefficients), terms, len(law.coefficients), terms))
    # a trial step may run off to where the law overflows; it is then not taken
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        sizes = law.sizes(problem.expand(values.T), at.design)[:, at.curve]
        mu, slopes = law.value_and_slopes(sizes, slip)
        residual = mu - problem.mu[:, np.newaxis]
        sse = total(residual**2, np.ones((problem.curves, 1)))[:, 0]
        for i, first in enumerate(slopes):
            gradient[:, i] = total(first * residual, at.design)
            for j, second in enumerate(slopes[: i + 1]):
                block = total(first * second, products).reshape(count, terms, terms)
                matrix[:, i, :, j, :] = matrix[:, j, :, i, :] = block
    gradient = gradient.reshape(count, len(free))[:, free]
    matrix = matrix.reshape(count, len(free), len(free))[:, free][:, :, free]
    moving = ~held
    pairs = moving[:, :, np.newaxis] & moving[:, np.newaxis, :]
    lost = ~(np.isfinite(sse) & np.isfinite(matrix).all(axis=(1, 2)))
    return _Normal(
        np.where(lost, np.inf, sse),
        np.where(moving, gradient, 0.0),
        np.where(pairs, matrix, np.eye(matrix.shape[1])),
    )
