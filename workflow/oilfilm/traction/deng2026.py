r"""The stress-based traction law of Deng et al. (2026), Eqs 7-9.

    mu = (A + B S) exp(-C S) - A,   X = X0 Pbar^X1 Ubar^X2 Tbar^X3   for X in A, B, C

with Pbar = P / 1 GPa, Ubar = U / 20 m/s, Tbar = T / 20 degC (degrees Celsius, as printed), S the
slide-roll ratio and A < 0, B > 0, C > 0. Hence mu = 0 at S = 0 and mu -> |A| for large S; with
these signs mu >= 0 for every S >= 0; the slope at S = 0 is B + |A| C and the one peak lies at
S = 1/C + |A|/B.

Reference: K. Deng, X. Qing, F. Pape, Y. Wang, Lubricants 14 (2026) 33, Eqs 7-9.
"""

import numpy as np

from oilfilm.traction.law import CONDITIONS, Constant, FloatArray, Observations

REFERENCE = np.array([1.0, 20.0, 20.0])  # GPa, m/s, degC: the paper's P0, U0, T0


def _block(letter: str, sign: int, smallest: float, largest: float) -> tuple[Constant, ...]:
    exponents = (
        Constant(f"{letter}{index}", -6.0, 6.0, condition=condition)
        for index, condition in enumerate(CONDITIONS, start=1)
    )
    return (Constant(f"{letter}0", np.log(smallest), np.log(largest), sign), *exponents)


class Deng2026:
    """Eqs 7-9 with their twelve constants; the signs of A, B and C cannot change."""

    name = "deng2026"
    reference = REFERENCE
    local_constants = ("A", "B", "C")
    constants = (
        *_block("A", -1, 1e-4, 1.0),
        *_block("B", +1, 1e-4, 1e3),
        *_block("C", +1, 1e-2, 1e4),
    )

    def design(self, conditions: FloatArray) -> FloatArray:
        """Rows of (P GPa, U m/s, T degC) -> rows of (1, ln Pbar, ln Ubar, ln Tbar).

        Raises:
            ValueError: A condition is not above zero, where the power laws have no value.
        """
        relative = np.atleast_2d(conditions) / REFERENCE
        if not np.all(relative > 0):
            raise ValueError("deng2026 needs pressure, speed and temperature (degC) above zero")
        return np.column_stack([np.ones(len(relative)), np.log(relative)])

    def traction(self, internal: FloatArray, at: Observations) -> FloatArray:
        """mu of Eq. 7 at each point (see `Law.traction`)."""
        size, slope, rate = (at.design @ block for block in np.split(internal, 3))
        slip = at.slip if internal.ndim == 1 else at.slip[:, np.newaxis]
        decay = np.exp(-np.exp(rate)[at.curve] * slip)
        return np.exp(size)[at.curve] * (1 - decay) + np.exp(slope)[at.curve] * slip * decay

    def jacobian(self, internal: FloatArray, at: Observations) -> FloatArray:
        """Derivatives of Eq. 7 by ln|X0|, X1, X2, X3 of A, B and C."""
        size, slope, rate = np.exp(self._logarithms(internal, at.design))[:, at.curve]
        decay = np.exp(-rate * at.slip)
        by_log_size = size * (1 - decay)
        by_log_slope = slope * at.slip * decay
        by_log_rate = (size - slope * at.slip) * rate * at.slip * decay
        rows = at.design[at.curve]
        return np.hstack(
            [part[:, np.newaxis] * rows for part in (by_log_size, by_log_slope, by_log_rate)]
        )

    def local_values(self, internal: FloatArray, design: FloatArray) -> FloatArray:
        """A, B and C at each row of the design."""
        size, slope, rate = np.exp(self._logarithms(internal, design))
        return np.column_stack([-size, slope, rate])

    def curve(self, local_values: FloatArray, slip: FloatArray) -> FloatArray:
        """Eq. 7 for one (A, B, C)."""
        a, b, c = local_values
        return np.asarray((a + b * slip) * np.exp(-c * slip) - a)

    def _logarithms(self, internal: FloatArray, design: FloatArray) -> FloatArray:
        return np.stack([design @ block for block in np.split(internal, 3)])


def traction_coefficient(
    constants: FloatArray,
    max_hertz_pressure_gpa: FloatArray,
    entrainment_speed_m_s: FloatArray,
    inlet_temperature_c: FloatArray,
    slide_roll_ratio: FloatArray,
) -> FloatArray:
    """Traction coefficient by Eqs 7-9.

    Args:
        constants: A0..A3, B0..B3, C0..C3, signs included.
        max_hertz_pressure_gpa: P, in GPa.
        entrainment_speed_m_s: U, in m/s.
        inlet_temperature_c: T, in degC, above 0.
        slide_roll_ratio: S, 0 or more. The four arrays broadcast against each other.

    Returns:
        mu, of the broadcast shape.

    Reference: Deng et al., Lubricants 14 (2026) 33, Eqs 7-9.

    Examples:
        At the reference condition mu is (A0 + B0 S) exp(-C0 S) - A0; 4102, S = 0.05, by hand:

        >>> c = np.zeros(12)
        >>> c[[0, 4, 8]] = -0.01567792, 0.63482685, 24.43483717
        >>> round(float(traction_coefficient(c, 1.0, 20.0, 20.0, 0.05)), 6)
        0.020412
    """
    bars = (
        np.asarray(max_hertz_pressure_gpa) / REFERENCE[0],
        np.asarray(entrainment_speed_m_s) / REFERENCE[1],
        np.asarray(inlet_temperature_c) / REFERENCE[2],
    )
    a, b, c = (
        block[0] * bars[0] ** block[1] * bars[1] ** block[2] * bars[2] ** block[3]
        for block in np.split(np.asarray(constants, dtype=float), 3)
    )
    slip = np.asarray(slide_roll_ratio)
    return np.asarray((a + b * slip) * np.exp(-c * slip) - a)
