"""Newton's method for many bearings at once, each with a few unknowns of its own."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.units import BoolArray, FloatArray, IndexArray

# Largest residual of a root.
TOLERANCE = 1e-10
# Step of a derivative, relative to the scale of its unknown.
_DIFFERENCE = 1e-7
# Longest step of an unknown, in its scale; a longer one is shortened as a whole.
_LONGEST_STEP = 0.3
# Steps with one Jacobian; those after the first must lower the residual to this share.
_CHORDS, _CHORD_GAIN = 3, 0.2
# By how much a step may raise the residual in the first half of the iterations: a ball that must
# travel along its groove first leaves it by more than the contacts are pressed together.
_GROWTH = 1e3
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
            on = better & (new_size > TOLERANCE)
            if not on.any():
                break
            going, x, unit = going[on], trial[on], unit[on]
            residual, inverse = residual[on], inverse[on]
        active = active[size[active] > TOLERANCE]
        if len(active) == 0:
            break
    return Solution(unknowns, size, size <= TOLERANCE)


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
        size[going] = _size(residual)
        step = np.einsum("pij,pj->pi", inverse, residual)
        length = np.abs(step).max(axis=1)
        step *= np.minimum(1.0, _LONGEST_STEP / np.maximum(length, _DIFFERENCE))[:, np.newaxis]
        x = x + step * unit
        # The step from a root is not checked: its residuals would be rounding, of which an updated
        # inverse would make a direction.
        unknowns[going] = x
        on = (size[going] > _POLISHED) & np.isfinite(size[going])
        going, x, unit = going[on], x[on], unit[on]
        if len(going) == 0:
            break
        moved = equations(x, going)
        inverse = broyden_update(inverse[on], step[on], residual[on] - moved)
        residual = moved
    return Solution(unknowns, size, size <= TOLERANCE)


def broyden_update(inverse: FloatArray, step: FloatArray, change: FloatArray) -> FloatArray:
    """The nearest inverse Jacobian that gives a step by the change of residuals that it brought.

    Args:
        inverse: Of each point, shape (points, n, n).
        step: Of the unknowns, shape (points, n).
        change: Of the residuals, shape (points, n).
    """
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
