"""What every exported function says of itself, as lines of plain text."""

import textwrap
from collections.abc import Iterable

from oilfilm.outputs.exports.description import SLIP, SLIP_MEANING, Condition, Description
from oilfilm.outputs.exports.names import plain

# Fortran ends a line at 132 characters; an editor shows fewer.
_WIDTH = 92


def header(
    description: Description, sentences: Iterable[str], results: Iterable[str], mark: str
) -> str:
    """The head of a source file, as a comment whose every line begins with `mark`.

    Args:
        description: The fit.
        sentences: One per argument: name, meaning, unit, range tested.
        results: What the functions give back, and for which arguments they give nothing.
        mark: What makes a line a comment.
    """
    fit = description.quality
    lines = [
        *_lines(
            f"Traction coefficient mu (traction force over load) of the oil "
            f"{plain(description.oil)}"
        ),
        "",
        *_lines(origin(description)),
        *_lines(
            f"Fit: {fit['n_points']} points of {fit['n_curves']} runs, rms error of mu "
            f"{fit['rmse']:.2g}; {certificate(description)}"
        ),
        *_lines(f"Errors of the constants: traction_{description.identifier}.json and .csv"),
        "",
        *(line for text in law_in_words(description) for line in _lines(text)),
        "",
        "Arguments, and the box tested",
        *(line for text in sentences for line in _lines(text, indent="  ")),
        *(line for text in _fixed(description) for line in _lines(text)),
        "",
        *(line for text in results for line in _lines(text)),
    ]
    return "\n".join(f"{mark}{line}".rstrip() for line in lines)


def origin(description: Description) -> str:
    """Which campaign the constants come from, and whether its data are real."""
    kind = "SIMULATED DATA, not for design" if description.simulated else "Measured data"
    return f"{kind}. Campaign {plain(description.campaign)}: {plain(description.about)}"


def certificate(description: Description) -> str:
    """How many searches agree where the fit is certified, else why it is not."""
    fit = description.quality
    if fit["certified"]:
        return f"certified: {fit['searches_agreeing']} of {fit['searches']} searches agree"
    return plain(str(fit["certificate"]))


def law_in_words(description: Description) -> list[str]:
    """The law, its powers and its source."""
    given, law = description.arguments, description.law
    return [
        f"Law {law.name}: {law.formula} for S >= 0, and mu(-S) = -mu(S)",
        *([f"with {description.power_law(given)}"] if given else []),
        law.source,
    ]


def arguments(description: Description) -> list[str]:
    """One sentence per argument, in the units of the tables."""
    return [
        *(
            f"{condition.name}: {condition.symbol}, {condition.meaning}, {condition.unit}; "
            f"{span(condition.lower, condition.upper)}"
            for condition in description.arguments
        ),
        f"{SLIP}: {slip_in_words(description)}",
    ]


def slip_in_words(description: Description) -> str:
    """What S is, and how far it was tested."""
    return f"S, {SLIP_MEANING}, either sign; |S| {span(0.0, description.slip_upper)}"


def span(lower: float | None, upper: float | None) -> str:
    """A range in words."""
    return "unknown" if lower is None or upper is None else f"{lower:.4g} to {upper:.4g}"


def level(condition: Condition) -> str:
    """The one tested level of a condition."""
    return "unknown" if condition.level is None else f"{condition.level:.4g} {condition.unit}"


def _fixed(description: Description) -> list[str]:
    if not description.fixed:
        return []
    levels = "; ".join(f"{condition.meaning} {level(condition)}" for condition in description.fixed)
    return [f"Tested at one level only, at which alone mu is known: {levels}"]


def _lines(text: str, indent: str = "") -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent=indent, subsequent_indent=indent + "  ")
