"""Newton's method for many bearings at once, each with a few unknowns."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray

# A point is solved where its largest residual is at most this.
TOLERANCE = 1e-10
# Step of a finite difference, relative to the scale of its unknown.
_FINITE_DIFFERENCE = 1e-7
# Longest step of an unknown, in its scale. A longer step is shortened for all unknowns alike.
_LONGEST_STEP = 0.3
# Steps with one Jacobian (chord steps).
_CHORD_STEPS = 3
# Each chord step after the first must reduce the residual to this share.
_CHORD_GAIN = 0.2
# Largest growth of the residual in a plain Newton step. A straight step along a curved groove moves
# a ball off the groove by more than its contacts are pressed together.
_LARGEST_GROWTH = 1e3
# Plain Newton iterations. After these the point starts again, with damping.
_NEWTON_ITERATIONS = 15
# Damping of the first damped iteration, and the damping below which there is none. Damping is the
# inverse of the time step of the stable motion in `solve`.
_FIRST_DAMPING = 0.1
_SMALLEST_DAMPING = 1e-6
# Damping is divided by the factor after a step shorter than this, in the unknowns' scale, and
# multiplied by it after a long or refused step.
_SHORT_STEP = 0.1
_DAMPING_FACTOR = 4

# Steps of Broyden's method, and the residual at which they end. Results do not show so small a
# residual.
_BROYDEN_STEPS = 20
_BROYDEN_TOLERANCE = 1e-12

# Added to the diagonal of the Jacobian. The equations stay regular where a ball touches nothing, so
# that no force depends on its position.
_SMALLEST_DIAGONAL = 1e-12


# Residuals of many bearings. Arguments: unknowns, shape (..., points, unknowns), and the indices of
# the points. The result has the shape of the unknowns.
Equations = Callable[[FloatArray, IndexArray], FloatArray]


@dataclass(frozen=True)
class Solution:
    """Result of an iteration.

    Attributes:
        unknowns: Shape (points, unknowns).
        residual: Largest residual of each point, in the equations' scale.
        converged: True where `residual` is at most `TOLERANCE`.
    """

    unknowns: FloatArray
    residual: FloatArray
    converged: BoolArray

    def replace_points(self, point_index: IndexArray, replacement: "Solution") -> None:
        """Write the solution of some points into this one, in place."""
        self.unknowns[point_index] = replacement.unknowns
        self.residual[point_index] = replacement.residual
        self.converged[point_index] = replacement.converged


@dataclass
class _Iterates:
    """State of the iteration of all points.

    Attributes:
        unknowns: Shape (points, unknowns).
        largest_residual: Largest residual of each point.
        damping: Damping of each point's next step.
    """

    unknowns: FloatArray
    largest_residual: FloatArray
    damping: FloatArray


def solve(
    equations: Equations, start: FloatArray, scale: FloatArray, max_iterations: int
) -> Solution:
    """Roots of the equations of many points, by damped Newton steps of each point.

    The residuals must be of order 1, and dx/dt = residual must be a stable motion. A step solves

        (damping I - J) step = residual

    with the Jacobian J. A plain Newton step has no damping. Where it fails, damping 1/dt turns it
    into an implicit step of that motion over the time dt (pseudo-transient continuation). The
    motion ends in the state in which the balls would settle.

    Args:
        equations: Residuals. Steps below 1e-7 of an unknown's scale are not resolved.
        start: Start of the unknowns, shape (points, unknowns).
        scale: Scale of the unknowns, of the same shape.
        max_iterations: Jacobians after which a point is given up.

    Reference: C. T. Kelley and D. E. Keyes, Convergence analysis of pseudo-transient continuation,
        SIAM J. Numer. Anal. 35 (1998) 508.
    """
    point_count = len(start)
    iterates = _Iterates(start.copy(), np.full(point_count, np.inf), np.zeros(point_count))
    unsolved_index = np.arange(point_count)
    for iteration in range(max_iterations):
        if iteration == _NEWTON_ITERATIONS:
            iterates.damping[unsolved_index] = _FIRST_DAMPING
            iterates.unknowns[unsolved_index] = start[unsolved_index]
        is_damped = iteration >= _NEWTON_ITERATIONS
        _chord_steps(equations, iterates, scale, unsolved_index, is_damped)
        unsolved_index = unsolved_index[iterates.largest_residual[unsolved_index] > TOLERANCE]
        if len(unsolved_index) == 0:
            break
    return Solution(
        iterates.unknowns, iterates.largest_residual, iterates.largest_residual <= TOLERANCE
    )


def _chord_steps(
    equations: Equations,
    iterates: _Iterates,
    scale: FloatArray,
    unsolved_index: IndexArray,
    is_damped: bool,
) -> None:
    """Steps of the unsolved points with one Jacobian, in place, for as long as they help."""
    remaining_index = unsolved_index
    unknowns = iterates.unknowns[remaining_index]
    residual, jacobian = _residual_and_jacobian(
        equations, unknowns, scale[remaining_index], remaining_index
    )
    iterates.largest_residual[remaining_index] = _largest_residual(residual)
    diagonal = (iterates.damping[remaining_index] + _SMALLEST_DIAGONAL)[:, np.newaxis, np.newaxis]
    inverse_matrix = np.linalg.inv(diagonal * np.eye(unknowns.shape[1]) - jacobian)
    for chord_step in range(_CHORD_STEPS):
        step = np.einsum("pij,pj->pi", inverse_matrix, residual)
        length = np.abs(step).max(axis=1)
        trial_unknowns = (
            unknowns
            + _step_shortening_factor(length)[:, np.newaxis] * step * scale[remaining_index]
        )
        residual = equations(trial_unknowns, remaining_index)
        largest_residual = _largest_residual(residual)
        if chord_step > 0:
            largest_allowed_ratio = _CHORD_GAIN
        else:
            largest_allowed_ratio = np.inf if is_damped else _LARGEST_GROWTH
        is_accepted = (
            largest_residual < iterates.largest_residual[remaining_index] * largest_allowed_ratio
        )
        if chord_step == 0 and is_damped:
            damping = iterates.damping[remaining_index]
            iterates.damping[remaining_index] = _next_damping(damping, is_accepted, length)
        iterates.unknowns[remaining_index[is_accepted]] = trial_unknowns[is_accepted]
        iterates.largest_residual[remaining_index[is_accepted]] = largest_residual[is_accepted]
        is_unsolved = is_accepted & (largest_residual > TOLERANCE)
        if not is_unsolved.any():
            break
        remaining_index = remaining_index[is_unsolved]
        unknowns = trial_unknowns[is_unsolved]
        residual = residual[is_unsolved]
        inverse_matrix = inverse_matrix[is_unsolved]


def solve_near(
    equations: Equations, start: FloatArray, scale: FloatArray, inverse_jacobian: FloatArray
) -> Solution:
    """Roots close to the roots of similar equations, by Broyden's method.

    A step takes one evaluation and no Jacobian.

    Args:
        equations: As for `solve`.
        start: Roots of similar equations, shape (points, unknowns).
        scale: As for `solve`.
        inverse_jacobian: Inverse Jacobian at `start`, by the function of that name, shape
            (points, unknowns, unknowns).

    Reference: C. G. Broyden, A class of methods for solving nonlinear simultaneous equations,
        Math. Comput. 19 (1965) 577.
    """
    unknowns = start.copy()
    largest_residual = np.full(len(start), np.inf)
    remaining_index = np.arange(len(start))
    current_unknowns = start
    residual = equations(current_unknowns, remaining_index)
    for _ in range(_BROYDEN_STEPS):
        largest_residual[remaining_index] = _largest_residual(residual)
        step = np.einsum("pij,pj->pi", inverse_jacobian, residual)
        step *= _step_shortening_factor(np.abs(step).max(axis=1))[:, np.newaxis]
        current_unknowns = current_unknowns + step * scale[remaining_index]
        # The step from a root is not checked: its residuals would be rounding, and an updated
        # inverse would turn rounding into a direction.
        unknowns[remaining_index] = current_unknowns
        is_unsolved = (largest_residual[remaining_index] > _BROYDEN_TOLERANCE) & np.isfinite(
            largest_residual[remaining_index]
        )
        remaining_index = remaining_index[is_unsolved]
        current_unknowns = current_unknowns[is_unsolved]
        if len(remaining_index) == 0:
            break
        new_residual = equations(current_unknowns, remaining_index)
        residual_change = residual[is_unsolved] - new_residual
        inverse_jacobian = broyden_update(
            inverse_jacobian[is_unsolved], step[is_unsolved], residual_change
        )
        residual = new_residual
    # a point that is not at a root after all steps is judged where its last step ended
    if len(remaining_index):
        largest_residual[remaining_index] = _largest_residual(residual)
    return Solution(unknowns, largest_residual, largest_residual <= TOLERANCE)


def broyden_update(
    inverse_jacobian: FloatArray, step: FloatArray, residual_change: FloatArray
) -> FloatArray:
    """Inverse of the nearest Jacobian that maps a step to the change of residuals in it.

        H + (s - H c) (s^T H) / (s^T H c)

    Args:
        inverse_jacobian: Inverse Jacobian H of each point, shape (points, n, n).
        step: Step s of the unknowns, shape (points, n).
        residual_change: Change c of the residuals in this step, shape (points, n), with the sign of
            H: where the equations are linear, H c is the step.
    """
    expected_step = np.einsum("pij,pj->pi", inverse_jacobian, residual_change)
    step_times_inverse = np.einsum("pi,pij->pj", step, inverse_jacobian)
    denominator = np.einsum("pi,pi->p", step, expected_step)
    # without a denominator the inverse stays as it is
    weight = np.divide(1.0, denominator, out=np.zeros_like(denominator), where=denominator != 0)
    return np.asarray(
        inverse_jacobian
        + np.einsum("p,pi,pj->pij", weight, step - expected_step, step_times_inverse)
    )


def inverse_jacobian(equations: Equations, unknowns: FloatArray, scale: FloatArray) -> FloatArray:
    """Matrices that turn residuals into Newton steps in the unknowns' scale: (points, n, n)."""
    _, jacobian = _residual_and_jacobian(equations, unknowns, scale, np.arange(len(unknowns)))
    regular_matrix = _SMALLEST_DIAGONAL * np.eye(unknowns.shape[1]) - jacobian
    return np.asarray(np.linalg.inv(regular_matrix), dtype=np.float64)


def _residual_and_jacobian(
    equations: Equations, unknowns: FloatArray, scale: FloatArray, point_index: IndexArray
) -> tuple[FloatArray, FloatArray]:
    """Residuals, and their derivatives by the scaled unknowns, from one call of the equations."""
    unknown_count = unknowns.shape[1]
    # the first row moves no unknown, each other row moves one of them
    displacements = (
        np.eye(unknown_count + 1, unknown_count, k=-1)[:, np.newaxis] * _FINITE_DIFFERENCE * scale
    )
    residuals = equations(unknowns + displacements, point_index)
    derivatives = (residuals[1:] - residuals[0]) / _FINITE_DIFFERENCE
    return residuals[0], np.moveaxis(derivatives, 0, -1)


def _largest_residual(residuals: FloatArray) -> FloatArray:
    """Largest absolute residual of each point; infinite where a residual is not finite."""
    largest_residual = np.abs(residuals).max(axis=-1)
    return np.where(np.isfinite(largest_residual), largest_residual, np.inf)


def _step_shortening_factor(length: FloatArray) -> FloatArray:
    """Factor on a step, by its length, that limits it to the longest step allowed."""
    return _LONGEST_STEP / np.maximum(length, _LONGEST_STEP)


def _next_damping(damping: FloatArray, is_accepted: BoolArray, length: FloatArray) -> FloatArray:
    """Damping of the next step: smaller after a short step, larger after a long or refused one."""
    is_too_long = ~is_accepted | ~(length < _LONGEST_STEP)
    damping_after_success = np.where(length < _SHORT_STEP, damping / _DAMPING_FACTOR, damping)
    next_damping = np.where(is_too_long, damping * _DAMPING_FACTOR, damping_after_success)
    return np.where(next_damping < _SMALLEST_DAMPING, 0.0, next_damping)
