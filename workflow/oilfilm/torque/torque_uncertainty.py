"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Each draw takes one refit of the law, moves it by the calibration of the traction rig's sensors, and
puts a random factor on each other term of the balance. The equilibrium is solved again, so that the
cage slips by what the drawn forces allow. A refit has the law's form: far beyond the tested box the
spread of the draws is true as far as this form is.

Decides: the uncertainty of torque, cage slip and power.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import scipy

from oilfilm.bearing.friction import friction_equilibrium
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import TERMS, Lubrication
from oilfilm.bearing.solver import BoolArray, IntArray, Solution
from oilfilm.bearing.torque import cage_slip, inner_ring_torque_n_m
from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.config import TermUncertaintySettings
from oilfilm.torque.load_variables import LawInBearing
from oilfilm.traction.law import to_constants, to_internal
from oilfilm.units import RAD_S_PER_RPM, FloatArray

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


@dataclass(frozen=True)
class Draws:
    """What a torque is calculated with, at random; one row per draw.

    Attributes:
        constants: Of the law, shape (draws, constants).
        factors: On each of `TERMS`, shape (draws, terms), with mean 1.
    """

    constants: FloatArray
    factors: FloatArray

    @classmethod
    def of(
        cls,
        fitted: FittedLaw,
        terms: TermUncertaintySettings,
        count: int,
        random: np.random.Generator,
    ) -> "Draws | None":
        """Draws from the refits of a law; None where it has none.

        Args:
            fitted: The law with its refits.
            terms: Relative standard uncertainty of each other term; its factors are log-normal.
            count: Number of draws.
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
        return cls(to_constants(law, moved), factors)


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
    draws = Draws.of(law.fitted, terms, count, random)
    size = len(calculated)
    slip = torque = np.full((count, size), np.nan)
    if draws is not None:
        slip, torque = _drawn(bearing, calculated, lubrication, law, draws)
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
    draws: Draws,
) -> tuple[FloatArray, FloatArray]:
    """Cage slip and torque of each draw at each point, shape (draws, points); NaN without them.

    The search starts from the calculated equilibrium, so that draws stay on its branch while it
    exists. The draws' coarser quadrature is made good by the difference at the calculated point.
    """
    load, speed = calculated[["axial_load_n", "inner_speed_rpm"]].to_numpy().T
    points = OperatingPoints.axial(load, speed * RAD_S_PER_RPM)
    own = friction_equilibrium(bearing, points, lubrication, law, _QUADRATURE)
    # each row of drawn bearings holds all draws of one point
    count = len(draws.factors)
    rows = [
        _solved(bearing, points, lubrication, law, draws, own.solution, chunk)
        for chunk in np.array_split(
            np.arange(len(calculated)), -(-len(calculated) * count // _CHUNK)
        )
    ]
    slip, torque = (np.concatenate(parts).T for parts in zip(*rows, strict=True))
    slips = cage_slip(bearing, points, own.balance.contacts, own.balance.motion).mean(axis=1)
    moments = inner_ring_torque_n_m(own.balance, own.balls_per_row)
    # beside a fold the coarser quadrature may end on the other branch: there is no difference then
    off = calculated["cage_slip"].to_numpy() - slips
    same = own.solution.converged & (np.abs(off) < _SAME_BRANCH)
    off_moments = calculated["torque_n_m"].to_numpy() - moments
    return slip + np.where(same, off, 0.0), torque + np.where(same, off_moments, 0.0)


def _solved(
    bearing: Bearing,
    points: OperatingPoints,
    lubrication: Lubrication,
    law: LawInBearing,
    draws: Draws,
    start: Solution,
    which: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Cage slip and torque of all draws at some points, shape (points, draws)."""
    count = len(draws.factors)
    point, draw = np.repeat(which, count), np.tile(np.arange(count), len(which))
    slip, torque = np.full((2, len(point)), np.nan)

    def search(some: IntArray, near: Solution) -> Solution:
        at = points.at(point[some])
        found = friction_equilibrium(
            bearing,
            at,
            replace(lubrication.at(point[some]), factors=draws.factors[draw[some]]),
            law.with_constants(draws.constants[draw[some]]),
            _QUADRATURE,
            near,
        )
        good = found.solution.converged
        slips = cage_slip(bearing, at, found.balance.contacts, found.balance.motion).mean(axis=1)
        moments = inner_ring_torque_n_m(found.balance, found.balls_per_row)
        slip[some], torque[some] = (np.where(good, part, np.nan) for part in (slips, moments))
        return found.solution

    solution = search(np.arange(len(point)), start.at(point))
    # a draw whose branch has ended is on the other one: near the slowest cage of its point
    slowest = np.nan_to_num(slip.reshape(-1, count), nan=-np.inf).argmax(axis=1)
    lost = np.flatnonzero(np.isnan(slip))
    if len(lost):
        search(lost, solution.at(count * (lost // count) + slowest[lost // count]))
    return slip.reshape(-1, count), torque.reshape(-1, count)


def _split(slip: FloatArray) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium come last and count as the one before
    ranked = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first, last = (round(end * (len(slip) - 1)) for end in _INTERVAL)
    within = ranked[first : last + 1]
    widest = np.diff(within, axis=0).max(axis=0)
    return np.asarray((widest > _GAP) & (widest > _GAP_SHARE * (within[-1] - within[0])))
