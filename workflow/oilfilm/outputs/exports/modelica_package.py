"""The law as a Modelica package, in SI units as Modelica's own libraries are."""

import html
from collections.abc import Callable
from dataclasses import dataclass

from oilfilm.outputs.exports.description import Condition, Description
from oilfilm.outputs.exports.header import header, slip_in_words, span
from oilfilm.outputs.exports.names import plain
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import ABSOLUTE_ZERO_C, PA_PER_GPA


@dataclass(frozen=True)
class _Input:
    """A condition as Modelica has it; `in_table_units` is an expression of Modelica."""

    name: str
    unit: str
    attributes: str
    in_table_units: str
    in_si: Callable[[float], float]


_INPUTS = dict(
    zip(
        CONDITIONS,
        (
            _Input(
                "maxHertzPressure",
                "Pa",
                'unit = "Pa", displayUnit = "GPa"',
                f"maxHertzPressure / {PA_PER_GPA:g}",
                lambda pressure: pressure * PA_PER_GPA,
            ),
            _Input("entrainmentSpeed", "m/s", 'unit = "m/s"', "entrainmentSpeed", float),
            _Input(
                "inletTemperature",
                "K",
                'unit = "K", displayUnit = "degC"',
                f"(inletTemperature - {-ABSOLUTE_ZERO_C!r})",
                lambda temperature: temperature - ABSOLUTE_ZERO_C,
            ),
        ),
        strict=True,
    )
)
_SLIP = "slideRollRatio"
_TIMES = "\n      * "  # a factor a line


def modelica_package(description: Description) -> str:
    """A package of two functions: mu, and whether it is extrapolated."""
    name, given = f"Traction_{description.identifier}", description.arguments
    results = [
        "coefficient gives mu, of the sign of S"
        + "; it stops unless pressure, speed and temperature in degC are above 0" * bool(given),
        "outsideTestedBox is true where mu is extrapolated",
    ]
    sentences = [*map(_sentence, given), f"{_SLIP}: {slip_in_words(description)}"]
    information = html.escape(header(description, sentences, results, mark=""))
    inputs = "".join(map(_declaration, given))
    bars = "".join(
        f"    {one.symbol.lower()} := {_INPUTS[one.name].in_table_units} / {one.reference!r};\n"
        for one in given
    )
    positive = " and ".join(f"{one.symbol.lower()} > 0" for one in given)
    complaint = f"{name}: pressure, speed and temperature in degC must be above 0"
    check = f'    assert({positive}, "{complaint}");\n' if given else ""
    local = "".join(
        f"    Real {symbol};\n"
        for symbol in (*(one.symbol.lower() for one in given), *description.powers, "S")
    )
    products = "".join(
        f"    {letter} := {description.product(letter, '{} ^ ({})'.format, _TIMES)};\n"
        for letter in description.powers
    )
    inside = "\n      and ".join(
        [*map(_inside, given), f"abs({_SLIP}) <= {description.slip_upper!r}"]
    )
    simulated = ", SIMULATED DATA" * description.simulated
    return f"""\
package {name} "Traction coefficient of the oil {plain(description.oil)}{simulated}"
  function coefficient "Traction coefficient, odd in the slide-roll ratio"
{inputs}    input Real {_SLIP}(unit = "1") "S, of either sign";
    output Real mu(unit = "1") "Traction force over load, of the sign of S";
  protected
{local}  algorithm
{bars}{check}{products}    S := abs({_SLIP});
    mu := sign({_SLIP}) * ({description.formula});
    annotation(smoothOrder = 1);
  end coefficient;

  function outsideTestedBox "True where the traction coefficient is extrapolated"
{inputs}    input Real {_SLIP}(unit = "1") "S, of either sign";
    output Boolean outside;
  algorithm
    outside := not ({inside});
  end outsideTestedBox;

  annotation(Documentation(info = "<html><pre>
{information}
</pre></html>"));
end {name};
"""


def _sentence(one: Condition) -> str:
    given = _INPUTS[one.name]
    lower, upper = (
        None if value is None else given.in_si(value) for value in (one.lower, one.upper)
    )
    return f"{given.name}: {one.symbol}, {one.meaning}, {given.unit}; {span(lower, upper)}"


def _declaration(one: Condition) -> str:
    given = _INPUTS[one.name]
    return f'    input Real {given.name}({given.attributes}) "{one.symbol}, {one.meaning}";\n'


def _inside(one: Condition) -> str:
    expression = _INPUTS[one.name].in_table_units
    return f"{expression} >= {one.lower!r} and {expression} <= {one.upper!r}"
