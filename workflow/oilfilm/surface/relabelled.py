"""How likely the points of a campaign are if a condition or the slip was read wrongly.

Decides: how a reading with an error too large for an effect of a run is judged.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import RunErrorSizes
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.reduction import ReducedCurves, box_of, reduced_curves
from oilfilm.surface.reml import MISFIT, CurveCovariance, most_likely_sizes, objective, priors
from oilfilm.surface.surface import CURVES_FOR_SIZES, Surface


@dataclass(frozen=True)
class Relabelled:
    """The points of a campaign with other readings, and their likelihood.

    Attributes:
        surface: The surface of the points as they were read.
        errors: Sizes of the errors of the rig, before the data.
        measurements: The points with the other readings; curves and points are in the order of
            those of the surface.
        covariance: Covariance of the curves, with its most likely sizes.
        objective: Negative logarithm of the likelihood, up to a constant; smaller is likelier.
    """

    surface: Surface
    errors: RunErrorSizes
    measurements: Measurements
    covariance: CurveCovariance
    objective: float

    @classmethod
    def as_read(cls, surface: Surface, errors: RunErrorSizes) -> "Relabelled":
        """The points as they were read, with the sizes that are most likely for them."""
        measurements, sizes = surface.measurements, surface.misfit_covariance.sizes
        if len(measurements.conditions) > CURVES_FOR_SIZES:
            # those of the surface are of a sample of the curves
            return cls._fitted(surface, errors, measurements, sizes.logarithms())
        curves, box = _reduced(surface, errors, measurements), box_of(measurements)
        objective_value, _ = objective(sizes.logarithms(), curves, box, priors(errors, MISFIT))
        covariance = CurveCovariance(curves, box, sizes)
        return cls(surface, errors, measurements, covariance, float(objective_value))

    @classmethod
    def _fitted(
        cls, surface: Surface, errors: RunErrorSizes, measurements: Measurements, start: FloatArray
    ) -> "Relabelled":
        """The points with some readings, at their most likely sizes.

        Args:
            surface: The surface of the points as they were read.
            errors: Sizes of the errors of the rig, before the data.
            measurements: The points with the other readings.
            start: Logarithms of the sizes at which the search starts.
        """
        box, size_priors = box_of(measurements), priors(errors, MISFIT)
        curves = _reduced(surface, errors, measurements)
        most_likely = most_likely_sizes(curves, box, size_priors, start)
        objective_value, _ = objective(most_likely.logarithms, curves, box, size_priors)
        covariance = CurveCovariance(curves, box, most_likely.sizes)
        return cls(surface, errors, measurements, covariance, float(objective_value))

    def fitted_to(self, measurements: Measurements) -> "Relabelled":
        """The same points with other readings, at their most likely sizes."""
        start = self.covariance.sizes.logarithms()
        return self._fitted(self.surface, self.errors, measurements, start)

    def objective_of(self, measurements: Measurements) -> float:
        """The negative logarithm of the likelihood of other readings, at the present sizes.

        A constant that is the same for all readings is left out: only differences mean something.
        """
        curves = _reduced(self.surface, self.errors, measurements)
        covariance = CurveCovariance(curves, box_of(measurements), self.covariance.sizes)
        factor = scipy.linalg.cholesky(covariance.matrix(), lower=True)
        whitened = scipy.linalg.solve_triangular(factor, curves.departure, lower=True)
        noise = self.covariance.sizes.noise
        remainder_term = np.sum((curves.remainder / noise) ** 2) / 2
        coordinate_term = whitened @ whitened / 2 + np.sum(np.log(np.diag(factor)))
        return float(coordinate_term + remainder_term)


def _reduced(surface: Surface, errors: RunErrorSizes, measurements: Measurements) -> ReducedCurves:
    """The curves with some readings; near zero traction, ln mu is linearised about the surface."""
    zero_sd = max(errors.zero.median, surface.effect_sizes()["zero"])
    return reduced_curves(measurements, surface.law, surface.log_mu, zero_sd, box_of(measurements))
