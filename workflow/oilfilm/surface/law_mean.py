"""A fitted traction law whose constants stay free: the mean of a surface.

Decides: how far the constants of a law may move inside a surface.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.traction.law import Law, Observations

# Standard deviation of each internal constant (ln|X0| or exponent) about its fitted value. With
# constants that are not free, the law takes up a drift of the rig, and intervals are too narrow.
CONSTANT_SD = 0.3
# A constant is at a bound where it is nearer to it than this share of its range.
_AT_BOUND = 1e-6
# Points whose design is in memory at once: it is many times as large as their mu.
_POINTS_AT_ONCE = 1 << 16


def _unchanged(conditions: FloatArray) -> FloatArray:
    """The conditions of the law where these are P, U and T."""
    return conditions


@dataclass(frozen=True)
class FreeLaw:
    """A fitted traction law: its constants, and which of them stay free inside a surface.

    Attributes:
        law: The law.
        constants: Internal constants, ln|X0| and exponents, shape (constants,).
        is_free: Whether each constant was fitted, shape (constants,).
        conditions_of_law: Makes rows of `law.conditions` from rows of P in GPa, U in m/s and T in
            degC.
    """

    law: Law
    constants: FloatArray
    is_free: BoolArray
    conditions_of_law: Callable[[FloatArray], FloatArray] = _unchanged

    def log_mu(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """ln mu of the law, shape (points,); not finite where its mu is not above 0.

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slip: Slide-roll ratio, above 0, shape (points,).
        """
        mu = np.empty(len(slip))
        for first_point in range(0, len(slip), _POINTS_AT_ONCE):
            block = slice(first_point, first_point + _POINTS_AT_ONCE)
            observations = self._observations(conditions[block], slip[block])
            mu[block] = self.law.traction(self.constants, observations)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.log(mu)

    def has_traction(self, conditions: FloatArray, slip: FloatArray) -> BoolArray:
        """Whether mu of the law is above 0, shape (points,); arguments as of `log_mu`."""
        return np.isfinite(self.log_mu(conditions, slip))

    def log_slopes(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives of ln mu by the free internal constants, shape (points, free constants)."""
        observations = self._observations(conditions, slip)
        mu = self.law.traction(self.constants, observations)
        slopes = self.law.jacobian(self.constants, observations)[:, self.is_free]
        return slopes / mu[:, np.newaxis]

    def is_at_bound(self) -> BoolArray:
        """Whether each free constant is at a bound of its search, shape (free constants,)."""
        lower = np.array([constant.lower for constant in self.law.constants])
        upper = np.array([constant.upper for constant in self.law.constants])
        distance = np.minimum(self.constants - lower, upper - self.constants)
        return (distance <= _AT_BOUND * (upper - lower))[self.is_free]

    @property
    def _is_followed(self) -> BoolArray:
        """Whether each group has an exponent that is free or not 0; other groups have no effect."""
        followed_groups = set()
        for constant, value, is_free in zip(
            self.law.constants, self.constants, self.is_free, strict=True
        ):
            if is_free or value != 0:
                followed_groups.add(constant.group)
        return np.array([group in followed_groups for group in self.law.groups])

    def _observations(self, conditions: FloatArray, slip: FloatArray) -> Observations:
        """Points as the law takes them, each with a row of the design of its own."""
        design = self.law.design(self.conditions_of_law(conditions), self._is_followed)
        return Observations(design, np.arange(len(slip)), slip)
