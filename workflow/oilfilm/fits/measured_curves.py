"""The information of measured curves on a law's constants, and which curve to measure next.

The information of a curve can be computed before it is measured, from its slopes and the expected
errors of its points. It is the precision matrix (Fisher information) that the curve adds.
Precisions of curves add up, so a further measurement never makes a quantity less certain.

Curves are chosen that make the variance of a wanted quantity least: c-optimality, or A-optimality
(linear or L-optimality) for the mean over several quantities. The law is not linear in its
constants, so the design is optimal at the present constants (locally optimal). The curves of a plan
are chosen one after the other.

All points of a run share the errors of load, speed, temperature and zero of the force. A new curve
of 31 points is therefore less than 31 independent pieces of information.

Reference: A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum Experimental Designs, with SAS (2007),
chapters 10 and 17.

Decides: which errors the points of a run share, and how large they are; how much a further curve
would tell.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
import scipy

from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, first_largest, first_smallest
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import Curves, curve_data
from oilfilm.fits.uncertainty import SENSORS
from oilfilm.settings.rig import Calibration
from oilfilm.traction.law import Law, to_internal

# Errors that all points of a curve share: relative errors of load, force and speed, the error of
# the temperature in kelvins, and of the zero of the force in newtons.
CURVE_ERRORS = (*SENSORS, "zero of the force")
# Indices of the errors whose size is estimated, one error per run. An error of force or speed
# changes mu nearly as an error of the load does: their sizes could not be estimated separately.
_ESTIMATED_ERRORS = [
    CURVE_ERRORS.index("load"),
    CURVE_ERRORS.index("inlet temperature"),
    CURVE_ERRORS.index("zero of the force"),
]
# Range of the logarithm of a variance, over the mean square of its column.
_LOG_VARIANCE_RANGE = (-14.0, 4.0)
# Start of the search for variances, in the same unit but not a logarithm.
_FIRST_VARIANCE = 0.3
# Relative change of the deviance at which the search ends. With the default of SciPy it ends 1e-4
# from the optimum, where rounding decides.
_DEVIANCE_TOLERANCE = 1e-12
# Step of the logarithm of a condition, for slopes by differences.
_LOG_STEP = 1e-4
# A temperature nearer to 0 degC than this counts as this: a factor does not move 0.
_LEAST_TEMPERATURE_C = 1e-3
# Standard deviation of mu that replaces a smaller one: of an exact point.
_SMALLEST_MU_SD = 1e-9


def curve_error_slopes(law: Law, internal_constants: FloatArray, curves: Curves) -> FloatArray:
    """Change of (measured mu - law at the measured conditions) per unit of each of `CURVE_ERRORS`.

    A load sensor that reads (1 + e) W makes mu = F/W smaller. It also makes the pressure higher,
    which goes with the cube root of the load.

    Args:
        law: The law.
        internal_constants: Its internal constants, shape (constants,).
        curves: The points.

    Returns:
        Shape (points, errors).
    """
    temperature_index = law.conditions.index("inlet_temperature_c")
    conditions = curves.conditions.copy()
    is_near_zero = np.abs(conditions[:, temperature_index]) < _LEAST_TEMPERATURE_C
    conditions[is_near_zero, temperature_index] = _LEAST_TEMPERATURE_C

    def traction(sign: int, exponents: dict[str, float]) -> FloatArray:
        """mu with some conditions multiplied by powers of exp(sign * step)."""
        factors = [np.exp(sign * _LOG_STEP * exponents.get(name, 0.0)) for name in law.conditions]
        scaled_curves = replace(curves, conditions=conditions * factors)
        return law.traction(internal_constants, scaled_curves.observations(law))

    def slope(exponents: dict[str, float]) -> FloatArray:
        """Derivative of mu by the logarithm of a factor on these powers of conditions."""
        return np.asarray((traction(1, exponents) - traction(-1, exponents)) / (2 * _LOG_STEP))

    mu = law.traction(internal_constants, curves.observations(law))
    temperature = conditions[curves.curve_of_point, temperature_index]
    slope_by_load = slope({"load_n": 1.0, "max_hertz_pressure_gpa": 1 / 3})
    slope_by_speed = slope({"entrainment_speed_m_s": 1.0})
    slope_by_temperature = slope({"inlet_temperature_c": 1.0})
    slopes_by_error = {
        "load": -mu - slope_by_load,
        "traction force": mu,
        "entrainment speed": -slope_by_speed,
        "inlet temperature": -slope_by_temperature / temperature,
        "zero of the force": 1 / curves.load_n[curves.curve_of_point],
    }
    return np.column_stack([slopes_by_error[name] for name in CURVE_ERRORS])


@dataclass(frozen=True)
class ErrorVariances:
    """Variances of the errors of a curve and of its points.

    Attributes:
        curve_variances: Variance of each of `CURVE_ERRORS`, in its unit squared, shape (errors,). A
            curve has one error of each.
        point_variance: Variance of mu. A point has one error.
    """

    curve_variances: FloatArray
    point_variance: float


def error_variances(
    jacobian: FloatArray, error_slopes: FloatArray, residual: FloatArray, curve_of_point: IndexArray
) -> ErrorVariances:
    """Variances of the errors by restricted maximum likelihood.

    The residuals of curve i are modelled as J_i x + D_i b_i + e, where x are the free constants.
    The errors b_i of the run are normal with the variances v. The errors e of the points are
    independent and normal with the variance s^2. v and s^2 minimise

        sum ln|V_i| + ln|sum J_i^T V_i^-1 J_i| + r^T P r,  V_i = s^2 I + D_i diag(v) D_i^T,

    P = V^-1 - V^-1 J (J^T V^-1 J)^-1 J^T V^-1. An error of the law's form counts as an error of the
    curve or of its points.

    Reference: H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545.

    Args:
        jacobian: J, slopes of mu by the free constants, shape (points, n).
        error_slopes: D, as `curve_error_slopes` returns it, shape (points, errors).
        residual: r, measured minus fitted mu, shape (points,).
        curve_of_point: Index of the curve of each point, ascending from 0, shape (points,).
    """
    if not residual.any():
        return ErrorVariances(np.zeros(len(CURVE_ERRORS)), 0.0)
    estimated_count = len(_ESTIMATED_ERRORS)
    columns = np.column_stack([error_slopes[:, _ESTIMATED_ERRORS], jacobian, residual])
    column_rms = np.sqrt(np.mean(columns**2, axis=0))
    columns = columns / column_rms
    # the likelihood needs only the products of the columns of each curve
    products = []
    points_per_curve = []
    for points in point_indices_by_curve(curve_of_point):
        products.append(columns[points].T @ columns[points])
        points_per_curve.append(len(points))
    stacked_products = np.stack(products)
    point_counts = np.array(points_per_curve)

    def deviance(log_variances: FloatArray) -> float:
        """`_deviance` of the variances whose logarithms are searched."""
        return _deviance(np.exp(log_variances), stacked_products, point_counts)

    search_result = scipy.optimize.minimize(
        deviance,
        np.log([_FIRST_VARIANCE] * (estimated_count + 1)),
        method="L-BFGS-B",
        jac="3-point",
        bounds=scipy.optimize.Bounds(*_LOG_VARIANCE_RANGE),
        options={"ftol": _DEVIANCE_TOLERANCE},
    )
    variances = np.exp(search_result.x) * column_rms[-1] ** 2
    curve_variances = np.zeros(len(CURVE_ERRORS))
    curve_variances[_ESTIMATED_ERRORS] = variances[:-1] / column_rms[:estimated_count] ** 2
    return ErrorVariances(curve_variances, float(variances[-1]))


def _deviance(variances: FloatArray, products: FloatArray, point_counts: IndexArray) -> float:
    """-2 ln of the restricted likelihood, without a constant.

    Args:
        variances: v and s^2 as in `error_variances`, shape (estimated errors + 1,).
        products: Products of the columns D, J, r of each curve, shape (curves, columns, columns).
        point_counts: Number of points of each curve, shape (curves,).
    """
    run_variances = variances[:-1]
    point_variance = variances[-1]
    error_count = len(run_variances)
    # V^-1 = (I - D inner^-1 D^T) / s^2
    inner_matrix = products[:, :error_count, :error_count] + np.diag(point_variance / run_variances)
    d_by_others = products[:, :error_count, error_count:]
    others_by_d = np.swapaxes(d_by_others, 1, 2)
    projected = others_by_d @ np.linalg.solve(inner_matrix, d_by_others)
    summed_products = (products[:, error_count:, error_count:] - projected).sum(
        axis=0
    ) / point_variance
    # blocks of J and r
    j_by_j = summed_products[:-1, :-1]
    j_by_r = summed_products[:-1, -1]
    r_by_r = summed_products[-1, -1]
    log_determinants = (
        np.sum((point_counts - error_count) * np.log(point_variance))
        + len(point_counts) * np.sum(np.log(run_variances))
        + np.linalg.slogdet(inner_matrix)[1].sum()
        + np.linalg.slogdet(j_by_j)[1]
    )
    return float(log_determinants + r_by_r - j_by_r @ np.linalg.solve(j_by_j, j_by_r))


def point_indices_by_curve(curve_of_point: IndexArray) -> list[IndexArray]:
    """Indices of the points of each curve, one array per curve."""
    return np.split(np.arange(len(curve_of_point)), np.flatnonzero(np.diff(curve_of_point)) + 1)


def precision_by_curve(
    slopes: FloatArray,
    error_slopes: FloatArray,
    variances: ErrorVariances,
    curve_of_point: IndexArray,
) -> FloatArray:
    """Precision that each curve adds about parameters: A^T V^-1 A, V = s^2 I + D diag(v) D^T.

    Args:
        slopes: A, slopes of mu by the parameters, shape (points, n).
        error_slopes: D, as `curve_error_slopes` returns it, shape (points, errors).
        variances: v and s^2, as `error_variances` returns them.
        curve_of_point: Index of the curve of each point, ascending from 0, shape (points,).

    Returns:
        Shape (curves, n, n).
    """
    error_indices = np.flatnonzero(variances.curve_variances > 0)
    # a point without any error would have infinite precision
    point_variance = max(variances.point_variance, _SMALLEST_MU_SD**2)
    variance_ratios = np.diag(point_variance / variances.curve_variances[error_indices])
    precisions = []
    for point_indices in point_indices_by_curve(curve_of_point):
        slopes_of_curve = slopes[point_indices]
        error_slopes_of_curve = error_slopes[point_indices][:, error_indices]
        d_by_a = error_slopes_of_curve.T @ slopes_of_curve
        inner = variance_ratios + error_slopes_of_curve.T @ error_slopes_of_curve
        precisions.append(
            slopes_of_curve.T @ slopes_of_curve - d_by_a.T @ np.linalg.solve(inner, d_by_a)
        )
    return np.stack(precisions) / point_variance


# Attributes of `Calibration`: the standard uncertainty of each sensor, in the order of `SENSORS`.
_CALIBRATION_KEYS = ("load_relative", "traction_force_relative", "speed_relative", "temperature_c")
# Largest number of centres of the error of the law's form.
_MOST_CENTRES = 30
# Least distance of two centres in correlation lengths: nearer centres add nothing.
_CENTRE_DISTANCE = 0.3
# Added to the correlation of the centres, so that its root exists.
_CORRELATION_JITTER = 1e-9


@dataclass(frozen=True)
class FormErrorProcess:
    """The error of the law's form, in its standard deviations, as a Gaussian process.

    Its correlation falls with the distance d as exp(-d^2/2), d in units of `correlation_lengths`.
    The process is a sum over a few centres with independent normal weights, so that precisions of
    curves add up.

    Reference: M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425 (discrepancy of a model);
        J. Quinonero-Candela, C. E. Rasmussen, J. Mach. Learn. Res. 6 (2005) 1939 (few centres).

    Attributes:
        correlation_lengths: Correlation length of each of ln W/3, ln U and T, shape (3,).
        centres: Coordinates of the centres, as `form_coordinates` gives them, shape (centres, 3).
    """

    correlation_lengths: FloatArray
    centres: FloatArray

    @classmethod
    def spread_over(
        cls, correlation_lengths: FloatArray, coordinates: FloatArray
    ) -> "FormErrorProcess":
        """The process with centres at some of the operating points, as far apart as possible.

        Args:
            correlation_lengths: Correlation lengths, shape (3,).
            coordinates: Operating points, as `form_coordinates` gives them, shape (points, 3). The
                first one is a centre.
        """
        centre_indices = [0]
        while len(centre_indices) < min(_MOST_CENTRES, len(coordinates)):
            lengths_away = (
                coordinates[:, np.newaxis] - coordinates[centre_indices]
            ) / correlation_lengths
            squared_distance = (lengths_away**2).sum(axis=-1)
            squared_distance_to_nearest = squared_distance.min(axis=1)
            if exceeds(_CENTRE_DISTANCE**2, squared_distance_to_nearest.max()):
                break
            centre_indices.append(int(first_largest(squared_distance_to_nearest)))
        return cls(correlation_lengths, coordinates[centre_indices])

    def error_per_weight(self, coordinates: FloatArray) -> FloatArray:
        """Error per unit of each standard normal weight.

        Args:
            coordinates: Operating points, as `form_coordinates` gives them, shape (..., 3).

        Returns:
            Shape (..., centres).
        """
        centre_count = len(self.centres)
        jitter = _CORRELATION_JITTER * np.eye(centre_count)
        root = np.linalg.cholesky(self._correlation(self.centres) + jitter)
        flat_coordinates = coordinates.reshape(-1, coordinates.shape[-1])
        correlation = self._correlation(flat_coordinates)
        error_per_weight = np.linalg.solve(root, correlation.T).T
        return error_per_weight.reshape(*coordinates.shape[:-1], centre_count)

    def _correlation(self, coordinates: FloatArray) -> FloatArray:
        """Correlation of the error at operating points and at the centres: (points, centres)."""
        lengths_away = (coordinates[:, np.newaxis] - self.centres) / self.correlation_lengths
        return np.asarray(np.exp(-0.5 * (lengths_away**2).sum(axis=-1)))


NO_FORM_ERROR_PROCESS = FormErrorProcess(np.ones(3), np.empty((0, 3)))


def form_coordinates(
    load_n: FloatArray, speed_m_s: FloatArray, temperature_c: FloatArray
) -> FloatArray:
    """Operating points as coordinates of the form's error: ln W/3, ln U and T.

    On one rig ln W/3 differs from the logarithm of the maximum Hertz pressure by a constant.

    Args:
        load_n: W.
        speed_m_s: U.
        temperature_c: T.

    Returns:
        Shape (..., 3).
    """
    return np.stack([np.log(load_n) / 3, np.log(speed_m_s), temperature_c], axis=-1)


@dataclass(frozen=True)
class Information:
    """Information of the measured curves on the constants that the data decide.

    The parameters are these constants, the calibration errors of the rig's sensors in their
    standard uncertainties, and the weights of the form's error. The size of the form's error is
    that which the measured curves leave, so that only further curves tell of these weights.

    Attributes:
        law: The fitted law.
        internal_constants: All its internal constants, shape (constants,).
        is_free: Whether the data decide each of them, shape (constants,).
        curves: The measured curves.
        error_variances: Variances of the errors of a curve, from the residuals of the fit.
        calibration_uncertainties: Standard uncertainty of each sensor's calibration, shape
            (sensors,).
        longest_curve_slips: Slide-roll ratios of the curve with the most points, ascending.
        form_error_at: Gives the relative standard error of the law's form that the measured curves
            leave. Its arguments are rows of the law's conditions, and the slip of each row.
        form_process: Error of the law's form over its standard deviation, which `form_error_at`
            gives.
    """

    law: Law
    internal_constants: FloatArray
    is_free: BoolArray
    curves: Curves
    error_variances: ErrorVariances
    calibration_uncertainties: FloatArray
    longest_curve_slips: FloatArray
    form_error_at: Callable[[FloatArray, FloatArray], FloatArray]
    form_process: FormErrorProcess = NO_FORM_ERROR_PROCESS

    def precision_of_curves(self, curves: Curves, form_error: FloatArray) -> FloatArray:
        """Precision that each of some curves would add, shape (curves, parameters, parameters).

        Args:
            curves: The curves.
            form_error: Relative standard error of the law's form at each point, shape (points,).
        """
        error_slopes = curve_error_slopes(self.law, self.internal_constants, curves)
        observations = curves.observations(self.law)
        mu = self.law.traction(self.internal_constants, observations)
        error_per_weight_of_curve = self.form_process.error_per_weight(
            self.form_coordinates(curves)
        )
        by_constants = self.law.jacobian(self.internal_constants, observations)[:, self.is_free]
        by_calibration = error_slopes[:, : len(SENSORS)] * self.calibration_uncertainties
        by_form = (mu * form_error)[:, np.newaxis] * error_per_weight_of_curve[
            curves.curve_of_point
        ]
        slopes = np.hstack([by_constants, by_calibration, by_form])
        return precision_by_curve(slopes, error_slopes, self.error_variances, curves.curve_of_point)

    @property
    def precision(self) -> FloatArray:
        """Precision of all parameters, shape (parameters, parameters).

        It is the sum of the measured curves and of the prior: calibration errors and weights of the
        form are standard normal, and nothing is known of the constants.
        """
        constant_count = int(self.is_free.sum())
        prior = np.ones(constant_count + len(SENSORS) + len(self.form_process.centres))
        prior[:constant_count] = 0.0
        no_form_error = np.zeros(len(self.curves.slip))
        measured_precision = self.precision_of_curves(self.curves, no_form_error)
        return np.asarray(np.diag(prior) + measured_precision.sum(axis=0))

    def without_calibration(
        self, precision: FloatArray, gradients: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Precision and gradients without the parameters of the sensors, as for exact sensors.

        Args:
            precision: Of all parameters, shape (..., parameters, parameters).
            gradients: By all parameters, shape (..., parameters).
        """
        constant_count = int(self.is_free.sum())
        sensor_indices = np.arange(constant_count, constant_count + len(SENSORS))
        precision = np.delete(precision, sensor_indices, axis=-2)
        precision = np.delete(precision, sensor_indices, axis=-1)
        return precision, np.delete(gradients, sensor_indices, axis=-1)

    def gradients(
        self, by_constants: FloatArray, by_form_error: FloatArray, coordinates: FloatArray
    ) -> FloatArray:
        """Gradients of quantities by all parameters, shape (quantities, parameters).

        Args:
            by_constants: Derivatives by the free constants, shape (quantities, free).
            by_form_error: Change of each quantity by an error of the law's form of one standard
                deviation, shape (quantities,).
            coordinates: Operating points whose mu a quantity depends on, as `form_coordinates`
                gives them, shape (quantities, operating points, 3).
        """
        mean_error_per_weight = self.form_process.error_per_weight(coordinates).mean(axis=1)
        by_form = by_form_error[:, np.newaxis] * mean_error_per_weight
        by_calibration = np.zeros((len(by_form_error), len(SENSORS)))
        return np.hstack([by_constants, by_calibration, by_form])

    def form_coordinates(self, curves: Curves) -> FloatArray:
        """Operating points of curves as coordinates of the form's error, shape (curves, 3)."""
        conditions = self.law.conditions
        speed = curves.conditions[:, conditions.index("entrainment_speed_m_s")]
        temperature = curves.conditions[:, conditions.index("inlet_temperature_c")]
        return form_coordinates(curves.load_n, speed, temperature)


def measured_information(
    fitted: FittedLaw,
    points: pd.DataFrame,
    oil: str,
    calibration: Calibration | None,
    law_error_beyond: float,
) -> Information:
    """Information of the measured curves of an oil about the constants of its law.

    Args:
        fitted: The law with its refits.
        points: Table of points; those of the oil are used.
        oil: Name of the oil.
        calibration: Calibration of the rig's sensors; without it they are assumed exact.
        law_error_beyond: Relative standard error of the law's form where the surface of measured mu
            has no interval.

    Raises:
        OilfilmError: The fit has no constants, no refits, or does not follow a condition; or the
            points do not determine its constants.
    """
    coefficients = fitted.coefficients
    if np.isnan(coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    if coefficients.fixed_conditions or not coefficients.group_has_exponent.all():
        reason = "; ".join(fixed.sentence() for fixed in coefficients.fixed_conditions)
        raise OilfilmError(
            f"{oil}: a plan needs a law that follows every condition ({reason or 'it does not'}). "
            "First test at two or more levels of each condition, varied one at a time."
        )
    if len(coefficients.refits) < 2:
        raise OilfilmError(
            f"{oil}: the uncertainty of the constants is not known, because too few curves were "
            "tested (fit.min_curves_for_errors of config/config.yaml). Test more conditions first."
        )
    law = fitted.law
    internal_constants = to_internal(law, coefficients.constants)
    internal_refits = to_internal(law, coefficients.refits)
    # constants that the law prescribes, or that ended at a bound, are the same in every refit
    is_free = np.ptp(internal_refits, axis=0) > 0
    points_of_oil = points[points["accepted"] & (points["oil"] == oil)]
    complete_points = points_of_oil.dropna(subset=[*law.conditions, "load_n"])
    curves = curve_data(complete_points, law.conditions)
    observations = curves.observations(law)
    jacobian = law.jacobian(internal_constants, observations)[:, is_free]
    if np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        raise OilfilmError(
            f"{oil}: the accepted points do not tell the law's constants apart. Test at two or "
            "more levels of each condition, or fit again if points and fit are of different runs."
        )
    residual = curves.mu - law.traction(internal_constants, observations)
    error_slopes = curve_error_slopes(law, internal_constants, curves)
    longest_curve_index = np.argmax(np.bincount(curves.curve_of_point))
    return Information(
        law=law,
        internal_constants=internal_constants,
        is_free=is_free,
        curves=curves,
        error_variances=error_variances(jacobian, error_slopes, residual, curves.curve_of_point),
        calibration_uncertainties=np.array(
            [getattr(calibration, key, 0.0) for key in _CALIBRATION_KEYS]
        ),
        longest_curve_slips=np.sort(curves.slip[curves.curve_of_point == longest_curve_index]),
        form_error_at=partial(fitted.form_error, error_without_interval=law_error_beyond),
    )


# ---------------------------------------------------------------- the next curves


def covariance(precision: FloatArray) -> FloatArray:
    """The inverse of precisions, shape (..., n, n); the parameters may differ much in size."""
    parameter_sizes = np.sqrt(np.diagonal(precision, axis1=-2, axis2=-1))
    scale = parameter_sizes[..., :, np.newaxis] * parameter_sizes[..., np.newaxis, :]
    return np.asarray(np.linalg.inv(precision / scale) / scale)


def uncertainties(precision: FloatArray, gradients: FloatArray) -> FloatArray:
    """Standard uncertainty of each quantity, shape (..., quantities).

    Args:
        precision: Of the parameters, shape (..., n, n).
        gradients: Of the quantities by the parameters, shape (quantities, n).
    """
    variance = (gradients @ covariance(precision) * gradients).sum(axis=-1)
    return np.sqrt(np.maximum(variance, 0.0))


def rms_uncertainty(precision: FloatArray, gradients: FloatArray) -> FloatArray:
    """Root mean square of `uncertainties` over the quantities, shape (...,)."""
    return np.asarray(np.sqrt(np.square(uncertainties(precision, gradients)).mean(axis=-1)))


@dataclass(frozen=True)
class CurvePlan:
    """Curves to measure next, chosen one after the other.

    Attributes:
        chosen_indices: Indices of the chosen candidates, in the order of the plan.
        uncertainty_before: Uncertainty with the measured curves alone, as `rms_uncertainty` gives
            it.
        uncertainty_with_one: Uncertainty with one candidate added, shape (candidates,).
        uncertainty_after: Uncertainty after each chosen curve, shape (chosen,).
        final_precision: Precision of the measured and the chosen curves, shape (n, n).
    """

    chosen_indices: list[int]
    uncertainty_before: float
    uncertainty_with_one: FloatArray
    uncertainty_after: FloatArray
    final_precision: FloatArray


def choose_curves(
    measured_precision: FloatArray,
    candidate_precisions: FloatArray,
    gradients: FloatArray,
    curve_count: int,
    smallest_gain: float = 0.0,
) -> CurvePlan:
    """Choose curves one after the other, each time the best one beside those already chosen.

    Args:
        measured_precision: Precision of the parameters by the measured curves, shape (n, n).
        candidate_precisions: Precision that each candidate curve would add, shape
            (candidates, n, n); each is chosen once at most.
        gradients: Derivatives of the wanted quantities by the parameters, shape (quantities, n).
        curve_count: Number of curves to choose; fewer where there are fewer candidates.
        smallest_gain: Relative fall of the uncertainty below which a curve is not worth measuring.

    Examples:
        A straight line through 4 points with mean 0 is wanted at x = 0.5. Every new point at x
        gives the variance 1/5 at the mean of all five, so the best one is x = 5 * 0.5
        (the mean moves to where the line is wanted):

        >>> x = np.linspace(-3, 3, 61)
        >>> rows = np.stack([np.ones_like(x), x], axis=-1)[:, np.newaxis]
        >>> new_precisions = np.swapaxes(rows, 1, 2) @ rows
        >>> plan = choose_curves(np.diag([4.0, 10.0]), new_precisions, np.array([[1.0, 0.5]]), 1)
        >>> print(f"{x[plan.chosen_indices[0]]:.1f} {plan.uncertainty_after[0] ** 2:.3f}")
        2.5 0.200
    """
    uncertainty_with_one = rms_uncertainty(measured_precision + candidate_precisions, gradients)
    uncertainty_before = float(rms_uncertainty(measured_precision, gradients))
    is_available = np.ones(len(uncertainty_with_one), dtype=bool)
    chosen_indices: list[int] = []
    uncertainty_after: list[float] = []
    current_uncertainty = uncertainty_before
    total_precision = measured_precision
    for _ in range(min(curve_count, len(uncertainty_with_one))):
        uncertainty_with_candidate = rms_uncertainty(
            total_precision + candidate_precisions, gradients
        )
        uncertainty_with_candidate = np.where(is_available, uncertainty_with_candidate, np.inf)
        best_index = int(first_smallest(uncertainty_with_candidate))
        if exceeds(
            uncertainty_with_candidate[best_index], (1 - smallest_gain) * current_uncertainty
        ):
            break
        current_uncertainty = float(uncertainty_with_candidate[best_index])
        chosen_indices.append(best_index)
        uncertainty_after.append(current_uncertainty)
        is_available[best_index] = False
        total_precision = total_precision + candidate_precisions[best_index]
    return CurvePlan(
        chosen_indices,
        uncertainty_before,
        uncertainty_with_one,
        np.array(uncertainty_after),
        total_precision,
    )
