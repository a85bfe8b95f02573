"""Curves of solutions, followed through their folds: pseudo-arclength continuation.

Equations with one free parameter have a curve of solutions. The curve is followed by its length
and not by its parameter, because it may turn back. A point is a problem with equations of its own,
such as an operating point of a bearing. One call follows the curves of many points. Each curve is
followed by itself: its result does not depend on the other points.

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
# shape (..., points), and the numbers of the points.
ParametricEquations = Callable[[FloatArray, FloatArray, IndexArray], FloatArray]

# Step of a finite difference, in the scaled unknowns and in the parameter.
_DIFFERENCE = 1e-7
# Lengths of steps along a curve, in the scaled unknowns.
_FIRST_STEP = 0.05
_SHORTEST_STEP = 1e-6
_LONGEST_STEP = 0.4
# Steps of a curve, refused steps included, after which it is given up.
_MAX_STEPS = 600
# Corrections of a predicted state after which the step is refused.
_MAX_CORRECTIONS = 6
# The next step is not longer after a step with so many corrections.
_MANY_CORRECTIONS = 4
# A step is refused where the cosine of the angle between its two tangents is below this.
_SMALLEST_COSINE = 0.9
# The next step is longer where that cosine is above this.
_STRAIGHT_COSINE = 0.97
# Factors on the length of the next step.
_LONGER = 1.7
_SHORTER = 0.4
# Largest imaginary part of a real root, which has one by rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Crossings:
    """Crossings of a value of the parameter by curves of solutions.

    Attributes:
        point: Number of the point of each crossing, in ascending order, shape (crossings,).
        unknowns: Unknowns interpolated on the curve, near a solution, (crossings, unknowns).
        reached_last: True where the curve of a point reached the last value of the parameter,
            shape (points,).
        returned: True where the curve of a point turned back to the first value, (points,).
        end: Unknowns at the end of each curve, shape (points, unknowns).
        end_parameter: Parameter at the end of each curve, shape (points,).
    """

    point: IndexArray
    unknowns: FloatArray
    reached_last: BoolArray
    returned: BoolArray
    end: FloatArray
    end_parameter: FloatArray


@dataclass
class _Curves:
    """Unfinished curves, one row per curve.

    Attributes:
        point: Number of each curve's point.
        state: Scaled unknowns and parameter, shape (curves, unknowns + 1).
        slopes: Derivatives of the residuals at that state, (curves, unknowns, unknowns + 1).
        tangent: Unit tangent at that state, shape (curves, unknowns + 1).
        curvature: Derivative of the tangent by length, estimated from the last step.
        step: Length of the next step.
        refused: True where the last step was refused.
    """

    point: IndexArray
    state: FloatArray
    slopes: FloatArray
    tangent: FloatArray
    curvature: FloatArray
    step: FloatArray
    refused: BoolArray

    def select(self, which: BoolArray) -> "_Curves":
        """Some of the curves."""
        return _Curves(
            point=self.point[which],
            state=self.state[which],
            slopes=self.slopes[which],
            tangent=self.tangent[which],
            curvature=self.curvature[which],
            step=self.step[which],
            refused=self.refused[which],
        )


def trace(
    equations: ParametricEquations,
    start: FloatArray,
    scale: FloatArray,
    parameter: FloatArray,
    wanted: float,
    first: float,
    last: float,
    kink: float = 0.0,
    tolerance: float = 1e-7,
) -> Crossings:
    """All crossings of a value of the parameter by the curves through some solutions.

    A curve starts in the direction of a rising parameter. It ends where the parameter passes
    `first` or `last`. Between two states the curve is a cubic of its length (Hermite), so that two
    crossings within one step are found.

    Args:
        equations: The residuals, smooth and of order 1.
        start: Solutions at `parameter`, shape (points, unknowns).
        scale: Scale of the unknowns, of the same shape.
        parameter: Parameter of these solutions, shape (points,).
        wanted: Value of the parameter whose crossings are returned.
        first: Curves that have turned back end at this value of the parameter.
        last: The other curves end at this value of the parameter, at least `wanted`.
        kink: Steps shorter than this may turn by any acute angle. At a kink of the residuals a
            step turns by the same angle, however short it is.
        tolerance: Largest residual of a state on its curve. Crossings are only interpolated.
    """
    curve_count, unknown_count = start.shape
    # a state: the scaled unknowns, then the parameter
    state_scale = np.column_stack([scale, np.ones(curve_count)])
    end_state = np.column_stack([start / scale, parameter])

    def residuals(states: FloatArray, which: IndexArray) -> FloatArray:
        """The equations at states: the scaled unknowns, then the parameter."""
        return equations(states[..., :-1] * scale[which], states[..., -1], which)

    rising_parameter = np.zeros_like(end_state)
    rising_parameter[:, -1] = 1.0
    slopes = _slopes(residuals, end_state, np.arange(curve_count))
    curves = _Curves(
        point=np.arange(curve_count),
        state=end_state.copy(),
        slopes=slopes,
        tangent=_tangent(slopes, rising_parameter),
        curvature=np.zeros_like(end_state),
        step=np.full(curve_count, _FIRST_STEP),
        refused=np.zeros(curve_count, dtype=bool),
    )
    crossing_points = [np.arange(0)]
    crossing_states = [np.empty((0, unknown_count + 1))]
    reached_last = np.zeros(curve_count, dtype=bool)
    returned = np.zeros(curve_count, dtype=bool)
    for _ in range(_MAX_STEPS):
        if len(curves.point) == 0:
            break
        old_state = curves.state.copy()
        old_tangent = curves.tangent.copy()
        accepted = _advance(residuals, curves, kink, tolerance)
        length = np.linalg.norm(curves.state - old_state, axis=1)
        crossing_row, crossing_state = _crossings(
            old_state, curves.state, old_tangent, curves.tangent, length, wanted
        )
        is_accepted = accepted[crossing_row]
        crossing_points.append(curves.point[crossing_row[is_accepted]])
        crossing_states.append(crossing_state[is_accepted])
        new_parameter = curves.state[:, -1]
        reaches_last = accepted & (new_parameter >= last)
        returns_to_first = accepted & (new_parameter < first)
        reached_last[curves.point[reaches_last]] = True
        returned[curves.point[returns_to_first]] = True
        end_state[curves.point] = curves.state
        has_stalled = curves.step < _SHORTEST_STEP
        curves = curves.select(~(reaches_last | returns_to_first | has_stalled))
    point = np.concatenate(crossing_points)
    unknowns = (np.concatenate(crossing_states) * state_scale[point])[:, :-1]
    order_by_point = np.argsort(point, kind="stable")
    return Crossings(
        point=point[order_by_point],
        unknowns=unknowns[order_by_point],
        reached_last=reached_last,
        returned=returned,
        end=(end_state * state_scale)[:, :-1],
        end_parameter=end_state[:, -1],
    )


def _advance(
    residuals: Callable[[FloatArray, IndexArray], FloatArray],
    curves: _Curves,
    kink: float,
    tolerance: float,
) -> BoolArray:
    """One step of each curve, in place; True where the step was accepted."""
    step = curves.step[:, np.newaxis]
    predicted_state = curves.state + step * curves.tangent + step**2 / 2 * curves.curvature
    # after a refused step the slopes at the old state are replaced by those at the predicted state
    refused_rows = np.flatnonzero(curves.refused)
    if len(refused_rows):
        curves.slopes[refused_rows] = _slopes(
            residuals, predicted_state[refused_rows], curves.point[refused_rows]
        )
    corrected_state, corrections = _corrected(residuals, curves, predicted_state, tolerance)
    reached_rows = np.flatnonzero(corrections <= _MAX_CORRECTIONS)
    slopes = _slopes(residuals, corrected_state[reached_rows], curves.point[reached_rows])
    tangent = _tangent(slopes, curves.tangent[reached_rows])
    cosine = np.einsum("pi,pi->p", tangent, curves.tangent[reached_rows])
    smallest_cosine = np.where(curves.step[reached_rows] < kink, 0.0, _SMALLEST_COSINE)
    turns_little = cosine > smallest_cosine
    accepted_rows = reached_rows[turns_little]
    accepted = np.zeros(len(curves.point), dtype=bool)
    accepted[accepted_rows] = True
    may_be_longer = np.zeros(len(curves.point), dtype=bool)
    may_be_longer[reached_rows] = (cosine > _STRAIGHT_COSINE) & (
        corrections[reached_rows] < _MANY_CORRECTIONS
    )
    length = np.linalg.norm(corrected_state[accepted_rows] - curves.state[accepted_rows], axis=1)[
        :, np.newaxis
    ]
    curves.curvature[accepted_rows] = (
        tangent[turns_little] - curves.tangent[accepted_rows]
    ) / length
    curves.state[accepted_rows] = corrected_state[accepted_rows]
    curves.slopes[accepted_rows] = slopes[turns_little]
    curves.tangent[accepted_rows] = tangent[turns_little]
    curves.refused[:] = ~accepted
    factor = np.where(accepted, np.where(may_be_longer, _LONGER, 1.0), _SHORTER)
    curves.step[:] = np.minimum(curves.step * factor, _LONGEST_STEP)
    return accepted


def _corrected(
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
    corrections = np.full(len(state), _MAX_CORRECTIONS + 1)
    inverse = np.linalg.inv(_bordered(curves.slopes, curves.tangent))
    unfinished = np.arange(len(state))
    residual = _with_zero(residuals(state, curves.point))
    for correction in range(_MAX_CORRECTIONS + 1):
        largest_residual = np.abs(residual).max(axis=1)
        has_reached = largest_residual <= tolerance
        corrections[unfinished[has_reached]] = correction
        is_unfinished = ~has_reached & np.isfinite(largest_residual)
        unfinished = unfinished[is_unfinished]
        residual = residual[is_unfinished]
        inverse = inverse[is_unfinished]
        if len(unfinished) == 0 or correction == _MAX_CORRECTIONS:
            break
        change = -np.einsum("pij,pj->pi", inverse, residual)
        # a longer correction could end on another part of the curve
        length = np.linalg.norm(change, axis=1)
        change *= (_LONGEST_STEP / np.maximum(length, _LONGEST_STEP))[:, np.newaxis]
        state[unfinished] += change
        new_residual = _with_zero(residuals(state[unfinished], curves.point[unfinished]))
        inverse = broyden_update(inverse, change, new_residual - residual)
        residual = new_residual
    return state, corrections


def _with_zero(residual: FloatArray) -> FloatArray:
    """Residuals and a zero for the plane normal to the tangent, in which corrections remain."""
    return np.concatenate([residual, np.zeros((*residual.shape[:-1], 1))], axis=-1)


def _bordered(slopes: FloatArray, tangent: FloatArray) -> FloatArray:
    """Square matrices: derivatives of the residuals, and of the distance along the tangent."""
    return np.concatenate([slopes, tangent[:, np.newaxis]], axis=1)


def _tangent(slopes: FloatArray, direction: FloatArray) -> FloatArray:
    """Unit vectors along which the residuals are constant, on the side of `direction`."""
    right_side = np.zeros(direction.shape)
    right_side[:, -1] = 1.0
    matrix = _bordered(slopes, direction)
    tangent = np.linalg.solve(matrix, right_side[..., np.newaxis])[..., 0]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))


def _slopes(
    residuals: Callable[[FloatArray, IndexArray], FloatArray], state: FloatArray, which: IndexArray
) -> FloatArray:
    """Derivatives of the residuals, (points, unknowns, unknowns + 1), from one call of them."""
    coordinate_count = state.shape[1]
    # the first row moves nothing, each other row moves one coordinate
    moved = (
        state + np.eye(coordinate_count + 1, coordinate_count, k=-1)[:, np.newaxis] * _DIFFERENCE
    )
    values = residuals(moved, which)
    return np.moveaxis((values[1:] - values[0]) / _DIFFERENCE, 0, -1)


def _crossings(
    old_state: FloatArray,
    new_state: FloatArray,
    old_tangent: FloatArray,
    new_tangent: FloatArray,
    length: FloatArray,
    wanted: float,
) -> tuple[IndexArray, FloatArray]:
    """Crossings of a value of the last coordinate by the cubics between two states of each curve.

    Returns:
        Row of the curve of each crossing, and the interpolated states.
    """
    old_derivative = old_tangent * length[:, np.newaxis]
    new_derivative = new_tangent * length[:, np.newaxis]
    state_change = new_state - old_state
    # coefficients of t^3, t^2, t and 1, for t from 0 to 1 (Hermite)
    cubic_coefficient = old_derivative + new_derivative - 2 * state_change
    square_coefficient = 3 * state_change - 2 * old_derivative - new_derivative
    coefficients = np.stack([cubic_coefficient, square_coefficient, old_derivative, old_state])
    # of the parameter's distance from the wanted value
    distance_coefficients = coefficients[..., -1].copy()
    distance_coefficients[3] -= wanted
    # a cubic is within the hull of its Bezier points: it has a root only if they enclose 0
    old_distance = distance_coefficients[3]
    new_distance = distance_coefficients.sum(axis=0)
    bezier = np.stack(
        [
            old_distance,
            old_distance + distance_coefficients[2] / 3,
            new_distance - new_derivative[:, -1] / 3,
            new_distance,
        ]
    )
    may_cross = (bezier.min(axis=0) <= 0) & (bezier.max(axis=0) >= 0)
    crossing_rows = []
    crossing_shares = []
    for row in np.flatnonzero(may_cross):
        roots = np.roots(distance_coefficients[:, row])
        real_roots = np.sort(roots[np.abs(roots.imag) < _ROUNDING].real)
        for root in real_roots[(real_roots > 0) & (real_roots <= 1)]:
            crossing_rows.append(row)
            crossing_shares.append(root)
    rows = np.array(crossing_rows, dtype=np.intp)
    # share of the step at each crossing
    t = np.array(crossing_shares)[:, np.newaxis]
    a, b, c, d = coefficients[:, rows]
    return rows, np.asarray(((a * t + b) * t + c) * t + d)
