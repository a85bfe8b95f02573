"""Uncertainty of calculated torque, cage slip and power, by random draws through the equilibrium.

Everything that is known to be uncertain is drawn here, and nowhere else. The keys of
`NUMBER_NAMES_OF_CAUSE` are these causes:

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
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from oilfilm.base.randomness import generator
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.equilibria import NearbyEquilibria, friction_equilibrium
from oilfilm.bearing.friction import COARSE_NODE_COUNTS, FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.inputs import INPUT_NAMES, InputValues
from oilfilm.bearing.resistance import FACTOR_NAMES
from oilfilm.bearing.torque import worst_lambda_ratio
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.oils import Oil
from oilfilm.settings.config import BearingSettings, TorqueDrawSettings
from oilfilm.torque.load_variables import LawInBearing, join_laws
from oilfilm.traction.law import to_constants, to_internal

# Ends of every interval of the project: 95 %.
_INTERVAL_PROBABILITIES = (0.025, 0.975)
# Cage slips from two quadratures on the same branch differ by less than this.
_SAME_BRANCH_SLIP = 0.01
# Results of each draw, as columns of the calculated results.
DRAWN_RESULTS = ("torque_n_m", "cage_slip", "lambda_ratio")
# Terms of the balance that have a random factor; the drag is drawn by the oil's share.
RANDOM_FACTOR_TERMS = ("rolling", "hysteresis", "pocket", "land")
# Names of the random numbers for the sensors of a traction rig, whose calibration changes a fit.
_SENSORS = tuple(f"sensor {number}" for number in range(8))
_NUMBER_NAMES_OF_OIL_CAUSE: Mapping[str, tuple[str, ...]] = {
    "viscosity": ("viscosity", "pressure viscosity"),
    "law": ("refit", "law error"),
    "runs": ("run",),
}
# Every cause of uncertainty that is drawn, with the names of its random numbers.
NUMBER_NAMES_OF_CAUSE: Mapping[str, tuple[str, ...]] = {
    **{name: (name,) for name in (*INPUT_NAMES, *RANDOM_FACTOR_TERMS)},
    "rig": _SENSORS,
    **_NUMBER_NAMES_OF_OIL_CAUSE,
}
# Random numbers that all oils share, and those of each oil.
_NUMBER_NAMES_OF_OIL = tuple(
    name for names in _NUMBER_NAMES_OF_OIL_CAUSE.values() for name in names
)
_SHARED_NUMBER_NAMES = tuple(
    name
    for names in NUMBER_NAMES_OF_CAUSE.values()
    for name in names
    if name not in _NUMBER_NAMES_OF_OIL
)
_ALL_NUMBER_NAMES = (*_SHARED_NUMBER_NAMES, *_NUMBER_NAMES_OF_OIL)
# Pairs of draws by which the share of one cause is estimated.
_DRAW_PAIRS = 50
# Multiplier of the lattice of such pairs; it has no common divisor with their number.
_LATTICE_MULTIPLIER = 21
# Draws that are solved together, which bounds the memory.
_DRAWS_SOLVED_AT_ONCE = 30_000

# Standard normal numbers by their names, shapes (draws,).
NormalNumbers = Mapping[str, FloatArray]


def sd_of_log_factor(settings: BearingSettings, term: str) -> float:
    """Standard deviation of the logarithm of the factor on a term."""
    return float(np.sqrt(np.log1p(getattr(settings.term_uncertainty, term) ** 2)))


def random_factor(settings: BearingSettings, term: str, normal_numbers: FloatArray) -> FloatArray:
    """Random factors on one of `RANDOM_FACTOR_TERMS`: log-normal with mean 1.

    Args:
        settings: Uncertainties of the terms.
        term: The term.
        normal_numbers: Standard normal numbers.
    """
    sd_of_log = sd_of_log_factor(settings, term)
    return np.asarray(np.exp(sd_of_log * normal_numbers - sd_of_log**2 / 2))


def has_enough_refits(fitted: FittedLaw) -> bool:
    """Whether a law has the refits that its draws are made of."""
    coefficients = fitted.coefficients
    return len(coefficients.refits) >= 2 and not np.isnan(coefficients.constants).any()


def law_error(
    law: LawInBearing, calculated: pd.DataFrame, error_without_interval: float
) -> FloatArray:
    """Relative standard error of the law's form at operating points, shape (points,).

    It is the larger one of both contacts. Each contact has its own pressure and speed, and its own
    local slip, averaged over the ellipse by load. The slip in its middle would leave out spin,
    which is nearly all of the sliding under a cage that rolls. Below the smallest levels at which
    the law is evaluated, it is the error at these levels.

    Args:
        law: The law.
        calculated: Results with pressure, speed and mean slip of each contact (`torque_terms`), and
            with the oil temperature.
        error_without_interval: The error where the surface of measured mu has no interval.
    """
    errors = []
    for ring in ("inner", "outer"):
        pressure_gpa = calculated[f"{ring}_max_hertz_pressure_gpa"].to_numpy(dtype=float)
        speed_m_s = calculated[f"{ring}_entrainment_speed_m_s"].to_numpy(dtype=float)
        slip = calculated[f"{ring}_mean_slide_roll_ratio"].to_numpy(dtype=float)
        level_by_condition: dict[str, FloatArray] = {
            "max_hertz_pressure_gpa": pressure_gpa,
            "load_n": law.rig_contact.load_n(pressure_gpa),
            "entrainment_speed_m_s": speed_m_s,
            "inlet_temperature_c": calculated["inlet_temperature_c"].to_numpy(dtype=float),
        }
        conditions = law.limited_conditions(level_by_condition)
        errors.append(law.fitted.form_error(conditions, slip, error_without_interval))
    return np.maximum(*errors)


def _normal_numbers(
    draw_count: int, number_names: Sequence[str], random: np.random.Generator
) -> dict[str, FloatArray]:
    """Standard normal numbers by name, with one draw from each slice of equal probability."""
    shape = (len(number_names), draw_count)
    slice_of_number = np.array([random.permutation(draw_count) for _ in number_names])
    position_in_slice = random.random(shape)
    normal_numbers = scipy.special.ndtri((slice_of_number + position_in_slice) / draw_count)
    return dict(zip(number_names, normal_numbers, strict=True))


def _second_normal_numbers(
    normal_numbers: FloatArray, shift: int, position_in_slice: FloatArray
) -> FloatArray:
    """Other standard normal numbers, one from each slice of equal probability, in another order.

    The slices of both form a lattice. Hence they hardly correlate, which makes estimates by pairs
    twice as exact as a random order does.

    Args:
        normal_numbers: The numbers of the first order, from `_normal_numbers`.
        shift: Number of slices by which the lattice is moved.
        position_in_slice: Positions in the slices, 0 to 1.
    """
    draw_count = len(normal_numbers)
    slice_of_number = np.floor(scipy.special.ndtr(normal_numbers) * draw_count)
    return np.asarray(
        scipy.special.ndtri(
            ((_LATTICE_MULTIPLIER * slice_of_number + shift) % draw_count + position_in_slice)
            / draw_count
        )
    )


class OilAndLaw(NamedTuple):
    """The oil and the law of a group of operating points.

    Attributes:
        oil_name: Name of the oil.
        oil: Its properties.
        law: Its law.
    """

    oil_name: str
    oil: Oil
    law: LawInBearing


class RandomDraws:
    """Random draws of operating points, and what they give: results and shares of variance.

    Attributes:
        drawn_point_index: Indices of the points that have draws.
        law_error_of_drawn_point: Relative standard error of the law's form at these points.
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
        self._point_count = len(group_of_point)
        group_has_draws = np.array(
            [has_enough_refits(group.law.fitted) for group in groups], dtype=bool
        )
        converged = calculated["converged"].to_numpy(dtype=bool)
        self.drawn_point_index = np.flatnonzero(group_has_draws[group_of_point] & converged)
        self._group_of_point = group_of_point[self.drawn_point_index]
        self.law_error_of_drawn_point = np.empty(len(self.drawn_point_index))
        if len(self.drawn_point_index) == 0:
            return
        for group_index in np.unique(self._group_of_point):
            is_of_group = self._group_of_point == group_index
            rows_of_group = calculated.iloc[self.drawn_point_index[is_of_group]]
            self.law_error_of_drawn_point[is_of_group] = law_error(
                groups[group_index].law, rows_of_group, settings.law_error_beyond
            )
        self._coarse_problem = replace(
            equilibrium.problem.at_points(self.drawn_point_index),
            rule=gauss_rule(*COARSE_NODE_COUNTS),
        )
        # A draw starts from the equilibrium of its point without draws. It stays on that branch
        # while the branch exists. Otherwise its equilibrium is searched from the rolling cage.
        nearby_equilibria = NearbyEquilibria.from_unknowns(
            self._coarse_problem, equilibrium.solution.unknowns[self.drawn_point_index]
        )
        nominal_equilibrium = friction_equilibrium(self._coarse_problem, nearby_equilibria)
        self._start_equilibria = NearbyEquilibria.from_unknowns(
            self._coarse_problem, nominal_equilibrium.solution.unknowns
        )
        # Corrects the coarse quadrature of the draws. At a fold it may end on the other branch.
        fine_results = (
            calculated.iloc[self.drawn_point_index][list(DRAWN_RESULTS)].to_numpy(dtype=float).T
        )
        correction = fine_results - _result_arrays(nominal_equilibrium)
        is_same_branch = np.abs(correction[DRAWN_RESULTS.index("cage_slip")]) < _SAME_BRANCH_SLIP
        self._correction = np.where(is_same_branch, correction, 0.0)

    def calculate_results(self) -> FloatArray:
        """Torque, cage slip and lambda of each draw, shape (3, draws, points).

        NaN without refits and where a draw has no equilibrium.
        """
        return self._results_of_draws

    @cached_property
    def _results_of_draws(self) -> FloatArray:
        """See `calculate_results`."""
        draw_count = self._settings.uncertainty.draws
        results = np.full((len(DRAWN_RESULTS), draw_count, self._point_count), np.nan)
        if len(self.drawn_point_index):
            numbers = self._random_numbers(draw_count, "torque uncertainty")
            results[..., self.drawn_point_index] = self._solve_draws(
                numbers, np.arange(len(self.drawn_point_index))
            )
        return results

    def calculate_shares(
        self,
        wanted_points: IndexArray,
        causes: Mapping[str, tuple[str, ...]] = NUMBER_NAMES_OF_CAUSE,
    ) -> pd.DataFrame:
        """Share of the variance of torque and cage slip by each of some causes.

        The share is a total effect: the part of the variance that is left if all else is known
        (M. J. W. Jansen, Comput. Phys. Commun. 117 (1999) 35). Near a jump of the cage the shares
        add up to more than 1, because a cause acts together with others there.

        Args:
            wanted_points: Indices of the points; those without draws are left out.
            causes: Causes, each with the names of its random numbers.

        Returns:
            One row per point and cause: `point`, `variance_cause`, `torque_share`, `slip_share`.
            The shares are NaN where too many draws have no equilibrium for an interval.
        """
        position_in_drawn = np.flatnonzero(np.isin(self.drawn_point_index, wanted_points))
        if len(position_in_drawn) == 0:
            return pd.DataFrame(columns=["point", "variance_cause", "torque_share", "slip_share"])
        first_numbers_of_group = self._random_numbers(_DRAW_PAIRS, "shares of variance")
        # every oil has the same shifts and positions, so that shared numbers stay shared
        random = generator(self._seed, "shares of variance, redrawn")
        shift_and_position = {
            name: (int(random.integers(_DRAW_PAIRS)), random.random(_DRAW_PAIRS))
            for name in _ALL_NUMBER_NAMES
        }
        second_numbers_of_group = [
            {
                name: _second_normal_numbers(normal_numbers, *shift_and_position[name])
                for name, normal_numbers in numbers.items()
            }
            for numbers in first_numbers_of_group
        ]
        # the first numbers, then those with one cause redrawn after the other
        joined_numbers_of_group = []
        for numbers, second_numbers in zip(
            first_numbers_of_group, second_numbers_of_group, strict=True
        ):
            variants = [numbers]
            for number_names in causes.values():
                redrawn_numbers = {name: second_numbers[name] for name in number_names}
                variants.append({**numbers, **redrawn_numbers})
            joined_numbers_of_group.append(
                {name: np.concatenate([variant[name] for variant in variants]) for name in numbers}
            )
        results = self._solve_draws(joined_numbers_of_group, position_in_drawn)
        torque_n_m = self.calculate_results()[0][:, self.drawn_point_index[position_in_drawn]]
        has_enough_draws = _has_enough_draws(
            np.isfinite(torque_n_m), self._settings.uncertainty.lost_share_max
        )
        results_by_variant = results.reshape(
            len(DRAWN_RESULTS), 1 + len(causes), _DRAW_PAIRS, len(position_in_drawn)
        )
        # of torque and cage slip: lambda has no shares, and is NaN in cold oil
        results_by_variant = np.where(has_enough_draws, results_by_variant[:2], 0.0)
        first_results, redrawn_results = results_by_variant[:, :1], results_by_variant[:, 1:]
        with np.errstate(invalid="ignore", divide="ignore"):
            variance = np.nanvar(first_results, axis=2, ddof=1) + np.nanvar(
                redrawn_results, axis=2, ddof=1
            )
            shares = np.nanmean((redrawn_results - first_results) ** 2, axis=2) / variance
        torque_share, slip_share = np.where(has_enough_draws, shares, np.nan)
        return pd.DataFrame(
            {
                "point": np.tile(self.drawn_point_index[position_in_drawn], len(causes)),
                "variance_cause": np.repeat(list(causes), len(position_in_drawn)),
                "torque_share": torque_share.ravel(),
                "slip_share": slip_share.ravel(),
            }
        )

    def _random_numbers(self, draw_count: int, purpose: str) -> list[NormalNumbers]:
        """Random numbers of each group of points, by their names."""
        shared = _normal_numbers(draw_count, _SHARED_NUMBER_NAMES, generator(self._seed, purpose))
        return [
            {
                **shared,
                **_normal_numbers(
                    draw_count, _NUMBER_NAMES_OF_OIL, generator(self._seed, purpose, group.oil_name)
                ),
            }
            for group in self._groups
        ]

    def _solve_draws(
        self, numbers_of_group: Sequence[NormalNumbers], position_in_drawn: IndexArray
    ) -> FloatArray:
        """`DRAWN_RESULTS` with random numbers of each group, shape (3, draws, chosen points).

        Args:
            numbers_of_group: Random numbers of each group.
            position_in_drawn: Positions in `drawn_point_index`.
        """
        draw_count = len(numbers_of_group[0]["run"])
        points_at_once = max(_DRAWS_SOLVED_AT_ONCE // draw_count, 1)
        results_of_chunks = []
        for chunk_start in range(0, len(position_in_drawn), points_at_once):
            positions_of_chunk = position_in_drawn[chunk_start : chunk_start + points_at_once]
            problem = self._drawn_problem(numbers_of_group, positions_of_chunk, draw_count)
            nearby_equilibria = self._start_equilibria.at_points(
                np.repeat(positions_of_chunk, draw_count)
            )
            drawn_results = _result_arrays(friction_equilibrium(problem, nearby_equilibria))
            drawn_results = np.swapaxes(
                drawn_results.reshape(len(DRAWN_RESULTS), len(positions_of_chunk), draw_count), 1, 2
            )
            results_of_chunks.append(
                drawn_results + self._correction[:, np.newaxis, positions_of_chunk]
            )
        return np.concatenate(results_of_chunks, axis=2)

    def _drawn_problem(
        self,
        numbers_of_group: Sequence[NormalNumbers],
        position_in_drawn: IndexArray,
        draw_count: int,
    ) -> FrictionProblem:
        """The problem of all draws of some points, with the draws of a point next to each other."""
        point_count = len(position_in_drawn)
        group_of_point = self._group_of_point[position_in_drawn]
        problem = self._coarse_problem.at_points(np.repeat(position_in_drawn, draw_count))
        lubrication = problem.lubrication
        # the shared numbers are the same in every group
        shared_numbers = numbers_of_group[0]
        uncertain_input_by_name = {
            **problem.bearing.uncertain_inputs,
            **self._settings.uncertain_inputs(),
        }
        probability_by_input = {
            name: np.tile(scipy.special.ndtr(shared_numbers[name]), point_count)
            for name in INPUT_NAMES
        }
        factors = lubrication.factors.copy()
        for term in RANDOM_FACTOR_TERMS:
            factor = random_factor(self._settings, term, shared_numbers[term])
            factors[:, FACTOR_NAMES.index(term)] *= np.tile(factor, point_count)
        numbers_of_point = [numbers_of_group[group_index] for group_index in group_of_point]
        run_sd_of_point = [
            np.nan_to_num(self._groups[group_index].law.fitted.coefficients.run_sd)
            for group_index in group_of_point
        ]
        traction_errors_of_point = [
            run_sd * oil_numbers["run"] + law_error_of_point * oil_numbers["law error"]
            for oil_numbers, run_sd, law_error_of_point in zip(
                numbers_of_point,
                run_sd_of_point,
                self.law_error_of_drawn_point[position_in_drawn],
                strict=True,
            )
        ]
        factors[:, FACTOR_NAMES.index("traction")] *= np.exp(
            np.concatenate(traction_errors_of_point)
        )
        stand_in_uncertainty = self._settings.stand_in_uncertainty
        is_stand_in = np.repeat(
            [self._groups[group_index].oil.stand_in for group_index in group_of_point], draw_count
        )
        viscosity_numbers = np.concatenate(
            [oil_numbers["viscosity"] for oil_numbers in numbers_of_point]
        )
        pressure_viscosity_numbers = np.concatenate(
            [oil_numbers["pressure viscosity"] for oil_numbers in numbers_of_point]
        )
        oil_without_draws = lubrication.inlet_oil
        drawn_inlet_oil = replace(
            oil_without_draws,
            dynamic_viscosity_pa_s=oil_without_draws.dynamic_viscosity_pa_s
            * np.exp(stand_in_uncertainty.viscosity * is_stand_in * viscosity_numbers),
            pressure_viscosity_coefficient_1_pa=oil_without_draws.pressure_viscosity_coefficient_1_pa
            * np.exp(
                stand_in_uncertainty.pressure_viscosity_coefficient
                * is_stand_in
                * pressure_viscosity_numbers
            ),
        )
        constants_of_group = {
            group_index: _drawn_constants(
                self._groups[group_index].law.fitted, numbers_of_group[group_index]
            )
            for group_index in np.unique(group_of_point)
        }
        law_of_point = [
            self._groups[group_index].law.with_constants(constants_of_group[group_index])
            for group_index in group_of_point
        ]
        drawn_problem = replace(
            problem,
            law=join_laws(law_of_point, [draw_count] * point_count),
            lubrication=replace(lubrication, inlet_oil=drawn_inlet_oil, factors=factors),
        )
        return drawn_problem.with_inputs(
            InputValues.drawn(uncertain_input_by_name, probability_by_input)
        )


def _drawn_constants(fitted: FittedLaw, numbers: NormalNumbers) -> FloatArray:
    """Constants of the draws: refits, moved by the errors of sensors, shape (draws, constants)."""
    law, coefficients = fitted.law, fitted.coefficients
    refits = coefficients.refits
    refit_index = (scipy.special.ndtr(numbers["refit"]) * len(refits)).astype(np.intp)
    shift_of_sensor = to_internal(law, coefficients.shifted_refits) - to_internal(
        law, coefficients.constants
    )
    sensor_numbers = np.column_stack([numbers[name] for name in _SENSORS])
    internal = (
        to_internal(law, refits[refit_index])
        + sensor_numbers[:, : len(shift_of_sensor)] @ shift_of_sensor
    )
    return np.asarray(to_constants(law, internal))


def add_uncertainty(
    calculated: pd.DataFrame,
    draws: FloatArray,
    was_drawn: BoolArray,
    inner_speed_rad_s: FloatArray,
    settings: TorqueDrawSettings,
) -> pd.DataFrame:
    """Calculated friction with the standard uncertainty and 95 % interval of its results.

    Args:
        calculated: The results without draws.
        draws: Draws of `RandomDraws.calculate_results`.
        was_drawn: Points that have draws, with or without equilibria, shape (points,).
        inner_speed_rad_s: Speed of the inner ring.
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
    draws_by_result = {
        "torque_n_m": torque,
        "cage_slip": slip,
        "power_w": torque * inner_speed_rad_s,
    }
    columns: dict[str, FloatArray] = {}
    for name, drawn_values in draws_by_result.items():
        usable_values = np.where(has_enough_draws, drawn_values, 0.0)
        # with these ranks the interval holds the next draw with a probability of 95 %; with the
        # ranks that NumPy takes by default it would be 93 % for 100 draws
        lower, upper = np.nanquantile(
            usable_values, _INTERVAL_PROBABILITIES, axis=0, method="weibull"
        )
        standard_deviation = np.nanstd(usable_values, axis=0, ddof=1)
        columns[f"{name}_uncertainty"] = np.where(has_enough_draws, standard_deviation, np.nan)
        columns[f"{name}_lower"] = np.where(has_enough_draws, lower, np.nan)
        columns[f"{name}_upper"] = np.where(has_enough_draws, upper, np.nan)
    is_split = pd.Series(_is_split(slip, settings), calculated.index, dtype="boolean")
    return calculated.assign(
        power_w=calculated["torque_n_m"] * inner_speed_rad_s,
        **columns,
        draws_split=is_split.where(has_enough_draws),
        draws_lost=np.where(was_drawn, (~has_equilibrium).sum(axis=0), np.nan),
    )


def _has_enough_draws(has_equilibrium: BoolArray, lost_share_max: float) -> BoolArray:
    """Points at which enough draws, shape (draws, points), have an equilibrium."""
    # counts are compared, because a mean may be rounded to either side of the limit
    lost_draws = (~has_equilibrium).sum(axis=0)
    has_few_lost_draws = lost_draws <= lost_share_max * len(has_equilibrium)
    # the settings may allow any number of lost draws, but fewer than two draws have no spread
    return np.asarray(has_few_lost_draws & (has_equilibrium.sum(axis=0) >= 2))


def _result_arrays(equilibrium: FrictionEquilibrium) -> FloatArray:
    """`DRAWN_RESULTS` of equilibria, shape (3, points); NaN where there is no equilibrium."""
    lambda_ratio, _ = worst_lambda_ratio(equilibrium)
    values = np.stack([equilibrium.torque_n_m(), equilibrium.cage_slip(), lambda_ratio])
    return np.where(equilibrium.solution.converged, values, np.nan)


def _is_split(slip: FloatArray, settings: TorqueDrawSettings) -> BoolArray:
    """Points whose draws, shape (draws, points), are in two groups of cage slip."""
    # draws without an equilibrium are sorted to the end and repeat the largest slip
    sorted_slip = np.fmax.accumulate(np.sort(slip, axis=0), axis=0)
    first_rank, last_rank = (
        round(quantile * (len(slip) - 1)) for quantile in _INTERVAL_PROBABILITIES
    )
    slips_in_interval = sorted_slip[first_rank : last_rank + 1]
    widest_gap = np.diff(slips_in_interval, axis=0).max(axis=0)
    smallest_gap = settings.split_gap_share * (slips_in_interval[-1] - slips_in_interval[0])
    return np.asarray((widest_gap > settings.split_gap) & (widest_gap > smallest_gap))
