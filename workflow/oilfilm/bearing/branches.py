"""Whether a bearing's equilibrium is the only one: a rolling and a skidding cage side by side.

Traction that falls with slip can hold a cage at two speeds: the film of a rolling contact pulls
hard enough, that of a skidding one no longer does. Which of them a bearing takes depends on its
past. Here one search comes from stronger traction, where the cage rolls, and one from weaker
traction, where it skids; where they end apart there are two equilibria. A branch that is connected
with neither would be missed.

Decides: when a cage may roll or skid at one operating point.
"""

from dataclasses import replace

import numpy as np

from oilfilm.bearing.ellipse import grid
from oilfilm.bearing.friction import COARSE, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.solver import solve
from oilfilm.units import FloatArray

# Factors on all traction on the way down to the law; the way up has the reciprocals.
_FACTORS = (4.0, 2.0, 1.4, 1.15, 1.0)
# Speed of a skidding cage at the start, over that of a rolling one.
_SKIDDING = 0.5
# Jacobians of one step.
_MAX_ITERATIONS = 12
# Cage slips of two equilibria are further apart.
_APART = 1e-3


def other_equilibrium(
    problem: FrictionProblem, known_cage_slip: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Cage slip and torque of the equilibrium that is not the known one, where there is another.

    Args:
        problem: Bearing, loads, speeds, oil and law; the outer ring at rest.
        known_cage_slip: Of the known equilibria, shape (points,); NaN where there is none.

    Returns:
        Two arrays of shape (points,), NaN where no second equilibrium was found.
    """
    count = len(known_cage_slip)
    whole = problem.at(np.tile(np.arange(count), 2))
    unknowns, scale = whole.start(), whole.scale()
    # cage and balls that have lost half their speed: they roll on the outer race and slide on the
    # inner one
    unknowns[count:, 2:6] *= _SKIDDING
    for factor in _FACTORS:
        both_ways = whole.lubrication.with_traction(np.repeat([factor, 1 / factor], count))
        # fewer nodes are enough on the way
        rule = whole.rule if factor == _FACTORS[-1] else grid(*COARSE)
        part = replace(whole, lubrication=both_ways, rule=rule)
        end = solve(part.equations(1.0), unknowns, scale, _MAX_ITERATIONS)
        # what is lost at one factor starts at the next from where it was
        unknowns = np.where(end.converged[:, np.newaxis], end.unknowns, unknowns)
    final = FrictionEquilibrium(whole, whole.balance(unknowns), end)
    slip = np.where(end.converged, final.cage_slip(), np.nan).reshape(2, count)
    away = np.nan_to_num(np.abs(slip - known_cage_slip))
    chosen = away.argmax(axis=0), np.arange(count)
    apart = away[chosen] > _APART
    torque = final.torque_n_m().reshape(2, count)
    return np.where(apart, slip[chosen], np.nan), np.where(apart, torque[chosen], np.nan)
