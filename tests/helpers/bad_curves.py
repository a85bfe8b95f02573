"""Curves with defects that no oil makes, as arrays of points."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.surface.measurements import Measurements

# Damages one curve. Arguments: its mu and its slips, in ascending order, and its pressure in GPa.
CurveDamage = Callable[[FloatArray, FloatArray, float], FloatArray]


def film_collapse(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """The film fails over the last three steps: up to 2.5 times the traction."""
    factor = np.ones_like(mu)
    factor[-3:] = (1.3, 1.8, 2.5)
    return mu * factor


def late_by_a_step(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """The force belongs to the slip of one step before."""
    return np.append(0.5 * mu[0], mu[:-1])


def scuffing(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """The surfaces are damaged at two thirds of the steps: 67 % more traction from there."""
    factor = np.where(np.arange(len(mu)) < 2 * len(mu) // 3, 1.0, 1.67)
    return mu * factor


def one_step_high(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """One step reads 15 % too high."""
    factor = np.ones_like(mu)
    factor[len(mu) // 2] = 1.15
    return mu * factor


def zero_shift(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """The zero of the force moves by -0.35 N above a slip of 0.1: 39 N at 1.25 GPa."""
    load_n = 39.0 * (pressure_gpa / 1.25) ** 3
    return mu - np.where(slip > 0.1, 0.35 / load_n, 0.0)


def pump_stop(mu: FloatArray, slip: FloatArray, pressure_gpa: float) -> FloatArray:
    """The contact starves over the second half of the steps: half the traction at the end."""
    half = len(mu) // 2
    factor = np.append(np.ones(len(mu) - half), np.linspace(0.95, 0.5, half))
    return mu * factor


CURVE_DAMAGES: tuple[CurveDamage, ...] = (
    film_collapse,
    late_by_a_step,
    scuffing,
    one_step_high,
    zero_shift,
    pump_stop,
)


def damage_curves(measurements: Measurements, rows: list[int], damage: CurveDamage) -> Measurements:
    """The points with some curves damaged; each curve is in ascending order of slip."""
    mu = measurements.mu.copy()
    for row in rows:
        points = measurements.curve_of_point == row
        pressure = float(measurements.conditions[row, 0])
        mu[points] = damage(mu[points], measurements.slip[points], pressure)
    return replace(measurements, mu=mu)
