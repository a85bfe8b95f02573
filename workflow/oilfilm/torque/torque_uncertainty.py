"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Each draw takes one refit of the law, moves it by the calibration of the traction rig's sensors, and
puts a random factor on each other term of the balance. The equilibrium is solved again, so that the
cage slips by what the drawn forces allow. A refit has the law's form: far beyond the tested box the
spread of the draws is true as far as this form is.

Decides: the uncertainty of torque, cage slip and power.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import scipy

from oilfilm.bearing.friction import FrictionEquilibrium, friction_equilibrium
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import TERMS, Lubrication
from oilfilm.bearing.solver import IntArray, Solution
from oilfilm.bearing.torque import cage_slip, inner_ring_torque_n_m
from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.config import TermUncertaintySettings
from oilfilm.torque.load_variables import LawInBearing
from oilfilm.traction.law import to_constants, to_internal
from oilfilm.units import RAD_S_PER_RPM, BoolArray, FloatArray

# Integration points of the draws: fewer than those of the calculated torque, whose error is shown.
_QUADRATURE = (6, 2)
# Points solved at once: about what fits a processor's cache.
_CHUNK = 2000
# Draws without an equilibrium that may be left out.
_LOST = 0.05
_INTERVAL = (0.025, 0.975)
# A gap of cage slip inside the interval parts rolling cages from skidding ones where it is as wide
# as this, and as this share of the interval.
_GAP, _GAP_SHARE = 0.03, 1 / 3
# Cage slips that two quadratures give on one branch differ by less.
_SAME_BRANCH = 0.01
_QUANTITIES = ("torque_n_m", "cage_slip", "power_w")


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
    bearing: Bearing,
    calculated: pd.DataFrame,
    lubrication: Lubrication,
    law: LawInBearing,
    terms: TermUncertaintySettings,
    count: int,
    random: np.random.Generator,
) -> pd.DataFrame:
    """Calculated friction with the standard uncertainty and 95 % interval of its results.

    Args:
        bearing: The bearing.
        calculated: Of `OilInBearing.run` with this law.
        lubrication: The oil at each point.
        law: A law that knows its refits.
        terms: Relative standard uncertainty of each other term.
        count: Number of draws.
        random: Source of the random numbers.

    Returns:
        The same with `power_w`, with `_uncertainty`, `_lower` and `_upper` of torque, cage slip and
        power (NaN without refits, or where draws have no equilibrium), and `draws_split`.
    """
    speed = calculated["inner_speed_rpm"].to_numpy() * RAD_S_PER_RPM
    calculated = calculated.assign(power_w=calculated["torque_n_m"] * speed)
    slip = torque = np.full((count, len(calculated)), np.nan)
    if draws := _draws(law.fitted, terms, count, random):
        slip, torque = _drawn(bearing, calculated, lubrication, law, *draws)
    drawn = dict(zip(_QUANTITIES, (torque, slip, torque * speed), strict=True))
    found = np.isfinite(torque).mean(axis=0) >= 1 - _LOST
    enough = found & calculated["converged"].to_numpy()
    columns: dict[str, FloatArray] = {}
    for name, values in drawn.items():
        known = np.where(enough, values, 0.0)
        ends = np.nanquantile(known, _INTERVAL, axis=0)
        statistics = {"uncertainty": np.nanstd(known, axis=0, ddof=1)}
        statistics |= {"lower": ends[0], "upper": ends[1]}
        columns |= {
            f"{name}_{which}": np.where(enough, value, np.nan)
            for which, value in statistics.items()
        }
    return calculated.assign(**columns, draws_split=enough & _split(slip))


def _drawn(
    bearing: Bearing,
    calculated: pd.DataFrame,
    lubrication: Lubrication,
    law: LawInBearing,
    constants: FloatArray,
    factors: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Cage slip and torque of each draw at each point, shape (draws, points); NaN without them.

    The search starts from the calculated equilibrium, so that draws stay on its branch while it
    exists. The draws' coarser quadrature is made good by the difference at the calculated point.
    """
    load, speed = calculated[["axial_load_n", "inner_speed_rpm"]].to_numpy().T
    points = OperatingPoints.axial(load, speed * RAD_S_PER_RPM)
    own = friction_equilibrium(bearing, points, lubrication, law, _QUADRATURE)
    count, size = len(factors), len(calculated)

    def search(point: IntArray, draw: IntArray, near: Solution) -> tuple[Solution, FloatArray]:
        at = points.at(point)
        oil = replace(lubrication.at(point), factors=factors[draw])
        drawn_law = law.with_constants(constants[draw])
        found = friction_equilibrium(bearing, at, oil, drawn_law, _QUADRATURE, near)
        return found.solution, _slip_and_torque(bearing, at, found)

    def of_all_draws(which: IntArray) -> FloatArray:
        """Cage slip and torque of all draws at some points, shape (2, points, draws)."""
        point, draw = np.repeat(which, count), np.tile(np.arange(count), len(which))
        solution, results = search(point, draw, own.solution.at(point))
        # a draw whose branch has ended is on the other one: near the slowest cage of its point
        slowest = np.nan_to_num(results[0].reshape(-1, count), nan=-np.inf).argmax(axis=1)
        if len(lost := np.flatnonzero(np.isnan(results[0]))):
            near = solution.at(count * (lost // count) + slowest[lost // count])
            results[:, lost] = search(point[lost], draw[lost], near)[1]
        return results.reshape(2, -1, count)

    chunks = np.array_split(np.arange(size), -(-size * count // _CHUNK))
    results = np.concatenate([of_all_draws(chunk) for chunk in chunks], axis=1)
    off = calculated[["cage_slip", "torque_n_m"]].to_numpy().T
    off = off - _slip_and_torque(bearing, points, own)
    # beside a fold the coarser quadrature may end on the other branch: there is no difference then
    same = np.abs(off[0]) < _SAME_BRANCH
    slip, torque = np.swapaxes(results, 1, 2) + np.where(same, off, 0.0)[:, np.newaxis]
    return slip, torque


def _slip_and_torque(
    bearing: Bearing, points: OperatingPoints, found: FrictionEquilibrium
) -> FloatArray:
    """Cage slip and torque of equilibria, shape (2, points); NaN where there is none."""
    slips = cage_slip(bearing, points, found.balance.contacts, found.balance.motion).mean(axis=1)
    moments = inner_ring_torque_n_m(found.balance, found.balls_per_row)
    return np.where(found.solution.converged, np.stack([slips, moments]), np.nan)


def _split(slip: FloatArray) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium come last and count as the one before
    ranked = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first, last = (round(end * (len(slip) - 1)) for end in _INTERVAL)
    within = ranked[first : last + 1]
    widest = np.diff(within, axis=0).max(axis=0)
    return np.asarray((widest > _GAP) & (widest > _GAP_SHARE * (within[-1] - within[0])))
