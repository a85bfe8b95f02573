"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Each draw takes one refit of the law, moves it by the calibration of the traction rig's sensors, and
puts a random factor on each other term of the balance. The equilibrium is solved again, so that the
cage slips by what the drawn forces allow. A refit has the law's form: far beyond the tested box the
spread of the draws is true as far as this form is.

Decides: the uncertainty of torque, cage slip and power.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import scipy

from oilfilm.bearing.ellipse import JoinedLaw, grid
from oilfilm.bearing.friction import FrictionEquilibrium, FrictionProblem, friction_equilibrium
from oilfilm.bearing.resistance import TERMS
from oilfilm.fits.fitted import FittedLaw
from oilfilm.randomness import generator
from oilfilm.settings.config import BearingSettings, TermUncertaintySettings
from oilfilm.torque.load_variables import LawInBearing
from oilfilm.traction.law import to_constants, to_internal
from oilfilm.units import BoolArray, FloatArray, IndexArray

# Integration points of the draws: fewer than those of the calculated torque, whose error is shown.
_QUADRATURE = (6, 2)
# Draws without an equilibrium that may be left out.
_LOST = 0.05
_INTERVAL = (0.025, 0.975)
# A gap of cage slip inside the interval parts rolling cages from skidding ones where it is as wide
# as this, and as this share of the interval.
_GAP, _GAP_SHARE = 0.03, 1 / 3
# Cage slips that two quadratures give on one branch differ by less.
_SAME_BRANCH = 0.01


def _draws(
    fitted: FittedLaw, terms: TermUncertaintySettings, count: int, random: np.random.Generator
) -> tuple[FloatArray, FloatArray] | None:
    """Constants of the law and a factor with mean 1 on each of `TERMS`; None without refits.

    Args:
        fitted: The law with its refits.
        terms: Relative standard uncertainty of each other term; its factors are log-normal.
        count: Number of draws, which are rows of both arrays.
        random: Source of the random numbers.
    """
    law, coefficients = fitted.law, fitted.coefficients
    refits = coefficients.spread
    if len(refits) < 2 or np.isnan(coefficients.constants).any():
        return None
    chosen = random.permutation(np.resize(random.permutation(len(refits)), count))
    shifts = to_internal(law, coefficients.shifted) - to_internal(law, coefficients.constants)
    moved = to_internal(law, refits[chosen]) + _normal(count, len(shifts), random) @ shifts
    spread = np.sqrt(np.log1p(np.square([getattr(terms, term) for term in TERMS])))
    factors = np.exp(spread * _normal(count, len(TERMS), random) - spread**2 / 2)
    return to_constants(law, moved), factors


def _normal(draws: int, variables: int, random: np.random.Generator) -> FloatArray:
    """Standard normal numbers, each variable stratified: one draw from each equal slice."""
    slices = np.array([random.permutation(draws) for _ in range(variables)], dtype=float)
    within = random.random((variables, draws))
    return np.asarray(scipy.special.ndtri((slices.reshape(variables, draws) + within) / draws).T)


def with_uncertainty(
    problem: FrictionProblem,
    laws: Mapping[tuple[str, str], LawInBearing],
    calculated: pd.DataFrame,
    settings: BearingSettings,
    seed: int,
) -> pd.DataFrame:
    """Calculated friction with the standard uncertainty and 95 % interval of its results.

    Args:
        problem: What was calculated.
        laws: The law of each oil and load variable, in the order of `problem.law`.
        calculated: Its results.
        settings: Uncertainty of the other terms, number of draws.
        seed: Of the configuration; each oil and load variable has random numbers of its own.

    Returns:
        The same with `power_w`, with `_uncertainty`, `_lower` and `_upper` of torque, cage slip and
        power (NaN without refits, or where draws have no equilibrium), and `draws_split`.
    """
    speed, count = problem.points.ring_speed_rad_s[:, 0], settings.uncertainty.draws
    calculated = calculated.assign(power_w=calculated["torque_n_m"] * speed)
    drawn = [
        _draws(
            law.fitted,
            settings.term_uncertainty,
            count,
            generator(seed, "torque uncertainty", *name),
        )
        for name, law in laws.items()
    ]
    group = calculated.groupby(["oil", "load_variable"], sort=False).ngroup()
    number: IndexArray = np.asarray(group, dtype=np.int64)
    has_draws = np.array([draws is not None for draws in drawn])[number]
    which = np.flatnonzero(has_draws & calculated["converged"].to_numpy(dtype=bool))
    slip, torque = np.full((2, count, len(number)), np.nan)
    if len(which):
        own, results = _solved(problem.at(which), [*laws.values()], number[which], drawn)
        off = calculated[["cage_slip", "torque_n_m"]].to_numpy()[which].T - own
        # beside a fold the coarser quadrature may end on the other branch: there is no difference
        same = np.abs(off[0]) < _SAME_BRANCH
        slip[:, which], torque[:, which] = results + np.where(same, off, 0.0)[:, np.newaxis]
    enough = np.isfinite(torque).mean(axis=0) >= 1 - _LOST
    columns: dict[str, FloatArray] = {}
    for name, values in (("torque_n_m", torque), ("cage_slip", slip), ("power_w", torque * speed)):
        found = np.where(enough, values, 0.0)
        lower, upper = np.nanquantile(found, _INTERVAL, axis=0)
        spread = np.nanstd(found, axis=0, ddof=1)
        for suffix, value in {"uncertainty": spread, "lower": lower, "upper": upper}.items():
            columns[f"{name}_{suffix}"] = np.where(enough, value, np.nan)
    return calculated.assign(**columns, draws_split=enough & _split(slip))


def _solved(
    problem: FrictionProblem,
    laws: Sequence[LawInBearing],
    number: IndexArray,
    drawn: Sequence[tuple[FloatArray, FloatArray] | None],
) -> tuple[FloatArray, FloatArray]:
    """Cage slip and torque without draws, (2, points), and of each draw, (2, draws, points).

    The search starts from the equilibrium without draws, so that draws stay on its branch while it
    exists. All have the coarser quadrature.
    """
    coarse = replace(problem, rule=grid(*_QUADRATURE))
    own = friction_equilibrium(coarse)
    constants, factors = zip(*(drawn[each] for each in number), strict=True)
    count = len(factors[0])
    point = np.repeat(np.arange(len(number)), count)
    of_law = [np.flatnonzero(number == each) for each in range(len(laws))]
    drawn_laws = [
        law.with_constants(np.concatenate([constants[each] for each in which]))
        if len(which)
        else law
        for law, which in zip(laws, of_law, strict=True)
    ]
    every = replace(
        coarse.at(point),
        law=JoinedLaw(drawn_laws, number[point]),
        lubrication=replace(coarse.lubrication.at(point), factors=np.concatenate(factors)),
    )
    found = friction_equilibrium(every, own.solution.unknowns[point])
    results, unknowns = _slip_and_torque(found), found.solution.unknowns
    # a draw whose branch has ended is on the other one: near the slowest cage of its point
    if len(lost := np.flatnonzero(np.isnan(results[0]))):
        slip = results[0].reshape(-1, count)
        slowest = np.nan_to_num(slip, nan=-np.inf).argmax(axis=1) + count * np.arange(len(slip))
        again = friction_equilibrium(every.at(lost), unknowns[slowest[point[lost]]])
        results[:, lost] = _slip_and_torque(again)
    return _slip_and_torque(own), np.swapaxes(results.reshape(2, -1, count), 1, 2)


def _slip_and_torque(found: FrictionEquilibrium) -> FloatArray:
    """Cage slip and torque of equilibria, shape (2, points); NaN where there is none."""
    both = np.stack([found.cage_slip(), found.torque_n_m()])
    return np.where(found.solution.converged, both, np.nan)


def _split(slip: FloatArray) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium come last and count as the one before
    ranked = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first, last = (round(end * (len(slip) - 1)) for end in _INTERVAL)
    within = ranked[first : last + 1]
    widest = np.diff(within, axis=0).max(axis=0)
    return np.asarray((widest > _GAP) & (widest > _GAP_SHARE * (within[-1] - within[0])))
