"""Levenberg-Marquardt from many starts at once, for searches, resampled curves and profiles.

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

# Number of points, summed over descents, whose sums are kept at once.
_POINTS_PER_CHUNK = 1 << 17
# Number of points, summed over descents, at which laws are evaluated at once: about what fits the
# cache of a processor.
_POINTS_PER_BLOCK = 1 << 13
# Number of curves whose sums BLAS adds at once: too few for BLAS to start a second thread.
_CURVES_PER_PRODUCT = 1 << 9
# Damping of the first step, from any start and from a start near the end. Near the end, the first
# step is almost that of Newton's method.
_FIRST_DAMPING = 1e-2
_FIRST_DAMPING_NEAR = 1e-5
# Factor on the damping after a refused step, from any start and from a start near the end. Near the
# end, the damping is small at first and must rise fast.
_DAMPING_GROWTH = 2.0
_DAMPING_GROWTH_NEAR = 16.0
# A refit ends after this many steps in a row outside its bounds, each farther than the last.
_MOST_STEPS_OUTSIDE = 3
# Newton's method reduces a magnitude |X0| by at most this share in one step.
_LARGEST_DECREASE = 0.9
# Keeps a singular matrix solvable, and is too small to slow down a regular one.
_LEAST_DAMPING = 1e-12
# A step with this damping moves nothing: the descent is stuck.
_STUCK_DAMPING = 1e12
# glibc returns freed memory to the system and requests it again, which takes 15 % of the time of
# a fit. After an array of this many numbers was freed, glibc keeps that much memory.
np.empty(1 << 21)


@dataclass(frozen=True)
class _NormalEquations:
    """Normal equations of k descents, each over n constants.

    Attributes:
        sse: Sum of squared errors, shape (k,).
        gradient: Half the gradient of the SSE, shape (k, n).
        matrix: J^T J or half the Hessian of the SSE, shape (k, n, n).
    """

    sse: FloatArray
    gradient: FloatArray
    matrix: FloatArray

    def update(
        self, overwritten: IndexArray, other: "_NormalEquations", is_taken: BoolArray
    ) -> None:
        """Overwrite some descents with those of other normal equations.

        Args:
            overwritten: Indices of the descents that are overwritten.
            other: Normal equations with the new values.
            is_taken: Whether each descent of `other` is taken; as many are as are overwritten.
        """
        self.sse[overwritten] = other.sse[is_taken]
        self.gradient[overwritten] = other.gradient[is_taken]
        self.matrix[overwritten] = other.matrix[is_taken]


def descend(
    problem: Problem,
    starts: FloatArray,
    *,
    weights: FloatArray | None = None,
    is_held: BoolArray | None = None,
    tolerance: float = 1e-9,
    use_newton: bool = False,
    most_steps: int = 300,
) -> tuple[FloatArray, FloatArray]:
    """The local optima next to each start, within the law's bounds.

    Where constants leave their bounds, the one farthest out is put on its bound and held there.
    The others descend again from within their bounds.

    Args:
        problem: What to fit.
        starts: Free internal constants, shape (descents, free).
        weights: Weight of each curve's squared errors, shape (descents, curves); 1 if not given.
        is_held: True where a constant stays at its start, shape (descents, free).
        tolerance: A descent ends where the relative decrease of the SSE is below this, both the
            expected and the achieved one.
        use_newton: Whether Newton's method is used, with second derivatives of the law and little
            damping. Only for starts near their ends: from others it may run away.
        most_steps: Largest number of steps of a descent.

    Returns:
        The ends, shape (descents, free), and the weighted SSE there, shape (descents,).

    Reference: H. B. Nielsen, Damping Parameter in Marquardt's Method, IMM-REP-1999-05, Technical
    University of Denmark (1999).
    """
    if not len(starts):
        return starts, np.empty(0)
    if weights is None:
        weights = np.ones((len(starts), problem.curve_count))
    if is_held is None:
        is_held = np.zeros(starts.shape, dtype=bool)
    descents = _Descents(problem, weights, is_held, tolerance, use_newton, most_steps)
    ends, sse = _descend(descents, starts.copy())
    low, high = problem.free_bounds.T
    while True:
        distance_outside = ~is_held * problem.distance_beyond_bounds(ends)
        outside_indices = np.flatnonzero(distance_outside.any(axis=1))
        if not len(outside_indices):
            return ends, sse
        is_farthest = distance_outside == distance_outside.max(axis=1, keepdims=True)
        is_held = is_held | ((distance_outside > 0) & is_farthest)
        restarts = np.where(distance_outside > 0, np.clip(ends, low, high), ends)
        held_descents = replace(descents, is_held=is_held).select(outside_indices)
        ends[outside_indices], sse[outside_indices] = _descend(
            held_descents, restarts[outside_indices]
        )


@dataclass(frozen=True)
class _Descents:
    """A set of descents of one problem.

    Attributes:
        problem: What to fit.
        weights: Weight of each curve's squared errors in each descent, shape (descents, curves).
        is_held: True where a constant stays at its start, shape (descents, free).
        tolerance: As in `descend`.
        use_newton: As in `descend`.
        most_steps: As in `descend`.
    """

    problem: Problem
    weights: FloatArray
    is_held: BoolArray
    tolerance: float
    use_newton: bool
    most_steps: int

    def select(self, indices: IndexArray) -> "_Descents":
        """Some of the descents.

        Args:
            indices: Indices of these descents.
        """
        return replace(self, weights=self.weights[indices], is_held=self.is_held[indices])

    def distance_outside(self, indices: IndexArray, constants: FloatArray) -> FloatArray:
        """Largest distance beyond the bounds, of the constants that are not held; 0 within.

        Args:
            indices: Indices of the descents.
            constants: Their free internal constants, shape (rows, free).

        Returns:
            Shape (rows,), in ranges of the bounds.
        """
        distances = ~self.is_held[indices] * self.problem.distance_beyond_bounds(constants)
        return np.asarray(distances.max(axis=1, initial=0.0))


def _descend(descents: _Descents, constants: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ends of the descents and the SSE there, without regard to bounds; overwrites `constants`."""
    use_newton = descents.use_newton
    first_damping = _FIRST_DAMPING_NEAR if use_newton else _FIRST_DAMPING
    least_growth = _DAMPING_GROWTH_NEAR if use_newton else _DAMPING_GROWTH
    current = _normal_equations(descents, constants)
    damping: FloatArray = np.full(len(constants), first_damping)
    growth: FloatArray = np.full(len(constants), least_growth)
    active_indices = np.arange(len(constants))
    distance_outside = descents.distance_outside(active_indices, constants)
    steps_farther = np.zeros(len(constants), dtype=int)
    is_linear = descents.problem.is_linear & use_newton
    for _ in range(descents.most_steps):
        steps, expected_decrease = _damped_steps(current, damping, active_indices, is_linear)
        # a strongly damped step promises little and proves nothing, nor does one towards a saddle
        is_small = (expected_decrease >= 0) & (
            expected_decrease <= descents.tolerance * current.sse[active_indices]
        )
        has_ended: BoolArray = is_small & (damping[active_indices] <= 1)
        if use_newton:
            # Newton's last step is not tested: its error is the square of the step
            constants[active_indices[has_ended]] += steps[has_ended]
            current.sse[active_indices[has_ended]] -= expected_decrease[has_ended]
            steps, expected_decrease, active_indices = (
                steps[~has_ended],
                expected_decrease[~has_ended],
                active_indices[~has_ended],
            )
            has_ended = has_ended[~has_ended]
            if not len(active_indices):
                break
        trial_constants = constants[active_indices] + steps
        trial = _normal_equations(descents.select(active_indices), trial_constants)
        is_better = trial.sse < current.sse[active_indices]
        damping_factor = _damping_factor(
            current.sse[active_indices], trial.sse, expected_decrease, growth[active_indices]
        )
        damping[active_indices] *= damping_factor
        np.maximum(damping, _LEAST_DAMPING, out=damping)
        growth[active_indices] = np.where(is_better, least_growth, 2 * growth[active_indices])
        accepted_indices = active_indices[is_better]
        constants[accepted_indices] = trial_constants[is_better]
        current.update(accepted_indices, trial, is_better)
        new_distance = descents.distance_outside(accepted_indices, constants[accepted_indices])
        is_farther = new_distance > distance_outside[accepted_indices]
        steps_farther[accepted_indices] = np.where(
            is_farther, steps_farther[accepted_indices] + 1, 0
        )
        distance_outside[accepted_indices] = new_distance
        # a refit that runs away goes on for many steps; it ends at a bound
        has_ended |= (steps_farther[active_indices] >= _MOST_STEPS_OUTSIDE) & use_newton
        active_indices = active_indices[~has_ended & (damping[active_indices] < _STUCK_DAMPING)]
        if not len(active_indices):
            break
    return constants, current.sse


def _damping_factor(
    sse: FloatArray, trial_sse: FloatArray, expected_decrease: FloatArray, growth: FloatArray
) -> FloatArray:
    """Factor on the damping after a step: below 1 where it was good, `growth` where it was refused.

    Reference: as in `descend`.

    Args:
        sse: SSE before the step, shape (descents,).
        trial_sse: SSE after the step.
        expected_decrease: Decrease that the quadratic model expects.
        growth: Factor for a refused step.
    """
    # where the law overflows at the start, the SSE of every step is infinitely smaller
    with np.errstate(over="ignore", invalid="ignore"):
        gain_ratio = (sse - trial_sse) / np.maximum(expected_decrease, np.finfo(float).tiny)
    accepted_factor = np.maximum(1 / 3, 1 - (2 * np.clip(gain_ratio, 0, 2) - 1) ** 3)
    return np.where(trial_sse < sse, accepted_factor, growth)


def _damped_steps(
    current: _NormalEquations, damping: FloatArray, active_indices: IndexArray, is_linear: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Damped steps and the decrease of the SSE that the quadratic model expects of them.

    Args:
        current: Normal equations of all descents.
        damping: Damping of all descents, shape (descents,).
        active_indices: Indices of the descents that have not ended.
        is_linear: True for constants ln|X0| with mu linear in X0: their step is that of Newton's
            method in X0. Shape (free,).

    Returns:
        Steps, shape (active, free), and decreases, shape (active,).
    """
    matrix = current.matrix[active_indices]
    gradient = current.gradient[active_indices]
    diagonals = np.einsum("kii->ki", matrix)  # a view: `matrix` changes with it
    # X^2 f'' = d2f/d(ln X)2 - df/d(ln X)
    diagonals -= np.where(is_linear, gradient, 0.0)
    # far from a minimum a second derivative may be negative
    scale = np.sqrt(np.abs(diagonals))
    # a constant without effect has no scale
    scale = np.where(scale > 0, scale, 1.0)
    scaled_matrix = matrix / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    scaled_gradient = gradient / scale
    damped_matrix = scaled_matrix + damping[active_indices, np.newaxis, np.newaxis] * np.eye(
        matrix.shape[1]
    )
    steps = np.linalg.solve(damped_matrix, -scaled_gradient[:, :, np.newaxis])[:, :, 0]
    expected_decrease = np.sum(
        steps * (damping[active_indices, np.newaxis] * steps - scaled_gradient), axis=1
    )
    steps = steps / scale
    relative_steps = np.maximum(steps, -_LARGEST_DECREASE)
    steps = np.where(is_linear, np.log1p(relative_steps), steps)
    return steps, np.asarray(expected_decrease)


def _normal_equations(descents: _Descents, constants: FloatArray) -> _NormalEquations:
    """Normal equations at the values of each descent, without the constants that are held.

    Args:
        descents: The descents.
        constants: Free internal constants, shape (descents, free).
    """
    problem = descents.problem
    if (constants == constants[0]).all():
        # all descents at one start: sums over points are the same for all
        sse, gradient, matrix = _weighted_sums(
            problem, constants[:1], descents.weights, descents.use_newton
        )
    else:
        descents_per_chunk = max(_POINTS_PER_CHUNK // max(len(problem.mu), 1), 1)
        sse_of_chunks = []
        gradients = []
        matrices = []
        for first_descent in range(0, len(constants), descents_per_chunk):
            chunk = slice(first_descent, first_descent + descents_per_chunk)
            chunk_sse, chunk_gradient, chunk_matrix = _weighted_sums(
                problem, constants[chunk], descents.weights[chunk], descents.use_newton
            )
            sse_of_chunks.append(chunk_sse)
            gradients.append(chunk_gradient)
            matrices.append(chunk_matrix)
        sse = np.concatenate(sse_of_chunks)
        gradient = np.concatenate(gradients)
        matrix = np.concatenate(matrices)
    is_moving = ~descents.is_held
    are_both_moving = is_moving[:, :, np.newaxis] & is_moving[:, np.newaxis, :]
    is_finite = np.isfinite(sse) & np.isfinite(matrix).all(axis=(1, 2))
    return _NormalEquations(
        sse=np.where(is_finite, sse, np.inf),
        gradient=np.where(is_moving, gradient, 0.0),
        matrix=np.where(are_both_moving, matrix, np.eye(matrix.shape[1])),
    )


def _weighted_sums(
    problem: Problem, constants: FloatArray, weights: FloatArray, with_hessian: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """SSE, half its gradient and J^T J, or half the Hessian, by all free constants.

    d mu / d(X0, X1, ...) of a coefficient X is (d mu / d ln X) times the curve's row of the
    design. Sums over points therefore end within a curve. Curves of weight 0 are not evaluated.

    Args:
        problem: What to fit.
        constants: Free internal constants, shape (descents, free); one row if all have the same.
        weights: Weight of each curve's squared errors, shape (descents, curves).
        with_hessian: Whether second derivatives of the law are included: the Hessian.
    """
    design = problem.observations.design
    term_count = design.shape[1]
    descent_count = len(weights)
    is_free_by_coefficient = problem.is_free.reshape(-1, term_count)
    fitted_coefficients = np.flatnonzero(is_free_by_coefficient.any(axis=1))
    is_free = is_free_by_coefficient[fitted_coefficients].ravel()
    coefficient_count = len(fitted_coefficients)
    if len(constants) == 1:
        is_evaluated = weights.any(axis=0, keepdims=True)
    else:
        is_evaluated = weights > 0
    # a sum is over the points of one curve in one descent, or in all descents if they share the
    # constants
    row_of_sum, curve_of_sum = np.nonzero(is_evaluated)
    sums_per_curve = 1 + coefficient_count * (coefficient_count + 3) // 2
    sums_by_curve = np.zeros((*is_evaluated.shape, sums_per_curve))
    # a trial step may run off to where the law overflows; it is then refused
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        magnitudes = problem.law.magnitudes(problem.expand(constants.T), design)[
            :, curve_of_sum, row_of_sum
        ]
        curves_per_block = _POINTS_PER_BLOCK * problem.curve_count // max(len(problem.mu), 1)
        curves_per_block = max(curves_per_block, 1)
        blocks_of_sums = []
        for first_sum in range(0, len(curve_of_sum), curves_per_block):
            block = slice(first_sum, first_sum + curves_per_block)
            coefficient_indices = tuple(fitted_coefficients.tolist())
            blocks_of_sums.append(
                _sums_of_curves(
                    problem,
                    magnitudes[:, block],
                    curve_of_sum[block],
                    coefficient_indices,
                    with_hessian,
                )
            )
        sums_by_curve[is_evaluated] = np.concatenate(blocks_of_sums, axis=1).T
        totals = _weighted_totals(design, weights, sums_by_curve)
    # the first column of a design is 1
    gradient = totals[:, 1 : 1 + coefficient_count, :term_count].reshape(
        descent_count, len(is_free)
    )[:, is_free]
    pair_totals = totals[:, 1 + coefficient_count :].reshape(
        descent_count, -1, term_count, term_count
    )
    matrix = np.empty((descent_count, coefficient_count, term_count, coefficient_count, term_count))
    for pair, (i, j) in enumerate(_lower_triangle(coefficient_count)):
        matrix[:, i, :, j, :] = pair_totals[:, pair]
        matrix[:, j, :, i, :] = pair_totals[:, pair]
    matrix = matrix.reshape(descent_count, len(is_free), len(is_free))[:, is_free][:, :, is_free]
    return totals[:, 0, 0], gradient, matrix


def _weighted_totals(
    design: FloatArray, weights: FloatArray, sums_by_curve: FloatArray
) -> FloatArray:
    """Sums over curves of weight times `sums_by_curve` times the products of the curve's design.

    One product of small matrices follows the other. The bytes of a result therefore depend neither
    on the other descents nor on the threads of BLAS.

    Args:
        design: Shape (curves, terms).
        weights: Shape (descents, curves).
        sums_by_curve: Shape (descents, curves, sums), or (1, curves, sums) where all are the same.

    Returns:
        Shape (descents, sums, terms * terms).
    """
    curve_count, term_count = design.shape
    products = (design[:, :, np.newaxis] * design[:, np.newaxis, :]).reshape(-1, term_count**2)
    totals: FloatArray | float = 0.0
    for first_curve in range(0, curve_count, _CURVES_PER_PRODUCT):
        chunk = slice(first_curve, first_curve + _CURVES_PER_PRODUCT)
        weighted = weights[:, chunk, np.newaxis] * sums_by_curve[:, chunk]
        totals = totals + weighted.swapaxes(1, 2) @ products[chunk]
    return np.asarray(totals)


def _sums_of_curves(
    problem: Problem,
    magnitudes: FloatArray,
    curve_of_sum: IndexArray,
    coefficient_indices: tuple[int, ...],
    with_hessian: bool,
) -> FloatArray:
    """Sums over the points of curves, by ln|X| of the coefficients X that have a free constant.

    Args:
        problem: What to fit.
        magnitudes: |X| of each coefficient, shape (coefficients, sums).
        curve_of_sum: Index of the curve of each sum, shape (sums,).
        coefficient_indices: Indices of the coefficients that have a free constant.
        with_hessian: As in `_weighted_sums`.

    Returns:
        SSE, half its gradient and the lower triangle of J^T J or half the Hessian, one row each;
        shape (1 + n (n + 3) / 2, sums) of n such coefficients.
    """
    law = problem.law
    point_counts = problem.point_counts[curve_of_sum]
    # an entry is a point in a sum; the entries of a sum follow each other
    first_entry_of_sum = np.cumsum(point_counts) - point_counts
    point_of_entry = np.arange(point_counts.sum()) + np.repeat(
        problem.first_point_of_curve[curve_of_sum] - first_entry_of_sum, point_counts
    )
    magnitudes = np.repeat(magnitudes, point_counts, axis=1)
    slip = problem.observations.slip[point_of_entry]
    curvatures: tuple[FloatArray | float, ...] = ()
    if with_hessian:
        mu, slopes, curvatures = law.mu_slopes_and_curvatures(magnitudes, slip, coefficient_indices)
    else:
        mu, all_slopes = law.mu_and_slopes(magnitudes, slip)
        slopes = tuple(all_slopes[index] for index in coefficient_indices)
    residual = mu - problem.mu[point_of_entry]
    pairs = _lower_triangle(len(slopes))
    first_slope_row = 1
    first_pair_row = first_slope_row + len(slopes)
    entry_terms = np.empty((first_pair_row + len(pairs), len(point_of_entry)))
    np.square(residual, out=entry_terms[0])
    for row, slope in enumerate(slopes, start=first_slope_row):
        np.multiply(slope, residual, out=entry_terms[row])
    for row, (i, j) in enumerate(pairs, start=first_pair_row):
        np.multiply(slopes[i], slopes[j], out=entry_terms[row])
    for row, curvature in enumerate(curvatures, start=first_pair_row):
        # many are zero everywhere
        if np.ndim(curvature):
            entry_terms[row] += residual * curvature
    if problem.weight_of_point is not None:
        entry_terms *= problem.weight_of_point[point_of_entry]
    return np.asarray(np.add.reduceat(entry_terms, first_entry_of_sum, axis=1))


def _lower_triangle(size: int) -> list[tuple[int, int]]:
    """Rows and columns of the lower triangle of a matrix, row by row."""
    return [(i, j) for i in range(size) for j in range(i + 1)]
