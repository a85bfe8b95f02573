"""The edges of the library: SI inside, GPa, um, degC and rpm outside; converted only here."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

PA_PER_GPA = 1e9
M_PER_UM = 1e-6


def rpm_to_surface_speed(speed_rpm: FloatArray, radius_m: float) -> FloatArray:
    """Surface speed in m/s of a body turning at `speed_rpm`, at `radius_m` from its axis."""
    return np.asarray(speed_rpm) * (2 * np.pi / 60) * radius_m


def surface_speed_to_rpm(speed_m_s: FloatArray, radius_m: float) -> FloatArray:
    """Rotational speed in rpm that gives `speed_m_s` at `radius_m` from the axis."""
    return np.asarray(speed_m_s) / radius_m * (60 / (2 * np.pi))
