"""Levenberg-Marquardt on many starts at once, for searches, resampled curves and profiles.

Each of these tasks is a set of descents of one sum of squares. The descents differ in their start,
in the weights of the curves, or in the constants that are held. The law is evaluated for all of
them in one array, which costs a fraction of as many calls of SciPy. A law's coefficients are power
laws of a curve's condition, so the normal equations are sums over curves of small products.

Refits to resampled curves start near their ends. There Newton's method, with the second
derivatives of the law, needs 3 to 7 steps where J^T J alone needs 5 to 50. For a constant X0 in
which mu is linear the step is that of Newton's method in X0, not in ln|X0|. This saves half the
steps where the data hardly determine X0.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.problem import Problem

# Points times descents whose sums are kept at once. The second number is that of points times
# descents that are evaluated at once: about what fits a processor's cache.
_POINTS_PER_CHUNK = 1 << 17
_POINTS_PER_BLOCK = 1 << 13
# Curves whose sums BLAS adds at once: too few for BLAS to start a second thread.
_CURVES_PER_PRODUCT = 1 << 9
# Damping of the first step. Near the end the first step is almost that of Newton's method.
_FIRST_DAMPING = 1e-2
_FIRST_DAMPING_NEAR = 1e-5
# Factor on the damping after a refused step. Near the end the damping is small at first and must
# rise fast.
_GROWTH = 2.0
_GROWTH_NEAR = 16.0
# A refit has left its bounds after this many steps outside, each farther than the one before.
_STEPS_OUTSIDE = 3
# Newton's method takes off at most this share of a size X0 in one step.
_LARGEST_DECREASE = 0.9
# Keeps a singular matrix solvable, and is too small to slow down a regular one.
_LEAST_DAMPING = 1e-12
# A step with this damping moves nothing: the descent is stuck.
_STUCK_DAMPING = 1e12
# glibc returns freed memory to the system and requests it again, which takes 15 % of the time of
# a fit. After an array of this many numbers was freed, glibc keeps that much memory.
np.empty(1 << 21)


@dataclass(frozen=True)
class _Normal:
    """Normal equations of k descents by n constants.

    Attributes:
        sse: Sum of squared errors, shape (k,).
        gradient: Half the gradient of the SSE, shape (k, n).
        matrix: J^T J or half the Hessian of the SSE, shape (k, n, n).
    """

    sse: FloatArray
    gradient: FloatArray
    matrix: FloatArray

    def update(self, rows: IndexArray, other: "_Normal", other_rows: BoolArray) -> None:
        """Overwrite some descents with those of other normal equations.

        Args:
            rows: The descents that are overwritten.
            other: Normal equations with the new values.
            other_rows: Which descents of `other` are taken, as many as `rows`.
        """
        self.sse[rows] = other.sse[other_rows]
        self.gradient[rows] = other.gradient[other_rows]
        self.matrix[rows] = other.matrix[other_rows]


def descend(
    problem: Problem,
    starts: FloatArray,
    *,
    weights: FloatArray | None = None,
    held: BoolArray | None = None,
    tolerance: float = 1e-9,
    starts_near_ends: bool = False,
    most_steps: int = 300,
) -> tuple[FloatArray, FloatArray]:
    """The local optima next to each start, within the law's bounds.

    Where constants leave their bounds, the one farthest out is put on its bound and held there.
    The others descend again from within their bounds.

    Args:
        problem: What to fit.
        starts: Free internal constants, shape (descents, free).
        weights: Weight of each curve's squared errors, shape (descents, curves); 1 if not given.
        held: True where a constant stays at its start, shape (descents, free).
        tolerance: A descent ends where the relative decrease of the SSE is below this, both the
            expected and the achieved one.
        starts_near_ends: The starts are near their ends; Newton's method is used.
        most_steps: A descent ends where it is after this many steps.

    Returns:
        The ends, shape (descents, free), and the weighted SSE there, shape (descents,).

    Reference: H. B. Nielsen, Damping Parameter in Marquardt's Method, IMM-REP-1999-05, Technical
    University of Denmark (1999).
    """
    if not len(starts):
        return starts, np.empty(0)
    if weights is None:
        weights = np.ones((len(starts), problem.curves))
    if held is None:
        held = np.zeros(starts.shape, dtype=bool)
    descents = _Descents(problem, weights, held, tolerance, starts_near_ends, most_steps)
    ends, sse = _descend(descents, starts.copy())
    low, high = problem.limits.T
    while True:
        outside = ~held * problem.beyond(ends)
        rows = np.flatnonzero(outside.any(axis=1))
        if not len(rows):
            return ends, sse
        farthest = outside == outside.max(axis=1, keepdims=True)
        held = held | ((outside > 0) & farthest)
        inside = np.where(outside > 0, np.clip(ends, low, high), ends)
        held_descents = replace(descents, held=held).subset(rows)
        ends[rows], sse[rows] = _descend(held_descents, inside[rows])


@dataclass(frozen=True)
class _Descents:
    """A set of descents of one problem.

    Attributes:
        problem: What to fit.
        weights: Weight of each curve's squared errors in each descent, shape (descents, curves).
        held: True where a constant stays at its start, shape (descents, free).
        tolerance: As in `descend`.
        starts_near_ends: The starts are near their ends, where second derivatives of the law help.
        most_steps: As in `descend`.
    """

    problem: Problem
    weights: FloatArray
    held: BoolArray
    tolerance: float
    starts_near_ends: bool
    most_steps: int

    def subset(self, rows: IndexArray) -> "_Descents":
        """The descents of these rows."""
        return replace(self, weights=self.weights[rows], held=self.held[rows])

    def outside(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """Largest distance of the constants that move from their bounds, 0 within.

        Args:
            rows: The descents.
            values: Their free internal constants, shape (rows, free).

        Returns:
            Shape (rows,), in ranges of the bounds.
        """
        beyond = ~self.held[rows] * self.problem.beyond(values)
        return np.asarray(beyond.max(axis=1, initial=0.0))


def _descend(descents: _Descents, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ends of the descents and the SSE there, without regard to bounds; overwrites `values`."""
    starts_near_ends = descents.starts_near_ends
    first_damping = _FIRST_DAMPING_NEAR if starts_near_ends else _FIRST_DAMPING
    least_growth = _GROWTH_NEAR if starts_near_ends else _GROWTH
    current = _normal_equations(descents, values)
    damping: FloatArray = np.full(len(values), first_damping)
    growth: FloatArray = np.full(len(values), least_growth)
    active = np.arange(len(values))
    outside = descents.outside(active, values)
    steps_farther = np.zeros(len(values), dtype=int)
    linear = descents.problem.linear & starts_near_ends
    for _ in range(descents.most_steps):
        step, expected = _steps(current, damping, active, linear)
        # a strongly damped step promises little and proves nothing, nor does one towards a saddle
        is_small = (expected >= 0) & (expected <= descents.tolerance * current.sse[active])
        ended: BoolArray = is_small & (damping[active] <= 1)
        if starts_near_ends:
            # Newton's last step is not tested: its error is the square of the step
            values[active[ended]] += step[ended]
            current.sse[active[ended]] -= expected[ended]
            step, expected, active = step[~ended], expected[~ended], active[~ended]
            ended = ended[~ended]
            if not len(active):
                break
        trial_values = values[active] + step
        trial = _normal_equations(descents.subset(active), trial_values)
        is_better = trial.sse < current.sse[active]
        factor = _damping_factor(current.sse[active], trial.sse, expected, growth[active])
        damping[active] *= factor
        np.maximum(damping, _LEAST_DAMPING, out=damping)
        growth[active] = np.where(is_better, least_growth, 2 * growth[active])
        accepted = active[is_better]
        values[accepted] = trial_values[is_better]
        current.update(accepted, trial, is_better)
        now_outside = descents.outside(accepted, values[accepted])
        is_farther = now_outside > outside[accepted]
        steps_farther[accepted] = np.where(is_farther, steps_farther[accepted] + 1, 0)
        outside[accepted] = now_outside
        # a refit that runs away goes on for many steps; it ends at a bound
        ended |= (steps_farther[active] >= _STEPS_OUTSIDE) & starts_near_ends
        active = active[~ended & (damping[active] < _STUCK_DAMPING)]
        if not len(active):
            break
    return values, current.sse


def _damping_factor(
    sse: FloatArray, trial_sse: FloatArray, expected: FloatArray, growth: FloatArray
) -> FloatArray:
    """Factor on the damping after a step: below 1 where it was good, `growth` where it was refused.

    Reference: as in `descend`.

    Args:
        sse: SSE before the step, shape (descents,).
        trial_sse: SSE after the step.
        expected: Decrease that the quadratic model expects.
        growth: Factor for a refused step.
    """
    # where the law overflows at the start, every step is an infinite gain
    with np.errstate(over="ignore", invalid="ignore"):
        gain = (sse - trial_sse) / np.maximum(expected, np.finfo(float).tiny)
    easing = np.maximum(1 / 3, 1 - (2 * np.clip(gain, 0, 2) - 1) ** 3)
    return np.where(trial_sse < sse, easing, growth)


def _steps(
    current: _Normal, damping: FloatArray, active: IndexArray, linear: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Damped steps and the decrease of the SSE that the quadratic model expects of them.

    Args:
        current: Normal equations of all descents.
        damping: Damping of all descents.
        active: The descents that have not ended.
        linear: True for constants ln|X0| with mu linear in X0: their step is that of Newton's
            method in X0. Shape (free,).

    Returns:
        Steps, shape (active, free), and decreases, shape (active,).
    """
    matrix = current.matrix[active]
    gradient = current.gradient[active]
    # X^2 f'' = d2f/d(ln X)2 - df/d(ln X)
    np.einsum("kii->ki", matrix)[:] -= np.where(linear, gradient, 0.0)
    # far from a minimum a second derivative may be negative
    size = np.sqrt(np.abs(np.einsum("kii->ki", matrix)))
    # a constant without effect has no scale
    size = np.where(size > 0, size, 1.0)
    scaled = matrix / (size[:, :, np.newaxis] * size[:, np.newaxis, :])
    slope = gradient / size
    damped = scaled + damping[active, np.newaxis, np.newaxis] * np.eye(matrix.shape[1])
    step = np.linalg.solve(damped, -slope[:, :, np.newaxis])[:, :, 0]
    expected = np.sum(step * (damping[active, np.newaxis] * step - slope), axis=1)
    step = step / size
    relative_step = np.maximum(step, -_LARGEST_DECREASE)
    step = np.where(linear, np.log1p(relative_step), step)
    return step, np.asarray(expected)


def _normal_equations(descents: _Descents, values: FloatArray) -> _Normal:
    """Normal equations at the values of each descent, without the constants that are held.

    Args:
        descents: The descents.
        values: Free internal constants, shape (descents, free).
    """
    problem = descents.problem
    if (values == values[0]).all():
        # all descents at one start: sums over points are the same for all
        sse, gradient, matrix = _sums(
            problem, values[:1], descents.weights, descents.starts_near_ends
        )
    else:
        rows_per_chunk = max(_POINTS_PER_CHUNK // max(len(problem.mu), 1), 1)
        sse_of_chunks = []
        gradients = []
        matrices = []
        for first in range(0, len(values), rows_per_chunk):
            rows = slice(first, first + rows_per_chunk)
            chunk_sse, chunk_gradient, chunk_matrix = _sums(
                problem, values[rows], descents.weights[rows], descents.starts_near_ends
            )
            sse_of_chunks.append(chunk_sse)
            gradients.append(chunk_gradient)
            matrices.append(chunk_matrix)
        sse = np.concatenate(sse_of_chunks)
        gradient = np.concatenate(gradients)
        matrix = np.concatenate(matrices)
    moving = ~descents.held
    both_moving = moving[:, :, np.newaxis] & moving[:, np.newaxis, :]
    is_finite = np.isfinite(sse) & np.isfinite(matrix).all(axis=(1, 2))
    return _Normal(
        sse=np.where(is_finite, sse, np.inf),
        gradient=np.where(moving, gradient, 0.0),
        matrix=np.where(both_moving, matrix, np.eye(matrix.shape[1])),
    )


def _sums(
    problem: Problem, values: FloatArray, weights: FloatArray, with_hessian: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """SSE, half its gradient and J^T J, or half the Hessian, by all free constants.

    d mu / d(X0, X1, ...) of a coefficient X is (d mu / d ln X) times the curve's row of the
    design. Sums over points therefore end within a curve. Curves of weight 0 are not evaluated.

    Args:
        problem: What to fit.
        values: Free internal constants, shape (descents, free); one row if all have the same.
        weights: Weight of each curve's squared errors, shape (descents, curves).
        with_hessian: Whether second derivatives of the law are included: the Hessian.
    """
    design = problem.observations.design
    terms = design.shape[1]
    descents = len(weights)
    free_of_coefficient = problem.free.reshape(-1, terms)
    followed = np.flatnonzero(free_of_coefficient.any(axis=1))
    free = free_of_coefficient[followed].ravel()
    coefficients = len(followed)
    if len(values) == 1:
        is_evaluated = weights.any(axis=0, keepdims=True)
    else:
        is_evaluated = weights > 0
    row, curve = np.nonzero(is_evaluated)
    sums_per_curve = 1 + coefficients * (coefficients + 3) // 2
    by_curve = np.zeros((*is_evaluated.shape, sums_per_curve))
    # a trial step may run off to where the law overflows; it is then refused
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        sizes = problem.law.sizes(problem.expand(values.T), design)[:, curve, row]
        curves_per_block = _POINTS_PER_BLOCK * problem.curves // max(len(problem.mu), 1)
        curves_per_block = max(curves_per_block, 1)
        sums = []
        for first in range(0, len(curve), curves_per_block):
            block = slice(first, first + curves_per_block)
            indices = tuple(followed.tolist())
            sums.append(
                _sums_of_curves(problem, sizes[:, block], curve[block], indices, with_hessian)
            )
        by_curve[is_evaluated] = np.concatenate(sums, axis=1).T
        totals = _weighted_totals(design, weights, by_curve)
    # the first column of a design is 1
    gradient = totals[:, 1 : 1 + coefficients, :terms].reshape(descents, len(free))[:, free]
    pair_totals = totals[:, 1 + coefficients :].reshape(descents, -1, terms, terms)
    matrix = np.empty((descents, coefficients, terms, coefficients, terms))
    for pair, (i, j) in enumerate(_lower_triangle(coefficients)):
        matrix[:, i, :, j, :] = pair_totals[:, pair]
        matrix[:, j, :, i, :] = pair_totals[:, pair]
    matrix = matrix.reshape(descents, len(free), len(free))[:, free][:, :, free]
    return totals[:, 0, 0], gradient, matrix


def _weighted_totals(design: FloatArray, weights: FloatArray, by_curve: FloatArray) -> FloatArray:
    """Sums over curves of weight times `by_curve` times the products of the curve's design.

    One product of small matrices follows the other. The bytes of a result therefore depend neither
    on the other descents nor on the threads of BLAS.

    Args:
        design: Shape (curves, terms).
        weights: Shape (descents, curves).
        by_curve: Shape (descents, curves, sums), or (1, curves, sums) where all are the same.

    Returns:
        Shape (descents, sums, terms * terms).
    """
    curves, terms = design.shape
    products = (design[:, :, np.newaxis] * design[:, np.newaxis, :]).reshape(-1, terms**2)
    totals: FloatArray | float = 0.0
    for first in range(0, curves, _CURVES_PER_PRODUCT):
        chunk = slice(first, first + _CURVES_PER_PRODUCT)
        weighted = weights[:, chunk, np.newaxis] * by_curve[:, chunk]
        totals = totals + weighted.swapaxes(1, 2) @ products[chunk]
    return np.asarray(totals)


def _sums_of_curves(
    problem: Problem,
    sizes: FloatArray,
    curve: IndexArray,
    followed: tuple[int, ...],
    with_hessian: bool,
) -> FloatArray:
    """Sums over the points of curves, by ln|X| of the coefficients X that have a free constant.

    Args:
        problem: What to fit.
        sizes: |X| of each coefficient, shape (coefficients, sums).
        curve: Curve of each sum.
        followed: Indices of the coefficients that have a free constant.
        with_hessian: As in `_sums`.

    Returns:
        SSE, half its gradient and the lower triangle of J^T J or half the Hessian, one row each;
        shape (1 + n (n + 3) / 2, sums) of n followed coefficients.
    """
    law = problem.law
    length = problem.lengths[curve]
    first_point = np.cumsum(length) - length
    point = np.arange(length.sum()) + np.repeat(problem.starts[curve] - first_point, length)
    sizes = np.repeat(sizes, length, axis=1)
    slip = problem.observations.slip[point]
    curvatures: tuple[FloatArray | float, ...] = ()
    if with_hessian:
        mu, slopes, curvatures = law.mu_slopes_and_curvatures(sizes, slip, followed)
    else:
        mu, all_slopes = law.mu_and_slopes(sizes, slip)
        slopes = tuple(all_slopes[index] for index in followed)
    residual = mu - problem.mu[point]
    pairs = _lower_triangle(len(slopes))
    first_slope = 1
    first_pair = first_slope + len(slopes)
    point_terms = np.empty((first_pair + len(pairs), len(point)))
    np.square(residual, out=point_terms[0])
    for row, slope in enumerate(slopes, start=first_slope):
        np.multiply(slope, residual, out=point_terms[row])
    for row, (i, j) in enumerate(pairs, start=first_pair):
        np.multiply(slopes[i], slopes[j], out=point_terms[row])
    for row, curvature in enumerate(curvatures, start=first_pair):
        # many are zero everywhere
        if np.ndim(curvature):
            point_terms[row] += residual * curvature
    if problem.weight is not None:
        point_terms *= problem.weight[point]
    return np.asarray(np.add.reduceat(point_terms, first_point, axis=1))


def _lower_triangle(size: int) -> list[tuple[int, int]]:
    """Rows and columns of the lower triangle of a matrix, row by row."""
    return [(i, j) for i in range(size) for j in range(i + 1)]
