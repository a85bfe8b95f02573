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
import scipy.linalg
import scipy.optimize
import scipy.special

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECTS, RunErrorSizes
from oilfilm.surface.measurements import LevelWidths
from oilfilm.surface.posterior import DensePosterior, coordinates_by_group, smooth_covariance
from oilfilm.surface.reduction import Coordinates, reduced_curves
from oilfilm.surface.relabelled import Relabelled
from oilfilm.surface.steadiness import SteadinessLimits
from oilfilm.surface.surface import LARGEST_DENSE, Surface
from oilfilm.surface.threads import with_one_blas_thread

# Column of the temperature among the conditions, and of the zero among the effects.
_TEMPERATURE = 2
_ZERO = EFFECTS.index("zero")
# Largest number of runs that are suspected together, and their largest share of all runs.
_MOST_SUSPECTS = 8
_LARGEST_SHARE = 1 / 3
# Number of exchanges that are tried one after the other.
_ROUNDS = 6


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
    surface: Surface, errors: RunErrorSizes | None = None, limits: SteadinessLimits | None = None
) -> LabelSwap | None:
    """The exchange of temperatures that explains most; None if no exchange explains anything.

    Args:
        surface: The surface; its measurements are in canonical order.
        errors: Sizes of the errors of the rig, before the data.
        limits: `alarm_of_groups`, the score above which an exchange is named.

    Returns:
        None also for more than 150 curves, for which the exchange is not tried.
    """
    conditions_as_read = surface.measurements.conditions
    run_count = len(conditions_as_read)
    if run_count > LARGEST_DENSE:
        return None
    as_labelled = Relabelled.as_read(surface, errors or RunErrorSizes())
    likeliest = current = as_labelled
    for _ in range(_ROUNDS):
        proposed_conditions = _likeliest_conditions(current)
        if proposed_conditions is None:
            break
        # a round may be worse before the next one is better
        current = current.fitted_to(replace(current.measurements, conditions=proposed_conditions))
        if current.objective < likeliest.objective:
            likeliest = current
    moved_curves = np.flatnonzero(
        _is_moved(
            conditions_as_read, likeliest.measurements.conditions, surface.measurements.level_widths
        )
    )
    moved_count = len(moved_curves)
    if not moved_count:
        return None
    # groups of this size, and the orders of their labels
    ln_choices = np.log(scipy.special.comb(run_count, moved_count)) + scipy.special.gammaln(
        moved_count + 1
    )
    score = float(2 * (as_labelled.objective - likeliest.objective - ln_choices))
    alarm_score = (limits or SteadinessLimits()).alarm_of_groups
    new_temperatures_c = likeliest.measurements.conditions[moved_curves, _TEMPERATURE]
    return LabelSwap(moved_curves, new_temperatures_c, score, score > alarm_score)


def _is_moved(
    conditions_before: FloatArray, conditions_after: FloatArray, widths: LevelWidths
) -> BoolArray:
    """Whether the temperature of each curve has another level afterwards, shape (curves,)."""
    difference_k = conditions_after[:, _TEMPERATURE] - conditions_before[:, _TEMPERATURE]
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


def _likeliest_conditions(relabelled: Relabelled) -> FloatArray | None:
    """The conditions after the likeliest exchange; None if that changes no temperature."""
    suspect_curves = _suspects(relabelled)
    conditions = relabelled.measurements.conditions
    temperatures = conditions[suspect_curves, _TEMPERATURE]
    log_density = _log_densities(relabelled, suspect_curves, temperatures)
    _, temperature_index_of_suspect = scipy.optimize.linear_sum_assignment(-log_density)
    proposed_conditions = conditions.copy()
    proposed_conditions[suspect_curves, _TEMPERATURE] = temperatures[temperature_index_of_suspect]
    is_moved = _is_moved(conditions, proposed_conditions, relabelled.measurements.level_widths)
    proposed_conditions[~is_moved] = conditions[~is_moved]
    return proposed_conditions if is_moved.any() else None


def _suspects(relabelled: Relabelled) -> IndexArray:
    """Indices of curves: those with changed labels, and those that contradict all others most."""
    run_count = len(relabelled.measurements.conditions)
    mean_squares_of_curves = []
    for left_out in DensePosterior(relabelled.covariance).left_out(np.arange(run_count)):
        squares = left_out.error @ left_out.precision @ left_out.error
        mean_squares_of_curves.append(squares / len(left_out.error))
    mean_squares = np.array(mean_squares_of_curves)
    measurements_as_read = relabelled.surface.measurements
    mean_squares[
        _is_moved(
            measurements_as_read.conditions,
            relabelled.measurements.conditions,
            measurements_as_read.level_widths,
        )
    ] = np.inf
    suspect_count = min(_MOST_SUSPECTS, int(_LARGEST_SHARE * run_count))
    return np.sort(np.argsort(-mean_squares, kind="stable")[:suspect_count])


def _log_densities(
    relabelled: Relabelled, suspect_curves: IndexArray, temperatures: FloatArray
) -> FloatArray:
    """Logarithm of the density of each suspect at each temperature, by the other runs.

    Returns:
        Shape (suspects, temperatures).
    """
    curves = relabelled.covariance.curves
    remaining_coordinates = np.flatnonzero(~np.isin(curves.curve_of_coordinate, suspect_curves))
    remaining_covariance = relabelled.covariance.matrix()[
        np.ix_(remaining_coordinates, remaining_coordinates)
    ]
    factor = scipy.linalg.cholesky(remaining_covariance, lower=True)
    weights = scipy.linalg.cho_solve((factor, True), curves.departure[remaining_coordinates])
    remaining = _RemainingCurves(curves.select_coordinates(remaining_coordinates), factor, weights)
    distinct_temperatures, distinct_temperature_index = np.unique(temperatures, return_inverse=True)
    log_density = [
        _log_densities_of_run(relabelled, remaining, curve_index, distinct_temperatures)
        for curve_index in suspect_curves
    ]
    return np.array(log_density)[:, distinct_temperature_index]


def _log_densities_of_run(
    relabelled: Relabelled, remaining: _RemainingCurves, curve_index: int, temperatures: FloatArray
) -> FloatArray:
    """Logarithm of the density of a curve at each temperature, by the remaining curves.

    The curve is copied to each temperature, and all copies are reduced at once.

    Args:
        relabelled: The points with the temperatures of this round.
        remaining: The curves that predict this one.
        curve_index: Index of the curve.
        temperatures: Temperatures, in degC, shape (temperatures,).
    """
    covariance, sizes = relabelled.covariance, relabelled.covariance.sizes
    measurements = relabelled.measurements
    conditions = np.tile(measurements.conditions[curve_index], (len(temperatures), 1))
    conditions[:, _TEMPERATURE] = temperatures
    copies = measurements.copied_to_conditions(curve_index, conditions)
    law = relabelled.surface.law
    curves = reduced_curves(copies, law, law.log_mu, float(sizes.effects[_ZERO]), covariance.box)
    every_coordinate = curves.select_coordinates(np.arange(len(curves.departure)))
    cross_covariance = smooth_covariance(covariance, every_coordinate, remaining.coordinates)
    whitened_across = scipy.linalg.solve_triangular(
        remaining.covariance_factor, cross_covariance.T, lower=True
    )
    error = curves.departure - cross_covariance @ remaining.weights
    log_densities = []
    for coordinate_indices in coordinates_by_group(
        curves.curve_of_coordinate, np.arange(len(temperatures))
    ):
        curve_copy = curves.select_coordinates(coordinate_indices)
        whitened_across_copy = whitened_across[:, coordinate_indices]
        scaled_effects = curves.effects[coordinate_indices] * sizes.effects
        curve_covariance = (
            smooth_covariance(covariance, curve_copy, curve_copy)
            - whitened_across_copy.T @ whitened_across_copy
        )
        curve_covariance += scaled_effects @ scaled_effects.T
        curve_covariance += sizes.noise**2 * np.eye(len(coordinate_indices))
        curve_factor = scipy.linalg.cholesky(curve_covariance, lower=True)
        whitened = scipy.linalg.solve_triangular(
            curve_factor, error[coordinate_indices], lower=True
        )
        log_densities.append(-whitened @ whitened / 2 - np.sum(np.log(np.diag(curve_factor))))
    return np.array(log_densities)
