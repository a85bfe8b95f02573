"""Interface of traction laws. Fitting, exports and the report use laws through it only.

A law gives mu as a function of the slide-roll ratio S and a few coefficients. Each coefficient is a
power law of the operating conditions, or of groups of them. The file of a law has its equation as
text. Values, derivatives, exported code and the typeset equation are made from that text.

Decides: what a law is, and the bounds of its exponents in the search.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache, cached_property
from typing import Any

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.traction import expression
from oilfilm.traction.expression import Node

CONDITIONS = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")

# Largest exponent in the search. No steeper power laws of traction are known.
_LARGEST_EXPONENT = 6.0
# The same for an exponential of T over 20 degC: 0.1 per K. The viscosity of oils, which varies
# most, changes by 0.01 to 0.05 per K between 20 and 120 degC.
_LARGEST_EXPONENTIAL = 2.0


class NoValueError(OilfilmError, ValueError):
    """A law has no value at a condition."""


@dataclass(frozen=True)
class Quantity:
    """A variable of power laws: symbol in equations, meaning, unit."""

    symbol: str
    meaning: str
    unit: str

    @property
    def short_meaning(self) -> str:
        """The meaning without its explanation after the comma."""
        return self.meaning.partition(",")[0]


QUANTITIES = {
    "max_hertz_pressure_gpa": Quantity("P", "maximum Hertz pressure", "GPa"),
    "entrainment_speed_m_s": Quantity("U", "entrainment speed, mean of both surface speeds", "m/s"),
    "inlet_temperature_c": Quantity("T", "oil temperature at the inlet", "degC"),
    "load_n": Quantity("W", "normal load", "N"),
    "dimensionless_load": Quantity("Q", "dimensionless load W/(E' R^2)", "1"),
    "dimensionless_speed": Quantity("V", "dimensionless speed eta0 U/(E' R)", "1"),
    "inlet_viscosity_pa_s": Quantity("eta", "dynamic viscosity at the inlet temperature", "Pa s"),
    "thermal_loading_parameter": Quantity("Z", "thermal loading eta0 beta U^2/k", "1"),
}


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of a law's equation, X = sign * |X0| * (power law of the conditions).

    A group may act as an exponential in place of a power; see `Law.exponential`.

    Attributes:
        name: Name in the equation.
        sign: Sign of X, which is fixed.
        smallest: Smallest |X0| in the search.
        largest: Largest |X0| in the search.
        exponents: Exponents of the power law, if the law prescribes them. X0 is then the only
            constant of the coefficient.
        smallest_start: Smallest |X0| at which a search starts; `smallest` if not given. Far below
            it |X0| has no effect on the residuals.
        multiplies_slip: True if the coefficient multiplies the slip wherever the equation has the
            slip.
    """

    name: str
    sign: int
    smallest: float
    largest: float
    exponents: tuple[float, ...] | None = None
    smallest_start: float | None = None
    multiplies_slip: bool = False


@dataclass(frozen=True)
class Constant:
    """One constant of a law: the X0 of a coefficient, or one of its exponents.

    Attributes:
        name: Name, such as A0 or A1.
        lower: Lower bound of the internal value, which is ln|X0| or the exponent.
        upper: Upper bound of the internal value.
        sign: Sign of X0; 0 for an exponent.
        group: Group that the exponent belongs to; None for X0.
        prescribed: Value of an exponent that the law prescribes, so that it is not fitted.
        smallest_start: Smallest internal value at which a search starts, as
            `Coefficient.smallest_start`; not limited for an exponent.
    """

    name: str
    lower: float
    upper: float
    sign: int = 0
    group: str | None = None
    prescribed: float | None = None
    smallest_start: float = -np.inf


@dataclass(frozen=True)
class Observations:
    """Points at which a law is evaluated, without their mu, in curves of one condition each.

    Attributes:
        design: Rows of `Law.design`, one row per curve.
        curve_of_point: Row of `design` for each point, shape (points,).
        slip: Slide-roll ratio of each point, 0 or more, shape (points,).
    """

    design: FloatArray
    curve_of_point: IndexArray
    slip: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Law:
    """A traction law: mu as a function of its constants, the conditions and the slip.

    `internal` is the form of the constants in the search: ln|X0| and the exponents. Its shape is
    (constants,), or (constants, population) for many sets of constants at once.

    Attributes:
        name: Name in config and tables.
        title: Name in texts; `name` if it is empty.
        source: Author, year, equation.
        equation: mu for S >= 0 as text, by the coefficients and S (`oilfilm.traction.expression`).
        parts: Named parts of the equation, in order: name and text.
        coefficients: The coefficients of the equation. Arrays of coefficients have this order.
        reference: Value of each group at which every power law is 1.
        conditions: Columns of the table of points that the law needs.
        groups: Variables of the power laws. A group is a condition, or a dimensionless combination
            of conditions and of properties of the oil.
        exponential: Groups g that enter as exp(Xi (g/reference - 1)) in place of a power. At the
            reference its slope is that of a power with the exponent Xi.
        varied_conditions_needed: Conditions that must vary, so that the law can be fitted.
        adore: A, B, C and D as text, if the law has the form of the code ADORE,
            (A + B S) exp(-C S) + D.
        nested_law: Law with fewer constants, equal to this law with the further constants at their
            lower bounds. The search also starts from its optimum.
        is_evaluated_in_bearings: Whether bearings are calculated with this law beside the
            campaign's law. It is true for laws on load, which differ from a law on stress in
            bearings.
    """

    name: str
    source: str
    equation: str
    coefficients: tuple[Coefficient, ...]
    reference: tuple[float, ...] = (1.0, 20.0, 20.0)
    conditions: tuple[str, ...] = CONDITIONS
    groups: tuple[str, ...] = CONDITIONS
    exponential: tuple[str, ...] = ()
    parts: tuple[tuple[str, str], ...] = ()
    varied_conditions_needed: tuple[str, ...] = ()
    adore: tuple[str, str, str, str] | None = None
    nested_law: "Law | None" = None
    is_evaluated_in_bearings: bool = False
    title: str = ""

    def __getstate__(self) -> dict[str, Any]:
        # without cached graphs, which are made again from the equation
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def group_values(self, conditions: FloatArray) -> FloatArray:
        """Rows of groups from rows of conditions, shape (rows, groups)."""
        return conditions

    def for_oil(self, oil: Oil | None, contact: Contact | None) -> "Law | None":
        """The law for an oil in a contact; None if the law needs one of them that is not known.

        Args:
            oil: The oil; None if its properties are not known.
            contact: The contact; None if it is not known.
        """
        return self

    def in_contacts(self, radius_m: FloatArray, reduced_modulus_pa: float) -> "Law":
        """The law with its groups for other contacts, one contact per row of conditions.

        Args:
            radius_m: Reduced radius along the rolling direction, shape (rows,).
            reduced_modulus_pa: E' = 2 E*.
        """
        return self

    def unvaried_conditions(self, condition_varies: BoolArray) -> tuple[str, ...]:
        """Conditions that do not vary, although the law can only be fitted where they do.

        Args:
            condition_varies: Whether each of `conditions` varies.
        """
        return tuple(
            name
            for name, varies in zip(self.conditions, condition_varies, strict=True)
            if name in self.varied_conditions_needed and not varies
        )

    def varied_groups(self, condition_varies: BoolArray) -> BoolArray:
        """Whether each group varies, from whether each condition varies.

        Args:
            condition_varies: Whether each of `conditions` varies.

        Raises:
            ValueError: The law cannot be fitted where only these conditions vary.
        """
        unvaried_conditions = self.unvaried_conditions(condition_varies)
        if unvaried_conditions:
            raise ValueError(f"{self.name} needs {' and '.join(unvaried_conditions)} to vary")
        return condition_varies

    def mu_of_magnitudes(self, magnitudes: FloatArray, slip: FloatArray) -> FloatArray:
        """mu from magnitudes |X| of the coefficients, shape (coefficients, ...), at slips (...)."""
        compiled_function = _compile_once(self.graphs[:1], self._arguments)
        (mu,) = compiled_function(*magnitudes, slip)
        return np.asarray(mu)

    def mu_and_slopes(
        self, magnitudes: FloatArray, slip: FloatArray
    ) -> tuple[FloatArray, tuple[FloatArray, ...]]:
        """mu and its derivatives by each ln|X|; they broadcast to the shape of the arguments."""
        compiled_function = _compile_once(self.graphs, self._arguments)
        mu, *slopes = compiled_function(*magnitudes, slip)
        return mu, tuple(slopes)

    def mu_slopes_and_curvatures(
        self, magnitudes: FloatArray, slip: FloatArray, coefficient_indices: tuple[int, ...]
    ) -> tuple[FloatArray, tuple[FloatArray, ...], tuple[FloatArray | float, ...]]:
        """mu, its first and its second derivatives by the ln|X| of some coefficients.

        Args:
            magnitudes: |X| of each coefficient, shape (coefficients, ...).
            slip: Slide-roll ratio, shape (...).
            coefficient_indices: Indices of these coefficients.

        Returns:
            mu; its slopes; the lower triangle of its second derivatives, row by row. A second
            derivative that is zero everywhere is a number.
        """
        compiled_function = _compile_to_second_order(
            self.graphs, self._arguments, coefficient_indices
        )
        mu, *derivatives = compiled_function(*magnitudes, slip)
        slopes = tuple(derivatives[: len(coefficient_indices)])
        curvatures = tuple(derivatives[len(coefficient_indices) :])
        return mu, slopes, curvatures

    @property
    def steps(self) -> tuple[tuple[str, str], ...]:
        """Name and text of each part of the equation, then of mu."""
        return (*self.parts, ("mu", self.equation))

    @property
    def formula(self) -> str:
        """mu and the parts of its equation, as text."""
        parts = "".join(f", {name} = {text}" for name, text in reversed(self.parts))
        return f"mu = {self.equation}{parts}"

    @cached_property
    def graphs(self) -> tuple[Node, ...]:
        """mu by the magnitudes |X| and S, and its derivatives by each ln|X|."""
        signs = tuple((coefficient.name, coefficient.sign) for coefficient in self.coefficients)
        return _graphs(self.equation, self.parts, signs)

    @cached_property
    def is_linear_x0(self) -> BoolArray:
        """For each constant, whether it is the X0 of a coefficient in which mu is linear."""
        is_linear_coefficient = []
        for name, slope in zip(self.coefficient_names, self.graphs[1:], strict=True):
            # mu = X g + h is linear in X: its logarithmic derivative X g is its own derivative
            is_linear_coefficient.append(expression.derivative_by_ln(slope, name) is slope)
        constants_per_coefficient = len(self.constants) // len(self.coefficients)
        is_linear_constant = np.zeros(len(self.constants), dtype=bool)
        is_linear_constant[::constants_per_coefficient] = is_linear_coefficient
        return is_linear_constant

    @cached_property
    def slip_direction(self) -> FloatArray:
        """Direction of the internal constants in which mu changes by S dmu/dS: (constants,)."""
        direction = np.zeros((len(self.coefficients), 1 + len(self.groups)))
        direction[:, 0] = [coefficient.multiplies_slip for coefficient in self.coefficients]
        return direction.ravel()

    @cached_property
    def _arguments(self) -> tuple[str, ...]:
        """Names of the arguments of compiled functions."""
        return (*self.coefficient_names, "S")

    @cached_property
    def constants(self) -> tuple[Constant, ...]:
        """X0 and the exponents of each coefficient. Arrays of constants have this order."""
        constants: list[Constant] = []
        for coefficient in self.coefficients:
            lower, upper = np.log([coefficient.smallest, coefficient.largest])
            constants.append(
                Constant(
                    name=f"{coefficient.name}0",
                    lower=lower,
                    upper=upper,
                    sign=coefficient.sign,
                    smallest_start=np.log(coefficient.smallest_start or coefficient.smallest),
                )
            )
            exponents = coefficient.exponents or (None,) * len(self.groups)
            for group_index, group in enumerate(self.groups):
                is_exponential = group in self.exponential
                largest_exponent = _LARGEST_EXPONENTIAL if is_exponential else _LARGEST_EXPONENT
                constants.append(
                    Constant(
                        name=f"{coefficient.name}{group_index + 1}",
                        lower=-largest_exponent,
                        upper=largest_exponent,
                        group=group,
                        prescribed=exponents[group_index],
                    )
                )
        return tuple(constants)

    @cached_property
    def signs(self) -> IndexArray:
        """Sign of each constant, shape (constants,); 0 for exponents."""
        return np.array([constant.sign for constant in self.constants])

    @cached_property
    def prescribed(self) -> FloatArray:
        """Internal constants with the exponents that the law prescribes, and 0 elsewhere."""
        return np.array([constant.prescribed or 0.0 for constant in self.constants])

    def log_terms(self, groups: FloatArray) -> FloatArray:
        """Change of ln|X| per unit of each exponent, shape (..., groups); 0 at the reference.

        It is ln(g/reference) of a power, NaN where g is not above zero, and g/reference - 1 of an
        exponential.

        Args:
            groups: Values of the groups, shape (..., groups).
        """
        relative_groups = np.asarray(groups / np.array(self.reference))
        logarithms = np.log(
            relative_groups, out=np.full(relative_groups.shape, np.nan), where=relative_groups > 0
        )
        return np.where(self._is_exponential, relative_groups - 1, logarithms)

    def design(
        self, conditions: FloatArray, group_has_exponent: BoolArray | None = None
    ) -> FloatArray:
        """Design matrix of the power laws: rows of 1 and the terms of the groups (`log_terms`).

        Args:
            conditions: Shape (rows, conditions).
            group_has_exponent: Whether the power laws follow each group by an exponent; the others
                have their reference value. All groups are followed if it is not given.

        Returns:
            Shape (rows, groups + 1).

        Raises:
            NoValueError: A group is not above zero, so that its power has no value.
        """
        condition_rows = np.atleast_2d(conditions)
        terms = self.log_terms(self.group_values(condition_rows))
        if group_has_exponent is not None:
            terms = np.where(group_has_exponent, terms, 0.0)
        has_no_value = np.isnan(terms)
        if has_no_value.any():
            first_row = int(has_no_value.any(axis=1).argmax())
            groups_without_value = ", ".join(np.array(self.groups)[has_no_value[first_row]])
            values = ", ".join(f"{value:g}" for value in condition_rows[first_row])
            raise NoValueError(
                f"{self.name} needs {groups_without_value} above zero; found {values} "
                f"({', '.join(self.conditions)})"
            )
        return np.column_stack([np.ones(len(terms)), terms])

    def magnitudes(self, internal: FloatArray, design: FloatArray) -> FloatArray:
        """|X| of each coefficient, shape (coefficients, rows of design[, population])."""
        population_shape = internal.shape[1:]
        # first axis: terms of the power laws, that is X0 and the exponents
        constants = internal.reshape(len(self.coefficients), -1, 1, *population_shape).swapaxes(
            0, 1
        )
        design_columns = design.T.reshape(*design.T.shape, *(1,) * len(population_shape))
        # summed term by term, so that a result does not depend on the size of the population
        logarithms = sum(
            column * constant for column, constant in zip(design_columns, constants, strict=True)
        )
        return np.asarray(np.exp(logarithms))

    def traction(self, internal: FloatArray, observations: Observations) -> FloatArray:
        """mu at each point, shape (points,) or (points, population)."""
        magnitudes = self.magnitudes(internal, observations.design)[:, observations.curve_of_point]
        slip = observations.slip
        return self.mu_of_magnitudes(
            magnitudes, slip if internal.ndim == 1 else slip[:, np.newaxis]
        )

    def jacobian(self, internal: FloatArray, observations: Observations) -> FloatArray:
        """Derivatives of mu by each internal constant, shape (points, constants)."""
        magnitudes = self.magnitudes(internal, observations.design)[:, observations.curve_of_point]
        _, slopes = self.mu_and_slopes(magnitudes, observations.slip)
        design_rows = observations.design[observations.curve_of_point]
        return np.hstack([slope[:, np.newaxis] * design_rows for slope in slopes])

    @cached_property
    def _is_exponential(self) -> BoolArray:
        """Whether each group is an exponential, shape (groups,)."""
        return np.array([group in self.exponential for group in self.groups])

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(coefficient.name for coefficient in self.coefficients)


@cache
def _graphs(
    equation: str, named_parts: tuple[tuple[str, str], ...], signs: tuple[tuple[str, int], ...]
) -> tuple[Node, ...]:
    """Graphs of mu and of its derivatives by each ln|X|, with the magnitudes |X| and S as names."""
    node_by_name = {"S": expression.name_node("S")}
    for name, sign in signs:
        node_by_name[name] = expression.parse(
            "X" if sign > 0 else "-X", {"X": expression.name_node(name)}
        )
    mu = expression.parse(equation, node_by_name, named_parts)
    derivatives = [expression.derivative_by_ln(mu, name) for name, _ in signs]
    return (mu, *derivatives)


@cache
def _compile_once(graphs: tuple[Node, ...], argument_names: tuple[str, ...]) -> Callable[..., Any]:
    """The compiled function of these graphs, made once."""
    return expression.compile_function(argument_names, graphs)


@cache
def _compile_to_second_order(
    graphs: tuple[Node, ...], argument_names: tuple[str, ...], coefficient_indices: tuple[int, ...]
) -> Callable[..., Any]:
    """Compiled function of mu, its slopes by some coefficients, and their second derivatives.

    Args:
        graphs: Graphs of mu and of its slopes by all coefficients.
        argument_names: Arguments of the function.
        coefficient_indices: Indices of the coefficients.
    """
    slopes = [graphs[1 + index] for index in coefficient_indices]
    curvatures = []
    for slope_index, slope in enumerate(slopes):
        for index in coefficient_indices[: slope_index + 1]:
            curvatures.append(expression.derivative_by_ln(slope, argument_names[index]))
    return _compile_once((graphs[0], *slopes, *curvatures), argument_names)


def to_constants(law_or_signs: "Law | IndexArray", internal: FloatArray) -> FloatArray:
    """Constants of a law's equation from internal constants, shape (..., constants).

    Args:
        law_or_signs: The law, or the signs of some of its constants.
        internal: Internal constants, shape (..., constants).
    """
    signs = law_or_signs.signs if isinstance(law_or_signs, Law) else law_or_signs
    logarithms = np.where(signs == 0, 0.0, internal)
    return np.where(signs == 0, internal, signs * np.exp(logarithms))


def to_internal(law: Law, constants: FloatArray) -> FloatArray:
    """Internal constants from the constants of a law's equation, shape (..., constants).

    The search works on internal constants: ln|X0| in place of each X0, and the exponents as they
    are.

    Args:
        law: The law.
        constants: X0 with its sign, then the exponents, of each coefficient, in the order of
            `Law.constants`, shape (..., constants).

    Raises:
        ValueError: A constant has the sign that the law forbids.
    """
    magnitude = np.where(law.signs == 0, 1.0, law.signs * constants)
    if np.any(magnitude <= 0):
        first_wrong = np.argwhere(magnitude <= 0)[0]
        constant = law.constants[int(first_wrong[-1])]
        raise ValueError(f"{law.name}: {constant.name} must be of sign {constant.sign:+d}")
    return np.where(law.signs == 0, constants, np.log(magnitude))


def bounds(law: Law) -> FloatArray:
    """Search bounds of the internal constants, shape (constants, 2)."""
    return np.array([(constant.lower, constant.upper) for constant in law.constants])
