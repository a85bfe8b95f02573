"""Newton's method for many bearings at once.

Every ball has unknowns of its own, and the bearing has a few that all balls share. Balls depend on
each other through these only, so the Jacobian has the shape of an arrow and is solved ball by ball.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from oilfilm.units import BoolArray, FloatArray

IntArray = npt.NDArray[np.int64]

# Largest residual of a root.
_TOLERANCE = 1e-10
# Step of a derivative, relative to the scale of its unknown.
_DIFFERENCE = 1e-7
# Longest step of an unknown, in its scale; a longer one is shortened as a whole.
_LONGEST_STEP = 0.3
# Steps with one Jacobian; those after the first must lower the residual to this share.
_CHORDS, _CHORD_GAIN = 3, 0.2
# With so few balls a Jacobian costs hardly more than the residuals alone: each step gets its own.
_FEW = 16
# By how much a step may raise the residual in the first half of the iterations: a ball that must
# travel along its groove first leaves it by more than the contacts are pressed together.
_GROWTH = 1e3
# Shares of the difficult part of the equations on the way to the whole, where a start fails.
_SHARES = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
# How often the points that still fail start again beside one that was solved.
_ROUNDS = 3
# Damping with which settling begins, and below which there is none.
_FIRST_DAMPING, _LEAST_DAMPING = 0.1, 1e-6
_SHORT_STEP = 0.1
_NEWTON = 15

# Keeps a ball that touches nothing, and so feels nothing, from making the equations singular.
_LEAST_STIFFNESS = 1e-12


class Equations(Protocol):
    """Residuals of many bearings."""

    def __call__(
        self, own: FloatArray, shared: FloatArray, which: IntArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Residuals of the balls, each ball's part in those of the bearing, and the rest of them.

        Args:
            own: Unknowns of the balls, shape (..., points, balls, own unknowns).
            shared: Unknowns of the bearing, shape (..., points, shared unknowns).
            which: Which points these are, shape (points,).

        Returns:
            Shapes (..., points, balls, own unknowns), (..., points, balls, shared unknowns) and
            (..., points, shared unknowns); the bearing's residuals are the sum of the second over
            the balls, plus the third.
        """
        ...


@dataclass(frozen=True)
class Solution:
    """Where the iteration ended.

    Attributes:
        own: Unknowns of the balls, shape (points, balls, own unknowns).
        shared: Unknowns of the bearing, shape (points, shared unknowns).
        residual: Largest residual of each point, in the equations' own scale.
        converged: True where `residual` fell to 1e-10.
    """

    own: FloatArray
    shared: FloatArray
    residual: FloatArray
    converged: BoolArray

    def at(self, which: IntArray) -> "Solution":
        """The same at some of the points."""
        return Solution(**{name: values[which] for name, values in vars(self).items()})


def solve(
    equations: Equations,
    own: FloatArray,
    shared: FloatArray,
    own_scale: FloatArray,
    shared_scale: FloatArray,
    max_iterations: int,
) -> Solution:
    """Roots of the equations of many points, by damped Newton steps of each.

    Residuals are to be of order 1 and to push their unknown: dx/dt = residual must be a stable
    motion. Where a Newton step fails, damping turns it into an implicit step of that motion
    (pseudo-transient continuation), which ends in the state that the balls would settle in.

    Args:
        equations: Residuals; a step shorter than 1e-7 of an unknown's scale is not resolved.
        own: Start of the balls' unknowns, shape (points, balls, own unknowns).
        shared: Start of the bearing's unknowns, shape (points, shared unknowns).
        own_scale: Scale of `own`, shape (points, own unknowns).
        shared_scale: Scale of `shared`, of its shape.
        max_iterations: Jacobians after which a point is given up.

    Reference: C. T. Kelley and D. E. Keyes, Convergence analysis of pseudo-transient continuation,
        SIAM J. Numer. Anal. 35 (1998) 508.
    """
    start = own, shared
    own, shared = own.copy(), shared.copy()
    damping, residual = np.zeros(len(own)), np.full(len(own), np.inf)
    active = np.arange(len(own))
    few = own.shape[0] * own.shape[1] <= _FEW
    known: tuple[_Jacobian, _State] | None = None
    for number in range(max_iterations):
        settling = number >= _NEWTON
        allowed = np.inf if settling else _GROWTH
        if number == _NEWTON:
            damping[active] = _FIRST_DAMPING
            own[active], shared[active] = start[0][active], start[1][active]
            known = None
        scales = own_scale[active], shared_scale[active]
        jacobian, state = known or _linearised(
            equations, own[active], shared[active], scales, active
        )
        for chord in range(1 if few else _CHORDS):
            step_own, step_shared, length = _step(jacobian, state, damping[active])
            at = (
                state.own + step_own * scales[0][:, np.newaxis],
                state.shared + step_shared * scales[1],
            )
            if few:
                next_jacobian, trial = _linearised(equations, *at, scales, active)
            else:
                of_balls, parts, rest = equations(*at, active)
                trial = _state(*at, of_balls, parts.sum(axis=-2) + rest)
            better = trial.size < state.size * (allowed if chord == 0 else _CHORD_GAIN)
            if chord == 0:
                damping[active] = _next_damping(damping[active], better, length, settling)
            state = _chosen(better, trial, state)
            if few:
                jacobian = _chosen(better, next_jacobian, jacobian)
            if not better.any() or state.size.max() <= _TOLERANCE:
                break
        own[active], shared[active], residual[active] = state.own, state.shared, state.size
        going = state.size > _TOLERANCE
        active = active[going]
        if len(active) == 0:
            break
        if few:
            known = _chosen_rows(jacobian, going), _chosen_rows(state, going)
    return Solution(own, shared, residual, residual <= _TOLERANCE)


def of_some(equations: Equations, points: IntArray) -> Equations:
    """The equations of some of the points, numbered from 0 again."""

    def of_points(
        own: FloatArray, shared: FloatArray, which: IntArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        return equations(own, shared, points[which])

    return of_points


def follow(
    equations: Callable[[float], Equations],
    own: FloatArray,
    shared: FloatArray,
    own_scale: FloatArray,
    shared_scale: FloatArray,
    max_iterations: int,
    position: FloatArray,
) -> Solution:
    """`solve`, and where that fails again from elsewhere.

    First a part of the equations is brought in by and by; then the search starts from where the
    nearest point that was solved ended.

    Args:
        equations: The equations with a share, 0 to 1, of their difficult part; 1 is the whole.
        own: As for `solve`, and so are the others.
        shared: As for `solve`.
        own_scale: As for `solve`.
        shared_scale: As for `solve`.
        max_iterations: As for `solve`, for each search.
        position: Coordinates in which near points have similar solutions, shape (points, any).
    """
    solution = solve(equations(1.0), own, shared, own_scale, shared_scale, max_iterations)

    def again(
        points: IntArray, own: FloatArray, shared: FloatArray, share: float = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        part = of_some(equations(share), points)
        end = solve(part, own, shared, own_scale[points], shared_scale[points], max_iterations)
        if share == 1:
            solution.own[points], solution.shared[points] = end.own, end.shared
            solution.residual[points], solution.converged[points] = end.residual, end.converged
        return end.own, end.shared

    failed = np.flatnonzero(~solution.converged)
    if len(failed):
        here = own[failed], shared[failed]
        for share in _SHARES:
            here = again(failed, *here, share)
    for _ in range(_ROUNDS):
        failed, solved = np.flatnonzero(~solution.converged), np.flatnonzero(solution.converged)
        if len(failed) == 0 or len(solved) == 0:
            break
        away = np.square(position[failed, np.newaxis] - position[solved]).sum(axis=-1)
        nearest = solved[away.argmin(axis=1)]
        relative = solution.own[nearest] / own_scale[nearest, np.newaxis]
        again(
            failed,
            relative * own_scale[failed, np.newaxis],
            solution.shared[nearest] / shared_scale[nearest] * shared_scale[failed],
        )
    return solution


class _State(NamedTuple):
    """Unknowns of the active points, the residuals there, and the largest of each point."""

    own: FloatArray
    shared: FloatArray
    own_residual: FloatArray
    shared_residual: FloatArray
    size: FloatArray


class _Jacobian(NamedTuple):
    """Minus the derivatives of the residuals by the unknowns in their scale, by block."""

    own_own: FloatArray
    own_shared: FloatArray
    shared_own: FloatArray
    shared_shared: FloatArray


def _state(own: FloatArray, shared: FloatArray, r: FloatArray, s: FloatArray) -> _State:
    size = np.maximum(np.abs(r).max(axis=(1, 2)), np.abs(s).max(axis=1))
    return _State(own, shared, r, s, np.where(np.isfinite(size), size, np.inf))


_Parts = TypeVar("_Parts", _State, _Jacobian)


def _chosen(better: BoolArray, new: _Parts, old: _Parts) -> _Parts:
    """Of each point the new parts where they are better."""
    if better.all():
        return new
    return type(new)(
        *(
            np.where(better.reshape(-1, *(1,) * (new_part.ndim - 1)), new_part, old_part)
            for new_part, old_part in zip(new, old, strict=True)
        )
    )


def _chosen_rows(parts: _Parts, which: BoolArray) -> _Parts:
    """The parts of some points."""
    return parts if which.all() else type(parts)(*(part[which] for part in parts))


def _linearised(
    equations: Equations,
    own: FloatArray,
    shared: FloatArray,
    scales: tuple[FloatArray, FloatArray],
    which: IntArray,
) -> tuple[_Jacobian, _State]:
    """Jacobian by forward differences and the residuals, all of it in one call.

    Balls are independent: one unknown of all balls is changed at a time.
    """
    n_own, n_shared = own.shape[-1], shared.shape[-1]
    owns = np.repeat(own[np.newaxis], 1 + n_own + n_shared, axis=0)
    shareds = np.repeat(shared[np.newaxis], 1 + n_own + n_shared, axis=0)
    for unknown in range(n_own):
        owns[1 + unknown, ..., unknown] += _DIFFERENCE * scales[0][:, unknown, np.newaxis]
    for unknown in range(n_shared):
        shareds[1 + n_own + unknown, :, unknown] += _DIFFERENCE * scales[1][:, unknown]
    of_balls, parts, rest = equations(owns, shareds, which)
    of_bearing = parts.sum(axis=-2) + rest
    minus = np.moveaxis((of_balls[0] - of_balls[1:]) / _DIFFERENCE, 0, -1)
    minus_parts = np.moveaxis((parts[0] - parts[1:]) / _DIFFERENCE, 0, -1)
    minus_bearing = np.moveaxis((of_bearing[0] - of_bearing[1:]) / _DIFFERENCE, 0, -1)
    jacobian = _Jacobian(
        minus[..., :n_own],
        minus[..., n_own:],
        minus_parts[..., :n_own],
        minus_bearing[..., n_own:],
    )
    return jacobian, _state(own, shared, of_balls[0], of_bearing[0])


def _step(
    jacobian: _Jacobian, state: _State, damping: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The step of all unknowns, in their scale, and how long it was before it was shortened."""
    stiffness = (damping + _LEAST_STIFFNESS)[:, np.newaxis, np.newaxis]
    n_own, n_shared = state.own.shape[-1], state.shared.shape[-1]
    own_own = jacobian.own_own + stiffness[..., np.newaxis] * np.eye(n_own)
    known = np.concatenate([-jacobian.own_shared, state.own_residual[..., np.newaxis]], axis=-1)
    answered = np.linalg.solve(own_own, known)
    through, alone = answered[..., :n_shared], answered[..., n_shared]
    felt = np.einsum("pbqm,pbmk->pqk", jacobian.shared_own, answered)
    shared_shared = jacobian.shared_shared + stiffness * np.eye(n_shared) + felt[..., :n_shared]
    force = state.shared_residual - felt[..., n_shared]
    shared = np.linalg.solve(shared_shared, force[..., np.newaxis])[..., 0]
    own = alone + np.einsum("pbmk,pk->pbm", through, shared)
    length = np.maximum(np.abs(own).max(axis=(1, 2)), np.abs(shared).max(axis=1))
    share = np.minimum(1.0, _LONGEST_STEP / np.maximum(length, _DIFFERENCE))
    return own * share[:, np.newaxis, np.newaxis], shared * share[:, np.newaxis], length


def _next_damping(
    damping: FloatArray, better: BoolArray, length: FloatArray, settling: bool
) -> FloatArray:
    """Half as much where the last step was short, more where it was too long or led nowhere."""
    if not settling:
        return damping
    far = ~better | ~(length < _LONGEST_STEP)
    changed = np.where(far, damping * 4, np.where(length < _SHORT_STEP, damping / 4, damping))
    return np.where(changed < _LEAST_DAMPING, 0.0, np.maximum(changed, 0.0))
