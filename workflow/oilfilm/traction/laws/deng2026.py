"""The stress-based traction law of Deng et al. (2026), Eqs 7-9, and with an exponential of T.

    mu = (A + B S) exp(-C S) - A,   X = X0 Pbar^X1 Ubar^X2 Tbar^X3   for X in A, B, C

with Pbar = P / 1 GPa, Ubar = U / 20 m/s, Tbar = T / 20 degC (degrees Celsius, as printed), S the
slide-roll ratio and A < 0, B > 0, C > 0. Hence mu = 0 at S = 0 and mu -> |A| for large S. With
these signs mu >= 0 for every S >= 0. The slope at S = 0 is B + |A| C. The only peak is at
S = 1/C + |A|/B.

Decides: equation, signs and search bounds of the paper's law (each other law: its file beside this
one).
"""

from dataclasses import replace

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.traction.law import Coefficient, Law

DENG2026 = Law(
    name="deng2026",
    title="Deng (Eq. 7)",
    source="K. Deng, X. Qing, F. Pape, Y. Wang, Lubricants 14 (2026) 33, Eqs 7-9",
    equation="(A + B*S)*exp(-C*S) - A",
    coefficients=(
        Coefficient("A", -1, 1e-4, 1.0),
        Coefficient("B", +1, 1e-4, 1e3, multiplies_slip=True),
        Coefficient("C", +1, 1e-2, 1e4, multiplies_slip=True),
    ),
    adore=("A", "B", "C", "-A"),
)

# The same with X = X0 Pbar^X1 Ubar^X2 exp(X3 (Tbar - 1)): X3/20 is the relative change of X per K.
# A power of T in degC is steepest at 0 degC and has no value below it. The exponential has a value
# at every temperature, and is the usual form of a viscosity over a small range of temperature. It
# is OURS.
DENG_EXPONENTIAL = replace(
    DENG2026,
    name="deng-exponential",
    title="Deng (Eq. 7), exponential in T",
    source=f"{DENG2026.source}; the exponential of T in place of a power is ours",
    exponential=("inlet_temperature_c",),
)


def traction_coefficient(
    constants: FloatArray,
    max_hertz_pressure_gpa: FloatArray,
    entrainment_speed_m_s: FloatArray,
    inlet_temperature_c: FloatArray,
    slide_roll_ratio: FloatArray,
) -> FloatArray:
    """Traction coefficient by Eqs 7-9.

    Args:
        constants: A0 to A3, B0 to B3 and C0 to C3 with their signs, shape (12,).
        max_hertz_pressure_gpa: Maximum Hertz pressure P, in GPa.
        entrainment_speed_m_s: Entrainment speed U, in m/s.
        inlet_temperature_c: Inlet temperature T, in degC, above 0.
        slide_roll_ratio: Slide-roll ratio S, 0 or more. The four arrays broadcast.

    Returns:
        mu, of the broadcast shape.

    Reference: Deng et al., Lubricants 14 (2026) 33, Eqs 7-9.

    Examples:
        At the reference condition mu is (A0 + B0 S) exp(-C0 S) - A0. Oil 4102, S = 0.05, by hand:

        >>> c = np.zeros(12)
        >>> c[[0, 4, 8]] = -0.01567792, 0.63482685, 24.43483717
        >>> round(float(traction_coefficient(c, 1.0, 20.0, 20.0, 0.05)), 6)
        0.020412
    """
    pressure_reference, speed_reference, temperature_reference = DENG2026.reference
    relative_pressure = np.asarray(max_hertz_pressure_gpa) / pressure_reference
    relative_speed = np.asarray(entrainment_speed_m_s) / speed_reference
    relative_temperature = np.asarray(inlet_temperature_c) / temperature_reference

    def coefficient(x0: float, x1: float, x2: float, x3: float) -> FloatArray:
        return np.asarray(
            x0 * relative_pressure**x1 * relative_speed**x2 * relative_temperature**x3
        )

    a_constants, b_constants, c_constants = np.split(np.asarray(constants, dtype=float), 3)
    a = coefficient(*a_constants)
    b = coefficient(*b_constants)
    c = coefficient(*c_constants)
    return DENG2026.mu_of_magnitudes(np.array([-a, b, c]), np.asarray(slide_roll_ratio))
