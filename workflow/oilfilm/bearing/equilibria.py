"""Friction equilibria of a bearing: every steady motion, from the rolling cage through all folds.

Traction that falls with slip can hold a cage at several speeds: the film of a rolling contact pulls
hard enough, that of a skidding one no longer does. The curve of equilibria is followed in the share
s of everything beside traction (drag, rolling resistance, hysteresis, pockets, land, gyroscopic
moment). With none of it (s = 0) the cage rolls, and there is one equilibrium. The bearing is s = 1.

The search takes the cheap way where it is sure. Newton's method from a rolling cage is certified
where the inner contact slips less than the law's peak: traction has then risen with slip all the
way from s = 0, so that the curve has no fold before s = 1. Every point is solved by itself.

Reference: E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods (2003).

Decides: which equilibria a bearing has, and when a cage may roll or skid.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oilfilm.bearing.continuation import Crossings, trace
from oilfilm.bearing.ellipse import Grid, TractionLaw, grid, law_at
from oilfilm.bearing.friction import (
    COARSE,
    FULL_BANDS,
    NO_BANDS,
    QUADRATURE,
    FrictionEquilibrium,
    FrictionProblem,
)
from oilfilm.bearing.quasistatic import ball_force_n
from oilfilm.bearing.solver import TOLERANCE, Equations, Solution, inverse_jacobian, near, solve
from oilfilm.physics.contact import Conditions
from oilfilm.units import BoolArray, FloatArray, IndexArray

# Shares of everything beside traction at which a certified start is looked for.
_SHARES = (1.0, 0.54, 0.25, 0.11, 0.04)
# Parameter of the curve, u = s/(1 + s): of the bearing, where curves end that have turned back (one
# of a light bearing may dip below 0), and where the others end: 19 times the resistances, beyond
# which a curve that returns would be one of a bearing that nothing known makes skid. The fastest
# cage comes first: for that alone curves end soon after the bearing.
_WHOLE, _FIRST, _LAST, _SOON = 0.5, -1.0, 0.95, 0.6
# Jacobians of Newton's method from a rolling cage, and where nothing resists.
_NEWTON, _MOST = 15, 100
# Share of the slip at the law's peak below which a rolling start is certified.
_BELOW_PEAK = 0.9
# Slide-roll ratios among which the peak is looked for, and the relative rise from one to the next
# below which a law counts as flat.
_SLIPS = np.geomspace(1e-4, 2.0, 64)
_FLAT = 1e-3
# Softening of the law, as a slip, where a rolling cage is not found at once.
_SOFTENING = (*np.geomspace(0.3, 1e-5, 10), 0.0)
# Steps of a curve that may turn at a kink of the law, which its lowest levels make.
_KINK = 1e-3
# Largest residual on a curve along which bands shrink: beside a jump the forces are steep.
_FINE = 1e-9
# How a curve is followed that stalls: softening of the law, and steps that may turn at a kink.
_ATTEMPTS = ((0.0, 0.0), (0.0, _KINK), (0.003, _KINK))
# The narrowest band of rolling, over the full one, by which a motion may be held; and by how much
# the cage's speed, over its scale, may change when this band goes.
_NARROWEST, _OTHER = 1e-3, 0.01
# Cage speeds of two equilibria are further apart, over their scale.
_APART = 1e-6
# Parameter beyond which no step may look: at 1 the resistances would be infinite.
_HIGHEST = 0.99
# The speed of cage and balls among the unknowns.
_CAGE = 5


@dataclass(frozen=True)
class Equilibria:
    """Steady motions of a bearing at each point.

    Attributes:
        fastest: With the fastest cage: the bearing that has rolled from the start.
        slowest: With the slowest one: the cage skids. The same where there is one equilibrium.
        count: How many equilibria there are, shape (points,); those between the fastest and the
            slowest cage count too.
        complete: Whether the curve was followed to its end, and the fastest cage is one that the
            law was made for: otherwise there may be more.
    """

    fastest: FrictionEquilibrium
    slowest: FrictionEquilibrium
    count: IndexArray
    complete: BoolArray


@dataclass(frozen=True)
class Neighbour:
    """Known equilibria, near which others are looked for.

    Attributes:
        unknowns: Shape (points, 7).
        inverse: Of the Jacobian there, shape (points, 7, 7).
    """

    unknowns: FloatArray
    inverse: FloatArray

    @classmethod
    def of(cls, problem: FrictionProblem, unknowns: FloatArray) -> "Neighbour":
        """The equilibria of a problem."""
        return cls(unknowns, inverse_jacobian(problem.residuals, unknowns, problem.scale()))

    def at(self, which: IndexArray) -> "Neighbour":
        """Some of them."""
        return Neighbour(self.unknowns[which], self.inverse[which])


@dataclass(frozen=True)
class Softened:
    """A traction law that rises from slip 0 less steeply: mu(S_e) S/S_e, S_e^2 = S^2 + slip^2.

    Attributes:
        law: The law itself.
        slip: Slip-to-roll ratio up to which it is softened.
    """

    law: TractionLaw
    slip: float

    def at_points(self, which: IndexArray) -> "Softened":
        """See `TractionLaw`."""
        return Softened(law_at(self.law, which), self.slip)

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        softer = np.hypot(slide_roll_ratio, self.slip)
        return self.law(at, softer) * (slide_roll_ratio / softer)


def friction_equilibrium(
    problem: FrictionProblem, neighbour: Neighbour | None = None
) -> FrictionEquilibrium:
    """Where balls, cage and inner ring travel steadily under all forces, with the fastest cage.

    Args:
        problem: Bearing, loads, speeds, oil and law; the bands of an earlier search do not count.
        neighbour: Equilibria with other constants. What is found near them is taken, on whichever
            branch they are; the other points are searched as without them.

    Returns:
        The motion; not converged as well where a contact would be as wide as the ball.
    """
    problem = replace(problem, bands=NO_BANDS)
    if neighbour is None:
        return _equilibria(problem, every=False).fastest
    solution = near(problem.residuals, neighbour.unknowns, problem.scale(), neighbour.inverse)
    bands = np.zeros((len(solution.unknowns), len(NO_BANDS[0])))
    lost = np.flatnonzero(~solution.converged)
    if len(lost):
        found = _equilibria(problem.at(lost), every=False).fastest
        solution.put(lost, found.solution)
        bands[lost] = found.problem.bands
    return _motion(problem, solution.unknowns, bands)


def equilibria(problem: FrictionProblem) -> Equilibria:
    """All steady motions that the curve from the rolling cage comes by.

    Args:
        problem: As of `friction_equilibrium`.
    """
    return _equilibria(replace(problem, bands=NO_BANDS), every=True)


@dataclass(frozen=True)
class _Motions:
    """Motions of points, any number of each point.

    Attributes:
        point: Number of the point, shape (motions,).
        unknowns: Shape (motions, 7).
        bands: Widths of the bands with which the forces balance, shape (motions, 3).
    """

    point: IndexArray
    unknowns: FloatArray
    bands: FloatArray

    @classmethod
    def near(cls, point: IndexArray, unknowns: FloatArray) -> "_Motions":
        """Motions that are known about, with the full bands."""
        return cls(point, unknowns, np.repeat(FULL_BANDS, len(point), axis=0))

    def at(self, which: IndexArray | BoolArray) -> "_Motions":
        """Some of them."""
        return _Motions(self.point[which], self.unknowns[which], self.bands[which])

    def joined(self, other: "_Motions") -> "_Motions":
        """These and others."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return _Motions(*(np.concatenate(pair) for pair in pairs))


def _equilibria(problem: FrictionProblem, every: bool) -> Equilibria:
    """Steady motions; without `every` the fastest cage alone where it is certified."""
    # a law may be one of certain nodes
    rule = grid(*COARSE) if problem.rule.counts == QUADRATURE else problem.rule
    found, stalled = _searched(problem, rule, every)
    # a crossing of the coarse nodes may have no counterpart on all nodes
    missed = np.setdiff1d(np.arange(len(stalled)), found.point)
    if len(missed) and problem.rule is not rule:
        again, stalled[missed] = _searched(problem.at(missed), problem.rule, every)
        found = found.joined(replace(again, point=missed[again.point]))
    return _chosen(problem, found, ~stalled)


def _searched(problem: FrictionProblem, rule: Grid, every: bool) -> tuple[_Motions, BoolArray]:
    """Steady motions by a search on some nodes, and points whose curve stalls before its end."""
    coarse = replace(problem, rule=rule, bands=FULL_BANDS)
    start, share = _starts(coarse)
    rolls = share == 1
    followed = np.flatnonzero(np.isfinite(share) & (every | ~rolls))
    last = _LAST if every else _SOON
    crossings, ended = _followed(coarse.at(followed), start[followed], share[followed], last)
    stalled = np.isnan(share)
    stalled[followed[~ended]] = True
    rolling = _Motions.near(np.flatnonzero(rolls), start[rolls])
    crossings = replace(crossings, point=followed[crossings.point])
    return _exact(problem, rolling.joined(crossings)), stalled


def _starts(problem: FrictionProblem) -> tuple[FloatArray, FloatArray]:
    """Where each point's curve is known to be before its first fold.

    Returns:
        Unknowns, and the share of everything beside traction: 1 where the bearing itself is
        certified to roll; NaN where no start was found.
    """
    rolling, scale = problem.start(), problem.scale()
    unknowns, share = rolling.copy(), np.full(len(rolling), np.nan)
    for level in (*_SHARES, 0.0):
        open_points = np.flatnonzero(np.isnan(share))
        if len(open_points) == 0:
            break
        part = problem.at(open_points)
        most = _NEWTON if level else _MOST
        end = solve(_of_share(part, level), rolling[open_points], scale[open_points], most)
        good = end.converged.copy()
        if level and good.any():
            good[good] = _certified(part.at(np.flatnonzero(good)), end.unknowns[good])
        unknowns[open_points[good]], share[open_points[good]] = end.unknowns[good], level
    lost = np.flatnonzero(np.isnan(share))
    if len(lost):
        end = _hardened(problem.at(lost), rolling[lost], _SOFTENING)
        unknowns[lost[end.converged]] = end.unknowns[end.converged]
        share[lost[end.converged]] = 0.0
    return unknowns, share


def _of_share(problem: FrictionProblem, share: float) -> Equations:
    """The equations with a share of everything beside traction."""
    return lambda unknowns, which: problem.residuals(unknowns, which, share)


def _hardened(
    problem: FrictionProblem, start: FloatArray, softening: tuple[float, ...], share: float = 0.0
) -> Solution:
    """The motion of a softened law, then of less and less softened ones; each from the last."""
    scale, unknowns = problem.scale(), start
    for slip in softening:
        soft = replace(problem, law=Softened(problem.law, slip)) if slip else problem
        end = solve(_of_share(soft, share), unknowns, scale, _MOST)
        unknowns = np.where(end.converged[:, np.newaxis], end.unknowns, unknowns)
    return end


def _certified(problem: FrictionProblem, unknowns: FloatArray) -> BoolArray:
    """Whether the inner contact of each motion slips less than the law's peak."""
    balance = problem.balance(unknowns)
    levels = vars(balance.at).items()
    of_inner = {name: value[:, :1] if np.ndim(value) else value for name, value in levels}
    ratio = np.broadcast_to(_SLIPS, (len(unknowns), 1, len(_SLIPS)))
    inner = problem.law(Conditions(**of_inner), ratio)[:, 0]
    flat = inner[:, 1:] <= inner[:, :-1] * (1 + _FLAT)
    peak = np.where(flat.any(axis=1), _SLIPS[flat.argmax(axis=1)], np.inf)
    slip = np.abs(balance.sliding.middle_slide_roll_ratio[:, 0])
    return np.asarray(slip < _BELOW_PEAK * peak)


def _followed(
    problem: FrictionProblem, start: FloatArray, share: FloatArray, last: float
) -> tuple[_Motions, BoolArray]:
    """Crossings of the whole bearing by the curves of all points, and which curves end.

    Args:
        problem: The points, with bands.
        start: Where each curve begins, shape (points, 7).
        share: Of everything beside traction there, shape (points,).
        last: Parameter at which curves end.
    """
    ended = np.zeros(len(share), dtype=bool)
    found = _Motions.near(np.arange(0), start[:0])
    for softening, kink in _ATTEMPTS:
        point = np.flatnonzero(~ended)
        if len(point) == 0:
            break
        part = problem.at(point)
        if softening:
            curves, crossings = _softly_followed(part, start[point], last, softening, kink)
        else:
            curves = _traced(part, start[point], share[point], last, kink)
            crossings = _Motions.near(curves.point, curves.unknowns)
        ended[point] = curves.ended
        crossings = replace(crossings, point=point[crossings.point])
        # what another attempt found of a curve that stalled is told only where this finds nothing
        before = ~np.isin(found.point, crossings.point)
        found = found.at(before).joined(crossings)
    return found, ended


def _softly_followed(
    problem: FrictionProblem, start: FloatArray, last: float, softening: float, kink: float
) -> tuple[Crossings, _Motions]:
    """Curves of a softened law, and their crossings with the law itself.

    A law of abrupt slopes is followed softened, and hardened again where it crosses.
    """
    gentler = tuple(slip for slip in _SOFTENING if slip > softening)
    harder = tuple(slip for slip in _SOFTENING if slip < softening)
    begin = _hardened(problem, start, (*gentler, softening)).unknowns
    soft = replace(problem, law=Softened(problem.law, softening))
    curves = _traced(soft, begin, np.zeros(len(start)), last, kink)
    end = _hardened(problem.at(curves.point), curves.unknowns, harder, share=1.0)
    return curves, _Motions.near(curves.point, end.unknowns).at(end.converged)


def _traced(
    problem: FrictionProblem, start: FloatArray, share: FloatArray, last: float, kink: float
) -> Crossings:
    """Where the curves of equilibria cross the whole bearing."""

    def residuals(unknowns: FloatArray, level: FloatArray, which: IndexArray) -> FloatArray:
        below = np.minimum(level, _HIGHEST)
        return problem.residuals(unknowns, which, below / (1 - below))

    begin = share / (1 + share)
    return trace(residuals, start, problem.scale(), begin, _WHOLE, _FIRST, last, kink)


def _exact(problem: FrictionProblem, motions: _Motions) -> _Motions:
    """Motions of the problem's own nodes near others, with bands as narrow as they can be.

    Most motions lie outside the bands, so that they are exact at once. The bands of the others
    shrink along a curve. A motion whose curve turns back is one of a pair that the bands have made.
    Where the resistance to rolling jumps at the very motion, it stays between the two sides of the
    jump (a solution in the sense of Filippov): there the narrowest band is kept.
    """
    smooth, solved = _solved(problem, motions)
    smooth = smooth.at(solved)
    part = problem.at(smooth.point)
    left = np.abs(part.residuals(smooth.unknowns, np.arange(len(smooth.point)))).max(axis=1)
    exact = left <= TOLERANCE
    smooth.bands[exact] = NO_BANDS
    inside = smooth.at(~exact)
    if len(inside.point) == 0:
        return smooth
    narrowed = _narrowed(problem, inside)
    # a point keeps one motion at least
    alone = ~np.isin(inside.point, np.concatenate([smooth.point[exact], narrowed.point]))
    return smooth.at(exact).joined(narrowed).joined(inside.at(alone))


def _solved(problem: FrictionProblem, motions: _Motions) -> tuple[_Motions, BoolArray]:
    """Motions near others, with the bands that these have; and which of them there are."""
    part = replace(problem.at(motions.point), bands=motions.bands)
    scale = part.scale()
    neighbour = Neighbour.of(part, motions.unknowns)
    solution = near(part.residuals, motions.unknowns, scale, neighbour.inverse)
    lost = np.flatnonzero(~solution.converged)
    again = solve(part.at(lost).residuals, motions.unknowns[lost], scale[lost], _NEWTON)
    solution.put(lost, again)
    return replace(motions, unknowns=solution.unknowns), solution.converged


def _narrowed(problem: FrictionProblem, motions: _Motions) -> _Motions:
    """Motions whose bands have shrunk, one band after the other; those that turn back are gone."""
    held = motions.at(np.arange(0))
    for shares in (_less_entrainment, _less_spin, _less_rolling):
        part = problem.at(motions.point)

        def residuals(
            unknowns: FloatArray,
            level: FloatArray,
            which: IndexArray,
            part: FrictionProblem = part,
            shares: Callable[[FloatArray], FloatArray] = shares,
        ) -> FloatArray:
            bands = FULL_BANDS * shares(level)
            at_level = replace(part.at(which), bands=bands)
            return at_level.residuals(unknowns, np.arange(len(which)))

        begin = np.zeros(len(motions.point))
        curves = trace(
            residuals, motions.unknowns, part.scale(), begin, 1.0, 0.0, 1.0, _KINK, _FINE
        )
        stalled = ~curves.ended & ~curves.returned
        held = held.joined(motions.at(stalled))
        bands = FULL_BANDS * shares(curves.end_parameter)
        narrower = _Motions(motions.point, curves.end, bands).at(curves.ended)
        wider = motions.at(curves.ended)
        # beside the edge of a narrow band there may be no slope to go by
        solution, solved = _solved(problem, narrower)
        motions = solution.at(solved).joined(wider.at(~solved))
    free = replace(motions, bands=np.zeros_like(motions.bands))
    solution, solved = _solved(problem, free)
    away = np.abs(solution.unknowns - motions.unknowns)[:, _CAGE]
    let_go = solved & (away < _OTHER * problem.scale()[motions.point, _CAGE])
    return held.joined(motions.at(~let_go)).joined(solution.at(let_go))


def _less_entrainment(level: FloatArray) -> FloatArray:
    """Shares of the bands, (..., 3), while that of the entrainment speed shrinks to nothing."""
    whole = np.ones_like(level)
    return np.stack([whole, whole, np.maximum(1 - level, 0.0)], axis=-1)


def _less_spin(level: FloatArray) -> FloatArray:
    """The same while that of the ball's spin shrinks to nothing."""
    return np.stack([np.ones_like(level), np.maximum(1 - level, 0.0), 0 * level], axis=-1)


def _less_rolling(level: FloatArray) -> FloatArray:
    """The same while that of the rolling speed shrinks to the narrowest."""
    none = np.zeros_like(level)
    return np.stack([_NARROWEST**level, none, none], axis=-1)


def _chosen(problem: FrictionProblem, found: _Motions, complete: BoolArray) -> Equilibria:
    """The fastest and the slowest cage of each point."""
    scale = problem.scale()
    speed = np.abs(found.unknowns[:, _CAGE]) / scale[found.point, _CAGE]
    sorted_motions = found.at(np.lexsort((-speed, found.point)))
    number = sorted_motions.point
    speed = np.abs(sorted_motions.unknowns[:, _CAGE]) / scale[number, _CAGE]
    twice = np.zeros(len(number), dtype=bool)
    twice[1:] = (np.diff(number) == 0) & (-np.diff(speed) < _APART)
    distinct = sorted_motions.at(~twice)
    count = np.bincount(distinct.point, minlength=len(scale))
    last = np.cumsum(count) - 1
    known, unknown = np.flatnonzero(count > 0), np.flatnonzero(count == 0)

    def of_points(row: IndexArray) -> FrictionEquilibrium:
        unknowns, bands = np.empty_like(scale), np.zeros((len(scale), len(NO_BANDS[0])))
        unknowns[known], bands[known] = distinct.unknowns[row[known]], distinct.bands[row[known]]
        unknowns[unknown] = problem.at(unknown).start()
        return _motion(problem, unknowns, bands)

    fastest = of_points(last - count + 1)
    slowest = of_points(last) if (count > 1).any() else fastest
    # Beyond the law a curve may come by balls that stand still, with motions so close to each other
    # that rounding decides how many of them are found.
    return Equilibria(fastest, slowest, count, complete & ~fastest.outside_law())


def _motion(
    problem: FrictionProblem, unknowns: FloatArray, bands: FloatArray
) -> FrictionEquilibrium:
    """A motion of each point, with its forces."""
    held = replace(problem, bands=bands)
    balance = held.balance(unknowns)
    forces = np.abs(balance.left_over_n).max(axis=1)
    left = forces / ball_force_n(problem.bearing, problem.points)
    residual = np.where(np.isfinite(left), left, np.inf)
    converged = residual <= TOLERANCE
    motion = FrictionEquilibrium(held, balance, Solution(unknowns, residual, converged))
    # beyond the range of Hertz's solution and of the groove there is no equilibrium
    converged[motion.widest_contact() >= 1] = False
    return motion
