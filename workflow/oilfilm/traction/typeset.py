"""A law's equation as mathematics: MathML for the report, LaTeX for the documentation.

Decides: the equation of a law as the report shows it.
"""

from oilfilm.traction.expression import Form, Language
from oilfilm.traction.law import QUANTITIES, Law

DEGREES = "&#176;C"
LATEX = Language(
    {
        "*": Form(r"{}\,{}", 2, (2, 3)),
        "/": Form(r"\frac{{{}}}{{{}}}", 3, (0, 0)),
        "**": Form("{}^{{{}}}", 4, (5, 0)),
        "exp": Form(r"\mathrm{{e}}^{{{}}}", 4, (0,)),
        "expm1": Form(r"\mathrm{{e}}^{{{}}} - 1", 1, (0,)),
        "log1p": Form(r"\ln\left(1 + {}\right)", 5, (1,)),
        "log": Form(r"\ln\left({}\right)"),
        "sqrt": Form(r"\sqrt{{{}}}"),
        "tanh": Form(r"\tanh\left({}\right)"),
        "asinh": Form(r"\operatorname{{arsinh}}\left({}\right)"),
        "abs": Form(r"\left|{}\right|"),
    },
    numeral="{:g}".format,
    identifier=lambda name: rf"\{name}" if name == "mu" else name,
    brackets=r"\left({}\right)",
)


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


def latex(law: Law) -> list[str]:
    """The equation, its parts and its power laws, one LaTeX formula each."""
    equations = [
        rf"{LATEX.identifier(name)} = {LATEX.write(value)}" for name, value in law.definitions()
    ]
    for coefficient, factors in _power_laws(law).items():
        powers = "".join(
            rf" \left(\frac{{{symbol}}}{{\text{{{reference}}}}}\right)^{{{exponent}}}"
            for symbol, reference, exponent in factors
        )
        equations.append(f"{coefficient} = {coefficient}_0{powers}")
    return equations


def mathml(law: Law) -> str:
    """The same as MathML, one `math` element per formula; made of our own text only."""
    formulas = [
        f"{MATHML.identifier(name)}<mo>=</mo>{MATHML.write(value)}"
        for name, value in law.definitions()
    ]
    for coefficient, factors in _power_laws(law).items():
        powers = "".join(
            f"<msup><mrow><mo>(</mo><mfrac><mi>{symbol}</mi>"
            f"<mtext>{reference.replace('degC', DEGREES)}</mtext></mfrac>"
            f"<mo>)</mo></mrow>{_exponent(exponent)}</msup>"
            for symbol, reference, exponent in factors
        )
        head = f"<mi>{coefficient}</mi><mo>=</mo><msub><mi>{coefficient}</mi><mn>0</mn></msub>"
        formulas.append(head + powers)
    return " ".join(f'<math display="block"><mrow>{text}</mrow></math>' for text in formulas)


def _exponent(text: str) -> str:
    """A number, or a constant such as X1 with its number as index."""
    if text[0].isalpha():
        return f"<msub><mi>{text[0]}</mi><mn>{text[1:]}</mn></msub>"
    return f"<mn>{text}</mn>"


def _power_laws(law: Law) -> dict[str, list[tuple[str, str, str]]]:
    """X for all coefficients, then those whose exponents the law gives, by name.

    Each with its factors: symbol, reference with its unit, exponent.
    """
    exponents = {"X": [f"X{number}" for number in range(1, len(law.groups) + 1)]}
    for coefficient in law.coefficients:
        if coefficient.exponents is not None:
            exponents[coefficient.name] = [f"{exponent:g}" for exponent in coefficient.exponents]
    quantities = [QUANTITIES[group] for group in law.groups]
    references = [
        (quantity.symbol, f"{reference:g} {quantity.unit}".removesuffix(" 1"))
        for quantity, reference in zip(quantities, law.reference, strict=True)
    ]
    return {
        name: [
            (*base, power) for base, power in zip(references, powers, strict=True) if power != "0"
        ]
        for name, powers in exponents.items()
    }
