"""What the exports of several languages share."""

import textwrap
from collections.abc import Mapping

from oilfilm.exports.description import SLIP, Description
from oilfilm.traction.expression import Language, functions_of

_WIDTH = 88  # leaves room for indentation within Fortran's 132 columns


def assignments(
    description: Description, language: Language, template: str, continued: str = "\n        "
) -> str:
    """The steps from the arguments to mu, one line each.

    Args:
        description: The fit.
        language: In which they are written.
        template: A line, with gaps for the name and for the value.
        continued: What joins the parts of a long value. Outside names and numbers the languages
            do not mind where a line breaks.
    """
    lines = (
        template.format(
            language.identifier(name),
            continued.join(textwrap.wrap(language.write(value), _WIDTH, break_on_hyphens=False)),
        )
        for name, value in description.steps
    )
    return "".join(lines)


def variables(description: Description, language: Language) -> list[str]:
    """Names of all steps, mu last."""
    return [language.identifier(name) for name, _ in description.steps]


def helpers(description: Description, texts: Mapping[str, str]) -> str:
    """Functions that the language lacks and the law needs.

    Args:
        description: The fit.
        texts: Function -> its definition; one that calls another comes before it.
    """
    needed = functions_of(value for _, value in description.steps)
    written = ""
    for function, text in texts.items():
        if function in needed or f"{function}(" in written:
            written += text
    return written


def box(
    description: Description,
    numeral: str = "{!r}",
    both: str = "&&",
    size: str = "fabs",
) -> list[str]:
    """The conditions of the tested box, one per argument.

    Args:
        description: The fit.
        numeral: How a number is written.
        both: The language's "and".
        size: The language's absolute value.
    """
    sides = [
        f"{condition.name} >= {numeral.format(condition.tested[0])} {both} "
        f"{condition.name} <= {numeral.format(condition.tested[1])}"
        for condition in description.arguments
    ]
    return [*sides, f"{size}({SLIP}) <= {numeral.format(description.slip.tested[1])}"]


def result(description: Description, without: str) -> str:
    """What is given back, and for which arguments nothing is: a sentence for the header.

    Args:
        description: The fit.
        without: What the function does where the law has no value, as "NaN".
    """
    if not description.arguments:
        return "mu, of the sign of S"
    return f"mu, of the sign of S; {without} unless {description.argument_meanings} are above 0"
