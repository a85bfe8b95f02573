"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Each draw changes these inputs:

- the law: one refit, moved by calibration errors of the traction rig's sensors;
- all traction: a factor with the error of a run, by the surface of measured mu;
- the oil's viscosity, where a similar oil stands in for the oil;
- each other term of the balance: a random factor.

The equilibrium is solved again for each draw, so that the cage slips as the drawn forces allow.
Drag and the other terms belong to the bearing, calibration to the rig. A draw has the same values
of them for all oils. Far beyond the tested range the spread is only as good as the law's form.

Decides: the uncertainty of torque, cage slip and power.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from oilfilm.base.randomness import generator
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.equilibria import Neighbour, friction_equilibrium
from oilfilm.bearing.friction import COARSE, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.resistance import TERMS
from oilfilm.bearing.torque import film_ratio
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.oils import Oil
from oilfilm.settings.config import BearingSettings, TorqueDrawSettings
from oilfilm.torque.load_variables import LawInBearing, law_of_groups
from oilfilm.traction.law import to_constants, to_internal

# Ends of every interval of the project: 95 %.
_INTERVAL = (0.025, 0.975)
# Cage slips from two quadratures on the same branch differ by less than this.
_SAME_BRANCH_SLIP = 0.01
# Sensors of a traction rig whose calibration changes a fit.
_SENSORS = 8
# Results of each draw, as columns of the calculated results.
DRAWN = ("torque_n_m", "cage_slip", "lambda_ratio")


def term_factors(settings: BearingSettings, normal: FloatArray) -> FloatArray:
    """Random factors on each of `TERMS`, shape (draws, terms).

    The drag is drawn from the range of the oil's share (`Uncertain.at`). The factors on the other
    terms are log-normal with mean 1.

    Args:
        settings: Range of the drag and uncertainties of the other terms.
        normal: Standard normal numbers, shape (draws, terms).
    """
    factors = np.empty_like(normal)
    for column, term in enumerate(TERMS):
        if term == "drag":
            fraction = settings.uncertain()["oil_volume_fraction"]
            drawn = fraction.at(scipy.special.ndtr(normal[:, column]))
            factors[:, column] = drawn / fraction.value
        else:
            spread = np.sqrt(np.log1p(getattr(settings.term_uncertainty, term) ** 2))
            factors[:, column] = np.exp(spread * normal[:, column] - spread**2 / 2)
    return factors


class Draws(NamedTuple):
    """Draws of one oil's law and properties.

    Attributes:
        constants: Constants of the law, shape (draws, constants).
        traction_errors: Error of ln mu in a run, shape (draws,).
        oil_factors: Factors on viscosity and pressure-viscosity coefficient, shape (draws, 2).
    """

    constants: FloatArray
    traction_errors: FloatArray
    oil_factors: FloatArray


def has_draws(fitted: FittedLaw) -> bool:
    """Whether a law has the refits that its draws are made of."""
    coefficients = fitted.coefficients
    return len(coefficients.spread) >= 2 and not np.isnan(coefficients.constants).any()


def _draw_oil(
    fitted: FittedLaw,
    oil: Oil,
    settings: BearingSettings,
    sensors: FloatArray,
    random: np.random.Generator,
) -> Draws | None:
    """Draws of an oil; None without refits of its law.

    Args:
        fitted: The law with its refits.
        oil: The oil.
        settings: Uncertainty of the properties of a stand-in.
        sensors: Errors of the rig's sensors over their uncertainties, shape (draws, sensors).
        random: Source of random numbers for this oil alone.
    """
    if not has_draws(fitted):
        return None
    law, coefficients, count = fitted.law, fitted.coefficients, len(sensors)
    refits = coefficients.spread
    # each refit is drawn equally often, in random order
    chosen = random.permutation(np.resize(random.permutation(len(refits)), count))
    shifts = to_internal(law, coefficients.shifted) - to_internal(law, coefficients.constants)
    internal = to_internal(law, refits[chosen]) + sensors[:, : len(shifts)] @ shifts
    viscosity_normal, pressure_normal, run_normal = _normal(count, 3, random).T
    uncertainty = settings.stand_in_uncertainty
    viscosity_spread = uncertainty.viscosity * oil.stand_in
    pressure_spread = uncertainty.pressure_viscosity_coefficient * oil.stand_in
    logarithms = [viscosity_spread * viscosity_normal, pressure_spread * pressure_normal]
    return Draws(
        constants=to_constants(law, internal),
        traction_errors=np.nan_to_num(coefficients.run_sd) * run_normal,
        oil_factors=np.exp(np.column_stack(logarithms)),
    )


def _normal(draws: int, variables: int, random: np.random.Generator) -> FloatArray:
    """Standard normal numbers, (draws, variables), with one draw from each equal slice."""
    slices = np.array([random.permutation(draws) for _ in range(variables)])
    position_in_slice = random.random((variables, draws))
    return np.asarray(scipy.special.ndtri((slices + position_in_slice) / draws).T)


def draw_results(
    equilibrium: FrictionEquilibrium,
    groups: Sequence[tuple[str, Oil, LawInBearing]],
    group_of_point: IndexArray,
    calculated: pd.DataFrame,
    settings: BearingSettings,
    seed: int,
) -> FloatArray:
    """Torque, cage slip and lambda of each draw, shape (3, draws, points).

    Args:
        equilibrium: The equilibria without draws.
        groups: Name of the oil, its properties and its law, for each group of points.
        group_of_point: Index of each point's group, in ascending order.
        calculated: The results without draws.
        settings: Uncertainty of drag, other terms and stand-ins; number of draws.
        seed: Seed of the configuration. All oils and load variables share the random numbers of
            bearing and rig. Each oil has random numbers of its own for law and properties.

    Returns:
        The results, NaN without refits and where a draw has no equilibrium.
    """
    count = settings.uncertainty.draws
    shared = _normal(count, len(TERMS) + _SENSORS, generator(seed, "torque uncertainty"))
    factors = term_factors(settings, shared[:, : len(TERMS)])
    sensors = shared[:, len(TERMS) :]
    draws_of_groups = []
    for name, oil, law in groups:
        random = generator(seed, "torque uncertainty", name)
        draws_of_groups.append(_draw_oil(law.fitted, oil, settings, sensors, random))
    group_has_draws = np.array([draws is not None for draws in draws_of_groups])
    converged = calculated["converged"].to_numpy(dtype=bool)
    which = np.flatnonzero(group_has_draws[group_of_point] & converged)
    results = np.full((len(DRAWN), count, len(group_of_point)), np.nan)
    if len(which) == 0:
        return results
    law_and_draws = [(groups[group][2], draws_of_groups[group]) for group in group_of_point[which]]
    coarse = replace(equilibrium.problem.at_points(which), rule=gauss_rule(*COARSE))
    # A draw starts from the equilibrium of its point without draws. It stays on that branch while
    # the branch exists. Otherwise its equilibrium is searched without a neighbour.
    start = Neighbour.of(coarse, equilibrium.solution.unknowns[which])
    without_draws = friction_equilibrium(coarse, start)
    problem = _with_draws(coarse, law_and_draws, factors)
    point = np.repeat(np.arange(len(which)), count)
    neighbour = Neighbour.of(coarse, without_draws.solution.unknowns).at_points(point)
    drawn = _results(friction_equilibrium(problem, neighbour))
    drawn = np.swapaxes(drawn.reshape(len(DRAWN), -1, count), 1, 2)
    # Corrects the coarse quadrature of the draws. At a fold it may end on the other branch.
    correction = calculated.iloc[which][list(DRAWN)].to_numpy().T - _results(without_draws)
    same_branch = np.abs(correction[1]) < _SAME_BRANCH_SLIP
    results[..., which] = drawn + np.where(same_branch, correction, 0.0)[:, np.newaxis]
    return results


def _with_draws(
    problem: FrictionProblem,
    law_and_draws: Sequence[tuple[LawInBearing, Draws]],
    factors: FloatArray,
) -> FrictionProblem:
    """The problem of all draws of all points, with the draws of a point next to each other.

    Args:
        problem: The points.
        law_and_draws: Law and draws of each point.
        factors: Factors on the terms of the balance, shape (draws, terms).
    """
    count, points = len(factors), len(law_and_draws)
    laws = [law.with_constants(draws.constants) for law, draws in law_and_draws]
    # the error of a run is a factor on all traction of a draw
    errors = np.array([draws.traction_errors for _, draws in law_and_draws])
    oil_factors = np.concatenate([draws.oil_factors for _, draws in law_and_draws])
    viscosity_factor, pressure_factor = oil_factors.T
    point = np.repeat(np.arange(points), count)
    lubrication = problem.lubrication.at_points(point)
    inlet = lubrication.oil
    oil = replace(
        inlet,
        dynamic_viscosity_pa_s=inlet.dynamic_viscosity_pa_s * viscosity_factor,
        pressure_viscosity_coefficient_1_pa=(
            inlet.pressure_viscosity_coefficient_1_pa * pressure_factor
        ),
    )
    traction_factor = np.exp(errors).ravel()
    all_factors = np.column_stack([traction_factor, np.tile(factors, (points, 1))])
    return replace(
        problem.at_points(point),
        law=law_of_groups(laws, [count] * points),
        lubrication=replace(lubrication, oil=oil, factors=all_factors),
    )


def with_uncertainty(
    calculated: pd.DataFrame,
    draws: FloatArray,
    was_drawn: BoolArray,
    speed_rad_s: FloatArray,
    settings: TorqueDrawSettings,
) -> pd.DataFrame:
    """Calculated friction with the standard uncertainty and 95 % interval of its results.

    Args:
        calculated: The results without draws.
        draws: Draws of `draw_results`.
        was_drawn: Points that have draws, with or without equilibria, shape (points,).
        speed_rad_s: Speed of the inner ring.
        settings: How many draws may be lost, and when they are split.

    Returns:
        The results with `power_w`; with `_uncertainty`, `_lower` and `_upper` of torque, cage slip
        and power; with `draws_split` and `draws_lost`. Intervals are NaN and `draws_split` is null
        without refits, or where too many draws have no equilibrium. `draws_lost` is NaN where
        nothing was drawn.
    """
    torque, slip, _ = draws
    has_equilibrium = np.isfinite(torque)
    enough = _has_enough_draws(has_equilibrium, settings.lost_share_max)
    drawn = {"torque_n_m": torque, "cage_slip": slip, "power_w": torque * speed_rad_s}
    columns: dict[str, FloatArray] = {}
    for name, values in drawn.items():
        counted = np.where(enough, values, 0.0)
        lower, upper = np.nanquantile(counted, _INTERVAL, axis=0)
        spread = np.nanstd(counted, axis=0, ddof=1)
        columns[f"{name}_uncertainty"] = np.where(enough, spread, np.nan)
        columns[f"{name}_lower"] = np.where(enough, lower, np.nan)
        columns[f"{name}_upper"] = np.where(enough, upper, np.nan)
    split = pd.Series(_is_split(slip, settings), calculated.index, dtype="boolean")
    return calculated.assign(
        power_w=calculated["torque_n_m"] * speed_rad_s,
        **columns,
        draws_split=split.where(enough),
        draws_lost=np.where(was_drawn, (~has_equilibrium).sum(axis=0), np.nan),
    )


def _has_enough_draws(has_equilibrium: BoolArray, lost_share_max: float) -> BoolArray:
    """Points at which enough draws, shape (draws, points), have an equilibrium."""
    # counts are compared, because a mean may be rounded to either side of the limit
    lost = (~has_equilibrium).sum(axis=0)
    return np.asarray(lost <= lost_share_max * len(has_equilibrium))


def _results(equilibrium: FrictionEquilibrium) -> FloatArray:
    """`DRAWN` of equilibria, shape (3, points); NaN where there is no equilibrium."""
    lambda_ratio, _ = film_ratio(equilibrium)
    values = np.stack([equilibrium.torque_n_m(), equilibrium.cage_slip(), lambda_ratio])
    return np.where(equilibrium.solution.converged, values, np.nan)


def _is_split(slip: FloatArray, settings: TorqueDrawSettings) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium are sorted to the end and repeat the largest slip
    ranked = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first, last = (round(quantile * (len(slip) - 1)) for quantile in _INTERVAL)
    interval = ranked[first : last + 1]
    widest_gap = np.diff(interval, axis=0).max(axis=0)
    least_gap = settings.split_gap_share * (interval[-1] - interval[0])
    return np.asarray((widest_gap > settings.split_gap) & (widest_gap > least_gap))
