"""What a traction law is; fitting, exports and the report know laws through this interface only.

A law gives mu by the slide-roll ratio S and a few coefficients. Each coefficient is a power law
of the operating conditions, or of groups made of them. A law's own file holds its equation as
text; values, derivatives, exported code and the typeset equation are all made from that text.

Decides: what a law is, and the bounds of its exponents in the search.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache, cached_property
from typing import Any

import numpy as np

from oilfilm.errors import OilfilmError
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.traction import expression
from oilfilm.traction.expression import Node
from oilfilm.units import BoolArray, FloatArray, IndexArray

CONDITIONS = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")

# Power laws of traction steeper than this are not known; the search needs a limit.
_STEEPEST = 6.0


class NoValueError(OilfilmError, ValueError):
    """A condition at which a law has no value."""


@dataclass(frozen=True)
class Quantity:
    """What a power law can be of: symbol in equations, meaning, unit."""

    symbol: str
    meaning: str
    unit: str

    @property
    def short_meaning(self) -> str:
        """The meaning without what explains it."""
        return self.meaning.partition(",")[0]


QUANTITIES = {
    "max_hertz_pressure_gpa": Quantity("P", "maximum Hertz pressure", "GPa"),
    "entrainment_speed_m_s": Quantity("U", "entrainment speed, mean of both surface speeds", "m/s"),
    "inlet_temperature_c": Quantity("T", "oil temperature at the inlet", "degC"),
    "load_n": Quantity("W", "normal load", "N"),
    "dimensionless_load": Quantity("Q", "dimensionless load W/(E' R^2)", "1"),
    "dimensionless_speed": Quantity("V", "dimensionless speed eta0 U/(E' R)", "1"),
    "thermal_loading_parameter": Quantity("Z", "thermal loading eta0 beta U^2/k", "1"),
}


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of a law's equation, X = sign * |X0| * (power law of the conditions).

    The search looks for |X0| between `smallest` and `largest`; the sign can never change. It starts
    above `searched_from`, where that is given: far below it |X0| has no effect to find its way by.
    `exponents` are given where the law knows them: X0 is then the coefficient's only constant.
    `per_slip` coefficients multiply the slip wherever it stands in the equation.
    """

    name: str
    sign: int
    smallest: float
    largest: float
    exponents: tuple[float, ...] | None = None
    searched_from: float | None = None
    per_slip: bool = False


@dataclass(frozen=True)
class Constant:
    """One constant of a law: the X0 of a coefficient, or one of its exponents.

    `condition` names the group whose exponent it is, None for X0. The bounds are those of the
    search and hold for the internal value: ln|X0|, or the exponent itself. `known` is the value
    of an exponent that is not fitted, because the law gives it; `start_lower` the lowest value at
    which a search starts.
    """

    name: str
    lower: float
    upper: float
    sign: int = 0
    condition: str | None = None
    known: float | None = None
    start_lower: float = -np.inf


@dataclass(frozen=True)
class Observations:
    """Points to evaluate a law at, gathered in curves of one operating condition each.

    Attributes:
        design: One row per curve, made by the law from its conditions.
        curve: Row of `design` that each point belongs to.
        slip: Slide-roll ratio of each point, 0 or more.
    """

    design: FloatArray
    curve: IndexArray
    slip: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Law:
    """A traction law: mu as a function of its constants, the conditions and the slip.

    `internal` is the search's own form of the constants, shape (constants,) or, for a whole
    population at once, (constants, population).

    Attributes:
        name: Name in config and tables.
        title: Name in texts; `name` where it is empty.
        source: Author, year, equation.
        equation: mu for S >= 0 by the coefficients and S, as text (`oilfilm.traction.expression`).
        parts: Parts of the equation that have a name of their own, in order: name and text.
        coefficients: The coefficients of the equation, in the order of every array of them.
        reference: Value of each group at which every power law is 1.
        conditions: Columns of the table of points that the law needs.
        groups: What the power laws are of: the conditions, or groups that the law makes of them.
        must_vary: Conditions without whose variation the law cannot be fitted.
        adore: A, B, C and D as text where the law has the form (A + B S) exp(-C S) + D.
        nested: A law that this one becomes with its further constants at their lower bounds; the
            search also starts from its optimum.
        in_bearings: Whether bearings are evaluated with it too, where another law is the
            campaign's: for laws on load, which differ from one on stress there.
    """

    name: str
    source: str
    equation: str
    coefficients: tuple[Coefficient, ...]
    reference: tuple[float, ...] = (1.0, 20.0, 20.0)
    conditions: tuple[str, ...] = CONDITIONS
    groups: tuple[str, ...] = CONDITIONS
    parts: tuple[tuple[str, str], ...] = ()
    must_vary: tuple[str, ...] = ()
    adore: tuple[str, str, str, str] | None = None
    nested: "Law | None" = None
    in_bearings: bool = False
    title: str = ""

    def __getstate__(self) -> dict[str, Any]:
        # functions compiled from the equation are made again where they are needed
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def group_values(self, conditions: FloatArray) -> FloatArray:
        """Rows of groups from rows of conditions."""
        return conditions

    def of(self, oil: Oil | None, contact: Contact | None) -> "Law | None":
        """The law for an oil in a contact; None where it needs one of them that is not known."""
        return self

    def in_contacts(self, radius_m: FloatArray, reduced_modulus_pa: float) -> "Law":
        """The law with its groups made in other contacts, one per row of conditions.

        Args:
            radius_m: Reduced radius along the rolling direction, shape (rows,).
            reduced_modulus_pa: E' = 2 E*.
        """
        return self

    def varied_groups(self, varied: BoolArray) -> BoolArray:
        """Which groups vary where these conditions do.

        Raises:
            ValueError: The law cannot be fitted where only these conditions vary.
        """
        for name, varies in zip(self.conditions, varied, strict=True):
            if name in self.must_vary and not varies:
                raise ValueError(f"{self.name} needs {name} to vary")
        return varied

    def value(self, sizes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from the coefficients' sizes |X|, shape (coefficients, ...), at slips (...)."""
        return np.asarray(_compiled(self.graphs[:1], self._arguments)(*sizes, slip)[0])

    def value_and_slopes(
        self, sizes: FloatArray, slip: FloatArray
    ) -> tuple[FloatArray, tuple[FloatArray, ...]]:
        """mu, and its derivatives by each ln|X|, each of the arguments' shape or broadcastable."""
        mu, *slopes = _compiled(self.graphs, self._arguments)(*sizes, slip)
        return mu, tuple(slopes)

    def value_slopes_and_curvatures(
        self, sizes: FloatArray, slip: FloatArray, by: tuple[int, ...]
    ) -> tuple[FloatArray, tuple[FloatArray, ...], tuple[FloatArray | float, ...]]:
        """mu, its first and its second derivatives by the ln|X| of some coefficients.

        Args:
            sizes: |X| of each coefficient, shape (coefficients, ...).
            slip: Slide-roll ratio, shape (...).
            by: Indices of the coefficients to differentiate by.

        Returns:
            mu; its slopes; the lower triangle of its second derivatives row by row, where one that
            is zero everywhere is a number.
        """
        function = _to_second_order(self.graphs, self._arguments, by)
        mu, *rest = function(*sizes, slip)
        return mu, tuple(rest[: len(by)]), tuple(rest[len(by) :])

    @property
    def steps(self) -> tuple[tuple[str, str], ...]:
        """The parts of the equation, then mu: name and text."""
        return (*self.parts, ("mu", self.equation))

    @property
    def formula(self) -> str:
        """mu and the parts of its equation, as text."""
        parts = "".join(f", {name} = {text}" for name, text in reversed(self.parts))
        return f"mu = {self.equation}{parts}"

    @cached_property
    def graphs(self) -> tuple[Node, ...]:
        """mu by the sizes |X| and S, and its derivatives by each ln|X|."""
        signs = tuple((coefficient.name, coefficient.sign) for coefficient in self.coefficients)
        return _graphs(self.equation, self.parts, signs)

    @cached_property
    def linear_in(self) -> BoolArray:
        """For each constant, whether it is the X0 of a coefficient in which mu is linear."""
        terms = len(self.constants) // len(self.coefficients)
        linear = np.zeros(len(self.constants), dtype=bool)
        # X g + h is linear in X: its change per relative change of X is X g, and so is that of X g
        linear[::terms] = [
            expression.logarithmic_derivative(slope, name) is slope
            for name, slope in zip(self.local_constants, self.graphs[1:], strict=True)
        ]
        return linear

    @cached_property
    def slip_scale(self) -> FloatArray:
        """Direction of the internal constants in which mu changes by S dmu/dS: (constants,)."""
        each = np.zeros((len(self.coefficients), 1 + len(self.groups)))
        each[:, 0] = [coefficient.per_slip for coefficient in self.coefficients]
        return each.ravel()

    @cached_property
    def _arguments(self) -> tuple[str, ...]:
        return (*self.local_constants, "S")

    @cached_property
    def constants(self) -> tuple[Constant, ...]:
        """X0 and the exponents of each coefficient, in the order of every array of them."""
        constants: list[Constant] = []
        for coefficient in self.coefficients:
            lower, upper = np.log([coefficient.smallest, coefficient.largest])
            start = np.log(coefficient.searched_from or coefficient.smallest)
            constants.append(
                Constant(f"{coefficient.name}0", lower, upper, coefficient.sign, start_lower=start)
            )
            known = coefficient.exponents or (None,) * len(self.groups)
            constants += [
                Constant(f"{coefficient.name}{number}", -_STEEPEST, _STEEPEST, 0, group, value)
                for number, (group, value) in enumerate(zip(self.groups, known, strict=True), 1)
            ]
        return tuple(constants)

    @cached_property
    def signs(self) -> IndexArray:
        """Sign of each constant, 0 for exponents."""
        return np.array([constant.sign for constant in self.constants])

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
            NoValueError: A group is not above zero, where the power laws have no value.
        """
        relative = self.group_values(np.atleast_2d(conditions)) / np.array(self.reference)
        if varied is not None:
            relative = np.where(varied, relative, 1.0)
        without = np.atleast_2d(conditions)[~np.all(relative > 0, axis=1)]
        if len(without):
            found = ", ".join(f"{value:g}" for value in without[0])
            raise NoValueError(
                f"{self.name} needs {', '.join(self.conditions)} above zero; found {found}"
            )
        return np.column_stack([np.ones(len(relative)), np.log(relative)])

    def sizes(self, internal: FloatArray, design: FloatArray) -> FloatArray:
        """|X| of each coefficient: shape (coefficients, rows of design[, population])."""
        population = internal.shape[1:]
        blocks = internal.reshape(len(self.coefficients), -1, 1, *population).swapaxes(0, 1)
        columns = design.T.reshape(*design.T.shape, *(1 for _ in population))
        # term by term: the bytes of one member do not depend on how many others there are
        logarithms = sum(column * block for column, block in zip(columns, blocks, strict=True))
        return np.asarray(np.exp(logarithms))

    def traction(self, internal: FloatArray, at: Observations) -> FloatArray:
        """mu at each point: shape (points,) or (points, population)."""
        sizes = self.sizes(internal, at.design)[:, at.curve]
        return self.value(sizes, at.slip if internal.ndim == 1 else at.slip[:, np.newaxis])

    def jacobian(self, internal: FloatArray, at: Observations) -> FloatArray:
        """Derivatives of mu by each internal constant: shape (points, constants)."""
        sizes = self.sizes(internal, at.design)[:, at.curve]
        _, slopes = self.value_and_slopes(sizes, at.slip)
        rows = at.design[at.curve]
        return np.hstack([slope[:, np.newaxis] * rows for slope in slopes])

    @property
    def local_constants(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(coefficient.name for coefficient in self.coefficients)


@cache
def _graphs(
    equation: str, parts: tuple[tuple[str, str], ...], signs: tuple[tuple[str, int], ...]
) -> tuple[Node, ...]:
    """mu by the sizes |X| and S, and its derivatives by each ln|X|."""
    values = {"S": expression.name("S")}
    for name, sign in signs:
        values[name] = expression.parse("X" if sign > 0 else "-X", {"X": expression.name(name)})
    mu = expression.parse(equation, values, parts)
    return mu, *(expression.logarithmic_derivative(mu, name) for name, _ in signs)


@cache
def _compiled(graphs: tuple[Node, ...], names: tuple[str, ...]) -> Callable[..., Any]:
    return expression.compiled(names, graphs)


@cache
def _to_second_order(
    graphs: tuple[Node, ...], names: tuple[str, ...], by: tuple[int, ...]
) -> Callable[..., Any]:
    """A function that gives mu, its slopes and their slopes, of mu and all its slopes."""
    slopes = [graphs[1 + index] for index in by]
    curvatures = [
        expression.logarithmic_derivative(slope, names[index])
        for row, slope in enumerate(slopes)
        for index in by[: row + 1]
    ]
    return _compiled((graphs[0], *slopes, *curvatures), names)


def to_constants(law: "Law | IndexArray", internal: FloatArray) -> FloatArray:
    """Constants in the form of the law's equation, from the search's form.

    Args:
        law: The law, or the signs of some of its constants.
        internal: Shape (..., constants).
    """
    signs = law.signs if isinstance(law, Law) else law
    return np.where(signs == 0, internal, signs * np.exp(np.where(signs == 0, 0.0, internal)))


def to_internal(law: Law, constants: FloatArray) -> FloatArray:
    """The search's form of a law's constants, shape (..., constants).

    Raises:
        ValueError: A constant has the sign that the law forbids.
    """
    magnitude = np.where(law.signs == 0, 1.0, law.signs * constants)
    if np.any(magnitude <= 0):
        wrong = law.constants[int(np.argwhere(magnitude <= 0)[0][-1])]
        raise ValueError(f"{law.name}: {wrong.name} must be of sign {wrong.sign:+d}")
    return np.where(law.signs == 0, constants, np.log(magnitude))


def bounds(law: Law) -> FloatArray:
    """Search bounds of the internal constants, shape (constants, 2)."""
    return np.array([(constant.lower, constant.upper) for constant in law.constants])
