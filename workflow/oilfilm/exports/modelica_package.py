"""The law as a Modelica package, in SI units as Modelica's own libraries are."""

import html
from dataclasses import dataclass

from oilfilm.exports.code import assignments, helpers, result, variables
from oilfilm.exports.description import SLIP, Condition, Description
from oilfilm.exports.header import header, slip_range, span
from oilfilm.exports.names import plain
from oilfilm.traction.expression import Form, Language
from oilfilm.units import ABSOLUTE_ZERO_C, PA_PER_GPA


@dataclass(frozen=True)
class _Input:
    """A condition in SI units: `factor` times its value in the tables, plus `offset`."""

    name: str
    unit: str
    shown_unit: str = ""
    factor: float = 1.0
    offset: float = 0.0

    @property
    def attributes(self) -> str:
        """Attributes of its declaration."""
        shown = f', displayUnit = "{self.shown_unit}"' if self.shown_unit else ""
        return f'unit = "{self.unit}"{shown}'

    @property
    def in_table_units(self) -> str:
        """Its value in the unit of the tables, as an expression of Modelica."""
        if self.factor != 1:
            return f"({self.name} / {self.factor:g})"
        return f"({self.name} - {self.offset!r})" if self.offset else self.name


_INPUTS = {
    "max_hertz_pressure_gpa": _Input("maxHertzPressure", "Pa", "GPa", factor=PA_PER_GPA),
    "entrainment_speed_m_s": _Input("entrainmentSpeed", "m/s"),
    "inlet_temperature_c": _Input("inletTemperature", "K", "degC", offset=-ABSOLUTE_ZERO_C),
    "load_n": _Input("normalLoad", "N"),
    "dimensionless_load": _Input("dimensionlessLoad", "1"),
    "dimensionless_speed": _Input("dimensionlessSpeed", "1"),
    "thermal_loading_parameter": _Input("thermalLoadingParameter", "1"),
}
_SLIP = "slideRollRatio"
# The package's text for names of the tables.
_NAMES = {SLIP: _SLIP} | {name: given.in_table_units for name, given in _INPUTS.items()}

MODELICA = Language(
    {"**": Form("{} ^ {}", 4, (5, 5))},
    identifier=lambda name: _NAMES.get(name, name),
)
# Modelica itself has none of the three; all without cancellation at small x.
_HELPERS = {
    "expm1": """
  function expm1 "exp(x) - 1"
    input Real x;
    output Real y;
  protected
    Real t;
  algorithm
    t := tanh(x / 2);
    y := if x > 0.5 then exp(x) - 1 else 2 * t / (1 - t);
  end expm1;
""",
    "asinh": """
  function asinh "Inverse hyperbolic sine"
    input Real x;
    output Real y;
  algorithm
    y := log1p(abs(x) + x ^ 2 / (1 + sqrt(1 + x ^ 2)));
    y := if x < 0 then -y else y;
  end asinh;
""",
    "log1p": """
  function log1p "log(1 + x)"
    input Real x;
    output Real y;
  protected
    Real u;
  algorithm
    u := 1 + x;
    y := if abs(u - 1) > 0 then x * log(u) / (u - 1) else x;
  end log1p;
""",
}


def modelica_package(description: Description) -> str:
    """A package of two functions: mu, and whether it is extrapolated."""
    name, given = f"Traction_{description.identifier}", description.arguments
    results = [
        f"coefficient gives {result(description, 'it stops')}; temperatures count in degC",
        "outsideTestedBox is true where mu is extrapolated",
    ]
    sentences = [*map(_sentence, given), f"{_SLIP}: {slip_range(description)}"]
    information = html.escape(header(description, sentences, results, mark=""))
    inputs = "".join(map(_declaration, given))
    *steps, mu = variables(description, MODELICA)
    local = "".join(f"    Real {step};\n" for step in steps)
    values = assignments(description, MODELICA, "    {} := {};\n")
    inside = "\n      and ".join(
        [*map(_inside, given), f"abs({_SLIP}) <= {description.slip.tested[1]!r}"]
    )
    label = {"simulated": ", SIMULATED DATA", "printed": ", PRINTED CONSTANTS", "measured": ""}
    return f"""\
package {name} "Traction coefficient of the oil {plain(description.oil)}{label[description.data]}"
  function coefficient "Traction coefficient, odd in the slide-roll ratio"
{inputs}    input Real {_SLIP}(unit = "1") "S, of either sign";
    output Real mu(unit = "1") "Traction force over load, of the sign of S";
  protected
{local}  algorithm
{_check(description)}{values}    {mu} := if {_SLIP} < 0 then -{mu} else {mu};
  end coefficient;

  function outsideTestedBox "True where the traction coefficient is extrapolated"
{inputs}    input Real {_SLIP}(unit = "1") "S, of either sign";
    output Boolean outside;
  algorithm
    outside := not ({inside});
  end outsideTestedBox;
{helpers(description, _HELPERS)}
  annotation(Documentation(info = "<html><pre>
{information}
</pre></html>"));
end {name};
"""


def _check(description: Description) -> str:
    """What stops a simulation where the law has no value."""
    if not description.arguments:
        return ""
    positive = " and ".join(f"{_NAMES[condition.name]} > 0" for condition in description.arguments)
    meaning = f"{description.argument_meanings} must be above 0, temperatures in degC"
    return f'    assert({positive}, "Traction_{description.identifier}: {meaning}");\n'


def _sentence(condition: Condition) -> str:
    given = _INPUTS[condition.name]
    tested = (
        None if end is None else given.factor * end + given.offset for end in condition.tested
    )
    meaning = f"{condition.symbol}, {condition.meaning}"
    return f"{given.name}: {meaning}, {given.unit}; {span(*tested)}"


def _declaration(condition: Condition) -> str:
    given = _INPUTS[condition.name]
    meaning = f"{condition.symbol}, {condition.meaning}"
    return f'    input Real {given.name}({given.attributes}) "{meaning}";\n'


def _inside(condition: Condition) -> str:
    value = _NAMES[condition.name]
    lower, upper = condition.tested
    return f"{value} >= {lower!r} and {value} <= {upper!r}"
