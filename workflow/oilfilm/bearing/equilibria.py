"""Friction equilibria of a bearing: every steady motion, from the rolling cage through all folds.

A cage rolls where its balls roll on both races; it skids where they slip. Traction that falls with
slip can balance the resistances at several cage speeds: the film of a rolling contact pulls hard
enough, that of a skidding contact does not. The curve of equilibria is followed in the share s of
the resistances: drag, rolling resistance, hysteresis, pockets, land and gyroscopic moment. At s = 0
the cage rolls, and there is one equilibrium. The bearing is at s = 1. At a fold the curve turns
back in s.

Where possible the search takes a shorter way: Newton's method from a rolling cage. Its result is
certified where the inner contact slips less than at the law's peak. Traction has then risen with
slip all the way from s = 0, so that the curve has no fold before s = 1. Each point is solved by
itself.

A curve may pass balls at rest, beside which it cannot be followed. Where no motion was found,
Newton's method starts from skidding cages.

Reference: E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods (2003).

Decides: which equilibria a bearing has, and when a cage may roll or skid.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.continuation import Crossings, trace
from oilfilm.bearing.ellipse import QuadratureRule, TractionLaw, gauss_rule, law_at_points
from oilfilm.bearing.friction import (
    COARSE_NODE_COUNTS,
    FULL_BANDS,
    NO_BANDS,
    NODE_COUNTS,
    FrictionEquilibrium,
    FrictionProblem,
)
from oilfilm.bearing.quasistatic import ball_force_scale_n
from oilfilm.bearing.solver import (
    TOLERANCE,
    Equations,
    Solution,
    inverse_jacobian,
    solve,
    solve_near,
)
from oilfilm.physics.contact import Conditions

# Shares of the resistances at which a certified start is searched.
_START_RESISTANCE_SHARES = (1.0, 0.54, 0.25, 0.11, 0.04)
# Values of the curve's parameter u = s/(1 + s).
# The bearing, s = 1.
_BEARING_PARAMETER = 0.5
# End of curves that have turned back. The curve of a light bearing may dip below 0.
_FIRST_PARAMETER = -1.0
# End of the other curves, at 19 times the resistances. No known effect makes such resistances.
_LAST_PARAMETER = 0.95
# End of the other curves where only the fastest cage is wanted, which comes first.
_LAST_PARAMETER_FOR_FASTEST = 0.6
# Largest value at which the equations are evaluated: at 1 the resistances would be infinite.
_HIGHEST_PARAMETER = 0.99
# Jacobians of Newton's method from a rolling cage, and of Newton's method without resistances or
# with a softened law.
_NEWTON_ITERATIONS = 15
_MAX_ITERATIONS = 100
# A rolling start is certified where its slip is below this share of the slip at the law's peak.
_CERTIFIED_SHARE_OF_PEAK_SLIP = 0.9
# Slide-roll ratios at which the law is evaluated to find its peak.
_PEAK_SLIPS = np.geomspace(1e-4, 2.0, 64)
# The peak is where mu rises by less than this share from one such ratio to the next.
_SMALLEST_RISE_BEFORE_PEAK = 1e-3
# Slips of softened laws, where Newton's method does not find a rolling cage.
_SOFTENING_SLIPS = (*np.geomspace(0.3, 1e-5, 10), 0.0)
# Steps shorter than this may turn at a kink, which the law has at its lowest levels.
_KINK_LENGTH = 1e-3
# Attempts to follow a curve, until one reaches its end: (slip up to which the law is softened,
# `kink_length` of `trace`).
_ATTEMPTS = ((0.0, 0.0), (0.0, _KINK_LENGTH), (0.003, _KINK_LENGTH), (0.01, _KINK_LENGTH))
# Largest residual on a curve along which bands shrink: the forces are steep beside a jump.
_BAND_TOLERANCE = 1e-9
# Factor on all bands from one step to the next, by which a motion without bands is sought, and the
# number of such steps before the bands vanish. With a factor of 0.5 some motions are lost.
_BAND_FACTOR = 0.75
_BAND_STEPS = 32
# Step of the parameter along which bands shrink, from 0 to 1, to which a stalled curve goes back.
_STALL_STEP = 0.2
# Narrowest band of the rolling speed that may hold a motion, over the full band.
_NARROWEST_BAND = 1e-3
# A motion without band is the same as one with the narrowest band if their cage speeds, over their
# scale, differ by less than this.
_LARGEST_SAME_MOTION_CHANGE = 0.01
# Cage speeds of two different equilibria, over their scale, differ by at least this.
_SMALLEST_SPEED_DIFFERENCE = 1e-6
# Index of the speed of cage and balls among the unknowns.
_CAGE_SPEED_INDEX = 5
# Indices of the rotation of the balls and of that speed.
_SPEED_INDICES = slice(2, 6)
# Shares of the speeds of rolling from which a skidding cage is searched where no curve leads to it.
_SLOW_CAGE_SPEED_SHARES = (0.2, 0.1, 0.05)


@dataclass(frozen=True)
class Equilibria:
    """Steady motions of a bearing at each point.

    Attributes:
        fastest: Equilibrium with the fastest cage: the bearing has rolled from the start.
        slowest: Equilibrium with the slowest cage: the cage skids. It is the same as `fastest`
            where there is one equilibrium.
        count: Number of equilibria, shape (points,), including those between the two.
        is_complete: True where the curve was followed to its end and the fastest cage is within the
            range of the law. Elsewhere there may be more equilibria.
    """

    fastest: FrictionEquilibrium
    slowest: FrictionEquilibrium
    count: IndexArray
    is_complete: BoolArray


@dataclass(frozen=True)
class NearbyEquilibria:
    """An equilibrium of each point, near which that of a similar problem is searched.

    Attributes:
        unknowns: Unknowns of the equilibria, shape (points, 7).
        inverse_jacobian: Inverse Jacobian there, shape (points, 7, 7).
    """

    unknowns: FloatArray
    inverse_jacobian: FloatArray

    @classmethod
    def from_unknowns(cls, problem: FrictionProblem, unknowns: FloatArray) -> "NearbyEquilibria":
        """Equilibria of a problem, by their unknowns."""
        return cls(unknowns, inverse_jacobian(problem.residuals, unknowns, problem.scale()))

    def at_points(self, point_index: IndexArray) -> "NearbyEquilibria":
        """The equilibria of some of the points."""
        return NearbyEquilibria(self.unknowns[point_index], self.inverse_jacobian[point_index])


@dataclass(frozen=True)
class SoftenedLaw:
    """A traction law that rises from slip 0 less steeply: mu(S_e) S/S_e, S_e^2 = S^2 + slip^2.

    Attributes:
        law: The law without softening.
        softening_slip: Slide-roll ratio up to which the law is softened.
    """

    law: TractionLaw
    softening_slip: float

    def at_points(self, point_index: IndexArray) -> "SoftenedLaw":
        """See `TractionLaw`."""
        return SoftenedLaw(law_at_points(self.law, point_index), self.softening_slip)

    def __call__(self, conditions: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        softened_slip = np.hypot(slide_roll_ratio, self.softening_slip)
        return self.law(conditions, softened_slip) * (slide_roll_ratio / softened_slip)


def friction_equilibrium(
    problem: FrictionProblem, nearby_equilibria: NearbyEquilibria | None = None
) -> FrictionEquilibrium:
    """Steady motion of balls, cage and inner ring under all forces, with the fastest cage.

    Args:
        problem: Bearing, loads, speeds, oil and law; bands of an earlier search are ignored.
        nearby_equilibria: Equilibria of a similar problem, such as one whose law has other
            constants. The result is near them, on the same branch. Points without such a result
            are searched from the rolling cage.

    Returns:
        The motion. It is not converged where a contact would be as wide as the ball.
    """
    problem = replace(problem, bands=NO_BANDS)
    if nearby_equilibria is None:
        return _equilibria(problem, wants_all_motions=False).fastest
    solution = solve_near(
        problem.residuals,
        nearby_equilibria.unknowns,
        problem.scale(),
        nearby_equilibria.inverse_jacobian,
    )
    bands = np.zeros((len(solution.unknowns), len(NO_BANDS[0])))
    unsolved_index = np.flatnonzero(~solution.converged)
    if len(unsolved_index):
        searched_equilibrium = _equilibria(
            problem.at_points(unsolved_index), wants_all_motions=False
        ).fastest
        solution.replace_points(unsolved_index, searched_equilibrium.solution)
        bands[unsolved_index] = searched_equilibrium.problem.bands
    return _equilibrium_of_motion(problem, solution.unknowns, bands)


def equilibria(problem: FrictionProblem) -> Equilibria:
    """All steady motions on the curve that starts at the rolling cage.

    Args:
        problem: As for `friction_equilibrium`.
    """
    return _equilibria(replace(problem, bands=NO_BANDS), wants_all_motions=True)


@dataclass(frozen=True)
class _Motions:
    """Steady motions (equilibria), any number per operating point.

    Attributes:
        point_index: Index of each motion's point, shape (motions,).
        unknowns: Unknowns of each motion, shape (motions, 7).
        bands: Half-widths of the bands with which the forces balance, shape (motions, 3).
    """

    point_index: IndexArray
    unknowns: FloatArray
    bands: FloatArray

    @classmethod
    def with_full_bands(cls, point_index: IndexArray, unknowns: FloatArray) -> "_Motions":
        """Motions with the full bands, of which the unknowns are known approximately."""
        return cls(point_index, unknowns, np.repeat(FULL_BANDS, len(point_index), axis=0))

    def select(self, index_or_mask: IndexArray | BoolArray) -> "_Motions":
        """Some of the motions."""
        return _Motions(
            self.point_index[index_or_mask], self.unknowns[index_or_mask], self.bands[index_or_mask]
        )

    def joined(self, other: "_Motions") -> "_Motions":
        """These motions and others."""
        return _Motions(
            point_index=np.concatenate([self.point_index, other.point_index]),
            unknowns=np.concatenate([self.unknowns, other.unknowns]),
            bands=np.concatenate([self.bands, other.bands]),
        )


def _equilibria(problem: FrictionProblem, wants_all_motions: bool) -> Equilibria:
    """Steady motions: all of them, or only the fastest cage where it is certified to roll."""
    # a problem with other nodes than the usual ones keeps them: its law may be solved at each node
    rule = (
        gauss_rule(*COARSE_NODE_COUNTS) if problem.rule.node_counts == NODE_COUNTS else problem.rule
    )
    motions, is_unfinished = _search_motions(problem, rule, wants_all_motions)
    # a crossing with the coarse nodes may have no counterpart with all nodes
    points_without_motion = np.setdiff1d(np.arange(len(is_unfinished)), motions.point_index)
    if len(points_without_motion) and problem.rule is not rule:
        added_motions, is_unfinished[points_without_motion] = _search_motions(
            problem.at_points(points_without_motion), problem.rule, wants_all_motions
        )
        motions = motions.joined(
            replace(added_motions, point_index=points_without_motion[added_motions.point_index])
        )
    # beside balls at rest rounding decides how far a curve gets
    points_without_motion = np.setdiff1d(np.arange(len(is_unfinished)), motions.point_index)
    for speed_share in _SLOW_CAGE_SPEED_SHARES:
        if len(points_without_motion) == 0:
            break
        slow_motions = _find_slow_cages(problem.at_points(points_without_motion), speed_share)
        motions = motions.joined(
            replace(slow_motions, point_index=points_without_motion[slow_motions.point_index])
        )
        points_without_motion = np.setdiff1d(points_without_motion, motions.point_index)
    return _fastest_and_slowest(problem, motions, ~is_unfinished)


def _find_slow_cages(problem: FrictionProblem, speed_share: float) -> _Motions:
    """Motions by Newton's method from a skidding cage, with a share of the speeds of rolling.

    They are on no curve that was followed, so that there may be others.
    """
    banded_problem = replace(problem, bands=FULL_BANDS)
    slow_start = problem.start_unknowns()
    slow_start[:, _SPEED_INDICES] *= speed_share
    solution = solve(banded_problem.residuals, slow_start, banded_problem.scale(), _MAX_ITERATIONS)
    solved_index = np.flatnonzero(solution.converged)
    return _narrow_bands(
        problem, _Motions.with_full_bands(solved_index, solution.unknowns[solved_index])
    )


def _search_motions(
    problem: FrictionProblem, rule: QuadratureRule, wants_all_motions: bool
) -> tuple[_Motions, BoolArray]:
    """Steady motions by a search with other nodes, and which points have an unfinished search."""
    coarse_problem = replace(problem, rule=rule, bands=FULL_BANDS)
    start, resistance_share = _find_curve_starts(coarse_problem)
    is_rolling = resistance_share == 1
    followed_index = np.flatnonzero(
        np.isfinite(resistance_share) & (wants_all_motions | ~is_rolling)
    )
    last_parameter = _LAST_PARAMETER if wants_all_motions else _LAST_PARAMETER_FOR_FASTEST
    followed_motions, has_reached_end = _follow_curves(
        coarse_problem.at_points(followed_index),
        start[followed_index],
        resistance_share[followed_index],
        last_parameter,
    )
    is_unfinished = np.isnan(resistance_share)
    is_unfinished[followed_index[~has_reached_end]] = True
    rolling_motions = _Motions.with_full_bands(np.flatnonzero(is_rolling), start[is_rolling])
    followed_motions = replace(
        followed_motions, point_index=followed_index[followed_motions.point_index]
    )
    return _narrow_bands(problem, rolling_motions.joined(followed_motions)), is_unfinished


def _find_curve_starts(problem: FrictionProblem) -> tuple[FloatArray, FloatArray]:
    """A state on each point's curve, before its first fold.

    Returns:
        Unknowns, and the share of the resistances there. The share is 1 where the bearing itself is
        certified to roll, and NaN where no start was found.
    """
    rolling_unknowns = problem.start_unknowns()
    scale = problem.scale()
    unknowns = rolling_unknowns.copy()
    resistance_share = np.full(len(rolling_unknowns), np.nan)
    for tried_resistance_share in (*_START_RESISTANCE_SHARES, 0.0):
        unstarted_index = np.flatnonzero(np.isnan(resistance_share))
        if len(unstarted_index) == 0:
            break
        remaining_problem = problem.at_points(unstarted_index)
        max_iterations = _NEWTON_ITERATIONS if tried_resistance_share else _MAX_ITERATIONS
        solution = solve(
            _equations_with_share(remaining_problem, tried_resistance_share),
            rolling_unknowns[unstarted_index],
            scale[unstarted_index],
            max_iterations,
        )
        has_start = solution.converged.copy()
        if tried_resistance_share and has_start.any():
            converged_problem = remaining_problem.at_points(np.flatnonzero(has_start))
            has_start[has_start] = _is_certified_to_roll(
                converged_problem, solution.unknowns[has_start]
            )
        unknowns[unstarted_index[has_start]] = solution.unknowns[has_start]
        resistance_share[unstarted_index[has_start]] = tried_resistance_share
    unstarted_index = np.flatnonzero(np.isnan(resistance_share))
    if len(unstarted_index):
        solution = _harden_law(
            problem.at_points(unstarted_index), rolling_unknowns[unstarted_index], _SOFTENING_SLIPS
        )
        is_solved = solution.converged
        unknowns[unstarted_index[is_solved]] = solution.unknowns[is_solved]
        resistance_share[unstarted_index[is_solved]] = 0.0
    return unknowns, resistance_share


def _equations_with_share(problem: FrictionProblem, resistance_share: float) -> Equations:
    """The equations with a share of the resistances."""
    return lambda unknowns, point_index: problem.residuals(unknowns, point_index, resistance_share)


def _harden_law(
    problem: FrictionProblem,
    start: FloatArray,
    softening_slips: tuple[float, ...],
    resistance_share: float = 0.0,
) -> Solution:
    """Motions with softened laws, one softening slip after the other, from soft to hard.

    Each search starts from the motion before.
    """
    scale = problem.scale()
    unknowns = start
    for softening_slip in softening_slips:
        softened_problem = (
            replace(problem, law=SoftenedLaw(problem.law, softening_slip))
            if softening_slip
            else problem
        )
        equations = _equations_with_share(softened_problem, resistance_share)
        solution = solve(equations, unknowns, scale, _MAX_ITERATIONS)
        unknowns = np.where(solution.converged[:, np.newaxis], solution.unknowns, unknowns)
    return solution


def _is_certified_to_roll(problem: FrictionProblem, unknowns: FloatArray) -> BoolArray:
    """Whether the inner contact of each motion slips less than at the law's peak."""
    balance = problem.balance(unknowns)
    # a law that is solved at each node needs them all; of any other law one node is enough
    law_needs_its_nodes = problem.rule.node_counts not in (COARSE_NODE_COUNTS, NODE_COUNTS)
    weight = problem.rule.load_share if law_needs_its_nodes else np.ones(1)
    shape_of_contacts = balance.conditions.load_n.shape[:-1]
    shape_of_slips = (len(_PEAK_SLIPS), *shape_of_contacts, len(weight))
    slips = np.broadcast_to(_PEAK_SLIPS[:, np.newaxis, np.newaxis, np.newaxis], shape_of_slips)
    mu_at_nodes = problem.law(balance.conditions, slips)[:, :, 0]
    mu = (mu_at_nodes @ weight / weight.sum()).T
    is_flat = mu[:, 1:] <= mu[:, :-1] * (1 + _SMALLEST_RISE_BEFORE_PEAK)
    peak_slip = np.where(is_flat.any(axis=1), _PEAK_SLIPS[is_flat.argmax(axis=1)], np.inf)
    inner_slip = np.abs(balance.sliding.middle_slide_roll_ratio[:, 0])
    return np.asarray(inner_slip < _CERTIFIED_SHARE_OF_PEAK_SLIP * peak_slip)


def _follow_curves(
    problem: FrictionProblem, start: FloatArray, resistance_share: FloatArray, last_parameter: float
) -> tuple[_Motions, BoolArray]:
    """Motions of the bearing on the curves of all points, and which curves reach `last_parameter`.

    Args:
        problem: The points, with bands.
        start: Start of each curve, shape (points, 7).
        resistance_share: Share of the resistances there, shape (points,).
        last_parameter: Parameter at which curves end.
    """
    has_reached_end = np.zeros(len(resistance_share), dtype=bool)
    motions = _Motions.with_full_bands(np.arange(0), start[:0])
    for softening_slip, kink_length in _ATTEMPTS:
        remaining_index = np.flatnonzero(~has_reached_end)
        if len(remaining_index) == 0:
            break
        remaining_problem = problem.at_points(remaining_index)
        if softening_slip:
            crossings, motions_at_crossings = _follow_softened_curves(
                remaining_problem,
                start[remaining_index],
                last_parameter,
                softening_slip,
                kink_length,
            )
        else:
            crossings = _trace_crossings(
                remaining_problem,
                start[remaining_index],
                resistance_share[remaining_index],
                last_parameter,
                kink_length,
            )
            motions_at_crossings = _Motions.with_full_bands(
                crossings.point_index, crossings.unknowns
            )
        has_reached_end[remaining_index] = crossings.reached_last_value
        motions_at_crossings = replace(
            motions_at_crossings, point_index=remaining_index[motions_at_crossings.point_index]
        )
        # motions of an earlier, unfinished attempt remain only at points without motions now
        is_kept = ~np.isin(motions.point_index, motions_at_crossings.point_index)
        motions = motions.select(is_kept).joined(motions_at_crossings)
    return motions, has_reached_end


def _follow_softened_curves(
    problem: FrictionProblem,
    start: FloatArray,
    last_parameter: float,
    softening_slip: float,
    kink_length: float,
) -> tuple[Crossings, _Motions]:
    """Curves of a softened law, and the motions of the law itself at their crossings.

    The curve of a law with abrupt slopes is followed with a softened law. At each crossing the law
    is hardened again.
    """
    softer_slips = tuple(slip for slip in _SOFTENING_SLIPS if slip > softening_slip)
    harder_slips = tuple(slip for slip in _SOFTENING_SLIPS if slip < softening_slip)
    softened_start = _harden_law(problem, start, (*softer_slips, softening_slip)).unknowns
    softened_problem = replace(problem, law=SoftenedLaw(problem.law, softening_slip))
    crossings = _trace_crossings(
        softened_problem, softened_start, np.zeros(len(start)), last_parameter, kink_length
    )
    crossing_problem = problem.at_points(crossings.point_index)
    solution = _harden_law(crossing_problem, crossings.unknowns, harder_slips, resistance_share=1.0)
    motions = _Motions.with_full_bands(crossings.point_index, solution.unknowns)
    return crossings, motions.select(solution.converged)


def _trace_crossings(
    problem: FrictionProblem,
    start: FloatArray,
    resistance_share: FloatArray,
    last_parameter: float,
    kink_length: float,
) -> Crossings:
    """Crossings of the bearing's share, s = 1, by the curves of equilibria."""

    def residuals(
        unknowns: FloatArray, parameter: FloatArray, point_index: IndexArray
    ) -> FloatArray:
        """Balance residuals, with the traced parameter s / (1 + s) as `parameter`."""
        limited_parameter = np.minimum(parameter, _HIGHEST_PARAMETER)
        return problem.residuals(unknowns, point_index, limited_parameter / (1 - limited_parameter))

    start_parameter = resistance_share / (1 + resistance_share)
    return trace(
        residuals,
        start,
        problem.scale(),
        start_parameter,
        wanted_value=_BEARING_PARAMETER,
        first_value=_FIRST_PARAMETER,
        last_value=last_parameter,
        kink_length=kink_length,
    )


def _narrow_bands(problem: FrictionProblem, motions: _Motions) -> _Motions:
    """Motions with the problem's nodes, near others, with bands as narrow as possible.

    Most motions are outside the bands, so that they are exact at once. The bands of the others are
    reduced step by step until they vanish. Where a motion is lost on that way its bands shrink
    along a curve. A motion whose curve turns back exists only because of the bands, and so does its
    partner. Where rolling resistance jumps at the motion itself, the motion is between the two
    sides of the jump (a solution in the sense of Filippov), and the narrowest band is kept.
    """
    banded_motions, is_solved = _solve_near_motions(problem, motions)
    banded_motions = banded_motions.select(is_solved)
    motion_index = np.arange(len(banded_motions.point_index))
    residuals = problem.at_points(banded_motions.point_index).residuals(
        banded_motions.unknowns, motion_index
    )
    is_exact = np.abs(residuals).max(axis=1) <= TOLERANCE
    banded_motions.bands[is_exact] = NO_BANDS
    within_bands = banded_motions.select(~is_exact)
    unbanded_motions, holds_without_bands = _remove_bands_by_steps(problem, within_bands)
    exact_motions = banded_motions.select(is_exact).joined(
        unbanded_motions.select(holds_without_bands)
    )
    within_bands = within_bands.select(~holds_without_bands)
    if len(within_bands.point_index) == 0:
        return exact_motions
    narrowed_motions = _shrink_bands(problem, within_bands)
    # each point keeps at least one motion
    kept_points = np.concatenate([exact_motions.point_index, narrowed_motions.point_index])
    is_last_of_point = ~np.isin(within_bands.point_index, kept_points)
    return exact_motions.joined(narrowed_motions).joined(within_bands.select(is_last_of_point))


def _remove_bands_by_steps(
    problem: FrictionProblem, motions: _Motions
) -> tuple[_Motions, BoolArray]:
    """Motions with bands that are reduced to 0 step by step, and whether each one was followed.

    A motion is followed while it is found near that of the step before. Where a curve turns or
    stalls at a kink depends on rounding; whether a motion is found near another one hardly does.
    """
    scale = problem.scale()
    unknowns = motions.unknowns.copy()
    followed_index = np.arange(len(motions.point_index))
    for band_share in (*_BAND_FACTOR ** np.arange(1, _BAND_STEPS + 1), 0.0):
        if len(followed_index) == 0:
            break
        point_index = motions.point_index[followed_index]
        bands = np.repeat(band_share * FULL_BANDS, len(point_index), axis=0)
        old_unknowns = unknowns[followed_index]
        new_motions, is_solved = _solve_near_motions(
            problem, _Motions(point_index, old_unknowns, bands)
        )
        cage_speed_change = np.abs(new_motions.unknowns - old_unknowns)[:, _CAGE_SPEED_INDEX]
        is_followed = is_solved & (
            cage_speed_change < _LARGEST_SAME_MOTION_CHANGE * scale[point_index, _CAGE_SPEED_INDEX]
        )
        followed_index = followed_index[is_followed]
        unknowns[followed_index] = new_motions.unknowns[is_followed]
    holds_without_bands = np.isin(np.arange(len(unknowns)), followed_index)
    unbanded_motions = _Motions(motions.point_index, unknowns, np.zeros_like(motions.bands))
    return unbanded_motions, holds_without_bands


def _solve_near_motions(problem: FrictionProblem, motions: _Motions) -> tuple[_Motions, BoolArray]:
    """Motions near others, with the bands of these, and whether each one was found."""
    banded_problem = replace(problem.at_points(motions.point_index), bands=motions.bands)
    scale = banded_problem.scale()
    nearby_equilibria = NearbyEquilibria.from_unknowns(banded_problem, motions.unknowns)
    solution = solve_near(
        banded_problem.residuals, motions.unknowns, scale, nearby_equilibria.inverse_jacobian
    )
    unsolved_index = np.flatnonzero(~solution.converged)
    unsolved_equations = banded_problem.at_points(unsolved_index).residuals
    newton_solution = solve(
        unsolved_equations,
        motions.unknowns[unsolved_index],
        scale[unsolved_index],
        _NEWTON_ITERATIONS,
    )
    solution.replace_points(unsolved_index, newton_solution)
    return replace(motions, unknowns=solution.unknowns), solution.converged


def _shrink_bands(problem: FrictionProblem, motions: _Motions) -> _Motions:
    """Motions after their bands have shrunk, one band after the other.

    Motions whose curve turns back are left out. Those whose curve stalls keep the bands of the last
    step before, unless they are exact without bands.
    """
    # rounding decides how far a curve gets before it stalls, but hardly on which step that is
    stalled_motions = motions.select(np.arange(0))
    motions_at_last_step = stalled_motions
    for band_shares in (
        _shares_as_entrainment_band_shrinks,
        _shares_as_rotation_band_shrinks,
        _shares_as_rolling_band_shrinks,
    ):
        shrinking_problem = problem.at_points(motions.point_index)

        def residuals(
            unknowns: FloatArray,
            parameter: FloatArray,
            point_index: IndexArray,
            shrinking_problem: FrictionProblem = shrinking_problem,
            band_shares: Callable[[FloatArray], FloatArray] = band_shares,
        ) -> FloatArray:
            bands = FULL_BANDS * band_shares(parameter)
            banded_problem = replace(shrinking_problem.at_points(point_index), bands=bands)
            return banded_problem.residuals(unknowns, np.arange(len(point_index)))

        crossings = trace(
            residuals,
            motions.unknowns,
            shrinking_problem.scale(),
            start_parameter=np.zeros(len(motions.point_index)),
            wanted_value=1.0,
            first_value=0.0,
            last_value=1.0,
            kink_length=_KINK_LENGTH,
            tolerance=_BAND_TOLERANCE,
        )
        has_stalled = ~crossings.reached_last_value & ~crossings.turned_back
        end_bands = FULL_BANDS * band_shares(crossings.end_parameter)
        end_motions = _solve_with_bands(problem, motions, crossings.end_unknowns, end_bands)
        stalled_motions = stalled_motions.joined(end_motions.select(has_stalled))
        last_step = np.floor(crossings.end_parameter[has_stalled] / _STALL_STEP) * _STALL_STEP
        step_motions = _solve_with_bands(
            problem,
            motions.select(has_stalled),
            crossings.end_unknowns[has_stalled],
            FULL_BANDS * band_shares(last_step),
        )
        motions_at_last_step = motions_at_last_step.joined(step_motions)
        motions = end_motions.select(crossings.reached_last_value)
    # a curve may stall beside a motion that is exact without bands
    narrow_motions = motions.joined(stalled_motions)
    unbanded_motions = replace(narrow_motions, bands=np.zeros_like(narrow_motions.bands))
    solved_motions, is_solved = _solve_near_motions(problem, unbanded_motions)
    cage_speed_change = np.abs(solved_motions.unknowns - narrow_motions.unknowns)[
        :, _CAGE_SPEED_INDEX
    ]
    holds_without_bands = is_solved & (
        cage_speed_change
        < _LARGEST_SAME_MOTION_CHANGE
        * problem.scale()[narrow_motions.point_index, _CAGE_SPEED_INDEX]
    )
    held_motions = motions.joined(motions_at_last_step).select(~holds_without_bands)
    return held_motions.joined(solved_motions.select(holds_without_bands))


def _solve_with_bands(
    problem: FrictionProblem, motions: _Motions, near_unknowns: FloatArray, bands: FloatArray
) -> _Motions:
    """Motions with other bands, near some unknowns; where there is none the motions as they are."""
    # at the edge of a narrow band the slopes may not lead to the solution
    solved_motions, is_solved = _solve_near_motions(
        problem, _Motions(motions.point_index, near_unknowns, bands)
    )
    is_changed = is_solved[:, np.newaxis]
    return _Motions(
        point_index=motions.point_index,
        unknowns=np.where(is_changed, solved_motions.unknowns, motions.unknowns),
        bands=np.where(is_changed, bands, motions.bands),
    )


def _shares_as_entrainment_band_shrinks(parameter: FloatArray) -> FloatArray:
    """Shares of the bands, (..., 3), while the band of the entrainment speed shrinks to 0."""
    ones = np.ones_like(parameter)
    return np.stack([ones, ones, np.maximum(1 - parameter, 0.0)], axis=-1)


def _shares_as_rotation_band_shrinks(parameter: FloatArray) -> FloatArray:
    """Shares of the bands, (..., 3), while the band of the ball's rotation shrinks to 0."""
    return np.stack(
        [np.ones_like(parameter), np.maximum(1 - parameter, 0.0), 0 * parameter], axis=-1
    )


def _shares_as_rolling_band_shrinks(parameter: FloatArray) -> FloatArray:
    """Shares of the bands, (..., 3), while the band of the rolling speed shrinks to its limit."""
    zeros = np.zeros_like(parameter)
    return np.stack([_NARROWEST_BAND**parameter, zeros, zeros], axis=-1)


def _fastest_and_slowest(
    problem: FrictionProblem, motions: _Motions, is_complete: BoolArray
) -> Equilibria:
    """Equilibria of each point, with the fastest and the slowest cage."""
    scale = problem.scale()
    relative_cage_speed = (
        np.abs(motions.unknowns[:, _CAGE_SPEED_INDEX])
        / scale[motions.point_index, _CAGE_SPEED_INDEX]
    )
    ranked_motions = motions.select(np.lexsort((-relative_cage_speed, motions.point_index)))
    ranked_cage_speed = (
        np.abs(ranked_motions.unknowns[:, _CAGE_SPEED_INDEX])
        / scale[ranked_motions.point_index, _CAGE_SPEED_INDEX]
    )
    is_repeated = np.zeros(len(ranked_motions.point_index), dtype=bool)
    has_same_point = np.diff(ranked_motions.point_index) == 0
    is_repeated[1:] = has_same_point & (-np.diff(ranked_cage_speed) < _SMALLEST_SPEED_DIFFERENCE)
    distinct_motions = ranked_motions.select(~is_repeated)
    motion_count = np.bincount(distinct_motions.point_index, minlength=len(scale))
    slowest_index = np.cumsum(motion_count) - 1
    fastest_index = slowest_index - motion_count + 1
    solved_index = np.flatnonzero(motion_count > 0)
    unsolved_index = np.flatnonzero(motion_count == 0)

    def equilibrium_of_motions(motion_index: IndexArray) -> FrictionEquilibrium:
        """Equilibrium with these rows of `distinct_motions`; unsolved points have their start."""
        unknowns = np.empty_like(scale)
        bands = np.zeros((len(scale), len(NO_BANDS[0])))
        unknowns[solved_index] = distinct_motions.unknowns[motion_index[solved_index]]
        bands[solved_index] = distinct_motions.bands[motion_index[solved_index]]
        unknowns[unsolved_index] = problem.at_points(unsolved_index).start_unknowns()
        return _equilibrium_of_motion(problem, unknowns, bands)

    fastest = equilibrium_of_motions(fastest_index)
    slowest = equilibrium_of_motions(slowest_index) if (motion_count > 1).any() else fastest
    # Outside the law a curve may pass balls at rest, with motions so close to each other that
    # rounding decides how many of them are found.
    return Equilibria(fastest, slowest, motion_count, is_complete & ~fastest.outside_law())


def _equilibrium_of_motion(
    problem: FrictionProblem, unknowns: FloatArray, bands: FloatArray
) -> FrictionEquilibrium:
    """A motion of each point, with its forces."""
    banded_problem = replace(problem, bands=bands)
    balance = banded_problem.balance(unknowns)
    largest_imbalance_n = np.abs(balance.imbalance_n).max(axis=1)
    relative_imbalance = largest_imbalance_n / ball_force_scale_n(problem.bearing, problem.points)
    residual = np.where(np.isfinite(relative_imbalance), relative_imbalance, np.inf)
    converged = residual <= TOLERANCE
    equilibrium = FrictionEquilibrium(
        banded_problem, balance, Solution(unknowns, residual, converged)
    )
    # there is no equilibrium outside the range of Hertz's solution and of the groove
    converged[equilibrium.widest_contact() >= 1] = False
    return equilibrium
