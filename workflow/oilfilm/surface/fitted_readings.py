"""How likely the points of a campaign are if a condition or the slip was read wrongly.

Decides: how a reading with an error too large for an effect of a run is judged.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.reduction import ReducedCurves, box_of, reduced_curves
from oilfilm.surface.reml import (
    MISFIT_KAPPA_PRIOR,
    CurveCovariance,
    most_likely_sizes,
    objective,
    priors,
)
from oilfilm.surface.surface import CURVE_COUNT_FOR_SIZES, Surface


@dataclass(frozen=True)
class FittedReadings:
    """The points of a campaign by some readings of conditions and slip, and their likelihood.

    Attributes:
        surface: The surface of the points as they were read.
        error_priors: Priors of the sizes of the errors of the rig.
        measurements: The points by these readings; curves and points are in the order of those of
            the surface.
        covariance: Covariance of the curves, with its most likely sizes.
        negative_ln_posterior: Negative logarithm of likelihood times priors of the sizes, up to a
            constant; smaller is likelier.
    """

    surface: Surface
    error_priors: ErrorPriors
    measurements: Measurements
    covariance: CurveCovariance
    negative_ln_posterior: float

    @classmethod
    def as_read(cls, surface: Surface, error_priors: ErrorPriors) -> "FittedReadings":
        """The points as they were read, with the sizes that are most likely for them."""
        measurements, sizes = surface.measurements, surface.misfit_covariance.sizes
        if len(measurements.conditions) > CURVE_COUNT_FOR_SIZES:
            # those of the surface are of a sample of the curves
            return cls._fitted(surface, error_priors, measurements, sizes.logarithms())
        curves, box = _reduced(surface, error_priors, measurements), box_of(measurements)
        negative_ln_posterior, _ = objective(
            sizes.logarithms(), curves, box, priors(error_priors, MISFIT_KAPPA_PRIOR)
        )
        covariance = CurveCovariance(curves, box, sizes)
        return cls(surface, error_priors, measurements, covariance, float(negative_ln_posterior))

    @classmethod
    def _fitted(
        cls,
        surface: Surface,
        error_priors: ErrorPriors,
        measurements: Measurements,
        start: FloatArray,
    ) -> "FittedReadings":
        """The points with some readings, at their most likely sizes.

        Args:
            surface: The surface of the points as they were read.
            error_priors: Priors of the sizes of the errors of the rig.
            measurements: The points by these readings.
            start: Logarithms of the sizes at which the search starts.
        """
        box, size_priors = box_of(measurements), priors(error_priors, MISFIT_KAPPA_PRIOR)
        curves = _reduced(surface, error_priors, measurements)
        most_likely = most_likely_sizes(curves, box, size_priors, start)
        negative_ln_posterior, _ = objective(most_likely.logarithms, curves, box, size_priors)
        covariance = CurveCovariance(curves, box, most_likely.sizes)
        return cls(surface, error_priors, measurements, covariance, float(negative_ln_posterior))

    def fit_to(self, measurements: Measurements) -> "FittedReadings":
        """The same points with other readings, at their most likely sizes."""
        start = self.covariance.sizes.logarithms()
        return self._fitted(self.surface, self.error_priors, measurements, start)

    def negative_ln_likelihood_of(self, measurements: Measurements) -> float:
        """The negative logarithm of the likelihood of other readings, at the present sizes.

        A constant that is the same for all readings is left out: only differences mean something.
        It is infinite where the law has no traction at a point with these readings.
        """
        law = self.surface.law
        if not law.has_traction(measurements.point_conditions, measurements.slip).all():
            return np.inf
        curves = _reduced(self.surface, self.error_priors, measurements)
        covariance = CurveCovariance(curves, box_of(measurements), self.covariance.sizes)
        factor = scipy.linalg.cholesky(covariance.matrix(), lower=True)
        whitened = scipy.linalg.solve_triangular(factor, curves.departure, lower=True)
        noise = self.covariance.sizes.noise
        remainder_term = np.sum((curves.remainder / noise) ** 2) / 2
        coordinate_term = whitened @ whitened / 2 + np.sum(np.log(np.diag(factor)))
        return float(coordinate_term + remainder_term)


def _reduced(
    surface: Surface, error_priors: ErrorPriors, measurements: Measurements
) -> ReducedCurves:
    """The curves with some readings; near zero traction, ln mu is linearised about the surface."""
    zero_sd = max(error_priors.zero.median, surface.effect_sizes()["zero"])
    return reduced_curves(measurements, surface.law, surface.log_mu, zero_sd, box_of(measurements))
