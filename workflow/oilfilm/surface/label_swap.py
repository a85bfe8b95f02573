"""Runs whose temperature labels were exchanged among each other.

A label that is wrong by 20 K or more acts like no small effect of a run, so the exchange is tried.
The runs that contradict the others most are left out together. The other runs predict each of them
at the temperature of each, and the likeliest assignment is taken. This is repeated with the new
temperatures until none changes. The likelihood of all points then stands beside the likelihood with
the temperatures as they were. A run is one curve here, and one row of the conditions.

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
from oilfilm.surface.reduction import Coordinates, reduced
from oilfilm.surface.relabelled import Relabelled
from oilfilm.surface.steadiness import SteadinessLimits
from oilfilm.surface.surface import LARGEST_DENSE, Surface
from oilfilm.surface.threads import with_one_blas_thread

# Column of the temperature among the conditions, and of the zero among the effects.
_TEMPERATURE = 2
_ZERO = EFFECTS.index("zero")
# Largest number of runs that are suspected together, and their largest share.
_MOST_SUSPECTS, _LARGEST_SHARE = 8, 1 / 3
# Exchanges that are tried one after the other.
_ROUNDS = 6


@dataclass(frozen=True)
class LabelSwap:
    """Temperatures that were exchanged among some runs.

    Attributes:
        rows: Rows of the measurements whose temperature changes, shape (swapped,).
        temperatures_c: The temperatures with which they agree, shape (swapped,).
        score: Twice the logarithm of the likelihood ratio, less that of the number of exchanges.
        is_alarm: Whether the exchange explains more than chance does.
    """

    rows: IndexArray
    temperatures_c: FloatArray
    score: float
    is_alarm: bool


@with_one_blas_thread
def swapped_temperatures(
    surface: Surface, errors: RunErrorSizes | None = None, limits: SteadinessLimits | None = None
) -> LabelSwap | None:
    """The exchange of temperatures that explains most; None if no exchange explains anything.

    Args:
        surface: The surface; its measurements are in canonical order.
        errors: Sizes of the errors of the rig, before the data.
        limits: When an exchange is named: as a group of runs.

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
        proposed = _likeliest_conditions(current)
        if proposed is None:
            break
        # a round may be worse before the next one is better
        current = current.fitted_to(replace(current.measurements, conditions=proposed))
        if current.objective < likeliest.objective:
            likeliest = current
    moved = np.flatnonzero(
        _is_moved(
            conditions_as_read, likeliest.measurements.conditions, surface.measurements.level_widths
        )
    )
    count = len(moved)
    if not count:
        return None
    # groups of this size, and the orders of their labels
    ln_choices = np.log(scipy.special.comb(run_count, count)) + scipy.special.gammaln(count + 1)
    score = float(2 * (as_labelled.objective - likeliest.objective - ln_choices))
    alarm_score = (limits or SteadinessLimits()).alarm_of_groups
    new_temperatures_c = likeliest.measurements.conditions[moved, _TEMPERATURE]
    return LabelSwap(moved, new_temperatures_c, score, score > alarm_score)


def _is_moved(old: FloatArray, new: FloatArray, widths: LevelWidths) -> BoolArray:
    """Whether the temperature of each row has another level, shape (rows,)."""
    difference_k = new[:, _TEMPERATURE] - old[:, _TEMPERATURE]
    return np.asarray(np.abs(difference_k) > widths.temperature_k)


@dataclass(frozen=True)
class _RemainingCurves:
    """The remaining curves, which predict the suspects.

    Attributes:
        coordinates: The curves as weighted sums of values (`Coordinates`).
        factor: Lower Cholesky factor of their covariance.
        weights: Inverse of their covariance times the departure of ln mu from the law.
    """

    coordinates: Coordinates
    factor: FloatArray
    weights: FloatArray


def _likeliest_conditions(relabelled: Relabelled) -> FloatArray | None:
    """The conditions after the likeliest exchange; None if that changes no temperature."""
    suspects = _suspects(relabelled)
    conditions = relabelled.measurements.conditions
    temperatures = conditions[suspects, _TEMPERATURE]
    log_density = _log_densities(relabelled, suspects, temperatures)
    _, assigned = scipy.optimize.linear_sum_assignment(-log_density)
    proposed = conditions.copy()
    proposed[suspects, _TEMPERATURE] = temperatures[assigned]
    is_moved = _is_moved(conditions, proposed, relabelled.measurements.level_widths)
    proposed[~is_moved] = conditions[~is_moved]
    return proposed if is_moved.any() else None


def _suspects(relabelled: Relabelled) -> IndexArray:
    """The runs whose labels were changed, and those that contradict all others most."""
    run_count = len(relabelled.measurements.conditions)
    contradiction = []
    for left_out in DensePosterior(relabelled.covariance).left_out(np.arange(run_count)):
        squares = left_out.error @ left_out.precision @ left_out.error
        contradiction.append(squares / len(left_out.error))
    mean_squares = np.array(contradiction)
    measurements_as_read = relabelled.surface.measurements
    mean_squares[
        _is_moved(
            measurements_as_read.conditions,
            relabelled.measurements.conditions,
            measurements_as_read.level_widths,
        )
    ] = np.inf
    count = min(_MOST_SUSPECTS, int(_LARGEST_SHARE * run_count))
    return np.sort(np.argsort(-mean_squares, kind="stable")[:count])


def _log_densities(
    relabelled: Relabelled, suspects: IndexArray, temperatures: FloatArray
) -> FloatArray:
    """Logarithm of the density of each suspect at each temperature, from the other runs."""
    curves = relabelled.covariance.curves
    remaining_index = np.flatnonzero(~np.isin(curves.curve, suspects))
    remaining_covariance = relabelled.covariance.matrix()[np.ix_(remaining_index, remaining_index)]
    factor = scipy.linalg.cholesky(remaining_covariance, lower=True)
    weights = scipy.linalg.cho_solve((factor, True), curves.departure[remaining_index])
    remaining = _RemainingCurves(curves.select(remaining_index), factor, weights)
    distinct_temperatures, distinct_index = np.unique(temperatures, return_inverse=True)
    log_density = [
        _log_densities_of_run(relabelled, remaining, row, distinct_temperatures) for row in suspects
    ]
    return np.array(log_density)[:, distinct_index]


def _log_densities_of_run(
    relabelled: Relabelled, remaining: _RemainingCurves, row: int, temperatures: FloatArray
) -> FloatArray:
    """Logarithm of the density of a curve at each temperature, from the remaining curves.

    The curve is reduced at all temperatures at once, as if each were a run.
    """
    covariance, sizes = relabelled.covariance, relabelled.covariance.sizes
    measurements = relabelled.measurements
    conditions = np.tile(measurements.conditions[row], (len(temperatures), 1))
    conditions[:, _TEMPERATURE] = temperatures
    copies = measurements.at_conditions(row, conditions)
    law = relabelled.surface.law
    curves = reduced(copies, law, law.log_mu, float(sizes.effects[_ZERO]), covariance.box)
    every_coordinate = curves.select(np.arange(len(curves.departure)))
    across = smooth_covariance(covariance, every_coordinate, remaining.coordinates)
    whitened_across = scipy.linalg.solve_triangular(remaining.factor, across.T, lower=True)
    error = curves.departure - across @ remaining.weights
    log_densities = []
    for coordinates in coordinates_by_group(curves.curve, np.arange(len(temperatures))):
        copy = curves.select(coordinates)
        explained = whitened_across[:, coordinates]
        scaled_effects = curves.effects[coordinates] * sizes.effects
        curve_covariance = smooth_covariance(covariance, copy, copy) - explained.T @ explained
        curve_covariance += scaled_effects @ scaled_effects.T
        curve_covariance += sizes.noise**2 * np.eye(len(coordinates))
        curve_factor = scipy.linalg.cholesky(curve_covariance, lower=True)
        whitened = scipy.linalg.solve_triangular(curve_factor, error[coordinates], lower=True)
        log_densities.append(-whitened @ whitened / 2 - np.sum(np.log(np.diag(curve_factor))))
    return np.array(log_densities)
