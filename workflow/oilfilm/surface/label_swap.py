"""Runs whose temperature labels were exchanged among each other.

A label that is wrong by 20 K or more acts like no small effect of a run, so the exchange is tried.
The runs that contradict the others most are left out together. The other runs predict each of them
at each of their temperatures, and the likeliest assignment is taken. This is repeated with the new
temperatures until none changes. The likelihood of all points with the new temperatures is then
compared with the likelihood with the old ones. A run is one curve here, and one row of the
conditions.

Decides: when temperature labels are called exchanged.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECT_NAMES, ErrorPriors
from oilfilm.surface.fitted_readings import FittedReadings
from oilfilm.surface.measurements import LevelWidths, Measurements
from oilfilm.surface.posterior import DensePosterior, coordinates_by_group, smooth_covariance
from oilfilm.surface.reduction import Coordinates, reduced_curves
from oilfilm.surface.steadiness import SteadinessLimits
from oilfilm.surface.surface import LARGEST_EXACT_CURVE_COUNT, Surface
from oilfilm.surface.threads import with_one_blas_thread

# Column of the temperature among the conditions, and of the zero among the effects.
_TEMPERATURE_COLUMN = 2
_ZERO_INDEX = EFFECT_NAMES.index("zero")
# Largest number of runs that are suspected together, and their largest share of all runs.
_LARGEST_SUSPECT_COUNT = 8
_LARGEST_SUSPECT_SHARE = 1 / 3
# Number of exchanges that are tried one after the other.
_ROUND_COUNT = 6


@dataclass(frozen=True)
class LabelSwap:
    """Temperatures that were exchanged among some runs.

    Attributes:
        curve_indices: Indices of the curves whose temperature changes, shape (swapped,).
        temperatures_c: The temperatures with which they agree, shape (swapped,).
        score: Twice the logarithm of the likelihood ratio, less twice that of the number of
            possible exchanges.
        is_alarm: Whether the exchange explains more than chance does.
    """

    curve_indices: IndexArray
    temperatures_c: FloatArray
    score: float
    is_alarm: bool


@with_one_blas_thread
def likeliest_swap(
    surface: Surface,
    error_priors: ErrorPriors | None = None,
    limits: SteadinessLimits | None = None,
) -> LabelSwap | None:
    """The exchange of temperatures that explains most; None if no exchange explains anything.

    Args:
        surface: The surface; its measurements are in canonical order.
        error_priors: Priors of the sizes of the errors of the rig.
        limits: `alarm_of_groups`, the score above which an exchange is named.

    Returns:
        None also for more than 150 curves, for which the exchange is not tried.
    """
    conditions_as_read = surface.measurements.conditions
    run_count = len(conditions_as_read)
    if run_count > LARGEST_EXACT_CURVE_COUNT:
        return None
    as_read = FittedReadings.as_read(surface, error_priors or ErrorPriors())
    likeliest = current = as_read
    for _ in range(_ROUND_COUNT):
        proposed_conditions = _likeliest_conditions(current)
        if proposed_conditions is None:
            break
        # a round may be worse before the next one is better
        current = current.fit_to(replace(current.measurements, conditions=proposed_conditions))
        if current.negative_ln_posterior < likeliest.negative_ln_posterior:
            likeliest = current
    changed_curves = np.flatnonzero(
        _is_temperature_changed(
            conditions_as_read, likeliest.measurements.conditions, surface.measurements.level_widths
        )
    )
    changed_count = len(changed_curves)
    if not changed_count:
        return None
    # groups of this size, and the orders of their labels
    ln_choices = np.log(scipy.special.comb(run_count, changed_count)) + scipy.special.gammaln(
        changed_count + 1
    )
    score = float(
        2 * (as_read.negative_ln_posterior - likeliest.negative_ln_posterior - ln_choices)
    )
    alarm_score = (limits or SteadinessLimits()).alarm_of_groups
    new_temperatures_c = likeliest.measurements.conditions[changed_curves, _TEMPERATURE_COLUMN]
    return LabelSwap(changed_curves, new_temperatures_c, score, score > alarm_score)


def _is_temperature_changed(
    conditions_before: FloatArray, conditions_after: FloatArray, widths: LevelWidths
) -> BoolArray:
    """Whether the temperature of each curve has another level afterwards, shape (curves,)."""
    difference_k = (
        conditions_after[:, _TEMPERATURE_COLUMN] - conditions_before[:, _TEMPERATURE_COLUMN]
    )
    return np.asarray(np.abs(difference_k) > widths.temperature_k)


@dataclass(frozen=True)
class _RemainingCurves:
    """The curves that are not suspect, ready to predict those that are.

    Attributes:
        coordinates: The curves as weighted sums of values (`Coordinates`).
        covariance_factor: Lower Cholesky factor of their covariance.
        weights: Inverse of their covariance times the departure of ln mu from the law.
    """

    coordinates: Coordinates
    covariance_factor: FloatArray
    weights: FloatArray


def _likeliest_conditions(readings: FittedReadings) -> FloatArray | None:
    """The conditions after the likeliest exchange; None if that changes no temperature."""
    suspect_curves = _suspects(readings)
    conditions = readings.measurements.conditions
    temperatures_c = conditions[suspect_curves, _TEMPERATURE_COLUMN]
    ln_density = _ln_densities(readings, suspect_curves, temperatures_c)
    _, temperature_index_of_suspect = scipy.optimize.linear_sum_assignment(-ln_density)
    proposed_conditions = conditions.copy()
    proposed_conditions[suspect_curves, _TEMPERATURE_COLUMN] = temperatures_c[
        temperature_index_of_suspect
    ]
    is_changed = _is_temperature_changed(
        conditions, proposed_conditions, readings.measurements.level_widths
    )
    proposed_conditions[~is_changed] = conditions[~is_changed]
    return proposed_conditions if is_changed.any() else None


def _suspects(readings: FittedReadings) -> IndexArray:
    """Indices of curves: those with changed labels, and those that contradict all others most."""
    run_count = len(readings.measurements.conditions)
    mean_squares_of_curves = []
    for left_out in DensePosterior(readings.covariance).leave_groups_out(np.arange(run_count)):
        squares = left_out.error @ left_out.precision @ left_out.error
        mean_squares_of_curves.append(squares / len(left_out.error))
    mean_squares = np.array(mean_squares_of_curves)
    measurements_as_read = readings.surface.measurements
    mean_squares[
        _is_temperature_changed(
            measurements_as_read.conditions,
            readings.measurements.conditions,
            measurements_as_read.level_widths,
        )
    ] = np.inf
    suspect_count = min(_LARGEST_SUSPECT_COUNT, int(_LARGEST_SUSPECT_SHARE * run_count))
    return np.sort(np.argsort(-mean_squares, kind="stable")[:suspect_count])


def _ln_densities(
    readings: FittedReadings, suspect_curves: IndexArray, temperatures_c: FloatArray
) -> FloatArray:
    """Logarithm of the density of each suspect at each temperature, by the other runs.

    Returns:
        Shape (suspects, temperatures). -inf where the law has no traction at a point of the run.
    """
    curves = readings.covariance.curves
    remaining_coordinates = np.flatnonzero(~np.isin(curves.curve_of_coordinate, suspect_curves))
    remaining_covariance = readings.covariance.matrix()[
        np.ix_(remaining_coordinates, remaining_coordinates)
    ]
    factor = scipy.linalg.cholesky(remaining_covariance, lower=True)
    weights = scipy.linalg.cho_solve((factor, True), curves.departure[remaining_coordinates])
    remaining_curves = _RemainingCurves(
        curves.select_coordinates(remaining_coordinates), factor, weights
    )
    distinct_temperatures_c, distinct_index_of_temperature = np.unique(
        temperatures_c, return_inverse=True
    )
    ln_density = np.full((len(suspect_curves), len(distinct_temperatures_c)), -np.inf)
    for ln_density_of_run, curve_index in zip(ln_density, suspect_curves.tolist(), strict=True):
        copies = _copies_of_run(readings.measurements, curve_index, distinct_temperatures_c)
        has_traction = np.ones(len(distinct_temperatures_c), dtype=bool)
        np.logical_and.at(
            has_traction,
            copies.curve_of_point,
            readings.surface.law.has_traction(copies.point_conditions, copies.slip),
        )
        ln_density_of_run[has_traction] = _ln_densities_of_run(
            readings, remaining_curves, curve_index, distinct_temperatures_c[has_traction]
        )
    return ln_density[:, distinct_index_of_temperature]


def _copies_of_run(
    measurements: Measurements, curve_index: int, temperatures_c: FloatArray
) -> Measurements:
    """A curve copied to each temperature, in degC, shape (temperatures,)."""
    conditions = np.tile(measurements.conditions[curve_index], (len(temperatures_c), 1))
    conditions[:, _TEMPERATURE_COLUMN] = temperatures_c
    return measurements.copied_to_conditions(curve_index, conditions)


def _ln_densities_of_run(
    readings: FittedReadings,
    remaining_curves: _RemainingCurves,
    curve_index: int,
    temperatures_c: FloatArray,
) -> FloatArray:
    """Logarithm of the density of a curve at each temperature, by the remaining curves.

    The curve is copied to each temperature, and all copies are reduced at once.

    Args:
        readings: The points with the temperatures of this round.
        remaining_curves: The curves that predict this one.
        curve_index: Index of the curve.
        temperatures_c: Temperatures, in degC, shape (temperatures,).
    """
    covariance, sizes = readings.covariance, readings.covariance.sizes
    copies = _copies_of_run(readings.measurements, curve_index, temperatures_c)
    law = readings.surface.law
    curves = reduced_curves(
        copies, law, law.log_mu, float(sizes.effects[_ZERO_INDEX]), covariance.box
    )
    every_coordinate = curves.select_coordinates(np.arange(len(curves.departure)))
    cross_covariance = smooth_covariance(covariance, every_coordinate, remaining_curves.coordinates)
    whitened_cross_covariance = scipy.linalg.solve_triangular(
        remaining_curves.covariance_factor, cross_covariance.T, lower=True
    )
    error = curves.departure - cross_covariance @ remaining_curves.weights
    ln_densities = []
    for coordinate_indices in coordinates_by_group(
        curves.curve_of_coordinate, np.arange(len(temperatures_c))
    ):
        curve_copy = curves.select_coordinates(coordinate_indices)
        whitened_cross_covariance_of_copy = whitened_cross_covariance[:, coordinate_indices]
        scaled_effects = curves.effect_design[coordinate_indices] * sizes.effects
        curve_covariance = (
            smooth_covariance(covariance, curve_copy, curve_copy)
            - whitened_cross_covariance_of_copy.T @ whitened_cross_covariance_of_copy
        )
        curve_covariance += scaled_effects @ scaled_effects.T
        curve_covariance += sizes.noise**2 * np.eye(len(coordinate_indices))
        curve_factor = scipy.linalg.cholesky(curve_covariance, lower=True)
        whitened = scipy.linalg.solve_triangular(
            curve_factor, error[coordinate_indices], lower=True
        )
        ln_densities.append(-whitened @ whitened / 2 - np.sum(np.log(np.diag(curve_factor))))
    return np.array(ln_densities)
