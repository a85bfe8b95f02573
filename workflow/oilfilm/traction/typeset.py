"""A law's equation as mathematics, for the report and the documentation.

Decides: the equation of a law as the report shows it.
"""

from oilfilm.traction.expression import Form, Language, parse_steps
from oilfilm.traction.law import QUANTITIES, Law

_DEGREE_CELSIUS = "&#176;C"


def _operator(text: str) -> str:
    """An operator in MathML."""
    return f"<mo>{text}</mo>"


def _function(name: str) -> Form:
    """A named function in MathML, with brackets around its argument."""
    return Form(f"<mi>{name}</mi><mo>&#8289;</mo><mrow><mo>(</mo>{{}}<mo>)</mo></mrow>")


# Euler's number is upright, so that it differs from a part of a law that is called e.
_EULER = '<mi mathvariant="normal">e</mi>'
_GREEK = {"mu": "&#956;", "eta": "&#951;"}


def _identifier(name: str) -> str:
    """A name in MathML."""
    return f"<mi>{_GREEK.get(name, name)}</mi>"


def _number(value: float) -> str:
    """A number in MathML, with powers of ten as `10` and exponent."""
    mantissa, _, exponent = f"{value:g}".partition("e")
    if not exponent:
        return f"<mn>{mantissa}</mn>"
    power_of_ten = f"<msup><mn>10</mn><mn>{int(exponent)}</mn></msup>"
    if mantissa == "1":
        return power_of_ten
    return f"<mrow><mn>{mantissa}</mn>{_operator('&#215;')}{power_of_ten}</mrow>"


MATHML = Language(
    {
        "+": Form(f"{{}}{_operator('+')}{{}}", 1, (1, 2)),
        "-": Form(f"{{}}{_operator('&#8722;')}{{}}", 1, (1, 2)),
        "negative": Form(f"{_operator('&#8722;')}{{}}", 1, (2,)),
        "*": Form(f"{{}}{_operator('&#8290;')}{{}}", 2, (2, 3)),
        "/": Form("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", 3, (0, 0)),
        "**": Form("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", 4, (5, 0)),
        "exp": Form(f"<msup>{_EULER}<mrow>{{}}</mrow></msup>", 4, (0,)),
        "expm1": Form(
            f"<msup>{_EULER}<mrow>{{}}</mrow></msup>{_operator('&#8722;')}<mn>1</mn>", 1, (0,)
        ),
        "sqrt": Form("<msqrt>{}</msqrt>"),
        "abs": Form("<mrow><mo>|</mo>{}<mo>|</mo></mrow>"),
        "log": _function("ln"),
        "log1p": Form("<mi>ln</mi><mo>(</mo><mn>1</mn><mo>+</mo>{}<mo>)</mo>", 5, (1,)),
        "tanh": _function("tanh"),
        "asinh": _function("arsinh"),
    },
    write_number=_number,
    write_name=_identifier,
    brackets="<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
)


# Factors of a coefficient: relative group and exponent, exponent and relative group.
_POWER = "<msup><mrow><mo>(</mo>{}<mo>)</mo></mrow>{}</msup>"
_EXPONENTIAL = (
    f"<msup>{_EULER}<mrow>{{}}<mo>(</mo>{{}}{_operator('&#8722;')}<mn>1</mn><mo>)</mo></mrow>"
    "</msup>"
)


def mathml(law: Law) -> str:
    """The equation, its parts and its power laws, one `math` element per formula.

    X is any coefficient whose exponents are fitted.
    """
    steps = parse_steps(law.steps, (*law.coefficient_names, "S"))
    # mu first, then its parts
    formulas = [
        f"{MATHML.write_name(name)}<mo>=</mo>{MATHML.write(value)}"
        for name, value in reversed(steps)
    ]
    fitted_exponents = [
        f"<msub><mi>X</mi><mn>{number}</mn></msub>" for number in range(1, len(law.groups) + 1)
    ]
    formulas.append(_power_law(law, "X", fitted_exponents))
    for coefficient in law.coefficients:
        if coefficient.exponents is not None:
            exponent_texts = [
                _number(exponent) if exponent else "" for exponent in coefficient.exponents
            ]
            formulas.append(_power_law(law, coefficient.name, exponent_texts))
    return " ".join(f'<math display="block"><mrow>{text}</mrow></math>' for text in formulas)


def _power_law(law: Law, coefficient_name: str, exponent_texts: list[str]) -> str:
    """The power law of a coefficient in MathML, without groups whose exponent is empty."""
    factors = [
        f"<mi>{coefficient_name}</mi><mo>=</mo><msub><mi>{coefficient_name}</mi><mn>0</mn></msub>"
    ]
    for group, reference, exponent_text in zip(
        law.groups, law.reference, exponent_texts, strict=True
    ):
        if not exponent_text:
            continue
        quantity = QUANTITIES[group]
        reference_value = _number(reference)
        if quantity.unit != "1":
            unit = quantity.unit.replace("degC", _DEGREE_CELSIUS)
            reference_value = f"<mrow>{reference_value}<mtext>&#160;{unit}</mtext></mrow>"
        relative_group = f"<mfrac>{_identifier(quantity.symbol)}{reference_value}</mfrac>"
        if group in law.exponential:
            factors.append(_EXPONENTIAL.format(exponent_text, relative_group))
        else:
            factors.append(_POWER.format(relative_group, exponent_text))
    return "".join(factors)
