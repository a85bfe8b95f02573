"""The smooth step of many vehicle and bearing codes: up to a level, and there it stays.

    mu = A tanh(B S/A)

with A the level and B the slope at S = 0. It rises with slip for ever and has no peak.

Reference: in general use as a regularised Coulomb law; no single source.
"""

import numpy as np

from oilfilm.traction.law import Coefficient, FloatArray, Law


class Saturating(Law):
    """Two coefficients, eight constants: the plainest law of all."""

    name = "tanh"
    equation = "mu = A tanh(B S/A), X = X0 (P/1 GPa)^X1 (U/20 m/s)^X2 (T/20 degC)^X3"
    source = "in general use; no single source"
    reference = np.array([1.0, 20.0, 20.0])  # GPa, m/s, degC
    coefficients = (
        Coefficient("A", +1, 1e-4, 1.0),
        Coefficient("B", +1, 1e-2, 1e4),
    )

    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from A and B."""
        level, slope = sizes
        return np.asarray(level * np.tanh(slope * slip / level))

    def slopes(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives by ln A and ln B."""
        level, slope = sizes
        step = np.tanh(slope * slip / level)
        by_slope = slope * slip * (1 - step**2)
        return np.stack([level * step - by_slope, by_slope])
