"""A laboratory that runs tests and repeats them as often as wished: a planted law, planted errors.

The truth is the law of oil 4102 as printed. A run's errors enter as on a rig: the controller holds
what the sensors read at the set point, so that load, speed and temperature themselves are off.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from campaigns import LABORATORY, printed, rig_contact
from fit_points import LAW, accepted_points, problem_of
from oilfilm.base.units import FloatArray
from oilfilm.fits.measured_curves import curve_error_slopes, point_indices_by_curve
from oilfilm.fits.problem import Curves
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import OilInBearing, oils_in_bearings
from oilfilm.traction.law import CONDITIONS, to_constants, to_internal
from planted_fits import printed_fits

OIL = "4102"
CONTACT = rig_contact()
_ALL_OILS = resolve(LABORATORY, {}).plain_values()
SETTINGS = Settings.from_plain_values({**_ALL_OILS, "oils": {OIL: _ALL_OILS["oils"][OIL]}})
# In the internal form of the law.
TRUE_CONSTANTS = to_internal(LAW, np.array(printed()[OIL]))
SLIP = np.linspace(0, 0.3, 31)
# A rig without errors of load, force, speed and temperature.
NO_RIG = np.zeros(4)
# A small matrix in a corner of the rig's range: twelve runs that leave exponents poorly known.
SMALL_PLAN = [(p, u, t) for p in (1.0, 1.5) for u in (25.0, 30.0) for t in (25.0, 60.0, 100.0)]
# Axial load N, inner speed rpm, oil temperature degC.
DUTY = np.array([[10000.0, 9000.0, 100.0], [10000.0, 12000.0, 100.0], [20000.0, 12000.0, 120.0]])


@dataclass(frozen=True)
class Errors:
    """Standard deviations of the errors of a run, and of mu at each point.

    Attributes:
        load: Of the load, relative.
        force: Of the traction force, relative.
        speed: Of the entrainment speed, relative.
        temperature_c: Of the temperature.
        zero_n: Of the zero of the force.
        point: Of mu at each point.
    """

    load: float = 0.005
    force: float = 0.002
    speed: float = 0.002
    temperature_c: float = 0.5
    zero_n: float = 0.01
    point: float = 5e-5

    @property
    def of_curve(self) -> FloatArray:
        """The five errors that all points of a curve share."""
        return np.array([self.load, self.force, self.speed, self.temperature_c, self.zero_n])


def curves_at(conditions: list[tuple[float, float, float]]) -> Curves:
    """One curve at each condition, at all slips of `SLIP`."""
    levels = np.array(conditions)
    number = len(conditions)
    curve = np.repeat(np.arange(number), len(SLIP))
    return Curves(levels, CONTACT.load_n(levels[:, 0]), curve, np.tile(SLIP, number))


def run_tests(
    conditions: list[tuple[float, float, float]],
    random: np.random.Generator,
    of_run: Errors,
    of_rig: FloatArray | None = None,
) -> pd.DataFrame:
    """A table of points, with simulated errors.

    Args:
        conditions: P in GPa, U in m/s and T in degC of each run.
        random: Source of chance.
        of_run: Standard deviations of the errors of each run.
        of_rig: Errors of load, force, speed and temperature that all runs share.
    """
    curves = curves_at(conditions)
    errors_of_runs = of_run.of_curve * random.standard_normal((len(conditions), 5))
    errors_of_runs[:, :4] += 0.0 if of_rig is None else of_rig
    load, force, speed, temperature, zero = errors_of_runs[curves.curve_of_point].T
    p, u, t = curves.conditions[curves.curve_of_point].T
    true_conditions = np.column_stack([p / np.cbrt(1 + load), u / (1 + speed), t - temperature])
    point = np.arange(len(p))
    mu = LAW.traction(
        TRUE_CONSTANTS, Curves(true_conditions, curves.load_n, point, curves.slip).observations(LAW)
    )
    read = mu / (1 + load) * (1 + force) + zero / curves.load_n[curves.curve_of_point]
    frame = pd.DataFrame(conditions, columns=list(CONDITIONS)).assign(load_n=curves.load_n)
    return accepted_points(OIL, frame, SLIP, read, of_run.point, random)


def refit(
    points: pd.DataFrame, of_run: Errors | None = None, of_rig: FloatArray = NO_RIG
) -> FloatArray:
    """Internal constants by generalised least squares, started from the true constants.

    The four errors of the rig are fitted too. Their standard uncertainties hold them near 0.

    Args:
        points: Table of points.
        of_run: Standard deviations of the errors of each run; those of `Errors` by default.
        of_rig: Standard uncertainties of load, force, speed and temperature of the rig.
    """
    data = problem_of(points).data
    load_n = CONTACT.load_n(data.conditions[:, 0])
    curves = Curves(data.conditions, load_n, data.curve_of_point, data.slip)
    of_run = of_run or Errors()
    error_slopes = curve_error_slopes(LAW, TRUE_CONSTANTS, curves)
    # inverse root of the covariance of each curve
    whitening_matrices = []
    for indices in point_indices_by_curve(data.curve_of_point):
        effects = error_slopes[indices] * of_run.of_curve
        covariance = effects @ effects.T + of_run.point**2 * np.eye(len(indices))
        whitening_matrices.append(np.linalg.inv(np.linalg.cholesky(covariance)))
    observations = curves.observations(LAW)
    sensor_slopes = error_slopes[:, :4] * of_rig
    curve_ends = np.cumsum([len(matrix) for matrix in whitening_matrices])[:-1]

    def whitened(values: FloatArray) -> list[FloatArray]:
        parts = np.split(values, curve_ends)
        return [matrix @ part for matrix, part in zip(whitening_matrices, parts, strict=True)]

    def residual(unknowns: FloatArray) -> FloatArray:
        internal, sensor_errors = np.split(unknowns, [len(TRUE_CONSTANTS)])
        mu_residual = data.mu - LAW.traction(internal, observations)
        mu_residual = mu_residual - sensor_slopes @ sensor_errors
        return np.concatenate([*whitened(mu_residual), sensor_errors])

    def slopes(unknowns: FloatArray) -> FloatArray:
        law_slopes = LAW.jacobian(unknowns[: len(TRUE_CONSTANTS)], observations)
        slopes_of_sensors = np.eye(4, len(start), len(TRUE_CONSTANTS))
        return np.vstack([*whitened(-np.hstack([law_slopes, sensor_slopes])), slopes_of_sensors])

    start = np.concatenate([TRUE_CONSTANTS, np.zeros(4)])
    solution = least_squares(residual, start, slopes, method="lm", x_scale="jac").x
    return solution[: len(TRUE_CONSTANTS)]


def oil_in_bearing() -> OilInBearing:
    """The oil with its printed law, as bearings take it."""
    (oil,) = oils_in_bearings(*printed_fits(), SETTINGS)
    return oil


def torques(internal: FloatArray, duty: FloatArray = DUTY) -> FloatArray:
    """Torque at each duty point for rows of internal constants, shape (rows, points)."""
    constants = np.repeat(to_constants(LAW, internal), len(duty), axis=0)
    terms = (
        oil_in_bearing()
        .with_constants(constants)
        .calculate(SETTINGS.tested_bearing(), *np.tile(duty.T, len(internal)))
    )
    return terms["torque_n_m"].to_numpy().reshape(len(internal), -1)
