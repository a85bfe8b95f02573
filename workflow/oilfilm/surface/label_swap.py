"""Runs whose temperature labels were exchanged among each other.

A label that is wrong by 20 K or more acts like no small effect of a run, so the exchange is tried.
The runs that contradict the others most are left out together. The other runs predict each of them
at the temperature of each, and the likeliest assignment is taken. This is repeated with the new
temperatures until none changes. The likelihood of all points then stands beside the likelihood with
the temperatures as they were.

Decides: when temperature labels are called exchanged.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.special

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.surface.effects import EFFECTS, RunErrorSizes
from oilfilm.surface.measurements import LEVEL_WIDTH, Measurements, scaled_conditions
from oilfilm.surface.posterior import DensePosterior, smooth_covariance
from oilfilm.surface.reduction import Coordinates, box_of, reduced
from oilfilm.surface.reml import (
    MISFIT,
    CurveCovariance,
    Sizes,
    most_likely_sizes,
    objective,
    priors,
)
from oilfilm.surface.steadiness import SteadinessLimits
from oilfilm.surface.surface import LARGEST_DENSE, Surface
from oilfilm.surface.threads import with_one_blas_thread

_TEMPERATURE = 2
_ZERO = EFFECTS.index("zero")
# Largest number of runs that are suspected together, and their largest share.
_MOST_SUSPECTS, _LARGEST_SHARE = 8, 1 / 3
_ROUNDS = 6


@dataclass(frozen=True)
class LabelSwap:
    """Temperatures that were exchanged among some runs.

    Attributes:
        curves: Rows of the measurements whose temperature changes, shape (swapped,).
        temperatures_c: The temperatures with which they agree, shape (swapped,).
        score: Twice the logarithm of the likelihood ratio, less that of the number of exchanges.
        is_alarm: Whether the exchange explains more than chance does.
    """

    curves: IndexArray
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
    given = surface.measurements.conditions
    runs = len(given)
    if runs > LARGEST_DENSE:
        return None
    as_labelled = _Labelling.of_surface(surface, errors or RunErrorSizes())
    labels = present = as_labelled
    for _ in range(_ROUNDS):
        proposed = present.likeliest_conditions()
        if proposed is None:
            break
        # a round may be worse before the next one is better
        present = present.with_other_conditions(proposed)
        if present.objective < labels.objective:
            labels = present
    moved = np.flatnonzero(_is_moved(given, labels.measurements.conditions))
    count = len(moved)
    if not count:
        return None
    # groups of this size, and the orders of their labels
    choices = np.log(scipy.special.comb(runs, count)) + scipy.special.gammaln(count + 1)
    score = float(2 * (as_labelled.objective - labels.objective - choices))
    alarm = (limits or SteadinessLimits()).alarm_of_groups
    new = labels.measurements.conditions[moved, _TEMPERATURE]
    return LabelSwap(moved, new, score, score > alarm)


def _is_moved(old: FloatArray, new: FloatArray) -> BoolArray:
    """Whether the temperature of each row has another level, shape (rows,)."""
    difference = scaled_conditions(new) - scaled_conditions(old)
    return np.abs(difference[:, _TEMPERATURE]) > LEVEL_WIDTH


@dataclass(frozen=True)
class _Labelling:
    """The points with some temperatures.

    Attributes:
        surface: The surface of the points as they were labelled.
        errors: Sizes of the errors of the rig, before the data.
        measurements: The points with these temperatures.
        covariance: Covariance of the curves, with its most likely sizes.
        objective: Negative logarithm of the likelihood.
    """

    surface: Surface
    errors: RunErrorSizes
    measurements: Measurements
    covariance: CurveCovariance
    objective: float

    @classmethod
    def of_surface(cls, surface: Surface, errors: RunErrorSizes) -> "_Labelling":
        """The points as they were labelled."""
        start = surface.misfit_covariance.sizes.logarithms()
        return cls._fitted(surface, surface.measurements.conditions, errors, start)

    @classmethod
    def _fitted(
        cls, surface: Surface, conditions: FloatArray, errors: RunErrorSizes, start: FloatArray
    ) -> "_Labelling":
        """The points with some conditions, fitted.

        Args:
            surface: The surface of the points as they were labelled.
            conditions: The conditions, shape (curves, 3).
            errors: Sizes of the errors of the rig, before the data.
            start: Logarithms of the sizes at which the search starts.
        """
        measurements = replace(surface.measurements, conditions=conditions)
        box = box_of(measurements)
        zero_sd = max(errors.zero.median, surface.effect_sizes()["zero"])
        curves = reduced(measurements, surface.law, surface.log_mu, zero_sd, box)
        known = priors(errors, MISFIT)
        logarithms = most_likely_sizes(curves, box, known, start)
        value, _ = objective(logarithms, curves, box, known)
        covariance = CurveCovariance(curves, box, Sizes.from_logarithms(logarithms))
        return cls(surface, errors, measurements, covariance, float(value))

    def with_other_conditions(self, conditions: FloatArray) -> "_Labelling":
        """The same points with other conditions."""
        start = self.covariance.sizes.logarithms()
        return self._fitted(self.surface, conditions, self.errors, start)

    def likeliest_conditions(self) -> FloatArray | None:
        """The conditions after the likeliest exchange; None if that changes no temperature."""
        suspects = self._suspects()
        conditions = self.measurements.conditions
        temperatures = conditions[suspects, _TEMPERATURE]
        density = self._log_densities(suspects, temperatures)
        _, assigned = scipy.optimize.linear_sum_assignment(-density)
        proposed = conditions.copy()
        proposed[suspects, _TEMPERATURE] = temperatures[assigned]
        is_moved = _is_moved(conditions, proposed)
        proposed[~is_moved] = conditions[~is_moved]
        return proposed if is_moved.any() else None

    def _suspects(self) -> IndexArray:
        """The runs whose labels were changed, and those that contradict all others most."""
        runs = len(self.measurements.conditions)
        contradiction = []
        for left_out in DensePosterior(self.covariance).left_out(np.arange(runs)):
            squares = left_out.error @ left_out.precision @ left_out.error
            contradiction.append(squares / len(left_out.error))
        size = np.array(contradiction)
        size[_is_moved(self.surface.measurements.conditions, self.measurements.conditions)] = np.inf
        count = min(_MOST_SUSPECTS, int(_LARGEST_SHARE * runs))
        return np.sort(np.argsort(-size, kind="stable")[:count])

    def _log_densities(self, suspects: IndexArray, temperatures: FloatArray) -> FloatArray:
        """Logarithm of the density of each suspect at each temperature, from the other runs."""
        curves = self.covariance.curves
        kept = np.flatnonzero(~np.isin(curves.curve, suspects))
        matrix = self.covariance.matrix()[np.ix_(kept, kept)]
        factor = scipy.linalg.cholesky(matrix, lower=True)
        weights = scipy.linalg.cho_solve((factor, True), curves.departure[kept])
        rest = _Rest(curves.part(kept), factor, weights)
        different, number = np.unique(temperatures, return_inverse=True)
        density = [[self._log_density(rest, row, t) for t in different] for row in suspects]
        return np.array(density)[:, number]

    def _log_density(self, rest: "_Rest", row: int, temperature_c: float) -> float:
        """Logarithm of the density of a curve at some temperature, from the remaining curves."""
        covariance, sizes = self.covariance, self.covariance.sizes
        alone = self.measurements.of_curves(np.array([row]))
        conditions = alone.conditions.copy()
        conditions[:, _TEMPERATURE] = temperature_c
        moved = replace(alone, conditions=conditions)
        law = self.surface.law
        curve = reduced(moved, law, law.log_mu, float(sizes.effects[_ZERO]), covariance.box)
        places = curve.part(np.arange(len(curve.departure)))
        across = smooth_covariance(covariance, places, rest.places)
        half = scipy.linalg.solve_triangular(rest.factor, across.T, lower=True)
        own = smooth_covariance(covariance, places, places) - half.T @ half
        scaled = curve.effects * sizes.effects
        own += scaled @ scaled.T + sizes.noise**2 * np.eye(len(own))
        own_factor = scipy.linalg.cholesky(own, lower=True)
        error = curve.departure - across @ rest.weights
        whitened = scipy.linalg.solve_triangular(own_factor, error, lower=True)
        return float(-whitened @ whitened / 2 - np.sum(np.log(np.diag(own_factor))))


@dataclass(frozen=True)
class _Rest:
    """The remaining curves, which predict the suspects.

    Attributes:
        places: Their coordinates.
        factor: Lower Cholesky factor of their covariance.
        weights: Inverse of their covariance times the departure.
    """

    places: Coordinates
    factor: FloatArray
    weights: FloatArray
