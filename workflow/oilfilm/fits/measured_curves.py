"""What the measured curves of an oil tell about the constants of its law."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm.errors import OilfilmError
from oilfilm.fits.curve_errors import (
    Curves,
    ErrorSizes,
    effects,
    error_sizes,
    information,
)
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.optimal_design import Information
from oilfilm.fits.problem import curve_data
from oilfilm.settings.rig import Calibration
from oilfilm.traction.law import Law, to_internal
from oilfilm.units import BoolArray, FloatArray


@dataclass(frozen=True)
class Known:
    """What the measured curves tell about the constants that are not fixed.

    Attributes:
        law: The fitted law.
        internal: All its internal constants.
        free: Which of them the data decide.
        information: Of all measured curves.
        sizes: Variances of what is wrong in a curve, from the residuals of the fit.
        calibration: Standard uncertainty of each sensor's calibration.
        slip: Slide-roll ratios of the curve with the most points.
    """

    law: Law
    internal: FloatArray
    free: BoolArray
    information: Information
    sizes: ErrorSizes
    calibration: FloatArray
    slip: FloatArray

    def of_curves(self, curves: Curves) -> Information:
        """What each of some curves would tell."""
        jacobian = self.law.jacobian(self.internal, curves.at(self.law))[:, self.free]
        effect = effects(self.law, self.internal, curves)
        return information(jacobian, effect, self.sizes, self.calibration, curves.curve)


def known_of(
    fitted: FittedLaw, points: pd.DataFrame, oil: str, calibration: Calibration | None
) -> Known:
    """What the measured curves of an oil tell about the constants of its law.

    Args:
        fitted: The law with its refits.
        points: Table of points; those of the oil are used.
        oil: Name of the oil.
        calibration: Of the rig's sensors; without it they are taken as exact.

    Raises:
        OilfilmError: The fit has no constants, no refits, or does not follow a condition; or the
            points do not tell its constants apart.
    """
    coefficients = fitted.coefficients
    if np.isnan(coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    if coefficients.fixed or not coefficients.known.all():
        where = "; ".join(each.sentence() for each in coefficients.fixed)
        raise OilfilmError(
            f"{oil}: a plan needs a law that follows every condition ({where or 'it does not'}). "
            "First test at two or more levels of each condition, varied one at a time."
        )
    if len(coefficients.spread) < 2:
        raise OilfilmError(
            f"{oil}: the uncertainty of the constants is not known, because too few curves were "
            "tested (fit.min_curves_for_errors of config/config.yaml). Test more conditions first."
        )
    law = fitted.law
    internal = to_internal(law, coefficients.constants)
    spread = to_internal(law, coefficients.spread)
    # constants that the law gives, or that ended at a bound, are the same in every refit
    free = np.ptp(spread, axis=0) > 0
    curves, mu = _measured_curves(points[points["oil"] == oil], law)
    jacobian = law.jacobian(internal, curves.at(law))[:, free]
    if np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        raise OilfilmError(
            f"{oil}: the accepted points do not tell the law's constants apart. Test at two or "
            "more levels of each condition, or fit again if points and fit are of different runs."
        )
    residual = mu - law.traction(internal, curves.at(law))
    effect = effects(law, internal, curves)
    sizes = error_sizes(jacobian, effect, residual, curves.curve)
    sensors = _sensor_errors(calibration)
    each = information(jacobian, effect, sizes, sensors, curves.curve)
    hessian = each.hessian.sum(axis=0)
    covariance = np.atleast_2d(np.cov(spread[:, free], rowvar=False))
    # the scatter that gives the constants the covariance of the bootstrap
    scatter = hessian @ covariance @ hessian
    now = Information(hessian, scatter, each.shared.sum(axis=0))
    longest = np.argmax(np.bincount(curves.curve))
    slip = np.sort(curves.slip[curves.curve == longest])
    return Known(law, internal, free, now, sizes, sensors, slip)


def _measured_curves(points: pd.DataFrame, law: Law) -> tuple[Curves, FloatArray]:
    """Accepted curves whose conditions are all known, and mu of their points."""
    accepted = points[points["accepted"]].dropna(subset=[*law.conditions, "load_n"])
    data = curve_data(accepted, law.conditions)
    load = accepted.groupby("run_id", sort=True)["load_n"].mean().to_numpy(dtype=float)
    return Curves(data.conditions, load, data.curve, data.slip), data.mu


def _sensor_errors(calibration: Calibration | None) -> FloatArray:
    """Standard uncertainties in the order of `systematic.SENSORS`; 0 where they are not stated."""
    if calibration is None:
        return np.zeros(4)
    return np.array(
        [
            calibration.load_relative,
            calibration.traction_force_relative,
            calibration.speed_relative,
            calibration.temperature_c,
        ]
    )
