"""Friction torque as catalogues estimate it: outside opinions, never a gate.

Both formulas and their constants are as usually quoted, not checked against print, for pure axial
load on a single-row angular-contact bearing.
"""

import numpy as np

from oilfilm.physics.contact import Floats
from oilfilm.units import MM_PER_M, FloatArray

_CST = 1e6
_N_MM = 1e-3


def palmgren_torque_n_m(
    axial_load_n: Floats,
    speed_rpm: Floats,
    kinematic_viscosity_m2_s: Floats,
    pitch_diameter_m: float,
    contact_angle_rad: float,
    f0: float,
    f1: float,
) -> FloatArray:
    """Palmgren's torque: a part of speed and one of load.

        M0 = 1e-7 f0 (nu n)^(2/3) dm^3 N mm, at least that of nu n = 2000
        M1 = f1 P1 dm,   P1 = 0.9 Fa cot(alpha)

    with nu in cSt, n in 1/min, dm in mm.

    Args:
        axial_load_n: Fa.
        speed_rpm: n.
        kinematic_viscosity_m2_s: nu.
        pitch_diameter_m: dm.
        contact_angle_rad: alpha, unloaded.
        f0: Of lubrication and bearing type.
        f1: Of load and bearing type.

    Returns:
        M0 + M1, in N m; NaN without contact angle.

    Reference: A. Palmgren, Ball and Roller Bearing Engineering, 3rd ed., 1959.

    Examples:
        dm 100 mm, nu n = 8000, f0 1, no load: 1e-7 * 400 * 1e6 N mm.

        >>> print(f"{palmgren_torque_n_m(0.0, 1000.0, 8e-6, 0.1, 0.5, 1.0, 1e-3):.3f} N m")
        0.040 N m
    """
    pitch = pitch_diameter_m * MM_PER_M
    turning = np.maximum(kinematic_viscosity_m2_s * _CST * speed_rpm, 2000.0)
    of_speed = 1e-7 * f0 * turning ** (2 / 3) * pitch**3
    # of a bearing without contact angle he has another formula
    per_load = 0.9 / np.tan(contact_angle_rad) if contact_angle_rad > 0 else np.nan
    of_load = f1 * per_load * axial_load_n * pitch
    return np.asarray(_N_MM * (of_speed + of_load))


def skf_torque_n_m(
    axial_load_n: Floats,
    speed_rpm: Floats,
    kinematic_viscosity_m2_s: Floats,
    pitch_diameter_m: float,
) -> FloatArray:
    """SKF's rolling and sliding torque, without drag, seals and starvation.

        Mrr = phi_ish Grr (nu n)^0.6,   Grr = R1 dm^1.97 (Fg + R2 Fa)^0.54,   Fg = R3 dm^4 n^2
        Msl = Gsl mu_sl,   Gsl = S1 dm^0.26 (Fs^(4/3) + S2 Fa^(4/3)),   Fs = S3 dm^4 n^2
        phi_ish = 1/(1 + 1.84e-9 (n dm)^1.28 nu^0.64)
        mu_sl = phi_bl 0.12 + (1 - phi_bl) 0.04,   phi_bl = exp(-2.6e-8 (n nu)^1.4 dm)

    with R1, R2, R3 = 5.03e-7, 1.97, 1.90e-12 and S1, S2, S3 = 1.30e-2, 0.68, 1.91e-12, nu in cSt,
    n in 1/min, dm in mm, torque in N mm.

    Args:
        axial_load_n: Fa.
        speed_rpm: n.
        kinematic_viscosity_m2_s: nu.
        pitch_diameter_m: dm.

    Returns:
        Mrr + Msl, in N m.

    Validity: loads above the catalogue's minimum and speeds up to a bearing's limiting speed, about
    0.7 million mm rpm for single-row angular-contact bearings. Sliding goes with n^(8/3): at 2
    million mm rpm it alone is several times any measured torque.

    Reference: SKF, Rolling bearings, general catalogue, 2018: the SKF model for calculating the
        frictional moment, angular contact ball bearings.

    Examples:
        At rest the film is gone: 0.12 S1 dm^0.26 S2 Fa^(4/3) = 0.035 N m at 100 mm, 1 kN, by hand:

        >>> print(f"{skf_torque_n_m(1000.0, 0.0, 5e-6, 0.1):.3f} N m")
        0.035 N m
    """
    pitch, nu = pitch_diameter_m * MM_PER_M, kinematic_viscosity_m2_s * _CST
    turning = nu * np.asarray(speed_rpm, dtype=float)
    heating = 1 / (1 + 1.84e-9 * (speed_rpm * pitch) ** 1.28 * nu**0.64)
    of_balls = 1.90e-12 * pitch**4 * np.square(speed_rpm)
    rolling = 5.03e-7 * pitch**1.97 * (of_balls + 1.97 * axial_load_n) ** 0.54 * turning**0.6
    slid_by_balls = 1.91e-12 * pitch**4 * np.square(speed_rpm)
    sliding = slid_by_balls ** (4 / 3) + 0.68 * np.power(axial_load_n, 4 / 3)
    touching = np.exp(-2.6e-8 * turning**1.4 * pitch)
    friction = touching * 0.12 + (1 - touching) * 0.04
    return np.asarray(_N_MM * (heating * rolling + friction * 1.30e-2 * pitch**0.26 * sliding))
