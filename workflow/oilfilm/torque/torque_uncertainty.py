"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Everything that is known to be uncertain is drawn here, and nowhere else. `UNCERTAIN` names it:

- the inputs of the bearing that no drawing gives exactly (`oilfilm.bearing.inputs`), from their
  ranges: ring temperatures, fits, bore of the shaft, feed oil, drag, replenishment, ellipse;
- each other term of the balance: a random factor;
- the oil's viscosity, where a similar oil stands in for the oil;
- the calibration of the traction rig's sensors;
- the law: one refit, and an error of its form. That error is the one of the surface of measured mu
  where this has an interval, and a stated one beyond;
- all traction: a factor with the error of a run, by the surface of measured mu.

The equilibrium is solved again for each draw, so that the cage slips as the drawn forces allow.
A draw has the same bearing, feed oil and rig for all oils.

The spin of the traction rig is not drawn. It changes mu by less than 1 % from S = 0.01 on.

Decides: the uncertainty of torque, cage slip and power, and the share of each cause in it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from oilfilm.base.randomness import generator
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.equilibria import Neighbour, friction_equilibrium
from oilfilm.bearing.friction import COARSE_QUADRATURE, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.inputs import INPUTS, Inputs
from oilfilm.bearing.resistance import FACTORS
from oilfilm.bearing.torque import film_ratio
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.oils import Oil
from oilfilm.settings.config import BearingSettings, TorqueDrawSettings
from oilfilm.torque.load_variables import LawInBearing, law_of_groups
from oilfilm.traction.law import to_constants, to_internal

# Ends of every interval of the project: 95 %.
_INTERVAL_PROBABILITIES = (0.025, 0.975)
# Cage slips from two quadratures on the same branch differ by less than this.
_SAME_BRANCH_SLIP = 0.01
# Results of each draw, as columns of the calculated results.
DRAWN_RESULTS = ("torque_n_m", "cage_slip", "lambda_ratio")
# Terms of the balance that have a random factor; the drag is drawn by the oil's share.
FACTOR_TERMS = ("rolling", "hysteresis", "pocket", "land")
# Sensors of a traction rig whose calibration changes a fit.
_SENSORS = tuple(f"sensor {number}" for number in range(8))
_CAUSES_OF_OIL: Mapping[str, tuple[str, ...]] = {
    "viscosity": ("viscosity", "pressure viscosity"),
    "law": ("refit", "law error"),
    "runs": ("run",),
}
# Everything that is drawn, each with the names of its random numbers.
UNCERTAIN: Mapping[str, tuple[str, ...]] = {
    **{name: (name,) for name in (*INPUTS, *FACTOR_TERMS)},
    "rig": _SENSORS,
    **_CAUSES_OF_OIL,
}
# Random numbers that all oils share, and those of each oil.
_NAMES_OF_OIL = tuple(name for names in _CAUSES_OF_OIL.values() for name in names)
_SHARED_NAMES = tuple(
    name for names in UNCERTAIN.values() for name in names if name not in _NAMES_OF_OIL
)
_ALL_NAMES = (*_SHARED_NAMES, *_NAMES_OF_OIL)
# Pairs of draws by which the share of one cause is estimated.
_DRAW_PAIRS = 50
# Multiplier of the lattice of such pairs; it has no common divisor with their number.
_LATTICE_MULTIPLIER = 21
# Draws that are solved together, which bounds the memory.
_SOLVED_AT_ONCE = 30_000

# Standard normal numbers by their names, shapes (draws,).
Numbers = Mapping[str, FloatArray]


def factor_spread(settings: BearingSettings, term: str) -> float:
    """Standard deviation of the logarithm of the factor on a term."""
    return float(np.sqrt(np.log1p(getattr(settings.term_uncertainty, term) ** 2)))


def random_factor(settings: BearingSettings, term: str, normal: FloatArray) -> FloatArray:
    """Random factors on one of `FACTOR_TERMS`: log-normal with mean 1.

    Args:
        settings: Uncertainties of the terms.
        term: The term.
        normal: Standard normal numbers.
    """
    spread = factor_spread(settings, term)
    return np.asarray(np.exp(spread * normal - spread**2 / 2))


def has_draws(fitted: FittedLaw) -> bool:
    """Whether a law has the refits that its draws are made of."""
    coefficients = fitted.coefficients
    return len(coefficients.refits) >= 2 and not np.isnan(coefficients.constants).any()


def law_error(
    law: LawInBearing, calculated: pd.DataFrame, error_without_interval: float
) -> FloatArray:
    """Relative standard error of the law's form at operating points, shape (points,).

    It is the larger one of both contacts.

    Args:
        law: The law.
        calculated: Pressures, speed, oil temperature and slip of the contacts.
        error_without_interval: The error where the surface of measured mu has no interval.
    """
    slip = calculated["inner_slide_roll_ratio"].to_numpy(dtype=float)
    errors = []
    for ring in ("inner", "outer"):
        pressure_gpa = calculated[f"{ring}_max_hertz_pressure_gpa"].to_numpy(dtype=float)
        values_by_condition: dict[str, FloatArray] = {
            "max_hertz_pressure_gpa": pressure_gpa,
            "load_n": law.rig_contact.load_n(pressure_gpa),
            "entrainment_speed_m_s": calculated["entrainment_speed_m_s"].to_numpy(dtype=float),
            "inlet_temperature_c": calculated["inlet_temperature_c"].to_numpy(dtype=float),
        }
        conditions = np.column_stack(
            [values_by_condition[name] for name in law.fitted.law.conditions]
        )
        errors.append(law.fitted.form_error(conditions, slip, error_without_interval))
    return np.maximum(*errors)


def _normal_numbers(
    draw_count: int, names: Sequence[str], random: np.random.Generator
) -> dict[str, FloatArray]:
    """Standard normal numbers by name, with one draw from each equal slice."""
    shape = (len(names), draw_count)
    slices = np.array([random.permutation(draw_count) for _ in names])
    position_in_slice = random.random(shape)
    numbers = scipy.special.ndtri((slices + position_in_slice) / draw_count)
    return dict(zip(names, numbers, strict=True))


def _moved_numbers(normal: FloatArray, shift: int, position: FloatArray) -> FloatArray:
    """Standard normal numbers with one from each equal slice, in an order of their own.

    The slices of both form a lattice. Hence they hardly correlate, which makes estimates by pairs
    twice as exact as a random order does.

    Args:
        normal: The numbers of the first order, from `_normal_numbers`.
        shift: Number of slices by which the lattice is moved.
        position: Positions in the slices, 0 to 1.
    """
    draw_count = len(normal)
    slices = np.floor(scipy.special.ndtr(normal) * draw_count)
    return np.asarray(
        scipy.special.ndtri(
            ((_LATTICE_MULTIPLIER * slices + shift) % draw_count + position) / draw_count
        )
    )


class OilAndLaw(NamedTuple):
    """Points of one oil with one law.

    Attributes:
        name: Name of the oil.
        properties: Its properties.
        law: Its law.
    """

    name: str
    properties: Oil
    law: LawInBearing


class Drawing:
    """The draws of operating points.

    Attributes:
        drawn_points: Indices of the points that have draws.
        law_errors: Relative standard error of the law's form at these points.
    """

    def __init__(
        self,
        equilibrium: FrictionEquilibrium,
        groups: Sequence[OilAndLaw],
        group_of_point: IndexArray,
        calculated: pd.DataFrame,
        settings: BearingSettings,
        seed: int,
    ) -> None:
        """Draws of the points whose law has refits and that have an equilibrium.

        Args:
            equilibrium: The equilibria without draws.
            groups: The groups of points.
            group_of_point: Index of each point's group, in ascending order.
            calculated: The results without draws.
            settings: Ranges and uncertainties; number of draws.
            seed: Seed of the configuration. All oils and load variables share the random numbers
                of bearing and rig. Each oil has random numbers of its own.
        """
        self._groups = groups
        self._settings = settings
        self._seed = seed
        self._points = len(group_of_point)
        group_has_draws = np.array([has_draws(group.law.fitted) for group in groups], dtype=bool)
        converged = calculated["converged"].to_numpy(dtype=bool)
        self.drawn_points = np.flatnonzero(group_has_draws[group_of_point] & converged)
        self._group_of_point = group_of_point[self.drawn_points]
        self.law_errors = np.empty(len(self.drawn_points))
        if len(self.drawn_points) == 0:
            return
        for group_index in np.unique(self._group_of_point):
            is_of_group = self._group_of_point == group_index
            rows_of_group = calculated.iloc[self.drawn_points[is_of_group]]
            self.law_errors[is_of_group] = law_error(
                groups[group_index].law, rows_of_group, settings.law_error_beyond
            )
        self._coarse = replace(
            equilibrium.problem.at_points(self.drawn_points), rule=gauss_rule(*COARSE_QUADRATURE)
        )
        # A draw starts from the equilibrium of its point without draws. It stays on that branch
        # while the branch exists. Otherwise its equilibrium is searched without a neighbour.
        neighbour = Neighbour.from_unknowns(
            self._coarse, equilibrium.solution.unknowns[self.drawn_points]
        )
        without_draws = friction_equilibrium(self._coarse, neighbour)
        self._start = Neighbour.from_unknowns(self._coarse, without_draws.solution.unknowns)
        # Corrects the coarse quadrature of the draws. At a fold it may end on the other branch.
        fine_results = (
            calculated.iloc[self.drawn_points][list(DRAWN_RESULTS)].to_numpy(dtype=float).T
        )
        correction = fine_results - _results(without_draws)
        is_same_branch = np.abs(correction[1]) < _SAME_BRANCH_SLIP
        self._correction = np.where(is_same_branch, correction, 0.0)

    def results(self) -> FloatArray:
        """Torque, cage slip and lambda of each draw, shape (3, draws, points).

        NaN without refits and where a draw has no equilibrium.
        """
        draw_count = self._settings.uncertainty.draws
        results = np.full((len(DRAWN_RESULTS), draw_count, self._points), np.nan)
        if len(self.drawn_points):
            numbers = self._numbers(draw_count, "torque uncertainty")
            results[..., self.drawn_points] = self._solved(
                numbers, np.arange(len(self.drawn_points))
            )
        return results

    def shares(
        self, wanted: IndexArray, causes: Mapping[str, tuple[str, ...]] = UNCERTAIN
    ) -> pd.DataFrame:
        """Share of the variance of torque and cage slip by each of some causes.

        The share is a total effect: the part of the variance that is left if all else is known
        (M. J. W. Jansen, Comput. Phys. Commun. 117 (1999) 35). Near a jump of the cage the shares
        add up to more than 1, because a cause acts together with others there.

        Args:
            wanted: Indices of the points; those without draws are left out.
            causes: Causes, each with the names of its random numbers.

        Returns:
            One row per point and cause: `point`, `variance_cause`, `torque_share`, `slip_share`.
        """
        chosen_positions = np.flatnonzero(np.isin(self.drawn_points, wanted))
        if len(chosen_positions) == 0:
            return pd.DataFrame(columns=["point", "variance_cause", "torque_share", "slip_share"])
        first_numbers = self._numbers(_DRAW_PAIRS, "shares of variance")
        # every oil has the same moves, so that shared numbers stay shared
        random = generator(self._seed, "shares of variance, redrawn")
        moves = {
            name: (int(random.integers(_DRAW_PAIRS)), random.random(_DRAW_PAIRS))
            for name in _ALL_NAMES
        }
        second_numbers_of_groups = [
            {name: _moved_numbers(normal, *moves[name]) for name, normal in numbers.items()}
            for numbers in first_numbers
        ]
        # the first numbers, then those with one cause redrawn after the other
        joined_numbers = []
        for numbers, second_numbers in zip(first_numbers, second_numbers_of_groups, strict=True):
            variants = [numbers]
            for names in causes.values():
                variants.append({**numbers, **{name: second_numbers[name] for name in names}})
            joined_numbers.append(
                {name: np.concatenate([variant[name] for variant in variants]) for name in numbers}
            )
        solved = self._solved(joined_numbers, chosen_positions)
        values = solved.reshape(
            len(DRAWN_RESULTS), 1 + len(causes), _DRAW_PAIRS, len(chosen_positions)
        )
        first_values, redrawn_values = values[:, :1], values[:, 1:]
        with np.errstate(invalid="ignore", divide="ignore"):
            variance = np.nanvar(first_values, axis=2, ddof=1) + np.nanvar(
                redrawn_values, axis=2, ddof=1
            )
            shares = np.nanmean((redrawn_values - first_values) ** 2, axis=2) / variance
        torque_share, slip_share, _ = shares
        return pd.DataFrame(
            {
                "point": np.tile(self.drawn_points[chosen_positions], len(causes)),
                "variance_cause": np.repeat(list(causes), len(chosen_positions)),
                "torque_share": torque_share.ravel(),
                "slip_share": slip_share.ravel(),
            }
        )

    def _numbers(self, draw_count: int, purpose: str) -> list[Numbers]:
        """Random numbers of each group."""
        shared = _normal_numbers(draw_count, _SHARED_NAMES, generator(self._seed, purpose))
        return [
            {
                **shared,
                **_normal_numbers(
                    draw_count, _NAMES_OF_OIL, generator(self._seed, purpose, group.name)
                ),
            }
            for group in self._groups
        ]

    def _solved(self, numbers: Sequence[Numbers], chosen_positions: IndexArray) -> FloatArray:
        """`DRAWN_RESULTS` with random numbers of each group, shape (3, draws, chosen points).

        Args:
            numbers: Random numbers of each group.
            chosen_positions: Positions in `drawn_points`.
        """
        draw_count = len(numbers[0]["run"])
        points_at_once = max(_SOLVED_AT_ONCE // draw_count, 1)
        results_of_chunks = []
        for chunk_start in range(0, len(chosen_positions), points_at_once):
            chunk = chosen_positions[chunk_start : chunk_start + points_at_once]
            problem = self._drawn_problem(numbers, chunk, draw_count)
            neighbour = self._start.at_points(np.repeat(chunk, draw_count))
            drawn_results = _results(friction_equilibrium(problem, neighbour))
            drawn_results = np.swapaxes(
                drawn_results.reshape(len(DRAWN_RESULTS), len(chunk), draw_count), 1, 2
            )
            results_of_chunks.append(drawn_results + self._correction[:, np.newaxis, chunk])
        return np.concatenate(results_of_chunks, axis=2)

    def _drawn_problem(
        self, numbers: Sequence[Numbers], chosen_positions: IndexArray, draw_count: int
    ) -> FrictionProblem:
        """The problem of all draws of some points, with the draws of a point next to each other."""
        point_count = len(chosen_positions)
        group_of_point = self._group_of_point[chosen_positions]
        problem = self._coarse.at_points(np.repeat(chosen_positions, draw_count))
        lubrication = problem.lubrication
        # the shared numbers are the same in every group
        shared = numbers[0]
        uncertain = {**problem.bearing.uncertain, **self._settings.uncertain()}
        probability = {
            name: np.tile(scipy.special.ndtr(shared[name]), point_count) for name in INPUTS
        }
        factors = lubrication.factors.copy()
        for term in FACTOR_TERMS:
            factor = random_factor(self._settings, term, shared[term])
            factors[:, FACTORS.index(term)] *= np.tile(factor, point_count)
        numbers_of_points = [numbers[group] for group in group_of_point]
        run_sd = [
            np.nan_to_num(self._groups[group].law.fitted.coefficients.run_sd)
            for group in group_of_point
        ]
        traction_errors = [
            sd_of_run * oil_numbers["run"] + error_of_law * oil_numbers["law error"]
            for oil_numbers, sd_of_run, error_of_law in zip(
                numbers_of_points, run_sd, self.law_errors[chosen_positions], strict=True
            )
        ]
        factors[:, FACTORS.index("traction")] *= np.exp(np.concatenate(traction_errors))
        uncertainty = self._settings.stand_in_uncertainty
        stand_in = np.repeat(
            [self._groups[group].properties.stand_in for group in group_of_point], draw_count
        )
        viscosity = np.concatenate([oil_numbers["viscosity"] for oil_numbers in numbers_of_points])
        pressure_viscosity = np.concatenate(
            [oil_numbers["pressure viscosity"] for oil_numbers in numbers_of_points]
        )
        inlet = lubrication.oil
        oil = replace(
            inlet,
            dynamic_viscosity_pa_s=inlet.dynamic_viscosity_pa_s
            * np.exp(uncertainty.viscosity * stand_in * viscosity),
            pressure_viscosity_coefficient_1_pa=inlet.pressure_viscosity_coefficient_1_pa
            * np.exp(uncertainty.pressure_viscosity_coefficient * stand_in * pressure_viscosity),
        )
        constants = {
            group: _drawn_constants(self._groups[group].law.fitted, numbers[group])
            for group in np.unique(group_of_point)
        }
        laws = [
            self._groups[group].law.with_constants(constants[group]) for group in group_of_point
        ]
        drawn_problem = replace(
            problem,
            law=law_of_groups(laws, [draw_count] * point_count),
            lubrication=replace(lubrication, oil=oil, factors=factors),
        )
        return drawn_problem.with_inputs(Inputs.drawn(uncertain, probability))


def _drawn_constants(fitted: FittedLaw, numbers: Numbers) -> FloatArray:
    """Constants of the draws: refits that sensors move, shape (draws, constants)."""
    law, coefficients = fitted.law, fitted.coefficients
    refits = coefficients.refits
    refit_index = (scipy.special.ndtr(numbers["refit"]) * len(refits)).astype(np.intp)
    shifts = to_internal(law, coefficients.shifted_refits) - to_internal(
        law, coefficients.constants
    )
    sensors = np.column_stack([numbers[name] for name in _SENSORS])
    internal = to_internal(law, refits[refit_index]) + sensors[:, : len(shifts)] @ shifts
    return np.asarray(to_constants(law, internal))


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
        draws: Draws of `Drawing.results`.
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
    has_enough_draws = _has_enough_draws(has_equilibrium, settings.lost_share_max)
    draws_by_result = {"torque_n_m": torque, "cage_slip": slip, "power_w": torque * speed_rad_s}
    columns: dict[str, FloatArray] = {}
    for name, values in draws_by_result.items():
        usable_values = np.where(has_enough_draws, values, 0.0)
        # between these ranks the next draw is with 95 %; the usual ranks hold 93 % with 100 draws
        lower, upper = np.nanquantile(
            usable_values, _INTERVAL_PROBABILITIES, axis=0, method="weibull"
        )
        spread = np.nanstd(usable_values, axis=0, ddof=1)
        columns[f"{name}_uncertainty"] = np.where(has_enough_draws, spread, np.nan)
        columns[f"{name}_lower"] = np.where(has_enough_draws, lower, np.nan)
        columns[f"{name}_upper"] = np.where(has_enough_draws, upper, np.nan)
    is_split = pd.Series(_is_split(slip, settings), calculated.index, dtype="boolean")
    return calculated.assign(
        power_w=calculated["torque_n_m"] * speed_rad_s,
        **columns,
        draws_split=is_split.where(has_enough_draws),
        draws_lost=np.where(was_drawn, (~has_equilibrium).sum(axis=0), np.nan),
    )


def _has_enough_draws(has_equilibrium: BoolArray, lost_share_max: float) -> BoolArray:
    """Points at which enough draws, shape (draws, points), have an equilibrium."""
    # counts are compared, because a mean may be rounded to either side of the limit
    lost_draws = (~has_equilibrium).sum(axis=0)
    return np.asarray(lost_draws <= lost_share_max * len(has_equilibrium))


def _results(equilibrium: FrictionEquilibrium) -> FloatArray:
    """`DRAWN_RESULTS` of equilibria, shape (3, points); NaN where there is no equilibrium."""
    lambda_ratio, _ = film_ratio(equilibrium)
    values = np.stack([equilibrium.torque_n_m(), equilibrium.cage_slip(), lambda_ratio])
    return np.where(equilibrium.solution.converged, values, np.nan)


def _is_split(slip: FloatArray, settings: TorqueDrawSettings) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium are sorted to the end and repeat the largest slip
    sorted_slip = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first, last = (round(quantile * (len(slip) - 1)) for quantile in _INTERVAL_PROBABILITIES)
    interval = sorted_slip[first : last + 1]
    widest_gap = np.diff(interval, axis=0).max(axis=0)
    least_gap = settings.split_gap_share * (interval[-1] - interval[0])
    return np.asarray((widest_gap > settings.split_gap) & (widest_gap > least_gap))
