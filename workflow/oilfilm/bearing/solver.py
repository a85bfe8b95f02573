"""Newton's method for many bearings at once, each with a few unknowns of its own."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.units import BoolArray, FloatArray, IndexArray

# Largest residual of a root.
_TOLERANCE = 1e-10
# Step of a derivative, relative to the scale of its unknown.
_DIFFERENCE = 1e-7
# Longest step of an unknown, in its scale; a longer one is shortened as a whole.
_LONGEST_STEP = 0.3
# Steps with one Jacobian; those after the first must lower the residual to this share.
_CHORDS, _CHORD_GAIN = 3, 0.2
# By how much a step may raise the residual in the first half of the iterations: a ball that must
# travel along its groove first leaves it by more than the contacts are pressed together.
_GROWTH = 1e3
# Shares of the difficult part of the equations on the way to the whole, where a start fails.
_SHARES = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
# Jacobians of a share that is not the whole.
_ON_THE_WAY = 40
# How often the points that still fail start again beside one that was solved.
_ROUNDS = 2
# Damping with which settling begins, and below which there is none.
_FIRST_DAMPING, _LEAST_DAMPING = 0.1, 1e-6
_SHORT_STEP = 0.1
_NEWTON = 15

# Steps of Broyden's method, and the residual at which they end: it must not show in the results.
_UPDATES, _POLISHED = 20, 1e-12

# Keeps a ball that touches nothing, and so feels nothing, from making the equations singular.
_LEAST_STIFFNESS = 1e-12


# Residuals of many bearings: from unknowns, shape (..., points, unknowns), and the numbers of the
# points they belong to, to residuals of the same shape.
Equations = Callable[[FloatArray, IndexArray], FloatArray]


@dataclass(frozen=True)
class Solution:
    """Where the iteration ended.

    Attributes:
        unknowns: Shape (points, unknowns).
        residual: Largest residual of each point, in the equations' own scale.
        converged: True where `residual` fell to 1e-10.
    """

    unknowns: FloatArray
    residual: FloatArray
    converged: BoolArray

    def put(self, which: IndexArray, other: "Solution") -> None:
        """Replace some of the points."""
        for name, values in vars(self).items():
            values[which] = getattr(other, name)


def solve(
    equations: Equations, start: FloatArray, scale: FloatArray, max_iterations: int
) -> Solution:
    """Roots of the equations of many points, by damped Newton steps of each.

    Residuals are to be of order 1 and to push their unknown: dx/dt = residual must be a stable
    motion. Where a Newton step fails, damping turns it into an implicit step of that motion
    (pseudo-transient continuation), which ends in the state that the balls would settle in.

    Args:
        equations: Residuals; a step shorter than 1e-7 of an unknown's scale is not resolved.
        start: Start of the unknowns, shape (points, unknowns).
        scale: Their scale, of the same shape.
        max_iterations: Jacobians after which a point is given up.

    Reference: C. T. Kelley and D. E. Keyes, Convergence analysis of pseudo-transient continuation,
        SIAM J. Numer. Anal. 35 (1998) 508.
    """
    unknowns = start.copy()
    damping, size = np.zeros(len(start)), np.full(len(start), np.inf)
    active = np.arange(len(start))
    for number in range(max_iterations):
        settling = number >= _NEWTON
        if number == _NEWTON:
            damping[active], unknowns[active] = _FIRST_DAMPING, start[active]
        # each point steps with one Jacobian for as long as that helps
        going, x, unit = active, unknowns[active], scale[active]
        residual, jacobian = _linearised(equations, x, unit, going)
        size[going] = _size(residual)
        stiffness = (damping[going] + _LEAST_STIFFNESS)[:, np.newaxis, np.newaxis]
        inverse = np.linalg.inv(stiffness * np.eye(x.shape[1]) - jacobian)
        for chord in range(_CHORDS):
            step = np.einsum("pij,pj->pi", inverse, residual)
            length = np.abs(step).max(axis=1)
            share = np.minimum(1.0, _LONGEST_STEP / np.maximum(length, _DIFFERENCE))
            trial = x + share[:, np.newaxis] * step * unit
            residual = equations(trial, going)
            new_size = _size(residual)
            allowed = (np.inf if settling else _GROWTH) if chord == 0 else _CHORD_GAIN
            better = new_size < size[going] * allowed
            if chord == 0 and settling:
                damping[going] = _next_damping(damping[going], better, length)
            unknowns[going[better]], size[going[better]] = trial[better], new_size[better]
            on = better & (new_size > _TOLERANCE)
            if not on.any():
                break
            going, x, unit = going[on], trial[on], unit[on]
            residual, inverse = residual[on], inverse[on]
        active = active[size[active] > _TOLERANCE]
        if len(active) == 0:
            break
    return Solution(unknowns, size, size <= _TOLERANCE)


def near(
    equations: Equations, start: FloatArray, scale: FloatArray, inverse: FloatArray
) -> Solution:
    """Roots close to known ones, by Broyden's method: an evaluation per step, no Jacobian.

    Args:
        equations: As for `solve`.
        start: Roots of similar equations, shape (points, unknowns).
        scale: As for `solve`.
        inverse: Of the Jacobian there, by `inverse_jacobian`: (points, unknowns, unknowns).

    Reference: C. G. Broyden, A class of methods for solving nonlinear simultaneous equations,
        Math. Comput. 19 (1965) 577.
    """
    unknowns, size = start.copy(), np.full(len(start), np.inf)
    going, x, unit = np.arange(len(start)), start, scale
    residual = equations(x, going)
    for _ in range(_UPDATES):
        step = np.einsum("pij,pj->pi", inverse, residual)
        length = np.abs(step).max(axis=1)
        step *= np.minimum(1.0, _LONGEST_STEP / np.maximum(length, _DIFFERENCE))[:, np.newaxis]
        x = x + step * unit
        change = residual - (residual := equations(x, going))
        inverse = _updated(inverse, step, change)
        size[going] = now = _size(residual)
        # the step that the last residual asks for needs no check
        unknowns[going] = x + np.einsum("pij,pj->pi", inverse, residual) * unit
        on = (now > _POLISHED) & np.isfinite(now)
        if not on.any():
            break
        going, x, unit, inverse, residual = going[on], x[on], unit[on], inverse[on], residual[on]
    return Solution(unknowns, size, size <= _TOLERANCE)


def _updated(inverse: FloatArray, step: FloatArray, change: FloatArray) -> FloatArray:
    """The nearest inverse that gives the last step by the change of residuals that it brought."""
    expected = np.einsum("pij,pj->pi", inverse, change)
    row = np.einsum("pi,pij->pj", step, inverse)
    along = np.einsum("pi,pi->p", step, expected)
    weight = np.divide(1.0, along, out=np.zeros_like(along), where=along != 0)
    return np.asarray(inverse + np.einsum("p,pi,pj->pij", weight, step - expected, row))


def inverse_jacobian(equations: Equations, unknowns: FloatArray, scale: FloatArray) -> FloatArray:
    """What turns residuals into Newton steps in the unknowns' scale, shape (points, n, n)."""
    _, jacobian = _linearised(equations, unknowns, scale, np.arange(len(unknowns)))
    stiff = _LEAST_STIFFNESS * np.eye(unknowns.shape[1]) - jacobian
    return np.asarray(np.linalg.inv(stiff), dtype=np.float64)


def follow(
    equations: Callable[[float], Equations],
    start: FloatArray,
    scale: FloatArray,
    max_iterations: int,
    position: FloatArray,
) -> Solution:
    """`solve`, and where that fails again from elsewhere.

    First a part of the equations is brought in by and by; then from where the nearest point that
    was solved ended.

    Args:
        equations: The equations with a share, 0 to 1, of their difficult part; 1 is the whole.
        start: As for `solve`.
        scale: As for `solve`.
        max_iterations: As for `solve`, for each search.
        position: Coordinates in which near points have similar solutions, shape (points, any).
    """
    solution = solve(equations(1.0), start, scale, max_iterations)
    failed = np.flatnonzero(~solution.converged)

    def again(start: FloatArray, share: float = 1.0) -> FloatArray:
        most = max_iterations if share == 1 else min(max_iterations, _ON_THE_WAY)
        end = solve(_of_some(equations(share), failed), start, scale[failed], most)
        if share == 1:
            solution.put(failed, end)
        return end.unknowns

    here = start[failed]
    for share in _SHARES if len(failed) else ():
        here = again(here, share)
    for _ in range(_ROUNDS):
        failed, solved = (np.flatnonzero(solution.converged == way) for way in (False, True))
        if len(failed) == 0 or len(solved) == 0:
            break
        away = np.square(position[failed, np.newaxis] - position[solved]).sum(axis=-1)
        nearest = solved[away.argmin(axis=1)]
        again(solution.unknowns[nearest] / scale[nearest] * scale[failed])
    return solution


def _of_some(equations: Equations, points: IndexArray) -> Equations:
    """The equations of some of the points, numbered from 0 again."""
    return lambda unknowns, which: equations(unknowns, points[which])


def _linearised(
    equations: Equations, unknowns: FloatArray, scale: FloatArray, which: IndexArray
) -> tuple[FloatArray, FloatArray]:
    """Residuals and their derivatives by the unknowns in their scale, all of it in one call."""
    count = unknowns.shape[1]
    steps = np.eye(count + 1, count, k=-1)[:, np.newaxis] * _DIFFERENCE * scale
    residuals = equations(unknowns + steps, which)
    slopes = (residuals[1:] - residuals[0]) / _DIFFERENCE
    return residuals[0], np.moveaxis(slopes, 0, -1)


def _size(residuals: FloatArray) -> FloatArray:
    """The largest residual of each point; infinite where one is no number."""
    size = np.abs(residuals).max(axis=-1)
    return np.where(np.isfinite(size), size, np.inf)


def _next_damping(damping: FloatArray, better: BoolArray, length: FloatArray) -> FloatArray:
    """Less where the last step was short, more where it was too long or led nowhere."""
    far = ~better | ~(length < _LONGEST_STEP)
    changed = np.where(far, damping * 4, np.where(length < _SHORT_STEP, damping / 4, damping))
    return np.where(changed < _LEAST_DAMPING, 0.0, changed)
