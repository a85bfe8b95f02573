"""What a traction law offers; fitting knows laws through this interface only.

Every law here says mu as a function of the slide-roll ratio and of a few coefficients, each of
which is a power law of the operating conditions, or of groups made of them. A law's own module
holds its equation and the derivatives of it; what all laws share is written once, here.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

CONDITIONS = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")

# Power laws of traction steeper than this are not known; the search needs a limit.
_STEEPEST = 6.0


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of a law's equation, X = sign * |X0| * (power law of the conditions).

    The search looks for |X0| between `smallest` and `largest`; the sign can never change.
    `exponents` are given where the law knows them: X0 is then the coefficient's only constant.
    """

    name: str
    sign: int
    smallest: float
    largest: float
    exponents: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Constant:
    """One constant of a law: the X0 of a coefficient, or one of its exponents.

    `condition` names the group whose exponent it is, None for X0. The bounds are those of the
    search and hold for the internal value: ln|X0|, or the exponent itself. `known` is the value
    of an exponent that is no constant to be fitted, because the law gives it.
    """

    name: str
    lower: float
    upper: float
    sign: int = 0
    condition: str | None = None
    known: float | None = None


@dataclass(frozen=True)
class Observations:
    """Points to evaluate a law at, gathered in curves of one operating condition each.

    Attributes:
        design: One row a curve, made by the law from its conditions.
        curve: Row of `design` that each point belongs to.
        slip: Slide-roll ratio of each point, 0 or more.
    """

    design: FloatArray
    curve: IndexArray
    slip: FloatArray


class Law(ABC):
    """A traction law: mu as a function of its constants, the conditions and the slip.

    `internal` is the search's own form of the constants, shape (constants,) or, for a whole
    population at once, (constants, population).

    Attributes:
        name: Name in config and tables.
        equation: The equation in words a reader can type.
        source: Author, year, equation.
        coefficients: The coefficients of the equation, in the order of every array of them.
        conditions: Columns of the table of points that the law needs.
        groups: What the power laws are of: the conditions, or groups that the law makes of them.
        reference: Value of each group at which every power law is 1.
    """

    name: ClassVar[str]
    equation: ClassVar[str]
    source: ClassVar[str]
    coefficients: ClassVar[tuple[Coefficient, ...]]
    conditions: ClassVar[tuple[str, ...]] = CONDITIONS
    reference: ClassVar[FloatArray]

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups."""
        return self.conditions

    def group_values(self, conditions: FloatArray) -> FloatArray:
        """Rows of groups from rows of conditions."""
        return conditions

    def in_contacts(self, radius_m: FloatArray, reduced_modulus_pa: float) -> "Law":
        """The law with its groups made in other contacts, a row of conditions each.

        Args:
            radius_m: Reduced radius along the rolling direction, shape (rows,).
            reduced_modulus_pa: E' = 2 E*.
        """
        return self

    def varied_groups(self, varied: BoolArray) -> BoolArray:
        """Which groups vary where these conditions do.

        Raises:
            ValueError: The law cannot follow the varied conditions alone.
        """
        return varied

    @abstractmethod
    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from the coefficients' sizes |X|, shape (coefficients, ...), at slips (...)."""

    @abstractmethod
    def slopes(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """Derivatives of `value` by each ln|X|, shape (coefficients, ...)."""

    @cached_property
    def constants(self) -> tuple[Constant, ...]:
        """X0 and the exponents of each coefficient, in the order of every array of them."""
        constants: list[Constant] = []
        for one in self.coefficients:
            lower, upper = np.log([one.smallest, one.largest])
            constants.append(Constant(f"{one.name}0", lower, upper, one.sign))
            known = one.exponents or (None,) * len(self.groups)
            constants += [
                Constant(f"{one.name}{place}", -_STEEPEST, _STEEPEST, condition=group, known=value)
                for place, (group, value) in enumerate(zip(self.groups, known, strict=True), 1)
            ]
        return tuple(constants)

    @cached_property
    def known(self) -> FloatArray:
        """Internal constants with the exponents that the law gives, and 0 for all others."""
        return np.array([constant.known or 0.0 for constant in self.constants])

    def design(self, conditions: FloatArray, varied: BoolArray | None = None) -> FloatArray:
        """Rows of conditions -> rows of 1 and the logarithms of the groups over their reference.

        Args:
            conditions: Shape (rows, conditions).
            varied: Groups that count; the others stay at their reference. All if not given.

        Raises:
            ValueError: A group is not above zero, where the power laws have no value.
        """
        relative = self.group_values(np.atleast_2d(conditions)) / self.reference
        if varied is not None:
            relative = np.where(varied, relative, 1.0)
        if not np.all(relative > 0):
            raise ValueError(f"{self.name} needs {', '.join(self.conditions)} above zero")
        return np.column_stack([np.ones(len(relative)), np.log(relative)])

    def sizes(self, internal: FloatArray, design: FloatArray) -> FloatArray:
        """|X| of each coefficient: shape (coefficients, rows of design[, population])."""
        blocks = internal.reshape(len(self.coefficients), -1, *internal.shape[1:])
        return np.asarray(np.exp(np.einsum("cd,ld...->lc...", design, blocks)))

    def traction(self, internal: FloatArray, at: Observations) -> FloatArray:
        """mu at each point: shape (points,) or (points, population)."""
        sizes = self.sizes(internal, at.design)[:, at.curve]
        return self.value(sizes, at.slip if internal.ndim == 1 else at.slip[:, np.newaxis])

    def jacobian(self, internal: FloatArray, at: Observations) -> FloatArray:
        """Derivatives of mu by each internal constant: shape (points, constants)."""
        slopes = self.slopes(self.sizes(internal, at.design)[:, at.curve], at.slip)
        rows = at.design[at.curve]
        return np.hstack([slope[:, np.newaxis] * rows for slope in slopes])

    @property
    def local_constants(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(one.name for one in self.coefficients)


def to_constants(law: Law, internal: FloatArray) -> FloatArray:
    """Constants as they stand in the law's equation, from the search's form."""
    signs = np.array([constant.sign for constant in law.constants])
    return np.where(signs == 0, internal, signs * np.exp(np.where(signs == 0, 0.0, internal)))


def to_internal(law: Law, constants: FloatArray) -> FloatArray:
    """The search's form of a law's constants, shape (..., constants).

    Raises:
        ValueError: A constant has the sign that the law forbids.
    """
    signs = np.array([constant.sign for constant in law.constants])
    magnitude = np.where(signs == 0, 1.0, signs * constants)
    if np.any(magnitude <= 0):
        wrong = law.constants[int(np.argwhere(magnitude <= 0)[0][-1])]
        raise ValueError(f"{law.name}: {wrong.name} must be of sign {wrong.sign:+d}")
    return np.where(signs == 0, constants, np.log(magnitude))


def bounds(law: Law) -> FloatArray:
    """Search bounds of the internal constants, shape (constants, 2)."""
    return np.array([(constant.lower, constant.upper) for constant in law.constants])
