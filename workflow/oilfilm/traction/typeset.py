"""A law's equation as mathematics, for the report and the documentation.

Decides: the equation of a law as the report shows it.
"""

from oilfilm.traction.expression import Form, Language, parse_steps
from oilfilm.traction.law import QUANTITIES, Law

DEGREES = "&#176;C"


def _operator(text: str) -> str:
    return f"<mo>{text}</mo>"


def _function(name: str) -> Form:
    return Form(f"<mi>{name}</mi><mo>&#8289;</mo><mrow><mo>(</mo>{{}}<mo>)</mo></mrow>")


MATHML = Language(
    {
        "+": Form(f"{{}}{_operator('+')}{{}}", 1, (1, 2)),
        "-": Form(f"{{}}{_operator('&#8722;')}{{}}", 1, (1, 2)),
        "negative": Form(f"{_operator('&#8722;')}{{}}", 1, (2,)),
        "*": Form(f"{{}}{_operator('&#8290;')}{{}}", 2, (2, 3)),
        "/": Form("<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>", 3, (0, 0)),
        "**": Form("<msup><mrow>{}</mrow><mrow>{}</mrow></msup>", 4, (5, 0)),
        "exp": Form("<msup><mi>e</mi><mrow>{}</mrow></msup>", 4, (0,)),
        "expm1": Form(
            f"<msup><mi>e</mi><mrow>{{}}</mrow></msup>{_operator('&#8722;')}<mn>1</mn>", 1, (0,)
        ),
        "sqrt": Form("<msqrt>{}</msqrt>"),
        "abs": Form("<mrow><mo>|</mo>{}<mo>|</mo></mrow>"),
        "log": _function("ln"),
        "log1p": Form("<mi>ln</mi><mo>(</mo><mn>1</mn><mo>+</mo>{}<mo>)</mo>", 5, (1,)),
        "tanh": _function("tanh"),
        "asinh": _function("arsinh"),
    },
    numeral="<mn>{:g}</mn>".format,
    identifier=lambda name: "<mi>&#956;</mi>" if name == "mu" else f"<mi>{name}</mi>",
    brackets="<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
)


def mathml(law: Law) -> str:
    """The equation, its parts and its power laws, one `math` element per formula.

    X stands for all coefficients but those whose exponents the law gives.
    """
    formulas = [
        f"{MATHML.identifier(name)}<mo>=</mo>{MATHML.write(value)}"
        # mu, then its parts
        for name, value in parse_steps(law.steps, (*law.local_constants, "S"))[::-1]
    ]
    exponents = {
        "X": [f"<msub><mi>X</mi><mn>{1 + at}</mn></msub>" for at in range(len(law.groups))]
    } | {
        each.name: [f"<mn>{exponent:g}</mn>" if exponent else "" for exponent in each.exponents]
        for each in law.coefficients
        if each.exponents is not None
    }
    for name, powers in exponents.items():
        factors = [f"<mi>{name}</mi><mo>=</mo><msub><mi>{name}</mi><mn>0</mn></msub>"]
        for group, reference, power in zip(law.groups, law.reference, powers, strict=True):
            quantity = QUANTITIES[group]
            unit = f"{reference:g} {quantity.unit}".removesuffix(" 1").replace("degC", DEGREES)
            factors.append(
                f"<msup><mrow><mo>(</mo><mfrac><mi>{quantity.symbol}</mi><mtext>{unit}</mtext>"
                f"</mfrac><mo>)</mo></mrow>{power}</msup>"
                if power
                else ""
            )
        formulas.append("".join(factors))
    return " ".join(f'<math display="block"><mrow>{text}</mrow></math>' for text in formulas)
