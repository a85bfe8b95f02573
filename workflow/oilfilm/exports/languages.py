"""The law as source code: a template and the forms of expressions for each language.

Decides: how an exported function is written in C, Fortran, MATLAB, Modelica and Python.
"""

import html
import textwrap
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined

from oilfilm.base.units import ABSOLUTE_ZERO_C, PA_PER_GPA
from oilfilm.exports.description import SLIP, Description, LawVariable, plain_text, range_text
from oilfilm.traction.expression import Form, Language, function_names

_EXPRESSION_WIDTH = 88  # leaves room for indentation within Fortran's 132 columns
_NUMPY_FUNCTIONS = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "abs", "sign")
_LABEL_OF_DATA = {"simulated": ", SIMULATED DATA", "printed": ", PRINTED CONSTANTS", "measured": ""}

TEMPLATE_ENVIRONMENT = Environment(
    loader=PackageLoader("oilfilm.exports"),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
    autoescape=False,  # noqa: S701 - source code, whose names and texts `plain_text` has cleaned
)
# For pages in Markdown, where HTML has an effect.
TEMPLATE_ENVIRONMENT.filters["escape_html"] = partial(html.escape, quote=False)


class _SiInput(NamedTuple):
    """An argument in SI units, for Modelica: `factor` times its value in tables, plus `offset`.

    Attributes:
        name: Name of the argument.
        unit: Unit of the argument.
        shown_unit: Unit that a Modelica tool shows.
        factor: SI units per unit of the tables.
        offset: Zero of the unit of the tables, in SI units.
    """

    name: str
    unit: str
    shown_unit: str = ""
    factor: float = 1.0
    offset: float = 0.0

    @property
    def in_table_units(self) -> str:
        """Its value in the unit of the tables, as an expression of Modelica."""
        if self.factor != 1:
            return f"({self.name} / {self.factor:g})"
        return f"({self.name} - {self.offset!r})" if self.offset else self.name

    def sentence(self, argument: LawVariable) -> str:
        """Name, meaning, unit and tested range."""
        lower, upper = argument.tested
        tested = range_text(self._in_si(lower), self._in_si(upper))
        return f"{self.name}: {argument.symbol}, {argument.meaning}, {self.unit}; {tested}"

    def _in_si(self, value: float | None) -> float | None:
        """A value in the unit of the tables, in SI units; None where it is unknown."""
        return None if value is None else self.factor * value + self.offset


_SI_INPUTS = {
    "max_hertz_pressure_gpa": _SiInput("maxHertzPressure", "Pa", "GPa", factor=PA_PER_GPA),
    "entrainment_speed_m_s": _SiInput("entrainmentSpeed", "m/s"),
    "inlet_temperature_c": _SiInput("inletTemperature", "K", "degC", offset=-ABSOLUTE_ZERO_C),
    "load_n": _SiInput("normalLoad", "N"),
    "dimensionless_load": _SiInput("dimensionlessLoad", "1"),
    "dimensionless_speed": _SiInput("dimensionlessSpeed", "1"),
    "inlet_viscosity_pa_s": _SiInput("inletViscosity", "Pa.s"),
    "thermal_loading_parameter": _SiInput("thermalLoadingParameter", "1"),
    SLIP: _SiInput("slideRollRatio", "1"),
}


def _modelica_name(name: str) -> str:
    """A name in Modelica. Arguments there are in SI units; an argument is converted back."""
    return _SI_INPUTS[name].in_table_units if name in _SI_INPUTS else name


def _fortran_name(name: str) -> str:
    """A name in Fortran, which takes n and N for the same name: a small letter gets a suffix."""
    return f"{name}_" if len(name) == 1 and name.islower() else name


@dataclass(frozen=True)
class TargetLanguage:
    """A language in which the functions of a law are written.

    Attributes:
        template: File of its template, without `.jinja`.
        expression_forms: How the language writes expressions.
        line_break: Text between two lines of one expression.
    """

    template: str
    expression_forms: Language
    line_break: str = "\n        "

    def source(self, description: Description) -> str:
        """The source code of two functions: mu, and whether it is extrapolated."""
        steps = description.steps()
        used_functions = function_names([value for _, value in steps])
        arguments = description.arguments
        return TEMPLATE_ENVIRONMENT.get_template(f"{self.template}.jinja").render(
            name=description.identifier,
            oil=plain_text(description.oil),
            data_label=_LABEL_OF_DATA[description.kind_of_data],
            arguments=arguments,
            argument_names=description.argument_names,
            power_arguments=description.power_arguments,
            power_meanings=description.power_meanings,
            slip=SLIP,
            largest_tested_slip=description.slip_variable.tested[1],
            limiting_stress_ratio=repr(description.limiting_stress_ratio),
            marked_where="mu is extrapolated or its size is above "
            f"{description.limiting_stress_ratio:g}, the oil's limiting shear stress over the "
            "pressure",
            steps=[
                (
                    self.expression_forms.write_name(name),
                    self._wrapped(self.expression_forms.write(value)),
                )
                for name, value in steps
            ],
            uses_function=lambda *names: not used_functions.isdisjoint(names),
            head=partial(description.header, description.argument_sentences),
            head_si=partial(description.header, _si_sentences(description)),
            result_sentence=partial(_result_sentence, description),
            box_comparisons=partial(self._box_comparisons, description),
            si_input=lambda argument: _SI_INPUTS[argument.name],
        )

    def _wrapped(self, expression: str) -> str:
        """An expression on several lines, broken at blanks, which all languages allow."""
        lines = textwrap.wrap(expression, _EXPRESSION_WIDTH, break_on_hyphens=False)
        return self.line_break.join(lines)

    def _box_comparisons(
        self, description: Description, and_operator: str, absolute_function: str
    ) -> list[str]:
        """The comparisons of the tested box, one text per argument.

        Args:
            description: The fit.
            and_operator: The language's "and".
            absolute_function: The language's function of the absolute value.
        """
        comparisons = []
        for argument in description.arguments:
            lower, upper = argument.tested
            comparisons.append(
                f"{argument.name} >= {self._number(lower)} {and_operator} "
                f"{argument.name} <= {self._number(upper)}"
            )
        largest_slip = self._number(description.slip_variable.tested[1])
        comparisons.append(f"{absolute_function}({SLIP}) <= {largest_slip}")
        return comparisons

    def _number(self, value: float | None) -> str:
        """A number as the language writes it; the text `None` where it is unknown."""
        return repr(value) if value is None else self.expression_forms.write_number(value)


def _result_sentence(description: Description, no_value: str) -> str:
    """A sentence on the result of the function; `no_value` is its result without a mu."""
    if not description.power_arguments:
        return "mu, of the sign of S"
    return f"mu, of the sign of S; {no_value} unless {description.power_meanings} are above 0"


def _si_sentences(description: Description) -> list[str]:
    """One sentence per argument, in SI units."""
    sentences = [_SI_INPUTS[argument.name].sentence(argument) for argument in description.arguments]
    sentences.append(f"{_SI_INPUTS[SLIP].name}: {description.slip_range}")
    return sentences


C_LANGUAGE = TargetLanguage("c.h", Language({"**": Form("pow({}, {})"), "abs": Form("fabs({})")}))
FORTRAN = TargetLanguage(
    "fortran.f90",
    Language(
        {"sign": Form("sign(1.0_dp, {})")}, write_number="{!r}_dp".format, write_name=_fortran_name
    ),
    " &\n        ",
)
MATLAB = TargetLanguage(
    "matlab.m",
    Language(
        {
            "*": Form("{} .* {}", 2, (2, 3)),
            "/": Form("{} ./ {}", 2, (2, 3)),
            "**": Form("{} .^ {}", 4, (5, 5)),
        }
    ),
    " ...\n    ",
)
MODELICA = TargetLanguage(
    "modelica.mo", Language({"**": Form("{} ^ {}", 4, (5, 5))}, write_name=_modelica_name)
)
PYTHON = TargetLanguage(
    "python.py",
    Language(
        {name: Form(f"np.{name}({{}})") for name in _NUMPY_FUNCTIONS}
        | {"asinh": Form("np.arcsinh({})")}
    ),
    " \\\n        ",
)
