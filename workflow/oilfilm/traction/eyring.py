"""A film that thins by Eyring's rule up to a limiting stress, softened by its own heat.

    mu = m/(1 + H S mu),   m = L [1 - exp(-e/L)],   e = E asinh(N S/E)

All stresses are over the mean pressure: N the slope at rest eta U/(h p), E = tau_E/p, L = tau_L/p.
The heat that arises goes with mu S; H is how much of its stress the film loses to it, a power law
like the others. That the stress falls as 1/(1 + temperature rise) is OURS, and keeps the law
explicit; without heat (H = 0) it is the isothermal law. tau_E is taken for a property of the oil,
the same at every condition, hence E = E0 P^-1.

References: K. L. Johnson, J. L. Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215; S. Bair,
W. O. Winer, J. Lubr. Technol. 101 (1979) 258; the stresses as in
`oilfilm.physics.thermal_traction`.
"""

import numpy as np

from oilfilm.physics.thermal_traction import eyring_stress, limited_stress
from oilfilm.traction.law import Coefficient, FloatArray, Law


class Eyring(Law):
    """Shear thinning by thermal activation, limiting stress, first-order heat."""

    name = "eyring"
    equation = (
        "mu = m/(1 + H S mu), m = L (1 - exp(-E asinh(N S/E)/L)), "
        "X = X0 (P/1 GPa)^X1 (U/20 m/s)^X2 (T/20 degC)^X3, E = E0 (P/1 GPa)^-1"
    )
    source = (
        "Johnson and Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215, with the limit of Bair and "
        "Winer (1979); the heat is ours"
    )
    reference = np.array([1.0, 20.0, 20.0])  # GPa, m/s, degC
    coefficients = (
        Coefficient("N", +1, 1e-2, 1e4),
        Coefficient("E", +1, 1e-4, 1.0, exponents=(-1.0, 0.0, 0.0)),
        Coefficient("L", +1, 1e-3, 1.0),
        Coefficient("H", +1, 1e-2, 1e5),
    )

    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from N, E, L and H."""
        slope, eyring, limit, heat = sizes
        cold = limited_stress(eyring_stress(slope, slip, eyring), limit)
        return 2 * cold / (1 + np.sqrt(1 + 4 * heat * slip * cold))

    def slopes(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives by ln N, ln E, ln L and ln H."""
        slope, eyring, limit, heat = sizes
        free = eyring_stress(slope, slip, eyring)
        cold = limited_stress(free, limit)
        root = np.sqrt(1 + 4 * heat * slip * cold)
        mu = 2 * cold / (1 + root)
        ratio = slope * slip / eyring
        free_by_slope = eyring * ratio / np.hypot(1, ratio)
        # mu + H S mu^2 = m; (1 + 2 H S mu) is the root
        share = np.exp(-free / limit)
        return np.stack(
            [
                share * free_by_slope / root,
                share * (free - free_by_slope) / root,
                (cold - share * free) / root,
                -heat * slip * mu**2 / root,
            ]
        )
