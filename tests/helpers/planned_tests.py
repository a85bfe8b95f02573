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
DEMO = resolve(LABORATORY, {}).plain_values()
SETTINGS = Settings.from_plain_values({**DEMO, "oils": {OIL: DEMO["oils"][OIL]}})
TRUE_CONSTANTS = to_internal(LAW, np.array(printed()[OIL]))
SLIP = np.linspace(0, 0.3, 31)
NO_RIG = np.zeros(4)
# A small matrix in a corner of the rig's range: twelve runs that leave exponents poorly known.
SMALL_PLAN = [(p, u, t) for p in (1.0, 1.5) for u in (25.0, 30.0) for t in (25.0, 60.0, 100.0)]
# Axial load N, inner speed rpm, oil temperature degC.
DUTY = np.array([[10000.0, 9000.0, 100.0], [10000.0, 12000.0, 100.0], [20000.0, 12000.0, 120.0]])


@dataclass(frozen=True)
class Errors:
    """Standard deviations: relative of load, force and speed, K, N; of mu at each point."""

    load: float = 0.005
    force: float = 0.002
    speed: float = 0.002
    temperature_c: float = 0.5
    zero_n: float = 0.01
    point: float = 5e-5

    @property
    def of_curve(self) -> FloatArray:
        return np.array([self.load, self.force, self.speed, self.temperature_c, self.zero_n])


def curves_at(conditions: list[tuple[float, float, float]]) -> Curves:
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
    """A table of points; `of_rig` are errors of the four sensors that all runs share."""
    curves = curves_at(conditions)
    drawn = of_run.of_curve * random.standard_normal((len(conditions), 5))
    drawn[:, :4] += 0.0 if of_rig is None else of_rig
    load, force, speed, temperature, zero = drawn[curves.curve_of_point].T
    p, u, t = curves.conditions[curves.curve_of_point].T
    true = np.column_stack([p / np.cbrt(1 + load), u / (1 + speed), t - temperature])
    point = np.arange(len(p))
    mu = LAW.traction(
        TRUE_CONSTANTS, Curves(true, curves.load_n, point, curves.slip).observations(LAW)
    )
    read = mu / (1 + load) * (1 + force) + zero / curves.load_n[curves.curve_of_point]
    frame = pd.DataFrame(conditions, columns=list(CONDITIONS)).assign(load_n=curves.load_n)
    return accepted_points(OIL, frame, SLIP, read, of_run.point, random)


def refit(
    points: pd.DataFrame, of_run: Errors | None = None, of_rig: FloatArray = NO_RIG
) -> FloatArray:
    """Internal constants by generalised least squares, from the truth on: the valley is known here.

    The rig's four errors are fitted too, held by their standard uncertainties.
    """
    data = problem_of(points).data
    load = CONTACT.load_n(data.conditions[:, 0])
    curves = Curves(data.conditions, load, data.curve_of_point, data.slip)
    of_run = of_run or Errors()
    effect = curve_error_slopes(LAW, TRUE_CONSTANTS, curves)
    roots = []
    for part in point_indices_by_curve(data.curve_of_point):
        d = effect[part] * of_run.of_curve
        of_points = d @ d.T + of_run.point**2 * np.eye(len(part))
        roots.append(np.linalg.inv(np.linalg.cholesky(of_points)))
    at, of_sensors = curves.observations(LAW), effect[:, :4] * of_rig
    ends = np.cumsum([len(root) for root in roots])[:-1]

    def whitened(left: FloatArray) -> list[FloatArray]:
        return [root @ part for root, part in zip(roots, np.split(left, ends), strict=True)]

    def residual(unknown: FloatArray) -> FloatArray:
        internal, sensors = np.split(unknown, [len(TRUE_CONSTANTS)])
        left = data.mu - LAW.traction(internal, at) - of_sensors @ sensors
        return np.concatenate([*whitened(left), sensors])

    def slopes(unknown: FloatArray) -> FloatArray:
        of_law = LAW.jacobian(unknown[: len(TRUE_CONSTANTS)], at)
        return np.vstack([*whitened(-np.hstack([of_law, of_sensors])), np.eye(4, len(start), 12)])

    start = np.concatenate([TRUE_CONSTANTS, np.zeros(4)])
    return least_squares(residual, start, slopes, method="lm", x_scale="jac").x[
        : len(TRUE_CONSTANTS)
    ]


def oil_in_bearing() -> OilInBearing:
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
