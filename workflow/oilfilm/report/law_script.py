"""The traction laws as the page's script computes them, written from their equations."""

from collections.abc import Iterable

from oilfilm.traction.expression import Form, Language, in_steps
from oilfilm.traction.law import Law

_FUNCTIONS = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "asinh", "abs", "sign")
JAVASCRIPT = Language(
    {
        "**": Form("{} ** {}", 4, (5, 5)),
        **{function: Form(f"Math.{function}({{}})") for function in _FUNCTIONS},
    }
)


def law_script(laws: Iterable[Law]) -> str:
    """`LAWS`: name -> function of the coefficients' sizes |X| and S, S not negative.

    Each gives mu, and its derivatives by each ln|X|.
    """
    return f"const LAWS = {{\n{''.join(map(_law, laws))}}};\n"


def _law(law: Law) -> str:
    steps, (mu, *slopes) = in_steps(law.graphs)
    lines = "".join(f"    const {name} = {JAVASCRIPT.write(node)};\n" for name, node in steps)
    written = ", ".join(map(JAVASCRIPT.write, slopes))
    return (
        f'  "{law.name}": ([{", ".join(law.local_constants)}], S) => {{\n'
        f"{lines}    return {{ mu: {JAVASCRIPT.write(mu)}, slopes: [{written}] }};\n  }},\n"
    )
