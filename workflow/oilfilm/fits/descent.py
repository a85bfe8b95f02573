"""Levenberg-Marquardt on many starts at once, for searches, resampled curves and profiles.

All of them are descents of one sum of squares from many starts, or with other weights of the
curves, or with a constant held. Taken together they cost a fraction of as many calls of SciPy:
the law is evaluated for all of them in one array, and because a law's coefficients are power laws
of a curve's condition, the normal equations are sums over curves of small products. Refits to
resampled curves start near their ends: there Newton's method, with the second derivatives of the
law, needs 3 to 7 steps where J^T J alone needs 5 to 50. A constant X0 in which mu is linear takes
Newton's step in X0 itself, not in ln|X0|: where the data hardly know X0, that saves half the steps.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.problem import Problem

# Points times descents whose sums are kept at once, and those of them that are evaluated at once:
# about what fits a processor's cache.
_CHUNK = 1 << 17
_BLOCK = 1 << 13
# Curves whose sums BLAS adds at once: too few for it to take a second thread.
_CURVES = 1 << 9
_FIRST_DAMPING = 1e-2
# Of a start near its end: the first step is almost that of Newton; where it is refused, damping
# must soon be felt.
_FIRST_DAMPING_NEAR = 1e-5
_GROWTH, _GROWTH_NEAR = 2.0, 16.0
# Steps outside the bounds, each farther than the one before, after which a refit has left them.
_LEFT = 3
# The most that Newton's method may take off a size at once, as a share of it.
_MOST_OFF = 0.9
# Keeps a singular matrix solvable; far below what slows a regular one down.
_LEAST_DAMPING = 1e-12
# glibc returns freed memory to the system and asks for it again, 15 % of the time of a fit. Once an
# array of so many numbers is dropped it keeps that much.
np.empty(1 << 21)
# Damped to this, a step is nothing: the descent stands.
_STUCK_DAMPING = 1e12


@dataclass(frozen=True)
class _Normal:
    """SSE (k,), its half gradient (k, n) and J^T J or half Hessian (k, n, n) of k descents."""

    sse: FloatArray
    gradient: FloatArray
    matrix: FloatArray


def descend(
    problem: Problem,
    starts: FloatArray,
    *,
    weights: FloatArray | None = None,
    held: BoolArray | None = None,
    tolerance: float = 1e-9,
    near: bool = False,
    most_steps: int = 300,
) -> tuple[FloatArray, FloatArray]:
    """The local optima next to each start, within the law's bounds.

    Where constants leave their bounds, the one farthest out is put back on its bound and stays
    there, and the others descend again from within theirs.

    Args:
        problem: What to fit.
        starts: Free internal constants, shape (descents, free).
        weights: Weight of each curve's squared errors, shape (descents, curves); 1 if not given.
        held: True where a constant stays at its start, shape (descents, free).
        tolerance: Relative decrease of the SSE, expected and found, at which a descent ends.
        near: The starts are near their ends: by Newton's method.
        most_steps: After which a descent ends where it is.

    Returns:
        The ends, shape (descents, free), and the weighted SSE there, shape (descents,).

    Reference: H. B. Nielsen, Damping Parameter in Marquardt's Method, IMM-REP-1999-05, Technical
    University of Denmark (1999).
    """
    if not len(starts):
        return starts, np.empty(0)
    weights = np.ones((len(starts), problem.curves)) if weights is None else weights
    held = np.zeros(starts.shape, dtype=bool) if held is None else held
    descents = _Descents(problem, weights, held, tolerance, near, most_steps)
    ends, sse = _descend(descents, starts.copy())
    low, high = problem.limits.T
    while True:
        outside = ~held * problem.beyond(ends)
        rows = np.flatnonzero(outside.any(axis=1))
        if not len(rows):
            return ends, sse
        held = held | (outside > 0) & (outside == outside.max(axis=1, keepdims=True))
        inside = np.where(outside > 0, np.clip(ends, low, high), ends)
        ends[rows], sse[rows] = _descend(replace(descents, held=held).of(rows), inside[rows])


@dataclass(frozen=True)
class _Descents:
    """What to descend on.

    Attributes:
        problem: What to fit.
        weights: Weight of each curve's squared errors in each descent, shape (descents, curves).
        held: True where a constant stays at its start, shape (descents, free).
        tolerance: As of `descend`.
        near: The starts are near their ends, where second derivatives of the law help.
        most_steps: As of `descend`.
    """

    problem: Problem
    weights: FloatArray
    held: BoolArray
    tolerance: float
    near: bool
    most_steps: int

    def of(self, rows: IndexArray) -> "_Descents":
        """Some of them."""
        return replace(self, weights=self.weights[rows], held=self.held[rows])

    def outside(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """How far some of them are outside the bounds of what moves, 0 within."""
        beyond = ~self.held[rows] * self.problem.beyond(values)
        return np.asarray(beyond.max(axis=1, initial=0.0))


def _descend(descents: _Descents, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    now = _normal_equations(descents, values)
    damping: FloatArray
    first, least_growth = (
        (_FIRST_DAMPING_NEAR, _GROWTH_NEAR) if descents.near else (_FIRST_DAMPING, _GROWTH)
    )
    damping, growth = np.full(len(values), first), np.full(len(values), least_growth)
    going = np.arange(len(values))
    outside, farther = descents.outside(going, values), np.zeros(len(values), dtype=int)
    tiny = np.finfo(float).tiny
    linear = descents.problem.linear & descents.near
    for _ in range(descents.most_steps):
        step, expected = _steps(now, damping, going, linear)
        # a step damped short promises little and proves nothing, nor does one towards a saddle
        small = (expected >= 0) & (expected <= descents.tolerance * now.sse[going])
        ended: BoolArray = small & (damping[going] <= 1)
        if descents.near:
            # Newton's last step needs no proof: what it leaves over is its square
            values[going[ended]] += step[ended]
            now.sse[going[ended]] -= expected[ended]
            step, expected, going = step[~ended], expected[~ended], going[~ended]
            ended = ended[~ended]
            if not len(going):
                break
        trial = values[going] + step
        then = _normal_equations(descents.of(going), trial)
        better = then.sse < now.sse[going]
        # from where the law overflows any step is a gain without measure
        with np.errstate(over="ignore", invalid="ignore"):
            gain = (now.sse[going] - then.sse) / np.maximum(expected, tiny)
        easing = np.maximum(1 / 3, 1 - (2 * np.clip(gain, 0, 2) - 1) ** 3)
        damping[going] *= np.where(better, easing, growth[going])
        np.maximum(damping, _LEAST_DAMPING, out=damping)
        growth[going] = np.where(better, least_growth, 2 * growth[going])
        taken = going[better]
        values[taken] = trial[better]
        beyond = descents.outside(taken, values[taken])
        farther[taken] = np.where(beyond > outside[taken], farther[taken] + 1, 0)
        outside[taken] = beyond
        for kept, new in zip(vars(now).values(), vars(then).values(), strict=True):
            kept[taken] = new[better]
        # what runs off does so for many steps: it ends at a bound
        ended |= (farther[going] >= _LEFT) & descents.near
        going = going[~ended & (damping[going] < _STUCK_DAMPING)]
        if not len(going):
            break
    return values, now.sse


def _steps(
    now: _Normal, damping: FloatArray, going: IndexArray, linear: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Damped steps and the decrease of the SSE that the quadratic model expects of them.

    A `linear` constant is ln|X0| with mu linear in X0: its step is that of Newton's method in X0.
    """
    matrix, gradient = now.matrix[going], now.gradient[going]
    # X^2 f'' = d2f/d(ln X)2 - df/d(ln X)
    np.einsum("kii->ki", matrix)[:] -= np.where(linear, gradient, 0.0)
    # far from a minimum a second derivative may be negative
    size = np.sqrt(np.abs(np.einsum("kii->ki", matrix)))
    # a constant without effect has no scale of its own
    size = np.where(size > 0, size, 1.0)
    scaled = matrix / (size[:, :, np.newaxis] * size[:, np.newaxis, :])
    slope = gradient / size
    damped = scaled + damping[going, np.newaxis, np.newaxis] * np.eye(matrix.shape[1])
    step = np.linalg.solve(damped, -slope[:, :, np.newaxis])[:, :, 0]
    expected = np.sum(step * (damping[going, np.newaxis] * step - slope), axis=1)
    step = step / size
    step = np.where(linear, np.log1p(np.maximum(step, -_MOST_OFF)), step)
    return step, np.asarray(expected)


def _normal_equations(descents: _Descents, values: FloatArray) -> _Normal:
    """Normal equations at the values of each descent, with what is held left out."""
    problem, weights = descents.problem, descents.weights
    if (values == values[0]).all():
        # all at one start: sums over points are the same for all
        sse, gradient, matrix = _sums(problem, values[:1], weights, descents.near)
    else:
        step = max(_CHUNK // max(len(problem.mu), 1), 1)
        chunks = [slice(first, first + step) for first in range(0, len(values), step)]
        parts = [_sums(problem, values[rows], weights[rows], descents.near) for rows in chunks]
        sse, gradient, matrix = (np.concatenate(part) for part in zip(*parts, strict=True))
    moving = ~descents.held
    pairs = moving[:, :, np.newaxis] & moving[:, np.newaxis, :]
    lost = ~(np.isfinite(sse) & np.isfinite(matrix).all(axis=(1, 2)))
    return _Normal(
        np.where(lost, np.inf, sse),
        np.where(moving, gradient, 0.0),
        np.where(pairs, matrix, np.eye(matrix.shape[1])),
    )


def _sums(
    problem: Problem, values: FloatArray, weights: FloatArray, curved: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """SSE, half its gradient and J^T J, or half the Hessian, by all free constants.

    d mu / d(X0, X1, ...) of a coefficient X is (d mu / d ln X) times the curve's row of the
    design, so that sums over points end within a curve. Curves of weight 0 are not evaluated.

    Args:
        problem: What to fit.
        values: Free internal constants, shape (descents, free); one row if all have the same.
        weights: Weight of each curve's squared errors, shape (descents, curves).
        curved: Whether second derivatives of the law are included: the Hessian.
    """
    at, count, terms = problem.at, len(weights), problem.at.design.shape[1]
    of_coefficient = problem.free.reshape(-1, terms)
    followed = tuple(np.flatnonzero(of_coefficient.any(axis=1)).tolist())
    free, coefficients = of_coefficient[list(followed)].ravel(), len(followed)
    drawn = weights.any(axis=0, keepdims=True) if len(values) == 1 else weights > 0
    descent, curve = np.nonzero(drawn)
    by_curve = np.zeros((*drawn.shape, 1 + coefficients * (coefficients + 3) // 2))
    products = (at.design[:, :, np.newaxis] * at.design[:, np.newaxis, :]).reshape(-1, terms**2)
    # a trial step may run off to where the law overflows; it is then not taken
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        sizes = problem.law.sizes(problem.expand(values.T), at.design)[:, curve, descent]
        step = max(_BLOCK * problem.curves // max(len(problem.mu), 1), 1)
        blocks = [slice(first, first + step) for first in range(0, len(curve), step)]
        sums = [
            _sums_of_curves(problem, sizes[:, block], curve[block], followed, curved)
            for block in blocks
        ]
        by_curve[drawn] = np.concatenate(sums, axis=1).T
        # One product of small matrices after the other: its bytes do not depend on which other
        # descents there are, nor on the threads of BLAS. The first column of a design is 1.
        some_curves = [slice(first, first + _CURVES) for first in range(0, problem.curves, _CURVES)]
        totals = np.asarray(
            sum(
                (weights[:, some, np.newaxis] * by_curve[:, some]).swapaxes(1, 2) @ products[some]
                for some in some_curves
            )
        )
    gradient = totals[:, 1 : 1 + coefficients, :terms].reshape(count, len(free))[:, free]
    of_pairs = totals[:, 1 + coefficients :].reshape(count, -1, terms, terms)
    matrix = np.empty((count, coefficients, terms, coefficients, terms))
    for pair, (i, j) in enumerate(_lower(coefficients)):
        matrix[:, i, :, j, :] = matrix[:, j, :, i, :] = of_pairs[:, pair]
    matrix = matrix.reshape(count, len(free), len(free))[:, free][:, :, free]
    return totals[:, 0, 0], gradient, matrix


def _sums_of_curves(
    problem: Problem, sizes: FloatArray, curve: IndexArray, followed: tuple[int, ...], curved: bool
) -> FloatArray:
    """Sums over the points of curves, by ln|X| of the coefficients X that have a free constant.

    Args:
        problem: What to fit.
        sizes: |X| of each coefficient, shape (coefficients, sums).
        curve: Curve of each sum.
        followed: Indices of the coefficients that have a free constant.
        curved: As of `_sums`.

    Returns:
        SSE, half its gradient and the lower triangle of J^T J or half the Hessian, one row each;
        shape (1 + n (n + 3) / 2, sums) of n followed coefficients.
    """
    law, at = problem.law, problem.at
    length = problem.lengths[curve]
    first_point = np.cumsum(length) - length
    point = np.arange(length.sum()) + np.repeat(problem.starts[curve] - first_point, length)
    sizes = np.repeat(sizes, length, axis=1)
    curvatures: tuple[FloatArray | float, ...] = ()
    if curved:
        mu, slopes, curvatures = law.value_slopes_and_curvatures(sizes, at.slip[point], followed)
    else:
        mu, slopes = law.value_and_slopes(sizes, at.slip[point])
        slopes = tuple(slopes[index] for index in followed)
    residual = mu - problem.mu[point]
    pairs = _lower(len(slopes))
    of_points = np.empty((1 + len(slopes) + len(pairs), len(point)))
    np.square(residual, out=of_points[0])
    for row, slope in enumerate(slopes, start=1):
        np.multiply(slope, residual, out=of_points[row])
    for row, (i, j) in enumerate(pairs, start=1 + len(slopes)):
        np.multiply(slopes[i], slopes[j], out=of_points[row])
    for row, curvature in enumerate(curvatures, start=1 + len(slopes)):
        # many are zero everywhere
        if np.ndim(curvature):
            of_points[row] += residual * curvature
    if problem.weight is not None:
        of_points *= problem.weight[point]
    return np.asarray(np.add.reduceat(of_points, first_point, axis=1))


def _lower(size: int) -> list[tuple[int, int]]:
    """Rows and columns of the lower triangle of a matrix, row by row."""
    return [(i, j) for i in range(size) for j in range(i + 1)]
