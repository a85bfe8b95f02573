"""Curves of solutions, followed through their folds: pseudo-arclength continuation.

Equations with one free parameter have a curve of solutions. The curve is followed by its length
and not by its parameter, because it may turn back. A point is a problem with equations of its own,
such as an operating point of a bearing. One call follows the curves of many points. Each curve is
followed independently: its result does not depend on the other points.

References: H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in
    P. Rabinowitz (ed.), Applications of Bifurcation Theory (1977) 359; E. L. Allgower and K. Georg,
    Introduction to Numerical Continuation Methods (2003), chapters 2, 6 and 7.

Decides: how a curve of solutions is followed, and where it passes a value of its parameter.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.solver import broyden_update

# Residuals with a parameter. Arguments: unknowns, shape (..., points, unknowns), the parameter,
# shape (..., points), and the indices of the points.
ParametricEquations = Callable[[FloatArray, FloatArray, IndexArray], FloatArray]

# Step of a finite difference, in the scaled unknowns and in the parameter.
_FINITE_DIFFERENCE = 1e-7
# Lengths of steps along a curve, in the scaled unknowns.
_FIRST_STEP = 0.05
_SHORTEST_STEP = 1e-6
_LONGEST_STEP = 0.4
# Steps of a curve, refused steps included, after which it is given up.
_MAX_STEPS = 600
# Steps in sequence below `kink_length`, after which a curve is given up: it goes back and forth
# between the two sides of a kink.
_MAX_STEPS_AT_KINK = 60
# Corrections of a predicted state after which the step is refused.
_MAX_CORRECTIONS = 6
# The next step is not longer after a step with so many corrections.
_MANY_CORRECTIONS = 4
# A step is refused where the cosine of the angle between its two tangents is below this.
_SMALLEST_COSINE = 0.9
# The next step is longer where that cosine is above this.
_STRAIGHT_COSINE = 0.97
# Factors on the length of the next step.
_LENGTHENING_FACTOR = 1.7
_SHORTENING_FACTOR = 0.4
# A root of a polynomial counts as real if its imaginary part is below this, by rounding.
_LARGEST_IMAGINARY_PART = 1e-9


@dataclass(frozen=True)
class Crossings:
    """Crossings of a value of the parameter by curves of solutions.

    Attributes:
        point_index: Index of the point of each crossing, in ascending order, shape (crossings,).
        unknowns: Unknowns interpolated on the curve, near a solution, (crossings, unknowns).
        reached_last_value: True where the curve of a point reached the last value of the parameter,
            shape (points,).
        turned_back: True where the curve of a point turned back to the first value of the
            parameter, shape (points,).
        end_unknowns: Unknowns at the end of each curve, shape (points, unknowns).
        end_parameter: Parameter at the end of each curve, shape (points,).
    """

    point_index: IndexArray
    unknowns: FloatArray
    reached_last_value: BoolArray
    turned_back: BoolArray
    end_unknowns: FloatArray
    end_parameter: FloatArray


@dataclass
class _Curves:
    """Unfinished curves, one row per curve.

    Attributes:
        point_index: Index of each curve's point, shape (curves,).
        state: Scaled unknowns and parameter, shape (curves, unknowns + 1).
        slopes: Derivatives of the residuals at that state, (curves, unknowns, unknowns + 1).
        tangent: Unit tangent at that state, shape (curves, unknowns + 1).
        curvature: Derivative of the tangent by length, estimated from the last step, of the same
            shape.
        step_length: Length of the next step, shape (curves,).
        was_refused: True where the last step was refused, shape (curves,).
        steps_at_kink: Number of last steps that were shorter than `kink_length`, shape (curves,).
    """

    point_index: IndexArray
    state: FloatArray
    slopes: FloatArray
    tangent: FloatArray
    curvature: FloatArray
    step_length: FloatArray
    was_refused: BoolArray
    steps_at_kink: IndexArray

    def select(self, is_selected: BoolArray) -> "_Curves":
        """Some of the curves."""
        return _Curves(
            point_index=self.point_index[is_selected],
            state=self.state[is_selected],
            slopes=self.slopes[is_selected],
            tangent=self.tangent[is_selected],
            curvature=self.curvature[is_selected],
            step_length=self.step_length[is_selected],
            was_refused=self.was_refused[is_selected],
            steps_at_kink=self.steps_at_kink[is_selected],
        )


def trace(
    equations: ParametricEquations,
    start: FloatArray,
    scale: FloatArray,
    start_parameter: FloatArray,
    wanted_value: float,
    first_value: float,
    last_value: float,
    kink_length: float = 0.0,
    tolerance: float = 1e-7,
) -> Crossings:
    """All crossings of a value of the parameter by the curves through some solutions.

    A curve starts in the direction of a rising parameter. It ends where the parameter passes
    `first_value` or `last_value`. Between two states the curve is a cubic of its length (Hermite),
    so that two crossings within one step are found.

    Args:
        equations: The residuals, smooth and of order 1.
        start: Solutions at `start_parameter`, shape (points, unknowns).
        scale: Scale of the unknowns, of the same shape.
        start_parameter: Parameter of these solutions, shape (points,).
        wanted_value: Value of the parameter whose crossings are returned.
        first_value: Curves that have turned back end at this value of the parameter.
        last_value: The other curves end at this value of the parameter, at least `wanted_value`.
        kink_length: Steps shorter than this may turn by any acute angle. At a kink of the residuals
            a step turns by the same angle, however short it is. A curve that takes only such steps
            is given up.
        tolerance: Largest residual of a state on its curve. Crossings are only interpolated.
    """
    curve_count, unknown_count = start.shape
    # a state: the scaled unknowns, then the parameter
    state_scale = np.column_stack([scale, np.ones(curve_count)])
    end_state = np.column_stack([start / scale, start_parameter])

    def residuals(states: FloatArray, point_index: IndexArray) -> FloatArray:
        """The equations at states: the scaled unknowns, then the parameter."""
        return equations(states[..., :-1] * scale[point_index], states[..., -1], point_index)

    rising_parameter = np.zeros_like(end_state)
    rising_parameter[:, -1] = 1.0
    slopes = _slopes(residuals, end_state, np.arange(curve_count))
    curves = _Curves(
        point_index=np.arange(curve_count),
        state=end_state.copy(),
        slopes=slopes,
        tangent=_unit_tangent(slopes, rising_parameter),
        curvature=np.zeros_like(end_state),
        step_length=np.full(curve_count, _FIRST_STEP),
        was_refused=np.zeros(curve_count, dtype=bool),
        steps_at_kink=np.zeros(curve_count, dtype=np.int64),
    )
    point_indices_of_crossings = [np.arange(0)]
    crossing_states = [np.empty((0, unknown_count + 1))]
    reached_last_value = np.zeros(curve_count, dtype=bool)
    turned_back = np.zeros(curve_count, dtype=bool)
    for _ in range(_MAX_STEPS):
        if len(curves.point_index) == 0:
            break
        old_state = curves.state.copy()
        old_tangent = curves.tangent.copy()
        is_step_accepted = _advance(residuals, curves, kink_length, tolerance)
        length = np.linalg.norm(curves.state - old_state, axis=1)
        crossing_curve_index, crossing_state = _interpolated_crossings(
            old_state, curves.state, old_tangent, curves.tangent, length, wanted_value
        )
        is_crossing_accepted = is_step_accepted[crossing_curve_index]
        point_indices_of_crossings.append(
            curves.point_index[crossing_curve_index[is_crossing_accepted]]
        )
        crossing_states.append(crossing_state[is_crossing_accepted])
        new_parameter = curves.state[:, -1]
        reaches_last = is_step_accepted & (new_parameter >= last_value)
        turns_back = is_step_accepted & (new_parameter < first_value)
        reached_last_value[curves.point_index[reaches_last]] = True
        turned_back[curves.point_index[turns_back]] = True
        end_state[curves.point_index] = curves.state
        has_stalled = (curves.step_length < _SHORTEST_STEP) | (
            curves.steps_at_kink > _MAX_STEPS_AT_KINK
        )
        curves = curves.select(~(reaches_last | turns_back | has_stalled))
    point_index_of_crossing = np.concatenate(point_indices_of_crossings)
    unknowns = (np.concatenate(crossing_states) * state_scale[point_index_of_crossing])[:, :-1]
    sorted_order = np.argsort(point_index_of_crossing, kind="stable")
    return Crossings(
        point_index=point_index_of_crossing[sorted_order],
        unknowns=unknowns[sorted_order],
        reached_last_value=reached_last_value,
        turned_back=turned_back,
        end_unknowns=(end_state * state_scale)[:, :-1],
        end_parameter=end_state[:, -1],
    )


def _advance(
    residuals: Callable[[FloatArray, IndexArray], FloatArray],
    curves: _Curves,
    kink_length: float,
    tolerance: float,
) -> BoolArray:
    """One step of each curve, in place; True where the step was accepted."""
    is_at_kink = curves.step_length < kink_length
    curves.steps_at_kink[:] = np.where(is_at_kink, curves.steps_at_kink + 1, 0)
    step_length = curves.step_length[:, np.newaxis]
    predicted_state = (
        curves.state + step_length * curves.tangent + step_length**2 / 2 * curves.curvature
    )
    # after a refused step the slopes at the old state are replaced by those at the predicted state
    refused_index = np.flatnonzero(curves.was_refused)
    if len(refused_index):
        curves.slopes[refused_index] = _slopes(
            residuals, predicted_state[refused_index], curves.point_index[refused_index]
        )
    corrected_state, correction_count = _correct_states(
        residuals, curves, predicted_state, tolerance
    )
    reached_index = np.flatnonzero(correction_count <= _MAX_CORRECTIONS)
    slopes = _slopes(residuals, corrected_state[reached_index], curves.point_index[reached_index])
    tangent = _unit_tangent(slopes, curves.tangent[reached_index])
    cosine = np.einsum("pi,pi->p", tangent, curves.tangent[reached_index])
    smallest_cosine = np.where(
        curves.step_length[reached_index] < kink_length, 0.0, _SMALLEST_COSINE
    )
    is_turn_small = cosine > smallest_cosine
    accepted_index = reached_index[is_turn_small]
    is_accepted = np.zeros(len(curves.point_index), dtype=bool)
    is_accepted[accepted_index] = True
    may_be_longer = np.zeros(len(curves.point_index), dtype=bool)
    may_be_longer[reached_index] = (cosine > _STRAIGHT_COSINE) & (
        correction_count[reached_index] < _MANY_CORRECTIONS
    )
    length = np.linalg.norm(corrected_state[accepted_index] - curves.state[accepted_index], axis=1)[
        :, np.newaxis
    ]
    curves.curvature[accepted_index] = (
        tangent[is_turn_small] - curves.tangent[accepted_index]
    ) / length
    curves.state[accepted_index] = corrected_state[accepted_index]
    curves.slopes[accepted_index] = slopes[is_turn_small]
    curves.tangent[accepted_index] = tangent[is_turn_small]
    curves.was_refused[:] = ~is_accepted
    length_factor = np.where(
        is_accepted, np.where(may_be_longer, _LENGTHENING_FACTOR, 1.0), _SHORTENING_FACTOR
    )
    curves.step_length[:] = np.minimum(curves.step_length * length_factor, _LONGEST_STEP)
    return is_accepted


def _correct_states(
    residuals: Callable[[FloatArray, IndexArray], FloatArray],
    curves: _Curves,
    predicted_state: FloatArray,
    tolerance: float,
) -> tuple[FloatArray, IndexArray]:
    """Predicted states moved onto their curves by Broyden's method, normal to the tangent.

    Returns:
        The corrected states, and the number of corrections: more than `_MAX_CORRECTIONS` where the
        curve was not reached.
    """
    state = predicted_state.copy()
    correction_count = np.full(len(state), _MAX_CORRECTIONS + 1)
    inverse_slopes = np.linalg.inv(_bordered_matrix(curves.slopes, curves.tangent))
    unfinished_index = np.arange(len(state))
    residual = _append_zero(residuals(state, curves.point_index))
    for correction_index in range(_MAX_CORRECTIONS + 1):
        largest_residual = np.abs(residual).max(axis=1)
        has_converged = largest_residual <= tolerance
        correction_count[unfinished_index[has_converged]] = correction_index
        is_unfinished = ~has_converged & np.isfinite(largest_residual)
        unfinished_index = unfinished_index[is_unfinished]
        residual = residual[is_unfinished]
        inverse_slopes = inverse_slopes[is_unfinished]
        if len(unfinished_index) == 0 or correction_index == _MAX_CORRECTIONS:
            break
        correction = -np.einsum("pij,pj->pi", inverse_slopes, residual)
        # a longer correction could end on another part of the curve
        length = np.linalg.norm(correction, axis=1)
        correction *= (_LONGEST_STEP / np.maximum(length, _LONGEST_STEP))[:, np.newaxis]
        state[unfinished_index] += correction
        new_residual = _append_zero(
            residuals(state[unfinished_index], curves.point_index[unfinished_index])
        )
        inverse_slopes = broyden_update(inverse_slopes, correction, new_residual - residual)
        residual = new_residual
    return state, correction_count


def _append_zero(residual: FloatArray) -> FloatArray:
    """Residuals and a zero for the plane normal to the tangent, in which corrections remain."""
    return np.concatenate([residual, np.zeros((*residual.shape[:-1], 1))], axis=-1)


def _bordered_matrix(slopes: FloatArray, tangent: FloatArray) -> FloatArray:
    """Square matrices: derivatives of the residuals, and of the distance along the tangent.

    A singular one is NaN, so that its curve stalls: NumPy would refuse those of all curves.
    """
    matrix = np.concatenate([slopes, tangent[:, np.newaxis]], axis=1)
    matrix[np.linalg.slogdet(matrix).sign == 0] = np.nan
    return matrix


def _unit_tangent(slopes: FloatArray, direction: FloatArray) -> FloatArray:
    """Unit vectors along which the residuals are constant, on the side of `direction`."""
    right_side = np.zeros(direction.shape)
    right_side[:, -1] = 1.0
    matrix = _bordered_matrix(slopes, direction)
    tangent = np.linalg.solve(matrix, right_side[..., np.newaxis])[..., 0]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))


def _slopes(
    residuals: Callable[[FloatArray, IndexArray], FloatArray],
    state: FloatArray,
    point_index: IndexArray,
) -> FloatArray:
    """Derivatives of the residuals, (points, unknowns, unknowns + 1), from one call of them."""
    coordinate_count = state.shape[1]
    # the first row moves nothing, each other row moves one coordinate
    moved_states = (
        state
        + np.eye(coordinate_count + 1, coordinate_count, k=-1)[:, np.newaxis] * _FINITE_DIFFERENCE
    )
    residuals_of_moved = residuals(moved_states, point_index)
    return np.moveaxis((residuals_of_moved[1:] - residuals_of_moved[0]) / _FINITE_DIFFERENCE, 0, -1)


def _interpolated_crossings(
    old_state: FloatArray,
    new_state: FloatArray,
    old_tangent: FloatArray,
    new_tangent: FloatArray,
    length: FloatArray,
    wanted_value: float,
) -> tuple[IndexArray, FloatArray]:
    """Crossings of a value of the last coordinate by the cubics between two states of each curve.

    Returns:
        Index of the curve of each crossing, and the interpolated states.
    """
    old_derivative = old_tangent * length[:, np.newaxis]
    new_derivative = new_tangent * length[:, np.newaxis]
    state_change = new_state - old_state
    # coefficients of t^3, t^2, t and 1, for t from 0 to 1 (Hermite)
    cubic_coefficient = old_derivative + new_derivative - 2 * state_change
    square_coefficient = 3 * state_change - 2 * old_derivative - new_derivative
    coefficients = np.stack([cubic_coefficient, square_coefficient, old_derivative, old_state])
    # coefficients of the parameter less the wanted value
    distance_coefficients = coefficients[..., -1].copy()
    distance_coefficients[3] -= wanted_value
    # a cubic is within the hull of its Bezier points: it has a root only if they enclose 0
    old_distance = distance_coefficients[3]
    new_distance = distance_coefficients.sum(axis=0)
    bezier_ordinates = np.stack(
        [
            old_distance,
            old_distance + distance_coefficients[2] / 3,
            new_distance - new_derivative[:, -1] / 3,
            new_distance,
        ]
    )
    may_cross = (bezier_ordinates.min(axis=0) <= 0) & (bezier_ordinates.max(axis=0) >= 0)
    curve_index_list = []
    step_shares = []
    for curve_index in np.flatnonzero(may_cross):
        roots = np.roots(distance_coefficients[:, curve_index])
        real_roots = np.sort(roots[np.abs(roots.imag) < _LARGEST_IMAGINARY_PART].real)
        for root in real_roots[(real_roots > 0) & (real_roots <= 1)]:
            curve_index_list.append(curve_index)
            step_shares.append(root)
    crossing_curve_index = np.array(curve_index_list, dtype=np.intp)
    # share of the step at each crossing
    t = np.array(step_shares)[:, np.newaxis]
    a, b, c, d = coefficients[:, crossing_curve_index]
    return crossing_curve_index, np.asarray(((a * t + b) * t + c) * t + d)
