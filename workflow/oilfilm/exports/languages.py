"""The law as source code: one template per language, and how each writes the law's expression.

Decides: how an exported function is written in C, Fortran, MATLAB, Modelica and Python.
"""

import html
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined

from oilfilm.base.units import ABSOLUTE_ZERO_C, PA_PER_GPA
from oilfilm.exports.description import SLIP, Condition, Description, plain, span
from oilfilm.traction.expression import Form, Language, functions_of

_WIDTH = 88  # leaves room for indentation within Fortran's 132 columns
_NUMPY = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "abs", "sign")
_LABELS = {"simulated": ", SIMULATED DATA", "printed": ", PRINTED CONSTANTS", "measured": ""}

TEMPLATES = Environment(
    loader=PackageLoader("oilfilm.exports"),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
    autoescape=False,  # noqa: S701 - source code, whose names and texts `plain` has cleaned
)
# Of pages in Markdown, which may hold HTML.
TEMPLATES.filters["shown"] = partial(html.escape, quote=False)


class _Input(NamedTuple):
    """A condition in SI units, as Modelica has it: `factor` times its value, plus `offset`."""

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

    def sentence(self, condition: Condition) -> str:
        """Name, meaning, unit and tested range."""
        ends = (e if e is None else self.factor * e + self.offset for e in condition.tested)
        return f"{self.name}: {condition.symbol}, {condition.meaning}, {self.unit}; {span(*ends)}"


_SI = {
    "max_hertz_pressure_gpa": _Input("maxHertzPressure", "Pa", "GPa", factor=PA_PER_GPA),
    "entrainment_speed_m_s": _Input("entrainmentSpeed", "m/s"),
    "inlet_temperature_c": _Input("inletTemperature", "K", "degC", offset=-ABSOLUTE_ZERO_C),
    "load_n": _Input("normalLoad", "N"),
    "dimensionless_load": _Input("dimensionlessLoad", "1"),
    "dimensionless_speed": _Input("dimensionlessSpeed", "1"),
    "thermal_loading_parameter": _Input("thermalLoadingParameter", "1"),
    SLIP: _Input("slideRollRatio", "1"),
}


def _modelica_name(name: str) -> str:
    return _SI[name].in_table_units if name in _SI else name


def _fortran_name(name: str) -> str:
    """Fortran takes n and N for the same name."""
    return f"{name}_" if len(name) == 1 and name.islower() else name


@dataclass(frozen=True)
class Target:
    """A language: its template, how expressions look in it, and how a long line is continued."""

    template: str
    language: Language
    continued: str = "\n        "

    def source(self, description: Description) -> str:
        """The functions of a law: mu, and whether it is extrapolated."""
        values = [value for _, value in description.steps()]
        given = description.arguments
        return TEMPLATES.get_template(f"{self.template}.jinja").render(
            name=description.identifier,
            oil=plain(description.oil),
            label=_LABELS[description.data],
            given=given,
            names=description.argument_names,
            meanings=given and description.argument_meanings,
            slip=SLIP,
            slip_end=description.slip.tested[1],
            limit=repr(description.limit),
            marked="mu is extrapolated or its size is above "
            f"{description.limit:g}, the oil's limiting shear stress over the pressure",
            steps=[
                (self.language.identifier(name), self._wrapped(self.language.write(value)))
                for name, value in description.steps()
            ],
            needs=lambda *functions: not functions_of(values).isdisjoint(functions),
            head=partial(description.header, description.argument_sentences),
            head_si=partial(description.header, _si_sentences(description)),
            result=partial(_result, description),
            box=partial(self._box, description),
            si=lambda condition: _SI[condition.name],
        )

    def _wrapped(self, value: str) -> str:
        # outside names and numbers the languages do not mind where a line breaks
        return self.continued.join(textwrap.wrap(value, _WIDTH, break_on_hyphens=False))

    def _box(self, description: Description, both: str, size: str) -> list[str]:
        """The conditions of the tested box, one per argument, with the language's "and"."""

        def between(condition: Condition) -> str:
            lower, upper = map(self._number, condition.tested)
            return f"{condition.name} >= {lower} {both} {condition.name} <= {upper}"

        sides = map(between, description.arguments)
        return [*sides, f"{size}({SLIP}) <= {self._number(description.slip.tested[1])}"]

    def _number(self, end: float | None) -> str:
        return repr(end) if end is None else self.language.numeral(end)


def _result(description: Description, without: str) -> str:
    """What is given back, and what the function does (`without`) where the law has no value."""
    if not description.arguments:
        return "mu, of the sign of S"
    return f"mu, of the sign of S; {without} unless {description.argument_meanings} are above 0"


def _si_sentences(description: Description) -> Sequence[str]:
    named = [_SI[each.name].sentence(each) for each in description.arguments]
    return [*named, f"{_SI[SLIP].name}: {description.slip_range}"]


C = Target("c.h", Language({"**": Form("pow({}, {})"), "abs": Form("fabs({})")}))
FORTRAN = Target(
    "fortran.f90",
    Language(
        {"sign": Form("sign(1.0_dp, {})")}, numeral="{!r}_dp".format, identifier=_fortran_name
    ),
    " &\n        ",
)
MATLAB = Target(
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
MODELICA = Target(
    "modelica.mo", Language({"**": Form("{} ^ {}", 4, (5, 5))}, identifier=_modelica_name)
)
PYTHON = Target(
    "python.py",
    Language(
        {name: Form(f"np.{name}({{}})") for name in _NUMPY} | {"asinh": Form("np.arcsinh({})")}
    ),
    " \\\n        ",
)
