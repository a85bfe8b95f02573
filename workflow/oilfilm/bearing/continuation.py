"""Curves of solutions, followed through their folds: pseudo-arclength continuation.

Equations with one parameter more than they need have a curve of solutions. It is followed by its
length, not by its parameter, so that it may turn back. Many points are followed in one call, each
by itself: no point takes anything from another.

References: H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in
    P. Rabinowitz (ed.), Applications of Bifurcation Theory (1977) 359; E. L. Allgower and K. Georg,
    Introduction to Numerical Continuation Methods (2003), chapters 2, 6 and 7.

Decides: how a curve of solutions is followed, and where it passes a value of its parameter.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.bearing.solver import broyden_update
from oilfilm.units import BoolArray, FloatArray, IndexArray

# Residuals from unknowns, shape (..., points, unknowns), the parameter, shape (..., points), and
# the numbers of the points they belong to.
ParametricEquations = Callable[[FloatArray, FloatArray, IndexArray], FloatArray]

# Step of a derivative, in the scaled unknowns and in the parameter.
_DIFFERENCE = 1e-7
# Steps along a curve: the first, the shortest and the longest, in the scaled unknowns.
_FIRST_STEP, _SHORTEST_STEP, _LONGEST_STEP = 0.05, 1e-6, 0.4
# Steps of a curve, refused ones included, after which it is given up.
_MOST_STEPS = 600
# Corrections of a predicted point before the step is refused; with so many it is not lengthened.
_MOST_CORRECTIONS, _MANY_CORRECTIONS = 6, 4
# Cosine of the angle between two tangents: below the first a step is refused, above the second the
# next one is longer.
_LEAST_COSINE, _STRAIGHT = 0.9, 0.97
_LONGER, _SHORTER = 1.7, 0.4


@dataclass(frozen=True)
class Crossings:
    """Where curves pass the wanted value of the parameter.

    Attributes:
        point: Number of the point whose curve it is, rising, shape (crossings,).
        unknowns: Near the solution, as interpolated on the curve, shape (crossings, unknowns).
        ended: Points whose curve came to the last value of the parameter, shape (points,).
        returned: Points whose curve turned back to the first one.
        end: Where the curves end, shape (points, unknowns).
        end_parameter: The parameter there, shape (points,).
    """

    point: IndexArray
    unknowns: FloatArray
    ended: BoolArray
    returned: BoolArray
    end: FloatArray
    end_parameter: FloatArray


@dataclass
class _Curves:
    """Curves under way, one row per curve.

    Attributes:
        point: Number of each curve's point.
        here: Scaled unknowns and parameter, shape (curves, unknowns + 1).
        slopes: Derivatives of the residuals there, shape (curves, unknowns, unknowns + 1).
        tangent: Unit tangent there, shape (curves, unknowns + 1).
        bend: Derivative of the tangent by length, estimated from the last step.
        step: Length of the next step.
        refused: Whether the last step was refused.
    """

    point: IndexArray
    here: FloatArray
    slopes: FloatArray
    tangent: FloatArray
    bend: FloatArray
    step: FloatArray
    refused: BoolArray

    def keep(self, which: BoolArray) -> "_Curves":
        """Some of the curves."""
        return _Curves(**{name: values[which] for name, values in vars(self).items()})


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
    """Every crossing of a value of the parameter by the curves of solutions through some points.

    A curve begins with a rising parameter and ends where the parameter passes `first` or `last`.
    Between two of its points it is a cubic of its length (Hermite), so that a pair of
    crossings within one step is seen.

    Args:
        equations: The residuals, smooth and of order 1.
        start: Solutions at `parameter`, shape (points, unknowns).
        scale: Scale of the unknowns, of the same shape.
        parameter: Of the solutions at the start, shape (points,).
        wanted: Value of the parameter of which crossings are looked for.
        first: Value of the parameter at which curves end that have turned back.
        last: Value of the parameter at which the others end, `wanted` or above.
        kink: Steps shorter than this may turn by any acute angle: at a kink of the residuals no
            step is short enough to turn little.
        tolerance: Largest residual of a point on its curve. Crossings are only interpolated.
    """
    count, size = start.shape
    unit = np.column_stack([scale, np.ones(count)])
    here = np.column_stack([start / scale, parameter])

    def residuals(state: FloatArray, which: IndexArray) -> FloatArray:
        return equations(state[..., :size] * scale[which], state[..., size], which)

    along_parameter = np.zeros((count, size + 1))
    along_parameter[:, size] = 1.0
    slopes = _slopes(residuals, here, np.arange(count))
    curves = _Curves(
        point=np.arange(count),
        here=here.copy(),
        slopes=slopes,
        tangent=_tangent(slopes, along_parameter),
        bend=np.zeros_like(here),
        step=np.full(count, _FIRST_STEP),
        refused=np.zeros(count, dtype=bool),
    )
    found: list[tuple[IndexArray, FloatArray]] = []
    ended, returned = (np.zeros(count, dtype=bool) for _ in range(2))
    for _ in range(_MOST_STEPS):
        if len(curves.point) == 0:
            break
        before, left = curves.here.copy(), curves.tangent.copy()
        accepted = _advance(residuals, curves, kink, tolerance)
        length = np.linalg.norm(curves.here - before, axis=1)
        crossed = _crossings(before, curves.here, left, curves.tangent, length, wanted)
        of_step = accepted[crossed[0]]
        found.append((curves.point[crossed[0][of_step]], crossed[1][of_step]))
        level = curves.here[:, size]
        arrived = accepted & (level >= last)
        back = accepted & (level < first)
        ended[curves.point[arrived]] = True
        returned[curves.point[back]] = True
        here[curves.point] = curves.here
        stalled = ~(curves.step >= _SHORTEST_STEP)
        curves = curves.keep(~(arrived | back | stalled))
    point = np.concatenate([numbers for numbers, _ in found]) if found else np.arange(0)
    states = np.concatenate([values for _, values in found]) if found else np.empty((0, size + 1))
    order = np.argsort(point, kind="stable")
    unknowns = (states * unit[point])[:, :size]
    end = (here * unit)[:, :size]
    return Crossings(point[order], unknowns[order], ended, returned, end, here[:, size])


def _advance(
    residuals: Callable[[FloatArray, IndexArray], FloatArray],
    curves: _Curves,
    kink: float,
    tolerance: float,
) -> BoolArray:
    """One step of each curve, in place; true where it was accepted."""
    step = curves.step[:, np.newaxis]
    predicted = curves.here + step * curves.tangent + step**2 / 2 * curves.bend
    # the slopes of the point before lead astray where they led astray already
    again = np.flatnonzero(curves.refused)
    if len(again):
        curves.slopes[again] = _slopes(residuals, predicted[again], curves.point[again])
    corrected, corrections = _corrected(residuals, curves, predicted, tolerance)
    reached = np.flatnonzero(corrections <= _MOST_CORRECTIONS)
    slopes = _slopes(residuals, corrected[reached], curves.point[reached])
    tangent = _tangent(slopes, curves.tangent[reached])
    cosine = np.einsum("pi,pi->p", tangent, curves.tangent[reached])
    least = np.where(curves.step[reached] < kink, 0.0, _LEAST_COSINE)
    straight = cosine > least
    accepted = np.zeros(len(curves.point), dtype=bool)
    accepted[reached[straight]] = True
    longer = np.zeros(len(curves.point), dtype=bool)
    longer[reached] = (cosine > _STRAIGHT) & (corrections[reached] < _MANY_CORRECTIONS)
    forward = reached[straight]
    length = np.linalg.norm(corrected[forward] - curves.here[forward], axis=1)[:, np.newaxis]
    curves.bend[forward] = (tangent[straight] - curves.tangent[forward]) / length
    curves.here[forward] = corrected[forward]
    curves.slopes[forward] = slopes[straight]
    curves.tangent[forward] = tangent[straight]
    curves.refused[:] = ~accepted
    factor = np.where(accepted, np.where(longer, _LONGER, 1.0), _SHORTER)
    curves.step[:] = np.minimum(curves.step * factor, _LONGEST_STEP)
    return accepted


def _corrected(
    residuals: Callable[[FloatArray, IndexArray], FloatArray],
    curves: _Curves,
    predicted: FloatArray,
    tolerance: float,
) -> tuple[FloatArray, IndexArray]:
    """From predicted points to the curves, across the tangent, by Broyden's method.

    Returns:
        Where the corrections end, and how many they took: more than `_MOST_CORRECTIONS` where
        the curve was not reached.
    """
    state = predicted.copy()
    corrections = np.full(len(state), _MOST_CORRECTIONS + 1)
    inverse = np.linalg.inv(_bordered(curves.slopes, curves.tangent))
    going = np.arange(len(state))
    left = _with_zero(residuals(state, curves.point))
    for number in range(_MOST_CORRECTIONS + 1):
        size = np.abs(left).max(axis=1)
        arrived = size <= tolerance
        corrections[going[arrived]] = number
        on = ~arrived & np.isfinite(size)
        going, left, inverse = going[on], left[on], inverse[on]
        if len(going) == 0 or number == _MOST_CORRECTIONS:
            break
        change = -np.einsum("pij,pj->pi", inverse, left)
        # no correction is longer than the longest step: it would end on another part of the curve
        length = np.linalg.norm(change, axis=1)
        change *= np.minimum(1.0, _LONGEST_STEP / np.maximum(length, _DIFFERENCE))[:, np.newaxis]
        state[going] += change
        new = _with_zero(residuals(state[going], curves.point[going]))
        inverse = broyden_update(inverse, change, new - left)
        left = new
    return state, corrections


def _with_zero(left: FloatArray) -> FloatArray:
    """Residuals with that of the plane across the tangent, in which corrections stay."""
    return np.concatenate([left, np.zeros((*left.shape[:-1], 1))], axis=-1)


def _bordered(slopes: FloatArray, tangent: FloatArray) -> FloatArray:
    """Derivatives of the residuals, and of the distance along the tangent: square matrices."""
    return np.concatenate([slopes, tangent[:, np.newaxis]], axis=1)


def _tangent(slopes: FloatArray, towards: FloatArray) -> FloatArray:
    """Unit vectors along which the residuals do not change, on the side of `towards`."""
    along = np.zeros(towards.shape)
    along[:, -1] = 1.0
    tangent = np.linalg.solve(_bordered(slopes, towards), along[..., np.newaxis])[..., 0]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))


def _slopes(
    residuals: Callable[[FloatArray, IndexArray], FloatArray], state: FloatArray, which: IndexArray
) -> FloatArray:
    """Derivatives of the residuals, shape (points, unknowns, unknowns + 1), in one call."""
    count = state.shape[1]
    moved = state + np.eye(count + 1, count, k=-1)[:, np.newaxis] * _DIFFERENCE
    values = residuals(moved, which)
    return np.moveaxis((values[1:] - values[0]) / _DIFFERENCE, 0, -1)


def _crossings(
    first: FloatArray,
    last: FloatArray,
    tangent_first: FloatArray,
    tangent_last: FloatArray,
    length: FloatArray,
    wanted: float,
) -> tuple[IndexArray, FloatArray]:
    """Where the cubics between two points of each curve pass a value of the last coordinate.

    Returns:
        Rows of the curves, and the interpolated states.
    """
    slope_first = tangent_first * length[:, np.newaxis]
    slope_last = tangent_last * length[:, np.newaxis]
    rise = last - first
    # coefficients of t^3, t^2, t and 1, for t from 0 to 1 (Hermite)
    cubic = slope_first + slope_last - 2 * rise
    square = 3 * rise - 2 * slope_first - slope_last
    parts = np.stack([cubic, square, slope_first, first])
    of_level = parts[..., -1].copy()
    of_level[3] -= wanted
    rows, places = [], []
    # a cubic lies within its Bezier points: only where these enclose 0 it can be 0
    bezier = np.stack(
        [
            of_level[3],
            of_level[3] + of_level[2] / 3,
            of_level[:].sum(axis=0) - slope_last[:, -1] / 3,
            of_level.sum(axis=0),
        ]
    )
    for row in np.flatnonzero((bezier.min(axis=0) <= 0) & (bezier.max(axis=0) >= 0)):
        roots = np.roots(of_level[:, row])
        real = np.sort(roots[np.abs(roots.imag) < _ROUNDING].real)
        for place in real[(real > 0) & (real <= 1)]:
            rows.append(row)
            places.append(place)
    number = np.array(rows, dtype=np.intp)
    t = np.array(places)[:, np.newaxis]
    a, b, c, d = parts[:, number]
    return number, np.asarray(((a * t + b) * t + c) * t + d)


# Imaginary part of a root that is real but for rounding.
_ROUNDING = 1e-9
