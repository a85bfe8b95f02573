"""Simulated campaigns as arrays of points: truths, plans of tests, errors of runs."""

import itertools
from dataclasses import dataclass

import numpy as np
import scipy.optimize

from lawless_truths import DENG_CONSTANTS, LawlessTruth
from oilfilm.base.units import FloatArray
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import Measurements
from oilfilm.traction import PAPER_LAW

PRESSURES, SPEEDS = (1.0, 1.25, 1.5), (25.0, 30.0, 35.0, 40.0)
TEMPERATURES = (25.0, 50.0, 70.0, 85.0, 100.0, 120.0)
SLIPS = np.geomspace(0.0015, 0.3, 15)


@dataclass(frozen=True)
class PlantedErrors:
    """Standard deviations of the errors of runs and points.

    Attributes:
        gain: Of the force, relative, one per run.
        zero: Of the zero, as a traction coefficient, one per run.
        slip_scale: Of the slip, relative, one per run.
        temperature_k: Of the temperature, one per run.
        noise: Of each point, relative.
        kind: `norm`: normal; `logn`: gains are log-normal and skew; `heavy`: noise of Student's t
            with 3 degrees of freedom; `het`: noise grows at low traction; `slip0`: slips have an
            offset.
        rig_gain: Of the force, relative, one per rig; runs take turns on three rigs.
    """

    gain: float = 0.008
    zero: float = 4e-5
    slip_scale: float = 0.004
    temperature_k: float = 0.5
    noise: float = 0.003
    kind: str = "norm"
    rig_gain: float = 0.0


def grid(*levels: tuple[float, ...]) -> FloatArray:
    """All combinations of levels, shape (conditions, 3)."""
    return np.array(list(itertools.product(*levels)))


def ends(values: tuple[float, ...]) -> tuple[float, float]:
    """The first and the last level."""
    return values[0], values[-1]


def latin() -> FloatArray:
    """24 conditions of a Latin design: two of six temperatures per pair of pressure and speed."""
    rows = []
    for (i, pressure), (j, speed) in itertools.product(enumerate(PRESSURES), enumerate(SPEEDS)):
        for half in (0, 3):
            rows.append((pressure, speed, TEMPERATURES[(i + j + half) % 6]))
    return np.array(rows)


def without_corners() -> FloatArray:
    """27 conditions less the eight corners of the box."""
    conditions = grid(PRESSURES, (25.0, 32.0, 40.0), (25.0, 72.0, 120.0))
    centred = conditions - (1.25, 32.0, 72.0)
    return conditions[np.any(np.abs(centred) < 0.01, axis=1)]


def random_conditions(count: int, random: np.random.Generator) -> FloatArray:
    """Conditions anywhere in the box."""
    lowest = np.array([PRESSURES[0], SPEEDS[0], TEMPERATURES[0]])
    highest = np.array([PRESSURES[-1], SPEEDS[-1], TEMPERATURES[-1]])
    return lowest + random.random((count, 3)) * (highest - lowest)


def simulated(
    truth: LawlessTruth,
    conditions: FloatArray,
    random: np.random.Generator,
    errors: PlantedErrors | None = None,
    slips: FloatArray = SLIPS,
    rig_gains: FloatArray | None = None,
) -> Measurements:
    """Measured points, one curve per row of conditions.

    Args:
        truth: mu of the oil.
        conditions: P in GPa, U in m/s and T in degC, shape (curves, 3).
        random: Draws the errors.
        errors: Their sizes.
        slips: Slips of every curve.
        rig_gains: Gains of the three rigs, shape (3,); drawn if they are not given.
    """
    errors = errors or PlantedErrors()
    curves = len(conditions)
    gain = errors.gain * random.standard_normal(curves)
    if errors.kind == "logn":
        gain = 0.01 * (np.exp(0.7 * random.standard_normal(curves)) - 1)
    drawn = errors.rig_gain * random.standard_normal(3)
    rig = np.arange(curves) % 3
    gain += (drawn if rig_gains is None else rig_gains)[rig]
    zero = errors.zero * random.standard_normal(curves)
    scale = 1 + errors.slip_scale * random.standard_normal(curves)
    offset = 1e-4 * random.standard_normal(curves) * (errors.kind == "slip0")
    temperature = conditions[:, 2] + errors.temperature_k * random.standard_normal(curves)

    curve = np.repeat(np.arange(curves), len(slips))
    slip = np.tile(slips, curves)
    noise = errors.noise * random.standard_normal(len(slip))
    if errors.kind == "heavy":
        noise = errors.noise * random.standard_t(3, len(slip))
    true_slip = slip * scale[curve] + offset[curve]
    mu = truth(conditions[curve, 0], conditions[curve, 1], temperature[curve], true_slip)
    if errors.kind == "het":
        noise *= 1 + 0.005 / mu
    measured = mu * (1 + gain[curve]) * (1 + noise) + zero[curve]
    return Measurements(
        conditions, curve, slip, measured, rig_of_curve=rig if errors.rig_gain > 0 else None
    )


def fitted_law(measurements: Measurements) -> FreeLaw:
    """Deng's law, fitted to the logarithms of points by least squares."""
    positive = measurements.mu > 4e-4
    conditions = measurements.point_conditions[positive]
    slip, logarithm = measurements.slip[positive], np.log(measurements.mu[positive])
    free = np.ones(len(DENG_CONSTANTS), dtype=bool)
    lower = np.array([constant.lower for constant in PAPER_LAW.constants])
    upper = np.array([constant.upper for constant in PAPER_LAW.constants])

    def residuals(constants: FloatArray) -> FloatArray:
        return FreeLaw(PAPER_LAW, constants, free).log_mu(conditions, slip) - logarithm

    def slopes(constants: FloatArray) -> FloatArray:
        return FreeLaw(PAPER_LAW, constants, free).log_slopes(conditions, slip)

    start = np.clip(DENG_CONSTANTS, lower, upper)
    found = scipy.optimize.least_squares(residuals, start, slopes, (lower, upper), x_scale="jac")
    return FreeLaw(PAPER_LAW, found.x, free)
