"""A film that thins by a power law up to a limiting stress, at one temperature.

    mu = L [1 - exp(-c/L)],   c = N S [1 + (N S/G)^2]^((n - 1)/2)

All stresses are over the mean pressure: N the slope at rest eta U/(h p), G the stress at which
thinning begins, L = tau_L/p. n and the stress G p are taken for properties of the oil, the same at
every condition, hence G = G0 P^-1. n stays below 0.9: nearer to 1 nothing thins and G could be
anything. The law rises with slip for ever: nothing heats it.

References: S. Bair, High Pressure Rheology for Quantitative Elastohydrodynamics, Elsevier (2007);
S. Bair, W. O. Winer, J. Lubr. Technol. 101 (1979) 258; the stresses as in
`oilfilm.physics.thermal_traction`.
"""

import numpy as np

from oilfilm.physics.thermal_traction import carreau_stress, limited_stress
from oilfilm.traction.law import Coefficient, FloatArray, Law


class Carreau(Law):
    """Shear thinning by a power law, limiting stress."""

    name = "carreau"
    equation = (
        "mu = L (1 - exp(-c/L)), c = N S (1 + (N S/G)^2)^((n - 1)/2), "
        "X = X0 (P/1 GPa)^X1 (U/20 m/s)^X2 (T/20 degC)^X3, G = G0 (P/1 GPa)^-1, n = n0"
    )
    source = "Bair, High Pressure Rheology (2007), with the limit of Bair and Winer (1979)"
    reference = np.array([1.0, 20.0, 20.0])  # GPa, m/s, degC
    coefficients = (
        Coefficient("N", +1, 1e-2, 1e4),
        Coefficient("G", +1, 1e-4, 1.0, exponents=(-1.0, 0.0, 0.0)),
        Coefficient("n", +1, 1e-2, 0.9, exponents=(0.0, 0.0, 0.0)),
        Coefficient("L", +1, 1e-3, 1.0),
    )

    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from N, G, n and L."""
        slope, thinning, exponent, limit = sizes
        return limited_stress(carreau_stress(slope, slip, thinning, exponent), limit)

    def slopes(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives by ln N, ln G, ln n and ln L."""
        slope, thinning, exponent, limit = sizes
        free = carreau_stress(slope, slip, thinning, exponent)
        ratio = slope * slip / thinning
        bend = (exponent - 1) * (ratio / np.hypot(1, ratio)) ** 2
        share = np.exp(-free / limit)
        return np.stack(
            [
                share * free * (1 + bend),
                -share * free * bend,
                share * free * exponent * np.log(np.hypot(1, ratio)),
                limited_stress(free, limit) - share * free,
            ]
        )
