"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Each draw takes one refit of the law, moves it by the calibration of the traction rig's sensors,
scales it and its slip by the error of a curve left out of the fit, draws the oil's viscosity where
a similar oil stands in for it, and puts a random factor on each other term of the balance. The
equilibrium is solved again, so that the cage slips by what the drawn forces allow. Drag and the
other terms belong to the bearing and calibration to the rig: a draw has the same of them for all
oils. Far beyond the tested box the spread of the draws is true as far as the law's form is.

Decides: the uncertainty of torque, cage slip and power.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from oilfilm.bearing.ellipse import grid
from oilfilm.bearing.equilibria import Neighbour, friction_equilibrium
from oilfilm.bearing.friction import COARSE, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.resistance import TERMS
from oilfilm.bearing.torque import film_ratio
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import LEVELS, Unseen
from oilfilm.physics.oils import Oil
from oilfilm.randomness import generator
from oilfilm.settings.config import BearingSettings
from oilfilm.torque.load_variables import LawInBearing, law_of_groups
from oilfilm.traction.law import to_constants, to_internal
from oilfilm.units import BoolArray, FloatArray, IndexArray

# Draws without an equilibrium that may be left out.
_LOST = 0.05
_INTERVAL = (0.025, 0.975)
# A gap of cage slip inside the interval parts rolling cages from skidding ones where it is as wide
# as this, and as this share of the interval.
_GAP, _GAP_SHARE = 0.03, 1 / 3
# Cage slips that two quadratures give on one branch differ by less.
_SAME_BRANCH = 0.01
# Sensors of a traction rig whose calibration moves a fit.
_SENSORS = 8
# What is drawn, as columns of the calculated results.
DRAWN = ("torque_n_m", "cage_slip", "lambda_ratio")


def term_factors(settings: BearingSettings, normal: FloatArray) -> FloatArray:
    """A factor on each of `TERMS` by standard normal numbers of the same shape (draws, terms).

    Drag is uniform between the ends of its calibrated range on a logarithmic scale; the factors on
    the others are log-normal with mean 1.
    """
    factors = np.empty_like(normal)
    for place, term in enumerate(TERMS):
        if term == "drag":
            low, high = settings.oil_volume_fraction_range
            share = scipy.special.ndtr(normal[:, place])
            factors[:, place] = low * (high / low) ** share / settings.oil_volume_fraction
        else:
            spread = np.sqrt(np.log1p(getattr(settings.term_uncertainty, term) ** 2))
            factors[:, place] = np.exp(spread * normal[:, place] - spread**2 / 2)
    return factors


class Draws(NamedTuple):
    """Draws of one oil's law and properties.

    Attributes:
        constants: Of the law, shape (draws, constants).
        scores: Error of a curve left out of the fit, over its expected size, shape (draws,).
        oil: Factors on viscosity and pressure-viscosity coefficient, shape (draws, 2).
    """

    constants: FloatArray
    scores: FloatArray
    oil: FloatArray


def _draws(
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
        settings: How far a stand-in's properties may be off.
        sensors: Errors of the rig's sensors over their uncertainties, shape (draws, sensors).
        random: Source of the oil's own random numbers.
    """
    law, coefficients, count = fitted.law, fitted.coefficients, len(sensors)
    refits = coefficients.spread
    if len(refits) < 2 or np.isnan(coefficients.constants).any():
        return None
    chosen = random.permutation(np.resize(random.permutation(len(refits)), count))
    shifts = to_internal(law, coefficients.shifted) - to_internal(law, coefficients.constants)
    moved = to_internal(law, refits[chosen]) + sensors[:, : len(shifts)] @ shifts
    assumed = settings.stand_in_uncertainty
    spread = [assumed.viscosity, assumed.pressure_viscosity_coefficient]
    normal = _normal(count, 4, random)
    scores, of_slip = (_scores(coefficients.unseen, each) for each in normal[:, 2:].T)
    slip = np.nan_to_num(coefficients.unseen.slip) * of_slip
    moved = moved + slip[:, np.newaxis] * law.slip_scale
    factors = np.exp(np.array(spread) * oil.stand_in * normal[:, :2])
    return Draws(to_constants(law, moved), scores, factors)


def _scores(unseen: Unseen, normal: FloatArray) -> FloatArray:
    """Errors over their expected size with the quantiles of curves left out; 0 where unknown."""
    known = np.isfinite(unseen.quantiles)
    if not known.any():
        return np.zeros_like(normal)
    levels, sizes = np.array(LEVELS)[known], np.asarray(unseen.quantiles)[known]
    level = 2 * scipy.special.ndtr(np.abs(normal)) - 1
    return np.asarray(np.sign(normal) * np.interp(level, [0.0, *levels], [0.0, *sizes]))


def _normal(draws: int, variables: int, random: np.random.Generator) -> FloatArray:
    """Standard normal numbers, each variable stratified: one draw from each equal slice."""
    slices = [random.permutation(draws) for _ in range(variables)]
    within = random.random((variables, draws))
    return np.asarray(scipy.special.ndtri((np.array(slices) + within) / draws).T)


def drawn(
    found: FrictionEquilibrium,
    groups: Sequence[tuple[str, Oil, LawInBearing]],
    number: IndexArray,
    calculated: pd.DataFrame,
    settings: BearingSettings,
    seed: int,
) -> FloatArray:
    """Torque, cage slip and lambda of each draw, shape (3, draws, points).

    Args:
        found: The equilibria without draws.
        groups: Name of an oil, its properties and its law, of each group of points.
        number: Index of each point's group, rising.
        calculated: The results without draws.
        settings: Uncertainty of drag, other terms and stand-ins; number of draws.
        seed: Of the configuration. All oils and load variables share the numbers of bearing and
            rig; each oil has its own for law and properties.

    Returns:
        NaN without refits, and where a draw has no equilibrium.
    """
    count = settings.uncertainty.draws
    shared = _normal(count, len(TERMS) + _SENSORS, generator(seed, "torque uncertainty"))
    factors = term_factors(settings, shared[:, : len(TERMS)])
    draws = []
    for name, oil, law in groups:
        own = generator(seed, "torque uncertainty", name)
        draws.append(_draws(law.fitted, oil, settings, shared[:, len(TERMS) :], own))
    has_draws = np.array([each is not None for each in draws])[number]
    which = np.flatnonzero(has_draws & calculated["converged"].to_numpy(dtype=bool))
    results = np.full((len(DRAWN), count, len(number)), np.nan)
    if len(which) == 0:
        return results
    known, of_point = calculated.iloc[which], [(groups[at][2], draws[at]) for at in number[which]]
    coarse = replace(found.problem.at_points(which), rule=grid(*COARSE))
    # a draw starts from its point's own equilibrium without draws, so that it stays on that branch
    # while the branch exists; where it has ended, the draw is searched by itself
    unknowns = found.solution.unknowns[which]
    own_motion = friction_equilibrium(coarse, Neighbour.of(coarse, unknowns))
    every = _with_draws(coarse, of_point, factors, known["mean_traction_coefficient"].to_numpy())
    point = np.repeat(np.arange(len(which)), count)
    neighbour = Neighbour.of(coarse, own_motion.solution.unknowns).at_points(point)
    values = _results(friction_equilibrium(every, neighbour))
    # all draws have the coarser quadrature; beside a fold it may end on the other branch
    off = known[[*DRAWN]].to_numpy().T - _results(own_motion)
    same = np.abs(off[1]) < _SAME_BRANCH
    drawn_values = np.swapaxes(values.reshape(len(DRAWN), -1, count), 1, 2)
    results[..., which] = drawn_values + np.where(same, off, 0.0)[:, np.newaxis]
    return results


def _with_draws(
    problem: FrictionProblem,
    of_point: Sequence[tuple[LawInBearing, Draws]],
    factors: FloatArray,
    mean_traction: FloatArray,
) -> FrictionProblem:
    """Every draw of every point.

    Args:
        problem: The points.
        of_point: Law and draws of each.
        factors: On the terms of the balance, shape (draws, terms).
        mean_traction: Mean traction coefficient of each point.
    """
    count, points = len(factors), len(of_point)
    laws = [law.with_constants(draws.constants) for law, draws in of_point]
    # the part of the slip is in the constants; the two others go with all traction of a draw, as in
    # `oilfilm.fits.interval.Band.ends`
    unseen = [law.fitted.coefficients.unseen for law, _ in of_point]
    pairs = zip(unseen, mean_traction, strict=True)
    sizes = np.nan_to_num([np.hypot(each.relative, each.absolute / mu) for each, mu in pairs])
    scores = np.array([draws.scores for _, draws in of_point])
    viscosity, pressure = np.concatenate([draws.oil for _, draws in of_point]).T
    point = np.repeat(np.arange(points), count)
    lubrication = problem.lubrication.at_points(point)
    inlet = lubrication.oil
    oil = replace(
        inlet,
        dynamic_viscosity_pa_s=inlet.dynamic_viscosity_pa_s * viscosity,
        pressure_viscosity_coefficient_1_pa=inlet.pressure_viscosity_coefficient_1_pa * pressure,
    )
    on_traction = np.exp(np.arcsinh(sizes[:, np.newaxis] * scores)).ravel()
    every = np.column_stack([on_traction, np.tile(factors, (points, 1))])
    return replace(
        problem.at_points(point),
        law=law_of_groups(laws, [count] * points),
        lubrication=replace(lubrication, oil=oil, factors=every),
    )


def with_uncertainty(
    calculated: pd.DataFrame, draws: FloatArray, speed_rad_s: FloatArray
) -> pd.DataFrame:
    """Calculated friction with the standard uncertainty and 95 % interval of its results.

    Args:
        calculated: The results without draws.
        draws: As of `drawn`.
        speed_rad_s: Of the inner ring.

    Returns:
        The same with `power_w`, with `_uncertainty`, `_lower` and `_upper` of torque, cage slip and
        power (NaN without refits, or where draws have no equilibrium), `draws_split`, null there
        as well, and `draws_lost`.
    """
    torque, slip, _ = draws
    answered = np.isfinite(torque)
    enough = _enough(answered)
    power = torque * speed_rad_s, calculated["torque_n_m"] * speed_rad_s
    columns: dict[str, FloatArray] = {}
    for name, values in (("torque_n_m", torque), ("cage_slip", slip), ("power_w", power[0])):
        found = np.where(enough, values, 0.0)
        lower, upper = np.nanquantile(found, _INTERVAL, axis=0)
        spread = np.nanstd(found, axis=0, ddof=1)
        for suffix, value in {"uncertainty": spread, "lower": lower, "upper": upper}.items():
            columns[f"{name}_{suffix}"] = np.where(enough, value, np.nan)
    drawn_at_all = answered.any(axis=0)
    return calculated.assign(
        power_w=power[1],
        **columns,
        draws_split=pd.Series(_split(slip), calculated.index, dtype="boolean").where(enough),
        draws_lost=np.where(drawn_at_all, (~answered).sum(axis=0), 0),
    )


def _enough(answered: BoolArray) -> BoolArray:
    """Points at which so many draws, shape (draws, points), have an answer that they count."""
    # counted, as a mean may be rounded to either side of the limit
    return np.asarray((~answered).sum(axis=0) <= _LOST * len(answered))


def _results(found: FrictionEquilibrium) -> FloatArray:
    """`DRAWN` of equilibria, shape (3, points); NaN where there is none."""
    values = np.stack([found.torque_n_m(), found.cage_slip(), film_ratio(found)[0]])
    return np.where(found.solution.converged, values, np.nan)


def _split(slip: FloatArray) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium come last and count as the one before
    ranked = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first, last = (round(end * (len(slip) - 1)) for end in _INTERVAL)
    within = ranked[first : last + 1]
    widest = np.diff(within, axis=0).max(axis=0)
    return np.asarray((widest > _GAP) & (widest > _GAP_SHARE * (within[-1] - within[0])))
