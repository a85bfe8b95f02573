"""Whether a bearing's equilibrium is the only one: a rolling and a skidding cage side by side.

Traction that falls with slip can hold a cage at two speeds: the film of a rolling contact pulls
hard enough, that of a skidding one no longer does. Which of them a bearing takes depends on its
past. Here one search comes from stronger traction, where the cage rolls, and one from weaker
traction, where it skids; where they end apart there are two equilibria. A branch that is connected
with neither would be missed.

Decides: when a cage may roll or skid at one operating point.
"""

from dataclasses import dataclass, replace

import numpy as np

from oilfilm.bearing.ellipse import ScaledLaw, TractionLaw, grid, law_at
from oilfilm.bearing.friction import QUADRATURE, FrictionProblem
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.bearing.solver import solve
from oilfilm.bearing.torque import cage_slip, inner_ring_torque_n_m
from oilfilm.units import FloatArray

# Factors on all traction on the way down to the law; the way up has the reciprocals.
_FACTORS = (4.0, 2.0, 1.4, 1.15, 1.0)
# Speed of a skidding cage at the start, over that of a rolling one.
_SKIDDING = 0.5
# Jacobians of one step.
_MAX_ITERATIONS = 12
# Cage slips of two equilibria are further apart.
_APART = 1e-3


@dataclass(frozen=True)
class OtherEquilibrium:
    """A second equilibrium of each point; shapes (points,), NaN where none was found.

    Attributes:
        cage_slip: Of the cage in it.
        torque_n_m: On the inner ring.
    """

    cage_slip: FloatArray
    torque_n_m: FloatArray


def other_equilibrium(
    bearing: Bearing,
    points: OperatingPoints,
    lubrication: Lubrication,
    law: TractionLaw,
    known_cage_slip: FloatArray,
    quadrature: tuple[int, int] = QUADRATURE,
) -> OtherEquilibrium:
    """The equilibrium of each point that is not the known one, where there is another.

    Args:
        bearing: The bearing.
        points: Loads and speeds; the outer ring at rest.
        lubrication: The oil at each point.
        law: The traction law.
        known_cage_slip: Of the known equilibria, shape (points,); NaN where there is none.
        quadrature: Nodes of the ellipse, across and along the rolling direction.
    """
    count = len(known_cage_slip)
    twice = np.tile(np.arange(count), 2)
    whole = FrictionProblem(
        bearing, points.at(twice), lubrication.at(twice), law_at(law, twice), grid(*quadrature)
    )
    (own, shared), (own_scale, shared_scale) = whole.start(), whole.unknown_scales()
    # cage and balls that have lost half their speed: they roll on the outer race and slide on the
    # inner one
    shared[count:, 0] *= _SKIDDING
    own[count:, :, 2:] *= _SKIDDING
    for factor in _FACTORS:
        both_ways = ScaledLaw(whole.law, np.repeat([factor, 1 / factor], count))
        equations = replace(whole, law=both_ways).equations(1.0)
        end = solve(equations, own, shared, own_scale, shared_scale, _MAX_ITERATIONS)
        # what is lost at one factor starts at the next from where it was
        good = end.converged
        own = np.where(good[:, np.newaxis, np.newaxis], end.own, own)
        shared = np.where(good[:, np.newaxis], end.shared, shared)
    final = whole.balance(own, shared, np.arange(2 * count), share=1.0)
    slip = cage_slip(bearing, whole.points, final.contacts, final.motion).mean(axis=1)
    slip = np.where(good, slip, np.nan)
    torque = inner_ring_torque_n_m(final, bearing.ball_count / own.shape[1])
    away = np.nan_to_num(np.abs(slip.reshape(2, count) - known_cage_slip))
    apart = away.max(axis=0) > _APART
    chosen = np.where(apart, away.argmax(axis=0) * count + np.arange(count), 0)
    return OtherEquilibrium(
        np.where(apart, slip[chosen], np.nan), np.where(apart, torque[chosen], np.nan)
    )
