"""What the measured curves of an oil tell about its law, and which curve to measure next.

What a curve adds to the precision of the constants is known before it is measured: its slopes and
the expected errors of its points. Precisions add, so that no measurement can make anything less
certain. Choosing the curves that make the variance of a wanted quantity least is c-optimality, the
mean over several quantities is A-optimality (linear or L-optimality): A. C. Atkinson, A. N. Donev,
R. D. Tobias, Optimum Experimental Designs, with SAS (2007), chapters 10 and 17. The law is not
linear in its constants, so the design is optimal at the constants known so far (locally optimal),
and a plan of several curves is made one after the other.

All points of a run share the errors of load, speed, temperature and zero of the force: a new curve
of 31 points is no 31 independent pieces of information.

Decides: which errors the points of a run share, and how large they are; how much a further curve
would tell.
"""

from dataclasses import dataclass, replace

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

# What may be wrong in a whole curve: relative errors of load, force and speed, degrees of the
# temperature, newtons of the zero.
EFFECTS = (*SENSORS, "zero of the force")
# Of these each run has its own. An error of force or speed changes mu nearly as one of the load
# does: their sizes could not be told apart.
_OF_A_RUN = [EFFECTS.index(name) for name in ("load", "inlet temperature", "zero of the force")]
# Range of the logarithm of a variance, over the variance of the residuals.
_VARIANCES = (-14.0, 4.0)
_STEP = 1e-4
# Error of mu below which a point counts as exact.
_EXACT = 1e-9


def effects(law: Law, internal: FloatArray, curves: Curves) -> FloatArray:
    """Change of (measured mu - law at the measured conditions) per unit of each of `EFFECTS`.

    A load sensor that reads (1 + e) W makes mu = F/W smaller and, as the pressure goes with the
    cube root of the load, places the point at a higher pressure.

    Returns:
        Shape (points, effects).
    """
    mu = law.traction(internal, curves.observations(law))

    def slope(**factors: float) -> FloatArray:
        """Of mu by the logarithm of some conditions together."""
        ends = []
        for sign in (1, -1):
            factor = [np.exp(sign * _STEP * factors.get(name, 0.0)) for name in law.conditions]
            moved = replace(curves, conditions=curves.conditions * factor)
            ends.append(law.traction(internal, moved.observations(law)))
        return np.asarray((ends[0] - ends[1]) / (2 * _STEP))

    temperature = curves.conditions[:, law.conditions.index("inlet_temperature_c")][curves.curve]
    by_load = slope(load_n=1.0, max_hertz_pressure_gpa=1 / 3)
    by_speed, by_temperature = slope(entrainment_speed_m_s=1.0), slope(inlet_temperature_c=1.0)
    zero = 1 / curves.load_n[curves.curve]
    return np.column_stack([-mu - by_load, mu, -by_speed, -by_temperature / temperature, zero])


@dataclass(frozen=True)
class ErrorSizes:
    """Variances of what is wrong in a curve.

    Attributes:
        of_curve: Of each of `EFFECTS`, in its unit squared; a draw per curve.
        of_point: Of mu, a draw per point.
    """

    of_curve: FloatArray
    of_point: float


def error_sizes(
    jacobian: FloatArray, effect: FloatArray, residual: FloatArray, curve: IndexArray
) -> ErrorSizes:
    """Sizes of the errors that make the residuals most likely, the fit's own freedom allowed for.

    Residuals of curve i are taken as J_i x + D_i b_i + e: b_i the errors of the run, normal with
    the variances v, e independent, normal with variance s^2. Restricted maximum likelihood gives v
    and s^2: least of

        sum ln|V_i| + ln|sum J_i^T V_i^-1 J_i| + r^T P r,  V_i = s^2 I + D_i diag(v) D_i^T,

    P = V^-1 - V^-1 J (J^T V^-1 J)^-1 J^T V^-1. What the law's form misses is counted as an error
    of the curve or of its points.

    Reference: H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545.

    Args:
        jacobian: Slopes of mu by the free constants, shape (points, n).
        effect: As `effects`, shape (points, effects).
        residual: Of each point.
        curve: Curve of each point, rising from 0.
    """
    if not residual.any():
        return ErrorSizes(np.zeros(len(EFFECTS)), 0.0)
    columns = np.column_stack([effect[:, _OF_A_RUN], jacobian, residual])
    size = np.sqrt(np.mean(columns**2, axis=0))
    columns = columns / size
    # products of the columns of each curve are all that the likelihood needs
    parts = points_of_curves(curve)
    products = np.stack([columns[part].T @ columns[part] for part in parts])
    points = np.array([len(part) for part in parts])

    def deviance(logarithms: FloatArray) -> float:
        return _deviance(np.exp(logarithms), products, points)

    start, bounds = np.log([0.3] * (len(_OF_A_RUN) + 1)), scipy.optimize.Bounds(*_VARIANCES)
    # by default it ends 1e-4 from the optimum, where rounding decides
    best = scipy.optimize.minimize(
        deviance, start, method="L-BFGS-B", jac="3-point", bounds=bounds, options={"ftol": 1e-12}
    )
    variances = np.exp(best.x) * size[-1] ** 2
    of_curve = np.zeros(len(EFFECTS))
    of_curve[_OF_A_RUN] = variances[:-1] / size[: len(_OF_A_RUN)] ** 2
    return ErrorSizes(of_curve, float(variances[-1]))


def _deviance(variances: FloatArray, products: FloatArray, points: IndexArray) -> float:
    """-2 ln of the restricted likelihood, but for a constant.

    Args:
        variances: Of the errors of a run, then of a point.
        products: Products of the columns D, J, r of each curve.
        points: Number of points of each curve.
    """
    *of_run, of_point = variances
    count = len(of_run)
    inner = products[:, :count, :count] + np.diag(of_point / np.array(of_run))
    across = products[:, :count, count:]
    # V^-1 = (I - D inner^-1 D^T)/s^2
    rest = products[:, count:, count:] - np.swapaxes(across, 1, 2) @ np.linalg.solve(inner, across)
    total = rest.sum(axis=0) / of_point
    jacobian, cross = total[:-1, :-1], total[:-1, -1]
    logarithms = (
        np.sum((points - count) * np.log(of_point))
        + len(points) * np.sum(np.log(of_run))
        + np.linalg.slogdet(inner)[1].sum()
        + np.linalg.slogdet(jacobian)[1]
    )
    return float(logarithms + total[-1, -1] - cross @ np.linalg.solve(jacobian, cross))


def points_of_curves(curve: IndexArray) -> list[IndexArray]:
    """Indices of the points of each curve."""
    return np.split(np.arange(len(curve)), np.flatnonzero(np.diff(curve)) + 1)


def precision(
    rows: FloatArray, effect: FloatArray, sizes: ErrorSizes, curve: IndexArray
) -> FloatArray:
    """What each curve tells about parameters: A^T V^-1 A, V = s^2 I + D diag(v) D^T.

    Args:
        rows: A, slopes of mu by the parameters, shape (points, n).
        effect: D, as `effects`, shape (points, effects).
        sizes: v and s^2, as `error_sizes`.
        curve: Curve of each point, rising from 0.

    Returns:
        Shape (curves, n, n).
    """
    of_run = np.flatnonzero(sizes.of_curve > 0)
    # without any error a point would be worth any number of others
    of_point = max(sizes.of_point, _EXACT**2)
    inner = np.diag(of_point / sizes.of_curve[of_run])
    each = []
    for part in points_of_curves(curve):
        a, d = rows[part], effect[part][:, of_run]
        across = d.T @ a
        each.append(a.T @ a - across.T @ np.linalg.solve(inner + d.T @ d, across))
    return np.stack(each) / of_point


# Standard uncertainties of a rig's calibration, in the order of `SENSORS`.
_CALIBRATION = ("load_relative", "traction_force_relative", "speed_relative", "temperature_c")
# Centres of the form's error, and their least distance in lengths: nearer ones tell nothing new.
_CENTRES, _APART = 30, 0.3


@dataclass(frozen=True)
class FormError:
    """Relative error of the law's form over the conditions, as a Gaussian process.

    Its correlation falls with the distance as exp(-d^2/2), d in lengths of `length`. It is written
    by a few weights, those of processes at `centres`, so that precisions of curves add.

    Reference: M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425 (discrepancy of a model);
        J. Quinonero-Candela, C. E. Rasmussen, J. Mach. Learn. Res. 6 (2005) 1939 (few centres).

    Attributes:
        size: Standard deviation.
        length: Of each of ln W/3, ln U and T, shape (3,).
        centres: Where the process is written, shape (centres, 3).
    """

    size: float
    length: FloatArray
    centres: FloatArray

    @classmethod
    def near(cls, size: float, length: FloatArray, places: FloatArray) -> "FormError":
        """The process with centres spread over some places, the first of which come first."""
        chosen = [0]
        while len(chosen) < min(_CENTRES, len(places)):
            away = ((places[:, np.newaxis] - places[chosen]) / length) ** 2
            nearest = away.sum(axis=-1).min(axis=1)
            if exceeds(_APART**2, nearest.max()):
                break
            chosen.append(int(first_largest(nearest)))
        return cls(size, length, places[chosen])

    def weights(self, places: FloatArray) -> FloatArray:
        """Error at places, shape (..., 3), by the standard normal weights: (..., centres)."""
        matrix = self._correlation(self.centres) + 1e-9 * np.eye(len(self.centres))
        root = np.linalg.cholesky(matrix)
        flat = self._correlation(places.reshape(-1, places.shape[-1]))
        solved = self.size * np.linalg.solve(root, flat.T).T
        return solved.reshape(*places.shape[:-1], len(self.centres))

    def _correlation(self, places: FloatArray) -> FloatArray:
        away = (places[:, np.newaxis] - self.centres) / self.length
        return np.asarray(np.exp(-0.5 * (away**2).sum(axis=-1)))


NO_FORM_ERROR = FormError(0.0, np.ones(3), np.empty((0, 3)))


def place(load_n: FloatArray, speed_m_s: FloatArray, temperature_c: FloatArray) -> FloatArray:
    """Conditions as coordinates of the form's error: ln W/3, which is ln p on one rig, ln U, T."""
    return np.stack([np.log(load_n) / 3, np.log(speed_m_s), temperature_c], axis=-1)


@dataclass(frozen=True)
class Known:
    """What the measured curves tell about the constants that are not fixed.

    Beside these constants the parameters are the calibration errors of the rig's sensors, in their
    standard uncertainties, and the weights of the form's error.

    Attributes:
        law: The fitted law.
        internal: All its internal constants.
        free: Which of them the data decide.
        curves: The measured curves.
        sizes: Variances of what is wrong in a curve, from the residuals of the fit.
        calibration: Standard uncertainty of each sensor's calibration.
        slip: Slide-roll ratios of the curve with the most points.
        form: How far the law's form may be wrong.
    """

    law: Law
    internal: FloatArray
    free: BoolArray
    curves: Curves
    sizes: ErrorSizes
    calibration: FloatArray
    slip: FloatArray
    form: FormError = NO_FORM_ERROR

    def of_curves(self, curves: Curves) -> FloatArray:
        """Precision that each of some curves would add, shape (curves, parameters, parameters)."""
        effect = effects(self.law, self.internal, curves)
        at = curves.observations(self.law)
        mu = self.law.traction(self.internal, at)
        of_form = mu[:, np.newaxis] * self.form.weights(self.places(curves))[curves.curve]
        rows = [
            self.law.jacobian(self.internal, at)[:, self.free],
            effect[:, : len(SENSORS)] * self.calibration,
            of_form,
        ]
        return precision(np.hstack(rows), effect, self.sizes, curves.curve)

    @property
    def precision(self) -> FloatArray:
        """Of all parameters by the measured curves and by what calibration and form are known."""
        before = np.ones(self.free.sum() + len(SENSORS) + len(self.form.centres))
        before[: self.free.sum()] = 0.0
        return np.asarray(np.diag(before) + self.of_curves(self.curves).sum(axis=0))

    def without_calibration(
        self, precision: FloatArray, gradients: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """A precision and gradients where the sensors are exact: without their parameters."""
        count = int(self.free.sum())
        sensors = np.arange(count, count + len(SENSORS))
        rows = np.delete(precision, sensors, axis=-2)
        return np.delete(rows, sensors, axis=-1), np.delete(gradients, sensors, axis=-1)

    def gradients(
        self, by_constants: FloatArray, lever: FloatArray, places: FloatArray
    ) -> FloatArray:
        """Gradients of quantities by all parameters.

        Args:
            by_constants: By the free constants, shape (quantities, free).
            lever: Change of each quantity per relative change of mu.
            places: Conditions at which mu counts, shape (quantities, places, 3).
        """
        of_form = lever[:, np.newaxis] * self.form.weights(places).mean(axis=1)
        none = np.zeros((len(lever), len(SENSORS)))
        return np.hstack([by_constants, none, of_form])

    def places(self, curves: Curves) -> FloatArray:
        """Conditions of curves as coordinates of the form's error."""
        levels = dict(zip(self.law.conditions, curves.conditions.T, strict=True))
        return place(curves.load_n, levels["entrainment_speed_m_s"], levels["inlet_temperature_c"])


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
    of_oil = points[points["accepted"] & (points["oil"] == oil)]
    known = of_oil.dropna(subset=[*law.conditions, "load_n"])
    curves = curve_data(known, law.conditions)
    jacobian = law.jacobian(internal, curves.observations(law))[:, free]
    if np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        raise OilfilmError(
            f"{oil}: the accepted points do not tell the law's constants apart. Test at two or "
            "more levels of each condition, or fit again if points and fit are of different runs."
        )
    residual = curves.mu - law.traction(internal, curves.observations(law))
    effect = effects(law, internal, curves)
    sizes = error_sizes(jacobian, effect, residual, curves.curve)
    sensors = np.array([getattr(calibration, name, 0.0) for name in _CALIBRATION])
    longest = np.argmax(np.bincount(curves.curve))
    slip = np.sort(curves.slip[curves.curve == longest])
    return Known(law, internal, free, curves, sizes, sensors, slip)


# ---------------------------------------------------------------- the next curves


def covariance(precision: FloatArray) -> FloatArray:
    """The inverse of precisions, shape (..., n, n), whose parameters may differ much in size."""
    size = np.sqrt(np.diagonal(precision, axis1=-2, axis2=-1))
    scale = size[..., :, np.newaxis] * size[..., np.newaxis, :]
    return np.asarray(np.linalg.inv(precision / scale) / scale)


def uncertainties(precision: FloatArray, gradients: FloatArray) -> FloatArray:
    """Standard uncertainty of each quantity, shape (..., quantities).

    Args:
        precision: Of the parameters, shape (..., n, n).
        gradients: Of the quantities by the parameters, shape (quantities, n).
    """
    variance = (gradients @ covariance(precision) * gradients).sum(axis=-1)
    return np.sqrt(np.maximum(variance, 0.0))


def uncertainty(precision: FloatArray, gradients: FloatArray) -> FloatArray:
    """Root mean square of `uncertainties`, shape (...,)."""
    return np.asarray(np.sqrt(np.square(uncertainties(precision, gradients)).mean(axis=-1)))


@dataclass(frozen=True)
class Design:
    """Curves chosen one after the other.

    Attributes:
        chosen: Candidates in the order of the plan.
        before: Uncertainty with the curves that there are.
        alone: Uncertainty with one candidate added, shape (candidates,).
        after: Uncertainty after each chosen curve, shape (chosen,).
        end: Precision of all curves.
    """

    chosen: list[int]
    before: float
    alone: FloatArray
    after: FloatArray
    end: FloatArray


def choose(
    known: FloatArray,
    candidates: FloatArray,
    gradients: FloatArray,
    count: int,
    smallest_gain: float = 0.0,
) -> Design:
    """Choose curves one after the other, each the best given those before.

    Args:
        known: Precision of the parameters by the curves that there are, shape (n, n).
        candidates: What each curve that could be measured adds, shape (candidates, n, n); each is
            chosen once at most.
        gradients: Of the wanted quantities by the parameters, shape (quantities, n).
        count: Number of curves; fewer where there are fewer candidates.
        smallest_gain: Relative fall of the uncertainty below which a curve is not worth measuring.

    Examples:
        A straight line through 4 points with mean 0 is wanted at x = 0.5. Every new point at x
        gives the variance 1/5 at the mean of all five, so the best one is x = 5 * 0.5
        (the mean moves to where the line is wanted):

        >>> x = np.linspace(-3, 3, 61)
        >>> rows = np.stack([np.ones_like(x), x], axis=-1)[:, np.newaxis]
        >>> new = np.swapaxes(rows, 1, 2) @ rows
        >>> best = choose(np.diag([4.0, 10.0]), new, np.array([[1.0, 0.5]]), 1)
        >>> print(f"{x[best.chosen[0]]:.1f} {best.after[0] ** 2:.3f}")
        2.5 0.200
    """
    alone = uncertainty(known + candidates, gradients)
    before = float(uncertainty(known, gradients))
    left = np.ones(len(alone), dtype=bool)
    chosen: list[int] = []
    after = [before]
    state = known
    for _ in range(min(count, len(alone))):
        new = np.where(left, uncertainty(state + candidates, gradients), np.inf)
        best = int(first_smallest(new))
        if exceeds(new[best], (1 - smallest_gain) * after[-1]):
            break
        chosen.append(best)
        after.append(float(new[best]))
        left[best] = False
        state = state + candidates[best]
    return Design(chosen, before, alone, np.array(after[1:]), state)
