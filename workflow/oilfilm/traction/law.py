"""What a traction law offers; fitting knows laws through this interface only."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

CONDITIONS = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")


@dataclass(frozen=True)
class Constant:
    """One constant of a law.

    `condition` names the operating condition whose exponent it is, None for the others. The
    bounds are those of the search and hold for the internal (logarithmic, where `sign` is not 0)
    value: a constant with a sign is `sign * exp(internal)` and can never change it.
    """

    name: str
    lower: float
    upper: float
    sign: int = 0
    condition: str | None = None


@dataclass(frozen=True)
class Observations:
    """Points to evaluate a law at, gathered in curves of one operating condition each.

    Attributes:
        design: One row a curve, made by the law from its conditions.
        curve: Row of `design` that each point belongs to.
        slip: Slide-roll ratio of each point.
    """

    design: FloatArray
    curve: IndexArray
    slip: FloatArray


class Law(Protocol):
    """A traction law: mu as a function of its constants, the conditions and the slip.

    `internal` is the search's own form of the constants, shape (constants,) or, for a whole
    population at once, (constants, population).
    """

    @property
    def name(self) -> str:
        """Name in config and tables."""
        ...

    @property
    def constants(self) -> tuple[Constant, ...]:
        """Constants in the order of every array of them."""
        ...

    @property
    def local_constants(self) -> tuple[str, ...]:
        """Names of the law's coefficients at one operating condition."""
        ...

    @property
    def reference(self) -> FloatArray:
        """Conditions (P in GPa, U in m/s, T in degC) at which every power law is 1."""
        ...

    def design(self, conditions: FloatArray) -> FloatArray:
        """Rows of (P in GPa, U in m/s, T in degC) -> rows of what the law needs of them."""
        ...

    def traction(self, internal: FloatArray, at: Observations) -> FloatArray:
        """mu at each point: shape (points,) or (points, population)."""
        ...

    def jacobian(self, internal: FloatArray, at: Observations) -> FloatArray:
        """Derivatives of mu by each internal constant: shape (points, constants)."""
        ...

    def local_values(self, internal: FloatArray, design: FloatArray) -> FloatArray:
        """The law's coefficients at given conditions: shape (curves, local constants)."""
        ...

    def curve(self, local_values: FloatArray, slip: FloatArray) -> FloatArray:
        """mu against slip for one row of local values."""
        ...


def to_constants(law: Law, internal: FloatArray) -> FloatArray:
    """Constants as they stand in the law's equation, from the search's form."""
    signs = np.array([constant.sign for constant in law.constants])
    return np.where(signs == 0, internal, signs * np.exp(np.where(signs == 0, 0.0, internal)))


def to_internal(law: Law, constants: FloatArray) -> FloatArray:
    """The search's form of a law's constants.

    Raises:
        ValueError: A constant has the sign that the law forbids.
    """
    signs = np.array([constant.sign for constant in law.constants])
    magnitude = np.where(signs == 0, 1.0, signs * constants)
    if np.any(magnitude <= 0):
        wrong = law.constants[int(np.argmin(magnitude))]
        raise ValueError(f"{law.name}: {wrong.name} must be of sign {wrong.sign:+d}")
    return np.where(signs == 0, constants, np.log(magnitude))


def bounds(law: Law) -> FloatArray:
    """Search bounds of the internal constants, shape (constants, 2)."""
    return np.array([(constant.lower, constant.upper) for constant in law.constants])
