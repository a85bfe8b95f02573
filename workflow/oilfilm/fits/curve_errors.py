"""What errors the points of one curve share, and how large they are, from the curves measured.

All points of a run have the same error of load, speed, temperature and zero of the force. A new
curve of 31 points is therefore no 31 independent pieces of information.

Decides: which errors the points of a run share, and how large they are.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from oilfilm.fits.problem import Curves
from oilfilm.fits.uncertainty import SENSORS
from oilfilm.traction.law import Law
from oilfilm.units import FloatArray, IndexArray

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
    mu = law.traction(internal, curves.at(law))

    def slope(**factors: float) -> FloatArray:
        """Of mu by the logarithm of some conditions together."""
        ends = []
        for sign in (1, -1):
            factor = [np.exp(sign * _STEP * factors.get(name, 0.0)) for name in law.conditions]
            moved = replace(curves, conditions=curves.conditions * factor)
            ends.append(law.traction(internal, moved.at(law)))
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
    best = scipy.optimize.minimize(deviance, start, method="L-BFGS-B", bounds=bounds)
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
